"""Reads JSON without holding the interpreter for long: `json.loads` of a hundred megabytes would stop all threads."""

from __future__ import annotations

import json
from json.decoder import WHITESPACE  # type: ignore[attr-defined]
from typing import Any

LARGE = 1 << 20
"""Characters from which on it matters."""
_DECODER = json.JSONDecoder()


def patient_loads(text: str) -> Any:
    """As `json.loads`. Lists at the top of an object are read item by item, so that other threads run between them.

    Raises `ValueError` and `RecursionError` likewise.
    """
    start = _blank(text, 0)
    if len(text) < LARGE or text[start : start + 1] != "{":
        return json.loads(text)
    found: dict[str, Any] = {}
    at, end = _items(text, start + 1, "}"), len(text)
    while text[at] != "}":
        key, at = _DECODER.raw_decode(text, at)
        if not isinstance(key, str):
            raise json.JSONDecodeError("Expecting property name enclosed in double quotes", text, at)
        at = _blank(text, at)
        if text[at : at + 1] != ":":
            raise json.JSONDecodeError("Expecting ':' delimiter", text, at)
        found[key], at = _value(text, _blank(text, at + 1))
        at = _next(text, at, "}")
    at = _blank(text, at + 1)
    if at != end:
        raise json.JSONDecodeError("Extra data", text, at)
    return found


def _value(text: str, at: int) -> tuple[Any, int]:
    if text[at : at + 1] != "[":
        return _DECODER.raw_decode(text, at)
    items = []
    at = _items(text, at + 1, "]")
    while text[at] != "]":
        item, at = _DECODER.raw_decode(text, at)
        items.append(item)
        at = _next(text, at, "]")
    return items, at + 1


def _items(text: str, at: int, end: str) -> int:
    """The place of the first item, or of the end."""
    at = _blank(text, at)
    if at >= len(text):
        raise json.JSONDecodeError(f"Expecting {end!r}", text, at)
    return at


def _next(text: str, at: int, end: str) -> int:
    """The place of the next item, or of the end."""
    at = _blank(text, at)
    if text[at : at + 1] == end:
        return at
    if text[at : at + 1] != ",":
        raise json.JSONDecodeError("Expecting ',' delimiter", text, at)
    at = _items(text, at + 1, end)
    if text[at] == end:
        raise json.JSONDecodeError("Expecting value", text, at)
    return at


def _blank(text: str, at: int) -> int:
    """The place after white space."""
    return int(WHITESPACE.match(text, at).end())
