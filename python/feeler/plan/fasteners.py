"""`find_fasteners`: bolts, screws, nuts and studs of a mock-up, by geometry and, second, by name."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import (
    RowsLike,
    check_kind,
    check_length,
    check_list,
    check_progress,
    check_text,
    check_word,
    rows_at,
)
from feeler.choices import FASTENER_KINDS, FastenerKind
from feeler.errors import MeshError
from feeler.field_docs import documented
from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.parts import PartsLike
from feeler.plan.fastener_names import is_by_hand, kind_said, may_be_pin, name_of, says_nothing
from feeler.plan.fastener_shape import Looks, bore_of, is_long, is_plain, is_round_nut, looks_of, needs_thread, rod_of
from feeler.plan.same_shapes import SameShape, same_shapes
from feeler.plan.wound import wound
from feeler.progress import Progress
from feeler.rows import read_only
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

KINDS = FASTENER_KINDS

LARGEST_M = 0.6
"""The longest side of the box of examined parts: longer bolts are rare, and large parts cost time."""
ROD_WIDTH_M = 0.25
"""How wide the box of a longer part may be that is named as a fastener: threaded rods, also turned ones."""
MOST_TRIANGLES = 100_000
"""The most triangles of examined parts; a bolt with a finely meshed thread has some ten thousand."""

STRONG, WEAK = 0.9, 0.5
"""Confidence in an unambiguous shape, and in an ambiguous one."""
AGREED = 0.99
"""Confidence if the name agrees."""
NAMED = 0.6
"""Confidence if the name says so and the shape is only about as wide both ways."""
DOUBTED = 0.3
"""Factor of the confidence if the name says that it is another thing, and for a weak shape without such a name among
parts that are named as fasteners."""
LEAST_CONFIDENCE = 0.5
"""Results have at least this confidence."""

ROD_TO_BORE = (0.85, 1.25)
"""Diameter of a stud, relative to the bore of its nut: threads are drawn with the core's diameter, the nominal one, or
both."""
ROD_FULL = 0.6
"""The least share of its cylinder that a stud fills: tubes fill less."""
ROD_SLENDER = 1.5
"""The least length of a stud in a nut, in diameters."""

THREAD_PLAY = 1.014
"""The diameter of a nut's bore, relative to the thread in it, at most; clearance holes are wider."""

_IN_BORE = 24  # rays into a bore
_WALL = 0.98  # where they begin at most, in halves of the width across flats
_FILLED = 0.8  # the share of them that meets the thread
_FACETS = 0.93  # how near to the axis the facets of a thread come, relative to the bore
_SET_IN = 0.2  # radii outwards, from 0.9 of them, where what an insert is in is sought
_NEAR_END = 0.12  # heights from the ends of a long nut, where its rods are sought
_BEYOND = 1e-3  # heights of a nut that a stud goes beyond its middle
_AROUND = 12  # rays from each end, around the axis
_RAY_BEGIN = 1e-3  # their distance from the end, as a share of the height
_FAR = 5.0  # heights beyond which a hit need not be the joint
_INSIDE = 0.15  # weight of the room at an end that is inside something
_BESIDE = 0.3  # heights from each end, where the nearest part is then sought
_NEARER = 0.88  # for a clear answer: the nearest distance of one end, relative to that of the other
_POINT = np.array([[0.0, 0.0, 0.0], [1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0]])  # a tool as small as a point, metres


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Fastener:
    """One fastener, as recognised. Metres; NaN if the mesh does not show a value."""

    part: int
    """Index into `mockup.parts`."""
    path: str
    """Its path."""
    kind: FastenerKind
    """"bolt" (hexagon head), "screw" (round head, or a socket without one), "nut" or "stud"."""
    frame: Floats
    """`(4, 4)` world_from_fastener: the origin in the middle of the top of head or nut; z along the axis out of the
    joint, towards the tool; x perpendicular to the world axis least aligned with z."""
    size: float
    """Diameter of the thread as modelled; for a nut its bore."""
    across_flats: float
    """Width across flats: of the hexagon, or of the socket."""
    length: float
    """From the bearing surface of the head to the tip; for a nut its height."""
    head_height: float
    """From the bearing surface of the head to its top, metres; NaN without a head."""
    confidence: float
    """0 to 1: an order, not a probability. `because` explains it."""
    because: str
    drive: str = ""
    """The drive of the tool: "hexagon", "square", "12-point", "torx", "wings" or "hand" (a knurled head, a crossbar) on
    the outside; "hexagon socket", "square socket", "12-point socket", "torx socket", "slot" or "cross" inside; empty if
    the mesh does not show it."""
    width: float = np.nan
    """The width by which its tool is chosen: across flats; across the points of a Torx; of a slot, and of the slots of
    a cross. NaN for other drives."""

    @property
    def axis(self) -> Floats:
        """`(3,)`, unit, out of the joint."""
        return self.frame[:3, 2]


