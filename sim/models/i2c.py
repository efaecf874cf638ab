"""Model of an I2C bus: two lines, the chips on them, and the rules of the standard mode, checked on the lines.

The model works on times and levels; :func:`amaranth_bus` and :func:`cocotb_bus` connect it to a design. Times are nanoseconds.
"""

import math
from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any


__all__ = ["DATA_HOLD", "DATA_SETUP", "DATA_VALID", "I2cBus", "Violation", "amaranth_bus", "cocotb_bus"]


class Violation(AssertionError):
    """The design violated a rule of the bus, or of a chip."""


# Standard mode, UM10204 table 10; the hold time is the one that bridges the falling edge of SCL.
LOW, HIGH, PERIOD = 4_700, 4_000, 10_000
START_SETUP, START_HOLD, STOP_SETUP, FREE = 4_700, 4_000, 4_000, 4_700
DATA_SETUP, DATA_HOLD = 250, 300

# Longest time from SCL's falling edge to valid data of a chip.
DATA_VALID = 3_450


class I2cBus:
    """Two lines with pull-ups, the chips on them, and the rules.

    Parameters
    ----------
    *chips : :class:`sim.models.i2c_chips.I2cChip`
    rise_ns : int
        Rise time of a line.

    Attributes
    ----------
    scl, sda : int
        Levels of the lines.
    broken_allowed : bool
        Allow a start or a stop inside a byte, and a start without a stop before, as a master does that gives up after a chip's fault.
    busy : bool
        There was a start and no stop since.
    starts, stops : int
        Number of conditions.
    """
    def __init__(self, *chips: Any, rise_ns: float = 0):
        self.chips = chips
        self.rise_ns = rise_ns
        self.broken_allowed = False
        self.scl = int(not any(chip.scl_low for chip in chips))
        self.sda = int(not any(chip.sda_low for chip in chips))
        self.starts = self.stops = 0
        self._master: tuple[int, int] = (0, 0)
        self._now = 0.0
        self._rises = {"scl": math.inf, "sda": math.inf}
        self.busy = False
        self._clocks = 0
        self._restarted = False
        self._scl_rose = self._scl_fell = self._sda_changed = self._started = self._stopped = -math.inf

    @property
    def due(self) -> float:
        """Time of the next change of a line that the master does not cause; infinity if there is none."""
        return min([*self._rises.values(), *(chip.due for chip in self.chips)])

    def restart(self) -> None:
        """The master is reset in the midst of whatever it does: the rules apply again from its next start on."""
        self._restarted = True

    def drive(self, now: float, scl_low: int, sda_low: int, **pins: int) -> None:
        """Set the master's outputs, and the levels of the chips' pins, from ``now`` on."""
        while self.due <= now:
            self._settle(max(self.due, self._now))
        self._now = now
        self._master = (scl_low, sda_low)
        for chip in self.chips:
            chip.set_pins(now, pins)
        self._settle(now)

    def _settle(self, now: float) -> None:
        while True:
            for chip in self.chips:
                chip.wake(now)
            scl = self._level("scl", now, self._master[0] or any(chip.scl_low for chip in self.chips))
            sda = self._level("sda", now, self._master[1] or any(chip.sda_low for chip in self.chips))
            # If both lines change at once, the order is the worst case: SDA changes within SCL's high time.
            if scl > self.scl:
                self.scl = scl
                self._on_rise(now)
            elif sda != self.sda:
                self.sda = sda
                self._on_sda(now)
            elif scl < self.scl:
                self.scl = scl
                self._on_fall(now)
            else:
                return

    def _level(self, name: str, now: float, low: bool | int) -> int:
        """Level of a line: low immediately, high after the rise time."""
        if low:
            self._rises[name] = math.inf
            return 0
        if getattr(self, name):
            return 1
        if self._rises[name] == math.inf:
            self._rises[name] = now + self.rise_ns
        if self._rises[name] <= now:
            self._rises[name] = math.inf
            return 1
        return 0

    def _check(self, name: str, now: float, since: float, least: int) -> None:
        # Half a nanosecond of tolerance for clocks whose period is not in whole nanoseconds.
        if not self._restarted and now - since < least - 0.5:
            raise Violation(f"{name} is {now - since:.0f} ns at {now:.0f} ns; the least is {least} ns")

    def _on_rise(self, now: float) -> None:
        self._check("SCL low", now, self._scl_fell, LOW)
        self._check("set-up of data", now, self._sda_changed, DATA_SETUP)
        self._check("period of SCL", now, self._scl_rose, PERIOD)
        self._scl_rose = now
        self._clocks += 1
        for chip in self.chips:
            chip.on_rise(now, self.sda)

    def _on_fall(self, now: float) -> None:
        self._check("SCL high", now, self._scl_rose, HIGH)
        self._check("hold of start", now, self._started, START_HOLD)
        self._scl_fell = now
        for chip in self.chips:
            chip.on_fall(now)

    def _on_sda(self, now: float) -> None:
        self._sda_changed = now
        if not self.scl:
            self._check("hold of data", now, self._scl_fell, DATA_HOLD)
            return
        # A condition is between bytes: SCL has risen once since the last acknowledge.
        whole = self._clocks % 9 == 1
        if not (self.broken_allowed or self._restarted) and (self.busy or self.sda) and not whole:
            raise Violation(f"SDA changes while SCL is high, at {now:.0f} ns, inside a byte")
        if self.sda:
            self._check("set-up of stop", now, self._scl_rose, STOP_SETUP)
            self.busy, self._stopped = False, now
            self.stops += 1
            for chip in self.chips:
                chip.on_stop(now)
        else:
            self._restarted = False
            self._check("set-up of start", now, self._scl_rose, START_SETUP)
            self._check("bus free", now, self._stopped, FREE)
            repeated, self.busy, self._started, self._clocks = self.busy, True, now, 0
            self.starts += 1
            for chip in self.chips:
                chip.on_start(now, repeated, strict=not self.broken_allowed)


