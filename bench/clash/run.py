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
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from command_line import listed, one_of, positive, triangles
from section import Form, Result, measured_each

from clash import hard_cases, timings
from clash.checkers import PEERS, Checker, FeelerChecker, peers
from clash.judge import experiment as judging
from clash.tables import SECTION

SIZES = Form([100_000, 1_600_000], [20_000])
REPEATS = Form(3, 1)


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "a small engine, coarse boxes, everything once")
    add, names = parser.add_argument, list(PEERS)
    add("--sizes", type=listed(triangles), default=SIZES, help=f"triangles of the sample engine ({SIZES})")
    add("--repeats", type=positive, default=REPEATS, help=f"of each stage; the least time counts ({REPEATS})")
    add("--peers", type=listed(one_of("peer", [*names, "none"])), default=names, help=f"{', '.join(names)}; none")
    return SECTION.options(parser, given)


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data: each by name, with its origin."""
    there, absent = peers([name for name in options.peers if name != "none"])
    checkers: list[Checker] = [FeelerChecker(), *there]
    ways: dict[str, Callable[[], Result]] = {
        "cases": lambda: hard_cases.asked(checkers, options.quick),
        "judge": lambda: judging.measured(options.quick),
        "times": lambda: timings.measured(options.sizes, there, options.repeats),
    }
    versions = {checker.name: checker.version for checker in checkers}
    return measured_each(ways, options, versions, absent)


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
