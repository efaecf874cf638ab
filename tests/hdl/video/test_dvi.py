# amaranth: UnusedElaboratable=no
import random

import numpy as np
import pytest

import hdl.video.dvi
from golden.video.formats import DISPLAYS, DisplayFormat
from hdl.video.dvi import DisplayOutput, DviTiming
from sim.kit.clocked import run_clocked
from sim.kit.display_cases import SMALL_DISPLAY, Fetch, shown_pictures, shown_words
from tests.hdl.video.display_runs import CONFIG, LABELS, SIZE, run_display


def check_pictures(plan, pictures, settings):
    assert len(plan) == len(pictures)
    for number, (entry, picture, (mode, colour)) in enumerate(zip(plan, pictures, settings)):
        np.testing.assert_array_equal(picture, entry.picture(SMALL_DISPLAY, mode, colour, LABELS), f"frame {number}")


def check(plan, run):
    """The monitor's pictures and the counters agree with the plan."""
    check_pictures(plan, run.pictures, run.settings)
    assert run.underflows == np.cumsum([0, *(entry.underflow for entry in plan)]).tolist()
    assert run.frames == list(range(len(plan) + 1))


def pairs(count, size=SIZE):
    return [shown_pictures(*size, LABELS, seed) for seed in range(count)]


def test_timing_of_a_small_format():
    """3x2 pixels in 6x5, by hand; from the last pixel before vertical blanking on, twice."""
    names = ("x", "y", "de", "hsync", "vsync", "frame_start", "frame_end")
    given = run_clocked(DviTiming(DisplayFormat(3, range(4, 5), 6, 2, range(3, 4), 5, 1)), [{}] * 61, names)
    lines = {
        "de": ["111000", "111000", "000000", "000000", "000000"],
        "hsync": ["111101"] * 5,
        "vsync": ["111111", "111111", "111111", "000000", "111111"],
        "frame_start": ["000000", "000000", "100000", "000000", "000000"],
        "frame_end": ["000000", "000000", "000000", "000000", "000001"],
    }
    for clock, cycle in enumerate(given):
        y, x = divmod(clock + 11, 6)
        wanted = {"x": x, "y": y % 5, **{name: int(line[y % 5][x]) for name, line in lines.items()}}
        assert cycle == wanted, f"clock {clock}"


@pytest.mark.parametrize("name, horizontal, vertical, hertz", [
    ("720x576", (720, 732, 796, 864), (576, 581, 586, 625), 50.0),
    ("1024x768", (1024, 1048, 1184, 1344), (768, 771, 777, 806), 60.004),
])
def test_formats(name, horizontal, vertical, hertz):
    """CEA-861 formats 17 and 18, and VESA's."""
    display = DISPLAYS[name]
    assert (display.width, display.h_sync.start, display.h_sync.stop, display.h_total) == horizontal
    assert (display.height, display.v_sync.start, display.v_sync.stop, display.v_total) == vertical
    assert display.frames_per_second == pytest.approx(hertz, abs=0.001)


@pytest.mark.parametrize("colour", [0, 1])
@pytest.mark.parametrize("mode", range(4))
def test_modes(mode, colour):
    plan = [Fetch(pair, stall=stall) for pair, stall in zip(pairs(3), (0.0, 0.3, 0.0))]
    check(plan, run_display(plan, mode=mode, colour=colour))


@pytest.mark.parametrize("size", [(18, 10), (2, 2), (7, 5), (17, 9), (3, 2)])
def test_sizes(size):
    """The whole display, the smallest picture, odd ones. Mode ``both`` takes up to 36 words in 24 pixels' time."""
    modes = set()
    for reader_skips, clocks in ((False, (120, 65)), (True, (75, 65))):
        plan = [Fetch(pair) for pair in pairs(6, size)]
        run = run_display(plan, size=size, clocks=clocks, reader_skips=reader_skips, change=0.4)
        check(plan, run)
        modes |= {min(mode, 2) for mode, _ in run.settings}
    assert modes == {0, 1, 2}


@pytest.mark.parametrize("clocks", [(75, 27), (65, 65), (40, 65), (31, 65), (300, 65)])
def test_clocks(clocks):
    plan = [Fetch(pair) for pair in pairs(3)]
    check(plan, run_display(plan, clocks=clocks, mode=2, colour=1))


def test_settings_change_with_fetch_only():
    """They are other ones in every second cycle."""
    plan = [Fetch(pair) for pair in pairs(8)]
    run = run_display(plan, change=0.5)
    check(plan, run)
    assert len({tuple(settings) for settings in run.settings}) >= 5


