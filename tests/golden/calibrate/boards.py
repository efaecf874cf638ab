"""Cameras that are known, and what they see of a chessboard: corners, pictures, files."""

import functools

import numpy as np
import pytest

from golden.calibrate.views import Board, View
from golden.pictures.images import write_picture


SIZE = 320, 240
BOARD = Board(7, 5, 25.0)
FOCAL = 300.0
BASELINE = 60.0


def opencv():
    return pytest.importorskip("cv2", reason="cv2, of the extra lab, is not installed")


class Cameras:
    """Two cameras of which the right one is rolled, in degrees, and lower, in millimetres; ``lens`` is the k1 of both."""
    def __init__(self, roll=1.0, lower=2.0, lens=-0.1, baseline=BASELINE, size=SIZE):
        cv2 = opencv()
        self.size = size
        self.matrix = np.array([[FOCAL, 0, size[0] / 2 - 3], [0, FOCAL, size[1] / 2 + 2], [0, 0, 1]])
        self.distortion = np.array([lens, 0, 0, 0, 0])
        self.rotation = cv2.Rodrigues(np.radians([0.0, 1.0, roll]))[0]
        self.translation = np.array([[-baseline], [-lower], [0.0]])

    def poses(self, count):
        """Rotations and translations of the board, left camera's coordinates: it is turned and in another place in each."""
        rng = np.random.default_rng(3)
        middle = np.array([25.0 * (BOARD.columns - 1) / 2, 25.0 * (BOARD.rows - 1) / 2, 0])
        for _ in range(count):
            turn = opencv().Rodrigues(np.append(rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.3, 0.3)))[0]
            place = np.array([rng.uniform(0, 60), rng.uniform(-25, 25), rng.uniform(330, 420)])
            yield turn, (place - turn @ middle)[:, None]

    def seen(self, points, turn, place):
        """Points of the board in both pictures: two of (N, 2)."""
        cv2 = opencv()
        poses = (turn, place), (self.rotation @ turn, self.rotation @ place + self.translation)
        return [cv2.projectPoints(points.astype(float), cv2.Rodrigues(r)[0], t, self.matrix, self.distortion)[0].reshape(-1, 2)
                for r, t in poses]

    def views(self, count=10, noise=0.05):
        """Views of the board, with noise, pixels."""
        rng = np.random.default_rng(5)
        for number, pose in enumerate(self.poses(count)):
            left, right = (side + rng.normal(0, noise, side.shape) for side in self.seen(BOARD.points, *pose))
            yield View(f"view {number}", left.astype(np.float32), right.astype(np.float32))

    def write(self, folder, count=10):
        """Pictures of the board as ``left0.png``, ``right0.png`` and so on: their names, those of the left camera first."""
        names = [[], []]
        for number, pose in enumerate(self.poses(count)):
            for camera, side in enumerate(("left", "right")):
                names[camera].append(f"{side}{number}.png")
                write_picture(folder / names[camera][-1], self._picture(camera, *pose))
        return names[0] + names[1]

    @functools.cached_property
    def _rays(self):
        """Of every pixel, nine times: (N, 3)."""
        part = (np.arange(3) - 1) / 3
        y, x = np.mgrid[:self.size[1], :self.size[0]].astype(float)
        pixels = np.stack([np.stack([x + a, y + b], -1) for a in part for b in part]).reshape(-1, 1, 2)
        rays = opencv().undistortPoints(pixels, self.matrix, self.distortion).reshape(-1, 2)
        return np.append(rays, np.ones((len(rays), 1)), axis=1)

    def _picture(self, camera, turn, place):
        """The rays are followed to the board's plane."""
        if camera:
            turn, place = self.rotation @ turn, self.rotation @ place + self.translation
        rays = self._rays @ turn      # in the board's coordinates
        eye = -(turn.T @ place)[:, 0]
        u, v = ((eye[axis] - rays[:, axis] * eye[2] / rays[:, 2]) / 25.0 for axis in (0, 1))
        inside = (u > -1) & (u < BOARD.columns) & (v > -1) & (v < BOARD.rows)
        level = np.where(inside & ((np.floor(u) + np.floor(v)) % 2 == 0), 40, 215)
        return np.rint(level.reshape(9, *self.size[::-1]).mean(axis=0)).astype(np.uint8)
