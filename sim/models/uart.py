"""The host's end of a serial line: a model that is stepped once a clock, and the chip's registers behind it in Amaranth's simulator."""

from collections import deque

from amaranth.sim import Simulator

from hdl.host.registers import SerialRegisters


__all__ = ["SimulatedChip", "UartHost"]


class UartHost:
    """Sends and receives bytes at a rate of its own, eight data bits, no parity, one stop bit; disturbs the line if asked to.

    It is stepped once a clock of the design: :meth:`step` takes the level of the design's ``tx`` and returns the one for its ``rx``. In
    Amaranth's simulator that is ``ctx.set(dut.rx, host.step(ctx.get(dut.tx)))``, in cocotb ``dut.rx.value = host.step(int(dut.tx.value))``.
    All that is to be sent is queued first, and goes out in order.

    Parameters
    ----------
    bit_cycles : int or float
        Cycles of a bit at the design's rate.
    mismatch : float
        How much faster this end is, a fraction: at 0.03 its bits are 3 % shorter.
    rng
        Anything with a method ``random()``; places pulses of noise.

    Attributes
    ----------
    received : bytearray
        Bytes that came with their stop bit.
    framing_errors : int
        Bytes that came without.
    cycle : int
        Number of steps.
    """
    def __init__(self, bit_cycles, *, mismatch=0.0, rng=None):
        self.bit_cycles = bit_cycles / (1 + mismatch)
        self.rng = rng
        self.received = bytearray()
        self.framing_errors = 0
        self.cycle = 0
        self._levels: deque = deque()       # (level, cycles): what is still to be sent
        self._level, self._end = 1, 0.0     # what is on the line, and the cycle up to which
        self._previous = 1                  # of the design's line
        self._since = None                  # cycles since the edge that opened a byte
        self._bits: list[int] = []

    @property
    def idle(self):
        """Whether all has been sent."""
        return not self._levels and self.cycle >= self._end

    def _put(self, level, bits):
        self._levels.append((level, bits * self.bit_cycles))

    def send(self, data, *, pulses=0.0, pulse_bits=1 / 16, stop=1, gap=0.0):
        """Queue bytes.

        Parameters
        ----------
        pulses : float
            Probability of a bit to hold a pulse of the opposite level, at a random place.
        pulse_bits : float
            Its length.
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

    def send_level(self, level, bits):
        """Queue a level for a number of bits: a break, a silence, a pulse."""
        self._put(level, bits)

    def send_noise(self, bits):
        """Queue a level that changes at random, at any time, for a number of bits; it ends high."""
        left = bits
        level = 0
        while left > 0:
            length = min(left, self.rng.random() ** 3 * 4)
            self._put(level, length)
            left -= length
            level = 1 - level
        self._put(1, 1)

    def step(self, tx):
        """One clock: the design's level in, this end's out."""
        self.cycle += 1
        self._listen(tx)
        while self.cycle > self._end and self._levels:
            # Edges fall between cycles; after a silence the first one does not.
            self._level, length = self._levels.popleft()
            self._end = max(self._end, self.cycle - 1) + length
        return self._level if self.cycle <= self._end else 1

    def _listen(self, tx):
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
    """The registers behind their serial line in Amaranth's simulator, as the transport of :class:`hdl.host.console.Chip`.

    Time is the chip's: a wait of a second is one of ``clock_hz`` cycles.

    Parameters
    ----------
    registers : RegisterMap
    baud : int
    bit_cycles : int
        Cycles of a bit.
    frame_seconds : float
        Time-out within a request.
    mismatch : float
    rng
        As of :class:`UartHost`.

    Attributes
    ----------
    status : dict
        Status inputs of the chip, by name; may be written between calls.
    actions : list of str
        Actions that fired.
    line : UartHost
    """
    def __init__(self, registers, *, baud=115_200, bit_cycles=16, frame_seconds=1e-3, mismatch=0.0, rng=None):
        self.clock_hz = baud * bit_cycles
        self.dut = SerialRegisters(registers, self.clock_hz, baud, frame_seconds=frame_seconds)
        self.line = UartHost(bit_cycles, mismatch=mismatch, rng=rng)
        self.status: dict[str, int] = {}
        self._params = 0
        self.actions: list[str] = []
        self._simulator = Simulator(self.dut)
        self._simulator.add_clock(1 / self.clock_hz)
        self._simulator.add_testbench(self._run)

    @property
    def params(self):
        """What the parameters are, by name."""
        return {name: int(self.dut.params.shape().from_bits(self._params)[name]) for name in self.dut.params.shape().members}

    async def _run(self, ctx):
        given: dict[str, int] = {}
        while True:
            if given != self.status:
                given = dict(self.status)
                ctx.set(self.dut.status, given)
            ctx.set(self.dut.rx, self.line.step(ctx.get(self.dut.tx)))
            await ctx.tick()
            self._params = ctx.get(self.dut.params.as_value())
            if ctx.get(self.dut.actions.as_value()):
                self.actions += [name for name in self.dut.actions.shape().members if ctx.get(self.dut.actions[name])]

    def advance(self, cycles):
        """Let the chip run."""
        until = self.line.cycle + cycles
        while self.line.cycle < until:
            self._simulator.advance()

    def write(self, data):
        """Queue bytes for the chip."""
        self.line.send(data)

    def read(self, count, seconds):
        """Up to ``count`` bytes of the chip; fewer if they do not come in time."""
        until = self.line.cycle + seconds * self.clock_hz
        while len(self.line.received) < count and (self.line.cycle < until or not self.line.idle):
            self._simulator.advance()
        data = bytes(self.line.received[:count])
        del self.line.received[:count]
        return data
