"""The system on boards to which a host sends pairs of pictures, as :class:`boards.registry.Board` wants it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from golden.errors import UserError
from golden.host.loop_registers import loop_register_map
from golden.host.registers import RegisterMap
from golden.video.bandwidth import Budget
from hdl.loop.store import BlockStores
from hdl.loop.system import LoopSystem
from hdl.loop.words import Stores

from ..registry import Design, Serial


__all__ = ["CLOCK_MHZ", "PICTURES", "LoopBoard", "block_stores", "loop_registers", "loop_system"]


#: What is built unless something else is chosen: a picture that is sent in a tenth of a second, and a matcher that is built in minutes.
PICTURES = Serial(width=320, height=240, disparities=16, baud=3_000_000)
#: A multiple of the default rate of the serial line, which a matcher of this size reaches.
CLOCK_MHZ = 60


@dataclass
class LoopBoard:
    """The component ``core``, and its matcher."""
    core: Any
    matcher: Any
    budget: Budget | None = None


def block_stores(design: Design) -> Stores:
    """Pictures in memory blocks."""
    return BlockStores(design.config, design.height, display=design.display is not None)


def loop_system(design: Design, stores_of: Callable[[Design], Stores] = block_stores) -> LoopBoard:
    """The system of a design; :class:`golden.errors.UserError` if the serial line does not run at its rate.

    ``stores_of`` makes what the pictures are stored in, and may refuse the design likewise.
    """
    assert design.baud
    stores = stores_of(design)
    try:
        core = LoopSystem(stores, design.clock_hz, design.baud)
    except ValueError as error:
        raise UserError(f"--baud {design.baud} at a clock of {design.clock_hz / 1e6:g} MHz: {error}") from None
    return LoopBoard(core, core.matcher)


def loop_registers(design: Design) -> RegisterMap:
    """Registers of :func:`loop_system`."""
    return loop_register_map(design.config, design.height)
