"""The answers of a nightly run in a file beside it, for the next run."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version

from feeler.tasks.digests import short
from feeler.tasks.memory import Answer, named_again

ENDING = ".answers"
"""Behind the name of the file of the run."""
MOST_BYTES = 512 * 2**20
"""Of answers in memory: those beyond it are not kept."""
_HEAD = f"feeler answers 2 of {version('feeler')}\n".encode()
_LEVEL = 3


class StoredAnswers:
    """The answers that the rows of a run used: bytes until they are asked for, or the other way round."""

    def __init__(self, paths: Sequence[str], data: bytes) -> None:
        """paths: the parts of the run, in the order of its snapshot. data: of `StoredAnswers.data`.

        Raises `ValueError` for data of another version.
        """
        if not data.startswith(_HEAD):
            raise ValueError(
                "they are of another version of feeler" if data[:7] == _HEAD[:7] else "they are no answers"
            )
        self._paths = list(paths)
        self._data: bytes | None = data
        self._known: tuple[list[Answer], dict[str, tuple[str, ...]]] | None = None
        self._before: tuple[StoredAnswers, Mapping[str, str]] | None = None
        """Those that these are with other paths."""

    @classmethod
    def of(cls, paths: Sequence[str], answers: Iterable[Answer], rows: Mapping[str, Sequence[str]]) -> StoredAnswers:
        """Those of rows, each with the names of the answers that it used."""
        wanted = {name for names in rows.values() for name in names}
        made = cls(paths, _HEAD)
        made._data = None
        made._known = [each for each in answers if each.name in wanted], {row: tuple(n) for row, n in rows.items()}
        return made

    def renamed(self, names: Mapping[str, str]) -> StoredAnswers:
        """The same with other paths: the new one by the one before; others stay."""
        made = StoredAnswers([names.get(path, path) for path in self._paths], _HEAD)
        made._data, made._before = None, (self, names)
        return made

    def __getstate__(self) -> tuple[list[str], bytes]:
        return self._paths, self.data

    def __setstate__(self, state: tuple[list[str], bytes]) -> None:
        self._paths, self._data = state
        self._known = self._before = None

    @property
    def data(self) -> bytes:
        """For a file."""
        if self._data is None:
            self._data = self._written()
        return self._data

    def _written(self) -> bytes:
        try:
            answers, rows = self.read()
        except ValueError:  # those with their paths before are damaged
            answers, rows = [], {}
        numbers = {path: number for number, path in enumerate(self._paths)}
        kept: dict[str, int] = {}
        lines: list[str] = []
        size = 0
        for answer in answers:
            line = json.dumps(answer.to_list(numbers))
            size += len(line)
            if size > MOST_BYTES:
                break
            kept[answer.name] = len(kept)
            lines.append(line)
        named = {row: [kept[name] for name in names if name in kept] for row, names in rows.items()}
        text = f'{{"answers": [{", ".join(lines)}], "rows": {json.dumps(named)}}}'
        return _HEAD + zlib.compress(text.encode(), _LEVEL)

    @property
    def digest(self) -> str:
        """Of its bytes."""
        return short(self.data)

    def read(self) -> tuple[list[Answer], dict[str, tuple[str, ...]]]:
        """The answers, and of rows the names of those that they used. Raises `ValueError` for damaged data."""
        if self._known is None:
            self._known = self._parsed() if self._before is None else self._named_again(*self._before)
        return self._known

    @staticmethod
    def _named_again(
        before: StoredAnswers, names: Mapping[str, str]
    ) -> tuple[list[Answer], dict[str, tuple[str, ...]]]:
        answers, rows = before.read()
        again = {each.name: named_again(each, names) for each in answers}
        return list(again.values()), {
            renamed_id(row, names): tuple(again[name].name for name in used) for row, used in rows.items()
        }

    def _parsed(self) -> tuple[list[Answer], dict[str, tuple[str, ...]]]:
        reader = zlib.decompressobj()
        try:
            text = reader.decompress(self.data[len(_HEAD) :], 2 * MOST_BYTES)
            if not reader.eof:
                raise ValueError("they are cut off or too large")
            data = json.loads(text)
            answers = [Answer.from_list(each, self._paths) for each in data["answers"]]
            rows = {str(row): tuple(answers[n].name for n in names) for row, names in data["rows"].items()}
        except (zlib.error, KeyError, TypeError, IndexError, AttributeError, RecursionError) as error:
            raise ValueError(f"they are damaged: {error}") from None
        return answers, rows


def renamed_id(key: str, names: Mapping[str, str]) -> str:
    """The key of a row with other paths; keys of another kind stay."""
    try:
        (parts, keep, people), end = json.JSONDecoder().raw_decode(key)
        some = [sorted(names.get(each, each) for each in paths) for paths in (parts, keep)]
    except (TypeError, ValueError):
        return key
    return json.dumps([*some, people]) + key[end:]
