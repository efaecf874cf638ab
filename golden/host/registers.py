"""The register map of the system as data, and the chip's reply to a request; docs/registers.md is its page."""

import enum
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ..config import METHODS, PIXEL_MAX, MatcherConfig
from ..rig.balance import GAIN_ONE, GAINS, OFFSETS
from ..rig.config import MapsInUse, RigConfig
from ..rig.maps import SUM_BITS, WORD_BITS, word_count
from ..rig.rectify import ROW_OFFSETS
from ..video.setup_steps import TFP410, TVP5154, Chip, Failure
from .build_id import parameter_digest, release
from .protocol import Operation, Reply, Status, decode_request


__all__ = ["CLOCK_BITS", "COUNT_MAX", "IDENTITY", "SETUPS", "VERSION", "Kind", "Register", "RegisterMap", "access", "answer",
           "register_map", "setting_registers"]


#: Value of ``identity``: "SG" in ASCII.
IDENTITY = int.from_bytes(b"SG", "big")

#: Version of this map: incremented whenever a register is added, removed or changes its meaning.
VERSION = 6

#: Bits of the clocks of a pair: 0.2 s at 75 MHz, five frames.
CLOCK_BITS = 24

#: Counters hold their greatest value.
COUNT_MAX = 2**16 - 1

#: Values of a register that may be negative.
SIGNED = range(-2**15, 2**15)


class Kind(enum.StrEnum):
    """Kind of a register.

    ``CONSTANT``: fixed when the gateware was built. ``SETTING``: written by the host. ``ACTION``: writing 1 triggers something once; reads
    as 0. ``STATUS``: present state. ``COUNTER``: events, or a greatest value, since reset or the last ``clear_counters``.
    """
    CONSTANT = "constant"
    SETTING = "setting"
    ACTION = "action"
    STATUS = "status"
    COUNTER = "counter"


@dataclass(frozen=True)
class Register:
    """A register of up to 16 bits.

    Parameters
    ----------
    name : str
        A plain identifier.
    address : int
        8 bits.
    kind : Kind
        Determines :attr:`access`.
    maximum : int
        Greatest value; determines :attr:`width`.
    description : str
        One line.
    minimum : int
        Least value that may be written. Below 0, values are sent as two's complement of 16 bits.
    reset : int
        Value after reset; of a constant, its value.
    unit : str
        Unit of the values.
    words : mapping
        Names of values.
    """
    name: str
    address: int
    kind: Kind
    maximum: int
    description: str
    minimum: int = 0
    reset: int = 0
    unit: str = ""
    words: Mapping[int, str] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not self.name.isidentifier():
            raise ValueError(f"the name of a register must be an identifier, not {self.name!r}")
        if self.address not in range(256):
            raise ValueError(f"the address of {self.name} must be from 0 to 255, not {self.address!r}")
        limits = (SIGNED[0], SIGNED[-1]) if self.signed else (0, COUNT_MAX)
        if not limits[0] <= self.minimum <= self.maximum <= limits[1]:
            raise ValueError(f"the values of {self.name} must be within {limits[0]} .. {limits[1]} in rising order, "
                             f"not {self.minimum} .. {self.maximum}")
        least = self.minimum if self.kind is Kind.SETTING else 0
        if not least <= self.reset <= self.maximum:
            raise ValueError(f"the reset value of {self.name} must be from {least} to {self.maximum}, not {self.reset!r}")

    @property
    def signed(self) -> bool:
        """Whether values may be negative."""
        return self.minimum < 0

    @property
    def width(self) -> int:
        """Bits, with the sign's."""
        return max(1, self.maximum.bit_length(), (~self.minimum).bit_length() if self.signed else 0) + self.signed

    def encode(self, value: int) -> int:
        """The 16 bits of a value on the line."""
        return value & COUNT_MAX

    def decode(self, bits: int) -> int:
        """The value of 16 bits of the line."""
        return bits - (COUNT_MAX + 1) if self.signed and bits > SIGNED[-1] else bits

    @property
    def writable(self) -> bool:
        return self.kind in (Kind.SETTING, Kind.ACTION)

    @property
    def access(self) -> str:
        """``read-only``, ``read-write`` or ``write 1``."""
        return {Kind.SETTING: "read-write", Kind.ACTION: "write 1"}.get(self.kind, "read-only")

    #: Names of values that take more characters than this are in a separate list on the page.
    NAMES_MAX = 60

    @property
    def limits(self) -> str:
        """The valid values, with their names if these are short."""
        named = ", ".join(f"{value} {word}" for value, word in self.words.items())
        if named and len(named) <= self.NAMES_MAX:
            return named
        return f"{self.minimum} .. {self.maximum}" if self.minimum < self.maximum else f"{self.maximum}"

    def text(self, value: int) -> str:
        """A value for a reader: its name, or its number and unit."""
        if value in self.words:
            return self.words[value]
        return f"{value} {self.unit}".rstrip()


