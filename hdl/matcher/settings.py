"""Settings of a matcher as gateware: ports, and registers that hold them."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Member

from golden.config import MatcherConfig


__all__ = ["held_settings", "setting_ports"]


def setting_ports(config: MatcherConfig) -> dict[str, Member]:
    """Members of a signature: each of :attr:`golden.config.MatcherConfig.settings` under its name, and ``apply_settings``.

    A stage of the refinement that is switched off keeps its latency.
    """
    return {**{name: In(setting.bits) for name, setting in config.settings.items()}, "apply_settings": In(1)}


def held_settings(m: Module, component: wiring.Component, config: MatcherConfig) -> dict[str, Signal]:
    """Registers that sample the settings at ``component.apply_settings``, by name."""
    held = {}
    for name, setting in config.settings.items():
        port = getattr(component, name)
        held[name] = Signal.like(port, name=f"{name}_set", init=setting.default)
        with m.If(component.apply_settings):
            m.d.sync += held[name].eq(port)
    return held
