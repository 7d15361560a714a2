"""Random assemblies of plates under bolts with brackets, hoods, bars, fences and plugs, whose truth is known by their
construction.

A base block, plates on it, bolts through them into the base; hoods over heads, bars above heads and fences around them,
which are in the way of tools; plugs in the base; brackets on plates, which can leave with them, and straps from plate
to plate or base. Boxes are parallel to the axes, bolts along z.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

manifold3d = import_module("manifold3d")  # an extra, without type information

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MOST_PARTS, MOST_WITH_BRACKETS = 7, 9
SIZE_M, CLEAR_M = 0.008, 0.0045
"""Diameter of the bolts, and the radius of their holes in plates."""
ENGAGED_M = 0.01
"""How deep bolts are in the base."""
SHALLOW_M = 0.0045
"""How deep those of brackets are in plates, which are thicker."""
PLATE_M, SIDE_M, BASE_M = 0.006, 0.06, 0.03
PLACES = ((-0.035, -0.035), (-0.035, 0.035), (0.035, -0.035), (0.035, 0.035))
GAP_M = 2e-5
"""Between parts that lie on each other: no flush faces."""
TOLERANCE = Tolerance(2e-4)


@dataclass
class Part:
    """A part of boxes, `(n, 2, 3)`, metres; a bolt's are around its shank and head."""

    name: str
    boxes: Floats
    mesh: tuple[Floats, Ints]
    is_bolt: bool = False
    holds: set[int] = field(default_factory=set)
    """Of a bolt: the plates that it goes through, or its bracket."""
    travel: float = 0.0
    anchor: int = 0
    """The part that a bolt has its thread in."""
    engaged: float = ENGAGED_M
    """Of a bolt: how deep."""


@dataclass
class Assembly:
    """Parts, the one that is wanted, and those that stay."""

    parts: list[Part]
    wanted: int = 0
    keep: frozenset[int] = frozenset()

    def mockup(self) -> feeler.Mockup:
        """The parts as one mock-up."""
        meshes = [part.mesh for part in self.parts]
        first = np.cumsum([0] + [len(corners) for corners, _ in meshes])
        return feeler.Mockup(
            np.concatenate([corners for corners, _ in meshes]),
            np.concatenate([faces + begin for (_, faces), begin in zip(meshes, first, strict=False)]),
            np.repeat(np.arange(len(meshes)), [len(faces) for _, faces in meshes]),
            [part.name for part in self.parts],
        )


def random_assembly(seed: int) -> Assembly:
    """The assembly of a number."""
    rng = np.random.default_rng([seed, 64])
    made = Assembly([])
    half = SIDE_M
    _add_box(made, "base", [[-half, -half, -BASE_M], [half, half, 0.0]])
    count = int(rng.integers(1, 3))
    plates = [_plate(rng, level) for level in range(count)]
    bolts = [place for place in rng.permutation(len(PLACES)).tolist()[: int(rng.integers(1, 4))]]
    for level, (low, high) in enumerate(plates):
        holes = [PLACES[place] for place in bolts if _is_in(PLACES[place], low, high)]
        made.parts.append(_drilled(f"plate_{level}", low, high, holes))
    for place in bolts:
        _add_bolt(made, place, plates)
    tops = {place: _top(PLACES[place], plates) for place in bolts}
    for place in bolts:
        if len(made.parts) < MOST_PARTS and rng.random() < 0.8:
            _add_obstacle(made, rng, PLACES[place], tops[place])
            if _overlaps(made.parts[-1], made.parts[:-1]):
                made.parts.pop()
    if len(made.parts) < MOST_PARTS and rng.random() < 0.3:
        free = [place for place in range(len(PLACES)) if place not in bolts]
        _add_bolt(made, free[0], [], "plug")
        if _overlaps(made.parts[-1], made.parts[1:-1]):
            made.parts.pop()
    _add_brackets(made, np.random.default_rng([seed, 65]), bolts, plates)
    others = [n for n, part in enumerate(made.parts) if n and not part.name.startswith(("hood", "bar", "fence"))]
    made.wanted = 1 if rng.random() < 0.6 else int(rng.choice(others))
    movable = [n for n, part in enumerate(made.parts) if n and n != made.wanted and not part.is_bolt]
    made.keep = frozenset([0, *(n for n in movable if rng.random() < 0.1)])
    return made


