"""The host's view of the system as data: register map, wire protocol, and the page that describes both; no gateware.
May import ``golden.config``, ``golden.rig`` and ``golden.video``.
"""
