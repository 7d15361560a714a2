"""A plan lists the parts of a mock-up, and is then tessellated to a given number of triangles.

The plan is a list of shapes with the poses at which each stands. Tessellation has levels of chord tolerance, each
finer by `LEVEL_RATIO`. `Plan.build` finds the level at which the whole is just too small, refines single items to the
next level while they fit, and tops up with filler parts (rivets).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np

from feeler.progress import Progress

from ..errors import LimitError
from .mesh import Floats, Ints, Mesh, MeshParts, snapped
from .tessellation import Tolerance

Told = Callable[[float], None]
"""A progress callback, 0 to 1."""

COARSEST_CHORD_M = 0.024
LEVEL_RATIO = 2.0**0.5
LEVELS = 44  # down to a chord of a few nanometres; `LEAST_PIECE_M` stops before


class Shape:
    """A shape that can be tessellated at any level; meshes are cached until `forget`."""

    def __init__(self, make: Callable[[Tolerance], Mesh]) -> None:
        self._make = make
        self._made: dict[int, Mesh] = {}

    def mesh(self, level: int) -> Mesh:
        """The shape at a level."""
        if level not in self._made:
            self._made[level] = self._make(Tolerance(COARSEST_CHORD_M * LEVEL_RATIO**-level))
        return self._made[level]

    def forget(self, *but: int) -> None:
        """Drops the meshes of all other levels."""
        self._made = {level: mesh for level, mesh in self._made.items() if level in but}


@dataclass(eq=False)
class Item:
    """One shape at `poses` (k, 4, 4): k parts, named `base`, or `base_001`, `base_002`, ... if there are several."""

    base: str
    shape: Shape
    poses: Floats
    first: int
    numbered: bool

    def names(self, count: int) -> list[str]:
        """The names of the first `count` parts."""
        return [f"{self.base}_{k:03d}" for k in range(self.first, self.first + count)] if self.numbered else [self.base]


@dataclass
class Plan:
    """The parts of a mock-up. `root` is the first step of every part's path."""

    root: str
    rng: np.random.Generator
    items: list[Item] = field(default_factory=list)
    fillers: list[Item] = field(default_factory=list)
    _shapes: dict[Hashable, Shape] = field(default_factory=dict)
    _numbers: dict[str, int] = field(default_factory=dict)

    def shape(self, make: Callable[..., Mesh], *arguments: Hashable) -> Shape:
        """The shape `make(*arguments, tol)`; equal calls give the same one, so that it is tessellated once."""
        key = (make, arguments)
        if key not in self._shapes:
            self._shapes[key] = Shape(lambda tol: make(*arguments, tol))
        return self._shapes[key]

    def add(self, base: str, shape: Shape, poses: Floats) -> None:
        """Parts at poses: one (4, 4), named as it is, or several (k, 4, 4), numbered on from the last of that base."""
        if len(poses):
            self.items.append(self._item(base, shape, poses))

    def add_filler(self, base: str, shape: Shape, poses: Floats) -> None:
        """Parts of which only the first few may be built: as many as the requested size needs."""
        if len(poses):
            self.fillers.append(self._item(base, shape, poses))

    def _item(self, base: str, shape: Shape, poses: Floats) -> Item:
        if poses.ndim == 2:
            if base in self._numbers:
                raise AssertionError(f"part name {base!r} used twice")
            self._numbers[base] = 1
            return Item(base, shape, poses[None], 0, False)
        first = self._numbers.get(base, 0) + 1
        self._numbers[base] = first + len(poses) - 1
        return Item(base, shape, poses, first, True)

    @property
    def part_count(self) -> int:
        """Parts without fillers."""
        return sum(len(item.poses) for item in self.items)

    def count(self, level: int, told: Told = lambda share: None) -> int:
        """Triangles of all items at one level."""
        total = 0
        for number, item in enumerate(self.items, start=1):
            total += len(item.poses) * item.shape.mesh(level).triangle_count
            if number % 256 == 0:
                told(number / len(self.items))
        told(1.0)
        return total

    def least_count(self) -> int:
        """Triangles at the coarsest level."""
        return self.count(0)

    def build(self, triangles: int, progress: Progress | None = None) -> MeshParts:
        """The mock-up with as nearly `triangles` triangles as the plan allows, never more."""

        def told(share: float) -> None:
            if progress:
                progress(0.3 * share, "tessellating")

        told(0.0)
        levels = self._choose_levels(triangles, told)
        if progress:
            progress(0.3, "placing parts")
        chosen = [(item, level, len(item.poses)) for item, level in zip(self.items, levels, strict=True)]
        missing = triangles - sum(item.shape.mesh(level).triangle_count * k for item, level, k in chosen)
        filler_level = max(levels)
        for item in self.fillers:
            each = item.shape.mesh(filler_level).triangle_count
            k = min(len(item.poses), missing // each)
            if k > 0:
                chosen.append((item, filler_level, k))
                missing -= k * each
        if missing > 0.05 * triangles:
            raise LimitError(
                f"{self.root} cannot be tessellated to {triangles} triangles, {triangles - missing} is the most with "
                "its parts; ask for fewer"
            )
        for item, level, _ in chosen:
            item.shape.forget(level, level + 1, level - 1)
        return _assemble(self.root, chosen, progress)

    def _choose_levels(self, triangles: int, told: Told) -> Ints:
        level = self._level_below(triangles, told)
        copies = np.array([len(item.poses) for item in self.items])
        total = self.count(level)
        levels = np.full(len(self.items), level)
        order = self.rng.permutation(len(self.items))
        # the shapes with most to gain first, so that no large step is left for the end
        now = np.array([item.shape.mesh(level).triangle_count for item in self.items]) * copies
        finer = np.array([item.shape.mesh(level + 1).triangle_count for item in self.items]) * copies
        order = order[np.argsort(-np.minimum((finer - now)[order], triangles // 50), kind="stable")]
        for k in order:
            step = int(finer[k] - now[k])
            if 0 < step <= triangles - total:
                levels[k] = level + 1
                total += step
        return levels

    def _level_below(self, triangles: int, told: Told) -> int:
        """The finest level that does not exceed `triangles`: guessed on a twelfth of the items, then counted."""
        counts = 0

        def counted(level: int) -> int:
            # The number of counts is not known: each reports half of the rest.
            nonlocal counts
            counts += 1
            return self.count(level, lambda share: told(1.0 - 0.5 ** (counts - 1 + share)))

        if self.least_count() > triangles:
            raise LimitError(f"{self.root}: even the coarsest tessellation has more than {triangles} triangles")
        some = Plan(self.root, self.rng, self.items[::12])
        share = some.count(6) / self.count(6)
        level = 0
        while level < LEVELS and some.count(level + 1) <= share * triangles:
            level += 1
        while level > 0 and counted(level) > triangles:
            level -= 1
        while level < LEVELS and counted(level + 1) <= triangles:
            level += 1
            for item in self.items:
                item.shape.forget(level)
        return level


def _assemble(root: str, chosen: list[tuple[Item, int, int]], progress: Progress | None) -> MeshParts:
    meshes = [item.shape.mesh(level) for item, level, _ in chosen]
    vertex_total = sum(len(mesh.vertices) * k for mesh, (_, _, k) in zip(meshes, chosen, strict=True))
    face_total = sum(mesh.triangle_count * k for mesh, (_, _, k) in zip(meshes, chosen, strict=True))
    if vertex_total >= 2**32 or face_total >= 2**32:
        raise LimitError(f"{root}: {face_total} triangles do not fit 32-bit indices; ask for fewer")
    vertices = np.empty((vertex_total, 3))
    faces = np.empty((face_total, 3), dtype=np.uint32)
    part_of_face = np.empty(face_total, dtype=np.uint32)
    names: list[str] = []
    v = f = 0
    for number, (mesh, (item, _, k)) in enumerate(zip(meshes, chosen, strict=True)):
        n, m = len(mesh.vertices), mesh.triangle_count
        rotation, shift = item.poses[:k, :3, :3], item.poses[:k, None, :3, 3]
        placed = vertices[v : v + n * k].reshape(k, n, 3)
        np.matmul(mesh.vertices[None], rotation.transpose(0, 2, 1), out=placed)
        placed += shift
        offset = (v + n * np.arange(k)).astype(np.uint32)
        faces[f : f + m * k].reshape(k, m, 3)[:] = mesh.faces.astype(np.uint32)[None] + offset[:, None, None]
        part_of_face[f : f + m * k] = np.repeat(np.arange(len(names), len(names) + k, dtype=np.uint32), m)
        names += item.names(k)
        v, f = v + n * k, f + m * k
        if progress and number % 256 == 255:
            progress(0.3 + 0.6 * f / face_total, "placing parts")
    if progress:
        progress(0.9, "placing parts")
    snapped(vertices)
    return MeshParts(vertices, faces, part_of_face, names, [f"{root}/{name}" for name in names])
