"""The answers to questions of cards: by the planner, of the mock-up as it stands."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from feeler.errors import WorkbenchError
from feeler.mockup import Mockup, Tool
from feeler.parts import Part
from feeler.plan.legs import leg_words
from feeler.plan.order import RemovalOrder, removal_order
from feeler.plan.removal import Removal, RemovalBlocker, removal
from feeler.plan.swept import swept
from feeler.poses import between
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.tasks.replanning import Memory
from feeler.words import length_in, plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import BlockerFacts, CardAnswer, Gap, ReachFacts, TaskAnswer, WayFacts
from feeler.workbench.document.cards import task_parts
from feeler.workbench.document.document import NO_EDIT, Card, TaskEdits
from feeler.workbench.document.frames import check
from feeler.workbench.document.known import Way
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol import HeldManifest, Vec3
from feeler.workbench.engine.gaps import WITHIN_M, Gaps, Near, gap_json
from feeler.workbench.engine.geometry import HeldGeometry
from feeler.workbench.engine.world import World
from feeler.workbench.session.apart import way_apart

SECONDS, ORDER_SECONDS = 30.0, 120.0
"""Time for the search of a way, and of an order, unless another is asked for."""
MOST_GAPS, MOST_REFINED = 121, 400
"""Poses of a way at which the gap is looked for, evenly spread; and at most where it is least."""
ROOM_SHARE, ROOM_STEPS = 1.0 / 60.0, 300.0
"""The swept volume may exceed the true one by this share of the moving parts' size, and by an eighth of their smallest
side, but not less than its own size over `ROOM_STEPS`: it would take long, and gigabytes."""
CLEARANCE_ERROR = 0.05
"""The clearance of a way may be too large by this share (`Removal.clearance`)."""
MOST_BLOCKERS = 100
_NAMED = 3  # parts named in a sentence

Lengths = Callable[[float], str]
"""A length in words, of metres."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked: parts of a scene, tools by name, options of the card, and how many threads may work on it.

    built_in: the names of tools whose way to sit on a fastener is known.
    """

    scene: Scene
    parts: tuple[int, ...]
    options: Mapping[str, Any]
    tools: Mapping[str, Tool]
    built_in: frozenset[str]
    threads: int
    edits: TaskEdits = NO_EDIT
    times: str = ""
    """Of a task: the table of times, TOML."""
    catalogue: str = ""
    """Of a task, and of access: the catalogue of tools, TOML; empty: the built-in one."""
    memory: Memory = field(default_factory=Memory)
    """Of a task: what its plans before edits found."""
    unit: str = "mm"
    """Of lengths in words."""

    @property
    def mockup(self) -> Mockup:
        """Of the scene."""
        return self.scene.mockup

    def length(self, metres: float) -> str:
        """A length in words."""
        return length_in(metres, self.unit)

    def number(self, name: str, default: float) -> float:
        """An option, or its default."""
        return float(self.options.get(name, default))


@dataclass(frozen=True, eq=False)
class Room:
    """A swept volume, packed for the page."""

    manifest: HeldManifest
    data: bytes


@dataclass(frozen=True, eq=False)
class Answered:
    """An answer: in a sentence, in figures, and its ways. room: the swept volume, packed."""

    sentence: str
    is_good: bool | None
    ways: tuple[Way, ...] = ()
    way_facts: tuple[WayFacts, ...] = ()
    blockers: tuple[BlockerFacts, ...] = ()
    reaches: tuple[ReachFacts, ...] = ()
    room: Room | None = None
    facts: tuple[tuple[str, str], ...] = field(default=())
    task: TaskAnswer | None = None

    def to_json(self, number: int) -> CardAnswer:
        """All of it, for the page."""
        answer: CardAnswer = {
            "id": number,
            "ways": list(self.way_facts),
            "blockers": list(self.blockers),
            "reaches": list(self.reaches),
            "room": None if self.room is None else self.room.manifest,
            "facts": [{"name": name, "figure": figure} for name, figure in self.facts],
        }
        if self.task is not None:
            answer["task"] = self.task
        return answer


def way_out(asked: Asked, progress: Progress) -> Answered:
    """Whether parts come out."""
    found = _removal(asked, progress)
    if not found.is_found:
        return Answered(_blocked(asked, found), False, blockers=_blockers(found.held_by, found.blocked_by))
    gaps = _gaps(asked.scene, asked.parts, found, progress)
    way = _way(asked.parts, found, gaps)
    what, wanted = _names(asked.mockup, asked.parts), asked.number("clearance", 0.0)
    if not found.legs:
        return _apart(asked, what, way)
    is_kept = way.clearance is None or way.clearance >= wanted * (1.0 - CLEARANCE_ERROR)
    short = "" if is_kept else f", less than the {asked.length(wanted)} that you asked for"
    return Answered(
        f"{what} {_verb(asked.parts, 'come')} out: {_way_words(found, asked.length)}"
        f"{nearest(asked.mockup, way, gaps, asked.length)}{short}.",
        is_kept,
        (way,),
        (_way_facts(way, found, gaps, asked.length),),
        _blockers(found.held_by, found.blocked_by),
    )


def _apart(asked: Asked, what: str, way: Way) -> Answered:
    """The answer for parts outside of all others, with a way to take: others may still be stopped by them."""
    lie = "lies" if len(asked.parts) == 1 else "lie"
    found = way_apart(asked.scene, asked.parts)
    if found is None:
        return Answered(f"{what} {lie} outside of all other parts already: nothing is in the way.", True, (way,))
    poses, direction, long = found
    facts: WayFacts = {
        "parts": list(way.parts),
        "poses": [list(pose) for pose in poses],
        "clearance": way.clearance,
        "legs": [f"{asked.length(long)} along {direction}"],
        "length": long,
        "rotation": 0.0,
        "gaps": [],
    }
    said = f"{what} {lie} outside of all other parts already, and {_verb(asked.parts, 'move')} away along {direction}."
    return Answered(said, True, (replace(way, poses=poses),), (facts,))


def order(asked: Asked, progress: Progress) -> Answered:
    """Which parts have to go before others come out."""
    found = removal_order(
        asked.scene,
        list(asked.parts),
        clearance=asked.number("clearance", 0.0),
        seconds=asked.number("seconds", ORDER_SECONDS),
        threads=asked.threads,
        progress=progress,
    )
    if not found.is_found:
        return _no_order(asked, found)
    ways = tuple(_way(step.parts, step.removal, []) for step in found.steps)
    facts = tuple(_way_facts(way, step.removal, [], asked.length) for way, step in zip(ways, found.steps, strict=True))
    what = f"{_names(asked.mockup, asked.parts)} {_verb(asked.parts, 'come')} out"
    others = shown(asked.mockup, (part for step in found.steps[:-1] for part in step.parts))
    along = shown(asked.mockup, (part for part in found.steps[-1].parts if part not in asked.parts))
    if along:
        what += f" together with {listed(along)}"
    if not others:
        return Answered(f"{what}{',' if along else ''} with nothing before: one step.", True, ways, facts)
    go = "goes" if len(others) == 1 else "go"
    sentence = f"{what} after {listed(others)} {go}: {plural(len(found.steps), 'step')}."
    return Answered(sentence, True, ways, facts)


def _no_order(asked: Asked, found: RemovalOrder) -> Answered:
    last = found.steps[-1].removal
    said = f"No order was found in {found.seconds:.0f} s"
    if last.held_by or not found.blocked_by:
        blockers = _blockers(last.held_by, last.blocked_by)
    else:
        blockers = _blockers((), found.blocked_by)
        if found.stuck != asked.parts:
            do = "does" if len(found.stuck) == 1 else "do"
            said += f": {_names(asked.mockup, found.stuck)} {do} not come out"
    names = listed(shown(asked.mockup, (each["part"] for each in blockers)))
    return Answered(f"{said}; stopped by {names}." if names else f"{said}.", False, blockers=blockers)


def room(asked: Asked, progress: Progress) -> Answered:
    """The room that parts need on their way out."""
    found = _removal(asked, part_of(progress, 0.0, 0.6))
    if not found.is_found:
        return Answered(_blocked(asked, found), False, blockers=_blockers(found.held_by, found.blocked_by))
    moving = Tool.of_parts(asked.mockup, list(asked.parts))
    error = _room_error(moving, found)
    volume = swept(
        moving,
        found.poses,
        error,
        threads=asked.threads,
        progress=part_of(progress, 0.6, 1.0),
    )
    low, high = volume.bounds
    way = _way(asked.parts, found, [])
    litres = _volume(volume) * 1e3
    # Rounded to a millimetre.
    *sides, last = (asked.length(round(float(side), 3)) for side in high - low)
    box = " × ".join([*(side.removesuffix(f" {asked.unit}") for side in sides), last])
    return Answered(
        f"{_names(asked.mockup, asked.parts)} {_verb(asked.parts, 'need')} at most {_litres(litres)} on the way out, "
        f"within {box}.",
        True,
        (way,),
        (_way_facts(way, found, [], asked.length),),
        room=_packed(volume),
        facts=(
            ("volume, at most", _litres(litres)),
            ("drawn too large by at most", asked.length(error)),
            ("box", box),
            ("way", _way_words(found, asked.length)),
        ),
    )


def kept_answer(card: Card, facts: Any, data: bytes | None, parts: int) -> Answered | None:
    """The answer that `to_json` gave, from a project file of anybody; None for anything else. parts: their number."""
    try:
        if not isinstance(facts, dict):
            return None
        given = {key: value for key, value in facts.items() if key != "kind"}
        _complete_reaches(given, card)
        answer: CardAnswer = check(given, CardAnswer, "answer")
        ways = tuple(
            Way(
                tuple(way["parts"]),
                tuple(motion.row(motion.checked(pose, "pose")) for pose in way["poses"]),
                way["clearance"],
            )
            for way in answer["ways"]
        )
    except WorkbenchError:
        return None
    named = [part for way in ways for part in way.parts]
    named += [each["part"] for each in answer["blockers"]]
    named += [part for each in answer["reaches"] for part in (each["part"], *each["blockers"]) if part is not None]
    named += [each["part"] for way in answer["ways"] for each in way["gaps"] if each["part"] is not None]
    named += [way["hit"]["part"] for way in answer["ways"] if "hit" in way]
    named += task_parts(answer)
    elsewhere = [part for way in answer["ways"] for part in way.get("places", {})]
    if not all(part.isascii() and part.isdigit() and len(part) < 12 for part in elsewhere):
        return None
    named += map(int, elsewhere)
    if not all(0 <= part < parts for part in named) or not all(way.poses and way.parts for way in ways):
        return None
    room = answer["room"]
    if room is not None and (data is None or len(data) != sum(piece["bytes"] for piece in room["pieces"])):
        return None
    return Answered(
        card.sentence,
        card.is_good,
        ways,
        tuple(answer["ways"]),
        tuple(answer["blockers"]),
        tuple(answer["reaches"]),
        None if room is None or data is None else Room(room, data),
        tuple((each["name"], each["figure"]) for each in answer["facts"]),
        answer.get("task"),
    )


def _complete_reaches(answer: dict[str, Any], card: Card) -> None:
    """Rows of access that were kept before several tools could be asked about do not name theirs; those before the
    catalogue was asked have no strokes, hand and head."""
    rows = answer.get("reaches")
    tool = card.options.get("tool")
    for row in rows if isinstance(rows, list) else []:
        if isinstance(row, dict) and "tool" not in row and isinstance(tool, str):
            row.update(tool=tool, tools=[tool] if row.get("is_reachable") is True else [])
        if isinstance(row, dict):
            older = {"is_catalogue": False, "strokes": None, "has_hand": None, "head": ""}
            row.update({name: value for name, value in older.items() if name not in row})


ANSWERS: dict[str, Callable[[Asked, Progress], Answered]] = {
    "removal": way_out,
    "order": order,
    "swept": room,
}
"""By the question of a card; `access_answers.py` has that of access."""


def _removal(asked: Asked, progress: Progress) -> Removal:
    return removal(
        asked.scene,
        list(asked.parts),
        clearance=asked.number("clearance", 0.0),
        seconds=asked.number("seconds", SECONDS),
        threads=asked.threads,
        progress=progress,
    )


def _room_error(moving: Tool, found: Removal) -> float:
    """By how much a swept volume may be too large: little beside the parts, but not so little that it takes long."""
    low, high = moving.bounds
    around = motion.corners(moving.bounds)
    places = np.concatenate([around @ pose[:3, :3].T + pose[:3, 3] for pose in found.poses])
    extent = float(np.ptp(places, axis=0).max())
    fine = min(float(np.linalg.norm(high - low)) * ROOM_SHARE, float((high - low).min()) / 8.0)
    return max(fine, extent / ROOM_STEPS, 1e-6)


def _packed(volume: Mockup) -> Room:
    geometry = HeldGeometry(Tool(volume.vertices, volume.faces, volume.part_names[0]), 0)
    return Room(geometry.manifest(), geometry.data())


def _way(parts: tuple[int, ...], found: Removal, gaps: list[Gap]) -> Way:
    """With the smallest gap that is known: the search's own may be 5 % too large, and leaves out more seats."""
    known = [each["gap"] for each in gaps if each["gap"] is not None]
    least = min([found.clearance, *known]) if math.isfinite(found.clearance) else min(known, default=math.inf)
    return Way(parts, tuple(motion.row(pose) for pose in found.poses), least if math.isfinite(least) else None)


