"""The rows of a report, from its source."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any, TypeVar

import numpy as np

from feeler.choices import STATUSES
from feeler.errors import OptionError
from feeler.io.film import way_length
from feeler.project.runs import RunRow
from feeler.words import length, plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import CardAnswer, WayFacts
from feeler.workbench.document.document import (
    Card,
    Check,
    Findings,
    KeptClear,
    Removal,
    Since,
    Verdict,
    is_stale,
)
from feeler.workbench.document.finding_table import DUPLICATE, KINDS, FindingTable, table_of
from feeler.workbench.document.joints import JointStep, figure
from feeler.workbench.document.line_facts import least_clearance, line_length, newest_check
from feeler.workbench.report import values
from feeler.workbench.report.source import Source

LONGEST_NAME, LONGEST_TEXT = 500, 5_000
"""Characters of names, and of notes and sentences; the rest is cut."""
MOST_LISTED = 100
"""Paths of parts that were out, in the hand or moved; there are counts, too."""
MOST_ROWS = 20_000
"""Rows of one table: parts, blockers, fasteners, marks of one finding."""
_LARGEST_M = 1e9
_LONGEST_S = 1e9
_ORDER: dict[str, int] = {status: number for number, status in enumerate(STATUSES)}
_EARLIER = "it is about an earlier revision of the mock-up"
_NO_POINT = (math.nan, math.nan, math.nan)

Row = TypeVar("Row")


def report_of(source: Source, when: datetime.datetime | None = None) -> values.Report:
    """The content of a report. when: it was made; now by default."""
    made = (when or datetime.datetime.now(datetime.timezone.utc)).strftime("%Y-%m-%d %H:%M UTC")
    writer = _Writer(source)
    document, about = source.document, source.document.mockup
    name = about.name if about is not None else "mock-up"
    tool = document.tool
    return values.Report(
        title=cut(name),
        project=cut(source.name),
        made=made,
        version=_version(),
        sources=tuple(map(cut, source.sources)),
        content=cut(about.hash if about is not None else ""),
        parts=len(source.parts),
        triangles=about.triangles if about is not None else 0,
        tool=cut(tool.name) if tool is not None else "",
        stale=source.changes,
        check=writer.check(),
        requirements=tuple(map(writer.requirement, document.requirements)),
        findings=tuple(writer.findings()),
        resolved=tuple(writer.resolved()),
        questions=tuple(map(writer.question, document.cards)),
        steps=tuple(writer.steps()),
        maintenance=_maintenance(source),
        notes=(*source.notes, *writer.left_out()),
    )


def cut(text: str, most: int = LONGEST_NAME) -> str:
    """A text that is not longer than a page needs."""
    return text if len(text) <= most else text[: most - 1] + "…"


def name_of(path: str) -> str:
    """The last step of a path."""
    return path.rstrip("/").rpartition("/")[2] or path or "a part"


def _version() -> str:
    try:
        return version("feeler")
    except PackageNotFoundError:
        return ""


class _Writer:
    """Makes rows of one source."""

    def __init__(self, source: Source) -> None:
        self._source, self._document = source, source.document
        self._count = len(source.parts)
        self._gone = frozenset({*self._document.out, *self._document.gripped, *self._document.absent})
        found = self._document.findings
        self._own_groups = {} if found is None else {each.id: each.name for each in found.own_groups}
        self._selected: dict[str, frozenset[int] | None] = {}

    # ---- parts ----

    def path(self, part: int | None) -> str:
        """The path of a part; empty for one that is not there."""
        return cut(self._source.parts[part].path) if part is not None and 0 <= part < self._count else ""

    def paths(self, parts: Sequence[int]) -> tuple[str, ...]:
        return tuple(self.path(part) for part in parts[:MOST_ROWS])

    def since(self, stale: Mapping[int, Since], parts: Iterable[int] | None = None) -> str:
        """Which parts of a result, or of these, differ since it was computed, in words; empty if none does."""
        return self._changes({part: each.change for part, each in stale.items()}, stale if parts is None else parts)

    def changed(self, parts: Sequence[int] | frozenset[int]) -> str:
        """Which of these parts differ from those of the project's first revision, likewise."""
        return self._changes(self._source.stale, parts)

    def _changes(self, changes: Mapping[int, str], parts: Iterable[int]) -> str:
        return _some([f"{name_of(self.path(part))} {changes[part]}" for part in parts if part in changes])

    def _is_moved(self, moved: Mapping[int, Any], out: Sequence[int], gripped: Sequence[int]) -> bool:
        """Whether parts lay elsewhere than now."""
        now = self._document
        return (dict(moved), tuple(out), tuple(gripped)) != (dict(now.moved), now.out, tuple(now.gripped))

    def _layout(self, moved: Mapping[int, Any], out: Sequence[int], gripped: Sequence[int]) -> values.Layout:
        gone = {*out, *gripped}
        return values.Layout(*map(self._few, (out, gripped, [part for part in moved if part not in gone])))

    def _few(self, parts: Sequence[int]) -> values.SomeParts:
        there = [part for part in parts if 0 <= part < self._count]
        return values.SomeParts(len(there), self.paths(there[:MOST_LISTED]))

    def left_out(self) -> list[str]:
        """A note on the parts that the whole project leaves out."""
        absent = self._document.absent
        return [f"The project is without {plural(len(absent), 'part')}: {self._few(absent)}."] if absent else []

    def _selection(self, pattern: str) -> frozenset[int] | None:
        """The parts of a pattern; None if there are none."""
        if pattern not in self._selected:
            try:
                found = frozenset(self._source.parts.select(pattern).tolist())
            except (OptionError, ValueError, RecursionError, OverflowError):
                found = frozenset()
            self._selected[pattern] = found or None
        return self._selected[pattern]

    # ---- requirements ----

    def requirement(self, asked: KeptClear) -> values.RequirementRow:
        """A clearance that must hold, with what is known of it."""
        verdict = asked.verdict
        status = "not checked" if verdict is None else cut(verdict.status)
        parts = [] if verdict is None else [part for part in verdict.parts if 0 <= part < self._count][:2]
        a, b = (self.path(part) for part in (*parts, None, None)[:2])
        gap, depth = (None if verdict is None else _finite(value) for value in _sizes(verdict))
        stale = []
        if verdict is not None:
            stale.append(self.since(verdict.stale))
            for side, pattern in (("a", asked.a), ("b", asked.b)):
                chosen = self._selection(pattern)
                if chosen is None and status != "unknown" and not pattern.startswith("re:"):
                    stale.append(f"pattern {side} names no part now")
            stale += self._lost(verdict.parts)
        points = () if verdict is None else verdict.points
        return values.RequirementRow(
            id=asked.id,
            name=cut(asked.name),
            a=cut(asked.a),
            b=cut(asked.b),
            required=asked.gap,
            status=status,
            sentence=cut(_requirement_words(asked, status, a, b, gap, depth), LONGEST_TEXT),
            stale="; ".join(dict.fromkeys(filter(None, stale))),
            is_moved=verdict is not None and self._is_moved(*_lay(verdict)),
            layout=self._layout(*_lay(verdict)),
            gap=gap,
            depth=depth,
            pairs=0 if verdict is None else verdict.pairs,
            path_a=a,
            path_b=b,
            point=_point(points[0]) if points else None,
            place=_place(parts, points) if len(parts) == 2 and status == "violated" else None,
        )

    def _lost(self, parts: Sequence[int]) -> list[str]:
        return ["its parts are gone"] if any(not 0 <= part < self._count for part in parts) else []

    # ---- findings ----

    def check(self) -> values.Check | None:
        """The clash check; None if there are no findings."""
        found = self._document.findings
        if found is None:
            return None
        facts, made = found.table.facts, found.check
        contact = cut(facts.contact) if isinstance(facts.contact, str) else facts.contact
        return values.Check(
            facts.clearance,
            contact,
            {cut(name): count for name, count in found.table.hidden.items()},
            self._is_moved(*_lay(made)),
            () if made is None or made.of is None else self.paths(made.of),
            self._layout(*_lay(made)),
        )

    def findings(self) -> list[values.FindingRow]:
        """All findings: open ones first, contacts last, each the worst first."""
        found = self._document.findings
        if found is None:
            return []
        history = _history(self._source.history)
        rows = [self._finding(found, found.table, row, history) for row in range(len(found.table))]
        return sorted(rows, key=lambda row: (row.is_touching, _ORDER.get(row.status, 0)))

    def resolved(self) -> list[values.FindingRow]:
        """Findings of the check before that are gone."""
        found = self._document.findings
        if found is None:
            return []
        table = table_of({"clashes": found.resolved}, self._source.parts)
        history = _history(self._source.history)
        return [self._finding(None, table, row, history) for row in range(len(table))]

    def _finding(
        self,
        found: Findings | None,
        table: FindingTable,
        row: int,
        history: Mapping[str, list[values.Mark]],
    ) -> values.FindingRow:
        name = table.ids[row]
        status: str = STATUSES[int(table.status[row])]
        mark = table.marks.get(name)
        note, by = ("", "") if mark is None else (mark.note, mark.by)
        group = table.groups[table.group[row]]
        if found is not None:
            group = self._own_groups.get(found.members.get(name, -1), group)
            own = found.mark_of(name)
            status, note, by = own.status, own.note, own.by
        sides = [int(table.part_of_path[side[row]]) for side in (table.a, table.b)]
        a, b = (cut(table.paths[side[row]]) for side in (table.a, table.b))
        verdict = table.verdicts[table.verdict[row]]
        depth, gap = (_finite(float(column[row])) for column in (table.depth, table.gap))
        points = [_point(column[row].tolist()) for column in (table.point_a, table.point_b)]
        is_here = all(part >= 0 for part in sides)
        known = next((point for point in points if point is not None), None)
        extent = _extent(verdict, depth, gap, KINDS[table.depth_kind[row]])
        place = values.PairPlace(
            sides[0],
            sides[1],
            points[0] or points[1] or _NO_POINT,
            points[1] or points[0] or _NO_POINT,
            _point(table.translation[row].tolist()) or _NO_POINT,
        )
        return values.FindingRow(
            id=cut(name),
            a=a,
            b=b,
            verdict=cut(verdict),
            severity=("critical", "major", "minor")[int(table.severity[row])],
            rule=cut(table.rules[table.rule[row]]),
            status=status,
            group=cut(group),
            by=cut(by),
            note=cut(note, LONGEST_TEXT),
            sentence=_finding_words(verdict, a, b, extent),
            extent=extent,
            depth=depth,
            gap=gap,
            point=known,
            is_touching=bool(table.is_touching[row]),
            stale=self.since({} if found is None else found.stale, sides) if is_here else "a part is gone",
            history=tuple(history.get(name, ()))[:MOST_ROWS],
            place=place if is_here else None,
        )

    # ---- ways ----

    def question(self, card: Card) -> values.QuestionRow:
        """A card with its answer."""
        answer = self._source.answers.get(card.id) if card.state == "done" else None
        sentence = card.sentence or ("" if card.state == "done" else "Not answered.")
        moved, held = card.world
        gone = frozenset({*(part for part, _ in moved), *held, *card.without, *self._document.absent})
        ways = () if answer is None else tuple(self._ways(card, answer, dict(moved), gone))
        return values.QuestionRow(
            id=card.id,
            kind=cut(card.question),
            title=cut(card.title),
            setting=cut(card.setting),
            sentence=cut(sentence, LONGEST_TEXT),
            is_good=card.is_good if card.state == "done" else None,
            stale=(self.changed(card.parts) or _EARLIER) if card.is_earlier else "",
            is_moved=is_stale(self._document, card) and not card.is_earlier,
            ways=ways,
            blockers=() if answer is None else self._blockers(answer),
            reaches=() if answer is None else self._reaches(answer),
            facts=() if answer is None else tuple((cut(f["name"]), cut(f["figure"])) for f in answer["facts"]),
            task=() if answer is None else self._task(card, answer),
            notes=() if answer is None else self._task_notes(card, answer),
        )

    def _task(self, card: Card, answer: CardAnswer) -> tuple[values.TaskStepRow, ...]:
        task = answer.get("task")
        firsts = {path for pair in card.edits.before for path in pair}
        return tuple(
            values.TaskStepRow(
                number=number,
                verb=cut(step["verb"]),
                path=self.path(step["part"]),
                tool=cut(step["tool"]),
                person=step["person"] + 1,
                start=step["start"],
                seconds=step["seconds"],
                spread=step["spread"],
                arithmetic=cut(step["arithmetic"], LONGEST_TEXT),
                because=cut(step["because"], LONGEST_TEXT),
                edited=", ".join(
                    word
                    for word, is_so in (
                        ("time typed", step["is_typed"]),
                        ("order forced", self.path(step["part"]) in firsts),
                    )
                    if is_so
                ),
            )
            for number, step in enumerate(() if task is None else task["steps"][:MOST_ROWS], start=1)
        )

    def _task_notes(self, card: Card, answer: CardAnswer) -> tuple[str, ...]:
        """What is to be known of a task: its notes, what blocks it, and the edits of the user."""
        task = answer.get("task")
        if task is None:
            return ()
        blocked = (
            f"{'all together' if each['part'] is None else self.path(each['part'])}: {each['because']}"
            for each in task["blocked"]
        )
        off = (f"Already off: {path}." for path in card.edits.off)
        forced = (f"Forced: {first} before {then}." for first, then in card.edits.before)
        return tuple(cut(note, LONGEST_TEXT) for note in (*task["notes"], *blocked, *off, *forced))[:MOST_ROWS]

    def _ways(
        self, card: Card, answer: CardAnswer, places: Mapping[int, motion.Row], gone: frozenset[int]
    ) -> list[values.WayRow]:
        rows = []
        for number, way in enumerate(answer["ways"], start=1):
            told = {int(part): motion.row(place) for part, place in way.get("places", {}).items()}
            there = told if "places" in way else places
            starts = {part: there[part] for part in way["parts"] if part in there}
            stale = self.changed(way["parts"]) if card.is_earlier else ""
            rows.append(self._way(f"way-{card.id}-{number}", way, starts, gone | frozenset(told), stale))
            gone |= frozenset(way["parts"])
        return rows

    def _way(
        self, key: str, way: WayFacts, starts: Mapping[int, motion.Row], gone: frozenset[int], stale: str
    ) -> values.WayRow:
        return values.WayRow(
            key=key,
            title=self._names(way["parts"]),
            paths=self.paths(way["parts"]),
            parts=tuple(way["parts"]),
            poses=tuple(motion.row(motion.checked(pose, "pose")) for pose in way["poses"]),
            starts=starts,
            gone=gone - frozenset(way["parts"]),
            legs=tuple(cut(leg) for leg in way["legs"][:MOST_ROWS]),
            length=max(0.0, way["length"]),
            rotation=way["rotation"],
            clearance=way["clearance"],
            stale=stale,
            gaps=_gaps(way),
        )

    def _blockers(self, answer: CardAnswer) -> tuple[values.BlockerRow, ...]:
        rows = answer["blockers"][:MOST_ROWS]
        return tuple(values.BlockerRow(self.path(each["part"]), each["attempts"], each["is_proof"]) for each in rows)

    def _reaches(self, answer: CardAnswer) -> tuple[values.ReachRow, ...]:
        return tuple(
            values.ReachRow(
                self.path(each["part"]) or cut(each["name"]),
                cut(each["kind"]),
                cut(each["tool"]),
                tuple(map(cut, each["tools"][:MOST_ROWS])),
                each["is_reachable"],
                each["swing_deg"],
                cut(each["because"]),
                self.paths(each["blockers"]),
            )
            for each in answer["reaches"][:MOST_ROWS]
        )

    def steps(self) -> list[values.WayRow]:
        """The sequence as work steps."""
        rows = []
        gone = frozenset(self._document.absent)
        for line in self._document.sequence:
            rows.append(self._step(line, gone))
            gone |= frozenset(line.parts)
        return rows

    def _step(self, line: Removal, gone: frozenset[int]) -> values.WayRow:
        step, mockup = line.joint, self._source.mockup
        poses = np.stack([motion.matrix(pose) for pose in line.way])
        moves = poses @ np.linalg.inv(poses[0])
        return values.WayRow(
            key=f"step-{line.id}",
            title=cut(line.name),
            paths=self.paths(line.parts),
            parts=line.parts,
            poses=tuple(motion.row(pose) for pose in moves),
            starts=dict(line.starts),
            gone=gone - frozenset(line.parts),
            legs=(),
            length=way_length(poses) if mockup is None else line_length(line, mockup.part_bounds),
            rotation=None if step is None or step.kind == "slide" else abs(step.end - step.begin),
            clearance=_finite(least_clearance(self._document, line)),
            touched=tuple(map(cut, line.touched[:MOST_ROWS])),
            tool=cut(line.tool or ""),
            stale=self.since(line.stale, line.parts) or (_EARLIER if line.stale else ""),
            checked=self._checked(line),
            joint="" if step is None else cut(_joint_words(step, self._document.unit)),
        )

    def _checked(self, line: Removal) -> str:
        """What the newest check of its way says, if the way is still that one."""
        check = newest_check(self._document, line)
        return "" if check is None else cut(check.sentence, LONGEST_TEXT)

    def _names(self, parts: Sequence[int]) -> str:
        names = [name_of(self.path(part)) for part in parts[:3]]
        more = f" and {len(parts) - 3:,} more" if len(parts) > 3 else ""
        return ", ".join(names) + more


