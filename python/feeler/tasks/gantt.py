"""A task as one HTML page that loads nothing: a Gantt chart by person, totals, and the arithmetic of each step."""

from __future__ import annotations

import os
from collections.abc import Iterable
from html import escape

from feeler.atomic import atomic_file
from feeler.tasks.steps import TaskFacts, TaskStep, clock
from feeler.tasks.times import EXAMPLES

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'"
_STYLE = """
:root { color-scheme: light dark; --line: #8885; --soft: #8882; }
body { font: 14px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1200px; padding: 1.5em; }
h1, p { overflow-wrap: anywhere; }
h1 { font-size: 1.5em; margin: 0 0 .2em; } h2 { font-size: 1.15em; margin: 2em 0 .6em; }
svg { width: 100%; height: auto; font-size: 11px; } svg text { fill: currentColor; }
.blocked { border-left: 4px solid #d33; padding: .4em .8em; background: #d331; }
.note { border-left: 4px solid #38f; padding: .4em .8em; background: #38f1; }
table { border-collapse: collapse; width: 100%; }
th, td { padding: .35em .6em; text-align: left; vertical-align: top; overflow-wrap: anywhere; }
th { border-bottom: 2px solid var(--line); overflow-wrap: normal; } td { border-bottom: 1px solid var(--soft); }
.number { text-align: right; white-space: nowrap; }
@media (max-width: 800px) { table { display: block; overflow-x: auto; } td { overflow-wrap: break-word; } }
"""
_WIDTH, _NAMES, _ROW = 1000.0, 300.0, 18.0
"""Of the chart, of its column of names, and of a row, in its own units."""
_LABEL = 70.0
"""The widest label of a time."""
_TICKS = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 28800, 86400)
"""Seconds between two lines of the chart."""
_MOST_TICKS = 10
_HUES = (212, 28, 145, 275, 350, 185, 48, 315)
"""Of tools, in order of their first use; by hand is grey."""


def write_html(path: str | os.PathLike[str], task: TaskFacts) -> None:
    """Writes the page. Raises `WriteError`."""
    title = f"Take out {', '.join(task.parts[:3])}{' and more' if len(task.parts) > 3 else ''}"
    page = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body><main>",
        f"<h1>{escape(title)}</h1>",
        f"<p{'' if task.is_found else ' class=blocked'}>{escape(task.said)}</p>",
        *(f'<p class="note">{escape(note)}</p>' for note in task.notes),
        *(_found(task) if task.steps else _blocked(task)),
        *_elements(task),
        "</main></body></html>",
    ]
    with atomic_file(path, ".html") as file:
        file.write("\n".join(page).encode("utf-8", errors="replace"))


def _found(task: TaskFacts) -> list[str]:
    return [
        "<h2>Gantt chart</h2>",
        *_chart(task),
        "<h2>Totals</h2>",
        *_table(
            ("", "seconds", "spread"),
            [
                *(
                    (f"tool: {name or 'by hand'}", f"{each.mean:.1f}", f"{each.spread:.1f}")
                    for name, each in task.by_tool.items()
                ),
                *(
                    (f"person {person + 1}", f"{each.mean:.1f}", f"{each.spread:.1f}")
                    for person, each in task.by_person.items()
                ),
                ("work of all", f"{task.work.mean:.1f}", f"{task.work.spread:.1f}"),
                ("from beginning to end", f"{task.seconds:.1f}", f"{task.spread:.1f}"),
                ("no plan is below", f"{task.bound:.1f}", ""),
            ],
            (1, 2),
        ),
        "<h2>Steps</h2>",
        *_table(
            ("#", "step", "tool", "from", "seconds", "low", "high", "arithmetic", "because"),
            [
                (
                    *(str(step.number + 1), f"{step.verb} {_names(step)}", step.tool, clock(step.start)),
                    *(f"{step.seconds:.1f}", f"{step.low:.1f}", f"{step.high:.1f}", step.arithmetic, step.because),
                )
                for step in task.steps
            ],
            (0, 4, 5, 6),
        ),
    ]


def _blocked(task: TaskFacts) -> list[str]:
    return [
        "<h2>Blocked</h2>",
        *_table(
            ("part", "why", "in its way"),
            [(each.part, each.because, ", ".join(each.blockers)) for each in task.blocked],
        ),
    ]


def _elements(task: TaskFacts) -> list[str]:
    return [
        "<h2>Elements</h2>",
        *_table(
            ("element", "seconds", "spread", "what"),
            [
                (name, f"{mean:g}", f"{spread:g}", EXAMPLES[name][2] + (" (example)" if name in task.examples else ""))
                for name, (mean, spread) in task.elements.items()
            ],
            (1, 2),
        ),
    ]


def _names(step: TaskStep) -> str:
    more = len(step.paths) - 1
    return step.part + (f" and {more} more" if more > 0 else "")


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]], numbers: tuple[int, ...] = ()) -> list[str]:
    def line(cells: tuple[str, ...], tag: str) -> str:
        marked = (f"<{tag}{' class=number' if n in numbers else ''}>{escape(c)}</{tag}>" for n, c in enumerate(cells))
        return f"<tr>{''.join(marked)}</tr>"

    return ["<table>", line(heads, "th"), *(line(row, "td") for row in rows), "</table>"]


def _chart(task: TaskFacts) -> list[str]:
    """A row for each step: a bar from its start to its end, in the colour of its tool, and its spread."""
    end = max((step.start + step.high for step in task.steps), default=1.0) or 1.0
    scale = (_WIDTH - _NAMES - 10.0) / end
    height = _ROW * (len(task.steps) + 1)
    colours = {name: f"hsl({_HUES[n % len(_HUES)]} 60% 50%)" for n, name in enumerate(task.tools)}
    lines = [f'<svg viewBox="0 0 {_WIDTH:g} {height:g}" role="img" aria-label="Gantt chart">']
    tick = next((each for each in _TICKS if end / each <= _MOST_TICKS), _TICKS[-1])
    for n in range(int(end / tick) + 1):
        x = _NAMES + n * tick * scale
        lines.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{height - _ROW:g}" stroke="#8885"/>')
        anchor = ' text-anchor="end"' if x > _WIDTH - _LABEL else ""
        lines.append(f'<text x="{x:.1f}" y="{height - 5:g}"{anchor}>{escape(clock(n * tick))}</text>')
    for n, step in enumerate(task.steps):
        y, x = n * _ROW, _NAMES + step.start * scale
        name = f"{step.number + 1} {step.verb} {'/'.join(step.part.split('/')[-2:])}"
        said = f"{step}: {clock(step.seconds)} +- {clock(step.spread)}, person {step.person + 1}"
        middle, far = y + 0.5 * _ROW, x + step.seconds * scale
        lines += [
            f'<text x="0" y="{y + 13:g}">{escape(name[:44])}</text>',
            f'<rect x="{x:.1f}" y="{y + 3:g}" width="{step.seconds * scale:.1f}" height="{_ROW - 6:g}" '
            f'fill="{colours.get(step.tool, "#888")}"><title>{escape(said)}</title></rect>',
            f'<line x1="{far - step.spread * scale:.1f}" x2="{far + step.spread * scale:.1f}" '
            f'y1="{middle:g}" y2="{middle:g}" stroke="currentColor"/>',
        ]
        if task.people > 1:
            lines.append(f'<text x="{_NAMES - 14:g}" y="{y + 13:g}">{step.person + 1}</text>')
    return [*lines, "</svg>"]
