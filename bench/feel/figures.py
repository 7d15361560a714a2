"""Fills the tables and plots of docs/haptics.md from bench/records/feel.json. They are not edited by hand.

    python bench/feel/figures.py             write them
    python bench/feel/figures.py --check     1 if the page is not what the record makes it

A block of the page stands between `<!-- feel: NAME -->` and `<!-- end of feel: NAME -->`, NAME one of the tables of
bench/feel/tables.py. Plots go to docs/haptics/.
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

from feel import plots, tables

PAGE = host.ROOT / "docs" / "haptics.md"
RECORD = host.ROOT / "bench" / "records" / "feel.json"
BLOCK = re.compile(r"<!-- feel: (?P<name>[a-z_]+) -->\n.*?<!-- end of feel: (?P=name) -->", re.DOTALL)


class PageError(ValueError):
    """A page or record that cannot be used."""


def filled(text: str, result: dict[str, Any]) -> str:
    """The page with its blocks made anew."""
    made = tables.tables(result)

    def block(found: re.Match[str]) -> str:
        name = found["name"]
        if name not in made:
            raise PageError(f"the page asks for the table {name!r}; the record has {', '.join(made)}")
        return f"<!-- feel: {name} -->\n{made[name]}\n<!-- end of feel: {name} -->"

    opened = len(re.findall(r"<!-- feel: ", text))
    if opened != len(BLOCK.findall(text)):
        raise PageError("a block of the page has no end: each `<!-- feel: NAME -->` needs `<!-- end of feel: NAME -->`")
    return BLOCK.sub(block, text)


def main() -> int:
    """Write, or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if the page is out of date")
    parser.add_argument("--record", type=Path, default=RECORD, help="the record (bench/records/feel.json)")
    parser.add_argument("--page", type=Path, default=PAGE, help="the page (docs/haptics.md)")
    options = parser.parse_args()
    for path, remedy in ((options.record, "run bench/feel/run.py --record first"), (options.page, "write it first")):
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
    for path in plots.plots(result, options.page.parent / options.page.stem):
        print(f"Written: {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
