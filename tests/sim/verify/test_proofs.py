"""The catalogue of proofs: the quick ones are carried out, and deliberate faults are refuted."""

import argparse
import gc
import json

import pytest
from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.errors import UserError
from hdl.host.registers import RequestReader
from hdl.loop import pair_read
from hdl.loop.pair_read import PairScan
from hdl.matcher import lines
from hdl.matcher.sequential.argmin import ComparatorTree
from hdl.parts.arithmetic import multiply
from hdl.parts.delay import Delay, StreamRegister
from hdl.parts.queue import Queue
from hdl.video.bt656 import ActivePixels
from hdl.video.i2c import I2cMaster
from hdl.video.timing_codes import TimingCodes
from sim.verify import campaign
from sim.verify.parts import proofs
from sim.verify.proofs import components, credits, minimum, order, protocols, streams
from sim.verify.proofs.claim import Claim, streams_of
from sim.verify.proofs.proof import FAMILIES, Proof, carried_out


# Many components are built only to look at their members, or a claim twice.
pytestmark = pytest.mark.filterwarnings("ignore::amaranth.hdl.UnusedElaboratable")

CATALOGUE = proofs.all_proofs()


@pytest.fixture(scope="module", autouse=True)
def collected():
    """What was not elaborated warns here, and not in another file's tests."""
    yield
    gc.collect()


def result_of(family, claim, folder, **options):
    return carried_out(Proof(family, "fault", "", "", claim, **options), folder)


@pytest.mark.parametrize("key", [key if proof.quick else pytest.param(key, marks=pytest.mark.slow) for key, proof in CATALOGUE.items()])
def test_claim(key, tmp_path):
    result = carried_out(CATALOGUE[key], tmp_path)
    assert result["result"] in proofs.HOLDS, result["found"]


def test_catalogue():
    assert {proof.family for proof in CATALOGUE.values()} == set(FAMILIES)
    assert all(proof.size and proof.witness for proof in CATALOGUE.values())


def test_components_with_streams():
    """Each is proved, passes on streams of a part that is, or sends none."""
    proved = {type(proof.build().component) for proof in streams.PROOFS}
    for make in components.SEND_NOTHING:
        assert not [found.name for found in streams_of(make()) if found.is_output]
    passing = [make() for make in components.PASS_ON]
    passed_on = {type(component) for component in passing}
    for component in passing:
        sources = components.sources_of(component)
        assert sources and set(sources.values()) <= proved | passed_on, (component, sources)
    known = proved | passed_on | {type(make()) for make in components.SEND_NOTHING} | set(components.BASES)
    assert components.components_with_streams() == known


def test_a_new_component_is_missed(monkeypatch):
    class Late(wiring.Component):
        __module__ = "hdl.late"

        def __init__(self):
            super().__init__({"o": Out(stream.Signature(1))})

    assert Late in components.components_with_streams()


def test_a_stream_that_is_not_passed_on():
    class Inverts(wiring.Component):
        def __init__(self):
            super().__init__({"i": In(stream.Signature(1)), "o": Out(stream.Signature(1))})

        def elaborate(self, platform):
            m = Module()
            m.submodules.register = register = StreamRegister(1)
            wiring.connect(m, wiring.flipped(self.i), register.i)
            m.d.comb += [self.o.valid.eq(register.o.valid & ~register.o.p), register.o.ready.eq(self.o.ready)]
            return m

    assert components.sources_of(Inverts()) == {"o": None}


class Faulty(wiring.Component):
    """A register of a stream with a fault."""
    def __init__(self, fault):
        self.fault = fault
        super().__init__({"i": In(stream.Signature(2)), "o": Out(stream.Signature(2))})

    def elaborate(self, platform):
        m = Module()
        valid, payload = Signal(), Signal(2)
        m.d.comb += [self.i.ready.eq(~valid | self.o.ready), self.o.valid.eq(valid), self.o.p.eq(payload)]
        with m.If(self.i.ready):
            m.d.sync += [valid.eq(self.i.valid), payload.eq(self.i.p)]
        match self.fault:
            case "drops":
                m.d.sync += valid.eq(self.i.valid & self.i.ready)
            case "changes":
                m.d.sync += payload.eq(self.i.p)
            case "waits":
                m.d.comb += self.o.valid.eq(valid & self.o.ready)
            case "asks first":
                asked = Signal()
                m.d.sync += asked.eq(asked | self.o.ready)
                m.d.comb += self.o.valid.eq(valid & asked)
        return m


