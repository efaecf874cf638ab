"""Resources of a design on a Cyclone III, and its clock rate on a stand-in. ``mapping`` maps a component by Yosys passes, ``count`` counts
the elements, ``estimate`` estimates them, ``devices`` has the capacities, ``clock`` and ``floorplan`` place and route for an ECP5,
``report`` and ``tables`` show the figures. May import ``golden`` and all of ``hdl`` except ``hdl.build``.
"""
