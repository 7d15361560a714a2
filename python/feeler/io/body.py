"""Triangles with parts and colours: the common input of the writers and of `feeler.picture`."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_flag, check_ids, check_kind, check_list, shown
from feeler.errors import MeshError, OptionError
from feeler.poses import QUERY_DEVIATION, PoseLike, nearest_rigid, one_pose

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Colour = tuple[float, float, float]

# sRGB, 0 to 1.
LIGHT_GREY: Colour = (0.80, 0.81, 0.82)
TINT: Colour = (0.93, 0.72, 0.66)
RED: Colour = (0.87, 0.06, 0.08)
ORANGE: Colour = (1.00, 0.52, 0.05)
STEEL_BLUE: Colour = (0.27, 0.50, 0.80)

_LARGEST_M = 1e15  # farther vertices would not survive float32 arithmetic

# Muted colours of machine parts: steel, titanium, alloys, paint. Distinct in lightness as well as in hue.
_MATERIALS: tuple[Colour, ...] = (
    (0.72, 0.74, 0.77),
    (0.55, 0.62, 0.69),
    (0.80, 0.75, 0.66),
    (0.60, 0.58, 0.56),
    (0.67, 0.72, 0.64),
    (0.84, 0.84, 0.82),
    (0.48, 0.54, 0.58),
    (0.75, 0.66, 0.55),
)


@dataclass(frozen=True, eq=False)
class Body:
    """Triangles to draw or write, in world coordinates.

    vertices: (n, 3) float64, metres. faces: (m, 3) integers. part_of_face: (m,) integers into `paths`.
    paths: "assembly/sub/part" of each part. palette: (k, 3) sRGB colours, 0 to 1.
    colour_of_face: (m,) integers into `palette`. cut: whether a section plane cuts it (pictures only).
    attributes: text by name, of each part; None: no part has any.
    """

    vertices: FloatArray
    faces: npt.NDArray[Any]
    part_of_face: npt.NDArray[Any]
    paths: tuple[str, ...]
    palette: FloatArray
    colour_of_face: npt.NDArray[Any]
    cut: bool = True
    attributes: Sequence[Mapping[str, str]] | None = None

    def __post_init__(self) -> None:
        vertices = check_array("vertices", self.vertices, (None, 3), is_finite=False)
        _check_srgb("palette", check_array("palette", self.palette, (None, 3)))
        faces: Any = self.faces
        if not isinstance(faces, np.ndarray) or faces.dtype.kind not in "iu" or faces.shape[1:] != (3,):
            raise MeshError(f"faces is {shown(faces)}: give whole numbers, (m, 3)")
        paths = check_list("paths", self.paths, "a path for each part")
        for name, count in (("part_of_face", len(paths)), ("colour_of_face", len(self.palette))):
            if len(check_ids(name, getattr(self, name), count)) != len(faces):
                raise MeshError(f"{name} does not have an entry for each of {len(faces)} faces")
        if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
            raise MeshError(f"faces refer to vertices that do not exist: there are {len(vertices)}")
        check_flag("cut", self.cut)
        if self.attributes is not None:
            self._check_attributes(len(paths))

    def _check_attributes(self, count: int) -> None:
        given = check_list("attributes", self.attributes, "text by name, for each part")
        if len(given) != count:
            raise MeshError(f"attributes has {len(given)} entries but there are {count} parts")
        for each in given:
            pairs = each.items() if isinstance(each, Mapping) else [(each, each)]
            if not all(isinstance(text, str) for pair in pairs for text in pair):
                raise MeshError(f"attributes has {shown(each)}: give text by name, for each part")

    @property
    def points(self) -> FloatArray:
        """The used vertices, (k, 3) metres, world."""
        mark = np.zeros(len(self.vertices), dtype=bool)
        mark[self.faces] = True
        return self.vertices[mark]

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner of the used vertices, (2, 3) metres."""
        used = self.points
        return np.stack([used.min(axis=0), used.max(axis=0)])


class MeshLike(Protocol):
    """A mock-up, a tool, a body, or anything else with vertices and faces."""

    @property
    def vertices(self) -> npt.ArrayLike:
        """`(n, 3)`, metres."""

    @property
    def faces(self) -> npt.ArrayLike:
        """`(m, 3)`: the vertices of each triangle."""


