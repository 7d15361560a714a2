"""Work on executors: the same rows in the same order, whatever the workers, and whichever of them dies."""

from __future__ import annotations

import functools
import json
import multiprocessing
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json

import feeler
from feeler import batches, spreading
from feeler.plan import crew
from feeler.spreading import Interrupted, WorkerLost, spread

SPAWN = multiprocessing.get_context("spawn")


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(feeler.sample("engine", 20_000))


@pytest.fixture(scope="module")
def file(scene: feeler.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("spread") / "engine.feeler"
    scene.save(path)
    return path


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    with ProcessPoolExecutor(2, mp_context=SPAWN) as pool:
        yield pool


@pytest.fixture(scope="module")
def dask() -> Iterator[Any]:
    """A cluster of two workers, which are processes."""
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with (
            distributed.LocalCluster(
                n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs="CRITICAL"
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client


def doubled(scene: feeler.Scene | None, shared: tuple[float, Path | None], task: int) -> tuple[float, int]:
    """A task that kills its process once, if there is a folder to note that in."""
    factor, folder = shared
    if folder is not None and task == 7:
        try:
            (folder / "died").touch(exist_ok=False)
        except FileExistsError:
            pass
        else:
            os._exit(1)
    time.sleep(0.01)
    return factor * task, -1 if scene is None else scene.mockup.part_count


def kills_always(_scene: None, _shared: None, _task: int) -> None:
    os._exit(1)


def fails(_scene: None, _shared: None, task: int) -> int:
    if task == 3:
        raise ZeroDivisionError("task 3")
    return task


def fails_in_words(_scene: None, _shared: None, task: int) -> None:
    raise (feeler.LimitError, feeler.MissingFileError, feeler.WriteError)[task]("said by the worker")


def process_of(scene: feeler.Scene, _shared: None, _task: int) -> tuple[int, int, int]:
    time.sleep(0.02)
    return os.getpid(), id(scene), len(spreading._questions)


@pytest.mark.parametrize("where", ["threads", "processes", "dask", "loky"])
def test_rows_come_in_the_order_of_the_tasks(where: str, file: Path, request: pytest.FixtureRequest) -> None:
    scene = feeler.open_scene(file)
    executor = _executor(where, request)
    heard: list[int] = []
    found = spread(doubled, scene, (2.0, None), range(20), executor, lambda done, _: heard.append(done))
    assert found == [(2.0 * i, scene.mockup.part_count) for i in range(20)]
    assert heard == list(range(1, 21))


def _executor(where: str, request: pytest.FixtureRequest) -> Any:
    if where == "threads":
        return ThreadPoolExecutor(3)
    if where == "loky":
        return pytest.importorskip("loky").get_reusable_executor(max_workers=2)
    return request.getfixturevalue("dask").get_executor() if where == "dask" else request.getfixturevalue(where)


@pytest.mark.parametrize("where", ["processes", "dask", "loky"])
def test_a_worker_that_dies_is_made_up_for(
    where: str, file: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    scene = feeler.open_scene(file)
    executor = _executor(where, request) if where != "processes" else ProcessPoolExecutor(2, mp_context=SPAWN)
    told: list[str] = []
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        found = spread(doubled, scene, (3.0, tmp_path), range(30), executor, lambda _, stage: told.append(stage))
    assert found == [(3.0 * i, scene.mockup.part_count) for i in range(30)]
    assert (tmp_path / "died").exists()
    if where != "dask":  # which does lost tasks again itself
        assert [each.category for each in warned if each.category is WorkerLost] == [WorkerLost]
        assert any(stage.startswith("a worker died: ") for stage in told)
    executor.shutdown()


def test_workers_that_always_die_are_an_error() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", WorkerLost)
        with pytest.raises(feeler.FeelerError, match="workers died 4 times, and 2 of 2 tasks are not done"):
            spread(kills_always, None, None, range(2), ProcessPoolExecutor(1, mp_context=SPAWN))


def test_tasks_that_are_cancelled_again_and_again_are_an_error() -> None:
    class Cancels(Executor):
        def submit(self, *_: Any, **__: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.cancel()
            return future

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", WorkerLost)
        with pytest.raises(feeler.FeelerError, match="tasks were cancelled 4 times, and 2 of 2 are not done"):
            spread(kills_always, None, None, range(2), Cancels())


def test_an_error_of_a_task_is_raised(processes: Executor) -> None:
    for executor in (processes, ThreadPoolExecutor(2)):
        with pytest.raises(ZeroDivisionError, match="task 3"):
            spread(fails, None, None, range(1000), executor)
    assert spread(fails, None, None, range(3), processes) == [0, 1, 2]


@pytest.mark.parametrize("where", ["processes", "dask", "loky"])
def test_errors_of_feeler_come_back_from_workers(where: str, request: pytest.FixtureRequest) -> None:
    for task, kind in enumerate((feeler.LimitError, feeler.MissingFileError, feeler.WriteError)):
        with pytest.raises(kind, match="said by the worker"):
            spread(fails_in_words, None, None, [task], _executor(where, request))


def test_a_process_opens_the_scene_once(scene: feeler.Scene, processes: Executor) -> None:
    rows = spread(process_of, scene, None, range(40), processes)
    assert len(rows) == 40 and os.getpid() not in {pid for pid, *_ in rows}
    assert len(set(rows)) == len({pid for pid, *_ in rows}) <= 2, "one scene a process"
    for _ in range(spreading.KEPT_IN_A_PROCESS + 1):
        rows = spread(process_of, scene.without([1]), None, range(10), processes)
    assert all(kept <= spreading.KEPT_IN_A_PROCESS for *_, kept in rows)


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_an_executor_that_is_shut_down_meanwhile_is_told(kind: Any) -> None:
    pool = kind(1) if kind is ThreadPoolExecutor else kind(1, mp_context=SPAWN)

    def end(done: int, _stage: str) -> None:
        if done == 2:
            pool.shutdown(wait=False, cancel_futures=True)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", WorkerLost)
        with pytest.raises(feeler.FeelerError, match=r"shut down|takes no more tasks"):
            spread(doubled, None, (1.0, None), range(100), pool, end)
        with pytest.raises(feeler.FeelerError, match="takes no more tasks"):
            spread(doubled, None, (1.0, None), range(3), pool)


def test_an_executor_that_answers_otherwise_is_told() -> None:
    class Forgetful(ThreadPoolExecutor):
        def submit(self, *_: Any, **__: Any) -> Any:
            return super().submit(lambda: None)

    with Forgetful(1) as pool, pytest.raises(feeler.OptionError, match="answered a task with a NoneType"):
        spread(doubled, None, (1.0, None), range(3), pool)


def test_ctrl_c_gives_what_is_done() -> None:
    def stop(done: int, _stage: str) -> None:
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        spread(doubled, None, (1.0, None), range(1000), ThreadPoolExecutor(1), stop)
    assert caught.value.results == {i: (float(i), -1) for i in range(5)}


def test_a_scene_without_a_file_is_saved_for_the_workers(
    scene: feeler.Scene, processes: Executor, tmp_path: Path
) -> None:
    with scene.without([2])._in_a_file() as saved:
        path = Path(saved.mockup._saved.path)  # type: ignore[union-attr]
        assert path.exists() and len(pickle.dumps(saved)) < 2000 and not saved.part_mask[2]
    assert not path.parent.exists()
    assert spread(doubled, scene, (1.0, None), [4], processes) == [(4.0, scene.mockup.part_count)]


def test_things_that_take_no_tasks_are_refused(scene: feeler.Scene) -> None:
    tool = feeler.sample_tool("wrench")
    poses = np.tile(np.eye(4), (batches.CHUNK + 1, 1, 1))
    for bad in (3, "processes", object(), ProcessPoolExecutor):
        with pytest.raises(feeler.OptionError, match="executor"):
            feeler.removals(scene, [[1]], executor=bad)  # type: ignore[arg-type]
        with pytest.raises(feeler.OptionError, match="executor"):
            scene.collide_batch(tool, poses, executor=bad)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["collide_batch", "distance_batch", "clearance_batch"])
def test_batches_are_joined_in_order(
    name: str, scene: feeler.Scene, file: Path, processes: Executor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batches, "CHUNK", 7)
    tool = feeler.sample_tool("wrench")
    poses = np.concatenate([feeler.sample_poses(scene, tool, kind, 20) for kind in ("nominal", "near")])
    far = poses.copy()
    far[:, 0, 3] += 100.0
    poses = np.concatenate([poses, far])
    options: dict[str, Any] = {"within": 0.02} if name != "collide_batch" else {}
    ignore = [("*", "*disk*")]
    whole = getattr(scene, name)(tool, poses, ignore=ignore, **options)
    for executor in (processes, ThreadPoolExecutor(2)):
        cut = getattr(scene, name)(tool, poses, ignore=ignore, executor=executor, **options)
        assert len(cut) == len(whole) == len(poses) and type(cut) is type(whole)
        for ours, theirs in zip(cut.__reduce__()[1][3], whole.__reduce__()[1][3], strict=True):
            assert np.array_equal(ours, theirs) and ours.dtype == theirs.dtype
    bad = poses.copy()
    bad[23] *= 2.0
    with pytest.raises(feeler.PoseError, match="23"):
        getattr(scene, name)(tool, bad, executor=processes, **options)
    tight = feeler.open_scene(file, memory_limit=2000)
    if name != "distance_batch":
        with pytest.raises(feeler.LimitError):
            getattr(tight, name)(tool, poses, executor=processes, **({"within": 0.5} if options else {}))


def _rows(found: feeler.Removals) -> list[Any]:
    return [
        (row.parts, row.paths, row.removal.is_found, row.removal.poses.tolist(), row.removal.certificate.casts)
        for row in found
    ]


def test_removals_do_not_depend_on_the_workers(processes: Executor, dask: Any) -> None:
    scene = feeler.Scene(_shelf())
    entries = [[0], ["shelf/box_1"], [2, 3], "shelf/box_4"]
    found = feeler.removals(scene, entries)
    assert found.is_found.all() and not found.is_out_of_time.any() and not found.is_partial
    assert found[2].parts == (2, 3) and found[2].paths == ("shelf/box_2", "shelf/box_3")
    alone = feeler.removal(scene, [0])
    assert np.array_equal(found[0].removal.poses, alone.poses)
    for executor in (processes, dask.get_executor(), ThreadPoolExecutor(2)):
        assert _rows(feeler.removals(scene, entries, executor=executor)) == _rows(found)
    everything = feeler.removals(scene, threads=1)
    assert [row.parts for row in everything] == [(i,) for i in range(scene.mockup.part_count)]


def test_rounds_end_a_search_alike_everywhere(processes: Executor) -> None:
    """A search without an end: parts of the gearbox, with all others in place."""
    scene = feeler.Scene(feeler.sample("gearbox", 40_000))
    entries = [[3], [40], [81]]
    found = feeler.removals(scene, entries, seconds=600.0, rounds=2)
    assert any(row.removal.is_out_of_rounds for row in found) and not found.is_out_of_time.any()
    assert _rows(feeler.removals(scene, entries, seconds=600.0, rounds=2, threads=1)) == _rows(found)
    assert _rows(feeler.removals(scene, entries, seconds=600.0, rounds=2, executor=processes)) == _rows(found)
    casts = [sum(row.removal.certificate.casts for row in found)]
    casts.append(sum(row.removal.certificate.casts for row in feeler.removals(scene, entries, rounds=1)))
    assert casts[0] > casts[1]
    for bad in (-1, 1.5, "2", 2**40):
        with pytest.raises(feeler.OptionError, match="rounds"):
            feeler.removals(scene, entries, rounds=bad)  # type: ignore[arg-type]


def _shelf() -> feeler.Mockup:
    """Six boxes beside each other, a little apart."""
    box = feeler.sample_tool("square")
    count = 6
    size = box.bounds[1] - box.bounds[0]
    vertices = np.concatenate([box.vertices + np.array([1.1 * i * size[0], 0.0, 0.0]) for i in range(count)])
    faces = np.concatenate([box.faces + i * len(box.vertices) for i in range(count)])
    paths = [f"shelf/box_{i}" for i in range(count)]
    return feeler.Mockup(vertices, faces, np.repeat(np.arange(count), len(box.faces)), part_paths=paths)


@pytest.mark.skipif(sys.platform != "linux", reason="the MPI of the tests is for Linux")
def test_mpi_gives_the_same_rows(tmp_path: Path) -> None:
    """Three processes: one runs the script, the others work for it."""
    pytest.importorskip("mpi4py")
    mpiexec = Path(sys.executable).with_name("mpiexec")
    if not mpiexec.exists():
        pytest.skip("no mpiexec beside this Python: pip install mpich")
    script = tmp_path / "script.py"
    script.write_text(MPI_SCRIPT)
    # Processes of one machine alone, whatever its network.
    command = [str(mpiexec), "-localhost", "127.0.0.1", "-n", "3", sys.executable, "-m", "mpi4py.futures", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.split() == ["2", "same", "same", "same"]


MPI_SCRIPT = """
import feeler
from mpi4py.futures import MPIPoolExecutor

def rows(found):
    return [(row.parts, row.removal.poses.tolist(), row.removal.certificate) for row in found]

if __name__ == "__main__":
    scene = feeler.Scene(feeler.sample("gearbox", 40_000))
    scene.save("gearbox.feeler")
    bolts = ["gearbox/housing/split_bolts/bolt_2", "gearbox/housing/split_bolts/bolt_3"]
    order = {"parts": "gearbox/bracket/left_mount/retainer", "keep": "gearbox/housing", "rounds": 1, "seconds": 600.0}
    with MPIPoolExecutor() as workers:
        workers.bootup()
        print(workers.num_workers)
        alone = rows(feeler.removals(scene, bolts, rounds=1))
        for each in (scene, feeler.open_scene("gearbox.feeler")):
            print("same" if rows(feeler.removals(each, bolts, rounds=1, executor=workers)) == alone else "different")
        alone, spread = (rows(feeler.removal_order(scene, executor=each, **order)) for each in (None, workers))
        print("same" if spread == alone else "different")
"""


def test_removals_refuse_what_cannot_move(scene: feeler.Scene) -> None:
    for bad, said in (("a*", "give a list"), ([], "at least one"), ([["nothing"]], "nothing"), (3, "give a list")):
        with pytest.raises(feeler.OptionError, match=said):
            feeler.removals(scene, bad)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="out already"):
        feeler.removals(scene.without([3]), [[3]])
    mask = np.arange(scene.mockup.part_count) < 2
    for given, said in ((mask, "parts is a mask: give np.flatnonzero"), ({"a": [1]}, "parts is a dict")):
        with pytest.raises(feeler.OptionError, match=said):
            feeler.removals(scene, given)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="seconds"):
        feeler.removals(scene, [[3]], seconds=0.0)


def _steps(order: feeler.RemovalOrder) -> list[Any]:
    return [(step.parts, *_facts(step.removal)) for step in order]


def _facts(one: feeler.Removal) -> tuple[Any, ...]:
    blockers = [(each.part, each.count, each.reach, each.pose.tolist()) for each in one.blocked_by]
    return one.is_found, one.poses.tolist(), one.path_length, one.certificate, blockers


@pytest.fixture(scope="module")
def gearbox() -> feeler.Scene:
    return feeler.Scene(feeler.sample("gearbox", 40_000))


# Two that other parts leave before, and one that tries what is stuck, and gives up.
ORDERS = {
    "bracket/left_mount/retainer": 2,
    "housing/split_bolts/bolt_8": 2,
    "lines/oil_pipe/post": 0,
}


@pytest.mark.parametrize("where", ["threads", "processes", "dask"])
def test_orders_do_not_depend_on_the_workers(
    where: str, gearbox: feeler.Scene, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    executor = _executor(where, request)
    handed: list[int] = []
    spread_all = crew.spread

    def counted(*args: Any, **kwargs: Any) -> Any:
        handed.append(len(args[3]))
        return spread_all(*args, **kwargs)

    monkeypatch.setattr(crew, "spread", counted)
    for part, steps in ORDERS.items():
        options: dict[str, Any] = {"keep": "gearbox/housing", "seconds": 600.0, "rounds": 1}
        alone = feeler.removal_order(gearbox, f"gearbox/{part}", threads=1, **options)
        assert len(alone) == max(steps, 1) and alone.is_found == bool(steps) and not alone.is_out_of_time
        assert not handed
        told: list[tuple[float, str]] = []
        progress = functools.partial(lambda told, *heard: told.append(heard), told)
        found = feeler.removal_order(gearbox, f"gearbox/{part}", executor=executor, progress=progress, **options)
        assert _steps(found) == _steps(alone) and found.is_found == alone.is_found and not found.is_out_of_time
        assert handed and min(handed) > 1, "nothing was handed to the workers"
        assert told == sorted(told, key=lambda heard: heard[0]) and any("at once: 1 of" in stage for _, stage in told)
        handed.clear()


def test_an_order_by_rounds_ends_without_a_time_limit(gearbox: feeler.Scene) -> None:
    part = "gearbox/housing/split_bolts/bolt_washer_5"
    options: dict[str, Any] = {"keep": "gearbox/housing", "seconds": float("inf")}
    casts = [
        feeler.removal_order(gearbox, part, rounds=rounds, **options).steps[0].removal.certificate.casts
        for rounds in (0, 1, 4)
    ]
    assert casts[0] < casts[1] < casts[2]
    cut = feeler.removal_order(gearbox, part, keep="gearbox/housing", seconds=0.3, rounds=2**20)
    assert not cut.is_found and cut.is_out_of_time
    for bad in (-1, 1.5, "2", 2**40):
        with pytest.raises(feeler.OptionError, match="rounds"):
            feeler.removal_order(gearbox, part, rounds=bad)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="executor"):
        feeler.removal_order(gearbox, part, executor="processes")  # type: ignore[arg-type]


def dies_once(note: Path, scene: feeler.Scene, shared: Any, task: Any) -> Any:
    """The task of an order, which kills its process once."""
    try:
        note.touch(exist_ok=False)
    except FileExistsError:
        return crew.done(scene, shared, task)
    os._exit(1)


@pytest.mark.parametrize("where", ["processes", "dask"])
def test_an_order_survives_the_death_of_a_worker(
    where: str, gearbox: feeler.Scene, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = "gearbox/lines/oil_pipe/post"
    options: dict[str, Any] = {"keep": "gearbox/housing", "seconds": 600.0, "rounds": 1}
    alone = feeler.removal_order(gearbox, part, **options)
    spread_all, dying = crew.spread, functools.partial(dies_once, tmp_path / "died")
    monkeypatch.setattr(crew, "spread", lambda _, *args, **kwargs: spread_all(dying, *args, **kwargs))
    executor = _executor(where, request) if where == "dask" else ProcessPoolExecutor(2, mp_context=SPAWN)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        found = feeler.removal_order(gearbox, part, executor=executor, **options)
    assert _steps(found) == _steps(alone) and (tmp_path / "died").exists()
    losses = [each for each in warned if each.category is WorkerLost]
    assert len(losses) == (where != "dask"), "told once, however many spreads follow; Dask does lost tasks again itself"


def test_ctrl_c_ends_an_order_with_the_best_attempt(gearbox: feeler.Scene) -> None:
    told: list[str] = []

    def stop(_share: float, stage: str) -> None:
        told.append(stage)
        if "attempts at once: 1 of" in stage:
            raise KeyboardInterrupt

    with pytest.raises(feeler.RemovalOrderInterrupted) as caught:
        feeler.removal_order(
            gearbox,
            "gearbox/gear_train/starter_shaft/front_bearing/ball_5",
            keep="gearbox/housing",
            rounds=1,
            executor=ThreadPoolExecutor(2),
            progress=stop,
        )
    order = caught.value.order
    assert not order.is_found and [len(step.parts) for step in order] == [1]
    assert order.steps[0].removal.blocked_by


def test_tasks_after_the_last_one_of_use_are_left_out() -> None:
    done: list[int] = []
    for executor in (None, ThreadPoolExecutor(1), ThreadPoolExecutor(3)):
        found = spread(doubled, None, (1.0, None), range(300), executor, is_last=lambda row: row[0] >= 4.0)
        assert found == [(float(i), -1) for i in range(5)]
        done.clear()
        found = spread(
            *(doubled, None, (1.0, None), range(300), executor, lambda i, _: done.append(i)),
            goes_on=lambda: len(done) < 6,
        )
        assert found == [(float(i), -1) for i in range(len(found))] and 4 <= len(found) < 20


def test_access_does_not_depend_on_the_workers(processes: Executor) -> None:
    mockup = feeler.sample("gearbox", 40_000)
    scene = feeler.Scene(mockup)
    fasteners = feeler.find_fasteners(mockup)[:6]
    tool = feeler.sample_tool("wrench")

    def rows(**options: Any) -> list[Any]:
        told: list[float] = []
        found = feeler.access(
            scene, tool, fasteners, 30.0, grip="y", progress=lambda share, _: told.append(share), **options
        )
        assert told[-1] == 1.0 and len(told) == len(fasteners)
        return [(row.target, row.swing_deg, row.pose.tolist(), row.way.tolist(), row.blockers) for row in found]

    assert rows() == rows(threads=1) == rows(executor=processes) == rows(executor=ThreadPoolExecutor(2))


def test_variants_are_checked_in_order(processes: Executor, tmp_path: Path) -> None:
    mockups = [feeler.sample("differential", 10_000, seed=seed) for seed in range(3)]
    feeler.Scene(mockups[1]).save(tmp_path / "b.feeler")
    variants = [mockups[0], tmp_path / "b.feeler", mockups[2]]
    expected = [feeler.clash(mockup) for mockup in mockups]
    for options in ({}, {"executor": processes}):
        found = feeler.clash_variants(variants, **options)
        for ours, theirs in zip(found, expected, strict=True):
            assert list(ours.ids) == list(theirs.ids) and ours.depths.tolist() == theirs.depths.tolist()
    in_dict = {"a": mockups[0]}
    for bad, said in (("a.glb", "a list"), ([], "at least one"), ([3], r"variants\[0\]"), (in_dict, "variants.values")):
        with pytest.raises(feeler.OptionError, match=said):
            feeler.clash_variants(bad)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="clearance"):
        feeler.clash_variants(variants, clearance=-1.0)
    with pytest.raises(feeler.OptionError, match="rules"):
        feeler.clash_variants(variants, rules=3, executor=processes)  # type: ignore[arg-type]


def test_a_variant_that_fails_does_not_lose_the_others(processes: Executor, tmp_path: Path) -> None:
    mockup = feeler.sample("differential", 10_000)
    (tmp_path / "bad.stl").write_text("solid nothing")
    variants = [tmp_path / "none.glb", mockup, tmp_path / "bad.stl", mockup]
    for executor in (None, processes, ThreadPoolExecutor(1)):
        with pytest.raises(
            feeler.VariantsError, match=r"2 of 4 variants cannot be checked: variants\[0\]: .*none"
        ) as told:
            feeler.clash_variants(variants, executor=executor)
        assert [*told.value.found] == [1, 3] and len(told.value.found[1]) == len(told.value.found[3]) > 0
        assert isinstance(told.value.errors[0], feeler.MissingFileError) and [*told.value.errors] == [0, 2]


def test_paths_of_variants_are_those_of_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The worker stays in the folder where it began, in which other files have the same names."""
    box = feeler.sample_tool("square")
    size = float(np.ptp(box.vertices[:, 0]))
    for name, shift in (("one", 0.5), ("two", 5.0)):
        (tmp_path / name).mkdir()
        moved = box.vertices + np.array([shift * size, 0.0, 0.0])
        faces, parts = np.concatenate([box.faces, box.faces + len(moved)]), np.repeat([0, 1], len(box.faces))
        mockup = feeler.Mockup(np.concatenate([box.vertices, moved]), faces, parts, ["a", "b"])
        feeler.Scene(mockup).save(tmp_path / name / "v.feeler")
        feeler.io.write_glb(tmp_path / name / "v.glb", mockup)
        hidden = f'[[exclude]]\nname = "all"\na = "{"*" if name == "two" else "nothing*"}"\nb = "*"\n'
        (tmp_path / name / "r.toml").write_text(hidden if name == "two" else "")
    monkeypatch.chdir(tmp_path / "two")
    with ProcessPoolExecutor(1, mp_context=SPAWN) as pool:
        pool.submit(os.getcwd).result()
        monkeypatch.chdir(tmp_path / "one")
        for variants in (["v.feeler", "v.glb"], [Path("v.feeler")]):
            here = feeler.clash_variants(variants, rules="r.toml")
            there = feeler.clash_variants(variants, rules="r.toml", executor=pool)
            assert [each.verdicts.tolist() for each in here] == [each.verdicts.tolist() for each in there]
            assert all(len(each) == 1 for each in there)


@pytest.mark.parametrize("defect", ["no triangle", "no area", "not finite"])
def test_a_part_without_anything_to_query_has_a_row_that_says_so(
    defect: str, processes: Executor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shelf = _shelf()
    bad = {"no triangle": [], "no area": [[0, 0, 0]], "not finite": [[0, 1, len(shelf.vertices)]]}[defect]
    faces = np.concatenate([shelf.faces, np.array(bad, np.uint32).reshape(-1, 3)])
    parts = np.concatenate([shelf.part_of_face, np.full(len(bad), shelf.part_count)])
    vertices = np.concatenate([shelf.vertices, [[np.nan] * 3]])
    mockup = feeler.Mockup(vertices, faces, parts, part_paths=[*shelf.part_paths, "shelf/bad"])
    scene = feeler.Scene(mockup)
    for executor in (None, processes):
        found = feeler.removals(scene, executor=executor)
        assert found.is_found.tolist() == [True] * 6 + [False] and not found.is_out_of_time.any()
        assert [bool(row.error) for row in found] == [False] * 6 + [True]
        assert found[6].error.startswith("shelf/bad: ")
    for call in (feeler.removal, feeler.removal_order, feeler.insertion):
        with pytest.raises(feeler.MeshError, match=r"^shelf/bad: ") as told:
            call(scene, "shelf/bad")
        assert "tool has" not in str(told.value)
    assert feeler.removal_order(scene, "shelf/box_1", rounds=1).is_found
    monkeypatch.chdir(tmp_path)
    scene.save("s.feeler")
    for words in ([], ["--workers", "1"]):
        asked = ["remove", "s.feeler", "--part", "*", "--each", "--rounds", "1", *words]
        document = run_json(*asked, "--csv", "rows.csv", code=1)
        assert [part["error"] for part in document["parts"]] == [None] * 6 + [found[6].error]
        assert (
            (tmp_path / "rows.csv")
            .read_text(encoding="utf-8-sig")
            .splitlines()[-1]
            .rstrip('"')
            .endswith(found[6].error)
        )
        assert "6 of 7 parts come out" in run(*asked, code=1).stdout
    asked = ["remove", "s.feeler", "--part", "shelf/bad", "--seconds", "1"]
    told_last = run(*asked, code=2).stderr.splitlines()[-1]
    assert "shelf/bad: no" in told_last.replace("there are ", "")


@pytest.mark.parametrize("address", ["nonsense", "127.0.0.1", "http://127.0.0.1:80", "tcp://", "tcp://host", "a b:1"])
def test_an_address_that_is_none_is_refused_at_once(address: str) -> None:
    asked = ["remove", "nothing.stl", "--part", "*", "--each"]
    assert "--dask" in error_of(*asked, "--dask", address) and "such as tcp://" in error_of(*asked, "--dask", address)


def test_a_server_that_is_no_scheduler_is_told(tmp_path: Path) -> None:
    """It answers with something else, or not at all."""
    pytest.importorskip("distributed")
    write_stl = feeler.io.write_stl
    write_stl(tmp_path / "s.stl", _shelf())
    code = "from feeler.cli import main; main()"
    asked = [sys.executable, "-c", code, "remove", str(tmp_path / "s.stl"), "--part", "*", "--each", "--dask"]
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=_answer_as_a_page, args=(server,), daemon=True).start()
        done = subprocess.run(
            [*asked, f"127.0.0.1:{server.getsockname()[1]}"], capture_output=True, text=True, check=False, timeout=60
        )
    assert done.returncode == 2 and "no scheduler answers there" in done.stderr, done.stderr
    assert done.stderr.startswith("feeler: --dask") and done.stderr.count("\n") == 1


def _answer_as_a_page(server: socket.socket) -> None:
    while True:
        try:
            connection, _ = server.accept()
        except OSError:
            return
        with connection:
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n")


def test_commands_share_their_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dask: Any) -> None:
    monkeypatch.chdir(tmp_path)
    run("index", "sample:gearbox:40000", "-o", "gearbox.feeler")
    each = ["remove", "gearbox.feeler", "--part", "*retainer*", "--each", "--rounds", "1", "--seconds", "600"]

    def steps(*words: str, code: int = 1) -> Any:
        document = run_json(*each, *words, code=code)
        for part in document["parts"]:
            for step in part["steps"]:
                step.pop("seconds")
        return document["parts"]

    address = dask.scheduler.address
    assert steps() == steps("--workers", "2") == steps("--dask", address) and len(steps()) > 1
    reach = ["access", "gearbox.feeler", "--tool", "sample:wrench", "--grip", "y", "--targets", "*covers*"]
    alone = run_json(*reach, code=1)["rows"]
    assert run_json(*reach, "--workers", "2", code=1)["rows"] == alone
    assert "exclude each other" in error_of(*each, "--workers", "2", "--dask", address)
    assert "--workers is for --each or --order" in error_of(
        "remove", "gearbox.feeler", "--part", "*retainer*", "--workers", "2"
    )
    assert "--rounds is for" in error_of("remove", "gearbox.feeler", "--part", "*", "--insert", "--rounds", "2")
    wanted = ["--part", "gearbox/bracket/left_mount/retainer", "--keep", "gearbox/housing", "--rounds", "2"]
    each = ["remove", "gearbox.feeler", "--order", *wanted, "--seconds", "600"]
    assert steps(code=0) == steps("--workers", "2", code=0) == steps("--dask", address, code=0)
    assert [len(part["steps"]) for part in steps(code=0)] == [2]
    assert "no scheduler answers" in error_of(*reach, "--dask", "tcp://127.0.0.1:1")


def test_ctrl_c_ends_variants_with_those_that_are_done() -> None:
    mockups = [feeler.sample("differential", 10_000, seed=seed) for seed in range(3)]

    def stop(share: float, _stage: str) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    for executor in (None, ThreadPoolExecutor(1)):
        with pytest.raises(feeler.VariantsInterrupted) as caught:
            feeler.clash_variants(mockups, executor=executor, progress=stop)
        assert {0, 1} == set(caught.value.found) and len(caught.value.found[1]) > 0


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C of POSIX")
def test_ctrl_c_ends_removals_with_the_rows_that_are_done() -> None:
    code = """
import signal
import feeler
from feeler.plan.removals import RemovalsInterrupted
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = feeler.Scene(feeler.sample("gearbox", 40_000))
print("begun", flush=True)
try:
    feeler.removals(scene, threads=2, seconds=60.0, progress=lambda share, stage: print(stage, flush=True))
except RemovalsInterrupted as interrupted:
    print(len(interrupted.removals), interrupted.removals.is_partial, flush=True)
"""
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None and run.stdout.readline() == "begun\n"
    time.sleep(0.5)
    run.send_signal(signal.SIGINT)
    said = run.communicate(timeout=60)[0].splitlines()
    assert said[-1].endswith("True"), said
    assert run.returncode == 0


def _children(parent: int) -> list[int]:
    """Processes with this parent that still run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text(encoding="ascii").rpartition(")")[2].split()
        except OSError:
            continue  # it ended meanwhile
        if int(words[1]) == parent and words[0] != "Z":
            found.append(int(stat.parent.name))
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_workers_of_a_killed_command_end() -> None:
    code = "from feeler.cli import main; main()"
    asked = ["remove", "sample:gearbox:40000", "--part", "*", "--each", "--rounds", "9", "--workers", "2"]
    run = subprocess.Popen([sys.executable, "-c", code, *asked], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    begun, workers = time.monotonic(), []
    # The workers, and the process that watches over shared names.
    while len(workers) < 3 and time.monotonic() - begun < 60:
        time.sleep(0.1)
        workers = _children(run.pid)
    assert len(workers) >= 3
    time.sleep(2.0)  # until they work
    run.kill()
    run.wait()
    # A pipe ends when the last process that holds it does.
    run.communicate(timeout=60)
    until = time.monotonic() + 30
    while any(map(_runs, workers)) and time.monotonic() < until:
        time.sleep(0.1)
    assert not [worker for worker in workers if _runs(worker)]


def _runs(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C of POSIX")
def test_ctrl_c_of_an_order_answers_with_what_is_known() -> None:
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import os, feeler\n"
        "from feeler.plan import order\n"
        "old = order._Search.order\n"
        "def stopped(search):\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    return old(search)\n"
        "order._Search.order = stopped\n"
        "from feeler.cli import main; main()"
    )
    asked = ["remove", "sample:gearbox:40000", "--part", "*housing*", "--order", "--json"]
    done = subprocess.run([sys.executable, "-c", code, *asked], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["parts"][0]["found"] is False


def test_an_executor_that_answers_with_something_else_is_refused() -> None:
    class Lying(ThreadPoolExecutor):
        def submit(self, *_args: object, **_kwargs: object) -> Any:
            return 7

    with Lying(1) as executor, pytest.raises(feeler.OptionError, match="submit answered with a int"):
        feeler.clash_variants([feeler.sample("differential", 10_000)] * 2, executor=executor)
