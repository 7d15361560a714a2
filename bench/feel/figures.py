"""Fills the tables and plots of docs/haptics-figures.md from bench/records/feel.json. They are not edited by hand.

    python bench/feel/figures.py             write them
    python bench/feel/figures.py --check     1 if the page does not match the record

A block of the page stands between `<!-- feel: NAME -->` and `<!-- end of feel: NAME -->`, NAME one of the tables of
bench/feel/tables.py. Plots go to docs/haptics/.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host
import pages

from feel import plots, tables

PAGE = host.ROOT / "docs" / "haptics-figures.md"


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its blocks made anew. Raises `pages.PageError`."""
    return pages.filled(text, "feel", tables.tables(result))


def main() -> int:
    """Write, or compare."""
    return pages.program(
        *(__doc__, "feel", PAGE, "bench/feel/run.py --record", filled),
        beside=lambda result, page: plots.plots(result, page.parent / "haptics"),
    )


if __name__ == "__main__":
    sys.exit(main())
