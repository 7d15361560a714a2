"""trimesh's collision manager, answered by feeler: `from feeler.compat.trimesh import CollisionManager`.

The methods, arguments and results are those of `trimesh.collision`, which needs python-fcl. trimesh itself is not
imported. Differences: [docs/compat.md](https://feeler.readthedocs.io/en/latest/compat/).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from threading import RLock
from typing import Any, Literal, NoReturn, TypeAlias, TypeVar, overload

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import check_flag, check_kind, check_threads, shown
from feeler.compat.meshes import Floats, affine, rigid_after, shape_of, split, triangles_of
from feeler.errors import MeshError, OptionError, PoseError
from feeler.memory import free_memory
from feeler.words import counted, plural

EXTERNAL = "__external"
"""The name of a mesh that is in no manager."""

_ANOTHER = "another feeler.compat.trimesh.CollisionManager"

Names: TypeAlias = tuple[Any, Any]
_Yes: TypeAlias = Literal[True]
_No: TypeAlias = Literal[False]
_Named = TypeVar("_Named")


class ContactData:
    """Two triangles of two objects that meet. `names` is a set, as trimesh's; `pair` has an order, for `normal`: the
    second is the mesh that was asked for, or of the other manager, or of one manager's the one that was added first."""

    def __init__(self, names: Names, triangles: tuple[int, int], point: Floats, parting: _Parting) -> None:
        self.names = set(names)
        self.pair = names
        self._triangles: dict[Hashable, int] = dict(zip(names, triangles, strict=True))
        self._point = point
        self._parting = parting

    @property
    def point(self) -> Floats:
        """A point that both triangles have, `(3,)`; if one object is inside the other, between their nearest
        triangles."""
        return self._point

    @property
    def normal(self) -> Floats:
        """The direction in which the second object of `pair` leaves the first on the shortest way found, `(3,)`, of
        length 1."""
        return self._parting.normal

    @property
    def depth(self) -> float:
        """How far that object has to be moved along `normal` until the two are apart: an upper bound of the
        least. The same for all contacts of two objects, and found when first asked for."""
        return self._parting.depth

    def index(self, name: Hashable) -> int:
        """The triangle of the object of this name."""
        return self._triangles[name]

    def __repr__(self) -> str:
        return f"<ContactData of {' and '.join(sorted(map(str, self._triangles)))} at {self._point.tolist()}>"


class DistanceData:
    """The closest triangles of two objects."""

    def __init__(self, names: Names, triangles: tuple[int, int], distance: float, points: Floats) -> None:
        self.names = set(names)
        self._triangles: dict[Hashable, int] = dict(zip(names, triangles, strict=True))
        self._points: dict[Hashable, Floats] = dict(zip(names, points, strict=True))
        self._distance = distance

    @property
    def distance(self) -> float:
        """Their distance; negative where they overlap and one is convex."""
        return self._distance

    def index(self, name: Hashable) -> int:
        """The triangle of the object of this name."""
        return self._triangles[name]

    def point(self, name: Hashable) -> Floats:
        """The closest point of the object of this name, `(3,)`; where they overlap, a point of both."""
        return self._points[name]

    def __repr__(self) -> str:
        return f"<DistanceData of {' and '.join(sorted(map(str, self._triangles)))}, {self._distance} apart>"


class _Parting:
    """The shortest translation found that parts two bodies, found when first asked for."""

    def __init__(self, bodies: _core.Bodies, others: _core.Bodies | None, pair: tuple[int, int]) -> None:
        self.pair = pair
        self._asked: tuple[_core.Bodies, _core.Bodies | None] | None = (bodies, others)
        self._found: Floats = np.zeros(3)

    def __getstate__(self) -> dict[str, Any]:
        """Found first: the bodies do not travel."""
        return {"pair": self.pair, "_asked": None, "_found": self.translation}

    @property
    def translation(self) -> Floats:
        if self._asked is not None:
            bodies, others = self._asked
            self._found = bodies.depth(*self.pair, others=others)
            self._asked = None
        return self._found

    @property
    def depth(self) -> float:
        return float(np.linalg.norm(self.translation))

    @property
    def normal(self) -> Floats:
        length = self.depth
        return self.translation / length if length > 0 else np.array([0.0, 0.0, 1.0])


