"""golden.lab.mounting and cameras: a mounting is undone by its rig, and the table shows what that is worth."""

import dataclasses
import json
import pathlib
import re

import numpy as np
import pytest

from golden.__main__ import main
from golden.lab.cameras import COLUMNS, pictures
from golden.lab.mounting import Mounting, cubic, linear
from golden.pictures.dataset import StereoPair
from tests.kit import middlebury, only


STRAIGHT = Mounting(0, 0, 0, 1)


def smooth(width=160, height=120):
    """A picture without fine detail, so that interpolation is nearly exact."""
    y, x = np.mgrid[:height, :width]
    return np.rint(120 + 60 * np.sin(x / 9) * np.cos(y / 11) + 40 * np.sin((x + 2 * y) / 14)).astype(np.uint8)


def pair(right=None):
    left = smooth()
    return StereoPair("smooth", left, left if right is None else right, np.zeros(left.shape), {"all": np.ones(left.shape, bool)}, 8)


@pytest.mark.parametrize("sample", [cubic, linear])
def test_samples_by_hand(sample):
    picture = np.array([[0, 100, 200, 60]], np.uint8)
    at = np.array([[-4.0, 0, 1, 1.5, 2, 9]])
    middle = {cubic: 165, linear: 150}[sample]     # (-0 + 9 * 100 + 9 * 200 - 60) / 16 = 165
    assert sample(picture, at, 0 * at).tolist() == [[0, 0, 100, middle, 200, 60]]
    assert sample(picture.T, 0 * at, at).tolist() == [[0, 0, 100, middle, 200, 60]]


def test_straight_cameras_see_the_pair_itself():
    assert (STRAIGHT.pair(pair())[0] == smooth()).all() and (STRAIGHT.pair(pair())[1] == smooth()).all()


@pytest.mark.parametrize("change", [{"offset": 3}, {"roll": 2}, {"lens": -0.2}, {"roll": -1, "offset": -4, "lens": 0.1}], ids=str)
def test_rig_undoes_the_mounting(change):
    mounting = dataclasses.replace(STRAIGHT, **change)
    seen = mounting.pair(pair())
    inner = slice(12, -12), slice(12, -12)
    assert np.abs(seen[1].astype(int) - smooth())[inner].mean() > 2
    for side in mounting.rig(160, 120).rectified(*seen):
        assert np.abs(side.astype(int) - smooth())[inner].mean() < 0.6


def test_directions():
    """The right picture alone is lower; its first lines are what was above them, and grey levels fall by the gain."""
    left, right = dataclasses.replace(STRAIGHT, offset=3, gain=0.5).pair(pair())
    assert (left == smooth()).all()
    assert (right[3:] == np.floor(0.5 * smooth()[:-3] + 0.5)).all() and (right[0] == right[3]).all()
    x, y = dataclasses.replace(STRAIGHT, roll=90).sources(101, 101, 1)
    assert (x[50, 90], y[50, 90]) == pytest.approx((50, 90))    # clockwise, as one looks at the picture


def test_vignetting_and_noise():
    """Corners are darker by what was said, and the rig's gain undoes that; noise is the same at each call, and that of each camera."""
    flat = StereoPair("flat", *2 * [np.full((120, 160), 100, np.uint8)], np.zeros((120, 160)), {}, 8)
    dark = dataclasses.replace(STRAIGHT, vignetting=0.4)
    left, right = dark.pair(flat)
    assert (left == right).all() and (left[0, 0], left[60, 80]) == (61, 100)
    assert np.abs(dark.rig(160, 120).rectified(left, right)[0].astype(int) - 100).max() <= 5
    noisy = dataclasses.replace(STRAIGHT, noise=2)
    first, second = noisy.pair(flat), noisy.pair(flat)
    assert all((a == b).all() for a, b in zip(first, second)) and (first[0] != first[1]).any()
    assert [side.std() for side in first] == pytest.approx([2, 2], abs=0.1)


def test_pictures_of_every_column():
    found = pictures(pair(), Mounting())
    assert [*found] == [*COLUMNS]
    error = {name: np.abs(right.astype(int) - smooth())[12:-12, 12:-12].mean() for name, (_, right) in found.items()}
    assert error["published"] == 0 and max(error[name] for name in ("rectified", "exact", "balanced", "both cured")) < 3
    assert min(error[name] for name in ("mounted", "darker", "both", "both rectified")) > 5


def test_command(tmp_path, capsys):
    middlebury("tsukuba")
    with only("tsukuba"):
        assert main(["cameras", "--methods", "one-pass-thesis", "--json", str(tmp_path / "a.json")]) == 0
    of = json.loads((tmp_path / "a.json").read_text())["figures"]["one-pass-thesis"]
    mean = {column: np.mean(of[column]["tsukuba"]) for column in COLUMNS}
    assert mean["published"] == pytest.approx(9.85, abs=0.005) and f"{mean['both cured']:.2f}" in capsys.readouterr().out
    assert max(mean[name] for name in ("rectified", "exact", "balanced", "both cured")) < 14 < 50 < min(
        mean[name] for name in ("mounted", "darker", "both", "both rectified"))


@pytest.mark.slow  # all pairs and methods, most of a minute; test_command measures one
def test_figures_of_the_page(tmp_path, capsys):
    middlebury("tsukuba")
    assert main(["cameras", "--json", str(tmp_path / "a.json")]) == 0
    figures = json.loads((tmp_path / "a.json").read_text())["figures"]
    page = (pathlib.Path(__file__).parents[3] / "docs" / "cameras.md").read_text(encoding="utf-8")
    told = [re.findall(r"\d+\.\d\d", line) for line in page.partition("*recursive-1* |")[2].splitlines()[2:2 + len(COLUMNS)]]
    assert told == [[f"{np.mean(list(of[column].values())):.2f}" for of in figures.values()] for column in COLUMNS]


@pytest.mark.parametrize("arguments, message", [
    (["--roll", "16"], "--roll must be from -15 to 15, not 16"),
    (["--lens", "nan"], "--lens must be from -0.3 to 0.3, not nan"),
    (["--gain", "0"], "--gain must be above 0 and at most 1, not 0"),
    (["--offset", "50"], "lines and the gateware holds 34: level the cameras"),
])
def test_refused(capsys, arguments, message):
    middlebury("tsukuba")
    with only("tsukuba"):
        assert main(["cameras", *arguments]) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1
