"""Geometry as the page gets it: packed pieces of a mock-up, big shapes first, and of what the hand holds."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from feeler._core import Packed, PackedPiece
from feeler.mockup import Mockup, Tool
from feeler.workbench.motion import Floats
from feeler.workbench.protocol import HeldManifest, Manifest, ManifestPiece, Vec3

SMALL_SHARE = 0.01
"""A part is small where its box's diagonal is less than this share of the mock-up's."""


def small_parts(mockup: Mockup) -> npt.NDArray[np.bool_]:
    """`(parts,)`: which parts may be left out while the camera moves."""
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    sizes = np.linalg.norm(np.maximum(0.0, boxes[:, 1] - boxes[:, 0]), axis=1)
    whole = float(np.linalg.norm(mockup.bounds[1] - mockup.bounds[0]))
    small: npt.NDArray[np.bool_] = sizes < SMALL_SHARE * whole
    return small


class Geometry:
    """A mock-up, packed. places: its triangles -> packed triangles."""

    def __init__(self, mockup: Mockup, content: str, name: str, packed: Packed) -> None:
        """content: the digest of the mock-up. packed: `mockup.pack(small=small_parts(mockup))`."""
        self._small = small_parts(mockup)
        self._mockup, self._content, self._name = mockup, content, name
        self._packed = packed
        self.places: npt.NDArray[np.uint32] = self._packed.places

    def manifest(self) -> Manifest:
        """What `GET /scene` says."""
        mockup, (lower, upper) = self._mockup, self._mockup.bounds
        boxes = mockup.part_bounds.reshape(-1, 2, 3)
        # An empty part's box is crossed, and infinite: JSON has no infinity.
        boxes = np.where(np.isfinite(boxes), boxes, [[[1.0] * 3, [0.0] * 3]])
        pieces = _pieces(self._packed)
        return {
            "hash": self._content,
            "name": self._name,
            "unit": mockup.source.unit,
            "up": mockup.source.up or "z",
            "middle": _triple(self._packed.middle),
            "lower": _triple(lower),
            "upper": _triple(upper),
            "triangles": sum(piece["triangles"] for piece in pieces),
            "vertices": sum(piece["vertices"] for piece in pieces),
            "part_bytes": 4 if mockup.part_count > 65_535 else 2,
            "parts": {
                "paths": list(mockup.part_paths),
                "triangles": mockup.part_triangles.tolist(),
                "lower": [_triple(each) for each in boxes[:, 0]],
                "upper": [_triple(each) for each in boxes[:, 1]],
                "small": self._small.astype(int).tolist(),
            },
            "pieces": pieces,
        }

    @property
    def piece_count(self) -> int:
        """How many pieces there are."""
        return len(self._packed.pieces)

    def piece(self, number: int) -> bytes:
        """The bytes of a piece. Raises `IndexError`."""
        if not 0 <= number < self.piece_count:
            raise IndexError(number)
        return _bytes(self._packed.pieces[number])


class HeldGeometry:
    """What the hand holds, packed, in its own frame."""

    def __init__(self, tool: Tool, version: int) -> None:
        self._tool, self._version = tool, version
        self._packed = tool.pack()
        self.places: npt.NDArray[np.uint32] = self._packed.places

    def manifest(self) -> HeldManifest:
        """What a "held" event says."""
        lower, upper = self._tool.bounds
        pieces = _pieces(self._packed)
        return {
            "version": self._version,
            "middle": _triple(self._packed.middle),
            "lower": _triple(lower),
            "upper": _triple(upper),
            "triangles": sum(piece["triangles"] for piece in pieces),
            "vertices": sum(piece["vertices"] for piece in pieces),
            "part_bytes": 4 if self._tool.part_count > 65_535 else 2,
            "parts": list(self._tool.part_paths),
            "pieces": pieces,
        }

    def data(self) -> bytes:
        """Its pieces, one after the other."""
        return b"".join(_bytes(piece) for piece in self._packed.pieces)


def _pieces(packed: Packed) -> list[ManifestPiece]:
    found: list[ManifestPiece] = []
    first = 0
    for piece in packed.pieces:
        lower, upper = np.asarray(piece.bounds, dtype=np.float64)
        found.append(
            {
                "triangles": len(piece.indices),
                "vertices": len(piece.positions),
                "first": first,
                "bytes": sum(_padded(array.nbytes) for array in _arrays(piece)),
                "lower": _triple(lower),
                "upper": _triple(upper),
                "small": bool(piece.is_small),
                "parts": len(np.unique(piece.parts)),
            }
        )
        first += len(piece.indices)
    return found


def _arrays(piece: PackedPiece) -> tuple[npt.NDArray[Any], ...]:
    parts = "<u2" if piece.parts.dtype.itemsize == 2 else "<u4"
    return tuple(
        np.ascontiguousarray(array, dtype=dtype)
        for array, dtype in ((piece.positions, "<f4"), (piece.parts, parts), (piece.indices, "<u2"))
    )


def _bytes(piece: PackedPiece) -> bytes:
    return b"".join(array.tobytes().ljust(_padded(array.nbytes), b"\0") for array in _arrays(piece))


def _padded(size: int) -> int:
    return -(-size // 4) * 4


def _triple(vector: Floats) -> Vec3:
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    return (x, y, z)
