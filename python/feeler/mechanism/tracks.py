"""Animations of glTF as motions of parts, and what parts meet on the way."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from feeler._core import Chain, Distance
from feeler.arguments import check_flag, check_number, check_path, check_progress, shown
from feeler.choices import TOUCHINGS, UpAxis
from feeler.errors import OptionError
from feeler.ignored import IgnoredPairs
from feeler.io import axes
from feeler.io.gltf_animation import read_animation
from feeler.io.load import load_with_nodes
from feeler.mechanism.answers import MechanismClashes, MechanismClearance, MechanismContact, MechanismSeat, Vector
from feeler.mechanism.seating import TOLERANCE_M
from feeler.mechanism.track_motion import SAME, Moves, Piece, Step, seen_from
from feeler.mechanism.track_seats import Met, TrackSeat, seats_at, turn_of
from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.parts import PartsLike
from feeler.poses import inverse
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.words import plural

Floats = npt.NDArray[np.float64]
PathLike = str | os.PathLike[str]

CURVE = 61
"""Times at which the curve of a clearance has a row."""
SPLINE_M = 1e-4
"""By how much points may leave the motion of a spline, unless it is given, metres."""
_MOST_CUTS = 24
"""Times that a piece of a spline is halved."""
_CLOSE_M = 1e-7
"""By how much points may leave the motion of a spline where a seat seems to go deeper, metres."""
_WHOLE = -2


def load_tracks(
    path: PathLike, animation: str | int | None = None, *, up: UpAxis | None = None, progress: Progress | None = None
) -> Tracks:
    """An animation of a glTF file as motions of its parts. See docs/mechanisms.md.

    path: a .glb or .gltf file. animation: its name or number; None: the only one. up: as in `load_mockup`.

    Translations and rotations of nodes are read, LINEAR, STEP and CUBICSPLINE, also of nodes below each other.
    Raises `LoadError` for files without animations, those that scale, bend or shear parts, and damaged ones, and
    `OptionError` for an animation that is not there.
    """
    file = check_path("path", path)
    check_progress(progress)
    mockup, nodes, own = load_with_nodes(file, up, progress)
    found = read_animation(file, animation)
    base = np.eye(4)
    wanted = axes.parse_axis(up)
    if wanted is not None and own is not None and wanted != own:
        base[:3, :3] = axes.turn(np.eye(3), own, wanted).T
    body_of = [found.mover.get(node, -1) for node in nodes]
    return Tracks(mockup, Moves(found.nodes, base, str(file)), body_of, found.name, found.names)


_Near = tuple[int, int, Distance]


class Tracks:
    """Motions of parts over time, as `load_tracks` reads them. Times are seconds.

    The mock-up has the parts at rest, where the scene of the file puts them, which need not be where the animation
    begins. Before `start` and after `end` all parts stand still. Parts that hang on the same moved node are one body.
    """

    def __init__(self, mockup: Mockup, moves: Moves, body_of: Sequence[int], name: str, names: tuple[str, ...]) -> None:
        self._mockup, self._moves, self._body_of = mockup, moves, np.array(body_of, dtype=np.int64)
        self._name, self._names = name, names
        self._times = moves.times(list(moves.nodes))
        self._bodies = [n for n in [*moves.nodes, -1] if (self._body_of == n).any()]
        self._tools: dict[int, Tool] = {}
        self._reaches: dict[int, float] = {}
        self._scenes: dict[int, Scene] = {}
        self._meshes = PartMeshes(mockup)

    def __repr__(self) -> str:
        return f"Tracks({self._name!r}, {self.start:g} to {self.end:g} s, {plural(len(self.moving), 'moving part')})"

    @property
    def mockup(self) -> Mockup:
        """The parts at rest."""
        return self._mockup

    @property
    def name(self) -> str:
        """The name of the animation."""
        return self._name

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all animations of the file."""
        return self._names

    @property
    def times(self) -> Floats:
        """`(k,)`: the times of all keys, ascending."""
        return np.array(self._times)

    @property
    def start(self) -> float:
        """The first time."""
        return float(self._times[0])

    @property
    def end(self) -> float:
        """The last time."""
        return float(self._times[-1])

    @property
    def moving(self) -> tuple[str, ...]:
        """The paths of the parts that move."""
        return tuple(self._mockup.part_paths[i] for i in np.flatnonzero(self._body_of >= 0))

    def poses(self, time: float) -> dict[str, Floats]:
        """The pose `(4, 4)` of each moving part at a time, by its path; the identity is where it is at rest."""
        found = self._moves.poses(self._time("time", time))
        paths = self._mockup.part_paths
        return {paths[i]: found[int(self._body_of[i])].copy() for i in np.flatnonzero(self._body_of >= 0)}

    def scene(self, time: float) -> Scene:
        """A scene with the parts at a time; parts keep their numbers and names, and the index is shared."""
        found = self._moves.poses(self._time("time", time))
        return self._whole().moved({tuple(self._parts(body)): found[body] for body in self._bodies if body >= 0})

    def chain(self, parts: PartsLike, error: float = SPLINE_M) -> list[Chain | Floats]:
        """The motion of parts that move as one, from `start` to `end`, as `Scene.check_path` takes it: a pose, and
        chains. Times at which they stand still are left out.

        Exact for LINEAR and STEP; splines are followed to within `error`, metres. Raises `OptionError` for parts that
        move against each other or stand still, and where a STEP makes them jump.
        """
        error = check_number("error", error, "metres, more than 0", above=0.0)
        bodies = set(self._body_of[self._mockup.parts.select(parts)].tolist())
        if len(bodies) != 1 or -1 in bodies:
            moves = ", ".join(self.moving[:5]) + (", ..." if len(self.moving) > 5 else "")
            raise OptionError(f"{shown(parts)} do not move as one: give parts of one moved node, of {moves}")
        found: list[Chain | Floats] = []
        last: Floats | None = None
        for step in self._steps(bodies.pop(), -1, self.start, self.end, error):
            if last is None:
                found.append(step.pose)
            elif np.abs(step.pose - last).max() > SAME:
                raise OptionError(f"{shown(parts)} jump at {step.begin:g} s (STEP): ask clearance() or clash()")
            last = step.pose
            if step.joints:
                chain = Chain(step.joints)
                found.append(chain)
                last = np.asarray(chain.at(step.pose), dtype=np.float64)
        return found

    def clearance(
        self,
        error: float = 1e-4,
        *,
        start: float | None = None,
        end: float | None = None,
        ignore_touching: bool = True,
    ) -> MechanismClearance:
        """Bounds of the least gap between parts that move against each other, from `start` to `end`.

        error: the gap of the two bounds, metres. `worst` is `{"time": seconds}`, and `curve` is `(n, 3)`: a time, the
        gap there, and `lower`. Pieces between keys of LINEAR and STEP are exact chains; splines are cut until they
        leave a chain by less than a quarter of the error, which the bounds contain.

        ignore_touching: pairs in contact at `start`, such as a pin in its hole, have no gap; `seats` names them. They
        may slide and separate, but where one goes deeper than there, or meets elsewhere, both bounds are 0 and `jams`
        names it. False: all pairs are asked.
        """
        error = check_number("error", error, "metres, more than 0", above=0.0)
        begin, stop = self._span(start, end)
        check_flag("ignore_touching", ignore_touching)
        lower, best = math.inf, math.inf
        worst, asked = begin, 0
        near: _Near | None = None
        seats: list[MechanismSeat] = []
        jams: list[MechanismContact] = []
        ignored: list[IgnoredPairs | None] = []
        for one, other in self._pairs():
            held = self._seats(one, other, begin, stop) if ignore_touching else []
            ignore = self._ignored(one, [(each.seat.number, each.seat.other) for each in held])
            ignored.append(ignore)
            seats += [self._seat(each) for each in held]
            jams += [met for each in held if (met := self._jam(one, other, each, begin, stop)) is not None]
            tool, around = self._tool(one), self._alone(other)
            for step in self._steps(one, other, begin, stop, error / 4.0):
                asked += 1
                if best == 0.0:
                    break
                at = step.begin
                if step.joints:
                    way = Chain(step.joints)
                    within = best + 2.0 * step.error
                    along = around.clearance_along(tool, step.pose, way, error / 2.0, within=within, ignore=ignore)
                    lower = min(lower, along.lower - step.error)
                    if not math.isfinite(along.upper):
                        continue
                    at = self._when(one, other, step, along.fraction)
                found = around.distance(tool, self._relative(one, other, at), best, ignore=ignore)
                if found.value < best:
                    best, worst, near = found.value, at, (one, other, found)
        part = other_part = points = None
        if near is not None:
            part, other_part, points = self._told(near, worst)
        if jams:
            jams.sort(key=lambda each: (each.value, each.part, each.other))
            first = jams[0]
            best, worst, part, other_part, points = 0.0, first.value, first.part, first.other, (first.point,) * 2
        lower = max(0.0, min(lower, best))
        rows = [(t, self._gap(t, ignored), lower) for t in np.linspace(begin, stop, CURVE).tolist()]
        rows = [(t, 0.0 if jams and t >= worst else gap, lower) for t, gap, lower in rows]
        paths = self._mockup.part_paths
        return MechanismClearance(
            lower,
            best,
            {"time": worst},
            part,
            other_part,
            "" if part is None else paths[part],
            "" if other_part is None else paths[other_part],
            points,
            asked,
            0.0,
            tuple(seats),
            np.array(rows),
            jams=tuple(jams),
        )

    def clash(
        self,
        error: float = SPLINE_M,
        *,
        start: float | None = None,
        end: float | None = None,
        ignore_touching: bool = True,
    ) -> MechanismClashes:
        """The pairs of parts that clash at some time, each with its first one in `value`, seconds.

        Never late for LINEAR and STEP; splines are followed to within `error`, metres. Pairs in contact at `start`
        clash where they go deeper than there, as in `clearance`.
        """
        error = check_number("error", error, "metres, more than 0", above=0.0)
        begin, stop = self._span(start, end)
        check_flag("ignore_touching", ignore_touching)
        contacts: list[MechanismContact] = []
        seats: list[MechanismSeat] = []
        for one, other in self._pairs():
            held = self._seats(one, other, begin, stop) if ignore_touching else []
            skipped = {(each.seat.number, each.seat.other) for each in held}
            seats += [self._seat(each) for each in held]
            contacts += [jam for each in held if (jam := self._jam(one, other, each, begin, stop)) is not None]
            for step in self._steps(one, other, begin, stop, error):
                while (met := self._first(one, other, step, skipped)) is not None:
                    contacts.append(met[0])
                    skipped.add(met[1])
        contacts.sort(key=lambda each: (each.value, each.part, each.other))
        return MechanismClashes("time", begin, stop, tuple(contacts), tuple(seats))

    def _first(
        self, one: int, other: int, step: Step, skipped: set[tuple[int, int]]
    ) -> tuple[MechanismContact, tuple[int, int]] | None:
        """The first contact of two bodies in a step, of pairs that are not skipped."""
        tool, around = self._tool(one), self._alone(other)
        ignore = self._ignored(one, sorted(skipped))
        way = Chain(step.joints) if step.joints else None
        last = step.pose if way is None else None
        hit = None
        for touching in TOUCHINGS:
            hit = around.cast(tool, step.pose, last, screw=way, tolerance=TOLERANCE_M, touching=touching, ignore=ignore)
            if hit is None:
                return None
            if hit.fraction > 0.0:
                break
        assert hit is not None
        when = self._when(one, other, step, hit.fraction)
        pair = (self._parts(one)[hit.tool_part], hit.part)
        return self._contact(pair, other, (when, hit.point, hit.normal)), (hit.tool_part, hit.part)

    def _contact(self, pair: tuple[int, int], other: int, met: Met) -> MechanismContact:
        """A meeting with a body, in the world."""
        when, point, normal = met
        there = self._moves.poses(when)[other] if other >= 0 else np.eye(4)
        x, y, z = (float(v) for v in there[:3, :3] @ point + there[:3, 3])
        i, j, k = (float(v) for v in there[:3, :3] @ normal)
        paths = self._mockup.part_paths
        return MechanismContact(when, *pair, paths[pair[0]], paths[pair[1]], (x, y, z), (i, j, k))

    def _gap(self, time: float, ignored: Sequence[IgnoredPairs | None]) -> float:
        """The least gap at a time, metres."""
        least = math.inf
        found = self._moves.poses(time)
        for (one, other), ignore in zip(self._pairs(), ignored, strict=True):
            pose = found[one] if other < 0 else inverse(found[other]) @ found[one]
            least = min(least, self._alone(other).distance(self._tool(one), pose, least, ignore=ignore).value)
        return least

    def _time(self, what: str, time: object) -> float:
        return check_number(what, time, "seconds")

    def _span(self, start: object, end: object) -> tuple[float, float]:
        begin = self.start if start is None else self._time("start", start)
        stop = self.end if end is None else self._time("end", end)
        if begin > stop:
            raise OptionError(f"start is {begin:g} s and end {stop:g} s: give a start before the end")
        return begin, stop

    def _parts(self, body: int) -> list[int]:
        return [int(part) for part in np.flatnonzero(self._body_of == body)]

    def _tool(self, body: int) -> Tool:
        if body not in self._tools:
            self._tools[body] = Tool.of_parts(self._mockup, self._parts(body))
        return self._tools[body]

    def _alone(self, body: int) -> Scene:
        if body not in self._scenes:
            self._scenes[body] = self._whole().only(self._parts(body))
        return self._scenes[body]

    def _whole(self) -> Scene:
        if _WHOLE not in self._scenes:
            self._scenes[_WHOLE] = Scene(self._mockup)
        return self._scenes[_WHOLE]

    def _pairs(self) -> Iterator[tuple[int, int]]:
        """The bodies that move against each other: the one as a tool, the other as a scene."""
        for place, one in enumerate(self._bodies):
            for other in self._bodies[place + 1 :]:
                yield one, other

    def _relative(self, one: int, other: int, time: float) -> Floats:
        """The pose of a body in the frame of another at rest."""
        found = self._moves.poses(time)
        return found[one] if other < 0 else np.asarray(inverse(found[other]) @ found[one], dtype=np.float64)

    def _when(self, one: int, other: int, step: Step, share: float) -> float:
        """The time after a share of a step; of its end the time just before, if a STEP makes a body jump there."""
        found = step.begin + share * (step.end - step.begin)
        if not step.joints or found < step.end:
            return found
        ended = np.asarray(Chain(step.joints).at(step.pose), dtype=np.float64)
        jumps = np.abs(self._relative(one, other, step.end) - ended).max() > SAME + step.error
        return math.nextafter(step.end, step.begin) if jumps else step.end

    def _steps(self, one: int, other: int, begin: float, stop: float, error: float) -> Iterator[Step]:
        """How a body moves against another; steps at which they stand as before are left out."""
        up, down = self._moves.above(one), self._moves.above(other)
        shared = 0
        while shared < min(len(up), len(down)) and up[shared] == down[shared]:
            shared += 1
        still = up[:shared]
        keys = self._moves.times([*up[shared:], *down[shared:]])
        edges = [begin, *keys[(keys > begin) & (keys < stop)].tolist(), stop]
        last: Floats | None = None
        for first, after in itertools.pairwise(edges):
            for early, late, pieces in self._cut(up, down, still, (first, after), error):
                mine, theirs = pieces
                found = self._moves.poses(early, list(dict.fromkeys([*up, *down])), still)
                back = inverse(found[other]) if other >= 0 else np.eye(4)
                chains = [Chain([seen_from(joint, back) for joint in each.joints]) for each in (mine, theirs)]
                joints = chains[0].relative_to(chains[1]).joints if theirs.joints else chains[0].joints
                step = Step(early, late, back @ found[one], joints, mine.error + theirs.error)
                if step.joints or last is None or np.abs(step.pose - last).max() > SAME:
                    yield step
                    last = step.pose
                    if step.joints:
                        last = np.asarray(Chain(step.joints).at(step.pose), dtype=np.float64)
        final = self._relative(one, other, stop)
        if last is None or np.abs(final - last).max() > SAME:
            yield Step(stop, stop, final, (), 0.0)

    def _cut(
        self, up: list[int], down: list[int], still: list[int], span: tuple[float, float], error: float
    ) -> Iterator[tuple[float, float, tuple[Piece, Piece]]]:
        """Pieces of both ways between two keys, halved until chains follow them to within an error."""
        reaches = [self._reach(way[-1] if way else -1) for way in (up, down)]
        left = [(*span, 0)]
        while left:
            early, late, depth = left.pop()
            mine, theirs = (
                self._moves.piece(way, still, early, late, reach)
                for way, reach in zip((up, down), reaches, strict=True)
            )
            middle = 0.5 * (early + late)
            if mine.error + theirs.error > error and depth < _MOST_CUTS and early < middle < late:
                left += [(middle, late, depth + 1), (early, middle, depth + 1)]
            else:
                yield early, late, (mine, theirs)

    def _reach(self, body: int) -> float:
        """How far points of a body are from the origin of its node, metres."""
        if body < 0:
            return 0.0
        if body not in self._reaches:
            points = np.asarray(self._tool(body).vertices, dtype=np.float64) - self._moves.rest_origin(body)
            self._reaches[body] = float(np.linalg.norm(points, axis=1).max())
        return self._reaches[body]

    def _ignored(self, one: int, pairs: Sequence[tuple[int, int]]) -> IgnoredPairs | None:
        return IgnoredPairs(self._tool(one), self._mockup, np.array(pairs, dtype=np.int64)) if pairs else None

    def _seats(self, one: int, other: int, begin: float, stop: float) -> list[TrackSeat]:
        """The pairs of parts of two bodies that are in contact at a time."""
        turn = turn_of(self._steps(one, other, begin, stop, SPLINE_M))
        pose = self._relative(one, other, begin)
        return seats_at(self._meshes, self._whole(), self._parts(one), self._parts(other), pose, turn)

    def _seat(self, held: TrackSeat) -> MechanismSeat:
        seat, paths = held.seat, self._mockup.part_paths
        return MechanismSeat(seat.part, seat.other, paths[seat.part], paths[seat.other], seat.kind)

    def _jam(self, one: int, other: int, held: TrackSeat, begin: float, stop: float) -> MechanismContact | None:
        """Where a seat first goes deeper; splines are followed closely where they seem to meet."""
        for step in self._steps(one, other, begin, stop, SPLINE_M):
            if held.meets(step) is None:
                continue
            close = [step] if step.error <= _CLOSE_M else self._steps(one, other, step.begin, step.end, _CLOSE_M)
            for each in close:
                if (met := held.meets(each)) is not None:
                    return self._contact((held.seat.part, held.seat.other), other, met)
        return None

    def _told(self, near: _Near, time: float) -> tuple[int, int, tuple[Vector, Vector]]:
        """The parts and points, in the world, of a distance."""
        one, other, found = near
        there = self._moves.poses(time)[other] if other >= 0 else np.eye(4)
        ends = []
        for point in (found.point_on_tool, found.point_on_mockup):
            x, y, z = there[:3, :3] @ np.asarray(point, dtype=np.float64) + there[:3, 3]
            ends.append((float(x), float(y), float(z)))
        assert found.part is not None and found.tool_part is not None
        return self._parts(one)[found.tool_part], found.part, (ends[0], ends[1])
