"""A report as one HTML page, which opens offline and can be printed. Every text is escaped."""

from __future__ import annotations

import base64
import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from html import escape
from urllib.parse import quote

from feeler.choices import STATUSES
from feeler.tasks.steps import clock
from feeler.words import length, plural
from feeler.workbench.report.content import name_of
from feeler.workbench.report.html_style import CHUNK, SCRIPT, STYLE, chunk_class
from feeler.workbench.report.values import (
    FindingRow,
    MaintenanceRow,
    Media,
    QuestionRow,
    Report,
    RequirementRow,
    TaskStepRow,
    WayRow,
)

MOST_EMBEDDED = 24 << 20
"""Bytes of all films in one page, the first ones first; the others are left out of it."""
MOST_LISTED = 300
"""Parts of a list in the text; the others are counted."""
PAGE = "mock-up.html"
"""The name of the page with the mock-up, among the files of a report."""
_LIST_HEAD = (
    "<table class=rows><thead><tr><th>No.<th>Verdict<th>Depth or gap<th>Parts<th>Group"
    "<th>Note, history<th class=number>At, m</tr></thead><tbody>"
)
_CURVE = (600, 90)
"""Width and height of the drawing of gaps."""
_SCROLL = "<div class=scroll tabindex=0>"
"""Around a wide table: the keyboard scrolls it."""
_OPEN = ("new", "active")
_VERBS = {"undo": "#3b82c4", "disconnect": "#b97a1a", "take out": "#3f9163"}
"""Colours of the bars of a task."""
_TICKS = (6, 15, 30, 60, 120, 300, 600, 1800, 3600, 7200, 14400, 28800)
"""Seconds between two lines of its chart."""
_MOST_TICKS = 10
_CHIPS = {
    **{"holds": "good", "violated": "bad", "unknown": "warn", "not checked": "warn"},
    **{"clash": "bad", "contained": "bad", "duplicate": "bad"},
}

FileLink = Callable[[str, bytes], str | None]
"""The address of a file by its name and content; None: it is left out."""


def html_page(report: Report, media: Media, folder: str | None = None) -> bytes:
    """The page. folder: of the files beside it, relative; None: films are embedded, and the mock-up is not."""
    embedded = _Embedded()
    writer = _Page(report, media, _linked(folder) if folder is not None else embedded.link, folder)
    body = "\n".join(writer.body())
    script, style = SCRIPT.strip("\n"), STYLE.strip("\n")
    policy = "; ".join(
        [
            *("default-src 'none'", "img-src data:", f"style-src {_digest(style)}", f"script-src {_digest(script)}"),
            *("base-uri 'none'", "form-action 'none'"),
        ]
    )
    page = f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{_text(f"Report: {report.title}")}</title>
