"""TOML files of rules and requirements."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from feeler.errors import LoadError, MissingFileError
from feeler.io.text import text_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def toml_of(file: Path, advice: str) -> dict[str, Any]:
    """The content of a file. Raises `LoadError`, and `MissingFileError` with the advice."""
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: {advice}") from None
    return parsed_toml(text, str(file))


def parsed_toml(text: str, where: str) -> dict[str, Any]:
    """The content of a text. Raises `LoadError`."""
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise LoadError(f"{where}: not valid TOML: {error}") from None
    return data


LONE = re.compile("[\ud800-\udfff]")
"""Halves of surrogate pairs, such as Python has in names that are not UTF-8, which no file can store."""


def quoted(text: str) -> str:
    """A text as a basic string of TOML; lone surrogates become question marks."""
    return json.dumps(LONE.sub("?", text), ensure_ascii=False).replace("\x7f", "\\u007f")
