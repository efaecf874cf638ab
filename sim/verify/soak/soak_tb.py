"""The cocotb half of the soak: disturbs the whole system as the schedule says, and checks that it recovers and what it counted."""

import json
import os
import time
from pathlib import Path
from typing import Any

import cocotb
from cocotb.triggers import Timer, ValueChange, with_timeout

from golden.host.protocol import Operation, Request, Status, encode_request
from golden.host.registers import IDENTITY, Kind, answer
from golden.rig.balance import GAIN_ONE
from golden.video.display import DisplayMode
from sim.benches.system_faults import FAULTS, camera_reset, film
from sim.benches.system_rig import NO_CLOCK, SIDES, Rig
from sim.benches.system_sizes import CLOCK_HZ
from sim.models.camera import FAULTS as CAMERA_FAULTS
from sim.models.ddr2 import Ddr2Timing
from sim.verify.soak.ledger import COUNTERS, Ledger
from sim.verify.soak.memory import resident_bytes
from sim.verify.soak.schedule import DOMAIN_RESET, Disturbance


# Frames of the monitor within which two in a row are exact after a disturbance, and those of a camera that any of them takes at most.
RECOVERY = 24
PATIENCE = 200

HOSTILE = Ddr2Timing(busy=0.4, refresh=(300, 24))

# Settings that a monitor's picture, and golden's, depend on, beside the matcher's. After random writes any other is set to its reset value.
SHOWN = ("show", "colour", "rectify", "balance", "fixed_gain", "fixed_offset")

# Modes of the balance.
AUTO, FIXED = 1, 2


