"""The count of Cyclone III resources, on circuits that can be counted by hand, and the command line around it."""

import itertools
import json
import operator
import random

import pytest
from amaranth import *
from amaranth.hdl import Mux
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.netlist import Cell, Netlist
from hdl.parts.queue import AsyncQueue
from hdl.resources import __main__ as command
from hdl.resources.clock import Clock
from hdl.resources.count import FIGURES, Count, Resources, count
from hdl.resources.devices import DEFAULT_DEVICE, DEVICES
from hdl.resources.mapping import Mapped, map_cyclone3
from hdl.resources.report import as_json, counting, system_table, table, tree
from tests.kit import Circuit


DEVICE = DEVICES[DEFAULT_DEVICE]


def registered(function):
    """A circuit whose output ``y`` is a register of ``function``."""
    def build(circuit, m):
        m.d.sync += circuit.y.eq(function(circuit))
    return build


def counted(build, **ports):
    return count(map_cyclone3(Circuit(build, **ports), "top"))


def evaluate(mapped, **inputs):
    """Outputs of a mapped design without registers: elements are evaluated until none is left."""
    netlist = mapped.module
    known = {"0": 0, "1": 1, "x": 0}
    for name, value in inputs.items():
        known |= {bit: value >> place & 1 for place, bit in enumerate(netlist.ports[name].bits)}
    waiting = [cell for cell in netlist.cells.values() if cell.kind != "$scopeinfo"]
    while waiting:
        left = []
        for cell in waiting:
            pins = {port: bits[0] for port, bits in cell.connections.items()}
            if any(pins[port] not in known for port, way in cell.directions.items() if way == "input"):
                left.append(cell)
                continue
            a, b, c = (known[pins[port]] for port in ("A", "B", "CI" if cell.kind == "C3_ADD" else "C"))
            if cell.kind == "C3_ADD":
                total = a + (b ^ int(cell.parameters["INVERT"], 2)) + c
                known |= {pins[port]: value for port, value in (("S", total & 1), ("CO", total >> 1)) if port in pins}
            else:
                known[pins["O"]] = int(cell.parameters["LUT"], 2) >> (a + 2 * b + 4 * c + 8 * known[pins["D"]]) & 1
        assert len(left) < len(waiting)
        waiting = left
    return {name: sum(known[bit] << place for place, bit in enumerate(port.bits))
            for name, port in netlist.ports.items() if port.direction == "output"}


# --- Logic elements ---

def test_counter():
    # A bit is one element: sum and register.
    assert counted(lambda c, m: m.d.sync.__iadd__(c.y.eq(c.y + 1)), y=Out(16)).total == Resources(logic_elements=16)


@pytest.mark.parametrize("compare", [operator.lt, operator.le, operator.gt, operator.ge], ids=lambda compare: compare.__name__)
@pytest.mark.parametrize("signed", [False, True], ids=["unsigned", "signed"])
def test_comparator(compare, signed):
    # A bit is one element; the last takes the carry as an input, and the register.
    shape = Shape(8, signed)
    result = counted(registered(lambda c: compare(c.a, c.b)), a=In(shape), b=In(shape), y=Out(1))
    assert result.total == Resources(logic_elements=8)
    assert result.kinds == {"tables": 1, "carry_elements": 7, "registers": 1, "packed_registers": 1, "registers_in_blocks": 0}


@pytest.mark.parametrize("function, width, elements", [
    (lambda a, b: a + b, 9, 9),              # the ninth is the carry output
    (lambda a, b: a - b, 8, 8),              # the inverted operand costs nothing
    (lambda a, b: a + ~b, 8, 8),
    (lambda a, b: ~(a + b), 8, 8),           # nor does an inverted sum
    (lambda a, b: -a, 8, 8),
    (lambda a, b: (a << 3) + b, 12, 12),     # three registers alone, nine bits of sum
    (lambda a, b: Mux(a > b, a - b, b - a), 8, 32),  # comparison, two subtractions, eight tables
    (lambda a, b: a < 80, 1, 1),             # of a constant: tables; 80 is five sixteenths of 256
    (lambda a, b: a & b, 8, 8),
    (lambda a, b: a[:2] + b[:2], 2, 2),      # two bits are two tables,
    (lambda a, b: a[:3] + b[:3], 3, 3),      # three a chain: the third has six inputs
], ids=["sum", "difference", "of ~b", "~sum", "negation", "shifted", "absolute", "constant", "and", "two bits", "three bits"])
def test_arithmetic(function, width, elements):
    result = counted(registered(lambda c: function(c.a, c.b)), a=In(8), b=In(8), y=Out(width))
    assert result.total == Resources(logic_elements=elements)


