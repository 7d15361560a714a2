"""The document in a project: its fields as rows, and back.

Each field is JSON by its type, so that new fields are kept without code of their own; lists of things with an id have a
row for each. What belongs to one run of the program, such as the progress of loading, is not kept. Files of strangers
come here, too: everything read is checked.
"""

from __future__ import annotations

import itertools
import time
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np

from feeler.clashes.limits import unmatched
from feeler.clashes.rules import Rule, Rules
from feeler.clashes.tracking import NEW, Mark, mark_json, mark_of_json
from feeler.errors import FeelerError, LoadError
from feeler.parts import Parts
from feeler.project.book import CHECK, PAIR, Book, dumps, pair_of, resolved_of, row_id
from feeler.project.layout import TABLES
from feeler.project.parts import PartContent
from feeler.project.renaming import Names
from feeler.project.store import Change, Row, drop, put
from feeler.workbench.document import motion
from feeler.workbench.document.document import (
    MATERIALS,
    MODES,
    UNITS,
    Card,
    Check,
    Document,
    Findings,
    Isolation,
    KeptClear,
    TaskEdits,
    Trip,
    Verdict,
)
from feeler.workbench.document.finding_rules import renamed_rules
from feeler.workbench.document.finding_table import FindingTable, table_of
from feeler.workbench.document.gone import Left, gone_now, left_of, with_gone
from feeler.workbench.document.set_aside import KINDS, Aside, Renumber, brought_back, kept_things, numbers, stale_now
from feeler.workbench.document.values import is_number

NOT_KEPT = frozenset(
    ("mockup", "loading", "failed", "tools", "record", "absent", "project", "guiding", "joint_ranges"),
)
"""Fields of one run of the program."""

_RENAMED = {"viewpoints": "views"}
_FINDINGS, _TABLE, _RESOLVED, _CARDS = "findings", "table", "resolved", "cards"
_GROUP = "members"  # of a mark: the number of a group that was made by hand
_OPEN = ("waiting", "running")
_INTERRUPTED = "Interrupted: ask again."
_SLICE = 16
_MOST_TEXT = 100_000


class Kept(NamedTuple):
    """A document from a project.

    aside: what belonged to parts that are gone. back: ids of rows of the table `aside` whose parts are there again.
    """

    document: Document
    aside: tuple[Aside, ...]
    back: tuple[str, ...] = ()


@cache
def kept_fields() -> Mapping[str, Any]:
    """The fields that a project keeps, with their types."""
    hints = get_type_hints(Document)
    return {each.name: hints[each.name] for each in fields(Document) if each.name not in NOT_KEPT}


@cache
def lists() -> Mapping[str, str]:
    """The fields with a row for each of their things, and the tables of these."""
    found = {}
    for name, kind in kept_fields().items():
        arguments = get_args(kind)
        table = _RENAMED.get(name, name)
        is_list = get_origin(kind) is tuple and len(arguments) == 2 and arguments[1] is ...
        if is_list and is_dataclass(arguments[0]) and table in TABLES and "id" in _hints(arguments[0]):
            found[name] = table
    return found


def is_same(before: Document, after: Document) -> bool:
    """Whether a project keeps the same of both; no is certain, yes may be a coincidence of equal values."""
    return all(
        getattr(before, name) is getattr(after, name) or (name == _CARDS and _cards(before) == _cards(after))
        for name in kept_fields()
    )


def _cards(document: Document) -> tuple[Card, ...]:
    """The cards, without the progress of questions that are not answered: nobody would answer those again."""
    return tuple(
        replace(card, state="cancelled", share=0.0, stage="", sentence=_INTERRUPTED) if card.state in _OPEN else card
        for card in document.cards
    )


# ---- writing ----


def changes(before: Document | None, after: Document) -> Iterator[Change]:
    """The rows that differ; all, if there was no document before. Without those of findings, which have a history."""
    for name in kept_fields():
        now = getattr(after, name)
        if before is not None and now is getattr(before, name):
            continue
        if name == _FINDINGS:
            rest = None if now is None else {key: value for key, value in _fields_of(now) if not _is_by_id(now, key)}
            if rest is not None:
                del rest[_RESOLVED]  # see `check_changes`
                rest[_TABLE] = now.table.facts_json()
            yield put("document", name, 0, encoded(rest))
        elif name == _CARDS:
            yield from _list_changes(_CARDS, () if before is None else _cards(before), _cards(after))
        elif name in lists():
            yield from _list_changes(lists()[name], () if before is None else getattr(before, name), now)
        else:
            yield put("document", name, 0, encoded(now))


