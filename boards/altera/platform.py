"""A platform for Quartus: settings and files that all boards have in common."""

from importlib import resources
from typing import Any, ClassVar

from amaranth import Module
from amaranth.build.run import BuildPlan
from amaranth.hdl import Fragment
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer
from amaranth.vendor import AlteraPlatform

from ..environment import no_overrides
from .synchronizers import async_ff_synchronizer, ff_synchronizer


__all__ = ["OUTSIDE_CLOCKS", "QuartusPlatform", "file_templates", "quartus_settings", "settings_template"]


#: Template of constraints: clocks that enter at pins.
OUTSIDE_CLOCKS = """
    # Clocks that come from outside.
    {% for port, frequency in platform.iter_port_clock_constraints() %}
    create_clock -name {{port.name}} -period {{"%.3f"|format(1e9 / frequency)}} [get_ports {{'{'}}{{port.name}}{{'}'}}]
    {% endfor %}
"""


def quartus_settings(family: str, standard: str) -> tuple[str, ...]:
    """Settings of every project of a board.

    Parameters
    ----------
    family : str
        Of the FPGA, as Quartus calls it.
    standard : str
        I/O standard of pins that have none of their own.
    """
    return (
        f'set_global_assignment -name FAMILY "{family}"',
        f'set_global_assignment -name STRATIX_DEVICE_IO_STANDARD "{standard}"',
        # Unused balls are connected to chips that drive them: they must be inputs.
        'set_global_assignment -name RESERVE_ALL_UNUSED_PINS_WEAK_PULLUP "AS INPUT TRI-STATED WITH WEAK PULL-UP"',
        # There is no other device in the configuration chain.
        'set_global_assignment -name CYCLONEII_RESERVE_NCEO_AFTER_CONFIGURATION "USE AS REGULAR IO"',
        # The device has room for logic, and the matcher needs its clock. For these families the setting has the name of Cyclone II.
        "set_global_assignment -name CYCLONEII_OPTIMIZATION_TECHNIQUE SPEED",
        # Delays stay in registers, as hdl.resources counts them: in memory they would take blocks that the pictures' lines need.
        "set_global_assignment -name AUTO_SHIFT_REGISTER_RECOGNITION OFF",
    )


_CONSTRAINTS_FILE = "    set_global_assignment -name SDC_FILE {{name}}.sdc\n"


def settings_template(files: str = _CONSTRAINTS_FILE, more: str = "") -> str:
    """Template of a project's settings.

    Parameters
    ----------
    files : str
        Lines that name constraints and what else there is.
    more : str
        Lines behind the pins.
    """
    return f"""
    {{{{get_override("add_settings")}}}}
    set_global_assignment -name DEVICE {{{{platform.device}}}}{{{{platform.package}}}}{{{{platform.speed}}}}{{{{platform.suffix}}}}
    set_global_assignment -name TOP_LEVEL_ENTITY {{{{name}}}}
    set_global_assignment -name VERILOG_FILE {{{{name}}}}.v
    set_global_assignment -name VERILOG_INPUT_VERSION VERILOG_2001
    set_global_assignment -name USE_TIMEQUEST_TIMING_ANALYZER ON
{files}    set_global_assignment -name PROJECT_OUTPUT_DIRECTORY output_files

    {{% for port, ball, attributes in platform.iter_port_constraints_bits() %}}
    set_location_assignment PIN_{{{{ball}}}} -to {{{{port}}}}
    {{% for key, value in attributes.items() %}}
    set_instance_assignment -name {{{{key|upper}}}} "{{{{value}}}}" -to {{{{port}}}}
    {{% endfor %}}
    {{% endfor %}}
{more}"""


def file_templates(package: str, constraints: str, settings: str | None = None) -> dict[str, str]:
    """Templates of a project's files: RTLIL for :mod:`boards.emission`, settings, constraints, instructions.

    Parameters
    ----------
    package : str
        The board's, whose folder has the instructions, ``readme.md``.
    constraints : str
        Template.
    settings : str or None
        Template; that of :func:`settings_template` by default.
    """
    return {
        "{{name}}.il": "{{emit_rtlil()}}",
        "{{name}}.qsf": settings_template() if settings is None else settings,
        "{{name}}.sdc": constraints,
        "README.md": resources.files(package).joinpath("readme.md").read_text(encoding="utf-8"),
    }


class QuartusPlatform(AlteraPlatform):
    """For a board's platform: synchronisers of our own, and a project that Quartus opens.

    ``SETTINGS`` are lines of every project for the board, of :func:`quartus_settings`.
    """
    SETTINGS: ClassVar[tuple[str, ...]]

    quartus_command_templates = ()   # Quartus is run by hand

    def get_ff_sync(self, ff_sync: FFSynchronizer) -> Module:
        return ff_synchronizer(ff_sync)

    def get_async_ff_sync(self, async_ff_sync: AsyncFFSynchronizer) -> Module:
        return async_ff_synchronizer(async_ff_sync)

    def toolchain_prepare(self, fragment: Fragment, name: str, *, add_settings: str = "", **kwargs: Any) -> BuildPlan:
        with no_overrides():
            plan = super().toolchain_prepare(fragment, name, add_settings="\n".join([*self.SETTINGS, add_settings]), **kwargs)
        plan.add_file(f"{name}.qpf", f'QUARTUS_VERSION = "13.1"\nPROJECT_REVISION = "{name}"\n')
        return plan
