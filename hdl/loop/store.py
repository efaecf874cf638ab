"""A picture in block RAM: read and written by the system, read by a display in another clock domain."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ..parts.delay import NO_COLLISION


__all__ = ["FrameStore", "StorePort", "row_start", "slice_bits"]


# Words of a block of one bit, as a power of two, and widths of its words: each is as many words fewer.
_ADDRESS_BITS, _WIDTHS = 14, (1, 2, 4, 9, 18)
# Of the blocks that a store takes at least, for a selection among few.
_MORE_BLOCKS = 0.1


def slice_bits(depth: int, bits: int) -> int:
    """Bits of a word that share a memory, such that few blocks are selected from.

    A deep memory of whole words is made of blocks that are as wide as these, and the selection among dozens of them is the longest path of
    the system. Blocks of one bit are the deepest.

    Examples
    --------
    >>> slice_bits(320 * 240, 8), slice_bits(128, 8), slice_bits(2048, 8)
    (1, 8, 8)
    """
    def blocks(width: int, shared: int) -> int:
        place = next(place for place, unit in enumerate(_WIDTHS) if unit >= width or unit == _WIDTHS[-1])
        return -(-bits // shared) * -(-width // _WIDTHS[place]) * -(-depth // (1 << _ADDRESS_BITS - place))

    taken = {min(width, bits): blocks(min(width, bits), min(width, bits)) for width in (*_WIDTHS, bits)}
    return min(width for width, number in taken.items() if number <= (1 + _MORE_BLOCKS) * min(taken.values()))


def row_start(line: Value, width: int) -> Value:
    """Address of a line's first pixel; of additions, so that no multiplier is taken from the matcher.

    Examples
    --------
    >>> row_start(Signal(8), 320).shape()
    unsigned(17)
    """
    terms: list[Value] = [line.shift_left(place) for place in range(width.bit_length()) if width >> place & 1]
    while len(terms) > 1:
        terms = [*(a + b for a, b in zip(terms[::2], terms[1::2])), *([terms[-1]] if len(terms) % 2 else [])]
    return terms[0]


class StorePort(wiring.Signature):
    """Port to a store, from the accessor's view; see :class:`FrameStore`."""
    def __init__(self, depth: int, bits: int):
        super().__init__({"address": Out(range(depth)), "write": Out(1), "data": Out(bits), "found": In(bits)})


class FrameStore(wiring.Component):
    """Words of a picture, line by line from the top.

    Reads and writes of ``port`` have one address, so that one port of a block RAM with two ports serves both, and the display has the
    other.

    Timing: ``port.found`` is the word of the address :attr:`LATENCY` cycles before; a word written in a cycle is found if it is addressed
    in a later one. ``display_found`` is the word of ``display_address`` one cycle of ``pixel`` before;
    undefined if it was being written then.

    Memory: ``depth`` words, in slices of :func:`slice_bits`. A reset does not change them.

    Parameters
    ----------
    depth, bits : int
        Words, and bits of each.
    display : bool
        With the read port in the clock domain ``pixel``.

    Members
    -------
    port : In(StorePort(depth, bits))
    display_address : In(range(depth)), display_found : Out(bits)
        With ``display`` only.
    """
    #: Registers in front of the blocks and behind their selection, and the blocks' own.
    LATENCY = 3

    def __init__(self, depth: int, bits: int, *, display: bool = False):
        self.depth, self.bits, self.display = depth, bits, display
        super().__init__({
            "port": In(StorePort(depth, bits)),
            **({"display_address": In(range(depth)), "display_found": Out(bits)} if display else {}),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        address = Signal.like(self.port.address, reset_less=True)
        data    = Signal(self.bits, reset_less=True)
        write   = Signal()
        found   = Signal(self.bits, reset_less=True)
        m.d.sync += [address.eq(self.port.address), data.eq(self.port.data), write.eq(self.port.write)]
        m.d.comb += self.port.found.eq(found)
        shared = slice_bits(self.depth, self.bits)
        for low in range(0, self.bits, shared):
            part = slice(low, low + shared)
            width = len(data[part])
            name = "memory" if width == self.bits else f"memory_{low}"
            m.submodules[name] = memory = Memory(shape=width, depth=self.depth, init=[], attrs=NO_COLLISION)
            reader, writer = memory.read_port(), memory.write_port()
            m.d.sync += found[part].eq(reader.data)
            m.d.comb += [reader.addr.eq(address), reader.en.eq(~write),
                         writer.addr.eq(address), writer.data.eq(data[part]), writer.en.eq(write)]
            if self.display:
                shown = memory.read_port(domain="pixel")
                m.d.comb += [shown.addr.eq(self.display_address), shown.en.eq(1), self.display_found[part].eq(shown.data)]
        return m
