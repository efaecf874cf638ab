"""An estimate of what :mod:`hdl.resources.mapping` would count, in seconds: from the netlist that is emitted with the Verilog.

``flat`` joins the modules, ``graph`` holds the logic without what is constant, unused or there twice, ``resolve`` enters the design into
it and ``cells`` Yosys's cells, ``cover`` covers the logic with tables, ``total`` adds up.
May import ``hdl.memory_blocks``, ``hdl.resources`` and ``hdl.netlist``.
"""

from .total import LOGIC_ERROR, SOFT_PRODUCT, Elements, elements, estimate


__all__ = ["LOGIC_ERROR", "SOFT_PRODUCT", "Elements", "elements", "estimate"]
