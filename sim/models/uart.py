"""The host's end of a serial line: a model that is stepped once a clock, and the chip's registers at its other end in a simulator."""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from amaranth.hdl import Value
from amaranth.sim import Simulator
from numpy.typing import NDArray

from golden.host.blocks import stored_line
from golden.host.registers import RegisterMap
from hdl.host.registers import SerialRegisters


__all__ = ["SimulatedChip", "UartHost"]


class UartHost:
    """Sends and receives bytes at a separate baud rate, eight data bits, no parity, one stop bit, with optional noise on the line.

    It is stepped once a clock of the design: :meth:`step` takes the level of the design's ``tx`` and returns the one for its ``rx``. In
    Amaranth's simulator that is ``ctx.set(dut.rx, host.step(ctx.get(dut.tx)))``, in cocotb ``dut.rx.value = host.step(int(dut.tx.value))``.
    Everything to be sent is queued, and sent in order.

    Parameters
    ----------
    bit_cycles : int or float
        Cycles of a bit at the design's baud rate.
    mismatch : float
        By which fraction this end is faster: at 0.03 its bits are 3 % shorter.
    rng
        Anything with a method ``random()``, for the position of pulses and for noise.

    Attributes
    ----------
    received : bytearray
        Bytes with a stop bit.
    framing_errors : int
        Number of bytes without.
    cycle : int
        Number of steps.
    """
    def __init__(self, bit_cycles: float, *, mismatch: float = 0.0, rng: Any = None):
        self.bit_cycles = bit_cycles / (1 + mismatch)
        self.rng = rng
        self.received = bytearray()
        self.framing_errors = 0
        self.cycle = 0
        self._levels: deque[tuple[int, float]] = deque()    # levels to send, each with its cycles
        self._level, self._end = 1, 0.0     # level on the line, and its last cycle
        self._previous = 1                  # level of the design's line in the cycle before
        self._since: int | None = None      # cycles since the start edge of a byte
        self._bits: list[int] = []

    @property
    def idle(self) -> bool:
        """Whether everything queued has been sent."""
        return not self._levels and self.cycle >= self._end

    def _put(self, level: int, bits: float) -> None:
        self._levels.append((level, bits * self.bit_cycles))

    def send(self, data: Iterable[int], *, pulses: float = 0.0, pulse_bits: float = 1 / 16, stop: int = 1, gap: float = 0.0) -> None:
        """Queue bytes.

        Parameters
        ----------
        pulses : float
            Probability that a bit contains a pulse of the opposite level, at a random position.
        pulse_bits : float
            Length of a pulse, in bits.
        stop : int
            Level of the stop bit; at 0 the line is high for a bit after it.
        gap : float
            Bits between two bytes.
        """
        for byte in data:
            for level in (0, *((byte >> place) & 1 for place in range(8)), stop):
                if pulses and self.rng.random() < pulses:
                    before = self.rng.random() * (1 - pulse_bits)
                    self._put(level, before)
                    self._put(1 - level, pulse_bits)
                    self._put(level, 1 - before - pulse_bits)
                else:
                    self._put(level, 1)
            if not stop:
                self._put(1, 1)
            if gap:
                self._put(1, gap)

    def send_level(self, level: int, bits: float) -> None:
        """Queue a level for a number of bits: a break, a pause, a pulse."""
        self._put(level, bits)

    def send_noise(self, bits: float) -> None:
        """Queue a level that changes at random times for a number of bits; it ends high."""
        left = bits
        level = 0
        while left > 0:
            length = min(left, self.rng.random() ** 3 * 4)
            self._put(level, length)
            left -= length
            level = 1 - level
        self._put(1, 1)

    def step(self, tx: int) -> int:
        """One clock: takes the design's level, returns this end's."""
        self.cycle += 1
        self._listen(tx)
        while self.cycle > self._end and self._levels:
            # Edges are at fractions of a cycle, except for the first one after a pause.
            self._level, length = self._levels.popleft()
            self._end = max(self._end, self.cycle - 1) + length
        return self._level if self.cycle <= self._end else 1

    def _listen(self, tx: int) -> None:
        if self._since is None:
            if self._previous and not tx:
                self._since, self._bits = 0, []
        else:
            self._since += 1
        self._previous = tx
        if self._since is not None and self._since >= (len(self._bits) + 0.5) * self.bit_cycles - 0.5:
            self._bits.append(tx)
            if len(self._bits) == 10:
                start, *bits, stop = self._bits
                if stop and not start:
                    self.received.append(sum(bit << place for place, bit in enumerate(bits)))
                else:
                    self.framing_errors += 1
                self._since = None


