"""The known facts of the gearbox: fits, fastened parts, removal paths, tools, joints, masses.

SI units. Points and axes are in the mock-up's coordinates: z along the shafts, y up. Parts are named by their paths.
"""

from __future__ import annotations

import difflib
import json
from dataclasses import asdict, dataclass

from feeler.field_docs import documented
from feeler.short_reprs import shortly

from ...errors import OptionError

Vector = tuple[float, float, float]
SWING_RAD = 0.001
"""The tolerance of the swings of open-end wrenches: 0.06 degrees."""
STOP_RAD = 0.035
"""How far a joint's stop may be beyond its limit, at most: two degrees. With a larger value, limits say less about
stops."""


@documented
@dataclass(frozen=True)
class Fit:
    """Two parts that touch or fit into each other. Pairs without a fit neither touch nor cross.

    A pair has one entry, at any number of triangles the same but for its depth: that of the cylinder, thread, spline or
    teeth, if it has such a fit; otherwise "line to line".
    """

    a: str
    b: str
    """Paths of the two, `a` before `b` in the alphabet."""
    kind: str
    """"H7/g6" and the like, "line to line", "thread as cylinders", "thread as helices", "ball in raceway", ..."""
    play_m: float
    """The smallest gap between the two curved surfaces, normal to them, without facets; negative for a press.

    Of gears, splines and helices: normal to the flanks, on each side of a tooth, with the tooth in the middle."""
    deepest_m: float
    """How deep the modelled parts may overlap, metres: the press, the facets of curved faces, and the rounding of
    coordinates, less than a micrometre."""
    flush: bool
    """They touch, plane on plane, whatever the play of the fit: a gear on its seat also leans on the shoulder."""


@documented
@dataclass(frozen=True)
class Leg:
    """One motion of a removal path."""

    kind: str
    """"pull", "turn" or "screw" (both at once, in proportion)."""
    axis: Vector
    """A unit vector: the direction of motion, and the axis of rotation."""
    point_m: Vector
    """On the axis of a turn or screw; zero for a pull."""
    distance_m: float
    """Along the axis; 0 for a turn."""
    angle_rad: float
    """Counter-clockwise seen against the axis, so that a right-handed thread has a positive one; 0 for a pull."""


@documented
@dataclass(frozen=True)
class Step:
    """Parts that come out together, and how."""

    parts: tuple[str, ...]
    """Paths; the first one gives the unit its name."""
    legs: tuple[Leg, ...]
    """In order, from the place of the parts in the mock-up, or where an earlier step left them. Those of a ring that is
    not `rigid` are of the spread ring: it leaves its groove before the first leg, and does not close again."""
    after: tuple[str, ...]
    """Paths of parts to remove or loosen before; of the step's own ones those to loosen."""
    door_open: bool
    """Whether the joint "door" must be at its `high`."""
    rigid: bool
    """False: the part, a circlip, is spread by `spread_m` during all legs. As modelled, it does not come out."""
    removes: bool
    """False: the parts are only loosened; a later step takes them out."""
    blocked_by: tuple[str, ...] = ()
    """Names of the planted faults that block this step or one that it needs. Empty: the path of the legs is free.

    Otherwise the legs are the path without these faults, and the parts do not come out in this order; they may in one
    in which what a fault added is out before."""
    spread_m: float = 0.0
    """How far each point of a circlip is moved away from the ring's axis: enough to pass over its shaft. 0 for rigid
    parts."""
    spread_about_m: Vector = (0.0, 0.0, 0.0)
    """A point on that axis, which has the direction of the first leg; zero for rigid parts."""


