"""Threads that are drawn without flanks: a bolt as wide as its thread, in a hole as wide as its core."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from feeler.mechanism.rounds import THREAD
from feeler.mechanism.surfaces import Cylinder
from feeler.part_meshes import PartMeshes

Floats = npt.NDArray[np.float64]

_COAXIAL_RAD = 0.01
_BESIDE = 0.02
"""A bolt is out of line with its hole by this share of its radius at most: neither has play."""
_LEAST = 0.8
"""The least length of a thread, in radii."""
_WIDER = (1.2, 4.0)
"""The radius of a head, in those of its bolt."""
_NUT = 2.6
"""The largest radius of a nut, in those of its bolt."""
_FLAT_RAD = 0.02
_FLATS = 0.8
"""The least share of six flats in the outside of a nut."""


def drawn_threads(
    meshes: PartMeshes, child: Sequence[Cylinder], parent: Sequence[Cylinder]
) -> list[tuple[Cylinder, Cylinder]]:
    """The pairs of cylinders of child and parent that are a bolt and its hole.

    One with a head beyond the hole is a bolt, and what has six flats around the hole a nut: all else may be a pin that
    was pressed in by mistake.
    """
    found = []
    for one in child:
        for other in parent:
            bolt, hole = (other, one) if one.is_hole else (one, other)
            if _are_in_each_other(bolt, hole) and (_has_head(meshes, bolt, hole) or _is_nut(meshes, bolt, hole)):
                found.append((one, other))
    return found


def _are_in_each_other(bolt: Cylinder, hole: Cylinder) -> bool:
    if bolt.is_hole or not hole.is_hole or not (1.0 - THREAD) * bolt.radius <= hole.radius < bolt.radius:
        return False
    off = hole.point - bolt.point
    along = abs(float(off @ bolt.axis))
    shared = min(0.5 * (bolt.length + hole.length) - along, bolt.length, hole.length)
    return (
        float(np.linalg.norm(np.cross(bolt.axis, hole.axis))) < _COAXIAL_RAD
        and float(np.linalg.norm(np.cross(off, bolt.axis))) < _BESIDE * bolt.radius
        and shared > _LEAST * bolt.radius
    )


def _polar(meshes: PartMeshes, part: int, bolt: Cylinder) -> tuple[Floats, Floats]:
    """The heights and radii of the corners of a part about the axis of a bolt: `(m, 3)`."""
    off = meshes.corners(part) - bolt.point
    height = off @ bolt.axis
    return height, np.linalg.norm(off - height[..., None] * bolt.axis, axis=-1)


def _has_head(meshes: PartMeshes, bolt: Cylinder, hole: Cylinder) -> bool:
    """Whether the part of a bolt is wider beyond one end of the hole, and nowhere else."""
    height, radius = _polar(meshes, bolt.part, bolt)
    wide = radius > _WIDER[0] * bolt.radius
    if not wide.any() or radius.max() > _WIDER[1] * bolt.radius:
        return False
    middle, slack = float((hole.point - bolt.point) @ bolt.axis), 1e-3 * bolt.radius
    above, below = (sign * (height[wide] - middle) >= 0.5 * hole.length - slack for sign in (1.0, -1.0))
    return bool(above.all() or below.all())


def _is_nut(meshes: PartMeshes, bolt: Cylinder, hole: Cylinder) -> bool:
    """Whether the part of a hole is a hexagon around it."""
    _, radius = _polar(meshes, hole.part, bolt)
    if radius.max() > _NUT * bolt.radius:
        return False
    corners = meshes.corners(hole.part)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    outside = (np.abs(normal @ bolt.axis) < 1e-3 * twice) & (radius.min(axis=1) > _WIDER[0] * bolt.radius)
    normal, twice = normal[outside], twice[outside]
    if not len(normal):
        return False
    first = normal[np.argmax(twice)] / twice.max()
    at = np.arctan2(normal @ np.cross(bolt.axis, first), normal @ first) / (math.pi / 3.0)
    is_flat = np.abs(at - np.round(at)) * (math.pi / 3.0) < _FLAT_RAD
    sides = np.unique(np.round(at[is_flat]).astype(np.int64) % 6)
    return len(sides) == 6 and float(twice[is_flat].sum()) > _FLATS * float(twice.sum())
