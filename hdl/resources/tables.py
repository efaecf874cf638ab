"""Write tables 2 and 3 of the thesis with columns of ours: ``python -m hdl.resources.tables``."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from amaranth.hdl import Fragment
from rich.progress import Progress

from boards.cyclone3 import platform as cyclone3
from golden.cli import Parser, progress
from golden.config import Arithmetic, Engine, MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output

from ..matcher.matcher import Matcher
from .__main__ import need
from .count import FIGURES, Resources, count
from .mapping import map_cyclone3
from .report import THESIS, TITLES


__all__ = ["main"]


SIZES = ((384, 288, 16), (720, 576, 80), (1280, 720, 80), (1920, 1080, 80))

#: Table 3 of the thesis: hardware, width, height, disparities, method, frames a second.
THESIS_TABLE_3 = (
    ("4 x Virtex-2 [26]", 256, 360, 20, "local weighted phase correlation", 30),
    ("Virtex-4 [27]", 640, 480, 64, "census, local", 60),
    ("Virtex-2 [28]", 640, 480, 128, "SAD, local", 60),
    ("Virtex-2 [29]", 640, 480, 64, "SAD, local", 30),
    ("Cyclone III, the thesis", 720, 576, 80, "one-pass graph cut", 25),
)


def _config(engine: Engine, width: int, disparities: int) -> MatcherConfig:
    arithmetic = Arithmetic.LINEAR if engine is Engine.STREAMING else Arithmetic.THESIS
    return MatcherConfig(disparities=disparities, arithmetic=arithmetic, max_width=width, engine=engine)


def _counts(bar: Progress) -> dict[tuple[Engine, int], Resources]:
    """Totals of both engines at every size, by engine and width."""
    jobs = [(engine, width, disparities) for engine in Engine for width, _, disparities in SIZES]
    task = bar.add_task("", total=len(jobs))
    found = {}
    for engine, width, disparities in jobs:
        bar.update(task, description=f"{engine}, {width} wide, {disparities} disparities")
        found[engine, width] = count(map_cyclone3(Matcher(_config(engine, width, disparities)), "matcher")).total
        bar.advance(task)
    return found


def _row(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _table(head: Sequence[object], rows: Sequence[Sequence[object]]) -> list[str]:
    return [_row(head), _row(["---"] + ["---:"] * (len(head) - 1)), *map(_row, rows)]


def _table_2(counts: dict[tuple[Engine, int], Resources]) -> list[str]:
    head = ["EP3C120", "available", "thesis 720x576x80",
            *(f"{engine} {'x'.join(map(str, size))}" for engine in Engine for size in SIZES)]
    rows = [[TITLES[figure], f"{cyclone3.CAPACITY[figure]:,}", f"{THESIS[figure]:,}" if figure in THESIS else "-",
             *(f"{getattr(counts[engine, size[0]], figure):,}" for engine in Engine for size in SIZES)] for figure in FIGURES]
    return _table(head, rows)


def _table_3(clocks: Sequence[dict]) -> list[str]:  # type: ignore[type-arg]
    def row(hardware: str, width: int, height: int, disparities: int, method: str, rate: float) -> list[str]:
        return [hardware, f"{width}x{height}", str(disparities), method, f"{rate:.4g}", f"{rate * width * height * disparities / 1e6:,.0f}"]

    rows = [row(*entry) for entry in THESIS_TABLE_3]
    for clock in clocks:
        engine = Engine(clock["engine"])
        matcher = Matcher(_config(engine, clock["width"], clock["disparities"]))
        Fragment.get(matcher, None)  # Amaranth complains of components that are not used
        rate = clock["clock_mhz"] * 1e6 / matcher.frame_clocks(clock["width"], clock["height"])
        rows.append(row(f"ours, {engine}, at {clock['clock_mhz']:.1f} MHz (stand-in ECP5-85F)", clock["width"], clock["height"],
                        clock["disparities"], "one-pass graph cut", rate))
    return _table(["hardware", "picture", "disparities", "method", "frames/s", "million disparities/s"], rows)


def _read_clock(path: Path) -> dict:  # type: ignore[type-arg]
    try:
        clock = json.loads(path.read_text())
        return {key: clock[key] for key in ("engine", "width", "height", "disparities", "clock_mhz")}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path} is not what `python -m hdl.resources --clock --json {path}` writes ({error}); write it so") from error


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.resources.tables", description=__doc__ + " Counts eight matchers: about a quarter of an hour.")
    parser.add_argument("--output", type=Path, default=Path("docs/resources.md"), metavar="FILE", help="default: %(default)s")
    parser.add_argument("--clock", type=Path, action="append", default=[], metavar="JSON",
                        help="what `python -m hdl.resources --clock --json JSON` wrote: a row of table 3; may be repeated")
    options = parser.parse_args(argv)
    check_output(options.output, [".md"])
    clocks = [_read_clock(path) for path in options.clock]
    need("pyosys", "pyosys")
    with progress() as bar:
        counts = _counts(bar)
    text = [
        "# Tables 2 and 3 of the thesis, and ours", "",
        "Written by `python -m hdl.resources.tables`. The count is ours, on Yosys passes; `python -m hdl.resources` states the method and",
        "its error, and counts each block. The sequential engine is counted with the thesis's arithmetic, the streaming engine with",
        "`linear`.", "",
        "## Table 2: resources", "", *_table_2(counts), "",
        "## Table 3: rate", "",
        "Our rows are at the clock rate that nextpnr reaches on an ECP5-85F, speed 6, for the whole matcher: a stand-in, because no open",
        "tool routes a Cyclone III. Blanking between lines and frames is included.", "", *_table_3(clocks), "",
    ]
    with atomic(options.output) as file:
        file.write("\n".join(text).encode())
    print(f"{options.output}")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.resources.tables")


if __name__ == "__main__":
    sys.exit(main())
