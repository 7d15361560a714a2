"""glTF 2.0, as .glb or .gltf: the scene graph as parts.

A node with a mesh is one part, so a mesh used by many nodes is as many parts. A vertex goes through the node transforms
in float64 as ((m00*x + m01*y) + m02*z) + m03, without fused multiply-add. Axes stay as in the file (y up by the
standard). Skins, morphs and animations are not played: the mesh is taken as it lies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feeler.io.gltf_document import Document
from feeler.io.limits import MAX_DEPTH, check_mesh
from feeler.io.raw import PathBook, Progress, RawMesh, clean_name, seal_indices
from feeler.io.units import parse_unit

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_IDENTITY = np.eye(4)
Matrix = NDArray[np.float64]


@dataclass
class _Mesh:
    """The triangles of one mesh in its own frame, all its primitives together."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]


class _Instance(NamedTuple):
    name: str
    path: str
    mesh: int
    world: Matrix


def read_gltf(path: Path, progress: Progress = None, *, edit: Callable[[Document], None] | None = None) -> RawMesh:
    """Read a .glb or .gltf file. The unit is the metre, by the standard. `edit` may change the document first."""
    document = Document(path)
    if edit is not None:
        edit(document)
    return _Reader(document).read(progress)


class _Reader:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.notes: list[str] = []
        self.skipped_primitives = 0
        self.left_over_corners = 0
        self.skinned = 0
        self.book = PathBook()
        self.instances: list[_Instance] = []
        self.sizes: dict[int, tuple[int, int]] = {}

    def read(self, progress: Progress) -> RawMesh:
        if progress:
            progress(0.0, f"reading {self.document.path.name}")
        self._collect_instances()
        meshes: dict[int, _Mesh] = {}
        bound = [self._bound(instance.mesh) for instance in self.instances]
        uses = np.bincount([instance.mesh for instance in self.instances] or [0])
        check_mesh(sum(b[0] for b in bound), sum(b[1] for b in bound), len(bound), str(self.document.path))
        vertices: list[NDArray[np.float64]] = []
        faces: list[NDArray[np.uint32]] = []
        names: list[str] = []
        paths: list[str] = []
        base = 0
        for number, instance in enumerate(self.instances):
            mesh = meshes.get(instance.mesh) or self._mesh(instance.mesh)
            if uses[instance.mesh] > 1:
                meshes[instance.mesh] = mesh
            if not len(mesh.faces):
                continue
            vertices.append(transform(mesh.vertices, instance.world))
            faces.append(shift_indices(mesh.faces, base, len(mesh.vertices)))
            base += len(mesh.vertices)
            names.append(instance.name)
            paths.append(instance.path)
            if progress and not number % 256:
                progress(0.1 + 0.7 * number / len(self.instances), f"reading {self.document.path.name}")
        self._add_notes()
        part_of_face = np.repeat(np.arange(len(faces), dtype=np.uint32), [len(f) for f in faces])
        return RawMesh(
            np.concatenate(vertices) if vertices else np.empty((0, 3)),
            np.concatenate(faces) if faces else np.empty((0, 3), dtype=np.uint32),
            part_of_face,
            names,
            paths,
            unit=parse_unit("m"),
            notes=self.notes,
        )

    # --- the scene graph -------------------------------------------------------------------------------------------

    def _collect_instances(self) -> None:
        """Walk the nodes, without recursion. The standard asks for trees: a node has one parent, and no cycle."""
        document = self.document
        nodes = document.root.get("nodes", [])
        if not isinstance(nodes, list):
            raise document.fail("'nodes' is no list")
        if not nodes:
            for index in range(len(document.root.get("meshes", []))):
                self._add_instance({}, index, "", _IDENTITY, f"mesh {index}")
            if self.instances:
                self.notes.append("the file has meshes and no scene: each mesh was taken once, where it lies")
            return
        stack: list[tuple[int, str, Matrix, int]] = [(root, "", _IDENTITY, 0) for root in reversed(self._roots(nodes))]
        seen = np.zeros(len(nodes), dtype=bool)
        while stack:
            index, above, world, depth = stack.pop()
            node = document.item("nodes", index)
            if seen[index]:
                raise document.fail(
                    f"nodes[{index}] is reached twice: the node graph has a cycle or a node with two parents"
                )
            seen[index] = True
            if depth > MAX_DEPTH:
                raise document.fail(f"the assembly is more than {MAX_DEPTH} levels deep", damaged=False)
            world = _multiply(world, self._local(node, index))
            children = _list(node.get("children"))
            path = above
            if "mesh" in node:
                path = self._add_instance(node, node["mesh"], above, world, f"node {index}")
            elif children:
                path = self.book.claim(above, clean_name(node.get("name"), f"node {index}"))
            stack.extend((child, path, world, depth + 1) for child in reversed(children))
        unused = sum(
            1 for index, node in enumerate(nodes) if not seen[index] and isinstance(node, dict) and "mesh" in node
        )
        if unused:
            self.notes.append(f"{unused:,} nodes with a mesh are not in the scene and were left out")

    def _roots(self, nodes: list[Any]) -> list[int]:
        document = self.document
        scenes = document.root.get("scenes")
        if scenes:
            chosen = document.root.get("scene", 0)
            if isinstance(scenes, list) and len(scenes) > 1:
                self.notes.append(f"the file has {len(scenes)} scenes; the default one was taken")
            roots = _list(document.item("scenes", chosen).get("nodes"))
        else:
            children = {
                c for node in nodes if isinstance(node, dict) for c in _list(node.get("children")) if isinstance(c, int)
            }
            roots = [index for index in range(len(nodes)) if index not in children]
            if not roots:
                raise document.fail("no node is a root: the node graph is a cycle")
        for root in roots:
            document.item("nodes", root)
        return roots

    def _add_instance(self, node: dict[str, Any], mesh: Any, above: str, world: Matrix, default: str) -> str:
        document = self.document
        name = clean_name(node.get("name"), "") or clean_name(document.item("meshes", mesh).get("name"), default)
        path = self.book.claim(above, name)
        self.skinned += "skin" in node
        extensions = node.get("extensions")
        spread = extensions.get("EXT_mesh_gpu_instancing") if isinstance(extensions, dict) else None
        if spread is None:
            self.instances.append(_Instance(name, path, mesh, world))
            return path
        for local in self._spread(spread):
            self.instances.append(_Instance(name, self.book.claim(path, name), mesh, _multiply(world, local)))
        return path

    def _spread(self, extension: Any) -> list[Matrix]:
        """Return the transforms of EXT_mesh_gpu_instancing."""
        attributes = extension.get("attributes", {})
        counts = {self.document.count(index) for index in attributes.values()}
        if len(counts) != 1:
            raise self.document.fail("EXT_mesh_gpu_instancing has attributes of different length, or none")
        count = counts.pop()
        check_mesh(0, 0, count, str(self.document.path))
        columns = {}
        for key, width, default in (
            ("TRANSLATION", 3, (0, 0, 0)),
            ("ROTATION", 4, (0, 0, 0, 1)),
            ("SCALE", 3, (1, 1, 1)),
        ):
            given = key in attributes
            columns[key] = (
                self.document.array(attributes[key], width) if given else np.broadcast_to(default, (count, width))
            )
        rows = zip(*(columns[key].tolist() for key in ("TRANSLATION", "ROTATION", "SCALE")), strict=True)
        return [_compose(t, r, s) for t, r, s in rows]

    def _local(self, node: dict[str, Any], index: int) -> Matrix:
        """Return the transform of a node, column-major `matrix` or translation * rotation * scale."""

        def numbers(key: str, count: int) -> list[float] | None:
            value = node.get(key)
            if value is None:
                return None
            if not isinstance(value, list) or len(value) != count or not all(type(v) in (int, float) for v in value):
                raise self.document.fail(f"nodes[{index}].{key} should be {count} numbers")
            return [float(v) for v in value]

        matrix = numbers("matrix", 16)
        if matrix is not None:
            if matrix[3::4] != [0.0, 0.0, 0.0, 1.0]:
                raise self.document.fail(f"nodes[{index}].matrix is no affine transform")
            return np.array([matrix[row::4] for row in range(4)])  # column by column
        move, turn, scale = numbers("translation", 3), numbers("rotation", 4), numbers("scale", 3)
        if move is None and turn is None and scale is None:
            return _IDENTITY
        return _compose(move or [0.0, 0.0, 0.0], turn or [0.0, 0.0, 0.0, 1.0], scale or [1.0, 1.0, 1.0])

    # --- meshes ----------------------------------------------------------------------------------------------------

    def _primitives(self, mesh: int) -> list[dict[str, Any]]:
        found = _list(self.document.item("meshes", mesh).get("primitives"))
        if not all(isinstance(p, dict) and isinstance(p.get("attributes"), dict) for p in found):
            raise self.document.fail(f"meshes[{mesh}] has a primitive without attributes")
        return found

    def _bound(self, mesh: int) -> tuple[int, int]:
        """Return the most vertices and triangles the mesh can have, from counts alone: nothing is read yet."""
        if mesh not in self.sizes:
            vertices = triangles = 0
            for primitive in self._primitives(mesh):
                if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                    continue
                corners = self.document.count(primitive["attributes"].get("POSITION"))
                if "indices" in primitive:
                    indices = self.document.count(primitive["indices"])
                    corners = min(corners, indices)
                else:
                    indices = corners
                vertices += corners
                triangles += indices // 3 if primitive.get("mode", _TRIANGLES) == _TRIANGLES else max(indices - 2, 0)
            self.sizes[mesh] = (vertices, triangles)
        return self.sizes[mesh]

    def _mesh(self, index: int) -> _Mesh:
        vertices: list[NDArray[np.float64]] = []
        faces: list[NDArray[np.uint32]] = []
        base = 0
        for primitive in self._primitives(index):
            mode = primitive.get("mode", _TRIANGLES)
            if mode not in (_TRIANGLES, _STRIP, _FAN):
                self.skipped_primitives += 1
                continue
            extensions = primitive.get("extensions")
            if isinstance(extensions, dict) and "KHR_draco_mesh_compression" in extensions:
                accessor = self.document.item("accessors", primitive["attributes"].get("POSITION"))
                if "bufferView" not in accessor:
                    raise self.document.compressed("Draco")
            points = self.document.array(primitive["attributes"].get("POSITION"), 3)
            triangles = self._triangles(primitive, mode, len(points))
            if len(points) > triangles.size:
                # Exporters let many primitives share one accessor: take what this one uses.
                points, triangles = _used_only(points, triangles)
            vertices.append(points.astype(np.float64))
            faces.append(shift_indices(triangles, base, len(points)))
            base += len(points)
        if len(faces) == 1:
            return _Mesh(vertices[0], faces[0])
        if not faces:
            return _Mesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.uint32))
        return _Mesh(np.concatenate(vertices), np.concatenate(faces))

    def _triangles(self, primitive: dict[str, Any], mode: int, point_count: int) -> NDArray[np.uint32]:
        if "indices" in primitive:
            corners = self.document.array(primitive["indices"], 1)
            if corners.dtype.kind != "u":
                raise self.document.fail("indices are not unsigned integers")
            corners = seal_indices(corners, point_count)
        else:
            corners = np.arange(point_count, dtype=np.uint32)
        if mode == _TRIANGLES:
            spare = len(corners) % 3
            self.left_over_corners += spare
            return corners[: len(corners) - spare].reshape(-1, 3)
        if len(corners) < 3:
            return np.empty((0, 3), dtype=np.uint32)
        if mode == _FAN:
            return np.stack([corners[1:-1], corners[2:], np.broadcast_to(corners[0], len(corners) - 2)], axis=1)
        strip = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
        strip[1::2, 1:] = strip[1::2, 2:0:-1]  # every second one is turned, to keep its side
        return strip

    def _add_notes(self) -> None:
        if self.skipped_primitives:
            self.notes.append(
                f"{self.skipped_primitives:,} primitives of points or lines were skipped: only triangles collide"
            )
        if self.left_over_corners:
            self.notes.append(f"{self.left_over_corners:,} indices at the end of primitives make no whole triangle")
        if self.skinned:
            self.notes.append(f"{self.skinned:,} skinned meshes were taken as they lie, without their skeleton")
        if self.document.root.get("animations"):
            self.notes.append("animations were not played: parts lie where the scene puts them")


