"""`feeler info`: describes mesh files."""

from __future__ import annotations

from collections import Counter
from typing import Annotated

import typer

import feeler
from feeler.cli.app import command
from feeler.cli.inputs import AsJson, Up, read_mockup
from feeler.cli.values import UNIT
from feeler.words import plural

_SHOWN = 12


@command(
    examples="""
feeler info engine.step
feeler info --unit in bracket.stl housing.stl
feeler info --json plant/ > report.json
"""
)
def info(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE", help="Mesh files or folders, each described on its own.")
    ],
    unit: Annotated[
        str | None,
        typer.Option(help="Unit of the numbers; overrides the files: mm (default if they do not say), cm, m, in, ..."),
        UNIT,
    ] = None,
    up: Up = None,
    all_parts: Annotated[bool, typer.Option("--parts", help="List every part, not only the largest.")] = False,
    as_json: AsJson = False,
) -> None:
    """Shows the contents of mesh files: triangles, parts, extents, unit, defects."""
    from feeler.cli import outputs

    reports = []
    for number, file in enumerate(files):
        mockup = read_mockup([file], unit, up)
        if as_json:
            reports.append({"file": file, **mockup.report.to_dict(), "part_list": _parts(mockup)})
        else:
            if number:
                print()
            _print(mockup, file, all_parts)
    if as_json:
        outputs.print_json({"files": reports})


def _parts(mockup: feeler.Mockup) -> list[dict[str, object]]:
    return [
        {
            "part": part.index,
            "path": part.path,
            "name": part.name,
            "triangles": part.triangles,
            "lower": list(part.lower),
            "upper": list(part.upper),
            "attributes": part.attributes,
        }
        for part in mockup.parts
    ]


def _attributes(mockup: feeler.Mockup) -> str:
    """The names of attributes that most parts have, and of how many parts."""
    counts = Counter(name for row in mockup._part_attributes or () for name in row)
    names = [f"{name} ({plural(count, 'part')})" for name, count in counts.most_common(_SHOWN)]
    return ", ".join(names) + (f", and {len(counts) - _SHOWN:,} more" if len(counts) > _SHOWN else "")


def _print(mockup: feeler.Mockup, file: str, all_parts: bool) -> None:
    from feeler.cli import outputs

    out, report = outputs.console(), mockup.report
    facts = [
        ("file", file),
        ("format", report.source.format),
        ("triangles", f"{report.triangles:,}"),
        ("vertices", f"{report.vertices:,}"),
        ("parts", f"{report.parts:,}"),
        ("unit", f"{report.source.unit} ({report.source.unit_source})"),
        ("up", report.source.up or "not said"),
        ("extent", outputs.extent(report.lower, report.upper)),
        ("lower, m", ", ".join(f"{value:.6g}" for value in report.lower)),
        ("upper, m", ", ".join(f"{value:.6g}" for value in report.upper)),
    ]
    if report.source.seconds and mockup._saved is None:  # a saved scene knows how long its files took, long ago
        facts.append(("loaded in", outputs.duration(report.source.seconds)))
    found = {kind: defect for kind, defect in report.defects.items() if defect.count}
    if not found:
        facts.append(("defects", "none"))
    for kind, defect in found.items():
        fate = "queried" if kind == "duplicate" else "not queried"
        ids = ", ".join(str(index) for index in defect.first[:5]) + (", ..." if defect.count > 5 else "")
        facts.append((kind.replace("_", " "), f"{plural(defect.count, 'triangle')}, {fate}: {ids}"))
    if stated := _attributes(mockup):
        facts.append(("attributes", stated))
    facts += [("note", note) for note in report.source.notes]
    outputs.print_facts(out, facts)
    parts = sorted(mockup.parts, key=lambda part: -part.triangles)
    shown = parts if all_parts else parts[:_SHOWN]
    if len(parts) > 1 or all_parts:
        out.print()
        outputs.print_table(
            out,
            "Parts" if len(shown) == len(parts) else "Largest parts",
            [("part", "left"), ("triangles", "right"), ("extent", "left")],
            [(part.path, f"{part.triangles:,}", outputs.extent(part.lower, part.upper)) for part in shown],
        )
        if len(shown) < len(parts):
            out.print(f"... and {len(parts) - len(shown):,} more (--parts lists all)")
