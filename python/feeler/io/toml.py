"""TOML files of rules, requirements, joints, times and tools."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from feeler.arguments import shown
from feeler.errors import FeelerError, LoadError, MissingFileError
from feeler.io.text import text_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


VERSION = 1
"""Of rules, requirements, joints and times."""


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


def check_version(data: Mapping[str, Any], where: str, error: type[FeelerError] = LoadError) -> None:
    """Checks the key `version` of a document: without it, it is of version 1. Raises `error` for another."""
    version = data.get("version", VERSION)
    if version != VERSION or not isinstance(version, int) or isinstance(version, bool):
        raise error(f"{where} is of version {shown(version)}, and this feeler reads {VERSION}")


LONE = re.compile("[\ud800-\udfff]")
"""Halves of surrogate pairs, such as Python has in names that are not UTF-8, which no file can store."""


def quoted(text: str) -> str:
    """A text as a basic string of TOML; lone surrogates become question marks."""
    return json.dumps(LONE.sub("?", text), ensure_ascii=False).replace("\x7f", "\\u007f")
