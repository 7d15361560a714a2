"""Saved scenes: the same answers from a file, and no answer from a file that is not whole."""

from __future__ import annotations

import copy
import gc
import json
import multiprocessing
import os
import pickle
import struct
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json

import feeler
from feeler.io import WriteError, write_glb, write_stl


@pytest.fixture(scope="module")
def engine() -> feeler.Scene:
    mockup = feeler.sample("engine", 20_000)
    colours = np.linspace(0.0, 1.0, 3 * mockup.part_count).reshape(-1, 3)
    colours[3] = np.nan
    mockup.part_colours = colours
    return feeler.Scene(mockup)


@pytest.fixture(scope="module")
def file(engine: feeler.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "engine.feeler"
    engine.save(path)
    return path


@cache
def _poses() -> Any:
    return feeler.sample_poses(
        feeler.Scene(feeler.sample("engine", 20_000)), feeler.sample_tool("wrench"), "nominal", 20
    )


def answers(scene: feeler.Scene) -> list[Any]:
    tool = feeler.sample_tool("wrench")
    poses = _poses()
    batch = scene.collide_batch(tool, poses)
    found: list[Any] = [batch.pairs.tolist(), batch.offsets.tolist(), scene.part_mask.tolist()]
    for pose in poses[:5]:
        near, planes = scene.clearance(tool, pose, 0.01), scene.contacts(tool, pose, 0.01)
        found += [near.parts.tolist(), near.distances.tolist(), planes.gaps.tolist()]
        found += [scene.containment(tool, pose).containing.tolist(), scene.is_colliding(tool, pose, touching="free")]
    return found


def test_a_scene_that_was_saved_answers_as_before(engine: feeler.Scene, file: Path) -> None:
    for verify in (True, False):
        opened = feeler.open_scene(file, verify)
        assert answers(opened) == answers(engine)
        assert opened.build_seconds == 0.0 and opened.voxel_size == engine.voxel_size
        assert "adjacency" in opened.memory(), "no query finds it again"
        ours, theirs = engine.mockup, opened.mockup
        assert (theirs.part_names, theirs.part_paths) == (ours.part_names, ours.part_paths)
        assert theirs.report == ours.report
        assert theirs.part_colours is not None and ours.part_colours is not None
        assert np.array_equal(theirs.part_colours, ours.part_colours, equal_nan=True)
        assert np.array_equal(theirs.vertices, ours.vertices) and np.array_equal(theirs.faces, ours.faces)
        with pytest.raises(ValueError, match="read-only"):
            theirs.vertices[0, 0] = 1.0
    assert len(feeler.clash(opened.mockup)) == len(feeler.clash(engine.mockup)) > 100


def test_a_mock_up_of_a_file_brings_its_index(file: Path, engine: feeler.Scene) -> None:
    mockup = feeler.load_mockup(file)
    scene = feeler.Scene(mockup)
    assert scene.build_seconds == 0.0 and answers(scene) == answers(engine)
    other = feeler.Scene(mockup, voxel_size=0.01, threads=1, simd="portable")
    assert other.voxel_size == 0.01 and other.simd == "portable" and answers(other) == answers(engine)
    assert feeler.Scene(mockup, simd="portable").simd == "portable"
    with pytest.raises(feeler.OptionError, match="threads"):
        feeler.Scene(mockup, threads=0)
    with pytest.raises(feeler.LimitError):
        small = feeler.Scene(mockup, memory_limit=100)
        small.collide_batch(feeler.sample_tool("wrench"), _poses())
    tool = feeler.load_tool(file)
    assert tool.name == "engine" and tool.part_paths == mockup.part_paths
    for option in ({"unit": "mm"}, {"up": "z"}, {"chord_tolerance": 0.1}):
        with pytest.raises(feeler.OptionError, match=r"which is for meshes.*: give it when"):
            feeler.load_mockup(file, **option)
    with pytest.raises(feeler.LoadError, match="cannot be joined with other files"):
        feeler.load_mockup([file, file])


@pytest.mark.parametrize("storage", ["dense", "hashed"])
def test_other_storages_are_built_again(storage: str, engine: feeler.Scene, tmp_path: Path) -> None:
    scene = feeler.Scene(engine.mockup, storage=storage, hashing=0.5 if storage == "hashed" else 0.0)
    scene.save(tmp_path / "a.feeler")
    opened = feeler.open_scene(tmp_path / "a.feeler")
    assert (opened.storage, opened.hashing) == (scene.storage, scene.hashing)
    assert answers(opened) == answers(engine)


def test_parts_that_are_out_stay_out(engine: feeler.Scene, tmp_path: Path) -> None:
    without = engine.without([3, 5])
    without.save(tmp_path / "a.feeler")
    opened = feeler.open_scene(tmp_path / "a.feeler")
    assert answers(opened) == answers(without)
    assert feeler.Scene(feeler.load_mockup(tmp_path / "a.feeler")).part_mask.all()
    again = pickle.loads(pickle.dumps(opened))
    assert np.flatnonzero(~again.part_mask).tolist() == [3, 5]
    assert "without 2 of its parts, which are there again" in run("info", tmp_path / "a.feeler").stderr


def test_a_pickle_is_path_and_hash(file: Path, engine: feeler.Scene, tmp_path: Path) -> None:
    scene = feeler.open_scene(file)
    packed = pickle.dumps(scene)
    assert len(packed) < 1000
    assert answers(pickle.loads(packed)) == answers(engine)
    scene.mockup.note = "kept"  # type: ignore[attr-defined]
    scene.mockup.part_colours = None
    restored = pickle.loads(pickle.dumps(scene)).mockup
    assert restored.note == "kept" and restored.part_colours is None
    assert copy.deepcopy(scene.mockup).note == "kept"  # type: ignore[attr-defined]
    other = tmp_path / "other.feeler"
    feeler.Scene(engine.mockup).save(other)
    packed = pickle.dumps(feeler.open_scene(other))
    gc.collect()
    feeler.Scene(feeler.sample("differential", 10_000)).save(other)
    with pytest.raises(feeler.LoadError, match="another mock-up"):
        pickle.loads(packed)
    other.unlink()
    with pytest.raises(feeler.LoadError, match="the pickle names a saved scene by its path"):
        pickle.loads(packed)


def test_a_mock_up_whose_file_is_gone_travels_as_arrays(engine: feeler.Scene, tmp_path: Path) -> None:
    engine.save(tmp_path / "a.feeler")
    scene = feeler.open_scene(tmp_path / "a.feeler")
    (tmp_path / "a.feeler").unlink()
    assert answers(pickle.loads(pickle.dumps(scene))) == answers(engine)


def _distances(scene: feeler.Scene) -> list[Any]:
    return answers(scene)


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_other_processes_open_the_file(method: str, file: Path, engine: feeler.Scene) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip("this system does not fork")
    scene = feeler.open_scene(file)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(_distances, [scene, scene, scene]) == [answers(engine)] * 3


def test_the_hash_is_that_of_the_mock_up(engine: feeler.Scene, tmp_path: Path) -> None:
    first = engine.save(tmp_path / "a.feeler")
    assert len(first) == 32 and first == feeler.Scene(engine.mockup, 0.02).save(tmp_path / "b.feeler")
    assert first != feeler.Scene(feeler.sample("engine", 20_000, seed=1)).save(tmp_path / "c.feeler")


def test_files_that_are_not_whole_are_refused_in_words(file: Path, tmp_path: Path) -> None:
    whole = file.read_bytes()
    other = tmp_path / "other.feeler"

    def said(content: bytes) -> str:
        other.write_bytes(content)
        with pytest.raises(feeler.LoadError) as error:
            feeler.open_scene(other)
        assert str(error.value).startswith(f"{other}: the scene cannot be opened: ")
        return str(error.value)

    assert "not a saved scene" in said(b"solid of STL\n")
    assert "not a saved scene" in said(b"")
    assert "cut off" in said(whole[:-70_000])
    at = whole.rindex(b'{"part_names"')
    assert "damaged (document)" in said(whole[:at] + b"[" + whole[at + 1 :])
    assert "layout 999" in said(whole[:8] + (999).to_bytes(4, "little") + whole[12:])
    assert "damaged (mesh.vertices)" in said(whole[:65_536] + bytes([whole[65_536] ^ 1]) + whole[65_537:])
    with pytest.raises(feeler.MissingFileError, match="there is no such file"):
        feeler.open_scene(tmp_path / "none.feeler")
    for path in (None, 3, "", "a\0b", "\ud800", b"a"):
        with pytest.raises(feeler.OptionError, match="give the path of a file"):
            feeler.open_scene(path)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="verify"):
        feeler.open_scene(file, "no")  # type: ignore[arg-type]


