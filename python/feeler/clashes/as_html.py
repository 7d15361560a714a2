"""Findings as one HTML page that loads nothing else: summary, groups with pictures, a table with filters."""

from __future__ import annotations

import base64
import json
import os
from html import escape
from typing import Any

from feeler.arguments import check_kind, check_progress, check_whole
from feeler.atomic import atomic_file
from feeler.choices import GroupBy
from feeler.clashes.advice import advice
from feeler.clashes.as_json import statuses
from feeler.clashes.html_page import POLICY, SCRIPT, STYLE
from feeler.clashes.result import Clashes, Group
from feeler.clashes.verdict import Verdict
from feeler.clashes.words import capitalised, extent, hidden, sentence, shared
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.words import length, plural, printable, volume

MOST_GROUPS = 200
"""Most groups on the page, the worst first. Each has a picture, about 30 kB and 0.05 s. The table has all findings."""
MOST_ROWS = 20_000
"""Most findings in the table, the worst first: 6 MB. CSV and JSON have all."""


def write_html(
    path: str | os.PathLike[str],
    clashes: Clashes,
    mockup: Mockup | None = None,
    *,
    by: GroupBy = "part",
    pictures: int = MOST_GROUPS,
    progress: Progress | None = None,
) -> None:
    """Writes the page. It needs no network.

    The table lists the `MOST_ROWS` worst findings. With `mockup`, the `pictures` worst groups show a picture of their
    worst finding. by: how to group, as in `Clashes.groups`. Raises `WriteError`, and `OptionError` for clashes of
    another mock-up.
    """
    check_kind("clashes", clashes, Clashes)
    pictures = check_whole("pictures", pictures)
    check_progress(progress)
    groups = clashes.groups(by)
    drawn = _drawn(clashes, mockup, groups[: min(pictures, MOST_GROUPS)], progress) if mockup is not None else []
    group_of = {int(row): group.name for group in groups for row in group.rows}
    page = "\n".join(
        [
            '<!doctype html><html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{_shown(_title(clashes))}</title><style>{STYLE}</style></head><body><main>",
            f"<h1>{_shown(_title(clashes))}</h1>",
            *_summary(clashes, groups),
            *_groups(groups, drawn),
            *_table(clashes),
            f'</main><script type="application/json" id="data">{_data(clashes, group_of)}</script>',
            f"<script>{SCRIPT}</script></body></html>\n",
        ]
    )
    with atomic_file(path, ".html") as file:
        file.write(page.encode("utf-8", errors="replace"))


def _drawn(clashes: Clashes, mockup: Mockup, groups: list[Group], progress: Progress | None) -> list[str]:
    """The picture of each group's worst finding, as a data URL."""
    from feeler.clashes.pictures import Pictures
    from feeler.clashes.table import check_same

    check_same(mockup, clashes)
    pictures = Pictures(mockup)
    found = []
    for number, group in enumerate(groups):
        if progress is not None:
            progress(number / len(groups), f"picture {number + 1} of {len(groups)}")
        found.append("data:image/png;base64," + base64.b64encode(pictures.png(group.worst)).decode("ascii"))
    return found


def _shown(text: str) -> str:
    """Text for the page: no markup, and control characters, which HTML forbids, as code."""
    return escape(printable(text))


def _title(clashes: Clashes) -> str:
    files = [file.replace("\\", "/").rpartition("/")[2] for file in clashes.facts.files]
    return f"Clashes of {', '.join(files[:3])}{' ...' if len(files) > 3 else ''}" if files else "Clashes"


