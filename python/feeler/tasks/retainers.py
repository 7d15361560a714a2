"""Circlips, pins, clamps and clips: what holds parts without a thread. They are known by their names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler._core import Rays
from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.plan.fastener_names import retainer_said
from feeler.plan.fasteners import Fastener, framed
from feeler.scene import Scene
from feeler.tasks.passing import passed_by
from feeler.tasks.rings import ring_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

TOUCH_M = 2e-4
"""Parts nearer than this lean on a circlip, metres."""
CLASP_M = 5e-4
"""What clamps and clips hold may have this gap: rubber is often not drawn."""
LARGEST_M = 0.6
MOST_TRIANGLES = 100_000
_AROUND = 24  # rays around a circlip, on each side
_SHARES = (0.02, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.94, 0.98)  # where, across its width
_LEAST = 0.2  # the share of them that hit a part that leans on it


@dataclass(frozen=True)
class Retained:
    """What a circlip or a pin holds."""

    part: int
    kind: str
    parts: tuple[int, ...]
    anchor: int | None
    because: str


def clasped(scene: Scene, parts: Iterable[int], but: set[int]) -> list[int]:
    """What the clamps and clips among some parts touch, but for some. scene: without fasteners."""
    mockup, found = scene.mockup, set[int]()
    for part in parts:
        if retainer_said(mockup.part_names[part]) == "clasp":
            near = scene.clearance(Tool.of_parts(mockup, [part]), np.eye(4), CLASP_M)
            found.update(int(each) for each in near.parts)
    return sorted(found - set(parts) - but)


def retained(scene: Scene, but: Iterable[int]) -> list[Retained]:
    """What the circlips and pins of a scene hold. but: parts that are known as other fasteners."""
    mockup, taken = scene.mockup, set(but)
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    sides = bounds[:, 1] - bounds[:, 0]
    is_small = scene.part_mask & (sides.max(axis=1) <= LARGEST_M) & (sides.min(axis=1) > 0.0)
    is_small &= (mockup.part_triangles <= MOST_TRIANGLES) & (mockup.part_triangles >= 8)
    some = [int(part) for part in np.flatnonzero(is_small) if int(part) not in taken]
    said = {part: retainer_said(mockup.part_names[part]) for part in some}
    circlips = [part for part in some if said[part] == "circlip"]
    pins = [part for part in some if said[part] == "pin"]
    mask = scene.part_mask.copy()
    mask[[*taken, *circlips, *pins]] = False
    bare, meshes = scene.only(mask), PartMeshes(mockup)
    others = scene.part_mask.copy()
    others[circlips] = False
    around = scene.only(others)  # a pin, and a bolt, can have a groove, and a pin can lean on a circlip
    rows = [_circlip(around, part, *meshes.mesh(part), taken) for part in circlips]
    rods = [_rod(mockup.part_paths[part], part, meshes.mesh(part)[0]) for part in pins]
    for rod, passed in zip(rods, passed_by(bare, rods), strict=True):
        parts = tuple(each.part for each in passed)
        how = "it is in no part" if not parts else "it goes through them"
        rows.append(Retained(rod.part, "pin", parts, None, f"{how}; its name says pin"))
    return rows


def _axes(vertices: Floats) -> tuple[Floats, Floats]:
    """The middle of some points, and their principal directions, the one of the least spread first, as columns."""
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return middle, np.linalg.eigh(np.cov((vertices - vertices.mean(axis=0)).T))[1]


def _rod(path: str, part: int, vertices: Floats) -> Fastener:
    """A pin, as the shank that it is."""
    middle, axes = _axes(vertices)
    axis = axes[:, 2]
    along = (vertices - middle) @ axis
    across = np.linalg.norm((vertices - middle) - along[:, None] * axis, axis=1)
    top = middle + along.max() * axis
    size, length = 2.0 * float(np.percentile(across, 75)), float(np.ptp(along))
    return Fastener(part, path, "stud", framed(top, axis), size, np.nan, length, np.nan, 1.0, "")


def _circlip(scene: Scene, part: int, vertices: Floats, faces: Ints, fasteners: set[int]) -> Retained:
    """What leans on one side of a ring, but threaded fasteners; what is on both sides has its groove."""
    mockup, ring = scene.mockup, ring_of(vertices, faces)
    if ring is None:
        return Retained(part, "circlip", (), None, "its name says circlip, but it is no ring")
    frame = framed(ring.middle, ring.axis)
    turn = np.arange(_AROUND) * (2.0 * np.pi / _AROUND)
    sides: list[set[int]] = []
    leaning = set[int]()
    for way in (ring.axis, -ring.axis):
        found = set[int]()
        for share in _SHARES:
            radius = ring.inner + share * ring.width
            at = radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(_AROUND)], axis=1) @ frame[:3, :3].T
            origins, ways = ring.middle + at, np.broadcast_to(way, (_AROUND, 3))
            hits = scene.rays(origins, ways, within=max(ring.thickness, 0.5 * ring.thickness + TOUCH_M))
            found |= _most(hits, ring.thickness)
            leaning |= _most(hits, 0.5 * ring.thickness + TOUCH_M)
        sides.append(found)
    both = sides[0] & sides[1]
    anchor = min(both) if both else None
    parts = tuple(sorted(leaning - both - fasteners))
    said = "no groove was found" if anchor is None else f"its groove is in {mockup.part_paths[anchor]!r}"
    return Retained(part, "circlip", parts, anchor, f"{said}; its name says circlip")


def _most(hits: Rays, within: float) -> set[int]:
    """The parts that a share of the rays around hit within a distance, metres."""
    is_near = (np.asarray(hits.triangles) >= 0) & (np.asarray(hits.distances) <= within)
    names, counts = np.unique(np.asarray(hits.parts)[is_near], return_counts=True)
    return {int(name) for name, count in zip(names, counts, strict=True) if count >= _LEAST * _AROUND}
