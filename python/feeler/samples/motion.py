"""A hand-like motion of a tool: into a mock-up from outside, some work in contact, and out again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from feeler.arguments import check_progress
from feeler.progress import Progress

from ..errors import OptionError
from ..mockup import Tool
from ..scene import Scene
from . import rigid
from .mesh import Floats
from .poses import Searcher, Slide, _check_count, _check_pair, _generator

APPROACHES = 24  # places tried; the one whose way in has the fewest collisions is taken
CHECKS = 12  # poses tested along each way in
REACH_SPEED_M_PER_S = 0.5
WORK_S = 0.7  # one working stroke
TREMOR = ((0.7, 1.2e-3), (1.9, 5e-4), (8.5, 1e-4))  # Hz, and metres for a tool of 0.3 m
TREMOR_TURN = 0.006  # radians


@dataclass(frozen=True, eq=False)
class Way:
    """An approach to a place: a slide, the points on it where the tool is just free and where it touches, the way
    out."""

    slide: Slide
    free: float
    touching: float
    out: Floats
    distance: float
    clashes: int


def sample_path(scene: Scene, tool: Tool, n: int, seed: int = 0, progress: Progress | None = None) -> Floats:
    """A hand-like motion: `(n, 4, 4) float64`, world_from_tool, metres, equally spaced in time.

    The tool comes from outside the mock-up's box, reaches a place where it is just free, pushes until 1 to 5 % of its
    triangles collide with the mock-up, works there (turning strokes about its z axis, releasing in between) and leaves.
    Each reach speeds up and slows down smoothly, with a small slow tremor. Of the places tried, it takes the one whose
    way in collides least. The same scene, tool, n and seed give the same poses, whatever the storage.

    Raises OptionError if n is less than 2, or if no place is found where the tool touches and is free nearby.
    """
    _check_pair(scene, tool)
    _check_count(n, 2)
    check_progress(progress)
    rng = _generator(seed, "path")
    searcher = Searcher(scene, tool, rng)
    way = _find_way(searcher, progress)
    positions, quaternions, durations = _keys(searcher, way)
    times = np.linspace(0.0, float(durations.sum()), n)
    position, quaternion = _interpolated(positions, quaternions, durations, times)
    position, quaternion = _shaken(position, quaternion, times, searcher.size, rng)
    if progress:
        progress(1.0, "done")
    return rigid.matrices(quaternion, position)


def _find_way(searcher: Searcher, progress: Progress | None) -> Way:
    best: Way | None = None
    found = 0
    for _ in range(1200):
        slide = searcher.slide()
        free = searcher.near(slide) if slide is not None else None
        if slide is None or free is None:
            continue
        from_free = Slide(slide.quaternion, slide.origin + free * slide.outward, slide.outward)
        push = searcher.nominal(from_free)
        if push is None or push > 0.0:
            continue
        for out in _ways_out(searcher, from_free):
            distance = _leaving_distance(searcher, from_free.pose(0.0), out)
            clashes = 0
            for share in np.linspace(0.0, 1.0, CHECKS + 1)[1:]:
                pose = from_free.pose(0.0)
                pose[:3, 3] += share * share * distance * out  # closer together near the work
                clashes += searcher.scene.is_colliding(searcher.tool, pose)
            if best is None or clashes < best.clashes:
                best = Way(slide, free, free + push, out, distance, clashes)
        found += 1
        if progress:
            progress(0.9 * found / APPROACHES, "finding a way in")
        if best is not None and (best.clashes == 0 or found >= APPROACHES):
            return best
    if best is None:
        raise OptionError(
            f"no place was found where a tool of {searcher.triangles} triangles and {searcher.size:.3g} m touches the "
            "mock-up and is free nearby; check that tool and mock-up have the same unit"
        )
    return best


def _ways_out(searcher: Searcher, slide: Slide) -> list[Floats]:
    """Directions worth trying: along the surface's normal, the tool's z, away from the mock-up's axis and middle."""
    pose = slide.pose(0.0)
    low, high = searcher.mockup_bounds
    from_middle = pose[:3, :3] @ searcher.tool_middle + pose[:3, 3] - 0.5 * (low + high)
    across = from_middle.copy()
    across[int(np.argmax(high - low))] = 0.0
    ways = [slide.outward, pose[:3, 2]]
    ways += [rigid.normalised(v) for v in (across, from_middle) if float(v @ v) > 1e-12]
    return ways


