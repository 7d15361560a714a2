"""The parts of the last run under their paths of today: it may be of a file with another name, another level, other
names of parts.

    last run, parts of today -> matching of `feeler.clashes` -> the last run with the paths of today
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from feeler.clashes.matching import matched
from feeler.clashes.shapes import Shapes
from feeler.errors import OptionError
from feeler.tasks.night_rows import Plan, Seeing
from feeler.tasks.run import Maintenance
from feeler.tasks.snapshots import Held, Seen, Snapshot
from feeler.tasks.stored_answers import renamed_id
from feeler.tasks.times import Times, entries_for
from feeler.words import plural

_NUMBERED = re.compile(r"(.*)#\d+", re.DOTALL)
_TEXT = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"", re.DOTALL)
"""A text in a `repr`."""
_OF_HOLD, _OF_FASTENER = 1, 2
"""Texts at the beginning of `Held.facts` that are no paths: the kind of the hold; kind and drive of the fastener."""
_BEFORE = " (before)"

Names = Mapping[str, str]
"""The path of today by the path of the last run, of parts whose paths differ."""


@dataclass(frozen=True)
class Recognised:
    """Which parts of the last run are in this mock-up. `str()` gives a sentence."""

    parts: int
    """The number of parts of the last run."""
    by_path: int
    """Of these, parts with the same path."""
    altered: int
    """Of `by_path` and `by_shape`, parts with another shape or place."""
    by_shape: int
    """Parts with another path: the same shape and place, or the path that the others' new paths suggest."""
    names: Names = field(default_factory=dict)
    """The paths of today by those of the last run: of the parts in `by_shape`, and of parts that are gone and whose
    path is another part's."""
    before: Names = field(default_factory=dict)
    """The path in the last run of each part in `by_shape`, by its path of today."""

    def __str__(self) -> str:
        found = self.by_path + self.by_shape
        said = (
            f"{found:,} of {plural(self.parts, 'part')} of the last run are in this mock-up: {self.by_path:,} by path"
        )
        said += f", {self.by_shape:,} by shape and place" if self.by_shape else ""
        said += f" ({self.altered:,} with another shape or place)" if self.altered else ""
        if self.before:
            now, before = min(self.before.items())
            said += f", such as {now}, renamed from {before}"
        return said

    @property
    def is_doubtful(self) -> bool:
        """Whether less than half of the parts have the same shape and place as before."""
        return 2 * (self.by_path + self.by_shape - self.altered) < self.parts

    @property
    def hints(self) -> list[str]:
        """What is to be said of it."""
        if self.is_doubtful:
            return [f"{self}. Is the last run of this mock-up?"]
        return [f"{self}."] if self.before else []


def recognised(old: Mapping[str, Seen], new: Mapping[str, Seen]) -> Recognised:
    """Matches the parts of the last run with those of today. Raises `OptionError` if none matches."""
    shapes = _shapes(old, new)
    new_of_old, is_same, is_ambiguous = matched(*shapes)
    pairs = {a: int(b) for a, b in enumerate(new_of_old.tolist()) if b >= 0}
    pairs.update(_by_place_in_tree(shapes, pairs))
    if old and new and not pairs and not is_ambiguous.any():
        raise OptionError(
            f"previous is a run of another mock-up: none of its parts is in this one (0 of {len(old):,}, such as "
            f"{next(iter(old))!r}, match one of {plural(len(new), 'part')}, such as {next(iter(new))!r}, by path or by "
            "shape and place); give the last run of this mock-up, or none"
        )
    keys = [each.keys for each in shapes]
    names = {keys[0][a]: keys[1][b] for a, b in pairs.items() if keys[0][a] != keys[1][b]}
    altered = sum(not is_same[a] for a in pairs)
    before = {now: then for then, now in names.items()}
    gone = [key for n, key in enumerate(keys[0]) if n not in pairs]
    taken = {*keys[0], *keys[1]}
    for key in gone:
        if key in new:
            names[key] = _free(key, taken)
    return Recognised(len(old), len(pairs) - len(before), altered, len(before), names, before)


def _free(key: str, taken: set[str]) -> str:
    """A path that no part has, for a part that is gone."""
    name = key + _BEFORE
    while name in taken:
        name += _BEFORE
    taken.add(name)
    return name


def _shapes(*runs: Mapping[str, Seen]) -> tuple[Shapes, Shapes]:
    """As the matching takes them. Older files have no centroids: the middles of boxes serve for all."""
    is_known = all(each.middle is not None for parts in runs for each in parts.values())
    one, other = (_rows(parts, is_known) for parts in runs)
    return one, other


