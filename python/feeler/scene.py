"""Scenes: a mock-up with its index, and the queries on it."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from typing import Any, cast, overload

import numpy as np
import numpy.typing as npt

from feeler import _core, saved, scene_pickles
from feeler._core import (
    Batch,
    Cast,
    Chain,
    Clearance,
    ClearanceAlong,
    ClearanceBatch,
    Contacts,
    Distance,
    DistanceBatch,
    PathCheck,
    Penetration,
    Rays,
    Screw,
    SectionOutline,
    Slide,
)
from feeler.arguments import (
    UNREADABLE,
    check_flag,
    check_number,
    check_progress,
    check_real,
    check_text,
    check_threads,
    check_whole,
    check_word,
    shown,
    unmasked,
)
from feeler.atomic import check_target
from feeler.calibrate import machine_constants
from feeler.choices import ESTIMATORS, SIMDS, STORAGES, TOUCHINGS, Estimator, Simd, Storage, Touching
from feeler.depths import Depths
from feeler.enumerations import CodedEnum
from feeler.errors import LimitError, MeshError, OptionError, WriteError
from feeler.figures import SceneMemory
from feeler.ignored import Ignore, IgnoredPairs, ignored
from feeler.memory import free_memory
from feeler.mockup import Mockup, Tool
from feeler.parts import OnePartsKey, PartsKey, PartsLike
from feeler.poses import PoseLike, PosesLike, one_pose
from feeler.progress import Progress
from feeler.renamed import keywords
from feeler.travel import reduced

_Test = Callable[[Any], bool]

CAST_TOLERANCE = 1e-6
"""The most by which an impact may be early, metres."""


class PairKind(CodedEnum):
    """How two triangles collide: words, with numbers (`.code`) from 0 on in their order."""

    COPLANAR = "coplanar"
    """They lie in one plane."""
    CROSSING = "crossing"
    """In two planes: each has vertices strictly on both sides of the other's, and they share more than a point."""
    TOUCHING = "touching"
    """Every other case: a vertex or an edge on a face, edge on edge, a shared point."""


