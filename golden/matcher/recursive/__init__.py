"""The method :class:`golden.config.Recursive`, a module a step: costs are carried from line to line, and joined before they are summed.

May import ``golden.config`` and ``golden.matcher``.
"""