def rows_to_drop(rows: Callable[[str], list[Row]], document: Document) -> Iterator[Change]:
    """The rows of a file whose things the document does not have. rows: of a table."""
    for name, table in lists().items():
        there = {row_id(str(each.id)) for each in getattr(document, name)}
        yield from (drop(table, row.id) for row in rows(table) if row.id not in there)


def _list_changes(table: str, before: Sequence[Any], now: Sequence[Any]) -> Iterator[Change]:
    known = {each.id: (place, each) for place, each in enumerate(before)}
    for place, each in enumerate(now):
        there = known.pop(each.id, None)
        if there is None or there[0] != place or (there[1] is not each and there[1] != each):
            yield put(table, row_id(str(each.id)), place, encoded(each))
    for key in known:
        yield drop(table, row_id(str(key)))


def finding_rows(found: Findings | None) -> list[Mapping[str, Any]]:
    """All findings, in display order."""
    return [] if found is None else [found.table.whole_row_json(row) for row in range(len(found.table))]


def finding_marks(found: Findings | None) -> dict[str, dict[str, Any]]:
    """What people said of findings, by id: all of it, so that nothing is merged with what a file has."""
    if found is None:
        return {}
    table = found.table
    names = dict.fromkeys(table.ids[row] for row in np.flatnonzero(table.status).tolist())
    for by_id in (table.marks, found.status, found.notes, found.members, found.aside):
        names.update(dict.fromkeys(by_id))
    return {name: mark for name in names if (mark := finding_mark(found, name)) is not None}


def finding_mark(found: Findings, name: str) -> dict[str, Any] | None:
    """What people said of a finding: a row of the table `marks`, without the id. None if they said nothing."""
    mark, group = mark_json(found.mark_of(name)), found.members.get(name)
    if name in found.aside and (pair := found.aside[name].pair) is not None:
        mark[PAIR] = list(pair)
    if group is not None:
        return {**mark, _GROUP: group}
    return None if mark == mark_json(NEW) else mark


def check_changes(book: Book, found: Findings | None, *, is_same_check: bool) -> Iterator[Change]:
    """The rows of findings that are gone, where a check of the command line has them. is_same_check: as the file's."""
    if found is None:
        return book.check_changes({}, (), is_same_check=False)
    return book.check_changes(found.table.facts_json(), found.resolved, is_same_check=is_same_check)


def marks_that_differ(old: Findings, new: Findings) -> dict[str, dict[str, Any] | None]:
    """The marks that changed between findings of one table; None: nothing is said any more."""
    names: dict[str, None] = {}
    for name, by_id in _fields_of(new):
        if _is_by_id(new, name):
            before: Mapping[str, Any] = getattr(old, name)
            names.update(dict.fromkeys(key for key in {**before, **by_id} if before.get(key) != by_id.get(key)))
    return {name: finding_mark(new, name) for name in names}


def _is_by_id(found: object, name: str) -> bool:
    kind = _hints(type(found))[name]
    return get_origin(kind) is Mapping and get_args(kind)[0] is str and name != "gone"  # which is by the key of a part


def encoded(value: Any) -> str:
    """A value as JSON. Long lists in slices: the interpreter's lock is free in between, for the hand."""
    if isinstance(value, tuple) and len(value) > _SLICE:
        texts = []
        for begin in range(0, len(value), _SLICE):
            texts.append(dumps(_plain(value[begin : begin + _SLICE]))[1:-1])
            time.sleep(0)
        return f"[{','.join(texts)}]"
    if is_dataclass(value) and not isinstance(value, type):
        return "{" + ",".join(f"{dumps(name)}:{encoded(inner)}" for name, inner in _fields_of(value)) + "}"
    return dumps(_plain(value))


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, (str, int, float)):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, frozenset):
        return [_plain(item) for item in sorted(value)]
    return {name: _plain(item) for name, item in _fields_of(value)}


def _fields_of(value: Any) -> list[tuple[str, Any]]:
    return [(each.name, getattr(value, each.name)) for each in fields(value)]


