"""Evaluation of (size, time) curves: fitted optimum, optimal zone, error of an estimator, rank correlation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

ZONE_ABSOLUTE_S = 1e-3
"""The paper's zone: one millisecond more than the optimum, of the hundred at 10 Hz."""

ZONE_RELATIVE = 0.10
"""The zone relative to the optimum's time, for machines on which everything takes less than a millisecond."""

DEGREE = 5


@dataclass(frozen=True)
class Zone:
    """The range of good sizes, metres. At an end of the measured range, the zone may extend beyond."""

    least: float
    most: float
    is_cut: bool


@dataclass(frozen=True)
class Fit:
    """A polynomial of the 5th degree through the logarithms of sizes and times."""

    sizes: tuple[float, ...]
    coefficients: tuple[float, ...]

    @staticmethod
    def of(sizes: Sequence[float], seconds: Sequence[float]) -> Fit:
        """The fit by least squares; of a lower degree for few sizes."""
        x = np.log(sizes)
        middle, half = 0.5 * (x.max() + x.min()), max(0.5 * (x.max() - x.min()), 1e-9)
        degree = min(DEGREE, len(sizes) - 1)
        coefficients = np.polynomial.polynomial.polyfit((x - middle) / half, np.log(seconds), degree)
        return Fit(tuple(float(s) for s in sizes), tuple(float(c) for c in coefficients))

    def seconds(self, size: float) -> float:
        """The time at a size (metres); beyond the measured range, that of the nearest measured size."""
        x = np.log(self.sizes)
        middle, half = 0.5 * (x.max() + x.min()), max(0.5 * (x.max() - x.min()), 1e-9)
        at = float(np.clip((np.log(size) - middle) / half, -1.0, 1.0))
        return float(np.exp(np.polynomial.polynomial.polyval(at, self.coefficients)))

    def _dense(self) -> list[tuple[float, float]]:
        ladder = np.geomspace(min(self.sizes), max(self.sizes), 2001)
        return [(float(size), self.seconds(float(size))) for size in ladder]

    def optimum(self) -> float:
        """The size (metres) with the least fitted time."""
        return min(self._dense(), key=lambda at: at[1])[0]

    def zone(self, most_seconds: float) -> Zone:
        """The sizes around the optimum with at most that time."""
        dense = self._dense()
        best = min(range(len(dense)), key=lambda i: dense[i][1])
        low = high = best
        while low > 0 and dense[low - 1][1] <= most_seconds:
            low -= 1
        while high < len(dense) - 1 and dense[high + 1][1] <= most_seconds:
            high += 1
        return Zone(dense[low][0], dense[high][0], low == 0 or high == len(dense) - 1)


def epsilon(predicted: float, optimum: float, zone: Zone) -> float:
    """Equation 11: the error of a predicted size relative to the half of the zone on its side; at most 1 is inside.

    Infinite if that half is empty: the optimum lies at the end of the measured range.
    """
    error = abs(predicted - optimum)
    half = optimum - zone.least if predicted < optimum else zone.most - optimum
    if error == 0.0:
        return 0.0
    return error / half if half > 0.0 else math.inf


def rank_correlation(one: Sequence[float], other: Sequence[float]) -> float:
    """Spearman's rank correlation: 1 if both order the sizes alike. 0 if one of them has no order."""
    a, b = (_ranks(np.asarray(values, dtype=np.float64)) for values in (one, other))
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0 else 0.0


def power_law(sizes: Sequence[float], seconds: Sequence[float]) -> tuple[float, float]:
    """(exponent, factor) of `seconds = factor * size ** exponent`, by least squares of the logarithms."""
    exponent, shift = np.polyfit(np.log(sizes), np.log(seconds), 1)
    return float(exponent), float(np.exp(shift))


def _ranks(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Ranks; equal values share the mean of theirs."""
    ranks = np.empty(len(values))
    ranks[np.argsort(values, kind="stable")] = np.arange(len(values))
    for value in np.unique(values):
        same = values == value
        ranks[same] = ranks[same].mean()
    return ranks
