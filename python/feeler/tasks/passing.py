"""What lies around the axes of fasteners: the parts that shanks pass through, and what is in the bores of nuts."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler._core import Rays
from feeler.part_meshes import PartMeshes
from feeler.plan.fasteners import Fastener
from feeler.scene import Scene
from feeler.tasks.thread_sizes import thread_size

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
_Level = tuple[float, float, float]
"""A height, and the greatest and least distance of a part from the axis there."""

_AROUND = 12  # rays around the axis
LEVELS = 32  # heights along it
_LAYERS = 24  # the most layers that are entered or left below a head
_BESIDE = (0.6, 0.68)  # distances from the axis, in diameters, where layers are looked for: beside holes, under heads
_WIDE = 0.77  # the same for thin layers alone: of a shank drawn as wide as its core, holes are this wide
_REACH = 0.8  # in diameters: holes are narrower
_MOST = 0.58  # the share of rays that hit a part around the axis; two walls that meet in a corner beside it are half
_BATCH = 1_000  # fasteners at a time
_TIP = 0.95  # of the length of a shank: what is met beyond is not passed
_ABOVE = 1e-3  # of the length of a shank: rays along it begin above its top
_THIN = 0.01  # of the length of a shank
_NARROW, _FEW = 0.2, 5  # a share of the heights of a hole, and the least number of them
_STEP = 1e-7  # metres beyond a hit, where the next ray begins
_BORE = (0.62, 0.48)  # where rays into a nut begin: in bores, in widths across flats
_FINE, _MOST_LEVELS = 0.05, 400  # how far levels of a thread beyond its nut are from each other, in its radii
_OUTSIDE, _CREST, _ROOT = 1.1, 0.8, 0.7  # where rays at it begin, and its least radii, in those in its nut
SEAT = 0.02
"""A head bears on what is this near, in diameters; one that is no higher is a cone, which bears in its hole."""
_SEATED = 36  # rays around its axis
_SEAT_SHARES = (0.1, 0.35, 0.6, 0.8, 0.95)  # where they begin, between the shank and the edge of the head
_SEAT_LEAST = 0.08  # the share of them that hit a part


@dataclass(frozen=True)
class Passed:
    """A part around or in the axis of a fastener."""

    part: int
    top: float
    """Where it begins and ends along the axis, in the fastener's frame, metres; `top` is nearer to the head."""
    bottom: float
    radius: float
    """The largest distance of its surface from the axis there, metres, where the hole is narrow; 0: it is drawn without
    a hole."""
    least: float = 0.0
    """The least such distance."""


def passed_by(scene: Scene, rows: Sequence[Fastener]) -> Iterator[list[Passed]]:
    """The parts that each shank passes through, the one nearest to the head first; a fork once for each leg.

    scene: without the fasteners.
    """
    for begin in range(0, len(rows), _BATCH):
        yield from _passed(scene, rows[begin : begin + _BATCH])


def _span(row: Fastener) -> tuple[float, float]:
    """Top and bottom of the shank, in its frame."""
    head = row.head_height if np.isfinite(row.head_height) else 0.0
    length = row.length if np.isfinite(row.length) else 0.0
    return -head, -head - length


def _passed(scene: Scene, rows: Sequence[Fastener]) -> list[list[Passed]]:
    spans = np.array([_span(row) for row in rows]).reshape(-1, 2)
    sizes = np.array([thread_size(row) if np.isfinite(row.size) else 0.0 for row in rows])
    frames = np.array([row.frame for row in rows]).reshape(-1, 4, 4)
    levels = spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * ((np.arange(LEVELS) + 0.5) / LEVELS)
    levels = np.concatenate([levels, _layers(scene, frames, spans, sizes)], axis=1)
    levels = -np.sort(-levels, axis=1)
    count = levels.shape[1]
    ring = _ring()
    ways = np.einsum("nij,aj->nai", frames[:, :3, :3], ring)[:, None].repeat(count, axis=1)
    origins = frames[:, None, :3, 3] + levels[:, :, None] * frames[:, None, :3, 2]
    hits = scene.rays(
        origins[:, :, None].repeat(_AROUND, axis=2).reshape(-1, 3),
        ways.reshape(-1, 3),
        within=float(_REACH * sizes.max(initial=0.0)),
    )
    parts, far = _flat(hits, (len(rows), count, _AROUND))
    parts[far > _REACH * sizes[:, None, None]] = -1
    # Unused layers are at the top: in the plane of a flush face, rays may hit its edges.
    is_in = levels < spans[:, :1]
    found = [_around(parts[n, is_in[n]], far[n, is_in[n]], levels[n, is_in[n]]) for n in range(len(rows))]
    for n, more in enumerate(_solid(scene, frames, spans)):
        # Near to one height alone, rays may be in the face of a part without a hole.
        solid, thin = {each.part for each in more}, _THIN * float(spans[n, 0] - spans[n, 1])
        found[n] = [each for each in found[n] if each.top - each.bottom > thin or each.part not in solid]
        known = {each.part for each in found[n]}
        found[n] += [each for each in more if each.part not in known]
        found[n].sort(key=lambda each: -each.top)
    return found


