"""Tables 1, 2 and 3: the thesis's figures next to measured ones."""

from ...pictures.dataset import MASKS
from ..published import TABLE_1, TABLE_1_PAIR, TABLE_2, TABLE_3
from ..rivals.registry import METHODS, measure
from . import sweeps
from .laboratory import Laboratory, Result, difference, percent
from .page import Section, Table
from .rivals import RIVALS, SLOW


__all__ = ["table_1", "table_2", "table_3"]


# Row of Table 1 that each of our methods is compared with.
OURS = {"float": "Proposed Method", "thesis": "Proposed Method", "linear": "Proposed Method", "fused": None}


def table_1(lab: Laboratory) -> Section:
    """Methods on Tsukuba, and on all pairs."""
    rivals = [name for name in RIVALS if not (lab.quick and name in SLOW)]
    measured = lab.run("rivals", {(name, pair): (measure, each, name) for name in rivals for pair, each in lab.pairs.items()})
    results = lab.by_method()
    methods: dict[str, tuple[str | None, dict[str, Result]]] = {
        f"one pass, {method}": (OURS[method], {pair: results[pair, method] for pair in lab.pairs}) for method in sweeps.METHODS}
    methods |= {name: (METHODS[name].published, {pair: measured[name, pair] for pair in lab.pairs}) for name in rivals}

    rows, wide = [], []
    for name, (published, pairs) in methods.items():
        row, one = TABLE_1.get(published or ""), pairs[TABLE_1_PAIR]
        rows.append([name, *(percent([row.figures[mask] for mask in MASKS]) if row else ["-"] * 3), *percent(one["bad"]),
                     *(difference(one["bad"], row.figures) if row else ["-"] * 3), f"{row.seconds:g} {row.tool}" if row else "-",
                     f"{one['seconds']:.2f}"])
        every = [bad for result in pairs.values() for bad in result["bad"].tolist()]
        wide.append([name, *percent(every), f"{sum(every) / len(every):.2f}"])
    rows += [[name, *percent([row.figures[mask] for mask in MASKS]), *["-"] * 6, f"{row.seconds:g} {row.tool}", "-"]
             for name, row in TABLE_1.items() if name not in {published for published, _ in methods.values()}]
    return Section(
        "Table 1: previous methods and the proposed one", [
            "Bad pixels in percent, and seconds. The thesis's columns are as printed, on machines of its time; the others are measured, on "
            "the same pictures and masks. Seconds here are processor time of software, not of the gateware.",
            "Rivals: " + "; ".join(f"{name} is {METHODS[name].about}" for name in rivals) + "."],
        [Table(["Tsukuba", *(f"{mask}, {whose}" for whose in ("thesis", "measured", "difference") for mask in MASKS),
                "s, thesis", "s, here"], rows),
         Table(["all pairs", *(f"{pair} {mask}" for pair in lab.pairs for mask in MASKS), "average"], wide)],
        left_out=[f"{name}, {METHODS[name].about}" for name in SLOW] if lab.quick else [])


def table_2(resources: dict[int, Table] | None) -> Section:
    """FPGA resources."""
    if resources is None:
        rows = [[name, f"{available:,}", f"{used:,}"] for name, (used, available) in TABLE_2.items()]
        return Section("Table 2: FPGA resources", ["As the thesis prints it."],
                       [Table(["EP3C120", "available", "thesis 720x576x80"], rows)], left_out=["the resources of our engines"])
    found = resources[2]
    return Section("Table 2: FPGA resources", [
        "Ours, as `python -m hdl.resources.tables` counts them; `python -m hdl.resources` states the method and its error. "
        f"{_less(found)}"], [found])


def _less(found: Table) -> str:
    """Ours less the thesis's at the size of the thesis, in words."""
    whose = next(number for number, title in enumerate(found.head) if title.startswith("thesis"))
    words = []
    for row in found.rows:
        for number, title in enumerate(found.head):
            # At the thesis's size, where both are whole numbers.
            if title.endswith("720x576x80") and number != whose:
                ours, theirs = (row[column].replace(",", "") for column in (number, whose))
                if ours.isdigit() and theirs.isdigit():
                    words.append(f"{row[0]} {int(ours) - int(theirs):+,} ({title.split()[0]})")
    return f"Ours less the thesis's at its size: {'; '.join(words)}." if words else ""


def table_3(resources: dict[int, Table] | None) -> Section:
    """Rates of real-time systems."""
    if resources is None:
        rows = [[hardware, f"{width}x{height}", str(disparities), method, str(rate)]
                for hardware, width, height, disparities, method, rate in TABLE_3]
        head = ["hardware", "picture", "disparities", "method", "frames/s"]
        return Section("Table 3: real-time systems", ["As the thesis prints it."], [Table(head, rows)],
                       left_out=["the rates of our engines"])
    ours = any(row[0].startswith("ours") for row in resources[3].rows)
    return Section("Table 3: real-time systems", ["All rows but ours are as the thesis prints them. " + (
        "Ours are at the clock rate that place and route reaches on an ECP5, a stand-in, because no open tool routes a Cyclone III."
        if ours else "No clock rate of ours is in the page that was read: `python -m hdl.resources --clock --json FILE` measures one in "
        "half an hour, and `python -m hdl.resources.tables --clock FILE` puts it there.")], [resources[3]])
