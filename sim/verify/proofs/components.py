"""Which components have streams, and why those that have no proof of their own need none."""

import ast
import importlib
import inspect
import pkgutil
import textwrap
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

from amaranth.hdl import Module
from amaranth.lib import wiring

import hdl
from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, OnePass, changed
from golden.host.registers import register_map
from golden.rig.config import RigConfig
from golden.video.formats import DISPLAYS, PAL
from golden.video.frame_rule import Closes
from golden.video.sdram import SDRAM
from golden.video.setup_steps import TFP410
from hdl.host.registers import ByteRegisters, SerialRegisters
from hdl.interfaces.core import RegisteredMatcher
from hdl.loop.core import LoopCore
from hdl.loop.sdram import SdramController
from hdl.loop.sdram_store import SdramStores
from hdl.loop.store import BlockStores
from hdl.loop.words import Stores
from hdl.matcher.framed import FramedMatcher
from hdl.matcher.matcher import Matcher
from hdl.matcher.recursive.engine import RecursiveEngine
from hdl.matcher.recursive.source import RecursiveSource
from hdl.matcher.recursive.support import ArmSource
from hdl.matcher.refine.median import Median, MedianColumns
from hdl.matcher.refine.weighted_median import WeightedMedian
from hdl.matcher.refine.window import LabelColumns
from hdl.matcher.refine.window_stage import WindowStage
from hdl.matcher.sequential.cost import _Stage
from hdl.matcher.sequential.smooth import Smooth
from hdl.matcher.streaming.bec_array import BecArray
from hdl.matcher.streaming.engine import StreamingEngine
from hdl.matcher.streaming.label_output import PlainLabel
from hdl.matcher.streaming.support import Arms, SupportArms
from hdl.matcher.streaming.waves import WaveSource
from hdl.parts.uart import UartTransmitter
from hdl.rectified import RectifiedMatcher
from hdl.rig.rectifier import Rectifier
from hdl.rig.stages import RigStages
from hdl.video.arbiter import Arbiter
from hdl.video.bt656 import CameraInput
from hdl.video.dvi import DisplayOutput
from hdl.video.frame_read import _PlanePairReader, _Reader
from hdl.video.frame_write import _PlaneWriter
from hdl.video.pair_rig import PairRig
from hdl.video.picture import PictureGate, PictureScan
from hdl.video.setup import ChipSetup

from .claim import streams_of


__all__ = ["BASES", "PASS_ON", "SEND_NOTHING", "components_with_streams", "sources_of"]


THESIS, LINEAR = MatcherConfig(2, 3), MatcherConfig(2, 3, method=OnePass(Arithmetic.LINEAR))
STREAMING = MatcherConfig(2, 3, method=OnePass(Arithmetic.LINEAR), engine=Engine.STREAMING)
FUSED = MatcherConfig(2, 3, method=changed(FUSED_1, census_rows=3, census_columns=3))
RECURSIVE = MatcherConfig(2, 3, method=RECURSIVE_1)
VIDEO = MatcherConfig(2, PAL.width)

Make = Callable[[], wiring.Component]

#: Never built themselves: what is derived from them, or contains them, is proved.
BASES: tuple[type, ...] = (Stores, SupportArms, WindowStage, _PlanePairReader, _PlaneWriter, _Reader, _Stage)

#: Components that accept streams and send none, or that the search of sources takes for such.
SEND_NOTHING: tuple[Make, ...] = (
    lambda: Arbiter(1, 1), lambda: ArmSource(RECURSIVE), lambda: Arms(FUSED), lambda: BlockStores(LINEAR, 2),
    lambda: ChipSetup(TFP410, 1_000_000), lambda: DisplayOutput(VIDEO, DISPLAYS["720x576"], 720, 576),
    lambda: FramedMatcher(LINEAR), lambda: LabelColumns(FUSED, 3), lambda: MedianColumns(FUSED), lambda: PictureGate(LINEAR, 8, 2),
    lambda: PictureScan(VIDEO, DISPLAYS["720x576"], 720, 576), lambda: RecursiveSource(RECURSIVE, 3),
    lambda: SdramController(SDRAM.clocks(50_000_000), 2), lambda: SdramStores(LINEAR, 2, 50_000_000), lambda: Smooth(THESIS),
    lambda: UartTransmitter(32, 2), lambda: WaveSource(STREAMING, BecArray),
)