def amaranth_bus(bus: I2cBus, dut: Any, *, clock_hz: float, pins: Sequence[str] = ()) -> Callable[[Any], Coroutine[Any, Any, None]]:
    """Background testbench for Amaranth's simulator: ``bus`` at the lines of ``dut``, sampled every cycle.

    ``dut`` has the members ``scl_low``, ``sda_low``, ``scl_i``, ``sda_i``, and those of the names in ``pins``.
    """
    async def testbench(ctx: Any) -> None:
        signals = [dut.scl_low, dut.sda_low, *(getattr(dut, pin) for pin in pins)]
        before = None
        cycle = 0
        while True:
            now = cycle * 1e9 / clock_hz
            values = [ctx.get(signal) for signal in signals]
            if values != before or bus.due <= now:
                bus.drive(now, *values[:2], **dict(zip(pins, values[2:])))
                ctx.set(dut.scl_i, bus.scl)
                ctx.set(dut.sda_i, bus.sda)
                before = values
            await ctx.tick()
            cycle += 1
    return testbench


async def cocotb_bus(bus: I2cBus, dut: Any, *, prefix: str = "", pins: Sequence[str] = (), ports: Mapping[str, str] | None = None,
                     levels: Mapping[str, int] | None = None, scale: float = 1) -> None:
    """Run in the background (``cocotb.start_soon``), once the reset has begun: ``bus`` at the lines of a module in a simulator.

    The ports have the names of :func:`amaranth_bus` with ``prefix``, except for those that ``ports`` names. ``levels`` are those of pins
    that are not ports. A nanosecond of the simulator is ``scale`` nanoseconds of the bus. It sleeps while the lines do not change.
    """
    from cocotb.simtime import get_sim_time
    from cocotb.triggers import First, ReadOnly, Timer, ValueChange
    ports = ports or {}

    def port(name: str) -> Any:
        return getattr(dut, ports.get(name, prefix + name))

    handles = {name: port(name) for name in ("scl_low", "sda_low", *pins)}
    while True:
        await ReadOnly()
        now = dict(levels or {})
        for name, handle in handles.items():
            assert handle.value.is_resolvable, f"{prefix}{name} is {handle.value}"
            now[name] = int(handle.value)
        await Timer(1, "ps")
        bus.drive(scale * get_sim_time("ns"), now.pop("scl_low"), now.pop("sda_low"), **now)
        port("scl_i").value, port("sda_i").value = bus.scl, bus.sda
        triggers = [ValueChange(handle) for handle in handles.values()]
        if bus.due < math.inf:
            triggers.append(Timer(max(round((bus.due / scale - get_sim_time("ns")) * 1000), 1), "ps"))
        await First(*triggers)
