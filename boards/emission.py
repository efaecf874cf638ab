"""The files of a board's project, from its platform and its top level."""

from collections.abc import Collection

from amaranth import Elaboratable
from amaranth.build import Platform

from hdl.emit import NO_RW_CHECK, emit_rtlil
from hdl.netlist import Netlist


__all__ = ["NAME", "emitted_files"]


#: Of every project and its top-level module.
NAME = "stereo"


def emitted_files(platform: Platform, top: Elaboratable, attributes: Collection[str]) -> tuple[dict[str, str], dict[str, Netlist]]:
    """The files of a platform's templates by name, with Verilog in place of RTLIL, and the design's netlist.

    Parameters
    ----------
    platform : Platform
        One of its templates is ``NAME.il``: RTLIL.
    top : Elaboratable
    attributes : collection of str
        Those that stay in the Verilog, besides ``no_rw_check``.
    """
    plan = platform.prepare(top, NAME, emit_src=False)
    files = {file_name: text.rstrip("\n") + "\n" for file_name, text in plan.files.items()}
    files[f"{NAME}.v"], netlist = emit_rtlil(files.pop(f"{NAME}.il"), attributes=(*attributes, NO_RW_CHECK))
    return files, netlist
