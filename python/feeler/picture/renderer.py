"""Pictures without a display: a software renderer for mock-ups of millions of triangles.

Flow: bodies -> cut by the section plane -> visible triangle at each pixel (`raster`) -> normals (`surface`) -> light,
ambient occlusion, outlines (`shade`) -> mean of 2 by 2 pixels -> PNG.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import MeshError, OptionError
from feeler.io.atomic import atomic_file
from feeler.io.body import body_of
from feeler.picture import shade, surface
from feeler.picture.camera import Camera, Section, usual_view
from feeler.picture.clip import clip_triangles
from feeler.picture.png import write_png
from feeler.picture.raster import visible_triangles

Progress = Callable[[float, str], None]
Float32 = npt.NDArray[np.float32]

_BACKGROUND = ((0.975, 0.98, 0.985), (0.83, 0.85, 0.875))  # top, bottom, sRGB
_CUT = np.array((0.085, 0.105, 0.135), dtype=np.float32)  # what a cut face adds to a fifth of its own colour, linear
_BAND = 32  # rows shaded at a time; even, and few enough for the cache
_LARGEST_SIDE = 16_384
_NUDGE = 2e-5  # of the distance: far above float32 rounding, far below a pixel
_INK = (40, 44, 52)  # frame of an inset and its pointer, sRGB bytes
_CIRCLE_PX = 10.0


@dataclass(frozen=True)
class Inset:
    """A second view, framed, laid over the picture.

    camera: its own. box: left, top, width, height as shares of the picture, 0 to 1.
    """

    camera: Camera
    box: tuple[float, float, float, float] = (0.66, 0.04, 0.32, 0.42)
    section: Section | None = None


def render(
    path: str | os.PathLike[str],
    *meshes: Any,
    camera: Camera | None = None,
    size: tuple[int, int] = (1600, 1000),
    section: Section | None = None,
    insets: Sequence[Inset] = (),
    progress: Progress | None = None,
) -> npt.NDArray[np.uint8]:
    """Renders mock-ups, tools or bodies to a PNG; returns the pixels, (height, width, 3) uint8.

    camera: None frames everything (`usual_view`). size: width, height in pixels. section: what to cut away of the
    bodies with `cut`. Needs no display and no GPU. Raises `WriteError`, `OptionError`, `MeshError`.
    """
    image = render_array(*meshes, camera=camera, size=size, section=section, insets=insets, progress=progress)
    with atomic_file(path) as file:
        write_png(file, image)
    return image


def render_array(
    *meshes: Any,
    camera: Camera | None = None,
    size: tuple[int, int] = (1600, 1000),
    section: Section | None = None,
    insets: Sequence[Inset] = (),
    progress: Progress | None = None,
) -> npt.NDArray[np.uint8]:
    """As `render`, without a file."""
    report = progress or (lambda _fraction, _stage: None)
    width, height = size
    if not (1 <= width <= _LARGEST_SIDE and 1 <= height <= _LARGEST_SIDE):
        raise OptionError(f"size is {size}: give a width and a height from 1 to {_LARGEST_SIDE} pixels")
    bodies = [body_of(mesh) for mesh in meshes]
    if not bodies or not any(len(body.faces) for body in bodies):
        raise MeshError("nothing to show: pass at least one mesh with triangles")
    report(0.0, "preparing picture")
    triangles = surface.join(bodies)
    view = _View(triangles, section)
    if camera is None:
        points = np.concatenate([body.points for body in bodies])
        camera = Camera.framing(points, *usual_view([points.min(axis=0), points.max(axis=0)]), size=size)
    share = 1 / (1 + len(insets))
    report(0.1 * share, "rendering")
    image = view.draw(camera, width, height)
    for number, inset in enumerate(insets):
        report(share * (number + 1), "rendering inset")
        box = _pixel_box(inset.box, width, height)
        inner = view if inset.section == section else _View(triangles, inset.section)
        small = inner.draw(inset.camera, box[2], box[3])
        _lay_over(image, small, box, _on_screen(camera, inset.camera.target, width, height))
    report(1.0, "rendered")
    return image


class _View:
    """Triangles prepared for pictures with one section plane."""

    def __init__(self, triangles: surface.Triangles, section: Section | None) -> None:
        self.triangles = triangles
        self.section = section
        corners = triangles.vertices[triangles.corners]
        self.area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.source: npt.NDArray[np.int64] | None = None
        self.corners = corners
        self.closed = np.zeros(0, dtype=np.int8)
        if section is None:
            return
        normal, offset = section.plane()
        cut = np.flatnonzero(triangles.cut)
        whole = np.flatnonzero(~triangles.cut)
        pieces, source = clip_triangles(corners[cut], normal, offset)
        self.corners = np.concatenate([corners[whole], pieces])
        self.source = np.concatenate([whole, cut[source]])
        if section.cap:
            self.closed = surface.closed_parts(self.area, corners, triangles.part)

    def draw(self, camera: Camera, width: int, height: int) -> npt.NDArray[np.uint8]:
        """The picture, (height, width, 3) uint8."""
        pixels = _Pixels(self, camera, 2 * width, 2 * height)
        return pixels.shaded()


class _Pixels:
    """One picture at twice its size in the making."""

    def __init__(self, view: _View, camera: Camera, width: int, height: int) -> None:
        self.view, self.width, self.height = view, width, height
        right, up, forward = camera.axes()
        self.rotation = np.stack([right, up, -forward])  # view_from_world: x right, y up, z towards the viewer
        self.eye = np.asarray(camera.eye, dtype=np.float64)
        if not 0.1 <= camera.fov_deg <= 160:
            raise OptionError(f"camera fov_deg is {camera.fov_deg}: give degrees from 0.1 to 160")
        self.focal = height / 2 / np.tan(np.radians(camera.fov_deg) / 2)
        self.distance = float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
        # What is nearer than this to the camera is cut off; a plane through the eye cannot be projected.
        near = self.distance * 1e-3
        corners, source = view.corners, view.source
        limit = float(forward @ self.eye) + near
        if len(corners) and float((corners @ forward).min()) < limit:
            corners, index = clip_triangles(corners, -forward, -limit)
            source = index if source is None else source[index]
        x, y, w = self.project(corners)
        self.inside = self._inner_sides()
        if self.inside is not None:
            # Where two solids touch, the cut through the nearer one wins over the face of the farther one.
            behind = self.inside if source is None else self.inside[source]
            w[behind] *= np.float32(1 + _NUDGE)
        seen, self.inverse_depth = visible_triangles(x, y, w, width, height)
        # A spare last entry stands for "nothing", which is -1 on both sides.
        self.seen = seen if source is None else np.append(source, -1)[seen]
        self.ghost = self._ghost(x, y, w, source)

    def project(self, points: npt.NDArray[np.float64]) -> tuple[Float32, Float32, Float32]:
        """Pixel coordinates x, y and inverse depth (1 / metres) of points (..., 3)."""
        local = ((points - self.eye) @ self.rotation.T).astype(np.float32)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a corner beside or behind the camera
            inverse = -1 / local[..., 2]
            x = np.float32(self.width / 2) + np.float32(self.focal) * local[..., 0] * inverse
            y = np.float32(self.height / 2) - np.float32(self.focal) * local[..., 1] * inverse
        return x, y, inverse

    def _inner_sides(self) -> npt.NDArray[np.bool_] | None:
        """Which triangles show the inner side of a closed solid; None where no cut is to be capped.

        Such a side can only be seen through the cut: its pixels are painted as the cut.
        """
        view = self.view
        if view.section is None or not view.section.cap:
            return None
        corner = view.triangles.vertices[view.triangles.corners[:, 0]]
        away = np.einsum("ij,ij->i", corner - self.eye, view.area)
        inner: npt.NDArray[np.bool_] = (away * view.closed[view.triangles.part] > 0) & view.triangles.cut
        return inner

    def _ghost(
        self, x: Float32, y: Float32, w: Float32, source: npt.NDArray[np.int64] | None
    ) -> npt.NDArray[np.int64] | None:
        """The x-ray triangle at each pixel where one is hidden; None where there is none at all."""
        shining = self.view.triangles.xray if source is None else self.view.triangles.xray[source]
        ids = np.flatnonzero(shining > 0)
        if not len(ids) or len(ids) == len(shining):
            return None
        seen, depth = visible_triangles(x[ids], y[ids], w[ids], self.width, self.height)
        # Not what lies on the surface that is seen: two parts that touch would show as a speckled patch.
        hidden = (seen >= 0) & (depth < self.inverse_depth * np.float32(1 - 3e-4))
        if not hidden.any():
            return None
        ids = ids if source is None else source[ids]
        return np.where(hidden, ids[seen], -1)

    def shaded(self) -> npt.NDArray[np.uint8]:
        """Shades, darkens, draws lines, and averages down to the picture."""
        wanted, index = self._compact(self.seen)
        facet, corner = surface.corner_normals(self.view.triangles, self.view.area, wanted)
        table = _Table(self, wanted, facet, corner)
        height, width = self.height, self.width
        colour = np.empty((height, width, 3), dtype=np.float32)
        normal = np.zeros((height // 2, width // 2, 3), dtype=np.float32)
        depth = np.full((height, width), np.float32(1e9))
        bands = [slice(top, min(top + _BAND, height)) for top in range(0, height, _BAND)]
        # Bands write to rows of their own, and NumPy works without the interpreter lock most of the time.
        with ThreadPoolExecutor(max_workers=min(os.cpu_count() or 1, 8)) as pool:
            list(pool.map(lambda band: table.shade_band(band, index, colour, normal, depth), bands))
        solid = index >= 0
        half_depth = depth[::2, ::2]
        position = self._positions(half_depth)
        sky = shade.ambient_occlusion(position, normal, solid[::2, ::2], self.distance * 0.05, self.width / 2 * 0.022)
        part = np.full(len(wanted) + 1, -1, dtype=np.int32)
        part[:-1] = self.view.triangles.part[wanted]
        part_seen = part[index]
        line = shade.outlines(part_seen, depth)
        colour *= (1 - line)[..., None]
        small = (colour[::2, ::2] + colour[1::2, ::2] + colour[::2, 1::2] + colour[1::2, 1::2]) * np.float32(0.25)
        covered = (
            solid[::2, ::2].astype(np.float32) + solid[1::2, ::2] + solid[::2, 1::2] + solid[1::2, 1::2]
        ) * np.float32(0.25)
        small *= (1 - covered * (1 - sky))[..., None]
        return shade.encode(small)

    def _compact(self, seen: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int32]]:
        """The triangles that are seen, and each pixel's index among them (-1: none)."""
        mark = np.zeros(len(self.view.triangles.corners) + 1, dtype=bool)
        mark[seen] = True  # -1 marks the spare last entry
        wanted = np.flatnonzero(mark[:-1])
        number = np.full(len(mark), -1, dtype=np.int32)
        number[wanted] = np.arange(len(wanted))
        return wanted, number[seen]

    def _positions(self, depth: Float32) -> Float32:
        rows, columns = depth.shape
        scale = self.width / columns
        px = (np.arange(columns, dtype=np.float32) * scale + np.float32(0.5) - self.width / 2) / self.focal
        py = (self.height / 2 - np.arange(rows, dtype=np.float32) * scale - np.float32(0.5)) / self.focal
        return np.stack([px[None, :] * depth, py[:, None] * depth, -depth], axis=-1).astype(np.float32)


