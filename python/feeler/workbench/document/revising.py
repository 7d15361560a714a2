"""Which results are about an earlier revision of the mock-up: each result knows the parts that differ since.

A part that a later revision has again as it was makes no result stale that knew it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from feeler.parts import Parts
from feeler.project.parts import PartContent, Revision
from feeler.project.renaming import Left, named_parts
from feeler.project.store import Row
from feeler.workbench.document.document import (
    NONE_GONE,
    Document,
    Findings,
    KeptClear,
    LeftPattern,
    Measure,
    Removal,
    Since,
    Verdict,
)
from feeler.workbench.document.finding_rules import patterns_of
from feeler.workbench.document.gone import MOST

_STALE = '"stale":'
_WORST = ("changed", "new", "moved")

Sinces = Mapping[int, Since]


def with_revision(document: Document, revision: Revision, parts: Parts) -> Document:
    """The document, whose parts have the numbers of a revision, with what is stale in it.

    A removal and the answer of a card depend on all that is around their parts.
    """
    if not revision.differs and None not in revision.row_of:
        return document
    selected: dict[str, list[int]] = {}
    return replace(
        document,
        cards=tuple(replace(card, is_earlier=True) for card in document.cards),
        findings=document.findings and _findings(document.findings, revision),
        measures=tuple(_measure(each, revision) for each in document.measures),
        sequence=tuple(_line(each, revision) for each in document.sequence),
        requirements=tuple(_requirement(each, revision, parts, selected) for each in document.requirements),
    )


def left_patterns(document: Document, left: Left) -> tuple[LeftPattern, ...]:
    """The patterns of requirements and rules that renamed parts have left."""
    patterns = {(word, "requirement"): None for each in document.requirements for word in (each.a, each.b)}
    patterns |= {(word, "rule"): None for word in patterns_of(document.clash.rules)}
    found = (LeftPattern(pattern, of, now, was) for pattern, of in patterns for was, now in left.of(pattern))
    return tuple(itertools.islice(found, MOST))


def with_older(
    document: Document,
    rows: Callable[[str], list[Row]],
    known: Sequence[PartContent],
    number: Callable[[int], int | None],
    parts: Parts,
) -> Document:
    """The document of an older feeler, which knew what is stale of the whole project alone. number: of a part now."""
    was: dict[int, Since] = {}
    for old, part in enumerate(known):
        now = number(old)
        if part.change is not None and now is not None:
            was[now] = Since(part.change, "" if part.change == "new" else part.base)
    if not was:
        return document

    def older(table: str) -> set[str]:
        return {row.id for row in rows(table) if _STALE not in row.value}

    def of(chosen: Iterable[int]) -> Sinces:
        return _bounded({part: was[part] for part in chosen if part in was})

    lines, measures, asked = older("sequence"), older("measures"), older("requirements")
    found = document.findings
    if found is not None and "findings" in older("document"):
        found = replace(found, stale=_bounded(was))
    requirements = []
    for each in document.requirements:
        if each.verdict is not None and str(each.id) in asked:
            chosen = [*each.verdict.parts, *named_parts(each.a, parts), *named_parts(each.b, parts)]
            each = replace(each, verdict=replace(each.verdict, stale=of(dict.fromkeys(chosen))))
        requirements.append(each)
    return replace(
        document,
        findings=found,
        requirements=tuple(requirements),
        sequence=tuple(replace(line, stale=of(was)) if str(line.id) in lines else line for line in document.sequence),
        measures=tuple(
            replace(each, stale=of(each.parts)) if str(each.id) in measures else each for each in document.measures
        ),
    )


def with_check(document: Document, contents: Mapping[str, str], now: Sequence[PartContent]) -> Document:
    """The document with findings of a check of the command line. contents: of the parts that it saw, by their keys."""
    found = document.findings
    if found is None or not contents:
        return document
    stale = {}
    for part in _parts_of(found):
        was = contents.get(now[part].key)
        if was is not None and was != now[part].content:
            stale[part] = found.stale.get(part) or Since("changed", was)
    return replace(document, findings=replace(found, stale=_bounded(stale), gone=NONE_GONE))


def _findings(found: Findings, revision: Revision) -> Findings:
    # Parts without findings, too: they may have some now.
    return replace(found, **_aged(found, revision.differs, revision))


def _parts_of(found: Findings) -> list[int]:
    """The parts that findings name, ascending."""
    table = found.table
    rows = table.part_of_path[np.unique(np.concatenate([table.a, table.b]))] if len(table) else np.zeros(0, np.int32)
    return sorted({int(part) for part in rows.tolist() if part >= 0})


def _measure(measure: Measure, revision: Revision) -> Measure:
    return replace(measure, stale=_aged_stale(measure.stale, measure.parts, revision, NONE_GONE))


def _line(line: Removal, revision: Revision) -> Removal:
    others = (part for part in revision.differs if part not in line.parts)
    return replace(line, **_aged(line, [*line.parts, *others], revision))


def _requirement(asked: KeptClear, revision: Revision, parts: Parts, selected: dict[str, list[int]]) -> KeptClear:
    if asked.verdict is None:
        return asked
    for pattern in (asked.a, asked.b):
        if pattern not in selected:
            selected[pattern] = named_parts(pattern, parts)
    chosen = dict.fromkeys([*asked.verdict.parts, *selected[asked.a], *selected[asked.b]])
    return replace(asked, verdict=replace(asked.verdict, **_aged(asked.verdict, chosen, revision)))


def _aged(result: Removal | Verdict | Findings, parts: Iterable[int], revision: Revision) -> dict[str, Any]:
    """The fields of a result that differ after another revision. parts: those that it is about."""
    gone = {key: content for key, content in result.gone.items() if key not in revision.keys}
    stale = _aged_stale(result.stale, parts, revision, result.gone)
    return {"stale": stale, "gone": MappingProxyType(gone)}


def _aged_stale(stale: Sinces, parts: Iterable[int], revision: Revision, gone: Mapping[str, str]) -> Sinces:
    """The parts that differ, of those that a result is about, after another revision. gone: as `NONE_GONE`."""
    found = dict(stale)
    for part in parts:
        step = revision.differs.get(part)
        if step is None:
            continue
        change: str = step[0]
        content = step[1]
        if change == "new" and (known := gone.get(revision.parts[part].key)):  # it is back
            change, content = "changed", known
        was = found.get(part)
        if was is not None:
            change, content = min(change, was.change, key=_WORST.index), was.content
        if content == revision.parts[part].content:
            found.pop(part, None)
        else:
            found[part] = Since(change, content)
    return _bounded(found)


def _bounded(stale: Sinces) -> Sinces:
    return MappingProxyType(dict(list(stale.items())[:MOST]))
