"""A short smoke of the fuzz targets; `make fuzz` runs them for long, guided by coverage."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

FORMATS = ["stl", "obj", "ply", "off", "gltf", "glb", "3mf", "dae", "step"]


def run(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-W", "error", str(root / "fuzz" / "loaders.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_every_format_is_listed(root: Path) -> None:
    assert run(root, "--list").stdout.split() == FORMATS


@pytest.mark.parametrize("kind", FORMATS)
def test_changed_files_load_or_are_refused(root: Path, kind: str) -> None:
    result = run(root, kind, "--smoke", "15" if kind == "step" else "150")  # a child process for each STEP file
    assert result.returncode == 0, result.stderr[-2000:]
