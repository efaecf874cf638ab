"""Protocols of the outside: lines of video, the I2C bus, requests of the host, buses."""

from collections.abc import Callable
from functools import reduce
from itertools import pairwise
from operator import or_
from typing import Any

from amaranth import *

from golden.host.protocol import FRAME_BYTES, REQUEST_SYNC
from golden.video.formats import CameraFormat
from golden.video.setup_steps import Failure
from hdl.host.registers import RequestReader
from hdl.interfaces.axi_lite import AxiLite
from hdl.video.bt656 import ActivePixels
from hdl.video.i2c import I2cMaster
from hdl.video.timing_codes import TimingCodes

from .claim import Claim
from .proof import Proof
from .streams import AXI, axi


__all__ = ["AxiResponses", "CheckedRequests", "Codes", "OpenDrain", "PROOFS", "VideoLines"]


SMALL_FORMAT = CameraFormat(width=2, field_lines=2, blanking=1, before_top=1, after_top=1, before_bottom=1, after_bottom=1)


class VideoLines(Claim):
    """Pixels of a camera, whatever its bytes are: none outside a line of active video, frames of the right size or closed by ``drop``."""
    def __init__(self, component: ActivePixels, codes: TimingCodes | None = None):
        super().__init__()
        self.component, self.codes = component, codes or TimingCodes()

    def build(self, m: Module) -> None:
        pixels, codes, camera = self.component, self.codes, self.component.format
        m.submodules.codes, m.submodules.pixels = codes, pixels
        m.d.comb += [
            codes.data.eq(self.free(8, "data")), pixels.byte.eq(codes.byte), pixels.found.eq(codes.found), pixels.valid.eq(codes.valid),
            pixels.code.eq(codes.code),
        ]
        # Between the code that begins active video and the next one; that one included, which closes the line.
        active = Signal()
        with m.If(codes.found):
            m.d.sync += active.eq(codes.valid & ~codes.code.h & ~codes.code.v)
        was_active = Signal()
        m.d.sync += was_active.eq(active)
        pixel = Signal()
        m.d.comb += pixel.eq(pixels.strobe & ~pixels.o.drop)
        self.promise(m, ~pixel | was_active, "no pixel outside a line")
        x, y, opened = Signal(range(camera.width)), Signal(range(camera.height)), Signal()
        last = x == camera.width - 1
        end = last & (y == camera.height - 1)
        with m.If(pixel):
            self.promise(m, pixels.o.first == ((x == 0) & (y == 0)), "first")
            self.promise(m, pixels.o.last == last, "last")
            self.promise(m, pixels.o.end == end, "end")
            m.d.sync += [x.eq(Mux(last, 0, x + 1)), opened.eq(~end)]
            with m.If(last):
                m.d.sync += y.eq(Mux(end, 0, y + 1))
        with m.If(pixels.strobe & pixels.o.drop):
            m.d.sync += [x.eq(0), y.eq(0), opened.eq(0)]
        m.d.comb += self.witness.eq(pixel & pixels.o.last & (y == 1))


class Codes(Claim):
    """A code with one wrong bit is the code that was sent; any two codes that are sent differ in four bits."""
    def __init__(self, component: TimingCodes, *, wrong_bits: int = 1):
        super().__init__()
        self.component, self.wrong_bits = component, wrong_bits

    def build(self, m: Module) -> None:
        m.submodules.codes = codes = self.component
        state, data = Signal(2), self.free(8, "data")
        f, v, h = (self.free(1, name) for name in "fvh")
        sent = Cat(f ^ v ^ h, f ^ v, f ^ h, v ^ h, h, v, f, 1)
        wrong = reduce(or_, ((C(1, 8) << self.free(3, f"wrong_{n}"))[:8] for n in range(self.wrong_bits)), C(0, 8))
        wrong &= self.free(1, "is_wrong").replicate(8)
        # FF, 00, 00, then the code; between codes any bytes.
        preamble = self.free(1, "preamble")
        with m.If((state != 0) | preamble):
            m.d.sync += state.eq(state + 1)
        with m.Switch(state):
            with m.Case(0):
                m.d.comb += codes.data.eq(Mux(preamble, 0xFF, data))
            with m.Case(1, 2):
                m.d.comb += codes.data.eq(0)
            with m.Case(3):
                m.d.comb += codes.data.eq(sent ^ wrong)
        due, expected = Signal(codes.LATENCY), [Signal(4, name=f"expected_{n}") for n in range(codes.LATENCY)]
        m.d.sync += [due.eq(Cat(state == 3, due)), expected[0].eq(Cat(f, v, h, wrong.any()))]
        m.d.sync += [later.eq(earlier) for earlier, later in pairwise(expected)]
        with m.If(due[-1]):
            self.promise(m, codes.found & codes.valid, "the code is found")
            self.promise(m, Cat(codes.code, codes.corrected) == expected[-1], "the code that was sent")
        m.d.comb += self.witness.eq(due[-1] & codes.corrected)


