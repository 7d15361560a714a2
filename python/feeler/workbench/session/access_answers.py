"""The answer to which tools reach fasteners: tools by name, or those of the catalogue."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import cast

import numpy as np

from feeler.choices import GripAxis
from feeler.mockup import Tool
from feeler.plan.catalogue import Catalogue, shaped, tool_of
from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners
from feeler.plan.reaching import Reach, access
from feeler.progress import Progress
from feeler.tasks.holding import holds
from feeler.words import plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import ReachFacts
from feeler.workbench.document.protocol import Vec3
from feeler.workbench.session.answering import MOST_BLOCKERS, Answered, Asked, listed, part_of, triple
from feeler.workbench.session.task_answers import catalogue_of

MOST_REACHES = 5000
MOST_TOOLS = 12
"""Tools of the catalogue that are counted by name."""
_WRENCH_HALF_M = 0.0046  # half the built-in wrench's thickness, and a tenth of a millimetre above the bearing face
_FAN_STEP_DEG = 5.0


def reach(asked: Asked, progress: Progress) -> Answered:
    """Which tools reach fasteners. Of the catalogue the first that fits by drive and size and reaches; of tools by name
    the one that swings farthest."""
    bolts = _meant(asked, part_of(progress, 0.0, 0.2))
    if not len(bolts):
        return Answered("None of these parts looks like a fastener, and no fastener was found that holds them.", None)
    if asked.options.get("catalogue"):
        return _chosen(asked, bolts, part_of(progress, 0.2, 1.0))
    assert asked.tools, "a question of access has a tool"
    found: dict[str, list[Reach]] = {}
    for number, name in enumerate(asked.tools):
        start, end = (0.2 + 0.8 * each / len(asked.tools) for each in (number, number + 1))
        found[name] = _reaches(asked, name, bolts, part_of(progress, start, end))
    reaching = [[name for name, rows in found.items() if rows[k].is_reachable] for k in range(len(bolts))]
    best = [max(names or found, key=lambda name: found[name][k].swing_deg) for k, names in enumerate(reaching)]
    order = sorted(range(len(bolts)), key=lambda k: (bool(reaching[k]), bolts[k].path))
    facts = tuple(_reach_facts(asked, best[k], reaching[k], found[best[k]][k], bolts[k]) for k in order[:MOST_REACHES])
    good = {name: sum(row.is_reachable for row in rows) for name, rows in found.items()}
    more = [(f"{name} reaches", f"{count:,} of {len(bolts):,}") for name, count in good.items() if len(good) > 1]
    if len(order) > len(facts):
        more.append(("not listed", plural(len(order) - len(facts), "fastener")))
    reached = sum(map(bool, reaching))
    return Answered(
        _reach_words(good, reached, found, len(bolts)), reached == len(bolts), reaches=facts, facts=tuple(more)
    )


def _meant(asked: Asked, progress: Progress) -> Fasteners:
    """The fasteners among the chosen parts, or else those that hold them; all if none are chosen."""
    chosen = set(asked.parts)
    found = find_fasteners(asked.scene, sorted(chosen) or None, part_of(progress, 0.0, 0.4))
    if len(found) or not chosen:
        return found
    every = find_fasteners(asked.scene, None, part_of(progress, 0.4, 0.8))
    held = holds(asked.scene, every, progress=part_of(progress, 0.8, 1.0))
    holding = {each.fastener for each in held if chosen & set(each.parts)}
    return Fasteners([row for row in every if row.part in holding])


def _reaches(asked: Asked, name: str, bolts: Fasteners, progress: Progress) -> list[Reach]:
    """Whether one tool reaches them. The built-in wrench lies flat, its jaw about the head."""
    is_wrench = name == "wrench" and name in asked.built_in
    grip = asked.options.get("grip") or ("y" if is_wrench else None)
    heads = [bolt.head_height if math.isfinite(bolt.head_height) else 0.0 for bolt in bolts]
    found = access(
        asked.scene,
        asked.tools[name],
        bolts,
        asked.number("swing_deg", 60.0),
        grip=cast("GripAxis | None", grip),
        lift=[_WRENCH_HALF_M - height if height > 0.0 else 0.0 for height in heads] if is_wrench else 0.0,
        threads=asked.threads,
        progress=progress,
    )
    return list(found)


def _reach_words(good: Mapping[str, int], reached: int, found: Mapping[str, list[Reach]], bolts: int) -> str:
    fasteners = plural(bolts, "fastener")
    if len(good) == 1:
        (tool,) = good
        if reached == bolts:
            return f"The {tool} reaches all {fasteners}." if bolts > 1 else f"The {tool} reaches it."
        if bolts == 1:
            return f"The {tool} does not reach it: {found[tool][0].because}."
        return f"The {tool} reaches {f'{reached:,}' if reached else 'none'} of {fasteners}."
    if not reached:
        return f"None of {len(good)} tools reaches {'it' if bolts == 1 else f'any of {fasteners}'}."
    which = [name for name, count in good.items() if count]
    if bolts == 1:
        return f"The {listed(which)} {'reaches' if len(which) == 1 else 'reach'} it."
    most = max(good, key=lambda name: good[name])
    if good[most] == bolts:
        return f"The {most} reaches all {fasteners}."
    count = f"{reached:,}" if reached < bolts else "All"
    by = f"by the {listed(which)}" if reached == 1 else f"{good[most]:,} of them by the {most}"
    return f"{count} of {fasteners} {'is' if reached == 1 else 'are'} reached, {by}."


def _chosen(asked: Asked, bolts: Fasteners, progress: Progress) -> Answered:
    """Of each fastener the first tool that reaches it: of those by name, else of the catalogue."""
    own = 0.4 if asked.tools else 0.0
    rows: dict[int, ReachFacts] = {}
    for number, name in enumerate(asked.tools):
        left = [k for k in range(len(bolts)) if k not in rows]
        if left:
            share = own / len(asked.tools)
            heard = part_of(progress, number * share, (number + 1) * share)
            found = _reaches(asked, name, Fasteners([bolts[k] for k in left]), heard)
            for k, row in zip(left, found, strict=True):
                if row.is_reachable:
                    rows[k] = _reach_facts(asked, name, [name], row, bolts[k])
    left = [k for k in range(len(bolts)) if k not in rows]
    if left:
        some = Fasteners([bolts[k] for k in left])
        rows.update(zip(left, _of_catalogue(asked, some, part_of(progress, own, 1.0)), strict=True))
    order = sorted(rows, key=lambda k: (rows[k]["is_reachable"], rows[k]["has_hand"] is not False, bolts[k].path))
    good = Counter(row["tool"] for row in rows.values() if row["is_reachable"])
    counted = [(name, plural(count, "fastener")) for name, count in good.most_common(MOST_TOOLS)]
    if len(good) > MOST_TOOLS:
        counted.append(("other tools", f"{len(good) - MOST_TOOLS:,}"))
    if bare := sum(not bolt.drive for bolt in bolts):
        counted.append(("without a drive that shows", plural(bare, "fastener")))
    if len(order) > MOST_REACHES:
        counted.append(("not listed", plural(len(order) - MOST_REACHES, "fastener")))
    tight = sum(row["has_hand"] is False for row in rows.values())
    return Answered(
        _chosen_words([rows[k] for k in order], sum(good.values()), tight),
        sum(good.values()) == len(bolts) and not tight,
        reaches=tuple(rows[k] for k in order[:MOST_REACHES]),
        facts=tuple(counted) if len(bolts) > 1 else (),
    )


def _of_catalogue(asked: Asked, bolts: Fasteners, progress: Progress) -> list[ReachFacts]:
    """The tools of the catalogue that reach them with a hand at the grip; where none does, without."""
    tools = catalogue_of(asked.catalogue)
    hand, swing = tools.hand, asked.options.get("swing_deg")
    gap = asked.number("clearance", 0.0)

    def asked_of(some: Fasteners, held: Tool | None, heard: Progress) -> list[Reach]:
        return list(
            access(asked.scene, tools, some, swing, hand=held, clearance=gap, threads=asked.threads, progress=heard)
        )

    found = asked_of(bolts, hand, part_of(progress, 0.0, 0.6))
    rows = [(row, True if row.is_reachable and hand is not None else None) for row in found]
    left = [k for k, row in enumerate(found) if not row.is_reachable and row.nearest is not None]
    if left and hand is not None:
        again = asked_of(Fasteners([bolts[k] for k in left]), None, part_of(progress, 0.6, 1.0))
        rows = [*rows]
        for k, row in zip(left, again, strict=True):
            rows[k] = (row, False if row.is_reachable else None)
    return [
        _catalogue_facts(asked, tools, row, has_hand, bolt) for (row, has_hand), bolt in zip(rows, bolts, strict=True)
    ]


def _catalogue_facts(asked: Asked, tools: Catalogue, row: Reach, has_hand: bool | None, bolt: Fastener) -> ReachFacts:
    name = row.tool or row.nearest or ""
    fan = _fan(tools.tool(name), row, bolt) if name else []
    facts = _facts(asked, name, [name] if row.is_reachable else [], row, bolt, fan, has_hand)
    return {**facts, "is_catalogue": True}


def _chosen_words(rows: list[ReachFacts], reached: int, tight: int) -> str:
    """rows: those that are not reached first."""
    count, first = len(rows), rows[0]
    if count == 1:
        if not reached:
            return f"No tool reaches it: {first['because']}."
        return f"The {first['tool']} reaches it{'; a hand does not fit at its grip' if tight else ''}."
    fasteners = plural(count, "fastener")
    if not reached:
        return f"No tool reaches any of {fasteners}."
    said = f"Tools reach {'all' if reached == count else f'{reached:,} of'} {fasteners}"
    return f"{said}; at {tight:,} of them no hand fits at the grip." if tight else f"{said}."


def _head(bolt: Fastener) -> str:
    """What a tool has to fit, in words; empty if the mesh does not show it."""
    width = bolt.across_flats if bolt.across_flats > 0.0 else bolt.width
    return f"{bolt.drive} {1e3 * width:.3g} mm" if bolt.drive and width > 0.0 else bolt.drive


def _reach_facts(asked: Asked, tool: str, tools: list[str], row: Reach, bolt: Fastener) -> ReachFacts:
    return _facts(asked, tool, tools, row, bolt, _fan(asked.tools[tool], row, bolt))


def _facts(
    asked: Asked, tool: str, tools: list[str], row: Reach, bolt: Fastener, fan: list[Vec3], has_hand: bool | None = None
) -> ReachFacts:
    return {
        "part": row.part,
        "name": asked.mockup.part_names[bolt.part],
        "kind": bolt.kind,
        "tool": tool,
        "tools": tools,
        "is_catalogue": False,
        "head": _head(bolt),
        "strokes": row.strokes,
        "has_hand": has_hand,
        "is_reachable": row.is_reachable,
        "swing_deg": row.swing_deg,
        "because": row.because,
        "pose": list(motion.row(row.pose)),
        "way": [list(motion.row(pose)) for pose in row.way],
        "point": triple(bolt.frame[:3, 3]),
        "axis": triple(bolt.axis),
        "fan": fan,
        "blockers": [each.part for each in row.blockers[:MOST_BLOCKERS]],
    }


def _fan(tool: Tool, row: Reach, bolt: Fastener) -> list[Vec3]:
    """The path of the tool's far end over the free swing, about the fastener's axis."""
    if not row.swing_deg > 0.0:
        return []
    around = motion.corners(tool.bounds) @ row.pose[:3, :3].T + row.pose[:3, 3]
    origin, axis = bolt.frame[:3, 3], bolt.axis
    arms = around - origin
    flat = arms - np.outer(arms @ axis, axis)
    far = arms[int(np.argmax(np.linalg.norm(flat, axis=1)))]
    count = max(2, math.ceil(row.swing_deg / _FAN_STEP_DEG) + 1)
    turns = np.radians(np.linspace(-row.swing_deg / 2.0, row.swing_deg / 2.0, count))
    along = axis * (far @ axis)
    across = far - along
    side = np.cross(axis, across)
    return [triple(origin + along + math.cos(turn) * across + math.sin(turn) * side) for turn in turns]


def tool_in_hand(toml: str, name: str, has_hand: bool) -> Tool:
    """A tool of a catalogue in the frame of its seat, with its hand at the grip. Raises `OptionError` for a name that
    is not in it."""
    tools = catalogue_of(toml)
    pieces, hand = tools.pieces(name), tools.hand
    if not has_hand or hand is None:
        return tool_of(pieces)
    return Tool.assembly({"tool": tool_of(pieces), "hand": (hand, shaped(pieces).grip)}, name)
