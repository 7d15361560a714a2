"""A user's script, as strict as type checkers are: nothing in it may be an error or of no known type."""

import numpy as np
import numpy.typing as npt
from typing_extensions import assert_type

import feeler

mockup = feeler.load_mockup("engine.step")
tool = feeler.load_tool("wrench.stl")
scene = feeler.Scene(mockup)
pose: npt.NDArray[np.float64] = np.eye(4)

hit = scene.collide(tool, pose)
assert_type(hit, feeler.Collision)
assert_type(scene.is_colliding(tool, pose), bool)
batch = scene.collide_batch(tool, np.stack([pose, pose]))
assert_type(batch, feeler.Batch)

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

session = feeler.haptics.Session(scene, tool)
session.start(pose)
step = session.step(pose, dt=0.001)
assert_type(step, feeler.haptics.Step)
print(step.force @ step.force)

try:
    view: feeler.View = feeler.view(scene)
    view.screenshot("engine.png")
except (feeler.WorkbenchError, feeler.WriteError, feeler.RemovalInterrupted) as error:
    print(error)
