"""Shared by arrays of costs: groups of labels, the least of a group, the right picture along the labels, a line memory."""

from collections.abc import Iterator, Sequence

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ...parts.delay import NO_COLLISION, data_register
from ...parts.line_memory import BLOCK_SHAPES
from .waves import Pixel


__all__ = ["LABELS_PER_GROUP", "TREE", "LabelMemory", "Queued", "groups_of", "least_of", "seen_along", "tree_of", "word_bits"]


#: Labels that work in the same cycle.
LABELS_PER_GROUP = 4


def tree_of(labels: int) -> int:
    """Levels of the tree of a group of ``labels`` labels, each a register."""
    return (labels - 1).bit_length()


#: Levels of a group's tree.
TREE = tree_of(LABELS_PER_GROUP)


def least_of(m: Module, values: Sequence[Value], first: int, least_i: data.View, least_o: data.View,
             labels_per_group: int = LABELS_PER_GROUP, prefix: str = "", beside: Sequence[Value] | None = None) -> None:
    """The least of a group and of those below it; all are complements, hence the greatest. The smaller label wins a tie.

    ``least_i`` is due :func:`tree_of` ``labels_per_group`` cycles after ``values``, ``least_o`` is valid a cycle later. ``prefix``: of the
    names of signals. ``beside``, with ``values``: what goes along with each, in a field of that name.
    """
    # In order of labels.
    rivals = [(value, Const(0, 0)) for value in values]
    besides = list(beside or ())
    for level in range(tree_of(labels_per_group)):
        winners = []
        for n in range(0, len(rivals), 2):
            value = Signal.like(values[0], name=f"{prefix}least_{level}_{n // 2}", reset_less=True)
            index = Signal(level + 1, name=f"{prefix}label_{level}_{n // 2}", reset_less=True)
            (low, low_index), (high, high_index) = rivals[n], rivals[min(n + 1, len(rivals) - 1)]
            above = high > low
            m.d.sync += [value.eq(Mux(above, high, low)), index.eq(Mux(above, Cat(high_index, Const(1, 1)), low_index))]
            winners.append((value, index))
            if beside:
                later = Signal.like(besides[n], name=f"{prefix}beside_{level}_{n // 2}", reset_less=True)
                m.d.sync += later.eq(Mux(above, besides[min(n + 1, len(rivals) - 1)], besides[n]))
                besides[n // 2] = later     # those before it have been used
        rivals, besides = winners, besides[:len(winners)]
    (value, index), = rivals
    register = data_register(m, least_o)
    along = [register.beside.eq(besides[0])] if beside else []
    if first == 0:
        m.d.sync += [register.value.eq(value), register.index.eq(index), *along]
    else:
        with m.If(value > least_i.value):
            m.d.sync += [register.value.eq(value), register.index.eq(first + index), *along]
        with m.Else():
            m.d.sync += register.eq(least_i)


def groups_of(config: MatcherConfig, labels_per_group: int = LABELS_PER_GROUP) -> list[range]:
    """The labels of each group."""
    return [range(low, min(low + labels_per_group, config.labels)) for low in range(0, config.labels, labels_per_group)]


def seen_along(m: Module, labels: range, i: data.View, o: data.View, *,
               registered: bool = True) -> Iterator[tuple[int, dict[str, Value], Value]]:
    """The right columns of the labels of a group; passes the wave on to the group above, a cycle later.

    Parameters
    ----------
    m : Module
    labels : range
    i, o : View of Wave
        From the group below, to the group above.
    registered : bool
        ``o`` has a register of its own; else it is there in the same cycle, and the group above registers it.

    Yields
    ------
    label : int
    seen : dict of str to Value
        The wave's fields of the right picture at ``x - label``.
    inside : Value
        Whether that is inside the picture, and the label is in use.
    """
    shape = i.shape()
    seen, inside = {name: i[name] for name in shape.members if name.startswith("right")}, i.inside
    for label in labels:
        yield label, seen, inside & (i.in_use > label)
        # The next label compares one pixel further left: the right column of the wave before.
        before = {name: Signal.like(value, name=f"{name}_{label}", reset_less=True) for name, value in seen.items()}
        before_inside = Signal(name=f"inside_{label}", reset_less=True)
        with m.If(i.valid):
            m.d.sync += [register.eq(seen[name]) for name, register in before.items()]
            m.d.sync += before_inside.eq(inside)
        seen, inside = before, before_inside & ~i.pre
    moved = {name: i[name] for name in shape.members if name != "valid"} | seen | {"inside": inside}
    if registered:
        m.d.sync += o.valid.eq(i.valid)
        m.d.sync += [data_register(m, o[name], f"o_{name}").eq(value) for name, value in moved.items()]
    else:
        m.d.comb += o.valid.eq(i.valid)
        m.d.comb += [o[name].eq(value) for name, value in moved.items()]


class Queued(data.StructLayout):
    """A pixel to be labelled, and the local disparity of the one below it."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"pixel": Pixel(), "local": range(config.labels)})


def word_bits(depth: int) -> int:
    """Bits of the words of a line memory of ``depth`` words: those of two memory blocks of 9 kbit side by side, or of one of 18 kbit.

    Wider ones need more registers for the labels that are read with their word's first one.

    Examples
    --------
    >>> word_bits(256), word_bits(834), word_bits(2034)
    (36, 18, 8)
    """
    of_block = max((bits for words, bits in BLOCK_SHAPES if words >= depth), default=1)
    return min(2 * of_block, 36)


class LabelMemory(wiring.Component):
    """A line of data terms: written group by group of labels, read label by label.

    The bits of all labels, one label behind the other, are cut into words of whole memory blocks: the word of a memory begins within a
    label and ends within the same or a later one. It is read as its first label is due, and written with its last one.

    Timing: ``words`` of a group are due a cycle after those of the group below it, those of label 0 with ``write``. What was written
    ``n``-th is read at ``address`` ``n % depth``; that of label ``d`` is at ``o[d]`` ``d + 2`` cycles after ``address``.

    Memory: ``D * depth`` words.

    Members
    -------
    write : In(1)
    words : In(ArrayLayout(data_bits, D))
    address : In(range(depth))
    o : Out(ArrayLayout(data_bits, D))
    """
    def __init__(self, config: MatcherConfig, depth: int):
        self.config = config
        self.depth = depth
        words = data.ArrayLayout(config.data_bits, config.labels)
        super().__init__({"write": In(1), "words": In(words), "address": In(range(depth)), "o": Out(words)})

    @staticmethod
    def skew_of(config: MatcherConfig) -> int:
        """Cycles by which the top label's reading is later than that of label 0, beyond those of its writing."""
        return config.labels - len(groups_of(config))

    def parts(self) -> dict[int, list[tuple[int, range]]]:
        """The memories: the first label of each to the labels in a word of it, from the lowest bit on, each with the bits of it."""
        bits, labels = self.config.data_bits, self.config.labels
        width = word_bits(self.depth)
        found: dict[int, list[tuple[int, range]]] = {}
        for low in range(0, labels * bits, width):
            high = min(low + width, labels * bits)
            first, last = low // bits, (high - 1) // bits
            found.setdefault(first, []).extend(
                (label, range(max(low - label * bits, 0), min(high - label * bits, bits))) for label in range(first, last + 1))
        return found

    def elaborate(self, platform: object) -> Module:
        m = Module()
        depth = self.depth
        group_of = [number for number, labels in enumerate(groups_of(self.config)) for _ in labels]

        # The address of the next words, passed from group to group as the waves are; that of the words read, from label to label.
        place = Signal(range(depth))
        with m.If(self.write):
            m.d.sync += place.eq(Mux(place == depth - 1, 0, place + 1))
        writes, write_places, read_places = [self.write], [place], [self.address]
        for group in range(1, group_of[-1] + 1):
            writes.append(Signal(name=f"write_{group}"))
            write_places.append(Signal(range(depth), name=f"write_place_{group}", reset_less=True))
            m.d.sync += [writes[-1].eq(writes[-2]), write_places[-1].eq(write_places[-2])]
        for label in range(1, self.config.labels):
            read_places.append(Signal(range(depth), name=f"read_place_{label}", reset_less=True))
            m.d.sync += read_places[-1].eq(read_places[-2])

        pieces: dict[int, list[Value]] = {}
        for first, parts in self.parts().items():
            group = group_of[parts[-1][0]]
            words: list[Value] = []
            for number, (label, bits) in enumerate(parts):
                piece: Value = self.words[label][bits.start:bits.stop]
                for stage in range(group - group_of[label]):
                    early = Signal(len(bits), name=f"early_{first}_{number}_{stage}", reset_less=True)
                    m.d.sync += early.eq(piece)
                    piece = early
                words.append(piece)
            m.submodules[f"memory_{first}"] = memory = Memory(
                shape=sum(map(len, words)), depth=depth, init=[], attrs=NO_COLLISION)
            write_port, read_port = memory.write_port(), memory.read_port()
            m.d.comb += [
                write_port.en.eq(writes[group]), write_port.addr.eq(write_places[group]), write_port.data.eq(Cat(words)),
                read_port.en.eq(1), read_port.addr.eq(read_places[first]),
            ]
            word = Signal(len(read_port.data), name=f"word_{first}", reset_less=True)
            m.d.sync += word.eq(read_port.data)
            low = 0
            for number, (label, bits) in enumerate(parts):
                piece = word[low:low + len(bits)]
                for stage in range(label - first):
                    skew = Signal(len(bits), name=f"skew_{first}_{number}_{stage}", reset_less=True)
                    m.d.sync += skew.eq(piece)
                    piece = skew
                pieces.setdefault(label, []).append(piece)
                low += len(bits)
        m.d.comb += [self.o[label].eq(Cat(values)) for label, values in pieces.items()]
        return m
