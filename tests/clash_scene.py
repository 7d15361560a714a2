"""A mock-up of boxes with one finding of each kind, and tables made without a check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from shapes import box, joined, mockup_of

import feeler
from feeler.clashes.table import SHAPES, Columns, Facts
from feeler.clashes.verdict import Verdict

PARTS = {
    "house/walls/left": box((0, 0, 0), (1, 1, 1)),
    "house/walls/right": box((0.9375, 0, 0), (2, 1, 1)),
    "house/pins/bolt M8x30": box((0.25, 0.25, 0.875), (0.5, 0.5, 1.5)),
    "house/pins/core": box((1.25, 0.25, 0.25), (1.5, 0.5, 0.5)),
    "house/copy/left": box((0, 0, 0), (1, 1, 1)),
    "yard/near": box((2.0009765625, 0, 0), (3, 1, 1)),
    "yard/flush": box((0.25, -1, 0.25), (0.75, 0, 0.75)),
}
FOUND = {
    ("house/walls/left", "house/walls/right"): "clash",
    ("house/walls/left", "house/pins/bolt M8x30"): "clash",
    ("house/walls/left", "house/copy/left"): "duplicate",
    ("house/walls/left", "yard/flush"): "contact",
    ("house/walls/right", "house/pins/core"): "contained",
    ("house/walls/right", "house/copy/left"): "clash",
    ("house/walls/right", "yard/near"): "clearance",
    ("house/pins/bolt M8x30", "house/copy/left"): "clash",
    ("house/copy/left", "yard/flush"): "contact",
}
"""All that is to be found with the limits of `feeler.clash`."""


def house() -> feeler.Mockup:
    return mockup_of(PARTS)


def moved(by: float, part: str = "house/walls/right") -> feeler.Mockup:
    """The same with one part shifted along x."""
    shift = np.array([by, 0.0, 0.0])
    return mockup_of({path: (mesh[0] + shift * (path == part), mesh[1]) for path, mesh in PARTS.items()})


def without(*paths: str) -> feeler.Mockup:
    return mockup_of({path: mesh for path, mesh in PARTS.items() if path not in paths})


def pairs(clashes: feeler.Clashes) -> dict[tuple[str, str], str]:
    return {(each.path_a, each.path_b): str(each.verdict) for each in clashes}


def table(
    rows: Sequence[dict[str, Any]],
    paths: Sequence[str] = ("x/a", "x/b", "x/c", "x/d"),
    rules: Sequence[str] = ("default",),
    **more: Any,
) -> feeler.Clashes:
    """A table of rows that say what is not zero, the worst first."""
    zero = {name: np.zeros(shape, kind) for name, (kind, shape) in SHAPES.items()} | {"severity": 1}
    values = [{**zero, "volume": np.nan, **row, "verdict": Verdict(row.get("verdict", 0)).code} for row in rows]
    columns = Columns(
        **{
            name: np.array([each[name] for each in values], dtype=kind).reshape(-1, *shape)
            for name, (kind, shape) in SHAPES.items()
        }
    )
    facts = Facts(clearance=0.002, parts=len(paths))
    order = columns.order(paths, rules)
    return feeler.Clashes(columns.rows(order), paths, rules, facts=facts, **more)


def open_box(lower: Sequence[float], upper: Sequence[float]) -> Any:
    """A box without its top."""
    vertices, faces = box(lower, upper)
    return vertices, faces[~(vertices[faces][:, :, 2] == upper[2]).all(axis=1)]


__all__ = ["FOUND", "PARTS", "box", "house", "joined", "mockup_of", "moved", "open_box", "pairs", "table", "without"]
