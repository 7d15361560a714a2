"""Undo and redo: the documents before a change, and those before an undo."""

from __future__ import annotations

from collections.abc import Callable

from feeler.errors import WorkbenchError
from feeler.workbench.document.document import Document

MOST_UNDO = 1000


class History:
    """Two stacks of documents. Not thread-safe: the session's lock is around it."""

    def __init__(self) -> None:
        self._undo: list[Document] = []
        self._redo: list[Document] = []

    @property
    def undo_depth(self) -> int:
        """How many changes can be undone."""
        return len(self._undo)

    @property
    def redo_depth(self) -> int:
        """How many can be done again."""
        return len(self._redo)

    def changed(self, before: Document) -> None:
        """Records a change of a document; redo is cleared."""
        self._undo.append(before)
        del self._undo[:-MOST_UNDO]
        self._redo.clear()

    def next(self, name: str) -> Document:
        """The result of "undo" or "redo". Raises `WorkbenchError` if there is none."""
        stack = self._undo if name == "undo" else self._redo
        if not stack:
            raise WorkbenchError(f"there is nothing to {name}", name, "change something first")
        return stack[-1]

    def stepped(self, name: str, now: Document) -> None:
        """Moves on: `next` is the new document, `now` the previous one."""
        here, there = (self._undo, self._redo) if name == "undo" else (self._redo, self._undo)
        here.pop()
        there.append(now)

    def revise(self, revised: Callable[[Document], Document]) -> None:
        """Applies a change to all documents in the history, for changes that the user did not make."""
        self._undo = [revised(each) for each in self._undo]
