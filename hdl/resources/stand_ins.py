"""Devices that stand in for a Cyclone III where a clock rate is measured: no open tool places and routes for that one."""

from .ecp5 import ECP5
from .lattice import Lattice
from .nexus import NEXUS


__all__ = ["DEFAULT_STAND_IN", "STAND_INS"]


STAND_INS: dict[str, Lattice] = {"ecp5": ECP5, "nexus": NEXUS}
DEFAULT_STAND_IN = "ecp5"
