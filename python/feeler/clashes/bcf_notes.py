"""Status and note of one finding as a BCF comment, and back.

A topic has one status for all findings of a group, so a comment keeps what differs:

    approved: drawn so
    pump is 3 mm deep in case. Finding 5c9b7d5e-..., topic active.
"""

from __future__ import annotations

import re
from typing import NamedTuple, cast

from feeler.choices import SETTABLE_STATUSES, Status
from feeler.clashes.tracking import Mark

SYSTEM = "feeler"
"""The author of topics and comments of nobody."""
LONGEST_NOTE = 10_000
"""Characters of a note in a comment, and of one that is read."""

_WORDS = "|".join(SETTABLE_STATUSES)
_UUID = "[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}"
_OWN = re.compile(rf"({_WORDS})(?:: (.*))?\n[^\n]*Finding ({_UUID}), topic ({_WORDS})\.", re.DOTALL)


class FindingNote(NamedTuple):
    """What a comment says of one finding. topic: the status of its topic when the comment was written."""

    finding: str
    status: Status
    note: str
    topic: str


def comment_of(finding: str, mark: Mark, sentence: str, topic: str) -> str | None:
    """The text of a comment; None if the topic says as much. topic: its status."""
    if not mark.note and mark.status == topic:
        return None
    note = f": {mark.note[:LONGEST_NOTE]}" if mark.note else ""
    return f"{mark.status}{note}\n{' '.join(sentence.split())}. Finding {finding}, topic {topic}."


def note_of(comment: str) -> FindingNote | None:
    """What a comment of `comment_of` says; None for others."""
    found = _OWN.fullmatch(comment.strip().replace("\r\n", "\n"))
    if found is None:
        return None
    status, note, finding, topic = found.groups()
    return FindingNote(finding, cast("Status", status), (note or "").strip()[:LONGEST_NOTE], topic)
