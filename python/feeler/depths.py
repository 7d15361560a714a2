"""The depth of a tool in the parts of a mock-up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.field_docs import documented
from feeler.rows import Columns
from feeler.words import plural


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Depth:
    """The depth of a tool in one part: a row of `Depths`, metres, world."""

    part: int
    """Index into `mockup.parts`."""
    tool_part: int
    """Index into `tool.parts`."""
    depth: float
    """A lower bound; 0 for contact."""
    error: float
    """How much larger the depth can be; NaN for two open parts."""
    is_estimate: bool
    """Whether one of the two is open."""
    point_on_tool: npt.NDArray[np.float64]
    """`(3,)`: where the depth is measured."""
    point_on_mockup: npt.NDArray[np.float64]
    """`(3,)`: the same on the part."""


@documented
@dataclass(frozen=True, eq=False, repr=False)
class Depths(Columns[Depth]):
    """The depth of a tool at one pose: a row for each part that it collides with, contains or is inside; deepest first.

    `depths[i]` is row `i`, a `Depth`; slices are tables. Metres, world. All arrays are read-only.
    """

    _ROW = Depth

    parts: npt.NDArray[np.uint32]
    """`(k,)`: indices into `mockup.parts`."""
    tool_parts: npt.NDArray[np.uint32]
    """`(k,)`: indices into `tool.parts`: the part of the tool that is deepest there."""
    depths: npt.NDArray[np.float64]
    """`(k,)`: how far the deepest point of one surface lies inside the other part: a lower bound. 0 for contact."""
    errors: npt.NDArray[np.float64]
    """`(k,)`: how much larger the depth can be: at most a thousandth of it, or a nanometre; NaN for two open parts."""
    is_estimate: npt.NDArray[np.bool_]
    """`(k,)`: one of the two is open, so that only points of the open surface inside the closed part count; of two open
    parts the depth is how far their surfaces cross."""
    points_on_tool: npt.NDArray[np.float64]
    """`(k, 3)`: the point of the tool where the depth is measured."""
    points_on_mockup: npt.NDArray[np.float64]
    """`(k, 3)`: the point of the part where the depth is measured."""

    @classmethod
    def _of(
        cls,
        parts: npt.NDArray[np.uint32],
        numbers: npt.NDArray[np.float64],
        is_estimate: npt.NDArray[np.bool_],
    ) -> Depths:
        """From the columns of the core: indices of the mock-up and the tool `(k, 2)`, `numbers` `(k, 8)`."""
        on_tool, on_mockup = numbers[:, 2:5].copy(), numbers[:, 5:8].copy()
        depths, errors = numbers[:, 0].copy(), numbers[:, 1].copy()
        return cls(parts[:, 0].copy(), parts[:, 1].copy(), depths, errors, is_estimate, on_tool, on_mockup)

    def __post_init__(self) -> None:
        for column in vars(self).values():
            column.flags.writeable = False

    def __reduce__(self) -> tuple[type[Depths], tuple[npt.NDArray[Any], ...]]:
        return (type(self), tuple(vars(self).values()))  # through `__post_init__`, so that a copy is read-only, too

    def __repr__(self) -> str:
        deepest = f", the deepest {self.depths[0]:.6g} m" if len(self) else ""
        return f"Depths({plural(len(self), 'part')}{deepest})"


def deepest(scene: _core.Scene, tool: _core.Tool, pose: npt.NDArray[np.float64]) -> dict[int, float]:
    """The depth of a tool in each part that it is in, metres."""
    return deepest_within(scene, tool, pose, math.inf) or {}


def deepest_within(
    scene: _core.Scene, tool: _core.Tool, pose: npt.NDArray[np.float64], seconds: float
) -> dict[int, float] | None:
    """The depth of a tool in each part that it is in, metres; None if measuring them takes longer than `seconds`."""
    columns = scene._depths(tool, pose, seconds)
    if columns is None:
        return None
    found: dict[int, float] = {}
    for part, depth in zip(columns[0][:, 0].tolist(), columns[1][:, 0].tolist(), strict=True):
        found[part] = max(depth, found.get(part, 0.0))
    return found
