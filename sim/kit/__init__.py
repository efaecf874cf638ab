"""Kit of the benches: cases and their expected results, drivers and monitors of streams for Amaranth's simulator and for cocotb, the
harness for whole pictures, builds of Icarus and Verilator and the store that keeps them, proofs.
May import ``golden``, ``hdl`` and the memory of a simulated board, ``sim.models.sdram`` and ``sim.models.cocotb_sdram``, but not
``hdl.build``.
"""
