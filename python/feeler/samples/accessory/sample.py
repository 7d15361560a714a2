"""The gearbox as arrays for a number of triangles, and its known facts."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import lru_cache

import numpy as np

from feeler.progress import Progress

from ...errors import OptionError
from ..mesh import Floats, Mesh, MeshParts, snapped, times
from . import assembly
from .assembly import MATERIALS, Assembly, Part, tool_room
from .build import build
from .faults import block_ring, plant
from .solid import Cut, Solid
from .standard import SEAT_RAD
from .swings import FULL, LENGTH, WIDTH, widest_swing, wrench
from .truth import SWING_RAD, Body, Fastener, Fault, Fit, Joint, Keeper, Leg, Stay, Step, Truth, steps_before

ROOT = "gearbox"
MM = 1e-3
Vector = tuple[float, float, float]
COARSEST_MM = 1.6
"""The largest chord: larger, and circles of neighbouring holes and edges cross."""
LEVEL_RATIO = 2.0 ** (-1.0 / 3.0)
COUNTS = {
    0: 39_000,
    2: 44_000,
    3: 66_000,
    6: 80_000,
    9: 118_000,
    12: 184_000,
    18: 413_000,
    27: 1_797_000,
    39: 15_600_000,
}
"""About how many triangles there are at a level, to begin with the right one."""


class Drawn:
    """An assembly with every part's solid at one of two neighbouring chords, so that the triangles number as wanted.

    Planted faults change no other part: the parts that they add come on top.
    """

    def __init__(self, triangles: int, seed: int, faults: Sequence[str]) -> None:
        made, finer = _neighbours(triangles, seed)
        if made.triangle_count > triangles:
            raise OptionError(
                f"triangles is {triangles}; the {len(made.parts)} parts of the sample 'gearbox' have at least "
                f"{made.triangle_count} with this seed; give that or more"
            )
        self.assembly = made
        self.solids: dict[Hashable, Solid] = {}
        copies: dict[Hashable, int] = {}
        for part in made.parts.values():
            self.solids[part.shape] = made.solid(part)
            copies[part.shape] = copies.get(part.shape, 0) + 1
        left = triangles - made.triangle_count
        # shapes are the same ones at both chords, in the same order
        better = [(finer.solid(b), a.shape) for a, b in zip(made.parts.values(), finer.parts.values(), strict=True)]
        gains = {
            shape: (copies[shape] * (s.triangle_count - self.solids[shape].triangle_count), s) for s, shape in better
        }
        for shape, (gain, solid) in sorted(gains.items(), key=lambda item: -item[1][0]):
            if 0 < gain <= left:
                self.solids[shape] = solid
                left -= gain
        made.planted = plant(made, faults)
        for part in made.parts.values():
            if part.shape not in self.solids:
                self.solids[part.shape] = made.solid(part)

    def meshes(self, told: Callable[[float], None] = lambda _share: None) -> list[tuple[Part, Mesh]]:
        """Every part with its mesh in the world, metres."""
        return placed_meshes(self.assembly, self.solids, told)


Built = tuple[Assembly, list[tuple[Part, Mesh]]]
_last: tuple[Hashable, Built] | None = None
"""The last gearbox, by its arguments: arrays and facts are mostly requested one after the other."""


def _built(triangles: int, seed: int, faults: Sequence[str], progress: Progress | None = None) -> Built:
    """The assembly, and every part with its mesh in the world, metres; of no use to a caller that changes them."""
    global _last
    key, last = (triangles, seed, tuple(faults)), _last
    if last is not None and last[0] == key:
        return last[1]
    _last = last = None  # two are not held at a time
    if progress:
        progress(0.0, "tessellating")
    drawn = Drawn(triangles, seed, faults)

    def told(share: float) -> None:
        if progress:
            progress(0.3 + 0.6 * share, "tessellating")

    told(0.0)
    built = drawn.assembly, drawn.meshes(told)
    built[0].forget()
    _last = key, built
    return built


def placed_meshes(
    asm: Assembly,
    solids: dict[Hashable, Solid] | None = None,
    told: Callable[[float], None] = lambda _share: None,
) -> list[tuple[Part, Mesh]]:
    """Every part with its mesh in the world, metres; `solids`: by shape, where not the assembly's."""
    out: list[tuple[Part, Mesh]] = []
    made: dict[Hashable, Mesh] = {}
    for number, part in enumerate(asm.parts.values()):
        if part.shape not in made:
            made[part.shape] = (asm.solid(part) if solids is None else solids[part.shape]).mesh()
        out.append((part, _placed(part, made[part.shape])))
        told(number / len(asm.parts))
    return out


