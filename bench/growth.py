"""How the median time of a nominal `collide` grows from a small engine to a large one, both asked in turns.

    python bench/growth.py --write                        and put the table into docs/performance.md
    python bench/growth.py --sizes 100k,1.6M --tools torque --rounds 3

`bench/run.py` measures one size after the other, minutes apart, and has that from its record; a machine that others use
may have changed in between. Here both mock-ups are there at once and passes over their poses take turns. Before each
pass the caches are emptied, as other work would, or not: both are shown. Of each pose the least time of all rounds
counts.
"""

from __future__ import annotations

import argparse
import functools

import numpy as np
from engines import Floats
from measure import clock_once, find_poses
from options import TOOLS, triangles
from page import PERFORMANCE, fill
from record import machine

import feeler

EMPTIED_BYTES = 256 << 20  # more than the caches of most machines


def medians(scenes: list[feeler.Scene], tool: feeler.Tool, poses: list[Floats], rounds: int, junk: Floats) -> Floats:
    """Median microseconds of a pose in each scene; empties the caches with `junk` before each pass."""
    least = [np.full(len(own), np.inf) for own in poses]
    for _ in range(rounds):
        for scene, own, best in zip(scenes, poses, least, strict=True):
            junk += 1.0
            times = [clock_once(functools.partial(scene.collide, tool, pose))[0] for pose in own]
            np.minimum(best, times, out=best)
    return np.array([np.median(best) for best in least])


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="100k,6.4M", help="two sizes, in triangles (100k,6.4M)")
    parser.add_argument("--tools", default=TOOLS, help=f"({TOOLS})")
    parser.add_argument("--poses", type=int, default=1000, help="of each tool in each mock-up (1000)")
    parser.add_argument("--rounds", type=int, default=5, help="(5)")
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    options = parser.parse_args()
    sizes = [triangles(size) for size in options.sizes.split(",")]
    if len(sizes) != 2:
        parser.error("--sizes takes two sizes")
    scenes = [feeler.Scene(feeler.sample("engine", size), threads=1) for size in sizes]
    lines = [
        "| tool | pairs | caches emptied, µs | growth | caches warm, µs | growth |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    print("\n".join(lines))
    for name in options.tools.split(","):
        tool = feeler.sample_tool(name.removesuffix("-fine"), name.endswith("-fine"))
        poses = [find_poses(scene, tool, "nominal", options.poses) for scene in scenes]
        pairs = [
            float(np.median([len(scene.collide(tool, pose).pairs) for pose in own]))
            for scene, own in zip(scenes, poses, strict=True)
        ]
        row = [name, f"{pairs[1] / max(1.0, pairs[0]):.2f}"]
        for size in (EMPTIED_BYTES, 0):
            small, large = medians(scenes, tool, poses, options.rounds, np.zeros(size // 8))
            row += [f"{small:.1f}, {large:.1f}", f"{large / small:.2f}"]
        lines.append(f"| {' | '.join(row)} |")
        print(lines[-1], flush=True)
    if options.write:
        small, large = (f"{scene.mockup.triangle_count:,}" for scene in scenes)
        note = f"`python bench/growth.py --write`: {small} and {large} triangles in turns, "
        note += f"{options.poses:,} poses, {options.rounds} rounds, {machine()['cpu']}."
        fill(PERFORMANCE, "growth: bench/growth.py", "\n".join([*lines, "", note]))


if __name__ == "__main__":
    main()
