"""Fills the tables of docs/clash.md from bench/records/clash.json. They are not edited by hand.

    python bench/clash/figures.py             write them
    python bench/clash/figures.py --check     1 if the page does not match the record

A block of the page stands between `<!-- clash: NAME -->` and `<!-- end of clash: NAME -->`, NAME one of the tables of
bench/clash/tables.py.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host
import pages

from clash import tables

PAGE = host.ROOT / "docs" / "clash.md"


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its blocks made anew. Raises `pages.PageError`."""
    return pages.filled(text, "clash", tables.tables(result))


def main() -> int:
    """Write, or compare."""
    return pages.program(__doc__, "clash", PAGE, f"{tables.PROGRAM} --record", filled)


if __name__ == "__main__":
    sys.exit(main())
