"""Applies rules to existing findings, without another check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind
from feeler.clashes.fastener_rule import Shaped, shape_of
from feeler.clashes.limits import Limits, limits, unmatched
from feeler.clashes.rules import Rule, Rules
from feeler.clashes.scope import Scope
from feeler.clashes.table import AnyTable, Columns, Table
from feeler.clashes.tracking import part_keys
from feeler.clashes.verdict import DEFAULT_RULE, DEPTH_KINDS, Verdict
from feeler.errors import OptionError
from feeler.mockup import Mockup
from feeler.parts import Parts
from feeler.words import length

OTHERS = "others = false"
"""The key in `Clashes.hidden` for findings that no rule names."""

ROUNDOFFS = 32.0
"""`COORDINATEROUNDOFFS` of the core: parts touch if their depth is at most this many units in the last place of the
largest coordinate."""

_WALL_LENGTH = 1.5
"""The multiple of its depth above which the translation of a pair may be that of thin walls that cross."""

_WALL_MIDDLE = 0.98
"""`WALL_MIDDLE` of the core: from this share of half a wall's thickness on, a point is in its middle."""


def with_rules(clashes: AnyTable, rules: Rules, mockup: Mockup | None) -> AnyTable:
    """See `Clashes.with_rules`."""
    found, notes = _limits(clashes, rules, mockup)
    rule = found.rule_of(clashes.parts_a, clashes.parts_b)
    hidden_by = np.where(rule < 0, len(found.hiding), found.hidden_by(clashes.parts_a, clashes.parts_b))
    every = [*rules.rules, Rule(DEFAULT_RULE)]

    def judged_rows(rows: npt.NDArray[np.intp]) -> _Judged:
        return _judged(clashes, clashes.columns.rows(rows), [every[each] for each in rule[rows].tolist()])

    # Nothing hides a pair that is farther apart than its rule asks for: it is not a finding.
    is_hidden = hidden_by >= 0
    is_hidden[is_hidden] = ~judged_rows(np.flatnonzero(is_hidden)).is_far
    names = [*found.hiding, *([OTHERS] if not rules.others else [])]
    hidden = tuple((name, int(np.count_nonzero(is_hidden & (hidden_by == place)))) for place, name in enumerate(names))
    kept = np.flatnonzero(hidden_by < 0)
    judged, rule = judged_rows(kept), rule[kept]
    columns = replace(judged.columns, rule=rule.astype(np.uint32), severity=found.severities[rule])
    left = np.flatnonzero(~judged.is_far)
    order = left[columns.rows(left).order(clashes.keys, found.names)]
    notes += judged.notes
    facts = replace(
        clashes.facts,
        hidden=hidden,
        notes=tuple(notes),
        rules=tuple((each.name, *_asked(clashes, each)) for each in every),
    )
    made = type(clashes)(
        columns.rows(order),
        clashes.part_paths,
        found.names,
        facts=facts,
        is_partial=clashes.is_partial,
        scope=Scope.of(found, np.ones(len(clashes.part_paths), dtype=bool)),
    )
    before = [clashes.ids[row] for row in kept[order].tolist()]
    marks = {now: clashes.marks.of(then) for now, then in zip(made.ids, before, strict=True)}
    made.marks.replace(marks)
    made._set_earlier(clashes.earlier())
    return made


def _names(clashes: Table, mockup: Mockup | None) -> list[str]:
    """The names of the parts: those of the mock-up, else as the check had them."""
    checked = dict(clashes.facts.names)
    pairs = zip(clashes.keys, clashes.part_paths, strict=True)
    names = [checked.get(key, path.rpartition("/")[2]) for key, path in pairs]
    if mockup is None:
        return names
    check_kind("mockup", mockup, Mockup)
    known = dict(zip(part_keys(mockup.part_paths), mockup.part_names, strict=True))
    return [known.get(key, name) for key, name in zip(clashes.keys, names, strict=True)]