def placed_mesh(asm: Assembly, part: Part) -> Mesh:
    """One part with its mesh in the world, metres."""
    return _placed(part, asm.mesh(part))


def _placed(part: Part, mesh: Mesh) -> Mesh:
    vertices = (times(mesh.vertices, part.scale * part.pose[:3, :3].T) + part.pose[:3, 3]) * MM
    faces = mesh.faces if np.linalg.det(part.pose[:3, :3]) > 0.0 else mesh.faces[:, ::-1]
    return Mesh(snapped(vertices), faces)


def _neighbours(triangles: int, seed: int) -> tuple[Assembly, Assembly]:
    """The gearbox without faults at two neighbouring levels: the finest that does not exceed the triangles, or the
    coarsest, and the next one."""

    @lru_cache
    def made(level: int) -> Assembly:
        return build(Cut(COARSEST_MM * LEVEL_RATIO**level), seed)

    level = int(np.interp(np.log(max(triangles, 1)), np.log(list(COUNTS.values())), list(COUNTS)))
    while level < max(COUNTS) and made(level + 1).triangle_count <= triangles:
        level += 1
    while level > 0 and made(level).triangle_count > triangles:
        level -= 1
    return made(level), made(level + 1)


def gearbox_parts(triangles: int, seed: int, faults: Sequence[str], progress: Progress | None = None) -> MeshParts:
    """The gearbox as arrays; see `feeler.sample`."""
    _, meshes = _built(triangles, seed, faults, progress)
    starts = np.cumsum([0, *(len(mesh.vertices) for _, mesh in meshes)])
    counts = [mesh.triangle_count for _, mesh in meshes]
    paths = [part.path for part, _ in meshes]
    return MeshParts(
        np.concatenate([mesh.vertices for _, mesh in meshes]),
        np.concatenate([mesh.faces + start for (_, mesh), start in zip(meshes, starts, strict=False)]).astype(
            np.uint32
        ),
        np.repeat(np.arange(len(meshes), dtype=np.uint32), counts),
        paths,
        [f"{ROOT}/{path}" for path in paths],
        np.array([MATERIALS[part.material].colour for part, _ in meshes]),
    )


@lru_cache(maxsize=2)
def gearbox_truth(triangles: int, seed: int, faults: tuple[str, ...]) -> Truth:
    """The known facts of `gearbox_parts` with the same arguments."""
    made, meshes = _built(triangles, seed, faults)
    return truth_of(made, {part.path: mesh for part, mesh in meshes}, seed)


