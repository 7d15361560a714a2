"""Fasteners as a task sees them: what each joins, what goes with it, how far it is turned, and how far it is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.parts import PartNumber
from feeler.plan.fastener_names import name_of, retainer_said
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.scene import Scene
from feeler.tasks.captive import free_travel, has_neck
from feeler.tasks.cotters import pin_shank
from feeler.tasks.digests import facts_of
from feeler.tasks.held_rows import BODY, Hold, Holds
from feeler.tasks.passing import LEVELS, Passed, in_bore, is_against, passed_by, standing_out
from feeler.tasks.retainers import gripped
from feeler.tasks.thread_sizes import nominal
from feeler.tasks.times import Arithmetic, Turns

Floats = npt.NDArray[np.float64]

_STAY = ("stud", BODY)
"""Kinds that are not undone."""
_LOOSE = (*_STAY, "dowel")
"""Kinds that join no parts: what is on a dowel comes off along it, or it is in the way."""
RINGS = ("circlip", "cotter")
"""Kinds that are bent to come out."""
LOCKS = ("cotter", "pin", "dowel")
"""Kinds that keep a fastener that they go through from turning."""
BEYOND = 1.02
"""How far what stays on a part is looked for, in lengths of its thread."""
CLEAR_M = 1e-5
"""How far a fastener is drawn beyond the length of its thread."""
_ROUND_NUT = 1.3
"""The width of a nut without flats, in diameters of its bore: rays into its bore begin there."""
_BESIDE = 8
"""Rays around a hole that look for its edge."""
_RIM = 1.05
"""How far they are from its axis, in radii of the shank."""


@dataclass(frozen=True, eq=False)  # it holds arrays
class Fixing:
    """One fastener."""

    hold: Hold
    row: Fastener | None
    """None for circlips, pins and what a table says: they come off by hand."""
    turns: Turns
    travel: float
    """How far it is drawn along its axis, metres."""

    @property
    def part(self) -> int:
        """Its own part."""
        return self.hold.fastener


class Fixings:
    """All fasteners of a scene."""

    def __init__(
        self,
        scene: Scene,
        rows: Fasteners,
        held: Holds,
        times: Arithmetic,
        loose: frozenset[int] = frozenset(),
        riding: frozenset[int] = frozenset(),
    ) -> None:
        """loose: plugs that do not leave with the part that they are in; riding: circlips that do, and join it to
        nothing."""
        self.scene, self.times, self.loose, self.riding = scene, times, loose, riding
        self.held = held
        self._held = {hold.fastener: hold for hold in held}
        # Others are no fasteners, whatever their names say.
        self._rows = {row.part: row for row in rows if row.part in self._held}
        mask = scene.part_mask.copy()
        mask[[part for part in self._rows if part < len(mask)]] = False
        self._bare = scene.only(mask)
        self._washers = self._sorted_washers(held)
        self._known: dict[int, Fixing] = {}
        self._gripped: dict[int, tuple[int, ...]] = {}
        self._free: dict[int, float] = {}
        self._captive: dict[int, int | None] = {}
        self.studs: dict[int, int] = {
            hold.fastener: hold.anchor for hold in held if hold.kind == "stud" and hold.anchor is not None
        }
        """Studs, and the part that each is fastened in."""
        self.bodies: list[tuple[int, ...]] = []
        """Parts that leave as one, such as those of a rolling bearing; the one that it is known by is the first."""
        for hold in held:
            body = tuple(part for part in (hold.fastener, *hold.parts) if scene.part_mask[part])
            if hold.kind == BODY and len(body) > 1:
                self.bodies.append(body)
        self._axles = {
            hold.anchor
            for hold in held
            if hold.kind in RINGS and hold.anchor in self._held and self._held[hold.anchor].anchor is None
        }
        """What a circlip or a cotter pin alone keeps in its place: it has no thread, so it is drawn by hand."""
        self._locks: dict[int, list[int]] = {}
        for hold in held:
            if hold.kind in LOCKS and scene.part_mask[hold.fastener]:
                for part in (*hold.parts, *([] if hold.anchor is None else [hold.anchor])):
                    self._locks.setdefault(part, []).append(hold.fastener)
        self.nuts: dict[int, frozenset[int]] = {}
        """The nuts of each rod that is fastened in nothing but these, and those of studs that are turned out."""
        for hold in held:
            if hold.kind == "nut" and hold.anchor in self._held and self._is_rod(hold.anchor):
                self.nuts[hold.anchor] = self.nuts.get(hold.anchor, frozenset()) | {hold.fastener}
        self.by_joined: dict[int, list[int]] = {}
        """Fasteners by the parts that they join."""
        for hold in held:
            for part in self.joins(hold.fastener):
                self.by_joined.setdefault(part, []).append(hold.fastener)

    def __contains__(self, part: object) -> bool:
        return part in self._held and self._held[part].kind not in _STAY

    def __iter__(self) -> Iterator[int]:
        return iter(part for part, hold in self._held.items() if hold.kind not in _STAY)

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing that holds parts, studs and nuts included."""
        return not self._held

    def of(self, part: int) -> Fixing:
        """The fastener of a part."""
        if part not in self._known:
            self._known[part] = self._made(part)
        return self._known[part]

    def joins(self, part: int) -> tuple[int, ...]:
        """The parts that a fastener joins, without itself."""
        hold = self._held[part]
        if hold.kind in _LOOSE or part in self.riding or not hold.parts:
            return ()
        ends = [*hold.parts, self._end(hold), *self._grips(hold)]
        return tuple(dict.fromkeys(each for each in ends if each is not None and each != part))

    def axis_mates(self, part: int) -> tuple[int, ...]:
        """Other fasteners on its axis, without studs."""
        return tuple(each for each in self._held[part].mates if each in self)

    def locks(self, part: int) -> list[int]:
        """The pins that go through a fastener, and the nuts on a stud: it is not turned before these are out."""
        return [each for each in (*self._locks.get(part, []), *sorted(self.nuts.get(part, ()))) if each != part]

    def is_turned(self, part: int) -> bool:
        """Whether a fastener is turned by a tool."""
        return part in self and part in self._rows and part not in self._axles

    def _is_rod(self, part: int) -> bool:
        """Whether nuts are undone before a stud leaves: it is in nothing else, or it is turned out."""
        row, hold = self._rows.get(part), self._held[part]
        return row is not None and row.kind == "stud" and (hold.anchor is None or hold.kind != "stud")

    def is_plug(self, part: int) -> bool:
        """Whether a fastener holds itself alone, and leaves with what it is in."""
        return self._held[part].parts == (part,) and part not in self.loose

    def anchor(self, part: int) -> int | None:
        """What a fastener is fastened in."""
        return self._held[part].anchor

    def washers(self, part: int) -> list[int]:
        """The washers that leave with a fastener."""
        return self._washers.get(part, [])

    def shank(self, part: int) -> Fastener | None:
        """The shank that a fastener has, or is."""
        if part in self._rows or part not in self._held:
            return self._rows.get(part)
        return pin_shank(self.scene, part, self._meshes.mesh(part)[0])

    @cached_property
    def _meshes(self) -> PartMeshes:
        return PartMeshes(self.scene.mockup)

    def captive_on(self, part: int) -> int | None:
        """Of a union nut: the pipe that it cannot be drawn off; of a captive screw: the part that it cannot be drawn
        out of. It stays there when it is undone."""
        if part not in self._captive:
            self._captive[part] = self._held_on(part)
        return self._captive[part]

    def _held_on(self, part: int) -> int | None:
        row, hold = self._rows.get(part), self._held[part]
        held = [each for each in hold.parts if each != part and self.scene.part_mask[each]]
        if row is None or hold.mates or not held:
            return None
        if row.kind != "nut":
            return self._captive_in(row, hold, held)
        own = Tool.of_parts(self.scene.mockup, [part])
        return next((each for each in held if self._is_kept_on(row, own, each)), None)

    def _is_kept_on(self, nut: Fastener, own: Tool, pipe: int) -> bool:
        """Whether a nut cannot be drawn off a part in its bore: a bend of it is in the way, near the nut or far."""
        alone = self.scene.only([pipe])
        if not self._is_around(alone, nut, 0.0):
            return False  # it lies on it
        step = 2.0 * float(np.linalg.norm(own.bounds[1] - own.bounds[0]))
        if alone.is_colliding(own, np.eye(4)) or alone.cast(own, np.eye(4), _along(nut, step), touching="free"):
            return True
        long = nut.length if math.isfinite(nut.length) else 0.0
        end = float(((self._meshes.mesh(pipe)[0] - nut.frame[:3, 3]) @ nut.axis).max()) + long
        if end <= step or not self._is_around(alone, nut, step):
            return False
        hit = alone.cast(own, _along(nut, step), _along(nut, end * BEYOND), touching="free")
        return hit is not None and self._is_around(alone, nut, float(hit.pose[:3, 3] @ nut.axis))

    def _is_around(self, alone: Scene, nut: Fastener, travel: float) -> bool:
        """Whether a part is in the bore of a nut that was drawn along its axis: it cannot leave sideways there."""
        wide = nut.across_flats if math.isfinite(nut.across_flats) else _ROUND_NUT * nut.size
        drawn = replace(nut, frame=_along(nut, travel) @ nut.frame, across_flats=wide)
        return bool(in_bore(alone, drawn, self._meshes))

    def _captive_in(self, row: Fastener, hold: Hold, held: list[int]) -> int | None:
        """What a screw whose thread is wider than a hole above it cannot be drawn out of, if it is out of its thread
        before it meets that."""
        if not (math.isfinite(row.length) and has_neck(self._meshes.mesh(row.part)[0], row)):
            return None
        free = {each: self._free_travel(row, each) for each in held if each != hold.anchor}
        met = [(travel, each) for each, travel in free.items() if travel is not None]
        if not met:
            return None
        travel, first = min(met)
        self._free[row.part] = travel
        return first if self._engaged(row, hold)[1] <= travel else None

    def _free_travel(self, row: Fastener, part: int) -> float | None:
        """How far a screw is drawn out of a part before it meets it, metres; None if it comes out. All plans ask it of
        all screws."""
        mockup, far = self.scene.mockup, BEYOND * row.length
        question = ("free travel", row.part, part, far, tuple(row.axis.tolist()))
        if question not in mockup._remembered:
            own = Tool.of_parts(mockup, [row.part])
            mockup._remembered[question] = free_travel(self.scene.only([part]), own, row.axis, far)
        known: float | None = mockup._remembered[question]
        return known

    def _grips(self, hold: Hold) -> tuple[int, ...]:
        """What the clamps that a fastener closes hold a hose on, if it is fastened in nothing else."""
        if hold.fastener not in self._gripped:
            found = list[int]()
            parts = dict.fromkeys((hold.fastener, *hold.parts))
            if self._end(hold) in (None, *hold.parts):
                for clamp in [part for part in parts if retainer_said(name_of(self.scene.mockup, part)) == "clasp"]:
                    if self.scene.part_mask[clamp]:
                        held = [part for part in hold.parts if part != clamp]
                        found += gripped(self._bare, clamp, held, self._meshes)
            self._gripped[hold.fastener] = tuple(dict.fromkeys(found))
        return self._gripped[hold.fastener]

    def _end(self, hold: Hold) -> int | None:
        """The part that it is fastened in: through its stud, not through its nut. A stud that is fastened in nothing is
        held by its nuts."""
        anchor, seen = hold.anchor, {hold.fastener}
        while anchor in self._held and anchor not in seen:
            seen.add(anchor)
            if self._held[anchor].kind != "stud":
                return None if anchor in hold.mates else anchor  # a fitting, or a pin with a circlip
            if self._held[anchor].anchor is None:
                return anchor
            anchor = self._held[anchor].anchor
        return anchor

    def _made(self, part: int) -> Fixing:
        hold, row = self._held[part], self._rows.get(part)
        if row is None:
            return Fixing(hold, None, Turns(0.0, ""), 0.0)
        size, engaged = self._engaged(row, hold)
        turns = self.times.turns(row.path, nominal(row, size), engaged)
        length = row.length if math.isfinite(row.length) else 0.0
        travel = CLEAR_M + max(engaged if math.isfinite(engaged) else 0.0, length)
        if self.captive_on(part) is not None and part in self._free:
            travel = min(CLEAR_M + engaged, self._free[part])
        return Fixing(hold, row, turns, travel)

    def _engaged(self, row: Fastener, hold: Hold) -> tuple[float, float]:
        """As `_thread`, remembered."""
        facts = [[*facts_of(self._rows.get(each)), each == hold.anchor] for each in (row.part, *hold.mates)]
        anchor = None if hold.anchor is None else PartNumber(hold.anchor)
        size, engaged = self._bare._recalled("thread", [], [anchor, *facts], lambda: list(self._thread(row, hold)))
        return size, engaged

    def _thread(self, row: Fastener, hold: Hold) -> tuple[float, float]:
        """The diameter of its thread, and how far it is turned, metres."""
        anchor = hold.anchor
        if row.kind == "nut":
            shanks = [self._rows[mate] for mate in hold.mates if mate in self._rows and self._rows[mate].kind != "nut"]
            if shanks:
                return max(row.size, shanks[0].size), row.length + _beyond(row, shanks[0])
            around = self.scene.only([anchor]) if anchor in self._rows else self._bare
            thread = [each for each in in_bore(around, row, self._meshes) if each.part == anchor]
            if thread and anchor is not None:
                inside = min(thread[0].top - thread[0].bottom + row.length / LEVELS, row.length)
                return 2.0 * thread[0].radius, inside + self._standing_out(row, anchor, thread[0])
            return row.size, row.length
        nuts = [self._rows[mate] for mate in hold.mates if mate in self._rows]
        if nuts:
            return row.size, nuts[0].length + _beyond(nuts[0], row)
        around = self.scene.only([anchor]) if anchor in self._rows else self._bare
        thread = [each for each in next(iter(passed_by(around, [row]))) if each.part == anchor]
        head = row.head_height if math.isfinite(row.head_height) else 0.0
        if thread and math.isfinite(row.length):
            # It is turned until its end is out of the thread, also where it stands out behind.
            return row.size, min(self._rim(row, thread[-1]), -head) + head + row.length
        return row.size, row.length

    def _standing_out(self, nut: Fastener, anchor: int, thread: Passed) -> float:
        """How far the thread of a part goes on above its nut, metres."""
        if thread.top < -2.0 * nut.length / LEVELS:
            return 0.0
        far = float(((self._meshes.mesh(anchor)[0] - nut.frame[:3, 3]) @ nut.axis).max())
        return standing_out(self.scene.only([anchor]), nut, thread.radius, far)

    def _rim(self, row: Fastener, thread: Passed) -> float:
        """The height of the edge of a threaded hole along a shank, metres, by rays beside it."""
        step = row.length / LEVELS  # its rows of rays are this far from each other
        angles = np.arange(_BESIDE) * math.tau / _BESIDE
        around = np.stack([np.cos(angles), np.sin(angles), np.zeros(_BESIDE)], axis=1) * _RIM * 0.5 * row.size
        start = thread.top + 1.5 * step
        origins = (around + np.array([0.0, 0.0, start])) @ row.frame[:3, :3].T + row.frame[:3, 3]
        ways = np.tile(-row.axis, (_BESIDE, 1))
        hits = self.scene.only([thread.part]).rays(origins, ways)
        heights = start - np.asarray(hits.distances)
        # In a wider pocket the thread begins at its floor. Of a screw that is sunk in it rays begin in the part.
        is_outside = (np.asarray(hits.triangles) >= 0) & is_against(self.scene, np.asarray(hits.triangles), ways)
        near = heights[(heights >= thread.bottom) & is_outside]
        return float(np.median(near)) if 2 * len(near) >= _BESIDE else thread.top + 0.5 * step

    def _sorted_washers(self, held: Holds) -> dict[int, list[int]]:
        """Each washer with the nearest of the fasteners that it is on."""
        bounds = self.scene.mockup.part_bounds.reshape(-1, 2, 3)
        on: dict[int, list[int]] = {}
        for hold in held:
            if hold.kind != "stud":
                for washer in hold.washers:
                    on.setdefault(washer, []).append(hold.fastener)
        found: dict[int, list[int]] = {}
        for washer, fasteners in on.items():
            middle = bounds[washer].mean(axis=0)
            nearest = min(fasteners, key=lambda part: (_distance(self._rows.get(part), middle), part))
            found.setdefault(nearest, []).append(washer)
        return found


def _along(row: Fastener, travel: float) -> Floats:
    """A motion (4, 4) of a fastener along its axis, metres."""
    motion = np.eye(4)
    motion[:3, 3] = travel * row.axis
    return motion


def _distance(row: Fastener | None, point: Floats) -> float:
    return math.inf if row is None else float(np.linalg.norm(row.frame[:3, 3] - point))


def _beyond(nut: Fastener, shank: Fastener) -> float:
    """How far a shank stands out beyond the top of a nut, metres. With a head it ends on the other side, whichever way
    the nut faces."""
    head = shank.head_height if math.isfinite(shank.head_height) else 0.0
    length = shank.length if math.isfinite(shank.length) else 0.0
    top = shank.frame[:3, 3]
    tip = top - (head + length) * shank.axis
    if head > 0.0:
        half = 0.5 * nut.length
        middle = nut.frame[:3, 3] - half * nut.axis
        return max(0.0, float((middle - tip) @ shank.axis) - half)
    ends = np.array([tip, *([top] if shank.kind == "stud" else [])])
    return max(0.0, float(((ends - nut.frame[:3, 3]) @ nut.axis).max()))
