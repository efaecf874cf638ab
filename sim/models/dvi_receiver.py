"""Strict model of a DVI receiver: finds the words in the bits of four channels, checks their code, and hands pixels to a monitor."""

from golden.video.tmds import WORD_BITS, Received, decode, encode_byte

from .monitor import Monitor


__all__ = ["CodeError", "DviReceiver"]


class CodeError(AssertionError):
    """A channel violates DVI's code."""


class DviReceiver:
    """The model itself; :meth:`bits` is called once for each bit.

    Everything before the first rising edge of the clock channel is ignored. From then on its period must be that of a word, high in the
    first half; the data channels must agree on whether there is a pixel, channels 1 and 2 have no control bits, and a pixel's word must be
    the one that DVI 1.0 prescribes after those before it. Otherwise :class:`CodeError` is raised.

    Parameters
    ----------
    monitor : Monitor
        Its :meth:`~sim.models.monitor.Monitor.clock` is called for each word.

    Attributes
    ----------
    words : int
        Words so far.
    """
    def __init__(self, monitor: Monitor):
        self.monitor = monitor
        self.words = 0
        self._known: dict[int, Received] = {}
        self._disparities = [0, 0, 0]
        self._shift = [0, 0, 0, 0]
        self._count: int | None = None      # bits of the present word; not locked
        self._before = 1

    def bits(self, levels: int) -> None:
        """A bit of each channel: blue, green, red, clock, from the lowest one on."""
        clock = levels >> 3 & 1
        if self._count is None:
            if clock and not self._before:
                self._count = 0
            self._before = clock
        if self._count is None:
            return
        for channel in range(4):
            self._shift[channel] |= (levels >> channel & 1) << self._count
        self._count += 1
        if self._count == WORD_BITS:
            self._word(*self._shift)
            self._shift, self._count = [0, 0, 0, 0], 0

    def _word(self, blue: int, green: int, red: int, clock: int) -> None:
        if clock != 0b0000011111:
            raise CodeError(f"word {self.words}: the clock channel has {clock:010b}")
        for word in (blue, green, red):
            if word not in self._known:
                self._known[word] = decode([word])[0]
        received = [self._known[word] for word in (blue, green, red)]
        de = received[0].de
        if any(each.de != de for each in received):
            raise CodeError(f"word {self.words}: the channels have {received}")
        if de:
            for channel, (word, each) in enumerate(zip((blue, green, red), received)):
                wanted, self._disparities[channel] = encode_byte(each.level, self._disparities[channel])
                if word != wanted:
                    raise CodeError(f"word {self.words}, channel {channel}: {word:010b} instead of {wanted:010b}")
        else:
            self._disparities = [0, 0, 0]
            if received[1].control or received[2].control:
                raise CodeError(f"word {self.words}: channels 1 and 2 have control bits")
        control = received[0].control if de is False else 0b11
        self.words += 1
        self.monitor.clock(received[0].level | received[1].level << 8 | received[2].level << 16 | de << 24 | control << 25)
