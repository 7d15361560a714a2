"""Results and values of `feeler._core`. No module of its own: the stub of `feeler._core` takes them in."""

from typing import final

import numpy as np
import numpy.typing as npt

@final
class Collision:
    """The pairs of triangles that meet at one pose; false when there are none."""

    @property
    def pairs(self) -> npt.NDArray[np.uint32]:
        """`(k, 2)`: tool triangle and mock-up triangle; unique, sorted by row, read-only."""
    @property
    def kinds(self) -> npt.NDArray[np.str_]:
        """`(k,)`: a `feeler.PairKind` for each pair, as words; read-only, made anew at each call."""
    @property
    def kind_codes(self) -> npt.NDArray[np.uint8]:
        """`(k,)`: the `PairKind.code` of each pair, one byte each; read-only."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """Triangles of the tool that meet something; unique, sorted."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """Triangles of the mock-up that meet something; unique, sorted."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """Indices into `mockup.parts` of the parts that are met; unique, sorted."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """Indices into `tool.parts` of the tool's parts that meet something; unique, sorted."""
    @property
    def stats(self) -> dict[str, int]:
        """What the query did, stage by stage.

        - `voxels_visited`: voxels looked up; with blocks, nodes whose 32 children were tested against a box.
        - `entries_scanned`: pairs of tool triangle and list entry; with blocks, pairs of pieces whose boxes meet.
        - `repeats_skipped`: pairs skipped because they had been seen.
        - `box_survivors`: pairs whose triangles' boxes meet.
        - `triangle_tests`: triangle tests.
        - `exact_tests`: triangle tests that float64 arithmetic could not decide, so that exact arithmetic did.
        - `pairs`: distinct pairs that meet.
        """
    def __len__(self) -> int: ...
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
        """`(K,)`: a `feeler.PairKind` for each pair, as words; read-only, made anew at each call."""
    @property
    def kind_codes(self) -> npt.NDArray[np.uint8]:
        """`(K,)`: the `PairKind.code` of each pair, one byte each; read-only."""
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> npt.NDArray[np.uint32]: ...

@final
class Distance:
    """The distance of tool and mock-up, or of the tool and one part; 0 when they meet.

    When nothing lies within `within`, `value` is infinite and all else is None.
    """

    @property
    def value(self) -> float:
        """Metres; 0 if and only if triangles meet, infinite when nothing lies within `within`."""
    @property
    def point_on_tool(self) -> npt.NDArray[np.float64] | None:
        """`(3,)`: the point of the tool that is closest, world, metres."""
    @property
    def point_on_mockup(self) -> npt.NDArray[np.float64] | None:
        """`(3,)`: the point of the mock-up that is closest, world, metres; where they meet, the same point."""
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

    Where nothing lies within `within`, the value is infinite, points are NaN and ids -1.
    """

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """`(n,)`: metres; 0 where they meet."""
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
    def __getitem__(self, index: int, /) -> Distance: ...

@final
class Clearance:
    """What is near at one pose: a row for each part, or for each pair of triangles; by distance, then by triangles."""

    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `tool.parts`."""
    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """`(k,)`: metres, ascending; 0 where they meet."""
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

@final
class ClearanceBatch:
    """What is near at many poses; `batch[i]` is the `Clearance` of pose `i`, its rows `offsets[i]:offsets[i + 1]`."""

    @property
    def offsets(self) -> npt.NDArray[np.uint64]:
        """`(n + 1,)`: where the rows of each pose begin."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(K,)`: as of `Clearance`, and so are the others."""
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
    def __getitem__(self, index: int, /) -> Clearance: ...

@final
class Packed:
    """A mesh in pieces for drawing. Packed triangles are numbered piece by piece. Arrays are read-only."""

    @property
    def pieces(self) -> list[PackedPiece]:
        """Large parts first, small ones last."""
    @property
    def order(self) -> npt.NDArray[np.uint32]:
        """`(m,)`: the triangle of the mesh that each packed one is."""
    @property
    def places(self) -> npt.NDArray[np.uint32]:
        """`(triangles of the mesh,)`: the packed one of each; 2**32 - 1 for defects, which are not drawn."""
    @property
    def middle(self) -> npt.NDArray[np.float64]:
        """`(3,)`: what positions are relative to, in the mesh's frame, metres: the middle of its box."""

