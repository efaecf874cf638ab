"""The estimate of resources, on circuits that can be counted by hand; tests of the counts compare it for whole matchers."""

import pytest
from amaranth import *
from amaranth.hdl import Mux
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.emit import emit_rtlil, rtlil_text
from hdl.memory_blocks import MemoryShape, blocks, logic_elements
from hdl.netlist import Cell, Netlist, Port
from hdl.parts.queue import AsyncQueue
from hdl.resources.count import Resources
from hdl.resources.estimate import Elements, elements, estimate
from tests.kit import Circuit


def comb(function):
    return lambda c, m: m.d.comb.__iadd__(c.y.eq(function(c)))


def registered(m, value, output):
    """A register without reset between a value and an output."""
    register = Signal(len(output), reset_less=True)
    m.d.sync += register.eq(value)
    m.d.comb += output.eq(register)


WORDS = {"a": In(8), "b": In(8)}

# A combinational function, the width of its result, and the logic elements.
LOGIC = [
    (lambda c: c.a + c.b, 9, 9),
    (lambda c: c.a + c.b, 8, 8),
    (lambda c: c.a[:2] + c.b[:2], 2, 2),                # in tables
    (lambda c: c.a + (c.b << 3), 11, 8),                # the low bits are those of a
    (lambda c: c.a + 0, 8, 0),
    (lambda c: (c.a - c.b)[8], 1, 9),
    (lambda c: -c.a, 9, 9),
    (lambda c: c.a.as_signed() + c.b.as_signed(), 12, 9),     # the sign is extended by wires
    (lambda c: Cat(c.a, c.a[7].replicate(4)).as_signed() + Cat(c.b, c.b[7].replicate(4)).as_signed(), 13, 9),     # here by the operands
    (lambda c: c.a > c.b, 1, 8),
    (lambda c: c.a.as_signed() <= c.b.as_signed(), 1, 8),
    (lambda c: c.a.as_signed() >= 0, 1, 0),
    (lambda c: c.a == c.b, 1, 5),                       # a table for two bits, and one for all
    (lambda c: c.a == 77, 1, 3),
    (lambda c: c.a.any(), 1, 3),
    (lambda c: c.a.xor(), 1, 3),
    (lambda c: c.a ^ c.b, 8, 8),
    (lambda c: ~(c.a & c.b), 4, 4),
    (lambda c: Mux(c.a[0], c.b, ~c.b), 8, 8),           # an exclusive or, of which one bit is constant
    (lambda c: Cat(Mux(c.a[0], ~c.b[0], c.b[0]), c.a[0] ^ c.b[0]), 2, 1),       # one function, written in two ways
    (lambda c: Mux(c.a[0], c.b, c.b), 8, 0),
    (lambda c: Cat(c.a, c.b).bit_select(c.b[:2], 4), 4, 10),
    (lambda c: (c.a[0] ^ c.a[1]) + (c.b[0] ^ c.b[1]), 2, 2),    # both bits take the pairs into their tables
]
PRODUCTS = [(9, 9, 1), (10, 4, 2), (18, 18, 2), (4, 4, 1), (8, 3, 0)]


def priority(c, m):
    with m.Switch(c.a):
        for place in range(4):
            with m.Case("-" * (7 - place) + "1" + "0" * place):
                m.d.comb += c.y.eq(c.b[place])


def registers(c, m):
    """A counter, and two copies of a word."""
    counter, copy, other = Signal(16), Signal(8), Signal(8)
    m.d.sync += [counter.eq(counter + 1), copy.eq(c.a), other.eq(c.a), c.y.eq(counter), c.z.eq(copy ^ other)]


def outside(c, m):
    """What a block above leaves open or sets is known inside."""
    def inside(c, m):
        m.d.sync += [c.y.eq(c.a + c.b), c.z.eq(c.a - c.b)]
    m.submodules.part = part = Circuit(inside, **WORDS, y=Out(8), z=Out(8))
    m.d.comb += [part.a.eq(c.a), part.b.eq(0), c.y.eq(part.y)]


def memory(words, width, init=(), write=True):
    def build(c, m):
        m.submodules.memory = store = Memory(shape=width, depth=words, init=init)
        read = store.read_port()
        m.d.comb += [read.addr.eq(c.a), read.en.eq(1)]
        if write:
            port = store.write_port()
            m.d.comb += [port.addr.eq(c.a), port.data.eq(c.b), port.en.eq(1)]
        registered(m, read.data, c.y)
    return build


def queue(c, m):
    """Leads to nothing."""
    m.submodules.queue = AsyncQueue(8, 64, i_domain="sync", o_domain="sync")


BLOCKS = {
    **{f"logic_{place}": (comb(function), {**WORDS, "y": Out(width)}) for place, (function, width, _) in enumerate(LOGIC)},
    **{f"product_{a}_{b}": (lambda c, m: registered(m, c.a * c.b, c.y), {"a": In(a), "b": In(b), "y": Out(a + b)}) for a, b, _ in PRODUCTS},
    "priority": (priority, {**WORDS, "y": Out(1)}),
    "registers": (registers, {"a": In(8), "y": Out(16), "z": Out(8)}),
    "outside": (outside, {"a": In(8), "y": Out(8)}),
    "memory": (memory(256, 10), {"a": In(8), "b": In(10), "y": Out(10)}),
    "narrow_memory": (memory(256, 10), {"a": In(8), "b": In(6), "y": Out(10)}),
    "table": (memory(256, 10, init=range(256), write=False), {"a": In(8), "y": Out(10)}),
    "queue": (queue, {"a": In(1)}),
}


