"""Makes the pictures and the table of fits of docs/samples.md from the sample gearbox and its known facts.

    python tools/gearbox_docs.py [--check]

`--check` writes nothing and fails if the table is out of date. Needs no display; takes a minute.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import numpy.typing as npt

import feeler
from feeler.io.body import body_of
from feeler.picture import Camera, Section, render
from feeler.samples.accessory import Fit, Truth

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "samples.md"
TRIANGLES, SIZE = 400_000, (1600, 1000)
BEGIN, END = "<!-- fits: tools/gearbox_docs.py -->\n", "<!-- end of fits -->\n"
APART_M, STEP_M = 0.02, 0.022
HIDDEN = ("bracket/", "door/", "harness/", "lines/")


def table(truth: Truth) -> str:
    """The fits by kind, as Markdown."""
    kinds: dict[str, list[Fit]] = defaultdict(list)
    for fit in truth.fits:
        kinds[fit.kind].append(fit)
    lines = ["| fit | pairs | play on each side, um | as drawn at most, um | for example |", "|---|---|---|---|---|"]
    for kind, fits in sorted(kinds.items(), key=lambda item: (-len(item[1]), item[0])):
        plays = sorted(int(np.floor(fit.play_m * 1e6 + 0.5 + 1e-6)) for fit in fits)
        span = f"{plays[0]}" if plays[0] == plays[-1] else f"{plays[0]} to {plays[-1]}"
        deep = round(max(fit.deepest_m for fit in fits) * 1e6)
        a, b = (path.removeprefix("gearbox/") for path in (fits[0].a, fits[0].b))
        lines.append(f"| {kind} | {len(fits)} | {span} | {deep} | `{a}`, `{b}` |")
    return "\n".join(lines) + "\n"


def exploded(mockup: feeler.Mockup, truth: Truth) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Vertices (n, 3) with every part moved along its way out, the first ones farthest; which faces are shown."""
    depth: dict[str, int] = {}
    axis: dict[str, tuple[float, float, float]] = {}
    for step in truth.steps:
        level = 1 + max((depth.get(path, 0) for path in step.after), default=0)
        for path in step.parts:
            depth[path] = max(level, depth.get(path, 0))
            legs = [leg for leg in step.legs if leg.kind == "pull"]
            near = [axis[p] for p in step.parts if p in axis]
            axis[path] = legs[-1].axis if legs else (near[0] if near else (0.0, 0.0, -1.0))
    deepest: dict[tuple[float, float, float], int] = defaultdict(int)
    for path, way in axis.items():
        deepest[way] = max(deepest[way], depth[path])
    shift = np.zeros((mockup.part_count, 3))
    shown = np.ones(mockup.part_count, dtype=bool)
    for part in mockup.parts:
        shown[part.index] = not part.name.startswith(HIDDEN)
        if part.path in axis and not part.name.startswith("housing/rear_case"):
            way = axis[part.path]
            shift[part.index] = np.array(way) * (APART_M + STEP_M * (deepest[way] - depth[part.path]))
    part_of_vertex = np.zeros(len(mockup.vertices), dtype=np.int64)
    part_of_vertex[mockup.faces] = mockup.part_of_face[:, None]
    return mockup.vertices + shift[part_of_vertex], shown[mockup.part_of_face]


def draw(folder: Path) -> None:
    """The gearbox whole, exploded, and cut open."""
    mockup = feeler.sample("gearbox", TRIANGLES)
    truth = feeler.sample_truth("gearbox", TRIANGLES)
    body = body_of(mockup)
    camera = Camera.framing(body.points, (-0.5, -0.25, -0.8), (0.0, 1.0, 0.0), size=SIZE)
    render(folder / "gearbox.png", body, camera=camera, size=SIZE)
    vertices, shown = exploded(mockup, truth)
    apart = feeler.Mockup(
        vertices, mockup.faces[shown], mockup.part_of_face[shown], mockup.part_names, part_paths=mockup.part_paths
    )
    body = body_of(apart, colours=mockup.part_colours)
    camera = Camera.framing(body.points, (0.62, -0.35, 0.62), (0.0, 1.0, 0.0), size=SIZE)
    render(folder / "exploded.png", body, camera=camera, size=SIZE)
    inside = body_of(mockup)
    cut = Section((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    near = inside.points[(np.abs(inside.points - np.array([0.0, -0.05, 0.06])) < [0.09, 0.18, 0.14]).all(axis=1)]
    camera = Camera.framing(near, (0.9, -0.15, 0.35), (0.0, 1.0, 0.0), size=SIZE)
    render(folder / "section.png", inside, camera=camera, size=SIZE, section=cut)


def main() -> int:
    """Writes the pictures and the table, or checks the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare the table")
    wants = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(BEGIN)
    tail = rest.split(END)[1]
    new = head + BEGIN + table(feeler.sample_truth("gearbox", TRIANGLES)) + END + tail
    if wants.check:
        return int(new != page)
    PAGE.write_text(new, encoding="utf-8")
    draw(ROOT / "docs" / "samples")
    return 0


if __name__ == "__main__":
    sys.exit(main())
