"""Space around a casing: the radius of its surface, and the occupied places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mesh import Floats, Ints


@dataclass(frozen=True, eq=False)
class Surface:
    """The outside of the casings in steps: from `z[i]` to `z[i + 1]` walls reach `radius[i]`, flanges `flange[i]`."""

    z: Floats
    radius: Floats
    flange: Floats

    def at(self, z: float) -> float:
        """Wall radius at z, metres."""
        return float(self.radius[self._index(z)])

    def top(self, z0: float, z1: float) -> float:
        """Largest radius, flanges included, between two heights."""
        low, high = self._index(min(z0, z1)), self._index(max(z0, z1))
        return float(self.flange[low : high + 1].max())

    def _index(self, z: float) -> int:
        return int(np.clip(np.searchsorted(self.z, z, side="right") - 1, 0, len(self.radius) - 1))


class Room:
    """Which cells of a cylindrical grid (angle, z, radius) are taken. Counts clashes; it forbids nothing."""

    ANGLES = 240

    def __init__(self, z0: float, z1: float, r0: float) -> None:
        self._z0, self._r0 = z0, r0
        self._step = 0.02
        self._taken = np.zeros((self.ANGLES, int((z1 - z0) / self._step) + 2, 40), dtype=bool)

    def cells(self, points: Floats) -> tuple[Ints, Ints, Ints]:
        """Grid indices of cylindrical points (n, 3): angle, z, radius."""
        angle = np.floor(points[:, 0] * (self.ANGLES / (2.0 * np.pi))).astype(np.int64) % self.ANGLES
        z = np.clip((points[:, 1] - self._z0) / self._step, 0, self._taken.shape[1] - 1).astype(np.int64)
        r = np.clip((points[:, 2] - self._r0) / self._step, 0, self._taken.shape[2] - 1).astype(np.int64)
        return angle, z, r

    def clashes(self, points: Floats) -> int:
        """How many of the points fall into taken cells."""
        return int(self._taken[self.cells(points)].sum())

    def take(self, points: Floats) -> None:
        """Marks the cells of the points as taken."""
        self._taken[self.cells(points)] = True


def block(angle: tuple[float, float], z: tuple[float, float], r: tuple[float, float]) -> Floats:
    """Cylindrical points (n, 3) that fill a block."""
    axes = [
        np.arange(angle[0], angle[1] + 0.013, 0.013),
        np.arange(z[0], z[1] + 0.01, 0.01),
        np.arange(r[0], r[1] + 0.01, 0.01),
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=3).reshape(-1, 3)
