"""Openings: what goes through round and square holes, slots and tilted plates, against closed forms, both sides."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json
from shapes import box, mockup_of

import feeler
from feeler.io import write_glb
from feeler.plan.opening import LIMITS_TEMPLATE, write_limits_template
from feeler.plan.tool_solids import lathed

ERROR = 1e-4
Z = [0.0, 0.0, 1.0]


def ring_of(radius: float, count: int, z: float) -> Any:
    turn = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, z)])


def round_hole(bore: float, thick: float = 0.004, count: int = 360) -> Any:
    """A plate with a hole of a radius, whose polygon is around the circle."""
    inner = bore / math.cos(math.pi / count)
    levels = [(inner, -thick / 2), (0.5, -thick / 2), (0.5, thick / 2), (inner, thick / 2)]
    return lathed([ring_of(radius, count, z) for radius, z in levels], is_ring=True)


def frame_of(width: float, height: float, thick: float = 0.004) -> dict[str, Any]:
    """Four bars around a rectangular window."""
    x, y, z = width / 2, height / 2, thick / 2
    return {
        "left": box((-0.5, -0.5, -z), (-x, 0.5, z)),
        "right": box((x, -0.5, -z), (0.5, 0.5, z)),
        "low": box((-0.5, -0.5, -z), (0.5, -y, z)),
        "high": box((-0.5, y, -z), (0.5, 0.5, z)),
    }


def posed(parts: dict[str, Any], turn: np.ndarray, shift: np.ndarray) -> feeler.Scene:
    return feeler.Scene(mockup_of({name: (v @ turn.T + shift, f) for name, (v, f) in parts.items()}))


def turn_of(rng: np.random.Generator) -> np.ndarray:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(turn * np.linalg.det(turn))


def about(found: float, truth: float) -> bool:
    return truth - ERROR - 1e-9 <= found <= truth + 1e-9


def test_round_holes() -> None:
    rng = np.random.default_rng(2)
    for bore in (0.004, 0.02, 0.0613):
        turn, shift = turn_of(rng), rng.normal(size=3)
        scene = posed({"plate": round_hole(bore)}, turn, shift)
        row = feeler.opening(scene, shift, turn[:, 2])
        assert about(row.ball, 2 * bore) and about(row.cylinder, 2 * bore)
        assert 2 * bore / math.sqrt(2.0) - ERROR <= row.width <= 2 * bore / math.sqrt(2.0) + 2e-3 * bore
        assert row.height == row.width and {part for _, part in row.stopped_by} == {"plate"}
        flat = feeler.opening(scene, shift, turn[:, 2], aspect=0.5)
        assert flat.width == pytest.approx(2 * bore * math.cos(math.atan(0.5)), abs=1.5 * ERROR + 2e-3 * bore)
        assert flat.height == 0.5 * flat.width


def test_a_ball_as_wide_as_its_limit_goes_through() -> None:
    """The line that its middle follows has no width."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        turn, shift = turn_of(rng), rng.normal(size=3)
        scene = posed(frame_of(0.02, 0.03), turn, shift)
        limits = [feeler.OpeningLimit("ball", "ball", width, 0.0, "-") for width in (0.02, 0.02 + 1e-9)]
        row = feeler.opening(scene, shift, turn[:, 2], limits=limits)
        assert abs(row.ball - 0.02) < 1e-13 and [bool(fit) for fit in row.fits] == [True, False]
    crossed = posed(
        {**frame_of(0.02, 0.03), "wire": box((-0.01, -1e-3, -1e-3), (0.01, 1e-3, 1e-3))}, np.eye(3), np.zeros(3)
    )
    assert feeler.opening(crossed, [0, 0, 0], Z).ball == 0.0


