"""Projects for scripts: `feeler.open_project`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NoReturn, cast

from feeler.arguments import check_flag, check_kind, check_path, check_text, shown
from feeler.atomic import atomic_file, check_target
from feeler.clashes.result import Clashes
from feeler.errors import FeelerError, OptionError, WriteError
from feeler.mockup import Mockup
from feeler.project.book import Book, open_or_make
from feeler.project.layout import SUFFIX
from feeler.project.lock import Lock
from feeler.project.opening import files_beside
from feeler.project.parts import PartChanges, contents_of, revised, rows_of
from feeler.project.rows import FindingChange, FindingRow, ProjectDocument
from feeler.project.store import Store


def open_project(path: str | os.PathLike[str], mockup: Mockup | None = None, *, read_only: bool = False) -> Project:
    """Opens a project file (`.feelproj`), as `feeler view --project` writes it.

    - `mockup`: if there is no such file, a project of this mock-up is made. The file keeps the content of each part,
      and no triangles.
    - `read_only`: reads a project that another process may be writing.

    One process at a time writes a project. Raises `MissingFileError`, `LoadError` for a file that is damaged, of a
    newer layout or no project, `ProjectError` if another process writes it, `WriteError`, and `OptionError`.
    """
    file = check_path("path", path)
    is_read_only = check_flag("read_only", read_only)
    if mockup is None or is_read_only:
        return Project(Book(Store(file, read_only=is_read_only, is_made=False)))
    check_kind("mockup", mockup, Mockup, "a feeler.Mockup, or None")
    book = open_or_make(file)
    try:
        if not book.parts():
            book.write(rows_of(contents_of(mockup)))
    except BaseException:
        book.close()
        raise
    return Project(book)


class Project:
    """An open project file; see `feeler.open_project`. Use it in a `with`, or call `close()`.

    All methods may be called from any thread. They raise `LoadError` for a damaged file, and `ProjectError` after
    `close()`; those that write raise `WriteError`, and `ProjectError` for a project that is open read-only.
    """

    def __init__(self, book: Book) -> None:
        self._book = book

    @property
    def path(self) -> str:
        """The file."""
        return self._book.path

    @property
    def is_read_only(self) -> bool:
        """Whether nothing can be written."""
        return self._book.is_read_only

    def document(self) -> ProjectDocument:
        """What the workbench shows, by field: `hidden`, `sections`, `sequence`, `measures`, `requirements`, ...

        A `feeler.types.ProjectDocument`: values are as in JSON, lengths in metres. Parts are numbers, which index
        `part_paths()`.
        """
        found = {row.id: self._book.value(row, "document") for row in self._book.rows("document")}
        for name in ("sequence", "measures", "viewpoints", "cards", "requirements"):
            table = {"viewpoints": "views"}.get(name, name)
            found[name] = [self._book.value(row, table) for row in self._book.rows(table)]
        return cast("ProjectDocument", found)

    def part_paths(self) -> list[str]:
        """The path of each part of the mock-up. Paths that several parts have end in `#2`, `#3` from the second on."""
        return [part.key for part in self._book.parts()]

    def changes(self, mockup: Mockup | None = None) -> PartChanges:
        """The parts that changed since the project's answers were computed: their answers are stale.

        mockup: a newer revision to compare with; None: the one that was opened last.
        """
        if mockup is None:
            known = self._book.parts()
            return self._book.part_changes(revised(known, self._book.gone(), known))
        return self._book.part_changes(self._book.revision(check_kind("mockup", mockup, Mockup)))

    def clashes(self) -> Clashes | None:
        """The findings of the last clash check, with their statuses and notes; None if there was none.

        Set statuses by `Clashes.set_status`, and write them by `write_clashes`.
        """
        return self._book.clashes()

    def findings(self) -> list[FindingRow]:
        """The findings as `feeler clash --json` lists them, in the order of the workbench.

        Rows are `feeler.types.FindingRow`s; `clashes()` has the same findings as a table.
        """
        return cast("list[FindingRow]", self._book.findings())

    def history(self, finding: str | None = None) -> list[FindingChange]:
        """Each change of a finding's status or note, or of those of all findings, the oldest first.

        A row, a `feeler.types.FindingChange`, has the `id` of the finding, `at` (UTC), and the new `status`, `by` and
        `note`.
        """
        wanted = None if finding is None else check_text("finding", finding, "the id of a finding, or None")
        return cast("list[FindingChange]", self._book.history(wanted))

    def write_clashes(self, clashes: Clashes) -> None:
        """Writes the findings of a clash check in place of the previous ones, and each change of a status or note.

        To keep the statuses, compare first: `clashes.diff(project.clashes())`. Raises `OptionError` if none of their
        parts is in the project.
        """
        self._book.write_clashes(check_kind("clashes", clashes, Clashes))

    def save_copy(self, path: str | os.PathLike[str]) -> None:
        """Writes the project as it is now to another file.

        Raises `OptionError` if that is this project, `ProjectError` if it is a project that is open, and `WriteError`.
        """
        target = Path(os.path.realpath(check_target(path, SUFFIX)))
        if target.exists() and target.samefile(self.path):
            raise OptionError(f"path is {shown(str(path))}, which is this project: give another file")
        data = self._book.copied()
        lock = Lock(target)
        try:
            for beside in files_beside(target):  # of a process that was killed: SQLite would add it to the copy
                beside.unlink()
            with atomic_file(target, SUFFIX) as file:
                file.write(data)
        except OSError as error:
            if isinstance(error, FeelerError):
                raise
            raise WriteError(f"cannot write {path}: {error.strerror or error}; choose another place") from None
        finally:
            lock.release()

    def close(self) -> None:
        """Closes the file, and lets other processes write it; a second call does nothing."""
        self._book.close()

    def __enter__(self) -> Project:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "" if self._book.is_open else " closed"
        return f"<feeler.Project {self.path!r}{' read-only' if self.is_read_only else ''}{state}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("a Project cannot be pickled or copied: open it by its path where it is needed")
