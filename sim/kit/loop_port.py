"""A simulated board at a serial port of this machine: the Verilog of :class:`hdl.loop.system.LoopSystem` behind a pseudo-terminal."""

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from golden.config import MatcherConfig
from hdl.emit import write_verilog
from hdl.loop.sdram_store import SdramStores
from hdl.loop.store import BlockStores
from hdl.loop.system import LoopSystem

from .simulators import ROOT, SimulationError, build


__all__ = ["BIT_CYCLES", "TOP", "small_board", "simulated_port"]


#: Cycles of a bit: the fewest that the receiver takes.
BIT_CYCLES = 16

_BAUD = 1_000_000
#: Name of the top module.
TOP = "loop_system"

# A byte takes 160 clocks. The board waits for the next one for so many clocks that the simulator needs less time for them than a host
# pauses after an error, with two waits of a millisecond in which nothing is on the line.
_IDLE_CLOCKS = 400
_FRAME_CLOCKS = 2 * _IDLE_CLOCKS

# Longest time until a simulator has started, seconds.
_START_SECONDS = 60.0

_RUN = "import sys; from sim.kit.simulators import run; run(*sys.argv[1:4], 'sim.kit.loop_port_tb', env={environment!r})"


def small_board(config: MatcherConfig, height: int, *, sdram: bool = False) -> LoopSystem:
    """A board whose line and time-out are as short as they can be in a simulation; with pictures in an SDRAM, or in memory blocks."""
    clock_hz = BIT_CYCLES * _BAUD
    stores = SdramStores(config, height, clock_hz) if sdram else BlockStores(config, height)
    return LoopSystem(stores, clock_hz, _BAUD, frame_seconds=_FRAME_CLOCKS / clock_hz)


@contextlib.contextmanager
def simulated_port(system: LoopSystem, folder: Path, *, verilog: Path | None = None, faults: Mapping[str, Any] | None = None,
                   simulator: str = "verilator", idle_clocks: int = _IDLE_CLOCKS) -> Iterator[str]:
    """Name of a port behind which the board runs, for the block.

    Parameters
    ----------
    system : LoopSystem
        From :func:`small_board`.
    folder : Path
        Of Verilog, model and logs, and of this run alone.
    verilog : Path
        Of the same ports, in place of the system's own.
    faults : mapping
        ``to_board`` and ``to_host``: the ``kind``, ``every`` and ``after`` of ``Line`` in ``loop_port_tb``. ``unplugged``: bytes of
        the host after which the port disappears. ``dead``: the board is in reset.
    """
    folder.mkdir(parents=True, exist_ok=True)
    source = verilog or write_verilog(system, folder / f"{TOP}.v", name=TOP)
    build(simulator, [source], TOP, folder / simulator)
    for name in ("port", "stop"):
        (folder / name).unlink(missing_ok=True)
    environment = {"BIT_CYCLES": BIT_CYCLES, "IDLE_CLOCKS": idle_clocks, "LOOP_FOLDER": str(folder.resolve()),
                   "SDRAM_HZ": system.clock_hz if "memory" in system.stores.outside else 0, "LOOP_FAULTS": json.dumps(faults or {})}
    # In a process of its own: cocotb's runner changes the environment while it works.
    with (folder / "port.log").open("w") as log:
        process = subprocess.Popen([sys.executable, "-c", _RUN.format(environment=environment), simulator, TOP, str(folder / simulator)],
                                   cwd=ROOT, stdout=log, stderr=subprocess.STDOUT, env=dict(os.environ), start_new_session=True)
        try:
            until = time.monotonic() + _START_SECONDS
            while not (folder / "port").exists():
                if process.poll() is not None or time.monotonic() > until:
                    raise SimulationError(f"{simulator} did not start the board: {(folder / 'port.log').read_text()[-2000:]}")
                time.sleep(0.01)
            yield (folder / "port").read_text()
        finally:
            (folder / "stop").touch()
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
    if process.returncode:
        raise SimulationError(f"the simulated board failed: {(folder / 'port.log').read_text()[-2000:]}")
