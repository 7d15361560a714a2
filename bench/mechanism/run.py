"""Mechanisms: a door of the sample engine, what steps miss, and bounds against random positions; feeler and its peers.

    python bench/mechanism/run.py                   everything; ten minutes
    python bench/mechanism/run.py --quick           the short form, a minute
    python bench/mechanism/run.py --only door --peers none
    python bench/mechanism/run.py --only bounds     certified bounds against a million random positions
    python bench/mechanism/run.py --record          and into bench/records/mechanism.json, for docs/mechanisms.md

Writes into a folder (target/mechanism): mechanism.json with all results, and tables.md. The exit status is 1 if a goal
is missed (bench/mechanism/goals.py) that does not depend on time. Peers step through 121 positions: python-fcl
(`pip install "feeler[bench]"`) and MuJoCo (`pip install mujoco`); a missing one is skipped, and the tables say why. The
engine is asked of python-fcl alone: MuJoCo would take the convex hulls of its parts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from command_line import listed, one_of, positive, triangles
from section import Form, Result, measured_each

from mechanism import bounds, doors, misses
from mechanism.steppers import PEERS, Stepper, peers
from mechanism.tables import SECTION

SIZES = Form([1_600_000], [20_000])
REPEATS = Form(3, 1)
ARMS = Form(500, 12)
POSITIONS = Form(2_000, 50)
SEED = 5


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "a small engine, few arms, everything once")
    add, names = parser.add_argument, list(PEERS)
    add("--sizes", type=listed(triangles), default=SIZES, help=f"triangles of the sample engine ({SIZES})")
    add("--repeats", type=positive, default=REPEATS, help=f"the least time counts ({REPEATS})")
    add("--arms", type=positive, default=ARMS, help=f"random mechanisms ({ARMS})")
    add("--positions", type=positive, default=POSITIONS, help=f"random positions of each ({POSITIONS})")
    add("--peers", type=listed(one_of("peer", [*names, "none"])), default=names, help=f"{', '.join(names)}; none")
    return SECTION.options(parser, given)


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    there, absent = peers([name for name in options.peers if name != "none"])
    whole: list[Stepper] = [each for each in there if each.name == "python-fcl"]
    ways: dict[str, Callable[[], Result]] = {
        "door": lambda: {
            "repeats": options.repeats,
            "sizes": [doors.measured(size, options.repeats, whole) for size in options.sizes],
        },
        "steps": lambda: misses.measured(there),
        "bounds": lambda: bounds.measured(options.arms, options.positions, SEED),
    }
    return measured_each(ways, options, {each.name: each.version for each in there}, absent)


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
