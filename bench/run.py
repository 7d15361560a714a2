"""Measures feeler and its peers on the same poses in the same run, and writes a dated record.

    make bench                                  all sizes and tools, 100 poses a cell
    make bench QUICK=1                          two sizes, 20 poses: a few minutes
    python bench/run.py --sizes 1.6M --tools hand --kinds nominal,deep --poses 300
    python bench/run.py --no-peers --out /tmp/records

A cell is a mock-up size, a tool and a kind of poses. How it is timed: bench/measure.py. How peers are set up:
bench/*_engine.py. Pairs that only one engine finds are judged in exact arithmetic: bench/judge.py. There is no pass or
fail in the times; the exit status is 1 only if feeler found a pair that is none, or missed one.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import engines
import measure
import numpy as np
import record
import tables

import feeler
from feeler.progress import bar
from feeler.samples.mockups import sample
from feeler.samples.tools import sample_tool

SIZES, QUICK_SIZES = "100k,400k,1.6M", "100k,400k"
TOOLS = "torque,wrench,square,hand,hand-fine"
KINDS = ("nominal", "near", "deep")
METHOD = (
    "Per cell: one unclocked pass over all poses, then `rounds` passes; at each pose every engine is called once, in "
    "an order that rotates with pose and round. Of each pose the least time over the rounds counts; median, p95, p99, "
    "worst and mean are over poses. wall: perf_counter; cpu: CPU time of the calling thread; one core. times faster: "
    "the peer's figure over feeler's. Python bindings on both sides, nothing subtracted; overheads: median of a call "
    "with the tool far outside. Builds: the fastest of `runs`. bytes: feeler's scene.memory()['total'], which includes "
    "the mock-up's arrays that the index reads; Coal's memUsage, which includes its copy of the mesh. rss growth: the "
    "process's resident set after one build less before, freed memory given back first; for feeler the mock-up's "
    "arrays are there before."
)


def main(arguments: list[str] | None = None) -> int:
    """Run, print, write; 0, or 1 if feeler is wrong somewhere."""
    given = sys.argv[1:] if arguments is None else arguments
    options = parse(given)
    started = time.perf_counter()
    bench = Bench(options)
    when, load_before = record.now(), record.load_average()
    bench.run()
    result = {
        "schema": record.SCHEMA,
        "when": when,
        **record.commit(),
        "args": record.arguments(given),
        "machine": record.machine(),
        "load_average": {"before": load_before, "after": record.load_average()},
        "versions": record.versions({engine.name: engine.version for engine in bench.engines}),
        "cargo_profile": record.build_profile(),
        "engines": {engine.name: engine.settings for engine in bench.engines},
        "absent": bench.absent,
        "method": METHOD,
        "overheads": bench.overheads,
        "sizes": bench.sizes,
        "cells": bench.cells,
        "seconds": round(time.perf_counter() - started, 1),
    }
    out = tables.console()
    tables.show(result, out)
    for path in record.write(result, options.out):
        out.print(f"Written: {path}", highlight=False, soft_wrap=True)
    wrong = sum(found["feeler_wrong"] for cell in bench.cells for found in cell.get("agreement", {}).values())
    return 1 if wrong else 0


class Bench:
    """All cells, one after the other."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.absent: dict[str, str] = {}
        self.engines: list[engines.Engine] = [engines.FeelerEngine()]
        if options.peers:
            self.engines += self._peers()
        self.overheads: dict[str, Any] = {}
        self.sizes: list[dict[str, Any]] = []
        self.cells: list[dict[str, Any]] = []
        self._started = time.perf_counter()

    def _peers(self) -> list[engines.Engine]:
        try:
            from coal_engine import CoalEngine
        except ImportError as error:
            self.absent["coal"] = str(error)
            print("Coal is not installed (pip install coal): feeler is measured alone.", file=sys.stderr)
            return []
        return [CoalEngine()]

    def run(self) -> None:
        """Fill `sizes` and `cells`."""
        for size in self.options.sizes:
            self._size(size)

    def _size(self, size: int) -> None:
        with bar(f"making an engine of {size:,} triangles") as progress:
            mockup = sample("engine", size, self.options.seed, progress=progress)
        builds = []
        for engine in self.engines:
            self._say(f"{mockup.triangle_count:,} triangles: {engine.name} builds, {self.options.builds} times")
            builds.append(engine.build(mockup, self.options.builds).row(mockup.triangle_count))
        about = {"triangles_asked": size, "triangles": mockup.triangle_count, "parts": mockup.part_count}
        self.sizes.append({**about, "sample": "engine", "seed": self.options.seed, "builds": builds})
        scene = self.engines[0].scene  # type: ignore[attr-defined]
        for name, tool in self.options.tools.items():
            if not self.overheads:
                self.overheads = measure.overheads(self.engines, mockup, tool)
            prepared = {engine.name: engine.prepare(tool) for engine in self.engines}
            for kind in self.options.kinds:
                self._say(f"{mockup.triangle_count:,} triangles, {name}, {kind}")
                cell = {"query": "collide", **about, "tool": name, "tool_triangles": tool.triangle_count, "kind": kind}
                cell["tool_seconds"] = prepared
                self._cell(cell, scene, tool, kind)
                self.cells.append(cell)

    def _cell(self, cell: dict[str, Any], scene: feeler.Scene, tool: feeler.Tool, kind: str) -> None:
        try:
            poses = measure.find_poses(scene, tool, kind, self.options.poses, self.options.seed)
        except feeler.OptionError as error:
            cell["problem"] = str(error)
            return
        found = measure.look(self.engines, poses)
        times = measure.clock(self.engines, poses, self.options.rounds)
        counts = np.array([len(pairs) for pairs in found["feeler"].pairs])
        stats = found["feeler"].stats
        peers = [engine.name for engine in self.engines if engine.name != "feeler"]
        cell |= {
            "poses": len(poses),
            "poses_asked": self.options.poses,
            "rounds": self.options.rounds,
            "pairs": {"median": float(np.median(counts)), "mean": float(counts.mean()), "worst": int(counts.max())},
            "engines": {name: own.figures() for name, own in times.items()},
            "ratios": {name: measure.ratios(times["feeler"], times[name]) for name in peers},
            "agreement": {
                name: measure.compare(scene.mockup, tool, poses, found["feeler"], found[name]).row() for name in peers
            },
            "funnel": {stage: float(np.mean([one[stage] for one in stats])) for stage in stats[0]},
        }

    def _say(self, what: str) -> None:
        # Lines and no moving bar: its thread would share the core, and Python's lock, with what is measured.
        print(f"[{time.perf_counter() - self._started:6.1f} s] {what}", file=sys.stderr, flush=True)


