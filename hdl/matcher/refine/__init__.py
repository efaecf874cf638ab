"""Stages after the engine, on disparities that may have failed the left-right check: fills, medians and confidence, with their windows.
May import ``golden.config``, ``golden.matcher``, ``hdl.parts`` and ``hdl.matcher``, except ``hdl.matcher.sequential`` and
``hdl.matcher.streaming``.
"""
