"""What the fasteners of the samples hold, by a rule that shares no code with `feeler.holds`.

The samples know where each bolt, screw and nut stands. Lines along its axis, at several radii, are cut with the meshes
of the parts near it; signed crossings say where on each line a part is solid. A part is passed where it is solid around
the shank in at least half of the directions, at one height. It is borne on where it begins under the head.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fastener_truth import Truth

import feeler

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ANGLES, LEVELS = 36, 160
SHANK = (0.15, 0.5, 0.85)
"""Radii of lines in the shank, over its own."""
TIGHT = 1.03
"""A hole is a thread where it is solid this near to the axis, in radii of the shank."""
AROUND = (TIGHT, 1.12, 1.25, 1.4, 1.55)
"""Radii of lines around the shank."""
MOST = 0.5
HEAD = {"bolt": 0.8, "screw": 0.72, "nut": 0.8}
"""Radii within the bearing face, over the diameter of the thread: widths across flats are at least 1.6 diameters."""
SEATED, NEAR = 0.08, 0.02
"""A head bears on a part in this share of the directions, if it begins this near, in diameters."""
TIP = 0.95
"""What begins beyond is only reached by the tip."""
OVERLAP = 0.05
"""Parts are in each other if they share this much of what is solid around a shank."""
NEAR_CLAMP_M = 5e-4
"""What clamps hold is this near, metres."""


@dataclass(frozen=True)
class Span:
    """A part around or in a shank: where it begins and ends below the head, metres; `is_tight` if it is a thread."""

    part: int
    top: float
    bottom: float
    is_tight: bool


class Rule:
    """The rule on one mock-up."""

    def __init__(self, mockup: feeler.Mockup, truth: dict[str, Truth]) -> None:
        self.mockup = mockup
        numbers = {path: part for part, path in enumerate(mockup.part_paths)}
        self.truth = {numbers[path]: known for path, known in truth.items()}
        self.bounds = mockup.part_bounds.reshape(-1, 2, 3)
        order = np.argsort(mockup.part_of_face, kind="stable")
        self.faces = np.split(mockup.faces[order], np.cumsum(mockup.part_triangles)[:-1])
        self.is_other = np.ones(mockup.part_count, dtype=bool)
        self.is_other[list(self.truth)] = False
        self.unclear: set[int] = set()
        """Fasteners where parts are in each other, or whose thread is in two at one height: parts are placed by
        chance."""
        self.scene = feeler.Scene(mockup)
        self.nuts = self._nuts()

    def held(self) -> dict[int, set[int]]:
        """What each fastener holds."""
        found: dict[int, set[int]] = {}
        on = {nut: bolt for bolt, nut in self.nuts.items()}
        for part, known in self.truth.items():
            if known.kind != "nut":
                found[part] = self._of_shank(part, known)
        for part, known in self.truth.items():
            if known.kind == "nut":
                found[part] = found[on[part]] if part in on else set()
                self.unclear |= {part} if on.get(part) in self.unclear else set()
        return found

    def _nuts(self) -> dict[int, int]:
        """The nut of each bolt."""
        found = {}
        shanks = [(part, known) for part, known in self.truth.items() if known.kind != "nut"]
        frames = np.linalg.inv(np.array([known.poses for _, known in shanks]).reshape(-1, 4, 4))
        sizes = np.array([known.size for _, known in shanks])
        lengths = np.array([known.length for _, known in shanks])
        for part, known in self.truth.items():
            if known.kind != "nut":
                continue
            local = frames @ (known.poses @ [0.0, 0.0, 0.4 * known.size, 1.0])
            is_on = (np.hypot(local[:, 0], local[:, 1]) < 0.2 * sizes) & (local[:, 2] < 0.0)
            is_on &= local[:, 2] > -lengths - known.size
            if is_on.any():
                found[shanks[int(np.flatnonzero(is_on)[0])][0]] = part
        return found

    def _of_shank(self, part: int, known: Truth) -> set[int]:
        spans, seats = self._spans(known, known.length)
        if self._is_overlapping:
            self.unclear.add(part)
        if part in self.nuts:
            nut = self.truth[self.nuts[part]]
            height = float((np.linalg.inv(known.poses) @ nut.poses)[2, 3])
            held = {each.part for each in spans if 0.5 * (each.top + each.bottom) > height} | seats
            return self._with_clamps(held | self._spans(nut, 0.0)[1], set())
        tight = [each for each in spans if each.is_tight]
        if not tight:
            return self._with_clamps({each.part for each in spans} | seats, set())
        anchor = min(tight, key=lambda each: each.bottom)
        if sum(each.bottom < anchor.bottom + 2.0 * known.length / LEVELS for each in tight) > 1:
            self.unclear.add(part)
        held = ({each.part for each in spans if each.top > anchor.top} | seats) - {anchor.part}
        return self._with_clamps(held, {anchor.part}) or {part}

    def _with_clamps(self, held: set[int], but: set[int]) -> set[int]:
        """With what clamps and clips touch."""
        more = set(held)
        for part in held:
            if self.mockup.part_paths[part].split("/")[-1].split("_")[0] in ("clamp", "clip"):
                more |= self._near(part)
        return more - but

    def _near(self, part: int) -> set[int]:
        """What is near a part, by distances of points of both surfaces to the other's triangles."""
        low, high = self.bounds[part] + np.array([[-NEAR_CLAMP_M], [NEAR_CLAMP_M]])
        is_met = self.is_other & (self.bounds[:, 0] <= high).all(axis=1) & (self.bounds[:, 1] >= low).all(axis=1)
        mine = feeler.Tool.of_parts(self.mockup, [part])
        return {
            each
            for each in np.flatnonzero(is_met).tolist()
            if each != part and self.scene.only([each]).distance(mine, np.eye(4)).value <= NEAR_CLAMP_M
        }

    def _spans(self, known: Truth, length: float) -> tuple[list[Span], set[int]]:
        """The parts around a shank, and those that its head bears on."""
        radius, head = 0.5 * known.size, HEAD[known.kind] * known.size
        frame = known.poses
        reach = max(head, AROUND[-1] * radius)
        corners = np.array([[x, y, z] for x in (-reach, reach) for y in (-reach, reach) for z in (-length, 0.0)])
        world = corners @ frame[:3, :3].T + frame[:3, 3]
        slack = NEAR * known.size
        is_met = self.is_other & (self.bounds[:, 0] <= world.max(axis=0) + slack).all(axis=1)
        is_met &= (self.bounds[:, 1] >= world.min(axis=0) - slack).all(axis=1)
        turn = (np.arange(ANGLES) + 0.31) * (2.0 * np.pi / ANGLES)
        seat = np.linspace(1.06 * radius, head, 5)
        radii = np.concatenate([radius * np.array([*SHANK, *AROUND]), seat])
        lines = (radii[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)).reshape(-1, 2)
        levels = np.concatenate([[2.0 * slack, -slack], -length * (np.arange(LEVELS) + 0.5) / LEVELS])
        spans, seats, count = [], set(), np.zeros(0)
        self._is_overlapping = False
        for part in np.flatnonzero(is_met).tolist():
            solid = self._solid(part, frame, lines, levels, reach).reshape(len(radii), ANGLES, -1)
            begins = ~solid[len(SHANK) + len(AROUND) :, :, 0] & solid[len(SHANK) + len(AROUND) :, :, 1]
            if (begins.mean(axis=1) >= SEATED).any():
                seats.add(part)
            if length > 0.0:
                rest = solid[: len(SHANK) + len(AROUND), :, 2:]
                own = self._around(part, rest, levels[2:])
                spans += own
                if own:
                    count = count if len(count) else np.zeros(rest.shape, dtype=np.int64)
                    self._is_overlapping |= bool((rest & (count > 0)).sum() > OVERLAP * rest.sum())
                    count += rest
        return spans, seats

    def _around(self, part: int, solid: npt.NDArray[np.bool_], levels: Floats) -> list[Span]:
        """Where a part is around a shank. solid: (radii, angles, levels)."""
        inside, around = solid[: len(SHANK)], solid[len(SHANK) :]
        is_passed = (around.any(axis=0).mean(axis=0) >= MOST) | (inside.mean(axis=1) >= MOST).any(axis=0)
        is_passed &= levels > TIP * levels[-1]
        if not is_passed.any():
            return []
        is_tight = ((around[0] | inside[-1]).mean(axis=0) >= MOST) & is_passed
        places = np.flatnonzero(is_passed)
        return [Span(part, float(levels[places[0]]), float(levels[places[-1]]), bool(is_tight.sum() > 1))]

    def _solid(self, part: int, frame: Floats, lines: Floats, levels: Floats, reach: float) -> npt.NDArray[np.bool_]:
        """Whether a part is solid on lines along the axis, (lines, levels), by the signs of its crossings above."""
        faces = self.faces[part]
        used, index = np.unique(faces, return_inverse=True)
        points = (self.mockup.vertices[used] - frame[:3, 3]) @ frame[:3, :3]
        corners = points[index.reshape(-1, 3)]
        low, high = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
        corners = corners[((low <= reach) & (high >= -reach)).all(axis=1)]
        depth = np.zeros((len(lines), len(levels) + 1), dtype=np.int64)
        order = np.argsort(-levels)
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        area = _cross(b - a, c - a)
        is_up = np.abs(area) > 1e-18
        a, b, c, area = a[is_up], b[is_up], c[is_up], area[is_up]
        for begin in range(0, len(a), 4096):
            some = slice(begin, begin + 4096)
            point = lines[:, None]
            u = _cross(b[some] - _point3(point), c[some] - _point3(point)) / area[some]
            v = _cross(c[some] - _point3(point), a[some] - _point3(point)) / area[some]
            line, face = np.nonzero((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0))
            z = (
                u[line, face] * a[some][face, 2]
                + v[line, face] * b[some][face, 2]
                + (1.0 - u - v)[line, face] * c[some][face, 2]
            )
            # A crossing above counts at all levels below it.
            first = np.searchsorted(-levels[order], -z, side="left")
            np.add.at(depth, (line, first), np.sign(area[some][face]).astype(np.int64))
        inside = np.cumsum(depth, axis=1)[:, :-1] > 0
        found = np.empty_like(inside)
        found[:, order] = inside
        return found


def _point3(points: Floats) -> Floats:
    """Points (..., 2) as (..., 3)."""
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
