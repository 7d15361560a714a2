"""The tables of a run, as Markdown: one for each experiment, all faces side by side, and the scorecard."""

from __future__ import annotations

from collections.abc import Callable

from pages import markdown
from section import Goal, Result, Section, last_line, scorecard_table

from . import goals, plots

Faces = dict[str, Result]
"""Of each face, its experiments by name."""


def tables(result: Result) -> dict[str, str]:
    """All tables that a run has something for, by name."""
    faces: Faces = result["faces"]
    heads = ["experiment", "goal", "wanted", "found"]
    made = {"goals": scorecard_table(heads, 4, scorecard(result))} if "feeler" in faces else {}
    for name, make in MAKERS.items():
        there = {face: found[name] for face, found in faces.items() if name in found}
        whole = {face: found for face, found in there.items() if "failed" not in found}
        if whole:
            made[name] = make(whole)
        for face, found in there.items():
            if "failed" in found:
                made[name] = f"{made.get(name, '')}\n\n{face}: stopped with an error, {last_line(found)}".strip()
    made["origin"] = SECTION.origin(result)
    return made


def scorecard(result: Result) -> list[Goal]:
    """The goals of feeler; baselines have none."""
    return goals.scorecard(result["faces"].get("feeler", {}))


def _passing(faces: Faces) -> str:
    lines = []
    for row in next(iter(faces.values()))["rows"]:
        line = [row["kind"], f"{row['speed_m_per_s']:g}"]
        for found in faces.values():
            own = [r for r in found["rows"] if (r["kind"], r["speed_m_per_s"]) == (row["kind"], row["speed_m_per_s"])]
            runs, steps = sum(r["runs"] for r in own), sum(r["steps"] for r in own)
            passed, hit = sum(r["passed"] for r in own), sum(r["colliding_steps"] for r in own)
            line += [f"{passed:,} of {runs:,}", f"{hit:,} of {steps:,}"]
        lines.append(line)
    heads = ["thin thing", "m/s", *(h for face in faces for h in (f"{face}: passed", "steps in collision"))]
    return markdown(heads, 1, lines, "For the baselines, the virtual tool counts as the proxy.")


def _forces(faces: Faces) -> str:
    lines = []
    rows = {face: {(r["contact"], r["triangles"], r["frame"]): r for r in f["rows"]} for face, f in faces.items()}
    for contact, triangles, frame in next(iter(rows.values())):
        line = [contact, f"{triangles:,}", frame]
        for own in rows.values():
            row = own.get((contact, triangles, frame))
            line.append("–" if row is None else f"{row['magnitude_n']:.3f} ({row['unrest_n']:.3f})")
        lines.append(line)
    for contact in next(iter(faces.values()))["spread"]:
        spread = [f"{100 * f['spread'][contact]:.2f} %" for f in faces.values()]
        lines.append([f"**{contact}, spread**", "", "", *spread])
    note = "Newtons at the end of a press, 1 mm deep (in brackets: their change over 50 ms of holding)."
    return markdown(["contact", "triangles", "frame", *faces], 1, lines, note)


def _sliding(faces: Faces) -> str:
    lines = []
    for face, found in faces.items():
        for row in found["rows"]:
            lines.append(
                [
                    f"{row['surface']}, {row['triangles']:,} triangles",
                    face,
                    f"{row['force_n']:.3f}",
                    f"{row['least_n']:.3f} to {row['largest_n']:.3f}",
                    f"{100 * row['size_jump']:.2f} %",
                    f"{100 * row['jump']:.2f} %",
                    "–" if row.get("unshaded_jump") is None else f"{100 * row['unshaded_jump']:.2f} %",
                    f"{row['direction_rad']:.3f} ({row['allowed_rad']:.3f})",
                ]
            )
    heads = [
        "surface",
        "face",
        "mean N",
        "range",
        "jump of its size a tick",
        "as a vector",
        "without shading",
        "off the normal, rad (facets)",
    ]
    return markdown(heads, 2, sorted(lines))


def _closed(faces: Faces) -> str:
    lines = []
    for at, row in enumerate(next(iter(faces.values()))["rows"]):
        line = [row["motion"]]
        for found in faces.values():
            own = found["rows"][at]
            line += [f"{1e3 * own['went_in_j']:.2f}", f"{100 * own['gain']:+.1f} %"]
        lines.append(line)
    heads = ["closed motion", *(h for face in faces for h in (f"{face}: in, mJ", "gain"))]
    return markdown(heads, 1, lines, "Gain: energy returned beyond the energy put in, relative to the latter.")


def _step_response(faces: Faces) -> str:
    lines = []
    for face, found in faces.items():
        for row in found["rows"]:
            numbers = [f"{row['force_n']:.2f}", f"{1e6 * row['swing_before_m']:.2f}", f"{1e6 * row['swing_m']:.2f}"]
            lines.append([face, row["coupling"], str(row["delay_ticks"]), *numbers])
    heads = ["face", "coupling", "late, ms", "force at rest, N", "swing 0.4 s before the end, um", "at the end, um"]
    return markdown(heads, 2, lines)


