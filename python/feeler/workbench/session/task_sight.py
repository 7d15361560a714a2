"""What the mechanic sees of the fastener of a step: the share of its head, and a picture from the best eye."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from feeler.io.body import LIGHT_GREY, STEEL_BLUE, body_of
from feeler.mockup import Mockup, Tool
from feeler.picture.camera import Camera
from feeler.picture.png import write_png
from feeler.picture.renderer import render
from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners
from feeler.plan.sight import sight
from feeler.scene import Scene
from feeler.tasks.nightly import eyes_over
from feeler.workbench.document.answers import TaskSight, TaskStepFacts, WayFacts

Floats = npt.NDArray[np.float64]

SIZE = (320, 200)
"""Pixels of the picture."""
HEADS = 9.0
"""The picture is as high as so many heads, and as `LEAST_M` at least."""
LEAST_M = 0.06
SHOWN_M = 0.6
"""Parts farther from the head than this are not drawn, metres."""
MOST_NAMED = 3
NEARLY = 0.1
"""The picture may show so much less of the head than the best eye sees."""


def gone_before(steps: Sequence[TaskStepFacts], ways: Sequence[WayFacts], number: int) -> set[int]:
    """The parts that are out before a step: what is disconnected is still there."""
    return {
        part
        for step, way in zip(steps[:number], ways[:number], strict=True)
        if step["verb"] != "disconnect"
        for part in way["parts"]
    }


def seen_at(scene: Scene, part: int) -> TaskSight | None:
    """What is seen of a fastener in a scene; None if the part is none."""
    rows = find_fasteners(scene, [part])
    if not len(rows):
        return None
    row = rows[0]
    eyes = eyes_over(row)
    found = sight(scene, Fasteners([row]), eyes)[0]
    # Of eyes that see nearly as much the one that looks most along the axis: the last ones are the highest.
    best = int(np.flatnonzero(found.shares >= found.share - NEARLY)[-1])
    numbers: Mapping[str, int] = {path: each for each, path in enumerate(scene.mockup.part_paths)}
    hidden = [path for path, _ in found.hidden_by if path != row.path]
    return {
        "share": found.share,
        "hidden_by": [numbers[path] for path in hidden[:MOST_NAMED]],
        "picture": base64.b64encode(_picture(scene, row, eyes[best])).decode("ascii"),
        "size": SIZE,
    }


def _picture(scene: Scene, row: Fastener, eye: Floats) -> bytes:
    """As PNG: from an eye at the head, which is blue."""
    mockup, head = scene.mockup, row.frame[:3, 3]
    parts = _near(mockup, scene.part_mask, head)
    colours = np.tile(np.array(LIGHT_GREY), (len(parts), 1))
    colours[parts.index(row.part)] = STEEL_BLUE
    bounds = mockup.part_bounds.reshape(-1, 2, 3)[row.part]
    wide = row.across_flats if np.isfinite(row.across_flats) else float((bounds[1] - bounds[0]).min())
    far = float(np.linalg.norm(head - eye))
    fov = float(np.degrees(2.0 * np.arctan(0.5 * max(HEADS * wide, LEAST_M) / far)))
    up = (0.0, 0.0, 1.0) if abs(head[2] - eye[2]) < 0.95 * far else (0.0, 1.0, 0.0)
    camera = Camera(_triple(eye), _triple(head), up, fov_deg=min(90.0, fov))
    file = io.BytesIO()
    body = body_of(Tool.of_parts(mockup, parts, "seen"), colours=colours)
    write_png(file, render(None, body, camera=camera, size=SIZE))
    return file.getvalue()


def _near(mockup: Mockup, mask: npt.NDArray[np.bool_], head: Floats) -> list[int]:
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    gap = np.maximum(bounds[:, 0] - head, head - bounds[:, 1]).max(axis=1)
    near: list[int] = np.flatnonzero((gap <= SHOWN_M) & mask).tolist()
    return near


def _triple(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
