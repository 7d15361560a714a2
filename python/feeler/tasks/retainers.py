"""Circlips, pins, clamps, clips and fittings of pipes: what holds parts without a head or a nut. They are known by
their names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler._core import Rays
from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.plan.fastener_names import is_pipe, name_of, retainer_said
from feeler.plan.fastener_shape import rod_of
from feeler.plan.fasteners import Fastener, framed
from feeler.scene import Scene
from feeler.tasks.passing import passed_by, through
from feeler.tasks.rings import ring_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

TOUCH_M = 2e-4
"""Parts nearer than this lean on a circlip, metres."""
CLASP_M = 5e-4
"""What clamps and clips hold may have this gap: rubber is often not drawn."""
HALVES_M = 3e-3
"""The widest gap between the halves of a clamp."""
ASIDE, UNDERCUT = 0.3, 0.1
"""What lies in an open half: the normals there have this mean at least, and none points against it by more."""
OPPOSITE = 0.9
"""Two halves of a clamp face each other: the cosine between their directions is at most minus this."""
LARGEST_M = 0.6
MOST_TRIANGLES = 100_000
_AROUND = 24  # rays around a circlip, on each side
_SHARES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)  # where across it they begin
_LEAST = 0.2  # the share of them that hit a part that leans on it
_GROOVE = 0.5  # the share of rays across it that hit the floor of its groove
_DEPTHS = (0.1, 0.5, 0.9)  # where its walls are looked for, from the middle of the ring to the floor
_WALL = 4.0  # how far away they are at most, in halves of its thickness
_FAR = (0.0, 1.0, 4.0)  # how much farther than they touch parts are looked for, in halves of its thickness


@dataclass(frozen=True)
class Retained:
    """What a circlip, a pin, a fitting or a clip holds."""

    part: int
    kind: str
    parts: tuple[int, ...]
    anchor: int | None
    because: str


def clasped(scene: Scene, parts: Iterable[int], but: set[int], meshes: PartMeshes) -> list[int]:
    """What the clamps and clips among some parts touch, but for some. scene: without fasteners; meshes: of all parts.

    A fastener that holds only one half of a clamp joins it to its support, and does not hold what lies between both.
    """
    mockup, found, known = scene.mockup, set[int](), {*parts} | but
    for part in parts:
        if retainer_said(name_of(mockup, part)) == "clasp":
            near = scene.clearance(Tool.of_parts(mockup, [part]), np.eye(4), HALVES_M)
            inside = {int(each) for each, gap in zip(near.parts, near.distances, strict=True) if gap <= CLASP_M}
            others = {int(each) for each in near.parts if retainer_said(name_of(mockup, each)) == "clasp"} - {part}
            if not others & known:
                inside -= {each for other in others for each in _between(scene, part, other, inside, meshes)}
            found |= inside
    return sorted(found - known)


def _between(scene: Scene, half: int, other: int, parts: Iterable[int], meshes: PartMeshes) -> set[int]:
    """Of some parts those between two halves of a clamp, and the other half; clamps of pipes that cross have nothing
    between them."""
    found = set[int]()
    for part in sorted({*parts} - {other}):
        sides = [_side(scene, each, part, meshes) for each in (half, other)]
        if sides[0] is not None and sides[1] is not None:
            sizes = np.linalg.norm(sides[0]) * np.linalg.norm(sides[1])
            found |= {part, other} if float(sides[0] @ sides[1]) < -OPPOSITE * sizes else set()
    return found


def retained(scene: Scene, but: Iterable[int]) -> list[Retained]:
    """What the circlips, pins and fittings of a scene hold. but: parts that are known as other fasteners."""
    mockup, taken = scene.mockup, set(but)
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    sides = bounds[:, 1] - bounds[:, 0]
    is_small = scene.part_mask & (sides.max(axis=1) <= LARGEST_M) & (sides.min(axis=1) > 0.0)
    is_small &= (mockup.part_triangles <= MOST_TRIANGLES) & (mockup.part_triangles >= 8)
    some = [int(part) for part in np.flatnonzero(is_small) if int(part) not in taken]
    said = {part: retainer_said(name_of(mockup, part)) for part in some}
    circlips = [part for part in some if said[part] == "circlip"]
    pins = [part for part in some if said[part] == "pin"]
    meshes = PartMeshes(mockup)
    # Grooves are also in pins and bolts.
    around = _without(scene, circlips)
    rows = [_circlip(around, part, *meshes.mesh(part), taken) for part in circlips]
    fittings = [part for part in some if said[part] == "fitting"]
    bare = _without(scene, [*taken, *circlips, *pins])
    rows += _fittings(_without(scene, [*taken, *circlips, *pins, *fittings]), fittings, meshes)
    rods = [pin_rod(mockup.part_paths[part], part, meshes.mesh(part)[0]) for part in pins]
    for rod, passed in zip(rods, passed_by(bare, rods), strict=True):
        parts = tuple(dict.fromkeys(each.part for each in passed))
        # Parts that follow on each other come off along it; a fork does not, nor what is between its legs.
        is_dowel = 1 < len(parts) == len(passed) and all(each.radius > 0.0 for each in passed)
        how = (
            "it is in no part" if not parts else "it goes through them" + (", one behind the other" if is_dowel else "")
        )
        rows.append(Retained(rod.part, "dowel" if is_dowel else "pin", parts, None, f"{how}; its name says pin"))
    return rows


def gripped(scene: Scene, clamp: int, held: Iterable[int], meshes: PartMeshes) -> list[int]:
    """What is inside of the parts that a clamp clasps, such as the spigot that a hose is on.

    Rays from the clamp go through the wall of such a part, and no farther than what touches it there. scene: without
    fasteners; held: what the clamp clasps; meshes: of all parts.
    """
    corners = meshes.corners(clamp)
    middles, normals, _ = _off(corners)
    ways = np.concatenate([normals, -normals])  # it may be wound inside out
    origins = np.tile(middles, (2, 1)) - CLASP_M * ways
    near = _without(scene, [clamp])
    lengths = np.full(len(ways), float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))) if len(ways) else 0.0)
    far, parts, _ = through(near, origins, ways, lengths)
    found: set[int] = set()
    for part in held:
        wall = np.sort(np.where(parts == part, far, np.inf), axis=1)[:, :2]
        is_met = (wall[:, 0] <= 2.0 * CLASP_M) & np.isfinite(wall[:, 1])
        if is_met.any():
            others = (parts >= 0) & is_met[:, None] & (far <= wall[:, 1:] + CLASP_M) & (far >= wall[:, :1])
            names, counts = np.unique(parts[others], return_counts=True)
            found.update(names[counts >= _LEAST * is_met.sum()].tolist())
    return sorted(found - set(held) - {clamp})


def _side(scene: Scene, clamp: int, part: int, meshes: PartMeshes) -> Floats | None:
    """On which side of a clamp a part only lies, as a pipe in the lower half of one: the clamp comes off sideways."""
    corners = meshes.corners(clamp)
    volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    middles, normals, areas = _off(corners)
    ways = normals if volume >= 0.0 else -normals
    hits = scene.only([part]).rays(middles - CLASP_M * ways, ways, within=2.0 * CLASP_M)
    is_met = np.asarray(hits.triangles) >= 0
    towards, weight = ways[is_met], areas[is_met]
    mean: Floats = weight @ towards / max(float(weight.sum()), 1e-300)
    size = float(np.linalg.norm(mean))
    return mean if size > ASIDE and float((towards @ mean).min()) > -UNDERCUT * size else None


def _off(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """The middles of triangles, their normals, and twice their areas."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(normals, axis=1)
    is_some = sizes > 0.0
    return corners[is_some].mean(axis=1), normals[is_some] / sizes[is_some, None], sizes[is_some]


