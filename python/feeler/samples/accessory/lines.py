"""Pipes and hoses with their unions, and the wiring harness. Millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..mesh import Floats, at, times
from .accessories import PORT_CORE, PORT_THREAD, port
from .assembly import Vector, pull, screw
from .bodies import Drill, bent, extruded, flanged, plate, swept
from .design import AWAY, OUT, Workshop, frame
from .fits import METRIC, deviation, play
from .housing import FaceHole, tapped
from .layout import FILTER_X, REAR, Layout
from .solid import Cut, Row, Solid
from .standard import hex_prism

BEND = 16.0
THREAD, CORE = PORT_THREAD, PORT_CORE
NOSE, NUT_CORE = 7.0, 6.25
NOSE_END = 18.0
COLLAR, COLLAR_RADIUS = 5.0, 5.6
NUT_LOW, NUT_HIGH = 9.5, 30.0
UNSCREWED = 10.0
"""How far a union nut goes back: off its thread, and not into the pipe's bend."""
PIPE, BORE = 4.0, 3.0
ELBOW_COLLAR = 5.0
REACH = 42.0
"""From the axis of an elbow to its flat face."""


def adapter(cut: Cut) -> Solid:
    """A union's adapter: its thread on z < 0, a hexagon, and a threaded nose with a flat face at z = 18."""
    solid = Solid()
    end, neck = solid.turned(cut.sharp([(THREAD - 0.6, -9.0), (THREAD, -8.0), (THREAD, 0.0)]), cut.circle(THREAD))
    low, high = hex_prism(solid, cut, 17.0, 0.0, 8.0, chamfers="high")
    foot, face = solid.turned(
        cut.sharp([(NOSE, 8.0), (NOSE, NOSE_END - 0.8), (NOSE - 0.8, NOSE_END)]), cut.circle(NOSE)
    )
    solid.wall(neck, low)
    solid.face(high, foot)
    if cut.plain:
        solid.face(end)
        solid.face(face)
    else:
        mouth, out = solid.turned([(BORE, -9.0), (BORE, NOSE_END)], cut.circle(BORE))
        solid.face(end, mouth)
        solid.face(face, out)
    return solid


def elbow(cut: Cut, reach: float) -> Solid:
    """An elbow whose spigot is on z < 0 and that leads to +x: its flat face is `reach` from the axis."""
    path = bent(cut, np.array([[0.0, 0.0, -9.0], [0.0, 0.0, 18.0], [reach, 0.0, 18.0]]), 8.0, 6.0)
    solid = Solid()
    n = cut.circle(NOSE)
    angle = (np.arange(n) + 0.4) * (2.0 * np.pi / n)
    rings: list[Floats] = []

    def ring(point: Floats, way: Floats, radius: float) -> None:
        side = np.array([0.0, 1.0, 0.0])
        across = np.cross(way, side)
        rings.append(point + radius * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * side))

    up, out = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    spigot = THREAD + deviation("g6", 2.0 * THREAD) / 2.0
    ends = [
        (spigot - 0.6, -9.0),
        (spigot, -8.0),
        (spigot, 0.0),
        (8.5, 0.0),
        (8.5, ELBOW_COLLAR),
        (COLLAR_RADIUS, ELBOW_COLLAR),
    ]
    for radius, z in cut.sharp(ends):
        ring(np.array([0.0, 0.0, z]), up, radius)
    for point, way in zip(path.points[1:-1], path.tangents[1:-1], strict=True):
        ring(point, way, 5.6)
    nose = [(5.6, reach - 12.0), (NOSE, reach - 10.5), (NOSE, reach - 0.8), (NOSE - 0.8, reach)]
    for radius, x in nose[:2] + ([(NOSE, reach)] if cut.plain else nose[2:]):
        ring(np.array([x, 0.0, 18.0]), out, radius)
    first, last = solid.tube(np.stack(rings))
    if cut.plain:
        solid.face(first)
        solid.face(last)
    else:
        rings.clear()
        for point, way in zip(path.points, path.tangents, strict=True):
            ring(point, way, BORE)
        mouth, out = solid.tube(np.stack(rings))
        solid.wall(first, mouth)
        solid.wall(last, out)
    return solid


