"""COLLADA (.dae, .zae) 1.4 and 1.5: the visual scene as parts, with the file's unit.

Only geometry is read: materials, lights and cameras do not move a vertex, and errors in them do not reject a file. Each
placed geometry is a part. Axes stay as in the file; `RawMesh.up` is the up axis. Vertices are transformed as described
in `feeler.io.placing`; mirrored parts get their faces turned.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from feeler.io.collada_document import Document, Element
from feeler.io.collada_mesh import Mesh, MeshReader, name_of
from feeler.io.collada_nodes import local_matrix
from feeler.io.collada_skin import Controllers
from feeler.io.limits import MAX_DEPTH, MAX_PARTS, check_mesh
from feeler.io.placing import IDENTITY, Matrix, facing, multiply, shift_indices, transform
from feeler.io.raw import AT_REST, Axis, PathBook, RawMesh, clean_name
from feeler.io.rounding import PlacementErrors, of_numbers
from feeler.io.tally import Tally
from feeler.io.units import Unit
from feeler.progress import Progress

_UP: dict[str, Axis] = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}
_LOOKS = ("library_effects", "library_materials", "library_images", "library_lights", "library_cameras")
_NUMBERS = {"color", "float", "float2", "float3", "float4", "int", "bool"}


def read_collada(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read a COLLADA file: one part for every placed geometry."""
    if progress:
        progress(0.0, f"reading {path.name}")
    return _Reader(Document(path)).read(progress)


class _Open(NamedTuple):
    """A node still to be visited."""

    node: Element
    above: str
    world: Matrix
    row: int  # among the errors of placements
    depth: int
    inside: frozenset[int]  # the nodes of the library that it is an instance in


class _Use(NamedTuple):
    """A geometry or controller to be placed."""

    element: Element
    world: Matrix
    row: int
    above: str
    skeletons: tuple[str, ...]


