"""Boards, a folder each, with all that is a vendor's: pins, clocks, top level, project files and their checks. ``registry`` finds a board
by the name of its folder, also in a folder ``boards`` elsewhere on Python's path. May import ``golden`` and ``hdl``, except ``hdl.build``.
"""

from pkgutil import extend_path


__path__ = extend_path(__path__, __name__)
