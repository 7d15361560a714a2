"""Does the force depend on how the surfaces are cut into triangles, and does it jump while the tool slides?"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import feeler

from .. import scenes
from ..faces import TICK_S, Face
from ..meshes import Floats, ball, box, mockup_of, tool_of, turned_mesh
from ..poses import pose

DEPTH_M = 0.001
ABOVE_M = 0.001
PRESS_TICKS = 200
SETTLE_TICKS = 200
LOOKED_AT_TICKS = 50
SLIDE_M_PER_S = 0.1
START_TICKS = 200  # of a slide that are not looked at: a damper feels the start
BALLS = ((32, 0.001), (32, 0.003), (32, 0.006), (16, 0.001), (64, 0.001))  # bands, how deep they are pressed (metres)
FLAT_RAD = 1e-3  # off the normal of a flat face, at most
FRAMES = {"flush": pose(), "turned": pose((0.02, -0.01, 0.03), (0.4, -0.7, 1.1))}


def pressed(make: Callable[..., Face], contact: scenes.Contact, frame: Floats, seed: int = 0) -> Floats:
    """Force and torque (n, 6), in the contact's frame, of the last ticks of a tool pressed in by `DEPTH_M` and held."""
    scene = feeler.Scene(mockup_of(turned_mesh(contact.mockup, frame)), threads=1)
    face = make(scene, tool_of(contact.tool), seed=seed)
    depths = np.minimum(np.linspace(-ABOVE_M, DEPTH_M, PRESS_TICKS), DEPTH_M)
    found: list[Floats] = []
    for depth in [depths[0], *depths, *([DEPTH_M] * SETTLE_TICKS)]:
        at = contact.touching.copy()
        at[:3, 3] += depth * contact.push
        if not found:
            face.start(frame @ at)
        step = face.step(frame @ at)
        found.append(np.concatenate([frame[:3, :3].T @ step.force, frame[:3, :3].T @ step.torque]))
    return np.array(found[-LOOKED_AT_TICKS:])


def forces(make: Callable[..., Face], cells: Sequence[int], seed: int = 0) -> dict[str, Any]:
    """Each contact, at each tessellation and in two frames; and by how much the forces of one contact differ."""
    rows: list[dict[str, Any]] = []
    for name, build in scenes.CONTACTS.items():
        for count in cells:
            contact = build(count)
            for where, frame in FRAMES.items():
                wrench = pressed(make, contact, frame, seed)
                force = wrench[:, :3].mean(axis=0)
                rows.append(
                    {
                        "contact": name,
                        "triangles": contact.triangles,
                        "frame": where,
                        "force_n": force.tolist(),
                        "magnitude_n": float(np.linalg.norm(force)),
                        "aside": float(
                            np.linalg.norm(np.cross(force, contact.push)) / max(np.linalg.norm(force), 1e-9)
                        ),
                        "torque_nm": wrench[:, 3:].mean(axis=0).tolist(),
                        "unrest_n": float(np.linalg.norm(np.ptp(wrench[:, :3], axis=0))),
                    }
                )
    spread = {}
    for name in scenes.CONTACTS:
        sizes = [row["magnitude_n"] for row in rows if row["contact"] == name]
        spread[name] = (max(sizes) - min(sizes)) / max(np.mean(sizes), 1e-9)
    return {"depth_m": DEPTH_M, "rows": rows, "spread": {k: float(v) for k, v in spread.items()}}


def sliding(
    make: Callable[..., Face], sides: Sequence[int], seed: int = 0, *, unshaded: Callable[..., Face] | None = None
) -> dict[str, Any]:
    """A ball over cylinders of several tessellations, and a box along a flat face of 10,000 triangles.

    `unshaded`: the same face without force shading, for the jump that it has then.
    """
    rows = []
    for count in sides:
        for bands, depth in BALLS:
            row = _over_cylinder(make, count, bands, depth, seed)
            bare = None if unshaded is None else _over_cylinder(unshaded, count, bands, depth, seed)
            rows.append({**row, "unshaded_jump": bare and bare["jump"]})
    rows.append({**_along_face(make, seed), "unshaded_jump": None})
    return {"speed_m_per_s": SLIDE_M_PER_S, "depth_m": DEPTH_M, "rows": rows}


