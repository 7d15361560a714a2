"""Random assemblies of cubes, with known blocking relations along each axis.

An assembly is a grid of cubes, each of one part or empty. A part that moves along an axis is blocked by the parts with
a cube ahead of one of its own in the same row. Parts are painted over each other: a bolt makes its hole. Meshes are
smaller than their cubes by a play. Bolts have a round shank and a hexagon head within theirs.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler

manifold3d = import_module("manifold3d")  # an extra, without type information

CUBE_M = 0.004
PLAYS_M = (0.0, 2e-5, 1e-4)
"""How much smaller than its cubes a mesh is, on each side."""
MOST_PARTS = 7
DIRECTIONS = tuple(itertools.product(range(3), (1, -1)))
"""Axis, and which way."""
EMPTY = -1

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@dataclass
class Assembly:
    """Cubes of parts, which of these are bolts, which must stay, and which is wanted."""

    kind: str
    cubes: Ints
    """`(x, y, z)`: the part of each cube, or `EMPTY`."""
    play_m: float
    bolts: dict[int, tuple[int, int]] = field(default_factory=dict)
    """By part: where its head begins along z, and how many cubes it is wide."""
    keep: frozenset[int] = frozenset()
    wanted: int = 0

    @property
    def count(self) -> int:
        """Parts."""
        return int(self.cubes.max()) + 1

    def fill(self, part: int, x: slice, y: slice, z: slice) -> None:
        """Paints a block of cubes."""
        self.cubes[x, y, z] = part

    def names(self) -> list[str]:
        """Of the parts; bolts are called so."""
        return [f"bolt_{part}" if part in self.bolts else f"part_{part}" for part in range(self.count)]

    def blocks(self) -> dict[tuple[int, int], list[set[int]]]:
        """By direction, for each part: the parts that it meets on its way out."""
        found = {}
        for axis, sign in DIRECTIONS:
            rows = np.moveaxis(self.cubes, axis, -1)[..., ::sign]
            blocked: list[set[int]] = [set() for _ in range(self.count)]
            for row in rows.reshape(-1, rows.shape[-1]).tolist():
                met = [part for part in row if part != EMPTY]
                for place, part in enumerate(met):
                    blocked[part].update(met[place + 1 :])
            for part, others in enumerate(blocked):
                others.discard(part)
            found[axis, sign] = blocked
        return found

    def joined(self) -> dict[int, set[int]]:
        """By bolt: the parts beside its shank, those that it goes through and the one that it ends in."""
        found: dict[int, set[int]] = {}
        for bolt, (head, _) in self.bolts.items():
            near: set[int] = set()
            for x, y, z in np.argwhere(self.cubes == bolt).tolist():
                if z < head:
                    near |= {int(self.cubes[x + dx, y, z]) for dx in (-1, 1)} | {int(self.cubes[x, y + 1, z])}
            found[bolt] = near - {EMPTY, bolt} - self.bolts.keys()
        return found

    def meshes(self) -> list[tuple[Floats, Ints]]:
        """Corners, metres, and triangles of each part."""
        return [self._bolt(part) if part in self.bolts else self._cubes(part) for part in range(self.count)]

    def mockup(self) -> feeler.Mockup:
        """The parts as one mock-up."""
        meshes = self.meshes()
        first = np.cumsum([0] + [len(corners) for corners, _ in meshes])
        return feeler.Mockup(
            np.concatenate([corners for corners, _ in meshes]),
            np.concatenate([faces + begin for (_, faces), begin in zip(meshes, first, strict=False)]),
            np.repeat(np.arange(len(meshes)), [len(faces) for _, faces in meshes]),
            self.names(),
        )

    def _cubes(self, part: int) -> tuple[Floats, Ints]:
        mine = np.pad(self.cubes == part, 1)
        play = self.play_m
        boxes = []
        for cube in np.argwhere(mine):
            lower, upper = (cube - 1) * CUBE_M, cube * CUBE_M
            for axis in range(3):
                step = np.eye(3, dtype=int)[axis]
                lower[axis] += 0.0 if mine[tuple(cube - step)] else play
                upper[axis] -= 0.0 if mine[tuple(cube + step)] else play
            boxes.append(manifold3d.Manifold.cube((upper - lower).tolist()).translate(lower.tolist()))
        return arrays(manifold3d.Manifold.batch_boolean(boxes, manifold3d.OpType.Add))

    def _bolt(self, part: int) -> tuple[Floats, Ints]:
        head, width = self.bolts[part]
        cubes = np.argwhere(self.cubes == part)
        shank, top = cubes[cubes[:, 2] < head], cubes[cubes[:, 2] >= head]
        x, y = (shank[0, :2] + 0.5) * CUBE_M
        low, bearing, high = (np.array([shank[:, 2].min(), head, top[:, 2].max() + 1])) * CUBE_M
        radius = 0.5 * CUBE_M - self.play_m - 1e-5
        round_, hexagon = 24, 6
        rod = manifold3d.Manifold.cylinder(bearing - low + 0.5 * CUBE_M, radius, radius, round_)
        wide = 0.5 * width * CUBE_M - self.play_m
        cap = manifold3d.Manifold.cylinder(high - bearing - 2 * self.play_m, wide, wide, hexagon)
        low, bearing = low + self.play_m, bearing + self.play_m
        return arrays(rod.translate((x, y, low)) + cap.translate((x, y, bearing)))


def arrays(solid: Any) -> tuple[Floats, Ints]:
    """Corners and triangles."""
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(np.int64)


def _empty(kind: str, shape: tuple[int, int, int], rng: np.random.Generator) -> Assembly:
    return Assembly(kind, np.full(shape, EMPTY, dtype=np.int64), float(rng.choice(PLAYS_M)))


def tray(rng: np.random.Generator) -> Assembly:
    """Blocks in a tray, some on others, some under a lid in the rim or a cover over it."""
    made = _empty("boxes in a tray", (10, 10, 7), rng)
    made.fill(0, slice(1, 9), slice(1, 9), slice(0, 5))
    made.fill(EMPTY, slice(2, 8), slice(2, 8), slice(1, 5))
    part = 1
    for x, y in rng.permutation([(2, 2), (2, 5), (5, 2), (5, 5)])[: rng.integers(1, 4)]:
        high = 1
        for _ in range(int(rng.integers(1, 3))):
            if part < MOST_PARTS - 2:
                made.fill(part, slice(x, x + rng.integers(2, 4)), slice(y, y + 3), slice(high, high + 1))
                part, high = part + 1, high + 1
    if rng.random() < 0.5:
        made.fill(part, slice(2, 8), slice(2, 8), slice(3, 4))
        part += 1
    if rng.random() < 0.5:
        made.fill(part, slice(0, 10), slice(0, 10), slice(5, 6))
    made.keep = frozenset([0])
    return made


def pegs(rng: np.random.Generator) -> Assembly:
    """Pegs in through and blind holes of a plate, with and without heads, and hoods over some of them."""
    made = _empty("pegs in holes", (12, 12, 9), rng)
    made.fill(0, slice(0, 12), slice(0, 12), slice(1, 4))
    part = 1
    for x, y in rng.permutation([(2, 2), (2, 8), (8, 2), (8, 8)])[: rng.integers(1, 5)]:
        low = int(rng.integers(1, 3))
        made.fill(part, slice(x, x + 1), slice(y, y + 1), slice(low, 6))
        if rng.random() < 0.5:
            made.fill(part, slice(x - 1, x + 2), slice(y - 1, y + 2), slice(4, 5))
        if low == 1 and rng.random() < 0.3:
            made.fill(part, slice(x - 1, x + 2), slice(y, y + 1), slice(0, 1))
        part += 1
        if part < MOST_PARTS and rng.random() < 0.5:
            # A hood, down to the plate.
            around = slice(x - 2, x + 3), slice(y - 2, y + 3)
            inside = made.cubes[x - 1 : x + 2, y - 1 : y + 2, 4:7].copy()
            made.fill(part, *around, slice(4, 8))
            made.cubes[x - 1 : x + 2, y - 1 : y + 2, 4:7] = inside
            part += 1
    made.keep = frozenset([0]) if rng.random() < 0.5 else frozenset()
    return made


def plates(rng: np.random.Generator) -> Assembly:
    """Plates on a base, under bolts; a hood over a bolt, or a bar over several."""
    made = _empty("plates with bolts", (11, 11, 12), rng)
    count = int(rng.integers(1, 4))
    top = 3 + count
    made.fill(0, slice(0, 11), slice(0, 11), slice(0, 3))
    for part in range(1, count + 1):
        made.fill(part, slice(0, 11), slice(0, 11), slice(part + 2, part + 3))
    part = count + 1
    places = rng.permutation([(2, 2), (2, 8), (8, 2), (8, 8)])[: rng.integers(1, 7 - part)]
    for x, y in places:
        made.fill(part, slice(x, x + 1), slice(y, y + 1), slice(1, top))
        made.fill(part, slice(x - 1, x + 2), slice(y - 1, y + 2), slice(top, top + 2))
        made.bolts[part] = (top, 3)
        part += 1
    if part < MOST_PARTS and rng.random() < 0.6:
        x, y = places[0]
        inside = made.cubes[x - 1 : x + 2, y - 1 : y + 2, top : top + 3].copy()
        made.fill(part, slice(x - 2, x + 3), slice(y - 2, y + 3), slice(top, top + 4))
        made.cubes[x - 1 : x + 2, y - 1 : y + 2, top : top + 3] = inside
    made.keep = frozenset([0]) if rng.random() < 0.5 else frozenset()
    return made


def interlocked(rng: np.random.Generator) -> Assembly:
    """Halves with tongues under each other, in a tray or free, with blocks on them."""
    made = _empty("interlocking halves", (12, 8, 7), rng)
    has_tray = rng.random() < 0.6
    a, b = 0, 1
    made.fill(a, slice(1, 6), slice(1, 7), slice(1, 4))
    made.fill(b, slice(6, 11), slice(1, 7), slice(1, 4))
    under = int(rng.integers(1, 3))
    made.fill(a, slice(6, 9), slice(1, 3), slice(under, under + 1))
    made.fill(b, slice(3, 6), slice(4, 6), slice(under, under + 1))
    if rng.random() < 0.4:
        made.fill(a, slice(6, 7), slice(1, 7), slice(3, 4))  # and a lip over the other one
    part = 2
    for x in (1, 6):
        if rng.random() < 0.4:
            made.fill(part, slice(x, x + int(rng.integers(3, 7))), slice(2, 5), slice(4, 5))
            part += 1
    part = len(_renumbered(made))
    if has_tray:
        around = made.cubes == EMPTY
        around[:, :, 5:] = False
        made.cubes[around] = part
        made.keep = frozenset([part])
    return made


def combs(rng: np.random.Generator) -> Assembly:
    """Combs whose fingers are between each other's, rails with a sliding block, and stops at their ends."""
    made = _empty("combs and rails", (10, 12, 7), rng)
    if rng.random() < 0.5:
        made.fill(0, slice(0, 10), slice(0, 5), slice(1, 3))
        made.fill(1, slice(0, 10), slice(7, 12), slice(1, 3))
        for x in range(0, 10, 2):
            made.fill(0, slice(x, x + 1), slice(5, 7), slice(1, 3))
            made.fill(1, slice(x + 1, x + 2), slice(5, 7), slice(1, 3))
        part = 2
        for z in (0, 3):
            if rng.random() < 0.5:
                made.fill(part, slice(2, 8), slice(3, 9), slice(z, z + 1))
                part += 1
    else:
        # A T-slot.
        made.fill(0, slice(0, 10), slice(1, 11), slice(0, 5))
        made.fill(EMPTY, slice(2, 8), slice(1, 11), slice(1, 3))
        made.fill(EMPTY, slice(4, 6), slice(1, 11), slice(3, 5))
        part = 1
        for y in (2, 5, 8):
            if y == 5 or rng.random() < 0.5:
                made.fill(part, slice(2, 8), slice(y, y + 2), slice(1, 3))
                made.fill(part, slice(4, 6), slice(y, y + 2), slice(3, 6))
                part += 1
        for y in (0, 11):
            if rng.random() < 0.6:
                made.fill(part, slice(1, 9), slice(y, y + 1), slice(0, 4))
                if rng.random() < 0.3:
                    made.fill(part, slice(4, 6), slice(min(y, 10), min(y, 10) + 2), slice(1, 2))
                part += 1
        made.keep = frozenset([0])
    return made