def elbow_end(place: Floats) -> Floats:
    """The middle (3,) of the flat face of an elbow in a port that looks down; the elbow leads to +z."""
    return np.asarray(times(place, [0.0, 0.0, 18.0, 1.0])[:3] + np.array([0.0, 0.0, REACH]))


def union_nut(cut: Cut) -> Solid:
    """A union nut over an adapter's nose and a pipe's collar, in the adapter's frame."""
    solid = Solid()
    low, high = hex_prism(solid, cut, 17.0, NUT_LOW, NUT_HIGH, chamfers="low high")
    core = NOSE + cut.ease if cut.ease else NUT_CORE
    shoulder = NOSE_END + COLLAR
    mouth, end = solid.turned(
        [
            *cut.sharp([(core + 0.5, NUT_LOW), (core, NUT_LOW + 0.5), (core, shoulder)]),
            (PIPE + 0.4 + cut.ease, shoulder),
            (PIPE + 0.4 + cut.ease, NUT_HIGH),
        ],
        cut.circle(core),
    )
    solid.wall(low, mouth)
    solid.wall(end, high)
    return solid


def line(
    shop: Workshop,
    group: str,
    material: str,
    ports: Sequence[tuple[Floats, str, str]],
    level: float,
    *,
    kind: str = "pipe",
    after: Sequence[str] = (),
    bore: float = BORE,
) -> tuple[str, Floats, Floats]:
    """A pipe between two ports that look along +z (or down, through an elbow), with a straight run at z = level.

    `ports`: frame, holder, and "straight" or "elbow". Returns the pipe and the ends of its run.
    """
    asm = shop.asm
    ends, nuts = [], []
    z = np.array([0.0, 0.0, 1.0])
    thread = CORE - THREAD
    for k, (place, holder, form) in enumerate(ports):
        if form == "straight":
            fitting = asm.add(f"{group}/adapter_{k + 1}", "stainless steel", adapter, pose=place, spin=True)
            base = frame(place[:3, 3], z)
            asm.fit(fitting, holder, "thread as cylinders", thread, CORE)
            asm.keep(holder, "thread", fitting)
            asm.step(fitting, screw(z, place[:3, 3], 10.0, 1.5), pull(z, 60.0), after=[f"{group}/{kind}"])
        else:
            pose = frame(place[:3, 3], place[:3, 2], z)
            fitting = asm.add(f"{group}/adapter_{k + 1}", "stainless steel", elbow, REACH, pose=pose)
            base = frame(elbow_end(place) - NOSE_END * z, z)
            asm.fit(fitting, holder, "H7/g6", play("H7/g6", 2.0 * THREAD), THREAD)
            held = elbow_clamp(shop, group, fitting, pose, holder)
            asm.step([fitting, held[0]], pull(pose[:3, 2], 60.0), after=[f"{group}/{kind}", *held[1:]])
        asm.wait(holder, fitting)
        asm.flush(fitting, holder)
        nut = asm.add(f"{group}/union_nut_{k + 1}", "stainless steel", union_nut, pose=base, spin=True)
        asm.fit(nut, fitting, "thread as cylinders", NUT_CORE - NOSE, NUT_CORE)
        asm.keep(fitting, "thread", nut)
        ends.append(times(base, [0.0, 0.0, NOSE_END, 1.0])[:3])
        nuts.append(nut)
        asm.fasten(nut, "nut", "open-end wrench", 17.0, times(base, at(z=NUT_HIGH)), [f"{group}/{kind}"])
    a, b = ends
    corners = (a, np.array([a[0], a[1], level]), np.array([b[0], b[1], level]), b)
    asm.lines.append((f"{group}/{kind}", np.array(corners), PIPE, BEND))
    rows: tuple[Row, ...] = ((COLLAR_RADIUS, 0.0), (COLLAR_RADIUS, COLLAR), (PIPE, COLLAR))
    pipe = asm.add(f"{group}/{kind}", material, swept, tuple(tuple(map(float, c)) for c in corners), BEND, rows, bore)
    for k, nut in enumerate(nuts):
        asm.fit(nut, pipe, "clearance", 0.4, PIPE + 0.4)
        asm.fit(nut, pipe, "clearance", NUT_CORE - COLLAR_RADIUS, NUT_CORE)
        asm.flush(nut, pipe, f"{group}/adapter_{k + 1}")
        asm.step(nut, screw(z, ends[k], UNSCREWED, 1.5), door_open=ports[k][2] == "elbow", removes=False)
    asm.step([pipe, *nuts], pull(z, 1.5 * AWAY), after=after)
    return pipe, corners[1], corners[2]


