"""Altera Cyclone III development board (EP3C120F780C7), as Quartus II wants to hear of it.

Pins are those of the kit's own project files.
"""

from collections.abc import Iterable, Mapping


__all__ = ["CAPACITY", "CLOCK_MHZ", "DEVICE", "FAMILY", "quartus_project"]


FAMILY = "Cyclone III"
DEVICE = "EP3C120F780C7"
CAPACITY = {"logic_elements": 119_088, "memory_bits": 3_981_312, "m9k": 432, "multipliers_9x9": 576}

#: Top-level port: (ball, I/O standard). The oscillator's bank is supplied with 1.8 V; the button is low active with a pull-up.
PINS = {
    "clk": ("AH15", "1.8 V"),      # clkin_50
    "reset_n": ("T21", "2.5 V"),   # cpu_resetn
}
CLOCK_MHZ = 50


def quartus_project(name: str, sources: Iterable[str], ports: Mapping[str, int], clock_mhz: float) -> dict[str, str]:
    """Project, settings and constraints for Quartus II 9.1 to 13.1.

    Ports without a pin become virtual pins: the fitter keeps their logic and reports its size and speed, and a design that contains the
    matcher takes them over.

    Parameters
    ----------
    name : str
        Of project and top-level module.
    sources : iterable of str
        Verilog files, relative to the project.
    ports : mapping
        Top-level port to its width in bits.
    clock_mhz : float
        What the clock is constrained to.

    Returns
    -------
    dict
        File name to text.
    """
    settings = [
        f'set_global_assignment -name FAMILY "{FAMILY}"',
        f"set_global_assignment -name DEVICE {DEVICE}",
        f"set_global_assignment -name TOP_LEVEL_ENTITY {name}",
        *(f"set_global_assignment -name VERILOG_FILE {source}" for source in sources),
        "set_global_assignment -name VERILOG_INPUT_VERSION VERILOG_2001",
        f"set_global_assignment -name SDC_FILE {name}.sdc",
        "set_global_assignment -name PROJECT_OUTPUT_DIRECTORY output_files",
        'set_global_assignment -name STRATIX_DEVICE_IO_STANDARD "2.5 V"',
        # Unused balls lead to chips that drive them: they must not drive back.
        'set_global_assignment -name RESERVE_ALL_UNUSED_PINS_WEAK_PULLUP "AS INPUT TRI-STATED WITH WEAK PULL-UP"',
    ]
    for port, width in ports.items():
        if port in PINS:
            ball, standard = PINS[port]
            settings += [f"set_location_assignment PIN_{ball} -to {port}",
                         f'set_instance_assignment -name IO_STANDARD "{standard}" -to {port}']
        else:
            settings += [f"set_instance_assignment -name VIRTUAL_PIN ON -to {bit}"
                         for bit in ([port] if width == 1 else [f"{port}[{n}]" for n in range(width)])]
    constraints = [
        f"create_clock -name clk -period {1000 / clock_mhz:.3f} [get_ports clk]",
        "derive_clock_uncertainty",
        # A button: two flip-flops bring it into the clock domain.
        "set_false_path -from [get_ports reset_n]",
    ]
    return {
        f"{name}.qpf": f'QUARTUS_VERSION = "13.1"\nPROJECT_REVISION = "{name}"\n',
        f"{name}.qsf": "\n".join(settings) + "\n",
        f"{name}.sdc": "\n".join(constraints) + "\n",
    }
