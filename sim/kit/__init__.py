"""Kit of the benches: cases and their expected results, drivers and monitors of streams for Amaranth's simulator and for cocotb, the
harness for whole pictures, builds of Icarus and Verilator and the store that keeps them, proofs.
May import ``golden`` and ``hdl``, except ``hdl.build``.
"""