def _way_facts(way: Way, found: Removal, gaps: list[Gap], length: Lengths) -> WayFacts:
    return {
        "parts": list(way.parts),
        "poses": [list(pose) for pose in way.poses],
        "clearance": way.clearance,
        "legs": [leg_words(leg, length) for leg in found.legs],
        "length": found.path_length,
        "rotation": found.rotation,
        "gaps": gaps,
    }


def _gaps(scene: Scene, parts: tuple[int, ...], found: Removal, progress: Progress) -> list[Gap]:
    moving = Tool.of_parts(scene.mockup, list(parts))
    return gaps_along(scene.without(list(parts)), moving, found.poses, progress)


def gaps_along(rest: Scene | World, moving: Tool, way: Floats, progress: Progress) -> list[Gap]:
    """The nearest neighbour at poses spread evenly over a way, without those in contact at the start; and between
    them until no gap can be less than the least by more than `CLEARANCE_ERROR`."""
    poses, shares = spread(way, moving.bounds)
    nearest = Gaps(rest, moving, poses[0])
    found: dict[float, tuple[Floats, Near | None]] = {}
    for number, (pose, share) in enumerate(zip(poses, shares, strict=True)):
        progress(number / len(poses), "measuring gaps")
        found[share] = (pose, nearest.at(pose))
    if len(poses) <= 2 * MOST_GAPS:
        _refine(found, nearest, moving.bounds)
    return [gap_json(share, near) for share, (_, near) in sorted(found.items(), key=lambda item: item[0])]


