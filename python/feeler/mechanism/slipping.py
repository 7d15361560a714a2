"""Motions that slide surfaces in themselves (Gelfand and Guibas 2004), and what stands in the way of the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mechanism.rounds import polar
from feeler.mechanism.touching import Touches

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

SLIDES = 0.12
"""Sine of the largest angle between a motion and a surface that slides in itself: facets of threads lean that much."""
TURN_PLAY_RAD = 0.2
"""A joint may have this much play until its flats or keys stop it."""
LEAST_SHARE = 0.004
"""The share of the surface in contact that stops a motion; less are edges and rounding."""
FREE = 1e-5
"""The greatest mean square of a free motion's speed into the surface, relative to its speed."""
BALL = 0.02
"""The largest distance of the normals from the middle of a ball, as a share of its radius."""
BALL_SHARE = 0.25
"""The share of a ball's surface that may be farther."""
LEANS = 0.15
"""The least lean along the axis of the flanks of a thread, as a sine."""
THREAD_SHARE = 0.03
"""The least share of flanks in the surface in contact."""
TAPER_SPREAD = 0.05
"""The largest difference of a cone's lean from its mean: interpolated normals of coarse facets differ."""
LEAST_TAPER = 0.002
TAPER_SHARE = 0.8
"""The least share of a cone in the surface in contact."""
EVEN = 0.01
"""Edges that wind are off the pitch of all corners by this share at most: files round all of them alike."""
PITCH_OFF = 0.15
"""The pitch of leaning facets is off by this share at most."""
PITCH_STEP = 1e-6
"""It is sought to this share."""
BESIDE = 0.3
"""Crests and roots are beside the flanks by this share of their height at most."""
WAVES = 4
"""Of the profile of a thread: as many as its starts at least."""
MOST_CORNERS = 4000
"""Of each side."""
AGREED = 0.7
"""The least share of flanks that agree on a pitch within 30 %."""


@dataclass(frozen=True)
class Way:
    """Whether a motion is stopped forwards and backwards: shares of the surface."""

    forward: float
    backward: float

    @property
    def is_free(self) -> bool:
        """To both sides."""
        return self.forward < LEAST_SHARE and self.backward < LEAST_SHARE

    @property
    def most(self) -> float:
        """The larger share."""
        return max(self.forward, self.backward)

    @property
    def is_open(self) -> bool:
        """Free to one side at least."""
        return min(self.forward, self.backward) < LEAST_SHARE


def turn(touches: Touches, axis: Floats, point: Floats, pitch: float = 0.0) -> Floats:
    """The velocity of each point of a turn of a radian a second; pitch: metres a radian."""
    return np.asarray(np.cross(axis, touches.points - point) + pitch * axis)


def slip(touches: Touches, velocity: Floats) -> Floats:
    """The speed of each point into the other side; 0 where either surface slides in itself."""
    one = np.einsum("ij,ij->i", velocity, touches.child_normals)
    other = np.einsum("ij,ij->i", velocity, touches.parent_normals)
    least = np.where(np.abs(one) < np.abs(other), one, other)
    return np.where(one * other > 0.0, least, 0.0)


def way_of(touches: Touches, velocity: Floats, travel: float, counts: Bools | None = None) -> Way:
    """What stops a motion. travel: stops beyond are ignored, in the unit of the motion. counts: the points that can
    stop it; None for all."""
    into = slip(touches, velocity)
    stops = stopped(touches, into, velocity, travel)
    if counts is not None:
        stops &= counts
    total = float(touches.weights.sum())
    forward = float(touches.weights[stops & (into > 0)].sum()) / total
    backward = float(touches.weights[stops & (into < 0)].sum()) / total
    return Way(forward, backward)


def stopped(touches: Touches, into: Floats, velocity: Floats, travel: float) -> Bools:
    """Which points stop a motion."""
    speed = np.linalg.norm(velocity, axis=1)
    steep = np.abs(into) > np.maximum(SLIDES * speed, 1e-15)
    return np.asarray(steep & (np.maximum(touches.gaps, 0.0) <= travel * np.abs(into)))