def cell(kind, inputs, outputs):
    """A cell with ports of one bit."""
    return Cell(kind, {port: [bit] for port, bit in (inputs | outputs).items()},
                dict.fromkeys(inputs, "input") | dict.fromkeys(outputs, "output"), {"WIDTH": "10", "LUT": "0110"})


CARRY = 4
ADD = {"A": 1, "B": 2, "CI": "0"}
PLACES = {
    "chain": cell("C3_ADD", {"A": 1, "B": 2, "CI": CARRY}, {"S": 10}),
    "table": cell("C3_LUT", {"A": CARRY, "B": 2}, {"O": 11}),
    "table too": cell("C3_LUT", {"A": CARRY, "B": 3}, {"O": 12}),
    "register": cell("C3_FF", {"D": CARRY, "EN": "1", "CLR": "0", "CLK": 9}, {"Q": 13}),
    "another chain and a table with both": cell("C3_LUT", {"A": CARRY, "B": 5}, {"O": 14}),
}


@pytest.mark.parametrize("places, elements", [
    (["chain"], 2),
    (["table"], 2),                # which takes the carry as one of its inputs
    (["register"], 2),             # one element as the carry's output, which includes the register
    (["chain", "table"], 4),       # an output, because it leads to two elements
    (["table", "table too"], 4),
    (["another chain and a table with both"], 4),  # a table has one carry as input, the other needs an output
], ids=str)
def test_carry(places, elements):
    cells = {"begin": cell("C3_ADD", ADD, {"S": 3, "CO": CARRY}), **{place: PLACES[place] for place in places}}
    if places == ["another chain and a table with both"]:
        cells["begin another"] = cell("C3_ADD", ADD, {"CO": 5})
    assert count(Mapped("top", Netlist({}, cells, {}), ())).total.logic_elements == elements


def test_register_file():
    # Four registers of 16 bits, one table each for the clock enable; a four-way multiplexer is two tables.
    def build(c, m):
        file = [Signal(16, name=f"register_{n}", reset_less=True) for n in range(4)]
        for n, register in enumerate(file):
            with m.If(c.write & (c.to == n)):
                m.d.sync += register.eq(c.d)
        m.d.comb += c.q.eq(Array(file)[c.at])
    result = counted(build, d=In(16), to=In(2), write=In(1), at=In(2), q=Out(16))
    assert result.total == Resources(logic_elements=4 * 16 + 4 + 2 * 16)
    # A register that no table feeds can share an element with a table that feeds no register.
    assert (result.least, result.most) == (64, 100)


def test_shift_register():
    result = counted(registered(lambda c: Cat(c.a, c.y)), a=In(1), y=Out(16))
    assert result.total == Resources(logic_elements=16)
    assert result.kinds["packed_registers"] == 0


def test_clock_enable_and_clear_cost_nothing():
    def build(c, m):
        value = Signal(16, reset_less=True)
        with m.If(c.enable):
            m.d.sync += value.eq(Mux(c.clear, 0, c.a))
        m.d.comb += c.y.eq(value)
    assert counted(build, a=In(16), enable=In(1), clear=In(1), y=Out(16)).total == Resources(logic_elements=16)


def test_one_table_packs_one_register():
    # The same function in two registers with unlike enables: one shares, the other does not, though the table feeds both.
    def build(c, m):
        y, z = Signal(reset_less=True), Signal(reset_less=True)
        both = Signal()
        m.d.comb += [both.eq(c.a ^ c.b), c.y.eq(y), c.z.eq(z)]
        with m.If(c.one):
            m.d.sync += y.eq(both)
        with m.If(c.two):
            m.d.sync += z.eq(both)
    result = counted(build, a=In(1), b=In(1), one=In(1), two=In(1), y=Out(1), z=Out(1))
    assert (result.total.logic_elements, result.least, result.most) == (2, 2, 3)


# --- Multipliers ---

@pytest.mark.parametrize("a, b, elements", [(18, 18, 2), (13, 9, 2), (10, 10, 2), (9, 9, 1), (8, 5, 1), (36, 18, 4)])
def test_multiplier(a, b, elements):
    result = counted(lambda c, m: m.d.comb.__iadd__(c.y.eq(c.a * c.b)), a=In(a), b=In(b), y=Out(a + b))
    assert result.total.multipliers_9x9 == elements
    assert (result.total.logic_elements == 0) == (a <= 18)  # otherwise partial products are added


