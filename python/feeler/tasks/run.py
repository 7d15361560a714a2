"""`Maintenance`: the rows of a nightly run, their differences to the last one, and the files that they go into."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, overload

import numpy as np

from feeler.arguments import check_path, check_word
from feeler.atomic import atomic_file
from feeler.choices import MAINTAIN_FAULTS, MaintainFault
from feeler.errors import LoadError, MissingFileError, WriteError
from feeler.io.text import text_of
from feeler.tasks.digests import short
from feeler.tasks.night_rows import MaintainRow, Plan, Seeing
from feeler.tasks.run_files import write_html, write_xlsx
from feeler.tasks.snapshots import Changes, MaintainChange, Snapshot
from feeler.tasks.steps import clock
from feeler.tasks.stored_answers import ENDING, StoredAnswers
from feeler.words import plural

SAME_S = 0.05
"""Differences below are none, seconds."""
SAME_SIGHT = 0.02
"""And below this share."""
FORMAT = "feeler maintain 1"
_NAMED = 3
_RUNS = {"version", "search"}
"""Options that no table gives."""


Plans = Mapping[str, tuple[Plan, list[Seeing]]]


class Maintenance(Sequence[MaintainRow]):
    """The rows of `maintain`, in the order of its list."""

    def __init__(
        self,
        names: Mapping[str, str],
        paths: Mapping[str, tuple[str, ...]],
        plans: Plans,
        kept: frozenset[str],
        options: Mapping[str, str],
        snapshot: Snapshot,
        base: Maintenance | None,
        is_partial: bool,
        answers: StoredAnswers | None = None,
        hints: Sequence[str] = (),
        renamed: Mapping[str, str] = MappingProxyType({}),
        retimed: frozenset[str] = frozenset(),
    ) -> None:
        """As `maintain` makes it. Keys of plans: the paths, kept parts and people of each row."""
        self.answers = answers
        """What the next run need not ask again."""
        self.hints = tuple(hints)
        """What kept answers of the last run from being used, and how its parts were recognised if paths changed."""
        self.renamed = dict(renamed)
        """The path in the last run of each part that has another one now, by its path now."""
        self.retimed = retimed
        """Those of them for which the table of times has other entries."""
        self.names, self.own_paths, self.plans, self.kept = dict(names), dict(paths), plans, kept
        self.options, self.snapshot, self.is_partial = dict(options), snapshot, is_partial
        self.base = None if base is None else base._alone()
        """The run that it is compared with."""
        self.changes: tuple[MaintainChange, ...] = ()
        """What changed of the parts since then."""
        changes = None if base is None else Changes(base.snapshot, snapshot, retimed=retimed)
        if changes is not None:
            self.changes = tuple(changes)
        self._rows = tuple(self._row(key, changes) for key in plans)

    def _alone(self) -> Maintenance:
        """The run without what it is compared with."""
        if self.base is None:
            return self
        rest = (self.kept, self.options, self.snapshot, None, self.is_partial, self.answers)
        return Maintenance(self.names, self.own_paths, self.plans, *rest, renamed=self.renamed)

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> MaintainRow: ...
    @overload
    def __getitem__(self, index: slice) -> list[MaintainRow]: ...
    def __getitem__(self, index: int | slice) -> MaintainRow | list[MaintainRow]:
        return list(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[MaintainRow]:
        return iter(self._rows)

    def __repr__(self) -> str:
        return f"Maintenance({self.said})"

    @property
    def said(self) -> str:
        """The result in a sentence."""
        out, kept = sum(row.state == "out" for row in self), sum(row.is_kept for row in self)
        text = f"{out:,} of {len(self):,} come out"
        if self.base is not None:
            text += f", {sum(bool(row.change) for row in self):,} changed, {kept:,} kept"
        if self.renamed:
            text += f", {plural(len(self.renamed), 'part')} renamed"
        missing = len(self.names) - len(self)
        return text + (f", interrupted: {plural(missing, 'row')} missing" if self.is_partial else "")

    @property
    def by_change(self) -> list[MaintainRow]:
        """The rows, those first that are new in some way: worse, better, otherwise."""
        return sorted(self, key=_rank)

    def failing(self, word: MaintainFault) -> list[MaintainRow]:
        """The rows that are "slower" than in the last run (or came out then alone), "blocked", "unreachable" (blocked,
        as no tool reaches a fastener), have "hidden" fasteners, or "failed". Raises `OptionError` for other words."""
        tests: dict[MaintainFault, Callable[[MaintainRow], bool]] = {
            "slower": lambda row: row.is_slower,
            "blocked": lambda row: row.state == "blocked",
            "unreachable": lambda row: row.is_unreachable,
            "hidden": lambda row: bool(row.hidden),
            "failed": lambda row: row.state == "failed",
        }
        test = tests[check_word("word", word, MAINTAIN_FAULTS)]
        return [row for row in self if test(row)]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the run as JSON, for `previous` of the next one, and its answers beside it. Raises `WriteError`."""
        data, answers = packed(self)
        if answers is not None:
            with atomic_file(_beside(path)) as file:
                file.write(answers)
        with atomic_file(path, ".json") as file:
            file.write(json.dumps(data, allow_nan=False).encode("utf-8", errors="replace"))

    def to_dict(self) -> dict[str, Any]:
        """As JSON: the rows, and what the next run needs."""
        data = {
            "format": FORMAT,
            "said": self.said,
            "is_partial": self.is_partial,
            "rows": [row.to_dict() for row in self],
            "changes": [change.to_dict() for change in self.changes],
            "renamed": self.renamed,
            "retimed": sorted(self.retimed),
            "options": self.options,
            "names": self.names,
            "paths": {key: list(paths) for key, paths in self.own_paths.items()},
            "plans": {key: [p.to_dict(), [s.to_dict() for s in seen]] for key, (p, seen) in self.plans.items()},
            "snapshot": self.snapshot.to_dict(),
        }
        # The next run goes on with an interrupted one, and counts its differences from the one before.
        return data if self.base is None or not self.is_partial else {**data, "base": self.base.to_dict()}

    @classmethod
    def _from_dict(cls, data: Mapping[str, Any]) -> Maintenance:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError`, `AttributeError` for other data."""
        if data["format"] != FORMAT:
            raise ValueError(f"its format is {data['format']!r}, not {FORMAT!r}")
        base = data.get("base")
        return cls(
            {str(key): str(name) for key, name in data["names"].items()},
            {str(key): tuple(map(str, paths)) for key, paths in data["paths"].items()},
            {
                str(key): (Plan.from_dict(plan), [Seeing.from_dict(each) for each in seen])
                for key, (plan, seen) in data["plans"].items()
            },
            frozenset(),
            {str(name): str(value) for name, value in data["options"].items()},
            Snapshot.from_dict(data["snapshot"]),
            None if base is None else cls._from_dict(base),
            bool(data["is_partial"]),
            renamed={str(now): str(then) for now, then in data.get("renamed", {}).items()},
            retimed=frozenset(map(str, data.get("retimed", []))),
        )

    def to_html(self, path: str | os.PathLike[str]) -> None:
        """Writes a page with the rows, changed ones first. It loads nothing. Raises `WriteError`."""
        write_html(path, self.said, self.by_change, self.changes, self.is_partial, self.renamed)

    def to_xlsx(self, path: str | os.PathLike[str]) -> None:
        """Writes a workbook: rows, changes and renamed parts. Needs `feeler[xlsx]`. Raises `WriteError`,
        `OptionError`."""
        write_xlsx(path, self.by_change, self.changes, self.renamed)

    def _row(self, key: str, changes: Changes | None) -> MaintainRow:
        plan, seen = self.plans[key]
        shares = [each.share for each in seen]
        sight = math.fsum(shares) / len(shares) if shares else math.nan
        delta, is_slower, text, causes = self._compared(key, sight, changes)
        return MaintainRow(
            name=self.names.get(key, key),
            paths=self.own_paths.get(key, ()),
            state=plan.state,
            seconds=plan.seconds,
            low=plan.low,
            high=plan.high,
            steps=plan.steps,
            undone=plan.undone,
            tools=plan.tools,
            reach_deg=plan.reach_deg,
            sight=sight,
            hidden=tuple(each.path for each in seen if each.share == 0.0),
            is_unreachable=plan.is_unreachable,
            blockers=plan.blockers,
            said=plan.said,
            error=plan.error,
            is_kept=key in self.kept,
            delta=delta,
            is_slower=is_slower,
            change=text,
            causes=causes,
            renamed_from=tuple(self.renamed[each] for each in self.own_paths.get(key, ()) if each in self.renamed),
        )

    def _compared(
        self, key: str, sight: float, changes: Changes | None
    ) -> tuple[float, bool, str, tuple[MaintainChange, ...]]:
        """Seconds more than in the last run, whether that is slower, what is new, and which changes it is from."""
        if self.base is None or changes is None:
            return math.nan, False, "", ()
        then = key if key in self.base.plans else self._entry_before(key, self.base)
        if then is None:
            return math.nan, False, "new in the list", ()
        now, (old, seen) = self.plans[key][0], self.base.plans[then]
        delta = now.seconds - old.seconds
        is_slower = delta > SAME_S or (old.is_out and not now.is_out)
        before = math.fsum(each.share for each in seen) / len(seen) if seen else math.nan
        said = _differences(old, now, delta, before, sight)
        if not said:
            return delta, is_slower, "", ()
        causes = _causes(old, now, changes)
        if not causes and delta == 0.0:  # what is seen
            around = [np.array(each.box).reshape(2, 3) for each in (*seen, *self.plans[key][1])]
            there = {change.path for box in around for change in changes.within(box[0], box[1])}
            causes = tuple(each for each in changes if each.path in there)
        text = ", ".join(said)
        if causes:
            named = [f"{each.path.split('/')[-1]} {str(each)[len(each.path) + 1 :]}" for each in causes[:_NAMED]]
            more = [f"{len(causes) - _NAMED} more"] if len(causes) > _NAMED else []
            text += f" since {_listed([*named, *more, *_given(self.base.options, self.options)])}"
        elif given := _given(self.base.options, self.options):
            text += f" since {_listed(given)}"
        return delta, is_slower, text, causes

    def _entry_before(self, key: str, base: Maintenance) -> str | None:
        """The row of the same entry of the list in a run before: of an assembly that lost or gained parts."""
        now = _common(key, base.snapshot.parts)
        for then in base.plans:
            is_free = then not in self.plans and base.names.get(then) == self.names.get(key)
            if is_free and now is not None and _common(then, self.snapshot.parts) == now:
                return then
        return next((then for then in base.plans if self._is_named(then, key, base)), None)

    def _is_named(self, then: str, key: str, base: Maintenance) -> bool:
        """Whether a row before is of the same paths: parts have changed their places, and the list names paths."""
        before, now = (_common(each, _Every()) for each in (then, key))
        if before is None or now is None or then in self.plans or base.names.get(then) != self.names.get(key):
            return False
        parts, keep = ({self.renamed.get(each, each) for each in some} for some in before[:2])
        return (parts, keep, before[2]) == now


class MaintenanceInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.maintenance` has the rows finished by then."""

    def __init__(self, maintenance: Maintenance) -> None:
        self.maintenance = maintenance
        super().__init__(f"interrupted: {maintenance!r}")

    def __reduce__(self) -> tuple[type[MaintenanceInterrupted], tuple[Maintenance]]:
        return (type(self), (self.maintenance,))


def packed(run: Maintenance) -> tuple[dict[str, Any], bytes | None]:
    """A run as JSON, and its answers: what files and projects keep of it."""
    data = run.to_dict()
    return (data, None) if run.answers is None else ({**data, "answers": run.answers.digest}, run.answers.data)


def unpacked(data: object, answers: bytes | None, where: object) -> Maintenance:
    """What `packed` gave, where its answers are missing or damaged with a hint. where: they are.

    Raises `ValueError` for other data.
    """
    try:
        if not isinstance(data, dict):
            raise ValueError("it is a list or a single value")
        run = Maintenance._from_dict(data)
    except KeyError as error:
        raise ValueError(f"{error} is missing") from None
    except (TypeError, AttributeError, OverflowError, RecursionError):
        raise ValueError("a value in it is of another kind") from None
    if "answers" in data:
        try:
            if answers is None:
                raise ValueError("they are missing")
            if short(answers) != data["answers"]:
                raise ValueError("they are damaged, or of another run")
            run.answers = StoredAnswers(list(run.snapshot.parts), answers)
        except ValueError as error:
            run.hints = (f"The answers in {where} are not used: {error}. Rows that changed are computed in full.",)
    return run


def load_maintenance(path: str | os.PathLike[str]) -> Maintenance:
    """Reads what `Maintenance.save` wrote. Raises `LoadError`, and `OptionError` for what is no path."""
    file = check_path("path", path)
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: leave it out of the first run") from None
    beside = _beside(file)
    try:
        answers = beside.read_bytes()
    except OSError:
        answers = None
    try:
        return unpacked(json.loads(text), answers, beside)
    except (ValueError, RecursionError) as error:
        raise LoadError(f"{file} is no run of feeler maintain: {error}; give a file that --save wrote") from None


def _beside(path: str | os.PathLike[str]) -> Path:
    file = check_path("path", path, WriteError)
    return file.with_name(file.name + ENDING)


def _given(old: Mapping[str, str], new: Mapping[str, str]) -> list[str]:
    """Which options are others, in words."""
    names = [name for name, value in new.items() if old.get(name) != value]
    said = [f"other {_listed([name for name in names if name not in _RUNS])} were given"] if set(names) - _RUNS else []
    said += ["another version of feeler runs"] if "version" in names else []
    said += ["the search has other limits"] if "search" in names else []
    return said


class _Every:
    """Contains all."""

    def __contains__(self, _: object) -> bool:
        return True


def _common(key: str, there: Container[str]) -> tuple[set[str], set[str], int] | None:
    """Of a key of rows the wanted and kept parts that are in another run, too, and the people; None if it is no key."""
    try:
        (parts, keep, people), _ = json.JSONDecoder().raw_decode(key)
        return {each for each in parts if each in there}, {each for each in keep if each in there}, int(people)
    except (TypeError, ValueError):
        return None


def _listed(words: Sequence[str]) -> str:
    return " and ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), *words[-1:]])


def _differences(old: Plan, now: Plan, delta: float, before: float, sight: float) -> list[str]:
    said = []
    if old.state != now.state:
        said.append({"out": "comes out", "blocked": "blocked", "failed": "failed"}[now.state])
    elif abs(delta) > SAME_S:
        said.append(f"{'+' if delta > 0.0 else '-'}{clock(abs(delta))}")
    elif now.is_out and (old.tools, old.steps) != (now.tools, now.steps):
        said.append("other steps")
    elif not now.is_out and (old.is_unreachable, old.blockers) != (now.is_unreachable, now.blockers):
        said.append("blocked otherwise")
    if abs(sight - before) > SAME_SIGHT:
        said.append(f"seen {before:.0%} -> {sight:.0%}")
    return said


def _causes(old: Plan, now: Plan, changes: Changes) -> tuple[MaintainChange, ...]:
    """The changes that the steps looked at, then and now; else those that bear on the row."""
    looked = {*old.looked, *now.looked, *old.blockers, *now.blockers}
    found = [each for each in changes if each.path in looked]
    if not found and not changes.is_beyond:
        known = {each.path for plan in (old, now) for each in changes.bearing_on(plan.regions)}
        found = [each for each in changes if each.path in known]
    if not found and changes.is_beyond:
        found = list(changes)
    return tuple(sorted(found, key=lambda each: each.what == "is held otherwise"))


def _rank(row: MaintainRow) -> tuple[int, float]:
    delta = 0.0 if math.isnan(row.delta) else row.delta
    if row.state == "failed":
        return 0, 0.0
    if row.is_slower:
        return (1, 0.0) if row.state != "out" else (2, -delta)
    if row.change:
        return 3, delta
    return 4, 0.0
