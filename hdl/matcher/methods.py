"""The methods and their parts. No other gateware depends on which methods there are."""

from dataclasses import dataclass

from golden.config import Engine, Fused, MatcherConfig, OnePass, Recursive

from .census import BlindCensusStage, CensusStage
from .lead import Lead
from .recursive.engine import RecursiveEngine
from .refine.border_fill import BorderFill
from .refine.fill import Fill
from .refine.median import Median
from .refine.weighted_median import WeightedMedian
from .sequential.bec import Bec
from .sequential.engine import SequentialEngine
from .shift import RightShift
from .stage import CostArray, LabelOutput, Stage
from .streaming.bec_array import BecArray
from .streaming.engine import StreamingEngine
from .streaming.fused_array import FusedArray
from .streaming.label_output import CheckedLabel, PlainLabel


__all__ = ["METHODS", "Composition", "Parts", "compose"]


@dataclass(frozen=True)
class Parts:
    """The parts of a method, in the order of the stream.

    Parameters
    ----------
    costs : type of CostArray or None
        Of the streaming engine.
    label_output : type of LabelOutput
        Turns a selected label into the engine's output.
    engine : type or None
        In place of the streaming engine with such an array.
    pixels, columns, labels : tuple of types of Stage
        Stages in front of the line store, between it and the engine, and behind the engine.
    """
    costs: type[CostArray] | None = None
    label_output: type[LabelOutput] = PlainLabel
    engine: type[RecursiveEngine] | None = None
    pixels: tuple[type[Stage], ...] = ()
    columns: tuple[type[Stage], ...] = ()
    labels: tuple[type[Stage], ...] = ()


#: A method's class to its parts. A third method is a row here, and one in :data:`golden.matcher.matcher.MATCHERS`.
METHODS: dict[type, Parts] = {
    OnePass: Parts(costs=BecArray),
    Fused: Parts(pixels=(RightShift,), columns=(CensusStage,), costs=FusedArray, label_output=CheckedLabel, labels=(Fill, Median)),
    Recursive: Parts(pixels=(RightShift,), columns=(BlindCensusStage,), engine=RecursiveEngine, labels=(BorderFill, WeightedMedian)),
}


@dataclass(frozen=True)
class Composition:
    """The parts of a configuration's matcher: stages, and an engine between them."""
    pixels: tuple[Stage, ...]
    columns: tuple[Stage, ...]
    engine: StreamingEngine | SequentialEngine | RecursiveEngine
    labels: tuple[Stage, ...]

    @property
    def stages(self) -> tuple[Stage, ...]:
        """All stages, in the order of the stream."""
        return (*self.pixels, *self.columns, *self.labels)


def compose(config: MatcherConfig) -> Composition:
    """The parts of a configuration, constructed; :class:`ValueError` if there is no gateware for it."""
    parts = METHODS[type(config.method)]
    if config.minimum and "minimum" not in config.settings:
        raise ValueError(f"the method {config.method.name} has gateware for the least disparity 0 only, not {config.minimum}")
    in_front: tuple[type[Stage], ...] = (Lead, *parts.pixels) if config.lead else parts.pixels
    pixels, labels = (tuple(stage(config) for stage in stages) for stages in (in_front, parts.labels))
    columns = tuple(stage(config) for stage in parts.columns)
    if parts.engine:
        return Composition(pixels, columns, parts.engine(config), labels)
    if config.engine is Engine.STREAMING and parts.costs:
        engine = StreamingEngine(config, parts.costs, parts.label_output, registered=bool(parts.labels))
        return Composition(pixels, columns, engine, labels)
    bec = Bec(config)
    return Composition(pixels, (bec,), SequentialEngine(config, bec), labels)
