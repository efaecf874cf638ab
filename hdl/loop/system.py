"""The matcher behind a serial line: a pair is received and matched, and its disparities are sent back."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.host.loop_registers import LOOP_BAUD
from golden.host.protocol import FRAME_BYTES, FRAME_SECONDS

from ..parts.queue import Queue
from ..parts.uart import UartReceiver, UartTransmitter
from .core import LoopCore
from .words import Stores, pass_on


__all__ = ["LoopSystem"]


# Bytes that wait: requests of the host while a block is sent, and a reply while the next block is received.
_REQUEST_BYTES = 10 * FRAME_BYTES
_REPLY_BYTES = 2 * FRAME_BYTES


class LoopSystem(wiring.Component):
    """:class:`LoopCore` behind a serial line; docs/loop.md has the protocol.

    Golden: :class:`golden.host.loop_device.LoopDevice`, byte by byte.

    Timing: the line is full duplex. Up to 10 requests may be sent ahead while a block is sent, and the next block while the reply to
    one is.

    Parameters
    ----------
    stores
        As of :class:`LoopCore`.
    clock_hz, baud : int
        As of :class:`hdl.parts.uart.UartReceiver`.
    frame_seconds : float
        Longest pause within a request or a block, and the silence after which a request is expected.

    Members
    -------
    uart_rx : In(1), uart_tx : Out(1)
        The pins, high while idle; the input is synchronised here.
    leds, members of ``stores.outside``
        As of :class:`LoopCore`.
    """
    def __init__(self, stores: Stores, clock_hz: int, baud: int = LOOP_BAUD, *, frame_seconds: float = FRAME_SECONDS):
        self.receiver = UartReceiver(clock_hz, baud)
        self.transmitter = UartTransmitter(clock_hz, baud)
        self.core = core = LoopCore(stores, round(clock_hz * frame_seconds))
        self.config, self.width, self.height = core.config, core.width, core.height
        self.registers, self.matcher, self.stores = core.registers, core.matcher, stores
        self.clock_hz, self.baud = clock_hz, baud
        super().__init__({"uart_rx": In(1, init=1), "uart_tx": Out(1, init=1), "leds": Out(8), **stores.outside})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.receiver = receiver = self.receiver
        m.submodules.requests = requests = Queue(8, _REQUEST_BYTES)
        m.submodules.core = core = self.core
        m.submodules.replies = replies = Queue(8, _REPLY_BYTES)
        m.submodules.transmitter = transmitter = self.transmitter
        wiring.connect(m, receiver.o, requests.i)
        # Reading a block RAM takes half of a clock.
        m.submodules.next_request = next_request = Queue(8, 1)
        wiring.connect(m, requests.o, next_request.i)
        wiring.connect(m, next_request.o, core.i)
        wiring.connect(m, core.o, replies.i)
        wiring.connect(m, replies.o, transmitter.i)
        m.d.comb += [
            receiver.rx.eq(self.uart_rx), self.uart_tx.eq(transmitter.tx), self.leds.eq(core.leds),
            core.line_error.eq(receiver.framing_error | receiver.overrun),
        ]
        pass_on(m, self.stores.outside, core, self)
        return m
