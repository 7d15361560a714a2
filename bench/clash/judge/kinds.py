"""The kinds of pairs: random bodies with their expected facts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from itertools import combinations, islice
from typing import Any

import numpy as np

from . import branching, flat, whole_numbers
from .asking import Group
from .facts import Facts
from .shapes import (
    PATTERNS,
    Convex,
    Floats,
    Mesh,
    Polycube,
    ball,
    box,
    cut_finer,
    even_planes,
    frustum,
    joined,
    mirrored,
    pattern,
    random_turn,
    revolved,
    sheet,
    shuffled,
    torus,
    tube,
    whole_turn,
)

Random = np.random.Generator
Groups = Iterator[Group]

UNIT_M = 2.0**-30
"""The unit of integer coordinates: about a nanometre."""
CELL = 2**24
"""The size of a cell of a polycube: 15.6 mm."""
FAR = 2**46
"""The largest distance from the origin: 65 km."""
STEPS = (1, 1_074, 107_374, 1_073_742)
"""Small offsets of faces that are nearly flush: a nanometre, a micrometre, 0.1 and 1 mm."""
MOST_TRIANGLES = 60_000
CLEARANCE_M = 0.002
CLASH, CONTACT, CONTAINED = frozenset({"clash"}), frozenset({"contact"}), frozenset({"contained"})


def _whole_dress(rng: Random) -> tuple[Floats, Floats, float, bool]:
    """Rotation, place, scale, and whether they round: integer coordinates stay exact unless the angle is arbitrary."""
    place = rng.integers(-FAR, FAR, 3).astype(float) if rng.random() < 0.4 else np.zeros(3)
    kind = rng.integers(3)
    if kind == 0:
        return np.eye(3), place, 1.0, False
    if kind == 1:
        turn, scale = whole_turn(rng)
        return turn, place, float(scale), False
    return random_turn(rng), place, 1.0, True


def _dress(rng: Random) -> tuple[Floats, Floats]:
    turn = random_turn(rng) if rng.random() < 0.8 else np.eye(3)
    far = FAR * UNIT_M
    return turn, rng.uniform(-far, far, 3) if rng.random() < 0.4 else np.zeros(3)


def _worn(rng: Random, mesh: Mesh, most_levels: int = 3) -> Mesh:
    """The same surface: subdivided, reordered, and sometimes with flipped windings."""
    most = max(0, min(most_levels, int(np.log2(MOST_TRIANGLES / len(mesh[1])) / 2)))
    levels = int(min(most, rng.geometric(0.6) - 1))
    worn = shuffled(rng, cut_finer(mesh, levels))
    return mirrored(worn) if rng.random() < 0.15 else worn


def _misses(rng: Random) -> Floats:
    """A random small offset of a body from the lattice, in units."""
    if rng.random() < 0.4:
        return np.zeros(3)
    return float(rng.choice(STEPS)) * rng.integers(-1, 2, 3).astype(float)


def boxes(rng: Random) -> Groups:
    """Boxes with parallel edges on a lattice, flush or nearly flush. Closed form."""
    while True:
        bodies = []
        for _ in range(2):
            low = rng.integers(0, 4, 3) * float(4 * CELL) + _misses(rng)
            bodies.append((low, low + rng.integers(1, 5, 3) * float(4 * CELL)))
        chance = rng.random()
        if chance < 0.05:
            bodies[1] = bodies[0]
        elif chance < 0.2:
            bodies[1] = bodies[1][0], np.maximum(bodies[1][1], bodies[0][1] + np.abs(_misses(rng)))
        turn, place, scale, is_rounded = _whole_dress(rng)
        facts = whole_numbers.boxes(*bodies[0], *bodies[1]).scaled(UNIT_M * scale)
        meshes = []
        for low, high in bodies:
            planes = tuple(np.array([low[axis], high[axis]]) for axis in range(3))
            body = Polycube(np.zeros((1, 3), np.int64), (planes[0], planes[1], planes[2]))
            made = body.mesh(rng, int(2 ** min(4, rng.geometric(0.6) - 1)))
            meshes.append(mirrored(made) if rng.random() < 0.15 else made)
        yield Group(
            "boxes, parallel", tuple(meshes), {(0, 1): facts}, turn, place, UNIT_M, is_rounded, None, CLEARANCE_M
        )


def _convex(rng: Random, size: float) -> Convex:
    if rng.random() < 0.4:
        low, high = -rng.uniform(0.2, 1, 3) * size, rng.uniform(0.2, 1, 3) * size
        return box(low, high)
    upper = float(rng.choice([0, 0.5, 1]))
    return frustum(int(rng.integers(3, 8)), size * rng.uniform(0.3, 1), size * upper * 0.7, size * rng.uniform(0.3, 2))


def _of_convex(a: Convex, b: Convex) -> Facts | None:
    """The facts of two convex bodies; None if they depend on rounding."""
    depth = flat.deepest_of_convex(a, b)
    if abs(depth) < 1e-7:
        return None
    if depth < 0:
        return Facts(0.0, 0.0, None)
    out = []
    for one, other in ((a, b), (b, a)):
        normals, offsets = other.planes()
        out.append(float((one.corners() @ normals.T - offsets).max()))
    if min(abs(each) for each in out) < 1e-7:
        return None
    return Facts(depth * (1 - 1e-9), depth * (1 + 1e-9), is_inside=min(out) < 0, is_touching=min(out) > 0)


def convex(rng: Random) -> Groups:
    """Boxes, prisms, pyramids and frusta, each with its own rotation. Linear programs."""
    while True:
        a = _convex(rng, 0.5).placed(random_turn(rng), np.zeros(3))
        b = _convex(rng, rng.uniform(0.05, 0.5)).placed(random_turn(rng), rng.normal(size=3) * rng.uniform(0.05, 0.4))
        facts = _of_convex(a, b)
        if facts is not None:
            yield Group(
                "convex, each turned", (_worn(rng, a.mesh()), _worn(rng, b.mesh())), {(0, 1): facts}, *_dress(rng)
            )


def fine(rng: Random) -> Groups:
    """Boxes and prisms, each triangle subdivided into 256 to 4,096. Linear programs."""
    while True:
        a = _convex(rng, 0.5).placed(random_turn(rng), np.zeros(3))
        b = _convex(rng, rng.uniform(0.2, 0.5)).placed(random_turn(rng), rng.normal(size=3) * 0.2)
        facts = _of_convex(a, b)
        if facts is not None and facts.gap == 0:
            levels = [int(rng.integers(4, 7)), int(rng.choice([0, 4, 6]))]
            meshes = [cut_finer(body.mesh(), level) for body, level in zip((a, b), levels, strict=True)]
            yield Group("cut 4,096 times finer", tuple(meshes), {(0, 1): facts}, *_dress(rng))


LUMP = 9


def _lump(rng: Random, kind: str, contact: float | None) -> Group:
    bodies: list[Polycube] = []
    meshes: list[Mesh] = []
    for _ in range(LUMP):
        if bodies and rng.random() < 0.1:
            body = bodies[int(rng.integers(len(bodies)))]
        else:
            is_block = not bodies and rng.random() < 0.5  # so that others may be inside it
            cells = np.argwhere(np.ones((3, 3, 3), bool)) if is_block else pattern(rng)
            size = float(CELL * rng.choice([1, 1, 1, 2])) * (1 + is_block)
            body = Polycube(cells, even_planes(cells, size, rng.integers(0, 4, 3) * float(CELL) + _misses(rng)))
        bodies.append(body)
        mesh = body.mesh(rng, int(rng.choice([1, 1, 2, 4])))
        meshes.append(mirrored(mesh) if rng.random() < 0.15 else mesh)
    turn, place, scale, is_rounded = _whole_dress(rng)
    facts = {
        (i, j): whole_numbers.polycubes(bodies[i], bodies[j]).scaled(UNIT_M * scale)
        for i, j in combinations(range(LUMP), 2)
    }
    limit = None if contact is None else contact * scale
    return Group(kind, tuple(meshes), facts, turn, place, UNIT_M, is_rounded, limit, CLEARANCE_M)


def polycubes(rng: Random) -> Groups:
    """Heaps of polycubes, some hollow, some duplicated. Integer arithmetic."""
    while True:
        yield _lump(rng, "polycubes", None)


def polycubes_in_contact(rng: Random) -> Groups:
    """The same with a `contact` that allows some of the overlaps."""
    while True:
        yield _lump(rng, "polycubes, `contact` given", float(rng.choice([2.5e-9, 1.5e-6, 1.5e-4, 1.2e-3])))


def balls(rng: Random) -> Groups:
    """Balls with 8 to 64 sides. Bounds from the closed form of true balls, and the sag of the facets."""
    while True:
        sizes = [rng.uniform(0.1, 0.4), rng.uniform(0.03, 0.4)]
        sides = [int(rng.choice([8, 12, 16, 24, 32, 48, 64])) for _ in sizes]
        meshes = [ball(radius, n, n // 2) for radius, n in zip(sizes, sides, strict=True)]
        sags = [
            radius - float(branching.distances(np.zeros((len(mesh[1]), 1, 3)), mesh[0][mesh[1]]).min())
            for radius, mesh in zip(sizes, meshes, strict=True)
        ]
        apart = float(rng.uniform(0, 1.1) * sum(sizes))
        depth = max(sizes[1] - abs(apart - sizes[0]), sizes[0] - abs(apart - sizes[1]))
        sag = sum(sags)
        inside = [apart + sizes[i] - (sizes[1 - i] - sags[1 - i]) for i in range(2)]
        crosses = [apart + sizes[i] - sags[i] - sizes[1 - i] for i in range(2)]
        direction = rng.normal(size=3)
        second = meshes[1][0] @ random_turn(rng).T + apart * direction / np.linalg.norm(direction)
        if depth < -1e-9:
            facts = Facts(0.0, 0.0, None)
        elif min(inside) < 0 or (min(crosses) > 0 and depth > 2 * sag):
            is_inside = min(inside) < 0
            facts = Facts(max(depth - sag, 0.0), depth + sag, is_inside=is_inside, is_touching=not is_inside)
        else:
            continue
        parts = (_worn(rng, meshes[0], 1), _worn(rng, (second, meshes[1][1]), 1))
        yield Group("balls of facets", parts, {(0, 1): facts}, *_dress(rng))


# Any solids.


def solid(rng: Random) -> Mesh:
    """A random body, about 0.3 m large: torus, tube, ball, hollow ball or polycube, randomly rotated."""
    kind = int(rng.integers(7))
    if kind == 0:
        mesh = torus(0.2, rng.uniform(0.04, 0.12), int(rng.integers(8, 25)), int(rng.integers(5, 11)))
    elif kind == 1:
        inner = rng.uniform(0.05, 0.15)
        mesh = tube(inner, inner + rng.uniform(0.01, 0.1), -0.2, rng.uniform(0, 0.2), int(rng.integers(6, 33)))
    elif kind == 2:
        mesh = ball(0.2, 16, 8)
    elif kind == 3:
        mesh = joined(ball(0.25, 14, 7), mirrored(ball(rng.uniform(0.08, 0.2), 10, 5)))
    else:
        name = str(rng.choice(["L", "U", "tee", "cross", "ring", "stairs", "hollow", "cup"]))
        cells = pattern(rng, name)
        number = cells.max(axis=0) + 2
        x, y, z = (np.cumsum(rng.uniform(0.03, 0.18, each)) - 0.2 for each in number)
        mesh = Polycube(cells, (x, y, z)).mesh(rng)
    return mesh[0] @ random_turn(rng).T, mesh[1]


def _volume_of(mesh: Mesh) -> Any:
    manifold3d = import_module("manifold3d")  # an extra, `feeler[volume]`: other experiments run without it
    vertices, faces = np.ascontiguousarray(mesh[0]), np.ascontiguousarray(mesh[1].astype(np.uint64))
    return manifold3d.Manifold(manifold3d.Mesh64(vertices, faces))


def of_solids(a: Mesh, b: Mesh) -> Facts | None:
    """The facts of any two solids; None if they depend on rounding. Raises if depth and volume disagree."""
    one, other = _volume_of(a), _volume_of(b)
    shared = (one ^ other).volume()
    volumes = one.volume(), other.volume()
    least = min(volumes)
    if shared < 1e-6 * least:
        if shared > 0 or one.min_gap(other, 1e-4) < 1e-4:
            return None
        low, high = branching.depth(a, b)
        assert low == 0.0, (low, high)
        return Facts(0.0, 0.0, None)
    low, high = branching.depth(a, b)
    assert low > 0.0, (low, high, shared)
    beyond = least - shared
    if 1e-12 * least < beyond < 1e-6 * least or high > low * 1.001:
        return None
    is_inside = beyond <= 1e-12 * least
    return Facts(low, high, is_inside=is_inside, is_touching=not is_inside, share=shared / least)


DRESSES = 3


def solids(rng: Random) -> Groups:
    """Tori, tubes, balls, hollow balls, L, U, tee and more. Branch and bound; verdicts from volumes by manifold3d."""
    while True:
        a, b = solid(rng), solid(rng)
        b = b[0] * rng.choice([0.1, 0.2, 0.5, 1]) + rng.normal(size=3) * 0.07, b[1]
        facts = of_solids(a, b)
        if facts is not None:
            for _ in range(DRESSES):
                yield Group("any solids", (_worn(rng, a, 2), _worn(rng, b, 2)), {(0, 1): facts}, *_dress(rng))


# Pins in holes.

RADIUS_M = 0.005


def pin_in_hole(rng: Random) -> tuple[Mesh, Mesh, float]:
    """A pin, a block with a hole of the same nominal radius, and D. The radius of the pin may be up to 50 µm larger."""
    sides = [int(rng.choice([16, 20, 24, 32, 48, 64])) for _ in range(2)]
    phase = float(rng.uniform(0, 1)) if rng.random() < 0.7 else 0.0
    radius = RADIUS_M + float(rng.choice([0, 0, 1e-6, 1e-5, 5e-5]))
    form = int(rng.integers(4))
    low = [-0.01, 0.0, 0.0, -0.01][form]  # through, flush below, blind, headed
    head = [(0.009, 0.03), (0.009, 0.036), (0.0, 0.036)] if form == 3 else [(radius, 0.04), (0.0, 0.04)]
    shaft = [(0.0, low), (radius, low), *([(radius, 0.03)] if form == 3 else [])]
    pin = revolved([*shaft, *head], sides[0], phase)
    if form == 2:
        outline = [(0, -0.01), (0.02, -0.01), (0.02, 0.03), (RADIUS_M, 0.03), (RADIUS_M, 0.0), (0, 0.0)]
        block = revolved(outline, sides[1])
    else:
        block = tube(RADIUS_M, 0.02, 0.0, 0.03, sides[1])
    sections = []
    for number, own_radius, own_phase in ((sides[0], radius, phase), (sides[1], RADIUS_M, 0.0)):
        angles = own_phase + 2 * np.pi * np.arange(number) / number
        sections.append(own_radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return pin, block, flat.overlap_in_plane(*sections)


def pins(rng: Random) -> Groups:
    """Pins in holes, with a `contact` of 0.99 and 1.01 times the depth, and the default."""
    while True:
        pin, block, depth = pin_in_hole(rng)
        turn, place = _dress(rng)
        if depth < 1e-12:
            yield Group("pins in holes", (pin, block), {(0, 1): Facts(0.0, 0.0)}, turn, place)
            continue
        facts = Facts(depth * (1 - 1e-9), depth * (1 + 1e-9))
        for factor, right in ((None, CLASH), (0.99, CLASH), (1.01, CONTACT)):
            contact = None if factor is None else factor * depth
            yield Group(
                "pins in holes", (pin, block), {(0, 1): facts}, turn, place, contact=contact, right={(0, 1): right}
            )


# Copies, sheets, foils, flush webs.


def copies(rng: Random) -> Groups:
    """The same surface twice, with other triangles; and a solid with a copy that has a cavity."""
    planes = (np.array([-0.2, -0.1, 0.05, 0.2]),) * 3
    while True:
        if rng.random() < 0.2:
            full = Polycube(np.argwhere(np.ones((3, 3, 3), bool)), planes)
            hollow = Polycube(np.array(PATTERNS["hollow"]), planes)
            facts = whole_numbers.polycubes(full, hollow)
            a, b = full.mesh(rng), hollow.mesh(rng)
        else:
            facts = Facts(0.0, 0.0, is_same=True, share=1.0)
            if rng.random() < 0.5:
                a = solid(rng)
                b = a
            else:
                x, y, z = (np.cumsum(rng.uniform(0.03, 0.15, 7)) - 0.3 for _ in range(3))
                body = Polycube(pattern(rng), (x, y, z))
                turn = random_turn(rng)
                a, b = ((mesh[0] @ turn.T, mesh[1]) for mesh in (body.mesh(rng), body.mesh(rng)))
        yield Group("copies, cut otherwise", (_worn(rng, a), _worn(rng, b)), {(0, 1): facts}, *_dress(rng))


def copies_in_single(rng: Random) -> Groups:
    """The same surface twice, with other triangles, through files in single precision."""
    for group in copies(rng):
        if group.facts[0, 1].is_same:
            yield replace(group, kind="copies, cut otherwise, in float32", place=np.zeros(3), is_single=True)


SHEET_CONTACTS = (None, None, 1.5e-6, 1.5e-4, 1.2e-3)
"""Values of `contact` for open sheets, metres: between the small offsets."""


def _sheet_depth(start: Floats, ends: Floats, low: Floats, high: Floats) -> float:
    """The farthest that a point of a rectangle lies inside a box, both with the edges of the axes; units."""
    middle = np.clip(0.5 * (low + high), start, ends)
    return float(np.minimum(middle - low, high - middle).min())


def _of_sheets(
    rng: Random, kind: str, parts: tuple[Mesh, Mesh], facts: Facts, dress: tuple[Floats, Floats, float, bool]
) -> Group:
    """A pair with a sheet, at one of several values of `contact`; dress: of `_whole_dress`."""
    turn, place, scale, is_rounded = dress
    chosen = SHEET_CONTACTS[int(rng.integers(len(SHEET_CONTACTS)))]
    contact = None if chosen is None else chosen * scale
    worn = (_worn(rng, parts[0]), _worn(rng, parts[1]))
    scaled = {(0, 1): facts.scaled(UNIT_M * scale)}
    return Group(kind, worn, scaled, turn, place, UNIT_M, is_rounded, contact, CLEARANCE_M)


def sheets(rng: Random) -> Groups:
    """Rectangles without thickness through, on and in a box, at several values of `contact`. Closed form."""
    while True:
        low: Floats = np.zeros(3)
        high = rng.integers(2, 5, 3).astype(float) * (4 * CELL)
        start = rng.integers(-1, 4, 3) * float(4 * CELL) + _misses(rng)
        ends = np.array([*(start[:2] + rng.integers(1, 5, 2) * float(4 * CELL)), start[2]])
        gap = float(np.linalg.norm(np.maximum(np.maximum(low - ends, start - high), 0)))
        depth = max(_sheet_depth(start, ends, low, high), 0.0)
        is_inside = depth > 0 and bool((start >= low).all() and (ends <= high).all())
        is_touching = bool((start[:2] == 0).any() or (ends == high)[:2].any()) or not is_inside
        facts = Facts(depth, depth, gap, False, is_inside, is_touching, 0.0, True)
        turn, place, scale, is_rounded = _whole_dress(rng)
        plate = sheet(list(start[:2]), list(ends[:2]), float(start[2]))
        a = (plate[0][:, [2, 0, 1]], plate[1])
        b = box(np.roll(low, 1), np.roll(high, 1)).mesh()
        if depth > 0 and not is_inside:
            # After a rotation, an overlap of a nanometre would depend on rounding.
            out = np.concatenate([(ends - low)[:2], (high - start)[:2], start[2:] - low[2:], high[2:] - start[2:]])
            if is_rounded and out.min() < STEPS[1]:
                continue
        yield _of_sheets(rng, "open sheets in boxes", (a, b), facts, (turn, place, scale, is_rounded))


SAMPLED = 0.01
"""The share by which the depth of two open parts, taken at points where they cross, may be too small."""


def crossing_sheets(rng: Random) -> Groups:
    """Two rectangles without thickness at right angles: through, on or beside each other. Closed form.

    Along the segment in which they cross, the depth is the least of four lengths: how far each goes on behind the other
    on its shorter side, and how far it is to both ends of the segment.
    """
    while True:
        # One is in the plane z = 0, the other in x = 0; y is along the segment.
        ends = rng.integers(0, 4, 8) * float(2 * CELL) + np.concatenate([_misses(rng) for _ in range(3)])[:8]
        (left, right), (down, up) = (-ends[0], ends[1]), (-ends[2], ends[3])
        if right - left < CELL or up - down < CELL:
            continue
        spans = [(ends[4], ends[4] + float(4 * CELL)), (ends[5], ends[5] + float(6 * CELL))]
        along = min(spans[0][1], spans[1][1]) - max(spans[0][0], spans[1][0])
        reach = np.array([-left, right, -down, up])
        gap = float(np.linalg.norm([max(-along, 0.0), *(max(-min(reach[k : k + 2]), 0.0) for k in (0, 2))]))
        depth = max(min(float(reach.min()), along / 2), 0.0)
        turn, place, scale, is_rounded = _whole_dress(rng)
        if is_rounded and 0 < depth < STEPS[1]:
            continue
        one = sheet([left, spans[0][0]], [right, spans[0][1]], 0.0)
        flat_other = sheet([spans[1][0], down], [spans[1][1], up], 0.0)
        other = (flat_other[0][:, [2, 0, 1]], flat_other[1])
        facts = Facts(depth * (1 - SAMPLED), depth, gap, is_open=True)
        yield _of_sheets(rng, "two open sheets", (one, other), facts, (turn, place, scale, is_rounded))


WALL_CONTACT_M, AWAY_FROM_LIMIT = 5e-4, 0.03


def walls(rng: Random) -> Groups:
    """Thin walls side by side that share a part of their thickness, at a `contact` that their depth does not exceed.

    They clash if they share more than `contact`; foils thinner than that are in contact. Nearer than 3 % to the limits
    of that rule no pair is drawn.
    """
    while True:
        thick = WALL_CONTACT_M * float(rng.uniform(0.3, 1.9))
        shared = thick if rng.random() < 0.2 else thick * float(rng.uniform(0.05, 1.0))
        if abs(shared / WALL_CONTACT_M - 1) < AWAY_FROM_LIMIT or abs(thick / WALL_CONTACT_M - 1) < AWAY_FROM_LIMIT:
            continue
        sizes = rng.uniform(0.05, 0.2, (2, 2))
        aside = rng.uniform(0.1, 0.6, 2) * sizes.min(axis=0) * rng.choice([-1, 1], 2)
        if rng.random() < 0.1 and shared < thick:
            sizes[1], aside = sizes[0], np.zeros(2)  # one over the other, with all edges in line
        a = box([0, 0, 0], [*sizes[0], thick])
        b = box([*aside, thick - shared], [*(aside + sizes[1]), 2 * thick - shared])
        depth = flat.deepest_of_convex(a, b)
        right = CLASH if shared > WALL_CONTACT_M else CONTACT
        ends = aside + sizes[1]
        is_in = ((aside > 0) & (ends < sizes[0])).all() or ((aside < 0) & (ends > sizes[0])).all()
        if shared == thick and is_in:
            right |= CONTAINED  # flush with both faces of the other; rounding may move it out of one
        yield Group(
            "walls side by side",
            (_worn(rng, a.mesh()), _worn(rng, b.mesh())),
            {(0, 1): Facts(depth * (1 - 1e-9), depth * (1 + 1e-9))},
            *_dress(rng),
            contact=WALL_CONTACT_M,
            right={(0, 1): right},
        )


FOIL_M, FOIL_CONTACT_M = 50e-6, 1e-4


def foils(rng: Random) -> Groups:
    """Foils of half the `contact`: a clash if pierced, a contact if they lie on a part or are slightly sunk into it."""
    while True:
        foil = box([-0.05, -0.05, -FOIL_M / 2], [0.05, 0.05, FOIL_M / 2])
        kind = int(rng.integers(5))
        right = CLASH
        if kind == 0:
            other = frustum(int(rng.integers(4, 17)), rng.uniform(1e-3, 0.02), rng.uniform(1e-3, 0.02), 0.06)
        elif kind == 1:
            other = frustum(int(rng.integers(4, 9)), 40e-6, 40e-6, 0.02)  # a needle as thin as the foil
        elif kind == 2:
            other = box([-FOIL_M / 2, -0.03, -0.02], [FOIL_M / 2, 0.03, 0.04])  # another foil
        elif kind == 3:
            other = box([-0.02, -0.02, -0.01], [0.02, 0.02, 0.03])
        else:
            sunk = float(rng.choice([0.0, 1e-6, 1e-5]))
            other = box([-0.02, -0.02, FOIL_M / 2 - sunk], [0.02, 0.02, 0.03])
            right = CONTACT
        if kind < 4:
            tilt = random_turn(rng)
            if abs(tilt[2, 2]) < 0.7:
                continue
            other = other.placed(tilt, np.array([*rng.uniform(-0.02, 0.02, 2), 0]))
        depth = flat.deepest_of_convex(foil, other)
        facts = Facts(max(0.0, depth - 1e-14), max(0.0, depth) + 1e-14)
        parts = (_worn(rng, foil.mesh()), _worn(rng, other.mesh()))
        yield Group(
            "foils, pierced or laid on",
            parts,
            {(0, 1): facts},
            *_dress(rng),
            contact=FOIL_CONTACT_M,
            right={(0, 1): right},
        )


def webs(rng: Random) -> Groups:
    """Rotated bars through the webs of U and H frames, flush all around up to rounding."""
    while True:
        size = float(rng.choice([0.0625, 0.05]))
        frame = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)]
        if rng.random() < 0.5:
            frame += [(0, -1, 0), (2, -1, 0)]
        bar = [(1, 0, k) for k in range(int(rng.integers(-2, 0)), int(rng.integers(2, 4)))]
        bodies = []
        for cells in (frame, bar):
            from_zero = np.add(cells, (0, 2, 2))
            bodies.append(Polycube(from_zero, even_planes(from_zero, size, (0, -2 * size, -2 * size))))
        facts = whole_numbers.polycubes(*bodies)
        contact = None if rng.random() < 0.3 else 1e-4
        meshes = [_worn(rng, body.mesh(rng)) for body in bodies]
        yield Group(
            "bars flush in webs", tuple(meshes), {(0, 1): facts}, *_dress(rng), contact=contact, right={(0, 1): CLASH}
        )


Maker = Callable[[Random], Groups]
KINDS: dict[str, tuple[Maker, int]] = {
    "boxes": (boxes, 9000),
    "convex": (convex, 4500),
    "fine": (fine, 120),
    "polycubes": (polycubes, 400),
    "polycubes_in_contact": (polycubes_in_contact, 100),
    "balls": (balls, 600),
    "solids": (solids, 1200),
    "pins": (pins, 1200),
    "copies": (copies, 600),
    "copies_in_single": (copies_in_single, 400),
    "sheets": (sheets, 1000),
    "crossing_sheets": (crossing_sheets, 1000),
    "walls": (walls, 400),
    "foils": (foils, 240),
    "webs": (webs, 120),
}
"""By name: the generator, and the number of groups in a full run. A group of polycubes has 36 pairs."""


def groups(name: str, number: int, seed: int) -> Groups:
    """The first `number` groups of a kind."""
    maker, _ = KINDS[name]
    return islice(maker(np.random.default_rng([seed, *name.encode()])), number)
