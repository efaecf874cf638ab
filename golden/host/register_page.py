"""`python -m golden.host.register_page --output docs/registers.md`: the page of the register map and of its protocol; with `--core` that
of the core with a bus, with `--loop` that of the matcher behind a serial line.
"""

import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from ..cli import Parser
from ..config import METHODS, RECURSIVE_2, Fused, MatcherConfig
from ..errors import run_cli
from ..files import atomic, check_output
from ..pages import digest, origin
from ..rig.config import RigConfig
from ..video.frame_rule import Fault
from ..video.memory_map import MemoryMap
from .blocks import PLANES, SENT_PLANES, line_bytes
from .core_registers import WORD_BITS, WORD_BYTES, core_register_map
from .loop_registers import LOOP_BAUD, LOOP_PLANES, loop_register_map, result_bits
from .protocol import (
    BAUD,
    CRC_BYTES,
    FRAME_BYTES,
    FRAME_SECONDS,
    QUIET_SECONDS,
    REPLY_SYNC,
    REQUEST_SYNC,
    Operation,
    Reply,
    Request,
    Status,
    block_bits,
    encode_reply,
    encode_request,
)
from .registers import COUNT_MAX, Kind, Register, RegisterMap, register_map


__all__ = ["core_page", "loop_page", "main", "page"]


_STATUS_TEXT = {
    Status.OK: "done",
    Status.BAD_SUM: "the request's bytes do not add up to 0: it had no effect, repeat it",
    Status.UNKNOWN_ADDRESS: "no register, or no plane, has this address",
    Status.READ_ONLY: "the register cannot be written",
    Status.OUT_OF_RANGE: "the value is not within the register's limits, and it is unchanged; or there is no such line",
    Status.UNKNOWN_OPERATION: "neither a read, a write, a block read nor a block write",
    Status.NOT_KEPT: "a block read, and `kept` is 0: set `keep` and wait",
    Status.BUSY: "a block write while pairs are the cameras', `keep` is 1, the pair is being read, or a line before is not stored",
}


def _paragraph(*sentences: str) -> str:
    return textwrap.fill(" ".join(sentences), 140)


def _protocol() -> list[str]:
    """Markdown that describes the protocol byte by byte."""
    example = Request(Operation.WRITE, 0x10, 15)
    return [
        _paragraph(
            f"RS-232, {BAUD} baud, eight data bits, no parity, one stop bit.",
            f"The host sends a request and the chip a reply, of {FRAME_BYTES} bytes each; a block follows the reply to a block",
            "read, and the request of a block write.",
            "One request at a time: the next one is sent after the reply."),
        "",
        "| byte | request | reply |",
        "|---|---|---|",
        f"| 0 | sync, `0x{REQUEST_SYNC:02X}` | sync, `0x{REPLY_SYNC:02X}` |",
        f"| 1 | operation: `0x{Operation.READ:02X}` read, `0x{Operation.WRITE:02X}` write, `0x{Operation.BLOCK:02X}` block read, "
        f"`0x{Operation.BLOCK_WRITE:02X}` block write | status, see below |",
        "| 2 | address; of a block, the plane | address, as it was received |",
        "| 3 | value, upper byte; ignored in a read; of a block, the line | value, upper byte; 0 unless the status is 0 |",
        "| 4 | value, lower byte | value, lower byte |",
        "| 5 | sum: makes all six bytes add up to 0 modulo 256 | sum, likewise |",
        "",
        "| status | meaning |",
        "|---|---|",
        *(f"| {status.value} | {text} |" for status, text in _STATUS_TEXT.items()),
        "",
        "The value of a reply is the value read, all bits of the same moment, or the value that a write stored.",
        "",
        _paragraph(
            f"For example, `{encode_request(example).hex(' ')}` writes {example.value} to address `0x{example.address:02X}`, and",
            f"`{encode_reply(Reply(Status.OK, example.address, example.value)).hex(' ')}` confirms it."),
        "",
        *_block(),
        *_block_write(),
        "",
        "### Noise",
        "",
        _paragraph(
            "The sum detects every error within one byte.",
            "Errors in several bytes that change the address or the value are detected by the host,",
            "which compares the reply with its request."),
        "",
        _paragraph(
            "A request whose next byte is not received within",
            f"{1000 * FRAME_SECONDS:g} ms is dropped, and so is one with a byte without a stop bit. After that, after a byte that begins",
            "no request, after status 1 or 5, and after a block write that was refused, the chip ignores everything until the line has",
            "been silent for that long: so no pixel is ever taken for a request.",
            "Each such event but status 5 and a refusal is counted in `uart_errors`, as is each byte that is lost.",
            f"After any noise, a request sent after a pause of {1000 * QUIET_SECONDS:g} ms has a reply:",
            "the pause covers the time-out, and a reply to noise. At other rates the time-out is as many bits.",
            "While a reply or a block is sent, or a line is stored, one byte of the host waits, and further ones are lost and counted:",
            "they are no request. A host that does not want the rest of a block waits for its end."),
        "",
        "After no reply, or status 1, a host pauses for that long and repeats the request; a write may be repeated. But what the chip did",
        "before its reply was lost, it does again: `map_sum` tells whether `map_next` wrote a word twice, and after a second `map_swap`",
        "the maps are loaded again.",
    ]


