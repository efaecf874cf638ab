"""Checks of the board's Quartus project."""

from functools import partial

from ..altera import check
from ..altera.check import Ball, Chip
from .blocks import BLOCKS, MEMORY_CONTROLLER
from .platform import BALLS, BANK_VOLTS, CLOCK_BALLS


__all__ = ["check_project"]


_CHIP = Chip(
    balls={ball: Ball(BANK_VOLTS[bank], bank) for ball, bank in BALLS.items()}, clock_balls=CLOCK_BALLS, blocks=BLOCKS,
    instances={"altpll.clk": "display_pll", f"{MEMORY_CONTROLLER}.phy_clk": "ddr2"}, controller=MEMORY_CONTROLLER)

#: Lists the problems of a project, as :func:`boards.altera.check.check_project` does.
check_project = partial(check.check_project, _CHIP)
