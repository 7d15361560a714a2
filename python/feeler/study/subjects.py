"""The subjects of a study: mock-ups and tools, made on demand, and the extent of the measurements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from feeler.progress import Progress

from ..mockup import Mockup, Tool

Thing = TypeVar("Thing", Mockup, Tool)


@dataclass(frozen=True)
class Subject(Generic[Thing]):
    """A mock-up or a tool by name; `make` loads or builds it. `key` separates subjects of one name."""

    name: str
    key: str
    make: Callable[[], Thing]


@dataclass
class Plan:
    """A study to run: output folder, subjects, extent."""

    folder: Path
    mockups: list[Subject[Mockup]]
    tools: list[Subject[Tool]]
    poses: int = 10
    rounds: int = 15
    sizes: int = 13
    seed: int = 0
    resume: bool = True
    memory_limit: int = 2_000_000_000
    """Bytes of the largest index to build; sizes that need more are skipped and reported."""
    progress: Progress = field(default=lambda _fraction, _stage: None)

    def pairs(self) -> list[tuple[Subject[Mockup], Subject[Tool]]]:
        """Every mock-up with every tool, mock-up by mock-up."""
        return [(mockup, tool) for mockup in self.mockups for tool in self.tools]


class Workshop:
    """Keeps the current mock-up, so that it is made once for all its tools, and frees the last one."""

    def __init__(self) -> None:
        self._name: tuple[str, str] | None = None
        self._mockup: Mockup | None = None

    def mockup(self, subject: Subject[Mockup]) -> Mockup:
        """The mock-up of a subject."""
        if self._mockup is None or self._name != (subject.name, subject.key):
            self._mockup = None
            self._mockup = subject.make()
            self._name = (subject.name, subject.key)
        return self._mockup
