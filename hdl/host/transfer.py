"""Many blocks over a line: the next ones are sent, or requested, before the replies to those before are received.

A USB adapter delivers a reply only after some milliseconds: waiting for each would take longer than the line itself. What is lost or
garbled is repeated from there on, after a pause, a block at a time at first.
"""

from collections.abc import Callable, Sequence

from golden.errors import UserError
from golden.host.loop_registers import LOOP_PLANES
from golden.host.protocol import CRC_BYTES, FRAME_BYTES, QUIET_SECONDS, Operation, Request, Status, encode_block

from .chip import Chip


__all__ = ["get_lines", "put_lines", "seconds_of_pair"]


# Requests of block reads that wait in the chip.
_REQUESTS_AHEAD = 8

# Blocks whose replies, six bytes each, wait in the computer.
_REPLIES_AHEAD = 64

# What is on its way takes the line so long, seconds: twice what an adapter waits. What is lost is repeated once the rest has been ignored,
# and that must be well before the time-out of a reply.
_AHEAD_SECONDS = 0.03


def _transfer(chip: Chip, requests: Sequence[Request], most: int, seconds: float, send: Callable[[int], None],
              end: Callable[[int], bool], report: Callable[[int, int], None]) -> None:
    """Send all requests, up to ``most`` ahead, each of which takes the line so many ``seconds``; ``end`` receives what follows a good
    reply, and tells whether it is good.
    """
    done = sent = 0
    ahead = most
    problems: list[str] = []
    while done < len(requests):
        while sent < min(len(requests), done + ahead):
            send(sent)
            sent += 1
        reply, problem = chip.answer(requests[done])
        if reply and reply.status is Status.OK:
            problem = "" if end(done) else "garbled block"
        elif reply and reply.status is not Status.BAD_SUM:
            problem = reply.status.name.lower().replace("_", " ")
        if not problem:
            done += 1
            ahead = min(2 * ahead, most)
            problems.clear()
            report(done, len(requests))
            continue
        problems.append(problem)
        # The chip ignores what is on its way, until a pause.
        chip.drop(QUIET_SECONDS + (sent - done) * seconds)
        if len(problems) == chip.ATTEMPTS:
            if reply and reply.status is not Status.BAD_SUM and len(set(problems)) == 1:
                request = requests[done]
                raise UserError(f"the board refuses line {request.value} of the {LOOP_PLANES[request.address]} picture: {problem}; another "
                                "program may be using it: end that, and try again")
            raise chip.failure(problems)
        chip.repeated += 1
        sent, ahead = done, 1


def _ahead(chip: Chip, block_bytes: int, baud: int, most: int) -> int:
    """Blocks on their way: at least two, but one to a system with cameras, where nothing waits while a reply is sent."""
    if chip.system.cameras:
        return 1
    return max(2, min(most, min(chip.AHEAD_BYTES, round(baud / 10 * _AHEAD_SECONDS)) // block_bytes))


def put_lines(chip: Chip, lines: Sequence[tuple[int, int, bytes]], baud: int, report: Callable[[int, int], None]) -> None:
    """Send lines of pictures, each with the number of its plane and its own.

    :class:`UserError` if one is refused, or not received well in several attempts. Each line that was sent is in its store, or as before.

    Parameters
    ----------
    chip : Chip
    lines : sequence of (int, int, bytes)
    baud : int
        Of the line: determines how much is sent ahead.
    report : callable
        Is given the number of lines sent, and that of all.
    """
    if not lines:
        return
    requests = [Request(Operation.BLOCK_WRITE, plane, line) for plane, line, _ in lines]
    blocks = [encode_block(*line) for line in lines]
    size = FRAME_BYTES + len(blocks[0])
    most = _ahead(chip, size, baud, _REPLIES_AHEAD)
    _transfer(chip, requests, most, 10 * size / baud, lambda number: chip.send(requests[number], blocks[number]), lambda number: True,
              report)


def get_lines(chip: Chip, plane: int, count: int, line_bytes: int, baud: int, report: Callable[[int, int], None]) -> list[bytes]:
    """The first ``count`` lines of a plane, of so many bytes each; :class:`UserError` as of :func:`put_lines`."""
    requests = [Request(Operation.BLOCK, plane, line) for line in range(count)]
    lines: list[bytes] = []

    def receive(number: int) -> bool:
        data = chip.data(requests[number], line_bytes)
        lines.extend([] if data is None else [data])
        return data is not None

    most = _ahead(chip, FRAME_BYTES + line_bytes + CRC_BYTES, baud, _REQUESTS_AHEAD)
    _transfer(chip, requests, most, 10 * FRAME_BYTES / baud, lambda number: chip.send(requests[number]), receive, report)
    return lines


def seconds_of_pair(width: int, height: int, result_bytes: int, baud: int) -> float:
    """Time on the line of a pair and its results, without the matcher, and without what the computer waits.

    Examples
    --------
    >>> round(1 / seconds_of_pair(320, 240, 1, 3_000_000), 2)
    1.27
    """
    sent = 2 * height * (FRAME_BYTES + width + CRC_BYTES)
    received = height * (FRAME_BYTES + width * result_bytes + CRC_BYTES)
    return 10 * (sent + received + 2 * FRAME_BYTES) / baud
