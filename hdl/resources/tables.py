"""Write tables 2 and 3 of the thesis with columns of ours: ``python -m hdl.resources.tables``."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from amaranth.hdl import Fragment
from rich.progress import Progress

from golden.cli import Parser, progress
from golden.config import Arithmetic, Engine, MatcherConfig, OnePass
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output, parsed
from golden.lab.published import TABLE_3
from golden.pages import digest, origin, table

from ..matcher.matcher import Matcher
from ..options import need
from .count import FIGURES, Resources, count
from .devices import DEFAULT_DEVICE, DEVICES
from .mapping import map_cyclone3
from .report import THESIS, TITLES


__all__ = ["SMALL", "inputs", "main"]


SIZES = ((384, 288, 16), (720, 576, 80), (1280, 720, 80), (1920, 1080, 80))

#: Width and disparities of small matchers, one of each engine. Their totals stand for the gateware in the page's digest: the tests count
#: them, so a change of the gateware that changes a count makes the page stale.
SMALL = (64, 6)


def _config(engine: Engine, width: int, disparities: int) -> MatcherConfig:
    arithmetic = Arithmetic.LINEAR if engine is Engine.STREAMING else Arithmetic.THESIS
    return MatcherConfig(labels=disparities, max_width=width, engine=engine, method=OnePass(arithmetic))


def _counts(bar: Progress) -> tuple[dict[tuple[Engine, int], Resources], list[Resources]]:
    """Totals of both engines at every size, by engine and width, and those of the small matchers."""
    jobs = [(engine, width, disparities) for engine in Engine for width, disparities in (*((size[0], size[2]) for size in SIZES), SMALL)]
    task = bar.add_task("", total=len(jobs))
    found = {}
    for engine, width, disparities in jobs:
        bar.update(task, description=f"{engine}, {width} wide, {disparities} disparities")
        found[engine, width] = count(map_cyclone3(Matcher(_config(engine, width, disparities)), "matcher")).total
        bar.advance(task)
    return found, [found.pop((engine, SMALL[0])) for engine in Engine]


def inputs(tables: Sequence[str], small: Sequence[Resources]) -> str:
    """Digest of the page's inputs: what is counted, what the thesis prints, the figures, and the totals of the small matchers.

    Parameters
    ----------
    tables : sequence of str
        Lines of both tables, as the page has them.
    small : sequence of Resources
        Totals of the small matchers, in the order of the engines.
    """
    return digest(SIZES, TABLE_3, THESIS, DEVICES[DEFAULT_DEVICE].capacity._asdict(), list(tables), [list(total) for total in small])


def _table_2(counts: dict[tuple[Engine, int], Resources]) -> list[str]:
    head = ["EP3C120", "available", "thesis 720x576x80",
            *(f"{engine} {'x'.join(map(str, size))}" for engine in Engine for size in SIZES)]
    rows = [[TITLES[figure], f"{getattr(DEVICES[DEFAULT_DEVICE].capacity, figure):,}", f"{THESIS[figure]:,}" if figure in THESIS else "-",
             *(f"{getattr(counts[engine, size[0]], figure):,}" for engine in Engine for size in SIZES)] for figure in FIGURES]
    return table(head, rows)


def _table_3(clocks: Sequence[dict]) -> list[str]:  # type: ignore[type-arg]
    def row(hardware: str, width: int, height: int, disparities: int, method: str, rate: float) -> list[str]:
        return [hardware, f"{width}x{height}", str(disparities), method, f"{rate:.4g}", f"{rate * width * height * disparities / 1e6:,.0f}"]

    rows = [row(*entry) for entry in TABLE_3]
    for clock in clocks:
        engine = Engine(clock["engine"])
        matcher = Matcher(_config(engine, clock["width"], clock["disparities"]))
        Fragment.get(matcher, None)  # Amaranth complains of components that are not used
        rate = clock["clock_mhz"] * 1e6 / matcher.frame_clocks(clock["width"], clock["height"])
        device = clock["clock_device"].partition(",")[0]
        rows.append(row(f"ours, {engine}, at {clock['clock_mhz']:.1f} MHz (stand-in {device})", clock["width"], clock["height"],
                        clock["disparities"], "one-pass graph cut", rate))
    return table(["hardware", "picture", "disparities", "method", "frames/s", "million disparities/s"], rows)


def _read_clock(path: Path) -> dict:  # type: ignore[type-arg]
    try:
        clock = parsed(json.loads, path.read_text(encoding="utf-8"))
        _table_3([clock])       # what is wrong with it is told before the minutes of counting
        return {key: clock[key] for key in ("engine", "width", "height", "disparities", "clock_mhz", "clock_device")}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, ZeroDivisionError) as error:
        raise UserError(f"{path} is not what `python -m hdl.resources --clock --json {path}` writes ({error}); run that command") from error


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.resources.tables", description=__doc__ + " Counts ten matchers: about a quarter of an hour.")
    parser.add_argument("--output", type=Path, default=Path("docs/resources.md"), metavar="FILE", help="default: %(default)s")
    parser.add_argument("--clock", type=Path, action="append", default=[], metavar="JSON",
                        help="what `python -m hdl.resources --clock --json JSON` wrote: a row of table 3; may be repeated")
    options = parser.parse_args(argv)
    check_output(options.output, [".md"])
    clocks = [_read_clock(path) for path in options.clock]
    need("pyosys", "pyosys")
    with progress() as bar:
        counts, small = _counts(bar)
    resources, rate = _table_2(counts), _table_3(clocks)
    command = "python -m hdl.resources.tables" + "".join(f" --clock {path.as_posix()}" for path in options.clock)
    text = [
        "# Tables 2 and 3 of the thesis, and ours", "",
        origin(command, inputs([*resources, *rate], small)), "",
        "The count is ours, on Yosys passes, from the Verilog as it is delivered; `python -m hdl.resources` states the method and its",
        "error, and counts each block. The sequential engine is counted with the thesis's arithmetic, the streaming engine with `linear`.",
        "",
        "## Table 2: resources", "", *resources, "",
        "## Table 3: rate", "",
        "Our rows are at the clock rate that nextpnr reaches on an ECP5-85F, speed 6, for the whole matcher: a stand-in, because no open",
        "tool routes a Cyclone III. `python -m hdl.resources --clock --json FILE` measures it in half an hour; docs/clock.json keeps the",
        "result. Blanking between lines and frames is included.", "", *rate, "",
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
