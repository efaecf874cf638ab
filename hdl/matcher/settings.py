"""Settings of a matcher that may change from frame to frame: which there are, and what they are until they are set."""

from amaranth.hdl import Signal
from amaranth.lib.wiring import In

from golden.config import IN_USE_BITS, MINIMUM_BITS, WEIGHT_BITS, Cost, MatcherConfig


__all__ = ["defaults", "held_settings", "setting_ports"]


_BITS = {"u1": WEIGHT_BITS, "u2": WEIGHT_BITS, "u3": WEIGHT_BITS, "in_use": IN_USE_BITS}
_FUSED_BITS = {"minimum": MINIMUM_BITS, "check": 1, "fill": 1, "median": 1}


def setting_ports(config: MatcherConfig):
    """Members of a signature: each setting of the matcher under its name, and ``set_parameters``, which takes them all.

    ``u1, u2, u3``: weights of the left, upper and lower neighbour. ``in_use``: labels in use, ``1 .. D``. With the cost ``FUSED`` also
    ``minimum``: least disparity, pixels; ``check, fill, median``: stages of the refinement; one that is off costs its time all the same.
    """
    bits = _BITS | (_FUSED_BITS if config.cost is Cost.FUSED else {})
    return {name: In(width) for name, width in {**bits, "set_parameters": 1}.items()}


def defaults(config: MatcherConfig):
    """What the settings are until they are set, by name."""
    values = dict(zip(("u1", "u2", "u3"), config.weights)) | {"in_use": config.labels_in_use}
    if config.cost is Cost.FUSED:
        stages = config.refinement
        values |= {"minimum": config.minimum, "check": stages.check, "fill": stages.fill, "median": stages.median}
    return values


def held_settings(m, component, config: MatcherConfig):
    """Registers that take the settings at ``component.set_parameters``, by name."""
    held = {}
    for name, default in defaults(config).items():
        port = getattr(component, name)
        held[name] = Signal.like(port, name=f"{name}_set", init=int(default))
        with m.If(component.set_parameters):
            m.d.sync += held[name].eq(port)
    return held
