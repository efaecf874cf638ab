"""The whole system as emitted Verilog, from two cameras to the monitor; see ``system_tb.py``, and ``system.v`` for the full size."""

import json
import re

import numpy as np
import pytest

from golden.pictures.images import read_picture, write_picture
from sim.benches.system_faults import FAULTS
from sim.benches.system_sizes import SIZES
from sim.system import main, run_small


# The faults of the first run.
SOME = ("left camera's clock stops and comes back", "fields swapped", "one-bit errors of timing codes", "memory stalls for 100 us")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of the small system, which is emitted and built once."""
    return tmp_path_factory.mktemp("system")


def test_glance(folder):
    """With the fused method: a minimum disparity and fractions, which the monitor's picture does not have."""
    run_small(folder, "glance", size="glance", brief=True)


# Slow: larger pictures and more settings than at a glance; with the other methods monitor, host and cameras do the same.
@pytest.mark.slow
@pytest.mark.parametrize("size", ["small fused", "small", "small recursive"])
def test_pictures(folder, size):
    run_small(folder, "pictures", size=size)


# Slow: a kept pair, block reads and their reader have tests of their own.
@pytest.mark.slow
def test_grab(folder):
    """A pair that is kept and read while the system runs."""
    run_small(folder, "grab", size="small fused")


# Slow: the blocks that take the pair are tested with faults in tests/hdl/host/test_put.py.
@pytest.mark.slow
@pytest.mark.parametrize("size", ["glance", "small"])
def test_put(folder, size):
    """A pair of the host's in place of the cameras', and theirs afterwards."""
    run_small(folder, "put", size=size)


# Slow: loading maps takes long; the rectifier's benches load them, and miss lines, too.
@pytest.mark.slow
def test_maps(folder):
    """Maps that the host loads, a wrong one, a black camera."""
    run_small(folder, "maps", size="small fused")


# Slow: few faults with the method fused; the blocks that count them have tests of their own.
@pytest.mark.slow
@pytest.mark.parametrize("size, names", [("small fused", SOME), ("small", tuple(FAULTS))], ids=["some", "all"])
def test_faults(folder, size, names):
    report = folder / "faults.json"
    run_small(folder, "faults", size=size, FAULTS=json.dumps(names), REPORT=str(report))
    told = json.loads(report.read_text())
    assert [entry["fault"] for entry in told] == list(names)
    assert all(entry["count"] > 0 and entry["counter"] == FAULTS[entry["fault"]].counter for entry in told)


@pytest.mark.slow
def test_fills(folder, capsys):
    assert main(["--frames", "100", "--output", str(folder)]) == 0
    out = capsys.readouterr().out
    fills = re.findall(r"│ (\w+) +│ +(\d+) │ +(\d+) │", out)
    assert len(fills) == 5 and all(0 < int(fill) <= int(size) for _, fill, size in fills)
    assert "% of what there is" in out


@pytest.mark.slow
def test_full_size(tmp_path, capsys):
    """Pictures that are not of the cameras' size; every label wins somewhere."""
    camera = SIZES["full"].camera
    rng = np.random.default_rng(1)
    right = rng.integers(0, 256, (600, 700), dtype=np.uint8)
    left = np.stack([np.roll(row, y // 8) for y, row in enumerate(right)])
    for name, picture in (("left", left), ("right", right)):
        write_picture(tmp_path / f"{name}.png", picture)
    assert main([str(tmp_path / "left.png"), str(tmp_path / "right.png"), "--output", str(tmp_path / "out")]) == 0
    assert re.search(r"mismatching pixels at the monitor +│ +0 │", capsys.readouterr().out)
    picture = read_picture(tmp_path / "out" / "monitor.png")
    assert picture.shape == (camera.height, camera.width) and picture.max() > 200


@pytest.mark.parametrize("arguments, told", [
    (["one.png"], "LEFT and RIGHT are two pictures, not 1"), (["--frames", "0"], "--frames must be at least 1, not 0"),
    (["--frames", "2", "--faults"], "choose one"), (["none.png", "none.png"], "none.png"),
    (["a.png", "b.png", "--faults"], "LEFT, RIGHT and --mounted are for the full size"),
    (["--mounted", "--frames", "2"], "LEFT, RIGHT and --mounted are for the full size"),
])
def test_bad_input(arguments, told, tmp_path, capsys):
    assert main([*arguments, "--output", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert re.match(f"sim.system: .*{told}", err) and err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
