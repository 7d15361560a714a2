"""Attributes of parts as files state them: made into text, bounded, and counted where something is left out."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from feeler.attributes import MOST_NAME, MOST_PER_PART, MOST_VALUE, Attributes, Book
from feeler.io.raw import clean_name
from feeler.io.tally import Tally

_LONG_NAME = f"attributes have names longer than {MOST_NAME} characters, or are nested deeper, and were left out"
_LONG = f"attributes have values longer than {MOST_VALUE:,} characters, which were cut"
_MANY = f"attributes were left out of parts that have more than {MOST_PER_PART}"
_NO_TEXT = "attributes are binary data or no finite numbers, and were left out"
_TOO_MANY = "parts lost their attributes: the file states too many"
_HIDDEN = "attributes of meshes or materials were left out, as the part itself states others of the same name"
_BINARY = re.compile(r"data:[^,]{0,200};base64,", re.IGNORECASE)
_MOST_HUGE = 10**60


class Stated:
    """Collects the attributes of the parts of a file, in their order. `tally` counts what is left out, as doubts."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._book = Book()

    def add(self, *rows: Mapping[str, str], name: str = "") -> None:
        """Adds those of the next part, called `name`. Of equal names the first row counts; other values are noted."""
        joined: dict[str, str] = {}
        for row in rows:
            for key, value in row.items():
                if joined.setdefault(key, value) != value:
                    self._tally.add(_HIDDEN, f"{name}: {key}: {value}")
        if len(joined) > MOST_PER_PART:
            self._doubt(_MANY, name, len(joined) - MOST_PER_PART)
            joined = dict(list(joined.items())[:MOST_PER_PART])
        if not self._book.add(joined):
            self._doubt(_TOO_MANY, name)

    def attributes(self) -> Attributes | None:
        """Those of all parts."""
        return self._book.attributes()

    def flat(self, value: object) -> dict[str, str]:
        """The texts in a JSON object, nested ones by names with dots. Plain lists are one text, others are numbered.

        Different values of one name are one text, with commas. What is no object is called "extras".
        """
        found: dict[str, str] = {}
        if value is None:
            return found
        if not isinstance(value, dict):
            value = {"extras": value}
        waiting: list[tuple[str, Any]] = [("", value)]
        while waiting:
            above, here = waiting.pop()
            if isinstance(here, dict):
                items: Iterable[tuple[str, Any]] = here.items()
            elif isinstance(here, list) and not all(_is_plain(each) for each in here):
                items = ((str(at), each) for at, each in enumerate(here))
            else:
                self._take(found, above, here)
                continue
            below: list[tuple[str, Any]] = []
            for name, each in items:
                if len(found) + len(below) + len(waiting) > MOST_PER_PART:
                    self._doubt(_MANY, above or name, max(1, len(here) - len(below)))
                    break
                label = clean_name(name, "")
                path = f"{above}.{label}" if above and label else above or label
                if len(path) > MOST_NAME:
                    self._doubt(_LONG_NAME, path)
                elif path:
                    below.append((path, each))
            waiting.extend(reversed(below))
        return found

    def text(self, name: object, value: object) -> dict[str, str]:
        """One attribute; none where its value is empty."""
        found: dict[str, str] = {}
        label = clean_name(name, "")
        if len(label) > MOST_NAME:
            self._doubt(_LONG_NAME, label)
        elif label:
            self._take(found, label, value)
        return found

    def _take(self, found: dict[str, str], name: str, value: object) -> None:
        text = self._text(name, value)
        if text and found.setdefault(name, text) != text:
            found[name] = self._cut(name, f"{found[name]}, {text}")

    def _text(self, name: str, value: object) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, str):
            if _BINARY.match(value) or "\0" in value:
                self._doubt(_NO_TEXT, name)
                return ""
            return self._cut(name, clean_name(" ".join(value[: 2 * MOST_VALUE].split()), ""))
        if isinstance(value, int):
            return str(value) if abs(value) < _MOST_HUGE else self._text(name, math.inf)
        if isinstance(value, float):
            if math.isfinite(value):
                return f"{value:.15g}"
            self._doubt(_NO_TEXT, name)
        if isinstance(value, list):
            texts = (self._text(name, each) for each in value[:MOST_VALUE])
            return self._cut(name, ", ".join(text for text in texts if text))
        return ""

    def _cut(self, name: str, text: str) -> str:
        if len(text) <= MOST_VALUE:
            return text
        self._doubt(_LONG, name)
        return text[: MOST_VALUE - 1] + "…"

    def _doubt(self, kind: str, name: str, count: int = 1) -> None:
        self._tally.add(kind, name, count, is_doubtful=True)


def _is_plain(value: object) -> bool:
    return not isinstance(value, (dict, list))
