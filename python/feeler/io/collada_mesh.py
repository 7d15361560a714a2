"""The geometries of a COLLADA file as triangles in their own frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feeler.io.collada_document import Document, Element
from feeler.io.placing import shift_indices
from feeler.io.polygons import CROSSING, bridged, triangulate
from feeler.io.raw import clean_name, seal_indices
from feeler.io.tally import Tally

_POLYGONS = ("triangles", "polylist", "polygons", "tristrips", "trifans")
_LINES = {"lines": "lines", "linestrips": "line strips"}


class Mesh(NamedTuple):
    """The triangles of one geometry, all its primitives together."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]


_MISCOUNTED = (
    "primitives hold another number of polygons than they say: all that is there was read; if some are missing, \
export the file again"
)


class MeshReader:
    """Reads geometries on demand, each once, and counts primitives without triangles."""

    def __init__(self, document: Document, tally: Tally) -> None:
        self.document = document
        self.tally = tally
        self._meshes: dict[int, Mesh] = {}

    def read(self, geometry: Element) -> Mesh:
        """Return the triangles of a <geometry>."""
        key = id(geometry)
        if key not in self._meshes:
            self._meshes[key] = self._read(geometry)
        return self._meshes[key]

    def is_read(self, geometry: Element) -> bool:
        """Whether anything in the scene uses a <geometry>."""
        return id(geometry) in self._meshes

    def vertices(self) -> NDArray[np.float64]:
        """Those of all geometries that were read, `(n, 3)`."""
        return np.concatenate([np.empty((0, 3)), *(mesh.vertices for mesh in self._meshes.values())])

    def _read(self, geometry: Element) -> Mesh:
        name = name_of(geometry, "geometry")
        mesh = geometry.first("mesh") or geometry.first("convex_mesh")
        for other in geometry.all("spline", "brep"):
            self.tally.add(f"geometries of the kind '{other.tag}' were left out: only triangles collide", name)
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.uint32)]
        sources: dict[int, int] = {}  # a source of positions -> the first vertex of it here
        base = 0
        if mesh is not None and "convex_hull_of" in mesh.attributes:
            self.tally.add("convex hulls of other geometries were left out", name)
        for primitive in mesh.children if mesh is not None else ():
            if primitive.tag in _LINES:
                self.tally.add(f"primitives of {_LINES[primitive.tag]} were left out: only triangles collide", name)
            if primitive.tag not in _POLYGONS:
                continue
            if not primitive.all("p", "ph"):
                continue  # an empty one, as exporters write for a material that is not used
            source, offset, stride = self._positions(mesh, primitive)
            if id(source) not in sources:
                sources[id(source)] = base
                vertices.append(self.document.points(source))
                base += len(vertices[-1])
            first = sources[id(source)]
            points = vertices[1 + list(sources).index(id(source))]
            corners, sizes = self._polygons(primitive, offset, stride, points, name)
            self._check_count(primitive, len(sizes), name)
            made = triangulate(corners, sizes, points)
            if made.cut:
                self.tally.add("polygons with more than three corners were cut into triangles", name, made.cut)
            if made.thin:
                self.tally.add("polygons with fewer than three corners have no triangle", name, made.thin)
            if made.rough:
                self.tally.add(CROSSING, name, made.rough, is_doubtful=True)
            faces.append(shift_indices(seal_indices(made.faces, len(points)), first, len(points)))
        return Mesh(np.concatenate(vertices), np.concatenate(faces))

    def _positions(self, mesh: Element | None, primitive: Element) -> tuple[Element, int, int]:
        """Return (source of the positions, their offset within a corner's indices, indices of each corner)."""
        document = self.document
        inputs = primitive.all("input")
        stride = 1 + max((document.natural(entry, "offset", 0) for entry in inputs), default=0)
        for entry in inputs:
            meaning = entry.attributes.get("semantic")
            if meaning not in ("VERTEX", "POSITION"):
                continue
            target = document.find(entry.attributes.get("source"), "vertices", "source")
            if target is not None and target.tag == "vertices":
                shared = [i for i in target.all("input") if i.attributes.get("semantic") == "POSITION"]
                target = document.find(shared[0].attributes.get("source"), "source") if shared else None
            if target is None:
                raise document.fail(f"<{primitive.tag}> has positions that are not in the file", primitive)
            return target, document.natural(entry, "offset", 0), stride
        raise document.fail(f"<{primitive.tag}> has no input for positions", primitive)

    def _polygons(
        self, primitive: Element, offset: int, stride: int, points: NDArray[np.float64], name: str
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the polygons of a primitive: all corners in a row, and the number of corners of each."""
        lists = [self._corners(p, offset, stride, name) for p in primitive.all("p")]
        if primitive.tag == "polylist":
            count = primitive.first("vcount")
            corners = np.concatenate(lists)
            sizes = self.document.integers(count) if count is not None else np.empty(0, dtype=np.int64)
            if (sizes < 0).any() or int(sizes.sum()) > len(corners):
                raise self.document.fail(
                    f"<polylist> promises {int(sizes.sum()):,} corners and has {len(corners):,}: it is damaged",
                    primitive,
                )
            if int(sizes.sum()) < len(corners):
                self._add_spare(len(corners) - int(sizes.sum()), name)
            return corners, sizes
        if primitive.tag == "polygons":
            for holed in primitive.all("ph"):
                outline = [self._corners(p, offset, stride, name) for p in holed.all("p")]
                holes = [self._corners(h, offset, stride, name) for h in holed.all("h")]
                if outline:
                    self.tally.add("polygons with holes were cut along a line to each hole", name)
                    lists.append(bridged(outline[0], holes, points))
            return _row(lists), np.array([len(one) for one in lists], dtype=np.int64)
        if primitive.tag == "triangles":
            corners = np.concatenate(lists)
            spare = len(corners) % 3
        elif primitive.tag == "tristrips":
            corners, spare = _row([_strip(one) for one in lists]), sum(len(one) for one in lists if len(one) < 3)
        else:
            corners, spare = _row([_fan(one) for one in lists]), sum(len(one) for one in lists if len(one) < 3)
        if spare:
            self._add_spare(spare, name)
        return corners, np.full(len(corners) // 3, 3, dtype=np.int64)

    def _check_count(self, primitive: Element, found: int, name: str) -> None:
        """Count a primitive that holds more or less than it says."""
        if primitive.tag in ("tristrips", "trifans"):
            found = len(primitive.all("p"))
        said = primitive.attributes.get("count", "").strip()
        # Compared as text: Python reads no number of thousands of digits.
        if said.isascii() and said.isdigit() and (said.lstrip("0") or "0") != str(found):
            self.tally.add(_MISCOUNTED, name, is_doubtful=True)

    def _corners(self, element: Element, offset: int, stride: int, name: str) -> NDArray[np.int64]:
        """Return the index of the position of each corner of a <p> or <h>."""
        numbers = self.document.integers(element)
        spare = len(numbers) % stride
        if spare:
            self._add_spare(spare, name)
        if len(numbers) < stride:
            return np.empty(0, dtype=np.int64)
        return numbers[: len(numbers) - spare].reshape(-1, stride)[:, offset]

    def _add_spare(self, count: int, name: str) -> None:
        self.tally.add("indices at the end of primitives make no whole triangle", name, count)


def name_of(element: Element, default: str) -> str:
    """Return the name of an element, or else its id."""
    return clean_name(element.attributes.get("name"), "") or clean_name(element.attributes.get("id"), default)


def _row(lists: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    return np.concatenate([np.empty(0, dtype=np.int64), *lists])


def _strip(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the triangles of a strip, three corners each; every second one is reversed to keep its side."""
    if len(corners) < 3:
        return np.empty(0, dtype=np.int64)
    triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles.reshape(-1)


def _fan(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the triangles of a fan, three corners each."""
    if len(corners) < 3:
        return np.empty(0, dtype=np.int64)
    first = np.broadcast_to(corners[0], len(corners) - 2)
    return np.stack([first, corners[1:-1], corners[2:]], axis=1).reshape(-1)
