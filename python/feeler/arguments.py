"""Arguments of calls, checked: what is refused, and the hint that goes with it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

import numpy as np

from feeler.errors import OptionError


def check_length(what: str, value: object, other: str = "") -> float:
    """A length in metres. Raises `OptionError` for other values."""
    good = isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, bool)
    if not good or not 0 <= value < math.inf:  # type: ignore[operator]
        raise OptionError(f"{what} is {value!r}: give metres, 0 or more{other}")
    return float(value)  # type: ignore[arg-type]


def near(asked: object, known: Iterable[str]) -> str:
    """A hint with similar words, or with all known words."""
    words = list(known)
    alike = difflib.get_close_matches(str(asked), words, 3, 0.5)
    return f"do you mean {' or '.join(alike)}?" if alike else f"choose {', '.join(words)}"
