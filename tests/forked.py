"""What tests/test_fork.py runs as a program of its own: `python forked.py CASE...`.

Threads keep the pools busy, the process forks again and again meanwhile, and each child is asked what the parent was
asked. A child that does not end is the failure looked for: it is killed after GUARD_S. Each case that passed prints
`passed CASE`; the program ends with 1 where one did not.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import feeler
from feeler import _core, calibrate, haptics
from feeler.io import body_of, write_stl
from feeler.study.timing import mean_work

GUARD_S = 60.0  # far longer than any child takes: a guard against waiting for ever, no measurement
FORKS = 4

MOCKUP = feeler.sample("differential", 20_000)
TOOL = feeler.sample_tool("wrench")
TOOL_AS_MOCKUP = feeler.Mockup(TOOL.vertices, TOOL.faces)
SCENE = feeler.Scene(MOCKUP)
OWN_POOL = feeler.Scene(MOCKUP, threads=2)
POSES = feeler.sample_path(SCENE, TOOL, 40)
HOLDER = feeler.Tool.of_parts(MOCKUP, range(5))  # parts that hold others of the mock-up
HIT = POSES[int(np.argmax(np.diff(SCENE.collide_batch(TOOL, POSES).offsets.astype(np.int64))))]
RAYS = (POSES[:, :3, 3], MOCKUP.bounds.mean(axis=0) - POSES[:, :3, 3])
HIT_PART = int(SCENE.collide(TOOL, HIT).parts[0])


def arrays(result: Any, *names: str) -> list[bytes]:
    return [np.asarray(getattr(result, name)).tobytes() for name in names]


def built(storage: str, **options: Any) -> list[bytes]:
    scene = feeler.Scene(feeler.Mockup(MOCKUP.vertices, MOCKUP.faces), storage=storage, **options)
    return arrays(scene.collide_batch(TOOL, POSES), "offsets", "pairs")


def path(result: feeler.PathCheck) -> list[bytes]:
    return [*arrays(result, "points", "fractions"), *arrays(result.containment, "containing_pairs", "contained_pairs")]


def contacts(result: feeler.Contacts) -> list[bytes]:
    return arrays(result, "points", "gaps", "ids", "footing")


def loaded() -> list[bytes]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mockup.stl"
        write_stl(path, body_of(MOCKUP))
        return arrays(feeler.load_mockup(path, "m"), "vertices", "faces")


def studied() -> Any:
    """What studies are made of: scenes of many sizes, the work in them counted and predicted."""
    scenes = [feeler.Scene(MOCKUP, size, "dense") for size in (0.008, 0.016)]
    predictors = [_core.PiecePredictor(MOCKUP, TOOL), _core.Predictor(MOCKUP, TOOL, "dense", 0.0)]
    return [mean_work(scene, TOOL, POSES[:4]) for scene in scenes], [each.work(0.004) for each in predictors]


def felt() -> list[bytes]:
    """A session of a new mock-up, and a grip in it."""
    session = haptics.Session(*fresh())
    session.start(POSES[0])
    found = [session.step(pose).force.tobytes() for pose in POSES]
    session.start(POSES[0])
    session.grip(HIT_PART)
    return [*found, session.step(POSES[0]).world_from_proxy.tobytes()]


def ran() -> tuple[bool, int | None]:
    """A run with threads of its own, and a grip in it."""
    session = haptics.Session(*fresh())
    session.start(POSES[0])
    session.run(haptics.devices.Mouse(POSES[0]), realtime=False)
    session.grip(HIT_PART)
    while session.view().number == 0:
        time.sleep(0.001)
    view, gripped = session.view(), session.gripped
    session.stop()
    return bool(np.allclose(view.world_from_proxy, POSES[0], atol=1e-9)), gripped


CASES: dict[str, Callable[[], Any]] = {
    "mockup": lambda: arrays(feeler.Mockup(MOCKUP.vertices, MOCKUP.faces), "bounds"),
    "tool": lambda: arrays(feeler.Tool(TOOL.vertices, TOOL.faces), "bounds"),
    "blocks": lambda: built("blocks"),
    "dense": lambda: built("dense", voxel_size=0.008),
    "hashed": lambda: built("hashed", hashing=0.5, voxel_size=0.008),
    "own pool": lambda: built("blocks", threads=2),
    "calibrated": lambda: built("dense", tool=TOOL),
    "sample": lambda: arrays(feeler.sample("turbine", 10_000), "vertices", "faces"),
    "collide": lambda: arrays(SCENE.collide(TOOL, HIT), "pairs"),
    "is_colliding": lambda: SCENE.is_colliding(TOOL, HIT),
    "collide_batch": lambda: arrays(SCENE.collide_batch(TOOL, POSES), "pairs"),
    "collide_batch, own pool": lambda: arrays(OWN_POOL.collide_batch(TOOL, POSES), "pairs"),
    "clearance": lambda: arrays(SCENE.clearance(TOOL, HIT), "distances"),
    "clearance_batch": lambda: arrays(SCENE.clearance_batch(TOOL, POSES), "distances"),
    "distance": lambda: SCENE.distance(TOOL, POSES[0]).value,
    "distances": lambda: [d.value for d in SCENE.nearest(TOOL, POSES[0], 3)],
    "distance_batch": lambda: arrays(SCENE.distance_batch(TOOL, POSES), "values"),
    "cast": lambda: SCENE.cast(TOOL, POSES[0], HIT).fraction,
    "check_path": lambda: arrays(SCENE.check_path(TOOL, POSES), "points"),
    "check_path, own pool": lambda: arrays(OWN_POOL.check_path(TOOL, POSES), "points"),
    "check_path of a new mock-up": lambda: path(fresh()[0].check_path(fresh()[1], POSES, touching="free")),
    "is_colliding, touching free": lambda: fresh()[0].is_colliding(fresh()[1], HIT, touching="free"),
    "cast, touching free": lambda: fresh()[0].cast(fresh()[1], POSES[0], HIT, touching="free").fraction,
    "is_free": lambda: [fresh()[0].is_free(fresh()[1], pose) for pose in (POSES[0], HIT)],
    "containment": lambda: arrays(
        fresh()[0].containment(HOLDER, np.eye(4)), "containing_pairs", "contained_pairs", "unknown"
    ),
    "rays": lambda: arrays(SCENE.rays(*RAYS), "distances", "triangles"),
    "rays, own pool": lambda: arrays(OWN_POOL.rays(*RAYS), "distances", "triangles"),
    "section": lambda: arrays(SCENE.section(MOCKUP.bounds.mean(axis=0), [1, 2, 3]), "segments", "triangles"),
    "section, own pool": lambda: arrays(OWN_POOL.section(MOCKUP.bounds.mean(axis=0), [1, 2, 3]), "segments"),
    "pack": lambda: [arrays(each, "positions", "parts", "indices") for each in MOCKUP.pack().pieces],
    "pack, tool": lambda: arrays(TOOL.pack(), "order", "places"),
    "without": lambda: arrays(SCENE.without(HIT_PART).collide_batch(TOOL, POSES), "pairs"),
    "only": lambda: arrays(OWN_POOL.only(HIT_PART).collide_batch(TOOL, POSES), "pairs"),
    "ignore": lambda: arrays(SCENE.collide_batch(TOOL, POSES, ignore=[(0, HIT_PART)]), "pairs"),
    "tool of parts": lambda: arrays(SCENE.without(3).contacts(feeler.Tool.of_parts(MOCKUP, 3), np.eye(4)), "gaps"),
    "contacts": lambda: contacts(SCENE.contacts(TOOL, HIT)),
    "contacts of a new mock-up": lambda: contacts(fresh()[0].contacts(fresh()[1], HIT)),
    "penetration": lambda: arrays(SCENE.penetration(TOOL, HIT), "translation"),
    "penetration of a new mock-up": lambda: arrays(fresh()[0].penetration(fresh()[1], HIT), "translation"),
    "tracker": lambda: contacts(feeler.ContactTracker(SCENE, TOOL).contacts(HIT)),
    "optimal_voxel_size": lambda: feeler.optimal_voxel_size(MOCKUP, TOOL, "area"),
    "predictor": lambda: _core.Predictor(MOCKUP, TOOL, "dense", 0.0).optimal_size(calibrate.TYPICAL, 2**30),
    "piece predictor": lambda: _core.PiecePredictor(MOCKUP, TOOL).optimal_size(2**30),
    "haptics": felt,
    "haptics, running": ran,
    "swept": lambda: arrays(feeler.swept(fresh()[1], POSES[:3], 0.01), "vertices", "faces"),
    "swept, own pool": lambda: arrays(feeler.swept(TOOL, POSES[:3], 0.01, threads=2), "vertices", "faces"),
    "study": studied,
    "fasteners": lambda: feeler.find_fasteners(SCENE).frames.tobytes(),
    "access": lambda: arrays(feeler.access(SCENE, TOOL, POSES[:4], threads=2), "swings_deg", "is_reachable"),
    "removal": lambda: arrays(feeler.removal(SCENE, HIT_PART, seconds=0.5, threads=2), "poses"),
    "load": loaded,
}


def fresh() -> tuple[feeler.Scene, feeler.Tool]:
    """Nothing is known yet of how their triangles hang together."""
    mockup = feeler.Mockup(MOCKUP.vertices, MOCKUP.faces, MOCKUP.part_of_face, MOCKUP.part_names)
    return feeler.Scene(mockup), feeler.Tool(TOOL.vertices, TOOL.faces)


def in_child(ask: Callable[[], Any], expected: Any, threads: Busy | None = None) -> bool:
    """Whether a forked child gets the answer that is expected, and ends. threads: busy while it is forked."""
    if threads:
        threads.go_on()
    pid = os.fork()
    if pid == 0:
        try:
            os._exit(0 if ask() == expected else 2)
        finally:
            os._exit(3)
    if threads:
        threads.rest()
    until = time.monotonic() + GUARD_S
    while time.monotonic() < until:
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            if status:
                print(f"the child ended with {os.waitstatus_to_exitcode(status)}")
            return status == 0
        time.sleep(0.01)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    print("the child hangs")
    return False


class Busy:
    """Threads that use all pools, and all that one thread may wait for another for. They rest while a child answers."""

    def __init__(self) -> None:
        self._work, self._rounds, self._ended = threading.Event(), [0] * 4, False
        works = (self._batches, self._topology, self._single, self._single)
        self._threads = [threading.Thread(target=self._again, args=each, daemon=True) for each in enumerate(works)]
        for thread in self._threads:
            thread.start()

    def _again(self, number: int, work: Callable[[], None]) -> None:
        while self._work.wait() and not self._ended:
            self._rounds[number] += 1
            work()

    def _batches(self) -> None:
        SCENE.collide_batch(TOOL, POSES)
        OWN_POOL.distance_batch(TOOL, POSES)

    def _topology(self) -> None:
        scene, tool = fresh()
        scene.contacts(tool, HIT)
        scene.penetration(tool, POSES[0])

    def _single(self) -> None:
        for pose in POSES[::4]:
            SCENE.collide(TOOL, pose)
            SCENE.distance(TOOL, pose)
            SCENE.contacts(TOOL, pose)

    def go_on(self) -> None:
        """Waits until each has begun anew, and so is in the middle of something."""
        before = [*self._rounds]
        self._work.set()
        while any(now == then for now, then in zip(self._rounds, before, strict=True)):
            time.sleep(0.001)

    def rest(self) -> None:
        self._work.clear()

    def end(self) -> None:
        self._ended = True
        self._work.set()
        for thread in self._threads:
            thread.join()


def busy(case: str) -> bool:
    ask = CASES[case]
    expected = ask()
    threads = Busy()
    good = all(in_child(ask, expected, threads) for _ in range(FORKS))
    threads.end()
    return good and ask() == expected


def while_topology_is_found() -> bool:
    """Forks at many moments of a first query for contacts, and asks the child for those of the same two."""
    scene, tool = fresh()
    begin = time.monotonic()
    expected = contacts(scene.contacts(tool, HIT))
    took = time.monotonic() - begin
    for share in np.linspace(0.05, 0.95, 10):
        scene, tool = fresh()
        thread = threading.Thread(target=scene.contacts, args=(tool, HIT))
        thread.start()
        time.sleep(share * took)
        good = in_child(lambda scene=scene, tool=tool: contacts(scene.contacts(tool, HIT)), expected)
        thread.join()
        if not good:
            return False
    return True


def in_a_progress_function() -> bool:
    """Forks while the pool works for the very thread that forks."""
    answers: list[bool] = []
    expected = CASES["collide_batch"]()

    def fork_once(_share: float, _stage: str) -> None:
        if not answers:
            answers.append(in_child(CASES["collide_batch"], expected))

    SCENE.distance_batch(TOOL, np.repeat(POSES, 20, axis=0), progress=fork_once)
    return answers == [True]


def while_pools_are_made() -> bool:
    """Forks while other threads start and end pools, and threads of pools have something to tell."""
    stop = threading.Event()

    def make() -> None:
        while not stop.is_set():
            feeler.Scene(TOOL_AS_MOCKUP, threads=8, progress=lambda share, stage: None)

    expected = CASES["check_path"]()
    threads = [threading.Thread(target=make, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    good = all(in_child(CASES["check_path"], expected) for _ in range(200))
    stop.set()
    for thread in threads:
        thread.join()
    return good


def grandchild() -> bool:
    """A fork of a fork, each with pools of its own."""
    expected = CASES["check_path"]()

    def child() -> Any:
        return CASES["check_path"]() == expected and in_child(CASES["check_path"], expected)

    return in_child(child, True)


def dropped() -> bool:
    """A child that drops scenes and makes others: the pools that it inherits are not waited for."""

    def child() -> Any:
        global OWN_POOL, SCENE
        OWN_POOL = SCENE = None
        return built("blocks", threads=2) == expected

    expected = built("blocks", threads=2)
    OWN_POOL.collide_batch(TOOL, POSES)
    return in_child(child, True)


def no_global_pool() -> bool:
    """After every case, all threads but Python's are of pools that know their process."""
    for ask in CASES.values():
        ask()
    names = [path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")]
    own = [name for name in names if name.startswith("feeler-")]
    others = [name for name in names if not name.startswith("feeler-")]
    print(names)
    return len(own) >= 2 and len(others) == THREADS_BEFORE


OTHERS: dict[str, Callable[[], bool]] = {
    "while topology is found": while_topology_is_found,
    "in a progress function": in_a_progress_function,
    "while pools are made": while_pools_are_made,
    "grandchild": grandchild,
    "dropped": dropped,
    "no global pool": no_global_pool,
}
if Path("/proc/self/task").is_dir():
    THREADS_BEFORE = sum(not path.read_text().startswith("feeler-") for path in Path("/proc/self/task").glob("*/comm"))

if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        print(*CASES, sep="\n")
        sys.exit()
    all_passed = True
    for name in sys.argv[1:]:
        has_passed = OTHERS[name]() if name in OTHERS else busy(name)
        print(f"{'passed' if has_passed else 'FAILED'} {name}", flush=True)
        all_passed &= has_passed
    sys.exit(0 if all_passed else 1)
