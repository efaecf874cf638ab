"""Counts as a table and as JSON."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import median
from typing import Any

from rich.table import Table

from golden.tables import print_table

from .clock import Clock
from .count import FIGURES, Count, Resources
from .devices import Device
from .estimate import LOGIC_ERROR


__all__ = [
    "ESTIMATED", "THESIS", "TITLES", "as_json", "classes_table", "clock_text", "counting", "seeds_text", "show", "system_table", "table",
    "tree",
]


#: Table 2 of the thesis, at 720x576 and 80 disparities. It gives no number of memory blocks.
THESIS = {"logic_elements": 66_123, "memory_bits": 1_901_632, "multipliers_9x9": 480}

#: What an estimate is.
ESTIMATED = (f"Estimate: logic elements within {LOGIC_ERROR} % of our count with 64 disparities or more, and up to 11 % above it with few; "
             "memory blocks at most 2 % above it, and multipliers as counted.")

_MANY = 4
TITLES = {"logic_elements": "logic elements", "memory_bits": "memory bits", "m9k": "M9K", "multipliers_9x9": "9x9 multipliers"}


def counting(count: Count) -> str:
    """How it is counted, and the bounds of the error; or how it is estimated."""
    if not count.kinds:
        return ESTIMATED
    kinds = count.kinds
    total = count.total.logic_elements
    return (
        "Method: the Verilog as it is delivered, flattened and mapped by Yosys and ABC; no vendor tool took part. "
        f"{kinds['tables']:,} tables of 4 inputs, {kinds['carry_elements']:,} carry elements (one a bit; one more where a carry goes to "
        f"more than one place) and {kinds['registers']:,} registers, of which {kinds['packed_registers']:,} share the element that feeds "
        "them. A register shares even if its element feeds others too: an element of this family has both outputs. Clock enable and "
        "synchronous clear need no table. "
        f"{kinds['registers_in_blocks']:,} registers are those that multipliers and memory blocks have at their outputs. "
        "A table counts for the block that it leads to; if these are several, for the block around them. "
        "Memory bits: words times bits of the memories in memory blocks; smaller ones are registers.\n"
        "Error: packing registers with unrelated tables too gives at best "
        f"{count.least:,} logic elements ({_percent(count.least, total)}), packing only where a table feeds nothing else "
        f"{count.most:,} ({_percent(count.most, total)}). Not in these bounds: Quartus optimises logic by other means, duplicates "
        "registers, and may turn shift registers into memory; of the logic that it includes in an element in arithmetic mode, only "
        "inverters are included here; the rest is counted as tables."
    )


def _percent(value: int, reference: int) -> str:
    return f"{100 * (value - reference) / reference:+.1f} %" if reference else "-"


def _add(figures: Iterable[Resources]) -> Resources:
    return Resources(*map(sum, zip(Resources(), *figures, strict=True)))


def tree(blocks: dict[str, Resources]) -> dict[str, tuple[int, Resources]]:
    """The rows of a table: a block includes the blocks inside it; many blocks whose names differ only in a number are one row.

    Returns
    -------
    dict
        Path, with ``*`` for such a number, to the number of blocks in the row and their figures.
    """
    paths = sorted({".".join(path.split(".")[:depth]) for path in blocks for depth in range(1, path.count(".") + 2)})
    alike = Counter(map(_without_numbers, paths))
    rows: dict[str, list[str]] = {}
    for path in paths:
        names = path.split(".")
        prefixes = [_without_numbers(".".join(names[:depth + 1])) for depth in range(len(names))]
        row = ".".join(_without_numbers(name) if alike[prefix] > _MANY else name for name, prefix in zip(names, prefixes, strict=True))
        rows.setdefault(row, []).append(path)
    result = {}
    for row, members in rows.items():
        inside = [figures for path, figures in blocks.items() if any(path == member or path.startswith(member + ".") for member in members)]
        result[row] = len(members), _add(inside)
    return result


def _without_numbers(path: str) -> str:
    """The path with ``*`` in place of the numbers at the end of its names."""
    return re.sub(r"(_?\d+)+(?=\.|$)", "*", path)


def table(count: Count, device: Device, title: str, thesis: bool) -> Table:
    """Blocks, total, device and, if ``thesis``, Table 2."""
    shown = Table(title=title, title_justify="left")
    shown.add_column("block", no_wrap=True, overflow="fold")
    for figure in FIGURES:
        shown.add_column(TITLES[figure], justify="right")
    for path, (number, figures) in tree(count.blocks).items():
        name = "  " * path.count(".") + path.rpartition(".")[2] + (f" ({number})" if number > 1 else "")
        shown.add_row(name, *(f"{value:,}" for value in figures))
    _add_device(shown, count.total, device)
    if thesis:
        total = count.total._asdict()
        known = {figure: f"{value:,}" for figure, value in THESIS.items()}
        share = {figure: f"{100 * total[figure] / value:.1f} %" for figure, value in THESIS.items()}
        shown.add_row("thesis, table 2", *(known.get(figure, "-") for figure in FIGURES))
        shown.add_row("of the thesis's", *(share.get(figure, "-") for figure in FIGURES))
    return shown


def system_table(count: Count, device: Device, title: str, allowance: Resources) -> Table:
    """The blocks of the first level, with their shares of the device; ``allowance`` is for what is not in the count."""
    shown = Table(title=title, title_justify="left")
    shown.add_column("block", no_wrap=True, overflow="fold")
    for figure in FIGURES:
        shown.add_column(TITLES[figure], justify="right")
        shown.add_column("%", justify="right")
    rows = {path.rpartition(".")[2]: figures for path, (_, figures) in tree(count.blocks).items() if path.count(".") == 1}
    top = min(count.blocks, key=len)
    rows |= {f"{top} itself": count.blocks[top], "DDR2 controller, an allowance": allowance}
    for name, figures in sorted(rows.items(), key=lambda row: -row[1].logic_elements):
        shown.add_row(name, *_with_shares(figures, device))
    total = _add([count.total, allowance])
    shown.add_section()
    shown.add_row("total", *_with_shares(total, device), style="bold")
    shown.add_row(device.name, *(cell for value in device.capacity for cell in (f"{value:,}", "")))
    return shown


def _with_shares(figures: Resources, device: Device) -> list[str]:
    return [cell for value, capacity in zip(figures, device.capacity) for cell in (f"{value:,}", f"{100 * value / capacity:.1f}")]


def _add_device(shown: Table, total: Resources, device: Device) -> None:
    shown.add_section()
    shown.add_row("total", *(f"{value:,}" for value in total), style="bold")
    shown.add_row(device.name, *(f"{value:,}" for value in device.capacity))
    shown.add_row("used", *(f"{100 * value / capacity:.1f} %" for value, capacity in zip(total, device.capacity)))


def clock_text(clock: Clock) -> str:
    """The clock rate and the worst path, in words."""
    lines = [
        f"Clock: {clock.mhz:.1f} MHz, by nextpnr on the stand-in {clock.device}: no open tool routes a Cyclone III.",
        f"Worst path between registers: {clock.logic:.2f} ns of logic, {clock.routing:.2f} ns of routing, through",
        *(f"  {name}" for name in clock.path),
    ]
    if clock.soft_multipliers:
        lines.insert(1, "The device has too few multipliers for the design; they are made of tables here.")
    return "\n".join(lines)


def seeds_text(clocks: Sequence[Clock]) -> str:
    """Of several placements, the fastest first: the range, the median, and the seed of the fastest."""
    best, worst, middle = clocks[0], clocks[-1], median(clock.mhz for clock in clocks)
    return (f"Of {len(clocks)} placements the fastest, of seed {best.seed}, reaches {best.mhz:.1f} MHz, the slowest {worst.mhz:.1f} MHz, "
            f"the median is {middle:.1f} MHz.")


def classes_table(clock: Clock) -> Table:
    """The slowest paths between registers, a row for those whose names differ only in numbers."""
    shown = Table(title="Slowest paths between registers, ns", title_justify="left")
    for column in ("from", "to"):
        shown.add_column(column, overflow="fold")
    for column in ("logic", "routing", "together", "ends"):
        shown.add_column(column, justify="right")
    for found in clock.classes:
        shown.add_row(found.begin, found.end, f"{found.logic:.2f}", f"{found.routing:.2f}", f"{found.delay:.2f}", f"{found.ends:,}")
    return shown


def as_json(count: Count, clocks: Sequence[Clock], about: dict[str, Any], capacity: Resources) -> dict[str, Any]:
    """The JSON document. Figures of a block exclude the blocks inside it, so that all of them add up to the total.

    ``clocks``: of all placements, the fastest first; none if it was not placed.
    """
    document = {
        **about,
        "total": count.total._asdict(),
        "blocks": {path: figures._asdict() for path, figures in count.blocks.items()},
        "logic_elements_between": [count.least, count.most],
        "elements": count.kinds,
        "capacity": capacity._asdict(),
        "thesis_table_2": THESIS,
        "counting": counting(count),
    }
    for clock in clocks[:1]:
        document |= {"clock_mhz": round(clock.mhz, 2), "clock_device": clock.device, "worst_path": clock.worst_path,
                     "path_classes": clock.path_classes, "clock_mhz_by_seed": {found.seed: round(found.mhz, 2) for found in clocks}}
    return document


def show(count: Count, device: Device, title: str, thesis: bool) -> None:
    """Print the table, and how it is counted."""
    print_table(table(count, device, title, thesis))
    print(counting(count))
