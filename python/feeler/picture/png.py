"""Writes PNG with the standard library alone."""

from __future__ import annotations

import struct
import zlib
from typing import BinaryIO

import numpy as np
import numpy.typing as npt


def write_png(file: BinaryIO, image: npt.NDArray[np.uint8]) -> None:
    """Writes (height, width, 3) uint8 RGB pixels, sRGB, as a PNG."""
    height, width, _ = image.shape
    # Each row is the difference to the row above (filter 2).
    rows = np.full((height, 1 + 3 * width), 2, dtype=np.uint8)
    rows[:, 1:] = np.diff(image, axis=0, prepend=np.uint8(0)).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    file.write(b"\x89PNG\r\n\x1a\n")
    for kind, data in (
        (b"IHDR", header),
        (b"sRGB", b"\0"),
        (b"IDAT", zlib.compress(rows.tobytes(), 7)),
        (b"IEND", b""),
    ):
        file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
