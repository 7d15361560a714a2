"""What a server answers about: the mock-up and the tools that were named when it started. Nothing else is read."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.agent.answers import part_of_number
from feeler.agent.job import Job
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.errors import FeelerError, OptionError
from feeler.mockup import Mockup, Tool
from feeler.plan.catalogue import Catalogue
from feeler.plan.catalogue import catalogue as built_in
from feeler.progress import Progress
from feeler.samples import sample_tool
from feeler.scene import Scene

SAMPLE = "sample:"
KEPT_ANSWERS = 4
"""Answers of long calls that are kept, so that the next page of one is there at once."""
_WAIT_S = 0.1


@dataclass
class Served:
    """A mock-up with its index, and tools by name."""

    scene: Scene
    tools: Mapping[str, Tool] = field(default_factory=dict)
    named: Sequence[str] = ()
    """What the mock-up is called: names of files, without their folders, or of a sample."""
    catalogue: Catalogue = field(default_factory=built_in)
    """The tools that are chosen by drive and size."""

    def __post_init__(self) -> None:
        self._samples: dict[str, Tool] = {}
        self._kept: OrderedDict[str, Any] = OrderedDict()
        self._lock = threading.Lock()

    @property
    def mockup(self) -> Mockup:
        """The mock-up."""
        return self.scene.mockup

    def tool(self, name: str) -> Tool:
        """A tool by its name. Raises `OptionError` for a tool that was not named at the start."""
        if name in self.tools:
            return self.tools[name]
        plain = name.removeprefix(SAMPLE)
        if plain in SAMPLE_TOOL_NAMES:  # plain, it is the one that was named, if there is one
            with self._lock:
                return self._samples.setdefault(plain, sample_tool(plain))
        known = ", ".join([*self.tools, *(SAMPLE + each for each in SAMPLE_TOOL_NAMES)])
        raise OptionError(f"tool is {name[:80]!r}: choose {known}; other files cannot be opened from here")

    def select(self, argument: str, names: list[str]) -> npt.NDArray[np.uint32]:
        """The parts with these names, or that match these patterns, by index. Raises `OptionError`."""
        try:
            numbered = [part_of_number(self.mockup, name) for name in names]
            given = [name if parts is None else parts for name, parts in zip(names, numbered, strict=True)]
            return self.mockup.parts.select(
                [each for some in given for each in ([some] if isinstance(some, str) else some)]
            )
        except OptionError as error:
            raise OptionError(f"{argument}: {error} (the tool `parts` lists them)") from None

    def present(self, argument: str, names: list[str]) -> npt.NDArray[np.uint32]:
        """`select`, of the parts that are not left out of the mock-up."""
        found = self.select(argument, names)
        there = found[self.scene.part_mask[found]]
        if not len(there):
            raise OptionError(f"{argument}: these parts were left out when the server started")
        return there

    def standing(self, given: Mapping[str, Any]) -> Scene:
        """The mock-up without the parts that `without` names. Raises `OptionError`."""
        if not given.get("without"):
            return self.scene
        scene = self.scene.without(self.select("without", given["without"]))
        return _not_empty(scene)

    def moving(self, given: Mapping[str, Any]) -> tuple[Scene, Tool]:
        """The tool, or parts of the mock-up that move as one, and the parts that stay. Raises `OptionError`."""
        scene, tool, part = self.standing(given), given["tool"], given["part"]
        if tool is not None and part is not None:
            raise OptionError("give tool or part, not both")
        if part is not None:
            chosen = self.present("part", part)
            return _not_empty(scene.without(chosen)), Tool.of_parts(self.mockup, chosen)
        if tool is None and len(self.tools) == 1:
            return scene, next(iter(self.tools.values()))
        if tool is None:
            raise OptionError("nothing moves: give tool, or part for parts of the mock-up")
        return scene, self.tool(tool)

    def kept(
        self, tool: str, given: Mapping[str, Any], aside: Sequence[str], make: Callable[[], tuple[Any, bool]]
    ) -> Any:
        """What `make` returns, or what it returned for the same arguments, those in `aside` excepted.

        make: returns a result, and whether it is complete; only complete ones are kept.
        """
        key = json.dumps([tool, {name: given[name] for name in given if name not in aside}], default=_listed)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        made, is_complete = make()
        if is_complete:
            with self._lock:
                self._kept[key] = made
                while len(self._kept) > KEPT_ANSWERS:
                    self._kept.popitem(last=False)
        return made


def _not_empty(scene: Scene) -> Scene:
    if not scene.part_mask.any():
        raise OptionError("no part of the mock-up is left: name fewer parts")
    return scene


def _listed(value: Any) -> Any:
    return value.tolist()


class Opening:
    """Opens what is served while the server already runs, since clients do not wait for large files."""

    def __init__(self, open_: Callable[[Progress], Served]) -> None:
        self._open = open_
        self._is_over = threading.Event()
        self._share = (0.0, "opening the mock-up")
        self._served: Served | None = None
        self.error: BaseException | None = None
        """Why it could not be opened."""

    @property
    def is_over(self) -> bool:
        """Whether it is open, or could not be opened."""
        return self._is_over.is_set()

    def run(self) -> None:
        """Opens it, in the calling thread."""
        try:
            self._served = self._open(self._heard)
        except BaseException as error:  # the thread that serves raises it
            self.error = error
        self._is_over.set()

    def served(self, job: Job) -> Served:
        """What is served, when it is open. The job reports the progress of opening meanwhile, and may end it."""
        was_waiting = False
        while not self._is_over.wait(_WAIT_S if was_waiting else 0.0):
            was_waiting = True
            job.progress(*self._share)
        if was_waiting:
            job.next_step()
        if self._served is None:
            raise FeelerError("the mock-up could not be opened")
        return self._served

    def _heard(self, fraction: float, stage: str = "") -> None:
        self._share = (fraction, stage or "opening the mock-up")
