"""The tool that draws: a PNG in memory, of a bounded size."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from feeler.agent.answers import part_names
from feeler.agent.job import Job
from feeler.agent.queries import Answer, Given
from feeler.agent.served import Served
from feeler.errors import OptionError
from feeler.io.body import LIGHT_GREY, RED, Body, body_of, only_faces
from feeler.mockup import Mockup
from feeler.picture import Camera, Section, render, render_collision
from feeler.picture.camera import triple, usual_view
from feeler.picture.png import write_png

LARGEST_PX, SMALLEST_PX = 1024, 64
"""Sides of a picture."""
MOST_PNG_BYTES = 700_000
"""The largest picture: as text in a message it is a third longer. Pictures of more detail are made smaller."""
_SMALLER = 0.7  # each time


def picture(served: Served, given: Given, job: Job) -> tuple[Answer, bytes]:
    """A picture of the mock-up, of some of its parts, or of a tool at a pose, with what it hits; as PNG."""
    draw = _collision if given["pose"] is not None or given["tool"] is not None else _mockup
    size = (given["width_px"], given["height_px"])
    while True:
        answer, image = draw(served, given, job, size)
        job.check()
        png = io.BytesIO()
        write_png(png, image)
        if png.tell() <= MOST_PNG_BYTES:
            return {**answer, "width_px": size[0], "height_px": size[1], "png_bytes": png.tell()}, png.getvalue()
        size = (int(size[0] * _SMALLER), int(size[1] * _SMALLER))


def _view(given: Given, bounds: Any, mockup: Mockup) -> tuple[Any, Any]:
    direction, up = usual_view(bounds, mockup.source.vertical)
    return (
        direction if given["direction"] is None else np.array(given["direction"]),
        up if given["up"] is None else np.array(given["up"]),
    )


def _collision(served: Served, given: Given, job: Job, size: tuple[int, int]) -> tuple[Answer, Any]:
    """The mock-up, cut open at the tool."""
    if given["section"] is not None or given["only"] is not None:
        raise OptionError("section and only are for pictures without a tool: leave out tool and pose, or these")
    if given["pose"] is None:
        raise OptionError("the tool has no pose: give pose, or leave out tool")
    scene, tool = served.moving(given)
    hit = scene.collide(tool, given["pose"])
    direction, up = _view(given, served.mockup.bounds, served.mockup)
    image = render_collision(
        None,
        served.mockup,
        tool,
        given["pose"],
        hit,
        size=size,
        direction=direction,
        up=up,
        parts=scene.part_mask,
        progress=job.progress,
    )
    return {"hit": {"count": len(hit.parts), "first": part_names(served.mockup, hit.parts)}}, image


def _mockup(served: Served, given: Given, job: Job, size: tuple[int, int]) -> tuple[Answer, Any]:
    """The mock-up, some of its parts in red."""
    scene, mockup = served.standing(given), served.mockup
    shown = scene.part_mask.copy()
    if given["only"] is not None:
        wanted = np.zeros(len(shown), dtype=bool)
        wanted[served.select("only", given["only"])] = True
        shown &= wanted
    colours = None
    answer: Answer = {}
    if given["part"] is not None:
        red = served.select("part", given["part"])
        colours = np.tile(np.array(LIGHT_GREY), (mockup.part_count, 1))
        colours[red] = RED
        answer["red"] = {"count": len(red), "first": part_names(mockup, red)}
    body: Body = body_of(mockup, colours=colours)
    if not shown.all():
        body = only_faces(body, shown[body.part_of_face])
    if not len(body.faces):
        raise OptionError("nothing to show: name other parts")
    section = None
    if given["section"] is not None:
        section = Section(given["section"]["point_m"], given["section"]["normal"])
    points = body.points
    if section is not None:
        normal, offset = section.plane()
        kept = points[points @ normal <= offset]
        points = kept if len(kept) else points
    direction, up = _view(given, np.array([points.min(axis=0), points.max(axis=0)]), mockup)
    camera = Camera.framing(points, triple(direction), triple(up), size=size)
    return answer, render(None, body, camera=camera, size=size, section=section, progress=job.progress)
