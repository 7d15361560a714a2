"""Loads, indexes and collides real models, and writes the table of docs/real-data.md.

    python bench/real_data.py                               $FEELER_MODELS, or shared/models beside the clone
    python bench/real_data.py ~/models --poses 100 --peers  another folder; Coal on the same poses
    python bench/real_data.py --only 'cylinder2*' --out /tmp/table.md

Every file of the folder is loaded, and its result or error is reported. Every mock-up of 10,000 triangles or more is
indexed and collided with the tools. Models in folders called tools* or hand* are tools, all others mock-ups. The exit
status is 1 if an error was not of feeler's types, or if a pair judged in exact arithmetic was wrong.
"""

from __future__ import annotations

import argparse
import fnmatch
import gc
import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import agreement
import command_line
import engines
import host
import measure
import numpy as np
import real_files
import real_table

import feeler
from feeler.choices import PoseKind
from feeler.io import load_mockup, load_tool
from feeler.progress import bar

TOOLS = "screwdriver.ply,adjustable_wrench.ply,hand_closed.obj,vise_grip.ply"
KINDS: tuple[PoseKind, ...] = ("nominal", "near")
LEAST_TRIANGLES = 10_000
PEER_LIMIT = 3_000_000  # triangles; above, a peer's index takes minutes and gigabytes


def main(arguments: list[str] | None = None) -> int:
    """Run, write; 0, or 1 if something is wrong."""
    given = sys.argv[1:] if arguments is None else arguments
    options = parse(given)
    if options.folder is None or not options.folder.is_dir():
        print(f"{options.folder or 'no folder'}: name a folder of models, or set FEELER_MODELS.", file=sys.stderr)
        return 2
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="feeler-models-") as scratch:
        run = Run(options, Path(scratch))
        run.all()
    result = {
        "when": host.now(),
        **host.commit(),
        "args": ["FOLDER" if Path(word) == options.folder else word for word in host.arguments(given)],
        "machine": host.machine(),
        "load_average": host.load_average(),
        "versions": host.versions({engine.name: engine.version for engine in run.engines}),
        "cargo_profile": host.build_profile(),
        "poses": options.poses,
        "rounds": options.rounds,
        "files": run.files,
        "others": run.others,
        "mockups": run.mockups,
        "tools": run.tools_used,
        "cells": run.cells,
        "sources": real_files.sources(options.folder),
        "seconds": round(time.perf_counter() - started, 1),
    }
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(real_table.markdown(result), encoding="utf-8")
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    untyped = [row["name"] for row in run.files if row["outcome"] == "untyped"]
    wrong = sum(cell.get("agreement", {}).get("feeler_wrong", 0) for cell in run.cells)
    loaded = sum(row["outcome"] == "loaded" for row in run.files)
    refused = len(run.files) - loaded - len(untyped)
    print(f"{len(run.files)} files: {loaded} loaded, {refused} refused with a message, {len(untyped)} failed otherwise")
    print(f"{len(run.mockups)} mock-ups indexed, {len(run.cells)} cells of queries, {wrong} wrong pairs")
    for name in untyped:
        print(f"an error without a type: {name}")
    print(f"Written: {options.out}")
    return 1 if untyped or wrong else 0


