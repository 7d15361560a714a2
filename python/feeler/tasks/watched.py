"""A scene that notes where questions look."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.parts import PartsLike
from feeler.plan.blocking import room_of
from feeler.plan.removal import Removal
from feeler.poses import one_pose
from feeler.scene import CAST_TOLERANCE, Scene
from feeler.tasks.memory import Answer, Memory
from feeler.tasks.regions import Noted, NotedParts, Regions, box_of

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

TOUCH_M = 1e-4
NEAR_SHARE = 0.03
"""A removal looks at what is this near to the moving parts: metres, and a share of their size. It is more than it casts
around fits and than it ignores as touching."""
FEW_PARTS, FEW_SHARE = 8, 4
"""Scenes with no more parts, and no more than one of so many of those that they are made of, look at these."""
STRAIGHT = 1.0 - 1e-9
_QUIET = "looking at what leaves together"
"""While `task` is at this stage it asks of all fasteners; `maintain` compares these answers by themselves."""


class Recall:
    """What one row takes from a memory, and adds to it."""

    def __init__(self, memory: Memory, goes_on: Callable[[], bool]) -> None:
        """goes_on: whether there is time left: answers that time ended are not kept."""
        self.memory, self._goes_on = memory, goes_on
        self.used: dict[str, None] = {}
        """The names of the answers that it asked for, in their order."""
        self.new: list[Answer] = []
        """Those that were computed."""

    def known(self, answer: Answer) -> None:
        """An answer was taken."""
        self.used[answer.name] = None

    def found(self, key: str, told: Any, regions: Regions, present: Bools) -> None:
        """An answer was computed in a scene with these parts."""
        if self._goes_on():
            answer = self.memory.note(key, told, regions, present)
            self.used[answer.name] = None
            self.new.append(answer)


class WatchedScene(Scene):
    """A scene whose queries note where they look. Queries that it does not know note the whole mock-up."""

    _noted: Noted
    _recall: Recall | None

    @classmethod
    def of(cls, scene: Scene, recall: Recall | None = None) -> WatchedScene:
        """The same scene, watched. `noted` has what its queries look at, and those of all scenes made of it. recall:
        where answers are remembered."""
        selected = _core.Scene._selected_without(scene, [])
        made = _core.Scene.__new__(cls, selected)
        made.build_seconds, made._given = 0.0, scene._given
        made._noted = Noted(*room_of(*box_of(scene.mockup.part_bounds.reshape(-1, 2, 3)[scene.part_mask])))
        made._recall = recall
        return made

    @property
    def noted(self) -> Noted:
        """Where queries looked."""
        return self._noted

    def heard(self, _share: float, stage: str) -> None:
        """The progress of `task`: notes nothing while it looks at all fasteners."""
        self._noted.is_on = stage != _QUIET

    def _made_of(self, selected: _core.Selected) -> Scene:
        made = super()._made_of(selected)
        assert isinstance(made, WatchedScene)
        made._noted, made._recall = self._noted, self._recall
        return made

    def only(self, parts: PartsLike) -> Scene:
        """As `Scene`."""
        made = super().only(parts)
        assert isinstance(made, WatchedScene)
        there = np.flatnonzero(made.part_mask)
        is_few = len(there) <= FEW_PARTS and FEW_SHARE * len(there) <= np.count_nonzero(self.part_mask)
        if self._recall is not None and is_few:
            made._noted = NotedParts(self._noted, self._recall.memory.paths_of(there.tolist()))
        return made

    def _recalled(
        self,
        kind: str,
        own: Sequence[int],
        facts: Any,
        ask: Callable[[], Any],
        is_enough: Callable[[Any], bool] = lambda _: True,
    ) -> Any:
        """See `Scene._recalled`."""
        recall = self._recall
        if recall is None:
            return ask()
        present = self.part_mask
        key = recall.memory.key(kind, own, facts)
        for answer in recall.memory.find(key, present):
            try:
                told = recall.memory.told(answer.data)
            except (KeyError, TypeError):
                continue
            if is_enough(told):
                recall.known(answer)
                self._noted.add(answer.regions)
                return told
        with self._noted.apart() as looked:
            told = ask()
            recall.found(key, told, looked(), present)
        return told

    def _note(self, tool: _core.Tool, pose: Any, grown: float = 0.0, is_solid: bool = False) -> None:
        if math.isfinite(grown):
            lower, upper = _placed(tool, one_pose(pose))
            self._noted.box(lower - grown, upper + grown, is_solid)
        else:
            self._noted.all()

    def _note_way(self, tool: _core.Tool, start: Floats, end: Floats, grown: float = 0.0) -> None:
        """The motion between two poses, as `cast` defines it."""
        lower, upper = _placed(tool, start)
        if np.array_equal(start[:3, :3], end[:3, :3]):
            boxes = self._noted.boxes_of(tool)
            if np.array_equal(start[:3, :3], np.eye(3)):
                boxes = boxes + start[:3, 3]
            else:
                corners = _corners_of(boxes) @ start[:3, :3].T + start[:3, 3]
                boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
            self._noted.sweep(boxes + grown * np.array([[-1.0], [1.0]]), end[:3, 3] - start[:3, 3])
            return
        other = _placed(tool, end)
        # Its middle goes straight, and corners turn about it: by half an angle they are farthest from both boxes.
        turn = math.acos(min(1.0, max(-1.0, 0.5 * (float(np.trace(start[:3, :3].T @ end[:3, :3])) - 1.0))))
        grown += 0.5 * float(np.linalg.norm(tool.bounds[1] - tool.bounds[0])) * (1.0 - math.cos(0.5 * turn))
        self._noted.box(np.minimum(lower, other[0]) - grown, np.maximum(upper, other[1]) + grown)

    def _note_screw(self, tool: _core.Tool, start: Floats, screw: _core.Screw) -> None:
        """All turns about the axis."""
        axis, point = np.array(screw.axis), np.array(screw.point)
        # What is near to the axis, such as a socket, sweeps little; what is far, such as a handle, at its height alone.
        for corners in _corners_of(self._noted.boxes_of(tool, 4)) @ start[:3, :3].T + start[:3, 3] - point:
            heights = corners @ axis
            radius = float(np.linalg.norm(corners - heights[:, None] * axis, axis=1).max(initial=0.0))
            ends = np.array([heights.min(), heights.max(), *(heights + screw.advance)])
            middle = point + 0.5 * (ends.min() + ends.max()) * axis
            half = 0.5 * (ends.max() - ends.min()) * np.abs(axis) + radius * np.sqrt(np.maximum(0.0, 1.0 - axis * axis))
            self._noted.box(middle - half, middle + half)

    def _depends_on(self, parts: Sequence[int]) -> None:
        """See `Scene._depends_on`."""
        if self._recall is not None:
            self._noted.ask(self._recall.memory.paths_of(parts))
        else:
            self._noted.all()

    def _saw_removal(self, tool: _core.Tool, directions: Floats, found: Removal) -> None:
        """See `Scene._saw_removal`: a straight way along a given direction looked at its sweep alone; other answers, at
        the whole mock-up."""
        if found.certificate.method == "out":
            self._noted.all()
            return
        step = found.poses[-1][:3, 3]
        length = float(np.linalg.norm(step))
        is_straight = len(found.poses) == 2 and np.array_equal(found.poses[-1][:3, :3], np.eye(3)) and len(directions)
        if not (found.is_found and is_straight and length > 0.0):
            self._noted.all()
            return
        if float(step @ directions[0]) < STRAIGHT * length * float(np.linalg.norm(directions[0])):
            self._noted.all()
            return
        size = float(np.linalg.norm(tool.bounds[1] - tool.bounds[0]))
        self._note(tool, found.poses[0], TOUCH_M + NEAR_SHARE * size, is_solid=True)
        self._note_way(tool, found.poses[0], found.poses[1], TOUCH_M + NEAR_SHARE * size)

    def collide(self, tool: Any, world_from_tool: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool)
        return super().collide(tool, world_from_tool, *args, **options)

    def is_colliding(self, tool: Any, world_from_tool: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool)
        return super().is_colliding(tool, world_from_tool, *args, **options)

    def is_free(self, tool: Any, world_from_tool: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool, is_solid=True)
        return super().is_free(tool, world_from_tool, *args, **options)

    def containment(self, tool: Any, world_from_tool: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool, is_solid=True)
        return super().containment(tool, world_from_tool, *args, **options)

    def _depths(self, tool: Any, world_from_tool: Any, *args: Any, **options: Any) -> Any:
        self._note(tool, world_from_tool, is_solid=True)
        return super()._depths(tool, world_from_tool, *args, **options)

    def contacts(self, tool: Any, world_from_tool: Any, within: float = 0.002, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool, float(within), is_solid=True)
        return super().contacts(tool, world_from_tool, within, *args, **options)

    def clearance(self, tool: Any, world_from_tool: Any, within: float = 0.005, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._note(tool, world_from_tool, float(within))
        return super().clearance(tool, world_from_tool, within, *args, **options)

    def distance(self, tool: Any, world_from_tool: Any, within: float = math.inf, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        found = super().distance(tool, world_from_tool, within, *args, **options)
        self._note(tool, world_from_tool, min(float(within), found.value))
        return found

    def cast(
        self,
        tool: Any,
        start: Any,
        end: Any = None,
        *,
        screw: Any = None,
        tolerance: float = CAST_TOLERANCE,
        **options: Any,
    ) -> Any:
        """As `Scene`."""
        found = super().cast(tool, start, end, screw=screw, tolerance=tolerance, **options)
        begin = one_pose(start)
        if screw is None:
            stop = one_pose(end) if found is None else np.asarray(found.pose)
            if found is not None and not np.array_equal(begin[:3, :3], one_pose(end)[:3, :3]):
                stop = one_pose(end)
            self._note_way(tool, begin, stop, tolerance)
        elif isinstance(screw, _core.Screw):
            self._note_screw(tool, begin, screw)
        else:
            self._noted.all()
        return found

    def _cast_within(self, tool: Any, start: Any, screw: Any, **options: Any) -> Any:
        """As the engine's."""
        found = super()._cast_within(tool, start, screw, **options)
        self._noted.all()
        return found

    def check_path(self, tool: Any, poses: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        if isinstance(poses, np.ndarray) and poses.ndim == 3:
            self._note(tool, poses[0], is_solid=True)
            for start, end in pairwise(poses):
                self._note_way(tool, start, end, 1e-6)
        elif isinstance(poses, Sequence) and all(isinstance(each, np.ndarray) for each in poses):
            return self.check_path(tool, np.array(poses), *args, **options)
        else:
            self._noted.all()
        return super().check_path(tool, poses, *args, **options)

    def clearance_along(self, tool: Any, pose: Any, way: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        within = float(options.get("within", math.inf))
        if isinstance(way, np.ndarray) and math.isfinite(within):
            self._note_way(tool, one_pose(pose), one_pose(way), within)
        else:
            self._noted.all()
        return super().clearance_along(tool, pose, way, *args, **options)

    def rays(self, origins: Any, directions: Any, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        found = super().rays(origins, directions, *args, **options)
        starts, ways = np.asarray(origins, dtype=np.float64), np.asarray(directions, dtype=np.float64)
        if len(starts):
            noted = self._noted
            corner = np.maximum(np.abs(noted.lower - starts), np.abs(noted.upper - starts))
            far = float(np.linalg.norm(corner, axis=1).max())
            lengths = np.minimum(np.asarray(found.distances), min(far, float(options.get("within", math.inf))))
            ends = starts + ways * (lengths / np.linalg.norm(ways, axis=1))[:, None]
            both = np.concatenate([starts, ends])
            noted.box(both.min(axis=0), both.max(axis=0))
        return found

    def moved(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().moved(*args, **options)

    def penetration(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().penetration(*args, **options)

    def nearest(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().nearest(*args, **options)

    def section(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().section(*args, **options)

    def collide_batch(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().collide_batch(*args, **options)

    def clearance_batch(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().clearance_batch(*args, **options)

    def distance_batch(self, *args: Any, **options: Any) -> Any:
        """As `Scene`."""
        self._noted.all()
        return super().distance_batch(*args, **options)


def _corners_of(boxes: Floats) -> Floats:
    """The corners of boxes `(n, 2, 3)`: `(n, 8, 3)`."""
    return np.stack([boxes[:, [i, j, k], [0, 1, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)], axis=1)


def _corners(tool: _core.Tool, pose: Floats) -> Floats:
    low, high = tool.bounds
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    return np.asarray(corners @ pose[:3, :3].T + pose[:3, 3])


def _placed(tool: _core.Tool, pose: Floats) -> tuple[Floats, Floats]:
    """The box of a tool at a pose."""
    corners = _corners(tool, pose)
    return corners.min(axis=0), corners.max(axis=0)
