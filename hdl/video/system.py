"""The whole system of the thesis (figures 15 to 18): from two cameras to disparities on a monitor."""

from fractions import Fraction

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.host.protocol import BAUD, FRAME_SECONDS
from golden.host.registers import CLOCK_BITS, SETUPS, register_map
from golden.rig.config import RigConfig
from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import PAL, CameraFormat, DisplayFormat
from golden.video.memory_map import MemoryMap, Plane
from golden.video.pairing import WINDOW, buffers_needed

from ..host.registers import SerialRegisters
from ..matcher.matcher import Matcher
from ..matcher.stream import PixelPair, copy_flags
from ..parts.arithmetic import maximum
from .arbiter import Arbiter
from .bt656 import CameraInput
from .buttons import Button
from .dvi import DisplayOutput
from .frame_read import PairReader, PictureReader
from .frame_write import FrameWriter, PictureWriter
from .line_access import LineAccess
from .pair_rig import PairRig
from .pairing import BufferControl
from .ports import SystemPorts
from .setup import ChipSetup
from .shown_label import ShownLabel
from .words import PlanePixel


__all__ = ["PairFork", "StereoSystem"]


class PairFork(wiring.Component):
    """Forks the pixels of a pair: all to the matcher, those of the left picture to the frame store too, for the monitor.

    Timing: combinational; each branch accepts a pixel once, whenever it is ready; ``i`` is accepted when both have it.

    Members
    -------
    i, matcher : stream.Signature(PixelPair())
    left : Out(stream.Signature(PlanePixel()))
    """
    def __init__(self) -> None:
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "matcher": Out(stream.Signature(PixelPair())),
            "left": Out(stream.Signature(PlanePixel())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        branches = []
        for name, branch in (("matcher", self.matcher), ("left", self.left)):
            done = Signal(name=f"{name}_done")  # this branch has accepted the pixel in an earlier cycle
            ready = Signal(name=f"{name}_ready")
            m.d.comb += [branch.valid.eq(self.i.valid & ~done), ready.eq(done | branch.ready)]
            m.d.sync += done.eq(self.i.valid & ready & ~self.i.ready)
            branches.append(ready)
        m.d.comb += [
            self.i.ready.eq(branches[0] & branches[1]),
            self.matcher.payload.eq(self.i.payload),
            self.left.p.value.eq(self.i.p.left), *copy_flags(self.left.p, self.i.p),
        ]
        return m


class StereoSystem(wiring.Component):
    """Cameras, frame store, matcher and monitor, with the host's registers and the set-up of the video chips.

    The monitor shows :func:`golden.video.display.monitor_picture` of the labels (:class:`hdl.video.shown_label.ShownLabel`) of the
    disparities that :func:`golden.matcher.matcher.match` computes for the pair that :class:`golden.video.pairing.Pairing` chose among the
    frames that :func:`golden.video.bt656.decode` finds in the cameras' bytes.

    The matcher's settings take effect with the next pair, the choice of the shown picture with the monitor's next frame. Button 0 repeats
    the set-up of the chips, button 1 clears the counters. LEDs: 0 and 1 left and right video is good, 2 and 3 left and right decoder is
    locked, 4 memory ready, 5 toggles with each pair, 6 a set-up has failed, 7 a frame or picture was dropped or late since the counters
    were cleared.

    Domains: ``sync``, ``display``, ``left_camera``, ``right_camera``, asynchronous to each other.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        ``max_width`` is the cameras' width.
    display : :class:`DisplayFormat`
    camera : :class:`CameraFormat`
    timing : :class:`MemoryTiming`
        ``clock_hz`` is that of ``sync``. :class:`golden.errors.UserError` if the memory cannot serve the system.
    baud : int
        Baud rate of the registers' serial line. The time-out is as many bits as :data:`golden.host.protocol.FRAME_SECONDS` is at
        :data:`golden.host.protocol.BAUD`.
    setup_hz, bus_hz : int
        Frequency of ``sync`` that the times of the buttons and of the chips' set-up are counted with, and that of the I2C bus. In a
        simulation a low ``setup_hz`` shortens these times.
    window : Fraction or float
        Greatest time between the beginnings of a pair's frames, in frame periods.
    rig : RigConfig or None
        Of rectification and balance of the pair; without them if ``None``. :class:`ValueError` if it is for another size.

    Attributes
    ----------
    matcher : :class:`Matcher`
    pair_rig : :class:`PairRig` or None
    memory_map : :class:`MemoryMap`
    budget : :class:`Budget`
        Of the memory's bandwidth; it sizes the FIFOs.
    registers : :class:`golden.host.registers.RegisterMap`
    depths : dict of str to int
        Depth in words of each FIFO whose highest level is in a register, by the register's name without ``_fill``.
    """
    def __init__(self, config: MatcherConfig, display: DisplayFormat, *, camera: CameraFormat = PAL, timing: MemoryTiming | None = None,
                 baud: int = BAUD, setup_hz: int | None = None, bus_hz: int = 100_000, window: Fraction | float = WINDOW,
                 rig: RigConfig | None = None):
        if config.max_width != camera.width:
            raise ValueError(f"the matcher is built for lines of {config.max_width} pixels, and the cameras send {camera.width}: "
                             "choose the same width")
        timing = timing or MemoryTiming()
        clock_hz = timing.clock_hz
        self.config = config
        self.camera = camera
        self.clock_hz = clock_hz
        self.matcher = matcher = Matcher(config)
        self.pair_rig = PairRig(rig, config, camera) if rig else None
        pixels = camera.width * camera.height
        frame_clocks = matcher.frame_clocks(camera.width, camera.height)
        if self.pair_rig:
            frame_clocks = self.pair_rig.frame_clocks(matcher)
        # A matcher that is too slow for any number of buffers is refused by the budget.
        reading_seconds = frame_clocks / clock_hz
        buffers = buffers_needed(reading_seconds, camera.frame_seconds, window) if reading_seconds < camera.frame_seconds else 3
        # One more, for the pair that is kept for the host.
        self.memory_map = memory_map = MemoryMap(camera.width, camera.height, buffers + 1, host=True)
        self.budget = budget = Budget(memory_map, camera, display, timing, matcher_clocks=frame_clocks / pixels, window=window, kept=1)
        budget.check()
        burst = budget.burst

        self.depths = {
            "left_camera": budget.camera_depth, "right_camera": budget.camera_depth,
            **dict.fromkeys(("pair", "picture"), max(2 * burst, budget.matcher_depth)), "display": max(2 * burst, budget.display_depth),
        }
        self.cameras = {side: CameraInput(camera, f"{side}_camera") for side in ("left", "right")}
        self.frame_writers = {side: FrameWriter(memory_map, plane, burst=burst, depth=self.depths[f"{side}_camera"])
                              for side, plane in (("left", Plane.LEFT), ("right", Plane.RIGHT))}
        self.picture_writers = {name: PictureWriter(memory_map, plane, burst=burst, depth=self.depths["picture"])
                                for name, plane in (("disparity", Plane.DISPARITY), ("left", Plane.SHOWN_LEFT))}
        self.pair_reader = PairReader(memory_map, burst=burst, depth=self.depths["pair"], moves=bool(rig))
        self.picture_reader = PictureReader(memory_map, config, burst=burst, depth=self.depths["display"])
        self.display = DisplayOutput(config, display, camera.width, camera.height)
        self.line_access = LineAccess(memory_map, burst=burst)
        # Two ports are the line access's, of which one waits at a time: as a master it counts once.
        self.arbiter = Arbiter(5, 3, burst=burst)
        self.control = BufferControl(memory_map.buffers, round(window * camera.frame_seconds * clock_hz))
        self.setup_hz = setup_hz or clock_hz
        self.setups = {role: ChipSetup(chip, self.setup_hz, bus_hz) for role, chip in SETUPS.items()}
        self.registers = register_map(config, camera.height, rig)
        # The time-out is the same number of bits at every rate.
        self.serial = SerialRegisters(self.registers, clock_hz, baud, frame_seconds=FRAME_SECONDS * BAUD / baud)
        super().__init__(SystemPorts())

    def elaborate(self, platform: object) -> Module:
        m = Module()
        control = m.submodules.control = self.control
        matcher = m.submodules.matcher = self.matcher
        arbiter = m.submodules.arbiter = self.arbiter
        display = m.submodules.display = self.display
        serial = m.submodules.serial = self.serial
        settings, actions = serial.settings, serial.actions
        status = serial.status
        m.d.comb += [serial.rx.eq(self.uart_rx), self.uart_tx.eq(serial.tx)]
        wiring.connect(m, arbiter.bus, wiring.flipped(self.memory))

        # Buttons.
        pressed = []
        for number in range(2):
            m.submodules[f"button_{number}"] = button = Button(self.setup_hz)
            m.d.comb += button.i.eq(self.buttons[number])
            pressed.append(button.pressed)
        clear   = Signal()
        restart = Signal()
        m.d.comb += [restart.eq(actions.restart_setup | pressed[0]), clear.eq(actions.clear_counters | pressed[1])]

        # From the cameras to the frame store.
        ports = iter(arbiter.write)
        for side, camera in self.cameras.items():
            writer = self.frame_writers[side]
            m.submodules[f"{side}_input"] = camera
            m.submodules[f"{side}_writer"] = writer
            wiring.connect(m, camera.o, writer.i)
            wiring.connect(m, writer.port, next(ports))
            m.d.comb += [camera.data.eq(getattr(self, f"{side}_data")), camera.clear.eq(clear), status[f"{side}_signal"].eq(camera.present)]
            m.d.comb += [status[f"{side}_{count}"].eq(getattr(camera, count)) for count in ("corrected", "rejected", "dropped", "overflow")]
            m.d.comb += [status[f"{side}_{count}"].eq(getattr(control, f"{side}_{count}")) for count in ("skipped", "unpaired")]
            m.d.comb += status[f"{side}_camera_fill"].eq(writer.fill)
            wiring.connect(m, writer.control, getattr(control, f"{side}_camera"))
            m.d.comb += writer.clear_fill.eq(clear)

        # A pair through the matcher. The host's settings take effect with its start.
        m.submodules.pair_reader = pair_reader = self.pair_reader
        m.submodules.fork = fork = PairFork()
        pairs = iter(arbiter.read)
        wiring.connect(m, pair_reader.port, next(pairs))
        wiring.connect(m, fork.matcher, matcher.i)
        wiring.connect(m, pair_reader.control, control.reader)
        start = control.reader.start
        m.d.comb += [
            pair_reader.clear_fill.eq(clear),
            *(getattr(matcher, name).eq(settings[name]) for name in self.config.settings),
            matcher.apply_settings.eq(start), matcher.clear.eq(clear), control.hold.eq(settings.hold), control.clear.eq(clear),
        ]
        if self.pair_rig:
            m.submodules.pair_rig = rig = self.pair_rig
            wiring.connect(m, pair_reader.o, rig.i)
            wiring.connect(m, rig.o, fork.i)
            m.d.comb += [
                rig.start.eq(start), rig.clear.eq(clear), pair_reader.row_offset.eq(rig.used_row_offset),
                rig.minimum.eq(settings.minimum if "minimum" in self.config.settings else self.config.minimum),
                *(getattr(rig, name).eq(settings[name]) for name in rig.SETTINGS),
                *(getattr(rig, name).eq(actions[name]) for name in rig.ACTIONS),
                *(status[name].eq(getattr(rig, name)) for name in rig.STATUS),
            ]
        else:
            wiring.connect(m, pair_reader.o, fork.i)

        # Disparities and the left picture to the frame store.
        disparity_writer, left_writer = self.picture_writers["disparity"], self.picture_writers["left"]
        m.submodules.disparity_writer, m.submodules.left_plane_writer = disparity_writer, left_writer
        wiring.connect(m, fork.left, left_writer.i)
        m.submodules.shown_label = shown_label = ShownLabel(self.config)
        if shown_label.is_set:
            m.d.comb += shown_label.minimum.eq(settings.minimum)
        m.d.comb += [
            shown_label.start.eq(start), shown_label.i.eq(matcher.o.p), shown_label.step.eq(matcher.o.valid & matcher.o.ready),
            disparity_writer.i.p.value.eq(shown_label.label), *copy_flags(disparity_writer.i.p, matcher.o.p),
            disparity_writer.i.valid.eq(matcher.o.valid), matcher.o.ready.eq(disparity_writer.i.ready),
        ]
        for writer, plane in ((disparity_writer, control.disparity_plane), (left_writer, control.left_plane)):
            wiring.connect(m, writer.port, next(ports))
            wiring.connect(m, writer.control, plane)
            m.d.comb += writer.clear_fill.eq(clear)

        # From the frame store to the monitor.
        m.submodules.picture_reader = picture_reader = self.picture_reader
        wiring.connect(m, picture_reader.port, next(pairs))
        wiring.connect(m, picture_reader.o, display.i)
        shown = control.display
        m.d.comb += [
            shown.fetch.eq(display.fetch), picture_reader.fetch.eq(display.fetch), picture_reader.clear_fill.eq(clear),
            picture_reader.shown_buffer.eq(shown.shown_buffer), picture_reader.shown_valid.eq(shown.shown_valid),
            display.shown_valid.eq(shown.shown_valid), display.mode.eq(settings.show), display.colour.eq(settings.colour),
            display.clear.eq(clear),
            *(getattr(self, name).eq(getattr(display, name)) for name in ("red", "green", "blue", "de", "hsync", "vsync")),
        ]

        # Lines of a kept pair to the host, and lines of its own pair from it.
        m.submodules.line_access = line_access = self.line_access
        wiring.connect(m, line_access.read, next(pairs))
        wiring.connect(m, line_access.write, next(ports))
        wiring.connect(m, serial.line, line_access.i)
        wiring.connect(m, line_access.o, serial.byte)
        wiring.connect(m, serial.put, line_access.put)
        m.d.comb += [
            control.keep.eq(settings.keep), status.kept.eq(control.kept),
            line_access.left.eq(control.kept_left), line_access.right.eq(control.kept_right), line_access.slot.eq(control.kept_slot),
            line_access.put_plane.eq(serial.put_plane), line_access.put_line.eq(serial.put_line),
            control.host.eq(settings.source), control.put.eq(serial.start_pair), serial.putting.eq(control.putting),
        ]
        clocks   = Signal(CLOCK_BITS, reset_less=True)  # from the start of a pair to its last disparity in memory
        counting = Signal()
        m.d.comb += Cat(status.clocks_low, status.clocks_high).eq(clocks)
        with m.If(start):
            m.d.sync += [clocks.eq(1), counting.eq(1)]
        with m.Elif(counting):
            m.d.sync += [clocks.eq(clocks + 1), counting.eq(~disparity_writer.control.complete)]

        # Chips.
        for (role, setup), bus in zip(self.setups.items(), ("decoder", "dvi")):
            m.submodules[f"{role}_setup"] = setup
            m.d.comb += [
                setup.restart.eq(restart), setup.scl_i.eq(getattr(self, f"{bus}_scl")), setup.sda_i.eq(getattr(self, f"{bus}_sda")),
                getattr(self, f"{bus}_scl_low").eq(setup.scl_low), getattr(self, f"{bus}_sda_low").eq(setup.sda_low),
                status[f"{role}_state"].eq(Mux(setup.failed, 2, setup.done)), status[f"{role}_step"].eq(setup.step),
                status[f"{role}_reason"].eq(setup.reason), status[f"{role}_failures"].eq(setup.failures),
            ]
        decoder = self.setups["decoder"]
        m.d.comb += [
            self.decoder_reset_n.eq(decoder.resetb), self.decoder_powerdown_n.eq(decoder.pdn),
            Cat(status.left_locked, status.right_locked).eq(decoder.locked),
        ]

        # Remaining status registers.
        m.d.comb += [
            status.memory_ready.eq(self.memory.init_done), status.matcher_error.eq(matcher.error), status.pairs.eq(control.pairs),
            status.pictures_dropped.eq(control.pictures_dropped), status.pictures_abandoned.eq(control.pictures_abandoned),
            status.display_frames.eq(display.frames), status.display_underflows.eq(display.underflows),
            status.pair_fill.eq(pair_reader.fill), status.display_fill.eq(picture_reader.fill),
            status.picture_fill.eq(maximum(disparity_writer.fill, left_writer.fill)),
        ]
        lost = [status[name].any() for name in ("left_dropped", "right_dropped", "left_skipped", "right_skipped", "pictures_abandoned",
                                                "display_underflows")]
        m.d.sync += self.leds.eq(Cat(
            status.left_signal, status.right_signal, status.left_locked, status.right_locked, status.memory_ready, status.pairs[0],
            Cat(setup.failed for setup in self.setups.values()).any(), Cat(lost).any()))
        return m