class _Table:
    """What the pixels look up, one row per visible triangle."""

    def __init__(
        self,
        pixels: _Pixels,
        wanted: npt.NDArray[np.int64],
        facet: npt.NDArray[np.float64],
        corner: npt.NDArray[np.float64],
    ) -> None:
        self.pixels = pixels
        triangles = pixels.view.triangles
        points = triangles.vertices[triangles.corners[wanted]]
        x, y, w = pixels.project(points)
        ahead = np.all((w > 0) & np.isfinite(x) & np.isfinite(y) & np.isfinite(w), axis=1)
        x, y, w = (np.where(ahead[:, None], a, 1) for a in (x, y, w))
        turned = corner @ pixels.rotation.T
        flat = facet @ pixels.rotation.T
        # n / depth is linear on the screen: n = base + (X - x_a) along_x + (Y - y_a) along_y, up to length.
        value = turned * w[:, :, None]
        ux, uy = (x[:, 1] - x[:, 0]).astype(np.float64), (y[:, 1] - y[:, 0]).astype(np.float64)
        vx, vy = (x[:, 2] - x[:, 0]).astype(np.float64), (y[:, 2] - y[:, 0]).astype(np.float64)
        determinant = ux * vy - uy * vx
        # A triangle thinner than this, or with a corner behind the camera, is shaded flat.
        usable = ahead & (np.abs(determinant) > 0.05) & (np.abs(turned - flat[:, None]).max((1, 2)) > 1e-4)
        safe = np.where(usable, determinant, 1.0)[:, None]
        du, dv = value[:, 1] - value[:, 0], value[:, 2] - value[:, 0]
        along_x = np.where(usable[:, None], (du * vy[:, None] - dv * uy[:, None]) / safe, 0)
        along_y = np.where(usable[:, None], (dv * ux[:, None] - du * vx[:, None]) / safe, 0)
        base = np.where(usable[:, None], value[:, 0], flat)
        start = np.where(usable[:, None], np.stack([x[:, 0], y[:, 0]], axis=1), 0)
        self.rows = np.concatenate([base, along_x, along_y, start], axis=1).astype(np.float32)
        self.albedo = triangles.colour[wanted]
        section = pixels.view.section
        self.plane = section.plane() if section is not None and section.cap else None
        self.inside = np.zeros(len(wanted), dtype=bool) if pixels.inside is None else pixels.inside[wanted]

    def shade_band(
        self, band: slice, index: npt.NDArray[np.int32], colour: Float32, normal: Float32, depth: Float32
    ) -> None:
        """Fills rows `band` of colour (linear) and depth, and every second pixel of normal."""
        p = self.pixels
        rows = np.arange(band.start, band.stop)
        colour[band] = _background(rows, p.height)[:, None, :]
        iy, ix = np.nonzero(index[band] >= 0)
        if len(iy):
            which = index[band][iy, ix]
            sx = ix.astype(np.float32) + np.float32(0.5)
            sy = (iy + band.start).astype(np.float32) + np.float32(0.5)
            row = self.rows[which]
            n = row[:, 0:3] + (sx - row[:, 9])[:, None] * row[:, 3:6] + (sy - row[:, 10])[:, None] * row[:, 6:9]
            n /= np.sqrt(np.einsum("ij,ij->i", n, n))[:, None] + np.float32(1e-20)
            ray = np.empty((len(ix), 3), dtype=np.float32)
            ray[:, 0] = (sx - np.float32(p.width / 2)) / np.float32(p.focal)
            ray[:, 1] = (np.float32(p.height / 2) - sy) / np.float32(p.focal)
            ray[:, 2] = -1
            distance = 1 / p.inverse_depth[band][iy, ix]
            albedo = self.albedo[which]
            if self.plane is not None:
                on_cut = self.inside[which]
                if on_cut.any():
                    plane_normal, offset = self.plane
                    local = (p.rotation @ plane_normal).astype(np.float32)
                    n[on_cut] = local
                    height = np.float32(offset - plane_normal @ p.eye)
                    towards = ray[on_cut] @ local
                    distance[on_cut] = np.where(towards != 0, height / np.where(towards != 0, towards, 1), 1e9)
                    albedo[on_cut] = albedo[on_cut] * np.float32(0.18) + _CUT
            to_viewer = -ray / np.sqrt(np.einsum("ij,ij->i", ray, ray))[:, None]
            colour[band.start + iy, ix] = shade.light(n, albedo, to_viewer)
            depth[band.start + iy, ix] = distance
            every = ((iy + band.start) % 2 == 0) & (ix % 2 == 0)
            away = np.einsum("ij,ij->i", n[every], to_viewer[every]) < 0
            normal[(band.start + iy[every]) // 2, ix[every] // 2] = np.where(away[:, None], -n[every], n[every])
        if p.ghost is not None:
            gy, gx = np.nonzero(p.ghost[band] >= 0)
            if len(gy):
                ghost = p.ghost[band][gy, gx]
                share = p.view.triangles.xray[ghost][:, None]
                at = (band.start + gy, gx)
                colour[at] = colour[at] * (1 - share) + p.view.triangles.colour[ghost] * share


def _background(rows: npt.NDArray[np.int64], height: int) -> Float32:
    share = ((rows + 0.5) / height)[:, None]
    top, bottom = (surface.linear_light(np.array(c)) for c in _BACKGROUND)
    return (top * (1 - share) + bottom * share).astype(np.float32)


def _pixel_box(box: tuple[float, float, float, float], width: int, height: int) -> tuple[int, int, int, int]:
    left, top, w, h = box
    x, y = int(left * width), int(top * height)
    pw, ph = int(w * width), int(h * height)
    if x < 0 or y < 0 or pw < 1 or ph < 1 or x + pw > width or y + ph > height:
        raise OptionError(f"inset box {box} does not fit in the picture: give left, top, width, height from 0 to 1")
    return x, y, pw, ph


def _on_screen(camera: Camera, point: Sequence[float], width: int, height: int) -> tuple[float, float]:
    x, y = camera.shares(np.array([point]), (width, height))[0]
    return float(x) * width, float(y) * height


def _lay_over(
    image: npt.NDArray[np.uint8],
    small: npt.NDArray[np.uint8],
    box: tuple[int, int, int, int],
    towards: tuple[float, float],
) -> None:
    """Puts an inset into the picture, with a frame, a circle around what it shows and a line to it."""
    left, top, width, height = box
    rows, columns = (np.arange(n, dtype=np.float32) + np.float32(0.5) for n in image.shape[:2])
    dx, dy = columns[None, :] - towards[0], rows[:, None] - towards[1]
    from_circle = np.abs(np.hypot(dx, dy) - _CIRCLE_PX)
    # The line runs from the circle to the nearest point of the frame.
    ex = float(np.clip(towards[0], left, left + width)) - towards[0]
    ey = float(np.clip(towards[1], top, top + height)) - towards[1]
    length = max(float(np.hypot(ex, ey)), 1e-6)
    along = (dx * ex + dy * ey) / length
    from_line = np.where((along > _CIRCLE_PX) & (along < length), np.abs(dx * ey - dy * ex) / length, np.inf)
    ink = np.clip(1.6 - np.minimum(from_circle, from_line), 0, 1)[..., None]
    image[:] = np.round(image * (1 - ink) + np.array(_INK) * ink).astype(np.uint8)
    frame = (slice(max(top - 2, 0), top + height + 2), slice(max(left - 2, 0), left + width + 2))
    image[frame] = _INK
    image[top : top + height, left : left + width] = small