def _leaving_distance(searcher: Searcher, pose: Floats, out: Floats) -> float:
    """How far along `out` the tool must go to be outside the mock-up's box, with room to spare."""
    low, high = searcher.mockup_bounds
    farthest = float(np.where(out > 0.0, high, low) @ out)
    bounds = np.asarray(searcher.tool.bounds, dtype=np.float64)
    local = pose[:3, :3].T @ out
    nearest = float(np.where(local > 0.0, bounds[0], bounds[1]) @ local + pose[:3, 3] @ out)
    return max(0.0, farthest - nearest) + 0.3 * searcher.size


def _keys(searcher: Searcher, way: Way) -> tuple[Floats, Floats, Floats]:
    """Positions (k, 3), rotations (k, 4) and the seconds (k - 1,) from one to the next."""
    rng, size = searcher.rng, searcher.size
    base, slide = way.slide.quaternion, way.slide
    free = slide.origin + way.free * slide.outward
    touching = slide.origin + way.touching * slide.outward
    shaft = rigid.matrices(base[None], np.zeros((1, 3)))[0, :3, 2]

    def aside(scale: float) -> Floats:
        sideways = rng.normal(size=3)
        return np.asarray((sideways - way.out * float(sideways @ way.out)) * scale * size)

    def tilted(angle: float) -> Floats:
        return rigid.product(rigid.about(rigid.normalised(rng.normal(size=3)), float(rng.normal(0.0, angle))), base)

    close = min(way.distance, 0.2 * size)
    positions = [free + way.distance * way.out + aside(0.15), free + close * way.out + aside(0.004), free, touching]
    rotations = [tilted(0.3), tilted(0.02), base, base]
    seconds = [way.distance / REACH_SPEED_M_PER_S + 0.5, 0.8, 0.5]
    for _ in range(3):
        stroke = float(rng.uniform(0.12, 0.3))
        positions += [touching, free, free, touching]
        rotations += [rigid.product(rigid.about(shaft, stroke), base)] * 2 + [base] * 2
        seconds += [WORK_S, 0.4 * WORK_S, WORK_S, 0.4 * WORK_S]
    positions += [free, free + close * way.out + aside(0.004), free + way.distance * way.out + aside(0.15)]
    rotations += [base, tilted(0.02), tilted(0.3)]
    seconds += [0.5, 0.8, way.distance / REACH_SPEED_M_PER_S + 0.5]
    return np.array(positions), np.array(rotations), np.array(seconds)


def _interpolated(positions: Floats, quaternions: Floats, durations: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Positions (n, 3) and rotations (n, 4), by minimum-jerk reaches (Flash and Hogan 1985) between the keys."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    leg = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(durations) - 1)
    t = np.clip((times - starts[leg]) / durations[leg], 0.0, 1.0)
    share = t * t * t * (10.0 + t * (6.0 * t - 15.0))
    position = positions[leg] + share[:, None] * (positions[leg + 1] - positions[leg])
    quaternion = np.empty((len(times), 4))
    for k in range(len(durations)):
        here = leg == k
        quaternion[here] = rigid.slerp(quaternions[k], quaternions[k + 1], share[here])
    return position, quaternion


def _shaken(
    position: Floats, quaternion: Floats, times: Floats, size: float, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Adds the tremor of a hand: a few slow waves in each direction, and about each axis."""
    scale = min(1.0, size / 0.3)
    shift, turn = np.zeros((len(times), 3)), np.zeros((len(times), 3))
    for frequency, metres in TREMOR:
        phase = rng.uniform(0.0, 2.0 * np.pi, (2, 3))
        wave = 2.0 * np.pi * frequency * times[:, None]
        shift += scale * metres * np.sin(wave + phase[0])
        turn += TREMOR_TURN * metres / TREMOR[0][1] * np.sin(wave + phase[1])
    small = rigid.normalised(np.concatenate([np.ones((len(times), 1)), 0.5 * turn], axis=1))
    return position + shift, rigid.product(small, quaternion)
