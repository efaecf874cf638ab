"""The soak: the Verilog of the whole system among its models, with disturbances drawn from a seed, as long as one likes.
May import ``golden``, ``hdl``, ``sim.kit``, ``sim.models`` and ``sim.benches``.
"""
