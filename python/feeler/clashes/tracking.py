"""Ids and statuses, which findings keep from check to check.

An id is a UUID of version 5 of the rule and both part paths. It is the same on every machine and does not depend on
coordinates. A status belongs to an id.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from feeler import choices
from feeler.arguments import check_text, check_word
from feeler.choices import Status
from feeler.errors import OptionError

STATUSES = choices.STATUSES
"""New: not in the previous check. Active: in it. Reviewed, approved: set by a person. Resolved: gone."""

SETTABLE = choices.SETTABLE_STATUSES
"""The statuses that a person can set."""

DEPTH_GROWTH_M = 1e-4
"""How much deeper an approved finding may become: the chord tolerance of STEP, since another triangulation of the same
surfaces can change a depth by this much. Larger: deeper clashes go unnoticed. Smaller: every new export of a file needs
approvals again."""

_NAMESPACE = uuid.UUID("14e5acf5-0b61-45c2-bc05-5a908cb2fbed")


@dataclass(frozen=True)
class Mark:
    """The status of one finding.

    status: one of `STATUSES`. by, note: who set it and why, or empty. approved_depth: the signed depth (metres; a gap
    is negative) at which it was approved; None if it was not, or if the next `diff` must set it. changed: "renamed" if
    the last `diff` found a part under another path, "renumbered" if only its number among equal paths changed, else
    empty.
    """

    status: Status = "new"
    by: str = ""
    note: str = ""
    approved_depth: float | None = None
    changed: str = ""


NEW = Mark()


def mark_json(mark: Mark) -> dict[str, Any]:
    """A mark as files have it, without empty fields. Not `changed`, which is of one check."""
    return {
        "status": mark.status,
        **({"by": mark.by} if mark.by else {}),
        **({"note": mark.note} if mark.note else {}),
        **({"approved_depth": mark.approved_depth} if mark.approved_depth is not None else {}),
    }


def mark_of_json(data: Mapping[str, Any]) -> Mark:
    """The mark of `mark_json`. Raises `ValueError` for anything else."""
    status, by, note, depth = (data.get(name) for name in ("status", "by", "note", "approved_depth"))
    if status not in STATUSES:
        raise ValueError(f"a finding has a status that does not exist ({status!r:.60})")
    if not all(text is None or isinstance(text, str) for text in (by, note)):
        raise ValueError("a note is not text")
    if depth is not None and (isinstance(depth, bool) or not isinstance(depth, (int, float)) or not abs(depth) < 1e100):
        raise ValueError("the depth of an approval is not a number")
    return Mark(cast("Status", status), by or "", note or "", None if depth is None else float(depth))


def part_keys(paths: Sequence[str]) -> list[str]:
    """A unique name for each part: its path, with `#2` for the second part of a path, and so on.

    The first part of a path has no number. Names that are the path of another part are skipped.
    """
    taken = set(paths)
    count: dict[str, int] = {}
    keys = []
    for path in paths:
        number = count.get(path, 0) + 1
        key = path
        while number > 1 and (key := f"{path}#{number}") in taken:
            number += 1
        taken.add(key)
        count[path] = number
        keys.append(key)
    return keys


def clash_id(rule: str, one: str, other: str) -> str:
    """The id of a finding, from its rule and the sorted keys of both parts."""
    first, second = sorted((one, other))
    return str(uuid.uuid5(_NAMESPACE, json.dumps([rule, first, second])))


def derived_id(*words: str) -> str:
    """A UUID for things made from findings, such as topics and viewpoints."""
    return str(uuid.uuid5(_NAMESPACE, json.dumps(words)))


class Marks:
    """The status of each finding by id. Slices of a table share one instance. Ids without an entry are new.

    aside: marks of findings that no table lists, such as those that the workbench ignores. `Clashes.diff` gives them to
    the findings once they are found again.
    """

    def __init__(self, marks: Mapping[str, Mark] | None = None, aside: Mapping[str, Mark] | None = None) -> None:
        self._by_id = dict(marks or {})
        self.aside: Mapping[str, Mark] = dict(aside or {})

    def of(self, clash: str) -> Mark:
        """The mark of a finding."""
        return self._by_id.get(clash, NEW)

    def set(self, clash: str, status: object, depth: float, by: object, note: object) -> None:
        """Sets the status of a finding. Raises `OptionError` for another status, or if `by` or `note` is not text."""
        if isinstance(status, str) and status == "resolved":
            raise OptionError(f"status is 'resolved', which only diff sets: choose {', '.join(SETTABLE)}")
        by = check_text("by", by, "text: who set the status")
        note = check_text("note", note, "text: why")
        self._by_id[clash] = Mark(
            check_word("status", status, SETTABLE),
            by,
            note,
            depth if status == "approved" else None,
            self.of(clash).changed,
        )

    def put(self, clash: str, mark: Mark) -> None:
        """Replaces the mark of a finding."""
        self._by_id[clash] = mark

    def replace(self, marks: Mapping[str, Mark]) -> None:
        """Replaces all marks."""
        self._by_id = dict(marks)


def followed(before: Mark | None, depth: float, growth: float) -> Mark:
    """The mark of a finding, given its mark in the previous check; None: it did not exist."""
    if before is None or before.status == "resolved":
        return NEW
    if before.status == "approved":
        was = before.approved_depth
        if was is None:  # from an older file, with another definition of depth
            return replace(before, approved_depth=depth)
        if depth > was + growth:
            grown = f"approved at {was:.6g} m, and now {depth:.6g} m deep"
            note = f"{before.note}; {grown}" if before.note else grown
            return replace(before, status="new", note=note, approved_depth=None)
        return before
    return replace(before, status="active") if before.status == "new" else before
