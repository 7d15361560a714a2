"""Robots from URDF: the geometry of their links, placed by the joints."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, TypeAlias
from urllib.parse import unquote

import numpy as np

from feeler.arguments import check_list, check_number, check_path, check_word
from feeler.choices import GEOMETRIES, UnitName
from feeler.choices import Geometry as GeometryKind
from feeler.errors import FeelerError, LoadError, MissingFileError
from feeler.interchange import shapes
from feeler.interchange.assembly import Assembly
from feeler.interchange.kinematics import link_poses
from feeler.interchange.urdf_file import Floats, Geometry, Link, read_urdf
from feeler.io import DEFAULT_CHORD_TOLERANCE, load_mockup
from feeler.io.sniff import identify
from feeler.mockup import Mockup
from feeler.words import counted

PathLike: TypeAlias = str | os.PathLike[str]
PackageDirs: TypeAlias = Iterable[PathLike] | Mapping[str, PathLike]

_WITHOUT_UNIT = ("STL", "OBJ", "PLY", "OFF")
_SCHEMES = ("package://", "model://")


def from_urdf(
    path: PathLike,
    joints: Mapping[str, float] | None = None,
    *,
    geometry: GeometryKind = "collision",
    package_dirs: PackageDirs = (),
    chord_tolerance: float = DEFAULT_CHORD_TOLERANCE,
) -> Mockup:
    """A robot as a mock-up: each geometry of each link is a part, `link/geometry`, placed by the joints, metres.

    path             a URDF file; run xacro files through `xacro` first.
    joints           joint name -> value, radians or metres. Others are at 0, or at the limit nearest to 0; mimicking
                     joints follow; floating and planar ones stay at their origins. A value beyond the limits is used,
                     and noted.
    geometry         "collision" or "visual": which geometry of the links.
    package_dirs     folders for `package://NAME/...`: folders that contain the packages (or are them), or a dict of
                     names and folders. Searched next: beside the file and in the folders above it.
    chord_tolerance  metres: the largest chordal error of cylinders, spheres and capsules.

    The frame is that of the root link. `load_mockup` reads mesh files (in STL, OBJ, PLY and OFF the unit is the metre,
    in others the file's), and their `scale` is applied; triangles are reversed if it mirrors.
    `feeler.Tool(feeler.from_urdf(...))` makes a tool. The report's notes list everything unusual.

    Raises `LoadError` for a file that is not a URDF or has no such geometry; `MissingFileError` if it, or a mesh file,
    does not exist; `OptionError` for the options.
    """
    file = check_path("path", path)
    links, hinges = read_urdf(file)
    poses, notes = link_poses(links, hinges, joints, str(file))
    return placed_robot(file, links, poses, notes, geometry, package_dirs, chord_tolerance).mockup


class PlacedRobot(NamedTuple):
    """A robot as a mock-up. parts: of each link the indices of its parts."""

    mockup: Mockup
    parts: dict[str, list[int]]


def placed_robot(
    file: Path,
    links: Sequence[Link],
    poses: Mapping[str, Floats],
    notes: Sequence[str],
    geometry: GeometryKind,
    package_dirs: PackageDirs,
    chord_tolerance: float,
    bare: Collection[str] = (),
) -> PlacedRobot:
    """The geometry of links at their poses. Links of `bare` that have none get a part without triangles."""
    started = time.perf_counter()
    check_word("geometry", geometry, GEOMETRIES)
    chord_tolerance = check_number("chord_tolerance", chord_tolerance, "metres, more than 0", above=0.0)
    assembly = Assembly("URDF", "m")
    assembly.files.append(str(file))
    assembly.notes += notes
    finder = _Finder(file, package_dirs)
    parts: dict[str, list[int]] = {}
    empty = 0
    for link in links:
        found = link.collision if geometry == "collision" else link.visual
        empty += not found
        first = assembly.part_count
        for each in found:
            placed = poses[link.name] @ each.link_from_geometry
            _add(assembly, link.name, each, placed, finder, chord_tolerance, f"{file}: link {link.name!r}")
        if link.name in bare and assembly.part_count == first:
            assembly.add_bare((link.name,))
        parts[link.name] = list(range(first, assembly.part_count))
    if empty:
        assembly.notes.append(counted(empty, f"links without {geometry} geometry add nothing"))
    if assembly.is_empty:
        other = "visual" if geometry == "collision" else "collision"
        raise LoadError(f"{file}: no link has {geometry} geometry; try geometry={other!r}")
    meshes = assembly.meshes(time.perf_counter() - started)
    source = replace(meshes.source, unit_source="URDF is in metres")
    return PlacedRobot(Mockup(*meshes[:4], part_paths=meshes.part_paths, source=source), parts)


def _add(
    assembly: Assembly, link: str, shape: Geometry, placed: Floats, finder: _Finder, tolerance: float, where: str
) -> None:
    if shape.kind == "mesh":
        _add_mesh(assembly, link, shape, placed, finder, where)
        return
    if shape.kind == "box":
        mesh = shapes.box(shape.sizes)
    else:
        radius = shape.sizes[0]
        mesh = getattr(shapes, shape.kind)(*shape.sizes, tolerance)
        share = 1.0 if shape.kind == "cylinder" else 0.5
        off = radius * (1 - math.cos(math.pi / shapes.segments(radius, share * tolerance))) / share
        if off > tolerance:
            assembly.notes.append(f"link {link!r}: its {shape.kind} is up to {off:.2g} m inside of the round one")
    assembly.add((link, shape.name or shape.kind), *mesh, matrix=placed, unit="m")


def _add_mesh(assembly: Assembly, link: str, shape: Geometry, placed: Floats, finder: _Finder, where: str) -> None:
    file = finder.find(shape.filename, where)
    try:
        unit: UnitName | None = "m" if identify(file)[0] in _WITHOUT_UNIT else None
        loaded = load_mockup(file, unit)
    except FeelerError as error:
        raise type(error)(f"{where}: {error}") from error
    # Usually paths start with the file; here they start with the link and the geometry.
    below = [tuple(path.split("/"))[1:] for path in loaded.part_paths] if loaded.part_count > 1 else [()]
    matrix = placed @ np.diag([*shape.scale, 1.0])
    path = (link, shape.name or file.stem)
    assembly.add_parts(path, loaded.vertices, loaded.faces, loaded.part_of_face, below, matrix=matrix, unit="m")
    if str(file) not in assembly.files:
        assembly.files.append(str(file))
        assembly.notes += [f"{file.name}: {note}" for note in loaded.source.notes]


class _Finder:
    """Finds the mesh files of a URDF."""

    def __init__(self, file: Path, package_dirs: PackageDirs) -> None:
        self._folder = file.parent
        self._above = file.resolve().parent.parents
        self._named: dict[str, Path] = {}
        self._folders: list[Path] = []
        if isinstance(package_dirs, Mapping):
            self._named = {str(name): check_path("package_dirs", folder) for name, folder in package_dirs.items()}
        elif isinstance(package_dirs, (str, os.PathLike)):
            self._folders = [check_path("package_dirs", package_dirs)]
        else:
            folders = check_list("package_dirs", package_dirs, "a list of folders, or a dict of names and folders")
            self._folders = [check_path("package_dirs", folder) for folder in folders]

    def find(self, name: str, where: str) -> Path:
        """The file; raises `MissingFileError` with the places that were searched."""
        places = self._places(name, where)
        for place in places:
            if place.is_file():
                return place
        tried = ", ".join(str(place) for place in places[:4]) + (", ..." if len(places) > 4 else "")
        raise MissingFileError(
            f"{where}: its mesh {name!r} is not there (tried {tried}); name its folder in package_dirs"
        )

    def _places(self, name: str, where: str) -> list[Path]:
        for scheme in _SCHEMES:
            if name.startswith(scheme):
                return self._in_packages(unquote(name[len(scheme) :]))
        if name.startswith("file://"):
            rest = unquote(name[len("file://") :])
            return [Path(rest) if rest.startswith("/") else self._folder / rest]
        if "://" in name:
            raise LoadError(f"{where}: the mesh {name!r} is not on this machine; fetch it, and name the file")
        plain = Path(name.replace("\\", "/"))
        return [self._folder / plain, *(folder / plain for folder in self._folders)]

    def _in_packages(self, name: str) -> list[Path]:
        package, _, rest = name.partition("/")
        if package in self._named:
            return [self._named[package] / rest]
        places = []
        for folder in (*self._folders, self._folder, *self._above):
            places.append(folder / package / rest)
            if folder.resolve().name == package:
                places.append(folder / rest)
        # A package that was flattened, or renamed: its files beside the URDF, or beside the folder it is in.
        return [*places, *(folder / rest for folder in (*self._folders, self._folder, *self._above[:1]))]
