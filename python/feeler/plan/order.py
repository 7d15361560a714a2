"""`feeler.removal_order`: what has to go before a part comes out."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from feeler.errors import OptionError
from feeler.mockup import Tool
from feeler.parts import PartsLike
from feeler.plan.removal import Allow, Removal, moving_tool, removal
from feeler.scene import Progress, Scene

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
) -> RemovalOrder:
    """Which parts have to go before these come out, and the way of each.

    Arguments as of `feeler.removal`; `part` comes out together, with the tool; what goes before it goes without. Parts
    that blocked the most tries are left out first, until there is a way; of these only those stay on the list that
    this way meets, each with a way of its own, found in the same manner. So the list is short, with no promise that it
    is the shortest. `seconds` is for all of it.

    Raises what `feeler.removal` raises; Ctrl-C ends it.
    """
    if not seconds > 0.0:
        raise OptionError(f"seconds is {seconds}: give the time there is, more than 0")
    wanted = tuple(int(each) for each in scene.mockup.parts.select(part))
    search = _Search(
        scene, seconds, progress, {"allow": allow, "clearance": clearance, "seed": seed, "threads": threads}
    )
    own = {"tool": tool, "start": start, "directions": directions}
    out = search.take_out(wanted, frozenset(), frozenset(wanted), own, 0)
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
    def __init__(self, scene: Scene, seconds: float, progress: Progress | None, options: dict[str, Any]) -> None:
        self.scene, self.seconds, self.progress, self.options = scene, seconds, progress, options
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
            way, left_out = relaxed
            needed, way = self._needed(parts, gone, left_out, way, own)
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
        """A way with some blockers left out, and these; the worst first, twice as many each time."""
        left_out: list[int] = []
        tried, most = first, 1
        while not self._is_over():
            worst = [int(each.part) for each in tried.blocked_by]
            more = [each for each in worst if each not in fixed and each not in left_out][:most]
            if not more:
                return None
            left_out += more
            tried = self._try(parts, gone | frozenset(left_out), own)
            if tried.found:
                return tried, left_out
            most *= 2
        return None

    def _needed(
        self, parts: tuple[int, ...], gone: frozenset[int], left_out: Sequence[int], way: Removal, own: dict[str, Any]
    ) -> tuple[list[int], Removal]:
        """Of the parts left out those that the way meets; of these not those without which there is a way as well."""
        needed = [each for each in left_out if self._is_met(parts, each, way, own)]
        for each in list(reversed(needed)):
            if len(needed) == 1 or self._is_over():
                break
            rest = [other for other in needed if other != each]
            tried = self._try(parts, gone | frozenset(rest), own)
            if tried.found:
                needed, way = rest, tried
        return needed, way

    def _is_met(self, parts: tuple[int, ...], other: int, way: Removal, own: dict[str, Any]) -> bool:
        moving = moving_tool(self.scene, parts, own["tool"], own["start"])
        return not self.scene.only([other]).check_path(moving, way.poses, touching="free").free

    def _all_out(self, needed: Sequence[int], gone: frozenset[int], fixed: frozenset[int], deep: int) -> _Out:
        """Each of them out, in the order in which they can go."""
        steps: list[RemovalStep] = []
        pending = list(needed)
        away = gone
        free: dict[str, Any] = {"tool": None, "start": None, "directions": None}
        while pending:
            for each in pending:
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

    def _try(self, parts: tuple[int, ...], gone: frozenset[int], own: dict[str, Any]) -> Removal:
        left = self.seconds - (time.monotonic() - self.begun)
        budget = max(LEAST_TRY_S, min(left, TRY_SHARE * self.seconds))
        self.tries += 1
        if self.progress is not None:
            self.progress(min(1.0, 1.0 - left / self.seconds), f"try {self.tries}: {len(gone)} parts gone")
        scene = self.scene.without(sorted(gone)) if gone else self.scene
        return removal(scene, list(parts), seconds=budget, **own, **self.options)

    def _is_over(self) -> bool:
        return time.monotonic() - self.begun >= self.seconds
