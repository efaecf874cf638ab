"""The reference: what every block must compute, and the programs around it. Array in, array out; no cycles, no Amaranth.

``config``, ``matcher``, ``rig``, ``video`` and ``host`` are what the gateware must equal; ``pictures`` and ``lab`` measure it on data.
May import ``golden``, NumPy and libraries for pictures and tables.
"""

from .errors import guard_start


guard_start()
