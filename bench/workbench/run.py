"""The workbench in a headless Chromium with a software renderer, on one core, against its goals.

    python bench/workbench/run.py                    the sample engine of 1.6M triangles; a quarter of an hour
    python bench/workbench/run.py --quick            the short form, minutes
    python bench/workbench/run.py --big              also of 10 million triangles
    python bench/workbench/run.py --only soak --soak 30
    python bench/workbench/run.py --record           into bench/records/workbench.json, for docs/workbench-figures.md

Writes into a folder (target/workbench): workbench.json with all results, and tables.md. The exit status is 1 if a goal
is missed (bench/workbench/goals.py) that does not depend on time. Experiments: large and small (opening, camera, tool
and single frames, a picture of 1280x720 and of 640x360), parts (hiding and filtering 10,000), page (memory, contact,
stops, a cut, a lost context), engine (outlines, rays, one HTML file), soak (continuous motion of the tool). Of repeated
measurements the best counts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import host
from command_line import positive, triangles
from section import Form, Result, attempted, measured

from workbench import experiments, stand
from workbench.best import best
from workbench.tables import SECTION

SIZE, BIG_SIZE = Form(1_600_000, 100_000), 10_000_000
REPEATS, SOAK_MINUTES, MOVE_S = Form(3, 1), Form(1.0, 0.1), Form(4.0, 1.0)


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "a small engine, everything once")
    add = parser.add_argument
    add("--size", type=triangles, default=SIZE, help=f"triangles of the sample engine ({SIZE})")
    add("--big", action="store_true", help=f"the engine at {BIG_SIZE:,} triangles, too, once")
    add("--repeats", type=positive, default=REPEATS, help=f"of large, small and parts ({REPEATS})")
    add("--soak", type=float, default=SOAK_MINUTES, metavar="MINUTES", help=f"how long the tool moves ({SOAK_MINUTES})")
    add("--core", type=int, default=host.last_core(), help="for the page; default: the last one")
    return SECTION.options(parser, given)


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data. Raises `StandError` where there is no browser."""

    def found() -> Result:
        with stand.browser(options.core) as browser:
            mockups = _measured(browser, options, options.size, options.repeats)
            if options.big:
                mockups |= _measured(browser, options, BIG_SIZE, 1, without=("parts", "soak"))
            version = f"Chromium {browser.version}"
        return {"browser": version, "core": options.core, "bundle": experiments.bundle(), "mockups": mockups}

    return measured(found, options)


def _measured(
    browser: Any, options: argparse.Namespace, size: int, repeats: int, without: Sequence[str] = ()
) -> dict[str, Result]:
    """The results of a mock-up's experiments, by its name."""
    mockup = f"sample:engine:{size}"
    ways: dict[str, Callable[[], Result]] = {
        "large": lambda: best(experiments.pictures(browser, mockup, experiments.LARGE, repeats)),
        "small": lambda: best(experiments.pictures(browser, mockup, experiments.SMALL, repeats)),
        "parts": lambda: best(experiments.parts(browser, repeats)),
        "page": lambda: experiments.page(browser, mockup, MOVE_S.of(options)),
        "engine": lambda: experiments.engine(browser, mockup),
        "soak": lambda: experiments.soak(browser, mockup, 60 * options.soak),
    }
    name = f"engine, {size / 1e6:g}M"
    return {name: attempted(name, {each: ways[each] for each in options.only if each not in without})}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write, judge."""
    try:
        return SECTION.main(parse, run, arguments)
    except stand.StandError as error:
        print(error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
