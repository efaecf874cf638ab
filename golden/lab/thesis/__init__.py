"""Every figure and table of the thesis that can be measured on pictures, with ours next to them: docs/thesis.md and .html.

``command`` writes the pages; sections are in ``tables``, ``results``, ``weights`` and ``disturbances``; ``sweeps`` holds the jobs, and
``disturb`` and ``cures`` change pairs for them. May import ``golden.lab``, ``golden.lab.rivals``, ``golden.pictures``, ``golden.rig``,
``golden.matcher`` and ``golden.config``, never ``hdl``.
"""
