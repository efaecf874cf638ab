"""golden.video.bandwidth: numbers worked by hand, and refusals."""

import pytest
from rich.console import Console

from golden.errors import UserError
from golden.video.bandwidth import Budget, MemoryTiming, grant_clocks, served_clocks
from golden.video.formats import DISPLAYS, PAL, CameraFormat
from golden.video.memory_map import MemoryMap


def test_latency_by_hand():
    assert grant_clocks(6, 16, 2, 100) == 192 + 100 + 2
    assert served_clocks(6, 16, 2, 100) == 224 + 100 + 3
    assert served_clocks(3, 5, 1.5, 0) == 30 + 3
    assert grant_clocks(1, 1, 1.01, 0) == 2 + 2      # a part of a clock is a clock


def test_efficiency_by_hand():
    timing = MemoryTiming()
    # 24 of 585 clocks are refreshes. 45 words in 3 bursts, each of which loses 14 clocks.
    assert timing.refresh_share == pytest.approx(24 / 585)
    assert timing.efficiency(45, 3) == pytest.approx(45 / 87 * 561 / 585)
    assert Budget().available == pytest.approx(37_201_592)


def test_another_clock():
    """The longest stall stays 100 us; the FIFOs that bridge it hold as many words, or a few more for what else takes longer."""
    assert MemoryTiming.at(75_000_000) == MemoryTiming()
    slow = MemoryTiming.at(62_500_000)
    assert (slow.clock_hz, slow.stall_clocks) == (62_500_000, 6250)
    budget, fast = Budget(timing=slow), Budget()
    budget.check()
    assert budget.available < fast.available * 62.5 / 75
    assert fast.camera_depth <= budget.camera_depth <= fast.camera_depth + 2
    assert fast.display_depth <= budget.display_depth <= fast.display_depth + 4


def test_demands_by_hand():
    budget = Budget()
    words = {demand.name: demand.words_per_second for demand in budget.demands}
    # 45 words in each of 15,625 lines a second; 576 lines in 3/8 of 40 ms; 45 words of two lines in each of 31,250 lines a second.
    assert words["left camera, written"] == words["right camera, written"] == 703_125
    for name in ("disparity, written", "left picture shown, written", "left of the pair, read", "right of the pair, read"):
        assert words[name] == pytest.approx(45 * 576 / 0.015)
    assert words["disparity shown, read"] == words["left picture shown, read"] == 2_812_500
    assert len(words) == 8
    assert budget.used == pytest.approx(2 * 703_125 + 4 * 1_728_000 + 2 * 2_812_500)
    assert budget.demands[0].bytes_per_second == 11_250_000
    budget.check()
    # Two buffers: a frame's time less the window. Three: a whole frame's time.
    assert Budget(window=0.7).reading_seconds == pytest.approx(0.3 * 0.040)
    assert Budget(memory_map=MemoryMap(buffers=3), window=0.7).reading_seconds == pytest.approx(0.040)
    # Of three, one is of a kept pair.
    assert Budget(memory_map=MemoryMap(buffers=3), window=0.7, kept=1).reading_seconds == pytest.approx(0.3 * 0.040)
    # 1344 pixels of 65 MHz a line.
    assert Budget(display=DISPLAYS["1024x768"]).demands[-1].words_per_second == pytest.approx(2 * 45 * 65e6 / 1344)


def test_depths_by_hand():
    budget = Budget()
    pace = 1 / budget.efficiency
    assert pace == pytest.approx(2.016, abs=1e-3)
    # 8 * 16 * 2.016 = 258.1, and 7500 + 3 + 30.
    assert budget.latency_clocks(7500) == 259 + 7533
    # 103.89 us: one line of 64 us, 45 words, and 39.89 us of the next one, 539 pixels of 13.5 MHz, 34 words.
    assert budget.camera_depth == 16 + 45 + 34 + 1
    # Three lines of 32 us, 135 words, and 7.89 us, 214 pixels of 27 MHz, 14 words.
    assert budget.display_depth == 16 + 2 * (135 + 14) + 1
    # Five lines of 20.68 us, and 0.51 us: 34 pixels.
    assert Budget(display=DISPLAYS["1024x768"]).display_depth == 16 + 2 * (225 + 3) + 1
    # 292 clocks, a word in 16.16 of them.
    assert budget.matcher_depth == 16 + 19 + 1


