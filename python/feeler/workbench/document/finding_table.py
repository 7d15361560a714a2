"""The findings of a clash check as columns: a hundred thousand of them, read from any source, immutable.

Tables are made of `feeler.Clashes`, or of JSON in the format of `feeler clash --json`:

    {"version": 1, "clashes": [{"id", "a", "b", "verdict", "depth", "depth_kind", "gap", "point_a", "point_b", "rule",
                                "status", "note", "group"}]}

Lengths are metres; `a` and `b` are part paths. Reading is tolerant: fields may be missing, and unknown ones are kept.
The document has what people do with the findings (`document.Findings`); pages fetch the rows once (`message`).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from feeler.choices import STATUSES, Status, VerdictName
from feeler.clashes import Clashes, Verdict
from feeler.clashes.table import SHAPES, Columns, Facts
from feeler.clashes.tracking import APPROVAL, Found, Mark, approval_of_json, approved, part_keys
from feeler.clashes.verdict import DEPTH_KINDS, SEVERITIES
from feeler.errors import LoadError
from feeler.mockup import Mockup
from feeler.parts import Parts
from feeler.workbench.document.frames import pack
from feeler.workbench.document.protocol_findings import FindingRows
from feeler.workbench.document.values import is_number, is_sequence

VERSION = 1
STATUS = STATUSES
TOUCHING = ("touching", "touch", "contact")
"""Verdicts of parts in contact."""
DUPLICATE = "duplicate"
"""The verdict of parts that have the same surface; their depth is 0."""
KINDS = ("", "measured", "estimate", "bound", "exact")
"""Kinds of depth; empty: not stated. A bound is the length of a translation: the depth is at most that."""
_NO_PART = 2**32 - 1
_KNOWN = {
    *("id", "a", "b", "verdict", "depth", "depth_error", "depth_kind", "translation", "gap", "point_a", "point_b"),
    *("volume", "triangles", "box", "open", "rule", "severity", "status", "by", "note", "changed", *APPROVAL),
    "group",
}
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class FindingTable:
    """Findings, the worst first. Rows are numbered from 0 on.

    ids: of the findings, unique. paths: the keys of the parts that they name, and `part_of_path` the mock-up's part of
    each, -1 for none. a, b: `(n,)` indices into `paths`. verdict, rule, group: indices into `verdicts`, `rules` and
    `groups`. severity, status, depth_kind: into `SEVERITIES`, `STATUS` and `KINDS`. depth, depth_error, gap, volume:
    `(n,)` metres and cubic metres, NaN if not known. point_a, point_b, translation: `(n, 3)`. box: `(n, 2, 3)`.
    marks: who set a status and why, by id; only ids that have one. hidden: how many findings each exclusion hid.
    extras: fields of a row that this feeler does not know. facts: the head of the file.
    """

    ids: tuple[str, ...]
    paths: tuple[str, ...]
    part_of_path: npt.NDArray[np.int32]
    a: Ints
    b: Ints
    verdicts: tuple[str, ...]
    verdict: Ints
    rules: tuple[str, ...]
    rule: Ints
    groups: tuple[str, ...]
    group: Ints
    severity: npt.NDArray[np.uint8]
    status: npt.NDArray[np.uint8]
    depth_kind: npt.NDArray[np.uint8]
    depth: Floats
    depth_error: Floats
    gap: Floats
    volume: Floats
    translation: Floats
    point_a: Floats
    point_b: Floats
    box: Floats
    triangles: Ints
    is_open: npt.NDArray[np.bool_]
    marks: Mapping[str, Mark] = field(default_factory=lambda: MappingProxyType({}))
    hidden: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    extras: Mapping[int, Mapping[str, Any]] = field(default_factory=lambda: MappingProxyType({}))
    facts: Facts = field(default_factory=Facts)

    def __len__(self) -> int:
        return len(self.ids)

    @cached_property
    def key(self) -> str:
        """A digest of the content, 16 hex digits: the address of the rows."""
        found = hashlib.sha256()
        for each in fields(self):
            if each.name == "facts":
                continue
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                found.update(np.ascontiguousarray(value).data)
            elif isinstance(value, tuple):
                found.update(json.dumps(value).encode())
            else:
                found.update(repr(sorted(value.items()) if isinstance(value, Mapping) else value).encode())
        return found.hexdigest()[:16]

    @cached_property
    def row_of(self) -> Mapping[str, int]:
        """The row of each id."""
        return {each: row for row, each in enumerate(self.ids)}

    @cached_property
    def is_touching(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether the parts only touch."""
        return np.array([each in TOUCHING for each in self.verdicts] or [False])[self.verdict]

    @cached_property
    def placed(self) -> npt.NDArray[np.intp]:
        """The rows with both parts in this mock-up: those of `clashes`, in order."""
        if not len(self):
            return np.zeros(0, np.intp)
        known = self.part_of_path
        return np.flatnonzero((known[self.a] >= 0) & (known[self.b] >= 0))

    @property
    def counts(self) -> dict[str, int]:
        """The number of findings of each verdict."""
        found = np.bincount(self.verdict, minlength=len(self.verdicts))
        return {name: int(count) for name, count in zip(self.verdicts, found, strict=True) if count}

    def status_of(self, name: str) -> str:
        """The status of a finding when the table was made."""
        word: str = STATUS[int(self.status[self.row_of[name]])]
        return word

    def note_of(self, name: str) -> str:
        """The note of a finding when the table was made."""
        return self.marks[name].note if name in self.marks else ""

    def mark_of(
        self, name: str, status: Mapping[str, str], notes: Mapping[str, str], authors: Mapping[str, str]
    ) -> Mark:
        """The mark of a finding, with the statuses and notes that people set since, and who they are: by the finding's
        id."""
        row = self.row_of[name]
        was: Status = STATUS[self.status[row]]
        before = self.marks.get(name, Mark(was))
        word = cast("Status", status.get(name, was))
        # The person and the approval belong to the status of then.
        by = authors.get(name, before.by if word == was else "")
        mark = replace(before, status=word, note=notes.get(name, before.note), by=by)
        if word != "approved":
            return approved(mark, None)
        return mark if word == was and mark.approved_depth is not None else approved(mark, self.found(row))

    def found(self, row: int) -> Found:
        """What `Clashes.diff` compares of a row."""
        verdict = _known_verdict(self.verdicts[self.verdict[row]])
        return Found(_signed(self.depth[row], self.gap[row]), float(self.depth_error[row]), verdict)

    def rows(self, chosen: npt.NDArray[Any], hidden: Mapping[str, int] | None = None) -> FindingTable:
        """Some of the rows, by a mask or by numbers."""
        numbers = np.flatnonzero(chosen) if chosen.dtype == bool else chosen
        made = {name: getattr(self, name)[numbers] for name in _PER_ROW}
        place = {int(old): new for new, old in enumerate(numbers)}
        ids = tuple(self.ids[row] for row in numbers.tolist())
        kept = replace(
            self,
            ids=ids,
            marks={name: self.marks[name] for name in ids if name in self.marks},
            extras={place[row]: each for row, each in self.extras.items() if row in place},
            hidden=self.hidden if hidden is None else hidden,
            **made,
        )
        return _canonical(kept)

    def message(self) -> FindingRows:
        """The rows for a page."""
        count = len(self)
        words = {
            **{"ids": self.ids, "paths": self.paths, "verdicts": self.verdicts, "rules": self.rules},
            **{"groups": self.groups, "notes": {name: mark.note for name, mark in self.marks.items() if mark.note}},
        }
        part = np.where(self.part_of_path < 0, _NO_PART, self.part_of_path).astype(np.uint32)
        codes = np.stack([self.severity, self.status, self.depth_kind, self.is_touching.astype(np.uint8)], axis=1)
        return FindingRows(
            version=self.key,
            words=np.frombuffer(json.dumps(words).encode(), np.uint8),
            part_of_path=part,
            pairs=np.stack([self.a, self.b], axis=1).reshape(count, 2),
            labels=np.stack([self.verdict, self.rule, self.group], axis=1).reshape(count, 3),
            codes=codes.reshape(count, 4),
            sizes=np.stack([self.depth, self.depth_error, self.gap, self.volume], axis=1).astype(np.float32),
            places=np.concatenate([self.point_a, self.point_b, self.translation], axis=1).astype(np.float32),
        )

    def frame(self) -> bytes:
        """The message, packed."""
        packed = pack(self.message())
        assert isinstance(packed, bytes), "it has arrays"
        return packed

    def to_json(self) -> dict[str, Any]:
        """The table in the format that `table_of` reads: an equal table comes back."""
        return {**self.facts_json(), "clashes": [self.row_json(row) for row in range(len(self))]}

    def facts_json(self) -> dict[str, Any]:
        """The same without the rows."""
        facts = self.facts
        return {
            "version": VERSION,
            "clearance": facts.clearance,
            "contact": facts.contact,
            "parts": facts.parts,
            "triangles": facts.triangles,
            "files": list(facts.files),
            "hidden": dict(self.hidden),
        }

    def row_json(self, row: int) -> dict[str, Any]:
        """A row as JSON, without what is not known of it."""
        return {key: value for key, value in self.whole_row_json(row).items() if value not in (None, "")}

    def whole_row_json(self, row: int) -> dict[str, Any]:
        """A row as `Clashes.save` writes it."""
        name = self.ids[row]
        mark = self.marks.get(name, Mark())
        return {
            **self.extras.get(row, {}),
            "id": name,
            "a": self.paths[self.a[row]],
            "b": self.paths[self.b[row]],
            "rule": self.rules[self.rule[row]],
            "verdict": self.verdicts[self.verdict[row]],
            "severity": SEVERITIES[self.severity[row]],
            "status": STATUS[self.status[row]],
            "by": mark.by,
            "note": mark.note,
            **{name: getattr(mark, name) for name in APPROVAL},
            "changed": mark.changed,
            "depth": _number(self.depth[row]),
            "depth_error": _number(self.depth_error[row]),
            "depth_kind": KINDS[self.depth_kind[row]],
            "translation": _numbers(self.translation[row]),
            "gap": _number(self.gap[row]),
            "point_a": _numbers(self.point_a[row]),
            "point_b": _numbers(self.point_b[row]),
            "volume": _number(self.volume[row]),
            "triangles": int(self.triangles[row]),
            "box": None if np.isnan(self.box[row]).any() else self.box[row].tolist(),
            "open": self.is_open[row].tolist(),
            "group": self.groups[self.group[row]],
        }

    def clashes(self, mockup: Mockup, mark_of: Callable[[str], Mark]) -> Clashes:
        """The findings of this mock-up's parts with their marks by id, for `feeler.clashes`. Others are left out."""
        files = mockup.source.files or self.facts.files
        return self._clashes(self.placed, self.part_of_path, mockup.part_paths, files, mark_of)

    def named_clashes(self, keys: Sequence[str], mark_of: Callable[[str], Mark]) -> Clashes:
        """All findings with their marks by id, for `Clashes.diff`. keys: of the mock-up's parts; others keep theirs."""
        number: dict[str, int] = {}
        names = (keys[part] if part >= 0 else path for part, path in zip(self.part_of_path, self.paths, strict=True))
        known = np.array([number.setdefault(name, len(number)) for name in names], np.uint32)
        return self._clashes(np.arange(len(self)), known, [*number], self.facts.files, mark_of)

    def _clashes(
        self,
        kept: npt.NDArray[np.intp],
        known: npt.NDArray[Any],
        paths: Sequence[str],
        files: tuple[str, ...],
        mark_of: Callable[[str], Mark],
    ) -> Clashes:
        """Some rows. known: the number of each of `self.paths` among these paths."""
        codes = np.array([_CODES.get(word, Verdict.CLASH.code) for word in self.verdicts] or [0])
        values = {
            "a": known[self.a[kept]],
            "b": known[self.b[kept]],
            "verdict": codes[self.verdict[kept]],
            "depth_kind": np.array([0, 0, 1, 1, 1])[self.depth_kind[kept]],
            **{name: getattr(self, name)[kept] for name in SHAPES if name not in ("a", "b", "verdict", "depth_kind")},
        }
        columns = Columns(
            **{name: np.array(values[name], kind).reshape(-1, *shape) for name, (kind, shape) in SHAPES.items()}
        )
        hidden = tuple(self.hidden.items())
        made = Clashes(columns, paths, self.rules, facts=replace(self.facts, files=files, hidden=hidden))
        names = zip(made.ids, kept.tolist(), strict=True)
        made.marks.replace({now: mark_of(self.ids[row]) for now, row in names})
        return made


