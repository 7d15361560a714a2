"""Ten kinds of faults to plant in the gearbox, each with the expected result of a check."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...errors import OptionError
from ..mesh import Floats, Mesh, at, times
from . import lines, standard
from .assembly import Assembly, Planted, pull, tool_room
from .bodies import extruded, plate
from .design import AWAY, X, Y, frame
from .layout import FILTER_X
from .solid import placed

MM = 1e-3
CLASH_MM = 3.0
WITHIN_MM, OFF_MM = 10.0, 20.0
"""How far the lost ball is under the beam's face, and the lost washer above it."""
RULE_MM, NEARER_MM = 5.0, 0.5
"""The clearance that a rule requires of pipes, and by how much less two parts have."""
NARROW_MM = 2.0
HEAD_FLATS_MM = 8.0
SLEEVE_MM, SLEEVE_DIAMETERS_MM = 3.1, (9.9, 11.5)
"""How far a sleeve reaches down a bolt's head, and its diameters: around the corners, where a socket has room."""
INCH_MM = 25.4


def _leg(asm: Assembly, pipe: str) -> tuple[float, float]:
    """x and lower edge of the leg that a pipe has over the rear rail."""
    corners = next(corners for path, corners, _, _ in asm.lines if path == pipe)
    return float(corners[3][0]), float(corners[3][1]) - lines.PIPE


def _rail(asm: Assembly, name: str) -> tuple[float, float, float]:
    """z from, z to, and top of a rail, millimetres."""
    points = asm.mesh(asm.parts[f"bracket/{name}_rail"]).vertices
    return float(-points[:, 0].max()), float(-points[:, 0].min()), float(points[:, 1].max())


def _box(asm: Assembly, path: str) -> tuple[Floats, Floats]:
    """Lower and upper corner of a part in the world, millimetres, (3,) each."""
    part = asm.parts[path]
    points = placed(asm.mesh(part).vertices, part.pose)
    return points.min(axis=0), points.max(axis=0)


def _support(asm: Assembly, path: str, x: float, top: float) -> None:
    """A post on the rear rail."""
    low, high, foot = _rail(asm, "rear")
    box = ((x - 10.0, -high + 4.0), (x + 10.0, -high + 4.0), (x + 10.0, -low - 4.0), (x - 10.0, -low - 4.0))
    asm.add(path, "painted steel", extruded, box, 0.0, top - foot, pose=frame((0.0, foot, 0.0), Y, X))
    asm.flush(path, "bracket/rear_rail")
    asm.weld(path, "bracket/rear_rail")


def _pipe_clash(asm: Assembly) -> Planted:
    pipe, path = "lines/pressure_pipe/pipe", "bracket/pipe_support"
    x, low = _leg(asm, pipe)
    _support(asm, path, x, low + CLASH_MM)
    asm.block("pipe_clash", pipe)
    asm.wait("bracket/rear_rail", pipe)
    return Planted(
        "pipe_clash", [pipe, path], "clash", CLASH_MM * MM, "the pipe is 3 mm inside a support of the bracket"
    )


def _too_near(asm: Assembly) -> Planted:
    pipe, path = "lines/oil_pipe/pipe", "bracket/near_support"
    x, low = _leg(asm, pipe)
    gap = RULE_MM - NEARER_MM
    _support(asm, path, x, low - gap)
    asm.block("too_near", pipe)
    return Planted("too_near", [pipe, path], "too near", gap * MM, "4.5 mm from a pipe, where a rule asks for 5 mm")


def _blocked_bolt(asm: Assembly) -> Planted:
    bolt, plug, cover = "covers/idler_front/bolt_1", "covers/idler_front/blanking_plug", "covers/idler_front/cover"
    face, head = asm.parts[plug].pose, asm.parts[bolt].pose[:3, 3]
    way = head - face[:3, 3]
    way = way - face[:3, 2] * times(way, face[:3, 2])
    reach = float(np.sqrt(times(way, way))) + 7.0
    path = "covers/idler_front/guard"
    corners = ((-9.0, -9.0), (reach, -9.0), (reach, 9.0), (-9.0, 9.0))
    pose = frame(face[:3, 3], face[:3, 2], way)
    asm.add(path, "aluminium", plate, corners, 3.0, 3.0, ((0.0, 0.0, 6.6),), pose=pose)
    asm.lift(plug, 3.0)
    del asm.fits[(plug, cover) if plug < cover else (cover, plug)]
    asm.fit(plug, cover, "thread as cylinders", lines.CORE - lines.THREAD, lines.CORE)
    asm.fit(plug, path, "clearance", 0.6, 6.6)
    asm.flush(plug, path, cover)
    asm.block("blocked_bolt", bolt)
    asm.stop_tool(bolt)
    next(f for f in asm.fasteners if f.path == plug).holds.append(path)
    asm.step(path, pull(face[:3, 2], AWAY), after=[plug])
    asm.wait(cover, path)
    top = next(f.frame[:3, 3] for f in asm.fasteners if f.path == bolt)
    room = float(times(face[:3, 3] - top, face[:3, 2]))
    # Around the head, so that no spanner comes in from the side.
    sleeve, high = "covers/idler_front/guard_sleeve", room + SLEEVE_MM
    foot = frame(face[:3, 3] + way - high * face[:3, 2], face[:3, 2], way)
    asm.add(sleeve, "aluminium", standard.seal_washer, *SLEEVE_DIAMETERS_MM, high, pose=foot)
    asm.flush(sleeve, path)
    bore = SLEEVE_DIAMETERS_MM[0] / 2.0
    asm.fit(bolt, sleeve, "clearance", bore - HEAD_FLATS_MM / math.sqrt(3.0), bore)
    asm.weld(sleeve, path)
    says = f"a guard stands {room:.1f} mm over the bolt's head, and its sleeve around it"
    return Planted("blocked_bolt", [bolt, path, sleeve], "no tool access", room * MM, says, [plug])


