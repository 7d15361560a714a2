"""The parts of a mock-up or tool, and their lookup by path, name or pattern."""

from __future__ import annotations

import bisect
import difflib
import fnmatch
import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias, TypeVar, overload

import numpy as np
import numpy.typing as npt

from feeler import attributes as attributes_of
from feeler.arguments import check_text, mask_of, shown
from feeler.attributes import Attributes
from feeler.errors import OptionError
from feeler.field_docs import documented

_SIGN = re.compile(r"([*?[])")
_MOST_COMPARED = 10_000  # the most names compared with a wrong one: about a tenth of a second


def escaped(name: str) -> str:
    """The name as a part of a pattern: its own `*`, `?` and `[` stand for themselves."""
    return _SIGN.sub(r"[\1]", name)


@documented
@dataclass(frozen=True)
class Part:
    """One part of a mock-up or tool. `lower` and `upper` bound its queried triangles, metres; NaN if it has none.

    `attributes`: text by name, such as its material, as the file or the caller states it; a copy.
    """

    index: int
    """Into `mockup.parts`."""
    name: str
    path: str
    """Its names from the root on, joined by "/". Loaders give each part its own; `Mockup` takes what it is given."""
    triangles: int
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    attributes: dict[str, str] = field(default_factory=dict, compare=False)


PartsLike: TypeAlias = int | str | Part | Iterable[int | str | Part] | npt.NDArray[Any]
"""Parts, as arguments name them: see `Parts.select`."""
PartsKey: TypeAlias = int | str | Part | tuple[int | str | Part, ...] | frozenset[int | str | Part]
"""Parts as a key of a dict."""
OnePartsKey = TypeVar("OnePartsKey", bound=PartsKey)
"""The key of a dict whose keys are of one kind: the key of a `Mapping` is invariant."""


class PartNumber(int):
    """The index of a part, in what a scene may remember."""


