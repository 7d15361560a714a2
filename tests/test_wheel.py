"""The wheel as people install it: the workbench's page is in it, and is what its server serves."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import urllib.request
import zipfile
from pathlib import Path

import pytest

PAGE = "feeler/workbench/static/"


@pytest.mark.slow
def test_the_wheel_carries_the_page_and_serves_it(root: Path, tmp_path: Path) -> None:
    static = root / "python" / PAGE
    if not (static / "index.html").is_file() or not (root / "target" / "maturin").is_dir():
        pytest.skip("nothing is built here: make build")
    # What `make build` compiled is taken as it is.
    built = subprocess.run(
        [sys.executable, "-m", "maturin", "build", "--release", "--locked", "--out", tmp_path / "dist"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        inside = {name.removeprefix(PAGE) for name in archive.namelist() if name.startswith(PAGE)}
        assert inside == {path.relative_to(static).as_posix() for path in static.rglob("*") if path.is_file()}
        assert {"index.html", "main.js", "style.css"} <= inside
        assert "feeler/plan/catalogue.toml" in archive.namelist()
        archive.extractall(tmp_path / "installed")
    process = subprocess.Popen(
        [sys.executable, "-c", "from feeler.cli import main; main()", "view", "sample:engine:1000", "--no-browser"],
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "installed"), "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        address = re.match(r"(http://\S+)/#", process.stdout.readline())
        assert address is not None
        for name in ("", "main.js"):
            with urllib.request.urlopen(f"{address.group(1)}/{name}", timeout=30) as answer:
                assert answer.read() == (static / (name or "index.html")).read_bytes()
    finally:
        process.kill()
        process.communicate()
