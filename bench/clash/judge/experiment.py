"""All kinds of pairs, and what must not change a depth, as plain data."""

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
"""Wrong answers of each kind that the record quotes."""


def measured(is_quick: bool, seed: int = SEED) -> Result:
    """Each kind of pair with what is wrong of it, and each change with what it changes."""
    if find_spec("manifold3d") is None:
        raise SystemExit("the judge needs manifold3d: pip install 'feeler[volume]'")
    kinds = []
    for name, (_, number) in KINDS.items():
        some = max(1, round(number * QUICK_SHARE)) if is_quick else number
        kinds += summed(list(asked(groups(name, some, seed))))
        print(f"judge: {name}: {kinds[-1]['pairs']:,} pairs", file=sys.stderr)
    return {"seed": seed, "kinds": kinds, "stability": stability.measured(seed, is_quick)}


def summed(found: Sequence[Judged]) -> list[Result]:
    """A row for each kind, in the order in which they come."""
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
