"""The workbench from a script: a wrench stopped by contact, a pump taken out, a picture; --open continues by hand.

python examples/workbench.py [--open]
"""

import sys

import numpy as np

import feeler

PUMP = "gearbox/oil_pump/body"
is_open = "--open" in sys.argv  # the browser

# What has to go before the pump is out already: pipes, nuts and its cover.
mockup = feeler.sample("gearbox", triangles=100_000)
*before, last = feeler.sample_truth("gearbox", triangles=100_000).way(PUMP)
scene = feeler.Scene(mockup).without([path for step in before if step.removes for path in step.parts])
tool = feeler.sample_tool("wrench")

# Behind the pump, its handle outward.
start = np.eye(4)
start[:3, 3] = (0.12, -0.01, 0.3)

with feeler.view(scene, tool, pose=start, browser=is_open) as view:
    # The hand wants to go through the pump, and comes as far as contact lets it.
    wish = start.copy()
    wish[2, 3] = 0.1
    view.pose = wish
    print(f"wished 200 mm forward, came {(start[2, 3] - view.pose[2, 3]) * 1e3:.1f} mm")
    print(f"stopped by {', '.join(view.touched)}")

    # What it would meet there: shown in the page, as any answer of the scene can be.
    hit = scene.collide(tool, wish)
    view.show_hit(wish)
    view.show_hit(hit)
    print(f"there it would meet the pump in {len(hit.pairs):,} pairs of triangles")

    # The pump, taken out by an empty hand. It is seated in the gearbox: it may slide out of it.
    view.command("take_tool", name=None)
    view.command("grip", parts=list(last.parts))
    pose = view.pose
    pose[:3, 3] += last.legs[0].distance_m * np.array(last.legs[0].axis)
    view.pose = pose
    view.command("release")
    (removal,) = view.session.document()["sequence"]
    clearance = removal["least_clearance"]
    room = "no other part was near" if clearance is None else f"{clearance * 1e3:.2f} mm was the least room they had"
    print(f"{len(removal['parts'])} parts came out, {room}")

    view.screenshot("workbench.png")
    if is_open:
        input("The page is open. Enter ends it. ")
