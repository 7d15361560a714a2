"""Fills the figures of docs/workbench-figures.md from bench/records/workbench.json. They are not edited by hand.

    python bench/workbench/figures.py             write them
    python bench/workbench/figures.py --check     1 if the page does not match the record

They stand between `<!-- workbench: figures -->` and `<!-- end of workbench: figures -->`; a page without the two has
none.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host
import pages

from workbench import tables

PAGE = host.ROOT / "docs" / "workbench-figures.md"


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its figures made anew; one without markers stays as it is. Raises `pages.PageError`."""
    return pages.filled(text, "workbench", {"figures": tables.page(result)})


def main() -> int:
    """Write, or compare."""
    return pages.program(__doc__, "workbench", PAGE, "bench/workbench/run.py --record", filled)


if __name__ == "__main__":
    sys.exit(main())
