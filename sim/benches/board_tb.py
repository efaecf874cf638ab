"""The cocotb half of ``test_board.py``: each pin is connected to its port of the system's stand-in, with its level and delay."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer


CLOCK_NS = 20
CAMERA_PS = {"left": 37_036, "right": 37_048}   # two clocks with drift
PRESSED = 0xF


async def start(dut, *, cameras=("left", "right"), switch=1):
    """Start the clocks and release the reset."""
    memory = dut.chip.ddr2
    dut.reset_n.value = 0
    dut.buttons_n.value = PRESSED
    dut.switch.value = switch
    dut.lines_low.value = 0
    dut.rx.value = 1
    for camera in ("left", "right"):
        getattr(dut, f"{camera}_data").value = 0
        getattr(dut, f"{camera}_clk").value = 0
    for output in (memory.local_ready, memory.local_rdata, memory.local_rdata_valid, memory.local_init_done):
        output.value = 0
    Clock(dut.clk50, CLOCK_NS, unit="ns").start()
    for camera in cameras:
        Clock(getattr(dut, f"{camera}_clk"), CAMERA_PS[camera], unit="ps").start()
    await Timer(400, unit="ns")
    assert dut.isel.value == 0 and memory.global_reset_n.value == 0
    dut.reset_n.value = 1
    return memory


async def settle(dut, cycles=8):
    for _ in range(cycles):
        await RisingEdge(dut.clk50)
    await Timer(1, unit="ns")


@cocotb.test()
async def resets_end_in_order(dut):
    """``sync`` when both PLLs have locked, then ``display``, then a camera's domain once its clock runs, independent of the other
    camera. The button resets all again.
    """
    locks = dut.chip.ddr2.locks, dut.chip.display_pll.locks
    for late in locks:
        late.value = 0
        await start(dut, cameras=())
        await settle(dut, 20)
        assert dut.chip.rst.value == 1
        late.value = 1
        await settle(dut, 20)
        assert dut.chip.rst.value == 0
    for late in locks:
        late.value = 0
    await start(dut, cameras=())
    # A clock faster than the display's: without a wait for that domain, the camera's would be released first.
    Clock(dut.right_clk, 4, unit="ns").start()
    resets = {"sync": dut.chip.rst, "display": dut.chip.display_rst, "right": dut.chip.right_camera_rst, "left": dut.chip.left_camera_rst}
    assert all(reset.value == 1 for reset in resets.values())
    for late in locks:
        late.value = 1
    ended = []
    for _ in range(400):
        await Timer(1, unit="ns")
        ended += [name for name, reset in resets.items() if reset.value == 0 and name not in ended]
    assert ended == ["sync", "display", "right"]
    Clock(dut.left_clk, CAMERA_PS["left"], unit="ps").start()
    await Timer(200, unit="ns")
    assert resets["left"].value == 0
    dut.reset_n.value = 0
    await Timer(400, unit="ns")
    assert all(reset.value == 1 for reset in resets.values())


@cocotb.test()
async def decoder_leaves_reset_then_power_down(dut):
    await start(dut)
    assert (dut.decoder_reset_n.value, dut.decoder_powerdown_n.value) == (0, 0)
    await FallingEdge(dut.chip.rst)
    await settle(dut, 1)
    assert (dut.decoder_reset_n.value, dut.decoder_powerdown_n.value) == (1, 0)
    await settle(dut, 1)
    assert (dut.decoder_reset_n.value, dut.decoder_powerdown_n.value) == (1, 1)


async def show(dut, camera, sent, count, rng):
    """Bytes change with the falling edge of the camera's clock."""
    for _ in range(count):
        await FallingEdge(getattr(dut, f"{camera}_clk"))
        byte = rng.randrange(256)
        getattr(dut, f"{camera}_data").value = byte
        sent.append(byte)


