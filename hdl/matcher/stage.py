"""The contracts of a matcher's parts: stages, arrays of costs, label outputs.

A method is a tuple of such parts, see :mod:`hdl.matcher.methods`. They are composed by these attributes alone, whichever method it is.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from amaranth.lib import data, wiring

from golden.config import MatcherConfig

from .settings import setting_shape
from .stream import FLAGS


__all__ = ["CostArray", "LabelOutput", "Selected", "Stage"]


class Stage(wiring.Component, ABC):
    """A stage on the stream of pixels, of columns or of labels; constructed from a :class:`MatcherConfig` alone.

    Members ``i`` and ``o`` are streams; any further members are settings.

    Attributes
    ----------
    name : str
        Of the submodule.
    settings : mapping of str to str
        Member to the setting of :attr:`golden.config.MatcherConfig.settings` that drives it. Sampled with the word marked ``first``.
    lines : int
        Scanlines from a word to its result.
    line_clocks : int
        Cycles that a line takes beyond its pixels; of stages on columns those that it adds to the line store's, of stages on pixels the
        columns that it adds to a line.
    frame_lines : int
        Lines that a frame takes beyond its height.
    rows : int
        Of a stage on columns: lines that a column must have; 3 elsewhere.
    """
    name: ClassVar[str]
    settings: ClassVar[Mapping[str, str]] = {}
    lines: ClassVar[int] = 0
    line_clocks: int = 0
    frame_lines: int = 0
    rows: int = 3

    @property
    @abstractmethod
    def latency(self) -> int:
        """Cycles from a word to its result beyond :attr:`lines`, if nothing stalls."""


class CostArray(wiring.Component, ABC):
    """An array of costs of the streaming engine, a cell a label; constructed from a configuration and the depth of its line memory.

    Members
    -------
    i : In(Issue(config, type(self)))
        Output of :class:`hdl.matcher.streaming.waves.WaveSource`.
    queued : Out(Queued(config)), queued_valid : Out(1)
        A pixel that can be labelled, with the local disparity of the one below it, :meth:`latency_of` cycles after the issue of the pixel
        :meth:`lag_of` places behind.
    address : In(range(depth))
    cost : Out(ArrayLayout(data_bits, D))
        Complements of data terms. Those stored ``n``-th are read at ``address`` ``n % depth``; that of label ``d`` is output ``d + 2``
        cycles after ``address``.
    take : In(1), size : Out(range(size_max + 1))
        With :meth:`size_max_of` above 0 only: pixels of the next support, a cycle after ``take``.
    sideband : Out(signature)
        Further data for the method's :class:`LabelOutput`; :meth:`sideband_of`.
    """
    #: Members driven by settings: those of the wave source.
    settings: ClassVar[tuple[str, ...]] = ()

    @staticmethod
    @abstractmethod
    def columns_of(config: MatcherConfig) -> data.StructLayout:
        """Payload of the columns that it needs."""

    @staticmethod
    def join_threshold_of(config: MatcherConfig) -> int | None:
        """Grey levels by which a pixel may differ from its vertical neighbour for their costs to be joined; ``None``: costs are not."""
        return None

    @staticmethod
    def flush_waves_of(config: MatcherConfig) -> int:
        """Flush cycles after a frame's last line, and after one of fewer pixels than labels."""
        return 0

    @staticmethod
    def size_max_of(config: MatcherConfig) -> int:
        """Most pixels of a support, by which slopes are multiplied; 0 if there are no supports."""
        return 0

    @staticmethod
    def lag_of(config: MatcherConfig) -> int:
        """Pixels issued between one and the last one that its data terms need."""
        return 0

    @staticmethod
    @abstractmethod
    def latency_of(config: MatcherConfig) -> int:
        """Cycles from the issue of the last pixel needed to ``queued``."""

    @staticmethod
    def sideband_of(config: MatcherConfig) -> wiring.Signature:
        """Signature of ``sideband``."""
        return wiring.Signature({})


class Selected(data.StructLayout):
    """A label selected, with its pixel's column, the settings of its frame, and the flags."""
    def __init__(self, config: MatcherConfig, settings: tuple[str, ...]):
        shapes = {name: setting_shape(config.settings[name]) for name in settings}
        super().__init__({"valid": 1, "x": range(config.max_width), "label": range(config.labels), **shapes, **FLAGS})


class LabelOutput(wiring.Component):
    """Turns a selected label into the streaming engine's output word, at a fixed latency, without back-pressure.

    Parameters
    ----------
    config : MatcherConfig
    costs : type of CostArray
        Whose ``sideband`` it reads.
    in_flight : int
        Most pixels between a candidate's issue and its use here.
    array_latency, selection_latency : int
        Cycles from label 0's wave, and from admission, to ``i``.

    Members
    -------
    i : In(Selected(config, settings))
    size : In(range(size_max + 1))
        Two cycles after admission; with supports only.
    sideband : In(costs.sideband_of(config))
    o : Out(shape), o_valid : Out(1)
        :attr:`latency` cycles after ``i``.
    """
    settings: ClassVar[tuple[str, ...]] = ()
    latency: ClassVar[int] = 0
