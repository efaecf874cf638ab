"""Avalon-MM in front of accesses to registers."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.core_registers import WORD_BITS, WORD_BYTES
from golden.host.protocol import Status

from .axi_lite import bus_response
from .words import Command, Response


__all__ = ["AvalonMemoryMapped"]


class AvalonMemoryMapped(wiring.Component):
    """Agent of Avalon-MM with one access at a time: ``waitrequest`` is high from an access to its response.

    Golden: :func:`golden.host.core_registers.word_access`.

    Addresses are of words. ``response`` is valid with ``readdatavalid`` and with ``writeresponsevalid``; a host without responses leaves
    it and ``writeresponsevalid`` open. All outputs are registers.

    Timing: a response is valid 7 cycles after its access was accepted.

    Members
    -------
    address : In(8), read : In(1), write : In(1), writedata : In(32), byteenable : In(4), waitrequest : Out(1), readdata : Out(32),
    readdatavalid : Out(1), response : Out(2), writeresponsevalid : Out(1)
    command : Out(stream.Signature(Command()))
    result : In(stream.Signature(Response()))
    """
    PORTS: ClassVar = {
        "address": In(8), "read": In(1), "write": In(1), "writedata": In(WORD_BITS), "byteenable": In(WORD_BYTES),
        "waitrequest": Out(1), "readdata": Out(WORD_BITS), "readdatavalid": Out(1), "response": Out(2), "writeresponsevalid": Out(1),
    }

    def __init__(self):
        super().__init__({
            **self.PORTS,
            "command": Out(stream.Signature(Command())),
            "result": In(stream.Signature(Response())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        command, result = self.command, self.result
        m.d.sync += [self.readdatavalid.eq(0), self.writeresponsevalid.eq(0)]
        with m.If(~self.waitrequest):
            m.d.sync += [
                command.p.address.eq(self.address), command.p.write.eq(self.write),
                command.p.data.eq(self.writedata), command.p.strobes.eq(self.byteenable),
            ]
            with m.If(self.read | self.write):
                m.d.sync += [self.waitrequest.eq(1), command.valid.eq(1)]
        with m.If(command.valid & command.ready):
            m.d.sync += command.valid.eq(0)
        m.d.comb += result.ready.eq(1)
        with m.If(result.valid):
            m.d.sync += [
                self.waitrequest.eq(0), self.response.eq(bus_response(result.p.status)),
                self.readdatavalid.eq(~command.p.write), self.writeresponsevalid.eq(command.p.write),
                self.readdata.eq(Mux(result.p.status == Status.OK, result.p.data, 0)),
            ]
        return m
