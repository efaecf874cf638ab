"""golden.lab.sparsification: curves worked by hand, the figures of the four pairs, and the command."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig
from golden.lab.sparsification import area, area_above_oracle, main, sparsification
from golden.matcher.fused import match
from tests.kit import middlebury, only


def test_curve():
    bad = np.array([True, False, False, True])
    assert sparsification(np.array([0, 3, 2, 1]), bad).tolist() == [0, 0, 100 / 3, 50]
    assert sparsification(np.array([3, 0, 1, 2]), bad).tolist() == [100, 100, 200 / 3, 50]
    assert sparsification(np.zeros(4), bad).tolist() == [50] * 4  # knows nothing: the share stays


def test_equal_confidence_is_kept_in_random_order():
    # The mean over all orders of the two that are equal.
    bad = np.array([False, True, False])
    assert sparsification(np.array([2, 2, 1]), bad).tolist() == [50, 50, 100 / 3]
    either = [sparsification(np.array(order), bad) for order in ([3, 2, 1], [2, 3, 1])]
    assert sparsification(np.array([2, 2, 1]), bad).tolist() == np.mean(either, axis=0).tolist()


def test_area():
    bad = np.array([True, False, False, True])
    assert area(sparsification(np.zeros(4), bad)) == 50
    assert area_above_oracle(np.array([1, 2, 2, 1]), bad) == 0
    assert area_above_oracle(np.array([0, 3, 2, 1]), bad) == pytest.approx(0)
    assert area_above_oracle(np.zeros(4), bad) == pytest.approx(50 - (100 / 3 + 50) / 4)


@pytest.mark.parametrize("name, expected, of_random", [
    ("tsukuba", 0.54, 4.04), ("venus", 0.29, 1.29), ("teddy", 1.49, 11.43), ("cones", 0.73, 8.61),
])
def test_confidence_ranks_errors(name, expected, of_random):
    pair = middlebury(name)
    result = match(pair.left, pair.right, MatcherConfig(labels=pair.disparities, method=FUSED_1))
    bad = np.abs(result.disparity - pair.truth)[pair.masks["all"]] > 1
    confidence = result.confidence[pair.masks["all"]]
    assert area_above_oracle(confidence, bad) == pytest.approx(expected, abs=0.005)
    assert area_above_oracle(np.zeros(bad.size), bad) == pytest.approx(of_random, abs=0.005)
    # The four bits are used, and the share of bad pixels falls from level to level.
    levels = [bad[(confidence >= low) & (confidence < low + 4)].mean() for low in (0, 4, 8, 12)]
    assert levels == sorted(levels, reverse=True) and levels[0] > 0.3 and levels[-1] < 0.03


@pytest.mark.parametrize("suffix, start", [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_command(capsys, tmp_path, suffix, start):
    output = tmp_path / f"a{suffix}"
    with only("tsukuba"):
        assert main(["--output", str(output)]) == 0
    assert output.read_bytes().startswith(start)
    printed = capsys.readouterr()
    assert printed.err == ""
    line = next(line for line in printed.out.splitlines() if "tsukuba" in line)
    assert line.replace("│", " ").split() == ["tsukuba", "4.12", "1.55", "0.79", "0.50", "0.35", "0.26", "0.54", "4.04"]


@pytest.mark.parametrize("arguments, message", [
    (["--output", "a.jpg"], "a.jpg has the suffix .jpg"),
    (["--cost", "thesis"], "--cost is now --method; write --method thesis"),
    (["--method", "thesis"], "--method thesis has no confidence; choose --method fused"),
    (["--arithmetic", "thesis"], "--arithmetic thesis cannot compute the method fused"),
    (["--data", "none"], "the data folder none does not exist"),
    (["surplus"], "unrecognized arguments: surplus"),
])
def test_bad_input(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("golden sparsification: ") and message in printed.err
