"""glTF 2.0, as .glb or .gltf: the scene graph as parts.

A node with a mesh is one part, so a mesh used by several nodes gives several parts. Vertices are transformed as
described in `feeler.io.placing`; mirrored parts get their faces turned, as the standard requires. Axes stay as in the
file: y is up by the standard, except in files written by feeler, which keep the axes of the mock-up. Morph targets and
skins are taken at rest; animations are not played.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.io.gltf_colours import Colour, material_names, mesh_colour
from feeler.io.gltf_deform import joint_matrices
from feeler.io.gltf_document import OWN_GENERATOR, Document
from feeler.io.gltf_mesh import Mesh, MeshReader
from feeler.io.gltf_nodes import Instance, SceneGraph, Shape
from feeler.io.limits import check_mesh
from feeler.io.placing import facing, is_mirrored, transform, turned
from feeler.io.placing import shift_indices as shift_indices
from feeler.io.raw import AT_REST, OUT_OF_RANGE, RawMesh
from feeler.io.skinning import skinned
from feeler.io.stated import Stated
from feeler.io.tally import Tally
from feeler.io.units import parse_unit
from feeler.progress import Progress


def read_gltf(
    path: Path, progress: Progress | None = None, *, edit: Callable[[Document], None] | None = None
) -> RawMesh:
    """Read a .glb or .gltf file. The unit is the metre, by the standard. `edit` may change the document first."""
    document = Document(path)
    if edit is not None:
        edit(document)
    if progress:
        progress(0.0, f"reading {path.name}")
    tally = Tally()
    graph = SceneGraph(document, tally)
    reader = MeshReader(document, tally)
    bound = [reader.bound(instance.shape.mesh) for instance in graph.instances]
    check_mesh(sum(b[0] for b in bound), sum(b[1] for b in bound), len(bound), str(path))
    placer = _Placer(document, graph, tally)
    uses = Counter(instance.shape for instance in graph.instances)
    meshes: dict[Shape, Mesh] = {}
    vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.uint32)]
    names: list[str] = []
    paths: list[str] = []
    colours: list[Colour] = []
    nodes: list[int] = []
    stated = _Attributes(document, tally)
    base = 0
    rounding, errors = 0.0, graph.errors.bounds()
    for number, instance in enumerate(graph.instances):
        mesh = meshes.get(instance.shape) or reader.read(instance.shape, instance.name)
        if uses[instance.shape] > 1:
            meshes[instance.shape] = mesh
        if not len(mesh.faces):
            continue
        points, triangles = placer.place(instance, mesh)
        place = errors[instance.row] if instance.row >= 0 else (0.0, 0.0)
        rounding = max(rounding, graph.errors.placed(mesh.rounding, mesh.vertices, instance.world, place))
        vertices.append(points)
        faces.append(shift_indices(triangles, base, len(points)))
        base += len(points)
        names.append(instance.name)
        paths.append(instance.path)
        nodes.append(instance.node)
        colours.append(mesh_colour(document, instance.shape.mesh))
        stated.add_instance(instance)
        if progress and not number % 256:
            progress(0.1 + 0.7 * number / len(graph.instances), f"reading {path.name}")
    notes = graph.notes + tally.notes()
    if document.root.get("animations"):
        notes.append(AT_REST)
    part_of_face = np.repeat(np.arange(len(names), dtype=np.uint32), [len(f) for f in faces[1:]])
    return RawMesh(
        np.concatenate(vertices),
        np.concatenate(faces),
        part_of_face,
        names,
        paths,
        unit=parse_unit("m"),
        notes=notes,
        doubts=[*document.doubts, *tally.doubts()],
        up=None if document.root["asset"].get("generator") == OWN_GENERATOR else "y",
        colours=np.array(colours).reshape(-1, 3),
        attributes=stated.attributes(),
        nodes=nodes,
        rounding=rounding,
    )


class _Attributes(Stated):
    """The attributes of parts: `extras` of the node, then of the mesh, then the names of its materials."""

    def __init__(self, document: Document, tally: Tally) -> None:
        super().__init__(tally)
        self._document = document
        self._of_node: tuple[int, dict[str, str]] = (-1, {})
        self._of_mesh: dict[int, tuple[dict[str, str], dict[str, str]]] = {}

    def add_instance(self, instance: Instance) -> None:
        """Adds those of the next part."""
        document, node, mesh = self._document, instance.node, instance.shape.mesh
        # The parts of a node that places its mesh many times come one after the other.
        if node >= 0 and self._of_node[0] != node:
            self._of_node = (node, self.flat(document.item("nodes", node).get("extras")))
        if mesh not in self._of_mesh:
            entry = document.item("meshes", mesh)
            materials = dict.fromkeys(filter(None, material_names(document, entry)))
            self._of_mesh[mesh] = (self.flat(entry.get("extras")), self.text("material", ", ".join(materials)))
        self.add(self._of_node[1] if node >= 0 else {}, *self._of_mesh[mesh], name=instance.name)


class _Placer:
    """Places parts in the world: by their node, or by their skin."""

    def __init__(self, document: Document, graph: SceneGraph, tally: Tally) -> None:
        self.document = document
        self.worlds = graph.worlds
        self.tally = tally
        self._skins: dict[int, NDArray[np.float64]] = {}

    def place(self, instance: Instance, mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
        """Return (vertices, faces) of a part, in the world."""
        skin = instance.shape.skin
        if skin is None:
            return transform(mesh.vertices, instance.world), facing(mesh.faces, instance.world)
        if mesh.joints is None or mesh.weights is None:
            self.tally.add("meshes with a skin have no joints, and were placed by their node", instance.name)
            return transform(mesh.vertices, instance.world), facing(mesh.faces, instance.world)
        self.tally.add("skinned meshes were placed by their joints as these stand at rest", instance.name)
        if skin not in self._skins:
            self._skins[skin] = joint_matrices(self.document, skin, self.worlds)
        matrices = self._skins[skin]
        if mesh.joints.size and int(mesh.joints.max()) >= len(matrices):
            raise self.document.fail(f"a mesh names joint {int(mesh.joints.max())} of a skin with {len(matrices)}")
        points, mirrored = skinned(mesh.vertices, mesh.joints, mesh.weights, matrices)
        free = mesh.joints[:, 0] < 0  # of a primitive that has no joints
        if free.any():
            points[free] = transform(mesh.vertices[free], instance.world)
            mirrored[free] = is_mirrored(instance.world)
        first = mesh.faces[:, 0]
        known = first != OUT_OF_RANGE
        flip = np.zeros(len(mesh.faces), dtype=bool)
        flip[known] = mirrored[first[known]]
        return points, np.where(flip[:, None], turned(mesh.faces), mesh.faces)
