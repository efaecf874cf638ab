"""Sound files of every kind that a command reads, small, from which hostile ones are made."""

import functools
import io
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from golden.config import FUSED_1, RECURSIVE_1
from golden.matcher.parameters import write_parameters
from golden.pictures.dataset import MASKS, PAIRS
from golden.pictures.disparities import write_labels
from golden.pictures.images import write_picture
from golden.pictures.scenes import SCENES
from golden.rig.files import Rig, write_rig
from golden.rig.maps import identity


__all__ = ["SIZE", "samples"]


#: Width and height of all pictures; number of disparities.
SIZE = (24, 16, 4)

# The kinds that Pillow writes of grey levels, or of colours with alpha.
_PILLOW = {"left.tif": "TIFF", "right.tif": "TIFF", "left.jpg": "JPEG", "right.jpg": "JPEG", "left.bmp": "BMP", "left.gif": "GIF"}


def _opencv(entries: Mapping[str, Any]) -> str:
    """YAML as OpenCV writes it."""
    lines = ["%YAML:1.0", "---"]
    for name, value in entries.items():
        array = np.asarray(value, float)
        rows, columns = array.reshape(len(array), -1).shape
        numbers = ", ".join(f"{number:.6g}" for number in array.ravel())
        lines += [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {columns}", "   dt: d", f"   data: [ {numbers} ]"]
    return "\n".join([*lines, ""])


def _calibrations() -> dict[str, str]:
    """Text files that describe two cameras."""
    width, height, _ = SIZE
    matrix: list[list[float]] = [[30.0, 0, width / 2], [0, 30.0, height / 2], [0, 0, 1]]
    lenses = {"M1": matrix, "D1": [[-0.01, 0, 0, 0]], "M2": matrix, "D2": [[-0.01, 0, 0, 0]]}
    places = {"R": np.eye(3), "T": [[-60.0], [0.0], [0.0]]}
    projection = [30.0, 0, width / 2, 0, 0, 30.0, height / 2, 0, 0, 0, 1, 0]
    moved = [*projection[:3], -1.8, *projection[4:]]
    place = np.eye(4)
    place[0, 3] = -0.06
    camera = {"camera_model": "pinhole", "intrinsics": [30.0, 30.0, width / 2, height / 2], "distortion_model": "radtan",
              "distortion_coeffs": [-0.01, 0.0, 0.0, 0.0], "resolution": [width, height], "rostopic": "/camera"}
    ros = {"image_width": width, "image_height": height, "camera_name": "right", "distortion_model": "plumb_bob",
           "camera_matrix": {"rows": 3, "cols": 3, "data": [number for row in matrix for number in row]},
           "distortion_coefficients": {"rows": 1, "cols": 5, "data": [0.0] * 5},
           "rectification_matrix": {"rows": 3, "cols": 3, "data": np.eye(3).ravel().tolist()}}
    of_ros = [yaml.safe_dump({**ros, "projection_matrix": {"rows": 3, "cols": 4, "data": data}}) for data in (projection, moved)]
    return {
        "calib.txt": f"cam0=[30 0 {width / 2}; 0 30 {height / 2}; 0 0 1]\ncam1=[30 0 {width / 2 + 1}; 0 30 {height / 2}; 0 0 1]\n"
                     f"doffs=1\nbaseline=193.001\nwidth={width}\nheight={height}\nndisp=4\n",
        "kitti.txt": "".join(f"P{number}: {' '.join(map(str, moved if number % 2 else projection))}\n" for number in range(4)),
        "intrinsics.yml": _opencv(lenses), "extrinsics.yml": _opencv(places), "stereo.yml": _opencv({**lenses, **places}),
        "projections.yml": _opencv({"P1": np.reshape(projection, (3, 4)), "P2": np.reshape(moved, (3, 4))}),
        "camchain.yaml": yaml.safe_dump({"cam0": camera, "cam1": {**camera, "T_cn_cnm1": place.tolist()}}),
        "ros_left.yaml": of_ros[0], "ros_right.yaml": of_ros[1],
    }


def _pictures(folder: Path, left: NDArray[np.uint8], right: NDArray[np.uint8], truth: NDArray[np.uint8]) -> None:
    """A pair, its truth and its mask in every format."""
    for name, picture in (("left", left), ("right", right)):
        for suffix in (".png", ".pgm", ".pfm", ".npy", ".txt"):
            write_picture(folder / f"{name}{suffix}", picture)
        colours = np.repeat(picture[..., None], 3, axis=2)
        write_picture(folder / f"{name}.ppm", colours)
        write_picture(folder / f"{name}_16.png", picture.astype(np.uint16) * 4)
        opaque = np.concatenate([colours, np.full_like(colours[..., :1], 255)], axis=2)
        Image.fromarray(opaque).save(folder / f"{name}_alpha.png")
        Image.fromarray(colours).convert("P").save(folder / f"{name}_palette.png")
    for name, form in _PILLOW.items():
        Image.fromarray(left if name.startswith("left") else right).save(folder / name, form)
    for suffix in (".png", ".pgm", ".npy"):
        write_labels(folder / f"truth{suffix}", truth)
    write_picture(folder / "truth.pfm", truth)
    write_picture(folder / "truth_16.png", truth.astype(np.uint16) * 256)
    write_picture(folder / "mask.png", np.full_like(left, 255))


def _sets(folder: Path, left: NDArray[np.uint8], right: NDArray[np.uint8], truth: NDArray[np.uint8]) -> None:
    """A folder of one set, and one that is laid out as the benchmark."""
    for place, scale in (("sets/one", 1), *((f"benchmark/{name}", scale) for name, (_, scale) in PAIRS.items())):
        (folder / place).mkdir(parents=True)
        for name, picture in (("left", left), ("right", right), ("disp_left", truth * scale)):
            write_picture(folder / place / f"{name}.png", picture)
        for mask in MASKS:
            write_picture(folder / place / f"{mask}.png", np.full_like(left, 255))
    (folder / "sets/one/meta.json").write_text('{"scale": 1, "unknown_value": 0, "disp_range": [0, 7]}\n')


@functools.cache
def samples() -> dict[str, bytes]:
    """Files by their names; a name with a slash is that of a file in a folder."""
    width, height, labels = SIZE
    scene = SCENES["slanted"](width, height, labels, 1)
    truth = np.clip(np.rint(scene.truth), 1, labels - 1).astype(np.uint8)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        _pictures(folder, scene.left, scene.right, truth)
        _sets(folder, scene.left, scene.right, truth)
        for name, text in _calibrations().items():
            (folder / name).write_text(text)
        (folder / "calibrated").mkdir()
        straight = identity(width, height)
        write_rig(folder / "calibrated" / "rig.json", Rig(straight, straight))
        write_rig(folder / "rig.json", Rig(straight, straight, 1))
        write_parameters(folder / "fused.toml", FUSED_1, "written for a test")
        write_parameters(folder / "recursive.toml", RECURSIVE_1, "written for a test")
        clock = {"device": "x", "engine": "streaming", "method": "fused", "width": 720, "height": 576, "disparities": 80,
                 "clock_mhz": 100.0, "clock_device": "ecp5"}
        (folder / "clock.json").write_text(json.dumps(clock, indent=1))
        (folder / "page.md").write_text("# Page\n\n<!-- By hand from here on; the command keeps it. -->\nMine.\n")
        stored = io.BytesIO()
        np.savez(stored, left=scene.left, right=scene.right)
        (folder / "pair.npz").write_bytes(stored.getvalue())
        (folder / "table.csv").write_text("name,value\na,1\n")
        return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}
