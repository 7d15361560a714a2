"""Fasteners as modelled in various CAD styles, and other things: random sizes, cuts, places and windings.

    python bench/drawn_fasteners.py [--count 40] [--seed 0] [--show KIND]

Prints, for each shape, how many of `count` are recognised as fasteners without names, and how many answers are right:
the right kind, drive, size and place, or none. Needs `manifold3d`, with whose solids feeler shares no code.
"""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler

Floats = npt.NDArray[np.float64]
m3 = importlib.import_module("manifold3d")
Solid: Any = m3.Manifold
Shape: Any = m3.CrossSection
Rng = np.random.Generator

COARSE = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 24.0)
"""Threads M3 to M24, mm."""
FLATS = {3: 5.5, 4: 7, 5: 8, 6: 10, 8: 13, 10: 17, 12: 19, 16: 24, 20: 30, 24: 36}
"""Width across the flats of their hexagons (DIN 931), mm."""
SOCKETS = {3: 2.5, 4: 3, 5: 4, 6: 5, 8: 6, 10: 8, 12: 10, 16: 14, 20: 17, 24: 19}
"""Width of the hexagon sockets of their cap screws (DIN 912), mm."""


@dataclass(frozen=True)
class Drawn:
    """A solid in millimetres, whose tool comes from +z, and its right answer. `kind` None: it is not a fastener."""

    solid: Any
    kind: str | None = None
    drive: str = ""
    flats: float = float("nan")
    size: float = float("nan")
    top: float = 0.0
    is_two_sided: bool = False


def polygon(points: Floats) -> Any:
    return Shape([points.tolist()])


