"""The parts of a mock-up as the nightly run remembers them, and what changed between two runs."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
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
from feeler.tasks.holding import Hold, Holds
from feeler.tasks.regions import Regions, leaves
from feeler.tasks.times import Times

Floats = npt.NDArray[np.float64]
What = Literal["added", "removed", "moved", "changed shape", "is held otherwise"]

STEP_M = 1e-6
"""Boxes around triangles are rounded outwards to this, metres."""
_DECIMALS = 9
_OTHERWISE: What = "is held otherwise"
COARSE = 1e-5
"""The step of sizes and places of fasteners whose mesh is as it was, metres, and of directions."""
SAME_SHARE = 1e-6
"""How much area and length of edges may differ where a part only moved."""


@documented
@dataclass(frozen=True)
class MaintainChange:
    """What changed of one part between two runs."""

    path: str
    """The part."""
    what: What
    """"is held otherwise": it stayed, but another part holds it, or it holds others."""

    def __str__(self) -> str:
        verb = {"added": "was added", "removed": "was removed"}.get(self.what, self.what)
        return f"{self.path} {verb}"

    def to_dict(self) -> dict[str, str]:
        """A dict of plain Python values, as JSON takes them."""
        return {"path": self.path, "what": self.what}


@dataclass(frozen=True)
class Seen:
    """One part."""

    digest: str
    """Of its triangles."""
    measure: tuple[float, float, float]
    """Number of triangles, area, square metres, and length of all edges, metres: motions keep them."""
    box: tuple[float, ...]
    """Lower and upper corner, metres."""
    surface: tuple[float, ...]
    """Boxes around its triangles, six numbers each."""

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
    def of(
        cls, scene: Scene, fasteners: Fasteners, held: Holds, before: Mapping[str, Seen] = MappingProxyType({})
    ) -> Snapshot:
        """That of a scene. before: the parts of an earlier one; those that are as they were are taken from it."""
        mockup = scene.mockup
        keys = keys_of(mockup)
        present = np.flatnonzero(scene.part_mask).tolist()
        meshes, bounds = PartMeshes(mockup), mockup.part_bounds.reshape(-1, 2, 3)
        seen = {keys[n]: _seen(meshes.corners(n), bounds[n], before.get(keys[n])) for n in present}
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
            "held": {key: [each.facts, sorted(each.joins), list(each.mates)] for key, each in self.held.items()},
            "axes": [list(axis) for axis in self.axes],
            "scene": self.scene,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Snapshot:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        parts = {}
        for key, (digest, measure, *boxes) in data["parts"].items():
            count, area, edges = measure
            box, surface = (tuple(math.nan if value is None else float(value) for value in each) for each in boxes)
            if len(box) != 6 or len(surface) % 6:
                raise ValueError("a box has six numbers")
            parts[str(key)] = Seen(str(digest), (float(count), float(area), float(edges)), box, surface)
        held = {
            str(key): Held(str(facts), frozenset(map(str, joins)), tuple(map(str, mates)))
            for key, (facts, joins, mates) in data["held"].items()
        }
        axes = tuple(tuple(float(value) for value in axis) for axis in data["axes"])
        return cls(parts, held, axes, str(data["scene"]))


class Changes(Sequence[MaintainChange]):
    """What changed from one snapshot to the next, and on which rows it bears."""

    def __init__(self, old: Snapshot, new: Snapshot, is_bare: bool = False) -> None:
        """is_bare: without tools, rows do not look at each fastener that they count on."""
        self._seen: dict[str, list[Seen]] = {}
        self._joined: dict[str, frozenset[str]] = {}
        rows: list[MaintainChange] = []
        for key in sorted(old.parts.keys() | new.parts.keys()):
            before, now = old.parts.get(key), new.parts.get(key)
            what = _what(before, now)
            lost, gained = old.held.get(key), new.held.get(key)
            is_other = lost != gained or any(old.held.get(each) != new.held.get(each) for each in _mates(lost, gained))
            if what is None and not is_other:
                continue
            rows.append(MaintainChange(key, what or _OTHERWISE))
            self._seen[key] = [each for each in (before, now) if each is not None]
            if is_other:
                joins = [frozenset[str]() if each is None else each.joins for each in (lost, gained)]
                is_wide = is_bare and bool(_mates(lost, gained))
                self._joined[key] = joins[0] | joins[1] if is_wide else joins[1] - joins[0]
        self._rows = tuple(rows)
        common = old.parts.keys() & new.parts.keys()
        is_mixed = [key for key in old.parts if key in common] != [key for key in new.parts if key in common]
        is_same_box = np.array_equal(old.bounds, new.bounds, equal_nan=True)
        self.is_beyond = is_mixed or not is_same_box or old.axes != new.axes
        """Whether it bears on all rows: parts come in another order, or the box of all or its axes are others, by which
        directions are put in order."""
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


def _seen(corners: Floats, bounds: Floats, before: Seen | None) -> Seen:
    """A part with triangles `(k, 3, 3)` and a box `(2, 3)`."""
    digest = hashlib.blake2b(np.ascontiguousarray(corners).tobytes(), digest_size=12).hexdigest()
    box = tuple(float(value) for value in bounds.ravel())
    if before is not None and (before.digest, before.box) == (digest, box):
        return before
    with np.errstate(invalid="ignore", over="ignore"):
        sides = corners[:, [1, 2, 0]] - corners
        area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
        edges = np.linalg.norm(sides, axis=2).sum()
    around = leaves(corners)
    surface = np.stack([np.floor(around[:, 0] / STEP_M), np.ceil(around[:, 1] / STEP_M)], axis=1) * STEP_M
    rounded = tuple(np.round(surface, _DECIMALS).ravel().tolist())
    return Seen(digest, (float(len(corners)), _finite(area), _finite(edges)), box, rounded)


def _held(hold: Hold | None, row: Fastener | None, fixings: Fixings, keys: Sequence[str]) -> Held:
    facts: list[Any] = []
    if row is not None:
        # Fasteners of one shape are aligned to one of them: another one changes their last digits.
        sizes = np.array([row.size, row.length, row.width, row.head_height])
        facts += [row.kind, row.drive, _coarse(sizes).tolist(), _coarse(row.frame[:3, 2:]).ravel().tolist()]
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


def _coarse(values: Floats) -> Floats:
    """Whole steps, whose borders are off round numbers."""
    return np.floor(values / COARSE + 0.37)


def _mates(*held: Held | None) -> set[str]:
    return {mate for each in held if each is not None for mate in each.mates}


def _finite(value: float) -> float:
    return float(value) if math.isfinite(value) else -1.0


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]
