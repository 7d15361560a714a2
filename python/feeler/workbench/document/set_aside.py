"""Removals, measures and cards by the numbers of parts of another revision; those whose parts are gone are set aside.

The file keeps what is set aside, with the names of its parts, and a revision that has all of them brings it back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from feeler.workbench.document.document import Card, Measure, Removal, Since

Renumber = Callable[[int], int | None]
"""The number of a part now; None if it is gone."""

Thing = Removal | Measure | Card


@dataclass(frozen=True)
class Aside:
    """A thing whose parts are gone. kind: the field of the document. parts: all that it names, by the numbers then."""

    kind: str
    thing: Thing
    parts: tuple[int, ...]


def kept_things(
    values: Mapping[str, Any], renumber: Renumber
) -> tuple[dict[str, tuple[Thing, ...]], tuple[Aside, ...]]:
    """The removals, measures and cards with the numbers of parts now, and those whose parts are gone."""
    found: dict[str, tuple[Thing, ...]] = {}
    aside: list[Aside] = []
    for kind, now_of in _NOW.items():
        there = []
        for thing in values.get(kind, ()):
            now = now_of(thing, renumber)
            if _is_kept(thing, now):
                there.append(now)
            else:
                aside.append(Aside(kind, thing, _parts_in(kind, thing)))
        found[kind] = tuple(there)
    return found, tuple(aside)


def brought_back(kind: str, thing: Thing, keys: Mapping[int, str], number: Mapping[str, int]) -> Thing | None:
    """A thing that was set aside, with the numbers of parts now; None while a part that it is about is not there.

    keys: of the parts that it names, by their numbers then. number: of a part now, by its key.
    """
    now: Thing = _NOW[kind](thing, lambda part: number.get(keys.get(part, "")))
    return now if len(now.parts) == len(thing.parts) else None


KINDS: Mapping[str, type] = MappingProxyType({"sequence": Removal, "measures": Measure, "cards": Card})
"""What can be set aside, by its field of the document."""


def stale_now(stale: Mapping[int, Since], renumber: Renumber) -> Mapping[int, Since]:
    """The parts that differ, by their numbers now."""
    return MappingProxyType({now: since for part, since in stale.items() if (now := renumber(part)) is not None})


def numbers(parts: Iterable[int], renumber: Renumber) -> tuple[int, ...]:
    """The parts that are there, by their numbers now, in the order given."""
    return tuple(now for part in parts if (now := renumber(part)) is not None)


def _is_kept(thing: Thing, now: Thing) -> bool:
    if isinstance(thing, Measure):
        return len(now.parts) == len(thing.parts)
    return bool(now.parts) or (isinstance(thing, Card) and not thing.parts)


def _line(line: Removal, renumber: Renumber) -> Removal:
    return replace(
        line,
        parts=numbers(line.parts, renumber),
        out=numbers(line.out, renumber),
        starts=tuple((now, row) for part, row in line.starts if (now := renumber(part)) is not None),
        stale=stale_now(line.stale, renumber),
    )


def _measure(measure: Measure, renumber: Renumber) -> Measure:
    return replace(measure, parts=numbers(measure.parts, renumber), stale=stale_now(measure.stale, renumber))


def _card(card: Card, renumber: Renumber) -> Card:
    moved, held = card.world
    return replace(
        card,
        parts=numbers(card.parts, renumber),
        without=numbers(card.without, renumber),
        world=(
            tuple((now, row) for part, row in moved if (now := renumber(part)) is not None),
            numbers(held, renumber),
        ),
    )


_NOW: Mapping[str, Callable[[Any, Renumber], Any]] = {"sequence": _line, "measures": _measure, "cards": _card}


def _parts_in(kind: str, thing: Thing) -> tuple[int, ...]:
    named: dict[int, None] = {}

    def note(part: int) -> int:
        named[part] = None
        return part

    _NOW[kind](thing, note)
    return tuple(named)
