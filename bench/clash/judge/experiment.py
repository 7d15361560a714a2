"""Runs all kinds of pairs and the stability checks. Returns plain data."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

from . import stability
from .asking import Judged, asked
from .kinds import KINDS, groups

Result = dict[str, Any]

SEED = 56
QUICK_SHARE = 1 / 40
MOST_EXAMPLES = 5
"""Most wrong answers that the record lists for each kind."""


def measured(is_quick: bool, seed: int = SEED) -> Result:
    """The number of wrong answers for each kind of pair, and the results of the stability checks."""
    if find_spec("manifold3d") is None:
        raise SystemExit("the judge needs manifold3d: pip install 'feeler[volume]'")
    kinds = []
    for name, (_, number) in KINDS.items():
        some = max(1, round(number * QUICK_SHARE)) if is_quick else number
        kinds += summed(list(asked(groups(name, some, seed))))
        print(f"judge: {name}: {kinds[-1]['pairs']:,} pairs", file=sys.stderr)
    return {"seed": seed, "kinds": kinds, "stability": stability.measured(seed, is_quick)}


def summed(found: Sequence[Judged]) -> list[Result]:
    """A row for each kind, in the order of the pairs."""
    rows = []
    for kind in dict.fromkeys(each.kind for each in found):
        own = [each for each in found if each.kind == kind]
        errors = [each.relative_error for each in own if each.relative_error is not None]
        rows.append(
            {
                "kind": kind,
                "pairs": len(own),
                "meet": sum(each.is_meeting for each in own),
                "depths": len(errors),
                "wrong_verdicts": sum(each.is_verdict_wrong for each in own),
                "outside": sum(each.is_outside for each in own),
                "largest_error": float(f"{max(errors, default=0.0):.3g}"),
                "examples": [each.says for each in own if each.says][:MOST_EXAMPLES],
            }
        )
    return rows
