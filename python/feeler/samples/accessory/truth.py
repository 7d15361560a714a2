"""What is true of the gearbox: fits, what holds what, ways out, tools, joints, masses.

SI units. Points and axes are in the mock-up's coordinates: z along the shafts, y up. Parts are named by their paths.
"""

from __future__ import annotations

import difflib
import json
from dataclasses import asdict, dataclass

from ...errors import OptionError

Vector = tuple[float, float, float]
STOP_RAD = 0.035
"""No stop of a joint is farther beyond its limit, two degrees: larger, and limits say less of the stops."""


@dataclass(frozen=True)
class Fit:
    """Two parts that touch or fit into each other. Pairs that no fit names neither touch nor cross.

    A pair has one entry, the same at any number of triangles: that of the cylinder, thread, spline or teeth, if it has
    such a fit; otherwise "line to line".
    """

    a: str
    b: str
    """Paths of the two, `a` before `b` in the alphabet."""
    kind: str
    """"H7/g6" and the like, "line to line", "thread as cylinders", "thread as helices", "ball in raceway", ..."""
    play_m: float
    """The least gap between the two curved surfaces, normal to them, as drawn without chords; negative for a press.

    Of gears, splines and helices: normal to the flanks, on each side of a tooth, with the tooth in the middle."""
    deepest_m: float
    """How deep the parts as drawn may be in each other, metres: the press, the chords of curved faces, and the rounding
    of coordinates, less than a micrometre."""
    flush: bool
    """They touch, plane on plane, whatever the play of the fit: a gear on its seat also leans on the shoulder."""


@dataclass(frozen=True)
class Leg:
    """One motion of a way out."""

    kind: str
    """"pull", "turn" or "screw" (both at once, in proportion)."""
    axis: Vector
    """A unit vector: where the parts go, and about what they turn."""
    point_m: Vector
    """On the axis of a turn or screw; zero for a pull."""
    distance_m: float
    """Along the axis; 0 for a turn."""
    angle_rad: float
    """Counter-clockwise seen against the axis, so that a right-handed thread has a positive one; 0 for a pull."""


@dataclass(frozen=True)
class Step:
    """Parts that come out together, and how."""

    parts: tuple[str, ...]
    """Paths; the first one gives the unit its name."""
    legs: tuple[Leg, ...]
    """In turn, from where the parts are in the mock-up or where an earlier step left them."""
    after: tuple[str, ...]
    """Paths of parts that have to be out, or loosened, before, in the order of the parts."""
    door_open: bool
    """The joint "door" has to be at its `high`."""
    rigid: bool
    """False: the part has to be bent to come out (a circlip is spread); it has no legs."""
    removes: bool
    """False: the parts are only loosened; a later step takes them out."""
    blocked_by: tuple[str, ...] = ()
    """Names of the planted faults that block this step or one that it needs. Empty: the way is free as the legs say.

    Otherwise the legs are the way without these faults, and the parts do not come out."""


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
    """A unit vector outwards, from where the tool comes."""
    swing_rad: float
    """A swing of the tool that is free: a full turn for sockets and keys, 0 where a fault is in the tool's way. For an
    open-end wrench it is a lower bound of the largest swing: the least of several seeds. A wrench is about nine flats
    long and loosens counter-clockwise; 60 degrees take it from flat to flat."""
    holds: tuple[str, ...]
    """Paths of the parts that come loose with it, from the head inwards; a sensor or plug that is screwed in by its own
    thread holds itself."""


@dataclass(frozen=True)
class Joint:
    """Parts that turn together about an axis, all others at rest. 0 is where they are in the mock-up."""

    name: str
    """"main_shaft", "main_shaft/rear_bearing" (its cage and balls), "filter_bowl", "door", "latch", ..."""
    kind: str
    """"revolute", or "continuous": it has no limits."""
    parts: tuple[str, ...]
    """All that moves, paths; of a shaft also what is pressed, keyed or splined on it."""
    axis: Vector
    """A unit vector."""
    point_m: Vector
    """On the axis, metres."""
    low: float | None
    high: float | None
    """Limits, radians, counter-clockwise seen against the axis; None where there are none. Strictly between them the
    parts are free of all that no fit names; no more than `STOP_RAD` beyond them they meet a stop."""
    follows: str
    """The joint that turns it: a gear in mesh, a shaft for the cages of its bearings. Empty: it turns by itself."""
    ratio: float
    """Its angle by the angle of the joint that it follows; 1 where it follows none."""
    needs: tuple[str, ...]
    """Joints that have to be at their `high` before: a door opens when its latch is turned."""


