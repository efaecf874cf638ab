"""Notes to the user: what a command assumed, on stderr, where it goes on."""

import sys


__all__ = ["note"]


def note(text: str) -> None:
    """Print one line that begins with ``note:`` to stderr, even if a file name in it contains line breaks."""
    print(f"note: {' '.join(text.split())}", file=sys.stderr)