def test_depths_of_a_whole_line():
    """A stall that ends within the blanking: the line under way counts whole, not more."""
    timing = MemoryTiming(stall_clocks=75 * 60 - 259 - 33)
    assert Budget(timing=timing).camera_depth == 16 + 45 + 1


def test_refuses_what_cannot_be_served():
    slow = Budget(timing=MemoryTiming(clock_hz=20_000_000), matcher_clocks=0.1)
    with pytest.raises(UserError, match=r"^cameras, matcher and monitor need 13\.9 million words a second of memory, and it serves 8\.8 "
                                        r"at 20 MHz: choose a smaller picture, a monitor of fewer pixels or a faster memory clock$"):
        slow.check()
    # 720 pixels of two lines in each of 48,363 lines a second.
    with pytest.raises(UserError, match=r"^the monitor needs 69\.6 million pixels a second, and the frame store sends one a clock, of "
                                        r"69 MHz: choose a slower monitor or a faster memory clock$"):
        Budget(display=DISPLAYS["1024x768"], timing=MemoryTiming(clock_hz=69_000_000)).check()
    Budget(display=DISPLAYS["1024x768"], timing=MemoryTiming(clock_hz=70_000_000)).check()


def test_refuses_a_slow_matcher():
    # 414,720 pixels of 6 clocks at 75 MHz.
    with pytest.raises(UserError, match=r"^the matcher takes 33\.2 ms to read a pair, and with 2 buffers it has 15\.0 ms: choose 3 "
                                        r"buffers, a matcher of fewer clocks a pixel or a smaller picture$"):
        Budget(matcher_clocks=6).check()
    Budget(matcher_clocks=6, memory_map=MemoryMap(buffers=3)).check()
    for buffers in (2, 3):      # a third buffer does not help
        with pytest.raises(UserError, match=rf"with {buffers} buffers it has [0-9.]+ ms: choose a matcher of"):
            Budget(matcher_clocks=8, memory_map=MemoryMap(buffers=buffers)).check()


def test_refuses_nonsense():
    with pytest.raises(ValueError, match=r"laid out for 704x576 pixels, and the cameras send 720x576: choose the same size"):
        Budget(memory_map=MemoryMap(704, 576))
    with pytest.raises(ValueError, match=r"matcher_clocks must be above 0, not 0"):
        Budget(matcher_clocks=0)
    with pytest.raises(ValueError, match=r"clock_hz must be at least 1, not 0"):
        MemoryTiming(clock_hz=0)
    with pytest.raises(ValueError, match=r"row_clocks must not be negative, not -1"):
        MemoryTiming(row_clocks=-1)
    with pytest.raises(ValueError, match=r"24 clocks each 7800 ns leaves no time for data at 3000000 Hz: choose a faster clock"):
        MemoryTiming(clock_hz=3_000_000)


def test_table():
    """A row for each demand, and their sum."""
    console = Console(width=120)
    with console.capture() as capture:
        console.print(Budget().table())
    text = capture.get()
    assert "memory, 37.2 million words of 16 bytes a second at 75 MHz" in text
    rows = {line.strip("│ ").split("│")[0].strip(): line for line in text.splitlines() if "│" in line}
    assert {demand.name for demand in Budget().demands} < set(rows)
    assert [cell.strip() for cell in rows["left camera, written"].strip("│ ").split("│")[1:]] == ["11.2", "703,125", "1.9%"]
    assert [cell.strip() for cell in rows["all"].strip("│ ").split("│")[1:]] == ["223.1", "13,943,250", "37.5%"]


def test_small_camera():
    camera = CameraFormat(width=20, field_lines=3)
    assert Budget(memory_map=MemoryMap(20, 6), camera=camera).demands[0].words_per_second == 2 * 27e6 / camera.line_bytes
    assert PAL.frame_seconds == pytest.approx(0.04)
