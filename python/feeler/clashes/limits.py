"""Limits for the pairs of parts of one mock-up, by its rules, and pairs that are hidden.

The first rule that names a pair applies; other pairs have the `clearance` and `contact` of the call. Pairs of an
exclusion, and of the `level` of a rule, are checked like others, then hidden and counted. The count shows when an
exclusion hides too much.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.clashes.fastener_rule import Shaped, fastener_mask
from feeler.clashes.rules import Exclusion, Rule, Rules
from feeler.clashes.verdict import DEFAULT_RULE, SEVERITIES
from feeler.errors import OptionError
from feeler.parts import Parts

Ints = npt.NDArray[np.uint32]

Hider = Callable[[Ints, Ints, npt.NDArray[np.int32]], npt.NDArray[np.bool_]]
"""Returns which pairs of parts are hidden, given both parts and their rule."""

NOT_ASKED = -1.0
"""The clearance that the core takes for pairs of classes to skip."""

CLASS_LIMIT = 2_048
"""Most classes of parts. The tables of their pairs have this many rows and columns, 80 MB in all."""


@dataclass(frozen=True, eq=False)
class Limits:
    """The rules as tables for one mock-up.

    names, severities: of each rule; the last is for pairs that no rule names. of_classes: `(classes, classes)`, the
    rule of each pair of classes, -1 for pairs to skip. class_of_part: `(parts,)`. clearance, contact: `(classes,
    classes)` metres. exclude: `(k, 2)` pairs of parts to skip. hiding: the names of exclusions and of rules with a
    level, in the order in which `hiders` are tried. asked: name, clearance and contact of each rule, metres.
    """

    names: tuple[str, ...]
    severities: npt.NDArray[np.uint8]
    of_classes: npt.NDArray[np.int32]
    class_of_part: npt.NDArray[np.uint32]
    clearance: npt.NDArray[np.float64]
    contact: npt.NDArray[np.float64]
    exclude: npt.NDArray[np.uint32]
    hiding: tuple[str, ...] = ()
    asked: tuple[tuple[str, float, float], ...] = ()
    hiders: tuple[Hider, ...] = ()

    def rule_of(self, a: npt.NDArray[np.uint32], b: npt.NDArray[np.uint32]) -> npt.NDArray[np.int32]:
        """The rule of each pair of parts; -1 for pairs to skip."""
        return np.array(self.of_classes[self.class_of_part[a], self.class_of_part[b]])

    def hidden_by(self, a: npt.NDArray[np.uint32], b: npt.NDArray[np.uint32]) -> npt.NDArray[np.int32]:
        """The first of `hiding` that hides each pair of parts; -1 for visible pairs."""
        found = np.full(len(a), -1, dtype=np.int32)
        rule = self.rule_of(a, b)
        for number, hider in enumerate(self.hiders):
            found[(found < 0) & hider(a, b, rule)] = number
        return found


CONTACT_ROUNDINGS = 4.0
"""How many roundings of the coordinates in a file `contact` is at least. Each corner of two parts may be off by the
square root of 3 roundings, so flush faces may overlap by 3.5."""


def limits(
    rules: Rules,
    parts: Parts,
    paths: Sequence[str],
    clearance: float,
    contact: float | str,
    chord: float | None,
    exclude: npt.NDArray[np.uint32],
    shaped: Shaped | None = None,
    least_contact: float = 0.0,
) -> Limits:
    """Applies the rules to the parts. chord: the chordal error of the mock-up, metres, for `contact="chord"`. shaped:
    finds parts with the shape of a fastener; None: names alone decide. least_contact: the least `contact`, metres.

    Raises `OptionError` for patterns that match no part, with similar names; for "chord" if it is not known; and for
    rules that need more than `CLASS_LIMIT` classes of parts.
    """
    every = [*rules.rules, Rule(DEFAULT_RULE)]
    named = _Named(parts, paths, rules.where)
    sides = [named.both(f"rule {rule.name!r}", rule) for rule in every]
    hiders = _hiders(rules, named, paths, shaped)
    signature = np.array([side for pair in sides for side in pair], dtype=bool).T
    kinds, class_of_part = np.unique(signature, axis=0, return_inverse=True)
    if len(kinds) > CLASS_LIMIT:
        raise OptionError(
            f"{rules.where}: the patterns put the parts into {len(kinds):,} classes, and {CLASS_LIMIT:,} are the most; "
            "use fewer rules, or patterns that overlap less"
        )
    of_classes = np.full((len(kinds), len(kinds)), -1, dtype=np.int32)
    for number in range(len(every) - 1 if not rules.others else len(every)):
        of_classes[_meets(kinds, number) & (of_classes < 0)] = number
    near = np.array([clearance if rule.clearance is None else rule.clearance for rule in every])
    least = [contact if rule.contact is None else rule.contact for rule in every]
    doubled = _chord_of(least, chord, len(paths), of_classes, rules.where)
    touch = np.array([0.0 if isinstance(each, str) else each for each in least]) + doubled
    touch = np.maximum(touch, least_contact)
    asked = of_classes >= 0
    return Limits(
        tuple(rule.name for rule in every),
        np.array([SEVERITIES.index(rule.severity) for rule in every], dtype=np.uint8),
        of_classes,
        class_of_part.reshape(-1).astype(np.uint32),
        np.where(asked, near[of_classes], NOT_ASKED),
        np.where(asked, touch[of_classes], 0.0),
        np.unique(exclude, axis=0).astype(np.uint32),
        tuple(name for name, _ in hiders),
        tuple((rule.name, float(near[i]), float(touch[i])) for i, rule in enumerate(every)),
        tuple(hider for _, hider in hiders),
    )


def only_with(found: Limits, chosen: npt.NDArray[np.bool_]) -> Limits:
    """The limits for pairs with at least one chosen part; others are skipped. chosen: `(parts,)`."""
    twice = np.concatenate([found.of_classes, found.of_classes])
    every = np.concatenate([twice, twice], axis=1)
    count = len(found.of_classes)
    every[:count, :count] = -1
    asked = every >= 0

    def doubled(table: npt.NDArray[np.float64], skipped: float) -> npt.NDArray[np.float64]:
        return np.where(asked, np.tile(table, (2, 2)), skipped)

    return replace(
        found,
        of_classes=every,
        class_of_part=found.class_of_part + np.where(chosen, count, 0).astype(np.uint32),
        clearance=doubled(found.clearance, NOT_ASKED),
        contact=doubled(found.contact, 0.0),
    )


def without_groups(
    found: Limits, groups: Sequence[tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]]
) -> Limits | None:
    """The limits without any pair of a part of the first group with one of the second, in either order, by classes:
    no pair is listed. None if this needs more than `CLASS_LIMIT` classes."""
    sides = np.zeros((len(found.class_of_part), 2 * len(groups)), dtype=bool)
    for column, parts in enumerate(part for group in groups for part in group):
        sides[parts, column] = True
    packed = np.packbits(sides, axis=1).astype(np.uint32)
    kinds, first, class_of_part = np.unique(
        np.column_stack([found.class_of_part, packed]), axis=0, return_index=True, return_inverse=True
    )
    if len(kinds) > CLASS_LIMIT:
        return None
    before = kinds[:, 0]
    of_classes = found.of_classes[np.ix_(before, before)]
    for number in range(len(groups)):
        of_classes[_meets(sides[first], number)] = -1
    asked = of_classes >= 0
    return replace(
        found,
        of_classes=of_classes,
        class_of_part=class_of_part.reshape(-1).astype(np.uint32),
        clearance=np.where(asked, found.clearance[np.ix_(before, before)], NOT_ASKED),
        contact=np.where(asked, found.contact[np.ix_(before, before)], 0.0),
    )


def both_sides(parts: Parts, each: Rule | Exclusion) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """The parts that the patterns `a` and `b` name, as masks. Raises `OptionError` for patterns that name none."""
    return _Named(parts, [part.path for part in parts], "rules").both(repr(each.name), each)


def _hiders(rules: Rules, named: _Named, paths: Sequence[str], shaped: Shaped | None) -> list[tuple[str, Hider]]:
    """Exclusions, then rules with a level, by name, each with its test for pairs to hide."""
    found: list[tuple[str, Hider]] = []
    for each in rules.exclusions:
        if each.same_assembly:
            found.append((each.name, _Within(sub_assemblies(paths, each.same_assembly))))
        elif each.fasteners:
            found.append((each.name, _Between(fastener_mask(paths, shaped), np.ones(len(paths), dtype=bool))))
        else:
            found.append((each.name, _Between(*named.both(f"exclusion {each.name!r}", each))))
    for number, rule in enumerate(rules.rules):
        if rule.level:
            found.append((rule.name, _Within(sub_assemblies(paths, rule.level), number)))
    return found


@dataclass(frozen=True, eq=False)
class _Between:
    """Hides pairs with one part in the first mask and the other part in the second."""

    one: npt.NDArray[np.bool_]
    other: npt.NDArray[np.bool_]

    def __call__(self, a: Ints, b: Ints, _rule: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
        return (self.one[a] & self.other[b]) | (self.one[b] & self.other[a])


@dataclass(frozen=True, eq=False)
class _Within:
    """Hides pairs within one sub-assembly. only: limits this to one rule."""

    assembly: npt.NDArray[np.int64]
    only: int | None = None

    def __call__(self, a: Ints, b: Ints, rule: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
        same: npt.NDArray[np.bool_] = (self.assembly[a] == self.assembly[b]) & (self.assembly[a] >= 0)
        return same if self.only is None else same & (rule == self.only)


def unmatched(rules: Rules, parts: Parts, paths: Sequence[str]) -> list[str]:
    """The patterns that match no part, each with its rule or exclusion."""
    named = _Named(parts, paths, rules.where)
    found = []
    every: list[tuple[str, Rule | Exclusion]] = [("rule", rule) for rule in rules.rules]
    every += [("exclusion", each) for each in rules.exclusions]
    for kind, each in every:
        for pattern in [*each.a, *each.b]:
            try:
                if pattern != "*":
                    named.matching(pattern)
            except OptionError:
                found.append(f"{pattern!r} of {kind} {each.name!r}")
    return found


def sides(rule: Rule, parts: Parts, paths: Sequence[str], where: str) -> tuple[npt.NDArray[np.bool_], ...]:
    """The parts that a rule names as `a` and as `b`, `(parts,)` each. Raises `OptionError` for patterns that match no
    part, unless the rule is optional."""
    return _Named(parts, paths, where).both(f"rule {rule.name!r}", rule)


def sub_assemblies(paths: Sequence[str], level: int) -> npt.NDArray[np.int64]:
    """A number for the first `level` steps of each path, `(parts,)`; -1 for paths that have no more steps."""
    keys: dict[tuple[str, ...], int] = {}
    found = np.empty(len(paths), dtype=np.int64)
    for place, path in enumerate(paths):
        steps = path.split("/")
        found[place] = keys.setdefault(tuple(steps[:level]), len(keys)) if len(steps) > level else -1
    return found


def _meets(kinds: npt.NDArray[np.bool_], number: int) -> npt.NDArray[np.bool_]:
    """Which pairs of classes the rule of that number names, in either order."""
    one, other = kinds[:, 2 * number], kinds[:, 2 * number + 1]
    found = one[:, None] & other[None, :]
    return np.asarray(found | found.T)


def _chord_of(
    contacts: Sequence[float | str], chord: float | None, parts: int, of_classes: npt.NDArray[np.int32], where: str
) -> npt.NDArray[np.float64]:
    """The sum of both chordal errors for rules with "chord", metres; 0 for rules with a number."""
    is_chord = np.array([isinstance(each, str) for each in contacts])
    if is_chord[np.unique(of_classes[of_classes >= 0])].any() and chord is None:
        raise OptionError(
            f'contact="chord" ({where}): the chordal error is known only of STEP files, '
            "which feeler triangulates itself; give contact in metres"
        )
    return np.where(is_chord, 2.0 * (chord or 0.0), 0.0)


class _ExpressionError(OptionError):
    """A regular expression is not valid."""


class _Named:
    """Turns patterns into masks of parts."""

    def __init__(self, parts: Parts, paths: Sequence[str], where: str) -> None:
        self.parts, self.paths, self.where = parts, paths, where

    def both(self, who: str, each: Rule | Exclusion) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """The masks of `a` and of `b`."""
        return self._mask(who, "a", each.a, each.optional), self._mask(who, "b", each.b, each.optional)

    def _mask(self, who: str, side: str, patterns: Iterable[str], optional: bool) -> npt.NDArray[np.bool_]:
        mask = np.zeros(len(self.paths), dtype=bool)
        for pattern in patterns:
            if pattern == "*":
                mask[:] = True
                continue
            try:
                mask[self.matching(pattern)] = True
            except OptionError as error:
                is_wrong = isinstance(error, _ExpressionError)
                if is_wrong or not optional:
                    hint = "" if is_wrong else " (optional = true lets it match nothing)"
                    raise OptionError(f"{self.where}, {who}, {side}: {error}{hint}") from None
        return mask

    def matching(self, pattern: str) -> npt.NDArray[Any]:
        """The parts that one pattern names. Raises `OptionError` where it names none, or is no pattern."""
        if not pattern.startswith("re:"):
            return self.parts.select(pattern)
        try:
            matches = re.compile(pattern[3:]).fullmatch
        except re.error as error:
            raise _ExpressionError(f"{pattern!r} is not a regular expression: {error}") from None
        found = np.flatnonzero([matches(path) is not None for path in self.paths])
        if not len(found):
            near = self.paths[0] if self.paths else ""
            raise OptionError(f"no path matches {pattern!r} as a whole; paths are such as {near!r}")
        return found
