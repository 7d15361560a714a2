"""Times of a whole assembly: the sample engine, feeler on one core and on all, and peers on one."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import host

import feeler

from .checkers import QUERIES, Checker, Pairs, Whole, whole

Result = dict[str, Any]


def measured(sizes: Sequence[int], peers: Sequence[Checker], repeats: int) -> Result:
    """Of each size the seconds of every stage; of the smallest also the peers', and what they find.

    Peers are given one core, as feeler is where it is compared with them.
    """
    has_volumes = find_spec("manifold3d") is not None
    rows = []
    for size in sorted(sizes):
        mockup = feeler.sample("engine", size)
        print(f"{mockup.triangle_count:,} triangles: feeler", file=sys.stderr)
        # All cores first: threads that were started on one core might stay there.
        on_all = whole(mockup, repeats, threads=None, volume=has_volumes)
        with host.on_core(host.last_core()):
            on_one = whole(mockup, repeats, threads=1, volume=has_volumes)
        row: Result = {
            "size": size,
            "triangles": mockup.triangle_count,
            "parts": mockup.part_count,
            "pairs": {query: len(on_one.pairs[query]) for query in QUERIES},
            "one_core_s": _short(on_one),
            "all_cores_s": _short(on_all),
            "peers": {},
        }
        for peer in peers if size == min(sizes) else ():
            print(f"{mockup.triangle_count:,} triangles: {peer.name}", file=sys.stderr)
            with host.on_core(host.last_core()):
                found = peer.whole(mockup, repeats)
            differing = {query: compared(found.pairs[query], on_one.pairs[query]) for query in QUERIES}
            row["peers"][peer.name] = {"one_core_s": _short(found), "pairs": differing}
        rows.append(row)
    return {"repeats": repeats, "has_volumes": has_volumes, "sizes": rows}


def compared(found: Pairs, right: Pairs) -> dict[str, int]:
    """How many pairs a peer finds, misses and makes up."""
    return {"found": len(found), "missed": len(right - found), "made_up": len(found - right)}


def _short(found: Whole) -> dict[str, float]:
    return {stage: float(f"{seconds:.4g}") for stage, seconds in found.seconds.items()}
