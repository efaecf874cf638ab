"""Pictures in block RAM: read and written by the system, read by a display in another clock domain."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.host.blocks import SENT_PLANES

from ..parts.delay import NO_COLLISION
from .words import FLAG_BITS, StoredResult, Stores, shown_known, shown_label


__all__ = ["BlockStores", "FrameStore", "StorePort", "row_start", "slice_bits", "slices"]


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


def slices(depth: int, bits: int) -> list[int]:
    """Widths of the memories of a store of whole words.

    Examples
    --------
    >>> slices(320 * 240, 3), slices(50, 8)
    ([1, 1, 1], [8])
    """
    shared = slice_bits(depth, bits)
    return [min(shared, bits - low) for low in range(0, bits, shared)]


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
        low = 0
        for width in slices(self.depth, self.bits):
            part = slice(low, low + width)
            name = "memory" if width == self.bits else f"memory_{low}"
            m.submodules[name] = memory = Memory(shape=width, depth=self.depth, init=[], attrs=NO_COLLISION)
            reader, writer = memory.read_port(), memory.write_port()
            m.d.sync += found[part].eq(reader.data)
            m.d.comb += [reader.addr.eq(address), reader.en.eq(~write),
                         writer.addr.eq(address), writer.data.eq(data[part]), writer.en.eq(write)]
            if self.display:
                shown = memory.read_port(domain="pixel")
                m.d.comb += [shown.addr.eq(self.display_address), shown.en.eq(1), self.display_found[part].eq(shown.data)]
            low += width
        return m


class BlockStores(Stores):
    """A :class:`FrameStore` for each picture and for the results.

    Timing: everything is accepted at once, but a ``read`` in the cycle of a ``write``; words are found :attr:`FrameStore.LATENCY` cycles
    after their request.

    Parameters
    ----------
    config, height
        As of :class:`hdl.loop.words.Stores`.
    display : bool
        With read ports in the clock domain ``pixel``.

    Members
    -------
    busy, write, scan, read, results
        As of :class:`hdl.loop.words.Stores`.
    display_address : In(range(max_width * height)), display_left : Out(8), display_label : Out(range(labels)), display_known : Out(1)
        With ``display`` only, in the domain ``pixel``, asynchronous to ``sync``: left grey level and label of the place
        ``y * max_width + x``, a cycle after its address. ``display_known``: whether the label passed the check of methods
        that have one. Undefined while written.
    """
    # Those of the stores' latency, the queue's, and the cycle in which a place in it is known to be free.
    ahead = 8
    about = "memory blocks"

    def __init__(self, config: MatcherConfig, height: int, *, display: bool = False):
        depth = config.max_width * height
        self.display = display
        super().__init__(config, height, {
            "display_address": In(range(depth)), "display_left": Out(PIXEL_BITS), "display_label": Out(range(config.labels)),
            "display_known": Out(1),
        } if display else {})
        self.left, self.right = FrameStore(depth, PIXEL_BITS, display=display), FrameStore(depth, PIXEL_BITS)
        self.result = FrameStore(depth, StoredResult(config).size, display=display)

    def pair_clocks(self, width: int, height: int) -> int:
        return 0

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.left, m.submodules.right, m.submodules.results = left, right, result = self.left, self.right, self.result
        scan, read, write, results = self.scan, self.read, self.write, self.results
        m.d.comb += [scan.request.ready.eq(1), results.ready.eq(1), write.ready.eq(~self.busy)]
        m.d.comb += read.request.ready.eq(~self.busy & ~write.valid)

        sent = write.p
        for plane, store in zip(range(len(SENT_PLANES)), (left, right)):
            port = store.port
            m.d.comb += port.data.eq(sent.level)
            with m.If(self.busy):
                m.d.comb += port.address.eq(scan.request.p.address)
            with m.Elif(write.valid):
                m.d.comb += [port.address.eq(sent.address), port.write.eq(sent.plane == plane)]
            with m.Else():
                m.d.comb += port.address.eq(read.request.p.address)
        port = result.port
        m.d.comb += [
            port.address.eq(Mux(self.busy, results.p.address, read.request.p.address)), port.write.eq(results.valid),
            port.data.eq(results.p.result.as_value()),
        ]

        # Flags travel beside the words.
        for name, reader in (("scan", scan), ("read", read)):
            valid, flags = reader.request.valid & reader.request.ready, reader.request.p.flags
            for number in range(FrameStore.LATENCY):
                next_valid = Signal(name=f"{name}_valid_{number}")
                next_flags = Signal(FLAG_BITS, name=f"{name}_flags_{number}", reset_less=True)
                m.d.sync += [next_valid.eq(valid), next_flags.eq(flags)]
                valid, flags = next_valid, next_flags
            found = reader.found
            m.d.comb += [
                reader.valid.eq(valid), reader.flags.eq(flags), found.left.eq(left.port.found), found.right.eq(right.port.found),
                found.result.as_value().eq(result.port.found),
            ]

        if self.display:
            shown = Signal(StoredResult(self.config))
            m.d.comb += [
                left.display_address.eq(self.display_address), result.display_address.eq(self.display_address),
                self.display_left.eq(left.display_found), shown.as_value().eq(result.display_found),
                self.display_label.eq(shown_label(shown, self.config)), self.display_known.eq(shown_known(shown, self.config)),
            ]
        return m