def test_multiplier_has_registers():
    def build(c, m):
        product = Signal(22, reset_less=True)
        m.d.sync += product.eq(c.a * c.b)
        m.d.comb += c.y.eq(product)
    result = counted(build, a=In(13), b=In(9), y=Out(22))
    assert result.total == Resources(multipliers_9x9=2)
    assert result.kinds["registers_in_blocks"] == 22
    # But no synchronous clear.
    assert counted(registered(lambda c: c.a * c.b), a=In(13), b=In(9), y=Out(22)).total == Resources(logic_elements=22, multipliers_9x9=2)


def test_small_multiplier_is_tables():
    assert counted(registered(lambda c: c.a * c.b), a=In(3), b=In(3), y=Out(6)).total.multipliers_9x9 == 0


# --- Memories ---

def memory(depth, width, init=(), domain="sync"):
    def build(c, m):
        m.submodules.memory = memory = Memory(shape=width, depth=depth, init=list(init))
        read = memory.read_port(domain=domain)
        m.d.comb += [read.addr.eq(c.at), c.q.eq(read.data)]
        if domain == "sync":
            m.d.comb += read.en.eq(c.read)
        if not init:
            write = memory.write_port()
            m.d.comb += [write.addr.eq(c.to), write.data.eq(c.d), write.en.eq(c.write)]
    return counted(build, at=In(range(depth)), read=In(1), q=Out(width), to=In(range(depth)), write=In(1), d=In(width))


@pytest.mark.parametrize("depth, width, blocks", [
    (8192, 1, 1), (4096, 2, 1), (2048, 4, 1), (1024, 9, 1), (512, 18, 1), (256, 36, 1),
    (720, 7, 1), (720, 12, 2), (720, 880, 98), (1920, 12, 3), (80, 560, 16), (9000, 1, 2),
])
def test_memory(depth, width, blocks):
    total = memory(depth, width).total
    assert (total.m9k, total.memory_bits) == (blocks, depth * width)
    assert (total.logic_elements == 0) == (depth <= 8192)


def test_memory_between_two_clocks():
    """Its output register is that of the block."""
    queue = count(map_cyclone3(AsyncQueue(32, 64, i_domain="camera"), "queue"))
    assert (queue.total.m9k, queue.total.memory_bits, queue.kinds["registers_in_blocks"]) == (1, 2048, 32)
    assert queue.total.logic_elements < 150


def test_rom():
    assert memory(128, 16, init=range(1000, 1128)).total.m9k == 1


def test_small_memory_is_registers():
    # 32 bits; Amaranth's read port is a register too.
    total = memory(4, 8).total
    assert (total.m9k, total.memory_bits) == (0, 0)
    assert total.logic_elements >= 32


def test_asynchronous_memory_is_registers():
    total = memory(64, 8, domain="comb").total
    assert (total.m9k, total.memory_bits) == (0, 0)
    assert total.logic_elements > 64 * 8


# --- The mapping preserves the function ---

@pytest.mark.parametrize("signed", [False, True], ids=["unsigned", "signed"])
def test_mapping_is_exact(signed):
    shape = Shape(6, signed)
    functions = [operator.lt, operator.le, operator.gt, operator.ge, operator.add, operator.sub, lambda a, b: -a, lambda a, b: a + (b ^ 21),
                 lambda a, b: a < 20, lambda a, b: (b << 2) - a, lambda a, b: b[:3] >= a]

    def build(c, m):
        for n, function in enumerate(functions):
            m.d.comb += getattr(c, f"y{n}").eq(function(c.a, c.b))

    mapped = map_cyclone3(Circuit(build, a=In(shape), b=In(shape), **{f"y{n}": Out(8) for n in range(len(functions))}), "top")
    values = range(-32, 32) if signed else range(64)
    low = [lambda a, b: (b & 7) >= a]  # a slice is unsigned
    for a, b in random.Random(1).sample(list(itertools.product(values, values)), 300):
        assert evaluate(mapped, a=a, b=b) == {
            f"y{n}": int(function(a, b)) % 256 for n, function in enumerate(functions[:-1] + low)}


# --- The report ---

def test_tree():
    blocks = {"top": Resources(1), "top.s1": Resources(2), "top.s2": Resources(3),
              **{f"top.array.cell_{n}.x": Resources(n) for n in range(5)}}
    assert tree(blocks) == {
        "top": (1, Resources(16)), "top.array": (1, Resources(10)),
        "top.array.cell*": (5, Resources(10)), "top.array.cell*.x": (5, Resources(10)),
        "top.s1": (1, Resources(2)), "top.s2": (1, Resources(3)),
    }


def example():
    return Count({"matcher": Resources(100, 20, 3, 4), "matcher.bec": Resources(1, 2, 3, 4)},
                 {"tables": 1, "carry_elements": 2, "registers": 3, "packed_registers": 4, "registers_in_blocks": 5}, least=90, most=110)


