"""Figures of docs/scale.md: saved scenes, and work on several processes.

Opens and first queries of a saved scene against loading and indexing; then parts a minute of `feeler.removals`, the
cost of handing over a task, and the memory of processes that open one file.

    python bench/scale.py                    # 1.6M and 10M triangles, one and two workers; a few minutes
    python bench/scale.py --write            # the same, into docs/scale.md
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import host
import pages

import feeler
from feeler.spreading import spread

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "scale.md"
TASKS = 500
"""Without work, to see what handing one over costs."""
SPAWN = multiprocessing.get_context("spawn")


def seconds(work: Callable[[], object], rounds: int = 1) -> float:
    """The best of some rounds."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def private_mib() -> float:
    """Memory of this process that it shares with no other and with no file."""
    with open("/proc/self/smaps_rollup", encoding="ascii") as lines:
        rows = {words[0].rstrip(":"): int(words[1]) for words in map(str.split, lines) if words[-1] == "kB"}
    return rows.get("Private_Dirty", 0) / 1024


def of_worker(scene: feeler.Scene, _shared: None, _task: int) -> tuple[int, float]:
    """A task that queries, so that the worker has the scene open: its process, and that one's own memory."""
    scene.collide(feeler.sample_tool("wrench"), [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return os.getpid(), private_mib()


def empty(_scene: feeler.Scene, _shared: None, task: int) -> int:
    """A task without work."""
    return task


def opens(triangles: int, folder: Path, rounds: int) -> list[str]:
    """A row of the first table."""
    path = folder / f"engine-{triangles}.feeler"
    start = time.perf_counter()
    mockup = feeler.sample("engine", triangles)
    made = time.perf_counter() - start
    index = seconds(lambda: feeler.Scene(mockup))
    scene = feeler.Scene(mockup)
    saved = seconds(lambda: scene.save(path))
    part = [mockup.part_count // 2]
    topology = seconds(lambda: feeler.removal(feeler.Scene(mockup), part, rounds=0))
    plain = seconds(lambda: feeler.open_scene(path, verify=False), rounds)
    verified = seconds(lambda: feeler.open_scene(path), rounds)
    first = statistics.median(
        seconds(partial(feeler.removal, opened, part, rounds=0))
        for opened in [feeler.open_scene(path, verify=False) for _ in range(3)]
    )
    row = [f"{mockup.triangle_count:,}", f"{path.stat().st_size / 1e6:,.0f} MB"]
    row += [f"{made:.2f} s", f"{index:.2f} s", f"{topology:.2f} s", f"{saved:.1f} s"]
    return [*row, f"{1e3 * plain:.1f} ms", f"{1e3 * verified:.0f} ms", f"{first:.2f} s"]


def work(workers: list[int], triangles: int, entries: int, most: float, folder: Path) -> list[list[str]]:
    """Rows of the second table. `most`: seconds for a part."""
    mockup = feeler.sample("gearbox", triangles)
    path = folder / "gearbox.feeler"
    feeler.Scene(mockup).save(path)
    scene = feeler.open_scene(path, threads=1)
    step = max(1, mockup.part_count // entries)
    chosen = [[part] for part in range(0, mockup.part_count, step)][:entries]
    options: dict[str, Any] = {"rounds": 1, "seconds": most}
    rows = []
    alone = seconds(lambda: feeler.removals(scene, chosen, threads=1, **options))
    rows.append(["this process, one thread", f"{60 * len(chosen) / alone:.1f}", "", ""])
    for count in workers:
        with ProcessPoolExecutor(count, mp_context=SPAWN) as pool:
            spread(empty, scene, None, range(4 * count), pool)  # starts them and opens the scene
            took = seconds(partial(feeler.removals, scene, chosen, executor=pool, **options))
            handing = seconds(partial(spread, empty, scene, None, range(TASKS), pool)) / TASKS
            own = dict(spread(of_worker, scene, None, range(20), pool))
        name = f"{count} process{'' if count == 1 else 'es'}"
        rows.append([name, f"{60 * len(chosen) / took:.1f}", f"{1e3 * handing:.2f} ms", f"{max(own.values()):.0f} MiB"])
    return rows


def main() -> int:
    """Measures, prints, and writes where asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        "--triangles", type=int, nargs="+", default=[1_600_000, 10_000_000], help="of the sample engine"
    )
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], help="processes")
    parser.add_argument("--gearbox", type=int, default=75_000, help="triangles of the sample gearbox")
    parser.add_argument("--entries", type=int, default=40, help="parts of it that are taken out")
    parser.add_argument("--seconds", type=float, default=3600.0, help="for each of them at most")
    parser.add_argument("--rounds", type=int, default=5, help="of each open, of which the best counts")
    parser.add_argument("--write", action="store_true", help="write the tables into docs/scale.md")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="feeler-bench-") as name:
        folder = Path(name)
        rows = [opens(triangles, folder, options.rounds) for triangles in options.triangles]
        shared = work(options.workers, options.gearbox, options.entries, options.seconds, folder)
    machine = host.machine()
    note = f"{machine['cpu']}, {machine['cores']} cores; `python bench/scale.py`."
    heads = [
        "triangles",
        "file",
        "made",
        "index",
        "first removal",
        "save",
        "open",
        "open, verified",
        "first removal, opened",
    ]
    tables = {
        "opens": pages.markdown(heads, 0, rows, f"The sample engine. {note}"),
        "workers": pages.markdown(
            ["where", "parts a minute", "handing over a task", "own memory of a worker"],
            1,
            shared,
            f"`feeler.removals` of {options.entries} parts of the sample gearbox, one round each. {note}",
        ),
    }
    print("\n\n".join(tables.values()))
    if options.write:
        PAGE.write_text(pages.filled(PAGE.read_text(encoding="utf-8"), "scale", tables), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