@cocotb.test()
async def camera_bytes(dut):
    """All bytes of each camera, in order, in one half of the memory's write data each; those of the left one are also the address."""
    memory = await start(dut)
    await settle(dut, 40)
    sent = {"left": [], "right": []}
    for seed, camera in enumerate(sent):
        cocotb.start_soon(show(dut, camera, sent[camera], 200, random.Random(seed)))
    seen = {"left": [0], "right": [0]}
    for _ in range(600):
        await FallingEdge(memory.phy_clk)
        word = memory.local_wdata.value.to_unsigned()
        for camera, byte in (("left", word & 0xFF), ("right", word >> 64 & 0xFF)):
            if byte != seen[camera][-1]:
                seen[camera].append(byte)
        assert memory.local_address.value == word & 0xFF
    for camera, bytes_sent in sent.items():
        assert len(bytes_sent) == 200
        # A repeated byte is not visible.
        expected = [byte for before, byte in zip([0, *bytes_sent], bytes_sent) if byte != before]
        assert seen[camera][1:] == expected, camera


@cocotb.test()
async def pixels(dut):
    """Colours and sync signals, valid half a clock before and after the transmitter's rising edge."""
    memory = await start(dut)
    await settle(dut, 20)
    rng = random.Random(1)
    words = [rng.randrange(2**27) for _ in range(100)]

    async def play():
        for word in words:
            await FallingEdge(memory.phy_clk)
            memory.local_rdata.value = word
            memory.local_rdata_valid.value = 1
        await FallingEdge(memory.phy_clk)
        memory.local_rdata_valid.value = 0

    def shown():
        colours = sum(signal.value.to_unsigned() << place for signal, place in ((dut.red, 0), (dut.green, 8), (dut.blue, 16)))
        return colours | sum(int(signal.value) << place for signal, place in ((dut.de, 24), (dut.hsync, 25), (dut.vsync, 26)))

    cocotb.start_soon(play())
    seen = []
    for _ in range(130):
        await FallingEdge(dut.dvi_clk)
        await Timer(1, unit="ns")
        early = shown()
        await RisingEdge(dut.dvi_clk)
        seen.append(shown())
        await Timer(CLOCK_NS / 2 - 1, unit="ns")
        assert early == seen[-1] == shown()
    first = seen.index(words[0])
    assert seen[first:first + 100] == words


@cocotb.test()
async def memory_bus(dut):
    memory = await start(dut)
    await settle(dut, 20)

    def requests():
        return [memory.local_write_req.value, memory.local_read_req.value, memory.local_burstbegin.value, memory.local_be.value == 0xA5F0]

    for button in range(4):
        dut.buttons_n.value = PRESSED & ~(1 << button)
        await settle(dut)
        assert requests() == [int(number == button) for number in range(4)]
    assert memory.local_size.value == 1 and memory.soft_reset_n.value == 1
    for led, output in ((5, memory.local_rdata_valid), (6, memory.local_ready), (7, memory.local_init_done)):
        output.value = 1
        await settle(dut)
        assert ~dut.leds_n.value.to_unsigned() & 0xE0 == 1 << led
        output.value = 0


@cocotb.test()
async def i2c_lines(dut):
    """Low if the chip or another device pulls it low, which the chip reads; otherwise high."""
    await start(dut)
    await settle(dut, 20)
    assert dut.isel.value == 1
    assert dut.lines.value == 0xF
    for line in range(4):
        dut.buttons_n.value = PRESSED & ~(1 << line)
        await settle(dut)
        assert dut.lines.value == 0xF & ~(1 << line)
        assert dut.leds_n.value.to_unsigned() & 0xF == 1 << line
        dut.buttons_n.value = PRESSED
        dut.lines_low.value = 1 << line
        await settle(dut)
        assert dut.leds_n.value.to_unsigned() & 0xF == 1 << line
        dut.lines_low.value = 0


@cocotb.test()
async def transmitter_by_levels(dut):
    """Switch 0 closed: ISEL stays low, and the chip releases the transmitter's lines only."""
    await start(dut, switch=0)
    await settle(dut, 20)
    dut.buttons_n.value = 0
    await settle(dut)
    assert dut.isel.value == 0
    assert dut.lines.value == 0b1100
    assert (dut.power_up.value, dut.dvi_clk_n.value, dut.dken.value, dut.ctl.value) == (1, 0, 0, 0)


@cocotb.test()
async def console(dut):
    await start(dut)
    await settle(dut, 20)
    for level in (0, 1, 0):
        dut.rx.value = level
        await settle(dut)
        assert dut.tx.value == level
        assert dut.leds_n.value.to_unsigned() >> 4 & 1 == 1 - level
