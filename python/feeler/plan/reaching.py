"""`access`: can a tool reach fasteners, and how far can it swing there?"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_number, check_progress, check_threads, check_whole, shown
from feeler.choices import GripAxis
from feeler.errors import MeshError, OptionError, PoseError
from feeler.mockup import Tool
from feeler.plan.blocked import Blocker
from feeler.plan.fasteners import Fasteners
from feeler.plan.swings import Swing, Swings, turned, uncovered
from feeler.plan.tool_seat import SeatedTool, seated_tool
from feeler.poses import PoseLike, PosesLike, nearest_rigid, placed, pose_stack
from feeler.progress import Progress
from feeler.renamed import OldAttributes, keywords
from feeler.scene import Scene
from feeler.spreading import Interrupted, check_executor, spread
from feeler.stopping import check_stop

Floats = npt.NDArray[np.float64]
Hand = Tool | tuple[Tool, PoseLike]

LEAST_ANGLES, MOST_ANGLES = 4, 3600
"""Seats around the axis."""
FARTHEST_M = 1000.0
"""The longest way in, and the largest lift, metres: no wrench comes from farther away, and casts over distances at
which coordinates round by millimetres take for ever."""
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
NEAR_M = 0.02
"""The largest distance between the origin of a bare frame and its fastener, metres."""
UNDER_M = 1e-4
"""How far below that origin the search begins, so that the head comes first, metres."""
_POINT = np.array([[0.0, 0.0, 0.0], [1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0]])  # a tool as small as a point, metres


@dataclass(frozen=True, eq=False)  # it holds arrays
class Reach(OldAttributes):
    """The result for one target."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"swing": "swing_deg", "angle": "angle_deg", "reachable": "is_reachable"}

    target: int
    """Index of the target."""
    part: int | None
    """Its fastener, index into `mockup.parts`: the tool may touch it. None: no part is near the target."""
    path: str | None
    is_reachable: bool
    """Whether there is a way in to a free swing that is large enough."""
    swing_deg: float
    """The largest free swing with a way in, degrees, 360 for a full turn; without a way in, the largest free swing.
    Never too large."""
    angle_deg: float
    """Where it begins, degrees about the target's z from its x axis, 0 to 360. NaN without a swing."""
    pose: Floats
    """`(4, 4)` world_from_tool: the tool seated in the middle of the swing; at angle 0 without one."""
    way: Floats
    """`(k, 4, 4)` world_from_tool: the way in, to a seat within the swing; `(0, 4, 4)` if none was found."""
    looked: float
    """The distance from the seat over which a way in was searched, metres: `approach`."""
    drawn: float
    """How far the tool came out of its seat at best, metres: `looked` if a way was found, 0 without a free seat."""
    because: str
    """The reason for the answer, in words."""
    blockers: tuple[Blocker, ...]
    """The blockers, most frequent first."""


class Access(OldAttributes, Sequence[Reach]):
    """The results of `access`, one per target, in their order."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"swing": "swings_deg", "angle": "angles_deg", "reachable": "is_reachable"}

    def __init__(self, rows: Sequence[Reach], is_partial: bool = False) -> None:
        self._rows = tuple(rows)
        self.is_partial = is_partial
        """Whether it was interrupted, so that the last targets are missing."""

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Reach: ...
    @overload
    def __getitem__(self, index: slice) -> list[Reach]: ...
    def __getitem__(self, index: int | slice) -> Reach | list[Reach]:
        return list(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[Reach]:
        return iter(self._rows)

    @property
    def is_reachable(self) -> npt.NDArray[np.bool_]:
        """`(n,)`."""
        return np.array([row.is_reachable for row in self._rows], dtype=bool)

    @property
    def swings_deg(self) -> Floats:
        """`(n,)`, degrees."""
        return np.array([row.swing_deg for row in self._rows], dtype=np.float64)

    @property
    def angles_deg(self) -> Floats:
        """`(n,)`, degrees; NaN without a swing."""
        return np.array([row.angle_deg for row in self._rows], dtype=np.float64)

    @property
    def blockers(self) -> tuple[Blocker, ...]:
        """The blockers of all unreachable targets together, most frequent first."""
        counts: Counter[tuple[int, str]] = Counter()
        for row in self._rows:
            if not row.is_reachable:
                counts.update({(each.part, each.path): each.count for each in row.blockers})
        return tuple(Blocker(part, path, count) for (part, path), count in _worst_first(counts))

    def __repr__(self) -> str:
        partial = ", interrupted" if self.is_partial else ""
        return f"Access({int(self.is_reachable.sum()):,} of {len(self):,} reachable{partial})"


class AccessInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.access` has the answers for the targets finished by then."""

    def __init__(self, access: Access) -> None:
        self.access = access
        super().__init__(f"interrupted: {access!r}")

    def __reduce__(self) -> tuple[type[AccessInterrupted], tuple[Access]]:
        return (type(self), (self.access,))


