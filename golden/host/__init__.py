"""The host's view of the system as data: register map, wire protocol, and the page that describes both; no gateware.
``loop_device`` is the model of a board that the host sends pairs to.
May import ``golden.config``, ``golden.matcher``, ``golden.rig`` and ``golden.video``.
"""