def hinge(rng: np.random.Generator) -> Assembly:
    """Two leaves on a pin, which may have a head, a cap, or a key through it."""
    made = _empty("hinge with its pin", (13, 11, 6), rng)
    made.fill(0, slice(0, 5), slice(1, 10), slice(1, 3))
    made.fill(1, slice(8, 13), slice(1, 10), slice(1, 3))
    for y in range(1, 10, 3):
        made.fill(0, slice(5, 8), slice(y, y + 2), slice(0, 4))
    for y in range(3, 10, 3):
        made.fill(1, slice(5, 8), slice(y, y + 1), slice(0, 4))
    made.fill(2, slice(6, 7), slice(1, 10), slice(1, 2))
    part = 3
    if rng.random() < 0.5:
        made.fill(2, slice(5, 8), slice(0, 1), slice(0, 3))
    elif rng.random() < 0.5:
        made.fill(part, slice(5, 8), slice(0, 1), slice(0, 3))
        part += 1
    if rng.random() < 0.4:
        made.fill(part, slice(5, 8), slice(10, 11), slice(0, 3))
        part += 1
    if rng.random() < 0.4:
        y = int(rng.integers(1, 9))
        made.fill(part, slice(6, 7), slice(y, y + 1), slice(1, 5))
    made.keep = frozenset([0]) if rng.random() < 0.3 else frozenset()
    return made


