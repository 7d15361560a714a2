"""Puts the figures of a benchmark record into README.md, between its markers.

examples:
    python bench/readme.py                                    the newest record in bench/records
    python bench/readme.py bench/records/2026-11-20-x-1.json  a given one
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

from goals import MEASURES, geometric_mean

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
RECORDS = ROOT / "bench" / "records"
MARKERS = ("<!-- figures: bench/readme.py -->", "<!-- end of figures -->")


def by_age() -> list[Path]:
    """All records, by when they were made; without those with a remark `disturbed`, which says how that was seen."""
    records = {path: json.loads(path.read_text(encoding="utf-8")) for path in RECORDS.glob("*.json")}
    return sorted((p for p, record in records.items() if "disturbed" not in record), key=lambda p: records[p]["when"])


def newest() -> Path:
    """The last record."""
    records = by_age()
    if not records:
        sys.exit("bench/records holds no record: run `make bench` first")
    return records[-1]


def read(path: Path | str) -> tuple[dict[str, Any], str]:
    """A record and its file's name, for the command line: `ArgumentTypeError` where a file is none, or too old."""
    try:
        record = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"{path} is no record: {error}") from error
    if not isinstance(record, dict) or "schema" not in record:
        raise argparse.ArgumentTypeError(f"{path} is no record of `make bench`")
    if record["schema"] < 2:
        raise argparse.ArgumentTypeError(f"{path} is of an older layout: run `make bench` again")
    return record, Path(path).name


# The first of these that a CPU has. One name may stand for several generations, which only such flags tell apart.
LANES = {"avx512_vp2intersect": "AVX-512 with VP2INTERSECT", "avx512f": "AVX-512", "avx2": "AVX2"}


def kind(record: dict[str, Any]) -> str:
    """What sets a machine apart: its CPU, and the best lanes it has."""
    about = record["machine"]
    lanes = next((name for flag, name in LANES.items() if flag in about["flags"]), "neither AVX2 nor AVX-512")
    return f"{re.sub(r'[(]R[)]| Processor', '', about['cpu'])}, {lanes}"


NAMES = {"coal": "Coal", "fcl": "FCL", "embree": "Embree", "parry": "parry3d"}
SHOWN = 1_600_000  # triangles asked; without such a mock-up, the largest


def figures(record: dict[str, Any], name: str) -> str:
    """The table of one mock-up, and what it was measured with."""
    size = next((size for size in record["sizes"] if size["triangles_asked"] == SHOWN), record["sizes"][-1])
    cells = [c for c in record["cells"] if c["triangles_asked"] == size["triangles_asked"] and "engines" in c]
    peers = [peer for peer in record["engines"] if peer != "feeler"]
    asked = [cell for cell in cells if cell["query"] == "collide"]
    counts = [own.get("rounds", cell["rounds"]) for cell in asked for own in cell["engines"].values()]
    least, most = min(counts), max(counts)
    rounds = f"{least}" if least == most else f"{least} to {most}"
    poses = max(cell["poses"] for cell in cells)
    lines = [
        f"The sample `engine` with {size['triangles']:,} triangles in {size['parts']:,} parts; all colliding pairs",
        f"of a pose, one core, microseconds, median (p95) over {poses} poses, each the best of {rounds} rounds:",
        "",
        f"| tool | triangles | pose | pairs | feeler |{' best of the others | times faster |' if peers else ''}",
        f"|---|---:|---|---:|---:|{'---:|---:|' if peers else ''}",
    ]
    for cell in cells:
        if cell["query"] != "collide":
            continue
        row = [cell["tool"], f"{cell['tool_triangles']:,}", cell["kind"], f"{cell['pairs']['median']:,.0f}"]
        row.append(_times(cell["engines"]["feeler"]))
        if cell["best"]:
            best = [cell["best"][measure] for measure in MEASURES]
            row.append(f"{NAMES[best[0]['peer']]} {_times(cell['engines'][best[0]['peer']])}")
            row.append(f"{best[0]['times_faster']:.1f} ({best[1]['times_faster']:.1f})")
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join([*lines, "", *_notes(record, size, cells, peers, name)])


def _notes(
    record: dict[str, Any], size: dict[str, Any], cells: list[dict[str, Any]], peers: list[str], name: str
) -> list[str]:
    """What follows the table."""
    builds = {build["engine"]: build for build in size["builds"]}
    ours, cores = builds["feeler"], record["machine"]["cores"]
    built = [
        f"Index built in {ours['all_cores_s']:.2f} s on {cores} cores ({ours['one_core_s']:.2f} s on one), "
        f"{ours['bytes_per_triangle']:.0f} bytes a triangle with the triangles themselves"
    ]
    for peer in peers:
        each = builds[peer]["bytes_per_triangle"]
        each = f" and {each:.0f} bytes" if each else ""
        built.append(f"{NAMES[peer]} {builds[peer]['one_core_s']:.1f} s{each}")
    lines = ["; ".join(built) + "."]
    any_contact = [cell["best"] for cell in cells if cell["query"] == "is_colliding" and cell["best"]]
    if any_contact:
        means = [geometric_mean(best[measure]["times_faster"] for best in any_contact) for measure in MEASURES]
        lines.append(
            f"`is_colliding`: {means[0]:.1f} ({means[1]:.1f}) times faster than the best of the others, geometric mean."
        )
    lines.append(
        "Nominal: 1 to 5 % of the tool's triangles collide; near: among the parts, nothing collides; deep: more."
    )
    if peers:
        versions = ", ".join(f"{NAMES[peer]} {record['versions'][peer]}" for peer in peers)
        lines.append(
            f"The others: {versions}, each set up for speed, same poses, same run, the best in each row by its median "
            "(p95 ratio: the best by p95)."
        )
    lines.append(
        f"{kind(record)}, `make bench`, [{name}](bench/records/{name}); other machines: "
        "[docs/performance.md](docs/performance.md#where-the-goals-are-missed)."
    )
    return lines


def _times(figures: dict[str, Any]) -> str:
    wall = figures["wall_us"]
    return f"{wall['median']:,.0f} ({wall['p95']:,.0f})"


def asked_for(description: str | None) -> tuple[dict[str, Any], str]:
    """The record named on the command line of a script so described, else the newest; and its file's name."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("record", nargs="?", type=read, help="a record of `make bench` (the newest in bench/records)")
    found: tuple[dict[str, Any], str] = parser.parse_args().record or read(newest())
    return found


def main() -> int:
    text = figures(*asked_for(__doc__))
    page = README.read_text(encoding="utf-8")
    before, rest = page.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    README.write_text(f"{before}{MARKERS[0]}\n{text}\n{MARKERS[1]}{after}", encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