def _ring(count: int = _AROUND) -> Floats:
    turn = (np.arange(count) + 0.37) * (2.0 * np.pi / count)
    return np.stack([np.cos(turn), np.sin(turn), np.zeros(count)], axis=1)


def around(frame: Floats, count: int = _AROUND) -> Floats:
    """Directions (count, 3) around the axis of a frame."""
    return np.asarray(_ring(count) @ frame[:3, :3].T)


def _flat(hits: Rays, shape: tuple[int, ...]) -> tuple[Ints, Floats]:
    return np.asarray(hits.parts, dtype=np.int64).reshape(shape).copy(), np.asarray(hits.distances).reshape(shape)


def _around(parts: Ints, far: Floats, levels: Floats) -> list[Passed]:
    """The parts that at least half of the rays of a level hit, the topmost first; those that another part divides more
    than once. parts, far: (levels, rays)."""
    seen: dict[int, list[_Level]] = {}
    # Of each ray, how many of its level hit the same part.
    counts = ((parts[:, :, None] == parts[:, None]) & (parts >= 0)[:, :, None]).sum(axis=2)
    most = counts.max(axis=1, initial=0)
    # Of two that are hit by as many, the first.
    best = np.where(counts == most[:, None], parts, np.iinfo(np.int64).max).min(axis=1, initial=np.iinfo(np.int64).max)
    is_own = parts == best[:, None]
    largest = np.where(is_own, far, -np.inf).max(axis=1, initial=-np.inf).tolist()
    least = np.where(is_own, far, np.inf).min(axis=1, initial=np.inf).tolist()
    for n in np.flatnonzero((most > 0) & (most >= _MOST * parts.shape[1])).tolist():
        seen.setdefault(int(best[n]), []).append((float(levels[n]), largest[n], least[n]))
    ends = {part: (rows[0][0], rows[-1][0]) for part, rows in seen.items()}
    found = []
    for part, rows in seen.items():
        for run in _runs(rows, [span for other, span in ends.items() if other != part]):
            heights, widest, nearest = zip(*run, strict=True)
            found.append(Passed(part, heights[0], heights[-1], _narrow(widest), float(np.median(nearest))))
    return sorted(found, key=lambda each: -each.top)


def _narrow(radii: Sequence[float]) -> float:
    """The radius of the narrower part of a hole: its thread may be behind a wider part."""
    return sorted(radii)[int(_NARROW * len(radii))] if len(radii) >= _FEW else float(np.median(radii))


def _runs(rows: list[_Level], others: list[tuple[float, float]]) -> list[list[_Level]]:
    """The levels of a part, divided where another part is between two of them as a whole: the legs of a fork."""
    runs = [rows[:1]]
    for above, row in itertools.pairwise(rows):
        if any(above[0] > top and bottom > row[0] for top, bottom in others):
            runs.append([])
        runs[-1].append(row)
    return runs


