"""Ids and statuses, which findings keep from check to check.

An id is a UUID of version 5 of the rule and both part paths. It is the same on every machine and does not depend on
coordinates. A status belongs to an id.
"""

from __future__ import annotations

import json
import math
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from feeler import choices
from feeler.arguments import check_text, check_word
from feeler.choices import Status, VerdictName
from feeler.clashes.verdict import Verdict
from feeler.errors import OptionError

STATUSES = choices.STATUSES
"""New: not in the previous check. Active: in it. Reviewed, approved: set by a person. Resolved: gone."""

SETTABLE = choices.SETTABLE_STATUSES
"""The statuses that a person can set."""

DEPTH_GROWTH_M = 1e-4
"""How much deeper an approved finding may become: the chord tolerance of STEP, since another triangulation of the same
surfaces can change a depth by this much. Larger: deeper clashes go unnoticed. Smaller: every new export of a file needs
approvals again."""

APPROVAL = ("approved_depth", "approved_error", "approved_verdict")
"""The fields of a `Mark` that an approval has."""

_ERROR_SHARE, _LEAST_ERROR_M = 1e-3, 1e-9
"""The largest error of a measured depth, as a share and in metres: for approvals of older files, which lack it."""

_ESTIMATE_SHARE = 1e-2
"""How much an estimated depth of open parts changes at most if triangles are cut, as a share."""

_NAMESPACE = uuid.UUID("14e5acf5-0b61-45c2-bc05-5a908cb2fbed")


@dataclass(frozen=True)
class Mark:
    """The status of one finding.

    status: one of `STATUSES`. by, note: who set it and why, or empty. approved_depth: the signed depth (metres; a gap
    is negative) at which it was approved; None if it was not, or if the next `diff` must set it. approved_error: how
    much larger that depth can be, metres; approved_verdict: the verdict then; None if an older file lacks them.
    pair: of a finding that is not listed, its rule and the keys of its parts. changed: "renamed" if the last `diff`
    found a part under another path, "renumbered" if only its number among equal paths changed, else empty.
    """

    status: Status = "new"
    by: str = ""
    note: str = ""
    approved_depth: float | None = None
    changed: str = ""
    approved_error: float | None = None
    approved_verdict: VerdictName | None = None
    pair: tuple[str, str, str] | None = None


NEW = Mark()


class Found(NamedTuple):
    """What `followed` compares between checks.

    depth: signed, metres. error: how much larger it can be; NaN for estimates of open parts. is_thin: a clash by the
    rule of thin walls, whatever its depth.
    """

    depth: float
    error: float
    verdict: VerdictName
    is_thin: bool = False


def approved(mark: Mark, found: Found | None) -> Mark:
    """The mark with an approval of this finding; None: without an approval."""
    if found is None:
        return replace(mark, approved_depth=None, approved_error=None, approved_verdict=None)
    error = found.error if math.isfinite(found.error) else _ESTIMATE_SHARE * max(found.depth, 0.0)
    return replace(mark, approved_depth=found.depth, approved_error=error, approved_verdict=found.verdict)


def mark_json(mark: Mark) -> dict[str, Any]:
    """A mark as files have it, without empty fields. Not `changed`, which is of one check."""
    return {
        "status": mark.status,
        **({"by": mark.by} if mark.by else {}),
        **({"note": mark.note} if mark.note else {}),
        **approval_json(mark),
    }


def approval_json(mark: Mark) -> dict[str, Any]:
    """The fields of an approval as files store them, without those that are unknown."""
    known = {name: getattr(mark, name) for name in APPROVAL}
    return {name: value for name, value in known.items() if value is not None}


def mark_of_json(data: Mapping[str, Any]) -> Mark:
    """The mark of `mark_json`. Raises `ValueError` for anything else."""
    status, by, note = (data.get(name) for name in ("status", "by", "note"))
    if status not in STATUSES:
        raise ValueError(f"a finding has a status that does not exist ({status!r:.60})")
    if not all(text is None or isinstance(text, str) for text in (by, note)):
        raise ValueError("a note is not text")
    return Mark(cast("Status", status), by or "", note or "", **approval_of_json(data))


