"""Finds the files to load: one file, several, or folders."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, TypeAlias

from feeler.arguments import check_path
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io.sniff import COMPANIONS, EXTENSIONS, known_formats
from feeler.words import counted

PathLike: TypeAlias = str | os.PathLike[str]

_NAMES_SHOWN = 5
_ADDRESS = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]+://")


class Found(NamedTuple):
    """A file to read."""

    path: Path
    label: str  # first step of the paths of its parts
    shown: str  # its name in notes
    is_named: bool  # given by the caller, not found in a folder


@dataclass
class FileList:
    """The files of one load."""

    files: list[Found] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def collect(paths: PathLike | Iterable[PathLike]) -> FileList:
    """Return the named files, in the given order; those of a folder sorted by path, with subfolders.

    In a folder, hidden files and links to folders are skipped, and files of other kinds are listed in a note.
    """
    if isinstance(paths, (str, bytes, os.PathLike)):
        given = [_path(paths)]
    else:
        try:
            given = [_path(path) for path in paths]
        except TypeError:
            raise OptionError(f"a path, or several, are needed, and not {type(paths).__name__}") from None
    if not given:
        raise MissingFileError("no file was given; name at least one file or folder")
    found = FileList()
    for path in given:
        try:
            is_folder = path.is_dir()
        except (OSError, ValueError) as error:
            raise LoadError(f"{str(path)!r}: cannot be opened ({error})") from error
        if is_folder:
            _add_folder(path, found)
        else:
            found.files.append(Found(path, path.stem or path.name, path.name, True))
    return found


def _path(path: object) -> Path:
    if isinstance(path, str) and not path:
        raise OptionError("path is empty: give the path of a file")
    checked = check_path("path", path)
    if isinstance(path, str) and _ADDRESS.match(path) and not checked.exists():
        raise MissingFileError(f"{path}: feeler loads nothing from a network; save the file and give its path")
    return checked


def _add_folder(folder: Path, found: FileList) -> None:
    meshes: list[Path] = []
    others: Counter[str] = Counter()
    for at, subfolders, names in os.walk(folder, onerror=_raise):
        subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))
        for name in names:
            path = Path(at, name)
            if name.startswith("."):
                continue
            if path.suffix.lower() in EXTENSIONS:
                meshes.append(path)
            elif path.suffix.lower() not in COMPANIONS:
                others[path.relative_to(folder).as_posix()] += 1
    if others:
        shown = ", ".join(sorted(others)[:_NAMES_SHOWN]) + (", ..." if len(others) > _NAMES_SHOWN else "")
        found.notes.append(counted(len(others), f"files of other kinds in {folder} were skipped: {shown}"))
    if not meshes:
        raise MissingFileError(f"{folder}: the folder holds no mesh file ({known_formats()})")
    for path in sorted(meshes):
        below = path.relative_to(folder)
        found.files.append(Found(path, below.with_suffix("").as_posix(), below.as_posix(), False))


def _raise(error: OSError) -> None:
    raise LoadError(f"{error.filename}: cannot be listed ({error.strerror}); check its permissions") from error