@keywords({"swing": "swing_deg"})
def access(
    scene: Scene,
    tool: Tool,
    targets: Fasteners | PoseLike | PosesLike,
    swing_deg: float = 60.0,
    angles: int = 72,
    hand: Hand | None = None,
    approach: float = 0.1,
    *,
    grip: GripAxis | PoseLike | None = None,
    lift: float | npt.ArrayLike = 0.0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Access:
    """Whether the tool reaches each target, and how far it can swing there, about the target's z axis.

    The tool's frame is laid on the target's: origin on origin, z along z, turned about z by any angle. Every free swing
    of at least a thousandth of a degree is found, and none is reported larger than it is. Then a way in is searched
    over `approach` metres: straight along z, or else sideways, across z. `access` never claims that there is no way:
    each answer says how far it searched (`looked`) and how far the tool came out (`drawn`).

    - `targets`: `Fasteners`, or frames `(n, 4, 4)`, world_from_target, metres, z out of the joint. The tool may touch
      the fastener at the seat, while swinging, and on a straight way; not when it is pulled off sideways, so that a
      ring does not pass through the head. The fastener of a bare frame is the part nearest to its origin, up to 20 mm
      away.
    - `swing_deg`: the required degrees, above 0 up to 360.
    - `angles`: even steps around z that are tried first, and counted in `blockers`. Free swings do not depend on it.
    - `hand`: a tool in the tool's frame that moves with it, or `(hand, tool_from_hand)`.
    - `grip`: the target's frame in the tool's: `tool_from_target` `(4, 4)`, or the tool's axis that points out of the
      joint, about its origin: "y" for `sample_tool("wrench")`, whose jaw turns about y.
    - `lift`: metres by which the tool sits above the target's origin, one or one per target; negative: below.
    - `threads`: default: all.
    - `executor`: where the targets are worked on, as in `removals`; the answer depends on neither.

    Raises `OptionError` if there is no target, a number is out of range, or fasteners are of another mock-up,
    `PoseError` for frames that are not rigid, `MeshError` if the tool is not one, and `AccessInterrupted`, a
    `KeyboardInterrupt`, with the answers found before Ctrl-C.
    """
    if not isinstance(scene, Scene):
        raise MeshError(f"access needs a feeler.Scene, not {type(scene).__name__}")
    needed = check_number("swing_deg", swing_deg, "degrees, above 0 up to 360", above=0.0, most=360.0)
    way = check_number("approach", approach, "metres, above 0 up to 1,000", above=0.0, most=FARTHEST_M)
    steps = check_whole("angles", angles, LEAST_ANGLES, MOST_ANGLES)
    workers = check_threads(threads) or os.cpu_count() or 1
    check_progress(progress)
    seated = seated_tool(tool, hand, grip)
    frames, parts = _targets(scene, targets)
    frames = _lifted(frames, lift)
    targeted = [(i, frame, part) for i, (frame, part) in enumerate(zip(frames, parts, strict=True))]

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(targeted), stage or "reaching targets")

    is_alone = executor is not None or min(workers, len(targeted)) == 1
    own = None if is_alone else ThreadPoolExecutor(workers, thread_name_prefix="feeler-access")
    pool = check_executor(executor) or own
    try:
        return Access(spread(_reach, scene, _Asked(seated, needed, steps, way), targeted, pool, heard))
    except Interrupted as interrupted:
        rows = [row for _, row in sorted(interrupted.results.items())]
        raise AccessInterrupted(Access(rows, is_partial=len(rows) < len(targeted))) from None
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)


