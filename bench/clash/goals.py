"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import section
from section import Goal, Result

from . import hard_cases

ONE_CORE_S = {
    100_000: {"verdicts": 0.07},
    1_600_000: {"verdicts": 1.0, "clearance": 4.0, "depths": 5.0, "volumes": 10.0},
}
"""By size of the sample engine and stage: seconds on one core, after the index, side by side."""

JUDGED_PAIRS = 20_000
"""The least number of random colliding pairs that a full run judges."""


def _verdicts(found: Result) -> Iterator[Goal]:
    told = [
        hard_cases.is_verdict_right(case, "feeler", hard_cases.answer_of(run["answers"]["feeler"]))
        for case in found["cases"]
        for run in case["runs"]
    ]
    yield Goal("hard pairs", "verdicts", f"all {len(told)}", f"{sum(told)}", all(told))


def _judged(found: Result) -> Iterator[Goal]:
    pairs, meet = (sum(row[key] for row in found["kinds"]) for key in ("pairs", "meet"))
    if not found["is_quick"]:
        yield Goal("judge", "pairs that meet", f"{JUDGED_PAIRS:,}", f"{meet:,}", meet >= JUDGED_PAIRS)
    for goal, key in (("wrong verdicts", "wrong_verdicts"), ("depths outside their bounds", "outside")):
        wrong = sum(row[key] for row in found["kinds"])
        yield Goal("judge", f"{goal} of {pairs:,} pairs", "0", f"{wrong:,}", wrong == 0)
    beyond = sum(row["beyond"] for row in found["stability"])
    about = "depths that change by more than their errors and the motion"
    yield Goal("judge", about, "0", f"{beyond:,}", beyond == 0)


def _times(found: Result) -> Iterator[Goal]:
    for row in found["sizes"]:
        for stage, wanted in ONE_CORE_S.get(row["size"], {}).items():
            seconds = row["one_core_s"].get(stage)
            said = "not measured" if seconds is None else f"{seconds:.3g} s"
            is_met = seconds is not None and seconds <= wanted
            yield Goal(f"engine, {row['triangles']:,} triangles, one core", stage, f"{wanted:g} s", said, is_met, True)


JUDGES = {"cases": _verdicts, "judge": _judged, "times": _times}
scorecard = partial(section.scorecard, JUDGES)
