"""`python -m golden thesis`: every table and figure of the thesis that can be measured, as two pages."""

import contextlib
import functools
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from rich.progress import Progress

from ...cli import Parser, progress
from ...errors import UserError, run_cli
from ...files import atomic
from ...pages import origin
from ...pictures import images
from ...pictures.checksums import FILES, pixel_digest
from ...pictures.dataset import PAIRS, add_data_option, data_folder, load_pairs
from ..cache import Cache
from ..rivals.registry import METHODS
from ..workers import add_worker_options, check_installed, workers
from . import disturbances, results, specimen, tables, weights
from .laboratory import Laboratory
from .page import Section, Table, html, markdown
from .resources import KEPT, find_resources, read_resources
from .rivals import RIVALS, SLOW


__all__ = ["chapters", "main"]


TITLE = "The thesis, measured"
NAME = "thesis"  # of the pages, and of the folder of pictures
COMMAND = "python -m golden thesis"


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden thesis", description=(
        "Figures 34 to 38, 42, 45, 46 and tables 1 to 3 of the thesis: its numbers, ours, the difference, and pictures. Measures all of "
        f"it, some five minutes of one processor, and keeps the results. Writes {NAME}.html, which needs no other file, and {NAME}.md "
        f"with its pictures in the folder {NAME}."))
    add_data_option(result)
    result.add_argument("--output", type=Path, default=Path("docs"), metavar="DIR", help="folder of the pages (default: %(default)s)")
    result.add_argument("--quick", action="store_true", help=(
        "leave out what takes minutes, by name: graph cuts, the readings of the thesis, the search for the best weights, and resources "
        "that are not counted yet"))
    result.add_argument("--resources", type=Path, metavar="FILE", help=(
        f"page of python -m hdl.resources.tables, for tables 2 and 3 (default: {KEPT}; where that is missing, that command counts for a "
        "quarter of an hour)"))
    result.add_argument("--cache", type=Path, default=Path("build/thesis"), metavar="DIR", help=(
        "keep results there, by the content of their inputs; a second run computes what changed (default: %(default)s)"))
    add_worker_options(result)
    return result


def chapters(lab: Laboratory, resources: dict[int, Table] | None) -> Iterator[Section]:
    """All sections, in the order of the pages; each is computed when it is taken."""
    yield tables.table_1(lab)
    yield results.tsukuba(lab)
    yield tables.table_2(resources)
    yield tables.table_3(resources)
    yield weights.figure_34(lab)
    yield results.figure_35(lab)
    yield weights.figure_36(lab)
    yield weights.figure_37(lab)
    yield results.figure_38(lab)
    yield results.figure_42(lab)
    yield disturbances.figure_45(lab)
    yield disturbances.figure_46(lab)


def _check_folder(folder: Path, option: str) -> None:
    """:class:`UserError` unless files can be made in a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UserError(f"the folder {folder} cannot be written: {error.strerror}; choose another {option}") from error


def _steps(bar: Progress) -> tuple[Callable[[str, int], None], Callable[[], None]]:
    """Functions by which a laboratory shows its progress: begin and advance."""
    task = bar.add_task("", total=None)

    def begin(what: str, count: int) -> None:
        bar.reset(task, description=what, total=count)

    return begin, lambda: bar.advance(task)


def _write(folder: Path, sections: Sequence[Section], quick: bool, inputs: str) -> list[Path]:
    """Write both pages and the pictures; the files, in order."""
    foreword = (f"{origin(COMMAND + ' --quick' * quick, inputs)} Measured with the golden model on the four pairs of the Middlebury "
                "benchmark, version 2 (D. Scharstein and R. Szeliski, IJCV 47, 2002, and CVPR 2003). Numbers of the thesis are as printed "
                "in it; all others are measured. Bad pixels: off by more than one pixel, percent, of the benchmark's masks nonocc, all and "
                "disc.")
    contents = {folder / NAME / f"{picture.name}.png": picture.png for section in sections for picture in section.pictures}
    contents[folder / f"{NAME}.md"] = markdown(TITLE, foreword, sections, NAME).encode()
    contents[folder / f"{NAME}.html"] = html(TITLE, foreword, sections).encode()
    _check_folder(folder / NAME, "--output")
    for path, content in contents.items():
        with atomic(path) as file:
            file.write(content)
    return list(contents)


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    rivals = [name for name in RIVALS if not (options.quick and name in SLOW)]
    check_installed("dask", "jinja2", *sorted({need for name in rivals if (need := METHODS[name].needs)}))
    folder = data_folder(options.data)
    pairs = {pair.name: pair for pair in load_pairs(folder)}
    pictures = {f"{pair}/{name}": pixel_digest(folder / pair / name) for pair in PAIRS for name in FILES}
    left, right = (images.read_colours(folder / "tsukuba" / f"{side}.png") for side in ("left", "right"))
    _check_folder(options.output, "--output")
    _check_folder(options.cache, "--cache")

    with contextlib.ExitStack() as stack:
        compute = stack.enter_context(workers(options.workers, options.scheduler))
        resources = read_resources(options.resources) if options.resources else find_resources(options.cache, options.quick)
        begin, advance = _steps(stack.enter_context(progress()))
        lab = Laboratory(pairs, (left, right), compute, Cache(options.cache), begin, advance, options.quick)
        sections = list(chapters(lab, resources))
        begin("digest", 1)
        inputs = specimen.inputs(functools.partial(chapters, resources=resources), pictures, options.quick)
    files = _write(options.output, sections, options.quick, inputs)
    size = sum(path.stat().st_size for path in files)
    print(f"{options.output / NAME}.html, .md: {len(sections)} sections, {len(files) - 2} pictures, {size / 1e6:.2f} MB")
    for section in sections:
        if section.left_out:
            print(f"left out of {section.title.partition(':')[0]}: {'; '.join(section.left_out)}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden thesis")
