"""The gearbox's accessories: input drive, covers, pump, starter, generator, filter, drain plug. Millimetres."""

from __future__ import annotations

import numpy as np

from ..mesh import Floats, at, times, turned
from . import standard, train
from .assembly import pull, screw, turn
from .bodies import GASKET_ROOM, Blind, flanged, gasket, outline_of
from .design import AWAY, OUT, RING, RING_DEPTH, SQUEEZE, TRAIN, Workshop, X, Y, frame, ring_radius
from .fits import BEARINGS, CIRCLIPS, METRIC, deviation, play
from .housing import SideHole, opening, tapped
from .layout import (
    APEX_Z,
    BEVEL_TEETH,
    BEVEL_WIDTH,
    FILTER_X,
    FRONT,
    GASKET,
    MODULE,
    PLUG_X,
    REAR,
    TAPPED,
    Half,
    Station,
)
from .solid import Cut, Row, Solid

INPUT_BOLTS = ((40.0, 20.0), (-40.0, 20.0), (-40.0, -20.0), (40.0, -20.0))
FILTER_BOLTS = ((34.0, 24.0), (-34.0, 24.0), (-34.0, -24.0), (34.0, -24.0))
FILTER_PORTS = ((46.0, 0.0), (-46.0, 0.0))
FILTER_Z = 58.0
PLUG_Z = 58.0
PORT_CORE, PORT_THREAD = 5.25, 6.0


def port(cut: Cut) -> tuple[Row, ...]:
    """The hole of a union's adapter: rows of (radius, depth)."""
    core = PORT_THREAD + cut.ease if cut.ease else PORT_CORE
    return ((core, 0.0), (core, 11.0), (0.0, 13.5))


def side_frame(shop: Workshop, side: str, x: float, z: float) -> Floats:
    """A frame on the top or the bottom of the rear case at (x, z), z outwards and x along x."""
    y = float(shop.plan.side(side)[1][1])
    return frame((x, y, z), (0.0, 1.0 if side == "top" else -1.0, 0.0), X)


def side_holes(shop: Workshop) -> list[SideHole]:
    """The holes in the sides of the rear case."""
    cut = shop.cut
    out = []

    def add(side: str, x: float, z: float, rows: tuple[Row, ...]) -> None:
        middle = float(shop.plan.side(side)[1][0])
        out.append(SideHole(side, (middle - x) * (1.0 if side == "top" else -1.0), z - GASKET, rows))

    bore = 26.0 + deviation("H7", 52.0) / 2.0 + cut.ease
    add("top", 0.0, APEX_Z, ((bore + 0.8, 0.0), (bore, 0.8), (bore, 12.0)))
    for x, y in INPUT_BOLTS:
        add("top", x, APEX_Z - y, tapped(cut, 6, TAPPED))
    for x, y in FILTER_BOLTS:
        add("bottom", FILTER_X + x, FILTER_Z + y, tapped(cut, 6, TAPPED))
    add("bottom", PLUG_X, PLUG_Z, ())
    return out