def return_level(begin: Floats, end: Floats, outlet: Floats) -> float:
    """The height of the return hose's run between two ports: above the nut on the oil pump's outlet where it would pass
    that by less than `APART`."""
    a, b, at_nut = begin[:2, 3], end[:2, 3], outlet[:2, 3]
    along = (b - a) / np.linalg.norm(b - a)
    offset = at_nut - a
    beside = abs(along[0] * offset[1] - along[1] * offset[0])
    return RETURN_LEVEL if beside >= NUT_CORNER + PIPE + APART else RETURN_ABOVE


def elbow_clamp(shop: Workshop, group: str, fitting: str, pose: Floats, holder: str) -> list[str]:
    """The plate that holds an elbow by its collar, with its screw; the plate stays on the elbow."""
    asm, cut = shop.asm, shop.cut
    side = -1.0 if pose[0, 3] > FILTER_X else 1.0
    ears = ((-9.0, -9.0), (9.0, -9.0), (9.0, 20.0), (-9.0, 20.0))
    corners = ears if side > 0.0 else tuple((x, -y) for x, y in ears[::-1])
    holes = ((0.0, 0.0, 6.1), (0.0, 13.0 * side, METRIC[5].through / 2.0 + cut.ease))
    base = times(pose, at(z=ELBOW_COLLAR))
    plate_path = asm.add(f"{group}/elbow_clamp", "zinc-plated steel", plate, corners, 4.0, 3.0, holes, pose=base)
    asm.flush(plate_path, fitting)
    asm.keep(plate_path, "clamp", fitting)
    asm.fit(plate_path, fitting, "clearance", 0.5, 6.1)
    seat = times(base, at(0.0, 13.0 * side, 3.0))
    bolts = shop.bolt(
        group, "clamp_screw", 5, seat, [plate_path], holder, 3.0 + ELBOW_COLLAR, 8.0, head="screw", door_open=True
    )
    asm.fasteners[-1].holds.append(fitting)
    asm.wait(holder, *bolts)
    return [plate_path, *bolts]


def loop_outline(cut: Cut, radius: float, reach: float, low: float, high: float) -> tuple[tuple[float, float], ...]:
    """A flat tab from x = 0 to `reach` between y = low and high that ends in a round eye about the origin."""
    start, stop = np.arcsin(high / radius), 2.0 * np.pi + np.arcsin(low / radius)
    angle = np.linspace(start, stop, cut.arc(radius, stop - start, 6) + 1)
    eye = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return ((reach, low), (reach, high), *map(tuple, eye.tolist()))


CLIP_AT, CLIP_ASIDE = (0.36, 0.33, 0.39, 0.42, 0.45, 0.48, 0.51, 0.54, 0.57, 0.6), 15.5
"""Shares of the oil pipe's run at which its clip may be, the best first; how far its post stands beside."""
POST_ROOM = 7.5
"""Between the middle of the post and a pad: half its width over corners, a gap, and a chord."""
OIL_PORT = (-10.0, 0.0)
NUT_CORNER = 17.0 / math.sqrt(3.0)
"""Half the width of union nuts across their corners."""
APART = 5.3
"""How far pipes and hoses are from what they do not fit, chords included."""
RETURN_LEVEL, RETURN_ABOVE = 178.0, 207.0
OIL_LEVEL = 172.0


