"""Meshes packed for drawing, in Python; what is promised of pieces is tested in Rust."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import feeler
from feeler.mockup import VERTEX_LIMIT

MOCKUP = feeler.sample("differential", 20_000)


def test_pieces_give_the_mesh_back() -> None:
    packed = MOCKUP.pack(3000)
    assert repr(packed) == f"Packed({MOCKUP.triangle_count} triangles in {len(packed.pieces)} pieces)"
    first = 0
    for piece in packed.pieces:
        assert piece.first == first
        assert (piece.positions.dtype, piece.parts.dtype, piece.indices.dtype) == (np.float32, np.uint16, np.uint16)
        assert len(piece.positions) == len(piece.parts) <= 3000
        triangles = packed.order[first : first + len(piece.indices)]
        given = MOCKUP.vertices[MOCKUP.faces[triangles]]
        np.testing.assert_array_equal(piece.positions[piece.indices], (given - packed.middle).astype(np.float32))
        np.testing.assert_array_equal(piece.parts[piece.indices[:, 0]], MOCKUP.part_of_face[triangles])
        np.testing.assert_array_equal(piece.bounds, [given.min(axis=(0, 1)), given.max(axis=(0, 1))])
        first += len(piece.indices)
    np.testing.assert_array_equal(packed.places[packed.order], np.arange(MOCKUP.triangle_count))
    np.testing.assert_array_equal(packed.middle, MOCKUP.bounds.mean(axis=0))


def test_small_parts_come_last_in_pieces_of_their_own() -> None:
    small = [part.index for part in MOCKUP.parts if max(np.subtract(part.upper, part.lower)) < 0.05]
    assert 0 < len(small) < MOCKUP.part_count
    mask = np.isin(np.arange(MOCKUP.part_count), small)
    for named in (small, mask):
        pieces = MOCKUP.pack(small=named).pieces
        assert [piece.is_small for piece in pieces] == sorted(piece.is_small for piece in pieces)
        for piece in pieces:
            assert (mask[piece.parts] == piece.is_small).all()
    assert not any(piece.is_small for piece in MOCKUP.pack().pieces)


def test_a_piece_outlives_what_it_is_of() -> None:
    positions = feeler.sample_tool("wrench").pack().pieces[0].positions
    assert np.isfinite(positions).all() and not positions.flags.writeable


@pytest.mark.parametrize("limit", [0, 2, -1, VERTEX_LIMIT + 1, 2**80, 3.5, True, "many"])
def test_a_limit_out_of_range_is_refused(limit: Any) -> None:
    for mesh in (MOCKUP, feeler.sample_tool("wrench")):
        with pytest.raises(feeler.OptionError, match=r"vertex_limit is .* 3 to 65535"):
            mesh.pack(limit)


def test_parts_that_are_not_there_are_refused() -> None:
    with pytest.raises(feeler.OptionError, match="no part has the path or name"):
        MOCKUP.pack(small="no such part")
    with pytest.raises(feeler.OptionError, match="mask of shape"):
        MOCKUP.pack(small=np.zeros(1, dtype=bool))
