"""Objects that travel: pickled and copied, to other processes and back, the same as before."""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import operator
import pickle
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler
from feeler import _core, haptics, travel
from feeler.errors import FeelerError, LoadError
from feeler.io.export import Motion, animated_glb
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
STAY = {
    "ClashRows",
    "World",
    "Shape",
    "Bodies",
    "GuardedMove",
    "Impact",
    "Predictor",
    "PiecePredictor",
    "MoveAnswer",
    "MovedMockup",
    "RemovalAnswer",
    "HapticsDevice",
    "HapticsRun",
    "Session",
    "SavedScene",
    "Project",
}
RUNNING: dict[str, Callable[[Any], Any]] = {
    "TickAnswer": lambda run: run.view(),
    "TraceAnswer": lambda run: run.trace(),
    "GrantedAnswer": lambda run: run.granted(),
    "StatisticsAnswer": lambda run: run.statistics(),
    "DistributionAnswer": lambda run: run.statistics().age,
    "RunEnd": lambda run: run.stop(),
}
STEPPED: dict[str, Callable[[haptics.Session], Any]] = {
    "StartAnswer": lambda session: session._begin(pose(0.2)),
    "SeatAnswer": lambda session: session._begin(pose(0.2)).seats[0],
    "StepAnswer": lambda session: (session._begin(pose(5.0)), session._advance(pose(5.0), 0.001))[1],
}
STAY |= {*RUNNING, *STEPPED}
"""What does not travel, and says so; answers of running sessions, and of stepped ones."""
BASES = {"Mockup", "Tool", "Scene", "ContactTracker", "IgnoredPairs", "Selected", "HapticsSession"}
"""Classes of the core that only their feeler.* subclasses are used of, or that make these."""
WAYS: dict[str, Callable[[Any], Any]] = {
    **{f"protocol {p}": lambda value, p=p: pickle.loads(pickle.dumps(value, p)) for p in PROTOCOLS},
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def box(lower: tuple[float, float, float], size: float) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float) * size + lower
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    return corners, np.array([*faces, [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])


def mockup() -> feeler.Mockup:
    """Three cubes, one of them without a triangle that can be queried, one triangle with an index that is not there."""
    (a, faces), (b, _) = box((0, 0, 0), 1.0), box((1.3, 0, 0), 1.0)
    bad = np.array([[0, 1, 99], [2, 2, 2]])
    return feeler.Mockup(
        np.concatenate([a, b, [[np.nan, 0, 0]]]),
        np.concatenate([faces, faces + 8, bad]),
        np.repeat([0, 1, 2], [12, 12, 2]),
        ["left", "right", "odd"],
        part_paths=["pair/left", "pair/right", "odd"],
    )


def pose(x: float, y: float = 0.3, z: float = 0.95) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


POSES = np.array([pose(0.2), pose(1.1), pose(5.0), pose(1.5)])


def tracks(mock: feeler.Mockup) -> feeler.Tracks:
    """A cube that moves."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.glb"
        path.write_bytes(animated_glb(mock, [Motion(0, np.arange(2.0), np.array([pose(0.0), pose(1.0)]))]))
        return feeler.load_tracks(path)


def clashes() -> feeler.Clashes:
    """One finding, which somebody approved."""
    path = Path(__file__).parent.parent / "testdata" / "clash" / "found.json"
    return feeler.load_clashes(path)


def opened(scene: feeler.Scene) -> dict[str, list[Any]]:
    """What goes through beside a wall."""
    limit = feeler.OpeningLimit("fist", "ball", 0.09, 0.0, "mine")
    found = feeler.opening(scene, [0.0, 0.0, 0.2], [0.0, 0.0, 1.0], limits=[limit])
    return {"Opening": [found], "OpeningFit": list(found.fits), "OpeningLimit": [limit]}


def nightly() -> dict[str, list[Any]]:
    """A box that comes out, and did beside another."""
    rows = [box((0, 0, 0), 0.5), box((2, 0, 0), 0.5), box((0.75, 0, 0), 0.5)]
    mocks = [feeler.Mockup({str(n): mesh for n, mesh in enumerate(some)}) for some in (rows, rows[:2])]
    first = feeler.maintain(feeler.Scene(mocks[0]), ["0"])
    night = feeler.maintain(feeler.Scene(mocks[1]), ["0"], previous=first)
    return {"Maintenance": [first, night], "MaintainRow": list(night), "MaintainChange": list(night.changes)}


def reached() -> dict[str, list[Any]]:
    """A bolt, and what a tool met on its way to it."""
    bolt = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    wall, faces = box((0.03, -0.1, -0.1), 0.2)
    mock = feeler.Mockup(
        np.concatenate([bolt.vertices, wall]),
        np.concatenate([bolt.faces, faces + len(bolt.vertices)]),
        np.repeat([0, 1], [len(bolt.faces), len(faces)]),
        ["bolt", "wall"],
    )
    found = feeler.find_fasteners(mock)
    reach = feeler.access(
        feeler.Scene(mock), feeler.Tool(*box((0.02, 0.0, 0.0), 0.03), "probe"), found, swing_deg=300.0
    )
    assert len(found) == 1 and reach.blockers
    task = feeler.task(feeler.Scene(mock), "bolt")
    stuck = feeler.task(feeler.Scene(mock), "bolt", feeler.Tool(*box((-0.05, -0.05, -0.01), 0.1), "probe"), keep="wall")
    assert task.steps and stuck.blocked
    return {
        "Fasteners": [found, found[:0]],
        "Fastener": list(found),
        "Holds": [feeler.holds(mock, found), feeler.Holds([])],
        "Sight": [feeler.sight(feeler.Scene(mock), found, [[0.0, 0.0, 1.0]])],
        "Seen": list(feeler.sight(feeler.Scene(mock), found, [[0.0, 0.0, 1.0]])),
        "Hold": list(feeler.holds(mock, found)),
        "Task": [task, stuck],
        "TaskStep": list(task.steps),
        "TaskBlocker": list(stuck.blocked),
        "Times": [feeler.Times(), feeler.Times({"get": 5.0}, pitches_mm={"*": 1.0}, typed={"*bolt*": [9.0, 1.0]})],
        "Access": [reach],
        **nightly(),
        "Reach": list(reach),
        "Catalogue": [feeler.catalogue(), feeler.Catalogue([])],
        "ToolSpec": list(feeler.catalogue())[::40],
        **opened(feeler.Scene(mock)),
        "TriedTool": [feeler.TriedTool("socket 10", "it collides at every angle", reach.blockers)],
        "Blocker": list(reach.blockers),
    }


def removed() -> dict[str, list[Any]]:
    """A part that comes out of a corner after another, and what was in its way."""
    low, high = box((0, 0, 0), 0.5), box((0, 0, 0.5), 0.5)
    wall = box((0.5, 0, 0), 1.0)
    mock = feeler.Mockup(
        np.concatenate([low[0], high[0], wall[0]]),
        np.concatenate([faces + 8 * i for i, (_, faces) in enumerate([low, high, wall])]),
        np.repeat([0, 1, 2], 12),
        ["low", "high", "wall"],
    )
    scene = feeler.Scene(mock)
    straight = feeler.removal(scene, "high", threads=1)
    stopped = feeler.removal(scene, "low", directions=[[1, 0, 0]], threads=1)
    assert stopped.blocked_by
    within = feeler.removal(scene, "wall", directions=[[-1, 0, 0]], seconds=1e-9)
    assert not within.is_found
    order = feeler.removal_order(scene, "high", threads=1)
    many = feeler.removals(scene, ["high"], threads=1)
    return {
        "Removals": [many, feeler.Removals([], is_partial=True)],
        "PartsRemoval": list(many),
        "Removal": [straight, stopped, within],
        "RemovalBlocker": list(stopped.blocked_by),
        "RemovalLeg": list(straight.legs),
        "Certificate": [straight.certificate],
        "RemovalOrder": [order],
        "RemovalStep": list(order),
    }


def samples() -> dict[str, list[Any]]:
    """Of each class that travels, at least one object; those of results both with and without a find."""
    mock = mockup()
    tool = feeler.Tool(*box((0, 0, 0), 0.25), "probe")
    scene = feeler.Scene(mock, voxel_size=0.1 + 0.2, storage="hashed", hashing=0.3, threads=2, simd="portable")
    slides = feeler.Mechanism(mock, [feeler.Joint("j", feeler.JointKind.PRISMATIC, None, 0)])
    many = feeler.Mockup(*box((0, 0, 0), 1.0), np.full(12, 69_999), ["bolt"] * 70_000)
    tracker = feeler.ContactTracker(scene, tool)
    tracker.contacts(pose(0.2, z=3.0))
    contacts = [scene.contacts(tool, pose(0.2)), scene.contacts(tool, pose(9.0))]
    rays = scene.rays(np.tile([0.4, 0.4, 3.0], (3, 1)), [[0, 0, -1], [0, 0, 1], [1, 0, -2]])
    assert contacts[0] and not contacts[1]
    path = [pose(0.2, z=3.0), pose(0.2, z=0.5), pose(0.2, z=3.0), pose(0.3, z=3.0)]
    session = haptics.Session(scene, tool)
    begun = [session.start(pose(0.2, z=2.0)), session.start(pose(0.2))]
    session.start(pose(0.2, z=1.0001))
    step = session.step(pose(0.2, z=0.999))
    session.run(haptics.devices.Mouse(pose(0.2, z=1.0001)), realtime=False)
    while session.view().number == 0:
        time.sleep(0.001)
    view, granted, trace, stats = session.view(), session.granted(), session.trace(), session.stop()
    assert stats is not None
    return {
        "View": [view],
        "Requirement": [feeler.Requirement("one", "post*", ["a", "b"], 0.1)],
        "Verified": feeler.verify(scene, [feeler.Requirement("one", "*", "*", 0.1)]),
        "Joint": [feeler.Joint("hinge", feeler.JointKind.REVOLUTE, None, ("door", 2), limits=(0, 1), because="so")],
        "JointCoupling": [feeler.JointCoupling("rack", "pinion", 0.1)],
        "Mechanism": [slides],
        "Tracks": [tracks(mock)],
        "MechanismClashes": [slides.clash({"j": (0.0, 9.0)})],
        "MechanismClearance": [slides.clearance({"j": (0.0, 0.1)}, error=0.1)],
        "MechanismContact": [feeler.MechanismContact(0.1, 0, 1, "a", "b", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))],
        "MechanismSeat": [feeler.MechanismSeat(0, 1, "a", "b")],
        "Range": [slides.range("j")],
        "JointKind": [feeler.JointKind.SCREW],
        "PartChanges": [feeler.PartChanges(changed=("a",), renamed={"b": "c"})],
        "Granted": [granted],
        "Trace": [trace],
        "Statistics": [stats],
        "Distribution": [stats.servo_tick],
        "Coupling": [haptics.Coupling(), haptics.Coupling(stiffness_n_per_m=500.0)],
        "Start": begun,
        "Seat": list(begun[1].seats),
        "Step": [step],
        "Planes": [step.planes],
        "Plane": list(step.planes),
        "Tick": list(trace)[:1],
        "Parted": [haptics.Parted(3, 1, 0.5)],
        "Mockup": [mock, feeler.Mockup(*box((0, 0, 0), 1.0))],
        "Defect": [mock.defects["zero_area"], many.defects["duplicate"]],
        "LoadReport": [mock.report],
        "Source": [mock.source],
        "Part": list(mock.parts),
        "Parts": [mock.parts],
        "Screw": [feeler.Screw((0, 0, 1), (1, 2, 3), 0.5), feeler.Screw((1, 2, 0), (0, 0, 0), -40.0, 0.002)],
        "Tool": [tool, feeler.Tool.of_parts(mock)],
        "Scene": [
            scene,
            scene.without("odd"),
            feeler.Scene(mock, storage="dense", voxel_size=0.25),
            feeler.Scene(mock, tool=tool),
        ],
        "ContactTracker": [tracker, feeler.ContactTracker(scene, tool)],
        "Collision": [scene.collide(tool, p) for p in POSES],
        "Batch": [scene.collide_batch(tool, POSES), scene.collide_batch(tool, POSES[:0])],
        "Distance": [scene.distance(tool, pose(5.0)), scene.distance(tool, pose(5.0), 0.1)],
        "DistanceBatch": [scene.distance_batch(tool, POSES, 1.0)],
        "Clearance": [scene.clearance(tool, p, 0.5, triangles=True) for p in POSES],
        "ClearanceBatch": [scene.clearance_batch(tool, POSES, 0.5)],
        "ClearanceAlong": [scene.clearance_along(tool, path[0], path[1], 1e-3)],
        "Chain": [feeler.Chain([feeler.Screw((0, 0, 1), (1, 2, 3), 0.5), feeler.Slide((1, 2, 0))])],
        "Slide": [feeler.Slide((1, 2, 0.5))],
        "Cast": [scene.cast(tool, path[0], path[1])],
        "PathCheck": [scene.check_path(tool, path), scene.check_path(tool, path[2:])],
        "Contacts": contacts,
        "ContactPlane": list(contacts[0]),
        "Containment": [scene.containment(tool, pose(0.4, 0.4, 0.4)), scene.containment(tool, pose(9.0))],
        "IgnoredPairs": [feeler.IgnoredPairs(tool, mock, [("*", "pair")]), feeler.IgnoredPairs(tool, mock, [])],
        "Penetration": [scene.penetration(tool, pose(0.2)), scene.penetration(tool, pose(0.4, 0.4, 0.4))],
        "Depths": [scene.depth(tool, pose(0.2)), scene.depth(tool, pose(9.0))],
        "Depth": list(scene.depth(tool, pose(0.2))),
        "Packed": [mock.pack(), mock.pack(5, ["odd", "left"]), tool.pack()],
        "PackedPiece": [*mock.pack(5).pieces, *many.pack().pieces],
        "Rays": [rays, scene.rays([], [])],
        "RayHit": [each for each in rays if each is not None],
        "SectionOutline": [scene.section([0.3, 0.2, 0.1], [1, 2, 3]), scene.section([0, 0, 9], [0, 0, 1])],
        "PairKind": list(feeler.PairKind),
        "Verdict": list(feeler.Verdict),
        "Clashes": [clashes(), clashes()[:0]],
        "Clash": list(clashes()),
        **reached(),
        **removed(),
    }


SAMPLES = samples()


def public_classes() -> dict[str, type]:
    """Every class that feeler or its core shows, by name."""
    shown = [(name, getattr(feeler, name)) for name in feeler.__all__]
    shown += [(name, getattr(haptics, name)) for name in haptics.__all__]
    shown += [(name, each) for name, each in inspect.getmembers(_core, inspect.isclass) if name not in BASES]
    return {name: each for name, each in shown if inspect.isclass(each)}


OLD = {"PathCheck": ("free", "fraction"), "ClearanceAlong": ("share", "shares")}
"""Older names, which warn."""


def facts(value: Any) -> Any:
    """All that can be asked of an object without arguments, arrays as (dtype, shape, bytes)."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tolist() if value.dtype == object else value.tobytes()
    if isinstance(value, (list, tuple)):
        return [facts(each) for each in value]
    if isinstance(value, dict):
        return {key: facts(each) for key, each in value.items()}
    if type(value).__module__.startswith("feeler") and not is_dataclass(value) and not isinstance(value, Enum):
        names = [name for name in dir(value) if not name.startswith("_") and name != "build_seconds"]
        names = [name for name in names if name not in OLD.get(type(value).__name__, ())]
        asked = {name: getattr(value, name) for name in names}
        found = {name: facts(answer) for name, answer in asked.items() if not callable(answer)}
        if hasattr(value, "__getitem__"):
            found["items"] = [facts(value[i]) for i in range(len(value))]
        shown = "" if type(value).__repr__ is object.__repr__ else repr(value)
        return {"class": type(value).__name__, "repr": shown, **found}
    return repr(value)


def staying(name: str) -> Any:
    """One of what does not travel."""
    mock, tool = mockup(), feeler.Tool(*box((0, 0, 0), 0.25))
    if name == "Predictor":
        return _core.Predictor(mock, tool, "dense", 0.0)
    if name == "SavedScene":
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.feeler"
            feeler.Scene(mock).save(path)
            return _core.SavedScene(str(path), True, 2**63, None)
    if name == "Project":
        with tempfile.TemporaryDirectory() as folder, feeler.open_project(Path(folder) / "a.feelproj", mock) as project:
            return project
    if name == "PiecePredictor":
        return _core.PiecePredictor(mock, tool)
    if name == "ClashRows":
        return _core.clash(feeler.Scene(mock), np.zeros((1, 1)), np.zeros((1, 1)))
    if name == "RemovalAnswer":
        lift = {
            "allow_start": True,
            "allow_overlap": 0.0,
            "allow_parts": [],
            "clearance": 0.0,
            "seconds": 1.0,
            "seed": 0,
        }
        return _core.removal(feeler.Scene(mock), tool, pose(5.0), own_parts=1, directions=np.eye(3), **lift)
    if name in ("Shape", "Bodies"):
        vertices, faces = mock.vertices, mock.faces
        return _core.Bodies(1, 2**20) if name == "Bodies" else _core.Shape(vertices, faces, 2**30)
    if name in ("World", "GuardedMove", "MoveAnswer"):
        world = _core.World(feeler.Scene(mock), [])
        guarded = _core.GuardedMove(world, tool, pose(5.0))
        made = {"World": world, "GuardedMove": guarded, "MoveAnswer": guarded.go(pose(5.0), pose(4.0), 1e-6, 1e-6)}
        return made[name]
    if name == "MovedMockup":
        held = []
        whole = feeler.Scene(mock)

        def keep(core: Any) -> feeler.Mockup:
            held.append(core)
            return mock._with_moved(core)

        _core.Scene._selected_moved(whole, [0] * mock.part_count, pose(5.0)[None], keep)
        return held[0]
    if name == "Impact":
        return _core.Impact(0.5, np.zeros(3), np.ones(3), 0)
    device = haptics.devices.Simulated()
    if name == "HapticsDevice":
        return device._device
    session = haptics.Session(feeler.Scene(mock), tool)
    if name == "HapticsRun" or name in RUNNING:
        session.start(pose(5.0))
        session.run(device, realtime=False)
        return session._run if name == "HapticsRun" else RUNNING[name](session._run)
    return STEPPED[name](session) if name in STEPPED else session


@pytest.mark.parametrize("name", sorted(public_classes()))
def test_every_public_class_travels_or_says_that_it_does_not(name: str) -> None:
    cls = public_classes()[name]
    if issubclass(cls, (FeelerError, KeyboardInterrupt, Warning)):
        return  # below
    if name in STAY:
        made = staying(name)
        for act in WAYS.values():
            with pytest.raises(TypeError, match="cannot be pickled or copied: "):
                act(made)
        return
    assert SAMPLES.get(name), f"{name} is new: give samples() one, and see that it travels"
    for value in SAMPLES[name]:
        assert isinstance(value, cls)
        before = facts(value)
        for way, act in WAYS.items():
            there = act(value)
            assert type(there) is type(value), way
            assert facts(there) == before, way


@pytest.mark.parametrize(
    "cls", [c for c in public_classes().values() if issubclass(c, FeelerError) and c is not feeler.VariantsError]
)
def test_errors_travel(cls: type[FeelerError]) -> None:
    error = cls("voxel_size is -1: it must be positive")
    error.add_note("seen on the way") if sys.version_info >= (3, 11) else None
    for way, act in WAYS.items():
        there = act(error)
        assert type(there) is cls and str(there) == str(error) and there.args == error.args, way
        assert getattr(there, "__notes__", None) == getattr(error, "__notes__", None), way


def test_errors_of_variants_travel_with_what_was_found() -> None:
    found = feeler.VariantsError({0: SAMPLES["Clashes"][0], 2: feeler.MissingFileError("a.stl: there is no such file")})
    for act in WAYS.values():
        there = act(found)
        assert type(there) is feeler.VariantsError and str(there) == str(found) and "variants[2]: a.stl" in str(there)
        assert facts(there.found[0]) == facts(found.found[0]) and type(there.errors[2]) is feeler.MissingFileError


@pytest.mark.parametrize(
    ("cls", "holds"),
    [
        (feeler.ClashInterrupted, ("clashes", "Clashes")),
        (feeler.RemovalInterrupted, ("removal", "Removal")),
        (feeler.RemovalsInterrupted, ("removals", "Removals")),
        (feeler.RemovalOrderInterrupted, ("order", "RemovalOrder")),
        (feeler.AccessInterrupted, ("access", "Access")),
        (feeler.TaskInterrupted, ("task", "Task")),
        (feeler.MaintenanceInterrupted, ("maintenance", "Maintenance")),
    ],
)
def test_interruptions_travel_with_what_was_found(cls: Any, holds: tuple[str, str]) -> None:
    attribute, kind = holds
    found = cls(SAMPLES[kind][0])
    for act in WAYS.values():
        there = act(found)
        assert type(there) is cls and str(there) == str(found)
        assert facts(getattr(there, attribute)) == facts(SAMPLES[kind][0])


def test_a_scene_that_travelled_answers_as_before() -> None:
    tool = SAMPLES["Tool"][0]
    for scene in SAMPLES["Scene"]:
        there = pickle.loads(pickle.dumps(scene))
        there.validate()
        assert there.voxel_size == scene.voxel_size
        for p in POSES:
            assert facts(there.collide(tool, p)) == facts(scene.collide(tool, p))
            assert facts(there.contacts(tool, p)) == facts(scene.contacts(tool, p))
        assert there.memory() == scene.memory()
        assert there.__reduce__()[1][3][2] == scene.__reduce__()[1][3][2], "its options"


def test_a_scene_takes_no_index_along_and_a_result_no_mock_up() -> None:
    mock = feeler.sample("differential", 20_000)
    tool = feeler.sample_tool("wrench")
    scene = feeler.Scene(mock)
    scene.contacts(tool, np.eye(4))  # finds adjacency, leaves working memory
    plain = len(pickle.dumps(mock))
    assert plain < len(pickle.dumps(scene)) < plain + 1000
    for result in (
        scene.collide(tool, np.eye(4)),
        scene.check_path(tool, [np.eye(4)]),
        scene.contacts(tool, np.eye(4)),
    ):
        assert len(pickle.dumps(result)) < plain / 4


def test_a_copy_of_a_scene_is_the_scene() -> None:
    for scene in SAMPLES["Scene"]:
        assert copy.copy(scene) is scene and copy.deepcopy([scene])[0] is scene


def test_attributes_and_subclasses_travel() -> None:
    tool = copy.copy(SAMPLES["Tool"][0])
    tool.name = "renamed"
    tool.serial = 17
    there = pickle.loads(pickle.dumps(tool))
    assert (there.name, there.serial, SAMPLES["Tool"][0].name) == ("renamed", 17, "probe")
    for mine in (Marked(*box((0, 0, 0), 1.0)), Bay(mockup(), owner="me")):
        there = pickle.loads(pickle.dumps(mine))
        assert type(there) is type(mine) and getattr(there, "owner", None) == getattr(mine, "owner", None)
        assert facts(there) == facts(mine)


class Marked(feeler.Mockup):
    """Somebody's own kind of mock-up."""


class Bay(feeler.Scene):
    """Somebody's own kind of scene, made in another way."""

    def __new__(cls, mockup: feeler.Mockup, *, owner: str) -> Bay:
        self = super().__new__(cls, mockup, voxel_size=0.5, threads=1)
        self.owner = owner
        return self


def test_arrays_go_out_of_band() -> None:
    mock = feeler.sample("differential", 20_000)
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(mock, 5, buffer_callback=buffers.append)
    arrays = mock.vertices.nbytes + mock.faces.nbytes + mock.part_of_face.nbytes
    assert sum(len(buffer.raw()) for buffer in buffers) >= arrays
    assert len(head) < 100_000
    # As a transport may give them back: read-only, and wherever they came to lie.
    odd = [memoryview(b"x" + bytes(buffer.raw()))[1:] for buffer in buffers]
    assert facts(pickle.loads(head, buffers=odd)) == facts(mock)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_processes_ask_for_each_other(method: str) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system cannot {method}")
    scene, tool = SAMPLES["Scene"][0], SAMPLES["Tool"][0]
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as executor:
        for name, arguments in {"collide": (POSES[0],), "check_path": (POSES,), "contacts": (POSES[0],)}.items():
            asked = operator.methodcaller(name, tool, *arguments)
            assert facts(executor.submit(asked, scene).result()) == facts(asked(scene))
        failing = executor.submit(operator.methodcaller("collide", tool, 2 * np.eye(4)), scene)
        with pytest.raises(feeler.PoseError, match="not rigid"):
            failing.result()


def test_another_format_says_which_feeler_wrote_it() -> None:
    restore, (_, _, kind, state) = SAMPLES["Batch"][0].__reduce__()
    with pytest.raises(LoadError, match=r"Batch was pickled by feeler 7\.1 in format 99, but this is feeler .* format"):
        restore(99, "7.1", kind, state)


def test_a_damaged_pickle_is_refused() -> None:
    def broken(name: str, change: Callable[[list[Any]], None]) -> None:
        restore, (written_in, by, kind, state) = SAMPLES[name][0].__reduce__()
        changed = list(state)
        change(changed)
        with pytest.raises(LoadError, match=f"pickle of a {name} is damaged"):
            restore(written_in, by, kind, tuple(changed))

    def put(place: int, value: Any) -> Callable[[list[Any]], None]:
        return lambda state: state.__setitem__(place, value)

    assert len(SAMPLES["Batch"][0].pairs) > 0
    broken("Batch", put(0, np.array([0, 10**6], dtype=np.uint64)))
    broken("Batch", put(0, np.array([], dtype=np.uint64)))
    broken("Batch", put(1, np.zeros((3, 3), dtype=np.uint32)))
    broken("Batch", lambda state: state[2].setflags(write=False) or state.__setitem__(2, state[2] + 7))
    broken("Batch", lambda state: state.pop())
    broken("Collision", put(1, np.zeros(0, dtype=np.uint8)))
    broken("Collision", put(3, {"nonsense": 1}))
    broken("Cast", put(0, np.zeros((2, 24))))
    broken("Cast", put(1, "text"))
    broken("PathCheck", put(0, 0))
    broken("Distance", put(1, np.zeros((1, 6))))
    broken("DistanceBatch", put(0, np.zeros(4, dtype=bool)))
    broken("ClearanceBatch", put(0, np.array([0, 1, 0], dtype=np.uint64)))
    broken("ContactPlane", put(1, 99))
    broken("Contacts", put(1, (np.zeros(2, dtype=np.uint32), np.array([0, 5], dtype=np.uint64))))
    broken("Contacts", put(3, (np.zeros((1, 3, 3)), np.zeros(1, dtype=np.uint32))))
    broken("Penetration", put(2, "certain"))
    broken("Rays", put(0, np.zeros(3, dtype=bool)))
    broken("Rays", put(2, np.zeros((1, 6))))
    broken("SectionOutline", put(0, np.zeros((1, 3, 3))))
    broken("SectionOutline", put(1, np.zeros(1, dtype=np.uint32)))
    broken("SectionOutline", put(2, np.zeros(1, dtype=np.uint32)))
    broken("Packed", put(1, np.zeros(3, dtype=np.uint32)))
    broken("Packed", put(2, np.zeros(26, dtype=np.uint32)))
    broken("Packed", put(0, ()))
    broken("PackedPiece", put(0, np.zeros((1, 3), dtype=np.float32)))
    broken("PackedPiece", put(1, np.zeros(1, dtype=np.uint16)))
    broken("PackedPiece", put(2, np.full((2, 3), 999, dtype=np.uint16)))
    broken("PackedPiece", put(5, np.zeros((1, 3))))
    with pytest.raises(LoadError, match='nothing is called "Nonsense"'):
        travel.restore(travel.FORMAT, "0", "Nonsense", ())


def test_a_scene_goes_where_its_instruction_set_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    restore, (written_in, by, kind, (cls, mock, options, mask)), _ = SAMPLES["Scene"][0].__reduce__()
    assert options["simd"] == "portable"
    there = restore(written_in, by, kind, (cls, mock, {**options, "simd": "of another machine"}, mask))
    assert there.simd == SAMPLES["Scene"][3].simd
    with pytest.raises(feeler.OptionError, match="voxel_size"):
        restore(written_in, by, kind, (cls, mock, {**options, "voxel_size": -1.0}, mask))
