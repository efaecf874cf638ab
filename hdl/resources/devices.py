"""Devices of the family that :mod:`hdl.resources.mapping` maps to, Cyclone III, and their capacities."""

from dataclasses import dataclass

from .count import Resources


__all__ = ["DEFAULT_DEVICE", "DEVICES", "Device"]


@dataclass(frozen=True)
class Device:
    """An FPGA by its ordering code."""
    name: str
    capacity: Resources


#: Devices by name, with the capacities of Altera's "Cyclone III Device Handbook".
DEVICES = {device.name: device for device in (
    Device("EP3C120F780C7", Resources(logic_elements=119_088, memory_bits=3_981_312, m9k=432, multipliers_9x9=576)),
)}
#: The device of the thesis.
DEFAULT_DEVICE = "EP3C120F780C7"
