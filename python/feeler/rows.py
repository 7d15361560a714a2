"""Rows of results: whatever has a length can be indexed, sliced and iterated."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, overload

import numpy as np
import numpy.typing as npt

from feeler.field_docs import documented

if TYPE_CHECKING:
    from typing_extensions import Self

Row = TypeVar("Row")
AnyArray = TypeVar("AnyArray", bound=npt.NDArray[Any])


def read_only(column: AnyArray) -> AnyArray:
    """Makes a computed array read-only: its table would not see what a caller writes into it."""
    column.flags.writeable = False
    return column


class Columns(Generic[Row]):
    """A dataclass whose fields are columns of one length: `table[i]` is a row, `table[a:b]` a table."""

    _ROW: ClassVar[type[Any]]
    """The class of a row: its fields are those of the table, in order."""

    def __len__(self) -> int:
        return len(next(iter(vars(self).values())))

    @overload
    def __getitem__(self, index: int) -> Row: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    def __getitem__(self, index: int | slice) -> Row | Self:
        if isinstance(index, slice):
            return type(self)(*(column[index] for column in vars(self).values()))
        place = operator.index(index)
        if not -len(self) <= place < len(self):
            raise IndexError(f"row {place} of {len(self)}")
        values = (column[place] for column in vars(self).values())
        row: Row = self._ROW(*(each.item() if isinstance(each, np.generic) else each for each in values))
        return row

    def __iter__(self) -> Iterator[Row]:
        return (self[place] for place in range(len(self)))


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class RayHit:
    """The first hit of one ray."""

    distance: float
    """From the origin of the ray, metres."""
    point: npt.NDArray[np.float64]
    """`(3,)`: world, metres."""
    normal: npt.NDArray[np.float64]
    """`(3,)`: of the triangle, as in `Rays.normals`."""
    triangle: int
    """Of the mock-up."""
    part: int
    """Index into `mockup.parts`."""