def volume(mesh: Mesh) -> float:
    """Of a closed mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def truth_of(asm: Assembly, meshes: dict[str, Mesh], seed: int) -> Truth:
    """The facts of the assembly, in metres and with full paths; `meshes`: in the world, by the assembly's paths.

    Without meshes masses are 0, and wrenches swing in full.
    """
    asm.wait_for_lines()
    for planted in asm.planted:
        if planted.expects == "unit":
            block_ring(asm, planted.parts[0], meshes)

    def full(path: str) -> str:
        return f"{ROOT}/{path}"

    def many(paths: Sequence[str]) -> tuple[str, ...]:
        return tuple(full(path) for path in paths)

    bodies = []
    for part in asm.parts.values():
        material = MATERIALS[part.material]
        bodies.append(
            Body(
                full(part.path),
                part.material,
                material.density,
                material.density * volume(meshes[part.path]) if meshes else 0.0,
                material.colour,
            )
        )
    steps = []
    blocked: dict[str, dict[str, None]] = {}
    for step, after in ordered(asm):
        legs = tuple(Leg(g.kind, g.axis, _metres(g.point), _metre(g.distance), g.angle) for g in step.legs)
        by = dict.fromkeys(
            [*step.blocked_by, *(name for path in [*after, *step.parts] for name in blocked.get(path, ()))]
        )
        for path in step.parts:
            blocked[path] = by
        middle = (0.0, 0.0, 0.0) if step.rigid else _metres(asm.parts[step.parts[0]].pose[:3, 3])
        moved, needs, wide = many(step.parts), many(after), _metre(step.spread)
        steps.append(Step(moved, legs, needs, step.door_open, step.rigid, step.removes, tuple(by), wide, middle))
    plain_steps = tuple(steps)
    joints = tuple(
        Joint(
            j.name,
            "revolute" if j.limits else "continuous",
            many(j.parts),
            j.axis,
            _metres(j.point),
            j.limits[0] if j.limits else None,
            j.limits[1] if j.limits else None,
            j.follows,
            j.ratio,
            tuple(j.needs),
        )
        for j in asm.joints
    )
    room = Room({full(path): mesh for path, mesh in meshes.items()}, plain_steps, joints)
    fasteners = tuple(_fastener(asm, f, room) for f in asm.fasteners)
    keepers = tuple(Keeper(full(path), kind, many(held)) for path, kind, held in asm.keepers)
    stays = tuple(Stay(full(path), because) for path, because in asm.stays.items())
    fits = tuple(
        Fit(full(f.a), full(f.b), f.kind, _metre(f.play), _metre(f.deepest), f.flush) for f in asm.fits.values()
    )
    faults = tuple(
        Fault(f.name, many(f.parts), f.expects, round(f.value, 9), f.says, many(f.moved)) for f in asm.planted
    )
    chord = asm.cut.chord * MM
    return Truth(seed, chord, tuple(bodies), fits, plain_steps, fasteners, keepers, stays, joints, faults)


def _fastener(asm: Assembly, f: assembly.Fastener, room: Room) -> Fastener:
    """A fastener with its tool."""
    path, size = f"{ROOT}/{f.path}", _metre(f.size)
    boxes: tuple[tuple[Vector, Vector], ...] = ()
    seat: Vector = (0.0, 0.0, 0.0)
    if f.tool == "open-end wrench":
        pose = asm.parts[f.path].pose[:3, :3]
        seat = _plain(times(pose, [np.cos(SEAT_RAD), np.sin(SEAT_RAD), 0.0]))
        boxes = tuple((_plain(low), _plain(high)) for low, high in wrench(size))
        length, width = LENGTH * size, WIDTH * size
        z = f.frame[:3, 2]
        frame = np.column_stack([seat, np.cross(z, seat), z])
        swing = room.swing(path, frame, f.frame[:3, 3] * MM, boxes)
    else:
        radius, reach = tool_room(f.tool, f.size)
        length, width, swing = _metre(reach), _metre(2.0 * radius), 0.0 if f.is_stopped else FULL
    top, axis = _metres(f.frame[:3, 3]), _plain(f.frame[:3, 2])
    holds = tuple(f"{ROOT}/{held}" for held in f.holds)
    return Fastener(path, f.kind, f.tool, size, top, axis, swing, length, width, boxes, seat, holds)


class Room:
    """The parts around a wrench."""

    def __init__(self, meshes: dict[str, Mesh], steps: tuple[Step, ...], joints: tuple[Joint, ...]) -> None:
        self.meshes, self.steps = meshes, steps
        pick = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=bool)
        ends = {path: (mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for path, mesh in meshes.items()}
        self.boxes = {path: np.where(pick, high, low) for path, (low, high) in ends.items()}
        """Corners (8, 3) by path."""
        self.door = next(joint for joint in joints if joint.name == "door")

    def swing(self, path: str, frame: Floats, top: Floats, boxes: tuple[tuple[Vector, Vector], ...]) -> float:
        """The largest swing on a fastener when its step begins. `frame`: the axes of the wrench on a seat, columns."""
        step = next(step for step in self.steps if path in step.parts)
        out = {each for earlier in steps_before(self.steps, step) if earlier.removes for each in earlier.parts}
        low, high = np.array(boxes).min(axis=0)[0], np.array(boxes).max(axis=0)[1]
        reach = float(np.hypot(high[0], high[1]))
        corners = []
        for other, mesh in self.meshes.items():
            if other in out or other == path:
                continue
            is_turned = step.door_open and other in self.door.parts
            box = turned_about(self.door, self.boxes[other]) if is_turned else self.boxes[other]
            local = times(box - top, frame)
            least, most = local.min(axis=0), local.max(axis=0)
            gap = np.maximum(np.maximum(least, -most), 0.0)[:2]
            if least[2] < high[2] and most[2] > low[2] and np.hypot(gap[0], gap[1]) < reach:
                points = turned_about(self.door, mesh.vertices) if is_turned else mesh.vertices
                corners.append(times(points - top, frame)[mesh.faces])
        swing = widest_swing(np.concatenate(corners), boxes) if corners else FULL
        return swing if swing == FULL else round(int(swing / SWING_RAD) * SWING_RAD, 6)


def turned_about(joint: Joint, points: Floats) -> Floats:
    """Points (n, 3) with a joint at its `high`, metres."""
    axis, point, angle = np.array(joint.axis), np.array(joint.point_m), joint.high or 0.0
    off = points - point
    along = np.outer(times(off, axis), axis)
    return np.asarray(point + along + (off - along) * np.cos(angle) + np.cross(axis, off) * np.sin(angle))


def ordered(asm: Assembly) -> list[tuple[assembly.Step, list[str]]]:
    """The steps in a valid order, with their prerequisites as paths.

    The door comes off when nothing else is left that can: steps that want it open find it on its hinges.
    """
    needs = [asm.matching(step.after) if step.after else [] for step in asm.steps]
    steps_of: dict[str, set[int]] = {path: set() for path in asm.parts}
    for k, step in enumerate(asm.steps):
        for path in step.parts:
            steps_of[path].add(k)
    before: list[set[int]] = []
    for k, step in enumerate(asm.steps):
        wanted = {j for path in needs[k] for j in steps_of[path]}
        if step.removes:  # parts are loosened before they are taken out
            loosening = {path: {j for j in steps_of[path] if not asm.steps[j].removes} for path in step.parts}
            wanted |= set().union(*loosening.values())
            needs[k] = list(dict.fromkeys([*needs[k], *(path for path in step.parts if loosening[path])]))
        before.append(wanted - {k})
    out: list[int] = []
    left = list(range(len(asm.steps)))
    door = {k for k, step in enumerate(asm.steps) if step.removes and step.parts[0].startswith("door/")}
    is_door_begun = False
    while left:
        ready = [k for k in left if not before[k] & set(left)]
        if not ready:
            raise ValueError(f"steps wait for each other: {[asm.steps[k].parts[0] for k in left]}")
        ready = [k for k in ready if (k in door) == is_door_begun] or ready
        is_door_begun = is_door_begun or ready[0] in door
        out += ready
        left = [k for k in left if k not in set(ready)]
    return [(asm.steps[k], needs[k]) for k in out]


def _metre(millimetres: float) -> float:
    """To a picometre, so that 13 mm is 0.013 m."""
    return round(millimetres * MM, 12)


def _metres(point: Sequence[float] | Floats) -> tuple[float, float, float]:
    return _plain(np.asarray(point, dtype=np.float64) * MM)


def _plain(vector: Sequence[float] | Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(v), 9) + 0.0 for v in vector)
    return (x, y, z)
