"""Mock-ups and tools for haptics: thin objects, and contacts of known force at any tessellation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .meshes import Floats, Mesh, ball, box, joined, regular, ridge, ring, rod, sheet, shifted_mesh, stack, tube
from .poses import pose

WIRE_RADIUS_M = 0.0005
WIRE_PITCH_M = 0.010  # of a grid of wires: less than any tool is thick
THIN_HALF_M = 0.25  # half the side of thin scenes

TOOL_SIZE_M = 0.03


@dataclass(frozen=True)
class Contact:
    """A tool that touches a mock-up, just, at `touching`; pressing it along `push` (a unit vector) builds up force."""

    mockup: Mesh
    tool: Mesh
    touching: Floats
    push: Floats
    triangles: int
    """Of both together."""


def thin_sheet(half: float = THIN_HALF_M, cells: int = 1) -> Mesh:
    """A sheet without thickness in the plane z = 0."""
    return sheet(cells, cells, lambda s, t: ((2 * s - 1) * half, (2 * t - 1) * half, 0.0))


def half_sheet(half: float = THIN_HALF_M, cells: int = 1) -> Mesh:
    """A sheet without thickness in the plane z = 0 that ends with an edge at x = 0, and lies where x is negative."""
    return sheet(cells, cells, lambda s, t: ((s - 1) * 2 * half, (2 * t - 1) * half, 0.0))


def wires(half: float = THIN_HALF_M, pitch: float = WIRE_PITCH_M, radius: float = WIRE_RADIUS_M) -> Mesh:
    """Parallel wires along y in the plane z = 0, closer than a tool is thick: prisms of three sides."""
    count = math.floor(half / pitch)
    made = []
    for k in range(-count, count + 1):
        made.append(shifted_mesh(wire(half, radius), (k * pitch, 0.0, 0.0)))
    return joined(*made)


def wire(half: float = THIN_HALF_M, radius: float = WIRE_RADIUS_M) -> Mesh:
    """One wire along y: a prism of three sides, its triangles as long as itself."""
    section = regular(radius, 3, start=math.pi / 2)
    loops = [np.stack([section[:, 0], np.full(3, y), section[:, 1]], axis=1) for y in (-half, half)]
    return stack(np.array(loops))


def strips(half: float = THIN_HALF_M, pitch: float = WIRE_PITCH_M, width: float = 2 * WIRE_RADIUS_M) -> Mesh:
    """Like `wires`, with strips without thickness: two triangles each, hundreds of times as long as wide."""
    count = math.floor(half / pitch)
    made = []
    for k in range(-count, count + 1):
        x = k * pitch
        made.append(sheet(1, 1, lambda s, t, x=x: (x + (s - 0.5) * width, (2 * t - 1) * half, 0.0)))  # type: ignore[misc]
    return joined(*made)


def thin_tools(size: float = TOOL_SIZE_M) -> dict[str, Mesh]:
    """Tools to throw at thin things, each about its middle and at least `WIRE_PITCH_M` thick."""
    angle = math.acos(1.0 / 3.0)
    corners = np.array(
        [
            (0.0, 0.0, 1.0),
            *(
                (math.sin(angle) * math.cos(a), math.sin(angle) * math.sin(a), -1.0 / 3.0)
                for a in (0.0, 2 * math.pi / 3, 4 * math.pi / 3)
            ),
        ]
    )
    tetrahedron = corners * size, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])
    return {
        "box": box((size, 0.8 * size, 0.6 * size), (0.0, 0.0, 0.0), 1),
        "tetrahedron": tetrahedron,
        "ball": ball(0.5 * size, 8),
        "rod": rod(0.25 * size, 2.0 * size, 12, 1),
    }


def thread_ring(radius: float = 0.02, thickness: float = 0.003) -> Mesh:
    """A ring about z, to be threaded on a wire."""
    return ring(radius, thickness, 24, 8)


def box_on_plate(cells: int) -> Contact:
    """A box that stands on a plate: 24 triangles where `cells` is 1."""
    plate = box((0.2, 0.2, 0.02), (0.0, 0.0, -0.01), cells)
    return _resting(plate, box((0.03, 0.02, 0.04), (0.0, 0.0, 0.02), cells), 0.0)


def ball_on_plate(cells: int) -> Contact:
    """A ball on a plate; every tessellation has a corner at its lowest point."""
    plate = box((0.2, 0.2, 0.02), (0.0, 0.0, -0.01), cells)
    return _resting(plate, ball(0.02, max(4, 2 * cells)), 0.02)


def cylinder_on_plate(cells: int) -> Contact:
    """A lying cylinder on a plate; every tessellation has an edge at its lowest line."""
    plate = box((0.2, 0.2, 0.02), (0.0, 0.0, -0.01), cells)
    return _resting(plate, rod(0.01, 0.06, max(8, 4 * cells), cells), 0.01)


def _resting(mockup: Mesh, tool: Mesh, height: float) -> Contact:
    # a little aside, so that corners and edges of the two do not lie on each other
    return Contact(
        mockup, tool, pose((0.0031, 0.0017, height)), np.array([0.0, 0.0, -1.0]), len(mockup[1]) + len(tool[1])
    )


FLANK_RAD = math.radians(20.0)


def tooth_in_slot(cells: int) -> Contact:
    """A gear tooth with straight flanks of 20 degrees that sits in its slot: both flanks touch, the tip does not."""
    slope = math.tan(FLANK_RAD)
    foot, rim = 0.002, 0.002 + 0.01 * slope
    slot = [(-0.02, 0.0), (-rim, 0.0), (-foot, -0.01), (foot, -0.01), (rim, 0.0), (0.02, 0.0)]
    tip, top = foot + 0.001 * slope, rim + 0.001 * slope
    tooth = [(-top, 0.001), (-tip, -0.009), (tip, -0.009), (top, 0.001)]
    n = max(1, cells // 2)
    mockup, tool = ridge(slot, -0.02, 0.03, n, 2 * n), ridge(tooth, 0.02, 0.01, n, 2 * n)
    return Contact(mockup, tool, pose(), np.array([0.0, 0.0, -1.0]), len(mockup[1]) + len(tool[1]))


CONTACTS: dict[str, Callable[[int], Contact]] = {
    "box": box_on_plate,
    "ball": ball_on_plate,
    "cylinder": cylinder_on_plate,
    "tooth": tooth_in_slot,
}
CELLS = (1, 4, 16, 45, 64)  # the finest have about 100,000 triangles
QUICK_CELLS = (1, 4, 16)


def contact_with(name: str, triangles: int) -> Contact:
    """A contact of the table with about that many triangles, never many more."""
    make, cells = CONTACTS[name], 1
    while make(cells + max(1, cells // 4)).triangles <= triangles:
        cells += max(1, cells // 4)
    return make(cells)


def long_cylinder(sides: int, radius: float = 0.05, length: float = 0.3) -> Mesh:
    """A cylinder along x to slide over, its highest line an edge of the tessellation."""
    mesh = rod(radius, length, sides, 1)
    # the rod has an edge at its lowest line: turned upside down about x
    return mesh[0] * np.array([1.0, -1.0, -1.0]), mesh[1]


def flat_face(triangles: int = 10_000, half: float = 0.15, seed: int = 0) -> Mesh:
    """A plate whose upper face, in the plane z = 0, has about that many triangles of uneven shapes."""
    cells = max(1, round(math.sqrt(triangles / 2.0)))
    rng = np.random.default_rng(seed)
    top = sheet(cells, cells, lambda s, t: ((2 * s - 1) * half, (2 * t - 1) * half, 0.0))
    inner = (np.abs(top[0][:, :2]) < half * (1.0 - 0.5 / cells)).all(axis=1)
    top[0][inner, :2] += rng.uniform(-0.3, 0.3, (int(inner.sum()), 2)) * (2.0 * half / cells)
    return top


def stair_wave(length: float = 0.1, height: float = 0.004, cells: int = 64) -> Mesh:
    """A smooth wave along x as a sheet, on which a voxel grid shows its stairs."""

    def at(s: Floats, t: Floats) -> tuple[Floats, Floats, Floats]:
        x = (2 * s - 1) * length
        return x, (2 * t - 1) * 0.05, height * np.sin(2 * np.pi * x / length)

    return sheet(cells, 4, at)


def rounded_rod(length: float = 0.06, radius: float = 0.004, sides: int = 16) -> Mesh:
    """A straight tube along z, to poke with."""
    return tube(np.array([(0.0, 0.0, 0.0), (0.0, 0.0, length)]), radius, sides)
