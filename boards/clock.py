"""The clock that is chosen for a board's matcher, where a PLL makes it."""

from collections.abc import Callable, Iterable

from golden.errors import UserError


__all__ = ["chosen_clock"]


def chosen_clock(board: str, input_hz: int, clock_mhz: float, makes: Callable[[int], object], offered: Iterable[int]) -> int:
    """``clock_mhz`` in Hz, if the board's PLL makes it without error.

    Parameters
    ----------
    board : str
        Its name.
    input_hz : int
        Of the oscillator.
    clock_mhz : float
    makes : callable
        Whether the PLL makes a clock, in Hz.
    offered : iterable of int
        Clocks that it makes, in Hz.

    Raises
    ------
    UserError
        If it does not; the sentence names the nearest one of those that are offered.

    Examples
    --------
    >>> chosen_clock("b", 50_000_000, 62.5, lambda hz: True, [])
    62500000
    """
    hz = round(clock_mhz * 1e6)
    if makes(hz):
        return hz
    nearest = min(offered, key=lambda clock: abs(clock - hz))
    raise UserError(f"the PLL of the board {board} does not make {clock_mhz:g} MHz of {input_hz / 1e6:g} MHz; "
                    f"choose --clock {nearest / 1e6:g}")
