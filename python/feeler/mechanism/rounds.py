"""Round surfaces about the axis of a joint: pins and holes whose facets cross while the round ones only turn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

CLEAR_M = 2e-6
"""How far the facets of a pin are kept off those of its hole: more than what counts as touching."""
_WIDER = 2.05
"""A facet that is wider than all narrower ones by this factor is not one of theirs: the flat of a D-shaft."""
_STEP = 0.88
"""The widest facet, radians: prisms of eight sides are round, those of seven have edges that stop them."""
_ARC = 1.5
"""The least arc that facets side by side make up, radians: less is a flat face that is square to its radius."""
_FEWEST = 4
_UPRIGHT = 1e-3  # cosine of a facet's normal with the axis
_SAME = 2e-4  # differences of radii on one surface, as a share of them: axes are found
_GRID_M, _GRID_SHARE = 1e-6, 5e-3  # and beside it: files are rounded; by a share at most, where all is small
_PRESS = 1.1  # a pin is wider than its hole by this factor at most


@dataclass(frozen=True)
class Round:
    """Facets of one cylinder about the axis. Metres and radians."""

    radius: float
    """The largest of the corners."""
    least: float
    """The least of the corners."""
    step: float
    """The widest facet."""
    low: float
    high: float
    """Along the axis."""
    is_hole: bool

    @property
    def inner(self) -> float:
        """The least radius of its facets."""
        return self.least * math.cos(0.5 * self.step)


def polar(vertices: Floats, axis: Floats, point: Floats) -> tuple[Floats, Floats, Floats]:
    """Height, radius and bearing of points about an axis."""
    u = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    u /= np.linalg.norm(u)
    off = vertices - point
    x, y = off @ u, off @ np.cross(axis, u)
    return off @ axis, np.hypot(x, y), np.arctan2(y, x)


def rounds_of(
    vertices: Floats, faces: Ints, axis: Floats, point: Floats, near: Sequence[Round] | None = None
) -> list[Round]:
    """The cylinders about an axis. near: look for those beside these alone."""
    height, radius, bearing = polar(vertices, axis, point)
    if near is not None:
        kept = np.zeros(len(vertices), dtype=bool)
        for each in near:
            slack = 0.2 * each.radius
            kept |= np.abs(radius - each.radius) <= slack
        faces = faces[kept[faces].all(axis=1)]
    if not len(faces):
        return []
    of = radius[faces]
    mean = of.mean(axis=1)
    same = (np.ptp(of, axis=1) <= _slack(mean)) & (mean > 0.0)
    faces, mean = faces[same], mean[same]
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    turned = bearing[faces] - bearing[faces[:, :1]]
    turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
    span = np.ptp(turned, axis=1)
    upright = np.abs(normal @ axis) <= _UPRIGHT * twice
    kept = upright & (twice > 0.0) & (span > 1e-9) & (span <= _STEP)
    faces, mean, turned, span, normal = (each[kept] for each in (faces, mean, turned, span, normal))
    middle = vertices[faces].mean(axis=1) - point
    is_hole = np.einsum("ij,ij->i", normal, middle - np.outer(middle @ axis, axis)) < 0.0
    low_bearing = bearing[faces[:, 0]] + turned.min(axis=1)
    order = np.lexsort((mean, is_hole))
    found = []
    tall = np.sort(height[faces], axis=1)
    alike = (wide for same in _same_radii(order, mean, is_hole) for wide in _same_widths(same, span))
    for group in (run for wide in alike for run in _runs(wide, tall[:, 0], tall[:, 2])):
        if _longest_arc(low_bearing[group], span[group]) < _ARC:
            continue
        if len(np.unique(np.round(low_bearing[group], 4))) < _FEWEST:
            continue
        heights = height[faces[group]]
        found.append(
            Round(
                float(radius[faces[group]].max()),
                float(radius[faces[group]].min()),
                float(span[group].max()),
                float(heights.min()),
                float(heights.max()),
                bool(is_hole[group[0]]),
            )
        )
    return found


def _slack(radius: Floats) -> Floats:
    """How much radii on one surface may differ, metres."""
    return np.asarray(_SAME * radius + np.minimum(_GRID_M, _GRID_SHARE * radius) + 1e-9)


def _same_radii(order: Ints, mean: Floats, is_hole: npt.NDArray[np.bool_]) -> Iterator[Ints]:
    """Facets of one radius each, of pins and of holes: an oval has many. order: by that, and by radius."""
    for side in np.split(order, np.flatnonzero(np.diff(is_hole[order])) + 1) if len(order) else []:
        radii, start = mean[side], 0
        while start < len(side):
            end = int(np.searchsorted(radii, radii[start] + _slack(radii[start]), "right"))
            yield side[start:end]
            start = end


def _same_widths(facets: Ints, span: Floats) -> list[Ints]:
    """Facets of one radius by their width: those of a cylinder are alike, also where files make them uneven."""
    order = facets[np.argsort(span[facets], kind="stable")]
    widths = span[order]
    return np.split(order, np.flatnonzero(widths[1:] > _WIDER * widths[:-1]) + 1)


def _runs(facets: Ints, low: Floats, high: Floats) -> list[Ints]:
    """Facets of one radius by where they are along the axis: those on both sides of a groove are two cylinders."""
    order = facets[np.argsort(low[facets], kind="stable")]
    reach = np.maximum.accumulate(high[order])
    return np.split(order, np.flatnonzero(low[order][1:] > reach[:-1] + 1e-9) + 1)


def _longest_arc(begin: Floats, span: Floats) -> float:
    """The longest arc that intervals of bearings cover without a gap."""
    begin = begin % (2.0 * np.pi)
    order = np.argsort(begin)
    begin, span = np.tile(begin[order], 2), np.tile(span[order], 2)
    begin[len(order) :] += 2.0 * np.pi
    reach = np.maximum.accumulate(begin + span)
    gaps = np.flatnonzero(begin[1:] > reach[:-1] + 1e-4)
    firsts = np.concatenate([[0], gaps + 1])
    lasts = np.concatenate([gaps, [len(begin) - 1]])
    return float((reach[lasts] - begin[firsts]).max())


def clear_radii(own: Sequence[Round], others: Sequence[Round]) -> list[tuple[Round, float]]:
    """The cylinders of a part whose facets cross those of another on its turn, and the radius at which they do not."""
    found = []
    for mine in own:
        wanted = mine.radius
        for its in others:
            if mine.is_hole == its.is_hole or min(mine.high, its.high) <= max(mine.low, its.low):
                continue
            pin, hole = (its, mine) if mine.is_hole else (mine, its)
            if pin.radius <= hole.inner - CLEAR_M or pin.radius > _PRESS * hole.radius:
                continue
            if mine.is_hole:
                wanted = max(wanted, (pin.radius + CLEAR_M) / math.cos(0.5 * mine.step))
            else:
                wanted = min(wanted, hole.inner - CLEAR_M)
        if wanted != mine.radius:
            found.append((mine, wanted))
    return found


def moved(vertices: Floats, axis: Floats, point: Floats, radii: Sequence[tuple[Round, float]]) -> Floats:
    """The vertices of a part with cylinders brought to other radii."""
    height, radius, _ = polar(vertices, axis, point)
    moved_to: Floats = vertices.copy()
    for each, wanted in radii:
        slack = 1e-9 + _SAME * each.radius
        on = (
            (radius >= each.least - 1e-9)
            & (radius <= each.radius + 1e-9)
            & (height >= each.low - slack)
            & (height <= each.high + slack)
        )
        foot = point + np.outer(height[on], axis)
        moved_to[on] = foot + (vertices[on] - foot) * (wanted / radius[on])[:, None]
    return moved_to
