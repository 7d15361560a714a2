"""Saved scenes: what their files keep beside the arrays of the core, names, origin, colours and attributes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from feeler import _core, attributes
from feeler.arguments import check_path
from feeler.attributes import Attributes
from feeler.errors import FeelerError, LoadError, MissingFileError
from feeler.memory import free_memory
from feeler.source import Source

SUFFIX = ".feeler"
"""The extension of saved scenes."""

MAGIC = b"FEELSCN\n"
"""The first bytes of their files."""

_DOCUMENT = "document"
_COLOURS = "parts.colours"
_ATTRIBUTES = "parts.attributes"  # absent from files of older versions, and of parts without any


@dataclass(frozen=True, eq=False)
class SavedFile:
    """The file that a mock-up is in."""

    path: str  # absolute
    core: _core.SavedScene
    state: tuple[int, ...] = ()
    """What the file system said of it when it was opened."""

    @property
    def is_there(self) -> bool:
        """Whether the path still leads to a file with this mock-up: it may have been saved anew since."""
        state = _state(self.path)
        if state and state == self.state:
            return True
        try:
            there = _core.SavedScene(self.path, False, free_memory() * 4 // 5, None)
        except FeelerError:
            return False
        return there.content_hash == self.core.content_hash

    @cached_property
    def attributes(self) -> Attributes | None:
        """The attributes of its parts, read when they are first asked for: they may be larger than all else that is
        read. Raises `LoadError` if they cannot be right."""
        stated = self.core.extra(_ATTRIBUTES)
        try:
            return None if stated is None else attributes.from_bytes(stated, self.core.part_count)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise LoadError(f"{self.path}: the attributes of its parts are damaged ({error}); save it again") from None

    @cached_property
    def facts(self) -> Facts:
        """What it says of the mock-up. Raises `LoadError` if that cannot be right."""
        return _facts(self)


def path_of(path: object, error: type[FeelerError]) -> str:
    """The path as text. Raises `error` for anything else."""
    if isinstance(path, str) and not path:
        raise error("path is empty: give the path of a file")
    return str(check_path("path", path, error))


_known: WeakValueDictionary[tuple[str, str], SavedFile] = WeakValueDictionary()


def opened(path: str, verify: bool, memory_limit: int, progress: Callable[[float, str], object] | None) -> SavedFile:
    """Opens a file. Raises `MissingFileError` and `LoadError`."""
    try:
        path = os.path.abspath(path)
    except FileNotFoundError:
        raise MissingFileError(f"{path}: the current folder is gone; give a path that starts with /") from None
    if not os.path.lexists(path):
        raise MissingFileError(f"{path}: there is no such file; check the path")
    state = _state(path)
    core = _core.SavedScene(path, verify, memory_limit, progress)
    if any(part >= core.part_count for part in core.absent_parts):
        raise LoadError(f"{path}: the file is damaged: a part that is out of the scene is not in it; save it again")
    file = SavedFile(path, core, state if state == _state(path) else ())
    _known[path, file.core.content_hash] = file
    return file


def _state(path: str) -> tuple[int, ...]:
    try:
        found = os.stat(path)
    except OSError:
        return ()
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def opened_again(path: str, content_hash: str) -> SavedFile:
    """The file of a pickled mock-up, opened once in a process. Raises `LoadError` where it holds another one by now."""
    known = _known.get((path, content_hash))
    if known is not None:
        return known
    try:
        file = opened(path, True, free_memory() * 4 // 5, None)
    except LoadError as error:
        raise LoadError(f"the pickle names a saved scene by its path: {error}") from None
    if file.core.content_hash != content_hash:
        raise LoadError(f"{path}: the file holds another mock-up than when the pickle was made; save it elsewhere")
    return file


class Facts(NamedTuple):
    """What a file says of its mock-up."""

    part_names: tuple[str, ...]
    part_paths: tuple[str, ...]
    source: Source
    colours: npt.NDArray[np.float64] | None


def extras(facts: Facts, stated: Attributes | None) -> list[tuple[str, bytes]]:
    """The sections of the file that keep these facts, and the attributes of its parts."""
    paths = None if facts.part_paths == facts.part_names else facts.part_paths
    document = {"part_names": facts.part_names, "part_paths": paths, "source": asdict(facts.source)}
    sections = [(_DOCUMENT, json.dumps(document).encode("ascii"))]
    if facts.colours is not None:
        sections.append((_COLOURS, np.ascontiguousarray(facts.colours, dtype="<f8").tobytes()))
    if stated is not None:
        sections.append((_ATTRIBUTES, attributes.to_bytes(stated)))
    return sections


def _facts(file: SavedFile) -> Facts:
    try:
        document = json.loads(file.core.extra(_DOCUMENT) or b"")
        names, paths, source = document["part_names"], document["part_paths"], document["source"]
        for listed in (names, paths):
            if listed is not None and not all(isinstance(each, str) for each in listed):
                raise ValueError("names of parts")
        paths = names if paths is None else paths
        if not len(names) == len(paths) == file.core.part_count:
            raise ValueError("number of parts")
        fields: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in source.items()
        }
        colours = file.core.extra(_COLOURS)
        rows = None if colours is None else np.frombuffer(colours, dtype="<f8").reshape(-1, 3).astype(np.float64)
        if rows is not None and len(rows) != len(names):
            raise ValueError("colours of parts")
        if rows is not None:  # earlier versions kept any numbers
            rows[~np.isfinite(rows).all(axis=1)] = np.nan
            rows = np.clip(rows, 0.0, 1.0)
        return Facts(tuple(names), tuple(paths), Source(**fields), rows)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise LoadError(f"{file.path}: the scene cannot be opened: its {_DOCUMENT} is damaged ({error})") from None
