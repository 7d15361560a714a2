"""The commands of clearances that must hold, for the table in `commands.py`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from feeler.errors import FeelerError
from feeler.requirements import Requirement
from feeler.workbench.document.arguments import Arguments, replaced, without
from feeler.workbench.document.document import Document, KeptClear, Verdict
from feeler.workbench.document.protocol_findings import RequirementResult
from feeler.workbench.document.values import is_sequence

_MOST = 1000


def requirement_add(document: Document, given: Arguments, _known: object) -> Document:
    """Adds a clearance that must hold: parts of pattern `a` at least `gap` metres away from those of `b`."""
    if len(document.requirements) >= _MOST:
        raise given.fail("name", f"there are {_MOST} requirements already", "remove one first")
    made = KeptClear(document.next_id, given.text("name"), given.text("a"), given.text("b"), _gap(given))
    _check(given, made)
    return document.with_id(requirements=(*document.requirements, made))


def requirement_edit(document: Document, given: Arguments, _known: object) -> Document:
    """Changes the requirement `id`; it has to be checked again. `gap`: metres."""
    at = given.place_of(document.requirements)
    old = document.requirements[at]
    name, a, b = (given.text(each) if given.has(each) else getattr(old, each) for each in ("name", "a", "b"))
    made = KeptClear(old.id, name, a, b, _gap(given) if given.has("gap") else old.gap)
    if (a, b, made.gap) == (old.a, old.b, old.gap):
        made = replace(made, verdict=old.verdict)
    _check(given, made)
    return replace(document, requirements=replaced(document.requirements, at, made))


def requirement_remove(document: Document, given: Arguments, _known: object) -> Document:
    """Removes a requirement."""
    place = given.place_of(document.requirements)
    return replace(document, requirements=without(document.requirements, place))


def requirements_checked(document: Document, given: Arguments, _known: object) -> Document:
    """Takes the verdicts of the job "verify"; requirements that are gone are left out."""
    rows: Any = given.raw("results", list[RequirementResult])
    try:
        if not is_sequence(rows):
            raise TypeError("they are not a list")
        found = {int(row["id"]): _verdict(row["verdict"]) for row in rows}
    except KeyError as error:
        raise given.fail("results", f"a verdict has no {error!s:.40}", "send the results of the job verify") from None
    except (TypeError, ValueError, AttributeError, OverflowError, IndexError):
        raise given.fail("results", "they are not verdicts", "send the results of the job verify") from None
    kept = (replace(each, verdict=found.get(each.id, each.verdict)) for each in document.requirements)
    return replace(document, requirements=tuple(kept))


def requirements_of(kept: Iterable[KeptClear]) -> tuple[Requirement, ...]:
    """As `feeler.verify` takes them: each with a name of its own. Raises `OptionError` for those of a stranger."""
    found: dict[str, Requirement] = {}
    for each in kept:
        name, number = each.name, 2
        while name in found:
            name, number = f"{each.name} {number}", number + 1
        found[name] = Requirement(name, (each.a,), (each.b,), each.gap)
    return tuple(found.values())


def _gap(given: Arguments) -> float:
    return given.number("gap", 0.0, 1e3)


def _check(given: Arguments, made: KeptClear) -> None:
    try:
        requirements_of([made])
    except FeelerError as error:
        raise given.fail("a", str(error), "change the patterns") from None


def _verdict(row: Any) -> Verdict:
    status = row["status"]
    if status not in ("holds", "violated", "unknown"):
        raise ValueError(f"status is {status!r:.20}")
    numbers = [None if row[name] is None else float(row[name]) for name in ("gap", "depth")]
    if any(each is not None and not abs(each) < 1e9 for each in numbers):
        raise ValueError("a length is none")
    points = tuple((float(x), float(y), float(z)) for x, y, z in row["points"])
    places = {int(part): tuple(float(each) for each in place) for part, place in row["moved"].items()}
    return Verdict(
        status,
        int(row["pairs"]),
        numbers[0],
        numbers[1],
        tuple(int(each) for each in row["parts"]),
        points,
        None if row["trouble"] is None else str(row["trouble"]),
        MappingProxyType(places),
        tuple(int(each) for each in row["out"]),
        tuple(int(each) for each in row["gripped"]),
    )
