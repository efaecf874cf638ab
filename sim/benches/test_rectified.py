"""The matcher behind rectification and balance as emitted Verilog, against the golden model, on whole pictures: sim/kit/harness.v."""

import itertools

import numpy as np
import pytest

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, OnePass
from golden.lab.mounting import Mounting
from golden.pictures.dataset import StereoPair
from golden.pictures.scenes import scene
from golden.rig.balance import Auto, Fixed
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.rectify import move_rows
from hdl.emit import write_verilog
from hdl.rectified import RectifiedMatcher
from hdl.rig.balance import BalanceMode
from sim.kit.harness import mismatches, simulate
from sim.kit.rig_cases import noise_map


THESIS = MatcherConfig(4, 35, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR))
SEQUENTIAL = MatcherConfig(4, 35, engine=Engine.SEQUENTIAL, method=OnePass(Arithmetic.THESIS))
FUSED = MatcherConfig(8, 70, -5, method=FUSED_1)
RECURSIVE = MatcherConfig(8, 70, method=RECURSIVE_1)


def starts(result):
    """Clocks from each frame's first disparity to the next one's."""
    return [after.start - before.start for before, after in itertools.pairwise(result.frames)]


@pytest.mark.parametrize("simulator, config", [
    pytest.param("icarus", THESIS, id="icarus"),
    # Slow: the same on the simulator that compiles for long.
    pytest.param("verilator", THESIS, id="verilator", marks=pytest.mark.slow),
    # Slow: other engines behind the same stages, of which the sequential one is slower than they are; windows that a negative least
    # disparity moves apart.
    pytest.param("icarus", SEQUENTIAL, id="sequential", marks=pytest.mark.slow),
    pytest.param("icarus", FUSED, id="fused", marks=pytest.mark.slow),
    pytest.param("icarus", RECURSIVE, id="recursive", marks=pytest.mark.slow),
])
def test_pairs(simulator, config, tmp_path):
    """Maps of the build and automatic balance, then other settings of both and of the matcher; clocks a frame, and latency."""
    width, height, labels = config.max_width, 14, config.labels
    rig = Rig(*(noise_map(width, height, 90, seed) for seed in (1, 2)), 2)
    core = RectifiedMatcher(config, height, RigConfig(22, rig))
    verilog = write_verilog(core, tmp_path / "core.v", name="matcher")
    pairs = [scene(width, height, labels, seed)[:2] for seed in range(4)]
    pairs = [(left, (right * 0.7).astype(np.uint8)) for left, right in pairs]

    def run(pairs, **arguments):
        lefts, rights = zip(*pairs)
        return simulate(config, lefts, rights, simulator=simulator, work_dir=tmp_path, verilog=verilog, core=core, **arguments)

    result = run([(left, move_rows(right, rig.row_offset)) for left, right in pairs])
    auto = Auto(config.minimum, labels)
    for number, pair in enumerate(pairs):
        left, right = rig.rectified(*pair)
        assert mismatches(result, number, left, auto.pair(left, right), config) == 0
    assert auto.gain > 300
    bound = core.frame_clocks(width, height)
    assert all(bound / 3 < clocks <= bound for clocks in starts(result))
    assert result.frames[0].latency <= core.latency_lines * max(width, core.full_rate_width) * core.clocks_per_pixel + core.latency_clocks

    # Smaller pictures; without rectification of any size. The labels in use are the matcher's setting.
    pairs = [(left[:9, :21], right[:9, :21]) for left, right in pairs[:2]]
    fixed = {"rectify": 0, "balance": BalanceMode.FIXED, "fixed_gain": 400, "fixed_offset": -3000, "width": 21, "height": 9, "in_use": 3}
    result = run(pairs, settings=fixed, stall_i=0.2, stall_o=0.2)
    for number, (left, right) in enumerate(pairs):
        assert mismatches(result, number, left, Fixed(400, -3000).pair(left, right), config.with_settings({"in_use": 3})) == 0


# Slow: whole pictures of the board, which take minutes to compile and to simulate.
@pytest.mark.slow
@pytest.mark.parametrize("method", [RECURSIVE_1, FUSED_1], ids=lambda method: method.name)
def test_full_size(method, tmp_path):
    """Mounted cameras with lenses, the right one rolled, lower and darker, still: from the third pair on balanced; with and without."""
    width, height, labels = 720, 576, 80
    config = MatcherConfig(labels, width, method=method)
    left, right, truth = scene(width, height, labels, seed=1)
    mounting = Mounting()
    seen = mounting.pair(StereoPair("scene", left, right, truth, {}, labels))
    rig = mounting.rig(width, height)
    core = RectifiedMatcher(config, height, RigConfig(rig=rig))
    with_stages = simulate(config, [seen[0]] * 3, [seen[1]] * 3, simulator="verilator", work_dir=tmp_path / "core", core=core)
    pair, auto = rig.rectified(*seen), Auto(0, labels)
    pairs = [(pair[0], auto.pair(*pair)) for _ in range(3)]
    without = simulate(config, [pair[0]] * 2, [pair[1]] * 2, simulator="verilator", work_dir=tmp_path / "matcher")
    wrong = [mismatches(with_stages, number, *each, config) for number, each in enumerate(pairs)]
    print(f"{method.name}, {width}x{height}, {labels} labels: mismatching pixels {wrong} of {width * height} each; "
          f"clocks a frame {starts(with_stages)} (at most {core.frame_clocks(width, height)}), "
          f"without rectification and balance {starts(without)} (at most {core.matcher.frame_clocks(width, height)})")
    assert wrong == [0, 0, 0]
    assert mismatches(without, 0, *pair, config) == 0
    assert max(starts(with_stages)) <= core.frame_clocks(width, height)
