"""The text of a STEP file (ISO 10303-21): entities with their arguments, and decoded strings.

Only the requested entities are parsed: a file has a million others, which only the converter needs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np

from feeler.io.text import name_text

Argument: TypeAlias = "str | int | float | list[Argument] | None"
"""A string, the number of an entity (`#7`, an int), a number (a float), a list, or None for anything else ($, .T.)."""

_STRING_OR_COMMENT = re.compile(rb"('[^']*')|/\*.*?(?:\*/|\Z)", re.DOTALL)
_BEFORE = re.compile(rb"(?:[\xef\xbb\xbf\s]|/\*.*?\*/)*", re.DOTALL)
_TOKEN = re.compile(rb"'(?:[^']|'')*'|#\d+|[(),;]|[^\s'#(),;]+")
_ESCAPE = re.compile(
    r"''|\\\\|\\X2\\((?:[0-9A-F]{4})*)\\X0\\|\\X4\\((?:[0-9A-F]{8})*)\\X0\\|\\X\\([0-9A-F]{2})|\\P([A-I])\\|\\S\\(.)",
    re.IGNORECASE,
)
_END = re.compile(rb"END-ISO-10303-21\s*;")
_SECTION = re.compile(rb"(?:^|(?<=[;\s]))(HEADER|DATA|ANCHOR|REFERENCE)\s*(?:\([^;]*\)\s*)?;|\bENDSEC\s*;")
_MAX_NESTED = 50  # real ones nest 4 deep


class Entity(NamedTuple):
    """One entity: its number, keyword, arguments, and the place of its text (from the `#` to behind the `)`)."""

    number: int
    keyword: str
    arguments: list[Argument]
    start: int
    end: int

    def refers(self, at: int) -> int:
        """Return the entity number in that argument, 0 if there is none."""
        value = self.arguments[at] if at < len(self.arguments) else None
        return value if isinstance(value, int) else 0

    def numbers(self, at: int) -> list[float]:
        """Return the numbers in that argument, a list or one."""
        value = self.arguments[at] if at < len(self.arguments) else None
        items = value if isinstance(value, list) else [value]
        return [item for item in items if isinstance(item, float)]

    def text(self, at: int) -> str:
        """Return that argument as a string, "" if it is not one."""
        value = self.arguments[at] if at < len(self.arguments) else None
        return value if isinstance(value, str) else next(strings(value), "")

    def all(self, at: int) -> list[int]:
        """Return the numbers of all entities in that argument, a list or one."""
        return list(references(self.arguments[at])) if at < len(self.arguments) else []


def without_comments(text: bytes) -> bytes:
    """Return the text from its first keyword on: blanks and comments may be before it."""
    return text[_BEFORE.match(text).end() :]  # type: ignore[union-attr]  # it matches nothing, too


def plain_text(text: bytes) -> bytes:
    """Return the text in UTF-8, without comments. `text` is as `feeler.io.text.decoded` returns it."""
    if not text.isascii():
        try:
            text.decode("utf-8")
        except UnicodeDecodeError:
            text = name_text(text).encode("utf-8")
    if b"/*" in text:
        text = _STRING_OR_COMMENT.sub(lambda m: m[1] or b" ", text)
    return text


def split_end(text: bytes) -> tuple[bytes, bytes] | None:
    """Return (the text up to the end of its exchange structure, what follows); None if it has no end.

    Signatures follow (edition 3 of the standard), and what was appended by programs. `text` is as `plain_text` returns
    it.
    """
    for found in _END.finditer(text):
        if text.count(b"'", 0, found.start()) % 2 == 0:
            return text[: found.end()], text[found.end() :]
    return None


def one_section(text: bytes) -> bytes:
    """Return the text with all entities in one section DATA, and without the sections of edition 3.

    OpenCASCADE knows neither several sections DATA, nor one with parameters, nor ANCHOR and REFERENCE. `text` is as
    `split_end` returns it.
    """
    pieces: dict[bytes, list[bytes]] = {b"HEADER": [], b"DATA": []}
    quotes = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("'"))
    keyword, start = b"", 0
    for found in _SECTION.finditer(text):
        if np.searchsorted(quotes, found.start()) % 2:
            continue  # in a string
        pieces.setdefault(keyword, []).append(text[start : found.start()])
        keyword, start = found[1] or b"", found.end()
    pieces.setdefault(keyword, []).append(text[start : text.rindex(b"END-ISO")])  # nothing, unless an end is missing
    header, data = (b"\n".join(pieces[word]) for word in (b"HEADER", b"DATA"))
    return b"ISO-10303-21;\nHEADER;%b\nENDSEC;\nDATA;%b\nENDSEC;\nEND-ISO-10303-21;\n" % (header, data)


def entities(text: bytes, *keywords: str) -> Iterator[Entity]:
    """Yield the entities of those keywords, in the order of the file. `text` is as `plain_text` returns it."""
    wanted = "|".join(sorted(keywords, key=len, reverse=True)).encode("ascii")
    quotes = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("'"))
    for found in re.finditer(rb"#(\d+)\s*=\s*(" + wanted + rb")\s*\(", text):
        if np.searchsorted(quotes, found.start()) % 2:
            continue  # in a string
        arguments, end = _arguments(text, found.end())
        yield Entity(int(found[1]), found[2].decode("ascii"), arguments, found.start(), end)


def references(value: Argument) -> Iterator[int]:
    """Yield the numbers of all entities in an argument."""
    if isinstance(value, int):
        yield value
    elif isinstance(value, list):
        for item in value:
            yield from references(item)


def strings(value: Argument) -> Iterator[str]:
    """Yield the strings in an argument: `IDENTIFIER('a')` is an argument too."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for item in value:
            yield from strings(item)