#: Rates at which times are stated.
_BAUDS = (BAUD, 921_600, 3_000_000)


def _block() -> list[str]:
    """Markdown that describes a block read byte by byte."""
    memory_map = MemoryMap()
    width, height = memory_map.width, memory_map.height
    length = line_bytes(width)
    bits = block_bits(length)
    example = Request(Operation.BLOCK, 2, 300)
    return [
        "### Block read",
        "",
        _paragraph(
            "A block read returns a line of a picture that is kept in memory. Write 1 to `keep`: the next pair that starts is kept,",
            "as the cameras sent it, with its disparities. Once `kept` is 1, all lines are of that one pair, until `keep` is 0;",
            "the system runs on meanwhile. The address is the plane,",
            ", ".join(f"{number} {name}" for number, name in enumerate(PLANES)) + ", and the value is the line, from 0.",
            "Pixels of the disparities are what the monitor shows: whole disparities less the least one."),
        "",
        "After the six bytes of the reply, and only if its status is 0, the chip sends:",
        "",
        "| byte | block |",
        "|---|---|",
        "| 0 .. `n - 1` | the line's pixels from left to right, a byte each; `n` is `width` rounded up to a multiple of 16 |",
        "| `n` | CRC, upper byte |",
        "| `n + 1` | CRC, lower byte |",
        "",
        _paragraph(
            "The CRC is that of CCITT, polynomial `0x1021`, from `0xFFFF` on, most significant bits first, over the plane,",
            "the line's upper byte, its lower byte, and the `n` bytes.",
            "If the pair was let go before the last of them was sent, the CRC is inverted,",
            "and so is wrong. Bytes from `width` on may have any value. Statuses are looked for in the order 2, 4, 6."),
        "",
        _paragraph(
            f"For example, `{encode_request(example).hex(' ')}` reads line {example.value} of the disparities, and",
            f"`{encode_reply(Reply(Status.OK, example.address, example.value)).hex(' ')}` and {length} + {CRC_BYTES} bytes are the answer.",
            f"With {width} pixels, request, reply and block take {bits} bits on the line; all {height} lines of a picture take",
            ", ".join(f"{height * bits / baud:.1f} s at {baud:,} baud" for baud in _BAUDS)
            + ", and what the host waits between a block and its next request."),
    ]


