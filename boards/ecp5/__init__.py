"""What boards with a Lattice ECP5 share: PLLs, top level, constraints, and the way to a bitstream with tools from PyPI. A board's folder
says which pins there are, in a subclass of its platform in amaranth-boards. May import ``golden``, ``boards.loop`` and ``hdl``, except
``hdl.build``.
"""