def _refine(found: dict[float, tuple[Floats, Near | None]], nearest: Gaps, bounds: Floats) -> None:
    """Adds poses in the middle of spans where the gap may be less: it changes by no more than the fastest corner
    moves."""
    corners, middle = motion.corners(bounds), bounds.mean(axis=0)

    def gap(share: float) -> float:
        near = found[share][1]
        return WITHIN_M if near is None else near.gap

    def bounded(one: float, other: float) -> tuple[float, float, float]:
        moved = motion.carried(found[one][0], found[other][0], corners)
        return 0.5 * (gap(one) + gap(other) - moved), one, other

    spans = [bounded(one, other) for one, other in pairwise(sorted(found))]
    heapq.heapify(spans)
    least = min(map(gap, found))
    for _ in range(MOST_REFINED):
        if not spans or spans[0][0] >= least * (1.0 - CLEARANCE_ERROR):
            return
        _, one, other = heapq.heappop(spans)
        share = 0.5 * (one + other)
        if not one < share < other:
            continue
        pose = between(found[one][0], found[other][0], middle, 0.5)
        found[share] = (pose, nearest.at(pose))
        least = min(least, gap(share))
        heapq.heappush(spans, bounded(one, share))
        heapq.heappush(spans, bounded(share, other))


def spread(poses: Floats, bounds: Floats) -> tuple[Floats, list[float]]:
    """Poses of a way at even steps of its fastest corner, and their shares of it: its own poses and some between."""
    corners, middle = motion.corners(bounds), bounds.mean(axis=0)
    steps = [motion.carried(one, other, corners) for one, other in pairwise(poses)]
    total = sum(steps)
    if total == 0.0:
        return poses[:1], [0.0]
    spread, shares, gone = [poses[0]], [0.0], 0.0
    for one, other, step in zip(poses[:-1], poses[1:], steps, strict=True):
        if step == 0.0:
            continue
        pieces = max(1, round(step / total * (MOST_GAPS - 1)))
        for piece in range(1, pieces + 1):
            spread.append(between(one, other, middle, piece / pieces))
            shares.append(min(1.0, (gone + step * piece / pieces) / total))
        gone += step
    every = max(1, -(-len(spread) // (2 * MOST_GAPS)))
    kept = [*range(0, len(spread) - 1, every), len(spread) - 1]
    return np.array([spread[each] for each in kept]), [shares[each] for each in kept]


def _blockers(held_by: Sequence[Part], blocked_by: Sequence[RemovalBlocker]) -> tuple[BlockerFacts, ...]:
    home = list(motion.HOME)
    proofs: list[BlockerFacts] = [
        {"part": part.index, "attempts": 0, "is_proof": True, "pose": home} for part in held_by
    ]
    proven = {part.index for part in held_by}
    stopped: list[BlockerFacts] = [
        {"part": each.part, "attempts": each.count, "is_proof": False, "pose": list(motion.row(each.pose))}
        for each in blocked_by
        if each.part not in proven
    ]
    return tuple([*proofs, *stopped][:MOST_BLOCKERS])


def _blocked(asked: Asked, found: Removal) -> str:
    names, parts = _names(asked.mockup, asked.parts), asked.parts
    if found.held_by:
        held = listed(shown(asked.mockup, (part.index for part in found.held_by)))
        return f"{names} cannot come out while {held} {'stays' if len(found.held_by) == 1 else 'stay'}: this is proven."
    how = f"in {found.seconds:.0f} s" if found.is_out_of_time else "in a complete search"
    stopped = listed(shown(asked.mockup, (each.part for each in found.blocked_by)))
    tail = f"; stopped by {stopped}" if stopped else ""
    return f"No way out was found for {names} {how}{tail}." if parts else f"No way out was found{tail}."


def _way_words(found: Removal, length: Lengths) -> str:
    turned = f", turned by {math.degrees(found.rotation):.0f}°" if found.rotation > math.radians(0.5) else ""
    if not found.legs:
        return "already out"
    legs = "straight" if len(found.legs) == 1 and not turned else plural(len(found.legs), "leg")
    return f"{legs}, {length(found.path_length)}{turned}"


def nearest(mockup: Mockup, way: Way, gaps: list[Gap], length: Lengths) -> str:
    """The tightest place, and of which neighbour it is, if that was seen."""
    known = [each for each in gaps if each["gap"] is not None and each["part"] is not None]
    near = min(known, key=lambda each: each["gap"] or 0.0, default=None)
    if way.clearance is None or near is None or near["part"] is None or near["gap"] is None:
        return ""
    name = listed(shown(mockup, [near["part"]]))
    if near["gap"] <= way.clearance * (1.0 + CLEARANCE_ERROR):
        return f"; nearest about {length(near['gap'])} to {name}"
    return f"; nearest about {length(way.clearance)}"


def part_of(progress: Progress, start: float, end: float) -> Progress:
    """Reports a stage of a task as this share of it."""

    def report(share: float, stage: str) -> None:
        progress(start + (end - start) * share, stage)

    return report


def _volume(mockup: Mockup) -> float:
    """Of a closed mesh, cubic metres."""
    corners = mockup.vertices[mockup.faces] - mockup.bounds.mean(axis=0)
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0


def _litres(litres: float) -> str:
    return f"{litres:.3g} l" if litres >= 0.1 else f"{1e3 * litres:.3g} cm³"


def _names(mockup: Mockup, parts: tuple[int, ...]) -> str:
    more = f" and {len(parts) - 1} more parts" if len(parts) > 2 else ""
    if len(parts) == 2:
        return " and ".join(shown(mockup, parts))
    return f"{shown(mockup, parts[:1])[0]}{more}"


def _verb(parts: tuple[int, ...], verb: str) -> str:
    return verb + "s" if len(parts) == 1 else verb


def shown(mockup: Mockup, parts: Iterable[int]) -> list[str]:
    """The names of parts in a sentence: as files have them, with a "/", too. Of a path as a name, the last step."""
    names, paths = mockup.part_names, mockup.part_paths
    return [names[part] if names[part] != paths[part] else names[part].rpartition("/")[2] for part in parts]


def listed(names: list[str]) -> str:
    """ "a, b and c", or "a, b, c and 5 more"."""
    if len(names) > _NAMED + 1:
        return f"{', '.join(names[:_NAMED])} and {len(names) - _NAMED} more"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else ""


def triple(vector: Any) -> Vec3:
    """Three numbers."""
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    return (x, y, z)