<style>{style}</style>
</head>
<body>
{body}
<script>{script}</script>
</body>
</html>
"""
    return page.encode("utf-8", errors="replace")


def files_of(media: Media) -> dict[str, bytes]:
    """The files beside the page, by name."""
    return {**{f"{key}.glb": data for key, data in media.films.items()}, **({PAGE: media.page} if media.page else {})}


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode('ascii')}'"


def _linked(folder: str) -> FileLink:
    return lambda name, _data: quote(f"{folder}/{name}")


class _Embedded:
    def __init__(self) -> None:
        self._left = MOST_EMBEDDED

    def link(self, _name: str, data: bytes) -> str | None:
        """The file inside of the address; None where the page would become too large."""
        if len(data) > self._left:
            return None
        self._left -= len(data)
        return "data:model/gltf-binary;base64," + base64.b64encode(data).decode("ascii")


def _text(text: str) -> str:
    """Text of files and people, harmless, and with its own direction of writing."""
    return escape(text.replace("\0", "\ufffd"))


def _named(text: str) -> str:
    return f"<bdi>{_steps(text)}</bdi>"


def _steps(text: str) -> str:
    """A name that may be broken after the steps of its path."""
    return _text(text).replace("/", "/<wbr>")


def _part(path: str, kind: str = "") -> str:
    """A part by its name, and the folder that it is in."""
    folder = path.rstrip("/").rpartition("/")[0]
    name = f'<bdi class="{kind}">{_steps(name_of(path))}</bdi>' if kind else _named(name_of(path))
    where = f" <bdi class=folder>{_steps(folder)}</bdi>" if folder else ""
    return f"<span class=part>{name}{where}</span>"


def _chip(word: str, kind: str | None = None) -> str:
    return f'<span class="chip {_CHIPS.get(word, "") if kind is None else kind}">{_text(word)}</span>'


def _gantt(steps: Sequence[TaskStepRow]) -> str:
    """The steps of a task over minutes: a row for each, numbered by its person."""
    end = max(max(step.start + step.seconds for step in steps), 1e-3)
    width, names, row = 900.0, 240.0, 18.0
    height = row * (len(steps) + 1)
    scale = (width - names - 60.0) / end
    lines = [f"<svg viewBox='0 0 {width:g} {height:g}' role=img aria-label='Gantt chart of the steps'>"]
    ticks = next((each for each in _TICKS if end / each <= _MOST_TICKS), end / _MOST_TICKS)
    for count in range(int(end / ticks) + 1):
        x = names + count * ticks * scale
        lines.append(f"<line x1={x:.1f} x2={x:.1f} y1=0 y2={height - row:g} stroke='var(--line)' />")
        said = f"{count * ticks / 60.0:.3g} min"
        lines.append(f"<text x={x:.1f} y={height - 5:g} font-size=11 fill='var(--soft)'>{said}</text>")
    for number, step in enumerate(steps):
        y, x = number * row, names + step.start * scale
        said = f"{step.number} {step.verb} {name_of(step.path)}"
        title = f"{said}: {clock(step.seconds)}, person {step.person}"
        lines += [
            f"<text x=0 y={y + 13:g} font-size=11 fill='var(--ink)'>{_text(said[:40])}</text>",
            f"<text x={names - 16:g} y={y + 13:g} font-size=11 fill='var(--soft)'>{step.person}</text>",
            f"<rect x={x:.1f} y={y + 3:g} width={max(1.0, step.seconds * scale):.1f} height={row - 6:g} "
            f"fill='{_VERBS.get(step.verb, '#888')}'><title>{_text(title)}</title></rect>",
        ]
    return "".join([*lines, "</svg>"])


def _facts(facts: Iterable[tuple[str, str]]) -> str:
    """Names and figures; the figures are HTML."""
    return "<dl>" + "".join(f"<dt>{_text(name)}</dt><dd>{figure}</dd>" for name, figure in facts if figure) + "</dl>"


def _listed(items: Sequence[str]) -> str:
    left = len(items) - MOST_LISTED
    more = f"<li>and {left:,} more</li>" if left > 0 else ""
    return "<ul class=plain>" + "".join(f"<li>{each}</li>" for each in items[:MOST_LISTED]) + f"{more}</ul>"


def _stale(text: str) -> str:
    return f"<p class=stale>Out of date: {_text(text)}.</p>" if text else ""


def _moved(is_moved: bool, text: str = "Parts were moved since.") -> str:
    return _remark(text) if is_moved else ""


def _remark(said: object) -> str:
    return f"<p class=soft>{_text(text)}</p>" if (text := str(said)) else ""


def _bytes(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{max(1, round(count / 1e3))} kB"


def _clearance(way: WayRow) -> str:
    return "not measured" if way.clearance is None else length(way.clearance)


class _Page:
    def __init__(self, report: Report, media: Media, link: FileLink, folder: str | None) -> None:
        self._report, self._media, self._link, self._folder = report, media, link, folder
        self._number = {id(row): number for number, row in enumerate(report.findings, start=1)}

    def body(self) -> list[str]:
        """The elements of the page."""
        return [
            *self._head(),
            "<main>",
            *self._requirements(),
            *self._findings(),
            *self._questions(),
            *self._steps(),
            *self._maintenance(),
            *self._about(),
            "</main>",
            *self._foot(),
        ]

    # ---- head ----

    def _head(self) -> list[str]:
        report = self._report
        sections = [
            ("requirements", "Requirements", bool(report.requirements)),
            ("findings", "Findings", report.check is not None),
            ("questions", "Questions", bool(report.questions)),
            ("steps", "Work steps", bool(report.steps)),
            ("maintenance", "Maintenance", report.maintenance is not None),
            ("about", "About this report", True),
        ]
        links = "".join(f'<a href="#{key}">{name}</a>' for key, name, is_there in sections if is_there)
        page = self._page_link()
        return [
            "<header>",
            f"<p class=made>Report of {_named(report.project)}, {_text(report.made)}</p>",
            f"<h1>{_named(report.title)}</h1>",
            f"<nav aria-label=Contents>{links}{page}</nav>",
            *self._tiles(),
            *self._notices(),
            "</header>",
        ]

    def _page_link(self) -> str:
        if self._media.page is None or self._folder is None:
            return ""
        href = self._link(PAGE, self._media.page)
        return f'<a href="{escape(href or "")}">Open the mock-up: look around, play the ways</a>'

    def _finding_link(self, row: FindingRow) -> str:
        """To the finding in the page with the mock-up."""
        if self._media.page is None or self._folder is None:
            return ""
        href = f"{self._link(PAGE, self._media.page)}#finding={quote(row.id, safe='')}"
        return f'<p><a href="{escape(href)}" target=_blank rel=noopener>Show it in the mock-up</a></p>'

    def _tiles(self) -> list[str]:
        report = self._report
        tiles = []
        if report.requirements:
            counts = Counter(row.status for row in report.requirements)
            wrong, count = counts["violated"], len(report.requirements)
            kind = "bad" if wrong else "good" if counts["holds"] == count else ""
            said = f"{wrong:,} violated" if wrong else f"{counts['holds']:,} hold"
            tiles.append(("requirements", said, f"of {plural(count, 'requirement')}", kind))
        if report.check is not None:
            rows = [row for row in report.findings if not row.is_touching]
            left = sum(row.status in _OPEN for row in rows)
            touching = len(report.findings) - len(rows)
            beside = f", {plural(touching, 'contact')} not counted" if touching else ""
            said = f"of {plural(len(rows), 'finding')}{beside}"
            tiles.append(("findings", f"{left:,} open", said, "bad" if left else "good"))
        if report.questions:
            good = sum(row.is_good is True for row in report.questions)
            tiles.append(("questions", f"{good:,} of {len(report.questions):,}", "questions answered yes", ""))
        if report.steps:
            free = [row.length for row in report.steps if not row.joint]
            joints = len(report.steps) - len(free)
            kinds = [f"{length(sum(free))} of ways"] if free else []
            kinds += [plural(joints, "move") + " of joints"] if joints else []
            tiles.append(("steps", plural(len(report.steps), "work step"), ", ".join(kinds), ""))
        if report.maintenance is not None:
            maintained = report.maintenance.rows
            out = sum(row.state == "out" for row in maintained)
            kind = "bad" if any(row.is_worse for row in maintained) else ""
            tiles.append(("maintenance", f"{out:,} of {len(maintained):,}", "parts come out", kind))
        if not tiles:
            return ["<p class=notice>The project has no requirements, findings, questions or work steps yet.</p>"]
        items = "".join(
            f'<a class="tile {kind}" href="#{key}"><b>{big}</b><span>{small}</span></a>'
            for key, big, small, kind in tiles
        )
        return [f"<div class=tiles>{items}</div>"]

    def _notices(self) -> list[str]:
        report, stale = self._report, self._report.stale
        found = []
        if self._media.is_partial:
            found.append(
                "<div class='notice bad'><p>This report was stopped: pictures and films are missing. Its lists are "
                "complete.</p></div>"
            )
        if stale:
            lists = [
                f"<li>{len(paths):,} {name}: {', '.join(_named(name_of(path)) for path in paths[:8])}"
                f"{f' and {len(paths) - 8:,} more' if len(paths) > 8 else ''}</li>"
                for name, paths in (
                    *(("changed", stale.changed), ("moved", stale.moved), ("new", stale.new), ("gone", stale.gone)),
                    ("renamed", [*stale.renamed.values()]),
                )
                if paths
            ]
            found.append(
                "<div class=notice><p><b>The mock-up has changed since these results.</b> Results that concern the "
                f"parts below are marked as out of date.</p><ul>{''.join(lists)}</ul></div>"
            )
        if report.notes:
            found.append("<div class=notice>" + "".join(f"<p>{_text(note)}</p>" for note in report.notes) + "</div>")
        return found

    # ---- requirements ----

    def _requirements(self) -> list[str]:
        rows = self._report.requirements
        if not rows:
            return []
        lines = [self._requirement_line(row) for row in rows]
        cards = [self._requirement_card(row) for row in rows if f"requirement-{row.id}" in self._media.pictures]
        return [
            "<h2 id=requirements>Requirements</h2>",
            "<p>Clearances that must hold between parts.</p>",
            _SCROLL + "<table><thead><tr><th>Requirement<th>Between<th class=number>Required<th>Verdict"
            "<th>Where</tr></thead><tbody>",
            *lines,
            "</tbody></table></div>",
            *(["<div class=cards>", *cards, "</div>"] if cards else []),
        ]

    def _requirement_line(self, row: RequirementRow) -> str:
        where = f"{_part(row.path_a)}<br>{_part(row.path_b)}" if row.path_a and row.path_b else ""
        more = f"<br><span class=soft>and {plural(row.pairs - 1, 'pair')} more</span>" if row.pairs > 1 else ""
        return (
            f"<tr><td>{_named(row.name)}<td class=between><code>{_text(row.a)}</code><br><code>{_text(row.b)}</code>"
            f"<td class=number>{length(row.required) if row.required else 'no overlap'}"
            f"<td>{_chip(row.status)}{_chip('out of date', 'warn') if row.stale else ''}<br>{_text(row.sentence)}"
            f"{_remark(row.layout)}{_moved(row.is_moved)}{_stale(row.stale)}"
            f"<td class=where>{where}{_place(row.point)}{more}</tr>"
        )

    def _requirement_card(self, row: RequirementRow) -> str:
        picture = self._picture(f"requirement-{row.id}", f"{row.name}: {row.sentence}")
        return (
            f"<article class=card>{picture}<div class=text><h4>{_named(row.name)}</h4>"
            f"<p>{_part(row.path_a, 'a')}<br>{_part(row.path_b, 'b')}</p><p>{_text(row.sentence)}</p></div></article>"
        )

    # ---- findings ----

    def _findings(self) -> list[str]:
        report, check = self._report, self._report.check
        if check is None:
            return []
        contact = check.contact if isinstance(check.contact, str) else length(check.contact) if check.contact else "0"
        limits = f"Clearance {length(check.clearance) if check.clearance else '0'}, contact {contact}."
        of = f" Only pairs with {', '.join(_named(name_of(path)) for path in check.of[:5])}" if check.of else ""
        of += f" and {len(check.of) - 5:,} more were checked." if len(check.of) > 5 else " were checked." if of else ""
        hidden = sum(check.hidden.values())
        hides = f" Rules hide {plural(hidden, 'pair')}." if hidden else ""
        pictured = [row for row in report.findings if f"finding-{row.id}" in self._media.pictures]
        return [
            "<h2 id=findings>Findings</h2>",
            f"<p>Parts that overlap, touch or are too near. {_text(limits)}{of}{hides}</p>",
            _remark(check.layout),
            _moved(check.is_moved, "Parts were moved since this check."),
            self._counts(report.findings),
            *self._finding_cards(pictured),
            *self._finding_table(report.findings),
            *self._resolved(),
        ]

    def _counts(self, rows: Sequence[FindingRow]) -> str:
        if not rows:
            return "<p>The check found nothing.</p>"
        verdicts = list(dict.fromkeys(row.verdict for row in rows))[:12]
        counts = Counter((row.status, row.verdict) for row in rows)
        totals = Counter(row.status for row in rows)
        head = "".join(f"<th class=number>{_text(each)}" for each in verdicts)
        lines = [
            f"<tr><th>{status}"
            + "".join(f"<td class=number>{counts[status, each] or ''}" for each in verdicts)
            + f"<td class=number><b>{totals[status]:,}</b></tr>"
            for status in STATUSES
            if totals[status]
        ]
        return (
            _SCROLL + f"<table class=narrow><thead><tr><th>Status{head}<th class=number>all</tr></thead>"
            f"<tbody>{''.join(lines)}</tbody></table></div>"
        )

    def _finding_cards(self, rows: Sequence[FindingRow]) -> list[str]:
        """Findings with pictures, by status and group."""
        found = []
        for status in STATUSES:
            mine = [row for row in rows if row.status == status]
            if not mine:
                continue
            found.append(f"<h3>{_text(status.capitalize())}</h3><div class=cards>")
            order = {group: number for number, group in enumerate(dict.fromkeys(row.group for row in mine))}
            found += [self._finding_card(row) for row in sorted(mine, key=lambda row: order[row.group])]
            found.append("</div>")
        left = len(self._report.findings) - len(rows)
        if rows and left > 0:
            touching = sum(row.is_touching for row in self._report.findings) - sum(row.is_touching for row in rows)
            of = f", {plural(touching, 'contact')} among them" if touching else ""
            found.append(f"<p class=soft>{plural(left, 'more finding')} without a picture{of}: see the list.</p>")
        return found

    def _finding_card(self, row: FindingRow) -> str:
        number = self._number[id(row)]
        history = ""
        if row.history:
            lines = [
                f"{_text(mark.at[:10])} {_text(mark.status)}{f' by {_named(mark.by)}' if mark.by else ''}"
                for mark in row.history[-5:]
            ]
            history = f"<p class=soft>{', '.join(lines)}</p>"
        return (
            f"<article class=card>{self._picture(f'finding-{row.id}', row.sentence)}<div class=text>"
            f'<h4><a href="#f{number}">F{number}</a> {_text(row.sentence)}</h4>'
            f"<p>{_chip(row.verdict)} {_chip(row.status, '')}{_severity(row)}</p>"
            f"<p>{_part(row.a, 'a')}<br>{_part(row.b, 'b')}</p>"
            f"{f'<p class=soft>Group: {_named(row.group)}</p>' if row.group else ''}{_note(row)}{history}"
            f"{_stale(row.stale)}{self._finding_link(row)}</div></article>"
        )

    def _finding_table(self, rows: Sequence[FindingRow]) -> list[str]:
        if not rows:
            return []
        found = [
            "<h3>All findings</h3>",
            "<p class=filter hidden><label>Filter <input type=search id=filter></label> <span id=count></span></p>",
            _SCROLL,
        ]
        for key, mine in _runs(rows):
            for begin in range(0, len(mine), CHUNK):
                some = mine[begin : begin + CHUNK]
                said = f"{key}: {len(mine):,}"
                if len(mine) > CHUNK:
                    said += f" ({begin + 1:,} to {begin + len(some):,})"
                found.append(f'<div class="{chunk_class(len(some))}">{_LIST_HEAD}<tr><th colspan=7>{_text(said)}</tr>')
                found += [self._finding_line(row) for row in some]
                found.append("</tbody></table></div>")
        return [*found, "</div>"]

    def _finding_line(self, row: FindingRow) -> str:
        number = self._number[id(row)]
        at = " ".join(f"{value:.4f}" for value in row.point) if row.point else ""
        marks = "".join(
            f"<br><span class=soft>{_text(mark.at[:10])} {_text(mark.status)}"
            f"{f' by {_named(mark.by)}' if mark.by else ''}</span>"
            for mark in row.history[-5:]
        )
        return (
            f'<tr id="f{number}"><td>F{number}<td>{_chip(row.verdict)}{_severity(row)}'
            f"<td class=short>{_text(row.extent)}"
            f"<td>{_part(row.a)}<br>{_part(row.b)}<td>{_named(row.group)}{_rule(row)}"
            f"<td>{_note(row)}{marks}{_stale(row.stale)}<td class='number at'>{at}</tr>"
        )

    def _resolved(self) -> list[str]:
        rows = self._report.resolved
        if not rows:
            return []
        lines = [f"{_part(row.a)} and {_part(row.b)}: {_text(row.verdict)}, {_text(row.extent)}" for row in rows]
        return [f"<h3>Resolved since the check before: {len(rows):,}</h3>", _listed(lines)]

    # ---- questions ----

    def _questions(self) -> list[str]:
        rows = self._report.questions
        return ["<h2 id=questions>Questions</h2>", *(self._question(row) for row in rows)] if rows else []

    def _question(self, row: QuestionRow) -> str:
        chip = {True: _chip("yes", "good"), False: _chip("no", "bad"), None: ""}[row.is_good]
        parts = [
            f"<article class='card wide'><h3>{_text(row.title)}</h3>",
            f"<p>{chip} {_text(row.sentence)}</p>",
            f"<p class=soft>About the mock-up: {_text(row.setting)}.</p>" if row.setting else "",
            _moved(row.is_moved) + _stale(row.stale),
        ]
        if row.facts:
            parts.append(_facts((name, _text(figure)) for name, figure in row.facts))
        if row.task:
            parts.append(_gantt(row.task) + self._task(row))
        if row.notes:
            parts.append(_listed([_text(note) for note in row.notes]))
        if row.task:
            parts += [self._film(way) for way in row.ways]
        elif row.is_order and row.ways:
            parts.append(self._step_list(row.ways))
        else:
            parts += [self._way(way) for way in row.ways]
        if row.ways:
            parts.append(self._film_link(f"question-{row.id}"))
        if row.blockers:
            lines = [
                _part(each.path)
                + (" <b>holds it: proven</b>" if each.is_proof else f" stopped {plural(each.attempts, 'attempt')}")
                for each in row.blockers
            ]
            parts.append(f"<h4>{'In the way' if row.is_good is False else 'Beside the way'}</h4>{_listed(lines)}")
        if row.reaches:
            parts.append(self._reaches(row))
        return "".join([*parts, "</article>"])

    def _task(self, row: QuestionRow) -> str:
        lines = "".join(
            f"<tr><td class=number>{step.number}<td>{_text(step.verb)} {_part(step.path)}<td>{_text(step.tool)}"
            f"<td class=number>{step.person}<td class=number>{_text(clock(step.start))}"
            f"<td class=number>{step.seconds:.1f} ± {step.spread:.1f}"
            f"<td>{_chip(step.edited, 'warn') + ' ' if step.edited else ''}{_text(step.arithmetic)}"
            f"<td>{_text(step.because)}</tr>"
            for step in row.task
        )
        return (
            _SCROLL + "<table><thead><tr><th class=number>No.<th>Step<th>Tool<th class=number>Person"
            "<th class=number>From<th class=number>Seconds<th>Arithmetic<th>Because"
            f"</tr></thead><tbody>{lines}</tbody></table></div>"
        )

    def _way(self, way: WayRow) -> str:
        legs = "; ".join(way.legs[:12]) + (f"; and {len(way.legs) - 12:,} more" if len(way.legs) > 12 else "")
        facts = [
            ("parts", ", ".join(map(_part, way.paths[:MOST_LISTED])) + _more(len(way.paths) - MOST_LISTED)),
            ("way", f"{length(way.length)}{_turn(way.rotation)}"),
            ("least clearance", _clearance(way)),
            ("legs", _text(legs)),
        ]
        return f"{_facts(facts)}{_stale(way.stale)}{self._film(way)}{_curve(way)}"

    def _reaches(self, row: QuestionRow) -> str:
        lines = "".join(
            f"<tr><td>{_part(each.path)}<td>{_text(each.kind)}<td>{_names(each.tools) or _named(each.tool)}"
            f"<td>{_chip('reachable', 'good') if each.is_reachable else _chip('not reachable', 'bad')}"
            f"<td class=number>{each.swing_deg:.0f}°<td>{_text(each.because)}"
            f"{f'<br><span class=soft>{_names(each.blockers)}</span>' if each.blockers else ''}</tr>"
            for each in row.reaches
        )
        return (
            _SCROLL + "<table><thead><tr><th>Fastener<th>Kind<th>Tool<th>Access<th class=number>Free swing"
            f"<th>Why</tr></thead><tbody>{lines}</tbody></table></div>"
        )

    # ---- steps ----

    def _steps(self) -> list[str]:
        rows = self._report.steps
        if not rows:
            return []
        return [
            "<h2 id=steps>Work steps</h2>",
            f"<p>The parts in the order in which they {'move or ' if any(row.joint for row in rows) else ''}leave.</p>",
            self._step_list(rows),
            self._film_link("sequence"),
        ]

    def _step_list(self, rows: Sequence[WayRow]) -> str:
        return f"<ol class=steps>{''.join(self._step(row) for row in rows)}</ol>"

    def _step(self, row: WayRow) -> str:
        facts = [
            ("joint", _text(row.joint)),
            ("way", "" if row.joint else f"{length(row.length)}{_turn(row.rotation)}"),
            ("least clearance", "" if row.joint else _clearance(row)),
            ("tool", _named(row.tool) if row.tool else ""),
            ("touched", _names(row.touched)),
            ("checked", _text(row.checked)),
            ("legs", _text("; ".join(row.legs[:6]) + _more(len(row.legs) - 6))),
        ]
        parts = ", ".join(map(_part, row.paths[:MOST_LISTED])) + _more(len(row.paths) - MOST_LISTED)
        return (
            f"<li><div><h4>{_named(row.title)}</h4><div>{parts}</div>{_facts(facts)}{_stale(row.stale)}</div>"
            f"{self._film(row)}</li>"
        )

    # ---- maintenance ----

    def _maintenance(self) -> list[str]:
        run = self._report.maintenance
        if run is None:
            return []
        partial = "<p class=notice>The run was interrupted: rows are missing.</p>" if run.is_partial else ""
        return [
            "<h2 id=maintenance>Maintenance</h2>",
            f"<p>How long each part takes to take out, by the run of {_text(run.at)}: {_text(run.sentence)}.</p>",
            partial + _stale(run.stale),
            _SCROLL + "<table><thead><tr><th>Part<th>State<th class=number>Time<th class=number>Spread<th>Tools"
            "<th class=number>Reach<th class=number>Sight<th>Change</tr></thead><tbody>",
            *(_maintained(row) for row in run.rows),
            "</tbody></table></div>",
        ]

    # ---- pictures and films ----

    def _picture(self, key: str, alt: str) -> str:
        frames = self._media.pictures.get(key, [])
        return _image(frames[0], alt) if frames else ""

    def _film(self, row: WayRow) -> str:
        frames = self._media.pictures.get(row.key, [])
        if not frames:
            return ""
        pictures = "".join(
            _image(frame, f"{row.title}, picture {number} of {len(frames)} of the way")
            for number, frame in enumerate(frames, start=1)
        )
        if len(frames) < 3:
            return f"<figure class=film><div class='frames two'>{pictures}</div></figure>"
        player = (
            "<div class=player><button type=button>Play</button>"
            f'<input type=range min=0 max={len(frames) - 1} value=0 aria-label="{_text("Way of " + row.title)}"></div>'
        )
        return f"<figure class=film data-film><div class=frames>{pictures}</div>{player}</figure>"

    def _film_link(self, key: str) -> str:
        data = self._media.films.get(key)
        if data is None:
            return ""
        href = self._link(f"{key}.glb", data)
        if href is None:
            return f"<p class=soft>The film ({_bytes(len(data))}) is left out: this page would become too large.</p>"
        return (
            f'<p class=link><a href="{escape(href)}" download="{escape(key)}.glb">Film as animated GLB</a> '
            f"<span class=soft>{_bytes(len(data))}; opens in viewers of glTF</span></p>"
        )

    # ---- about ----

    def _about(self) -> list[str]:
        report = self._report
        facts = [
            ("mock-up", _names(report.sources) or _named(report.title)),
            ("content", f"<code>{_text(report.content)}</code>" if report.content else ""),
            ("size", f"{plural(report.parts, 'part')}, {plural(report.triangles, 'triangle')}"),
            ("project", _named(report.project)),
            ("tool", _named(report.tool) if report.tool else ""),
            ("changes", _text(str(report.stale)) if report.stale else "none since the results"),
            ("made", _text(report.made)),
            ("by", _text(f"feeler {report.version}".strip())),
        ]
        return ["<h2 id=about>About this report</h2>", _facts(facts)]

    def _foot(self) -> list[str]:
        return [
            "<footer><p>Lengths are of the triangles of the mock-up. A way is verified by continuous collision "
            "detection; that none was found is a proof only where the text says so. In pictures of two parts, the "
            "<span class=a>first</span> is blue and the <span class=b>second</span> orange, cut open where they "
            "overlap or hide the place in the red ring; other parts are faint.</p></footer>"
        ]


def _maintained(row: MaintenanceRow) -> str:
    """A row of a run of `feeler maintain`."""
    chip = _chip(row.state, {"out": "good", "failed": "bad"}.get(row.state, "warn"))
    paths = [path for path in row.paths if path != row.name]
    time, spread = ("" if each is None else _text(clock(each)) for each in (row.seconds, row.spread))
    seen = "" if row.sight is None else f"{row.sight:.0%}"
    return (
        f"<tr><td>{_named(row.name)}{_soft(_names(paths))}{_soft(_text(row.renamed_from))}"
        f"<td>{chip}{_soft(_text(row.why))}<td class=number>{time}<td class=number>{spread}<td>{_names(row.tools)}"
        f"<td class=number>{'' if row.reach_deg is None else f'{row.reach_deg:.0f}°'}"
        f"<td class=number>{seen}{_soft(f'{row.hidden:,} not seen' if row.hidden else '')}"
        f"<td>{_chip('worse', 'bad') if row.is_worse else ''} {_text(row.change)}</tr>"
    )


def _soft(text: str) -> str:
    """A line below another; text is HTML."""
    return f"<br><span class=soft>{text}</span>" if text else ""


def _image(data: bytes, alt: str) -> str:
    width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    address = base64.b64encode(data).decode("ascii")
    return f'<img alt="{_text(alt)}" width={width} height={height} src="data:image/png;base64,{address}">'


def _runs(rows: Sequence[FindingRow]) -> list[tuple[str, list[FindingRow]]]:
    """Findings by status; contacts by themselves, at the end."""
    found: dict[str, list[FindingRow]] = {}
    for row in rows:
        key = f"contacts, {row.status}" if row.is_touching else row.status
        found.setdefault(key, []).append(row)
    return list(found.items())


def _severity(row: FindingRow) -> str:
    return "" if row.severity == "major" else f" {_chip(row.severity, 'bad' if row.severity == 'critical' else '')}"


def _rule(row: FindingRow) -> str:
    return f"<br><span class=soft>rule: {_named(row.rule)}</span>" if row.rule not in ("", "default") else ""


def _note(row: FindingRow) -> str:
    if not row.note and not row.by:
        return ""
    by = f"<span class=soft>{_named(row.by)}:</span> " if row.by else ""
    return f"<p>{by}{_named(row.note)}</p>"


def _place(point: Sequence[float] | None) -> str:
    if point is None:
        return ""
    return f"<br><span class=soft>at {', '.join(f'{value:.4f}' for value in point)} m</span>"


def _curve(way: WayRow) -> str:
    """The gap along a way, as a drawing; empty if it is not known."""
    known = [(share, gap) for share, gap in way.gaps if gap is not None]
    most = max((gap for _, gap in known), default=0.0)
    if len(known) < 2 or most <= 0.0:
        return ""
    lines: list[list[str]] = [[]]
    for share, gap in way.gaps:
        if gap is None:
            lines.append([])
        else:
            lines[-1].append(f"{_CURVE[0] * share:.1f},{_CURVE[1] * (1.0 - gap / most):.1f}")
    drawn = "".join(f'<polyline points="{" ".join(line)}"/>' for line in lines if len(line) > 1)
    share, least = min(known, key=lambda each: each[1])
    said = f"Gap to the nearest neighbour; the smallest of those measured is {length(least)}, at {share:.0%} of the way"
    return (
        f'<figure class=curve><svg viewBox="0 -4 {_CURVE[0]} {_CURVE[1] + 8}" role=img aria-label="{_text(said)}">'
        f'<path d="M0 {_CURVE[1]}H{_CURVE[0]}"/>{drawn}</svg><figcaption>{_text(said)}.</figcaption></figure>'
    )


def _turn(rotation: float | None) -> str:
    return f", turned by {math.degrees(rotation):.0f}°" if rotation is not None and rotation > 0.01 else ""


def _names(paths: Sequence[str]) -> str:
    return ", ".join(_named(name_of(path)) for path in paths[:8]) + _more(len(paths) - 8)


def _more(left: int) -> str:
    return f" and {left:,} more" if left > 0 else ""
