"""Stations for tests of nightly runs: a cover on a case, under a bolt, each; far corners that keep the box the same."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from shapes import Mesh, box, cube, mockup_of

import feeler
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

COARSE = Tolerance(1e-3)
CLEAR, TAPPED = 0.0045, 0.0034
COUNT = 4


def driver() -> feeler.Tool:
    """A rod above a head."""
    return feeler.Tool(*box((-0.002, -0.002, 0.0005), (0.002, 0.002, 0.05)), name="driver")


def placed(mesh: Mesh, x: float, z: float = 0.0) -> Mesh:
    return mesh[0] + np.array([x, 0.0, z]), mesh[1]


def ring(inner: float, height: float) -> Mesh:
    mesh = hardware.ring(inner, 0.02, height, COARSE)
    return mesh.vertices, mesh.faces.astype(np.int64)


def bolt(length: float = 0.03) -> Mesh:
    mesh = hardware.hex_bolt(0.008, length, COARSE)
    return mesh.vertices, mesh.faces.astype(np.int64)


def lid(x: float, z: float = 0.02) -> Mesh:
    return box((x - 0.03, -0.03, z), (x + 0.03, 0.03, z + 0.005))


def parts(count: int = COUNT) -> dict[str, Mesh]:
    """Paths and meshes. Station n is at x = n, metres; a lid lies beside each bolt but the first."""
    found = {"frame/low": cube((-1.0, -1.0, -1.0), 0.1), "frame/high": cube((count, 1.0, 1.0), 0.1)}
    for n in range(count):
        found[f"s{n}/bolt"] = placed(bolt(), n)
        found[f"s{n}/cover"] = placed(ring(CLEAR, 0.01), n, -0.01)
        found[f"s{n}/case"] = placed(ring(TAPPED, 0.03), n, -0.04)
        found[f"s{n}/lid"] = lid(n + 0.5)
    return found


def scene_of(meshes: Mapping[str, Mesh]) -> feeler.Scene:
    return feeler.Scene(mockup_of(meshes), threads=1)


def covers(count: int = COUNT) -> list[str]:
    return [f"s{n}/cover" for n in range(count)]


def saved(folder: Path, name: str, meshes: Mapping[str, Mesh]) -> Path:
    path = folder / name
    scene_of(meshes).save(path)
    return path
