"""From which side a finding is seen, and whether it is cut open: decided by rays against its two parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from feeler.choices import UpAxis
from feeler.mockup import Mockup
from feeler.picture import Camera
from feeler.picture.camera import upright_frame
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

_SIDES = 96
_STEEPEST = 0.9
"""Of the sine of the elevation: straight from above, a picture has no upright."""
_GRID = 11
"""Rays across and down the picture, to count how much of each part is seen."""
_WHOLE = 0.05
"""Share of these rays that is enough of a part."""
_LINE = np.linspace(0.1, 0.9, 5)
"""Where on the line of a gap it must be seen."""
_SHORT = 1e-6
"""Of the way from the eye: a ray to a point on a surface ends before it."""


class Sides:
    """The candidates for one finding. cameras: one per side. corners: the triangles of both parts, `(k, 3, 3)` each."""

    def __init__(self, cameras: Sequence[Camera], corners: Sequence[Floats], extent: float) -> None:
        vertices = np.concatenate(corners).reshape(-1, 3)
        parts = np.repeat([0, 1], [len(each) for each in corners])
        self._scene = Scene(Mockup(vertices, np.arange(len(vertices)).reshape(-1, 3), parts, ["a", "b"]))
        self._parts = parts
        self._eyes = np.array([camera.eye for camera in cameras])
        axes = np.array([camera.axes()[:2] for camera in cameras])
        steps = (np.arange(_GRID) - (_GRID - 1) / 2) / (_GRID - 1) * extent
        across, up = (each.ravel() for each in np.meshgrid(steps, steps))
        grid = across[:, None] * axes[:, None, 0] + up[:, None] * axes[:, None, 1]
        self._grid = np.array([camera.target for camera in cameras])[:, None] + grid

    def sees(self, start: Floats, end: Floats) -> npt.NDArray[np.bool_]:
        """Per side: whether nothing is before the line between two points."""
        points = start + _LINE[:, None] * (end - start)
        ways = (points - self._eyes[:, None]) * (1.0 - _SHORT)
        eyes = np.broadcast_to(self._eyes[:, None], ways.shape)
        rays = self._scene.rays(eyes.reshape(-1, 3), ways.reshape(-1, 3))
        is_hidden = rays.distances.reshape(ways.shape[:2]) <= np.linalg.norm(ways, axis=2)
        return np.asarray(~is_hidden.any(axis=1))

    def shares(self, which: npt.NDArray[np.intp], point: Floats, normal: Floats | None) -> Floats:
        """For some of the sides: how much of the part that is seen less is seen, 0 to 1, behind a section if any."""
        ways = self._grid[which] - self._eyes[which, None]
        eyes = np.broadcast_to(self._eyes[which, None], ways.shape)
        sections = None if normal is None else [[*-normal, -float(normal @ point)]]
        hits = self._scene.rays(eyes.reshape(-1, 3), ways.reshape(-1, 3), sections=sections).triangles
        parts = np.where(hits >= 0, self._parts[hits], -1).reshape(ways.shape[:2])
        least = np.minimum((parts == 0).mean(axis=1), (parts == 1).mean(axis=1))
        return np.asarray(np.minimum(least / _WHOLE, 1.0))


def directions(usual: Floats, up: UpAxis) -> Floats:
    """Unit vectors of looks all around, evenly, and the usual one first: a Fibonacci sphere."""
    number = np.arange(_SIDES) + 0.5
    height = 1.0 - 2.0 * number / _SIDES
    angle = np.pi * (1.0 + np.sqrt(5.0)) * number
    ring = np.sqrt(1.0 - height * height)
    sphere = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    sphere = sphere[np.abs(height) < _STEEPEST] @ np.stack(upright_frame(up))
    return np.concatenate([[usual / np.linalg.norm(usual)], sphere])
