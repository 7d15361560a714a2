"""What is true of the gearbox: fits, what holds what, ways out, tools, joints, masses. SI units, world coordinates."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Fit:
    """Two parts that touch or fit into each other. Pairs that no fit names neither touch nor cross."""

    a: str
    b: str
    kind: str
    """"H7/g6" and the like, "line to line", "thread as cylinders", "thread as helices", "ball in raceway", ..."""
    play_m: float
    """The gap between the two surfaces when they are centred; negative for a press."""
    deepest_m: float
    """How deep the parts as drawn may be in each other: the press and the chords of curved faces."""


@dataclass(frozen=True)
class Leg:
    """One motion of a way out: "pull", "turn" or "screw" (both at once, in proportion)."""

    kind: str
    axis: Vector
    point_m: Vector
    """On the axis of a turn or screw; zero for a pull."""
    distance_m: float
    angle_rad: float
    """Counter-clockwise seen against the axis."""


@dataclass(frozen=True)
class Step:
    """Parts that come out together, and how."""

    parts: tuple[str, ...]
    legs: tuple[Leg, ...]
    """In turn, from where the parts are in the mock-up or where an earlier step left them."""
    after: tuple[str, ...]
    """Parts that have to be out, or loosened, before."""
    door_open: bool
    rigid: bool
    """False: the part has to be bent to come out (a circlip is spread); it has no legs."""
    removes: bool
    """False: the parts are only loosened; a later step takes them out."""


@dataclass(frozen=True)
class Fastener:
    """A bolt, screw or nut with its tool."""

    path: str
    kind: str
    """"bolt", "screw" (a socket in its head) or "nut"."""
    tool: str
    """"socket", "hex key" or "open-end wrench"."""
    size_m: float
    """Across the flats."""
    top_m: Vector
    """The middle of the top of the head."""
    axis: Vector
    """Outwards, from where the tool comes."""
    swing_rad: float
    """The largest swing of the tool that is free whatever the seed: a full turn for sockets and keys. A wrench is about
    nine flats long and loosens counter-clockwise; 60 degrees take it from flat to flat."""
    holds: tuple[str, ...]


@dataclass(frozen=True)
class Joint:
    """A joint: the parts that move in it, its axis and its limits (radians)."""

    name: str
    kind: str
    parts: tuple[str, ...]
    axis: Vector
    point_m: Vector
    low: float
    high: float


@dataclass(frozen=True)
class Body:
    """A part's material."""

    path: str
    material: str
    density_kg_per_m3: float
    mass_kg: float
    """Of the part as drawn."""
    colour: Vector
    """sRGB, 0 to 1."""


@dataclass(frozen=True)
class Fault:
    """A fault that was planted, and what a check must say of it."""

    name: str
    parts: tuple[str, ...]
    expects: str
    """"clash", "too near", "no tool access", "no way out", "no hole", "duplicate", "inside", "floating", "mirrored" or
    "unit"."""
    value: float
    """In metres: depth of the clash, gap, or by how much the way is too narrow; a factor for a unit; else 0."""
    says: str
    """In words."""


@dataclass(frozen=True)
class Truth:
    """The truth of one gearbox; see `feeler.sample_truth`. Parts are named by their paths."""

    seed: int
    chord_m: float
    """No curved face is farther than this from the surface that it stands for."""
    bodies: tuple[Body, ...]
    fits: tuple[Fit, ...]
    steps: tuple[Step, ...]
    """In one order of taking apart that is right."""
    fasteners: tuple[Fastener, ...]
    joints: tuple[Joint, ...]
    faults: tuple[Fault, ...]

    def fit(self, a: str, b: str) -> Fit | None:
        """The fit of two parts, or None: they neither touch nor cross."""
        pair = {a, b}
        return next((fit for fit in self.fits if {fit.a, fit.b} == pair), None)

    def holds(self, path: str) -> tuple[str, ...]:
        """The fasteners that hold a part."""
        return tuple(fastener.path for fastener in self.fasteners if path in fastener.holds)

    def way(self, path: str) -> tuple[Step, ...]:
        """The steps, in order, that take a part out; empty for the beam, which carries all."""
        last = next((step for step in self.steps if step.removes and path in step.parts), None)
        return () if last is None else (*self.needed(last), last)

    def needed(self, step: Step) -> tuple[Step, ...]:
        """The steps, in order, that have to come before a step."""
        wanted = set(step.after)
        loose = set(step.parts) if step.removes else set()
        chosen = []
        before = self.steps[: self.steps.index(step)] if step in self.steps else self.steps
        for earlier in reversed(before):
            if wanted & set(earlier.parts) or (loose & set(earlier.parts) and not earlier.removes):
                chosen.append(earlier)
                wanted |= set(earlier.after)
                loose |= set(earlier.parts) if earlier.removes else set()
        return tuple(reversed(chosen))

    def to_json(self) -> str:
        """All of it as JSON."""
        return json.dumps(asdict(self), indent=1)
