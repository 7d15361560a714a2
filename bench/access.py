"""How many fasteners of the samples are recognised, and how long an access check takes.

    python bench/access.py                        print the tables
    python bench/access.py --write                and put them into docs/access.md, between its markers
    python bench/access.py --quick                small samples

A result is right if its frame is on the top of the head (within 0.12 thread diameters) and points out of the joint
(within a degree); the samples have the true frames. A second column shows the same without names.
"""

from __future__ import annotations

import argparse
import platform
import time
from pathlib import Path

from fastener_truth import sample_and_truth, scores, without_names
from host import machine

import feeler
from feeler.arguments import check_word
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.types import GripAxis, SampleToolName

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "access.md"
FOUND = ("<!-- found: bench/access.py -->", "<!-- end of found -->")
TIMES = ("<!-- times: bench/access.py -->", "<!-- end of times -->")

SAMPLES = [
    *(("engine", count) for count in (10_000, 30_000, 100_000, 1_600_000)),
    *(("carcass", count) for count in (10_000, 100_000)),
    *(("differential", count) for count in (20_000, 300_000)),
    *(("turbine", count) for count in (20_000, 200_000)),
    *(("externals", count) for count in (20_000, 500_000)),
    *(("tay", count) for count in (30_000, 1_000_000)),
]
QUICK_SAMPLES = [("engine", 30_000), ("differential", 20_000)]
TARGETS, ANGLES = 200, 72
ASKED: list[tuple[str, SampleToolName, GripAxis, float]] = [
    ("wrench, at the head", "wrench", "y", 0.0),
    ("wrench, 40 mm above", "wrench", "y", 0.04),
    ("wrench, in free space", "wrench", "y", 5.0),
    ("torque, at the head", "torque", "z", 0.0),
    ("hand, at the head", "hand", "z", 0.0),
]
"""The checks: tool, grip, lift in metres. In free space each cast goes all the way, which costs most."""


def found_table(samples: list[tuple[str, int]]) -> str:
    """Recall and precision on samples, and how long it takes on one core."""
    lines = [
        "| sample | triangles | fasteners | recall | precision | recall, no names | precision, no names | s |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, triangles in samples:
        mockup, truth = sample_and_truth(name, triangles)
        start = time.perf_counter()
        found = feeler.find_fasteners(feeler.Scene(mockup, threads=1))
        seconds = time.perf_counter() - start
        named = scores(found, truth, mockup.part_paths)
        plain = scores(feeler.find_fasteners(without_names(mockup)), truth, mockup.part_paths)
        shares = " | ".join(f"{100 * share:.1f} %" for share in (*named, *plain))
        lines.append(f"| {name} | {mockup.triangle_count:,} | {len(truth):,} | {shares} | {seconds:.2f} |")
    return "\n".join(
        [
            *lines,
            "",
            f"`python bench/access.py --write`, Python {platform.python_version()}; one core, the index included.",
        ]
    )


def times_table(triangles: int, rounds: int) -> str:
    """How long `access` takes on one core."""
    mockup = feeler.sample("engine", triangles)
    scene = feeler.Scene(mockup, threads=1)
    bolts = feeler.find_fasteners(scene).where("*bolt*")
    targets = bolts[:: max(1, len(bolts) // TARGETS)][:TARGETS]
    lines = ["| tool | with a free seat | reachable | s |", "|---|---:|---:|---:|"]
    for what, name, grip, lift in ASKED:
        tool = feeler.sample_tool(check_word("name", name, SAMPLE_TOOL_NAMES))
        seconds = []
        for _ in range(rounds):
            start = time.perf_counter()
            found = feeler.access(scene, tool, targets, angles=ANGLES, grip=grip, lift=lift, threads=1)
            seconds.append(time.perf_counter() - start)
        seats = int((found.swings_deg > 0).sum())
        lines.append(f"| {what} | {seats} | {int(found.is_reachable.sum())} | {min(seconds):.2f} |")
    note = (
        f"{len(targets)} bolts of `engine` with {mockup.triangle_count:,} triangles, {ANGLES} angles each, one core of "
        f"{machine()['cpu']}, best of {rounds}."
    )
    return "\n".join([*lines, "", note])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/access.md")
    parser.add_argument("--quick", action="store_true", help="small samples")
    options = parser.parse_args()
    text = PAGE.read_text(encoding="utf-8")
    blocks = [
        (FOUND, found_table(QUICK_SAMPLES if options.quick else SAMPLES)),
        (TIMES, times_table(100_000 if options.quick else 1_600_000, 1 if options.quick else 3)),
    ]
    for (begin, end), table in blocks:
        print(table, end="\n\n")
        head, rest = text.split(begin, 1)
        text = f"{head}{begin}\n{table}\n{end}{rest.split(end, 1)[1]}"
    if options.write:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