def _maintenance(source: Source) -> values.Maintenance | None:
    """The last run of `feeler maintain`; None if there was none."""
    run, since = source.run, source.since_run
    if run is None:
        return None
    stale = [
        f"{name_of(cut(path))} {change}" for change in ("changed", "new", "gone") for path in getattr(since, change)
    ]
    rows = tuple(map(_maintenance_row, run["rows"][:MOST_ROWS]))
    return values.Maintenance(cut(run["at"]), cut(run["said"], LONGEST_TEXT), run["is_partial"], _some(stale), rows)


def _maintenance_row(row: RunRow) -> values.MaintenanceRow:
    seconds, high = _duration(row["seconds"]), _duration(row["high"])
    return values.MaintenanceRow(
        name=cut(row["name"]),
        paths=tuple(map(cut, row["paths"][:MOST_ROWS])),
        state=row["state"],
        seconds=seconds,
        spread=None if seconds is None or high is None else max(0.0, high - seconds),
        steps=row["steps"],
        tools=tuple(map(cut, row["tools"][:MOST_ROWS])),
        reach_deg=row["reach_deg"],
        sight=row["sight"],
        hidden=row["hidden"],
        change=cut(row["change"], LONGEST_TEXT),
        is_worse=row["is_slower"] or row["state"] == "failed",
        why=cut(row["why"], LONGEST_TEXT),
        renamed_from=cut(row["renamed_from"]),
    )