def input_drive(shop: Workshop) -> None:
    """The bevel pinion's shaft in its cartridge on top of the housing."""
    asm, cut = shop.asm, shop.cut
    rear = OUT + REAR.name
    group = "input_drive"
    base = side_frame(shop, "top", 0.0, APEX_Z)
    top = float(base[1, 3])
    pose = times(base, at(z=GASKET))
    apex = frame((0.0, 0.0, APEX_Z), Y, (0.0, 0.0, -1.0))
    zero = top + GASKET  # the cartridge's own z is y less this
    shape = (100.0, 62.0, 8.0)
    seat = 20.0 + deviation("H7", 40.0) / 2.0 + cut.ease
    out = 26.0 + deviation("g6", 52.0) / 2.0
    m = METRIC[6]
    gap = play("H7/g6", 52.0)
    down = (
        (out, 0.0),
        (out, -2.6),
        (out - RING_DEPTH, -2.6),
        (out - RING_DEPTH, -6.0),
        (out, -6.0),
        (out, 45.0 - zero),
        (out - 1.0, 44.0 - zero),
    )
    up = ((28.0, 9.0), (28.0, 93.0 - zero), (27.0, 94.0 - zero))
    bore = (
        (seat + 1.0, 44.0 - zero),
        (seat, 45.0 - zero),
        (seat, 58.0 - zero),
        (17.0, 58.0 - zero),
        (17.0, 70.0 - zero),
        (seat, 70.0 - zero),
        (seat, 93.0 - zero),
        (seat + 1.0, 94.0 - zero),
    )
    holes = tuple((x, y, m.through / 2.0 + cut.ease) for x, y in INPUT_BOLTS)
    loose = tuple((x, y, m.through / 2.0 + GASKET_ROOM) for x, y in INPUT_BOLTS)
    cartridge = asm.add(f"{group}/cartridge", "cast aluminium", flanged, shape, 9.0, up, down, bore, holes, pose=pose)
    seal = asm.add(
        f"{group}/gasket",
        "gasket",
        gasket,
        shape,
        27.5,
        GASKET,
        loose,
        pose=base,
    )
    asm.flush(cartridge, seal, rear)
    asm.fit(cartridge, rear, "H7/g6", gap, 26.0)
    ring = shop.o_ring(
        f"{group}/o_ring", ring_radius(out), RING, times(pose, at(z=-4.3)), cartridge, rear, play("H7/g6", 52.0)
    )
    journal = 8.5 + deviation("k6", 17.0) / 2.0
    _thick, groove, wide, _ = CIRCLIPS[17]
    rows: tuple[Row, ...] = (
        (16.0, 34.5),
        (11.0, 36.5),
        (11.0, 46.0),
        (journal, 46.0),
        (journal, 82.0),
        (groove / 2.0, 82.0),
    )
    rows += ((groove / 2.0, 82.0 + wide), (8.0, 82.0 + wide), (8.0, 99.0), (7.0, 100.0))
    spline = train.Spline(10, 3.8, 5.0, 14.0)
    shaft = asm.add(
        f"{group}/pinion_shaft",
        "steel",
        train.shaft,
        rows,
        (),
        (None, spline),
        (BEVEL_TEETH[1], BEVEL_TEETH[0], MODULE, BEVEL_WIDTH),
        pose=apex,
    )
    unit = [cartridge, ring, shaft]
    for name, y, flip in (("lower", 52.0, np.pi), ("upper", 76.0, 0.0)):
        parts = shop.bearing(f"{group}/{name}_bearing", "6203", times(frame((0.0, y, APEX_Z), Y), turned("x", flip)))
        asm.fit(parts[0], shaft, "nominal/k6", play("nominal/k6", 17.0), 8.5)
        asm.fit(parts[1], cartridge, "H7/nominal", play("H7/nominal", 40.0), 20.0)
        asm.flush(parts[1], cartridge)
        asm.keep(parts[0], "bearing", shaft)
        asm.keep(shaft, "press", parts[0])
        asm.keep(cartridge, "bearing", parts[1])
        unit += parts
    lower, upper = f"{group}/lower_bearing/inner_ring", f"{group}/upper_bearing/inner_ring"
    sleeve = asm.add(
        f"{group}/spacer",
        "steel",
        standard.seal_washer,
        17.2,
        21.0,
        12.0,
        pose=frame((0.0, 58.0, APEX_Z), Y),
        spin=True,
    )
    clip = asm.add(f"{group}/circlip", "hardened steel", standard.circlip, 17, pose=frame((0.0, 82.0, APEX_Z), Y))
    lip = asm.add(
        f"{group}/shaft_seal",
        "rubber",
        shaft_seal,
        8.0,
        20.0 + deviation("p6", 40.0) / 2.0,
        pose=frame((0.0, 85.0, APEX_Z), Y),
        spin=True,
    )
    asm.flush(shaft, lower, sleeve, upper, clip)
    asm.fit(sleeve, shaft, "clearance", 8.6 - journal, 8.6)
    asm.flush(clip, shaft)
    asm.keep(clip, "circlip", upper, sleeve, lower)
    asm.keep(shaft, "groove", clip)
    asm.keep(cartridge, "press", lip)
    asm.fit(lip, cartridge, "H7/p6", play("H7/p6", 40.0), 20.0)
    asm.fit(lip, shaft, "seal lip", -0.2, 8.0)
    bolts = []
    for k, (x, y) in enumerate(INPUT_BOLTS):
        bolts += shop.bolt(
            group, f"bolt_{k + 1}", 6, times(pose, at(x, y, 9.0)), [cartridge, seal], rear, 9.0 + GASKET, TAPPED
        )
    asm.step([*unit, sleeve, clip, lip], pull(Y, AWAY), after=bolts)
    rings = {f"{group}/{name}_bearing": BEARINGS["6203"] for name in ("lower", "upper")}
    asm.bear("pinion_shaft", [shaft, sleeve, clip], Y, (0.0, 0.0, APEX_Z), rings)
    asm.drive("main_shaft", "pinion_shaft", BEVEL_TEETH[0] / BEVEL_TEETH[1])
    asm.step(seal, pull(Y, AWAY), after=[cartridge])
    asm.fit(f"{TRAIN}main_shaft/bevel_wheel", shaft, "gear mesh", train.bevel_play(*BEVEL_TEETH, MODULE, BEVEL_WIDTH))