def burr(rng: np.random.Generator) -> Assembly:
    """A block cut at random into connected parts, which hold each other."""
    shape = tuple(int(side) for side in rng.integers(2, 5, size=3))
    made = _empty("block cut at random", (shape[0], shape[1], shape[2]), rng)
    count = int(rng.integers(3, MOST_PARTS + 1))
    cells = list(itertools.product(*(range(side) for side in shape)))
    for part, cell in enumerate(rng.permutation(cells)[: min(count, len(cells) - 1)]):
        made.cubes[tuple(cell)] = part
    while (made.cubes == EMPTY).any():
        x, y, z = rng.permutation(np.argwhere(made.cubes == EMPTY))[0]
        step = np.eye(3, dtype=int)[rng.integers(3)] * rng.choice([-1, 1])
        there = np.array([x, y, z]) + step
        if ((there >= 0) & (there < shape)).all():
            made.cubes[x, y, z] = made.cubes[tuple(there)]
    return made


KINDS: tuple[Callable[[np.random.Generator], Assembly], ...] = (*(tray, pegs, plates, interlocked, combs, hinge, burr),)


def _renumbered(made: Assembly) -> list[int]:
    """Numbers the parts without gaps, where painting over one left none of its cubes."""
    there = [part for part in np.unique(made.cubes).tolist() if part != EMPTY]
    place = {part: number for number, part in enumerate(there)}
    cubes = made.cubes.copy()
    for part, number in place.items():
        cubes[made.cubes == part] = number
    made.cubes = cubes
    made.bolts = {place[part]: head for part, head in made.bolts.items() if part in place}
    made.keep = frozenset(place[part] for part in made.keep if part in place)
    return there


def random_assembly(seed: int) -> Assembly:
    """The assembly of a number: its kind, its cubes, and a wanted part that is not kept."""
    rng = np.random.default_rng([seed, 59])
    made = KINDS[seed % len(KINDS)](rng)
    _renumbered(made)
    others = [part for part in range(made.count) if part not in made.keep]
    made.wanted = int(rng.choice(others))
    return made
