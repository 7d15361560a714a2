"""Morph targets and skins of glTF, at rest: as stored in the file, without animations.

A morph target moves every vertex by its weight: the node's, or else the mesh's. A skinned mesh is placed by its joints
alone: by the standard, the transform of its own node does not count.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from feeler.io.gltf_document import Document
from feeler.io.placing import IDENTITY, Matrix, multiply


def morphed(
    document: Document, points: NDArray[np.float64], targets: Any, weights: tuple[float, ...]
) -> NDArray[np.float64]:
    """Return the points (n, 3) moved by the morph targets of their primitive."""
    for target, weight in zip(targets, weights, strict=False):
        if not weight or not isinstance(target, dict) or "POSITION" not in target:
            continue
        moves = document.array(target["POSITION"], 3).astype(np.float64)
        if len(moves) != len(points):
            raise document.fail(f"a morph target has {len(moves):,} positions for {len(points):,} vertices")
        with np.errstate(all="ignore"):
            points = points + weight * moves
    return points


def influences(document: Document, attributes: dict[str, Any], count: int) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """Return (joints (n, k), weights (n, k) float64, each row's sum one) of a primitive, or None if it has none."""
    joints: list[NDArray[Any]] = []
    weights: list[NDArray[Any]] = []
    while (key := f"JOINTS_{len(joints)}") in attributes:
        joints.append(document.array(attributes[key], 4).astype(np.int64))
        weights.append(document.array(attributes.get(f"WEIGHTS_{len(weights)}"), 4, normalise=True).astype(np.float64))
        if len(joints[-1]) != count or len(weights[-1]) != count:
            raise document.fail(f"{key} has {len(joints[-1]):,} rows for {count:,} vertices")
    if not joints:
        return None
    joint, weight = np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)
    total = weight.sum(axis=1, keepdims=True)
    weight[total[:, 0] == 0, 0] = 1.0
    return joint, weight / np.where(total == 0, 1.0, total)


def joint_matrices(document: Document, skin: int, worlds: dict[int, Matrix]) -> NDArray[np.float64]:
    """Return the transform of each joint of the skin for vertices: (joints, 4, 4), world_from_mesh."""
    item = document.item("skins", skin)
    joints = item.get("joints")
    if not isinstance(joints, list) or not joints:
        raise document.fail(f"skins[{skin}] has no joints")
    inverse: NDArray[np.float64] | None = None
    if "inverseBindMatrices" in item:
        flat = document.array(item["inverseBindMatrices"], 16).astype(np.float64)
        if len(flat) < len(joints):
            raise document.fail(f"skins[{skin}] has {len(flat)} inverse bind matrices for {len(joints)} joints")
        inverse = flat.reshape(-1, 4, 4).transpose(0, 2, 1)
    made = []
    for number, joint in enumerate(joints):
        if not isinstance(joint, int) or joint not in worlds:
            raise document.fail(f"skins[{skin}] has joint {str(joint)[:20]}, which is not a node of the scene")
        made.append(multiply(worlds[joint], IDENTITY if inverse is None else inverse[number]))
    return np.stack(made)
