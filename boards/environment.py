"""What somebody's environment has for boards of their own, kept out of these."""

import contextlib
import os
from collections.abc import Iterator


__all__ = ["no_overrides"]


@contextlib.contextmanager
def no_overrides() -> Iterator[None]:
    """Within the block no variable ``AMARANTH_add_settings`` or the like, which somebody needs for a board of their own: Amaranth prefers
    those to what a platform says.
    """
    before = {name: os.environ.pop(name) for name in [*os.environ] if name.startswith("AMARANTH_") and name != "AMARANTH_USE_YOSYS"}
    try:
        yield
    finally:
        os.environ.update(before)
