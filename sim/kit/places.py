"""What a user's machine may have in the way of a simulator: odd names of folders, an environment for other benches, a full disk."""

import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path


__all__ = ["clean_environment", "copied", "full_disk", "link_tools", "relative"]


# Links in the folder of a build to Verilator and to cocotb, where they are installed. All that the tools are told is relative to that
# folder: `make` cannot cope with a space, a quote or a dollar in a path, nor can the start scripts of the simulators.
_VERILATOR_LINK = "verilator_root"
_COCOTB_LINK = "cocotb_root"

# What a simulator and its compilers see of the user's environment; it may hold anything else for benches, compilers and simulators of the
# user's own: COCOTB_TEST_FILTER, GPI_EXTRA, MAKEFLAGS, CXXFLAGS, PYTHONPATH, VERILATOR_ROOT, WAVES. The prefixes are of distributions
# whose compilers find their libraries that way.
_KEPT = ("PATH", "HOME", "TMPDIR", "LANG", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "LIBPYTHON_LOC", "SDKROOT", "VIRTUAL_ENV")
_KEPT_PREFIXES = ("LC_", "NIX_", "CONDA_")


# Bytes that a compiler needs at least for its next file.
_ROOM = 1 << 20


def clean_environment() -> dict[str, str]:
    """What a simulator and its compilers see of the process's environment."""
    kept = {name: value for name, value in os.environ.items() if name in _KEPT or name.startswith(_KEPT_PREFIXES)}
    return {"PATH": os.defpath, **kept}


def relative(command: Sequence[str], build_dir: Path) -> list[str]:
    """A command of cocotb that builds a model, for `build_dir` as working folder, with its links."""
    from cocotb_tools.config import libs_dir
    # The model finds the library where `run` says, so that it has no path in it.
    changes = {f"-Wl,-rpath,{libs_dir} -L{libs_dir}": f"-L{_COCOTB_LINK}/{libs_dir.name}", str(libs_dir.parent): _COCOTB_LINK}
    words = []
    for word in command:
        word = "." if word == str(build_dir) else word.removeprefix(f"{build_dir}{os.sep}")
        for old, new in changes.items():
            word = word.replace(old, new)
        words.append(word)
    # Verilator's makefile refuses a working folder with a space, which none of its rules uses.
    return [*words, "CURDIR=."] if command[0] == "make" else words


def copied(source: Path, folder: Path, number: int) -> Path:
    """A copy of a source by a name that `make` can read, and that still tells which it is."""
    path = folder / f"{number}_{re.sub(r'[^A-Za-z0-9.]', '_', source.name)}"
    path.write_bytes(source.read_bytes())   # `shutil.copy` may leave a part on a full disk, without an error
    return path


def link_tools(folder: Path, tools: Path | None) -> dict[str, str]:
    """Make the links in the folder of a build with Verilator, which is in ``tools``; what its start script must find in the environment."""
    from cocotb_tools.config import libs_dir
    (folder / _COCOTB_LINK).symlink_to(libs_dir.parent)
    if tools is None or not (tools.parent / "include" / "verilated.mk").is_file():
        return {}       # of a distribution, which knows its places
    (folder / _VERILATOR_LINK).symlink_to(tools.parent.resolve())
    return {"VERILATOR_ROOT": _VERILATOR_LINK, "VERILATOR_BIN": f"{_VERILATOR_LINK}/bin/verilator_bin"}


def full_disk(folder: str | os.PathLike[str]) -> str:
    """What to add to a message if ``folder`` takes no more data, which compilers that write their log there cannot tell; else nothing."""
    try:
        with tempfile.TemporaryFile(dir=folder) as file:    # buffered: a raw write may write a part and succeed
            file.write(bytes(_ROOM))
            file.flush()
    except OSError as error:
        return f" ({error.strerror} in {Path(folder).parent}; make room, or name another folder with --output or TMPDIR)"
    return ""
