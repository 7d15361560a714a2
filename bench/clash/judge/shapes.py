"""Triangle meshes, wound outwards: convex bodies, surfaces of revolution, polycubes; and their subdivision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Mesh = tuple[Floats, Faces]


def mirrored(mesh: Mesh) -> Mesh:
    """The same surface with every winding flipped."""
    return mesh[0], mesh[1][:, ::-1].copy()


def joined(*meshes: Mesh) -> Mesh:
    """Several surfaces as one part."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def cut_finer(mesh: Mesh, levels: int) -> Mesh:
    """Subdivides each triangle into four, `levels` times. Neighbours share the new vertices."""
    vertices, faces = mesh
    for _ in range(levels):
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        # One integer for each side: np.unique over rows is much slower.
        _, first, which = np.unique(sides[:, 0] * len(vertices) + sides[:, 1], return_index=True, return_inverse=True)
        middle = which.reshape(-1, 3) + len(vertices)
        ends = sides[first]
        vertices = np.concatenate([vertices, (vertices[ends[:, 0]] + vertices[ends[:, 1]]) / 2])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])
    return vertices, faces


def shuffled(rng: np.random.Generator, mesh: Mesh) -> Mesh:
    """The same triangles in random order of vertices, faces and first corners."""
    vertices, faces = mesh
    order = rng.permutation(len(vertices))
    place = np.argsort(order)
    turned = place[faces[rng.permutation(len(faces))]]
    first = rng.integers(0, 3, len(faces))
    return vertices[order], np.take_along_axis(turned, (first[:, None] + np.arange(3)) % 3, axis=1)


def random_turn(rng: np.random.Generator) -> Floats:
    """A random rotation matrix, uniform over all rotations."""
    four = rng.normal(size=4)
    a, b, c, d = (float(each) for each in four / np.linalg.norm(four))
    return np.array(_rotation(a, b, c, d))


def whole_turn(rng: np.random.Generator) -> tuple[Floats, int]:
    """An integer matrix that rotates and scales, and its scale. Exact for integer coordinates."""
    while True:
        a, b, c, d = (int(each) for each in rng.integers(-2, 3, 4))
        scale = a * a + b * b + c * c + d * d
        if 0 < scale <= 13:
            return np.array(_rotation(a, b, c, d), float), scale


def _rotation(a: float, b: float, c: float, d: float) -> list[list[float]]:
    """The rotation matrix of the quaternion a + bi + cj + dk, times its squared length."""
    return [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]


# Convex bodies.


@dataclass(frozen=True)
class Convex:
    """A convex body: the corners of each flat face in order, counterclockwise from outside."""

    faces: tuple[Floats, ...]

    def placed(self, turn: Floats, place: Floats) -> Convex:
        return Convex(tuple(face @ turn.T + place for face in self.faces))

    def planes(self) -> tuple[Floats, Floats]:
        """Outward unit normals and offsets. A point is inside if `normals @ point <= offsets`."""
        normals = []
        for face in self.faces:
            normal = np.cross(face, np.roll(face, -1, axis=0)).sum(axis=0)  # Newell's method
            normals.append(normal / np.linalg.norm(normal))
        offsets = [float((face @ normal).max()) for face, normal in zip(self.faces, normals, strict=True)]
        return np.array(normals), np.array(offsets)

    def corners(self) -> Floats:
        return np.concatenate(self.faces)

    def mesh(self) -> Mesh:
        """Each face as a fan of triangles. Equal corners are one vertex."""
        points, which = np.unique(self.corners(), axis=0, return_inverse=True)
        which = which.reshape(-1)
        triangles, start = [], 0
        for face in self.faces:
            own = which[start : start + len(face)]
            triangles += [[own[0], own[i], own[i + 1]] for i in range(1, len(face) - 1)]
            start += len(face)
        return points, np.array(triangles)


def box(low: Sequence[float] | Floats, high: Sequence[float] | Floats) -> Convex:
    ends = np.array([low, high], float)
    quads = [
        [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)],
        [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
        [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
        [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)],
        [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)],
        [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    ]
    axes = np.arange(3)
    return Convex(tuple(np.array([ends[which, axes] for which in quad]) for quad in np.array(quads)))


def frustum(sides: int, low_radius: float, high_radius: float, height: float, phase: float = 0.0) -> Convex:
    """A prism if both radii are equal, a pyramid if the upper one is 0. Centred on the origin."""
    angles = phase + 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(sides)], axis=1)
    low = low_radius * ring - [0, 0, height / 2]
    if high_radius == 0:
        tip = np.array([0, 0, height / 2])
        mantle = [np.array([low[i], low[(i + 1) % sides], tip]) for i in range(sides)]
        return Convex((low[::-1].copy(), *mantle))
    high = high_radius * ring + [0, 0, height / 2]
    walls = [np.array([low[i], low[j], high[j], high[i]]) for i in range(sides) for j in [(i + 1) % sides]]
    return Convex((low[::-1].copy(), high, *walls))


