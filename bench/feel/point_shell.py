"""A baseline: a point shell in a voxel grid.

After W. A. McNeely, K. D. Puterbaugh and J. J. Troy, Six degree-of-freedom haptic rendering using voxel sampling,
SIGGRAPH 1999.

The mock-up becomes a grid of voxels: free, surface, interior. The tool becomes points, one in the middle of each voxel
of its own surface, with normals inwards. A point in a surface voxel (or inside) touches the plane through that voxel's
middle across its own normal; the depth behind it gives the force (the paper's tangent-plane force). With more than ten
points in contact the stiffness is shared, as in the paper. As there, the felt surface is up to half a voxel off the
true one, and a motion of more than half a voxel per tick can pass through a thin object. Not included: the layer of
voxels around the surface that keeps the true surfaces apart, and the braking before a contact. Written to be simple,
not fast.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import feeler

from .faces import TICK_S, PlainCoupling, PlainStep, VirtualTool
from .meshes import Floats
from .poses import placed

STIFFNESS_N_PER_M = 1000.0  # of a point
SHARED_FROM = 10  # points; beyond, they share the stiffness
VOXELS_PER_TOOL = 30  # along the tool's diagonal, unless a size is given
MOST_FLOODED = 8_000_000  # voxels


class VoxelGrid:
    """A mesh as voxels: surface and interior. Kept as sorted numbers of the voxels that hold anything.

    What is enclosed is looked for in grids of up to `MOST_FLOODED` voxels; a larger one has its surface alone.
    """

    def __init__(self, vertices: Floats, faces: npt.NDArray[np.integer], size: float) -> None:
        self.size = size
        self.origin = vertices.min(axis=0) - 2.5 * size
        self.shape = tuple(int(n) for n in np.ceil((vertices.max(axis=0) - self.origin) / size + 2.5))
        surface = np.unique(self._number(self.index(surface_samples(vertices, faces, 0.7 * size))))
        if math.prod(self.shape) <= MOST_FLOODED:
            free = np.ones(math.prod(self.shape), dtype=bool)
            free[surface] = False
            self.filled = np.flatnonzero(~flooded(free.reshape(self.shape)).ravel())
        else:
            self.filled = surface

    def index(self, points: Floats) -> npt.NDArray[np.int64]:
        """The voxels of points (n, 3)."""
        return np.asarray(np.floor((points - self.origin) / self.size), dtype=np.int64)

    def middle(self, index: npt.NDArray[np.int64]) -> Floats:
        """The middles of voxels."""
        return np.asarray(self.origin + (index + 0.5) * self.size)

    def is_filled(self, index: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Whether voxels are of the surface or enclosed by it; beyond the grid nothing is."""
        inside = ((index >= 0) & (index < self.shape)).all(axis=1)
        number = np.where(inside, self._number(index), -1)
        at = np.searchsorted(self.filled, number)
        return np.asarray(self.filled[np.minimum(at, len(self.filled) - 1)] == number)

    def _number(self, index: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        return np.asarray((index[:, 0] * self.shape[1] + index[:, 1]) * self.shape[2] + index[:, 2])


def surface_samples(vertices: Floats, faces: npt.NDArray[np.integer], spacing: float) -> Floats:
    """Points on every triangle, no farther from each other than about `spacing`."""
    return _samples(vertices, faces, spacing)[0]


def _samples(vertices: Floats, faces: npt.NDArray[np.integer], spacing: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Points in rows along each triangle's longest edge, at most `spacing` apart, and the triangle that each is of."""
    corners = vertices[faces]
    edges = np.sqrt(((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2))
    longest, which = edges.argmax(axis=1), np.arange(len(faces))
    a, b, c = (corners[which, (longest + k) % 3] for k in range(3))
    base = edges[which, longest]
    height = np.sqrt((np.cross(b - a, c - a) ** 2).sum(axis=1)) / np.maximum(base, 1e-300)
    # powers of two, so that there are few kinds of rows
    counts = 2 ** np.ceil(np.log2(np.maximum(np.stack([base, height], axis=1) / spacing, 1.0))).astype(np.int64)
    found, owner = [], []
    for along, up in np.unique(counts, axis=0):
        chosen = np.flatnonzero((counts == (along, up)).all(axis=1))
        u, v = np.meshgrid(np.arange(along + 1) / along, np.arange(up + 1) / up)
        weights = np.stack([(1 - v) * (1 - u), (1 - v) * u, v], axis=2).reshape(-1, 3)
        own = np.stack([a[chosen], b[chosen], c[chosen]], axis=1)
        found.append(np.einsum("wk,tkx->twx", weights, own).reshape(-1, 3))
        owner.append(np.repeat(chosen, len(weights)))
    return np.concatenate(found), np.concatenate(owner)


def flooded(free: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The free voxels that can be reached from the grid's outside, over faces."""
    reached = np.zeros_like(free)
    for axis in range(3):
        for end in (0, -1):
            side = [slice(None)] * 3
            side[axis] = slice(end, None) if end else slice(0, 1)
            reached[tuple(side)] = free[tuple(side)]
    count = -1
    while count != (count := int(reached.sum())):
        for axis in range(3):
            moved_in = np.moveaxis(reached, axis, 0)
            open_in = np.moveaxis(free, axis, 0)
            for k in range(1, len(moved_in)):
                moved_in[k] |= moved_in[k - 1] & open_in[k]
            for k in range(len(moved_in) - 2, -1, -1):
                moved_in[k] |= moved_in[k + 1] & open_in[k]
    return reached


def shell_of(tool: feeler.Tool, size: float) -> tuple[Floats, Floats]:
    """Points (n, 3) and inward normals of the tool's surface: the middles of its own surface voxels."""
    vertices, faces = np.asarray(tool.vertices), np.asarray(tool.faces)
    points, owner = _samples(vertices, faces, 0.5 * size)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals = -normals / np.maximum(np.sqrt((normals**2).sum(axis=1, keepdims=True)), 1e-300)
    index = np.floor((points - vertices.min(axis=0)) / size).astype(np.int64)
    _, which = np.unique(index, axis=0, return_inverse=True)
    which = which.ravel()
    count = np.bincount(which).astype(np.float64)
    # on the surface itself: the mean of the samples in the voxel, so that a flat face stays flat
    place = np.stack([np.bincount(which, points[:, k]) for k in range(3)], axis=1) / count[:, None]
    inwards = np.stack([np.bincount(which, normals[owner, k]) for k in range(3)], axis=1)
    length = np.sqrt((inwards**2).sum(axis=1))
    kept = length > 1e-9 * count
    return place[kept], inwards[kept] / length[kept, None]


class PointShell:
    """A virtual tool on a coupling, pushed by its points that lie in the mock-up's voxels."""

    def __init__(
        self,
        scene: feeler.Scene,
        tool: feeler.Tool,
        *,
        coupling: PlainCoupling | None = None,
        stiffness_n_per_m: float = STIFFNESS_N_PER_M,
        voxel_size: float | None = None,
        seed: int = 0,
    ) -> None:
        del seed  # nothing here is random
        self.virtual = VirtualTool(tool, coupling or PlainCoupling())
        self.stiffness = stiffness_n_per_m
        size = voxel_size or 2.0 * self.virtual.size / VOXELS_PER_TOOL
        self.grid = VoxelGrid(np.asarray(scene.mockup.vertices), np.asarray(scene.mockup.faces), size)
        self.points, self.inwards = shell_of(tool, size)

    def start(self, pose: Floats) -> None:
        """Rest at a pose."""
        self.virtual.start(pose)

    def step(self, world_from_device: Floats, dt: float = TICK_S) -> PlainStep:
        """One tick."""
        force, torque, count = self.contact_wrench(self.virtual.pose)
        on_hand = self.virtual.step(world_from_device, force, torque, dt)
        return PlainStep(self.virtual.pose.copy(), *on_hand, planes=count, mode="contact" if count else "free")

    def contact_wrench(self, pose: Floats) -> tuple[Floats, Floats, int]:
        """Force and torque about the tool's middle at a pose, and how many points gave them."""
        points, inwards = placed(self.points, pose), self.inwards @ pose[:3, :3].T
        index = self.grid.index(points)
        inside = self.grid.is_filled(index)
        if not inside.any():
            return np.zeros(3), np.zeros(3), 0
        points, inwards = points[inside], inwards[inside]
        # behind the plane through the voxel's middle across the point's normal
        depth = ((self.grid.middle(index[inside]) - points) * inwards).sum(axis=1)
        depth = np.clip(depth, 0.0, None)
        count = int((depth > 0.0).sum())
        stiffness = self.stiffness * min(1.0, SHARED_FROM / max(count, 1))
        forces = stiffness * depth[:, None] * inwards
        arms = points - placed(self.virtual.middle[None], pose)[0]
        return forces.sum(axis=0), np.cross(arms, forces).sum(axis=0), count
