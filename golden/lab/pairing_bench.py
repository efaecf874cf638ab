"""`python -m golden.lab.pairing_bench`: pairs of two cameras that drift, over hours, and how long reading a pair may take."""

import sys
from collections.abc import Sequence

from rich.table import Table

from ..cli import Parser, progress
from ..errors import UserError, run_cli
from ..tables import print_table
from ..video.drift import Trace, all_phases, camera_frames, figures, simulate, violations
from ..video.formats import DISPLAYS, PAL
from ..video.pairing import WINDOW, Pairing, buffers_needed


__all__ = ["main"]


# In frame periods: on either side of the limits of double buffers, and of any number of buffers.
_READS = (0.250, 0.375, 0.410, 0.420, 0.500, 0.600, 0.750, 0.950)


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden.lab.pairing_bench", description=(
        "Two PAL cameras that start at different times and drift: the frame store's rule from event to event, with all its guarantees "
        "checked. For each drift: frames of the slower camera, pairs, pictures shown; the greatest time between the starts of a pair's "
        "frames, the greatest age of a frame as its pair starts, the longest time from pair to pair; frames skipped and unpaired. Then "
        "the reading times that two and three buffers allow, over all phases of the cameras."))
    result.add_argument("--hours", type=float, default=3.0, metavar="H", help="simulated time (default: %(default)s)")
    result.add_argument("--ppm", type=float, nargs="+", default=[0.0, 1.0, 10.0, -50.0, 100.0], metavar="PPM",
                        help="how much longer the right camera's period is, in millionths (default: 0 1 10 -50 100)")
    result.add_argument("--start", type=float, default=0.6, metavar="PERIODS",
                        help="how much later the right camera starts, in periods (default: %(default)s)")
    result.add_argument("--read-ms", type=float, default=5.6, metavar="MS",
                        help="milliseconds that a pair is read for: the matcher's frame time (default: %(default)s)")
    result.add_argument("--buffers", type=int, metavar="N", help="buffers for each picture (default: as many as the reading time needs)")
    result.add_argument("--display", choices=DISPLAYS, default="720x576", metavar="|".join(DISPLAYS),
                        help="the monitor's format (default: %(default)s)")
    result.add_argument("--clock-mhz", type=float, default=75.0, metavar="MHZ", help="clock of the control (default: %(default)s)")
    return result


def checked(trace: Trace) -> Trace:
    """The trace, if it keeps the rule's guarantees."""
    if found := violations(trace):
        raise AssertionError("; ".join(found))
    return trace


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    for value, name, least, most in ((options.hours, "--hours", 0.001, 100), (options.start, "--start", 0, 1000),
                                     (options.clock_mhz, "--clock-mhz", 0.1, 1000), (options.read_ms, "--read-ms", 0.01, 1000),
                                     *((drift, "--ppm", -10_000, 10_000) for drift in options.ppm)):
        if not least <= value <= most:
            raise UserError(f"{name} must be from {least:g} to {most}, not {value:g}; choose a value in that range")
    period_ms = PAL.frame_seconds * 1e3
    try:
        buffers = options.buffers or buffers_needed(options.read_ms / 1e3, PAL.frame_seconds)
        Pairing(buffers, 1)
    except ValueError as error:
        raise UserError(f"{error}; choose another --read-ms or --buffers") from None

    clocks_ms = options.clock_mhz * 1e3
    clock_hz = round(clocks_ms * 1e3)
    window = int(WINDOW * round(period_ms * clocks_ms))
    drifts = Table(title=f"{options.hours:g} hours, {buffers} buffers, pairs read in {options.read_ms:g} ms",
                   caption=f"ms: apart, age, gap, at most; window {window / clocks_ms:.3f} ms; frames: left, right")
    for column in ("ppm", "slower", "pairs", "shown", "apart", "age", "gap", "skipped", "unpaired"):
        drifts.add_column(column, justify="right")
    reading = Table(title="Reading time over all phases of the cameras", caption="pairs lost: of the slower camera's frames")
    for column in ("period", "ms", "2 buffers: skipped", "pairs lost", "3 buffers: skipped", "pairs lost"):
        reading.add_column(column, justify="right")

    with progress() as bar:
        task = bar.add_task("drift", total=len(options.ppm) + len(_READS))
        for ppm in options.ppm:
            left, right = (camera_frames(options.hours * 3600, clock_hz, ppm=drift, start=start)
                           for drift, start in ((0.0, 0.0), (ppm, options.start)))
            display = DISPLAYS[options.display].frames_per_second
            trace = checked(simulate(left, right, Pairing(buffers, window), max(1, round(options.read_ms * clocks_ms)),
                                     round(clock_hz / display)))
            if len(trace.started) < 2:
                raise UserError(f"--hours {options.hours:g} is too short for two pairs; choose a longer time or a smaller --start")
            found = figures(trace)
            drifts.add_row(
                f"{ppm:g}", f"{min(len(side.begins) for side in (left, right))}", f"{found.pairs}", f"{found.shown}",
                *(f"{clocks / clocks_ms:.3f}" for clocks in (found.apart, found.age, found.gap)),
                "{}, {}".format(*found.skipped), "{}, {}".format(*found.unpaired))
            bar.advance(task)
        bar.update(task, description="reading time")
        for read in _READS:
            cells = []
            for number in (2, 3):
                trace = checked(all_phases(number, read, clock_hz=clock_hz))
                found = figures(trace)
                cells += ["{}, {}".format(*found.skipped), f"{min(len(side.begins) for side in trace.frames) - found.pairs}"]
            reading.add_row(f"{read:.3f}", f"{read * period_ms:.2f}", *cells)
            bar.advance(task)
    print_table(drifts)
    print_table(reading)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden.lab.pairing_bench")


if __name__ == "__main__":
    sys.exit(main())
