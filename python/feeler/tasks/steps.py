"""What `task` answers: steps with their tools and times, totals, and what is blocked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from feeler.choices import TaskVerb
from feeler.field_docs import documented
from feeler.tasks.times import Element
from feeler.words import plural

Floats = npt.NDArray[np.float64]


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class TaskStep:
    """One step of a task."""

    number: int
    verb: TaskVerb
    """"undo", "disconnect" (it stays on its pipe), or "take out"."""
    part: str
    """The path of the fastener, or of the first part."""
    parts: tuple[int, ...]
    """All parts that leave with it, indices into `mockup.parts`; what is disconnected stays for now."""
    paths: tuple[str, ...]
    """The paths of `parts`."""
    tool: str
    """Empty: by hand, or without tools."""
    swing_deg: float
    """The free swing of the tool, degrees; NaN without one."""
    strokes: int
    """How often the tool is set on anew; 0 without a tool."""
    way: Floats
    """`(k, 4, 4)`: the motion of the parts in the world, from their place until they are out, as `Removal.poses`. A
    fastener is drawn off its thread. Empty where it was not checked."""
    tool_way: Floats
    """`(k, 4, 4)` world_from_tool: the tool's way in; empty without one."""
    person: int
    """Who does it, from 0."""
    start: float
    """Seconds from the beginning."""
    seconds: float
    spread: float
    """The standard deviation of its time, seconds."""
    after: tuple[int, ...]
    """Steps that have to be done before, by number; others can be done meanwhile."""
    looked: tuple[int, ...]
    """The parts that the step depends on: those whose boxes its motion, and its tool, can meet. While these do not
    change, the step holds."""
    because: str
    """Why it is done, in words."""
    arithmetic: str
    """How its time adds up."""

    @property
    def low(self) -> float:
        """Its time less its spread, seconds, 0 at least."""
        return max(0.0, self.seconds - self.spread)

    @property
    def high(self) -> float:
        """Its time and its spread, seconds."""
        return self.seconds + self.spread

    def __str__(self) -> str:
        return f"{self.verb} {self.part}" + (f" with {self.tool}" if self.tool else "")

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        row = {name: value for name, value in vars(self).items() if name not in ("way", "tool_way")}
        row |= {"low": self.low, "high": self.high, "way": self.way.tolist(), "tool_way": self.tool_way.tolist()}
        return row | {"swing_deg": None if math.isnan(self.swing_deg) else self.swing_deg}


