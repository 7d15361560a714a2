"""Attributes of parts: text by name, such as a material or a layer. They are data of strangers, and bounded.

Parts that have the same attributes share one dict inside of a mesh, because bolts come by the ten thousand.
"""

from __future__ import annotations

import fnmatch
import json
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from feeler.arguments import check_list, shown
from feeler.errors import LimitError, MeshError

MOST_PER_PART = 100
"""The most attributes of a part."""
MOST_NAME = 100
"""The most characters of an attribute's name."""
MOST_VALUE = 1_000
"""The most characters of a value."""
MOST_IN_ALL = 4_000_000
"""The most attributes of a mesh; those that parts share count once."""

Attributes = tuple[dict[str, str], ...]
"""Of each part of a mesh. Equal ones are one object, which nobody changes."""

VERSION = 1
"""Of the section in saved scenes."""

_WORD = re.compile(r'(?:"[^"]*(?:"|$)|[^\s"])+')
_PATTERN = re.compile(r"[*?\[]")


class Term(NamedTuple):
    """A word of a search: `name:value`, or a word of a path, which has no name. Casefolded, without quotes."""

    text: str
    name: str
    value: str


def checked(given: object, parts: int) -> Attributes | None:
    """Attributes as the caller gives them: a dict for each part. None: no part has any.

    Raises `MeshError` for anything else, and `LimitError` for too many or too long ones.
    """
    if given is None:
        return None
    rows = check_list("part_attributes", given, "a list with a dict of text for each part", MeshError)
    if len(rows) != parts:
        raise MeshError(f"part_attributes has {len(rows)} entries but there are {parts} parts: give as many")
    book = Book()
    for number, row in enumerate(rows):
        if not isinstance(row, Mapping):
            raise MeshError(f"part_attributes[{number}] is {shown(row)}: give a dict of text")
        if len(row) > MOST_PER_PART:
            raise LimitError(f"part_attributes[{number}] has {len(row):,} entries: at most {MOST_PER_PART} are kept")
        for name, value in row.items():
            if not isinstance(name, str) or not isinstance(value, str):
                raise MeshError(
                    f"part_attributes[{number}] has {shown(name)}: {shown(value)}: names and values are text"
                )
            if not name or len(name) > MOST_NAME or len(value) > MOST_VALUE:
                raise LimitError(
                    f"part_attributes[{number}], {shown(name)}: a name has 1 to {MOST_NAME} characters, a value at "
                    f"most {MOST_VALUE:,}"
                )
        if not book.add(dict(row)):
            raise LimitError(f"part_attributes has more than {MOST_IN_ALL:,} attributes: give fewer")
    return book.attributes()


class Book:
    """Collects the attributes of parts, one after the other; equal ones are kept once."""

    def __init__(self) -> None:
        self._rows: list[dict[str, str]] = []
        self._known: dict[tuple[tuple[str, str], ...], dict[str, str]] = {(): {}}
        self._count = 0

    def add(self, row: dict[str, str]) -> bool:
        """Adds those of the next part. False: there are too many in all, and it has none."""
        key = tuple(row.items())
        if key not in self._known:
            if self._count + len(row) > MOST_IN_ALL:
                self._rows.append(self._known[()])
                return False
            self._count += len(row)
            self._known[key] = row
        self._rows.append(self._known[key])
        return True

    def attributes(self) -> Attributes | None:
        """Those of all parts; None if no part has any."""
        return tuple(self._rows) if any(self._rows) else None


def to_bytes(attributes: Attributes) -> bytes:
    """The section of a saved scene."""
    number: dict[int, int] = {}
    sets: list[dict[str, str]] = []
    for row in attributes:
        if id(row) not in number:
            number[id(row)] = len(sets)
            sets.append(row)
    document = {"version": VERSION, "sets": sets, "of_part": [number[id(row)] for row in attributes]}
    return json.dumps(document, separators=(",", ":")).encode("ascii")


def from_bytes(data: bytes, parts: int) -> Attributes | None:
    """What `to_bytes` wrote; None if a later version of feeler wrote it. Raises `ValueError` if it is damaged."""
    document: Any = json.loads(data)
    if document["version"] != VERSION:
        return None
    sets, places = document["sets"], document["of_part"]
    if not isinstance(sets, list) or not isinstance(places, list) or len(places) != parts:
        raise ValueError("attributes of parts")
    if not all(isinstance(row, dict) and all(isinstance(value, str) for value in row.values()) for row in sets):
        raise ValueError("values of attributes")
    if not all(type(place) is int and 0 <= place < len(sets) for place in places):
        raise ValueError("places of attributes")
    return tuple(sets[place] for place in places)


def terms(query: str) -> list[Term]:
    """The words of a search, in which quotes keep blanks together."""
    found = []
    for match in _WORD.finditer(query):
        text = match[0].replace('"', "").casefold()
        name, colon, value = text.partition(":")
        if not text:
            continue
        found.append(Term(text, name if colon else "", value if colon else ""))
    return found


def asks_for_attributes(query: str) -> bool:
    """Whether a search has a word of the form `name:value`."""
    return ":" in query and any(term.name for term in terms(query))


def search(query: str, paths: Sequence[str], attributes: Attributes | None) -> list[int]:
    """The parts that have every word of a search.

    A word is a part of the path, in any case. `name:value` is a part of the path, or a part of the value of an
    attribute with that name: its whole name, or what follows a dot in it. A value with `*`, `?` or `[` is a pattern of
    the whole value; without a value, the part has such an attribute.
    """
    asked = terms(query)
    if not asked:
        return []
    tests = [_test(term) for term in asked]
    known: dict[int, tuple[bool, ...]] = {}
    found = []
    for part, path in enumerate(paths):
        row = attributes[part] if attributes is not None else {}
        has = known.get(id(row)) if row else ()
        if has is None:
            plain = [(name.casefold(), value.casefold()) for name, value in row.items()]
            has = known[id(row)] = tuple(any(test(*each) for each in plain) for test in tests)
        folded = path.casefold()
        if all((bool(has) and has[at]) or term.text in folded for at, term in enumerate(asked)):
            found.append(part)
    return found


def names(attributes: Attributes | None) -> list[str]:
    """The names of all attributes, in the order in which they occur."""
    seen: dict[str, None] = {}
    for row in {id(row): row for row in attributes or ()}.values():
        seen.update(dict.fromkeys(row))
    return list(seen)


def _test(term: Term) -> Callable[[str, str], bool]:
    """Whether an attribute, by its name and value, is what a word asks for."""
    if not term.name:
        return lambda name, value: False
    ending = "." + term.name
    if _PATTERN.search(term.value):
        matches = re.compile(fnmatch.translate(term.value)).match
        return lambda name, value: (name == term.name or name.endswith(ending)) and matches(value) is not None
    return lambda name, value: (name == term.name or name.endswith(ending)) and term.value in value
