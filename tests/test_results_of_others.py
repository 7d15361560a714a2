"""Pictures and films of results that are of another mock-up or tool: an error in words, not an index out of range."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import box, cube, inverted, joined, mockup_of

import feeler
from feeler import picture
from feeler.plan.as_glb import write_removal_glb

TOOL = feeler.Tool(*cube((0, 0, 0), 0.5))
POSE = np.eye(4)
FAR, LEFT, RIGHT = (box((x, 0, 0), (x + 1, 1, 1)) for x in (5, -1, 0))
# The first part is far away: those that collide have larger numbers, and so have their triangles.
MOCKUP = mockup_of({"far": FAR, "left": LEFT, "right": RIGHT})
OTHERS = {
    "fewer parts": mockup_of({"one": LEFT}),
    "as many parts, fewer triangles": mockup_of({"a": LEFT, "b": (LEFT[0], LEFT[1][:1]), "c": RIGHT}),
    "the triangles are of other parts": mockup_of({"a": joined(FAR, LEFT, RIGHT), "b": LEFT, "c": RIGHT}),
}


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(MOCKUP, threads=1)


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize(
    "draw",
    ["collision_bodies", "write_collision_glb", "render_collision", "clearance_bodies", "write_clearance_glb"],
)
def test_triangles_of_another_mockup_are_refused(name: str, draw: str, scene: feeler.Scene, tmp_path: Path) -> None:
    found: Any = scene.clearance(TOOL, POSE, 0.5) if "clearance" in draw else scene.collide(TOOL, POSE)
    assert found.parts.min() > 0
    path = {"write": (tmp_path / "a.glb",), "render": (None,)}.get(draw.partition("_")[0], ())
    with pytest.raises(feeler.OptionError, match="of another mock-up"):
        getattr(picture, draw)(*path, OTHERS[name], TOOL, POSE, found)
    assert not list(tmp_path.iterdir())
    getattr(picture, draw)(*path, MOCKUP, TOOL, POSE, found)


def test_triangles_of_another_tool_are_refused(scene: feeler.Scene) -> None:
    found = scene.collide(TOOL, POSE)
    other = feeler.Tool(TOOL.vertices, TOOL.faces[: int(found.tool_triangles.max())])
    with pytest.raises(feeler.OptionError, match="of another tool"):
        picture.collision_bodies(MOCKUP, other, POSE, found)


def test_steps_of_another_mockup_are_refused(scene: feeler.Scene, tmp_path: Path) -> None:
    shell = joined(box((-1, -1, -1), (2, 2, 2)), inverted(box((-0.5, -0.5, -0.5), (1.5, 1.5, 1.5))))
    closed = mockup_of({"inner": RIGHT, "outer": shell})
    held = feeler.removal(feeler.Scene(closed, threads=1), "inner", rounds=1)
    assert [each.path for each in held.blocked_by] == ["outer"]
    out, blocked = feeler.removal_order(scene, "right", seconds=10.0).steps, [feeler.RemovalStep((0,), held)]
    for mockup, steps in ((MOCKUP, out), (closed, blocked)):
        assert write_removal_glb(tmp_path / "a.glb", mockup, steps) > 0
    for mockup, steps in ((mockup_of({"one": LEFT}), out), (mockup_of({"inner": RIGHT, "case": shell}), blocked)):
        with pytest.raises(feeler.OptionError, match="of another mock-up"):
            write_removal_glb(tmp_path / "b.glb", mockup, steps)
        assert not (tmp_path / "b.glb").exists()
