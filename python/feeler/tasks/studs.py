"""Studs that are wanted: they are turned out of their parts, as no other studs are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from feeler.plan.fasteners import Fastener, Fasteners, turned_round
from feeler.scene import Scene
from feeler.tasks.held_rows import Hold, Holds
from feeler.tasks.passing import passed_by

TURNED = "screw"
"""The kind of a stud that is turned out."""


def with_wanted_studs(scene: Scene, rows: Fasteners, held: Holds, wanted: Iterable[int]) -> tuple[Fasteners, Holds]:
    """The same, with wanted studs as screws that hold themselves; nuts on them are undone from them.

    Only if all that is wanted are fasteners: of a pump that is wanted with its studs, these stay in the housing.
    """
    own = set(wanted)
    washers = {part for row in held for part in row.washers}
    if not all(held.of(part) is not None or part in washers for part in own):
        return rows, held
    turned = {row.fastener: row.anchor for row in held if row.fastener in own and row.kind == "stud"}
    turned = {part: anchor for part, anchor in turned.items() if anchor is not None and anchor not in own}
    if not turned:
        return rows, held
    mask = scene.part_mask.copy()
    mask[[row.part for row in rows if row.part < len(mask)]] = False
    bare = scene.only(mask)
    outward = [_outward(bare, row, turned[row.part]) if row.part in turned else row for row in rows]
    return Fasteners(outward), Holds(
        _turned(row) if row.fastener in turned else _without_mates(row, set(turned)) for row in held
    )


def _outward(bare: Scene, stud: Fastener, anchor: int | None) -> Fastener:
    """A stud whose axis points out of the part that it is fastened in."""
    (passed,) = passed_by(bare, [stud])
    middle = [0.5 * (each.top + each.bottom) for each in passed if each.part == anchor]
    if not middle or min(middle) <= -0.5 * stud.length:
        return stud
    return turned_round(stud, stud.length)


def _turned(row: Hold) -> Hold:
    because = row.because.split(";")[0]
    return replace(row, kind=TURNED, parts=(row.fastener,), paths=(row.path,), mates=(), because=because)


def _without_mates(row: Hold, turned: set[int]) -> Hold:
    return replace(row, mates=tuple(each for each in row.mates if each not in turned))
