"""Registers behind an access port: one component, whichever line or bus the host uses."""

from collections.abc import Container

from amaranth import *
from amaranth.hdl import ShapeLike, ValueLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.host.protocol import Status
from golden.host.registers import Kind, Register, RegisterMap


__all__ = ["AccessPort", "ActionLayout", "RegisterFile", "SettingLayout", "StatusLayout"]


def _shape(register: Register) -> ShapeLike:
    return signed(register.width) if register.signed else register.width


class SettingLayout(data.StructLayout):
    """Each setting under its name."""
    def __init__(self, registers: RegisterMap):
        super().__init__({register.name: _shape(register) for register in registers.of(Kind.SETTING)})


class ActionLayout(data.StructLayout):
    """Each action under its name."""
    def __init__(self, registers: RegisterMap):
        super().__init__({register.name: 1 for register in registers.of(Kind.ACTION)})


class StatusLayout(data.StructLayout):
    """Each status and each counter under its name, but those in ``without``."""
    def __init__(self, registers: RegisterMap, without: Container[str] = ()):
        given = [register for register in registers.of(Kind.STATUS, Kind.COUNTER) if register.name not in without]
        super().__init__({register.name: _shape(register) for register in given})


class AccessPort(wiring.Signature):
    """A read or a write of a register, from the accessor's view; see :class:`RegisterFile`.

    Members
    -------
    address : Out(8)
    write : Out(1)
        A write, not a read.
    value : Out(bits)
        To be written.
    commit : Out(1)
        Carries a write out.
    found : In(bits)
        The value read; negative ones as two's complement.
    status : In(Status)
        ``OK``, ``UNKNOWN_ADDRESS``, ``READ_ONLY`` or ``OUT_OF_RANGE``.
    """
    def __init__(self, bits: int):
        super().__init__({
            "address": Out(8),
            "write": Out(1),
            "value": Out(bits),
            "commit": Out(1),
            "found": In(bits),
            "status": In(Status),
        })


class RegisterFile(wiring.Component):
    """Holds the settings, and carries out accesses.

    Golden: :func:`golden.host.registers.access`.

    Timing: ``found`` and ``status`` are those of ``address``, ``write`` and ``value`` of the cycle before; all bits of ``found`` are of the
    same moment. ``commit`` with ``write`` carries the write out, if the status is ``OK``: an action is high in that cycle, a setting
    changes in the next one. Address, value and write must hold from the cycle before ``commit``.

    Parameters
    ----------
    registers : RegisterMap
    bits : int
        Of a value at the port, at least 16.

    Members
    -------
    access : In(AccessPort(bits))
    settings : Out(SettingLayout(registers))
        May change in any cycle; to be sampled at the start of a frame.
    actions : Out(ActionLayout(registers))
        High for one cycle each.
    status : In(StatusLayout(registers))
        May change in any cycle.
    """
    def __init__(self, registers: RegisterMap, bits: int = 16):
        if bits < 16:
            raise ValueError(f"an access to the register file must have at least 16 bits, not {bits!r}")
        self.registers = registers
        self.bits = bits
        super().__init__({
            "access": In(AccessPort(bits)),
            "settings": Out(SettingLayout(registers), init={register.name: register.reset for register in registers.of(Kind.SETTING)}),
            "actions": Out(ActionLayout(registers)),
            "status": In(StatusLayout(registers)),
        })

    def _value(self, register: Register) -> ValueLike:
        """The value that a read of ``register`` returns."""
        match register.kind:
            case Kind.CONSTANT:
                return register.reset
            case Kind.SETTING:
                return self.settings[register.name]
            case Kind.ACTION:
                return 0
        return self.status[register.name]

    def elaborate(self, platform: object) -> Module:
        m = Module()
        port     = self.access
        known    = Signal(reset_less=True)
        writable = Signal(reset_less=True)
        in_range = Signal(reset_less=True)
        found    = Signal(self.bits, reset_less=True)
        write    = Signal()
        m.d.comb += port.found.eq(found)
        m.d.sync += [known.eq(0), writable.eq(0)]
        with m.Switch(port.address):
            for register in self.registers:
                with m.Case(register.address):
                    m.d.sync += [known.eq(1), found.eq(self._value(register))]
                    if register.writable:
                        number = port.value.as_signed() if register.signed else port.value
                        # Comparisons that are always true are left out.
                        above = number >= register.minimum if register.minimum else 1
                        below = number <= register.maximum if register.maximum < (1 << self.bits) - 1 else 1
                        m.d.sync += [writable.eq(1), in_range.eq(above & below)]
                    if register.kind is Kind.SETTING:
                        with m.If(write):
                            m.d.sync += self.settings[register.name].eq(port.value)
                    elif register.kind is Kind.ACTION:
                        m.d.comb += self.actions[register.name].eq(write)

        with m.If(~known):
            m.d.comb += port.status.eq(Status.UNKNOWN_ADDRESS)
        with m.Elif(port.write & ~writable):
            m.d.comb += port.status.eq(Status.READ_ONLY)
        with m.Elif(port.write & ~in_range):
            m.d.comb += port.status.eq(Status.OUT_OF_RANGE)
        with m.Else():
            m.d.comb += [port.status.eq(Status.OK), write.eq(port.write & port.commit)]
        return m