class Soak:
    """The system in its models, and what is known of it."""
    def __init__(self, dut: Any, seed: int):
        self.dut = dut
        self.rig = rig = Rig(dut, seed=seed, timing=HOSTILE)
        self.registers = rig.registers
        self.values: dict[str, int] = {}    # of settings that were written
        self.maps_known = True
        self.dark = 0                       # LEDs that were off
        self.frames = 0                     # that both cameras have sent, up to the last settlement
        self.ledgers = {}
        for side, camera in rig.films.items():
            ledger = self.ledgers[side] = Ledger(rig.camera)
            camera.tape = ledger.tape
            camera.faults.append(NO_CLOCK)  # so that the first byte is sent after the reset

    async def start(self) -> None:
        """The first exact pictures."""
        await self.rig.start()
        cocotb.start_soon(self._watch_leds())
        await self._first_pictures()

    async def _watch_leds(self) -> None:
        while True:
            await ValueChange(self.dut.leds)
            self.dark |= ~int(self.dut.leds.value)

    async def _first_pictures(self) -> None:
        """Those after a reset; with a rig, up to two that are not balanced yet. Then the balance is fixed."""
        rig = self.rig
        rig.change(scene=False, **self.settings())
        del rig.states[:-1]
        if rig.rig:
            await self._restore()
            rig.change(scene=False, **self.settings())
        await rig.shows(RECOVERY, every=not rig.rig)
        rig.cut = 0     # black until the first picture

    # What the host knows.

    def value(self, name: str) -> int:
        """Value of a setting."""
        return self.values.get(name, self.registers[name].reset)

    def settings(self) -> dict[str, Any]:
        """Settings of golden's picture."""
        rig = self.rig
        found: dict[str, Any] = {name: self.value(name) for name in rig.config.settings}
        found |= {"mode": list(DisplayMode)[self.value("show")], "colour": bool(self.value("colour")),
                  "maps": None, "balance": (GAIN_ONE, 0)}
        if rig.rig:
            found["maps"] = rig.rig.rig if self.value("rectify") else None
            if self.value("balance") == FIXED:
                found["balance"] = self.value("fixed_gain"), self.value("fixed_offset")
        return found

    async def write(self, name: str, value: int) -> None:
        """Write a setting."""
        await self.rig.write(name, value)
        self.values[name] = value

    async def request(self, frame: bytes) -> None:
        """Send a request that is not a read; golden has the reply."""
        expected, written = answer(self.registers, {}, frame)
        if "clear_counters" in written:
            self._counters_cleared(more=2)
        reply = await self.rig.reply(frame)
        assert reply == expected, f"the reply to {frame.hex(' ')} is {reply}, not {expected}"
        if reply.status in (Status.BAD_SUM, Status.UNKNOWN_OPERATION):
            await self.rig.silence(self.rig.QUIET_BITS)     # only then is the next request one
            assert reply.status is Status.UNKNOWN_OPERATION or await self.rig.read("uart_errors") > 0
        for name, value in written.items():
            if self.registers[name].kind is Kind.SETTING:
                self.values[name] = value
            self.maps_known &= name != "map_swap"

    async def _restore(self) -> None:
        """Settings that make a picture which golden does not know are set back."""
        for register in self.registers.of(Kind.SETTING):
            name = register.name
            kept = name in SHOWN or name in self.rig.config.settings or name == "keep" or name.startswith("map_")
            if not kept and self.value(name) != register.reset:
                await self.write(name, register.reset)
        if self.rig.rig and self.value("balance") == AUTO:      # depends on the scenes before
            await self.write("balance", FIXED)
        if self.rig.rig and not self.maps_known and self.value("rectify"):
            await self.write("rectify", 0)

    def _counters_cleared(self, fewer: int = 0, more: int = 0) -> None:
        self.rig.cut = 0
        for ledger in self.ledgers.values():
            self.frames += ledger.frames
            ledger.begin(fewer, more)

    # Disturbances.

    async def faults(self, drawn: Disturbance) -> None:
        """Faults of cameras, host, chips or memory at a time: each is counted, and the pictures are exact again."""
        rig = self.rig
        strikes, counters, dark = [], [], 0
        for number, side in enumerate(SIDES):
            if side in drawn:
                names = drawn[side]
                if names == [DOMAIN_RESET]:
                    strikes.append(camera_reset(side))
                    self.ledgers[side].unsure()
                    continue
                strikes.append(film(side, *names))
                fault = CAMERA_FAULTS[names[0]]
                counters += [f"{side}_{fault.counter}"] if fault.counter else []
                dark |= (not fault.kept) << number
        for where in ("host", "memory"):
            if where in drawn:
                strikes.append(FAULTS[drawn[where]].strike)
                counters.append(FAULTS[drawn[where]].counter)
        before = [await rig.read(name) for name in counters]
        await Timer(drawn["delay"], "ps")
        self.dark = 0
        for task in [cocotb.start_soon(strike(rig)) for strike in strikes]:
            await task
        await self.recovered()
        for name, count in zip(counters, before, strict=True):
            assert await rig.read(name) > count, f"{name} has not counted"
        assert not dark & ~self.dark, f"LEDs {dark & ~self.dark:02b} of the cameras' signals have stayed on"

    async def recovered(self, *, every: bool = True) -> None:
        """Another scene is shown exactly."""
        self.rig.change(**self.settings())
        await self.rig.shows(RECOVERY, every=every)

    async def reset(self, drawn: Disturbance) -> None:
        """The board's reset: all settings are as at first, and the memory is initialised in time or late."""
        rig = self.rig
        if drawn["in_request"]:
            rig.host.send(encode_request(Request(Operation.READ, 0)))
            for _ in range(round(drawn["delay"] * CLOCK_HZ / 1e12) % 2000):
                await rig.exchange()
        else:
            await Timer(drawn["delay"], "ps")
        rig.check()     # what was shown with the settings that are lost now
        await rig.reset(drawn["clocks"], drawn["init"])
        self._counters_cleared(1, 2)
        self.values.clear()
        if drawn["in_request"]:
            rig.host.send_level(1, rig.QUIET_BITS)
            while not rig.host.idle:
                await rig.exchange()
        elif drawn["init"] > 5000:
            assert await rig.read("memory_ready") == 0 and int(self.dut.leds.value) >> 4 & 1 == 0
        await rig.until_reads("memory_ready", 1)
        assert await rig.read("identity") == IDENTITY
        await self._first_pictures()

    async def writes(self, drawn: Disturbance) -> None:
        """Requests to any register, right or wrong, and what the settings are then."""
        for frame in drawn["requests"]:
            await self.request(bytes.fromhex(frame))
        await self._restore()
        for register in self.registers.of(Kind.SETTING):
            if register.name in self.values:
                found = await self.rig.read(register.name)
                assert found == self.value(register.name), f"{register.name} is {found}, not {self.value(register.name)}"
        await self.recovered(every=False)

    async def pause(self, drawn: Disturbance) -> None:
        """Nothing happens for a while, or the picture is held while the scene is another one."""
        rig = self.rig
        if drawn["hold"]:
            await self.write("hold", 1)
            await rig.shows(RECOVERY)
            still = rig.golden(rig.pair, rig.settings)
            rig.change()
        await Timer(drawn["delay"], "ps")
        if drawn["hold"]:
            assert all((picture == still).all() for picture in rig.monitor.pictures), "the picture has changed while it was held"
            await self.write("hold", 0)
        await self.recovered()

    # Accounts.

    async def settle(self) -> None:
        """All is well; then the cameras stop, and each frame that they have sent must be in a counter."""
        rig = self.rig
        for name in ("decoder_state", "transmitter_state", "left_locked", "right_locked", "left_signal", "right_signal"):
            await rig.until_reads(name, 1)
        assert await rig.read("matcher_error") == 0
        for camera in rig.films.values():
            camera.faults.extend([NO_CLOCK] * PATIENCE)
        first = {side: camera.frames for side, camera in rig.films.items()}
        # The frame in transmission ends; those that wait for a partner expire after 2.5 frames.
        await rig.until(lambda: all(camera.frames >= first[side] + 4 for side, camera in rig.films.items()))
        pairs, underflows = await rig.read("pairs"), await rig.read("display_underflows")
        for side, ledger in self.ledgers.items():
            ledger.check(side, pairs, [await rig.read(f"{side}_{name}") for name in COUNTERS])
        assert rig.cut <= underflows, f"{rig.cut} pictures were cut, and display_underflows is {underflows}"
        lost = [await rig.read(name) for name in ("pictures_dropped", "pictures_abandoned")]
        assert sum(lost) <= pairs, f"{lost} pictures were dropped and abandoned, of {pairs} pairs"
        await rig.write("clear_counters", 1)
        self._counters_cleared()

    async def resume(self) -> None:
        """The cameras send again."""
        for camera in self.rig.films.values():
            camera.faults.clear()
        await self.recovered()


@cocotb.test()
async def soak(dut):
    """Rounds of disturbances; after each the cameras stop, the accounts are settled, and the process's memory is sampled."""
    schedule = json.loads(Path(os.environ["SCHEDULE"]).read_text())
    report = Path(os.environ["REPORT"])
    soak = Soak(dut, int(os.environ["SEED"]))
    bound = round(PATIENCE * soak.rig.camera.frame_seconds * 1e12)
    await with_timeout(soak.start(), bound, "ps")
    told: dict[str, Any] = {"recovered": 0, "resident": []}
    for number, each_round in enumerate(schedule):
        if number:
            await with_timeout(soak.resume(), bound, "ps")
        for drawn in each_round:
            dut._log.info("%s", drawn)
            await with_timeout(getattr(soak, drawn["kind"])(drawn), bound, "ps")
            told["recovered"] += 1
            report.write_text(json.dumps(told))     # for a run that fails
        await with_timeout(soak.settle(), bound, "ps")
        told["resident"].append((soak.frames // 2, resident_bytes()))
    told |= {"frames": soak.frames // 2, "shown": soak.rig.monitor.frames, "seconds": round(time.process_time(), 1)}
    report.write_text(json.dumps(told))
