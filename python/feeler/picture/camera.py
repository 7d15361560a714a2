"""Camera and section plane of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_list, check_number, check_whole, shown
from feeler.choices import UpAxis
from feeler.errors import OptionError
from feeler.source import Source

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A perspective camera.

    eye, target: (3,) metres, world. up: (3,), the up direction of the picture. fov_deg: vertical field of view.
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    fov_deg: float = 26.0

    def __post_init__(self) -> None:
        for name in ("eye", "target", "up"):
            check_array(name, getattr(self, name), (3,))
        _check_fov(self.fov_deg)

    @classmethod
    def framing(
        cls,
        points: npt.ArrayLike,
        direction: npt.ArrayLike = (-0.55, 0.75, -0.42),
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        *,
        size: tuple[int, int] = (1600, 1000),
        fov_deg: float = 26.0,
        box: tuple[float, float, float, float] = (0.04, 0.04, 0.92, 0.92),
    ) -> Camera:
        """The camera that looks along `direction` and fits all of `points` (n, 3) into a box of the picture.

        size: of the picture, pixels. box: left, top, width, height as shares of the picture, 0 to 1.
        """
        cloud = check_array("points", np.atleast_2d(check_array("points", points, (None, 3))), (None, 3))
        if not len(cloud):
            raise OptionError("points is empty: give at least one")
        forward = _unit(direction, "direction")
        right, true_up = _right_up(forward, _unit(up, "up"))
        size, box = check_size(size), check_box(box)
        _check_fov(fov_deg)
        half = np.tan(np.radians(fov_deg) / 2)
        centre = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
        z = (cloud - centre) @ forward
        # A point at z is inside where low (z + d) <= x - e <= high (z + d), with d the distance and e the sideways
        # place of the eye: each side bounds e, and the two bounds meet at the least distance.
        bounds = []
        distance = max(float(-z.min()) * 1.01, 1e-6)
        for axis, begin, share, reach in (
            (right, box[0], box[2], half * size[0] / size[1]),
            (-true_up, box[1], box[3], half),
        ):
            along = (cloud - centre) @ axis
            low, high = (2 * begin - 1) * reach, (2 * (begin + share) - 1) * reach
            least, most = float(np.max(along - high * z)), float(np.min(along - low * z))
            distance = max(distance, (least - most) / (high - low))
            bounds.append((axis, low, high, least, most))
        eye = centre - forward * distance
        for axis, low, high, least, most in bounds:
            eye = eye + axis * ((least - high * distance) + (most - low * distance)) / 2
        return cls(triple(eye), triple(eye + forward * distance), triple(up), fov_deg)

    def shares(self, points: npt.ArrayLike, size: tuple[int, int]) -> FloatArray:
        """The image of points (n, 3), (n, 2): shares of width and height from the left and from the top."""
        right, up, forward = self.axes()
        size = check_size(size)
        away = check_array("points", points, (None, 3)) - np.asarray(self.eye)
        half = np.tan(np.radians(self.fov_deg) / 2) * np.maximum(away @ forward, 1e-12)
        x = away @ right / half * size[1] / size[0]
        return np.stack([(1 + x) / 2, (1 - away @ up / half) / 2], axis=1)

    def axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Unit vectors right, up, forward, in the world. Raises `OptionError` if eye and target coincide."""
        forward = _unit(np.subtract(self.target, self.eye), "camera target minus eye")
        right, up = _right_up(forward, np.asarray(self.up, dtype=np.float64))
        return right, up, forward


def upright_frame(up: UpAxis) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What is to the right, to the back and up in the view from the front: as `viewFrame` of the page has it."""
    right, ahead, above = _FRAMES[up]
    return np.array(right), np.array(ahead), np.array(above)


_FRAMES: dict[UpAxis, tuple[tuple[float, float, float], ...]] = {
    "x": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    "y": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    "z": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
}


def vertical_of(mesh: object) -> UpAxis:
    """The axis that stands upright in pictures of a mesh, as in the page; z for one that does not say it."""
    source = getattr(mesh, "source", None)
    return source.vertical if isinstance(source, Source) else "z"


def usual_view(bounds: npt.ArrayLike, up: UpAxis) -> tuple[FloatArray, FloatArray]:
    """Direction and up for a box (2, 3): from the front and above, its longer horizontal side across."""
    right, ahead, above = upright_frame(up)
    width, depth = np.abs(np.diff(np.asarray(bounds, dtype=np.float64), axis=0)[0] @ np.stack([right, ahead]).T)
    across, along = (0.55, 0.75) if width >= depth else (0.75, 0.55)
    return across * right + along * ahead - 0.42 * above, above


@dataclass(frozen=True)
class Section:
    """A section plane: it removes the side that its normal points to.

    point: (3,) metres, on the plane. normal: (3,), of any length. Cut solids are closed, in a dark shade of their
    colour.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        check_array("point", self.point, (3,))
        _unit(self.normal, "normal")

    def plane(self) -> tuple[FloatArray, float]:
        """Unit normal n and offset d; points with n.x > d are removed."""
        normal = _unit(self.normal, "section normal")
        return normal, float(normal @ np.asarray(self.point, dtype=np.float64))


def _unit(vector: npt.ArrayLike, what: str) -> FloatArray:
    array = check_array(what, vector, (3,))
    largest = float(np.abs(array).max())
    if largest == 0.0:
        raise OptionError(f"{what} is zero: give three numbers, not all zero")
    array = array / largest  # squares of large numbers are infinite
    return np.asarray(array / np.sqrt(array @ array))


MOST_PIXELS = 16_384


def check_size(size: object, least: int = 1, most: int = MOST_PIXELS) -> tuple[int, int]:
    """Width and height of a picture, pixels. Raises `OptionError`."""
    sides = check_list("size", size, "a width and a height, pixels")
    if len(sides) != 2:
        raise OptionError(f"size is {shown(size)}: give a width and a height, pixels")
    width, height = (check_whole(what, side, least, most, " pixels") for what, side in zip(_SIDES, sides, strict=True))
    return width, height


_SIDES = ("size: the width", "size: the height")


def check_box(box: object) -> tuple[float, float, float, float]:
    """Left, top, width and height as shares of a picture. Raises `OptionError`."""
    left, top, width, height = check_array("box", box, (4,)).tolist()
    if min(left, top) < 0.0 or min(width, height) <= 0.0 or max(left + width, top + height) > 1.0 + 1e-9:
        raise OptionError(f"box is {shown(box)}: give left, top, width and height within the picture, 0 to 1")
    return left, top, width, height


def _check_fov(fov_deg: object) -> None:
    check_number("fov_deg", fov_deg, "degrees, between 0 and 180", above=0.0, most=179.0)


def _right_up(forward: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
    right = np.cross(forward, up)
    if np.sqrt(right @ right) < 1e-9 * max(float(np.sqrt(up @ up)), 1e-300):
        right = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    right /= np.sqrt(right @ right)
    return right, np.cross(right, forward)


def triple(vector: npt.ArrayLike) -> tuple[float, float, float]:
    """Three numbers for a camera or a section."""
    x, y, z = (float(c) for c in np.asarray(vector, dtype=np.float64))
    return x, y, z
