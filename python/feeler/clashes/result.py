"""The result of a check: the table of findings, and all that is made of it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import overload

import numpy as np
import numpy.typing as npt

from feeler.choices import GroupBy, Status
from feeler.clashes.changes import compare
from feeler.clashes.grouping import grouped
from feeler.clashes.matching import PartMatch
from feeler.clashes.retried import with_rules
from feeler.clashes.rules import RulesLike, rules_from
from feeler.clashes.saving import load, save
from feeler.clashes.table import Clash, Table
from feeler.clashes.tracking import DEPTH_GROWTH_M
from feeler.field_docs import documented
from feeler.mockup import Mockup


class Clashes(Table):
    """The result of `feeler.clash`: a row for each pair of parts, the worst first.

    `clashes[i]` is a `Clash`. `clashes[i:j]` and `clashes[mask]` are tables that share the statuses of this one.
    Columns have an entry for each row and are read-only, one for each field of `Clash`: `.parts_a .parts_b .paths_a
    .paths_b .verdicts .depths .depth_errors .depth_kinds .translations .gaps .points_a .points_b .volumes .triangles
    .boxes .is_open_a .is_open_b .rules .severities .ids .statuses .by .notes .changed`. Sorted by severity; then
    duplicates; then clashes and contained parts, the deepest first; then contacts; then clearances, the nearest first;
    then by the names of parts.
    """

    def groups(self, by: GroupBy = "part", *, reach: float | None = None) -> list[Group]:
        """Groups the rows. The group with the worst row comes first.

        by: "part" (each row goes to the part with most of the remaining rows, so one misplaced part is one group),
        "rule", or "cluster" (chains of findings, each within `reach` metres of the next; default: a hundredth of the
        diagonal of the box around all). Raises `OptionError` for others.
        """
        return [Group(name, rows, self[rows]) for name, rows in grouped(self, by, reach)]

    def diff(self, previous: Clashes, *, growth: float = DEPTH_GROWTH_M) -> Changes:
        """Compares with the previous check, and takes over its statuses and notes.

        Findings of both checks keep their status, except that new becomes active. Findings that did not exist, or were
        resolved, are new. Findings that are gone are resolved. An approved finding is new again if it is more than
        `growth` metres deeper than when it was approved, beyond the error of the depth, if it became a duplicate, or
        if thin walls that did not overlap now clash. A partial check resolves nothing. Findings that this
        check did not look for, such as gaps above its clearance, and those that a rule hides, keep their status in
        `earlier()` for the next check.

        Parts match by path, even if they moved, also below a root or sub-assembly with another name that other parts
        of it tell; equal parts that swapped paths, by place. If a path is gone (a file,
        root or sub-assembly was renamed, a level added), or several parts have it, parts match by shape and place:
        another meshing, motions of at most 0.01 mm, or a shift of the whole assembly do not matter. If it was turned as
        a whole, such parts do not match. Size and area may differ by what the chords of the coarser mesh explain, whose
        facets meet at up to 46 degrees: 0.5 % of a radius for 32 facets, 8 % for 8. For flat parts, and for as many
        triangles as before, they may differ only by rounding, a millionth of the largest coordinate. `changed` of
        findings that match so is "renamed" or "renumbered", and `Changes.parts` counts the parts.

        Findings become new if their rule is renamed, if a part is renamed and also moved alone or reshaped, and if one
        of several parts of one path moves by more than half its size, unless a part with a path of its own moves with
        it. Parts of files of older versions may differ by 4 % of a side and 12 % of the area. Raises `LoadError` if no
        part of the previous findings is in this mock-up, by path or by shape.
        """
        parts = compare(self, previous, growth)
        found = {name: self.where(status=name) for name in ("new", "active", "reviewed", "approved")}
        return Changes(**found, resolved=self.earlier().where(status="resolved"), parts=parts)

    def with_rules(self, rules: RulesLike | None, mockup: Mockup | None = None) -> Clashes:
        """Applies other rules to these findings, without another check: to try rules on saved findings.

        rules: as in `feeler.clash`. mockup: the one that was checked, to find fasteners by shape, also for loaded
        findings; None: by name alone. Verdicts, severities and ids follow the new rules, statuses stay with their
        pairs, and `hidden` is counted again. It also counts findings that `others = false` leaves out; a check does not
        look for these. `facts.notes` lists what needs another check: pairs that were hidden, pairs beyond the clearance
        of the check, and verdicts that depend on more than the depth. Findings of older files have no names of parts;
        without `mockup`, the last step of the path counts as the name. Raises errors as `feeler.clash` does.
        """
        return with_rules(self, rules_from(rules), mockup)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the findings and `earlier()` with their statuses as JSON, one sorted line for each.

        Equal findings give equal bytes. `feeler.load_clashes` reads the file. Raises `WriteError`.
        """
        save(self, path)


@documented
@dataclass(frozen=True, eq=False)
class Group:
    """Some findings, the worst first. name: the key of a part, a rule, or "cluster 1"."""

    name: str
    rows: npt.NDArray[np.intp]
    """`(n,)`: indices into the grouped table."""
    clashes: Clashes
    """The findings themselves."""

    @property
    def worst(self) -> Clash:
        """The first finding."""
        return self.clashes[0]

    def __len__(self) -> int:
        return len(self.clashes)

    @overload
    def __getitem__(self, index: int) -> Clash: ...
    @overload
    def __getitem__(self, index: slice) -> Clashes: ...
    def __getitem__(self, index: int | slice) -> Clash | Clashes:
        return self.clashes[index]

    def __iter__(self) -> Iterator[Clash]:
        return iter(self.clashes)


@documented
@dataclass(frozen=True)
class Changes:
    """The findings of a check by status, each a table. `resolved` has rows of the previous check.

    parts: how many parts of the previous check are in this mock-up, and which were renamed.
    """

    new: Clashes
    """Found for the first time."""
    active: Clashes
    """Found before, too, and not decided."""
    reviewed: Clashes
    """Looked at; nothing was approved."""
    approved: Clashes
    """Allowed as deep as they were then."""
    resolved: Clashes
    parts: PartMatch

    def counts(self) -> dict[Status, int]:
        """The number of findings of each status."""
        return {name: len(getattr(self, name)) for name in ("new", "active", "reviewed", "approved", "resolved")}


def load_clashes(path: str | os.PathLike[str]) -> Clashes:
    """Loads findings that `Clashes.save` or `feeler clash --json` wrote, the worst first.

    Part numbers index the `part_paths` of the table, not the mock-up. Raises `MissingFileError` if the file does not
    exist, and `LoadError` if it has another format or version, or is cut short.
    """
    return load(path, Clashes)
