"""Pictures without a display: a software renderer for mock-ups of millions of triangles.

Flow: bodies, a chunk of triangles at a time -> cut by the section plane -> visible triangle at each pixel (`raster`)
-> a colour for each visible triangle, lines, hollows (`shade`) -> mean of 2 by 2 pixels -> PNG.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_progress
from feeler.atomic import atomic_file
from feeler.errors import MeshError, OptionError
from feeler.io.body import Body, MeshLike, body_of
from feeler.picture import shade
from feeler.picture.camera import Camera, Section, check_box, check_size, usual_view, vertical_of
from feeler.picture.clip import clip_triangles
from feeler.picture.png import write_png
from feeler.picture.raster import DepthBuffer
from feeler.progress import Progress

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]

_CUT, _CUT_SHARE = np.array((0.085, 0.105, 0.135)), 0.18  # a cut's colour, linear, and how much of the part's is added
_CHUNK = 1 << 16  # triangles at a time
_NEAR = 1e-3  # of the distance: nearer geometry is clipped, since a plane through the eye cannot be projected
_NUDGE = 2e-5  # of the distance: far above float32 rounding, far below a pixel
_INK, _CIRCLE_PX = (40, 44, 52), 10.0  # frame of the inset and its pointer, sRGB bytes; the circle's radius


@dataclass(frozen=True)
class Inset:
    """A second view, framed, laid over the picture.

    camera: its own. box: left, top, width, height as shares of the picture, 0 to 1.
    """

    camera: Camera
    box: tuple[float, float, float, float] = (0.66, 0.04, 0.32, 0.42)

    def __post_init__(self) -> None:
        check_kind("camera", self.camera, Camera, "a feeler.picture.Camera")
        check_box(self.box)


def render(
    path: str | os.PathLike[str] | None,
    *meshes: MeshLike,
    camera: Camera | None = None,
    size: tuple[int, int] = (1600, 1000),
    section: Section | None = None,
    inset: Inset | None = None,
    progress: Progress | None = None,
) -> Image:
    """Renders mock-ups, tools or bodies to a PNG; returns the pixels, (height, width, 3) uint8.

    path: None writes no file. camera: None frames everything, upright as in
    the page by the `source` of the first mesh. size: width, height in pixels. section:
    cuts the bodies with `cut`, also in the inset. Needs no display and no GPU.
    Raises `WriteError`, `OptionError`, `MeshError`.
    """
    report = check_progress(progress) or (lambda _fraction, _stage: None)
    size = check_size(size)
    for what, given, kind in (("camera", camera, Camera), ("section", section, Section), ("inset", inset, Inset)):
        if given is not None:
            check_kind(what, given, kind, f"a feeler.picture.{kind.__name__}, or None")
    bodies = [body for body in map(body_of, meshes) if len(body.faces)]
    if not bodies:
        raise MeshError("nothing to show: pass at least one mesh with triangles")
    report(0.0, "rendering")
    plane = None if section is None else section.plane()
    solids = [(body, None if plane is None or not body.cut else _facing(body)) for body in bodies]
    if camera is None:
        points = np.concatenate([body.points for body in bodies])
        usual = usual_view([points.min(axis=0), points.max(axis=0)], vertical_of(meshes[0]))
        camera = Camera.framing(points, *usual, size=size)
    image = _View(solids, plane, camera, size).drawn()
    if inset is not None:
        report(0.5, "rendering inset")
        box = _pixel_box(inset.box, size)
        small = _View(solids, plane, inset.camera, (box[2], box[3])).drawn()
        _lay_over(image, small, box, camera.shares([inset.camera.target], size)[0] * size)
    if path is not None:
        with atomic_file(path, ".png") as file:
            write_png(file, image)
    report(1.0, "rendered")
    return image


def _chunks(body: Body) -> Iterator[slice]:
    return (slice(begin, begin + _CHUNK) for begin in range(0, len(body.faces), _CHUNK))


def _area(corners: FloatArray) -> FloatArray:
    """Half the cross product of each triangle (m, 3, 3)."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2


