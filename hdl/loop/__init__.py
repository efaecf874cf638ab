"""The matcher behind a serial line, without cameras: the host sends a pair, and reads disparities; ``system`` is the whole. Pins and clocks
belong to a board. May import ``golden``, ``hdl.host``, ``hdl.matcher`` and ``hdl.parts``.
"""