def matrix_of(touches: Touches) -> tuple[Floats, Floats, float]:
    """The 6x6 matrix of the surface in contact, with its middle and size: turns first, in units of the size."""
    weights = touches.weights / touches.weights.sum()
    middle = weights @ touches.points
    size = float(np.sqrt(weights @ np.sum((touches.points - middle) ** 2, axis=1))) or 1.0
    matrix = np.zeros((6, 6))
    for normals in (touches.child_normals, touches.parent_normals):
        rows = np.concatenate([np.cross((touches.points - middle) / size, normals), normals], axis=1)
        matrix += 0.5 * (rows * weights[:, None]).T @ rows
    return matrix, middle, size


def screws_of(touches: Touches) -> list[tuple[float, Floats, Floats, Floats]]:
    """The motions in the order of how freely they slip: the share, turn, slide, and a point of the axis."""
    matrix, middle, size = matrix_of(touches)
    values, vectors = np.linalg.eigh(matrix)
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        omega, slide = vector[:3], vector[3:] * size
        square = float(omega @ omega)
        point = middle + (np.cross(omega, slide) / square if square > 1e-6 else 0.0)
        found.append((float(value), omega, slide, point))
    return found


def ball_of(touches: Touches) -> Floats | None:
    """The middle of the ball that all normals of one side pass through, if they do."""
    for normals, of in ((touches.child_normals, touches.is_of_child), (touches.parent_normals, ~touches.is_of_child)):
        if np.count_nonzero(of) < 8:
            continue
        points, rows, weights = touches.points[of], normals[of], touches.weights[of] / touches.weights[of].sum()
        across = np.eye(3) - rows[:, :, None] * rows[:, None, :]
        matrix = np.einsum("i,ijk->jk", weights, across)
        if np.linalg.eigvalsh(matrix)[0] < 1e-3:
            continue
        middle = np.linalg.solve(matrix, np.einsum("i,ijk,ik->j", weights, across, points))
        off = np.linalg.norm(np.einsum("ijk,ik->ij", across, points - middle), axis=1)
        radius = np.sqrt(weights @ np.sum((points - middle) ** 2, axis=1))
        if weights @ (off > BALL * radius) < BALL_SHARE:
            return np.asarray(middle)
    return None


def taper_of(touches: Touches, axis: Floats) -> float:
    """The lean of a cone along an axis, as a sine; 0 unless nearly all of the surface in contact leans one way."""
    leans, weights = [], []
    for normals, of in ((touches.child_normals, touches.is_of_child), (touches.parent_normals, ~touches.is_of_child)):
        leans.append((normals @ axis)[of])
        weights.append(touches.weights[of])
    lean, weight = np.concatenate(leans), np.concatenate(weights)
    mean = float(weight @ lean / weight.sum())
    is_cone = np.abs(lean - mean) < TAPER_SPREAD * min(1.0, 4.0 * abs(mean))
    alike = float(weight @ is_cone) / float(weight.sum())
    return mean if abs(mean) > LEAST_TAPER and alike > TAPER_SHARE else 0.0


def pitch_of(touches: Touches, axis: Floats, point: Floats) -> float | None:
    """The pitch, metres a radian, at which a turn about an axis slips along the flanks of a thread, if these are one.

    Flanks lean so little that a turn without the pitch seems to slip too; that most agree on one pitch is the sign.
    """
    across, along, weights = [], [], []
    for normals, of in ((touches.child_normals, touches.is_of_child), (touches.parent_normals, ~touches.is_of_child)):
        rows = normals[of]
        lean = rows @ axis
        leans = np.abs(lean) > LEANS
        across.append(np.einsum("ij,ij->i", turn(touches, axis, point)[of], rows)[leans])
        along.append(lean[leans])
        weights.append((touches.weights[of] * np.abs(lean))[leans])
    turns, lifts, weight = (np.concatenate(each) for each in (across, along, weights))
    if len(turns) < 16 or weight.sum() < THREAD_SHARE * touches.weights.sum():
        return None
    values = -turns / lifts
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    pitch = float(values[order][np.searchsorted(total, total[-1] / 2)])
    if weight @ (np.abs(values - pitch) < 0.3 * abs(pitch)) < AGREED * total[-1]:
        return None
    return pitch


