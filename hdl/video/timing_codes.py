"""The timing codes of BT.656 in a sequence of bytes."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out


__all__ = ["TimingCode", "TimingCodes"]


class TimingCode(data.StructLayout):
    """``f``: field, 0 top, 1 bottom; ``v``: vertical blanking; ``h``: 1 for EAV, 0 for SAV."""
    def __init__(self) -> None:
        super().__init__({"f": 1, "v": 1, "h": 1})


class TimingCodes(wiring.Component):
    """Finds the timing codes ``FF 00 00 XY`` and checks their protection bits; golden: :data:`golden.video.bt656.CORRECTED`.

    Codes differ from one another in at least four bits of XY: one wrong bit is corrected, two are detected.

    Timing: latency :attr:`LATENCY` cycles, one byte each cycle.

    Members
    -------
    data : In(8)
        A byte each cycle.
    byte : Out(8)
        The same, :attr:`LATENCY` cycles later.
    found : Out(1)
        ``byte`` is the XY of a code.
    valid : Out(1)
        It is the code ``code``; implies ``found``.
    corrected : Out(1)
        One of its bits was wrong; implies ``valid``.
    code : Out(TimingCode())
    """
    LATENCY = 2

    def __init__(self) -> None:
        super().__init__({
            "data": In(8),
            "byte": Out(8),
            "found": Out(1),
            "valid": Out(1),
            "corrected": Out(1),
            "code": Out(TimingCode()),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        byte = Signal(8, reset_less=True)
        m.d.sync += [byte.eq(self.data), self.byte.eq(byte)]

        # Preamble before `byte`: FF; FF 00; FF 00 00.
        preamble = Signal(3)
        m.d.sync += preamble.eq(Cat(byte.all(), preamble[:2] & (~byte.any()).replicate(2)))

        # The protection bits that F, V, H call for, against those received. A wrong F, V or H shows in three of them.
        p, h, v, f, one = byte[:4], byte[4], byte[5], byte[6], byte[7]
        syndrome = Signal(4)
        m.d.comb += syndrome.eq(p ^ Cat(f ^ v ^ h, f ^ v, f ^ h, v ^ h))
        wrong_f, wrong_v, wrong_h = syndrome == 0b0111, syndrome == 0b1011, syndrome == 0b1101
        one_bit = Mux(one, syndrome.matches("0001", "0010", "0100", "1000") | wrong_f | wrong_v | wrong_h, syndrome == 0)
        m.d.sync += [
            self.found.eq(preamble[2]),
            self.valid.eq(preamble[2] & ((syndrome == 0) | one_bit)),
            self.corrected.eq(preamble[2] & one_bit),
            self.code.f.eq(f ^ wrong_f), self.code.v.eq(v ^ wrong_v), self.code.h.eq(h ^ wrong_h),
        ]
        return m
