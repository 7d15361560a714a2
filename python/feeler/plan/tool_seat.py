"""The tool of `access`, in the frame of its seat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import numpy.typing as npt

from feeler.choices import GRIP_AXES
from feeler.errors import MeshError, OptionError
from feeler.ignored import IgnoredPairs
from feeler.mockup import Mockup, Tool
from feeler.poses import PoseLike, one_pose, placed

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SeatedTool:
    """A tool in the frame of its seat: z out of the joint, the origin on that of the fastener."""

    tool: Tool
    seat_from_tool: Floats
    """(4, 4): from the frame of the tool as it was given."""
    outward: Floats
    """(3,), unit, across z: towards the bulk of the tool, such as its handle."""
    kept: Tool
    """The hand, in the frame of the seat, or what stands for it: it keeps a clearance from parts."""
    is_around: bool = False
    """Whether it encloses the head, or is in its recess, and cannot come off sideways."""
    depth: float = 0.0
    """How far it is then lifted to be off the head, metres; 0: it is not tried."""
    aligned_deg: float | None = None
    """At multiples of this angle it is on the flats; None if that is not known."""
    core: Tool | None = None
    """A body inside of it at any angle about z: where that collides, it does at every angle."""
    plug: Tool | None = None
    """What fills its ring or jaw: a part in there says that it is not off."""


def ignoring(tool: Tool, mockup: Mockup, part: int | None) -> IgnoredPairs | None:
    """Pairs that a tool ignores if the fastener is `part`."""
    if part is None:
        return None
    count = tool.part_count
    return IgnoredPairs(tool, mockup, np.column_stack([np.arange(count), np.full(count, part)]))


def seated_tool(tool: object, hand: object = None, grip: object = None) -> SeatedTool:
    """The tool, with its hand if given, as `access` takes them. Raises `MeshError`, `OptionError`, `PoseError`."""
    if not isinstance(tool, Tool):
        raise MeshError(f"the tool is {type(tool).__name__}: a feeler.Tool is needed (feeler.load_tool reads one)")
    held: dict[str, object] = {}
    if hand is not None:
        if not isinstance(hand[0] if isinstance(hand, tuple) and len(hand) == 2 else hand, Tool):
            raise MeshError("hand is a feeler.Tool in the tool's frame, or (hand, tool_from_hand) with its place")
        held = {"hand": hand}
        tool = Tool.assembly({"tool": tool, **held}, name=tool.name)  # type: ignore[dict-item]
    tool_from_seat = _grip(grip)
    seat_from_tool = np.eye(4)
    seat_from_tool[:3, :3] = tool_from_seat[:3, :3].T
    seat_from_tool[:3, 3] = -tool_from_seat[:3, :3].T @ tool_from_seat[:3, 3]
    if grip is not None:
        tool = _moved(tool, seat_from_tool)
    kept = tool
    if held:
        alone = Tool.assembly(held)  # type: ignore[arg-type]
        kept = _moved(alone, seat_from_tool) if grip is not None else alone
    middle = tool.bounds.mean(axis=0)
    across = float(np.hypot(middle[0], middle[1]))
    reach = float(np.abs(tool.bounds).max())
    outward = np.array([middle[0], middle[1], 0.0]) / across if across > 1e-3 * reach else np.array([1.0, 0.0, 0.0])
    return SeatedTool(tool, seat_from_tool, outward, kept)


def _moved(tool: Tool, pose: Floats) -> Tool:
    corners = placed(tool.vertices, pose, "the grip")
    return Tool(corners, tool.faces, tool.name, tool.part_of_face, tool.part_names, part_paths=tool.part_paths)


def _grip(grip: object) -> Floats:
    """tool_from_seat, (4, 4)."""
    if grip is None:
        return np.eye(4)
    if isinstance(grip, str):
        if grip not in GRIP_AXES:
            raise OptionError(
                f"grip is {grip!r}: name the tool's axis that points out of the joint ({', '.join(GRIP_AXES)}), or "
                "give tool_from_target, (4, 4)"
            )
        i = "xyz".index(grip[-1])
        axes = np.eye(3)
        z, x, y = axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]
        frame = np.eye(4)
        frame[:3, :3] = np.column_stack([y, x, -z] if grip[0] == "-" else [x, y, z])
        return frame
    frame = one_pose(cast("PoseLike", grip), "grip")
    placed(np.zeros((1, 3)), frame, "the grip")
    return frame
