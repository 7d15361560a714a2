"""The tables of a run, as Markdown: the hard pairs, each checker beside the true result, and times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any

from pages import bold, markdown
from section import Result, Section, busy, by_experiment

from feeler.words import length

from . import goals, hard_cases
from .checkers import QUERIES, Answer

MOST_WRONG = 2
"""Wrong answers that a cell quotes."""
STAGES = {
    "index": "index; trees",
    "verdicts": "which meet",
    "clearance": "which are within 2 mm",
    "depths": "how deep",
    "volumes": "shared volumes",
}
WORDS = {"verdicts": "meet", "clearance": "within 2 mm", "depths": "clash"}

JUDGE_NOTE = (
    "The expected depths share no code with feeler: closed forms (boxes, balls), linear programs (convex bodies), "
    "plane polygons (pins), integer arithmetic (polycubes), branch and bound with volumes by manifold3d (any solids). "
    "Parts are rotated, up to 65 km off, subdivided and mirrored; some are hollow. Depths may exceed their bounds by "
    "four units in the last place of the largest coordinate. If a contained part touches from inside and coordinates "
    "are rounded, `CLASH` is as right as `CONTAINED`. Relative errors are of depths of a micrometre and more."
)
STABILITY_NOTE = "A depth may change by its error, and by 2 e more if each part moves by e."


def cases(found: Result) -> str:
    """Each pair, and what each checker makes of it."""
    checkers = _checkers(found)
    lines = [[case["name"], _right(case), *(_cell(case, name) for name in checkers)] for case in found["cases"]]
    for what, judge in (("verdicts", hard_cases.is_verdict_right), ("verdicts and figures", hard_cases.is_right)):
        told = [
            [judge(case, name, each) for case in found["cases"] for each in _answers(case, name)] for name in checkers
        ]
        lines.append([f"**right: {what}**", "", *(f"{sum(said)} of {len(said)}" for said in told)])
    heads = ["pair", "is", *(f"{name} {found['versions'][name]}" for name in checkers)]
    finest = max(12 * run["cut"] ** 2 for case in found["cases"] for run in case["runs"])
    notes = [
        f"Each pair is checked at the origin and {hard_cases.OFFSETS_M[1]:,.0f} m off, with boxes of 12 to {finest:,} "
        f"triangles. Bold: the number of right answers, and the wrong ones, most frequent first.",
        "A depth or gap is right within 1 %. For contained parts and duplicates, a clash is right for a peer, too.",
        *_left_out(found),
    ]
    return f"{SECTION.origin(found)}\n\n{markdown(heads, len(heads), lines, ' '.join(notes))}"


def _checkers(found: Result) -> list[str]:
    return list(found["cases"][0]["runs"][0]["answers"])


def _answers(case: Result, checker: str) -> list[Answer]:
    return [hard_cases.answer_of(run["answers"][checker]) for run in case["runs"]]


def _right(case: Result) -> str:
    """The right answer for a pair; without a figure for a contact."""
    has_figure = case["figure"] is not None and case["verdict"] != "contact"
    return f"{case['verdict']}, {length(case['figure'])}" if has_figure else str(case["verdict"])


def _cell(case: Result, checker: str) -> str:
    answers = _answers(case, checker)
    wrong = [each for each in answers if not hard_cases.is_right(case, checker, each)]
    if not wrong:
        return "right"
    said = [words for words, _ in Counter(_said(each) for each in wrong).most_common()]
    more = ", ..." if len(said) > MOST_WRONG else ""
    return f"**{len(answers) - len(wrong)} of {len(answers)}**: {'; '.join(said[:MOST_WRONG])}{more}"


def _said(answer: Answer) -> str:
    if answer.verdict in ("none", "contact"):
        return answer.verdict
    if answer.figure is None:
        return f"{answer.verdict}, no depth"
    sure = {"estimate": "about "}.get(answer.kind or "", "")
    return f"{answer.verdict}, {sure}{length(answer.figure)}"


def judge(found: Result) -> str:
    """Wrong answers by kind of pair, and the stability checks."""
    keys = ("pairs", "meet", "wrong_verdicts", "outside")
    rows = found["kinds"]
    total = {key: sum(row[key] for row in rows) for key in keys}
    total["largest_error"] = max((row["largest_error"] for row in rows), default=0.0)
    lines = []
    for row in [*rows, {"kind": "**all**", **total}]:
        wrong = [bold(f"{row[key]:,}", row[key] == 0) for key in ("wrong_verdicts", "outside")]
        error = row["largest_error"]
        lines.append([row["kind"], f"{row['pairs']:,}", f"{row['meet']:,}", *wrong, f"{error:.1g}" if error else ""])
    heads = [
        "pairs of",
        "pairs",
        "that meet",
        "wrong verdicts",
        "depths outside their bounds",
        "largest relative error",
    ]
    kinds = "\n\n".join([SECTION.origin(found), markdown(heads, 1, lines, JUDGE_NOTE)])
    lines = [
        [row["parts"], row["change"], f"{row['pairs']:,}", bold(f"{row['beyond']:,}", row["beyond"] == 0)]
        for row in found["stability"]
    ]
    heads = ["parts", "change", "pairs", "depths that change too much"]
    return f"{kinds}\n\n{markdown(heads, 2, lines, STABILITY_NOTE)}"


def times(found: Result) -> str:
    """The time of each stage, and the findings of the peers."""
    peers: dict[str, Result] = found["sizes"][0]["peers"]
    lines = []
    for row in found["sizes"]:
        wanted = goals.ONE_CORE_S.get(row["size"], {})
        for stage, what in STAGES.items():
            if stage in row["one_core_s"]:
                seconds, goal = row["one_core_s"][stage], wanted.get(stage)
                mine = bold(_seconds(seconds), goal is None or seconds <= goal)
                theirs = [_seconds(row["peers"].get(name, {}).get("one_core_s", {}).get(stage)) for name in peers]
                goal_s = "" if goal is None else f"{goal:g} s"
                lines.append([_mockup(row), what, goal_s, mine, _seconds(row["all_cores_s"][stage]), *theirs])
    versions = [f"{name} {found['versions'][name]}" for name in peers]
    heads = ["sample engine", "stage", "goal", "feeler, one core", f"all {found['machine']['cores']} cores", *versions]
    notes = [
        "Bold: misses its goal, which is for one core. Each stage of feeler uses the results of the previous one; the "
        "queries of a peer are independent.",
        f"Minimum of {found['repeats']} runs; volumes and the index of ifcclash: one run.",
        *([] if found["has_volumes"] else ["Volumes: manifold3d was not installed."]),
        *_left_out(found),
    ]
    made = [f"{SECTION.origin(found, *busy(found))}\n\n{markdown(heads, 2, lines, ' '.join(notes))}"]
    if peers:
        made.append(_pairs(found["sizes"][0], peers))
    return "\n\n".join(made)


def _pairs(row: Result, peers: Mapping[str, Result]) -> str:
    lines = []
    for query in QUERIES:
        theirs = [_found(peer["pairs"][query]) for peer in peers.values()]
        lines.append([f"{_mockup(row)}: {WORDS[query]}", f"{row['pairs'][query]:,}", *theirs])
    note = "Missed and made up (false): compared with feeler, whose pairs the tests check against all triangles."
    return markdown(["pairs of parts", "feeler", *peers], 1, lines, note)


def _found(pairs: Mapping[str, int]) -> str:
    wrong = [f"{pairs[key]:,} {what}" for key, what in (("missed", "missed"), ("made_up", "made up")) if pairs[key]]
    return f"{pairs['found']:,}" + (f" ({', '.join(wrong)})" if wrong else "")


def _mockup(row: Result) -> str:
    return f"{row['triangles']:,} triangles, {row['parts']:,} parts"


def _seconds(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.3g} s"


def _left_out(found: Mapping[str, Any]) -> list[str]:
    """Peers that are not in the table, and why."""
    return [f"{name}: {reason}." for name, reason in found["absent"].items()]


MAKERS = {"cases": cases, "judge": judge, "times": times}
SECTION = Section("clash", "clash.md", list(MAKERS), partial(by_experiment, MAKERS), goals.scorecard)