class Fasteners(Sequence[Fastener]):
    """The results of `find_fasteners`, sorted by part."""

    def __init__(self, rows: Iterable[Fastener]) -> None:
        found = check_list("rows", rows, "a list of feeler.Fastener")
        self._rows = tuple(check_kind("rows", row, Fastener, "a list of feeler.Fastener") for row in found)

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Fastener: ...
    @overload
    def __getitem__(self, index: RowsLike) -> Fasteners: ...
    def __getitem__(self, index: int | RowsLike) -> Fastener | Fasteners:
        at = rows_at(index, len(self))
        return self._rows[at] if isinstance(at, int) else Fasteners([self._rows[each] for each in at])

    def __iter__(self) -> Iterator[Fastener]:
        return iter(self._rows)

    @property
    def parts(self) -> npt.NDArray[np.int64]:
        """`(n,)`: indices into `mockup.parts`."""
        return read_only(np.array([row.part for row in self._rows], dtype=np.int64))

    @property
    def frames(self) -> Floats:
        """`(n, 4, 4)`: world_from_fastener, metres; see `Fastener.frame`."""
        return read_only(np.array([row.frame for row in self._rows]).reshape(-1, 4, 4))

    @property
    def axes(self) -> Floats:
        """`(n, 3)`, unit, out of the joint."""
        return self.frames[:, :3, 2]

    def where(
        self,
        pattern: str | None = None,
        *,
        kind: FastenerKind | None = None,
        across_flats: float | tuple[float, float] | None = None,
    ) -> Fasteners:
        """The fasteners of a kind and of a width across flats whose path, or its last step, matches a pattern
        (`*bolt*`).

        `across_flats`: metres, within 3 %; or from, to. Raises `OptionError` for an unknown kind.
        """
        if kind is not None:
            check_word("kind", kind, KINDS)
        if pattern is not None:
            check_text("pattern", pattern, "a pattern of paths, such as *bolt*")
        low, high = -np.inf, np.inf
        if isinstance(across_flats, tuple) and len(across_flats) == 2:
            low, high = (check_length("across_flats", each) for each in across_flats)
        elif across_flats is not None:
            width = check_length("across_flats", across_flats, ", or a pair of these")
            low, high = 0.97 * width, 1.03 * width
        return Fasteners(
            row
            for row in self._rows
            if (kind is None or row.kind == kind)
            and (across_flats is None or low <= row.across_flats <= high)
            and (pattern is None or any(fnmatch.fnmatchcase(n, pattern) for n in (row.path, row.path.split("/")[-1])))
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Fasteners) or len(self) != len(other):
            return NotImplemented if not isinstance(other, Fasteners) else False
        return all(_key(a) == _key(b) for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]  # it holds arrays

    def __repr__(self) -> str:
        counts = [(sum(row.kind == kind for row in self._rows), kind) for kind in KINDS]
        said = ", ".join(f"{count:,} {kind}{'' if count == 1 else 's'}" for count, kind in counts if count)
        return f"Fasteners({said or 'none'})"


def _key(row: Fastener) -> tuple[Any, ...]:
    numbers = [row.size, row.across_flats, row.width, row.length, row.head_height, row.confidence]
    return (row.part, row.path, row.kind, row.drive, row.because, row.frame.tobytes(), np.array(numbers).tobytes())