def _limits(clashes: Table, rules: Rules, mockup: Mockup | None) -> tuple[Limits, list[str]]:
    """The limits for the parts of the findings, and notes on what needs another check."""
    paths, facts = clashes.part_paths, clashes.facts
    count = len(paths)
    parts = Parts(_names(clashes, mockup), [*paths], np.zeros(count, np.uint32), np.zeros((count, 2, 3)))
    notes: list[str] = []
    if count < facts.parts:  # a file has only the parts of its findings
        notes += [f"{what} names no part of these findings" for what in unmatched(rules, parts, paths)]
        rules = replace(
            rules,
            rules=tuple(replace(each, optional=True) for each in rules.rules),
            exclusions=tuple(replace(each, optional=True) for each in rules.exclusions),
        )
    if mockup is None and any(each.fasteners for each in rules.exclusions):
        notes.append("fasteners are found by name alone. Pass the mock-up to find them by shape, too")
    for name, hidden in clashes.hidden.items():
        if hidden:
            notes.append(f"{hidden:,} findings that {name!r} hid are missing here. Check the mock-up to see them")
    least = _least_reach(clashes)
    for each in rules.rules:
        asked = max((x for x in (each.clearance, each.contact) if isinstance(x, float | int)), default=0.0)
        if asked > least:
            notes.append(
                f"rule {each.name!r} asks for {length(asked)}, but some pairs were checked only within "
                f"{length(least)}: farther ones are missing. Check the mock-up again with this rule"
            )
    shaped = None if mockup is None else _shaped(clashes, mockup)
    none = np.empty((0, 2), dtype=np.uint32)
    least_contact = facts.least_contact
    return limits(rules, parts, paths, facts.clearance, 0.0, 0.0, none, shaped, least_contact), notes


def _shaped(clashes: Table, mockup: Mockup) -> Shaped:
    """Finds fasteners by shape among the parts of the findings; loaded ones have only some of the mock-up's parts."""
    known = {key: part for part, key in enumerate(part_keys(mockup.part_paths))}
    missing = [key for key in clashes.keys if key not in known]
    if missing:
        raise OptionError(
            f"the clashes are of other parts than the mock-up's, such as {missing[0]!r}: give the mock-up that was "
            "checked"
        )
    parts, shaped = np.array([known[key] for key in clashes.keys], dtype=np.intp), shape_of(mockup)
    return lambda: shaped()[:, parts]


def _least_reach(clashes: Table) -> float:
    """Within which distance the check looked at every pair, metres: clearance or contact, whichever is more."""
    facts = clashes.facts
    if facts.rules:
        return min(max(clearance, contact) for _, clearance, contact in facts.rules)
    return max(facts.clearance, facts.contact if isinstance(facts.contact, float | int) else 0.0)


def _asked(clashes: Table, rule: Rule) -> tuple[float, float]:
    """Clearance and contact of a rule, metres; NaN for "chord", which needs the mock-up."""
    facts = clashes.facts
    clearance = facts.clearance if rule.clearance is None else rule.clearance
    contact = facts.contact if rule.contact is None else rule.contact
    if isinstance(contact, str):
        contact = _contacts(clashes).get(DEFAULT_RULE, np.nan) if facts.contact == contact else np.nan
    return clearance, max(contact, facts.least_contact) if contact == contact else contact


def _contacts(clashes: Table) -> dict[str, float]:
    """The contact of each rule of the check, metres."""
    return {name: contact for name, _, contact in clashes.facts.rules}


@dataclass(frozen=True, eq=False)
class _Judged:
    """Rows with new verdicts. is_far: rows that exceed the clearance. notes: verdicts that are uncertain."""

    columns: Columns
    is_far: npt.NDArray[np.bool_]
    notes: tuple[str, ...] = ()


