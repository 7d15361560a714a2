"""3MF: build items and components as parts, with the file's unit.

An XML reader of our own on expat: it streams, so memory follows the mesh and not the XML, it refuses document type
declarations (entity bombs), and it looks at the sizes in the archive before it opens anything.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io.limits import MAX_DEPTH, check_memory, check_mesh
from feeler.io.placing import shift_indices, transform
from feeler.io.raw import PathBook, Progress, RawMesh, clean_name, seal_indices
from feeler.io.units import parse_unit

_DEFAULT_MODEL = "3D/3dmodel.model"
_SEPARATOR = " "
_MAX_RATIO = 250  # deflate packs the XML of meshes about 5 to 40 times, a bomb up to 1032 times
_SMALL = 64 * 2**20  # below this a high ratio does no harm
_READ_BYTES = 2**20
# The namespaces that add nothing to the geometry of a mesh.
_HARMLESS = ("production/2015/06", "material/2015/02", "triangleset", "trianglesets/2021/07", "core/2015/02")

_ObjectKey = tuple[str, str]  # (model file, object id)


class _Use(NamedTuple):
    """An item of the build, or a component of an object."""

    target: _ObjectKey
    matrix: NDArray[np.float64]
    name: str


@dataclass
class _Object:
    name: str
    numbers: list[str] = field(default_factory=list)  # x y z of every vertex while reading
    indices: list[str] = field(default_factory=list)
    vertices: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    faces: NDArray[np.uint32] = field(default_factory=lambda: np.empty((0, 3), dtype=np.uint32))
    uses: list[_Use] = field(default_factory=list)


class _Model:
    """What has been read of all the model files of one 3MF."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.objects: dict[_ObjectKey, _Object] = {}
        self.items: list[_Use] = []
        self.unit = "millimeter"
        self.notes: list[str] = []
        self.pending: list[str] = []
        self.seen: set[str] = set()

    def fail(self, what: str) -> LoadError:
        """Return the error for this file."""
        return LoadError(f"{self.path}: {what}; export the file again")


