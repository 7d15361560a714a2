"""Findings that keep their name and their status from one check to the next.

An id is a UUID of version 5 of the rule and of both part paths, so that it is the same on every machine and does not
follow the coordinates. A status belongs to an id.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from feeler.errors import OptionError

STATUSES = ("new", "active", "reviewed", "approved", "resolved")
"""New: not in the check before. Active: it was. Reviewed, approved: somebody said so. Resolved: it is gone."""

SETTABLE = ("new", "active", "reviewed", "approved")
"""What somebody may say of a finding that is there."""

DEPTH_GROWTH_M = 1e-4
"""What an approved finding may grow deeper: the chord tolerance of STEP, since another triangulation of the same two
surfaces may move a depth by as much. More: depths grow unseen; less: files exported anew ask for approval again."""

_NAMESPACE = uuid.UUID("14e5acf5-0b61-45c2-bc05-5a908cb2fbed")


@dataclass(frozen=True)
class Mark:
    """What is known of one finding beside its geometry.

    status: one of `STATUSES`. by, note: who set it and why; empty where nobody did. approved_depth: the signed depth
    (metres; a gap is negative) at which it was approved, else None; None of an approval, too, whose depth the next
    `diff` is to set. changed: "renamed" where the last `diff` found one of its parts under another path, "renumbered"
    where only its number among equal paths changed, else empty.
    """

    status: str = "new"
    by: str = ""
    note: str = ""
    approved_depth: float | None = None
    changed: str = ""


NEW = Mark()


def part_keys(paths: Sequence[str]) -> list[str]:
    """A name of each part that no other has: its path; the second of a path gets a `#2` behind it, and so on.

    The first keeps its name when a second one comes. What would be the name of another part already is passed over.
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
    """The id of a finding: of its rule, and the keys of both parts in the order of their characters."""
    first, second = sorted((one, other))
    return str(uuid.uuid5(_NAMESPACE, json.dumps([rule, first, second])))


def derived_id(*words: str) -> str:
    """A UUID for what is made of findings: topics, viewpoints."""
    return str(uuid.uuid5(_NAMESPACE, json.dumps(words)))


class Marks:
    """The status of each finding by id. Slices of a table share one; those without an entry are new."""

    def __init__(self, marks: Mapping[str, Mark] | None = None) -> None:
        self._by_id = dict(marks or {})

    def of(self, clash: str) -> Mark:
        """What is known of a finding."""
        return self._by_id.get(clash, NEW)

    def set(self, clash: str, status: object, depth: float, by: object, note: object) -> None:
        """Says what somebody thinks of a finding. Raises `OptionError` for another status, or one that is no text."""
        if status not in SETTABLE:
            raise OptionError(f"status is {status!r}: choose {', '.join(SETTABLE)} (resolved is what is gone)")
        if not isinstance(by, str) or not isinstance(note, str):
            raise OptionError("by and note are texts: who says so, and why")
        self._by_id[clash] = Mark(
            str(status), by, note, depth if status == "approved" else None, self.of(clash).changed
        )

    def replace(self, marks: Mapping[str, Mark]) -> None:
        """Forgets all, and takes these."""
        self._by_id = dict(marks)


def followed(before: Mark | None, depth: float, growth: float) -> Mark:
    """The mark of a finding that is there, after what was known of it in the check before; None: it was not there."""
    if before is None or before.status == "resolved":
        return NEW
    if before.status == "approved":
        was = before.approved_depth
        if was is None:  # read from a file whose depth was another measure
            return replace(before, approved_depth=depth)
        if depth > was + growth:
            grown = f"approved at {was:.6g} m, and now {depth:.6g} m deep"
            note = f"{before.note}; {grown}" if before.note else grown
            return replace(before, status="new", note=note, approved_depth=None)
        return before
    return replace(before, status="active") if before.status == "new" else before
