"""A core as packages describe it: its files, its ports, the buses that they form, and its registers."""

import enum
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from golden.host.registers import RegisterMap


__all__ = ["Bus", "Core", "Port", "Protocol", "RegisterSpace", "Reset", "find_buses"]


#: Direction, ``input`` or ``output``, and width in bits.
Port = tuple[str, int]


class Protocol(enum.Enum):
    """Protocols of buses: the signals that a bus must have, and those that it may have, each the end of a port's name.

    The first signal tells whether the core is the source of a stream: it is driven by the source. ``NATIVE`` is the stream of
    :mod:`amaranth.lib.stream` with its fields in one port.
    """
    AXI_STREAM = ("tvalid", "tready", "tdata"), ("tlast", "tuser", "tkeep", "tstrb")
    AXI_LITE = (("awvalid", "awready", "awaddr", "wvalid", "wready", "wdata", "wstrb", "bvalid", "bready", "bresp", "arvalid", "arready",
                 "araddr", "rvalid", "rready", "rdata", "rresp"), ("awprot", "arprot"))
    AVALON_STREAM = ("valid", "ready", "data"), ("startofpacket", "endofpacket")
    AVALON_MEMORY = (("write", "read", "address", "writedata", "readdata", "waitrequest"),
                     ("byteenable", "readdatavalid", "response", "writeresponsevalid"))
    NATIVE = ("valid", "ready", "payload"), ()

    @property
    def required(self) -> tuple[str, ...]:
        return self.value[0]

    @property
    def signals(self) -> tuple[str, ...]:
        return self.value[0] + self.value[1]

    @property
    def streams(self) -> bool:
        """Whether it is a stream; a host reaches registers by the other ones."""
        return self in (Protocol.AXI_STREAM, Protocol.AVALON_STREAM, Protocol.NATIVE)


class Bus(NamedTuple):
    """Ports that form a bus.

    Parameters
    ----------
    name : str
        What all its ports begin with, such as ``s_axis``.
    protocol : Protocol
    drives : bool
        Whether the core drives it: it is the source of a stream, or the host of registers.
    ports : dict
        Signal of the protocol to port.
    """
    name: str
    protocol: Protocol
    drives: bool
    ports: dict[str, str]


class Reset(NamedTuple):
    """A reset port, and whether it is active low."""
    port: str
    active_low: bool


def find_buses(ports: Mapping[str, Port]) -> list[Bus]:
    """The buses that ports form by their names, in the order of their first ports.

    Examples
    --------
    >>> [bus] = find_buses({"clk": ("input", 1), "i_valid": ("input", 1), "i_ready": ("output", 1), "i_payload": ("input", 19)})
    >>> bus.name, bus.protocol, bus.drives
    ('i', <Protocol.NATIVE: (('valid', 'ready', 'payload'), ())>, False)
    """
    def found() -> Iterator[Bus]:
        prefixes = dict.fromkeys(name[:at] for name in ports for at, letter in enumerate(name) if letter == "_")
        for prefix in prefixes:
            for protocol in Protocol:
                bus = {signal: f"{prefix}_{signal}" for signal in protocol.signals if f"{prefix}_{signal}" in ports}
                if bus.keys() >= {*protocol.required}:
                    yield Bus(prefix, protocol, ports[bus[protocol.required[0]]][0] == "output", bus)

    return list(found())


@dataclass(frozen=True)
class RegisterSpace:
    """Registers as a host addresses them.

    Parameters
    ----------
    registers : RegisterMap
    word_bytes : int
        Of a register; its byte offset is its address times this.
    title : str
        What they are the registers of, and how they are reached, without a full stop.
    """
    registers: RegisterMap
    word_bytes: int
    title: str

    @property
    def word_bits(self) -> int:
        return 8 * self.word_bytes

    @property
    def span(self) -> int:
        """Bytes of the whole space: addresses have eight bits."""
        return 256 * self.word_bytes


@dataclass(frozen=True)
class Core:
    """A core to be packed.

    Parameters
    ----------
    name : str
        Of the top module.
    version : str
        Of this project, such as ``0.2.0``.
    description : str
        A sentence without its full stop.
    files : sequence of str
        Names of its Verilog files, ``.v``, and of waivers for Verilator, ``.vlt``; packages lie in the same folder.
    ports : mapping
        Of the top module, name to direction and width.
    payloads : mapping
        Fields of a port: name to lowest and highest bit.
    space : RegisterSpace or None
        Its registers, if a bus leads to them.
    """
    name: str
    version: str
    description: str
    files: Sequence[str]
    ports: Mapping[str, Port]
    payloads: Mapping[str, Mapping[str, tuple[int, int]]]
    space: RegisterSpace | None = None

    @property
    def verilog(self) -> list[str]:
        return [name for name in self.files if name.endswith(".v")]

    @property
    def clock(self) -> str:
        """The clock's port."""
        return next(name for name in ("clk", "aclk") if name in self.ports)

    @property
    def reset(self) -> Reset:
        """The reset's port."""
        return next(Reset(name, name.endswith("n")) for name in ("rst", "reset", "aresetn", "reset_n") if name in self.ports)

    @property
    def buses(self) -> list[Bus]:
        return find_buses(self.ports)

    @property
    def others(self) -> dict[str, Port]:
        """Ports that are neither clock, reset nor of a bus."""
        taken = {self.clock, self.reset.port, *(port for bus in self.buses for port in bus.ports.values())}
        return {name: port for name, port in self.ports.items() if name not in taken}
