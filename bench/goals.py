"""The goals, and whether a record meets them. None of them affects the exit status."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from record import Row

TIMES_FASTER = {
    ("collide", "nominal"): 5.0,
    ("collide", "deep"): 5.0,
    ("collide", "near"): 3.0,
    ("is_colliding", "nominal"): 3.0,
    ("is_colliding", "near"): 3.0,
    ("distance", "near"): 1.0,
    ("cast", "near"): 1.0,
}
GEOMETRIC_MEAN = 8.0  # of collide, nominal and deep
FINE_COST = 5.0  # a tool ten times finer, at the same place
WORST_US = 1000.0  # of a nominal pose; p99 of contacts
SMALL_TOOL = 5000  # triangles, for which those hold
BUILD_S = {1_600_000: 0.6, 6_400_000: 2.5}  # one core
BYTES_PER_TRIANGLE = 64.0
PEAK_OVER_RESULT = 2.0
BATCH_ON_TWO = 1.9
CALL_US = 2.0

MEASURES = {"median": "times_faster", "p95": "times_faster_p95"}


@dataclass(frozen=True)
class Goal:
    """A goal and its result; `met` is None where the machine was too busy to tell."""

    goal: str
    wanted: str
    found: str
    met: bool | None


@dataclass(frozen=True)
class Best:
    """feeler against the best peer of a cell, another maybe for the median than for the p95."""

    wanted: float | None
    peer: str  # by median
    median: float  # times faster
    p95: float

    @property
    def met(self) -> bool | None:
        """None where nothing is wanted."""
        return None if self.wanted is None else min(self.median, self.p95) >= self.wanted


def against_best(peers: Sequence[Row]) -> Best | None:
    """Of the rows of a cell's peers; None without peers."""
    if not peers:
        return None
    median, peer = min((row["times_faster"], row["engine"]) for row in peers)
    p95 = min(row["times_faster_p95"] for row in peers)
    return Best(TIMES_FASTER.get((peers[0]["query"], peers[0]["kind"])), peer, median, p95)


def geometric_mean(values: Iterable[float]) -> float:
    """Of positive numbers; not a number for none."""
    logs = [math.log(value) for value in values]
    return math.exp(sum(logs) / len(logs)) if logs else math.nan