def find_fasteners(
    mockup: Mockup | Scene, parts: PartsLike | None = None, progress: Progress | None = None
) -> Fasteners:
    """Recognises the bolts, screws, nuts and studs of a mock-up, with the place of their heads and their size.

    The walls of a part decide: a hexagon on a shank, a hexagon socket in a round head, a hexagon with a bore. A name
    that agrees raises the confidence; if the mesh is too coarse, the name decides. The surroundings of both ends show
    which end of a nut, or of a head without a shank, is outside. Parts of one shape are examined once. Results are
    estimates.

    `mockup`: also a `Scene`, of which only the present parts are examined. `parts`: only these, as `Parts.select` takes
    them. A part is at most one fastener: several in one part, and fasteners made of several parts, are not found.
    Raises `OptionError` for parts that do not exist.
    """
    if not isinstance(mockup, (Mockup, Scene)):
        raise MeshError(f"fasteners are of a feeler.Mockup or a feeler.Scene, not of {type(mockup).__name__}")
    check_progress(progress)
    world = mockup.mockup if isinstance(mockup, Scene) else mockup
    named = np.arange(world.part_count) if parts is None else world.parts.select(parts)
    chosen = named.astype(np.int64)
    if isinstance(mockup, Scene):
        chosen = chosen[mockup.part_mask[chosen]]
    found = _looked_at(world, chosen, progress)
    scene = mockup if isinstance(mockup, Scene) else None
    if any(row.confidence < LEAST_CONFIDENCE for row, _ in found):
        scene = scene or Scene(world)
        found = list(_sure(scene, found))
    unsure = [i for i, (_, looks) in enumerate(found) if looks.is_two_sided]
    rows = [row for row, _ in found]
    if unsure:
        if progress is not None:
            progress(0.8, "looking which end is outside")
        scene = scene or Scene(world)
        mask = scene.part_mask.copy()
        mask[[row.part for row in rows if row.kind == "nut"]] = False  # nuts on one axis lock each other
        for i, row in zip(unsure, _turned_out(scene.only(mask), [found[i] for i in unsure]), strict=True):
            rows[i] = row
    rows += _studs(world, chosen, rows)
    if progress is not None:
        progress(1.0, "done")
    return Fasteners(sorted(rows, key=lambda row: row.part))


def shaped_as_fasteners(mockup: Mockup) -> npt.NDArray[np.int64]:
    """The parts recognised as fasteners, by shape and name, with a confidence of at least `STRONG`.

    The same parts as in `find_fasteners(mockup)`, without their frames, which need an index.
    """
    found = _looked_at(mockup, np.arange(mockup.part_count), None)
    return np.array(sorted(row.part for row, _ in found if row.confidence >= STRONG), dtype=np.int64)


def sized_as_fasteners(mockup: Mockup) -> npt.NDArray[np.bool_]:
    """The parts that are not too large for a fastener, `(parts,)`; rods may be longer than `LARGEST_M`."""
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    sides = np.sort(bounds[:, 1] - bounds[:, 0], axis=1)
    return np.asarray((sides[:, 2] <= LARGEST_M) | (sides[:, 1] <= ROD_WIDTH_M))


def _looked_at(world: Mockup, chosen: npt.NDArray[np.int64], progress: Progress | None) -> list[tuple[Fastener, Looks]]:
    """The fasteners among the parts, each with its looks; which of two equal ends is outside is still open. Of less
    than `LEAST_CONFIDENCE` are nuts that only a thread in their bore shows."""
    names = [name_of(world, part) for part in range(world.part_count)]
    said = [kind_said(name) for name in names]
    is_naming = any(kind in KINDS for kind in said)
    small = _small(world, chosen)
    found: list[tuple[Fastener, Looks]] = []
    done = 0
    for shape in same_shapes(world, small):
        found += _of_shape(world, shape, names, said, is_naming)
        done += len(shape.parts)
        if progress is not None:
            progress(0.8 * done / len(small), "looking at parts")
    return found


