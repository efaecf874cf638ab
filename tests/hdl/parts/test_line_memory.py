# amaranth: UnusedElaboratable=no
"""hdl.parts.line_memory: words come back whichever memory holds them; a second memory only where it spares blocks."""

import numpy as np
import pytest

from hdl.parts.line_memory import LineMemory, blocks_of
from sim.kit.clocked import run_clocked


@pytest.mark.parametrize("depth, bits, split", [
    (1, 3, 1), (20, 72, 20), (300, 36, 300), (720, 72, 512), (720, 9, 720), (1024, 72, 1024),
])
def test_words(depth, bits, split):
    dut = LineMemory(bits, depth)
    assert dut.split == split
    rng = np.random.default_rng(depth)
    words = [int.from_bytes(rng.bytes(9), "big") & (1 << bits) - 1 for _ in range(depth)]
    order = rng.permutation(depth).tolist()
    writes = [{"write": 1, "column": column, "i": words[column], "address": 0} for column in range(1, depth)]
    # Not where it is read: column 0 is written last.
    writes.append({"write": 1, "column": 0, "i": words[0], "address": depth - 1})
    # While ``write`` is low nothing changes.
    reads = [{"write": 0, "column": (column + 1) % depth, "i": 0, "address": column} for column in order * 2]
    out = run_clocked(dut, [*writes, *reads], ["o"], drain=dut.LATENCY)
    assert [word["o"] for word in out[depth + dut.LATENCY:]] == [words[column] for column in order * 2]


@pytest.mark.parametrize("depth", [1, 257, 512, 700, 720, 768, 769, 1000, 4096])
@pytest.mark.parametrize("bits", [1, 9, 36, 64, 72])
def test_never_more_blocks(depth, bits):
    dut = LineMemory(bits, depth)
    assert blocks_of(dut.split, bits) + blocks_of(depth - dut.split, bits) <= blocks_of(depth, bits)
