"""The system around the matcher: camera inputs, frame store in DDR2 memory, display output, set-up of the video chips; ``system`` is the
whole. Pins, PLLs and vendor code belong to a board. May import ``golden``, ``hdl.host``, ``hdl.matcher``, ``hdl.parts`` and ``hdl.rig``.
"""
