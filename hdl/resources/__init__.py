"""What a design costs: logic elements, memory and multipliers of a Cyclone III, clock rate on a stand-in. See ``python -m hdl.resources``.

``mapping`` maps a component by Yosys passes, ``count`` counts what came out, ``clock`` places and routes, ``report`` shows it.
"""
