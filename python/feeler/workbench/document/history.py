"""Undo and redo: the documents before a change, and those before an undo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from feeler.errors import WorkbenchError
from feeler.workbench.document.document import Document

MOST_UNDO = 1000


@dataclass(frozen=True)
class Step:
    """A change: its command, and who made it, as the session counts people."""

    command: str = ""
    by: int = 0


class History:
    """Two stacks of documents, each with the step between it and the next. Not thread-safe: the session's lock is
    around it."""

    def __init__(self) -> None:
        self._undo: list[Document] = []
        self._redo: list[Document] = []
        self._undo_steps: list[Step] = []
        self._redo_steps: list[Step] = []

    @property
    def undo_depth(self) -> int:
        """How many changes can be undone."""
        return len(self._undo)

    @property
    def redo_depth(self) -> int:
        """How many can be done again."""
        return len(self._redo)

    @property
    def last(self) -> str:
        """The command that would be undone; empty without one."""
        return self._undo_steps[-1].command if self._undo_steps else ""

    def is_empty(self, name: str) -> bool:
        """Whether there is nothing to "undo" or "redo"."""
        return not (self._undo if name == "undo" else self._redo)

    def changed(self, before: Document, step: Step = Step()) -> None:
        """Records a change of a document; redo is cleared."""
        self._undo.append(before)
        self._undo_steps.append(step)
        del self._undo[:-MOST_UNDO], self._undo_steps[:-MOST_UNDO]
        self._redo.clear()
        self._redo_steps.clear()

    def next(self, name: str) -> Document:
        """The result of "undo" or "redo". Raises `WorkbenchError` if there is none."""
        stack = self._undo if name == "undo" else self._redo
        if not stack:
            raise WorkbenchError(f"there is nothing to {name}", name, "change something first")
        return stack[-1]

    def stepped(self, name: str, now: Document) -> Step:
        """Moves on: `next` is the new document, `now` the previous one. The result is the step that was taken back, or
        again."""
        here, there = (self._undo, self._redo) if name == "undo" else (self._redo, self._undo)
        steps, others = self._undo_steps, self._redo_steps
        if name != "undo":
            steps, others = others, steps
        here.pop()
        there.append(now)
        others.append(steps.pop())
        return others[-1]

    def revise(self, revised: Callable[[Document], Document]) -> None:
        """Applies a change to all documents in the history, for changes that the user did not make."""
        self._undo = [revised(each) for each in self._undo]
