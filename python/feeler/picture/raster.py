"""Visibility: which triangle is seen at each pixel, in NumPy.

A z-buffer with scanline spans. Triangles are taken front to back in slices; a coarse pyramid of the farthest depths
drops those that are surely hidden before any pixel of theirs is made. A triangle that covers no pixel centre is
dropped at once, which disposes of most triangles of a large mock-up; the rest become rows, the rows become pixels, all
in arrays without a Python loop over triangles.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]

_SLICES = 14  # front-to-back slices; more cull better and cost more passes over the pyramid
_TILE = 8  # pixels along a side of the finest level of the pyramid; `_hidden` halves three times
_SPAN_CHUNK = 1 << 19  # pixels made at a time, so that the arrays stay in the cache


def visible_triangles(
    x: npt.NDArray[Any], y: npt.NDArray[Any], inverse_depth: npt.NDArray[Any], width: int, height: int
) -> tuple[npt.NDArray[np.int64], Float32]:
    """The triangle seen at each pixel, and its inverse depth there.

    x, y: (m, 3) screen coordinates of the corners, pixels, y downwards. inverse_depth: (m, 3), 1 / metres, positive.
    Returns (height, width) int64, -1 where nothing is seen, and (height, width) float32, 0 where nothing is seen.
    Where two triangles are equally near, the later one is seen.
    """
    # One number a pixel, the depth's bits above the triangle's number: positive floats order as their bits do, so
    # the maximum is the nearest triangle.
    buffer = np.zeros(width * height, dtype=np.uint64)
    x, y, w = (np.asarray(a, dtype=np.float32) for a in (x, y, inverse_depth))
    kept = _covering(x, y, width, height)
    if len(kept):
        nearest = _largest(w[kept])
        span = max(float(nearest.max() - nearest.min()), 1e-30)
        level = ((float(nearest.max()) - nearest) * (65535.0 / span)).astype(np.uint16)
        kept = kept[np.argsort(level, kind="stable")]
        # The first slices fill the picture, the later ones are mostly hidden: let them grow.
        edges = (np.linspace(0, 1, _SLICES + 1) ** 1.5 * len(kept)).astype(np.int64)
        for begin, end in pairwise(edges):
            ids = kept[begin:end]
            if begin and len(ids):
                ids = ids[~_hidden(buffer, x[ids], y[ids], w[ids], width, height)]
            if len(ids):
                _draw(buffer, x[ids], y[ids], w[ids], ids, width, height)
    depth = (buffer >> np.uint64(32)).astype(np.uint32).view(np.float32).reshape(height, width)
    seen = (buffer & np.uint64(0xFFFFFFFF)).astype(np.int64).reshape(height, width)
    seen[depth == 0] = -1
    return seen, depth


def _covering(x: Float32, y: Float32, width: int, height: int) -> npt.NDArray[np.int64]:
    """Triangles whose box holds a pixel centre of the picture."""
    kept = np.ones(len(x), dtype=bool)
    for a, size in ((x, width), (y, height)):
        low, high = _smallest(a), _largest(a)
        first = np.maximum(np.ceil(low - np.float32(0.5)), 0)
        last = np.minimum(np.floor(high - np.float32(0.5)), size - 1)
        kept &= first <= last
    return np.flatnonzero(kept)


def _hidden(
    buffer: npt.NDArray[np.uint64], x: Float32, y: Float32, w: Float32, width: int, height: int
) -> npt.NDArray[np.bool_]:
    """Which triangles lie behind what is drawn, everywhere in their box (true only if sure)."""
    depth = buffer.reshape(height, width).view(np.uint32)[:, _HIGH_WORD::2].view(np.float32)
    rows, columns = -(-height // _TILE), -(-width // _TILE)
    padded = np.zeros((rows * _TILE, columns * _TILE), dtype=np.float32)
    padded[:height, :width] = depth
    # The far side of a tile beyond the picture's edge is copied from inside, or it would never hide anything.
    padded[height:, :width] = depth[-1]
    padded[:, width:] = padded[:, width - 1 : width]
    farthest = _halved(_halved(_halved(padded)))
    nearest = _largest(w)
    x0 = np.clip(_smallest(x), 0, width - 1).astype(np.int32) // _TILE
    x1 = np.clip(_largest(x), 0, width - 1).astype(np.int32) // _TILE
    y0 = np.clip(_smallest(y), 0, height - 1).astype(np.int32) // _TILE
    y1 = np.clip(_largest(y), 0, height - 1).astype(np.int32) // _TILE
    hidden = np.zeros(len(x), dtype=bool)
    todo = np.arange(len(x))
    while len(todo):
        # At this level a box of at most 2 by 2 tiles is answered; larger ones wait for a coarser level.
        small = (x1[todo] - x0[todo] <= 1) & (y1[todo] - y0[todo] <= 1)
        t = todo[small]
        far = np.minimum(
            np.minimum(farthest[y0[t], x0[t]], farthest[y0[t], x1[t]]),
            np.minimum(farthest[y1[t], x0[t]], farthest[y1[t], x1[t]]),
        )
        hidden[t] = nearest[t] < far
        todo = todo[~small]
        x0, x1, y0, y1 = x0 >> 1, x1 >> 1, y0 >> 1, y1 >> 1
        r, c = -(-farthest.shape[0] // 2) * 2, -(-farthest.shape[1] // 2) * 2
        farthest = _halved(np.pad(farthest, ((0, r - farthest.shape[0]), (0, c - farthest.shape[1])), mode="edge"))
    return hidden


def _halved(image: Float32) -> Float32:
    """The smallest of each 2 by 2 pixels; much faster than a reduction along short axes."""
    rows = np.minimum(image[0::2], image[1::2])
    return np.minimum(rows[:, 0::2], rows[:, 1::2])


def _smallest(a: Float32) -> Float32:
    return np.minimum(np.minimum(a[:, 0], a[:, 1]), a[:, 2])


def _largest(a: Float32) -> Float32:
    return np.maximum(np.maximum(a[:, 0], a[:, 1]), a[:, 2])


# Which half of a 64-bit word holds its upper 32 bits.
_HIGH_WORD = int(np.array([1], dtype=np.uint64).view(np.uint32)[0])


def _draw(
    buffer: npt.NDArray[np.uint64],
    x: Float32,
    y: Float32,
    w: Float32,
    ids: npt.NDArray[np.int64],
    width: int,
    height: int,
) -> None:
    """Draws triangles: rows, then pixels."""
    by_y = np.argsort(y, axis=1)
    x, y, w = (np.take_along_axis(a, by_y, axis=1) for a in (x, y, w))
    half = np.float32(0.5)
    first = np.maximum(np.ceil(y[:, 0] - half), 0).astype(np.int32)
    last = np.minimum(np.floor(y[:, 2] - half), height - 1).astype(np.int32)
    rows = np.maximum(last - first + 1, 0)
    (xa, xb, xc), (ya, yb, yc), (wa, wb, wc) = x.T, y.T, w.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slope_ac = (xc - xa) / (yc - ya)
        slope_ab = (xb - xa) / (yb - ya)
        slope_bc = (xc - xb) / (yc - yb)
        # The depth plane w = w_a + gx (x - x_a) + gy (y - y_a), in float64: slivers lose many digits.
        ux, uy = (xb - xa).astype(np.float64), (yb - ya).astype(np.float64)
        vx, vy = (xc - xa).astype(np.float64), (yc - ya).astype(np.float64)
        determinant = ux * vy - uy * vx
        du, dv = (wb - wa).astype(np.float64), (wc - wa).astype(np.float64)
        gx = (du * vy - dv * uy) / determinant
        gy = (dv * ux - du * vx) / determinant
    flat = ~(np.isfinite(gx) & np.isfinite(gy))
    gx[flat] = 0
    gy[flat] = 0
    low, high = _smallest(w), _largest(w)
    gx32, gy32 = gx.astype(np.float32), gy.astype(np.float32)

    ends = np.cumsum(rows)
    begin = 0
    while begin < len(rows):
        # As many triangles as give about a chunk of rows, at least one.
        done = int(ends[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(ends, done + _SPAN_CHUNK, side="right")), begin + 1)
        n = rows[begin:end]
        t = np.repeat(np.arange(begin, end), n)
        row = np.arange(len(t)) - np.repeat(np.cumsum(n) - n, n) + first[t]
        centre = row.astype(np.float32) + half
        from_a = centre - ya[t]
        long_edge = xa[t] + from_a * slope_ac[t]
        with np.errstate(invalid="ignore", over="ignore"):
            upper = xa[t] + from_a * slope_ab[t]
            lower = xb[t] + (centre - yb[t]) * slope_bc[t]
        short_edge = np.where(centre < yb[t], upper, lower)
        np.nan_to_num(short_edge, copy=False, nan=0.0, posinf=float(width), neginf=-1.0)
        left = np.maximum(np.ceil(np.minimum(long_edge, short_edge) - half), 0)
        right = np.minimum(np.ceil(np.maximum(long_edge, short_edge) - half), width)
        length = right - left
        some = np.flatnonzero(length > 0)
        if len(some):
            t, left, centre = t[some], left[some], centre[some]
            length = length[some].astype(np.int32)
            base = row[some] * width + left.astype(np.int64)
            # Depth at both ends, held within the triangle's own, then linear between.
            w0 = wa[t] + gx32[t] * (left + half - xa[t]) + gy32[t] * (centre - ya[t])
            w1 = w0 + gx32[t] * (length - 1).astype(np.float32)
            w0 = np.clip(w0, low[t], high[t])
            step = (np.clip(w1, low[t], high[t]) - w0) / np.maximum(length - 1, 1).astype(np.float32)
            _fill(buffer, base, length, w0, step, ids[t])
        begin = end


def _fill(
    buffer: npt.NDArray[np.uint64],
    base: npt.NDArray[np.int64],
    length: npt.NDArray[np.int32],
    w0: Float32,
    step: Float32,
    ids: npt.NDArray[np.int64],
) -> None:
    """Writes spans: `length` pixels from `base` on, with depth w0 + i * step."""
    key = ids.astype(np.uint64)
    one = length == 1
    if one.any():
        _store(buffer, base[one], w0[one], key[one])
        many = np.flatnonzero(~one)
        base, length, w0, step, key = base[many], length[many], w0[many], step[many], key[many]
    ends = np.cumsum(length, dtype=np.int64)
    begin = 0
    while begin < len(length):
        done = int(ends[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(ends, done + _SPAN_CHUNK, side="right")), begin + 1)
        n = length[begin:end]
        offset = np.arange(int(ends[end - 1]) - done) - np.repeat(ends[begin:end] - n - done, n)
        depth = np.repeat(w0[begin:end], n) + np.repeat(step[begin:end], n) * offset.astype(np.float32)
        _store(buffer, np.repeat(base[begin:end], n) + offset, depth, np.repeat(key[begin:end], n))
        begin = end


def _store(
    buffer: npt.NDArray[np.uint64], index: npt.NDArray[np.int64], depth: Float32, key: npt.NDArray[np.uint64]
) -> None:
    value = (depth.view(np.uint32).astype(np.uint64) << np.uint64(32)) | key
    better = value > buffer[index]
    np.maximum.at(buffer, index[better], value[better])
