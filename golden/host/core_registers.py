"""The register map of the core with a bus, and what an access of 32 bits to it does; docs/core_registers.md is its page."""

from collections.abc import Mapping

from ..config import METHODS, MatcherConfig
from ..video.frame_rule import Fault
from .protocol import Status
from .registers import COUNT_MAX, Kind, Register, RegisterMap, access, setting_registers


__all__ = ["CORE_IDENTITY", "CORE_VERSION", "WORD_BITS", "WORD_BYTES", "core_register_map", "word_access"]


#: Value of ``identity``: "SC" in ASCII.
CORE_IDENTITY = int.from_bytes(b"SC", "big")

#: Version of this map: incremented whenever a register is added, removed or changes its meaning.
CORE_VERSION = 1

#: Of a word on the bus; a register is a word.
WORD_BITS = 32
WORD_BYTES = WORD_BITS // 8

_NO_YES = {0: "no", 1: "yes"}


def core_register_map(config: MatcherConfig | None = None, height: int = 576, max_height: int = 4096) -> RegisterMap:
    """The registers of the core behind AXI4-Lite or Avalon-MM.

    Settings of the matcher have the addresses that they have in :func:`golden.host.registers.register_map`.

    Parameters
    ----------
    config : MatcherConfig
        Determines the constants and the settings; the default one if ``None``.
    height, max_height : int
        Lines of a frame: after reset, and the most that can be set.
    """
    config = config or MatcherConfig()
    methods = list(METHODS)

    def constant(name: str, address: int, value: int, description: str, unit: str = "", **words: Mapping[int, str]) -> Register:
        return Register(name, address, Kind.CONSTANT, value, description, minimum=value, reset=value, unit=unit, **words)

    def size(name: str, address: int, value: int, maximum: int, description: str, unit: str) -> Register:
        return Register(name, address, Kind.SETTING, maximum, description, minimum=1, reset=value, unit=unit)

    return RegisterMap(tuple(sorted((
        constant("identity", 0x00, CORE_IDENTITY, "identifies this core", words={CORE_IDENTITY: "stereo core"}),
        constant("version", 0x01, CORE_VERSION, "of this register map"),
        constant("disparities", 0x02, config.labels, "labels built in", "labels"),
        constant("max_width", 0x03, config.max_width, "longest line", "pixels"),
        constant("max_height", 0x04, max_height, "most lines of a frame", "lines"),
        constant("method", 0x05, methods.index(config.method.name), "method built in", words=dict(enumerate(methods))),
        constant("lead", 0x06, config.lead, "columns by which the right picture is ahead: minimum may be as low as minus these", "columns"),
        size("width", 0x08, config.max_width, config.max_width, "pixels of a line", "pixels"),
        size("height", 0x09, height, max_height, "lines of a frame", "lines"),
        *setting_registers(config),
        Register("clear", 0x20, Kind.ACTION, 1, "sets fault, matcher_error and all counters to 0", minimum=1),
        Register("apply", 0x21, Kind.ACTION, 1, "puts the settings into force, from the next frame on", minimum=1),
        Register("applying", 0x30, Kind.STATUS, 1, "settings wait for the next frame", words=_NO_YES),
        Register("fault", 0x31, Kind.STATUS, max(Fault), "how a frame first contradicted width and height",
                 words={fault.value: fault.text for fault in Fault}),
        Register("matcher_error", 0x32, Kind.STATUS, 1, "the matcher has received a ragged frame, and cut it", words=_NO_YES),
        Register("frames", 0x40, Kind.COUNTER, COUNT_MAX, "frames output", unit="frames"),
        Register("faults", 0x41, Kind.COUNTER, COUNT_MAX, "contradictions to width and height", unit="events"),
    ), key=lambda register: register.address)))


def word_access(registers: RegisterMap, values: Mapping[str, int], address: int, data: int | None = None,
                strobes: int = (1 << WORD_BYTES) - 1) -> tuple[Status, int, dict[str, int]]:
    """What a read or a write of a word does.

    Bytes without a strobe keep their value: that of a setting is merged with the bytes written, an action reads as 0. A write without any
    strobe changes nothing, and is answered as a read. Values below 0 are two's complement of 32 bits.

    Parameters
    ----------
    registers : RegisterMap
    values : mapping
        Register name to its value; the reset value if there is none.
    address : int
        Of the register: a byte address divided by four.
    data : int or None
        32 bits to be written; ``None`` for a read.
    strobes : int
        A bit for each byte, that of the least significant one lowest.

    Returns
    -------
    status : Status
    data : int
        32 bits read; 0 unless the status is ``OK``.
    written : dict
        The value written, by the name of the setting or action.

    Examples
    --------
    >>> registers = core_register_map()
    >>> word_access(registers, {"width": 0x123}, registers["width"].address, 0xAB, 0b0001)
    (<Status.OK: 0>, 427, {'width': 427})
    """
    status, value, written = access(registers, values, address)
    if data is not None and strobes and status is Status.OK:
        mask = sum(0xFF << 8 * byte for byte in range(WORD_BYTES) if strobes >> byte & 1)
        merged = (value & ~mask | data & mask) & (1 << WORD_BITS) - 1
        register = registers.at(address)
        assert register
        if register.signed and merged >> (WORD_BITS - 1):
            merged -= 1 << WORD_BITS
        status, value, written = access(registers, values, address, merged)
    return status, value & (1 << WORD_BITS) - 1, written
