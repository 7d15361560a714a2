"""Copies of parts are sent once: what the page gets is the packed mesh, but for the rounding of float32."""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from loading import instances
from workbench_scene import FACES, Bench, corners

import feeler
from feeler.io import load_mockup
from feeler.workbench.engine.geometry import SHARED, Geometry

GOLDEN = Path(__file__).parent.parent / "testdata" / "workbench"
SHAPE = 2**31

Shapes = dict[int, tuple[npt.NDArray[np.float32], npt.NDArray[np.int64]]]


def whole(data: bytes, part_bytes: int, shapes: Shapes) -> bytes:
    """What the page makes of a piece that was sent; viewer/src/link/shared.ts does the same."""
    head = np.frombuffer(data, "<u4", 5).tolist()
    if head[0] != SHARED:
        return data
    _, runs, places, vertices, triangles = head
    at = 20

    def take(kind: str, count: int, columns: int) -> npt.NDArray[np.generic]:
        nonlocal at
        found = np.frombuffer(data, kind, count * columns, at)
        at += -(-found.nbytes // 4) * 4
        return found.reshape(-1, columns) if columns > 1 else found

    rows, turns = take("<u4", runs, 4), take("<f4", places, 12).astype(float)
    positions, parts = take("<f4", vertices, 3), take(f"<u{part_bytes}", vertices, 1)
    indices = take("<u2", triangles, 3)
    assert at == len(data)
    made: list[list[npt.NDArray[np.generic]]] = [[], [], []]
    vertex = sent = face = place = 0
    for kind, count, faces, part in rows.tolist():
        if kind == 0 or kind >= SHAPE:
            own = (positions[sent : sent + count], parts[sent : sent + count], indices[face : face + faces])
            if kind >= SHAPE:
                shapes[kind - SHAPE] = (own[0], own[2].astype(np.int64) - vertex)
            sent, face = sent + count, face + faces
        else:
            points, corners_of = shapes[kind - 1]
            from_first = points.astype(float) - points[0].astype(float)
            turned = from_first @ turns[place, :9].reshape(3, 3).T + turns[place, 9:]
            own = (turned.astype("<f4"), np.full(count, part, f"<u{part_bytes}"), (corners_of + vertex).astype("<u2"))
            place += 1
        vertex += count
        for column, array in zip(made, own, strict=True):
            column.append(array)
    joined = (np.concatenate(column).tobytes() for column in made)
    return b"".join(block + bytes(-len(block) % 4) for block in joined)


def check(geometry: Geometry) -> tuple[int, int]:
    """Whether every piece arrives, in order; the bytes as packed and as sent."""
    manifest = geometry.manifest()
    shapes: Shapes = {}
    packed = sent = 0
    for number, piece in enumerate(manifest["pieces"]):
        given, wire = geometry.piece(number), geometry.sent(number)
        got = whole(wire, manifest["part_bytes"], shapes)
        ends = 12 * piece["vertices"]
        assert got[ends:] == given[ends:], "parts and triangles are the same"
        one, other = (np.frombuffer(data, "<f4", 3 * piece["vertices"]) for data in (given, got))
        assert np.abs(one.astype(float) - other).max() <= np.abs(one).max() * 2.0**-22
        packed, sent = packed + len(given), sent + len(wire)
    return packed, sent


def turned(count: int, seed: int = 0) -> list[npt.NDArray[np.float64]]:
    """Rotations and places, every other one without a rotation."""
    random = np.random.default_rng(seed)
    found = []
    for number in range(count):
        matrix = np.eye(4)
        if number % 2:
            matrix[:3, :3] = np.linalg.qr(random.normal(size=(3, 3)))[0]
            matrix[:3, 0] *= np.sign(np.linalg.det(matrix[:3, :3]))
        matrix[:3, 3] = [0.1 * number, 0.03 * (number % 7), 0.0]
        found.append(matrix)
    return found


def many(count: int, kinds: int = 1) -> feeler.Mockup:
    """Bolts of some sizes, all with the same triangles, turned and moved; and a plate."""
    bolt = feeler.sample_tool("wrench")
    vertices, faces = [corners((0, 0, -1), (1, 1, -0.5))], [FACES]
    for number, matrix in enumerate(turned(count)):
        size = 1.0 + 0.001 * (number % kinds)
        faces.append(bolt.faces.astype(int) + sum(map(len, vertices)))
        vertices.append(size * bolt.vertices @ matrix[:3, :3].T + matrix[:3, 3])
    return feeler.Mockup(
        np.concatenate(vertices), np.concatenate(faces), np.repeat(range(count + 1), list(map(len, faces)))
    )


def geometry_of(mockup: feeler.Mockup) -> Geometry:
    return Geometry(feeler.Scene(mockup), "hash", "name")


@pytest.mark.parametrize(("kinds", "share"), [(1, 0.05), (3, 0.1)])
def test_copies_are_sent_as_places(kinds, share):
    packed, sent = check(geometry_of(many(100, kinds)))
    assert sent < share * packed


def test_copies_in_later_pieces_are_of_shapes_in_earlier_ones():
    mockup = many(600)
    geometry = geometry_of(mockup)
    assert geometry.piece_count > 2
    assert geometry.sent(0) == geometry.piece(0), "the first picture waits for nothing"
    packed, sent = check(geometry)
    later = sum(len(geometry.piece(number)) for number in range(1, geometry.piece_count))
    assert sent - len(geometry.piece(0)) < 0.05 * later and packed > sent


def test_the_bytes_are_the_same_every_time():
    mockup = many(60, 2)
    geometries = [geometry_of(mockup) for _ in range(3)]
    assert len({tuple(each.sent(number) for number in range(each.piece_count)) for each in geometries}) == 1


def test_parts_that_are_nearly_alike_are_none():
    """A vertex aside, mirrored, and other triangles: each is sent as it is."""
    bolt = feeler.sample_tool("wrench")
    aside = bolt.vertices.copy()
    aside[len(aside) // 3] += [0.0, 0.0, 1e-5]
    mirrored = bolt.vertices * [1.0, 1.0, -1.0]
    faces = bolt.faces.astype(int)
    other = np.roll(faces, 1, axis=1)
    shapes = [(bolt.vertices, faces), (aside, faces), (mirrored, faces), (bolt.vertices, other)]
    base = len(bolt.vertices)
    mockup = feeler.Mockup(
        np.concatenate([np.add(vertices, [0.3 * k, 0, 0]) for k, (vertices, _) in enumerate(shapes)]),
        np.concatenate([rows + base * k for k, (_, rows) in enumerate(shapes)]),
        np.repeat(range(4), len(faces)),
    )
    packed, sent = check(geometry_of(mockup))
    assert sent >= packed


def test_without_copies_nothing_changes():
    geometry = geometry_of(feeler.sample("gearbox", 100_000))
    for number in range(geometry.piece_count):
        assert geometry.sent(number) == geometry.piece(number)
    with pytest.raises(IndexError):
        geometry.sent(geometry.piece_count)


def test_odd_parts_do_not_harm():
    """Points, lines, huge coordinates, and thousands of triangles on one line."""
    line = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]])
    rows = [np.add(line, [0, 0, k]) for k in range(3)] + [
        1e30 * corners((0, 0, 0), (1, 1, 1)) + k * 1e29 for k in range(3)
    ]
    rows += [np.add(corners((0, 0, 0), (1e-30, 1, 1)), [k, 0, 0]) for k in range(9)]
    faces = [np.array([[0, 1, 2]])] * 3 + [FACES] * 12
    bases = np.cumsum([0, *map(len, rows)])
    mockup = feeler.Mockup(
        np.concatenate(rows),
        np.concatenate([each + base for each, base in zip(faces, bases, strict=False)]),
        np.repeat(range(15), list(map(len, faces))),
    )
    check(geometry_of(mockup))


