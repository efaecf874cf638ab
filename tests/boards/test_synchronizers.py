# amaranth: UnusedElaboratable=no
import re
import warnings

import pytest
from amaranth import *
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer
from amaranth.sim import Simulator

from boards.altera.crossings import synchronizers, window
from boards.altera.synchronizers import ATTRIBUTE, FIRST_STAGE, LATER_STAGE
from boards.cyclone3.blocks import BLOCKS
from boards.cyclone3.platform import Cyclone3Platform
from hdl.netlist import Cell, Hierarchy, Netlist, Port
from sim.models.board_core import board_project


def run(synchronizer, values, i, o):
    """The output after each of ``values``, which are given a clock each."""
    told = []

    async def bench(ctx):
        for value in values:
            ctx.set(i, value)
            await ctx.delay(1e-9)
            told.append(ctx.get(o))
            await ctx.tick()

    simulator = Simulator(synchronizer)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        simulator.run()
    return told


@pytest.mark.parametrize("options", [{}, {"init": 0b1010}, {"stages": 3, "init": 0b1111}], ids=str)
def test_levels_are_those_of_amaranths(options):
    """Initial value, latency, and what a chain with a reset would do, bit for bit."""
    values = [3, 12, 5, 5, 0, 15, 9, 10, 0, 0]
    told = []
    for make in (lambda synchronizer: synchronizer, Cyclone3Platform().get_ff_sync):
        i, o = Signal(4), Signal(4)
        told.append(run(make(FFSynchronizer(i, o, **options)), values, i, o))
    assert told[0] == told[1]
    stages = options.get("stages", 2)
    assert told[1] == [options.get("init", 0)] * stages + values[:-stages]


@pytest.mark.parametrize("edge", ["pos", "neg"])
def test_resets_are_those_of_amaranths(edge):
    """Asserted at once, released after two clocks."""
    values = [0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0]
    told = []
    for make in (lambda synchronizer: synchronizer, Cyclone3Platform().get_async_ff_sync):
        i, o = Signal(), Signal()
        told.append(run(make(AsyncFFSynchronizer(i, o, async_edge=edge)), [value ^ (edge == "neg") for value in values], i, o))
    assert told[0] == told[1] == [1, 1, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 1, 0]


@pytest.mark.parametrize("make, kind", [(Cyclone3Platform().get_ff_sync, FFSynchronizer),
                                        (Cyclone3Platform().get_async_ff_sync, AsyncFFSynchronizer)])
def test_greatest_input_delay_is_refused(make, kind):
    with pytest.raises(ValueError, match=r"leave max_input_delay out$"):
        make(kind(Signal(), Signal(), max_input_delay=1e-9))


def test_settings_are_in_the_verilog():
    """Of every register of every chain, in front of its declaration, and of nothing else; Quartus's own synchronisers are not used."""
    text = board_project("720x576").files["stereo.v"]
    marked = re.findall(rf'(?m)^  \(\* {ATTRIBUTE} = "(.*)" \*\)\n  reg (?:\[\d+:0\] )?stage(\d);\n  initial stage\d = \d+\'h0+;$', text)
    assert len(marked) == text.count(f"(* {ATTRIBUTE}") == len(re.findall(r"(?m)^  reg .*stage\d", text))
    assert {number for value, number in marked if value == FIRST_STAGE} == {"0"}
    assert {number for value, number in marked if value == LATER_STAGE} == {"1"}
    assert "PRESERVE_REGISTER ON" in LATER_STAGE and "SYNCHRONIZER_IDENTIFICATION FORCED_IF_ASYNCHRONOUS" in FIRST_STAGE
    assert "altera_std" not in text


def test_crossings_are_found():
    """All Gray pointers of the stand-in's three FIFOs, with both clocks; inputs and resets are no pointers."""
    chains = synchronizers(Hierarchy(board_project("720x576").netlist, "stereo", BLOCKS))
    sync, display = "stereo_ddr2.phy_clk", "altpll.clk"
    queues = {"left_camera_queue": ("camera_0__clk__io", sync), "right_camera_queue": ("camera_1__clk__io", sync),
              "display_queue": (sync, display)}
    assert {chain.path: (chain.source, chain.launch, chain.latch) for chain in chains if chain.is_gray} == {
        f"core|{queue}|fifo|unbuffered|{which}_cdc": (source, *(clocks if which == "produce" else clocks[::-1]))
        for queue, clocks in queues.items() for which, source in (("produce", "produce_w_gry"), ("consume", "consume_r_gry"))}
    others = {chain.path: chain.latch for chain in chains if not chain.is_gray}
    assert others["button_2_synchronizer"] == others["sync_reset"] == sync
    assert others["right_camera_reset"] == "camera_1__clk__io"
    assert len(others) == 10 + 4 + 3


def test_pointer_that_is_no_register():
    """Its clock is not known: the check tells."""
    chain = Netlist({"clk": Port("input", [2]), "i": Port("input", [3, 4]), "o": Port("output", [7, 8])}, {
        "0": Cell("$dff", {"CLK": [2], "D": [3, 4], "Q": [5, 6]}, {"CLK": "input", "D": "input", "Q": "output"}),
        "1": Cell("$dff", {"CLK": [2], "D": [5, 6], "Q": [7, 8]}, {"CLK": "input", "D": "input", "Q": "output"}),
    }, {"stage0": [5, 6], "stage1": [7, 8]})
    top = Netlist({"clk": Port("input", [2]), "a": Port("input", [3, 4])}, {
        "gate": Cell("$not", {"A": [3, 4], "Y": [5, 6]}, {"A": "input", "Y": "output"}),
        "cdc": Cell("chain", {"clk": [2], "i": [5, 6], "o": [7, 8]}, {"clk": "input", "i": "input", "o": "output"}),
    }, {"pointer_gry": [5, 6]})
    found, = synchronizers(Hierarchy({"top": top, "chain": chain}, "top", {}))
    assert (found.path, found.source, found.launch, found.latch, found.is_gray) == ("cdc", "pointer_gry", "", "clk", True)
    assert found.registers == ["cdc|stage0[0]", "cdc|stage0[1]"]


def test_window_is_no_wider_than_the_shorter_period():
    for periods in ([37.037, 40 / 3], [1000 / 65, 16], [7.0, 7.0]):
        least, most = window(periods)
        assert min(periods) - 0.003 < most - least <= min(periods)
        assert least < 0 < most