def shaft_seal(cut: Cut, shaft: float, outside: float) -> Solid:
    """A lip seal on z = 0, 7 mm wide, for a shaft's radius and in a bore's."""
    lip = shaft - 0.2 + (cut.ease + 0.2 if cut.ease else 0.0)
    out = outside - (0.1 if cut.ease else 0.0)
    rows = ((shaft + 3.0, 0.0), (out - 0.5, 0.0), (out, 0.5), (out, 7.0), (shaft + 2.0, 7.0), (shaft + 2.0, 5.5))
    return standard.ring_of(
        cut, (*rows, (out - 3.0, 5.5), (out - 3.0, 2.0), (lip + 0.8, 2.0), (lip, 4.0), (lip + 0.4, 1.2))
    )


def accessory(
    shop: Workshop,
    s: Station,
    half: Half,
    group: str,
    material: str,
    up: tuple[Row, ...],
    blinds: tuple[Blind, ...] = (),
    *,
    studs: bool,
) -> str:
    """A driven accessory on a pad: body with gasket and O-ring, on studs with nuts or on bolts, and its drive shaft."""
    asm, cut = shop.asm, shop.cut
    holder = OUT + half.name
    base = shop.pad(s, half)
    pose = times(base, at(z=GASKET))
    size, places = shop.pad_holes(s, half)
    m = METRIC[size]
    down, ring, section = shop.spigot(s)
    thick = 10.0
    spline = shop.spline(s)
    bore = 8.0
    rows = (
        (bore + deviation("H7", 16.0) / 2.0 + cut.ease, down[-1][1]),
        (bore + deviation("H7", 16.0) / 2.0 + cut.ease, 16.0),
        (0.0, 19.0),
    )
    holes = tuple((x, y, m.through / 2.0 + cut.ease) for x, y in places)
    body = asm.add(f"{group}/body", material, flanged, (s.pad - 0.4,), thick, up, down, rows, holes, blinds, pose=pose)
    seal = asm.add(
        f"{group}/gasket",
        "gasket",
        gasket,
        (s.pad - 0.4,),
        opening(s) + 2.0,
        GASKET,
        tuple((x, y, m.through / 2.0 + GASKET_ROOM) for x, y in places),
        pose=base,
    )
    asm.fit(body, holder, "H7/g6", play("H7/g6", 2.0 * opening(s)), opening(s))
    asm.flush(body, seal, holder)
    gap = play("H7/g6", 2.0 * opening(s))
    o_ring = shop.o_ring(f"{group}/o_ring", ring, section, times(pose, at(z=-2.9)), body, holder, gap)
    # the drive shaft reaches from the spline's floor into the body
    end = shop.shaft_end(s, half)
    start = end - half.sign * (spline.length - 1.0)
    length = abs(half.z(half.pad) + half.sign * (GASKET + 14.0) - start)
    drive = asm.add(
        f"{group}/drive_shaft", "steel", train.quill, spline, bore + deviation("g6", 16.0) / 2.0, length,
        pose=times(at(s.x, s.y, start), turned("x", 0.0 if half is REAR else np.pi), turned("z", s.turn * half.sign)),
    )  # fmt: skip
    shaft = f"{TRAIN}{s.name}_shaft/shaft"
    asm.fit(drive, shaft, "spline", train.SPLINE_PLAY)
    asm.fit(drive, body, "H7/g6", play("H7/g6", 16.0), bore)
    asm.keep(body, "captive", drive)
    held = [body, seal]
    fasteners: list[str] = []
    for k, (x, y) in enumerate(places):
        if studs:
            fasteners += shop.stud(group, k + 1, size, times(base, at(x, y)), held, holder, GASKET + thick, 11.0)[1:]
        else:
            fasteners += shop.bolt(
                group, f"bolt_{k + 1}", size, times(pose, at(x, y, thick)), held, holder, GASKET + thick, 11.0
            )
    asm.step([body, o_ring], pull(pose[:3, 2], AWAY), after=fasteners)
    asm.step(seal, pull(pose[:3, 2], AWAY), after=[body])
    asm.step(drive, pull(pose[:3, 2], AWAY), after=[body])
    return body


