"""The writers: what they write is read back by an independent reader (trimesh)."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import struct
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh

import feeler
import feeler.clashes
import feeler.haptics
import feeler.picture
from feeler.errors import OptionError
from feeler.io import Mark, Motion, WriteError, animated_glb, body_of, with_marks, write_glb, write_stl
from feeler.io.film import motion_of
from feeler.picture import write_collision_glb

CUBE_VERTICES = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def cubes(paths: list[str], *, shift: float = 0.0) -> feeler.Mockup:
    """One unit cube per path, side by side along x, from `shift` on."""
    n = len(paths)
    vertices = np.concatenate([CUBE_VERTICES + np.array([shift + 2 * i, 0, 0]) for i in range(n)])
    faces = np.concatenate([CUBE_FACES + 8 * i for i in range(n)])
    names = [path.rpartition("/")[2] for path in paths]
    return feeler.Mockup(vertices, faces, np.repeat(np.arange(n), 12), names, part_paths=paths)


def read_json(path: Path) -> Any:
    data = path.read_bytes()
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + length])


def world_triangles(path: Path) -> np.ndarray:
    """All corners of a file in the world, sorted by row."""
    scene = trimesh.load(path, process=False)
    meshes = scene.dump() if isinstance(scene, trimesh.Scene) else [scene]
    corners = np.concatenate([mesh.triangles.reshape(-1, 9) for mesh in meshes])
    return corners[np.lexsort(corners.T[::-1])]


def expected_triangles(*bodies: Any) -> np.ndarray:
    corners = np.concatenate([body.vertices[body.faces].reshape(-1, 9) for body in bodies])
    return corners[np.lexsort(corners.T[::-1])]


def test_glb_comes_back_with_names_and_assembly(tmp_path: Path) -> None:
    mockup = cubes(["plant/pump/casing", "plant/pump/rotor", "plant/frame", "lid"])
    size = write_glb(tmp_path / "a.glb", mockup)
    assert size == (tmp_path / "a.glb").stat().st_size
    document = read_json(tmp_path / "a.glb")
    nodes = document["nodes"]
    children = {nodes[i]["name"]: {nodes[c]["name"] for c in nodes[i].get("children", [])} for i in range(len(nodes))}
    assert children["plant"] == {"pump", "frame"}
    assert children["pump"] == {"casing", "rotor"}
    assert {nodes[i]["name"] for i in document["scenes"][0]["nodes"]} == {"plant", "lid"}
    assert len(document["meshes"]) == 4
    np.testing.assert_array_equal(world_triangles(tmp_path / "a.glb"), expected_triangles(mockup))


def test_glb_of_our_own_has_the_axes_of_the_mockup(tmp_path: Path) -> None:
    """glTF says y up; what feeler wrote is not turned, and raises no doubt beside a file that is z up."""
    mockup = cubes(["one"], shift=3.0)
    write_glb(tmp_path / "a.glb", mockup)
    again = feeler.load_mockup(tmp_path / "a.glb", up="z")
    assert again.report.source.up is None
    np.testing.assert_array_equal(again.bounds, mockup.bounds)
    data = (tmp_path / "a.glb").read_bytes()
    (tmp_path / "b.glb").write_bytes(data.replace(b'"generator":"feeler"', b'"generator":"others"'))
    other = feeler.load_mockup(tmp_path / "b.glb", up="z")
    assert other.report.source.up == "z" and other.bounds[0].tolist() == [3, -1, 0]


def test_glb_orientation_survives(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", cubes(["one"]))
    mesh = trimesh.load(tmp_path / "a.glb", force="mesh")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1.0)


def test_glb_keeps_precision_far_from_the_origin(tmp_path: Path) -> None:
    mockup = cubes(["far/a", "far/b"], shift=123_456.125)
    write_glb(tmp_path / "a.glb", mockup)
    np.testing.assert_allclose(world_triangles(tmp_path / "a.glb"), expected_triangles(mockup), rtol=0, atol=1e-7)


def test_glb_bounds_are_those_of_the_stored_numbers(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    mockup = feeler.Mockup(rng.normal(size=(30, 3)), np.arange(30).reshape(10, 3), np.arange(10) // 5, ["a", "b"])
    write_glb(tmp_path / "a.glb", mockup)
    document = read_json(tmp_path / "a.glb")
    data = (tmp_path / "a.glb").read_bytes()
    binary = data[20 + struct.unpack_from("<I", data, 12)[0] + 8 :]
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        if accessor["type"] == "VEC3":
            start = view.get("byteOffset", 0) + accessor["byteOffset"]
            values = np.frombuffer(binary, "<f4", 3 * accessor["count"], start).reshape(-1, 3)
            np.testing.assert_array_equal(np.float32(accessor["min"]), values.min(axis=0))
            np.testing.assert_array_equal(np.float32(accessor["max"]), values.max(axis=0))
        width = {5126: 4, 5125: 4, 5123: 2}[accessor["componentType"]]
        assert (view.get("byteOffset", 0) + accessor["byteOffset"]) % width == 0


def test_glb_with_vertices_shared_between_parts(tmp_path: Path) -> None:
    mockup = feeler.Mockup(CUBE_VERTICES, CUBE_FACES, np.arange(12) % 3, ["a", "b", "c"])
    write_glb(tmp_path / "a.glb", mockup)
    np.testing.assert_array_equal(world_triangles(tmp_path / "a.glb"), expected_triangles(mockup))


def test_glb_with_a_part_of_more_than_65535_vertices(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    vertices = rng.integers(0, 1024, (70_000, 3)) / 1024.0
    faces = rng.permutation(70_000)[: 3 * 23_000].reshape(-1, 3)
    mockup = feeler.Mockup(np.concatenate([vertices, CUBE_VERTICES]), np.concatenate([faces, CUBE_FACES + 70_000]),
                           np.repeat([0, 1], [len(faces), 12]), ["big", "small"])  # fmt: skip
    write_glb(tmp_path / "a.glb", mockup)
    kinds = [entry["componentType"] for entry in read_json(tmp_path / "a.glb")["accessors"]]
    assert 5125 in kinds and 5123 in kinds
    np.testing.assert_array_equal(world_triangles(tmp_path / "a.glb"), expected_triangles(mockup))


def test_glb_colours_are_linear_and_one_primitive_each(tmp_path: Path) -> None:
    body = with_marks(body_of(cubes(["a", "b"]), colours=(1.0, 1.0, 1.0)), [Mark(np.array([0, 1]), (0.5, 0.0, 1.0))])
    write_glb(tmp_path / "a.glb", body)
    document = read_json(tmp_path / "a.glb")
    assert [len(mesh["primitives"]) for mesh in document["meshes"]] == [2, 1]
    factors = [material["pbrMetallicRoughness"]["baseColorFactor"] for material in document["materials"]]
    assert factors == [[1, 1, 1, 1], [pytest.approx(0.214041, abs=1e-6), 0, 1, 1]]
    marked = document["meshes"][0]["primitives"][1]
    assert document["accessors"][marked["indices"]]["count"] == 6


@pytest.mark.parametrize("colour", [(255, 0, 0), (-1, 0, 0), (1e308,) * 3, (0.0, 0.0, math.inf)])
def test_colours_outside_0_to_1_are_refused(tmp_path: Path, colour: Any) -> None:
    for colours in (colour, [colour, (0, 0, 0)]):
        with pytest.raises(OptionError, match=r"colours has \S+: sRGB colours are 0 to 1"):
            write_glb(tmp_path / "a.glb", cubes(["a", "b"]), colours=colours)
    body = body_of(cubes(["a"]))
    with pytest.raises(OptionError, match=r"palette (has .*: sRGB|has a number that is not finite)"):
        dataclasses.replace(body, palette=np.array([colour, *body.palette]))
    with pytest.raises(OptionError, match=r"colour (has .*: sRGB|has a number that is not finite)"):
        Mark(np.array([0]), colour)


def test_a_motion_of_a_part_that_is_not_there_is_refused() -> None:
    poses = np.stack([np.eye(4)] * 2)
    with pytest.raises(OptionError, match="part"):
        animated_glb(cubes(["a"]), [Motion(1, np.arange(2.0), poses)])
    with pytest.raises(OptionError, match="do not ascend"):
        Motion(0, np.array([1.0, 0.0]), poses)
    with pytest.raises(OptionError, match="poses has shape"):
        Motion(0, np.arange(3.0), poses)


def test_parts_without_a_colour_of_their_own_get_one_as_those_of_other_mockups() -> None:
    mockup = cubes(["plant/a", "plant/b", "shed/c"])
    plain = body_of(mockup)
    mockup.part_colours = np.array([[0.1, 1.0, 0.0], [np.nan] * 3, [np.nan] * 3])
    body = body_of(mockup)
    of_part = [body.palette[body.colour_of_face[12 * part]].tolist() for part in range(3)]
    others = [plain.palette[plain.colour_of_face[12 * part]].tolist() for part in range(3)]
    assert of_part == [[0.1, 1.0, 0.0], *others[1:]]
    assert body_of(mockup, colours=(0.5, 0.5, 0.5)).palette.tolist() == [[0.5, 0.5, 0.5]]
    taken = body_of(feeler.Tool.of_parts(mockup, [2, 0]))
    assert [taken.palette[taken.colour_of_face[12 * part]].tolist() for part in range(2)] == [of_part[0], others[2]]


def test_glb_of_thousands_of_parts(tmp_path: Path) -> None:
    mockup = cubes([f"shelf{i // 50}/box{i}" for i in range(4000)])
    write_glb(tmp_path / "a.glb", mockup)
    assert len(read_json(tmp_path / "a.glb")["meshes"]) == 4000


def test_glb_with_defects_is_still_written(tmp_path: Path) -> None:
    vertices = np.concatenate([CUBE_VERTICES, [[np.nan, 0, 0], [np.inf, 0, 0], [1e300, 0, 0]]])
    faces = np.concatenate([CUBE_FACES, [[0, 1, 8], [0, 1, 9], [0, 1, 10], [0, 1, 4_000_000]]])
    write_glb(tmp_path / "a.glb", feeler.Mockup(vertices, faces))
    document = read_json(tmp_path / "a.glb")
    bounds = next(entry for entry in document["accessors"] if entry["type"] == "VEC3")
    assert (bounds["min"], bounds["max"]) == ([0, 0, 0], [1, 1, 1])


def test_stl_is_binary_and_in_millimetres(tmp_path: Path) -> None:
    mockup = cubes(["a", "b"])
    assert write_stl(tmp_path / "a.stl", mockup) == (tmp_path / "a.stl").stat().st_size == 84 + 24 * 50
    assert not (tmp_path / "a.stl").read_bytes().startswith(b"solid")
    np.testing.assert_array_equal(world_triangles(tmp_path / "a.stl"), 1000 * expected_triangles(mockup))
    write_stl(tmp_path / "m.stl", mockup, unit="m")
    np.testing.assert_array_equal(world_triangles(tmp_path / "m.stl"), expected_triangles(mockup))
    with pytest.raises(feeler.OptionError, match="furlong"):
        write_stl(tmp_path / "b.stl", mockup, unit="furlong")


def hit(mockup_triangles: list[int], tool_triangles: list[int], parts: list[int]) -> SimpleNamespace:
    return SimpleNamespace(
        mockup_triangles=np.array(mockup_triangles, dtype=np.uint32),
        tool_triangles=np.array(tool_triangles, dtype=np.uint32),
        parts=np.array(parts, dtype=np.uint32),
    )


def test_collision_glb_shows_tool_at_its_pose(tmp_path: Path) -> None:
    mockup, tool = cubes(["x/a", "x/b", "x/c", "y/d"]), feeler.Tool(CUBE_VERTICES, CUBE_FACES, "probe")
    pose = np.eye(4)
    pose[:3, 3] = [0.5, 0.5, 0.5]
    write_collision_glb(tmp_path / "hit.glb", mockup, tool, pose, hit([2, 3], [0, 1, 4], [0]))
    document = read_json(tmp_path / "hit.glb")
    assert {"x", "y", "a", "b", "c", "d", "probe"} == {node["name"] for node in document["nodes"]}
    placed = SimpleNamespace(vertices=CUBE_VERTICES + 0.5, faces=CUBE_FACES)
    np.testing.assert_array_equal(world_triangles(tmp_path / "hit.glb"), expected_triangles(mockup, placed))
    by_name = {mesh["name"]: mesh["primitives"] for mesh in document["meshes"]}
    counts = {
        name: sorted(document["accessors"][entry["indices"]]["count"] // 3 for entry in primitives)
        for name, primitives in by_name.items()
    }
    assert counts == {"a": [2, 10], "b": [12], "c": [12], "d": [12], "probe": [3, 9]}


def test_collision_glb_with_context_leaves_far_parts_out(tmp_path: Path) -> None:
    mockup, tool = cubes(["x/a", "x/b", "x/c", "y/d"]), feeler.Tool(CUBE_VERTICES, CUBE_FACES, "probe")
    pose = np.eye(4)
    pose[0, 3] = 0.5  # reaches to 1.5; b begins at 2, c at 4, d (said to be hit) at 6
    write_collision_glb(tmp_path / "hit.glb", mockup, tool, pose, hit([36], [0], [3]), context=0.6)
    names = {mesh["name"] for mesh in read_json(tmp_path / "hit.glb")["meshes"]}
    assert names == {"a", "b", "d", "probe"}


@pytest.mark.parametrize("write", [write_glb, write_stl])
def test_errors_say_what_to_do_and_leave_nothing_behind(tmp_path: Path, write: Any) -> None:
    mockup = cubes(["a"])
    with pytest.raises(WriteError, match="does not exist"):
        write(tmp_path / "nowhere" / "a.out", mockup)
    with pytest.raises(WriteError, match="it is a folder"):
        write(tmp_path, mockup)
    (tmp_path / "file").write_text("old")
    with pytest.raises(WriteError, match="is not a folder"):
        write(tmp_path / "file" / "a.out", mockup)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]
    assert issubclass(WriteError, feeler.FeelerError) and issubclass(WriteError, OSError)


WRITERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "GLB": (".glb", lambda path: write_glb(path, cubes(["a"]))),
    "STL": (".stl", lambda path: write_stl(path, cubes(["a"]))),
    "picture": (".png", lambda path: feeler.picture.render(path, cubes(["a"]), size=(32, 32))),
    "collision": (".glb", lambda path: write_collision_glb(path, *_meeting())),
    "saved scene": (".feeler", lambda path: feeler.Scene(cubes(["a"])).save(path)),
    "clashes": (".json", lambda path: _found().save(path)),
    "rows": (".csv", lambda path: feeler.clashes.write_csv(path, _found())),
    "page": (".html", lambda path: feeler.clashes.write_html(path, _found())),
    "sheet": (".xlsx", lambda path: feeler.clashes.write_xlsx(path, _found())),
    "topics": (".bcf", lambda path: feeler.clashes.write_bcf(path, _found(), _touching())),
    "shown clashes": (".glb", lambda path: feeler.clashes.write_clash_glb(path, _found(), _touching())),
    "rules": (".toml", lambda path: feeler.clashes.write_rules(path, _found())),
    "haptics": (".npz", lambda path: _session().record(path)),
}


def _touching() -> feeler.Mockup:
    vertices = np.concatenate([CUBE_VERTICES, CUBE_VERTICES + 0.5])
    part = np.repeat([0, 1], 12).astype(np.uint32)
    return feeler.Mockup(vertices, np.concatenate([CUBE_FACES, CUBE_FACES + 8]), part, part_names=["a", "b"])


def _found() -> feeler.Clashes:
    return feeler.clash(_touching())


def _meeting() -> Any:
    mockup, tool = cubes(["a"]), feeler.Tool(CUBE_VERTICES + 0.5, CUBE_FACES)
    return mockup, tool, np.eye(4), feeler.Scene(mockup).collide(tool, np.eye(4))


def _session() -> feeler.haptics.Session:
    return feeler.haptics.Session(feeler.Scene(cubes(["a"])), feeler.Tool(0.1 * CUBE_VERTICES, CUBE_FACES))


@pytest.mark.parametrize("name", WRITERS)
def test_no_writer_takes_the_name_of_another_format(tmp_path: Path, name: str) -> None:
    ending, write = WRITERS[name]
    wrong = tmp_path / ("a.STL" if ending != ".stl" else "a.glb")
    with pytest.raises(WriteError, match=re.escape(f"give one that ends in {ending}")):
        write(wrong)
    assert not list(tmp_path.iterdir())
    write(tmp_path / "a.unknown")


@pytest.mark.parametrize("name", WRITERS)
def test_a_name_that_is_too_long_is_refused_in_words(tmp_path: Path, name: str) -> None:
    ending, write = WRITERS[name]
    for path in (tmp_path / ("é" * 5000 + ending), tmp_path / ("é" * 5000) / f"a{ending}"):
        with pytest.raises(WriteError, match="too long") as caught:
            write(path)
        assert str(caught.value).startswith("cannot write ") and len(str(caught.value)) < 500
    assert not list(tmp_path.iterdir())


def test_the_longest_name_is_written(tmp_path: Path) -> None:
    target = tmp_path / ("\U0001f529" * 62 + ".stl")  # 252 bytes, of the 255 that file systems allow
    write_stl(target, cubes(["a"]))
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are of Unix")
def test_what_is_no_file_is_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(WriteError, match="it is a device or a pipe"):
        write_stl(tmp_path / "pipe", cubes(["a"]))
    assert (tmp_path / "pipe").is_fifo()


def test_a_failed_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.stl"
    target.write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("feeler.atomic.os.replace", full)
    with pytest.raises(WriteError, match="No space left"):
        write_stl(target, cubes(["a"]))
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.stl"]


def test_nothing_to_write_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(feeler.MeshError, match="nothing to write"):
        write_glb(tmp_path / "a.glb")
    with pytest.raises(feeler.OptionError, match="colours"):
        write_glb(tmp_path / "a.glb", cubes(["a", "b"]), colours=np.zeros((3, 3)))
    with pytest.raises(feeler.MeshError, match=r"\(n, 3\)"):
        write_glb(tmp_path / "a.glb", SimpleNamespace(vertices=np.zeros(3), faces=np.zeros((1, 3), dtype=int)))


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([1.79e9, 1.79e9 + 0.01, 1.79e9 + 0.02], "are equal in float32"),
        ([0.0, 1.0, 1.0], "are equal in float32"),
        ([0.0, 1e-60, 1.0], "are equal in float32"),
        ([0.0, 1.0, 1e39], "which float32 cannot hold"),
        ([-1.0, 0.0, 1.0], "no negative times"),
    ],
)
def test_times_that_gltf_cannot_hold_are_refused(times: list[float], message: str) -> None:
    motion = Motion(0, np.array(times), np.stack([np.eye(4)] * 3))
    with pytest.raises(OptionError, match=message):
        animated_glb(cubes(["a"]), [motion])


def test_motions_take_lists_and_have_a_time() -> None:
    listed = Motion(0, [0, 1], [np.eye(4)] * 2)  # type: ignore[arg-type]
    arrays = Motion(0, np.array([0.0, 1.0]), np.stack([np.eye(4)] * 2))
    assert animated_glb(cubes(["a"]), [listed]) == animated_glb(cubes(["a"]), [arrays])
    with pytest.raises(OptionError, match="no times"):
        animated_glb(cubes(["a"]), [Motion(0, np.empty(0), np.empty((0, 4, 4)))])


def test_a_film_tells_times_apart_that_are_equal_in_float32(tmp_path: Path) -> None:
    times = np.array([0.0, 20.0, 20.0 + 1e-7, 20.0 + 2e-7, 20.000002])
    (tmp_path / "a.glb").write_bytes(animated_glb(cubes(["a"]), [motion_of(0, times, np.stack([np.eye(4)] * 5))]))
    kept = feeler.load_tracks(tmp_path / "a.glb").times
    assert len(kept) == 5 and (np.diff(kept) > 0.0).all() and kept == pytest.approx(times, abs=1e-5)