@pytest.mark.parametrize("fault, result, found", [
    ("", "proved", ""), ("drops", "refuted", "o holds"), ("changes", "refuted", "o holds"), ("waits", "waits for ready", "o"),
    ("asks first", "says nothing", "witness")])
def test_stream_rules(fault, result, found, tmp_path):
    told = result_of("streams", lambda: streams.StreamRules(Faulty(fault)), tmp_path)
    assert told["result"] == result and found in told["found"]


def test_valid_that_depends_on_ready(tmp_path):
    """It may hold all the same."""
    class Offers(wiring.Component):
        def __init__(self):
            super().__init__({"o": Out(stream.Signature(2))})

        def elaborate(self, platform):
            m = Module()
            held = Signal()
            m.d.sync += held.eq(1)
            m.d.comb += self.o.valid.eq(held | self.o.ready)
            return m

    assert result_of("streams", lambda: streams.StreamRules(Offers()), tmp_path)["result"] == "waits for ready"


class Slow(Claim):
    def build(self, m):
        count = Signal(4)
        m.d.sync += count.eq(count + self.free(1, "up"))
        self.promise(m, count != 9, "less than nine")
        m.d.comb += self.witness.eq(count == 2)


def test_bounded_and_what_is_told(tmp_path):
    assert result_of("order", Slow, tmp_path, depth=9)["result"] == "bounded"
    told = result_of("order", Slow, tmp_path)
    assert told["result"] == "refuted" and told["found"].endswith("broken in the last cycle: less than nine")
    assert [line.split() for line in told["found"].splitlines()[:2]] == [["cycle", "up"], ["0", "1"]]
    assert result_of("order", Slow, tmp_path, depth=9, witness=2)["result"] == "says nothing"


def options(tmp_path, **changed):
    return argparse.Namespace(**{"workers": 1, "work": tmp_path, "restart": False, "record": False, "quick": False, "only": "",
                                 "timeout": 60.0, **changed})


def test_command(tmp_path, monkeypatch, capsys):
    catalogue = {"order: good": Proof("order", "good", "a claim", "small", lambda: streams.StreamRules(Faulty("")))}
    monkeypatch.setattr(proofs, "all_proofs", lambda: catalogue)
    monkeypatch.setattr(campaign, "RECORDS", tmp_path / "records")
    assert proofs.PART.run(options(tmp_path, record=True)) == 0
    record = json.loads((tmp_path / "records" / "proofs.json").read_text())
    text = "\n".join(proofs.PART.section(record))
    assert "1 claims hold" in text and "| `good` | small | a claim | any time |" in text
    catalogue["order: bad"] = Proof("order", "bad", "", "small", lambda: streams.StreamRules(Faulty("drops")))
    assert proofs.PART.run(options(tmp_path)) == 1
    assert "o holds" in capsys.readouterr().out
    with pytest.raises(UserError, match="no proof has 'x' in its name"):
        proofs.PART.run(options(tmp_path, only="x"))
    with pytest.raises(UserError, match="leave out --quick and --only"):
        proofs.PART.run(options(tmp_path, only="good", record=True))


class Reorders(Faulty):
    """A queue whose words leave in another order, or twice, or not at all."""
    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = Queue(2, 3)
        m.d.comb += [queue.i.valid.eq(self.i.valid), queue.i.p.eq(self.i.p), self.i.ready.eq(queue.i.ready),
                     self.o.valid.eq(queue.o.valid), self.o.p.eq(queue.o.p), queue.o.ready.eq(self.o.ready)]
        match self.fault:
            case "repeats":
                again = Signal()
                m.d.sync += again.eq(self.o.valid & self.o.ready & (self.o.p == 3) & ~again)
                m.d.comb += queue.o.ready.eq(self.o.ready & ~again)
            case "loses":
                m.d.comb += queue.i.valid.eq(self.i.valid & (self.i.p != 3))
            case "changes":
                m.d.comb += self.o.p.eq(Mux(queue.o.p == 3, 2, queue.o.p))
            case "waits":
                m.d.comb += self.o.valid.eq(queue.o.valid & (queue.level != 1))
        return m


@pytest.mark.parametrize("fault, found", [
    ("", ""), ("repeats", "was"), ("loses", "offered in time"), ("changes", "the word that was accepted"), ("waits", "offered in time")])
def test_order(fault, found, tmp_path):
    told = result_of("order", lambda: order.InOrder(Reorders(fault), most=3, patience=2), tmp_path)
    assert told["result"] == ("refuted" if fault else "proved") and found in told["found"]


