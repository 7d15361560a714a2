"""`feeler.removal`: the path of parts out of a mock-up, or the parts that block it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler._core import Screw
from feeler.arguments import (
    UNREADABLE,
    check_length,
    check_number,
    check_progress,
    check_threads,
    check_whole,
    unmasked,
)
from feeler.errors import MeshError, OptionError, PoseError
from feeler.field_docs import documented
from feeler.mockup import Tool
from feeler.parts import Part, PartsLike
from feeler.plan.blocked import Blocker
from feeler.plan.legs import RemovalLeg, legs_of
from feeler.poses import PoseLike, nearest_rigid, one_pose
from feeler.progress import Progress
from feeler.renamed import ALLOW, OldAttributes, keywords
from feeler.scene import Scene
from feeler.words import plural

DIRECT = "direct"
"""The method of a path straight from its start to its goal."""
_VERSIONS = (("feeler", version("feeler")),)
LARGEST_SEED = 2**64 - 1
LARGEST_ROUNDS = 2**32 - 1


@documented
@dataclass(frozen=True, eq=False)
class RemovalBlocker(Blocker):
    """A part that stopped attempts, how often, and the best attempt that it stopped."""

    reach: float
    """The travel of the middle of the moving parts in the best of these attempts, metres."""
    pose: npt.NDArray[np.float64]
    """`(4, 4)`: the motion of the part at that point."""


@documented
@dataclass(frozen=True)
class Certificate:
    """The values that reproduce the answer: with these versions, the same scene and arguments."""

    seed: int
    """The seed of the search."""
    method: str
    """How the way was found: "straight", "pushes", "tree 3" (of random trees, by number), "out" (it was already out),
    "direct" (an insertion, straight from its start to its goal), "none"."""
    casts: int
    """Number of casts; the one figure here that depends on threads, some of which try ways that are not needed."""
    versions: tuple[tuple[str, str], ...]


@documented
@dataclass(frozen=True, eq=False, repr=False)
class Removal(OldAttributes):
    """A path of parts out of a mock-up, or the blocking parts; true if found.

    Only `held_by` proves that there is no path.
    """

    _RENAMED: ClassVar[Mapping[str, str]] = {"found": "is_found"}
    _GONE: ClassVar[Mapping[str, str]] = {"free": "a path that is found was verified: read is_found"}

    is_found: bool
    """Whether a way was found."""
    legs: tuple[RemovalLeg, ...]
    """The path, leg by leg, from the place of the parts until they are out; `str(leg)` describes it in words."""
    poses: npt.NDArray[np.float64]
    """`(n, 4, 4)`: the same path as poses, screws cut into pieces: the motion of the parts in the world, from the
    identity until they are out. A corner of the mock-up is at `poses[i] @ corner`. Between two poses they move as in
    `Scene.cast`. If no path was found, the identity alone."""
    path_length: float
    """The travel of the middle of the moving parts' box, metres."""
    rotation: float
    """The total rotation, radians."""
    clearance: float
    """The smallest distance along the path, metres, without pairs in contact at the start until they separate, and
    without allowed parts. Its error is at most 1/20 of its value or 1/64 of the size of the moving parts, whichever is
    more. Infinite if there is no other part, NaN if no path was found or time ran out before it was measured."""
    certificate: Certificate
    """What repeats the answer, and how the way was found."""
    blocked_by: tuple[RemovalBlocker, ...]
    """The parts that stopped an attempt, most frequent first; also if a path was found."""
    held_by: tuple[Part, ...]
    """The parts proven to hold it: no path exists while they stay. Empty without a proof, which does not mean that a
    path exists."""
    play: float
    """If it is held: no point of it can move farther than this, metres. Else NaN."""
    is_out_of_time: bool
    """Whether `seconds` ran out before the search was complete."""
    is_out_of_rounds: bool
    """Whether the search ended after the `rounds` that it was given."""
    seconds: float

    @property
    def path(self) -> list[npt.NDArray[np.float64] | Screw]:
        """The legs as `Scene.check_path` takes them: the start pose, then a pose or a screw for each leg."""
        return [self.poses[0], *(leg.pose if leg.screw is None else leg.screw for leg in self.legs)]

    def __bool__(self) -> bool:
        return self.is_found

    def __repr__(self) -> str:
        if self.is_found:
            how = f"{plural(len(self.legs), 'leg')}, {self.path_length:.4g} m, {math.degrees(self.rotation):.4g} deg"
        elif self.held_by:
            how = "held by " + ", ".join(part.path for part in self.held_by[:3])
        else:
            how = "not found, blocked by " + (", ".join(b.path for b in self.blocked_by[:3]) or "nothing")
        method = f"{self.certificate.method}, " if self.is_found else ""
        return f"Removal({how}; {method}{plural(self.certificate.casts, 'cast')}, {self.seconds:.3g} s)"


class RemovalInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.removal` has the result found by then."""

    def __init__(self, removal: Removal) -> None:
        self.removal = removal
        super().__init__(f"interrupted: {removal!r}")

    def __reduce__(self) -> tuple[type[RemovalInterrupted], tuple[Removal]]:
        return (type(self), (self.removal,))


@dataclass(frozen=True)
class Allowed:
    """The contacts that a path may have: see `removal`."""

    seats: bool
    overlap: float
    parts: tuple[int, ...]

    @classmethod
    def of(cls, scene: object, ignore: PartsLike | None, overlap: float, seats: bool) -> Allowed:
        """These options, checked."""
        if not isinstance(scene, Scene):
            raise MeshError(f"a feeler.Scene is needed, not {type(scene).__name__}")
        if not isinstance(seats, (bool, np.bool_)):
            raise OptionError(f"seats is {seats!r}: True or False is needed")
        parts = () if ignore is None else tuple(scene.mockup.parts.select(ignore).tolist())
        return cls(bool(seats), check_length("overlap", overlap), parts)

    @property
    def pairs(self) -> list[tuple[str, list[int]]] | None:
        """The pairs of a moving part and a neighbour that queries ignore."""
        return [("*", list(self.parts))] if self.parts else None


@keywords(gone={"allow": ALLOW})
def removal(
    scene: Scene,
    parts: PartsLike,
    tool: Tool | None = None,
    start: PoseLike | None = None,
    ignore: PartsLike | None = None,
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 30.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    *,
    overlap: float = 0.0,
    seats: bool = True,
    rounds: int | None = None,
) -> Removal:
    """A path by which parts come out of the mock-up of a scene.

    - `scene`: with these parts in their places. `parts`: as `Parts.select` takes them; they move as one.
    - `tool`: grips the parts and moves with them, from the pose `start` (`world_from_tool`, by default the identity).
      It must be free there.
    - `seats`: whether pairs of a moving part and a neighbour that are in contact at the start may stay so until they
      separate, no deeper than there.
    - `ignore`: neighbours with which contact is allowed throughout, as `Parts.select` takes them.
    - `overlap`: metres by which each pair may overlap.
    - `directions`: `(k, 3)`, world, tried first.
    - `clearance`: metres that the path keeps from all parts that are not seated, within 2 %.
    - `seconds`: the search ends then, or at most some tenths of a second later. A path does not depend on it, nor on
      `threads`, unless time runs out while the path is shortened.
    - `rounds`: the most rounds of the search, each of the same work (some 0.1 s on eight threads). An answer that
      `seconds` did not end is the same on every machine. Default: no limit but time.
    - `progress`: called with the elapsed share of the time (0 to 1), and the current attempt.

    Ctrl-C ends it with a `RemovalInterrupted`, which has the blockers found by then.

    Every contact that is not allowed ends a path. Pairs in contact at the start (nearer than 1e-6 m) are seats, surface
    by surface, and may slide and separate. Parts that touch or fit (up to 1/50 of the size of the moving parts deep)
    are cast at a size reduced by that depth and a play of 1e-6 or 1e-5 m. Deeper ones are sunk: at steps of half a
    thickness, their surface may be inside the other part only where the part itself was. See docs/removal.md.

    Raises `OptionError` for parts that do not exist, for all parts of the scene, and for invalid numbers; `PoseError`
    for a `start` that is not rigid or where the tool collides; `MeshError` if the scene or the tool is not one.
    """
    return way_from(
        np.eye(4),
        scene,
        parts,
        tool=tool,
        start=start,
        allowed=Allowed.of(scene, ignore, overlap, seats),
        directions=directions,
        clearance=clearance,
        seconds=seconds,
        seed=seed,
        threads=threads,
        progress=progress,
        rounds=rounds,
    )


def way_from(
    lies: npt.NDArray[np.float64],
    scene: Scene,
    parts: PartsLike,
    *,
    tool: Tool | None,
    start: PoseLike | None,
    allowed: Allowed,
    directions: npt.ArrayLike | None,
    clearance: float,
    seconds: float,
    seed: int,
    threads: int | None,
    progress: Progress | None,
    rounds: int | None = None,
    where: str = "start",
    first: Callable[[Scene, Tool], Removal | None] | None = None,
) -> Removal:
    """`removal` of parts that lie elsewhere: `lies` `(4, 4)` is their motion up to there, where the path begins.
    `where`: the name of that pose in errors. `first`: an attempt to try before, a function of the scene without the
    parts and of the moving parts."""
    begin = time.perf_counter()
    moved = chosen(scene, parts)
    rest = scene.without(moved)
    mockup = scene.mockup
    own = Tool.of_parts(mockup, moved)
    moving = own if tool is None else _gripped(own, tool, start, (lies, where), rest, allowed)
    if tool is None and start is not None:
        raise OptionError("start is the tool's pose, but there is no tool: give a tool, or leave out start")
    options: dict[str, Any] = {
        "own_parts": own.part_count,
        "allow_start": allowed.seats,
        "allow_overlap": allowed.overlap,
        "allow_parts": list(allowed.parts),
        "directions": checked_directions(directions),
        "clearance": check_length("clearance", clearance),
        "seconds": check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True),
        "seed": check_whole("seed", seed, 0, LARGEST_SEED),
        "rounds": None if rounds is None else check_whole("rounds", rounds, 0, LARGEST_ROUNDS),
        "threads": check_threads(threads),
        "progress": check_progress(progress),
    }
    if first is not None and (known := first(rest, moving)) is not None:
        return known
    answer = _core.removal(rest, moving, lies, **options)
    found = answer.method != "none"
    rows = zip(
        answer.blockers.tolist(),
        answer.blocker_counts.tolist(),
        answer.blocker_reaches.tolist(),
        answer.blocker_poses,
        strict=True,
    )
    blockers = (
        RemovalBlocker(part, mockup.part_paths[part], count, reach, np.array(pose)) for part, count, reach, pose in rows
    )
    answered = Removal(
        is_found=found,
        legs=legs_of(answer, moving.bounds.mean(axis=0), lies),
        poses=answer.poses,
        path_length=answer.path_length,
        rotation=answer.rotation,
        clearance=answer.clearance if found else math.nan,
        certificate=Certificate(int(seed), answer.method, answer.casts, _VERSIONS),
        blocked_by=tuple(blockers),
        held_by=tuple(mockup.parts[part] for part in answer.holders.tolist()),
        play=answer.play,
        is_out_of_time=answer.is_out_of_time,
        is_out_of_rounds=answer.is_out_of_rounds,
        seconds=time.perf_counter() - begin,
    )
    if answer.is_interrupted:
        raise RemovalInterrupted(answered)
    scene._saw_removal(moving, options["directions"], answered)
    return answered


def rigid_pose(pose: PoseLike, name: str) -> npt.NDArray[np.float64]:
    """A pose `(4, 4)` as given. Raises PoseError for one that is not rigid, with the name of its argument."""
    given = one_pose(pose, name)
    try:
        nearest_rigid(given)
    except PoseError as error:
        raise PoseError(f"{name}: {error}") from error
    return given


def alone(seed: int) -> Removal:
    """The answer for parts that are the whole mock-up: they are out."""
    certificate = Certificate(seed, "out", 0, _VERSIONS)
    return Removal(True, (), np.eye(4)[None], 0.0, 0.0, math.inf, certificate, (), (), math.nan, False, False, 0.0)


def not_tried(seed: int, is_out_of_time: bool = True) -> Removal:
    """The answer where nothing was tried: time was up before, or there is nothing that can be."""
    certificate = Certificate(seed, "none", 0, _VERSIONS)
    return Removal(
        False, (), np.eye(4)[None], 0.0, 0.0, math.nan, certificate, (), (), math.nan, is_out_of_time, False, 0.0
    )


def chosen(scene: object, parts: PartsLike) -> npt.NDArray[np.uint32]:
    """The moving parts, checked to be in the scene with others around them."""
    if not isinstance(scene, Scene):
        raise MeshError(f"a feeler.Scene is needed, not {type(scene).__name__}")
    moved = scene.mockup.parts.select(parts)
    if not len(moved):
        raise OptionError("parts names no part: name one at least")
    there = scene.part_mask
    away = moved[~there[moved]]
    if len(away):
        raise OptionError(f"part {scene.mockup.part_paths[away[0]]!r} is not in the scene: it is out already")
    if there.sum() == len(moved):
        raise OptionError(f"parts names all {plural(len(moved), 'part')} of the scene: leave at least one out of it")
    return moved


def _gripped(
    own: Tool,
    tool: object,
    start: PoseLike | None,
    place_of_parts: tuple[npt.NDArray[np.float64], str],
    rest: Scene,
    allowed: Allowed,
) -> Tool:
    """The parts with the tool that grips them, checked to be free."""
    if not isinstance(tool, Tool):
        raise MeshError(f"tool is a feeler.Tool that grips the parts, not {type(tool).__name__}")
    lies, where = place_of_parts
    place = np.eye(4) if start is None else rigid_pose(start, "start")
    met = {int(part) for part in rest.collide(tool, lies @ place, ignore=allowed.pairs).parts}
    if not met:
        met = set(rest.containment(tool, lies @ place).containing.tolist()) - set(allowed.parts)
    if met:
        names = ", ".join(repr(rest.mockup.part_paths[part]) for part in sorted(met)[:3])
        raise PoseError(
            f"{where}: the tool {tool.name!r} collides with {names}: put it where it is free, or ignore these parts"
        )
    return Tool.assembly({"parts": own, "tool": (tool, place)}, own.name)


def checked_directions(directions: npt.ArrayLike | None) -> npt.NDArray[np.float64]:
    """The argument `directions`, `(k, 3)`. Raises `OptionError`."""
    if directions is None:
        return np.empty((0, 3))
    unmasked("directions", directions)
    try:
        rows = np.atleast_2d(np.asarray(directions))
    except UNREADABLE as error:
        raise OptionError(f"directions cannot be read as (k, 3) numbers: {error}") from error
    if rows.dtype.kind not in "fiu":
        raise OptionError(f"directions have dtype {rows.dtype}: real numbers (k, 3) are needed")
    with np.errstate(over="ignore"):
        rows = rows.astype(np.float64)
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise OptionError(f"directions have shape {rows.shape}: (k, 3) is needed")
    if not np.isfinite(rows).all() or not rows.any(axis=1).all():
        raise OptionError("directions have a row that is zero or not finite: give three numbers that lead somewhere")
    return np.ascontiguousarray(rows)
