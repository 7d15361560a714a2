"""The last run of `feeler maintain` in a project: read for the next one, and written."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from feeler.errors import LoadError
from feeler.project.parts import PartContent
from feeler.project.runs import RunRow, run_of, write_run
from feeler.tasks.run import packed, unpacked
from feeler.tasks.run_files import renamed_from, why

if TYPE_CHECKING:
    import feeler
    from feeler.project.book import Book


def last_run(book: Book) -> feeler.Maintenance | None:
    """The last run in a project; None if there is none. Raises `LoadError`."""
    kept = run_of(book)
    if kept is None:
        return None
    try:
        return unpacked(*kept, book.path)
    except ValueError as error:
        raise LoadError(
            f"{book.path} is damaged: its last run of feeler maintain is not as written ({error!s:.80}); use a copy"
        ) from None


def keep_run(book: Book, run: feeler.Maintenance, parts: Sequence[PartContent]) -> list[str]:
    """Writes a run into a project; returns hints. parts: of its mock-up. Raises `WriteError`."""
    data, answers = packed(run)
    shown: dict[str, Any] = {
        "said": run.said,
        "is_partial": run.is_partial,
        "rows": [_shown(row) for row in run.by_change],
        "contents": {part.key: part.content for part in parts},
    }
    if write_run(book, shown, data, answers):
        return []
    return [
        f"The answers of {len(answers or b'') / 1e6:,.0f} MB are too large for {book.path}, and left out: rows that "
        "change are computed in full. --save and --previous keep them."
    ]


def _shown(row: feeler.MaintainRow) -> RunRow:
    given = row.to_dict()
    more = {"hidden": len(row.hidden), "why": why(row), "renamed_from": renamed_from(row)}
    shown: Any = {name: _text(value) for name, value in {**given, **more}.items() if name in RunRow.__annotations__}
    found: RunRow = shown
    return found


def _text(value: Any) -> Any:
    """Names of files may have bytes that are no text."""
    if isinstance(value, list):
        return [_text(each) for each in value]
    return value.encode("utf-8", "replace").decode() if isinstance(value, str) else value