def test_a_document_that_cannot_be_right_is_refused(engine: feeler.Scene, tmp_path: Path) -> None:
    path = tmp_path / "a.feeler"
    names = engine.mockup.part_names
    for document in (
        b"",
        b"{}",
        b"[1]",
        json.dumps({"part_names": names[1:], "part_paths": None, "source": {}}).encode(),
    ):
        feeler._core.Scene._save(engine, str(path), [("document", document)], None)  # type: ignore[attr-defined]
        with pytest.raises(feeler.LoadError, match="its document is damaged"):
            feeler.open_scene(path)


def test_colours_of_earlier_versions_are_made_to_fit(tmp_path: Path) -> None:
    mockup = feeler.Mockup(np.eye(3), [[0, 1, 2]] * 3, [0, 1, 2])
    vars(mockup)["part_colours"] = np.array([[255.0, 0.5, -1.0], [np.inf, 0.0, 0.0], [0.5, np.nan, 0.5]])
    feeler.Scene(mockup).save(tmp_path / "s.feeler")
    opened = feeler.open_scene(tmp_path / "s.feeler").mockup
    assert np.array_equal(opened.part_colours, [[1.0, 0.5, 0.0], [np.nan] * 3, [np.nan] * 3], equal_nan=True)


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_a_link_stays_and_its_file_is_written(tmp_path: Path) -> None:
    scene = feeler.Scene(feeler.Mockup(np.eye(3), [[0, 1, 2]]))
    (tmp_path / "link.feeler").symlink_to(tmp_path / "there.feeler")
    digest = scene.save(tmp_path / "link.feeler")
    assert (tmp_path / "link.feeler").is_symlink() and (tmp_path / "there.feeler").is_file()
    assert feeler.open_scene(tmp_path / "link.feeler").save(tmp_path / "again.feeler") == digest
    with pytest.raises(WriteError, match="folder"):
        scene.save(f"{tmp_path}/new/")


