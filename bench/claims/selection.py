"""The cost of queries in a scene without some parts, relative to the whole scene, and the time to make it.

Prints for each query the ratio of its time to that in the whole scene, as the median over poses of the best of a few
rounds, and the time to make the scenes without parts. One thread; the sample engine and a wrench.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial

import numpy as np

import feeler
from feeler.study.timing import least_in_turns

QUERIES = ("collide", "is_colliding", "clearance", "distance", "contacts")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--triangles", type=int, default=1_600_000, help="of the sample engine")
    parser.add_argument("--poses", type=int, default=60, help="at which some of the wrench's triangles meet")
    parser.add_argument("--rounds", type=int, default=15, help="of each call, of which the best counts")
    options = parser.parse_args()
    mockup = feeler.sample("engine", options.triangles)
    tool = feeler.sample_tool("wrench")
    whole = feeler.Scene(mockup, tool=tool, threads=1)
    nominal = feeler.sample_poses(whole, tool, "nominal", options.poses, seed=1)
    few = np.arange(3, mockup.part_count, mockup.part_count // 5)
    selections: dict[str, Callable[[], feeler.Scene]] = {
        "without five parts": lambda: whole.without(few),
        "without every second part": lambda: whole.without(np.arange(0, mockup.part_count, 2)),
        "every hundredth part alone": lambda: whole.only(np.arange(0, mockup.part_count, 100)),
        "five parts alone": lambda: whole.only(few),
    }
    print(f"{mockup.triangle_count:,} triangles, {mockup.part_count:,} parts, {len(nominal)} poses")
    made = least_in_turns(*selections.values(), rounds=options.rounds)
    print(f"{'':28s}{'made in, ms':>12s}" + "".join(f"{query:>14s}" for query in QUERIES))
    for (name, make), seconds in zip(selections.items(), made, strict=True):
        some = make()
        ratios = []
        for query in QUERIES:
            asks = [getattr(scene, query) for scene in (whole, some)]
            calls = [partial(ask, tool, pose) for pose in nominal for ask in asks]
            times = np.array(least_in_turns(*calls, rounds=options.rounds)).reshape(-1, 2)
            ratios.append(np.median(times[:, 1]) / np.median(times[:, 0]))
        print(f"{name:28s}{1e3 * seconds:12.2f}" + "".join(f"{ratio:14.3f}" for ratio in ratios))


if __name__ == "__main__":
    main()
