"""Certified bounds against random positions: none may be above the truth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import feeler
from feeler import Joint, JointCoupling, JointKind, Mechanism

from .misses import cuboid
from .steppers import Floats

Result = dict[str, Any]
SLACK_M = 1e-9
"""Rounding of poses."""
STILL = 1e-9
"""What changes by less is rounding: links that do not move against each other have no gap that is asked."""
RANGES = {"p": (-0.4, 0.5), "q": (-0.3, 0.3), "r": (-0.3, 0.4)}


def measured(mechanisms: int, positions: int, seed: int) -> Result:
    """Random arms of three links among three bodies, with one, two and three joints that move, and coupled."""
    rng = np.random.default_rng(seed)
    kinds: dict[str, Result] = {}
    while sum(row["mechanisms"] for row in kinds.values()) < mechanisms:
        number = sum(row["mechanisms"] for row in kinds.values())
        kind = ("one joint", "two joints", "three joints, coupled")[number % 3]
        moved = _arm(rng, kind)
        if moved is None:
            continue
        names = ("p", "r") if kind == "two joints" else ("p",)
        found = moved.clearance({name: RANGES[name] for name in names}, error=2e-3, most=20_000)
        drawn = [{name: float(rng.uniform(*RANGES[name])) for name in names} for _ in range(positions)]
        truth = _least(moved, drawn)
        row = kinds.setdefault(
            kind, {"mechanisms": 0, "positions": 0, "above": 0, "free": 0, "undecided": 0, "widest": 0.0, "missed": 0.0}
        )
        row["mechanisms"] += 1
        row["positions"] += positions
        row["above"] += int((truth < found.lower - SLACK_M).sum())
        row["free"] += int(found.lower > 0.0)
        row["undecided"] += int(found.undecided > 0.0)
        row["widest"] = max(row["widest"], found.upper - found.lower if found.undecided == 0.0 else 0.0)
        row["missed"] = max(row["missed"], float(truth.min()) - found.upper)
    return {"seed": seed, "kinds": [{"kind": kind, **row} for kind, row in kinds.items()]}


def _arm(rng: np.random.Generator, kind: str) -> Mechanism | None:
    """None if its bodies touch where they are modelled: that would be a seat."""
    low, size = rng.uniform(-1, 1, (6, 3)), rng.uniform(0.1, 0.5, (6, 3))
    meshes = [cuboid(a, a + b, float(rng.uniform(0, 3))) for a, b in zip(low, size, strict=True)]
    vertices = np.concatenate([mesh[0] for mesh in meshes])
    faces = np.concatenate([mesh[1] + 8 * n for n, mesh in enumerate(meshes)])
    mockup = feeler.Mockup(vertices, faces, np.repeat(np.arange(6), 12), list("abcdef"))
    kinds = rng.choice(["revolute", "prismatic", "screw"], 3)
    joints = []
    for name, word, parent, part in zip("pqr", kinds, (None, "a", "b"), "abc", strict=True):
        pitch = 0.4 if word == "screw" else 0.0
        joints.append(Joint(name, JointKind(str(word)), parent, part, _vector(rng), _vector(rng), pitch=pitch))
    coupled = [JointCoupling("q", "p", 0.6), JointCoupling("r", "p", -1.1)] if kind.endswith("coupled") else []
    moved = Mechanism(mockup, joints, coupled)
    return moved if _least(moved, [moved.position()], of_all=True)[0] > 0.0 else None


def _vector(rng: np.random.Generator) -> tuple[float, float, float]:
    x, y, z = (float(each) for each in rng.uniform(-1.0, 1.0, 3))
    return x, y, z


def _least(moved: Mechanism, positions: list[dict[str, float]], of_all: bool = False) -> Floats:
    """The least gap of bodies that move against each other, at positions."""
    scene = moved.scene()
    poses = [moved.poses(each) for each in positions]
    placed = {part: np.array([each[name] for each in poses]) for part, name in zip("abc", "pqr", strict=True)}
    back = {part: np.linalg.inv(each) for part, each in placed.items()}
    found = np.full(len(positions), math.inf)
    for part, pose in placed.items():
        tool = feeler.Tool.of_parts(moved.mockup, part)
        found = np.minimum(found, scene.only(["d", "e", "f"]).distance_batch(tool, pose).values)
        for other in "ab"[: "abc".index(part)]:
            relative = back[other] @ pose
            if of_all or np.ptp(relative, axis=0).max() > STILL:
                found = np.minimum(found, scene.only(other).distance_batch(tool, relative).values)
    return found
