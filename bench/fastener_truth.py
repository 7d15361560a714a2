"""The true fasteners of the sample mock-ups, and how many of them `feeler.find_fasteners` finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from unittest import mock

import numpy as np
import numpy.typing as npt

import feeler
from feeler.arguments import check_word
from feeler.choices import SAMPLE_NAMES
from feeler.samples import hardware
from feeler.samples.mesh import MeshParts, at
from feeler.samples.plan import Plan

NEAR = 0.12
"""How far off the top of the head a frame may be, in thread diameters."""
ALONG = 0.9998
"""Cosine of how far off the axis it may be: a degree."""

KINDS: dict[Any, str] = {hardware.hex_bolt: "bolt", hardware.cap_screw: "screw", hardware.nut: "nut"}


@dataclass(frozen=True)
class Truth:
    """One fastener of a sample."""

    kind: str
    size: float
    poses: npt.NDArray[np.float64]
    """(4, 4): of the shape's own frame, as its maker in `hardware` says."""
    length: float = 0.0
    """From under the head to the tip; 0 for nuts."""


def sample_and_truth(name: str, triangles: int, seed: int = 0) -> tuple[feeler.Mockup, dict[str, Truth]]:
    """The sample, and its fasteners by path."""
    plans: list[Plan] = []
    build = Plan.build

    def kept(self: Plan, *args: Any) -> MeshParts:
        plans.append(self)
        return build(self, *args)

    with mock.patch.object(Plan, "build", kept):
        mockup = feeler.sample(check_word("name", name, SAMPLE_NAMES), triangles, seed)
    (plan,) = plans
    made: dict[int, Any] = {id(shape): key for key, shape in plan._shapes.items()}
    truth = {}
    for item in plan.items:
        if id(item.shape) not in made:
            continue
        make, arguments = made[id(item.shape)]
        if make in KINDS:
            for path, pose in zip(item.names(len(item.poses)), item.poses, strict=True):
                length = float(arguments[1]) if make is not hardware.nut else 0.0
                truth[f"{plan.root}/{path}"] = Truth(KINDS[make], float(arguments[0]), pose, length)
    return mockup, truth


def tops(truth: Truth) -> list[npt.NDArray[np.float64]]:
    """Where the top of the head may be, (4, 4): a socket head that is cut coarsely is a little lower."""
    heights = {"bolt": (0.68,), "screw": (1.0, 0.9), "nut": (0.8,)}[truth.kind]
    return [truth.poses @ at(z=height * truth.size) for height in heights]


def without_names(mockup: feeler.Mockup) -> feeler.Mockup:
    """The mock-up with parts that are numbered."""
    return feeler.Mockup(mockup.vertices, mockup.faces, mockup.part_of_face)


def scores(found: feeler.Fasteners, truth: dict[str, Truth], paths: Sequence[str]) -> tuple[float, float]:
    """Recall and precision; a fastener found is right if its place and direction are."""
    right = 0
    for row in found:
        known = truth.get(paths[row.part])
        right += known is not None and any(
            np.linalg.norm(top[:3, 3] - row.frame[:3, 3]) < NEAR * known.size and top[:3, 2] @ row.axis > ALONG
            for top in tops(known)
        )
    return right / len(truth), right / max(len(found), 1)