def _over_cylinder(make: Callable[..., Face], sides: int, bands: int, depth: float, seed: int) -> dict[str, Any]:
    radius, tool_radius = 0.05, 0.01
    scene = feeler.Scene(mockup_of(scenes.long_cylinder(sides, radius)), threads=1)
    face = make(scene, tool_of(ball(tool_radius, bands)), seed=seed)
    reach = radius + tool_radius - depth
    half, a_tick = math.radians(30.0), SLIDE_M_PER_S * TICK_S / reach
    ticks = round(2 * half / a_tick)
    angles = -half + a_tick * np.arange(-START_TICKS, ticks)
    # in along the normal first, then along the arc that is `depth` deep
    radii = [
        *np.linspace(reach + depth + ABOVE_M, reach, PRESS_TICKS),
        *([reach] * (SETTLE_TICKS + START_TICKS + ticks)),
    ]
    angles = np.concatenate([np.full(PRESS_TICKS + SETTLE_TICKS, angles[0]), angles])
    normals = np.stack([np.zeros(len(angles)), np.sin(angles), np.cos(angles)], axis=1)
    found = _felt(face, [pose(r * n + np.array([0.0013, 0.0, 0.0])) for r, n in zip(radii, normals, strict=True)])
    facet = 2.0 * math.pi / sides
    row = _jumps(found[-ticks:], normals[-ticks:])
    # a facet is askew to the true normal by half its angle, on the cylinder and on the ball
    allowed = 0.5 * (facet + math.pi / bands)
    what = "cylinder" if (bands, depth) == BALLS[0] else f"cylinder, {bands} bands, {1e3 * depth:g} mm deep"
    return {"surface": what, "triangles": scene.mockup.triangle_count, "allowed_rad": allowed, **row}


def _along_face(make: Callable[..., Face], seed: int) -> dict[str, Any]:
    plate = scenes.flat_face()
    scene = feeler.Scene(mockup_of(plate), threads=1)
    face = make(scene, tool_of(box((0.03, 0.02, 0.04), (0.0, 0.0, 0.02), 4)), seed=seed)
    ticks = 1000
    way = np.array([math.cos(0.37), math.sin(0.37), 0.0])
    heights = [*np.linspace(ABOVE_M, -DEPTH_M, PRESS_TICKS), *([-DEPTH_M] * (SETTLE_TICKS + START_TICKS + ticks))]
    along = (
        np.concatenate([np.zeros(PRESS_TICKS + SETTLE_TICKS), np.arange(START_TICKS + ticks) * SLIDE_M_PER_S * TICK_S])
        - 0.06
    )
    found = _felt(
        face, [pose(s * way + np.array([0.0, 0.0, z]), (0.0, 0.0, 0.2)) for s, z in zip(along, heights, strict=True)]
    )
    row = _jumps(found[-ticks:], np.tile([0.0, 0.0, 1.0], (ticks, 1)))
    return {"surface": "flat face", "triangles": len(plate[1]), "allowed_rad": FLAT_RAD, **row}


def _felt(face: Face, path: Sequence[Floats]) -> Floats:
    face.start(path[0])
    return np.array([np.array(face.step(at).force) for at in path])


def _jumps(force: Floats, normals: Floats) -> dict[str, Any]:
    """How a force changes from tick to tick, as shares of its mean, and how far it is from the normals."""
    size = np.sqrt((force**2).sum(axis=1))
    mean = max(float(size.mean()), 1e-9)
    along = (force * normals).sum(axis=1)
    across = np.sqrt(np.maximum(size**2 - along**2, 0.0))
    return {
        "force_n": mean,
        "least_n": float(size.min()),
        "largest_n": float(size.max()),
        "size_jump": float(np.abs(np.diff(size)).max()) / mean,
        "jump": float(np.sqrt((np.diff(force, axis=0) ** 2).sum(axis=1)).max()) / mean,
        "direction_rad": float(np.arctan2(across, along).max()),
        "trace_n": [round(float(f), 5) for f in size[:: max(1, len(size) // 300)]],
    }
