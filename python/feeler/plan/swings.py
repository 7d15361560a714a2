"""The free swings of a tool about an axis: every free interval of angles, not only those that even steps hit.

A seat that is free is swung both ways by casts. A seat that is blocked rules out all angles around it at which one of
the pairs of triangles that meet there goes on meeting. The next seats are in the middle of what neither covers.
"""

from __future__ import annotations

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
"""A free swing at least this wide is found, degrees. Smaller: narrower ones are found, where many small triangles
border on each other with more seats."""
SWING_TOLERANCE_M = 1e-7
"""How far before its first contact a swing may end, metres. Smaller: swings come closer to what is free, casts take
longer."""
BORDER_DEG = 0.02
"""How far beyond the end of a swing the pair of triangles that ended it begins to meet, at most, degrees."""
PAIRS_A_SEAT = 4
"""Pairs of triangles by which a blocked seat rules out its neighbours. More: fewer seats, each with more work."""
PAIRS_COMPARED = 256
"""Pairs among which these are chosen. More: wider ones are chosen, with more work."""
COARSE = 8
"""One in so many of the first seats is looked at before the others, of which then fewer are left to rule out."""
_BEFORE_ALL = float(np.nextafter(1.0, 0.0))  # the largest fraction that is not all of a step


@dataclass(frozen=True)
class Swing:
    """A free swing, degrees: from `start`, over `span`."""

    start: float
    span: float

    def holds(self, angle: float) -> bool:
        """Whether a seat is in it."""
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

        `seats`: angles that are looked at first; `blocked` counts the parts that are met at these and by casts. Where a
        swing is found, free gaps that are narrower than it and than `needed` may be left out.
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

    def ruled_out(self, frame: Floats, angle: float, ignore: IgnoredPairs | None) -> list[tuple[float, float]]:
        """Angles around a seat at which what meets there goes on meeting: from, how far; degrees. Empty: it is free."""
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
        """Degrees that are free from a seat on, of so many either way; all of them only where nothing is met."""
        screw = Screw(frame[:3, 2], frame[:3, 3], np.radians(by))
        seat = frame @ turned(angle)
        impact = self._scene.cast(self._tool, seat, screw=screw, tolerance=SWING_TOLERANCE_M, ignore=ignore)
        if impact is None:
            return abs(by), None
        blocked[impact.part] += 1
        return min(impact.fraction, _BEFORE_ALL) * abs(by), impact

    def _widest(self, frame: Floats, angle: float, pairs: npt.NDArray[np.integer]) -> tuple[Floats, Floats]:
        """The pairs that may meet over the most angles: the tool's triangles at a seat, the mock-up's, in the frame."""
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
    """Angles at which pairs go on meeting around each seat: from, how far; degrees."""
    if not met:
        return []
    angles = np.repeat([angle for angle, _, _ in met], [len(turning) for _, turning, _ in met])
    low, high = blocked_turns(np.concatenate([each[1] for each in met]), np.concatenate([each[2] for each in met]))
    low = np.minimum(np.degrees(low), -0.5 * FINEST_DEG)
    high = np.maximum(np.degrees(high), 0.5 * FINEST_DEG)
    return list(zip((angles + low).tolist(), (high - low).tolist(), strict=True))


def uncovered(covered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """What intervals (from, how far), degrees, leave of the circle, in the same form; the whole circle for none."""
    if not covered:
        return [(0.0, 360.0)]
    starts = np.array([start for start, _ in covered]) % 360.0
    spans = np.array([span for _, span in covered])
    order = np.argsort(starts)
    starts, reach = starts[order], np.maximum.accumulate((starts + spans)[order])
    # What reaches over 360 covers what begins behind 0.
    ends = np.maximum(reach, reach[-1] - 360.0)
    following = np.append(starts[1:], starts[0] + 360.0)
    spans = following - ends
    return [(float(end % 360.0), float(span)) for end, span in zip(ends, spans, strict=True) if span > 0.0]


def turned(degrees: float) -> Floats:
    """(4, 4): a turn about z."""
    angle = np.radians(degrees)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turn
