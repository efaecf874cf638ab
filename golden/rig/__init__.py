"""Golden models of the stages between two mounted cameras and the matcher: maps, rectification, balance of brightness, and files of them.

Exact integers, bit-exact with the gateware; a stage is given plainly, pixel by pixel, and fast. May import ``golden.config``.
"""