def cells(rows: Iterable[Row]) -> list[tuple[Row, list[Row]]]:
    """feeler's row of each cell that has poses, and those of its peers."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        if row["what"] == "cell" and row["poses"]:
            groups.setdefault((row["size"], row["tool"], row["kind"], row["query"]), []).append(row)
    found = []
    for own in groups.values():
        feeler = next(row for row in own if row["engine"] == "feeler")
        found.append((feeler, [row for row in own if row is not feeler]))
    return found


def scorecard(rows: Sequence[Row]) -> list[Goal]:
    """Every goal of which the rows say something."""
    own = cells(rows)
    return [*_speed(own), *_contacts(own), *_growth(own), *_alone(rows), *_builds(rows)]


def _speed(own: Sequence[tuple[Row, list[Row]]]) -> Iterable[Goal]:
    by: dict[tuple[str, str], list[Best]] = {}
    for feeler, peers in own:
        if best := against_best(peers):
            by.setdefault((feeler["query"], feeler["kind"]), []).append(best)
    for (query, kind), found in by.items():
        if (wanted := found[0].wanted) is not None:
            met = [bool(one.met) for one in found]
            least = min(min(one.median, one.p95) for one in found)
            yield Goal(
                f"{query}, {kind}: times faster than the best peer, median and p95",
                f"{wanted:g} in every cell",
                f"{sum(met)} of {len(met)} cells, least {least:.2f}",
                all(met),
            )
    hard = [*by.get(("collide", "nominal"), []), *by.get(("collide", "deep"), [])]
    for measure in MEASURES if hard else ():
        mean = geometric_mean(getattr(one, measure) for one in hard)
        what = f"collide, nominal and deep: {measure}, geometric mean of {len(hard)} cells"
        yield Goal(what, f"{GEOMETRIC_MEAN:g}", f"{mean:.2f}", mean >= GEOMETRIC_MEAN)


def _contacts(own: Sequence[tuple[Row, list[Row]]]) -> Iterable[Goal]:
    for row, _ in own:
        if row["query"] == "contacts" and row["tool_triangles"] <= SMALL_TOOL:
            slow = row["p99_us"]
            what = f"contacts, {row['kind']}, {row['tool']}, {row['triangles']:,} triangles: p99, µs"
            yield Goal(what, f"under {WORST_US:,.0f}", f"{slow:,.0f}", slow < WORST_US)


def _growth(own: Sequence[tuple[Row, list[Row]]]) -> Iterable[Goal]:
    """From the smallest to the largest mock-up, per tool: how the nominal median grows beside the pairs found."""
    nominal = [row for row, _ in own if (row["query"], row["kind"]) == ("collide", "nominal")]
    for tool in dict.fromkeys(row["tool"] for row in nominal):
        sizes = sorted((row for row in nominal if row["tool"] == tool), key=lambda row: int(row["triangles"]))
        if len(sizes) > 1:
            small, large = sizes[0], sizes[-1]
            pairs = large["pairs"] / max(1.0, small["pairs"])
            grown = large["median_us"] / small["median_us"]
            what = f"growth of the nominal median, {tool}, {small['triangles']:,} to {large['triangles']:,} triangles"
            yield Goal(what, f"less than the pairs', {pairs:.2f}", f"{grown:.2f}", grown < pairs)


def _alone(rows: Sequence[Row]) -> Iterable[Goal]:
    for row in rows:
        about = f"{row['tool']}, {row['triangles']:,} triangles" if row["triangles"] else ""
        if row["what"] == "fine":
            slower = row["times_slower"]
            what = f"tool ten times finer, same poses, {about}: times slower"
            yield Goal(what, f"less than {FINE_COST:g}", f"{slower:.2f}", slower < FINE_COST)
        elif row["what"] == "worst":
            slowest = row["worst_us"]
            what = f"worst of {row['poses']:,} nominal poses, {about}, µs"
            yield Goal(what, f"under {WORST_US:,.0f}", f"{slowest:,.0f}", slowest < WORST_US)
        elif row["what"] == "batch" and row["batch_2_per_s"]:
            yield _batch(row)
        elif row["over_core_us"] is not None:
            cost = row["over_core_us"]
            yield Goal("a Python call over the core's time, µs", f"{CALL_US:g}", f"{cost:.2f}", cost <= CALL_US)


def _batch(row: Row) -> Goal:
    one, two, apart = (row[f"{name}_per_s"] for name in ("batch_1", "batch_2", "apart_2"))
    gain = two / one
    beside = f"; two apart {apart / one:.2f}" if apart else ""
    found = f"{gain:.2f} (had {row['cores_had']:.2f} cores{beside})"
    # Without two free cores, nothing is known.
    met = True if gain >= BATCH_ON_TWO else (None if row["cores_had"] < BATCH_ON_TWO else False)
    return Goal(f"collide_batch, {row['tool']}: rate on two threads over one", f"{BATCH_ON_TWO:g}", found, met)


def _builds(rows: Sequence[Row]) -> Iterable[Goal]:
    for row in rows:
        if row["what"] != "build" or row["engine"] != "feeler":
            continue
        what = f"{row['triangles']:,} triangles"
        if row["size"] in BUILD_S:
            wanted, seconds = BUILD_S[row["size"]], row["one_core_s"]
            yield Goal(f"build of {what}, one core, s", f"at most {wanted:g}", f"{seconds:.2f}", seconds <= wanted)
        each = row["bytes"] / row["triangles"]
        met = each <= BYTES_PER_TRIANGLE
        yield Goal(f"bytes a triangle, {what}", f"at most {BYTES_PER_TRIANGLE:g}", f"{each:.1f}", met)
        # Where the index is small beside the rest of the process, its peak cannot be measured.
        if row["peak_bytes"] and row["bytes"] > 50e6:
            # The engine counts the mock-up's arrays, which were there before: they are part of the peak as well.
            before = row["bytes"] - row["growth_bytes"]
            peak = (before + row["peak_bytes"]) / row["bytes"]
            what = f"peak while building over the result, {what}"
            yield Goal(what, f"at most {PEAK_OVER_RESULT:g}", f"{peak:.2f}", peak <= PEAK_OVER_RESULT)
