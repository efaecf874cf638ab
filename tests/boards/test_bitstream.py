"""From a project to a bitstream: what the tools are given. The tools themselves run in ``test_ecp5_build.py``."""

import json
from collections import Counter
from dataclasses import dataclass

import pytest

from boards.ecp5 import bitstream
from boards.ecp5.bitstream import MATCHER, Target, make_bitstream
from boards.registry import Design, Project, find_board
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.video.formats import VGA
from hdl.resources.ecp5 import ECP5
from hdl.resources.floorplan import SITES
from hdl.resources.lattice import Lattice


TARGET = Target("T1", "--85k", "P", "6", "2.4")


@dataclass(frozen=True)
class Tools(Lattice):
    """Synthesis gives so many memory blocks, all but ten of them of labels; the netlist that nextpnr would place is kept."""
    blocks: int = 0
    seen: tuple = ()

    def synthesise(self, folder, top, report):
        names = [f"{MATCHER}engine.array.wait_{n}.memory" if n >= 10 else f"core.core.stores.memory_{n}.0" for n in range(self.blocks)]
        cells = {name: {"type": "DP16KD", "connections": {}, "parameters": {}, "attributes": {}} for name in names}
        (folder / "yosys.log").write_text("")
        (folder / "design.json").write_text(json.dumps({"modules": {top: {"ports": {}, "cells": cells, "netnames": {}}}}))
        return Counter(DP16KD=self.blocks), False

    def run_nextpnr(self, folder, arguments, log, report=None):
        self.seen.append(json.loads((folder / "design.json").read_text())["modules"]["stereo"]["cells"])
        return "as the test wants it"


@pytest.mark.parametrize("blocks", [166, 167, 200])
def test_floor_plan_of_a_filled_device(blocks, tmp_path, monkeypatch):
    """From four fifths of the blocks on; nearly all: what is outside of the matcher, too."""
    seen = []
    fields = {name: getattr(ECP5, name) for name in ECP5.__dataclass_fields__}
    monkeypatch.setattr(bitstream, "ECP5", Tools(**fields, blocks=blocks, seen=seen))
    with pytest.raises(UserError, match=r"nextpnr did not place and route the design on an T1 \(as the test wants it\); see .*, or choose"):
        make_bitstream(TARGET, Project("stereo", {"stereo.v": "", "stereo.lpf": ""}, {}), tmp_path, lambda step: None)
    places = {name: cell["attributes"]["BEL"] for name, cell in seen[0].items() if cell["attributes"]}
    assert len(seen[0]) == blocks and len(places) == {166: 0, 167: 157, 200: 200}[blocks]
    assert len({*places.values()}) == len(places) and {*places.values()} <= {site for row in SITES.values() for site in row}
    assert all(name.startswith(MATCHER) for name in places) == (blocks != 200) or not places


def test_name_of_the_matcher():
    """In the project as it is emitted, in which a level of the hierarchy is a word of the module's name."""
    board, design = find_board("ulx3s"), Design(MatcherConfig(2, max_width=5), 4, 60_000_000, VGA, None, 3_000_000)
    text = board.project(board.system(design), design).files["stereo.v"]
    assert f"\nmodule stereo_{MATCHER.rstrip('.').replace('.', '_')}(" in text
