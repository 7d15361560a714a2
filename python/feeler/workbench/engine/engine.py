"""The engine: takes the newest wish of the hand, returns an immutable snapshot of its contacts.

`tick()` does one round, on a clock that is passed in; a thread only calls it in a loop. The hand's motion and
collisions are computed completely in every round, so that they can be replayed. Contact planes, distances, clearances
and depth, which affect nothing else, are computed within a time budget, at lower rates if they exceed it. They are
computed a little early in rounds with time left, so that no wish has to wait for all of them at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler._core import Clearance, Collision, Contacts, Distance, GuardedMove, Impact, Penetration
from feeler.mockup import Tool
from feeler.poses import between
from feeler.workbench.document import motion
from feeler.workbench.document.document import Trip
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.gaps import Near, nearest
from feeler.workbench.engine.gliding import MOST_STEPS, STEP_S, Glide
from feeler.workbench.engine.guide import Guide
from feeler.workbench.engine.joint_hand import Freedom, JointGuide
from feeler.workbench.engine.snapshot import NO_FORCE, Places, Snapshot
from feeler.workbench.engine.trip import TripRecorder, least_clearance
from feeler.workbench.engine.world import NO_HITS, NO_PLANES, NO_ROWS, World

OFF_M = 5e-7
"""The tool stops this far before an impact, along its way, so that rounding cannot bring it into contact."""
MARGIN_M = 0.002
"""Surfaces nearer than this get contact planes."""
WITHIN_M = 0.02
"""Parts nearer than this get clearance rows."""
BUDGET_S = 0.004
"""Time per tick for results with lower rates."""
ROUND_S = 0.001
"""Results computed early do not lengthen a round, except an otherwise empty one."""
_TOLERANCE_M = 2.5e-7  # of the casts: with `OFF_M`, a stop is early by less than the tolerance of `Scene.cast`
_LONGEST_WAIT_S = 0.25  # results are computed at least this often, even beyond the budget
_PERIODS_S = {"planes": 0.0, "distance": 0.015, "rows": 0.1, "inside": 0.05, "depth": 0.1}
_EARLY = 0.75  # of a period: from then on a result is computed if a round has time for it
_DEPTH_SHARE = 0.05  # of all time at most: deep in a dense mock-up the way out takes tens of milliseconds
_RATE_SHARE = 0.1  # weight of the newest round in the mean length of rounds
_REST_ROUNDS = 250  # in glide without a change, until the proxy counts as at rest
_PLACE_STEPS = 100  # ticks that a placing waits for the proxy to come to rest
_REST_M = 1e-7
_PLAY_M_PER_S = 0.25


@dataclass(frozen=True, eq=False)
class Bump:
    """The hand hit a part that it did not touch before. speed: metres a second; force: newtons, 0 except in glide."""

    part: int
    point: Floats
    speed: float
    force: float


@dataclass(frozen=True, eq=False)
class Ticked:
    """The actions of a round, for a record. steps: of the proxy, 0 except in glide."""

    time: float
    seq: int
    source: str
    wish: Floats
    steps: int
    mode: str
    pose: Floats
    hits: Collision


class Engine:
    """One hand in one world. Thread-safe: changes wait for the current tick, and no longer."""

    # The state to reset when the hand is placed elsewhere.
    _guarded: GuardedMove | None
    _glide: Glide | None
    _force: Floats
    _torque: Floats
    _impact: Impact | None
    _held_by: dict[int, tuple[Floats, Floats | None]]
    _touched: set[int]
    _hits: Collision
    _planes: Contacts
    _rows: Clearance
    _distance: Distance | None
    _contains: bool
    _way_out: Penetration | None
    _last_free: Floats | None
    _stale: dict[str, bool]
    _found_at: dict[str, float]
    _is_settled: bool
    _is_changed: bool

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        on_bump: Callable[[Bump], None] = lambda bump: None,
        on_tick: Callable[[Ticked], None] = lambda ticked: None,
        on_guided: Callable[[Guide], None] = lambda guide: None,
        budget_s: float = BUDGET_S,
    ) -> None:
        """clock: seconds, never backwards. on_bump, on_tick: called within a tick; they must not block. on_guided:
        called after a tick in which the hand came to the end of the way that guides it."""
        self._clock, self._on_bump, self._on_tick, self._budget_s = clock, on_bump, on_tick, budget_s
        self._on_guided = on_guided
        self._guide: Guide | None = None
        self._lock = threading.RLock()
        self._wish_lock = threading.Lock()
        self._world: World | None = None
        self._tool: Tool | None = None
        self._mode = "stop"
        self._pose = np.eye(4)
        self._wish, self._seq, self._source, self._wish_time = np.eye(4), 0, "api", 0.0
        self._newest: tuple[Floats, int, str, float] | None = None
        self._places: Places = None
        self._held_places: Places = None
        self._number = 0
        self._snapshot: Snapshot | None = None
        self._last_tick = clock()
        self._owed_s = 0.0  # time of the clock for which the proxy has not yet been stepped
        self._period_s = 0.0
        self._cost: dict[str, float] = {}
        self._trip: TripRecorder | None = None
        self._idle: Ticked | None = None
        self._is_quiet = False
        self._is_held = False
        self._is_replayed = False  # the round that runs is one of a record
        self._rested = 0  # rounds without news, in a row
        self._was_idle = False  # after the latest round
        self._way: list[Floats] = []
        self._on_played: Callable[[], None] | None = None
        self._forget()

    def set(
        self,
        world: World | None,
        tool: Tool | None,
        pose: Floats,
        *,
        mode: str,
        places: Places = None,
        held_places: Places = None,
        is_carrying: bool = False,
        trip: Trip | None = None,
    ) -> None:
        """Sets another world, tool, mode, or all of them, with the hand at a pose, without a motion.

        is_carrying: from now on the way is recorded, after that of `trip`, if there is one.
        """
        with self._lock:
            self._guide = None
            self._world, self._tool, self._mode = world, tool, mode
            self._places, self._held_places = places, held_places
            self._jump(pose)
            if is_carrying and world is not None and tool is not None:
                seated = world.seated_parts(tool, pose) if trip is None else []
                self._trip = TripRecorder(tool, pose, trip, frozenset(seated))

    def wish(self, pose: Floats, seq: int, source: str) -> None:
        """Sets the target of the hand; only the newest counts. Never waits."""
        with self._wish_lock:
            self._newest = (pose, seq, source, self._clock())

    @property
    def guide(self) -> Guide | None:
        """The way that guides the hand. Never waits."""
        return self._guide

    def set_guide(self, way: Sequence[Floats] | Freedom | None) -> None:
        """Lets a way of the hand guide it, a joint hold it, or nothing; another content of the hand ends it. Never
        waits."""
        tool = self._tool
        if isinstance(way, Freedom):
            self._guide = None if tool is None else JointGuide(way, tool.bounds)
            return
        self._guide = None if way is None or tool is None else Guide(np.array(way), tool.bounds)

    def let_go(self) -> None:
        """Clears the target: the hand stays where it is."""
        with self._lock:
            self._drop_wish()
            self._flush_idle()
            self._wish = self._pose
            self._is_settled = False

    def place(self, pose: Floats) -> Floats:
        """Moves the hand to a pose at once, as far as the mode allows; returns its pose."""
        with self._lock:
            self._drop_wish()
            self._flush_idle()
            self.wish(pose, self._seq, "api")
            self._is_quiet = True
            self._round(MOST_STEPS if self._mode == "glide" else 0)
            for _ in range(_PLACE_STEPS if self._glide is not None else 0):
                before = self._pose
                self._round(MOST_STEPS)
                if self._carried(before, self._pose) < _REST_M:
                    break
            self._is_quiet = False
            self._is_changed = True  # the next tick reports it to listeners
            return self._pose

    def paused(self) -> AbstractContextManager[Any]:
        """Blocks ticks during a `with`."""
        return self._lock

    def flush(self) -> None:
        """Reports idle steps to `on_tick`, which otherwise gets them with the next change."""
        with self._lock:
            self._flush_idle()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Blocks all rounds except those of `replayed` during a `with`; then the hand stays where it is."""
        with self._lock:
            self._is_held = True
        try:
            yield
        finally:
            with self._lock:
                self._is_held = False
                self.let_go()

    @property
    def is_idle(self) -> bool:
        """Whether rounds change nothing until something is asked of the engine: they may come seldom. Never waits."""
        return (
            self._rested > (_REST_ROUNDS if self._mode == "glide" else 0)
            and self._newest is None
            and not self._way
            and self._on_played is None
            and not self._is_changed
            and (self._world is None or self._tool is None or not any(self._stale.values()))
        )

    @property
    def is_held(self) -> bool:
        """Whether only recorded wishes move the hand."""
        return self._is_held

    def replayed(self, wish: Floats, seq: int, source: str, steps: int) -> Ticked:
        """Runs a round from a record."""
        with self._lock:
            self.wish(wish, seq, source)
            self._is_replayed = True
            try:
                self._round(steps)
            finally:
                self._is_replayed = False
            return self._ticked(steps)

    def shown(self, pose: Floats, wish: Floats, *, is_last: bool) -> None:
        """Puts the hand at a recorded pose, and shows the contacts there, and what held it back from a wish.

        is_last: right after `set`, whose trip goes on.
        """
        with self._lock:
            if not is_last:
                self._jump(pose)
            self.replayed(wish if self._mode == "stop" else pose, self._seq, "api", 0)

    def nearest(self) -> Near | None:
        """The nearest neighbour of the hand's content, without seats; None: nothing is within reach."""
        with self._lock:
            if self._world is None or self._tool is None:
                return None
            seats = self._trip.seat_parts if self._trip is not None else frozenset()
            return nearest(self._world, self._tool, self._pose, seats)

    @property
    def ticked_at(self) -> float:
        """Start of the last round, on the engine's clock."""
        return self._last_tick

    @property
    def pose(self) -> Floats:
        """The pose of the hand. Never waits."""
        return self._pose

    def snapshot(self) -> Snapshot | None:
        """The newest snapshot; None before the first tick."""
        return self._snapshot

    def trip(self) -> Trip | None:
        """The trip of the gripped parts so far; None if it is not recorded."""
        with self._lock:
            return self._trip.so_far(self._pose) if self._trip is not None else None

    def least_clearance(self, trip: Trip) -> float | None:
        """Clearance of the hand's content on a trip; see `trip.least_clearance`."""
        with self._lock:
            if self._world is None or self._tool is None:
                return None
            return least_clearance(self._world, self._tool, trip)

    def jump(self, pose: Floats) -> None:
        """Puts the hand at a pose, without a motion."""
        with self._lock:
            self._jump(pose)

    def show(self, pairs: npt.NDArray[np.uint32], kinds: npt.NDArray[np.uint8]) -> None:
        """Shows pairs `(k, 2)` of tool and mock-up triangles, and their kinds, as colliding, until the hand moves."""
        with self._lock:
            world, tool = self._world, self._tool
            if world is None or tool is None or not len(pairs):
                self._hits = NO_HITS
            else:
                self._hits = world.collision_of(tool, pairs, kinds)
            self._is_changed = True

    def play(self, way: Sequence[Floats], on_played: Callable[[], None]) -> None:
        """Moves the hand along a way at a constant speed, then calls `on_played`, in the thread of the ticks."""
        with self._lock:
            self._way, self._on_played = list(way), on_played

    def tick(self) -> bool:
        """One round. Returns whether there is a new snapshot."""
        with self._lock:
            now = self._clock()
            elapsed, self._last_tick = max(0.0, now - self._last_tick), now
            if self._is_held:
                return False
            if not self._was_idle:
                # The mean of the lengths, not of the rates, which are few and huge when rounds come in pairs. Rounds
                # of an idle engine come seldom, which is not its rate.
                share = _RATE_SHARE if self._period_s > 0.0 else 1.0
                self._period_s += share * (elapsed - self._period_s)
            self._play_on(elapsed)
            steps = 0
            if self._mode == "glide":
                self._owed_s = min(self._owed_s + elapsed, MOST_STEPS * STEP_S)
                steps = int(self._owed_s / STEP_S + 1e-9)
                self._owed_s -= steps * STEP_S
            has_moved = self._round(steps)
            self._rested = 0 if has_moved else self._rested + 1
            self._was_idle = self.is_idle
            played = self._on_played if self._on_played and not self._way and self._newest is None else None
            if played is not None:
                self._on_played = None
            guide = self._guide
            is_there = guide is not None and has_moved and guide.is_at_end(self._pose)
        if played is not None:
            played()
        if guide is not None and is_there:
            self._on_guided(guide)
        return has_moved

    def warm_up(self) -> None:
        """Builds the connectivity of the meshes, which the first answers need."""
        with self._lock:
            if self._world is not None and self._tool is not None:
                self._world.contacts(self._tool, self._pose, MARGIN_M)
                self._world.distance(self._tool, self._pose, WITHIN_M)
                self._world.clearance(self._tool, self._pose, WITHIN_M)
                self._world.is_containing(self._tool, self._pose)
                self._world.penetration(self._tool, self._pose, MARGIN_M)

    # ---- one round ----

    def _round(self, steps: int) -> bool:
        begun = self._clock()
        is_new = self._take_wish()
        before = self._pose
        is_moved = False
        if not self._is_settled or is_new or steps:
            is_moved = self._move(steps)
            self._told(steps, is_new or is_moved or not self._is_settled)
            self._is_settled = True
        if is_moved or not np.array_equal(before, self._pose):
            self._stale = dict.fromkeys(_PERIODS_S, True)
        has_found = self._look_around(begun, is_new or is_moved)
        if not (is_new or is_moved or has_found or self._is_changed):
            return False
        self._is_changed = False
        self._publish(begun)
        return True

    def _take_wish(self) -> bool:
        with self._wish_lock:
            newest, self._newest = self._newest, None
        if newest is None:
            return False
        pose, self._seq, self._source, time = newest
        guide = self._guide
        # A device feels the way instead, and what is placed goes where it was told to. Records have wishes as drawn.
        is_joint = isinstance(guide, JointGuide)
        is_free = self._source == "device" or self._is_quiet
        if guide is not None and not self._is_replayed and (is_joint or not is_free):
            pose = guide.drawn(pose)
        self._wish_elapsed, self._wish_time = max(1e-3, time - self._wish_time), time
        self._hand_from, self._wish = self._wish, pose
        return True

    def _drop_wish(self) -> None:
        with self._wish_lock:
            self._newest = None
        self._way, self._on_played = [], None

    def _told(self, steps: int, has_changed: bool) -> None:
        """Reports the round; idle steps of the proxy are reported together, before the next change."""
        if self._is_quiet:
            return
        if not has_changed:
            self._idle = self._ticked(steps + (self._idle.steps if self._idle else 0))
            return
        self._flush_idle()
        self._on_tick(self._ticked(steps))

    def _flush_idle(self) -> None:
        idle, self._idle = self._idle, None
        if idle is not None:
            self._on_tick(idle)

    def _ticked(self, steps: int) -> Ticked:
        return Ticked(self._clock(), self._seq, self._source, self._wish, steps, self._mode, self._pose, self._hits)

    def _move(self, steps: int) -> bool:
        """Moves the hand towards its wish. Returns whether anything changed."""
        before, force = self._pose, self._force
        world, tool = self._world, self._tool
        self._force = self._torque = NO_FORCE
        impact: Impact | None = None
        guide = self._guide
        if isinstance(guide, JointGuide):
            self._pose, self._force, self._torque = guide.reached(self._wish)
        elif world is None or tool is None or self._mode == "pass":
            self._pose = self._wish
        elif self._mode == "stop":
            if not np.array_equal(self._pose, self._wish):
                if self._guarded is None:
                    self._guarded = GuardedMove(world, tool, self._pose)
                moved = self._guarded.go(self._pose, self._wish, _TOLERANCE_M, OFF_M)
                self._pose, impact = moved.pose, moved.impact
        elif steps:
            impact = self._glide_on(world, tool, steps)
        else:
            self._force, impact = force, self._impact
        is_moved = not np.array_equal(before, self._pose)
        if is_moved or not self._is_settled:
            self._hits = self._collided(world, tool) if world is not None and tool is not None else NO_HITS
            if self._mode != "stop":
                self._guarded = None
        if not self._hits:
            self._last_free = self._pose
        self._bumped(impact)
        is_other = is_moved or (impact is None) != (self._impact is None) or not np.array_equal(force, self._force)
        self._impact = impact
        if self._trip is not None and is_other:
            self._trip.moved(self._pose, impact, self._hits)
        return is_other or not self._is_settled

    def _collided(self, world: World, tool: Tool) -> Collision:
        """What collides; the seats of a joint in the hand do not."""
        hits, guide = world.collide(tool, self._pose), self._guide
        if not isinstance(guide, JointGuide) or not hits:
            return hits
        mine, others = tool.part_of_face[hits.pairs[:, 0]], world.part_of(hits.pairs[:, 1])
        pairs = zip(mine.tolist(), others.tolist(), strict=True)
        kept = np.array([pair not in guide.free.seats for pair in pairs])
        return world.collision_of(tool, hits.pairs[kept], hits.kind_codes[kept]) if kept.any() else NO_HITS

    def _glide_on(self, world: World, tool: Tool, steps: int) -> Impact | None:
        if self._glide is None:
            self._glide = Glide(world, tool, self._pose)
        glided = self._glide.step(self._wish, steps)
        self._pose, self._force, self._torque = glided.pose, glided.force, glided.torque
        self._held_by = {
            part: (point, normal)
            for part, point, normal in zip(glided.parts, glided.points, glided.normals, strict=True)
        }
        if not glided.parts:
            return None
        return Impact(1.0, glided.points[0], glided.normals[0], glided.parts[0])

    def _bumped(self, impact: Impact | None) -> None:
        """Reports parts that are newly touched, while the hand moves."""
        touched = dict(self._held_by)
        if self._mode == "pass":
            touched.update(self._cut())
        if impact is not None:
            touched[impact.part] = (impact.point, impact.normal)
        for part in sorted(touched.keys() - self._touched):
            speed = self._speed_at(*touched[part])
            if speed > 0.0:
                self._on_bump(Bump(part, touched[part][0], speed, float(np.linalg.norm(self._force))))
        self._touched = set(touched)

    def _cut(self) -> dict[int, tuple[Floats, Floats | None]]:
        """The colliding parts, each with a colliding corner of the tool."""
        if self._world is None or self._tool is None:
            return {}
        owners = self._world.part_of(self._hits.pairs[:, 1])
        found: dict[int, tuple[Floats, Floats | None]] = {}
        for part in self._hits.parts.tolist():
            triangle = self._hits.pairs[int(np.argmax(owners == part)), 0]
            corner = self._tool.vertices[self._tool.faces[triangle, 0]]
            found[part] = (self._pose[:3, :3] @ corner + self._pose[:3, 3], None)
        return found

    def _speed_at(self, point: Floats, normal: Floats | None) -> float:
        """The speed of the hand at a point: against the normal, or without one, its magnitude."""
        in_hand = self._hand_from[:3, :3].T @ (point - self._hand_from[:3, 3])
        way = self._wish[:3, :3] @ in_hand + self._wish[:3, 3] - point
        metres = float(np.linalg.norm(way)) if normal is None else max(0.0, -float(normal @ way))
        return metres / self._wish_elapsed

    # ---- results with lower rates ----

    def _look_around(self, begun: float, is_busy: bool) -> bool:
        """Computes stale results that are due, within the budget; then those due soon. Returns whether there were any.

        is_busy: the hand moved in this round.
        """
        world, tool = self._world, self._tool
        if world is None or tool is None:
            return False
        found = False
        for name, is_due in self._wanted():
            now = self._clock()
            length = now - begun + self._cost.get(name, 0.0)
            is_alone = not (is_busy or found)
            if is_due:
                is_time = length <= self._budget_s or self._waited(name) >= _LONGEST_WAIT_S
            else:
                is_time = length <= ROUND_S or is_alone
            if not is_time:
                continue
            self._find(name, world, tool)
            after = self._clock()
            self._found_at[name], self._stale[name], found = after, False, True
            cost = self._cost.get(name, after - now)
            self._cost[name] = cost + 0.3 * (after - now - cost)
        return found

    def _wanted(self) -> list[tuple[str, bool]]:
        """Stale results that are due, the longest waiting first; then those due soon."""
        waited = {name: self._waited(name) for name, is_stale in self._stale.items() if is_stale}
        order = sorted(waited, key=lambda name: (-waited[name], name))
        due = [name for name in order if waited[name] >= self._period(name)]
        soon = [name for name in order if name not in due and waited[name] >= _EARLY * self._period(name)]
        return [(name, True) for name in due] + [(name, False) for name in soon]

    def _waited(self, name: str) -> float:
        return self._clock() - self._found_at.get(name, -1e9)

    def _period(self, name: str) -> float:
        period = _PERIODS_S[name]
        return max(period, self._cost.get(name, 0.0) / _DEPTH_SHARE) if name == "depth" else period

    def _find(self, name: str, world: World, tool: Tool) -> None:
        if name == "planes":
            self._planes = world.contacts(tool, self._pose, MARGIN_M, self._last_free)
        elif name == "distance":
            self._distance = world.distance(tool, self._pose, np.inf)
        elif name == "rows":
            self._rows = world.clearance(tool, self._pose, WITHIN_M)
        elif name == "depth":
            is_in = bool(self._hits) or self._contains
            self._way_out = world.penetration(tool, self._pose, MARGIN_M) if is_in else None
        else:
            before = self._contains
            # A joint meets nothing in its range: what is inside a part that it moves was there before.
            is_joint = isinstance(self._guide, JointGuide)
            self._contains = not self._hits and not is_joint and world.is_containing(tool, self._pose)
            self._stale["depth"] |= self._contains != before  # containment has a depth as well

    # ---- state ----

    def _forget(self) -> None:
        self._guarded = None
        self._glide = None
        self._force = self._torque = NO_FORCE
        self._impact = None
        self._held_by = {}
        self._touched = set()
        self._hits = NO_HITS
        self._planes = NO_PLANES
        self._rows = NO_ROWS
        self._distance = None
        self._contains = False
        self._way_out = None
        self._last_free = None
        self._stale = dict.fromkeys(_PERIODS_S, True)
        self._found_at = {}
        self._is_settled, self._is_changed = False, True
        self._hand_from, self._wish_elapsed = self._wish, 1.0

    def _jump(self, pose: Floats) -> None:
        self._drop_wish()
        self._flush_idle()
        self._trip = None
        self._pose = self._wish = pose
        self._forget()

    def _carried(self, before: Floats, after: Floats) -> float:
        assert self._tool is not None
        return motion.carried(before, after, motion.corners(self._tool.bounds))

    def _play_on(self, elapsed: float) -> None:
        """The next wish of a played way. No pose of the way is skipped: the hand goes through each."""
        if not self._way:
            return
        goal, step = self._way[0], _PLAY_M_PER_S * elapsed
        if self._tool is not None and (far := self._carried(self._wish, goal)) > step:
            goal = between(self._wish, goal, self._tool.bounds.mean(axis=0), step / far)
        else:
            self._way.pop(0)
        self.wish(goal, self._seq, "api")

    def _publish(self, begun: float) -> None:
        now = self._clock()
        self._number += 1
        self._snapshot = Snapshot(
            number=self._number,
            time=now,
            pose_seq=self._seq,
            wish_time=self._wish_time,
            source=self._source,
            mode=self._mode,
            pose=_kept(self._pose),
            wish=_kept(self._wish),
            blocked=self._impact is not None,
            force=_kept(self._force),
            torque=_kept(self._torque),
            hits=self._hits,
            planes=self._planes,
            rows=self._rows,
            distance=self._distance,
            contains=self._contains,
            way_out=self._way_out,
            stopped_by=None if self._impact is None else self._impact.part,
            is_current=not any(self._stale.values()),
            engine_us=1e6 * (now - begun),
            rate_hz=1.0 / self._period_s if self._period_s > 0.0 else 0.0,
            places=self._places,
            held_places=self._held_places,
        )


def _kept(array: Any) -> Floats:
    copy = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy
