"""Mutants of the project's Python sources, and the tests that each must fail: one small change a mutant, spliced into the text.
``plugin`` runs within pytest, in the mutant's own copy of the project, and imports nothing of the project.
May import ``golden`` and ``sim.verify.campaign``, ``sim.verify.journal``.
"""
