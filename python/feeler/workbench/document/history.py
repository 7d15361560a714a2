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
        """A change was made of a document; what was undone is forgotten."""
        self._undo.append(before)
        del self._undo[:-MOST_UNDO]
        self._redo.clear()

    def next(self, name: str) -> Document:
        """What "undo" or "redo" leads to. Raises `WorkbenchError` where there is nothing."""
        stack = self._undo if name == "undo" else self._redo
        if not stack:
            raise WorkbenchError(f"there is nothing to {name}", name, "change something first")
        return stack[-1]

    def stepped(self, name: str, now: Document) -> None:
        """`next` is what is shown now; `now` is what was before."""
        here, there = (self._undo, self._redo) if name == "undo" else (self._redo, self._undo)
        here.pop()
        there.append(now)

    def revise(self, revised: Callable[[Document], Document]) -> None:
        """Changes all that undo leads to: for what is no change of the user's."""
        self._undo = [revised(each) for each in self._undo]
