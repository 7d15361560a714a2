"""The last run of `feeler maintain` in a project: what a report shows of it, the whole run, and its answers.

They are three rows of the table `answers`, written in one transaction. Older versions leave them as they are.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any, Literal, TypedDict

from feeler.errors import LoadError, WriteError
from feeler.project.book import Book, dumps, loads, now
from feeler.project.layout import MOST_DATA
from feeler.project.store import drop, put

SHOWN, RUN, ANSWERS = "maintain", "maintain run", "maintain answers"
"""The ids of the rows, and their kinds."""
MOST_RUN_TEXT = 1 << 30
"""Characters of a whole run. A hundred thousand parts have some 150 million."""
_LEVEL = 3


class RunRow(TypedDict):
    """A row of a run. Unknown numbers are None; times in seconds. why: it has no time. hidden: fasteners not seen."""

    name: str
    paths: list[str]
    state: Literal["out", "blocked", "failed"]
    seconds: float | None
    low: float | None
    high: float | None
    steps: int
    tools: list[str]
    reach_deg: float | None
    sight: float | None
    hidden: int
    delta: float | None
    is_slower: bool
    change: str
    why: str
    renamed_from: str


class RunFacts(TypedDict):
    """What a report shows of a run. at: when it was written, UTC. contents: of all parts of its mock-up, by key."""

    at: str
    said: str
    is_partial: bool
    rows: list[RunRow]
    contents: dict[str, str]


def write_run(
    book: Book,
    shown: Mapping[str, Any],
    run: Mapping[str, Any],
    answers: bytes | None,
) -> bool:
    """Writes a run in place of the one before, all or none. shown: `RunFacts` without `at`.

    Returns whether its answers are in the project: those of more than `MOST_DATA` bytes are left out. Raises
    `WriteError`, also for a run that is too large.
    """
    text = dumps(run)
    data = zlib.compress(text.encode("ascii"), _LEVEL)
    if len(text) > MOST_RUN_TEXT or len(data) > MOST_DATA:
        raise WriteError(
            f"cannot write {book.path}: a run of {len(text) / 1e6:,.0f} MB is too large for a project; keep it in a "
            "file, by --save and --previous"
        )
    fits = answers is None or len(answers) <= MOST_DATA
    kept = answers if fits else None
    book.write(
        [
            put("answers", SHOWN, 0, dumps({"kind": SHOWN, "at": now(), **shown})),
            put("answers", RUN, 0, dumps({"kind": RUN}), data),
            drop("answers", ANSWERS) if kept is None else put("answers", ANSWERS, 0, dumps({"kind": ANSWERS}), kept),
        ]
    )
    return fits


def run_of(book: Book) -> tuple[Any, bytes | None] | None:
    """The last run and its answers, as `write_run` was given them; None if there is none. Raises `LoadError`."""
    kept = book.answer(RUN)
    if kept is None:
        return None
    reader = zlib.decompressobj()
    try:
        data = reader.decompress(kept[1] or b"", MOST_RUN_TEXT)
        if not reader.eof:
            raise ValueError("it is cut off, or too large")
        text = data.decode("ascii")
    except (zlib.error, ValueError) as error:
        raise LoadError(
            f"{book.path} is damaged: its last run of feeler maintain cannot be read ({error!s:.80}); use a copy"
        ) from None
    answers = book.answer(ANSWERS)
    return loads(text, f"{book.path}: its last run of feeler maintain"), None if answers is None else answers[1]


def shown_of(book: Book) -> dict[str, Any] | None:
    """What a report shows of the last run, unchecked; None if there is none. Raises `LoadError`."""
    kept = book.answer(SHOWN)
    if kept is None:
        return None
    if not isinstance(kept[0], dict):
        raise LoadError(f"{book.path} is damaged: its last run of feeler maintain is not as written; use a copy")
    return {name: value for name, value in kept[0].items() if name != "kind"}