@dataclass(frozen=True)
class RegisterMap:
    """Registers with unique names and addresses."""
    registers: tuple[Register, ...]

    def __post_init__(self) -> None:
        for what in ("name", "address"):
            seen = [getattr(register, what) for register in self.registers]
            twice = sorted({item for item in seen if seen.count(item) > 1})
            if twice:
                raise ValueError(f"two registers have the {what} {twice[0]!r}")

    def __iter__(self) -> Iterator[Register]:
        return iter(self.registers)

    def __len__(self) -> int:
        return len(self.registers)

    def __contains__(self, name: object) -> bool:
        return any(register.name == name for register in self.registers)

    def __getitem__(self, name: str) -> Register:
        for register in self.registers:
            if register.name == name:
                return register
        raise KeyError(name)

    def at(self, address: int) -> Register | None:
        """The register of an address."""
        return next((register for register in self.registers if register.address == address), None)

    def of(self, *kinds: Kind) -> list[Register]:
        """The registers of these kinds, in the map's order."""
        return [register for register in self.registers if register.kind in kinds]


#: The chips that are set up, by the prefix of their registers' names.
SETUPS: Mapping[str, Chip] = {"decoder": TVP5154, "transmitter": TFP410}

_NO_YES = {0: "no", 1: "yes"}
_OFF_ON = {0: "off", 1: "on"}

# Addresses of the settings; further ones of a method follow.
_SETTINGS = {
    "u1": 0x10, "u2": 0x11, "u3": 0x12, "in_use": 0x13, "minimum": 0x17, "check": 0x18, "fill": 0x19, "median": 0x1A,
    "census_threshold": 0x1B, "near_threshold": 0x1C, "far_threshold": 0x1D, "step_threshold": 0x1E, "above_share": 0x1F,
    "below_share": 0x22, "gate_numerator": 0x23, "gate_offset": 0x24, "gate_floor": 0x25}
_OTHER_SETTINGS = range(0x26, 0x30)


def _setup_status() -> Iterator[tuple[str, str, Mapping[int, str]]]:
    """Name, description and words of the status of each chip's set-up, in the order of addresses."""
    for role, chip in SETUPS.items():
        yield f"{role}_state", f"state of the set-up of the {chip.name}", {0: "busy", 1: "done", 2: "failed"}
        yield f"{role}_step", "step that failed last", {number: step.text for number, step in enumerate(chip.steps)}
        yield f"{role}_reason", "why it failed", {failure.value: failure.text for failure in Failure}


def setting_registers(config: MatcherConfig) -> Iterator[Register]:
    """The settings of the configuration's matcher."""
    others = iter(_OTHER_SETTINGS)
    for name, setting in config.settings.items():
        greatest = min(setting.maximum, config.labels) if name == "in_use" else setting.maximum
        address = _SETTINGS[name] if name in _SETTINGS else next(others)
        yield Register(name, address, Kind.SETTING, greatest, setting.description, minimum=setting.minimum, reset=setting.default,
                       unit=setting.unit, words={} if setting.unit else _OFF_ON)


