"""Proofs, as data: what is claimed of which component, in which size, and for how many cycles. A module with ``PROOFS`` for each family.
May import ``golden``, ``hdl``, ``sim.kit`` and ``sim.verify.proofs``.
"""