def _release(faces: Faces) -> str:
    lines = []
    for face, found in faces.items():
        for row in found["rows"]:
            lines.append(
                [
                    face,
                    f"{1e3 * row['depth_m']:g}",
                    str(row["delay_ticks"]),
                    f"{row['held_n']:.2f}",
                    f"{row['largest_n']:.2f}",
                    f"{1e3 * row['stored_j']:.2f}",
                    f"{1e3 * row['kinetic_j']:.2f}",
                    f"{row['speed_m_per_s']:.2f}",
                ]
            )
    heads = [
        "face",
        "depth, mm",
        "late, ms",
        "held, N",
        "after, at most, N",
        "went in, mJ",
        "comes out with, mJ",
        "m/s",
    ]
    return markdown(heads, 1, lines)


def _pegs(faces: Faces) -> str:
    lines = []
    for face, found in faces.items():
        rows = found["rows"]
        for fit, shape in dict.fromkeys((row["fit"], row["shape"]) for row in rows):
            own = [row for row in rows if (row["fit"], row["shape"]) == (fit, shape)]
            times = sorted(row["seconds"] for row in own if row["seconds"] is not None)
            lines.append(
                [
                    face,
                    f"{fit}, {shape}",
                    f"{1e6 * own[0]['clearance_m']:.0f}",
                    f"{sum(row['is_in'] for row in own)} of {len(own)}",
                    f"{times[len(times) // 2]:.2f}" if times else "–",
                    f"{1e3 * min(row['reached_m'] for row in own):.1f}",
                    f"{sorted(row['force_median_n'] for row in own)[len(own) // 2]:.2f}",
                    f"{max(row['force_max_n'] for row in own):.2f}",
                    f"{sum(row['colliding_steps'] for row in own):,}",
                ]
            )
    heads = ["face", "peg", "clearance, um", "in", "median s", "least depth, mm", "median N", "largest N"]
    return markdown([*heads, "steps in collision"], 2, lines)


def _ways(faces: Faces) -> str:
    lines = []
    for face, found in faces.items():
        for row in found["rows"]:
            left = f" (without {', '.join(p.split('/')[-1] for p in row['left_out'])})" if row["left_out"] else ""
            lines.append(
                [
                    face,
                    f"{row['way']}, {row['direction']}{left}",
                    f"{1e3 * row['clearance_m']:.3f}",
                    f"{1e3 * row['left_behind_m']:.2f}",
                    f"{row['force_max_n']:.2f}",
                    f"{row['colliding_steps']:,} of {row['steps']:,}",
                ]
            )
    heads = ["face", "way", "clearance, mm", "off at the end, mm", "largest N", "steps in collision"]
    return markdown(heads, 2, lines)


def _engine(faces: Faces) -> str:
    lines = []
    for found in faces.values():
        for row in found["rows"]:
            line = [row["tool"], f"{row['triangles']:,}", f"{row['planes_mean']:.1f}"]
            for name in ("step_us", "near_us", "contacts_us"):
                line += [f"{row[name][share]:,.0f}" if row[name] else "–" for share in ("median", "p99", "worst")]
            servo = row["servo_us"]
            line += [f"{servo['median']:.1f}", f"{servo['p99.9']:.1f}"] if servo else ["–", "–"]
            lines.append(line)
    heads = ["tool", "triangles", "planes", "step, median", "p99", "worst", "near, median", "p99", "worst"]
    heads += ["contacts alone, median", "p99", "worst", "between, median", "p99.9"]
    note = (
        "Microseconds, from Python, one core, along a path of a hand in and out. Near: with planes within 2 mm. "
        "Contacts: the one query at the proxy's poses. Between: a step "
        "between two searches, wall time with Python's own; the servo tick "
        "alone, in thread time: `cargo run --release -p feeler-devices --example servo_time`."
    )
    return markdown(heads, 1, lines, note)


def _fits(faces: Faces) -> str:
    lines = []
    for found in faces.values():
        for row in found["rows"]:
            triangles = f"{row['triangles']:,} + {row['tool_triangles']:,}"
            times = [f"{1e-3 * row['step_us'][share]:.2f}" for share in ("median", "p99", "worst")]
            lines.append([f"{row['what']}: a step", triangles, *times, f"{row['colliding_steps']} of {row['steps']:,}"])
        for row in found["casts"]:
            times = [f"{1e-3 * row['cast_us'][share]:.2f}" for share in ("median", "p99", "worst")]
            lines.append([f"cast along a bore, {row['way']}, touching {row['touching']}", "", *times, ""])
    heads = ["fit", "triangles", "median", "p99", "worst", "steps in collision"]
    return markdown(heads, 1, lines, "Milliseconds, from Python, one core.")


MAKERS: dict[str, Callable[[Faces], str]] = {
    "passing": _passing,
    "forces": _forces,
    "sliding": _sliding,
    "closed": _closed,
    "step_response": _step_response,
    "release": _release,
    "pegs": _pegs,
    "ways": _ways,
    "engine": _engine,
    "fits": _fits,
}
SECTION = Section(
    *("feel", "haptics-figures.md", list(MAKERS), tables, scorecard, "faces"),
    plots=plots.plots,
    pictures="haptics",
)
