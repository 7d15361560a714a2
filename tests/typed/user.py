"""A user's script, as strict as type checkers are: nothing in it may be an error or of no known type."""

from typing import Any

import numpy as np
import numpy.typing as npt
from typing_extensions import assert_type

import feeler
from feeler.compat.trimesh import CollisionManager, ContactData, DistanceData
from feeler.types import (
    CardQuestion,
    CollisionStats,
    FindingStatus,
    GivenWay,
    Hand,
    MeshSource,
    PackageDirs,
    PartsLike,
    PoseLike,
    RequirementResult,
    RequirementsLike,
    Storage,
    TaskEditKind,
    Values,
    Vec3,
    WordsLike,
)

mockup = feeler.load_mockup("engine.step")
tool = feeler.load_tool("wrench.stl")
scene = feeler.Scene(mockup)
pose: npt.NDArray[np.float64] = np.eye(4)

storage: Storage = "dense"
dense = feeler.Scene(mockup, storage=storage, voxel_size=0.01)
assert_type(dense.storage, Storage)
total: int = scene.memory().total + scene.memory()["triangles"]
parts: list[feeler.Part] = [part for part in mockup.parts if part.triangles > 100]
report: feeler.LoadReport = mockup.report
defect: feeler.Defect = report.defects["zero_area"]
truth: feeler.samples.Truth = feeler.sample_truth("gearbox")
fits: list[feeler.samples.Fit] = [fit for fit in truth.fits if fit.flush]


Known = tuple[
    CardQuestion, FindingStatus, GivenWay, PackageDirs, RequirementResult, TaskEditKind, Values, Vec3, WordsLike
]


def reached_by(hand: Hand) -> feeler.Access:
    return feeler.access(scene, tool, feeler.find_fasteners(mockup), hand=hand)


def verified(limits: RequirementsLike, start: PoseLike) -> bool:
    return bool(feeler.verify(scene, limits)) and feeler.removal_order(scene, "a", start=start).is_found


def is_free_at(where: PoseLike, without: PartsLike) -> bool:
    return scene.without(without).is_free(tool, where)


hit = scene.collide(tool, pose)
counters: CollisionStats = hit.stats
print(counters.exact_tests, counters["pairs"], sum(counters.values()))
assert_type(hit, feeler.Collision)
assert_type(scene.is_colliding(tool, pose), bool)
batch = scene.collide_batch(tool, np.stack([pose, pose]))
assert_type(batch, feeler.Batch)
for pairs in batch:
    assert_type(pairs, npt.NDArray[np.uint32])
for gap in scene.distance_batch(tool, np.stack([pose, pose])):
    assert_type(gap, feeler.Distance)

impact = scene.cast(tool, pose, pose)
if impact is not None:
    assert_type(impact.fraction, float)
    print(impact.part + 1)
path = scene.check_path(tool, [pose, feeler.Screw([0, 0, 1], [0, 0, 0], 0.5)])
assert_type(path, feeler.PathCheck)

near = scene.distance(tool, pose)
if near is not None:
    assert_type(near.value, float)
contacts = scene.contacts(tool, pose)
assert_type(contacts.gaps, npt.NDArray[np.float64])

clashes = feeler.clash(mockup, clearance=0.002)
assert_type(clashes, feeler.Clashes)
for row in clashes:
    assert_type(row, feeler.Clash)
    if row.verdict == feeler.Verdict.CLASH:
        print(row.path_a, row.path_b)
found = feeler.removal(scene, "*pump*")
assert_type(found, feeler.Removal)
print([str(leg) for leg in found.legs], [part.path for part in found.held_by])
order = feeler.removal_order(scene, "*pump*")
assert_type(order.steps, tuple[feeler.RemovalStep, ...])
screws: feeler.Fasteners = feeler.find_fasteners(scene)
for reach in feeler.access(scene, tool, screws):
    print(reach)

