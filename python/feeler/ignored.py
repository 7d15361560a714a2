"""Pairs of parts that queries skip because they may touch, as in a robot's allowed collision matrix."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import shown, unmasked
from feeler.errors import MeshError, OptionError
from feeler.mockup import Mockup, Tool
from feeler.parts import PartsLike
from feeler.travel import reduced
from feeler.words import plural

MOST_PAIRS = 100_000_000
"""Most pairs that are listed one by one: 800 MB."""

Group = tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]
"""Two groups of parts, as indices: every combination of the two is a pair."""


class IgnoredPairs(_core.IgnoredPairs):
    """Pairs of a tool part and a mock-up part that queries skip: pass it as their `ignore=`.

    `pairs`: a list of pairs of tool parts and mock-up parts, each as `Parts.select` takes them: `[("hand", "*gasket*"),
    ("*", 17)]` means every combination of the two. An integer array `(k, 2)` of indices works as well. `ignore=` also
    takes such a list directly; an `IgnoredPairs` saves looking it up at each query.

    Raises `OptionError` for parts that do not exist, for entries that are not pairs, and for more than 100 million
    pairs.
    """

    pairs: npt.NDArray[np.uint32]
    """`(k, 2)`: indices of tool part and mock-up part; unique, sorted, read-only."""

    def __new__(
        cls, tool: Tool, mockup: Mockup, pairs: Iterable[tuple[PartsLike, PartsLike]] | npt.NDArray[np.integer[Any]]
    ) -> IgnoredPairs:
        """See the class."""
        given: tuple[object, object] = (tool, mockup)
        if not isinstance(given[0], Tool) or not isinstance(given[1], Mockup):
            raise MeshError("pairs to ignore are of a feeler.Tool and a feeler.Mockup")
        rows = pairs_of_parts(tool, mockup, pairs)
        return cls._restore(tool.part_count, mockup.part_count, rows)

    def __len__(self) -> int:
        return len(self.pairs)

    @overload
    def __getitem__(self, index: int) -> tuple[int, int]: ...
    @overload
    def __getitem__(self, index: slice) -> list[tuple[int, int]]: ...
    def __getitem__(self, index: int | slice) -> tuple[int, int] | list[tuple[int, int]]:
        if isinstance(index, slice):
            return [(a, b) for a, b in self.pairs[index].tolist()]
        a, b = self.pairs[operator.index(index)].tolist()
        return a, b

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self[:])

    def __repr__(self) -> str:
        return f"IgnoredPairs({plural(len(self), 'pair')})"

    def __reduce__(self) -> tuple[Any, ...]:
        return reduced("IgnoredPairs", (type(self), *self._counts, self.pairs))

    _counts: tuple[int, int]

    @classmethod
    def _restore(cls, tool_parts: int, parts: int, pairs: npt.NDArray[np.uint32]) -> IgnoredPairs:
        pairs = np.require(pairs, np.uint32, "C")
        self = super().__new__(cls, tool_parts, parts, pairs)
        pairs.flags.writeable = False
        self.pairs, self._counts = pairs, (tool_parts, parts)
        return self


Ignore: TypeAlias = IgnoredPairs | Iterable[tuple[PartsLike, PartsLike]] | None


def ignored(ignore: Ignore, tool: _core.Tool, mockup: Mockup) -> IgnoredPairs | None:
    """The argument `ignore=` of a query, looked up."""
    if ignore is None or isinstance(ignore, IgnoredPairs):
        return ignore
    if not isinstance(tool, Tool):
        raise MeshError(f"a feeler.Tool is needed, not {type(tool).__name__}")
    return IgnoredPairs(tool, mockup, ignore)


def pairs_of_parts(
    one: Tool | Mockup,
    other: Mockup,
    pairs: Any,
    option: str = "ignore",
    whose: tuple[str, str] = ("tool", "mock-up"),
) -> npt.NDArray[np.uint32]:
    """Pairs of parts as `IgnoredPairs` takes them, as indices `(k, 2)`; unique, sorted.

    option, whose: the names of the argument and the two meshes in errors. Raises `OptionError`, also for more than
    `MOST_PAIRS` pairs.
    """
    unmasked(option, pairs)
    if not isinstance(pairs, np.ndarray):
        return listed(groups_of_parts(one, other, pairs, option, whose), other.part_count, option)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu":
        raise OptionError(f"{option} has shape {pairs.shape} and dtype {pairs.dtype}: (k, 2) whole numbers are needed")
    for column, count, of in ((0, one.part_count, whose[0]), (1, other.part_count, whose[1])):
        outside = (pairs[:, column] < 0) | (pairs[:, column] >= count)
        if outside.any():
            raise OptionError(f"the {of} has no part {pairs[outside][0, column]}: it has {count}, 0 to {count - 1}")
    return _unique(_keys(pairs[:, 0], pairs[:, 1], other.part_count), other.part_count)


def groups_of_parts(
    one: Tool | Mockup,
    other: Mockup,
    pairs: Any,
    option: str = "ignore",
    whose: tuple[str, str] = ("tool", "mock-up"),
) -> list[Group]:
    """Pairs as `IgnoredPairs` takes them, except arrays: of each the two groups of parts, as indices.

    option, whose: as in `pairs_of_parts`. Raises `OptionError`.
    """
    if isinstance(pairs, (str, bytes)) or not isinstance(pairs, Iterable):
        raise OptionError(f"{option} is {shown(pairs)}: give pairs of parts, such as [('hand', '*gasket*')]")
    groups = []
    for pair in pairs:
        if isinstance(pair, (str, bytes)) or not hasattr(pair, "__len__") or len(pair) != 2:
            wanted = "of two parts" if whose[0] == whose[1] else f"of a {whose[0]}'s and a {whose[1]}'s part"
            raise OptionError(f"{option} holds {shown(pair)}: give pairs {wanted}")
        ours = _selected(one, pair[0], f"{option}, of the {whose[0]}")
        groups.append((ours, _selected(other, pair[1], f"{option}, of the {whose[1]}")))
    return groups


def listed(groups: Iterable[Group], count: int, option: str = "ignore") -> npt.NDArray[np.uint32]:
    """Every combination within each of the groups, `(k, 2)`; unique, sorted. count: of the parts on the second side.

    Raises `OptionError` for more than `MOST_PAIRS`.
    """
    given = list(groups)
    number = sum(len(ours) * len(theirs) for ours, theirs in given)
    if number > MOST_PAIRS:
        raise OptionError(f"{option} names {number:,} pairs of parts, and {MOST_PAIRS:,} are the most: use fewer")
    keys = [_keys(ours[:, None], theirs[None, :], count).ravel() for ours, theirs in given]
    return _unique(np.concatenate([np.empty(0, np.int64), *keys]), count)


def _keys(ours: npt.NDArray[Any], theirs: npt.NDArray[Any], count: int) -> npt.NDArray[np.int64]:
    """A number for each pair, in the order of the pairs."""
    return np.asarray(ours.astype(np.int64) * count + theirs.astype(np.int64))


def _unique(keys: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.uint32]:
    """The pairs of these numbers, `(k, 2)`; unique, sorted."""
    keys.sort()  # faster than np.unique, which looks up each number
    keys = keys[np.diff(keys, prepend=-1) > 0]
    return np.stack(np.divmod(keys, max(count, 1)), axis=1).astype(np.uint32)


def _selected(mesh: Tool | Mockup, parts: PartsLike, where: str) -> npt.NDArray[np.uint32]:
    try:
        return mesh.parts.select(parts)
    except OptionError as error:
        raise OptionError(f"{where}: {error}") from None
