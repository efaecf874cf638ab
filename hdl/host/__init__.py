"""Access for a host: registers behind a serial line, and the console that talks to them; the register map itself is in ``golden.host``.
May import ``golden`` and ``hdl.parts``.
"""
