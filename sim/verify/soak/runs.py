"""Runs of the soak's bench on a model of the system that is built once."""

import json
import tempfile
from pathlib import Path
from typing import Any

from hdl.emit import verilog_text
from sim.benches.system_sizes import SIZES, TOP
from sim.kit.simulators import SimulationError, build, run

from .schedule import Schedule, first, smallest


__all__ = ["emit", "run_seed", "soak"]


def emit(size: str, folder: Path) -> Path:
    """The Verilog of a system, written into a folder."""
    source = folder / f"{size.replace(' ', '-')}.v"
    folder.mkdir(parents=True, exist_ok=True)
    source.write_text(verilog_text(SIZES[size].system(), name=TOP))
    return source


def soak(schedule: Schedule, seed: int, size: str, source: Path, *, brief: bool = False) -> dict[str, Any]:
    """What the bench reports of a schedule, or ``{"failed": reason, "recovered": count}``, and how many disturbances were recovered from.

    Parameters
    ----------
    schedule : list
    seed : int
        Of scenes, memory and chips.
    size : str
        One of :data:`SIZES`.
    source : Path
        Its Verilog.
    brief : bool
        As in :func:`sim.kit.simulators.build`.
    """
    with tempfile.TemporaryDirectory(prefix="soak-") as name:
        folder = Path(name)
        report = folder / "report.json"
        (folder / "schedule.json").write_text(json.dumps(schedule))
        build("verilator", [source], TOP, folder / "model", brief=brief)
        try:
            run("verilator", TOP, folder / "model", "sim.verify.soak.soak_tb",
                env={"SYSTEM_SIZE": size, "SCHEDULE": folder / "schedule.json", "SEED": seed, "REPORT": report})
        except SimulationError as error:
            recovered = json.loads(report.read_text())["recovered"] if report.exists() else 0
            return {"failed": _reason(str(error)), "recovered": recovered}
        return dict(json.loads(report.read_text()))


def _reason(log: str) -> str:
    """The line of a simulation's log that says what failed."""
    lines = [line.strip() for line in log.splitlines()]
    told = [line for line in lines if line.partition(":")[0].rpartition(".")[2].endswith(("Error", "Violation"))]
    return told[-1] if told else lines[-1] if lines else "no message"


def run_seed(schedule: Schedule, seed: int, size: str, source: Path, *, brief: bool = False) -> dict[str, Any]:
    """A run's report; if it fails, its reason and the smallest schedule that was found to fail, for the same reason or another."""
    found = soak(schedule, seed, size, source, brief=brief)
    if "failed" in found:
        begun = first(schedule, found["recovered"] + 1)
        found["schedule"] = smallest(begun, lambda less: "failed" in soak(less, seed, size, source, brief=brief))
    return found
