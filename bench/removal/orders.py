"""Removal orders of random assemblies: whether they are valid, and as short as those of an exhaustive search.

    python bench/removal/orders.py                 300 assemblies; some minutes
    python bench/removal/orders.py 40 --first 1000 others, fewer
    python bench/removal/orders.py 1 --first 17    one of them, with the results

Prints a row for each kind of assembly, and each order that is longer or invalid. Assemblies that straight motions along
the axes cannot disassemble are left out. The exit status is 1 if an order is invalid, or if fewer than 95 % are as
short.
"""

from __future__ import annotations

import heapq
import itertools
import sys
import time
from collections import defaultdict
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line

import feeler
from removal.assemblies import Assembly, random_assembly

manifold3d = import_module("manifold3d")  # an extra, without type information

SECONDS = 20.0
SHORT_SHARE = 0.95
POSES = 300
"""Poses at which each step is looked at, at least."""
OVERLAP_SHARE = 1e-7
"""Of a part's volume, that may be in another: what rounding does to flush faces."""
STANDING_COST = 1000

Floats = npt.NDArray[np.float64]


def exhaustive(made: Assembly) -> int | None:
    """The least number of steps, plus `STANDING_COST` for each bolt left in a part that it joins; `None`: no order.

    A step is a set of parts that is free along an axis, of which no smaller set is free. All sets are tried.
    """
    blocks, joined = made.blocks(), made.joined()

    def is_free(parts: frozenset[int], there: frozenset[int]) -> bool:
        others = there - parts
        return any(not any(blocked[part] & others for part in parts) for blocked in blocks.values())

    queue: list[tuple[int, int, frozenset[int]]] = [(0, 0, frozenset(range(made.count)))]
    best = {queue[0][2]: 0}
    number = 0
    while queue:
        cost, _, there = heapq.heappop(queue)
        if made.wanted not in there:
            return cost
        if cost > best[there]:
            continue
        free: list[frozenset[int]] = []
        loose = sorted(there - made.keep)
        for size in range(1, len(loose) + 1):
            for parts in map(frozenset, itertools.combinations(loose, size)):
                if (
                    (parts == there and len(parts) > 1)
                    or any(smaller < parts for smaller in free)
                    or not is_free(parts, there)
                ):
                    continue
                free.append(parts)
                is_bolt = len(parts) == 1 and next(iter(parts)) in made.bolts
                standing = 0 if is_bolt else sum(bool(joined[bolt] & parts) for bolt in made.bolts if bolt in there)
                after, price = there - parts, cost + 1 + STANDING_COST * standing
                if price < best.get(after, price + 1):
                    best[after] = price
                    number += 1
                    heapq.heappush(queue, (price, number, after))
    return None


def cost_of(made: Assembly, order: feeler.RemovalOrder) -> int:
    """The same of an order."""
    joined, gone, cost = made.joined(), set(), 0
    for step in order:
        if not (len(step.parts) == 1 and step.parts[0] in made.bolts):
            cost += STANDING_COST * sum(bool(joined[bolt] & set(step.parts)) for bolt in made.bolts if bolt not in gone)
        gone |= set(step.parts)
        cost += 1
    return cost


def faults(made: Assembly, order: feeler.RemovalOrder) -> list[str]:
    """The faults of an order, by samples of each step: volumes of parts in each other, parts that are not out."""
    solids = [_solid(*mesh) for mesh in made.meshes()]
    found: list[str] = []
    there = set(range(made.count))
    for number, step in enumerate(order):
        moving = set(step.parts)
        found += [
            f"step {number} takes part {part}, which is kept or gone" for part in moving - there | moving & made.keep
        ]
        there -= moving
        poses = _sampled(step.removal.poses, np.concatenate([_box(solids[part]) for part in moving]))
        for part, other in itertools.product(sorted(moving), sorted(there)):
            allowed = OVERLAP_SHARE * solids[part].volume()
            for share, pose in enumerate(poses):
                at = solids[part].transform(pose[:3].tolist())
                if _boxes_meet(at, solids[other]) and (at ^ solids[other]).volume() > allowed:
                    found.append(
                        f"step {number}: part {part} is in part {other} at {share / len(poses):.2f} of the way"
                    )
                    break
        if there:
            ends = [_box(solids[part].transform(poses[-1][:3].tolist())) for part in moving]
            rest = np.concatenate([_box(solids[part]) for part in there])
            ended = np.concatenate(ends)
            if not ((ended.min(0) > rest.max(0) - 1e-9) | (ended.max(0) < rest.min(0) + 1e-9)).any():
                found.append(f"step {number} does not end outside")
    if made.wanted in there:
        found.append("the wanted part is still there")
    return found


