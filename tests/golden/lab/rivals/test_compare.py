"""`python -m golden compare`: figures are those of the methods on the scenes, the sheet shows them, bad input ends with status 2."""

import numpy as np
import pytest

from golden.__main__ import main
from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.lab.rivals import compare
from golden.lab.rivals.registry import METHODS
from golden.matcher.matcher import disparities as match
from golden.pages import read_origin
from golden.pictures.dataset import StereoPair
from golden.pictures.images import read_colours, write_picture
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import SCENES, layers
from golden.pictures.sets import sets_in


FREE = ["--methods", "one-pass-linear", "dynamic-programming"]  # need no package of the extra
GIVEN = ["left.png", "right.png", "--disparities", "8"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A working folder with a pair and its truth, and small scenes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(compare, "SCENE_SIZE", (48, 40, 8))
    left, right, truth, visible = layers(40, 30, 8, 1)
    for name, picture in {"left.png": left, "right.png": right, "truth.npy": truth, "narrow.npy": truth[:, 1:],
                          "mask.png": np.uint8(255) * visible}.items():
        write_picture(name, picture)
    return tmp_path


def figures(printed):
    """``{(view, pixels): figures}`` of a table."""
    found, name = {}, None
    for line in printed.splitlines():
        words = line.split()
        if "." in (words or [""])[-1] and words[-1][-1].isdigit():
            *names, mask = (word for word in words if not word[0].isdigit())
            name = names[0] if names else name
            found[name, mask] = [word for word in words if word[0].isdigit()]
    return found


def linear(pair):
    return match(pair.left, pair.right, MatcherConfig(labels=8, method=OnePass(Arithmetic.LINEAR)))


def test_scenes(capsys):
    assert main(["compare", *GIVEN, "--truth", "truth.npy", *FREE]) == 0
    printed = capsys.readouterr()
    assert printed.err == "" and max(map(len, printed.out.splitlines())) <= 80
    found = figures(printed.out)
    assert list(found) == [("left.png", "known"), *((name, mask) for name in SCENES for mask in ("known", "nonocc", "hard"))]
    for seed, (name, make) in enumerate(SCENES.items(), start=1):
        scene = make(48, 40, 8, seed)
        for mask, counted in (("known", np.ones_like(scene.hard)), ("nonocc", scene.visible), ("hard", scene.hard)):
            expected = [linear(scene), METHODS["dynamic-programming"].function(scene.left, scene.right, 8)]
            assert found[name, mask] == [f"{bad_pixels(labels, scene.truth, counted):.2f}" for labels in expected]
    assert len({tuple(row) for row in found.values()}) > 10
    assert all(printed.out.count(name) == 1 for name in SCENES)  # in the first row of its block


def test_threshold_and_mask(capsys):
    rows = []
    for arguments in ([], ["--threshold", "0"], ["--mask", "mask.png"], ["--threshold", "0", "--mask", "mask.png"]):
        assert main(["compare", *GIVEN, "--truth", "truth.npy", *arguments, "--scenes", *FREE]) == 0
        printed = capsys.readouterr().out
        assert f"more than {int('--threshold' not in arguments)} pixel" in printed
        rows.append(tuple(figures(printed)["left.png", "known"]))
    assert len(set(rows)) == 4


def test_motorcycle_without_pictures(capsys, monkeypatch):
    asked = {}

    def small(**options):
        asked.update(options)
        left, right, truth, visible = layers(40, 30, 8, 1)
        return StereoPair("motorcycle", left, right, truth, {"known": visible}, 8)

    monkeypatch.setattr(compare, "motorcycle", small)
    assert main(["compare", "--scenes", "thin", *FREE]) == 0
    found = figures(capsys.readouterr().out)
    assert list(found) == [("motorcycle", "known"), *(("thin", mask) for mask in ("known", "nonocc", "hard"))]
    assert asked["factor"] == 1 and asked["max_width"] >= 741 and asked["max_height"] >= 500
    pair = small()
    assert found["motorcycle", "known"][0] == f"{bad_pixels(linear(pair), pair.truth, pair.masks['known']):.2f}"


def test_sheet(folder, capsys):
    assert main(["compare", *GIVEN, "--scenes", "slanted", *FREE, "--output", "a.png"]) == 0  # no truth: its panel is black
    assert "no truth" in capsys.readouterr().out
    without = read_colours("a.png").astype(int)
    assert main(["compare", *GIVEN, "--truth", "truth.npy", "--scenes", "slanted", *FREE, "--output", "a.png"]) == 0
    upper, lower = (np.array_split(part, 4, axis=1) for part in np.array_split(read_colours("a.png").astype(int), 2))
    black = (np.array_split(np.array_split(without, 2)[0], 4, axis=1)[1] == 0).all(axis=-1).mean()
    assert black > 0.6 > 0.05 > (upper[1] == 0).all(axis=-1).mean()
    for row in (upper, lower):
        left, *others = (part.reshape(-1, 3) for part in row)
        assert np.ptp(left, axis=-1).max() <= 12  # grey
        assert min((np.ptp(part, axis=-1) > 40).mean() for part in others) > 0.6  # in colours
        assert len({part.tobytes() for part in row}) == 4


def test_every_picture_advances_the_bar(monkeypatch):
    advanced = []
    monkeypatch.setattr("rich.progress.Progress.advance", lambda bar, task: advanced.append(task))
    assert main(["compare", *GIVEN, "--scenes", "thin", "slanted", *FREE]) == 0
    assert len(advanced) == 3 * 2


def test_what_the_sheet_shows(monkeypatch):
    shown = []
    monkeypatch.setattr(compare, "write_comparison", lambda path, strips: shown.extend([path.name, *strips]))
    assert main(["compare", *GIVEN, "--truth", "truth.npy", "--scenes", "thin", *FREE, "--output", "a.png"]) == 0
    name, given, thin = shown
    assert (name, given.name, thin.name) == ("a.png", "left.png", "thin") and given.limits == thin.limits == (0, 7)
    scene = SCENES["thin"](48, 40, 8, 1 + list(SCENES).index("thin"))
    assert (thin.left == scene.left).all()
    titles, pictures = zip(*thin.disparities.items(), strict=True)
    assert [title.split(":")[0] for title in titles] == ["truth", *FREE[1:]]
    expected = [scene.truth, linear(scene), METHODS["dynamic-programming"].function(scene.left, scene.right, 8)]
    assert all((one == other).all() for one, other in zip(pictures, expected, strict=True))
    assert titles[1] == f"one-pass-linear: {bad_pixels(expected[1], scene.truth, np.ones_like(scene.hard)):.1f} % bad"


def test_sets(folder, capsys, monkeypatch):
    """The sets of folders in place of the Motorcycle pair, with an average of every folder."""
    shown = []
    monkeypatch.setattr(compare, "write_comparison", lambda path, strips: shown.extend(strips))
    for seed, name in enumerate(["one/a", "one/b", "two/c"]):
        (folder / name).mkdir(parents=True)
        left, right, truth, _ = layers(40, 30, 8, seed)
        for file, picture in (("left", left), ("right", right), ("disp_left", (4 * truth).astype(np.uint8))):
            write_picture(folder / name / f"{file}.png", picture)
        (folder / name / "meta.json").write_text('{"scale": 4}')
    assert main(["compare", "--data", "one", "two", "--scenes", "thin", *FREE, "--output", "a.png"]) == 0
    printed = capsys.readouterr()
    found = figures(printed.out)
    masks = ("known", "nonocc", "disc")
    sets = {pair.name: pair for pair in [*sets_in("one"), *sets_in("two")]}
    for name, pair in sets.items():
        for mask, counted in zip(masks, (pair.masks[mask] for mask in ("all", "nonocc", "disc")), strict=True):
            assert found[name, mask][0] == f"{bad_pixels(linear(pair), pair.truth, counted):.2f}"
    assert [strip.name for strip in shown] == [*sets, "thin"]
    lines = [line.split() for line in printed.out.splitlines()]
    for folder_name, names in (("one", "ab"), ("two", "c")):
        bad = [bad_pixels(linear(sets[name]), sets[name].truth, mask) for name in names for mask in sets[name].masks.values()]
        line = next(line for line in lines if line[:1] == [folder_name])
        assert line[1:4] == ["average", "of", str(len(bad))] and line[4] == f"{np.mean(bad):.2f}"


@pytest.fixture
def small_motorcycle(monkeypatch):
    left, right, truth, visible = layers(40, 30, 8, 1)
    pair = StereoPair("motorcycle", left, right, truth.astype(float), {"known": visible}, 8)
    monkeypatch.setattr(compare, "motorcycle", lambda **options: pair)
    return pair


def test_page(folder, capsys, small_motorcycle):
    (folder / "docs").mkdir()
    asked = ["compare", "--scenes", "thin", *FREE, "--output", "a.png", "--page", "docs/a.md"]
    assert main(asked) == 0
    text = (folder / "docs" / "a.md").read_text()
    assert read_origin(text)[0] == f"python -m golden {' '.join(asked)}" and "(../a.png)" in text
    compared = [compare.motorcycle_view(), *compare.views(["thin"])]
    assert read_origin(text)[1] == compare.inputs(compared, FREE[1:], 1.0)
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    assert rows[0] == ["scene", "pixels", *(f"`{method}`" for method in FREE[1:])] and len(rows) == 2 + 1 + 3
    printed = figures(capsys.readouterr().out)
    assert rows[2][:2] == ["motorcycle 40x30x8", "all of known truth"] and rows[2][2:] == printed["motorcycle", "known"]
    assert rows[3][0] == "thin 48x40x8" and rows[5][-2:] == printed["thin", "hard"]
    # What is added by hand stays, all else is written again.
    (folder / "docs" / "a.md").write_text(text.replace("thin", "thick") + "\nThin bars are lost.\n")
    assert main(asked) == 0
    assert (folder / "docs" / "a.md").read_text() == text + "\nThin bars are lost.\n"


def test_digest_is_of_the_inputs(small_motorcycle, monkeypatch):
    def found(names=("thin",), methods=FREE[1:], threshold=1.0):
        return compare.inputs([compare.motorcycle_view(), *compare.views(names)], methods, threshold)

    first = found()
    others = [found(names=["slanted"]), found(methods=FREE[1:2]), found(threshold=2.0)]
    with monkeypatch.context() as context:
        context.setattr(METHODS["dynamic-programming"].function, "__defaults__", (50,))
        others.append(found())
    small_motorcycle.masks["known"][0, 0] ^= True
    others.append(found())
    assert len({first, *others}) == 1 + len(others)


@pytest.mark.parametrize("arguments, message", [
    (["left.png"], "left.png has no right picture"),
    (["--page", "a.md"], "--page a.md shows the picture --output, which is missing; give --output FILE too"),
    ([*GIVEN, "--output", "a.png", "--page", "a.md"], "--page a.md is for the Motorcycle pair, not for left.png; leave one of them out"),
    (["--output", "a.png", "--page", "a.html"], "a.html has the suffix .html, which is not one of .md; choose one of these for --page"),
    (["left.png", "right.png"], "--disparities is missing; give the number of disparities of the pictures, 2 to "),
    ([*GIVEN[:-1], "1"], "--disparities must be a whole number from 2 to "),
    (["left.png", "none.png", "--disparities", "8"], "none.png does not exist"),
    ([*GIVEN, "--data", "."], "--data . is in place of LEFT and RIGHT, but left.png is given; leave one of them out"),
    (["--data", ".", "--page", "a.md", "--output", "a.png"], "--page a.md is for the Motorcycle pair, not for --data .; leave one"),
    (["--data", "none"], "the data folder none does not exist"),
    (["--data", "."], ". holds left.png, but no truth disp_left.png"),
    (["--data", ".", "--disparities", "8"], "--disparities 8 is for LEFT and RIGHT, which are missing"),
    (["--disparities", "8"], "--disparities 8 is for LEFT and RIGHT, which are missing"),
    (["--truth", "truth.npy"], "--truth truth.npy is for LEFT and RIGHT, which are missing"),
    ([*GIVEN, "--truth", "narrow.npy"], "narrow.npy has 39x30 pixels"),
    ([*GIVEN, "--mask", "mask.png"], "mask.png masks a ground truth, but there is none"),
    ([*GIVEN, "--scenes", "thin", "thin"], "--scenes names thin more than once"),
    ([*GIVEN, "--scenes", "fog"], "fog"),
    ([*GIVEN, "--methods", "none"], "none"),
    ([*GIVEN, "--methods", "one-pass-linear", "one-pass-linear"], "--methods names one-pass-linear more than once"),
    ([*GIVEN, "--output", "a.txt"], "a.txt has the suffix .txt"),
    ([*GIVEN, "--output", "none/a.png"], "the folder none of a.png does not exist"),
])
def test_bad_input(folder, capsys, arguments, message):
    asked = [*arguments, *([] if "--methods" in arguments else FREE)]
    asked += [] if {"--output", "--page"} & {*arguments} else ["--output", "a.png"]
    assert main(["compare", *asked]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("golden compare: ") and message in printed.err
    assert not list(folder.glob("a.*"))


def test_package_missing(capsys, monkeypatch):
    monkeypatch.setattr("golden.lab.workers.importlib.util.find_spec", lambda name: None)
    assert main(["compare"]) == 2
    assert capsys.readouterr().err == "golden compare: cv2 is not installed; install the extra lab of this package\n"