def oil_run(plan: Layout, filter_port: Vector) -> tuple[Floats, Floats, Floats]:
    """Of the oil pipe's run: the place of its clip, its direction, and the place of the clip's post, (3,) each."""
    main = plan.station("main")
    a = np.array([main.x + OIL_PORT[0], main.y + OIL_PORT[1], OIL_LEVEL])
    b = np.array([filter_port[0], filter_port[1], OIL_LEVEL])
    way = (b - a) / np.sqrt(times(b - a, b - a))
    aside = np.cross([0.0, 0.0, 1.0], way) * CLIP_ASIDE
    pads = np.array([s.centre for s in plan.stations]), np.array([s.pad for s in plan.stations])

    def room(share: float) -> float:
        """Between the post and the nearest pad."""
        foot = (a + (b - a) * share + aside)[:2]
        return float((np.hypot(*(pads[0] - foot).T) - pads[1]).min())

    share = next((share for share in CLIP_AT if room(share) > POST_ROOM), max(CLIP_AT, key=room))
    place = a + (b - a) * share
    return place, way, place + aside


def post_hole(plan: Layout, cut: Cut, filter_port: Vector) -> FaceHole:
    """The hole of the clip's post in the rear case."""
    x, y, _ = oil_run(plan, filter_port)[2].tolist()
    return FaceHole(x, y, (*tapped(cut, 4, 6.0)[:-1], (0.0, 6.8)), True)


def post(cut: Cut, length: float) -> Solid:
    """A hexagon post on z = 0 with a thread M4 below and a tapped hole M5 in its end."""
    solid = Solid()
    end, neck = solid.turned(cut.sharp([(1.6, -5.5), (2.0, -5.1), (2.0, 0.0)]), cut.circle(2.0, 6))
    low, high = hex_prism(solid, cut, 10.0, 0.0, length, chamfers="high")
    rows = tapped(cut, 5, 10.0)
    mouth, _ = solid.turned([(r, length - d) for r, d in rows], cut.circle(rows[0][0], 6))
    solid.wall(neck, low)
    solid.face(high, mouth)
    solid.face(end)
    return solid


def pipe_clip(shop: Workshop, pipe: str, filter_port: Vector) -> list[str]:
    """The clip of the oil pipe on its post; the clip stays on the pipe."""
    asm, cut = shop.asm, shop.cut
    place, way, foot = oil_run(shop.plan, filter_port)
    rear = OUT + REAR.name
    base = frame((foot[0], foot[1], REAR.z(REAR.outer)), (0.0, 0.0, 1.0))
    length = OIL_LEVEL - 1.25 - REAR.z(REAR.outer)
    stand = asm.add("lines/oil_pipe/post", "zinc-plated steel", post, length, pose=base, spin=True)
    thread = METRIC[4]
    asm.fit(stand, rear, "thread as cylinders", -(thread.size - thread.core) / 2.0, thread.core / 2.0)
    asm.flush(stand, rear)
    asm.keep(rear, "thread", stand)
    outline = loop_outline(cut, 6.0, CLIP_ASIDE + 7.0, -1.25, 1.25)
    drill = Drill(
        len(outline) - 1, CLIP_ASIDE - outline[-1][0], 7.0, ((2.75 + cut.ease, 0.0), (2.75 + cut.ease, 2.5)), 1
    )
    pose = frame(place - 7.0 * way, way, np.cross([0.0, 0.0, 1.0], way))
    clip = asm.add(
        "lines/oil_pipe/clip",
        "stainless steel",
        extruded,
        outline,
        0.0,
        14.0,
        (drill,),
        ((0.0, 0.0, PIPE + 0.3 + cut.ease),),
        pose=pose,
    )
    asm.fit(clip, pipe, "clearance", 0.3, PIPE + 0.3)
    asm.flush(clip, stand)
    asm.keep(clip, "clip", pipe)
    top = frame((foot[0], foot[1], OIL_LEVEL + 1.25), (0.0, 0.0, 1.0))
    bolts = shop.bolt("lines/oil_pipe", "clip_bolt", 5, top, [clip], stand, 2.5, 10.0)
    asm.fasteners[-1].holds.append(pipe)
    asm.step(stand, screw((0.0, 0.0, 1.0), foot, 6.0, thread.pitch), pull((0.0, 0.0, 1.0), AWAY), after=[pipe])
    for step in asm.steps:
        if pipe in step.parts:
            step.parts.append(clip)
            step.after += bolts
    return bolts


