"""Stages between the cameras' pictures and the matcher, on the stream of pixel pairs: rectification by a map, balance of brightness.

May import ``golden.config``, ``golden.rig``, ``hdl.matcher.stream`` and ``hdl.parts``.
"""