class _Placed:
    """An object of a manager: its triangles, the stretch of its shape, its body, how many were added before."""

    def __init__(self, mesh: Any, transform: npt.ArrayLike | None, memory_limit: int) -> None:
        self.number = 0
        self._memory_limit = memory_limit
        self._triangles = triangles_of(mesh)
        self.body = 0
        self.shape, self.pose, self._stretch = self._at(affine(transform))

    def move(self, bodies: _core.Bodies, transform: npt.ArrayLike) -> None:
        try:
            # The common case first: a rigid transform of what is not stretched.
            moved: Any = transform if self._stretch is None else rigid_after(affine(transform), self._stretch)
            bodies.set_pose(self.body, moved)
        except PoseError:
            shape, pose, stretch = self._at(affine(transform))
            body = bodies.add(shape, pose)
            bodies.remove(self.body)
            self.shape, self.pose, self._stretch, self.body = shape, pose, stretch, body

    def _at(self, matrix: Floats) -> tuple[_core.Shape, Floats, Floats | None]:
        stretch = None
        if not _is_rigid(matrix):
            matrix, stretch = split(matrix)
        return shape_of(self._triangles, stretch, self._memory_limit), matrix, stretch


def _is_rigid(matrix: Floats) -> bool:
    linear = matrix[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.abs(linear @ linear.T - np.eye(3)).max() <= 0.9e-6 and np.linalg.det(linear) > 0)


