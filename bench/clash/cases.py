"""The hard pairs of testdata/clash as meshes, and their true results: for boxes by rational arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from contacts import Floats, Mesh, joined

import feeler

FAR_M = 3000.0
CUTS = (1, 2, 4, 16)
"""Squares along each edge of a box's faces: 12, 48, 192 and 3,072 triangles."""


@dataclass(frozen=True)
class Case:
    """One line of the file. figure: depth or gap, metres; None where none is stated."""

    name: str
    parts: tuple[str, str]
    verdict: str
    figure: float | None

    @property
    def is_boxes(self) -> bool:
        return all(part.startswith("box ") for part in self.parts)

    def mockup(self, offset: float = 0.0, cuts: tuple[int, int] = (1, 1)) -> feeler.Mockup:
        """Both parts, shifted along all three axes."""
        meshes = [mesh_of(part, cut) for part, cut in zip(self.parts, cuts, strict=True)]
        vertices, faces = joined(*meshes)
        return feeler.Mockup(
            vertices + offset, faces, np.repeat([0, 1], [len(faces) for _, faces in meshes]), ["first", "second"]
        )


def cases(testdata: Path) -> list[Case]:
    found = []
    for line in (testdata / "clash" / "cases.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            name, one, other, verdict, figure = (word.strip() for word in line.split("|"))
            found.append(Case(name, (one, other), verdict, None if figure == "-" else float(figure)))
    return found


def rational(mockup: feeler.Mockup) -> tuple[str, float]:
    """The verdict on two boxes and its figure, by their corners as they are, without rounding."""
    corners = mockup.vertices[mockup.faces]
    low, high = (
        [
            [Fraction(x) for x in end(corners[mockup.part_of_face == part].reshape(-1, 3), axis=0).tolist()]
            for part in (0, 1)
        ]
        for end in (np.min, np.max)
    )
    apart = [max(low[1][i] - high[0][i], low[0][i] - high[1][i], Fraction(0)) for i in range(3)]
    if any(apart):
        square = sum(each * each for each in apart)
        return ("clearance" if square <= Fraction(0.002) ** 2 else "none"), float(square) ** 0.5
    if min(min(high[0][i] - low[1][i], high[1][i] - low[0][i]) for i in range(3)) == 0:
        return "contact", 0.0
    if low[0] == low[1] and high[0] == high[1]:
        return "duplicate", 0.0
    deep = float(max(depth_of_faces(low, high, one, 1 - one) for one in (0, 1)))
    for one, other in ((0, 1), (1, 0)):
        if all(low[one][i] <= low[other][i] and high[other][i] <= high[one][i] for i in range(3)):
            return "contained", deep
    return "clash", deep


def depth_of_faces(low: list[list[Fraction]], high: list[list[Fraction]], one: int, other: int) -> Fraction:
    """The farthest that a point on the faces of one box lies inside the other.

    A point's distance to the other's surface is the least over the axes of its distance to the two sides. On a face,
    the coordinate along one axis is given; along the others, the point nearest to the middle of the other box is best.
    """
    deepest = Fraction(0)
    for axis in range(3):
        for side in (low[one][axis], high[one][axis]):
            least = []
            for i in range(3):
                begin, end = low[other][i], high[other][i]
                near, far = (side, side) if i == axis else (max(low[one][i], begin), min(high[one][i], end))
                best = min(max((begin + end) / 2, near), far)
                least.append(min(best - begin, end - best))
            deepest = max(deepest, min(least))
    return deepest


def mesh_of(text: str, cut: int = 1) -> Mesh:
    kind, *words = text.split()
    numbers = [float(word) for word in words]
    if kind == "box":
        return cut_box(numbers[:3], numbers[3:], cut)
    if kind == "sheet":
        x, y, far_x, far_y, z = numbers
        return np.array([[x, y, z], [far_x, y, z], [far_x, far_y, z], [x, far_y, z]]), np.array([[0, 1, 2], [0, 2, 3]])
    sides = int(numbers[0])
    if kind == "pin":
        radius, low, high = numbers[1:]
        return turned(sides, [(0, low), (radius, low), (radius, high), (0, high)])
    if kind == "bore":
        radius, outer, low, high = numbers[1:]
        return turned(sides, [(radius, low), (outer, low), (outer, high), (radius, high), (radius, low)])
    if kind == "bolt":
        root, crest, pitch, low, high = numbers[1:]
        ridges = profile(root, crest, pitch, low, high)
        return turned(sides, [(0, low), *ridges, (0, high)])
    assert kind == "nut", text
    root, crest, outer, pitch, low, high = numbers[1:]
    ridges = profile(root, crest, pitch, low, high)
    return turned(sides, [ridges[0], (outer, low), (outer, high), *reversed(ridges)])


def profile(root: float, crest: float, pitch: float, low: float, high: float) -> list[tuple[float, float]]:
    """Root and crest in turn every half pitch; heights are counted from z = 0, so that those of two parts agree."""
    first, last = round(2 * low / pitch), round(2 * high / pitch)
    return [(crest if step % 2 else root, step * (pitch / 2)) for step in range(first, last + 1)]


def turned(sides: int, outline: list[tuple[float, float]]) -> Mesh:
    """A surface of revolution of that many flat sides, wound outwards for an outline that goes up on the outside.

    Corners that are at the same place in two parts have the same coordinates to the last bit.
    """
    angles = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows: list[Floats] = [np.column_stack([radius * ring, np.full(sides, z)]) for radius, z in outline]
    faces = []
    for level in range(len(outline) - 1):
        for side in range(sides):
            after = (side + 1) % sides
            a, b = level * sides + side, level * sides + after
            c, d = a + sides, b + sides
            # The same diagonal whichever way the outline goes, so that a bolt and its nut have the same triangles.
            is_up = outline[level][1] <= outline[level + 1][1]
            if outline[level][0] > 0:
                faces.append([a, b, d] if is_up else [a, b, c])
            if outline[level + 1][0] > 0:
                faces.append([a, d, c] if is_up else [b, d, c])
    return np.concatenate(rows), np.array(faces)


def cut_box(low: list[float], high: list[float], cut: int) -> Mesh:
    """A box whose faces are squares of two triangles each, wound outwards."""
    ends = np.array([low, high])
    meshes = []
    for axis in range(3):
        across, up = (axis + 1) % 3, (axis + 2) % 3
        steps = np.arange(cut + 1) / cut
        for side in (0, 1):
            # The last of a row is the corner itself: sums of shares may miss it by a bit.
            rows = [
                np.where(steps == 1.0, ends[1, i], ends[0, i] + (ends[1, i] - ends[0, i]) * steps) for i in (across, up)
            ]
            points = np.empty((cut + 1, cut + 1, 3))
            points[..., axis] = ends[side, axis]
            points[..., across], points[..., up] = rows[0][:, None], rows[1][None]
            first = (np.arange(cut)[:, None] * (cut + 1) + np.arange(cut)).reshape(-1)
            quads = np.stack([first, first + cut + 1, first + cut + 2, first + 1], axis=1)
            faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
            meshes.append((points.reshape(-1, 3), faces if side else faces[:, ::-1]))
    return joined(*meshes)
