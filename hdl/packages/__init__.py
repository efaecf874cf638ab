"""What other tools need beside the core's Verilog: packages for FuseSoC, Quartus, Vivado, LiteX, VHDL, and descriptions of its registers.
Texts only, made of a module's ports and of a register map; nothing here builds gateware.
May import ``golden.errors`` and ``golden.host``.
"""