def test_places_that_cannot_be_written_are_refused(engine: feeler.Scene, tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "no" / "a.feeler", Path("/")):
        with pytest.raises(feeler.WriteError, match="cannot write"):
            engine.save(path)
    for path in (None, 3, "", "a\0b", b"a"):
        with pytest.raises(feeler.WriteError, match="give the path of a file"):
            engine.save(path)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of POSIX")
def test_a_full_disk_loses_nothing(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.feeler"
    path.write_bytes(file.read_bytes())
    code = """
import resource, signal, sys, feeler
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
scene = feeler.Scene(feeler.sample("engine", 20_000, seed=1))
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))
try:
    scene.save(sys.argv[1])
except feeler.WriteError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert "cannot be saved" in done.stdout and "large" in done.stdout, done
    assert path.read_bytes() == file.read_bytes() and [p.name for p in tmp_path.iterdir()] == ["a.feeler"]


def test_progress_is_told_and_stops_the_work(engine: feeler.Scene, file: Path, tmp_path: Path) -> None:
    told: list[tuple[float, str]] = []
    engine.save(tmp_path / "a.feeler", progress=lambda share, stage: told.append((share, stage)))
    assert told[0][1] == "finding the connectivity" and told[-1] == (1.0, "saved")
    assert told == sorted(told, key=lambda each: each[0])

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        engine.save(tmp_path / "b.feeler", progress=stop)
    assert not [path for path in tmp_path.iterdir() if path.suffix == ".part"]
    with pytest.raises(ZeroDivisionError):
        feeler.open_scene(file, progress=lambda *_: 1 / 0)


def test_commands_take_saved_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = run_json("index", "sample:engine:20000")
    assert made["out"] == "engine.feeler" and made["bytes"] == os.path.getsize("engine.feeler")
    tool = ("--tool", "sample:wrench", "--at")
    for words in (("collide", *tool, "0.1,0.2,0.3"), ("clearance", *tool, "0,0.9,1", "--within", "0.6"), ("clash",)):
        ours, theirs = (
            {**run_json(words[0], source, *words[1:], code=code), "seconds": None, "mockup": None}
            for source in ("engine.feeler", "sample:engine:20000")
            for code in [_code(words, source)]
        )
        assert _facts(ours) == _facts(theirs), words
    assert "--out" in error_of("index", "engine.feeler", "--out", "engine.feeler")
    assert "ends in .feeler" in error_of("index", "engine.feeler", "--out", "engine.stl")
    assert "does not exist" in error_of("index", "engine.feeler", "--out", "no/a.feeler")
    run("index", "engine.feeler", "--voxel-size", "0.02", "-o", "finer.feeler")
    assert feeler.open_scene("finer.feeler").voxel_size == 0.02


def _code(words: tuple[str, ...], source: str) -> int:
    from commands import app
    from typer.testing import CliRunner

    return CliRunner().invoke(app, [words[0], source, *words[1:], "--json"]).exit_code


def _facts(document: dict[str, Any]) -> Any:
    """Without times and sizes."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            left = {"seconds", "mockup", "scene", "stats"}
            return {
                key: plain(each)
                for key, each in value.items()
                if key not in left and not key.endswith(("_s", "_ms", "_us", "_seconds"))
            }
        return [plain(each) for each in value] if isinstance(value, list) else value

    return plain(document)


def test_a_cache_is_used_until_a_file_changes(tmp_path: Path) -> None:
    box = feeler.sample_tool("torque")
    mesh, cache = tmp_path / "a.stl", tmp_path / "cache"
    write_stl(mesh, box)
    plain = feeler.load_mockup(mesh)
    assert not cache.exists()
    first = feeler.load_mockup(mesh, cache=cache)
    (entry,) = cache.iterdir()
    written = entry.stat().st_mtime_ns
    again = feeler.load_mockup(mesh, cache=cache)
    assert entry.stat().st_mtime_ns == written
    for loaded in (first, again):
        assert feeler.Scene(loaded).build_seconds == 0.0
        assert np.array_equal(loaded.vertices, plain.vertices) and loaded.part_paths == plain.part_paths
        assert loaded.report.source.notes == plain.report.source.notes
    # Other options are another entry; a damaged entry, and one of a file that changed, are made again.
    assert feeler.load_mockup(mesh, "m", cache=cache).bounds[1, 0] == pytest.approx(1000 * plain.bounds[1, 0])
    assert len(list(cache.iterdir())) == 2
    entry.write_bytes(entry.read_bytes()[:-1])
    assert np.array_equal(feeler.load_mockup(mesh, cache=cache).vertices, plain.vertices)
    write_stl(mesh, feeler.sample_tool("wrench"))
    os.utime(mesh, ns=(0, 1))
    changed = feeler.load_mockup(mesh, cache=cache)
    assert changed.triangle_count == feeler.sample_tool("wrench").triangle_count != plain.triangle_count
    for bad in (3, b"a", ""):
        with pytest.raises(feeler.OptionError, match="cache is"):
            feeler.load_mockup(mesh, cache=bad)  # type: ignore[arg-type]


def test_a_cache_sees_a_file_whose_size_and_time_are_as_they_were(tmp_path: Path) -> None:
    """Rewritten in place, and its time set back, as programs that copy do."""
    mesh = tmp_path / "a.stl"
    sizes = []
    for height in (1.0, 2.0):
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, height, 0]])
        before = mesh.stat() if mesh.exists() else None
        with mesh.open("r+b" if before else "wb") as file:
            file.write(bytes(80) + struct.pack("<I12fH", 1, *[0.0] * 3, *corners.ravel(), 0))
        if before:
            os.utime(mesh, ns=(before.st_atime_ns, before.st_mtime_ns))
            after = mesh.stat()
            assert (after.st_size, after.st_mtime_ns) == (before.st_size, before.st_mtime_ns)
        sizes.append(feeler.load_mockup(mesh, "m", cache=tmp_path / "cache").bounds[1, 1])
    assert sizes == [1.0, 2.0]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such limit of a name")
