"""What changed from one check to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from feeler.clashes.rules import check_length
from feeler.clashes.table import Clashes
from feeler.clashes.tracking import Mark, Marks, followed, part_keys
from feeler.errors import LoadError, OptionError


@dataclass(frozen=True)
class Changes:
    """The findings of a check by their status, each a table; `resolved` has rows of the check before."""

    new: Clashes
    active: Clashes
    reviewed: Clashes
    approved: Clashes
    resolved: Clashes

    def counts(self) -> dict[str, int]:
        """How many there are of each status."""
        return {name: len(getattr(self, name)) for name in ("new", "active", "reviewed", "approved", "resolved")}


def changes(now: Clashes, before: Clashes, growth: float) -> Changes:
    """See `Clashes.diff`."""
    given: object = before
    if not isinstance(given, Clashes):
        raise OptionError(f"previous is {type(given).__name__}: give Clashes, such as of feeler.load_clashes")
    check_length("growth", growth)
    known = _with_earlier(before)
    check_mockup(now.part_paths, known)
    marks = {each: known.marks.of(each) for each in known.ids}
    here = set(now.ids)
    after: dict[str, Mark] = {}
    for each, depth in zip(now.ids, now.signed_depth.tolist(), strict=True):
        after[each] = followed(marks.get(each), depth, growth)
    gone = known[np.array([each not in here for each in known.ids], dtype=bool)]
    # A check that was stopped has not looked everywhere: what it did not find stays as it was.
    status = None if now.is_partial else "resolved"
    left: Mapping[str, Mark] = {
        each: marks[each] if status is None else replace(marks[each], status=status) for each in gone.ids
    }
    now.marks.replace(after)
    now.set_earlier(
        Clashes(gone.columns, gone.part_paths, gone.rules, marks=Marks(left), facts=gone.facts, is_partial=False)
    )
    found = {name: now.where(status=name) for name in ("new", "active", "reviewed", "approved")}
    return Changes(**found, resolved=now.earlier().where(status="resolved"))


def _with_earlier(table: Clashes) -> Clashes:
    """The rows of a table, and those of its `earlier` ones that nobody has called resolved."""
    from feeler.clashes.joining import joined

    waiting = table.earlier()
    waiting = waiting[waiting.status != "resolved"]
    return joined([table, waiting]) if len(waiting) else table


def check_mockup(part_paths: Sequence[str], known: Clashes) -> None:
    """Raises `LoadError` where nothing that was found before can be of a mock-up with these parts."""
    parts = set(known.a.tolist()) | set(known.b.tolist())
    keys = part_keys(known.part_paths)
    names = {keys[part] for part in parts}
    if names and names.isdisjoint(part_keys(part_paths)):
        raise LoadError(
            f"the previous clashes are of another mock-up: none of their {len(names):,} parts, such as "
            f"{min(names)!r}, is in this one of {len(part_paths):,} parts; give those of this mock-up"
        )
