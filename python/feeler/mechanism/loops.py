"""Loops of joints: the joints that are not given follow those that are, by Newton on the cut joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.errors import MechanismError
from feeler.mechanism.joint import Joint, JointKind
from feeler.poses import inverse, rotation_vector

Floats = npt.NDArray[np.float64]

STEP = 0.05
"""The largest step of a given number on the way to a position, radians or metres."""
LEAST_SHARE = 1e-7
"""A way that cannot be followed in steps of this share ends."""
CLOSED = 1e-11
"""The residual of a closed loop, in units of its size."""
RANK = 1e-7
"""A Jacobian whose least singular value is below this share of the largest has lost its rank."""
_MOST_STEPS = 30
_MOST_POLISH = 6
_POLISH = 1e-3
_FINE = 1e-14
_BENT = 1e-10  # larger steps of a polish need a new Jacobian
_DIFFERENCE = 1e-6
_CLOSED_BY = 1e-9  # what is left of closed loops moves numbers by less
_HELPS = 0.2  # a Jacobian that leaves more of the residual than this is made anew
_NEAR = 1e-3  # below this share of the largest singular value, positions are polished
_BEND = 0.25  # a step leaves the tangents at its ends by at most this share
_FARTHEST = 0.5  # that a joint may follow in a step, radians, or in sizes of the mechanism


def residual(joint: Joint, relative: Floats, size: float) -> Floats:
    """How far a cut joint is open: `relative` is the motion of its child against its parent; lengths in `size`."""
    axis, point = np.array(joint.axis), np.array(joint.point)
    moved = (relative[:3, :3] @ point + relative[:3, 3] - point) / size
    if joint.kind is JointKind.FIXED:
        return np.concatenate([moved, rotation_vector(relative[:3, :3])])
    if joint.kind is JointKind.PRISMATIC:
        return np.concatenate([moved - axis * (axis @ moved), rotation_vector(relative[:3, :3])])
    turned = relative[:3, :3] @ axis - axis
    if joint.kind is JointKind.REVOLUTE:
        return np.concatenate([moved, turned])
    if joint.kind is JointKind.SCREW:
        angle = float(axis @ rotation_vector(relative[:3, :3]))
        advance = float(axis @ moved) * size
        turns = round((advance - joint.pitch * angle / math.tau) / joint.pitch)
        along = (advance - joint.pitch * (angle / math.tau + turns)) / size
        return np.concatenate([moved - axis * (axis @ moved), [along], turned])
    return np.concatenate([moved - axis * (axis @ moved), turned])


def opening(joint: Joint, parent: Floats, child: Floats, size: float) -> Floats:
    """`residual` of the poses of both links in the world."""
    return residual(joint, inverse(parent) @ child, size)


class Follower:
    """Follows the numbers that are not given from one position to another."""

    def __init__(self, open_by: Callable[[Floats, Floats], Floats], scales: Floats, told: Callable[[Floats], str]):
        """open_by: the residual of given and followed numbers. scales: a unit of each followed number. told: a position
        in words."""
        self._open_by, self._scales, self._told = open_by, scales, told

    def follow(self, start: Floats, found: Floats, end: Floats) -> Floats:
        """The followed numbers at the end. Raises `MechanismError` where the way ends."""
        share = 0.0
        way = end - start
        before = self._jacobian(start, found)
        self._check_rank(before, start)
        closed = self._newton(start, found, before)
        found = found if closed is None else closed
        tangent = self._tangent(start, found, before, way)
        longest = float(np.abs(end - start).max()) if len(end) else 0.0
        step = most = 1.0 if longest == 0.0 else min(1.0, STEP / longest)
        while share < 1.0:
            there = min(1.0, share + step)
            given = start + there * way
            place = self._next(given, found, before, way)
            if place is None or not self._is_smooth(there - share, way, place[0] - found, (tangent, place[2])):
                step /= 2.0
                if step < LEAST_SHARE:
                    raise MechanismError(f"the mechanism has a dead point at {self._told(given)}, where its way ends")
                continue
            share, (found, before, tangent) = there, place
            step = min(most, 2.0 * step)
        return self._polished(end, found, before)

    def _next(self, given: Floats, begin: Floats, before: Floats, way: Floats) -> tuple[Floats, Floats, Floats] | None:
        """The followed numbers at a place nearby, their Jacobian and tangent; None where they do not follow."""
        found = self._newton(given, begin, before)
        if found is None:
            return None
        jacobian = self._jacobian(given, found)
        if self._is_lost(jacobian, _NEAR):
            found = self._polished(given, found, jacobian)
            jacobian = self._jacobian(given, found)
        if self._is_lost(jacobian) or _is_crossed(before, jacobian):
            return None
        return found, jacobian, self._tangent(given, found, jacobian, way)

    def _tangent(self, given: Floats, found: Floats, jacobian: Floats, way: Floats) -> Floats:
        """How the followed numbers move with the share of the way, in their scales."""
        length = float(np.linalg.norm(way))
        by = _DIFFERENCE * way / (length or 1.0)
        rate = (self._open_by(given + by, found) - self._open_by(given - by, found)) * (length / (2.0 * _DIFFERENCE))
        return np.asarray(-np.linalg.pinv(jacobian) @ rate, dtype=np.float64)

    def _is_smooth(self, share: float, way: Floats, moved: Floats, tangents: tuple[Floats, Floats]) -> bool:
        """Whether a step follows the tangents at both its ends: where two ways cross, such as those of a parallelogram
        whose bars lie in line, a step from one to the other does not."""
        forward = float(np.linalg.norm(way))
        return all(
            float(np.linalg.norm(moved / self._scales - share * tangent))
            <= _BEND * share * math.hypot(forward, float(np.linalg.norm(tangent))) + _CLOSED_BY
            for tangent in tangents
        )

    def _newton(self, given: Floats, begin: Floats, jacobian: Floats) -> Floats | None:
        """Of the followed numbers; the Jacobian of a position nearby serves as long as it helps."""
        found: Floats = begin.copy()
        back, last = np.linalg.pinv(jacobian), np.inf
        for _ in range(_MOST_STEPS):
            left = self._open_by(given, found)
            size = float(np.abs(left).max(initial=0.0))
            if size <= CLOSED:
                return found
            if size > _HELPS * last:
                back = np.linalg.pinv(self._jacobian(given, found))
            last = size
            found = np.asarray(found - (back @ left) * self._scales, dtype=np.float64)
            if not np.isfinite(found).all() or (np.abs(found - begin) > _FARTHEST * self._scales).any():
                return None
        return None

    def _polished(self, given: Floats, found: Floats, jacobian: Floats) -> Floats:
        """Closer, as long as steps shrink: near a dead point a small residual leaves a large error."""
        back, last = np.linalg.pinv(jacobian), _POLISH
        for _ in range(_MOST_POLISH):
            by = back @ self._open_by(given, found)
            size = float(np.abs(by).max(initial=0.0))
            if size <= _FINE or size >= last:
                return found
            found, last = np.asarray(found - by * self._scales, dtype=np.float64), 0.5 * size
            if size > _BENT:
                back = np.linalg.pinv(self._jacobian(given, found))
        return found

    def _jacobian(self, given: Floats, found: Floats) -> Floats:
        columns = []
        for number, scale in enumerate(self._scales):
            by = np.zeros(len(found))
            by[number] = _DIFFERENCE * scale
            columns.append((self._open_by(given, found + by) - self._open_by(given, found - by)) / (2.0 * _DIFFERENCE))
        return np.column_stack(columns)

    @staticmethod
    def _is_lost(jacobian: Floats, least: float = RANK) -> bool:
        values: Sequence[float] = np.linalg.svd(jacobian, compute_uv=False).tolist()
        return len(values) < jacobian.shape[1] or values[-1] <= least * max(values[0], RANK)

    def _check_rank(self, jacobian: Floats, given: Floats) -> None:
        if self._is_lost(jacobian):
            raise MechanismError(
                f"the loop is at a dead point at {self._told(given)}, or has more freedom than is given: the other "
                "joints do not follow from these; give another joint too, or begin elsewhere"
            )


def _is_crossed(before: Floats, now: Floats) -> bool:
    """Whether a Jacobian has lost its rank on the way from another: in one direction, or in several at once."""
    left, _, right = np.linalg.svd(before, full_matrices=False)
    along = np.einsum("ij,ik,jk->j", left, now, right)
    return bool((along <= 0.0).any() or np.linalg.det(before.T @ now) <= 0.0)