@documented
@dataclass(frozen=True)
class Fastener:
    """A bolt, screw or nut with its tool."""

    path: str
    """The part that the tool turns."""
    kind: str
    """"bolt", "screw" (a socket in its head) or "nut"."""
    tool: str
    """"socket", "hex key" or "open-end wrench"."""
    size_m: float
    """Across the flats, metres."""
    top_m: Vector
    """The middle of the top of the head, metres."""
    axis: Vector
    """A unit vector outwards, towards the tool."""
    swing_rad: float
    """The largest free swing of the tool about the axis, with the parts of earlier steps out and the door open if the
    step needs it: a full turn for sockets and keys, or 0 if a fault is in their way.

    Of an open-end wrench: the widest arc in which it touches nothing but the fastener and that contains a seat, for the
    meshes as they are. The arc is `SWING_RAD` too small at most, and never too large; 0 without a free seat."""
    tool_length_m: float
    """Sockets and keys: from the top of the head outwards. Wrenches: from the axis to the end of the handle."""
    tool_width_m: float
    """Sockets and keys: the diameter. Wrenches: the width of the handle."""
    tool_boxes_m: tuple[tuple[Vector, Vector], ...]
    """The shape of an open-end wrench: lower and upper corners of the boxes of its jaws, its neck and its handle.
    z is `axis`, the origin `top_m`, and the handle lies along x. Empty for sockets and keys: they are cylinders."""
    seat: Vector
    """A unit vector: x of a wrench that is put on the flats. There are six seats, 60 degrees apart. Zero for sockets
    and keys, which start anywhere."""
    holds: tuple[str, ...]
    """Paths of the parts that come loose with it, from the head inwards; a sensor or plug with its own thread fastens
    itself."""


@documented
@dataclass(frozen=True)
class Keeper:
    """A part without a tool that keeps others in place: a circlip, a key, a dowel, a clip, a bayonet, a latch, ..."""

    path: str
    """Of its part."""
    kind: str
    """How it keeps them; see `KEEPS`."""
    holds: tuple[str, ...]
    """Paths of the parts that it keeps."""


KEEPS = {
    "circlip": "a ring in a groove stops them along the shaft",
    "key": "they turn with the shaft that it lies in",
    "dowel": "they do not slide on each other",
    "clip": "a loop or an eye around them",
    "clamp": "a plate on their collar",
    "bayonet": "lugs behind a rim",
    "latch": "a bar behind a rail, until it is turned",
    "hinge": "a pin through the eyes of their leaves",
    "stop": "it ends their turn or their slide",
    "groove": "they lie in its groove",
    "press": "they are pressed into it, or onto it",
    "thread": "they are screwed into it, onto it, or it into them",
    "head": "they lie under its head",
    "bearing": "they run in it, or roll on it",
    "plugged": "they are plugged onto it",
    "captive": "they are enclosed by it",
    "welded": "they are one with it",
}
"""What each `Keeper.kind` means."""


@documented
@dataclass(frozen=True)
class Stay:
    """A part without a removal path."""

    path: str
    because: str
    """Why no step removes it."""


@documented
@dataclass(frozen=True)
class Joint:
    """Parts that rotate together about an axis, with all others at rest. 0 is their pose in the mock-up."""

    name: str
    """"main_shaft", "main_shaft/rear_bearing" (its cage and balls), "filter_bowl", "door", "latch", ..."""
    kind: str
    """"revolute", or "continuous": it has no limits."""
    parts: tuple[str, ...]
    """All moving parts, paths; with a shaft also the parts pressed, keyed or splined on it."""
    axis: Vector
    """A unit vector."""
    point_m: Vector
    """On the axis, metres."""
    low: float | None
    """The least value, radians or metres."""
    high: float | None
    """Limits, radians, counter-clockwise seen against the axis; None without limits. Strictly between them the parts
    collide with no part except through named fits; at most `STOP_RAD` beyond them they hit a stop."""
    follows: str
    """The joint that drives it: a gear in mesh, a shaft for the cages of its bearings. Empty: it turns by itself."""
    ratio: float
    """Ratio of its angle to that of the driving joint; 1 without one."""
    needs: tuple[str, ...]
    """Joints that must be at their `high` first: a door opens after its latch is turned."""


@documented
@dataclass(frozen=True)
class Body:
    """A part's material."""

    path: str
    """Of its part."""
    material: str
    """Its name: "cast aluminium", "hardened steel", "polyamide", ..."""
    density_kg_per_m3: float
    """Of its material."""
    mass_kg: float
    """Of the part as modelled."""
    colour: Vector
    """sRGB, 0 to 1."""


@documented
@dataclass(frozen=True)
class Fault:
    """A planted fault, and the expected result of a check."""

    name: str
    """One of `feeler.samples.FAULTS`."""
    parts: tuple[str, ...]
    """Paths of the affected parts: one or two."""
    expects: str
    """"clash", "too near", "no tool access", "no way out", "no hole", "duplicate", "inside", "floating", "mirrored" or
    "unit"."""
    value: float
    """By design; a measured value differs by the facets of the two parts, at most `chord_m` (a pipe is a polygon, and
    so less deep in its support). In metres: how deep the two overlap ("clash" and "no hole"), the gap between them
    ("too near", "no tool access", "duplicate", "inside"), the gap to the next part ("floating"), or by how much the
    path is too narrow ("no way out"). A factor of the part's size: 25.4 ("unit") or -1 ("mirrored")."""
    says: str
    """In words."""
    moved: tuple[str, ...] = ()
    """Paths of other parts that the fault displaces; they are correct. The guard of "blocked_bolt" is held by a plug,
    which it lifts by its own thickness."""


