"""A matcher's Verilog run on pictures: writes text pictures, runs ``harness.v`` in a simulator, reads disparities and counts."""

import contextlib
import itertools
import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from amaranth.hdl import Value
from numpy.typing import NDArray

from golden.config import MatcherConfig
from golden.errors import UserError
from golden.matcher.matcher import match
from golden.pictures.text import read_text, write_text
from hdl.emit import write_verilog
from hdl.matcher.matcher import Matcher
from hdl.rectified import RectifiedMatcher

from .places import full_disk
from .simulators import SimulationError, build, run
from .store import Store


__all__ = ["Frame", "Result", "Traffic", "emit", "mismatches", "simulate"]


_HARNESS = Path(__file__).with_name("harness.v")
_TOP = "harness"

# Pixels of a run up to which the optimiser takes longer than it saves.
_BRIEF = 5000

# Seconds between two reports of progress.
_POLL = 0.1


class Traffic(NamedTuple):
    """What happens around a frame of a run.

    Parameters
    ----------
    stall_i, stall_o : float
        Probability of an idle clock before a pixel pair of the frame; of a clock in which ``ready`` of the output is low while the frame is
        received. Rounded to 1/256, below 1.
    burst_i, burst_o : int
        A stall that has begun lasts for up to so many further clocks.
    settings : dict of str to int
        Values of the inputs of these names, applied before the frame, as soon as the first disparity of the one before is out; the
        other inputs have the values of the configuration. ``None``: the settings in force stay, at first the built-in ones.
    """
    stall_i: float = 0.0
    stall_o: float = 0.0
    burst_i: int = 0
    burst_o: int = 0
    settings: Mapping[str, int] | None = None


@dataclass(frozen=True)
class Frame:
    """Size and timing of one frame, in pixels and clocks.

    ``clocks``: from the first pixel pair accepted to the last disparity transferred, both counted. ``in_clocks``: from the first pair
    accepted to the last, both counted. ``out_clocks``: from the first disparity transferred to the last. ``latency``: the longest time
    from a pair's transfer to the clock in which its disparity is valid; ``latency_first``: that of the first pixel. ``start``: the clock
    of the run in which the first disparity is transferred.
    """
    width: int
    height: int
    clocks: int
    in_clocks: int
    out_clocks: int
    latency: int
    latency_first: int
    start: int = 0

    @property
    def clocks_per_pixel(self) -> float:
        """Of the slower of input and output. A picture that fits into the matcher's buffers enters faster than it leaves."""
        pixels = self.width * self.height
        return max(self.in_clocks / pixels, self.out_clocks / max(pixels - 1, 1))


@dataclass(frozen=True)
class Result:
    """Disparities and counts of a run.

    Parameters
    ----------
    fields : list of dict of str to (H, W) ndarray
        Output of the Verilog for each frame: names as in ``config.result_fields``, int32. ``disparity`` is in units of
        ``1 / config.method.disparity_scale`` pixel.
    frames : list of Frame
    report : dict of str to int
        Counts of the whole run: ``clocks``, ``frames``, ``pixels_in``, ``pixels_out``, and the counts of faults, all 0.
    seconds : float
        Of simulation, from the first clock to the last.
    build_seconds : float
        Of emission and compilation; a fraction of a second where the model is in the store.
    waves : path
        Waveform file, if there is one.
    """
    fields: list[dict[str, NDArray[Any]]]
    frames: list[Frame]
    report: dict[str, int]
    seconds: float
    build_seconds: float
    waves: Path | None = field(default=None)

    @property
    def clocks_per_second(self) -> float:
        return self.report["clocks"] / self.seconds


def emit(config: MatcherConfig, path: Path) -> Path:
    """Write the Verilog of the matcher, module ``matcher``; return the path."""
    return write_verilog(Matcher(config), path, name="matcher")


def mismatches(result: Result, number: int, left: NDArray[np.uint8], right: NDArray[np.uint8], config: MatcherConfig,
               seen: Callable[[dict[str, NDArray[Any]]], dict[str, NDArray[Any]]] = lambda fields: fields) -> int:
    """Number of pixels of frame ``number`` of which any field differs from the golden model's for ``config``.

    ``seen`` takes all fields and gives those, and of them what, a result can have.
    """
    golden, given = match(left, right, config), result.fields[number]
    expected = seen({name: golden[name] for name in config.result_fields})
    return int(np.count_nonzero(np.any([given[name] != values for name, values in expected.items()], axis=0)))


