"""Counts the contacts of flush faces that libraries miss or invent, compared with exact arithmetic.

    python bench/exactness.py                     print the table
    python bench/exactness.py --write             and put it into docs/exactness.md, between its markers

Each case is a common CAD situation: a pin in a hole without clearance, a box on a plate, a part and its own copy. The
truth is `judge.meets` (whole-number arithmetic that shares no code with any engine) over all pairs of triangles with
overlapping boxes; "missed" are true pairs not reported, "extra" are reported pairs that do not collide.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from judge import at_pose, has_area, meets

import feeler

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "exactness.md"
MARKERS = ("<!-- table: bench/exactness.py -->", "<!-- end of table -->")

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Mesh = tuple[Floats, Faces]
Pairs = set[tuple[int, int]]


@dataclass(frozen=True)
class Scene:
    """A mock-up, a tool and the tool's pose."""

    mockup: Mesh
    tool: Mesh
    pose: Floats


def rotation(rng: np.random.Generator) -> Floats:
    """A random rigid pose without translation."""
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return pose


def poses(count: int, translation: Floats | float = 0.0) -> list[Floats]:
    """Random rotations with a fixed translation."""
    rng = np.random.default_rng(0)
    made = [rotation(rng) for _ in range(count)]
    for pose in made:
        pose[:3, 3] = translation
    return made


def wall(radius: float, sides: int, levels: Floats, outward: bool) -> Mesh:
    """The side of a prism, its corners the same for the same arguments, bit for bit."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    vertices = np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in levels])
    faces = []
    for level in range(len(levels) - 1):
        for i in range(sides):
            a, b = level * sides + i, level * sides + (i + 1) % sides
            c, d = a + sides, b + sides
            faces += [(a, b, d), (a, d, c)] if outward else [(a, d, b), (a, c, d)]
    return vertices, np.array(faces)


def plate(size: float, cells: int, height: float = 0.0) -> Mesh:
    """A square in the plane z = height, cut into cells."""
    line = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, height)], 1)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    a, b, c, d = corner, corner + cells + 1, corner + cells + 2, corner + 1
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def box(size: float, cells: int) -> Mesh:
    """A closed box standing on z = 0, each side cut into cells."""
    top, faces = plate(size, cells, size)
    x, y, z = (top - np.array([0, 0, size / 2])).T
    sides = [(x, y, z), (x, -y, -z), (z, x, y), (-z, x, -y), (y, z, x), (-y, -z, x)]
    vertices = np.concatenate([np.stack(side, 1) for side in sides]) + np.array([0, 0, size / 2])
    return vertices, np.vstack([faces + i * len(top) for i in range(6)])


def placed(mesh: Mesh, pose: Floats) -> Mesh:
    """The mesh at a pose, each corner rounded as a tool's would be."""
    return at_pose(mesh[0], pose), mesh[1]


def pin_in_hole(clearance: float, translation: float, count: int = 8) -> Iterator[Scene]:
    """A pin and the wall of its hole, both at the same rotated pose."""
    hole = wall(0.02, 48, np.linspace(0, 0.06, 7), outward=False)
    pin = wall(0.02 - clearance, 48, np.linspace(-0.005, 0.065, 8), outward=True)
    if clearance == 0:
        pin = wall(0.02, 48, np.linspace(0, 0.06, 7), outward=True)
    for pose in poses(count, translation):
        yield Scene(placed(hole, pose), pin, pose)


def box_on_plate(turned: bool) -> Iterator[Scene]:
    """A box flush on a plate, its cells shifted against the plate's."""
    for pose in poses(8) if turned else [np.eye(4)]:
        shifted = pose @ np.array([[1, 0, 0, 0.003], [0, 1, 0, 0.002], [0, 0, 1, 0], [0, 0, 0, 1]])
        yield Scene(placed(plate(0.1, 10), pose), box(0.04, 6), shifted)


def own_copy(translation: float, scale: float = 1.0) -> Iterator[Scene]:
    """A part and its exact copy at the same pose: every triangle meets itself and its neighbours."""
    vertices, faces = box(0.04 * scale, 5)
    for pose in poses(8, translation):
        yield Scene(placed((vertices, faces), pose), (vertices, faces), pose)


CASES: dict[str, Callable[[], Iterator[Scene]]] = {
    "pin in a hole, no clearance, 8 poses": lambda: pin_in_hole(0.0, 0.0),
    "the same, 3000 m from the origin": lambda: pin_in_hole(0.0, 3000.0),
    "pin with 1e-9 m clearance, 3000 m from the origin": lambda: pin_in_hole(1e-9, 3000.0),
    "pin with 1e-9 m clearance at the origin": lambda: pin_in_hole(1e-9, 0.0),
    "box standing on a plate": lambda: box_on_plate(False),
    "the same, 8 rotated poses": lambda: box_on_plate(True),
    "a part and its own copy, 8 poses": lambda: own_copy(0.0),
    "the same, micrometres, 1000 m from the origin": lambda: own_copy(1000.0, 1e-4),
}


