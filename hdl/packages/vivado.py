"""A core in Vivado: its description in IP-XACT, IEEE 1685-2009."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from typing import Any

from golden.host.registers import Kind, Register

from .core import Bus, Core, Protocol, RegisterSpace


__all__ = ["NAMESPACE", "VENDOR", "vivado_files"]


#: Of IEEE 1685-2009, and of what Vivado adds.
NAMESPACE = "http://www.spiritconsortium.org/XMLSchema/SPIRIT/1685-2009"
_XILINX = "http://www.xilinx.com"

#: Names of the core in a catalogue: vendor and library.
VENDOR = "stereo"
_LIBRARY = "graph_cut"

#: Vivado's names of the protocols that it knows: library entry, and that of its signals.
_TYPES = {Protocol.AXI_STREAM: "axis", Protocol.AXI_LITE: "aximm"}

#: Families for which Vivado offers the core: the Verilog uses no primitive of any.
_FAMILIES = ("artix7", "kintex7", "virtex7", "spartan7", "zynq", "kintexu", "virtexu", "kintexuplus", "virtexuplus", "zynquplus")

#: Views of the design: name, what Vivado knows them as, and the set of files.
_VIEWS = (("xilinx_anylanguagesynthesis", "synthesis"), ("xilinx_anylanguagebehavioralsimulation", "simulation"))

# Text, or elements below by name; of several with the same name a list.
_Tree = Mapping[str, Any]


def _add(parent: ET.Element, tree: _Tree) -> ET.Element:
    for name, value in tree.items():
        for each in value if isinstance(value, list) else [value]:
            child = ET.SubElement(parent, f"{{{NAMESPACE}}}{name}")
            if isinstance(each, Mapping):
                for key, attribute in each.get("@", {}).items():
                    child.set(f"{{{NAMESPACE}}}{key}", attribute)
                if "#" in each:
                    child.text = str(each["#"])
                _add(child, {key: below for key, below in each.items() if key not in ("@", "#")})
            else:
                child.text = str(each)
    return parent


def _type(library: str, name: str) -> dict[str, _Tree]:
    def reference(name: str) -> _Tree:
        return {"@": {"vendor": "xilinx.com", "library": library, "name": name, "version": "1.0"}}

    return {"busType": reference(name), "abstractionType": reference(f"{name}_rtl")}


def _port_maps(ports: Iterable[tuple[str, str]]) -> _Tree:
    return {"portMap": [{"logicalPort": {"name": logical}, "physicalPort": {"name": physical}} for logical, physical in ports]}


def _parameters(interface: str, values: Mapping[str, str]) -> _Tree:
    return {"parameter": [{"name": name, "value": {"@": {"id": f"BUSIFPARAM_VALUE.{interface.upper()}.{name}"}, "#": value}}
                          for name, value in values.items()]}


def _bus_interface(bus: Bus) -> _Tree:
    role: _Tree = {} if bus.protocol.streams else {"memoryMapRef": {"@": {"memoryMapRef": bus.name}}}
    return {"name": bus.name, **_type("interface", _TYPES[bus.protocol]), "master" if bus.drives else "slave": role,
            "portMaps": _port_maps((signal.upper(), port) for signal, port in bus.ports.items())}


def _register(register: Register, space: RegisterSpace) -> _Tree:
    writable = register.writable
    description = f"{register.description}; {register.limits} {register.unit}".rstrip()
    return {
        "name": register.name, "description": description, "addressOffset": f"0x{register.address * space.word_bytes:X}",
        "size": space.word_bits, "volatile": str(register.kind in (Kind.STATUS, Kind.COUNTER)).lower(),
        "access": "read-write" if writable else "read-only",
        "reset": {"value": f"0x{register.reset % (1 << space.word_bits):X}"},
    }


def _memory_map(name: str, space: RegisterSpace) -> _Tree:
    block = {"name": "registers", "baseAddress": "0x0", "range": space.span, "width": space.word_bits, "usage": "register",
             "register": [_register(register, space) for register in space.registers]}
    return {"memoryMap": {"name": name, "addressBlock": block}}


def _port(name: str, direction: str, width: int) -> _Tree:
    vector = {"vector": {"left": width - 1, "right": 0}} if width > 1 else {}
    typed = {"wireTypeDef": {"typeName": "wire", "viewNameRef": [view for view, _ in _VIEWS]}}
    return {"name": name, "wire": {"direction": direction.removesuffix("put"), **vector, "wireTypeDefs": typed}}


def vivado_files(core: Core) -> dict[str, str]:
    """``component.xml``: the core for Vivado's catalogue; the folder is a repository of IP.

    AXI4-Stream and AXI4-Lite are buses with the registers as the memory map of the latter, clock and reset are interfaces. A stream of
    this project, and Avalon, are plain ports.
    """
    buses = [bus for bus in core.buses if bus.protocol in _TYPES]
    reset = core.reset
    of_clock = {"ASSOCIATED_RESET": reset.port} | ({"ASSOCIATED_BUSIF": ":".join(bus.name for bus in buses)} if buses else {})
    interfaces: list[_Tree] = [_bus_interface(bus) for bus in buses]
    for name, port, kind, values in ((core.clock, core.clock, "clock", of_clock),
                                     (reset.port, reset.port, "reset", {"POLARITY": f"ACTIVE_{'LOW' if reset.active_low else 'HIGH'}"})):
        interfaces.append({"name": name, **_type("signal", kind), "slave": {},
                           "portMaps": _port_maps([("CLK" if kind == "clock" else "RST", port)]), "parameters": _parameters(name, values)})
    memory = next((bus.name for bus in buses if not bus.protocol.streams), None)
    files = [{"name": name, "fileType": "verilogSource"} for name in core.verilog]
    tree: dict[str, Any] = {
        "vendor": VENDOR, "library": _LIBRARY, "name": core.name, "version": ".".join(core.version.split(".")[:2]),
        "busInterfaces": {"busInterface": interfaces},
        **({"memoryMaps": _memory_map(memory, core.space)} if memory and core.space else {}),
        "model": {
            "views": {"view": [
                {"name": view, "envIdentifier": f":vivado.xilinx.com:{use}", "language": "verilog", "modelName": core.name,
                 "fileSetRef": {"localName": f"{view}_files"}} for view, use in _VIEWS]},
            "ports": {"port": [_port(name, direction, width) for name, (direction, width) in core.ports.items()]},
        },
        "fileSets": {"fileSet": [{"name": f"{view}_files", "file": files} for view, _ in _VIEWS]},
        "description": core.description,
        "parameters": {"parameter": {"name": "Component_Name", "value": {
            "@": {"resolve": "user", "id": "PARAM_VALUE.Component_Name"}, "#": f"{core.name}_0"}}},
        "vendorExtensions": {},
    }
    ET.register_namespace("spirit", NAMESPACE)
    ET.register_namespace("xilinx", _XILINX)
    root = _add(ET.Element(f"{{{NAMESPACE}}}component"), tree)
    extensions = ET.SubElement(root[-1], f"{{{_XILINX}}}coreExtensions")
    families = ET.SubElement(extensions, f"{{{_XILINX}}}supportedFamilies")
    for family in _FAMILIES:
        ET.SubElement(families, f"{{{_XILINX}}}family", {f"{{{_XILINX}}}lifeCycle": "Production"}).text = family
    taxonomies = ET.SubElement(extensions, f"{{{_XILINX}}}taxonomies")
    ET.SubElement(taxonomies, f"{{{_XILINX}}}taxonomy").text = "/Video_&_Image_Processing"
    ET.SubElement(extensions, f"{{{_XILINX}}}displayName").text = core.name
    ET.SubElement(extensions, f"{{{_XILINX}}}coreRevision").text = "1"
    ET.indent(root)
    return {"component.xml": '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"}