def test_windows_and_slots_at_any_turn() -> None:
    rng = np.random.default_rng(3)
    for width, height in ((0.06, 0.06), (0.12, 0.03), (0.05, 0.08), (0.3, 0.1)):
        turn, shift = turn_of(rng), rng.normal(size=3)
        scene = posed(frame_of(width, height), turn, shift)
        row = feeler.opening(scene, shift, turn[:, 2], aspect=height / width, across=turn[:, 0])
        assert about(row.width, width) and row.height == pytest.approx(height, abs=2 * ERROR)
        assert row.across == pytest.approx(turn[:, 0]) and row.turn_deg == 0.0
        assert about(row.ball, min(width, height)) and about(row.cylinder, min(width, height))
        free = feeler.opening(scene, shift, turn[:, 2], aspect=height / width)
        assert free.width == pytest.approx(width, abs=ERROR)
        assert width == height or abs(free.across @ turn[:, 0]) == pytest.approx(1.0, abs=1e-3)


def test_a_tilted_plate_is_narrower_by_its_thickness() -> None:
    """A slot between two bars, seen at an angle: of a height w and a thickness t there is w cos a - t sin a."""
    for degrees in (0.0, 10.0, 25.0, 40.0):
        a = math.radians(degrees)
        turn = np.array([[1.0, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
        scene = posed(frame_of(0.9, 0.05, 0.01), turn, np.zeros(3))
        row = feeler.opening(scene, [0.0, 0, 0], Z, across=[1.0, 0, 0], aspect=0.1)
        truth = 0.05 * math.cos(a) - 0.01 * math.sin(a)
        assert about(row.cylinder, truth), degrees
        assert truth - 0.1 * ERROR - 1e-9 <= row.height <= truth
        # The nearest corner of the bars is where the path of the ball passes it.
        assert row.ball == pytest.approx(truth, abs=1e-9)


def test_what_is_said_goes_through_and_a_tenth_of_a_millimetre_more_does_not() -> None:
    """Random bars around an axis: balls and cylinders of other meshes are cast on the same way."""
    rng = np.random.default_rng(5)
    for _ in range(12):
        parts = {}
        for k in range(6):
            turn, low = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-0.01, 0.01, 3)
            low += rng.uniform(0.02, 0.07) * np.array([np.cos(turn), np.sin(turn), 0.0])
            parts[f"bar {k}"] = box(low, low + rng.uniform(0.003, 0.02, 3))
        scene = feeler.Scene(mockup_of(parts))
        row = feeler.opening(scene, [0.0, 0, 0], Z)
        start, end = np.eye(4), np.eye(4)
        start[2, 3], end[2, 3] = -0.05, 0.05
        for size, is_free in ((row.cylinder - 4e-6, True), (row.cylinder + ERROR, False)):
            if size <= 0.0:
                continue
            probe = feeler.Tool(ring_of(0.5 * size, 720, 0.0), [[0, i, i + 1] for i in range(1, 719)])
            assert (scene.cast(probe, start, end) is None) == is_free
        side = 0.5 * row.width
        for more, is_free in ((-2e-6, True), (0.5 * ERROR + 1e-7, False)):
            x, y = (side + more) * row.across, (side + more) * np.cross(Z, row.across)
            if side + more <= 0.0:
                continue
            probe = feeler.Tool([-x - y, x - y, x + y, y - x], [[0, 1, 2], [0, 2, 3]])
            assert (scene.cast(probe, start, end) is None) == is_free
        line = np.column_stack([np.zeros(400), np.zeros(400), np.linspace(-0.05, 0.05, 400)])
        points = feeler.Tool([[0.0, 0, 0], [1e-9, 0, 0], [0, 1e-9, 0]], [[0, 1, 2]])
        poses = np.tile(np.eye(4), (400, 1, 1))
        poses[:, :3, 3] = line
        least = 2.0 * scene.distance_batch(points, poses).values.min()
        assert row.ball <= least + 5e-9 and least < row.ball + 2.0 * ERROR


def test_the_middle_is_found() -> None:
    scene = posed({"plate": round_hole(0.03)}, np.eye(3), np.zeros(3))
    off = feeler.opening(scene, [0.011, -0.006, 0.0], Z)
    assert off.ball < 0.04
    row = feeler.opening(scene, [0.011, -0.006, 0.0], Z, centre=True)
    assert about(row.ball, 0.06) and np.linalg.norm(row.at) < 2e-4
    # From its rim, too, where the ball is smaller than the error.
    slit = posed(frame_of(0.02, 0.06), np.eye(3), np.zeros(3))
    for off in (1e-6, 1e-5, 5e-5, 1e-3):
        row = feeler.opening(slit, [off - 0.01, 0.0, 0.0], Z, centre=True)
        assert about(row.ball, 0.02), off


def test_nothing_in_the_way_and_in_the_middle_of_a_part() -> None:
    scene = posed({"plate": round_hole(0.03)}, np.eye(3), np.zeros(3))
    free = feeler.opening(scene, [5.0, 0.0, 3.0], [1.0, 0.0, 0.0])
    assert (free.ball, free.cylinder, free.width) == (math.inf,) * 3 and free.stopped_by == ()
    block = feeler.Scene(mockup_of({"block": box((-1, -1, -1), (1, 1, 1))}))
    solid = feeler.opening(block, [0.0, 0, 0], Z)
    assert (solid.ball, solid.cylinder, solid.width) == (0.0, 0.0, 0.0)
    assert set(dict(solid.stopped_by).values()) == {"block"}
    wall = feeler.opening(block, [0.0, 0, 1.0], Z)
    assert (wall.ball, wall.cylinder, wall.width) == (0.0, 0.0, 0.0)


def test_limits_of_the_users(tmp_path: Path) -> None:
    file = tmp_path / "limits.toml"
    text = """version = 1
[[limit]]
name = "fist"
shape = "ball"
diameter_mm = 90
source = "mine"
[[limit]]
name = "flat hand"
shape = "box"
width_mm = 100
height_mm = 29
[[limit]]
name = "arm"
shape = "cylinder"
diameter_mm = 30.2
"""
    file.write_text(text)
    limits = feeler.opening_limits(file)
    scene = posed(frame_of(0.12, 0.03), np.eye(3), np.zeros(3))
    row = feeler.opening(scene, [0.0, 0, 0], Z, limits=limits)
    assert [(fit.limit.name, fit.is_through) for fit in row.fits] == [
        ("fist", False),
        ("flat hand", True),
        ("arm", False),
    ]
    assert (
        row.fits[1].largest == pytest.approx(0.03 / 0.29, abs=5e-4) and row.to_dict()["fits"][0]["largest"] == row.ball
    )
    for wrong, words in [
        (text.replace("version = 1", "version = 3"), "version is 3"),
        (text.replace('"ball"', '"egg"'), "shape is 'egg'"),
        (text.replace("diameter_mm = 90", "width_mm = 90"), "a ball has diameter_mm"),
        (text.replace("height_mm = 29", ""), "a box has width_mm and height_mm"),
        (text.replace("= 29", "= -29"), "height_mm is -29"),
        (text.replace("= 29", "= 0.5"), "0.01 to 100 times the width"),
        (text.replace("source", "from"), "'from' is unknown"),
        (LIMITS_TEMPLATE, "fill in those of your standard"),
    ]:
        file.write_text(wrong)
        with pytest.raises(feeler.LoadError, match=words):
            feeler.opening_limits(file)
    with pytest.raises(feeler.MissingFileError, match="write-limits"):
        feeler.opening_limits(tmp_path / "none.toml")
    write_limits_template(file)
    assert file.read_text() == LIMITS_TEMPLATE and "ISO 15534-2" in LIMITS_TEMPLATE


def test_wrong_questions() -> None:
    scene = posed({"plate": round_hole(0.03)}, np.eye(3), np.zeros(3))
    for more, words in [
        ({"axis": [0, 0, 0]}, "axis is"),
        ({"across": [0, 0, 2.0]}, "across is along the axis"),
        ({"aspect": 0.0}, "aspect is"),
        ({"error": 1.0}, "error is"),
        ({"most": 1e-5}, "most is"),
        ({"limits": ["fist"]}, "limits is 'fist'"),
    ]:
        with pytest.raises(feeler.OptionError, match=words):
            feeler.opening(scene, **{"at": [0.0, 0, 0], "axis": Z, **more})


def test_the_command(tmp_path: Path) -> None:
    plate, limits = tmp_path / "plate.glb", tmp_path / "limits.toml"
    write_glb(plate, mockup_of(frame_of(0.12, 0.03)))
    words = ["opening", plate, "--at", "0.01,0,0", "--axis", "0,0,1"]
    text = run(*words, "--aspect", "0.25", "--across", "1,0,0").stdout
    assert "30.0 mm" in text and "100.0 mm x 25.0 mm" in text and "stopped by" in text
    assert "fill in" in run("opening", "--write-limits", limits).stdout
    assert "there is no [[limit]]" in error_of(*words, "--limits", limits)
    limits.write_text('version = 1\n[[limit]]\nname = "fist"\nshape = "cylinder"\ndiameter_mm = 80\nsource = "mine"\n')
    found = run_json(*words, "--limits", limits, "--centre", code=1)
    assert found["ball"] == pytest.approx(0.03, abs=1e-6) and not found["fits"][0]["is_through"]
    assert "no" in run(*words, "--limits", limits, code=1).stdout
    assert "give --at X,Y,Z and --axis X,Y,Z" in error_of("opening", plate)
    assert "there is no mock-up" in error_of("opening", "--at", "0,0,0", "--axis", "0,0,1")


@pytest.mark.parametrize("turn_deg", [0.0, 13.7, 30.0])
@pytest.mark.parametrize(("slit", "aspect"), [(0.0005, 1.0), (0.0005, 0.05), (0.003, 0.1), (0.01, 0.01), (0.01, 20.0)])
def test_boxes_in_a_narrow_slit(slit: float, aspect: float, turn_deg: float) -> None:
    """The turn of a slender box costs many times more of its width than of its height."""
    parts = {
        "high": box((-1.0, slit / 2, -0.005), (1.0, 1.0, 0.005)),
        "low": box((-1, -1, -0.005), (1, -slit / 2, 0.005)),
    }
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    scene = posed(parts, np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))
    found = feeler.opening(scene, [0.0, 0.0, 0.0], Z, aspect=aspect, reach=0.02, most=2.0)
    assert about(found.width, slit / min(aspect, 1.0)), found.width
    assert found.height == pytest.approx(aspect * found.width)


def widest_in(width: float, height: float, aspect: float) -> float:
    """The width of the largest box in a window at any turn, to a billionth of a metre."""

    def sizes(angles: np.ndarray) -> np.ndarray:
        c, s = abs(np.cos(angles)), abs(np.sin(angles))
        return np.asarray(np.minimum(width / (c + aspect * s), height / (s + aspect * c)))

    angles, step = np.linspace(0.0, math.pi, 20_001, retstep=True)
    found = sizes(angles)
    best = angles[found > found.max() - 1e-5]  # which of these is the best may be between two angles
    return float(sizes(best[:, None] + float(step) * np.linspace(-1.0, 1.0, 4001)).max())


@pytest.mark.parametrize("aspect", [0.1, 0.25, 0.6, 4.0])
def test_no_turn_of_a_box_in_a_window_is_missed(aspect: float) -> None:
    """There are several that no small turn betters."""
    rng = np.random.default_rng(1)
    for width, height in [*rng.uniform(0.005, 0.08, (6, 2)).tolist(), [0.01985, 0.02791]]:
        turn, shift = turn_of(rng), rng.uniform(-1.0, 1.0, 3)
        truth = widest_in(width, height, aspect)
        found = feeler.opening(posed(frame_of(width, height), turn, shift), shift, turn[:, 2], aspect=aspect)
        assert about(found.width, truth), (width, height)


def test_sizes_beyond_the_most_are_none_in_json() -> None:
    rows = (("arm", "cylinder", 0.1, 0.0), ("lid", "box", 0.2, 0.1))
    limits = [feeler.OpeningLimit(*row, "own") for row in rows]
    found = feeler.opening(feeler.Scene(mockup_of({"plate": round_hole(0.3)})), (0, 0, 0), Z, most=0.2, limits=limits)
    assert math.isinf(found.ball) and math.isinf(found.fits[0].largest)
    row = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert [row[name] for name in ("ball", "cylinder", "width", "height")] == [None] * 4
    assert [fit["largest"] for fit in row["fits"]] == [None, None]
