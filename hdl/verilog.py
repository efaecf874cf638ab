"""Emitted Verilog read back: ports, instances, and where a clock comes from. For the text of :mod:`hdl.emit` only."""

import re
from dataclasses import dataclass, field


__all__ = ["Instance", "Module", "clock_sources", "modules"]


_MODULE = re.compile(r"(?ms)^module (\w+)\((.*?)\);\n(.*?)^endmodule")
_PORT = re.compile(r"(?m)^  (input|output|inout) (?:\[(\d+):0\] )?(\w+);$")
_ASSIGN = re.compile(r"(?m)^  assign (\w+) = ([^;]+);$")
_CLOCKED = re.compile(r"(?m)^  always @\((?:pos|neg)edge (\w+)")
# Parameters end at the line that begins with a parenthesis.
_INSTANCE = re.compile(r"(?ms)^  (\w+) (?:#\(\n.*?\n  \) )?(\w+) \(\n((?:    \..*?\n)+)  \);$")
_WIRE = re.compile(r"(?:\{ .*, )?([A-Za-z_]\w*)(?:\[\d+(?::\d+)?\])?(?: \})?")
_CONNECTION = re.compile(r"(?m)^    \.(\w+)\((.*)\),?$")

# Of Altera's blocks: outputs that repeat an input, outputs that are clocks, inputs that must be clocks.
_REPEATERS = {("altiobuf_in", "dataout"): "datain", ("altiobuf_bidir", "dataout"): "dataio"}
_GENERATED = {("altpll", "clk"), ("stereo_ddr2", "phy_clk")}
_CLOCKED_PORTS = {"altpll": ("inclk",), "stereo_ddr2": ("pll_ref_clk",), "altddio_out": ("outclock",), "altddio_in": ("inclock",),
                  "altera_std_synchronizer": ("clk",), "altera_std_synchronizer_bundle": ("clk",)}


@dataclass(frozen=True)
class Instance:
    """``connections``: port to the expression that it is connected to."""
    kind: str
    name: str
    connections: dict[str, str]


@dataclass
class Module:
    """``ports``: name to (direction, width in bits). ``assigns``: wire to the expression that it is."""
    ports: dict[str, tuple[str, int]]
    instances: list[Instance]
    assigns: dict[str, str]
    clocked: list[str]                 # nets that clock an ``always`` block
    drivers: dict[str, tuple[Instance, str]] = field(default_factory=dict)     # net to the instance and its port that may drive it


def modules(text: str) -> dict[str, Module]:
    """The modules of emitted Verilog by name."""
    found = {}
    for name, _, body in _MODULE.findall(text):
        ports = {port: (direction, int(high or 0) + 1) for direction, high, port in _PORT.findall(body)}
        instances = [Instance(kind, instance, dict(_CONNECTION.findall(connections)))
                     for kind, instance, connections in _INSTANCE.findall(body) if kind != "module"]
        found[name] = Module(ports, instances, dict(_ASSIGN.findall(body)), _CLOCKED.findall(body))
    for module in found.values():
        for instance in module.instances:
            for port, net in instance.connections.items():
                if instance.kind in found:
                    drives = found[instance.kind].ports[port][0] == "output"
                else:
                    drives = (instance.kind, port) in _REPEATERS or (instance.kind, port) in _GENERATED
                if drives:
                    module.drivers[_net(net)] = instance, port
    return found


def _net(expression: str) -> str:
    """The net that an expression is, whatever its bit; the lowest of a concatenation; nothing if it is logic or a constant."""
    found = _WIRE.fullmatch(expression)
    return found[1] if found else ""


def clock_sources(found: dict[str, Module], top: str) -> set[str]:
    """Where the clocks of a design come from.

    Returns
    -------
    set of str
        Ports of ``top``; ``altpll.clk`` and ``stereo_ddr2.phy_clk`` for those that Altera's blocks make; ``? path.net`` for what could
        not be traced to either.
    """
    sources: set[str] = set()

    def trace(path: tuple[tuple[str, str], ...], net: str) -> str:
        """Follow ``net`` of the module at the end of ``path``, a chain of (module, instance in it), to its source."""
        seen = []
        while net and (path, net) not in seen:
            seen.append((path, net))
            module = found[path[-1][0]]
            if net in module.drivers:
                instance, port = module.drivers[net]
                if instance.kind in found:
                    path, net = (*path, (instance.kind, instance.name)), port
                elif (instance.kind, port) in _GENERATED:
                    return f"{instance.kind}.{port}"
                else:
                    net = _net(instance.connections[_REPEATERS[instance.kind, port]])
            elif module.ports.get(net, ("", 0))[0] in ("input", "inout"):
                if len(path) == 1:
                    return net
                instance = next(child for child in found[path[-2][0]].instances if child.name == path[-1][1])
                path, net = path[:-1], _net(instance.connections[net])
            else:
                net = _net(module.assigns.get(net, ""))
        path, net = seen[-1] if seen else (path, "constant")
        return "? " + ".".join([*(name for _, name in path[1:]), net])

    def visit(path):
        module = found[path[-1][0]]
        nets = list(module.clocked)
        for instance in module.instances:
            if instance.kind in found:
                visit((*path, (instance.kind, instance.name)))
            nets += [_net(instance.connections[port]) for port in _CLOCKED_PORTS.get(instance.kind, ())]
        sources.update(trace(path, net) for net in dict.fromkeys(nets))

    visit(((top, top),))
    return sources
