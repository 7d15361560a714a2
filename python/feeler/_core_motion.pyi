"""Motions of `feeler._core`, and what is found along them. Not a module: the stub of `feeler._core` imports it."""

from collections.abc import Iterator, Sequence
from typing import final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

@final
class Screw:
    """A rotation about an axis in the world with an advance along it: a door's swing, a bolt's thread, a bayonet.

    `axis`: a direction, no number beyond 1e100; `point`: on the axis, metres; `angle`: radians, right-handed about
    the axis, at most a thousand turns either way; `pitch`: metres along the axis for a whole turn, 0 for a hinge,
    negative for a left-handed thread. Raises `OptionError` for an axis of zero and for numbers that are not finite or
    too large.
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
        """The reverse motion."""
    def at(self, pose: npt.ArrayLike, fraction: float = 1.0) -> npt.NDArray[np.float64]:
        """`(4, 4)`: a pose moved by a fraction of the screw, 0 to 1. Raises `PoseError`, `OptionError`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Slide:
    """A straight motion: a drawer, a piston.

    `way`: metres, world. Raises `OptionError` for numbers that are not finite or too large.
    """

    def __new__(cls, way: npt.ArrayLike) -> Slide: ...
    @property
    def way(self) -> tuple[float, float, float]:
        """Metres, world."""
    def reversed(self) -> Slide:
        """The reverse motion."""
    def at(self, pose: npt.ArrayLike, fraction: float = 1.0) -> npt.NDArray[np.float64]:
        """`(4, 4)`: a pose moved by a fraction of the slide, 0 to 1. Raises `PoseError`, `OptionError`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Chain:
    """Several joints that move at once, each at a constant rate: an arm, a lever on a slide.

    `joints`: `Screw`s and `Slide`s, the one that carries all the others first; axes and directions are those in the
    world at the start. Raises `OptionError` for anything else.
    """

    def __new__(cls, joints: Sequence[Screw | Slide]) -> Chain: ...
    @property
    def joints(self) -> tuple[Screw | Slide, ...]:
        """Its `Screw`s and `Slide`s."""
    def at(self, pose: npt.ArrayLike, fraction: float = 1.0) -> npt.NDArray[np.float64]:
        """`(4, 4)`: a pose moved by a fraction of the chain, 0 to 1. Raises `PoseError`, `OptionError`."""
    def reversed(self) -> Chain:
        """The reverse motion: its axes are where they are at the end."""
    def relative_to(self, other: Chain) -> Chain:
        """The motion as seen from a body that moves along another chain meanwhile: a scene of that body, where it is at
        the start, stands still. First joints that both have in common drop out.
        """
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Screw | Slide]: ...
    @overload
    def __getitem__(self, index: int, /) -> Screw | Slide: ...
    @overload
    def __getitem__(self, index: slice, /) -> tuple[Screw | Slide, ...]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Cast:
    """The first impact of a tool on a motion between two poses."""

    @property
    def fraction(self) -> float:
        """The time of impact, as a fraction of the motion, 0 to 1; never late."""
    @property
    def pose(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: world_from_tool at the impact."""
    @property
    def point(self) -> npt.NDArray[np.float64]:
        """`(3,)`: the point of impact on the mock-up, metres, world."""
    @property
    def normal(self) -> npt.NDArray[np.float64]:
        """`(3,)`: unit normal of the contact, from mock-up to tool, world."""
    @property
    def distance(self) -> float:
        """The remaining distance of the two triangles at the pose, metres: at most the tolerance; 0 if they collide."""
    @property
    def tool_triangle(self) -> int:
        """The tool's triangle."""
    @property
    def mockup_triangle(self) -> int:
        """The mock-up's triangle."""
    @property
    def part(self) -> int:
        """Index into `mockup.parts` of the part hit."""
    @property
    def tool_part(self) -> int:
        """Index into `tool.parts` of the tool's part that hits it."""