def _no_way_out(asm: Assembly) -> Planted:
    bowl, path = "oil_filter/bowl", "bracket/filter_guard"
    front, rear = _rail(asm, "front"), _rail(asm, "rear")
    z = float(asm.parts[bowl].pose[2, 3])
    half = 33.0  # between the supports that other faults put on the rear rail
    corners = ((-half, -rear[1]), (half, -rear[1]), (half, -front[0]), (-half, -front[0]))
    pose = frame((FILTER_X, front[2], 0.0), Y, X)
    radius = 27.0 - NARROW_MM
    asm.add(path, "painted steel", plate, corners, 4.0, 2.0, ((0.0, -z, radius),), pose=pose)
    asm.flush("bracket/front_rail", path, "bracket/rear_rail")
    asm.block("no_way_out", bowl)
    asm.weld(path, "bracket/front_rail")
    says = "the hole under the filter's bowl has a radius 2 mm less than the bowl's"
    return Planted("no_way_out", [bowl, path], "no way out", NARROW_MM * MM, says)


def _missing_hole(asm: Assembly) -> Planted:
    cover, bolt = "covers/breather_front/cover", "covers/breather_front/bolt_1"
    part = asm.parts[cover]
    holes = next(k for k, value in enumerate(part.args) if isinstance(value, tuple) and len(value) == 5)
    part.args = (*part.args[:holes], part.args[holes][1:], *part.args[holes + 1 :])  # type: ignore[index]
    del asm.fits[(bolt, cover) if bolt < cover else (cover, bolt)]
    asm.block("missing_hole", bolt)
    deep = float(part.args[1]) / 2.0  # type: ignore[arg-type]
    says = "the cover has no hole where its first bolt is: half the flange's thickness is the depth"
    return Planted("missing_hole", [bolt, cover], "no hole", deep * MM, says)


def _duplicate(asm: Assembly) -> Planted:
    path = "housing/split_bolts/bolt_5"
    copy = f"{path}_copy"
    asm.parts[copy] = replace(asm.parts[path], path=copy)
    for (a, b), fit in list(asm.fits.items()):
        if path in (a, b):
            pair = (copy, b) if a == path else (a, copy)
            asm.fits[pair] = replace(fit, a=pair[0], b=pair[1])
    for step in asm.steps:
        if path in step.parts:  # each would hold the parts that the other one holds: they come out together
            step.parts.append(copy)
    for _, _, held in asm.keepers:
        held += [copy] * (path in held)
    asm.fasteners += [replace(f, path=copy, holds=list(f.holds)) for f in asm.fasteners if f.path == path]
    return Planted("duplicate", [path, copy], "duplicate", 0.0, "the same bolt twice, 0 mm apart")


def _inside(asm: Assembly) -> Planted:
    path = "bracket/lost_ball"
    low, high = _box(asm, "bracket/beam")
    x, y, _ = ((low + high) / 2.0).tolist()
    asm.add(path, "hardened steel", standard.ball, 8.0, pose=at(x, y, float(low[2]) + WITHIN_MM + 4.0))
    asm.stays[path] = "it is inside the solid beam"
    says = "a ball inside the solid beam, 10 mm under its face"
    return Planted("inside", [path, "bracket/beam"], "inside", WITHIN_MM * MM, says)


def _floating(asm: Assembly) -> Planted:
    path = "bracket/lost_washer"
    low, high = _box(asm, "bracket/beam")
    place = (low + high) / 2.0
    place[1] = high[1] + OFF_MM
    asm.add(path, "zinc-plated steel", standard.washer, 8, pose=frame(place, Y), spin=True)
    asm.step(path, pull(Y, AWAY))
    says = "a washer that nothing holds; the next part is the beam, 20 mm under it"
    return Planted("floating", [path], "floating", OFF_MM * MM, says)


def _mirrored(asm: Assembly) -> Planted:
    path, case = "housing/drain_plug", "housing/rear_case"
    asm.parts[path].pose = times(asm.parts[path].pose, np.diag([1.0, -1.0, 1.0, 1.0]))
    del asm.fits[(path, case) if path < case else (case, path)]
    asm.block("mirrored", path)
    return Planted("mirrored", [path, case], "mirrored", -1.0, "the drain plug is mirrored: a left-handed thread")


