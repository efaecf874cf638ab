"""Timing diagrams of the site: recorded from the gateware itself in Amaranth's simulator, drawn by WaveDrom."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import wavedrom
from amaranth.sim import Simulator

from hdl.matcher.frame_timing import FrameTiming
from hdl.matcher.stream import FLAGS, PixelPair
from hdl.parts.delay import SkidRegister


__all__ = ["diagrams"]


#: Shown in a diagram: the size of its frame, in pixels.
WIDTH, HEIGHT = 3, 2

Trace = dict[str, list[Any]]


def _record(component: Any, cycles: int, drive: Callable[[Any, int], None], sample: Callable[[Any], Mapping[str, Any]]) -> Trace:
    """What ``sample`` gives in each cycle, after ``drive`` has set the inputs of that cycle, by name."""
    trace: Trace = {}

    async def bench(ctx: Any) -> None:
        for cycle in range(cycles):
            drive(ctx, cycle)
            for name, value in sample(ctx).items():
                trace.setdefault(name, []).append(value)
            await ctx.tick()

    simulator = Simulator(component)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    return trace


def _words() -> list[dict[str, int]]:
    """The words of a frame; the grey level tells the place: 12 is column 2 of line 1."""
    return [{"left": 10 * y + x, "first": x == y == 0, "last": x == WIDTH - 1, "end": x == WIDTH - 1 and y == HEIGHT - 1}
            for y in range(HEIGHT) for x in range(WIDTH)]


def _stream(ctx: Any, stream: Any, name: str) -> dict[str, Any]:
    """The signals of a stream; its payload is ``None`` while ``valid`` is low."""
    valid = ctx.get(stream.valid)
    payload = {each: ctx.get(stream.payload[each]) if valid else None for each in ("left", *FLAGS)}
    left = payload.pop("left")
    return {f"{name}.valid": valid, f"{name}.ready": ctx.get(stream.ready), f"{name}.p.left": None if left is None else f"{left:02}",
            **{f"{name}.p.{each}": value for each, value in payload.items()}}


def back_pressure() -> Trace:
    """A frame through a register of a stream; its sender pauses in one cycle, its receiver stalls in three."""
    component = SkidRegister(PixelPair())
    words, sent = _words(), 0
    offers, accepts = "111011111110", "111110001111"    # by cycle; an offer is kept until it is accepted

    def drive(ctx: Any, cycle: int) -> None:
        offer = offers[cycle] == "1" and sent < len(words)
        ctx.set(component.i.valid, offer)
        if offer:
            ctx.set(component.i.payload, {"right": 0, **words[sent]})
        ctx.set(component.o.ready, accepts[cycle] == "1")

    def sample(ctx: Any) -> dict[str, Any]:
        nonlocal sent
        found = {**_stream(ctx, component.i, "i"), **_stream(ctx, component.o, "o")}
        sent += found["i.valid"] and found["i.ready"]
        return found

    return _record(component, len(offers), drive, sample)


def frame_timing() -> Trace:
    """A frame under frame, line and pixel valid, with a cycle without a pixel, as a stream."""
    component = FrameTiming(depth=8)
    inputs = {"frame_valid": "0111111111000000", "line_valid": "0111101110000000", "pixel_valid": "0110101110000000"}
    words = iter(_words())

    def drive(ctx: Any, cycle: int) -> None:
        for name, levels in inputs.items():
            ctx.set(getattr(component, name), levels[cycle] == "1")
        if inputs["pixel_valid"][cycle] == "1":
            ctx.set(component.left, next(words)["left"])
        ctx.set(component.o.ready, 1)

    def sample(ctx: Any) -> dict[str, Any]:
        levels = {name: ctx.get(getattr(component, name)) for name in inputs}
        return {**levels, "left": f"{ctx.get(component.left):02}" if levels["pixel_valid"] else None, **_stream(ctx, component.o, "o")}

    return _record(component, len(inputs["frame_valid"]), drive, sample)


def _lane(name: str, values: Sequence[Any]) -> dict[str, Any]:
    """A signal as WaveDrom has it: a level, a value in a box, or undefined."""
    wave, data = "", []
    for before, value in zip([object(), *values], values, strict=False):
        if value == before:
            wave += "."
        elif isinstance(value, str):
            wave += "="
            data.append(value)
        else:
            wave += "x" if value is None else str(int(value))
    return {"name": name, "wave": wave, "data": data}


def svg(trace: Trace) -> bytes:
    """A diagram with its clock and the numbers of the cycles."""
    cycles = len(next(iter(trace.values())))
    signals = [{"name": "clk", "wave": "p" + "." * (cycles - 1)}, *(_lane(*each) for each in trace.items())]
    return wavedrom.render(json.dumps({"signal": signals, "head": {"tick": 0}})).tostring().encode("utf-8")


def diagrams() -> dict[str, bytes]:
    """All diagrams, by the names of their files."""
    return {f"{record.__name__}.svg": svg(record()) for record in (back_pressure, frame_timing)}