LONG = 10_000   # cycles: the next fetch is earlier
LATE = 260      # cycles: the picture's second line has been shown; the frame has 388


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_underflow(mode):
    """Black from the missing pixel on, one count, and the next frame is bit-exact; also if the rest is sent later."""
    good, *pair = pairs(9)
    plan = []
    for entry in (
        Fetch(pair[0], in_time=0, pause=(0, LONG)),
        Fetch(pair[1], in_time=0, delay=LATE),             # fills the FIFO nevertheless
        Fetch(pair[2], in_time=0, words=[]),
        Fetch(pair[3], in_time=82, pause=(82, LONG)),      # the last word of mode `both`
        Fetch(pair[4], in_time=16, pause=(16, LATE)),      # in the second line; the rest is late
        Fetch(pair[5], in_time=26, pause=(26, LONG)),
        Fetch(pair[6], in_time=48, pause=(48, LONG)),      # between two lines
        Fetch(pair[7], in_time=1, pause=(1, LONG)),
    ):
        plan += [Fetch(good), entry] if entry.in_time else [entry]
    plan.append(Fetch(good))
    run = run_display(plan, mode=mode, colour=1)
    check(plan, run)
    assert run.fill == 0


def test_no_picture_is_black_and_no_underflow():
    """Even if words are sent."""
    none, *pair = pairs(3)
    silent, full = Fetch(none, shown_valid=False, words=[]), Fetch(none, shown_valid=False)
    plan = [silent, Fetch(pair[0]), full, silent, Fetch(pair[1])]
    check(plan, run_display(plan, colour=1))


def test_words_left_over():
    """Words of the old picture before the new one, and a FIFO full of them; at first a whole picture but for its first word."""
    pair = pairs(5)
    old = shown_words(*pair[0])
    plan = [Fetch(pair[1], stale=old[1:]), Fetch(pair[2], in_time=13, pause=(13, LATE)), Fetch(pair[3], stale=old[60:61]),
            Fetch(pair[4], words=shown_words(*pair[4]) + old)]
    check(plan, run_display(plan))
    check(plan, run_display(plan, clocks=(65, 75)))


def ragged():
    """Pictures with one fault each, and after how many words."""
    pair = pairs(1)[0]
    words = shown_words(*pair)
    yield "a line too short", pair, 34, words[:34] + words[35:]
    yield "a line too long", pair, 35, words[:35] + words[34:]
    yield "a picture too short", pair, 84, words[:84]
    yield "first in mid-picture", pair, 40, words[:40] + words
    yield "another picture after the first line", pair, 12, words[:12] + words
    yield "nothing but first", pair, 1, words[:1] * 50
    yield "no first", pair, 0, words[1:]
    yield "wider", pair, 11, shown_words(*(np.pad(picture, ((0, 0), (0, 1))) for picture in pair))
    yield "narrower", pair, 10, shown_words(*(picture[:, :11] for picture in pair))
    yield "higher", pair, None, words + words[12:24]


def test_ragged_pictures():
    """What is good of them is shown, the rest is black; the next one is exact."""
    good = pairs(1)[0]
    plan = [entry for _, pair, in_time, words in ragged() for entry in (Fetch(pair, in_time=in_time, words=words), Fetch(good))]
    check(plan, run_display(plan))


def test_fifo_bridges_a_pause():
    """16 words in memory, one in a register: 10 pixels and the way of the next word are bridged, 30 are not; ``fill`` tells."""
    size = (18, 10)
    pair = pairs(2, size)
    fills = {}
    for pause in (0, 5, 10, 30):
        plan = [Fetch(pair[0], pause=(56, pause), in_time=56 if pause == 30 else None), Fetch(pair[1])]
        run = run_display(plan, size=size, clocks=(100, 100))
        check(plan, run)
        fills[pause] = run.fill
    assert fills[0] >= 10
    assert fills[0] > fills[5] > fills[10] > fills[30] == 0


def test_fill_does_not_count_the_end():
    """The FIFO runs dry as the picture ends; that is not a low fill. And without a picture there is none."""
    plan = [Fetch(pair) for pair in pairs(2)]
    assert run_display(plan, clocks=(300, 65)).fill >= 12
    assert run_display([Fetch(pairs(1)[0], shown_valid=False)]).fill == 17


