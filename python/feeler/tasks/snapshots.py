"""The parts of a mock-up as the nightly run remembers them, and what changed between two runs."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from feeler.field_docs import documented
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes
from feeler.plan.blocking import room_of
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.frames import scene_axes
from feeler.scene import Scene
from feeler.tasks.fixings import Fixings
from feeler.tasks.held_rows import Hold, Holds
from feeler.tasks.regions import Regions, leaves
from feeler.tasks.times import Times

Floats = npt.NDArray[np.float64]
What = Literal["added", "removed", "moved", "changed shape", "is held otherwise", "renamed"]

STEP_M = 1e-6
"""Boxes around triangles are rounded outwards to this, metres."""
_DECIMALS = 9
_OTHERWISE: What = "is held otherwise"
COARSE = 1e-5
"""The step of sizes and places of fasteners whose mesh is as it was, metres, and of directions."""
SAME_PLACE_M = 1e-9
"""The step of corners in a digest, metres: last digits of coordinates follow the unit of a file, and are no change."""
SAME_SHARE = 1e-6
"""How much area and length of edges may differ where a part only moved."""


@documented
@dataclass(frozen=True)
class MaintainChange:
    """What changed of one part between two runs."""

    path: str
    """The part."""
    what: What
    """"is held otherwise": it stayed, but another part holds it, or it holds others. "renamed": the table of times has
    other entries for its new path; other new paths change nothing, and are no change."""

    def __str__(self) -> str:
        verb = {each: f"was {each}" for each in ("added", "removed", "renamed")}.get(self.what, self.what)
        return f"{self.path} {verb}"

    def to_dict(self) -> dict[str, str]:
        """A dict of plain Python values, as JSON takes them."""
        return {"path": self.path, "what": self.what}


@dataclass(frozen=True)
class Seen:
    """One part."""

    digest: str
    """Of its triangles, to `SAME_PLACE_M`."""
    measure: tuple[float, float, float]
    """Number of triangles, area, square metres, and length of all edges, metres: motions keep them."""
    box: tuple[float, ...]
    """Lower and upper corner, metres."""
    surface: tuple[float, ...]
    """Boxes around its triangles, six numbers each."""
    middle: tuple[float, float, float] | None = None
    """The centroid of its surface, metres, by which it is recognised under another path; None in older files."""

    @property
    def bounds(self) -> Floats:
        """`(2, 3)`."""
        return np.array(self.box).reshape(2, 3)

    @property
    def boxes(self) -> Floats:
        """`(n, 2, 3)`, around its triangles."""
        return np.array(self.surface).reshape(-1, 2, 3)


@dataclass(frozen=True)
class Held:
    """What was known of one fastener, in paths."""

    facts: str
    """Its kind, sizes and drive, and how it is anchored."""
    joins: frozenset[str]
    """The parts that it holds or is fastened in."""
    mates: tuple[str, ...]
    """Other fasteners on its axis."""


@dataclass(frozen=True)
class Snapshot:
    """All parts of a scene, by path; equal paths are numbered."""

    parts: Mapping[str, Seen]
    held: Mapping[str, Held]
    axes: tuple[tuple[float, ...], ...]
    """Those of the scene."""
    scene: str
    """The digest of all that the scene is made of: `scene_digest`."""

    @classmethod
    def of(cls, scene: Scene, fasteners: Fasteners, held: Holds, seen: Mapping[str, Seen] | None = None) -> Snapshot:
        """That of a scene. seen: its parts, as `parts_seen` gives them; None: they are looked at."""
        mockup = scene.mockup
        keys = keys_of(mockup)
        if seen is None:
            seen = parts_seen(scene)
        table: Any = Times()  # it is not asked
        fixings = Fixings(scene, fasteners, held, table)
        rows = {row.part: row for row in fasteners}
        holding = {hold.fastener: hold for hold in held}
        known = {
            keys[part]: _held(holding.get(part), rows.get(part), fixings, keys)
            for part in sorted(holding.keys() | rows.keys())
            if scene.part_mask[part]
        }
        axes = tuple(tuple(axis.tolist()) for axis in scene_axes(scene))
        return cls(seen, known, axes, scene_digest(scene))

    @property
    def bounds(self) -> Floats:
        """`(2, 3)`: the box of all parts; NaN without any."""
        boxes = np.array([each.box for each in self.parts.values()]).reshape(-1, 2, 3)
        boxes = boxes[np.isfinite(boxes).all(axis=(1, 2))]
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]) if len(boxes) else np.full((2, 3), np.nan)

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return {
            "parts": {
                key: [each.digest, list(each.measure), _numbers(each.box), _numbers(each.surface)]
                for key, each in self.parts.items()
            },
            "middles": {key: list(each.middle) for key, each in self.parts.items() if each.middle is not None},
            "held": {key: [each.facts, sorted(each.joins), list(each.mates)] for key, each in self.held.items()},
            "axes": [list(axis) for axis in self.axes],
            "scene": self.scene,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Snapshot:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        parts = {}
        middles = data.get("middles", {})
        for key, (digest, measure, *boxes) in data["parts"].items():
            count, area, edges = measure
            box, surface = (tuple(math.nan if value is None else float(value) for value in each) for each in boxes)
            if len(box) != 6 or len(surface) % 6:
                raise ValueError("a box has six numbers")
            middle = _point(middles[key]) if key in middles else None
            parts[str(key)] = Seen(str(digest), (float(count), float(area), float(edges)), box, surface, middle)
        held = {
            str(key): Held(str(facts), frozenset(map(str, joins)), tuple(map(str, mates)))
            for key, (facts, joins, mates) in data["held"].items()
        }
        axes = tuple(tuple(float(value) for value in axis) for axis in data["axes"])
        return cls(parts, held, axes, str(data["scene"]))


class Changes(Sequence[MaintainChange]):
    """What changed from one snapshot to the next, and on which rows it bears."""

    def __init__(
        self, old: Snapshot, new: Snapshot, is_bare: bool = False, retimed: frozenset[str] = frozenset()
    ) -> None:
        """is_bare: without tools, rows do not look at each fastener that they count on. retimed: parts of both whose
        new paths have other times."""
        self._seen: dict[str, list[Seen]] = {}
        self._joined: dict[str, frozenset[str]] = {}
        rows: list[MaintainChange] = []
        for key in sorted(old.parts.keys() | new.parts.keys()):
            before, now = old.parts.get(key), new.parts.get(key)
            what = _what(before, now)
            lost, gained = old.held.get(key), new.held.get(key)
            is_other = lost != gained or any(old.held.get(each) != new.held.get(each) for each in _mates(lost, gained))
            if what is None and not is_other and key not in retimed:
                continue
            rows.append(MaintainChange(key, what or (_OTHERWISE if is_other else "renamed")))
            self._seen[key] = [each for each in (before, now) if each is not None]
            if is_other:
                joins = [frozenset[str]() if each is None else each.joins for each in (lost, gained)]
                is_wide = is_bare and bool(_mates(lost, gained))
                self._joined[key] = joins[0] | joins[1] if is_wide else joins[1] - joins[0]
        self._rows = tuple(rows)
        common = old.parts.keys() & new.parts.keys()
        is_mixed = [key for key in old.parts if key in common] != [key for key in new.parts if key in common]
        pairs = (old.bounds, new.bounds), (np.array(old.axes), np.array(new.axes))
        is_same_box = all(np.allclose(a, b, rtol=0.0, atol=SAME_PLACE_M, equal_nan=True) for a, b in pairs)
        self.is_beyond = is_mixed or not is_same_box or bool(retimed)
        """Whether it bears on all rows: parts come in another order, the box of all or its axes are others, by which
        directions are put in order, or new paths have other times."""
        rooms = [np.stack(room_of(*each.bounds)) for each in (old, new)]
        self.is_other = is_mixed or not np.array_equal(rooms[0], rooms[1], equal_nan=True)
        """Whether it bears on all answers: parts come in another order, or casts end elsewhere."""
        self._beside = {**old.parts, **new.parts}

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Any:
        return self._rows[index]

    def __iter__(self) -> Iterator[MaintainChange]:
        return iter(self._rows)

    def bearing_on(self, looked: Regions) -> list[MaintainChange]:
        """The changes that bear on what looked there."""
        if not self._rows:
            return []
        if self.is_beyond:
            return list(self._rows)
        return [change for change in self._rows if self._bears(change.path, looked)]

    def within(self, lower: Floats, upper: Floats) -> list[MaintainChange]:
        """The changed parts that were or are in a box."""
        if self.is_beyond:
            return list(self._rows)
        looked = replace(Regions.everything(), is_all=False, boxes=np.stack([lower, upper])[None])
        return [change for change in self._rows if change.what != _OTHERWISE and self._is_seen(change.path, looked)]

    def _is_seen(self, key: str, looked: Regions) -> bool:
        return any(looked.bear(each.bounds, each.boxes) for each in self._seen[key])

    def _bears(self, key: str, looked: Regions) -> bool:
        if key in looked.asked or self._is_seen(key, looked):
            return True
        # What it newly holds has to wait for it, wherever it is. What it held was asked where it was.
        gained = self._joined.get(key, frozenset[str]())
        beside = [self._beside[each] for each in sorted(gained) if each in self._beside]
        return bool(gained & looked.asked) or any(looked.bear(each.bounds, each.boxes) for each in beside)


def scene_digest(scene: Scene) -> str:
    """The same text for the same vertices, faces and names, in the same order, with the same parts present."""
    mockup = scene.mockup
    digest = hashlib.blake2b(json.dumps([mockup.part_paths, mockup.part_names]).encode(), digest_size=16)
    for array in (mockup.vertices, mockup.faces, mockup.part_of_face, scene.part_mask):
        digest.update(f"{array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
    return digest.hexdigest()


def parts_seen(scene: Scene, before: Iterable[Seen] = ()) -> dict[str, Seen]:
    """The parts of a scene by path, as `keys_of`. before: parts of an earlier run; those with the same triangles in the
    same places are taken from it."""
    mockup = scene.mockup
    keys, known = keys_of(mockup), {each.digest: each for each in before}
    meshes, bounds = PartMeshes(mockup), mockup.part_bounds.reshape(-1, 2, 3)
    return {keys[n]: _seen(meshes.corners(n), bounds[n], known) for n in np.flatnonzero(scene.part_mask).tolist()}


def keys_of(mockup: Mockup) -> list[str]:
    """The path of each part; the second of a path is `path#2`, and so on."""
    count: Counter[str] = Counter()
    keys = []
    for path in mockup.part_paths:
        count[path] += 1
        keys.append(path if count[path] == 1 else f"{path}#{count[path]}")
    return keys


def _what(before: Seen | None, now: Seen | None) -> What | None:
    if before is None:
        return "added"
    if now is None:
        return "removed"
    if before.digest == now.digest:
        return None
    is_alike = before.measure[0] == now.measure[0] and all(
        abs(one - other) <= SAME_SHARE * max(one, other)
        for one, other in zip(before.measure[1:], now.measure[1:], strict=True)
    )
    return "moved" if is_alike else "changed shape"


def _seen(corners: Floats, bounds: Floats, known: Mapping[str, Seen]) -> Seen:
    """A part with triangles `(k, 3, 3)` and a box `(2, 3)`. known: parts by digest."""
    digest = hashlib.blake2b(_steps(corners, SAME_PLACE_M).tobytes(), digest_size=12).hexdigest()
    box = tuple(float(value) for value in bounds.ravel())
    before = known.get(digest)
    if before is not None and before.box == box and before.middle is not None:
        return before
    with np.errstate(invalid="ignore", over="ignore"):
        sides = corners[:, [1, 2, 0]] - corners
        areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        area, middle = areas.sum(), corners.mean(axis=1).T @ areas
        edges = np.linalg.norm(sides, axis=2).sum()
    around = leaves(corners)
    surface = np.stack([np.floor(around[:, 0] / STEP_M), np.ceil(around[:, 1] / STEP_M)], axis=1) * STEP_M
    rounded = tuple(np.round(surface, _DECIMALS).ravel().tolist())
    return Seen(
        digest, (float(len(corners)), _finite(area), _finite(edges)), box, rounded, _centroid(middle, area, bounds)
    )


def _centroid(moment: Floats, area: float, bounds: Floats) -> tuple[float, float, float]:
    """That of a surface with an area and a moment `(3,)`; without area that of its box `(2, 3)`, or the origin."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        places = moment / area, bounds.mean(axis=0), np.zeros(3)
    return _point(next(each for each in places if np.isfinite(each).all()).round(_DECIMALS).tolist())


