"""The compiled core. Use `feeler.Mockup`, `feeler.Tool` and `feeler.Scene`, which check their arguments first."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import Self, disjoint_base

from feeler._core_bodies import Bodies as Bodies
from feeler._core_bodies import Shape as Shape
from feeler._core_motion import (
    Cast,
    Chain,
    ClearanceAlong,
    Containment,
    Impact,
    PathCheck,
    Screw,
    Slide,
)
from feeler._core_results import (
    Batch,
    ClashRows,
    Clearance,
    ClearanceBatch,
    Collision,
    Distance,
    DistanceBatch,
    DistributionAnswer,
    GrantedAnswer,
    MoveAnswer,
    Packed,
    PackedPiece,
    Rays,
    RemovalAnswer,
    RunEnd,
    SavedScene,
    SeatAnswer,
    SectionOutline,
    StartAnswer,
    StatisticsAnswer,
    StepAnswer,
    TickAnswer,
    TraceAnswer,
)
from feeler.choices import DefectKind, Estimator, PenetrationKind, Simd, Storage, Touching
from feeler.parts import PartsLike
from feeler.poses import PoseLike, PosesLike

_Progress = Callable[[float, str], object]

__all__ = [
    "Batch",
    "Bodies",
    "Cast",
    "Chain",
    "ClashRows",
    "Clearance",
    "ClearanceAlong",
    "ClearanceBatch",
    "Collision",
    "ContactPlane",
    "ContactTracker",
    "Contacts",
    "Containment",
    "Distance",
    "DistanceBatch",
    "DistributionAnswer",
    "GrantedAnswer",
    "GuardedMove",
    "HapticsDevice",
    "HapticsRun",
    "HapticsSession",
    "IgnoredPairs",
    "Impact",
    "Mockup",
    "MoveAnswer",
    "MovedMockup",
    "Packed",
    "PackedPiece",
    "PathCheck",
    "Penetration",
    "PiecePredictor",
    "Predictor",
    "Rays",
    "RemovalAnswer",
    "RunEnd",
    "SavedScene",
    "Scene",
    "Screw",
    "SeatAnswer",
    "SectionOutline",
    "Selected",
    "Shape",
    "Slide",
    "StartAnswer",
    "StatisticsAnswer",
    "StepAnswer",
    "TickAnswer",
    "Tool",
    "TraceAnswer",
    "World",
    "clash",
    "optimal_voxel_size",
    "removal",
    "restore",
    "swept",
    "weld_vertices",
]

@disjoint_base
class Mockup:
    def __new__(
        cls,
        vertices: npt.NDArray[np.float64] | SavedScene | MovedMockup,
        faces: npt.NDArray[np.uint32] | None = None,
        part_of_face: npt.NDArray[np.uint32] | None = None,
        part_count: int = 1,
    ) -> Self: ...
    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`, metres, read-only."""
    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """`(m, 3)`, read-only."""
    @property
    def part_of_face(self) -> npt.NDArray[np.uint32]:
        """`(m,)`: the part of each triangle."""
    @property
    def part_triangles(self) -> npt.NDArray[np.uint32]:
        """`(parts,)`: triangles of each part, defective ones included."""
    @property
    def part_bounds(self) -> npt.NDArray[np.float64]:
        """`(2 * parts, 3)`: lower and upper corner of each part's box, metres; crossed if the part is empty."""
    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """`(2, 3)`: lower and upper corner of the box around all queried triangles, metres."""
    @property
    def triangle_count(self) -> int:
        """Triangles given, defective ones included."""
    @property
    def part_count(self) -> int:
        """Parts, including those without triangles."""
    @property
    def defects(self) -> Mapping[DefectKind, tuple[int, Sequence[int]]]:
        """Kind of defect -> count and first ids."""
    def pack(self, vertex_limit: int, small: Sequence[bool] | None) -> Packed: ...