def _add_brackets(
    made: Assembly, rng: np.random.Generator, taken: list[int], plates: list[tuple[Floats, Floats]]
) -> None:
    """Brackets at places without bolts: small ones, ones with an arm above another place, and straps of two bolts."""
    free = [place for place in rng.permutation(len(PLACES)).tolist() if place not in taken]
    while free and rng.random() < 0.6:
        place, kind = free.pop(), int(rng.integers(0, 3))
        other = int(rng.choice(_beside(place)))
        is_strap = kind == 2 and other in free
        feet = [place, other] if is_strap else [place]
        if len(made.parts) + 1 + len(feet) > MOST_WITH_BRACKETS:
            return
        if all(_top(PLACES[each], plates) <= GAP_M for each in feet):
            continue  # it would be fastened to the base alone
        begin = len(made.parts)
        _add_bracket(made, rng, feet, PLACES[other] if kind == 1 else None, plates)
        if any(_clashes(made, n) for n in range(begin, len(made.parts))):
            del made.parts[begin:]
        elif is_strap:
            free.remove(other)


def _add_bracket(
    made: Assembly,
    rng: np.random.Generator,
    feet: list[int],
    towards: tuple[float, float] | None,
    plates: list[tuple[Floats, Floats]],
) -> None:
    """A bracket with a bolt in each foot, and an arm above heads from foot to foot, or towards a place."""
    number, wide, thick = len(made.parts), 0.011, 0.004
    tops = [_top(PLACES[foot], plates) for foot in feet]
    boxes = []
    for foot, top in zip(feet, tops, strict=True):
        (x, y), low = PLACES[foot], top + GAP_M
        boxes.append([[x - wide, y - wide, low], [x + wide, y + wide, low + thick]])
    ends = [PLACES[foot] for foot in feet] + ([] if towards is None else [towards])
    if len(ends) > 1:
        low, high = max(tops) + float(rng.choice([0.016, 0.03])), max(tops) + 0.04
        axis = 0 if ends[0][0] != ends[1][0] else 1
        begin, end = sorted(each[axis] for each in ends)
        # A post beside each foot, where the arm is: no bracket is above its own heads.
        for foot, top in zip(feet, tops, strict=True):
            is_first = PLACES[foot][axis] == begin
            side = PLACES[foot][axis] + (wide if is_first else -wide - 0.003)
            boxes.append(_across(PLACES[foot], axis, (side, side + 0.003), (top + GAP_M, high)))
            begin, end = (side, end) if is_first else (begin, side + 0.003)
        boxes.append(_across(ends[0], axis, (begin, end), (low, high)))
    solid = _box(boxes[0])
    for box in boxes[1:]:
        solid = solid + _box(box)
    for foot, top in zip(feet, tops, strict=True):
        drill = manifold3d.Manifold.cylinder(2.0 * thick, CLEAR_M, CLEAR_M, 24)
        solid = solid - drill.translate((*PLACES[foot], top - 0.5 * thick))
    made.parts.append(Part(f"bracket_{number}", np.array(boxes), _arrays(solid)))
    for foot, top in zip(feet, tops, strict=True):
        on = [1 + n for n, (low_, high_) in enumerate(plates) if _is_in(PLACES[foot], low_, high_)]
        _add_bracket_bolt(made, PLACES[foot], top + GAP_M + thick + GAP_M, number, max(on, default=0))


def _beside(place: int) -> list[int]:
    """The places next to one, along x and along y."""
    x, y = PLACES[place]
    return [n for n, each in enumerate(PLACES) if (each[0] == x) != (each[1] == y)]