# Surfaces of revolution.


def revolved(outline: Sequence[tuple[float, float]], sides: int, phase: float = 0.0, is_ring: bool = False) -> Mesh:
    """Rotates an outline around z, in flat sides. outline: points (radius, z), upwards on the outside. The outline of a
    ring is closed; other outlines start and end on the axis (radius 0).
    """
    angles = phase + 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows: list[Floats] = []
    of_level: list[npt.NDArray[np.int64]] = []
    count = 0
    for radius, z in outline:
        if radius == 0:
            rows.append(np.array([[0, 0, z]], float))
            of_level.append(np.full(sides, count))
        else:
            rows.append(np.column_stack([radius * ring, np.full(sides, z)]))
            of_level.append(count + np.arange(sides))
        count += len(rows[-1])
    faces = []
    levels = len(outline)
    for level in range(levels if is_ring else levels - 1):
        a, d = of_level[level], of_level[(level + 1) % levels]
        b, c = np.roll(a, -1), np.roll(d, -1)
        if outline[level][0] > 0:
            faces.append(np.stack([a, b, c], axis=1))
        if outline[(level + 1) % levels][0] > 0:
            faces.append(np.stack([a, c, d], axis=1))
    return np.concatenate(rows), np.concatenate(faces)


def ball(radius: float, sides: int, stacks: int) -> Mesh:
    heights = -np.pi / 2 + np.pi * np.arange(1, stacks) / stacks
    middle = [(radius * float(np.cos(t)), radius * float(np.sin(t))) for t in heights]
    return revolved([(0.0, -radius), *middle, (0.0, radius)], sides)


def torus(radius: float, thickness: float, sides: int, around: int) -> Mesh:
    """radius: of the centre circle. thickness: radius of the tube, which has `around` sides."""
    angles = 2 * np.pi * np.arange(around) / around
    outline = [(radius + thickness * float(np.cos(t)), thickness * float(np.sin(t))) for t in angles]
    return revolved(outline, sides, is_ring=True)


def tube(inner: float, outer: float, low: float, high: float, sides: int) -> Mesh:
    return revolved([(inner, low), (outer, low), (outer, high), (inner, high)], sides, is_ring=True)


def sheet(low: Sequence[float], high: Sequence[float], z: float) -> Mesh:
    """A rectangle without thickness: an open part."""
    (a, b), (c, d) = low, high
    return np.array([[a, b, z], [c, b, z], [c, d, z], [a, d, z]], float), np.array([[0, 1, 2], [0, 2, 3]])


# Polycubes.


