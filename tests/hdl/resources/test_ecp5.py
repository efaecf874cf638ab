"""Place and route: the steps that its log tells of, and its reasons."""

import pytest

from hdl.resources import lattice
from hdl.resources.ecp5 import ECP5


# Lines of a log, and the steps that are told.
LOG = """\
Info: Packing IOs..
Info: Creating initial analytic placement for 11416 cells, random placement wirelen = 1454207.
Info:     at initial placer iter 0, wirelen = 4788
Info:     at iteration #12, type ALL: wirelen solved = 14475, spread = 19712, legal = 24568; time = 0.50s
Info:   at iteration #5: temp = 0.000000, timing cost = 332, wirelen = 21788
Info: Routing 51340 arcs.
Info:      15000 |     4840      10159 |  196   804 |     44496|      10.47     125.94|
Info: Program finished normally.
"""
STEPS = ["packing", "placing", "placing, round 12", "refining the placement, round 5", "routing", "routing, 44496 wires left"]


@pytest.mark.parametrize("more, end, reason", [
    ("", "sys.exit(0)", None), ("ERROR: no Bels left\nERROR: more\n", "sys.exit(1)", "no Bels left"),
    ("", "sys.exit(1)", "it gave no reason"), ("ERROR: ignored\n", "sys.exit(0)", None),
    ("", "os.kill(os.getpid(), 9)", "it was ended by the signal SIGKILL")])
def test_run_nextpnr(more, end, reason, tmp_path, monkeypatch):
    steps = []
    monkeypatch.setattr(lattice, "_NEXTPNR", f"import os, sys; print({LOG + more!r}, *sys.argv[1:], sep='', flush=True); {end}")
    assert ECP5.run_nextpnr(tmp_path, ["--seed", "1"], tmp_path / "log", steps.append) == reason
    assert steps == STEPS
    assert (tmp_path / "log").read_text() == f"{LOG}{more}--seed1\n"
