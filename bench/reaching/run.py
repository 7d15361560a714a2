"""The whole tool catalogue on 200 bolts of the sample engine, and on the sample gearbox, whose tools are known.

    python bench/reaching/run.py                   everything; two minutes
    python bench/reaching/run.py --quick           the short form, some seconds
    python bench/reaching/run.py --record          and into bench/records/reaching.json, for docs/access.md

Writes into a folder (target/reaching): reaching.json with all results, and tables.md. The exit status is 1 if a goal is
missed (bench/reaching/goals.py) that does not depend on time. No peer is known that chooses tools by exact casts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from command_line import positive, triangles
from section import Form, Result, measured_each

from reaching import bolts
from reaching.tables import SECTION

SIZE = Form(1_600_000, 20_000)
BOLTS = Form(200, 12)
REPEATS = Form(2, 1)
GEARBOX = Form(100_000, 75_000)
EVERY = Form(1, 9)


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "a small engine, few bolts, everything once")
    add = parser.add_argument
    add("--size", type=triangles, default=SIZE, help=f"triangles of the sample engine ({SIZE})")
    add("--bolts", type=positive, default=BOLTS, help=f"bolts of the engine ({BOLTS})")
    add("--repeats", type=positive, default=REPEATS, help=f"the least time counts ({REPEATS})")
    add("--gearbox", type=triangles, default=GEARBOX, help=f"triangles of the sample gearbox ({GEARBOX})")
    add("--every", type=positive, default=EVERY, help=f"one in so many of its fasteners ({EVERY})")
    return SECTION.options(parser, given)


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    ways: dict[str, Callable[[], Result]] = {
        "engine": lambda: bolts.engine(options.size, options.bolts, options.repeats),
        "gearbox": lambda: bolts.gearbox(options.gearbox, options.every),
    }
    return measured_each(ways, options, {}, {})


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
