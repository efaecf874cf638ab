"""Benches on the emitted Verilog: ``test_*`` build a design for Icarus and Verilator, ``*_tb`` are the cocotb halves that run inside of the
simulator, the other files are what both need, such as designs and sizes. No test imports another.
May import ``golden``, ``hdl``, ``boards``, ``sim.kit`` and ``sim.models``.
"""