def approval_of_json(data: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `Mark` for an approval in a file. Raises `ValueError` if one is invalid."""
    found: dict[str, Any] = {}
    for name in APPROVAL[:2]:
        length = data.get(name)
        is_number = isinstance(length, (int, float)) and not isinstance(length, bool) and abs(length) < 1e100
        if length is not None and not is_number:
            raise ValueError(f"{name} is {length!r:.60}, not a length")
        found[name] = None if length is None else float(length)
    verdict = data.get(APPROVAL[2])
    if verdict is not None and verdict not in list(Verdict):
        raise ValueError(f"{APPROVAL[2]} is {verdict!r:.60}")
    return {**found, APPROVAL[2]: verdict}


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


def check_of(ids: Sequence[str], points: Sequence[npt.NDArray[np.float64]]) -> str:
    """A short name of a check, by its findings and the points of both parts in any order; saving keeps it."""
    places = np.stack(points, axis=1).round(6) + 0.0
    rows = sorted((each, sorted(place)) for each, place in zip(ids, places.tolist(), strict=True))
    return uuid.uuid5(_NAMESPACE, json.dumps(rows)).hex[:12]


class Marks:
    """The status of each finding by id. Slices of a table share one instance. Ids without an entry are new.

    aside: marks of findings that no table lists, such as those that the workbench ignores. `Clashes.diff` gives them to
    the findings once they are found again.
    """

    version = 0
    """Another number after each change: columns of statuses are made anew only then."""

    def __init__(self, marks: Mapping[str, Mark] | None = None, aside: Mapping[str, Mark] | None = None) -> None:
        self._by_id = dict(marks or {})
        self.aside: Mapping[str, Mark] = dict(aside or {})
        self.former: Mapping[str, str | None] = {}
        """By id in the last check that `Clashes.diff` compared with: the id here; None if it is gone."""
        self.former_check = ""
        """That check, as `check_of` names it."""
        self.renamed: Mapping[str, str] = {}
        """By id in that check, or in those before it: the id now that a part has another key, also of findings that
        this check did not look for."""

    def of(self, clash: str) -> Mark:
        """The mark of a finding."""
        return self._by_id.get(clash, NEW)

    def set(self, clash: str, status: object, found: Found, by: object, note: object) -> None:
        """Sets the status of a finding. Raises `OptionError` for another status, or if `by` or `note` is not text."""
        if isinstance(status, str) and status == "resolved":
            raise OptionError(f"status is 'resolved', which only diff sets: choose {', '.join(SETTABLE)}")
        by = check_text("by", by, "text: who set the status")
        note = check_text("note", note, "text: why")
        mark = Mark(check_word("status", status, SETTABLE), by, note, changed=self.of(clash).changed)
        self.put(clash, approved(mark, found if status == "approved" else None))

    def put(self, clash: str, mark: Mark) -> None:
        """Replaces the mark of a finding."""
        self._by_id[clash] = mark
        self.version += 1

    def replace(self, marks: Mapping[str, Mark]) -> None:
        """Replaces all marks."""
        self._by_id = dict(marks)
        self.version += 1


def followed(before: Mark | None, now: Found, growth: float) -> Mark:
    """The mark of a finding, given its mark in the previous check; None: it did not exist."""
    if before is None or before.status == "resolved":
        return NEW
    if before.status == "approved":
        if before.approved_depth is None:  # from an older file, with another definition of depth
            return approved(before, now)
        if why := outgrown(before, now, growth):
            note = f"{before.note}; {why}" if before.note else why
            return approved(replace(before, status="new", note=note), None)
        return before if before.approved_verdict else replace(before, approved_verdict=now.verdict)
    return replace(before, status="active") if before.status == "new" else before


def outgrown(before: Mark, now: Found, growth: float) -> str:
    """Why an approval ends, in words; empty if it does not.

    The depth must have grown for certain: its lower bound now is above the upper bound of then. Where the depth does
    not say how bad a finding is, the verdict counts: duplicates, and thin walls that came to cross.
    """
    then, verdict = before.approved_depth or 0.0, before.approved_verdict
    error = max(_ERROR_SHARE * then, _LEAST_ERROR_M) if before.approved_error is None else before.approved_error
    if now.depth > then + error + growth:
        return f"approved at {then:.6g} m, and now {now.depth:.6g} m deep"
    is_duplicate = now.verdict == "duplicate"
    if verdict is not None and verdict != now.verdict and (is_duplicate or (now.is_thin and verdict in _APART)):
        return f"approved as {verdict}, and now {now.verdict}"
    return ""


_APART = ("contact", "clearance")
"""Verdicts of parts that do not share volume beyond their tolerance."""
