"""Controller of a single-data-rate SDRAM: words read and written in the order of their accesses."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, Signature

from golden.video.sdram import BANK_BITS, CAS_CLOCKS, COLUMN_BITS, ROW_BITS, WORD_BITS, Command, SdramClocks


__all__ = ["HALF_BITS", "Access", "SdramController", "SdramPins"]


#: Bits of an address within a half of the memory. From the lowest one on: column, lower bit of the bank, row; then the upper bit of the
#: bank. So the halves of the memory are in other banks, and a row of each is open at the same time.
HALF_BITS = COLUMN_BITS + 1 + ROW_BITS

# A burst length of 1: each word has a command of its own, one a clock in an open row. Bits 4 to 6 are the latency.
_MODE = CAS_CLOCKS << 4

_BYTES = WORD_BITS // 8
_REFRESHES = 8          # after power-up
_ALL_BANKS = 1 << 10    # a precharge's address


class Access(data.StructLayout):
    """A word to read or write.

    ``address`` is in words; accesses of the two halves of the memory do not close each other's rows. ``bytes``: those that are written.
    ``tag`` is returned with the word that was read.
    """
    def __init__(self, tag_bits: int):
        super().__init__({"address": HALF_BITS + BANK_BITS - 1, "write": 1, "data": WORD_BITS, "bytes": _BYTES, "tag": tag_bits})


class SdramPins(Signature):
    """Pins of the memory, seen from the controller; each output reaches the memory through one more register.

    The memory's clock is inverted: its edge is half a clock after a change at the pins. The chip is always selected.

    Members
    -------
    enable : Out(1)
        CKE.
    command : Out(Command), bank : Out(2), address : Out(13)
    mask : Out(2)
        DQM: bytes that are not written.
    word : Out(16), drive : Out(1)
        Data to the memory, and whether they are driven.
    found : In(16)
        Data from it, registered with its clock: of a read that is given in a cycle, three cycles later.
    """
    #: From a read at this port to its word.
    LATENCY = CAS_CLOCKS + 1

    def __init__(self) -> None:
        super().__init__({
            "enable": Out(1), "command": Out(Command, init=Command.NOP), "bank": Out(BANK_BITS), "address": Out(ROW_BITS),
            "mask": Out(_BYTES, init=(1 << _BYTES) - 1),
            "word": Out(WORD_BITS), "drive": Out(1), "found": In(WORD_BITS),
        })


class SdramController(wiring.Component):
    """Reads and writes words of an SDRAM, in order. A row stays open until another one of its bank is accessed, or for a refresh.

    Golden: an array of words; those that were never written are undefined.

    Timing: nothing is accepted before the memory is initialised, ``clocks.power_up`` and some 60 cycles after reset. Then a word a cycle
    within an open row; a write waits ``clocks.read_to_write`` cycles after a read. A row is changed in :attr:`row_clocks` cycles at most,
    and a refresh takes :attr:`refresh_clocks` at most, of each ``clocks.refresh_interval``: it is due that early that even the longest
    sequence before it ends in time. ``found`` is valid :attr:`LATENCY` cycles after the access was accepted.

    Parameters
    ----------
    clocks : SdramClocks
    tag_bits : int

    Members
    -------
    i : In(stream.Signature(Access(tag_bits)))
        ``i.ready`` depends combinationally on ``i.p``.
    valid : Out(1), found : Out(16), tag : Out(tag_bits)
        Words read, in order, without back-pressure.
    memory : Out(SdramPins())
    """
    LATENCY = SdramPins.LATENCY + 2

    def __init__(self, clocks: SdramClocks, tag_bits: int):
        self.clocks = clocks
        super().__init__({
            "i": In(stream.Signature(Access(tag_bits))),
            "valid": Out(1), "found": Out(WORD_BITS), "tag": Out(tag_bits),
            "memory": Out(SdramPins()),
        })

    @property
    def row_clocks(self) -> int:
        """Most cycles by which a row that is not open delays an access."""
        clocks = self.clocks
        return max(clocks.active, clocks.write_recovery) + clocks.precharge + clocks.active_to_access

    @property
    def refresh_clocks(self) -> int:
        """Most cycles by which a refresh delays an access, without the row's activation after it."""
        clocks = self.clocks
        return max(clocks.active, clocks.write_recovery) + clocks.precharge + clocks.refresh_cycle

    def elaborate(self, platform: object) -> Module:
        m = Module()
        clocks, memory, access = self.clocks, self.memory, self.i.p

        def countdown(name: str, most: int) -> Signal:
            """A counter that ends at 0."""
            left = Signal(range(most + 1), name=name)
            with m.If(left != 0):
                m.d.sync += left.eq(left - 1)
            return left

        wait       = countdown("wait", max(clocks.precharge, clocks.refresh_cycle, clocks.active_to_access, clocks.mode))
        active     = countdown("active", clocks.active)
        written    = countdown("written", clocks.write_recovery)
        read       = countdown("read", clocks.read_to_write)
        # A refresh is due early by what may come before it: an activation, its row's least time, and the precharge.
        interval   = clocks.refresh_interval - self.row_clocks - 3
        until_next = Signal(range(interval), init=interval - 1)
        due        = Signal()

        banks = 1 << BANK_BITS
        opened = Signal(banks)
        rows = Array(Signal(ROW_BITS, name=f"row_{bank}", reset_less=True) for bank in range(banks))
        column = access.address[:COLUMN_BITS]
        row    = access.address[COLUMN_BITS + 1:HALF_BITS]
        bank   = Cat(access.address[COLUMN_BITS], access.address[HALF_BITS:])
        is_open, hit, may_close = Signal(), Signal(), Signal()
        m.d.comb += [
            is_open.eq(opened.bit_select(bank, 1)), hit.eq(is_open & (rows[bank] == row)), may_close.eq((active == 0) & (written == 0)),
        ]

        def command(kind: Command, then_wait: int) -> None:
            m.d.sync += [memory.command.eq(kind), wait.eq(then_wait - 1)]

        power_up  = Signal(range(clocks.power_up), init=clocks.power_up - 1)
        refreshes = Signal(range(_REFRESHES), init=_REFRESHES - 1)
        ready     = Signal()    # initialised
        issue     = Signal()    # a read or write
        m.d.comb += [issue.eq(ready & (wait == 0) & ~due & self.i.valid & hit & ~(access.write & (read != 0))), self.i.ready.eq(issue)]
        m.d.sync += [memory.command.eq(Command.NOP), memory.drive.eq(0), memory.enable.eq(1)]
        m.d.sync += memory.mask.eq(Mux(ready, 0, -1))
        m.d.sync += until_next.eq(until_next - 1)
        with m.If(until_next == 0):
            m.d.sync += [until_next.eq(interval - 1), due.eq(ready)]
        m.d.sync += [memory.bank.eq(bank), memory.word.eq(access.data)]

        with m.FSM():
            with m.State("power up"):
                m.d.sync += power_up.eq(power_up - 1)
                with m.If(power_up == 0):
                    m.next = "close"

            with m.State("close"):
                with m.If((wait == 0) & may_close):
                    command(Command.PRECHARGE, clocks.precharge)
                    m.d.sync += [memory.address.eq(_ALL_BANKS), opened.eq(0)]
                    m.next = "refresh"

            with m.State("refresh"):
                with m.If(wait == 0):
                    command(Command.REFRESH, clocks.refresh_cycle)
                    m.d.sync += due.eq(0)
                    with m.If(ready):
                        m.next = "words"
                    with m.Else():
                        m.d.sync += [refreshes.eq(refreshes - 1), until_next.eq(interval - 1)]
                        with m.If(refreshes == 0):
                            m.next = "mode"

            with m.State("mode"):
                with m.If(wait == 0):
                    command(Command.MODE, clocks.mode)
                    m.d.sync += [memory.address.eq(_MODE), memory.bank.eq(0), ready.eq(1)]
                    m.next = "words"

            with m.State("words"):
                with m.If(due):
                    m.next = "close"
                with m.Elif(issue):
                    m.d.sync += [memory.address.eq(column), memory.command.eq(Command.READ)]
                    m.d.sync += read.eq(clocks.read_to_write - 1)
                    with m.If(access.write):
                        m.d.sync += [memory.command.eq(Command.WRITE), memory.drive.eq(1), memory.mask.eq(~access.bytes), read.eq(0)]
                        m.d.sync += written.eq(clocks.write_recovery - 1)
                with m.Elif((wait == 0) & self.i.valid & ~is_open):
                    command(Command.ACTIVATE, clocks.active_to_access)
                    m.d.sync += [memory.address.eq(row), opened.bit_select(bank, 1).eq(1), rows[bank].eq(row)]
                    m.d.sync += active.eq(clocks.active - 1)
                with m.Elif((wait == 0) & self.i.valid & ~hit & may_close):
                    command(Command.PRECHARGE, clocks.precharge)
                    m.d.sync += [memory.address.eq(0), opened.bit_select(bank, 1).eq(0)]

        # Words on their way, a cycle each: the command's register, the pins, the word's register.
        valid, tag = issue & ~access.write, access.tag
        for number in range(self.LATENCY):
            next_valid = Signal(name=f"valid_{number}")
            next_tag = Signal.like(self.tag, name=f"tag_{number}", reset_less=True)
            m.d.sync += [next_valid.eq(valid), next_tag.eq(tag)]
            valid, tag = next_valid, next_tag
        found = Signal(WORD_BITS, reset_less=True)
        m.d.sync += found.eq(memory.found)
        m.d.comb += [self.valid.eq(valid), self.tag.eq(tag), self.found.eq(found)]
        return m