def _further_ports(core: RectifiedMatcher) -> list[str]:
    """Connections of what only a matcher with rectification has: no maps are loaded, its status is not read."""
    inputs = [f".{name}({len(Value.cast(getattr(core, name)))}'d0)" for name in core.LOADING]
    return [*inputs, *(f".{name}()" for name in core.STATUS)]


def _placed(fields: Mapping[str, int]) -> dict[str, tuple[int, int]]:
    """Lowest bit and width of each field of a packed word, the first field lowest."""
    offsets = itertools.accumulate(fields.values(), initial=0)
    return {name: (offset, width) for (name, width), offset in zip(fields.items(), offsets)}


def _plan_line(traffic: Traffic, ports: Mapping[str, tuple[int, int]], defaults: Mapping[str, int]) -> str:
    """Line of the plan that ``harness.v`` reads. ``ports``: place of each setting, of :func:`_placed`."""
    values = {**defaults, **(traffic.settings or {})}
    settings = sum((int(values[name]) & (1 << bits) - 1) << low for name, (low, bits) in ports.items())
    stall_i, stall_o = (min(round(256 * stall), 255) for stall in (traffic.stall_i, traffic.stall_o))
    return f"{int(traffic.settings is not None)} {settings:x} {stall_i} {traffic.burst_i} {stall_o} {traffic.burst_o}\n"


def _read_report(path: Path) -> tuple[dict[str, int], list[Frame], float]:
    """Counts of the run, of its frames, and the seconds."""
    report: dict[str, int] = {}
    frames: list[dict[str, int]] = []
    seconds = 0.0
    for line in path.read_text().splitlines():
        key, value = line.split()
        if key == "seconds":
            seconds = float(value)
        elif key.startswith("frame") and "." in key:
            number, name = key.removeprefix("frame").split(".")
            if int(number) == len(frames):
                frames.append({})
            frames[int(number)][name] = int(value)
        else:
            # Icarus may print a count as x or z: that is a fault, not zero.
            report[key] = int(value) if value.isdigit() else -1
    return report, [Frame(**frame) for frame in frames], seconds


