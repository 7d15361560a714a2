"""Geometry for the page: packed pieces of a mock-up, big shapes first, and of the hand's content."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler._core import Packed, PackedPiece
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol import HeldManifest, Manifest, ManifestPiece, Vec3
from feeler.workbench.engine.snapshot import NOT_DRAWN

SHARED = 0x7FC0FEE1
"""The first word of a piece with copies: as a float it is no number, and so no position."""

SMALL_SHARE = 0.01
"""A part is small if its box's diagonal is less than this share of the mock-up's."""


def absent_parts(scene: Scene) -> tuple[int, ...]:
    """The parts excluded from a scene, ascending."""
    return tuple(np.flatnonzero(~scene.part_mask).tolist())


def scene_bounds(scene: Scene) -> Floats:
    """`(2, 3)`: the box of the parts in a scene."""
    boxes = scene.mockup.part_bounds.reshape(-1, 2, 3)[scene.part_mask]
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def small_parts(scene: Scene) -> npt.NDArray[np.bool_]:
    """`(parts,)`: which parts may be skipped while the camera moves."""
    boxes = scene.mockup.part_bounds.reshape(-1, 2, 3)
    sizes = np.linalg.norm(np.maximum(0.0, boxes[:, 1] - boxes[:, 0]), axis=1)
    lower, upper = scene_bounds(scene)
    small: npt.NDArray[np.bool_] = sizes < SMALL_SHARE * float(np.linalg.norm(upper - lower))
    return small


@dataclass(frozen=True, eq=False)
class PackedScene:
    """The parts of a scene in pieces. places: triangles of the mock-up -> packed triangles, or `NOT_DRAWN`."""

    packed: Packed
    places: npt.NDArray[np.uint32]


def pack_scene(scene: Scene) -> PackedScene:
    """The parts of a scene, for drawing: nothing of excluded parts leaves this process."""
    mockup, small = scene.mockup, small_parts(scene)
    if scene.part_mask.all():
        packed = mockup.pack(small=small)
        return PackedScene(packed, packed.places)
    kept = np.flatnonzero(scene.part_mask[mockup.part_of_face])
    names, paths = mockup.part_names, mockup.part_paths
    rest = Mockup(mockup.vertices, mockup.faces[kept], mockup.part_of_face[kept], names, part_paths=paths)
    packed = rest.pack(small=small)
    places = np.full(mockup.triangle_count, NOT_DRAWN, dtype=np.uint32)
    places[kept] = packed.places
    return PackedScene(packed, places)


class Geometry:
    """A scene, packed. places: triangles of its mock-up -> packed triangles."""

    def __init__(self, scene: Scene, content: str, name: str, packed: PackedScene | None = None) -> None:
        """content: the digest of the mock-up. packed: default `pack_scene(scene)`."""
        self._scene, self._content, self._name = scene, content, name
        self._small, self._colours = small_parts(scene), _colours(scene)
        made = pack_scene(scene) if packed is None else packed
        self._packed, self.places = made.packed, made.places

    def manifest(self) -> Manifest:
        """The content of `GET /scene`."""
        mockup, there = self._scene.mockup, self._scene.part_mask
        lower, upper = scene_bounds(self._scene)
        boxes = mockup.part_bounds.reshape(-1, 2, 3)
        # An empty part's box is crossed, and infinite, which JSON lacks. Pages see excluded parts as empty.
        is_seen = np.isfinite(boxes) & there[:, None, None]
        boxes = np.where(is_seen, boxes, [[[1.0] * 3, [0.0] * 3]])
        pieces = _pieces(self._packed)
        return {
            "hash": self._content,
            "name": self._name,
            "unit": mockup.source.unit,
            "up": mockup.source.vertical,
            "middle": _triple(self._packed.middle),
            "lower": _triple(lower),
            "upper": _triple(upper),
            "triangles": sum(piece["triangles"] for piece in pieces),
            "vertices": sum(piece["vertices"] for piece in pieces),
            "part_bytes": 4 if mockup.part_count > 65_535 else 2,
            "parts": {
                "paths": [path if is_there else "" for path, is_there in zip(mockup.part_paths, there, strict=True)],
                "triangles": np.where(there, mockup.part_triangles, 0).tolist(),
                "lower": [_triple(each) for each in boxes[:, 0]],
                "upper": [_triple(each) for each in boxes[:, 1]],
                "small": self._small.astype(int).tolist(),
                "colours": self._colours,
            },
            "pieces": pieces,
        }

    @property
    def piece_count(self) -> int:
        """Number of pieces."""
        return len(self._packed.pieces)

    def piece(self, number: int) -> bytes:
        """The bytes of a piece. Raises `IndexError`."""
        if not 0 <= number < self.piece_count:
            raise IndexError(number)
        return _bytes(self._packed.pieces[number])

    def sent(self, number: int) -> bytes:
        """The bytes of a piece as they are sent: as `piece`, or with copies as places. Raises `IndexError`.

        Copies of other parts, such as bolts, are places of one shape:

            u32 SHARED | u32 runs | u32 places | u32 vertices | u32 triangles | runs (r, 4) u32 | places (c, 12) f32
            | positions, parts and indices of `vertices` and `triangles` that are sent as they are, as of a piece

        A run is (kind, vertices, triangles, part): of kind 0 the next ones that are sent as they are; of 2^31 + n those
        too, which are called shape n from now on, also in later pieces; else the next copy of shape kind - 1. Its place
        is three rows of a rotation, then where the shape's first vertex lies: `to + rotation (p - first)` in float64,
        rounded. Its triangles are the shape's.
        """
        if not 0 <= number < self.piece_count:
            raise IndexError(number)
        # The first picture does not wait until copies are found.
        is_awaited = number == 0 and self.piece_count > 1
        found = None if is_awaited else self._packed._shared(number)
        whole = self._packed.pieces[number]
        if found is None:
            return _bytes(whole)
        runs, places, positions, parts, indices = found
        head = np.array([SHARED, len(runs) // 4, len(places) // 12, len(positions) // 3, len(indices) // 3], "<u4")
        kind = "<u2" if parts.dtype.itemsize == 2 else "<u4"
        rows = ((head, "<u4"), (runs, "<u4"), (places, "<f4"), (positions, "<f4"), (parts, kind), (indices, "<u2"))
        return _joined(np.ascontiguousarray(array, dtype=dtype) for array, dtype in rows)


class HeldGeometry:
    """The content of the hand, packed, in its own frame."""

    def __init__(self, tool: Tool, version: int) -> None:
        self._tool, self._version = tool, version
        self._packed = tool.pack()
        self.places: npt.NDArray[np.uint32] = self._packed.places

    def manifest(self) -> HeldManifest:
        """The content of a "held" event."""
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


def _colours(scene: Scene) -> list[int]:
    """`ManifestParts.colours`. Not even the colour of an excluded part is sent."""
    colours = scene.mockup.part_colours
    if colours is None:
        return []
    has_one = np.isfinite(colours).all(axis=1) & scene.part_mask
    levels = np.rint(255.0 * np.where(has_one[:, None], colours, 0.0)).astype(np.int64)
    packed: list[int] = np.where(has_one, levels @ (0x10000, 0x100, 1), -1).tolist()
    return packed


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
    return _joined(_arrays(piece))


def _joined(arrays: Iterable[npt.NDArray[Any]]) -> bytes:
    return b"".join(array.tobytes().ljust(_padded(array.nbytes), b"\0") for array in arrays)


def _padded(size: int) -> int:
    return -(-size // 4) * 4


def _triple(vector: Floats) -> Vec3:
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    return (x, y, z)