def clips(scene: Scene, held: set[int], but: set[int]) -> list[Retained]:
    """What clamps and clips hold that no fastener holds: they spring, or have their screw in them. What only lies in
    half a clamp is not held by it.

    held: all that fasteners hold; but: the fasteners.
    """
    mockup, rows = scene.mockup, []
    bare, meshes = _without(scene, but), PartMeshes(mockup)
    for part in np.flatnonzero(scene.part_mask).tolist():
        if part in held or part in but or retainer_said(name_of(mockup, part)) != "clasp":
            continue
        parts = tuple(each for each in clasped(bare, [part], set(), meshes) if _side(bare, part, each, meshes) is None)
        if parts:
            rows.append(
                Retained(part, "clip", parts, None, "it clamps them; no fastener holds it, its name says clamp")
            )
    return rows


def _fittings(scene: Scene, parts: list[int], meshes: PartMeshes) -> list[Retained]:
    """What fittings hold: what is clamped under them, and pipes at them; themselves in what their thread is in."""
    mockup, rods = scene.mockup, []
    for part in parts:
        looks = rod_of(*meshes.mesh(part))
        if looks is not None:
            local = (meshes.mesh(part)[0] - looks.top) @ framed(looks.top, looks.axis)[:3, :3]
            size = 2.0 * float(np.hypot(local[:, 0], local[:, 1]).max())
            frame = framed(looks.top, looks.axis)
            path = mockup.part_paths[part]
            rods.append(Fastener(part, path, "stud", frame, size, np.nan, looks.length, np.nan, 1.0, ""))
    rows = []
    for rod, passed in zip(rods, passed_by(scene, rods), strict=True):
        around = [each for each in passed if each.radius > 0.0]
        pipes = {each.part for each in around if is_pipe(name_of(mockup, each.part))}
        fixed = [each for each in around if each.part not in pipes]
        if not fixed:
            continue
        anchor = min(fixed, key=lambda each: (each.radius, each.part)).part
        held = dict.fromkeys(each.part for each in around if each.part != anchor)
        said = f"its thread is in {mockup.part_paths[anchor]!r}; its name says fitting"
        rows.append(Retained(rod.part, "fitting", (*held, rod.part) if held else (rod.part,), anchor, said))
    return rows


