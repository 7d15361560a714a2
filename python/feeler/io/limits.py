"""Refuses meshes that do not fit in memory before allocating them; the error has the size."""

from __future__ import annotations

import contextlib
import os
from functools import cache
from pathlib import Path

from feeler.errors import LimitError

MAX_TRIANGLES = 2**32 - 1
MAX_VERTICES = 2**32 - 2  # 2^32 - 1 is the mark for an index out of range, see raw.OUT_OF_RANGE
MAX_PARTS = 4_000_000  # a part costs about 500 bytes of Python objects: 2 GB of names is more than any assembly has
MAX_DEPTH = 1000  # levels of an assembly; real ones have a dozen
FALLBACK_MEMORY = 16 * 2**30  # if the system does not report it

BYTES_PER_VERTEX = 24  # three float64
BYTES_PER_TRIANGLE = 16  # three uint32 indices, one uint32 part


@cache
def machine_memory() -> int:
    """Return the memory of this machine in bytes, or the container's share of it if that is less."""
    try:
        total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        total = FALLBACK_MEMORY
    with contextlib.suppress(OSError, ValueError):  # no control group, or no limit in it
        total = min(total, int(Path("/sys/fs/cgroup/memory.max").read_text("ascii")))
    return total


def check_memory(needed: int, what: str) -> None:
    """Raise `LimitError` if `needed` bytes are more than the machine has."""
    if needed > machine_memory():
        raise LimitError(
            f"{what} would need {needed / 2**30:,.1f} GiB of memory, and this machine has "
            f"{machine_memory() / 2**30:,.1f} GiB; load fewer files, a coarser mesh, or use a larger machine"
        )


def check_mesh(vertices: int, triangles: int, parts: int, what: str) -> None:
    """Raise `LimitError` if a mesh of that size is beyond the limits of feeler or of this machine."""
    if triangles > MAX_TRIANGLES or vertices > MAX_VERTICES:
        raise LimitError(
            f"{what} has {triangles:,} triangles and {vertices:,} vertices; the most is {MAX_TRIANGLES:,}; split it"
        )
    if parts > MAX_PARTS:
        raise LimitError(f"{what} has {parts:,} part instances; the most is {MAX_PARTS:,}; split it")
    # Twice: the arrays, and the copies made while they are welded and passed on.
    check_memory(2 * (vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE), what)
