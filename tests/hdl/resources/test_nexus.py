"""The LIFCL-40 as a stand-in: what is changed in a netlist before it is placed, and what the device holds."""

import json

import pytest

from golden.errors import UserError
from hdl.resources.nexus import NEXUS


ZERO, ONE, CLOCK = 5, 6, 2


def carry(**connections):
    return {"type": "CCU2", "connections": {port: [bit] for port, bit in connections.items()}}


@pytest.fixture
def cells(tmp_path):
    """Those of a netlist after its preparation."""
    cells = {
        "zero": {"type": "VLO", "connections": {"Z": [ZERO]}}, "one": {"type": "VHI", "connections": {"Z": [ONE]}},
        "first": carry(CIN=ZERO, A1=ONE, COUT=20), "second": carry(CIN=20, A0=ZERO, COUT=21), "alone": carry(A0=7, COUT=22),
        "inverted": carry(CIN=ONE, COUT=23), "table": {"type": "LUT4", "connections": {"CIN": [ZERO], "Z": [30]}},
    }
    ports = {"clk": {"direction": "input", "bits": [CLOCK]}, "a": {"direction": "input", "bits": [7]}}
    path = tmp_path / "design.json"
    path.write_text(json.dumps({"modules": {"top": {"ports": ports, "cells": cells, "netnames": {}}}}))
    NEXUS.prepare(path, "top")
    module = json.loads(path.read_text())["modules"]["top"]
    assert module["ports"] == {}
    return module["cells"]


def test_first_carry_of_a_chain_has_none(cells):
    """A constant is disconnected; the carry of another cell stays, and so do other inputs and other cells."""
    assert cells["first"]["connections"] == {"A1": [ONE], "COUT": [20]} and cells["inverted"]["connections"] == {"COUT": [23]}
    assert cells["second"]["connections"] == {"CIN": [20], "A0": [ZERO], "COUT": [21]}
    assert cells["alone"]["connections"] == {"A0": [7], "COUT": [22]} and cells["table"]["connections"] == {"CIN": [ZERO], "Z": [30]}


def test_clock_has_a_driver(cells):
    assert cells["clock"]["connections"] == {"CLKO": [CLOCK]} and cells["clock"]["port_directions"] == {"CLKO": "output"}


FULL = {"LUT4": 32_000, "CCU2": 100, "WIDEFN9": 28, "FD1P3IX": 32_000, "FD1P3JX": 256, "PDPSC16K": 80, "DP16K": 4, "MULT18X18": 55,
        "MULT9X9": 2, "VHI": 1}


@pytest.mark.parametrize("more, sentence", [
    ({"LUT4": 32_001}, "takes 32,257 tables and the stand-in LIFCL-40, speed grade 9, has 32,256; choose fewer disparities"),
    ({"CCU2": 101}, "takes 32,258 tables"), ({"WIDEFN9": 29}, "takes 32,258 tables"), ({"FD1P3JX": 257}, "takes 32,257 registers"),
    ({"PDPSC16K": 81}, "takes 85 memory blocks and the stand-in LIFCL-40, speed grade 9, has 84"),
    ({"MULT9X9": 3}, "takes 113 9x9 multipliers"), ({"MULT18X18": 56}, "takes 114 9x9 multipliers"),
])
def test_what_the_device_holds(more, sentence):
    NEXUS.check(FULL)
    with pytest.raises(UserError, match=sentence):
        NEXUS.check(FULL | more)