def test_json():
    clock = Clock("ECP5", 77.777, ("a", "b", "c"), 1.234, 5, {}, False)
    document = as_json(example(), [clock], {"engine": "streaming"}, DEVICE.capacity)
    document = json.loads(json.dumps(document))
    assert document["total"] == {"logic_elements": 101, "memory_bits": 22, "m9k": 6, "multipliers_9x9": 8}
    assert {tuple(block) for block in document["blocks"].values()} == {FIGURES}
    assert (document["clock_mhz"], document["clock_device"], document["clock_mhz_by_seed"]) == (77.78, "ECP5", {"1": 77.78})
    assert document["worst_path"] == {"from": "a", "to": "c", "through": ["b"], "logic_ns": 1.23, "routing_ns": 5}
    assert "clock_mhz" not in as_json(example(), [], {}, DEVICE.capacity)


def test_method_tells_its_error():
    assert "at best 90 logic elements (-10.9 %)" in counting(example())
    assert "110 (+8.9 %)" in counting(example())


@pytest.mark.parametrize("thesis", [False, True])
def test_table_shows_the_thesis_at_its_size(thesis):
    rows = list(table(example(), DEVICE, "title", thesis).columns[0].cells)
    assert ("thesis, table 2" in rows) == thesis


def test_system_table():
    """Blocks of the first level with their shares; what they hold is in them; the allowance is in the total."""
    count = Count({"system": Resources(10, 0, 0, 0), "system.a": Resources(100, 20, 3, 4), "system.a.b": Resources(1, 2, 3, 4)})
    shown = system_table(count, DEVICE, "title", Resources(1000, 0, 2, 0))
    names, elements, shares = (list(shown.columns[number].cells) for number in range(3))
    assert names[:4] == ["DDR2 controller, an allowance", "a", "system itself", "total"]
    assert elements[:4] == ["1,000", "101", "10", "1,111"] and shares[3] == f"{100 * 1111 / 119088:.1f}"
    assert list(shown.columns[5].cells)[:4] == ["2", "6", "0", "8"]


def test_command_line(tmp_path, capsys):
    file = tmp_path / "count.json"
    assert command.main(["--device", DEVICE.name, "--width", "16", "--disparities", "2", "--fraction-bits", "2", "--json", str(file)]) == 0
    document = json.loads(file.read_text())
    out = capsys.readouterr().out
    assert f"{document['total']['logic_elements']:,}" in out
    assert (document["method"], document["method_parameters"]["fraction_bits"], document["arithmetic"]) == ("thesis", 2, "linear")
    assert "method thesis, linear arithmetic" in out and document["counting"] in out
    assert "Error: " in out
    for figure in FIGURES:
        assert document["total"][figure] == sum(block[figure] for block in document["blocks"].values())


@pytest.mark.parametrize("arguments, sentence", [
    (["--device", "spartan"], "there is no device 'spartan'; choose one of: EP3C120F780C7"),
    (["--arithmetic", "float"], "--arithmetic float has no gateware; choose thesis or linear"),
    (["--arithmetic", "float", "--method", "fused"], "--arithmetic float has no gateware; choose linear"),
    (["--system", "--clock"], "leave --clock or --system out"),
    (["--system", "--width", "640"], "send pictures of 720x576 pixels, not 640x576; leave --width and --height out"),
    (["--stand-in", "nexus"], "--stand-in nexus is for a clock rate; add --clock, or leave it out"),
    (["--seeds", "2"], "--seeds 2 is for a clock rate; add --clock, or leave it out"),
    (["--clock", "--stand-in", ""], "there is no stand-in ''; choose one of: ecp5, nexus"),
    (["--clock", "--stand-in", "ice40"], "there is no stand-in 'ice40'; choose one of: ecp5, nexus"),
    (["--clock", "--seeds", "0"], "--seeds must be a whole number from 1 to 100, not 0; choose a value in that range"),
    (["--width", "0"], "--width must be a whole number from 1 to 4096, not 0; choose a value in that range"),
    (["--disparities", "1"], "not 1; choose a value in that range"),
    (["--json", "count.txt"], "choose one of these for --json"),
    (["--engine", "streaming", "--arithmetic", "thesis"], "choose --engine sequential or --arithmetic linear"),
    (["--engine", "steam"], "invalid Engine value: 'steam'"),
])
def test_bad_input_is_one_sentence(arguments, sentence, capsys):
    assert command.main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("hdl.resources: ") and sentence in error and error.count("\n") == 1


def test_missing_tool_is_one_sentence(monkeypatch, capsys):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert command.main(["--disparities", "2"]) == 2
    assert "the Python package pyosys is not installed" in capsys.readouterr().err
