"""How the clashes of a project are checked: what the page shows, and what the command line takes without options."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from feeler.clashes.rules import Rules, tolerant
from feeler.errors import FeelerError, LoadError
from feeler.project.book import Book, dumps
from feeler.project.store import Change, put

MOST_RULES = 400_000
"""The longest rules that a project keeps, in characters."""
FIELD = "clash"
"""The row of the document that has them."""


@dataclass(frozen=True)
class ClashSettings:
    """How the next clash check is made: metres, contact None for the chordal errors of both parts; rules as TOML."""

    clearance: float = 0.002
    contact: float | None = 0.0
    rules: str = ""

    def parsed(self, where: str) -> Rules:
        """The rules; their patterns may match nothing. Raises `LoadError`."""
        return tolerant(Rules.parse(self.rules, where))


def settings_of(book: Book) -> ClashSettings | None:
    """Those that a project keeps; None if nothing was checked with it. Raises `LoadError`."""
    row = next((each for each in book.rows("document") if each.id == FIELD), None)
    if row is None:
        return None
    value = book.value(row, "document")
    try:
        contact, rules = value["contact"], value["rules"]
        if not isinstance(rules, str) or len(rules) > MOST_RULES:
            raise ValueError
        found = ClashSettings(_length(value["clearance"]), None if contact is None else _length(contact), rules)
        found.parsed("its rules")
    except (FeelerError, ValueError, TypeError, KeyError):
        raise LoadError(f"{book.path} is damaged: the settings of its clash checks are not as written") from None
    return found


def settings_changes(book: Book, settings: ClashSettings) -> Iterator[Change]:
    """The changes that keep them."""
    text = dumps(asdict(settings))
    if not any(row.id == FIELD and row.value == text for row in book.rows("document")):
        yield put("document", FIELD, 0, text)


def _length(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not (0.0 <= value < math.inf):
        raise ValueError
    return float(value)