class Scene(_core.Scene):
    """A mock-up with its index; immutable, usable from any number of threads, with any number of tools.

    - `voxel_size`: edge of the voxels, metres; for `blocks` the piece size. Default for `dense` and `hashed`: the
      `optimal_voxel_size` for `tool` (without a tool, by the paper's cost function with the area estimator, for a tool
      whose triangles are as long as the mock-up's). Default for `blocks`: the piece size at which boxes of `tool`
      overlap the fewest of the mock-up's, with at most about two extra pieces a triangle (120 bytes a triangle in all;
      without a tool, the size at which cutting long triangles adds a quarter of pieces, 64 bytes).
    - `storage`: `"blocks"` (ours, the default), `"dense"` (the paper's array) or `"hashed"` (its equation 1).
    - `hashing`: for `hashed`, the share of the voxel array's memory saved, 0 to 0.99.
    - `threads`: for building and batches; default: all.
    - `progress`: called with the share done (0 to 1) and the stage.
    - `memory_limit`: the most bytes for building, and for the result of a batch; default: 80 % of the free memory.
    - `simd`: the instruction set of its queries, `"avx512"`, `"avx2"`, `"neon"` or `"portable"`; default: the best
      this CPU has. All give the same answers.

    Raises `OptionError` for values out of range and `LimitError` for a voxel size that would need more memory, or more
    voxels, than allowed, before anything is allocated.

    Queries take `ignore`: pairs of a tool part and a mock-up part to skip, such as the allowed collision matrix of a
    robot: `[("hand", "*gasket*")]`, or an `IgnoredPairs` made once from such a list.

    A mock-up of a saved scene (`save`, `feeler.open_scene`) comes with its index: nothing is built then, unless another
    `voxel_size` or `storage` is given.

    `copy` returns the scene itself. A pickle contains the mock-up and the options, including the chosen `voxel_size`;
    unpickling rebuilds the index, with the best instruction set of that machine if its CPU lacks the given `simd`. Of a
    saved scene a pickle contains the path and the hash of its content, and unpickling opens the file again.
    """

    build_seconds: float
    """Time to build the index; 0 for a scene derived from another."""
    _given: dict[str, Any]

    def __new__(
        cls,
        mockup: Mockup,
        voxel_size: float | None = None,
        storage: Storage = "blocks",
        hashing: float = 0.0,
        tool: Tool | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
        memory_limit: int | None = None,
        simd: Simd | None = None,
    ) -> Scene:
        """See the class."""
        if not isinstance(mockup, Mockup):
            raise MeshError(f"a scene needs a feeler.Mockup, not {type(mockup).__name__}")
        check_threads(threads)
        check_word("storage", storage, STORAGES)
        if simd is not None:
            check_text("simd", simd, f"one of {', '.join(SIMDS)}")  # the core knows which this CPU has
        given = {"threads": threads, "memory_limit": memory_limit, "simd": simd}
        memory_limit = _memory_limit(memory_limit)
        check_progress(progress)
        if voxel_size is None and tool is not None and storage in ("dense", "hashed"):
            level = check_real("hashing", hashing)
            if 0.0 <= level <= (0.99 if storage == "hashed" else 0.0):  # the core refuses other values, in words
                voxel_size = _calibrated_size(mockup, tool, storage, level, memory_limit)
        start = time.perf_counter()
        file = mockup._saved
        if file and storage == file.core.storage == "blocks" and voxel_size in (None, file.core.voxel_size):
            selected = _core.Selected(file.core, mockup, threads, memory_limit, None if simd is None else str(simd))
            self = super().__new__(cls, selected)
            self.build_seconds, self._given = 0.0, given
            return self
        self = super().__new__(
            cls,
            mockup,
            None if voxel_size is None else check_real("voxel_size", voxel_size),
            storage,
            check_real("hashing", hashing),
            tool,
            threads,
            progress,
            memory_limit,
            simd,
        )
        self.build_seconds = time.perf_counter() - start
        self._given = given
        return self

    @property
    def mockup(self) -> Mockup:
        """The mock-up, with all its parts."""
        mockup = super().mockup
        assert isinstance(mockup, Mockup)
        return mockup

    def memory(self) -> SceneMemory:
        """Bytes by structure, and their `total`: all that stays in memory for the index.

        `triangles` and `parts` are the mock-up's own arrays, which the index reads and does not copy.
        """
        return SceneMemory(**super().memory())

    def without(self, parts: PartsLike) -> Scene:
        """The scene without some parts, which can then move in it as a `Tool.of_parts`.

        `parts` as `Parts.select` takes them: indices, paths, patterns. The new scene shares mock-up, index and threads.
        Triangle and part indices do not change, and every query answers as in a scene built without these parts. Parts
        already removed stay removed. Raises `OptionError` for parts that do not exist.
        """
        return self._made_of(super()._selected_without(self.mockup.parts.select(parts).tolist()))

    def only(self, parts: PartsLike) -> Scene:
        """The scene with only these parts, except those already removed; the opposite of `without`."""
        return self._made_of(super()._selected_only(self.mockup.parts.select(parts).tolist()))

    @overload  # before the other: of a dict of several kinds of keys, mypy finds none
    def moved(self, poses: Mapping[PartsKey, PoseLike]) -> Scene: ...
    @overload
    def moved(self, poses: Mapping[OnePartsKey, PoseLike]) -> Scene: ...
    def moved(self, poses: Mapping[PartsKey, PoseLike] | Mapping[OnePartsKey, PoseLike]) -> Scene:
        """The scene with parts at other places: `{"cowl/*": pose}`, each pose `(4, 4)`.

        Keys name parts as `Parts.select` takes them: an index, a path or pattern, a tuple of these. A pose counts from
        where the parts are modelled, in the world; also in a scene that has parts moved. Parts without a pose are where
        they are modelled. Parts that are not in the scene stay out.

        The new scene shares the index, and only the triangles that move are indexed, in milliseconds for a few
        thousand. Its `mockup` has the parts moved; part and triangle indices do not change, and every query answers as
        in a scene of that mock-up. `save` and clashes of all parts index it as a whole first. In a file, and in a
        pickle of the mock-up alone, parts are modelled where they were moved to.

        A triangle without area where it is modelled stays out of queries. Vertices that parts of several poses share
        are given to each, behind the others. Raises `OptionError` for parts that do not exist or have two poses,
        `PoseError` for poses that are not rigid.
        """
        if not isinstance(poses, Mapping):
            raise OptionError(f"poses is {shown(poses)}: give a dict of parts and poses, such as {{'cowl/*': pose}}")
        pose_of_part = np.full(self.mockup.part_count, -1)
        matrices = [one_pose(pose, f"the pose of {shown(parts)}") for parts, pose in poses.items()]
        for number, parts in enumerate(poses):
            chosen = self.mockup.parts.select(parts)
            twice = chosen[pose_of_part[chosen] >= 0]
            if len(twice):
                path = self.mockup.part_paths[int(twice[0])]
                raise OptionError(f"part {path!r} has two poses, the second by {shown(parts)}: give it one")
            pose_of_part[chosen] = number
        return self._with_poses(pose_of_part, np.array(matrices).reshape(-1, 4, 4))

    def _with_poses(self, pose_of_part: npt.NDArray[Any], poses: npt.NDArray[np.float64]) -> Scene:
        """`moved`: by part the number of its pose, or -1."""
        stays = (poses == np.eye(4)).all(axis=(1, 2))
        chosen = np.where(pose_of_part >= 0, np.append(~stays, False)[pose_of_part], False)
        modelled = self.mockup if self.mockup._modelled is None else self.mockup._modelled
        if not chosen.any():
            if modelled is self.mockup:
                return self
            return self._made_of(super()._selected_moved([], poses, lambda _: modelled))
        places = np.where(chosen, pose_of_part, -1).tolist()
        made = partial(modelled._with_moved, moves=(places, poses))
        return self._made_of(super()._selected_moved(places, poses, made))

    def save(self, path: str | os.PathLike[str], progress: Progress | None = None) -> str:
        """Save the scene in one file, for `feeler.open_scene` and every command; return the hash of its mock-up.

        The file has the mock-up with its names, colours and report, the index, and what first queries need: the
        connectivity of the triangles. It is written beside its place and renamed at the end, so that an older file
        stays whole if the disk is full. Other storages than `"blocks"` are built again when the file is opened.

        Files are read by the version of feeler that wrote them, or one with the same layout; others refuse them. Keep
        the files that the mock-up was loaded from. Raises `WriteError`, and `MeshError` for names or colours of the
        mock-up that were set to something else.
        """
        check_progress(progress)
        return self._save_with(path, [], progress)

    def _save_with(
        self, path: str | os.PathLike[str], others: list[tuple[str, bytes]], progress: Progress | None = None
    ) -> str:
        """`save` with more sections."""
        mockup = self.mockup
        facts = saved.Facts(mockup.part_names, mockup.part_paths, mockup.source, mockup.part_colours)
        saved.path_of(path, WriteError)
        target = str(check_target(path, saved.SUFFIX))
        if os.path.islink(target):  # the file that it names is written, and the link stays
            target = str(check_target(os.path.realpath(target)))
        return super()._save(target, saved.extras(facts, mockup._part_attributes) + others, progress)

    @contextmanager
    def _in_a_file(self) -> Iterator[Scene]:
        """The scene as worker processes open it: in a file, which may be temporary, and with one thread each."""
        file = self.mockup._saved
        if file is not None and file.is_there:
            options = {**self._given, "threads": 1}
            alone = Scene(self.mockup, self.voxel_size, self.storage, self.hashing, **options)
            mask = self.part_mask
            yield alone if mask.all() else alone.only(mask)
            return
        with tempfile.TemporaryDirectory(prefix="feeler-", ignore_cleanup_errors=True) as folder:
            path = os.path.join(folder, f"scene{saved.SUFFIX}")
            self.save(path)
            yield open_scene(path, verify=False, threads=1)

    def _made_of(self, selected: _core.Selected) -> Scene:
        scene = _core.Scene.__new__(type(self), selected)
        scene.build_seconds, scene._given = 0.0, self._given
        return scene

    def _recalled(
        self, kind: str, own: Sequence[int], facts: Any, ask: Callable[[], Any], is_enough: _Test = lambda _: True
    ) -> Any:
        """The answer of a question, which scenes that remember answers may know.

        own: the parts that it moves; facts: all else it depends on but for the parts around. Facts and answers: lists
        of numbers, texts and `PartNumber`. is_enough: whether a known answer says enough."""
        return ask()

    def _depends_on(self, parts: Sequence[int]) -> None:
        """Told that an answer depends on parts, wherever they are: for scenes that note where it looked."""

    def _saw_removal(self, tool: _core.Tool, directions: npt.NDArray[np.float64], found: Any) -> None:
        """Told by `removal` of parts, `tool`, that it answered in this scene: for scenes that note where it looked."""

    def collide_batch(
        self,
        tool: _core.Tool,
        poses: PosesLike,
        progress: Progress | None = None,
        *,
        ignore: Ignore = None,
        executor: Executor | None = None,
    ) -> Batch:
        """`collide` at each of `(n, 4, 4)` poses, on all threads of the scene.

        Pose `i` has the pairs `batch.pairs[batch.offsets[i]:batch.offsets[i + 1]]`, also `batch[i]`. `executor`: any
        `concurrent.futures.Executor` for more than 20,000 poses (`feeler.removals`). Raises `PoseError` naming the
        first pose that is not rigid, and `LimitError` if the pairs exceed the scene's `memory_limit`.
        """
        check_progress(progress)
        asked = partial(super().collide_batch, tool, poses, progress, ignore=ignore)
        query = ("collide_batch", (tool,), {"ignore": ignore})
        return asked() if executor is None else self._spread(asked, query, poses, executor, progress)

    def _spread(self, here: Any, query: Any, poses: PosesLike, executor: Executor, progress: Progress | None) -> Any:
        from feeler.batches import on_executor  # imported where it is used: it takes longer than most of feeler

        limit = _memory_limit(self._given["memory_limit"])
        return on_executor(here, self, query, poses, executor, progress, limit)

    def clearance(
        self,
        tool: _core.Tool,
        world_from_tool: PoseLike,
        within: float = 0.005,
        triangles: bool = False,
        *,
        ignore: Ignore = None,
    ) -> Clearance:
        """The parts not farther than `within` (metres) with the tool at a pose `(4, 4)`: a row for each, nearest first.

        With `triangles`, a row for each pair of triangles. A distance is 0 if and only if they collide; otherwise its
        error is at most 1.4e-14 of the largest difference of coordinates of the two triangles. If several pairs have
        the same distance, a part's row has the one with the smallest ids; if several collide, any. Raises `OptionError`
        if `within` is negative or NaN (it may be infinite), `LimitError` if the rows exceed the scene's `memory_limit`.
        """
        return super().clearance(
            tool, world_from_tool, _within(within), check_flag("triangles", triangles), ignore=ignore
        )

    def distance(
        self,
        tool: _core.Tool,
        world_from_tool: PoseLike,
        within: float = math.inf,
        *,
        ignore: Ignore = None,
    ) -> Distance:
        """The distance of tool and mock-up with the tool at a pose `(4, 4)`, with the two closest points.

        If no part is within `within` (metres), the value is infinite and all else None. Exact as `clearance`; if they
        collide, the value is 0, and the triangles are some colliding pair. Raises `OptionError` if `within` is negative
        or NaN.
        """
        return super().distance(tool, world_from_tool, _within(within), ignore=ignore)

    def nearest(
        self,
        tool: _core.Tool,
        world_from_tool: PoseLike,
        k: int,
        within: float = math.inf,
        *,
        ignore: Ignore = None,
    ) -> list[Distance]:
        """The distances of the `k` closest parts within `within` (metres), nearest first.

        Otherwise as `distance`. Raises `OptionError` also for `k` below 1.
        """
        return super()._distances(
            tool, world_from_tool, _within(within), check_whole("k", k, 1, 2**32 - 1), ignore=ignore
        )

    @keywords({"max": "within"})
    def distance_batch(
        self,
        tool: _core.Tool,
        poses: PosesLike,
        within: float = math.inf,
        progress: Progress | None = None,
        *,
        ignore: Ignore = None,
        executor: Executor | None = None,
    ) -> DistanceBatch:
        """`distance` at each of `(n, 4, 4)` poses, on all threads of the scene, or on an executor (`collide_batch`)."""
        check_progress(progress)
        asked = partial(super().distance_batch, tool, poses, _within(within), progress, ignore=ignore)
        query = ("distance_batch", (tool,), {"within": within, "ignore": ignore})
        return asked() if executor is None else self._spread(asked, query, poses, executor, progress)

    def clearance_batch(
        self,
        tool: _core.Tool,
        poses: PosesLike,
        within: float = 0.005,
        triangles: bool = False,
        progress: Progress | None = None,
        *,
        ignore: Ignore = None,
        executor: Executor | None = None,
    ) -> ClearanceBatch:
        """`clearance` at each of `(n, 4, 4)` poses, on all threads of the scene, or on an executor (`collide_batch`).

        Raises `LimitError` if the rows exceed the scene's `memory_limit`.
        """
        check_progress(progress)
        is_fine = check_flag("triangles", triangles)
        asked = partial(super().clearance_batch, tool, poses, _within(within), is_fine, progress, ignore=ignore)
        query = ("clearance_batch", (tool,), {"within": within, "triangles": triangles, "ignore": ignore})
        return asked() if executor is None else self._spread(asked, query, poses, executor, progress)

    def clearance_along(
        self,
        tool: _core.Tool,
        pose: PoseLike,
        way: Screw | Slide | Chain | PoseLike,
        error: float = 1e-4,
        *,
        within: float = math.inf,
        ignore: Ignore = None,
    ) -> ClearanceAlong:
        """The least gap of the tool on its way from a pose `(4, 4)`, between bounds that are proven for all of the way.

        `way`: a `Screw`, `Slide` or `Chain`, or the pose at its end, to which it leads as in `cast`. The bounds are at
        most `error` (metres) apart: the gap is nowhere less than `lower`, and at `fraction` it is `upper`; both are 0
        if they collide. A tool that goes far at nearly the same gap takes long: after a million spans the bounds are
        what is known by then. Gaps beyond `within` (metres) are not looked at. Raises `OptionError` if `error` is not
        positive and finite, and if `within` is negative or NaN.
        """
        error = check_number("error", error, "metres, more than 0", above=0.0)
        return super().clearance_along(tool, pose, way, within=_within(within), error=error, ignore=ignore)

    def cast(
        self,
        tool: _core.Tool,
        start: PoseLike,
        end: PoseLike | Screw | Slide | Chain | None = None,
        *,
        screw: Screw | Slide | Chain | None = None,
        tolerance: float = CAST_TOLERANCE,
        touching: Touching = "counts",
        ignore: Ignore = None,
    ) -> Cast | None:
        """The first impact between two poses `(4, 4)`, or along a `Screw`, `Slide` or `Chain`; None if it is free.

        A `Screw`, `Slide` or `Chain` may be given as `end` or by name, as `screw`.

        Between poses the middle of the tool's box moves straight and the tool turns about it, the shorter way round,
        both at constant speed. The impact is never late: nothing collides before it. It is early by at most `tolerance`
        metres, the remaining distance of the two triangles; a tool that passes by nearer than that may count as a hit.
        A tool that collides at `start` has its impact at 0; if both poses are equal, the answer is that of `collide`.
        Raises `PoseError` for a pose that is not rigid, `OptionError` for a tolerance that is not positive and finite,
        and if neither a second pose nor a screw is given, or both.

        With `touching="free"` the motion ends where one body enters the other: they may touch, slide along each other,
        and be seated without play. At both poses this is decided exactly, as by `is_colliding`; between them two
        triangles may overlap by `tolerance`, so that the rounding of a motion causes no impact.
        """
        tolerance = check_number("tolerance", tolerance, "metres, more than 0", above=0.0)
        check_word("touching", touching, TOUCHINGS)
        if isinstance(end, (Screw, Slide, Chain)):
            if screw is not None:
                raise OptionError("end is a motion, and screw another: give one of them")
            end, screw = None, end
        return super().cast(tool, start, end, screw=screw, tolerance=tolerance, touching=touching, ignore=ignore)

    @overload
    def check_path(
        self,
        tool: _core.Tool,
        poses: Sequence[PoseLike | Screw | Slide | Chain],
        *,
        tolerance: float = ...,
        touching: Touching = ...,
        inside: bool = ...,
        progress: Progress | None = ...,
        ignore: Ignore = ...,
    ) -> PathCheck: ...
    @overload
    def check_path(
        self,
        tool: _core.Tool,
        poses: PosesLike,
        *,
        tolerance: float = ...,
        touching: Touching = ...,
        inside: bool = ...,
        progress: Progress | None = ...,
        ignore: Ignore = ...,
    ) -> PathCheck: ...
    def check_path(
        self,
        tool: _core.Tool,
        poses: PosesLike | Sequence[PoseLike | Screw | Slide | Chain],
        *,
        tolerance: float = CAST_TOLERANCE,
        touching: Touching = "counts",
        inside: bool = True,
        progress: Progress | None = None,
        ignore: Ignore = None,
    ) -> PathCheck:
        """`cast` from each of `(n, 4, 4)` poses to the next, on all threads of the scene.

        `poses` may also be a list of a pose followed by poses, `Screw`s, `Slide`s and `Chain`s, each starting where the
        previous one ended.

        Each segment is checked separately, also those after an impact; a path of one pose is one segment without
        motion. Raises `PoseError` naming the first pose that is not rigid, and for a path without a pose; `OptionError`
        as `cast`.

        With `inside`, a tool that is inside a closed part at the first pose, or contains one, is not free, even without
        a collision (`PathCheck.containment`). `touching` as in `cast`.
        """
        check_progress(progress)
        check_word("touching", touching, TOUCHINGS)
        return super().check_path(
            tool,
            cast("PosesLike", poses),
            tolerance=check_number("tolerance", tolerance, "metres, more than 0", above=0.0),
            touching=touching,
            inside=check_flag("inside", inside),
            progress=progress,
            ignore=ignore,
        )

    @keywords({"margin": "within"})
    def contacts(
        self,
        tool: _core.Tool,
        world_from_tool: PoseLike,
        within: float = 0.002,
        reference: PoseLike | None = None,
        *,
        ignore: Ignore = None,
    ) -> Contacts:
        """At most 32 contact planes, deepest first, with the tool at a pose `(4, 4)`.

        They represent all collisions and all surfaces not farther than `within` (metres), and do not depend on the
        triangulation. With more than 6 deep planes the distance shrinks, to 0 at 12; if more than a million pairs of
        triangles are within it, it is halved until they are fewer. Unless 12 planes are deep, each colliding part has a
        plane that is not a gap.
        `reference`: a pose `(4, 4)` at which the tool was free. It decides on which side of open surfaces the tool
        belongs (see `ContactTracker`, and docs/contacts.md). Raises `OptionError` if `within` is negative, NaN or
        infinite.
        """
        return super().contacts(tool, world_from_tool, _within(within, endless=False), reference, ignore=ignore)

    @keywords({"margin": "within"})
    def penetration(
        self,
        tool: _core.Tool,
        world_from_tool: PoseLike,
        within: float = 0.002,
        reference: PoseLike | None = None,
        *,
        ignore: Ignore = None,
    ) -> Penetration:
        """The shortest translation that frees the tool at a pose, computed from its contact planes.

        If the planes yield none, many directions are searched, up to the tool's size; this takes milliseconds. The same
        holds for a tool that lies wholly inside a solid, or contains one, without colliding.
        Arguments and errors as `contacts`. `kind` says whether the result is a bound or an estimate.
        """
        return super().penetration(tool, world_from_tool, _within(within, endless=False), reference, ignore=ignore)

    def depth(self, tool: _core.Tool, world_from_tool: PoseLike, *, ignore: Ignore = None) -> Depths:
        """The depth of the tool in each part that it collides with, contains, or is inside; the deepest first.

        The depth of two solids is how far the deepest point of one surface lies inside the other solid. It does not
        depend on the triangulation, and a motion changes it by at most its length. The first query for a part builds a
        tree of its triangles, which the scene keeps.
        Arguments and errors as `collide`.
        """
        columns = self._depths(tool, world_from_tool, math.inf, ignore=ignore)
        assert columns is not None  # it takes no longer than that
        return Depths._of(*columns)

    @keywords({"max": "within"})
    def rays(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        within: float = math.inf,
        sections: npt.ArrayLike | None = None,
    ) -> Rays:
        """The first hits of rays from `origins` `(n, 3)` along `directions` `(n, 3)`, of any length, on all threads.

        Rays end at `within` (metres) and ignore what `sections` cut away: rows `[nx, ny, nz, d]` `(k, 4)`, each of
        which keeps the points with `n . x >= d`; only points kept by all rows count. Which closed triangle a ray hits,
        and which first, is exact; of several at the same place it is the one with the lowest index. The relative error
        of distances is 1e-12. A ray that begins on a triangle hits it at 0; one in a triangle's plane hits it where it
        enters it.

        Raises `OptionError` for other shapes, a zero direction or section normal, numbers that are not finite or beyond
        1e100, and if `within` is negative or NaN.
        """
        starts, ways = _rows("origins", origins, 3), _rows("directions", directions, 3)
        if len(starts) != len(ways):
            raise OptionError(f"there are {len(starts)} origins but {len(ways)} directions: give as many")
        kept = np.empty((0, 4)) if sections is None else _rows("sections", sections, 4)
        return super().rays(starts, ways, within=_within(within), sections=kept)

    def section(self, point: npt.ArrayLike, normal: npt.ArrayLike) -> SectionOutline:
        """The cut of the plane through `point` `(3,)` across `normal` `(3,)`, of any length: one segment a triangle.

        The side of each corner is exact; corners on the plane count as behind it. The outline is therefore that of the
        material in front of the plane, and outlines of closed surfaces are closed. A triangle in the plane yields
        nothing; its neighbours in front of the plane yield its border. Surfaces that touch the plane from behind yield
        nothing. Raises `OptionError` for other shapes, a zero normal, and numbers that are not finite or beyond 1e100.
        """
        return super().section(_vector("point", point), _vector("normal", normal))

    def __reduce__(self) -> tuple[Any, ...]:
        return scene_pickles.reduced_scene(self)

    @classmethod
    def _restore(cls, *state: Any) -> Scene:
        return cast(Scene, scene_pickles.restored_scene(partial(Scene.__new__, cls), *state))

    def __copy__(self) -> Scene:
        return self

    def __deepcopy__(self, _memo: object) -> Scene:
        return self

    def __repr__(self) -> str:
        there, parts = int(np.count_nonzero(self.part_mask)), self.mockup.part_count
        some = "" if there == parts else f", {there:,} of {parts:,} parts there"
        return f"Scene({self.mockup!r}, voxel_size={self.voxel_size:.4g}, storage={self.storage!r}{some})"


