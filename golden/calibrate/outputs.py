"""Files of a calibration: camera_info of ROS for each camera, and calib.txt for depth."""

from typing import Any

import numpy as np
import yaml

from .rectified import Rectified


__all__ = ["calib_txt", "camera_info"]


_METRE = 1000.0


def _matrix(values: Any) -> dict[str, Any]:
    values = np.asarray(values, dtype=np.float64)
    rows, columns = values.shape if values.ndim == 2 else (1, values.size)
    return {"rows": rows, "cols": columns, "data": values.ravel().tolist()}


def camera_info(rectified: Rectified, camera: int) -> str:
    """The YAML that ROS's ``camera_calibration`` saves, of camera 0, the left one, or 1; lengths in metres.

    The distortion model is ``plumb_bob`` for up to five coefficients, else ``rational_polynomial``.
    """
    projection = np.array(rectified.projections[camera])
    projection[:, 3] /= _METRE
    distortion = np.asarray(rectified.distortions[camera]).ravel()
    model = "plumb_bob" if distortion.size <= 5 else "rational_polynomial"
    distortion = np.pad(distortion, (0, max(0, 5 - distortion.size)))
    document = {
        "image_width": rectified.size[0], "image_height": rectified.size[1], "camera_name": ("left", "right")[camera],
        "camera_matrix": _matrix(rectified.matrices[camera]), "distortion_model": model, "distortion_coefficients": _matrix(distortion),
        "rectification_matrix": _matrix(rectified.turns[camera]), "projection_matrix": _matrix(projection)}
    text: str = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=140)
    return text


def calib_txt(rectified: Rectified) -> str:
    """``calib.txt`` as Middlebury 2014 has it, of the rectified pictures: pixels, and millimetres."""
    cameras = [f"cam{number}=[{each[0, 0]:.6f} 0 {each[0, 2]:.6f}; 0 {each[1, 1]:.6f} {each[1, 2]:.6f}; 0 0 1]"
               for number, each in enumerate(rectified.projections)]
    offset = rectified.projections[1][0, 2] - rectified.projections[0][0, 2]
    width, height = rectified.size
    return "\n".join([*cameras, f"doffs={offset:.6f}", f"baseline={rectified.baseline:.6f}", f"width={width}", f"height={height}", ""])
