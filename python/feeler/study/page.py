"""The output of a study: results, samples, and one self-contained page."""

from __future__ import annotations

import base64
import html
import json
from pathlib import Path
from typing import Any

from ..io.csv_table import csv_table
from .cells import write_text
from .plots import MISSING
from .tables import Section, sections_of

_STYLE = """body { color: #222; font: 15px/1.5 sans-serif; max-width: 72em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; font-size: 13px }
th, td { padding: .2em .6em; border-bottom: 1px solid #ddd; text-align: right }
th.word, td.word { text-align: left } img { max-width: 100% }"""


def write_study(
    folder: Path, results: dict[str, Any], samples: tuple[list[str], list[list[Any]]], plots: list[str]
) -> None:
    """Writes `results.json`, `samples.csv` and `index.html`; the plots already exist."""
    slim = {**results, "rows": [_without_samples(row) for row in results["rows"]]}
    write_text(folder / "results.json", json.dumps(slim, indent=1, allow_nan=False) + "\n")
    write_text(folder / "samples.csv", csv_table(*samples).decode("utf-8"))
    write_text(folder / "index.html", _page(results, [folder / f"{name}.png" for name in plots]))


def _without_samples(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_samples(item) for key, item in value.items() if key != "samples_s"}
    if isinstance(value, list):
        return [_without_samples(item) for item in value]
    return value


def markdown(section: Section) -> str:
    """A section's table in Markdown."""
    lines = [
        "| " + " | ".join(section.heading) + " |",
        "|" + "".join("---|" if i < section.words else "---:|" for i in range(len(section.heading))),
    ]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in section.rows)])


def _page(results: dict[str, Any], pictures: list[Path]) -> str:
    """One HTML file with everything in it."""
    sections = sections_of(results)
    parts = [f"<h1>feeler study {html.escape(results['study'])}</h1>"]
    embedded = [_picture(path) for path in pictures]
    for number, section in enumerate(sections):
        parts.append(f"<h2>{html.escape(section.title)}</h2>" if section.title else "")
        parts += [f"<p>{html.escape(paragraph)}</p>" for paragraph in section.text]
        if number == 0:
            parts += embedded or [f"<p>{html.escape(MISSING)}</p>"]
            parts += [f"<p>{html.escape(section.caption)}</p>"] if embedded and section.caption else []
        if section.rows:
            parts.append(_table(section))
    machine = results["machine"]
    constants = ", ".join(f"{name} {1e9 * seconds:.3g} ns" for name, seconds in machine["constants_s"].items())
    parts.append(
        f"<p>feeler {html.escape(machine['feeler'])}, {html.escape(machine['cpu'])}, {machine['cores']} cores, "
        f"{html.escape(machine['system'])}. Measured cost of a {constants}. Every measured time is in "
        '<a href="samples.csv">samples.csv</a>, every figure in <a href="results.json">results.json</a>.</p>'
    )
    head = f'<meta charset="utf-8"><title>feeler study {html.escape(results["study"])}</title><style>{_STYLE}</style>'
    body = "".join(parts)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>{body}</body></html>\n'


def _picture(path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<p><img alt="{html.escape(path.stem)}" src="data:image/png;base64,{data}"></p>'


def _table(section: Section) -> str:
    def cells(tag: str, row: list[str]) -> str:
        words = [' class="word"' if i < section.words else "" for i in range(len(row))]
        return "".join(f"<{tag}{kind}>{html.escape(x)}</{tag}>" for x, kind in zip(row, words, strict=True))

    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in section.rows)
    return f"<table><tr>{cells('th', section.heading)}</tr>{body}</table>"