@documented
@dataclass(frozen=True)
class TaskBlocker:
    """Something that nothing frees."""

    part: str
    """Its path."""
    because: str
    """Why it stays."""
    blockers: tuple[str, ...]
    """Paths of the parts in its way."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return dict(vars(self))


@dataclass(frozen=True, eq=False)  # its steps hold arrays
class TaskFacts:
    """How parts are taken out: the best plan that was found, in steps. See `task`."""

    parts: tuple[str, ...]
    """Paths of the wanted parts."""
    is_found: bool
    """Whether all wanted parts come out, and each way was checked."""
    steps: tuple[TaskStep, ...]
    """In order; empty if none was found. After Ctrl-C (`TaskInterrupted`), or if the time was up: those of the best
    plan until then, without their ways."""
    seconds: float
    """From the beginning to the end; NaN without steps."""
    spread: float
    """Its standard deviation, of the chain of steps that decides it."""
    bound: float
    """No plan of this model takes fewer seconds; NaN if there is none."""
    blocked: tuple[TaskBlocker, ...]
    """If no plan was found: what nothing frees, and why; if the search ended before it knew, what is in the way."""
    people: int
    """How many work."""
    is_complete: bool
    """Whether the search ended by itself, not at a limit."""
    elements: Mapping[str, Element]
    """The times of the elements."""
    examples: tuple[str, ...]
    """Those of them that are built-in examples."""
    notes: tuple[str, ...] = ()
    """What was not checked, and which times are examples."""

    def __bool__(self) -> bool:
        return self.is_found

    def __len__(self) -> int:
        return len(self.steps)

    @overload
    def __getitem__(self, index: int) -> TaskStep: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[TaskStep, ...]: ...
    def __getitem__(self, index: int | slice) -> TaskStep | tuple[TaskStep, ...]:
        return self.steps[index]

    def __iter__(self) -> Iterator[TaskStep]:
        return iter(self.steps)

    @property
    def low(self) -> float:
        """`seconds` less the spread."""
        return max(0.0, self.seconds - self.spread)

    @property
    def high(self) -> float:
        """`seconds` and the spread."""
        return self.seconds + self.spread

    @property
    def work(self) -> Element:
        """The seconds of all people together, and their spread."""
        return _total(self.steps)

    @property
    def tools(self) -> tuple[str, ...]:
        """The tools that are used, in order of their first use."""
        return tuple(dict.fromkeys(step.tool for step in self.steps if step.tool))

    @property
    def by_tool(self) -> dict[str, Element]:
        """Seconds and spread by tool; "" is by hand."""
        names = dict.fromkeys(step.tool for step in self.steps)
        return {name: _total([step for step in self.steps if step.tool == name]) for name in names}

    @property
    def by_person(self) -> dict[int, Element]:
        """Seconds of work and spread by person."""
        people = sorted({step.person for step in self.steps})
        return {person: _total([step for step in self.steps if step.person == person]) for person in people}

    @property
    def said(self) -> str:
        """The result in a sentence."""
        first = f": {self.blocked[0].part}: {self.blocked[0].because}" if self.blocked else ""
        if not self.is_found and not self.is_complete and math.isfinite(self.bound):
            return self._said_so_far + first
        if not self.is_found:
            return "blocked" + (first or ": no plan was found")
        total = f"best found: {plural(len(self.steps), 'step')}, {clock(self.seconds)} +- {clock(self.spread)}"
        return f"{total}, not below {clock(self.bound)}"

    @property
    def _said_so_far(self) -> str:
        """Of a search that ended early."""
        least = f"no plan is below {clock(self.bound)}"
        if not self.steps:
            return f"no plan so far; {least}" if self.bound > 0.0 else "no plan so far"
        total = f"{plural(len(self.steps), 'step')}, {clock(self.seconds)} +- {clock(self.spread)}"
        return f"best so far: {total}, its ways not checked; {least}"

    def __repr__(self) -> str:
        return f"Task({self.said})"

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return {
            "parts": list(self.parts),
            "is_found": self.is_found,
            "said": self.said,
            "seconds": _number(self.seconds),
            "low": _number(self.low),
            "high": _number(self.high),
            "bound": _number(self.bound),
            "is_complete": self.is_complete,
            "people": self.people,
            "tools": list(self.tools),
            "by_tool": {name: list(each) for name, each in self.by_tool.items()},
            "by_person": {str(person): list(each) for person, each in self.by_person.items()},
            "steps": [step.to_dict() for step in self.steps],
            "blocked": [each.to_dict() for each in self.blocked],
            "elements": {name: list(each) for name, each in self.elements.items()},
            "examples": list(self.examples),
            "notes": list(self.notes),
        }


def clock(seconds: float) -> str:
    """A duration for people: 42 s, 3 min 5 s, 1 h 2 min."""
    if math.isnan(seconds):
        return "unknown"
    whole = round(seconds)
    if whole < 60:
        return f"{seconds:.3g} s" if seconds < 10.0 else f"{whole} s"
    minutes, left = divmod(whole, 60)
    hours, minutes_left = divmod(minutes, 60)
    return f"{hours} h {minutes_left} min" if hours else f"{minutes} min {left} s"


def _total(steps: Sequence[TaskStep]) -> Element:
    return Element(math.fsum(step.seconds for step in steps), math.sqrt(math.fsum(step.spread**2 for step in steps)))


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
