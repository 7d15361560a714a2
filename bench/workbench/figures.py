"""Fills the figures of docs/workbench.md from bench/records/workbench.json. They are not edited by hand.

    python bench/workbench/figures.py             write them
    python bench/workbench/figures.py --check     1 if the page is not what the record makes it

They stand between `<!-- workbench: figures -->` and `<!-- end of workbench: figures -->`; a page without the two has
none.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host

from workbench import tables

PAGE = host.ROOT / "docs" / "workbench.md"
RECORD = host.ROOT / "bench" / "records" / "workbench.json"
BEGIN, END = "<!-- workbench: figures -->", "<!-- end of workbench: figures -->"


class PageError(ValueError):
    """A page that cannot be used."""


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its figures made anew; one without markers stays as it is. Raises `PageError`."""
    if text.count(BEGIN) != text.count(END) or text.find(BEGIN) > text.find(END):
        raise PageError(f"a block of the page has no end: `{BEGIN}` needs `{END}`")
    made = f"{BEGIN}\n{tables.page(result)}\n{END}"
    return re.sub(f"{re.escape(BEGIN)}.*?{re.escape(END)}", lambda found: made, text, flags=re.DOTALL)


def main() -> int:
    """Write, or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if the page is out of date")
    parser.add_argument("--record", type=Path, default=RECORD, help="the record (bench/records/workbench.json)")
    parser.add_argument("--page", type=Path, default=PAGE, help="the page (docs/workbench.md)")
    options = parser.parse_args()
    for path, remedy in ((options.record, "run bench/workbench/run.py --record first"), (options.page, "write it")):
        if not path.is_file():
            print(f"{path} is not there: {remedy}", file=sys.stderr)
            return 2
    result = json.loads(options.record.read_text(encoding="utf-8"))
    before = options.page.read_text(encoding="utf-8")
    try:
        after = filled(before, result)
    except PageError as error:
        print(error, file=sys.stderr)
        return 2
    if options.check:
        return int(before != after)
    options.page.write_text(after, encoding="utf-8")
    print(f"Written: {options.page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
