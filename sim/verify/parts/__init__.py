"""Parts of the verification, a module each with its ``PART``: a new one is a new file.
May import ``golden``, ``hdl``, ``boards``, ``sim.kit``, ``sim.models``, ``sim.benches`` and ``sim.verify``, but not
``sim.verify.report``.
"""