def _sure(scene: Scene, found: list[tuple[Fastener, Looks]]) -> Iterator[tuple[Fastener, Looks]]:
    """Those of sufficient confidence, and the others in whose bore threads are: something round, as wide as it; in a
    long nut two rods, as bolts are in the ends of a spacer."""
    bolts = [row.part for row, _ in found if row.confidence >= LEAST_CONFIDENCE and row.kind != "nut"]
    for row, looks in found:
        if row.confidence >= LEAST_CONFIDENCE:
            yield row, looks
        elif is_long(looks):
            ends = [_thread_in(scene, row, share) for share in (_NEAR_END, 1.0 - _NEAR_END)]
            if None not in ends and ends[0] != ends[1] and not set(ends) & set(bolts):
                yield replace(row, confidence=WEAK, because=f"{row.because}; two rods as wide are in it"), looks
        elif _thread_in(scene, row, 0.5) is not None and not (is_round_nut(looks) and _is_set_in(scene, row, looks)):
            yield replace(row, confidence=WEAK, because=f"{row.because}; a thread as wide is in it"), looks


def _thread_in(scene: Scene, nut: Fastener, share: float) -> int | None:
    """The part that is round and fills the bore of a nut at a share of its height; None if none does. Rays begin in its
    wall."""
    begin = ROD_TO_BORE[1] * 0.5 * nut.size
    if nut.across_flats == nut.across_flats:
        begin = min(_WALL * 0.5 * nut.across_flats, begin)
    ways = _ways_across(nut)
    hits = _others(scene, nut).rays(_middle(nut, share) + begin * ways, -ways, within=begin)
    parts, radii = np.asarray(hits.parts), begin - np.asarray(hits.distances)
    best = int(np.bincount(np.maximum(parts, 0)).argmax())
    is_own = (np.asarray(hits.triangles) >= 0) & (parts == best)
    is_round = (is_own & (radii >= _FACETS * 0.5 * nut.size)).mean() >= _FILLED
    return best if is_round and THREAD_PLAY * radii[is_own].max() >= 0.5 * nut.size else None


def _is_set_in(scene: Scene, nut: Fastener, looks: Looks) -> bool:
    """Whether a round body is around most of its outside in another part, as threaded inserts are."""
    wide = 2.0 * looks.ring - 0.5 * nut.size
    ways = _ways_across(nut)
    hits = _others(scene, nut).rays(_middle(nut, 0.5) + 0.9 * wide * ways, ways, within=_SET_IN * wide)
    return bool((np.asarray(hits.triangles) >= 0).mean() >= 0.5)


def _ways_across(nut: Fastener) -> Floats:
    """Directions around the axis of a nut."""
    turn = np.arange(_IN_BORE) * (2.0 * np.pi / _IN_BORE)
    return np.asarray(np.stack([np.cos(turn), np.sin(turn), np.zeros(_IN_BORE)], axis=1) @ nut.frame[:3, :3].T)


def _middle(nut: Fastener, share: float) -> Floats:
    """A point on the axis of a nut at a share of its height."""
    return nut.frame[:3, 3] - share * nut.length * nut.axis


def _others(scene: Scene, nut: Fastener) -> Scene:
    """A scene without a nut."""
    mask = scene.part_mask.copy()
    mask[nut.part] = False
    return scene.only(mask)