@dataclass(frozen=True)
class Polycube:
    """Cells of a lattice, and the coordinates of the lattice planes along each axis (integers for exact depths)."""

    cells: npt.NDArray[np.int64]
    planes: tuple[Floats, Floats, Floats]

    def ends(self) -> tuple[Floats, Floats]:
        """Lower and upper corners of each cell."""
        low = [self.planes[axis][self.cells[:, axis]] for axis in range(3)]
        high = [self.planes[axis][self.cells[:, axis] + 1] for axis in range(3)]
        return np.stack(low, axis=1), np.stack(high, axis=1)

    def squares(self) -> list[tuple[tuple[int, ...], int, int]]:
        """Cell, axis and side (0 lower, 1 upper) of each square of the boundary."""
        own = {tuple(cell) for cell in self.cells.tolist()}
        found = []
        for cell in sorted(own):
            for axis in range(3):
                for side in (0, 1):
                    beside = list(cell)
                    beside[axis] += 2 * side - 1
                    if tuple(beside) not in own:
                        found.append((cell, axis, side))
        return found

    def rectangles(self) -> tuple[Floats, Floats]:
        """Lower and upper corners of the squares of the boundary."""
        low, high = [], []
        for cell, axis, side in self.squares():
            ends = [[self.planes[i][cell[i]], self.planes[i][cell[i] + 1]] for i in range(3)]
            ends[axis] = [ends[axis][side]] * 2
            low.append([end[0] for end in ends])
            high.append([end[1] for end in ends])
        return np.array(low), np.array(high)

    def mesh(self, rng: np.random.Generator, cut: int = 1) -> Mesh:
        """Divides each square of the boundary into `cut` by `cut` squares of two triangles, with random diagonals."""
        squares = self.squares()
        keys: list[Faces] = []
        steps = np.arange(cut + 1)
        for cell, axis, side in squares:
            across, up = (axis + 1) % 3, (axis + 2) % 3
            key = np.empty((cut + 1, cut + 1, 3), np.int64)
            key[..., axis] = (cell[axis] + side) * cut
            key[..., across] = cell[across] * cut + steps[:, None]
            key[..., up] = cell[up] * cut + steps[None]
            i, j = (each.reshape(-1) for each in np.meshgrid(steps[:-1], steps[:-1], indexing="ij"))
            quad = np.stack([key[i, j], key[i + 1, j], key[i + 1, j + 1], key[i, j + 1]], axis=1)
            keys.append(quad if side else quad[:, ::-1])
        quads = np.concatenate(keys)
        points, which = np.unique(quads.reshape(-1, 3), axis=0, return_inverse=True)
        corners = which.reshape(-1, 4)
        other = rng.integers(0, 2, len(corners)) == 1
        corners[other] = np.roll(corners[other], 1, axis=1)
        faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
        vertices = np.empty(points.shape)
        for axis in range(3):
            plane = self.planes[axis]
            whole, part = np.divmod(points[:, axis], cut)
            after = np.minimum(whole + 1, len(plane) - 1)
            vertices[:, axis] = plane[whole] + (plane[after] - plane[whole]) * part / cut
        return vertices, faces

    def is_manifold(self) -> bool:
        """Whether exactly two boundary squares meet at each edge, and no vertex joins two bodies."""
        own = np.zeros(self.cells.max(axis=0) + 3, bool)
        own[tuple((self.cells + 1).T)] = True
        for axis in range(3):
            flat = np.moveaxis(own, axis, 2)
            a, b, c, d = flat[:-1, :-1], flat[1:, :-1], flat[:-1, 1:], flat[1:, 1:]
            if np.any((a & d & ~b & ~c) | (b & c & ~a & ~d)):
                return False
        # Two cells, or two gaps, that share only a corner.
        for flip in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            side = own[:, :: flip[0], :: flip[1]]
            eight = [
                side[i : -1 + i or None, j : -1 + j or None, k : -1 + k or None]
                for i in (0, 1)
                for j in (0, 1)
                for k in (0, 1)
            ]
            number = sum(each.astype(int) for each in eight)
            ends = eight[0].astype(int) + eight[7]
            if np.any((ends == 2) & (number == 2)) or np.any((ends == 0) & (number == 6)):
                return False
        return True


PATTERNS: dict[str, list[tuple[int, int, int]]] = {
    "cube": [(0, 0, 0)],
    "bar": [(i, 0, 0) for i in range(3)],
    "L": [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (0, 2, 0)],
    "U": [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)],
    "tee": [(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 1, 0), (1, 2, 0)],
    "cross": [(1, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 2, 0), (1, 1, 1)],
    "ring": [(i, j, 0) for i in range(3) for j in range(3) if (i, j) != (1, 1)],
    "plate": [(i, j, 0) for i in range(3) for j in range(2)],
    "stairs": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 1)],
    "hollow": [(i, j, k) for i in range(3) for j in range(3) for k in range(3) if (i, j, k) != (1, 1, 1)],
    "cup": [(i, j, k) for i in range(3) for j in range(3) for k in range(2) if (i, j, k) != (1, 1, 1)],
}


def pattern(rng: np.random.Generator, name: str | None = None) -> npt.NDArray[np.int64]:
    """The cells of a pattern with random axes and directions. name: None takes any pattern, or random cells."""
    if name is None:
        names = [*PATTERNS, "random"]
        name = names[int(rng.integers(len(names)))]
    cells = np.array(PATTERNS[name]) if name in PATTERNS else _grown(rng)
    cells = cells[:, rng.permutation(3)] * rng.choice([-1, 1], 3)
    moved: npt.NDArray[np.int64] = cells - cells.min(axis=0)
    return moved


def _grown(rng: np.random.Generator) -> npt.NDArray[np.int64]:
    while True:
        cells = [(0, 0, 0)]
        while len(cells) < 6:
            step = [0, 0, 0]
            step[int(rng.integers(3))] = int(rng.choice([-1, 1]))
            a, b, c = cells[int(rng.integers(len(cells)))]
            after = (a + step[0], b + step[1], c + step[2])
            if after not in cells:
                cells.append(after)
        found = np.array(cells)
        found -= found.min(axis=0)
        if Polycube(found, even_planes(found, 1.0)).is_manifold():
            return found


def even_planes(
    cells: npt.NDArray[np.int64], size: float, start: Sequence[float] | Floats = (0, 0, 0)
) -> tuple[Floats, Floats, Floats]:
    """Equally spaced lattice planes."""
    x, y, z = (start[axis] + size * np.arange(cells[:, axis].max() + 2) for axis in range(3))
    return x, y, z
