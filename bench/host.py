"""The environment of the bench: machine, system, commit, versions."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent

# Instruction sets that decide how fast such code can run; the rest of the flags says nothing here.
_SETS = re.compile(r"^(sse2|sse4_2|avx|avx2|fma|bmi2|avx512\w+|asimd|sve2?|neon)$")
# The first of these that a CPU has. One name may stand for several generations, which only such flags tell apart.
_LANES = {"avx512_vp2intersect": "AVX-512 with VP2INTERSECT", "avx512f": "AVX-512", "avx2": "AVX2", "asimd": "NEON"}


def machine() -> dict[str, Any]:
    """CPU, cores, instruction sets, memory, system."""
    cpu = _cpuinfo("model name") or platform.processor() or platform.machine()
    flags = (_cpuinfo("flags") or _cpuinfo("Features") or "").split()
    return {
        "cpu": cpu.strip(),
        "architecture": platform.machine(),
        "cores": os.cpu_count(),
        "flags": sorted(flag for flag in flags if _SETS.match(flag)),
        "memory_gib": _memory_gib(),
        "system": f"{platform.system()} {platform.release()}",
    }


def name(cpu: str, flags: Sequence[str]) -> str:
    """The name of a kind of machine: its CPU, and the best lanes it has."""
    lanes = next((name for flag, name in _LANES.items() if flag in flags), "no AVX2, AVX-512 or NEON")
    plain = re.sub(r"\((R|TM)\)|\b(CPU|Processor)\b|@.*$", " ", cpu, flags=re.IGNORECASE)
    return f"{' '.join(plain.split())}, {lanes}"


def now() -> str:
    """The time, UTC, to the second."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def commit() -> dict[str, Any]:
    """The commit of the code under measurement, and whether the working tree differs from it.

    Records and documents do not change the measurements.
    """
    revision = _git("rev-parse", "HEAD")
    unmeasured = (":(exclude)bench/records", ":(exclude)docs", ":(exclude)*.md")
    changed = _git("status", "--porcelain", "--untracked-files=no", "--", ".", *unmeasured)
    return {"commit": revision, "dirty": None if revision is None else bool(changed)}


def versions(peers: dict[str, str]) -> dict[str, str]:
    """Of everything whose version may move a figure."""
    found = {"python": platform.python_version(), **peers}
    for package in ("feeler", "numpy"):
        with contextlib.suppress(metadata.PackageNotFoundError):
            found[package] = metadata.version(package)
    return found


def arguments(given: list[str]) -> list[str]:
    """The arguments but for where results are written, which changes nothing in them."""
    kept, skip = [], False
    for word in given:
        if not skip and not re.match(r"--(out|json)(=|$)", word):
            kept.append(word)
        skip = not skip and word in ("--out", "--json")
    return kept


def affinity() -> set[int] | None:
    """The cores that this program may use; None where the system does not say."""
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None


def last_core() -> int | None:
    """The core to measure on: the last one, where there are several and the system lists them."""
    cores = affinity()
    return max(cores) if cores is not None and len(cores) > 1 else None


@contextlib.contextmanager
def on_core(core: int | None) -> Iterator[None]:
    """This thread on one core, and with it all threads and programs that it starts meanwhile; None: on any."""
    before = affinity()
    if core is None or before is None:
        yield
        return
    os.sched_setaffinity(0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def load_average() -> list[float] | None:
    """How busy the machine is; above 1 on one or two cores, the figures are noisy."""
    with contextlib.suppress(AttributeError, OSError):
        return [round(value, 2) for value in os.getloadavg()]
    return None


def build_profile() -> str | None:
    """The Cargo profile of the extension in use, where the Makefile left its mark."""
    marks = list((Path(sys.prefix)).glob(".built-*"))
    return marks[0].name.removeprefix(".built-") if len(marks) == 1 else None


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
