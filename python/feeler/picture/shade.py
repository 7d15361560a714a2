"""Lighting: colours of visible triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]

# Lights stand still relative to the camera (x right, y up, z towards the viewer), so that every picture is well lit.
_LIGHTS = (  # direction to the light, colour (linear), strength
    ((-0.52, 0.66, 0.54), (1.00, 0.97, 0.92), 0.78),
    ((0.86, 0.12, 0.50), (0.86, 0.92, 1.00), 0.26),
)
_SKY, _GROUND = np.array((0.36, 0.38, 0.41)), np.array((0.20, 0.19, 0.18))
_SHINE = 0.22
_BACKGROUND = ((0.975, 0.98, 0.985), (0.83, 0.85, 0.875))  # top, bottom, sRGB
_CROWD = 5  # pixels of a window in which lines crowd, odd
_LINE = 0.55  # darkness of the lines between parts
_HOLLOW, _DEEP, _REACH = 0.5, 150, 0.016  # hollows: greatest darkness, growth by depth, share of the width


def light(normal: FloatArray, albedo: FloatArray, to_viewer: FloatArray) -> FloatArray:
    """Colour (n, 3), linear, of facets: two-sided Lambert, a highlight, sky and ground.

    normal, to_viewer: (n, 3) unit, view space. albedo: (n, 3) linear.
    """
    normal = np.where(np.einsum("ij,ij->i", normal, to_viewer)[:, None] < 0, -normal, normal)
    total = _GROUND + (normal[:, 1:2] + 1) / 2 * (_SKY - _GROUND)
    gleam = np.zeros_like(total)
    for direction, colour, strength in _LIGHTS:
        to_light = unit(np.array([direction]))
        total += np.maximum(normal @ to_light.T, 0) * strength * np.array(colour)
        cosine = np.einsum("ij,ij->i", normal, unit(to_viewer + to_light))
        gleam += (_SHINE * strength * np.maximum(cosine, 0) ** 32)[:, None] * np.array(colour)
    result: FloatArray = albedo * total + gleam
    return result


def background(height: int) -> Float32:
    """The background: (height, 1, 3), linear, brighter at the top."""
    shares = (np.arange(height)[:, None, None] + 0.5) / height
    top, bottom = linear_light(_BACKGROUND)
    return np.asarray(top + shares * (bottom - top), dtype=np.float32)


def outlines(part: npt.NDArray[Any], depth: Float32) -> Float32:
    """Darkness of the lines between parts, (h / 2, w / 2), 0 to 1.

    part: (h, w), numbers that change across a line. depth: (h, w), 1 / metres.
    """
    line = np.zeros(part.shape, dtype=np.float32)
    for here, there in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        # Few pixels are at an edge; a list of them is shorter than a picture.
        at = np.nonzero(part[here] != part[there])
        is_here = depth[here][at] <= depth[there][at]
        # The farther side carries the line: outlines lie on the background.
        line[here][at[0][is_here], at[1][is_here]] = _LINE
        line[there][at[0][~is_here], at[1][~is_here]] = _LINE
    small = halved(line)
    # Where lines crowd they fade, or a far bolt circle would be a black blot.
    return np.asarray(small * np.clip(1.25 - 4.5 * _box_mean(small, _CROWD), 0.12, 1), dtype=np.float32)


def window(is_seen: npt.NDArray[np.bool_]) -> tuple[slice, slice]:
    """Rows and columns around all visible pixels, of even numbers, with a margin for the shading."""
    reach = 4 * int(_REACH * is_seen.shape[1] / 4) + 2 * _CROWD + 4
    sides = []
    for axis in (1, 0):
        found = np.flatnonzero(is_seen.any(axis=axis))
        size = is_seen.shape[1 - axis]
        low, high = (max(int(found[0]) - reach, 0), min(int(found[-1]) + reach, size)) if len(found) else (0, 0)
        sides.append(slice(low // 2 * 2, (high + 1) // 2 * 2))
    return sides[0], sides[1]


def hollows(depth: Float32, width: int) -> Float32:
    """Darkening of pixels by surfaces in front of them, (h / 2, w / 2), 0 to 1. depth: (h, w), 1 / metres, 0: nothing.
    width: of the whole picture, pixels.

    Inverse depth is linear on the screen wherever a surface is plane: pixels below their own mean are hollows.
    """
    mean = _box_mean(halved(depth), 2 * int(_REACH * width / 4) + 1)
    fours = depth.reshape(mean.shape[0], 2, mean.shape[1], 2)
    below = np.maximum(mean[:, None, :, None] / np.maximum(fours, np.float32(1e-30)) - 1, 0)
    # Most pixels are in no hollow: the exponential is computed for the others only.
    at = np.flatnonzero((fours > 0) & (below > 0))
    dark = np.zeros(depth.size, dtype=np.float32)
    dark[at] = _HOLLOW * (1 - np.exp(-_DEEP * below.ravel()[at]))
    return halved(dark.reshape(depth.shape))


def encode(linear: Float32) -> npt.NDArray[np.uint8]:
    """Light, 0 to 1, as sRGB bytes; more than 1 is white."""
    clipped = np.clip(linear, 0, 1)
    srgb = np.where(clipped <= 0.0031308, clipped * 12.92, 1.055 * clipped ** np.float32(1 / 2.4) - 0.055)
    return np.round(srgb * 255).astype(np.uint8)


def linear_light(srgb: npt.ArrayLike) -> FloatArray:
    """sRGB values, 0 to 1, as linear light."""
    value = np.asarray(srgb, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def unit(vectors: FloatArray) -> FloatArray:
    """The vectors (n, 3) at length 1; zero stays zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def halved(image: Float32) -> Float32:
    """The mean of each 2 by 2 pixels."""
    total = image[::2, ::2] + image[1::2, ::2] + image[::2, 1::2] + image[1::2, 1::2]
    return np.asarray(total * np.float32(0.25))


def _box_mean(image: Float32, size: int) -> Float32:
    """Mean over a window of `size` by `size` pixels, `size` odd, edges repeated."""
    for _axis in range(2):
        total = np.cumsum(np.pad(image, ((size // 2 + 1, size // 2), (0, 0)), mode="edge"), axis=0, dtype=np.float64)
        image = ((total[size:] - total[:-size]) / size).astype(np.float32).T
    return image