PUMP_TAPPED = 10.5
"""Depth of the holes of the end cover's screws."""


def oil_pump(shop: Workshop) -> Floats:
    """The oil pump on its studs, with an end cover; returns the frame of its outlet."""
    asm, cut, s = shop.asm, shop.cut, shop.plan.station("oil_pump")
    group = "oil_pump"
    screws = [(13.8 * np.cos(a), 13.8 * np.sin(a)) for a in np.arange(5) * (2.0 * np.pi / 5.0) + 0.4]
    blinds = tuple((float(x), float(y), tapped(cut, 4, PUMP_TAPPED)) for x, y in screws)
    up = ((19.2, 10.0), (18.4, 11.0), (18.4, 22.0), (17.0, 23.0), (17.0, 26.0), (18.4, 27.0), (18.4, 45.0))
    body = accessory(shop, s, REAR, group, "painted aluminium", up, blinds, studs=True)
    face = times(shop.pad(s, REAR), at(z=GASKET + 45.0))
    holes = tuple((float(x), float(y), METRIC[4].through / 2.0 + cut.ease) for x, y in screws)
    cover = asm.add(
        f"{group}/end_cover",
        "aluminium",
        flanged,
        (18.4,),
        7.0,
        ((8.6, 7.0), (8.6, 17.0)),
        (),
        (),
        holes,
        ((0.0, 0.0, port(cut)),),
        pose=face,
    )
    asm.flush(cover, body)
    bolts = []
    for k, (x, y) in enumerate(screws):
        bolts += shop.bolt(
            group,
            f"cover_screw_{k + 1}",
            4,
            times(face, at(x, y, 7.0)),
            [cover],
            body,
            7.0,
            PUMP_TAPPED,
            head="screw",
            washer=False,
        )
    asm.step(cover, pull((0.0, 0.0, 1.0), AWAY), after=[*bolts, "lines/pressure_pipe/adapter_1"])
    asm.wait(body, cover)
    return times(face, at(z=17.0))


