"""The result of every reader: plain arrays in the file's own numbers, with names, paths, unit and notes."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from feeler.attributes import Attributes
from feeler.io.units import Unit
from feeler.progress import Progress

Axis: TypeAlias = Literal["x", "y", "z"]
"""A coordinate axis, as the up direction of a file."""

OUT_OF_RANGE = 0xFFFFFFFF
"""Marks an index in `faces` without a vertex. The triangle is kept and the mock-up reports it."""

AT_REST = "animations were not played: parts lie where the scene puts them"
"""The note of a file that has animations."""

_MAX_LABEL = 200
_MAX_PATH = 4000
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


@dataclass(eq=False)
class RawMesh:
    """One file as read: nothing merged, dropped or moved.

    vertices      (n, 3) float64, in the file's unit, world frame of the file
    faces         (m, 3) uint32, in the file's order; `OUT_OF_RANGE` for an index without a vertex
    part_of_face  (m,) uint32, index into `part_names`
    part_paths    path of each part inside the file; empty for a file that is one nameless part
    unit          the unit that the file states, or None
    in_metres     the reader's library has already converted `vertices` from `unit` to metres (STEP)
    up            the up axis by the format's standard or the file's statement, or None
    colours       (parts, 3) sRGB, 0 to 1, NaN for a part without one; None: no colours
    attributes    of each part its attributes; None: no part has any
    rounding      the largest error of a coordinate, in the unit of `vertices`; None: the reader does not know it
    nodes         (parts,) of glTF: the node of each part, -1 for none; None: of other formats, and of several files
    doubts        like `notes`, but for what makes answers about the mesh doubtful: commands print them as warnings
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]
    part_of_face: NDArray[np.uint32]
    part_names: list[str]
    part_paths: list[str]
    unit: Unit | None = None
    in_metres: bool = False
    notes: list[str] = field(default_factory=list)
    up: Axis | None = None
    colours: NDArray[np.float64] | None = None
    doubts: list[str] = field(default_factory=list)
    attributes: Attributes | None = None
    nodes: list[int] | None = None
    rounding: float | None = None


def portion(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a progress callable that maps 0..1 onto `low..high` of the given one."""
    if progress is None:
        return None
    outer = progress

    def inner(fraction: float, stage: str) -> None:
        outer(low + (high - low) * min(max(fraction, 0.0), 1.0), stage)

    return inner


def clean_name(name: object, default: str) -> str:
    """Return the name without control characters (they could steer a terminal), or the default if none is left."""
    if isinstance(name, str) and name.isprintable():
        return name.strip() or default
    text = _CONTROL.sub("", name).strip() if isinstance(name, str) else ""
    # A lone surrogate cannot be printed or stored as UTF-8.
    return text.encode("utf-8", "replace").decode("utf-8") or default


class PathBook:
    """Makes part paths unique: the second `a/b` becomes `a/b#2`.

    A `/` inside a name becomes `_`, because it would read as a level. Labels are cut at 200 characters; levels beyond
    4000 characters of path are left out of it (a number keeps it unique).
    """

    def __init__(self) -> None:
        self._used: set[str] = set()
        self._next: dict[str, int] = {}

    def claim(self, parent: str, name: str) -> str:
        """Return the path of a child called `name` under `parent` ("" is the top) and mark it as taken."""
        label = name.replace("/", "_")[:_MAX_LABEL]
        wanted = f"{parent}/{label}" if parent else label
        return self.claim_path(wanted if len(wanted) <= _MAX_PATH else parent)

    def claim_path(self, wanted: str) -> str:
        """Return `wanted`, or the first free one of `wanted#2`, `wanted#3` ..., and mark it as taken."""
        path = wanted
        while path in self._used:
            number = self._next.get(wanted, 2)
            self._next[wanted] = number + 1
            path = f"{wanted}#{number}"
        self._used.add(path)
        return path


def joined_attributes(meshes: Sequence[RawMesh]) -> Attributes | None:
    """The attributes of the parts of several meshes, one mesh after the other."""
    if all(mesh.attributes is None for mesh in meshes):
        return None
    none: dict[str, str] = {}
    return tuple(row for mesh in meshes for row in (mesh.attributes or itertools.repeat(none, len(mesh.part_names))))


def seal_indices(indices: NDArray[np.integer[Any]], vertex_count: int) -> NDArray[np.uint32]:
    """Return the indices as uint32, those outside 0..vertex_count-1 as `OUT_OF_RANGE`."""
    if indices.size == 0:
        return indices.astype(np.uint32)
    if int(indices.max()) < vertex_count and int(indices.min()) >= 0:
        return indices.astype(np.uint32, copy=False)
    return np.where((indices >= 0) & (indices < vertex_count), indices, OUT_OF_RANGE).astype(np.uint32)


def weld(
    vertices: NDArray[np.float64], corners: NDArray[np.uint32] | None
) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Merge vertices that are equal bit for bit (-0.0 counts as 0.0); return (vertices, corners re-pointed).

    Lossless: every corner keeps its coordinates. `corners` None means 0, 1, 2, ... : a triangle soup.
    """
    from feeler._core import weld_vertices

    unique, index = weld_vertices(vertices)
    if corners is None:
        return unique, index
    if corners.size and int(corners.max()) >= len(vertices):
        keep = corners < len(vertices)
        return unique, np.where(keep, index[np.where(keep, corners, 0)], OUT_OF_RANGE).astype(np.uint32)
    return unique, index[corners]