def test_a_file_with_a_hundred_instances(tmp_path):
    bolt = feeler.sample_tool("wrench")
    nodes = [{"matrix": matrix.T.ravel().tolist()} for matrix in turned(100)]
    path = instances(tmp_path / "a.glb", nodes, mesh=(bolt.vertices, bolt.faces))
    mockup = load_mockup(path)
    assert mockup.part_count == 100
    packed, sent = check(geometry_of(mockup))
    assert sent < 0.05 * packed


def test_the_session_sends_both_forms():
    made = Bench(mockup=many(30))
    assert made.session.sent_piece(0)[:4] == struct.pack("<I", SHARED)
    assert len(made.session.piece(0)) == made.session.manifest()["pieces"][0]["bytes"]
    with pytest.raises(feeler.WorkbenchError, match="there is no piece 9"):
        made.session.sent_piece(9)


def golden() -> dict[str, bytes]:
    """A piece with two shapes and a plate, as it is sent and as it is packed; boxes have exact numbers everywhere."""
    box, quarter = corners((0, 0, 0), (0.5, 0.25, 1.0)), np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    rod = corners((0, 0, 0), (0.125, 0.125, 2.0))
    rows = [
        corners((0, 0, -4), (4, 4, -3)),
        rod,
        np.add(rod, [1, 0, 0]),
        box,
        np.add(box, [2, 0, 0]),
        box @ quarter.T + [0, 3, 0],
    ]
    mockup = feeler.Mockup(
        np.concatenate(rows), np.concatenate([FACES + 8 * k for k in range(6)]), np.repeat(range(6), 12)
    )
    geometry = geometry_of(mockup)
    return {"shared.bin": geometry.sent(0), "shared_whole.bin": geometry.piece(0)}


def test_the_golden_files_are_as_they_were():
    found = golden()
    for name, data in found.items():
        assert (GOLDEN / name).read_bytes() == data
    assert whole(found["shared.bin"], 2, {}) == found["shared_whole.bin"]
    assert found["shared.bin"][:4] == struct.pack("<I", SHARED)


if __name__ == "__main__":
    sys.exit([(GOLDEN / name).write_bytes(data) for name, data in golden().items()] == [])
