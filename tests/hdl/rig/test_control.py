"""hdl.rig.control: settings hold for a pair, maps and row offset change together with the next one."""

import pytest

from golden.rig.config import MapsInUse
from hdl.rig.control import RigControl
from sim.kit.clocked import run_clocked
from tests.kit import refused_components


TOLD = ["row_offset", "stages_swap", "waits", "maps"]


def run(steps, **parameters):
    given = run_clocked(RigControl(**parameters), [{"start": 0, "swap": 0, **step} for step in steps], TOLD)
    return [tuple(int(each[name]) for name in TOLD) for each in given]


def settings(**values):
    return {"settings": {"rectify": 1, "balance": 1, "fixed_gain": 256, "fixed_offset": 0, "minimum": 0, **values}}


def test_swap_waits_for_a_pair():
    on = settings()
    told = run([
        {**on, "wanted_row_offset": 5, "start": 1},                 # nothing was loaded: the offset of the first maps
        {"swap": 1}, {"wanted_row_offset": -7},
        {"start": 1}, {"swapping": 1}, {"swapping": 0, "wanted_row_offset": 9},
        {"start": 1, **settings(rectify=0)}, {"start": 1, **on},
    ], built_in=True, row_offset=3)
    built_in, loaded = MapsInUse.BUILT_IN, MapsInUse.LOADED
    assert told == [
        (3, 0, 0, built_in), (3, 0, 0, built_in), (-7, 0, 1, built_in), (-7, 1, 1, built_in), (-7, 0, 1, loaded), (-7, 0, 0, loaded),
        (0, 0, 0, loaded), (-7, 0, 0, loaded)]


def test_swap_in_the_cycle_of_a_start():
    """It is that of the pair after."""
    told = run([settings(), {"swap": 1, "start": 1, "wanted_row_offset": 4}, {}, {"start": 1}, {}])
    assert [each[:3] for each in told[1:]] == [(0, 0, 0), (4, 0, 1), (4, 1, 1), (4, 0, 0)]
    assert [each[3] for each in told] == [*4 * [MapsInUse.IDENTITY], MapsInUse.LOADED]


def test_settings_hold_for_a_pair():
    dut = RigControl()
    steps = [settings(balance=2, fixed_gain=300, fixed_offset=-5, minimum=-3), {"start": 1}, {"start": 0, **settings(rectify=0)}, {},
             {"start": 1}, {"start": 0}]
    held = [each["held"] for each in run_clocked(dut, steps, ["held"])]
    first, then = (dut.held.shape().const(step["settings"]) for step in (steps[0], steps[2]))
    assert [each.as_bits() for each in held] == [0, 0, *3 * [first.as_bits()], then.as_bits()]


def test_refused():
    with refused_components(), pytest.raises(ValueError, match="row offset must be from -128 to 127, not 128"):
        RigControl(row_offset=128)
