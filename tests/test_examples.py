"""Every example runs as it is, and says what its text promises."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SAYS = {
    "quick_start.py": ["triangles in", "indexed in", "pose"],
    "batch_of_poses.py": ["20,000 poses in", "of the poses are free", "most often in the way"],
    "own_arrays.py": ["beside the stand: 0 pairs", "stand/post_right"],
    "assembly_report.py": ["poses collide", "report.png"],
}


def test_every_example_is_tested() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(SAYS)


@pytest.mark.parametrize("name", sorted(SAYS))
def test_example_runs(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(EXAMPLES / name)], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    for words in SAYS[name]:
        assert words in done.stdout
    if name == "assembly_report.py":
        assert {path.name for path in tmp_path.iterdir()} == {"report.csv", "report.glb", "report.png"}
