"""Tables on the terminal whose figures are whole, however narrow it is."""

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table


__all__ = ["print_table", "whole"]


# More than any table needs.
_WIDE = 10_000


def whole(table: Table) -> Table:
    """The table, with figures that are neither wrapped nor cut, and words that are folded where they have no room.

    Figures are in columns that are justified to the right; a column that must not wrap is treated alike.
    """
    console = Console(width=_WIDE)
    for column in table.columns:
        if column.justify == "right" or column.no_wrap:
            column.no_wrap = True
            column.min_width = max(Measurement.get(console, console.options, cell).maximum for cell in (column.header, *column.cells))
        else:
            column.overflow = "fold"
    return table


def print_table(table: Table) -> None:
    """Print :func:`whole` of a table on stdout, wider than the terminal if the figures need it: a line that wraps can be read."""
    console = Console()
    wide = Console(width=_WIDE)
    needed = Measurement.get(wide, wide.options, whole(table)).minimum
    Console(width=max(console.width, needed)).print(table)
