"""How long a scene with moved parts takes to make, and its queries beside those of a scene indexed anew.

    python bench/mechanism/moved_scene.py [--quick]

Moves 1 % of the parts of the sample engine, one thread. Prints milliseconds: the first scene, the median of later
ones, a scene indexed anew, and `collide_batch` and `clearance_batch` in both.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import feeler


def milliseconds(work: Callable[[], Any]) -> tuple[float, Any]:
    """The time of one call, and its result."""
    start = time.perf_counter()
    result = work()
    return 1e3 * (time.perf_counter() - start), result


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a small engine, few repeats")
    quick = parser.parse_args().quick
    mockup = feeler.sample("engine", 75_000 if quick else 1_600_000)
    scene = feeler.Scene(mockup, threads=1)
    rng = np.random.default_rng(1)
    parts = tuple(rng.choice(mockup.part_count, max(1, mockup.part_count // 100), replace=False).tolist())

    def at(angle: float) -> np.ndarray:
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        return pose

    mockup.parts.select(parts)  # names are indexed once
    first, moved = milliseconds(lambda: scene.moved({parts: at(0.1)}))
    later = []
    for number in range(5 if quick else 30):
        del moved
        took, moved = milliseconds(partial(scene.moved, {parts: at(0.2 + 0.01 * number)}))
        later.append(took)
    took_anew, anew = milliseconds(lambda: feeler.Scene(moved.mockup, threads=1))
    triangles = int(mockup.part_triangles[list(parts)].sum())
    print(f"{mockup.triangle_count:,} triangles, {len(parts)} of {mockup.part_count:,} parts with {triangles:,} move")
    print(
        f"scene: first {first:.1f} ms, median of later ones {statistics.median(later):.1f} ms; anew {took_anew:.0f} ms"
    )
    tool = feeler.Tool.of_parts(mockup, [int(np.argsort(mockup.part_triangles)[mockup.part_count // 2])])
    lower, upper = mockup.bounds
    poses = np.repeat(np.eye(4)[None], 200 if quick else 2_000, axis=0)
    centre = np.asarray(tool.bounds).mean(axis=0)
    poses[:, :3, 3] = rng.uniform(lower, upper, (len(poses), 3)) - centre
    for name, ask in (
        ("collide_batch", lambda s: s.collide_batch(tool, poses)),
        ("clearance_batch", lambda s: s.clearance_batch(tool, poses, 0.005)),
    ):
        times: dict[str, list[float]] = {"base": [], "moved": [], "anew": []}
        for _ in range(3 if quick else 7):
            for kind, asked in (("base", scene), ("moved", moved), ("anew", anew)):
                times[kind].append(milliseconds(partial(ask, asked))[0])
        print(name, ", ".join(f"{kind} {min(each):.1f} ms" for kind, each in times.items()))


if __name__ == "__main__":
    main()
