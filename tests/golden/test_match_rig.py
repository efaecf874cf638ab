"""`python -m golden match --rig FILE --balance`: the stages before the matcher, and bad input of theirs."""

import numpy as np
import pytest

from golden.__main__ import main
from golden.config import MatcherConfig
from golden.matcher.matcher import match
from golden.pictures.images import write_picture
from golden.pictures.scenes import scene
from golden.rig.balance import balance
from golden.rig.files import Rig, write_rig
from golden.rig.fit import fit_map
from golden.rig.maps import identity


ARGUMENTS = ["match", "left.png", "right.png", "--disparities", "16", "--output", "d.npy"]


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """A working folder with a pair whose right picture is two lines lower and darker, and with rigs."""
    monkeypatch.chdir(tmp_path)
    left, right, _ = scene(120, 40, 16, seed=1)
    right = np.rint(0.7 * np.roll(right, 2, axis=0)).astype(np.uint8)
    write_picture("left.png", left)
    write_picture("right.png", right)
    y, x = np.mgrid[:40, :120].astype(float)
    plain = identity(120, 40)
    write_rig("rig.json", Rig(plain, fit_map(x, y + 2)))
    write_rig("plain.json", Rig(plain, plain))
    write_rig("small.json", Rig(identity(120, 39), identity(120, 39)))
    return left, right


def expected(left, right):
    return match(left, right, MatcherConfig(labels=16))["disparity"]


def test_identity_changes_nothing(pair):
    assert main([*ARGUMENTS, "--rig", "plain.json"]) == 0
    np.testing.assert_array_equal(np.load("d.npy"), expected(*pair))


def test_rectified_then_balanced(pair, tmp_path):
    left, right = pair
    right = np.concatenate([right[2:], right[-1:], right[-1:]])
    assert main([*ARGUMENTS, "--rig", str(tmp_path)]) == 0
    np.testing.assert_array_equal(np.load("d.npy"), expected(left, right))
    assert main([*ARGUMENTS, "--rig", "rig.json", "--balance"]) == 0
    balanced = balance(left, right, 0, 16)
    np.testing.assert_array_equal(np.load("d.npy"), expected(left, balanced))
    assert (balanced != right).mean() > 0.5


@pytest.mark.parametrize("arguments, message", [
    ([*ARGUMENTS, "--rig", "absent.json"], "cannot read absent.json"),
    ([*ARGUMENTS, "--rig", "small.json"], "left.png has 120x40 pixels and small.json is for 120x39; calibrate at the size of the pictures"),
    (["match", "--output", "d.npy", "--rig", "rig.json"], "--rig rig.json is for the cameras' own pictures; give LEFT and RIGHT"),
    ([*ARGUMENTS[:-1], "rig.json", "--rig", "rig.json"], "rig.json has the suffix .json"),
])
def test_refused(pair, tmp_path, capsys, arguments, message):
    assert main(arguments) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1 and not (tmp_path / "d.npy").exists()
