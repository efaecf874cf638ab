"""Settings of a matcher as gateware: ports, and registers that hold them."""

from amaranth.hdl import Module, Shape, Signal, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Member

from golden.config import MINIMUM_BITS, MatcherConfig, Setting


__all__ = ["held_settings", "minimum_shape", "setting_ports", "setting_shape"]


def setting_shape(setting: Setting) -> Shape:
    """Shape of a setting's port: signed if its least value is negative."""
    return signed(setting.bits) if setting.signed else unsigned(setting.bits)


def minimum_shape(config: MatcherConfig) -> Shape:
    """Shape of the least disparity: signed in gateware that was built with a negative one."""
    return signed(MINIMUM_BITS + 1) if config.lead else unsigned(MINIMUM_BITS)


def setting_ports(config: MatcherConfig) -> dict[str, Member]:
    """Members of a signature: each of :attr:`golden.config.MatcherConfig.settings` under its name, and ``apply_settings``.

    A stage of the refinement that is switched off keeps its latency.
    """
    return {**{name: In(setting_shape(setting)) for name, setting in config.settings.items()}, "apply_settings": In(1)}


def held_settings(m: Module, component: wiring.Component, config: MatcherConfig) -> dict[str, Signal]:
    """Registers that sample the settings at ``component.apply_settings``, by name."""
    held = {}
    for name, setting in config.settings.items():
        port = getattr(component, name)
        held[name] = Signal.like(port, name=f"{name}_set", init=setting.default)
        with m.If(component.apply_settings):
            m.d.sync += held[name].eq(port)
    return held
