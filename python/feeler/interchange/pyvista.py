"""Data of PyVista: surfaces of any polygons, blocks of them, and the surfaces of volumes."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import MeshError
from feeler.interchange.assembly import Assembly
from feeler.io.polygons import describe, triangulate
from feeler.words import counted

Ints = npt.NDArray[np.int64]
_MAX_DEPTH = 50


def is_ours(held: Any) -> bool:
    """Whether it is a data set, or blocks of them."""
    return _is_blocks(held) or (hasattr(held, "points") and (_has_faces(held) or hasattr(held, "extract_surface")))


def hint(held: Any) -> str | None:
    """The error for an object of VTK itself."""
    return " (first: pyvista.wrap(it))" if hasattr(held, "GetNumberOfPoints") and not is_ours(held) else None


def add(assembly: Assembly, held: Any, path: tuple[str, ...], depth: int = 0) -> None:
    """Adds a surface, or the blocks of many, each a part."""
    if depth > _MAX_DEPTH:
        raise MeshError(f"blocks within blocks, more than {_MAX_DEPTH} deep: does one contain itself?")
    if _is_blocks(held):
        names = [str(name) for name in held.keys()]  # noqa: SIM118 - it is no mapping, and iterates over blocks
        for i, name in enumerate(names):
            block = held[i]
            if block is None:
                assembly.skip("empty blocks")
            elif is_ours(block):
                add(assembly, block, (*path, name), depth + 1)
            else:
                assembly.skip(f"blocks ({type(block).__name__})")
        return
    if not _has_faces(held):
        assembly.notes.append(f"{'/'.join(path) or type(held).__name__}: the surface of a {type(held).__name__}")
        # Newer versions warn unless one of two modes is chosen.
        ways = inspect.signature(held.extract_surface).parameters
        held = held.extract_surface(**({"algorithm": "dataset_surface"} if "algorithm" in ways else {}))
    points = np.asarray(held.points)
    padded = _padded(held, "faces")
    faces, notes, doubts = _polygons(padded, np.asarray(points, dtype=np.float64), "/".join(path) or "faces")
    strips = _strips(_padded(held, "strips"), "/".join(path) or "strips")
    for what, name in (("lines", "lists of lines"), ("verts", "lists of points")):
        if len(_padded(held, what)):
            assembly.skip(name)
    for said, found in ((assembly.notes, notes), (assembly.doubts, doubts)):
        said += [f"{'/'.join(path)}: {line}" if path else line for line in found]
    assembly.add(path or ("part",), points, np.concatenate([faces, strips]))


def _is_blocks(held: Any) -> bool:
    return hasattr(held, "n_blocks") and hasattr(held, "keys") and hasattr(held, "__getitem__")


def _has_faces(held: Any) -> bool:
    # A volume may have faces too, as a method or in another form.
    return hasattr(held, "faces") and hasattr(held, "lines") and np.asarray(held.faces).ndim == 1


def _padded(held: Any, what: str) -> Ints:
    values = np.asarray(getattr(held, what, ()))
    if values.size and values.dtype.kind not in "iu":
        raise MeshError(f"{what} have dtype {values.dtype}: whole numbers, n and then n indices, are needed")
    return values.astype(np.int64).reshape(-1)


def _split(padded: Ints, where: str) -> tuple[Ints, Ints]:
    """Splits cells that each begin with their size: all corners in a row, and the sizes."""
    sizes = []
    at = 0
    while at < len(padded):
        size = int(padded[at])
        if size < 0 or at + 1 + size > len(padded):
            raise MeshError(f"{where}: entry {at} says that {size} corners follow, and {len(padded) - at - 1} do")
        sizes.append(size)
        at += 1 + size
    counts = np.array(sizes, dtype=np.int64)
    heads = np.cumsum(counts + 1) - counts - 1
    keep = np.ones(len(padded), dtype=bool)
    keep[heads] = False
    return padded[keep], counts


def _polygons(padded: Ints, points: npt.NDArray[np.float64], where: str) -> tuple[Ints, list[str], list[str]]:
    # Usually all cells are triangles.
    if len(padded) % 4 == 0 and (padded[::4] == 3).all():
        return padded.reshape(-1, 4)[:, 1:], [], []
    corners, sizes = _split(padded, where)
    done = triangulate(corners, sizes, points)
    notes, doubts = describe(done)
    if done.thin:
        notes.append(counted(done.thin, "polygons with fewer than three corners have no triangle"))
    return done.faces, notes, doubts


def _strips(padded: Ints, where: str) -> Ints:
    corners, sizes = _split(padded, where)
    triangles = []
    at = 0
    for size in sizes.tolist():
        strip = corners[at : at + size]
        at += size
        if size >= 3:
            each = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
            each[1::2] = each[1::2, [1, 0, 2]]  # every second one is reversed
            triangles.append(each)
    return np.concatenate(triangles) if triangles else np.empty((0, 3), dtype=np.int64)