@pytest.mark.parametrize("make, clocks", [(lambda: Delay(2, 7), 6), (lambda: Delay(2, 3), 4)])
def test_delay_of_another_length(make, clocks, tmp_path):
    assert result_of("order", lambda: order.Delayed(make(), clocks), tmp_path)["result"] == "refuted"


def test_line_store_that_shows_another_pixel(tmp_path, monkeypatch):
    """The lines above and below are exchanged."""
    monkeypatch.setattr(lines, "line_names", lambda rows: ["plus", "line", "minus"])
    told = result_of("order", lambda: order.LinesInOrder(streams.short_store(), 2, 2), tmp_path, depth=22)
    assert told["result"] == "refuted" and "the pixel that was accepted" in told["found"]


def test_wrong_minima(tmp_path):
    """Ties to the greater index; a product that is one too large at one place."""
    def tree(m, claim):
        m.submodules.tree = tree = ComparatorTree(2, 3)
        values = [claim.free(2, f"value_{n}") for n in range(3)]
        m.d.comb += [tree.enable.eq(1), *(port.eq(value) for port, value in zip(tree.i, values))]
        return tree.o.index, Mux((values[2] <= values[1]) & (values[2] <= values[0]), 2, values[1] < values[0])[:2], tree.latency

    def product(m, claim):
        a, b = claim.free(3, "a"), claim.free(3, "b")
        given, latency = multiply(m, "product", a, b)
        return given, (a * b + ((a == 7) & (b == 5)))[:6], latency

    for values in (tree, product):
        assert result_of("minimum", lambda: minimum.Equals(values), tmp_path)["result"] == "refuted"


def test_labels_with_a_wrong_slope(tmp_path, monkeypatch):
    monkeypatch.setattr(minimum, "vertex_rise", lambda wave, at_low, at_high: Mux(at_high, wave.high_rise, 0))
    assert result_of("minimum", lambda: minimum.Equals(minimum.label_passes), tmp_path, depth=14)["result"] == "refuted"


def test_one_credit_too_many(tmp_path, monkeypatch):
    """A reader that asks for a word more than its queue holds."""
    class Short(Queue):
        def __init__(self, shape, depth):
            super().__init__(shape, depth - 1)

    monkeypatch.setattr(pair_read, "Queue", Short)
    told = result_of("credits", lambda: credits.scan_credits(PairScan(streams.LINEAR, 2, 4)), tmp_path)
    assert told["result"] == "refuted" and told["found"].endswith("queue 0 has room")


def test_arbiter_is_not_faster(tmp_path):
    """Four cycles less than its bounds are not enough."""
    told = result_of("credits", lambda: credits.Served(2, 1, 2, 2, slack=4), tmp_path)
    assert told["result"] == "refuted" and "in time" in told["found"]


class Emits(ActivePixels):
    """One pixel too many, after the line."""
    def elaborate(self, platform):
        m = super().elaborate(platform)
        late = Signal()
        m.d.sync += late.eq(self.strobe & self.o.last)
        with m.If(late):
            m.d.sync += self.strobe.eq(1)
        return m


class Unchecked(RequestReader):
    """Acts on what was received, sum or not."""
    def elaborate(self, platform):
        m = super().elaborate(platform)
        count = Signal(3)
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += count.eq(count + 1)
        with m.If((count == 6) & ~self.i.ready):
            m.d.comb += self.access.commit.eq(1)
        return m


class Starts(I2cMaster):
    """Pulls SDA low while SCL is released."""
    def elaborate(self, platform):
        m = super().elaborate(platform)
        with m.If(self.i.valid & self.i.ready & ~self.scl_low):
            m.d.sync += self.sda_low.eq(1)
        return m


@pytest.mark.parametrize("claim, depth, found", [
    (lambda: protocols.VideoLines(Emits(protocols.SMALL_FORMAT)), None, ""),
    (lambda: protocols.Codes(TimingCodes(), wrong_bits=2), None, "the code"),
    (lambda: protocols.OpenDrain(Starts(400_000)), None, "a start condition"),
    (lambda: protocols.CheckedRequests(Unchecked(3, writes=True)), 12, "the s"),
])
def test_broken_protocols(claim, depth, found, tmp_path):
    told = result_of("protocols", claim, tmp_path, depth=depth)
    assert told["result"] == "refuted" and found in told["found"].splitlines()[-1]
