"""Tools about maintenance: how parts are taken out, with which tools, and what a mechanic sees."""

from __future__ import annotations

from typing import Any

import numpy as np

from feeler.agent.answers import part_name, part_names
from feeler.agent.job import Job
from feeler.agent.queries import MOST_ROWS, Answer, Given
from feeler.agent.served import Served
from feeler.errors import OptionError
from feeler.mockup import Mockup
from feeler.plan.fasteners import Fasteners, find_fasteners
from feeler.plan.sight import Seen
from feeler.plan.sight import sight as look
from feeler.tasks.answer import Task, TaskInterrupted
from feeler.tasks.nightly import eyes_over
from feeler.tasks.planning import task as plan
from feeler.tasks.steps import TaskStep
from feeler.tasks.times import Times

CATALOGUE, NO_TOOLS = "catalogue", "none"
"""Instead of the name of a tool."""
SECONDS = 2.0
"""The search has this many times the time of the call, so that the call ends it."""
_BLOCKERS = 3  # of each fastener


def tool_or_catalogue(served: Served, name: str) -> Any:
    """A tool by its name, or the catalogue."""
    return served.catalogue if name == CATALOGUE and name not in served.tools else served.tool(name)


def task(served: Served, given: Given, job: Job) -> Answer:
    """How parts are taken out, step by step, with tools and times."""
    scene = served.standing(given)
    wanted = served.present("parts", given["parts"])
    keep = None if given["keep"] is None else served.select("keep", given["keep"])
    tools: Any = None if given["tool"] == NO_TOOLS else tool_or_catalogue(served, given["tool"])
    times = Times(given["times"])

    def planned() -> tuple[Task, bool]:
        job.limit(given["seconds"])
        options: dict[str, Any] = {"seconds": SECONDS * given["seconds"], "progress": job.progress}
        try:
            task = plan(scene, wanted, tools, times, keep, given["people"], **options)
            return task, task.is_found or task.is_complete  # more time may find more
        except TaskInterrupted as stop:
            return stop.task, False

    found: Task = served.kept("task", given, ("seconds", "offset"), planned)
    job.check()
    offset = given["offset"]
    answer: Answer = {"found": found.is_found, "complete": found.is_complete, "said": found.said}
    if found.steps:
        answer |= {"seconds": found.seconds, "spread_seconds": found.spread, "tools": list(found.tools)}
    if found.is_found or not found.blocked:
        answer["bound_seconds"] = found.bound
    blocked = [
        {"part": each.part, "because": each.because, "blockers": list(each.blockers[:_BLOCKERS])}
        for each in found.blocked[:MOST_ROWS]
    ]
    return {
        **answer,
        "steps": len(found.steps),
        **({"blocked": blocked} if blocked else {}),
        "rows": [_step(scene.mockup, step) for step in found.steps[offset : offset + MOST_ROWS]],
        "notes": list(found.notes),
    }


def _step(mockup: Mockup, step: TaskStep) -> Answer:
    row: Answer = {
        "step": step.number + 1,
        "verb": step.verb,
        "parts": part_names(mockup, step.parts),
        "part_count": len(step.parts),
        "start_seconds": step.start,
        "seconds": step.seconds,
        "arithmetic": step.arithmetic,
    }
    if step.person:
        row["person"] = step.person + 1
    if step.tool:
        row |= {"tool": step.tool, "swing_deg": step.swing_deg, "strokes": step.strokes}
    return row


def sight(served: Served, given: Given, job: Job) -> Answer:
    """How much is seen of fasteners: from eyes, or from the best place around each."""
    scene = served.standing(given)
    targets = None if given["targets"] is None else served.present("targets", given["targets"])
    eyes = None if given["eyes_m"] is None else np.array(given["eyes_m"], dtype=np.float64)

    def looked() -> tuple[list[Seen], bool]:
        bolts = find_fasteners(scene, targets, progress=job.progress)
        if not len(bolts):
            raise OptionError("no part among these looks like a fastener: name others, or leave targets out")
        rows: list[Seen] = []
        for bolt in bolts:
            job.progress(len(rows) / len(bolts), "looking at fasteners")
            rows += list(look(scene, Fasteners([bolt]), eyes_over(bolt) if eyes is None else eyes))
        return rows, True

    job.limit(given["seconds"])
    found: list[Seen] = served.kept("sight", given, ("seconds", "offset"), looked)
    offset = given["offset"]
    rows = sorted(found, key=lambda row: row.share)
    return {
        "targets": len(rows),
        "hidden": sum(row.eye is None for row in rows),
        "rows": [_seen(scene.mockup, row) for row in rows[offset : offset + MOST_ROWS]],
    }


def _seen(mockup: Mockup, row: Seen) -> Answer:
    answer: Answer = {"part": row.path if row.part is None else part_name(mockup, row.part), "share": row.share}
    return answer | ({"hidden_by": [path for path, _ in row.hidden_by[:_BLOCKERS]]} if row.hidden_by else {})