@final
class Containment:
    """Bodies inside other bodies, without colliding; true if there is any."""

    @property
    def containing(self) -> npt.NDArray[np.uint32]:
        """Indices into `mockup.parts` of closed parts that contain the tool, or one of its connected surfaces;
        sorted."""
    @property
    def contained(self) -> npt.NDArray[np.uint32]:
        """Indices into `mockup.parts` of parts with a connected surface inside the tool; sorted."""
    @property
    def containing_pairs(self) -> npt.NDArray[np.uint32]:
        """`(k, 2)`: tool part inside, and the mock-up part that contains it; sorted."""
    @property
    def contained_pairs(self) -> npt.NDArray[np.uint32]:
        """`(k, 2)`: tool part that contains, and the mock-up part inside it; sorted."""
    @property
    def unknown(self) -> npt.NDArray[np.uint32]:
        """Parts that cannot be decided, sorted: open parts with a corner of the tool in their box and, if the tool is
        open, parts with a corner in its box."""
    def __bool__(self) -> bool: ...

@final
class PathCheck:
    """The first impact of a tool on each segment of a path, from one pose to the next.

    True if the path is free. Its rows are the segments, one less than poses: `check[i]` is the `Cast` of segment `i`,
    None if it is free. A path of one pose has one segment without motion.
    """

    @property
    def is_free(self) -> bool:
        """Whether no segment has an impact, and the tool neither contains a part nor is inside one at the first
        pose."""
    @property
    def containment(self) -> Containment | None:
        """Containment at the first pose; None unless `inside` was set."""
    @property
    def fractions(self) -> npt.NDArray[np.float64]:
        """`(segments,)`: the first impact of each segment, as a fraction of the segment; NaN if the segment is free."""
    @property
    def segments(self) -> npt.NDArray[np.uint64]:
        """`(k,)`: the segments with an impact, ascending. The rows of the following arrays belong to them."""
    @property
    def poses(self) -> npt.NDArray[np.float64]:
        """`(k, 4, 4)`: world_from_tool at the impact."""
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: as `Cast.point`."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: as `Cast.normal`."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: as `Cast.tool_triangle`."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: as `Cast.mockup_triangle`."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: as `Cast.part`."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: as `Cast.tool_part`."""
    @property
    def first(self) -> Cast | None:
        """The impact of the first segment that has one: `segments[0]`."""
    def __bool__(self) -> bool: ...
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int, /) -> Cast | None: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[Cast | None]: ...
    def __iter__(self) -> Iterator[Cast | None]: ...

@final
class ClearanceAlong:
    """The least gap of a tool along a motion, between proven bounds."""

    @property
    def lower(self) -> float:
        """Metres: nowhere on the motion is the gap less."""
    @property
    def upper(self) -> float:
        """Metres: the gap at `fraction`; 0 if they collide there, infinite if no part is within `within`."""
    @property
    def fraction(self) -> float:
        """The place of `upper`, as a fraction of the motion, 0 to 1."""
    @property
    def pose(self) -> npt.NDArray[np.float64]:
        """`(4, 4)`: world_from_tool at `fraction`."""
    @property
    def part(self) -> int | None:
        """The index into `mockup.parts` of the closest part at `fraction`; None if no part is within `within`."""
    @property
    def tool_part(self) -> int | None:
        """The index into `tool.parts` of the tool's part that is closest to it."""
    @property
    def points(self) -> npt.NDArray[np.float64] | None:
        """`(2, 3)`: the closest points at `fraction`, of the tool and of the mock-up, world, metres."""
    @property
    def edges(self) -> npt.NDArray[np.float64]:
        """`(n + 1,)`: where the spans of the curve begin and end, as fractions of the motion."""
    @property
    def fractions(self) -> npt.NDArray[np.float64]:
        """`(n,)`: the middles of the spans of the curve, as fractions of the motion."""
    @property
    def lowers(self) -> npt.NDArray[np.float64]:
        """`(n,)`: metres; nowhere in the span is the gap less."""
    @property
    def uppers(self) -> npt.NDArray[np.float64]:
        """`(n,)`: metres; in the middle of the span the gap is not more."""

@final
class Impact:
    """An impact: the free fraction of the motion, point and unit normal `(3,)` (mock-up to tool), world; the part."""

    def __new__(cls, fraction: float, point: npt.ArrayLike, normal: npt.ArrayLike, part: int) -> Self: ...
    @property
    def fraction(self) -> float: ...
    @property
    def point(self) -> npt.NDArray[np.float64]: ...
    @property
    def normal(self) -> npt.NDArray[np.float64]: ...
    @property
    def part(self) -> int: ...
