"""All sessions and baselines, by name."""

from __future__ import annotations

import functools
from typing import Any

import feeler
from feeler import haptics

from .faces import Face, MakeFace
from .penalty import Penalty
from .point_shell import PointShell


def feeler_session(scene: feeler.Scene, tool: feeler.Tool, *, seed: int = 0, **options: Any) -> Face:
    """feeler's own."""
    return haptics.Session(scene, tool, seed=seed, **options)


def stiffened(face: str, stiffness_n_per_m: float) -> dict[str, Any] | None:
    """Options of a face's maker with that stiffness; None where the bench does not vary it."""
    if face != "feeler":
        return None
    return {"coupling": haptics.Coupling(stiffness_n_per_m=stiffness_n_per_m)}


def unshaded(face: str) -> MakeFace | None:
    """A face's maker without force shading; None where there is no such option."""
    return functools.partial(feeler_session, shading=False) if face == "feeler" else None


def makers() -> dict[str, MakeFace]:
    """All faces, by name."""
    return {"feeler": feeler_session, "penalty": Penalty, "point-shell": PointShell}
