"""Puts the figures of a benchmark record into README.md, between its markers.

python bench/readme.py                                    the newest record in bench/records
python bench/readme.py bench/records/2026-11-20-x-1.json  a given one
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
MARKERS = ("<!-- figures: bench/readme.py -->", "<!-- end of figures -->")


def newest() -> Path:
    """The record with the latest date, then the highest number."""

    def age(path: Path) -> tuple[str, int]:
        match = re.fullmatch(r"(\d{4}-\d\d-\d\d)-.*?-(\d+)", path.stem)
        return (match[1], int(match[2])) if match else ("", 0)

    records = sorted((ROOT / "bench" / "records").glob("*.json"), key=age)
    if not records:
        sys.exit("bench/records holds no record: run `make bench` first")
    return records[-1]


def figures(record: dict[str, Any], name: str) -> str:
    """The table of the largest mock-up, and what it was measured with."""
    size = record["sizes"][-1]
    builds = {build["engine"]: build for build in size["builds"]}
    peer = "coal" if "coal" in builds else None
    lines = [
        f"The sample `engine` with {size['triangles']:,} triangles in {size['parts']:,} parts; all colliding pairs",
        "of a pose, one core, microseconds,",
        "median (p95) over 100 poses, each the best of five rounds:",
        "",
        f"| tool | triangles | pose | pairs | feeler |{' Coal |' if peer else ''}",
        f"|---|---:|---|---:|---:|{'---:|' if peer else ''}",
    ]
    for cell in record["cells"]:
        if cell["triangles"] != size["triangles"]:
            continue
        times = {engine: data["wall_us"] for engine, data in cell["engines"].items()}
        row = [cell["tool"], f"{cell['tool_triangles']:,}", cell["kind"], f"{cell['pairs']['median']:,.0f}"]
        row += [f"{times[e]['median']:,.0f} ({times[e]['p95']:,.0f})" for e in ("feeler", peer) if e]
        lines.append("| " + " | ".join(row) + " |")
    ours = builds["feeler"]
    text = (
        f"Index built in {ours['all_cores_s']:.2f} s on {record['machine']['cores']} cores ({ours['one_core_s']:.2f} s "
        f"on one), {ours['bytes_per_triangle']:.0f} bytes a triangle with the triangles themselves"
    )
    if peer:
        theirs = builds[peer]
        text += (
            f"; Coal {theirs['one_core_s']:.1f} s and {theirs['bytes_per_triangle']:.0f} bytes.\nNominal: 1 to 5 % of "
            "the tool's triangles collide; near: among the parts, nothing collides. Coal: `BVHModelOBBRSS`,\n"
            "contact computation off, same poses, same run, interleaved"
        )
    lines += ["", f"{text}. {record['machine']['cpu']}, `make bench`, [{name}](bench/records/{name})."]
    return "\n".join(lines)


def main() -> int:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else newest()
    text = figures(json.loads(path.read_text(encoding="utf-8")), path.name)
    page = README.read_text(encoding="utf-8")
    before, rest = page.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    README.write_text(f"{before}{MARKERS[0]}\n{text}\n{MARKERS[1]}{after}", encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
