"""Scenes and queries: the results' shape, what never changes them, memory, threads, progress, lifetimes."""

from __future__ import annotations

import gc
import itertools
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import oracle
import pytest

import feeler
from feeler import PairKind
from feeler.choices import SIMDS

Floats = npt.NDArray[np.float64]

STORES: list[dict[str, Any]] = [
    {"storage": "blocks"},
    {"storage": "dense"},
    {"storage": "hashed", "hashing": 0.0},
    {"storage": "hashed", "hashing": 0.99},
]
stores = pytest.mark.parametrize("store", STORES, ids=["blocks", "dense", "hashed 0", "hashed 0.99"])


def ball(rings: int, radius: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """A closed ball of `4 rings^2` triangles or so."""
    around = 2 * rings
    theta = np.pi * np.arange(1, rings) / rings
    phi = np.pi * np.arange(around) / rings
    grid = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(around)),
        ],
        axis=-1,
    )
    vertices = radius * np.vstack([grid.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    top, bottom = len(vertices) - 2, len(vertices) - 1
    faces = []
    for j in range(around):
        k = (j + 1) % around
        faces += [[top, j, k], [bottom, (rings - 2) * around + k, (rings - 2) * around + j]]
        for i in range(rings - 2):
            a, b = i * around, (i + 1) * around
            faces += [[a + j, b + j, b + k], [a + j, b + k, a + k]]
    return vertices, np.array(faces)


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    """Two balls side by side, a part each, and a third part without triangles."""
    vertices, faces = ball(14, 0.5)
    both = np.vstack([faces, faces + len(vertices)])
    part = np.repeat([0, 2], len(faces))
    shifted = vertices + np.array([2.0, 0, 0])
    return feeler.Mockup(np.vstack([vertices, shifted]), both, part, ["left", "ghost", "right"])


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    return feeler.Tool(*ball(6, 0.3), name="ball")


@pytest.fixture(scope="module")
def poses() -> Floats:
    """Forty poses: most of them touch, some touch both balls or none."""
    rng = np.random.default_rng(4)
    poses = np.tile(np.eye(4), (40, 1, 1))
    for pose in poses:
        angle, axis = rng.uniform(0, 3), rng.normal(size=3)
        x, y, z = axis / np.linalg.norm(axis)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        pose[:3, 3] = rng.uniform([-0.5, -0.5, -0.5], [2.5, 0.5, 0.5])
    return poses


def touching_pose() -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = 0.6, 0.1, 0.05
    return pose


# --- results -------------------------------------------------------------------------------------------------------


def test_what_a_collision_holds(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    hit = feeler.Scene(mockup).collide(tool, touching_pose())
    k = len(hit)
    assert k > 10 and bool(hit)
    assert (hit.pairs.shape, hit.pairs.dtype) == ((k, 2), np.uint32)
    assert (hit.kind_codes.shape, hit.kind_codes.dtype) == ((k,), np.uint8)
    assert hit.pairs.tolist() == np.unique(hit.pairs, axis=0).tolist(), "sorted by row, each once"
    for ids, column in ((hit.tool_triangles, 0), (hit.mockup_triangles, 1)):
        assert ids.dtype == np.uint32
        assert ids.tolist() == np.unique(hit.pairs[:, column]).tolist()
    assert hit.parts.tolist() == np.unique(mockup.part_of_face[hit.mockup_triangles]).tolist() == [0]
    assert f"{k} pairs" in repr(hit)
    found = {(int(a), int(b)): int(kind) for (a, b), kind in zip(hit.pairs, hit.kind_codes, strict=True)}
    assert found == oracle.collide(mockup, tool, touching_pose())


def test_no_contact_is_an_empty_result(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    away = np.eye(4)
    away[1, 3] = 5.0
    hit = feeler.Scene(mockup).collide(tool, away)
    assert len(hit) == 0 and not hit
    assert hit.pairs.shape == (0, 2)
    assert hit.kind_codes.shape == hit.tool_triangles.shape == hit.mockup_triangles.shape == hit.parts.shape == (0,)
    assert hit.pairs.dtype == np.uint32


def test_parts_in_contact(mockup: feeler.Mockup) -> None:
    bar = feeler.Tool([[-1.0, 0, 0], [3.0, 0, 0], [3.0, 0.01, 0]], [[0, 1, 2]])
    hit = feeler.Scene(mockup).collide(bar, np.eye(4))
    assert [mockup.parts[i].name for i in hit.parts] == ["left", "right"]


def test_kinds_have_names() -> None:
    assert [kind.name for kind in PairKind] == ["COPLANAR", "CROSSING", "TOUCHING"]
    assert [kind.code for kind in PairKind] == [0, 1, 2]
    face = feeler.Mockup([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    tool = feeler.Tool(
        [[1.0, 1, 0], [2, 1, 0], [1, 2, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1], [1, 1, 0], [1, 1, 5], [2, 1, 5]],
        [[0, 1, 2], [3, 4, 5], [6, 7, 8]],
    )
    hit = feeler.Scene(face).collide(tool, np.eye(4))
    kinds = hit.kinds
    assert kinds.tolist() == PairKind.words(hit.kind_codes).tolist() == [PairKind(k) for k in hit.kind_codes]
    assert kinds.tolist() == [PairKind.COPLANAR, PairKind.CROSSING, PairKind.TOUCHING]
    assert (kinds == PairKind.CROSSING).tolist() == [False, True, False] and not kinds.flags.writeable
    with pytest.raises(ValueError, match="3 is not a valid PairKind"):
        PairKind(3)


@stores
def test_stats_count_the_stages(store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup, **store)
    hit = scene.collide(tool, touching_pose())
    stats = hit.stats
    assert {"voxels_visited", "entries_scanned", "box_survivors", "triangle_tests", "pairs"} <= set(stats)
    assert all(isinstance(count, int) for count in stats.values())
    assert stats["pairs"] == len(hit)
    assert stats["entries_scanned"] >= stats["box_survivors"] >= stats["triangle_tests"] >= stats["pairs"] > 0
    assert stats["voxels_visited"] > 0
    assert scene.collide(tool, touching_pose()).stats == stats
    # What each filter brings.
    no_boxes = scene.collide(tool, touching_pose(), box_filter=False).stats
    assert no_boxes["triangle_tests"] > stats["triangle_tests"]
    no_repeats = scene.collide(tool, touching_pose(), repeat_filter=False).stats
    assert no_repeats["repeats_skipped"] == 0 < stats["repeats_skipped"]
    assert no_repeats["triangle_tests"] > stats["triangle_tests"]


@stores
def test_filters_never_change_the_answer(
    store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats
) -> None:
    scene = feeler.Scene(mockup, **store)
    for pose in poses[:10]:
        expected = scene.collide(tool, pose)
        for repeats, boxes in itertools.product((True, False), repeat=2):
            hit = scene.collide(tool, pose, repeat_filter=repeats, box_filter=boxes)
            assert hit.pairs.tolist() == expected.pairs.tolist()
            assert hit.kind_codes.tolist() == expected.kind_codes.tolist()


@stores
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_batches_are_single_queries_one_after_the_other(
    store: dict[str, Any], threads: int, mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats
) -> None:
    scene = feeler.Scene(mockup, threads=threads, **store)
    batch = scene.collide_batch(tool, poses)
    assert len(batch) == len(poses)
    assert (batch.offsets.shape, batch.offsets.dtype) == ((len(poses) + 1,), np.uint64)
    assert (batch.pairs.dtype, batch.kind_codes.dtype) == (np.uint32, np.uint8)
    assert batch.pairs.shape == (int(batch.offsets[-1]), 2)
    assert "40 poses" in repr(batch)
    hits = 0
    for i, pose in enumerate(poses):
        hit = scene.collide(tool, pose)
        assert batch[i].tolist() == hit.pairs.tolist()
        first, last = int(batch.offsets[i]), int(batch.offsets[i + 1])
        assert batch.pairs[first:last].tolist() == hit.pairs.tolist()
        assert batch.kind_codes[first:last].tolist() == hit.kind_codes.tolist()
        assert scene.is_colliding(tool, pose) is (len(hit) > 0)
        hits += len(hit) > 0
    assert 10 < hits < 40
    assert batch[-1].tolist() == batch[39].tolist()
    assert [len(pairs) for pairs in batch] == np.diff(batch.offsets.astype(np.int64)).tolist()
    for index in (40, -41):
        with pytest.raises(IndexError):
            batch[index]


def test_every_store_size_and_thread_count_gives_the_same(
    mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats
) -> None:
    expected = [oracle.collide_floats(mockup, tool, pose)[0] for pose in poses[:8]]
    assert sum(map(len, expected)) > 200
    for store, size, threads in itertools.product(STORES, (None, 0.03, 0.4, 9.0), (1, 2, 3)):
        scene = feeler.Scene(mockup, voxel_size=size, threads=threads, **store)
        for pose, pairs in zip(poses, expected, strict=False):
            hit = scene.collide(tool, pose)
            assert {(int(a), int(b)): int(k) for (a, b), k in zip(hit.pairs, hit.kind_codes, strict=True)} == pairs


def test_triangle_ids_are_the_callers(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    # Shuffled faces give shuffled ids, however the index orders them inside.
    rng = np.random.default_rng(0)
    order, turn = rng.permutation(mockup.triangle_count), rng.permutation(tool.triangle_count)
    shuffled = feeler.Mockup(mockup.vertices, mockup.faces[order])
    turned = feeler.Tool(tool.vertices, tool.faces[turn])
    expected = {tuple(pair) for pair in feeler.Scene(mockup).collide(tool, touching_pose()).pairs.tolist()}
    for store in STORES:
        found = feeler.Scene(shuffled, **store).collide(turned, touching_pose()).pairs
        assert {(int(turn[a]), int(order[b])) for a, b in found} == expected


# --- building ------------------------------------------------------------------------------------------------------


def test_what_a_scene_says_of_itself(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([7.0, 9.5])
    monkeypatch.setattr("feeler.scene.time", SimpleNamespace(perf_counter=lambda: next(clock)))
    scene = feeler.Scene(mockup, voxel_size=0.25, storage="hashed", hashing=0.5)
    assert scene.build_seconds == 2.5
    monkeypatch.undo()
    assert (scene.voxel_size, scene.storage, scene.hashing) == (0.25, "hashed", 0.5)
    assert scene.mockup is mockup
    assert "0.25" in repr(scene) and "hashed" in repr(scene)
    assert feeler.Scene(mockup).storage == "blocks"


@stores
def test_memory_is_the_sum_of_its_parts(store: dict[str, Any], mockup: feeler.Mockup) -> None:
    found = feeler.Scene(mockup, **store).memory()
    memory = dict(found)
    total = memory.pop("total")
    assert total == found.total == found["total"] == sum(memory.values())
    assert (found.blocks is None) == ("blocks" not in found) == (found.voxels is not None)
    with pytest.raises(KeyError):
        _ = found["nothing"]
    assert all(isinstance(count, int) for count in memory.values())
    assert memory["triangles"] >= mockup.vertices.nbytes + mockup.faces.nbytes
    assert total < 50 * memory["triangles"]


@pytest.mark.skipif(not Path("/sys/kernel/mm/transparent_hugepage").exists(), reason="no huge pages to ask for")
def test_large_arrays_ask_for_huge_pages() -> None:
    """In a process of its own, whose memory holds nothing that came before."""
    code = """
import re
import numpy as np
import feeler

rows, columns = np.mgrid[0:400, 0:400].reshape(2, -1)
at = (400 * rows + columns).reshape(400, 400)
faces = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:]], axis=-1).reshape(-1, 3)
mockup = feeler.Mockup(np.stack([rows, columns, 0.0 * rows], axis=1), np.vstack([faces, faces[:, ::-1]]))
scene = feeler.Scene(mockup)
# A mapping's lines end with its flags.
mappings = open("/proc/self/smaps").read().split("VmFlags:")
asked = sum(
    int(re.findall(r"^Size: +([0-9]+) kB", before, re.MULTILINE)[-1])
    for before, after in zip(mappings, mappings[1:])
    if " hg" in after.splitlines()[0]
)
print(asked * 1024, sum(scene.memory().values()))
"""
    asked, held = map(int, subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout.split())
    # Which arrays share a mapping depends on when threads ask for memory.
    assert asked > 0.4 * held > 4e6


def test_hashing_saves_what_it_says(mockup: feeler.Mockup) -> None:
    sizes = [
        feeler.Scene(mockup, voxel_size=0.02, storage="hashed", hashing=level).memory()["voxels"]
        for level in (0.0, 0.5, 0.9, 0.99)
    ]
    dense = feeler.Scene(mockup, voxel_size=0.02, storage="dense").memory()["voxels"]
    assert sizes[0] == dense
    for size, level in zip(sizes, (0.0, 0.5, 0.9, 0.99), strict=True):
        assert abs(size / dense - (1 - level)) < 1e-3


def test_the_default_voxel_size_is_the_calibrated_one(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    for storage, hashing in (("blocks", 0.0), ("dense", 0.0), ("hashed", 0.0), ("hashed", 0.9)):
        scene = feeler.Scene(mockup, storage=storage, hashing=hashing, tool=tool)
        assert scene.voxel_size == feeler.optimal_voxel_size(
            mockup, tool, "calibrated", storage=storage, hashing=hashing
        )
        assert 0.001 < feeler.Scene(mockup, storage=storage).voxel_size < 1.0


@pytest.mark.parametrize("estimator", ["area", "diagonal", "side"])
def test_the_optimum_minimises_the_papers_cost(mockup: feeler.Mockup, tool: feeler.Tool, estimator: str) -> None:
    """Equations 3 to 10, written out again: no size nearby costs less."""
    edges = [np.linalg.norm(np.roll(t, -1, axis=0) - t, axis=1) for t in tool.vertices[tool.faces]]
    longest = np.mean([e.max() for e in edges])
    corners = mockup.vertices[mockup.faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).mean()
    edge = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean()

    def cost(d: float) -> float:
        voxels = (longest / d + 2) ** 3
        triangles = {
            "area": np.sqrt(3) * d**2 / (2 * area),
            "diagonal": np.sqrt(3) * d / edge,
            "side": 3 * d / (3 * edge),
        }
        return 0.99 * voxels + 0.01 * voxels * triangles[estimator] * 100

    best = feeler.optimal_voxel_size(mockup, tool, estimator)
    for factor in (0.2, 0.5, 0.9, 0.98, 1.02, 1.1, 2.0, 5.0):
        assert cost(best) < cost(factor * best), factor


def test_the_optimum_scales_with_the_meshes(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    for estimator in ("area", "diagonal", "side"):
        one = feeler.optimal_voxel_size(mockup, tool, estimator)
        big = (
            feeler.Mockup(mockup.vertices * 1000, mockup.faces),
            feeler.Tool(tool.vertices * 1000, tool.faces),
        )
        assert feeler.optimal_voxel_size(*big, estimator) == pytest.approx(1000 * one, rel=1e-6)


@stores
def test_any_tool_can_be_used_whatever_the_size_was_chosen_for(
    store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool
) -> None:
    needle = feeler.Tool([[-1.0, 0, 0], [3.0, 0, 0], [3.0, 0.001, 0]], [[0, 1, 2]])
    scene = feeler.Scene(mockup, tool=needle, **store)
    expected = feeler.Scene(mockup).collide(tool, touching_pose()).pairs.tolist()
    assert scene.collide(tool, touching_pose()).pairs.tolist() == expected


@stores
def test_validate(store: dict[str, Any], mockup: feeler.Mockup) -> None:
    for size in (None, 0.05, 10.0):
        feeler.Scene(mockup, voxel_size=size, **store).validate()


# --- progress ------------------------------------------------------------------------------------------------------


@stores
def test_progress_goes_from_none_to_all(store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    poses = np.tile(np.eye(4), (9000, 1, 1))  # more than one wave
    poses[:, 1, 3] = 3.0
    for threads in (None, 1, 2):
        told: list[tuple[float, str]] = []
        scene = feeler.Scene(mockup, threads=threads, progress=lambda f, s, told=told: told.append((f, s)), **store)
        scene.collide_batch(tool, poses, lambda f, s, told=told: told.append((f, s)))
        building = told[: [f for f, _ in told].index(1.0) + 1]
        for run in (building, told[len(building) :]):
            shares = [share for share, _ in run]
            assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] == 1.0
            assert all(isinstance(stage, str) and stage for _, stage in run)


@stores
def test_an_exception_in_progress_comes_through(
    store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool
) -> None:
    class StopError(Exception):
        """What a cancel button raises."""

    def stop(fraction: float, stage: str) -> None:
        raise StopError(stage)

    for threads in (None, 2):
        with pytest.raises(StopError):
            feeler.Scene(mockup, progress=stop, threads=threads, **store)
        scene = feeler.Scene(mockup, threads=threads, **store)
        with pytest.raises(StopError):
            scene.collide_batch(tool, [touching_pose()], progress=stop)
        assert scene.is_colliding(tool, touching_pose())
    with pytest.raises(KeyboardInterrupt):
        feeler.Scene(mockup, progress=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()), **store)


def test_progress_may_query_the_scene_itself(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    for threads in (None, 1, 2):
        scene = feeler.Scene(mockup, threads=threads)
        found: list[int] = []

        def look(fraction: float, stage: str, scene: feeler.Scene = scene, found: list[int] = found) -> None:
            found.append(len(scene.collide(tool, touching_pose())))
            found.append(len(scene.collide_batch(tool, [touching_pose()]).pairs))

        scene.collide_batch(tool, [np.eye(4)] * 100, progress=look)
        assert len(set(found)) == 1 and found[0] > 0


# --- threads -------------------------------------------------------------------------------------------------------


@stores
def test_many_threads_query_one_scene_at_once(
    store: dict[str, Any], mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats
) -> None:
    scene = feeler.Scene(mockup, threads=2, **store)
    tools = [
        tool,
        feeler.Tool(*ball(3, 0.5)),
        feeler.Tool(*ball(9, 0.2)),
        feeler.Tool([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    ]
    jobs = [(t, pose) for t in tools for pose in poses]

    def run(job: tuple[feeler.Tool, Floats]) -> tuple[Any, ...]:
        hit = scene.collide(*job)
        batch = scene.collide_batch(job[0], job[1][None])
        return hit.pairs.tolist(), hit.kind_codes.tolist(), scene.is_colliding(*job), batch.pairs.tolist(), hit.stats

    serial = [run(job) for job in jobs]
    order = np.random.default_rng(3).permutation(len(jobs))
    start = threading.Barrier(8)
    with ThreadPoolExecutor(8, initializer=start.wait) as pool:
        concurrent = list(pool.map(run, [jobs[i] for i in order]))
    assert concurrent == [serial[i] for i in order]


def test_scenes_are_built_and_dropped_by_many_threads(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    expected = feeler.Scene(mockup).collide(tool, touching_pose()).pairs.tolist()

    def build(i: int) -> Any:
        scene = feeler.Scene(mockup, threads=1 + i % 3, **STORES[i % len(STORES)])
        return scene.collide(tool, touching_pose()).pairs.tolist()

    with ThreadPoolExecutor(6) as pool:
        assert all(pairs == expected for pairs in pool.map(build, range(24)))


@pytest.mark.parametrize("what", ["batch", "build"])
def test_other_python_threads_run_meanwhile(what: str, mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup, threads=1)
    poses = np.tile(touching_pose(), (20_000, 1, 1))
    large = feeler.Mockup(*ball(130, 1.0))
    calls: dict[str, Callable[[], object]] = {
        "batch": lambda: scene.collide_batch(tool, poses),
        "build": lambda: feeler.Scene(large, voxel_size=0.02, storage="dense", threads=1),
    }
    # With the lock held throughout a call, the other thread could count one or two steps at its ends, not many.
    count, stop = 0, threading.Event()

    def work() -> None:
        nonlocal count
        while not stop.wait(0.0002):
            count += 1

    other = threading.Thread(target=work)
    other.start()
    try:
        for _ in range(20):  # on a busy machine the other thread may not get its turn at once
            before = count
            calls[what]()
            if count > before + 5:
                break
        assert count > before + 5
    finally:
        stop.set()
        other.join()


# --- lifetimes -----------------------------------------------------------------------------------------------------


def test_results_are_read_only_and_outlive_everything(tool: feeler.Tool, poses: Floats) -> None:
    mockup = feeler.Mockup(*ball(10, 0.5))
    scene = feeler.Scene(mockup)
    hit, batch = scene.collide(tool, touching_pose()), scene.collide_batch(tool, poses)
    arrays = [hit.pairs, hit.kind_codes, batch.offsets, batch.pairs, batch.kind_codes]
    copies = [array.copy() for array in arrays]
    parts = hit.parts.tolist()
    del scene, mockup, batch
    gc.collect()
    _ = [np.full(1000, 7) for _ in range(1000)]  # overwrites what was freed, if it was
    assert hit.parts.tolist() == parts
    del hit
    gc.collect()
    _ = [np.full(1000, 7) for _ in range(1000)]
    for array, before in zip(arrays, copies, strict=True):
        assert array.tolist() == before.tolist()
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True


def test_a_scene_keeps_its_mock_up_alive(tool: feeler.Tool) -> None:
    scene = feeler.Scene(feeler.Mockup(*ball(10, 0.5), part_names=["only"]))
    gc.collect()
    assert scene.mockup.part_names == ("only",)
    assert scene.is_colliding(tool, touching_pose())


def test_results_cannot_be_changed_or_made(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup)
    hit, batch = scene.collide(tool, np.eye(4)), scene.collide_batch(tool, [np.eye(4)])
    for thing, name in ((hit, "pairs"), (batch, "offsets"), (scene, "voxel_size"), (scene, "mockup")):
        with pytest.raises(AttributeError):
            setattr(thing, name, 1)
    for cls in (feeler.Collision, feeler.Batch):
        with pytest.raises(TypeError, match="cannot create"):
            cls()


def test_subclassing(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    class Bay(feeler.Scene):
        """Counts its queries."""

        count = 0

        def collide(self, *args: Any, **kwargs: Any) -> feeler.Collision:
            self.count += 1
            return super().collide(*args, **kwargs)

    bay = Bay(mockup, storage="dense")
    assert len(bay.collide(tool, touching_pose())) > 0
    assert bay.count == 1


def test_every_instruction_set_of_this_cpu_gives_the_same_answers(
    mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats
) -> None:
    best = feeler.Scene(mockup)
    assert best.simd in SIMDS
    for simd in SIMDS:
        try:
            scene = feeler.Scene(mockup, simd=simd)
        except feeler.OptionError as error:
            assert simd != "portable" and "this CPU has portable" in str(error)
            continue
        assert scene.simd == simd
        for pose in poses[:10]:
            expected, found = best.collide(tool, pose), scene.collide(tool, pose)
            assert np.array_equal(found.pairs, expected.pairs) and np.array_equal(found.kind_codes, expected.kind_codes)
            assert scene.is_colliding(tool, pose) == best.is_colliding(tool, pose)
    with pytest.raises(feeler.OptionError, match='simd is "mmx"'):
        feeler.Scene(mockup, simd="mmx")


@pytest.mark.skipif(sys.platform == "win32", reason="sends SIGINT to a child")
@pytest.mark.parametrize("threads", ["None", "1"])
def test_ctrl_c_stops_a_batch_that_reports_to_nobody(threads: str) -> None:
    script = (
        "import signal, numpy as np, feeler\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "tool = feeler.sample_tool('wrench')\n"
        f"scene = feeler.Scene(feeler.sample('engine', 50_000), threads={threads})\n"
        "poses = np.tile(np.eye(4), (400_000, 1, 1))\n"
        "poses[:, 0, 3] = np.linspace(2, 3, len(poses))\n"
        "print('asking', flush=True)\n"
        "scene.distance_batch(tool, poses)\n"
        "print('answered', flush=True)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "asking\n"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    assert "answered" not in out
    assert "KeyboardInterrupt" in err
