"""A task as an animated GLB: parts leave in the order and at the times of the plan, and tools come to their seats."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_number
from feeler.atomic import atomic_file
from feeler.errors import OptionError
from feeler.io.body import LIGHT_GREY, ORANGE, STEEL_BLUE, body_of
from feeler.io.export import Motion, animated_glb
from feeler.io.film import moments, motion_of, with_neighbours
from feeler.mockup import Mockup, Tool
from feeler.plan.as_glb import in_steps
from feeler.tasks.reached import TaskTools, shape_of
from feeler.tasks.steps import TaskFacts, TaskStep

Floats = npt.NDArray[np.float64]

SPEED = 10.0
"""The film runs so many times as fast as the work."""
FASTEST, SLOWEST = 1e4, 1e-2
COME, WORK, GO = 0.2, 0.6, 0.75
"""Shares of a step at which the tool is in its seat, begins to leave, and is away; then the fastener comes out."""
JUMP_S = 1e-3
"""In which a tool comes from its place beside the mock-up to where its way in begins, seconds of the film."""
BESIDE = 0.1
"""How far beside the shown parts tools and parts lie, by the largest side of their box."""
GAP_M = 0.01
"""Between parts that were put aside, metres."""


def write_task_glb(
    path: str | os.PathLike[str], mockup: Mockup, task: TaskFacts, tools: TaskTools = None, speed: float = SPEED
) -> int:
    """Writes the film; returns its size in bytes. See `Task.to_glb`."""
    check_kind("mockup", mockup, Mockup)
    quick = check_number("speed", speed, "0.01 to 10,000", least=SLOWEST, most=FASTEST)
    _check_same(mockup, task)
    moving = sorted({part for step in task.steps for part in step.parts})
    shown = with_neighbours(mockup, moving)
    place = {part: number for number, part in enumerate(shown)}
    scene = Tool.of_parts(mockup, shown, "task")
    colours = [np.tile(np.array(LIGHT_GREY), (len(shown), 1))]
    colours[0][[place[part] for part in moving]] = STEEL_BLUE
    tracks: dict[int, _Track] = {}
    laid = 0.0
    for step in task.steps:
        bounds = Tool.of_parts(mockup, list(step.parts)).bounds
        aside = None if step.verb == "disconnect" else _aside(scene.bounds, bounds, laid)
        laid += 0.0 if aside is None else float(bounds[1, 1] - bounds[0, 1]) + GAP_M
        drawn = _timed(step.way, bounds)
        for part in step.parts:
            tracks.setdefault(place[part], _Track(np.eye(4))).leave(step, drawn, quick, aside)
    pieces: dict[str, object] = {"task": scene}
    first = len(shown)
    for number, (name, person) in enumerate(_held(task)):
        tool = shape_of(tools, name)
        pieces[_free(name if task.people == 1 else f"{name} of person {person + 1}", pieces)] = tool
        track = _Track(_beside(scene.bounds, tool, number))
        for step in task.steps:
            if (step.tool, step.person) == (name, person) and len(step.tool_way):
                track.visit(step, tool, quick)
        tracks |= {first + part: track for part in range(tool.part_count)}
        colours.append(np.tile(np.array(ORANGE), (tool.part_count, 1)))
        first += tool.part_count
    whole = scene if len(pieces) == 1 else Tool.assembly(pieces, "task")  # type: ignore[arg-type]
    motions = [track.motion(node) for node, track in sorted(tracks.items())]
    with atomic_file(path, ".glb") as file:
        data = animated_glb(body_of(whole, colours=np.concatenate(colours)), motions)
        file.write(data)
    return len(data)


def _check_same(mockup: Mockup, task: TaskFacts) -> None:
    if not task.is_found:
        raise OptionError("there is no film of a task without a plan: see what blocks it, in .blocked")
    for step in task.steps:
        paths = zip(step.parts, step.paths, strict=True)
        if any(part >= mockup.part_count or mockup.part_paths[part] != path for part, path in paths):
            raise OptionError("the task is of another mock-up: give the mock-up that its parts come out of")


def _held(task: TaskFacts) -> list[tuple[str, int]]:
    """The tools that are used, and by whom: each person has the tools."""
    return list(dict.fromkeys((step.tool, step.person) for step in task.steps if step.tool and len(step.tool_way)))


def _free(name: str, taken: dict[str, object]) -> str:
    return name if name not in taken else f"{name} (tool)"


def _beside(bounds: Floats, tool: Tool, number: int) -> Floats:
    """A place beside the shown parts, in a row, for a tool that is not in use."""
    size = float((bounds[1] - bounds[0]).max())
    pose = np.eye(4)
    pose[:3, 3] = [
        bounds[1, 0] + BESIDE * size - tool.bounds[0, 0],
        bounds[0, 1] + BESIDE * size * number,
        bounds[0, 2] - tool.bounds[0, 2],
    ]
    return pose


def _aside(bounds: Floats, parts: Floats, laid: float) -> Floats:
    """The motion of parts with a box that puts them aside: in a row on the side where no tools are, from `laid` on."""
    size = float((bounds[1] - bounds[0]).max())
    pose = np.eye(4)
    pose[:3, 3] = [
        bounds[0, 0] - BESIDE * size - parts[1, 0],
        bounds[0, 1] + laid - parts[0, 1],
        bounds[0, 2] - parts[0, 2],
    ]
    return pose


def _timed(way: Floats, bounds: Floats) -> tuple[Floats, Floats]:
    """A way with more poses where it turns, and shares of its time `(n,)` from 0 to 1. bounds: of what moves."""
    poses = in_steps(way, bounds.mean(axis=0)) if len(way) > 1 else way
    gone = moments(poses, bounds)
    return poses, gone / gone[-1] if gone[-1] > 0.0 else gone


class _Track:
    """The poses of a part or a tool over time, from one at the beginning."""

    def __init__(self, home: Floats) -> None:
        self._home, self._times, self._poses = home, [0.0], [home]

    def leave(self, step: TaskStep, drawn: tuple[Floats, Floats], speed: float, aside: Floats | None) -> None:
        """Parts leave at the end of their step, from where they are, and are put aside."""
        begin = GO if len(step.tool_way) else 0.0
        self._add(step, begin, 1.0, drawn, speed, self._poses[-1])
        if aside is not None:
            self._key(max(self._times[-1], (step.start + step.seconds) / speed), self._poses[-1])
            self._key(self._times[-1] + JUMP_S, aside)

    def visit(self, step: TaskStep, tool: Tool, speed: float) -> None:
        """A tool comes to its seat, works, and goes back to its place."""
        way, shares = _timed(step.tool_way, tool.bounds)
        start, home = step.start / speed, self._home
        self._key(start, home)
        begin = min(0.5 * COME, JUMP_S * speed / step.seconds) if step.seconds > 0.0 else 0.0
        self._add(step, begin, COME, (way, shares), speed)
        self._add(step, WORK, GO, (way[::-1], 1.0 - shares[::-1]), speed)
        self._key(self._times[-1] + JUMP_S, home)

    def _add(
        self,
        step: TaskStep,
        begin: float,
        end: float,
        drawn: tuple[Floats, Floats],
        speed: float,
        start: Floats | None = None,
    ) -> None:
        poses, shares = drawn
        for pose, share in zip(poses, shares.tolist(), strict=True):
            moment = (step.start + step.seconds * (begin + (end - begin) * share)) / speed
            self._key(moment, pose if start is None else pose @ start)

    def _key(self, moment: float, pose: Floats) -> None:
        """A pose at a moment; times go up."""
        last = self._times[-1]
        if len(self._times) == 1 and moment <= last:
            self._poses[0] = pose
            return
        self._times.append(max(moment, last + 1e-6))
        self._poses.append(pose)

    def motion(self, part: int) -> Motion:
        """Of a part of the film."""
        return motion_of(part, np.array(self._times), np.stack(self._poses))
