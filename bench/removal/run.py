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
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line
import host
import pages
from command_line import listed, one_of, triangles

from removal import engine_parts, goals, planners, solving, tables

OUT = host.ROOT / "target" / "removal"
RECORD = host.ROOT / "bench" / "records" / "removal.json"
SIZES, QUICK_SIZES = "100k,1.6M", "20k,20k"
SEEDS, QUICK_SEEDS = 30, 2
PEER_SEEDS, QUICK_PEER_SEEDS = 3, 1
SECONDS, QUICK_SECONDS = 10.0, 1.0
EVERY, QUICK_EVERY = 1, 20
PARTS, QUICK_PARTS, PART_S = 100, 10, 0.5
TARGETS, QUICK_TARGETS, ANGLES = 200, 10, 72

Result = dict[str, Any]


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("out", nargs="?", type=Path, default=OUT, help="folder of the results (target/removal)")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SEEDS} seeds, 1 s a try, a small engine")
    parser.add_argument("--only", type=listed(one_of("experiment", tables.NAMES)), help=", ".join(tables.NAMES))
    parser.add_argument("--sizes", type=listed(triangles), help=f"triangles of the engine, small and large ({SIZES})")
    parser.add_argument("--seeds", type=int, help=f"tries of feeler at a puzzle ({SEEDS}); of others {PEER_SEEDS}")
    parser.add_argument("--seconds", type=float, help=f"most time of a try at a puzzle ({SECONDS:g})")
    parser.add_argument("--peers", type=one_of("choice", ["OMPL", "none"]), default="OMPL", help="OMPL, none")
    parser.add_argument("--record", action="store_true", help="also write bench/records/removal.json")
    options = parser.parse_args(arguments)
    options.only = options.only or list(tables.NAMES)
    options.sizes = options.sizes or listed(triangles)(QUICK_SIZES if options.quick else SIZES)
    if len(options.sizes) != 2:
        parser.error("--sizes takes two: the small engine and the large")
    options.seeds = options.seeds or (QUICK_SEEDS if options.quick else SEEDS)
    options.seconds = options.seconds or (QUICK_SECONDS if options.quick else SECONDS)
    return options


def run(options: argparse.Namespace, given: Sequence[str] = ()) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    there, absent = planners.peers() if options.peers == "OMPL" else ([], {})
    for name, reason in absent.items():
        print(f"{name} is left out: {reason}", file=sys.stderr)
    peer_seeds = QUICK_PEER_SEEDS if options.quick else PEER_SEEDS
    ways: dict[str, Callable[[], Result]] = {
        "puzzles": lambda: solving.solved(there, options.seeds, min(peer_seeds, options.seeds), options.seconds),
        "engine": lambda: engine(options),
    }
    versions = {"OMPL": there[0].version} if there else {}
    return {name: pages.measured(ways[name], options, given, versions, absent) for name in options.only}


def engine(options: argparse.Namespace) -> Result:
    """The sample engine's share."""
    small, large = options.sizes
    quick = options.quick
    return {
        "straight": engine_parts.straight_ways(small, QUICK_EVERY if quick else EVERY),
        "rate": engine_parts.rate(large, QUICK_PARTS if quick else PARTS, PART_S),
        "access": engine_parts.access(large, QUICK_TARGETS if quick else TARGETS, ANGLES),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write, judge."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = parse(given)
    result = run(options, given)
    return pages.ended(result, options, "removal", tables.page(result), RECORD, goals.scorecard(result))


if __name__ == "__main__":
    sys.exit(main())
