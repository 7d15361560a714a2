"""Many poses at once: where around an engine is there room for a wrench?

`collide_batch` takes all poses in one call, runs on all cores, and leaves Python free meanwhile.
"""

import time
from collections import Counter

import numpy as np

import feeler

mockup = feeler.sample("engine", triangles=100_000)
tool = feeler.sample_tool("wrench")
scene = feeler.Scene(mockup, tool=tool)

# A ring of places around the engine's axis, and at each the tool turned about its own z axis.
lower, upper = mockup.bounds
axis = int(np.argmax(upper - lower))
across = [k for k in range(3) if k != axis]
centre = (lower + upper) / 2
rng = np.random.default_rng(0)
count = 20_000
poses = np.tile(np.eye(4), (count, 1, 1))
turn = rng.uniform(0, 2 * np.pi, count)
poses[:, 0, 0] = poses[:, 1, 1] = np.cos(turn)
poses[:, 1, 0], poses[:, 0, 1] = np.sin(turn), -np.sin(turn)
angle, radius = rng.uniform(0, 2 * np.pi, count), rng.uniform(0.3, 1.1, count)
poses[:, axis, 3] = rng.uniform(lower[axis], upper[axis], count)
for k, direction in zip(across, (np.cos(angle), np.sin(angle)), strict=True):
    poses[:, k, 3] = centre[k] + radius * direction * (upper[k] - lower[k]) / 2

start = time.perf_counter()
batch = scene.collide_batch(tool, poses)
seconds = time.perf_counter() - start
print(f"{count:,} poses in {seconds:.2f} s, {count / seconds:,.0f} a second, {len(batch.pairs):,} pairs in all")

# Pose i has the pairs batch.pairs[batch.offsets[i] : batch.offsets[i + 1]].
pairs_of_pose = np.diff(batch.offsets.astype(np.int64))
free = pairs_of_pose == 0
print(f"{free.mean():.0%} of the poses are free")
for low in np.arange(0.3, 1.1, 0.2):
    ring = (radius >= low) & (radius < low + 0.2)
    print(f"  {low:.1f} to {low + 0.2:.1f} of the engine's radius: {free[ring].mean():4.0%} free")

pose_of_pair = np.repeat(np.arange(count), np.asarray(pairs_of_pose, dtype=np.int64))
hits = np.unique(np.stack([mockup.part_of_face[batch.pairs[:, 1]], pose_of_pair]), axis=1)
print("most often in the way:")
for part, number in Counter(hits[0].tolist()).most_common(5):
    print(f"  {mockup.part_paths[part]}: {number:,} poses")
