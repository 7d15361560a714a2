"""Checks of arguments, and the hints in their error messages."""

from __future__ import annotations

import difflib
import inspect
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from feeler.errors import FeelerError, OptionError
from feeler.progress import Progress

MOST_THREADS = 1024
UNREADABLE = (TypeError, ValueError, OverflowError, RuntimeError)
"""Errors of `numpy.asarray` for values that are no arrays, and of other libraries for tensors that refuse to be one."""
_MOST_SHOWN = 80
_MOST_NAMED = 60

T = TypeVar("T")
Word = TypeVar("Word", bound=str)
RowsLike: TypeAlias = slice | npt.NDArray[Any] | Sequence[bool] | Sequence[int]
"""Several rows of a table: a slice, booleans, one each, or their numbers."""


def shown(value: object) -> str:
    """A value as error messages quote it: its `repr`, cut short."""
    try:
        text = repr(value)
    except Exception:  # of any class, and of numbers with more digits than Python prints
        text = f"a {type(value).__name__}"
    return text if len(text) <= _MOST_SHOWN else text[: _MOST_SHOWN - 3] + "..."


def check_real(what: str, value: object, give: str = "a number") -> float:
    """A real number, infinite and NaN too. give: what errors ask for. Raises `OptionError` for other values."""
    is_other = isinstance(value, (bool, str, bytes))
    if is_other or (isinstance(value, (np.ndarray, np.generic)) and (value.ndim or value.dtype.kind not in "fiuO")):
        raise OptionError(f"{what} is {shown(value)}: give {give}")
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise OptionError(f"{what} is {shown(value)}: give {give}") from None
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
        raise OptionError(f"{what} is {shown(value)}: give {give}")
    return number


def check_fraction(what: str, value: object) -> float:
    """A share of a motion. Raises `OptionError` for other values."""
    return check_number(what, value, "a number, 0 to 1", least=0.0, most=1.0)


def check_length(what: str, value: object, other: str = "") -> float:
    """A length in metres. other: what else could be given. Raises `OptionError` for other values."""
    return check_number(what, value, f"metres, 0 or more{other}", least=0.0)


