"""What boards with an FPGA of Altera share: ``pins`` reads a board's table of pins, ``platform`` has settings and files for Quartus,
``pll`` is the PLL; ``synchronizers`` and ``crossings`` lead from clock to clock, ``check`` and ``sdc`` check a project, ``bitec`` has cards
for an HSMC connector. May import ``golden``, ``boards.registry`` and ``hdl``, except ``hdl.build``.
"""
