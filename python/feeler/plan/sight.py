"""`sight`: how much of a bolt's head, a part, or some points is seen from where the eyes are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_kind, check_list, check_progress, check_whole, shown
from feeler.errors import OptionError
from feeler.field_docs import documented
from feeler.part_meshes import PartMeshes
from feeler.parts import PartsLike
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.progress import Progress
from feeler.renamed import OldAttributes
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SAMPLES = 64
"""Points of a target, unless it says otherwise."""
MOST_RAYS = 2_000_000
"""Rays of one batch."""
HEAD_SLOPE = 0.1
"""Faces of a head that are seen by who puts a tool on: those whose normals are at least this much along its axis."""
NEAR_REL = 1e-9
"""A hit as near to the target, relative to the distance, is the target."""


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Seen:
    """How much of one target is seen."""

    target: int
    """Its index."""
    part: int | None
    """Index into `mockup.parts`; None for a point."""
    path: str
    """The path of that part; None for a point."""
    share: float
    """Of its points, from the best eye, 0 to 1; 0 if no eye is outside of the parts."""
    eye: int | None
    """The best eye: the first of those that see most of it; None if none sees anything of it."""
    shares: Floats
    """`(k,)`: from each eye."""
    points: Floats
    """`(n, 3)`: the points that were looked at, metres, world."""
    seen: npt.NDArray[np.bool_]
    """`(k, n)`: which eye sees which point."""
    hidden_by: tuple[tuple[str, float], ...]
    """Paths of the parts in front of the points that the best eye does not see, with their shares of all points, the
    largest first."""

    def to_dict(self) -> dict[str, Any]:
        """As JSON, without the points."""
        row = {name: value for name, value in vars(self).items() if name not in ("points", "seen")}
        return {**row, "shares": self.shares.tolist(), "hidden_by": [list(each) for each in self.hidden_by]}


class Sight(OldAttributes, Sequence[Seen]):
    """How much is seen of each target. See `sight`."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"to_dict": "to_dicts"}

    def __init__(self, rows: Iterable[Seen]) -> None:
        found = check_list("rows", rows, "a list of feeler.Seen")
        self._rows = tuple(check_kind("rows", row, Seen) for row in found)

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Seen: ...
    @overload
    def __getitem__(self, index: slice) -> Sight: ...
    def __getitem__(self, index: int | slice) -> Seen | Sight:
        return Sight(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[Seen]:
        return iter(self._rows)

    def __repr__(self) -> str:
        return f"Sight({sum(row.eye is not None for row in self)} of {len(self)} targets are seen)"

    def to_dicts(self) -> list[dict[str, Any]]:
        """A dict of plain Python values for each row."""
        return [row.to_dict() for row in self._rows]


def sight(
    scene: Scene,
    targets: Fasteners | PartsLike | npt.ArrayLike,
    eyes: npt.ArrayLike,
    *,
    samples: int = SAMPLES,
    progress: Progress | None = None,
) -> Sight:
    """How much of each target is seen from each of `eyes` `(k, 3)`, metres, world, by exact rays.

    `targets`: `Fasteners`, of whose heads the faces towards the tool are looked at; parts, as `Parts.select` takes
    them, each a target; or points `(n, 3)`, metres, each a target. Of a fastener or part `samples` points are taken,
    evenly by area and always the same. A point is seen if nothing is between it and the eye, the part's own faces
    included. Eyes inside of a closed part see nothing but it. For a region of eyes, give points in it, as `eyes_in`
    does.

    Raises `OptionError` for other shapes, parts that are not there, and eyes or points that are not finite.
    """
    check_kind("scene", scene, Scene)
    check_progress(progress)
    places = check_array("eyes", eyes, (None, 3))
    if not len(places):
        raise OptionError("there are no eyes: give points (k, 3), metres")
    count = check_whole("samples", samples, 1, 100_000)
    rows = []
    looked = list(_targets(scene, targets, count))
    for number, (part, path, points) in enumerate(looked):
        rows.append(_seen(scene, number, part, path, points, places))
        if progress is not None:
            progress((number + 1) / len(looked), "looking at targets")
    return Sight(rows)


def eyes_in(lower: npt.ArrayLike, upper: npt.ArrayLike, count: int = 64) -> Floats:
    """Points `(count, 3)` evenly in a box between two corners, metres, always the same: where a head may be."""
    low, high = check_array("lower", lower, (3,)), check_array("upper", upper, (3,))
    if not (low <= high).all():
        raise OptionError(f"lower is {shown(lower)} and upper is {shown(upper)}: give the corners in this order")
    number = np.arange(1, check_whole("count", count, 1, 1_000_000) + 1)
    shares = np.stack([_halton(number, base) for base in (2, 3, 5)], axis=1)
    return np.asarray(low + shares * (high - low))


def _halton(number: Ints, base: int) -> Floats:
    """The radical inverse of numbers: evenly in 0 to 1."""
    left, share, found = number.copy(), 1.0, np.zeros(len(number))
    while left.any():
        share /= base
        found += share * (left % base)
        left //= base
    return found


def _targets(
    scene: Scene, targets: Fasteners | PartsLike | npt.ArrayLike, count: int
) -> Iterator[tuple[int | None, str, Floats]]:
    mockup = scene.mockup
    given: Any = targets
    if isinstance(given, Fasteners):
        meshes = PartMeshes(mockup)
        for row in given:
            if not (row.part < mockup.part_count and mockup.part_paths[row.part] == row.path):
                raise OptionError(f"fastener {row.path!r} is of another mock-up: find those of the scene's")
            yield row.part, row.path, _spread(_head(meshes.corners(row.part), row), count)
        return
    if isinstance(given, (list, tuple, np.ndarray)) and _has_rows(given):
        for number, point in enumerate(check_array("targets", given, (None, 3))):
            yield None, f"point {number}", point[None]
        return
    meshes = PartMeshes(mockup)
    for part in mockup.parts.select(given).tolist():
        yield part, mockup.part_paths[part], _spread(meshes.corners(part), count)


def _has_rows(given: Sequence[Any] | npt.NDArray[Any]) -> bool:
    if isinstance(given, np.ndarray):
        return given.ndim >= 2
    return any(isinstance(each, (list, tuple, np.ndarray)) for each in given)


def _head(corners: Floats, row: Fastener) -> Floats:
    """The triangles of a head that face the tool; all of its triangles if there are none."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    along = cross @ row.axis
    height = (corners.mean(axis=1) - row.frame[:3, 3]) @ row.axis
    deep = row.head_height if np.isfinite(row.head_height) else row.size
    towards = (np.abs(along) > HEAD_SLOPE * length) & (height > -deep if np.isfinite(deep) else height > -np.inf)
    # Meshes wound inside out have their outer faces along the axis, too: the side with more of them at the top is it.
    top = towards & (height > -0.25 * deep if np.isfinite(deep) else towards)
    sign = 1.0 if along[top].sum() >= 0.0 else -1.0
    kept = towards & (sign * along > 0.0)
    return corners[kept] if kept.any() else corners


def _spread(corners: Floats, count: int) -> Floats:
    """Points evenly by area on triangles, inside of them, always the same."""
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = np.cumsum(area)
    if not len(total) or not total[-1] > 0.0:
        return np.empty((0, 3))
    number = np.arange(1, count + 1)
    which = np.searchsorted(total, (number - 0.5) / count * total[-1])
    # Squeezed, so that no point is on an edge.
    u, v = (1e-3 + 0.998 * _halton(number, base) for base in (2, 3))
    root = np.sqrt(u)
    weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1)
    return np.asarray(np.einsum("nk,nki->ni", weights, corners[which]))


def _seen(scene: Scene, number: int, part: int | None, path: str, points: Floats, eyes: Floats) -> Seen:
    shape = (len(eyes), len(points))
    is_seen = np.zeros(shape, dtype=bool)
    owners = np.full(shape, -1, dtype=np.int64)
    at_once = max(1, MOST_RAYS // max(1, len(points)))
    for begin in range(0, len(eyes), at_once):
        some = eyes[begin : begin + at_once]
        ways = points[None] - some[:, None]
        far = np.linalg.norm(ways, axis=2)
        is_there = far > 0.0
        ways[~is_there] = [1.0, 0.0, 0.0]  # the eye is on the point, and sees it
        hits = scene.rays(np.repeat(some, len(points), axis=0), ways.reshape(-1, 3))
        distances = np.asarray(hits.distances).reshape(far.shape)
        scale = np.maximum(np.abs(points).max(initial=0.0), np.abs(some).max(initial=0.0))
        is_free = distances >= far - NEAR_REL * np.maximum(far, scale)
        is_seen[begin : begin + at_once] = is_free | ~is_there
        owners[begin : begin + at_once] = np.where(is_free, -1, np.asarray(hits.parts).reshape(far.shape))
    shares = is_seen.mean(axis=1) if shape[1] else np.zeros(shape[0])
    best = int(np.argmax(shares))
    counts = Counter(int(each) for each in owners[best] if each >= 0)
    hidden = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return Seen(
        number,
        part,
        path,
        float(shares[best]),
        best if shares[best] > 0.0 else None,
        shares,
        points,
        is_seen,
        tuple((scene.mockup.part_paths[each], many / shape[1]) for each, many in hidden),
    )