def check_whole(what: str, value: object, least: int = 0, most: int | None = None, other: str = "") -> int:
    """A whole number from `least` to `most`. other: what else could be given. Raises `OptionError` for other values."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value or (most is not None and value > most):  # type: ignore[operator]
        span = f"{least} or more" if most is None else f"from {least} to {most}"
        raise OptionError(f"{what} is {shown(value)}: give a whole number {span}{other}")
    return int(value)  # type: ignore[call-overload, no-any-return]


def check_flag(what: str, value: object) -> bool:
    """True or false. Raises `OptionError` for other values."""
    if not isinstance(value, (bool, np.bool_)) and not (isinstance(value, int) and value in (0, 1)):
        raise OptionError(f"{what} is {shown(value)}: give True or False")
    return bool(value)


def check_word(what: str, value: object, known: Iterable[Word]) -> Word:
    """One of the known words. Raises `OptionError` for others."""
    words = list(known)
    if not isinstance(value, str) or value not in words:
        every = f"choose {', '.join(words)}"
        hint = near(value, words)
        raise OptionError(f"{what} is {shown(value)}: {hint if hint == every else f'{hint} {every}'}")
    return words[words.index(value)]


def check_text(what: str, value: object, give: str = "text") -> str:
    """Text that can be written to a file. Raises `OptionError` for other values."""
    if not isinstance(value, str) or not _is_writable(value):
        raise OptionError(f"{what} is {shown(value)}: give {give}")
    return str(value)


def check_path(
    what: str, value: object, error: type[FeelerError] = OptionError, give: str = "the path of a file"
) -> Path:
    """A path. give: what errors ask for. Raises `error` for other values."""
    if isinstance(value, (str, os.PathLike)):
        try:
            text = os.fspath(value)
        except TypeError:
            text = None  # a path that gives something else than text
        if isinstance(text, str) and text and "\0" not in text and _is_writable(text, os.fsencode):
            return Path(text)
    raise error(f"{what} is {shown(value)}: give {give}")


def check_kind(what: str, value: object, kind: type[T], give: str = "") -> T:
    """An object of a class. give: what errors ask for. Raises `OptionError` for others."""
    if not isinstance(value, kind):
        raise OptionError(f"{what} is {shown(value)}: give {give or f'a feeler.{kind.__name__}'}")
    return value


def check_callable(what: str, value: Callable[..., object], give: str) -> Callable[..., object]:
    """A function. give: what errors ask for. Raises `OptionError` for other values."""
    if not callable(value):
        raise OptionError(f"{what} is {shown(value)}: give {give}")
    return value


def check_list(what: str, value: object, give: str, error: type[FeelerError] = OptionError) -> list[Any]:
    """The entries of anything that has some, other than text and dicts. Raises `error` for other values."""
    if isinstance(value, Mapping):
        raise error(f"{what} is a dict: give {give}, such as list({what}.values())")
    is_list = isinstance(value, Iterable) and not isinstance(value, (str, bytes)) and getattr(value, "ndim", 1) > 0
    if not is_list:
        raise error(f"{what} is {shown(value)}: give {give}")
    return list(value)  # type: ignore[call-overload, no-any-return]


def unmasked(what: str, value: object, error: type[FeelerError] = OptionError) -> object:
    """Returns the value. Raises the error for an array with masked entries, whose hidden values NumPy would use."""
    if isinstance(value, np.ndarray) and np.any(getattr(value, "mask", False)):
        raise error(f"{what} has masked entries: leave them out, or fill them with numpy.ma.filled")
    return value


def check_array(what: str, value: object, shape: tuple[int | None, ...], *, is_finite: bool = True) -> npt.NDArray[Any]:
    """Real numbers of a shape, in which None is any length. Raises `OptionError` for other values."""
    wanted = str(tuple(-1 if size is None else size for size in shape)).replace("-1", "n")
    unmasked(what, value)
    try:
        array = np.asarray(value)
        given = array.astype(np.float64, copy=False) if array.dtype.kind in "fiu" else None
    except UNREADABLE:
        given = None
    if given is None:
        raise OptionError(f"{what} is {shown(value)}: give real numbers, {wanted}")
    sizes = given.shape
    if len(sizes) != len(shape) or any(size not in (None, own) for size, own in zip(shape, sizes, strict=True)):
        raise OptionError(f"{what} has shape {sizes}: give numbers, {wanted}")
    if is_finite and not np.isfinite(given).all():
        raise OptionError(f"{what} has a number that is not finite: give finite numbers, {wanted}")
    return given


def numbers_of(value: object) -> npt.NDArray[np.float64]:
    """Real numbers, one or several; a NaN for anything else."""
    try:
        array = np.asarray(value)
        return array.astype(np.float64, copy=False) if array.dtype.kind in "fiu" else np.array(np.nan)
    except UNREADABLE:
        return np.array(np.nan)


def mask_of(value: object) -> npt.NDArray[np.bool_] | None:
    """Booleans as an array: those of an array, a list, or a column of a table; None for anything else."""
    if hasattr(value, "__array__"):
        array = np.asarray(unmasked("the mask", value))
        if array.dtype != object:
            return array if array.dtype == bool else None
        value = array.tolist()  # a column of pandas that may have gaps
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence) or not len(value):
        return None
    return np.array(value) if all(isinstance(each, (bool, np.bool_)) for each in value) else None


def rows_at(index: object, count: int) -> int | list[int]:
    """The row of a table at a number, or those that a slice, a truth for each row, or several numbers choose. Raises
    `IndexError`, `TypeError`, and `OptionError` for a mask of another length."""
    every = range(count)
    if isinstance(index, slice):
        return list(every[index])
    mask = mask_of(index)
    if mask is not None:
        if mask.shape != (count,):
            raise OptionError(f"a mask of shape {mask.shape} does not fit {count} rows: give one entry each")
        return [int(place) for place in np.flatnonzero(mask)]
    several = index.tolist() if isinstance(index, np.ndarray) else index
    try:
        return [every[each] for each in several] if isinstance(several, list) else every[several]  # type: ignore[index]
    except IndexError:
        rows = f"there are {count}, 0 to {count - 1}" if count else "there is none"
        raise IndexError(f"there is no row {shown(index)}: {rows}") from None
    except TypeError:
        raise TypeError(
            f"rows are chosen by a number, a slice, numbers, or a truth for each row, not by {shown(index)}"
        ) from None


def check_ids(what: str, value: object, count: int) -> npt.NDArray[np.int64]:
    """Whole numbers `(n,)` below a count. Raises `OptionError` for other values."""
    unmasked(what, value)
    try:
        array = np.asarray(value)
    except UNREADABLE:
        array = np.empty((0, 0))
    if array.shape == (0,):
        return np.empty(0, dtype=np.int64)
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise OptionError(f"{what} is {shown(value)}: give whole numbers, (n,)")
    if array.min() < 0 or array.max() >= count:
        raise OptionError(f"{what} has numbers from {array.min()} to {array.max()}: give 0 to {count - 1}")
    return array.astype(np.int64, copy=False)


def _is_writable(text: str, encode: Callable[[str], object] = str.encode) -> bool:
    """Whether a text has no half of a character, as file systems and files refuse it."""
    try:
        encode(text)
    except UnicodeEncodeError:
        return False
    return True


def check_threads(threads: object) -> int | None:
    """A number of threads; None for all. Raises `OptionError` for other values."""
    return None if threads is None else check_whole("threads", threads, 1, MOST_THREADS, ", or None for all")


def check_progress(progress: Progress | None) -> Progress | None:
    """A function that takes progress, or None. Raises `OptionError` for other values."""
    if progress is None:
        return None
    if callable(progress):
        try:
            inspect.signature(progress).bind(0.0, "")
            return progress
        except ValueError:
            if not isinstance(progress, type):  # int, for one, takes other arguments
                return progress  # some built-in functions do not say what they take
        except TypeError:
            pass
    raise OptionError(f"progress is {shown(progress)}: give a function of (share done, stage), or None")


def near(asked: object, known: Iterable[str], none: str = "there is none") -> str:
    """A hint with similar words, or with all known words if they are few; `none` if there are none."""
    words = list(known)
    alike = difflib.get_close_matches(asked, words, 3, 0.5) if isinstance(asked, str) else []
    if alike:
        return f"do you mean {' or '.join(alike)}?"
    if len(words) > _MOST_NAMED:
        return f"choose one of the {len(words):,}, such as {words[0]}"
    return f"choose {', '.join(words)}" if words else none
