"""From where a finding is seen: the side on which least is in the way."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from feeler.clashes.sides import directions
from feeler.picture.camera import upright_frame
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.finding_table import FindingTable
from feeler.workbench.document.motion import Floats, Row
from feeler.workbench.document.protocol_findings import FindingSide
from feeler.workbench.engine.parts import PartTools

USUAL = np.array([0.62, -0.66, 0.42])
"""From the right, the front and above: preferred where nothing else decides."""
_INSIDE = 0.6  # of the smaller part's box that lies in the larger one's, for that to cover it
_LARGER = 1.25  # times the diagonal
_NEAR = 0.02  # of the reach: what is nearer to the point than this hides nothing


def side_of(
    table: FindingTable, row: int, scene: Scene, meshes: PartTools, moved: Mapping[int, Row]
) -> FindingSide | None:
    """The direction from the contact to the eye, and the part that covers the other; None if no part is here."""
    parts = [int(table.part_of_path[side[row]]) for side in (table.a, table.b)]
    here = [part for part in parts if part >= 0]
    if not here:
        return None
    point = _point(table, row, [_box(scene, part, moved) for part in here])
    depth = float(np.nan_to_num(table.depth[row]))
    return side_of_pair(parts, point, depth, np.nan_to_num(table.translation[row]), scene, meshes, moved)


def side_of_pair(
    parts: list[int],
    point: Floats,
    depth: float,
    way: Floats,
    scene: Scene,
    meshes: PartTools,
    moved: Mapping[int, Row],
) -> FindingSide:
    """The same of two parts (-1: not here) that are so deep in each other at a point, with a way out."""
    here = [part for part in parts if part >= 0]
    boxes = {part: _box(scene, part, moved) for part in here}
    cover = _cover(parts, boxes)
    low, high = np.min([box[0] for box in boxes.values()], axis=0), np.max([box[1] for box in boxes.values()], axis=0)
    reach = max(2.0 * float(np.linalg.norm(high - low)), 1e-6)
    up = scene.mockup.source.vertical
    usual = USUAL / np.linalg.norm(USUAL) @ np.stack(upright_frame(up))
    sides = directions(usual, up)
    hidden = np.zeros(len(sides))
    for each in _scenes([part for part in here if part != cover], scene, meshes, moved):
        rays = each.rays(point + reach * sides, -sides)
        met = np.where(rays.triangles >= 0, reach - rays.distances, 0.0)
        hidden = np.maximum(hidden, met)
    in_way = np.maximum(0.0, hidden - _NEAR * reach - 2.0 * depth) / reach
    size = float(np.linalg.norm(way))
    across = 1.0 - np.abs(sides @ (way / size)) if size > 0.0 else np.zeros(len(sides))
    best = sides[int(np.argmax(-4.0 * in_way - 2.0 * (in_way > 0.0) + 0.5 * across + 0.4 * (sides @ usual)))]
    return {"direction": (float(best[0]), float(best[1]), float(best[2])), "cover": cover}


def _scenes(parts: list[int], scene: Scene, meshes: PartTools, moved: Mapping[int, Row]) -> list[Scene]:
    home = [part for part in parts if part not in moved]
    return [
        *([scene.only(home)] if home else []),
        *(meshes.lying(part, moved[part]) for part in parts if part in moved),
    ]


def _box(scene: Scene, part: int, moved: Mapping[int, Row]) -> Floats:
    box = np.array(scene.mockup.part_bounds.reshape(-1, 2, 3)[part], dtype=np.float64)
    if part not in moved:
        return box
    pose = motion.matrix(moved[part])
    there = motion.corners(box) @ pose[:3, :3].T + pose[:3, 3]
    return np.stack([there.min(axis=0), there.max(axis=0)])


def _cover(parts: list[int], boxes: Mapping[int, Floats]) -> int | None:
    """The part around the other one, if one is: it is drawn see-through."""
    if len(parts) < 2 or parts[0] == parts[1] or any(part not in boxes for part in parts):
        return None
    small, large = sorted(parts, key=lambda part: float(np.linalg.norm(boxes[part][1] - boxes[part][0])))
    one, other = boxes[small], boxes[large]
    sizes = np.maximum(one[1] - one[0], 1e-12)
    shared = np.clip(np.minimum(one[1], other[1]) - np.maximum(one[0], other[0]), 0.0, None)
    is_larger = np.linalg.norm(other[1] - other[0]) > _LARGER * np.linalg.norm(one[1] - one[0])
    return large if is_larger and float(np.prod(np.minimum(1.0, shared / sizes))) > _INSIDE else None


def _point(table: FindingTable, row: int, boxes: list[Floats]) -> Floats:
    points = np.stack([table.point_a[row], table.point_b[row]])
    known = points[np.isfinite(points).all(axis=1)]
    if len(known):
        return np.asarray(known.mean(axis=0))
    low, high = np.max([box[0] for box in boxes], axis=0), np.min([box[1] for box in boxes], axis=0)
    return np.asarray((low + high) / 2)
