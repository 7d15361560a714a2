"""Poses of a tool among the parts of a mock-up, for tests, benchmarks and demonstrations: touching, just free, deep.

An attempt takes a random point of the mock-up's surface, a random point of the tool and a random rotation, puts one
point on the other, and slides the tool along the surface's normal until the condition holds. It uses only exact answers
of the scene, so the poses depend on mock-up, tool, kind and seed alone, not on storage, voxel size or threads.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.progress import Progress

from ..arguments import check_progress, check_whole, check_word, shown
from ..choices import POSE_KINDS, PoseKind
from ..errors import MeshError, OptionError
from ..mockup import Tool
from ..scene import Scene
from . import rigid
from .mesh import Floats

KINDS = POSE_KINDS
NOMINAL_SHARE = (0.01, 0.05)  # of the tool's triangles
DEEP_SHARE = 0.10
NEAR_GAP_SHARE = 0.01  # of the tool's size: a push of this length makes a near pose collide
TRIES_PER_POSE = 60
LEAST_TRIES = 600


@dataclass(frozen=True, eq=False)
class Slide:
    """Poses of one rotation along a line: at `s` metres the tool has moved by that much outwards."""

    quaternion: Floats
    origin: Floats
    outward: Floats

    def pose(self, s: float) -> Floats:
        """The pose (4, 4) at `s`."""
        return np.asarray(rigid.matrices(self.quaternion[None], (self.origin + s * self.outward)[None])[0])


class Searcher:
    """Finds poses of one tool in one scene."""

    def __init__(self, scene: Scene, tool: Tool, rng: np.random.Generator) -> None:
        self.scene, self.tool, self.rng = scene, tool, rng
        self.mockup_bounds = np.asarray(scene.mockup.bounds, dtype=np.float64)
        bounds = np.asarray(tool.bounds, dtype=np.float64)
        self.tool_middle = bounds.mean(axis=0)
        self.size = float(np.sqrt(((bounds[1] - bounds[0]) ** 2).sum()))
        self.triangles = len(tool.faces)
        self.hits = (
            max(1, int(np.ceil(NOMINAL_SHARE[0] * self.triangles))),
            max(1, int(NOMINAL_SHARE[1] * self.triangles)),
        )

    def count(self, pose: Floats) -> int:
        """Number of colliding tool triangles."""
        return len(self.scene.collide(self.tool, pose).tool_triangles)

    def is_inside(self, pose: Floats) -> bool:
        """Whether the middle of the tool's box lies in the mock-up's box."""
        middle = pose[:3, :3] @ self.tool_middle + pose[:3, 3]
        return bool((middle >= self.mockup_bounds[0]).all() and (middle <= self.mockup_bounds[1]).all())

    def slide(self, *, tip_first: bool | None = None) -> Slide | None:
        """A random slide that starts with a point of the tool on the mock-up; None if the choice was unsuitable."""
        spot = self._surface_spot(self.scene.mockup.vertices, self.scene.mockup.faces)
        anchor = self._surface_spot(self.tool.vertices, self.tool.faces)
        if spot is None or anchor is None:
            return None
        (point, normal), (held, _) = spot, anchor
        rng = self.rng
        if rng.random() < 0.5:  # the free side is not known: meshes need not be closed
            normal = -normal
        quaternion = rigid.random_quaternion(rng)
        if tip_first if tip_first is not None else rng.random() < 0.5:
            tilt = rigid.between(np.array([0.0, 0.0, 1.0]), rigid.normalised(normal + 0.45 * rng.normal(size=3)))
            quaternion = rigid.product(tilt, rigid.about(np.array([0.0, 0.0, 1.0]), float(rng.uniform(0.0, 6.28))))
        turned = rigid.matrices(quaternion[None], np.zeros((1, 3)))[0, :3, :3] @ held
        return Slide(quaternion, point - turned, normal)

    def _surface_spot(self, vertices: Floats, faces: npt.NDArray[np.uint32]) -> tuple[Floats, Floats] | None:
        """A point on a random triangle and its normal; every other time the larger of a few triangles, by chance."""
        rng = self.rng
        pick = rng.integers(len(faces), size=1 if rng.random() < 0.5 else 24)
        chosen = faces[pick]
        inside = (chosen < len(vertices)).all(axis=1)
        if not inside.any():
            return None
        corners = vertices[chosen[inside]]
        with np.errstate(all="ignore"):
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            areas = np.sqrt((normals * normals).sum(axis=1))
        areas[~np.isfinite(areas)] = 0.0
        if not areas.sum() > 0.0:
            return None
        k = int(rng.choice(len(areas), p=areas / areas.sum()))
        a, b = np.sort(rng.random(2))
        point = corners[k, 0] * a + corners[k, 1] * (b - a) + corners[k, 2] * (1.0 - b)
        return point, normals[k] / areas[k]

    def nominal(self, slide: Slide) -> float | None:
        """The place along the slide where 1 to 5 % of the tool's triangles collide, or None."""
        low, high = self.hits
        step = 0.02 * self.size
        s, hits = 0.0, self.count(slide.pose(0.0))
        if low <= hits <= high:
            return s
        way = 1.0 if hits > high else -1.0
        last = s
        for _ in range(7):
            last, s = s, s + way * step
            hits = self.count(slide.pose(s))
            if low <= hits <= high:
                return s
            if (hits > high) != (way > 0.0):
                break
            step *= 1.8
        else:
            return None
        for _ in range(8):
            middle = 0.5 * (last + s)
            hits = self.count(slide.pose(middle))
            if low <= hits <= high:
                return middle
            if (hits > high) == (way > 0.0):
                last = middle
            else:
                s = middle
        return None

    def near(self, slide: Slide) -> float | None:
        """The place along the slide where the tool is just free: it would collide within the near gap inwards."""
        step, inner, outer = 0.01 * self.size, 0.0, 0.0
        if not self.scene.is_colliding(self.tool, slide.pose(0.0)):
            return None
        for _ in range(9):
            inner, outer = outer, outer + step
            if not self.is_inside(slide.pose(outer)):
                return None
            if not self.scene.is_colliding(self.tool, slide.pose(outer)):
                break
            step *= 1.6
        else:
            return None
        gap = NEAR_GAP_SHARE * self.size
        while outer - inner > gap:
            middle = 0.5 * (inner + outer)
            if self.scene.is_colliding(self.tool, slide.pose(middle)):
                inner = middle
            else:
                outer = middle
        return outer

    def deepest(self, slide: Slide) -> tuple[float, int]:
        """The place along the slide, out of a few, where most of the tool's triangles collide; and their number."""
        best, most = 0.0, -1
        for s in (0.0, -0.04 * self.size, -0.12 * self.size, -0.25 * self.size):
            hits = self.count(slide.pose(s))
            if hits > most:
                best, most = s, hits
            if hits > DEEP_SHARE * self.triangles or (s == 0.0 and hits < 0.01 * self.triangles):
                break
        return best, most


