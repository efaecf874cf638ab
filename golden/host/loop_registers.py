"""The register map of the matcher behind a serial line, without cameras: a pair is sent by the host; docs/loop_registers.md is its page."""

from collections.abc import Mapping

from ..config import METHODS, MatcherConfig
from .blocks import PLANES
from .build_id import parameter_digest, release
from .registers import COUNT_MAX, Kind, Register, RegisterMap, setting_registers


__all__ = ["LOOP_BAUD", "LOOP_IDENTITY", "LOOP_PLANES", "LOOP_VERSION", "PICTURE_PLANES", "loop_register_map", "result_bits",
           "result_bytes", "result_labels"]


#: Value of ``identity``: "SL" in ASCII.
LOOP_IDENTITY = int.from_bytes(b"SL", "big")

#: Version of this map and of the block transfers: incremented whenever one of them changes its meaning.
LOOP_VERSION = 1

#: Bits a second, unless a board says otherwise.
LOOP_BAUD = 3_000_000

#: Planes that have a byte a pixel, and all that can be read, in the order of their numbers. ``result`` is the matcher's whole word: label,
#: and what else the method gives.
PICTURE_PLANES = PLANES
LOOP_PLANES = (*PLANES, "result")

_NO_YES = {0: "no", 1: "yes"}

def result_labels(config: MatcherConfig) -> int:
    """Values of the lowest field of a result: labels in units of ``1 / config.method.disparity_scale`` pixel."""
    return config.labels * config.method.disparity_scale


def result_bits(config: MatcherConfig) -> Mapping[str, int]:
    """Fields of a stored result and their bits, the first one lowest.

    They are those of :attr:`golden.config.MatcherConfig.result_fields`, but that ``disparity`` is stored as the label: less the least
    disparity of its picture, and so without a sign.

    Examples
    --------
    >>> from golden.config import FUSED_1
    >>> result_bits(MatcherConfig(64, 320, minimum=-8, method=FUSED_1))
    {'disparity': 6, 'passed': 1, 'confidence': 4}
    """
    return {**config.result_fields, "disparity": (result_labels(config) - 1).bit_length()}


def result_bytes(config: MatcherConfig) -> int:
    """Bytes of a pixel in the plane ``result``, the least significant one first."""
    return -(-sum(result_bits(config).values()) // 8)


def loop_register_map(config: MatcherConfig | None = None, height: int = 240) -> RegisterMap:
    """The registers of the matcher behind a serial line.

    What is in :func:`golden.host.registers.register_map`, too, has the same name and address.

    Parameters
    ----------
    config : MatcherConfig
        Determines constants and settings; the default one if ``None``.
    height : int
        Most lines of a picture.
    """
    config = config or MatcherConfig()
    methods = list(METHODS)
    digest = parameter_digest(config)

    def constant(name: str, address: int, value: int, description: str, unit: str = "", **words: Mapping[int, str]) -> Register:
        return Register(name, address, Kind.CONSTANT, value, description, minimum=value, reset=value, unit=unit, **words)

    def size(name: str, address: int, greatest: int, description: str, unit: str) -> Register:
        return Register(name, address, Kind.SETTING, greatest, description, minimum=1, reset=greatest, unit=unit)

    def status(name: str, address: int, greatest: int, description: str, unit: str = "") -> Register:
        return Register(name, address, Kind.STATUS, greatest, description, unit=unit, words={} if unit else _NO_YES)

    return RegisterMap(tuple(sorted((
        constant("identity", 0x00, LOOP_IDENTITY, "identifies this system", words={LOOP_IDENTITY: "stereo loop"}),
        constant("version", 0x01, LOOP_VERSION, "of this register map"),
        constant("disparities", 0x02, config.labels, "labels built in", "labels"),
        constant("width", 0x03, config.max_width, "longest line", "pixels"),
        constant("height", 0x04, height, "most lines of a picture", "lines"),
        constant("method", 0x05, methods.index(config.method.name), "method built in", words=dict(enumerate(methods))),
        constant("lead", 0x06, config.lead, "columns by which the right picture is ahead: minimum may be as low as minus these", "columns"),
        constant("rectify_lines", 0x07, 0, "there is no rectification", "lines"),
        size("picture_width", 0x08, config.max_width, "pixels of a line of the pair", "pixels"),
        size("picture_height", 0x09, height, "lines of the pair", "lines"),
        constant("release", 0x0A, release(), "of the project that the gateware was built from"),
        constant("parameters_high", 0x0B, digest >> 16, "digest of the method's parameters that are built in, upper half"),
        constant("parameters_low", 0x0C, digest & COUNT_MAX, "lower half"),
        constant("result_bytes", 0x0D, result_bytes(config), "of a pixel in the plane result", "bytes"),
        *setting_registers(config),
        Register("clear_counters", 0x20, Kind.ACTION, 1, "sets counters and matcher_error to 0", minimum=1),
        Register("start", 0x21, Kind.ACTION, 1, "matches the pair; without effect while busy or keep is 1", minimum=1),
        status("busy", 0x30, 1, "a pair is being matched"),
        status("matcher_error", 0x3D, 1, "the matcher has received a ragged frame"),
        Register("pairs", 0x41, Kind.COUNTER, COUNT_MAX, "pairs matched", unit="pairs"),
        Register("uart_errors", 0x45, Kind.COUNTER, COUNT_MAX, "framing errors, lost bytes, bad sums and CRCs, time-outs and stray bytes "
                 "of this line", unit="events"),
        Register("keep", 0x80, Kind.SETTING, 1, "refuses block writes and start, so that the pair stays as it is", words=_NO_YES),
        status("kept", 0x81, 1, "a pair has been matched: block reads find both pictures and the disparities"),
        status("clocks_high", 0x82, COUNT_MAX, "clocks from start to the last disparity of the last pair, upper half", "65536 clocks"),
        status("clocks_low", 0x83, COUNT_MAX, "lower half", "clocks"),
    ), key=lambda register: register.address)))