@dataclass(frozen=True)
class _Asked:
    """The arguments that all targets share."""

    seated: SeatedTool
    needed: float
    angles: int
    approach: float


def _reach(scene: Scene, asked: _Asked, targeted: tuple[int, Floats, int | None]) -> Reach:
    """The task of one target."""
    return _Question(scene, asked).reach(*targeted)


@dataclass
class _Drawn:
    """How far the tool came out at best, as a fraction of the way."""

    most: float = 0.0

    def came(self, share: float) -> None:
        """Records the fraction of one attempt."""
        self.most = max(self.most, share)


class _Question:
    """What is asked of each target."""

    def __init__(self, scene: Scene, asked: _Asked) -> None:
        self._scene, self._seated, self._needed, self._approach = scene, asked.seated, asked.needed, asked.approach
        self._angles = 360.0 * np.arange(asked.angles) / asked.angles
        self._swings = Swings(scene, asked.seated.tool)
        self._sides = [turned(side)[:3, :3] @ asked.seated.outward for side in SIDEWAYS]

    def reach(self, target: int, frame: Floats, part: int | None) -> Reach:
        """The result for one target."""
        scene, seated = self._scene, self._seated
        ignore = seated.ignoring(scene.mockup, part)
        blocked: Counter[int] = Counter()
        swings = self._swings.free(frame, self._angles, self._needed, ignore, blocked)
        drawn = _Drawn()
        found: Swing | None = None
        way = np.empty((0, 4, 4))
        for swing in swings:
            way = self._straight(frame, swing, ignore, blocked, drawn)
            if not len(way):
                way = self._sideways(frame, swing, part, blocked, drawn)
            if len(way):
                found = swing
                break
        best = found or (swings[0] if swings else None)
        reachable = found is not None and found.span >= self._needed
        paths = scene.mockup.part_paths
        middle = 0.0 if best is None else best.start + 0.5 * best.span
        return Reach(
            target=target,
            part=part,
            path=None if part is None else paths[part],
            is_reachable=reachable,
            swing_deg=0.0 if best is None else best.span,
            angle_deg=float("nan") if best is None else best.start,
            pose=frame @ turned(middle) @ seated.seat_from_tool,
            way=way @ seated.seat_from_tool if len(way) else way,
            looked=self._approach,
            drawn=drawn.most * self._approach,
            because=self._because(best, found, drawn.most * self._approach),
            blockers=tuple(Blocker(i, paths[i], count) for i, count in _worst_first(blocked)),
        )

    def _because(self, best: Swing | None, found: Swing | None, drawn: float) -> str:
        if best is None:
            return "the tool collides at every angle"
        looked, came = f"{1e3 * self._approach:g} mm", f"{1e3 * drawn:.3g} mm"
        if found is None:
            return (
                f"a swing of {best.span:.1f} degrees is free, but no way in was found within {looked}: "
                f"it comes out {came} at most"
            )
        enough = "" if found.span >= self._needed else f", of {self._needed:g} that are needed"
        return f"{found.span:.1f} degrees are free{enough}, with a way in over {looked}"

    def _straight(self, frame: Floats, swing: Swing, ignore: Any, blocked: Counter[int], drawn: _Drawn) -> Floats:
        """The way along z to one of the swing's seats, (2, 4, 4), found by casts outwards; (0, 4, 4) if there is none.

        A triangle that stops the tool rules out all angles at which it would stop it at that height.
        """
        scene, tool = self._scene, self._seated.tool
        closed = [] if swing.span == 360.0 else [(swing.start + swing.span, 360.0 - swing.span)]
        angle = swing.start + 0.5 * swing.span
        for _ in range(STRAIGHT_ANGLES):
            check_stop()
            seat = frame @ turned(angle)
            impact = scene.cast(tool, seat, _shifted(seat, self._approach * frame[:3, 2]), ignore=ignore)
            if impact is not None:
                blocked[impact.part] += 1
                drawn.came(impact.fraction)
                height = impact.fraction * self._approach
            elif not self._is_inside(_shifted(seat, self._approach * frame[:3, 2]), ignore, blocked):
                drawn.came(1.0)
                return np.stack([_shifted(seat, self._approach * frame[:3, 2]), seat])
            else:
                height = self._approach
            lifted = _shifted(frame, (height + BEYOND_M) * frame[:3, 2])
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
        for angle in _spread(swing):
            seat = frame @ turned(angle)
            for side in self._sides:
                check_stop()
                out = _shifted(seat, self._approach * (seat[:3, :3] @ side))
                impact = scene.cast(tool, seat, out)
                if impact is not None and impact.part == part and impact.fraction == 0.0:
                    impact = scene.cast(tool, seat, out, touching="free")  # lets a jaw without play slide off
                if impact is not None:
                    drawn.came(impact.fraction)
                    if impact.part != part:
                        blocked[impact.part] += 1
                elif not self._is_inside(out, None, blocked):
                    drawn.came(1.0)
                    return np.stack([out, seat])
        return np.empty((0, 4, 4))

    def _is_inside(self, pose: Floats, ignore: Any, blocked: Counter[int]) -> bool:
        """Whether the tool is inside a part, or contains one, without a collision."""
        found = self._scene.containment(self._seated.tool, pose, ignore=ignore)
        blocked.update([*found.containing.tolist(), *found.contained.tolist()])
        return bool(found)


