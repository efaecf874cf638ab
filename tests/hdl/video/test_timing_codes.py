import numpy as np
import pytest

from golden.video.bt656 import CORRECTED, PREAMBLE
from hdl.video.timing_codes import TimingCodes
from sim.kit.clocked import run_clocked


OUTPUTS = ("byte", "found", "valid", "corrected", "code")


def run_codes(data):
    dut = TimingCodes()
    given = run_clocked(dut, [{"data": int(byte)} for byte in data], OUTPUTS, drain=dut.LATENCY)
    return given[dut.LATENCY:]


def check(data):
    """Return how many codes were found, read and corrected."""
    data = np.asarray(data)
    given = run_codes(data)
    counts = np.zeros(3, int)
    for at, out in enumerate(given):
        found = at >= 3 and tuple(data[at - 3:at]) == PREAMBLE
        code = CORRECTED[data[at]]
        valid = bool(found and code >= 0)
        corrected = bool(valid and code != data[at])
        assert (out["byte"], out["found"], out["valid"], out["corrected"]) == (data[at], found, valid, corrected), at
        if valid:
            assert (out["code"].f, out["code"].v, out["code"].h) == (code >> 6 & 1, code >> 5 & 1, code >> 4 & 1), at
        counts += found, valid, corrected
    return counts.tolist()


def test_all_codes():
    data = [byte for xy in range(256) for byte in (*PREAMBLE, xy, 0x10)]
    assert check(data) == [256, 72, 64]


@pytest.mark.parametrize("seed", range(3))
def test_bytes_at_random(seed):
    """Preambles in and after one another, and all that is nearly one."""
    rng = np.random.default_rng(seed)
    found, valid, corrected = check(rng.choice([0x00, 0xFF, 0x80, 0x9D, 0x01, 0xFE, 0x7F], 2000, p=[0.5, 0.25, *[0.05] * 5]))
    assert found > 50
    assert 0 < corrected < valid < found


def test_a_code_is_found_at_once_after_another():
    assert check([*PREAMBLE, 0xFF, 0x00, 0x00, 0x80, *PREAMBLE, 0x9D]) == [3, 2, 0]
