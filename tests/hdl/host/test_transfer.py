"""hdl.host.transfer: blocks are on their way before replies to those before are received; rates as docs/loop.md states them."""

import re
from pathlib import Path

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass
from golden.host.loop_device import LoopDevice
from hdl.host.chip import Chip
from hdl.host.transfer import get_lines, put_lines, seconds_of_pair
from sim.models.loop_line import LoopLine


WIDTH, HEIGHT = 20, 100
LINES = [(0, line, np.full(WIDTH, line, np.uint8).tobytes()) for line in range(HEIGHT)]


class Ahead(LoopLine):
    """Counts the writes since the last byte was read that the host waited for."""
    def __init__(self, *args, **faults):
        super().__init__(*args, **faults)
        self.row = self.most = 0

    def write(self, data):
        super().write(data)
        self.row += 1
        self.most = max(self.most, self.row)

    def read(self, count, seconds):
        self.row = max(0, self.row - 1)
        return super().read(count, seconds)


def board(**faults):
    line = Ahead(LoopDevice(MatcherConfig(4, WIDTH, method=OnePass()), HEIGHT), **faults)
    chip = Chip(line)
    line.row = line.most = 0
    return line, chip


def test_lines_there_and_back():
    told = []
    line, chip = board()
    put_lines(chip, LINES, 3_000_000, lambda done, total: told.append((done, total)))
    assert told == [(number, HEIGHT) for number in range(1, HEIGHT + 1)]
    assert (line.device.pictures[0] == np.arange(HEIGHT)[:, None]).all()
    assert line.most == 64
    line.device.values["kept"] = 1
    line.most = 0
    assert get_lines(chip, 0, HEIGHT, WIDTH, 3_000_000, lambda done, total: None) == [data for _, _, data in LINES]
    assert line.most == 8 and chip.repeated == 0


def test_nothing_to_send():
    line, chip = board()
    put_lines(chip, [], 3_000_000, lambda done, total: None)
    assert get_lines(chip, 0, 0, WIDTH, 3_000_000, lambda done, total: None) == [] and line.most == 0


def test_one_block_at_a_time_after_a_fault():
    """So that a line which is slow does not fall behind: the next fault costs a block, not all that were sent ahead."""
    line, chip = board()
    first = line.writes + 30
    line.to_board = lambda number, data: b"" if first <= number < first + 1 else data
    sizes = []
    put_lines(chip, LINES, 3_000_000, lambda done, total: sizes.append(line.writes))
    assert (line.device.pictures[0] == np.arange(HEIGHT)[:, None]).all() and chip.repeated == 1
    assert np.diff(sizes)[30:35].tolist() == [2, 3, 5, 9, 17]   # each good reply doubles what is on its way


@pytest.mark.parametrize("baud, most", [(9600, 2), (115_200, 12), (921_600, 64)])
def test_slow_lines_have_less_on_their_way(baud, most):
    """28 bytes of a block in at most 30 ms: what an error costs ends before the host has given up."""
    line, chip = board()
    put_lines(chip, LINES, baud, lambda done, total: None)
    assert line.most == most


def test_many_faults_that_are_not_in_a_row():
    line, chip = board()
    line.to_board = lambda number, data: b"" if number % 23 == 0 else data
    put_lines(chip, LINES, 3_000_000, lambda done, total: None)
    assert (line.device.pictures[0] == np.arange(HEIGHT)[:, None]).all() and chip.repeated > chip.ATTEMPTS


@pytest.mark.parametrize("row", re.findall(r"^\| (\d+)x(\d+) \| (\d) \| (.*) \|$",
                                           (Path(__file__).parents[3] / "docs" / "loop.md").read_text(), re.MULTILINE))
def test_rates_of_the_page(row):
    width, height, count = map(int, row[:3])
    assert row[3] == " | ".join(f"{1 / seconds_of_pair(width, height, count, baud):.3f}" for baud in (115_200, 921_600, 3_000_000))


def test_time_of_a_pair_by_hand():
    """Two pictures of two lines of four pixels, and their results of two bytes; ten bits a byte."""
    assert seconds_of_pair(4, 2, 2, 10) == 4 * (6 + 4 + 2) + 2 * (6 + 8 + 2) + 12
