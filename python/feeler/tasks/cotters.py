"""Cotter pins, hairpins and the like: thin parts in a hole across a bolt or a pin, by shape.

Such a part keeps a nut, or what is on a pin, from coming off. Its legs are bent and its eye is wider than the hole, so
it has no rigid way: its legs are straightened, or cut, and it is drawn by its head.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.plan.fastener_names import name_of, retainer_said
from feeler.plan.fastener_shape import rod_of
from feeler.plan.fasteners import Fastener, framed
from feeler.scene import Scene
from feeler.tasks.passing import LEVELS, around, in_bore, passed_by
from feeler.tasks.retainers import Retained, pin_rod
from feeler.tasks.rings import Slipping

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

INSIDE = 0.9
"""What is this near to the axis of a shank, in its radii, is in it."""
THIN = 0.6
"""The greatest radius of a cotter pin, in radii of the shank: holes across bolts are narrow."""
SLENDER = 0.5
"""The greatest spread of it in the shank across its axis, over that along it."""
NEEDLE = 0.01
"""The least such spread: one edge alone is no pin."""
FLAT = 0.05
"""The least spread of it in its flattest direction, over that in the other one across its axis."""
ACROSS = 0.2
"""The greatest cosine between its axis and that of the shank."""
OUT = 0.8
"""It reaches at least so far to both sides, in radii of the shank."""
LONGEST = 10.0
"""Its size, in diameters of the shank, at most."""
EYE = 1.3
"""What is farther from its axis, in its radii, is a bent leg or its head."""
ON_AXIS = 0.3
"""How far from the axis of a shank its nut may be, in its diameters."""
LEGS = 0.6
"""Bent legs and eyes are about in one plane: their spread across it, over that in it, at most. Round heads are not."""
ROUND = 0.93
"""The least width of a round rod across its axis, over its greatest."""
ROD_SLENDER = 1.5
"""Its least length, in diameters."""
PLAY_M = 1e-4
"""It is drawn so much farther than out of what it is in."""
MOST_TRIANGLES = 20_000
_PIECES = 24
_TURNS = 12


@dataclass(frozen=True, eq=False)
class Shank:
    """The straight part of a cotter pin, in the hole across a bolt or pin."""

    point: Floats
    axis: Floats
    radius: float

    def heights(self, points: Floats) -> Floats:
        """Along its axis, (n,)."""
        return np.asarray((points - self.point) @ self.axis)

    def radii(self, points: Floats) -> Floats:
        """Distances from its axis, (n,)."""
        local = points - self.point
        return np.asarray(np.linalg.norm(local - (local @ self.axis)[:, None] * self.axis, axis=1))


@dataclass(frozen=True, eq=False)
class Drawing(Slipping):
    """A cotter pin that is drawn by its head until it is out of its hole."""

    is_bent: bool = True
    """Whether it has bent legs."""

    def __str__(self) -> str:
        how = "its legs are straightened or cut; " if self.is_bent else ""
        return f"{how}it is drawn along its axis by {1e3 * self.travel:.3g} mm"


def cotters_of(scene: Scene, rows: Sequence[Fastener], taken: set[int]) -> list[Retained]:
    """The cotter pins of a scene, and what each keeps on the bolt or pin that it goes through.

    rows: its fasteners; taken: parts that are known as something else.
    """
    look = _Look(scene, rows, taken)
    shanks = [*(row for row in rows if row.kind != "nut"), *look.pins()]
    found: dict[int, tuple[Fastener, Shank]] = {}
    for row in shanks:
        for part, shank in look.through(row):
            found.setdefault(part, (row, shank))
    for row in look.bare_nuts([row for row in shanks if row.kind != "nut"]):
        for part, shank in look.through(nut_shank(row, -1)):
            thread = look.thread(row, part)
            if thread is not None and look.fits(nut_shank(row, thread), part, shank):
                found.setdefault(part, (nut_shank(row, thread), shank))
    for row in look.rods({row.part for row, _ in found.values()}):
        for part, shank in look.through(row):
            if look.is_cotter(part, shank):
                found.setdefault(part, (row, shank))
    # Of two pins one goes through the other: the smaller one.
    large = {part for part, (row, _) in found.items() if row.part in found and look.sizes[part] > look.sizes[row.part]}
    found = {part: each for part, each in found.items() if part not in large}
    return look.rows(found)


class _Look:
    """Looks at the shanks of a scene."""

    def __init__(self, scene: Scene, rows: Sequence[Fastener], taken: set[int]) -> None:
        self.scene, self.meshes = scene, PartMeshes(scene.mockup)
        self.bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)
        self.nuts = [row for row in rows if row.kind == "nut"]
        ends = [(row.frame[:3, 3], row.frame[:3, 3] - row.length * row.axis) for row in self.nuts]
        self.ends = np.array(ends).reshape(-1, 2, 3)
        self.fasteners = {row.part for row in rows}
        self.is_free = scene.part_mask & (scene.mockup.part_triangles <= MOST_TRIANGLES)
        self.is_free[sorted(self.fasteners | taken)] = False
        self._meshes: dict[int, tuple[Floats, Ints]] = {}
        self.sizes = np.linalg.norm(self.bounds[:, 1] - self.bounds[:, 0], axis=1)

    def pins(self) -> Iterator[Fastener]:
        """The parts that are pins by their names."""
        mockup = self.scene.mockup
        for part in np.flatnonzero(self.is_free).tolist():
            if retainer_said(name_of(mockup, part)) == "pin" and mockup.part_triangles[part] >= 8:
                yield pin_shank(self.scene, part, self.meshes.mesh(part)[0])

    def rods(self, known: set[int]) -> Iterator[Fastener]:
        """The other round rods, whatever their names are, that something thinner may go through."""
        mockup = self.scene.mockup
        for part in np.flatnonzero(self.is_free).tolist():
            name = name_of(mockup, part)
            if part in known or retainer_said(name) == "pin" or mockup.part_triangles[part] < 8:
                continue
            if not self._has_thin_neighbour(part):
                continue
            row = rod_shank(self.scene, part, *self.meshes.mesh(part))
            if row is not None:
                yield row

    def _has_thin_neighbour(self, part: int) -> bool:
        """Whether the box of a smaller part that may be a cotter pin reaches into that of a part."""
        low, high = self.bounds[part]
        near = self._beside(part)
        near = near[self.sizes[near] < self.sizes[part]]
        return bool(((self.bounds[near, 0] <= high) & (self.bounds[near, 1] >= low)).all(axis=1).any())

    def _beside(self, part: int) -> Ints:
        """The parts among which are the smaller ones whose boxes reach into that of a part."""
        low, high = self.bounds[part]
        lows, others, axis = self._by_place
        # Smaller parts that reach it begin at most its own size before it.
        return others[
            np.searchsorted(lows, low[axis] - self.sizes[part]) : np.searchsorted(lows, high[axis], side="right")
        ]

    @cached_property
    def _by_place(self) -> tuple[Floats, Ints, int]:
        """The free parts that have a size in the order in which they begin along an axis: where, which, and the axis,
        the one along which they are spread most."""
        parts = np.flatnonzero(self.is_free & (self.sizes > 0.0) & np.isfinite(self.sizes))
        lows = self.bounds[parts, 0]
        axis = int(np.argmax(np.ptp(lows, axis=0))) if len(parts) else 0
        order = np.argsort(lows[:, axis], kind="stable")
        return lows[order, axis], parts[order], axis

    def is_cotter(self, part: int, shank: Shank) -> bool:
        """Whether a part in a hole across a rod is a cotter pin: its legs or its eye are bent, and if its name does not
        say so, it is wide on both sides."""
        vertices = self.meshes.mesh(part)[0]
        heights, is_wide = shank.heights(vertices), shank.radii(vertices) > EYE * shank.radius
        sides = [vertices[is_wide & (sign * heights > 0.0)] for sign in (1.0, -1.0)]
        sides = [each for each in sides if len(each)]
        is_said = retainer_said(name_of(self.scene.mockup, part)) == "pin"
        return len(sides) >= (1 if is_said else 2) and any(_is_bent(each - shank.point, shank.axis) for each in sides)

    def bare_nuts(self, shanks: Sequence[Fastener]) -> list[Fastener]:
        """The nuts that are on no known shank, but on the thread of a part."""
        on = {nut for row in shanks for nut, _, _ in self._nuts_on(row)}
        return [nut for nut in self.nuts if nut.part not in on]

    def thread(self, nut: Fastener, but: int) -> int | None:
        """The part that a nut is on."""
        inside = in_bore(self.scene.without(sorted({*self.fasteners, but})), nut, self.meshes)
        return max(inside, key=lambda each: each.radius).part if inside else None

    def through(self, row: Fastener) -> Iterator[tuple[int, Shank]]:
        """The parts in a hole across a shank."""
        if not (np.isfinite(row.size) and np.isfinite(row.length) and row.size > 0.0):
            return
        foot = row.frame[:3, 3] - (row.length + _head(row)) * row.axis
        low, high = np.minimum(row.frame[:3, 3], foot), np.maximum(row.frame[:3, 3], foot)
        near = self.is_free & (self.sizes <= LONGEST * row.size) & (self.sizes >= row.size)
        near &= (self.bounds[:, 0] <= high).all(axis=1) & (self.bounds[:, 1] >= low).all(axis=1)
        for part in np.flatnonzero(near).tolist():
            if part not in self._meshes:
                vertices, faces = self.meshes.mesh(part)
                self._meshes[part] = vertices, _edges(faces)
            shank = None if part == row.part else _shank_of(*self._meshes[part], row)
            if shank is not None and self.fits(row, part, shank):
                yield part, shank

    def fits(self, row: Fastener, part: int, shank: Shank) -> bool:
        """Whether a part is a cotter pin by its name, or the shank has a hole for it: others are in it by chance."""
        if row.part < 0 or retainer_said(name_of(self.scene.mockup, part)) == "pin":
            return True
        ways = np.stack([shank.axis, -shank.axis])
        hits = self.scene.only([row.part]).rays(np.tile(shank.point, (2, 1)), ways, within=row.size)
        return not (np.asarray(hits.triangles) >= 0).any()

    def rows(self, found: dict[int, tuple[Fastener, Shank]]) -> list[Retained]:
        """What cotter pins keep on what they go through."""
        bare = self.scene.without(sorted(self.fasteners | found.keys() | {row.part for row, _ in found.values()}))
        shanks = [row for row, _ in found.values()]
        rows = []
        for (part, (row, shank)), passed in zip(found.items(), passed_by(bare, shanks), strict=True):
            height = float((shank.point - row.frame[:3, 3]) @ row.axis)
            is_up = bool(np.isfinite(row.head_height) or 2.0 * height < -row.length)
            on = [(each.part, each.top, each.bottom) for each in passed] + list(self._nuts_on(row))
            if not is_up:
                on = [(name, -bottom, -top) for name, top, bottom in on]
                height = -height
            beyond = [(max(bottom - height, 0.0), name) for name, top, bottom in on if top >= height]
            kept = () if not beyond else (min(beyond)[1],)
            path = self.scene.mockup.part_paths[row.part]
            rows.append(Retained(part, "cotter", kept, row.part, f"it is in a hole across {path!r}"))
        return rows

    def _nuts_on(self, row: Fastener) -> Iterator[tuple[int, float, float]]:
        """The nuts on a shank, and where each begins and ends along it."""
        local = (self.ends - row.frame[:3, 3]) @ row.frame[:3, :3]
        off = np.hypot(local[..., 0], local[..., 1]).max(axis=1)
        for n in np.flatnonzero(off <= ON_AXIS * row.size).tolist():
            yield self.nuts[n].part, float(local[n, :, 2].max()), float(local[n, :, 2].min())


def _is_bent(points: Floats, axis: Floats) -> bool:
    """Whether points, from a point of an axis, are about in one plane through it: legs and eyes, and no round heads."""
    across = points - (points @ axis)[:, None] * axis
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(across.T @ across)[1:], 0.0))
    return bool(spread[0] <= LEGS * spread[1])


def rod_shank(scene: Scene, part: int, vertices: Floats, faces: Ints) -> Fastener | None:
    """A round rod as a shank, without its head; None for other shapes."""
    looks = rod_of(vertices, faces)
    if looks is None:
        return None
    frame = framed(looks.top, looks.axis)
    local = (vertices - looks.top) @ frame[:3, :2]
    turns = np.arange(_TURNS) * (np.pi / _TURNS)
    along = local @ np.stack([np.cos(turns), np.sin(turns)])
    wide = np.ptp(along, axis=0)
    if wide.min() < ROUND * wide.max() or looks.length < ROD_SLENDER * float(wide.max()):
        return None
    path, size = scene.mockup.part_paths[part], float(wide.max())
    row = Fastener(part, path, "stud", frame, size, np.nan, looks.length, np.nan, 1.0, "")
    return pin_shank(scene, part, vertices, row)


def pin_shank(scene: Scene, part: int, vertices: Floats, rod: Fastener | None = None) -> Fastener:
    """A pin as a shank, without its head: as wide as it is at most heights. rod: if its axis is known."""
    row = rod or pin_rod(scene.mockup.part_paths[part], part, vertices)
    far = 2.0 * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    ways = around(row.frame)
    heights = -row.length * (np.arange(LEVELS) + 0.5) / LEVELS
    starts = row.frame[:3, 3] + heights[:, None, None] * row.axis + far * ways
    hits = scene.only([part]).rays(starts.reshape(-1, 3), -np.tile(ways, (LEVELS, 1)))
    met = far - np.asarray(hits.distances)[np.asarray(hits.triangles) >= 0]
    return replace(row, size=2.0 * float(np.median(met))) if len(met) else row


def shank_of(vertices: Floats, faces: Ints, row: Fastener) -> Shank | None:
    """The straight part of a mesh in a hole across the shank of a fastener; None if it goes through none."""
    return _shank_of(vertices, _edges(faces), row)


def _edges(faces: Ints) -> Ints:
    """The edges of triangles, (n, 2), each once."""
    both = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.asarray(np.unique(both, axis=0), dtype=np.int64)


def _shank_of(vertices: Floats, edges: Ints, row: Fastener) -> Shank | None:
    begin, end = ((vertices[edges[:, k]] - row.frame[:3, 3]) @ row.frame[:3, :3] for k in (0, 1))
    radius, step = 0.5 * row.size, end - begin
    length = np.einsum("ij,ij->i", step[:, :2], step[:, :2])
    share = -np.einsum("ij,ij->i", begin[:, :2], step[:, :2]) / np.where(length > 0.0, length, 1.0)
    nearest = begin + np.clip(share, 0.0, 1.0)[:, None] * step
    is_near = np.hypot(nearest[:, 0], nearest[:, 1]) <= INSIDE * radius
    pieces = np.linspace(0.0, 1.0, _PIECES)[:, None, None]
    points = (begin[is_near] + pieces * step[is_near]).reshape(-1, 3)
    is_in = (np.hypot(points[:, 0], points[:, 1]) <= INSIDE * radius) & (points[:, 2] <= 0.0)
    points = points[is_in & (points[:, 2] >= -row.length - _head(row))]
    if len(points) < 4:
        return None
    middle = points.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov((points - middle).T))
    if spread[1] > SLENDER**2 * spread[2] or abs(float(axes[2, 2])) > ACROSS:
        return None
    if spread[1] < NEEDLE**2 * spread[2] or spread[0] < FLAT**2 * spread[1]:
        return None  # the diagonals of a plane face, or of the faces of a plate
    rough = Shank(row.frame[:3, :3] @ middle + row.frame[:3, 3], row.frame[:3, :3] @ axes[:, 2], 0.0)
    wide = float(rough.radii(points @ row.frame[:3, :3].T + row.frame[:3, 3]).max())
    heights = rough.heights(vertices)
    if wide > THIN * radius or heights.max() < OUT * radius or heights.min() > -OUT * radius:
        return None
    return Shank(rough.point, rough.axis, wide)


def drawings(vertices: Floats, faces: Ints, row: Fastener, reach: float) -> Iterator[Drawing]:
    """How a cotter pin comes out of the shank of a fastener: by its head. reach: how far what it is in reaches from the
    axis of the shank, metres."""
    shank = shank_of(vertices, faces, row)
    if shank is None:
        return
    for sign in _heads(vertices, faces, shank):
        heights, radii = sign * shank.heights(vertices), shank.radii(vertices)
        is_leg = (heights < 0.0) & (radii > shank.radius)
        local = vertices - shank.point
        along = (local @ shank.axis)[:, None] * shank.axis
        share = np.where(is_leg, shank.radius / np.where(radii > 0.0, radii, 1.0), 1.0)[:, None]
        tool = Tool(shank.point + along + share * (local - along), faces.astype(np.uint32), name="cotter pin")
        way = (sign * shank.axis + 0.0).tolist()
        travel, is_bent = reach - float(heights.min()) + PLAY_M, bool((is_leg & (radii > EYE * shank.radius)).any())
        yield Drawing((way[0], way[1], way[2]), travel, 0.0, tool, False, is_bent)


def nut_shank(nut: Fastener, part: int) -> Fastener:
    """The thread of a part that a nut is on, as the shank of a bolt: as far as the nut is high beyond it."""
    frame = nut.frame.copy()
    frame[:3, 3] += nut.length * nut.axis
    return replace(nut, part=part, kind="stud", frame=frame, length=3.0 * nut.length, head_height=np.nan)


def _heads(vertices: Floats, faces: Ints, shank: Shank) -> list[float]:
    """On which side its head is: where it is in one piece, if its legs on the other side are two; else where it is
    wider; both if it is a plain pin."""
    heights, radii = shank.heights(vertices), shank.radii(vertices)
    count = {sign: _pieces(faces, sign * heights > 2.0 * shank.radius) for sign in (1.0, -1.0)}
    if 0 < count[1.0] < count[-1.0] or 0 < count[-1.0] < count[1.0]:
        return [1.0 if count[1.0] < count[-1.0] else -1.0]
    wide = {sign: float(radii[sign * heights > 0.0].max(initial=0.0)) for sign in (1.0, -1.0)}
    if max(wide.values()) <= EYE * shank.radius:
        return [1.0, -1.0]
    return [1.0 if wide[1.0] >= wide[-1.0] else -1.0]


def _pieces(faces: Ints, chosen: npt.NDArray[np.bool_]) -> int:
    """Of how many pieces the triangles with all corners chosen are."""
    own = faces[chosen[faces].all(axis=1)]
    if not len(own):
        return 0
    label = np.arange(len(chosen))
    while True:
        least = label[own].min(axis=1)
        new = label.copy()
        for k in range(3):
            np.minimum.at(new, own[:, k], least)
        if (new == label).all():
            return len(np.unique(label[own]))
        label = new


def _head(row: Fastener) -> float:
    return float(row.head_height) if np.isfinite(row.head_height) else 0.0