def parse(arguments: list[str]) -> argparse.Namespace:
    """Options, with the quick form's where none are given."""
    head, examples, tail = (__doc__ or "").split("\n\n")
    parser = argparse.ArgumentParser(
        description=f"{head}\n\n{tail}",
        epilog="examples:\n" + examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help=f"sizes {QUICK_SIZES}, 20 poses, 3 rounds, one build")
    parser.add_argument("--sizes", type=_listed(_size), help=f"triangles of the mock-up ({SIZES})")
    parser.add_argument("--tools", type=_listed(str), default=TOOLS, help=f"sample tools; -fine: about 50k ({TOOLS})")
    parser.add_argument("--kinds", type=_listed(_kind), default="nominal,near", help="of nominal,near,deep")
    parser.add_argument("--poses", type=_count, help="in each cell (100)")
    parser.add_argument("--rounds", type=_count, help="of all poses; the least time of each pose counts (5)")
    parser.add_argument("--builds", type=_count, help="of each index; the fastest counts (2)")
    parser.add_argument("--seed", type=int, default=0, help="of mock-ups and poses (0)")
    parser.add_argument("--no-peers", dest="peers", action="store_false", help="feeler alone")
    parser.add_argument("--out", type=Path, default=record.ROOT / "bench" / "records", help="folder of the record")
    options = parser.parse_args(arguments)
    options.sizes = options.sizes or _listed(_size)(QUICK_SIZES if options.quick else SIZES)
    options.poses = options.poses or (20 if options.quick else 100)
    options.rounds = options.rounds or (3 if options.quick else 5)
    options.builds = options.builds or (1 if options.quick else 2)
    try:
        options.tools = {
            name: sample_tool(name.removesuffix("-fine"), name.endswith("-fine")) for name in options.tools
        }
    except feeler.OptionError as error:
        parser.error(str(error))
    return options


def _listed(kind: Callable[[str], Any]) -> Callable[[str], list[Any]]:
    def values(text: str) -> list[Any]:
        return [kind(word.strip()) for word in text.split(",") if word.strip()]

    return values


def _size(text: str) -> int:
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([kM]?)", text.replace("_", ""))
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} is no size: write 100000, 100k or 1.6M")
    size = round(float(found[1]) * {"": 1, "k": 1_000, "M": 1_000_000}[found[2]])
    if size < 10_000:
        raise argparse.ArgumentTypeError(f"{text!r}: a sample has at least 10,000 triangles")
    return size


def _kind(text: str) -> str:
    if text not in KINDS:
        raise argparse.ArgumentTypeError(f"{text!r} is no kind of poses: choose of {', '.join(KINDS)}")
    return text


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: a whole number from 1 is needed")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
