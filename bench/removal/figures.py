"""Fills the tables of docs/removal.md from bench/records/removal.json. They are not edited by hand.

    python bench/removal/figures.py             write them
    python bench/removal/figures.py --check     1 if the page does not match the record

A block of the page stands between `<!-- removal: NAME -->` and `<!-- end of removal: NAME -->`, NAME one of the tables
of bench/removal/tables.py.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host
import pages

from removal import tables

PAGE = host.ROOT / "docs" / "removal.md"


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its blocks made anew. Raises `pages.PageError`."""
    return pages.filled(text, "removal", tables.tables(result))


def main() -> int:
    """Write, or compare."""
    return pages.program(__doc__, "removal", PAGE, f"{tables.PROGRAM} --record", filled)


if __name__ == "__main__":
    sys.exit(main())
