"""How the median time of a nominal `collide` grows from a small engine to a large one, both asked in turns.

    python bench/growth.py --write                        and put the table into docs/performance.md
    python bench/growth.py --sizes 100k,1.6M --tools torque --rounds 3

`bench/run.py` measures one size after the other, minutes apart, and has that from its record; a machine that others use
may have changed in between. Here both mock-ups are there at once and passes over their poses take turns. Before each
pass the caches are emptied, as other work would, and each pose is asked again at once, when all that it reads is in the
first caches: what then grows is work, the rest is memory. Of each pose the least time of all rounds counts. What a pair
found costs is the sum of all poses' times over the sum of their pairs, which few poses tell better than medians do.
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


def least_times(
    scenes: list[feeler.Scene], tool: feeler.Tool, poses: list[Floats], rounds: int
) -> list[tuple[Floats, Floats]]:
    """For each scene the least microseconds of each pose, after the caches were emptied, and asked again at once."""
    junk = np.zeros(EMPTIED_BYTES // 8)
    least = [(np.full(len(own), np.inf), np.full(len(own), np.inf)) for own in poses]
    for _ in range(rounds):
        for scene, own, best in zip(scenes, poses, least, strict=True):
            junk += 1.0
            for i, pose in enumerate(own):
                ask = functools.partial(scene.collide, tool, pose)
                for times in best:
                    times[i] = min(times[i], clock_once(ask)[0])
    return least


def _of_both(small_and_large: list[float], digits: str) -> list[str]:
    small, large = small_and_large
    return [f"{small:{digits}}, {large:{digits}}", f"{large / max(small, 1e-9):.2f}"]


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
        "| tool | pairs, median | growth | caches emptied, µs, median | growth | asked again, µs, median | growth "
        "| a pair found, ns, caches emptied | asked again |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    print("\n".join(lines))
    for name in options.tools.split(","):
        tool = feeler.sample_tool(name.removesuffix("-fine"), name.endswith("-fine"))
        poses = [find_poses(scene, tool, "nominal", options.poses) for scene in scenes]
        pairs = [
            np.array([len(scene.collide(tool, pose).pairs) for pose in own], float)
            for scene, own in zip(scenes, poses, strict=True)
        ]
        times = least_times(scenes, tool, poses, options.rounds)
        row = [name, *_of_both([float(np.median(found)) for found in pairs], ".0f")]
        each = []
        for k in range(2):
            row += _of_both([float(np.median(own[k])) for own in times], ".1f")
            each.append([1e3 * own[k].sum() / found.sum() for own, found in zip(times, pairs, strict=True)])
        row += [f"{small:.0f}, {large:.0f}" for small, large in each]
        lines.append(f"| {' | '.join(row)} |")
        print(lines[-1], flush=True)
    if options.write:
        small, large = (f"{scene.mockup.triangle_count:,}" for scene in scenes)
        note = f"`python bench/growth.py --write`: {small} and {large} triangles in turns, "
        note += f"{options.poses:,} poses, {options.rounds} rounds, {machine()['cpu']}."
        fill(PERFORMANCE, "growth: bench/growth.py", "\n".join([*lines, "", note]))


if __name__ == "__main__":
    main()