# ---- reading ----


def restored(
    base: Document,
    rows: Callable[[str], list[Row]],
    marks: Mapping[str, Mapping[str, Any]],
    loads: Callable[[str, str], Any],
    parts: Parts,
    renumber: Renumber | None = None,
    names: Names | None = None,
    keys: Sequence[str] = (),
    known: Sequence[PartContent] = (),
) -> Kept:
    """The document of a project, on the fields of `base` that a project does not keep. Raises `LoadError`.

    rows: of a table. marks: of findings. loads: a value of a row, and its place for errors. renumber: for a mock-up
    with other parts than the project's. names: how those are called now, in requirements, rules and edits. keys: of
    the present parts, for results that were set aside and come back. known: the project's parts, for
    what results know of those that are gone.
    """
    values: dict[str, Any] = {}
    texts = {row.id: row.value for row in rows("document")}
    for name, kind in kept_fields().items():
        where = f"{name} of the document"
        if name in lists():
            (item, _) = get_args(kind)
            values[name] = tuple(_decoded(loads(row.value, where), item, where) for row in rows(lists()[name]))
        elif name in texts and name != _FINDINGS:
            values[name] = _decoded(loads(texts[name], where), kind, where)
    values = {name: value for name, value in values.items() if value is not MISSING}
    aside: tuple[Aside, ...] = ()
    back: tuple[str, ...] = ()
    left = {} if renumber is None else left_of(known, renumber)
    if renumber is not None:
        values, aside = _renumbered(with_gone(values, left), renumber)
        values, back = _with_back(values, rows("aside"), loads, {key: number for number, key in enumerate(keys)})
    if names is not None:
        values = _renamed(values, names, parts)
    if renumber is not None and "requirements" in values:
        paths = [part.path for part in parts]
        values["requirements"] = tuple(_with_its_parts(each, parts, paths) for each in values["requirements"])
    values = _without(values, frozenset(base.absent))
    rest, there = loads(texts.get(_FINDINGS, "null"), _FINDINGS), rows(_FINDINGS)
    head = loads(next((row.value for row in rows("facts") if row.id == CHECK), "null"), _FINDINGS)
    resolved = tuple(resolved_of(head))
    if rest is not None or there or resolved:  # a clash check of the command line writes rows alone
        found = [loads(row.value, _FINDINGS) for row in there]
        made = _findings({_TABLE: head} if rest is None else rest, found, marks, base, parts, renumber, left)
        values[_FINDINGS] = replace(made, resolved=resolved)
    document = replace(base, **values)
    _check(document, len(parts))
    return Kept(document, aside, back)


def _findings(
    rest: Any,
    rows: list[Any],
    marks: Mapping[str, Mapping[str, Any]],
    base: Document,
    parts: Parts,
    renumber: Renumber | None,
    left: Left,
) -> Findings:
    facts = rest.get(_TABLE) if isinstance(rest, dict) else None
    table = table_of({**(facts if isinstance(facts, dict) else {}), "clashes": rows}, parts, base.absent, _FINDINGS)
    made = Findings(table)
    values: dict[str, Any] = _marked(table, marks)
    for name, kind in _hints(Findings).items():
        if name not in (_TABLE, _RESOLVED) and name not in values and isinstance(rest, dict) and name in rest:
            values[name] = _decoded(rest[name], kind, f"{name} of the findings")
    check = values.get("check")
    if renumber is not None and check is not None:
        of = None if check.of is None else numbers(check.of, renumber)
        values["check"] = replace(check, of=of, **_places(check, renumber))
    found = replace(made, **values)
    if renumber is None:
        return found
    return replace(found, stale=stale_now(found.stale, renumber), gone=gone_now(found, left))


