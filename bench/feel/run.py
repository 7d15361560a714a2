"""The acceptance of haptics without hardware: experiments, tables, plots.

    python bench/feel/run.py                         the long form: 10,000 runs at thin things; an hour or so
    python bench/feel/run.py --quick                 the short form, minutes
    python bench/feel/run.py --only passing --runs 500 --faces feeler,penalty
    python bench/feel/run.py --only engine --big     also at 11 million triangles
    python bench/feel/run.py --record                and into bench/records/feel.json, for docs/haptics-figures.md

Writes into a folder (target/feel): feel.json with all results, tables.md, and plots if matplotlib is installed. All
results but the times in the engine and in fits are computed on simulated time: the same arguments give the same numbers
on any machine. The exit status is 1 if a goal is missed (bench/feel/goals.py) that does not depend on time. --faces
selects the baselines.
"""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line
import host
import pages
from command_line import listed, one_of

from feel import felt, goals, plots, scenes, tables
from feel.experiments import energy, engine, fitting, passing, tessellation, tight
from feeler.progress import bar

OUT = host.ROOT / "target" / "feel"
RECORD = host.ROOT / "bench" / "records" / "feel.json"
RUNS, QUICK_RUNS, MOST_BASELINE_RUNS = 10_000, 45, 450
SEEDS, QUICK_SEEDS, BASELINE_SEEDS = 20, 2, 2
SIZE, BIG_SIZE, QUICK_SIZE = 1_600_000, 11_000_000, 100_000
QUICK_FIT_STEPS = 300
QUICK_STEPS = 1500  # of the way in the engine; the long form goes all of it
SIDES, QUICK_SIDES = (48, 96, 384), (96,)

Result = dict[str, Any]


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("out", nargs="?", type=Path, default=OUT, help="folder of the results (target/feel)")
    parser.add_argument("--quick", action="store_true", help="the short form of each experiment")
    names = list(EXPERIMENTS)
    parser.add_argument("--only", type=listed(one_of("experiment", names)), default=names, help=", ".join(names))
    names = list(felt.makers())
    parser.add_argument(
        "--faces", type=listed(one_of("face", names)), default=names, help=f"faces to measure ({','.join(names)})"
    )
    parser.add_argument(
        "--runs", type=int, help=f"at thin things ({RUNS:,}; of a baseline at most {MOST_BASELINE_RUNS})"
    )
    parser.add_argument(
        "--seeds", type=int, help=f"hands for each peg ({SEEDS}; of a baseline at most {BASELINE_SEEDS})"
    )
    parser.add_argument("--big", action="store_true", help=f"the engine at {BIG_SIZE:,} triangles, too")
    parser.add_argument("--seed", type=int, default=0, help="of the runs at thin things (0)")
    parser.add_argument("--jobs", type=int, default=1, help="processes for the runs at thin things (1)")
    parser.add_argument("--add", action="store_true", help="keep results of other faces and experiments")
    parser.add_argument("--record", action="store_true", help="also write bench/records/feel.json")
    options = parser.parse_args(arguments)
    options.runs = options.runs or (QUICK_RUNS if options.quick else RUNS)
    options.seeds = options.seeds or (QUICK_SEEDS if options.quick else SEEDS)
    return options


def _passing(face: str, options: argparse.Namespace) -> Result:
    runs = options.runs if face == "feeler" else min(options.runs, MOST_BASELINE_RUNS)
    with bar(f"{face}: runs at thin things") as progress:
        found = []
        for result in _throws(face, runs, options.seed, options.jobs):
            found.append(result)
            progress(len(found) / runs, f"{len(found):,} of {runs:,}")
    return passing.summary(found, options.seed)


def _throws(face: str, runs: int, seed: int, jobs: int) -> Iterator[Result]:
    asked = [(face, index, seed) for index in range(runs)]
    if jobs <= 1:
        yield from map(_throw, asked)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(_throw, asked, chunksize=8)


def _throw(asked: tuple[str, int, int]) -> Result:
    face, index, seed = asked
    return passing.one(felt.makers()[face], index, seed)


def _forces(face: str, options: argparse.Namespace) -> Result:
    return tessellation.forces(felt.makers()[face], scenes.QUICK_CELLS if options.quick else scenes.CELLS)


