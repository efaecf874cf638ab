"""A set-up with a chip on its bus, in Amaranth's simulator."""

from amaranth.hdl import Signal
from amaranth.sim import Simulator

from golden.video.setup_steps import Failure
from hdl.video.setup import ChipSetup
from sim.models.i2c import I2cBus, amaranth_bus


#: Low, so that tests are quick; the bus and its chips do not know.
CLOCK_HZ = 400_000

#: Cycles of a tick.
TICK = 40


class Watched:
    """What a script may do and see."""
    def __init__(self, ctx, dut, model, bus):
        self.ctx, self.dut, self.model, self.bus = ctx, dut, model, bus

    def get(self, name):
        return self.ctx.get(getattr(self.dut, name))

    async def idle(self, cycles=1):
        await self.ctx.tick().repeat(cycles)

    async def until(self, name, value=1, *, cycles=20_000):
        """Wait; return the cycles that it took."""
        for cycle in range(cycles):
            if self.get(name) == value:
                return cycle
            await self.ctx.tick()
        raise TimeoutError(f"{name} is not {value} after {cycles} cycles")

    async def restart(self):
        self.ctx.set(self.dut.restart, 1)
        await self.idle()
        self.ctx.set(self.dut.restart, 0)

    @property
    def status(self):
        return self.get("step"), Failure(self.get("reason")), self.get("failures")


def run_setup(chip, model, script, *, broken=False, **kwargs):
    kwargs = {"tries": 2, "pause_seconds": 0.0005, "watch_seconds": 0.0005, "stretch_seconds": 0.0004, **kwargs}
    dut = ChipSetup(chip, CLOCK_HZ, **kwargs)
    bus = I2cBus(model)
    bus.broken_allowed = broken
    ran = []

    async def testbench(ctx):
        await script(Watched(ctx, dut, model, bus))
        ran.append(True)

    async def check(ctx):
        """In every change of the status."""
        locked = dut.locked if chip.channels else Signal()
        async for busy, done, failed, lock in ctx.changed(dut.busy, dut.done, dut.failed, locked):
            assert busy + done + failed == 1, (busy, done, failed)
            assert done or not lock

    sim = Simulator(dut)
    sim.add_clock(1 / CLOCK_HZ)
    sim.add_testbench(testbench)
    sim.add_testbench(check, background=True)
    sim.add_testbench(amaranth_bus(bus, dut, clock_hz=CLOCK_HZ, pins=chip.pins), background=True)
    sim.run()
    assert ran
