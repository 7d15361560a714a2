"""The command line of run.py."""

from __future__ import annotations

import argparse
from pathlib import Path

import command_line
import peers
from command_line import listed, one_of, triangles
from engines import QUERIES

import feeler
from feeler.samples.poses import KINDS
from feeler.samples.tools import sample_tool

MOST_ROUNDS = 40  # of those in play
SIZES, QUICK_SIZES = "100k,400k,1.6M,6.4M", "100k,400k"
TOOLS = "torque,wrench,square,hand,hand-fine"


def parse(arguments: list[str], said: str) -> argparse.Namespace:
    """Options, with the quick form's where none are given."""
    parser = command_line.parser(said)
    parser.add_argument("--quick", action="store_true", help=f"sizes {QUICK_SIZES}; 40 poses, 3 rounds, one build")
    parser.add_argument("--sizes", type=listed(triangles), help=f"triangles of the mock-up ({SIZES})")
    parser.add_argument("--tools", type=listed(str), default=TOOLS, help=f"sample tools; -fine: about 50k ({TOOLS})")
    parser.add_argument("--kinds", type=listed(one_of("kind of poses", KINDS)), default=",".join(KINDS), help="(all)")
    parser.add_argument(
        "--queries", type=listed(one_of("query", QUERIES)), default=",".join(QUERIES), help=f"({','.join(QUERIES)})"
    )
    parser.add_argument("--poses", type=_count, help="in each cell (100)")
    parser.add_argument(
        "--rounds",
        type=_count,
        help=f"of all poses; the least time of each counts (5, of feeler and the best peers up to {MOST_ROUNDS})",
    )
    parser.add_argument("--builds", type=_count, help="of each index; the fastest counts (5)")
    parser.add_argument(
        "--worst", type=_count_or_none, metavar="N", help="nominal poses, for the worst (10000); 0: skip"
    )
    parser.add_argument("--batch", type=_count_or_none, metavar="N", help="poses in a batch (5000); 0: skip")
    parser.add_argument("--seed", type=int, default=0, help="of mock-ups and poses (0)")
    names = list(peers.PEERS)
    parser.add_argument("--peers", type=listed(one_of("peer", names)), default=",".join(names), help="(all)")
    parser.add_argument("--no-peers", dest="peers", action="store_const", const=[], help="feeler alone")
    parser.add_argument("--out", type=Path, help="folder of the record, whatever this run is worth")
    parser.add_argument("--json", type=Path, help="all that was found, too: single poses of pairs that differ")
    options = parser.parse_args(arguments)
    options.sizes = options.sizes or listed(triangles)(QUICK_SIZES if options.quick else SIZES)
    options.short = []
    options.most_rounds = 0 if options.quick or options.rounds else MOST_ROUNDS
    for name, quick, full in (
        ("poses", 40, 100),
        ("rounds", 3, 5),
        ("builds", 1, 5),
        ("worst", 1000, 10_000),
        ("batch", 500, 5000),
    ):
        if getattr(options, name) is None:
            setattr(options, name, quick if options.quick else full)
        # The rows of one record are measured alike; a skipped measurement has no rows.
        if getattr(options, name) not in (full, 0):
            options.short.append(f"--{name} is {getattr(options, name):,}, not {full:,}")
    if not options.most_rounds:
        options.short.append("the best engines get no further rounds")
    if options.seed:
        options.short.append(f"--seed is {options.seed}, not 0")
    try:
        options.tools = {
            name: sample_tool(name.removesuffix("-fine"), name.endswith("-fine")) for name in options.tools
        }
    except feeler.OptionError as error:
        parser.error(str(error))
    return options


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: a whole number from 1 is needed")
    return int(text)


def _count_or_none(text: str) -> int:
    return 0 if text == "0" else _count(text)
