"""Clash checks: hard pairs, and times of whole assemblies; feeler and its peers.

    python bench/clash/run.py                    everything; half an hour: one peer, and the judge
    python bench/clash/run.py --quick            the short form, two or three minutes
    python bench/clash/run.py --only times --sizes 1.6M --peers none
    python bench/clash/run.py --only judge       random pairs whose depth is known; a quarter of an hour
    python bench/clash/run.py --record           and into bench/records/clash.json, for docs/clash.md

Writes into a folder (target/clash): clash.json with all results, and tables.md. The exit status is 1 if a goal is
missed (bench/clash/goals.py) that does not depend on time: a verdict or a depth of feeler's. `--only`: cases (the pairs
of testdata/clash), judge (random pairs of known depth), times (the sample engine; peers on the smallest size). A record
keeps the results that a run leaves out. Peers come from `pip install "feeler[bench]"`; a missing one is skipped, and
the tables say why. The judge needs manifold3d (`feeler[volume]`).
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

from clash import goals, hard_cases, tables, timings
from clash.checkers import PEERS, Checker, FeelerChecker, peers
from clash.judge import experiment as judging

OUT = host.ROOT / "target" / "clash"
RECORD = host.ROOT / "bench" / "records" / "clash.json"
SIZES, QUICK_SIZES = "100k,1.6M", "20k"
REPEATS, QUICK_REPEATS = 3, 1

Result = dict[str, Any]


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("out", nargs="?", type=Path, default=OUT, help="folder of the results (target/clash)")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SIZES} triangles, coarse boxes, everything once")
    parser.add_argument("--only", type=listed(one_of("experiment", tables.NAMES)), help=", ".join(tables.NAMES))
    parser.add_argument("--sizes", type=listed(triangles), help=f"triangles of the sample engine ({SIZES})")
    parser.add_argument("--repeats", type=int, help=f"of each stage; the least time counts ({REPEATS})")
    names = list(PEERS)
    parser.add_argument("--peers", type=listed(one_of("peer", [*names, "none"])), help=f"{', '.join(names)}; none")
    parser.add_argument("--record", action="store_true", help="also write bench/records/clash.json")
    options = parser.parse_args(arguments)
    options.only = options.only or list(tables.NAMES)
    options.sizes = options.sizes or listed(triangles)(QUICK_SIZES if options.quick else SIZES)
    options.repeats = options.repeats or (QUICK_REPEATS if options.quick else REPEATS)
    options.peers = [name for name in options.peers or names if name != "none"]
    return options


def run(options: argparse.Namespace, given: Sequence[str] = ()) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    there, absent = peers(options.peers)
    for name, reason in absent.items():
        print(f"{name} is left out: {reason}", file=sys.stderr)
    checkers: list[Checker] = [FeelerChecker(), *there]
    ways: dict[str, Callable[[], Result]] = {
        "cases": lambda: hard_cases.asked(checkers, options.quick),
        "judge": lambda: judging.measured(options.quick),
        "times": lambda: timings.measured(options.sizes, there, options.repeats),
    }
    versions = {checker.name: checker.version for checker in checkers}
    return {name: pages.measured(ways[name], options, given, versions, absent) for name in options.only}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write, judge."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = parse(given)
    result = run(options, given)
    return pages.ended(result, options, "clash", tables.page(result), RECORD, goals.scorecard(result))


if __name__ == "__main__":
    sys.exit(main())
