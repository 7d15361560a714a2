"""The rounding error of coordinates in a file, which stores a limited number of digits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from feeler.io.raw import RawMesh

_CHUNK = 1 << 18
_FEWEST_DIGITS, _MOST_DIGITS = 6, 14
"""Numbers of fewer digits are taken for exact ones, such as 12.5; those of more for double precision."""
_DIGITS_IN_SINGLE, _DIGITS_OF_SINGLE = 7, 9
"""Decimal digits that single precision always holds, and the most with which programs print such a number."""
_SAMPLE = 1000
_MANY, _SOME = 8, 4
"""So many long numbers that end with zeros, and shorter ones that do not, show that a program cut the digits."""
_NOISE = 4.0 * float(np.finfo(np.float64).eps)
"""By how much a number of a few digits may differ from its double, as a share: by rounding, here and in the reader."""


def single(vertices: NDArray[np.floating]) -> float:
    """The largest error of coordinates that were rounded to single precision."""
    largest = np.abs(vertices[np.isfinite(vertices)]).max(initial=0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        error = 0.5 * float(np.spacing(np.float32(largest)))
    return error if np.isfinite(error) else 0.0


def state_rounding(raw: RawMesh, format_name: str) -> None:
    """Sets `rounding` where the reader has not: by the numbers. Coordinates of STEP are in double precision."""
    if raw.rounding is None:
        raw.rounding = 0.0 if format_name == "STEP" else of_numbers(raw.vertices)


def of_numbers(vertices: NDArray[np.float64]) -> float:
    """The largest error of coordinates (n, 3): half a unit in the last digit of the largest one, if all of them are
    single-precision numbers or decimals of few digits; 0 for double precision."""
    if _all(vertices, lambda some: some.astype(np.float32) == some):
        return 0.5 * 10.0 * _tens(vertices) or single(vertices)
    digits = next((n for n in range(1, _MOST_DIGITS + 1) if _all(vertices, partial(_has_digits, n))), 0)
    if digits < _FEWEST_DIGITS:
        return 0.0
    largest = np.abs(vertices[np.isfinite(vertices)]).max()
    if _DIGITS_IN_SINGLE < digits <= _DIGITS_OF_SINGLE and _is_printed_single(vertices):
        return single(vertices)
    return float(0.5 * 10.0 ** (np.floor(np.log10(largest)) + 1.0 - digits))


def _tens(vertices: NDArray[np.float64]) -> float:
    """The place of the last digit of the largest coordinate, in tens, if all are whole numbers of six digits, as C's
    `%g` writes them; 0 otherwise. Longer numbers all end with zeros, though shorter ones do not."""
    if not _all(vertices, lambda some: (some == np.round(some)) & _has_digits(_FEWEST_DIGITS, some)):
        return 0.0
    size = np.abs(vertices[np.isfinite(vertices)])
    long, short = 10.0**_FEWEST_DIGITS, 10.0 ** (_FEWEST_DIGITS - 1)
    is_cut = (size >= long).sum() >= _MANY and ((size < long) & (size >= short) & (size % 10.0 != 0.0)).sum() >= _SOME
    return float(10.0 ** (np.floor(np.log10(size.max())) - _FEWEST_DIGITS)) if is_cut else 0.0


def errors_of(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rounding of each of some numbers by itself: none of few digits, that of single precision, also in text, or
    else half a unit in its last digit."""
    with np.errstate(all="ignore"):
        single = np.float32(numbers)
        size = np.abs(numbers)
        magnitude = np.floor(np.log10(size)) + 1.0
        error = np.zeros(numbers.shape)
        for digits in range(_MOST_DIGITS, _FEWEST_DIGITS - 1, -1):
            has_digits = _has_digits(digits, numbers)
            error[has_digits] = (0.5 * 10.0 ** (magnitude - digits))[has_digits]
        is_few = _has_digits(_FEWEST_DIGITS - 1, numbers)
        is_single = single == numbers
        is_printed = _has_digits(_DIGITS_OF_SINGLE, numbers) & ~is_few & ~is_single
        if _is_printed_single(numbers[is_printed & ~_has_digits(_DIGITS_IN_SINGLE, numbers)]):
            is_single |= is_printed
        error[is_single] = 0.5 * np.spacing(np.abs(single))[is_single]
        error[is_few | ~np.isfinite(error)] = 0.0
    return error


