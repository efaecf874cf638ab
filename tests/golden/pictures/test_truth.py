"""golden.pictures.truth: marks of unknown disparities, and scales, that are told from what a truth holds."""

import types

import numpy as np
import pytest

from golden.cli import Parser
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.pictures.images import write_picture
from golden.pictures.truth import add_truth_options, check_truth_options, read_truth


SHAPE = (10, 20)


def ramp(unknown=0.0, count=60):
    """Disparities 0.5 .. 15 of which so many are a mark."""
    values = np.linspace(0.5, 15, 200)
    values[:count] = unknown
    return values.reshape(SHAPE)


@pytest.fixture
def read(tmp_path, monkeypatch):
    """Reads an array as a truth, from a file of that suffix, with further arguments."""
    monkeypatch.chdir(tmp_path)

    def read(values, *arguments, suffix=".pfm", minimum=0):
        name = f"truth{suffix}"
        values = np.asarray(values)
        if suffix == ".npy":
            np.save(name, values)
        else:
            write_picture(name, values if suffix == ".pfm" else values.astype(np.uint16 if values.max() > 255 else np.uint8))
        parser = Parser()
        add_truth_options(parser)
        options = parser.parse_args(["--truth", name, *arguments])
        check_truth_options(options)
        config = MatcherConfig(16) if minimum >= 0 else types.SimpleNamespace(minimum=minimum, labels=16)
        return read_truth(options, SHAPE, config)

    return read


@pytest.mark.parametrize("suffix", [".pfm", ".npy"])
@pytest.mark.parametrize("mark", [-1, -16, 0, 9999, 1e9])
def test_the_option_names_the_mark(read, capsys, suffix, mark):
    truth, mask = read(ramp(mark), "--truth-unknown", f"{mark:.0f}", suffix=suffix)
    np.testing.assert_array_equal(mask, ramp(np.inf) < 99)
    np.testing.assert_allclose(truth, ramp(np.inf), rtol=1e-6)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("mark", [-0.1, 3.4028234663852886e+38, -3.4028234663852886e+38, 1e10, -12345.678])
def test_a_mark_is_rounded_as_the_file_rounds_it(read, capsys, mark):
    """And what a message says of it can be given back."""
    if mark < 0:
        with pytest.raises(UserError) as error:
            read(ramp(mark))
        told = str(error.value)
    else:
        read(ramp(mark))
        told = capsys.readouterr().err
    for given in (told.rpartition("=")[2].strip(), repr(mark)):
        _, mask = read(ramp(mark), f"--truth-unknown={given}")
        assert mask.sum() == 140 and capsys.readouterr().err == ""


def test_a_mark_beyond_the_numbers_of_the_file(read, capsys):
    read(ramp(0.5), "--truth-unknown", "1e300")
    assert "no number in truth.pfm is 1e+300" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".pfm", ".png"])
def test_a_mark_that_is_not_there(read, capsys, suffix):
    read(np.ceil(ramp(0.5)), "--truth-unknown", "-16", suffix=suffix)
    assert capsys.readouterr().err == f"note: no number in truth{suffix} is -16, which marks unknown disparities\n"
    read(np.ceil(ramp(0.5)), "--truth-unknown", "nan", suffix=suffix)
    assert capsys.readouterr().err == ""


def test_the_mark_is_in_units_of_the_file(read):
    truth, mask = read((16 * ramp(-1)).astype(np.int16), "--truth-unknown", "-16", "--truth-scale", "16", suffix=".npy")
    assert mask.sum() == 140 and truth[mask].min() > 0


@pytest.mark.parametrize("mark, scale", [(-1, 1), (-16, 16), (-1, 3), (-1000, 1)])
def test_a_mark_below_0_is_recognised(read, mark, scale):
    with pytest.raises(UserError) as error:
        read(ramp(mark), "--truth-scale", str(scale))
    told = f"truth.pfm holds 60 pixels of exactly {mark}, 30% of it, which is below 0; if {mark} marks unknown disparities"
    assert told in str(error.value) and f"give --truth-unknown={mark}" in str(error.value)


def test_one_pixel_of_a_mark_suffices_below_0(read):
    with pytest.raises(UserError, match="give --truth-unknown=-1"):
        read(ramp(-1, 1))