def _block_write() -> list[str]:
    """Markdown about block writes."""
    example = Request(Operation.BLOCK_WRITE, 1, 300)
    return [
        "",
        "### Block write",
        "",
        _paragraph(
            "A block write sends a line of a pair of the host's, which is matched and shown in place of the cameras' pairs. Write 1 to",
            "`source`: no pair of the cameras starts from then on, and what they send is written over and over. The pair has buffers of",
            "its own. The address is the plane, " + ", ".join(f"{number} {name}" for number, name in enumerate(SENT_PLANES)) + ", and the",
            "value is the line, from 0. The six bytes of the request are followed by a block as that of a block read,",
            "whose bytes from `width`",
            "on may have any value; then the reply is sent: status 0 if the line is in memory, 1 if the CRC is wrong or a byte was not",
            f"received in time, and nothing has changed. For example, `{encode_request(example).hex(' ')}` and the",
            f"block write line {example.value}",
            f"of the right picture, and `{encode_reply(Reply(Status.OK, example.address, example.value)).hex(' ')}` confirms it."),
        "",
        _paragraph(
            "Lines are sent in their order, those of the left picture first. Any line that was stored may be sent again, as after a reply",
            "that was lost, and all lines after it must then be, too; one that is ahead is refused. `pair_whole` is 1 once the last line",
            "is stored, and 0 from the next pair's first one on. `start_pair` has no effect before: a pair that is broken off is never",
            "shown. It may be written again, to match the same pair with other settings, or to keep it. Write 0 to",
            "`source`, and the cameras'",
            "next pair is matched. A block write takes as many bits as a block read."),
    ]


_SECTIONS = {
    Kind.CONSTANT: ("Constants", "Read-only; here those of a matcher of the default size with the method `fused`."),
    Kind.SETTING: ("Settings", "Read and written; a new value takes effect at a frame's start, those of `keep`, `source`, and of "
                   "`map_side` to `map_high`, at once. "
                   "A matcher that was built with a negative `minimum` takes any value from there on, as a two's complement of 16 bits. "
                   + " ".join(
        f"A matcher with the method `{name}` has {', '.join(f'`{setting}`' for setting in MatcherConfig(method=method()).settings)}."
        for name, method in METHODS.items())),
    Kind.ACTION: ("Actions", "Write 1; they read as 0."),
    Kind.STATUS: ("Status", "Read-only; the present state."),
    Kind.COUNTER: ("Counters", f"Read-only; since reset or the last `clear_counters`. They hold their greatest value, {COUNT_MAX}."),
}


def _further(registers: RegisterMap, map_of: Callable[[MatcherConfig], RegisterMap]) -> list[str]:
    """Settings that other methods have, with the parameters that have them."""
    methods = {name: method() for name, method in METHODS.items()} | {"*recursive-2*": RECURSIVE_2}
    lines, seen = [], {register.name for register in registers}
    for about, method in methods.items():
        for register in map_of(MatcherConfig(method=method)).of(Kind.SETTING):
            if register.name not in seen:
                lines.append(f"{_row(register)} {about} |")
                seen.add(register.name)
    return ["", "### Settings of other methods", "", "| address | name | bits | values | reset | unit | meaning | method |",
            "|---|---|---:|---|---:|---|---|---|", *lines] if lines else []


def _row(register: Register) -> str:
    """A register as a row of its table."""
    return (f"| `0x{register.address:02X}` | `{register.name}` | {register.width} | {register.limits} | {register.reset} "
            f"| {register.unit or '-'} | {register.description} |")


def _tables(registers: RegisterMap, sections: Mapping[Kind, tuple[str, str]],
            map_of: Callable[[MatcherConfig], RegisterMap]) -> list[str]:
    """The registers by kind, and long lists of values."""
    lines = []
    for kind, (title, about) in sections.items():
        lines += ["", f"## {title}", "", _paragraph(about), "",
                  "| address | name | bits | values | reset | unit | meaning |", "|---|---|---:|---|---:|---|---|"]
        lines += [*map(_row, registers.of(kind)), *(_further(registers, map_of) if kind is Kind.SETTING else [])]
    for register in registers:
        if register.words and len(register.words) > 1 and not all(word in register.limits for word in register.words.values()):
            lines += ["", f"### Values of `{register.name}`", "", "| value | meaning |", "|---:|---|"]
            lines += [f"| {value} | {word} |" for value, word in register.words.items()]
    return lines


def page(registers: RegisterMap) -> str:
    """The page of the map and of the protocol, in Markdown."""
    lines = ["## Protocol", "", *_protocol(), *_tables(registers, _SECTIONS, register_map)]
    head = ["# Registers", "", origin("python -m golden.host.register_page --output docs/registers.md", digest(lines)), ""]
    return "\n".join(head + lines) + "\n"


