"""The designs whose coverage is measured, the smallest ones that have all parts, and the benches of the suite that drive each."""

import contextlib
import io
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from amaranth.lib.wiring import In

from golden.config import FUSED_1, FUSED_3, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, Method, OnePass, changed
from golden.host.protocol import BAUD
from golden.host.registers import register_map
from golden.pictures.images import write_picture
from golden.pictures.scenes import scene
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.maps import pack
from golden.video.memory_map import MemoryMap
from hdl.emit import port_name, write_verilog
from hdl.host import console
from hdl.host.registers import SerialRegisters
from hdl.interfaces.cores import INTERFACES
from hdl.rectified import RectifiedMatcher
from hdl.rig.balance import BalanceMode
from hdl.rig.stages import RigStages
from hdl.video.bt656 import CameraInput
from hdl.video.dvi import DisplayOutput
from sim import run as pair_command
from sim.benches import camera
from sim.benches.blocks import CONFIGS, Blocks
from sim.benches.bus_cases import CASES as BUS_CASES
from sim.benches.disorder import run_disorder
from sim.benches.matcher_bench import MatcherBench, pictures
from sim.benches.memory_path import MemoryPath
from sim.benches.rig import maps_of
from sim.benches.system_faults import FAULTS
from sim.benches.system_sizes import TOP as SYSTEM
from sim.benches.video_setup import VideoSetup
from sim.kit.display_cases import FORMATS
from sim.kit.harness import simulate
from sim.kit.loop_port import TOP as LOOP
from sim.kit.loop_port import simulated_port, small_board
from sim.kit.rig_cases import noise_map
from sim.kit.simulators import build, run
from sim.system import run_small


__all__ = ["DESIGNS", "Driven", "collecting"]


SIMULATOR = "verilator"
WIDTH, HEIGHT, LABELS = 24, 12, 8


class Driven(NamedTuple):
    """A design that its benches have run: component, its Verilog, and the name of its top module."""
    component: Any
    verilog: Path
    top: str


def _inputs(component: Any) -> str:
    return " ".join(port_name(path) for path, member, _ in component.signature.flatten(component) if member.flow is In)


def _matcher(folder: Path, method: Method, engine: Engine = Engine.STREAMING) -> Driven:
    """Frames of several sizes at full rate and with stalls, with the settings of the build and with others; then disorder."""
    config = MatcherConfig(LABELS, WIDTH, engine=engine, method=method)
    bench = MatcherBench(config, folder)
    pairs = pictures([(WIDTH, HEIGHT), (5, 3), (1, 1), (WIDTH, 2), (LABELS + 1, 7)], LABELS)
    bench.check(*pairs, SIMULATOR)
    bench.check(*pairs, SIMULATOR, stall_i=0.3, stall_o=0.3)
    bench.check(*pairs, SIMULATOR, stall_o=0.9, seed=2)
    for seed in range(2):
        rng = np.random.default_rng(seed)
        settings = {name: int(rng.integers(setting.minimum, setting.maximum + 1)) for name, setting in config.settings.items()}
        bench.check(*pairs, SIMULATOR, stall_i=0.8, seed=3 + seed, settings={**settings, "in_use": 3 + 2 * seed})
    run_disorder(config, HEIGHT, SIMULATOR, bench.verilog, folder)
    return Driven(bench.matcher, bench.verilog, "matcher")


def _component(folder: Path, component: Any, top: str, bench: str, tests: int, **env: object) -> Driven:
    """All tests of a cocotb module on a component."""
    verilog = write_verilog(component, folder / f"{top}.v", name=top)
    build(SIMULATOR, [verilog], top, folder / SIMULATOR, brief=True)
    assert run(SIMULATOR, top, folder / SIMULATOR, bench, env={"INPUTS": _inputs(component), **env}) == tests
    return Driven(component, verilog, top)


def _blocks(folder: Path, arithmetic: str) -> Driven:
    return _component(folder, Blocks(CONFIGS[arithmetic]), "blocks", "sim.benches.blocks_tb", 24, ARITHMETIC=arithmetic)


def _core(folder: Path, interface: str, tests: int) -> Driven:
    modules = f"sim.benches.{interface}_tb,sim.benches.bus_tb"
    return _component(folder, INTERFACES[interface](*BUS_CASES["thesis"]), "stereo_core", modules, tests, CASE="thesis", BUS=interface)


def _rectified(folder: Path) -> Driven:
    """The matcher behind rectification and automatic balance; then fixed balance, and pictures of another size as they are."""
    width, height = 35, 14
    config = MatcherConfig(4, width, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR))
    left_map, right_map = (noise_map(width, height, 90, seed) for seed in (1, 2))
    core = RectifiedMatcher(config, height, RigConfig(22, Rig(left_map, right_map, 2)))
    verilog = write_verilog(core, folder / "core.v", name="matcher")
    lefts, rights = pictures([(width, height)] * 4, 4)
    arguments: dict[str, Any] = {"simulator": SIMULATOR, "work_dir": folder, "verilog": verilog, "core": core}
    simulate(config, lefts, rights, **arguments)
    fixed = {"rectify": 0, "balance": BalanceMode.FIXED, "fixed_gain": 400, "fixed_offset": -3000, "width": 21, "height": 9, "in_use": 3}
    small = [[side[:9, :21] for side in sides] for sides in (lefts, rights)]
    simulate(config, *small, settings=fixed, stall_i=0.2, stall_o=0.2, **arguments)
    return Driven(core, verilog, "matcher")