def open_scene(
    path: str | os.PathLike[str],
    verify: bool = True,
    *,
    threads: int | None = None,
    memory_limit: int | None = None,
    simd: Simd | None = None,
    progress: Progress | None = None,
) -> Scene:
    """Open a scene that `Scene.save` or `feeler index` wrote, with its mock-up.

    The file is mapped, not read: opening takes milliseconds, and processes that open the same file share its memory.
    `verify` compares the checksum of every section and checks every index; without it, only those of the header are
    checked, and queries of a damaged file may be wrong. Parts that were out of the scene are out again. Other options
    as for `Scene`.

    While a scene is open, replace its file only by `Scene.save`, or by renaming another file to it: never change it in
    place. Raises `MissingFileError`, and `LoadError` for a file that is no saved scene, has another layout, or is
    damaged.
    """
    limit = _memory_limit(memory_limit)
    check_progress(progress)
    file = saved.opened(saved.path_of(path, OptionError), check_flag("verify", verify), limit, progress)
    mockup = Mockup._of_file(file)
    options = {"threads": threads, "memory_limit": memory_limit, "simd": simd}
    core = file.core
    scene = Scene(mockup, core.voxel_size, core.storage, core.hashing, **options)  # type: ignore[arg-type]
    absent = core.absent_parts
    return scene.without(absent) if absent else scene


