"""Checks of arguments, and the hints in their error messages."""

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


def near(asked: object, known: Iterable[str], none: str = "there is none") -> str:
    """A hint with similar words, or with all known words; `none` if there are none."""
    words = list(known)
    alike = difflib.get_close_matches(asked, words, 3, 0.5) if isinstance(asked, str) else []
    if alike:
        return f"do you mean {' or '.join(alike)}?"
    return f"choose {', '.join(words)}" if words else none
