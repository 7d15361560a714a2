"""Mock-ups and tools: checked triangle meshes with names and a report of their defects."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from feeler import _core, saved
from feeler import attributes as attributes_of
from feeler._core import Packed
from feeler.arguments import UNREADABLE, check_kind, check_list, check_text, check_whole, shown, unmasked
from feeler.attributes import Attributes
from feeler.choices import DefectKind, UnitName
from feeler.errors import MeshError, OptionError
from feeler.field_docs import documented
from feeler.mesh_types import ArrayOfInts, ArrayOfRows, MeshSource
from feeler.part_meshes import PartMeshes
from feeler.parts import Parts, PartsLike
from feeler.poses import PoseLike, placed
from feeler.saved import opened_again
from feeler.source import Source
from feeler.travel import reduced
from feeler.words import counted, plural

_LOST: tuple[DefectKind, ...] = ("index_out_of_range", "non_finite", "too_large")
"""Defects that take a piece of a surface away."""
_LOST_FOR = "a vertex that does not exist or is no finite number"
_OUT_OF_RANGE = np.iinfo(np.uint32).max
VERTEX_LIMIT = 65_535
"""The most vertices of a piece for drawing: its indices have 16 bits."""


@documented
@dataclass(frozen=True)
class Defect:
    """The number of triangles with one kind of defect, and the first ids. `count, first = defect` unpacks it."""

    count: int
    first: tuple[int, ...]

    def __iter__(self) -> Iterator[Any]:
        return iter((self.count, self.first))


@documented
@dataclass(frozen=True)
class LoadReport:
    """The contents and defects of a mesh. `str()` is for people, `to_dict()` for machines.

    `defects` maps each kind to its count and first ids. Triangles counted under `index_out_of_range`, `non_finite`,
    `too_large` (beyond 1e100 m) or `zero_area` are kept but not queried; `duplicate` ones (the same corners as an
    earlier triangle) are queried like any other.
    """

    source: Source
    """The files, their unit and why, and what puts results in doubt."""
    triangles: int
    """Their number."""
    vertices: int
    """Their number."""
    parts: int
    """Their number."""
    lower: tuple[float, float, float]
    """Of the box around all, metres."""
    upper: tuple[float, float, float]
    """Of the box around all, metres."""
    defects: dict[DefectKind, Defect]

    @property
    def extent(self) -> tuple[float, float, float]:
        """Side lengths of the box around all queried triangles, metres."""
        x, y, z = (u - w for w, u in zip(self.lower, self.upper, strict=True))
        return (x, y, z)

    @property
    def not_queried(self) -> int:
        """Number of triangles that queries skip because of a defect."""
        return sum(defect.count for kind, defect in self.defects.items() if kind != "duplicate")

    def to_dict(self) -> dict[str, Any]:
        """All figures as plain Python values."""
        return {
            "files": list(self.source.files),
            "format": self.source.format,
            "unit": self.source.unit,
            "unit_source": self.source.unit_source,
            "up": self.source.up,
            "seconds": self.source.seconds,
            "notes": list(self.source.notes),
            "doubts": list(self.source.doubts),
            "triangles": self.triangles,
            "vertices": self.vertices,
            "parts": self.parts,
            "lower": list(self.lower),
            "upper": list(self.upper),
            "extent": list(self.extent),
            "not_queried": self.not_queried,
            "defects": {kind: {"count": d.count, "first": list(d.first)} for kind, d in self.defects.items()},
        }

    def __str__(self) -> str:
        x, y, z = self.extent
        lines = [
            f"{plural(self.triangles, 'triangle')} in {plural(self.parts, 'part')}, {x:.4g} x {y:.4g} x {z:.4g} m",
            f"unit {self.source.unit} ({self.source.unit_source})",
        ]
        if self.source.files:
            lines.insert(0, ", ".join(self.source.files[:3]) + (" ..." if len(self.source.files) > 3 else ""))
        for kind, defect in self.defects.items():
            if defect.count:
                ids = ", ".join(str(i) for i in defect.first[:5]) + (", ..." if defect.count > 5 else "")
                fate = "queried" if kind == "duplicate" else "not queried"
                lines.append(f"{plural(defect.count, kind.replace('_', ' ') + ' triangle')}, {fate}: {ids}")
        if not any(defect.count for defect in self.defects.values()):
            lines.append("no defects")
        if self.source.up:
            lines.append(f"{self.source.up} is up")
        lines.extend(self.source.notes)
        return "\n".join(lines)


class Meshes(NamedTuple):
    """Several meshes joined into one, as `Mockup` takes them. Vertices are in metres."""

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[Any]
    part_of_face: npt.NDArray[Any]
    part_names: list[str]
    part_paths: list[str]
    source: Source


Converter = Callable[[object, str | None], Meshes]
_converters: list[Converter] = []


def register_converter(converter: Converter) -> None:
    """Registers the function that turns a mesh object and a unit into `Meshes`: see `feeler.interchange`."""
    _converters[:] = [converter]


def _converted(held: object, unit: str | None, others: Mapping[str, object]) -> Meshes:
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise MeshError(f"{', '.join(given)} without faces: a mesh object has its own; give vertices and faces instead")
    if not _converters:
        importlib.import_module("feeler.interchange")  # registers itself; imported only when needed
    return _converters[0](held, unit)


class _Attributed:
    """A mesh whose parts have names, and may have attributes."""

    part_count: int
    _saved: saved.SavedFile | None = None
    """The file that it is in, where it was opened from one."""

    @property
    def part_names(self) -> tuple[str, ...]:
        """The name of each part. Given when it is made: others are of another mesh."""
        names: tuple[str, ...] = self.__dict__["part_names"]
        return names

    @property
    def part_paths(self) -> tuple[str, ...]:
        """Of each part its place in the assembly, such as `engine/pump/bolt`. Given when it is made, too."""
        paths: tuple[str, ...] = self.__dict__["part_paths"]
        return paths

    def _name_parts(self, names: Iterable[str], paths: Iterable[str]) -> None:
        self.__dict__.update(part_names=tuple(names), part_paths=tuple(paths))

    @property
    def source(self) -> Source:
        """Where it came from: files, unit, notes. You can set it; raises `OptionError` for anything but a `Source`."""
        source: Source = self.__dict__["source"]
        return source

    @source.setter
    def source(self, given: Source) -> None:
        self.__dict__["source"] = check_kind("source", given, Source, "a feeler.types.Source")

    @property
    def part_bounds(self) -> npt.NDArray[np.float64]:
        """`(2 * parts, 3)`: lower and upper corner of each part's box, metres; crossed if the part is empty. Read-only,
        the same array at every call: `reshape(-1, 2, 3)` has a box a row."""
        known: npt.NDArray[np.float64] | None = self.__dict__.get("_boxes")
        if known is None:
            known = self.__dict__["_boxes"] = super().part_bounds  # type: ignore[misc]
        return known

    @property
    def part_colours(self) -> npt.NDArray[np.float64] | None:
        """Colours of the parts in pictures, GLB files and the workbench, `(parts, 3)` sRGB, 0 to 1; read-only.

        A row of NaN is a part without a colour; None: no part has one. Parts without a colour get distinct ones. You
        can set it; raises `MeshError` for anything else.
        """
        own: npt.NDArray[np.float64] | None = self.__dict__.get("part_colours")
        if own is None:
            return None
        colours: npt.NDArray[np.float64] = own.view()
        colours.flags.writeable = False
        return colours

    @part_colours.setter
    def part_colours(self, given: npt.ArrayLike | None) -> None:
        self.__dict__["part_colours"] = None if given is None else _colours_of_parts(given, self.part_count)

    @cached_property
    def _part_attributes(self) -> Attributes | None:
        """Those of its file, unless others were given."""
        return None if self._saved is None else self._saved.attributes

    @property
    def part_attributes(self) -> list[dict[str, str]]:
        """Of each part its attributes, text by name: copies. You can set it: a dict for each part, or None.

        Raises `MeshError` for anything but text, and `LimitError` for more than 100 attributes of a part, names longer
        than 100 characters or values longer than 1,000.
        """
        own = self._part_attributes
        return [{} for _ in range(self.part_count)] if own is None else [dict(row) for row in own]

    @part_attributes.setter
    def part_attributes(self, given: Sequence[Mapping[str, str]] | None) -> None:
        self._keep_attributes(attributes_of.checked(given, self.part_count))

    def _known_parts(self) -> Parts:
        """Made when they are first asked for."""
        known: Parts | None = self.__dict__.get("parts")
        if known is None:
            known = self.__dict__["parts"] = _parts_of(self)  # type: ignore[arg-type]  # a mock-up or a tool
        return known

    def _keep_attributes(self, attributes: Attributes | None) -> None:
        """Keeps attributes that were checked."""
        self.__dict__.pop("parts", None)
        self._part_attributes = attributes


class Mockup(_Attributed, _core.Mockup):
    """A static mock-up: triangles in named parts, metres, right-handed.

    `vertices` is `(n, 3)`, any real dtype and memory order; `faces` `(m, 3)`, any integer dtype. `part_of_face` is
    `(m,)` with the part of each triangle, indexing `part_names`; `part_paths` are places in the assembly such as
    `"engine/fan/blade_03"` (default: the names). Triangle `i` of every result is `faces[i]`. An index outside the
    vertices may read back as 4294967295 in `.faces`.

    Instead of arrays, the first argument may be a mesh or scene of trimesh, PyVista or Open3D, any object with
    `.vertices` and `.faces`, or a list or dict of them (see `feeler.from_trimesh`, ...). A key `"b/c"` of such a dict
    is part `c` of assembly `b`, as `{"b": {"c": mesh}}` is; of equal paths the second becomes `b/c#2`. `unit` is the
    unit of the objects' numbers, by default the one they state, else the metre. A pair of arrays (vertices, faces) in
    such a list or dict is a part; pairs, mock-ups and tools are in metres, and `unit` does not scale them.

    Attributes:

    - `part_names`, `part_paths`: tuples of text, by part: the name, and the place in the assembly.
    - `part_colours`: `(parts, 3)` sRGB, 0 to 1, of pictures, GLB files and the workbench; a row of NaN is a part
      without a colour, None: no part has one. You can set it.
    - `part_attributes`: of each part a dict of text by name, such as its material. You can set it.
    - `source`: the `feeler.types.Source`: files, unit, notes.

    Raises `MeshError` for wrong shapes or dtypes, or when no triangle can be queried, and `LimitError` past 2^32 - 1.
    """

    _modelled: Mockup | None = None
    """The mock-up with all parts where they are modelled, where this one has some moved (`Scene.moved`)."""
    _moves: tuple[list[int], npt.NDArray[np.float64]] | None = None
    """Then: by part the number of its pose, or -1, and the poses."""

    @overload
    def __new__(
        cls,
        vertices: ArrayOfRows,
        faces: ArrayOfRows,
        part_of_face: ArrayOfInts | None = None,
        part_names: Sequence[str] | None = None,
        *,
        part_paths: Sequence[str] | None = None,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
    ) -> Mockup: ...
    @overload
    def __new__(
        cls,
        vertices: MeshSource,
        faces: None = None,
        *,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
        unit: UnitName | None = None,
    ) -> Mockup: ...
    def __new__(
        cls,
        vertices: ArrayOfRows | MeshSource,
        faces: ArrayOfRows | None = None,
        part_of_face: ArrayOfInts | None = None,
        part_names: Sequence[str] | None = None,
        *,
        part_paths: Sequence[str] | None = None,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
        unit: UnitName | None = None,
    ) -> Mockup:
        """See the class."""
        given = vertices
        if faces is None:
            others = {"part_of_face": part_of_face, "part_names": part_names, "part_paths": part_paths}
            vertices, faces, part_of_face, part_names, part_paths, origin = _converted(vertices, unit, others)
            source = origin if source is None else source
        elif unit is not None:
            raise OptionError(
                f"unit is {shown(unit)}, and is for mesh objects: arrays are in metres, so scale the vertices"
            )
        points = mesh_points(vertices)
        indices = mesh_indices(faces, len(points))
        parts, names, paths = _named_parts(part_of_face, part_names, part_paths, len(indices), "part")
        self = super().__new__(cls, points, indices, parts, len(names))
        self._name_parts(names, paths)
        if part_attributes is not None:
            self.part_attributes = part_attributes
        elif isinstance(given, _Attributed):
            self._keep_attributes(given._part_attributes)
        self.source = Source() if source is None else source
        self.source = _with_lost(self.source, self)
        return self

    @classmethod
    def _of_file(cls, file: saved.SavedFile) -> Mockup:
        """The mock-up of a saved scene, on the mapped memory of its file."""
        self = super().__new__(cls, file.core)
        self._saved = file
        vars(self).update(_attributes(file))
        return self

    def _with_moved(
        self, core: _core.MovedMockup, moves: tuple[list[int], npt.NDArray[np.float64]] | None = None
    ) -> Mockup:
        """The mock-up of a core in which parts of this one are moved."""
        moved = super().__new__(type(self), core)
        moved._name_parts(self.part_names, self.part_paths)
        moved.source = self.source
        moved.part_colours = self.part_colours
        moved._keep_attributes(self._part_attributes)
        moved._modelled, moved._moves = self, moves
        return moved

    @cached_property
    def _remembered(self) -> dict[Any, Any]:
        """What questions found of its parts as they are, by question: asked again, they look here. Not pickled."""
        return {}

    @cached_property
    def _part_meshes(self) -> PartMeshes:
        """The triangles of each part. Not pickled."""
        return PartMeshes(self)

    @property
    def parts(self) -> Parts:
        """The parts, a sequence of `Part`."""
        return self._known_parts()

    @property
    def defects(self) -> dict[DefectKind, Defect]:  # type: ignore[override]  # the core gives pairs
        """The count and first ids of each kind of defect, as in `report`."""
        return _defects(super().defects)

    @property
    def report(self) -> LoadReport:
        """The contents and defects of the mesh."""
        return _report(self, self.source, self.part_count)

    def pack(self, vertex_limit: int = VERTEX_LIMIT, small: PartsLike | None = None) -> Packed:
        """The queried triangles in pieces for drawing, of at most `vertex_limit` (3 to 65,535) vertices each.

        Parts are sorted by the longest side of their box, large ones first. Parts named by `small` (as `Parts.select`
        takes them: a mask, patterns) come last, in pieces of their own. A part larger than a piece spans several.
        Corners of a part that are equal in float32 share a vertex, except where the part is cut. Runs on all threads;
        the result does not depend on their number. Raises `OptionError` for a limit out of range and parts that do not
        exist.
        """
        return super().pack(_vertex_limit(vertex_limit), _mask(self.parts, small))

    def __reduce__(self) -> tuple[Any, ...]:
        """Its arrays, or the path and hash of the saved scene that they are in, and all attributes."""
        attributes = {
            name: value
            for name, value in self.__dict__.items()
            if name not in ("_saved", "_modelled", "_moves", "_boxes", "_remembered", "_part_meshes")
        }
        file = self._saved
        if file is not None and file.is_there:
            own = {**_attributes(file), "parts": attributes.get("parts")}
            if "_part_attributes" in attributes:
                own["_part_attributes"] = file.attributes
            changed = {name: value for name, value in attributes.items() if value is not own.get(name)}
            return (*reduced("Mockup", (type(self), file.path, file.core.content_hash)), changed)
        parts = self.part_of_face if self.part_count > 1 else None
        state = (type(self), self.vertices, self.faces, parts, self.part_count)
        return (*reduced("Mockup", state), {**attributes, "_part_attributes": self._part_attributes})

    @classmethod
    def _restore(cls, *state: Any) -> Mockup:
        if isinstance(state[0], str):
            return cls._of_file(opened_again(*state))
        return super().__new__(cls, *state)

    def __repr__(self) -> str:
        return f"Mockup({plural(self.triangle_count, 'triangle')}, {plural(self.part_count, 'part')})"


class Tool(_Attributed, _core.Tool):
    """A moving tool in its own frame, metres; prepared once, usable with any number of scenes and threads.

    `vertices` is `(n, 3)`, any real dtype and memory order; `faces` `(m, 3)`, any integer dtype. It may have parts,
    like a mock-up: results name the colliding one, and queries can ignore some. `Tool.of_parts` makes a tool from parts
    of a mock-up, `Tool.assembly` one from several tools. Instead of arrays, the first argument may be a mesh object, as
    for `Mockup`, or a whole `Mockup`.

    Attributes: `name`; `part_names`, `part_paths`, `part_colours`, `part_attributes` and `source` as of `Mockup`.

    Raises `MeshError` for wrong shapes or dtypes, or when no triangle can be queried.
    """

    @overload
    def __new__(
        cls,
        vertices: ArrayOfRows,
        faces: ArrayOfRows,
        name: str = "tool",
        part_of_face: ArrayOfInts | None = None,
        part_names: Sequence[str] | None = None,
        *,
        part_paths: Sequence[str] | None = None,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
    ) -> Tool: ...
    @overload
    def __new__(
        cls,
        vertices: MeshSource,
        faces: None = None,
        name: str = "tool",
        *,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
        unit: UnitName | None = None,
    ) -> Tool: ...
    def __new__(
        cls,
        vertices: ArrayOfRows | MeshSource,
        faces: ArrayOfRows | None = None,
        name: str = "tool",
        part_of_face: ArrayOfInts | None = None,
        part_names: Sequence[str] | None = None,
        *,
        part_paths: Sequence[str] | None = None,
        part_attributes: Sequence[Mapping[str, str]] | None = None,
        source: Source | None = None,
        unit: UnitName | None = None,
    ) -> Tool:
        """See the class."""
        given = vertices
        if faces is None:
            others = {"part_of_face": part_of_face, "part_names": part_names, "part_paths": part_paths}
            vertices, faces, part_of_face, part_names, part_paths, origin = _converted(vertices, unit, others)
            source = origin if source is None else source
        elif unit is not None:
            raise OptionError(
                f"unit is {shown(unit)}, and is for mesh objects: arrays are in metres, so scale the vertices"
            )
        points = mesh_points(vertices)
        indices = mesh_indices(faces, len(points))
        check_text("name", name)
        parts, names, paths = _named_parts(part_of_face, part_names, part_paths, len(indices), name)
        self = super().__new__(cls, points, indices, parts, len(names))
        self.__dict__["name"] = name
        self._name_parts(names, paths)
        if part_attributes is not None:
            self.part_attributes = part_attributes
        elif isinstance(given, _Attributed):
            self._keep_attributes(given._part_attributes)
        self.source = Source() if source is None else source
        self.source = _with_lost(self.source, self)
        return self

    @property
    def name(self) -> str:
        """What the tool is called. You can set it; raises `OptionError` for anything but text."""
        name: str = self.__dict__["name"]
        return name

    @name.setter
    def name(self, given: str) -> None:
        self.__dict__["name"] = check_text("name", given)

    @classmethod
    def of_parts(cls, mockup: Mockup, parts: PartsLike | None = None, name: str | None = None) -> Tool:
        """Parts of a mock-up as a tool, in the mock-up's frame: the identity pose leaves them in place.

        `parts` as `Parts.select` takes them; None: all. They remain parts of the tool, in the mock-up's order; unused
        vertices are dropped. `name` defaults to the part's own name, or to the number of parts. Raises `OptionError`
        for parts that do not exist, `MeshError` if they have no triangle that can be queried.
        """
        if not isinstance(mockup, Mockup):
            raise MeshError(f"parts are of a feeler.Mockup, not of {type(mockup).__name__}")
        chosen = np.arange(mockup.part_count) if parts is None else mockup.parts.select(parts)
        if not len(chosen):
            raise OptionError("no part is named: a tool needs one at least")
        triangles = [mockup._part_meshes.triangles(int(part)) for part in chosen]
        order = np.argsort(np.concatenate(triangles), kind="stable")
        part_of_face = np.repeat(np.arange(len(chosen)), [len(each) for each in triangles])[order]
        faces = mockup.faces[np.concatenate(triangles)[order]]
        used = np.unique(faces)
        used = used[used < len(mockup.vertices)]
        low, high = (int(used[0]), int(used[-1]) + 1) if len(used) else (0, 0)
        # Indices out of range stay out of range.
        index = np.full(high - low + 1, _OUT_OF_RANGE, dtype=np.uint32)
        index[used - low] = np.arange(len(used), dtype=np.uint32)
        faces = index[np.where(faces < len(mockup.vertices), faces, high) - low]
        names, paths = ([each[i] for i in chosen] for each in (mockup.part_names, mockup.part_paths))
        if name is None:
            name = names[0] if len(names) == 1 else f"{len(names)} parts"
        if not len(faces):
            raise MeshError(f"{_first(paths)}: there are no triangles to make a tool of")
        try:
            tool = cls(mockup.vertices[used], faces, name, part_of_face, names, part_paths=paths)
        except MeshError as error:  # of a mesh, which the caller knows as parts
            raise MeshError(f"{_first(paths)}: {str(error).replace(' of the tool', '', 1)}") from None
        tool.source = mockup.source
        tool.part_colours = None if mockup.part_colours is None else mockup.part_colours[chosen]
        own = mockup._part_attributes
        tool._keep_attributes(None if own is None else tuple(own[part] for part in chosen))
        return tool

    @classmethod
    def assembly(cls, items: Mapping[str, Tool | tuple[Tool, PoseLike]], name: str = "assembly") -> Tool:
        """Several tools as one that moves as a whole: a hand with a wrench.

        `items` maps a name to a tool, or to a tool and its place `tool_from_item` `(4, 4)`: rigid, metres. Corners are
        computed as those of a tool at a pose. An item's part is named after the item, or `name/path` if it has several;
        triangles are numbered item by item. Raises `MeshError` if there is no item or one is not a tool, `PoseError`
        for a place that is not rigid.
        """
        given: object = items
        if not isinstance(given, Mapping) or not items:
            raise MeshError('an assembly is made of a dict of tools, such as {"hand": hand, "wrench": (wrench, place)}')
        vertices, faces, parts = [], [], []
        names: list[str] = []
        paths: list[str] = []
        vertex_count = 0
        for label, item in items.items():
            tool, place = item if isinstance(item, tuple) and len(item) == 2 else (item, np.eye(4))
            if not isinstance(tool, Tool):
                raise MeshError(f"assembly item {label!r} is {type(tool).__name__}: a feeler.Tool is needed")
            vertices.append(placed(tool.vertices, place, f"assembly item {label!r}"))
            outside = tool.faces >= len(tool.vertices)
            faces.append(np.where(outside, _OUT_OF_RANGE, tool.faces.astype(np.int64) + vertex_count))
            parts.append(tool.part_of_face.astype(np.int64) + len(names))
            vertex_count += len(tool.vertices)
            is_one = len(tool.part_names) == 1
            names += [str(label)] if is_one else tool.part_names
            paths += [str(label)] if is_one else [f"{label}/{path}" for path in tool.part_paths]
        return cls(
            np.concatenate(vertices), np.concatenate(faces), name, np.concatenate(parts), names, part_paths=paths
        )

    @property
    def parts(self) -> Parts:
        """The parts, a sequence of `Part`; a single one, named as the tool, unless it was made of several."""
        return self._known_parts()

    @property
    def defects(self) -> dict[DefectKind, Defect]:  # type: ignore[override]  # the core gives pairs
        """The count and first ids of each kind of defect, as in `report`."""
        return _defects(super().defects)

    @property
    def report(self) -> LoadReport:
        """The contents and defects of the mesh."""
        return _report(self, self.source, self.part_count)

    def pack(self, vertex_limit: int = VERTEX_LIMIT, small: PartsLike | None = None) -> Packed:
        """`Mockup.pack` for a tool, in its own frame."""
        return super().pack(_vertex_limit(vertex_limit), _mask(self.parts, small))

    def __reduce__(self) -> tuple[Any, ...]:
        """Its arrays and all attributes, as for other Python objects."""
        parts = self.part_of_face if self.part_count > 1 else None
        state = (type(self), self.vertices, self.faces, parts, self.part_count)
        return (*reduced("Tool", state), {name: value for name, value in self.__dict__.items() if name != "_boxes"})

    @classmethod
    def _restore(cls, *state: Any) -> Tool:
        return super().__new__(cls, *state)

    def __repr__(self) -> str:
        return f"Tool({self.name!r}, {plural(self.triangle_count, 'triangle')})"


def _attributes(file: saved.SavedFile) -> dict[str, Any]:
    """Those of a mock-up that a file describes; the same objects at every call."""
    facts = file.facts
    known: dict[str, Any] = {"part_names": facts.part_names, "part_paths": facts.part_paths, "source": facts.source}
    if facts.colours is not None:
        known["part_colours"] = facts.colours
    return known


def _parts_of(mesh: Mockup | Tool) -> Parts:
    bounds = mesh.part_bounds.reshape(-1, 2, 3)
    return Parts(mesh.part_names, mesh.part_paths, mesh.part_triangles, bounds, mesh._part_attributes)


def _first(paths: Sequence[str]) -> str:
    """The first of several parts in words, and how many more there are."""
    return ", ".join(paths[:3]) + (f" and {len(paths) - 3:,} more" if len(paths) > 3 else "")


def _vertex_limit(limit: object) -> int:
    return check_whole("vertex_limit", limit, 3, VERTEX_LIMIT)


def _mask(parts: Parts, chosen: PartsLike | None) -> list[bool] | None:
    """By part, whether it is chosen."""
    if chosen is None:
        return None
    mask = np.zeros(len(parts), dtype=bool)
    mask[parts.select(chosen)] = True
    return mask.tolist()  # type: ignore[no-any-return]


def _defects(found: Mapping[DefectKind, tuple[int, Sequence[int]]]) -> dict[DefectKind, Defect]:
    return {kind: Defect(count, tuple(first)) for kind, (count, first) in found.items()}


def lost_note(mesh: Mockup | Tool) -> str | None:
    """A sentence on triangles that no query can use, and which leave a hole in their part; None if there are none."""
    lost = sum(mesh.defects[kind].count for kind in _LOST)
    return counted(lost, f"triangles have {_LOST_FOR}, and take part in no query") if lost else None


def _with_lost(source: Source, mesh: Mockup | Tool) -> Source:
    """`source` with that note in place of one on the mesh it was made from. Loaders say it themselves, of files."""
    note = lost_note(mesh)
    if source.files or (note is None and not source.doubts):
        return source
    told = () if note is None else (note,)
    others = [tuple(line for line in lines if _LOST_FOR not in line) for lines in (source.notes, source.doubts)]
    return replace(source, notes=told + others[0], doubts=told + others[1])


def _report(mesh: _core.Mockup | _core.Tool, source: Source, parts: int) -> LoadReport:
    lower, upper = mesh.bounds
    return LoadReport(
        source, mesh.triangle_count, len(mesh.vertices), parts, _xyz(lower), _xyz(upper), _defects(mesh.defects)
    )


def _xyz(v: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    return (float(v[0]), float(v[1]), float(v[2]))


def mesh_points(vertices: object) -> npt.NDArray[np.float64]:
    """Vertices, `(n, 3) float64`. Raises `MeshError` for what is not that."""
    array = _array("vertices", vertices)
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"vertices has shape {array.shape}: (n, 3) is needed")
    if array.dtype.kind not in "fiu":
        raise MeshError(f"vertices has dtype {array.dtype}: real numbers are needed")
    with np.errstate(over="ignore"):  # a long double beyond float64 becomes an infinity, and is reported as such
        return np.ascontiguousarray(array, dtype=np.float64)


def mesh_indices(faces: object, vertices: int) -> npt.NDArray[np.uint32]:
    """Faces, `(m, 3) uint32`, of so many vertices. Raises `MeshError` for what is not that."""
    array = _array("faces", faces)
    if array.size == 0 and array.ndim <= 2:
        raise MeshError("faces is empty: a mesh needs at least one triangle")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"faces has shape {array.shape}: (m, 3) is needed; triangulate polygons first")
    whole = _whole("faces", array)
    if whole.dtype == np.uint32:
        return np.ascontiguousarray(whole)
    # An index out of range is a defect of that triangle, not an error of the call: map it to one that stays out of
    # range.
    limit = min(vertices, int(_OUT_OF_RANGE))
    if (whole.dtype.kind == "i" and whole.min() < 0) or int(whole.max()) >= limit:
        outside = (whole < 0) | (whole >= limit) if whole.dtype.kind == "i" else whole >= limit
        whole = np.where(outside, _OUT_OF_RANGE, whole)
    return np.ascontiguousarray(whole, dtype=np.uint32)


def _named_parts(
    part_of_face: object,
    part_names: Sequence[str] | None,
    part_paths: Sequence[str] | None,
    triangles: int,
    only: str,
) -> tuple[npt.NDArray[np.uint32] | None, list[str], list[str]]:
    """The part of each triangle, names and paths; a mesh of one unnamed part is named `only`."""
    parts = None
    count = 1
    if part_of_face is not None:
        parts = _part_ids(part_of_face, triangles)
        count = int(parts.max(initial=0)) + 1
    names = _names("part_names", part_names)
    paths = _names("part_paths", part_paths)
    if names is None:
        names = paths
    if names is None:
        if count > max(triangles, 1_000_000):
            raise MeshError(f"part_of_face goes up to {count - 1}: give part_names, or number the parts from 0 on")
        names = [only] if parts is None else [f"part_{i}" for i in range(count)]
    if not names:
        raise MeshError("part_names is empty: give at least one name")
    paths = names if paths is None else paths
    if len(paths) != len(names):
        raise MeshError(f"part_paths has {len(paths)} entries but part_names has {len(names)}: give as many")
    return parts, list(names), list(paths)


def _colours_of_parts(given: npt.ArrayLike, parts: int) -> npt.NDArray[np.float64]:
    """A copy. Raises `MeshError` unless each of the parts has three levels from 0 to 1, or three NaN."""
    give = f"give an array ({parts}, 3) of sRGB levels, 0 to 1, or None"
    unmasked("part_colours", given, MeshError)
    try:
        array = np.asarray(given)
        is_numbers = array.dtype.kind in "fiu"
    except UNREADABLE:
        is_numbers = False
    if not is_numbers:
        raise MeshError(f"part_colours is {shown(given)}: {give}")
    if array.shape != (parts, 3):
        raise MeshError(f"part_colours has shape {array.shape}: {give}")
    colours = np.array(array, dtype=np.float64)
    is_fit = ((colours >= 0.0) & (colours <= 1.0)).all(axis=1) | np.isnan(colours).all(axis=1)
    if not is_fit.all():
        part = int(np.argmin(is_fit))
        advice = "; divide levels up to 255 by 255" if (colours > 1.0).any() else ""
        raise MeshError(f"part_colours[{part}] is {colours[part].tolist()}: {give}, NaN for no colour{advice}")
    return colours


def _part_ids(part_of_face: object, triangles: int) -> npt.NDArray[np.uint32]:
    array = _array("part_of_face", part_of_face)
    if array.ndim != 1:
        raise MeshError(f"part_of_face has shape {array.shape}: (m,) is needed, one part index per triangle")
    if len(array) != triangles:
        raise MeshError(f"part_of_face has {len(array)} entries but there are {triangles} triangles: give as many")
    whole = _whole("part_of_face", array)
    if whole.size and (int(whole.min()) < 0 or int(whole.max()) >= _OUT_OF_RANGE):
        raise MeshError(f"part_of_face has values from {whole.min()} to {whole.max()}: indices of parts are needed")
    return np.ascontiguousarray(whole, dtype=np.uint32)


def _whole(what: str, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if array.dtype.kind in "iu":
        return array
    if array.dtype.kind != "f":
        raise MeshError(f"{what} has dtype {array.dtype}: whole numbers are needed")
    # Beyond 2^53 a float64 cannot distinguish whole numbers.
    with np.errstate(over="ignore"):
        size = np.abs(array.astype(np.float64))
    bad = ~((array == np.rint(array)) & (size < 2.0**53))
    if bad.any():
        at = tuple(int(i) for i in np.argwhere(bad)[0])
        raise MeshError(f"{what}{list(at)} is {array[at]}: whole numbers below 2^53 are needed")
    return array.astype(np.int64)


def _array(what: str, values: object) -> npt.NDArray[Any]:
    unmasked(what, values, MeshError)
    try:
        return np.asarray(values)
    except UNREADABLE as error:
        raise MeshError(f"{what} cannot be read as an array: {error}") from error


def _names(what: str, names: Sequence[str] | None) -> list[str] | None:
    if names is None:
        return None
    if isinstance(names, (set, frozenset)):
        raise MeshError(f"{what} is a set, which has no order: give a list of strings, by part")
    found = check_list(what, names, "a sequence of strings", MeshError)
    for i, name in enumerate(found):
        if not isinstance(name, str):
            raise MeshError(f"{what}[{i}] is {shown(name)}: give a string")
    return found
