"""Shared parts of the bench's command lines: a parser whose help is the module's docstring, and option types."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from typing import Any


def parser(said: str) -> argparse.ArgumentParser:
    """A parser of a module's text, three paragraphs: what it does, examples, what it writes."""
    head, examples, tail = said.split("\n\n")
    return argparse.ArgumentParser(
        description=f"{head}\n\n{tail}",
        epilog="examples:\n" + examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def listed(kind: Callable[[str], Any]) -> Callable[[str], list[Any]]:
    """Values with commas between them."""

    def values(text: str) -> list[Any]:
        return [kind(word.strip()) for word in text.split(",") if word.strip()]

    return values


def one_of(what: str, known: Any) -> Callable[[str], str]:
    """A word that is known."""

    def check(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(f"{text!r} is no {what}: choose of {', '.join(known)}")
        return text

    return check


def positive(text: str) -> int:
    """A whole number of at least 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of at least 1")
    return int(text)


def triangles(text: str) -> int:
    """A number of triangles: 100000, 100k or 1.6M."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([kM]?)", text.replace("_", ""))
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} is no size: write 100000, 100k or 1.6M")
    size = round(float(found[1]) * {"": 1, "k": 1_000, "M": 1_000_000}[found[2]])
    if size < 10_000:
        raise argparse.ArgumentTypeError(f"{text!r}: a sample has at least 10,000 triangles")
    return size