def _point(values: Sequence[Any]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _held(hold: Hold | None, row: Fastener | None, fixings: Fixings, keys: Sequence[str]) -> Held:
    facts: list[Any] = []
    if row is not None:
        # Fasteners of one shape are aligned to one of them: another one changes their last digits.
        sizes = np.array([row.size, row.length, row.width, row.head_height])
        facts += [row.kind, row.drive]
        facts += [_steps(each, COARSE).tolist() for each in (sizes, row.frame[:3, 2:].ravel())]
    if hold is None:
        return Held(repr(facts), frozenset(), ())
    captive = fixings.captive_on(hold.fastener) if hold.fastener in fixings else None
    more = fixings.joins(hold.fastener)
    joins = [*hold.parts, *more, *(each for each in (hold.anchor, captive) if each is not None)]
    anchor = None if hold.anchor is None else keys[hold.anchor]
    facts += [
        hold.kind,
        [keys[each] for each in hold.parts],
        [keys[each] for each in more],
        [keys[each] for each in hold.mates],
    ]
    facts += [anchor, None if captive is None else keys[captive], [keys[each] for each in hold.washers]]
    facts.append([keys[each] for each in fixings.washers(hold.fastener)])
    return Held(repr(facts), frozenset(keys[each] for each in joins), tuple(keys[each] for each in hold.mates))


def _steps(values: Floats, step: float) -> Floats:
    """Whole steps, whose borders are off round numbers of metres and inches."""
    with np.errstate(over="ignore"):
        return np.floor(values / step + 0.37)


def _mates(*held: Held | None) -> set[str]:
    return {mate for each in held if each is not None for mate in each.mates}


def _finite(value: float) -> float:
    return float(value) if math.isfinite(value) else -1.0


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]