def body_of(
    mesh: MeshLike,
    *,
    colours: npt.ArrayLike | None = None,
    pose: PoseLike | None = None,
    cut: bool = True,
) -> Body:
    """The `Body` of a mock-up, a tool, or anything with `.vertices` and `.faces`.

    colours: None (the mesh's own `part_colours`, else one per assembly), one (3,) sRGB colour, or (parts, 3), one per
    part.
    pose: world_from_mesh, (4, 4), metres; None leaves the mesh where it is.
    Raises `PoseError` for a pose that is not rigid, `MeshError` if a face refers to a vertex that does not exist,
    `OptionError` for colours that are not 0 to 1.
    """
    if isinstance(mesh, Body):
        return mesh
    if isinstance(mesh, type) or not hasattr(mesh, "vertices") or not hasattr(mesh, "faces"):
        raise MeshError(
            f"{type(mesh).__name__} objects are not meshes: pass a mock-up, a tool, or an object with vertices and "
            "faces"
        )
    check_flag("cut", cut)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    faces = np.asarray(mesh.faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise MeshError(
            f"expected vertices (n, 3) and faces (m, 3), got {vertices.shape} and {faces.shape}: "
            "pass a mock-up, a tool, or an object with such arrays"
        )
    parts = getattr(mesh, "part_of_face", None)
    part_of_face = np.zeros(len(faces), dtype=np.int64) if parts is None else np.asarray(parts)
    names = getattr(mesh, "part_paths", None)
    paths = (str(getattr(mesh, "name", "part")),) if names is None else tuple(names)
    faces, part_of_face = _drawable(vertices, faces, part_of_face)
    if pose is not None:
        matrix = nearest_rigid(one_pose(pose), QUERY_DEVIATION)
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    palette, colour_of_part = _palette(getattr(mesh, "part_colours", None) if colours is None else colours, paths)
    attributes = getattr(mesh, "_part_attributes", None)
    if attributes is not None and len(attributes) != len(paths):
        attributes = None
    return Body(
        vertices, faces, part_of_face, paths, palette, colour_of_part[part_of_face], cut=cut, attributes=attributes
    )


@dataclass(frozen=True, eq=False)
class Mark:
    """Triangles (face indices) to show in a colour of their own."""

    faces: npt.NDArray[Any]
    colour: Colour

    def __post_init__(self) -> None:
        _check_srgb("colour", check_array("colour", self.colour, (3,)))
        check_ids("faces", self.faces, 2**32)


def with_marks(body: Body, marks: Sequence[Mark]) -> Body:
    """`body` with marked triangles; of overlapping marks, the last one counts."""
    check_kind("body", body, Body, "a feeler.io.Body")
    marks = [check_kind("marks", mark, Mark, "feeler.io.Mark objects") for mark in check_list("marks", marks, "a list")]
    colour_of_face = np.array(body.colour_of_face, dtype=np.int64)
    for number, mark in enumerate(marks):
        colour_of_face[check_ids("faces", mark.faces, len(body.faces))] = len(body.palette) + number
    return replace(
        body,
        palette=np.array([*body.palette, *(mark.colour for mark in marks)], dtype=np.float64).reshape(-1, 3),
        colour_of_face=colour_of_face,
    )


def only_faces(body: Body, keep: npt.NDArray[np.bool_]) -> Body:
    """`body` reduced to the triangles where `keep` (m,) is true, and to the parts that still have one."""
    parts, index = np.unique(body.part_of_face[keep], return_inverse=True)
    return replace(
        body,
        faces=body.faces[keep],
        part_of_face=np.asarray(index, dtype=np.int64).reshape(-1),
        paths=tuple(body.paths[part] for part in parts),
        attributes=None if body.attributes is None else [body.attributes[part] for part in parts],
        colour_of_face=body.colour_of_face[keep],
    )


def _drawable(
    vertices: FloatArray, faces: npt.NDArray[Any], part_of_face: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Collapses triangles with a bad corner, which queries skip, to a point, so that they keep their number."""
    if len(faces) == 0:
        return faces, part_of_face
    bad = np.zeros(len(faces), dtype=bool)
    if faces.max() >= len(vertices) or (faces.dtype.kind == "i" and faces.min() < 0):
        bad |= np.logical_or(faces >= len(vertices), faces < 0).any(axis=1)
    finite = np.all(np.abs(vertices) < _LARGEST_M, axis=1)
    if not finite.all():
        bad |= ~finite[np.where(bad[:, None], 0, faces)].all(axis=1)
    if bad.any():
        good = np.flatnonzero(finite)
        if len(good) == 0:
            raise MeshError(f"no vertex is finite and below {_LARGEST_M:g} m: there is nothing to show")
        faces = np.where(bad[:, None], good[0], faces)
    return faces, part_of_face


def _bytes(name: str) -> bytes:
    """A name as UTF-8; lone surrogates, which it cannot store, become question marks."""
    return name.encode("utf-8", "replace")


def _check_srgb(what: str, table: FloatArray) -> None:
    """NaN passes: a part without a colour of its own."""
    outside = table[(table < 0.0) | (table > 1.0)]
    if len(outside):
        raise OptionError(f"{what} has {outside[0]:g}: sRGB colours are 0 to 1; divide numbers up to 255 by 255")


def _palette(colours: Any, paths: tuple[str, ...]) -> tuple[FloatArray, IntArray]:
    # A colour per assembly (all but the last name of the path); crc32, because hash() changes between runs.
    groups = np.array([zlib.crc32(_bytes(path.rpartition("/")[0] or path)) for path in paths], dtype=np.int64)
    groups %= len(_MATERIALS)
    if colours is None:
        return np.array(_MATERIALS), groups
    try:
        table = np.array(colours, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"colours is {shown(colours)}: pass (3,) or one row per part, ({len(paths)}, 3)") from None
    _check_srgb("colours", table)
    if table.shape == (3,):
        return table[None, :], np.zeros(len(paths), dtype=np.int64)
    if table.shape == (len(paths), 3):
        table = np.where(np.isnan(table), np.array(_MATERIALS)[groups], table)
        palette, index = np.unique(table, axis=0, return_inverse=True)
        return palette, np.asarray(index, dtype=np.int64).reshape(-1)
    raise OptionError(f"colours has shape {table.shape}: pass (3,) or one row per part, ({len(paths)}, 3)")
