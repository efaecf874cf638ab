"""The method ``recursive``: costs that are carried from line to line, an array of cells, a label a cell, and the engine around it.

May import ``golden`` and ``hdl``.
"""
