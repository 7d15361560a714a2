"""How the median time of a nominal `collide` grows from a small engine to a large one, both measured in turns.

    python bench/claims/growth.py                                100k and 6.4M triangles, into bench/records
    python bench/claims/growth.py --sizes 100k,1.6M --tools torque --rounds 3 --out /tmp/records

`bench/run.py` measures one size after the other, minutes apart; on a shared machine, conditions may have changed in
between. Here both mock-ups are loaded at once, and passes over their poses take turns. Before each pass the caches are
emptied, as other work would do, and each pose is repeated at once, when all its data is in the first caches: the growth
of the second time is work, the rest is memory. For each pose the least time of all rounds counts. The cost of a found
pair is the sum of all poses' times over the sum of their pairs, which is more stable for few poses than medians.
"""

from __future__ import annotations

import argparse
import functools
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import figures
from command_line import triangles
from engines import Floats
from measure import clock_once, find_poses
from options import TOOLS
from record import Origin, Row, elsewhere, keep

import feeler

SIZES, POSES, ROUNDS = "100k,6.4M", 1000, 5
EMPTIED_BYTES = 256 << 20  # more than the caches of most machines


def least_times(
    scenes: list[feeler.Scene], tool: feeler.Tool, poses: list[Floats], rounds: int
) -> list[tuple[Floats, Floats]]:
    """For each scene the least microseconds of each pose, with emptied caches, and repeated at once."""
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


def main() -> None:
    """Measure, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default=SIZES, help=f"two sizes, in triangles ({SIZES})")
    parser.add_argument("--tools", default=TOOLS, help=f"({TOOLS})")
    parser.add_argument("--poses", type=int, default=POSES, help=f"of each tool in each mock-up ({POSES})")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"({ROUNDS})")
    parser.add_argument("--out", type=Path, help="folder of the record, whatever this run is worth")
    options = parser.parse_args()
    sizes = [triangles(size) for size in options.sizes.split(",")]
    if len(sizes) != 2:
        parser.error("--sizes takes two sizes")
    origin = Origin.here(feeler.__version__)
    standard = (options.sizes, options.poses, options.rounds) == (SIZES, POSES, ROUNDS)
    reasons = [*([] if standard else ["sizes, poses or rounds are not the usual ones"]), *origin.reasons_against()]
    scenes = [feeler.Scene(feeler.sample("engine", size), threads=1) for size in sizes]
    rows: list[Row] = []
    for name in options.tools.split(","):
        tool = feeler.sample_tool(name.removesuffix("-fine"), name.endswith("-fine"))
        poses = [find_poses(scene, tool, "nominal", options.poses) for scene in scenes]
        pairs = [
            np.array([len(scene.collide(tool, pose).pairs) for pose in own], float)
            for scene, own in zip(scenes, poses, strict=True)
        ]
        times = least_times(scenes, tool, poses, options.rounds)
        for size, scene, found, (cold, again) in zip(sizes, scenes, pairs, times, strict=True):
            row: Row = {"what": "growth", "size": size, "tool": name, "kind": "nominal", "query": "collide"}
            row |= {"engine": "feeler", "version": feeler.__version__, "triangles": scene.mockup.triangle_count}
            row |= {"parts": scene.mockup.part_count, "tool_triangles": tool.triangle_count, "poses": len(cold)}
            row |= {"rounds": options.rounds, "pairs": float(np.median(found)), "median_us": float(np.median(cold))}
            row |= {"again_us": float(np.median(again)), "pair_ns": float(1e3 * cold.sum() / found.sum())}
            rows.append(row | {"again_pair_ns": float(1e3 * again.sum() / found.sum())})
    marked = origin.marked(rows)
    if table := figures.growth(marked):
        print(table.markdown())
    if reasons and not options.out:
        print(elsewhere(reasons))
    print(f"Written: {keep(marked, origin, options.out, reasons)}")


if __name__ == "__main__":
    main()
