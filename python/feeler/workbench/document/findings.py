"""What people do with the findings of a clash check, and files of findings."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from feeler.clashes import Clashes
from feeler.clashes.tracking import Mark, mark_json, mark_of_json
from feeler.errors import LoadError, MissingFileError
from feeler.io.text import decoded, text_of
from feeler.mockup import Mockup
from feeler.parts import Parts
from feeler.project.book import resolved_of
from feeler.workbench.document.document import Check, Findings, OwnGroup
from feeler.workbench.document.finding_table import FindingTable, clashes_in, lacking, table_of, table_of_clashes
from feeler.workbench.document.patient_json import patient_loads


def read_findings(path: str | Path) -> Any:
    """The content of a file, for `findings_of`. Raises `MissingFileError`, and `LoadError` for other files."""
    file = Path(path)
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give findings of feeler clash --json") from None
    return _parsed(text, str(file))


def parsed_findings(data: bytes, name: str) -> Any:
    """The content of a file that a page opened. Raises `LoadError`."""
    try:
        text = decoded(data).decode()
    except UnicodeDecodeError as error:
        raise LoadError(f"{name} is not text in UTF-8: {error.reason} at byte {error.start}") from None
    return _parsed(text, name)


def _parsed(text: str, name: str) -> Any:
    try:
        data = patient_loads(text)
    except (ValueError, RecursionError) as error:
        raise LoadError(f"{name} cannot be read as JSON: {error}") from None
    clashes_in(data, name)
    return data


def findings_of(data: Any, parts: Parts, absent: Collection[int] = ()) -> Findings:
    """Findings in JSON, for the document. Raises `LoadError` if there is no list."""
    return Findings(table_of(data, parts, absent))


def doubt_of(found: Findings, parts: Parts) -> str:
    """How many findings name parts that the mock-up lacks, in words; empty if none does."""
    table = found.table
    lacked = lacking(table, parts)
    count = int((np.isin(table.a, lacked) | np.isin(table.b, lacked)).sum())
    if not count:
        return ""
    name = table.paths[lacked[0]]
    some = "finding names" if len(table) == 1 else "findings name"
    return f"{count:,} of {len(table):,} {some} parts that this mock-up lacks, such as {name!r}"


def findings_of_clashes(clashes: Clashes, mockup: Mockup, absent: Collection[int] = ()) -> Findings:
    """The findings of a check of this mock-up, for the document."""
    return Findings(table_of_clashes(clashes, mockup, absent))


def saved(found: Findings) -> dict[str, Any]:
    """The findings with their rows as JSON, for `restored`: for records and projects."""
    facts = found.to_json()
    kept = ("status", "notes", "own_groups", "members", "is_touching_hidden", "check")
    aside = {name: mark_json(mark) for name, mark in found.aside.items()}
    return {
        "table": found.table.to_json(),
        **{name: facts[name] for name in kept},
        "authors": dict(found.authors),
        "aside": aside,
        "resolved": list(found.resolved),
    }


def restored(data: Any, parts: Parts, absent: Collection[int] = ()) -> Findings:
    """The findings of `saved`. Raises `LoadError` for anything else."""
    if not isinstance(data, Mapping):
        raise LoadError("the saved findings are not an object")
    try:
        check = data["check"]
        return Findings(
            table_of(data["table"], parts, absent),
            MappingProxyType({str(name): str(word) for name, word in data["status"].items()}),
            MappingProxyType({str(name): str(text) for name, text in data["notes"].items()}),
            tuple(OwnGroup(int(each["id"]), str(each["name"])) for each in data["own_groups"]),
            MappingProxyType({str(name): int(group) for name, group in data["members"].items()}),
            bool(data["is_touching_hidden"]),
            None if check is None else _check(check),
            MappingProxyType({str(name): mark_of_json(mark) for name, mark in data.get("aside", {}).items()}),
            authors=MappingProxyType({str(name): str(by) for name, by in data.get("authors", {}).items()}),
            resolved=tuple(resolved_of({"earlier": data.get("resolved")})),
        )
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise LoadError(f"the saved findings cannot be read: {error!r}") from None


def _check(data: Mapping[str, Any]) -> Check:
    of = data["of"]
    return Check(
        float(data["clearance"]),
        None if data["contact"] is None else float(data["contact"]),
        None if of is None else tuple(map(int, of)),
        MappingProxyType({int(part): tuple(map(float, place)) for part, place in data["moved"].items()}),
        tuple(map(int, data["out"])),
        tuple(map(int, data["gripped"])),
    )


def changed(before: Mapping[str, Any], more: Mapping[str, Any], base: Callable[[str], Any]) -> Mapping[str, Any]:
    """Values by id with some of them set; those that are as in the table need no entry."""
    kept = {name: value for name, value in before.items() if name not in more}
    return MappingProxyType({**kept, **{name: value for name, value in more.items() if base(name) != value}})


def signed(found: Findings, authors: Mapping[str, str]) -> Findings:
    """The findings with who set the statuses and notes of some of them; those whose mark says so need no entry."""
    bare = replace(found, authors=MappingProxyType({n: by for n, by in found.authors.items() if n not in authors}))
    own = {name: by for name, by in authors.items() if bare.mark_of(name).by != by}
    return replace(bare, authors=MappingProxyType({**bare.authors, **own}))


def paired(table: FindingTable, name: str, mark: Mark) -> Mark:
    """The mark of a finding that will not be listed, with its rule and the keys of its parts."""
    row = table.row_of.get(name)
    if row is None:
        return mark
    value = table.whole_row_json(row)
    return replace(mark, pair=(str(value.get("rule") or ""), str(value["a"]), str(value["b"])))


def carried(found: Findings, now: Findings | None, since: Findings | None) -> Findings:
    """Findings of a check, with what people did while it ran. since: the findings when it began."""
    if now is None:
        return found
    here = found.table.row_of
    before = Findings(now.table) if since is None else since
    names = {*now.status, *now.notes, *before.status, *before.notes}
    changes = {name: (before.mark_of(name), now.mark_of(name)) for name in names}
    differ = {name: there for name, (then, there) in changes.items() if then != there}
    status = {
        name: mark.status for name, mark in differ.items() if name in here and changes[name][0].status != mark.status
    }
    notes = {name: mark.note for name, mark in differ.items() if name in here and changes[name][0].note != mark.note}
    authors = {name: mark.by for name, mark in differ.items() if name in here}
    ended = {row["id"] for row in found.resolved}
    aside = {
        name: paired(now.table, name, mark)
        for name, mark in {**found.aside, **now.aside, **differ}.items()
        if name not in here and name not in ended
    }
    resolved = (
        {**row, "by": differ[row["id"]].by, "note": differ[row["id"]].note} if row["id"] in differ else row
        for row in found.resolved
    )
    made = replace(
        found,
        status=changed(found.status, status, found.table.status_of),
        notes=changed(found.notes, notes, found.table.note_of),
        own_groups=now.own_groups,
        members=MappingProxyType({name: group for name, group in now.members.items() if name in here or name in aside}),
        is_touching_hidden=now.is_touching_hidden,
        aside=MappingProxyType(aside),
        resolved=tuple(resolved),
    )
    return signed(made, authors)