def _judged(clashes: Table, columns: Columns, rules: Sequence[Rule]) -> _Judged:
    """The verdicts under the new rules, from depth and gap.

    A verdict stays if the contact of its rule is "chord", which needs the mock-up. Thin walls that cross stay a clash,
    although their depth is at most `contact` (see `Verdict.CLASH`). Contained parts and duplicates keep their verdict;
    an open part that is no deeper than `contact` in another becomes a contact.
    """
    if not len(columns.a):
        return _Judged(columns, np.zeros(0, dtype=bool))
    clearance, contact = np.array([_asked(clashes, each) for each in rules]).T
    before, default = _contacts(clashes), _asked(clashes, Rule(DEFAULT_RULE))[1]
    was = np.array([before.get(clashes.rule_names[each], default) for each in columns.rule.tolist()])
    verdict = columns.verdict.copy()
    is_known = ~np.isnan(contact)
    meet = (columns.gap == 0.0) | (columns.depth > 0.0)
    is_clash, is_contact = verdict == Verdict.CLASH.code, verdict == Verdict.CONTACT.code
    is_pierced = is_clash & (columns.depth <= was)
    is_shallow = is_known & is_clash & ~is_pierced & (columns.depth <= contact)
    is_deep = is_known & is_contact & meet & (columns.depth > contact) & ~(contact >= was)
    is_sheet = is_known & (verdict == Verdict.CONTAINED.code) & columns.is_open.any(axis=1) & (columns.depth <= contact)
    verdict[is_sheet] = Verdict.CONTACT.code
    is_deep[is_deep] = columns.depth[is_deep] > _rounding(clashes, columns, np.flatnonzero(is_deep))
    verdict[is_shallow] = Verdict.CONTACT.code
    verdict[is_deep] = Verdict.CLASH.code
    apart = np.flatnonzero(is_known & ((verdict == Verdict.CLEARANCE.code) | (is_contact & ~meet)))
    touch = np.maximum(contact[apart], _rounding(clashes, columns, apart))
    verdict[apart] = np.where(columns.gap[apart] <= touch, Verdict.CONTACT.code, Verdict.CLEARANCE.code)
    is_far = (verdict == Verdict.CLEARANCE.code) & (columns.gap > clearance)
    translation = np.where((verdict == Verdict.CONTACT.code)[:, None], 0.0, columns.translation)
    translation[is_deep] = np.nan
    is_old = is_known & is_contact & meet & ~(contact >= was) & (columns.depth == 0.0)
    is_old &= columns.depth_kind == DEPTH_KINDS.index("estimate")
    # The translation of thin walls is longer than they are deep.
    reach = np.minimum(contact, _WALL_LENGTH * columns.depth)
    is_long = is_shallow & (np.linalg.norm(columns.translation, axis=1) > reach)
    is_thin = is_known & is_contact & meet & ~is_deep & (contact < was) & (2.0 * columns.depth > _WALL_MIDDLE * contact)
    doubts = [
        (is_old, "contacts may be clashes by these rules: the file lacks their depth"),
        (is_long, "clashes count as contacts by their depth, but may be thin walls that cross"),
        (is_thin, "contacts may be clashes by these rules, as walls that share more than contact of their thickness"),
        (is_deep, "contacts are clashes by these rules, but may be contained parts: their translation is not known"),
    ]
    notes = [
        f"{count:,} {what}. Check the mock-up again with these rules"
        for rows, what in doubts
        if (count := int(np.count_nonzero(rows)))
    ]
    return _Judged(replace(columns, verdict=verdict, translation=translation), is_far, tuple(notes))


def _rounding(clashes: Table, columns: Columns, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
    """The least contact of some rows, metres, `(k,)`: the rounding of their largest coordinate."""
    largest = np.abs(_boxes(clashes, columns, rows)).max(axis=(1, 2, 3), initial=0.0)
    return np.asarray(ROUNDOFFS * np.spacing(largest))


def _boxes(clashes: Table, columns: Columns, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
    """The boxes of both parts of some rows, `(k, 2, 2, 3)`; 0 if unknown."""
    if not len(rows):
        return np.zeros((0, 2, 2, 3))
    shapes = clashes.shapes
    place = {key: number for number, key in enumerate(shapes.keys)}
    parts = np.stack([columns.a[rows], columns.b[rows]], axis=1)
    chosen = [[place[clashes.keys[part]] for part in pair] for pair in parts.tolist()]
    boxes: npt.NDArray[np.float64] = np.nan_to_num(shapes.box[np.array(chosen)])
    return boxes
