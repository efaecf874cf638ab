"""A third method as somebody else would write it: three files, and a row that ``test_methods.py`` adds.

The cost of a label is the absolute difference of two pixels; the rule labels it as it is.
"""