def block_ring(asm: Assembly, path: str, meshes: dict[str, Mesh]) -> None:
    """Says of which steps and tools a washer of a wrong unit, about an axis along z, is in the way.

    `meshes`: in the world, metres.
    """
    ring = meshes[path].vertices / MM
    low, high = float(ring[:, 2].min()), float(ring[:, 2].max())
    flat = ring[ring[:, 2] < (low + high) / 2.0, :2]
    centre = flat.mean(axis=0)
    radius = np.hypot(*(flat - centre).T)
    edges = [_hull(flat[radius > radius.mean()] - centre), _hull(flat[radius < radius.mean()] - centre)]
    asm.block("wrong_unit", path)
    for step in asm.steps:
        lift = sum(leg.distance * leg.axis[2] for leg in step.legs)
        for moving in step.parts if path not in step.parts else ():
            mesh = meshes[moving]
            corners = mesh.vertices[mesh.faces] / MM
            least, most = corners[:, :, 2].min(axis=1) + min(lift, 0.0), corners[:, :, 2].max(axis=1) + max(lift, 0.0)
            corners = corners[(least <= high) & (most >= low), :, :2]
            for leg in step.legs:  # parts already rotated move on in their present orientation
                angle = leg.angle * leg.axis[2]
                spun = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
                corners = np.concatenate([corners, times(corners - leg.point[:2], spun) + leg.point[:2]])
            if len(corners) and _meets_ring(corners - centre, *edges):
                step.blocked_by.append("wrong_unit")
                break
    turn = np.arange(32) * (np.pi / 16.0)
    round_tool = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for fastener in asm.fasteners:
        top, up = float(fastener.frame[2, 3]), float(fastener.frame[2, 2])
        if fastener.tool == "open-end wrench":
            continue  # its swing is computed
        room, reach = tool_room(fastener.tool, fastener.size)
        ends = sorted((top, top + up * reach))
        tool = fastener.frame[:2, 3] + room * round_tool - centre
        if abs(up) > 0.5 and ends[0] < high and ends[1] > low and _meets_ring(tool[None], *edges):
            fastener.is_stopped = True


def _hull(points: Floats) -> Floats:
    """Corners of a convex polygon about the origin, counter-clockwise."""
    return points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]


def _meets_ring(shapes: Floats, outer: Floats, inner: Floats) -> bool:
    """Whether one of convex shapes (n, k, 2) intersects the region between two convex polygons, one inside the other.

    It does if it intersects the outer one and is not inside the inner one.
    """

    def beyond(points: Floats, polygon: Floats) -> npt.NDArray[np.bool_]:
        """Of each side of polygons (..., k, 2), which points (..., m, 2) are beyond it: (..., k, m)."""
        side = np.roll(polygon, -1, axis=-2) - polygon
        normal = np.stack([side[..., 1], -side[..., 0]], axis=-1)
        return np.asarray(times(normal, np.swapaxes(points, -1, -2)) > (normal * polygon).sum(axis=-1)[..., None])

    ahead = np.roll(shapes, -1, axis=1)
    area = (shapes[:, :, 0] * ahead[:, :, 1] - shapes[:, :, 1] * ahead[:, :, 0]).sum(axis=1)
    shapes = np.where(area[:, None, None] < 0.0, shapes[:, ::-1], shapes)
    apart = [np.any(np.all(beyond(a, b), axis=2), axis=1) for a, b in ((shapes, outer), (outer, shapes))]
    inside = ~beyond(shapes, inner).any(axis=(1, 2))
    return not bool((apart[0] | apart[1] | inside).all())


def _wrong_unit(asm: Assembly) -> Planted:
    path = "lines/oil_pipe/clip_washer"
    asm.parts[path].scale = INCH_MM
    for pair in [pair for pair in asm.fits if path in pair]:
        del asm.fits[pair]
    return Planted("wrong_unit", [path], "unit", INCH_MM, "a washer whose millimetres were read as inches")


FAULTS: dict[str, Callable[[Assembly], Planted]] = {
    "pipe_clash": _pipe_clash,
    "too_near": _too_near,
    "blocked_bolt": _blocked_bolt,
    "no_way_out": _no_way_out,
    "missing_hole": _missing_hole,
    "duplicate": _duplicate,
    "inside": _inside,
    "floating": _floating,
    "mirrored": _mirrored,
    "wrong_unit": _wrong_unit,
}
"""The function that plants each fault, by name."""


def plant(asm: Assembly, names: Sequence[str]) -> list[Planted]:
    """Plants the named faults; returns their descriptions."""
    for name in names:
        if name not in FAULTS:
            raise OptionError(f"no fault is called {name!r}; choose from {', '.join(FAULTS)}")
    return [FAULTS[name](asm) for name in dict.fromkeys(names)]
