"""Benches on the emitted Verilog, the kit they are made of, and the main job: ``python -m sim.run``."""
