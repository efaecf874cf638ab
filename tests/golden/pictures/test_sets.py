"""golden.pictures.sets: either layout, what is derived where a set does not tell it, and what is refused."""

import json
import shutil

import numpy as np
import pytest

from golden.errors import UserError
from golden.pictures import sets
from golden.pictures.dataset import MASKS, PAIRS
from golden.pictures.images import write_picture
from golden.pictures.masks import computed_masks
from golden.pictures.scenes import layers


NAMES = {"ours": ("left", "right", "disp_left", "disp_right"), "middlebury": ("view1", "view5", "disp1", "disp5")}


def write_set(folder, layout="ours", meta=None, height=30, scale=3, both=True, unknown=0, labels=8):
    """A synthetic set; pictures, and truths as they should be read."""
    left, right, truth, _ = layers(50, height, labels, len(folder.name))
    truth = truth.astype(float)
    truth[3:5, 20:30] = np.inf
    other = np.full_like(truth, 2.0)
    other[:, 30:] = np.inf
    folder.mkdir(parents=True)
    for name, picture in zip(NAMES[layout], (left, right, truth, other)[:4 if both else 3]):
        if name.startswith("disp"):
            # Disparity 0 cannot be told from unknown where that is 0.
            picture = np.where(np.isinf(picture), unknown, picture * scale).astype(np.uint8)
        write_picture(folder / f"{name}.png", picture)
    if meta is not None:
        (folder / "meta.json").write_text(json.dumps(meta))
    if unknown == 0:
        truth[truth == 0] = np.inf
    return left, right, truth, other if both else None


def same(pair, written):
    left, right, truth, other = written
    assert (pair.left == left).all() and (pair.right == right).all() and np.allclose(pair.truth, truth)
    expected = computed_masks(truth, other)
    assert list(pair.masks) == list(MASKS) and all((pair.masks[name] == mask).all() for name, mask in expected.items())


@pytest.mark.parametrize("both", [True, False])
@pytest.mark.parametrize("layout, height, scale, meta", [
    ("ours", 30, 3, {"scale": 3}), ("ours", 370, 4, {"scale": 4}), ("middlebury", 370, 3, None), ("middlebury", 555, 2, None),
    ("middlebury", 1110, 1, None), ("middlebury", 30, 5, {"scale": 5}), ("middlebury", 370, 2, {"scale": 2}),
    ("middlebury", 370, 3, {"disp_range": [0, 7]}),
])
def test_layouts(tmp_path, layout, height, scale, meta, both):
    written = write_set(tmp_path / "a", layout, meta, height, scale, both)
    pair, = sets.sets_in(tmp_path)
    assert (pair.name, pair.disparities) == ("a", 8)
    same(pair, written)
    assert sets.sets_in(tmp_path / "a")[0].name == "a"


def test_a_folder_of_both_layouts(tmp_path, monkeypatch):
    write_set(tmp_path / "b", "middlebury", height=370)
    write_set(tmp_path / "c", meta={"scale": 3})
    write_set(tmp_path / "a", meta={"scale": 3})
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").write_text("no set")
    assert [pair.name for pair in sets.load_data(tmp_path)] == ["a", "b", "c"]
    assert [pair.name for pair in sets.load_data(tmp_path, ["c", "b"])] == ["c", "b"]
    monkeypatch.chdir(tmp_path / "c")
    assert [pair.name for pair in sets.load_data(".")] == [pair.name for pair in sets.load_data(".", ["c"])] == ["c"]


def test_a_set_itself(tmp_path):
    """What is in its folder does not count, and neither do files of the other layout."""
    written = write_set(tmp_path / "a", meta={"scale": 3})
    write_set(tmp_path / "a" / "inner", meta={"scale": 3})
    for name in NAMES["middlebury"]:
        write_picture(tmp_path / "a" / f"{name}.png", np.ones((9, 9), np.uint8))
    for place in (tmp_path, tmp_path / "a"):
        pair, = sets.load_data(place)
        same(pair, written)


def test_the_mark_of_unknown_disparities(tmp_path, capsys):
    same(sets.sets_in(tmp_path)[0] if write_set(tmp_path / "a", meta={"scale": 3, "unknown_value": 0}) else None,
         write_set(tmp_path / "other" / "a", meta={"scale": 3}))
    shutil.rmtree(tmp_path / "a")
    written = write_set(tmp_path / "b", meta={"scale": 3, "unknown_value": 255}, unknown=255)
    same(sets.sets_in(tmp_path, ["b"])[0], written)
    assert (written[2] == 0).any() and capsys.readouterr().err == ""  # 0 is a disparity there


def test_masks_that_are_there_are_kept(tmp_path):
    left, *_ = write_set(tmp_path / "a", meta={"scale": 3})
    computed = sets.sets_in(tmp_path)[0].masks
    mask = np.zeros(left.shape, np.uint8)
    mask[3, 4:9], mask[5] = 255, 128
    write_picture(tmp_path / "a" / "nonocc.png", mask)
    kept = sets.sets_in(tmp_path)[0].masks
    assert kept["nonocc"].sum() == 5 and kept["nonocc"][3, 4:9].all()
    assert all((kept[name] == computed[name]).all() for name in ("all", "disc")) and list(kept) == list(MASKS)


