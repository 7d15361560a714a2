"""What a fastener clamps beside its shank: the profile above a T-slot nut, a slotted plate below a foot."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from feeler.plan.fasteners import Fastener
from feeler.scene import Scene
from feeler.tasks.passing import Windings, around, through

Floats = npt.NDArray[np.float64]

_SHARES = (0.6, 0.75, 0.9, 1.05)  # radii of rays beside a shank, in its diameters
_AROUND = 36  # rays of each radius
_LEAST = 0.15  # a clamped part is met by at least this share of the rays of one radius
_GAP = 0.04  # what is this near is in contact once the fastener is tight, in diameters
_LOOSE = 0.1  # the same where nothing nearer takes the force: a nut that hangs below its slot
_BEYOND = 1.0  # rays end this far behind the upper end of the thread, in diameters: a nut may have a neck


class _Layer(NamedTuple):
    """A part along one ray, metres from its origin."""

    begin: float
    end: float


def clamped_beside(
    windings: Windings, bare: Scene, row: Fastener, high: float, low: float, held: Iterable[int], end: int
) -> list[int]:
    """The parts beside a shank that are pressed between what it holds and what it is fastened in.

    windings: of the scene; bare: without fasteners and washers; high, low: where the held parts and the thread begin,
    in the frame of the fastener, metres; held: the parts that the shank passes through; end: what has the thread.
    """
    if not (np.isfinite(row.size) and row.size > 0.0 and low < high):
        return []
    play = _GAP * row.size
    origins, ways = _rays(row, high + play)
    length = high - low + play + _BEYOND * row.size
    above, others = set(held), set[int]()
    rest = bare.without(sorted({*above, end}))
    while True:
        # Of two flush faces a ray reports one. So it can miss a part between two others until these are left out.
        met = through(rest, origins, ways, np.full(len(origins), length))[1]
        more = {int(part) for part in np.unique(met) if part >= 0}
        if not more:
            break
        others |= more
        rest = rest.without(sorted(more))
    if not others:
        return []
    layers = {
        part: _layers(windings.scene.only([part]), origins, ways, length, windings.is_inside_out(part))
        for part in (*others, *above, end)
    }
    rays = [{part: rows[n] for part, rows in layers.items()} for n in range(len(origins))]
    borne = _bearing(rays, above, end, play)
    return _counted(rays, above, end, borne, play) or _counted(rays, above, end, borne, _LOOSE * row.size, {end})


def shoulder_below(alone: Scene, nut: Fastener, high: float, length: float) -> float | None:
    """The height at which a part that has the thread of a nut is wider than that, in the frame of the nut.

    alone: that part; high: of the face of the nut; length: how far below it is looked. None if it is nowhere.
    """
    if not (np.isfinite(nut.size) and nut.size > 0.0 and length > 0.0):
        return None
    origins, ways = _rays(nut, high)
    far = np.sort(through(alone, origins, ways, np.full(len(origins), length))[0][:, 0].reshape(-1, _AROUND), axis=1)
    found = far[:, math.ceil(_LEAST * _AROUND) - 1].min()
    return float(high - found) if np.isfinite(found) else None


def _rays(row: Fastener, height: float) -> tuple[Floats, Floats]:
    """Rays inwards beside a shank, from a height in the frame of a fastener: origins and directions."""
    ring = around(row.frame, _AROUND)
    origins = np.concatenate([share * row.size * ring for share in _SHARES]) + row.frame[:3, 3] + height * row.axis
    return origins, np.broadcast_to(-row.axis, origins.shape)


def _bearing(rays: list[dict[int, list[_Layer]]], above: set[int], end: int, play: float) -> set[tuple[int, int]]:
    """Which held parts bear on which, or on the end, and so by others: nothing has to be between these."""

    def touching(layers: dict[int, list[_Layer]]) -> set[tuple[int, int]]:
        return {
            (part, other)
            for part in above
            for other in (above - {part}) | {end}
            if any(abs(one.end - two.begin) <= play for one in layers[part] for two in layers[other])
        }

    found = _enough([touching(layers) for layers in rays])
    while more := {(a, d) for a, b in found for c, d in found if b == c and a != d} - found:
        found |= more
    return found


def _counted(
    rays: list[dict[int, list[_Layer]]],
    above: set[int],
    end: int,
    borne: set[tuple[int, int]],
    play: float,
    below: set[int] | None = None,
) -> list[int]:
    """The parts that are pressed between two that do not bear on each other, of which the lower is in `below`, if it is
    given."""
    pairs = [
        (part, other)
        for part in sorted(above)
        for other in sorted((above - {part}) | {end})
        if (part, other) not in borne and (below is None or other in below)
    ]
    return sorted(_enough([_pressed(layers, above | {end}, pairs, play) for layers in rays])) if pairs else []


def _enough(rays: list[set[Any]]) -> set[Any]:
    """What is true of enough rays of one radius."""
    found = set()
    for begin in range(0, len(rays), _AROUND):
        counts = Counter(each for ray in rays[begin : begin + _AROUND] for each in ray)
        found |= {each for each, count in counts.items() if count >= _LEAST * _AROUND}
    return found


def _layers(alone: Scene, origins: Floats, ways: Floats, length: float, is_inside_out: bool) -> list[list[_Layer]]:
    """Where each ray is in a part. alone: of that part, because rays miss faces that are flush with what they hit."""
    far, _, enters = through(alone, origins, ways, np.full(len(origins), length))
    found: list[list[_Layer]] = []
    for distances, are_entries in zip(far, enters != is_inside_out, strict=True):
        met = distances[np.isfinite(distances)].tolist()
        entries = are_entries[: len(met)].tolist()
        if met and not entries[0]:
            met, entries = [0.0, *met], [True, *entries]
        layers, depth, begin = [], 0, 0.0
        for at, is_entry in zip([*met, length], [*entries, False], strict=True):
            if is_entry and depth == 0:
                begin = at
            elif not is_entry and depth == 1:
                layers.append(_Layer(begin, at))
            depth = max(depth + (1 if is_entry else -1), 0)
        found.append(layers)
    return found


def _pressed(layers: dict[int, list[_Layer]], known: set[int], pairs: list[tuple[int, int]], play: float) -> set[int]:
    """The parts of one ray that touch the upper one of a pair, or a pressed part, above them, and so the lower one."""
    own = [(part, layer) for part, rows in layers.items() if part not in known for layer in rows]
    found = set()
    for part, other in pairs if own else ():
        down = _chained([layer.end for layer in layers[part]], own, play, 1)
        up = _chained([layer.begin for layer in layers[other]], own, play, -1) if down else set()
        found |= {own[n][0] for n in down & up}
    return found


def _chained(ends: list[float], own: list[tuple[int, _Layer]], play: float, way: int) -> set[int]:
    """Which layers follow one of some ends, or another such layer, along the ray or against it."""
    found: set[int] = set()
    while ends:
        at = ends.pop()
        for n, (_, layer) in enumerate(own):
            near, far = (layer.begin, layer.end) if way > 0 else (layer.end, layer.begin)
            if n not in found and abs(near - at) <= play:
                found.add(n)
                ends.append(far)
    return found
