"""The solid of a part for manifold3d: the union of its closed surfaces, less their hollows."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.uint64]

_HASH = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
"""Odd numbers that spread three indices over 64 bits."""

_WELD_SHARE = 2.0**-19
"""`WELD_SHARE` of the core: by this share of a part's length the corners at an open seam may be off."""

_MOST_SHARE = 1.0 + 1e-9
"""How much larger than the room it has a volume may be, by rounding."""


def solid_of(library: Any, corners: Floats, middle: Floats) -> Any:
    """The solid of triangles `(k, 3, 3)`, relative to `middle`; None if manifold3d rejects it, or it has no volume.

    Triangles count once, each surface is turned as depths take it, and what lies in two surfaces counts once. Corners
    at open seams that nearly coincide are merged.
    """
    vertices, index = _core.weld_vertices(np.ascontiguousarray(corners.reshape(-1, 3)))
    faces = _once(_without_lines(index.reshape(-1, 3).astype(np.uint64)))
    solid = _solid(library, vertices - middle, faces)
    merged = _with_seams_merged(vertices, faces) if solid is None else None
    return solid if merged is None else _solid(library, vertices - middle, _once(_without_lines(merged)))


def _solid(library: Any, vertices: Floats, faces: Faces) -> Any:
    """The solid of a mesh whose triangles share vertices; None as for `solid_of`."""
    wholes = [library.Manifold(library.Mesh64(*each)) for each in _pieces(vertices, faces)]
    if any(each.status() != library.Error.NoError for each in wholes):
        return None
    # Surfaces that share vertices are one piece. Taking many surfaces apart at once would take its time in square.
    shells = [_Shell(library, each) for whole in wholes for each in whole.decompose()]
    shells = sorted((each for each in shells if each.size > 0.0), key=lambda each: -each.size)
    if any(each.solid.status() != library.Error.NoError for each in shells):
        return None
    solid = _joined(library, shells)
    if solid is None or solid.status() != library.Error.NoError or not solid.volume() > 0.0:
        return None
    # A surface that overlaps itself would count the overlap twice.
    return solid if solid.volume() <= _MOST_SHARE * solid.hull().volume() else None


def shared_volume(one: Any, other: Any) -> float:
    """The volume that two solids share, cubic metres; NaN if it is not between 0 and the smaller."""
    volume = float((one ^ other).volume())
    least = min(one.volume(), other.volume())
    return min(volume, least) if 0.0 <= volume <= _MOST_SHARE * least else float("nan")


class _Shell:
    """A connected closed surface, turned outwards. size: its enclosed volume, cubic metres. sense: -1 if it was wound
    inwards, else 1."""

    def __init__(self, library: Any, given: Any) -> None:
        volume = given.volume()
        self.size, self.sense = abs(volume), 1 if volume > 0.0 else -1
        self.solid = given if volume > 0.0 else _flipped(library, given)
        self.low, self.high = np.array(self.solid.bounding_box()).reshape(2, 3)
        self.is_hollow = False

    def holds(self, other: _Shell) -> bool:
        """Whether another shell, of at most this size and with its box in this one's, lies in this one."""
        return bool((self.solid ^ other.solid).volume() > 0.5 * other.size)


def _joined(library: Any, shells: list[_Shell]) -> Any:
    """The union of the shells, the largest first, less the hollows; None of none."""
    if not shells:
        return None
    if len({each.sense for each in shells}) > 1:
        bodies = _without_hollows(library, shells)
    else:
        bodies = [each.solid for each in shells]
    return bodies[0] if len(bodies) == 1 else library.Manifold.batch_boolean(bodies, library.OpType.Add)


def _without_hollows(library: Any, shells: list[_Shell]) -> list[Any]:
    """The solid shells, each without the hollows in it. A shell in the material of others is wound as these are; one in
    a hollow, or in none, is a solid, however it is wound."""
    hollows: dict[int, list[Any]] = {}
    low, high = (np.array([getattr(each, side) for each in shells]) for side in ("low", "high"))
    for place, shell in enumerate(shells):
        is_around = (low[:place] <= shell.low).all(axis=1) & (high[:place] >= shell.high).all(axis=1)
        holding = [at for at in np.flatnonzero(is_around).tolist() if shells[at].holds(shell)]
        if not sum(-1 if shells[at].is_hollow else 1 for at in holding):
            continue
        around = shells[holding[-1]]
        outward = -around.sense if around.is_hollow else around.sense
        shell.is_hollow = shell.sense != outward
        if shell.is_hollow:
            solids = [at for at in holding if not shells[at].is_hollow]
            hollows.setdefault(solids[-1], []).append(shell.solid)
    solid = [(place, each.solid) for place, each in enumerate(shells) if not each.is_hollow]
    return [
        library.Manifold.batch_boolean([each, *hollows[place]], library.OpType.Subtract) if place in hollows else each
        for place, each in solid
    ]


