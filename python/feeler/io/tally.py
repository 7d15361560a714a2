"""Counts elements of a file without triangles, by kind, with the first names."""

from __future__ import annotations

from feeler.io.raw import clean_name
from feeler.words import counted

_NAMES_SHOWN = 5
_NAME_LENGTH = 60


class Tally:
    """Counts by kind; `notes()` has a line for each kind, in the order of occurrence."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._names: dict[str, dict[str, None]] = {}
        self._doubtful: set[str] = set()

    def add(self, kind: str, name: object = "", count: int = 1, *, is_doubtful: bool = False) -> None:
        """Count an element. `kind` is a plural with its verb: "lines were left out: only triangles collide".

        is_doubtful: it makes answers about the mesh doubtful, so it is in `doubts()` and not in `notes()`.
        """
        if is_doubtful:
            self._doubtful.add(kind)
        self._counts[kind] = self._counts.get(kind, 0) + count
        known = self._names.setdefault(kind, {})
        label = clean_name(name, "")[:_NAME_LENGTH]
        if label and len(known) <= _NAMES_SHOWN:
            known[label] = None

    def notes(self) -> list[str]:
        """Return the notes: "3 hidden nodes were left out ('a', 'b', 'c')"."""
        return self._lines(is_doubtful=False)

    def doubts(self) -> list[str]:
        """Return the notes on what was counted as doubtful."""
        return self._lines(is_doubtful=True)

    def _lines(self, is_doubtful: bool) -> list[str]:
        lines = []
        for kind, count in self._counts.items():
            if (kind in self._doubtful) != is_doubtful:
                continue
            shown = [f"'{name}'" for name in self._names[kind]]
            more = ", ..." if len(shown) > _NAMES_SHOWN else ""
            lines.append(counted(count, kind) + (f" ({', '.join(shown[:_NAMES_SHOWN])}{more})" if shown else ""))
        return lines
