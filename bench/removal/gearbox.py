"""For how many disassembly steps of the sample gearbox `feeler.removal` finds a path, after the preceding steps.

    python bench/removal/gearbox.py                        100,000 triangles, 2 s a step; some minutes
    python bench/removal/gearbox.py 250000 --seed 1
    python bench/removal/gearbox.py --overlap 0.0009        let pairs overlap by up to 0.9 mm

Lists the steps without a path, with their blockers. Steps that bend a part, and steps that only loosen one, are left
out. If a door is open, the parts that turn with it count as removed. feeler's path may differ from the known one.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line
from command_line import triangles

import feeler


def main() -> None:
    """Goes through the steps."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("triangles", nargs="?", type=triangles, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=2.0, help="most time of a step")
    parser.add_argument("--overlap", type=float, default=0.0, help="metres by which pairs may overlap")
    options = parser.parse_args()
    scene = feeler.Scene(feeler.sample("gearbox", options.triangles, options.seed))
    truth = feeler.sample_truth("gearbox", options.triangles, options.seed)
    door = next(joint.parts for joint in truth.joints if joint.name == "door")
    times, missed = [], 0
    for step in truth.steps:
        if not (step.removes and step.rigid):
            continue
        out = {path for earlier in truth.needed(step) if earlier.removes for path in earlier.parts}
        out |= set(door) if step.door_open else set()
        moving = [path for path in step.parts if path not in out]
        start = time.perf_counter()
        found = feeler.removal(
            scene.without(sorted(out)), moving, overlap=options.overlap, seconds=options.seconds, threads=1
        )
        if found.is_found:
            times.append(time.perf_counter() - start)
            continue
        missed += 1
        legs = ", ".join(leg.kind for leg in step.legs)
        print(f"not found: {step.parts[0]} ({legs}), blocked by {[each.path for each in found.blocked_by[:3]]}")
    print(f"{len(times)} of {len(times) + missed} steps found, {np.median(times) * 1e3:.0f} ms in the median")


if __name__ == "__main__":
    main()