@disjoint_base
class Tool:
    def __new__(
        cls,
        vertices: npt.NDArray[np.float64],
        faces: npt.NDArray[np.uint32],
        part_of_face: npt.NDArray[np.uint32] | None,
        part_count: int,
    ) -> Self: ...
    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`, metres, read-only."""
    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """`(m, 3)`, read-only."""
    @property
    def part_of_face(self) -> npt.NDArray[np.uint32]:
        """`(m,)`: the part of each triangle."""
    @property
    def part_triangles(self) -> npt.NDArray[np.uint32]:
        """`(parts,)`: triangles of each part, defective ones included."""
    @property
    def part_bounds(self) -> npt.NDArray[np.float64]:
        """`(2 * parts, 3)`: lower and upper corner of each part's box, metres; crossed if the part is empty."""
    @property
    def part_count(self) -> int:
        """Parts, including those without triangles."""
    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """`(2, 3)`: lower and upper corner of the box around all queried triangles, tool frame, metres."""
    @property
    def triangle_count(self) -> int:
        """Triangles given, defective ones included."""
    @property
    def defects(self) -> Mapping[DefectKind, tuple[int, Sequence[int]]]:
        """Kind of defect -> count and first ids."""
    def pack(self, vertex_limit: int, small: Sequence[bool] | None) -> Packed: ...

@disjoint_base
class IgnoredPairs:
    def __new__(cls, tool_parts: int, parts: int, pairs: npt.NDArray[np.uint32]) -> Self: ...

_Pairs = IgnoredPairs | Iterable[tuple[PartsLike, PartsLike]] | None
_Ignore = Any  # of methods that feeler.Scene overrides: its IgnoredPairs is a class of its own

@final
class MovedMockup:
    """The core of a mock-up that another one's parts were moved for: an argument for `Mockup`."""

@final
class Selected:
    """The core of a scene that shares another scene's index, or that of a file."""

    def __new__(
        cls, saved: SavedScene, mockup: Mockup, threads: int | None, memory_limit: int, simd: str | None
    ) -> Self: ...

@disjoint_base
class Scene:
    def __new__(
        cls,
        mockup: Mockup | Selected,
        voxel_size: float | None = None,
        storage: Storage = "blocks",
        hashing: float = 0.0,
        tool: Tool | None = None,
        threads: int | None = None,
        progress: _Progress | None = None,
        memory_limit: int = ...,
        simd: Simd | None = None,
    ) -> Self: ...
    @property
    def mockup(self) -> Mockup:
        """The mock-up."""
    @property
    def voxel_size(self) -> float:
        """Edge of the voxels, or the piece size of blocks, metres."""
    @property
    def storage(self) -> Storage:
        """`"blocks"`, `"dense"` or `"hashed"`."""
    @property
    def hashing(self) -> float:
        """The hashing level; 0 unless hashed."""
    @property
    def simd(self) -> Simd:
        """The instruction set of its queries: `"avx512"`, `"avx2"`, `"neon"` or `"portable"`."""
    def memory(self) -> Mapping[str, int]:
        """Bytes by structure, and their `"total"`: all that stays in memory for the index.

        `"triangles"` and `"parts"` are the mock-up's own arrays, which the index reads and does not copy.
        """
    def validate(self) -> None:
        """Raises `FeelerError` if an invariant of the index does not hold; for tests."""
    @property
    def part_mask(self) -> npt.NDArray[np.bool_]:
        """`(parts,)`: true for the parts present in the scene; all of them unless it was made by `without` or
        `only`."""
    def _save(self, path: str, extras: list[tuple[str, bytes]], progress: _Progress | None) -> str: ...
    def _selected_without(self, parts: Sequence[int]) -> Selected: ...
    def _selected_only(self, parts: Sequence[int]) -> Selected: ...
    def _selected_moved(
        self, pose_of_part: Sequence[int], poses: PosesLike, mockup_of: Callable[[MovedMockup], Mockup]
    ) -> Selected: ...
    def collide(
        self,
        tool: Tool,
        world_from_tool: PoseLike,
        *,
        repeat_filter: bool = True,
        box_filter: bool = True,
        ignore: _Pairs = None,
    ) -> Collision:
        """Every colliding pair of triangles, with the tool at a pose `(4, 4)`; exact.

        The filters skip repeated pairs and compare boxes first. They never change the answer; switch one off to measure
        its effect. Raises `PoseError` for a pose that is not rigid.
        """
    def is_colliding(
        self, tool: Tool, world_from_tool: PoseLike, *, touching: Touching = "counts", ignore: _Pairs = None
    ) -> bool:
        """Whether any two triangles collide, with the tool at a pose `(4, 4)`; stops at the first pair.

        With `touching="free"`, whether one body enters the other: surfaces in contact and a pin seated without play are
        free. Crossing pairs enter. Coplanar and touching pairs are decided by exact side tests on the connectivity of
        both meshes, which is computed once. An open sheet has no inside: a tool that touches it from both sides goes
        through it. Pairs that share only corners of both triangles count as touching.
        """
    def is_free(self, tool: Tool, world_from_tool: PoseLike, *, ignore: _Pairs = None) -> bool:
        """Whether the tool at a pose `(4, 4)` neither collides nor contains anything, nor is contained
        (`containment`)."""
    def containment(self, tool: Tool, world_from_tool: PoseLike, *, ignore: _Pairs = None) -> Containment:
        """Which closed parts contain the tool, and which parts the tool contains, at a pose `(4, 4)`.

        Exact, by winding numbers, for each connected surface separately. One solid of a part may contain the tool; the
        inside of a hollow counts as outside. A surface that crosses a part is not inside it; one that touches it can
        be.
        """
    def collide_batch(
        self, tool: Tool, poses: PosesLike, progress: _Progress | None, *, ignore: _Ignore = None
    ) -> Batch: ...
    def clearance(
        self, tool: Tool, world_from_tool: PoseLike, within: float, triangles: bool, *, ignore: _Ignore = None
    ) -> Clearance: ...
    def _depths(
        self, tool: Tool, world_from_tool: PoseLike, seconds: float, *, ignore: _Ignore = None
    ) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.float64], npt.NDArray[np.bool_]] | None: ...
    def distance(self, tool: Tool, world_from_tool: PoseLike, within: float, *, ignore: _Ignore = None) -> Distance: ...
    def _distances(
        self, tool: Tool, world_from_tool: PoseLike, within: float, k: int, *, ignore: _Ignore = None
    ) -> list[Distance]: ...
    def distance_batch(
        self, tool: Tool, poses: PosesLike, within: float, progress: _Progress | None, *, ignore: _Ignore = None
    ) -> DistanceBatch: ...
    def clearance_batch(
        self,
        tool: Tool,
        poses: PosesLike,
        within: float,
        triangles: bool,
        progress: _Progress | None,
        *,
        ignore: _Ignore = None,
    ) -> ClearanceBatch: ...
    def clearance_along(
        self,
        tool: Tool,
        pose: PoseLike,
        way: Screw | Slide | Chain | PoseLike,
        *,
        within: float,
        error: float,
        ignore: _Ignore = None,
    ) -> ClearanceAlong: ...
    def cast(
        self,
        tool: Tool,
        start: PoseLike,
        end: PoseLike | None = None,
        *,
        screw: Screw | Slide | Chain | None = None,
        tolerance: float,
        touching: Touching,
        ignore: _Ignore = None,
    ) -> Cast | None: ...
    def _cast_within(
        self, tool: Tool, start: PoseLike, screw: Screw | Slide | Chain, *, tolerance: float, ignore: _Ignore = None
    ) -> Cast | None: ...
    @overload
    def check_path(
        self,
        tool: Tool,
        poses: Sequence[PoseLike | Screw | Slide | Chain],
        *,
        tolerance: float,
        touching: Touching,
        inside: bool,
        progress: _Progress | None,
        ignore: _Ignore = None,
    ) -> PathCheck: ...
    @overload
    def check_path(
        self,
        tool: Tool,
        poses: PosesLike,
        *,
        tolerance: float,
        touching: Touching,
        inside: bool,
        progress: _Progress | None,
        ignore: _Ignore = None,
    ) -> PathCheck: ...
    def contacts(
        self,
        tool: Tool,
        world_from_tool: PoseLike,
        within: float,
        reference: PoseLike | None,
        *,
        ignore: _Ignore = None,
    ) -> Contacts: ...
    def penetration(
        self,
        tool: Tool,
        world_from_tool: PoseLike,
        within: float,
        reference: PoseLike | None,
        *,
        ignore: _Ignore = None,
    ) -> Penetration: ...
    def rays(
        self,
        origins: npt.NDArray[np.float64],
        directions: npt.NDArray[np.float64],
        *,
        within: float,
        sections: npt.NDArray[np.float64],
    ) -> Rays: ...
    def section(self, point: Sequence[float], normal: Sequence[float]) -> SectionOutline: ...

@final
class Contacts:
    """Contact planes, deepest first; false when there are none. `contacts[i]` is one. All arrays are read-only."""

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: a point of each plane on the mock-up's surface, world, metres."""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """`(k, 3)`: unit, from the mock-up to the tool, world."""
    @property
    def gaps(self) -> npt.NDArray[np.float64]:
        """`(k,)`: metres, ascending. Negative: the depth of the tool behind the plane or, where both surfaces are
        concave, their overlap along the normal."""
    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `mockup.parts`."""
    @property
    def tool_parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: indices into `tool.parts`."""
    @property
    def ids(self) -> npt.NDArray[np.uint64]:
        """`(k,)`: identify the pair of surfaces of tool and mock-up, the same at every pose and in every call, thread
        and run. Unique within one answer."""
    @property
    def footing(self) -> npt.NDArray[np.float64]:
        """`(k, 4, 3)`: the points of the tool that carry each contact, tool frame, metres, in order around the normal.

        Plane `i` has the first `footing_counts[i]`; the rest repeat the last. If these points stay in front of the
        plane during a turn of up to one degree, so does the part of the tool that lies there, but for 1 % of the
        distance by which the turn moves it. Computed at the first access.
        """
    @property
    def footing_counts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: 1 for a corner, 2 for an edge, 3 or 4 for flat and round surfaces."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """Tool triangles behind the planes; plane `i` has those from `tool_offsets[i]` to `tool_offsets[i + 1]`."""
    @property
    def tool_offsets(self) -> npt.NDArray[np.uint64]:
        """`(k + 1,)`: into `tool_triangles`."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """Triangles of the mock-up behind the planes, as `tool_triangles`."""
    @property
    def mockup_offsets(self) -> npt.NDArray[np.uint64]:
        """`(k + 1,)`: into `mockup_triangles`."""
    @property
    def omitted(self) -> int:
        """Number of planes left out beyond 32: the least deep or the farthest."""
    @property
    def is_meeting(self) -> bool:
        """Whether any triangles collide."""
    def __len__(self) -> int: ...
    def __bool__(self) -> bool: ...
    @overload
    def __getitem__(self, index: int, /) -> ContactPlane: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[ContactPlane]: ...
    def __iter__(self) -> Iterator[ContactPlane]: ...

@final
class ContactPlane:
    """One contact plane of `Contacts`."""

    @property
    def point(self) -> npt.NDArray[np.float64]:
        """`(3,)`: on the mock-up's surface, world, metres."""
    @property
    def normal(self) -> npt.NDArray[np.float64]:
        """`(3,)`: unit, from the mock-up to the tool, world."""
    @property
    def gap(self) -> float:
        """Metres; negative: depth."""
    @property
    def part(self) -> int:
        """Index into `mockup.parts`."""
    @property
    def tool_part(self) -> int:
        """Index into `tool.parts`."""
    @property
    def id(self) -> int:
        """As in `Contacts.ids`."""
    @property
    def footing(self) -> npt.NDArray[np.float64]:
        """`(n, 3)`, n from 1 to 4: as in `Contacts.footing`."""
    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """`(t,)`: triangles of the tool behind it, ascending."""
    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """`(m,)`: triangles of the mock-up behind it, ascending."""

@final
class Penetration:
    """A translation that frees the tool."""

    @property
    def translation(self) -> npt.NDArray[np.float64]:
        """`(3,)`: metres, world; add it to the pose's translation."""
    @property
    def depth(self) -> float:
        """Its length, metres."""
    @property
    def kind(self) -> PenetrationKind:
        """`"bound"` (it frees the tool, a shorter one may exist), `"estimate"` (it does not free the tool), or
        `"exact"` (the tool does not collide, or only touches)."""
    @property
    def contacts(self) -> Contacts:
        """The contact planes at the pose."""

@disjoint_base
class ContactTracker:
    def __new__(cls, scene: Scene, tool: Tool, *, ignore: _Ignore = None) -> Self: ...
    def contacts(self, world_from_tool: PoseLike, within: float) -> Contacts: ...
    @property
    def last_free(self) -> npt.NDArray[np.float64] | None:
        """The last pose without a collision, `(4, 4)`."""
    def _set_last_free(self, world_from_tool: PoseLike | None) -> None:
        """Sets the last free pose, or forgets it."""

@final
class Predictor:
    """The predicted work and time of queries, averaged over places of the tool on the mock-up's surface.

    `constants`: seconds for a query, a tool triangle, a voxel, a list entry, a pair and a triangle test.
    """

    def __new__(cls, mockup: Mockup, tool: Tool, storage: str, hashing: float) -> Self: ...
    def work(self, voxel_size: float) -> tuple[float, float, float, float, float]:
        """Tool triangles placed, voxels visited, list entries read, distinct pairs, triangle tests of a query."""
    def seconds(self, voxel_size: float, constants: Sequence[float]) -> float:
        """The time of a query."""
    def bytes(self, voxel_size: float) -> float:
        """The memory of the store."""
    def optimal_size(self, constants: Sequence[float], memory_limit: int) -> float:
        """The voxel size (metres) with the least time, among those whose store takes at most `memory_limit` bytes."""

@final
class PiecePredictor:
    """How the work of queries of a tool depends on the piece size of blocks."""

    def __new__(cls, mockup: Mockup, tool: Tool) -> Self: ...
    def work(self, piece_size: float) -> tuple[float, float]:
        """The work that depends on the piece size, in arbitrary units, and the number of pieces."""
    def optimal_size(self, memory_limit: int) -> float:
        """The piece size (metres) with the least work, within three pieces a triangle and the memory for building."""

def optimal_voxel_size(mockup: Mockup, tool: Tool, estimator: Estimator) -> float: ...
def removal(
    scene: Scene,
    tool: Tool,
    start: npt.ArrayLike,
    *,
    own_parts: int,
    allow_start: bool,
    allow_overlap: float,
    allow_parts: list[int],
    directions: npt.NDArray[np.float64],
    clearance: float,
    seconds: float,
    seed: int,
    rounds: int | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> RemovalAnswer:
    """A way of a tool out of a scene, and its blockers; the tool's first `own_parts` parts are parts of the mock-up."""

def clash(
    scene: Scene,
    clearance: npt.NDArray[np.float64],
    contact: npt.NDArray[np.float64],
    *,
    class_of_part: npt.NDArray[np.uint32] | None = None,
    contact_of_part: npt.NDArray[np.float64] | None = None,
    copies_within: float = 0.0,
    exclude: npt.NDArray[np.uint32] | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> ClashRows:
    """Every pair of present parts that are closer than required.

    - `clearance`, `contact`: `(classes, classes)`, metres, symmetric. The required distance between parts of two
      classes (negative: such pairs are skipped), and the depth or distance up to which they count as in contact.
    - `class_of_part`: `(parts,)`; default: class 0 for all.
    - `contact_of_part`: `(parts,)`, metres: added to the contact of each pair of the part.
    - `copies_within`: metres: how far apart rounding in a file may put two copies of one surface.
    - `exclude`: `(k, 2)`: pairs of parts to skip.
    - `threads`: default: those of the scene.

    Ctrl-C ends it early: the result has the rows found so far (all of them, if only depths were missing), and
    `is_partial` is true. Depths not measured by then are NaN. Raises `OptionError` for tables of the wrong shape and
    invalid lengths, `MeshError` for arrays of the wrong length.
    """

def swept(
    tool: Tool,
    poses: PosesLike,
    error: float,
    *,
    threads: int | None = None,
    memory_limit: int = ...,
    progress: _Progress | None = None,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """The closed mesh around the swept volume of a tool: vertices `(n, 3)`, metres, world, faces `(m, 3)`, wound
    outwards.

    Raises `PoseError`, `OptionError` for an error that is not a positive length, `LimitError` for one that is too
    small.
    """

def weld_vertices(vertices: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """Distinct vertices in order of first appearance, `(k, 3)`, and each given vertex's index among them, `(n,)`.

    Equal means equal coordinates, with 0.0 equal to -0.0.
    """

def restore(kind: str, state: tuple[object, ...]) -> object:
    """A result from its pickled state (`feeler.travel`). Raises `LoadError` for a state that does not fit."""

@disjoint_base
class World:
    """A scene, and parts of its mock-up that lie elsewhere, queried as one; indices are the mock-up's."""

    def __new__(cls, scene: Scene, put_down: Sequence[tuple[int, Scene]]) -> Self:
        """`put_down`: parts of the scene's mock-up that lie elsewhere, each with a scene of it at its new place."""
    def collide(self, tool: Tool, world_from_tool: PoseLike) -> Collision:
        """Every colliding pair of triangles."""
    def collision_of(self, tool: Tool, pairs: npt.NDArray[np.uint32], kinds: npt.NDArray[np.uint8]) -> Collision:
        """The `Collision` of known pairs `(k, 2)` of tool and mock-up triangles and their kinds."""
    def is_colliding(self, tool: Tool, world_from_tool: PoseLike) -> bool:
        """Whether any triangles collide."""
    def cast(self, tool: Tool, start: npt.ArrayLike, end: npt.ArrayLike, tolerance: float) -> Impact | None:
        """The first impact between two poses, as `Scene.cast`; None if the motion is free."""
    def distance(self, tool: Tool, world_from_tool: PoseLike, within: float) -> Distance:
        """The smallest distance; infinite if no part is within `within`."""
    def clearance(self, tool: Tool, world_from_tool: PoseLike, within: float) -> Clearance:
        """The parts within `within`, nearest first."""
    def contacts(
        self, tool: Tool, world_from_tool: PoseLike, within: float, reference: PoseLike | None = None
    ) -> Contacts:
        """The contact planes, deepest first."""
    def penetration(self, tool: Tool, world_from_tool: PoseLike, within: float) -> Penetration | None:
        """The shortest translation found that frees the tool from the body it is deepest in; None if it is in none."""
    def is_containing(self, tool: Tool, world_from_tool: PoseLike) -> bool:
        """Whether the tool is inside a part, or contains one."""
    def seated_parts(self, tool: Tool, world_from_tool: PoseLike) -> list[tuple[int, int]]:
        """The seats, as pairs of tool part and mock-up part in contact: unique, sorted."""
    def least_distance(self, tool: Tool, way: npt.ArrayLike, within: float, ignore: Sequence[tuple[int, int]]) -> float:
        """The smallest distance along poses `(n, 4, 4)`, at most `within`; ignores the given pairs of parts."""
    def part_of(self, triangles: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
        """The parts of some triangles of the mock-up."""

@final
class GuardedMove:
    """A tool that stops at contact. Parts in contact at the start are seats: it may slide along them and separate."""

    def __new__(cls, world: World, tool: Tool, world_from_tool: PoseLike) -> Self: ...
    def seats(self) -> list[SeatAnswer]:
        """The remaining seats, with their depths at the start."""
    def go(self, start: npt.ArrayLike, end: npt.ArrayLike, tolerance: float, off: float) -> MoveAnswer:
        """Moves from a pose towards another as far as possible.

        `tolerance`: of the casts. `off`: the distance before an impact at which it stops. Metres.
        """
    def along(
        self, tool: Tool, start: npt.ArrayLike, way: Screw | Slide | Chain | npt.ArrayLike, tolerance: float
    ) -> tuple[MoveAnswer, float]:
        """Moves from a pose along a screw, slide or chain, or to another pose, exactly, as far as possible; it stays
        where it is. The pose, the impact if any, and the free fraction of the motion.

        Contacts may be as deep as at the pose it was made at, wherever the motion starts. `tolerance`: of the casts,
        metres.
        """

@disjoint_base
class HapticsSession:
    """One session; `feeler.haptics.Session` adds names and records."""

    def __new__(
        cls,
        scene: Scene,
        tool: Tool,
        coupling: Sequence[float],
        margin: float,
        skin: float,
        shading: bool,
        collision_hz: float | None,
        put_down: Sequence[tuple[int, Scene]],
    ) -> Self:
        """`put_down`: parts of the scene's mock-up that lie elsewhere, each with a scene of that part alone."""
    def _begin(self, pose: PoseLike) -> StartAnswer:
        """Begins at a pose."""
    def _advance(self, pose: npt.NDArray[np.float64], dt: float) -> StepAnswer:
        """One step of `dt` seconds; a pose `(4, 4)` that is not rigid is in doubt."""
    def _swap(self, scene: Scene) -> StartAnswer:
        """Changes the scene: the seats of the proxy there."""
    def _grip(self, parts: Sequence[int]) -> None: ...
    def _release(self, put_back: bool) -> None: ...
    @property
    def _gripped(self) -> list[int]: ...
    @property
    def _moved_parts(self) -> npt.NDArray[np.uint32]: ...
    @property
    def _last_rounds(self) -> tuple[int, int]: ...

@disjoint_base
class HapticsDevice:
    """A device, until a run takes it; the base of the classes of `feeler.haptics.devices`."""

    @staticmethod
    def simulated(
        preset: str,
        times: Sequence[float] | None,
        poses: npt.ArrayLike | None,
        grip: str,
        delays: Sequence[float],
        seed: int,
        fault: tuple[str, float, float, float] | None,
    ) -> HapticsDevice: ...
    @staticmethod
    def mouse(pose: PoseLike, frequency: float) -> HapticsDevice: ...
    @staticmethod
    def open(name: str, options: dict[str, Any]) -> HapticsDevice: ...
    @staticmethod
    def own(
        object: Any,
        name: str,
        senses_rotation: bool,
        workspace: Sequence[float],
        buttons: int,
        limits: Sequence[float],
    ) -> HapticsDevice: ...
    @staticmethod
    def drivers() -> list[tuple[str, str]]: ...
    def set_target(self, pose: PoseLike) -> None: ...
    def set_buttons(self, buttons: int) -> None: ...
    def coupling(self) -> list[float]: ...
    @property
    def name(self) -> str: ...
    @property
    def sensed(self) -> list[str]: ...
    @property
    def driven(self) -> list[str]: ...
    @property
    def workspace(self) -> list[float]: ...
    @property
    def button_count(self) -> int: ...
    @property
    def limits(self) -> dict[str, float]: ...

@final
class HapticsRun:
    """One run of a session with a device."""

    def __new__(
        cls,
        session: HapticsSession,
        device: HapticsDevice,
        rate_hz: float,
        scale: float,
        world_from_device: npt.ArrayLike,
        is_absolute: bool,
        clutch_button: int | None,
        is_realtime: bool,
    ) -> Self: ...
    def stop(self) -> RunEnd:
        """Ends it."""
    def statistics(self) -> StatisticsAnswer:
        """The run up to now; after its end, all of it."""
    def view(self) -> TickAnswer:
        """The newest tick."""
    def guide(self, place: PoseLike | None, pull: Sequence[float]) -> None:
        """Draws the tool to a pose, with a pull besides; None: nothing draws it."""
    def trace(self) -> TraceAnswer:
        """Every tick since the last call, 4 s at most; after the end of the run, those that are left."""
    def granted(self) -> GrantedAnswer:
        """What was granted so far."""
    def start(self, pose: PoseLike) -> StartAnswer: ...
    def set_scene(self, scene: Scene) -> StartAnswer: ...
    def grip(self, parts: Sequence[int]) -> None: ...
    def release(self, put_back: bool) -> None: ...
    @property
    def is_running(self) -> bool: ...