def starter(shop: Workshop) -> None:
    """The starter on the rear of the starter's shaft, with cooling fins and a terminal."""
    asm, s = shop.asm, shop.plan.station("starter")
    up: list[Row] = [(22.5, 10.0), (21.5, 11.0), (21.5, 24.0)]
    for k in range(0 if shop.cut.plain else 7):
        z = 26.0 + 6.0 * k
        up += [(19.0, z), (19.0, z + 3.0), (21.5, z + 3.5), (21.5, z + 5.0)]
    up += [(21.5, 78.0), (19.5, 80.0)]
    body = accessory(
        shop, s, REAR, "starter", "black aluminium", tuple(up), ((0.0, 0.0, tapped(shop.cut, 8, 14.0)),), studs=True
    )
    face = times(shop.pad(s, REAR), at(z=GASKET + 80.0))
    m = METRIC[8]
    stud = asm.add("starter/terminal_stud", "copper", standard.stud, 8, -12.0, 14.0, pose=face, spin=True)
    nut = asm.add("starter/terminal_nut", "copper", standard.nut, 8, pose=times(face, at(z=m.thick)), spin=True)
    ring = asm.add("starter/terminal_washer", "copper", standard.washer, 8, pose=face, spin=True)
    thread = -(m.size - m.core) / 2.0
    asm.fit(stud, body, "thread as cylinders", thread, m.core / 2.0)
    asm.fit(stud, nut, "thread as cylinders", thread, m.core / 2.0)
    asm.fit(stud, ring, "clearance", 0.2, m.washer_bore / 2.0)
    asm.flush(nut, ring, body)
    asm.keep(body, "thread", stud)
    asm.keep(stud, "thread", nut)
    axis = (0.0, 0.0, 1.0)
    asm.wait(body, stud, ring)
    asm.step(nut, screw(axis, face[:3, 3], 13.0, m.pitch), pull(axis, AWAY))
    asm.step(ring, pull(axis, AWAY), after=[nut])
    asm.step(stud, screw(axis, face[:3, 3], 13.0, m.pitch), pull(axis, AWAY), after=[nut])
    asm.fasten(nut, "nut", "socket", m.flats, times(face, at(z=m.thick + m.nut)), [ring])


def generator(shop: Workshop) -> Floats:
    """The generator on the front of the starter's shaft; returns the frame of its receptacle."""
    s = shop.plan.station("starter")
    up = (
        (22.5, 10.0),
        (21.5, 11.0),
        (21.5, 40.0),
        (20.0, 42.0),
        (20.0, 50.0),
        (18.0, 52.0),
        (9.0, 52.0),
        (9.0, 56.0),
        (7.0, 56.0),
        (7.0, 66.0),
    )
    accessory(shop, s, FRONT, "generator", "painted aluminium", up, studs=False)
    return times(shop.pad(s, FRONT), at(z=GASKET + 66.0))


# --- the filter -------------------------------------------------------------------------------------------------------

LIP, GROOVE, THROAT = 19.0, 23.0, 17.6
"""Radii of the bayonet's mouth, of the groove behind it, and of the bore for the bowl's neck."""
BAYONET, SLOT, LUG = np.deg2rad(60.0), np.deg2rad(54.0), np.deg2rad(44.0)
"""Of the bayonet: the angle of its turn, clockwise seen from below to lock it; the widths of its slots and lugs."""
BAYONET_STOPS, STOP = (np.deg2rad(6.0), np.deg2rad(1.0)), 3.2
"""How far a lug turns beyond the middle of its slot, and beyond its place; height of the stops."""


def lobes(cut: Cut, small: float, large: float, width: float, start: float, least: int = 3) -> Floats:
    """A circle (n, 2) with three lobes of a larger radius; the first one's middle is at `start`.

    `least`: pieces of the arc of a lobe.
    """
    out = []
    for k in range(3):
        middle = start + k * 2.0 * np.pi / 3.0
        wide = np.linspace(-width / 2.0, width / 2.0, cut.arc(large, width, least) + 1)
        rest = 2.0 * np.pi / 3.0 - width
        plain = np.linspace(width / 2.0, width / 2.0 + rest, cut.arc(small, rest, 4 if rest > width else 1) + 1)
        for radius, angle in ((large, wide), (small, plain)):
            out.append(radius * np.stack([np.cos(middle + angle), np.sin(middle + angle)], axis=1))
    return np.concatenate(out)


