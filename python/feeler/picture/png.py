"""PNG, written with the standard library alone."""

from __future__ import annotations

import struct
import zlib
from typing import BinaryIO

import numpy as np
import numpy.typing as npt


def write_png(file: BinaryIO, image: npt.NDArray[np.uint8]) -> None:
    """Writes (height, width, 3) uint8 RGB pixels, sRGB, as a PNG."""
    height, width, _ = image.shape
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    file.write(b"\x89PNG\r\n\x1a\n")
    for kind, data in (
        (b"IHDR", header),
        (b"sRGB", b"\0"),
        (b"IDAT", zlib.compress(_filtered(image), 7)),
        (b"IEND", b""),
    ):
        file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def _filtered(image: npt.NDArray[np.uint8]) -> bytes:
    """Each row as differences to its left (1), upper (2) or Paeth (4) neighbour, whichever is least in sum."""
    height, width, _ = image.shape
    padded = np.zeros((height + 1, width + 1, 3), dtype=np.int16)
    padded[1:, 1:] = image
    here, left, above, corner = padded[1:, 1:], padded[1:, :-1], padded[:-1, 1:], padded[:-1, :-1]
    to_left, to_above, to_corner = np.abs(above - corner), np.abs(left - corner), np.abs(left + above - 2 * corner)
    paeth = np.where(
        (to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner)
    )
    choices = np.stack([(here - guess).astype(np.uint8).reshape(height, -1) for guess in (left, above, paeth)])
    cost = np.abs(choices.view(np.int8).astype(np.int16)).sum(axis=2, dtype=np.int64)
    best = cost.argmin(axis=0)
    rows = np.empty((height, 1 + 3 * width), dtype=np.uint8)
    rows[:, 0] = np.array([1, 2, 4], dtype=np.uint8)[best]
    rows[:, 1:] = choices[best, np.arange(height)]
    return rows.tobytes()
