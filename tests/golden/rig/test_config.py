"""golden.rig.config: what rectification and balance are built with."""

import pytest

from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.maps import identity, pack
from sim.kit.rig_cases import camera_map


def test_maps_and_row_offset():
    left, right = identity(64, 40), camera_map(64, 40, roll=1)
    config = RigConfig(22, Rig(left, right, 5))
    assert config.maps == {"left": pack(left), "right": pack(right)} and config.row_offset == 5
    assert RigConfig().maps == {} and RigConfig().row_offset == 0


def _both(which):
    return Rig(which, which)


@pytest.mark.parametrize("make, told", [
    (lambda: RigConfig(30), "rectifiers can hold 22, 34, 44, 56, 68 lines, not 30; choose one of these"),
    (lambda: RigConfig(22, _both(camera_map(200, 60, roll=10))), r"this map needs 37 lines and the gateware holds 22: .*44"),
    (lambda: RigConfig(rig=_both(identity(64, 40))).check_size(720, 576),
     "the rig is for pictures of 64x40 pixels, and the cameras send 720x576; calibrate at this size"),
])
def test_refused(make, told):
    with pytest.raises(ValueError, match=told):
        make()
