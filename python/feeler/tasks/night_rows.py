"""Rows of a nightly run: what was found of each, and how it differs from the last run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from feeler.field_docs import documented
from feeler.tasks.regions import Regions
from feeler.tasks.snapshots import MaintainChange

State = Literal["out", "blocked", "failed"]


@dataclass(frozen=True)
class Plan:
    """What `task` said of one row, in paths, and where it looked."""

    is_out: bool
    said: str
    seconds: float
    low: float
    high: float
    steps: int
    undone: int
    tools: tuple[str, ...]
    reach_deg: float
    is_unreachable: bool
    blockers: tuple[str, ...]
    looked: tuple[str, ...]
    """The parts that the steps of the plan depend on."""
    regions: Regions
    """Where the search looked."""
    is_cut: bool
    """Whether time ended it."""
    error: str

    @classmethod
    def failed(cls, error: str) -> Plan:
        """Of a row that has an error."""
        nan = math.nan
        regions = Regions.everything()
        return cls(False, "", nan, nan, nan, 0, 0, (), nan, False, (), (), regions, False, error)

    @property
    def state(self) -> State:
        """In a word."""
        return "failed" if self.error else "out" if self.is_out else "blocked"

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        row = {name: _plain(value) for name, value in vars(self).items()}
        return {**row, "regions": self.regions.to_dict()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plan:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        numbers = {name: _number(data[name]) for name in ("seconds", "low", "high", "reach_deg")}
        lists = {name: tuple(str(each) for each in data[name]) for name in ("tools", "blockers", "looked")}
        flags = {name: bool(data[name]) for name in ("is_out", "is_unreachable", "is_cut")}
        counts = {name: int(data[name]) for name in ("steps", "undone")}
        texts = {name: str(data[name]) for name in ("said", "error")}
        every: dict[str, Any] = {**numbers, **lists, **flags, **counts, **texts}
        return cls(**every, regions=Regions.from_dict(data["regions"]))


@dataclass(frozen=True)
class Seeing:
    """What is seen of one fastener when it is undone."""

    path: str
    share: float
    out: tuple[str, ...]
    """The parts that are out before."""
    box: tuple[float, ...]
    """Lower and upper corner of all that was looked at, metres."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return {"path": self.path, "share": self.share, "out": list(self.out), "box": list(self.box)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Seeing:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        box = tuple(float(each) for each in data["box"])
        if len(box) != 6:
            raise ValueError("a box has six numbers")
        return cls(str(data["path"]), float(data["share"]), tuple(str(each) for each in data["out"]), box)


@documented
@dataclass(frozen=True)
class MaintainRow:
    """One row: how parts of the list come out, and what is new since the last run."""

    name: str
    """What the list says."""
    paths: tuple[str, ...]
    """The wanted parts."""
    state: State
    """"out", "blocked", or "failed": then `error` says why."""
    seconds: float
    """The time of the best plan found; NaN without one."""
    low: float
    """Its time less its spread, seconds."""
    high: float
    """The time less and with its spread."""
    steps: int
    """How many steps its task has."""
    undone: int
    """Fasteners that are undone."""
    tools: tuple[str, ...]
    reach_deg: float
    """The least free swing of a tool, degrees; NaN without tools."""
    sight: float
    """The share that is seen of the fasteners that are undone, on average, each from the best eye; NaN without any."""
    hidden: tuple[str, ...]
    """Fasteners of which nothing is seen."""
    is_unreachable: bool
    """Whether it is blocked since no tool reaches a fastener."""
    blockers: tuple[str, ...]
    """If it is blocked: parts in the way."""
    said: str
    """The result in a sentence."""
    error: str
    is_kept: bool
    """Whether it was kept from the last run."""
    delta: float
    """Seconds more than in the last run; NaN if either has no time."""
    is_slower: bool
    """Whether it takes longer than in the last run, or came out then and does not now."""
    change: str
    """What is new, and which changes it is from; empty if nothing is, or if there was no last run."""
    causes: tuple[MaintainChange, ...]
    """The changes of the mock-up that the difference to the last run is from."""
    renamed_from: tuple[str, ...] = ()
    """The paths in the last run of those wanted parts that have other ones now."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        row = {name: _plain(value) for name, value in vars(self).items()}
        return {**row, "causes": [each.to_dict() for each in self.causes]}


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _number(value: Any) -> float:
    if value is None:
        return math.nan
    number = float(value)
    if not math.isfinite(number):
        raise ValueError("a number is not finite")
    return number