def _across(
    place: tuple[float, float], axis: int, along: tuple[float, float], heights: tuple[float, float]
) -> list[list[float]]:
    """The corners of a narrow box at a place, from here to there along an axis."""
    corners = [[0.0, 0.0, heights[0]], [0.0, 0.0, heights[1]]]
    for corner, far, side in zip(corners, along, (-0.005, 0.005), strict=True):
        corner[axis], corner[1 - axis] = far, place[1 - axis] + side
    return corners


def _add_bracket_bolt(made: Assembly, place: tuple[float, float], head: float, bracket: int, anchor: int) -> None:
    """A bolt through the foot of a bracket."""
    engaged = SHALLOW_M if anchor else ENGAGED_M
    top = float(made.parts[anchor].boxes[:, 1, 2].max())
    bolt = _bolt(f"bolt_{len(made.parts)}", place, head, head - top + engaged)
    bolt.holds, bolt.anchor, bolt.engaged = {bracket}, anchor, engaged
    made.parts.append(bolt)


def _clashes(made: Assembly, number: int) -> bool:
    """Whether a part overlaps others than those that it goes through."""
    part = made.parts[number]
    through = {*part.holds, part.anchor} if part.is_bolt else set[int]()
    passed = through | {n for n, other in enumerate(made.parts) if number in {*other.holds, other.anchor}}
    rest = [other for n, other in enumerate(made.parts) if n != number and n not in passed]
    return _overlaps(part, rest) if rest else False


def tools() -> dict[str, Any]:
    """A stubby handle that swings nearly everywhere, and a long one that goes over low obstacles."""
    return {"stubby": _handle(0.018, 0.001, "stubby"), "crank": _handle(0.05, 0.03, "crank")}


def _handle(length: float, height: float, name: str) -> feeler.Tool:
    """A rod up from the head, and a handle across."""
    rod = _box([[-0.002, -0.002, 0.0005], [0.002, 0.002, height + 0.004]])
    arm = _box([[-0.002, -0.002, height], [length, 0.002, height + 0.004]])
    corners, faces = _arrays(rod + arm)
    return feeler.Tool(corners, faces, name)


def _plate(rng: np.random.Generator, level: int) -> tuple[Floats, Floats]:
    """Corners: of the whole face, or of one half."""
    low = np.array([-SIDE_M, -SIDE_M, level * (PLATE_M + GAP_M) + GAP_M])
    high = np.array([SIDE_M, SIDE_M, low[2] + PLATE_M])
    side = int(rng.integers(0, 3))
    if side == 1:
        high[0] = -0.005
    elif side == 2:
        low[0] = 0.005
    return low, high


def _is_in(place: tuple[float, float], low: Floats, high: Floats) -> bool:
    return bool(low[0] < place[0] < high[0] and low[1] < place[1] < high[1])


def _top(place: tuple[float, float], plates: list[tuple[Floats, Floats]]) -> float:
    """Where the head of a bolt lies."""
    return max((float(high[2]) for low, high in plates if _is_in(place, low, high)), default=0.0) + GAP_M


def _add_box(made: Assembly, name: str, corners: list[list[float]]) -> None:
    box = np.array(corners, dtype=np.float64)
    made.parts.append(Part(name, box[None], _arrays(_box(corners))))


def _drilled(name: str, low: Floats, high: Floats, holes: list[tuple[float, float]]) -> Part:
    solid = _box([low.tolist(), high.tolist()])
    for x, y in holes:
        drill = manifold3d.Manifold.cylinder(3.0 * PLATE_M, CLEAR_M, CLEAR_M, 24)
        solid = solid - drill.translate((x, y, float(low[2]) - PLATE_M))
    return Part(name, np.array([[low, high]]), _arrays(solid))


def _add_bolt(made: Assembly, place: int, plates: list[tuple[Floats, Floats]], name: str = "bolt") -> None:
    x, y = PLACES[place]
    top = _top((x, y), plates)
    bolt = _bolt(f"{name}_{sum(part.is_bolt for part in made.parts)}", (x, y), top, top + ENGAGED_M)
    bolt.holds = {1 + level for level, (low, high) in enumerate(plates) if _is_in((x, y), low, high)}
    made.parts.append(bolt)