_PER_ROW = tuple(
    each.name
    for each in fields(FindingTable)
    if each.name
    not in ("ids", "paths", "part_of_path", "verdicts", "rules", "groups", "marks", "hidden", "extras", "facts")
)
_CODES = {**dict.fromkeys(TOUCHING, Verdict.CONTACT.code), **{each.value: each.code for each in Verdict}}
"""The number of the verdict that a word means; other words mean a clash."""


def table_of(data: Any, parts: Parts, absent: Collection[int] = (), where: str = "findings") -> FindingTable:
    """The table of findings in JSON. Raises `LoadError` if there is no list of them.

    absent: parts excluded from the scene; findings list them, but the page cannot show them.
    """
    given = [each for each in clashes_in(data, where) if isinstance(each, Mapping)]
    reader = _Reader(parts, absent)
    for number, each in enumerate(given):
        reader.add(number, each)
    return reader.table(data)


def lacking(table: FindingTable, parts: Parts) -> list[int]:
    """Rows of `table.paths` that are no part of the mock-up, not even one that was left out of the scene."""
    reader = _Reader(parts, ())
    unknown = np.flatnonzero(table.part_of_path < 0).tolist()
    return [row for row in unknown if table.paths[row] and reader.part(table.paths[row]) < 0]


def table_of_clashes(clashes: Clashes, mockup: Mockup, absent: Collection[int] = ()) -> FindingTable:
    """The table of a check of this mock-up."""
    c = clashes.columns
    group_of = np.zeros(len(clashes), np.uint32)
    names = []
    for number, group in enumerate(clashes.groups("part")):
        names.append(group.name)
        group_of[group.rows] = number
    marks = {each: mark for each in clashes.ids if (mark := clashes.marks.of(each)) != Mark(mark.status)}
    known = np.arange(mockup.part_count, dtype=np.int32)
    known[list(absent)] = -1
    table = FindingTable(
        ids=clashes.ids,
        paths=tuple(clashes.keys),
        part_of_path=known,
        a=c.a,
        b=c.b,
        verdicts=tuple(each.value for each in Verdict),
        verdict=c.verdict.astype(np.uint32),
        rules=clashes.rule_names,
        rule=c.rule.astype(np.uint32),
        groups=tuple(names) or ("",),
        group=group_of,
        severity=c.severity,
        status=np.array([STATUS.index(each) for each in clashes.statuses.tolist()], np.uint8),
        depth_kind=np.array([KINDS.index(each) for each in DEPTH_KINDS], np.uint8)[c.depth_kind],
        **{name: getattr(c, name) for name in ("depth", "depth_error", "gap", "volume", "translation")},
        **{name: getattr(c, name) for name in ("point_a", "point_b", "box", "triangles", "is_open")},
        marks=marks,
        hidden=clashes.hidden,
        facts=clashes.facts,
    )
    return _canonical(table)


