"""Results and values of `feeler._core`. Not a module: the stub of `feeler._core` imports them."""

from collections.abc import Callable, Iterator
from typing import final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from feeler._core_motion import Impact, Screw
from feeler.choices import ProxyMode, SeatKind
from feeler.figures import CollisionStats
from feeler.rows import RayHit

@final
class Collision:
    """The colliding pairs of triangles at one pose; false when there are none.

    `hit[i]` is pair `i`: the tool's triangle and the mock-up's.
    """

    @property
    def pairs(self) -> npt.NDArray[np.uint32]:
        """`(k, 2)`: tool triangle and mock-up triangle; unique, sorted by row, read-only."""
    @property
    def kinds(self) -> npt.NDArray[np.str_]:
        """`(k,)`: the word of a `feeler.PairKind` for each pair, `numpy.str_`; read-only, made anew at each call."""
    @property
    def kind_codes(self) -> npt.NDArray[np.uint8]:
        """`(k,)`: the `PairKind.code` of each pair, one byte each; read-only."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """Colliding triangles of the tool; unique, sorted, read-only."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """Colliding triangles of the mock-up; unique, sorted, read-only."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """Indices into `mockup.parts` of the colliding parts; unique, sorted, read-only."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """Indices into `tool.parts` of the colliding parts; unique, sorted, read-only."""
    @property
    def stats(self) -> CollisionStats:
        """Counters of the query, stage by stage."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> tuple[int, int]: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[tuple[int, int]]: ...
    def __iter__(self) -> Iterator[tuple[int, int]]: ...
    def __bool__(self) -> bool: ...

@final
class Batch:
    """The pairs of many poses; `batch[i]` are those of pose `i`, `(k, 2)`."""

    @property
    def offsets(self) -> npt.NDArray[np.uint64]:
        """`(n + 1,)`: pose `i` has the pairs `offsets[i]:offsets[i + 1]`; read-only."""
    @property
    def pairs(self) -> npt.NDArray[np.uint32]:
        """`(K, 2)`: tool triangle and mock-up triangle, sorted within each pose; read-only."""
    @property
    def kinds(self) -> npt.NDArray[np.str_]:
        """`(K,)`: the word of a `feeler.PairKind` for each pair, `numpy.str_`; read-only, made anew at each call."""
    @property
    def kind_codes(self) -> npt.NDArray[np.uint8]:
        """`(K,)`: the `PairKind.code` of each pair, one byte each; read-only."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> npt.NDArray[np.uint32]: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[npt.NDArray[np.uint32]]: ...
    def __iter__(self) -> Iterator[npt.NDArray[np.uint32]]: ...

@final
class Distance:
    """The distance of tool and mock-up, or of the tool and one part; 0 if they collide.

    If no part is within `within`, `value` is infinite and all else is None.
    """

    @property
    def value(self) -> float:
        """Metres; 0 if and only if triangles collide, infinite if no part is within `within`."""
    @property
    def point_on_tool(self) -> npt.NDArray[np.float64] | None:
        """`(3,)`: the closest point of the tool, world, metres."""
    @property
    def point_on_mockup(self) -> npt.NDArray[np.float64] | None:
        """`(3,)`: the closest point of the mock-up, world, metres; the same point if they collide."""
    @property
    def tool_triangle(self) -> int | None:
        """The tool's triangle that the point lies on."""
    @property
    def mockup_triangle(self) -> int | None:
        """The mock-up's triangle that the point lies on."""
    @property
    def part(self) -> int | None:
        """The index into `mockup.parts` of that triangle's part."""
    @property
    def tool_part(self) -> int | None:
        """The index into `tool.parts` of the tool's part that the point lies on."""