def _duration(seconds: float | None) -> float | None:
    return seconds if seconds is not None and 0.0 <= seconds < _LONGEST_S else None


def _some(said: Sequence[str]) -> str:
    """The first of these, and how many more there are."""
    return ", ".join(said[:3]) + (f", and {len(said) - 3:,} more" if len(said) > 3 else "")


def _joint_words(step: JointStep, unit: str) -> str:
    return f"{step.name} from {figure(step.kind, step.begin, unit)} to {figure(step.kind, step.end, unit)}"


def _gaps(way: WayFacts) -> tuple[tuple[float, float | None], ...]:
    rows = ((each["share"], each["gap"]) for each in way["gaps"][:MOST_ROWS] if 0.0 <= each["share"] <= 1.0)
    return tuple((share, None if gap is None else max(0.0, gap)) for share, gap in rows)


def _lay(checked: Check | Verdict | None) -> tuple[Mapping[int, Any], Sequence[int], Sequence[int]]:
    """Where parts lay at a check: those that were moved, out and in the hand. None: a check on the command line."""
    return ({}, (), ()) if checked is None else (checked.moved, checked.out, checked.gripped)


def _sizes(verdict: Any) -> tuple[float | None, float | None]:
    return (None, None) if verdict is None else (verdict.gap, verdict.depth)


