"""`holds`: which fastener holds which parts, and why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_progress, near, shown
from feeler.errors import OptionError
from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.parts import PartsLike
from feeler.plan.fastener_names import is_pipe, kind_said, name_of
from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners, turned_round
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.tasks.bearings import bearings_of
from feeler.tasks.clamping import clamped_beside, shoulder_below
from feeler.tasks.cotters import cotters_of
from feeler.tasks.held_rows import BODY, Hold, Holds, hold_of
from feeler.tasks.passing import SEAT, Passed, Windings, around, borne, in_bore, passed_by, surrounding, under
from feeler.tasks.retainers import Retained, clasped, clips, retained
from feeler.tasks.thread_sizes import radius_at, thread_size
from feeler.tasks.threaded_bodies import threaded_bodies

Floats = npt.NDArray[np.float64]

TIGHT = 1.014
"""Radius of a hole over that of the shank: threads and fits are tighter, clearance holes wider."""
CORE = 0.93
"""The same of the core of a thread that is drawn as a helix."""
THIN, POINT = 0.75, 0.97
"""Radius of the point of a screw over that of its thread, at most, and of its hole, where it may be a core."""
THREADED = 0.84
"""Radius of what is in a nut over that of its bore: threads are at least as large."""
TIP = 0.95
"""A tip ends in a part that is around this much of the shank."""
INSERT = 2.2
"""The greatest radius of a threaded insert, in radii of the thread."""
AROUND_INSERT = 1.2
"""What an insert is in is around it within this many of its radii."""
ALIKE = 0.05
"""The greatest difference of the radii of two rods with one thread, as a share."""
FREE = 0.15
"""The share of the bore of a nut beyond the end of its shank, from which another rod may be in it."""
ON_AXIS = 0.3
"""How far from the axis a nut of a shank may be, in diameters of the shank."""
BELOW = 0.1
"""How far below a nut the hole of what it holds is measured, in diameters."""
HEADLESS = 1.1
"""The greatest width of screws without a head, in diameters."""
SHORT = 0.5
"""Bolts and screws whose shank is shorter, in diameters, are drawn without one."""
AT_FITTING_M = 0.005
"""Nuts and clamps this near to a fitting hold the pipe on it, metres."""
PLAY = 0.02
"""What ends this near to the bearing face of a nut is on one side of it, in diameters."""
WASHER_GAP = 0.03
"""How far washers may be from each other and from their head, in diameters."""
CLOSING = ("bolt", "screw", "nut")
"""Kinds that close a clamp."""
OUTER_DRIVES = ("hexagon", "square", "12-point")
WASHER_WIDTH, WASHER_HEIGHT = 1.6, 0.6
"""The largest diameter of a washer, in widths across flats or of 1.8 diameters, and its height, in diameters."""
LARGE_WASHER, LARGE_HEIGHT = 3.7, 0.4
"""The same of a large washer (ISO 7093, DIN 440), both in diameters."""


TALL = 2.0
"""The height of rings with a shoulder, in diameters."""


def holds(
    mockup: Mockup | Scene,
    fasteners: Fasteners | None = None,
    *,
    table: Mapping[int | str, PartsLike | None] | None = None,
    progress: Progress | None = None,
) -> Holds:
    """Which fastener holds which parts: a bolt or screw those that its shank passes through on the way to its thread or
    nut, a nut those that it clamps, a plug itself; clamps and clips pass it on to what they touch.

    The radius distinguishes threads from clearance holes. Circlips and pins are known by name. Results are estimates,
    each with its reason. `mockup`: also a `Scene`, of which only the present parts are examined. `fasteners`: of this
    mock-up; None: `find_fasteners`. `table`: what you know better, fastener by fastener: what it holds, or None if it
    holds nothing; a part that is no fastener so far becomes one.
    Raises `OptionError` for parts that do not exist.
    """
    if not isinstance(mockup, (Mockup, Scene)):
        raise OptionError(f"mockup is {shown(mockup)}: give a feeler.Mockup or a feeler.Scene")
    check_progress(progress)
    scene = mockup if isinstance(mockup, Scene) else Scene(mockup)
    if fasteners is None:
        fasteners = find_fasteners(scene, None, None if progress is None else _share(progress, 0.8))
    else:
        check_kind("fasteners", fasteners, Fasteners, "the result of feeler.find_fasteners")
        beyond = [row.path for row in fasteners if row.part >= scene.mockup.part_count]
        if beyond:
            raise OptionError(f"fasteners has {beyond[0]!r}, which is not in this mock-up: give fasteners of this one")
    given = _given(scene.mockup, table)
    present = [row for row in fasteners if scene.part_mask[row.part]]
    bodies = threaded_bodies(scene, present)
    present = [row for row in present if row.part not in bodies]
    if progress is not None:
        progress(0.8, "looking at circlips, pins and bearings")
    bearings = bearings_of(scene, [row.part for row in present])
    taken = {part for each in bearings for part in (each.lead, *each.parts)}
    by_name = cotters_of(scene, present, taken)
    taken |= {each.part for each in by_name}
    by_name += retained(scene, [*(row.part for row in present), *taken])
    holding = _Holding(scene, present, by_name)
    if spacers := holding.spacers():
        present = [row for row in present if row.part not in spacers]
        holding = _Holding(scene, present, by_name)
    kept = {row.fastener: row for row in holding.rows()}
    for each in by_name:
        kept[each.part] = hold_of(scene.mockup, each.part, each.kind, each.parts, (), each.anchor, (), each.because)
    held = {part for row in kept.values() for part in row.parts}
    for each in clips(scene, held | taken, set(kept)):
        closing = [row for row in kept.values() if _closes(row, each)]
        for row in closing:
            kept[row.fastener] = _closing(scene.mockup, row, each)
        if not closing:
            kept[each.part] = hold_of(scene.mockup, each.part, each.kind, each.parts, (), each.anchor, (), each.because)
    for row in [each for each in kept.values() if each.kind == "fitting"]:
        if _is_clamped(scene, row, present, kept):
            del kept[row.fastener]
        else:
            kept[row.fastener] = _without_nuts(scene.mockup, row, kept.values())
    for whole in bearings:
        others = tuple(part for part in whole.parts if part not in given)
        kept[whole.lead] = hold_of(scene.mockup, whole.lead, BODY, others, (), None, (), whole.because)
    for part, parts in given.items():
        was = kept.get(part)
        said = "the table says so"
        if was is None:
            kept[part] = hold_of(scene.mockup, part, "given", parts, (), None, (), said)
        else:
            paths = tuple(scene.mockup.part_paths[each] for each in parts)
            kept[part] = replace(was, parts=parts, paths=paths, because=said)
    if progress is not None:
        progress(1.0, "done")
    return Holds(kept.values())


def _closes(row: Hold, clamp: Retained) -> bool:
    """Whether a fastener has its thread in a clamp that nothing else holds, and holds no other part: its head bears on
    one ear of the clamp, and its thread is in the other."""
    return row.kind in CLOSING and row.anchor == clamp.part and row.parts == (row.fastener,)


def _closing(mockup: Mockup, row: Hold, clamp: Retained) -> Hold:
    """The screw of a clamp: it holds the clamp, and what that touches."""
    parts = (clamp.part, *(part for part in clamp.parts if part not in row.washers))
    paths = tuple(mockup.part_paths[part] for part in parts)
    said = f"its thread is in {row.anchor_path!r}, which it closes; what its clamps touch comes loose too"
    return replace(row, parts=parts, paths=paths, because=said)


def _is_clamped(scene: Scene, fitting: Hold, fasteners: Iterable[Fastener], rows: Mapping[int, Hold]) -> bool:
    """Whether a nut holds a fitting that has neither a thread in what it is in nor a pipe: the hole is wide."""
    ends = {fitting.fastener, *([] if fitting.anchor is None else [fitting.anchor])}
    if any(is_pipe(name_of(scene.mockup, part)) for part in fitting.parts):
        return False
    for nut in fasteners:
        row = rows.get(nut.part)
        clamped = ends.intersection(() if row is None else row.parts)
        if nut.kind == "nut" and row is not None and row.anchor in ends and clamped - {row.anchor}:
            point = nut.frame[:3, 3] - (_finite(nut.length) + BELOW * nut.size) * nut.axis
            ways = around(nut.frame)
            hits = scene.only(sorted(clamped)).rays(np.broadcast_to(point, ways.shape), ways, within=nut.size)
            far = np.where(np.asarray(hits.triangles) >= 0, np.asarray(hits.distances), 0.0)
            if float(np.median(far)) > TIGHT * 0.5 * nut.size:
                return True
    return False


def _without_nuts(mockup: Mockup, fitting: Hold, rows: Iterable[Hold]) -> Hold:
    """A fitting without the pipes that a nut or a clamp holds on it: these come off without it."""
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    low, high = bounds[fitting.fastener] + np.array([[-AT_FITTING_M], [AT_FITTING_M]])
    others: set[int] = set()
    for row in rows:
        own = bounds[row.fastener]
        if row is not fitting and (own[0] <= high).all() and (low <= own[1]).all():
            others.update(row.parts)
    parts = tuple(each for each in fitting.parts if each == fitting.fastener or each not in others)
    return replace(fitting, parts=parts, paths=tuple(mockup.part_paths[each] for each in parts))


def _given(mockup: Mockup, table: Mapping[int | str, PartsLike | None] | None) -> dict[int, tuple[int, ...]]:
    if table is None:
        return {}
    if not isinstance(table, Mapping):
        raise OptionError(f"table is {shown(table)}: give a dict of fasteners and what they hold")
    found: dict[int, tuple[int, ...]] = {}
    for name, parts in table.items():
        what = () if parts is None else tuple(mockup.parts.select(parts).tolist())
        for part in mockup.parts.select(name).tolist():
            if found.get(part, what) != what:
                path = mockup.part_paths[part]
                raise OptionError(f"table says two things of {path!r}: {near(path, list(mockup.part_paths))}")
            found[part] = what
    return found


class _Holding:
    """Looks at all fasteners of a scene."""

    def __init__(self, scene: Scene, rows: list[Fastener], retainers: list[Retained]) -> None:
        self.scene, self.mockup, self.fasteners = scene, scene.mockup, rows
        circlips = [each for each in retainers if each.kind in ("circlip", "cotter")]
        self.circlip_on = {each.anchor: each.part for each in circlips if each.anchor is not None}
        mask = scene.part_mask.copy()
        mask[[row.part for row in rows]] = False
        mask[[each.part for each in circlips]] = False
        self.bare = scene.only(mask)
        self.meshes = PartMeshes(scene.mockup)
        self.windings = Windings(scene)
        self.sizes = np.diff(scene.mockup.part_bounds.reshape(-1, 2, 3), axis=1)[:, 0]
        shanks = [row for row in rows if row.kind != "nut"]
        self.passed = {row.part: found for row, found in zip(shanks, passed_by(self.bare, shanks), strict=True)}
        self.nuts: dict[int, list[Fastener]] = {row.part: [] for row in shanks}
        self.shank: dict[int, Fastener] = {}
        self._pair([row for row in rows if row.kind == "nut"], shanks)
        self._turn_studs()

    def _pair(self, nuts: list[Fastener], shanks: list[Fastener]) -> None:
        """Which nut is on which shank."""
        if not shanks:
            return
        frames = np.linalg.inv(np.array([row.frame for row in shanks]))
        sizes = np.array([row.size for row in shanks])
        lengths = np.array([_finite(row.length) + _head(row) for row in shanks])
        is_headed = np.array([not _is_stud(row) for row in shanks])
        for nut in nuts:
            middle = nut.frame[:3, 3] - 0.5 * _finite(nut.length) * nut.axis
            local = np.einsum("nij,j->ni", frames[:, :3, :3], middle) + frames[:, :3, 3]
            off = np.hypot(local[:, 0], local[:, 1])
            along = np.abs(np.einsum("ni,i->n", frames[:, 2, :3], nut.axis))
            is_on = (off < ON_AXIS * sizes) & (along > 0.99) & (local[:, 2] < 0.5 * sizes)
            is_on &= local[:, 2] > -lengths - 0.5 * _finite(nut.length)
            if is_on.any():
                # Of two that a nut joins, the one with a head, else the one that is deeper in it.
                is_on &= off <= off[is_on].min() + PLAY * sizes
                half = 0.5 * _finite(nut.length)
                shared = np.minimum(local[:, 2] + half, 0.0) - np.maximum(local[:, 2] - half, -lengths)
                shared += np.where(is_headed & (shared > 2.0 * FREE * half), lengths + 2.0 * half, 0.0)
                best = int(np.argmax(np.where(is_on, np.round(shared, 6), -np.inf)))
                self.nuts[shanks[best].part].append(nut)
                self.shank[nut.part] = shanks[best]

    def _turn_studs(self) -> None:
        """Turns studs so that their nuts, or the end that stands out farther, are at the top: of two equal ends, which
        is at the top in their frame is a matter of the pose."""
        turned = {
            row.part: turned_round(row, row.length)
            for row in self.fasteners
            if _is_stud(row) and _finite(row.length) > 0.0 and self._is_top_in(row)
        }
        self.fasteners = [turned.get(row.part, row) for row in self.fasteners]
        self.shank = {nut: turned.get(row.part, row) for nut, row in self.shank.items()}
        rows = list(turned.values())
        self.passed.update(zip(turned, passed_by(self.bare, rows), strict=True))

    def _is_top_in(self, stud: Fastener) -> bool:
        """Whether the top of a stud is its fastened end, so that its frame has to be turned round."""
        passed, _ = self._without_washers(stud, self.passed[stud.part])
        sides = self._sides(stud, passed)
        if sides or not passed:
            return sides == {False}
        above = -max(each.top for each in passed)
        return above + PLAY * stud.size < _finite(stud.length) + min(each.bottom for each in passed)

    def _sides(self, shank: Fastener, passed: list[Passed]) -> set[bool]:
        """On which sides the nuts of a shank hold parts: True for below a nut, False for above."""
        return {self._is_upward(shank, nut, passed) for nut in self.nuts[shank.part]}

    def _is_between_nuts(self, row: Fastener, passed: list[Passed]) -> bool:
        """Whether it is a stud with nuts at both ends."""
        return _is_stud(row) and len(self._sides(row, passed)) > 1

    def spacers(self) -> set[int]:
        """Parts that look like nuts, with a clearance hole for a shank whose thread is farther on."""
        return {part for row in self.fasteners if row.part in self.nuts for part in self._spacers_on(row)}

    def _spacers_on(self, row: Fastener) -> Iterator[int]:
        nuts = [nut.part for nut in self.nuts[row.part]]
        if not nuts:
            return
        on_it = next(iter(passed_by(self.scene.only(nuts), [row])))
        loose = [each for each in on_it if each.radius > 0.0 and not _is_tight(row, each)]
        tight = [each for each in [*on_it, *self.passed[row.part]] if each.radius > 0.0 and _is_tight(row, each)]
        for each in loose:
            middle = 0.5 * (each.top + each.bottom)
            is_thread_below = any(thread.top <= middle for thread in tight)
            is_thread_above = any(thread.bottom >= middle for thread in tight)
            is_between = is_thread_below and (not _is_stud(row) or is_thread_above)
            if is_between and kind_said(name_of(self.mockup, each.part)) != "nut":
                yield each.part

    def rows(self) -> list[Hold]:
        """What each of them holds."""
        found = []
        for row in self.fasteners:
            if row.kind != "nut":
                found.append(self._of_shank(row))
            elif row.part in self.shank:
                found.append(self._of_nut(row, self.shank[row.part]))
            else:
                found.append(self._of_union(row))
        return found

    def _of_shank(self, row: Fastener) -> Hold:
        passed, washers = self._without_washers(row, self.passed[row.part])
        nuts, is_stud = self.nuts[row.part], _is_stud(row)
        mates = tuple(nut.part for nut in nuts)
        jammed = None if is_stud else self._jammed(row, passed, washers)
        if jammed is not None:
            said = f"its thread is in {self._name(jammed.part)}, where {', '.join(map(self._name, mates))} locks it"
            return self._held(row, [], washers, jammed.part, (), said)
        if row.part in self.circlip_on and not nuts:
            said = f"{self._name(self.circlip_on[row.part])} is in its groove or across it"
            return self._held(row, passed, washers, None, (), said)
        if nuts and not is_stud:
            nut = max(nuts, key=lambda each: self._middle(row, each))
            height, mates = self._bearing(row, nut), (nut.part,)  # a lock nut behind it goes first
            clamped = [each for each in passed if each.top > height + PLAY * row.size]
            clamped += self._borne(row, washers) + self._borne(nut, washers)
            clamped += self._shouldered(row, washers, clamped) + self._shouldered(nut, washers, clamped)
            clamped += self._beside(row, washers, clamped, height, nut.part)
            return self._held(row, clamped, washers, nut.part, mates, f"its shank ends in {self._name(nut.part)}")
        inserts = self._inserts(row, passed)
        anchor = self._anchor(row, passed)
        if anchor is None and inserts:
            anchor = min((each for each in passed if each.part in inserts), key=lambda each: each.bottom)
        if anchor is not None and anchor.part in inserts:
            anchor = replace(anchor, part=inserts[anchor.part])
        anchor = anchor or self._in_fastener(row) or self._around_tip(row, passed)
        passed = [each for each in passed if inserts.get(each.part) != _part(anchor) or anchor is None]
        if is_stud:
            said = "it stays: nuts on it hold parts" if nuts else "no nut is on it"
            if anchor is not None:
                said = f"it is fastened in {self._name(anchor.part)}; {said}"
            return hold_of(self.mockup, row.part, row.kind, (), (), _part(anchor), mates, said)
        if anchor is None:
            said = "neither a thread nor a nut was found for it"
            if not passed and not washers and row.length < SHORT * row.size:
                passed = [Passed(part, 0.0, 0.0, 0.0) for part in under(self.bare, row, 0.2 * row.size)]
                said = f"its shank is not drawn; its head lies on {self._names(passed)}"
            return self._held(row, passed + self._borne(row, washers), washers, None, (), said)
        clamped = [each for each in passed if each.top > anchor.top] + self._borne(row, washers)
        clamped += self._shouldered(row, washers, clamped)
        clamped = [each for each in clamped if each.part != anchor.part]
        clamped += self._beside(row, washers, clamped, anchor.top, anchor.part)
        how = "as wide as its thread" if _is_tight(row, anchor) else "where its tip ends"
        how = "without a hole for it" if anchor.radius == 0.0 else how
        return self._held(row, clamped, washers, anchor.part, (), f"its thread is in {self._name(anchor.part)}, {how}")

    def _of_nut(self, nut: Fastener, shank: Fastener) -> Hold:
        passed, washers = self._without_washers(shank, self.passed[shank.part])
        if not _is_stud(shank) and self._jammed(shank, passed, washers) is not None:
            return self._held(nut, [], [], shank.part, (), f"it locks {self._name(shank.part)} in its thread")
        height, is_upward = self._bearing(shank, nut), self._is_upward(shank, nut, passed)
        # Nuts on the same side lock each other: each has to be undone.
        others = [
            each
            for each in self.nuts[shank.part]
            if each is not nut and self._is_upward(shank, each, passed) != is_upward
        ]
        mates = tuple(sorted([shank.part, *(each.part for each in others)]))
        anchor = self._anchor(shank, passed) if _is_stud(shank) else None
        # From this nut to the thread of the stud, where a foil counts, or to the nut at its other end.
        beyond, play = [self._bearing(shank, each) for each in others], PLAY * shank.size
        if is_upward:
            thread = -np.inf if anchor is None else anchor.top
            low, high = max([-np.inf, *(each for each in beyond if each < height)]), height
            clamped = [each for each in passed if each.top > max(low + play, thread) and each.bottom < high - play]
            low = max(low, thread)
        else:
            thread = np.inf if anchor is None else anchor.bottom
            low, high = height, min([np.inf, *(each for each in beyond if each > height)])
            clamped = [each for each in passed if each.top > low + play and each.bottom < min(high - play, thread)]
            high = min(high, thread)
        # What the nut at the other end bears on counts, too, and what a nut in front of this one does.
        between = [each for each in self.nuts[shank.part] if low <= self._bearing(shank, each) <= high]
        for each in between:
            clamped += self._borne(each, washers)
        if not _is_stud(shank):
            clamped += self._borne(shank, washers)
            clamped += self._shouldered(shank, washers, clamped)
        for each in between:
            clamped += self._shouldered(each, washers, clamped)
        clamped = [each for each in clamped if each.part != _part(anchor)]
        if anchor is not None:
            point = shank.frame[:3, 3] + (anchor.top if is_upward else anchor.bottom) * shank.axis
            depth = float((point - nut.frame[:3, 3]) @ nut.axis)
            clamped += self._beside(nut, washers, clamped, depth, anchor.part)
        elif not _is_stud(shank) and not others:
            clamped += self._beside(shank, washers, clamped, height, nut.part)
        joined = self._joined(nut, shank)
        if joined and _is_stud(shank):
            both = [Passed(shank.part, height, height, 0.0), *joined]
            return self._held(nut, clamped + both, washers, shank.part, (), f"it joins {self._names(both)}")
        clamped += joined
        return self._held(nut, clamped, washers, shank.part, mates, f"it is on {self._name(shank.part)}")

    def _jammed(self, row: Fastener, passed: list[Passed], washers: list[int]) -> Passed | None:
        """The part that a screw has its thread in, if nuts only lock it there: they hold nothing against its head."""
        nuts, anchor = self.nuts[row.part], self._anchor(row, passed)
        if not nuts or anchor is None or any(each.part != anchor.part for each in passed):
            return None
        is_headless = self._width(row) <= HEADLESS * row.size
        if not is_headless and any(self._middle(row, nut) < max(each.top for each in passed) for nut in nuts):
            return None
        borne_by = [each.part for nut in nuts for each in self._borne(nut, washers)]
        return anchor if all(part == anchor.part for part in borne_by) else None

    def _borne(self, row: Fastener, washers: list[int]) -> list[Passed]:
        """What a head or a nut bears on, through its washers, also beside the shank."""
        height = row.length if row.kind == "nut" else row.head_height
        if not np.isfinite(height) or not height > SEAT * row.size:
            return []
        below, wide = self._face(row, washers)
        parts = borne(self.windings, self.bare.without(washers) if washers else self.bare, row, below, wide)
        return [Passed(part, below, below, 0.0) for part in parts]

    def _shouldered(self, row: Fastener, washers: list[int], held: list[Passed]) -> list[Passed]:
        """What rings with a shoulder bear on, if a head or a nut holds or bears on nothing but such: grommets, flanged
        bushes."""
        for ends in (held, self._borne(row, washers)):
            rings = sorted({each.part for each in ends})
            if rings and all(self._is_round_it(row, part, TALL) for part in rings):
                break
        else:
            return []
        local = np.concatenate([self.meshes.mesh(part)[0] - row.frame[:3, 3] for part in rings]) @ row.frame[:3, :3]
        below, wide = self._face(row, washers)[0], 2.0 * float(np.hypot(local[:, 0], local[:, 1]).max())
        bare = self.bare.without([*rings, *washers])
        parts = borne(self.windings, bare, row, below, wide, max(0.0, below - float(local[:, 2].min())))
        tool = Tool.of_parts(self.mockup, rings)
        near = set(self.bare.only(parts).clearance(tool, np.eye(4), PLAY * row.size).parts.tolist()) if parts else set()
        return [Passed(part, below, below, 0.0) for part in parts if part in near]

    def _face(self, row: Fastener, washers: list[int]) -> tuple[float, float]:
        """Height and diameter of the face that a head or a nut bears with, its washers included."""
        below, wide = -_finite(row.length if row.kind == "nut" else row.head_height), self._width(row)
        for each in washers:
            local = (self.meshes.mesh(each)[0] - row.frame[:3, 3]) @ row.frame[:3, :3]
            low, high = float(local[:, 2].min()), float(local[:, 2].max())
            if low < below <= high + WASHER_GAP * row.size:
                below, wide = low, 2.0 * float(np.hypot(local[:, 0], local[:, 1]).max())
        return below, wide

    def _beside(self, row: Fastener, washers: list[int], held: list[Passed], low: float, end: int) -> list[Passed]:
        """What is pressed beside a shank between what a head or a nut holds and the part at the other end.

        low: the height where that part begins, in the frame of the head or the nut.
        """
        parts = {each.part for each in held}
        if not parts:
            return []
        bare = self.bare.without(washers) if washers else self.bare
        high = self._face(row, washers)[0]
        found = clamped_beside(self.windings, bare, row, high, low, parts, end)
        return [Passed(part, low, low, 0.0) for part in found]

    def _width(self, row: Fastener) -> float:
        """The diameter of the bearing face of a head or a nut: within its flats."""
        if row.drive in OUTER_DRIVES and np.isfinite(row.across_flats):
            return float(row.across_flats)
        local = (self.meshes.mesh(row.part)[0] - row.frame[:3, 3]) @ row.frame[:3, :3]
        return 2.0 * float(np.hypot(local[:, 0], local[:, 1]).max())

    def _is_upward(self, shank: Fastener, nut: Fastener, passed: list[Passed]) -> bool:
        """Whether a nut holds what is below it: its own axis says so only where there are parts on both sides."""
        height = self._middle(shank, nut)
        below = [0.5 * (each.top + each.bottom) < height for each in passed]
        if below and all(each == below[0] for each in below):
            return below[0]
        return float(nut.axis @ shank.axis) > 0.0

    def _joined(self, nut: Fastener, shank: Fastener) -> list[Passed]:
        """What else has its thread in a nut, where it is longer than its shank reaches: the other one of two rods."""
        high = float((shank.frame[:3, 3] - nut.frame[:3, 3]) @ nut.axis)
        foot = high - (_head(shank) + _finite(shank.length)) * float(shank.axis @ nut.axis)
        length = _finite(nut.length)
        if min(0.0, max(high, foot)) - max(-length, min(high, foot)) > (1.0 - FREE) * length:
            return []
        rods = [row.part for row in self.fasteners if _is_stud(row) and row is not shank]
        mask = self.bare.part_mask.copy()
        mask[rods] = True
        return [each for each in in_bore(self.scene.only(mask), nut, self.meshes) if self._is_threaded(nut, each)]

    def _is_threaded(self, nut: Fastener, inside: Passed) -> bool:
        """Whether a part has its thread in a nut."""
        return inside.radius >= THREADED * 0.5 * nut.size and self._play(nut, inside) <= TIGHT - 1.0

    def _of_union(self, nut: Fastener) -> Hold:
        """A nut without a shank of its own: on a pipe, or on the thread of a part."""
        inside = in_bore(self.bare, nut, self.meshes)
        threads = [each for each in inside if each.radius >= THREADED * 0.5 * nut.size]
        anchor = min(threads, key=lambda each: (self._play(nut, each), each.bottom), default=None)
        held = [each for each in inside if each.part != _part(anchor)]
        if anchor is not None and any(_is_alike(each, anchor) and self._is_threaded(nut, each) for each in held):
            return self._held(nut, inside, [], anchor.part, (), f"it joins {self._names(inside)}")
        if not held:
            below = [part for part in under(self.bare, nut, 0.1 * nut.size) if part != _part(anchor)]
            held = [Passed(part, 0.0, 0.0, 0.0) for part in below]
        held, washers = self._without_washers(nut, held)
        if not held:
            # The hub of a wheel is wider than the thread that the nut is on.
            held = [each for each in self._borne(nut, washers) if each.part != _part(anchor)]
            held, more = self._without_washers(nut, held)
            if more and not held:
                washers = [*washers, *more]
                held = [each for each in self._borne(nut, washers) if each.part != _part(anchor)]
        if anchor is None:
            return self._held(nut, held, washers, None, (), "nothing is in its bore")
        shoulder = self._shoulder(nut, anchor.part)
        held = held if shoulder is None else held + self._beside(nut, washers, held, shoulder, anchor.part)
        return self._held(nut, held, washers, anchor.part, (), f"its thread is on {self._name(anchor.part)}")

    def _shoulder(self, nut: Fastener, part: int) -> float | None:
        """Where the part that a nut is on is wider than its thread below it, in the frame of the nut: at the head of a
        hammer bolt, at the collar of an eye bolt or a shaft."""
        return shoulder_below(self.scene.only([part]), nut, -_finite(nut.length), float(self.sizes[part].max()))

    def _play(self, nut: Fastener, inside: Passed) -> float:
        """How much wider the bore of a nut is than a part in it, as a share, to a thousandth: its thread is tight."""
        ring = around(nut.frame)
        origin = nut.frame[:3, 3] + 0.5 * (inside.top + inside.bottom) * nut.axis
        alone = self.scene.only([nut.part])
        hits = alone.rays(np.broadcast_to(origin, ring.shape), ring, within=float(self.sizes[nut.part].max()))
        met = np.asarray(hits.distances)[np.asarray(hits.triangles) >= 0]
        wide = float(np.median(met)) if len(met) else np.inf
        return round(wide / inside.radius - 1.0, 3) if inside.radius > 0.0 and np.isfinite(wide) else np.inf

    def _held(
        self,
        row: Fastener,
        passed: list[Passed],
        washers: list[int],
        anchor: int | None,
        mates: tuple[int, ...],
        said: str,
    ) -> Hold:
        parts = list(dict.fromkeys(each.part for each in passed))
        if not parts and anchor is not None and not mates:
            because = f"{said}; it holds nothing but {'its washers' if washers else 'itself'}"
            return hold_of(self.mockup, row.part, row.kind, (row.part,), tuple(washers), anchor, (), because)
        known = {row.part, *mates, *washers, *([] if anchor is None else [anchor])}
        more = clasped(self.bare, parts, known, self.meshes)
        because = f"{said}; what its clamps touch comes loose too" if more else said
        return hold_of(self.mockup, row.part, row.kind, (*parts, *more), tuple(washers), anchor, mates, because)

    def _without_washers(self, row: Fastener, passed: list[Passed]) -> tuple[list[Passed], list[int]]:
        """Parts, and the washers: flat rings with nothing but such between them and the head or a nut. Rings between
        other parts are shims and seals, which are held."""
        rings = {each.part for each in passed if self._is_ring(row, each.part)}
        ends = [] if _is_stud(row) else [np.inf]
        ends += [self._middle(row, nut) for nut in self.nuts.get(row.part, [])]
        ends += [-np.inf] if row.kind == "nut" else []
        others = [0.5 * (each.top + each.bottom) for each in passed if each.part not in rings]
        washers = []
        for each in passed:
            middle = 0.5 * (each.top + each.bottom)
            is_next = any(not any(min(middle, end) < o < max(middle, end) for o in others) for end in ends)
            if each.part in rings and is_next:
                washers.append(each.part)
        return [each for each in passed if each.part not in washers], washers

    def _is_ring(self, row: Fastener, part: int) -> bool:
        """Whether a part looks like a washer of a fastener."""
        return self._is_round_it(row, part, WASHER_HEIGHT)

    def _is_round_it(self, row: Fastener, part: int, height: float) -> bool:
        """Whether a part is a ring about a fastener, no wider than its washers. height: the greatest, in diameters."""
        flats = row.across_flats if np.isfinite(row.across_flats) else 0.0
        usual, large = WASHER_WIDTH * max(flats, 1.8 * row.size), LARGE_WASHER * row.size
        if self.sizes[part].max() > 1.01 * max(usual, large):
            return False
        local = (self.meshes.mesh(part)[0] - row.frame[:3, 3]) @ row.frame[:3, :3]
        radius = np.hypot(local[:, 0], local[:, 1])
        across, high = 2.0 * radius.max(), np.ptp(local[:, 2]) / row.size
        is_flat = (across <= usual and high <= height) or (across <= large and high <= LARGE_HEIGHT)
        return bool(is_flat and radius.min() > 0.4 * row.size)

    def _anchor(self, row: Fastener, passed: list[Passed]) -> Passed | None:
        """The deepest part that the shank is tight in; one around a thinner point of it only if there is no other. A
        stud with nuts at both ends that is tight in several parts has none: which hole is a thread is not known."""
        tight = [each for each in passed if _is_tight(row, each)]
        tight = [each for each in tight if not self._is_round_point(row, each)] or tight
        if len({each.part for each in tight}) > 1 and self._is_between_nuts(row, passed):
            return None
        return min(tight, key=lambda each: each.bottom, default=None)

    def _is_round_point(self, row: Fastener, inside: Passed) -> bool:
        """Whether a part is around a thinner point of a screw, which is free in it: the dog of a set screw."""
        thread = 0.5 * thread_size(row)
        own = radius_at(row, self.meshes.corners(row.part), 0.5 * (inside.top + inside.bottom))
        is_thin = own < THIN * thread or (own < CORE * thread and inside.radius < POINT * thread)
        return own > 0.0 and is_thin and inside.radius > TIGHT * own

    def _in_fastener(self, row: Fastener) -> Passed | None:
        """Another fastener that the shank has its thread in: a standoff, a bolt with a hole in its end."""
        if not _finite(row.length) > 0.0:
            return None
        tip = row.frame[:3, 3] - (_head(row) + TIP * row.length) * row.axis
        bounds = self.mockup.part_bounds.reshape(-1, 2, 3)
        others = [each.part for each in self.fasteners if each is not row and each.kind != "nut"]
        near = [part for part in others if (bounds[part, 0] <= tip).all() and (tip <= bounds[part, 1]).all()]
        if not near:
            return None
        passed = next(iter(passed_by(self.scene.only(near), [row])))
        return self._anchor(row, [each for each in passed if each.radius > 0.0])

    def _inserts(self, row: Fastener, passed: list[Passed]) -> dict[int, int]:
        """The threaded inserts that a shank is in, and the part that each is in."""
        radius = 0.5 * thread_size(row)
        found = {}
        for each in passed:
            if each.radius == 0.0 or self.sizes[each.part].max() > 4.0 * INSERT * radius:
                continue
            local = (self.meshes.mesh(each.part)[0] - row.frame[:3, 3]) @ row.frame[:3, :3]
            low, high = local.min(axis=0), local.max(axis=0)
            middle = 0.5 * (low + high)
            across = float(np.hypot(*(local - middle)[:, :2].T).max())
            if across > INSERT * radius or high[2] - low[2] < WASHER_HEIGHT * radius:
                continue
            own = self.bare.without([each.part])
            around = surrounding(own, row.frame[:3, :3] @ middle + row.frame[:3, 3], row.frame, AROUND_INSERT * across)
            if around is not None:
                found[each.part] = around
        return found

    def _around_tip(self, row: Fastener, passed: list[Passed]) -> Passed | None:
        """The deepest part, if the tip ends in it, and others are above: the tip of a bolt with a nut stands out."""
        deepest = min(passed, key=lambda each: each.bottom, default=None)
        if deepest is None or not _finite(row.length) > 0.0 or self._is_between_nuts(row, passed):
            return None
        is_in = deepest.bottom <= -_head(row) - TIP * row.length
        is_alone = all(each.part == deepest.part for each in passed)
        return deepest if is_in and not is_alone else None

    @staticmethod
    def _middle(shank: Fastener, nut: Fastener) -> float:
        """Where a nut is along a shank, whichever way it faces."""
        point = nut.frame[:3, 3] - 0.5 * _finite(nut.length) * nut.axis
        return float((point - shank.frame[:3, 3]) @ shank.axis)

    @staticmethod
    def _bearing(shank: Fastener, nut: Fastener) -> float:
        """Where the bearing face of a nut is along a shank."""
        point = nut.frame[:3, 3] - _finite(nut.length) * nut.axis
        return float((point - shank.frame[:3, 3]) @ shank.axis)

    def _names(self, passed: list[Passed]) -> str:
        return ", ".join(self._name(each.part) for each in passed) or "nothing"

    def _name(self, part: int) -> str:
        return repr(self.mockup.part_paths[part])


def _part(passed: Passed | None) -> int | None:
    return None if passed is None else passed.part


def _is_tight(row: Fastener, passed: Passed) -> bool:
    """Whether a hole is a thread or a fit for a shank."""
    return passed.radius <= TIGHT * 0.5 * thread_size(row) or passed.least <= CORE * 0.5 * row.size


def _is_alike(one: Passed, other: Passed) -> bool:
    """Whether two rods may have the same thread: the pipe in a union nut is thinner."""
    return abs(one.radius - other.radius) <= ALIKE * other.radius


def _is_stud(row: Fastener) -> bool:
    """Whether it has no head: a wheel stud is a bolt."""
    return row.kind == "stud" and not _finite(row.head_height) > 0.0


def _finite(value: float) -> float:
    return value if np.isfinite(value) else 0.0


def _head(row: Fastener) -> float:
    return _finite(row.head_height)


def _share(progress: Progress, share: float) -> Progress:
    """Progress of the first share of the work."""

    def report(done: float, stage: str) -> None:
        progress(share * done, stage)

    return report
