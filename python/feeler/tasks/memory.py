"""Answers of geometric questions, each with where it looked: a later run asks again only where something changed.

An answer follows from its question and from the parts that were in the scene where it looked. It is recalled where the
same parts, unmoved, are there, and no others.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.parts import PartNumber
from feeler.tasks.digests import short
from feeler.tasks.regions import GROWN_M, Columns, Regions, near
from feeler.tasks.snapshots import Changes, Snapshot

Bools = npt.NDArray[np.bool_]

_PART = "part"


@dataclass(frozen=True, eq=False)
class Answer:
    """One answer, in paths."""

    key: str
    """Of its question."""
    data: Any
    """As JSON, parts by path."""
    regions: Regions
    met: frozenset[str]
    """The parts that were in the scene where it looked."""
    missed: frozenset[str]
    """Those that would have been there, but were out."""

    @cached_property
    def name(self) -> str:
        """The same for the same question among the same parts."""
        said = repr((self.key, sorted(self.met)))
        return short(said.encode("utf-8", "surrogatepass"))

    def to_list(self, numbers: Mapping[str, int]) -> list[Any]:
        """As JSON, parts by number."""
        parts = [sorted(numbers[each] for each in some) for some in (self.met, self.missed)]
        return [self.key, self.data, self.regions.to_dict(), *parts]

    @classmethod
    def from_list(cls, data: Sequence[Any], paths: Sequence[str]) -> Answer:
        """What `to_list` gave. Raises `TypeError`, `ValueError`, `KeyError`, `IndexError` for other data."""
        key, answer, regions, met, missed = data
        if not isinstance(key, str) or min([0, *met, *missed]) < 0:
            raise ValueError("an answer has a text as its key, and parts by numbers of at least 0")
        parts = [frozenset(paths[number] for number in some) for some in (met, missed)]
        return cls(key, answer, Regions.from_dict(regions), *parts)


@dataclass(frozen=True, eq=False)
class _Known:
    """An answer, with parts by index."""

    answer: Answer
    met: npt.NDArray[np.intp]
    missed: npt.NDArray[np.intp]

    def holds(self, present: Bools) -> bool:
        """Whether a scene with these parts has the same parts where it looked."""
        return bool(present[self.met].all()) and not present[self.missed].any()


def named_again(answer: Answer, names: Mapping[str, str]) -> Answer:
    """An answer with other paths. names: the new one by the one that it has; others stay."""
    met, missed, asked = (
        frozenset(names.get(each, each) for each in some) for some in (answer.met, answer.missed, answer.regions.asked)
    )
    return Answer(answer.key, _renamed(answer.data, names), replace(answer.regions, asked=asked), met, missed)


def _renamed(data: Any, names: Mapping[str, str]) -> Any:
    """Data as `Memory.plain` gives it, with other paths."""
    if isinstance(data, dict):
        return {_PART: names.get(data[_PART], data[_PART])}
    return [_renamed(each, names) for each in data] if isinstance(data, list) else data


class Memory:
    """The answers that rows of a run share. It is used by many threads. Its pickle is without answers."""

    def __init__(self, keys: Sequence[str], snapshot: Snapshot, answers: Iterable[Answer] = ()) -> None:
        """keys: the path of each part of the mock-up, as `keys_of`; snapshot: those that are in the scene."""
        self._keys = list(keys)
        self._index = {key: part for part, key in enumerate(self._keys)}
        self._digests = {key: each.digest for key, each in snapshot.parts.items()}
        self._parts = list(snapshot.parts)
        twice = Counter(self._digests.values())
        self._own = {
            key: ("", digest) if twice[digest] == 1 else (key, digest) for key, digest in self._digests.items()
        }
        """What questions call a part: its triangles and their place; with its path, where another one is equal."""
        seen = list(snapshot.parts.values())
        self._seen = seen
        bounds = np.array([each.box for each in seen]).reshape(-1, 2, 3)
        self._endless: Bools = np.logical_not(np.isfinite(bounds).all(axis=(1, 2)))
        self._boxes = Columns(bounds + GROWN_M * np.array([[-1.0], [1.0]]))
        self._known: dict[str, dict[str, _Known]] = {}
        self._lock = threading.Lock()
        self.take(answers)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in ("_lock", "_known")}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        vars(self).update(state)
        self._known, self._lock = {}, threading.Lock()

    def __iter__(self) -> Iterator[Answer]:
        """All answers."""
        for rows in list(self._known.values()):
            yield from (each.answer for each in rows.values())

    def key(self, kind: str, own: Sequence[int], facts: Any) -> str:
        """The key of a question. own: parts that it moves; facts: all else that it depends on but for the scene. It
        does not depend on paths."""
        said = repr((kind, [self._known_as(part) for part in own], self._plain(facts, self._known_as)))
        return short(said.encode("utf-8", "surrogatepass"))

    def paths_of(self, parts: Iterable[int]) -> list[str]:
        """The paths of parts, as they are known here."""
        return [self._keys[part] for part in parts]

    def _known_as(self, part: int) -> tuple[str, str]:
        """What questions call a part."""
        return self._own.get(self._keys[part], (self._keys[part], ""))

    def plain(self, data: Any) -> Any:
        """Data as JSON, parts by path."""
        return self._plain(data, self._keys.__getitem__)

    def _plain(self, data: Any, called: Callable[[int], Any]) -> Any:
        if isinstance(data, PartNumber):
            return {_PART: called(data)}
        if isinstance(data, (list, tuple)):
            return [self._plain(each, called) for each in data]
        if isinstance(data, np.ndarray):
            return data.tolist()
        if isinstance(data, (np.floating, np.integer, np.bool_)):
            return data.item()
        return data

    def told(self, data: Any) -> Any:
        """What `plain` was given, with lists. Raises `KeyError` for a part that is no more."""
        if isinstance(data, dict):
            return PartNumber(self._index[data[_PART]])
        return [self.told(each) for each in data] if isinstance(data, list) else data

    def find(self, key: str, present: Bools) -> list[Answer]:
        """The answers of a question that hold in a scene with these parts, the newest first."""
        rows = self._known.get(key)
        return [each.answer for each in reversed(list(rows.values())) if each.holds(present)] if rows else []

    def note(self, key: str, data: Any, regions: Regions, present: Bools) -> Answer:
        """Keeps the answer that was found in a scene with these parts."""
        there = list({*(self._parts[n] for n in self._within(regions)), *regions.asked})
        is_in = [bool(present[self._index[each]]) for each in there]
        met = frozenset(each for each, flag in zip(there, is_in, strict=True) if flag)
        answer = Answer(key, self.plain(data), regions, met, frozenset(there) - met)
        self.take([answer])
        return answer

    def take(self, answers: Iterable[Answer]) -> None:
        """Adds answers."""
        for answer in answers:
            known = _Known(answer, self._numbers(answer.met), self._numbers(answer.missed))
            with self._lock:
                rows = self._known.get(answer.key, {})
                # Others may go through it meanwhile.
                self._known[answer.key] = {**rows, answer.name: known}

    def _numbers(self, some: Iterable[str]) -> npt.NDArray[np.intp]:
        return np.array(sorted(self._index[each] for each in some), dtype=np.intp)

    def _within(self, regions: Regions) -> list[int]:
        """The parts that are where a question looked."""
        if regions.is_all:
            return list(range(len(self._parts)))
        return [n for n in self._near(regions) if regions.bear(self._seen[n].bounds, self._seen[n].boxes)]

    def _near(self, regions: Regions) -> list[int]:
        """The parts whose boxes are where a question looked."""
        found = self._endless.copy()
        for low, high in regions.around():
            found |= self._boxes.meeting(low, high)
        return [int(n) for n in np.flatnonzero(found)]


def carried(answers: Iterable[Answer], old: Snapshot, new: Snapshot, changes: Changes) -> Iterator[Answer]:
    """The answers of a run that can hold in the next one, as that one sees its parts."""
    if changes.is_other:
        return
    other = {
        key
        for key in old.parts.keys() | new.parts.keys()
        if (before := old.parts.get(key)) is None or (now := new.parts.get(key)) is None or before.digest != now.digest
    }
    moved = [(key, new.parts[key]) for key in sorted(other) if key in new.parts]
    left = [answer for answer in answers if not answer.met & other]
    bounds = np.array([each.box for _, each in moved]).reshape(-1, 2, 3)
    for answer, is_near in zip(left, near([each.regions for each in left], bounds), strict=True):
        come = {
            moved[n][0] for n in np.flatnonzero(is_near) if answer.regions.bear(moved[n][1].bounds, moved[n][1].boxes)
        }
        missed = frozenset((answer.missed - other) | come)
        same = missed == answer.missed
        yield answer if same else Answer(answer.key, answer.data, answer.regions, answer.met, missed)
