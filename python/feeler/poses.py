"""Repair of poses that rounding made slightly non-rigid; rotation vectors, and interpolation between poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol, TypeAlias, cast, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import UNREADABLE, check_number, shown, unmasked
from feeler.errors import PoseError

Floats = npt.NDArray[np.float64]


class HasMatrix(Protocol):
    """A transform of another library, such as SciPy's `RigidTransform`."""

    def as_matrix(self) -> npt.NDArray[Any]:
        """`(4, 4)`, or `(n, 4, 4)` for several."""
        ...


class HasArray(Protocol):
    """An array of another library, such as a tensor."""

    def __array__(self) -> npt.NDArray[Any]:
        """As NumPy reads it."""
        ...


# Without npt.ArrayLike, which takes text and numbers, and under which a type checker finds no type for rows of whole
# and other numbers mixed.
_Matrix: TypeAlias = npt.NDArray[Any] | Sequence[Sequence[float]] | HasArray | HasMatrix
PoseLike: TypeAlias = _Matrix | tuple[_Matrix, npt.NDArray[Any] | Sequence[float] | HasArray]
"""A pose: `(4, 4)` numbers, row by row; an object with `as_matrix()`; or a pair of a rotation (`(3, 3)`, or an object
with `as_matrix()`) and a translation `(3,)`."""
PosesLike: TypeAlias = npt.NDArray[Any] | HasArray | HasMatrix | Sequence[PoseLike]
"""Many poses: `(n, 4, 4)`, an object whose `as_matrix()` gives that, or a list of poses."""

MAX_DEVIATION = 0.01
"""The most that `nearest_rigid` takes for rounding: three decimals are within it, a scale of 1 % is not."""

_RIGID = 1e-14  # deviation of a rotation whose entries were rounded to float64: nothing to repair
_FARTHEST = 1e100  # the largest entry of a pose of a query
QUERY_DEVIATION = 1e-6
"""The most by which the pose of a query may be not rigid."""
_LEAST_RANK = 1e-9  # second to first singular value; below it all rows are on one line and define no rotation


_ONE = "a matrix (4, 4), or a pair of a rotation (3, 3) and a translation (3,)"


def plain(pose: object) -> object:
    """A pose as NumPy reads it: a pair of rotation and translation, or an object with `as_matrix()`, becomes a matrix;
    all else is unchanged. Raises PoseError for a pair of other shapes, and for lists that NumPy cannot read."""
    if isinstance(pose, (tuple, list)):
        if len(pose) != 2:
            return _read(pose, "a pose", _ONE)
        try:
            turn, shift = (np.asarray(plain(each)) for each in pose)
        except UNREADABLE:
            raise PoseError(f"a pose is {shown(pose)}: give {_ONE}") from None
        if isinstance(pose, list) and turn.shape == shift.shape:
            return pose  # rows of numbers
        if turn.shape != (3, 3) or shift.shape != (3,):
            raise PoseError(
                f"a pose is a pair of shapes {turn.shape} and {shift.shape}: give a rotation (3, 3) and a translation "
                "(3,), or one matrix (4, 4)"
            )
        if turn.dtype.kind not in "fiu" or shift.dtype.kind not in "fiu":
            raise PoseError(f"a pose is a pair of dtypes {turn.dtype} and {shift.dtype}: real numbers are needed")
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, shift
        return matrix
    refuse_masked("a pose", pose)
    return pose if isinstance(pose, np.ndarray) or not hasattr(pose, "as_matrix") else pose.as_matrix()


def plain_each(poses: object) -> object:
    """Many poses as NumPy reads them. Raises PoseError for lists that it cannot read."""
    if not isinstance(poses, (list, tuple)):
        return plain(poses)
    if not len(poses):
        return np.zeros((0, 4, 4))  # as a comprehension gives where nothing is left
    if len(poses) == 2:
        shapes = _shapes(poses)
        if shapes == [(3, 3), (3,)]:
            raise PoseError("poses are one pose, a pair of rotation and translation: give a list of poses, [pose]")
        if [shape[1:] for shape in shapes] == [(3, 3), (3,)]:
            raise PoseError(
                f"poses are a pair of shapes {shapes[0]} and {shapes[1]}: give a list of pairs, "
                "list(zip(rotations, translations))"
            )
    plains = [plain(pose) for pose in poses]
    return _read(plains, "poses", f"a list of poses, each {_ONE}")


def one_pose(pose: PoseLike, name: str = "a pose") -> Floats:
    """One pose `(4, 4)` of any kind that queries take; it may be not rigid. Raises `PoseError` with its name."""
    try:
        given = plain(pose)
    except PoseError as error:
        raise PoseError(str(error).replace("a pose", name, 1)) from None
    array = _read(given, name, _ONE)
    if array.dtype.kind not in "fiu":
        raise PoseError(f"{name} is {shown(pose)}: give real numbers, {_ONE}")
    if array.ndim == 3 and array.shape[1:] == (4, 4):
        raise PoseError(f"{name} has shape {array.shape}, which are {len(array)} poses: (4, 4) is needed, one pose")
    if array.shape != (4, 4):
        raise PoseError(f"{name} has shape {array.shape}: (4, 4) is needed")
    with np.errstate(over="ignore"):  # a long double beyond float64 becomes an infinity, which is refused
        matrix: Floats = array.astype(np.float64)
    return matrix


