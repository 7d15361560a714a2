"""COLLADA (.dae), with the file's unit, through the package pycollada (`pip install pycollada`)."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from feeler.errors import LoadError
from feeler.io.limits import MAX_DEPTH, MAX_PARTS, check_mesh
from feeler.io.placing import shift_indices, transform
from feeler.io.raw import PathBook, Progress, RawMesh, clean_name, seal_indices
from feeler.io.units import Unit

_MAX_BYTES = 512 * 2**20  # the whole tree is held as Python objects, about twenty times this


def read_collada(path: Path, progress: Progress = None) -> RawMesh:
    """Read a COLLADA file: one part for every placed geometry. Axes stay as in the file, whatever its `up_axis`."""
    try:
        collada: Any = importlib.import_module("collada")
    except ImportError:
        raise LoadError(
            f"{path}: COLLADA files need the package pycollada; install it with: pip install pycollada"
        ) from None
    data = path.read_bytes()
    if len(data) > _MAX_BYTES:
        raise LoadError(f"{path}: {len(data):,} bytes of COLLADA are too many; convert it to GLB")
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise LoadError(f"{path}: the XML declares a document type, which COLLADA has no use for; it was not opened")
    if progress:
        progress(0.0, f"reading {path.name}")
    common = collada.common
    ignored = [common.DaeUnsupportedError, common.DaeBrokenRefError]
    with path.open("rb") as file:
        document = collada.Collada(file, ignore=ignored, aux_file_loader=lambda name: None)
    notes = (
        [f"{len(document.errors)} things were not understood, the first: {document.errors[0]}"]
        if document.errors
        else []
    )
    vertices = [np.empty((0, 3))]
    faces = [np.empty((0, 3), dtype=np.uint32)]
    names: list[str] = []
    paths: list[str] = []
    book = PathBook()
    base = triangle_count = skipped = 0
    scene = document.scene
    stack: list[tuple[Any, str, Any, int]] = [
        (node, "", np.eye(4), 0) for node in reversed(scene.nodes if scene else [])
    ]
    visits = 0
    while stack:
        node, above, world, depth = stack.pop()
        visits += 1
        if visits > MAX_PARTS:  # nodes may be shared, so a small file can stand for an astronomic scene
            raise LoadError(f"{path}: the scene has more than {MAX_PARTS:,} nodes; convert it to GLB")
        if depth > MAX_DEPTH:
            raise LoadError(f"{path}: the assembly is more than {MAX_DEPTH} levels deep")
        if isinstance(node, collada.scene.GeometryNode):
            points, corners, lines = _triangles(collada, node.geometry)
            skipped += lines
            if len(corners):
                triangle_count += len(corners)
                check_mesh(base + len(points), triangle_count, len(names) + 1, str(path))
                name = clean_name(node.geometry.name, "") or clean_name(node.geometry.id, "geometry")
                vertices.append(transform(points, world))
                faces.append(shift_indices(corners, base, len(points)))
                base += len(points)
                names.append(name)
                paths.append(book.claim(above, name))
            continue
        if isinstance(node, collada.scene.NodeNode):
            stack.append((node.node, above, _multiply(world, node.matrix), depth + 1))
        elif isinstance(node, collada.scene.Node):
            inner = _multiply(world, node.matrix)
            label = book.claim(above, clean_name(node.xmlnode.get("name"), "") or clean_name(node.id, "node"))
            stack.extend((child, label, inner, depth + 1) for child in reversed(node.children))
    if skipped:
        notes.append(f"{skipped:,} primitives of lines were skipped: only triangles collide")
    part_of_face = np.repeat(np.arange(len(names), dtype=np.uint32), [len(f) for f in faces[1:]])
    metres = document.assetInfo.unitmeter
    unit = Unit(str(document.assetInfo.unitname or "unit"), float(metres)) if metres else Unit("m", 1.0)
    return RawMesh(np.concatenate(vertices), np.concatenate(faces), part_of_face, names, paths, unit=unit, notes=notes)


def _triangles(collada: Any, geometry: Any) -> tuple[Any, Any, int]:
    """Return (points, corners, primitives skipped) of one geometry in its own frame."""
    points, corners, skipped, base = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.uint32)], 0, 0
    for primitive in geometry.primitives:
        if isinstance(primitive, collada.lineset.LineSet):
            skipped += 1
            continue
        if hasattr(primitive, "triangleset"):
            primitive = primitive.triangleset()
        if primitive.vertex is None or primitive.vertex_index is None or not len(primitive.vertex_index):
            continue
        points.append(np.asarray(primitive.vertex, dtype=np.float64))
        sealed = seal_indices(np.asarray(primitive.vertex_index, dtype=np.int64).reshape(-1, 3), len(points[-1]))
        corners.append(shift_indices(sealed, base, len(points[-1])))
        base += len(points[-1])
    return np.concatenate(points), np.concatenate(corners), skipped


def _multiply(a: Any, b: Any) -> Any:
    b = np.asarray(b, dtype=np.float64)
    return ((a[:, 0:1] * b[0] + a[:, 1:2] * b[1]) + a[:, 2:3] * b[2]) + a[:, 3:4] * b[3]
