"""A user's script with typos: each line that is marked must be an error to a type checker."""

import numpy as np

import feeler
from feeler.compat.trimesh import CollisionManager

scene = feeler.Scene(feeler.load_mockup("engine.step"))
tool = feeler.load_tool("wrench.stl")

feeler.no_such_thing(1)  # wrong
feeler.colide(scene)  # wrong
feeler.AcessInterrupted  # wrong
scene.colide(tool, np.eye(4))  # wrong
scene.collide(tool)  # wrong
scene.collide(tool, np.eye(4), ignored=None)  # wrong
scene.collide(tool, np.eye(4), ignore=3)  # wrong
scene.moved({3.5: np.eye(4)})  # wrong
scene.moved({"cowl": "here"})  # wrong
scene.moved([np.eye(4)])  # wrong
scene.is_free(tool, np.eye(4), ignore="x")  # wrong
scene.cast(tool, np.eye(4), np.eye(4), touching="freely")  # wrong
scene.cast(tool, np.eye(4), np.eye(4)).fraction  # wrong
found = feeler.removal(scene, "*pump*", second=3)  # wrong
found.leg  # wrong
found.clearance.upper()  # wrong
feeler.clash(scene, clearance="2 mm")  # wrong
feeler.haptics.Session(scene, tool).stepp(np.eye(4))  # wrong
number: str = scene.is_colliding(tool, np.eye(4))  # wrong
feeler.Scene(scene.mockup, storage="block")  # wrong
feeler.Scene(scene.mockup, simd="avx")  # wrong
feeler.load_mockup("engine.step", unit="millimetre")  # wrong
feeler.load_tool("wrench.stl", up="w")  # wrong
feeler.optimal_voxel_size(scene.mockup, tool, "foo")  # wrong
feeler.sample("gear")  # wrong
feeler.sample("gearbox", faults=["no_such_fault"])  # wrong
feeler.sample_tool("hammer")  # wrong
feeler.sample_poses(scene, tool, "far", 3)  # wrong
feeler.clash(scene.mockup, contact="cord")  # wrong
feeler.clash(scene.mockup).groups("prt")  # wrong
feeler.clash(scene.mockup).where(verdict="crash")  # wrong
feeler.clash(scene.mockup).where(verdit="clash")  # wrong
feeler.clash(scene.mockup).set_status("id", "resolved")  # wrong
feeler.clash(scene.mockup).verdict  # wrong
feeler.find_fasteners(scene).where(kind="rivet")  # wrong
feeler.from_urdf("robot.urdf", geometry="both")  # wrong
feeler.io.write_stl("a.stl", tool, unit="km")  # wrong
feeler.haptics.devices.Simulated("desk")  # wrong
feeler.haptics.devices.Simulated(grip="weak")  # wrong
feeler.view(scene, mode="halt")  # wrong
found.found  # wrong
found.free  # wrong
scene.distance(tool, np.eye(4), max=1.0)  # wrong
scene.memory().bytes  # wrong
hit_stats: dict[str, int] = scene.collide(tool, np.eye(4)).stats  # wrong
feeler.Mockup("file.stl")  # wrong
feeler.Mockup(3)  # wrong
feeler.Mockup(None)  # wrong
feeler.Mockup(["file.stl"])  # wrong
feeler.Mockup({"a": "file.stl"})  # wrong
feeler.Mockup(np.eye(3))  # wrong
feeler.Mockup("file.stl", "faces")  # wrong
feeler.Mockup(np.eye(3), 3)  # wrong
feeler.Mockup(np.eye(3), [[0, 1, 2]], "abc")  # wrong
feeler.Mockup(np.eye(3), [[0, 1, 2]], unit="mm")  # wrong
feeler.Tool("file.stl")  # wrong
feeler.Tool(3)  # wrong
feeler.from_trimesh("file.stl")  # wrong

manager = CollisionManager()
manager.in_collision_internal().count  # wrong
hit, met = manager.in_collision_single(scene, return_names=True)
met.first  # wrong
contacts = manager.in_collision_internal(return_names=True, return_data=True)[2]
contacts[0].deep  # wrong
manager.min_distance_internal().upper()  # wrong
nearest = manager.min_distance_other(manager, return_data=True)[1]
nearest.distance  # wrong
manager.min_distance_internal(return_name=True)  # wrong
