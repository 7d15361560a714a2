"""Disassembles the sample gearbox by `feeler.removal_order`, one part after the other.

    python bench/removal/apart.py                  100,000 triangles, 10 minutes
    python bench/removal/apart.py 250000 --seconds 1200
    python bench/removal/apart.py --of gearbox/oil_pump/body --of gearbox/starter/gasket

Prints the parts removed in each round, and at the end how many parts came out after all that the gearbox's known order
requires before them. An order may differ from the known one and be right: each path was verified. `--of`: the orders of
these parts instead, each in the whole gearbox, and how many parts of the known order are among theirs.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line
import numpy as np
from command_line import triangles

import feeler

ROUND_S = (0.5, 2.0, 8.0, 32.0)
"""Seconds for a part in each round; the last is repeated as long as parts come out."""


def main() -> None:
    """Goes through the parts, the small ones first, round after round."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("triangles", nargs="?", type=triangles, default=100_000)
    parser.add_argument("--seconds", type=float, default=600.0, help="for all of it; with --of, for each (600)")
    parser.add_argument("--of", action="append", metavar="PATH", help="the order of this part (several)")
    options = parser.parse_args()
    mockup = feeler.sample("gearbox", options.triangles)
    scene = feeler.Scene(mockup, threads=1)
    truth = feeler.sample_truth("gearbox", options.triangles)
    if options.of:
        for path in options.of:
            one(scene, truth, path, options.seconds)
        return
    begin = time.perf_counter()
    lower, upper = mockup.part_bounds[0::2], mockup.part_bounds[1::2]
    by_size = np.argsort(np.linalg.norm(upper - lower, axis=1)).tolist()
    gone: list[int] = []
    for number in range(99):
        before = len(gone)
        limit = ROUND_S[min(number, len(ROUND_S) - 1)]
        for part in by_size:  # the cases last: casts of them take long
            left = options.seconds - (time.perf_counter() - begin)
            if left <= 0.0 or len(gone) >= mockup.part_count - 1:
                break
            if part not in gone:
                there = scene.without(gone) if gone else scene
                order = feeler.removal_order(there, part, seconds=min(limit, left), threads=1)
                gone += order.parts if order.is_found else ()
        spent = time.perf_counter() - begin
        print(
            f"round {number + 1}: {len(gone) - before} parts, {len(gone)} of {mockup.part_count}, {spent:.0f} s",
            flush=True,
        )
        if spent >= options.seconds or (len(gone) == before and number >= len(ROUND_S) - 1):
            break
    agreed, known = agreement(mockup, truth, gone)
    print(f"{agreed} of {known} parts came out after all that the truth wants gone before them")


def agreement(mockup: feeler.Mockup, truth: object, gone: list[int]) -> tuple[int, int]:
    """How many of the parts came out after all that the truth wants gone before, and of how many it says so."""
    place = {mockup.part_paths[part]: number for number, part in enumerate(gone)}
    agreed = known = 0
    for step in truth.steps:  # type: ignore[attr-defined]
        if not step.removes or step.parts[0] not in place:
            continue
        known += 1
        needed = [path for earlier in truth.needed(step) if earlier.removes for path in earlier.parts]  # type: ignore[attr-defined]
        agreed += all(place.get(path, len(place)) < place[step.parts[0]] for path in needed)
    return agreed, known


def one(scene: feeler.Scene, truth: object, path: str, seconds: float) -> None:
    """Prints the order of one part beside the truth's."""
    begin = time.perf_counter()
    order = feeler.removal_order(scene, path, seconds=seconds, threads=1)
    took = time.perf_counter() - begin
    needed = {each for step in truth.way(path) if step.removes for each in step.parts}  # type: ignore[attr-defined]
    taken = {scene.mockup.part_paths[part] for part in order.parts}
    print(
        f"{path}: {order}, {len(taken)} parts; {len(needed & taken)} of the {len(needed)} of the truth; {took:.1f} s",
        flush=True,
    )


if __name__ == "__main__":
    main()
