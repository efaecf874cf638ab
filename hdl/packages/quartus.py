"""A core in Platform Designer, Qsys in older versions of Quartus: its description in Tcl."""

from collections.abc import Iterator

from .core import Bus, Core, Port, Protocol


__all__ = ["quartus_files"]


#: What Platform Designer calls the protocols, and the ends of an interface by whether the core drives it.
_TYPES = {
    Protocol.AXI_STREAM: ("axi4stream", ("end", "start")), Protocol.AXI_LITE: ("axi4lite", ("end", "start")),
    Protocol.AVALON_STREAM: ("avalon_streaming", ("end", "start")), Protocol.NATIVE: ("avalon_streaming", ("end", "start")),
    Protocol.AVALON_MEMORY: ("avalon", ("end", "start"))}

#: Version of Platform Designer that is required with AXI, and without: 13.1, the last one with the Cyclone III, knows no AXI4-Lite.
_VERSION = {True: "18.1", False: "13.1"}

#: Signals of Avalon-MM that are left out: what goes with them differs between versions of Quartus, and a host may do without.
_LEFT_OUT = ("response", "writeresponsevalid")


def _tcl(text: str) -> str:
    """A word of Tcl."""
    return "{" + text + "}"


def _properties(bus: Bus, ports: dict[str, Port]) -> Iterator[tuple[str, object]]:
    """Properties of a bus's interface besides clock and reset."""
    match bus.protocol:
        case Protocol.AVALON_STREAM | Protocol.NATIVE:
            data = bus.ports["data" if bus.protocol is Protocol.AVALON_STREAM else "payload"]
            yield "dataBitsPerSymbol", ports[data][1]
            yield "symbolsPerBeat", 1
            yield "readyLatency", 0
        case Protocol.AVALON_MEMORY:
            yield "addressUnits", "WORDS"
            yield "bitsPerSymbol", 8
            yield "readLatency", 0
            yield "readWaitTime", 0
            yield "writeWaitTime", 0
            yield "maximumPendingReadTransactions", 1 if "readdatavalid" in bus.ports else 0


def _interface(core: Core, bus: Bus) -> Iterator[str]:
    kind, ends = _TYPES[bus.protocol]
    yield ""
    yield f"add_interface {bus.name} {kind} {ends[bus.drives]}"
    yield f"set_interface_property {bus.name} associatedClock clock"
    yield f"set_interface_property {bus.name} associatedReset reset"
    for name, value in _properties(bus, dict(core.ports)):
        yield f"set_interface_property {bus.name} {name} {value}"
    for signal, port in bus.ports.items():
        if bus.protocol is Protocol.AVALON_MEMORY and signal in _LEFT_OUT:
            yield f"# {port} is left open: roles of responses differ between versions of Quartus."
            continue
        role = "data" if (bus.protocol, signal) == (Protocol.NATIVE, "payload") else signal
        direction, width = core.ports[port]
        yield f"add_interface_port {bus.name} {port} {role} {direction.capitalize()} {width}"


def quartus_files(core: Core) -> dict[str, str]:
    """``NAME_hw.tcl``: the component for Platform Designer.

    Buses are interfaces of their protocols; a stream of this project is an Avalon-ST whose symbol is the whole payload. All other ports
    are conduits, an interface each. The responses of Avalon-MM are left open.
    """
    reset = core.reset
    axi = any(bus.protocol in (Protocol.AXI_STREAM, Protocol.AXI_LITE) for bus in core.buses)
    lines = [
        f"# {core.description}.",
        "# For Platform Designer (Qsys), which finds this file in the folders that it searches for components.",
        "",
        f"package require -exact qsys {_VERSION[axi]}",
        "",
        f"set_module_property NAME {core.name}",
        f"set_module_property VERSION {core.version}",
        f"set_module_property DISPLAY_NAME {_tcl(core.name)}",
        f"set_module_property DESCRIPTION {_tcl(core.description)}",
        "set_module_property GROUP {Stereo}",
        "set_module_property INSTANTIATE_IN_SYSTEM_MODULE true",
        "set_module_property EDITABLE false",
    ]
    for fileset in ("QUARTUS_SYNTH", "SIM_VERILOG", "SIM_VHDL"):
        lines += ["", f'add_fileset {fileset} {fileset} "" ""', f"set_fileset_property {fileset} TOP_LEVEL {core.name}"]
        lines += [f"add_fileset_file {name} VERILOG PATH {name}{' TOP_LEVEL_FILE' if name == f'{core.name}.v' else ''}"
                  for name in core.verilog]
    lines += [
        "",
        "add_interface clock clock end",
        "set_interface_property clock clockRate 0",
        f"add_interface_port clock {core.clock} clk Input 1",
        "",
        "add_interface reset reset end",
        "set_interface_property reset associatedClock clock",
        f"set_interface_property reset synchronousEdges {'NONE' if reset.port == 'reset_n' else 'BOTH'}",
        f"add_interface_port reset {reset.port} {'reset_n' if reset.active_low else 'reset'} Input 1",
    ]
    for bus in core.buses:
        lines += _interface(core, bus)
    for name, (direction, width) in core.others.items():
        lines += [
            "",
            f"add_interface {name} conduit end",
            f"set_interface_property {name} associatedClock clock",
            f"add_interface_port {name} {name} export {direction.capitalize()} {width}",
        ]
    return {f"{core.name}_hw.tcl": "\n".join(lines) + "\n"}
