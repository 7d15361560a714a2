"""The shared volume of closed parts, computed by manifold3d. Needs the extra `feeler[volume]`."""

from __future__ import annotations

import importlib
import math
from collections import OrderedDict
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.clashes.solids import shared_volume, solid_of
from feeler.errors import OptionError
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes
from feeler.progress import Progress

_KEPT_TRIANGLES = 5_000_000
"""Most triangles of cached solids, about 2 GB in manifold3d."""


def solids_library() -> Any:
    """The module manifold3d. Raises `OptionError` if it is not installed."""
    try:
        return importlib.import_module("manifold3d")
    except ImportError:
        raise OptionError('volumes need manifold3d: pip install "feeler[volume]", or leave volume out') from None


def shared_volumes(
    mockup: Mockup,
    a: npt.NDArray[np.uint32],
    b: npt.NDArray[np.uint32],
    does_share: npt.NDArray[np.bool_],
    is_open: npt.NDArray[np.bool_],
    progress: Progress | None = None,
) -> tuple[npt.NDArray[np.float64], list[int]]:
    """The shared volume of each pair, `(n,)`, cubic metres; and the closed parts that have none.

    does_share: `(n,)`: which pairs to measure; others have 0. NaN if a part is open, or if manifold3d rejects it: its
    surface intersects itself, or an edge has more than two triangles. Never negative, and never more than the smaller
    part.
    """
    solids = _Solids(mockup, solids_library())
    are_closed = ~is_open.any(axis=1)
    found = np.where(are_closed, 0.0, math.nan)
    without: set[int] = set()
    wanted = np.flatnonzero(does_share & are_closed)
    # Sorted by part, so that a solid is built once for all its pairs.
    for number, row in enumerate(wanted[np.lexsort((b[wanted], a[wanted]))]):
        pair = int(a[row]), int(b[row])
        one, other = (solids.of(part) for part in pair)
        without.update(part for part, solid in zip(pair, (one, other), strict=True) if solid is None)
        found[row] = math.nan if one is None or other is None else shared_volume(one, other)
        if progress is not None and number % 64 == 0:
            progress(number / len(wanted), f"volume {number:,} of {len(wanted):,}")
    return found, sorted(without)


class _Solids:
    """A cache of solids. They are centred on the mock-up, to keep precision far from the origin."""

    def __init__(self, mockup: Mockup, library: Any) -> None:
        self._meshes, self._library = PartMeshes(mockup), library
        self._middle = mockup.bounds.mean(axis=0)
        self._kept: OrderedDict[int, tuple[Any, int]] = OrderedDict()
        self._held = 0

    def of(self, part: int) -> Any:
        """The solid of a part, or None if manifold3d rejects it."""
        if part in self._kept:
            self._kept.move_to_end(part)
            return self._kept[part][0]
        corners = self._meshes.corners(part)
        solid = solid_of(self._library, corners, self._middle)
        self._kept[part] = (solid, len(corners))
        self._held += len(corners)
        while self._held > _KEPT_TRIANGLES and len(self._kept) > 2:
            _, (_, size) = self._kept.popitem(last=False)
            self._held -= size
        return solid
