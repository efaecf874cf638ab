"""A core in LiteX: a Python module with its Verilog as an instance."""

import re
import textwrap
from collections.abc import Iterator

from .core import Bus, Core, Protocol


__all__ = ["litex_files"]


# Of an address on LiteX's main bus, whatever a slave decodes of it.
_ADDRESS_BITS = 32

# Fields of LiteX's streams that every endpoint has.
_FLAGS = ("first", "last")


def _joined(core: Core, bus: Bus) -> str:
    """A payload of LiteX's signals, from its lowest bit on."""
    fields = core.payloads.get(bus.ports["payload"])
    if not fields:
        return f"self.{bus.name}.payload"
    return f"Cat({', '.join(f'self.{bus.name}.{field}' for field in fields)})"


def _bus(core: Core, bus: Bus) -> tuple[str, dict[str, str]]:
    """The attribute's expression, and the signal of each port."""
    widths = {signal: core.ports[port][1] for signal, port in bus.ports.items()}
    match bus.protocol:
        case Protocol.AXI_STREAM:
            keywords = f"data_width={widths['tdata']}" + (f", user_width={widths['tuser']}" if "tuser" in widths else "")
            return f"AXIStreamInterface({keywords})", {signal: f"self.{bus.name}.{signal[1:]}" for signal in bus.ports}
        case Protocol.AXI_LITE:
            channels = {signal: next(c for c in ("aw", "ar", "w", "b", "r") if signal.startswith(c)) for signal in bus.ports}
            signals = {signal: f"self.{bus.name}.{channel}.{signal.removeprefix(channel)}" for signal, channel in channels.items()}
            signals |= {signal: f"{signals[signal]}[:{widths[signal]}]" for signal in ("awaddr", "araddr")}
            return f"AXILiteInterface(data_width={widths['wdata']}, address_width={_ADDRESS_BITS})", signals
        case Protocol.NATIVE:
            fields = core.payloads.get(bus.ports["payload"]) or {"payload": (0, widths["payload"] - 1)}
            layout = [(field, high - low + 1) for field, (low, high) in fields.items() if field not in _FLAGS]
            return (f"stream.Endpoint({layout})",
                    {"payload": _joined(core, bus), "valid": f"self.{bus.name}.valid", "ready": f"self.{bus.name}.ready"})
    # LiteX has Avalon-MM, too, but without responses, and of Avalon-ST only converters.
    layout = [(signal, width) for signal, width in widths.items()]
    return f"Record({layout})", {signal: f"self.{bus.name}.{signal}" for signal in bus.ports}


def _attributes(core: Core) -> Iterator[tuple[str, str]]:
    """Attribute and its expression, of buses and of other ports."""
    for bus in core.buses:
        yield bus.name, _bus(core, bus)[0]
    for name, (_, width) in core.others.items():
        yield name, f"Signal({width if width > 1 else ''})"


def _connections(core: Core) -> Iterator[tuple[str, str]]:
    """Port and the signal that is connected, in the order of the module's ports."""
    reset = core.reset
    signals = {core.clock: "ClockSignal()", reset.port: f"{'~' if reset.active_low else ''}ResetSignal()"}
    for bus in core.buses:
        signals |= {bus.ports[signal]: expression for signal, expression in _bus(core, bus)[1].items()}
    signals |= {name: f"self.{name}" for name in core.others}
    for name, (direction, _) in core.ports.items():
        yield f"{direction[0]}_{name}", signals[name]


# Where the names that the module uses are imported from.
_IMPORTS = {
    "litex.gen": ("LiteXModule",),
    "litex.soc.interconnect": ("stream",),
    "litex.soc.interconnect.axi": ("AXILiteInterface", "AXIStreamInterface"),
    "migen": ("Cat", "ClockSignal", "Instance", "Record", "ResetSignal", "Signal"),
}


def litex_files(core: Core) -> dict[str, str]:
    """``NAME_litex.py``: a class for LiteX that instantiates the core in the clock domain ``sys``; ``left_eye`` is the class ``LeftEye``.

    Streams of this project are LiteX's, of the same fields, AXI is LiteX's AXI; Avalon is a record of its signals. Other ports are signals.
    """
    kind = "".join(part.capitalize() for part in core.name.split("_"))
    attributes = dict(_attributes(core))
    lines = [
        f"class {kind}(LiteXModule):",
        '    """The core in the clock domain ``sys``; ``platform``, if it is given, gets its Verilog.',
        "",
        "    Attributes",
        "    ----------",
        *textwrap.wrap(", ".join(attributes), 130, initial_indent="    ", subsequent_indent="    "),
        '    """',
        "    def __init__(self, platform=None):",
        *(f"        self.{name} = {expression}" for name, expression in attributes.items()),
        "        self.specials += Instance(",
        f'            "{core.name}",',
        *(f"            {port}={expression}," for port, expression in _connections(core)),
        "        )",
        "        if platform is not None:",
        *(f'            platform.add_source(str(Path(__file__).resolve().with_name("{name}")))' for name in core.verilog),
    ]
    used = {*re.findall(r"\w+", "\n".join(lines))}
    imports = [f"from {module} import {', '.join(name for name in names if name in used)}"
               for module, names in _IMPORTS.items() if used & {*names}]
    head = [
        f'"""{core.description}, in LiteX.',
        "",
        f"An instance of the module {core.name} in {', '.join(core.verilog)}, which lies beside this file.",
        '"""',
        "", "from pathlib import Path", "", *imports, "", "", f'__all__ = ["{kind}"]', "", "",
    ]
    return {f"{core.name}_litex.py": "\n".join(head + lines) + "\n"}
