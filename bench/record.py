"""What is kept of a run: where and on what it was measured; one JSON document, and a JSON line per cell and engine."""

from __future__ import annotations

import contextlib
import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path
from typing import Any

from goals import MEASURES

ROOT = Path(__file__).resolve().parent.parent
SCHEMA = 2

# Instruction sets that decide how fast such code can run; the rest of the flags says nothing here.
_LANES = re.compile(r"^(sse2|sse4_2|avx|avx2|fma|bmi2|avx512\w+|asimd|sve2?|neon)$")


def now() -> str:
    """The time, UTC, to the second."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def machine() -> dict[str, Any]:
    """CPU, cores, instruction sets, memory, system."""
    cpu = _cpuinfo("model name") or platform.processor() or platform.machine()
    flags = (_cpuinfo("flags") or _cpuinfo("Features") or "").split()
    return {
        "cpu": cpu.strip(),
        "architecture": platform.machine(),
        "cores": os.cpu_count(),
        "flags": sorted(flag for flag in flags if _LANES.match(flag)),
        "memory_gib": _memory_gib(),
        "system": f"{platform.system()} {platform.release()}",
    }


def load_average() -> list[float] | None:
    """How busy the machine is; above 1 on one or two cores, the figures are noisy."""
    with contextlib.suppress(AttributeError, OSError):
        return [round(value, 2) for value in os.getloadavg()]
    return None


def commit() -> dict[str, Any]:
    """The commit of the code under measurement, and whether the working tree differs from it."""
    revision = _git("rev-parse", "HEAD")
    changed = _git("status", "--porcelain", "--untracked-files=no")
    return {"commit": revision, "dirty": None if revision is None else bool(changed)}


def versions(peers: dict[str, str]) -> dict[str, str]:
    """Of everything whose version may move a figure."""
    found = {"python": platform.python_version(), **peers}
    for name in ("feeler", "numpy"):
        with contextlib.suppress(metadata.PackageNotFoundError):
            found[name] = metadata.version(name)
    return found


def arguments(given: list[str]) -> list[str]:
    """The arguments but for where results are written, which changes nothing in them."""
    kept, skip = [], False
    for word in given:
        if not skip and not re.match(r"--(out|json)(=|$)", word):
            kept.append(word)
        skip = not skip and word in ("--out", "--json")
    return kept


def build_profile() -> str | None:
    """The Cargo profile of the extension in use, where the Makefile left its mark."""
    marks = list((Path(sys.prefix)).glob(".built-*"))
    return marks[0].name.removeprefix(".built-") if len(marks) == 1 else None


def write(record: dict[str, Any], folder: Path) -> tuple[Path, Path]:
    """Write the record and its rows under the next free name of the day; return both paths."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"{record['when'][:10]}-{_slug(record['machine']['cpu'])}"
    number = 1
    while (folder / f"{stem}-{number}.json").exists():
        number += 1
    document, lines = folder / f"{stem}-{number}.json", folder / f"{stem}-{number}.jsonl"
    document.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    lines.write_text("".join(json.dumps(row) + "\n" for row in rows(record)), encoding="utf-8")
    return document, lines


def rows(record: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """One flat row per cell and engine, each complete in itself, so that rows of many runs can be put in one table."""
    common = {
        "when": record["when"],
        "commit": record["commit"],
        "dirty": record["dirty"],
        "cpu": record["machine"]["cpu"],
        "cores": record["machine"]["cores"],
        "flags": " ".join(record["machine"]["flags"]),
        "args": " ".join(record["args"]),
    }
    builds = {(size["triangles_asked"], row["engine"]): row for size in record["sizes"] for row in size["builds"]}
    for cell in record["cells"]:
        for engine, figures in cell.get("engines", {}).items():
            build = builds[cell["triangles_asked"], engine]
            funnel = cell.get("funnel", {}) if engine == "feeler" else {}
            yield {
                **common,
                "engine": engine,
                "version": record["versions"].get(engine),
                **{key: cell[key] for key in ("query", "triangles_asked", "triangles", "parts")},
                **{key: cell[key] for key in ("tool", "tool_triangles", "kind", "poses", "rounds")},
                "pairs_median": cell["pairs"]["median"],
                **_flat("wall", figures["wall_us"], "us"),
                **_flat("cpu", figures["cpu_us"], "us"),
                "worst_single_call_us": figures["worst_single_call_us"],
                **_flat("times_faster_wall", cell["ratios"].get(engine, {}).get("wall", {})),
                **_flat("times_faster_cpu", cell["ratios"].get(engine, {}).get("cpu", {})),
                **_best(cell, engine),
                "build_one_core_s": build["one_core_s"],
                "build_all_cores_s": build["all_cores_s"],
                "bytes_per_triangle": build["bytes_per_triangle"],
                **_flat("mean", funnel),
            }


def _best(cell: dict[str, Any], engine: str) -> dict[str, Any]:
    """In feeler's row: the best peer; in a peer's: whether it is the best."""
    best = cell["best"]
    if engine != "feeler":
        return {f"best_{measure}": best[measure]["peer"] == engine for measure in MEASURES}
    row = {} if best is None else {"wanted": best["wanted"], "met": best["met"]}
    for measure in MEASURES if best else ():
        row |= {f"best_{measure}_peer": best[measure]["peer"]}
        row |= {f"times_faster_best_{measure}": best[measure]["times_faster"]}
    return row


def _flat(head: str, figures: dict[str, float], unit: str = "") -> dict[str, float]:
    tail = f"_{unit}" if unit else ""
    return {f"{head}_{name}{tail}": value for name, value in figures.items()}


def _slug(text: str) -> str:
    words = re.sub(r"\((r|tm)\)|\bcpu\b|@.*$", " ", text.lower())
    return re.sub(r"[^a-z0-9]+", "-", words).strip("-")[:40] or "cpu"


def _cpuinfo(field: str) -> str | None:
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == field:
                return value
    return None


def _memory_gib() -> float | None:
    with contextlib.suppress(AttributeError, OSError, ValueError):
        return round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30, 1)
    return None


def _git(*arguments: str) -> str | None:
    with contextlib.suppress(OSError):
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return done.stdout.strip()
    return None
