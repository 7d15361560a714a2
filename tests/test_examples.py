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
    "feel.py": ["a reach into the engine", "in collision at 0 of them", "the same bit for bit"],
    "own_arrays.py": ["beside the stand: 0 pairs", "stand/post_right"],
    "own_device.py": ["500 N/m granted; 12 mm into the plate the hand feels 6.00 N", "it has let go: 0.0 N"],
    "part_out.py": [
        "inside/pump/shaft is inside inside/pump",
        "inside/filter is held by inside/pump\ninside/pump is held by lid\nlid is held by latch\nlatch goes out\n",
        "lid goes out\ninside/filter is held by inside/pump\ninside/pump goes out\ninside/filter goes out\n",
    ],
    "cowl.py": [
        "latched, the door opens by 0.5 degrees: gearbox/door/latch meets gearbox/bracket/front_rail",
        "with the latch turned, it opens by 178.9 degrees",
        "with the door closed it comes out: False; of the door, these are in the way: gearbox/door/panel",
        "with the door open it comes out: True",
        "with the filter in place the door closes to -0.2 degrees\nwith the filter taken out the door closes to -0.2",
    ],
    "clash.py": [
        "findings among",
        "3 clash, ",
        "mm deep: gearbox/bracket/beam and gearbox/bracket/lost_ball",
        "mm apart: gearbox/lines/oil_pipe/pipe and gearbox/bracket/near_support",
        "since the last check: {'new': 0",
        "'approved': 1",
        "6 topics in clashes.bcf",
    ],
    "removal.py": [
        "left_mount/retainer: Removal(not found",
        "step 1: gearbox/bracket/left_mount/retainer_bolt",
        "step 2: gearbox/bracket/left_mount/retainer:",
        "a film in way.glb",
    ],
    "workbench.py": ["stopped by gearbox/oil_pump/body", "there it would meet the pump", "2 parts came out"],
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
    if name == "workbench.py":
        assert (tmp_path / "workbench.png").read_bytes().startswith(b"\x89PNG")
    if name == "clash.py":
        assert {path.name for path in tmp_path.iterdir()} == {"clashes.html", "clashes.bcf", "clashes.json"}
    if name == "removal.py":
        assert {path.name for path in tmp_path.iterdir()} == {"way.npy", "way.glb"}
    if name == "assembly_report.py":
        assert {path.name for path in tmp_path.iterdir()} == {"report.csv", "report.glb", "report.png"}
