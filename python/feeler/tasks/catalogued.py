"""The tools of a catalogue that are of use at a fastener."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from feeler.plan.blocked import Blocker
from feeler.plan.catalogue import Catalogue
from feeler.plan.choosing import Chosen, HeadShape, head_shapes, reaches, strokes_for
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.reach import Reach, TriedTool
from feeler.plan.reach_question import SeatSearch
from feeler.plan.tool_spec import depths_of
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

APPROACH_M = 0.1
"""How far each way in is searched, as in `access`."""
ANGLES = 72
"""Even seats that are tried first, as in `access`."""


@dataclass
class Catalogued:
    """Asks which tools of a catalogue reach a fastener, and how far they swing."""

    catalogue: Catalogue
    chosen: Chosen = field(init=False, repr=False)
    shapes: dict[int, HeadShape] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        # The swing is what each tool needs; nothing else of the search but its length bears on it.
        self.chosen = Chosen(self.catalogue, SeatSearch(1.0, ANGLES, APPROACH_M, 0.0), None, None)

    def rooms(self, row: Fastener) -> tuple[Floats, Floats]:
        """The box, in the frame of a fastener, that all tools that fit it stay in when they turn and on their ways in;
        without tools that fit, a point."""
        radius, low, high = 0.0, 0.0, 0.0
        for pieces in self.catalogue.fitting(row.drive, row.across_flats, row.size):
            seated = self.chosen.seated(pieces)
            vertices, bounds = seated.tool.vertices, seated.tool.bounds
            radius = max(radius, float(np.hypot(vertices[:, 0], vertices[:, 1]).max()))
            depths = list(depths_of(pieces[0], row.length if row.kind == "nut" else row.head_height))
            low = min([low, *(float(bounds[0, 2]) - depth for depth in depths)])
            high = max([high, *(float(bounds[1, 2]) - depth for depth in depths)])
        reach = radius + APPROACH_M
        return np.array([-reach, -reach, low]), np.array([reach, reach, high + APPROACH_M])

    def reached(self, scene: Scene, row: Fastener, turns: float) -> tuple[list[Reach], Counter[int], str]:
        """The tools that reach a fastener, what is in the way of the others, and why they do not.

        Of those that reach, in the order of the catalogue, one is kept if it needs fewer strokes than all before it.
        """
        if row.part not in self.shapes:
            (self.shapes[row.part],) = head_shapes(scene.mockup, Fasteners([row]))
        tried: list[TriedTool] = []
        kept: list[Reach] = []
        blockers: Counter[int] = Counter()
        reasons = []
        answers = reaches(scene, self.chosen, 0, row, row.frame, self.shapes[row.part], turns, tried)
        for answer in answers:
            if not answer.is_reachable:
                tried.append(TriedTool(str(answer.tool), answer.because, answer.blockers))
            elif all(strokes_for(turns, answer.stroke_deg) < strokes_for(turns, each.stroke_deg) for each in kept):
                kept.append(answer)
        for each in tried:
            reasons.append(f"{each.tool}: {each.because}")
            blockers.update(counts_of(each.blockers))
        if not kept and not tried:
            reasons.append("no tool of the catalogue fits it")
        return kept, blockers, "; ".join(reasons)


def counts_of(blockers: tuple[Blocker, ...]) -> dict[int, int]:
    """How often each part was in the way."""
    return {each.part: each.count for each in blockers}
