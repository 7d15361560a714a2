"""Surfaces of revolution about the axis of a joint: they stay on themselves as it turns, and only their facets cross.

In the half-plane of radius and height such a surface is a line. The facets of a part sweep a thin band along it, as
deep as their chords. A part is tested with these surfaces brought clear of the bands of those that they turn in.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

CLEAR_M = 2e-6
"""How far facets are kept off those of the other part, at least: more than what counts as touching."""
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
_PRESS = 0.1  # a part is pressed into the other by this share of its radius at most
THREAD = 0.28  # the same where both go all around: bolts are drawn as wide as their thread, and holes as its core
_OPPOSED = -0.7  # cosine of the normals of two surfaces that lie in each other
_STEEP = 0.3  # a surface that leans more moves along its normal: a move along the radius would be long
_BALL_RAD = 0.05  # the segments that stand for the circle of a ball
_MOST_BALLS = 4


@dataclass(frozen=True, eq=False)
class Round:
    """Facets of one surface of revolution between two rings, or of a ball. Metres and radians."""

    ends: tuple[tuple[float, float], tuple[float, float]]
    """Radius and height of the rings: the largest radii of corners there, or the least of a hole."""
    normal: tuple[float, float]
    """Outwards, along the radius and the axis."""
    step: float
    """The widest facet."""
    slack: float
    """How far corners may be off."""
    facets: Ints
    """Their numbers; none where it does not go all around."""
    ball: tuple[float, float, float] | None = None
    """Of a ball: the height of its middle, its radius, and the least radius of its facets. `ends` are of its height."""

    @property
    def is_hole(self) -> bool:
        """Whether the material is outside."""
        return self.normal[0] < 0.0

    @property
    def is_upright(self) -> bool:
        """A cylinder."""
        return self.ball is None and abs(self.normal[1]) <= _UPRIGHT

    def bound(self) -> Iterator[tuple[Floats, Floats]]:
        """The pieces of the line beyond which no facet reaches as it turns: their ends, and the normal."""
        normal = np.array(self.normal)
        if self.ball is None:
            by = np.array([math.cos(0.5 * self.step) if self.is_hole else 1.0, 1.0])
            ends = np.array(self.ends) * by
            way = ends[1] - ends[0]
            across = np.array([way[1], -way[0]]) / np.linalg.norm(way)
            yield ends, across * math.copysign(1.0, float(across @ normal))
            return
        middle, outer, inner = self.ball
        low, high = (math.asin(min(1.0, max(-1.0, (z - middle) / outer))) for _, z in self.ends)
        angles = np.linspace(low, high, 2 + int((high - low) / _BALL_RAD))
        half = math.cos(0.5 * (angles[1] - angles[0]))
        circle = np.column_stack([np.cos(angles), np.sin(angles)])
        points = (inner if self.is_hole else outer / half) * circle + [0.0, middle]
        way = 0.5 * (circle[1:] + circle[:-1]) / half * (-1.0 if self.is_hole else 1.0)
        yield from zip(np.stack([points[:-1], points[1:]], axis=1), way, strict=True)

    def on(self, radius: Floats, height: Floats) -> npt.NDArray[np.bool_]:
        """Which points lie on it."""
        if self.ball is not None:
            middle, outer, _ = self.ball
            low, high = sorted(z for _, z in self.ends)
            near = np.abs(np.hypot(radius, height - middle) - outer) <= self.slack
            return np.asarray(near & (height >= low - self.slack) & (height <= high + self.slack))
        (r, z), (r1, z1) = self.ends
        length = math.hypot(r1 - r, z1 - z)
        along = ((radius - r) * (r1 - r) + (height - z) * (z1 - z)) / length
        across = (radius - r) * self.normal[0] + (height - z) * self.normal[1]
        return np.asarray((np.abs(across) <= self.slack) & (along >= -self.slack) & (along <= length + self.slack))

    def normals(self, radius: Floats, height: Floats) -> Floats:
        """Its normal at points on it."""
        if self.ball is None:
            return np.tile(self.normal, (len(radius), 1))
        way = np.column_stack([radius, height - self.ball[0]])
        return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True) * math.copysign(1.0, self.normal[0]))


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
    """The surfaces of revolution about an axis, without faces that are square to it. near: look for those beside these
    alone."""
    height, radius, bearing = polar(vertices, axis, point)
    numbers = np.arange(len(faces))
    if near is not None:
        kept = np.zeros(len(vertices), dtype=bool)
        for each in near:
            low, high = _radii(each)
            kept |= (radius >= (1.0 - THREAD) * low - each.slack) & (radius <= high / (1.0 - THREAD) + each.slack)
        numbers = np.flatnonzero(kept[faces].all(axis=1))
    if not len(numbers):
        return []
    facets = _Facets(vertices, faces, numbers, axis, point, height, radius, bearing)
    found = list(_cylinders(facets))
    found += _bands(facets)
    return found + _balls(facets)


class _Facets:
    """Facets in numbers about the axis."""

    def __init__(
        self,
        vertices: Floats,
        faces: Ints,
        numbers: Ints,
        axis: Floats,
        point: Floats,
        height: Floats,
        radius: Floats,
        bearing: Floats,
    ) -> None:
        self.axis, self.point = axis, point
        faces = faces[numbers]
        corners = vertices[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        twice = np.linalg.norm(normal, axis=1)
        of, rows = radius[faces], np.arange(len(faces))
        first = bearing[faces[rows, np.argmax(of, axis=1)]][:, None]
        turned = (bearing[faces] - first + np.pi) % (2.0 * np.pi) - np.pi
        turned[of <= slack_of(of.max(axis=1))[:, None]] = 0.0  # on the axis there is no bearing
        span = np.ptp(turned, axis=1)
        kept = twice > 0.0
        self.numbers, self.corners, self.span = numbers[kept], corners[kept], span[kept]
        self.begin = (first[:, 0] + turned.min(axis=1))[kept]
        self.radius, self.height = radius[faces[kept]], height[faces[kept]]
        self.normal = normal[kept] / twice[kept, None]
        middle = self.corners.mean(axis=1) - point
        middle -= np.outer(middle @ axis, axis)
        length = np.linalg.norm(middle, axis=1)
        across = np.einsum("ij,ij->i", self.normal, middle) / np.where(length > 0.0, length, 1.0)
        self.lean = np.column_stack([across, self.normal @ axis])
        """The normal along the radius and the axis."""
        self.is_narrow = (self.span > 1e-9) & (self.span <= _STEP)
        self.left = np.ones(len(self.numbers), dtype=bool)
        """Those of no surface yet."""

    def is_round(self, group: Ints) -> bool:
        """Whether facets make up an arc, side by side."""
        if len(group) < _FEWEST or _longest_arc(self.begin[group], self.span[group]) < _ARC:
            return False
        return len(np.unique(np.round(self.begin[group], 4))) >= _FEWEST

    def all_around(self, group: Ints) -> Ints:
        """The numbers of facets that leave no gap about the axis; else none."""
        is_all = _longest_arc(self.begin[group], self.span[group]) >= 2.0 * np.pi - 1e-3
        found: Ints = self.numbers[group] if is_all else self.numbers[:0]
        return found


def _cylinders(facets: _Facets) -> Iterator[Round]:
    """The cylinders, whatever the heights of their corners."""
    mean = facets.radius.mean(axis=1)
    same = facets.is_narrow & (np.ptp(facets.radius, axis=1) <= slack_of(mean)) & (mean > 0.0)
    kept = np.flatnonzero(same & (np.abs(facets.lean[:, 1]) <= _UPRIGHT))
    is_hole = facets.lean[:, 0] < 0.0
    order = kept[np.lexsort((mean[kept], is_hole[kept]))]
    tall = np.sort(facets.height, axis=1)
    alike = (wide for same in _same_radii(order, mean, is_hole) for wide in _same_widths(same, facets.span))
    for group in (run for wide in alike for run in _runs(wide, tall[:, 0], tall[:, 2])):
        if not facets.is_round(group):
            continue
        facets.left[group] = False
        radii, low, high = facets.radius[group], float(tall[group, 0].min()), float(tall[group, 2].max())
        hole = bool(is_hole[group[0]])
        at = float(radii.min() if hole else radii.max())
        slack = 1e-9 + 1e-6 * at + float(np.ptp(radii))
        normal, widest = (-1.0 if hole else 1.0, 0.0), float(facets.span[group].max())
        yield Round(((at, low), (at, high)), normal, widest, slack, facets.all_around(group))


def _bands(facets: _Facets) -> Iterator[Round]:
    """Facets between two rings: cones, and surfaces made of cones, such as chamfers, balls and tori."""
    kept = np.flatnonzero(facets.left & facets.is_narrow)
    rings = _rings(facets.radius[kept].ravel(), facets.height[kept].ravel()).reshape(-1, 3)
    ordered = np.sort(rings, axis=1)
    is_band = (ordered[:, 0] != ordered[:, 2]) & ((ordered[:, 1] == ordered[:, 0]) | (ordered[:, 1] == ordered[:, 2]))
    kept, rings, ordered = kept[is_band], rings[is_band], ordered[is_band]
    if not len(kept):
        return
    key = ordered[:, 0] * (int(ordered.max()) + 1) + ordered[:, 2]
    order = np.argsort(key, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(key[order])) + 1):
        first, last = ordered[rows[0], 0], ordered[rows[0], 2]
        ends, slack = [], 0.0
        for ring in (first, last):
            on = rings[rows] == ring
            radii, heights = facets.radius[kept[rows]][on], facets.height[kept[rows]][on]
            ends.append((float(np.median(radii)), float(np.median(heights))))
            slack = max(slack, float(np.ptp(radii)), float(np.ptp(heights)))
        (r, z), (r1, z1) = ends
        length = math.hypot(r1 - r, z1 - z)
        way = np.array([z1 - z, r - r1]) / length
        if abs(way[0]) <= _UPRIGHT:  # it is square to the axis
            continue
        towards = facets.lean[kept[rows]] @ way > 0.0
        for side, normal in ((towards, way), (~towards, -way)):
            for group in _same_widths(kept[rows[side]], facets.span):
                if facets.is_round(group):
                    facets.left[group] = False
                    widest = float(facets.span[group].max())
                    out = (float(normal[0]), float(normal[1]))
                    off = slack + 1e-9 + 1e-6 * length
                    yield Round((ends[0], ends[1]), out, widest, off, facets.all_around(group))


def _rings(radius: Floats, height: Floats) -> Ints:
    """A number for each point: those of one radius and height have the same."""
    number, count = np.zeros(len(radius), dtype=np.int64), 0
    slack = slack_of(radius)
    for alike in _windows(np.argsort(radius, kind="stable"), radius, slack):
        for ring in _windows(alike[np.argsort(height[alike], kind="stable")], height, slack):
            number[ring] = count
            count += 1
    return number


def _windows(order: Ints, value: Floats, slack: Floats) -> Iterator[Ints]:
    """Ordered points in groups that differ by no more than the slack of their first."""
    values, start = value[order], 0
    while start < len(order):
        end = int(np.searchsorted(values, values[start] + slack[order[start]], "right"))
        yield order[start:end]
        start = end


def _balls(facets: _Facets) -> list[Round]:
    """Balls with their middle on the axis, whatever the order of their facets."""
    found: list[Round] = []
    kept = np.flatnonzero(facets.left)
    corners, normal = facets.corners[kept], facets.normal[kept]
    # The middle is on the line through the circumcentre, along the normal.
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.cross(one, other)
    square = np.einsum("ij,ij->i", area, area)
    squares = np.einsum("ij,ij->i", one, one)[:, None], np.einsum("ij,ij->i", other, other)[:, None]
    centre = corners[:, 0] + np.cross(squares[0] * other - squares[1] * one, area) / (2.0 * square[:, None])
    off = centre - facets.point
    along, lean = off @ facets.axis, normal @ facets.axis
    across, slope = off - np.outer(along, facets.axis), normal - np.outer(lean, facets.axis)
    steep = np.einsum("ij,ij->i", slope, slope)
    is_known = steep > 0.01
    kept, along, lean, across, slope, steep, corners = (
        each[is_known] for each in (kept, along, lean, across, slope, steep, corners)
    )
    by = -np.einsum("ij,ij->i", across, slope) / steep
    middle = along + by * lean
    size = np.linalg.norm(corners - (facets.point + middle[:, None, None] * facets.axis), axis=2).mean(axis=1)
    beside = np.linalg.norm(across + by[:, None] * slope, axis=1)
    near = np.flatnonzero(beside <= 0.01 * size)
    for _ in range(_MOST_BALLS):
        if len(near) < 2 * _FEWEST:
            break
        order = near[np.argsort(middle[near], kind="stable")]
        ends = np.searchsorted(middle[order], middle[order] + 0.01 * size[order], "right")
        start = int(np.argmax(ends - np.arange(len(order))))
        voted = order[start : ends[start]]
        at = float(np.median(middle[voted]))
        near = near[~np.isin(near, voted)]
        ball = _ball(facets, at)
        if ball is not None:
            found.append(ball)
            near = near[facets.left[kept[near]]]
    return found


def _ball(facets: _Facets, middle: float) -> Round | None:
    """The ball about a point of the axis that most of the facets that are left lie on."""
    for _ in range(2):
        left = np.flatnonzero(facets.left)
        far = np.hypot(facets.radius[left], facets.height[left] - middle)
        spread = np.ptp(far, axis=1)
        out = np.column_stack([facets.radius[left].mean(axis=1), facets.height[left].mean(axis=1) - middle])
        cosine = np.abs(np.einsum("ij,ij->i", out, facets.lean[left])) / np.linalg.norm(out, axis=1).clip(1e-300)
        is_on = (spread <= 10.0 * slack_of(far.mean(axis=1))) & (cosine >= math.cos(0.5 * _STEP))
        if np.count_nonzero(is_on) < 2 * _FEWEST:
            return None
        outer = float(np.median(far[is_on]))
        slack = float(slack_of(np.array(outer)))
        is_on &= (np.abs(far - outer) <= 10.0 * slack).all(axis=1)
        group = left[is_on]
        # By least squares, for facets alone do not say their middle well.
        radius, height = facets.radius[group].ravel(), facets.height[group].ravel()
        matrix = np.column_stack([2.0 * height, np.ones(len(height))])
        (middle, constant), *_ = np.linalg.lstsq(matrix, radius**2 + height**2, rcond=None)
        outer = math.sqrt(max(0.0, float(constant) + float(middle) ** 2))
    far = np.hypot(facets.radius[group], facets.height[group] - middle)
    group = group[(np.abs(far - outer) <= slack).all(axis=1)]
    corners = facets.corners[group]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    group, sides = group[sides <= _STEP * outer], sides[sides <= _STEP * outer]
    out = np.column_stack([facets.radius[group].mean(axis=1), facets.height[group].mean(axis=1) - middle])
    inwards = np.einsum("ij,ij->i", facets.lean[group], out) < 0.0
    is_hole = bool(np.count_nonzero(inwards) * 2 > len(inwards))
    group, sides = group[inwards == is_hole], sides[inwards == is_hole]
    narrow = group[facets.is_narrow[group]]
    if len(group) < 2 * _FEWEST or not facets.is_round(narrow):
        return None
    facets.left[group] = False
    at = facets.point + middle * facets.axis
    inner = float(np.abs(np.einsum("ij,ij->i", facets.normal[group], facets.corners[group, 0] - at)).min())
    beyond = float(sides.max())  # a facet may lie over the pole
    low = max(float(facets.height[group].min()) - beyond, float(middle) - outer)
    high = min(float(facets.height[group].max()) + beyond, float(middle) + outer)
    ball = (float(middle), outer, inner)
    normal = (-1.0 if is_hole else 1.0, 0.0)
    whole = facets.numbers[group] if len(facets.all_around(narrow)) else facets.numbers[:0]
    return Round(((0.0, low), (0.0, high)), normal, _STEP, slack, whole, ball)


def discs_of(vertices: Floats, faces: Ints, axis: Floats, point: Floats) -> Ints:
    """The numbers of the faces of discs and rings square to the axis whose edges are circles about it."""
    height, radius, bearing = polar(vertices, axis, point)
    slack = slack_of(radius)
    square = np.flatnonzero(np.ptp(height[faces], axis=1) <= slack[faces].max(axis=1))
    found = [faces[:0, 0]]
    for group in _windows(
        square[np.argsort(height[faces[square, 0]], kind="stable")], height[faces[:, 0]], slack[faces[:, 0]]
    ):
        _, same = np.unique(vertices[faces[group]].reshape(-1, 3), axis=0, return_inverse=True)
        corners = same.reshape(-1, 3)
        edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
        ends = np.stack([faces[group], np.roll(faces[group], -1, axis=1)], axis=2).reshape(-1, 2)
        _, which, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
        rim = ends[count[which.ravel()] == 1]
        turned = (bearing[rim[:, 1]] - bearing[rim[:, 0]] + np.pi) % (2.0 * np.pi) - np.pi
        is_round = (np.abs(np.diff(radius[rim], axis=1)[:, 0]) <= slack[rim].min(axis=1)) & (np.abs(turned) <= _STEP)
        if len(rim) and is_round.all():
            found.append(group)
    return np.sort(np.concatenate(found))


def _radii(of: Round) -> tuple[float, float]:
    """The least and the largest radius."""
    if of.ball is not None:
        return 0.0, of.ball[1]
    radii = [r for r, _ in of.ends]
    return min(radii), max(radii)


def slack_of(radius: Floats) -> Floats:
    """How much radii on one surface may differ, metres."""
    return np.asarray(_SAME * radius + np.minimum(_GRID_M, _GRID_SHARE * radius) + 1e-9)


def _same_radii(order: Ints, mean: Floats, is_hole: npt.NDArray[np.bool_]) -> Iterator[Ints]:
    """Facets of one radius each, of pins and of holes: an oval has many. order: by that, and by radius."""
    for side in np.split(order, np.flatnonzero(np.diff(is_hole[order])) + 1) if len(order) else []:
        radii, start = mean[side], 0
        while start < len(side):
            end = int(np.searchsorted(radii, radii[start] + slack_of(radii[start]), "right"))
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


def clearing(own: Sequence[Round], others: Sequence[Round]) -> list[tuple[Round, float]]:
    """The surfaces of a part whose facets cross those of another as it turns, and how far they move in to be clear."""
    pieces = [(k, *piece) for k, each in enumerate(own) for piece in each.bound()]
    theirs = [(len(each.facets) > 0, *piece) for each in others for piece in each.bound()]
    if not pieces or not theirs:
        return []
    lines = np.array([*(ends for _, ends, _ in pieces), *(ends for _, ends, _ in theirs)])
    found: dict[int, float] = {}
    start, normals = np.array([ends for _, ends, _ in theirs]), np.array([normal for *_, normal in theirs])
    shares = np.where([is_whole for is_whole, *_ in theirs], THREAD, _PRESS)
    for k, ends, normal in pieces:
        way, wide = ends[1] - ends[0], float(ends[:, 0].max())
        deepest = wide * (shares if len(own[k].facets) else np.minimum(shares, _PRESS))
        length = float(np.linalg.norm(way))
        way = way / length
        along, gap = (start - ends[0]) @ way, (start - ends[0]) @ normal
        low, high = np.maximum(along.min(axis=1), 0.0), np.minimum(along.max(axis=1), length)
        for number in np.flatnonzero((normals @ normal < _OPPOSED) & (high > low + 1e-9 * length)):
            at = np.array([low[number], high[number]])
            first, last = np.argsort(along[number])
            gaps = np.interp(at, along[number][[first, last]], gap[number][[first, last]])
            least = float(gaps.min())
            if (
                least >= CLEAR_M
                or least < -deepest[number]
                or _parts(lines, ends[0], way, normal, float(at.mean()), gaps.mean())
            ):
                continue
            by = (CLEAR_M - least) / (math.cos(0.5 * own[k].step) if own[k].is_hole and own[k].ball is None else 1.0)
            found[k] = max(found.get(k, 0.0), by)
    return [(own[k], by) for k, by in sorted(found.items())]


def _parts(lines: Floats, origin: Floats, way: Floats, normal: Floats, at: float, gap: float) -> bool:
    """Whether another surface lies between two that are to be cleared: the other side of a thin wall."""
    along, off = (lines - origin) @ way, (lines - origin) @ normal
    over = (along.min(axis=1) < at) & (along.max(axis=1) > at)
    along, off = along[over], off[over]
    share = (at - along[:, 0]) / (along[:, 1] - along[:, 0])
    there = off[:, 0] + share * (off[:, 1] - off[:, 0])
    return bool(((there < 0.05 * gap) & (there > 0.95 * gap)).any()) if gap < 0.0 else False


def moved(vertices: Floats, axis: Floats, point: Floats, by: Sequence[tuple[Round, float]]) -> Floats:
    """The vertices of a part with surfaces of revolution moved in. Edges between two move with both."""
    height, radius, _ = polar(vertices, axis, point)
    total, least = np.zeros((len(vertices), 2)), np.zeros(len(vertices))
    first, second = np.zeros((len(vertices), 3)), np.zeros((len(vertices), 3))
    for each, far in by:
        on = np.flatnonzero(each.on(radius, height))
        normal = each.normals(radius[on], height[on])
        total[on] += normal
        least[on] = np.maximum(least[on], far)
        row = np.column_stack([normal, np.full(len(on), far)])
        is_first = ~first[on].any(axis=1)
        first[on[is_first]] = row[is_first]
        second[on[~is_first]] = row[~is_first]
    shift = np.zeros((len(vertices), 2))
    for k in np.flatnonzero(least > 0.0):
        shift[k] = _shift(first[k], second[k], total[k], least[k], radius[k])
    foot = point + np.outer(height, axis)
    out = (vertices - foot) / np.where(radius > 0.0, radius, 1.0)[:, None]
    return np.asarray(vertices + out * shift[:, :1] + np.outer(shift[:, 1], axis))


def _shift(first: Floats, second: Floats, total: Floats, far: float, radius: float) -> Floats:
    """How a corner moves along the radius and the axis, so that the surfaces at it move in by their distances."""
    if radius <= 1e-9 + 0.5 * far:
        return np.array([0.0, -far / (total[1] / np.linalg.norm(total) or 1.0)])
    if second.any():
        matrix = np.array([first[:2], second[:2]])
        if abs(np.linalg.det(matrix)) >= _STEEP:
            return np.asarray(np.linalg.solve(matrix, [-first[2], -second[2]]))
        mean = total / np.linalg.norm(total)
        return np.asarray(-far / float((matrix @ mean).min()) * mean)
    if abs(first[0]) >= _STEEP:
        return np.array([-far / first[0], 0.0])  # so that faces square to the axis stay in their planes
    return np.asarray(-far * first[:2])
