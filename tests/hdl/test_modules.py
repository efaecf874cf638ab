import re

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import verilog_text
from hdl.modules import merge_equal_modules


class Leaf(wiring.Component):
    def __init__(self, step):
        self.step = step
        super().__init__({"i": In(8), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.o.eq(self.i + self.step)
        return m


class Chain(wiring.Component):
    """Leaves one after the other, or chains of them."""
    def __init__(self, parts):
        self.parts = parts
        super().__init__({"i": In(8), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        value = self.i
        for number, part in enumerate(self.parts):
            m.submodules[f"part_{number}"] = part
            m.d.comb += part.i.eq(value)
            value = part.o
        m.d.comb += self.o.eq(value)
        return m


def structure(text):
    """Modules, and the instances in them: name to kind."""
    modules = re.split(r"(?m)^module (\w+)", text)
    return {name: {instance: kind for kind, instance in re.findall(r"(?m)^  (\w+) (\w+) \($", body)}
            for name, body in zip(modules[1::2], modules[2::2], strict=True)}


def test_equal_modules_are_one():
    """At all levels, with the name of the first one; instances keep theirs. What differs stays apart."""
    text = verilog_text(Chain([Chain([Leaf(1), Leaf(2)]), Chain([Leaf(1), Leaf(3)]), Chain([Leaf(1), Leaf(2)])]), name="top")
    assert structure(text) == {
        "top": {"part_0": "top_part_0", "part_1": "top_part_1", "part_2": "top_part_0"},
        "top_part_0": {"part_0": "top_part_0_part_0", "part_1": "top_part_0_part_1"},
        "top_part_0_part_0": {}, "top_part_0_part_1": {},
        "top_part_1": {"part_0": "top_part_0_part_0", "part_1": "top_part_1_part_1"},
        "top_part_1_part_1": {},
    }


def test_what_is_no_module_stays():
    text = "attribute \\top 1\nattribute \\x 2\nmodule \\a\nend\nmodule \\b\n  wire \\x\nend\n\n"
    assert merge_equal_modules(text) == text
    assert merge_equal_modules("") == ""