class _Reader:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.tally = Tally()
        self.meshes = MeshReader(document, self.tally)
        self.uses: list[_Use] = []
        self.errors = PlacementErrors()
        self.placed: list[tuple[Mesh, Matrix, int]] = []
        self.worlds: dict[int, Matrix] = {}
        self.notes: list[str] = []
        self.book = PathBook()
        self.vertices = [np.empty((0, 3))]
        self.faces = [np.empty((0, 3), dtype=np.uint32)]
        self.names: list[str] = []
        self.paths: list[str] = []
        self.vertex_count = self.triangle_count = 0

    def read(self, progress: Progress | None) -> RawMesh:
        """Walk the scene."""
        unit, up = self._asset()
        if progress:
            progress(0.4, f"reading {self.document.path.name}")
        self._walk(self._roots())
        for number, use in enumerate(self.uses):
            if use.element.tag == "geometry":
                self._place(self.meshes.read(use.element), use)
            else:
                skins = Controllers(self.document, self.meshes, self.worlds, self.tally)
                mesh, world = skins.read(use.element, use.skeletons, use.world)
                self._place(mesh, use._replace(world=world))
            if progress and not number % 256:
                progress(0.4 + 0.6 * number / len(self.uses), f"reading {self.document.path.name}")
        for library in self.document.root.all("library_geometries"):
            for geometry in library.all("geometry"):
                if not self.meshes.is_read(geometry):
                    self.tally.add("geometries are not in the scene and were left out", name_of(geometry, "geometry"))
        self._check_looks()
        own, errors = of_numbers(self.meshes.vertices()), self.errors.bounds()
        place = [errors[row] if row >= 0 else (0.0, 0.0) for _, _, row in self.placed]
        rounding = [
            self.errors.placed(own, mesh.vertices, world, each)
            for (mesh, world, _), each in zip(self.placed, place, strict=True)
        ]
        part_of_face = np.repeat(np.arange(len(self.names), dtype=np.uint32), [len(f) for f in self.faces[1:]])
        return RawMesh(
            np.concatenate(self.vertices),
            np.concatenate(self.faces),
            part_of_face,
            self.names,
            self.paths,
            unit=unit,
            notes=self.notes + self.tally.notes(),
            doubts=self.tally.doubts(),
            up=up,
            rounding=max(rounding, default=0.0),
        )

    def _asset(self) -> tuple[Unit, Axis]:
        """Return the unit (the metre if none is stated) and the axis that is up (y if none is stated)."""
        asset = self.document.root.first("asset")
        unit = asset.first("unit") if asset else None
        axis = asset.first("up_axis") if asset else None
        word = axis.text.strip() if axis else "Y_UP"
        if word not in _UP:
            self.notes.append(f"the up axis {word[:20]!r} is unknown in COLLADA: taken as Y_UP")
            word = "Y_UP"
        found = Unit("m", 1.0)
        if unit is not None:
            text = unit.attributes.get("meter", "1")
            try:
                metres = float(text)
            except ValueError:
                metres = -1.0
            if not 0 < metres < float("inf"):
                raise self.document.fail(f"the unit has {text[:20]!r} metres, and should have a positive number", unit)
            found = Unit(clean_name(unit.attributes.get("name"), "unit" if metres != 1 else "m"), metres)
        for element in self.document.root.walk():
            other = element.first("asset") if element is not self.document.root else None
            if other is not None and (
                (
                    (u := other.first("unit"))
                    and u.attributes.get("meter", "1") != (unit or u).attributes.get("meter", "1")
                )
                or ((a := other.first("up_axis")) and a.text.strip() != word)
            ):
                self.tally.add(
                    "elements state another unit or up axis than the file: theirs was not used",
                    name_of(element, element.tag),
                )
        return found, _UP[word]

    def _roots(self) -> list[Element]:
        """Return the nodes of the visual scene, or of its substitute."""
        root = self.document.root
        scene = root.first("scene")
        instance = scene.first("instance_visual_scene") if scene else None
        found = self.document.find(instance.attributes.get("url"), "visual_scene") if instance else None
        scenes = [s for library in root.all("library_visual_scenes") for s in library.all("visual_scene")]
        if found is None and scenes:
            found = scenes[0]
            self.notes.append("the file does not say which scene is shown: the first one was taken")
        if found is not None:
            if len(scenes) > 1:
                self.notes.append(f"the file has {len(scenes)} scenes; only the one that is shown was taken")
            return found.all("node")
        nodes = [node for library in root.all("library_nodes") for node in library.all("node")]
        if nodes:
            self.notes.append("the file has nodes and no scene: each node was taken once")
            return nodes
        geometries = [g for library in root.all("library_geometries") for g in library.all("geometry")]
        if geometries:
            self.notes.append("the file has geometries and no scene: each was taken once, where it lies")
        self.uses += [_Use(geometry, IDENTITY, -1, "", ()) for geometry in geometries]
        return []

    def _walk(self, roots: list[Element]) -> None:
        """Visit every node, without recursion. Nodes may be shared: a small file can describe an enormous scene."""
        document = self.document
        stack = [_Open(node, "", IDENTITY, -1, 0, frozenset()) for node in reversed(roots)]
        visits = 0
        while stack:
            node, above, world, row, depth, inside = stack.pop()
            visits += 1
            if visits > MAX_PARTS:
                raise document.fail(f"the scene has more than {MAX_PARTS:,} nodes")
            if depth > MAX_DEPTH:
                raise document.fail(f"the assembly is more than {MAX_DEPTH} levels deep")
            local, row = local_matrix(document, node, self.errors, row)
            world = multiply(world, local)
            self.worlds.setdefault(id(node), world)
            path = self.book.claim(above, name_of(node, "node"))
            below: list[_Open] = []
            for child in node.children:
                if child.tag == "node":
                    below.append(_Open(child, path, world, row, depth + 1, inside))
                elif child.tag == "instance_node":
                    target = document.find(child.attributes.get("url"), "node")
                    if target is None:
                        self._add_missing("nodes", child)
                    elif id(target) in inside:
                        raise document.fail(f"the node {name_of(target, '')!r} contains itself", child)
                    else:
                        below.append(_Open(target, path, world, row, depth + 1, inside | {id(target)}))
                elif child.tag == "instance_geometry":
                    geometry = document.find(child.attributes.get("url"), "geometry")
                    if geometry is None:
                        self._add_missing("geometries", child)
                    else:
                        self.uses.append(_Use(geometry, world, row, path, ()))
                elif child.tag == "instance_controller":
                    controller = document.find(child.attributes.get("url"), "controller")
                    if controller is None:
                        self._add_missing("controllers", child)
                    else:
                        skeletons = tuple(skeleton.text.strip() for skeleton in child.all("skeleton"))
                        self.uses.append(_Use(controller, world, row, path, skeletons))
            stack.extend(reversed(below))

    def _add_missing(self, what: str, instance: Element) -> None:
        url = instance.attributes.get("url", "")
        if url.startswith("#") or not url:
            self.tally.add(f"uses of {what} that are not in the file were left out", url)
        else:
            self.tally.add(f"uses of {what} in other files were left out: load those files beside it", url)

    def _place(self, mesh: Mesh, use: _Use) -> None:
        name = name_of(use.element, use.element.tag)
        if not len(mesh.faces):
            return
        self.vertex_count += len(mesh.vertices)
        self.triangle_count += len(mesh.faces)
        check_mesh(self.vertex_count, self.triangle_count, len(self.names) + 1, str(self.document.path))
        base = self.vertex_count - len(mesh.vertices)
        self.vertices.append(transform(mesh.vertices, use.world))
        self.faces.append(shift_indices(facing(mesh.faces, use.world), base, len(mesh.vertices)))
        self.placed.append((mesh, use.world, use.row))
        self.names.append(name)
        self.paths.append(self.book.claim(use.above, name))

    def _check_looks(self) -> None:
        """Note errors in colours, lights and cameras, which move no vertex."""
        for library in self.document.root.all(*_LOOKS):
            for item in library.children:
                inner = item.first("optics") if item.tag == "camera" else item
                bare = item.tag in ("light", "camera") and (inner is None or inner.first("technique_common") is None)
                if bare or any(not _are_numbers(e) for e in item.walk() if e.tag in _NUMBERS and not e.children):
                    self.tally.add(
                        f"elements of the kind '{item.tag}' were not understood: they do not move a vertex",
                        name_of(item, item.tag),
                    )
        if self.document.root.first("library_animations") is not None:
            self.notes.append(AT_REST)


def _are_numbers(element: Element) -> bool:
    words = element.text.split()
    if element.tag == "bool":
        return all(word in ("true", "false", "0", "1") for word in words)
    try:
        [float(word) for word in words]
    except ValueError:
        return False
    return True
