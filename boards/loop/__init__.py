"""The system that matches pairs of a serial line on boards without cameras, whatever FPGA they have: its design and its top level.
May import ``golden`` and ``hdl``, except ``hdl.build``.
"""