def _marked(table: FindingTable, marks: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The fields of the findings that marks give. A finding without a mark is new, whatever its row says."""
    try:
        said = {name: mark_of_json(mark) for name, mark in marks.items()}
    except ValueError as error:
        raise LoadError(f"{error}: the project is damaged; use a copy") from None
    rows = {name: said.get(name, NEW) for name in table.ids if name in said or table.status_of(name) != "new"}
    rows |= {name: said.get(name, NEW) for name in table.marks}
    members = {
        name: _decoded(mark[_GROUP], int, "a group of a finding") for name, mark in marks.items() if _GROUP in mark
    }

    def with_pair(name: str, mark: Mark) -> Mark:
        return replace(mark, pair=pair_of(marks[name]))

    bare = Findings(table)
    found: dict[str, dict[str, Any]] = {
        "authors": {each: mark.by for each, mark in rows.items() if mark.by != bare.mark_of(each).by},
        "status": {each: mark.status for each, mark in rows.items() if mark.status != table.status_of(each)},
        "notes": {each: mark.note for each, mark in rows.items() if mark.note != table.note_of(each)},
        "members": members,
        "aside": {each: with_pair(each, mark) for each, mark in said.items() if each not in table.row_of},
    }
    return {name: MappingProxyType(by_id) for name, by_id in found.items()}


def _hints(kind: Any) -> dict[str, Any]:
    if kind not in _known_hints:
        _known_hints[kind] = get_type_hints(kind)
    return _known_hints[kind]


_known_hints: dict[Any, dict[str, Any]] = {}


def _decoded(value: Any, kind: Any, where: str) -> Any:
    """A JSON value as its type has it. Raises `LoadError`."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return value
    if origin in (Union, types.UnionType):
        if value is None and type(None) in arguments:
            return None
        (kind,) = (each for each in arguments if each is not type(None))
        return _decoded(value, kind, where)
    if origin is tuple and isinstance(value, list):
        if len(arguments) == 2 and arguments[1] is ...:
            return tuple(_decoded(each, arguments[0], where) for each in value)
        if len(arguments) == len(value):
            return tuple(_decoded(each, inner, where) for each, inner in zip(value, arguments, strict=True))
    if origin is frozenset and isinstance(value, list):
        return frozenset(_decoded(each, arguments[0], where) for each in value)
    if origin is Mapping and isinstance(value, dict):
        by_key = ((_key(key, arguments[0], where), each) for key, each in value.items())
        return MappingProxyType({key: _decoded(each, arguments[1], where) for key, each in by_key})
    if isinstance(kind, type) and is_dataclass(kind) and isinstance(value, dict):
        hints = _hints(kind)
        given = {name: _decoded(value[name], hints[name], where) for name in hints if name in value}
        try:
            return kind(**given)
        except TypeError:
            raise _damaged(where, "a value is missing") from None
    if kind is float and is_number(value):
        return value
    if kind in (str, int, bool) and type(value) is kind and (kind is not str or len(value) <= _MOST_TEXT):
        return value
    raise _damaged(where, f"{value!r:.60}")


def _key(key: str, kind: Any, where: str) -> Any:
    if kind is str:
        return key
    if kind is int and key.isascii() and key.isdigit() and len(key) < 12:
        return int(key)
    raise _damaged(where, f"{key!r:.60}")


def _damaged(where: str, what: str) -> LoadError:
    return LoadError(f"{where} cannot be what was written ({what}): the project is damaged; use a copy")


# ---- another revision of the mock-up ----


def _places(checked: Check | Verdict, renumber: Renumber) -> dict[str, Any]:
    """Where parts lay at a check, by their numbers now."""
    moved = {now: place for part, place in checked.moved.items() if (now := renumber(part)) is not None}
    return {
        "moved": MappingProxyType(dict(sorted(moved.items()))),
        "out": tuple(sorted(numbers(checked.out, renumber))),
        "gripped": numbers(checked.gripped, renumber),
    }


def _requirement(each: KeptClear, renumber: Renumber) -> KeptClear:
    """With the numbers of parts now; as if it was not checked if a part of its verdict is gone."""
    verdict = each.verdict
    if verdict is None:
        return each
    parts = numbers(verdict.parts, renumber)
    if len(parts) < len(verdict.parts):
        return replace(each, verdict=None)
    stale = stale_now(verdict.stale, renumber)
    return replace(each, verdict=replace(verdict, parts=parts, stale=stale, **_places(verdict, renumber)))


def _with_its_parts(each: KeptClear, parts: Parts, paths: Sequence[str]) -> KeptClear:
    """Unknown if one of its patterns names no part any more: nothing holds of parts that are not there."""
    if each.verdict is None:
        return each
    asked = Rules((Rule(each.name, each.a, each.b),), where=f"requirement {each.name!r}")
    lost = unmatched(asked, parts, paths)
    if not lost:
        return each
    pattern = lost[0].partition(" of rule ")[0]
    return replace(each, verdict=Verdict("unknown", trouble=f"{pattern} names no part of this revision"))


def _renamed(values: dict[str, Any], names: Names, parts: Parts) -> dict[str, Any]:
    """The values with the paths and patterns of now."""

    def edits(given: TaskEdits) -> TaskEdits:
        return replace(
            given,
            off=tuple(map(names.key, given.off)),
            times=tuple((names.key(path), seconds) for path, seconds in given.times),
            before=tuple((names.key(first), names.key(then)) for first, then in given.before),
        )

    def pattern(given: str) -> str:
        return names.pattern(given, parts)

    found = dict(values)
    if "requirements" in values:
        asked = (replace(each, a=pattern(each.a), b=pattern(each.b)) for each in values["requirements"])
        found["requirements"] = tuple(asked)
    if "sequence" in values:
        lines = (replace(line, touched=tuple(map(names.key, line.touched))) for line in values["sequence"])
        found["sequence"] = tuple(lines)
    if "clash" in values:
        found["clash"] = replace(values["clash"], rules=renamed_rules(values["clash"].rules, pattern))
    if _CARDS in values:
        found[_CARDS] = tuple(replace(card, edits=edits(card.edits)) for card in values[_CARDS])
    if "task_edits" in values:
        found["task_edits"] = MappingProxyType({card: edits(each) for card, each in values["task_edits"].items()})
    return found


def _renumbered(values: dict[str, Any], renumber: Renumber) -> tuple[dict[str, Any], tuple[Aside, ...]]:
    """The values with the numbers of parts now, and the things whose parts are gone."""

    def all_of(parts: Iterable[int]) -> tuple[int, ...]:
        return tuple(sorted(now for part in parts if (now := renumber(part)) is not None))

    def places(by_part: Mapping[int, Any]) -> Mapping[int, Any]:
        found = {now: place for part, place in by_part.items() if (now := renumber(part)) is not None}
        return MappingProxyType(dict(sorted(found.items())))

    found = dict(values)
    for name in ("hidden", "ghost", "out"):
        found[name] = all_of(values.get(name, ()))
    for name in ("gripped", "moved"):
        found[name] = places(values.get(name, {}))
    if (isolation := values.get("isolation")) is not None:
        found["isolation"] = Isolation(all_of(isolation.parts), all_of(isolation.hidden_before))
    if (trip := values.get("trip")) is not None:
        pairs = ((renumber(a), renumber(b)) for a, b in trip.seated)
        seated = frozenset((a, b) for a, b in pairs if a is not None and b is not None)
        found["trip"] = Trip(trip.way, all_of(trip.touched), seated)
    things, aside = kept_things(values, renumber)
    found |= things
    found["requirements"] = tuple(_requirement(each, renumber) for each in values.get("requirements", ()))
    if not found["gripped"] or found.get("replaying") not in {line.id for line in found["sequence"]}:
        found["replaying"] = None
    if not found["gripped"]:
        found["trip"] = None
    return found, aside


def aside_row(aside: Aside, keys: Sequence[str], at: str) -> str:
    """A result that is set aside, as a row of the file. keys: of its parts at that time. at: the time."""
    named = {str(part): keys[part] for part in aside.parts}
    return f'{{"kind":{dumps(aside.kind)},"at":{dumps(at)},"keys":{dumps(named)},"thing":{encoded(aside.thing)}}}'


def _with_back(
    values: dict[str, Any], rows: Sequence[Row], loads: Callable[[str, str], Any], number: Mapping[str, int]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The values, with the results that were set aside and have all their parts again; and the ids of their rows."""
    found, back = dict(values), []
    for row in rows:
        row_value, where = loads(row.value, "aside"), f"row {row.id} of the results set aside"
        kind = row_value.get("kind") if isinstance(row_value, dict) else None
        if (
            not isinstance(kind, str) or kind not in KINDS or "keys" not in row_value
        ):  # of versions that kept no names of the parts
            continue
        keys = _decoded(row_value["keys"], Mapping[int, str], where)
        now = brought_back(kind, _decoded(row_value.get("thing"), KINDS[kind], where), keys, number)
        if now is not None:
            found[kind] = (*found.get(kind, ()), now)
            back.append(row.id)
    return found, tuple(back)


def _without(values: dict[str, Any], absent: frozenset[int]) -> dict[str, Any]:
    """The values without the places of parts that are left out now, and were not before."""
    found = dict(values)
    for name in ("gripped", "moved"):
        by_part = values.get(name, {})
        if absent.intersection(by_part):
            found[name] = MappingProxyType({part: at for part, at in by_part.items() if part not in absent})
    if values.get("gripped") and not found["gripped"]:
        found["trip"] = found["replaying"] = None
    return found


# ---- checks ----


@dataclass(frozen=True)
class _Checks:
    parts: int

    def rising(self, numbers: Sequence[int], where: str) -> None:
        if any(a >= b for a, b in itertools.pairwise(numbers)):
            raise _damaged(where, "parts are not in order")
        self.there(numbers, where)

    def there(self, numbers: Iterable[int], where: str) -> None:
        for number in numbers:
            if not 0 <= number < self.parts:
                raise _damaged(where, f"there is no part {number}")

    def poses(self, rows: Iterable[motion.Row], where: str) -> None:
        for row in rows:
            try:
                motion.checked(row, where)
            except FeelerError as error:
                raise _damaged(where, str(error)[:120]) from None


def _check(document: Document, parts: int) -> None:
    """Raises `LoadError` for a document that no commands could have made and that would trip others."""
    check = _Checks(parts)
    for name in ("hidden", "ghost", "out"):
        check.rising(getattr(document, name), name)
    for name in ("gripped", "moved"):
        by_part = getattr(document, name)
        check.rising(list(by_part), name)
        check.poses(by_part.values(), name)
    check.poses([document.pose], "pose")
    if not 0 <= document.held_version < 2**50:
        raise _damaged("held_version", str(document.held_version))
    if set(document.gripped) & ({*document.moved} | {*document.absent}):
        raise _damaged("gripped", "a part is at two places")
    if document.unit not in UNITS or document.mode not in MODES or document.material not in (None, *MATERIALS):
        raise _damaged("the document", "a word that does not exist")
    if not 0.0 <= document.explode <= 1.0 or len(document.sections) > 64:
        raise _damaged("the document", "a number out of range")
    box = document.section_box
    if box is not None and not all(low < high for low, high in zip(box.lower, box.upper, strict=True)):
        raise _damaged("section_box", "it has no inside")
    if document.isolation is not None:
        check.rising(document.isolation.parts, "isolation")
        check.rising(document.isolation.hidden_before, "isolation")
    if document.trip is not None:
        check.poses(document.trip.way, "trip")
        check.there(document.trip.touched, "trip")
        check.there((part for pair in document.trip.seated for part in pair), "trip")
        if not document.trip.way:
            raise _damaged("trip", "it has no pose")
    for line in document.sequence:
        check.there([*line.parts, *line.out, *(part for part, _ in line.starts), *line.stale], "sequence")
        check.poses([*line.way, *(row for _, row in line.starts)], "sequence")
        if not line.way or not line.parts:
            raise _damaged("sequence", "a line without a way")
    for measure in document.measures:
        check.there([*measure.parts, *measure.stale], "measures")
    for each in document.requirements:
        if each.verdict is not None:
            check.there([*each.verdict.parts, *each.verdict.stale], "requirements")
    if document.findings is not None:
        check.there(document.findings.stale, "findings")
    for card in document.cards:
        check.there([*card.parts, *card.without, *(part for part, _ in card.world[0]), *card.world[1]], _CARDS)
        check.poses((row for _, row in card.world[0]), _CARDS)
        if not 0 < card.id < document.next_card < 2**50 or card.state in _OPEN:
            raise _damaged(_CARDS, str(card.id))
    if len({card.id for card in document.cards}) < len(document.cards):
        raise _damaged(_CARDS, "two cards have one id")
    named = {*lists(), "sections"} - {_CARDS}
    numbers = [each.id for name in named for each in getattr(document, name)]
    if len(set(numbers)) < len(numbers) or any(not 0 < number < document.next_id for number in numbers):
        raise _damaged("the document", "two things have one id")
    if document.next_id > 2**50:
        raise _damaged("next_id", str(document.next_id))
    if document.replaying is not None and (
        document.replaying not in {line.id for line in document.sequence} or not document.gripped
    ):
        raise _damaged("replaying", "there is no such line")