def _requirement_words(asked: KeptClear, status: str, a: str, b: str, gap: float | None, depth: float | None) -> str:
    wanted = length(asked.gap) if asked.gap else "no overlap"
    if status == "not checked":
        return f"Not checked; {wanted} required."
    if status == "holds":
        return f"Holds: {'at least ' if asked.gap else ''}{wanted}."
    if status == "unknown":
        trouble = asked.verdict.trouble if asked.verdict is not None else None
        return f"Could not be checked: {(trouble or 'for an unknown reason').rstrip('.?')}."
    one, other = name_of(a), name_of(b)
    if depth:
        return f"{one} is {length(depth)} deep in {other}; {wanted} required."
    if gap:
        return f"{one} is {length(gap)} from {other}; {wanted} required."
    return f"{one} touches {other}; {wanted} required."


def _extent(verdict: str, depth: float | None, gap: float | None, kind: str) -> str:
    """Depth or gap in words, as the page has it."""
    if verdict == DUPLICATE:
        return "same surface"
    if depth is not None and depth > 0.0:
        said = {"bound": "at most ", "estimate": "about "}.get(kind, "")
        return f"{said}{length(depth)} deep"
    if gap is not None and gap > 0.0:
        return f"{length(gap)} apart"
    return "touching" if gap == 0.0 else ""


