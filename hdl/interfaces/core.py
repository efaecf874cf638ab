"""The matcher with its registers, behind plain streams: what the cores with a bus have in common."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.host.core_registers import WORD_BITS, core_register_map
from golden.host.registers import COUNT_MAX
from golden.video.frame_rule import Closes, Fault

from ..host.register_file import RegisterFile
from ..matcher.matcher import Matcher
from ..matcher.settings import setting_ports
from ..matcher.stream import DisparityWord
from .frame_rule import FrameRule, ReceivedPixel
from .words import Command, Response, WordAccess


__all__ = ["RegisteredMatcher"]


# Frames that may be inside the matcher before their first disparity is output, each of one pixel: more than it holds pixels.
_FRAMES = 4096


class RegisteredMatcher(wiring.Component):
    """A matcher whose settings, size of frames included, and whose faults are registers.

    Golden: :func:`golden.matcher.matcher.match` of the pictures of :func:`golden.video.frame_rule.received`, and
    :func:`golden.host.core_registers.word_access` of the registers of :func:`golden.host.core_registers.core_register_map`.

    The action ``apply`` puts all settings into force together, before the next frame whose first pixel is not offered yet. ``i`` waits
    between two frames until the frames before have begun to be output, as parts of the matcher sample settings at different times;
    ``applying`` is 1 until then.

    Timing: that of :class:`Matcher`.

    Parameters
    ----------
    config : MatcherConfig
    height, max_height : int
        Lines of a frame after reset, and the most that can be set.
    closes : Closes
        What the stream of pixels marks.

    Members
    -------
    i : In(stream.Signature(ReceivedPixel()))
    o : Out(stream.Signature(DisparityWord(config)))
    command : In(stream.Signature(Command()))
    response : Out(stream.Signature(Response()))
    """
    def __init__(self, config: MatcherConfig, height: int, closes: Closes, max_height: int = 4096):
        self.config = config
        self.registers = core_register_map(config, height, max_height)
        self.matcher = Matcher(config)
        self.rule = FrameRule(config.max_width, max_height, closes)
        self.register_file = RegisterFile(self.registers, WORD_BITS)
        self.access = WordAccess()
        super().__init__({
            "i": In(stream.Signature(ReceivedPixel())),
            "o": Out(stream.Signature(DisparityWord(config))),
            "command": In(stream.Signature(Command())),
            "response": Out(stream.Signature(Response())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.frame_rule = rule = self.rule
        m.submodules.matcher = matcher = self.matcher
        m.submodules.register_file = file = self.register_file
        m.submodules.access = access = self.access
        wiring.connect(m, wiring.flipped(self.i), rule.i)
        wiring.connect(m, rule.o, matcher.i)
        wiring.connect(m, matcher.o, wiring.flipped(self.o))
        wiring.connect(m, wiring.flipped(self.command), access.i)
        wiring.connect(m, access.o, wiring.flipped(self.response))
        wiring.connect(m, access.access, file.access)
        settings, actions, status = file.settings, file.actions, file.status

        # Frames whose first line is in the matcher, and whose first disparity was not output: without that line it may drop a frame.
        waiting = Signal(range(_FRAMES))
        line_zero = Signal()
        first_line, accepted = Signal(), Signal()
        m.d.comb += [accepted.eq(rule.o.valid & rule.o.ready), first_line.eq(rule.o.p.first | line_zero)]
        with m.If(accepted):
            m.d.sync += line_zero.eq(first_line & ~rule.o.p.last)
        enters = accepted & first_line & rule.o.p.last
        leaves = matcher.o.valid & matcher.o.ready & matcher.o.p.first
        m.d.sync += waiting.eq(waiting + enters - leaves)

        # Settings.
        applying = Signal()
        apply    = Signal()
        m.d.comb += apply.eq(applying & rule.idle & (waiting == 0))
        with m.If(actions.apply):
            m.d.sync += applying.eq(1)
        with m.Elif(apply):
            m.d.sync += applying.eq(0)
        for name in ("width", "height"):
            port = getattr(rule, name)
            held = Signal.like(port, name=f"{name}_set", init=self.registers[name].reset)
            with m.If(apply):
                m.d.sync += held.eq(settings[name])
            m.d.comb += port.eq(held)
        m.d.comb += [
            rule.hold.eq(applying | (waiting >= _FRAMES - 2)),
            *(getattr(matcher, name).eq(settings[name]) for name in self.config.settings),
            matcher.apply_settings.eq(apply), matcher.clear.eq(actions.clear),
            status.matcher_error.eq(matcher.error), status.applying.eq(applying),
        ]
        assert set(setting_ports(self.config)) == {*self.config.settings, "apply_settings"}

        # Faults: the first one, and their number.
        counted = {"faults": rule.fault != Fault.NONE, "frames": matcher.o.valid & matcher.o.ready & matcher.o.p.end}
        for name, event in counted.items():
            count = Signal.like(status[name], name=name)
            m.d.comb += status[name].eq(count)
            with m.If(actions.clear):
                m.d.sync += count.eq(0)
            with m.Elif(event & (count != COUNT_MAX)):
                m.d.sync += count.eq(count + 1)
        fault = Signal(Fault)
        m.d.comb += status.fault.eq(fault)
        with m.If(actions.clear):
            m.d.sync += fault.eq(Fault.NONE)
        with m.Elif(fault == Fault.NONE):
            m.d.sync += fault.eq(rule.fault)
        return m