def _counters() -> Iterator[tuple[str, str, str]]:
    """Name, unit and description of each counter, in the order of addresses."""
    yield "display_frames", "frames", "frames of the display"
    yield "pairs", "pairs", "pairs matched"
    yield "pictures_dropped", "pictures", "disparity pictures replaced by a newer one before they were shown"
    yield "pictures_abandoned", "pictures", "disparity pictures that were not finished"
    yield "display_underflows", "events", "pictures cut short on the display because the memory was late"
    yield "uart_errors", "events", "framing errors, lost bytes, bad sums, time-outs and stray bytes of this line"
    for side in ("left", "right"):
        yield f"{side}_corrected", "codes", f"timing codes of the {side} camera with one wrong bit"
        yield f"{side}_rejected", "codes", f"timing codes of the {side} camera with more than one wrong bit"
        yield f"{side}_dropped", "frames", f"frames of the {side} camera dropped by its input"
        yield f"{side}_overflow", "frames", f"frames of the {side} camera lost to a full FIFO; counted in dropped too"
        yield f"{side}_skipped", "frames", f"frames of the {side} camera for which no buffer was free"
        yield f"{side}_unpaired", "frames", f"frames of the {side} camera without a partner near enough in time"
    for role, chip in SETUPS.items():
        yield f"{role}_failures", "failures", f"failed set-ups of the {chip.name}, and failures after its set-up"
    for fifo, what in (("left_camera", "of the left camera"), ("right_camera", "of the right camera"), ("pair", "before the matcher"),
                       ("picture", "behind the matcher"), ("display", "of the display")):
        yield f"{fifo}_fill", "words", f"highest level of the FIFO {what}"


def _rig_registers(rig: RigConfig, width: int, height: int) -> Iterator[Register]:
    """Registers of the stages between the cameras and the matcher."""
    def setting(name: str, address: int, values: range, description: str, *, reset: int = 0, unit: str = "") -> Register:
        return Register(name, address, Kind.SETTING, values[-1], description, minimum=values[0], reset=reset, unit=unit)

    part = range(1 << SUM_BITS)
    yield Register("rectify", 0x60, Kind.SETTING, 1, "both pictures are rectified", reset=1, words=_OFF_ON)
    yield Register("balance", 0x61, Kind.SETTING, 2, "gain and offset of the right picture: those of the pairs before, or the fixed ones",
                   reset=1, words={0: "off", 1: "auto", 2: "fixed"})
    yield setting("fixed_gain", 0x62, GAINS, "gain of the right picture where it is fixed", reset=GAIN_ONE, unit="/ 256")
    yield setting("fixed_offset", 0x63, OFFSETS, "offset of the right picture where it is fixed", unit="/ 256 grey level")
    yield setting("row_offset", 0x64, ROW_OFFSETS, "line of the right camera that is line 0; takes effect with the maps", unit="lines",
                  reset=rig.row_offset)
    yield Register("map_side", 0x65, Kind.SETTING, 1, "camera whose map is written, at once", words={0: "left", 1: "right"})
    yield setting("map_address", 0x66, range(word_count(width, height)), "first word to be written")
    yield setting("map_low", 0x67, part, f"bits 0 to {SUM_BITS - 1} of a word of a map")
    yield setting("map_middle", 0x68, part, f"bits {SUM_BITS} to {2 * SUM_BITS - 1}")
    yield setting("map_high", 0x69, range(1 << (WORD_BITS - 2 * SUM_BITS)), f"bits {2 * SUM_BITS} to {WORD_BITS - 1}")
    for address, (name, description) in enumerate({
            "map_start": "the next word is written at map_address; the sum is 0",
            "map_next": "writes a word of the map that is not in use",
            "map_swap": "maps and row offset that were written are those in use from the next pair on"}.items(), 0x6A):
        yield Register(name, address, Kind.ACTION, 1, description, minimum=1)
    yield Register("map", 0x70, Kind.STATUS, max(MapsInUse), "maps in use",
                   words={which: which.name.lower().replace("_", " ") for which in MapsInUse})
    yield Register("map_swapping", 0x71, Kind.STATUS, 1, "maps wait for the next pair: nothing must be written", words=_NO_YES)
    yield Register("map_sum", 0x72, Kind.STATUS, part[-1], "sum of the words written since map_start")
    yield Register("map_fault", 0x73, Kind.STATUS, 1, "a map needed more lines than there are, since clear_counters", words=_NO_YES)
    for address, (name, description) in enumerate({
            "left_mean": "mean of the left picture of the last pair", "right_mean": "mean of the right one, before its balance",
            "left_deviation": "mean absolute deviation from the mean, left", "right_deviation": "the same, right"}.items(), 0x74):
        yield Register(name, address, Kind.STATUS, 16 * PIXEL_MAX, description, unit="/ 16 grey level")
    yield Register("gain", 0x78, Kind.STATUS, GAINS[-1], "gain of the right picture", unit="/ 256")
    yield Register("offset", 0x79, Kind.STATUS, OFFSETS[-1], "offset of the right picture", minimum=OFFSETS[0], unit="/ 256 grey level")
    yield Register("map_abandoned", 0x7A, Kind.COUNTER, 255, "pairs not rectified to their end because of their maps",
                   unit="pairs")


