"""The whole gearbox."""

from __future__ import annotations

from ..mesh import at, times
from . import accessories, lines, stand
from .accessories import port
from .assembly import Assembly
from .design import Workshop
from .layout import FRONT, REAR, layout
from .solid import Cut

FLANGE_BOLTS = 20
BOX_X, BOX_SCREWS = 116.0, ((48.0, -14.0), (-48.0, -14.0), (-48.0, 14.0), (48.0, 14.0))


def build(cut: Cut, seed: int) -> Assembly:
    """The gearbox at a chord."""
    asm = Assembly(cut, seed)
    plan = layout(seed, asm.rng("layout"), FLANGE_BOLTS + (int(asm.rng("bolts").integers(-2, 3)) if seed else 0))
    shop = Workshop(asm, plan)
    ports = accessories.filter_ports(shop)
    face_holes = shop.face_holes()
    face_holes[REAR.name].append(lines.post_hole(plan, cut, lines.elbow_end(ports[1])))
    shop.housing(face_holes, [*accessories.side_holes(shop), *stand.side_holes(shop)])
    for s in plan.stations:
        shop.shaft(s, {"starter": "low high", "oil_pump": "high"}.get(s.name, ""))
    shop.meshes()
    accessories.input_drive(shop)
    outlet = accessories.oil_pump(shop)
    accessories.starter(shop)
    receptacle = accessories.generator(shop)
    accessories.oil_filter(shop)
    accessories.drain_plug(shop)
    sources = [("generator", receptacle, "generator/body")]
    covers = {}
    for s in plan.stations:
        for half in (FRONT, REAR):
            name = f"{s.name}_{half.name[:-5]}"
            if name in ("starter_front", "starter_rear", "oil_pump_rear"):
                continue
            r = s.pad - (16.0 if s.pad > 30.0 else 12.0)
            place = lines.OIL_PORT if name == "main_rear" else (0.0, 0.0)
            covers[name] = shop.cover(s, half, name, ((r, 6.0), (r - 1.0, 13.0)), ((*place, port(cut)),))
            face = times(shop.pad(s, half), at(z=13.0))
            if name in ("main_front", "oil_pump_front", "breather_front"):
                sensor = lines.speed_sensor(shop, s.name, covers[name], face)
                asm.wait(covers[name], sensor)
                sources.append((f"{s.name}_sensor", times(face, at(z=20.0)), sensor))
            elif name == "idler_front":
                asm.wait(covers[name], lines.blank(shop, covers[name], face))
    faces = {name: times(shop.pad(plan.station(name), REAR), at(z=13.0)) for name in ("main", "idler", "breather")}
    lines.line(
        shop,
        "lines/return_hose",
        "rubber",
        [(faces["breather"], covers["breather_rear"], "straight"), (faces["idler"], covers["idler_rear"], "straight")],
        lines.return_level(faces["breather"], faces["idler"], outlet),
        kind="hose",
        after=["lines/pressure_pipe/pipe"],
    )
    lines.line(
        shop,
        "lines/pressure_pipe",
        "stainless steel",
        [(outlet, "oil_pump/end_cover", "straight"), (ports[0], "oil_filter/head", "elbow")],
        226.0,
    )
    oil, _, _ = lines.line(
        shop,
        "lines/oil_pipe",
        "stainless steel",
        [
            (times(faces["main"], at(*lines.OIL_PORT)), covers["main_rear"], "straight"),
            (ports[1], "oil_filter/head", "elbow"),
        ],
        lines.OIL_LEVEL,
    )
    lines.pipe_clip(shop, oil, lines.elbow_end(ports[1]))
    bracket = stand.bracket(shop, BOX_X, BOX_SCREWS)
    stand.door(shop, bracket)
    sockets = lines.junction_box(shop, bracket.beam, bracket.beam_face(BOX_X), len(sources))
    lines.harness(shop, sources, sockets)
    return asm
