"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Iterator

import section
from section import Goal, Result

MOST_SPREAD = 0.01  # of the force of one contact, over tessellations and frames
MOST_JUMP = 0.02  # of the force vector, as a share of the force, a tick
MOST_GAIN = 0.01  # of what went in: what may come out above it
MOST_SWING_M = 2e-5  # of a device at rest; a hand feels a buzz from about a micrometre at 250 Hz
STILL_SINKING = 0.85  # a swing against that 0.4 s before: near its bound a device comes to rest slowly
MOST_RELEASED = 1.05  # a force that holds for a tick gives some; of a hand that is late more, and no session knows it
MOST_KICK = 0.01  # above the force before the release
LEAST_MEDIAN_HZ = 1000.0
LEAST_P99_HZ = 250.0
PEG_MS = (1.0, 4.0)  # a step, median and p99
BOLT_MS = (5.0, 20.0)
BORE_MS = 5.0


def _passing(result: Result) -> Iterator[Goal]:
    rows = result["rows"]
    runs, steps = sum(r["runs"] for r in rows), sum(r["steps"] for r in rows)
    passed, colliding = sum(r["passed"] for r in rows), sum(r["colliding_steps"] for r in rows)
    yield Goal("passing", "runs that passed a thin thing", "0", f"{passed:,} of {runs:,}", passed == 0)
    yield Goal("passing", "steps with the proxy in collision", "0", f"{colliding:,} of {steps:,}", colliding == 0)


def _forces(result: Result) -> Iterator[Goal]:
    for name, spread in result["spread"].items():
        met = spread <= MOST_SPREAD
        yield Goal("forces", f"{name}: same force at every tessellation", "1 %", f"{100 * spread:.3f} %", met)


def _share(value: float) -> str:
    return f"{100 * value:.2f} %"


def _sliding(result: Result) -> Iterator[Goal]:
    for row in result["rows"]:
        where = f"{row['surface']}, {row['triangles']:,} triangles"
        jump, off = row["jump"], row["direction_rad"]
        most = row["allowed_rad"]
        yield Goal("sliding", f"{where}: jump of the vector a tick", "2 %", _share(jump), jump <= MOST_JUMP)
        yield Goal("sliding", f"{where}: direction", f"{most:.3f} rad", f"{off:.3f} rad", off <= most)


def _closed(result: Result) -> Iterator[Goal]:
    worst = max(result["rows"], key=lambda row: float(row["gain"]))
    found = f"{100 * worst['gain']:+.1f} % ({worst['motion']})"
    yield Goal("closed", "energy from a closed motion", "at most 1 %", found, worst["gain"] <= MOST_GAIN)


def _step_response(result: Result) -> Iterator[Goal]:
    for row in result["rows"]:
        swing, before = row["swing_m"], row["swing_before_m"]
        met = swing <= max(MOST_SWING_M, STILL_SINKING * before)
        what = f"no limit cycle, {row['delay_ticks']} ms late, {row['coupling']}"
        found = f"{1e6 * swing:.2f} um ({1e6 * before:.2f} before)"
        yield Goal("step_response", what, "20 um, or sinking", found, met)


def _release(result: Result) -> Iterator[Goal]:
    rows = result["rows"]
    kick = max(row["largest_n"] / max(row["held_n"], 1e-9) - 1.0 for row in rows)
    at_once = [row for row in rows if row["delay_ticks"] == 0]
    energy = max(row["kinetic_j"] / max(row["stored_j"], 1e-12) for row in at_once)
    out = sum(row["is_out"] for row in rows)
    yield Goal(
        "release", "force after letting go, above the force before", "1 %", f"{100 * kick:+.1f} %", kick <= MOST_KICK
    )
    above = [row for row in rows if row["bound_n"] is not None and row["largest_n"] > row["bound_n"] * (1.0 + 1e-9)]
    yield Goal("release", "forces above the bound", "0", f"{len(above)} of {len(rows)}", not above)
    said, met = f"{100 * energy:.0f} %", energy <= MOST_RELEASED
    yield Goal("release", "energy it comes out with, of what went in, not late", "at most 105 %", said, met)
    yield Goal("release", "comes out", f"{len(rows)}", f"{out}", out == len(rows))


def _pegs(result: Result) -> Iterator[Goal]:
    rows = result["rows"]
    for fit, shape in dict.fromkeys((row["fit"], row["shape"]) for row in rows):
        own = [row for row in rows if (row["fit"], row["shape"]) == (fit, shape)]
        there, hit = sum(row["is_in"] for row in own), sum(row["colliding_steps"] for row in own)
        found = f"{there} of {len(own)}"
        yield Goal("pegs", f"{fit}, {shape}: in to the bottom", f"{len(own)}", found, there == len(own))
        yield Goal("pegs", f"{fit}, {shape}: steps in collision", "0", f"{hit}", hit == 0)


def _ways(result: Result) -> Iterator[Goal]:
    for row in result["rows"]:
        found = f"{1e3 * row['left_behind_m']:.2f} mm off, {row['colliding_steps']} steps in collision"
        met = row["is_there"] and row["is_free"] and not row["colliding_steps"]
        yield Goal("ways", f"{row['way']}, {row['direction']}", "there", found, met)


def _engine(result: Result) -> Iterator[Goal]:
    for row in result["rows"]:
        where = f"{row['triangles']:,} triangles, {row['tool']}"
        median, p99 = row["median_hz"], row["p99_hz"]
        yield Goal(
            "engine", f"{where}: a step, median", "1,000 Hz", f"{median:,.0f} Hz", median >= LEAST_MEDIAN_HZ, True
        )
        yield Goal("engine", f"{where}: p99", "250 Hz", f"{p99:,.0f} Hz", p99 >= LEAST_P99_HZ, True)
        hit = row["colliding_steps"]
        yield Goal("engine", f"{where}: steps in collision", "0", f"{hit}", hit == 0)


def _fits(result: Result) -> Iterator[Goal]:
    for row in result["rows"]:
        goal = PEG_MS if row["what"].startswith("peg") else BOLT_MS
        for share, wanted in zip(("median", "p99"), goal, strict=True):
            found = 1e-3 * row["step_us"][share]
            said = f"{found:.2f} ms"
            yield Goal("fits", f"{row['what']}: a step, {share}", f"{wanted:g} ms", said, found <= wanted, True)
        hit = row["colliding_steps"]
        yield Goal("fits", f"{row['what']}: steps in collision", "0", f"{hit}", hit == 0)
    for row in result["casts"]:
        found = 1e-3 * row["cast_us"]["median"]
        what = f"a cast along a bore, {row['way']}, touching {row['touching']}"
        yield Goal("fits", what, f"{BORE_MS:g} ms", f"{found:.2f} ms", found <= BORE_MS, True)


JUDGES = {
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


def scorecard(found: dict[str, Result]) -> list[Goal]:
    """The goals of the experiments that ran, in one order: a record may have been made in several runs."""
    return section.scorecard(JUDGES, {name: found[name] for name in JUDGES if name in found})
