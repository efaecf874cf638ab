"""Ports between a board's top level and the video system."""

from amaranth.lib.wiring import In, Out, Signature

from golden.config import PIXEL_BITS

from .words import LocalBus


__all__ = ["DOMAINS", "SystemPorts"]


#: Clock domains that the board provides: the memory controller's, the monitor's pixel clock, those of the decoder's two channels.
DOMAINS = ("sync", "display", "left_camera", "right_camera")


class SystemPorts(Signature):
    """Ports of the video system, seen from the system; in domain ``sync`` unless another one is named.

    Members
    -------
    left_data, right_data : In(8)
        BT.656 bytes, in ``left_camera`` and ``right_camera``.
    memory : Out(LocalBus())
    red, green, blue : Out(8), de, hsync, vsync : Out(1)
        In ``display``: a pixel, whether it is in the active area, and the sync signals with the polarity of the format.
    decoder_scl_low, decoder_sda_low, dvi_scl_low, dvi_sda_low : Out(1)
        Drive a line of the decoder's or the DVI transmitter's I2C bus low (open drain).
    decoder_scl, decoder_sda, dvi_scl, dvi_sda : In(1)
        Level of the line.
    decoder_reset_n, decoder_powerdown_n : Out(1)
        Low active.
    uart_rx : In(1), uart_tx : Out(1)
        High when idle.
    leds : Out(8)
        1 is lit.
    buttons : In(4)
        1 is pressed; not debounced.
    """
    def __init__(self) -> None:
        super().__init__({
            "left_data": In(8),
            "right_data": In(8),
            "memory": Out(LocalBus()),
            "red": Out(PIXEL_BITS),
            "green": Out(PIXEL_BITS),
            "blue": Out(PIXEL_BITS),
            "de": Out(1),
            "hsync": Out(1),
            "vsync": Out(1),
            **{f"{bus}_{line}_low": Out(1) for bus in ("decoder", "dvi") for line in ("scl", "sda")},
            **{f"{bus}_{line}": In(1) for bus in ("decoder", "dvi") for line in ("scl", "sda")},
            "decoder_reset_n": Out(1),
            "decoder_powerdown_n": Out(1),
            "uart_rx": In(1),
            "uart_tx": Out(1),
            "leds": Out(8),
            "buttons": In(4),
        })
