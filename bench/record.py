"""The record of the bench: one CSV per kind of machine and release, a row per cell and engine (bench/README.md).

`read` and `keep` are the only reader and writer. A run replaces the rows that it measured and keeps the others, so each
row has its own commit and date.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import host
from host import ROOT

RECORDS = ROOT / "bench" / "records"
SCRATCH = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "bench" / "records"

GROUP = ("what", "size", "tool", "kind", "query")  # what one run measures as a whole: for all engines, or not at all
ORIGIN = ("machine", "cores", "date", "commit")
STAGES = (
    *("voxels_visited", "clusters_placed", "pieces_scanned", "entries_scanned", "box_survivors"),
    *("repeats_skipped", "triangle_tests", "exact_tests", "pairs_mean"),
)
NUMBERS = (
    *("triangles", "parts", "tool_triangles", "poses", "rounds", "pairs"),
    *("median_us", "p95_us", "p99_us", "worst_us", "times_faster", "times_faster_p95"),
    *("agreed", "peer_wrong", "feeler_wrong", "unjudged"),
    *STAGES,
    *("one_core_s", "all_cores_s", "bytes", "growth_bytes", "peak_bytes"),
    *("calls_per_s", "batch_1_per_s", "batch_2_per_s", "apart_2_per_s", "cores_had", "over_core_us", "times_slower"),
    *("again_us", "pair_ns", "again_pair_ns", "lines", "memory_us", "lanes_us", "limit_us"),
)
COLUMNS = (*GROUP, "engine", "version", *ORIGIN, *NUMBERS)
WHOLE = {"size", "cores", "triangles", "parts", "tool_triangles", "poses", "rounds", "bytes", "growth_bytes"}
WHOLE |= {"peak_bytes", "agreed", "peer_wrong", "feeler_wrong", "unjudged"}

# The order of rows in a file; rows not named here come after, by name.
ORDER: dict[str, tuple[str, ...]] = {
    "what": ("cell", "build", "fine", "worst", "batch", "call", "growth", "limit", "level"),
    "tool": ("torque", "wrench", "square", "hand", "hand-fine"),
    "kind": ("nominal", "near", "deep"),
    "query": ("collide", "is_colliding", "distance", "cast", "contacts"),
    "engine": ("feeler", "coal", "fcl", "embree", "parry", "feeler-avx512", "feeler-avx2", "feeler-neon"),
}

Row = dict[str, Any]  # by column; None or no entry where a column says nothing


class RecordError(Exception):
    """A file that is no record; the message says why."""


def elsewhere(reasons: Sequence[str]) -> str:
    """The note on a run that does not go into bench/records."""
    return f"This run does not go into bench/records: {'; '.join(reasons)}."


@dataclass(frozen=True)
class Origin:
    """The machine and the commit that a run measures, found at its start."""

    machine: str
    cores: int
    date: str
    commit: str
    release: str
    changed: bool  # the working tree differs from the commit in measured files
    profile: str | None

    @classmethod
    def here(cls, release: str) -> Origin:
        """Of this machine and this working tree."""
        about, machine = host.commit(), host.machine()
        return cls(
            machine=host.name(machine["cpu"], machine["flags"]),
            cores=os.cpu_count() or 1,
            date=host.now()[:10],
            commit=(about["commit"] or "")[:9],
            release=release,
            changed=bool(about["dirty"]),
            profile=host.build_profile(),
        )

    def path(self, folder: Path) -> Path:
        """The file of this kind of machine and release."""
        return folder / f"{re.sub(r'[^a-z0-9]+', '-', self.machine.lower()).strip('-')}-{self.release}.csv"

    def marked(self, rows: Iterable[Row]) -> list[Row]:
        """The rows with all columns and their origin."""
        about = {"machine": self.machine, "cores": self.cores, "date": self.date, "commit": self.commit}
        return [dict.fromkeys(COLUMNS) | about | row for row in rows]

    def reasons_against(self, engines: Iterable[str] | None = None) -> list[str]:
        """Why rows of a run may not go into bench/records; of cells, of a run with these engines. None: they may."""
        reasons = [] if self.commit else ["it is not known which commit is measured"]
        reasons += ["the working tree has changes that are not committed"] if self.changed else []
        reasons += [f"the extension was compiled with the profile {self.profile}"] if self.profile == "dev" else []
        if engines is None:
            return reasons
        path = self.path(RECORDS)
        known = {row["engine"] for row in read(path) if row["what"] == "cell"} if path.exists() else set()
        # Ratios are of one run: a cell is measured with all engines that the record has, or stays as it is.
        if missing := sorted(known - set(engines)):
            reasons.append(f"the record has rows of {', '.join(missing)}, which this run leaves out")
        return reasons


def keep(rows: Iterable[Row], origin: Origin, out: Path | None = None, reasons: Sequence[str] = ()) -> Path:
    """Put rows into the CSV of this machine and release, in place of those of the same groups; return its path.

    It lies in `out`, else in bench/records, but in target/bench/records where there are reasons against.
    """
    path = origin.path(out or (SCRATCH if reasons else RECORDS))
    new = origin.marked(rows)
    groups = {_group(row) for row in new}
    old = [row for row in read(path) if _group(row) not in groups] if path.exists() else []
    path.parent.mkdir(parents=True, exist_ok=True)
    written = path.with_suffix(".new")  # so that a run that is stopped here leaves the record whole
    with written.open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(COLUMNS)
        lines.writerows([_said(row.get(name)) for name in COLUMNS] for row in sorted([*old, *new], key=_place))
    written.replace(path)
    return path


def read(path: Path) -> list[Row]:
    """The rows of a CSV; `RecordError` if it is none of ours."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = csv.DictReader(file)
            if tuple(lines.fieldnames or ()) != COLUMNS:
                raise RecordError(f"{path} has other columns than a record of bench/record.py")
            rows = [{name: _value(name, text) for name, text in line.items()} for line in lines]
        if any(tuple(row) != COLUMNS for row in rows):
            raise ValueError("a line has too many fields")
        return rows
    except (OSError, ValueError) as error:
        raise RecordError(f"{path} is no record: {error}") from error


