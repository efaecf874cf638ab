"""golden.rig.files: a rig is read as it was written, and what cannot be one is refused in a sentence."""

import dataclasses
import json

import numpy as np
import pytest

from golden.errors import UserError
from golden.rig.files import Rig, read_rig, write_rig
from golden.rig.fit import fit_map
from golden.rig.maps import identity, pack
from golden.rig.rectify import rectify


def rig(row_offset=0):
    y, x = np.mgrid[:40, :50].astype(float)
    return Rig(fit_map(x + 0.5, y + 1), fit_map(x - 0.02 * y, y + 0.02 * x), row_offset)


def test_as_it_was_written(tmp_path):
    before = rig(-3)
    write_rig(tmp_path / "rig.json", before)
    for path in (tmp_path / "rig.json", tmp_path):
        after = read_rig(path)
        assert after.row_offset == -3 and after.size == (50, 40)
        assert [pack(side) for side in (after.left, after.right)] == [pack(side) for side in (before.left, before.right)]


def test_rectified():
    left, right = np.random.default_rng(1).integers(0, 256, (2, 40, 50), dtype=np.uint8)
    first, second = rig(2).rectified(left, right)
    assert (first == rectify(left, rig().left)).all()
    assert (second == rectify(np.concatenate([right[2:], right[-1:], right[-1:]]), rig().right)).all()


def test_lines_of_both():
    assert Rig(identity(64, 64), identity(64, 64)).lines == 2
    assert rig().lines == 3


def test_rigs_that_cannot_be():
    with pytest.raises(ValueError, match="maps are for pictures of 50x40 and 50x41 pixels"):
        Rig(identity(50, 40), identity(50, 41))
    with pytest.raises(ValueError, match="row_offset must be a whole number from -128 to 127, not 200"):
        rig(200)
    with pytest.raises(ValueError, match="row bounds"):
        Rig(identity(50, 40), dataclasses.replace(identity(50, 40), bounds=np.ones(3, int)))


@pytest.mark.parametrize("change, message", [
    ({"format": "else"}, "is not a rig; give the rig.json of golden calibrate"),
    ({"version": 2}, "is a rig of version 2, and version 1 can be read"),
    ({"left": ["0"]}, "cannot be a rig: a map for 50x40 pixels has 12 words, not 1"),
    ({"right": ["zz"] * 12}, "cannot be a rig: invalid literal .*; calibrate again$"),
    ({"width": "50"}, "cannot be a rig"),
    ({"row_offset": 1.5}, "row_offset must be a whole number"),
    ({"left": None}, "cannot be a rig"),
    ({"height": ...}, "has no height; calibrate again"),
])
def test_refused(tmp_path, change, message):
    path = tmp_path / "rig.json"
    write_rig(path, rig())
    document = {**json.loads(path.read_text()), **change}
    path.write_text(json.dumps({name: value for name, value in document.items() if value is not ...}))
    with pytest.raises(UserError, match=message):
        read_rig(path)


def test_no_file(tmp_path):
    with pytest.raises(UserError, match=r"cannot read .*rig\.json: No such file"):
        read_rig(tmp_path)
    for text in ("width=3", "[" * 100_000):
        (tmp_path / "a.txt").write_text(text)
        with pytest.raises(UserError, match="is not a rig"):
            read_rig(tmp_path / "a.txt")
