"""The worst of very many nominal poses, feeler alone: a haptic loop is only as good as its slowest step.

Finding a nominal pose takes some ten to forty queries, so a tenth of the poses are found in the usual way, and the rest
are those turned by up to three degrees and moved by up to a hundredth of the tool's size, where they are still nominal.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from engines import Floats
from measure import clock_once, find_poses, spread

import feeler
from feeler.samples import rigid
from feeler.samples.poses import Searcher

ROUNDS = 3
CHUNK = 500


def worst(scene: feeler.Scene, tool: feeler.Tool, count: int, seed: int) -> dict[str, Any]:
    """Times over `count` nominal poses: of each the least of a few rounds; the worst of those, and of all calls."""
    poses, found = nominal_poses(scene, tool, count, seed)
    wall = np.zeros((ROUNDS, len(poses)))
    for turn in range(ROUNDS):
        for i, pose in enumerate(poses):
            wall[turn, i], _ = clock_once(functools.partial(scene.collide, tool, pose))
    least = wall.min(axis=0)
    slowest = int(least.argmax())
    return {
        "poses": len(poses),
        "poses_found_alone": found,
        "rounds": ROUNDS,
        "wall_us": spread(least) | {"p99_9": float(np.percentile(least, 99.9))},
        "worst_single_call_us": float(wall.max()),
        "over_1_ms": int((least > 1000.0).sum()),
        "slowest_pose": poses[slowest].ravel().tolist(),
        "pairs_at_slowest": len(scene.collide(tool, poses[slowest]).pairs),
    }


def nominal_poses(scene: feeler.Scene, tool: feeler.Tool, count: int, seed: int) -> tuple[Floats, int]:
    """`count` nominal poses, and how many of them were found alone and not beside another."""
    rng = np.random.default_rng([seed, 1])
    searcher = Searcher(scene, tool, rng)
    low, high = searcher.hits
    starts = find_poses(scene, tool, "nominal", max(1, count // 10), seed + 1)[:count]
    found, enough = [starts], len(starts)
    for _ in range(100 + 20 * count // CHUNK):
        if enough >= count:
            break
        nearby = starts[rng.integers(len(starts), size=CHUNK)] @ _small_moves(searcher, rng, CHUNK)
        batch = scene.collide_batch(tool, nearby)
        hits = [len(np.unique(batch[i][:, 0])) for i in range(CHUNK)]
        kept = nearby[[low <= h <= high for h in hits]][: count - enough]
        found.append(kept)
        enough += len(kept)
    return np.concatenate(found), len(starts)


def _small_moves(searcher: Searcher, rng: np.random.Generator, count: int) -> Floats:
    """Random small rigid motions about the tool's middle, in the tool's own frame."""
    moves = np.empty((count, 4, 4))
    middle = searcher.tool_middle
    for move in moves:
        turn = rigid.about(rigid.normalised(rng.normal(size=3)), float(np.radians(rng.uniform(-3.0, 3.0))))
        move[:] = rigid.matrices(turn[None], np.zeros((1, 3)))[0]
        shift = rigid.normalised(rng.normal(size=3)) * (0.01 * searcher.size * rng.random())
        move[:3, 3] = middle - move[:3, :3] @ middle + shift
    return moves