def _solid(corners: Floats, faces: npt.NDArray[np.int64]) -> Any:
    return manifold3d.Manifold(manifold3d.Mesh64(np.ascontiguousarray(corners), np.ascontiguousarray(faces, np.uint64)))


def _box(solid: Any) -> Floats:
    return np.array(solid.bounding_box()).reshape(2, 3)


def _boxes_meet(one: Any, other: Any) -> bool:
    a, b = _box(one), _box(other)
    return bool((np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]) > 1e-9).all())


def _sampled(poses: Floats, boxes: Floats) -> Floats:
    """Poses between: the middle of the moving box on a line, turning about it at constant speed."""
    middle = 0.5 * (boxes.min(axis=0) + boxes.max(axis=0))
    each = int(np.ceil(POSES / max(1, len(poses) - 1)))
    found = [poses[0]]
    for begin, end in itertools.pairwise(poses):
        turn = end[:3, :3] @ begin[:3, :3].T
        angle = np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
        axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        axis = axis / np.linalg.norm(axis) if np.linalg.norm(axis) > 1e-12 else np.array([0.0, 0.0, 1.0])
        cross = np.cross(np.eye(3), axis)
        places = [pose[:3, :3] @ middle + pose[:3, 3] for pose in (begin, end)]
        for share in np.linspace(0.0, 1.0, each + 1)[1:]:
            part = share * angle
            # Rodrigues' formula; `cross` is the negative of the axis's matrix.
            rotation = (np.eye(3) - np.sin(part) * cross + (1.0 - np.cos(part)) * cross @ cross) @ begin[:3, :3]
            pose = np.eye(4)
            pose[:3, :3] = rotation
            pose[:3, 3] = places[0] + share * (places[1] - places[0]) - rotation @ middle
            found.append(pose)
    return np.array(found)


@dataclass
class Answer:
    """One assembly."""

    made: Assembly
    least: int
    order: feeler.RemovalOrder
    faults: list[str]
    seconds: float

    @property
    def is_short(self) -> bool:
        """Whether the order costs no more than the best."""
        return self.order.is_found and cost_of(self.made, self.order) <= self.least


def answer(seed: int, seconds: float) -> Answer | None:
    """Of the assembly of a number; `None` where straight motions along the axes do not bring the wanted part out."""
    made = random_assembly(seed)
    least = exhaustive(made)
    if least is None:
        return None
    scene = feeler.Scene(made.mockup(), threads=1)
    begin = time.perf_counter()
    order = feeler.removal_order(scene, made.wanted, seconds=seconds, threads=1, keep=sorted(made.keep) or None)
    took = time.perf_counter() - begin
    return Answer(made, least, order, faults(made, order) if order.is_found else [], took)


def main() -> int:
    """Asks, judges, prints."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("count", nargs="?", type=int, default=300, help="assemblies that come apart (300)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument("--seconds", type=float, default=SECONDS, help=f"for an order ({SECONDS:g})")
    options = parser.parse_args()
    by_kind: dict[str, list[Answer]] = defaultdict(list)
    seeds = itertools.count(options.first)
    done = 0
    while done < options.count:
        seed = next(seeds)
        one = answer(seed, options.seconds)
        if one is None:
            continue
        done += 1
        by_kind[one.made.kind].append(one)
        if one.faults or not one.is_short or options.count == 1:
            steps = [step.parts for step in one.order] if one.order.is_found else "not found"
            print(
                f"{seed}, {one.made.kind}: {one.made.wanted} is wanted, {steps}, at best {one.least}; {one.faults}",
                flush=True,
            )
    print(f"{'kind':22} {'all':>4} {'found':>6} {'valid':>6} {'short':>6} {'median s':>9} {'worst s':>8}")
    everything = [one for answers in by_kind.values() for one in answers]
    for kind, answers in [*sorted(by_kind.items()), ("all", everything)]:
        found = [one for one in answers if one.order.is_found]
        valid, short = sum(not one.faults for one in found), sum(one.is_short for one in answers)
        times = [one.seconds for one in answers]
        print(
            f"{kind:22} {len(answers):4} {len(found):6} {valid:6} {short:6} {np.median(times):9.2f} {max(times):8.2f}"
        )
    bad = any(one.faults for one in everything)
    return int(bad or sum(one.is_short for one in everything) < SHORT_SHARE * len(everything))


if __name__ == "__main__":
    sys.exit(main())
