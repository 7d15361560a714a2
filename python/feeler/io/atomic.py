"""Writes a file completely or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from feeler.arguments import check_path
from feeler.errors import FeelerError, WriteError


def check_target(path: str | os.PathLike[str]) -> Path:
    """`path`, after checking that a file can be put there; raises `WriteError`. Call it before long work."""
    target = check_path("path", path, WriteError)
    folder = target.parent
    if not folder.is_dir():
        what = "is not a folder" if folder.exists() else "does not exist"
        raise WriteError(f"cannot write {target}: {folder} {what}; make it first, or choose another place")
    if target.is_dir():
        raise WriteError(f"cannot write {target}: it is a folder; give a file name")
    if not os.access(folder, os.W_OK):
        raise WriteError(f"cannot write {target}: no permission to write in {folder}; choose another place")
    return target


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary file that takes its name only when the block ends without an error.

    Readers see the old file or the new one, never half of one. Raises `WriteError`.
    """
    target = check_target(path)
    # In the same folder, because a rename across disks is not atomic.
    temporary = target.with_name(f".{target.name[:64]}.{secrets.token_hex(6)}.part")
    try:
        with open(temporary, "xb") as file:
            yield file
        os.replace(temporary, target)
    except OSError as error:
        if isinstance(error, FeelerError):
            raise
        raise WriteError(
            f"cannot write {target}: {error.strerror or error}; free some space or choose another place"
        ) from error
    finally:
        with contextlib.suppress(OSError):  # after the rename there is none
            os.unlink(temporary)
