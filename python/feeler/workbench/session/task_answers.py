"""The answer to how parts are taken out: a plan in steps, with the edits of the user."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from feeler.mockup import Mockup, Tool
from feeler.plan.catalogue import Catalogue, catalogue, parsed_catalogue
from feeler.progress import Progress
from feeler.tasks.answer import Task
from feeler.tasks.planning import planned
from feeler.tasks.steps import TaskBlocker, TaskStep, clock
from feeler.tasks.times import Times, WholePath
from feeler.workbench.document import motion
from feeler.workbench.document.answers import TaskAnswer, TaskBlockerFacts, TaskStepFacts, WayFacts
from feeler.workbench.document.document import Card, Document, TaskEdits
from feeler.workbench.document.known import Way
from feeler.workbench.engine.hand import Hands
from feeler.workbench.session.answering import Answered, Asked

SECONDS = 600.0
"""Time for the search, unless another is asked for."""


def parts_at(mockup: Mockup, paths: tuple[str, ...]) -> tuple[int, ...]:
    """The parts at paths, as far as they are there."""
    if not paths:
        return ()
    wanted = set(paths)
    return tuple(part for part, path in enumerate(mockup.part_paths) if path in wanted)


def task_answer(asked: Asked, progress: Progress) -> Answered:
    """How parts are taken out, with which tools, and how long it takes."""
    if not asked.parts:
        return Answered("It is off already.", True)
    edits, there = asked.edits, set(np.flatnonzero(asked.scene.part_mask).tolist())
    pairs = [(parts_at(asked.mockup, (one,)), parts_at(asked.mockup, (other,))) for one, other in edits.before]
    found = planned(
        asked.memory,
        asked.scene,
        list(asked.parts),
        _tools(asked),
        _times(asked),
        people=int(asked.options.get("people", 1)),
        before=[(one, other) for one, other in pairs if there.issuperset(one) and there.issuperset(other)],
        seconds=asked.number("seconds", SECONDS),
        threads=asked.threads,
        progress=progress,
    )
    numbers = {path: part for part, path in enumerate(asked.mockup.part_paths)}
    facts: TaskAnswer = {
        "steps": [_step(step, numbers, edits) for step in found.steps],
        "seconds": _known(found.seconds),
        "spread": _known(found.spread),
        "bound": _known(found.bound),
        "people": found.people,
        "is_complete": found.is_complete,
        "blocked": [_blocker(each, numbers) for each in found.blocked],
        "notes": list(found.notes),
    }
    ways = tuple(Way(step.parts, _rows(step), None) for step in found.steps)
    rows = tuple(_way_facts(asked.mockup, way, step) for way, step in zip(ways, found.steps, strict=True))
    said = found.said[:1].upper() + found.said[1:].replace("+-", "±")
    return Answered(f"{said}.", found.is_found, ways, rows, facts=_totals(found), task=facts)


def _times(asked: Asked) -> Times:
    """The table of the project, with the times that were typed."""
    table = Times.parse(asked.times)
    given = {name: each for name, each in table.elements.items() if name not in table.examples}
    typed: dict[str, Any] = {WholePath(path): seconds for path, seconds in asked.edits.times}
    return Times(given, pitches_mm=table.pitches_mm, typed=typed | table.typed)


def _tools(asked: Asked) -> Catalogue | dict[str, Any] | None:
    """The catalogue unless tools were named; else these by name, each as it is held; None: their reach is not
    checked."""
    if "tools" not in asked.options:
        return catalogue_of(asked.catalogue)
    if not asked.tools:
        return None
    is_wrench = {name: name == "wrench" and name in asked.built_in for name in asked.tools}
    return {name: (tool, {"grip": "y"}) if is_wrench[name] else tool for name, tool in asked.tools.items()}


def _step(step: TaskStep, numbers: Mapping[str, int], edits: TaskEdits) -> TaskStepFacts:
    return {
        "verb": step.verb,
        "part": numbers[step.part],
        "tool": step.tool,
        "swing_deg": _known(step.swing_deg),
        "strokes": step.strokes,
        "tool_way": [list(motion.row(pose)) for pose in step.tool_way],
        "person": step.person,
        "start": step.start,
        "seconds": step.seconds,
        "spread": step.spread,
        "after": list(step.after),
        "because": step.because,
        "arithmetic": step.arithmetic,
        "is_typed": any(path == step.part for path, _ in edits.times),
    }


def _rows(step: TaskStep) -> tuple[motion.Row, ...]:
    """The way of a step; where the part is, if the time ended before its way was tried."""
    return tuple(motion.row(pose) for pose in (step.way if len(step.way) else np.eye(4)[None]))


def _blocker(row: TaskBlocker, numbers: Mapping[str, int]) -> TaskBlockerFacts:
    return {
        "part": numbers.get(row.part),
        "because": row.because,
        "blockers": [numbers[path] for path in row.blockers],
    }


def _way_facts(mockup: Mockup, way: Way, step: TaskStep) -> WayFacts:
    bounds = mockup.part_bounds.reshape(-1, 2, 3)[list(step.parts)]
    gone, turned = motion.steps_of(step.way, motion.middle_of(bounds, [motion.HOME] * len(bounds)))
    return {
        "parts": list(way.parts),
        "poses": [list(pose) for pose in way.poses],
        "clearance": None,
        "legs": [step.because],
        "length": sum(gone),
        "rotation": sum(turned),
        "gaps": [],
    }


def _totals(found: Task) -> tuple[tuple[str, str], ...]:
    if not found.is_found:
        return ()
    return tuple(
        (f"with {name}" if name else "by hand", f"{clock(each.mean)} ± {clock(each.spread)}")
        for name, each in found.by_tool.items()
    )


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


@lru_cache(maxsize=4)
def catalogue_of(toml: str) -> Catalogue:
    """That of a document; without a text the built-in one."""
    return parsed_catalogue(toml, "the catalogue") if toml else catalogue()


def tool_called(hands: Hands, document: Document, card: Card, name: str) -> Tool:
    """The tool of a step of a card: one that may be held, or of the catalogue. Raises `OptionError`."""
    return hands.tool(name) if "tools" in card.options else catalogue_of(document.task_catalogue.toml).tool(name)


def tool_at(tool: Tool, pose: Any) -> Tool:
    """A tool at a pose, in the world's frame. Raises `WorkbenchError` for a pose that is none."""
    return Tool.assembly({tool.name or "tool": (tool, motion.checked(pose, "tool_way"))}, tool.name)