@contextlib.contextmanager
def _watch(path: Path, progress: Callable[[int], None] | None):
    """While the block runs, call ``progress`` with the number of picture lines in ``path``."""
    if progress is None:
        yield
        return
    over = threading.Event()

    def poll():
        rows = offset = 0
        rest = b""
        while True:
            ending = over.is_set()
            with contextlib.suppress(OSError), path.open("rb") as file:
                file.seek(offset)
                data = file.read()
                offset += len(data)
                *lines, rest = (rest + data).split(b"\n")
                rows += sum(not line.startswith(b"//") for line in lines)
                progress(rows)
            if ending:
                return
            over.wait(_POLL)

    thread = threading.Thread(target=poll, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def simulate(config: MatcherConfig, lefts: Sequence[NDArray[np.uint8]], rights: Sequence[NDArray[np.uint8]], *, simulator: str,
             work_dir: str | os.PathLike[str], stall_i: float = 0.0, stall_o: float = 0.0, settings: Mapping[str, int] | None = None,
             seed: int = 1, waves: bool = False, progress: Callable[[int], None] | None = None,
             stage: Callable[[str], None] = lambda text: None, verilog: str | os.PathLike[str] | None = None,
             core: RectifiedMatcher | None = None, timeout: int = 200_000, traffic: Sequence[Traffic] | None = None,
             store: Store | None = None) -> Result:
    """Run pictures through the Verilog of ``Matcher(config)``, one frame after another.

    Parameters
    ----------
    config : MatcherConfig
    lefts, rights : sequence of (H, W) uint8 ndarray
        Grey levels, as many left as right pictures; frames may differ in size.
    simulator : str
        One of :data:`sim.kit.simulators.SIMULATORS`.
    work_dir : path
        Folder for Verilog, model, text pictures and logs of this run alone.
    stall_i, stall_o : float
        Probability of an idle clock before a pixel pair; of a clock in which ``ready`` of the output is low. Rounded to 1/256, below 1.
    settings : dict of str to int
        Values of the inputs of these names, see :attr:`golden.config.MatcherConfig.settings`; the other inputs have the values of
        ``config``. By default no setting is written, and the built-in values hold.
    seed : int
        Of the stalls, and of what registers and memories without an initial value hold at first in Verilator.
    waves : bool
        Write a waveform file too.
    progress : callable
        Called several times a second, from another thread, with the number of picture lines that are finished.
    stage : callable
        Called with the name of each step as it begins.
    verilog : path
        Verilog of the matcher; emitted by default.
    core : RectifiedMatcher
        In the place of ``Matcher(config)``, for pictures that are not rectified; ``settings`` may then have all of its settings.
    timeout : int
        Clocks without a transfer after which the run ends as hung.
    traffic : sequence of Traffic
        Of each frame, in place of ``stall_i``, ``stall_o`` and ``settings``.
    store : Store
        Where models are kept, as of :func:`sim.kit.simulators.build`.

    Returns
    -------
    Result
        :class:`SimulationError` if the matcher hung, had extra words, a wrong flag or an unknown bit in its output, broke a rule of
        streams, or raised ``error``. Disparities are not compared.
    """
    work = Path(work_dir).absolute()
    work.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    if verilog is None:
        stage("Writing Verilog")
        verilog = write_verilog(core, work / "matcher.v", name="matcher") if core else emit(config, work / "matcher.v")
    stage(f"Building for {simulator}")
    folder = work / f"{simulator}{'_waves' if waves else ''}"
    fields = _placed(config.result_fields)
    known = core.settings if core else config.settings
    ports = _placed({name: setting.bits for name, setting in known.items()})
    word_bits, setting_bits = (sum(width for _, width in placed.values()) for placed in (fields, ports))
    connections = ",".join([*(f".{name}(settings[{low + width - 1}:{low}])" for name, (low, width) in ports.items()),
                            *(_further_ports(core) if core else ())])
    build(simulator, [verilog, _HARNESS], _TOP, folder, parameters={"WORD_BITS": word_bits, "SETTING_BITS": setting_bits},
          defines={"SETTING_PORTS": connections}, waves=waves, brief=sum(np.size(left) for left in lefts) <= _BRIEF,
          store=store)
    build_seconds = time.perf_counter() - start

    files = {name: work / f"{name}.txt" for name in ("left", "right", "plan", "output", "report")}
    write_text(files["left"], lefts)
    write_text(files["right"], rights)
    if traffic is None:
        traffic = [Traffic(stall_i, stall_o, settings=None if number else settings) for number in range(len(lefts))]
    defaults = {name: setting.default for name, setting in known.items()}
    files["plan"].write_text("".join(_plan_line(each, ports, defaults) for each in traffic))
    for name in ("output", "report"):
        files[name].unlink(missing_ok=True)
    # Relative to where the simulator runs: Verilog's file names are of limited length.
    plusargs = [f"+{name}={os.path.relpath(path, folder)}" for name, path in files.items()]
    numbers = {"seed": seed, "timeout": timeout}
    plusargs += [f"+{name}={value}" for name, value in numbers.items()]
    waves_file = work / f"matcher.{'fst' if simulator == 'icarus' else 'vcd'}" if waves else None

    stage(f"Simulating with {simulator}")
    with _watch(files["output"], progress):
        run(simulator, _TOP, folder, "sim.kit.harness_tb", plusargs=plusargs, waves=waves_file, seed=seed)
    try:
        report, frames, seconds = _read_report(files["report"])
        _check(report, sum(np.size(left) for left in lefts), len(lefts))
        words = read_text(files["output"], 6 if word_bits > 8 else 2)
    except (SimulationError, OSError, ValueError, KeyError, TypeError) as error:
        # Simulators do not tell that what they write is lost.
        if reason := full_disk(work):
            raise SimulationError(f"{simulator} did not write all of its output{reason}") from error
        if isinstance(error, UserError):
            raise SimulationError(f"the harness wrote a bad text picture: {error}") from error
        raise
    frame_fields = [{name: (word >> low & (1 << width) - 1).astype(np.int32) for name, (low, width) in fields.items()} for word in words]
    if config.lead:
        for frame in frame_fields:  # the disparity has a sign
            frame["disparity"] -= (frame["disparity"] >> fields["disparity"][1] - 1) << fields["disparity"][1]
    return Result(frame_fields, frames, report, seconds, build_seconds, waves_file)


def _check(report: dict[str, Any], pixels: int, frames: int) -> None:
    """Raise :class:`SimulationError` if the harness saw a fault."""
    faults = {name: report[name] for name in ("hang", "bad_files", "flag_errors", "rule_errors", "unknown_words", "extra_words", "error")}
    wrong = [f"{name} {count}" for name, count in faults.items() if count]
    wrong += [f"{name} {report[name]} of {expected}" for name, expected in
              (("pixels_in", pixels), ("pixels_out", pixels), ("frames", frames)) if report[name] != expected]
    if wrong:
        raise SimulationError(f"the harness saw faults: {', '.join(wrong)}")
