"""The engine of the thesis: several clocks a pixel, few operators, either arithmetic; ``bec`` computes costs, ``engine`` labels pixels.
May import ``golden.config``, ``golden.matcher``, ``hdl.parts`` and ``hdl.matcher``, except ``hdl.matcher.streaming`` and
``hdl.matcher.refine``.
"""