def _sliding(face: str, options: argparse.Namespace) -> Result:
    sides = QUICK_SIDES if options.quick else SIDES
    return tessellation.sliding(felt.makers()[face], sides, unshaded=felt.unshaded(face))


def _closed(face: str, options: argparse.Namespace) -> Result:
    del options
    return energy.closed(felt.makers()[face])


def _step_response(face: str, options: argparse.Namespace) -> Result:
    del options
    return energy.step_response(felt.makers()[face], lambda stiffness: felt.stiffened(face, stiffness))


def _release(face: str, options: argparse.Namespace) -> Result:
    del options
    return energy.release(felt.makers()[face])


def _pegs(face: str, options: argparse.Namespace) -> Result:
    seeds = options.seeds if face == "feeler" else min(options.seeds, BASELINE_SEEDS)
    names = ("H11/c11",) if options.quick else ("H11/c11", "H7/g6")
    return fitting.pegs(felt.makers()[face], seeds, names)


def _ways(face: str, options: argparse.Namespace) -> Result:
    # the baselines have no part of so large an engine: a grid of its own size would not fit
    return fitting.ways(felt.makers()[face], SIZE if face == "feeler" and not options.quick else None)


def _engine(face: str, options: argparse.Namespace) -> Result | None:
    if face != "feeler":
        return None
    sizes = [QUICK_SIZE] if options.quick else [SIZE, *([BIG_SIZE] if options.big else [])]
    steps = QUICK_STEPS if options.quick else None
    found = [engine.run(felt.makers()[face], size, steps, seed=options.seed) for size in sizes]
    return {"rows": [row for one in found for row in one["rows"]], "sample": "engine"}


def _fits(face: str, options: argparse.Namespace) -> Result | None:
    if face != "feeler":
        return None
    return tight.run(felt.makers()[face], QUICK_FIT_STEPS if options.quick else tight.STEPS)


EXPERIMENTS: dict[str, Callable[[str, argparse.Namespace], Result | None]] = {
    "passing": _passing,
    "forces": _forces,
    "sliding": _sliding,
    "closed": _closed,
    "step_response": _step_response,
    "release": _release,
    "pegs": _pegs,
    "ways": _ways,
    "engine": _engine,
    "fits": _fits,
}


def run(options: argparse.Namespace, given: Sequence[str] = ()) -> Result:
    """Runs the chosen experiments; plain data."""
    found: dict[str, Result] = {}
    for face in options.faces:
        found[face] = {}
        for name in options.only:
            print(f"{face}: {name}", file=sys.stderr)
            try:
                result = EXPERIMENTS[name](face, options)
            except Exception:  # one that stops must not take the others along, and is a finding
                result = {"failed": traceback.format_exc()}
                print(result["failed"], file=sys.stderr)
            if result is not None:
                found[face][name] = result
    return {
        "when": host.now(),
        **host.commit(),
        "args": [word for word in given if word not in (str(options.out), "--record", "--add")],
        "is_quick": options.quick,
        "machine": host.machine(),
        "versions": host.versions({}),
        "faces": found,
    }


def added(before: Path, result: Result) -> Result:
    """Adds this run to the folder's results of other faces and experiments; with the arguments of all runs."""
    if not before.is_file():
        return result
    old = json.loads(before.read_text(encoding="utf-8"))
    faces = {name: dict(found) for name, found in old["faces"].items()}
    for face, found in result["faces"].items():
        faces.setdefault(face, {}).update(found)
    parts = [*old["args"], "and", *result["args"]]
    return {**result, "faces": faces, "args": parts, "is_quick": result["is_quick"] or old["is_quick"]}


def write(result: Result, folder: Path) -> list[Path]:
    """feel.json, tables.md and the plots."""
    made = [f"## {name.replace('_', ' ').capitalize()}\n\n{table}\n" for name, table in tables.tables(result).items()]
    paths = pages.written(result, folder, "feel", "# Feel\n\n" + "\n".join(made))
    return [*paths, *plots.plots(result, folder)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write, judge."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = parse(given)
    result = run(options, given)
    if options.add:
        result = added(options.out / "feel.json", result)
    for path in write(result, options.out):
        print(f"Written: {path}")
    if options.record:
        pages.recorded(result, RECORD)
        print(f"Written: {RECORD}")
    return pages.judged(goals.scorecard(result["faces"].get("feeler", {})))


if __name__ == "__main__":
    sys.exit(main())
