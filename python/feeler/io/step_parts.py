"""Parts of a STEP assembly in other files: reads them and places them in the assembly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from feeler.errors import LimitError, LoadError
from feeler.io.limits import check_mesh
from feeler.io.placing import Matrix, facing, shift_indices, transform
from feeler.io.raw import PathBook, RawMesh, joined_attributes
from feeler.io.step_external import Named, find
from feeler.io.tally import Tally

_MAX_FILES_DEEP = 32  # nested files; each is read within the previous one

ReadFile = Callable[[Path, tuple[Path, ...]], RawMesh]
"""Reads a STEP file in metres; the second argument lists the files being read, the outermost first."""


class Slot(NamedTuple):
    """A part without a surface in the converted file: the place of a part of another file."""

    name: str
    path: str
    world: Matrix
    definition: int  # the entity PRODUCT_DEFINITION, 0 if not known


@dataclass
class Library:
    """The files of one assembly: each is read once, however often it is placed."""

    within: Path  # no file outside of this folder is read
    known: dict[Path, RawMesh | str] = field(default_factory=dict)

    def take(self, path: Path, chain: tuple[Path, ...], read: ReadFile) -> RawMesh | str:
        """Return the mesh of a file, or the reason why there is none."""
        if path in chain:
            around = " > ".join(p.name for p in (*chain[chain.index(path) :], path))
            return f"which holds itself ({around}) and so was not read again"
        if len(chain) > _MAX_FILES_DEEP:
            return f"which is more than {_MAX_FILES_DEEP} files deep and so was not read"
        if path not in self.known:
            try:
                self.known[path] = read(path, chain)
            except (LoadError, LimitError) as error:
                self.known[path] = f"which cannot be read: {error}"
            except OSError as error:
                self.known[path] = f"which cannot be read: {error.strerror or error}"
        return self.known[path]


class Filled(NamedTuple):
    """A mesh with the parts of other files."""

    raw: RawMesh
    missing: list[str]  # a note for each part in another file that was not read
    empty: list[str]  # notes on the parts without a surface in any file


def fill(
    raw: RawMesh,
    slots: list[Slot],
    files: dict[int, list[Named]],
    path: Path,
    chain: tuple[Path, ...],
    library: Library,
    read: ReadFile,
) -> Filled:
    """Add the parts in other files to `raw`, which was read from `path` and is in metres.

    `files` has the files of each definition.
    """
    missing: dict[str, None] = {}
    came: dict[Path, RawMesh] = {}
    placed: list[tuple[Slot, RawMesh]] = []
    empty = Tally()
    for slot in slots:
        if slot.definition not in files:
            empty.add("parts have no surface in the file", slot.name)
            continue
        whys = []
        for named in files[slot.definition]:
            place = find(named, path.parent, library.within)
            found = place.why_not if place.path is None else library.take(place.path, chain, read)
            if isinstance(found, RawMesh):
                assert place.path is not None
                came[place.path] = found
                placed.append((slot, found))
                break
            whys.append(f'part "{slot.name}" is in the file {named.shown}, {found}')
        else:
            missing.update(dict.fromkeys(whys))
    joined = _joined(raw, placed, path)
    if came:
        shown = ", ".join(p.name for p in came)
        joined.notes.append(
            f"parts were read from other files, as the assembly says: {shown} (where these are loaded with it, as in a "
            "folder, they are there twice)"
        )
        joined.notes += [f"{p.name}: {note}" for p, part in came.items() for note in part.notes]
    return Filled(joined, list(missing), empty.notes())


def _joined(raw: RawMesh, placed: list[tuple[Slot, RawMesh]], path: Path) -> RawMesh:
    """Return the mesh with the others appended, each moved into its slot, their parts below the slot's path."""
    if not placed:
        return raw
    meshes = [raw, *(part for _, part in placed)]
    check_mesh(
        sum(len(m.vertices) for m in meshes),
        sum(len(m.faces) for m in meshes),
        sum(len(m.part_names) for m in meshes),
        f"{path} with the files of its parts",
    )
    vertices, faces, parts = [raw.vertices], [raw.faces], [raw.part_of_face]
    names, paths = list(raw.part_names), list(raw.part_paths)
    book = PathBook()
    for taken in paths:
        book.claim_path(taken)
    base = len(raw.vertices)
    for slot, mesh in placed:
        vertices.append(transform(mesh.vertices, slot.world))
        faces.append(shift_indices(facing(mesh.faces, slot.world), base, len(mesh.vertices)))
        parts.append(mesh.part_of_face + np.uint32(len(names)))
        base += len(mesh.vertices)
        names += mesh.part_names
        paths += [book.claim_path(f"{slot.path}/{below}" if below else slot.path) for below in mesh.part_paths]
    return RawMesh(
        np.concatenate(vertices),
        np.concatenate(faces),
        np.concatenate(parts),
        names,
        paths,
        unit=raw.unit,
        in_metres=raw.in_metres,
        notes=raw.notes,
        up=raw.up,
        doubts=raw.doubts,
        rounding=max(mesh.rounding or 0.0 for mesh in meshes),
        attributes=joined_attributes(meshes),
    )