# --- the harness ------------------------------------------------------------------------------------------------------

PLUG_BORE, CABLE, CABLE_BEND = 7.25, 2.4, 14.0


def plug(cut: Cut) -> Solid:
    """A plug over a receptacle's nose that ends at z = 0; the cable comes out at z = 20."""
    solid = Solid()
    rows = [(PLUG_BORE + 0.4 + cut.ease, -8.5), (PLUG_BORE + cut.ease, -8.0), (PLUG_BORE + cut.ease, 0.6)]
    mouth, floor = solid.turned(cut.sharp(rows), cut.circle(PLUG_BORE))
    grip = [(9.6, 10.0)] if cut.plain else [(9.6, 4.0), (8.6, 5.0), (8.6, 10.0)]
    ring = cut.sharp([(9.0, -8.5), (9.6, -8.0), *grip, (5.0, 14.0), (5.0, 20.0)])
    rim, back = solid.turned(ring, cut.circle(9.6))
    hole = CABLE - 0.02 + (cut.ease + 0.02 if cut.ease else 0.0)
    start, pit = solid.turned([(hole, 20.0), (hole, 12.0)], cut.circle(CABLE, 6))
    solid.face(rim, mouth)
    solid.face(floor)
    solid.face(back, start)
    solid.face(pit)
    return solid


def sensor(cut: Cut) -> Solid:
    """A speed sensor: its thread on z < 0, a hexagon, and a receptacle that ends at z = 20."""
    solid = Solid()
    end, neck = solid.turned(cut.sharp([(THREAD - 0.6, -9.0), (THREAD, -8.0), (THREAD, 0.0)]), cut.circle(THREAD))
    low, high = hex_prism(solid, cut, 17.0, 0.0, 8.0, chamfers="high")
    foot, face = solid.turned(cut.sharp([(NOSE, 8.0), (NOSE, 19.4), (NOSE - 0.6, 20.0)]), cut.circle(NOSE))
    solid.wall(neck, low)
    solid.face(high, foot)
    solid.face(end)
    solid.face(face)
    return solid


def speed_sensor(shop: Workshop, name: str, cover: str, face: Floats) -> str:
    """A speed sensor in a cover."""
    asm = shop.asm
    path = asm.add(f"harness/{name}_sensor", "steel", sensor, pose=face, spin=True)
    asm.fit(path, cover, "thread as cylinders", CORE - THREAD, CORE)
    asm.flush(path, cover)
    asm.keep(cover, "thread", path)
    asm.step(
        path, screw(face[:3, 2], face[:3, 3], 10.0, 1.5), pull(face[:3, 2], AWAY), after=[f"harness/{name}_sensor_plug"]
    )
    asm.fasten(path, "bolt", "open-end wrench", 17.0, times(face, at(z=8.0)), [path])
    return path


def blank(shop: Workshop, cover: str, face: Floats) -> str:
    """A blanking plug in the port of a cover."""
    asm = shop.asm
    path = asm.add(cover.replace("/cover", "/blanking_plug"), "zinc-plated steel", blanking_plug, pose=face, spin=True)
    asm.fit(path, cover, "thread as cylinders", CORE - THREAD, CORE)
    asm.flush(path, cover)
    asm.keep(cover, "thread", path)
    asm.step(path, screw(face[:3, 2], face[:3, 3], 10.0, 1.5), pull(face[:3, 2], AWAY))
    asm.fasten(path, "bolt", "socket", 15.0, times(face, at(z=7.0)), [path])
    return path