def core_page(registers: RegisterMap) -> str:
    """The page of the registers of the core with a bus, in Markdown."""
    lines = [
        _paragraph(
            "The core of `python -m hdl.build --core --interface axi` has these registers behind AXI4-Lite, that of `--interface avalon`",
            f"behind Avalon-MM. A register is a word of {WORD_BITS} bits. Its address here counts words, as Avalon-MM does;",
            f"AXI4-Lite has byte addresses, {WORD_BYTES} times as great, of which the two lowest bits are ignored.",
            "The build's `manifest.json` has the same registers as data, with their byte offsets.",
            "Settings of the matcher have the addresses that they have on the board ([registers.md](registers.md))."),
        "",
        "## Accesses",
        "",
        "| access | AXI4-Lite, Avalon-MM |",
        "|---|---|",
        "| of a register that there is | `OKAY` |",
        "| of an address without a register | `DECERR`, and a read gives 0 |",
        "| a write to what is read-only, or of a value out of range | `SLVERR`, and nothing changes |",
        "",
        _paragraph(
            "Values below 0 are two's complement of 32 bits. Bytes without a strobe keep their value; the limits hold for the whole value.",
            "A write without any strobe changes nothing. Both channels of AXI4-Lite work at the same time: address and data of a write are",
            "accepted in any order, and neither reads nor writes wait until the response to the other is accepted.",
            "On Avalon-MM `response` tells with `readdatavalid` and with `writeresponsevalid`; a host may ignore it."),
        "",
        "## Frames",
        "",
        _paragraph(
            "AXI4-Stream marks the start of a frame and the end of each line, Avalon-ST the start and the end of a frame:",
            "`height`, or `width`, tell the rest. A frame whose marks contradict `width` and `height` sets `fault` and is counted in",
            "`faults`. It is cut after the faulty line, which is padded with its last pixel if it is short; a frame with a short first",
            "line is dropped. The rest is dropped up to the next start of a frame, and that frame is exact.",
            f"{len(Fault) - 1} kinds are told apart. Pixels before the first start of a frame after reset are dropped, and are no fault."),
        "",
        _paragraph(
            "Settings are put into force by `apply`, all together, with the next frame whose first pixel is not offered yet.",
            "The input waits between two frames until the frames before have begun to be output; `applying` is 1 until then."),
        *_tables(registers, {
            Kind.CONSTANT: ("Constants", "Read-only; here those of a matcher of the default size with the method `fused`."),
            Kind.SETTING: ("Settings", "Read and written; `apply` puts them into force. A core that was built with a negative `minimum` "
                           "takes any value from there on."),
            Kind.ACTION: ("Actions", "Write 1; they read as 0."),
            Kind.STATUS: ("Status", "Read-only; the present state, or since reset or the last `clear`."),
            Kind.COUNTER: ("Counters", f"Read-only; since reset or the last `clear`. They hold their greatest value, {COUNT_MAX}."),
        }, core_register_map),
    ]
    head = ["# Registers of the core", "",
            origin("python -m golden.host.register_page --core --output docs/core_registers.md", digest(lines)), ""]
    return "\n".join(head + lines) + "\n"


#: Of which the page of the matcher behind a serial line tells.
LOOP_CONFIG = MatcherConfig(64, 320, method=Fused())