def test_a_cache_whose_name_is_too_long_is_refused(tmp_path: Path) -> None:
    mesh = tmp_path / "a.stl"
    write_stl(mesh, feeler.sample_tool("wrench"))
    for folder in (tmp_path / ("x" * 5000), tmp_path / "x" / ("x" * 300)):
        with pytest.raises(WriteError, match="the cache cannot be made: File name too long"):
            feeler.load_mockup(mesh, cache=folder)


def test_a_cache_sees_the_files_beside_a_gltf(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", feeler.sample("differential", 10_000))
    whole = (tmp_path / "a.glb").read_bytes()
    length = int.from_bytes(whole[12:16], "little")
    document = json.loads(whole[20 : 20 + length])
    document["buffers"][0]["uri"] = "a.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    binary = bytearray(whole[28 + length :])
    (tmp_path / "a.bin").write_bytes(binary)
    first = feeler.load_mockup(tmp_path / "a.gltf", cache=tmp_path / "cache").vertices.copy()
    view = document["bufferViews"][document["accessors"][0]["bufferView"]]
    at = view.get("byteOffset", 0)
    binary[at : at + 4] = np.float32(7.0).tobytes()
    (tmp_path / "a.bin").write_bytes(binary)
    os.utime(tmp_path / "a.bin", ns=(0, 1))
    second = feeler.load_mockup(tmp_path / "a.gltf", cache=tmp_path / "cache").vertices
    assert not np.array_equal(first, second)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")  # to open it would wait for somebody who writes
    with pytest.raises(feeler.LoadError):
        feeler.open_scene(tmp_path / "pipe")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has other permissions")
def test_a_replaced_file_keeps_its_permissions(tmp_path: Path) -> None:
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    writers = {"a.feeler": scene.save, "a.glb": lambda path: write_glb(path, scene.mockup)}
    for name, write in writers.items():
        path = tmp_path / name
        write(path)
        path.chmod(0o640)
        write(path)
        assert path.stat().st_mode & 0o777 == 0o640, name


def test_a_cache_that_cannot_be_written_does_not_lose_what_was_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh, cache_folder = tmp_path / "a.stl", tmp_path / "cache"
    write_stl(mesh, feeler.sample("differential", 10_000))

    def full(*_: Any) -> None:
        raise WriteError("cannot write it: No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(feeler.Scene, "_save_with", full)
        with pytest.warns(RuntimeWarning, match="nothing is kept in the cache: .*No space left"):
            found = feeler.load_mockup(mesh, cache=cache_folder)
    assert np.array_equal(found.vertices, feeler.load_mockup(mesh).vertices)
    (cache_folder / "in the way").mkdir()
    feeler.load_mockup(mesh, cache=cache_folder)
    (entry,) = cache_folder.glob("*.feeler")
    entry.unlink()
    entry.mkdir()  # in the way
    with pytest.warns(RuntimeWarning, match="nothing is kept in the cache"):
        assert feeler.load_mockup(mesh, cache=cache_folder).triangle_count == found.triangle_count


def test_a_list_of_one_saved_scene_is_that_scene(tmp_path: Path) -> None:
    feeler.Scene(feeler.sample("differential", 10_000)).save(tmp_path / "a.feeler")
    for given in ([tmp_path / "a.feeler"], (str(tmp_path / "a.feeler"),)):
        assert feeler.load_mockup(given)._saved is not None
    said = run("info", tmp_path / "a.feeler").stdout
    assert "triangles" in said and "loaded in" not in said


def test_workers_of_a_scene_whose_file_was_replaced(tmp_path: Path) -> None:
    """They get what the scene has, not what the file has by now."""
    path = tmp_path / "a.feeler"
    mockup = feeler.sample("differential", 10_000)
    feeler.Scene(mockup).save(path)
    scene = feeler.open_scene(path)
    feeler.Scene(mockup).save(path)
    with scene._in_a_file() as same:
        assert same.mockup._saved.path == str(path), "the same content, if of another time"
    feeler.Scene(feeler.sample("differential", 20_000)).save(path)
    with scene._in_a_file() as there:
        assert there.mockup._saved.path != str(path)
        assert np.array_equal(there.mockup.vertices, mockup.vertices)
        assert len(pickle.dumps(there)) < 2000 < len(pickle.dumps(scene))
    assert np.array_equal(pickle.loads(pickle.dumps(scene.mockup)).vertices, mockup.vertices)


def test_variants_saved_without_parts_are_told(tmp_path: Path) -> None:
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    scene.without([1]).save(tmp_path / "a.feeler")
    with pytest.warns(
        UserWarning, match=r"variants\[0\]: the scene was saved without 1 of its parts, which are checked"
    ):
        feeler.clash_variants([tmp_path / "a.feeler"])
