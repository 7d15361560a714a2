"""Proven bounds of how far the joints of a loop are from a straight motion between two closed positions.

On a leg all roots move at constant rates, so the residual of the loops is a smooth function `f` of the share `s` of it:
between two shares `h` apart it is at most `h^2 max |f''| / 8` from the straight line between its values there.
Krawczyk's test (Moore, Kearfott and Cloud 2009, chapter 8) with that as the residual, and bounds of second derivatives
in place of interval arithmetic, gives a box of the followed roots around the straight motion in which the loops close
in at most one place at each `s`. The first box holds the start of the leg, so these places are the branch that is
followed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from feeler.mechanism.joint import Joint, JointKind
from feeler.mechanism.legs import Leg, halves
from feeler.mechanism.positions import Positions
from feeler.poses import inverse

Floats = npt.NDArray[np.float64]

_DIFFERENCE = 1e-5
_ROUNDING = 1e-13
"""Of residuals, in the size of the mechanism."""
_SLOPE_ERROR = 1e-8
"""Of their first derivatives by differences, the second ones being bounded by a few sizes."""
_SPANS = 8
"""Shares of a leg at which its residual is known."""
_WIDEST = 0.01
"""No box is wider, radians or sizes."""
_MOST_CUTS = 10
_MOST_LEGS = 5000
_GROWTH = (1.1, 1.5, 3.0, 8.0)


def enclosure(mechanism: Positions, name: str, at: Mapping[str, float], leg: Leg) -> dict[str, float] | None:
    """By how much each number may differ from the leg where the loops close, radians or metres; None: not proven."""
    found: dict[str, float] = {}
    given = {mechanism.driven[each].root for each in (*at, name)}
    for group, loops in mechanism.groups:
        if mechanism.driven[name].root not in group:
            continue
        closed = _Closed(mechanism, sorted(group), sorted(group - given), loops, leg)
        box = closed.box()
        if box is None:
            return None
        for number, by in mechanism.driven.items():
            found[number] = abs(by.ratio) * box.get(by.root, 0.0)
    return found


def _closing(joint: Joint, relative: Floats, size: float) -> Floats:
    """Six numbers that are zero where a cut joint is closed: three of places, in sizes, and three of turns."""
    axis, point = np.array(joint.axis), np.array(joint.point)
    moved = (relative[:3, :3] @ point + relative[:3, 3] - point) / size
    if joint.kind in (JointKind.PRISMATIC, JointKind.CYLINDRICAL):
        moved = moved - axis * (axis @ moved)
    if joint.kind in (JointKind.PRISMATIC, JointKind.FIXED):
        turn = relative[:3, :3] - relative[:3, :3].T  # of length two times the sine of the angle
        return np.concatenate([moved, 0.5 * np.array([turn[2, 1], turn[0, 2], turn[1, 0]])])
    return np.concatenate([moved, relative[:3, :3] @ axis - axis])


class _Closed:
    def __init__(self, mechanism: Positions, roots: list[str], followed: list[str], loops: list[int], leg: Leg) -> None:
        self._mechanism, self._roots, self._followed, self._loops, self._leg = mechanism, roots, followed, loops, leg
        self._size = mechanism.size
        self._steps = np.array([abs(leg.end[name] - leg.start[name]) for name in roots])
        self._column = [roots.index(name) for name in followed]

    def box(self) -> dict[str, float] | None:
        """Half-widths of the followed roots."""
        if not self._followed or any(self._mechanism.closing[n].kind is JointKind.SCREW for n in self._loops):
            return None
        size, middle = self._size, self._leg.at(0.5)
        slope = self._slope(middle)
        if np.linalg.matrix_rank(slope) < len(self._followed):
            return None
        back = np.linalg.pinv(slope)
        curve = self._curve()
        bend = np.einsum("kij,i,j->k", curve, self._steps, self._steps) / (8.0 * _SPANS**2)
        shares = np.linspace(0.0, 1.0, _SPANS + 1).tolist()
        known = np.abs([back @ self._open(self._leg.at(share)) for share in shares]).max(axis=0)
        least = known + np.abs(back) @ (bend + _ROUNDING * self._far())
        rest = np.abs(np.eye(len(self._followed)) - back @ slope)
        for growth in _GROWTH:
            half = growth * least
            around = 0.5 * self._steps
            around[self._column] += half
            # how far the slopes are from those in the middle
            change = (curve @ around)[:, self._column] + _SLOPE_ERROR * max(1.0, 1.0 / size) * self._far()
            if (half > self._widest()).any():
                return None
            if (least + (rest + np.abs(back) @ change) @ half < half).all():
                return dict(zip(self._followed, (half * (1.0 + 1e-9)).tolist(), strict=True))
        return None

    def _far(self) -> float:
        """By how much rounding grows with the distance from the origin."""
        points = [joint.point for joint in (*self._mechanism.joints, *self._mechanism.closing)]
        return 1.0 + float(np.abs(points).max()) / self._size

    def _widest(self) -> Floats:
        return np.array([_WIDEST * (1.0 if self._mechanism.turns(name) else self._size) for name in self._followed])

    def _open(self, place: Mapping[str, float]) -> Floats:
        poses = self._mechanism.links.poses(place)
        rows = []
        for number in self._loops:
            parent, child = self._mechanism._ends[number]
            rows.append(_closing(self._mechanism.closing[number], inverse(poses[parent]) @ poses[child], self._size))
        return np.concatenate(rows)

    def _slope(self, middle: Mapping[str, float]) -> Floats:
        columns = []
        for root in self._followed:
            by = _DIFFERENCE * (1.0 if self._mechanism.turns(root) else self._size)
            ends = []
            for sign in (1.0, -1.0):
                moved = {
                    name: value + sign * by * driven.ratio
                    for name, value in middle.items()
                    if (driven := self._mechanism.driven[name]).root == root
                }
                ends.append(self._open({**middle, **moved}))
            columns.append((ends[0] - ends[1]) / (2.0 * by))
        return np.column_stack(columns)

    def _curve(self) -> Floats:
        """Bounds of the second derivatives: `(k, n, n)`, of each residual by two roots."""
        rows = []
        for number in self._loops:
            joint, (parent, child) = self._mechanism.closing[number], self._mechanism._ends[number]
            links = self._mechanism.links
            up, down = links.between(parent, child)
            joints = [links.links[n].joint for n in (*up, *reversed(down))]
            reach = self._reach(joints, joint)
            place, turn = (np.zeros((len(self._roots),) * 2) for _ in range(2))
            rates = [
                (self._roots.index(by.root), abs(by.ratio), turns, abs(each.pitch) / math.tau)
                for each in joints
                for name, turns in zip(each.names, each.turns, strict=True)
                if (by := self._mechanism.driven[name]).root in self._roots
            ]
            for i, one, turns, rise in rates:
                for j, other, also, more in rates:
                    # the one nearer the parent turns what the other moves; slides bend nothing
                    lever = (reach + rise + more if turns and also else float(turns or also)) / self._size
                    place[i, j] += one * other * lever
                    turn[i, j] += one * other * float(turns and also)
            rows += [place] * 3 + [turn] * 3
        return np.array(rows)

    def _reach(self, joints: list[Joint], loop: Joint) -> float:
        """No axis of the loop's joints is farther from its point, at any position near the leg."""
        points = [np.array(each.point) for each in (*joints, loop)]
        far = sum(float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(points))
        for each in joints:
            for name, turns in zip(each.names, each.turns, strict=True):
                slide, near = (abs(each.pitch) / math.tau, _WIDEST) if turns else (1.0, _WIDEST * self._size)
                far += slide * (max(abs(self._leg.start[name]), abs(self._leg.end[name])) + near)
        return far


def sure_legs(
    mechanism: Positions,
    name: str,
    at: Mapping[str, float],
    legs: Iterable[Leg],
    levers: Sequence[Mapping[str, float]],
    near: float,
) -> list[tuple[Leg, list[float]]]:
    """Legs of a loop, cut until no point is proven farther than `near`, metres, from where it should be, with these
    bounds for each of several pairs of links; infinite where nothing is proven.

    levers: for each pair by name of a number how far points move for a unit of it.
    """
    found: list[tuple[Leg, list[float]]] = []
    waiting = [(leg, 0) for leg in reversed(list(legs))]
    while waiting:
        leg, depth = waiting.pop()
        box = enclosure(mechanism, name, at, leg)
        spreads = [
            math.inf if box is None else sum(box.get(number, 0.0) * lever for number, lever in each.items())
            for each in levers
        ]
        if max(spreads, default=0.0) > near and depth < _MOST_CUTS and len(found) + len(waiting) < _MOST_LEGS:
            waiting += [(half, depth + 1) for half in reversed(halves(mechanism, name, at, leg))]
        else:
            found.append((leg, spreads))
    return found
