# amaranth: UnusedElaboratable=no
import random

import pytest
from amaranth.hdl import ClockDomain, Module
from amaranth.sim import Simulator

from golden.video.tmds import CONTROL_WORDS, encode
from hdl.video.tmds import CLOCK_WORD, DviLink, PairSerializer, TmdsEncoder
from sim.kit.clocked import run_clocked


def words_of(pixels):
    given = run_clocked(TmdsEncoder(), [{"de": int(de), "level": level, "control": control} for de, level, control in pixels], ["word"],
                        drain=TmdsEncoder.LATENCY)
    return [cycle["word"] for cycle in given]


def test_every_byte_and_long_runs():
    """Equals golden: every byte after a control word and after every byte; levels that count in blanking for nothing."""
    rng = random.Random(1)
    pixels = [pixel for level in range(256) for pixel in ((False, rng.randrange(256), rng.randrange(4)), (True, level, rng.randrange(4)))]
    pixels += [(rng.random() < 0.99, rng.randrange(256), rng.randrange(4)) for _ in range(6000)]
    assert words_of(pixels) == [CONTROL_WORDS[0]] * TmdsEncoder.LATENCY + encode(pixels)


@pytest.mark.parametrize("level", [0x00, 0xFF, 0x0F, 0x55])
def test_the_same_level_for_long(level):
    pixels = [(True, level, 0)] * 60
    assert words_of(pixels)[TmdsEncoder.LATENCY:] == encode(pixels)


def test_link():
    """Colours and syncs in their channels; the clock has none of them."""
    rng = random.Random(2)
    names = ("red", "green", "blue", "de", "hsync", "vsync")
    cycles = [dict(zip(names, (*(rng.randrange(256) for _ in range(3)), int(rng.random() < 0.8), *(rng.randrange(2) for _ in range(2)))))
              for _ in range(300)]
    dut = DviLink()
    wanted = [encode([(bool(cycle["de"]), cycle[colour], cycle["hsync"] | cycle["vsync"] << 1 if colour == "blue" else 0)
                      for cycle in cycles]) for colour in ("blue", "green", "red")]
    found = []

    async def testbench(ctx):
        for cycle in cycles:
            for name, value in cycle.items():
                ctx.set(getattr(dut, name), value)
            found.append([ctx.get(word) for word in dut.words])
            await ctx.tick()
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    late = TmdsEncoder.LATENCY
    assert [list(words) for words in zip(*found[late:])] == [*(words[:-late] for words in wanted), [CLOCK_WORD] * (len(cycles) - late)]


@pytest.mark.parametrize("jitter", [0, 0.45])
@pytest.mark.parametrize("phase", [0.0, 0.13, 0.5, 0.77, 0.999])
def test_serializer(phase, jitter):
    """Every word once, whole, the lowest bit first, without a gap, at every phase of the clocks, also where the edges of a clock are up to
    nearly half of a shift clock late. Words do not count within a shift clock of their changes.
    """
    rng = random.Random(3)
    words = [[rng.randrange(1024), rng.randrange(1024), CLOCK_WORD] for _ in range(80)]
    channels = len(words[0])
    dut = PairSerializer(channels)
    bits = []
    late = [5 * (number + 1) + rng.uniform(0, jitter) for number in range(len(words))]
    edges = sorted([(at, "pixel", None) for at in late] +
                   [(at + 0.99, "settled", word) for at, word in zip(late, words)] + [(at - 0.99, "changing", None) for at in late] +
                   [(number + phase, "shift", None) for number in range(5 * len(words) + 10)], key=lambda event: event[0])
    m = Module()
    m.domains += [pixel := ClockDomain("pixel"), shift := ClockDomain("shift", reset_less=True)]
    m.submodules.dut = dut

    async def run(ctx):
        for _, event, word in edges:
            if event in ("settled", "changing"):
                for place, value in enumerate(word or (rng.randrange(1024) for _ in range(channels))):
                    ctx.set(dut.words[place], value)
            elif event == "pixel":
                ctx.set(pixel.clk, 1)
                ctx.set(pixel.clk, 0)
            else:
                ctx.set(shift.clk, 1)
                bits.extend([ctx.get(dut.first), ctx.get(dut.second)])
                ctx.set(shift.clk, 0)
    sim = Simulator(m)
    sim.add_testbench(run)
    sim.run()
    taken = [[sum((levels >> channel & 1) << place for place, levels in enumerate(bits[at:at + 10])) for channel in range(channels)]
             for at in range(len(bits) - 9)]
    first = taken.index(words[2])       # locked in the second word
    found = taken[first::10]
    assert len(found) > len(words) - 6
    assert found[:len(words) - 4] == words[2:len(words) - 2]
