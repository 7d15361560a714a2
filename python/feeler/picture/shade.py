"""Light: from what is seen at each pixel to a colour."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Float32 = npt.NDArray[np.float32]

# Lights stand still relative to the camera (x right, y up, z towards the viewer), so that every picture is well lit.
_LIGHTS = (  # direction to the light, colour (linear), strength
    ((-0.52, 0.66, 0.54), (1.00, 0.97, 0.92), 0.78),
    ((0.86, 0.12, 0.50), (0.86, 0.92, 1.00), 0.26),
    ((0.10, -0.75, 0.35), (1.00, 0.95, 0.90), 0.07),
)
_SKY = np.array((0.36, 0.38, 0.41), dtype=np.float32)
_GROUND = np.array((0.20, 0.19, 0.18), dtype=np.float32)
_SHINE = 0.22
_AO_STRENGTH = 4.2


def light(normal: Float32, albedo: Float32, to_viewer: Float32) -> Float32:
    """Colour (n, 3), linear, of surface points: two-sided Lambert, a highlight, sky and ground.

    normal, to_viewer: (n, 3) unit, view space. albedo: (n, 3) linear.
    """
    facing = np.einsum("ij,ij->i", normal, to_viewer)
    normal = np.where(facing[:, None] < 0, -normal, normal)
    facing = np.abs(facing)
    up = (normal[:, 1:2] + 1) * np.float32(0.5)
    total = up * _SKY + (1 - up) * _GROUND
    gleam = np.zeros((len(normal), 3), dtype=np.float32)
    for direction, colour, strength in _LIGHTS:
        to_light = np.array(direction, dtype=np.float32) / np.float32(np.linalg.norm(direction))
        amount = np.maximum(normal @ to_light, 0)
        total += (amount * np.float32(strength))[:, None] * np.array(colour, dtype=np.float32)
        if strength > 0.2:
            between = to_viewer + to_light
            cosine = np.einsum("ij,ij->i", normal, between) / np.sqrt(np.einsum("ij,ij->i", between, between))
            power = np.maximum(cosine, 0)
            for _ in range(5):  # to the 32nd
                power = power * power
            gleam += (power * np.float32(_SHINE * strength))[:, None] * np.array(colour, dtype=np.float32)
    # Grazing surfaces catch light from behind: outlines of round parts stand out.
    rim = np.float32(0.10) * (1 - facing) ** 3
    result: Float32 = albedo * total + gleam + rim[:, None] * (np.float32(0.4) + albedo)
    return result


def ambient_occlusion(
    position: Float32, normal: Float32, solid: npt.NDArray[np.bool_], reach_m: float, radius_px: float
) -> Float32:
    """How much of the sky each pixel sees, (h, w), 0 to 1, from the picture's own depths.

    position: (h, w, 3) view space, metres. normal: (h, w, 3) unit, towards the viewer. solid: (h, w), false for the
    background. reach_m: what stands farther off does not shade. radius_px: how far to look around a pixel.
    """
    height, width = solid.shape
    blocked = np.zeros((height, width), dtype=np.float32)
    count = 26
    for k in range(count):
        angle = 2.399963 * k
        radius = radius_px * ((k + 0.5) / count) ** 1.4 + 1.5
        dx, dy = round(np.cos(angle) * radius), round(np.sin(angle) * radius)
        here_y, there_y = _shifted(dy, height)
        here_x, there_x = _shifted(dx, width)
        if here_y.start >= here_y.stop or here_x.start >= here_x.stop:
            continue
        v = position[there_y, there_x] - position[here_y, here_x]
        length = np.sqrt(np.einsum("ijk,ijk->ij", v, v)) + np.float32(1e-12)
        cosine = np.einsum("ijk,ijk->ij", v, normal[here_y, here_x]) / length
        fade = np.maximum(1 - length / np.float32(reach_m), 0)
        amount = np.maximum(cosine - np.float32(0.08), 0) * fade
        blocked[here_y, here_x] += np.where(solid[there_y, there_x], amount, 0)
    # Each pixel looks at the same few neighbours, which shows as bands: a small mean hides them.
    blocked = _box_mean(blocked, 5)
    open_sky = 1 - np.minimum(blocked * np.float32(_AO_STRENGTH / count), np.float32(0.8))
    result: Float32 = np.where(solid, open_sky, 1).astype(np.float32)
    return result


def outlines(part: npt.NDArray[np.int32], depth: Float32) -> Float32:
    """How dark the lines between parts are, (h, w), 0 to 1; h and w even.

    part: numbers that change across a line; depth: metres. Where lines crowd they fade, or a far bolt circle would
    be a black blot.
    """
    line = np.zeros(part.shape, dtype=np.float32)
    for axis in (0, 1):
        a = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        b = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        iy, ix = np.nonzero(part[a] != part[b])
        ja, jb = (iy, ix), (iy + (axis == 0), ix + (axis == 1))
        da, db = depth[ja], depth[jb]
        strength = np.where(np.abs(da - db) > np.float32(0.012) * np.minimum(da, db), 0.62, 0.40).astype(np.float32)
        # The farther side carries the line: outlines lie on what is behind.
        farther = da > db
        line[ja] = np.maximum(line[ja], np.where(farther, strength, strength * np.float32(0.5)))
        line[jb] = np.maximum(line[jb], np.where(farther, strength * np.float32(0.5), strength))
    crowd = _box_mean((line[::2, ::2] + line[1::2, ::2] + line[::2, 1::2] + line[1::2, 1::2]) * np.float32(0.25), 5)
    fade = np.clip(np.float32(1.25) - crowd * np.float32(4.5), np.float32(0.12), 1)
    for dy in (0, 1):
        for dx in (0, 1):
            line[dy::2, dx::2] *= fade
    return line


def encode(linear: Float32) -> npt.NDArray[np.uint8]:
    """Light, 0 to 1 and above, as sRGB bytes; bright highlights roll off instead of clipping."""
    knee = np.float32(0.8)
    over = np.maximum(linear - knee, 0)
    soft = np.minimum(linear, knee) + (1 - knee) * (1 - np.exp(-over / (1 - knee)))
    table = np.arange(4096, dtype=np.float64) / 4095
    srgb = np.where(table <= 0.0031308, table * 12.92, 1.055 * table ** (1 / 2.4) - 0.055)
    coded = np.round(srgb * 255).astype(np.uint8)
    result: npt.NDArray[np.uint8] = coded[np.clip(soft * 4095 + np.float32(0.5), 0, 4095).astype(np.uint16)]
    return result


def _shifted(step: int, size: int) -> tuple[slice, slice]:
    """Slices of the pixels that have a neighbour `step` away, and of those neighbours."""
    if step >= 0:
        return slice(0, max(size - step, 0)), slice(min(step, size), size)
    return slice(min(-step, size), size), slice(0, max(size + step, 0))


def _box_mean(image: Float32, size: int) -> Float32:
    """Mean over a size by size window, edges repeated."""
    half = size // 2
    for axis in (0, 1):
        pad = [(0, 0), (0, 0)]
        pad[axis] = (half + 1, half)
        total = np.cumsum(np.pad(image, pad, mode="edge"), axis=axis, dtype=np.float64)
        ahead = (slice(size, None), slice(None)) if axis == 0 else (slice(None), slice(size, None))
        behind = (slice(None, -size), slice(None)) if axis == 0 else (slice(None), slice(None, -size))
        image = ((total[ahead] - total[behind]) / size).astype(np.float32)
    return image
