"""Joins meshes, each a part with a path, at their places, in metres."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import UNREADABLE, unmasked
from feeler.errors import MeshError, OptionError
from feeler.io.raw import OUT_OF_RANGE, PathBook, clean_name
from feeler.io.units import Unit, parse_unit
from feeler.mockup import Meshes
from feeler.source import Source
from feeler.words import counted

Floats = npt.NDArray[np.float64]


class Assembly:
    """Collects meshes; `meshes` joins them."""

    def __init__(self, format_name: str, unit: str | None = None) -> None:
        """`unit`: overrides the unit of the objects; None: the unit that they state, else the metre."""
        self.notes: list[str] = []
        self.doubts: list[str] = []
        self.files: list[str] = []
        self._format = format_name
        self._given = None if unit is None else parse_unit(unit)
        self._stated: set[Unit] = set()
        self._silent = False
        self._book = PathBook()
        self._vertices: list[Floats] = []
        self._are_metres: list[bool] = []
        self._faces: list[npt.NDArray[Any]] = []
        self._parts: list[npt.NDArray[np.int64]] = []
        self._names: list[str] = []
        self._paths: list[str] = []
        self._skipped: Counter[str] = Counter()
        self._vertex_count = 0

    def add(
        self,
        path: tuple[str, ...],
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        matrix: npt.ArrayLike | None = None,
        unit: str | None = None,
        in_metres: bool = False,
    ) -> None:
        """Adds a part.

        `path`: names from the top down; `matrix`: assembly_from_mesh, (4, 4), affine, in the object's unit; `unit`: the
        object's own; `in_metres`: it is in metres, whatever unit is given for others. If the matrix mirrors, triangles
        are reversed, so that the outside stays outside. Raises `MeshError` for arrays that are not a mesh, with the
        path.
        """
        self.add_parts(path, vertices, faces, 0, [()], matrix=matrix, unit=unit, in_metres=in_metres)

    def add_parts(
        self,
        path: tuple[str, ...],
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        part_of_face: npt.ArrayLike,
        below: Sequence[tuple[str, ...]],
        *,
        matrix: npt.ArrayLike | None = None,
        unit: str | None = None,
        in_metres: bool = False,
    ) -> None:
        """Adds a mesh with parts; their paths are `path` followed by their own of `below`. Otherwise as `add`.

        Parts without triangles are counted in the notes instead.
        """
        where = "/".join(path) or "the mesh"
        points = self._array(where, "vertices", vertices, "fiu").astype(np.float64)
        corners = self._array(where, "faces", faces, "iu").astype(np.int64)
        if not len(corners):
            self.skip("meshes")
            return
        if unit is None:
            self._silent |= not in_metres
        else:
            self._stated.add(parse_unit(unit))
        # An index without a vertex must not refer to a vertex of the next mesh.
        outside = (corners < 0) | (corners >= len(points))
        if matrix is not None:
            placed = _affine(where, matrix)
            points = points @ placed[:3, :3].T + placed[:3, 3]
            if np.linalg.det(placed[:3, :3]) < 0:
                corners, outside = corners[:, ::-1], outside[:, ::-1]
        self._faces.append(np.where(outside, OUT_OF_RANGE, corners + self._vertex_count))
        self._vertices.append(points)
        self._are_metres.append(in_metres)
        self._parts.append(np.broadcast_to(np.asarray(part_of_face, dtype=np.int64), len(corners)) + len(self._names))
        self._vertex_count += len(points)
        for own in below:
            self._claim((*path, *own))

    def add_bare(self, path: tuple[str, ...]) -> None:
        """Adds a part without triangles."""
        self._claim(path)

    def _claim(self, path: tuple[str, ...]) -> None:
        names = [clean_name(str(name), "part") for name in path] or ["part"]
        self._names.append(names[-1])
        self._paths.append(self._book.claim("/".join(name.replace("/", "_") for name in names[:-1]), names[-1]))

    def skip(self, what: str) -> None:
        """Counts an object without triangles, for the report."""
        self._skipped[what] += 1

    @property
    def part_count(self) -> int:
        """The number of parts so far."""
        return len(self._names)

    @property
    def is_empty(self) -> bool:
        """Whether no mesh with a triangle was added."""
        return not self._faces

    def meshes(self, seconds: float = 0.0) -> Meshes:
        """All meshes joined, in metres. Raises `MeshError` if there is no triangle, or if units differ."""
        notes = [
            *self.doubts,
            *self.notes,
            *(counted(count, f"{what} without triangles") for what, count in self._skipped.items()),
        ]
        if self.is_empty:
            raise MeshError(f"{self._format}: no triangle in it ({'; '.join(notes) or 'no mesh'}): give surfaces")
        unit, source = self._unit()
        with np.errstate(over="ignore", invalid="ignore"):  # the mock-up counts values beyond float64
            scaled = zip(self._vertices, self._are_metres, strict=True)
            vertices = np.concatenate([each if is_metres else each * unit.metres for each, is_metres in scaled])
        return Meshes(
            vertices,
            np.concatenate(self._faces),
            np.concatenate(self._parts),
            self._names,
            self._paths,
            Source(
                tuple(self.files),
                self._format,
                unit.name,
                source,
                seconds,
                notes=tuple(notes),
                doubts=tuple(self.doubts),
            ),
        )

    def _unit(self) -> tuple[Unit, str]:
        if all(self._are_metres):
            if self._given is not None:
                raise OptionError(
                    f"unit is {self._given.name!r}, and is for mesh objects: mock-ups, tools and pairs of arrays are "
                    "in metres, so scale the vertices"
                )
            return parse_unit("m"), "mock-ups, tools and pairs of arrays are in metres"
        if self._given is not None:
            others = sorted(unit.name for unit in self._stated - {self._given})
            return self._given, "given by unit=" + (f", instead of the {', '.join(others)} stated" if others else "")
        if not self._stated:
            return parse_unit("m"), "assumed: none is stated and none was given by unit="
        if len(self._stated) > 1 or self._silent:
            units = ", ".join(sorted(unit.name for unit in self._stated)) + (", and none" if self._silent else "")
            raise MeshError(
                f"{self._format}: its meshes state different units ({units}): bring them to one, or give unit="
            )
        return next(iter(self._stated)), "stated by the object"

    @staticmethod
    def _array(where: str, what: str, values: npt.ArrayLike, kinds: str) -> npt.NDArray[Any]:
        unmasked(f"{where}: {what}", values, MeshError)
        try:
            array = np.asarray(values)
        except UNREADABLE as error:
            raise MeshError(f"{where}: its {what} cannot be read as an array: {error}") from error
        if array.size == 0:
            return np.empty((0, 3), dtype=np.float64 if "f" in kinds else np.int64)
        if "f" not in kinds and array.dtype.kind == "f" and (array == np.rint(array)).all():
            array = np.where(np.abs(array) < OUT_OF_RANGE, array, OUT_OF_RANGE).astype(np.int64)
        if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in kinds:
            numbers = "real" if "f" in kinds else "whole"
            raise MeshError(
                f"{where}: its {what} have shape {array.shape} and dtype {array.dtype}: (n, 3) {numbers} "
                "numbers are needed"
            )
        return array


def _affine(where: str, matrix: npt.ArrayLike) -> Floats:
    try:
        placed = np.asarray(matrix, dtype=np.float64)
    except UNREADABLE as error:
        raise MeshError(f"{where}: its placement cannot be read as a matrix: {error}") from error
    if placed.shape != (4, 4) or not np.isfinite(placed).all() or not np.allclose(placed[3], [0, 0, 0, 1], atol=1e-9):
        raise MeshError(f"{where}: its placement is not a finite (4, 4) matrix with a last row of 0, 0, 0, 1")
    return placed
