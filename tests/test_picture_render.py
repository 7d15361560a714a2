"""The renderer: known pixels of simple scenes, against a plain rasteriser, and pictures as a whole."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import feeler
from feeler.io import Mark, WriteError, body_of, with_marks
from feeler.picture import Camera, Inset, Section, render, render_collision
from feeler.picture.clip import clip_triangles
from feeler.picture.raster import DepthBuffer

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


def visible_triangles(x: np.ndarray, y: np.ndarray, w: np.ndarray, width: int, height: int) -> tuple[Any, Any]:
    """The whole in two draws, the second of which lies before and behind the first."""
    buffer, ids = DepthBuffer(width, height), np.arange(len(x))
    for some in (ids % 3 == 1, ids % 3 != 1):
        buffer.draw(x[some], y[some], w[some], ids[some])
    return buffer.seen()


def plain_visible(x: np.ndarray, y: np.ndarray, w: np.ndarray, width: int, height: int) -> tuple[Any, Any]:
    """What `DepthBuffer` does, pixel by pixel."""
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
    return seen, best


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
    expected, expected_depth = plain_visible(x, y, w, width, height)
    # Pixel centres within rounding of an edge may go either way.
    assert np.count_nonzero(seen != expected) <= 2
    assert ((depth > 0) == (seen >= 0)).all()
    np.testing.assert_allclose(depth[seen == expected], expected_depth[seen == expected], rtol=2e-4)


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
    image = render(None, body_of(red, colours=(1, 0, 0)), body_of(blue, colours=(0, 0, 1)), camera=FRONT, size=SIZE)
    assert image.shape == (100, 160, 3)
    assert is_red(image[50, 70]) and is_red(image[50, 90])  # where they overlap, too
    assert is_blue(image[50, 99])
    assert is_background(image[50, 5]) and is_background(image[2, 80])


def test_a_marked_triangle_is_seen_in_its_colour() -> None:
    body = with_marks(body_of(quad(-1, 1, -1, 1, 0), colours=(0.5, 0.5, 0.5)), [Mark(np.array([1]), (1, 0, 0))])
    image = render(None, body, camera=FRONT, size=SIZE)
    assert is_red(image[35, 65]) and not is_red(image[65, 95])


def test_section_opens_a_solid_and_caps_it() -> None:
    solid, core = box(-1, 1), box(-0.3, 0.3)
    bodies = [body_of(solid, colours=(0.2, 0.8, 0.2)), body_of(core, colours=(1, 0, 0), cut=False)]
    section = Section((0, 0, 0), (0, -1, 0))
    closed = render(None, *bodies, camera=FRONT, size=SIZE)
    capped = render(None, *bodies, camera=FRONT, size=SIZE, section=section)
    bowl = box(-1, 1)
    bodies[0] = body_of(  # without its front it is open: nothing closes the cut
        SimpleNamespace(vertices=bowl.vertices, faces=np.delete(bowl.faces, [4, 5], axis=0)), colours=(0.2, 0.8, 0.2)
    )
    opened = render(None, *bodies, camera=FRONT, size=SIZE, section=section)
    assert not is_red(closed[50, 80])
    assert is_red(capped[50, 80]) and is_red(opened[50, 80])  # it is not cut, and stands out of the cut
    assert int(capped[50, 58].max()) < int(opened[50, 58].max())  # the cut is dark, the inside of the far wall is not
    assert not is_background(capped[50, 58])


def test_a_cut_is_even_and_wins_over_what_touches_it() -> None:
    # Seen aslant, so that edges of the inner side lie behind the cut; the red box begins where the green one ends.
    green, red = box(-1, 1), box(-1, 1)
    red.vertices = red.vertices + np.array([0, 2, 0])
    bodies = [body_of(green, colours=(0.2, 0.8, 0.2)), body_of(red, colours=(1, 0, 0))]
    camera, section = Camera((4, -9, 3), (0, 0, 0), fov_deg=20), Section((0, 0, 0), (0, -1, 0))
    image = render(None, *bodies, camera=camera, size=SIZE, section=section)
    seen = camera.shares([[x, 0, z] for x in (-0.8, 0.8) for z in (-0.8, 0.8)], SIZE) * SIZE
    (left, top), (right, bottom) = np.sort(seen, axis=0)[1:3].T.reshape(2, 2).T
    cut = image[int(top) : int(bottom), int(left) : int(right)].reshape(-1, 3)
    assert len(cut) > 500 and (cut == cut[0]).all()
    assert cut[0].argmax() == 1 and cut[0].max() < 140  # green, and dark


def test_lines_part_what_has_one_colour() -> None:
    vertices = np.array([[x, 0, z] for x in (-1, 0, 1) for z in (-1, 1)], dtype=float)
    faces = np.array([[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]])

    def contrast(*bodies: Any) -> int:
        grey = [body_of(body, colours=(0.8, 0.8, 0.8)) for body in bodies]
        row = render(None, *grey, camera=FRONT, size=SIZE)[50, 60:100, 0].astype(int)
        return int(row.max() - row.min())

    sheets = [
        SimpleNamespace(vertices=vertices, faces=faces, part_of_face=np.array(parts), part_paths=["a", "b"])
        for parts in ([0, 0, 1, 1], [0, 0, 0, 0])
    ]
    assert contrast(sheets[0]) > 20 and contrast(sheets[1]) < 4
    halves = [SimpleNamespace(vertices=vertices, faces=some) for some in (faces[:2], faces[2:])]
    assert contrast(*halves) > 20


def test_what_stands_before_a_wall_darkens_it_around_itself() -> None:
    wall, post = quad(-1, 1, -1, 1, 0), quad(-0.1, 0.1, -1, 1, -0.5)
    image = render(None, body_of(wall, colours=(0.8, 0.8, 0.8)), body_of(post), camera=FRONT, size=(640, 400))
    assert image[200, 320 - 15, 0] < image[200, 320 - 60, 0]  # beside the post, and well away from it
    assert (image[200, 250:260] == image[200, 255]).all()


def test_chunks_make_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    mockup = body_of(feeler.sample("carcass", triangles=10_000, seed=3))
    section = Section(tuple(mockup.bounds.mean(axis=0)), (0.3, 1, 0.2))
    whole = render(None, mockup, box(0, 0.1), size=SIZE, section=section)
    monkeypatch.setattr("feeler.picture.renderer._CHUNK", 97)
    monkeypatch.setattr("feeler.picture.raster._AT_ONCE", 1000)
    np.testing.assert_array_equal(render(None, mockup, box(0, 0.1), size=SIZE, section=section), whole)


def test_no_light_shines_through_a_seam() -> None:
    # A sheet of slivers that share edges: each pixel centre belongs to one of them, however the edges round.
    rng = np.random.default_rng(8)
    bottom, top = (np.sort(np.append(rng.uniform(0, 200, 300), (-1, 201))) for _ in range(2))
    a, b, c, d = bottom[:-1], bottom[1:], top[1:], top[:-1]
    x = np.concatenate([np.stack([a, b, c], 1), np.stack([c, a, d], 1)])
    low, high = np.full(len(a), -1.0), np.full(len(a), 121.0)
    y = np.concatenate([np.stack([low, low, high], 1), np.stack([high, low, high], 1)])
    seen, depth = visible_triangles(x, y, np.ones_like(x), 200, 120)
    assert (seen >= 0).all() and (depth == 1).all()


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
    image = render(
        None,
        body_of(box(-1, 1), colours=(1, 0, 0)),
        camera=FRONT,
        size=(201, 101),
        inset=Inset(Camera((0, -2, 0), (0, 0, 0)), (0.7, 0.05, 0.28, 0.5)),
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


@pytest.mark.parametrize("direction", [(0, 1, 0), (-0.55, 0.75, -0.42), (1, 0.3, 0.2)])
@pytest.mark.parametrize("shape", ["box", "sheet aside"])
def test_the_close_view_covers_next_to_nothing(
    monkeypatch: pytest.MonkeyPatch, direction: tuple[float, float, float], shape: str
) -> None:
    views: list[dict[str, Any]] = []
    monkeypatch.setattr("feeler.picture.views.render", lambda *_meshes, **view: views.append(view))
    block = box(-1, 1)
    if shape == "sheet aside":  # so many vertices up and to the left that the tool's hardly count
        x, z = (a.ravel() for a in np.meshgrid(np.linspace(-1, -0.9, 70), np.linspace(0.9, 1, 70)))
        corners = np.stack([x, np.full(len(x), 0.95), z], axis=1)
        block = SimpleNamespace(vertices=corners, faces=np.arange(len(x) - 1)[:, None] + [0, 1, 0])
        block.faces[:, 2] = len(x) // 2
    mockup, tool = feeler.Mockup(block.vertices, block.faces), feeler.Tool(box(0, 0.2).vertices, box(0, 0.2).faces)
    found = SimpleNamespace(mockup_triangles=np.zeros(0), tool_triangles=np.zeros(0), parts=np.zeros(0))
    for place in np.ndindex(2, 2, 2):
        pose = np.eye(4)
        pose[:3, 3] = np.array(place) * 1.8 - 1
        render_collision(None, mockup, tool, pose, found, size=(320, 200), direction=direction)
        camera, section, (left, top, width, height) = (
            *map(views[-1].get, ("camera", "section")),
            views[-1]["inset"].box,
        )
        normal, offset = section.plane()
        kept = block.vertices[block.vertices @ normal <= offset]
        for points, most in ((kept, 0.003), (box(0, 0.2).vertices + pose[:3, 3], 0)):
            seen = camera.shares(points, (320, 200))
            assert ((seen > 0) & (seen < 1)).all()
            assert (
                not len(seen)
                or np.all((seen > [left, top]) & (seen < [left + width, top + height]), axis=1).mean() <= most
            )


def test_a_camera_inside_the_scene_is_no_trouble() -> None:
    image = render(None, body_of(box(-1, 1)), camera=Camera((0, 0, 0), (0, 1, 0)), size=SIZE)
    assert not is_background(image[50, 80])


def test_nothing_in_sight_is_a_plain_background() -> None:
    cube = body_of(box(-1, 1))
    cut_away = render(None, cube, camera=FRONT, size=SIZE, section=Section((0, 5, 0), (0, -1, 0)))
    behind = render(None, cube, camera=Camera((0, 10, 0), (0, 20, 0)), size=SIZE)
    aside = render(None, cube, camera=Camera((0, 0, 1), (1, 0, 1)), size=SIZE)  # in the plane of a face
    assert int(cut_away.min()) > 200 and int(behind.min()) > 200
    assert aside.shape == (100, 160, 3)
    needle = SimpleNamespace(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    assert int(render(None, needle, size=SIZE).min()) > 200


def test_far_from_the_origin_and_tiny() -> None:
    near = render(None, body_of(box(-1, 1), colours=(1, 0, 0)), size=SIZE)
    far = box(-1, 1)
    far.vertices = far.vertices + np.array([1e6, -1e6, 1e6])
    tiny = box(-1e-6, 1e-6)
    for mesh in (far, tiny):
        image = render(None, body_of(mesh, colours=(1, 0, 0)), size=SIZE)
        assert np.abs(image.astype(int) - near).mean() < 1.0


def test_wrong_input_is_refused(tmp_path: Path) -> None:
    cube = body_of(box(-1, 1))
    with pytest.raises(feeler.OptionError, match="size"):
        render(None, cube, size=(0, 10))
    with pytest.raises(feeler.OptionError, match="camera target"):
        render(None, cube, camera=Camera((0, 0, 0), (0, 0, 0)), size=SIZE)
    with pytest.raises(feeler.OptionError, match="fov_deg"):
        render(None, cube, camera=Camera((0, -3, 0), (0, 0, 0), fov_deg=200), size=SIZE)
    with pytest.raises(feeler.OptionError, match="normal is zero"):
        render(None, cube, section=Section((0, 0, 0), (0, 0, 0)), size=SIZE)
    with pytest.raises(feeler.OptionError, match="box"):
        render(None, cube, size=SIZE, inset=Inset(FRONT, (0.9, 0.9, 0.5, 0.5)))
    with pytest.raises(feeler.MeshError, match="nothing to show"):
        render(None, size=SIZE)
    with pytest.raises(WriteError, match="does not exist"):
        render(tmp_path / "no" / "a.png", cube, size=SIZE)
