# amaranth: UnusedElaboratable=no
"""The display in Amaranth's simulator, between a picture reader that follows a plan and a monitor."""

import random
from dataclasses import dataclass, field

from amaranth import *
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from hdl.video.dvi import DisplayOutput
from hdl.video.words import ShownPixel
from sim.kit.cases import pack
from sim.kit.display_cases import SMALL_DISPLAY, Fetch
from sim.models.monitor import Monitor, watch_amaranth


__all__ = ["CONFIG", "LABELS", "SIZE", "Run", "run_display"]


LABELS = 5
CONFIG = MatcherConfig(labels=LABELS)
LAYOUT = ShownPixel(CONFIG)
SIZE = (12, 8)


@dataclass
class Run:
    """What was seen: a picture for each fetch, and at each fetch the settings and, before it, the counters."""
    pictures: list = field(default_factory=list)
    settings: list = field(default_factory=list)
    underflows: list = field(default_factory=list)
    frames: list = field(default_factory=list)
    fill: int = 0
    most: int = 0               # greatest count of underflows


def run_display(plan, *, size=SIZE, display=SMALL_DISPLAY, mode=0, colour=0, depth=16, clocks=(75, 65), change=0.0, reader_skips=False,
                clear=None, reset=None, restart=None):
    """Answer each fetch by an entry of ``plan``.

    ``clocks``: frequencies of ``sync`` and ``display``. ``change``: probability of new settings in each cycle. ``clear``: a function of the
    number of fetches, of cycles since the last one, and of ``fetch``. ``reset``, ``restart``: after so many fetches and cycles ``sync``, or
    ``display``, is reset for ten cycles; ``display`` loses a picture, and another one after an odd number of fetches.
    """
    rng = random.Random(1)
    dut = DisplayOutput(CONFIG, display, *size, depth=depth, reader_skips=reader_skips)
    monitor = Monitor(display)
    m = Module()
    m.domains += (domains := [ClockDomain("sync"), ClockDomain("display")])
    m.submodules.dut = dut
    run = Run()
    payload, knobs = Value.cast(dut.i.payload), Cat(dut.mode, dut.colour)
    settings = mode, colour
    since = 0
    lost = 0 if restart is None else 1 + restart[0] % 2

    async def cycle(ctx, word=None, shown_valid=None):
        """Whether the word was accepted, and whether there was a fetch. Inputs without a meaning are noise."""
        nonlocal since, settings
        now = len(run.settings), since
        if change and rng.random() < change:
            settings = rng.randrange(4), rng.randrange(2)
            ctx.set(knobs, settings[0] | settings[1] << 2)
        if clear is not None:
            ctx.set(dut.clear, clear(*now, ctx.get(dut.fetch)))
        for domain, start in zip(domains, (reset, restart)):
            if start is not None:
                ctx.set(domain.rst, now[0] == start[0] and 0 <= now[1] - start[1] < 10)
        if now == restart:
            monitor.restart()
        if shown_valid is not None:
            ctx.set(dut.shown_valid, shown_valid)
        ctx.set(dut.i.valid, word is not None)
        ctx.set(payload, rng.getrandbits(len(payload)) if word is None else word)
        _, _, ready, fetch, underflows, frames = await ctx.tick().sample(dut.i.ready, dut.fetch, dut.underflows, dut.frames)
        if shown_valid is not None:
            ctx.set(dut.shown_valid, not shown_valid)
        run.most = max(run.most, underflows)
        since += 1
        if fetch:
            run.settings.append(settings)
            run.underflows.append(underflows)
            run.frames.append(frames)
            since = 0
        assert since < 5 * display.h_total * display.v_total, "no fetch"
        return ready, fetch

    async def answer(ctx, entry):
        """Until all is sent and taken, or there is the next fetch: tell if it is."""
        shown_valid = entry.shown_valid
        for word, idle in entry.offers(rng, halves=reader_skips and ctx.get(dut.halves)):
            word, taken = pack(LAYOUT, word), False
            while not taken:
                taken, fetch = await cycle(ctx, None if idle else word, shown_valid)
                shown_valid = None
                if fetch:
                    return True
                if idle:
                    idle, taken = idle - 1, False
        return shown_valid is not None and (await cycle(ctx, None, shown_valid))[1]

    async def reader(ctx):
        ctx.set(knobs, mode | colour << 2)
        fetch = False
        for entry in [*plan, Fetch(plan[0].pair, shown_valid=False, words=[])]:
            while not fetch:
                _, fetch = await cycle(ctx)
            fetch = await answer(ctx, entry)
        while monitor.frames + lost < len(plan):
            await cycle(ctx)
        run.fill = ctx.get(dut.fill)

    simulator = Simulator(m)
    simulator.add_clock(1 / clocks[0])
    simulator.add_clock(1 / clocks[1], domain="display")
    simulator.add_testbench(reader)
    simulator.add_testbench(watch_amaranth(monitor, dut), background=True)
    simulator.run()
    run.pictures = list(monitor.pictures)
    return run