def read_3mf(path: Path, progress: Progress = None) -> RawMesh:
    """Read a 3MF file: one part for every mesh that an item of the build leads to."""
    model = _Model(path)
    try:
        with zipfile.ZipFile(path) as archive:
            names = {name.lower().lstrip("/"): name for name in archive.namelist()}
            root = _root_model(archive, names, model)
            model.pending.append(root)
            while model.pending:
                name = model.pending.pop()
                if name.lower() not in model.seen:
                    model.seen.add(name.lower())
                    _read_model(archive, names, name, model, progress, is_root=name == root)
    except (zipfile.BadZipFile, zipfile.LargeZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise model.fail(f"the archive is damaged, truncated or encrypted ({error})") from error
    return _assemble(model, progress)


def _root_model(archive: zipfile.ZipFile, names: dict[str, str], model: _Model) -> str:
    """Return the name of the root model: where the relations say, else where everybody puts it."""
    found: list[str] = []
    if "_rels/.rels" in names:
        info = archive.getinfo(names["_rels/.rels"])
        _check_size(info, model)
        parser = expat.ParserCreate(namespace_separator=_SEPARATOR)
        parser.StartDoctypeDeclHandler = _refuse_doctype

        def start(tag: str, attributes: dict[str, str]) -> None:
            if attributes.get("Type", "").endswith("/3dmodel"):
                found.append(attributes.get("Target", "").lstrip("/"))

        parser.StartElementHandler = start
        try:
            parser.Parse(archive.read(info), True)
        except (expat.ExpatError, _DoctypeError) as error:
            raise model.fail(f"'_rels/.rels' is damaged ({error})") from error
    for name in (*found, _DEFAULT_MODEL):
        if name.lower() in names:
            return name
    models = sorted(name for name in names if name.endswith(".model"))
    if models:
        return models[0]
    raise model.fail("there is no 3D model in the archive: it is no 3MF file")


def _check_size(info: zipfile.ZipInfo, model: _Model) -> None:
    """Refuse an archive member that unpacks to more than a mesh would."""
    if info.file_size > _SMALL and info.file_size > _MAX_RATIO * max(info.compress_size, 1):
        raise model.fail(
            f"{info.filename!r} unpacks from {info.compress_size:,} to {info.file_size:,} bytes: this is a zip bomb, "
            "and it was not opened"
        )
    check_memory(info.file_size, f"{model.path}: {info.filename!r} unpacked")


class _DoctypeError(Exception):
    """The XML declares a document type, which 3MF forbids and which can hold an entity bomb."""


def _refuse_doctype(*_: object) -> None:
    raise _DoctypeError("it declares a document type, which 3MF forbids")


def _read_model(
    archive: zipfile.ZipFile, names: dict[str, str], name: str, model: _Model, progress: Progress, is_root: bool
) -> None:
    if name.lower() not in names:
        raise model.fail(f"the model {name!r} is asked for and is not in the archive")
    info = archive.getinfo(names[name.lower()])
    _check_size(info, model)
    handler = _Handler(model, name, is_root)
    parser = expat.ParserCreate(namespace_separator=_SEPARATOR)
    parser.buffer_text = True
    parser.StartElementHandler = handler.start
    parser.EndElementHandler = handler.end
    parser.StartDoctypeDeclHandler = _refuse_doctype
    done = 0
    try:
        with archive.open(info) as file:
            while block := file.read(_READ_BYTES):
                parser.Parse(block)
                done += len(block)
                if progress:
                    progress(0.9 * done / max(info.file_size, 1), f"reading {model.path.name}")
        parser.Parse(b"", True)
    except (expat.ExpatError, _DoctypeError) as error:
        raise model.fail(f"the XML of {name!r} is damaged ({error})") from error
    except KeyError as error:
        line = parser.CurrentLineNumber
        raise model.fail(f"{name!r}, line {line}: the attribute {error} is missing") from error


class _Handler:
    """Gets the XML elements of one model file."""

    def __init__(self, model: _Model, name: str, is_root: bool) -> None:
        self.model = model
        self.name = name
        self.is_root = is_root
        self.object: _Object | None = None

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Take an element that opens."""
        word = tag.rpartition(_SEPARATOR)[2]
        current = self.object
        if word == "vertex" and current is not None:
            current.numbers += (attributes["x"], attributes["y"], attributes["z"])
        elif word == "triangle" and current is not None:
            current.indices += (attributes["v1"], attributes["v2"], attributes["v3"])
        elif word == "object":
            number = attributes["id"]
            self.object = _Object(clean_name(attributes.get("name"), f"object {number}"))
            if (self.name.lower(), number) in self.model.objects:
                raise self.model.fail(f"object {number[:20]!r} is defined twice in {self.name!r}")
            self.model.objects[self.name.lower(), number] = self.object
        elif word == "component" and current is not None:
            current.uses.append(self._use(attributes))
        elif word == "item" and self.is_root:
            self.model.items.append(self._use(attributes))
        elif word == "model":
            if self.is_root:
                self.model.unit = attributes.get("unit", "millimeter")
        elif word == "beamlattice":
            self.model.notes.append(
                f"the beam lattice of {current.name if current else 'an object'} was skipped: only triangles collide"
            )

    def end(self, tag: str) -> None:
        """Take an element that closes."""
        if tag.rpartition(_SEPARATOR)[2] != "object" or self.object is None:
            return
        found, self.object = self.object, None
        try:
            found.vertices = np.array(found.numbers, dtype=np.float64).reshape(-1, 3)
            indices = np.array(found.indices, dtype=np.int64).reshape(-1, 3)
        except (ValueError, OverflowError) as error:
            raise self.model.fail(f"{found.name!r} in {self.name!r} has a value that is no number ({error})") from error
        found.faces = seal_indices(indices, len(found.vertices))
        found.numbers, found.indices = [], []

    def _use(self, attributes: dict[str, str]) -> _Use:
        # The production extension lets an item or component name another model file.
        other = next((value for key, value in attributes.items() if key.endswith(_SEPARATOR + "path")), None)
        name = other.lstrip("/") if other else self.name
        if other:
            self.model.pending.append(name)
        label = clean_name(attributes.get("partnumber"), "")
        return _Use((name.lower(), attributes["objectid"]), self._matrix(attributes.get("transform")), label)

    def _matrix(self, text: str | None) -> NDArray[np.float64]:
        """Return the 4 x 4 matrix of a 3MF transform: twelve numbers, for row vectors."""
        matrix = np.eye(4)
        if text:
            try:
                matrix[:3, :] = np.array(text.split(), dtype=np.float64).reshape(4, 3).T
            except ValueError as error:
                raise self.model.fail(f"the transform {text[:80]!r} is not twelve numbers") from error
        return matrix


def _assemble(model: _Model, progress: Progress) -> RawMesh:
    if not model.items:
        raise model.fail(
            f"the build has no item (and the file {len(model.objects):,} objects): there is nothing to load"
        )
    parts, vertex_count, face_count = _count(model)
    check_mesh(vertex_count, face_count, parts, str(model.path))
    book = PathBook()
    vertices = [np.empty((0, 3))]
    faces = [np.empty((0, 3), dtype=np.uint32)]
    names: list[str] = []
    paths: list[str] = []
    base = 0
    stack = [(use, "", np.eye(4)) for use in reversed(model.items)]
    while stack:
        use, above, world = stack.pop()
        found = model.objects[use.target]
        name = use.name or found.name
        path = book.claim(above, name)
        m = use.matrix
        world = ((world[:, 0:1] * m[0] + world[:, 1:2] * m[1]) + world[:, 2:3] * m[2]) + world[:, 3:4] * m[3]
        if len(found.faces):
            vertices.append(transform(found.vertices, world))
            faces.append(shift_indices(found.faces, base, len(found.vertices)))
            base += len(found.vertices)
            names.append(name)
            paths.append(path)
        stack.extend((below, path, world) for below in reversed(found.uses))
    if progress:
        progress(1.0, f"reading {model.path.name}")
    part_of_face = np.repeat(np.arange(len(names), dtype=np.uint32), [len(f) for f in faces[1:]])
    try:
        unit = parse_unit(model.unit)
    except ValueError:
        raise model.fail(f"the unit {model.unit[:40]!r} is none of 3MF") from None
    return RawMesh(
        np.concatenate(vertices), np.concatenate(faces), part_of_face, names, paths, unit=unit, notes=model.notes
    )


def _count(model: _Model) -> tuple[int, int, int]:
    """Return (parts, vertices, triangles) of the build, before any of it is made; refuse cycles and missing objects.

    Objects may be shared by many components, so a small file can stand for an astronomic build: it is counted first.
    """
    totals: dict[_ObjectKey, tuple[int, int, int, int]] = {}  # parts, vertices, triangles, depth
    open_now: set[_ObjectKey] = set()
    for item in model.items:
        stack = [item.target]
        while stack:
            key = stack[-1]
            if key in totals:
                stack.pop()
                continue
            found = model.objects.get(key)
            if found is None:
                raise model.fail(f"object {key[1][:20]!r} is used and not defined")
            missing = [use.target for use in found.uses if use.target not in totals]
            if missing:
                if key in open_now and any(target in open_now for target in missing):
                    raise model.fail(f"object {key[1][:20]!r} contains itself: the components are a cycle")
                open_now.add(key)
                stack.extend(missing)
                continue
            open_now.discard(key)
            below = [totals[use.target] for use in found.uses]
            depth = 1 + max((b[3] for b in below), default=0)
            if depth > MAX_DEPTH:
                raise model.fail(f"the assembly is more than {MAX_DEPTH} levels deep")
            totals[key] = (
                1 + sum(b[0] for b in below),
                len(found.vertices) + sum(b[1] for b in below),
                len(found.faces) + sum(b[2] for b in below),
                depth,
            )
            stack.pop()
    chosen = [totals[item.target] for item in model.items]
    return sum(c[0] for c in chosen), sum(c[1] for c in chosen), sum(c[2] for c in chosen)
