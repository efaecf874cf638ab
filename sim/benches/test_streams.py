"""The stream helpers for Amaranth's simulator, on a register stage with deliberate faults."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from sim.kit.streams import run_stream


WORD = data.StructLayout({"value": 8, "last": 1})


class Stage(wiring.Component):
    """One register; ``fault`` breaks a rule."""
    def __init__(self, fault):
        self.fault = fault
        super().__init__({"i": In(stream.Signature(WORD)), "o": Out(stream.Signature(WORD))})

    def elaborate(self, platform):
        m = Module()
        full = Signal()
        advance = Signal()
        m.d.comb += [advance.eq(~full | self.o.ready), self.i.ready.eq(advance), self.o.valid.eq(full)]
        with m.If(advance):
            m.d.sync += [full.eq(self.i.valid), self.o.p.eq(self.i.p)]
        match self.fault:
            case "valid waits for ready":
                m.d.comb += self.o.valid.eq(full & self.o.ready)
            case "valid drops":
                m.d.sync += full.eq(self.i.valid & advance)
            case "payload changes":
                m.d.sync += self.o.p.eq(self.i.p)
            case "word is repeated":
                with m.If(self.o.p.last & advance):
                    m.d.sync += full.eq(1)
        return m


def through(fault, stall):
    words = [{"value": n, "last": n == 59} for n in range(60)]
    cycles = {}
    out = run_stream(Stage(fault), words, rng=np.random.default_rng(1), stall_i=stall, stall_o=stall, cycles=cycles, timeout=300)
    assert [(word.value, word.last) for word in out] == [(n, n == 59) for n in range(60)]
    return cycles


def test_good():
    cycles = through(None, 0.0)
    assert cycles["o"] == [cycle + 1 for cycle in cycles["i"]] == list(range(1, 61))
    through(None, 0.5)


@pytest.mark.parametrize("fault, error, told", [
    ("valid waits for ready", TimeoutError, "0 of 60"),
    ("valid drops", AssertionError, "valid dropped"),
    ("payload changes", AssertionError, "payload changed"),
    ("word is repeated", AssertionError, "extra item"),
])
def test_fault_is_seen(fault, error, told):
    with pytest.raises(error, match=told):
        through(fault, 0.5)
