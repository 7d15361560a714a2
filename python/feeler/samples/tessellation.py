"""How finely a curve is cut into straight pieces: by chord tolerance, as CAD systems do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mesh import Floats, Ints

# No arc is cut into shorter pieces, however fine the tolerance: far above the vertex grid, so that no triangle loses
# its area to rounding, and CAD systems have such a limit too. It bounds how many triangles a sample can have.
LEAST_PIECE_M = 8e-5


@dataclass(frozen=True)
class Tolerance:
    """Chord tolerance in metres; with it goes a limit on the angle between neighbouring pieces."""

    chord: float

    @property
    def angle(self) -> float:
        """Largest turn between neighbouring pieces, radians: CAD's angular deflection, finer with the chord."""
        return float(min(1.3, max(0.04, 0.5 * (self.chord / 2e-4) ** 0.3)))

    def segments(self, radius: float, angle: float = 2.0 * np.pi, least: int = 1) -> int:
        """Pieces for an arc of `radius` and `angle`: its chords stay within the tolerance."""
        step = 2.0 * np.arccos(1.0 - min(0.7 if self.coarse else 0.5, self.chord / max(radius, 1e-9)))
        step = max(min(step, self.angle), LEAST_PIECE_M / max(radius, 1e-9))
        return max(least, int(np.ceil(abs(angle) / step - 1e-9)))

    @property
    def coarse(self) -> bool:
        """Whether small parts are only stood for by a block: the smallest mock-ups."""
        return self.chord > 5e-3

    def circle(self, radius: float, least: int = 6, multiple: int = 1) -> int:
        """Pieces for a full circle, a multiple of `multiple`."""
        if self.coarse and radius < 0.03:
            least = min(least, 4)
        count = self.segments(radius, 2.0 * np.pi, least)
        return -(-count // multiple) * multiple

    def shows(self, size: float) -> bool:
        """Whether a feature of that size (a fillet's radius, a hole's) is worth modelling at this tolerance."""
        return size > 1.5 * self.chord


def circle(radius: float, count: int, z: float = 0.0, phase: float = 0.0) -> Floats:
    """A circle about z, (count, 3), counter-clockwise from above."""
    angle = np.arange(count) * (2.0 * np.pi / count) + phase
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, z)], axis=1)


def hexagon(across_flats: float, z: float = 0.0) -> Floats:
    """A regular hexagon about z, (6, 3)."""
    return circle(across_flats / np.sqrt(3.0), 6, z)


def lifted(outline: Floats, z: float) -> Floats:
    """A plane outline (n, 2) as a loop (n, 3) at height `z`."""
    return np.column_stack([outline, np.full(len(outline), z)])


def rounded(corners: Floats, radius: float | Floats, tol: Tolerance) -> Floats:
    """A closed plane polygon, (n, 2), with its corners turned into arcs; radius one number or one a corner.

    An arc too small for the tolerance stays a sharp corner.
    """
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(corners),))
    before = np.roll(corners, 1, axis=0) - corners
    after = np.roll(corners, -1, axis=0) - corners
    points: list[Floats] = []
    for corner, back, ahead, wish in zip(corners, before, after, radii, strict=True):
        back_length, ahead_length = np.hypot(*back), np.hypot(*ahead)
        u, v = back / back_length, ahead / ahead_length
        turn = np.pi - np.arccos(np.clip(u @ v, -1.0, 1.0))
        if turn < 0.05:
            points.append(corner[None])
            continue
        arc_radius = min(wish, 0.45 * min(back_length, ahead_length) / np.tan(turn / 2.0))
        if not tol.shows(arc_radius):
            points.append(corner[None])
            continue
        cut = arc_radius * np.tan(turn / 2.0)
        start = corner + u * cut
        side = np.sign(-u[0] * v[1] + u[1] * v[0])  # left turn: +1
        count = tol.segments(arc_radius, turn)
        centre = start + side * arc_radius * np.array([u[1], -u[0]])
        angle = np.arctan2(*(start - centre)[::-1]) + side * np.linspace(0.0, turn, count + 1)
        points.append(centre + arc_radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.concatenate(points)


def strip(count: int) -> Ints:
    """Triangles (count - 2, 3) of a convex loop, across it in a zigzag: the long thin triangles of a CAD face."""
    order = np.empty(count, dtype=np.int64)
    order[0::2] = np.arange((count + 1) // 2)
    order[1::2] = count - 1 - np.arange(count // 2)
    return np.sort(np.stack([order[:-2], order[1:-1], order[2:]], axis=1), axis=1)


def stitch(lower: Floats, upper: Floats) -> tuple[Ints, Ints]:
    """Triangles between two closed loops whose points are given by their angles, both counter-clockwise.

    Returns (with two points on the lower loop: lower i, lower i + 1, upper j) and (with one: lower i, upper j + 1,
    upper j), each (k, 3), indices modulo the loop's length.
    """
    two_pi = 2.0 * np.pi
    n, m = len(lower), len(upper)
    low = np.unwrap(np.append(lower, lower[0]))
    first = int(np.argmin(np.abs((upper - lower[0] + np.pi) % two_pi - np.pi)))
    high = np.unwrap(np.append(np.roll(upper, -first), upper[first]))
    low = low - low[0]
    high = high - high[0] + ((high[0] - lower[0] + np.pi) % two_pi - np.pi)
    low[-1], high[-1] = two_pi, high[0] + two_pi
    on_low: list[tuple[int, int, int]] = []
    on_high: list[tuple[int, int, int]] = []
    i = j = 0
    while i < n or j < m:
        if j == m or (i < n and low[i + 1] + low[i] <= high[j + 1] + high[j]):
            on_low.append((i % n, (i + 1) % n, (j + first) % m))
            i += 1
        else:
            on_high.append((i % n, (j + 1 + first) % m, (j + first) % m))
            j += 1
    return np.array(on_low, dtype=np.int64).reshape(-1, 3), np.array(on_high, dtype=np.int64).reshape(-1, 3)


def triangulate(outline: Floats) -> Ints:
    """Triangles (n - 2, 3) of a simple plane polygon (n, 2), counter-clockwise, by ear clipping; O(n^2)."""
    left = list(range(len(outline)))
    triangles: list[tuple[int, int, int]] = []
    position, misses = 0, 0
    scale = float(np.ptp(outline, axis=0).max()) ** 2
    while len(left) > 3 and misses <= len(left):
        count = len(left)
        position %= count
        a, b, c = left[position - 1], left[position], left[(position + 1) % count]
        if _is_ear(outline, a, b, c, left, 1e-10 * scale):
            triangles.append((a, b, c))
            del left[position]
            misses = 0
            position += 1  # clip every other corner, not one fan
        else:
            position += 1
            misses += 1
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64)


def _is_ear(outline: Floats, a: int, b: int, c: int, left: list[int], least: float) -> bool:
    corner_a, corner_b, corner_c = outline[a], outline[b], outline[c]
    if _cross(corner_b - corner_a, corner_c - corner_a) <= least:
        return False
    others = np.array([k for k in left if k not in (a, b, c)], dtype=np.int64)
    points = outline[others]
    inside = (
        (_cross(corner_b - corner_a, points - corner_a) >= 0.0)
        & (_cross(corner_c - corner_b, points - corner_b) >= 0.0)
        & (_cross(corner_a - corner_c, points - corner_c) >= 0.0)
    )
    return not bool(inside.any())


def _cross(u: Floats, v: Floats) -> Floats:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