def _summary(clashes: Clashes, groups: list[Group]) -> list[str]:
    facts = clashes.facts
    contact = facts.contact if isinstance(facts.contact, str) else length(facts.contact) if facts.contact else "0"
    verdicts = [(each.value, len(clashes.where(verdict=each))) for each in Verdict]
    lines = [
        ("mock-up", f"{plural(facts.parts, 'part')}, {plural(facts.triangles, 'triangle')}"),
        ("looked for", f"clearance {length(facts.clearance) if facts.clearance else '0'}, contact {contact}"),
        ("findings", ", ".join(f"{count:,} {name}" for name, count in verdicts if count) or "none"),
        ("status", ", ".join(f"{count:,} {name}" for name, count in statuses(clashes).items() if count) or "none"),
        ("groups", f"{len(groups):,}"),
        *([("shared volume", shared(clashes))] if shared(clashes) else []),
        *([("hidden", hidden(clashes))] if clashes.hidden else []),
    ]
    partial = ["<p class=partial>The check was stopped. More findings may exist.</p>"]
    items = "".join(f"<dt>{_shown(name)}</dt><dd>{_shown(value)}</dd>" for name, value in lines)
    said = [f"<p class=advice>{_shown(capitalised(each))}.</p>" for each in advice(clashes)]
    return [*(partial if clashes.is_partial else []), f"<dl>{items}</dl>", *said]


def _groups(groups: list[Group], drawn: list[str]) -> list[str]:
    if not groups:
        return []
    lines = ["<h2>Groups</h2><div class=groups tabindex=0 role=group aria-label=Groups>"]
    for number, group in enumerate(groups[:MOST_GROUPS]):
        image = f'<img alt="" loading=lazy src="{drawn[number]}">' if number < len(drawn) else ""
        more = plural(len(group), "finding")
        lines.append(
            f'<button type=button class=group aria-pressed=false data-group="{_shown(group.name)}">{image}<span>'
            f"<b>{_shown(group.name).replace('/', '/<wbr>')}</b>{more}; {_shown(sentence(group.worst))}</span></button>"
        )
    left = len(groups) - MOST_GROUPS
    return [*lines, "</div>", f"<p>... and {left:,} more groups, in the table</p>" if left > 0 else ""]


def _table(clashes: Clashes) -> list[str]:
    choices = {
        "verdict": [each.value for each in Verdict],
        "status": ["new", "active", "reviewed", "approved"],
        "severity": ["critical", "major", "minor"],
        "rule": list(dict.fromkeys(clashes.rules.tolist())),
    }
    filters = []
    for name, values in choices.items():
        options = "".join(f'<option value="{_shown(value)}">{_shown(value)}</option>' for value in values)
        filters.append(f'<label>{name} <select id={name}><option value="">any</option>{options}</select></label>')
    volumes = ["shared volume"] if shared(clashes) else []
    heads = ["verdict", "depth or gap", *volumes, "part", "other part", "at, m", "rule", "status"]
    return [
        "<h2>Findings</h2><div class=filters>",
        *filters,
        "<label>text <input type=search id=text></label>",
        "<button type=button id=clear>All</button><span id=count></span></div>",
        f"<table><thead><tr>{''.join(f'<th>{head}</th>' for head in heads)}</tr></thead>",
        "<tbody id=rows></tbody></table>",
        "<p><button type=button id=more hidden></button></p>",
        f"<p>The {MOST_ROWS:,} worst of {len(clashes):,} findings are in this page.</p>"
        if len(clashes) > MOST_ROWS
        else "",
        "<noscript><p>The table needs JavaScript. The page contains its own scripts.</p></noscript>",
    ]


def _data(clashes: Clashes, group_of: dict[int, str]) -> str:
    """The rows of the table as JSON, escaped so that no text can end the script element."""
    has_volumes = bool(shared(clashes))
    found: list[dict[str, Any]] = [
        {
            "id": clash.id,
            "verdict": clash.verdict,
            "extent": extent(clash),
            **({"volume": volume(clash.volume)} if has_volumes else {}),
            "a": printable(clash.path_a),
            "b": printable(clash.path_b),
            "place": " ".join(f"{value:.4f}" for value in clash.point_a),
            "rule": printable(clash.rule),
            "severity": clash.severity,
            "status": clash.status,
            "by": printable(clash.by),
            "note": printable(clash.note),
            "group": printable(group_of[row]),
        }
        for row, clash in enumerate(clashes[:MOST_ROWS])
    ]
    text = json.dumps(found, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