class CollisionManager:
    """Bodies by name, each against each, as `trimesh.collision.CollisionManager`.

    `threads`: how many answer a question; None: as many as there are CPUs.

    Objects meet if two of their triangles share a point, by exact arithmetic on vertices at their transforms in
    float64; a closed convex mesh is solid, and meets what lies in it. A transform may scale, shear and mirror.
    """

    def __init__(self, *, threads: int | None = None) -> None:
        self._threads = check_threads(threads)
        self._memory_limit = free_memory() * 4 // 5
        self._bodies = _core.Bodies(self._threads, self._memory_limit)
        self._placed: dict[Hashable, _Placed] = {}
        self._names: dict[int, Hashable] = {}
        self._added = 0
        self._lock = RLock()

    def add_object(self, name: Hashable, mesh: Any, transform: npt.ArrayLike | None = None) -> int:
        """Adds an object, in place of one that has this name already.

        `mesh`: of trimesh, of FreeCAD, anything with `.vertices` and `.faces`, or a pair of these arrays. `transform`:
        `(4, 4)`, affine. Raises `MeshError`, `PoseError`, or `OptionError` for a name that is not hashable; the object
        of this name stays then.
        """
        try:
            hash(name)
        except TypeError:
            raise OptionError(f"a name that can be a key of a dict is needed, not {shown(name)}") from None
        placed = _Placed(mesh, transform, self._memory_limit)
        for kind, (count, _) in placed.shape.defects.items():
            if count and kind != "duplicate":
                warnings.warn(f"{shown(name)}: {counted(count, 'triangles')} {kind}: not queried", stacklevel=2)
        with self._lock:
            old = self._placed.get(name)
            placed.body = self._bodies.add(placed.shape, placed.pose)
            placed.number, self._added = self._added, self._added + 1
            if old is not None:
                self.remove_object(name)
            self._placed[name], self._names[placed.body] = placed, name
        return placed.body

    def remove_object(self, name: Hashable) -> None:
        """Removes an object. Raises `OptionError`, which is a `ValueError`, if there is none of this name."""
        with self._lock:
            placed = self._of(name)
            self._bodies.remove(placed.body)
            del self._placed[name], self._names[placed.body]

    def set_transform(self, name: Hashable, transform: npt.ArrayLike) -> None:
        """Moves an object to a transform, `(4, 4)`, affine. Raises `PoseError`, and `OptionError` if there is none of
        this name."""
        with self._lock:
            placed = self._of(name)
            del self._names[placed.body]
            try:
                placed.move(self._bodies, transform)
            finally:
                self._names[placed.body] = name

    @property
    def names(self) -> list[Hashable]:
        """The names of the objects, in the order in which they were added."""
        return list(self._placed)

    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_names: _No = False, return_data: _No = False
    ) -> bool: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_names: _Yes, return_data: _No = False
    ) -> tuple[bool, set[Any]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[bool, set[Any]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_names: _No, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[Any], list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[Any], list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_names: bool = False, return_data: bool = False
    ) -> bool | tuple[bool, set[Any]] | tuple[bool, list[ContactData]] | tuple[bool, set[Any], list[ContactData]]: ...
    def in_collision_single(
        self,
        mesh: Any,
        transform: npt.ArrayLike | None = None,
        return_names: bool = False,
        return_data: bool = False,
    ) -> bool | tuple[bool, set[Any]] | tuple[bool, list[ContactData]] | tuple[bool, set[Any], list[ContactData]]:
        """Whether a mesh meets any object: a bool; with `return_names` also the set of their names, with `return_data`
        also the list of `ContactData`, in which the mesh is called "__external"."""
        alone = CollisionManager(threads=self._threads)
        alone.add_object(EXTERNAL, mesh, transform)
        return self._collisions(alone, lambda pair: pair[0], return_names, return_data)

    @overload
    def in_collision_internal(self, return_names: _No = False, return_data: _No = False) -> bool: ...
    @overload
    def in_collision_internal(self, return_names: _Yes, return_data: _No = False) -> tuple[bool, set[Names]]: ...
    @overload
    def in_collision_internal(self, return_names: _No, return_data: _Yes) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_internal(
        self, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_internal(
        self, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[Names], list[ContactData]]: ...
    @overload
    def in_collision_internal(
        self, return_names: bool = False, return_data: bool = False
    ) -> (
        bool | tuple[bool, set[Names]] | tuple[bool, list[ContactData]] | tuple[bool, set[Names], list[ContactData]]
    ): ...
    def in_collision_internal(
        self, return_names: bool = False, return_data: bool = False
    ) -> bool | tuple[bool, set[Names]] | tuple[bool, list[ContactData]] | tuple[bool, set[Names], list[ContactData]]:
        """Whether any two objects meet: a bool; with `return_names` also the set of pairs of names, each sorted, with
        `return_data` also the list of `ContactData`."""
        return self._collisions(None, _sorted, return_names, return_data)

    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _No = False, return_data: _No = False
    ) -> bool: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _Yes, return_data: _No = False
    ) -> tuple[bool, set[Names]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _No, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[Names], list[ContactData]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> (
        bool | tuple[bool, set[Names]] | tuple[bool, list[ContactData]] | tuple[bool, set[Names], list[ContactData]]
    ): ...
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> bool | tuple[bool, set[Names]] | tuple[bool, list[ContactData]] | tuple[bool, set[Names], list[ContactData]]:
        """Whether any object meets one of another manager: as `in_collision_internal`, with this manager's name first
        in a pair."""
        other = check_kind("other_manager", other_manager, CollisionManager, _ANOTHER)
        return self._collisions(other, lambda pair: pair, return_names, return_data)

    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_name: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_name: _Yes, return_data: _No = False
    ) -> tuple[float, Any]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, *, return_name: _Yes, return_data: _No = False
    ) -> tuple[float, Any]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_name: _No, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_name: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None, return_name: _Yes, return_data: _Yes
    ) -> tuple[float, Any, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, *, return_name: _Yes, return_data: _Yes
    ) -> tuple[float, Any, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_name: bool = False, return_data: bool = False
    ) -> float | tuple[float, Any] | tuple[float, DistanceData | None] | tuple[float, Any, DistanceData | None]: ...
    def min_distance_single(
        self, mesh: Any, transform: npt.ArrayLike | None = None, return_name: bool = False, return_data: bool = False
    ) -> float | tuple[float, Any] | tuple[float, DistanceData | None] | tuple[float, Any, DistanceData | None]:
        """The least distance of a mesh from any object; with `return_name` also that object's name, with `return_data`
        also the `DistanceData`. Infinite, with None for both, if there is no object."""
        alone = CollisionManager(threads=self._threads)
        alone.add_object(EXTERNAL, mesh, transform)
        return self._distance(alone, None, lambda pair: pair[0], return_name, return_data)

    @overload
    def min_distance_internal(
        self, name: Hashable | None = None, return_names: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None, return_names: _Yes, return_data: _No = False
    ) -> tuple[float, Names | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None = None, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[float, Names | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None, return_names: _No, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None = None, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None, return_names: _Yes, return_data: _Yes
    ) -> tuple[float, Names | None, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None = None, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[float, Names | None, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: Hashable | None = None, return_names: bool = False, return_data: bool = False
    ) -> (
        float
        | tuple[float, Names | None]
        | tuple[float, DistanceData | None]
        | tuple[float, Names | None, DistanceData | None]
    ): ...
    def min_distance_internal(
        self, name: Hashable | None = None, return_names: bool = False, return_data: bool = False
    ) -> (
        float
        | tuple[float, Names | None]
        | tuple[float, DistanceData | None]
        | tuple[float, Names | None, DistanceData | None]
    ):
        """The least distance of any two objects, or of one, by name, from any other; with `return_names` also the two
        names, sorted, with `return_data` also the `DistanceData`. Infinite, with None for both, if there are no two
        objects."""
        with self._lock:
            one = None if name is None else self._of(name).body
            return self._distance(None, one, _sorted, return_names, return_data)

    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _Yes, return_data: _No = False
    ) -> tuple[float, Names | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _No, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _Yes, return_data: _Yes
    ) -> tuple[float, Names | None, DistanceData | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> (
        float
        | tuple[float, Names | None]
        | tuple[float, DistanceData | None]
        | tuple[float, Names | None, DistanceData | None]
    ): ...
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> (
        float
        | tuple[float, Names | None]
        | tuple[float, DistanceData | None]
        | tuple[float, Names | None, DistanceData | None]
    ):
        """The least distance of any object from one of another manager: as `min_distance_internal`, with this manager's
        name first."""
        other = check_kind("other_manager", other_manager, CollisionManager, _ANOTHER)
        return self._distance(other, None, lambda pair: pair, return_names, return_data)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a CollisionManager cannot be pickled or copied: add its objects to a new one")

    def __repr__(self) -> str:
        return f"<CollisionManager of {plural(len(self._placed), 'object')}>"

    def _of(self, name: Hashable) -> _Placed:
        try:
            return self._placed[name]
        except (KeyError, TypeError):
            raise OptionError(f"{shown(name)} is not in the collision manager") from None

    def _pair(self, other: CollisionManager | None, bodies: Sequence[int]) -> Names:
        second = self if other is None else other
        return self._names[int(bodies[0])], second._names[int(bodies[1])]

    def _collisions(
        self, other: CollisionManager | None, named: Callable[[Names], _Named], return_names: bool, return_data: bool
    ) -> bool | tuple[bool, set[_Named]] | tuple[bool, list[ContactData]] | tuple[bool, set[_Named], list[ContactData]]:
        wants_names, wants_data = check_flag("return_names", return_names), check_flag("return_data", return_data)
        with _held(self, other):
            bodies, others = self._bodies, None if other is None else other._bodies
            if wants_data:
                # What is asked for later is answered as things are now.
                bodies, others = bodies.copy(), None if others is None else others.copy()
                contacts = self._contacts(other, bodies, others)
                names = {named(pair) for pair in dict.fromkeys(pair for pair, _ in contacts)}
                found = [contact for _, contact in contacts]
                return (bool(found), names, found) if wants_names else (bool(found), found)
            if wants_names:
                names = {named(self._pair(other, pair)) for pair in bodies.meeting(others=others).tolist()}
                return bool(names), names
            return bodies.is_meeting(others=others)

    def _contacts(
        self, other: CollisionManager | None, bodies: _core.Bodies, others: _core.Bodies | None
    ) -> list[tuple[Names, ContactData]]:
        pairs, triangles, _, points = bodies.contacts(others=others)
        partings: dict[tuple[int, int], tuple[Names, _Parting]] = {}
        contacts = []
        for (first, second), (s, t), point in zip(pairs.tolist(), triangles.tolist(), points, strict=True):
            pair = (first, second)
            names, parting = partings.get(pair) or self._parting(other, bodies, others, pair)
            partings[pair] = (names, parting)
            of_names = (s, t) if parting.pair == pair else (t, s)
            contacts.append((names, ContactData(names, of_names, point, parting)))
        return contacts

    def _parting(
        self, other: CollisionManager | None, bodies: _core.Bodies, others: _core.Bodies | None, pair: tuple[int, int]
    ) -> tuple[Names, _Parting]:
        """Two names, and how the second is parted from the first; of one manager's in the order of python-fcl."""
        names = self._pair(other, pair)
        if other is None and self._placed[names[0]].number < self._placed[names[1]].number:
            names, pair = names[::-1], pair[::-1]
        return names, _Parting(bodies, others, pair)

    def _distance(
        self,
        other: CollisionManager | None,
        one: int | None,
        named: Callable[[Names], _Named],
        return_names: bool,
        return_data: bool,
    ) -> (
        float
        | tuple[float, _Named | None]
        | tuple[float, DistanceData | None]
        | tuple[float, _Named | None, DistanceData | None]
    ):
        wants_names, wants_data = check_flag("return_names", return_names), check_flag("return_data", return_data)
        with _held(self, other):
            found = self._overlap(other, one, wants_data) or self._gap(other, one)
        distance, names, data = (float("inf"), None, None) if found is None else found
        told = None if names is None else named(names)
        if wants_names:
            return (distance, told, data) if wants_data else (distance, told)
        return (distance, data) if wants_data else distance

    def _gap(self, other: CollisionManager | None, one: int | None) -> tuple[float, Names, DistanceData] | None:
        """The closest two objects."""
        found = self._bodies.closest(np.inf, one=one, others=None if other is None else other._bodies)
        if found is None:
            return None
        pair, triangles, distance, points = found
        names = self._pair(other, pair)
        return distance, names, DistanceData(names, triangles, distance, points)

    def _overlap(
        self, other: CollisionManager | None, one: int | None, wants_data: bool
    ) -> tuple[float, Names, DistanceData | None] | None:
        """The two objects that are deepest in each other, if one is convex."""
        bodies, others = self._bodies, None if other is None else other._bodies
        deepest = bodies.deepest(one=one, others=others)
        if deepest is None:
            return None
        pair, depth = deepest
        names = self._pair(other, pair)
        if not wants_data:
            return -depth, names, None
        pairs, triangles, _, points = bodies.contacts(one=one, others=others)
        at = int(np.argmax((pairs == pair).all(axis=1)))
        s, t = triangles[at].tolist()
        return -depth, names, DistanceData(names, (s, t), -depth, np.array([points[at], points[at]]))


@contextmanager
def _held(*managers: CollisionManager | None) -> Iterator[None]:
    """Keeps other threads from changing managers, always in one order."""
    with ExitStack() as held:
        for manager in sorted({id(m): m for m in managers if m is not None}.values(), key=id):
            held.enter_context(manager._lock)
        yield


def _sorted(pair: Names) -> Names:
    try:
        first, second = sorted(pair)
    except TypeError:  # names of kinds that have no order
        first, second = sorted(pair, key=lambda name: (type(name).__name__, str(name)))
    return first, second


def scene_to_collision(scene: Any) -> tuple[CollisionManager, dict[Any, int]]:
    """A manager of the objects of a `trimesh.Scene`, by node, and the number of each. A robot of yourdfpy has one in
    `.scene`.

    Raises `MeshError` for what is no scene.
    """
    if not hasattr(getattr(scene, "graph", None), "nodes_geometry"):
        raise MeshError(f"a scene of trimesh is needed, not {shown(scene)}")
    manager = CollisionManager()
    numbers = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        numbers[node] = manager.add_object(node, scene.geometry[geometry], transform)
    return manager, numbers
