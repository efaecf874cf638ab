"""What the thesis prints, to be set next to our measurements and never mixed with them."""

from dataclasses import dataclass


__all__ = ["OPTIMUM", "TABLE_1", "TABLE_1_PAIR", "TABLE_2", "TABLE_3", "TSUKUBA", "Published"]


#: The weights u1, u2, u3 that section 4.1 found best.
OPTIMUM = (15, 10, 5)

#: Bad pixels of the proposed method on Tsukuba, percent, Table 1.
TSUKUBA = {"nonocc": 5.09, "all": 7.08, "disc": 18.2}


@dataclass(frozen=True)
class Published:
    """A row of Table 1: bad pixels of :data:`TABLE_1_PAIR`, percent, and the time of the computation.

    Parameters
    ----------
    figures : dict of str to float
        By the name of the mask.
    seconds : float
    tool : str
        What computed it: CPU or FPGA.
    """
    figures: dict[str, float]
    seconds: float
    tool: str


TABLE_1_PAIR = "tsukuba"

TABLE_1 = {
    "Dynamic Programming": Published({"nonocc": 4.12, "all": 5.04, "disc": 12.0}, 1.0, "CPU"),
    "Graph Cut Method": Published({"nonocc": 1.19, "all": 2.01, "disc": 6.24}, 69.8, "CPU"),
    "SSD+min filter": Published({"nonocc": 5.08, "all": 7.22, "disc": 24.1}, 1.1, "CPU"),
    "Proposed Method": Published(TSUKUBA, 0.040, "FPGA"),
}

#: Used of the EP3C120, and available there.
TABLE_2 = {"logic elements": (66_123, 119_088), "memory bits": (1_901_632, 3_981_312), "multipliers 9x9": (480, 576)}

#: Hardware, width and height in pixels, disparities, method, frames a second.
TABLE_3 = (
    ("4 x Virtex-2 [26]", 256, 360, 20, "local weighted phase correlation", 30),
    ("Virtex-4 [27]", 640, 480, 64, "census, local", 60),
    ("Virtex-2 [28]", 640, 480, 128, "SAD, local", 60),
    ("Virtex-2 [29]", 640, 480, 64, "SAD, local", 30),
    ("Cyclone III, the thesis", 720, 576, 80, "modified graph cut", 25),
)
