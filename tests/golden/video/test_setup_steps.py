from dataclasses import replace

import pytest

from golden.video.setup_steps import TFP410, TFP410_STRAPS, TVP5154, Chip, Drive, Failure, Lock, Poll, Write


CHIPS = [TVP5154, TFP410, TFP410_STRAPS]


def test_addresses():
    """As the notes of the cards have them, with the bit for reading or writing."""
    assert (TVP5154.address << 1, TFP410.address << 1) == (0xB8, 0x70)


def test_decoder_table():
    """Restart of all four decoders, then the settings of the two that are used, written out by hand."""
    restarts = [(ch, [(0xFE, ch), (0x7F, 0x00), (0xFF, ch), (0x81, 0x54)]) for ch in (1, 2, 4, 8)]
    settings = [(0x03, 0x0D), (0x17, 0x5B), (0x15, 0x81), (0x00, 0x00)]
    expected = [pair for _, restart in restarts for pair in restart]
    for _, restart in restarts[:2]:
        expected += restart + settings
    steps = [step for step in TVP5154.setup if not isinstance(step, Drive)]
    assert [(step.register, step.value) for step in steps] == expected
    assert {step.register for step in steps if isinstance(step, Poll)} == {0x81}
    assert [(step.register, step.value, step.mask, step.channel) for step in TVP5154.watch if isinstance(step, Lock)] == [
        (0x88, 0x06, 0x06, 0), (0x88, 0x06, 0x06, 1)]
    assert [step.value for step in TVP5154.watch if isinstance(step, Write)] == [1, 2]


@pytest.mark.parametrize("chip", CHIPS, ids=lambda chip: chip.name)
def test_every_failure_has_words_of_its_own(chip):
    texts = {chip.explain(step, failure) for step in range(len(chip.steps)) for failure in Failure}
    assert len(texts) == len(chip.steps) * len(Failure)
    assert all(line.startswith(f"{chip.name}, step ") for line in texts)


def test_words():
    assert TVP5154.explain(1, Failure.NONE) == "TVP5154, step 1 (reset, 1 ms): no failure"
    assert TVP5154.explain(6, 4) == "TVP5154, step 6 (decoder 1: read 81 = 54): the register did not read this in time"
    last = len(TVP5154.steps) - 1
    assert TVP5154.explain(last, 2) == f"TVP5154, step {last} (decoder 2: read lock in 88): the chip held SCL low for too long"
    assert TFP410.explain(4, 3) == "TFP410, step 4 (outputs: read 08 & 7F = 3F): something holds SDA low"
    with pytest.raises(ValueError, match=r"TFP410 has the steps 0 to 5, not 6$"):
        TFP410.explain(6, Failure.NONE)


@pytest.mark.parametrize("make, message", [
    (lambda: Write("x", -1, 0, 0), r"^x: the time of a step must be 0 seconds or more, not -1$"),
    (lambda: Write("x", float("inf"), 0, 0), r"not inf$"),
    (lambda: Write("x", 0, 256, 0), r"^x: register must be a byte, 0 to 255, not 256$"),
    (lambda: Write("x", 0, 0, -1), r"^x: value must be a byte, 0 to 255, not -1$"),
    (lambda: Poll("x", 0, 0, 0, 300), r"^x: mask must be a byte, 0 to 255, not 300$"),
    (lambda: Poll("x", 0, 0, 0x54, 0x0F), r"^x: no byte under the mask 0F is 54$"),
    (lambda: replace(TFP410, address=128), r"^TFP410: the address must have seven bits, 0 to 127, not 128$"),
    (lambda: replace(TFP410, setup=()), r"^TFP410: the first step of the set-up must drive the pins$"),
    (lambda: replace(TFP410, setup=TFP410.setup[2:]), r"^TFP410: the first step of the set-up must drive the pins$"),
    (lambda: replace(TFP410, pins=("a", "b")), r"^TFP410: reset, 1 ms: 1 levels for the pins a, b$"),
    (lambda: replace(TVP5154, channels=1), r"^TVP5154: decoder 2: read lock in 88: channel 1 of 1$"),
])
def test_bad_tables(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_chip_without_pins():
    assert Chip("bare", 0, (), (Write("x", 0, 1, 2),)).steps == (Write("x", 0, 1, 2),)
