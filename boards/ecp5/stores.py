"""What the pictures of a host are stored in on boards with an ECP5: memory blocks, or an SDRAM."""

from golden.config import PIXEL_BITS
from golden.errors import UserError
from hdl.loop.sdram_store import SdramStores
from hdl.loop.store import slices
from hdl.loop.words import StoredResult, Stores
from hdl.memory_blocks import MemoryShape
from hdl.resources.ecp5 import MEMORIES

from ..loop.system import block_stores
from ..registry import Design
from .fit import blocks


__all__ = ["PICTURE_BLOCKS", "block_or_sdram_stores"]


#: Most memory blocks that pictures take of all that the device has, on a board with an SDRAM; the others are the matcher's.
PICTURE_BLOCKS = 0.75


def block_or_sdram_stores(design: Design) -> Stores:
    """Memory blocks for pictures of at most :data:`PICTURE_BLOCKS`, and a board's SDRAM, as :mod:`golden.video.sdram` describes it, for
    larger ones; :class:`golden.errors.UserError` if it does not run at the matcher's clock.
    """
    config, height = design.config, design.height
    depth, words = config.max_width * height, (PIXEL_BITS, PIXEL_BITS, StoredResult(config).size)
    taken = sum(blocks(MemoryShape(depth, width, 1)) for bits in words for width in slices(depth, bits))
    if taken <= PICTURE_BLOCKS * MEMORIES:
        return block_stores(design)
    try:
        return SdramStores(config, height, design.clock_hz, display=design.display)
    except ValueError as error:
        raise UserError(f"--width {config.max_width} --height {height} --clock {design.clock_hz / 1e6:g}: {error}") from None
