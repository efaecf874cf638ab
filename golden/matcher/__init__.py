"""Golden model of the matcher: the costs of each method, the labelling of a scanline with its energy, the stages of the refinement;
``matcher`` runs a configuration's method on a pair of pictures. Exact integers, bit-exact with the gateware. May import ``golden.config``.
"""