by_index: dict[int, npt.NDArray[np.float64]] = {part.index: pose for part in parts}
opened: dict[str, tuple[npt.NDArray[np.float64], list[float]]] = {"cowl/*": (np.eye(3), [0.0, 0, 1])}
both: feeler.Scene = scene.moved(by_index).moved(opened).moved({"a": pose, ("b", 3): pose, parts[0]: pose, 4: pose})
scene.moved({part: pose for part in parts}).moved({}).moved({tuple(parts): pose})

session = feeler.haptics.Session(scene, tool)
session.start(pose)
step = session.step(pose, dt=0.001)
assert_type(step, feeler.haptics.Step)
print(step.force @ step.force)

try:
    view: feeler.View = feeler.view(scene)
    view.screenshot("engine.png")
    view.measure_add("edge", points=mockup.vertices[:2])
    view.measure_add("point", points=[(0, 0, 0), np.zeros(3)])
    view.measure_add("angle", triangles=scene.collide(tool, pose).mockup_triangles[:2])
except (feeler.WorkbenchError, feeler.WriteError, feeler.RemovalInterrupted) as error:
    print(error)


class Held:
    """A mesh of another library."""

    vertices = np.zeros((3, 3))
    faces = np.array([[0, 1, 2]])


corners, corner = Held.vertices, Held.faces
one: feeler.Mockup = feeler.Mockup(corners, corner, [0], ["a"], part_paths=["a/b"])
feeler.Mockup(corners.astype(np.float32), corner.astype(np.uint8))
feeler.Mockup([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
feeler.Mockup([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
wrench: feeler.Tool = feeler.Tool(corners, corner, "wrench")
feeler.Tool(one, name="all")
feeler.Mockup(Held(), unit="mm")
feeler.Mockup([Held(), one, wrench, (corners, corner)])
feeler.Mockup({"a": Held(), "b": (corners, corner), "c": {"d": [one]}, "e": one})
by_name: dict[str, Held] = {"a": Held()}
feeler.Mockup(by_name)
feeler.Mockup(list(by_name.values()))
feeler.Mockup({number: one for number in range(3)})


def made(mesh: MeshSource) -> feeler.Mockup:
    return feeler.from_trimesh(mesh, unit="in")


def approved(project: feeler.Project) -> list[str]:
    assert_type(project.history()[0]["at"], str)
    assert_type(project.document()["hidden"], list[int])
    return [row["note"] for row in project.findings() if row["status"] == "approved" and row["depth"] is not None]


for tool_triangle, mockup_triangle in hit:
    assert_type(tool_triangle + mockup_triangle, int)
assert_type([each.distance for each in scene.rays([[0, 0, 9]], [[0, 0, -1]]) if each is not None], list[float])

with feeler.haptics.Session(scene, tool) as held:
    assert_type(held, feeler.haptics.Session)


manager, others, box = CollisionManager(), CollisionManager(), (corners, corner)
assert_type(manager.in_collision_internal(), bool)
assert_type(manager.in_collision_internal(True), tuple[bool, set[tuple[Any, Any]]])
assert_type(manager.in_collision_single(box, None, False, True), tuple[bool, list[ContactData]])
assert_type(manager.in_collision_single(box, return_names=True), tuple[bool, set[Any]])
assert_type(manager.in_collision_single(box, return_data=True), tuple[bool, list[ContactData]])
assert_type(
    manager.in_collision_other(others, return_names=True, return_data=True),
    tuple[bool, set[tuple[Any, Any]], list[ContactData]],
)
assert_type(manager.min_distance_single(box), float)
assert_type(manager.min_distance_single(box, return_data=True), tuple[float, DistanceData | None])
assert_type(manager.min_distance_internal("a", True), tuple[float, tuple[Any, Any] | None])
assert_type(manager.min_distance_other(others, True, True), tuple[float, tuple[Any, Any] | None, DistanceData | None])


def apart(with_names: bool, with_data: bool) -> float:
    answer = manager.min_distance_internal(return_names=with_names, return_data=with_data)
    meeting = manager.in_collision_other(others, with_names, with_data)
    if isinstance(meeting, tuple) and meeting[0]:
        return 0.0
    return answer[0] if isinstance(answer, tuple) else answer
