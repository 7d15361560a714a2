"""Duration of a step in a tight fit, and of a cast along a bore. Like `engine`, an experiment that depends on time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler

from .. import fits
from ..faces import TICK_S, Face
from ..meshes import Mesh, mockup_of, tool_of
from ..poses import pose
from .engine import quantiles
from .fitting import colliding

STEPS = 1500
SINK_M = 3e-5  # a tick: the hand's step down a hole
ABOVE_M = 0.002  # the peg's tip over the mouth, at the start
ASIDE_M, TILT_RAD = 3e-4, 0.004  # how far the hand sways and leans: more than the play
TURNS = 1.5  # of the bolt
PUSH_M = 3e-4  # of the hand along the bolt: against the flanks
CASTS = 25


def run(make: Callable[..., Face], steps: int = STEPS) -> dict[str, Any]:
    """Times of a step of a peg and of a bolt both ways, and of casts down a bore to its bottom."""
    pair = fits.peg_in_hole("H7/g6", sides=fits.SIDES)
    rows = [_felt(make, "peg H7/g6", pair.hole, pair.peg, _down(steps))]
    nut, bolt = fits.bolt_in_nut()
    rows += [_felt(make, f"bolt M10 in its nut, {way}", nut, bolt, _turned(steps, s)) for way, s in BOLT_WAYS]
    return {"rows": rows, "casts": _casts()}


BOLT_WAYS = (("up", 1.0), ("down", -1.0))


def _felt(
    make: Callable[..., Face], what: str, fixed: Mesh, moving: Mesh, path: npt.NDArray[np.float64]
) -> dict[str, Any]:
    scene, tool = feeler.Scene(mockup_of(fixed), threads=1), tool_of(moving)
    face = make(scene, tool, seed=0)
    face.start(path[0])
    times, proxies = np.empty(len(path)), np.empty((len(path), 4, 4))
    for k, at in enumerate(path):
        begin = time.perf_counter()
        step = face.step(at, TICK_S)
        times[k] = time.perf_counter() - begin
        proxies[k] = step.world_from_proxy
    return {
        "what": what,
        "triangles": len(fixed[1]),
        "tool_triangles": len(moving[1]),
        "steps": len(path),
        "step_us": quantiles(times),
        "colliding_steps": colliding(scene, tool, proxies),
        "sunk_m": float(path[0][2, 3] - proxies[-1][2, 3]),
    }


def _down(steps: int) -> npt.NDArray[np.float64]:
    """The peg's hand: down, swaying and leaning by more than the play."""
    k = np.arange(steps, dtype=np.float64)
    places = np.stack([ASIDE_M * np.sin(k / 40), ASIDE_M * (np.cos(k / 33) - 1.0), ABOVE_M - SINK_M * k], axis=1)
    leans = np.stack([TILT_RAD * np.sin(k / 60), TILT_RAD * np.sin(k / 71), 0.0 * k], axis=1)
    return np.array([pose(place, lean) for place, lean in zip(places, leans, strict=True)])


def _turned(steps: int, sense: float) -> npt.NDArray[np.float64]:
    """The bolt's hand: along the thread, up or down, pushed against a flank."""
    angles = sense * 2 * np.pi * TURNS * np.arange(steps) / steps
    pushed = PUSH_M * np.minimum(1.0, np.arange(steps) / 100)
    heights = fits.PITCH_M * (2.0 + angles / (2 * np.pi)) - pushed
    return np.array([pose((0.0, 0.0, z), (0.0, 0.0, a)) for z, a in zip(heights, angles, strict=True)])


def _casts() -> list[dict[str, Any]]:
    block, shaft = fits.shaft_in_bore()
    scene, tool = feeler.Scene(mockup_of(block), threads=1), tool_of(shaft)
    above, low, below = (pose((0.0, 0.0, -z)) for z in (0.001, fits.BORE_M - 0.001, fits.BORE_M + 0.01))
    rows = []
    for way, end in (("free", low), ("to the bottom", below)):
        for touching in ("counts", "free"):
            times = np.empty(CASTS)
            for k in range(CASTS):
                begin = time.perf_counter()
                hit = scene.cast(tool, above, end, touching=touching)
                times[k] = time.perf_counter() - begin
            fraction = None if hit is None else hit.fraction
            rows.append({"way": way, "touching": touching, "fraction": fraction, "cast_us": quantiles(times)})
    return rows
