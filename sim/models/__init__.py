"""Strict models of the chips around the FPGA, for Amaranth's simulator and for cocotb: a protocol violation fails the test.

May import :mod:`golden`, and of :mod:`hdl` what a model shares with the gateware: payloads, buses, the register file.
"""
