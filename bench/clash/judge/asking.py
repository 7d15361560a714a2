"""Checks many pairs with feeler at once, and compares the answers with the expected values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import feeler

from .facts import Facts, wanted
from .shapes import Floats, Mesh, joined

MOST_GROUPS, MOST_TRIANGLES = 64, 150_000
"""Limits for one mock-up."""
SPACING_M = 32.0
"""Distance between groups; no group is larger. A power of two, so that integer coordinates stay exact."""
ROUNDED_BY = 4
"""How much rounding may change a depth, in units in the last place of the largest coordinate. Rotating and moving a
vertex rounds it by less than one unit along each axis, and a depth changes by at most the motion of both surfaces."""
LEAST_ERROR_M, RELATIVE_ERROR = 1e-9, 1e-3
"""The largest allowed distance between feeler's bounds of a depth."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class Group:
    """Parts that are checked together, with the expected facts of each pair.

    parts: meshes in local coordinates; `(part @ turn.T + place) * unit` are world coordinates in metres. facts: metres.
    is_rounded: whether this transformation rounds. right: the right verdicts, if they do not follow from the facts.
    is_single: whether the coordinates then go through a file in single precision.
    """

    kind: str
    parts: tuple[Mesh, ...]
    facts: Mapping[Pair, Facts]
    turn: Floats = field(default_factory=lambda: np.eye(3))
    place: Floats = field(default_factory=lambda: np.zeros(3))
    unit: float = 1.0
    is_rounded: bool = True
    contact: float | None = None
    clearance: float = 0.0
    right: Mapping[Pair, frozenset[str]] = field(default_factory=dict)
    is_single: bool = False

    def triangles(self) -> int:
        return sum(len(faces) for _, faces in self.parts)

    def in_world(self, slot: Floats) -> list[Mesh]:
        """The parts in world coordinates. slot: moves the whole group, metres."""
        return [((v @ self.turn.T + (self.place + slot / self.unit)) * self.unit, faces) for v, faces in self.parts]


@dataclass(frozen=True)
class Answer:
    """The finding of feeler for a pair; "none" if there is no finding."""

    verdict: str = "none"
    depth: float = 0.0
    error: float = 0.0
    kind: str = ""


@dataclass(frozen=True)
class Judged:
    """The result for one pair. is_meeting: whether the parts should meet. is_outside: the depth is outside its bounds.
    relative_error: of the depth; None if the right depth is unknown or below a micrometre. says: the fault in words.
    """

    kind: str
    is_meeting: bool
    is_verdict_wrong: bool
    is_outside: bool
    relative_error: float | None
    says: str


def mockup_of(parts: Sequence[Mesh], rounding: float = 0.0) -> feeler.Mockup:
    """A mock-up of these parts. rounding: what its source says of the coordinates, metres."""
    vertices, faces = joined(*parts)
    of_face = np.repeat(np.arange(len(parts)), [len(part[1]) for part in parts])
    source = feeler.types.Source(rounding=rounding)
    return feeler.Mockup(vertices, faces, of_face, [str(i) for i in range(len(parts))], source=source)


def in_single(parts: Sequence[Mesh]) -> tuple[list[Mesh], float]:
    """The parts rounded to single precision, and the largest rounding error, metres."""
    rounded = [(vertices.astype(np.float32).astype(np.float64), faces) for vertices, faces in parts]
    largest = max(np.abs(vertices).max() for vertices, _ in rounded)
    return rounded, 0.5 * float(np.spacing(np.float32(largest)))


def answers(mockup: feeler.Mockup, contact: float | None = None, clearance: float = 0.0) -> dict[Pair, Answer]:
    """All findings of a mock-up, by the indices of the parts."""
    limits: dict[str, Any] = {} if contact is None else {"contact": contact}
    found = feeler.clash(mockup, clearance=clearance, **limits)
    names = ("parts_a", "parts_b", "verdicts", "depths", "depth_errors", "depth_kinds")
    columns = [np.asarray(getattr(found, name)).tolist() for name in names]
    return {
        (a, b): Answer(verdict, depth, error, str(kind))
        for a, b, verdict, depth, error, kind in zip(*columns, strict=True)
    }


