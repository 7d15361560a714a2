"""The length of a line's way, its newest check and its least clearance.

One rule for the page, its files and reports.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from feeler.poses import inverse
from feeler.workbench.document.document import NONE_GONE, UP_TO_DATE, Card, Document, Removal, is_stale
from feeler.workbench.document.motion import Floats, matrix, middle_of, row, steps_of


def line_steps(line: Removal, motions: Floats, bounds: Floats) -> tuple[list[float], list[float]]:
    """Travel and rotation from pose to pose, as `steps_of`, of the parts of a line.

    motions: of the parts, `(n, 4, 4)`. bounds: of all parts of the mock-up.
    """
    boxes = bounds.reshape(-1, 2, 3)[list(line.parts)]
    places = [matrix(line.before[part]) for part in line.parts]
    # The box of what a joint moves turns with it, so that the way there is as long as the way back.
    frame = np.eye(4) if line.joint is None else places[0]
    middle = middle_of(boxes, [row(inverse(frame) @ place) for place in places])
    return steps_of(motions, frame[:3, :3] @ middle + frame[:3, 3])


def line_length(line: Removal, bounds: Floats) -> float:
    """The length of its way, metres."""
    way = np.array([matrix(pose) for pose in line.way])
    return sum(line_steps(line, way @ inverse(way[0]), bounds)[0])


def newest_check(document: Document, line: Removal) -> Card | None:
    """The newest check of its way, if the way, and what is around it, is still that one."""
    cards = [card for card in document.cards if (card.line, card.question) == (line.id, "way")]
    return next((card for card in reversed(cards) if card.state == "done" and not is_stale(document, card)), None)


def least_clearance(document: Document, line: Removal) -> float | None:
    """That of its newest check, if the way holds, else that of the hand; metres. None: nothing was near."""
    check = newest_check(document, line)
    return check.clearances[0] if check is not None and check.is_good and check.clearances else line.least_clearance


def with_checked_lines(document: Document) -> Document:
    """The document, in which lines whose way was checked in this revision of the mock-up are up to date."""
    checks = ((line, newest_check(document, line) if line.stale or line.gone else None) for line in document.sequence)
    checked = {line.id for line, check in checks if check is not None and check.is_good is not None}
    if not checked:
        return document
    lines = (
        replace(line, stale=UP_TO_DATE, gone=NONE_GONE) if line.id in checked else line for line in document.sequence
    )
    return replace(document, sequence=tuple(lines))
