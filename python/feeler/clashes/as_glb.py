"""Findings as GLB: parts in the colour of their worst verdict, and a line for each finding."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind
from feeler.clashes.result import Clashes
from feeler.clashes.table import check_same
from feeler.clashes.verdict import Verdict
from feeler.io.body import LIGHT_GREY, ORANGE, RED, STEEL_BLUE, Body, Colour, body_of
from feeler.io.export import write_glb
from feeler.mockup import Mockup

VIOLET: Colour = (0.55, 0.25, 0.70)
GREEN: Colour = (0.30, 0.62, 0.36)

COLOUR_OF: dict[Verdict, Colour] = {
    Verdict.CLASH: RED,
    Verdict.CONTACT: GREEN,
    Verdict.CLEARANCE: STEEL_BLUE,
    Verdict.CONTAINED: VIOLET,
    Verdict.DUPLICATE: ORANGE,
}
_THICKNESS_SHARE = 0.0005  # of the mock-up's size


def clash_bodies(mockup: Mockup, clashes: Clashes) -> tuple[Body, ...]:
    """The mock-up and the lines of its findings, coloured.

    A part has the colour of its worst finding; parts without findings are light grey. A line shows the translation of
    a finding, or joins its two points if it has none. An unknown translation has no line.
    """
    from feeler.picture.bars import LEAST_THICKNESS_M, bars

    check_same(mockup, clashes)
    colours = np.tile(np.array(LIGHT_GREY), (mockup.part_count, 1))
    for row in range(len(clashes) - 1, -1, -1):
        colour = COLOUR_OF[Verdict(clashes.columns.verdict[row])]
        colours[[clashes.parts_a[row], clashes.parts_b[row]]] = colour
    body = body_of(mockup, colours=colours)
    has_way_out = np.asarray(clashes.translations.any(axis=1))
    start = np.nan_to_num(clashes.points_a)
    way_out = clashes.points_a + np.nan_to_num(clashes.translations)
    end = np.nan_to_num(np.where(has_way_out[:, None], way_out, clashes.points_b))
    size = float(np.linalg.norm(mockup.bounds[1] - mockup.bounds[0]))
    paths = [f"witness lines/{name} {i}" for i, name in enumerate(clashes.verdicts.tolist())]
    lines = bars(start, end, max(_THICKNESS_SHARE * size, LEAST_THICKNESS_M), paths)
    return (body,) if lines is None else (body, lines)


def write_clash_glb(path: str | os.PathLike[str], clashes: Clashes, mockup: Mockup) -> int:
    """Writes `clash_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    check_kind("clashes", clashes, Clashes)
    return write_glb(path, *clash_bodies(mockup, clashes))


def _verdicts(verdict: npt.NDArray[np.uint8]) -> list[str]:
    return [Verdict(each).name.lower() for each in verdict.tolist()]
