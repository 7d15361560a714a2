"""Nightly runs of the sample engine and gearbox: in full, where nothing changed, and where one part in a hundred moved.

    python bench/maintain/run.py                   everything; an hour
    python bench/maintain/run.py --quick           the short form, a minute
    python bench/maintain/run.py --record          and into bench/records/maintain.json, for docs/task.md

With the built-in catalogue of tools, in one thread. Seconds are of the processor. Writes into a folder
(target/maintain): maintain.json with all results, and tables.md. The exit status is 1 if a goal is missed
(bench/maintain/goals.py) that does not depend on time. No peer is known that plans such tasks.
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

from maintain import nights
from maintain.tables import SECTION

SIZE = Form(1_600_000, 30_000)
GEARBOX = Form(100_000, 75_000)
PARTS = Form(100, 2)
UNITS = Form(10, 2)
MOVES = Form(5, 1)
ENGINE_MOVES = 1
"""At most, of the engine: each is compared with a full run."""


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "a small engine, two parts of each")
    add = parser.add_argument
    add("--size", type=triangles, default=SIZE, help=f"triangles of the sample engine ({SIZE})")
    add("--parts", type=positive, default=PARTS, help=f"parts of its list ({PARTS})")
    add("--gearbox", type=triangles, default=GEARBOX, help=f"triangles of the sample gearbox ({GEARBOX})")
    add("--units", type=positive, default=UNITS, help=f"parts of its list ({UNITS})")
    add("--moves", type=positive, default=MOVES, help=f"runs with other parts moved ({MOVES}); engine: {ENGINE_MOVES}")
    return SECTION.options(parser, given)


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    ways: dict[str, Callable[[], Result]] = {
        "engine": lambda: nights.engine(options.size, options.parts, min(ENGINE_MOVES, options.moves)),
        "gearbox": lambda: nights.gearbox(options.gearbox, options.units, options.moves),
    }
    return measured_each(ways, options, {}, {})


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
