"""Why what no bench reaches is no loss: the list that :mod:`sim.verify.coverage_holes` checks."""

from typing import NamedTuple


__all__ = ["EXPLAINED", "Explained"]


class Explained(NamedTuple):
    """Explains holes whose kind, class, text and design match these regular expressions as a whole."""
    kind: str
    origin: str
    text: str
    reason: str
    design: str = ".*"


_ANY = ".*"

EXPLAINED = (
    Explained("line", r"hdl\.matcher\.sequential\.engine\.SequentialEngine", "default: 1'h0",
              "the choice has all three states of the machine: the fourth code of its two bits does not occur"),
    Explained("(branch|toggle)", r"hdl\.matcher\.streaming\.label_array\.UpCell", _ANY,
              "near the last label the cones have no further vertex: whether there is one is a constant of these cells"),
    Explained("toggle", r"hdl\.parts\.queue\._MarkedFIFO", r"w_rdy:.*",
              "credits admit no more to the engine than its queues have room for: they are never full"),
)