class Run:
    """All files, then all mock-ups with all tools."""

    def __init__(self, options: argparse.Namespace, scratch: Path) -> None:
        self.options = options
        self.scratch = scratch
        self.engines: list[engines.Engine] = [engines.FeelerEngine()]
        if options.peers:
            try:
                from coal_engine import CoalEngine

                self.engines.append(CoalEngine())
            except ImportError:
                print("Coal is not installed (pip install coal): feeler is measured alone.", file=sys.stderr)
        self.files: list[dict[str, Any]] = []
        self.others: list[str] = []
        self.mockups: list[dict[str, Any]] = []
        self.tools_used: list[dict[str, Any]] = []
        self.cells: list[dict[str, Any]] = []
        self._started = time.perf_counter()

    def all(self) -> None:
        """Fill the lists."""
        models, self.others = real_files.find(self.options.folder)
        models = [model for model in models if not self._is_skipped(model.name)]
        tools = self._tools(models)
        wanted = [fnmatch.fnmatch(model.name, self.options.only) for model in models]
        for model in (model for model, want in zip(models, wanted, strict=True) if want):
            mockup = self._load(model)
            if mockup is not None and not model.is_tool and mockup.triangle_count >= self.options.least:
                self._mockup(model, mockup, tools)
            del mockup
            gc.collect()

    def _is_skipped(self, name: str) -> bool:
        return any(fnmatch.fnmatch(name, pattern) for pattern in self.options.skip)

    def _tools(self, models: list[real_files.Model]) -> list[feeler.Tool]:
        tools = []
        for name in self.options.tools:
            model = next((model for model in models if model.is_tool and Path(model.name).name == name), None)
            if model is None:
                self._say(f"no tool called {name} there: left out")
                continue
            tool = load_tool(model.files(self.scratch), model.unit)
            if model.scale != 1.0:
                tool = feeler.Tool(tool.vertices * model.scale, tool.faces, tool.name, source=tool.source)
            extent = [round(side, 4) for side in tool.report.extent]
            self.tools_used.append({"name": tool.name, "file": model.name, "triangles": tool.triangle_count})
            self.tools_used[-1] |= {"extent_m": extent, "scale": model.scale}
            tools.append(tool)
        return tools

    def _load(self, model: real_files.Model) -> feeler.Mockup | None:
        """Load one file, and put down what came of it."""
        self._say(f"{model.name} ({model.megabytes:.1f} MB)")
        row: dict[str, Any] = {"name": model.name, "megabytes": model.megabytes}
        self.files.append(row)
        files = model.files(self.scratch)
        start = time.perf_counter()
        try:
            with bar(f"loading {model.name}") as progress:
                mockup = load_mockup(files, model.unit, progress=progress)
        except Exception as error:
            row["outcome"] = "refused" if isinstance(error, feeler.FeelerError) else "untyped"
            row["message"] = f"{type(error).__name__}: {self._without_folders(str(error))}"
            return None
        finally:
            row["seconds"] = time.perf_counter() - start
        report = mockup.report
        row |= {
            "outcome": "loaded",
            "triangles": report.triangles,
            "parts": report.parts,
            "extent_m": list(report.extent),
            "unit": f"{report.source.unit} ({report.source.unit_source})",
            "defects": {kind: defect.count for kind, defect in report.defects.items() if defect.count},
            "notes": [self._without_folders(note) for note in report.source.notes],
        }
        return mockup

    def _without_folders(self, text: str) -> str:
        """Paths relative to the folder: its place on this machine stays private."""
        for folder in (self.options.folder, self.options.folder.resolve(), self.scratch, self.scratch.resolve()):
            text = text.replace(f"{folder}{os.sep}", "")
        return text

    def _mockup(self, model: real_files.Model, loaded: feeler.Mockup, tools: list[feeler.Tool]) -> None:
        mockup, scale = real_files.arrange(model, loaded)
        in_play = [engine for engine in self.engines if engine.name == "feeler" or mockup.triangle_count <= PEER_LIMIT]
        self._say(f"  indexing {mockup.triangle_count:,} triangles")
        builds = [engine.build(mockup, 1).row(mockup.triangle_count) for engine in in_play]
        about = {"mockup": model.name, "triangles": mockup.triangle_count, "parts": mockup.part_count}
        extent = list(mockup.report.extent)
        self.mockups.append({**about, "scale": scale, "extent_m": extent, "builds": builds})
        scene = in_play[0].scene  # type: ignore[attr-defined]
        for tool in tools:
            for engine in in_play:
                engine.prepare(tool)
            for kind in KINDS:
                self._say(f"  {tool.name}, {kind}")
                cell = {**about, "tool": tool.name, "tool_triangles": tool.triangle_count, "kind": kind}
                self.cells.append(cell)
                self._cell(cell, scene, tool, kind, in_play)

    def _cell(
        self,
        cell: dict[str, Any],
        scene: feeler.Scene,
        tool: feeler.Tool,
        kind: PoseKind,
        in_play: list[engines.Engine],
    ) -> None:
        try:
            poses = measure.find_poses(scene, tool, kind, self.options.poses)
        except feeler.OptionError as error:
            cell["problem"] = str(error)
            return
        found = measure.look(in_play, poses)
        times = measure.clock(in_play, poses, self.options.rounds)
        counts = np.array([len(pairs) for pairs in found["feeler"].pairs])
        cell |= {
            "poses": len(poses),
            "pairs": {"median": float(np.median(counts)), "worst": int(counts.max())},
            "engines": {name: own.figures() for name, own in times.items()},
        }
        if "coal" in found:
            judged = agreement.compare(scene.mockup, tool, poses, found["feeler"], found["coal"])
            cell["agreement"] = judged.row()

    def _say(self, what: str) -> None:
        print(f"[{time.perf_counter() - self._started:6.1f} s] {what}", file=sys.stderr, flush=True)


def parse(arguments: list[str]) -> argparse.Namespace:
    """Options."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument(
        "folder", type=Path, nargs="?", default=os.environ.get("FEELER_MODELS"), help="of models (FEELER_MODELS)"
    )
    parser.add_argument("--tools", type=lambda text: text.split(","), default=TOOLS.split(","), help=f"files ({TOOLS})")
    parser.add_argument("--only", default="*", metavar="PATTERN", help="only such files: 'degenerate/*'")
    parser.add_argument("--skip", action="append", default=[], metavar="PATTERN", help="not these; may be repeated")
    parser.add_argument("--least", type=int, default=LEAST_TRIANGLES, help="triangles of a mock-up to query (10000)")
    parser.add_argument("--poses", type=int, default=50, help="of each kind (50)")
    parser.add_argument("--rounds", type=int, default=3, help="of all poses; the least time of each counts (3)")
    parser.add_argument("--peers", action="store_true", help="Coal too, up to 3M triangles; differing pairs are judged")
    parser.add_argument("--out", type=Path, default=host.ROOT / "docs" / "real-data.md", help="the Markdown file")
    parser.add_argument("--json", type=Path, help="all figures, too")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
