"""Command lines with hostile arguments and files: what is given to them, the processes they run in, and what they must not do.
May import ``golden``, ``hdl``, ``boards``, ``sim.kit``, ``sim.models`` and ``sim.verify``, but not ``sim.verify.parts``.
"""
