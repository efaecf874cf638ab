"""Altera's Cyclone III development board with two cards of Bitec: ``board`` is its entry in the registry, ``platform`` its pins, ``top``
its top level, ``project`` its files for Quartus, ``check`` their checks. May import ``golden``, ``boards.registry``, ``boards.altera`` and
``hdl``, except ``hdl.build``.
"""
