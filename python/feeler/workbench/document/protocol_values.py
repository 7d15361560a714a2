"""Points, cameras, stale parts and patterns in messages: a part of `protocol.py`."""

from __future__ import annotations

from typing import Literal, TypedDict

Vec3 = tuple[float, float, float]


class CameraPlace(TypedDict):
    """Where a camera is, and what it looks at."""

    position: Vec3
    target: Vec3
    up: Vec3
    fov_rad: float
    """Vertical field of view."""


class Camera(CameraPlace, total=False):
    """A camera."""

    is_parallel: bool
    """Parallel projection, as high at the target as the perspective view; absent: perspective."""


class StalePart(TypedDict):
    """How a part differs from the one of the revision that a result was computed on."""

    change: Literal["changed", "moved", "new"]


class LeftPattern(TypedDict):
    """A pattern that does not name a part any more, as that has another name: its paths now and before."""

    pattern: str
    of: Literal["requirement", "rule"]
    part: str
    was: str
