"""What boards with an FPGA of Altera share: ``bitec`` has cards for an HSMC connector. May import ``golden``, ``boards.registry`` and
``hdl``, except ``hdl.build``.
"""