def truth(scene: Scene) -> Pairs:
    """Exactly the pairs that meet. Triangles without area are no one's business."""
    tool = at_pose(scene.tool[0], scene.pose)[scene.tool[1]]
    mockup = scene.mockup[0][scene.mockup[1]]
    queried_tool = [i for i, t in enumerate(scene.tool[0][scene.tool[1]]) if has_area(t)]
    queried_mockup = np.array([has_area(t) for t in mockup])
    lower, upper = mockup.min(1), mockup.max(1)
    found = set()
    for i in queried_tool:
        near = ((lower <= tool[i].max(0)) & (upper >= tool[i].min(0))).all(1) & queried_mockup
        found |= {(i, int(j)) for j in np.flatnonzero(near) if meets(tool[i], mockup[j])}
    return found


def by_feeler(scene: Scene) -> Pairs:
    index = feeler.Scene(feeler.Mockup(*scene.mockup))
    return {(int(a), int(b)) for a, b in index.collide(feeler.Tool(*scene.tool), scene.pose).pairs}


def by_coal(scene: Scene) -> Pairs:
    import coal
    from coal_engine import model

    request, result = coal.CollisionRequest(), coal.CollisionResult()
    request.num_max_contacts = 10_000_000
    request.enable_contact = False
    place = coal.Transform3s(scene.pose[:3, :3], scene.pose[:3, 3])
    coal.collide(model(*scene.tool), place, model(*scene.mockup), coal.Transform3s.Identity(), request, result)
    return {(int(c.b1), int(c.b2)) for c in result.getContacts()}


def by_fcl(scene: Scene) -> Pairs:
    import fcl

    def body(mesh: Mesh, place: Any) -> Any:
        made = fcl.BVHModel()
        made.beginModel(len(mesh[0]), len(mesh[1]))
        made.addSubModel(mesh[0], mesh[1])
        made.endModel()
        return fcl.CollisionObject(made, place)

    result = fcl.CollisionResult()
    tool = body(scene.tool, fcl.Transform(scene.pose[:3, :3], scene.pose[:3, 3]))
    request = fcl.CollisionRequest(num_max_contacts=10_000_000, enable_contact=True)
    fcl.collide(tool, body(scene.mockup, fcl.Transform()), request, result)
    return {(int(c.b1), int(c.b2)) for c in result.contacts}


ENGINES: dict[str, tuple[str, Callable[[Scene], Pairs]]] = {
    "feeler": ("feeler", by_feeler),
    "Coal": ("coal", by_coal),
    "python-fcl": ("fcl", by_fcl),
}


def available() -> dict[str, Callable[[Scene], Pairs]]:
    """The engines that are installed; says which are not."""
    from importlib.util import find_spec

    for name, (module, _) in ENGINES.items():
        if find_spec(module) is None:
            print(f"{name} is not installed: left out (pip install 'feeler[bench]')", file=sys.stderr)
    return {name: run for name, (module, run) in ENGINES.items() if find_spec(module)}


def rows(names: list[str]) -> Iterator[tuple[str, int, dict[str, tuple[int, int, int]]]]:
    """Per case: its name, the true pairs, and per engine the pairs reported, missed and extra."""
    engines = available()
    for name in names:
        start = time.perf_counter()
        true, counts = 0, {engine: np.zeros(3, int) for engine in engines}
        for scene in CASES[name]():
            exact = truth(scene)
            true += len(exact)
            for engine, run in engines.items():
                found = run(scene)
                counts[engine] += [len(found), len(exact - found), len(found - exact)]
        print(f"{name}: {time.perf_counter() - start:.1f} s", file=sys.stderr)
        yield name, true, {engine: (int(c[0]), int(c[1]), int(c[2])) for engine, c in counts.items()}


def markdown(table: list[tuple[str, int, dict[str, tuple[int, int, int]]]]) -> str:
    """The table, with where it comes from."""
    engines = list(table[0][2])
    lines = [
        "| case | pairs that meet | " + " | ".join(f"{e}: reported | missed | extra" for e in engines) + " |",
        f"|---|{'---:|' * (1 + 3 * len(engines))}",
    ]
    for name, true, counts in table:
        cells = [f"{n:,}" for engine in engines for n in counts[engine]]
        lines.append(f"| {name} | {true:,} | " + " | ".join(cells) + " |")
    from importlib.metadata import version

    packages = {"feeler": "feeler", "Coal": "coal", "python-fcl": "python-fcl"}
    versions = ", ".join(f"{e} {version(packages[e])}" for e in engines)
    lines += ["", f"`python bench/exactness.py --write`, {versions}, Python {platform.python_version()}."]
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the table into docs/exactness.md")
    parser.add_argument("--only", metavar="WORDS", default="", help="only cases whose name contains these words")
    options = parser.parse_args(arguments)
    names = [name for name in CASES if options.only in name]
    if not names:
        parser.error(f"no case contains {options.only!r}")
    text = markdown(list(rows(names)))
    print(text)
    if options.write:
        page = PAGE.read_text(encoding="utf-8")
        before, rest = page.split(MARKERS[0])
        after = rest.split(MARKERS[1])[1]
        PAGE.write_text(f"{before}{MARKERS[0]}\n{text}\n{MARKERS[1]}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
