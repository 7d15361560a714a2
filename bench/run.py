"""Measures feeler and its peers on the same poses in the same run, into the record of this kind of machine.

    make bench                                  all sizes and tools, 100 poses a cell, all peers that are there
    make bench QUICK=1                          two sizes, 40 poses: a few minutes, into target/bench/records
    python bench/run.py --sizes 1.6M --tools hand --kinds nominal,deep
    python bench/run.py --no-peers --queries collide --poses 300 --worst 0 --batch 0 --out /tmp/records

A cell is a mock-up size, a tool, a kind of poses and a query; a run replaces the rows of its cells in bench/records,
and keeps the others. A run that is not comparable (short, with uncommitted changes, without a peer that the record has)
goes into target/bench/records instead, and says why. Timing: bench/measure.py. Set-up of peers: bench/*_engine.py.
Pairs that only one engine finds are judged in exact arithmetic: bench/judge.py. Times neither pass nor fail; the exit
status is 1 only if feeler reported a false pair, or missed one.
"""

from __future__ import annotations

import argparse
import gc
import json
import sys
import time
from collections.abc import Iterable
from typing import Any

import agreement
import engines
import extras
import figures
import goals
import host
import measure
import numpy as np
import peers
import worst
from options import parse
from record import Origin, elsewhere, keep
from rows import rows

import feeler
from feeler.choices import PoseKind
from feeler.progress import bar
from feeler.samples.mockups import sample

BUSY = 1.5  # more than this many on the machine, this one included
ONE_SIZE = 1_600_000  # triangles, where a thing is measured at one size; without such a mock-up, the largest


def main(arguments: list[str] | None = None) -> int:
    """Run, print, write; 0, or 1 if feeler is wrong somewhere."""
    given = sys.argv[1:] if arguments is None else arguments
    options = parse(given, __doc__ or "")
    started, origin, load_before = time.perf_counter(), Origin.here(feeler.__version__), host.load_average()
    bench = Bench(options)
    reasons = [*options.short, *origin.reasons_against(engine.name for engine in bench.engines)]
    if reasons and not options.out:
        print(elsewhere(reasons), file=sys.stderr)
    bench.run()
    result = {
        "when": host.now(),
        **host.commit(),
        "args": host.arguments(given),
        "machine": host.machine(),
        "load_average": {"before": load_before, "after": host.load_average()},
        "versions": host.versions({engine.name: engine.version for engine in bench.engines}),
        "cargo_profile": origin.profile,
        "engines": {engine.name: engine.settings for engine in bench.engines},
        "absent": bench.absent,
        "overheads": bench.overheads,
        "python_call": bench.python_call,
        "sizes": bench.sizes,
        "cells": bench.cells,
        "batch": bench.batch,
        "fine": bench.fine,
        "worst": bench.worst,
        "seconds": round(time.perf_counter() - started, 1),
    }
    found = origin.marked(rows(result))
    figures.show(found)
    if load_before and max(load_before[0], result["load_average"]["after"][0]) > BUSY:
        print("The machine was busy: the figures are too large rather than too small.")
    for peer, reason in bench.absent.items():
        print(f"{peer} is absent: {reason}")
    print(f"Written: {keep(found, origin, options.out, reasons)}")
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        print(f"Written: {options.json}")
    wrong = sum(found.get("feeler_wrong", 0) for cell in bench.cells for found in cell.get("agreement", {}).values())
    return 1 if wrong else 0


