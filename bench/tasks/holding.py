"""What `feeler.holds` says of the samples, beside a rule that shares no code with it (`held_truth.py`).

    python bench/tasks/holding.py                 print the table
    python bench/tasks/holding.py --write         and put it into docs/task.md, between its markers
    python bench/tasks/holding.py --quick         two small samples

A pair is a fastener and a part that it holds. The sample gearbox knows its pairs itself. The exit status is 1 if recall
or precision of a sample is below 98 %.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from fastener_truth import sample_and_truth

import feeler
from tasks.held_truth import Rule

PAGE = Path(__file__).resolve().parents[2] / "docs" / "task.md"
MARKS = ("<!-- held: bench/tasks/holding.py -->", "<!-- end of held -->")
SAMPLES = [
    *(("carcass", 400_000), ("differential", 300_000), ("turbine", 400_000), ("externals", 400_000)),
    *(("engine", 400_000), ("tay", 400_000), ("gearbox", 100_000), ("gearbox", 400_000)),
]
QUICK = [("differential", 300_000), ("gearbox", 100_000)]
LEAST = 0.98


@dataclass(frozen=True)
class Score:
    """Of one sample."""

    name: str
    triangles: int
    fasteners: int
    unclear: int
    pairs: int
    """What the fasteners hold."""
    right: int
    wrong: int
    seconds: float

    @property
    def recall(self) -> float:
        """The share of the pairs that is found."""
        return self.right / self.pairs

    @property
    def precision(self) -> float:
        """The share of the found pairs that is right."""
        return self.right / max(self.right + self.wrong, 1)


def score(name: str, triangles: int) -> Score:
    """Of a sample."""
    if name == "gearbox":
        mockup = feeler.sample("gearbox", triangles)
        numbers = {path: part for part, path in enumerate(mockup.part_paths)}
        facts = feeler.sample_truth("gearbox", triangles).fasteners
        want = {numbers[row.path]: {numbers[path] for path in row.holds} for row in facts}
        unclear: set[int] = set()
    else:
        mockup, truth = sample_and_truth(name, triangles)
        rule = Rule(mockup, truth)
        want, unclear = rule.held(), rule.unclear
    begin = time.perf_counter()
    rows = feeler.holds(feeler.Scene(mockup, threads=1))
    seconds = time.perf_counter() - begin
    # A washer comes loose with its fastener, and is held where nothing else is.
    found = {row.fastener: _held(row) for row in rows}
    right = wrong = pairs = 0
    for part, held in want.items():
        if part not in unclear:
            said = found.get(part, set())
            right, wrong, pairs = right + len(held & said), wrong + len(said - held), pairs + len(held)
    return Score(name, triangles, len(want), len(unclear), pairs, right, wrong, seconds)


def _held(row: feeler.Hold) -> set[int]:
    """What a fastener holds; its washers where it holds nothing else."""
    return (set(row.parts) - ({row.fastener} if row.washers else set())) or set(row.washers)


def table(rows: list[Score]) -> str:
    """In Markdown."""
    lines = [
        "| sample | triangles | fasteners | left out | pairs | recall | precision | s |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        lines.append(
            f"| {row.name} | {row.triangles:,} | {row.fasteners:,} | {row.unclear:,} | {row.pairs:,} "
            f"| {100 * row.recall:.1f} % | {100 * row.precision:.1f} % | {row.seconds:.1f} |"
        )
    return "\n".join(lines)


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description="What feeler.holds says of the samples, beside a rule of its own.")
    parser.add_argument("--write", action="store_true", help="put the table into docs/task.md")
    parser.add_argument("--quick", action="store_true", help="two small samples")
    options = parser.parse_args()
    rows = []
    for name, triangles in QUICK if options.quick else SAMPLES:
        rows.append(score(name, triangles))
        print(table(rows[-1:]).splitlines()[-1], flush=True)
    print(table(rows))
    if options.write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        PAGE.write_text(f"{before}{MARKS[0]}\n{table(rows)}\n{MARKS[1]}{after}", encoding="utf-8")
    return int(any(min(row.recall, row.precision) < LEAST for row in rows))


if __name__ == "__main__":
    sys.exit(main())
