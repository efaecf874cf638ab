"""Whole matchers of drawn configurations: how they are drawn, what wins in their pictures, their run, and the smallest one that fails.
May import ``golden``, ``hdl`` and ``sim.kit``.
"""

from .case import Case, CaseFrame, literal
from .check import emitted, failure
from .drawing import ICARUS, draw
from .shrink import smallest
from .trees import unreachable, winners


__all__ = ["Case", "CaseFrame", "ICARUS", "draw", "emitted", "failure", "literal", "smallest", "unreachable", "winners"]
