"""feeler's collision manager against trimesh's, which asks python-fcl: the table of docs/compat.md.

    python bench/managers.py                      print the table; about a minute
    python bench/managers.py --write              and put it into docs/compat.md

Three scenes: 200 tori of 1,024 triangles that drift for 20 frames, each against each; the parts of the sample engine of
50,000 triangles, each against each; a wrench at 20 poses against them. Both managers get the same meshes and must name
the same pairs. One thread. "Adding" is until the first question can be answered: feeler makes trees and indices when a
pair first needs them, so its first question counts as adding, less a second one; python-fcl makes them when an object
is added.
"""

from __future__ import annotations

import argparse
import gc
import math
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import host
import numpy as np
import pages
import trimesh

import feeler
from feeler.compat import meshes
from feeler.compat.trimesh import CollisionManager

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "compat.md"
TORI, FRAMES, SIDE = 200, 20, 9.5
POSES = 20
ROUNDS = 5

Manager = Any
Row = tuple[str, float, float]


class Fcl(trimesh.collision.CollisionManager):
    """trimesh's manager, with feeler's test for convex meshes: its own needs SciPy."""

    def _get_fcl_obj(self, mesh: Any) -> Any:
        is_convex = meshes.shape_of(meshes.triangles_of(mesh), None, 1 << 30).is_solid
        make: Callable[[Any], Any] = trimesh.collision.mesh_to_convex if is_convex else trimesh.collision.mesh_to_BVH
        return make(mesh)


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    gc.collect()
    start = time.perf_counter()
    answer = work()
    return time.perf_counter() - start, answer


def rotations(rng: np.random.Generator, count: int) -> np.ndarray:
    places = np.tile(np.eye(4), (count, 1, 1))
    places[:, :3, :3] = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    places[:, :3, :3] *= np.sign(np.linalg.det(places[:, :3, :3]))[:, None, None]
    return places


def warm_up() -> None:
    """Starts threads and loads modules, so that no figure includes it."""
    ring = trimesh.creation.torus(1.0, 0.3)
    for make in (Fcl, partial(CollisionManager, threads=1)):
        manager = make()
        manager.add_object("a", ring)
        manager.add_object("b", ring, np.eye(4))
        manager.in_collision_internal(return_names=True)


def tori(make: Callable[[], Manager]) -> tuple[list[float], list[Any]]:
    """Seconds for adding, for a frame, and for the slowest; the names in each frame."""
    meshes._kept.clear()
    ring = trimesh.creation.torus(1.0, 0.3, major_sections=32, minor_sections=16)
    rng = np.random.default_rng(3)
    places = rotations(rng, TORI)
    places[:, :3, 3] = rng.uniform(0, SIDE, (TORI, 3))
    manager = make()

    def add() -> None:
        for i, place in enumerate(places):
            manager.add_object(f"torus {i}", ring, place)

    def frame() -> Any:
        for i, place in enumerate(places):
            manager.set_transform(f"torus {i}", place)
        return manager.in_collision_internal(return_names=True)[1]

    added = timed(add)[0]
    first, names = timed(frame)
    found, seconds = [names], []
    again = timed(frame)[0]
    for _ in range(FRAMES - 1):
        places[:, :3, 3] += rng.normal(scale=0.05, size=(TORI, 3))
        taken, names = timed(frame)
        found.append(names)
        seconds.append(taken)
    return [added + max(first - again, 0.0), float(np.median(seconds)), max(seconds)], found


def engine(make: Callable[[], Manager]) -> tuple[list[float], list[Any]]:
    """Seconds for adding, for all parts against each other, and for a wrench at its poses, by name and yes or no."""
    meshes._kept.clear()
    mockup = feeler.sample("engine", 50_000)
    parts = []
    for part in range(len(mockup.parts)):
        used, faces = np.unique(mockup.faces[mockup.part_of_face == part], return_inverse=True)
        parts.append(trimesh.Trimesh(mockup.vertices[used], faces.reshape(-1, 3), process=False))
    wrench = feeler.sample_tool("wrench")
    tool = trimesh.Trimesh(wrench.vertices, wrench.faces, process=False)
    rng = np.random.default_rng(1)
    places = rotations(rng, POSES)
    places[:, :3, 3] = rng.uniform(mockup.vertices.min(axis=0), mockup.vertices.max(axis=0), (POSES, 3))
    manager = make()

    def add() -> None:
        for part, mesh in enumerate(parts):
            manager.add_object(part, mesh)

    def internal() -> Any:
        return manager.in_collision_internal(return_names=True)[1]

    def single() -> Any:
        return [manager.in_collision_single(tool, place, return_names=True)[1] for place in places]

    def any_single() -> Any:
        return [manager.in_collision_single(tool, place) for place in places]

    def distances() -> Any:
        return [round(max(manager.min_distance_single(tool, place), 0.0), 6) for place in places]

    added = timed(add)[0]
    first = timed(internal)[0]
    rest, found = [], []
    for ask in (internal, single, any_single, distances):
        rounds = [timed(ask) for _ in range(ROUNDS)]
        rest.append(min(taken for taken, _ in rounds))
        found.append(rounds[0][1])
    return [added + max(first - rest[0], 0.0), *rest], found


def rows() -> list[Row]:
    warm_up()
    ours = partial(CollisionManager, threads=1)
    table: list[Row] = []
    labels = {
        tori: [f"{TORI} tori: adding", f"{TORI} tori: a frame, names, median", f"{TORI} tori: the slowest frame"],
        engine: [
            "engine: adding",
            "engine: each part against each, names",
            f"engine: a wrench at {POSES} poses, names",
            f"engine: a wrench at {POSES} poses, yes or no",
            f"engine: a wrench at {POSES} poses, distance",
        ],
    }
    for scene, names in labels.items():
        theirs, expected = scene(Fcl)
        own, found = scene(ours)
        if found != expected:
            raise SystemExit(f"{scene.__name__}: the managers do not name the same pairs")
        table.extend(zip(names, theirs, own, strict=True))
    return table


def markdown(table: list[Row]) -> str:
    def milliseconds(seconds: float) -> str:
        return f"{1e3 * seconds:,.2f} ms" if seconds < 0.1 else f"{1e3 * seconds:,.0f} ms"

    lines = [[name, milliseconds(t), milliseconds(o), f"{t / o:.1f}"] for name, t, o in table]
    mean = math.exp(sum(math.log(t / o) for _, t, o in table) / len(table))
    lines.append(["geometric mean", "", "", f"{mean:.1f}"])
    note = f"Same pairs in all. {host.machine()['cpu']}, one thread; `python bench/managers.py`."
    return pages.markdown(["", "trimesh with python-fcl", "feeler", "times as fast"], 1, lines, note)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help=f"put the table into {PAGE.relative_to(ROOT)}")
    given = parser.parse_args()
    made = markdown(rows())
    print(made)
    if given.write:
        PAGE.write_text(
            pages.filled(PAGE.read_text(encoding="utf-8"), "managers", {"managers": made}), encoding="utf-8"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
