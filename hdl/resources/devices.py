"""Devices of the families that :mod:`hdl.resources.mapping` maps to, Cyclone III and IV E, and their capacities."""

from dataclasses import dataclass

from .count import Resources


__all__ = ["CONTROLLER", "DEFAULT_DEVICE", "DEVICES", "Device"]


@dataclass(frozen=True)
class Device:
    """An FPGA by its ordering code."""
    name: str
    capacity: Resources


#: Devices by name, with the capacities of Altera's device handbooks of Cyclone III and Cyclone IV.
DEVICES = {device.name: device for device in (
    Device("EP3C120F780C7", Resources(logic_elements=119_088, memory_bits=3_981_312, m9k=432, multipliers_9x9=576)),
    Device("EP4CE115F29C7", Resources(logic_elements=114_480, memory_bits=3_981_312, m9k=432, multipliers_9x9=532)),
)}
#: What Altera's memory controller takes, which our count cannot see: the half-rate controller with its physical layer for 32 bits of DDR2,
#: rounded up from the user guide's table for this family.
CONTROLLER = Resources(logic_elements=10_000, memory_bits=100_000, m9k=20)

#: The device of the thesis.
DEFAULT_DEVICE = "EP3C120F780C7"