@pytest.mark.parametrize("greatest, labels", [(5, 8), (6.5, 8), (7, 8), (7.25, 16), (8, 16), (20, 24)])
def test_labels_cover_the_truth(tmp_path, greatest, labels):
    write_set(tmp_path / "a", meta={"scale": 4})
    write_picture(tmp_path / "a" / "disp_left.png", np.full((30, 50), 4 * greatest).astype(np.uint8))
    assert sets.sets_in(tmp_path)[0].disparities == labels


def test_the_benchmark_is_known_by_its_pairs(tmp_path, capsys):
    for name in PAIRS:
        write_set(tmp_path / name, meta={"scale": 3})
        for mask in MASKS:
            write_picture(tmp_path / name / f"{mask}.png", np.full((30, 50), 255, np.uint8))
    pairs = sets.load_data(tmp_path)
    assert [pair.name for pair in pairs] == list(PAIRS)  # in the benchmark's order, with its scales and labels
    assert [pair.disparities for pair in pairs] == [labels for labels, _ in PAIRS.values()]
    assert [pair.name for pair in sets.load_data(tmp_path, ["teddy", "venus"])] == ["teddy", "venus"]
    assert capsys.readouterr().err == ""
    write_set(tmp_path / "aloe", meta={"scale": 3})
    assert [pair.name for pair in sets.load_data(tmp_path)] == list(PAIRS)
    assert "aloe, which do not belong to it" in capsys.readouterr().err
    shutil.rmtree(tmp_path / "venus")
    assert [pair.name for pair in sets.load_data(tmp_path)] == ["aloe", "cones", "teddy", "tsukuba"]


@pytest.mark.parametrize("change, message", [
    (lambda folder: shutil.rmtree(folder / "a"), "holds no set; give the benchmark, one with tsukuba, venus, teddy, cones, or a "),
    (lambda folder: (folder / "a" / "disp1.png").unlink(), "a holds view1.png, but no truth disp1.png"),
    (lambda folder: (folder / "a" / "view5.png").unlink(), "view5.png does not exist"),
    (lambda folder: write_picture(folder / "a" / "view5.png", np.zeros((370, 49), np.uint8)), "49x370"),
    (lambda folder: write_picture(folder / "a" / "disp1.png", np.ones((9, 9), np.uint8)), "disp1.png and its left picture differ in size"),
    (lambda folder: write_picture(folder / "a" / "disp5.png", np.ones((9, 9), np.uint8)), "disp5.png and its left picture differ in size"),
    (lambda folder: write_picture(folder / "a" / "all.png", np.ones((9, 9), np.uint8)), "all.png and its left picture differ in size"),
    (lambda folder: write_picture(folder / "a" / "disp1.png", np.zeros((370, 50), np.uint8)), "disp1.png holds no known disparity"),
    (lambda folder: (folder / "a" / "meta.json").write_text('{"scale": 0.5}'), "needs 512 labels, not 2 to 256"),
    (lambda folder: (folder / "a" / "meta.json").write_text('{"disp_range": [0, 0]}'), "needs 1 labels, not 2 to 256"),
    (lambda folder: (folder / "a" / "meta.json").write_text('{"scale": -3}'), "has the scale -3, which is not above 0"),
    (lambda folder: (folder / "a" / "meta.json").write_text('{"scale": "x"}'), "does not tell the scale"),
    (lambda folder: (folder / "a" / "meta.json").write_text('{"disp_range": [0, 1e999]}'), "does not tell the scale"),
    (lambda folder: (folder / "a" / "meta.json").write_text("[" * 100_000), "its brackets are nested too deeply"),
])
def test_refused(tmp_path, change, message):
    write_set(tmp_path / "a", "middlebury", height=370)
    write_picture(tmp_path / "a" / "disp1.png", np.full((370, 50), 255, np.uint8))
    change(tmp_path)
    with pytest.raises(UserError) as caught:
        sets.load_data(tmp_path)
    assert message in str(caught.value)


def test_an_unknown_height_needs_a_scale(tmp_path):
    write_set(tmp_path / "a", "middlebury", height=100)
    with pytest.raises(UserError, match=r"does not tell the scale .* 100 lines are none of Middlebury's 370, 555, 1110"):
        sets.sets_in(tmp_path)


def test_names_that_are_not_there(tmp_path):
    write_set(tmp_path / "a", meta={"scale": 3})
    with pytest.raises(UserError, match=r"holds no set b; those there are a$"):
        sets.load_data(tmp_path, ["a", "b"])


def test_noise(tmp_path):
    write_set(tmp_path / "a", meta={"scale": 3}, height=300)
    pair, = sets.sets_in(tmp_path)
    noisy, again, other = sets.with_noise(pair, 2), sets.with_noise(pair, 2), sets.with_noise(pair, 2, seed=2)
    assert (noisy.left == again.left).all() and (noisy.right == again.right).all() and (noisy.left != other.left).any()
    assert noisy.truth is pair.truth and noisy.masks is pair.masks and noisy.left.dtype == np.uint8
    inside = (pair.left > 10) & (pair.left < 245)
    added = (noisy.left.astype(int) - pair.left)[inside]
    assert abs(added.mean()) < 0.1 and added.std() == pytest.approx(2.02, abs=0.06)  # rounding adds a twelfth to the variance
    right = noisy.right.astype(int) - pair.right
    assert abs(np.corrcoef(added, right[inside])[0, 1]) < 0.05
    assert (sets.with_noise(pair, 0).left == pair.left).all()
    # Clipped, not wrapped.
    dark = sets.with_noise(sets.with_noise(pair, 200), 0)
    assert (dark.left == 0).mean() > 0.1 and (dark.left == 255).mean() > 0.1
