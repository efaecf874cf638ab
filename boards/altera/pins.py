"""Tables of a board's pins: a line for each, with its signal, its ball, and what else is known of it."""

import csv
from importlib import resources

from amaranth.build import Connector


__all__ = ["PinTable"]


class PinTable:
    """The table ``pins.csv`` of a board.

    Parameters
    ----------
    package : str
        The board's, whose folder has the table.

    Attributes
    ----------
    rows : list of dict
        Column to text, for each pin.
    """
    def __init__(self, package: str):
        with resources.files(package).joinpath("pins.csv").open(encoding="utf-8") as file:
            self.rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self._of_signal = {row["signal"]: row["ball"] for row in self.rows}

    def balls(self, *signals: str) -> str:
        """Balls of signals, as a resource's pins have them."""
        return " ".join(self._of_signal[signal] for signal in signals)

    def bus(self, signal: str, width: int) -> str:
        """Balls of ``signal[0]`` and so on, the lowest bit first."""
        return self.balls(*(f"{signal}[{bit}]" for bit in range(width)))

    def hsmc(self, number: int, letter: str = "") -> Connector:
        """An HSMC connector: the rows whose column ``hsmc`` has a pin of it, behind the connector's letter if there are several."""
        return Connector("hsmc", number, {pin.removeprefix(letter): row["ball"] for row in self.rows
                                          if (pin := row["hsmc"]) and pin.startswith(letter)})
