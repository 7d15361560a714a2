"""Saves findings as JSON and loads them.

    {"format": "feeler clash", "version": 1, "clearance": m, "contact": m or "chord", "least_contact": m, "parts": n,
     "triangles": n, "files": [...], "partial": bool, "notes": [...], "names": {...}, "clashes": [one a line],
     "earlier": [likewise], "shapes": [a part a line], "earlier_shapes": [likewise]}

A finding has the fields of `Clash`, with the keys of its parts instead of part numbers: a new part changes no other
line. Lines are sorted by rule and parts, so a git diff shows only changes. `feeler clash --json` has the same fields in
the order of the table; `feeler view` reads both. Shapes are stored for parts with findings and for parts with equal
paths; files without shapes can be read. Older files have no `depth_error`, and their depths are lengths of a
translation: `load_clashes` reads them as estimates and keeps approvals. Files without `approved_error` and
`approved_verdict` can be read: the largest error of a depth counts, and the verdict of the file. `names`
are of parts whose name is not the last step of the path; older files lack them. Shapes without `triangles`, `chord` and
`area_error` match within wider tolerances.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Generic

import numpy as np

from feeler.arguments import check_path
from feeler.atomic import atomic_file
from feeler.clashes.shapes import ARRAYS, PartShapes, Shapes, unknown
from feeler.clashes.table import SHAPES, AnyTable, Columns, Facts, Table
from feeler.clashes.tracking import (
    STATUSES,
    Mark,
    Marks,
    approval_json,
    approval_of_json,
    clash_id,
    part_keys,
)
from feeler.clashes.verdict import DEPTH_KINDS, SEVERITIES, Verdict
from feeler.errors import LoadError, MissingFileError
from feeler.io.text import text_of

FORMAT, VERSION = "feeler clash", 1
_OLD_KINDS = ("exact", "bound", "estimate")
"""Kinds of depth in files without `depth_error`: lengths of a translation. They are read as estimates."""
_LARGEST_M = 1e100
_TRIANGLE_PAIRS = 2**32
_HASH_DIGITS = 16


def head(clashes: Table) -> dict[str, Any]:
    """The fields before the findings."""
    facts = clashes.facts
    return {
        "format": FORMAT,
        "version": VERSION,
        "clearance": facts.clearance,
        "contact": facts.contact,
        "least_contact": facts.least_contact,
        "parts": facts.parts,
        "triangles": facts.triangles,
        "files": list(facts.files),
        "partial": clashes.is_partial,
        "hidden": clashes.hidden,
        "rules": [[name, *map(_number, limits)] for name, *limits in facts.rules],
        **({"notes": list(facts.notes)} if facts.notes else {}),
        **({"names": names} if (names := _names(clashes)) else {}),
    }


def _names(clashes: Table) -> dict[str, str]:
    """The names of parts with findings that are not the last steps of their paths, by key."""
    if not clashes.facts.names:
        return {}
    keys = clashes.keys
    used = {keys[part] for part in np.union1d(clashes.parts_a, clashes.parts_b).tolist()}
    return {key: name for key, name in sorted(clashes.facts.names) if key in used}


def rows(clashes: Table) -> Iterator[dict[str, Any]]:
    """The findings in the order of the table, with None for NaN."""
    keys = part_keys(clashes.part_paths)
    for clash in clashes:
        yield {
            "id": clash.id,
            "rule": clash.rule,
            "a": keys[clash.a],
            "b": keys[clash.b],
            "verdict": clash.verdict.name.lower(),
            "severity": clash.severity,
            "status": clash.status,
            **({"by": clash.by} if clash.by else {}),
            **({"note": clash.note} if clash.note else {}),
            **approval_json(clashes.marks.of(clash.id)),
            **({"changed": clash.changed} if clash.changed else {}),
            "depth": _number(clash.depth),
            "depth_error": _number(clash.depth_error),
            "depth_kind": clash.depth_kind,
            "translation": list(map(_number, clash.translation)),
            "gap": _number(clash.gap),
            "point_a": list(map(_number, clash.point_a)),
            "point_b": list(map(_number, clash.point_b)),
            "volume": _number(clash.volume),
            "triangles": clash.triangles,
            "box": [list(map(_number, corner)) for corner in clash.box],
            "open": [clash.is_open_a, clash.is_open_b],
        }


def shape_rows(clashes: Table) -> list[dict[str, Any]]:
    """Shape and place of each part with findings, sorted by key; with `path` if it differs from the key."""
    keys = clashes.keys
    shapes = clashes.shapes.with_siblings(keys[part] for part in np.union1d(clashes.parts_a, clashes.parts_b))
    return [
        {
            "part": key,
            **({"path": path} if path != key else {}),
            "content": f"{content:016x}",
            "box": box,
            "middle": middle,
            "area": area,
            **({"triangles": triangles, "chord": chord, "area_error": error} if math.isfinite(chord) else {}),
        }
        for key, path, content, box, middle, area, triangles, chord, error in zip(
            shapes.keys,
            shapes.paths,
            *(getattr(shapes, name).tolist() for name in ARRAYS),
            strict=True,
        )
    ]


def shapes_of_file(clashes: Table) -> dict[str, list[dict[str, Any]]]:
    """The shapes for a file: of findings, and of earlier findings that are not resolved."""
    waiting = clashes.earlier()
    waiting = waiting[waiting.statuses != "resolved"]
    return {"shapes": shape_rows(clashes), **({"earlier_shapes": shape_rows(waiting)} if len(waiting) else {})}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def save(clashes: Table, path: str | os.PathLike[str]) -> None:
    """See `Clashes.save`."""
    texts = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in head(clashes).items()]
    for name, table in (("clashes", clashes), ("earlier", clashes.earlier())):
        lines = sorted(rows(table), key=lambda row: (row["rule"], sorted((row["a"], row["b"])), row["id"]))
        texts.append(_list(name, lines))
    texts += [_list(name, lines) for name, lines in shapes_of_file(clashes).items()]
    with atomic_file(path, ".json") as file:
        file.write(("{\n " + ",\n ".join(texts) + "\n}\n").encode("ascii"))


def _list(name: str, lines: Sequence[Mapping[str, Any]]) -> str:
    inside = ",\n".join("  " + json.dumps(line, allow_nan=False) for line in lines)
    return f'"{name}": [\n{inside}\n ]' if lines else f'"{name}": []'


def load(path: str | os.PathLike[str], kind: type[AnyTable]) -> AnyTable:
    """See `load_clashes`."""
    file = check_path("path", path)
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give a file of Clashes.save") from None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        end = len(text.rstrip())
        is_cut = not text[:end].endswith("}") or getattr(error, "pos", 0) >= end
        cut = "it is cut short, or " if is_cut else ""
        raise LoadError(f"{file}: {cut}not JSON ({error}): give a file of Clashes.save, whole") from None
    if not isinstance(data, Mapping) or data.get("format") != FORMAT:
        raise LoadError(f'{file} is not a file of clashes ("format" is not "{FORMAT}"): give a file of Clashes.save')
    return table_of(data, file, kind)


def table_of(data: Mapping[str, Any], file: str | os.PathLike[str], kind: type[AnyTable]) -> AnyTable:
    """The findings in the content of a file. file: its name, for errors. Raises `LoadError`."""
    if data.get("version") != VERSION:
        raise LoadError(
            f"{file} is of version {data.get('version')!r}, and this feeler reads {VERSION}: run the check again, or "
            "use the feeler that wrote it"
        )
    reader = _Reader(file, kind)
    found = reader.table(data, "clashes")
    if data.get("earlier"):
        found._set_earlier(reader.table(data, "earlier"))
    return found


class _Reader(Generic[AnyTable]):
    """Turns JSON into tables. Errors name the line."""

    def __init__(self, file: str | os.PathLike[str], kind: type[AnyTable]) -> None:
        self.file, self.kind = file, kind

    def table(self, data: Mapping[str, Any], name: str) -> AnyTable:
        lines = data.get(name)
        if not isinstance(lines, list):
            raise LoadError(f'{self.file} holds no list "{name}": give a file of Clashes.save')
        keys: dict[str, int] = {}
        rules: dict[str, int] = {}
        marks: dict[str, Mark] = {}
        values: dict[str, list[Any]] = {column: [] for column in SHAPES}
        for number, line in enumerate(lines):
            try:
                self._add(line, values, keys, rules, marks)
            except (KeyError, TypeError, ValueError, OverflowError) as error:
                what = f"it has no {error}" if isinstance(error, KeyError) else str(error)
                raise LoadError(f"{self.file}: {name}[{number}] is not a finding: {what}") from None
        columns = Columns(
            **{
                column: np.array(values[column], dtype=kind).reshape(-1, *shape)
                for column, (kind, shape) in SHAPES.items()
            }
        )
        if len(marks) < len(lines):
            raise LoadError(f"{self.file}: {name} holds a finding twice: give a file of Clashes.save")
        facts = Facts(
            clearance=_real(data.get("clearance"), "clearance") if data.get("clearance") is not None else 0.0,
            contact=data["contact"] if data.get("contact") == "chord" else _real(data.get("contact") or 0.0, "contact"),
            parts=int(data.get("parts") or 0),
            triangles=int(data.get("triangles") or 0),
            files=tuple(map(str, data.get("files") or ())),
            hidden=_hidden(data.get("hidden") or {}),
            rules=tuple(_rule(each) for each in data.get("rules") or ()),
            notes=tuple(map(str, data.get("notes") or ())),
            least_contact=_real(data.get("least_contact") or 0.0, "least_contact"),
            names=self._names(data.get("names", {})),
        )
        order = columns.order(list(keys), list(rules))
        is_partial = bool(data.get("partial", False)) and name == "clashes"
        shapes = self._shapes(data, "shapes" if name == "clashes" else "earlier_shapes").joined(unknown(list(keys)))
        return self.kind(
            columns.rows(order),
            list(keys),
            list(rules),
            marks=Marks(marks),
            facts=facts,
            is_partial=is_partial,
            shapes=PartShapes(shapes),
        )

    def _names(self, names: Any) -> tuple[tuple[str, str], ...]:
        if not isinstance(names, Mapping) or not all(isinstance(name, str) for name in names.values()):
            raise LoadError(f'{self.file}: "names" is not texts by part: give a file of Clashes.save')
        return tuple(names.items())

    def _shapes(self, data: Mapping[str, Any], name: str) -> Shapes:
        lines = data.get(name, [])
        if not isinstance(lines, list):
            raise LoadError(f'{self.file}: "{name}" is not a list: give a file of Clashes.save')
        found: dict[str, _Shape] = {}
        for number, line in enumerate(lines):
            try:
                key, shape = _shape(line)
            except (KeyError, TypeError, ValueError, OverflowError) as error:
                what = f"it has no {error}" if isinstance(error, KeyError) else str(error)
                raise LoadError(f"{self.file}: {name}[{number}] is not a shape of a part: {what}") from None
            found[key] = shape
        paths, content, box, middle, *figures = zip(*found.values(), strict=True) if found else ((),) * 8
        area, triangles, chord, area_error = figures
        return Shapes(
            tuple(found),
            paths,
            np.array(content, dtype=np.uint64),
            np.array(box, dtype=np.float64).reshape(-1, 2, 3),
            np.array(middle, dtype=np.float64).reshape(-1, 3),
            np.array(area, dtype=np.float64),
            np.array(triangles, dtype=np.int64),
            np.array(chord, dtype=np.float64),
            np.array(area_error, dtype=np.float64),
        )

    def _add(
        self,
        line: Any,
        values: dict[str, list[Any]],
        keys: dict[str, int],
        rules: dict[str, int],
        marks: dict[str, Mark],
    ) -> None:
        """Appends a finding. Raises `KeyError`, `TypeError` or `ValueError` if the line is invalid."""
        if not isinstance(line, Mapping):
            raise TypeError("it is not an object")
        a, b, rule = (_text(line, name) for name in ("a", "b", "rule"))
        if line["id"] != clash_id(rule, a, b):
            raise ValueError(f"its id {line['id']!r} is not that of its rule and parts")
        status = line["status"]
        if status not in STATUSES:
            raise ValueError(f"status is {status!r}")
        if line["verdict"] not in list(Verdict):
            raise ValueError(f"verdict is {line['verdict']!r}")
        approval = approval_of_json(line)
        if status == "approved" and approval["approved_verdict"] is None:  # an older file
            approval["approved_verdict"] = line["verdict"]
        is_old = "depth_error" not in line
        kind = line["depth_kind"]
        if is_old and kind in _OLD_KINDS:
            # The old depth is an upper bound of the new one, so its approval stays valid. The depth of a contact was
            # not stored, and an estimate may be too small: there the next check sets the approved depth.
            if kind == "estimate" or (line["verdict"] == "contact" and line["gap"] == 0.0):
                approval["approved_depth"] = None
            kind = "estimate"
        marks[line["id"]] = Mark(
            status,
            str(line.get("by", "")),
            str(line.get("note", "")),
            changed=str(line.get("changed", "")),
            **approval,
        )
        triangles = int(line["triangles"])
        if not 0 <= triangles < _TRIANGLE_PAIRS:
            raise ValueError(f"triangles is {triangles}")
        box = [_triple(corner, "box") for corner in line["box"]]
        if len(box) != 2:
            raise ValueError("box is not two corners")
        row: dict[str, Any] = {
            "a": keys.setdefault(a, len(keys)),
            "b": keys.setdefault(b, len(keys)),
            "verdict": Verdict(line["verdict"]).code,
            "depth": _real(line["depth"], "depth"),
            "depth_error": _real(line.get("depth_error"), "depth_error"),
            "depth_kind": DEPTH_KINDS.index(kind),
            "gap": _real(line["gap"], "gap"),
            "volume": _real(line["volume"], "volume"),
            "triangles": triangles,
            "is_open": _flags(line["open"]),
            "rule": rules.setdefault(rule, len(rules)),
            "severity": SEVERITIES.index(line["severity"]),
            "box": box,
            **{name: _triple(line[name], name) for name in ("translation", "point_a", "point_b")},
        }
        for column, value in row.items():
            values[column].append(value)


_ERRORS = ("chord", "area_error")
_Shape = tuple[str, int, list[list[float]], list[float], float, int, float, float]
"""Path, content, box, middle, area, number of triangles, and errors by chords of a part."""


def _shape(line: Any) -> tuple[str, _Shape]:
    """Key and shape of a part. Raises `KeyError`, `TypeError` or `ValueError` if the line is invalid."""
    if not isinstance(line, Mapping):
        raise TypeError("it is not an object")
    key, content = _text(line, "part"), _text(line, "content")
    path = _text(line, "path") if "path" in line else key
    box = [_triple(corner, "box") for corner in line["box"]]
    middle, area = _triple(line["middle"], "middle"), _real(line["area"], "area")
    if len(box) != 2 or not np.isfinite([*box, middle]).all() or not math.isfinite(area):
        raise ValueError("box, middle and area are not all numbers")
    if len(content) != _HASH_DIGITS:
        raise ValueError(f"content is {content!r}")
    triangles, chord, error = int(line.get("triangles", 0)), *(_real(line.get(each), each) for each in _ERRORS)
    if triangles < 0 or triangles >= _TRIANGLE_PAIRS or chord < 0.0 or error < 0.0:
        raise ValueError("triangles, chord and area_error are not all at least 0")
    return key, (path, int(content, 16), box, middle, area, triangles, chord, error)


def _hidden(counts: Any) -> tuple[tuple[str, int], ...]:
    """How many findings each rule hid; empty if `counts` is not a mapping."""
    if not isinstance(counts, Mapping):
        return ()
    return tuple((name, count) for name, count in counts.items() if isinstance(count, int))


def _rule(line: Any) -> tuple[str, float, float]:
    """Name, clearance and contact of a rule. Raises `LoadError`."""
    try:
        name, clearance, contact = line
        return str(name), _real(clearance, "clearance"), _real(contact, "contact")
    except (TypeError, ValueError) as error:
        raise LoadError(f"rules holds {line!r}, which is not a name with two lengths: {error}") from None


def _text(line: Mapping[str, Any], name: str) -> str:
    if not isinstance(line[name], str):
        raise TypeError(f"{name} is not text")
    return str(line[name])


def _real(value: Any, name: str) -> float:
    """A number; null becomes NaN."""
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _LARGEST_M:
        raise ValueError(f"{name} is {value!r}")
    return float(value)


def _flags(value: Any) -> list[bool]:
    if not isinstance(value, list) or len(value) != 2 or not all(isinstance(each, bool) for each in value):
        raise ValueError("open is not two of true and false")
    return value


def _triple(value: Any, name: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f"{name} is not three numbers")
    return [_real(each, name) for each in value]
