"""AXI4-Lite in front of accesses to registers."""

import enum
from typing import ClassVar

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.core_registers import WORD_BITS, WORD_BYTES
from golden.host.protocol import Status

from .words import Command, Response


__all__ = ["ADDRESS_BITS", "AxiLite", "BusResponse", "bus_response"]


#: Of a byte address: 256 words of four bytes.
ADDRESS_BITS = 10


class BusResponse(enum.IntEnum):
    """How AXI and Avalon tell what became of an access; both use these two bits."""
    OKAY = 0b00
    SLVERR = 0b10
    DECERR = 0b11


def bus_response(status: Value) -> Value:
    """The response to a :class:`Status`: ``DECERR`` where there is no register, ``SLVERR`` where a write was refused."""
    return Mux(status == Status.OK, BusResponse.OKAY, Mux(status == Status.UNKNOWN_ADDRESS, BusResponse.DECERR, BusResponse.SLVERR))


class AxiLite(wiring.Component):
    """Slave of AXI4-Lite: address and data of a write are accepted in any order, and reads and writes do not wait for each other's
    responses to be accepted. Where both wait they take turns.

    Golden: :func:`golden.host.core_registers.word_access`, an access for each response, in the order of the commands at ``command``.

    The two lowest bits of an address are ignored. All outputs are registers, or depend on registers only.

    Timing: a response is valid 8 cycles after address and data were accepted, if the other channel is idle.

    Members
    -------
    awaddr : In(10), awvalid : In(1), awready : Out(1), wdata : In(32), wstrb : In(4), wvalid : In(1), wready : Out(1), bresp : Out(2),
    bvalid : Out(1), bready : In(1), araddr : In(10), arvalid : In(1), arready : Out(1), rdata : Out(32), rresp : Out(2),
    rvalid : Out(1), rready : In(1)
    command : Out(stream.Signature(Command()))
    result : In(stream.Signature(Response()))
    """
    PORTS: ClassVar = {
        "awaddr": In(ADDRESS_BITS), "awvalid": In(1), "awready": Out(1),
        "wdata": In(WORD_BITS), "wstrb": In(WORD_BYTES), "wvalid": In(1), "wready": Out(1),
        "bresp": Out(2), "bvalid": Out(1), "bready": In(1),
        "araddr": In(ADDRESS_BITS), "arvalid": In(1), "arready": Out(1),
        "rdata": Out(WORD_BITS), "rresp": Out(2), "rvalid": Out(1), "rready": In(1),
    }

    def __init__(self):
        super().__init__({
            **self.PORTS,
            "command": Out(stream.Signature(Command())),
            "result": In(stream.Signature(Response())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        command = self.command

        # What was accepted and waits: an address for writing, data, an address for reading.
        waits = {}
        for channel in ("aw", "w", "ar"):
            valid, ready = getattr(self, f"{channel}valid"), getattr(self, f"{channel}ready")
            waits[channel] = full = Signal(name=f"{channel}_waits")
            m.d.comb += ready.eq(~full)
            with m.If(valid & ready):
                m.d.sync += full.eq(1)
        address = {channel: Signal(ADDRESS_BITS - 2, name=f"{channel}_address", reset_less=True) for channel in ("aw", "ar")}
        data    = Signal(WORD_BITS, reset_less=True)
        strobes = Signal(WORD_BYTES, reset_less=True)
        for channel, held in address.items():
            with m.If(~waits[channel]):
                m.d.sync += held.eq(getattr(self, f"{channel}addr")[2:])
        with m.If(~waits["w"]):
            m.d.sync += [data.eq(self.wdata), strobes.eq(self.wstrb)]

        busy      = Signal()    # an access is carried out
        writing   = Signal()    # it is a write
        can_write = Signal()
        can_read  = Signal()
        m.d.comb += [
            can_write.eq(waits["aw"] & waits["w"] & ~self.bvalid),
            can_read.eq(waits["ar"] & ~self.rvalid),
            command.p.write.eq(writing), command.p.address.eq(Mux(writing, address["aw"], address["ar"])),
            command.p.data.eq(data), command.p.strobes.eq(strobes),
        ]
        # In the cycle after an access its response is offered, so that its channel cannot have the next one: they take turns.
        with m.If(~busy & (can_write | can_read)):
            m.d.sync += [busy.eq(1), command.valid.eq(1), writing.eq(can_write)]
        with m.If(command.valid & command.ready):
            m.d.sync += command.valid.eq(0)

        with m.If(self.bvalid & self.bready):
            m.d.sync += self.bvalid.eq(0)
        with m.If(self.rvalid & self.rready):
            m.d.sync += self.rvalid.eq(0)
        m.d.comb += self.result.ready.eq(1)
        with m.If(self.result.valid):
            m.d.sync += busy.eq(0)
            with m.If(writing):
                m.d.sync += [self.bvalid.eq(1), self.bresp.eq(bus_response(self.result.p.status)), waits["aw"].eq(0), waits["w"].eq(0)]
            with m.Else():
                m.d.sync += [self.rvalid.eq(1), self.rresp.eq(bus_response(self.result.p.status)), waits["ar"].eq(0)]
                m.d.sync += self.rdata.eq(Mux(self.result.p.status == Status.OK, self.result.p.data, 0))
        return m
