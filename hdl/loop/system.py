"""The matcher behind a serial line: a pair is received, matched at a pixel a clock, and its disparities are sent back."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.host.loop_registers import LOOP_BAUD
from golden.host.protocol import FRAME_BYTES, FRAME_SECONDS

from ..parts.queue import Queue
from ..parts.uart import UartReceiver, UartTransmitter
from .core import LoopCore, display_ports


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
    config, height, display
        As of :class:`LoopCore`.
    clock_hz, baud : int
        As of :class:`hdl.parts.uart.UartReceiver`.
    frame_seconds : float
        Longest pause within a request or a block, and the silence after which a request is expected.

    Members
    -------
    uart_rx : In(1), uart_tx : Out(1)
        The pins, high while idle; the input is synchronised here.
    leds, display_address, display_left, display_label, display_known
        As of :class:`LoopCore`.
    """
    def __init__(self, config: MatcherConfig, height: int, clock_hz: int, baud: int = LOOP_BAUD, *, display: bool = False,
                 frame_seconds: float = FRAME_SECONDS):
        self.receiver = UartReceiver(clock_hz, baud)
        self.transmitter = UartTransmitter(clock_hz, baud)
        self.core = core = LoopCore(config, height, round(clock_hz * frame_seconds), display=display)
        self.config, self.width, self.height, self.registers, self.matcher = config, core.width, height, core.registers, core.matcher
        self.clock_hz, self.baud, self.display = clock_hz, baud, display
        super().__init__({
            "uart_rx": In(1, init=1), "uart_tx": Out(1, init=1), "leds": Out(8),
            **(display_ports(config, height) if display else {}),
        })

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
        if self.display:
            m.d.comb += [core.display_address.eq(self.display_address),
                         *(getattr(self, name).eq(getattr(core, name)) for name in ("display_left", "display_label", "display_known"))]
        return m
