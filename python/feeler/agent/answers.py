"""Answers of the tools: JSON of less than 4 kB, in which every figure has its kind.

A tool declares the fields of its answer once. From these come its output schema, the kinds in each answer, and the
tables of docs/agents.md.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from feeler.mockup import Mockup

MOST_BYTES = 4_000
"""The longest answer, bytes of UTF-8."""
MOST_NAME_BYTES = 120
"""The longest name of a part in an answer; longer ones are cut, and begin with the number of the part."""
MOST_LISTED = 5
"""The most parts in a list beside the rows."""

EXACT = "exact"
AT_LEAST = "bound: at least"
AT_MOST = "bound: at most"
ESTIMATE = "estimate"


@dataclass(frozen=True)
class Field:
    """A field of an answer. `kind`: of a figure or decision. `fields`: of the entries of a list of objects."""

    type: str
    meaning: str
    kind: str | None = None
    fields: Mapping[str, Field] = field(default_factory=dict)

    def schema(self) -> dict[str, Any]:
        """Its JSON schema."""
        said = self.meaning if self.kind is None else f"{self.meaning} ({self.kind})"
        if self.fields and self.type == "array":
            return {"type": "array", "items": _object(self.fields), "description": said}
        if self.fields:
            return {**_object(self.fields), "description": said}
        if self.type == "names":
            return {"type": "array", "items": {"type": "string"}, "description": said}
        if self.type == "point":
            return {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "description": said}
        return {"type": self.type, "description": said}


Fields = Mapping[str, Field]

_COMMON: dict[str, Field] = {
    "kinds": Field("object", "the kind of each figure in this answer: exact, bound or estimate"),
    "left_out": Field("object", "how many entries of a list are left out, to keep the answer short"),
    "more": Field("string", "how to get them"),
}


def output_schema(fields: Fields) -> dict[str, Any]:
    """The JSON schema of a tool's answer. No field is required: those without a value are left out."""
    return _object({**fields, **_COMMON})


def _object(fields: Fields) -> dict[str, Any]:
    return {"type": "object", "properties": {name: each.schema() for name, each in fields.items()}}


def finished(answer: Mapping[str, Any], fields: Fields, rows: str, offset: int) -> tuple[dict[str, Any], str]:
    """The answer as an object and as text, with the kinds of its figures, cut to `MOST_BYTES`.

    rows: the name of its main list, which begins with the entry `offset`. An answer may have `kinds` of its own, for
    figures that are less than they usually are.
    """
    whole: dict[str, Any] = _plain(answer)
    kinds = {name: kind for name, kind in _kinds(fields) if _has(whole, name)} | whole.pop("kinds", {})
    if kinds:
        whole["kinds"] = kinds
    left_out: dict[str, int] = {}
    entries = whole.get(rows)
    if isinstance(entries, list):
        room = MOST_BYTES - _size({**whole, rows: []}) - _SPARE
        kept = 0
        for entry in entries:
            room -= _size(entry) + 1
            if room < 0:
                break
            kept += 1
        if kept == len(entries) - 1 and _size(whole) <= MOST_BYTES:
            kept += 1  # without the note there is room for the last one
        if kept < len(entries):
            left_out[rows] = len(entries) - kept
            whole[rows] = entries[:kept]
    while _size(_noted(whole, left_out, rows, offset)) > MOST_BYTES:
        name = max((name for name in whole if isinstance(whole[name], list)), key=lambda name: _size(whole[name]))
        whole[name] = whole[name][:-1]
        left_out[name] = left_out.get(name, 0) + 1
    whole = _noted(whole, left_out, rows, offset)
    return whole, _text(whole)


_SPARE = 160  # bytes for the note of what is left out


def _noted(whole: dict[str, Any], left_out: dict[str, int], rows: str, offset: int) -> dict[str, Any]:
    if not left_out:
        return whole
    said = "; ".join(
        f"call again with offset {offset + len(whole[name])}" if name == rows else f"ask for fewer {name}"
        for name in left_out
    )
    return {**whole, "left_out": left_out, "more": f"{said}, or a narrower pattern"}


def _kinds(fields: Fields) -> Iterator[tuple[str, str]]:
    for name, each in fields.items():
        if each.kind is not None:
            yield name, each.kind
        yield from _kinds(each.fields)


def _has(value: Any, name: str) -> bool:
    if isinstance(value, dict):
        return name in value or any(_has(each, name) for each in value.values())
    return isinstance(value, list) and any(_has(each, name) for each in value)


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _size(value: Any) -> int:
    return len(_text(value).encode())


def _plain(value: Any) -> Any:
    """As JSON has it. Fields without a value (None, NaN, infinity) are left out."""
    if isinstance(value, Mapping):
        entries = ((str(key), _plain(each)) for key, each in value.items())
        return {key: each for key, each in entries if each is not None}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()  # names come from files, and may have half a character
    return value


def point(xyz: Any) -> list[float] | None:
    """Coordinates, rounded to a nanometre; None if they are not known."""
    values = np.asarray(xyz, dtype=np.float64)
    return [round(float(value), 9) + 0.0 for value in values] if np.isfinite(values).all() else None


def part_name(mockup: Mockup, part: int) -> str:
    """The path of a part. Where it is long, or names others as well, its number and the end of its path, `#12 ...end`,
    which `part_of_number` reads."""
    path = mockup.part_paths[part]
    is_short = len(path.encode("utf-8", "replace")) <= MOST_NAME_BYTES
    if is_short and [each.index for each in mockup.parts.find(path or "/")] == [part]:
        return path
    return _numbered(f"#{part}", path)


def assembly_name(mockup: Mockup, part: int, level: int) -> str:
    """The path of the assembly that the first `level` steps of a part's path name; `#12:3 ...end` for a long one."""
    path = "/".join(mockup.part_paths[part].split("/")[:level])
    return path if len(path.encode("utf-8", "replace")) <= MOST_NAME_BYTES else _numbered(f"#{part}:{level}", path)


def _numbered(number: str, path: str) -> str:
    encoded = path.encode("utf-8", "replace")
    room = MOST_NAME_BYTES - len(number) - len(" ...")
    end = encoded[-room:].decode("utf-8", "ignore")
    return f"{number} ...{end}" if len(encoded) > room else f"{number} {path}"


_NUMBER = re.compile(r"#(\d{1,10})(?::(\d{1,3}))?(?: .*)?", re.DOTALL)


def part_of_number(mockup: Mockup, text: str) -> list[int] | None:
    """The parts of `#12` or `#12:3`, as answers have them, with or without what follows. None for any other text, and
    for one that is the path or name of a part."""
    found = _NUMBER.fullmatch(text)
    if found is None or int(found[1]) >= mockup.part_count or mockup.parts.find(text):
        return None
    part = int(found[1])
    if found[2] is None:
        return [part]
    return [each.index for each in mockup.parts.find("/".join(mockup.part_paths[part].split("/")[: int(found[2])]))]


def part_names(mockup: Mockup, parts: Sequence[int] | Any) -> list[str]:
    """The names of the first parts, by index."""
    return [part_name(mockup, int(part)) for part in parts[:MOST_LISTED]]
