"""Controllers of COLLADA at rest: morphs with the file's weights, skins with the joints of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from feeler.io.collada_document import Document, Element
from feeler.io.collada_mesh import Mesh, MeshReader, name_of
from feeler.io.limits import check_memory
from feeler.io.placing import IDENTITY, Matrix, multiply, transform, turned
from feeler.io.raw import OUT_OF_RANGE
from feeler.io.skinning import skinned
from feeler.io.tally import Tally

_MOST_NESTED = 8  # controllers on controllers; a skin on a morph is two
_EMPTY = Mesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.uint32))


class Controllers:
    """Applies controllers to their geometry. `worlds` has the transform of each node, by the element's id()."""

    def __init__(self, document: Document, meshes: MeshReader, worlds: dict[int, Matrix], tally: Tally) -> None:
        self.document = document
        self.meshes = meshes
        self.worlds = worlds
        self.tally = tally

    def read(self, controller: Element, skeletons: tuple[str, ...], world: Matrix) -> tuple[Mesh, Matrix]:
        """Return (mesh, its placement): by its node, or by its joints."""
        name = name_of(controller, "controller")
        skin = controller.first("skin")
        if skin is None:
            return self._morphed(controller, name, 0), world
        mesh = self._source(skin, name, 0)
        if not len(mesh.faces):
            return _EMPTY, world
        bind = skin.first("bind_shape_matrix")
        shape = IDENTITY if bind is None else self.document.floats(bind, 16).reshape(4, 4)
        points = transform(mesh.vertices, shape)
        carried = self._influences(skin, len(points))
        matrices = self._joints(skin, skeletons) if carried else None
        if carried is None or matrices is None:
            self.tally.add("skins were taken in their bind shape: joints or weights of theirs are missing", name)
            return Mesh(points, mesh.faces), world
        self.tally.add("skins were placed by their joints as these stand at rest", name)
        joint, weight = carried
        if joint.size and int(joint.max()) >= len(matrices):
            raise self.document.fail(f"the skin {name!r} names joint {int(joint.max())} of {len(matrices)}", skin)
        # Joint -1 is the bind shape itself; it is stored last, which is index -1 in NumPy too.
        placed, mirrored = skinned(points, joint, weight, np.concatenate([matrices, IDENTITY[None]]))
        first = mesh.faces[:, 0]
        flip = np.zeros(len(mesh.faces), dtype=bool)
        flip[first != OUT_OF_RANGE] = mirrored[first[first != OUT_OF_RANGE]]
        return Mesh(placed, np.where(flip[:, None], turned(mesh.faces), mesh.faces)), IDENTITY

    def _source(self, above: Element, name: str, depth: int) -> Mesh:
        """Return the mesh that a skin or morph refers to: a geometry, or the result of another controller."""
        source = self.document.find(above.attributes.get("source"), "geometry", "controller")
        if source is None:
            self.tally.add("controllers have no geometry in the file and were left out", name)
            return _EMPTY
        if source.tag == "geometry":
            return self.meshes.read(source)
        if depth > _MOST_NESTED:
            raise self.document.fail(f"the controllers below {name!r} are nested too deeply, or a cycle", above)
        return self._morphed(source, name, depth + 1)

    def _morphed(self, controller: Element, name: str, depth: int) -> Mesh:
        """Return a mesh with the weights of a morph; a skin below another controller is used without its joints."""
        morph = controller.first("morph")
        if morph is None:
            skin = controller.first("skin")
            return self._source(skin, name, depth) if skin is not None else _EMPTY
        mesh = self._source(morph, name, depth)
        targets, weights = self._targets(morph)
        if not len(mesh.faces) or not targets:
            return mesh
        self.tally.add("morphs were taken at rest, with the weights that the file gives", name)
        if len(weights) != len(targets):
            raise self.document.fail(f"the morph {name!r} has {len(weights)} weights for {len(targets)} targets", morph)
        relative = morph.attributes.get("method", "NORMALIZED") == "RELATIVE"
        with np.errstate(all="ignore"):  # the mock-up counts values outside the range of float64
            points = mesh.vertices * (1.0 if relative else 1.0 - float(weights.sum()))
        for reference, weight in zip(targets, weights.tolist(), strict=True):
            if not weight:
                continue
            target = self.document.find(reference, "geometry")
            other = self.meshes.read(target).vertices if target is not None else None
            if other is None or len(other) != len(points):
                raise self.document.fail(f"the morph {name!r} has no target {reference[:40]!r} of its size", morph)
            with np.errstate(all="ignore"):
                points = points + weight * other
        return Mesh(points, mesh.faces)

    def _targets(self, morph: Element) -> tuple[list[str], NDArray[np.float64]]:
        names: list[str] = []
        weights = np.empty(0)
        inputs = morph.first("targets")
        for entry in inputs.all("input") if inputs is not None else ():
            source = self.document.find(entry.attributes.get("source"), "source")
            if source is None:
                continue
            if entry.attributes.get("semantic") == "MORPH_TARGET":
                names = _words(source)
            elif entry.attributes.get("semantic") == "MORPH_WEIGHT" and (array := source.first("float_array")):
                weights = self.document.floats(array)
        return names, weights

    def _influences(self, skin: Element, count: int) -> tuple[NDArray[Any], NDArray[Any]] | None:
        """Return (joints (n, k), weights (n, k), each row's sum one), or None if some are missing."""
        table = skin.first("vertex_weights")
        counts, values = (table.first("vcount"), table.first("v")) if table is not None else (None, None)
        if table is None or counts is None or values is None:
            return None
        inputs = {entry.attributes.get("semantic"): entry for entry in table.all("input")}
        if not {"JOINT", "WEIGHT"} <= set(inputs):
            return None
        source = self.document.find(inputs["WEIGHT"].attributes.get("source"), "source")
        array = source.first("float_array") if source is not None else None
        if array is None:
            return None
        listed = self.document.floats(array)
        stride = 1 + max(self.document.natural(entry, "offset", 0) for entry in table.all("input"))
        sizes, numbers = self.document.integers(counts), self.document.integers(values)
        if len(sizes) != count or (sizes < 0).any() or int(sizes.sum()) * stride != len(numbers):
            raise self.document.fail(f"the weights of a skin are {len(sizes):,} rows for {count:,} vertices", table)
        width = max(int(sizes.max()) if count else 0, 1)
        check_memory(16 * count * width, f"{self.document.path}: the weights of a skin")
        pairs = numbers.reshape(-1, stride)
        which = pairs[:, self.document.natural(inputs["WEIGHT"], "offset", 0)]
        if which.size and not 0 <= int(which.min()) <= int(which.max()) < len(listed):
            raise self.document.fail(f"a skin names a weight that is not among its {len(listed):,}", table)
        joint = np.full((count, width), -1, dtype=np.int64)
        weight = np.zeros((count, width))
        row = np.repeat(np.arange(count), sizes)
        column = np.arange(len(row)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        joint[row, column] = np.maximum(pairs[:, self.document.natural(inputs["JOINT"], "offset", 0)], -1)
        weight[row, column] = listed[which]
        total = weight.sum(axis=1, keepdims=True)
        joint[total[:, 0] == 0, 0], weight[total[:, 0] == 0, 0] = -1, 1.0
        with np.errstate(all="ignore"):
            return joint, weight / np.where(total == 0, 1.0, total)

    def _joints(self, skin: Element, skeletons: tuple[str, ...]) -> NDArray[np.float64] | None:
        """Return the transform of each joint from the bind shape (joints, 4, 4), or None if one is missing."""
        table = skin.first("joints")
        names: list[str] = []
        inverse = np.empty((0, 4, 4))
        for entry in table.all("input") if table is not None else ():
            source = self.document.find(entry.attributes.get("source"), "source")
            if source is None:
                return None
            if entry.attributes.get("semantic") == "JOINT":
                names = _words(source)
            elif entry.attributes.get("semantic") == "INV_BIND_MATRIX" and (array := source.first("float_array")):
                inverse = self.document.floats(array)
                inverse = inverse[: len(inverse) // 16 * 16].reshape(-1, 4, 4)
        if not names or len(inverse) < len(names):
            return None
        roots = [root for text in skeletons if (root := self.document.find(text, "node")) is not None]
        known: dict[str, Element] = {}
        for root in roots or [self.document.root]:
            for element in root.walk():
                if element.tag == "node" and id(element) in self.worlds:
                    for key in ("sid", "id", "name"):
                        known.setdefault(element.attributes.get(key, ""), element)
        found = [known.get(name) for name in names]
        made = [
            multiply(self.worlds[id(node)], matrix)
            for node, matrix in zip(found, inverse, strict=False)
            if node is not None
        ]
        return np.stack(made) if len(made) == len(names) else None


def _words(source: Element) -> list[str]:
    array = source.first("Name_array") or source.first("IDREF_array") or source.first("SIDREF_array")
    return array.text.split() if array is not None else []
