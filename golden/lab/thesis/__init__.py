"""Every figure and table of the thesis that can be measured on pictures, with ours next to them: docs/thesis.md and .html.

``command`` writes the pages; sections are in ``tables``, ``results``, ``weights`` and ``disturbances``; ``sweeps`` holds the jobs.
May import ``golden.lab``, ``golden.lab.rivals``, ``golden.pictures``, ``golden.matcher`` and ``golden.config``, never ``hdl``.
"""