def _rig(folder: Path) -> Driven:
    case: dict[str, Any] = {"width": 37, "height": 11, "labels": 8, "minimum": 0, "lines": 22, "stall": 0.3, "frames": 5}
    stages = RigStages(case["width"], case["height"], case["labels"], case["lines"],
                       maps=dict(zip(("left", "right"), map(pack, maps_of(case, False)))))
    return _component(folder, stages, "rig", "sim.benches.rig_tb", 1, CASE=json.dumps(case))


def _loop(folder: Path, sdram: bool) -> Driven:
    """A pair over a serial line, what the console shows, and a line that loses, doubles and changes bytes."""
    system = small_board(MatcherConfig(LABELS, 32, method=changed(OnePass(), arithmetic="linear")), 16, sdram=sdram)
    names = [folder / f"{side}.png" for side in ("left", "right")]
    for name, picture in zip(names, scene(32, 16, LABELS, seed=5)[:2]):
        write_picture(name, np.asarray(picture))
    kinds = ("lost", "doubled", "changed")
    faults = [{direction: {"kind": kind, "every": 211, "after": 100}} for direction in ("to_board", "to_host") for kind in kinds]
    for fault in [{}, *faults]:
        with simulated_port(system, folder, faults=fault) as port, contextlib.redirect_stdout(io.StringIO()):
            status = pair_command.main([*map(str, names), "--hardware", port, "--timeout", "3", "--baud", "9600", "--disparities",
                                        str(LABELS), "--output", str(folder / "pair")])
            assert status == 0
            if not fault:
                common = ["--port", port, "--timeout", "2"]
                assert console.main([*common, "get", "identity", "pairs", "uart_errors", "kept"]) == 0
                assert console.main([*common, "grab", "left", str(folder / "grabbed.png")]) == 0
    return Driven(system, folder / f"{LOOP}.v", LOOP)


def _system(folder: Path) -> Driven:
    """From two cameras to the monitor: pictures, a pair that is kept and read, maps that are loaded, all faults."""
    size = "small fused"
    for test in ("pictures", "grab", "maps"):
        system = run_small(folder, test, size=size)
    run_small(folder, "faults", size=size, FAULTS=json.dumps(list(FAULTS)), REPORT=str(folder / "faults.json"))
    return Driven(system, folder / "small.v", SYSTEM)


def _camera(folder: Path) -> Driven:
    return _component(folder, CameraInput(camera.FORMAT, "camera", depth=16), "camera_input", "sim.benches.camera_tb", 4)


def _display(folder: Path) -> Driven:
    width, height, disparities = 12, 8, 5
    output = DisplayOutput(MatcherConfig(disparities), FORMATS["small"], width, height, depth=16)
    for modes in ("0 0 0 1 1 0 2 1 3 0", ""):
        driven = _component(folder, output, "display_output", "sim.benches.display_tb", 1, DISPLAY_FORMAT="small",
                            SIZE=f"{width} {height}", DISPARITIES=disparities, MODES=modes)
    return driven


def _memory_path(folder: Path) -> Driven:
    width, height, size, depth = 37, 6, 1, 32
    path = MemoryPath(MemoryMap(width, height), MatcherConfig(256), burst=16, size=size, depth=depth)
    return _component(folder, path, "memory_path", "sim.benches.memory_path_tb", 2, PATH_SIZE=json.dumps([width, height, size, depth]))


def _registers(folder: Path) -> Driven:
    bit_cycles, frame_bits = 16, 30
    registers = SerialRegisters(register_map(), bit_cycles * BAUD, frame_seconds=frame_bits / BAUD)
    return _component(folder, registers, "serial_registers", "sim.benches.uart_tb", 4, BIT_CYCLES=bit_cycles, FRAME_BITS=frame_bits)


def _video_setup(folder: Path) -> Driven:
    return _component(folder, VideoSetup(), "video_setup", "sim.benches.video_setup_tb", 2)


#: By name: a function that takes a folder to work in, and the arguments that follow it.
DESIGNS: dict[str, tuple[Callable[..., Driven], tuple[Any, ...]]] = {
    "matcher thesis": (_matcher, (OnePass(Arithmetic.THESIS), Engine.SEQUENTIAL)),
    "matcher linear, sequential": (_matcher, (OnePass(Arithmetic.LINEAR), Engine.SEQUENTIAL)),
    "matcher linear": (_matcher, (OnePass(Arithmetic.LINEAR),)),
    "matcher fused": (_matcher, (FUSED_1,)),
    "matcher fused, vertical": (_matcher, (changed(FUSED_3, sub_pixel=True),)),
    "matcher recursive": (_matcher, (RECURSIVE_1,)),
    "matcher recursive, from below": (_matcher, (changed(RECURSIVE_1, from_below=True, sub_pixel=True),)),
    "blocks thesis": (_blocks, ("thesis",)),
    "blocks linear": (_blocks, ("linear",)),
    "core AXI": (_core, ("axi", 7)),
    "core Avalon": (_core, ("avalon", 6)),
    "core rectified": (_rectified, ()),
    "rectification": (_rig, ()),
    "loop": (_loop, (False,)),
    "loop SDRAM": (_loop, (True,)),
    "camera": (_camera, ()),
    "display": (_display, ()),
    "memory path": (_memory_path, ()),
    "serial registers": (_registers, ()),
    "video set-up": (_video_setup, ()),
    "system": (_system, ()),
}


@contextlib.contextmanager
def collecting(variable: str, folder: Path) -> Iterator[None]:
    """Set an environment variable to a folder for the block."""
    before = os.environ.get(variable)
    os.environ[variable] = str(folder)
    try:
        yield
    finally:
        os.environ.pop(variable) if before is None else os.environ.update({variable: before})