def regular(count: int, distance: float, turn: float = 0.0) -> Any:
    """A polygon whose sides are `distance` from the middle."""
    angles = turn + 2.0 * np.pi * np.arange(count) / count
    return polygon(distance / np.cos(np.pi / count) * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def lobes(radius: float, step: int) -> Any:
    """Six lobes as of Torx (ISO 10664), `radius` from the middle to their tips."""
    turn = np.linspace(0.0, 2.0 * np.pi, 6 * step, endpoint=False)
    r = radius * (0.86 + 0.14 * np.cos(6.0 * turn))
    return polygon(np.stack([r * np.cos(turn), r * np.sin(turn)], axis=1))


def rod(radius: float, low: float, high: float, n: int, chamfer: float = 0.0) -> Any:
    """A cylinder along z; `chamfer`: at its lower end."""
    if chamfer <= 0.0:
        return Solid.cylinder(high - low, radius, radius, n).translate([0, 0, low])
    tip = Solid.cylinder(chamfer, radius - chamfer, radius, n).translate([0, 0, low])
    return tip + Solid.cylinder(high - low - chamfer, radius, radius, n).translate([0, 0, low + chamfer])


def prism(shape: Any, low: float, high: float) -> Any:
    return shape.extrude(high - low).translate([0, 0, low])


class Draughtsman:
    """Draws one shape after the other, each with its own habits."""

    def __init__(self, rng: Rng) -> None:
        self.rng = rng
        self.size = float(rng.choice(COARSE))
        self.n = int(rng.choice([8, 12, 16, 20, 24, 32, 48, 64]))
        self.chamfer = 0.1 * self.size if rng.random() < 0.5 else 0.0
        self.length = self.size * float(rng.uniform(1.5, 6.0))
        self.turn = float(rng.uniform(0.0, 1.0))
        self.thread = self.size / 2.0 * (1.0 if rng.random() < 0.6 else 0.85)
        self.is_stepped = self.thread < self.size / 2.0

    @property
    def flats(self) -> float:
        return float(FLATS[int(self.size)])

    def shank(self, under: float = 0.0) -> Any:
        """Down from z = `under`; threads are cylinders, of the core's diameter for some."""
        solid = rod(self.thread, under - self.length, under + 0.01 * self.size, self.n, self.chamfer)
        if self.is_stepped:
            solid += rod(self.size / 2.0, under - 0.4 * self.length, under + 0.01 * self.size, self.n)
        return solid

    def rounded_off(self, shape: Any, high: float, flats: float) -> Any:
        """A prism from 0 to `high`, its upper corners turned off for some."""
        solid = prism(shape.rotate(50.0 * self.turn), 0.0, high)
        if self.chamfer > 0.0:
            rise = 0.62 * flats
            solid = solid ^ Solid.cylinder(
                high + rise, 0.475 * flats + (high + rise), 0.475 * flats - rise + rise, self.n
            )
        return solid

    def sized(self, solid: Any, kind: str, drive: str, flats: float, top: float, is_two_sided: bool = False) -> Drawn:
        return Drawn(solid, kind, drive, flats, 2.0 * self.thread, top, is_two_sided)

    # Heads with something around them.

    def hexagon_bolt(self) -> Drawn:
        high = 0.65 * self.size
        head = self.rounded_off(regular(6, self.flats / 2.0), high, self.flats)
        return self.sized(head + self.shank(), "bolt", "hexagon", self.flats, high)

    def flange_bolt(self) -> Drawn:
        flats, high = 0.85 * self.flats, 0.75 * self.size
        head = self.rounded_off(regular(6, flats / 2.0), high, flats)
        wide = 0.75 * self.flats
        flange = Solid.cylinder(0.12 * self.size, wide, wide, self.n)
        flange += Solid.cylinder(0.12 * self.size, wide, 0.9 * flats / 2.0, self.n).translate([0, 0, 0.12 * self.size])
        return self.sized(head + flange + self.shank(), "bolt", "hexagon", flats, high)

    def square_bolt(self) -> Drawn:
        high = 0.65 * self.size
        head = self.rounded_off(regular(4, self.flats / 2.0), high, 1.2 * self.flats)
        return self.sized(head + self.shank(), "bolt", "square", self.flats, high)

    def twelve_point_bolt(self) -> Drawn:
        flats, high = 0.8 * self.flats, self.size
        star = regular(6, flats / 2.0) + regular(6, flats / 2.0, np.pi / 6.0)
        head = prism(star.rotate(50.0 * self.turn), 0.0, high)
        wide = 0.75 * self.flats
        flange = Solid.cylinder(0.2 * self.size, wide, wide, self.n)
        return self.sized(head + flange + self.shank(), "bolt", "12-point", flats, high)

    # Round heads with something in them.

    def head(self) -> tuple[Any, float, float]:
        """A round head on z = 0, its radius at the top, its height: cheese, pan, button or countersunk."""
        d = self.size
        style = self.rng.choice(["cheese", "pan", "countersunk"])
        if style == "cheese":
            wide, high = 0.8 * d, 0.65 * d
            return Solid.cylinder(high, wide, wide, self.n), wide, high
        if style == "pan":
            wide, high = 0.95 * d, 0.6 * d
            low = Solid.cylinder(0.35 * d, wide, wide, self.n)
            return (
                low + Solid.cylinder(0.25 * d, wide, 0.75 * wide, self.n).translate([0, 0, 0.35 * d]),
                0.75 * wide,
                high,
            )
        wide, high = 0.95 * d, 0.5 * d
        rim = Solid.cylinder(0.05 * d, wide, wide, self.n).translate([0, 0, 0.45 * d])
        return Solid.cylinder(0.45 * d, d / 2.0, wide, self.n) + rim, wide, high

    def recess(self, drive: str, top: float, wide: float) -> tuple[Any, float]:
        """The recess to cut out of a head that ends at height `top` (mm), and the width across its flats (mm)."""
        deep = 0.35 * self.size
        if drive == "slot":
            width = 0.25 * self.size
            return Solid.cube([4.0 * wide, width, 2.0 * deep], True).translate([0, 0, top]).rotate(
                [0, 0, 360 * self.turn]
            ), np.nan
        if drive == "cross":
            reach, width = 0.95 * self.size / 2.0 * 1.1, 0.2 * self.size
            flat = Shape.square([2.0 * reach, width], True) + Shape.square([width, 2.0 * reach], True)
            taper = 0.6 if self.rng.random() < 0.7 else 1.0
            solid = flat.extrude(1.3 * deep, 0, 0.0, [1.0 / taper, 1.0 / taper]).scale([taper, taper, 1.0])
            return solid.translate([0, 0, top - 1.3 * deep + 1e-3]).rotate([0, 0, 360 * self.turn]), np.nan
        if drive == "torx socket":
            radius = 0.42 * self.size
            return prism(
                lobes(radius, int(self.rng.choice([6, 8, 12]))).rotate(360 * self.turn), top - deep, top + 1.0
            ), np.nan
        flats = float(SOCKETS[int(self.size)])
        if drive == "12-point socket":
            star = regular(6, flats / 2.0) + regular(6, flats / 2.0, np.pi / 6.0)
            return prism(star.rotate(360 * self.turn), top - deep, top + 1.0), flats
        return prism(regular(6, flats / 2.0).rotate(360 * self.turn), top - deep, top + 1.0), flats

    def headed(self, drive: str) -> Drawn:
        head, wide, high = self.head()
        cut, flats = self.recess(drive, high, wide)
        return self.sized((head + self.shank()) - cut, "screw", drive, flats, high)

    def slotted_screw(self) -> Drawn:
        return self.headed("slot")

    def cross_screw(self) -> Drawn:
        return self.headed("cross")

    def torx_screw(self) -> Drawn:
        return self.headed("torx socket")

    def hexagon_recess_screw(self) -> Drawn:
        return self.headed("hexagon socket")

    def twelve_point_recess_screw(self) -> Drawn:
        return self.headed("12-point socket")

    def cap_screw(self) -> Drawn:
        wide, high = 0.75 * self.size, self.size
        flats = float(SOCKETS[int(self.size)])
        socket = prism(regular(6, flats / 2.0).rotate(360 * self.turn), 0.5 * high, high + 1.0)
        if self.rng.random() < 0.5:  # the drill's point
            socket += Solid.cylinder(0.15 * high, 0.0, 0.5 * flats, self.n).translate([0, 0, 0.35 * high])
        solid = Solid.cylinder(high, wide, wide, self.n) + self.shank() - socket
        return self.sized(solid, "screw", "hexagon socket", flats, high)

    def set_screw(self) -> Drawn:
        drive = str(self.rng.choice(["hexagon socket", "slot", "torx socket"]))
        self.length, self.is_stepped, self.thread = (
            self.size * float(self.rng.uniform(1.0, 3.0)),
            False,
            self.size / 2.0,
        )
        flats = 0.5 * self.size
        deep, n = 0.45 * self.size, self.n
        if drive == "hexagon socket":
            cut = prism(regular(6, flats / 2.0).rotate(360 * self.turn), -deep, 1.0)
        else:
            flats = np.nan
            kept, self.size = self.size, 0.7 * self.size
            cut, _ = self.recess(drive, 0.0, self.thread)
            self.size = kept
        solid = rod(self.thread, -self.length, 0.0, n, self.chamfer) - cut
        return Drawn(solid, "screw", drive, flats, self.size, 0.0)

    # Nuts.

    def bored(self, solid: Any, high: float) -> Any:
        radius = self.thread
        solid -= rod(radius, -high, 3.0 * high, self.n)
        if self.chamfer > 0.0:
            countersink = Solid.cylinder(self.chamfer, radius + self.chamfer, radius, self.n)
            solid -= countersink
        return solid

    def hexagon_nut(self) -> Drawn:
        high = float(self.rng.choice([0.5, 0.8, 1.0])) * self.size
        solid = self.bored(self.rounded_off(regular(6, self.flats / 2.0), high, self.flats), high)
        return self.sized(solid, "nut", "hexagon", self.flats, high, True)

    def square_nut(self) -> Drawn:
        high = float(self.rng.choice([0.5, 0.8])) * self.size
        solid = self.bored(self.rounded_off(regular(4, self.flats / 2.0), high, 1.2 * self.flats), high)
        return self.sized(solid, "nut", "square", self.flats, high, True)

    def flange_nut(self) -> Drawn:
        high, wide = 0.95 * self.size, 0.75 * self.flats
        flats = max(0.85 * self.flats, 1.5 * self.size)
        solid = self.rounded_off(regular(6, flats / 2.0), high, flats) + Solid.cylinder(
            0.15 * self.size, wide, wide, self.n
        )
        return self.sized(self.bored(solid, high), "nut", "hexagon", flats, high)

    def castle_nut(self) -> Drawn:
        high = 1.1 * self.size
        solid = self.bored(prism(regular(6, self.flats / 2.0), 0.0, high), high)
        for i in range(3):
            slot = Solid.cube([3.0 * self.flats, 0.25 * self.size, 0.8 * self.size], True)
            solid -= slot.translate([0, 0, high]).rotate([0, 0, 60.0 * i + 30.0])
        return self.sized(solid, "nut", "hexagon", self.flats, high)

    def twelve_point_nut(self) -> Drawn:
        flats, high = max(0.8 * self.flats, 1.25 * self.size), self.size
        star = regular(6, flats / 2.0) + regular(6, flats / 2.0, np.pi / 6.0)
        wide = 0.75 * self.flats
        solid = prism(star, 0.0, high) + Solid.cylinder(0.2 * high, wide, wide, self.n)
        return self.sized(self.bored(solid, high), "nut", "12-point", flats, high)

    def wing_nut(self) -> Drawn:
        d, high = self.size, 0.8 * self.size
        hub = Solid.cylinder(high, d, 0.85 * d, self.n)
        outline = np.array([[0.0, 0.1], [0.9, 0.1], [1.9, 1.0], [2.0, 1.7], [1.5, 1.8], [0.5, 0.75], [0.0, 0.7]]) * d
        wing = polygon(outline).extrude(0.3 * d).translate([0, 0, -0.15 * d]).rotate([90, 0, 0])
        solid = hub + wing + wing.rotate([0, 0, 180])
        return self.sized(self.bored(solid, high), "nut", "wings", np.nan, 1.8 * d)

    def stud_with_threads(self) -> Drawn:
        """Two threads of the core's diameter and a shank between them."""
        r, core, long = self.size / 2.0, 0.42 * self.size, self.size * float(self.rng.uniform(5.0, 12.0))
        cut = max(self.chamfer, 0.08 * self.size)
        lower = rod(core, 0.0, 0.5 * long, self.n, cut)
        solid = lower + lower.rotate([180, 0, 0]).translate([0, 0, long])
        low, high = self.rng.uniform(0.15, 0.45, 2) * long
        solid += rod(r, low, long - high, self.n)
        return Drawn(solid, "stud", "", np.nan, np.nan, long, True)

    # Less usual ones.

    def dome_nut(self) -> Drawn:
        high, round_ = 0.8 * self.size, 0.47 * self.flats
        solid = prism(regular(6, self.flats / 2.0), 0.0, high)
        solid += Solid.sphere(round_, self.n).translate([0, 0, high])
        solid = solid.trim_by_plane([0, 0, 1], 0.0) - rod(self.thread, -1.0, self.size, self.n)
        return self.sized(solid, "nut", "hexagon", self.flats, high + round_)

    def coupling_nut(self) -> Drawn:
        high = 3.0 * self.size
        solid = prism(regular(6, self.flats / 2.0), 0.0, high) - rod(self.thread, -1.0, 2.0 * high, self.n)
        return self.sized(solid, "nut", "hexagon", self.flats, high, True)

    def banjo_bolt(self) -> Drawn:
        """Hollow from its tip."""
        high = 0.65 * self.size
        solid = prism(regular(6, self.flats / 2.0), 0.0, high) + self.shank()
        bore = rod(0.2 * self.size, -2.0 * self.length, -0.1 * self.size, self.n)
        return self.sized(solid - bore, "bolt", "hexagon", self.flats, high)

    def wood_screw(self) -> Drawn:
        d = self.size
        solid = Solid.cylinder(0.5 * d, 0.5 * d, d, self.n) + rod(0.5 * d, -2.0 * d, 0.01, self.n)
        solid += Solid.cylinder(3.0 * d, 0.02 * d, 0.5 * d, self.n).translate([0, 0, -5.0 * d])
        drive = str(self.rng.choice(["cross", "slot", "torx socket"]))
        cut, _ = self.recess(drive, 0.5 * d, d)
        return Drawn(solid - cut, "screw", drive, np.nan, d, 0.5 * d)

    def square_socket_plug(self) -> Drawn:
        d = 2.0 * self.size
        cut = prism(regular(4, 0.25 * d).rotate(360 * self.turn), -0.45 * d, 1.0)
        return Drawn(rod(d / 2.0, -0.9 * d, 0.0, self.n) - cut, "screw", "square socket", 0.5 * d, d, 0.0)

    # With a collar, a bore, a shoulder, a point or a short thread.

    def collar_plug(self) -> Drawn:
        """DIN 908."""
        d, low = self.size, float(self.rng.uniform(0.5, 1.1)) * self.size
        self.thread, flats = d / 2.0, 0.5 * d
        wide = float(self.rng.uniform(1.15, 1.5)) * d / 2.0
        solid = rod(self.thread, -low, 0.01, self.n, self.chamfer) + rod(wide, 0.0, 0.25 * d, self.n)
        cut = prism(regular(6, flats / 2.0).rotate(360 * self.turn), -0.3 * d, d)
        return self.sized(solid - cut, "screw", "hexagon socket", flats, 0.25 * d)

    def hexagon_plug(self) -> Drawn:
        """DIN 910: the thread is often wider than the flats."""
        d, low = self.size, float(self.rng.uniform(0.4, 1.1)) * self.size
        self.thread, flats = d / 2.0, float(self.rng.uniform(0.65, 1.1)) * d
        wide = max(float(self.rng.uniform(1.2, 1.45)) * d / 2.0, 0.6 * flats)
        solid = rod(self.thread, -low, 0.01, self.n, self.chamfer) + rod(wide, 0.0, 0.2 * d, self.n)
        solid += prism(regular(6, flats / 2.0).rotate(360 * self.turn), 0.19 * d, 0.2 * d + 0.5 * flats)
        if self.rng.random() < 0.4:  # hollow from below
            solid -= rod(0.3 * d, -2.0 * low, -0.1 * d, self.n)
        return self.sized(solid, "bolt", "hexagon", flats, 0.2 * d + 0.5 * flats)

    def hollow_bolt(self) -> Drawn:
        made = self.hexagon_bolt()
        bore = rod(self.thread * float(self.rng.uniform(0.08, 0.4)), -2.0 * self.length, 2.0 * self.size, self.n)
        return self.sized(made.solid - bore, "bolt", "hexagon", self.flats, made.top)

    def vented_screw(self) -> Drawn:
        made = self.cap_screw()
        bore = rod(self.thread * float(self.rng.uniform(0.08, 0.4)), -2.0 * self.length, 2.0 * self.size, self.n)
        return self.sized(made.solid - bore, "screw", "hexagon socket", made.flats, made.top)

    def shoulder_screw(self) -> Drawn:
        """ISO 7379."""
        d, flats = self.size, 0.75 * self.size
        self.thread = d / 2.0
        wide, long = float(self.rng.uniform(1.15, 1.5)) * d / 2.0, d * float(self.rng.uniform(0.5, 4.0))
        solid = rod(d / 2.0, -long - 1.4 * d, 0.01, self.n, self.chamfer) + rod(wide, -long, 0.01, self.n)
        solid += rod(1.5 * wide, 0.0, 0.8 * d, self.n)
        cut = prism(regular(6, flats / 2.0).rotate(360 * self.turn), 0.3 * d, 2.0 * d)
        return self.sized(solid - cut, "screw", "hexagon socket", flats, 0.8 * d)

    def dog_point_screw(self) -> Drawn:
        """DIN 915."""
        d, long = self.size, self.size * float(self.rng.uniform(1.1, 3.0))
        self.thread, flats = d / 2.0, 0.5 * d
        solid = rod(d / 2.0, -long, 0.0, self.n, 0.5 * self.chamfer) + rod(
            float(self.rng.uniform(0.6, 0.75)) * d / 2.0, -long - 0.5 * d, -0.9 * long, self.n
        )
        cut = prism(regular(6, flats / 2.0).rotate(360 * self.turn), -0.5 * d, d)
        return self.sized(solid - cut, "screw", "hexagon socket", flats, 0.0)

    def short_bolt(self) -> Drawn:
        self.length, self.is_stepped = self.size * float(self.rng.uniform(0.35, 0.7)), False
        return self.hexagon_bolt()

    def short_cap_screw(self) -> Drawn:
        self.length, self.is_stepped = self.size * float(self.rng.uniform(0.35, 0.7)), False
        return self.cap_screw()

    def wing_screw(self) -> Drawn:
        d, high = self.size, 0.9 * self.size
        outline = np.array([[0.0, 0.1], [0.8, 0.1], [1.9, 1.0], [2.0, 1.7], [1.5, 1.8], [0.5, 0.75], [0.0, 0.7]]) * d
        wing = polygon(outline).extrude(0.3 * d).translate([0, 0, -0.15 * d]).rotate([90, 0, 0])
        solid = Solid.cylinder(high, d, 0.85 * d, self.n) + wing + wing.rotate([0, 0, 180]) + self.shank()
        return self.sized(solid, "screw", "wings", np.nan, 1.8 * d)

    def carriage_bolt(self) -> Drawn:
        """DIN 603."""
        d, wide, high = self.size, 1.1 * self.size, 0.5 * self.size
        round_ = (wide * wide + high * high) / (2.0 * high)
        head = Solid.sphere(round_, 4 * self.n).translate([0, 0, high - round_]).trim_by_plane([0, 0, 1], 0.0)
        self.is_stepped, self.length = False, self.length + d
        neck = prism(regular(4, d / 2.0).rotate(360 * self.turn), -0.6 * d, 0.01 * d)
        return self.sized(head + neck + self.shank(), "bolt", "", np.nan, high)

    # Shapes that are not fasteners.

    def hexagon_shaft(self) -> Drawn:
        """A stepped shaft: one section is a hexagon, and another one is wider."""
        d, solid, z = self.size, Solid(), 0.0
        count = int(self.rng.integers(3, 6))
        chosen = int(self.rng.integers(count))
        wider = (chosen + int(self.rng.integers(1, count))) % count
        flat = d * float(self.rng.uniform(0.3, 0.9))
        for i in range(count):
            long, wide = d * float(self.rng.uniform(0.8, 3.0)), d * float(self.rng.uniform(0.3, 0.9))
            wide = flat * float(self.rng.uniform(1.2, 1.6)) if i == wider else wide
            solid += prism(regular(6, flat), z, z + long) if i == chosen else rod(wide, z - 0.01, z + long, self.n)
            z += long
        return Drawn(solid)

    def spacer(self) -> Drawn:
        """A hexagon spacer: a thread on one side, a threaded hole in the other."""
        d, high = self.size, self.size * float(self.rng.uniform(3.5, 8.0))
        solid = prism(regular(6, 0.85 * d), 0.0, high) + rod(d / 2.0, -1.2 * d, 0.01, self.n, self.chamfer)
        solid -= rod(0.45 * d, high - 1.5 * d, high + 1.0, self.n)
        return Drawn(solid, "bolt", "hexagon", 1.7 * d, d, high)

    def hose_nipple(self) -> Drawn:
        """A thread, a hexagon and barbs around a bore."""
        d, solid = self.size, prism(regular(6, 0.8 * self.size), 0.0, 0.6 * self.size)
        solid += rod(d / 2.0, -d, 0.01, self.n, self.chamfer)
        for i in range(int(self.rng.integers(2, 5))):
            solid += Solid.cylinder(0.51 * d, 0.5 * d, 0.4 * d, self.n).translate([0, 0, (0.6 + 0.5 * i) * d - 0.01])
        return Drawn(solid - rod(0.28 * d, -2.0 * d, 5.0 * d, self.n))

    def valve_body(self) -> Drawn:
        """A hexagon between a thread and a stem, with a bore from below and one across."""
        d = self.size
        solid = prism(regular(6, d), 0.0, 1.5 * d) + rod(0.6 * d, -d, 0.01, self.n) + rod(0.7 * d, 1.49 * d, 3 * d, 32)
        solid -= rod(0.3 * d, -2.0 * d, 0.8 * d, self.n)
        return Drawn(solid - rod(0.3 * d, 0.0, 2.0 * d, self.n).rotate([90, 0, 0]).translate([0, 0, 0.7 * d]))

    def reducer(self) -> Drawn:
        """A hexagon on a thread around a wide bore: fittings and the nuts of hoses."""
        d = self.size
        solid = prism(regular(6, 0.75 * d), 0.0, 0.5 * d) + rod(d / 2.0, -self.length, 0.01, self.n)
        return Drawn(solid - rod(float(self.rng.uniform(0.26, 0.42)) * d, -9.0 * d, d, self.n))

    def hub_flange(self) -> Drawn:
        """A disc on a solid boss."""
        d = self.size
        return Drawn(rod(2.0 * d, 0.0, 0.4 * d, self.n) + rod(d, -float(self.rng.uniform(0.4, 2.0)) * d, 0.1, self.n))

    def hexagon_hub(self) -> Drawn:
        """A disc with a hexagon bore, as of a clutch."""
        d = self.size
        solid = rod(2.0 * d, 0.0, 0.5 * d, self.n) + rod(1.2 * d, -d, 0.01, self.n)
        return Drawn(solid - prism(regular(6, 0.6 * d), -2.0 * d, 2.0 * d))

    def stepped_pin(self) -> Drawn:
        """A pin with a collar."""
        d = self.size
        solid = rod(d / 2.0, -self.length, self.length, self.n, self.chamfer)
        return Drawn(solid + rod(float(self.rng.uniform(0.6, 1.0)) * d, 0.0, 0.3 * d, self.n))

    def stepped_bush(self) -> Drawn:
        """A bush with a collar and a counterbore."""
        d = self.size
        solid = rod(0.8 * d, -self.length, 0.0, self.n) + rod(1.1 * d, -0.01, 0.4 * d, self.n)
        return Drawn(solid - rod(0.5 * d, -0.3 * d, d, self.n) - rod(0.25 * d, -2.0 * self.length, d, self.n))

    def socket_tool(self) -> Drawn:
        d = self.size
        return Drawn(
            rod(d, 0.0, 3.0 * d, self.n)
            - prism(regular(6, 0.7 * d), 1.8 * d, 4.0 * d)
            - prism(regular(4, 0.4 * d), -1.0, 1.2 * d)
        )

    def standoff(self) -> Drawn:
        d = self.size
        solid = prism(regular(6, d), 0.0, 6.0 * d) - rod(0.4 * d, -1.0, 1.5 * d, self.n)
        return Drawn(solid - rod(0.4 * d, 4.5 * d, 7.0 * d, self.n))

    def hexagon_flange(self) -> Drawn:
        d = self.size
        return Drawn(prism(regular(6, 3.0 * d), 0.0, 0.4 * d) + rod(1.2 * d, 0.0, 3.0 * d, self.n))

    def square_plate_with_boss(self) -> Drawn:
        d = self.size
        return Drawn(Solid.cube([4.0 * d, 4.0 * d, 0.4 * d], True) + rod(d / 2.0, 0.0, 2.0 * d, self.n))

    def lever(self) -> Drawn:
        d = self.size
        arms = Solid.cube([6.0 * d, 0.8 * d, 0.5 * d], True).translate([0, 0, 0.4 * d])
        return Drawn(rod(d, 0.0, 0.8 * d, self.n) + arms - rod(0.5 * d, -1.0, 2.0 * d, self.n))

    def spline_shaft(self) -> Drawn:
        d, solid = self.size, rod(self.size / 2.0, 0.0, 6.0 * self.size, self.n)
        for i in range(6):
            key = Solid.cube([0.65 * d, 0.2 * d, 2.0 * d]).translate([0, -0.1 * d, 0])
            solid += key.rotate([0, 0, 60.0 * i])
        return Drawn(solid)

    def slotted_bush(self) -> Drawn:
        d = self.size
        solid = rod(d, 0.0, 2.0 * d, self.n) - rod(0.6 * d, -1.0, 9.0 * d, self.n)
        return Drawn(solid - Solid.cube([9.0 * d, 0.3 * d, 0.8 * d], True).translate([0, 0, 2.0 * d]))

    def pulley(self) -> Drawn:
        d = self.size
        solid = rod(2.0 * d, 0.0, 0.3 * d, self.n) + rod(1.5 * d, 0.2 * d, 0.8 * d, self.n)
        return Drawn(solid + rod(2.0 * d, 0.7 * d, d, self.n) - rod(0.5 * d, -1.0, 2.0 * d, self.n))

    def washer(self) -> Drawn:
        solid = Solid.cylinder(0.2 * self.size, self.size, self.size, self.n)
        return Drawn(solid - rod(0.53 * self.size, -1.0, self.size, self.n))

    def pin(self) -> Drawn:
        return Drawn(rod(self.size / 2.0, 0.0, self.length, self.n))

    def dowel(self) -> Drawn:
        half = rod(self.size / 2.0, 0.0, 0.6 * self.length, self.n, max(self.chamfer, 0.06 * self.size))
        return Drawn(half + half.rotate([180, 0, 0]).translate([0, 0, self.length]))

    def clevis_pin(self) -> Drawn:
        d = self.size
        solid = rod(d / 2.0, -self.length, 0.0, self.n, self.chamfer) + Solid.cylinder(
            0.2 * d, 0.8 * d, 0.8 * d, self.n
        )
        return Drawn(
            solid
            - Solid.cylinder(4 * d, 0.1 * d, 0.1 * d, 8, True).rotate([90, 0, 0]).translate([0, 0, -0.8 * self.length])
        )

    def rivet(self) -> Drawn:
        d = self.size
        ball = Solid.sphere(0.9 * d, self.n).scale([1, 1, 0.75])
        return Drawn(ball.trim_by_plane([0, 0, 1], 0.0) + rod(d / 2.0, -self.length, 0.01, self.n))

    def tube(self) -> Drawn:
        return Drawn(rod(self.size, 0.0, self.length, self.n) - rod(0.7 * self.size, -1.0, self.length + 1.0, self.n))

    def flanged_bush(self) -> Drawn:
        d = self.size
        solid = rod(0.7 * d, -self.length, 0.0, self.n) + Solid.cylinder(0.2 * d, d, d, self.n)
        return Drawn(solid - rod(0.5 * d, -2.0 * self.length, d, self.n))

    def cylinder(self) -> Drawn:
        return Drawn(rod(self.size, 0.0, self.size * float(self.rng.uniform(0.2, 2.0)), self.n))

    def cup(self) -> Drawn:
        high = self.size * float(self.rng.uniform(0.8, 2.5))
        return Drawn(rod(self.size, 0.0, high, self.n) - rod(0.8 * self.size, 0.2 * self.size, 2.0 * high, self.n))

    def shaft(self) -> Drawn:
        d, solid, z = self.size, Solid(), 0.0
        for _ in range(int(self.rng.integers(3, 6))):
            long = d * float(self.rng.uniform(0.8, 3.0))
            solid += rod(d * float(self.rng.uniform(0.3, 0.9)), z - 0.01, z + long, self.n)
            z += long
        return Drawn(solid)

    def keyed_shaft(self) -> Drawn:
        d = self.size
        solid = rod(d / 2.0, 0.0, 5.0 * d, self.n)
        return Drawn(solid - Solid.cube([d, 0.3 * d, 2.0 * d], True).translate([0.8 * d, 0, 5.0 * d]))

    def hexagon_bar(self) -> Drawn:
        return Drawn(prism(regular(6, self.size), 0.0, self.size * float(self.rng.uniform(3.0, 12.0))))

    def box(self) -> Drawn:
        return Drawn(Solid.cube((self.size * self.rng.uniform(0.3, 4.0, 3)).tolist()))

    def square_tube(self) -> Drawn:
        d = self.size
        return Drawn(prism(regular(4, d) - regular(4, 0.85 * d), 0.0, self.length * 2.0))

    def union(self) -> Drawn:
        d = self.size
        solid = (
            prism(regular(6, 0.9 * d), 0.0, d) + rod(0.6 * d, -1.2 * d, 0.0, self.n) + rod(0.6 * d, d, 2.2 * d, self.n)
        )
        return Drawn(solid - rod(0.35 * d, -3.0 * d, 4.0 * d, self.n))

    def gear(self) -> Drawn:
        count, r = int(self.rng.integers(12, 30)), 2.0 * self.size
        turn = np.linspace(0.0, 2.0 * np.pi, 4 * count, endpoint=False)
        radius = r * np.where(np.arange(4 * count) % 4 < 2, 1.0, 0.85)
        shape = polygon(np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1))
        return Drawn(prism(shape, 0.0, self.size) - rod(0.5 * self.size, -1.0, 2.0 * self.size, self.n))

    def knob(self) -> Drawn:
        d = self.size
        return Drawn(Solid.cylinder(d, 1.5 * d, 1.3 * d, self.n) - rod(0.4 * d, -1.0, 0.7 * d, self.n))

    def plate_with_holes(self) -> Drawn:
        d = self.size
        solid = Solid.cube([5.0 * d, 5.0 * d, 0.6 * d], True)
        for x, y in ((0, 0), (1.7, 1.7), (-1.7, 1.7), (1.7, -1.7), (-1.7, -1.7)):
            solid -= Solid.cylinder(4.0 * d, 0.4 * d, 0.4 * d, self.n, True).translate([x * d, y * d, 0])
        return Drawn(solid)

    def grooved_block(self) -> Drawn:
        d = self.size
        solid = Solid.cube([3.0 * d, 3.0 * d, d], True)
        return Drawn(solid - Solid.cube([5.0 * d, 0.6 * d, d], True).translate([0, 0, 0.7 * d]))

    def grooved_disc(self) -> Drawn:
        """A coupling's half: a wide slot across a short cylinder."""
        d = self.size
        solid = Solid.cylinder(0.8 * d, d, d, self.n)
        return Drawn(solid - Solid.cube([5.0 * d, 0.7 * d, 0.8 * d], True).translate([0, 0, 0.8 * d]))