def newest(folder: Path = RECORDS) -> list[list[Row]]:
    """The record of the newest release of each kind of machine; first the one that was last measured as a whole."""
    best: dict[str, tuple[tuple[int, ...], list[Row]]] = {}
    for path in sorted(folder.glob("*.csv")):
        rows = read(path)
        release = tuple(int(part) for part in re.findall(r"\d+", path.stem.rpartition("-")[2]))
        if rows and (rows[0]["machine"] not in best or best[rows[0]["machine"]][0] < release):
            best[rows[0]["machine"]] = release, rows
    records = [rows for _, rows in best.values()]
    return sorted(records, key=lambda rows: min(row["date"] for row in rows if row["what"] == "cell"), reverse=True)


def _group(row: Row) -> tuple[str, ...]:
    return tuple(str(row.get(name) or "") for name in GROUP)


def _place(row: Row) -> tuple[tuple[int, str], ...]:
    """Where a row stands in its file."""
    place = []
    for name in ("what", "size", "tool", "kind", "query", "engine"):
        value, order = row.get(name) or "", ORDER.get(name, ())
        place.append((int(value or 0), "") if name == "size" else (_rank(value, order), str(value)))
    return tuple(place)


def _rank(value: str, order: Sequence[str]) -> int:
    return order.index(value) if value in order else len(order)


def _said(value: Any) -> str:
    """A number with five significant digits, never with an exponent; nothing for None."""
    if value is None:
        return ""
    if isinstance(value, float):
        return "0" if value == 0 else f"{float(f'{value:.5g}'):.12f}".rstrip("0").rstrip(".")
    return str(value)


def _value(name: str, text: str | None) -> Any:
    if text is None:
        raise ValueError("a line has too few fields")
    if text == "":
        return None
    if name in WHOLE:
        return int(text)
    return float(text) if name in NUMBERS else text
