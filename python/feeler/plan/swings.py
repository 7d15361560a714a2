"""The free swings of a tool about an axis: every free interval of angles, not only those hit by even steps.

From a free seat, casts find how far the tool swings both ways. A blocked seat rules out all angles around it over which
one of its colliding pairs of triangles keeps colliding. The next seats are in the middle of what neither covers.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler._core import Cast, Screw
from feeler.ignored import IgnoredPairs
from feeler.mockup import Tool
from feeler.plan.pair_turns import angular_spans, blocked_turns
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

FINEST_DEG = 1e-3
"""Free swings at least this wide are found, degrees. A smaller value finds narrower ones, with more seats where many
small triangles border on each other."""
SWING_TOLERANCE_M = 1e-7
"""The most by which a swing may end before its first contact, metres. With a smaller value, swings are more complete
and casts take longer."""
BORDER_DEG = 0.02
"""The most by which the pair of triangles that ended a swing begins to collide beyond that end, degrees."""
PAIRS_A_SEAT = 4
"""Pairs of triangles by which a blocked seat rules out its neighbours. More: fewer seats, each with more work."""
PAIRS_COMPARED = 256
"""Pairs among which these are chosen. More: wider intervals, with more work."""
COARSE = 8
"""One in this many of the first seats is tested before the others, which leaves fewer of them to test."""
_BEFORE_ALL = float(np.nextafter(1.0, 0.0))  # the largest fraction that is not all of a step


@dataclass(frozen=True)
class Swing:
    """A free swing, degrees: from `start`, over `span`."""

    start: float
    span: float

    def holds(self, angle: float) -> bool:
        """Whether it contains a seat."""
        return (angle - self.start) % 360.0 <= self.span


class Swings:
    """Finds the free swings of a tool about the z axis of a frame."""

    def __init__(self, scene: Scene, tool: Tool) -> None:
        self._scene, self._tool = scene, tool
        self._turning = tool.vertices[tool.faces]

    def free(
        self, frame: Floats, seats: Floats, needed: float, ignore: IgnoredPairs | None, blocked: Counter[int]
    ) -> list[Swing]:
        """The free swings, degrees, the largest first.

        `seats`: angles to test first; `blocked` counts the parts hit at these and by casts. If a swing is found, free
        gaps narrower than it and than `needed` may be missing.
        """
        found: list[Swing] = []
        covered: list[tuple[float, float]] = []
        is_counted = True
        waiting = [seats[::COARSE], np.delete(seats, np.s_[::COARSE])]
        while waiting:
            met: list[tuple[float, Floats, Floats]] = []
            for angle in waiting.pop(0).tolist():
                if any(swing.holds(angle) for swing in found):
                    continue
                contacts = self._scene.collide(self._tool, frame @ turned(angle), ignore=ignore)
                if len(contacts):
                    if is_counted:
                        blocked.update(contacts.parts.tolist())
                    if not _holds(covered, angle):
                        met.append((angle, *self._widest(frame, angle, contacts.pairs)))
                    continue
                swing, ends = self._swung(frame, angle, ignore, blocked)
                if swing.span == 360.0:
                    return [swing]
                found.append(swing)
                covered.append((swing.start, swing.span))
                met += ends
            covered += _ruled_out(met)
            if waiting:
                continue
            is_counted = False
            least = max(FINEST_DEG, min(needed, max((swing.span for swing in found), default=0.0)))
            middles = [low + 0.5 * span for low, span in uncovered(covered) if span > least]
            if middles:
                waiting.append(np.array(middles))
        return sorted(found, key=lambda swing: (-swing.span, swing.start))

    def at_least(self, frame: Floats, needed: float, ignore: IgnoredPairs | None, blocked: Counter[int]) -> list[Swing]:
        """The free swings of at least `needed` degrees, the largest first; smaller ones if they are met.

        Each of these contains one of the seats that are less than `needed` apart.
        """
        count = math.floor(360.0 / needed) + 1
        found: list[Swing] = []
        for angle in (360.0 * np.arange(count) / count).tolist():
            if any(swing.holds(angle) for swing in found):
                continue
            contacts = self._scene.collide(self._tool, frame @ turned(angle), ignore=ignore)
            blocked.update(contacts.parts.tolist())
            if not len(contacts):
                ahead, first = self._cast(frame, angle, 360.0, ignore, blocked)
                if first is None:
                    return [Swing(0.0, 360.0)]
                behind, _ = self._cast(frame, angle, ahead - 360.0, ignore, blocked)
                found.append(Swing((angle - behind) % 360.0, ahead + behind))
        return sorted(found, key=lambda swing: (-swing.span, swing.start))

    def ruled_out(self, frame: Floats, angle: float, ignore: IgnoredPairs | None) -> list[tuple[float, float]]:
        """Angles around a seat over which its collision persists: start and extent, degrees. Empty if it is free."""
        contacts = self._scene.collide(self._tool, frame @ turned(angle), ignore=ignore)
        return _ruled_out([(angle, *self._widest(frame, angle, contacts.pairs))]) if len(contacts) else []

    def _swung(
        self, frame: Floats, angle: float, ignore: IgnoredPairs | None, blocked: Counter[int]
    ) -> tuple[Swing, list[tuple[float, Floats, Floats]]]:
        """The swing around a free seat, and the pairs of triangles that end it."""
        ahead, first = self._cast(frame, angle, 360.0, ignore, blocked)
        if first is None:
            return Swing(0.0, 360.0), []
        behind, second = self._cast(frame, angle, ahead - 360.0, ignore, blocked)
        ends = []
        for end, way, impact in ((angle + ahead, 1.0, first), (angle - behind, -1.0, second)):
            if impact is not None:
                pair = np.array([[impact.tool_triangle, impact.mockup_triangle]])
                beyond = end + way * BORDER_DEG
                ends += [(beyond, *self._widest(frame, beyond, pair))]
        return Swing((angle - behind) % 360.0, ahead + behind), ends

    def _cast(
        self, frame: Floats, angle: float, by: float, ignore: IgnoredPairs | None, blocked: Counter[int]
    ) -> tuple[float, Cast | None]:
        """Degrees that are free from a seat on, up to a given number; all of them only without a hit."""
        screw = Screw(frame[:3, 2], frame[:3, 3], np.radians(by))
        seat = frame @ turned(angle)
        impact = self._scene.cast(self._tool, seat, screw=screw, tolerance=SWING_TOLERANCE_M, ignore=ignore)
        if impact is None:
            return abs(by), None
        blocked[impact.part] += 1
        return min(impact.fraction, _BEFORE_ALL) * abs(by), impact

    def _widest(self, frame: Floats, angle: float, pairs: npt.NDArray[np.integer]) -> tuple[Floats, Floats]:
        """The pairs that may collide over the most angles: the tool's triangles at a seat, the mock-up's, in the
        frame."""
        mockup = self._scene.mockup
        pairs = pairs[:: 1 + len(pairs) // PAIRS_COMPARED]
        turning = self._turning[pairs[:, 0]] @ turned(angle)[:3, :3].T
        fixed = (mockup.vertices[mockup.faces[pairs[:, 1]]] - frame[:3, 3]) @ frame[:3, :3]
        if len(pairs) > PAIRS_A_SEAT:
            widths = angular_spans(turning)[1] + angular_spans(fixed)[1]
            widest = np.argsort(-widths, kind="stable")[:PAIRS_A_SEAT]
            turning, fixed = turning[widest], fixed[widest]
        return turning, fixed


def _holds(covered: list[tuple[float, float]], angle: float) -> bool:
    return any((angle - start) % 360.0 <= span for start, span in covered)


def _ruled_out(met: list[tuple[float, Floats, Floats]]) -> list[tuple[float, float]]:
    """Angles over which pairs keep colliding around each seat: start and extent, degrees."""
    if not met:
        return []
    angles = np.repeat([angle for angle, _, _ in met], [len(turning) for _, turning, _ in met])
    low, high = blocked_turns(np.concatenate([each[1] for each in met]), np.concatenate([each[2] for each in met]))
    low = np.minimum(np.degrees(low), -0.5 * FINEST_DEG)
    high = np.maximum(np.degrees(high), 0.5 * FINEST_DEG)
    return list(zip((angles + low).tolist(), (high - low).tolist(), strict=True))


def uncovered(covered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The part of the circle that intervals (start, extent), degrees, leave, in the same form; all of it for none."""
    if not covered:
        return [(0.0, 360.0)]
    starts = np.array([start for start, _ in covered]) % 360.0
    spans = np.array([span for _, span in covered])
    order = np.argsort(starts)
    starts, reach = starts[order], np.maximum.accumulate((starts + spans)[order])
    # An interval that extends over 360 covers the one that begins after 0.
    ends = np.maximum(reach, reach[-1] - 360.0)
    following = np.append(starts[1:], starts[0] + 360.0)
    spans = following - ends
    return [(float(end % 360.0), float(span)) for end, span in zip(ends, spans, strict=True) if span > 0.0]


def turned(degrees: float) -> Floats:
    """(4, 4): a rotation about z."""
    angle = np.radians(degrees)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turn
