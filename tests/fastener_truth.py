"""What the sample mock-ups know of their fasteners."""

from __future__ import annotations

from dataclasses import dataclass
from unittest import mock

import numpy as np
import numpy.typing as npt

import feeler
from feeler.samples import hardware
from feeler.samples.mesh import MeshParts, at
from feeler.samples.plan import Plan

KINDS = {hardware.hex_bolt: "bolt", hardware.cap_screw: "screw", hardware.nut: "nut"}


@dataclass(frozen=True)
class Truth:
    """One fastener of a sample."""

    kind: str
    size: float
    poses: npt.NDArray[np.float64]
    """(4, 4): of the shape's own frame, as its maker in `hardware` says."""


def sample_and_truth(name: str, triangles: int, seed: int = 0) -> tuple[feeler.Mockup, dict[str, Truth]]:
    """The sample, and its fasteners by path."""
    plans: list[Plan] = []
    build = Plan.build

    def kept(self: Plan, *args: object) -> MeshParts:
        plans.append(self)
        return build(self, *args)  # type: ignore[arg-type]

    with mock.patch.object(Plan, "build", kept):
        mockup = feeler.sample(name, triangles, seed)
    (plan,) = plans
    made = {id(shape): key for key, shape in plan._shapes.items()}
    truth = {}
    for item in plan.items:
        make, arguments = made.get(id(item.shape), (None, ()))
        if make not in KINDS:
            continue
        for path, pose in zip(item.names(len(item.poses)), item.poses, strict=True):
            truth[f"{plan.root}/{path}"] = Truth(KINDS[make], float(arguments[0]), pose)
    return mockup, truth


def tops(truth: Truth) -> list[npt.NDArray[np.float64]]:
    """Where the top of the head may be, (4, 4): a socket head that is cut coarsely is a little lower."""
    heights = {"bolt": (0.68,), "screw": (1.0, 0.9), "nut": (0.8,)}[truth.kind]
    return [truth.poses @ at(z=height * truth.size) for height in heights]
