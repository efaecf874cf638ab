"""A core in FuseSoC: its description in CAPI2."""

from typing import Any

import yaml

from .core import Core


__all__ = ["fusesoc_files"]


_FILE_TYPES = {".v": "verilogSource-2001", ".vlt": "vlt"}


def fusesoc_files(core: Core) -> dict[str, str]:
    """``NAME.core``: the core ``::NAME:VERSION`` with its Verilog as the target ``default``, on which other cores depend.

    The target ``lint`` has Verilator check the Verilog with all warnings but those waived, and ends at one; ``sim`` compiles it for Icarus.
    """
    def files(suffix: str) -> list[dict[str, Any]]:
        return [{name: {"file_type": _FILE_TYPES[suffix]}} for name in core.files if name.endswith(suffix)]

    filesets = {"rtl": {"files": files(".v")}, "waivers": {"files": files(".vlt")}}
    description = {
        "name": f"::{core.name}:{core.version}",
        "description": core.description,
        "filesets": filesets,
        "targets": {
            "default": {"filesets": ["rtl"], "toplevel": core.name},
            "lint": {"filesets": [*filesets], "toplevel": core.name, "flow": "lint",
                     "flow_options": {"tool": "verilator", "verilator_options": ["-Wall"]}},
            "sim": {"filesets": ["rtl"], "toplevel": core.name, "flow": "sim", "flow_options": {"tool": "icarus"}},
        },
    }
    return {f"{core.name}.core": "CAPI=2:\n" + yaml.safe_dump(description, sort_keys=False)}