@shortly
@documented
@dataclass(frozen=True)
class Truth:
    """The known facts of one gearbox; see `feeler.sample_truth`."""

    seed: int
    """As given to `feeler.sample`."""
    chord_m: float
    """The largest distance from an arc to its chords. Faces with double curvature, as those of balls and of the bends
    of hoses, have the errors of two arcs: they are up to twice this from the true surface."""
    bodies: tuple[Body, ...]
    """One for each part, in the order of the mock-up's parts."""
    fits: tuple[Fit, ...]
    """One for each pair that touches or fits."""
    steps: tuple[Step, ...]
    """In one valid order of disassembly."""
    fasteners: tuple[Fastener, ...]
    keepers: tuple[Keeper, ...]
    """What keeps parts in place beside fasteners. Each part but those that stay is held by a fastener or a keeper."""
    stays: tuple[Stay, ...]
    """Parts that no step removes, and why."""
    joints: tuple[Joint, ...]
    """What can be moved in its place, and how far."""
    faults: tuple[Fault, ...]
    """In the given order."""

    def fit(self, a: str, b: str) -> Fit | None:
        """The fit of two parts, or None: they neither touch nor cross. Raises OptionError for an unknown path."""
        pair = {self._known(a), self._known(b)}
        return next((fit for fit in self.fits if {fit.a, fit.b} == pair), None)

    def holds(self, path: str) -> tuple[str, ...]:
        """The parts that hold a part: fasteners first, then `keepers`. Raises OptionError for an unknown path."""
        self._known(path)
        rows = [(fastener.path, fastener.holds) for fastener in self.fasteners]
        rows += [(keeper.path, keeper.holds) for keeper in self.keepers]
        return tuple(dict.fromkeys(holder for holder, held in rows if path in held))

    def way(self, path: str) -> tuple[Step, ...]:
        """The steps, in order, that take a part out; empty for parts that stay (`stays` says why).

        In this order the part comes out if `blocked_by` of the last step is empty. Raises OptionError for an unknown
        path.
        """
        self._known(path)
        last = next((step for step in self.steps if step.removes and path in step.parts), None)
        return () if last is None else (*self.needed(last), last)

    def _known(self, path: str) -> str:
        if not isinstance(path, str):
            raise OptionError(f"path is {path!r}; give the path of a part as text, such as {self.bodies[0].path!r}")
        paths = [body.path for body in self.bodies]
        if path not in paths:
            alike = difflib.get_close_matches(path, paths, 3, 0.6)
            hint = f"; there is {', '.join(map(repr, alike))}" if alike else ""
            raise OptionError(f"no part of the gearbox has the path {path!r}{hint}")
        return path

    def needed(self, step: Step) -> tuple[Step, ...]:
        """The steps, in order, that a step requires. Raises OptionError for a step of another truth."""
        if not isinstance(step, Step):
            raise OptionError(f"step is {step!r}; give one of the truth's `steps`, as `way(path)` does too")
        if step not in self.steps:
            raise OptionError(
                f"the step of {', '.join(map(repr, step.parts[:1]))} is none of this truth; "
                "give one of its own `steps`: other seeds, triangles and faults have others"
            )
        return steps_before(self.steps, step)

    def to_json(self) -> str:
        """All of it as JSON."""
        return json.dumps(asdict(self), indent=1)


def steps_before(steps: tuple[Step, ...], step: Step) -> tuple[Step, ...]:
    """The steps, in order, that a step requires; all of them if it is not in the list."""
    wanted = set(step.after)
    loose = set(step.parts) if step.removes else set()
    chosen = []
    for earlier in reversed(steps[: steps.index(step)] if step in steps else steps):
        if wanted & set(earlier.parts) or (loose & set(earlier.parts) and not earlier.removes):
            chosen.append(earlier)
            wanted |= set(earlier.after)
            loose |= set(earlier.parts) if earlier.removes else set()
    return tuple(reversed(chosen))
