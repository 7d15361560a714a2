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
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from command_line import listed, one_of, positive
from section import Form, Result, attempted, measured

from feel import felt, scenes
from feel.experiments import energy, engine, fitting, passing, tessellation, tight
from feel.tables import SECTION
from feeler.progress import bar

RUNS, MOST_BASELINE_RUNS = Form(10_000, 45), 450
SEEDS, BASELINE_SEEDS = Form(20, 2), 2
SIZE, BIG_SIZE = Form(1_600_000, 100_000), 11_000_000
FIT_STEPS = Form(tight.STEPS, 300)
STEPS = Form(None, 1500)  # of the way in the engine; None: all of it
SIDES = Form((48, 96, 384), (96,))
CELLS = Form(scenes.CELLS, scenes.QUICK_CELLS)
PEGS = Form(("H11/c11", "H7/g6"), ("H11/c11",))


def parse(given: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = SECTION.parser(__doc__, "the short form of each experiment")
    add, names = parser.add_argument, list(felt.makers())
    faces = listed(one_of("face", names))
    add("--faces", type=faces, default=names, help=f"faces to measure ({','.join(names)})")
    add("--runs", type=positive, default=RUNS, help=f"at thin things ({RUNS}; baselines {MOST_BASELINE_RUNS})")
    add("--seeds", type=positive, default=SEEDS, help=f"hands for each peg ({SEEDS}; baselines {BASELINE_SEEDS})")
    add("--big", action="store_true", help=f"the engine at {BIG_SIZE:,} triangles, too")
    add("--seed", type=int, default=0, help="of the runs at thin things (0)")
    add("--jobs", type=positive, default=1, help="processes for the runs at thin things (1)")
    return SECTION.options(parser, given)


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
    return tessellation.forces(felt.makers()[face], CELLS.of(options))


def _sliding(face: str, options: argparse.Namespace) -> Result:
    return tessellation.sliding(felt.makers()[face], SIDES.of(options), unshaded=felt.unshaded(face))


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
    return fitting.pegs(felt.makers()[face], seeds, PEGS.of(options))


def _ways(face: str, options: argparse.Namespace) -> Result:
    # the baselines have no part of so large an engine: a grid of its own size would not fit
    return fitting.ways(felt.makers()[face], SIZE.long if face == "feeler" and not options.quick else None)


def _engine(face: str, options: argparse.Namespace) -> Result | None:
    if face != "feeler":
        return None
    sizes = [SIZE.of(options), *([BIG_SIZE] if options.big and not options.quick else [])]
    found = [engine.run(felt.makers()[face], size, STEPS.of(options), seed=options.seed) for size in sizes]
    return {"rows": [row for one in found for row in one["rows"]], "sample": "engine"}


def _fits(face: str, options: argparse.Namespace) -> Result | None:
    if face != "feeler":
        return None
    return tight.run(felt.makers()[face], FIT_STEPS.of(options))


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


def run(options: argparse.Namespace) -> Result:
    """Runs the chosen experiments; plain data."""

    def faces() -> Result:
        ways = {name: EXPERIMENTS[name] for name in options.only}
        return {
            face: attempted(face, {name: partial(way, face, options) for name, way in ways.items()})
            for face in options.faces
        }

    return measured(lambda: {"faces": faces()}, options)


main = partial(SECTION.main, parse, run)

if __name__ == "__main__":
    sys.exit(main())
