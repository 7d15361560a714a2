"""Makes the pictures of docs/removal.md: removal paths as a row of poses.

    python tools/removal_pictures.py [NAME ...] [--out FOLDER]

Names: tubes, pump. Needs no display; takes a minute.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

import feeler
from feeler.io.body import Body, body_of
from feeler.io.film import with_neighbours
from feeler.picture import Camera, render
from feeler.poses import between

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "bench"))

from removal.puzzles import MOVING, tubes  # noqa: E402

Floats = npt.NDArray[np.float64]

SIZE = (1280, 720)
GREY, BLUE = (0.80, 0.81, 0.82), (0.27, 0.50, 0.80)
PUMP, GEARBOX_TRIANGLES = "gearbox/oil_pump/body", 400_000


def along(tool: feeler.Tool, poses: Floats, count: int) -> list[Floats]:
    """Poses of a way, evenly spread over its legs."""
    middle = tool.bounds.mean(axis=0)
    times = np.linspace(0.0, len(poses) - 1.0, count)
    legs = np.minimum(times.astype(int), len(poses) - 2)
    return [between(poses[leg], poses[leg + 1], middle, time - leg) for leg, time in zip(legs, times, strict=True)]


def shown(tool: feeler.Tool, poses: Sequence[Floats]) -> list[Body]:
    """The tool at each pose, paler and paler."""
    shares = np.linspace(1.0, 0.35, len(poses))
    white = np.ones(3)
    return [
        body_of(tool, pose=pose, colours=share * np.array(BLUE) + (1.0 - share) * white)
        for pose, share in zip(poses, shares, strict=True)
    ]


def draw_tubes(path: Path) -> None:
    """Linked tubes come apart."""
    mockup = tubes(1.6)
    found = feeler.removal(feeler.Scene(mockup), MOVING)
    tool = feeler.Tool.of_parts(mockup, MOVING)
    bodies = shown(tool, along(tool, found.poses, 7)[:5])
    still = body_of(feeler.Tool.of_parts(mockup, "obstacle"), colours=np.array(GREY))
    render(path, still, *bodies, size=SIZE)


def draw_pump(path: Path) -> None:
    """The oil pump of the sample gearbox and all around it; its pipes, nuts and end cover are out already."""
    mockup = feeler.sample("gearbox", GEARBOX_TRIANGLES)
    *before, last = feeler.sample_truth("gearbox", GEARBOX_TRIANGLES).way(PUMP)
    out = [path for step in before if step.removes for path in step.parts]
    found = feeler.removal(feeler.Scene(mockup).without(out), last.parts)
    print(f"{found!r}, {len(out)} parts out before")
    tool = feeler.Tool.of_parts(mockup, list(last.parts))
    gone = {*mockup.parts.select([*out, *last.parts]).tolist()}
    near = [part for part in with_neighbours(mockup, mockup.parts.select(last.parts)) if part not in gone]
    still = body_of(feeler.Tool.of_parts(mockup, near), colours=np.array(GREY))
    bodies = shown(tool, along(tool, found.poses, 4))
    points = np.concatenate([body.points for body in bodies])
    middle = points.mean(axis=0)
    around = middle + 1.6 * (points - middle)
    render(path, still, *bodies, camera=Camera.framing(around, (-0.6, 0.7, -0.6), size=SIZE), size=SIZE)


PICTURES: dict[str, Callable[[Path], None]] = {"tubes": draw_tubes, "pump": draw_pump}


def main() -> None:
    """Draws the chosen pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", choices=[*PICTURES, []], help="default: all")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "removal")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or PICTURES:
        PICTURES[name](options.out / f"{name}.png")
        print(f"Written: {options.out / name}.png")


if __name__ == "__main__":
    main()
