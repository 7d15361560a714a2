"""The scene graph of a glTF file: the place and name of each mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from feeler.io.gltf_document import Document
from feeler.io.limits import MAX_DEPTH, MAX_PARTS, check_mesh
from feeler.io.placing import IDENTITY, Matrix, multiply
from feeler.io.raw import PathBook, clean_name
from feeler.io.rounding import PlacementErrors
from feeler.io.tally import Tally

_OUTSIDE = "nodes with a mesh are not in the scene and were left out"
_UNUSED = "meshes are in no node and were left out"
_HIDDEN = "hidden parts (KHR_node_visibility) were left out"
_TWICE = "nodes are placed twice, by a matrix and by other numbers that differ: the matrix was used"
_SAME = 1e-5
"""How far numbers of two placements differ that are meant to be equal: a float32 each, rounded more than once."""


@dataclass(frozen=True)
class Shape:
    """A mesh as a node uses it, shared by all nodes that do not change it. `weights` None: the mesh's own."""

    mesh: int
    weights: tuple[float, ...] | None = None
    skin: int | None = None


class Instance(NamedTuple):
    """One part."""

    name: str
    path: str
    shape: Shape
    world: Matrix
    node: int = -1
    """Its number; -1: the mesh is in no node."""
    row: int = -1
    """Of its transform in the errors of placements; -1: it has none."""


class _Local(NamedTuple):
    """The transform of a node, and the quaternion and scale that it is made of, if it is."""

    matrix: Matrix
    turn: list[float] | None
    scale: list[float] = [1.0, 1.0, 1.0]  # noqa: RUF012


class _Open(NamedTuple):
    """A node still to be visited."""

    node: int
    above: str
    world: Matrix
    depth: int
    hidden: bool
    row: int