def _facing(body: Body) -> npt.NDArray[np.int8]:
    """Per part: 1 if it is a closed solid facing outward, -1 facing inward, 0 if it is open.

    A closed surface's area vectors sum to zero; the sign of its volume shows its orientation.
    """
    sums = np.zeros((5, max(len(body.paths), 1)))  # area, area vector, volume
    middle = body.bounds.mean(axis=0)
    for chunk in _chunks(body):
        corners = body.vertices[body.faces[chunk]] - middle
        area = _area(corners)
        values = np.linalg.norm(area, axis=1), *area.T, np.einsum("ij,ij->i", corners[:, 0], area)
        sums += [np.bincount(body.part_of_face[chunk], value, sums.shape[1]) for value in values]
    is_closed = np.linalg.norm(sums[1:4], axis=0) < 1e-6 * sums[0]
    return np.where(is_closed, np.sign(sums[4]), 0).astype(np.int8)


class _View:
    """One picture in progress, at twice its size. View space: x right, y up, z towards the viewer, eye at 0."""

    def __init__(
        self,
        solids: list[tuple[Body, npt.NDArray[np.int8] | None]],
        plane: tuple[FloatArray, float] | None,
        camera: Camera,
        size: tuple[int, int],
    ) -> None:
        if not 0.1 <= camera.fov_deg <= 160:
            raise OptionError(f"camera fov_deg is {camera.fov_deg}: give degrees from 0.1 to 160")
        right, up, forward = camera.axes()
        self.solids = solids
        self.first = np.cumsum([0, *(len(body.faces) for body, _ in solids)])
        self.width, self.height = 2 * size[0], 2 * size[1]
        self.view_from_world = np.stack([right, up, -forward])
        self.eye = np.asarray(camera.eye, dtype=np.float64)
        self.focal = size[1] / np.tan(np.radians(camera.fov_deg) / 2)
        self.near = float(np.linalg.norm(np.subtract(camera.target, camera.eye))) * _NEAR
        self.plane = plane and (self.view_from_world @ plane[0], plane[1] - float(plane[0] @ self.eye))

    def drawn(self) -> Image:
        """The picture, (height / 2, width / 2, 3)."""
        buffer = DepthBuffer(self.width, self.height)
        for (body, facing), first in zip(self.solids, self.first, strict=False):
            for chunk in _chunks(body):
                corners, is_inside = self._corners(body, facing, chunk)
                source = np.arange(len(corners))
                if self.plane is not None and facing is not None:
                    corners, source = clip_triangles(corners, *self.plane)
                corners, kept = clip_triangles(corners, np.array([0.0, 0.0, 1.0]), -self.near)
                source = source[kept]
                w = -1 / corners[..., 2]
                x = self.width / 2 + self.focal * corners[..., 0] * w
                y = self.height / 2 - self.focal * corners[..., 1] * w
                # Where two solids touch, the cut through the nearer one wins over the face of the farther one.
                w[is_inside[source]] *= 1 + _NUDGE
                buffer.draw(x, y, w, source + (first + chunk.start))
        return self._shaded(*buffer.seen())

    def _corners(
        self, body: Body, facing: npt.NDArray[np.int8] | None, faces: Any
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Corners (m, 3, 3) of faces in view space, and which of them show the inner side of a closed solid.

        Such a side is only visible through the cut: its pixels are painted as the cut.
        """
        corners = (body.vertices[body.faces[faces]] - self.eye) @ self.view_from_world.T
        if facing is None:
            return corners, np.zeros(len(corners), dtype=bool)
        away = np.einsum("ij,ij->i", corners[:, 0], _area(corners))
        return corners, away * facing[body.part_of_face[faces]] > 0

    def _shaded(self, seen: npt.NDArray[np.int64], depth: npt.NDArray[np.float32]) -> Image:
        """Colours visible triangles, draws lines, darkens hollows, and averages down to the picture."""
        behind = shade.background(self.height)
        image = np.empty((self.height // 2, self.width // 2, 3), dtype=np.uint8)
        image[:] = shade.encode(shade.halved(behind.repeat(2, axis=1)))
        rows, columns = shade.window(seen >= 0)
        if rows.stop:
            inside = self._lit(seen[rows, columns], depth[rows, columns], behind[rows, 0], rows, columns)
            image[rows.start // 2 : rows.stop // 2, columns.start // 2 : columns.stop // 2] = inside
        return image

    def _lit(
        self, seen: npt.NDArray[np.int64], depth: npt.NDArray[np.float32], behind: Any, rows: slice, columns: slice
    ) -> Image:
        """The same for the non-empty part of the picture. behind: `(rows, 3)`, linear."""
        mark = np.zeros(self.first[-1] + 1, dtype=bool)
        mark[seen] = True  # -1 marks the spare last entry
        wanted = np.flatnonzero(mark[:-1])
        row_of = np.full(len(mark), len(wanted), dtype=np.int32)
        row_of[wanted] = np.arange(len(wanted))
        row = row_of.take(seen, mode="wrap")  # `take` is several times as fast as an index for rows of colours
        colour, part, is_cut = self._looks(wanted)
        if self.plane is not None:
            # A cut lies in the plane, not at the inner side seen through it.
            (nx, ny, nz), offset = self.plane
            across = (np.arange(columns.start, columns.stop) + 0.5 - self.width / 2) / self.focal * nx
            down = (self.height / 2 - 0.5 - np.arange(rows.start, rows.stop)) / self.focal * ny - nz
            in_plane = across.astype(np.float32) + down[:, None].astype(np.float32)
            in_plane /= np.float32(offset or 1)
            depth = np.where(is_cut.take(row), np.maximum(in_plane, 0), depth)
        # The background adds rows of colours, one for each line of the picture.
        line = np.arange(len(wanted), len(wanted) + len(row), dtype=np.int32)[:, None]
        colours = np.concatenate([colour[:-1], behind])
        image = colours.take(np.where(row == len(wanted), line, row), axis=0)
        dark = (1 - shade.outlines(part.take(row), depth)) * (1 - shade.hollows(depth, self.width))
        return shade.encode(shade.halved(image) * dark[..., None])

    def _looks(self, wanted: npt.NDArray[np.int64]) -> tuple[npt.NDArray[Any], ...]:
        """Colour (linear), part, and whether it shows a cut, of each triangle; a last row for none."""
        colour = np.zeros((len(wanted) + 1, 3), dtype=np.float32)
        part = np.full(len(colour), -1, dtype=np.int32)
        is_cut = np.zeros(len(colour), dtype=bool)
        for number, (body, facing) in enumerate(self.solids):
            rows = slice(*np.searchsorted(wanted, self.first[number : number + 2]))
            faces = wanted[rows] - self.first[number]
            corners, is_inside = self._corners(body, facing, faces)
            normal = shade.unit(_area(corners))
            albedo = shade.linear_light(body.palette)[body.colour_of_face[faces]]
            if self.plane is not None:
                normal[is_inside] = self.plane[0]
                albedo[is_inside] = albedo[is_inside] * _CUT_SHARE + _CUT
            colour[rows] = shade.light(normal, albedo, shade.unit(-corners.mean(axis=1)))
            part[rows] = body.part_of_face[faces] + (part.max() + 1)
            is_cut[rows] = is_inside
        return colour, part, is_cut


def _pixel_box(box: tuple[float, float, float, float], size: tuple[int, int]) -> tuple[int, int, int, int]:
    x, y, width, height = (int(share * side) for share, side in zip(box, (*size, *size), strict=True))
    if x < 0 or y < 0 or width < 1 or height < 1 or x + width > size[0] or y + height > size[1]:
        raise OptionError(f"inset box {box} does not fit in the picture: give left, top, width, height from 0 to 1")
    return x, y, width, height


def _lay_over(image: Image, small: Image, box: tuple[int, int, int, int], towards: FloatArray) -> None:
    """Puts the inset into the picture, with a frame, a circle around its content and a line to it."""
    left, top, width, height = box
    rows, columns = (np.arange(n) + 0.5 for n in image.shape[:2])
    dx, dy = columns - towards[0], rows[:, None] - towards[1]
    # The line runs from the circle to the nearest point of the frame.
    ex, ey = np.clip(towards, [left, top], [left + width, top + height]) - towards
    length = max(float(np.hypot(ex, ey)), 1e-6)
    along = (dx * ex + dy * ey) / length
    from_line = np.where((along > _CIRCLE_PX) & (along < length), np.abs(dx * ey - dy * ex) / length, np.inf)
    ink = np.clip(1.6 - np.minimum(from_line, np.abs(np.hypot(dx, dy) - _CIRCLE_PX)), 0, 1)[..., None]
    image[:] = np.round(image * (1 - ink) + np.array(_INK) * ink).astype(np.uint8)
    image[max(top - 2, 0) : top + height + 2, max(left - 2, 0) : left + width + 2] = _INK
    image[top : top + height, left : left + width] = small
