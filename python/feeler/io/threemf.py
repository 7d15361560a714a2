"""3MF: build items and components as parts, with the file's unit.

Our own XML reader on expat. It streams, so memory follows the mesh and not the XML; it refuses document type
declarations (entity bombs); and it checks the sizes in the archive before it opens a member. Axes stay as in the file:
z is up by the standard. Vertices are transformed as described in `feeler.io.placing`; mirrored parts get their faces
turned.

Objects without triangles are skipped and noted with their extension, and the rest is loaded; if nothing is left, the
error lists them.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from feeler.errors import LoadError
from feeler.io.limits import MAX_DEPTH, check_mesh
from feeler.io.placing import IDENTITY, Matrix, facing, multiply, shift_indices, transform
from feeler.io.raw import PathBook, RawMesh, clean_name
from feeler.io.rounding import PlacementErrors, of_numbers
from feeler.io.stated import Stated
from feeler.io.tally import Tally
from feeler.io.threemf_model import STAND_INS, Model, Object, ObjectKey, read_models
from feeler.io.threemf_package import Package
from feeler.io.threemf_slicers import apply_settings
from feeler.io.units import parse_unit
from feeler.progress import Progress
from feeler.words import plural

_UNREACHED = "objects with triangles are reached from no item of the build and were left out"
_TYPES = ("solidsupport", "support", "surface", "other")
_URI_SHOWN = 120


def read_3mf(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read a 3MF file: one part for every mesh of every build item."""
    try:
        with zipfile.ZipFile(path) as archive:
            model = Model(Package(path, archive), Tally())
            root = model.package.root_model()
            read_models(model, root, progress)
            apply_settings(model, root)
    except (zipfile.BadZipFile, zlib.error, zipfile.LargeZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise LoadError(
            f"{path}: the archive is damaged, truncated or encrypted ({error}); export the file again"
        ) from error
    if not model.items:
        raise model.package.fail(
            f"the build has no item (and the file {plural(len(model.objects), 'object')}): there is nothing to load"
        )
    check_mesh(*_count(model), str(path))
    raw = _assemble(model)
    if progress:
        progress(1.0, f"reading {path.name}")
    return raw


def _assemble(model: Model) -> RawMesh:
    """Walk from the items to the meshes, without recursion; every object is known, and there is no cycle."""
    tally = model.tally
    book, stated = PathBook(), Stated(tally)
    vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.uint32)]
    names: list[str] = []
    paths: list[str] = []
    base = 0
    reached: set[ObjectKey] = set()
    errors = PlacementErrors()
    placed: list[tuple[Object, Matrix, int]] = []
    stack = [(use, "", IDENTITY, -1) for use in reversed(model.items)]
    while stack:
        use, above, world, row = stack.pop()
        found = model.objects[use.target]
        name = use.name or found.name
        if use.target not in reached:
            reached.add(use.target)
            _tell(found, tally)
        if needs := use.needs or found.needs:
            tally.add(f"uses of objects need the extension '{_shown(needs)}', which is not read, and are missing", name)
            continue
        path = book.claim(above, name)
        world, row = multiply(world, use.matrix), errors.add(row, use.matrix)
        if len(found.faces):
            vertices.append(transform(found.vertices, world))
            faces.append(shift_indices(facing(found.faces, world), base, len(found.vertices)))
            base += len(found.vertices)
            placed.append((found, world, row))
            names.append(name)
            paths.append(path)
            stated.add(stated.flat(use.attributes), stated.flat(found.attributes), name=name)
        stack.extend((below, path, world, row) for below in reversed(found.uses))
    for key, found in model.objects.items():
        if len(found.faces) and key not in reached and key not in model.operands:
            tally.add(_UNREACHED, found.name)
    try:
        unit = parse_unit(model.unit)
    except ValueError:
        raise model.package.fail(f"the unit {model.unit[:40]!r} is unknown in 3MF") from None
    required = [f"the file requires the extension '{_shown(uri)}', which is not read" for uri in model.unread]
    return RawMesh(
        np.concatenate(vertices),
        np.concatenate(faces),
        np.repeat(np.arange(len(names), dtype=np.uint32), [len(f) for f in faces[1:]]),
        names,
        paths,
        unit=unit,
        notes=tally.notes(),
        up="z",
        doubts=required + tally.doubts(),
        attributes=stated.attributes(),
        rounding=_rounding(placed, errors),
    )


def _rounding(placed: list[tuple[Object, Matrix, int]], errors: PlacementErrors) -> float:
    """That of meshes, each with its place in the world and its number among the errors of placements."""
    meshes = {id(found): found.vertices for found, _, _ in placed}
    own, bounds = of_numbers(np.concatenate([np.empty((0, 3)), *meshes.values()])), errors.bounds()
    return max((errors.placed(own, each.vertices, world, bounds[row]) for each, world, row in placed), default=0.0)


def _tell(found: Object, tally: Tally) -> None:
    """Count the notes on an object, when it is reached first."""
    for kind in found.lacks:
        tally.add(kind, found.name, is_doubtful=kind in STAND_INS)
    if found.kind != "model" and (len(found.faces) or found.uses):
        of = f"of the type '{found.kind}'" if found.kind in _TYPES else "of an unknown type"
        tally.add(f"objects {of} were taken like all others", found.name)


def _shown(uri: str) -> str:
    return clean_name(uri, "")[:_URI_SHOWN]


def _count(model: Model) -> tuple[int, int, int]:
    """Return (vertices, triangles, parts) of the build, before it is made; refuse cycles and missing objects.

    Many components may share an object, so that a small file can describe an enormous build: it is counted first.
    """
    totals: dict[ObjectKey, tuple[int, int, int, int]] = {}  # vertices, triangles, parts, depth
    open_now: set[ObjectKey] = set()
    for item in model.items:
        model.object(item, "an item of the build")
        stack: list[ObjectKey] = [item.target]
        while stack:
            key = stack[-1]
            if key in totals:
                stack.pop()
                continue
            found = model.objects[key]
            for use in found.uses:
                model.object(use, f"{found.name!r}")
            missing = [use.target for use in found.uses if use.target not in totals]
            if missing:
                if key in open_now and any(target in open_now for target in missing):
                    raise model.package.fail(
                        f"object {key[1][:20]!r} ({found.name!r}) contains itself: the components are a cycle"
                    )
                open_now.add(key)
                stack.extend(missing)
                continue
            open_now.discard(key)
            below = [totals[use.target] for use in found.uses]
            depth = 1 + max((b[3] for b in below), default=0)
            if depth > MAX_DEPTH:
                raise model.package.fail(f"the assembly is more than {MAX_DEPTH} levels deep")
            totals[key] = (
                len(found.vertices) + sum(b[0] for b in below),
                len(found.faces) + sum(b[1] for b in below),
                1 + sum(b[2] for b in below),
                depth,
            )
            stack.pop()
    chosen = [totals[item.target] for item in model.items]
    return sum(c[0] for c in chosen), sum(c[1] for c in chosen), sum(c[2] for c in chosen)