def _studs(world: Mockup, chosen: npt.NDArray[np.int64], rows: list[Fastener]) -> list[Fastener]:
    """Studs among the parts: rods, which alone look like pins, in the bore of a recognised nut."""
    nuts = [row for row in rows if row.kind == "nut" and row.size > 0.0]
    if not nuts:
        return []
    taken = {row.part for row in rows}
    rest = np.array([part for part in _small(world, chosen).tolist() if part not in taken], dtype=np.int64)
    bounds = world.part_bounds.reshape(-1, 2, 3)[rest]
    meshes = PartMeshes(world)
    found: dict[int, Fastener] = {}
    for nut in nuts:
        middle = nut.frame[:3, 3] - 0.5 * nut.length * nut.axis
        for part in rest[((bounds[:, 0] <= middle) & (middle <= bounds[:, 1])).all(axis=1)].tolist():
            if part in found or kind_said(name_of(world, part)) == "other":
                continue
            vertices, faces = meshes.mesh(part)
            local = (vertices - nut.frame[:3, 3]) @ nut.frame[:3, :3]
            size = 2.0 * float(np.hypot(local[:, 0], local[:, 1]).max())
            low, high = float(local[:, 2].min()), float(local[:, 2].max())
            if not low + _BEYOND * nut.length < -0.5 * nut.length < high - _BEYOND * nut.length:
                continue  # only its box, which depends on the pose, has the middle; or two rods meet there
            corners = local[faces]
            volume = abs(float(np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))) / 6.0
            is_rod = volume > ROD_FULL * 0.25 * np.pi * size**2 * (high - low)
            if not (is_rod and ROD_TO_BORE[0] <= size / nut.size <= ROD_TO_BORE[1] and high - low > ROD_SLENDER * size):
                continue
            frame = nut.frame.copy()
            frame[:3, 3] += high * nut.axis
            found[part] = Fastener(
                part=part,
                path=world.part_paths[part],
                kind="stud",
                frame=frame,
                size=size,
                across_flats=np.nan,
                length=high - low,
                head_height=np.nan,
                confidence=STRONG,
                because=f"a rod of {1e3 * size:.3g} mm in the bore of {nut.path}",
            )
    return list(found.values())