FASTENERS = [
    *("hexagon_bolt", "flange_bolt", "square_bolt", "twelve_point_bolt", "cap_screw", "hexagon_recess_screw"),
    *("slotted_screw", "cross_screw", "torx_screw", "twelve_point_recess_screw", "set_screw", "hexagon_nut"),
    *("square_nut", "flange_nut", "castle_nut", "twelve_point_nut", "wing_nut", "stud_with_threads"),
    *("dome_nut", "coupling_nut", "banjo_bolt", "wood_screw", "square_socket_plug"),
    *("collar_plug", "hexagon_plug", "hollow_bolt", "vented_screw", "shoulder_screw", "dog_point_screw"),
    *("short_bolt", "short_cap_screw", "wing_screw", "carriage_bolt", "spacer"),
]
OTHERS = [
    *("washer", "pin", "dowel", "clevis_pin", "rivet", "tube", "flanged_bush", "cylinder", "cup", "shaft"),
    *("keyed_shaft", "hexagon_bar", "box", "square_tube", "union", "gear", "knob", "plate_with_holes"),
    *("grooved_block", "grooved_disc", "socket_tool", "standoff", "hexagon_flange", "square_plate_with_boss"),
    *("lever", "spline_shaft", "slotted_bush", "pulley"),
    *("hexagon_shaft", "hose_nipple", "valve_body", "reducer", "hub_flange", "hexagon_hub"),
    *("stepped_pin", "stepped_bush"),
]


