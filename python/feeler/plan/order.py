"""`feeler.removal_order`: what has to go before a part comes out."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import OptionError
from feeler.mockup import Tool
from feeler.parts import Part, PartsLike
from feeler.plan.removal import Allow, Progress, Removal, alone, removal
from feeler.scene import Scene

TRY_SHARE = 0.1
"""One try to find a way takes at most so much of all the time: blockers of blockers want theirs."""
LEAST_TRY_S = 0.25
MOST_DEEP = 8
"""Blockers of blockers of ...: how long such a chain may be."""


@dataclass(frozen=True)
class RemovalStep:
    """Parts that come out together, and their way, found in the mock-up without the parts of the steps before it."""

    parts: tuple[int, ...]
    removal: Removal


@dataclass(frozen=True)
class RemovalOrder:
    """Which parts go, in order, the wanted ones last.

    - `found`: whether the wanted parts come out by these steps. That they do not is no proof that they cannot.
    - `steps`: `RemovalStep`s in order. Where none was found: those that were, and the try of the wanted parts.
    - `seconds`: what it took.
    """

    found: bool
    steps: tuple[RemovalStep, ...]
    seconds: float

    @property
    def parts(self) -> tuple[int, ...]:
        """All that goes, in order; the wanted parts too."""
        return tuple(part for step in self.steps for part in step.parts)

    def __len__(self) -> int:
        return len(self.steps)

    def __iter__(self) -> Iterator[RemovalStep]:
        return iter(self.steps)

    def __repr__(self) -> str:
        said = f"{len(self.steps)} steps" if self.found else "not found"
        return f"RemovalOrder({said})"


def removal_order(
    scene: Scene,
    part: PartsLike,
    tool: Tool | None = None,
    start: npt.ArrayLike | None = None,
    allow: Allow = "start",
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 60.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    keep: PartsLike | None = None,
) -> RemovalOrder:
    """Which parts have to go before these come out, and the way of each.

    Arguments as of `feeler.removal`; `part` comes out together, with the tool; what goes before it goes without. Parts
    that blocked the most tries are left out first, until there is a way; of these only those stay on the list that
    this way meets, each with a way of its own, found in the same manner. So the list is short, with no promise that it
    is the shortest. `seconds` is for all of it; `keep` are parts that must not go, as `Parts.select` takes them.

    Raises what `feeler.removal` raises; Ctrl-C ends it.
    """
    if not seconds > 0.0:
        raise OptionError(f"seconds is {seconds}: give the time there is, more than 0")
    wanted = tuple(int(each) for each in scene.mockup.parts.select(part))
    kept = frozenset() if keep is None else frozenset(scene.mockup.parts.select(keep).tolist())
    search = _Search(scene, seconds, progress, allow, {"clearance": clearance, "seed": seed, "threads": threads})
    own = {"tool": tool, "start": start, "directions": directions}
    out = search.take_out(wanted, frozenset(), kept.union(wanted), own, 0)
    return RemovalOrder(out.found, tuple(out.steps), time.monotonic() - search.begun)


@dataclass
class _Out:
    """What it takes to take parts out; where that failed, the last step is the best try."""

    found: bool
    steps: list[RemovalStep]

    @property
    def gone(self) -> frozenset[int]:
        return frozenset(part for step in self.steps for part in step.parts)


class _Search:
    def __init__(
        self, scene: Scene, seconds: float, progress: Progress | None, allow: Allow, options: dict[str, Any]
    ) -> None:
        self.scene, self.seconds, self.progress, self.options = scene, seconds, progress, options
        given = [] if allow is None else [allow] if isinstance(allow, (str, float, int, Part)) else [*allow]
        self.allow: list[str | float | Part] = given
        self.begun = time.monotonic()
        self.tries = 0

    def take_out(
        self, parts: tuple[int, ...], gone: frozenset[int], fixed: frozenset[int], own: dict[str, Any], deep: int
    ) -> _Out:
        """Takes parts out of the scene without those that are gone; what is fixed may not go before them."""
        first = self._try(parts, gone, own)
        if first.found:
            return _Out(True, [RemovalStep(parts, first)])
        failed = _Out(False, [RemovalStep(parts, first)])
        if deep == MOST_DEEP:
            return failed
        while True:
            relaxed = self._without_blockers(parts, gone, fixed, own, first)
            if relaxed is None:
                return failed
            way, through = relaxed
            needed, way = self._needed(parts, gone, through, way, own)
            before = self._all_out(needed, gone, fixed | frozenset(parts), deep)
            if before.found:
                return self._last(parts, gone, before, way, own)
            # What cannot go itself is no longer looked at: another way round is needed.
            fixed |= frozenset(needed) - before.gone
            if self._is_over():
                return failed

    def _without_blockers(
        self, parts: tuple[int, ...], gone: frozenset[int], fixed: frozenset[int], own: dict[str, Any], first: Removal
    ) -> tuple[Removal, list[int]] | None:
        """A way through some blockers, and these; the worst first, twice as many each time."""
        through: list[int] = []
        tried, most = first, 1
        while not self._is_over():
            worst = [int(each.part) for each in tried.blocked_by]
            more = [each for each in worst if each not in fixed and each not in through][:most]
            if not more:
                return None
            through += more
            tried = self._try(parts, gone, own, through=through)
            if tried.found:
                return tried, through
            most *= 2
        return None

    def _needed(
        self, parts: tuple[int, ...], gone: frozenset[int], through: Sequence[int], way: Removal, own: dict[str, Any]
    ) -> tuple[list[int], Removal]:
        """Of the parts that it may go through those that the way meets, less those without which there is a way too."""
        needed = [each for each in through if self._is_met(parts, each, way, own)]
        for each in list(reversed(needed)):
            if len(needed) == 1 or self._is_over():
                break
            rest = [other for other in needed if other != each]
            tried = self._try(parts, gone, own, through=rest)
            if tried.found:
                needed, way = rest, tried
        return needed, way

    def _is_met(self, parts: tuple[int, ...], other: int, way: Removal, own: dict[str, Any]) -> bool:
        moving = Tool.of_parts(self.scene.mockup, list(parts))
        if own["tool"] is not None:
            place = np.eye(4) if own["start"] is None else own["start"]
            moving = Tool.assembly({"parts": moving, "tool": (own["tool"], place)})
        return not self.scene.only([other]).check_path(moving, way.poses, touching="free").free

    def _all_out(self, needed: Sequence[int], gone: frozenset[int], fixed: frozenset[int], deep: int) -> _Out:
        """Each of them out, in the order in which they can go."""
        steps: list[RemovalStep] = []
        pending = list(needed)
        away = gone
        free: dict[str, Any] = {"tool": None, "start": None, "directions": None}
        while pending:
            for each in pending:
                if self._is_over():
                    return _Out(False, steps)
                out = self.take_out((each,), away, fixed | {each}, free, deep + 1)
                if out.found:
                    steps += out.steps
                    away |= out.gone
                    pending = [other for other in pending if other not in away]
                    break
            else:
                return _Out(False, steps)
        return _Out(True, steps)

    def _last(
        self, parts: tuple[int, ...], gone: frozenset[int], before: _Out, way: Removal, own: dict[str, Any]
    ) -> _Out:
        """The parts after what blocked them. The way that is known holds, since what it met is gone; a new one may be
        shorter, and its clearance is to all that is left."""
        again = self._try(parts, gone | before.gone, own)
        return _Out(True, [*before.steps, RemovalStep(parts, again if again.found else way)])

    def _try(
        self, parts: tuple[int, ...], gone: frozenset[int], own: dict[str, Any], through: Sequence[int] = ()
    ) -> Removal:
        left = self.seconds - (time.monotonic() - self.begun)
        budget = max(LEAST_TRY_S, min(left, TRY_SHARE * self.seconds))
        self.tries += 1
        if self.progress is not None:
            self.progress(min(1.0, 1.0 - left / self.seconds), f"try {self.tries}, {len(gone)} parts gone")
        scene = self.scene.without(sorted(gone)) if gone else self.scene
        if int(scene.part_mask.sum()) == len(parts):
            return alone(int(self.options["seed"]))
        allow = [*self.allow, *(scene.mockup.parts[part] for part in through)]
        return removal(scene, list(parts), allow=allow, seconds=budget, **own, **self.options)

    def _is_over(self) -> bool:
        return time.monotonic() - self.begun >= self.seconds
