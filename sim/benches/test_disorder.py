"""Bare matchers as emitted Verilog with ragged frames, resets within frames, and all settings from end to end: see ``disorder_tb.py``."""

import pytest

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, OnePass
from hdl.emit import write_verilog
from hdl.matcher.matcher import Matcher
from sim.benches.disorder import run_disorder


LINEAR = OnePass(Arithmetic.LINEAR)


# Slow: the line store, in front of all engines, is the same; tests/hdl has the other engines in Amaranth's simulator.
@pytest.mark.parametrize("config", [
    pytest.param(MatcherConfig(3, 8, engine=Engine.STREAMING, method=LINEAR), id="streaming"),
    pytest.param(MatcherConfig(3, 8, engine=Engine.SEQUENTIAL, method=LINEAR), id="sequential", marks=pytest.mark.slow),
    pytest.param(MatcherConfig(3, 8, method=FUSED_1), id="fused", marks=pytest.mark.slow),
    pytest.param(MatcherConfig(3, 8, method=RECURSIVE_1), id="recursive", marks=pytest.mark.slow),
])
def test_disorder(config, tmp_path):
    verilog = write_verilog(Matcher(config), tmp_path / "matcher.v", name="matcher")
    run_disorder(config, 5, "icarus", verilog, tmp_path)