def blanking_plug(cut: Cut) -> Solid:
    """A plug: its thread on z < 0, its hexagon above."""
    solid = Solid()
    end, neck = solid.turned(cut.sharp([(THREAD - 0.6, -9.0), (THREAD, -8.0), (THREAD, 0.0)]), cut.circle(THREAD))
    low, high = hex_prism(solid, cut, 15.0, 0.0, 7.0, chamfers="high")
    solid.wall(neck, low)
    solid.face(end)
    solid.face(high)
    return solid


def harness(shop: Workshop, sources: Sequence[tuple[str, Floats, str]], sockets: Sequence[tuple[Floats, str]]) -> None:
    """A cable from each source (name, frame at the end of its receptacle, its part) to a socket of the junction box."""
    asm = shop.asm
    out = (0.0, 0.0, -1.0)
    unit: list[str] = []
    for k, ((name, source, owner), (socket, box)) in enumerate(zip(sources, sockets, strict=True)):
        ends = []
        for end, pose, part in (("", source, owner), ("_box", socket, box)):
            piece = asm.add(f"harness/{name}{end}_plug", "anodised aluminium", plug, pose=pose, spin=True)
            asm.fit(piece, part, "plug on receptacle", PLUG_BORE - NOSE, PLUG_BORE)
            asm.keep(part, "plugged", piece)
            ends.append(times(pose, [0.0, 0.0, 12.3, 1.0])[:3])
            unit.append(piece)
        level = min(float(e[2]) for e in ends) - 46.0 - 9.0 * k
        a, b = ends
        corners = (a, np.array([a[0], a[1], level]), np.array([b[0], b[1], level]), b)
        cable = asm.add(
            f"harness/{name}_cable",
            "rubber",
            swept,
            tuple(tuple(map(float, c)) for c in corners),
            CABLE_BEND,
            ((CABLE, 0.0), (CABLE, 1.0)),
            0.0,
        )
        asm.lines.append((cable, np.array(corners), CABLE, CABLE_BEND))
        for piece in unit[-2:]:
            asm.fit(cable, piece, "press of 20 um", -0.02, CABLE)
            asm.keep(piece, "press", cable)
        unit.append(cable)
    asm.step(unit, pull(out, AWAY))


def junction_box(shop: Workshop, beam: str, face: Floats, count: int) -> list[tuple[Floats, str]]:
    """The junction box on the beam; returns the frames at the ends of its receptacles, and these."""
    asm, cut = shop.asm, shop.cut
    screws = ((48.0, 14.0), (-48.0, 14.0), (-48.0, -14.0), (48.0, -14.0))
    holes = tuple((x, y, 2.25 + cut.ease) for x, y in screws)
    places = [(26.0 * (k - (count - 1) / 2.0), 0.0) for k in range(count)]
    blinds = tuple((x, y, port(cut)) for x, y in places)
    box = asm.add(
        "harness/junction_box",
        "glass-filled polyamide",
        flanged,
        (116.0, 40.0, 6.0),
        16.0,
        (),
        (),
        (),
        holes,
        blinds,
        pose=face,
    )
    asm.flush(box, beam)
    bolts = []
    for k, (x, y) in enumerate(screws):
        bolts += shop.bolt(
            "harness",
            f"box_screw_{k + 1}",
            4,
            times(face, at(x, y, 16.0)),
            [box],
            beam,
            16.0,
            10.0,
            head="screw",
            washer=False,
        )
    asm.step(box, pull((0.0, 0.0, -1.0), AWAY), after=[*bolts, "harness/receptacle_*"])
    sockets = []
    for k, (x, y) in enumerate(places):
        pose = times(face, at(x, y, 16.0))
        part = asm.add(f"harness/receptacle_{k + 1}", "aluminium", sensor, pose=pose, spin=True)
        asm.fit(part, box, "thread as cylinders", CORE - THREAD, CORE)
        asm.flush(part, box)
        asm.keep(box, "thread", part)
        asm.step(part, screw(face[:3, 2], pose[:3, 3], 10.0, 1.5), pull(face[:3, 2], AWAY), after=["harness/*_plug"])
        sockets.append((times(pose, at(z=20.0)), part))
    return sockets
