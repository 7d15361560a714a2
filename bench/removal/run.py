"""Removal paths: time to find them, and tool access to bolts; feeler, and the planners of OMPL.

    python bench/removal/run.py                  everything; some twenty minutes, most of them OMPL's
    python bench/removal/run.py --quick          the short form, about a minute
    python bench/removal/run.py --only puzzles --seeds 100 --peers none
    python bench/removal/run.py --record         and into bench/records/removal.json, for docs/removal.md

Writes into a folder (target/removal): removal.json with all results, and tables.md. The exit status is 1 if a goal is
missed (bench/removal/goals.py) that does not depend on time: a path that is not free. `--only`: puzzles (linked tubes,
pegs in tight holes, a closed box), engine (the sample engine's parts and bolts). A record keeps the results that a run
leaves out. OMPL comes from `pip install "feeler[bench]"`; if it is missing it is skipped, and the tables say why.
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

from removal import engine_parts, planners, solving
from removal.tables import SECTION

SIZES = Form([100_000, 1_600_000], [20_000, 20_000])
SEEDS, PEER_SEEDS = Form(30, 2), Form(3, 1)
SECONDS = Form(10.0, 1.0)
EVERY = Form(1, 20)
PARTS, PART_S = Form(100, 10), 0.5
TARGETS, ANGLES = Form(200, 10), 72


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "few seeds, a short time for each, a small engine")
    add = parser.add_argument
    add("--sizes", type=listed(triangles), default=SIZES, help=f"triangles of the engine, small and large ({SIZES})")
    add("--seeds", type=positive, default=SEEDS, help=f"tries of feeler at a puzzle ({SEEDS}); of others fewer")
    add("--seconds", type=float, default=SECONDS, help=f"most time of a try at a puzzle ({SECONDS})")
    add("--peers", type=one_of("choice", ["OMPL", "none"]), default="OMPL", help="OMPL, none")
    options = SECTION.options(parser, given)
    if len(options.sizes) != 2:
        parser.error("--sizes takes two: the small engine and the large")
    return options


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    there, absent = planners.peers() if options.peers == "OMPL" else ([], {})
    peer_seeds = min(PEER_SEEDS.of(options), options.seeds)
    ways: dict[str, Callable[[], Result]] = {
        "puzzles": lambda: solving.solved(there, options.seeds, peer_seeds, options.seconds),
        "engine": lambda: engine(options),
    }
    versions = {"OMPL": there[0].version} if there else {}
    return measured_each(ways, options, versions, absent)


def engine(options: argparse.Namespace) -> Result:
    """The sample engine's share."""
    small, large = options.sizes
    return {
        "straight": engine_parts.straight_ways(small, EVERY.of(options)),
        "rate": engine_parts.rate(large, PARTS.of(options), PART_S),
        "access": engine_parts.access(large, TARGETS.of(options), ANGLES),
    }


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
