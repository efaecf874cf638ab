"""Strict models of the chips around the FPGA: each checks its protocol and fails the test on a violation."""
