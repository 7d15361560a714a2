"""Commands that let a way guide the hand, which holds its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from feeler.errors import WorkbenchError
from feeler.poses import inverse
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Document, Guiding
from feeler.workbench.document.known import Known
from feeler.workbench.document.motion import Floats, Row

GUIDES = ("guide", "guide_end")
"""The commands here: whoever has the tool decides what draws it."""
SAME_M = 1e-3
"""Parts that lie nearer than this to where the way has them are where it has them."""


def guide(document: Document, given: Arguments, known: Known) -> Document:
    """Lets a way guide the hand: step `step` of a card's ways, or the way of a line of the sequence.

    The hand holds its parts. If they are nearer to its end than to its begin, it guides back. It ends by itself there,
    or when the hand lets go of them. Up to 0.1 of the size of what is in the hand (2 to 50 mm) off the way, a wish is
    drawn onto it, and beyond 0.4 (10 to 200 mm) not at all; typed poses are not drawn. A device feels at most 1.5 N.
    """
    if given.has("line") == given.has("card"):
        raise WorkbenchError("name a card, or a line of the sequence", given.command, "send one of the two")
    card = line = None
    step = 0
    if given.has("card"):
        asked = document.cards[given.place_of(document.cards, "card")]
        card, ways = asked.id, known.ways.get(asked.id, ())
        step = given.whole("step", 0, max(0, len(ways) - 1)) if given.has("step") else 0
        if not ways or not asked.is_good:
            raise given.fail("card", "this card has no way that is free", "ask how the parts come out")
        moves = [motion.matrix(pose) for pose in ways[step].poses]
        parts, starts = ways[step].parts, dict(asked.world[0])
    else:
        removal = document.sequence[given.place_of(document.sequence, "line")]
        line, parts, starts = removal.id, removal.parts, dict(removal.before)
        first = inverse(motion.matrix(removal.way[0]))
        moves = [motion.matrix(pose) @ first for pose in removal.way]
    missing = [known.parts[part].path for part in parts if part not in document.gripped]
    if missing:
        raise WorkbenchError(f"{missing[0]} is not in the hand", given.command, "grip the parts of the way first")
    way = _of_hand(document, moves, parts, starts, known, given)
    # From where the hand is: back, if it is at the end.
    here, corners = motion.matrix(known.pose), _corners(document, parts, known)
    if motion.carried(here, way[-1], corners) < motion.carried(here, way[0], corners):
        way = way[::-1]
    return replace(document, guiding=Guiding(card, line, step, parts, tuple(motion.row(pose) for pose in way)))


def guide_end(document: Document, _given: Arguments, _known: Known) -> Document:
    """Ends the guidance of the hand."""
    return replace(document, guiding=None)


def _of_hand(
    document: Document,
    moves: Sequence[Floats],
    parts: Sequence[int],
    starts: Mapping[int, Row],
    known: Known,
    given: Arguments,
) -> list[Floats]:
    """The poses of the hand on a way of the parts that it holds."""
    begins = {
        part: motion.matrix(starts.get(part, motion.HOME)) @ inverse(motion.matrix(document.gripped[part]))
        for part in parts
    }
    begin = begins[parts[0]]
    for part, other in begins.items():
        if motion.carried(begin, other, _corners(document, [part], known)) > SAME_M:
            path = known.parts[part].path
            raise WorkbenchError(f"{path} is held otherwise than on the way", given.command, "grip all of them anew")
    return [move @ begin for move in moves]


def _corners(document: Document, parts: Sequence[int], known: Known) -> Floats:
    """Of the boxes of parts, in the hand."""
    boxes = []
    for part in parts:
        held = motion.matrix(document.gripped[part])
        box = np.array([known.parts[part].lower, known.parts[part].upper])
        boxes.append(motion.corners(box) @ held[:3, :3].T + held[:3, 3])
    return np.concatenate(boxes)
