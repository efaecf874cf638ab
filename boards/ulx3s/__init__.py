"""ULX3S with an LFE5U-85F: a pair of pictures over USB, matched, back over USB and to a monitor.
May import ``boards.ecp5``, ``boards.loop`` and ``golden``.
"""
