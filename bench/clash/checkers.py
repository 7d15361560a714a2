"""The interface of clash checkers, feeler's implementation, the list of peers, and which of them are installed."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from contacts import Floats

import feeler
from feeler import Clashes, Verdict

CLEARANCE_M = 0.002
QUERIES = ("verdicts", "clearance", "depths")
"""Of a whole mock-up: colliding pairs, those within `CLEARANCE_M`, and the depths of clashes."""

Pairs = set[tuple[int, int]]
Faces = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Answer:
    """A checker's answer for a pair of parts.

    figure: metres; the gap of a clearance, 0 of a contact, else the depth; None where it says none. kind: how sure
    the depth is, where it says.
    """

    verdict: str
    figure: float | None = None
    kind: str | None = None


@dataclass(frozen=True)
class Whole:
    """A checker's results on a whole mock-up: seconds, its "index" and each query; and the pairs of each query.

    pairs[query]: part indices, the lesser first.
    """

    seconds: dict[str, float]
    pairs: dict[str, Pairs]


class Checker(Protocol):
    """A program that checks for clashes. How it is set up: the head of its module."""

    name: str
    version: str

    def pair(self, mockup: feeler.Mockup) -> Answer:
        """Of a mock-up of two parts."""
        ...

    def whole(self, mockup: feeler.Mockup, repeats: int) -> Whole:
        """Of all pairs of parts, one core; of each stage the least of its repeats."""
        ...


class FeelerChecker:
    """`feeler.clash` with its defaults, on one thread."""

    name = "feeler"
    version = feeler.__version__

    def pair(self, mockup: feeler.Mockup) -> Answer:
        """Of a mock-up of two parts."""
        rows = feeler.clash(mockup, CLEARANCE_M, threads=1)
        if not len(rows):
            return Answer("none")
        (row,) = rows
        is_apart = row.verdict in (Verdict.CONTACT, Verdict.CLEARANCE)
        figure = row.gap if is_apart else row.depth
        return Answer(row.verdict, figure, None if is_apart else row.depth_kind)

    def whole(self, mockup: feeler.Mockup, repeats: int) -> Whole:
        """Of all pairs of parts."""
        return whole(mockup, repeats, threads=1)


def whole(mockup: feeler.Mockup, repeats: int, threads: int | None, volume: bool = False) -> Whole:
    """The same on `threads` threads; with `volume`, also the time of the volumes, once."""
    indexed, scene = least(lambda: feeler.Scene(mockup, threads=threads), repeats)
    runs = [feeler.clash(mockup, CLEARANCE_M, scene=scene, threads=threads) for _ in range(repeats)]
    if volume:
        runs.append(feeler.clash(mockup, CLEARANCE_M, volume=True, scene=scene, threads=threads))
    stages: dict[str, list[float]] = {}
    for run in runs:
        for stage, seconds in run.facts.seconds:
            stages.setdefault(stage, []).append(seconds)
    found = {stage: min(seconds) for stage, seconds in stages.items()}
    return Whole({**found, "index": indexed}, pairs_of(runs[0]))


def pairs_of(rows: Clashes) -> dict[str, Pairs]:
    """The pairs of each query: those that are right, by which peers are judged."""
    deep = np.isin(rows.verdicts, (Verdict.CLASH, Verdict.CONTAINED, Verdict.DUPLICATE))
    chosen = {"verdicts": rows.gaps == 0.0, "clearance": rows.gaps <= CLEARANCE_M, "depths": deep}
    return {
        query: {(int(a), int(b)) for a, b in zip(rows.parts_a[mask], rows.parts_b[mask], strict=True)}
        for query, mask in chosen.items()
    }


def ordered(a: int, b: int) -> tuple[int, int]:
    """A pair, the lesser part first."""
    return (a, b) if a < b else (b, a)


def least(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """The least seconds of several calls, and the result of the last."""
    times = []
    result = None
    for _ in range(repeats):
        result = None  # its memory goes before the clock starts
        begun = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - begun)
    return min(times), result


def part_meshes(mockup: feeler.Mockup) -> Iterator[tuple[Floats, Faces]]:
    """Of each part its vertices, as they are, and faces."""
    order = np.argsort(mockup.part_of_face, kind="stable")
    ends = np.cumsum(mockup.part_triangles)
    for begin, end in zip(ends - mockup.part_triangles, ends, strict=True):
        used, faces = np.unique(mockup.faces[order[begin:end]], return_inverse=True)
        yield np.array(mockup.vertices[used]), np.asarray(faces, dtype=np.int64).reshape(-1, 3)


PEERS = {
    "ifcclash": ("clash.ifcclash_checker", "IfcclashChecker"),
    "python-fcl": ("clash.fcl_checker", "FclChecker"),
}
"""By name: module and class."""


def peers(names: Sequence[str]) -> tuple[list[Checker], dict[str, str]]:
    """The peers of these names that are there; and of the others, why not."""
    there: list[Checker] = []
    absent: dict[str, str] = {}
    for name in names:
        module, kind = PEERS[name]
        try:
            there.append(getattr(importlib.import_module(module), kind)())
        except ImportError as error:
            absent[name] = f"not installed ({error})"
    return there, absent