def filter_head(cut: Cut) -> Solid:
    """The head on z = 0: a plate with bolt holes and ports, and the socket of the bayonet, open at z = 45."""
    solid = Solid()
    points = outline_of(cut, (132.0, 64.0, 9.0))
    low, high = solid.outline(points, (0.0, 14.0))
    m = METRIC[6]
    drilled = [
        solid.turned(
            [(m.through / 2.0 + cut.ease, 0.0), (m.through / 2.0 + cut.ease, 14.0)],
            cut.circle(m.through / 2.0),
            at(x, y),
        )
        for x, y in FILTER_BOLTS
    ]
    spigot = PORT_THREAD + deviation("H7", 2.0 * PORT_THREAD) / 2.0 + cut.ease
    hole = ((spigot, 0.0), (spigot, 10.0), (0.0, 12.0))
    pits: list[Blind] = [(x, y, hole) for x, y in FILTER_PORTS]
    pits += [(x + (13.0 if x > 0.0 else -13.0), y, tapped(cut, 5, 8.0)) for x, y in FILTER_PORTS]
    ports = [solid.turned([(r, 14.0 - d) for r, d in rows], cut.circle(rows[0][0]), at(x, y))[0] for x, y, rows in pits]
    neck = cut.sharp([(29.0, 14.0), (28.0, 15.5), (28.0, 44.0), (27.0, 45.0)])
    foot, rim = solid.turned(neck, cut.circle(29.0))
    mouth, behind = solid.outline(lobes(cut, LIP, GROOVE - 1.2, SLOT, 0.0), (45.0, 40.0))
    # behind each slot of the mouth a pocket leads on to where the lug is locked; its ends are the stops
    ends = -BAYONET - LUG / 2.0 - BAYONET_STOPS[1], LUG / 2.0 + BAYONET_STOPS[0]
    pockets = lobes(cut, GROOVE - STOP, GROOVE, ends[1] - ends[0], (ends[0] + ends[1]) / 2.0, 4)
    groove, ledge = solid.outline(pockets, (40.0, 31.0))
    throat, end = solid.turned([(THROAT, 31.0), (THROAT, 18.0)], cut.circle(THROAT))
    solid.face(low, *(first for first, _ in drilled))
    solid.face(high, foot, *(last for _, last in drilled), *ports)
    solid.face(rim, mouth)
    solid.face(groove, behind)
    solid.face(ledge, throat)
    solid.face(end)
    return solid


def filter_bowl(cut: Cut) -> Solid:
    """The bowl, with its lugs turned by the bayonet's angle: from z = 20 down into the head to z = 130."""
    solid = Solid()
    neck = LIP - 0.45
    start, shoulder = solid.turned(
        [
            *cut.sharp([(THROAT - 0.6, 20.0), (THROAT - 0.1, 20.8), (THROAT - 0.1, 23.8)])[:-1],
            (THROAT - 0.1, 23.8),
            (THROAT - 1.7, 23.8),
            (THROAT - 1.7, 26.6),
            (THROAT - 0.1, 26.6),
            (THROAT - 0.1, 31.5),
        ],
        cut.arc(THROAT, 2.0 * np.pi, 12),
    )
    lug_low, lug_high = solid.outline(lobes(cut, neck, GROOVE - 1.7, LUG, -BAYONET), (31.5, 39.75))
    under, body = solid.turned(
        [(neck - 1.2, 39.75), (neck - 1.2, 47.0), (27.0, 48.0), (27.0, 116.0), (22.0, 122.0)], cut.circle(27.0)
    )
    hexagon_low, hexagon_high = standard.hex_prism(solid, cut, 27.0, 122.0, 130.0, chamfers="high")
    inner, floor = solid.turned(
        [(14.0, 20.0), (14.0, 50.0), (24.5, 55.0), *([] if cut.plain else [(24.5, 114.0)]), (20.0, 118.0)],
        cut.arc(24.5, 2.0 * np.pi, 12),
    )
    solid.wall(shoulder, lug_low) if len(shoulder) == len(lug_low) else solid.face(lug_low, shoulder)
    solid.face(lug_high, under)
    solid.face(body, hexagon_low)
    solid.face(hexagon_high)
    solid.face(start, inner)
    solid.face(floor)
    return solid