def _bolt(name: str, place: tuple[float, float], top: float, length: float) -> Part:
    """A bolt whose head lies at a height."""
    x, y = place
    mesh = hardware.hex_bolt(SIZE_M, length, TOLERANCE)
    corners = mesh.vertices + np.array([x, y, top])
    head = float(corners[:, 2].max())
    wide = float(np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]).max())
    boxes = np.array(
        [
            [[x - 0.5 * SIZE_M, y - 0.5 * SIZE_M, top - length], [x + 0.5 * SIZE_M, y + 0.5 * SIZE_M, top]],
            [[x - wide, y - wide, top], [x + wide, y + wide, head]],
        ]
    )
    return Part(name, boxes, (corners, mesh.faces.astype(np.int64)), True, travel=length)


def _add_obstacle(made: Assembly, rng: np.random.Generator, place: tuple[float, float], top: float) -> None:
    """Over, above or beside a head."""
    x, y = place
    number = len(made.parts)
    kind = int(rng.integers(0, 4))
    if kind == 0:
        wide, low = 0.016, top + GAP_M
        outer = [[x - wide, y - wide, low], [x + wide, y + wide, low + 0.03]]
        inner = [[x - wide + 0.003, y - wide + 0.003, low - 1.0], [x + wide - 0.003, y + wide - 0.003, low + 0.026]]
        walls = [
            [[x - wide, y - wide, low], [x - wide + 0.003, y + wide, low + 0.03]],
            [[x + wide - 0.003, y - wide, low], [x + wide, y + wide, low + 0.03]],
            [[x - wide, y - wide, low], [x + wide, y - wide + 0.003, low + 0.03]],
            [[x - wide, y + wide - 0.003, low], [x + wide, y + wide, low + 0.03]],
            [[x - wide, y - wide, low + 0.026], [x + wide, y + wide, low + 0.03]],
        ]
        made.parts.append(Part(f"hood_{number}", np.array(walls), _arrays(_box(outer) - _box(inner))))
    elif kind == 1:
        low = top + float(rng.choice([0.012, 0.025, 0.05]))
        far = 0.055 if rng.random() < 0.5 else 0.012
        _add_box(made, f"bar_{number}", [[x - 0.012, y - far, low], [x + 0.012, y + far, low + 0.006]])
    else:
        _add_fence(made, f"fence_{number}", rng, (x, y), top)


def _add_fence(made: Assembly, name: str, rng: np.random.Generator, place: tuple[float, float], top: float) -> None:
    """Two or three walls around a head: low ones, over which a crank turns, or high ones."""
    x, y = place
    away, low = float(rng.choice([0.011, 0.014])), top + GAP_M
    high = low + float(rng.choice([0.015, 0.045]))
    walls = [
        [[x - away - 0.003, y - away, low], [x - away, y + away, high]],
        [[x - away - 0.003, y + away, low], [x + away + 0.003, y + away + 0.003, high]],
        [[x + away, y - away, low], [x + away + 0.003, y + away, high]],
    ]
    walls = walls[: int(rng.integers(2, 4))]
    solid = _box(walls[0])
    for wall in walls[1:]:
        solid = solid + _box(wall)
    made.parts.append(Part(name, np.array(walls), _arrays(solid)))


def _overlaps(part: Part, others: list[Part]) -> bool:
    boxes = np.concatenate([other.boxes for other in others])
    low, high = part.boxes[:, None, 0], part.boxes[:, None, 1]
    overlap = np.minimum(high, boxes[None, :, 1]) - np.maximum(low, boxes[None, :, 0])
    return bool((overlap > 0.0).all(axis=2).any())


def _box(corners: list[list[float]]) -> Any:
    low, high = np.array(corners)
    return manifold3d.Manifold.cube((high - low).tolist()).translate(low.tolist())


def _arrays(solid: Any) -> tuple[Floats, Ints]:
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(np.int64)
