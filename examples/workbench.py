"""The workbench from a script: a wrench that stops, a pump that comes out, a picture; with --open to go on by hand.

python examples/workbench.py [--open]
"""

import sys

import numpy as np

import feeler

GEARBOX = "engine/externals/accessory_gearbox"
is_open = "--open" in sys.argv  # the browser

scene = feeler.Scene(feeler.sample("engine", triangles=100_000))
tool = feeler.sample_tool("wrench")

# Beside the gearbox, its handle outward: the columns are the wrench's axes in the world.
start = np.eye(4)
start[:3, :3] = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]]
start[:3, 3] = (-0.31, -0.7, 1.05)

with feeler.view(scene, tool, pose=start, browser=is_open) as view:
    # The hand wants to go through the pump, and comes as far as contact lets it.
    wish = start.copy()
    wish[1, 3] = -0.4
    view.pose = wish
    print(f"wished 300 mm inward, came {(view.pose[1, 3] - start[1, 3]) * 1e3:.1f} mm")
    print(f"stopped by {', '.join(view.touched)}")

    # What it would meet there: shown in the page, as any answer of the scene can be.
    hit = scene.collide(tool, wish)
    view.show(wish)
    view.show(hit)
    print(f"there it would meet the pump in {len(hit.pairs):,} pairs of triangles")

    # The pump with its bolts, taken out by an empty hand. It is seated in the gearbox: it may slide out of it.
    view.command("take_tool", name=None)
    view.command("grip", parts=f"{GEARBOX}/fuel_pump_1")
    for step in ((0.0, 0.0, 0.05), (0.0, -0.3, 0.0)):
        pose = view.pose
        pose[:3, 3] += step
        view.pose = pose
    view.command("release")
    (removal,) = view.session.document()["sequence"]
    clearance = removal["least_clearance"]
    print(f"{len(removal['parts'])} parts came out, {clearance * 1e3:.2f} mm was the least room they had")

    view.screenshot("workbench.png")
    if is_open:
        input("The page is open. Enter ends it. ")
