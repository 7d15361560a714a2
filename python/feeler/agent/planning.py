"""Tools that take time: clash checks, removal paths and orders, access to fasteners."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from feeler.agent.answers import AT_LEAST, part_name, part_names, point
from feeler.agent.job import Job
from feeler.agent.queries import MOST_ROWS, Answer, Given
from feeler.agent.served import Served
from feeler.agent.tasks import tool_or_catalogue
from feeler.clashes import Clash, Clashes, ClashInterrupted, Verdict
from feeler.clashes import clash as clash_check
from feeler.errors import OptionError
from feeler.mockup import Mockup
from feeler.plan.blocked import Blocker
from feeler.plan.catalogue import Catalogue
from feeler.plan.fasteners import Fasteners, find_fasteners
from feeler.plan.order import removal_order
from feeler.plan.reaching import SWING_DEG, Access, AccessInterrupted, Reach
from feeler.plan.reaching import access as reach
from feeler.plan.removal import Removal
from feeler.plan.removal import removal as way_out
from feeler.scene import Scene

_LEGS = 6  # shown of a way
_BLOCKERS = 3  # of each fastener


def clash(served: Served, given: Given, job: Job) -> Answer:
    """All pairs of parts that overlap, touch or are too near; the worst first."""
    found: Clashes = served.kept(
        "clash", given, ("part", "verdict", "seconds", "offset"), lambda: _clashes(served, given, job)
    )
    job.check()
    chosen = found
    if given["part"] is not None:
        wanted = served.select("part", given["part"])
        chosen = chosen[np.isin(chosen.parts_a, wanted) | np.isin(chosen.parts_b, wanted)]
    counts = {each.value: len(chosen.where(verdict=each)) for each in Verdict}
    if given["verdict"] is not None:
        chosen = chosen.where(verdict=given["verdict"])
    offset = given["offset"]
    return {
        "complete": not found.is_partial,
        "findings": len(chosen),
        "verdicts": {verdict: count for verdict, count in counts.items() if count},
        "rows": [_finding(served.mockup, row) for row in chosen[offset : offset + MOST_ROWS]],
        "kinds": {"findings": AT_LEAST, "verdicts": AT_LEAST} if found.is_partial else {},
    }


def _clashes(served: Served, given: Given, job: Job) -> tuple[Clashes, bool]:
    job.limit(given["seconds"])
    try:
        scene = served.standing(given)
        found = clash_check(served.mockup, given["clearance_m"], given["contact_m"], scene=scene, progress=job.progress)
    except ClashInterrupted as stop:
        found = stop.clashes
    return found, not found.is_partial


def _finding(mockup: Mockup, row: Clash) -> Answer:
    verdict = row.verdict.value
    names = {"part_a": part_name(mockup, row.a), "part_b": part_name(mockup, row.b)}
    answer: Answer = {**names, "verdict": verdict}
    if verdict == "clearance":
        return {**answer, "gap_m": row.gap, "point_a_m": point(row.point_a)}
    if row.depth_kind == "estimate":
        answer["depth_estimate_m"] = row.depth
    else:
        answer |= {"depth_m": row.depth, "depth_at_most_m": row.depth + row.depth_error}
    if row.gap > 0.0:
        answer["gap_m"] = row.gap
    length = float(np.linalg.norm(row.translation))
    return {**answer, "separation_m": length if length > 0.0 else None, "point_a_m": point(row.point_a)}


def _options(served: Served, given: Given, moved: Any) -> dict[str, Any]:
    """The options of removals and orders; with the tool that grips the parts."""
    tool = None if given["tool"] is None else served.tool(given["tool"])
    if tool is None and given["tool_pose"] is not None:
        raise OptionError("tool_pose is of a tool that grips the parts: give tool, too")
    if tool is not None:
        _check_grip(served, tool, np.eye(4) if given["tool_pose"] is None else given["tool_pose"], moved)
    return {
        "tool": tool,
        "start": given["tool_pose"],
        "directions": None if given["directions"] is None else np.array(given["directions"]),
        "clearance": given["clearance_m"],
        "seconds": given["seconds"],
        "seed": given["seed"],
    }


def _check_grip(served: Served, tool: Any, pose: Any, moved: Any) -> None:
    """Refuses a tool that is far from the parts: a search would move both through all that is between them."""
    bounds = np.asarray(served.mockup.part_bounds).reshape(-1, 2, 3)[moved]
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    middle = pose[:3, :3] @ tool.bounds.mean(axis=0) + pose[:3, 3]
    away = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - middle, middle - high))))
    if away > float(np.linalg.norm(np.diff(served.mockup.bounds, axis=0))):
        raise OptionError(f"tool_pose: the tool is {away:.4g} m away from the parts: put it where it grips them")


def _moved(served: Served, given: Given) -> tuple[Scene, Any]:
    """The scene with the parts in it, and the parts to take out."""
    scene = served.standing(given)
    moved = served.present("parts", given["parts"])
    there = moved[scene.part_mask[moved]]
    if not len(there):
        raise OptionError("parts are all among those that `without` names: name others")
    return scene, there


def removal(served: Served, given: Given, job: Job) -> Answer:
    """A path of parts out of the mock-up, or what blocks it."""
    scene, moved = _moved(served, given)
    found = way_out(scene, moved, **_options(served, given, moved), progress=job.progress)
    return {
        "parts": {"count": len(moved), "first": part_names(scene.mockup, moved)},
        **_way(found),
        "play_m": found.play,
        "held_by": [part_name(scene.mockup, part.index) for part in found.held_by],
        "out_of_time": found.is_out_of_time,
        "blocked_by": _blockers(scene.mockup, found),
    }


def _blockers(mockup: Mockup, found: Removal) -> list[Answer]:
    return [
        {"part": part_name(mockup, each.part), "attempts": each.count, "reach_m": each.reach}
        for each in found.blocked_by
    ]


def _way(found: Removal) -> Answer:
    answer: Answer = {"found": found.is_found}
    if found.is_found:
        answer |= {
            "method": found.certificate.method,
            "legs": [str(leg) for leg in found.legs[:_LEGS]],
            "leg_count": len(found.legs),
            "path_length_m": found.path_length,
            "rotation_deg": math.degrees(found.rotation),
            "clearance_m": found.clearance,
        }
    return answer


def order(served: Served, given: Given, job: Job) -> Answer:
    """The parts that go first, and the path of each."""
    scene, moved = _moved(served, given)
    keep = None if given["keep"] is None else served.select("keep", given["keep"])
    found = served.kept(
        "order",
        given,
        ("offset",),
        lambda: (
            removal_order(scene, moved, **_options(served, given, moved), keep=keep, progress=job.progress),
            not job.is_cancelled,
        ),
    )
    offset = given["offset"]
    answer: Answer = {
        "found": found.is_found,
        "out_of_time": found.is_out_of_time,
        "seconds": round(found.seconds, 3),
    }
    if not found.is_found:
        last = found.steps[-1].removal
        held = [part_name(scene.mockup, part.index) for part in last.held_by]
        return {**answer, "held_by": held, "blocked_by": _blockers(scene.mockup, last)}
    return {
        **answer,
        "steps": len(found.steps),
        "rows": [
            {
                "step": offset + i + 1,
                "parts": part_names(scene.mockup, step.parts),
                "part_count": len(step.parts),
                "legs": [str(leg) for leg in step.removal.legs[:_LEGS]],
                "path_length_m": step.removal.path_length,
            }
            for i, step in enumerate(found.steps[offset : offset + MOST_ROWS])
        ],
    }


def access(served: Served, given: Given, job: Job) -> Answer:
    """Whether a tool reaches each fastener, and how far it swings there."""
    tool = tool_or_catalogue(served, given["tool"])
    hand = None if given["hand"] is None else served.tool(given["hand"])
    scene = served.standing(given)
    targets = None if given["targets"] is None else served.present("targets", given["targets"])
    asked: tuple[Fasteners, Access] = served.kept(
        "access", given, ("seconds", "offset"), lambda: _reached(scene, tool, hand, targets, given, job)
    )
    job.check()
    bolts, found = asked
    kinds = {bolt.part: bolt for bolt in bolts}
    rows = sorted(found, key=lambda row: (row.is_reachable, row.target))
    offset = given["offset"]
    return {
        "complete": not found.is_partial,
        "targets": len(bolts),
        "tried": len(found),
        "reachable": int(found.is_reachable.sum()),
        "rows": [_reach(scene.mockup, row, kinds) for row in rows[offset : offset + MOST_ROWS]],
    }


def _reached(
    scene: Scene, tool: Any, hand: Any, targets: Any, given: Given, job: Job
) -> tuple[tuple[Fasteners, Access], bool]:
    job.limit(given["seconds"])
    bolts = find_fasteners(scene, targets, progress=job.progress)
    if given["kind"] is not None:
        bolts = bolts.where(kind=given["kind"])
    if not len(bolts):
        what = given["kind"] or "fastener"
        raise OptionError(f"no part among these looks like a {what}: name others, or leave targets out")
    job.next_step()
    try:
        found = reach(
            scene,
            tool,
            bolts,
            _swing(tool, given["swing_deg"]),
            hand=hand,
            approach=given["approach_m"],
            grip=given["grip"],
            lift=given["lift_m"],
            progress=job.progress,
        )
    except AccessInterrupted as stop:
        found = stop.access
    return (bolts, found), not found.is_partial


def _swing(tool: Any, needed: float | None) -> float | None:
    """Each tool of a catalogue says what it needs."""
    return SWING_DEG if needed is None and not isinstance(tool, Catalogue) else needed


def _reach(mockup: Mockup, row: Reach, bolts: dict[int, Any]) -> Answer:
    bolt = None if row.part is None else bolts.get(row.part)
    answer: Answer = {
        "part": None if row.part is None else part_name(mockup, row.part),
        "fastener": None if bolt is None else bolt.kind,
        "reachable": row.is_reachable,
        "swing_deg": row.swing_deg,
    }
    if row.is_reachable:
        answer["tool"] = row.tool
    if not row.is_reachable:
        blockers: tuple[Blocker, ...] = row.blockers[:_BLOCKERS]
        answer |= {
            "because": row.because,
            "looked_m": row.looked,
            "drawn_m": row.drawn,
            "blockers": [part_name(mockup, each.part) for each in blockers],
        }
    return answer
