"""Places: the gear train and the housing's outline, from a seed. Millimetres; z along the shafts, y up."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..gears import mate_turn
from ..mesh import Floats, times
from .fits import BEARINGS, Bearing
from .polygon import along, offset, support
from .solid import Cut

MODULE = 2.0
FACE_WIDTH = 14.0
WALL, FLANGE, FLANGE_THICK = 14.0, 17.0, 10.0
TAPPED = 10.0
"""Depth of tapped holes in the walls: bolts have 1.4 diameters of thread in the cast aluminium."""
CORNER = 22.0
GASKET = 0.5
END_PLAY = 0.5
BEVEL_TEETH = (30, 20)
BEVEL_WIDTH = 10.0
APEX_Z = 54.0
FILTER_X, PLUG_X = 10.0, 130.0


@dataclass(frozen=True)
class Station:
    """One shaft of the train: its place, gear and bearings, and the radius of its pads."""

    name: str
    x: float
    y: float
    teeth: int
    turn: float
    bearing: Bearing
    seat: int
    """Diameter of the gear's seat."""
    pad: float

    @property
    def centre(self) -> Floats:
        """(x, y)."""
        return np.array([self.x, self.y])


@dataclass(frozen=True)
class Half:
    """Heights above the split plane of a half of the housing, and which way it stands: `sign` of its z."""

    name: str
    sign: float
    start: float
    floor: float
    outer: float
    pad: float
    boss: float
    lip: float | None
    """What the bearings bear on; None: they float, each by `END_PLAY`."""

    def z(self, height: float) -> float:
        """The z of a height above the half's split face."""
        return self.start + self.sign * height

    def stop(self, bearing: Bearing) -> float:
        """The height of the shoulder behind a bearing."""
        return self.boss + bearing.width + END_PLAY if self.lip is None else self.lip


FRONT = Half("front_case", -1.0, 0.0, 24.0, 32.0, 38.0, 16.0, 30.0)
REAR = Half("rear_case", 1.0, GASKET, 87.5, 95.5, 101.5, 77.5, None)


@dataclass(frozen=True)
class Layout:
    """The whole: stations from left to right, the cavity's corners (counter-clockwise), the flange's bolts."""

    stations: tuple[Station, ...]
    corners: tuple[tuple[float, float], ...]
    flange_bolts: tuple[tuple[float, float], ...]
    tapped_bolts: tuple[int, ...]
    """Numbers of the flange's bolts that have no room for a nut: they go into the rear case."""
    dowels: tuple[tuple[float, float], ...]
    ribs: tuple[tuple[int, float], ...]
    """Side and distance from its middle."""

    def station(self, name: str) -> Station:
        """By name."""
        return next(s for s in self.stations if s.name == name)

    @property
    def slope_ribs(self) -> tuple[tuple[int, float], ...]:
        """The ribs on sides that carry nothing."""
        return tuple(rib for rib in self.ribs if round(np.rad2deg(NORMALS[rib[0]])) % 90)

    @property
    def base(self) -> Floats:
        """The cavity's corners, (k, 2)."""
        return np.array(self.corners)

    def side(self, name: str) -> tuple[int, Floats, Floats]:
        """A flat side of the rear case ("top", "left", "bottom", "right"): its number, its middle, its normal."""
        normal = {"top": (0.0, 1.0), "left": (-1.0, 0.0), "bottom": (0.0, -1.0), "right": (1.0, 0.0)}[name]
        corners = offset(self.base, WALL)
        ahead = np.roll(corners, -1, axis=0)
        number = int(
            np.argmax(times((ahead - corners) / np.hypot(*(ahead - corners).T)[:, None], [-normal[1], normal[0]]))
        )
        return number, (corners[number] + ahead[number]) / 2.0, np.array(normal)

    def flat(self, name: str) -> Floats:
        """The middle (2,) of the plane strip of a side of the rear case."""
        first, last = self._flat_ends(name)
        return np.asarray((first + last) / 2.0)

    def flat_length(self, name: str) -> float:
        """How long that strip is."""
        first, last = self._flat_ends(name)
        return float(np.hypot(*(last - first)))

    def _flat_ends(self, name: str) -> tuple[Floats, Floats]:
        number, _, _ = self.side(name)
        cut = Cut(1.0)
        line = outline(cut, self.base, WALL, self.slope_ribs, 1.0)
        start = side_segments(cut, self.base, self.slope_ribs)[number]
        return line[start], line[(start + 1) % len(line)]


NORMALS = np.deg2rad([0.0, 62.0, 90.0, 136.0, 180.0, 270.0])


LEAST_FLAT = 25.0
"""Least length of the flats that carry the mounts: between two of their holes, and the material beside these."""


def layout(seed: int, rng: np.random.Generator, bolts: int) -> Layout:
    """Seed 0 is the drawing; others vary teeth, places, and the number of the flange's bolts."""
    while True:
        plan = _drawn(seed != 0, rng, bolts)
        if min(plan.flat_length("left"), plan.flat_length("right")) >= LEAST_FLAT:
            return plan


