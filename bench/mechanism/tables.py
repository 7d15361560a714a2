"""The tables of a run, as Markdown: the door, what steps miss, and bounds against random positions."""

from __future__ import annotations

from functools import partial

from pages import bold, markdown
from section import Result, Section, busy, by_experiment

from feeler.words import length

from . import goals

WORK = {
    "clearance": "all pairs within 5 mm, at 121 positions",
    "curve": "the least gap over all positions, with the curve of 121",
    "range": "free range",
    "clash": "all pairs that clash, with the first position of each",
    "first": "the first free range, which also finds the seats",
}


def door(found: Result) -> str:
    """Times of the door."""
    lines = []
    for row in found["sizes"]:
        what = f"{row['triangles']:,} triangles; door of {row['parts']} parts, {row['door_triangles']:,} triangles"
        for key, words in WORK.items():
            wanted = goals.DOOR_S.get(key) if row["triangles"] > goals.FULL else None
            seconds = row["seconds"][key]
            mine = bold(f"{seconds:.3g} s", wanted is None or seconds <= wanted)
            lines.append([what, f"feeler: {words}", "" if wanted is None else f"{wanted:g} s", mine, _answer(row, key)])
        for name, peer in row["peers"].items():
            words = f"{name} {found['versions'][name]}: least gap at {row['steps']} positions"
            lines.append([what, words, "", f"{peer['steps_s']:.3g} s", _gap(peer["gap"])])
    heads = ["sample engine", "question", "goal", "one core", "answer"]
    notes = [
        f"Bounds are {length(found['sizes'][0]['error'])} apart. Bold: misses its goal. Least of "
        f"{found['repeats']} runs; peers and the first range: one run.",
        *(f"{name}: {reason}." for name, reason in found["absent"].items()),
    ]
    return f"{SECTION.origin(found, *busy(found))}\n\n{markdown(heads, 2, lines, ' '.join(notes))}"


def _answer(row: Result, key: str) -> str:
    if key == "curve":
        return "it meets" if row["upper"] == 0.0 else f"{length(row['lower'])} to {length(row['upper'])}"
    if key in ("range", "first"):
        return f"{row['free'][0]:.6g} to {row['free'][1]:.6g} rad"
    return f"{row['clashes']} pairs" if key == "clash" else ""


def _gap(gap: float) -> str:
    return "collides" if gap == 0.0 else length(gap)


def steps(found: Result) -> str:
    """The gaps that each finds beside the true ones."""
    names = list(found["cases"][0]["gaps"])
    lines = []
    for row in found["cases"]:
        truth = row["truth"]
        theirs = [_wrong(row["gaps"][name], truth, found["error"]) for name in names]
        lines.append([row["case"], _gap(truth), _wrong(row["upper"], truth, found["error"]), *theirs])
    versions = [f"{name} {found['versions'].get(name, '')}".strip() for name in names]
    heads = ["hinge, 0 to 1.9 rad", "least gap", "feeler, all positions", *versions]
    note = (
        f"Steps: {found['steps']} positions. Bold: off by more than {length(found['error'])}. MuJoCo takes the "
        "convex hull of each mesh."
    )
    more = [f"{name}: {reason}." for name, reason in found["absent"].items()]
    return f"{SECTION.origin(found)}\n\n{markdown(heads, 1, lines, ' '.join([note, *more]))}"


def _wrong(gap: float, truth: float, error: float) -> str:
    return bold(_gap(gap), abs(gap - truth) <= 1.01 * error)


def bounds(found: Result) -> str:
    """Certified bounds against random positions."""
    lines = [
        [
            row["kind"],
            f"{row['mechanisms']:,}",
            f"{row['positions']:,}",
            bold(f"{row['above']:,}", row["above"] == 0),
            f"{row['free']:,}",
            f"{row['undecided']:,}",
            length(row["widest"]),
        ]
        for row in found["kinds"]
    ]
    heads = ["arms of three links", "arms", "positions", "bounds above", "free", "undecided", "bounds apart, at most"]
    note = "Bounds above: positions with a smaller gap than the certified bound. Free: arms whose bound is above 0."
    return f"{SECTION.origin(found)}\n\n{markdown(heads, 1, lines, note)}"


MAKERS = {"door": door, "steps": steps, "bounds": bounds}
SECTION = Section("mechanism", "mechanisms.md", list(MAKERS), partial(by_experiment, MAKERS), goals.scorecard)
