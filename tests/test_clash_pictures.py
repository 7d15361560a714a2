"""Pictures of findings: what is drawn of large parts, and that parts are looked up once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from clash_scene import house

import feeler
from feeler.choices import UpAxis
from feeler.clashes import pictures, write_html
from feeler.clashes.pictures import Pictures, _Triangles
from feeler.part_meshes import PartMeshes
from feeler.picture.camera import upright_frame, usual_view, vertical_of
from feeler.source import Source
from feeler.workbench.engine.geometry import Geometry
from feeler.workbench.report.values import PairPlace


def test_the_triangles_near_a_place_are_those_whose_boxes_meet_it(rng: np.random.Generator) -> None:
    corners = rng.uniform(-1, 1, (500, 1, 3)) + rng.uniform(-0.1, 0.1, (500, 3, 3))
    low, high = np.array([-0.25, -0.5, 0.0]), np.array([0.25, 0.5, 0.5])
    boxes = [(each.min(axis=0), each.max(axis=0)) for each in corners]
    expected = [i for i, (least, most) in enumerate(boxes) if (least <= high).all() and (most >= low).all()]
    assert 5 < len(expected) < 495 and _Triangles(corners).near(low, high).tolist() == expected


def test_parts_are_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A casing of a million triangles is in most findings."""
    mockup, asked = house(), []
    corners = PartMeshes.corners
    monkeypatch.setattr(PartMeshes, "corners", lambda self, part: asked.append(part) or corners(self, part))
    drawn = Pictures(mockup)
    for finding in feeler.clash(mockup):
        drawn.png(finding)
    assert len(asked) == len(set(asked)) == mockup.part_count


def test_what_is_kept_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    mockup = house()
    monkeypatch.setattr(pictures, "_KEPT_TRIANGLES", 30)
    drawn = Pictures(mockup)
    images = [drawn.png(finding) for finding in feeler.clash(mockup)]
    assert len(drawn._kept) == 2
    monkeypatch.undo()
    again = Pictures(mockup)
    assert images == [again.png(finding) for finding in feeler.clash(mockup)]


def test_the_page_tells_its_progress(tmp_path: Any) -> None:
    mockup, told = house(), []
    found = feeler.clash(mockup)
    write_html(tmp_path / "a.html", found, mockup, progress=lambda share, stage: told.append((share, stage)))
    shares = [share for share, _ in told]
    assert len(told) >= len(found.groups()) and shares == sorted(shares) and 0.0 <= shares[0] <= shares[-1] <= 1.0


@pytest.mark.parametrize("gap", [0.001, 0.074])
def test_both_parts_of_a_gap_are_seen(monkeypatch: pytest.MonkeyPatch, gap: float) -> None:
    """Whichever lies towards the camera: a cut does not remove it, and the picture reaches over the gap."""
    taken: list[Any] = []
    monkeypatch.setattr(pictures, "write_png", lambda _out, image: taken.append(image))
    box = trimesh.creation.box((0.02, 0.02, 0.02))
    for axis in range(3):
        for side in (1.0, -1.0):
            away = np.zeros(3)
            away[axis] = side * (0.02 + gap)
            mockup = feeler.Mockup(
                np.concatenate([box.vertices, box.vertices + away]),
                np.concatenate([box.faces, box.faces + 8]),
                np.repeat([0, 1], 12),
                ["a", "b"],
            )
            (found,) = feeler.clash(mockup, 0.1)
            Pictures(mockup).png(found)
            image = taken.pop().astype(int)
            blue = (image[..., 2] > image[..., 0] + 40).mean()
            orange = (image[..., 0] > image[..., 2] + 60).mean()
            assert blue > 0.002 and orange > 0.002, (axis, side, blue, orange)


@pytest.mark.parametrize("up", ["x", "y", "z", None])
@pytest.mark.parametrize("long", range(3))
def test_pictures_stand_as_in_the_page(up: UpAxis | None, long: int) -> None:
    """Whichever side is the longest: a tower lies down only in a file that says so."""
    box = trimesh.creation.box(np.where(np.arange(3) == long, 0.5, 0.02))
    away = np.where(np.arange(3) == (long + 1) % 3, 0.015, 0.0)
    corners, faces = np.concatenate([box.vertices, box.vertices + away]), np.concatenate([box.faces, box.faces + 8])
    source = Source(up=up)
    mockup = feeler.Mockup(corners, faces, np.repeat([0, 1], 12), ["a", "b"], source=source)
    (found,) = feeler.clash(mockup)
    above = np.eye(3)["xyz".index(up or "z")]
    _, upward, _ = Pictures(mockup).view(found).camera.axes()
    assert upward @ above > 0.4
    geometry = Geometry(feeler.Scene(mockup), "", "")
    assert geometry.manifest()["up"] == source.vertical == vertical_of(mockup)
    for pictured in (usual_view(mockup.bounds, source.vertical), usual_view(np.zeros((2, 3)), source.vertical)):
        assert (pictured[1] == above).all() and pictured[0] @ upright_frame(source.vertical)[1] > 0.0, "from the front"


def plates(gap: float, out: float = 0.0) -> feeler.Mockup:
    """Two plates over each other with a gap, and a lip of the upper one that hides the gap from three sides."""
    boxes = [
        trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.1, 0.1, 0.01]]),
        trimesh.creation.box(bounds=[[0.0, 0.0, 0.01 + gap], [0.1, 0.1, 0.02]]),
        trimesh.creation.box(bounds=[[-0.02, -0.02, -0.01], [0.12, -0.01, 0.02]]),
        trimesh.creation.box(bounds=[[-0.02, -0.02, -0.01], [-0.01, 0.12, 0.02]]),
        trimesh.creation.box(bounds=[[-0.02, 0.11, -0.01], [0.12, 0.12, 0.02]]),
    ]
    if out:
        boxes.append(trimesh.creation.box(bounds=[[0.11, -0.02, -0.01], [0.12, 0.12, 0.02]]))
    corners = np.concatenate([each.vertices for each in boxes])
    faces = np.concatenate([each.faces + 8 * number for number, each in enumerate(boxes)])
    return feeler.Mockup(corners, faces, np.repeat(np.minimum(np.arange(len(boxes)), 1), 12), ["lower", "upper"])


@pytest.mark.parametrize("is_closed", [False, True])
@pytest.mark.parametrize("point", [(0.05, 0.05), (0.1, 0.05), (0.1, 0.1)])
def test_the_place_of_a_gap_is_seen(point: tuple[float, float], is_closed: bool) -> None:
    """From the open side, or cut open where there is none: exact rays from the eye meet nothing before it."""
    mockup = plates(0.001, float(is_closed))
    one, other = (*point, 0.01), (*point, 0.011)
    found = PairPlace(0, 1, one, other, (0.0, 0.0, 0.0))
    view = Pictures(mockup).view(found)
    eye, place = np.array(view.camera.eye), (np.array(one) + np.array(other)) / 2
    kept = None if view.normal is None else [[*-view.normal, -float(view.normal @ view.point)]]
    way = place - eye
    (met,) = (
        feeler.Scene(mockup).rays(eye[None], way[None], within=0.999 * np.linalg.norm(way), sections=kept).triangles
    )
    assert met < 0
    assert view.normal is not None or point != (0.05, 0.05) or not is_closed
