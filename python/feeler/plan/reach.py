"""The results of `access`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import RowsLike, check_flag, check_kind, check_list, rows_at
from feeler.field_docs import documented
from feeler.plan.blocked import Blocker
from feeler.renamed import OldAttributes
from feeler.rows import read_only

Floats = npt.NDArray[np.float64]


@documented
@dataclass(frozen=True)
class TriedTool:
    """A tool of a catalogue that does not reach a target."""

    tool: str
    """Its name; of a chain that fails at its first pieces, these alone."""
    because: str
    """Why it does not reach."""
    blockers: tuple[Blocker, ...]
    """The parts in its way, most frequent first."""


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Reach(OldAttributes):
    """The result for one target; true if it is reachable."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"swing": "swing_deg", "angle": "angle_deg", "reachable": "is_reachable"}

    target: int
    """Index of the target."""
    part: int | None
    """Its fastener, index into `mockup.parts`: the tool may touch it. None: no part is near the target."""
    path: str | None
    """The path of that part; None if there is none."""
    is_reachable: bool
    """Whether there is a way in to a free swing that is large enough."""
    swing_deg: float
    """The largest free swing with a way in, degrees, 360 for a full turn; without a way in, the largest free swing.
    Never too large."""
    angle_deg: float
    """Where it begins, degrees about the target's z from its x axis, 0 to 360. NaN without a swing."""
    pose: Floats
    """`(4, 4)` world_from_tool: the tool seated in the middle of the swing; at angle 0 without one."""
    way: Floats
    """`(k, 4, 4)` world_from_tool: the way in, to a seat within the swing; `(0, 4, 4)` if none was found."""
    looked: float
    """The distance from the seat over which a way in was searched, metres: `approach`."""
    drawn: float
    """How far the tool came out of its seat at best, metres: `looked` if a way was found, 0 without a free seat."""
    because: str
    """The reason for the answer, in words."""
    blockers: tuple[Blocker, ...]
    """The blockers, most frequent first."""
    tool: str | None = None
    """The name of the tool that reaches it, of a catalogue the first that does; None if none does."""
    nearest: str | None = None
    """If none does: the name of the tool that came nearest, whose swing and pose these are; None if none fits."""
    stroke_deg: float = 0.0
    """The share of the swing that one stroke uses, degrees: of a catalogue's tool a multiple of its steps."""
    strokes: int | None = None
    """Strokes for the turns that were asked for; None if it is not reachable."""
    tried: tuple[TriedTool, ...] = ()
    """The tools of a catalogue that were tried before, and why they do not reach."""
    seen: float = float("nan")
    """The share of the head that the best eye sees, 0 to 1; NaN if no eyes were given."""

    def __bool__(self) -> bool:
        return self.is_reachable

    @property
    def comes_from(self) -> Floats:
        """`(3,)`: the direction from which the tool comes, unit, world; NaN if no way in was found."""
        if not len(self.way):
            return np.full(3, np.nan)
        along = self.way[0][:3, 3] - self.way[1][:3, 3]
        return read_only(np.asarray(along / np.linalg.norm(along)))


class Access(OldAttributes, Sequence[Reach]):
    """The results of `access`, one per target, in their order."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"swing": "swings_deg", "angle": "angles_deg", "reachable": "is_reachable"}

    def __init__(self, rows: Sequence[Reach], is_partial: bool = False) -> None:
        found = check_list("rows", rows, "a list of feeler.Reach")
        self._rows = tuple(check_kind("rows", row, Reach, "the rows of feeler.access") for row in found)
        self.is_partial = check_flag("is_partial", is_partial)
        """Whether it was interrupted, so that the last targets are missing."""

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Reach: ...
    @overload
    def __getitem__(self, index: RowsLike) -> list[Reach]: ...
    def __getitem__(self, index: int | RowsLike) -> Reach | list[Reach]:
        at = rows_at(index, len(self))
        return self._rows[at] if isinstance(at, int) else [self._rows[each] for each in at]

    def __iter__(self) -> Iterator[Reach]:
        return iter(self._rows)

    @property
    def is_reachable(self) -> npt.NDArray[np.bool_]:
        """`(n,)`."""
        return read_only(np.array([row.is_reachable for row in self._rows], dtype=bool))

    @property
    def swings_deg(self) -> Floats:
        """`(n,)`, degrees."""
        return read_only(np.array([row.swing_deg for row in self._rows], dtype=np.float64))

    @property
    def angles_deg(self) -> Floats:
        """`(n,)`, degrees; NaN without a swing."""
        return read_only(np.array([row.angle_deg for row in self._rows], dtype=np.float64))

    @property
    def blockers(self) -> tuple[Blocker, ...]:
        """The blockers of all unreachable targets together, most frequent first."""
        counts: Counter[tuple[int, str]] = Counter()
        for row in self._rows:
            if not row.is_reachable:
                counts.update({(each.part, each.path): each.count for each in row.blockers})
        return tuple(Blocker(part, path, count) for (part, path), count in worst_first(counts))

    @property
    def tools(self) -> dict[str, int]:
        """The tools that reach targets, and how many each, most frequent first."""
        counts = Counter(str(row.tool) for row in self._rows if row.is_reachable)
        return dict(worst_first(counts))

    def __repr__(self) -> str:
        partial = ", interrupted" if self.is_partial else ""
        return f"Access({int(self.is_reachable.sum()):,} of {len(self):,} reachable{partial})"


class AccessInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.access` has the answers for the targets finished by then."""

    def __init__(self, access: Access) -> None:
        self.access = access
        super().__init__(f"interrupted: {access!r}")

    def __reduce__(self) -> tuple[type[AccessInterrupted], tuple[Access]]:
        return (type(self), (self.access,))


def worst_first(counts: Counter[Any]) -> list[tuple[Any, int]]:
    """Entries by count, the largest first; equal ones in their order."""
    return sorted(counts.items(), key=lambda item: (-item[1], item[0]))
