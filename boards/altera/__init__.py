"""What boards with an FPGA of Altera share: ``platform`` has settings for Quartus, ``pll`` the PLL, ``synchronizers`` and ``crossings``
what leads from clock to clock, ``check`` and ``sdc`` the checks of a project, ``bitec`` cards for an HSMC connector.
May import ``golden``, ``boards.registry`` and ``hdl``, except ``hdl.build``.
"""
