"""DVI's code, TMDS: the words of the three channels, and their bits in pairs for a pin with a double data rate."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from golden.video.tmds import CONTROL_WORDS, WORD_BITS


__all__ = ["CHANNELS", "DviLink", "PairSerializer", "TmdsEncoder"]


#: Channels in the order of DVI, and their colours; the clock is a fourth one, with the constant word :data:`CLOCK_WORD`.
CHANNELS = ("blue", "green", "red")
#: High in the first half of a pixel.
CLOCK_WORD = 0b0000011111


def _ones(bits: Value) -> Value:
    """How many of eight bits are 1: a balanced tree."""
    pairs = [bits[place] + bits[place + 1] for place in range(0, 8, 2)]
    return (pairs[0] + pairs[1]) + (pairs[2] + pairs[3])


class TmdsEncoder(wiring.Component):
    """A channel's words. Golden: :func:`golden.video.tmds.encode`.

    Timing: latency :attr:`LATENCY` cycles, a word a cycle; ``word`` is registered. After reset it is the control word 0.

    Parameters
    ----------
    controlled : bool
        Whether the channel has control bits; those of others are 0.

    Members
    -------
    level : In(8)
        Of a pixel; counts where ``de`` is high.
    control : In(2)
        Counts where it is low; only if ``controlled``.
    de : In(1)
    word : Out(10)
        The lowest bit is sent first.
    """
    LATENCY = 2

    def __init__(self, controlled: bool = True):
        self.controlled = controlled
        super().__init__({"level": In(PIXEL_BITS), **({"control": In(2)} if controlled else {}), "de": In(1),
                          "word": Out(WORD_BITS, init=CONTROL_WORDS[0])})

    def elaborate(self, platform: object) -> Module:
        m = Module()

        # Few transitions: each bit is the XOR of the byte's bits up to it; with XNOR in its place every second bit is inverted.
        ones = Signal(4)
        by_xor = Signal()
        sums = [self.level[0]]
        for bit in self.level[1:]:
            sums.append(sums[-1] ^ bit)
        m.d.comb += [ones.eq(_ones(self.level)), by_xor.eq(~((ones > 4) | ((ones == 4) & ~self.level[0])))]
        minimised = Signal(PIXEL_BITS, reset_less=True)
        xor, de = Signal(reset_less=True), Signal()
        blank: Value | int = CONTROL_WORDS[0]
        if self.controlled:
            control = Signal(2)
            m.d.sync += control.eq(self.control)
            blank = Array(CONTROL_WORDS)[control]
        m.d.sync += [
            minimised.eq(Cat(bit ^ (~by_xor if place % 2 else 0) for place, bit in enumerate(sums))),
            xor.eq(by_xor), de.eq(self.de),
        ]

        # As many ones as zeros: half of what the words so far have more of, and half of what these eight bits have more of.
        running = Signal(signed(4))
        excess, change = Signal(signed(4)), Signal(signed(4))
        inverted = Signal()
        m.d.comb += excess.eq(_ones(minimised) - 4)
        with m.If((running == 0) | (excess == 0)):
            m.d.comb += inverted.eq(~xor)
        with m.Else():
            m.d.comb += inverted.eq(running[-1] == excess[-1])
        # The two upper bits count too: they are equal, or make up for one another.
        with m.If(inverted):
            m.d.comb += change.eq(Mux(xor, 1, 0) - excess)
        with m.Else():
            m.d.comb += change.eq(excess - Mux(xor, 0, 1))
        with m.If(de):
            m.d.sync += [
                self.word.eq(Cat(minimised ^ inverted.replicate(PIXEL_BITS), xor, inverted)),
                running.eq(running + change),
            ]
        with m.Else():
            m.d.sync += [self.word.eq(blank), running.eq(0)]
        return m


class DviLink(wiring.Component):
    """Pixels and syncs as the words of DVI's channels, blue with the syncs first.

    Timing: :attr:`TmdsEncoder.LATENCY` cycles, a pixel a cycle.

    Members
    -------
    red, green, blue : In(8), de, hsync, vsync : In(1)
        A pixel, whether it is in the active area, and the levels of the sync signals.
    words : Out(10), four of them
        Of the :data:`CHANNELS`, and of the clock.
    """
    def __init__(self) -> None:
        super().__init__({
            **{colour: In(PIXEL_BITS) for colour in CHANNELS},
            "de": In(1), "hsync": In(1), "vsync": In(1),
            "words": Out(WORD_BITS).array(len(CHANNELS) + 1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        for number, colour in enumerate(CHANNELS):
            m.submodules[colour] = encoder = TmdsEncoder(controlled=number == 0)
            m.d.comb += [encoder.level.eq(getattr(self, colour)), encoder.de.eq(self.de), self.words[number].eq(encoder.word)]
            if encoder.controlled:
                m.d.comb += encoder.control.eq(Cat(self.hsync, self.vsync))
        m.d.comb += self.words[len(CHANNELS)].eq(CLOCK_WORD)
        return m


class PairSerializer(wiring.Component):
    """Words of the domain ``pixel`` as pairs of bits in the domain ``shift``, whose clock is five times as fast, from the same PLL.

    The phase between the clocks does not matter: a toggle of ``pixel`` is watched in ``shift``, and words are taken where they have been
    stable for a cycle and will be for one, also if the toggle is seen a cycle early or late now and then.

    Timing: 4 to 8 cycles of ``shift`` from a word to its first pair; a pair a cycle, without gaps.

    Parameters
    ----------
    channels : int

    Members
    -------
    words : In(10), ``channels`` of them
        In ``pixel``.
    first, second : Out(channels)
        In ``shift``: the bits of each channel that are sent in the two halves of a cycle.
    """
    PAIRS = WORD_BITS // 2

    def __init__(self, channels: int):
        self.channels = channels
        super().__init__({"words": In(WORD_BITS).array(channels), "first": Out(channels), "second": Out(channels)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        toggle, seen, before = Signal(), Signal(), Signal()
        m.d.pixel += toggle.eq(~toggle)
        m.submodules.synchronizer = FFSynchronizer(toggle, seen, o_domain="shift")
        m.d.shift += before.eq(seen)

        # Seen in the phases 4, 0 and 1, the edge is where it should be; otherwise the count begins anew.
        phase = Signal(range(self.PAIRS))
        load = Signal()
        m.d.comb += load.eq(phase == 0)
        m.d.shift += phase.eq(Mux(phase == self.PAIRS - 1, 0, phase + 1))
        with m.If((seen != before) & ((phase == 2) | (phase == 3))):
            m.d.shift += phase.eq(1)
        for channel in range(self.channels):
            rest = Signal(WORD_BITS, name=f"rest_{channel}", reset_less=True)
            m.d.shift += rest.eq(Mux(load, self.words[channel], rest >> 2))
            m.d.comb += [self.first[channel].eq(rest[0]), self.second[channel].eq(rest[1])]
        return m
