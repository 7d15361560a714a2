"""A tool as access uses it: in the frame of what it is put on, with a twin that turns about that frame's z axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.errors import MeshError, OptionError, PoseError
from feeler.ignored import IgnoredPairs
from feeler.mockup import Mockup, Tool
from feeler.poses import placed

Floats = npt.NDArray[np.float64]

AXES = ("x", "y", "z", "-x", "-y", "-z")

PIVOT = "pivot"
"""The part of the twin that is never met: it puts the middle of its box on the axis."""
PIVOT_SIDE = 1e-6
"""Sides of that part's triangles, as a share of the tool's reach: large enough to be triangles at any place."""


@dataclass(frozen=True)
class SeatedTool:
    """A tool in the frame of its seat: z out of the joint, the origin on that of the fastener."""

    tool: Tool
    turning: Tool
    """The same surfaces, about whose box's middle a cast turns: with the middle on z it turns about z exactly."""
    seat_from_tool: Floats
    """(4, 4): from the frame of the tool as it was given."""
    outward: Floats
    """(3,), unit, across z: where the most of the tool is, as its handle."""

    def ignoring(self, mockup: Mockup, part: int | None) -> IgnoredPairs | None:
        """Pairs that `tool` ignores where the fastener is `part`."""
        rows = self._with_fastener(part)
        return IgnoredPairs(self.tool, mockup, rows) if len(rows) else None

    def ignoring_turning(self, mockup: Mockup, part: int | None) -> IgnoredPairs | None:
        """The same of `turning`, whose pivot never meets anything."""
        if self.turning is self.tool:
            return self.ignoring(mockup, part)
        never = np.arange(mockup.part_count)
        pivot = np.column_stack([np.full(len(never), self.tool.part_count), never])
        return IgnoredPairs(self.turning, mockup, np.concatenate([self._with_fastener(part), pivot]))

    def _with_fastener(self, part: int | None) -> npt.NDArray[np.int64]:
        count = self.tool.part_count if part is not None else 0
        return np.column_stack([np.arange(count), np.full(count, part or 0)])


def seated_tool(tool: object, hand: object = None, grip: object = None) -> SeatedTool:
    """The tool, with a hand if there is one, as `access` takes them. Raises `MeshError`, `OptionError`, `PoseError`."""
    if not isinstance(tool, Tool):
        raise MeshError(f"the tool is {type(tool).__name__}: a feeler.Tool is needed (feeler.load_tool reads one)")
    if hand is not None:
        if not isinstance(hand[0] if isinstance(hand, tuple) and len(hand) == 2 else hand, Tool):
            raise MeshError("hand is a feeler.Tool in the tool's frame, or (hand, tool_from_hand) with its place")
        tool = Tool.assembly({"tool": tool, "hand": hand}, name=tool.name)  # type: ignore[dict-item]
    tool_from_seat = _grip(grip)
    seat_from_tool = np.eye(4)
    seat_from_tool[:3, :3] = tool_from_seat[:3, :3].T
    seat_from_tool[:3, 3] = -tool_from_seat[:3, :3].T @ tool_from_seat[:3, 3]
    names = {"part_names": tool.part_names, "part_paths": tool.part_paths}
    if grip is not None:
        corners = placed(tool.vertices, seat_from_tool, "the grip")
        tool = Tool(corners, tool.faces, tool.name, tool.part_of_face, **names)  # type: ignore[arg-type]
    middle = tool.bounds.mean(axis=0)
    across = float(np.hypot(middle[0], middle[1]))
    reach = float(np.abs(tool.bounds).max())
    outward = np.array([middle[0], middle[1], 0.0]) / across if across > 1e-3 * reach else np.array([1.0, 0.0, 0.0])
    return SeatedTool(tool, _turning(tool, middle), seat_from_tool, outward)


def _turning(tool: Tool, middle: Floats) -> Tool:
    """The tool with two more triangles, at opposite corners of a box about z that holds it."""
    if middle[0] == 0.0 and middle[1] == 0.0:
        return tool
    side = PIVOT_SIDE * float(np.abs(tool.bounds).max())
    x, y = (max(float(np.abs(tool.bounds[:, axis]).max()), side) for axis in (0, 1))
    z = float(middle[2])
    corner = np.array([[x, y, z], [x - side, y, z], [x, y, z + side]])
    count = len(tool.vertices)
    parts = np.concatenate([tool.part_of_face, np.full(2, tool.part_count)])
    return Tool(
        np.concatenate([tool.vertices, corner, corner * [-1.0, -1.0, 1.0]]),
        np.concatenate([tool.faces, count + np.arange(6).reshape(2, 3)]),
        tool.name,
        parts,
        [*tool.part_names, PIVOT],
        part_paths=[*tool.part_paths, PIVOT],
    )


def _grip(grip: object) -> Floats:
    """tool_from_seat, (4, 4)."""
    if grip is None:
        return np.eye(4)
    if isinstance(grip, str):
        if grip not in AXES:
            raise OptionError(
                f"grip is {grip!r}: name the tool's axis that points out of the joint ({', '.join(AXES)}), or give "
                "tool_from_target, (4, 4)"
            )
        i = "xyz".index(grip[-1])
        axes = np.eye(3)
        z, x, y = axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]
        frame = np.eye(4)
        frame[:3, :3] = np.column_stack([y, x, -z] if grip[0] == "-" else [x, y, z])
        return frame
    try:
        frame = np.asarray(grip, dtype=np.float64)
        placed(np.zeros((1, 3)), frame, "the grip")
    except (TypeError, ValueError) as error:
        if isinstance(error, PoseError):
            raise
        raise PoseError(f"grip cannot be read as a matrix: {error}; give tool_from_target, (4, 4)") from None
    return frame