def _targets(scene: Scene, targets: Fasteners | PoseLike | PosesLike) -> tuple[Floats, list[int | None]]:
    """Frames (n, 4, 4), and their fasteners."""
    mockup = scene.mockup
    if isinstance(targets, Fasteners):
        if not len(targets):
            raise OptionError("there are no targets: no fastener is among these; give frames (n, 4, 4) instead")
        for row in targets:
            if not (row.part < mockup.part_count and mockup.part_paths[row.part] == row.path):
                raise OptionError(f"fastener {row.path!r} is of another mock-up: find those of the scene's")
        return targets.frames, [row.part for row in targets]
    if isinstance(targets, str):
        raise PoseError(
            f"targets is {shown(targets)}: give feeler.find_fasteners(mockup, {shown(targets)}), or frames (n, 4, 4)"
        )
    given: object = targets
    if isinstance(given, (Sequence, np.ndarray)) and (given.size == 0 if isinstance(given, np.ndarray) else not given):
        raise OptionError("there are no targets: give feeler.Fasteners or frames (n, 4, 4)")
    frames = pose_stack(targets, "targets")
    for i, frame in enumerate(frames):
        placed(np.zeros((1, 3)), frame, f"target {i}")
    frames = nearest_rigid(frames)
    point = Tool(_POINT, [[0, 1, 2]])
    parts: list[int | None] = []
    for frame in frames:
        under = _shifted(frame, -UNDER_M * frame[:3, 2])
        parts.append(scene.distance(point, under, within=NEAR_M).part)
    return frames, parts


def _lifted(frames: Floats, lift: float | npt.ArrayLike) -> Floats:
    try:
        heights = np.asarray(lift, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        heights = np.array(np.nan)
    if heights.shape not in ((), (len(frames),)) or not (np.abs(heights) <= FARTHEST_M).all():
        raise OptionError(
            f"lift is {shown(lift)}: give metres, -1,000 to 1,000, one number or one for each of {len(frames)} targets"
        )
    lifted = frames.copy()
    lifted[:, :3, 3] += np.broadcast_to(heights, len(frames))[:, None] * frames[:, :3, 2]
    return np.asarray(lifted)


def _shifted(pose: Floats, by: Floats) -> Floats:
    shifted: Floats = pose.copy()
    shifted[:3, 3] += by
    return shifted


def _spread(swing: Swing) -> list[float]:
    """Angles of a swing from its middle outwards, evenly spread."""
    shares = np.arange(SIDEWAYS_ANGLES) / (SIDEWAYS_ANGLES - (swing.span < 360.0))
    outwards = sorted([0.5, *shares.tolist()], key=lambda share: (abs(share - 0.5), share))
    return [swing.start + share * swing.span for share in dict.fromkeys(outwards)]


def _worst_first(counts: Counter[Any]) -> list[tuple[Any, int]]:
    return sorted(counts.items(), key=lambda item: (-item[1], item[0]))
