"""The pairs of testdata/clash, checked by each checker: as they are, 3,000 m off, and with boxes cut ever finer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import host

from .cases import CUTS, FAR_M, cases
from .checkers import Answer, Checker

Result = dict[str, Any]

OFFSETS_M = (0.0, FAR_M)
QUICK_CUTS = (1, 4)
SHARED = ("contained", "duplicate")
"""Verdicts that peers do not have: theirs is right if it says that the two overlap."""
WITHIN, WITHIN_M = 0.01, 1e-9
"""The allowed error of a depth or gap: relative, and in metres."""


def asked(checkers: Sequence[Checker], is_quick: bool) -> Result:
    """Every case: of each run of it where it was, how its boxes were cut, and each checker's answer."""
    rows = []
    for case in cases(host.ROOT / "testdata"):
        cuts = (QUICK_CUTS if is_quick else CUTS) if case.is_boxes else CUTS[:1]
        runs = []
        for offset in OFFSETS_M:
            for cut in cuts:
                mockup = case.mockup(offset, (cut, cut))
                answers = {checker.name: _row(checker.pair(mockup)) for checker in checkers}
                runs.append({"offset_m": offset, "cut": cut, "answers": answers})
        rows.append({"name": case.name, "verdict": case.verdict, "figure": case.figure, "runs": runs})
    return {"cases": rows}


def _row(answer: Answer) -> list[Any]:
    """Rounded for the record: seven digits are enough."""
    figure = None if answer.figure is None else float(f"{answer.figure:.7g}")
    return [answer.verdict, figure, *([] if answer.kind is None else [answer.kind])]


def answer_of(row: Sequence[Any]) -> Answer:
    """An answer of the record."""
    return Answer(*row)


def is_verdict_right(case: Result, checker: str, answer: Answer) -> bool:
    """Whether a checker classifies the two parts of a case correctly, as far as it has words for it."""
    is_shared = checker != "feeler" and case["verdict"] in SHARED and answer.verdict == "clash"
    return is_shared or answer.verdict == case["verdict"]


def is_right(case: Result, checker: str, answer: Answer) -> bool:
    """The verdict, and how deep or how far, where the case states it. A bound is right if it is as near."""
    if not is_verdict_right(case, checker, answer):
        return False
    wanted = case["figure"]
    if wanted is None:
        return True
    return answer.figure is not None and abs(answer.figure - wanted) <= WITHIN_M + WITHIN * wanted
