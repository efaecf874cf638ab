"""Parts for any gateware: registers, delays and FIFOs as streams, crossings, arithmetic, counters, sorting networks, a UART. None knows of
pictures, matching or a board. May import ``golden.host.protocol``, for the baud rate.
"""