@final
class DistanceBatch:
    """The distance at many poses; `batch[i]` is the `Distance` of pose `i`.

    Where no part is within `within`, the value is infinite, points are NaN and ids -1.
    """

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """`(n,)`: metres; 0 where they collide."""
    @property
    def points_on_tool(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: world, metres."""
    @property
    def points_on_mockup(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: world, metres."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.int64]:
        """`(n,)`: the tool's triangle that the point lies on."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.int64]:
        """`(n,)`: the mock-up's triangle that the point lies on."""
    @property
    def parts(self) -> npt.NDArray[np.int64]:
        """`(n,)`: indices into `mockup.parts`."""
    @property
    def tool_parts(self) -> npt.NDArray[np.int64]:
        """`(n,)`: indices into `tool.parts`."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> Distance: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[Distance]: ...
    def __iter__(self) -> Iterator[Distance]: ...

@final
class Clearance:
    """Clearances at one pose: a row for each part, or for each pair of triangles; by distance, then by triangles.

    `near[i]` is row `i`, a `Distance`.
    """

    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `tool.parts`."""
    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """`(k,)`: metres, ascending; 0 where they collide."""
    @property
    def points_on_tool(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: the closest point of the tool, world, metres."""
    @property
    def points_on_mockup(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: the closest point of the part or triangle, world, metres."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: the tool's triangle that the point lies on."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: the mock-up's triangle that the point lies on."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> Distance: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[Distance]: ...
    def __iter__(self) -> Iterator[Distance]: ...

@final
class ClearanceBatch:
    """Clearances at many poses; `batch[i]` is the `Clearance` of pose `i`, its rows `offsets[i]:offsets[i + 1]`."""

    @property
    def offsets(self) -> npt.NDArray[np.uint64]:
        """`(n + 1,)`: where the rows of each pose begin."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(K,)`: as in `Clearance`, and so are the others."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """`(K,)`: parts of the tool."""
    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """`(K,)`: metres."""
    @property
    def points_on_tool(self) -> npt.NDArray[np.float64]:
        """`(K, 3)`: world, metres."""
    @property
    def points_on_mockup(self) -> npt.NDArray[np.float64]:
        """`(K, 3)`: world, metres."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """`(K,)`: triangles of the tool."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """`(K,)`: triangles of the mock-up."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> Clearance: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[Clearance]: ...
    def __iter__(self) -> Iterator[Clearance]: ...

@final
class Packed:
    """A mesh in pieces for drawing. Packed triangles are numbered piece by piece. Arrays are read-only."""

    @property
    def pieces(self) -> list[PackedPiece]:
        """Large parts first, small ones last."""
    @property
    def order(self) -> npt.NDArray[np.uint32]:
        """`(m,)`: the mesh's triangle of each packed triangle."""
    @property
    def places(self) -> npt.NDArray[np.uint32]:
        """`(triangles of the mesh,)`: the packed triangle of each; 2**32 - 1 for defects, which are not drawn."""
    @property
    def middle(self) -> npt.NDArray[np.float64]:
        """`(3,)`: the origin of positions, in the mesh's frame, metres: the middle of its box."""
    def _shared(
        self, number: int
    ) -> (
        tuple[
            npt.NDArray[np.uint32],
            npt.NDArray[np.float32],
            npt.NDArray[np.float32],
            npt.NDArray[np.uint16] | npt.NDArray[np.uint32],
            npt.NDArray[np.uint16],
        ]
        | None
    ): ...

@final
class PackedPiece:
    """One draw call: whole parts, or a section of a large one. Arrays are read-only."""

    @property
    def positions(self) -> npt.NDArray[np.float32]:
        """`(v, 3)`: metres, from `Packed.middle`; distinct within a part, except where the part is cut."""
    @property
    def parts(self) -> npt.NDArray[np.uint16] | npt.NDArray[np.uint32]:
        """`(v,)`: the part of each vertex; uint32 where the mesh has more than 65,535 parts, else uint16."""
    @property
    def indices(self) -> npt.NDArray[np.uint16]:
        """`(t, 3)`: triangles, as indices into `positions`, wound as given."""
    @property
    def is_small(self) -> bool:
        """Whether it has parts that were named small."""
    @property
    def first(self) -> int:
        """The number of its first triangle among the packed ones."""
    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """`(2, 3)`: lower and upper corner of the box around its triangles as given, in the mesh's frame, metres."""

@final
class Rays:
    """The first hit of each of many rays; `rays[i]` is the `RayHit` of ray `i`, None without a hit."""

    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """`(n,)`: from the origin, metres; infinite without a hit."""
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: the hit, world, metres; NaN without a hit."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: of the triangle, unit, world, turned against the ray; if the ray lies in the triangle's plane, as
        the triangle is wound; NaN without a hit."""
    @property
    def triangles(self) -> npt.NDArray[np.int64]:
        """`(n,)`: -1 without a hit."""
    @property
    def parts(self) -> npt.NDArray[np.int64]:
        """`(n,)`: indices into `mockup.parts`; -1 without a hit."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> RayHit | None: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[RayHit | None]: ...
    def __iter__(self) -> Iterator[RayHit | None]: ...

@final
class SectionOutline:
    """The segments of all triangles that a plane cuts, sorted by triangle. Arrays are read-only.

    `outline[i]` is segment `i`, `(2, 3)`.
    """

    @property
    def segments(self) -> npt.NDArray[np.float64]:
        """`(k, 2, 3)`: both ends, world, metres. Seen from the side that the plane's normal points to, the body is on
        the left if triangles are wound outwards. Segments of triangles that share an edge share its point exactly."""
    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: the triangle of each segment; ascending."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> npt.NDArray[np.float64]: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[npt.NDArray[np.float64]]: ...
    def __iter__(self) -> Iterator[npt.NDArray[np.float64]]: ...

@final
class ClashRows:
    """Pairs of parts that are closer than required, as columns of one length, sorted by `a`, then `b`."""

    def __len__(self) -> int: ...
    @property
    def a(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the part with the smaller index."""
    @property
    def b(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the other part."""
    @property
    def verdict(self) -> npt.NDArray[np.uint8]:
        """`(n,)`: a `feeler.Verdict` for each pair."""
    @property
    def depth(self) -> npt.NDArray[np.float64]:
        """`(n,)`: how far the deepest point of one surface lies inside the other part, metres: a lower bound. 0 where
        they only touch or are apart; NaN where it was not measured."""
    @property
    def depth_error(self) -> npt.NDArray[np.float64]:
        """`(n,)`: how much larger the depth can be, metres; NaN for two open parts, and where it was not measured."""
    @property
    def depth_kind(self) -> npt.NDArray[np.uint8]:
        """`(n,)`: 0: measured within its error; 1: an estimate, because a part is open."""
    @property
    def translation(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: moves `a` out of `b`, metres, world: the shortest one known (`b` moves the opposite way). Zero
        where they only touch or are apart."""
    @property
    def gap(self) -> npt.NDArray[np.float64]:
        """`(n,)`: the distance between their surfaces, metres; 0 where they collide."""
    @property
    def point_a(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: on `a`, metres: the closest, touching or deepest point."""
    @property
    def point_b(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: the same on `b`."""
    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the number of colliding pairs of triangles."""
    @property
    def box(self) -> npt.NDArray[np.float64]:
        """`(n, 2, 3)`: lower and upper corner of the box around the collision, metres; else around the points."""
    @property
    def is_open(self) -> npt.NDArray[np.bool_]:
        """`(n, 2)`: whether `a`, and `b`, has no closed surface and so no inside."""
    @property
    def counts(self) -> dict[str, int]:
        """Number of pairs by first verdict: `crossing`, `touching`, `contained`, `duplicates`, `near`."""
    @property
    def seconds(self) -> dict[str, float]:
        """Seconds by stage: `verdicts`, `clearance`, `depths`."""
    @property
    def is_partial(self) -> bool:
        """Whether it was interrupted."""

@final
class RemovalAnswer:
    """The answer of `_core.removal`, from which `feeler.Removal` is made."""

    @property
    def method(self) -> str:
        """How the way was found; "none" if none was."""
    @property
    def leg_screws(self) -> list[Screw | None]:
        """By leg: the screw, or None for a leg to a pose."""
    @property
    def leg_ends(self) -> npt.NDArray[np.float64]:
        """`(legs, 4, 4)`: the motion of the parts at the end of each leg."""
    @property
    def leg_lengths(self) -> npt.NDArray[np.float64]:
        """`(legs,)`: the travel of the middle of the box, metres."""
    @property
    def leg_angles(self) -> npt.NDArray[np.float64]:
        """`(legs,)`: radians."""
    @property
    def poses(self) -> npt.NDArray[np.float64]:
        """`(n, 4, 4)`: the same way as poses."""
    @property
    def path_length(self) -> float:
        """Metres."""
    @property
    def rotation(self) -> float:
        """Radians."""
    @property
    def clearance(self) -> float:
        """Metres; NaN if time ran out before it was measured."""
    @property
    def casts(self) -> int:
        """Number of casts."""
    @property
    def is_out_of_time(self) -> bool:
        """Whether time ran out before the search was complete."""
    @property
    def is_out_of_rounds(self) -> bool:
        """Whether it ended after the rounds that it was given."""
    @property
    def is_interrupted(self) -> bool:
        """Whether Ctrl-C interrupted it."""
    @property
    def blockers(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: parts that stopped an attempt."""
    @property
    def blocker_counts(self) -> npt.NDArray[np.uint64]:
        """`(k,)`: attempts stopped by each."""
    @property
    def blocker_reaches(self) -> npt.NDArray[np.float64]:
        """`(k,)`: the travel of the best of these attempts, metres."""
    @property
    def blocker_poses(self) -> npt.NDArray[np.float64]:
        """`(k, 4, 4)`: where that attempt was stopped."""
    @property
    def holders(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: parts proven to hold it in place; empty without a proof."""
    @property
    def play(self) -> float:
        """A proven bound on the motion of every point, metres; NaN without a proof."""

@final
class SeatAnswer:
    """A part of the tool and one of the mock-up in contact at the start."""

    @property
    def tool_part(self) -> int:
        """Index into `tool.parts`."""
    @property
    def part(self) -> int:
        """Index into `mockup.parts`."""
    @property
    def kind(self) -> SeatKind:
        """`touching`, `fit` or `sunk`."""
    @property
    def depth(self) -> float:
        """Metres."""

@final
class StartAnswer:
    """The start of a session."""

    @property
    def seats(self) -> list[SeatAnswer]:
        """The contacts at the start."""
    @property
    def way_out(self) -> npt.NDArray[np.float64] | None:
        """`(3,)`: a translation that frees the tool, metres, world; None unless it is sunk."""

@final
class StepAnswer:
    """One step of a session, with its contact planes, nearest first."""

    @property
    def world_from_proxy(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: the proxy."""
    @property
    def force(self) -> npt.NDArray[np.float64]:
        """`(3,)`: on the hand, newtons, world axes."""
    @property
    def torque(self) -> npt.NDArray[np.float64]:
        """`(3,)`: on the hand, newton metres, world axes, at the origin of the tool's frame."""
    @property
    def age(self) -> float:
        """Age of the contact planes, seconds."""
    @property
    def mode(self) -> ProxyMode:
        """`free`, `contact`, `bound` or `doubt`."""
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: on the mock-up, metres, world; nearest first."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: unit, from the mock-up to the tool."""
    @property
    def gaps(self) -> npt.NDArray[np.float64]:
        """`(k,)`: distances from the proxy, metres."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    @property
    def ids(self) -> npt.NDArray[np.uint64]:
        """`(k,)`: identify the pair of surfaces."""
    @property
    def is_holding(self) -> npt.NDArray[np.bool_]:
        """`(k,)`: whether the plane holds the proxy."""

@final
class RunEnd:
    """How a run ended: errors as texts."""

    @property
    def error(self) -> str | None:
        """The error of a thread, if one failed."""
    @property
    def device_error(self) -> str | None:
        """The last failure of the device."""
    @property
    def collision_error(self) -> str | None:
        """The last failure of the search for contacts."""

@final
class TickAnswer:
    """The newest tick of a run."""

    @property
    def number(self) -> int:
        """Number of the servo tick; 0: none yet."""
    @property
    def time(self) -> float:
        """Seconds on the machine's clock."""
    @property
    def world_from_proxy(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: the proxy."""
    @property
    def world_from_device(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: the pose of the device."""
    @property
    def force(self) -> npt.NDArray[np.float64]:
        """`(3,)`: on the hand, newtons, world axes."""
    @property
    def torque(self) -> npt.NDArray[np.float64]:
        """`(3,)`: on the hand, newton metres, world axes, at the origin of the tool's frame."""
    @property
    def age(self) -> float:
        """Age of the contact planes, seconds."""
    @property
    def mode(self) -> ProxyMode:
        """`free`, `contact`, `bound` or `doubt`."""
    @property
    def buttons(self) -> int:
        """Pressed buttons, a bit each."""
    @property
    def is_clutched(self) -> bool:
        """Whether the clutch is pressed."""
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: on the mock-up, metres, world; nearest first."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: unit, from the mock-up to the tool."""
    @property
    def gaps(self) -> npt.NDArray[np.float64]:
        """`(k,)`: distances from the proxy, metres."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""

@final
class TraceAnswer:
    """All ticks of a period."""

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """`(n,)`: seconds on the machine's clock."""
    @property
    def world_from_device(self) -> npt.NDArray[np.float64]:
        """`(n, 4, 4)`."""
    @property
    def world_from_proxy(self) -> npt.NDArray[np.float64]:
        """`(n, 4, 4)`."""
    @property
    def wrenches(self) -> npt.NDArray[np.float64]:
        """`(n, 6)`: force and torque on the hand."""
    @property
    def modes(self) -> list[ProxyMode]:
        """As in `TickAnswer`, for each tick."""
    @property
    def has_device(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether the device reported a valid pose."""

@final
class DistributionAnswer:
    """The distribution of durations, seconds."""

    @property
    def count(self) -> int:
        """Number of durations."""
    @property
    def mean(self) -> float:
        """Mean."""
    @property
    def median(self) -> float:
        """Median."""
    @property
    def p90(self) -> float:
        """90th percentile."""
    @property
    def p99(self) -> float:
        """99th percentile."""
    @property
    def p999(self) -> float:
        """99.9th percentile."""
    @property
    def max(self) -> float:
        """Longest."""

@final
class StatisticsAnswer:
    """Timings and counts of a run; `feeler.haptics.Statistics` explains them."""

    @property
    def servo_lateness(self) -> DistributionAnswer:
        """Delay of servo ticks."""
    @property
    def servo_tick(self) -> DistributionAnswer:
        """CPU time of a servo tick."""
    @property
    def age(self) -> DistributionAnswer:
        """Age of the contact planes at the servo's ticks."""
    @property
    def collision_tick(self) -> DistributionAnswer:
        """CPU time of a search for contacts."""
    @property
    def ticks(self) -> int:
        """Servo ticks."""
    @property
    def misses(self) -> int:
        """Skipped servo ticks."""
    @property
    def doubts(self) -> int:
        """Servo ticks in doubt."""
    @property
    def device_errors(self) -> int:
        """Failed reads and writes of the device."""
    @property
    def sets(self) -> int:
        """Sets of contact planes."""
    @property
    def rounds(self) -> int:
        """Motions of the proxy that were tried."""
    @property
    def stopped(self) -> int:
        """Those stopped by the cast."""
    @property
    def collision_errors(self) -> int:
        """Failed searches for contacts."""
    @property
    def servo_hz(self) -> float:
        """Ticks per second."""
    @property
    def collision_hz(self) -> float:
        """Searches per second."""

@final
class GrantedAnswer:
    """What the system and the device granted to a run; `feeler.haptics.Granted` explains it."""

    @property
    def priority(self) -> str:
        """Priority of the servo thread, or why it has none."""
    @property
    def has_priority(self) -> bool:
        """Whether it has one."""
    @property
    def collision_priority(self) -> str:
        """Priority of the collision thread, or why it has none."""
    @property
    def has_collision_priority(self) -> bool:
        """Whether it has one."""
    @property
    def memory(self) -> str:
        """The locked memory, or why none is locked."""
    @property
    def is_locked(self) -> bool:
        """Whether memory is locked."""
    @property
    def coupling(self) -> list[float]:
        """The eight numbers of the coupling in use."""
    @property
    def limitations(self) -> list[str]:
        """Reductions of the session's coupling, a sentence each."""

@final
class MoveAnswer:
    """Where a guarded move ended."""

    @property
    def pose(self) -> npt.NDArray[np.float64]:
        """`(4, 4)` world_from_tool."""
    @property
    def impact(self) -> Impact | None:
        """The impact that stopped the tool, if any."""

@final
class SavedScene:
    """An opened file. `feeler.open_scene` makes a mock-up and a scene of it."""

    def __new__(
        cls, path: str, verify: bool, memory_limit: int, progress: Callable[[float, str], object] | None
    ) -> Self: ...
    @property
    def content_hash(self) -> str:
        """The hash of the mock-up, 32 hexadecimal digits."""
    @property
    def voxel_size(self) -> float:
        """As in `Scene`."""
    @property
    def storage(self) -> str:
        """As in `Scene`."""
    @property
    def hashing(self) -> float:
        """As in `Scene`."""
    @property
    def part_count(self) -> int:
        """As in `Mockup`."""
    @property
    def absent_parts(self) -> list[int]:
        """The parts that were not there when the scene was saved, by number."""
    def extra(self, name: str) -> bytes | None:
        """A section of `Scene._save`."""
