"""The subjects of a study: mock-ups and tools, made on demand, and the extent of the measurements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from feeler.field_docs import documented
from feeler.progress import Progress

from ..mockup import Mockup, Tool

Thing = TypeVar("Thing", Mockup, Tool)


@documented
@dataclass(frozen=True)
class Subject(Generic[Thing]):
    """A mock-up or a tool by name; `make` loads or builds it. `key` separates subjects of one name."""

    name: str
    key: str
    make: Callable[[], Thing]


@documented
@dataclass
class Plan:
    """A study to run: output folder, subjects, extent."""

    folder: Path
    mockups: list[Subject[Mockup]]
    """Each is measured with each tool."""
    tools: list[Subject[Tool]]
    """See `mockups`."""
    poses: int = 10
    """Of a tool in a mock-up, drawn at random by `seed`."""
    rounds: int = 15
    """How often each pose is measured."""
    sizes: int = 13
    seed: int = 0
    """Of all that is drawn at random."""
    resume: bool = True
    """Whether to go on with what is in the folder, instead of anew."""
    memory_limit: int = 2_000_000_000
    """Bytes of the largest index to build; sizes that need more are skipped and reported."""
    progress: Progress = field(default=lambda _fraction, _stage: None)
    """Told of the share that is done, 0 to 1, and the stage."""

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