def _rows(parts: Mapping[str, Seen], is_known: bool) -> Shapes:
    seen = list(parts.values())
    box = np.array([each.box for each in seen], dtype=np.float64).reshape(-1, 2, 3)
    box[~np.isfinite(box).all(axis=(1, 2))] = np.nan
    middles = [each.middle for each in seen] if is_known else box.mean(axis=1)
    area = np.array([each.measure[1] for each in seen], dtype=np.float64)
    area[(area < 0.0) | np.isnan(box[:, 0, 0])] = np.nan
    content = np.array([int(each.digest[:16], 16) for each in seen], dtype=np.uint64)
    paths = tuple(_path(key, parts) for key in parts)
    middle = np.array(middles, dtype=np.float64).reshape(-1, 3)
    triangles = np.array([each.measure[0] for each in seen], dtype=np.int64)
    chords = np.full(len(seen), np.nan)  # nights do not keep them
    return Shapes(tuple(parts), paths, content, box, middle, area, triangles, chords, chords)


def _path(key: str, parts: Mapping[str, Seen]) -> str:
    """The path of a part: its key without the number among equal paths."""
    found = _NUMBERED.fullmatch(key)
    return found[1] if found and found[1] in parts else key


def _by_place_in_tree(shapes: tuple[Shapes, Shapes], pairs: Mapping[int, int]) -> dict[int, int]:
    """Further pairs: parts that moved or changed their shape, by the beginning of paths that changed for the others.

    If `old/a` is `new/b/a` now, `old/c` is `new/b/c`.
    """
    starts: Counter[tuple[tuple[str, ...], tuple[str, ...]]] = Counter()
    steps = [[tuple(path.split("/")) for path in each.paths] for each in shapes]
    for a, b in pairs.items():
        starts[_starts(steps[0][a], steps[1][b])] += 1
    free = {row: n for n, row in enumerate(steps[1]) if n not in {*pairs.values()}}
    singles = [Counter(each) for each in steps]
    found: dict[int, int] = {}
    for (old, new), _ in sorted(starts.items(), key=lambda item: (-item[1], item[0])):
        for a, path in enumerate(steps[0]):
            if a in pairs or a in found or path[: len(old)] != old:
                continue
            now = (*new, *path[len(old) :])
            if now in free and singles[0][path] == singles[1][now] == 1:
                found[a] = free.pop(now)
    return found


def _starts(old: tuple[str, ...], new: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Two paths without the last steps that they share."""
    end = 0
    while end < min(len(old), len(new)) and old[-1 - end] == new[-1 - end]:
        end += 1
    return old[: len(old) - end], new[: len(new) - end]


def retimed(times: Times, names: Names) -> frozenset[str]:
    """The parts of today for which a table of times has other entries than for their path before."""
    return frozenset(now for then, now in names.items() if entries_for(times, then) != entries_for(times, now))


def renamed(run: Maintenance, names: Names) -> Maintenance:
    """A run with other paths, without the run that it was compared with."""
    if not names:
        return run
    now = _now(names)
    return Maintenance(
        names={renamed_id(key, names): name for key, name in run.names.items()},
        paths={renamed_id(key, names): tuple(map(now, paths)) for key, paths in run.own_paths.items()},
        plans={
            renamed_id(key, names): (_plan(plan, names), [_seeing(each, names) for each in seen])
            for key, (plan, seen) in run.plans.items()
        },
        kept=frozenset(renamed_id(key, names) for key in run.kept),
        options=run.options,
        snapshot=_snapshot(run.snapshot, names),
        base=None,
        is_partial=run.is_partial,
        answers=None if run.answers is None else run.answers.renamed(names),
        hints=run.hints,
    )


def _now(names: Names) -> Callable[[str], str]:
    return lambda path: names.get(path, path)


def _plan(plan: Plan, names: Names) -> Plan:
    now = _now(names)
    asked = frozenset(map(now, plan.regions.asked))
    return replace(
        plan,
        blockers=tuple(map(now, plan.blockers)),
        looked=tuple(sorted(map(now, plan.looked))),
        regions=replace(plan.regions, asked=asked),
    )


def _seeing(seeing: Seeing, names: Names) -> Seeing:
    now = _now(names)
    return replace(seeing, path=now(seeing.path), out=tuple(map(now, seeing.out)))


def _snapshot(snapshot: Snapshot, names: Names) -> Snapshot:
    now = _now(names)
    return replace(
        snapshot,
        parts={now(key): each for key, each in snapshot.parts.items()},
        held={now(key): _held(each, names) for key, each in snapshot.held.items()},
    )


def _held(held: Held, names: Names) -> Held:
    now = _now(names)
    return Held(_facts(held.facts, names), frozenset(map(now, held.joins)), tuple(map(now, held.mates)))


def _facts(facts: str, names: Names) -> str:
    """`Held.facts` with other paths."""
    # Those of a fastener begin with two texts, others with the kind of the hold and a list.
    is_fastener = len(_TEXT.findall(facts[: facts.find("[", 1)])) == _OF_FASTENER
    kept = _OF_HOLD + (_OF_FASTENER if is_fastener else 0)
    count = 0

    def now(found: re.Match[str]) -> str:
        nonlocal count
        count += 1
        text = ast.literal_eval(found[0])
        return found[0] if count <= kept else repr(names.get(text, text))

    return _TEXT.sub(now, facts)