def register_map(config: MatcherConfig | None = None, height: int = 576, rig: RigConfig | None = None) -> RegisterMap:
    """The registers of the system around a matcher.

    Parameters
    ----------
    config : MatcherConfig
        Determines ``disparities``, ``width``, ``method`` and the settings; the default one if ``None``.
    height : int
        Lines of a picture.
    rig : RigConfig or None
        Of rectification and balance; without them if ``None``.
    """
    config = config or MatcherConfig()
    labels = config.labels
    methods = list(METHODS)
    digest = parameter_digest(config)

    def constant(name: str, address: int, value: int, description: str, unit: str = "", **words: Mapping[int, str]) -> Register:
        return Register(name, address, Kind.CONSTANT, value, description, reset=value, unit=unit, minimum=value, **words)

    def setting(name: str, address: int, reset: int, words: Mapping[int, str], description: str) -> Register:
        return Register(name, address, Kind.SETTING, max(words), description, reset=reset, words=words)

    return RegisterMap(tuple(sorted((
        constant("identity", 0x00, IDENTITY, "identifies this system", words={IDENTITY: "stereo graph cut"}),
        constant("version", 0x01, VERSION, "of this register map"),
        constant("disparities", 0x02, labels, "labels built in", "labels"),
        constant("width", 0x03, config.max_width, "longest line", "pixels"),
        constant("height", 0x04, height, "lines of a picture", "lines"),
        constant("lead", 0x06, config.lead, "columns by which the right picture is ahead: minimum may be as low as minus these", "columns"),
        constant("rectify_lines", 0x07, rig.lines if rig else 0, "that each rectifier holds; 0 without rectification and balance", "lines"),
        constant("method", 0x05, methods.index(config.method.name), "method built in", words=dict(enumerate(methods))),
        constant("release", 0x0A, release(), "of the project that the gateware was built from"),
        constant("parameters_high", 0x0B, digest >> 16, "digest of the method's parameters that are built in, upper half"),
        constant("parameters_low", 0x0C, digest & COUNT_MAX, "lower half"),
        *setting_registers(config),
        setting("show", 0x14, 0, {0: "disparity", 1: "left", 2: "both"}, "which picture the monitor shows"),
        setting("colour", 0x15, 0, {0: "grey", 1: "colour"}, "how disparities are shown"),
        setting("keep", 0x80, 0, _NO_YES, "whether the next pair is kept in memory, for block reads"),
        Register("kept", 0x81, Kind.STATUS, 1, "a pair is kept: block reads find both pictures and the disparities", words=_NO_YES),
        Register("clocks_high", 0x82, Kind.STATUS, (1 << CLOCK_BITS - 16) - 1, "clocks from the last pair's start to its disparities in "
                 "memory, upper half", unit="65536 clocks"),
        Register("clocks_low", 0x83, Kind.STATUS, COUNT_MAX, "lower half", unit="clocks"),
        setting("source", 0x84, 0, {0: "cameras", 1: "host"}, "whose pairs are matched and shown"),
        Register("start_pair", 0x85, Kind.ACTION, 1, "matches the host's pair once, if pair_whole and source are 1", minimum=1),
        Register("pair_whole", 0x86, Kind.STATUS, 1, "all lines of the host's pair are in memory", words=_NO_YES),
        setting("hold", 0x16, 0, {0: "live", 1: "frozen"}, "whether the picture on the monitor is frozen"),
        Register("clear_counters", 0x20, Kind.ACTION, 1, "sets all counters to 0", minimum=1),
        Register("restart_setup", 0x21, Kind.ACTION, 1, "repeats the set-up of the video chips", minimum=1),
        *(Register(name, 0x30 + n, Kind.STATUS, max(words), description, words=words)
          for n, (name, description, words) in enumerate(_setup_status())),
        *(Register(name, 0x38 + n, Kind.STATUS, 1, description, words=_NO_YES) for n, (name, description) in enumerate({
            "left_locked": "the decoder is locked to the left camera",
            "right_locked": "the decoder is locked to the right camera",
            "left_signal": "the left camera sends good frames",
            "right_signal": "the right camera sends good frames",
            "memory_ready": "the memory has been initialised",
            "matcher_error": "the matcher has received a ragged frame",
        }.items())),
        *(Register(name, 0x40 + n, Kind.COUNTER, COUNT_MAX, description, unit=unit)
          for n, (name, unit, description) in enumerate(_counters())),
        *(_rig_registers(rig, config.max_width, height) if rig else ()),
    ), key=lambda register: register.address)))


