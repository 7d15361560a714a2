"""Plans of random assemblies of at most 9 parts against exhaustive search over all states.

    python bench/tasks/run.py              300 assemblies; some minutes
    python bench/tasks/run.py 40 --first 1000

Prints each plan that is slower or wrong, and a summary. The exit status is 1 if a plan is wrong or below its bound, if
a bound is above the quickest plan, or if fewer than 95 % are as quick.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import command_line

import feeler
from tasks.assemblies import Assembly, random_assembly, tools
from tasks.judge import Judge

QUICK_SHARE = 0.95
SLACK_S = 1e-6


@dataclass
class Answer:
    """Of one assembly."""

    made: Assembly
    least: float | None
    task: feeler.Task
    faults: list[str]
    seconds: float
    pair: feeler.Task
    """The plan for two people."""
    soonest: float | None
    """Seconds of the quickest one."""

    @property
    def is_quick(self) -> bool:
        """Whether the plan is as quick as any, or there is none."""
        if self.least is None:
            return not self.task.is_found
        return self.task.is_found and self.task.seconds <= self.least + SLACK_S

    @property
    def is_bounded(self) -> bool:
        """Whether its bounds are, for one person and for two."""
        rows = ((self.least, self.task), (self.soonest, self.pair))
        return all(least is None or not task.is_found or task.bound <= least + SLACK_S for least, task in rows)


def answer(seed: int, threads: int = 1) -> Answer:
    """Of the assembly of a number."""
    made, table, kit = random_assembly(seed), feeler.Times(), tools()
    judge = Judge(made, kit, table)
    least = judge.least()
    begin = time.perf_counter()
    scene = feeler.Scene(made.mockup(), threads=threads)
    task = feeler.task(scene, made.wanted, kit, table, sorted(made.keep), threads=threads)
    spent = time.perf_counter() - begin
    pair = feeler.task(scene, made.wanted, kit, table, sorted(made.keep), 2, threads=threads)
    return Answer(made, least, task, judge.faults(task), spent, pair, judge.soonest(2))


def main() -> int:
    """Asks, judges, prints."""
    parser = command_line.parser(__doc__ or "")
    parser.add_argument("count", nargs="?", type=int, default=300, help="assemblies (300)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    options = parser.parse_args()
    answers = []
    for seed in range(options.first, options.first + options.count):
        one = answer(seed)
        answers.append(one)
        if one.faults or not (one.is_quick and one.is_bounded) or options.count == 1:
            names = [part.name for part in one.made.parts]
            kept = [names[part] for part in sorted(one.made.keep)]
            print(f"{seed}: {names[one.made.wanted]} of {names}, kept {kept}")
            print(f"    at best {one.least}, {one.task}: {[str(step) for step in one.task.steps]}; {one.faults}")
            print(f"    {one.task.seconds} >= {one.task.bound}; {one.task.blocked}")
            print(f"    two people: at best {one.soonest}, {one.pair.seconds} >= {one.pair.bound}", flush=True)
    possible = [one for one in answers if one.least is not None]
    found = [one for one in possible if one.task.is_found]
    quick = sum(one.is_quick for one in answers)
    tight = sum(one.task.seconds - one.task.bound < SLACK_S for one in found)
    times = [one.seconds for one in answers]
    print(f"{len(answers)} assemblies, {len(possible)} come apart, {len(found)} plans found, {quick} as quick as any")
    print(f"{sum(not one.is_bounded for one in answers)} bounds too high, {tight} plans equal to their bound")
    early = sum(one.pair.seconds <= one.soonest + SLACK_S for one in found if one.soonest is not None)
    print(f"two people: {early} as early as any")
    faulty = sum(bool(one.faults) for one in answers)
    print(f"{faulty} with faults; median {np.median(times):.2f} s, worst {max(times):.2f} s")
    is_bad = any(one.faults or not one.is_bounded for one in answers)
    return int(is_bad or quick < QUICK_SHARE * len(answers))


if __name__ == "__main__":
    sys.exit(main())