class Bench:
    """All cells, one after the other."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self._started = time.perf_counter()
        self._one_size = ONE_SIZE if ONE_SIZE in options.sizes else options.sizes[-1]
        there, self.absent = peers.find(options.peers)
        for name, reason in self.absent.items():
            self._say(f"{name} is absent: {reason}")
        self.engines: list[engines.Engine] = [engines.FeelerEngine(), *there]
        self.overheads: dict[str, Any] = {}
        self.python_call: dict[str, float] = {}
        self.sizes: list[dict[str, Any]] = []
        self.cells: list[dict[str, Any]] = []
        self.batch: list[dict[str, Any]] = []
        self.fine: list[dict[str, Any]] = []
        self.worst: list[dict[str, Any]] = []

    def run(self) -> None:
        """Fill the lists."""
        for size in self.options.sizes:
            self._size(size)

    def _size(self, size: int) -> None:
        with bar(f"making an engine of {size:,} triangles") as progress:
            mockup = sample("engine", size, self.options.seed, progress=progress)
        builds = []
        for engine in self.engines:
            self._say(f"{mockup.triangle_count:,} triangles: {engine.name} builds")
            builds.append(engine.build(mockup, self.options.builds).row(mockup.triangle_count))
        about = {"triangles_asked": size, "triangles": mockup.triangle_count, "parts": mockup.part_count}
        self.sizes.append({**about, "sample": "engine", "seed": self.options.seed, "builds": builds})
        scene = self.engines[0].scene  # type: ignore[attr-defined]
        nominal = {}
        for name, tool in self.options.tools.items():
            if not self.overheads:
                self.overheads = measure.overheads(self.engines, mockup, tool)
                self.python_call = extras.python_call(mockup, tool)
            prepared = {engine.name: engine.prepare(tool) for engine in self.engines}
            for kind in self.options.kinds:
                cell = {**about, "tool": name, "tool_triangles": tool.triangle_count, "kind": kind}
                cell["tool_seconds"] = prepared
                poses = self._cells(cell, scene, tool, kind)
                if kind == "nominal" and poses is not None:
                    nominal[name] = poses
        self._fine(about, scene, nominal)
        if size == self._one_size:
            self._alone(about, scene, nominal.keys())

    def _cells(
        self, about: dict[str, Any], scene: feeler.Scene, tool: feeler.Tool, kind: PoseKind
    ) -> engines.Floats | None:
        """The cells of one kind of poses: one for each query."""
        head = f"{about['triangles']:,} triangles, {about['tool']}, {kind}"
        queries = [query for query in self.options.queries if kind in engines.KINDS_OF[query]]
        if about["triangles_asked"] != self._one_size:
            queries = [query for query in queries if query not in engines.AT_ONE_SIZE]
        self._say(f"{head}: finding poses")
        try:
            poses = measure.find_poses(scene, tool, kind, self.options.poses, self.options.seed)
        except feeler.OptionError as error:
            self.cells += [{"query": query, **about, "problem": str(error)} for query in queries]
            return None
        pairs = measure.look(self.engines, poses)
        for query in queries:
            self._say(f"{head}: {query}")
            asked = measure.ways(poses, self.options.seed) if query == "cast" else poses
            found = pairs if query == "collide" else measure.look(engines.able(self.engines, query), asked, query)
            cell = {"query": query, **about}
            self._cell(cell, scene.mockup, tool, asked, pairs["feeler"], found)
            self.cells.append(cell)
        return poses

    def _cell(
        self,
        cell: dict[str, Any],
        mockup: feeler.Mockup,
        tool: feeler.Tool,
        poses: engines.Floats,
        ours: measure.Findings,
        found: dict[str, measure.Findings],
    ) -> None:
        able = engines.able(self.engines, cell["query"])
        times = measure.clock(able, poses, self.options.rounds, cell["query"], self.options.most_rounds)
        others = able[1:]
        counts = np.array([len(pairs) for pairs in ours.pairs])
        cell |= {
            "poses": len(poses),
            "poses_asked": self.options.poses,
            "rounds": len(times["feeler"].wall),
            "pairs": {"median": float(np.median(counts)), "mean": float(counts.mean()), "worst": int(counts.max())},
            "engines": {name: own.figures() for name, own in times.items()},
            "ratios": {peer.name: measure.ratios(times["feeler"], times[peer.name]) for peer in others},
        }
        if cell["query"] == "collide":
            verdicts: agreement.Verdicts = {}
            cell["agreement"] = {
                peer.name: agreement.compare(mockup, tool, poses, ours, found[peer.name], verdicts).row()
                for peer in others
            }
            cell["funnel"] = {stage: float(np.mean([one[stage] for one in ours.stats])) for stage in ours.stats[0]}
        elif cell["query"] == "is_colliding":
            answers = measure.Findings(pairs=ours.pairs, answers=found["feeler"].answers)
            cell["agreement"] = {
                peer.name: agreement.compare_answers(mockup, tool, poses, answers, peer, found[peer.name])
                for peer in others
            }
        elif cell["query"] == "contacts":
            cell["agreement"], cell["planes"] = {}, float(np.mean(found["feeler"].values))
        else:
            casts = cell["query"] == "cast"
            compare = agreement.compare_casts if casts else agreement.compare_distances
            cell["agreement"] = {peer.name: compare(found["feeler"], found[peer.name]) for peer in others}
            if casts:
                cell["hits"] = int((np.array(found["feeler"].values) <= 1.0).sum())

    def _fine(self, about: dict[str, Any], scene: feeler.Scene, nominal: dict[str, engines.Floats]) -> None:
        for name, poses in nominal.items():
            fine = self.options.tools.get(f"{name}-fine")
            if fine is not None:
                self._say(f"{about['triangles']:,} triangles, {name} and {name}-fine at the same poses")
                row = extras.fine_and_coarse(scene, self.options.tools[name], fine, poses, self.options.rounds)
                self.fine.append({**about, "tool": name, **row})

    def _alone(self, about: dict[str, Any], scene: feeler.Scene, names: Iterable[str]) -> None:
        """Measurements of feeler alone, at one size, with tools that have nominal poses there."""
        for name in names:
            tool = self.options.tools[name]
            if self.options.batch and name in extras.BATCH_TOOLS:
                self._say(f"{about['triangles']:,} triangles, {name}: batches of {self.options.batch:,} poses")
                row = extras.batch(scene, tool, self.options.batch, self.options.seed)
                self.batch.append({**about, "tool": name, **row})
            if self.options.worst and tool.triangle_count <= goals.SMALL_TOOL:
                self._say(
                    f"{about['triangles']:,} triangles, {name}: the worst of {self.options.worst:,} nominal poses"
                )
                gc.collect()
                row = worst.worst(scene, tool, self.options.worst, self.options.seed)
                self.worst.append({**about, "tool": name, "tool_triangles": tool.triangle_count, **row})

    def _say(self, what: str) -> None:
        # Lines and no moving bar: its thread would share the core, and Python's lock, with the measured code.
        print(f"[{time.perf_counter() - self._started:6.1f} s] {what}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