class ContactTracker(_core.ContactTracker):
    """A tool that moves in a scene; its contacts refer to the last pose without a collision.

    Without such a pose, if the tool starts inside, the side of its larger share decides.
    """

    _asked: tuple[Scene, _core.Tool, IgnoredPairs | None]

    def __new__(cls, scene: Scene, tool: _core.Tool, *, ignore: Ignore = None) -> ContactTracker:
        """See the class."""
        if not isinstance(scene, Scene):
            raise MeshError(f"a tracker needs a feeler.Scene, not {type(scene).__name__}")
        pairs = ignored(ignore, tool, scene.mockup)
        self = super().__new__(cls, scene, tool, ignore=pairs)
        self._asked = (scene, tool, pairs)
        return self

    def __repr__(self) -> str:
        scene, tool, _ = self._asked
        reference = "no free pose yet" if self.last_free is None else "with a free pose"
        return f"ContactTracker({tool!r} in {scene!r}, {reference})"

    def __reduce__(self) -> tuple[Any, ...]:
        attributes = {name: value for name, value in self.__dict__.items() if name != "_asked"}
        return (*reduced("ContactTracker", (type(self), *self._asked, self.last_free)), attributes)

    @classmethod
    def _restore(
        cls, scene: Scene, tool: _core.Tool, pairs: IgnoredPairs | None, last_free: npt.NDArray[np.float64] | None
    ) -> ContactTracker:
        self = ContactTracker.__new__(cls, scene, tool, ignore=pairs)
        self.last_free = last_free
        return self

    @keywords({"margin": "within"})
    def contacts(self, world_from_tool: PoseLike, within: float = 0.002) -> Contacts:
        """`Scene.contacts` with the last free pose as reference; a pose without a collision becomes the next one."""
        return super().contacts(world_from_tool, _within(within, endless=False))

    @property
    def last_free(self) -> npt.NDArray[np.float64] | None:
        """The last pose without a collision, `(4, 4)`. Set it to a pose known to be free, or to None to forget it."""
        return super().last_free

    @last_free.setter
    def last_free(self, world_from_tool: PoseLike | None) -> None:
        super()._set_last_free(world_from_tool)