def access(registers: RegisterMap, values: Mapping[str, int], address: int, value: int | None = None) -> tuple[Status, int, dict[str, int]]:
    """What a read or a write does, whichever bus or line it is received from.

    Parameters
    ----------
    registers : RegisterMap
    values : mapping
        Register name to its value; the reset value if there is none.
    address : int
    value : int or None
        The value to be written; ``None`` for a read.

    Returns
    -------
    status : Status
        ``OK``, ``UNKNOWN_ADDRESS``, ``READ_ONLY`` or ``OUT_OF_RANGE``.
    value : int
        The value read or written; 0 unless the status is ``OK``.
    written : dict
        The value written, by the name of the setting or action; empty if nothing was written.
    """
    register = registers.at(address)
    if register is None:
        return Status.UNKNOWN_ADDRESS, 0, {}
    if value is None:
        return Status.OK, values.get(register.name, register.reset), {}
    if not register.writable:
        return Status.READ_ONLY, 0, {}
    if not register.minimum <= value <= register.maximum:
        return Status.OUT_OF_RANGE, 0, {}
    return Status.OK, value, {register.name: value}


def answer(registers: RegisterMap, values: Mapping[str, int], frame: bytes) -> tuple[Reply, dict[str, int]]:
    """The chip's reaction to a request; of a block read :func:`golden.host.blocks.block_answer` has the reply.

    Parameters
    ----------
    registers : RegisterMap
    values : mapping
        Register name to its value; the reset value if there is none.
    frame : bytes
        Six, the first one a sync byte.

    Returns
    -------
    Reply
    dict
        The value written, by the name of the setting or action; empty if nothing was written.
    """
    request = decode_request(frame)
    if request is None:
        return Reply(Status.BAD_SUM, frame[2]), {}
    if request.operation not in (Operation.READ, Operation.WRITE):
        return Reply(Status.UNKNOWN_OPERATION, request.address), {}
    register = registers.at(request.address)
    given = request.value if register is None else register.decode(request.value)
    status, value, written = access(registers, values, request.address, given if request.operation == Operation.WRITE else None)
    return Reply(status, request.address, register.encode(value) if register else 0), written
