"""Rules made from a finding: "ignore like this"."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from feeler.clashes import Exclusion, Rule, Rules
from feeler.clashes.limits import both_sides
from feeler.clashes.rules_file import pattern_of
from feeler.clashes.tracking import NEW
from feeler.errors import FeelerError, OptionError
from feeler.io.toml import quoted
from feeler.parts import Parts, escaped
from feeler.workbench.document.document import Findings
from feeler.workbench.document.finding_table import FindingTable
from feeler.workbench.document.findings import paired

_DIGITS = re.compile(r"\d+")
_NAME = re.compile(r"\s*name\s*=")


def alike(path: str) -> str:
    """A pattern for the part and its numbered siblings: `a/bolt_012` -> `a/bolt_*`."""
    folder, slash, name = path.rpartition("/")
    if not _DIGITS.search(name):
        return pattern_of(path)
    pattern = escaped(folder) + slash + _DIGITS.sub("*", escaped(name))
    return f"[r]{pattern[1:]}" if pattern.startswith("re:") else pattern


def with_exclusion(rules: str, name: str, a: str, b: str) -> str:
    """The text of rules with one more exclusion. Raises `OptionError` for a name that is there, or wrong patterns."""
    exclusion = Exclusion(name, (a,), (b,))
    if name in {each.name for each in Rules.parse(rules).exclusions}:
        raise OptionError(f"there is an exclusion {name!r} already: give another name")
    lines = ["[[exclude]]", f"name = {quoted(exclusion.name)}", f"a = {quoted(a)}", f"b = {quoted(b)}"]
    made = "\n".join([*([rules.rstrip("\n"), ""] if rules.strip() else []), *lines]) + "\n"
    Rules.parse(made)
    return made


def renamed_rules(rules: str, pattern: Callable[[str], str]) -> str:
    """The text of rules with other patterns, and all else as it is; unchanged where that cannot be done."""
    try:
        before = Rules.parse(rules)
    except FeelerError:
        return rules
    words = dict.fromkeys(word for rule in _all_of(before) for word in (*rule.a, *rule.b))
    others = {each: now for each in words if (now := pattern(each)) != each}
    lines = rules.splitlines(keepends=True)
    for each, now in others.items():
        for old in (quoted(each), json.dumps(each), f"'{each}'"):
            lines = [line if _NAME.match(line) else line.replace(old, quoted(now)) for line in lines]
    made = "".join(lines)
    try:
        after = Rules.parse(made)
    except FeelerError:
        return rules
    kept = [(rule.name, tuple(map(pattern, (*rule.a, *rule.b)))) for rule in _all_of(before)]
    is_whole = kept == [(rule.name, (*rule.a, *rule.b)) for rule in _all_of(after)]
    return made if is_whole else rules


def patterns_of(rules: str) -> list[str]:
    """The patterns of the text of rules; none where it is no rules."""
    try:
        made = Rules.parse(rules)
    except FeelerError:
        return []
    return [*dict.fromkeys(word for rule in _all_of(made) for word in (*rule.a, *rule.b))]


def _all_of(rules: Rules) -> list[Rule | Exclusion]:
    return [*rules.rules, *rules.exclusions]


def mask_of(table: FindingTable, parts: Parts, a: str, b: str) -> npt.NDArray[np.bool_]:
    """The rows whose pair of parts two patterns name. Raises `OptionError` for patterns that match no part."""
    one, other = both_sides(parts, Exclusion("alike", (a,), (b,)))
    known = table.part_of_path
    if not len(table):
        return np.zeros(0, bool)
    first, second = known[table.a], known[table.b]
    is_here = (first >= 0) & (second >= 0)
    return is_here & ((one[first] & other[second]) | (other[first] & one[second]))


def excluded(found: Findings, parts: Parts, name: str, a: str, b: str) -> Findings:
    """The findings without those that an exclusion names, which are counted in `hidden`."""
    mask = mask_of(found.table, parts, a, b)
    hidden = {**found.table.hidden, name: found.table.hidden.get(name, 0) + int(mask.sum())}
    names = {found.table.ids[row] for row in np.flatnonzero(mask)}
    said = {each: mark for each in names if (mark := found.mark_of(each)) != NEW or each in found.members}
    marks = {each: paired(found.table, each, mark) for each, mark in said.items()}
    return replace(
        found,
        table=found.table.rows(~mask, hidden),
        status=_others(found.status, names),
        notes=_others(found.notes, names),
        authors=_others(found.authors, names),
        aside=MappingProxyType({**found.aside, **dict(sorted(marks.items()))}),
    )


def _others(by_id: Mapping[str, str], names: Collection[str]) -> Mapping[str, str]:
    return MappingProxyType({each: value for each, value in by_id.items() if each not in names})


def unused(name: str, taken: Iterable[str]) -> str:
    """The name, or with a number if it is taken."""
    names, number, made = {*taken}, 2, name
    while made in names:
        made, number = f"{name} {number}", number + 1
    return made
