"""sim.models.ddr2: a violation of the protocol is seen, timing keeps its promises, contents are kept."""

import numpy as np
import pytest

from golden.video.memory_map import MemoryMap, Plane
from sim.models.ddr2 import Ddr2Timing, LocalMemory, Request


ALL_BYTES = 0xffff
ALWAYS_READY = Ddr2Timing(init=1, busy=0.0, refresh=(10**9, 0), latency=(10, 10))


def request(**changes):
    return Request(**{"address": 5, "write_req": 1, "read_req": 0, "burstbegin": 1, "wdata": 7, "be": ALL_BYTES, "size": 1, **changes})


def memory(*, words=64, size=4, ready=1, **timing):
    result = LocalMemory(words, size=size, timing=Ddr2Timing(**{**vars(ALWAYS_READY), **timing}))
    result.clock(None)
    result.ready = ready
    return result


READ = {"write_req": 0, "read_req": 1}

# Requests clock by clock, ``None`` for none; the last one is wrong. ``busy`` keeps ``ready`` low.
VIOLATIONS = {
    "both kinds": (0, [request(read_req=1)]),
    "burstbegin alone": (0, [request(write_req=0)]),
    "no burstbegin": (0, [request(burstbegin=0)]),
    "no burstbegin of a second burst": (0, [request(), request(burstbegin=0)]),
    "burstbegin held": (1, [request(), request()]),
    "withdrawn before ready": (1, [request(), None]),
    "address changed": (1, [request(), request(burstbegin=0, address=6)]),
    "data changed": (1, [request(), request(burstbegin=0, wdata=8)]),
    "byte enables changed": (1, [request(), request(burstbegin=0, be=1)]),
    "size changed": (1, [request(), request(burstbegin=0, size=2)]),
    "kind changed": (1, [request(), request(burstbegin=0, **READ)]),
    "read's address changed": (1, [request(**READ), request(burstbegin=0, address=6, **READ)]),
    "size of none": (0, [request(size=0)]),
    "size too great": (0, [request(size=5)]),
    "beyond the end": (0, [request(address=64)]),
    "over the end": (0, [request(address=62, size=3, **READ)]),
    "read in a write burst": (0, [request(size=2), request(**READ)]),
    "burstbegin in a write burst": (0, [request(size=2), request(size=2)]),
    "address changed in a write burst": (0, [request(size=2), request(size=2, burstbegin=0, address=6)]),
}


@pytest.mark.parametrize("case", VIOLATIONS)
def test_violations(case):
    busy, requests = VIOLATIONS[case]
    model = memory(ready=1 - busy, busy=float(busy), patience=10**6)
    for good in requests[:-1]:
        model.clock(good)
    with pytest.raises(AssertionError, match=f"^clock {len(requests)}:"):
        model.clock(requests[-1])


def test_request_before_init_done():
    with pytest.raises(AssertionError, match="before init_done"):
        LocalMemory(64).clock(request())


def read(model, address, size=1):
    """Words of one read, and the clocks from its acceptance to each."""
    model.clock(request(address=address, size=size, **READ))
    words, clocks = [], []
    for clock in range(1, 60):
        if model.rdata_valid:
            words.append(model.rdata)
            clocks.append(clock)
        model.clock(None)
    return words, clocks


def test_contents():
    """A burst with a pause in it, byte enables; bytes never written are noise, different each time."""
    model = memory()
    model.clock(request(address=8, size=2, wdata=1))
    model.clock(None)
    model.clock(request(address=8, size=2, wdata=2, burstbegin=0))
    model.clock(request(address=9, wdata=0xaaaa, be=2))
    model.clock(request(address=10, wdata=0x99, be=1))
    assert (model[8], model[9]) == (1, 0xaa02)
    (first, second, third), clocks = read(model, 8, 3)
    assert (first, second, third & 0xff) == (1, 0xaa02, 0x99)
    assert clocks == [10, 11, 12]
    assert read(model, 10)[0] != read(model, 10)[0]
    assert read(model, 20)[0] != read(model, 20)[0]
    with pytest.raises(KeyError):
        model[10]
    assert (model.words_written, model.words_read) == (4, 3 + 4)


def test_a_read_gets_what_was_there_when_it_was_accepted():
    model = memory()
    model[3] = 1
    model.clock(request(address=3, **READ))
    model.clock(request(address=3, wdata=2))
    for _ in range(20):
        if model.rdata_valid:
            break
        model.clock(None)
    assert (model.rdata, model[3]) == (1, 2)


def test_reads_come_in_order_and_in_time():
    """Latencies differ, order does not; each word 10 to 30 clocks after its acceptance, or right after the one before."""
    model = memory(latency=(10, 30))
    for address in range(64):
        model[address] = address
    words, at = [], []
    for clock in range(600):
        model.clock(request(address=clock // 8, **READ) if clock % 8 == 0 and clock < 64 * 8 else None)
        if model.rdata_valid:
            words.append(model.rdata)
            at.append(clock + 1)
    assert words == list(range(64))
    delays = [clock - 8 * number for number, clock in enumerate(at)]
    assert 10 <= min(delays)
    assert max(delays) <= 30
    assert len(set(delays)) > 5


def test_ready():
    """Low in refreshes and stalls, never longer by chance than patience allows."""
    model = LocalMemory(timing=Ddr2Timing(init=7, busy=0.8, patience=3, refresh=(100, 10), stalls=((320, 50),)))
    assert not model.init_done
    ready, done = [], []
    for _ in range(600):
        model.clock(None)
        ready.append(model.ready)
        done.append(model.init_done)
    assert done == [0] * 6 + [1] * 594
    for now in range(1, 601):
        if now % 100 >= 90 or 320 <= now < 370:
            assert not ready[now - 1]
    runs = "".join(map(str, ready[:89])).split("1")
    assert max(map(len, runs)) == 3
    model.stall(30)
    for _ in range(30):
        model.clock(None)
        assert not model.ready or model.now > 629


def test_pictures():
    memory_map = MemoryMap(20, 3)
    picture = np.random.default_rng(1).integers(0, 256, (3, 20))
    model = LocalMemory(memory_map.total_words, timing=ALWAYS_READY)
    model.load(memory_map, Plane.RIGHT, 1, picture)
    assert model.picture(memory_map, Plane.RIGHT, 1).tolist() == picture.tolist()
    with pytest.raises(KeyError):
        model.picture(memory_map, Plane.RIGHT, 0)
    base = memory_map.base(Plane.RIGHT, 0)
    model.clock(None)
    for offset, word in memory_map.words(picture).items():
        model.clock(request(address=base + offset, wdata=word, be=ALL_BYTES if offset % 2 == 0 else 0xf))
    assert model.picture(memory_map, Plane.RIGHT, 0).tolist() == picture.tolist()


def test_restart():
    """A controller in reset takes no request, whatever the master does, and gives no word back; then it is initialised again."""
    dut = memory(busy=0.0)
    dut.clock(request(address=3))
    dut.clock(request(address=3, **READ))
    dut.clock(request(size=2))
    dut.restart(4, 3)
    for number in range(4):
        dut.clock([request(burstbegin=0, size=9), None, request(address=4), None][number])
        assert dut.ready == dut.init_done == 0 or number == 3
    with pytest.raises(AssertionError, match="before init_done"):
        dut.clock(request())
    for _ in range(3):
        dut.clock(None)
    assert dut.init_done == 1
    for _ in range(20):
        dut.clock(None)
        assert not dut.rdata_valid
    assert dut[3] == 7
    dut.clock(request(address=4))
    assert dut[4] == 7