def _flipped(library: Any, given: Any) -> Any:
    """The same surface, wound the other way."""
    mesh = given.to_mesh64()
    vertices, faces = mesh.vert_properties[:, :3], mesh.tri_verts[:, ::-1]
    return library.Manifold(library.Mesh64(np.array(vertices, order="C"), np.array(faces, order="C")))


def _pieces(vertices: Floats, faces: Faces) -> list[tuple[Floats, Faces]]:
    """The vertices and triangles of each piece that shares no vertex with others."""
    piece = _connected(len(vertices), faces)[faces[:, 0]]
    if not len(faces) or (piece == piece[0]).all():
        return [(vertices, faces)] if len(faces) else []
    order = np.argsort(piece, kind="stable")
    starts = np.flatnonzero(np.diff(piece[order])) + 1
    found = []
    for own in np.split(order, starts):
        used, index = np.unique(faces[own], return_inverse=True)
        found.append((vertices[used], index.reshape(-1, 3).astype(np.uint64)))
    return found


def _connected(count: int, links: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """For each of some numbers the least one that it is connected to. links: `(n, k)`, each row of connected ones."""
    label = np.arange(count)
    while True:
        # All that a row connects get its least number: in few rounds.
        now = label[links]
        least = now.min(axis=1, initial=count)
        if (now == least[:, None]).all():
            return label
        np.minimum.at(label, now.ravel(), np.repeat(least, links.shape[1]))
        while not np.array_equal(label, label[label]):
            label = label[label]


def _with_seams_merged(vertices: Floats, faces: Faces) -> Faces | None:
    """The triangles with the vertices at open seams merged as the core does; None if that changes nothing.

    A seam is open if unequal numbers of triangles run along it in both directions.
    """
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    edges = np.minimum(start, end) * len(vertices) + np.maximum(start, end)
    _, edge = np.unique(edges, return_inverse=True)
    is_open = np.bincount(edge, weights=np.where(start < end, 1.0, -1.0)) != 0.0
    ends = np.unique(np.concatenate([start[is_open[edge]], end[is_open[edge]]]))
    if not len(ends):
        return None
    size = np.ptp(vertices, axis=0).max()
    near = _near(vertices[ends] - vertices[ends[0]], _WELD_SHARE * float(size))
    if np.array_equal(near, np.arange(len(ends))):
        return None
    label = np.arange(len(vertices), dtype=np.uint64)
    label[ends] = ends[near]
    return np.asarray(label[faces])


def _near(points: Floats, reach: float) -> npt.NDArray[np.int64]:
    """For each point the first of its cluster. Points closer than `reach` along each axis share a cluster."""
    # Two such points share a cell of this grid, or of one that is shifted by half a cell along some axes.
    count, cell = np.arange(len(points)), points / (2.0 * reach)
    links = []
    for shift in np.ndindex(2, 2, 2):
        cells, of_point = _core.weld_vertices(np.floor(cell + 0.5 * np.array(shift)))
        first = np.full(len(cells), len(points))
        np.minimum.at(first, of_point, count)
        links.append(np.stack([count, first[of_point]], axis=1))
    return _connected(len(points), np.concatenate(links))


def _without_lines(faces: Faces) -> Faces:
    """The triangles of three corners. One with two equal corners is a line; its neighbours share that edge."""
    return np.asarray(faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])


def _once(faces: Faces) -> Faces:
    """The triangles `(n, 3)` without those with the corners and the winding of an earlier one."""
    if not len(faces):
        return faces
    first = faces.argmin(axis=1)
    turned = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
    hashes = turned @ _HASH
    if len(np.unique(hashes)) == len(faces):  # in a tenth of the time
        return faces
    _, kept = np.unique(turned, axis=0, return_index=True)
    return faces if len(kept) == len(faces) else faces[np.sort(kept)]
