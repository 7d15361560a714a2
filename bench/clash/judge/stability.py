"""Checks that depths are stable when triangles are subdivided, and when parts move slightly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import feeler

from .asking import ROUNDED_BY, SPACING_M, Answer, Pair, answers, mockup_of
from .kinds import groups
from .shapes import Mesh, cut_finer

Result = dict[str, Any]
Parts = list[Mesh]

MOVES_M = (1e-9, 1e-6, 1e-4)
MOST_EXAMPLES = 5


def measured(seed: int, is_quick: bool) -> list[Result]:
    """For each set of parts and each change: the number of pairs, and of depths that change too much."""
    rows = []
    for name, parts in _sets(seed, is_quick):
        before = answers(mockup_of(parts))
        size = max(float(np.abs(vertices).max()) for vertices, _ in parts)
        rounding = 2 * ROUNDED_BY * float(np.spacing(size))
        finer = answers(mockup_of([cut_finer(part, 1) for part in parts]))
        rows.append({"parts": name, "change": "each triangle cut in four", **compared(before, finer, rounding)})
        for step in MOVES_M:
            rng = np.random.default_rng(seed)
            moves = rng.normal(size=(len(parts), 3))
            moves *= step / np.linalg.norm(moves, axis=1)[:, None]
            moved = [(vertices + move, faces) for (vertices, faces), move in zip(parts, moves, strict=True)]
            after = answers(mockup_of(moved))
            change = f"each part moved by {_length(step)} in its own direction"
            rows.append({"parts": name, "change": change, **compared(before, after, rounding + 2 * step)})
    return rows


def _length(metres: float) -> str:
    return {1e-9: "1 nm", 1e-6: "1 µm", 1e-4: "0.1 mm"}[metres]


def _sets(seed: int, is_quick: bool) -> Iterator[tuple[str, Parts]]:
    for name, numbers in (("polycubes", (1, 20)), ("solids", (6, 120)), ("pins", (9, 180))):
        found: Parts = []
        for number, group in enumerate(groups(name, numbers[not is_quick], seed)):
            # Near the origin: the judged pairs cover large coordinates.
            slot = SPACING_M * np.array([number % 8, number // 8 % 8, number // 64], float)
            found += group.in_world(slot - group.place * group.unit)
        yield f"{name}, as above", found
    yield "sample engine", parts_of(feeler.sample("engine", 10_000 if is_quick else 30_000))


def parts_of(mockup: feeler.Mockup) -> Parts:
    """Each part of a mock-up as a separate mesh."""
    found = []
    for part in range(mockup.part_count):
        faces = mockup.faces[mockup.part_of_face == part]
        used, which = np.unique(faces, return_inverse=True)
        found.append((np.array(mockup.vertices[used]), which.reshape(-1, 3).astype(np.int64)))
    return found


def compared(before: Mapping[Pair, Answer], after: Mapping[Pair, Answer], allowed: float) -> Result:
    """Counts depths whose bounds are farther apart than `allowed`, metres. A pair without a finding has depth 0."""
    most, verdicts = 0.0, 0
    wrong = []
    pairs = sorted(before.keys() | after.keys())
    for pair in pairs:
        one, other = before.get(pair, Answer()), after.get(pair, Answer())
        if "estimate" in (one.kind, other.kind):
            continue
        verdicts += one.verdict != other.verdict
        apart = max(0.0, other.depth - one.depth - one.error, one.depth - other.depth - other.error)
        most = max(most, apart)
        if apart > allowed:
            wrong.append((apart, f"parts {pair}: {one} became {other}"))
    examples = [says for _, says in sorted(wrong, reverse=True)[:MOST_EXAMPLES]]
    changed = {"beyond": len(wrong), "most_m": float(f"{most:.3g}"), "verdicts": verdicts}
    return {"pairs": len(pairs), **changed, "examples": examples}
