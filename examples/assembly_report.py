"""A report of a path through an assembly: which part is hit, when, and how hard; with a picture and a GLB.

    python examples/assembly_report.py [MOCKUP_FILE TOOL_FILE]

Without files it uses the built-in gearbox and torque wrench. Writes report.csv, report.png, report.glb.
"""

import sys

import numpy as np

import feeler
from feeler.io import csv_table
from feeler.picture import render_collision, write_collision_glb

if len(sys.argv) == 3:
    mockup, tool = feeler.load_mockup(sys.argv[1]), feeler.load_tool(sys.argv[2])
else:
    mockup, tool = feeler.sample("gearbox", triangles=100_000), feeler.sample_tool("torque")
print(mockup.report)

scene = feeler.Scene(mockup, tool=tool)
path = feeler.sample_path(scene, tool, 300)
hits = [scene.collide(tool, pose) for pose in path]

# One row per part: in how many poses it is hit, from when to when, and the most of its triangles hit at once.
rows: dict[int, list[int]] = {}
for number, hit in enumerate(hits):
    parts, counts = np.unique(mockup.part_of_face[hit.mockup_triangles], return_counts=True)
    for part, count in zip(parts.tolist(), counts.tolist(), strict=True):
        row = rows.setdefault(part, [0, number, number, 0])
        row[:] = [row[0] + 1, row[1], number, max(row[3], count)]
heading = ["part", "poses", "first pose", "last pose", "most triangles at once"]
lines: list[list[str | int | float | None]] = [
    [mockup.part_paths[part], *row] for part, row in sorted(rows.items(), key=lambda item: -item[1][0])
]
with open("report.csv", "wb") as file:
    file.write(csv_table(heading, lines))
print(f"{sum(len(hit.pairs) > 0 for hit in hits)} of {len(hits)} poses collide; parts hit: {len(rows)}; see report.csv")

worst = max(range(len(hits)), key=lambda i: len(hits[i].pairs))
render_collision("report.png", mockup, tool, path[worst], hits[worst], size=(1200, 750))
write_collision_glb("report.glb", mockup, tool, path[worst], hits[worst], context=0.1)
print(f"the worst moment, pose {worst}: report.png, report.glb")
