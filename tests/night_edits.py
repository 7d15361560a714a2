"""Random small assemblies, and random edits of them, for tests of nightly runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from night_scene import CLEAR, TAPPED, bolt, lid, placed, ring
from shapes import Mesh, box, cube

HEIGHTS = (0.006, 0.012, 0.02, 0.04)
"""Of what lies over a bolt: below its head's top, too low for the tool, in its way, and nearly clear."""


def assembly(rng: np.random.Generator) -> dict[str, Mesh]:
    """Two stations of covers under bolts, with lids, bars and fences around them at random; far corners."""
    found = {"frame/low": cube((-1.0, -1.0, -1.0), 0.1), "frame/high": cube((2.0, 1.0, 1.0), 0.1)}
    for n in range(2):
        found[f"s{n}/case"] = placed(ring(TAPPED, 0.03), n, -0.04)
        found[f"s{n}/cover"] = placed(ring(CLEAR, 0.01), n, -0.01)
        found[f"s{n}/bolt"] = placed(bolt(), n)
        for k in range(int(rng.integers(1, 4))):
            found[f"s{n}/more_{k}"] = obstacle(rng, n)
    return found


def obstacle(rng: np.random.Generator, x: float) -> Mesh:
    """A lid over the bolt, a bar across, a fence beside it, or a block that is in no way."""
    kind, z = int(rng.integers(0, 4)), float(rng.choice(HEIGHTS)) + float(rng.uniform(0.0, 0.002))
    if kind == 0:
        return lid(x, z)
    if kind == 1:
        return box((x - 0.004, -0.06, z), (x + 0.004, 0.06, z + 0.003))
    if kind == 2:
        side = float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.012, 0.03))
        return box((x + side, -0.03, 0.001), (x + side + 0.003, 0.03, z + 0.01))
    return box((x + 0.3, 0.2, z), (x + 0.35, 0.25, z + 0.05))


def edits(rng: np.random.Generator, meshes: dict[str, Mesh]) -> Iterator[tuple[str, dict[str, Mesh]]]:
    """Scenes that follow from each other by small and large moves, parts that go and come, other names and shapes."""
    while True:
        paths = [path for path in meshes if path.startswith("s")]
        path = str(rng.choice(paths))
        kind = int(rng.integers(0, 8))
        if kind == 0 and "more" in path:
            meshes = {each: mesh for each, mesh in meshes.items() if each != path}
        elif kind == 1:
            name = f"s{int(rng.integers(0, 2))}/more_{int(rng.integers(3, 9))}"
            meshes = {**meshes, name: obstacle(rng, float(name[1]))}
        elif kind == 2 and "more" in path:
            meshes = {**meshes, path: obstacle(rng, float(path[1]))}
        elif kind == 3 and "more" in path:
            name = f"{path[:2]}/more_{int(rng.integers(3, 9))}"
            meshes = {name if each == path else each: mesh for each, mesh in meshes.items() if each != name}
        elif kind == 4:
            corners, faces = meshes[path]
            middle = corners.mean(axis=0)
            meshes = {**meshes, path: (middle + float(rng.choice([0.9, 0.999, 1.001])) * (corners - middle), faces)}
        else:
            by = rng.uniform(-1.0, 1.0, 3) * float(rng.choice([1e-5, 5e-4, 5e-3, 0.05]))
            meshes = {**meshes, path: (meshes[path][0] + by, meshes[path][1])}
        yield f"{path} {kind}", meshes
