"""Haptics of a reach into an engine: the pose of the device, the pose that contact allows, and the force.

python examples/feel.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import feeler
from feeler import haptics

scene = feeler.Scene(feeler.sample("engine", triangles=100_000))
tool = feeler.sample_tool("hand")
way = feeler.sample_path(scene, tool, 1500)  # of the device, a pose a millisecond

session = haptics.Session(scene, tool)
with TemporaryDirectory() as folder:
    record = Path(folder) / "felt.npz"
    with session.record(record):
        session.start(way[0])
        steps = [session.step(world_from_device, dt=0.001) for world_from_device in way]
    same = haptics.replay(record, scene, tool)

colliding = sum(scene.is_colliding(tool, step.world_from_proxy) for step in steps)
entered = sum(scene.is_colliding(tool, world_from_device) for world_from_device in way)
forces = np.array([np.linalg.norm(step.force) for step in steps if step.mode != "free"])
touched = {int(part) for step in steps for part in step.planes.parts[step.planes.is_holding]}
print(f"a reach into the engine: {len(steps):,} steps, the device was inside something at {entered}")
print(f"the tool was in collision at {colliding} of them; it touched {len(touched)} parts")
print(f"the force was {forces.max():.1f} N at most, {np.median(forces):.1f} N in the median where it touched")
print(f"replayed {same.steps:,} steps: {'the same bit for bit' if same else f'another at step {same.at}'}")
