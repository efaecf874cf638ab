"""`python -m golden data`: the pictures that are meant, other encodings of them, and others."""

import hashlib
import shutil

import numpy as np
import pytest
from PIL import Image

from golden.__main__ import main
from golden.errors import UserError
from golden.pictures import checksums
from golden.pictures.dataset import PAIRS, data_folder


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of small pairs that the sums are those of."""
    rng = np.random.default_rng(1)
    names = [f"{pair}/{name}" for pair in PAIRS for name in checksums.FILES]
    for name in names:
        path = tmp_path / "data" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        shape = (5, 7, 3) if name.endswith(("left.png", "right.png")) and "disp" not in name else (5, 7)
        Image.fromarray(rng.integers(0, 256, shape, dtype=np.uint8)).save(path)
    for attribute, digest in (("SUMS", lambda path: hashlib.sha256(path.read_bytes()).hexdigest()), ("PIXEL_SUMS", checksums.pixel_digest)):
        list_ = tmp_path / attribute
        list_.write_text("".join(f"{digest(tmp_path / 'data' / name)}  {name}\n" for name in names))
        monkeypatch.setattr(checksums, attribute, list_)
    return tmp_path / "data"


def check(folder, capsys):
    status = main(["data", "--check", str(folder)])
    return status, *capsys.readouterr()


def test_the_lists_name_every_picture():
    names = [f"{pair}/{name}" for pair in PAIRS for name in checksums.FILES]
    for path in (checksums.SUMS, checksums.PIXEL_SUMS):
        found = checksums.sums(path)
        assert list(found) == names and len(set(found.values())) == len(names)
        assert all(len(digest) == 64 and int(digest, 16) for digest in found.values())


def test_the_lists_are_those_of_the_pictures():
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    files, pixels = checksums.sums(checksums.SUMS), checksums.sums(checksums.PIXEL_SUMS)
    for name, digest in files.items():
        assert checksums.state(folder, name, digest, "") == checksums.SAME
        assert checksums.pixel_digest(folder / name) == pixels[name]


def test_all_there(folder, capsys):
    status, out, err = check(folder, capsys)
    assert (status, err) == (0, "") and "24 pictures are those of the figures" in out


@pytest.mark.parametrize("name, encode", [
    ("left.png", lambda picture, path: picture.save(path, compress_level=0)),
    ("disc.png", lambda picture, path: picture.convert("RGB").save(path)),
    ("disc.png", lambda picture, path: picture.convert("P").save(path)),
])
def test_another_encoding_is_the_same(folder, capsys, name, encode):
    path = folder / "venus" / name
    with Image.open(path) as picture:
        picture.load()
        encode(picture, path)
    status, out, _ = check(folder, capsys)
    assert status == 0 and out.count("same") == 1


@pytest.mark.parametrize("change, word", [
    (lambda path: Image.fromarray(np.zeros((5, 7), np.uint8)).save(path), "differs"),
    (lambda path: path.write_bytes(b"no picture"), "differs"),
    (lambda path: path.unlink(), "missing"),
    (lambda path: (path.unlink(), path.mkdir()), "missing"),
])
def test_another_picture(folder, capsys, change, word):
    change(folder / "teddy" / "nonocc.png")
    status, _, err = check(folder, capsys)
    assert status == 2 and f"first teddy/nonocc.png: {word}; get them as docs/data.md says" in err and err.count("\n") == 1
    assert "1 of 24" in err


def test_a_turned_picture_differs(folder):
    """The bytes alone do not tell a picture from one of another shape."""
    path = folder / "cones" / "all.png"
    before = checksums.pixel_digest(path)
    with Image.open(path) as picture:
        levels = np.asarray(picture)
    Image.fromarray(levels.reshape(7, 5)).save(path)
    assert checksums.pixel_digest(path) != before


def test_no_folder(tmp_path, capsys):
    shutil.rmtree(tmp_path / "none", ignore_errors=True)
    status, out, err = check(tmp_path / "none", capsys)
    assert (status, out) == (2, "") and "does not exist" in err
