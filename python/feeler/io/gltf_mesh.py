"""The meshes of a glTF file as triangles in their own frame, at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feeler.io.gltf_deform import influences, morphed
from feeler.io.gltf_document import Document
from feeler.io.gltf_draco import DRACO, Unpacked, unpack
from feeler.io.gltf_nodes import Shape
from feeler.io.placing import shift_indices
from feeler.io.raw import seal_indices
from feeler.io.rounding import single
from feeler.io.tally import Tally

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_MODES = {0: "points", 1: "lines", 2: "line loops", 3: "line strips"}


@dataclass(eq=False)
class Mesh:
    """The triangles of one mesh, all its primitives together; joints and weights (n, k) if it has a skin.

    rounding: the largest error of a coordinate, metres.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]
    joints: NDArray[Any] | None = None
    weights: NDArray[Any] | None = None
    rounding: float = 0.0


class MeshReader:
    """Reads meshes on demand, and counts primitives without triangles."""

    def __init__(self, document: Document, tally: Tally) -> None:
        self.document = document
        self.tally = tally
        self._sizes: dict[int, tuple[int, int]] = {}
        self._counted: set[int] = set()

    def bound(self, mesh: int) -> tuple[int, int]:
        """Return the most vertices and triangles the mesh can have, from counts alone, before reading."""
        if mesh not in self._sizes:
            vertices = triangles = 0
            for primitive in self._primitives(mesh):
                mode = primitive.get("mode", _TRIANGLES)
                if mode not in (_TRIANGLES, _STRIP, _FAN):
                    continue
                corners = self.document.count(primitive["attributes"].get("POSITION"))
                if "indices" in primitive:
                    indices = self.document.count(primitive["indices"])
                    if not _packed(primitive):
                        corners = min(corners, indices)
                else:
                    indices = corners
                vertices += corners
                triangles += indices // 3 if mode == _TRIANGLES else max(indices - 2, 0)
            self._sizes[mesh] = (vertices, triangles)
        return self._sizes[mesh]

    def read(self, shape: Shape, name: str) -> Mesh:
        """Read the mesh of a part called `name`."""
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.uint32)]
        carried: list[tuple[NDArray[Any], NDArray[Any]] | None] = []
        first = shape.mesh not in self._counted
        self._counted.add(shape.mesh)
        weights = self._weights(shape, name)
        base = 0
        for number, primitive in enumerate(self._primitives(shape.mesh)):
            mode = primitive.get("mode", _TRIANGLES)
            if mode not in (_TRIANGLES, _STRIP, _FAN):
                if first:
                    kind = _MODES.get(mode if isinstance(mode, int) else -1, "an unknown mode")
                    self.tally.add(f"primitives of {kind} were left out: only triangles collide", name)
                continue
            where = f"meshes[{shape.mesh}].primitives[{number}]"
            packed = self._unpacked(primitive, where)
            attributes = primitive["attributes"]
            if packed:
                points = packed.attribute(self.document, "POSITION", 3, where).astype(np.float64)
                triangles = packed.faces
            else:
                points = self.document.array(attributes.get("POSITION"), 3)
                triangles = self._triangles(primitive, mode, len(points), name if first else None)
            if targets := primitive.get("targets"):
                points = morphed(self.document, points.astype(np.float64), targets, weights)
            rows = None
            if shape.skin is not None:
                source = packed.as_attributes(self.document, where) if packed else attributes
                rows = influences(self.document, source, len(points))
            if len(points) > triangles.size:
                # Exporters let many primitives share one accessor: take only the used vertices.
                used, triangles = _used_only(len(points), triangles)
                points = points[used]
                rows = rows and (rows[0][used], rows[1][used])
            vertices.append(points.astype(np.float64, copy=False))
            faces.append(shift_indices(triangles, base, len(points)))
            carried.append(rows)
            base += len(points)
        # A single primitive, the usual case, is not copied.
        mesh = Mesh(vertices[1], faces[1]) if len(faces) == 2 else Mesh(np.concatenate(vertices), np.concatenate(faces))
        mesh.rounding = single(mesh.vertices)
        if shape.skin is not None and any(carried):
            mesh.joints, mesh.weights = _joined(carried, [len(points) for points in vertices[1:]])
        return mesh

    def _weights(self, shape: Shape, name: str) -> tuple[float, ...]:
        """Return the weights of the morph targets: from the node, or else from the mesh, or else 0."""
        targets = max((len(_list(p.get("targets"))) for p in self._primitives(shape.mesh)), default=0)
        if not targets:
            return ()
        weights = shape.weights
        if weights is None:
            given = self.document.item("meshes", shape.mesh).get("weights", [])
            weights = tuple(self.document.numbers(given, f"meshes[{shape.mesh}].weights"))
        if len(weights) not in (0, targets):
            self.tally.add("meshes have more or fewer weights than morph targets: those missing were taken as 0", name)
        self.tally.add("meshes have morph targets: taken at rest, with the weights that the file gives", name)
        return weights

    def _primitives(self, mesh: int) -> list[dict[str, Any]]:
        found = _list(self.document.item("meshes", mesh).get("primitives"))
        if not all(isinstance(p, dict) and isinstance(p.get("attributes"), dict) for p in found):
            raise self.document.fail(f"meshes[{mesh}] has a primitive without attributes")
        return found

    def _unpacked(self, primitive: dict[str, Any], where: str) -> Unpacked | None:
        """Return the data packed by Draco, or None if there are plain accessors."""
        if not _packed(primitive):
            return None
        accessor = self.document.item("accessors", primitive["attributes"].get("POSITION"))
        indices = self.document.item("accessors", primitive["indices"]) if "indices" in primitive else accessor
        plain = all("bufferView" in a or "sparse" in a for a in (accessor, indices))
        if plain and DRACO not in self.document.required:
            return None
        return unpack(self.document, primitive, where)

    def _triangles(
        self, primitive: dict[str, Any], mode: int, point_count: int, name: str | None
    ) -> NDArray[np.uint32]:
        if "indices" in primitive:
            corners = self.document.array(primitive["indices"], 1)
            if corners.dtype.kind != "u":
                raise self.document.fail("indices are not unsigned integers")
            corners = seal_indices(corners, point_count)
        else:
            corners = np.arange(point_count, dtype=np.uint32)
        spare = len(corners) % 3 if mode == _TRIANGLES else len(corners) if len(corners) < 3 else 0
        if spare and name is not None:
            self.tally.add("indices at the end of primitives make no whole triangle", name, spare)
        if mode == _TRIANGLES:
            return corners[: len(corners) - spare].reshape(-1, 3)
        if spare:
            return np.empty((0, 3), dtype=np.uint32)
        if mode == _FAN:
            return np.stack([corners[1:-1], corners[2:], np.broadcast_to(corners[0], len(corners) - 2)], axis=1)
        strip = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
        strip[1::2, 1:] = strip[1::2, 2:0:-1]  # every second one is reversed to keep its side
        return strip


def _used_only(count: int, faces: NDArray[np.uint32]) -> tuple[NDArray[Any], NDArray[np.uint32]]:
    """Return (used vertices, faces with indices into those)."""
    used = np.unique(faces)
    used = used[used < count]
    place = np.searchsorted(used, faces).astype(np.uint32)
    return used, np.where(faces < count, place, faces)


def _joined(
    carried: list[tuple[NDArray[Any], NDArray[Any]] | None], counts: list[int]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the joints and weights of all primitives; joint -1 marks a vertex without any."""
    width = max(rows[0].shape[1] for rows in carried if rows)
    joints = [np.full((count, width), -1, dtype=np.int64) for count in counts]
    weights = [np.zeros((count, width)) for count in counts]
    for joint, weight, rows in zip(joints, weights, carried, strict=True):
        if rows:
            joint[:] = 0
            joint[:, : rows[0].shape[1]] = rows[0]
            weight[:, : rows[1].shape[1]] = rows[1]
    return np.concatenate(joints), np.concatenate(weights)


def _packed(primitive: dict[str, Any]) -> bool:
    extensions = primitive.get("extensions")
    return isinstance(extensions, dict) and DRACO in extensions


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