class SceneGraph:
    """Walks the nodes of the default scene; `instances` has the parts, `worlds` the transforms of all visited nodes."""

    def __init__(self, document: Document, tally: Tally) -> None:
        self.document = document
        self.tally = tally
        self.notes: list[str] = []
        self.instances: list[Instance] = []
        self.worlds: dict[int, Matrix] = {}
        self.errors = PlacementErrors()
        self._book = PathBook()
        nodes = document.root.get("nodes", [])
        if not isinstance(nodes, list):
            raise document.fail("'nodes' is not a list")
        if nodes:
            self._walk(nodes)
            return
        for index in range(len(document.root.get("meshes", []))):
            self._add_instance({}, index, "", IDENTITY, f"mesh {index}", -1, -1)
        if self.instances:
            self.notes.append("the file has meshes and no scene: each mesh was taken once, where it lies")

    def _walk(self, nodes: list[Any]) -> None:
        """Visit every node, without recursion. The standard requires trees: one parent per node, and no cycle."""
        document = self.document
        stack = [_Open(root, "", IDENTITY, 0, False, -1) for root in reversed(self._roots(nodes))]
        seen = np.zeros(len(nodes), dtype=bool)
        while stack:
            index, above, world, depth, hidden, row = stack.pop()
            node = document.item("nodes", index)
            if seen[index]:
                raise document.fail(
                    f"nodes[{index}] is reached twice: the node graph has a cycle or a node with two parents"
                )
            seen[index] = True
            if depth > MAX_DEPTH:
                raise document.fail(f"the assembly is more than {MAX_DEPTH} levels deep", damaged=False)
            local, turn, scale = self._local(node, index)
            row = row if local is IDENTITY else self.errors.add(row, local, turn, scale)
            world = multiply(world, local)
            self.worlds[index] = world
            hidden = hidden or _extension(node, "KHR_node_visibility").get("visible") is False
            children = _list(node.get("children"))
            path = above
            if "mesh" in node and hidden:
                self.tally.add(_HIDDEN, self._name(node, node["mesh"], f"node {index}"))
            elif "mesh" in node:
                path = self._add_instance(node, node["mesh"], above, world, f"node {index}", index, row)
            elif children and not hidden:
                path = self._book.claim(above, clean_name(node.get("name"), f"node {index}"))
            stack.extend(_Open(child, path, world, depth + 1, hidden, row) for child in reversed(children))
        for index, node in enumerate(nodes):
            if not seen[index] and isinstance(node, dict) and "mesh" in node:
                self.tally.add(_OUTSIDE, self._name(node, node["mesh"], f"node {index}"))
        used = {node.get("mesh") for node in nodes if isinstance(node, dict) and isinstance(node.get("mesh"), int)}
        for index, mesh in enumerate(_list(document.root.get("meshes"))):
            if index not in used and isinstance(mesh, dict):
                self.tally.add(_UNUSED, clean_name(mesh.get("name"), f"mesh {index}"))

    def _roots(self, nodes: list[Any]) -> list[int]:
        document = self.document
        scenes = document.root.get("scenes")
        if scenes:
            if isinstance(scenes, list) and len(scenes) > 1:
                which = "default" if "scene" in document.root else "first"
                self.notes.append(f"the file has {len(scenes)} scenes; the {which} one was taken")
            roots = _list(document.item("scenes", document.root.get("scene", 0)).get("nodes"))
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

    def _name(self, node: dict[str, Any], mesh: Any, default: str) -> str:
        return clean_name(node.get("name"), "") or clean_name(self.document.item("meshes", mesh).get("name"), default)

    def _add_instance(
        self, node: dict[str, Any], mesh: Any, above: str, world: Matrix, default: str, index: int, row: int
    ) -> str:
        name = self._name(node, mesh, default)
        path = self._book.claim(above, name)
        weights = node.get("weights")
        if weights is not None:
            weights = tuple(self.document.numbers(weights, f"the weights of node {name!r}"))
        spread = _extension(node, "EXT_mesh_gpu_instancing")
        skin = node.get("skin")
        if skin is not None and not spread:
            self.document.item("skins", skin)
        shape = Shape(mesh, weights, None if spread else skin)
        if not spread:
            self.instances.append(Instance(name, path, shape, world, index, row))
            return path
        for local, turn, scale in self._spread(spread):
            own, placed = self.errors.add(row, local, turn, scale), multiply(world, local)
            self.instances.append(Instance(name, self._book.claim(path, name), shape, placed, index, own))
        if len(self.instances) > MAX_PARTS:
            check_mesh(0, 0, len(self.instances), str(self.document.path))
        return path

    def _spread(self, extension: dict[str, Any]) -> list[_Local]:
        """Return the transforms of EXT_mesh_gpu_instancing."""
        attributes = extension.get("attributes")
        if not isinstance(attributes, dict):
            raise self.document.fail("EXT_mesh_gpu_instancing has no attributes")
        counts = {self.document.count(index) for index in attributes.values()}
        if len(counts) != 1:
            raise self.document.fail("EXT_mesh_gpu_instancing has attributes of different length, or none")
        count = counts.pop()
        check_mesh(0, 0, count, str(self.document.path))
        columns = []
        for key, width, default in (
            ("TRANSLATION", 3, (0, 0, 0)),
            ("ROTATION", 4, (0, 0, 0, 1)),
            ("SCALE", 3, (1, 1, 1)),
        ):
            if key in attributes:
                values = self.document.array(attributes[key], width, normalise=key == "ROTATION")
            else:
                values = np.broadcast_to(np.array(default, dtype=np.float64), (count, width))
            columns.append(values.astype(np.float64).tolist())
        return [
            _Local(self._compose(t, r, s, "EXT_mesh_gpu_instancing"), r, s) for t, r, s in zip(*columns, strict=True)
        ]

    def _local(self, node: dict[str, Any], index: int) -> _Local:
        """Return the transform of a node, column-major `matrix` or translation * rotation * scale."""

        def numbers(key: str, count: int) -> list[float] | None:
            value = node.get(key)
            return None if value is None else self.document.numbers(value, f"nodes[{index}].{key}", count)

        matrix = numbers("matrix", 16)
        if matrix is not None and matrix[3::4] != [0.0, 0.0, 0.0, 1.0]:
            raise self.document.fail(f"nodes[{index}].matrix is not an affine transform")
        whole = None if matrix is None else np.array([matrix[row::4] for row in range(4)])  # column by column
        move, turn, scale = numbers("translation", 3), numbers("rotation", 4), numbers("scale", 3)
        if move is None and turn is None and scale is None:
            return _Local(IDENTITY if whole is None else whole, None)
        turn, scale = turn or [0.0, 0.0, 0.0, 1.0], scale or [1.0, 1.0, 1.0]
        composed = self._compose(move or [0.0, 0.0, 0.0], turn, scale, f"nodes[{index}]")
        if whole is None:
            return _Local(composed, turn, scale)
        # The standard forbids both. Some programs write both all the same, the second as the first or as no motion.
        if not any(np.allclose(composed, same, rtol=_SAME, atol=_SAME) for same in (IDENTITY, whole)):
            self.tally.add(_TWICE, node.get("name", f"node {index}"), is_doubtful=True)
        return _Local(whole, None)

    def _compose(self, move: list[float], turn: list[float], scale: list[float], where: str) -> Matrix:
        x, y, z, w = turn
        length = x * x + y * y + z * z + w * w
        if not length:
            raise self.document.fail(f"{where} has a rotation of length zero")
        # Written with few digits or as small integers it is not of length one, and would scale the part.
        s = 2 / length if math.isfinite(length) else math.nan
        rotation = np.array(
            [
                [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
                [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
                [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
            ]
        )
        matrix = np.eye(4)
        with np.errstate(all="ignore"):
            matrix[:3, :3] = rotation * np.array(scale)
        matrix[:3, 3] = move
        return matrix


def _extension(item: dict[str, Any], name: str) -> dict[str, Any]:
    extensions = item.get("extensions")
    found = extensions.get(name) if isinstance(extensions, dict) else None
    return found if isinstance(found, dict) else {}


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
