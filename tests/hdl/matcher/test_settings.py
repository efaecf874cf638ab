"""hdl.matcher.settings: which settings a matcher has, and when they are taken."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass, changed
from hdl.matcher.settings import held_settings, setting_ports
from sim.kit.clocked import run_clocked


THESIS = MatcherConfig(labels=20, in_use=11, method=changed(OnePass(Arithmetic.LINEAR), u1=7, u2=0, u3=63))
FUSED = MatcherConfig(labels=128, minimum=255, method=changed(FUSED_1, u1=1, u2=2, u3=3, check=True, fill=False, median=True))
BARE = MatcherConfig(labels=2, method=changed(FUSED_1, check=False, fill=False, median=False))
CONFIGS = pytest.mark.parametrize("config", [THESIS, FUSED, BARE], ids=["thesis", "fused", "bare"])


def widths_of(config):
    ports = setting_ports(config)
    assert all(port.flow is wiring.In for port in ports.values())
    return {name: Shape.cast(port.shape).width for name, port in ports.items()}


def test_ports():
    common = {"u1": 6, "u2": 6, "u3": 6, "in_use": 9, "apply_settings": 1}
    assert widths_of(THESIS) == common
    assert widths_of(FUSED) == common | {"minimum": 8, "check": 1, "fill": 1, "median": 1}


def test_defaults():
    assert THESIS.defaults == {"u1": 7, "u2": 0, "u3": 63, "in_use": 11}
    assert FUSED.defaults == {"u1": 1, "u2": 2, "u3": 3, "in_use": 128, "minimum": 255, "check": True, "fill": False, "median": True}
    assert [BARE.defaults[name] for name in ("check", "fill", "median")] == [False] * 3


class Holder(wiring.Component):
    """Shows the settings that are in force, each under its name with ``_now`` behind it."""
    def __init__(self, config):
        self.config = config
        ports = setting_ports(config)
        super().__init__(ports | {f"{name}_now": Out(port.shape) for name, port in ports.items() if name != "apply_settings"})

    def elaborate(self, platform):
        m = Module()
        for name, value in held_settings(m, self, self.config).items():
            m.d.comb += getattr(self, f"{name}_now").eq(value)
        return m


@CONFIGS
def test_held_settings(config):
    """Those of the configuration until the first pulse, then those of the latest one, all of them together."""
    rng = np.random.default_rng(1)
    widths = widths_of(config)
    names = list(config.defaults)
    assert set(names) == set(widths) - {"apply_settings"}
    inputs = [{name: int(rng.integers(2**widths[name])) for name in names} | {"apply_settings": int(cycle >= 5 and rng.random() < 0.3)}
              for cycle in range(60)]
    out = run_clocked(Holder(config), inputs, [f"{name}_now" for name in names])
    expected, now = [], {name: int(value) for name, value in config.defaults.items()}
    for word in inputs:
        expected.append({f"{name}_now": now[name] for name in names})
        if word["apply_settings"]:
            now = word
    assert [{name: int(value) for name, value in word.items()} for word in out[:len(inputs)]] == expected