def optimal_voxel_size(
    mockup: Mockup,
    tool: Tool,
    estimator: Estimator = "calibrated",
    *,
    storage: Storage = "dense",
    hashing: float = 0.0,
    memory_limit: int | None = None,
) -> float:
    """The voxel size (metres) with which queries of a tool in a mock-up are fastest; for `blocks` the piece size.

    - `estimator="calibrated"`: the least time predicted from samples of both meshes and from the cost of each step of a
      query on this machine. The costs are measured at the first use (less than a second) and kept in the user's cache.
      For `blocks` it is the least work, which needs no measuring. `storage`, `hashing` and `memory_limit` are as for
      `Scene`: sizes whose store needs more memory are not chosen.
    - `"area"`, `"diagonal"`, `"side"`: the minimum of the paper's cost function, by how it estimates the static
      triangles per voxel (equations 3 to 10 of Borro, García-Alonso and Matey 2004); independent of the storage.
    """
    check_word("storage", storage, STORAGES)
    check_word("estimator", estimator, ESTIMATORS)
    if not isinstance(mockup, Mockup):
        raise MeshError(f"optimal_voxel_size needs a feeler.Mockup, not {type(mockup).__name__}")
    if estimator != "calibrated":
        return _core.optimal_voxel_size(mockup, tool, estimator)
    level = check_real("hashing", hashing)
    if storage != "hashed" and level != 0.0:
        raise OptionError(f"hashing is {level}, but the storage is not 'hashed': leave hashing at 0")
    limit = _memory_limit(memory_limit)
    size = _calibrated_size(mockup, tool, storage, level, limit)
    return _core.optimal_voxel_size(mockup, tool, "area") if size is None else size