class OpenDrain(Claim):
    """While SCL is released SDA falls for a start condition only, which the command has; between the bytes of a transfer SCL is low.

    ``scl_low`` and ``sda_low`` only ever pull their lines low: the component has no other outputs to them.
    """
    def __init__(self, component: I2cMaster):
        super().__init__()
        self.component = component

    def build(self, m: Module) -> None:
        m.submodules.master = master = self.component
        self.surround(m, master)
        released, sda_low = Signal(), Signal()
        command = Signal.like(master.i.p)
        m.d.sync += [released.eq(~master.scl_low), sda_low.eq(master.sda_low)]
        with m.If(master.i.valid & master.i.ready):
            m.d.sync += command.eq(master.i.p)
        stays = released & ~master.scl_low
        falls, rises = stays & ~sda_low & master.sda_low, stays & sda_low & ~master.sda_low
        self.promise(m, ~falls | command.start, "a start condition is one that was commanded")
        good = master.o.valid & (master.o.p.result == Failure.NONE)
        self.promise(m, ~good | (master.scl_low == ~command.stop), "SCL is held low within a transfer, and released after it")
        m.d.comb += self.witness.eq(rises & command.stop)


class CheckedRequests(Claim):
    """Nothing is carried out but a request whose six bytes were the last ones accepted, begin with the sync byte and sum to 0."""
    def __init__(self, component: RequestReader):
        super().__init__()
        self.component = component

    def build(self, m: Module) -> None:
        m.submodules.reader = reader = self.component
        self.surround(m, reader)
        taken = reader.i.valid & reader.i.ready
        # Sums of the last bytes, of one, two, and so on; whether these bytes, the last one first, are sync bytes.
        sums, syncs = [Signal(8, name=f"sum_{n}") for n in range(1, FRAME_BYTES + 1)], Signal(FRAME_BYTES)
        written = Signal()
        with m.If(taken):
            m.d.sync += [sums[0].eq(reader.i.p), *(longer.eq(shorter + reader.i.p) for shorter, longer in pairwise(sums))]
            m.d.sync += syncs.eq(Cat(reader.i.p == REQUEST_SYNC, syncs))
        with m.If(reader.access.commit | reader.block.start | (reader.put.start if reader.writes else 0)):
            self.promise(m, sums[-1] == 0, "the sum is right")
            self.promise(m, syncs[-1], "it begins with the sync byte")
        m.d.sync += written.eq(written | (reader.access.commit & reader.access.write))
        m.d.comb += self.witness.eq(written)


class AxiResponses(Claim):
    """Responses hold until they are accepted, one for each access."""
    def __init__(self, component: AxiLite):
        super().__init__()
        self.component = component

    def build(self, m: Module) -> None:
        m.submodules.slave = slave = self.component
        self.surround(m, slave, skip=AXI)
        axi(m, self, slave)
        answered = []
        for channel, names, (valid, ready) in (("b", ["bresp"], (slave.bvalid, slave.bready)),
                                               ("r", ["rdata", "rresp"], (slave.rvalid, slave.rready))):
            payload = Cat(getattr(slave, name) for name in names)
            stalled, before = Signal(name=f"{channel}_stalled"), Signal(len(payload), name=f"{channel}_before")
            m.d.sync += [stalled.eq(valid & ~ready), before.eq(payload)]
            self.promise(m, ~stalled | (valid & (payload == before)), f"{channel} holds")
            done = Signal(name=f"{channel}_done")
            m.d.sync += done.eq(done | (valid & ready))
            answered.append(done)
        # Accesses whose response has not been accepted.
        for name, enters, leaves in (("reads", slave.arvalid & slave.arready, slave.rvalid & slave.rready),
                                     ("addresses", slave.awvalid & slave.awready, slave.bvalid & slave.bready),
                                     ("words", slave.wvalid & slave.wready, slave.bvalid & slave.bready)):
            waiting = Signal(3, name=name)
            m.d.sync += waiting.eq(waiting + enters - leaves)
            self.promise(m, ~leaves | (waiting != 0), f"a response to {name} only")
            self.promise(m, waiting <= 2, f"few {name} wait")
        m.d.comb += self.witness.eq(answered[0] & answered[1])


def _proof(component: type, size: str, claim: str, build: Callable[[], Any], **options: Any) -> Proof:
    return Proof("protocols", f"{component.__module__.removeprefix('hdl.')}.{component.__name__}", claim, size, build, **options)


PROOFS = [
    _proof(ActivePixels, "lines of 2 pixels, fields of 2 lines, any bytes",
           "no pixel outside a line of active video; each frame has its size, or is closed by `drop`",
           lambda: VideoLines(ActivePixels(SMALL_FORMAT)), witness=40),
    _proof(TimingCodes, "whole", "a code with a wrong bit is the one that was sent", lambda: Codes(TimingCodes())),
    _proof(I2cMaster, "4 clocks a bit, any levels of the lines",
           "while SCL is released SDA falls for a start condition only, one that was commanded; SCL is low between the bytes of a transfer",
           lambda: OpenDrain(I2cMaster(400_000)), witness=70),
    _proof(RequestReader, "time-out of 3 cycles, with block writes", "nothing is carried out but a request with the right sum",
           lambda: CheckedRequests(RequestReader(3, writes=True)), quick=False),
    _proof(AxiLite, "whole", "responses hold until they are accepted, one for each access", lambda: AxiResponses(AxiLite())),
]
