"""The engine with one pixel a clock: an array of costs per method, with several pixels in flight, and the selection of labels that they
share, in ``engine``. May import ``golden.config``, ``golden.matcher``, ``hdl.parts`` and ``hdl.matcher``, except
``hdl.matcher.sequential`` and ``hdl.matcher.refine``.
"""