def waving_of(corners: Sequence[Floats], touches: Touches, axis: Floats, point: Floats, pitch: float) -> float:
    """The pitch, metres a radian, near another, in which the corners of a thread repeat best over all of its turns.

    The radius of a thread is a function of `height / pitch - angle`: its first waves are the largest at the pitch,
    however ragged corners are, while facets between these lean too little. `corners`: `(m, 3, 3)`, of each side.
    """
    leans = (np.abs(touches.child_normals @ axis) > LEANS) | (np.abs(touches.parent_normals @ axis) > LEANS)
    height, radius, _ = polar(touches.points[leans], axis, point)
    near, far = np.quantile(radius, [0.02, 0.98])
    near, far = near - BESIDE * (far - near), far + BESIDE * (far - near)
    rows = []
    for own in corners:
        heights, radii, angle = polar(own.reshape(-1, 3), axis, point)
        kept = np.flatnonzero((radii > near) & (radii < far) & (heights > height.min()) & (heights < height.max()))
        kept = kept[:: math.ceil(len(kept) / MOST_CORNERS) or 1]
        rows.append(np.column_stack([heights, angle, radii - (radii[kept].mean() if len(kept) else 0.0)])[kept])
    heights, angle, radii = np.concatenate(rows).T
    turned = float(np.ptp(heights)) / abs(pitch) if len(heights) else 0.0

    def power(value: float) -> float:
        wave = np.exp(1j * (heights / value - angle))
        return float(sum(np.abs(wave**k @ radii) ** 2 for k in range(1, WAVES + 1)))

    # the shortest wave falls together within one of its lengths over all turns
    step = 1.0 / max(turned * WAVES, 1.0)
    best = max(pitch * np.arange(1.0 - PITCH_OFF, 1.0 + PITCH_OFF, step), key=power)
    while step > PITCH_STEP:
        best = max(best + step * pitch * np.linspace(-1.0, 1.0, 9), key=power)
        step *= 0.25
    return float(best)


def winding_of(corners: Floats, axis: Floats, point: Floats, pitch: float) -> float:
    """The pitch, metres a radian, near another, of the edges that wind around an axis at one radius; `pitch` if too few
    do, as where corners are ragged.

    They go on: edges over a crest from flank to flank, which may keep their radius too, do not.
    """
    rounding = 2.0**-22 * float(np.abs(corners).max(initial=0.0))
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3) - point
    height = ends @ axis
    across = ends - height[:, :, None] * axis
    radius = np.linalg.norm(across, axis=2)
    begin, end = across[:, 0], across[:, 1]
    angle = np.arctan2(np.cross(begin, end) @ axis, np.einsum("ij,ij->i", begin, end))
    same = np.abs(radius[:, 0] - radius[:, 1]) < rounding + 1e-6 * radius.max(axis=1)
    winds = same & (np.abs(angle) > 0.01)
    ends, angle = ends[winds], angle[winds]
    rates = (height[winds, 1] - height[winds, 0]) / angle
    alike = np.abs(rates - pitch) < EVEN * abs(pitch)
    ends, rates, angle = ends[alike], rates[alike], angle[alike]
    ends[angle < 0.0] = ends[angle < 0.0][:, ::-1]
    places = np.round(ends / (4.0 * rounding or 1.0)).astype(np.int64).reshape(-1, 3)
    number = np.unique(places, axis=0, return_inverse=True)[1].reshape(-1, 2)
    found = rates[np.isin(number[:, 0], number[:, 1]) | np.isin(number[:, 1], number[:, 0])]
    return float(np.median(found)) if len(found) >= 8 else pitch
