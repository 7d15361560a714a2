"""The messages about tasks: a part of `protocol.py`."""

from __future__ import annotations

from typing import Literal, TypedDict

TaskEditKind = Literal["off", "on", "time", "before", "free"]


class TaskEdits(TypedDict):
    """What the user changed of a task."""

    off: list[str]
    """Paths of parts that are off already."""
    times: list[tuple[str, float]]
    """Paths of parts, and the seconds that were typed for their steps."""
    before: list[tuple[str, str]]
    """Pairs of paths: the first goes before the second."""
    table: str
    """A digest of the table of times; empty: the examples."""
    catalogue: str
    """A digest of the catalogue, where tools are chosen from it; empty: the built-in one."""


class TaskTimes(TypedDict):
    """The table of times that tasks use."""

    name: str
    """Of its file; empty: all figures are examples."""
    given: int
    """How many of the elements it gives."""


class TaskCatalogue(TypedDict):
    """The catalogue that tools of tasks are chosen from."""

    name: str
    """Of its file; empty: the built-in one."""
    tools: int
    """How many it has."""
