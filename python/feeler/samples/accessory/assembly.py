"""The assembly under construction: parts at their poses, with their known facts."""

from __future__ import annotations

import fnmatch
import itertools
import math
import zlib
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..mesh import VERTEX_GRID_M, Floats, Mesh, at, times, turned
from .bodies import bent
from .fits import METRIC, Bearing
from .solid import Cut, Solid

Make = Callable[..., Solid]
Vector = Sequence[float] | Floats


FLUSH = "line to line"
ROUNDING_MM = 2.0 * float(np.sqrt(3.0)) / 2.0 * VERTEX_GRID_M * 1e3
"""How much deeper two parts may overlap because their corners are rounded to the vertex grid."""
WIDER_MM = 0.02
"""The most by which a hole's radius exceeds the nominal one of its fit."""
SOCKET_MM = 62.0
"""How far a socket and the head below it reach: longer, and fasteners wait for pipes that are beyond the tool."""


@dataclass(frozen=True)
class Material:
    """A material: its density in kg/m3 and the colour in which it is drawn (sRGB, 0 to 1)."""

    density: float
    colour: tuple[float, float, float]


MATERIALS = {
    "cast aluminium": Material(2700.0, (0.62, 0.65, 0.67)),
    "aluminium": Material(2700.0, (0.74, 0.76, 0.78)),
    "steel": Material(7850.0, (0.50, 0.53, 0.57)),
    "hardened steel": Material(7850.0, (0.40, 0.42, 0.46)),
    "zinc-plated steel": Material(7850.0, (0.73, 0.70, 0.55)),
    "stainless steel": Material(7900.0, (0.70, 0.72, 0.74)),
    "polyamide": Material(1140.0, (0.80, 0.74, 0.58)),
    "rubber": Material(1200.0, (0.10, 0.10, 0.11)),
    "gasket": Material(1600.0, (0.35, 0.47, 0.40)),
    "copper": Material(8900.0, (0.75, 0.47, 0.32)),
    "painted aluminium": Material(2700.0, (0.20, 0.32, 0.48)),
    "black aluminium": Material(2700.0, (0.15, 0.16, 0.18)),
    "anodised aluminium": Material(2700.0, (0.30, 0.44, 0.34)),
    "painted steel": Material(7850.0, (0.30, 0.44, 0.34)),
    "glass-filled polyamide": Material(1360.0, (0.15, 0.16, 0.18)),
    "filter paper": Material(600.0, (0.86, 0.45, 0.12)),
}


@dataclass(eq=False)
class Part:
    """A part under construction. `pose` (4, 4), millimetres."""

    path: str
    make: Make
    args: tuple[Hashable, ...]
    pose: Floats
    material: str
    scale: float = 1.0
    """Of its own frame: other than 1 in a part of a wrong unit."""

    @property
    def shape(self) -> Hashable:
        """Data that parts of the same shape share."""
        return (self.make, self.args)


@dataclass
class Fit:
    """Two parts that touch or fit into each other, millimetres; see `feeler.samples.accessory.truth.Fit`."""

    a: str
    b: str
    kind: str
    play: float
    deepest: float
    flush: bool


@dataclass
class Leg:
    """One straight, turning or screwing motion, millimetres and radians; see `feeler.samples.accessory.truth.Leg`."""

    kind: str
    axis: tuple[float, float, float]
    distance: float = 0.0
    angle: float = 0.0
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass
class Step:
    """Parts that come out together, along legs, after the parts named by patterns."""

    parts: list[str]
    legs: list[Leg]
    after: list[str]
    door_open: bool
    rigid: bool
    removes: bool
    blocked_by: list[str] = field(default_factory=list)
    """Names of the faults that block it directly."""
    spread: float = 0.0
    """How far a circlip is opened, millimetres."""


@dataclass(eq=False)
class Fastener:
    """A bolt, screw, stud or nut with its tool, millimetres; `frame` (4, 4) on top of the head, z outwards."""

    path: str
    kind: str
    tool: str
    size: float
    frame: Floats
    holds: list[str]
    is_stopped: bool = False
    """A fault is in the way of a socket or key."""


