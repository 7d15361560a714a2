"""The design of the gearbox: its parts, and with them their fits, fasteners and removal paths. Millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..mesh import Floats, at, times, turned
from . import standard, train
from .assembly import Assembly, Vector, pull, screw
from .bodies import GASKET_ROOM, Blind, flanged, gasket
from .fits import BEARINGS, CIRCLIPS, KEYS, METRIC, deviation, play, stock_length
from .housing import FaceHole, SideHole, bolt_circle, case, opening, split_gasket, tapped
from .layout import (
    APEX_Z,
    BEVEL_TEETH,
    BEVEL_WIDTH,
    FACE_WIDTH,
    FLANGE_THICK,
    FRONT,
    GASKET,
    MODULE,
    REAR,
    Half,
    Layout,
    Station,
)

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AWAY = 120.0
"""How far parts go at the end of their path: beyond all neighbours."""
OUT = "housing/"
TRAIN = "gear_train/"


RING, RING_DEPTH, SQUEEZE = 2.62, 2.22, 0.2
"""Of O-rings: section, depth of the groove, and how far the ring as drawn is in either side."""


def ring_radius(spigot: float) -> float:
    """Radius of the middle line of an O-ring in the groove of a spigot."""
    return spigot - RING_DEPTH - SQUEEZE + RING / 2.0


def frame(origin: Vector, z: Vector, x: Vector | None = None) -> Floats:
    """A pose (4, 4) from its origin, its z axis and a hint for its x axis."""
    z_axis = np.asarray(z, dtype=np.float64)
    hint = np.asarray(x if x is not None else (X if abs(z_axis[0]) < 0.9 else Y), dtype=np.float64)
    y_axis = np.cross(z_axis, hint)
    y_axis /= np.sqrt(times(y_axis, y_axis))
    pose = np.eye(4)
    pose[:3, :] = np.stack([np.cross(y_axis, z_axis), y_axis, z_axis, np.asarray(origin, dtype=np.float64)], axis=1)
    return pose


class Workshop:
    """Joins parts: by bolts, bearings, covers."""

    def __init__(self, asm: Assembly, plan: Layout) -> None:
        self.asm, self.plan = asm, plan
        self.cut = asm.cut

    # --- fasteners --------------------------------------------------------------------------------------------------

    def bolt(
        self,
        group: str,
        name: str,
        size: int,
        seat: Floats,
        stack: Sequence[str],
        into: str,
        grip: float,
        deep: float,
        *,
        head: str = "bolt",
        after: Sequence[str] = (),
        door_open: bool = False,
        away: float = AWAY,
        washer: bool = True,
    ) -> list[str]:
        """A bolt with its washer through a stack of parts into a tapped hole of `into`.

        `seat`: z outwards, where the washer lies. `grip`: thickness of the stack; `deep`: of the tapped hole.
        Returns the paths of the parts added.
        """
        asm, m = self.asm, METRIC[size]
        thick = m.thick if washer else 0.0
        length = max(n for n in (8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 60) if n - grip - thick <= deep - 1.0)
        make = standard.hex_bolt if head == "bolt" else standard.cap_screw
        path = asm.add(
            f"{group}/{name}", "zinc-plated steel", make, size, float(length), pose=times(seat, at(z=thick)), spin=True
        )
        axis = seat[:3, 2]
        engaged = length - grip - thick
        asm.fit(path, into, "thread as cylinders", -(m.size - m.core) / 2.0, m.core / 2.0)
        asm.keep(into, "thread", path)
        out = [path]
        for part in stack:
            self.passes(path, part, size)
        if washer:
            beside = name.replace("bolt", "washer").replace("screw", "washer")
            ring = asm.add(f"{group}/{beside}", "zinc-plated steel", standard.washer, size, pose=seat, spin=True)
            asm.fit(path, ring, "clearance", (m.washer_bore - m.size) / 2.0, m.washer_bore / 2.0)
            asm.flush(path, ring, stack[0])
            asm.keep(path, "head", ring)
            asm.step(ring, pull(axis, away), after=[path], door_open=door_open)
            out.append(ring)
        else:
            asm.flush(path, stack[0])
        asm.step(
            path, screw(axis, seat[:3, 3], engaged + 1.0, m.pitch), pull(axis, away), after=after, door_open=door_open
        )
        tall, tool, flats = (m.head, "socket", m.flats) if head == "bolt" else (m.size, "hex key", m.socket)
        asm.fasten(
            path, "bolt" if head == "bolt" else "screw", tool, flats, times(seat, at(z=thick + tall)), list(stack)
        )
        return out

    def stud(
        self,
        group: str,
        number: int,
        size: int,
        face: Floats,
        stack: Sequence[str],
        into: str,
        grip: float,
        deep: float,
    ) -> list[str]:
        """A stud in a tapped hole of `into`, with washer and nut on a stack that begins at `face`."""
        asm, m = self.asm, METRIC[size]
        axis = face[:3, 2]
        low = -(deep - 2.0)
        high = grip + m.thick + m.nut + 2.0 * m.pitch
        stud = asm.add(f"{group}/stud_{number}", "steel", standard.stud, size, low, high, pose=face, spin=True)
        top = times(face, at(z=grip))
        washer = asm.add(f"{group}/washer_{number}", "zinc-plated steel", standard.washer, size, pose=top, spin=True)
        nut = asm.add(
            f"{group}/nut_{number}", "zinc-plated steel", standard.nut, size, pose=times(top, at(z=m.thick)), spin=True
        )
        thread = -(m.size - m.core) / 2.0
        asm.fit(stud, into, "thread as cylinders", thread, m.core / 2.0)
        asm.fit(stud, nut, "thread as cylinders", thread, m.core / 2.0)
        asm.fit(stud, washer, "clearance", (m.washer_bore - m.size) / 2.0, m.washer_bore / 2.0)
        for part in stack:
            self.passes(stud, part, size)
        asm.flush(nut, washer, stack[0])
        asm.keep(into, "thread", stud)
        asm.keep(stud, "thread", nut)
        asm.keep(nut, "head", washer)
        asm.step(nut, screw(axis, face[:3, 3], m.nut + 3.0 * m.pitch, m.pitch), pull(axis, AWAY))
        asm.step(washer, pull(axis, AWAY), after=[nut])
        asm.step(stud, screw(axis, face[:3, 3], -low + 1.0, m.pitch), pull(axis, AWAY), after=[nut])
        asm.fasten(nut, "nut", "socket", m.flats, times(top, at(z=m.thick + m.nut)), list(stack))
        return [stud, washer, nut]

    def passes(self, bolt: str, part: str, size: int) -> None:
        """A bolt or stud goes through the clearance hole of a part."""
        room = GASKET_ROOM if self.asm.parts[part].make in (gasket, split_gasket) else 0.0
        hole = METRIC[size].through / 2.0 + room
        self.asm.fit(bolt, part, "clearance", hole - size / 2.0, hole)

    # --- bearings ---------------------------------------------------------------------------------------------------

    def bearing(self, group: str, name: str, pose: Floats) -> list[str]:
        """A ball bearing about the pose's z axis, its middle there; returns inner ring, outer ring, cage, balls."""
        asm, b = self.asm, BEARINGS[name]
        inner = asm.add(f"{group}/inner_ring", "hardened steel", standard.inner_ring, name, pose=pose, spin=True)
        outer = asm.add(f"{group}/outer_ring", "hardened steel", standard.outer_ring, name, pose=pose, spin=True)
        start = float(asm.rng(group).uniform(0.0, 2.0 * np.pi / b.balls))
        cage = asm.add(f"{group}/cage", "polyamide", standard.cage, name, pose=times(pose, turned("z", start)))
        balls = []
        sag = standard.raceway_sag(self.cut, name)
        for k in range(b.balls):
            angle = start + 2.0 * np.pi * k / b.balls
            place = times(pose, turned("z", angle), at(x=b.pitch), turned("y", 0.7 + k), turned("x", 0.4 * k))
            ball = asm.add(f"{group}/ball_{k + 1}", "hardened steel", standard.ball, b.ball, pose=place)
            for ring in (inner, outer):
                asm.fit(ball, ring, "ball in raceway", 0.0, chords=sag)
            balls.append(ball)
        asm.keep(outer, "bearing", inner, cage, *balls)
        return [inner, outer, cage, *balls]

    # --- the housing and the train ----------------------------------------------------------------------------------

    def housing(self, face_holes: dict[str, list[FaceHole]], side_holes: list[SideHole]) -> None:
        """Both halves with gasket, dowels, and bolts with nuts all round."""
        asm, plan = self.asm, self.plan
        names = {}
        fits = {FRONT.name: "P7/h6", REAR.name: "G7/h6"}  # of the dowels: pressed into the front, a sliding fit behind
        hole = {half: 3.0 + deviation(fit[:2], 6.0) / 2.0 for half, fit in fits.items()}
        for half in (FRONT, REAR):
            names[half.name] = asm.add(
                OUT + half.name, "cast aluminium", case, plan, half, tuple(face_holes[half.name]),
                tuple(side_holes) if half is REAR else (), hole[half.name],
            )  # fmt: skip
        front, rear = names["front_case"], names["rear_case"]
        seal = asm.add(OUT + "split_gasket", "gasket", split_gasket, plan, 0.0, GASKET)
        asm.flush(front, seal, rear)
        unit = [front]
        for k, (x, y) in enumerate(plan.dowels):
            pin = asm.add(
                f"{OUT}dowel_{k + 1}",
                "hardened steel",
                standard.dowel,
                6.0 + deviation("h6", 6.0),
                13.0,
                pose=at(x, y, GASKET / 2.0),
                spin=True,
            )
            for half, case_path in ((FRONT, front), (REAR, rear)):
                asm.fit(pin, case_path, fits[half.name], play(fits[half.name], 6.0), hole[half.name])
            asm.fit(pin, seal, "clearance", 0.3, 3.3)
            asm.keep(front, "press", pin)
            asm.keep(pin, "dowel", front, seal, rear)
            unit.append(pin)
        m = METRIC[6]
        grip = 2.0 * FLANGE_THICK + GASKET
        length = stock_length(grip + 2.0 * m.thick + m.nut + m.pitch)
        for k, (x, y) in enumerate(plan.flange_bolts):
            low, high = frame((x, y, -FLANGE_THICK), (0.0, 0.0, -1.0)), frame((x, y, GASKET + FLANGE_THICK), Z)
            group = f"{OUT}split_bolts"
            if k in plan.tapped_bolts:
                stack = [front, seal]
                self.bolt(group, f"bolt_{k + 1}", 6, low, stack, rear, FLANGE_THICK + GASKET, FLANGE_THICK)
                continue
            bolt = asm.add(
                f"{group}/bolt_{k + 1}",
                "zinc-plated steel",
                standard.hex_bolt,
                6,
                length,
                pose=times(low, at(z=m.thick)),
                spin=True,
            )
            washers = [
                asm.add(f"{group}/{side}_washer_{k + 1}", "zinc-plated steel", standard.washer, 6, pose=pose, spin=True)
                for side, pose in (("bolt", low), ("nut", high))
            ]
            nut = asm.add(
                f"{group}/nut_{k + 1}", "zinc-plated steel", standard.nut, 6, pose=times(high, at(z=m.thick)), spin=True
            )
            for part in (front, seal, rear):
                self.passes(bolt, part, 6)
            for part in washers:
                asm.fit(bolt, part, "clearance", (m.washer_bore - m.size) / 2.0, m.washer_bore / 2.0)
            asm.fit(bolt, nut, "thread as cylinders", -(m.size - m.core) / 2.0, m.core / 2.0)
            asm.flush(bolt, washers[0], front)
            asm.flush(nut, washers[1], rear)
            asm.keep(nut, "thread", bolt)
            asm.keep(bolt, "thread", nut)
            asm.keep(bolt, "head", washers[0])
            asm.keep(nut, "head", washers[1])
            asm.step(nut, screw(Z, (x, y, 0.0), m.nut + 4.0, m.pitch), pull(Z, AWAY))
            asm.step(washers[1], pull(Z, AWAY), after=[nut])
            asm.step(bolt, pull((0.0, 0.0, -1.0), AWAY), after=[nut])
            asm.step(washers[0], pull((0.0, 0.0, -1.0), AWAY), after=[bolt])
            holds = [front, seal, rear]
            asm.fasten(bolt, "bolt", "socket", m.flats, times(low, at(z=m.thick + m.head)), holds)
            asm.fasten(nut, "nut", "socket", m.flats, times(high, at(z=m.thick + m.nut)), holds)
        needs = [OUT + "split_bolts/bolt_*", OUT + "split_bolts/washer_*", "covers/*_front/cover", "generator/gasket"]
        asm.step(unit, pull((0.0, 0.0, -1.0), 2.0 * AWAY), after=needs)
        asm.step(seal, pull((0.0, 0.0, -1.0), 2.0 * AWAY), after=[front])

    def shaft(self, s: Station, driven: str) -> None:
        """One shaft of the train with its bearings, gear, key and circlip; `driven`: its ends that drive."""
        asm, b = self.asm, s.bearing
        group = f"{TRAIN}{s.name}_shaft"
        front, rear = OUT + FRONT.name, OUT + REAR.name
        pose = times(at(s.x, s.y), turned("z", s.turn))
        main = s.name == "main"
        low = FRONT.z(FRONT.stop(b))
        shoulder = low + b.width
        rear_face = REAR.z(REAR.boss)
        journal = (b.bore + deviation("k6", b.bore)) / 2.0
        seat_kind = "H7/h6" if main else "H7/g6"
        seat = (s.seat + deviation(seat_kind[3:], s.seat)) / 2.0
        thick, groove, wide, _ = CIRCLIPS[s.seat]
        half = FACE_WIDTH / 2.0
        end = self.shaft_end(s, REAR)
        rows = [
            (journal - 1.0, self.shaft_end(s, FRONT)),
            (journal, low - 0.5),
            (journal, shoulder),
            (seat, shoulder),
            (seat, -half - wide),
        ]
        rows += [(groove / 2.0, -half - wide), (groove / 2.0, -half), (seat, -half), (seat, half), (seat + 4.0, half)]
        keyways = [train.Keyway(s.seat, -5.05, 5.05)]
        if main:
            bevel_seat = (25.0 + deviation("g6", 25.0)) / 2.0
            back, face = APEX_Z - 30.0, APEX_Z - 13.0
            clip_thick, clip_groove, clip_wide, _ = CIRCLIPS[25]
            rows += [(seat + 4.0, back), (bevel_seat, back), (bevel_seat, face), (clip_groove / 2.0, face)]
            rows += [
                (clip_groove / 2.0, face + clip_wide),
                (bevel_seat, face + clip_wide),
                (bevel_seat, face + 3.0),
                (11.5, face + 4.0),
            ]
            rows += [(11.5, rear_face)]
            keyways.append(train.Keyway(25, back + 3.45, back + 13.55))
        else:
            rows += [(seat + 4.0, half + 4.0), (journal + 2.5, half + 6.0), (journal + 2.5, rear_face)]
        rows += [(journal, rear_face), (journal, end - 1.0), (journal - 1.0, end)]
        sockets = (self.spline(s) if "low" in driven else None, self.spline(s) if "high" in driven else None)
        shaft = asm.add(f"{group}/shaft", "steel", train.shaft, tuple(rows), tuple(keyways), sockets, pose=pose)
        gear = asm.add(
            f"{group}/spur_gear",
            "steel",
            train.spur_gear,
            s.teeth,
            MODULE,
            FACE_WIDTH,
            s.seat,
            s.seat / 2.0 + 7.0,
            6,
            pose=pose,
        )
        asm.fit(gear, shaft, seat_kind, play(seat_kind, s.seat), (s.seat + deviation("H7", s.seat)) / 2.0)
        asm.flush(gear, shaft)
        key = self.key(f"{group}/key", s.seat, 0.0, pose, shaft, gear)
        clip = asm.add(
            f"{group}/circlip",
            "hardened steel",
            standard.circlip,
            s.seat,
            pose=times(pose, turned("z", 2.5), at(z=-half - thick)),
        )
        asm.flush(clip, shaft)
        asm.flush(clip, gear)
        asm.keep(clip, "circlip", gear)
        asm.keep(shaft, "groove", clip)
        bearings = []
        for name, z, holder, kind in (
            ("front", low + b.width / 2.0, front, "H7/nominal"),
            ("rear", rear_face + b.width / 2.0, rear, "H7/nominal"),
        ):
            parts = self.bearing(
                f"{group}/{name}_bearing",
                b.name,
                at(s.x, s.y, z) if name == "front" else times(at(s.x, s.y, z), turned("x", np.pi)),
            )
            asm.fit(parts[0], shaft, "nominal/k6", play("nominal/k6", b.bore), b.bore / 2.0)
            asm.flush(parts[0], shaft)
            asm.keep(parts[0], "bearing", shaft)
            asm.keep(shaft, "press", parts[0])
            asm.keep(holder, "bearing", parts[1])
            asm.fit(parts[1], holder, kind, play(kind, b.outside), (b.outside + deviation("H7", b.outside)) / 2.0)
            if name == "front":
                asm.flush(parts[1], holder)
            bearings.append(parts)
        out = (0.0, 0.0, -1.0)
        asm.step(bearings[0], pull(out, AWAY), after=[front])
        asm.step(clip, pull(out, AWAY), after=bearings[0][:1], spread=standard.spread(s.seat))
        asm.step(gear, pull(out, AWAY), after=[clip])
        asm.step(key, pull(pose[:3, 1], KEYS[s.seat][1] + 1.0), pull(out, AWAY), after=[gear])
        unit = [shaft, *bearings[1]]
        drives = ["generator/drive_shaft"] if "low" in driven else []
        turns = [shaft, gear, key, clip, *drives, *([f"{s.name}/drive_shaft"] if "high" in driven else [])]
        if main:
            wheel = self.bevel_wheel(group, shaft, back, face, clip_thick)
            unit, turns = [*unit, *wheel], [*turns, *wheel]
        rings = {f"{group}/{name}_bearing": b for name in ("front", "rear")}
        asm.bear(f"{s.name}_shaft", turns, Z, (s.x, s.y, 0.0), rings)
        asm.step(unit, pull(out, 1.5 * AWAY), after=[key, *drives, *(["input_drive/pinion_shaft"] if main else [])])

    def shaft_end(self, s: Station, half: Half) -> float:
        """The z of an end of a shaft."""
        return FRONT.z(FRONT.stop(s.bearing)) - 1.5 if half is FRONT else REAR.z(REAR.boss) + s.bearing.width + 1.0

    def spline(self, s: Station) -> train.Spline:
        """The spline in the rear end of a shaft."""
        return train.Spline(10, 0.5 * s.bearing.bore - 4.2, 0.5 * s.bearing.bore - 3.0, 16.0)

    def key(self, path: str, size: int, z: float, pose: Floats, shaft: str, hub: str) -> str:
        """A key of 10 mm, centred at z."""
        _, _, deep = KEYS[size]
        key = self.asm.add(
            path, "steel", standard.key, size, 10.0, pose=times(pose, at(y=size / 2.0 - deep + train.KEY_PLAY, z=z))
        )
        self.asm.fit(key, shaft, "key in keyway", train.KEY_PLAY)
        self.asm.fit(key, hub, "key in keyway", 2.0 * train.KEY_PLAY)
        self.asm.keep(key, "key", hub)
        self.asm.keep(hub, "captive", key)
        return key

    def bevel_wheel(self, group: str, shaft: str, back: float, face: float, thick: float) -> list[str]:
        """The bevel wheel on the main shaft with its key and circlip."""
        asm = self.asm
        pose = frame((0.0, 0.0, APEX_Z), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0))
        wheel = asm.add(
            f"{group}/bevel_wheel", "steel", train.bevel_wheel, *BEVEL_TEETH, MODULE, BEVEL_WIDTH, 25,
            APEX_Z - face, APEX_Z - back, pose=pose,
        )  # fmt: skip
        asm.fit(wheel, shaft, "H7/g6", play("H7/g6", 25.0), (25.0 + deviation("H7", 25.0)) / 2.0)
        key = self.key(f"{group}/bevel_key", 25, back + 8.5, np.eye(4), shaft, wheel)
        clip = asm.add(
            f"{group}/bevel_circlip", "hardened steel", standard.circlip, 25, pose=times(at(z=face), turned("z", -1.0))
        )
        asm.flush(wheel, shaft)
        asm.flush(clip, wheel)
        asm.flush(clip, shaft)
        asm.keep(clip, "circlip", wheel)
        asm.keep(shaft, "groove", clip)
        return [wheel, key, clip]

    def meshes(self) -> None:
        """The pairs of spur gears that mesh."""
        for a, b in pairwise(self.plan.stations):
            first, second = (f"{TRAIN}{s.name}_shaft/spur_gear" for s in (a, b))
            self.asm.fit(first, second, "gear mesh", train.mesh_play(MODULE))
            driver, driven = (b, a) if b.name == "main" else (a, b)
            self.asm.drive(f"{driver.name}_shaft", f"{driven.name}_shaft", -driver.teeth / driven.teeth)

    # --- on the pads ------------------------------------------------------------------------------------------------

    def pad(self, s: Station, half: Half) -> Floats:
        """The frame on a pad, z outwards."""
        return frame((s.x, s.y, half.z(half.pad)), (0.0, 0.0, half.sign))

    def pad_holes(self, s: Station, half: Half) -> tuple[int, list[tuple[float, float]]]:
        """Size and places of the tapped holes of a pad, in the pad's frame."""
        size, count, edge = (6, 6, 7.0) if s.pad > 35.0 else (5, 6 if s.pad > 30.0 else 5, 5.5)
        start = 0.35 + 0.2 * self.plan.stations.index(s) + (0.5 if half is REAR else 0.0)
        return size, bolt_circle((0.0, 0.0), s.pad - edge, count, start)

    def face_holes(self) -> dict[str, list[FaceHole]]:
        """All tapped holes of the pads, by half."""
        out: dict[str, list[FaceHole]] = {}
        for half in (FRONT, REAR):
            out[half.name] = []
            for s in self.plan.stations:
                size, places = self.pad_holes(s, half)
                pose = self.pad(s, half)
                for x, y in places:
                    px, py, _ = times(pose, [x, y, 0.0, 1.0])[:3].tolist()
                    out[half.name].append(FaceHole(px, py, tapped(self.cut, size, 11.0)))
        return out

    def spigot(self, s: Station) -> tuple[tuple[tuple[float, float], ...], float, float]:
        """Rows of a spigot that fits the pad's hole (H7/g6), with a groove; radius and section of its O-ring."""
        radius = opening(s) + deviation("g6", 2.0 * opening(s)) / 2.0
        floor = radius - RING_DEPTH
        rows = ((radius, 0.0), (radius, -1.2), (floor, -1.2), (floor, -4.6), (radius, -4.6), (radius - 0.4, -6.0))
        return rows, ring_radius(radius), RING

    def cover(
        self,
        s: Station,
        half: Half,
        name: str,
        up: tuple[tuple[float, float], ...],
        blinds: tuple[Blind, ...] = (),
        thick: float = 6.0,
    ) -> str:
        """A cover with spigot and O-ring on bolts."""
        asm = self.asm
        holder = OUT + half.name
        group = f"covers/{name}"
        pose = self.pad(s, half)
        size, places = self.pad_holes(s, half)
        m = METRIC[size]
        down, ring, section = self.spigot(s)
        holes = tuple((x, y, m.through / 2.0 + self.cut.ease) for x, y in places)
        path = asm.add(
            f"{group}/cover", "aluminium", flanged, (s.pad - 0.4,), thick, up, down, (), holes, blinds, pose=pose
        )
        asm.fit(path, holder, "H7/g6", play("H7/g6", 2.0 * opening(s)), opening(s))
        asm.flush(path, holder)
        gap = play("H7/g6", 2.0 * opening(s))
        seal = self.o_ring(f"{group}/o_ring", ring, section, times(pose, at(z=-2.9)), path, holder, gap)
        bolts = []
        for k, (x, y) in enumerate(places):
            bolts += self.bolt(group, f"bolt_{k + 1}", size, times(pose, at(x, y, thick)), [path], holder, thick, 11.0)
        asm.step([path, seal], pull(pose[:3, 2], AWAY), after=bolts)
        return path

    def o_ring(
        self, path: str, radius: float, section: float, pose: Floats, inside: str, outside: str, gap: float = 0.0
    ) -> str:
        """An O-ring, drawn as it is bought: it is squeezed where it sits; `gap`: between the parts that it seals."""
        asm = self.asm
        asm.add(path, "rubber", standard.o_ring, radius, section, pose=pose, spin=True)
        asm.keep(inside, "groove", path)
        for part, squeeze in ((inside, SQUEEZE), (outside, SQUEEZE - gap)):
            asm.fit(path, part, "O-ring squeezed", -squeeze, radius + section / 2.0, chords=self.cut.sag(section / 2.0))
        return path
