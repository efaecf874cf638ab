"""Strict models of the chips around the FPGA, for Amaranth's simulator and for cocotb: a violation of a protocol fails the test. And a
stand-in for the video system on a board. May import ``golden``, ``hdl`` and ``boards``.
"""