def loop_page(registers: RegisterMap) -> str:
    """The page of the registers of the matcher behind a serial line, and of its blocks, in Markdown."""
    width = LOOP_CONFIG.max_width
    example = Request(Operation.BLOCK_WRITE, 1, 300)
    fields = ", ".join(f"`{name}` {bits}" for name, bits in result_bits(LOOP_CONFIG).items())
    lines = [
        _paragraph(
            "The matcher of `hdl/loop/` has these registers behind its serial line, "
            f"{LOOP_BAUD:,} baud unless its board says otherwise, eight data bits, no parity, one stop bit.",
            "Requests and replies are those of [registers.md](registers.md); registers that are there, too, have the same name and",
            "address.",
            "[loop.md](loop.md) tells how a host uses them."),
        "",
        "## Blocks",
        "",
        _paragraph(
            f"A block write, operation `0x{Operation.BLOCK_WRITE:02X}`, sends a line of a picture: the address is the plane,",
            ", ".join(f"{number} {name}" for number, name in enumerate(SENT_PLANES)) + ", and the value is the line, from 0.",
            "The request is followed by `picture_width` bytes, the pixels from left to right, and two of the CRC, the upper byte first.",
            "The CRC is that of a block read, over plane, line and these bytes. Then the reply is sent: status 0 if the line is stored,",
            "1 if the CRC is wrong or the block was cut short, and nothing has changed. Status 2, 4 or 7 follows the request, and",
            "refuses it.",
            f"For example, `{encode_request(example).hex(' ')}` and {width} + {CRC_BYTES} bytes write line {example.value} of the right",
            f"picture, and `{encode_reply(Reply(Status.OK, example.address, example.value)).hex(' ')}` confirms it."),
        "",
        _paragraph(
            f"A block read, operation `0x{Operation.BLOCK:02X}`, has the planes",
            ", ".join(f"{number} {name}" for number, name in enumerate(LOOP_PLANES)) + ".",
            "The first three have a byte a pixel, `picture_width` of them; those of the disparities are whole labels.",
            "A pixel of the plane result has `result_bytes` bytes, the least significant one first: fields of the matcher's output,",
            f"the first one lowest, here with their bits: {fields}.",
            "`disparity` is a label, in units of 1/8 pixel with sub-pixel disparities: add `minimum`.",
            "Status 6 refuses a read while `kept` is 0."),
        "",
        "| status | meaning |",
        "|---|---|",
        *(f"| {status.value} | {text} |" for status, text in _STATUS_TEXT.items() if status < Status.NOT_KEPT),
        f"| {Status.NOT_KEPT.value} | a block read, and no pair has been matched |",
        f"| {Status.BUSY.value} | a block write while a pair is being matched, or while `keep` is 1 |",
        "",
        _paragraph(
            "A host need not wait for replies: block writes may follow each other, and up to 10 requests may wait while a block is sent.",
            "Replies have the order of the requests. So that no pixel is ever taken for a request, the chip ignores everything after",
            "status 1, 5, or a refused block write, and after bytes that begin no request, until the line has been silent for",
            f"{1000 * FRAME_SECONDS:g} ms. A host that misses a good reply waits for {1000 * QUIET_SECONDS:g} ms and repeats from",
            "there on."),
        *_tables(registers, {
            Kind.CONSTANT: ("Constants", "Read-only; here those of 320x240 pixels and 64 labels with the method `fused`."),
            Kind.SETTING: ("Settings", "Read and written; those of the matcher take effect with `start`, the others at once. "
                           "A matcher that was built with a negative `minimum` takes any value from there on."),
            Kind.ACTION: ("Actions", "Write 1; they read as 0."),
            Kind.STATUS: ("Status", "Read-only; the present state, or that of the last pair."),
            Kind.COUNTER: ("Counters", "Read-only; since reset or the last `clear_counters`. They hold their greatest value, "
                           f"{COUNT_MAX}."),
        }, loop_register_map),
    ]
    head = ["# Registers of the matcher behind a serial line", "",
            origin("python -m golden.host.register_page --loop --output docs/loop_registers.md", digest(lines)), ""]
    return "\n".join(head + lines) + "\n"


def _run(argv: Sequence[str] | None) -> None:
    parser = Parser(prog="golden.host.register_page", description="Write the page of the register map and its protocol.")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE", help="Markdown, .md")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--core", action="store_true", help="of the core with a bus, not of the board")
    which.add_argument("--loop", action="store_true", help="of the matcher behind a serial line, not of the board with cameras")
    options = parser.parse_args(argv)
    path = check_output(options.output, [".md"])
    config = MatcherConfig(method=Fused())
    if options.core:
        text = core_page(core_register_map(config))
    elif options.loop:
        text = loop_page(loop_register_map(LOOP_CONFIG))
    else:
        text = page(register_map(config, rig=RigConfig()))
    with atomic(path) as file:
        file.write(text.encode())


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(_run, argv, "golden.host.register_page")


if __name__ == "__main__":
    sys.exit(main())