def _calibrated_size(mockup: Mockup, tool: _core.Tool, storage: str, hashing: float, limit: int) -> float | None:
    """None for coordinates near the limits of float64, which allow no prediction."""
    try:
        if storage == "blocks":
            return _core.PiecePredictor(mockup, tool).optimal_size(limit)
        return _core.Predictor(mockup, tool, storage, hashing).optimal_size(machine_constants(), limit)
    except LimitError:
        return None


def _memory_limit(memory_limit: int | None) -> int:
    if memory_limit is None:
        return free_memory() * 4 // 5
    return check_whole("memory_limit", memory_limit, 0, 2**64 - 1)


def _within(value: float, endless: bool = True) -> float:
    """A query distance, metres."""
    wanted = f"a{'' if endless else ' finite'} distance of 0 metres or more"
    return check_number("within", value, wanted, least=0.0, is_endless=endless)


def _rows(what: str, values: npt.ArrayLike, columns: int) -> npt.NDArray[np.float64]:
    """`(n, columns) float64`."""
    unmasked(what, values)
    try:
        array = np.asarray(values)
    except UNREADABLE as error:
        raise OptionError(f"{what} cannot be read as an array: {error}") from error
    if array.shape == (0,):
        array = np.empty((0, columns))
    if array.ndim != 2 or array.shape[1] != columns:
        raise OptionError(f"{what} has shape {array.shape}: (n, {columns}) is needed")
    if array.dtype.kind not in "fiu":
        raise OptionError(f"{what} has dtype {array.dtype}: real numbers are needed")
    with np.errstate(over="ignore"):  # values beyond float64 become infinite, and the core refuses them
        return np.ascontiguousarray(array, dtype=np.float64)


def _vector(what: str, value: npt.ArrayLike) -> list[float]:
    unmasked(what, value)
    try:
        array = np.asarray(value, dtype=object)
    except ValueError:
        array = np.empty(0)  # entries of several shapes
    if array.shape != (3,):
        raise OptionError(f"{what} is {shown(value)}: three numbers are needed")
    return [check_real(what, each) for each in array]
