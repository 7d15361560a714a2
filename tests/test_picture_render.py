"""The renderer: known pixels of simple scenes, against a plain rasteriser, and pictures as a whole."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import feeler
from feeler.io import Mark, WriteError, body_of, with_marks
from feeler.picture import Camera, Inset, Section, render, render_collision
from feeler.picture.clip import clip_triangles
from feeler.picture.raster import visible_triangles
from feeler.picture.renderer import render_array

SIZE = (160, 100)
FRONT = Camera(eye=(0, -10, 0), target=(0, 0, 0), fov_deg=20)  # looks along +y, x to the right, z up


def quad(x0: float, x1: float, z0: float, z1: float, y: float) -> SimpleNamespace:
    vertices = np.array([[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]], dtype=float)
    return SimpleNamespace(vertices=vertices, faces=np.array([[0, 1, 2], [0, 2, 3]]))


def box(lower: float, upper: float) -> SimpleNamespace:
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return SimpleNamespace(vertices=lower + (upper - lower) * vertices, faces=np.array(faces))


def is_red(pixel: np.ndarray) -> bool:
    r, g, b = (int(c) for c in pixel)
    return r > 90 and r > 2 * g and r > 2 * b


def is_blue(pixel: np.ndarray) -> bool:
    r, _, b = (int(c) for c in pixel)
    return b > 90 and b > 1.5 * r


def is_background(pixel: np.ndarray) -> bool:
    return int(pixel.min()) > 200


def plain_visible(x: np.ndarray, y: np.ndarray, w: np.ndarray, width: int, height: int) -> np.ndarray:
    """What `visible_triangles` does, pixel by pixel."""
    seen, best = np.full((height, width), -1), np.zeros((height, width))
    for t in range(len(x)):
        (ax, bx, cx), (ay, by, cy) = x[t], y[t]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        for row in range(height):
            for column in range(width):
                px, py = column + 0.5, row + 0.5
                v = ((px - ax) * (cy - ay) - (py - ay) * (cx - ax)) / area
                u = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / area
                if v < 0 or u < 0 or u + v > 1:
                    continue
                depth = (1 - u - v) * w[t, 0] + v * w[t, 1] + u * w[t, 2]
                if depth > best[row, column]:
                    best[row, column], seen[row, column] = depth, t
    return seen


@pytest.mark.parametrize("seed", range(6))
def test_visibility_equals_the_plain_rasteriser(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count, width, height = 60, 37, 26
    centre = rng.uniform(-5, 45, (count, 1))
    spread = rng.choice([0.3, 2, 12, 60], (count, 1))
    x = centre + rng.normal(size=(count, 3)) * spread
    y = rng.uniform(-5, 30, (count, 1)) + rng.normal(size=(count, 3)) * spread
    w = rng.uniform(0.1, 1, (count, 1)) + rng.uniform(0, 0.05, (count, 3))
    seen, depth = visible_triangles(x, y, w, width, height)
    expected = plain_visible(x, y, w, width, height)
    # Pixel centres within rounding of an edge may go either way.
    assert np.count_nonzero(seen != expected) <= 2
    assert ((depth > 0) == (seen >= 0)).all()


def test_hidden_triangles_are_never_seen_and_visible_ones_always() -> None:
    # Many small triangles behind a wall with a hole: the pyramid must not drop those seen through the hole.
    rng = np.random.default_rng(1)
    wall_x = np.array([[0, 100, 0], [100, 100, 0], [120, 300, 120], [300, 300, 120]], dtype=float)
    wall_y = np.array([[0, 0, 200], [0, 200, 200], [0, 0, 200], [0, 200, 200]], dtype=float)
    x = rng.uniform(0, 300, (4000, 1)) + rng.uniform(-3, 3, (4000, 3))
    y = rng.uniform(0, 200, (4000, 1)) + rng.uniform(-3, 3, (4000, 3))
    w = np.concatenate([np.full((4, 3), 2.0), np.broadcast_to(rng.uniform(0.5, 1, (4000, 1)), (4000, 3))])
    seen, _ = visible_triangles(np.concatenate([wall_x, x]), np.concatenate([wall_y, y]), w, 300, 200)
    assert (seen[:, :100] < 4).all() and (seen[:, 121:] < 4).all()
    hole = seen[:, 101:119]
    alone, _ = visible_triangles(x, y, w[4:], 300, 200)
    np.testing.assert_array_equal(np.where(hole >= 0, hole - 4, -1), alone[:, 101:119])


def test_nearer_things_hide_farther_ones() -> None:
    red, blue = quad(-1, 0.5, -1, 1, 0), quad(-0.5, 1, -1, 1, 2)
    image = render_array(body_of(red, colours=(1, 0, 0)), body_of(blue, colours=(0, 0, 1)), camera=FRONT, size=SIZE)
    assert image.shape == (100, 160, 3)
    assert is_red(image[50, 70]) and is_red(image[50, 90])  # where they overlap, too
    assert is_blue(image[50, 99])
    assert is_background(image[50, 5]) and is_background(image[2, 80])


def test_a_marked_triangle_is_seen_in_its_colour() -> None:
    body = with_marks(body_of(quad(-1, 1, -1, 1, 0), colours=(0.5, 0.5, 0.5)), [Mark(np.array([1]), (1, 0, 0))])
    image = render_array(body, camera=FRONT, size=SIZE)
    assert is_red(image[35, 65]) and not is_red(image[65, 95])


def test_xray_shines_through_and_others_do_not() -> None:
    wall = body_of(quad(-1, 1, -1, 1, 0), colours=(0.8, 0.8, 0.8))
    behind = body_of(quad(-0.3, 0.3, -0.3, 0.3, 2), colours=(1, 0, 0))
    hidden = render_array(wall, behind, camera=FRONT, size=SIZE)
    shining = render_array(wall, with_marks(behind, [], xray=0.5), camera=FRONT, size=SIZE)
    assert int(hidden[50, 80, 0]) - int(hidden[50, 80, 1]) < 10
    assert int(shining[50, 80, 0]) - int(shining[50, 80, 1]) > 30
    np.testing.assert_array_equal(hidden[20, 60], shining[20, 60])


def test_section_opens_a_solid_and_caps_it() -> None:
    solid, core = box(-1, 1), box(-0.3, 0.3)
    bodies = [body_of(solid, colours=(0.2, 0.8, 0.2)), body_of(core, colours=(1, 0, 0), cut=False)]
    section = Section((0, 0, 0), (0, -1, 0))
    closed = render_array(*bodies, camera=FRONT, size=SIZE)
    capped = render_array(*bodies, camera=FRONT, size=SIZE, section=section)
    opened = render_array(*bodies, camera=FRONT, size=SIZE, section=Section((0, 0, 0), (0, -1, 0), cap=False))
    assert not is_red(closed[50, 80])
    assert is_red(capped[50, 80]) and is_red(opened[50, 80])  # it is not cut, and stands out of the cut
    assert int(capped[50, 58].max()) < int(opened[50, 58].max())  # the cut is dark, the inside of the far wall is not
    assert not is_background(capped[50, 58])


def test_camera_frames_what_it_is_given() -> None:
    rng = np.random.default_rng(5)
    for direction in ((1, 0, 0), (-0.5, 0.7, -0.4), (0, 0, -1), (0.2, -1, 3)):
        points = rng.normal(size=(200, 3)) * [5, 1, 0.3] + [100, -30, 7]
        frame = (0.1, 0.3, 0.5, 0.6)
        camera = Camera.framing(points, direction, size=SIZE, box=frame)
        right, up, forward = camera.axes()
        away = points - camera.eye
        half = np.tan(np.radians(camera.fov_deg) / 2) * (away @ forward)
        x = ((away @ right) / half * SIZE[1] / SIZE[0] + 1) / 2
        y = (1 - (away @ up) / half) / 2
        assert x.min() >= 0.1 - 1e-9 and x.max() <= 0.6 + 1e-9 and y.min() >= 0.3 - 1e-9 and y.max() <= 0.9 + 1e-9
        assert min(abs(x.min() - 0.1), abs(y.min() - 0.3)) < 1e-6  # as large as possible


def test_clipping_keeps_area_and_orientation() -> None:
    rng = np.random.default_rng(2)
    corners = rng.normal(size=(500, 3, 3))
    normal = np.array([1.0, 2.0, -1.0]) / np.sqrt(6)

    def areas(triangles: np.ndarray) -> np.ndarray:
        return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2

    below, source_below = clip_triangles(corners, normal, 0.1)
    above, source_above = clip_triangles(corners, -normal, -0.1)
    assert (below @ normal).max() <= 0.1 + 1e-12 and (above @ normal).min() >= 0.1 - 1e-12
    total = np.zeros((500, 3))
    np.add.at(total, source_below, areas(below))
    np.add.at(total, source_above, areas(above))
    np.testing.assert_allclose(total, areas(corners), atol=1e-12)


def test_png_holds_the_pixels(tmp_path: Path) -> None:
    image = render(tmp_path / "a.png", body_of(box(-1, 1)), size=(61, 47))
    data = (tmp_path / "a.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (61, 47)
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack_from(">I", data, at + 8 + length)[0] == zlib.crc32(kind + body)
        chunks[kind], at = body, at + 12 + length
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(47, 1 + 3 * 61)
    np.testing.assert_array_equal(unfiltered(rows), image)


def unfiltered(rows: np.ndarray) -> np.ndarray:
    """PNG's filters undone, byte by byte."""
    height, width = len(rows), (rows.shape[1] - 1) // 3
    image = np.zeros((height + 1, width + 1, 3), dtype=int)
    for i in range(height):
        for j in range(width):
            for k in range(3):
                a, b, c = image[i + 1, j, k], image[i, j + 1, k], image[i, j, k]
                p = a + b - c
                paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                guess = {0: 0, 1: a, 2: b, 3: (a + b) // 2, 4: paeth}[int(rows[i, 0])]
                image[i + 1, j + 1, k] = (int(rows[i, 1 + 3 * j + k]) + guess) % 256
    return image[1:, 1:].astype(np.uint8)


def test_inset_and_odd_sizes() -> None:
    image = render_array(
        body_of(box(-1, 1), colours=(1, 0, 0)),
        camera=FRONT,
        size=(201, 101),
        insets=[Inset(Camera((0, -2, 0), (0, 0, 0)), (0.7, 0.05, 0.28, 0.5))],
    )
    assert image.shape == (101, 201, 3)
    assert is_red(image[20, 170])  # the inset is full of the box
    assert int(image[4, 170].max()) < 80  # its frame


def test_collision_picture_shows_what_is_hit(tmp_path: Path) -> None:
    mockup = feeler.Mockup(np.concatenate([box(-1, 1).vertices, box(2, 3).vertices]),
                           np.concatenate([box(-1, 1).faces, box(2, 3).faces + 8]),
                           np.repeat([0, 1], 12), ["near", "far"])  # fmt: skip
    tool = feeler.Tool(box(0, 1).vertices, box(0, 1).faces, "probe")
    pose = np.eye(4)
    pose[:3, 3] = [-0.5, -0.5, 0.4]
    found = SimpleNamespace(mockup_triangles=np.array([10, 11]), tool_triangles=np.array([4, 5]), parts=np.array([0]))
    stages: list[tuple[float, str]] = []
    image = render_collision(
        tmp_path / "hit.png", mockup, tool, pose, found, size=(320, 200), progress=lambda f, s: stages.append((f, s))
    )
    assert (tmp_path / "hit.png").stat().st_size > 1000
    assert any(is_blue(pixel) for pixel in image.reshape(-1, 3)[::3])
    assert [fraction for fraction, _ in stages] == sorted(fraction for fraction, _ in stages)
    assert stages[-1][0] == 1.0


def test_a_camera_inside_the_scene_is_no_trouble() -> None:
    image = render_array(body_of(box(-1, 1)), camera=Camera((0, 0, 0), (0, 1, 0)), size=SIZE)
    assert not is_background(image[50, 80])


def test_nothing_in_sight_is_a_plain_background() -> None:
    cube = body_of(box(-1, 1))
    cut_away = render_array(cube, camera=FRONT, size=SIZE, section=Section((0, 5, 0), (0, -1, 0)))
    behind = render_array(cube, camera=Camera((0, 10, 0), (0, 20, 0)), size=SIZE)
    aside = render_array(cube, camera=Camera((0, 0, 1), (1, 0, 1)), size=SIZE)  # in the plane of a face
    assert int(cut_away.min()) > 200 and int(behind.min()) > 200
    assert aside.shape == (100, 160, 3)
    needle = SimpleNamespace(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    assert int(render_array(needle, size=SIZE).min()) > 200


def test_far_from_the_origin_and_tiny() -> None:
    near = render_array(body_of(box(-1, 1), colours=(1, 0, 0)), size=SIZE)
    far = box(-1, 1)
    far.vertices = far.vertices + np.array([1e6, -1e6, 1e6])
    tiny = box(-1e-6, 1e-6)
    for mesh in (far, tiny):
        image = render_array(body_of(mesh, colours=(1, 0, 0)), size=SIZE)
        assert np.abs(image.astype(int) - near).mean() < 1.0


def test_wrong_input_is_refused(tmp_path: Path) -> None:
    cube = body_of(box(-1, 1))
    with pytest.raises(feeler.OptionError, match="size"):
        render_array(cube, size=(0, 10))
    with pytest.raises(feeler.OptionError, match="camera target"):
        render_array(cube, camera=Camera((0, 0, 0), (0, 0, 0)), size=SIZE)
    with pytest.raises(feeler.OptionError, match="fov_deg"):
        render_array(cube, camera=Camera((0, -3, 0), (0, 0, 0), fov_deg=200), size=SIZE)
    with pytest.raises(feeler.OptionError, match="section normal"):
        render_array(cube, section=Section((0, 0, 0), (0, 0, 0)), size=SIZE)
    with pytest.raises(feeler.OptionError, match="inset"):
        render_array(cube, size=SIZE, insets=[Inset(FRONT, (0.9, 0.9, 0.5, 0.5))])
    with pytest.raises(feeler.MeshError, match="nothing to show"):
        render_array(size=SIZE)
    with pytest.raises(WriteError, match="does not exist"):
        render(tmp_path / "no" / "a.png", cube, size=SIZE)
