"""Checks of arguments, and the hints in their error messages."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

import numpy as np

from feeler.errors import OptionError
from feeler.progress import Progress

MOST_THREADS = 1024


def check_real(what: str, value: object, give: str = "a number") -> float:
    """A real number, infinite and NaN too. give: what errors ask for. Raises `OptionError` for other values."""
    if isinstance(value, (bool, str, bytes)):
        raise OptionError(f"{what} is {value!r}: give {give}")
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise OptionError(f"{what} is {value!r}: give {give}") from None
    except OverflowError:
        raise OptionError(f"{what} is beyond what a float64 can hold: give {give}") from None


def check_number(
    what: str,
    value: object,
    give: str,
    *,
    least: float = -math.inf,
    most: float = math.inf,
    above: float = -math.inf,
    is_endless: bool = False,
) -> float:
    """A real number from `least` to `most`, and larger than `above`; an infinite one only if it may be endless.

    give: what errors ask for, such as "metres, 0 or more". Raises `OptionError` for other values.
    """
    number = check_real(what, value, give)
    if not (least <= number <= most and number > above) or (math.isinf(number) and not is_endless):
        raise OptionError(f"{what} is {value!r}: give {give}")
    return number


def check_length(what: str, value: object, other: str = "") -> float:
    """A length in metres. other: what else could be given. Raises `OptionError` for other values."""
    return check_number(what, value, f"metres, 0 or more{other}", least=0.0)


def check_whole(what: str, value: object, least: int = 0, most: int | None = None, other: str = "") -> int:
    """A whole number from `least` to `most`. other: what else could be given. Raises `OptionError` for other values."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value or (most is not None and value > most):  # type: ignore[operator]
        span = f"{least} or more" if most is None else f"from {least} to {most}"
        raise OptionError(f"{what} is {value!r}: give a whole number {span}{other}")
    return int(value)  # type: ignore[call-overload, no-any-return]


def check_flag(what: str, value: object) -> bool:
    """True or false. Raises `OptionError` for other values."""
    if not isinstance(value, (bool, np.bool_, int)) or value not in (0, 1):
        raise OptionError(f"{what} is {value!r}: give True or False")
    return bool(value)


def check_word(what: str, value: object, known: Iterable[str]) -> str:
    """One of the known words. Raises `OptionError` for others."""
    words = list(known)
    if not isinstance(value, str) or value not in words:
        raise OptionError(f"{what} is {value!r}: {near(value, words)}")
    return str(value)


def check_threads(threads: object) -> int | None:
    """A number of threads; None for all. Raises `OptionError` for other values."""
    return None if threads is None else check_whole("threads", threads, 1, MOST_THREADS, ", or None for all")


def check_progress(progress: Progress | None) -> Progress | None:
    """A function that takes progress, or None. Raises `OptionError` for other values."""
    if progress is not None and not callable(progress):
        raise OptionError(f"progress is {progress!r}: give a function of (share done, stage), or None")
    return progress


def near(asked: object, known: Iterable[str], none: str = "there is none") -> str:
    """A hint with similar words, or with all known words; `none` if there are none."""
    words = list(known)
    alike = difflib.get_close_matches(asked, words, 3, 0.5) if isinstance(asked, str) else []
    if alike:
        return f"do you mean {' or '.join(alike)}?"
    return f"choose {', '.join(words)}" if words else none