#: Components whose streams are those of a part, wire by wire.
PASS_ON: tuple[Make, ...] = (
    lambda: ByteRegisters(register_map(VIDEO), 3, writes=True), lambda: CameraInput(PAL, "camera", depth=8),
    lambda: LoopCore(BlockStores(LINEAR, 2), 3), lambda: Matcher(LINEAR), lambda: Matcher(STREAMING), lambda: Matcher(FUSED),
    lambda: Matcher(RECURSIVE), lambda: Median(FUSED), lambda: PairRig(RigConfig(), VIDEO, PAL), lambda: Rectifier(8, 8),
    lambda: RectifiedMatcher(LINEAR, 3, RigConfig()), lambda: RecursiveEngine(RECURSIVE),
    lambda: RegisteredMatcher(LINEAR, 2, Closes.LINE), lambda: RigStages(8, 8, 2),
    lambda: SerialRegisters(register_map(VIDEO), 1_843_200), lambda: StreamingEngine(STREAMING, BecArray, PlainLabel),
    lambda: WeightedMedian(RECURSIVE),
)


def _modules() -> list[ModuleType]:
    names = [found.name for found in pkgutil.walk_packages(hdl.__path__, "hdl.") if not found.name.endswith("__main__")]
    return [importlib.import_module(name) for name in names]


def _names(code: Any) -> set[str]:
    """All names in the source of a function, attributes included."""
    nodes = [*ast.walk(ast.parse(textwrap.dedent(inspect.getsource(code))))]
    return {node.id for node in nodes if isinstance(node, ast.Name)} | {node.attr for node in nodes if isinstance(node, ast.Attribute)}


def _derived(base: type) -> Iterator[type]:
    kind: type
    for kind in base.__subclasses__():
        yield kind
        yield from _derived(kind)


def _names_of_members(kind: type) -> set[str]:
    inits = [vars(base)["__init__"] for base in kind.__mro__ if base.__module__.startswith("hdl.") and "__init__" in vars(base)]
    return set().union(*map(_names, inits))


def components_with_streams() -> set[type]:
    """Components of :mod:`hdl` whose members are made with the word ``stream``, with a signature or a function of which that is true, or
    from the members of another component. All that have a stream are among them.
    """
    modules = _modules()
    ours = {name: value for module in modules for name, value in vars(module).items()
            if getattr(value, "__module__", "").startswith("hdl.")}
    made = {kind.__name__: _names_of_members(kind) for kind in _derived(wiring.Signature) if kind.__module__.startswith("hdl.")}
    made |= {name: _names(value) for name, value in ours.items() if inspect.isfunction(value)}
    words: set[str] = {"stream", "members"}
    while new := {name for name, used in made.items() if used & words} - words:
        words |= new
    return {kind for kind in _derived(wiring.Component) if kind.__module__.startswith("hdl.") and _names_of_members(kind) & words}


def sources_of(component: wiring.Component) -> dict[str, type | None]:
    """Of each stream that a component sends: the class of the part whose stream it is, ``None`` if it is not wired to one."""
    module: Any = component.elaborate(None)     # type: ignore[attr-defined]
    assert isinstance(module, Module)
    parts = [part for part, _ in module._named_submodules.values()] + [part for part, _ in module._anon_submodules]
    valid_of = {id(stream.value.valid): type(part) for part in parts if isinstance(part, wiring.Component) for stream in streams_of(part)}
    driver = {id(statement.lhs): id(statement.rhs) for statement in module._statements["comb"] if hasattr(statement, "lhs")}
    return {stream.name: valid_of.get(driver.get(id(stream.value.valid), 0)) for stream in streams_of(component) if stream.is_output}
