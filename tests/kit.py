"""What tests of several rooms share: photographs with ground truth, components that are refused, parameters by turns, what was built."""

import atexit
import contextlib
import functools
import gc
import json
import os
import pathlib
import re
import shutil
import tempfile
import warnings

import pytest
from amaranth.hdl import Fragment, Module, UnusedElaboratable
from amaranth.lib import wiring

from golden.errors import UserError
from golden.pictures.dataset import PAIRS, data_folder, load_pair, motorcycle
from golden.pictures.sets import load_data


def by_turns(cases, stalls):
    """Parameters of tests: those of each case, then a stall.

    Slow: with one stall what is seen with the other. Case by case ``make test`` takes another one; of a case that is slow, none.
    """
    params = []
    for number, case in enumerate(cases):
        values, marks = (case.values, case.marks) if hasattr(case, "marks") else (case, ())
        params += [pytest.param(*values, stall, marks=marks or ([] if turn == number % len(stalls) else pytest.mark.slow))
                   for turn, stall in enumerate(stalls)]
    return params


@contextlib.contextmanager
def refused_components():
    """Around what a constructor refuses: the components that it had built by then are collected here, without Amaranth's warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        yield
        gc.collect()


class Circuit(wiring.Component):
    """A component with the given ports, whose logic ``build(component, module)`` adds."""
    def __init__(self, build, **ports):
        self.build = build
        super().__init__(ports)

    def elaborate(self, platform):
        m = Module()
        self.build(self, m)
        return m


@functools.cache
def middlebury(name):
    """A pair of the Middlebury benchmark; skips the test if the data are not on this machine."""
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    return load_pair(folder, name)  # a folder that is there must be whole


@functools.cache
def training_sets():
    """The sets in ``$STEREO_TRAIN``, else in ../shared/data/middlebury-train from the repository's root; skips the test without them."""
    default = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data" / "middlebury-train"
    folder = pathlib.Path(os.environ.get("STEREO_TRAIN") or default)
    if not folder.is_dir():
        pytest.skip(f"the folder {folder} does not exist; name one of fourteen Middlebury sets of 2005 and 2006 with STEREO_TRAIN")
    return load_data(folder)


@functools.cache
def calibration_folder():
    """The folder in ``$STEREO_CALIBRATION``, else ../shared/data/calibration from the repository's root; skips the test without it."""
    default = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data" / "calibration"
    folder = pathlib.Path(os.environ.get("STEREO_CALIBRATION") or default)
    if not folder.is_dir():
        pytest.skip(f"the folder {folder} does not exist; name one of OpenCV's pictures left01.jpg .. right14.jpg of a chessboard and "
                    "intrinsics.yml with STEREO_CALIBRATION")
    return folder


@contextlib.contextmanager
def only(name):
    """Within the block the benchmark, and its folder, has one pair; afterwards all, in the same order. Skips the test without the data."""
    middlebury(name)
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as context:
        pathlib.Path(folder, name).symlink_to(data_folder().resolve() / name, target_is_directory=True)
        context.setenv("STEREO_DATA", folder)
        every = dict(PAIRS)
        for other in every.keys() - {name}:
            del PAIRS[other]
        try:
            yield
        finally:
            PAIRS.clear()
            PAIRS.update(every)


@functools.cache
def reduced_motorcycle():
    """The Motorcycle pair as the demonstration takes it; skips the test if scikit-image is not installed."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    return motorcycle()


def manifest(folder):
    """What ``hdl.build`` told in a folder."""
    return json.loads((folder / "manifest.json").read_text())


@functools.cache
def packed_core(interface):
    """Folder of a small core ``left_eye`` with an interface, in all packages that it can have."""
    from hdl.build import main  # slow to import

    folder = pathlib.Path(tempfile.mkdtemp(prefix="packed-"))
    atexit.register(shutil.rmtree, folder)
    packages = ["--package", "fusesoc,quartus,vivado", "--package", "litex,vhdl" + ",registers" * (interface != "stream")]
    assert main(["--core", "--interface", interface, "--width", "8", "--height", "4", "--disparities", "4", "--name", "left_eye", *packages,
                 "--output", str(folder)]) == 0
    return folder


@functools.cache
def packed_ports(interface):
    """Ports in the Verilog of :func:`packed_core`."""
    return verilog_ports((packed_core(interface) / "left_eye.v").read_text(), "left_eye")


@functools.cache
def bus_core(interface):
    """A core ``left_eye`` with buses, as its packages describe it."""
    from golden.config import MatcherConfig
    from golden.host.core_registers import WORD_BYTES, core_register_map
    from hdl.build import fields_of, ports_of
    from hdl.interfaces.cores import INTERFACES
    from hdl.packages.core import Core, RegisterSpace

    component = INTERFACES[interface](MatcherConfig(4, 8), 4)
    Fragment.get(component, None)  # Amaranth complains of a component that is not used
    space = RegisterSpace(core_register_map(component.config, 4), WORD_BYTES, "Registers of a core")
    return Core("left_eye", "0.2.0", "Stereo matcher, for a test", ["left_eye.v", "left_eye.vlt"], ports_of(component),
                fields_of(component), space)


def verilog_ports(text, module):
    """Ports of a module of the Verilog text: name to (direction, width)."""
    body = re.search(rf"(?ms)^module {module}\((.*?)\);(.*?)^endmodule", text)
    names = re.findall(r"\w+", body[1])
    found = {name: (direction, int(high or 0) + 1) for direction, high, name
             in re.findall(r"(?m)^  (input|output|inout) (?:\[(\d+):0\] )?(\w+);$", body[2])}
    assert sorted(names) == sorted(found)
    return found
