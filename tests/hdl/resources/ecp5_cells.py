"""Cells of an ECP5 for netlists made by hand, and both netlists of a component on Icarus, before and after registers are moved."""

import json
import subprocess

from sim.kit.gate_level import gates_of


__all__ = ["CLOCK", "ENABLE", "moved_by", "printed", "register"]


CLOCK, ENABLE = 2, 3


def register(d, q, enable=None, **changed):
    parameters = {"CEMUX": "1 " if enable is None else "CE", "CLKMUX": "CLK", "LSRMUX": "LSR", "REGSET": "RESET"}
    connections = {"CLK": [CLOCK], "DI": [d], "LSR": ["0"], "Q": [q]} | ({} if enable is None else {"CE": [enable]})
    for name, value in changed.items():
        (parameters if name in parameters else connections)[name] = value
    return {"type": "TRELLIS_FF", "parameters": parameters, "port_directions": {"Q": "output"}, "connections": connections}


def moved_by(absorb, path, cells, ports=()):
    """What ``absorb`` returns for a netlist of these cells, whose ``ports`` are outputs, and the cells that it leaves."""
    ports = {f"p{bit}": {"direction": "output", "bits": [bit]} for bit in ports}
    path.write_text(json.dumps({"modules": {"top": {"ports": ports, "cells": cells, "netnames": {}}}}))
    moved = absorb(path, "top")
    return moved, json.loads(path.read_text())["modules"]["top"]["cells"]


def printed(netlist, bench, folder):
    """Lines that a bench prints with a netlist on Icarus."""
    folder.mkdir()
    gates = gates_of(netlist, "top", folder)
    (folder / "bench.v").write_text(bench)
    subprocess.run(["iverilog", "-g2012", "-s", "bench", "-o", "bench", "bench.v", gates.name], cwd=folder, check=True, capture_output=True)
    return subprocess.run(["vvp", "bench"], cwd=folder, check=True, capture_output=True, text=True).stdout.splitlines()