def _layers(scene: Scene, frames: Floats, spans: Floats, sizes: Floats) -> Floats:
    """Heights in the middle of the layers beside each shank, for thin ones, (n, k). Unused ones are the shank's top."""
    ring = _ring()[:: _AROUND // 4]
    columns = []
    for beside in (*_BESIDE, _WIDE):
        for way in ring:
            at = np.einsum("nij,j->ni", frames[:, :3, :3], way) * (beside * sizes)[:, None]
            origins = frames[:, :3, 3] + at + spans[:, :1] * frames[:, :3, 2]
            ends = through(scene, origins, -frames[:, :3, 2], spans[:, 0] - spans[:, 1])[0]
            # Whether a ray meets the face that it begins in is a matter of rounding.
            ends = np.concatenate([np.zeros((len(ends), 1)), ends], axis=1)
            middle = spans[:, :1] - 0.5 * (ends[:, 1:] + ends[:, :-1])
            is_layer = np.isfinite(middle) & (middle < spans[:, :1] - _STEP)
            if beside == _WIDE:
                is_layer &= ends[:, 1:] < ends[:, :-1] + (spans[:, :1] - spans[:, 1:]) / LEVELS
            columns.append(np.where(is_layer, middle, spans[:, :1]))
    return np.concatenate(columns, axis=1)


def through(scene: Scene, origins: Floats, ways: Floats, lengths: Floats) -> tuple[Floats, Ints, npt.NDArray[np.bool_]]:
    """All that rays meet up to their lengths: distances, parts and whether they enter them, (n, `_LAYERS`); infinite
    and -1 beyond the last."""
    far = np.full((len(origins), _LAYERS), np.inf)
    parts = np.full((len(origins), _LAYERS), -1, dtype=np.int64)
    enters = np.zeros((len(origins), _LAYERS), dtype=bool)
    gone = np.zeros(len(origins))
    left = np.arange(len(origins))
    for n in range(_LAYERS):
        if not len(left):
            break
        hits = scene.rays(
            origins[left] + gone[left, None] * ways[left], ways[left], within=float(lengths.max(initial=0.0))
        )
        gone[left] += np.asarray(hits.distances)
        is_hit = (np.asarray(hits.triangles) >= 0) & (gone[left] <= lengths[left])
        left, owners = left[is_hit], np.asarray(hits.parts, dtype=np.int64)[is_hit]
        far[left, n], parts[left, n] = gone[left], owners
        enters[left, n] = is_against(scene, np.asarray(hits.triangles)[is_hit], ways[left])
        gone[left] += _STEP
    return far, parts, enters


def is_against(scene: Scene, triangles: Ints, ways: Floats) -> npt.NDArray[np.bool_]:
    """Whether the normals of triangles are against some directions."""
    corners = scene.mockup.vertices[scene.mockup.faces[triangles]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.einsum("ij,ij->i", normals, ways) < 0.0)


class Windings:
    """Looks at single parts along shanks."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self._meshes = scene, PartMeshes(scene.mockup)
        self._turned: dict[int, bool] = {}

    def is_inside_out(self, part: int) -> bool:
        """Whether the triangles of a part face inwards."""
        if part not in self._turned:
            vertices, faces = self._meshes.mesh(part)
            corners = (vertices - vertices.mean(axis=0))[faces]
            volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
            self._turned[part] = bool(volume < 0.0)
        return self._turned[part]

    def begin(self, part: int, origin: Floats, way: Floats, within: float) -> float:
        """How far from a point a part begins along a ray, metres; 0 if the point is in it.

        Where faces are flush, rays that go on behind each hit see one part alone.
        """
        hits = self.scene.only([part]).rays(origin[None], way[None], within=within)
        if int(np.asarray(hits.triangles)[0]) < 0:
            return 0.0
        enters = bool(is_against(self.scene, np.asarray(hits.triangles), way[None])[0])
        return float(np.asarray(hits.distances)[0]) if enters != self.is_inside_out(part) else 0.0


def _solid(scene: Scene, frames: Floats, spans: Floats) -> list[list[Passed]]:
    """The parts whose material is in the axis: drawn without a hole, or plates that the shank crosses."""
    lengths = spans[:, 0] - spans[:, 1]
    above = _ABOVE * lengths  # the end of the shank may be in the face of a part
    origins = frames[:, :3, 3] + (spans[:, :1] + above[:, None]) * frames[:, :3, 2]
    far, parts, enters = through(scene, origins, -frames[:, :3, 2], lengths + above)
    found: list[list[Passed]] = []
    windings = Windings(scene)
    for n in range(len(frames)):
        own: dict[int, list[tuple[float, bool]]] = {}
        for distance, part, is_entry in zip((far[n] - above[n]).tolist(), parts[n], enters[n].tolist(), strict=True):
            if part >= 0:
                own.setdefault(int(part), []).append((distance, is_entry))
        # What is met at the tip alone is the bottom of a blind hole, or a part that the tip touches.
        top, tip = spans[n, 0], _TIP * lengths[n]
        found.append([])
        for part, at in own.items():
            (first, begins), (last, goes_on) = at[0], at[-1]
            is_turned = windings.is_inside_out(part)
            # What ends at the top lies on a head that is flush, as a cone in its hole is.
            if first >= tip or (begins == goes_on == is_turned and last <= above[n]):
                continue
            down = -frames[n, :3, 2]
            if begins == is_turned:
                first = max(windings.begin(part, origins[n], down, first + above[n]) - above[n], 0.0)
            if goes_on != is_turned:
                foot = origins[n] + (above[n] + lengths[n]) * down
                last = lengths[n] - windings.begin(part, foot, -down, lengths[n] - last)
            found[-1].append(Passed(part, top - max(first, 0.0), top - last, 0.0))
    return found


def in_bore(scene: Scene, nut: Fastener, meshes: PartMeshes) -> list[Passed]:
    """The outermost parts in the bore of a nut, the one nearest to its top first.

    scene: without the fasteners; meshes: of all parts of its mock-up.
    """
    if not (np.isfinite(nut.size) and np.isfinite(nut.length) and nut.size > 0.0):
        return []
    levels = -nut.length * (np.arange(LEVELS) + 0.5) / LEVELS
    ways = _ring() @ nut.frame[:3, :3].T
    middles = nut.frame[:3, 3] + levels[:, None] * nut.axis
    begin = _beside_bore(meshes, nut, levels)[:, None]
    origins = middles[:, None] + begin[:, :, None] * ways
    within = float(begin.max())
    directions = np.broadcast_to(-ways, (LEVELS, _AROUND, 3)).reshape(-1, 3)
    parts, far = _flat(scene.rays(origins.reshape(-1, 3), directions, within=within), (LEVELS, _AROUND))
    parts[far > begin] = -1  # beyond the axis
    return _around(parts, begin - far, levels)


def standing_out(alone: Scene, nut: Fastener, radius: float, far: float) -> float:
    """How far a thread goes on above the top of its nut, metres, by rays towards its axis.

    alone: the part with the thread; radius: that of the thread, metres; far: how far above the nut the part ends.
    """
    if not (radius > 0.0 and far > 0.0 and np.isfinite(far)):
        return 0.0
    count = int(np.clip(np.ceil(far / (_FINE * radius)), LEVELS, _MOST_LEVELS))
    step = far / count
    heights = step * (np.arange(count) + 0.5)
    ways = _ring() @ nut.frame[:3, :3].T
    middles = nut.frame[:3, 3] + heights[:, None] * nut.axis
    begin = _OUTSIDE * radius
    directions = np.broadcast_to(-ways, (count, _AROUND, 3)).reshape(-1, 3)
    hits = alone.rays((middles[:, None] + begin * ways).reshape(-1, 3), directions, within=begin)
    wide = np.where(np.asarray(hits.triangles) >= 0, begin - np.asarray(hits.distances), 0.0).reshape(count, _AROUND)
    # The crests of a thread that is drawn as a helix are as wide as a plain one.
    is_on = (wide.max(axis=1) >= _CREST * radius) & ((wide >= _ROOT * radius).sum(axis=1) >= _MOST * _AROUND)
    return step * (count if is_on.all() else int(np.argmin(is_on)))


def _beside_bore(meshes: PartMeshes, nut: Fastener, levels: Floats) -> Floats:
    """How far from the axis rays into a nut begin at each height, metres: in its wall, outside of a thread that is
    drawn wider than the bore.

    Nuts that are no hexagons have no width across flats, and a bore that may be wider at some heights: there it is
    where the edges of the mesh are nearest to the axis.
    """
    if np.isfinite(nut.across_flats):
        return np.full(len(levels), _BORE[1] * nut.across_flats)
    vertices, faces = meshes.mesh(nut.part)
    local = (vertices - nut.frame[:3, 3]) @ nut.frame[:3, :3]
    begin, end = local[faces].reshape(-1, 3), local[faces[:, [1, 2, 0]]].reshape(-1, 3)
    walls = np.full(len(levels), 0.5 * nut.size)
    for n, level in enumerate(levels):
        crossing = (begin[:, 2] < level) != (end[:, 2] < level)
        if crossing.any():
            low, high = begin[crossing], end[crossing]
            share = (level - low[:, 2]) / (high[:, 2] - low[:, 2])
            at = low[:, :2] + share[:, None] * (high - low)[:, :2]
            walls[n] = float(np.hypot(at[:, 0], at[:, 1]).min())
    return np.asarray(2.0 * _BORE[0] * walls)


def under(scene: Scene, row: Fastener, within: float) -> list[int]:
    """The parts just under the bearing face of a nut or a head. scene: without the fasteners."""
    height = row.length if row.kind == "nut" else row.head_height
    if not (np.isfinite(row.size) and np.isfinite(height)):
        return []
    wide = row.across_flats if np.isfinite(row.across_flats) and row.across_flats > row.size else 1.2 * row.size
    radius = 0.25 * (row.size + wide)
    play = SEAT * row.size  # what is flush is in it by rounding
    origins = row.frame[:3, 3] + (play - height) * row.axis + radius * (_ring() @ row.frame[:3, :3].T)
    hits = scene.rays(origins, np.broadcast_to(-row.axis, (_AROUND, 3)), within=play + within)
    names, counts = np.unique(np.asarray(hits.parts)[np.asarray(hits.triangles) >= 0], return_counts=True)
    return [int(name) for name, count in zip(names, counts, strict=True) if count >= _MOST * _AROUND]


def surrounding(scene: Scene, point: Floats, frame: Floats, within: float) -> int | None:
    """The part around a point, across the axis of a frame and no farther than `within`; None if there is none."""
    ways = _ring() @ frame[:3, :3].T
    hits = scene.rays(np.broadcast_to(point, ways.shape), ways, within=within)
    names, counts = np.unique(np.asarray(hits.parts)[np.asarray(hits.triangles) >= 0], return_counts=True)
    if not len(names) or counts.max() < _MOST * _AROUND:
        return None
    return int(names[int(np.argmax(counts))])


def borne(windings: Windings, scene: Scene, row: Fastener, below: float, wide: float, deeper: float = 0.0) -> list[int]:
    """The parts that a head, a nut or its washers bear on at a height, beside its shank too.

    windings: of the whole scene; scene: without the fasteners; below: the height of the bearing face in the frame of
    the fastener; wide: its diameter, metres; deeper: how far below they may begin.
    """
    if not (np.isfinite(row.size) and np.isfinite(below) and wide > row.size > 0.0):
        return []
    play, ring = SEAT * row.size, _ring(_SEATED) @ row.frame[:3, :3].T
    found: dict[int, int] = {}
    for share in _SEAT_SHARES:
        radius = 0.5 * (row.size + share * (wide - row.size))
        origins = row.frame[:3, 3] + (below + play) * row.axis + radius * ring
        parts = _entered(windings, scene, origins, -row.axis, 2.0 * play + deeper)
        names, counts = np.unique(parts[parts >= 0], return_counts=True)
        for name, count in zip(names.tolist(), counts.tolist(), strict=True):
            if count >= _SEAT_LEAST * _SEATED:
                found[int(name)] = max(found.get(int(name), 0), int(count))
    return sorted(found, key=lambda name: (-found[name], name))


def _entered(windings: Windings, scene: Scene, origins: Floats, way: Floats, within: float) -> Ints:
    """The first part that each ray enters, (n,), -1 for none: a part around its origin, which ends there, is none."""
    ways = np.broadcast_to(way, origins.shape)
    hits = scene.rays(origins, ways, within=within)
    parts = np.where(np.asarray(hits.triangles) >= 0, np.asarray(hits.parts, dtype=np.int64), -1)
    is_left = parts >= 0
    turned = np.array([windings.is_inside_out(part) for part in parts[is_left].tolist()], dtype=bool)
    is_left[is_left] = is_against(scene, np.asarray(hits.triangles)[is_left], ways[is_left]) == turned
    if is_left.any():
        # Where faces are flush, a ray meets one of two parts alone.
        rest = scene.without(sorted(set(parts[is_left].tolist())))
        parts[is_left] = _entered(windings, rest, origins[is_left], way, within)
    return parts
