"""Markdown of the bench: tables, and pages with blocks that are made from a record and not edited by hand."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence


class PageError(ValueError):
    """A page or record that cannot be used."""


def bold(text: str, is_met: bool) -> str:
    """Makes missed goals stand out."""
    return text if is_met else f"**{text}**"


def markdown(heads: Sequence[str], texts: int, lines: Sequence[Sequence[str]], note: str = "") -> str:
    """A table: the first columns are text, the others numbers."""
    rule = "|---" * texts + "|---:" * (len(heads) - texts) + "|"
    rows = [f"| {' | '.join(line)} |" for line in (heads, *lines)]
    return "\n".join([rows[0], rule, *rows[1:], *(["", note] if note else [])])


def filled(text: str, section: str, made: Mapping[str, str]) -> str:
    """The page with the blocks of a section made anew; without any it stays as it is. Raises `PageError`.

    A block stands between `<!-- SECTION: NAME -->` and `<!-- end of SECTION: NAME -->`.
    """
    block = re.compile(
        rf"<!-- {section}: (?P<name>[a-z_]+) -->\n.*?<!-- end of {section}: (?P=name) -->", flags=re.DOTALL
    )

    def anew(found: re.Match[str]) -> str:
        name = found["name"]
        if name not in made:
            raise PageError(f"the page asks for the table {name!r}; the record has {', '.join(made)}")
        return f"<!-- {section}: {name} -->\n{made[name]}\n<!-- end of {section}: {name} -->"

    if len(re.findall(rf"<!-- (?:end of )?{section}: ", text)) != 2 * len(block.findall(text)):
        begin, end = f"<!-- {section}: NAME -->", f"<!-- end of {section}: NAME -->"
        raise PageError(f"a block of the page has no end, or no beginning: each `{begin}` needs `{end}`")
    return block.sub(anew, text)
