"""A pair as two mounted cameras see it, through the Verilog of the matcher behind rectification and balance."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import NDArray

from golden.config import MatcherConfig
from golden.lab.cameras import pictures
from golden.lab.mounting import Mounting
from golden.matcher.matcher import in_pixels
from golden.pictures.dataset import StereoPair
from golden.rig.config import RigConfig
from hdl.emit import write_verilog
from hdl.rectified import RectifiedMatcher
from hdl.rig.balance import BalanceMode

from .harness import mismatches, simulate


__all__ = ["FRAMES", "RUNS", "MountedResult", "simulate_mounted"]


#: The runs: settings, and of each frame the column of :data:`golden.lab.cameras.COLUMNS` whose pictures are sent, and the one whose result
#: it is. Of a scene that stands still, the third pair is the first one that is balanced.
RUNS: tuple[tuple[dict[str, int], list[tuple[str, str | None]]], ...] = (
    ({"rectify": 0, "balance": BalanceMode.OFF}, [(name, name) for name in ("published", "mounted", "both")]),
    ({"rectify": 1, "balance": BalanceMode.OFF}, [("mounted", "rectified")]),
    ({"rectify": 0, "balance": BalanceMode.AUTO}, [("darker", "darker"), ("darker", None), ("darker", "balanced")]),
    ({"rectify": 1, "balance": BalanceMode.AUTO}, [("both", "both rectified"), ("both", None), ("both", "both cured")]),
)

#: Frames that :func:`simulate_mounted` sends.
FRAMES = sum(len(frames) for _, frames in RUNS)


class MountedResult(NamedTuple):
    """Disparities in pixels by column, pixels that are not the golden model's, clocks from frame to frame in the last run, and seconds."""
    disparities: dict[str, NDArray[Any]]
    mismatches: int
    frame_clocks: int
    seconds: float


def simulate_mounted(pair: StereoPair, config: MatcherConfig, mounting: Mounting, *, simulator: str, work_dir: Path,
                     stage: Callable[[str], None] = lambda text: None, progress: Callable[[int], None] = lambda lines: None
                     ) -> MountedResult:
    """The columns of ``golden cameras``, but the one in floating point, through the Verilog of :class:`RectifiedMatcher`.

    Parameters
    ----------
    pair : StereoPair
        Rectified; :class:`ValueError` if the default rectifier holds too few lines for its mounted cameras.
    config : MatcherConfig
        For lines of this width, with a least disparity of 0.
    simulator, work_dir, stage, progress
        As of :func:`sim.kit.harness.simulate`; ``progress`` counts the lines of all :data:`FRAMES` frames.
    """
    height, width = pair.left.shape
    seen = pictures(pair, mounting)
    core = RectifiedMatcher(config, height, RigConfig(rig=mounting.rig(width, height)))
    stage("Writing Verilog")
    verilog = write_verilog(core, work_dir / "core.v", name="matcher")
    disparities: dict[str, NDArray[Any]] = {}
    wrong = done = 0
    seconds = 0.0
    for settings, frames in RUNS:
        lefts, rights = zip(*(seen[sent] for sent, _ in frames))
        result = simulate(config, lefts, rights, simulator=simulator, work_dir=work_dir, stage=stage, verilog=verilog, core=core,
                          settings=settings, progress=lambda lines, before=done: progress(before + lines))    # type: ignore[misc]
        done += len(frames) * height
        seconds += result.seconds
        for number, (_, column) in enumerate(frames):
            if column:
                wrong += mismatches(result, number, *seen[column], config)
                disparities[column] = in_pixels(result.fields[number]["disparity"], config)
    return MountedResult(disparities, wrong, result.frames[-1].start - result.frames[-2].start, seconds)
