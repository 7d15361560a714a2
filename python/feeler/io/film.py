"""Films of moving parts: their timing, and the selection of parts to show nearby."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from feeler.io.body import FloatArray
from feeler.io.export import Motion
from feeler.mockup import Mockup

CONTEXT_M = 0.1
"""A film shows the moving parts, and those whose boxes are at most this far from their start."""
PAUSE_S = 0.5
"""Pause between two ways."""
STILL_S = 0.02
"""Time between two equal poses."""
_M_PER_S, _LEAST_S, _MOST_S = 0.25, 1.0, 20.0


def way_length(way: Sequence[FloatArray] | FloatArray) -> float:
    """The travel of the origin of the moving parts along poses `(n, 4, 4)`, metres."""
    places = np.array([pose[:3, 3] for pose in way])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def seconds_of(length: float) -> float:
    """Duration of a way in a film, by its length in metres."""
    return min(_MOST_S, max(_LEAST_S, length / _M_PER_S))


def moments(poses: FloatArray, bounds: FloatArray) -> FloatArray:
    """The time of each pose `(n, 4, 4)` in a film, seconds from 0 on, strictly ascending. The fastest corner of the box
    `bounds` `(2, 3)` of the moving parts, in the frame of the poses, moves at constant speed."""
    places = corners_of(bounds) @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=2).max(axis=1)
    gone = np.concatenate([[0.0], np.cumsum(lengths)])
    if gone[-1] == 0.0:
        return np.arange(len(poses), dtype=np.float64)
    # A pose without motion gets some time of its own: a frame of a slow film.
    moved = seconds_of(float(gone[-1])) * gone / gone[-1]
    return np.asarray(moved + STILL_S * np.cumsum(np.concatenate([[0.0], lengths == 0.0])), dtype=np.float64)


def corners_of(bounds: FloatArray) -> FloatArray:
    """The corners `(8, 3)` of a box `(2, 3)`."""
    return np.array([[bounds[i, 0], bounds[j, 1], bounds[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


class Leg(NamedTuple):
    """A way of some parts. poses: `(n, 4, 4)` their motion in the world; starts: world_from_part `(4, 4)` of each part
    when it begins."""

    poses: FloatArray
    starts: Mapping[int, FloatArray]


def motions_of(legs: Sequence[Leg], mockup: Mockup, place: Mapping[int, int]) -> list[Motion]:
    """The motions of all parts of legs that follow one another, with a pause after each. place: the number of each part
    in the film."""
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    times: dict[int, list[float]] = {}
    poses: dict[int, list[FloatArray]] = {}
    for leg in legs:
        for part, start in leg.starts.items():
            times.setdefault(part, [0.0])
            poses.setdefault(part, [start])
    now = 0.0
    for leg in legs:
        placed = [corners_of(boxes[part]) @ at[:3, :3].T + at[:3, 3] for part, at in leg.starts.items()]
        corners = np.concatenate(placed)
        shown_at = moments(leg.poses, np.stack([corners.min(axis=0), corners.max(axis=0)]))
        for part, start in leg.starts.items():
            for moment, pose in zip(shown_at.tolist(), leg.poses, strict=True):
                if now + moment > times[part][-1]:
                    times[part].append(now + moment)
                    poses[part].append(pose @ start)
        now += float(shown_at[-1]) + PAUSE_S
        for part in leg.starts:
            # It rests until its next motion.
            times[part].append(now)
            poses[part].append(poses[part][-1])
    return [motion_of(place[part], np.array(times[part]), np.stack(poses[part])) for part in sorted(times)]


def motion_of(part: int, times: FloatArray, poses: FloatArray) -> Motion:
    """The motion of a part of a film. Films keep times as float32: times that would be equal then are moved apart."""
    kept = times.astype(np.float32)
    for place in np.flatnonzero(np.diff(kept) <= 0.0).tolist():
        # Each may push the next one on.
        after = place + 1
        while after < len(kept) and kept[after] <= kept[after - 1]:
            kept[after] = np.nextafter(kept[after - 1], np.float32(np.inf))
            after += 1
    return Motion(part, kept.astype(np.float64), poses)


def with_neighbours(mockup: Mockup, moving: Sequence[int], absent: Sequence[int] = ()) -> list[int]:
    """The moving parts and those near them, ascending, without parts that are absent."""
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    near = np.zeros(len(boxes), dtype=bool)
    for part in moving:
        lower, upper = boxes[part, 0] - CONTEXT_M, boxes[part, 1] + CONTEXT_M
        near |= ((boxes[:, 0] <= upper) & (boxes[:, 1] >= lower)).all(axis=1)
    near[list(moving)] = True
    near[list(absent)] = False
    shown: list[int] = np.flatnonzero(near).tolist()
    return shown
