"""Terasic's DE2-115: a pair of pictures over a serial line, matched, back over the line and to a VGA monitor. ``board`` is its entry in the
registry, ``platform`` its pins, ``top`` its top level, ``project`` its files for Quartus.
May import ``boards.altera``, ``boards.loop``, ``golden`` and ``hdl``, except ``hdl.build``.
"""