class PlacementErrors:
    """How far off nodes place their points, by the digits of their transforms and of those above them."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, NDArray[np.float64], Sequence[float] | None, Sequence[float], float]] = []

    def add(
        self,
        above: int,
        local: NDArray[np.float64],
        turn: Sequence[float] | None = None,
        scale: Sequence[float] = (1.0,) * 3,
        share: float = 0.0,
    ) -> int:
        """A node below another one, or -1, with its matrix `(4, 4)`, and the quaternion and scale that this is made of,
        if it is. share: an error that its numbers do not show, in units of the distance. Returns its number."""
        self._rows.append((above, local, turn, scale, share))
        return len(self._rows) - 1

    def bounds(self) -> list[tuple[float, float]]:
        """Of each node the error of a point, in units of its distance from the node's origin, and the rest of it."""
        if not self._rows:
            return []
        with np.errstate(all="ignore"):
            matrices = np.array([row[1] for row in self._rows])
            turns = np.array([(0.0, 0.0, 0.0, 1.0) if row[2] is None else row[2] for row in self._rows])
            scales = np.array([row[3] for row in self._rows])
            sizes = np.sqrt(np.square(matrices[:, :3, :3]).sum(axis=1)).max(axis=1)
            of_turn = 2.0 * np.linalg.norm(errors_of(turns), axis=1) / np.linalg.norm(turns, axis=1)
            of_parts = of_turn * np.abs(scales).max(axis=1) + errors_of(scales).max(axis=1)
            of_matrix = np.linalg.norm(errors_of(matrices[:, :3, :3]), axis=(1, 2))
            shares = np.where([row[2] is None for row in self._rows], of_matrix, of_parts)
            shares = (shares + [row[4] for row in self._rows]).tolist()
            moves = np.linalg.norm(matrices[:, :3, 3], axis=1).tolist()
            rests = np.linalg.norm(errors_of(matrices[:, :3, 3]), axis=1).tolist()
        found: list[tuple[float, float]] = []
        scaled: list[float] = []
        for (above, *_), size, share, move, rest in zip(self._rows, sizes.tolist(), shares, moves, rests, strict=True):
            share_above, rest_above = found[above] if above >= 0 else (0.0, 0.0)
            scale_above = scaled[above] if above >= 0 else 1.0
            scaled.append(scale_above * size)
            found.append(
                (share_above * size + scale_above * share, share_above * move + rest_above + scale_above * rest)
            )
        return found

    @staticmethod
    def placed(
        own: float, vertices: NDArray[np.float64], world: NDArray[np.float64], errors: tuple[float, float]
    ) -> float:
        """The error of vertices with an error of their own that a node places: as its matrix in the world scales it,
        and that of the place, one of `bounds`."""
        share, rest = errors
        with np.errstate(all="ignore"):
            scale = float(np.sqrt(np.square(world[:3, :3]).sum(axis=0)).max())
            far = 0.0
            if share > 0.0:
                finite = vertices[np.isfinite(vertices).all(axis=1)]
                far = float(np.sqrt(np.square(np.abs(finite).max(axis=0, initial=0.0)).sum()))
            found = own * scale + share * far + rest
        return found if math.isfinite(found) else 0.0


def _is_printed_single(numbers: NDArray[np.float64]) -> bool:
    """Whether numbers of 8 or 9 digits are those of single precision in text, by some of them."""
    flat = numbers[np.isfinite(numbers)]
    if not len(flat):
        return False
    some = flat[:: max(1, len(flat) // _SAMPLE)].tolist()
    with np.errstate(over="ignore"):
        return all(number in (float(str(np.float32(number))), float(f"{np.float32(number):.9g}")) for number in some)


def _has_digits(digits: int, numbers: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which numbers have at most this many significant digits."""
    size = np.abs(numbers)
    with np.errstate(all="ignore"):
        unit = 10.0 ** (np.floor(np.log10(size)) + 1.0 - digits)
        rest = np.abs(np.round(size / unit) * unit - size)
    return np.asarray((size == 0.0) | (rest <= _NOISE * size))


def _all(vertices: NDArray[np.float64], is_so: Callable[[NDArray[np.float64]], NDArray[np.bool_]]) -> bool:
    """Whether something holds for all finite coordinates."""
    flat = vertices.reshape(-1)
    for begin in range(0, len(flat), _CHUNK):
        some = flat[begin : begin + _CHUNK]
        some = some[np.isfinite(some)]
        with np.errstate(over="ignore", invalid="ignore"):
            if not is_so(some).all():
                return False
    return True