def _arguments(text: bytes, at: int) -> tuple[list[Argument], int]:
    """Return (the arguments of the bracket opened before `at`, where the text continues)."""
    outer: list[Argument] = []
    stack = [outer]
    value: Argument = None
    while token := _TOKEN.search(text, at):
        word, at = token[0], token.end()
        if word == b"(":
            if len(stack) > _MAX_NESTED:
                break
            stack.append([])
            value = None
        elif word in (b",", b")"):
            inner = stack[-1]
            if word == b"," or inner or value is not None:
                inner.append(value)
            value = None
            if word == b")":
                value = stack.pop()
                if not stack:
                    return outer, at
        elif word == b";":  # a bracket is missing
            break
        elif word[:1] == b"'":
            value = string_text(word[1:-1])
        elif word[:1] == b"#":
            value = int(word[1:20])
        elif word[0] in b"+-0123456789":
            value = _number(word)
        else:
            value = None
    return outer, at


def _number(word: bytes) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def string_text(raw: bytes) -> str:
    """Return the text between the quotes, decoded: doubled quotes, and escapes for characters beyond ASCII."""
    plain = raw.decode("utf-8", "replace").replace("\n", "")
    if "\\" not in plain:
        return plain.replace("''", "'")
    page = "iso8859_1"

    def character(found: re.Match[str]) -> str:
        nonlocal page
        wide, widest, byte, letter, high = found.groups()
        if found[0] in ("''", "\\\\"):
            return found[0][0]
        if wide is not None:
            return bytes.fromhex(wide).decode("utf-16-be", "replace")
        if widest is not None:
            return bytes.fromhex(widest).decode("utf-32-be", "replace")
        if byte is not None:
            return chr(int(byte, 16))
        if letter is not None:
            page = f"iso8859_{ord(letter.upper()) - ord('A') + 1}"
            return ""
        return bytes([ord(high) + 128]).decode(page, "replace") if ord(high) < 128 else high

    return _ESCAPE.sub(character, plain)
