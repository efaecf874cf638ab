"""`console rectify`: the maps of mounted cameras, loaded into the running chip, verified and put in use."""

import time
from collections.abc import Iterator, Sequence

from rich.progress import Progress, TaskID

from golden.cli import progress
from golden.errors import UserError
from golden.notes import note
from golden.rig.files import Rig
from golden.rig.lines import check_lines
from golden.rig.maps import SUM_BITS, map_sum, pack

from .chip import Chip


__all__ = ["check_rectifiers", "load_rig", "requests"]


# While maps wait for a pair: readings of `map_swapping`, and seconds between two.
_READINGS = 100
_PAUSE = 0.05

# Seconds in which pairs, 25 a second and more, show that the rectifiers can run the maps.
_TRIAL = 1.0

# How often a side is loaded before its wrong sum is told, and both are before a swap that may have been done twice is.
_LOADS = 2
_SWAPS = 3

_PARTS = ("map_low", "map_middle", "map_high")


def requests(word: int, held: dict[str, int]) -> Iterator[tuple[str, int]]:
    """The registers to be written before ``map_next`` writes a word of 36 bits, with their values.

    Parameters
    ----------
    word : int
    held : dict of str to int
        Values that the chip holds, by register; these are not sent again. Updated.

    Examples
    --------
    >>> held = {}
    >>> [*requests(0x800000001, held)]
    [('map_low', 1), ('map_middle', 0), ('map_high', 8)]
    >>> [*requests(0x800000003, held)]
    [('map_low', 3)]
    """
    for place, name in enumerate(_PARTS):
        value = word >> SUM_BITS * place & ((1 << SUM_BITS) - 1)
        if held.get(name) != value:
            yield name, value
            held[name] = value


def check_rectifiers(chip: Chip) -> int:
    """Lines that the chip's rectifiers hold; :class:`UserError` if it has none."""
    lines = chip.read("rectify_lines")
    if not lines:
        raise UserError("the chip has no rectifiers: rectify_lines is 0, and 22 are needed at least; use a build that has them")
    return lines


def _check(chip: Chip, rig: Rig) -> int:
    lines = check_rectifiers(chip)
    size = chip.read("width"), chip.read("height")
    if rig.size != size:
        raise UserError(f"the rig is for pictures of {'x'.join(map(str, rig.size))} pixels, and the chip's have {size[0]}x{size[1]}; "
                        "calibrate at this size")
    try:
        check_lines([rig.left, rig.right], lines)
    except ValueError as error:
        raise UserError(str(error)) from None
    return lines


def _await_swap(chip: Chip) -> None:
    """Wait until no maps wait for a pair; :class:`UserError` if none is received."""
    for _ in range(_READINGS):
        if not chip.read("map_swapping"):
            return
        time.sleep(_PAUSE)
    raise UserError(f"no pair of pictures was received in {_READINGS * _PAUSE:g} s, for which the maps in the chip wait (map_swapping "
                    "is 1); check the cameras, see left_signal, right_signal and pairs")


def _write_side(chip: Chip, words: Sequence[int], bar: Progress, task: TaskID) -> bool:
    """Write the words of the side that ``map_side`` tells; whether the chip's sums are right."""
    held: dict[str, int] = {}
    room = 1 << (len(words) - 1).bit_length()   # of the chip's memory, words
    first = 0
    while first < len(words):
        chip.write("map_address", first)
        chip.write("map_start", 1)
        for last in range(first, len(words)):
            for name, value in requests(words[last], held):
                chip.write(name, value)
            before = chip.repeated
            chip.write("map_next", 1)
            again = chip.repeated - before
            bar.update(task, completed=last + 1)
            if again:
                break
        # Where the reply to `map_next` was lost, the word may have been written once or as often as it was sent. The sum of either is
        # good: the words after it are written from their address on.
        sent = words[first:last + 1]
        if chip.read("map_sum") not in {map_sum([*sent, *[words[last]] * more]) for more in range(again + 1)}:
            return False
        if last + 1 + again > room:
            return False    # the first words may be written over
        first = last + 1
    return True


def _write_maps(chip: Chip, rig: Rig) -> None:
    """Write both maps to where those are that are not in use; :class:`UserError` if a sum is wrong."""
    with progress() as bar:
        for number, (side, which) in enumerate((("left", rig.left), ("right", rig.right))):
            words = pack(which)
            task = bar.add_task(f"{side} map", total=len(words))
            for _ in range(_LOADS):
                chip.write("map_side", number)
                if _write_side(chip, words, bar, task):
                    break
            else:
                raise UserError(f"the {side} map was loaded {_LOADS} times, and its sum was wrong each time; the maps in use are those "
                                "from before: check the wires, or choose a lower --baud")


def _swap(chip: Chip, rig: Rig) -> None:
    """Write both maps and put them in use."""
    for _ in range(_SWAPS):
        _write_maps(chip, rig)
        chip.write("row_offset", rig.row_offset)
        before = chip.repeated
        chip.write("map_swap", 1)
        again = chip.repeated - before
        _await_swap(chip)
        if not again:
            return
        # A second swap after a pair puts the old maps back. Whichever are in use: the others are written, and are the right ones, too.
    raise UserError(f"the reply to map_swap was lost {_SWAPS} times, so that the maps in use may be those from before; check the wires, "
                    "and load them again")


def load_rig(chip: Chip, rig: Rig) -> str:
    """Load the maps of both cameras and put them in use; the maps in use stay so until the sums of both are right.

    Parameters
    ----------
    chip : Chip
    rig : Rig

    Returns
    -------
    str
        What is in use, in a line. :class:`UserError` if the chip has no rectifiers, or cannot run these maps; if no pair of pictures is
        received; if a sum is wrong twice; if the rectifiers report that a map needs more lines than they hold.
    """
    lines = _check(chip, rig)
    _await_swap(chip)
    _swap(chip, rig)
    abandoned = chip.read("map_abandoned")
    time.sleep(_TRIAL)
    fault = chip.read("map_fault")
    if chip.read("map_abandoned") > abandoned:
        raise UserError(f"the maps are in use, but the chip does not rectify pairs to their end: they need more than its {lines} lines; "
                        "calibrate again, and load that")
    if fault:
        note("map_fault is 1, because of these maps or of those before: set clear_counters=1, and get map_fault")
    switched = "" if chip.read("rectify") else "; rectification is off: set rectify=1"
    return (f"{rig.size[0]}x{rig.size[1]} pixels, {rig.lines} lines of {lines}, the right picture moved by {rig.row_offset} lines: "
            f"maps {chip.registers['map'].text(chip.read('map'))}, map_fault {chip.registers['map_fault'].text(fault)}{switched}")
