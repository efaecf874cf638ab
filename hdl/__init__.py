"""Gateware in Amaranth, with the commands that write it: ``build`` and ``emit`` make Verilog, ``options`` are those of the command lines,
``yosys`` starts Yosys, ``netlist`` reads its netlists, ``memory_blocks`` has the rule of memory blocks, ``fit`` compares a design with a
device; the components are in the rooms, and ``rectified`` joins two of them. Every component names its golden function.
May import ``golden``; ``hdl.build`` alone ``boards.registry``, to look a board up by name.
"""

from golden.errors import guard_start


guard_start()
