"""Findings of a clash check, in the format of `feeler clash --json`: grouped, deepest first, with a sentence each.

    {"version": 1, "clashes": [{"id", "a", "b", "verdict", "depth", "gap", "point_a", "point_b", "box", "rule",
                                "status", "group"}]}

Lengths are metres; `a` and `b` are part paths. Reading is tolerant: fields may be missing, and unknown ones are kept.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io.text import text_of
from feeler.parts import Parts
from feeler.words import length
from feeler.workbench.document.arguments import is_number, is_sequence
from feeler.workbench.document.document import Findings

VERSION = 1
STATUS = ("new", "active", "reviewed", "approved", "resolved")
TOUCHING = ("touching", "touch", "contact")
"""Verdicts of parts in contact."""
DUPLICATE = "duplicate"
"""The verdict of parts that have the same surface; their depth is 0."""


def read_findings(path: str | Path) -> Any:
    """The content of a file, for `grouped`. Raises `MissingFileError`, and `LoadError` for other files."""
    file = Path(path)
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give findings of feeler clash --json") from None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise LoadError(f"{file} cannot be read as JSON: {error}") from None
    _clashes(data, str(file))
    return data


def grouped(data: Any, parts: Parts, absent: Collection[int] = (), where: str = "findings") -> Findings:
    """Findings of `feeler clash --json`, for the document. Raises `LoadError` if there are none at all.

    absent: parts excluded from the scene; findings list them, but the page cannot show them.
    """
    clashes = _clashes(data, where)
    found = [_finding(each, number, parts, absent) for number, each in enumerate(clashes) if isinstance(each, Mapping)]
    by_group: dict[str, list[dict[str, Any]]] = {}
    for each in found:
        by_group.setdefault(each["group"], []).append(each)
    groups = []
    for name, members in by_group.items():
        members.sort(key=_worst_first)
        groups.append(
            {
                "name": name,
                "depth": members[0]["depth"],
                "gap": members[0]["gap"],
                "is_touching": all(each["is_touching"] for each in members),
                "findings": members,
            }
        )
    groups.sort(key=lambda group: _worst_first(group["findings"][0]))
    status = {each["id"]: each["status"] for each in found if each["status"] != STATUS[0]}
    return Findings(tuple(groups), MappingProxyType(status))


def _clashes(data: Any, where: str) -> Any:
    found: Any = data.get("clashes") if isinstance(data, Mapping) else None
    if not is_sequence(found):
        raise LoadError(f'{where} holds no list "clashes": give findings of feeler clash --json')
    if data.get("version", VERSION) != VERSION:
        raise LoadError(f"{where} is of version {data.get('version')!r}: this feeler reads {VERSION}")
    return found


def ids(groups: Iterable[Mapping[str, Any]]) -> list[str]:
    """All findings, in display order."""
    return [each["id"] for group in groups for each in group["findings"]]


def _finding(given: Mapping[str, Any], number: int, parts: Parts, absent: Collection[int]) -> dict[str, Any]:
    a, b = (str(given.get(side, "")) for side in "ab")
    depth, gap = (float(given[name]) if is_number(given.get(name)) else None for name in ("depth", "gap"))
    verdict = str(given.get("verdict") or _verdict(depth, gap))
    status = given.get("status")
    return {
        **given,
        "id": str(given.get("id", number)),
        "a": a,
        "b": b,
        "part_a": _part(a, parts, absent),
        "part_b": _part(b, parts, absent),
        "verdict": verdict,
        "depth": depth,
        "gap": gap,
        "point_a": _point(given.get("point_a")),
        "point_b": _point(given.get("point_b")),
        "status": status if status in STATUS else STATUS[0],
        "group": str(given.get("group") or f"{_folder(a)} and {_folder(b)}"),
        "is_touching": verdict in TOUCHING,
        "sentence": _sentence(a, b, verdict, depth, gap, given.get("rule")),
    }


def _sentence(a: str, b: str, verdict: str, depth: float | None, gap: float | None, rule: Any) -> str:
    one, other = a.rpartition("/")[2] or "a part", b.rpartition("/")[2] or "a part"
    if verdict == DUPLICATE:
        text = f"{one} and {other} have the same surface"
    elif verdict in TOUCHING:
        text = f"{one} touches {other}"
    elif depth:
        text = f"{one} is {length(depth)} deep in {other}"
    elif gap is not None and gap > 0.0:
        text = f"{one} is {length(gap)} from {other}"
    else:
        text = f"{one} collides with {other}"
    if isinstance(rule, str) and rule:
        text += f", against the rule {rule}"
    return text + "."


def _verdict(depth: float | None, gap: float | None) -> str:
    """The verdict of a finding that does not state one."""
    return TOUCHING[0] if not depth and gap == 0.0 else "clash"


def _worst_first(finding: Mapping[str, Any]) -> tuple[bool, float, float]:
    """Duplicates first, as in `Columns.order`: their depth is 0. Then by depth, then by distance."""
    gap = finding["gap"] if finding["gap"] is not None else 0.0
    return (finding["verdict"] != DUPLICATE, -_depth_in_order(finding), gap)


def _depth_in_order(finding: Mapping[str, Any]) -> float:
    """The depth of parts that overlap; a contact keeps its depth and still comes after them."""
    return 0.0 if finding["verdict"] in TOUCHING else finding["depth"] or 0.0


def _part(path: str, parts: Parts, absent: Collection[int]) -> int | None:
    try:
        found = parts.select(path)
    except OptionError:
        return None
    return int(found[0]) if len(found) == 1 and found[0] not in absent else None


def _point(given: Any) -> list[float] | None:
    if is_sequence(given) and len(given) == 3 and all(is_number(each) for each in given):
        return [float(each) for each in given]
    return None


def _folder(path: str) -> str:
    return path.rpartition("/")[0].rpartition("/")[2] or path or "parts"
