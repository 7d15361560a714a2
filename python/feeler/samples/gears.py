"""Spur and bevel gears with meshing involute teeth, and the parts that turn with them."""

from __future__ import annotations

import numpy as np

from .mesh import Floats, Mesh
from .shapes import skin_loops
from .tessellation import Tolerance, circle, lifted

PRESSURE_ANGLE = np.deg2rad(20.0)
ADDENDUM = 1.0  # in modules
DEDENDUM = 1.25
BACKLASH = 0.04  # of the module, taken off each tooth's thickness: meshing flanks stay just apart


def _involute(angle: Floats | float) -> Floats:
    return np.asarray(np.tan(angle) - angle)


def half_thickness(radius: Floats, teeth: float, module: float) -> Floats:
    """Half the angle (radians, seen from the axis) that an involute tooth fills at a radius."""
    pitch = module * teeth / 2.0
    base = pitch * np.cos(PRESSURE_ANGLE)
    local = np.arccos(np.minimum(1.0, base / np.maximum(radius, base)))
    thin = BACKLASH * module / (2.0 * pitch)
    return np.asarray(np.pi / (2.0 * teeth) - thin + _involute(PRESSURE_ANGLE) - _involute(local))


def tooth_flank(teeth: float, module: float, tol: Tolerance) -> tuple[Floats, Floats]:
    """One flank from root to tip: heights above the pitch circle and half angles, each (k,)."""
    pitch = module * teeth / 2.0
    base = pitch * np.cos(PRESSURE_ANGLE)
    tip, root = pitch + ADDENDUM * module, pitch - DEDENDUM * module
    start = max(base, root)
    pieces = tol.segments(1.2 * module, 1.2, 1)
    radius = start + (tip - start) * np.linspace(0.0, 1.0, pieces + 1) ** 1.25
    angle = half_thickness(radius, teeth, module)
    if root < start - 0.02 * module and not tol.shows(0.2 * module):
        radius[0] = root
    elif root < start - 0.02 * module:
        radius = np.concatenate([[root], radius])
        angle = np.concatenate([angle[:1] + 0.1 * (np.pi / teeth - angle[:1]), angle])
    return radius - pitch, angle


def spur_outline(teeth: int, module: float, tol: Tolerance) -> Floats:
    """The outline (n, 2) of a spur gear, counter-clockwise; a tooth's middle lies on the x axis."""
    height, angle = tooth_flank(teeth, module, tol)
    radius = height + module * teeth / 2.0
    r = np.concatenate([radius, radius[::-1]])
    turn = np.concatenate([-angle, angle[::-1]])
    all_turns = np.arange(teeth)[:, None] * (2.0 * np.pi / teeth) + turn[None]
    return np.stack([r * np.cos(all_turns), r * np.sin(all_turns)], axis=2).reshape(-1, 2)


def spur_gear(teeth: int, module: float, width: float, bore: float, helix: float, tol: Tolerance) -> Mesh:
    """A spur gear about z, its middle plane at z = 0; `helix` (radians) twists the teeth, for helical gears.

    Two gears mesh at centre distance module * (teeth_a + teeth_b) / 2, one with a tooth and the other with a gap on the
    line of centres, their helix angles opposite.
    """
    outline = spur_outline(teeth, module, tol)
    pitch = module * teeth / 2.0
    twist = width * np.tan(helix) / pitch
    layers = tol.segments(pitch, twist, 1 if tol.coarse else 2) if helix else 1
    loops = []
    for share in np.linspace(-0.5, 0.5, layers + 1):
        cosine, sine = np.cos(share * twist), np.sin(share * twist)
        x, y = outline.T
        loops.append(lifted(np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1), width * float(share)))
    rim = pitch - 2.6 * module
    hub = bore + max(0.3 * bore, 1.5 * module)
    n = tol.circle(rim, 8)
    top = width / 2.0
    if rim - hub > 2.0 * module and tol.shows(0.15 * width):
        web = 0.3 * width
        rows = [(rim, top), (rim - 0.3 * module, web), (hub + 0.3 * module, web), (hub, top), (bore, top)]
    else:
        rows = [(bore, top)]
    loops += [circle(r, n, z) for r, z in rows] + [circle(r, n, -z) for r, z in reversed(rows)]
    return skin_loops(loops, closed=True)


def bevel_gear(teeth: int, mate_teeth: int, module: float, width: float, bore: float, tol: Tolerance) -> Mesh:
    """A straight bevel gear for shafts at right angles: about z, its apex at the origin, its back towards +z.

    Teeth after Tredgold: involute on the back cone, drawn to the apex. Mates share the apex; a tooth's middle lies in
    the half plane of +x, and the mate must have a gap on the common line.
    """
    cone = np.arctan2(teeth, mate_teeth)
    pitch = module * teeth / 2.0
    reach = pitch / np.sin(cone)
    height, flank = tooth_flank(teeth / np.cos(cone), module, tol)
    flank = flank / np.cos(cone)
    r = pitch + height * np.cos(cone)
    z = reach * np.cos(cone) - height * np.sin(cone)
    turn = np.concatenate([-flank, flank[::-1]])
    r, z = np.concatenate([r, r[::-1]]), np.concatenate([z, z[::-1]])
    turns = np.arange(teeth)[:, None] * (2.0 * np.pi / teeth) + turn[None]
    outer = np.stack([r * np.cos(turns), r * np.sin(turns), np.broadcast_to(z, turns.shape)], axis=2).reshape(-1, 3)
    inner = outer * ((reach - width) / reach)
    back = float(z.max())
    front = float(inner[:, 2].min())
    rim = float(r.min()) - 0.8 * module * np.cos(cone)
    n = tol.circle(rim, 8)
    hub = min(bore * 1.5, 0.9 * rim)
    inner_rim = float(np.hypot(inner[:, 0], inner[:, 1]).min()) - 0.4 * module
    loops = [
        circle(bore, n, front),
        circle(max(bore * 1.05, min(hub, inner_rim)), n, front),
        inner,
        outer,
        circle(rim, n, back + 0.6 * module),
        circle(hub, n, back + 0.9 * module),
        circle(bore, n, back + 0.9 * module),
    ]
    return skin_loops(loops, closed=True)


def mate_turn(turn: float, teeth: int, mate_teeth: int, direction: float) -> float:
    """The turn (radians) at which a mate meshes with a gear turned by `turn`, the mate lying in `direction` from it."""
    return direction + np.pi + np.pi / mate_teeth - (turn - direction) * teeth / mate_teeth