class SimulatedChip:
    """The registers and their serial line in Amaranth's simulator, as the transport of :class:`hdl.host.chip.Chip`.

    Time is simulated: a second is ``clock_hz`` cycles.

    Parameters
    ----------
    registers : RegisterMap
    baud : int
    bit_cycles : int
        Cycles of a bit.
    frame_seconds : float
        Longest pause within a request.
    mismatch : float
    rng
        As of :class:`UartHost`.
    system : callable
        With the parameters of :class:`hdl.host.registers.SerialRegisters`, which is the default; a component with its members.

    Attributes
    ----------
    status : dict
        Status inputs of the chip, by name; may be changed between calls.
    actions : list of str
        Actions that were carried out.
    planes : sequence of three arrays, shape (H, W), or None
        Pictures that are kept from a cycle after ``keep`` is set until a cycle after it is not; none if ``None``.
    line : UartHost
    """
    def __init__(self, registers: RegisterMap, *, baud: int = 115_200, bit_cycles: int = 16, frame_seconds: float = 1e-3,
                 mismatch: float = 0.0, rng: Any = None, system: Callable[..., Any] = SerialRegisters):
        self.clock_hz = baud * bit_cycles
        self.dut = system(registers, self.clock_hz, baud, frame_seconds=frame_seconds)
        self.line = UartHost(bit_cycles, mismatch=mismatch, rng=rng)
        self.status: dict[str, int] = {}
        self.planes: Sequence[NDArray[Any]] | None = None
        self._settings = 0
        self.actions: list[str] = []
        self._simulator = Simulator(self.dut)
        self._simulator.add_clock(1 / self.clock_hz)
        self._simulator.add_testbench(self._run)

    @property
    def settings(self) -> dict[str, int]:
        """Values of the settings, by name."""
        return {name: int(self.dut.settings.shape().from_bits(self._settings)[name]) for name in self.dut.settings.shape().members}

    async def _run(self, ctx: Any) -> None:
        given: dict[str, int] = {}
        line, byte = self.dut.line, self.dut.byte
        offered: deque[dict[str, int]] = deque()    # bytes of a line, as of a memory that has it at once
        # Read as bits in each cycle: structs are made of them where they are needed.
        sampled = line.valid, Value.cast(line.p), byte.ready
        settings, actions = Value.cast(self.dut.settings), Value.cast(self.dut.actions)
        rx = None
        ctx.set(line.ready, 1)
        while True:
            kept = {"kept": int(self.planes is not None and ctx.get(self.dut.settings.keep))}
            if given != self.status | kept:
                given = self.status | kept
                ctx.set(self.dut.status, given)
            before, rx = rx, self.line.step(ctx.get(self.dut.tx))
            if rx != before:
                ctx.set(self.dut.rx, rx)
            *_, wanted, bits, taken = await ctx.tick().sample(*sampled)
            if wanted and self.planes is not None:
                request = line.p.shape().from_bits(bits)
                data = stored_line(self.planes[request.plane][request.line])
                offered.extend({"value": value, "last": int(number == len(data))} for number, value in enumerate(data, 1))
            elif taken and offered:
                offered.popleft()
            if wanted or taken:
                ctx.set(byte.valid, bool(offered))
                ctx.set(byte.p, offered[0] if offered else {})
            self._settings = ctx.get(settings)
            if ctx.get(actions):
                self.actions += [name for name in self.dut.actions.shape().members if ctx.get(self.dut.actions[name])]

    def advance(self, cycles: int) -> None:
        """Simulate so many cycles."""
        until = self.line.cycle + cycles
        while self.line.cycle < until:
            self._simulator.advance()

    def write(self, data: bytes) -> None:
        """Queue bytes for the chip."""
        self.line.send(data)

    def read(self, count: int, seconds: float) -> bytes:
        """Up to ``count`` bytes of the chip; fewer if the others are not received in time."""
        until = self.line.cycle + seconds * self.clock_hz
        while len(self.line.received) < count and (self.line.cycle < until or not self.line.idle):
            self._simulator.advance()
        data = bytes(self.line.received[:count])
        del self.line.received[:count]
        return data