def _small(world: Mockup, chosen: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The parts small enough for fasteners."""
    bounds = world.part_bounds.reshape(-1, 2, 3)[chosen]
    sides = bounds[:, 1] - bounds[:, 0]
    triangles = world.part_triangles[chosen]
    is_small = (sides.max(axis=1) <= LARGEST_M) & (sides.min(axis=1) > 0) & (triangles <= MOST_TRIANGLES)
    return np.asarray(chosen[is_small & (triangles >= 8)], dtype=np.int64)


def _of_shape(
    world: Mockup, shape: SameShape, called: list[str], said: list[str | None], is_naming: bool
) -> list[tuple[Fastener, Looks]]:
    """The fasteners among the parts of one shape, as `_looked_at`."""
    faces = wound(shape.vertices, shape.faces)
    looks = looks_of(shape.vertices, faces)
    names = [said[part] for part in shape.parts]
    rod = rod_of(shape.vertices, faces) if looks is None and any(kind in KINDS for kind in names) else None
    bore = bore_of(shape.vertices, faces, rod) if rod is not None and "nut" in names else None
    is_pin = rod is not None and is_plain(shape.vertices, faces, rod)
    found = []
    for part, place, name in zip(shape.parts.tolist(), shape.places, names, strict=True):
        seen = looks or (rod if name in KINDS and not (is_pin and may_be_pin(called[part])) else None)
        if seen is None:
            continue
        confidence = _confidence(seen, name, is_naming and not says_nothing(called[part]))
        if confidence < LEAST_CONFIDENCE and (name == "other" or not needs_thread(seen)):
            continue
        kind = _kind(seen, name)
        wide = bore if bore is not None and kind == "nut" else None
        if wide is not None:
            seen = replace(seen, ring=0.25 * (wide + seen.size))  # in its bore rays only meet the thread
        voice = "; its name says another thing" if name == "other" else f"; its name says {name}" if name else ""
        row = Fastener(
            part=part,
            path=world.part_paths[part],
            kind=kind,
            frame=framed(place[:3, :3] @ seen.top + place[:3, 3], place[:3, :3] @ seen.axis),
            size=seen.size if wide is None else wide,
            across_flats=seen.across_flats,
            length=seen.length,
            head_height=seen.head_height,
            confidence=confidence,
            because=seen.because + voice,
            drive=seen.drive or ("hand" if kind == "screw" and is_by_hand(called[part]) else ""),
            width=seen.across_flats if np.isnan(seen.width) else seen.width,
        )
        found.append((row, seen))
    return found


def _confidence(looks: Looks, name: str | None, is_telling: bool) -> float:
    if name in KINDS or (name == "plug" and looks.kind != "nut"):
        return NAMED if looks.kind == "rod" else AGREED
    if name == "other" or looks.is_known_by_name:
        return DOUBTED
    if looks.is_strong:
        return STRONG
    return DOUBTED if is_telling or name == "plug" else WEAK


def _kind(looks: Looks, name: str | None) -> FastenerKind:
    """A strong shape decides, except for studs; for other shapes the name does, if it says so."""
    if name == "stud" and looks.kind != "nut":
        return "stud"
    if looks.kind == "head":
        return "screw" if name == "screw" else "bolt"
    said = looks.kind if looks.is_strong or name not in KINDS else name
    return check_word("kind", "bolt" if said == "prism" else said, KINDS)


def framed(origin: Floats, axis: Floats) -> Floats:
    """A frame with z along an axis; x is perpendicular to the coordinate axis least aligned with it, the first of those
    that are by rounding."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.round(np.abs(axis), 6)))])
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(axis, x), axis, origin
    return frame


def turned_round(row: Fastener, height: float) -> Fastener:
    """A fastener of a height with its frame at its other end."""
    frame = row.frame @ np.diag([1.0, -1.0, -1.0, 1.0])
    frame[:3, 3] -= height * row.axis
    return replace(row, frame=frame)


def _turned_out(scene: Scene, found: list[tuple[Fastener, Looks]]) -> list[Fastener]:
    """Moves frames to the outer end, found by rays from both ends, around the axis.

    The end with less room before it is the joint's; room inside another body counts for less. If rays of both ends hit
    only far away, the joint's end is the one nearer to any part.
    """
    turn = np.arange(_AROUND) * (2.0 * np.pi / _AROUND)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros(_AROUND), np.ones(_AROUND)], axis=1)
    origins, directions = [], []
    for row, looks in found:
        ring = (circle * [looks.ring, looks.ring, 0.0, 1.0]) @ row.frame.T
        begin = _RAY_BEGIN * looks.height
        for z, way in ((begin, 1.0), (-looks.height - begin, -1.0)):
            origins.append(ring[:, :3] + z * row.axis)
            directions.append(np.broadcast_to(way * row.axis, (_AROUND, 3)))
    ways = np.concatenate(directions)
    rays = scene.rays(np.concatenate(origins), ways)
    room = np.median(rays.distances.reshape(-1, 2, _AROUND), axis=2)
    is_inside = _from_inside(scene.mockup, rays.triangles, ways).reshape(-1, 2, _AROUND).mean(axis=2) > 0.5
    room[is_inside] *= _INSIDE
    rows = []
    for (row, looks), (above, below), inside in zip(found, room.tolist(), is_inside.tolist(), strict=True):
        is_turned = below > above
        if not any(inside) and _FAR * looks.height < min(above, below) and max(above, below) < np.inf:
            is_turned = _nearer_end(scene, row, looks, is_turned)
        if is_turned:
            row = turned_round(row, looks.height)
        rows.append(row)
    return rows


def _nearer_end(scene: Scene, row: Fastener, looks: Looks, unless: bool) -> bool:
    """Whether the end at the frame is clearly nearer to other parts than the other end; `unless` if neither is."""
    point = Tool(_POINT, [[0, 1, 2]], name="point")
    near = []
    for z in (_BESIDE, -1.0 - _BESIDE):
        pose = np.eye(4)
        pose[:3, 3] = row.frame[:3, 3] + z * looks.height * row.axis
        near.append(scene.distance(point, pose, ignore=[("point", row.part)]).value)
    return near[0] < near[1] if min(near) < _NEARER * max(near) else unless


def _from_inside(world: Mockup, triangles: npt.NDArray[np.int64], ways: Floats) -> npt.NDArray[np.bool_]:
    """Whether rays along `ways` hit the triangles (-1: none) from behind, by their winding."""
    corners = world.vertices[world.faces[np.maximum(triangles, 0)]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray((triangles >= 0) & (np.einsum("ij,ij->i", normals, ways) > 0))
