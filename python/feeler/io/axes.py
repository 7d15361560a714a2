"""The up axis: turns meshes to a common one, and reports inconsistent axes."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from feeler.arguments import shown
from feeler.errors import OptionError
from feeler.io.raw import Axis, RawMesh

# Where right, up and towards the viewer are, as (axis, sign), after COLLADA's definition of X_UP, Y_UP and Z_UP.
_FRAMES: dict[Axis, tuple[tuple[int, int], ...]] = {
    "x": ((1, -1), (0, 1), (2, 1)),
    "y": ((0, 1), (1, 1), (2, 1)),
    "z": ((0, 1), (2, 1), (1, -1)),
}
_NAMES_SHOWN = 3


def parse_axis(up: object) -> Axis | None:
    """Return the axis that `up=` names, None for None; raise `OptionError` for anything else."""
    if up is None:
        return None
    if isinstance(up, str) and up.strip().lower() in _FRAMES:
        return cast(Axis, up.strip().lower())
    raise OptionError(f"up is {shown(up)}: choose x, y or z, or leave it out")


def turn(vertices: NDArray[np.float64], axis: Axis, wanted: Axis) -> NDArray[np.float64]:
    """Return vertices (n, 3) turned so that the direction up along `axis` becomes `wanted`.

    Exact: coordinates change places and signs. From "y" to "z": `(x, y, z)` becomes `(x, -z, y)`.
    """
    turned = np.empty_like(vertices)
    for (source, sign), (target, wanted_sign) in zip(_FRAMES[axis], _FRAMES[wanted], strict=True):
        turned[:, target] = vertices[:, source] if sign == wanted_sign else 0.0 - vertices[:, source]
    return turned


def align(raw: RawMesh, wanted: Axis | None) -> None:
    """Turn a mesh in place if its up axis is known and not the wanted one. `raw.up` keeps the file's axis."""
    if wanted is not None and raw.up is not None and raw.up != wanted:
        raw.vertices = turn(raw.vertices, raw.up, wanted)


def common_axis(found: list[tuple[str, Axis | None]], wanted: Axis | None) -> Axis | None:
    """Return the common up axis of files, given as (name, own axis): None if it is unknown or differs."""
    known = {axis for _, axis in found if axis is not None}
    if wanted is not None:
        return wanted if known else None
    return known.pop() if len(known) == 1 else None


def describe(found: list[tuple[str, Axis | None]], wanted: Axis | None) -> tuple[list[str], list[str]]:
    """Return notes on the up axes of files, given as (name, own axis): (doubts, turns made)."""
    by_axis: dict[Axis | None, list[str]] = {}
    for name, axis in found:
        by_axis.setdefault(axis, []).append(name)
    unknown = by_axis.pop(None, [])
    if wanted is None:
        if len(by_axis) < 2:
            return [], []
        which = "; ".join(f"{axis} up: {listed(names)}" for axis, names in sorted(by_axis.items(), key=str))
        clash = f"the files have different up axes and lie across each other ({which}); pass up='z' to turn them alike"
        return [clash], []
    notes = [
        f"turned from {axis} up to {wanted} up: {listed(names)}" for axis, names in by_axis.items() if axis != wanted
    ]
    if unknown:
        notes.append(f"not turned to {wanted} up, as nothing says which axis is up there: {listed(unknown)}")
    return [], notes


def listed(names: list[str]) -> str:
    """Return the first names, and the number of others."""
    more = len(names) - _NAMES_SHOWN
    return ", ".join(names[:_NAMES_SHOWN]) + (f" and {more:,} more" if more > 0 else "")
