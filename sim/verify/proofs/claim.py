"""A claim about a component, as a circuit: the component, its surroundings with free inputs, and assertions on what it does."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from amaranth import *
from amaranth.hdl import Assert, Assume, Elaboratable, ShapeLike, ValueLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In
from amaranth.sim import Simulator

from sim.kit.formal import Circuit


__all__ = ["Claim", "Port", "ports_of", "replayed", "streams_of"]


class Port(NamedTuple):
    """A port of a component, or a stream of it: its name with those of the signatures that it is in, and whether the component drives it
    (a stream: its payload)."""
    name: str
    is_output: bool
    value: Any
    is_stream: bool


def _members(signature: Any, interface: Any, prefix: str) -> Iterator[Port]:
    for name, member in signature.members.items():
        places = [(f"{prefix}{name}", getattr(interface, name))]
        for dimension in member.dimensions:
            places = [(f"{place}[{n}]", value[n]) for place, value in places for n in range(dimension)]
        for place, value in places:
            if member.is_port:
                yield Port(place, member.flow is not In, value, False)
            elif set(member.signature.members) == {"payload", "valid", "ready"}:
                yield Port(place, member.signature.members["valid"].flow is not In, value, True)
            else:
                yield from _members(member.signature, value, f"{place}.")


def ports_of(component: wiring.Component) -> list[Port]:
    """Streams of a component, and its ports that belong to none."""
    return list(_members(component.signature, component, ""))


def streams_of(component: wiring.Component) -> list[Port]:
    """Streams of a component."""
    return [port for port in ports_of(component) if port.is_stream]


def kept_of(word: Any, payload: Any, bits: int | None) -> list[Value]:
    """Of a word that is like a stream's payload: of each field the lowest ``bits`` bits, all of them if ``None``."""
    shape = payload.shape()
    if not isinstance(shape, data.Layout):
        return [Value.cast(word)[:bits]]
    view = data.View(shape, word)
    return [part for name, field in shape for part in kept_of(Value.cast(view[name]), data.View(field.shape, Signal(field.width))
            if isinstance(field.shape, data.Layout) else Value.cast(view[name]), bits)]


class Claim(Elaboratable, ABC):
    """A component in its surroundings.

    Members
    -------
    inputs : list of Signal
        Free in every cycle.
    witness : Signal
        High when what the claim is about has happened: if it cannot become high, the claim says nothing.
    """
    def __init__(self) -> None:
        self.inputs: list[Signal] = []
        #: For a simulator: what is promised is told by signals only, because an assertion is violated while values settle.
        self.simulated = False
        self.promises: list[tuple[str, Signal]] = []
        self.witness = Signal()
        #: Outputs of :class:`sim.kit.formal.Circuit`.
        self.outputs: dict[str, Value] = {}

    @abstractmethod
    def build(self, m: Module) -> None:
        """Add component, surroundings and assertions to a module."""

    @cached_property
    def module(self) -> Module:
        """All of it; only then are the inputs known."""
        m = Module()
        self.build(m)
        return m

    def elaborate(self, platform: object) -> Module:
        return self.module

    def circuit(self, folder: Path) -> Circuit:
        """The claim for the prover."""
        assert self.module
        return Circuit(self, self.inputs, folder, witness=self.witness, outputs=self.outputs)

    def free(self, shape: ShapeLike, name: str) -> Signal:
        """An input of any value in every cycle."""
        signal = Signal(shape, name=name)
        self.inputs.append(signal)
        return signal

    def promise(self, m: Module, value: ValueLike, name: str) -> None:
        """Assert, under the conditions of the module where this is called."""
        holds = Signal(init=1, name=f"holds_{len(self.promises)}")
        self.promises.append((name, holds))
        m.d.comb += holds.eq(Value.cast(value).bool())
        if not self.simulated:
            m.d.comb += Assert(holds)

    def presume(self, m: Module, *values: ValueLike) -> None:
        """Assume what the surroundings keep."""
        if not self.simulated:
            m.d.comb += [Assume(value) for value in values]

    def constant(self, m: Module, shape: ShapeLike, name: str) -> Signal:
        """Any value, the same in all cycles."""
        given, held, begun = self.free(shape, name), Signal(shape, name=f"{name}_held"), Signal(name=f"{name}_begun")
        value = Signal(shape, name=f"{name}_constant")
        m.d.sync += [begun.eq(1), held.eq(value)]
        m.d.comb += value.eq(Mux(begun, held, given))
        return value

    def offer(self, m: Module, stream: Any, name: str, bits: int | None = None, *, when: Value | int = 1, holds: bool = True) -> None:
        """Drive a stream that the component accepts, by its rules: an offer holds until it is accepted, unless ``holds`` is false."""
        payload, stalled = Value.cast(stream.payload), Signal(name=f"{name}_stalled")
        held, offered = Signal(len(payload), name=f"{name}_held"), Signal(len(payload), name=f"{name}_offered")
        kept = kept_of(offered, stream.payload, bits)
        m.d.comb += [
            stream.valid.eq(stalled | (self.free(1, f"{name}.valid") & when)),
            Cat(kept).eq(self.free(sum(map(len, kept)), f"{name}.payload")), payload.eq(Mux(stalled, held, offered)),
        ]
        m.d.sync += [stalled.eq(stream.valid & ~stream.ready if holds else 0), held.eq(payload)]

    def take(self, m: Module, stream: Any, name: str, *, when: Value | int = 1) -> None:
        """Drive ``ready`` of a stream that the component sends."""
        m.d.comb += stream.ready.eq(self.free(1, f"{name}.ready") & when)

    def surround(self, m: Module, component: wiring.Component, *, bits: int | None = None, constant: Sequence[str] = (),
                 skip: Sequence[str] = (), holds: bool = True) -> None:
        """Drive all inputs of a component: streams as :meth:`offer` does, and the others freely.

        ``bits``: of each field of a payload that are not always 0. ``constant``: inputs that do not change. ``skip``: ports that the
        caller drives.
        """
        for port in ports_of(component):
            if port.name in skip:
                continue
            if port.is_stream and not port.is_output:
                self.offer(m, port.value, port.name, bits, holds=holds)
            elif port.is_stream:
                self.take(m, port.value, port.name)
            elif not port.is_output:
                value = Value.cast(port.value)
                given = self.constant(m, len(value), port.name) if port.name in constant else self.free(len(value), port.name)
                m.d.comb += value.eq(given)


def replayed(claim: Claim, trace: Sequence[Mapping[str, int]]) -> str:
    """What Amaranth's simulator says of a counterexample: which promise is broken.

    Parameters
    ----------
    claim : Claim
        Anew.
    trace : list of dict
        As of :class:`sim.kit.formal.Verdict`.
    """
    claim.simulated = True
    simulator = Simulator(claim.module)
    simulator.add_clock(1e-6)
    broken: list[str] = []

    async def inputs(ctx):
        for cycle in trace:
            for signal in claim.inputs:
                ctx.set(signal, cycle[signal.name])
            *_, holds = await ctx.tick().sample(Cat(holds for _, holds in claim.promises))
            broken[:] = [name for place, (name, _) in enumerate(claim.promises) if not holds >> place & 1]

    simulator.add_testbench(inputs)
    simulator.run()
    return f"broken in the last cycle: {', '.join(broken) or 'nothing, in the simulator'}"