def transform(points: NDArray[np.float64], matrix: Matrix) -> NDArray[np.float64]:
    """Return points (n, 3) through an affine matrix, in the module's order. No BLAS: it may fuse and reorder."""
    if np.array_equal(matrix, _IDENTITY):
        return points
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    moved = np.empty_like(points)
    with np.errstate(all="ignore"):
        for row in range(3):
            a, b, c, d = matrix[row].tolist()
            column = a * x
            column += b * y
            column += c * z
            column += d
            moved[:, row] = column
    return moved


def shift_indices(faces: NDArray[np.uint32], base: int, vertex_count: int) -> NDArray[np.uint32]:
    """Return the faces with `base` added to each index, `OUT_OF_RANGE` kept."""
    if not base or not faces.size:
        return faces
    if int(faces.max()) < vertex_count:
        shifted: NDArray[np.uint32] = faces + np.uint32(base)
        return shifted
    return np.where(faces < vertex_count, faces + np.uint32(base), faces)


def _used_only(points: NDArray[Any], faces: NDArray[np.uint32]) -> tuple[NDArray[Any], NDArray[np.uint32]]:
    used = np.unique(faces)
    used = used[used < len(points)]
    place = np.searchsorted(used, faces).astype(np.uint32)
    return points[used], np.where(faces < len(points), place, faces)


def _compose(move: list[float], turn: list[float], scale: list[float]) -> Matrix:
    x, y, z, w = turn
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(scale)
    matrix[:3, 3] = move
    return matrix


def _multiply(a: Matrix, b: Matrix) -> Matrix:
    if a is _IDENTITY:
        return b
    if b is _IDENTITY:
        return a
    with np.errstate(all="ignore"):
        product: Matrix = ((a[:, 0:1] * b[0] + a[:, 1:2] * b[1]) + a[:, 2:3] * b[2]) + a[:, 3:4] * b[3]
    return product


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
