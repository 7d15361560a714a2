"""What results know of parts that are gone since: a part that is back as it was is not new to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from feeler.project.parts import PartContent
from feeler.workbench.document.document import Findings, KeptClear, Removal, Verdict
from feeler.workbench.document.set_aside import Renumber

MOST = 2_000
"""Parts that a result names; a page lists some of them."""

Left = Mapping[int, PartContent]
"""The parts that an earlier revision had and this one has not, by their numbers then."""


def left_of(known: Sequence[PartContent], renumber: Renumber) -> Left:
    """Those of the parts known that have no number now."""
    return {number: part for number, part in enumerate(known) if renumber(number) is None}


def with_gone(values: Mapping[str, Any], left: Left) -> dict[str, Any]:
    """The fields of a document with what its removals and requirements know of the parts that left."""
    return {
        **values,
        "sequence": tuple(_line(line, left) for line in values.get("sequence", ())),
        "requirements": tuple(_requirement(each, left) for each in values.get("requirements", ())),
    }


def gone_now(result: Removal | Verdict | Findings, left: Left) -> Mapping[str, str]:
    """The contents of parts that are gone, as a result knows them, by their keys."""
    found = dict(result.gone)
    for number, part in left.items() if len(result.stale) < MOST else ():
        since = result.stale.get(number)
        content = part.content if since is None else since.content
        if content:  # it is not new to the result
            found.setdefault(part.key, content)
    return MappingProxyType(dict(list(found.items())[:MOST]))


def _line(line: Removal, left: Left) -> Removal:
    # It no longer moves its own parts that left: they are new to it when they are back.
    return replace(line, gone=gone_now(line, {part: was for part, was in left.items() if part not in line.parts}))


def _requirement(asked: KeptClear, left: Left) -> KeptClear:
    verdict = asked.verdict
    return asked if verdict is None else replace(asked, verdict=replace(verdict, gone=gone_now(verdict, left)))
