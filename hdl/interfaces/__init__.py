"""The core with the buses of other designs: AXI4-Stream with AXI4-Lite, Avalon-ST with Avalon-MM; ``cores`` has one component for each.
The registers behind them are those of ``hdl.host.register_file``.
May import ``golden``, ``hdl.host.register_file``, ``hdl.matcher`` and ``hdl.parts``.
"""