def _without(scene: Scene, parts: Iterable[int]) -> Scene:
    mask = scene.part_mask.copy()
    mask[list(parts)] = False
    return scene.only(mask)


def pin_rod(path: str, part: int, vertices: Floats) -> Fastener:
    """A pin, as the shank that it is."""
    axes = np.linalg.eigh(np.cov((vertices - vertices.mean(axis=0)).T))[1]
    local = vertices @ axes
    middle = axes @ (0.5 * (local.min(axis=0) + local.max(axis=0)))  # a head is as wide to all sides
    axis = axes[:, 2]
    along = (vertices - middle) @ axis
    across = np.linalg.norm((vertices - middle) - along[:, None] * axis, axis=1)
    top = middle + along.max() * axis
    size, length = 2.0 * float(np.percentile(across, 75)), float(np.ptp(along))
    return Fastener(part, path, "stud", framed(top, axis), size, np.nan, length, np.nan, 1.0, "")


def _circlip(scene: Scene, part: int, vertices: Floats, faces: Ints, fasteners: set[int]) -> Retained:
    """What leans on a ring, and what has its groove."""
    mockup, found = scene.mockup, ring_of(vertices, faces)
    if found is None:
        return Retained(part, "circlip", (), None, "its name says circlip, but it is no ring")
    frame = framed(found.middle, found.axis)
    axis, middle = frame[:3, 2], frame[:3, 3]
    inner, outer, half = found.inner, found.outer, 0.5 * found.thickness
    turn = np.arange(_AROUND) * (2.0 * np.pi / _AROUND)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(_AROUND)], axis=1) @ frame[:3, :3].T
    rim = middle + (inner + np.array(_SHARES)[:, None, None] * (outer - inner)) * ring
    anchor = _groove(scene, frame, ring, (inner, outer), half)
    parts: tuple[int, ...] = ()
    for far in _FAR:  # it may have play
        sides = [_leaning(scene, rim, way, half + TOUCH_M + far * half) for way in (axis, -axis)]
        if anchor is None:
            both = {name: min(count, sides[1][name]) for name, count in sides[0].items() if name in sides[1]}
            anchor = max(sorted(both), key=lambda name: both[name], default=None)
        parts = tuple(sorted((set(sides[0]) ^ set(sides[1])) - {anchor} - fasteners))
        if parts:
            break
    said = "no groove was found" if anchor is None else f"its groove is in {mockup.part_paths[anchor]!r}"
    return Retained(part, "circlip", parts, anchor, f"{said}; its name says circlip")


def _leaning(scene: Scene, rim: Floats, way: Floats, within: float) -> dict[int, int]:
    """The parts on one side of a ring, and how many rays hit each. rim: (k, n, 3), circles of origins."""
    found: dict[int, int] = {}
    for origins in rim:
        for name, count in _counts(scene.rays(origins, np.broadcast_to(way, origins.shape), within=within)):
            if count >= _LEAST * len(origins):
                found[name] = found.get(name, 0) + count
    return found


def _groove(scene: Scene, frame: Floats, ring: Floats, radii: tuple[float, float], half: float) -> int | None:
    """The part with a groove at a ring: inside or outside of it, and on both sides of it, or as a step on one.

    ring: (n, 3).
    """
    middle = 0.5 * (radii[0] + radii[1])
    best, least = None, (0, np.inf)
    for way in (-1.0, 1.0):
        floor = scene.rays(frame[:3, 3] + middle * ring, way * ring, within=2.0 * middle)
        for name, count in _counts(floor):
            own = np.asarray(floor.parts) == name
            depth = np.asarray(floor.distances)[own]
            gap = abs(float(np.median(depth)) - 0.5 * (radii[1] - radii[0]))
            if count < _GROOVE * len(ring):
                continue
            alone = scene.only([name])
            origins = [frame[:3, 3] + (middle + way * share * depth)[:, None] * ring[own] for share in _DEPTHS]
            walls = sum(_is_wall(alone, origins, side * frame[:3, 2], _WALL * half) for side in (-1.0, 1.0))
            if walls and (-walls, gap) < least:
                best, least = name, (-walls, gap)
    return best


def _is_wall(scene: Scene, origins: list[Floats], way: Floats, within: float) -> bool:
    """Whether rays from one of some circles hit something."""
    for circle in origins:
        hits = scene.rays(circle, np.broadcast_to(way, circle.shape), within=within)
        if np.mean(np.asarray(hits.triangles) >= 0) >= _LEAST:
            return True
    return False


def _counts(hits: Rays) -> list[tuple[int, int]]:
    """The parts that rays hit, and how many hit each."""
    names, counts = np.unique(np.asarray(hits.parts)[np.asarray(hits.triangles) >= 0], return_counts=True)
    return list(zip(names.tolist(), counts.tolist(), strict=True))
