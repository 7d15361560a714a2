"""Writes a file completely or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from feeler.arguments import check_path, check_text
from feeler.errors import FeelerError, WriteError

_ENDINGS = frozenset(
    (
        *(
            ".3mf",
            ".bcf",
            ".bcfzip",
            ".bmp",
            ".csv",
            ".dae",
            ".feeler",
            ".feelproj",
            ".gif",
            ".glb",
            ".gltf",
            ".gz",
            ".html",
            ".jpeg",
        ),
        *(".jpg", ".json", ".npy", ".npz", ".obj", ".off", ".p21", ".pdf", ".ply", ".png", ".step", ".stl", ".stp"),
        *(".svg", ".tif", ".tiff", ".toml", ".webp", ".xlsx", ".xml", ".zae", ".zip"),
    )
)
"""The ends of names that say what is in a file, to people and to programs."""

_SHOWN = 200  # characters of a path in an error


def check_target(path: str | os.PathLike[str], *endings: str) -> Path:
    """`path`, after checking that a file can be put there; raises `WriteError`. Call it before long work.

    endings: of the names of such files, in small letters (".glb"). A name that ends in that of another format is
    refused: it would say what is not in the file. One without an ending, or with one that nobody knows, is not.
    """
    target = check_path("path", path, WriteError)
    for each in endings:
        check_text("endings", each, 'endings of names, such as ".glb"')
    named = _shown(target)
    if os.fspath(path).endswith(("/", os.sep)):
        raise WriteError(f"cannot write {named}{os.sep}: that is a folder; give a file name")
    ending = target.suffix.lower()
    if endings and ending in _ENDINGS and ending not in endings:
        give = f"give one that ends in {' or '.join(endings)}"
        raise WriteError(f"cannot write {named}: a name in {ending} is of another format; {give}")
    folder = target.parent
    above = _mode(folder, named)
    if not stat.S_ISDIR(above):
        what = "is not a folder" if above else "does not exist"
        raise WriteError(f"cannot write {named}: {_shown(folder)} {what}; make it first, or choose another place")
    there = _mode(target, named)
    if stat.S_ISDIR(there):
        raise WriteError(f"cannot write {named}: it is a folder; give a file name")
    if there and not stat.S_ISREG(there):
        # The file that is renamed to it would take its place, for all programs.
        raise WriteError(f"cannot write {named}: it is a device or a pipe; give a file name")
    if not os.access(folder, os.W_OK):
        raise WriteError(f"cannot write {named}: no permission to write in {_shown(folder)}; choose another place")
    return target


def _mode(path: Path, named: str) -> int:
    """The mode of what is at a path, 0 where nothing is. Raises `WriteError` where nothing can be: of a name that is
    too long, for one."""
    try:
        return os.stat(path).st_mode
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return 0
    except OSError as error:
        raise WriteError(f"cannot write {named}: {error.strerror or error}; choose another name or place") from None


def _shown(path: Path) -> str:
    text = str(path)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN // 2]}...{text[-_SHOWN // 2 :]}"


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike[str], *endings: str) -> Iterator[BinaryIO]:
    """A binary file that takes its name only when the block ends without an error. endings: as for `check_target`.

    Readers see the old file or the new one, never half of one. Raises `WriteError`.
    """
    target = check_target(path, *endings)
    if target.is_symlink():  # the file that it names is written, and the link stays
        target = check_target(os.path.realpath(target))
    # In the same folder, because a rename across disks is not atomic. Most systems end names at 255 bytes, and a
    # character has up to four.
    temporary = target.with_name(f".{target.name[:32]}.{secrets.token_hex(6)}.part")
    try:
        with open(temporary, "xb") as file:
            with contextlib.suppress(OSError):  # the file that is replaced may be for few to read
                os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
            yield file
        os.replace(temporary, target)
    except OSError as error:
        if isinstance(error, FeelerError):
            raise
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        what = "free some space or choose another place" if is_full else "choose another place"
        raise WriteError(f"cannot write {_shown(target)}: {error.strerror or error}; {what}") from error
    finally:
        with contextlib.suppress(OSError):  # after the rename there is none
            os.unlink(temporary)