def _drawn(vary: bool, rng: np.random.Generator, bolts: int) -> Layout:
    extra = rng.integers(-1, 3, 5).tolist() if vary else [0] * 5
    lean = rng.uniform(-6.0, 6.0, 4).tolist() if vary else [0.0] * 4
    names = ("starter", "main", "idler", "oil_pump", "breather")
    teeth = [t + e for t, e in zip((36, 44, 28, 34, 26), extra, strict=True)]
    reach = [MODULE * (a + b) / 2.0 for a, b in pairwise(teeth)]
    angle = np.deg2rad(np.array([200.0, -25.0, 20.0, -20.0]) + lean)
    places = {"main": np.zeros(2)}
    turns = {"main": 0.0}
    order = (("main", "starter", 0), ("main", "idler", 1), ("idler", "oil_pump", 2), ("oil_pump", "breather", 3))
    for a, b, k in order:
        places[b] = places[a] + reach[k] * np.array([np.cos(angle[k]), np.sin(angle[k])])
        turns[b] = mate_turn(turns[a], teeth[names.index(a)], teeth[names.index(b)], float(angle[k]))
    kinds = {
        "starter": ("6204", 30),
        "main": ("6204", 30),
        "idler": ("6202", 20),
        "oil_pump": ("6203", 25),
        "breather": ("6202", 20),
    }
    pads = {"starter": 37.0, "main": 38.0, "idler": 27.0, "oil_pump": 31.0, "breather": 27.0}
    stations = tuple(
        Station(n, float(places[n][0]), float(places[n][1]), t, turns[n], BEARINGS[kinds[n][0]], kinds[n][1], pads[n])
        for n, t in zip(names, teeth, strict=True)
    )
    tips = [MODULE * (t / 2.0 + 1.0) + 8.0 for t in teeth]
    top = tips[1] + 2.0
    centres = np.array([*(s.centre for s in stations), (-62.0, top - 1.0), (62.0, top - 1.0)])
    corners = support(np.stack([np.cos(NORMALS), np.sin(NORMALS)], axis=1), centres, np.array([*tips, 1.0, 1.0]))
    middle = outline(Cut(0.02), corners, WALL + FLANGE / 2.0 + 0.5)
    share = (np.arange(bolts) + 0.5) / bolts
    spots, _ = along(middle, share)
    pins, _ = along(middle, np.array([0.08, 0.58]))
    nearest = [float(np.min(np.hypot(*(spots - p).T))) for p in pins]
    pins = np.array(
        [
            p if d > 12.0 else (spots[np.argsort(np.hypot(*(spots - p).T))[:2]]).mean(axis=0)
            for p, d in zip(pins, nearest, strict=True)
        ]
    )
    ribs = []
    ahead = np.roll(corners, -1, axis=0)
    for k, (a, b) in enumerate(zip(corners, ahead, strict=True)):
        length = float(np.hypot(*(b - a)))
        way = (b - a) / length
        found = sorted(
            float(times(p - (a + b) / 2.0, way))
            for p in spots
            if abs(float(times(p - a, [way[1], -way[0]])) - WALL - FLANGE / 2.0 - 0.5) < 0.5
        )
        for low, high in pairwise(found):
            if abs((low + high) / 2.0) < length / 2.0 - CORNER:
                ribs.append((k, (low + high) / 2.0))
    return Layout(
        stations,
        tuple(map(tuple, corners.tolist())),
        tuple(map(tuple, spots.tolist())),
        tuple(k for k, (x, y) in enumerate(spots.tolist()) if _is_crowded(x, y, corners)),
        tuple(map(tuple, pins.tolist())),
        tuple(ribs),
    )


def _is_crowded(x: float, y: float, corners: Floats) -> bool:
    """Whether a bolt of the flange is beside the input drive, the filter, the drain plug or a mount."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    if y > high[1]:
        return abs(x) < 62.0
    if y < low[1]:
        return abs(x - FILTER_X) < 82.0 or abs(x - PLUG_X) < 20.0
    return bool(x < low[0] or x > high[0])


def outline(
    cut: Cut, corners: Floats, distance: float, ribs: tuple[tuple[int, float], ...] = (), rib: float = 0.0
) -> Floats:
    """The cavity's outline (n, 2) moved outwards, its corners round, with ribs of a height on its sides.

    The number of points does not depend on `distance` or `rib`.
    """
    moved = offset(corners, distance)
    radius = CORNER + distance
    count = len(corners)
    out: list[Floats] = []
    for k in range(count):
        back, here, on = moved[k - 1], moved[k], moved[(k + 1) % count]
        u, v = (back - here) / np.hypot(*(back - here)), (on - here) / np.hypot(*(on - here))
        turn = float(np.arccos(np.clip(times(-u, v), -1.0, 1.0)))
        pieces = cut.arc(CORNER + WALL + FLANGE, turn, 2)
        reach = radius * np.tan(turn / 2.0)
        centre = here + u * reach + radius * np.array([u[1], -u[0]])
        start = np.arctan2(*(here + u * reach - centre)[::-1])
        angle = start + np.linspace(0.0, turn, pieces + 1)
        out.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        middle, normal = (corners[k] + corners[(k + 1) % count]) / 2.0, np.array([v[1], -v[0]])
        for side, place in sorted(ribs):
            if side == k:
                foot = middle + v * place + normal * distance
                out.append(
                    np.stack(
                        [foot - 3.5 * v, foot - 2.0 * v + rib * normal, foot + 2.0 * v + rib * normal, foot + 3.5 * v]
                    )
                )
    return np.concatenate(out)


def side_segments(cut: Cut, corners: Floats, ribs: tuple[tuple[int, float], ...]) -> list[int]:
    """By side, the number of the segment of `outline` that runs along it from its start (to its first rib)."""
    count, at, found = len(corners), 0, []
    for k in range(count):
        back, here, on = corners[k - 1], corners[k], corners[(k + 1) % count]
        u, v = (back - here) / np.hypot(*(back - here)), (on - here) / np.hypot(*(on - here))
        turn = float(np.arccos(np.clip(times(-u, v), -1.0, 1.0)))
        at += cut.arc(CORNER + WALL + FLANGE, turn, 2)
        found.append(at)
        at += 1 + 4 * sum(side == k for side, _ in ribs)
    return found