def test_a_mark_among_other_negative_numbers(read):
    values = ramp(-1)
    values[9, :9] = -0.25 * np.arange(1, 10)
    with pytest.raises(UserError, match=r"61 pixels of exactly -1.*--truth-unknown=-1"):
        read(values)
    with pytest.raises(UserError, match=r"holds the disparity -15, which is below 0; .* swap the pictures or the sign"):
        read(-ramp(0.5))


@pytest.mark.parametrize("mark, suffix", [(0, ".pfm"), (0, ".npy"), (9999, ".pfm"), (255, ".npy"), (255, ".png"), (18, ".pfm")])
def test_a_good_part_of_one_number_is_told(read, capsys, mark, suffix):
    _, mask = read(ramp(mark) if suffix != ".png" else np.ceil(ramp(mark)), suffix=suffix)
    assert mask.all()
    note, = capsys.readouterr().err.splitlines()
    assert note == (f"note: truth{suffix} holds 60 pixels of exactly {mark}, 30% of it, which counts as a disparity; if {mark} marks "
                    f"unknown disparities, give --truth-unknown={mark}")


LAYERS = np.repeat([0, 0, 0, 3, 3, 5, 5, 8, 8, 9], 20).reshape(SHAPE)


@pytest.mark.parametrize("values", [LAYERS, ramp(0, 9), ramp(12), ramp(np.inf), ramp(np.nan), ramp(15)])
def test_what_is_no_mark(read, capsys, values):
    read(values)
    assert capsys.readouterr().err == ""


def test_0_of_a_png_is_unknown_without_a_note(read, capsys):
    _, mask = read(np.ceil(ramp(0)), suffix=".png")
    assert mask.sum() == 140 and capsys.readouterr().err == ""


def test_negative_disparities_that_are_searched(read, capsys):
    truth, mask = read(ramp(0.5) - 8, minimum=-8)
    assert mask.all() and truth.min() == -7.5
    capsys.readouterr()
    read(np.where(ramp(0) == 0, -999, ramp(0)), minimum=-8)
    assert "60 pixels of exactly -999" in capsys.readouterr().err


@pytest.mark.parametrize("factor, scale, suffix, fit", [
    (4, 1, ".pfm", 4), (16, 1, ".png", 16), (256, 1, ".png", 256), (8, 2, ".pfm", 8), (8, 1, ".npy", 8)])
def test_a_scale_that_would_fit(read, factor, scale, suffix, fit):
    with pytest.raises(UserError, match=rf"median disparity of .* more than the 15 that are searched; correct --truth-scale {scale} or "
                                        rf"raise --disparities; --truth-scale {fit} would fit$"):
        read(np.ceil(ramp(0.5)) * factor, "--truth-scale", str(scale), suffix=suffix)


def test_a_mark_above_is_told_with_the_scale(read):
    with pytest.raises(UserError, match="if 9999 marks unknown disparities, give --truth-unknown=9999"):
        read(ramp(9999, 120))


def test_a_mark_far_above_numbers_of_another_scale(read):
    values = 4 * ramp(0.5)
    values[0] = 255
    with pytest.raises(UserError, match=r"--truth-scale 4 would fit; if 255 marks unknown disparities, give --truth-unknown=255"):
        read(values, suffix=".npy")


def test_a_scale_that_is_too_great(read):
    with pytest.raises(UserError, match="below 1 pixel only with --truth-scale 256; correct it; --truth-scale 1 would fit"):
        read(ramp(0.5), "--truth-scale", "256")


def test_other_units(read, capsys):
    read(ramp(0.5) / 100)
    assert "note: truth.pfm holds disparities below 1 pixel only; unless" in capsys.readouterr().err


def test_many_that_are_not_searched(read, capsys):
    read(ramp(0.5) * 2)
    assert "of the disparities of truth.pfm are above the 15 pixels that are searched; raise --disparities or correct --truth-scale 1; " \
           "--truth-scale 2 would fit" in capsys.readouterr().err


@pytest.mark.parametrize("arguments, message", [
    (["--truth-unknown", "-1"], "--truth-unknown -1 is for --truth, which is missing"), (["--truth-unknown", "x"], "invalid float value")])
def test_option_refused(arguments, message):
    parser = Parser()
    add_truth_options(parser)
    with pytest.raises(UserError, match=message):
        check_truth_options(parser.parse_args(arguments))


def test_nothing_known(read):
    with pytest.raises(UserError, match=r"holds no known disparity; .* or another --truth-unknown"):
        read(np.full(SHAPE, -1.0), "--truth-unknown", "-1")