class Parts(Sequence[Part]):
    """The parts of a mock-up or tool, by index; `find` and `select` look them up by path, name or pattern."""

    def __init__(
        self,
        names: Sequence[str],
        paths: Sequence[str],
        triangles: npt.NDArray[np.uint32],
        bounds: npt.NDArray[np.float64],
        attributes: Attributes | None = None,
    ) -> None:
        """`bounds`: (parts, 2, 3), crossed where a part is empty."""
        self._names, self._paths = names, paths
        self._triangles, self._bounds = triangles, bounds
        self._attributes = attributes

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, index: int) -> Part: ...
    @overload
    def __getitem__(self, index: slice) -> list[Part]: ...
    def __getitem__(self, index: int | slice) -> Part | list[Part]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if not hasattr(index, "__index__") or isinstance(index, bool):
            raise TypeError(f"a part is indexed by its number, not by {shown(index)}: parts.find(path) looks parts up")
        try:
            i = range(len(self))[index]
        except IndexError:
            raise IndexError(f"there is no part {index}: there are {len(self)}, 0 to {len(self) - 1}") from None
        lower, upper = self._bounds[i]
        if lower[0] > upper[0]:
            lower = upper = np.full(3, np.nan)
        own = {} if self._attributes is None else dict(self._attributes[i])
        return Part(i, self._names[i], self._paths[i], int(self._triangles[i]), _xyz(lower), _xyz(upper), own)

    def __repr__(self) -> str:
        first = ", ".join(map(repr, self._paths[:3])) + (", ..." if len(self) > 3 else "")
        return f"Parts({len(self):,}: {first})"

    def __iter__(self) -> Iterator[Part]:
        return (self[i] for i in range(len(self)))

    def __contains__(self, part: object) -> bool:
        # A part knows its index: none of the others is looked at.
        return isinstance(part, Part) and 0 <= part.index < len(self) and self[part.index] == part

    def find(self, path: str) -> list[Part]:
        """Parts whose path or name equals `path`, or whose path lies below it."""
        return [self[i] for i in self._called(check_text("path", path, "the path or name of a part"))]

    def search(self, query: str) -> npt.NDArray[np.uint32]:
        """The indices of the parts that have every word of a search, ascending; none for an empty one.

        A word is a part of the path, in any case. `material:steel` is a part of the path, or the part has an attribute
        `material` (or `....material`) whose value contains `steel`, in any case. A value with `*`, `?` or `[...]` is a
        pattern of the whole value, and `material:` asks for any. Quotes keep blanks together: `material:"cast iron"`.
        """
        check_text("query", query, "words of a path, or name:value of an attribute")
        return np.array(attributes_of.search(query, self._paths, self._attributes), dtype=np.uint32)

    def select(self, parts: PartsLike) -> npt.NDArray[np.uint32]:
        """The indices of the named parts, ascending, each once.

        `parts` is an index; a `Part`; a path or name, which includes everything below that path; a case-sensitive
        pattern with `*`, `?` or `[...]` that matches a whole path or name (`*` also matches `/`); a search of
        attributes such as `material:steel` (see `search`); or several of these. What is a path, a name or a pattern of
        one is no search. Booleans, an entry for each part, are a mask: an array, a list, a column of pandas or polars.
        Raises `OptionError` for parts that do not exist, with the similar names.
        """
        mask = mask_of(parts)
        if mask is not None:
            if mask.shape != (len(self),):
                raise OptionError(f"a mask of shape {mask.shape} does not fit {len(self)} parts: give one entry each")
            return np.flatnonzero(mask).astype(np.uint32)
        one = isinstance(parts, (str, bytes, Part, int, np.integer, np.bool_))
        if not one and (not isinstance(parts, Iterable) or (isinstance(parts, np.ndarray) and not parts.ndim)):
            raise OptionError(f"{shown(parts)} names no part: give an index, a path or pattern, or several")
        found: set[int] = set()
        for each in [parts] if one else parts:  # type: ignore[union-attr]
            found.update(self._selected(each))
        return np.array(sorted(found), dtype=np.uint32)

    def _selected(self, part: object) -> Iterable[int]:
        if isinstance(part, Part):
            i = part.index
            here = (self._names[i], self._paths[i], int(self._triangles[i])) if i < len(self) else None
            if (part.name, part.path, part.triangles) != here:  # not its box, which moves
                raise OptionError(f"part {i}, {part.path!r}, is of another mesh: give a part of this one, or its path")
            return [i]
        if isinstance(part, (int, np.integer)) and not isinstance(part, bool):
            if not 0 <= part < len(self):
                raise OptionError(f"there is no part {part}: there are {len(self)}, 0 to {len(self) - 1}")
            return [int(part)]
        if isinstance(part, (bool, np.bool_)):
            raise OptionError(f"{part} names no part: a mask is a list or an array, True or False for each part")
        if not isinstance(part, str):
            raise OptionError(f"{shown(part)} names no part: give an index, a path or a pattern")
        called = self._called(part)
        is_pattern = any(sign in part for sign in "*?[")
        if not called and is_pattern:
            matches = re.compile(fnmatch.translate(part)).match
            named = enumerate(zip(self._names, self._paths, strict=True))
            called = [i for i, (name, path) in named if matches(path) or matches(name)]
        if not called and attributes_of.asks_for_attributes(part):
            called = attributes_of.search(part, self._paths, self._attributes)
            if not called and self._attributes is not None:
                raise OptionError(f"no part has the path, name or attribute {part!r}{self._attributes_alike(part)}")
        if not called:
            alike = self._alike(part)
            hint = f"; do you mean {' or '.join(map(repr, alike))}?" if alike else ""
            raise OptionError(f"no part {'matches' if is_pattern else 'has the path or name'} {part!r}{hint}")
        return called

    def _alike(self, part: str) -> list[str]:
        """Names and paths that are similar to the given one, or contain a similar word; case is ignored."""
        known: dict[str, str] = {}
        for name in itertools.islice(dict.fromkeys([*self._names, *self._paths]), _MOST_COMPARED):
            plain = name.casefold()
            for word in (plain, *re.findall(r"\w+", plain)):
                known.setdefault(word, name)
        asked = re.sub(r"\[.*?\]|[*?]", "", part).strip("/ ").casefold()
        found = difflib.get_close_matches(asked, known, 3, 0.6)
        return list(dict.fromkeys(known[word] for word in found))

    def _attributes_alike(self, query: str) -> str:
        """What there is instead of the attributes that a search asks for."""
        known = attributes_of.names(self._attributes)
        folded = {ending: name for name in known for ending in (name.casefold(), name.casefold().rpartition(".")[2])}
        for term in attributes_of.terms(query):
            if term.name and term.name not in folded:
                alike = difflib.get_close_matches(term.name, list(folded)[:_MOST_COMPARED], 3, 0.6)
                close = list(dict.fromkeys(folded[each] for each in alike)) or known[:5]
                return f"; attributes are {', '.join(map(repr, close))}"
        return ""

    def _called(self, path: str) -> list[int]:
        base = path.rstrip("/")
        # Paths that start with base + "/" sort before base + "0", since "0" is the next character.
        first, last = (bisect.bisect_left(self._sorted_paths, (base + end, -1)) for end in "/0")
        return sorted({*self._by_name.get(path, ()), *(i for _, i in self._sorted_paths[first:last])})

    @cached_property
    def _by_name(self) -> dict[str, list[int]]:
        """The parts of each name and path."""
        found: dict[str, list[int]] = {}
        for i, (name, path) in enumerate(zip(self._names, self._paths, strict=True)):
            for called in {name, path}:
                found.setdefault(called, []).append(i)
        return found

    @cached_property
    def _sorted_paths(self) -> list[tuple[str, int]]:
        return sorted(zip(self._paths, range(len(self)), strict=True))

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self._names, self._paths, self._triangles, self._bounds, self._attributes))


def _xyz(v: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    return (float(v[0]), float(v[1]), float(v[2]))
