"""The set-up of the chips that there are; for its sequencer see ``test_hdl_video_setup.py``."""

from dataclasses import replace

import pytest

from golden.video.setup_steps import TFP410, TFP410_STRAPS, TVP5154, Drive, Failure, Write
from sim.models.i2c_chips import Fault
from sim.models.video_chips import Tfp410, Tvp5154
from tests.hdl.video.chip_setups import TICK, run_setup


def quick(chip):
    """The same table with a short time to power up."""
    return replace(chip, setup=tuple(
        replace(step, seconds=min(step.seconds, 0.0003 if isinstance(step, Drive) else 0.005)) for step in chip.setup))


def decoder_model(**kwargs):
    """For ``quick(TVP5154)``."""
    model = Tvp5154(seed=1, start_ns=100_000, **kwargs)
    model.POWER_UP = 300_000
    return model


def test_decoder():
    """Order and values of all writes, both decoders set up and the others not, pins in their order, locks reported."""
    model = decoder_model(stretch=0.02)

    async def script(watched):
        assert (watched.get("resetb"), watched.get("pdn")) == (1, 1)
        await watched.until("done")
        assert [model.is_set_up(number) for number in range(4)] == [True, True, False, False]
        writes = [(step.register, step.value) for step in TVP5154.setup if isinstance(step, Write)]
        assert model.writes == writes
        assert watched.status == (0, Failure.NONE, 0)
        for values in ((0x06, 0x00), (0xFF, 0x06), (0x02, 0x0E), (0x04, 0xF9)):
            for decoder, value in zip(model.decoders, values):
                decoder.lock = value
            await watched.idle(3000)
            assert watched.get("locked") == sum((value & 6 == 6) << place for place, value in enumerate(values))
        assert watched.get("done")

    run_setup(quick(TVP5154), model, script)
    assert model.writes[-1] in ((0xFF, 1), (0xFF, 2))


def test_decoder_that_is_reset_is_set_up_again():
    model = decoder_model()

    async def script(watched):
        await watched.until("done")
        for decoder in model.decoders:
            decoder.lock = 0x06
        await watched.until("locked", 3)
        await watched.idle(1000)
        model.reset()
        await watched.until("done", 0)
        step, reason, failures = watched.status
        assert TVP5154.steps[step].text in ("decoder 1: read 03 & 0D = 0D", "decoder 2: read 03 & 0D = 0D")
        assert (reason, failures) == (Failure.NOT_READY, 1)
        await watched.until("done")
        assert model.is_set_up(0) and model.is_set_up(1)
        for decoder in model.decoders:
            decoder.lock = 0x06
        await watched.until("locked", 3)

    run_setup(quick(TVP5154), model, script)


@pytest.mark.parametrize("fault, step, reason", [
    (Fault("no acknowledge", None), "decoder 1: write FE = 01", Failure.NO_ACKNOWLEDGE),
    (Fault("no acknowledge", 0x7F, after=2), "decoder 3: write 7F = 00", Failure.NO_ACKNOWLEDGE),
    (Fault("clock", 0x17, after=1), "decoder 2: write 17 = 5B", Failure.CLOCK_HELD),
    (Fault("data", 0x03), "decoder 1: write 03 = 0D", Failure.DATA_HELD),
    ("processor", "decoder 1: read 81 = 54", Failure.NOT_READY),
])
def test_decoder_fails(fault, step, reason):
    """The step in words, and the reason."""
    model = decoder_model()
    if fault == "processor":
        model.start_ns = 10**12
    else:
        model.faults = [fault]

    async def script(watched):
        await watched.until("failed")
        at, why, failures = watched.status
        assert (TVP5154.steps[at].text, why, failures) == (step, reason, 1)

    run_setup(quick(TVP5154), model, script, tries=1, broken=isinstance(fault, Fault) and fault.kind != "no acknowledge")


def test_transmitter():
    model = Tfp410(stretch=0.05)

    async def script(watched):
        assert watched.get("isel") == 0
        await watched.until("done")
        assert watched.get("isel") == 1
        assert model.is_set_up()
        assert model.writes == [(0x08, 0xBF), (0x09, 0x20)]
        await watched.idle(1000)
        assert watched.get("done")
        model.reset()
        await watched.until("done", 0)
        assert (TFP410.steps[watched.get("step")].text, watched.status[1:]) == ("outputs: read 08 & 7F = 3F", (Failure.NOT_READY, 1))
        await watched.until("done")
        assert model.is_set_up()

    run_setup(TFP410, model, script)


def test_transmitter_by_straps():
    """Done without a word on the bus."""
    model = Tfp410()

    async def script(watched):
        assert await watched.until("done") >= 10 * TICK
        await watched.idle(3000)
        assert (watched.get("done"), watched.get("isel")) == (1, 0)
        assert (watched.bus.starts, watched.bus.sda, watched.bus.scl) == (0, 1, 1)
        await watched.restart()
        await watched.until("busy")
        await watched.until("done")

    run_setup(TFP410_STRAPS, model, script)