def refuse_masked(name: str, values: object) -> None:
    """Raises `PoseError` for poses with masked entries."""
    unmasked(name, values, PoseError)


def _read(values: object, name: str, give: str) -> npt.NDArray[Any]:
    """As an array, without NumPy's own words for what it cannot read."""
    refuse_masked(name, values)
    try:
        return np.asarray(values)
    except UNREADABLE as error:
        shapes = _shapes(values[:4]) if isinstance(values, (list, tuple)) else []
        found = f"entries of shapes {', '.join(map(str, shapes))}" if shapes else shown(values)
        more = ", ..." if shapes and len(values) > 4 else ""  # type: ignore[arg-type]
        raise PoseError(f"{name} cannot be read as numbers, with {found}{more}: give {give}") from error


def _shapes(values: Sequence[object]) -> list[tuple[int, ...]]:
    """Those of the entries; none for those that NumPy cannot read."""
    try:
        return [np.shape(cast("npt.ArrayLike", plain(each))) for each in values]
    except (PoseError, *UNREADABLE):
        return []


@overload  # of its own, or a type checker finds no type for rows of whole and other numbers mixed
def nearest_rigid(pose: Sequence[Sequence[float]], max_deviation: float = MAX_DEVIATION) -> Floats: ...
@overload
def nearest_rigid(pose: PoseLike | PosesLike, max_deviation: float = MAX_DEVIATION) -> Floats: ...
def nearest_rigid(pose: PoseLike | PosesLike, max_deviation: float = MAX_DEVIATION) -> Floats:
    """The pose, or each of many, with its rotation replaced by the nearest proper one, and 0, 0, 0, 1 as its last row.

    `pose` is `(4, 4)` or `(n, 4, 4)`, world_from_tool, metres; the result has the same shape, float64. Translations and
    poses that are rigid to rounding do not change. Nearest means the least sum of squared differences, found by
    singular value decomposition (K. Arun, T. Huang, S. Blostein: Least-squares fitting of two 3-D point sets, 1987).

    `max_deviation`: the most by which the product of two rows may miss 1 (of a row with itself) or 0 (of two), and the
    last row 0, 0, 0, 1. A mirror counts as 2. Larger values accept scales, shears and mirrors.

    Raises `PoseError` with the index for larger deviations, entries that are not finite, a rotation whose rows are all
    on one line, and another shape or dtype; `OptionError` if `max_deviation` is negative or NaN.
    """
    max_deviation = check_number("max_deviation", max_deviation, "a number, at least 0", least=0.0, is_endless=True)
    given = _matrices(pose)
    poses = given.reshape(-1, 4, 4)
    names = ["the pose"] if given.ndim == 2 else [f"poses[{i}]" for i in range(len(poses))]
    finite = np.isfinite(poses)
    if not finite.all():
        i, row, column = (int(x) for x in np.argwhere(~finite)[0])
        raise PoseError(f"{names[i]}: entry [{row}, {column}] is {poses[i, row, column]}: every entry must be finite")
    deviation = _deviation(poses)
    bad = np.flatnonzero(~(deviation <= max_deviation))
    if len(bad):
        i = int(bad[0])
        raise PoseError(
            f"{names[i]} is not rigid: it deviates by {deviation[i]:.3g} (max_deviation is "
            f"{max_deviation:g}); give a rotation without scale, shear or mirror"
        )
    repaired = poses.copy()
    loose = np.flatnonzero(deviation > _RIGID)
    if len(loose):
        u, sizes, v = np.linalg.svd(poses[loose, :3, :3])
        for i, each in zip(loose.tolist(), sizes, strict=True):
            if not each[1] > _LEAST_RANK * each[0]:
                raise PoseError(f"{names[i]}: the rows of its rotation are on one line, so that no rotation is nearest")
        u[:, :, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
        repaired[loose, :3, :3] = u @ v
    repaired[:, 3] = 0.0, 0.0, 0.0, 1.0
    shaped: Floats = repaired.reshape(given.shape)
    return shaped


def not_rigid(poses: Floats) -> int | None:
    """The index of the first of these poses, `(n, 4, 4)`, that queries refuse; None if they take all."""
    with np.errstate(invalid="ignore", over="ignore"):
        is_rigid = (_deviation(poses) <= QUERY_DEVIATION) & (np.abs(poses) <= _FARTHEST).all(axis=(1, 2))
    return None if is_rigid.all() else int(np.argmin(is_rigid))


def placed(points: Floats, place: PoseLike, what: str) -> Floats:
    """Points `(n, 3)` moved by a rigid matrix `(4, 4)`, computed exactly like a tool's corners at a pose.

    Raises `PoseError` for a place that a query would refuse; `what` names it in the message.
    """
    matrix = one_pose(place, f"the place of {what}")
    if not np.isfinite(matrix).all() or not _deviation(matrix[None])[0] <= QUERY_DEVIATION:
        raise PoseError(
            f"the place of {what} is not a rigid (4, 4) matrix: give a rotation without scale, shear or mirror; "
            "feeler.nearest_rigid(place) repairs rounding"
        )
    (x, y, z), r = points.T, matrix[:3, :3]
    return np.column_stack([((r[i, 0] * x + r[i, 1] * y) + r[i, 2] * z) + matrix[i, 3] for i in range(3)])


def quaternion(turn: Floats) -> list[float]:
    """(x, y, z, w) of a rotation `(3, 3)`, from its largest component, which avoids cancellation."""
    m = turn
    squares = [m[0, 0] - m[1, 1] - m[2, 2], m[1, 1] - m[0, 0] - m[2, 2], m[2, 2] - m[0, 0] - m[1, 1], m.trace()]
    most = int(np.argmax(squares))
    rows = [
        [1 + squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
        [m[1, 0] + m[0, 1], 1 + squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
        [m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], 1 + squares[2], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1 + squares[3]],
    ]
    q = np.array(rows[most])
    found: list[float] = (q / np.linalg.norm(q)).tolist()
    return found


def inverse(pose: Floats) -> Floats:
    """The rigid inverse."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -(pose[:3, :3].T @ pose[:3, 3])
    return back


def rotation_vector(turn: Floats) -> Floats:
    """Axis times angle (radians, at most pi) of a rotation `(3, 3)`."""
    x, y, z, w = quaternion(turn)
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    axis = np.array([x, y, z])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-15:
        return np.zeros(3)
    return axis / sine * (2.0 * math.atan2(sine, w))


def rotation(vector: Floats) -> Floats:
    """The rotation `(3, 3)` of an axis times an angle (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-300:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Floats = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)
    return turn


def between(start: Floats, end: Floats, centre: Floats, share: float) -> Floats:
    """The pose at a share of the motion: `centre` (of the tool, its frame) moves straight, the tool turns the shorter
    way.

    This is the motion of `Scene.cast`.
    """
    if share <= 0.0:
        return start
    if share >= 1.0:
        return end
    turn = rotation_vector(end[:3, :3] @ start[:3, :3].T)
    pose = np.eye(4)
    pose[:3, :3] = rotation(share * turn) @ start[:3, :3]
    first, last = (p[:3, :3] @ centre + p[:3, 3] for p in (start, end))
    pose[:3, 3] = first + share * (last - first) - pose[:3, :3] @ centre
    return nearest_rigid(pose)


def pose_stack(poses: PoseLike | PosesLike, name: str) -> Floats:
    """Many poses `(n, 4, 4)`, or one as the only; they may be not rigid. Raises `PoseError` with their name."""
    try:
        return _matrices(poses).reshape(-1, 4, 4)
    except PoseError as error:
        raise PoseError(f"{name}: {error}") from None


def _matrices(pose: PoseLike | PosesLike) -> Floats:
    """One pose `(4, 4)`, or many `(n, 4, 4)`."""
    is_pair = isinstance(pose, (tuple, list)) and len(pose) == 2 and _shapes(pose) == [(3, 3), (3,)]
    array = _read(plain(pose) if is_pair else plain_each(pose), "a pose", _ONE)
    if array.dtype.kind not in "fiu":
        raise PoseError(f"a pose is {shown(pose)}: give real numbers, (4, 4) or (n, 4, 4)")
    if array.ndim not in (2, 3) or array.shape[-2:] != (4, 4):
        raise PoseError(f"a pose has shape {array.shape}: (4, 4) or (n, 4, 4) is needed")
    with np.errstate(over="ignore"):  # a long double beyond float64 becomes an infinity, which is refused
        matrices: Floats = array.astype(np.float64)
    return matrices


def _deviation(poses: Floats) -> Floats:
    """How far each pose is from rigid, (n,): the same measure that queries apply."""
    rotations = poses[:, :3, :3]
    with np.errstate(over="ignore", invalid="ignore"):  # of enormous entries; NaN is more than any deviation allowed
        products = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
        mirrors = np.linalg.det(rotations) < 0
    last = np.abs(poses[:, 3] - [0.0, 0.0, 0.0, 1.0]).max(axis=1, initial=0.0)
    deviation: Floats = np.maximum(np.maximum(products, last), np.where(mirrors, 2.0, 0.0))
    deviation[np.isnan(deviation)] = np.inf
    return deviation


def rotation_xyz(rx_deg: float, ry_deg: float, rz_deg: float) -> Floats:
    """Rotation about the world's x, then y, then z axis: Rz @ Ry @ Rx, (3, 3). Quarter turns are exact."""
    (cx, sx), (cy, sy), (cz, sz) = (_cos_sin(angle) for angle in (rx_deg, ry_deg, rz_deg))
    rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    result: Floats = rz @ ry @ rx + 0.0  # turns negative zeros into zeros
    return result


def _cos_sin(angle_deg: float) -> tuple[float, float]:
    turn = math.fmod(angle_deg, 360.0)
    if turn % 90.0 == 0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(turn // 90) % 4]
    return math.cos(math.radians(turn)), math.sin(math.radians(turn))
