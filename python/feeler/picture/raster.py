"""Visibility: the visible triangle at each pixel, computed in arrays without a Python loop over triangles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]

_AT_ONCE = 1 << 19  # rows or pixels made at a time: bounds the memory, and the arrays stay near the cache
_HALF = np.float32(0.5)


class DepthBuffer:
    """A z-buffer filled by scanline spans: triangles become rows, rows become pixels."""

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        # One number per pixel, the depth's bits above the triangle's number: positive floats sort like their bits, so
        # the maximum is the nearest triangle.
        self._keys = np.zeros(width * height, dtype=np.uint64)

    def draw(self, x: npt.NDArray[Any], y: npt.NDArray[Any], inverse_depth: npt.NDArray[Any], ids: IntArray) -> None:
        """Draws triangles; of two at equal depth, the one with the larger number is visible.

        x, y: (m, 3) screen coordinates of the corners, pixels, y downwards. inverse_depth: (m, 3), 1 / metres,
        positive. ids: (m,) the triangles' numbers, 0 to 2^32 - 1.
        """
        corners = np.array([x, y, inverse_depth], dtype=np.float32)
        kept = self._covering(corners)  # most triangles of a large mock-up cover no pixel centre
        corners = np.take_along_axis(corners[:, kept], np.argsort(corners[1, kept], axis=1)[None], axis=2)
        key = ids[kept].astype(np.uint64)
        (xa, xb, xc), (ya, yb, yc), (wa, wb, wc) = corners.transpose(0, 2, 1)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            slope_ac, slope_ab, slope_bc = (xc - xa) / (yc - ya), (xb - xa) / (yb - ya), (xc - xb) / (yc - yb)
            # The depth plane w = w_a + gx (x - x_a) + gy (y - y_a), in float64: slivers lose many digits.
            (ux, uy, du), (vx, vy, dv) = np.array(
                [[xb - xa, yb - ya, wb - wa], [xc - xa, yc - ya, wc - wa]], np.float64
            )
            gradient = np.array([du * vy - dv * uy, dv * ux - du * vx]) / (ux * vy - uy * vx)
        gx, gy = np.where(np.isfinite(gradient), gradient, 0).astype(np.float32)
        low, high = _least(corners[2]), -_least(-corners[2])
        first = np.maximum(np.ceil(ya - _HALF), 0).astype(np.int64)
        last = np.minimum(np.floor(yc - _HALF), self.height - 1).astype(np.int64)
        for t, step in _counted(last - first + 1):
            row = first[t] + step
            centre = row.astype(np.float32) + _HALF
            with np.errstate(invalid="ignore", over="ignore"):
                long = xa[t] + (centre - ya[t]) * slope_ac[t]
                upper, lower = xa[t] + (centre - ya[t]) * slope_ab[t], xb[t] + (centre - yb[t]) * slope_bc[t]
            short = np.where(centre < yb[t], upper, lower)
            left = np.fmax(np.ceil(np.fmin(long, short) - _HALF), 0)
            right = np.fmin(np.ceil(np.fmax(long, short) - _HALF), self.width)
            some = np.flatnonzero(left < right)
            t, left, length = t[some], left[some], (right - left)[some]
            # Depth at both ends, clamped to the triangle's own, then linear between.
            begin = wa[t] + gx[t] * (left + _HALF - xa[t]) + gy[t] * (centre[some] - ya[t])
            end = np.clip(begin + gx[t] * (length - 1), low[t], high[t])
            begin = np.clip(begin, low[t], high[t])
            slope = (end - begin) / np.maximum(length - 1, 1)
            base = row[some] * self.width + left.astype(np.int64)
            for span, pixel in _counted(length.astype(np.int64)):
                depth = begin[span] + slope[span] * pixel.astype(np.float32)
                value = (depth.view(np.uint32).astype(np.uint64) << np.uint64(32)) | key[t[span]]
                pixel += base[span]
                better = value > self._keys[pixel]
                np.maximum.at(self._keys, pixel[better], value[better])

    def seen(self) -> tuple[IntArray, Float32]:
        """The triangle at each pixel, (height, width) int64, -1: none, and its inverse depth, float32, 0: none."""
        keys = self._keys.reshape(self.height, self.width)
        depth = (keys >> np.uint64(32)).astype(np.uint32).view(np.float32)
        return np.where(depth > 0, (keys & np.uint64(0xFFFFFFFF)).astype(np.int64), -1), depth

    def _covering(self, corners: Float32) -> IntArray:
        """Triangles whose box contains a pixel centre."""
        kept = np.ones(corners.shape[1], dtype=bool)
        for a, size in ((corners[0], self.width), (corners[1], self.height)):
            first, last = np.ceil(_least(a) - _HALF), np.floor(-_least(-a) - _HALF)
            kept &= np.maximum(first, 0) <= np.minimum(last, size - 1)
        return np.flatnonzero(kept)


def _least(a: Float32) -> Float32:
    """Minimum of each triangle's three; much faster than a reduction along so short an axis."""
    least: Float32 = np.minimum(np.minimum(a[:, 0], a[:, 1]), a[:, 2])
    return least


def _counted(counts: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Counts from 0 within each group: the group's number and the step, `_AT_ONCE` at a time, or one group."""
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        done = int(ends[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(ends, done + _AT_ONCE, side="right")), begin + 1)
        group = np.repeat(np.arange(begin, end), counts[begin:end])
        yield group, np.arange(len(group)) + done - (ends - counts)[group]
        begin = end
