"""The tables of a run, as Markdown: puzzles, everyone beside each other, and the engine."""

from __future__ import annotations

from functools import partial

from pages import bold, markdown
from section import Result, Section, busy, by_experiment

from . import goals


def puzzles(found: Result) -> str:
    """Each puzzle, and what everyone makes of it."""
    lines = []
    for row in found["puzzles"]:
        for one in row["tries"]:
            wanted = goals.MEDIAN_S.get(row["name"]) if one is row["tries"][0] else None
            median = _seconds(one["median_s"])
            lines.append(
                [
                    *(row["name"], one["planner"], f"{one['found']} of {one['seeds']}"),
                    f"{one['free']}" if one["found"] else "",
                    bold(median, wanted is None or one["median_s"] <= wanted),
                    _seconds(one["worst_s"]),
                ]
            )
    heads = ["puzzle", "planner", "found", "of these free", "median", "worst"]
    versions = found["versions"]
    notes = [
        f"One core, at most {found['seconds']:g} s per attempt, the same seeds for all planners. Free: no collision on "
        "the whole path, by `check_path`. Bold: misses its goal.",
        *(
            [f"OMPL {versions['OMPL']}, with feeler's exact test of a pose as its checker."]
            if "OMPL" in versions
            else []
        ),
        *(f"{name}: {reason}." for name, reason in found["absent"].items()),
    ]
    return f"{SECTION.origin(found, *busy(found))}\n\n{markdown(heads, 2, lines, ' '.join(notes))}"


def engine(found: Result) -> str:
    """Straight ways, parts a minute, access."""
    straight, rate, access = found["straight"], found["rate"], found["access"]
    worst = straight["straight_s"].get("worst")
    straight_said = (
        f"{straight['straight']:,} of {straight['parts']:,} parts have one; median "
        f"{_seconds(straight['straight_s'].get('median'))}, the slowest {_seconds(worst)}"
    )
    minute = 60.0 * rate["parts"] / rate["total_s"]
    lines = [
        [
            f"a straight way, {straight['triangles']:,} triangles",
            f"{_seconds(goals.STRAIGHT_S)} each",
            bold(straight_said, worst is not None and worst <= goals.STRAIGHT_S),
        ],
        [
            f"{rate['parts']} of {rate['all_parts']:,} parts, {rate['triangles']:,} triangles",
            f"{goals.PARTS_A_MINUTE} a minute",
            bold(
                f"{minute:.3g} a minute; {rate['found']} come out, {rate['straight']} of them straight",
                minute >= goals.PARTS_A_MINUTE,
            ),
        ],
        *(
            [
                f"a wrench {row['where']}: {access['targets']} bolts x {access['angles']} angles, "
                f"{access['triangles']:,} triangles",
                f"{goals.ACCESS_S:g} s",
                bold(
                    f"{_seconds(row['total_s'])}; {row['reachable']} can be reached", row["total_s"] <= goals.ACCESS_S
                ),
            ]
            for row in access["rows"]
        ),
        [
            f"finding the fasteners, {access['triangles']:,} triangles",
            "",
            f"{_seconds(access['finding_s'])}; {access['fasteners']:,} found",
        ],
    ]
    note = (
        f"One core. A part has {_seconds(rate['limit_s'])} at most, {_seconds(straight['limit_s'])} for "
        "straight paths only; all other parts are in place. Bold: misses its goal."
    )
    return f"{SECTION.origin(found, *busy(found))}\n\n{markdown(['what', 'goal', 'found'], 3, lines, note)}"


def _seconds(value: float | None) -> str:
    if value is None:
        return ""
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


MAKERS = {"puzzles": puzzles, "engine": engine}
SECTION = Section("removal", "removal.md", list(MAKERS), partial(by_experiment, MAKERS), goals.scorecard)
