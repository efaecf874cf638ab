"""Boards, a folder each: pins, clocks, project files and their checks, and nothing of a vendor elsewhere; ``registry`` finds them.

May import ``golden`` and ``hdl``. Of a folder ``boards/NAME`` anywhere on Python's path a board can be built too.
"""

from pkgutil import extend_path


__path__ = extend_path(__path__, __name__)
