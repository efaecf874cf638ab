"""Accesses of 32 bits to a register file, with byte strobes, as streams: what a bus's front needs to know of registers."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.core_registers import WORD_BITS, WORD_BYTES
from golden.host.protocol import Status

from ..host.register_file import AccessPort


__all__ = ["Command", "Response", "WordAccess"]


class Command(data.StructLayout):
    """A read or a write of the register ``address``; ``strobes`` of the bytes of ``data`` that are written, both undefined in a read."""
    def __init__(self):
        super().__init__({"address": 8, "write": 1, "data": WORD_BITS, "strobes": WORD_BYTES})


class Response(data.StructLayout):
    """``data`` that was read, undefined after a write or a failure."""
    def __init__(self):
        super().__init__({"status": Status, "data": WORD_BITS})


class WordAccess(wiring.Component):
    """Carries out commands, one at a time.

    Golden: :func:`golden.host.core_registers.word_access`.

    Timing: a response is valid 5 cycles after its command was accepted; the next command is accepted in the cycle after the response was.

    Members
    -------
    i : In(stream.Signature(Command()))
    o : Out(stream.Signature(Response()))
    access : Out(AccessPort(32))
        To the :class:`hdl.host.register_file.RegisterFile`.
    """
    def __init__(self):
        super().__init__({
            "i": In(stream.Signature(Command())),
            "o": Out(stream.Signature(Response())),
            "access": Out(AccessPort(WORD_BITS)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        access  = self.access
        command = Signal(Command(), reset_less=True)
        write   = command.write & command.strobes.any()
        m.d.comb += [access.address.eq(command.address), access.value.eq(command.data), access.write.eq(write)]
        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += command.eq(self.i.p)
                with m.If(self.i.valid):
                    m.next = "look up"
            with m.State("look up"):
                m.next = "merge"
            # Bytes without a strobe keep their value.
            with m.State("merge"):
                for byte in range(WORD_BYTES):
                    with m.If(~command.strobes[byte]):
                        m.d.sync += command.data[8 * byte:8 * byte + 8].eq(access.found[8 * byte:8 * byte + 8])
                m.next = "compare"
            with m.State("compare"):
                m.next = "carry out"
            with m.State("carry out"):
                m.d.comb += access.commit.eq(1)
                m.d.sync += [self.o.valid.eq(1), self.o.p.status.eq(access.status), self.o.p.data.eq(access.found)]
                m.next = "respond"
            with m.State("respond"):
                with m.If(self.o.ready):
                    m.d.sync += self.o.valid.eq(0)
                    m.next = "idle"
        return m