@dataclass
class Joint:
    """A joint, millimetres and radians; see `feeler.samples.accessory.truth.Joint`."""

    name: str
    parts: list[str]
    axis: tuple[float, float, float]
    point: tuple[float, float, float]
    limits: tuple[float, float] | None = None
    follows: str = ""
    ratio: float = 1.0
    needs: list[str] = field(default_factory=list)


@dataclass
class Planted:
    """A fault; see `feeler.samples.accessory.truth.Fault`."""

    name: str
    parts: list[str]
    expects: str
    value: float
    says: str
    moved: Sequence[str] = ()


@dataclass
class Assembly:
    """Parts by path, their fits by pair, the disassembly steps, fasteners and joints."""

    cut: Cut
    seed: int
    parts: dict[str, Part] = field(default_factory=dict)
    fits: dict[tuple[str, str], Fit] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    fasteners: list[Fastener] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    keepers: list[tuple[str, str, list[str]]] = field(default_factory=list)
    """Parts that keep others without a tool: path, kind, the others."""
    stays: dict[str, str] = field(default_factory=dict)
    """Why parts without a step stay."""
    planted: list[Planted] = field(default_factory=list)
    lines: list[tuple[str, Floats, float, float]] = field(default_factory=list)
    """Pipes and cables: path, corners (k, 3) of the middle line, radius, radius of the bends."""
    _solids: dict[Hashable, Solid] = field(default_factory=dict)
    _meshes: dict[Hashable, Mesh] = field(default_factory=dict)

    def rng(self, name: str) -> np.random.Generator:
        """A generator of its own for each name."""
        words = [self.seed & 0xFFFFFFFF, self.seed >> 32, zlib.crc32(name.encode())]
        return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))

    def add(
        self,
        path: str,
        material: str,
        make: Make,
        *args: Hashable,
        pose: Floats | None = None,
        spin: bool = False,
    ) -> str:
        """A part `make(cut, *args)` at a pose; `spin` turns it about its own z axis by an angle of its own."""
        if path in self.parts:
            raise ValueError(f"{path} is there already")
        place = np.eye(4) if pose is None else pose
        if spin:
            share = (zlib.crc32(path.encode()) ^ self.seed) % 9973 / 9973.0
            place = times(place, turned("z", 2.0 * np.pi * share))
        self.parts[path] = Part(path, make, args, place, material)
        return path

    # --- the truth about them ---------------------------------------------------------------------------------------

    def fit(self, a: str, b: str, kind: str, play: float, radius: float = 0.0, chords: float = 0.0) -> None:
        """Names a fit. `radius`: of the hole, whose chords take from the play; `chords`: what else they take.

        A pair has one entry: a second fit makes its play and depth those of both, and must be of the same kind.
        """
        play += self.cut.ease if radius else 0.0
        sag = self.cut.sag(radius) * (1.0 + WIDER_MM / radius) if radius else 0.0
        deepest = max(0.0, sag + chords + ROUNDING_MM - play)
        pair = (a, b) if a < b else (b, a)
        known = self.fits.get(pair)
        if known is None or known.kind == FLUSH:
            self.fits[pair] = Fit(*pair, kind, play, deepest, known is not None)
        elif known.kind == kind:
            known.play, known.deepest = min(known.play, play), max(known.deepest, deepest)
        else:
            raise ValueError(f"{a} and {b} have the fit {known.kind} already; {kind} is another")

    def flush(self, *stack: str) -> None:
        """Each part of a stack lies on the next one, plane on plane; a fit that the two have besides keeps its name."""
        for a, b in itertools.pairwise(stack):
            pair = (a, b) if a < b else (b, a)
            self.fits.setdefault(pair, Fit(*pair, FLUSH, 0.0, 0.0, True)).flush = True

    def step(
        self,
        parts: str | Sequence[str],
        *legs: Leg,
        after: Iterable[str] = (),
        door_open: bool = False,
        removes: bool = True,
        spread: float = 0.0,
    ) -> None:
        """Names a step of taking apart: the parts that come out, how, and after which others (paths or patterns).

        `removes=False`: they are only loosened. `spread`: how far a circlip is opened.
        """
        moved = [parts] if isinstance(parts, str) else list(parts)
        self.steps.append(Step(moved, list(legs), list(after), door_open, spread == 0.0, removes, spread=spread))

    def keep(self, keeper: str, kind: str, *parts: str) -> None:
        """Names parts that a part keeps in place; see `feeler.samples.accessory.truth.KEEPS`."""
        self.keepers.append((keeper, kind, list(parts)))

    def weld(self, path: str, holder: str) -> None:
        """A part comes out with another one."""
        self.keep(holder, "welded", path)
        for step in self.steps:
            if holder in step.parts:
                step.parts.append(path)

    def wait(self, path: str, *after: str) -> None:
        """A part comes out only after others."""
        for step in self.steps:
            if path in step.parts and step.removes:
                step.after += after

    def joint(
        self,
        name: str,
        parts: Sequence[str],
        axis: Vector,
        point: Vector,
        limits: tuple[float, float] | None = None,
        *,
        follows: str = "",
        ratio: float = 1.0,
        needs: Sequence[str] = (),
    ) -> None:
        """Names a joint: parts that turn together; no limits where they turn on and on."""
        x, y, z = (float(v) for v in point)
        turn = limits and (float(limits[0]), float(limits[1]))
        self.joints.append(Joint(name, list(parts), _unit(axis), (x, y, z), turn, follows, float(ratio), list(needs)))

    def bear(self, name: str, parts: Sequence[str], axis: Vector, point: Vector, bearings: dict[str, Bearing]) -> None:
        """Names the joint of a shaft, with the inner rings of its bearings (by group), and those of their cages."""
        self.joint(name, [*parts, *(f"{group}/inner_ring" for group in bearings)], axis, point)
        for group, b in bearings.items():
            rolling = [f"{group}/cage", *(f"{group}/ball_{k + 1}" for k in range(b.balls))]
            cage = f"{name}/{group.rsplit('/', 1)[1]}"
            # the balls roll on both rings, and the outer one stands
            self.joint(cage, rolling, axis, point, follows=name, ratio=0.5 - b.ball / (4.0 * b.pitch))

    def drive(self, driver: str, driven: str, ratio: float) -> None:
        """A joint turns another one."""
        for joint in self.joints:
            if joint.name == driven:
                joint.follows, joint.ratio = driver, ratio

    def block(self, fault: str, path: str) -> None:
        """A fault is in the way of the step that takes a part out."""
        for step in self.steps:
            if path in step.parts and step.removes:
                step.blocked_by.append(fault)

    def wait_for_lines(self) -> None:
        """Fasteners and round covers whose way crosses a pipe or cable come out after it."""
        paths = [
            (line, _dense(bent(Cut(0.1), corners, bend, radius).points), radius)
            for line, corners, radius, bend in self.lines
        ]
        for step in self.steps:
            part = self.parts[step.parts[0]]
            size = _room(part)
            if len(step.parts) > 1 or not step.legs or step.legs[-1].kind != "pull" or size is None:
                continue
            head, tool, height = size
            leg, start = step.legs[-1], part.pose[:3, 3]
            drawn = sum(times(each.axis, leg.axis) * each.distance for each in step.legs)
            for path, points, radius in paths:
                off = points - start
                along = times(off, leg.axis)
                beside = np.sqrt(((off - along[:, None] * leg.axis) ** 2).sum(axis=1))
                room = np.where(along < SOCKET_MM, tool, head)
                is_level = (along > -radius) & (along < drawn + height + radius)
                if path not in step.after and (is_level & (beside < radius + room)).any():
                    step.after.append(path)

    def fasten(
        self,
        path: str,
        kind: str,
        tool: str,
        size: float,
        frame: Floats,
        holds: Sequence[str],
    ) -> None:
        """Names a fastener."""
        self.fasteners.append(Fastener(path, kind, tool, size, frame, list(holds)))

    def lift(self, path: str, height: float) -> None:
        """Moves a part, and where its tool goes, along its z axis; its steps keep their axes."""
        self.parts[path].pose = times(self.parts[path].pose, at(z=height))
        for fastener in self.fasteners:
            if fastener.path == path:
                fastener.frame = times(fastener.frame, at(z=height))

    def stop_tool(self, path: str) -> None:
        """A fault is in the way of a socket or key on a fastener."""
        for fastener in self.fasteners:
            if fastener.path == path:
                fastener.is_stopped = True

    # --- the results ------------------------------------------------------------------------------------------------

    def solid(self, part: Part) -> Solid:
        """The solid of a part in its own frame; parts of one shape share it."""
        if part.shape not in self._solids:
            self._solids[part.shape] = part.make(self.cut, *part.args)
        return self._solids[part.shape]

    def mesh(self, part: Part) -> Mesh:
        """The mesh of a part in its own frame, millimetres."""
        if part.shape not in self._meshes:
            self._meshes[part.shape] = self.solid(part).mesh()
        return self._meshes[part.shape]

    def forget(self) -> None:
        """Frees solids and meshes; they are made again on demand."""
        self._solids.clear()
        self._meshes.clear()

    @property
    def triangle_count(self) -> int:
        """Triangles of all parts."""
        return sum(self.solid(part).triangle_count for part in self.parts.values())

    def matching(self, patterns: Iterable[str]) -> list[str]:
        """Paths that are named or match a pattern, in the order of the parts."""
        wanted = list(patterns)
        exact = {w for w in wanted if w in self.parts}
        loose = [w for w in wanted if w not in exact]
        for pattern in loose:
            if not any(fnmatch.fnmatchcase(path, pattern) for path in self.parts):
                raise ValueError(f"no part is called {pattern}")
        return [p for p in self.parts if p in exact or any(fnmatch.fnmatchcase(p, w) for w in loose)]


