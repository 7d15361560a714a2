"""The workbench in a headless Chromium with a software renderer, on one core, against its goals.

    python bench/workbench/run.py                    the sample engine of 1.6M triangles; a quarter of an hour
    python bench/workbench/run.py --quick            the short form, minutes
    python bench/workbench/run.py --big              also of 10 million triangles
    python bench/workbench/run.py --only soak --soak 30
    python bench/workbench/run.py --record           into bench/records/workbench.json, for docs/workbench-figures.md

Writes into a folder (target/workbench): workbench.json with all results, and tables.md. The exit status is 1 if a goal
is missed (bench/workbench/goals.py) that does not depend on time. Experiments: large and small (opening, camera, tool
and single frames, a picture of 1280x720 and of 640x360), parts (hiding and filtering 10,000), page (memory, contact,
stops, a cut, a lost context), engine (outlines, rays, one HTML file), soak (continuous motion of the tool). Of repeated
measurements the best counts.
"""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line
import host
import pages
from command_line import listed, one_of

from workbench import experiments, goals, stand, tables
from workbench.best import best

OUT = host.ROOT / "target" / "workbench"
RECORD = host.ROOT / "bench" / "records" / "workbench.json"
SIZE, BIG_SIZE, QUICK_SIZE = 1_600_000, 10_000_000, 100_000
REPEATS, SOAK_MINUTES, QUICK_SOAK_MINUTES = 3, 1.0, 0.1
MOVE_S, QUICK_MOVE_S = 4.0, 1.0
NAMES = ("large", "small", "parts", "page", "engine", "soak")

Result = dict[str, Any]


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("out", nargs="?", type=Path, default=OUT, help="folder of the results (target/workbench)")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SIZE:,} triangles, everything once")
    parser.add_argument("--only", type=listed(one_of("experiment", NAMES)), default=list(NAMES), help=", ".join(NAMES))
    parser.add_argument("--size", type=int, help=f"triangles of the sample engine ({SIZE:,})")
    parser.add_argument("--big", action="store_true", help=f"the engine at {BIG_SIZE:,} triangles, too, once")
    parser.add_argument("--repeats", type=int, help=f"of large, small and parts ({REPEATS})")
    parser.add_argument("--soak", type=float, metavar="MINUTES", help=f"how long the tool moves ({SOAK_MINUTES:g})")
    parser.add_argument("--core", type=int, help="for the page; default: the last one")
    parser.add_argument("--add", action="store_true", help="keep results of other mock-ups and experiments")
    parser.add_argument("--record", action="store_true", help="also write bench/records/workbench.json")
    options = parser.parse_args(arguments)
    options.size = options.size or (QUICK_SIZE if options.quick else SIZE)
    options.repeats = options.repeats or (1 if options.quick else REPEATS)
    options.soak = (QUICK_SOAK_MINUTES if options.quick else SOAK_MINUTES) if options.soak is None else options.soak
    options.core = host.last_core() if options.core is None else options.core
    return options


def run(options: argparse.Namespace, given: Sequence[str] = ()) -> Result:
    """Runs the chosen experiments; plain data. Raises `StandError` where there is no browser."""
    before = host.load_average()
    with stand.browser(options.core) as browser:
        version = f"Chromium {browser.version}"
        found = {_named(options.size): _measured(browser, options, options.size, options.repeats)}
        if options.big:
            found[_named(BIG_SIZE)] = _measured(browser, options, BIG_SIZE, 1, without=("parts", "soak"))
    return {
        "when": host.now(),
        **host.commit(),
        "args": [word for word in given if word not in (str(options.out), "--record", "--add")],
        "is_quick": options.quick,
        "machine": host.machine(),
        "versions": host.versions({}),
        "browser": version,
        "core": options.core,
        "load_average": before,
        "load_average_after": host.load_average(),
        "bundle": experiments.bundle(),
        "mockups": found,
    }


def _named(size: int) -> str:
    return f"engine, {size / 1e6:g}M"


def _measured(
    browser: Any, options: argparse.Namespace, size: int, repeats: int, without: Sequence[str] = ()
) -> dict[str, Result]:
    mockup = f"sample:engine:{size}"
    ways: dict[str, Callable[[], Result]] = {
        "large": lambda: best(experiments.pictures(browser, mockup, experiments.LARGE, repeats)),
        "small": lambda: best(experiments.pictures(browser, mockup, experiments.SMALL, repeats)),
        "parts": lambda: best(experiments.parts(browser, repeats)),
        "page": lambda: experiments.page(browser, mockup, QUICK_MOVE_S if options.quick else MOVE_S),
        "engine": lambda: experiments.engine(browser, mockup),
        "soak": lambda: experiments.soak(browser, mockup, 60 * options.soak),
    }
    found: dict[str, Result] = {}
    for name in options.only:
        if name in without:
            continue
        print(f"{_named(size)}: {name}", file=sys.stderr)
        try:
            found[name] = ways[name]()
        except Exception:  # one that stops must not take the others along, and is a finding
            found[name] = {"failed": traceback.format_exc()}
            print(found[name]["failed"], file=sys.stderr)
    return found


def added(before: Path, result: Result) -> Result:
    """Adds this run to the folder's results of other mock-ups and experiments; with the arguments of all runs."""
    if not before.is_file():
        return result
    old = json.loads(before.read_text(encoding="utf-8"))
    mockups = {name: dict(found) for name, found in old["mockups"].items()}
    for mockup, found in result["mockups"].items():
        mockups.setdefault(mockup, {}).update(found)
    parts = [*old["args"], "and", *result["args"]]
    return {**result, "mockups": mockups, "args": parts, "is_quick": result["is_quick"] or old["is_quick"]}


def write(result: Result, folder: Path) -> list[Path]:
    """workbench.json and tables.md."""
    return pages.written(result, folder, "workbench", f"# The workbench\n\n{tables.page(result)}\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write, judge."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = parse(given)
    try:
        result = run(options, given)
    except stand.StandError as error:
        print(error, file=sys.stderr)
        return 2
    if options.add:
        result = added(options.out / "workbench.json", result)
    for path in write(result, options.out):
        print(f"Written: {path}")
    if options.record:
        pages.recorded(result, RECORD)
        print(f"Written: {RECORD}")
    return pages.judged(goals.scorecard(result))


if __name__ == "__main__":
    sys.exit(main())