def _canonical(table: FindingTable) -> FindingTable:
    """The same table with its words in the order in which the rows name them, so that equal tables have equal keys."""
    words, pairs = _in_order(np.stack([table.a, table.b], axis=1).ravel())
    verdicts, verdict = _in_order(table.verdict)
    rules, rule = _in_order(table.rule)
    groups, group = _in_order(table.group)
    pairs = pairs.reshape(-1, 2)
    return replace(
        table,
        paths=tuple(table.paths[word] for word in words),
        part_of_path=table.part_of_path[words],
        a=np.ascontiguousarray(pairs[:, 0]),
        b=np.ascontiguousarray(pairs[:, 1]),
        verdicts=tuple(table.verdicts[word] for word in verdicts),
        verdict=verdict,
        rules=tuple(table.rules[word] for word in rules),
        rule=rule,
        groups=tuple(table.groups[word] for word in groups),
        group=group,
    )


def _in_order(numbers: Ints) -> tuple[npt.NDArray[np.intp], Ints]:
    """The different numbers in the order in which they come, and for each number its place among them."""
    found, first, back = np.unique(numbers, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    place = np.empty(len(order), np.uint32)
    place[order] = np.arange(len(order))
    return found[order].astype(np.intp), place[back.reshape(-1)]


def clashes_in(data: Any, where: str) -> Sequence[Any]:
    """The list of findings. Raises `LoadError`."""
    found: Any = data.get("clashes") if isinstance(data, Mapping) else None
    if not is_sequence(found):
        raise LoadError(f'{where} holds no list "clashes": give findings of feeler clash --json')
    if data.get("version", VERSION) != VERSION:
        raise LoadError(f"{where} is of version {data.get('version')!r}: this feeler reads {VERSION}")
    return found  # type: ignore[no-any-return]


class _Words:
    """Texts, each once, with their numbers."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def of(self, text: str) -> int:
        return self.numbers.setdefault(text, len(self.numbers))


class _Reader:
    """Collects rows of JSON."""

    def __init__(self, parts: Parts, absent: Collection[int]) -> None:
        self._parts, self._absent = parts, {*absent}
        self._key = {key: part for part, key in enumerate(part_keys([each.path for each in parts]))}
        self._ids: dict[str, None] = {}
        self._paths, self._verdicts, self._rules, self._groups = _Words(), _Words(), _Words(), _Words()
        self._rows: list[tuple[Any, ...]] = []
        self._marks: dict[str, Mark] = {}
        self._extras: dict[int, Mapping[str, Any]] = {}

    def add(self, number: int, given: Mapping[str, Any]) -> None:
        a, b = (str(given.get(side, "")) for side in "ab")
        depth, gap = (_real(given.get(name)) for name in ("depth", "gap"))
        name = str(given.get("id", number))
        while name in self._ids:
            name += "'"
        self._ids[name] = None
        status, severity, kind = given.get("status"), given.get("severity"), given.get("depth_kind")
        row = (
            *(self._paths.of(a), self._paths.of(b)),
            self._verdicts.of(str(given.get("verdict") or _verdict(depth, gap))),
            self._rules.of(str(given.get("rule") or "")),
            self._groups.of(str(given.get("group") or f"{_folder(a)} and {_folder(b)}")),
            SEVERITIES.index(severity) if severity in SEVERITIES else 1,
            STATUS.index(status) if status in STATUS else 0,
            KINDS.index(kind) if kind in KINDS else 0,
            *(depth, _real(given.get("depth_error")), gap, _real(given.get("volume"))),
            *(_point(given.get(each)) for each in ("translation", "point_a", "point_b")),
            _box(given.get("box")),
            _whole(given.get("triangles")),
            _flags(given.get("open")),
        )
        self._rows.append(row)
        mark = Mark(
            STATUS[self._rows[-1][6]],
            _text(given.get("by")),
            _text(given.get("note")),
            changed=_text(given.get("changed")),
            **_approval(given),
        )
        if mark != Mark(mark.status):
            self._marks[name] = mark
        more = {key: value for key, value in given.items() if key not in _KNOWN}
        if more:
            self._extras[number] = more

    def table(self, data: Any) -> FindingTable:
        verdicts = [*self._verdicts.numbers]
        order = sorted(range(len(self._rows)), key=lambda row: _worst_first(self._rows[row], verdicts))
        ids = [*self._ids]
        columns = list(zip(*(self._rows[row] for row in order), strict=True)) or [()] * len(_ROW)
        made: dict[str, Any] = {
            name: np.array(column, kind).reshape(-1, *shape)
            for (name, (kind, shape)), column in zip(_ROW.items(), columns, strict=True)
        }
        read = FindingTable(
            ids=tuple(ids[row] for row in order),
            paths=tuple(self._paths.numbers),
            part_of_path=np.array([self.part(path) for path in self._paths.numbers], np.int32),
            verdicts=tuple(self._verdicts.numbers),
            rules=tuple(self._rules.numbers),
            groups=tuple(self._groups.numbers),
            marks=self._marks,
            hidden=_hidden(data.get("hidden")),
            extras={new: self._extras[old] for new, old in enumerate(order) if old in self._extras},
            facts=_facts(data),
            **made,
        )
        return _canonical(read)

    def part(self, path: str) -> int:
        """The number of a part in the scene, or -1."""
        part = self._key.get(path)
        if part is None:
            # Not by patterns or attributes: a path of another file is none of these.
            found = self._parts.find(path)
            if len(found) != 1:
                return -1
            part = found[0].index
        return -1 if part in self._absent else part


def _worst_first(row: tuple[Any, ...], verdicts: Sequence[str]) -> tuple[Any, ...]:
    """As `Columns.order`: by severity; then duplicates, parts that overlap, contacts, and parts that are apart."""
    verdict, depth, gap = verdicts[row[2]], row[8], row[10]
    # A part inside of another overlaps it, though their surfaces may be apart.
    rank = 0 if verdict == DUPLICATE else 2 if verdict in TOUCHING else 3 if gap > 0.0 and not depth > 0.0 else 1
    return (row[5], rank, 0.0 if math.isnan(depth) else -depth, 0.0 if math.isnan(gap) else gap)


_ROW: dict[str, tuple[type, tuple[int, ...]]] = {
    **{name: (np.uint32, ()) for name in ("a", "b", "verdict", "rule", "group")},
    **{name: (np.uint8, ()) for name in ("severity", "status", "depth_kind")},
    **{name: (np.float64, ()) for name in ("depth", "depth_error", "gap", "volume")},
    **{name: (np.float64, (3,)) for name in ("translation", "point_a", "point_b")},
    "box": (np.float64, (2, 3)),
    "triangles": (np.uint32, ()),
    "is_open": (np.bool_, (2,)),
}


def _hidden(given: Any) -> Mapping[str, int]:
    if not isinstance(given, Mapping):
        return {}
    return {str(name): int(count) for name, count in given.items() if is_number(count)}


def _facts(data: Mapping[str, Any]) -> Facts:
    contact, clearance = data.get("contact"), data.get("clearance")
    files = data.get("files")
    return Facts(
        clearance=float(clearance) if is_number(clearance) else 0.0,  # type: ignore[arg-type]
        contact="chord" if contact == "chord" else float(contact) if is_number(contact) else 0.0,  # type: ignore[arg-type]
        parts=_whole(data.get("parts")),
        triangles=_whole(data.get("triangles")),
        files=tuple(map(str, files)) if is_sequence(files) else (),  # type: ignore[arg-type]
    )


def _verdict(depth: float, gap: float) -> str:
    """The verdict of a finding that does not state one."""
    return TOUCHING[0] if not depth > 0.0 and gap == 0.0 else "clash"


def _signed(depth: float, gap: float) -> float:
    return -float(gap) if gap > 0.0 else float(depth) if math.isfinite(depth) else 0.0


def _known_verdict(word: str) -> VerdictName:
    """The verdict of feeler that a word means."""
    return Verdict(_CODES.get(word, Verdict.CLASH.code)).value


def _approval(given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `Mark` for the approval of a row; without what is invalid. Older files have no verdict in it."""
    try:
        found = approval_of_json(given)
    except ValueError:
        return {}
    if given.get("status") == "approved" and found["approved_depth"] is not None and not found["approved_verdict"]:
        found["approved_verdict"] = _known_verdict(_text(given.get("verdict")))
    return found


def _real(given: Any) -> float:
    return float(given) if is_number(given) else math.nan


def _whole(given: Any) -> int:
    return int(given) if isinstance(given, int) and not isinstance(given, bool) and 0 <= given < 2**32 else 0


def _text(given: Any) -> str:
    return given if isinstance(given, str) else ""


_NOWHERE = [math.nan] * 3


def _point(given: Any) -> list[float]:
    if is_sequence(given) and len(given) == 3 and all(is_number(each) for each in given):
        return [float(each) for each in given]
    return _NOWHERE


def _box(given: Any) -> list[list[float]]:
    corners = [_point(each) for each in given] if is_sequence(given) and len(given) == 2 else []
    return corners if len(corners) == 2 else [_NOWHERE, _NOWHERE]


def _flags(given: Any) -> list[bool]:
    is_two = is_sequence(given) and len(given) == 2 and all(isinstance(each, bool) for each in given)
    return list(given) if is_two else [False, False]


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _numbers(values: Iterable[float]) -> list[float] | None:
    found = [float(each) for each in values]
    return found if all(map(math.isfinite, found)) else None


def _folder(path: str) -> str:
    return path.rpartition("/")[0].rpartition("/")[2] or path or "parts"