def test_any_input():
    """Twelve frames of words without sense: the monitor is content, and a picture after them is exact."""
    rng = random.Random(3)
    good = pairs(1)[0]
    noise = [Fetch(good, words=[{"disparity": rng.randrange(LABELS), "left": rng.randrange(256), "first": int(rng.random() < 0.1),
                                 "last": int(rng.random() < 0.1)} for _ in range(400)], stall=rng.choice([0.0, 0.5, 0.9]),
                   shown_valid=rng.random() < 0.8) for _ in range(12)]
    run = run_display([*noise, Fetch(good)], change=0.1)
    check_pictures([Fetch(good)], run.pictures[-1:], run.settings[12:13])
    steps = np.diff(run.underflows)
    assert set(steps) == {0, 1} and all(step == entry.shown_valid for step, entry in zip(steps, noise))


def test_counters_stay_or_wrap(monkeypatch):
    monkeypatch.setattr(hdl.video.dvi, "COUNT_BITS", 2)
    run = run_display([Fetch(pairs(1)[0], words=[])] * 5)
    assert run.underflows == [0, 1, 2, 3, 3, 3]
    assert run.frames == [0, 1, 2, 3, 0, 1]


def test_clear():
    plan = [Fetch(pairs(1)[0], words=[])] * 4
    run = run_display(plan, clear=lambda fetches, cycle, fetch: (fetches, cycle) == (2, 30))
    assert run.underflows == [0, 1, 1, 2, 3]
    assert run.frames == [0, 1, 0, 1, 2]
    # Events in the cycle of `clear` are counted.
    run = run_display(plan, clear=lambda fetches, cycle, fetch: fetch)
    assert run.frames == [0, 1, 1, 1, 1]
    run = run_display(plan, clear=lambda fetches, cycle, fetch: True)
    assert run.underflows == [0] * 5
    assert run.most == 1


def cut(entry, picture):
    """How many words of it were shown."""
    return [n for n in range(96) if (Fetch(entry.pair, in_time=n).picture(SMALL_DISPLAY, 0, 0, LABELS) == picture).all()][-1]


def test_reset_of_the_memory_side():
    """The monitor does not notice but for the rest of a picture; fetches go on, the next picture is exact. No event is invented."""
    first, *pair = pairs(5)
    plan = [Fetch(first, in_time=0, words=[]), *map(Fetch, pair)]
    run = run_display(plan, reset=(3, 200))
    whole = [0, 1, 3, 4]
    check_pictures([plan[n] for n in whole], [run.pictures[n] for n in whole], [run.settings[n] for n in whole])
    assert 20 < cut(plan[2], run.pictures[2]) < 60
    # The reset outlasts the word in the display's register: that underflow is not counted.
    assert run.underflows == [0, 1, 1, 0, 0, 0]
    assert run.frames == [0, 1, 2, 0, 1, 2]


@pytest.mark.parametrize("fetches", [2, 3])
def test_reset_of_the_display(fetches):
    """It fetches a picture at once, which is bit-exact; the picture that was being read is drained. After an odd number of fetches and
    underflows one more of each is counted."""
    first, *pair = pairs(6)
    plan = [Fetch(first, in_time=0, words=[]), *map(Fetch, pair)]
    run = run_display(plan, restart=(fetches, 200))
    odd = fetches % 2
    whole = [n for n in range(6) if n not in ((2, 3) if odd else (1,))]
    check_pictures([plan[n] for n in whole], run.pictures, [run.settings[n] for n in whole])
    assert run.underflows == ([0, 1, 1, 1, 2, 2, 2] if odd else [0, 1, 2, 2, 2, 2, 2])
    assert run.frames == list(range(7))


def test_pixel_rate():
    """720 pixels in a line of 1344 at 65 MHz, and 720 in one of 864 at 27 MHz; twice that in mode ``both``."""
    outputs = [DisplayOutput(CONFIG, display, 720, 576, reader_skips=skips) for display in DISPLAYS.values() for skips in (True, False)]
    rates = [output.pixel_rate for output in outputs]
    assert rates == pytest.approx([22.5e6, 45e6, 34.82e6, 69.64e6], rel=1e-3)


def test_refuses():
    with pytest.raises(ValueError, match="picture of 720x577 pixels cannot be shown on a display of 720x576"):
        DisplayOutput(CONFIG, DISPLAYS["720x576"], 720, 577)
    for depth in (8, 24, 0):
        with pytest.raises(ValueError, match=f"must be a power of two of at least 16, not {depth}"):
            DisplayOutput(CONFIG, DISPLAYS["720x576"], 720, 576, depth=depth)
    with pytest.raises(ValueError, match="blanking of 96 pixels is too short to drain the display's FIFO of 64 words; give it 32 or less"):
        DisplayOutput(CONFIG, SMALL_DISPLAY, 12, 8, depth=64)
    DisplayOutput(CONFIG, SMALL_DISPLAY, 12, 8, depth=32)