def filter_ports(shop: Workshop) -> tuple[Floats, Floats]:
    """The frames of the filter's two ports, which look down."""
    base = side_frame(shop, "bottom", FILTER_X, FILTER_Z)
    first, second = (times(base, at(x, y, GASKET + 14.0)) for x, y in FILTER_PORTS)
    return first, second


def oil_filter(shop: Workshop) -> None:
    """The filter under the housing."""
    asm, _cut = shop.asm, shop.cut
    group = "oil_filter"
    rear = OUT + REAR.name
    base = side_frame(shop, "bottom", FILTER_X, FILTER_Z)
    pose = times(base, at(z=GASKET))
    m = METRIC[6]
    head = asm.add(f"{group}/head", "cast aluminium", filter_head, pose=pose)
    seal = asm.add(
        f"{group}/gasket",
        "gasket",
        gasket,
        (132.0, 64.0, 9.0),
        15.0,
        GASKET,
        tuple((x, y, m.through / 2.0 + GASKET_ROOM) for x, y in FILTER_BOLTS),
        pose=base,
    )
    asm.flush(head, seal, rear)
    bowl = asm.add(f"{group}/bowl", "painted aluminium", filter_bowl, pose=pose)
    asm.fit(bowl, head, "bayonet", 0.1, THROAT)
    asm.keep(head, "bayonet", bowl)
    ring = shop.o_ring(f"{group}/o_ring", THROAT - 1.7 - SQUEEZE + 1.05, 2.1, times(pose, at(z=25.2)), bowl, head)
    element = asm.add(
        f"{group}/element", "filter paper", standard.ring_of,
        ((7.0, 18.3), (13.4, 18.3), (13.4, 118.0), (7.0, 118.0)), 13.4, pose=pose,
    )  # fmt: skip
    asm.flush(element, bowl)
    asm.keep(bowl, "captive", element)
    down = (0.0, -1.0, 0.0)
    limits = -BAYONET_STOPS[1], BAYONET + BAYONET_STOPS[0]
    asm.joint("filter_bowl", [bowl, ring, element], down, pose[:3, 3], limits)
    asm.step([bowl, ring, element], turn(down, pose[:3, 3], BAYONET), pull(down, 130.0), door_open=True)
    # of the wrench
    in_the_way: list[list[str]] = [["lines/pressure_pipe/adapter_2"], ["lines/oil_pipe/adapter_2"], [], []]
    bolts = []
    for k, (x, y) in enumerate(FILTER_BOLTS):
        bolts += shop.bolt(
            group,
            f"bolt_{k + 1}",
            6,
            times(pose, at(x, y, 14.0)),
            [head, seal],
            rear,
            14.0 + GASKET,
            TAPPED,
            after=in_the_way[k],
            away=100.0,
        )
    asm.step(
        head,
        pull(down, 100.0),
        after=[*bolts, bowl],
        door_open=True,
    )
    asm.step(seal, pull(down, 100.0), after=[head])


def drain_plug(shop: Workshop) -> None:
    """The drain plug, whose thread is a helix, with its copper washer."""
    asm = shop.asm
    base = side_frame(shop, "bottom", PLUG_X, PLUG_Z)
    rear = OUT + REAR.name
    plug = asm.add("housing/drain_plug", "zinc-plated steel", standard.threaded_plug, pose=times(base, at(z=1.5)))
    ring = asm.add("housing/drain_washer", "copper", standard.seal_washer, 14.4, 20.0, 1.5, pose=base, spin=True)
    asm.flush(plug, ring, rear)
    asm.fit(plug, ring, "clearance", 0.2, 7.2)
    asm.fit(plug, rear, "thread as helices", *standard.thread_play(asm.cut))
    asm.keep(rear, "thread", plug)
    down = base[:3, 2]
    asm.step(plug, screw(down, base[:3, 3], 13.0, standard.PLUG_PITCH), pull(down, 60.0))
    asm.step(ring, pull(down, 60.0), after=[plug])
    asm.fasten(plug, "bolt", "socket", standard.PLUG_FLATS, times(base, at(z=10.5)), [ring])
