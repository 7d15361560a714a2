"""What BCF says of single findings, and back: status and note in a comment, verdict and depth in the description.

A topic has one status for all findings of a group, so a comment keeps what differs:

    approved: drawn so
    pump is 3 mm deep in case. Finding 5c9b7d5e-..., topic active.

A line of the description ends with the id, verdict and depth (metres; a gap is negative) of its finding. Those that are
too many for a description are in a comment of their own, so that a status reaches all:

    Further findings of this topic:
    5c9b7d5e-...; clash, 0.003 m
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple, cast

from feeler.choices import SETTABLE_STATUSES, Status, VerdictName
from feeler.clashes.tracking import Found, Mark
from feeler.clashes.verdict import Verdict

SYSTEM = "feeler"
"""The author of topics and comments of nobody."""
LONGEST_NOTE = 10_000
"""Characters of a note in a comment, and of one that is read."""

_WORDS = "|".join(SETTABLE_STATUSES)
_UUID = "[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}"
_OWN = re.compile(rf"({_WORDS})(?:: (.*))?\n[^\n]*Finding ({_UUID}), topic ({_WORDS})\.", re.DOTALL)


_FURTHER = "Further findings of this topic:"
_VERDICTS = "|".join(Verdict)
_SEEN = re.compile(rf"({_UUID})(?:; ({_VERDICTS}), (-?[0-9][0-9.e+-]*) m\b)?")


class Seen(NamedTuple):
    """A finding of a topic, as it was when the file was written. verdict, depth: None where the file does not say."""

    finding: str
    verdict: VerdictName | None = None
    depth: float | None = None


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


def seen_text(finding: str, found: Found) -> str:
    """A finding for the description of a topic: id, verdict and signed depth."""
    return f"{finding}; {found.verdict}, {found.depth + 0.0!r} m" if math.isfinite(found.depth) else finding


_WRITTEN = re.compile(rf"^status when written: ({_WORDS}), check ([0-9a-f]{{12}})\.?$", re.MULTILINE)


def written_text(status: str, check: str) -> str:
    """The last line of a description: the status of the topic, and the check (`check_of`) that it is of."""
    return f"Status when written: {status}, check {check}."


def written_in(description: str) -> tuple[str, str]:
    """What `written_text` says in a description; empty where it does not."""
    found = _WRITTEN.search(description.lower())
    return (found[1], found[2]) if found else ("", "")


def further_text(lines: Iterable[str]) -> str:
    """The text of the comment with the findings that a description does not list; from `seen_text`."""
    return "\n".join([_FURTHER, *lines])


def is_further(comment: str) -> bool:
    """Whether a comment is of `further_text`."""
    return comment.strip().startswith(_FURTHER)


def seen_in(text: str) -> tuple[Seen, ...]:
    """The findings that a text names, each once."""
    found: dict[str, Seen] = {}
    for finding, verdict, depth in _SEEN.findall(text):
        found.setdefault(finding, _seen(finding, verdict, depth))
    return tuple(found.values())


def _seen(finding: str, verdict: str, depth: str) -> Seen:
    try:
        length = float(depth)
    except ValueError:
        return Seen(finding)
    return Seen(finding, cast("VerdictName", verdict), length) if abs(length) < 1e100 else Seen(finding)


def note_of(comment: str) -> FindingNote | None:
    """What a comment of `comment_of` says; None for others."""
    found = _OWN.fullmatch(comment.strip().replace("\r\n", "\n"))
    if found is None:
        return None
    status, note, finding, topic = found.groups()
    return FindingNote(finding, cast("Status", status), (note or "").strip()[:LONGEST_NOTE], topic)
