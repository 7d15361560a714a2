"""Can a mount's retainer be taken off the gearbox, and what must be removed first? Writes the path and a film of it.

    python examples/removal.py [MOCKUP_FILE PART]

Without a file it uses the built-in gearbox.
"""

import sys

import numpy as np

import feeler
from feeler.plan.as_glb import write_removal_glb

if len(sys.argv) == 3:
    mockup, part = feeler.load_mockup(sys.argv[1]), sys.argv[2]
else:
    mockup, part = feeler.sample("gearbox", triangles=100_000), "gearbox/bracket/left_mount/retainer"
scene = feeler.Scene(mockup)
found = feeler.removal(scene, part, seconds=1.0)
print(f"{part}: {found!r}")
for blocker in found.blocked_by[:5]:
    print(f"  in the way of {blocker.count} tries: {blocker.path}")

order = feeler.removal_order(scene, part, seconds=10.0)
for number, step in enumerate(order, start=1):
    names = ", ".join(mockup.part_paths[index] for index in step.parts)
    way = step.removal
    print(f"step {number}: {names}: {way.path_length:.3f} m, turned by {np.degrees(way.rotation):.1f} degrees")

np.save("way.npy", order.steps[-1].removal.poses)
write_removal_glb("way.glb", mockup, order.steps)
print("way.npy, and a film in way.glb")
