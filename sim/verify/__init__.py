"""Verification by campaigns: hundreds of cases each, seeded, resumable, in parallel; ``python -m sim.verify PART``. Each part is a module
and writes its figures into ``docs/verification/``, from which ``report`` makes ``docs/verification.md``.
May import ``golden``, ``hdl``, ``boards``, ``sim.kit``, ``sim.models`` and ``sim.benches``.
"""