@pytest.fixture(scope="module")
def figures():
    """Of each of the blocks, in a design with all of them, whose ports are theirs; emitted once."""
    def build(c, m):
        for name, (function, ports) in BLOCKS.items():
            m.submodules[name] = block = Circuit(function, **ports)
            for port, member in ports.items():
                pair = getattr(block, port), getattr(c, f"{name}_{port}")
                m.d.comb += pair[0].eq(pair[1]) if member.flow is In else pair[1].eq(pair[0])
    ports = {f"{name}_{port}": member for name, (_, ports) in BLOCKS.items() for port, member in ports.items()}
    found = estimate(emit_rtlil(rtlil_text(Circuit(build, **ports), name="top")).netlist, "top").blocks
    return {name: Resources(*map(sum, zip(Resources(), *(figures for path, figures in found.items() if path.split(".")[1] == name))))
            for name in BLOCKS}


@pytest.mark.parametrize("place", range(len(LOGIC)))
def test_logic(place, figures):
    assert figures[f"logic_{place}"] == Resources(logic_elements=LOGIC[place][2])


def test_priority(figures):
    """Four cases; the selections take some of the tables."""
    assert 2 <= figures["priority"].logic_elements <= 4


def test_registers(figures):
    """The counter's registers are in the elements of its sum, y's are not; of two copies one is left, and their difference is constant."""
    assert figures["registers"] == Resources(logic_elements=32)


def test_unused_and_constant(figures):
    assert figures["outside"] == Resources(logic_elements=8)       # registers only


@pytest.mark.parametrize("a, b, multipliers", PRODUCTS)
def test_products(a, b, multipliers, figures):
    """The registers behind are in the multiplier; a narrow product is tables, of which each has one."""
    assert figures[f"product_{a}_{b}"] == Resources(logic_elements=0 if multipliers else 36, multipliers_9x9=multipliers)


def test_memory(figures):
    """The registers behind are in the block, and a bit that is always written as 0 has no place in it, nor one that never differs."""
    assert figures["memory"] == Resources(memory_bits=2560, m9k=1)
    assert figures["narrow_memory"]._replace(logic_elements=0) == Resources(memory_bits=6 * 256, m9k=1)
    assert figures["table"] == Resources(memory_bits=8 * 256, m9k=1)


def test_leads_to_nothing(figures):
    assert figures["queue"] == Resources()


@pytest.mark.parametrize("shape, number", [
    ((8192, 1, 1), 1), ((8193, 1, 1), 2), ((256, 36, 1), 1), ((257, 36, 1), 2), ((720, 9, 1), 1), ((720, 10, 1), 2), ((512, 37, 1), 3),
    ((19, 4, 1), 1), ((18, 4, 1), 0), ((19, 4, 1, 1, 2), 0), ((20, 4, 1, 1, 2), 1),     # 4 costs a bit in registers against 18 or 19
    ((256, 8, 0), 1), ((32, 9, 0), 0), ((720, 8, 1, 2), 2),
])
def test_memory_blocks(shape, number):
    assert blocks(MemoryShape(*shape)) == number


def test_memory_in_logic():
    assert logic_elements(MemoryShape(4, 6, 1)) == 24 + 4 + 12
    assert logic_elements(MemoryShape(32, 9, 0)) == 18


def test_black_box():
    """Its pins are outputs and inputs of the design."""
    cells = {"box": Cell("vendor", {"a": [3], "q": [4]}),
             "not": Cell("$not", {"A": [4], "Y": [3]}, {"A": "input", "Y": "output"}, {"A_SIGNED": "0"})}
    modules = {"top": Netlist({"y": Port("output", [4])}, cells, {"a": [3], "q": [4]})}
    assert estimate(modules, "top").total == Resources()    # an inverter is part of what it leads to


def test_feedthrough():
    """An output of a module that repeats an input is that input."""
    wire = Netlist({"i": Port("input", [2]), "o": Port("output", [2])}, {}, {"i": [2]})
    differ = Cell("$xor", {"A": [2], "B": [3], "Y": [4]}, {"A": "input", "B": "input", "Y": "output"}, {"A_SIGNED": "0", "B_SIGNED": "0"})
    cells = {"part": Cell("wire", {"i": [2], "o": [3]}, {"i": "input", "o": "output"}), "differ": differ}
    top = Netlist({"a": Port("input", [2]), "y": Port("output", [4])}, cells, {"a": [2], "b": [3], "y": [4]})
    assert estimate({"top": top, "wire": wire}, "top").total == Resources()


@pytest.mark.parametrize("shared, ports", [(True, 1), (False, 2)])
def test_elements(shared, ports):
    """By hand: a memory with a read at the address of its write, or at another one, and a second read; a product, a sum, a register."""
    def build(c, m):
        m.submodules.memory = memory = Memory(shape=8, depth=64, init=[])
        write, reads = memory.write_port(), [memory.read_port(), memory.read_port()]
        m.d.comb += [write.addr.eq(c.a), write.data.eq(c.b), write.en.eq(1)]
        m.d.comb += [reads[0].addr.eq(c.a if shared else c.c), reads[1].addr.eq(c.b)]
        m.d.sync += c.sum.eq(reads[0].data + reads[1].data)
        m.d.comb += c.product.eq(c.b[:5] * c.c[:4])
    circuit = Circuit(build, a=In(6), b=In(8), c=In(8), sum=Out(9), product=Out(9))
    found = elements(emit_rtlil(rtlil_text(circuit, name="top")).netlist, "top")
    assert found == Elements(0, 9, 9, [(5, 4)], [MemoryShape(64, 8, 1, ports, 1)])