def asked(groups: Iterable[Group]) -> Iterator[Judged]:
    """Checks and judges all pairs of all groups."""
    for batch in _batches(groups):
        parts: list[Mesh] = []
        of_part: list[Pair] = []  # group, and part in it
        for number, group in enumerate(batch):
            i, j, k = number % 4, number // 4 % 4, number // 16
            placed = group.in_world(SPACING_M * np.array([i, j, k], float))
            parts += placed
            of_part += [(number, part) for part in range(len(placed))]
        found: list[dict[Pair, Answer]] = [{} for _ in batch]
        parts, of_file = in_single(parts) if batch[0].is_single else (parts, 0.0)
        for (a, b), answer in answers(mockup_of(parts, of_file), batch[0].contact, batch[0].clearance).items():
            (group_a, part_a), (group_b, part_b) = of_part[a], of_part[b]
            if group_a != group_b:
                yield Judged(batch[group_a].kind, False, True, False, None, f"{answer} of parts of two groups")
            else:
                found[group_a][part_a, part_b] = answer
        first = 0
        for group, rows in zip(batch, found, strict=True):
            sizes = [float(np.abs(part[0]).max()) for part in parts[first : first + len(group.parts)]]
            first += len(group.parts)
            for pair in group.facts:
                size = max(sizes[each] for each in pair)
                rounding = ROUNDED_BY * max(float(np.spacing(size)), of_file)
                result = judged(group, pair, rows.get(pair, Answer()), rounding)
                if result is not None:
                    yield result


def _batches(groups: Iterable[Group]) -> Iterator[list[Group]]:
    """Batches of groups with equal limits, as many as fit into one mock-up."""
    waiting: dict[tuple[float | None, float, bool], list[Group]] = {}
    for group in groups:
        limits = group.contact, group.clearance, group.is_single
        batch = waiting.setdefault(limits, [])
        triangles = group.triangles() + sum(each.triangles() for each in batch)
        if batch and (len(batch) == MOST_GROUPS or triangles > MOST_TRIANGLES):
            yield batch.copy()
            batch.clear()
        batch.append(group)
        # Rare limits: do not wait for another group with the same ones.
        if group.contact is not None and len(waiting) > MOST_GROUPS:
            yield waiting.pop(limits)
    yield from (batch for batch in waiting.values() if batch)


def judged(group: Group, pair: Pair, answer: Answer, rounding: float) -> Judged | None:
    """Judges one answer; None if several verdicts are possible. rounding: how much it may change a depth, metres."""
    facts = group.facts[pair]
    right = group.right.get(pair) or wanted(facts, group.contact, group.clearance, rounding * group.is_rounded)
    if right is None:
        return None
    is_wrong = answer.verdict not in right
    is_outside = False
    relative = None
    if answer.verdict not in ("none", "clearance") and not is_wrong:
        error = 0.0 if math.isnan(answer.error) else answer.error
        top = answer.depth + error
        is_outside = answer.kind != ("estimate" if facts.is_open else "measured")
        is_outside |= not (answer.depth <= facts.high + rounding and facts.low - rounding <= top)
        least = max(LEAST_ERROR_M, rounding) if group.is_single else LEAST_ERROR_M
        is_outside |= error > max(least, RELATIVE_ERROR * answer.depth) * (1 + 1e-9)
        if not facts.is_open and facts.low > LEAST_ERROR_M / RELATIVE_ERROR:
            relative = max(0.0, facts.low - rounding - answer.depth, answer.depth - facts.high - rounding) / facts.low
    says = "" if not (is_wrong or is_outside) else _report(group, pair, answer, right)
    return Judged(group.kind, facts.gap == 0, is_wrong, is_outside, relative, says)


def _report(group: Group, pair: Pair, answer: Answer, right: frozenset[str]) -> str:
    facts = group.facts[pair]
    sizes = [len(group.parts[part][1]) for part in pair]
    limit = "the default" if group.contact is None else f"{group.contact:.9g}"
    return (
        f"{group.kind}, parts {pair}, {sizes[0]} and {sizes[1]} triangles at {np.round(group.place * group.unit, 3)}, "
        f"contact {limit}: feeler says {answer.verdict}, depth {answer.depth:.12g} + {answer.error:.3g} "
        f"({answer.kind}); right is {' or '.join(sorted(right))}, D in [{facts.low:.12g}, {facts.high:.12g}]"
    )
