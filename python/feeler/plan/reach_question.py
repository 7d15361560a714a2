"""One tool at one target: seats, swings and ways in, found by casts."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.ignored import IgnoredPairs
from feeler.plan.blocked import Blocker
from feeler.plan.gloves import wide_swings
from feeler.plan.reach import Reach, worst_first
from feeler.plan.swings import FINEST_DEG, Swing, Swings, turned, uncovered
from feeler.plan.tool_seat import SeatedTool, ignoring
from feeler.scene import Scene
from feeler.stopping import check_stop

Floats = npt.NDArray[np.float64]

SIDEWAYS_ANGLES = 24
"""Angles of each free swing from which the tool is pulled off sideways: evenly spread, the middle first."""
STRAIGHT_ANGLES = 48
"""Angles of each free swing from which it is pulled off straight. A larger value finds narrower slots above the seat,
and takes longer for targets without a way."""
STRAIGHT_DEG = 0.1
"""Angles that differ less are one in the search for a straight way, degrees."""
BEYOND_M = 1e-6
"""How far beyond an impact the tool collides with the parts that stopped it, metres."""
SIDEWAYS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
"""Directions across the axis, degrees from the handle, in which the tool is pulled off sideways."""
OVER_ANGLES = 9
"""Angles of each free swing from which a tool that encloses the head is lifted off, and then pulled away sideways."""
OVER_M = 1e-3
"""How far above the head it is lifted, metres."""


@dataclass(frozen=True)
class SeatSearch:
    """What is asked of a tool at all targets. Metres and degrees."""

    needed: float
    """The swing that it needs."""
    angles: int
    """Even seats that are tried first."""
    approach: float
    """The length of a way in."""
    clearance: float
    """How far the hand, or what stands for it, stays from all parts."""
    is_strict: bool = False
    """Whether smaller swings are of no interest."""


@dataclass
class _Drawn:
    """How far the tool came out at best, as a fraction of the way."""

    most: float = 0.0

    def came(self, share: float) -> None:
        """Records the fraction of one attempt."""
        self.most = max(self.most, share)


class ReachQuestion:
    """One tool, at one target after the other."""

    def __init__(self, scene: Scene, seated: SeatedTool, search: SeatSearch) -> None:
        self._scene, self._seated, self._search = scene, seated, search
        self._angles = 360.0 * np.arange(search.angles) / search.angles
        self._swings = Swings(scene, seated.tool)
        self._sides = [turned(side)[:3, :3] @ seated.outward for side in SIDEWAYS]

    def reach(self, target: int, frame: Floats, part: int | None) -> Reach:
        """The result for one target."""
        scene, search = self._scene, self._search
        ignore = ignoring(self._seated.tool, scene.mockup, part)
        blocked: Counter[int] = Counter()
        if search.is_strict:
            swings = self._swings.at_least(frame, search.needed, ignore, blocked)
        else:
            swings = self._swings.free(frame, self._angles, search.needed, ignore, blocked)
        if search.clearance > 0.0:
            swings = wide_swings(scene, self._seated.kept, frame, swings, search.clearance, part, blocked)
        drawn = _Drawn()
        found: Swing | None = None
        way = np.empty((0, 4, 4))
        for swing in swings:
            if search.is_strict and swing.span < search.needed:
                break
            way = self._way(frame, swing, part, ignore, blocked, drawn)
            if len(way):
                found = swing
                break
        best = found or (swings[0] if swings else None)
        reachable = found is not None and found.span >= search.needed
        paths = scene.mockup.part_paths
        middle = 0.0 if best is None else best.start + 0.5 * best.span
        seat_from_tool = self._seated.seat_from_tool
        return Reach(
            target=target,
            part=part,
            path=None if part is None else paths[part],
            is_reachable=reachable,
            swing_deg=0.0 if best is None else best.span,
            angle_deg=float("nan") if best is None else best.start,
            pose=frame @ turned(middle) @ seat_from_tool,
            way=way @ seat_from_tool if len(way) else way,
            looked=search.approach,
            drawn=drawn.most * search.approach,
            because=self._because(best, found, drawn.most * search.approach),
            blockers=self._named(blocked),
            tool=self._seated.tool.name,
        )

    def _named(self, blocked: Counter[int]) -> tuple[Blocker, ...]:
        paths = self._scene.mockup.part_paths
        return tuple(Blocker(i, paths[i], count) for i, count in worst_first(blocked))

    def _because(self, best: Swing | None, found: Swing | None, drawn: float) -> str:
        search = self._search
        glove = f" with {1e3 * search.clearance:g} mm around the hand" if search.clearance > 0.0 else ""
        if best is None and search.is_strict:
            return f"no swing of {search.needed:g} degrees is free{glove}"
        if best is None:
            return f"no seat is free{glove}" if glove else f"no swing of {FINEST_DEG:g} degrees or more is free"
        enough = "" if best.span >= search.needed else f", of {search.needed:g} that are needed"
        looked, came = f"{1e3 * search.approach:g} mm", f"{1e3 * drawn:.3g} mm"
        if found is None and enough and search.is_strict:
            return f"{best.span:.1f} degrees are free{glove}{enough}"
        if found is None:
            return (
                f"a swing of {best.span:.1f} degrees is free{glove}, but no way in was found within {looked}: "
                f"it comes out {came} at most"
            )
        return f"{found.span:.1f} degrees are free{glove}{enough}, with a way in over {looked}"

    def _way(
        self, frame: Floats, swing: Swing, part: int | None, ignore: Any, blocked: Counter[int], drawn: _Drawn
    ) -> Floats:
        """A way in to one of the swing's seats, (k, 4, 4); (0, 4, 4) if none was found."""
        way = self._straight(frame, swing, ignore, part, blocked, drawn)
        if not len(way) and not self._seated.is_around:
            way = self._sideways(frame, swing, part, blocked, drawn)
        if not len(way) and self._seated.depth > 0.0:
            way = self._over(frame, swing, ignore, part, blocked, drawn)
        return way

    def _straight(
        self, frame: Floats, swing: Swing, ignore: Any, part: int | None, blocked: Counter[int], drawn: _Drawn
    ) -> Floats:
        """The way along z to one of the swing's seats, (2, 4, 4), found by casts outwards; (0, 4, 4) if there is none.

        A triangle that stops the tool rules out all angles at which it would stop it at that height.
        """
        scene, tool, approach = self._scene, self._seated.tool, self._search.approach
        if self._seated.core is not None:
            within = ignoring(self._seated.core, scene.mockup, part)
            impact = scene.cast(self._seated.core, frame, shifted(frame, approach * frame[:3, 2]), ignore=within)
            if impact is not None:
                blocked[impact.part] += 1
                drawn.came(impact.fraction)
                return np.empty((0, 4, 4))
        closed = [] if swing.span == 360.0 else [(swing.start + swing.span, 360.0 - swing.span)]
        angle = swing.start + 0.5 * swing.span
        for _ in range(STRAIGHT_ANGLES):
            check_stop()
            seat = frame @ turned(angle)
            out = shifted(seat, approach * frame[:3, 2])
            impact = scene.cast(tool, seat, out, ignore=ignore)
            if impact is not None:
                blocked[impact.part] += 1
                drawn.came(impact.fraction)
                height = impact.fraction * approach
            elif self._is_way([out, seat], ignore, part, blocked):
                drawn.came(1.0)
                return np.stack([out, seat])
            else:
                height = approach
            lifted = shifted(frame, (height + BEYOND_M) * frame[:3, 2])
            closed += [(angle - 0.5 * STRAIGHT_DEG, STRAIGHT_DEG), *self._swings.ruled_out(lifted, angle, ignore)]
            gaps = uncovered(closed)
            if not gaps:
                break
            low, span = max(gaps, key=lambda gap: (gap[1], -gap[0]))
            angle = low + 0.5 * span
        return np.empty((0, 4, 4))

    def _sideways(self, frame: Floats, swing: Swing, part: int | None, blocked: Counter[int], drawn: _Drawn) -> Floats:
        """The way across z to one of the swing's seats, (2, 4, 4); (0, 4, 4) if none was found."""
        scene, tool = self._scene, self._seated.tool
        for angle in self._seats_of(swing):
            seat = frame @ turned(angle)
            for side in self._sides:
                check_stop()
                out = shifted(seat, self._search.approach * (seat[:3, :3] @ side))
                impact = scene.cast(tool, seat, out)
                if impact is not None and impact.part == part and impact.fraction == 0.0:
                    impact = scene.cast(tool, seat, out, touching="free")  # lets a jaw without play slide off
                if impact is not None:
                    drawn.came(impact.fraction)
                    if impact.part != part:
                        blocked[impact.part] += 1
                elif self._is_way([out, seat], None, part, blocked):
                    drawn.came(1.0)
                    return np.stack([out, seat])
        return np.empty((0, 4, 4))

    def _over(
        self, frame: Floats, swing: Swing, ignore: Any, part: int | None, blocked: Counter[int], drawn: _Drawn
    ) -> Floats:
        """The way off the head along z, and then across z, (3, 4, 4); (0, 4, 4) if none was found."""
        scene, tool = self._scene, self._seated.tool
        lift = self._seated.depth + OVER_M
        for angle in spread_over(swing, OVER_ANGLES):
            seat = frame @ turned(angle)
            above = shifted(seat, lift * frame[:3, 2])
            impact = scene.cast(tool, seat, above, ignore=ignore)
            if impact is not None:
                blocked[impact.part] += 1
                drawn.came(impact.fraction * min(1.0, lift / self._search.approach))
                continue
            for side in self._sides:
                check_stop()
                out = shifted(above, self._search.approach * (seat[:3, :3] @ side))
                impact = scene.cast(tool, above, out)
                if impact is not None:
                    blocked[impact.part] += 1
                    drawn.came(impact.fraction)
                elif self._is_way([out, above, seat], None, part, blocked):
                    drawn.came(1.0)
                    return np.stack([out, above, seat])
        return np.empty((0, 4, 4))

    def _seats_of(self, swing: Swing) -> list[float]:
        """Angles from which the tool is pulled off sideways: those at which it is on the flats first."""
        step = self._seated.aligned_deg
        on_flats = []
        if step is not None:
            first = np.ceil(swing.start / step) * step
            on_flats = np.arange(first, swing.start + swing.span + 1e-9, step).tolist()
            middle = swing.start + 0.5 * swing.span
            on_flats.sort(key=lambda angle: (abs(angle - middle), angle))
        return [*on_flats, *spread_over(swing, SIDEWAYS_ANGLES)]

    def _is_way(self, poses: list[Floats], ignore: Any, part: int | None, blocked: Counter[int]) -> bool:
        """Whether the tool is off at the first pose, and its hand has room on the way, of which casts say that it is
        free."""
        scene, seated, search = self._scene, self._seated, self._search
        if self._is_inside(poses[0], ignore, blocked):
            return False
        if seated.plug is not None:
            through = scene.collide(seated.plug, poses[0]).parts
            blocked.update(through.tolist())
            if len(through):
                return False
        if search.clearance == 0.0:
            return True
        least = search.clearance
        kept = ignoring(seated.kept, scene.mockup, part)
        for start, end in zip(poses[1:], poses[:-1], strict=True):
            error = min(1e-4, 0.1 * least)
            near = scene.clearance_along(seated.kept, start, end, error, within=2.0 * least, ignore=kept)
            if near.lower < least:
                if near.part is not None:
                    blocked[near.part] += 1
                return False
        return True

    def _is_inside(self, pose: Floats, ignore: IgnoredPairs | None, blocked: Counter[int]) -> bool:
        """Whether the tool is inside a part, or contains one, without a collision."""
        found = self._scene.containment(self._seated.tool, pose, ignore=ignore)
        blocked.update([*found.containing.tolist(), *found.contained.tolist()])
        return bool(found)


def shifted(pose: Floats, by: Floats) -> Floats:
    """A pose moved by a vector (3,), metres, world."""
    moved: Floats = pose.copy()
    moved[:3, 3] += by
    return moved


def spread_over(swing: Swing, count: int) -> list[float]:
    """Angles of a swing from its middle outwards, evenly spread."""
    shares = np.arange(count) / (count - (swing.span < 360.0))
    outwards = sorted([0.5, *shares.tolist()], key=lambda share: (abs(share - 0.5), share))
    return [swing.start + share * swing.span for share in dict.fromkeys(outwards)]