@dataclass(frozen=True)
class Body:
    """A part's material."""

    path: str
    material: str
    """Its name: "cast aluminium", "hardened steel", "polyamide", ..."""
    density_kg_per_m3: float
    mass_kg: float
    """Of the part as drawn."""
    colour: Vector
    """sRGB, 0 to 1."""


@dataclass(frozen=True)
class Fault:
    """A fault that was planted, and what a check must say of it."""

    name: str
    """One of `feeler.samples.FAULTS`."""
    parts: tuple[str, ...]
    """Paths of the parts that are concerned: one or two."""
    expects: str
    """"clash", "too near", "no tool access", "no way out", "no hole", "duplicate", "inside", "floating", "mirrored" or
    "unit"."""
    value: float
    """By design; what a check measures differs by the chords of the two, at most `chord_m` (a pipe is a polygon, and so
    less deep in its support). In metres: how deep the two are in each other ("clash" and "no hole"), the gap between
    them ("too near", "no tool access", "duplicate", "inside"), the gap to the next part ("floating"), or by how much
    the way is too narrow ("no way out"). A factor of the part's size: 25.4 ("unit") or -1 ("mirrored")."""
    says: str
    """In words."""
    moved: tuple[str, ...] = ()
    """Paths of parts beside these that sit elsewhere with the fault; nothing is wrong with them. The guard of
    "blocked_bolt" is held by a plug, which it lifts by its own thickness."""


@dataclass(frozen=True)
class Truth:
    """The truth of one gearbox; see `feeler.sample_truth`."""

    seed: int
    """As given to `feeler.sample`."""
    chord_m: float
    """The largest distance from an arc to its chords. Faces that are curved both ways, as those of balls and of the
    bends of hoses, have the errors of two arcs: they are up to twice this from the surface that they stand for."""
    bodies: tuple[Body, ...]
    """One for each part, in the order of the mock-up's parts."""
    fits: tuple[Fit, ...]
    """One for each pair that touches or fits."""
    steps: tuple[Step, ...]
    """In one order of taking apart that is right."""
    fasteners: tuple[Fastener, ...]
    joints: tuple[Joint, ...]
    faults: tuple[Fault, ...]
    """In the order in which they were asked for."""

    def fit(self, a: str, b: str) -> Fit | None:
        """The fit of two parts, or None: they neither touch nor cross. Raises OptionError for an unknown path."""
        pair = {self._known(a), self._known(b)}
        return next((fit for fit in self.fits if {fit.a, fit.b} == pair), None)

    def holds(self, path: str) -> tuple[str, ...]:
        """The fasteners that hold a part. Raises OptionError for an unknown path."""
        self._known(path)
        return tuple(fastener.path for fastener in self.fasteners if path in fastener.holds)

    def way(self, path: str) -> tuple[Step, ...]:
        """The steps, in order, that take a part out; empty for the beam, which carries all, and for parts that a fault
        adds. The part comes out if `blocked_by` of the last step is empty. Raises OptionError for an unknown path.
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
        """The steps, in order, that have to come before a step. Raises OptionError for a step of another truth."""
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
    """The steps, in order, that have to come before a step; all may, where it is not one of them."""
    wanted = set(step.after)
    loose = set(step.parts) if step.removes else set()
    chosen = []
    for earlier in reversed(steps[: steps.index(step)] if step in steps else steps):
        if wanted & set(earlier.parts) or (loose & set(earlier.parts) and not earlier.removes):
            chosen.append(earlier)
            wanted |= set(earlier.after)
            loose |= set(earlier.parts) if earlier.removes else set()
    return tuple(reversed(chosen))