@final
class PackedPiece:
    """What is drawn at once: whole parts, or the share of a large one. Arrays are read-only."""

    @property
    def positions(self) -> npt.NDArray[np.float32]:
        """`(v, 3)`: metres, from `Packed.middle`; of one part no two are the same, but where the part is cut."""
    @property
    def parts(self) -> npt.NDArray[np.uint16] | npt.NDArray[np.uint32]:
        """`(v,)`: the part of each vertex; uint32 where the mesh has more than 65,535 parts, else uint16."""
    @property
    def indices(self) -> npt.NDArray[np.uint16]:
        """`(t, 3)`: triangles, as places among the positions, wound as given."""
    @property
    def is_small(self) -> bool:
        """Whether it has parts that were called small."""
    @property
    def first(self) -> int:
        """The number of its first triangle among the packed ones."""
    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """`(2, 3)`: lower and upper corner of the box around its triangles as given, in the mesh's frame, metres."""

@final
class Rays:
    """What each of many rays meets first."""

    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """`(n,)`: from the origin, metres; infinite where nothing is met."""
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: where, world, metres; NaN where nothing is met."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: the triangle's, unit, world, turned against the ray; as the triangle is wound where the ray lies in
        its plane; NaN where nothing is met."""
    @property
    def triangles(self) -> npt.NDArray[np.int64]:
        """`(n,)`: -1 where nothing is met."""
    @property
    def parts(self) -> npt.NDArray[np.int64]:
        """`(n,)`: indices into `mockup.parts`; -1 where nothing is met."""
    def __len__(self) -> int: ...

@final
class SectionOutline:
    """The segments of all triangles that a plane cuts, sorted by triangle. Arrays are read-only."""

    @property
    def segments(self) -> npt.NDArray[np.float64]:
        """`(k, 2, 3)`: both ends, world, metres. Seen from where the plane's normal points to, the body is on the left
        where triangles are wound outwards. Segments of triangles that share an edge share its point to the last bit."""
    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: the triangle that each is of; ascending."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    def __len__(self) -> int: ...

@final
class ClashRows:
    """Pairs of parts that are too near each other, as columns of one length, sorted by `a`, then `b`."""

    def __len__(self) -> int: ...
    @property
    def a(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: one part, the lesser."""
    @property
    def b(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the other."""
    @property
    def verdict(self) -> npt.NDArray[np.uint8]:
        """`(n,)`: a `feeler.Verdict` for each pair."""
    @property
    def depth(self) -> npt.NDArray[np.float64]:
        """`(n,)`: the farthest that a point of one surface is inside the other part, metres: a lower bound. 0 where
        they only touch or are apart; NaN where it was not measured."""
    @property
    def depth_error(self) -> npt.NDArray[np.float64]:
        """`(n,)`: how much more the depth can be, metres; NaN of two open parts, and where it was not measured."""
    @property
    def depth_kind(self) -> npt.NDArray[np.uint8]:
        """`(n,)`: 0: measured within its error; 1: an estimate, as a part is open."""
    @property
    def translation(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: moves `a` out of `b`, metres, world: the shortest way known (`b` moves the other way). Zero where
        they only touch or are apart."""
    @property
    def gap(self) -> npt.NDArray[np.float64]:
        """`(n,)`: how far their surfaces are apart, metres; 0 where they meet."""
    @property
    def point_a(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: on `a`, metres: where they are closest, touch, or are deepest in each other."""
    @property
    def point_b(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`: the same on `b`."""
    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: how many pairs of triangles meet."""
    @property
    def box(self) -> npt.NDArray[np.float64]:
        """`(n, 2, 3)`: lower and upper corner of the box around where they meet, metres; else around the points."""
    @property
    def is_open(self) -> npt.NDArray[np.bool_]:
        """`(n, 2)`: whether `a`, and `b`, has no inside: none of its surfaces is closed."""
    @property
    def counts(self) -> dict[str, int]:
        """Pairs by what was found first: `crossing`, `touching`, `contained`, `duplicates`, `near`."""
    @property
    def seconds(self) -> dict[str, float]:
        """What the stages took: `verdicts`, `clearance`, `depths`."""
    @property
    def is_partial(self) -> bool:
        """Whether it was stopped."""

@final
class RemovalAnswer:
    """What `_core.removal` found; `feeler.Removal` is made of it."""

    @property
    def method(self) -> str:
        """How the way was found; "none": it was not."""
    @property
    def leg_screws(self) -> list[Screw | None]:
        """By leg: the screw, or None of a leg to a pose."""
    @property
    def leg_ends(self) -> npt.NDArray[np.float64]:
        """`(legs, 4, 4)`: the motion of the parts at the end of each leg."""
    @property
    def leg_lengths(self) -> npt.NDArray[np.float64]:
        """`(legs,)`: how far the middle of the box goes, metres."""
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
        """Metres; NaN where time was up before it was known."""
    @property
    def casts(self) -> int:
        """Motions that were followed."""
    @property
    def is_out_of_time(self) -> bool:
        """Whether time was up before all was tried."""
    @property
    def is_interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
    @property
    def blockers(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: parts that stopped it."""
    @property
    def blocker_counts(self) -> npt.NDArray[np.uint64]:
        """`(k,)`: tries that each stopped."""
    @property
    def blocker_reaches(self) -> npt.NDArray[np.float64]:
        """`(k,)`: how far the best of them got, metres."""
    @property
    def blocker_poses(self) -> npt.NDArray[np.float64]:
        """`(k, 4, 4)`: where it was stopped."""
    @property
    def holders(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: parts that are shown to hold it; none where that is not shown."""
    @property
    def play(self) -> float:
        """No point can move farther, metres; NaN where that is not shown."""

@final
class Cast:
    """The first impact of a tool on its way between two poses."""

    @property
    def fraction(self) -> float:
        """When, as a share of the way, 0 to 1; never late."""
    @property
    def pose(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: world_from_tool then."""
    @property
    def point(self) -> npt.NDArray[np.float64]:
        """`(3,)`: where the mock-up is met, metres, world."""
    @property
    def normal(self) -> npt.NDArray[np.float64]:
        """`(3,)`: unit normal of the contact, from mock-up to tool, world."""
    @property
    def distance(self) -> float:
        """How far apart the two triangles still are at the pose, metres: at most the tolerance; 0 where they meet."""
    @property
    def tool_triangle(self) -> int:
        """The tool's triangle."""
    @property
    def mockup_triangle(self) -> int:
        """The mock-up's triangle."""
    @property
    def part(self) -> int:
        """Index into `mockup.parts` of the part that is met."""
    @property
    def tool_part(self) -> int:
        """Index into `tool.parts` of the tool's part that meets it."""

@final
class Screw:
    """A turn about an axis in the world with an advance along it: a door's swing, a bolt's thread, a bayonet.

    `axis`: a direction of any length; `point`: on the axis, metres; `angle`: radians, right-handed about the axis, at
    most a thousand turns either way; `pitch`: metres along the axis for a whole turn, 0 for a hinge, negative for a
    left-handed thread. Raises `OptionError` for an axis of zero and for numbers that are not finite or too large.
    """

    def __new__(cls, axis: npt.ArrayLike, point: npt.ArrayLike, angle: float, pitch: float | None = None) -> Screw: ...
    @property
    def axis(self) -> tuple[float, float, float]:
        """Unit, world."""
    @property
    def point(self) -> tuple[float, float, float]:
        """On the axis, metres, world."""
    @property
    def angle(self) -> float:
        """Radians."""
    @property
    def pitch(self) -> float:
        """Metres along the axis for a whole turn."""
    @property
    def advance(self) -> float:
        """Metres along the axis for the whole angle."""
    def reversed(self) -> Screw:
        """The way back."""
    def at(self, pose: npt.ArrayLike, fraction: float = 1.0) -> npt.NDArray[np.float64]:
        """`(4, 4)`: what has a pose is there after a share of the screw, 0 to 1. Raises `PoseError`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
