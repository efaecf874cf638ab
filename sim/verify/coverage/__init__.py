"""Coverage of the emitted Verilog: designs and what drives them, the points that Verilator counts, holes and their explanations.
May import ``golden``, ``hdl``, ``boards``, ``sim.kit``, ``sim.models``, ``sim.benches`` and ``sim.system``.
"""