def drawn(shape: str, seed: int) -> tuple[Drawn, feeler.Mockup, Floats]:
    """One shape of a seed: its truth, a mock-up of it without a name, and the pose of its frame in that, metres."""
    rng = np.random.default_rng([seed, *shape.encode()])
    made: Drawn = getattr(Draughtsman(rng), shape)()
    mesh = made.solid.to_mesh64()
    vertices, faces = 1e-3 * np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    pose = np.eye(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    if rng.random() < 0.7:
        pose[:3, :3] = turn * np.sign(np.linalg.det(turn))
    pose[:3, 3] = rng.uniform(-1.0, 1.0, 3) * rng.choice([0.0, 1.0, 30.0])
    vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
    if rng.random() < 0.4:
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    if rng.random() < 0.3:
        vertices = vertices.astype(np.float32).astype(np.float64) if abs(pose[:3, 3]).max() < 2.0 else vertices
    if rng.random() < 0.3:
        faces = faces[:, ::-1].copy()
    return made, feeler.Mockup(vertices, faces), pose


def fault_of(made: Drawn, pose: Floats, found: feeler.Fasteners) -> str:
    """The errors in the answer for a shape; empty if it is right."""
    if made.kind is None:
        return f"found as {found[0].kind}: {found[0].because}" if len(found) else ""
    if not len(found):
        return "missed"
    row = found[0]
    if row.kind != made.kind:
        return f"kind {row.kind}: {row.because}"
    top = pose[:3, :3] @ np.array([0.0, 0.0, 1e-3 * made.top]) + pose[:3, 3]
    along = float(row.axis @ pose[:3, 2])
    if abs(along) < 0.9999 or (along < 0 and not made.is_two_sided):
        return f"axis {along:.4f}: {row.because}"
    if along > 0 and np.linalg.norm(row.frame[:3, 3] - top) > 0.03e-3 * made.top + 2e-5:
        return f"top off by {1e3 * np.linalg.norm(row.frame[:3, 3] - top):.3f} mm: {row.because}"
    if getattr(row, "drive", "") != made.drive:
        return f"drive {getattr(row, 'drive', '')!r}: {row.because}"
    if not np.isnan(row.across_flats) and not abs(row.across_flats - 1e-3 * made.flats) < 1e-5 * made.flats:
        return f"across flats {1e3 * row.across_flats:.4g}, not {made.flats:.4g}: {row.because}"
    if not np.isnan(made.flats) and np.isnan(row.across_flats):
        return f"across flats not told: {row.because}"
    return ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", help="print the faults of this shape, or of all")
    given = parser.parse_args()
    for shape in FASTENERS + OTHERS:
        faults: list[tuple[int, str]] = []
        missed = 0
        for i in range(given.seed, given.seed + given.count):
            made, mockup, pose = drawn(shape, i)
            found = feeler.find_fasteners(mockup)
            missed += not len(found)
            fault = fault_of(made, pose, found)
            if fault:
                faults.append((i, fault))
        right = given.count - len(faults)
        print(f"{shape:28} found {given.count - missed:4}  right {right:4} of {given.count}")
        if given.show in (shape, "all"):
            for i, fault in faults:
                print(f"    seed {i}: {fault}")


if __name__ == "__main__":
    main()
