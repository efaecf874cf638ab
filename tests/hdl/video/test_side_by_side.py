# amaranth: UnusedElaboratable=no
import numpy as np
import pytest
from amaranth.hdl import ClockDomain, DomainRenamer, Module
from amaranth.lib.memory import Memory
from amaranth.sim import Simulator

from golden.video.formats import DisplayFormat
from golden.video.side_by_side import side_by_side
from golden.video.tmds import encode
from hdl.video.side_by_side import SideBySide
from hdl.video.tmds import DviLink, PairSerializer
from sim.models.dvi_receiver import CodeError, DviReceiver
from sim.models.monitor import Monitor, watch_amaranth


SMALL = DisplayFormat(18, range(20, 22), 24, 10, range(11, 13), 14, 25_000_000)


def pictures(width, height, labels, seed=1):
    rng = np.random.default_rng(seed)
    return rng.integers(0, 256, (height, width)), rng.integers(0, labels, (height, width)), rng.random((height, width)) < 0.8


def with_memory(left, label, known, labels, display=SMALL):
    """The component with a memory that holds the pictures, in the domain ``pixel``."""
    height, width = left.shape
    m = Module()
    m.domains += ClockDomain("pixel")
    m.submodules.screen = screen = DomainRenamer("pixel")(SideBySide(display, width, height, labels))
    words = [int(grey) | int(number) << 8 | int(there) << 16 for grey, number, there in zip(left.flat, label.flat, known.flat)]
    m.submodules.store = store = Memory(shape=17, depth=len(words), init=words)
    read = store.read_port(domain="pixel")
    m.d.comb += read.addr.eq(screen.address)
    m.d.comb += [screen.left.eq(read.data[:8]), screen.label.eq(read.data[8:16]), screen.known.eq(read.data[16])]
    return m, screen


@pytest.mark.parametrize("size, labels", [((9, 10), 16), ((5, 3), 2), ((4, 10), 256), ((18, 7), 5), ((19, 21), 80), ((40, 5), 7)])
def test_picture(size, labels):
    """Equals golden on every pixel of every frame, with the timing of the format: whole display, odd margins, every n-th pixel."""
    width, height = size
    shown = pictures(width, height, labels)
    m, screen = with_memory(*shown, labels)
    monitor = Monitor(SMALL)
    sim = Simulator(m)
    sim.add_clock(1e-6, domain="pixel")
    sim.add_process(watch_amaranth(monitor, screen, domain="pixel"))
    sim.run_until(1e-6 * 2.2 * SMALL.h_total * SMALL.v_total)
    assert monitor.frames == 2
    for picture in monitor.pictures:
        np.testing.assert_array_equal(picture, side_by_side(*shown, SMALL, labels))


def test_at_the_connector():
    """The four channels' bits, as a strict receiver decodes them, are the picture."""
    labels = 16
    shown = pictures(9, 6, labels)
    m, screen = with_memory(*shown, labels)
    m.domains += ClockDomain("shift", reset_less=True)
    m.submodules.link = link = DomainRenamer("pixel")(DviLink())
    m.submodules.serializer = serializer = PairSerializer(4)
    m.d.comb += [getattr(link, name).eq(getattr(screen, name)) for name in ("red", "green", "blue", "de", "hsync", "vsync")]
    m.d.comb += [to.eq(word) for to, word in zip(serializer.words, link.words)]
    receiver = DviReceiver(Monitor(SMALL))

    async def receive(ctx):
        for _ in range(20):
            await ctx.tick("shift")
        async for _, _, first, second in ctx.tick("shift").sample(serializer.first, serializer.second):
            receiver.bits(first)
            receiver.bits(second)
    sim = Simulator(m)
    sim.add_clock(40e-9, domain="pixel")
    sim.add_clock(8e-9, domain="shift", phase=3e-9)
    sim.add_testbench(receive, background=True)
    sim.run_until(40e-9 * 1.2 * SMALL.h_total * SMALL.v_total)
    assert receiver.monitor.frames == 1
    np.testing.assert_array_equal(receiver.monitor.pictures[0], side_by_side(*shown, SMALL, labels))


@pytest.mark.parametrize("fault, told", [
    ({"clock": 0b0000111111}, r"^word 1: the clock channel has 0000111111$"),
    ({"green": encode([(False, 0, 0)])[0]}, r"^word 1: the channels have"),
    ({"red": 0b1111111111}, r"^word 1, channel 2: 1111111111 instead of 0100000000$"),
    ({"blue": encode([(False, 0, 0)])[0], "green": encode([(False, 0, 1)])[0], "red": encode([(False, 0, 0)])[0]},
     r"^word 1: channels 1 and 2 have control bits$"),
])
def test_receiver_is_strict(fault, told):
    blank = {name: encode([(False, 0, 0)])[0] for name in ("blue", "green", "red")} | {"clock": 0b0000011111}
    pixel = dict.fromkeys(("blue", "green", "red"), 0b0100000000) | {"clock": 0b0000011111}
    receiver = DviReceiver(Monitor(SMALL))
    with pytest.raises(CodeError, match=told):
        for words in (blank, blank, pixel | fault):     # the first one is not known to be whole
            for place in range(10):
                receiver.bits(sum((words[name] >> place & 1) << channel for channel, name in enumerate(("blue", "green", "red", "clock"))))