def _finding_words(verdict: str, a: str, b: str, extent: str) -> str:
    one, other = name_of(a), name_of(b)
    if verdict == "contained":
        return f"{one} and {other}: one is inside the other"
    if verdict == DUPLICATE:
        return f"{one} and {other} have the same surface"
    if extent.endswith(" deep"):
        return f"{one} is {extent} in {other}"
    if extent.endswith(" apart"):
        return f"{one} and {other} are {extent}"
    return f"{one} touches {other}" if extent == "touching" else f"{one} and {other}: {cut(verdict)}"


def _history(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[values.Mark]]:
    """The history of each finding by its id, the oldest first."""
    found: dict[str, list[values.Mark]] = {}
    for row in rows:
        key = row.get("id")
        if not isinstance(key, str):
            continue
        at, status, by = (_text(row.get(name)) for name in ("at", "status", "by"))
        note = _text(row.get("note"))
        found.setdefault(key, []).append(values.Mark(cut(at), cut(status) or "new", cut(by), cut(note, LONGEST_TEXT)))
    return found


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _point(given: Sequence[float]) -> values.Point | None:
    if len(given) != 3 or not all(math.isfinite(each) and abs(each) < _LARGEST_M for each in given):
        return None
    x, y, z = given
    return (float(x), float(y), float(z))


def _place(parts: Sequence[int], points: Sequence[Sequence[float]]) -> values.PairPlace:
    known = [_point(each) or _NO_POINT for each in points[:2]] or [_NO_POINT]
    return values.PairPlace(parts[0], parts[1], known[0], known[-1], (0.0, 0.0, 0.0))
