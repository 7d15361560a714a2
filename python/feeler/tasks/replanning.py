"""What plans of one question have found of the geometry, for the next plan: after an edit little is asked again."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.plan.catalogue import Catalogue
from feeler.plan.removal import Removal
from feeler.scene import Scene
from feeler.tasks.fixings import Fixings
from feeler.tasks.leading import Searched
from feeler.tasks.reached import Reaching, TaskTools

MOST_KEPT = 4
"""Scenes that are remembered, by the parts that are in them."""

Made = TypeVar("Made")


@dataclass
class Found:
    """What is known of one question in one scene."""

    fixings: Fixings
    question: Any
    ways: dict[Any, Removal] = field(default_factory=dict)
    searched: Searched = field(default_factory=Searched)
    actions: Any = None
    """The `Actions` of the last plan."""


class Memory:
    """For plans of a task that differ in times, in what is off already and in a forced order. For one thread at a
    time. Another mock-up, other tools or other pitches begin anew."""

    def __init__(self) -> None:
        self._mockup: Mockup | None = None
        self._setting: Hashable = None
        self._reaching: Reaching | None = None
        self._tools: TaskTools = None
        self._found: dict[Hashable, Found] = {}

    def reaching(self, scene: Scene, tools: TaskTools, threads: int | None, pitches: Mapping[str, float]) -> Reaching:
        """That of the last plan, where it serves."""
        setting = (_named(tools), tuple(pitches.items()))
        known = self._reaching
        if known is None or self._mockup is not scene.mockup or self._setting != setting or not known.covers(scene):
            self._found, self._mockup, self._setting, self._tools = {}, scene.mockup, setting, tools
            known = self._reaching = Reaching(scene, tools, threads)
        known.look_at(scene)
        return known

    def found(self, key: Hashable, scene: Scene, make: Callable[[], Found]) -> Found:
        """What is known of a question in a scene."""
        whole = (key, _mask(scene.part_mask))
        if whole not in self._found:
            while len(self._found) >= MOST_KEPT:
                del self._found[next(iter(self._found))]
            self._found[whole] = make()
        return self._found[whole]


def _mask(mask: npt.NDArray[np.bool_]) -> bytes:
    return np.packbits(mask).tobytes()


def _named(tools: object) -> Hashable:
    """Equal for equal tools and options, which nobody has checked yet. `Memory` holds them, so that ids stay theirs."""
    if isinstance(tools, Mapping):
        return tuple((name, _named(each)) for name, each in tools.items())
    if isinstance(tools, (list, tuple)):
        return tuple(_named(each) for each in tools)
    if isinstance(tools, Catalogue):
        return tools
    if tools is None or isinstance(tools, (str, int, float, np.generic, np.ndarray)):
        return repr(tools)
    return id(tools)