def _dense(points: Floats) -> Floats:
    """A chain of points (n, 3) with more between them: no two are farther apart than 1 mm."""
    steps = np.ceil(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1))).astype(int).clip(1)
    shares = [
        a + np.linspace(0.0, 1.0, n, endpoint=False)[:, None] * (b - a)
        for a, b, n in zip(points, points[1:], steps, strict=False)
    ]
    return np.concatenate([*shares, points[-1:]])


def _room(part: Part) -> tuple[float, float, float] | None:
    """Radius of a fastener or round cover, of its tool, and its height, millimetres; None for other parts."""
    name, size = part.make.__name__, part.args[0] if part.args else None
    if name == "flanged" and isinstance(size, tuple) and len(size) == 1:
        return size[0], size[0], 0.0
    if name not in ("hex_bolt", "cap_screw", "nut", "washer", "stud") or not isinstance(size, int):
        return None
    m = METRIC[size]
    slim = {"cap_screw": m.cap / 2.0, "washer": m.washer / 2.0, "stud": m.size / 2.0}
    head = slim.get(name, m.flats / float(np.sqrt(3.0)))
    return head, slim.get(name, 0.64 * m.flats + 0.7), 0.0 if name in ("washer", "stud") else m.head


def tool_room(tool: str, size: float) -> tuple[float, float]:
    """Radius of a socket or key, and how far it reaches from the top of the head, millimetres.

    It stands 0.2 mm above the head.
    """
    return (0.6 * size, 40.2) if tool == "hex key" else (0.64 * size + 0.7, 55.2)


def pull(axis: Vector, distance: float) -> Leg:
    """A straight motion."""
    return Leg("pull", _unit(axis), distance)


def turn(axis: Vector, point: Vector, angle: float) -> Leg:
    """A rotation about an axis."""
    return Leg("turn", _unit(axis), 0.0, float(angle), (float(point[0]), float(point[1]), float(point[2])))


def screw(axis: Vector, point: Vector, distance: float, pitch: float) -> Leg:
    """A right-handed thread: out by `distance` along `axis`, which points out of the hole."""
    angle = float(2.0 * np.pi * distance / pitch)
    return Leg("screw", _unit(axis), distance, angle, (float(point[0]), float(point[1]), float(point[2])))


def _unit(axis: Vector) -> tuple[float, float, float]:
    x, y, z = map(float, axis)
    length = math.sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length)