def sample_poses(
    scene: Scene, tool: Tool, kind: PoseKind, n: int, seed: int = 0, progress: Progress | None = None
) -> Floats:
    """Poses of a tool among the parts of a scene: `(n, 4, 4) float64`, world_from_tool, metres, rigid.

    - "nominal": 1 to 5 % of the tool's triangles collide with the mock-up (at least one triangle).
    - "near": the tool's middle is inside the mock-up's box and nothing collides, but a push of 1 % of the tool's length
      or less makes it collide.
    - "deep": more than 10 % of the tool's triangles collide; for a tool so fine that this is seldom found, the deepest
      poses of a few hundred attempts, all above 5 %.

    Works for any mock-up and tool. The same scene, tool, kind and seed give the same poses, whatever the storage.
    `progress(fraction, stage)` is called as poses are found. Raises OptionError for an unknown kind, a count that is
    not a whole number from 0, and if too few such poses are found in a bounded number of attempts.
    """
    check_word("kind", kind, KINDS)
    _check_pair(scene, tool)
    _check_count(n, 0)
    check_progress(progress)
    searcher = Searcher(scene, tool, _generator(seed, kind))
    poses: list[Floats] = []
    spare: list[tuple[int, Floats]] = []
    tries = max(LEAST_TRIES, TRIES_PER_POSE * n)
    for attempt in range(tries):
        if len(poses) == n or (attempt >= max(150, 4 * n) and len(poses) + len(spare) >= n):
            break
        slide = searcher.slide()
        if slide is None:
            continue
        if kind == "deep":
            s, hits = searcher.deepest(slide)
            if hits > DEEP_SHARE * searcher.triangles:
                poses.append(slide.pose(s))
            elif hits > NOMINAL_SHARE[1] * searcher.triangles:
                spare.append((hits, slide.pose(s)))
        else:
            found = searcher.nominal(slide) if kind == "nominal" else searcher.near(slide)
            if found is not None:
                poses.append(slide.pose(found))
        if progress:
            progress(len(poses) / max(1, n), f"finding {kind} poses")
    spare.sort(key=lambda entry: -entry[0])
    poses += [pose for _, pose in spare[: n - len(poses)]]
    if len(poses) < n:
        raise OptionError(
            f"only {len(poses)} of {n} {kind} poses were found in {tries} tries for a tool of {searcher.triangles} "
            f"triangles and {searcher.size:.3g} m; ask for fewer, or another kind, or check that tool and mock-up have "
            "the same unit"
        )
    if progress:
        progress(1.0, "done")
    return np.array(poses).reshape(-1, 4, 4)


_MOST_POSES = 10_000_000


def _check_pair(scene: object, tool: object) -> None:
    if not isinstance(scene, Scene) or not isinstance(tool, Tool):
        raise MeshError(
            f"poses need a feeler.Scene and a feeler.Tool, not {type(scene).__name__}, {type(tool).__name__}"
        )


def _check_count(n: object, least: int) -> None:
    check_whole("n", n, least, _MOST_POSES)


def _generator(seed: object, purpose: str) -> np.random.Generator:
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise OptionError(f"seed is {shown(seed)}: give a whole number, 0 or more")
    words = [int(seed) & 0xFFFFFFFF, int(seed) >> 32, zlib.crc32(purpose.encode())]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))
