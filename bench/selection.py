"""What queries cost in a scene without some parts, beside the whole one, and how long it takes to make.

    python bench/selection.py [TRIANGLES]

Prints for each query the ratio of its time to that in the whole scene, as the median over poses of the best of a few
rounds, and what the scenes without parts take to make. One thread; the sample engine and a wrench.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import feeler

ROUNDS = 15
POSES = 60
QUERIES = ("collide", "is_colliding", "clearance", "distance", "contacts")


def best_of(calls: list[Callable[[], object]], rounds: int = ROUNDS) -> np.ndarray:
    """Seconds of each call, the best of some rounds; in turns, so that what disturbs one disturbs all."""
    best = np.full(len(calls), np.inf)
    for _ in range(rounds):
        for i, call in enumerate(calls):
            start = time.perf_counter()
            call()
            best[i] = min(best[i], time.perf_counter() - start)
    return best


def main() -> None:
    triangles = int(sys.argv[1]) if len(sys.argv) > 1 else 1_600_000
    mockup = feeler.sample("engine", triangles)
    tool = feeler.sample_tool("wrench")
    whole = feeler.Scene(mockup, tool=tool, threads=1)
    nominal = feeler.sample_poses(whole, tool, "nominal", POSES, seed=1)
    few = np.arange(3, mockup.part_count, mockup.part_count // 5)
    selections = {
        "without five parts": lambda: whole.without(few),
        "without every second part": lambda: whole.without(np.arange(0, mockup.part_count, 2)),
        "every hundredth part alone": lambda: whole.only(np.arange(0, mockup.part_count, 100)),
        "five parts alone": lambda: whole.only(few),
    }
    print(f"{mockup.triangle_count:,} triangles, {mockup.part_count:,} parts, {len(nominal)} poses")
    made = best_of(list(selections.values()))
    print(f"{'':28s}{'made in, ms':>12s}" + "".join(f"{query:>14s}" for query in QUERIES))
    for (name, make), seconds in zip(selections.items(), made, strict=True):
        some = make()
        ratios = []
        for query in QUERIES:
            calls = [(lambda s=s, p=p: getattr(s, query)(tool, p)) for p in nominal for s in (whole, some)]
            times = best_of(calls).reshape(-1, 2)
            ratios.append(np.median(times[:, 1]) / np.median(times[:, 0]))
        print(f"{name:28s}{1e3 * seconds:12.2f}" + "".join(f"{ratio:14.3f}" for ratio in ratios))


if __name__ == "__main__":
    main()
