"""With which tool a fastener is reached while some parts are out, remembered by what each question looked at."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from feeler.arguments import shown
from feeler.errors import MeshError, OptionError
from feeler.mockup import Tool
from feeler.parts import PartNumber
from feeler.plan.catalogue import Catalogue, catalogue, tool_of
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.reach import Reach
from feeler.plan.reaching import APPROACH_M, access, quickest
from feeler.plan.tool_seat import seated_tool
from feeler.scene import Scene
from feeler.tasks.digests import digest_of, facts_of
from feeler.tasks.regions import Columns
from feeler.tasks.times import strokes_for

Floats = npt.NDArray[np.float64]

HeldTool: TypeAlias = Tool | tuple[Tool, Mapping[str, Any]]
"""A tool, also with options of `access`."""
TaskTools: TypeAlias = (
    Catalogue | str | os.PathLike[str] | HeldTool | Sequence[HeldTool] | Mapping[str, HeldTool] | None
)
"""A catalogue, its TOML file, "built-in"; or tools: one, a list, a dict by name; None: all is reached."""
"""Instead of a file: the built-in catalogue."""
ASSUMED_DEG = 60.0
"""The swing without tools: nothing says more."""
NEAR_M = 1e-5
"""What boxes are grown by where they tell what a question looked at."""


@dataclass(frozen=True, eq=False)  # it holds arrays
class Tooled:
    """How a tool reaches a fastener."""

    tool: str
    swing_deg: float
    way: Floats
    """`(k, 4, 4)` world_from_tool: the way in; empty without a tool."""
    because: str
    stroke_deg: float
    """The share of the swing that one stroke uses, degrees."""


@dataclass(frozen=True)
class Reached:
    """The tools that reach a fastener, or the parts in their way."""

    tooled: tuple[Tooled, ...]
    blockers: tuple[int, ...]
    """The parts in the way of those that do not, the worst first."""
    looked: frozenset[int]
    """The parts whose boxes the tools, their swings and their ways in can meet: nothing else bears on the answer."""
    because: str


@dataclass(frozen=True)
class _Held:
    """A tool, and how `access` is to hold it."""

    name: str
    tool: Tool
    options: dict[str, Any]
    digest: str


@dataclass(frozen=True, eq=False)  # it holds an array
class _Told:
    """What `access` says of one fastener."""

    tool: str
    swing_deg: float
    stroke_deg: float
    """0 where it is not reached."""
    because: str
    way: Floats
    own: Counter[int]
    """How often parts are in the way of the tool."""
    tried: Counter[int]
    """And of all that were tried before it."""

    @classmethod
    def of(cls, answer: Reach, row: Fastener) -> _Told:
        """That of an answer, without the fastener itself."""
        stroke = (answer.stroke_deg or answer.swing_deg) if answer.is_reachable else 0.0
        own, tried = Counter({each.part: each.count for each in answer.blockers}), Counter[int]()
        for each in answer.tried:
            tried.update({block.part: block.count for block in each.blockers})
        for counts in (own, tried):
            counts.pop(row.part, None)
        return cls(answer.tool or "", answer.swing_deg, stroke, answer.because, answer.way, own, tried)

    def plain(self) -> list[Any]:
        """As scenes remember it."""
        counts = [[[PartNumber(part), n] for part, n in some.items()] for some in (self.own, self.tried)]
        return [self.tool, self.swing_deg, self.stroke_deg, self.because, self.way.tolist(), *counts]

    @classmethod
    def read(cls, data: Sequence[Any]) -> _Told:
        """What `plain` gave."""
        tool, swing, stroke, because, way, *counts = data
        own, tried = (Counter({int(part): n for part, n in each}) for each in counts)
        return cls(tool, swing, stroke, because, np.array(way).reshape(-1, 4, 4), own, tried)


class Reaching:
    """Asks which tools reach a fastener. `tools`: as `task` takes them."""

    def __init__(self, scene: Scene, tools: TaskTools, threads: int | None) -> None:
        self.scene, self.threads = scene, threads
        self.given = tools
        """The argument."""
        self.is_checked = tools is not None
        """Whether there are tools."""
        self.catalogue = _catalogue(tools)
        self.tools = () if self.catalogue is not None or tools is None else _tools(tools)
        self._off = frozenset[int]()
        self._boxes = Columns(scene.mockup.part_bounds.reshape(-1, 2, 3))
        self._near: dict[int, frozenset[int]] = {}
        self._known: dict[int, dict[frozenset[int], Reached]] = {}
        self._enough: dict[int, int] = {}
        self._ahead: dict[tuple[int, frozenset[int]], Reached] = {}
        self._digests: dict[int, str] = {}
        self._extents: dict[Any, tuple[float, float, float]] = {}
        self.asked = 0
        """Questions that were not answered from memory."""

    def covers(self, scene: Scene) -> bool:
        """Whether a scene is this one, or this one with less in it."""
        return scene.mockup is self.scene.mockup and not bool((scene.part_mask & ~self.scene.part_mask).any())

    def look_at(self, scene: Scene) -> None:
        """From now on asks in such a scene: what is not in it is out."""
        self._off = frozenset(np.flatnonzero(self.scene.part_mask & ~scene.part_mask).tolist())

    def reached(self, row: Fastener, out: frozenset[int], turns: float) -> Reached:
        """The answer while some parts are out. It is the same for all sets with the same parts out near the fastener:
        among those whose boxes meet that of the tools in any turn, and on any way in.

        It is also taken from other sets: what is out never blocks, so the strokes for `turns` of a set are between
        those of a smaller and of a larger one, and where no tool reaches, none does with less out. Parts that were in
        the way of no tool in a smaller set give no more room.
        """
        known, key = self._known.setdefault(row.part, {}), self._key(row, out)
        if key not in known:
            asked = self._between(known, key, turns) or self._ahead.pop((row.part, key), None)
            known[key] = asked or self.ask(row, out, turns, self.enough(row))
        if not self._off:
            return known[key]
        there = tuple(part for part in known[key].blockers if part not in self._off)
        return replace(known[key], blockers=there, looked=known[key].looked - self._off)

    def _key(self, row: Fastener, out: frozenset[int]) -> frozenset[int]:
        return (out | self._off) & self._around(row)

    def knows(self, row: Fastener, out: frozenset[int], turns: float) -> bool:
        """Whether the answer needs no geometry."""
        known, key = self._known.get(row.part, {}), self._key(row, out)
        is_known = key in known or (row.part, key) in self._ahead
        return is_known or self._between(known, key, turns) is not None

    def foretell(self, row: Fastener, out: frozenset[int], answer: Reached) -> None:
        """Has the answer of `ask` ready, where it will be asked."""
        self._ahead[row.part, self._key(row, out)] = answer

    def enough(self, row: Fastener) -> int | None:
        """The strokes below which no tool comes at a fastener, if they are known."""
        return self._enough.get(row.part)

    def at_best(self, row: Fastener, out: frozenset[int], turns: float) -> Reached:
        """The answer while all is out that can be: no tool needs fewer strokes with less out, so none is sought."""
        found = self.reached(row, out, turns)
        fewest = min((strokes for _, strokes in _strokes(found, turns)), default=0)
        self._enough[row.part] = max(fewest, strokes_for(turns, 360.0))
        return found

    @staticmethod
    def _between(known: dict[frozenset[int], Reached], key: frozenset[int], turns: float) -> Reached | None:
        """The answer for a set that follows from those for others."""
        larger = {_strokes(answer, turns): answer for other, answer in known.items() if other >= key}
        if () in larger:
            return larger[()]  # one of its blockers has to go, whatever else is
        for other, answer in known.items():
            # Without any of its blockers gone, an answer stays what it is.
            if other <= key and (_strokes(answer, turns) in larger or not (key - other).intersection(answer.blockers)):
                return answer
        return None

    def near(self, row: Fastener) -> frozenset[int]:
        """The parts that its answers can depend on."""
        return self._around(row) - self._off

    def _around(self, row: Fastener) -> frozenset[int]:
        if row.part not in self._near:
            found: set[int] = set()
            for lower, upper in self._rooms(row):
                found.update(np.flatnonzero(self._boxes.meeting(lower, upper) & self.scene.part_mask).tolist())
            self._near[row.part] = frozenset(found) - {row.part}
        return self._near[row.part]

    def ask(self, row: Fastener, out: frozenset[int], turns: float, enough: int | None) -> Reached:
        """The answer by the geometry. enough: strokes below which no tool comes there, None: not known; it does not
        bear on the answer."""
        self.asked += 1
        near, out = self._around(row), out | self._off
        if not self.is_checked:
            said = "without tools: its reach is not checked"
            return Reached((Tooled("", ASSUMED_DEG, np.empty((0, 4, 4)), said, ASSUMED_DEG),), (), near, said)
        scene = self.scene.without(sorted(out)) if out else self.scene
        if self.catalogue is not None:
            least = strokes_for(turns, 360.0) if enough is None else enough
            answers = self._quickest(scene, self.catalogue, row, turns, least)
            tooled = tuple(one for each in answers for one in _tooled(each, each.tool, each.because))
            return Reached(tooled, _in_the_way(answers), near, answers[-1].because)
        found: list[Tooled] = []
        blockers: Counter[int] = Counter()
        reasons = []
        for held in self.tools:
            told = self._told(scene, row, held)
            because = f"{held.name}: {told.because}" if len(self.tools) > 1 else told.because
            found += _tooled(told, held.name, because)
            if not told.stroke_deg:
                reasons.append(because)
            blockers.update(told.own)
        worst = tuple(sorted(blockers, key=lambda part: (-blockers[part], part)))
        return Reached(tuple(found), worst, near, "; ".join(reasons))

    def _told(self, scene: Scene, row: Fastener, held: _Held) -> _Told:
        """What `access` says of one fastener and tool."""

        def ask() -> list[Any]:
            answer = access(scene, held.tool, Fasteners([row]), threads=self.threads, **held.options)[0]
            return _Told.of(answer, row).plain()

        return _Told.read(scene._recalled("reach", [row.part], [held.digest, *facts_of(row)], ask))

    def _quickest(self, scene: Scene, tools: Catalogue, row: Fastener, turns: float, enough: int) -> list[_Told]:
        """What `quickest` says."""

        def ask() -> list[Any]:
            return [_Told.of(each, row).plain() for each in quickest(scene, tools, row, turns, enough)]

        # Tools beyond the first that is quick enough are not looked at.
        facts = [self._fitting(row), turns, enough, *facts_of(row)]
        return [_Told.read(each) for each in scene._recalled("quickest", [row.part], facts, ask)]

    def _fitting(self, row: Fastener) -> str:
        """The digest of all of a catalogue that bears on a fastener."""
        assert self.catalogue is not None
        if row.part not in self._digests:
            fitting = self.catalogue.fitting(row.drive, row.across_flats, row.size, row.width)
            self._digests[row.part] = digest_of(fitting or list(self.catalogue))
        return self._digests[row.part]

    def _rooms(self, row: Fastener) -> Iterator[tuple[Floats, Floats]]:
        """The boxes of what tools can meet at a fastener, on their way in too."""
        for held in self.tools:
            tool = seated_tool(held.tool, held.options.get("hand"), held.options.get("grip")).tool
            lift = float(held.options.get("lift", 0.0))
            yield _room(_extent(tool), row, lift, lift, float(held.options.get("approach", APPROACH_M)))
        if self.catalogue is not None:
            # The lower end of a tool is on the bearing face, in the recess, or above.
            deep = max(each for each in (row.head_height, row.length, row.size, 0.0) if math.isfinite(each))
            for pieces in self.catalogue.fitting(row.drive, row.across_flats, row.size, row.width):
                if pieces not in self._extents:
                    self._extents[pieces] = _extent(tool_of(pieces))
                yield _room(self._extents[pieces], row, -deep, deep, APPROACH_M)


def shape_of(tools: TaskTools, name: str) -> Tool:
    """The tool of a step in its own frame; tools: as `task` took them. Raises `OptionError` if it is not among them."""
    chosen = _catalogue(tools)
    if chosen is not None:
        return chosen.tool(name)
    known = {} if tools is None else {each.name: each.tool for each in _tools(tools)}
    if name not in known:
        raise OptionError(f"tools has no {name!r}: give the tools that the task was planned with")
    return known[name]


def _strokes(answer: Reached, turns: float) -> tuple[tuple[str, int], ...]:
    """Tools with their strokes; empty if none reaches."""
    return tuple((each.tool, strokes_for(turns, each.stroke_deg)) for each in answer.tooled)


def _tooled(told: _Told, name: str, because: str) -> tuple[Tooled, ...]:
    return (Tooled(name, told.swing_deg, told.way, because, told.stroke_deg),) if told.stroke_deg else ()


def _in_the_way(answers: Sequence[_Told]) -> tuple[int, ...]:
    """The parts in the way of tools, and of all that were tried, the worst first."""
    counts = answers[-1].tried.copy()
    for each in answers:
        counts.update(each.own)
    return tuple(sorted(counts, key=lambda part: (-counts[part], part)))


def _extent(tool: Tool) -> tuple[float, float, float]:
    """Its largest distance from its axis, its lowest and its highest point, metres."""
    far = float(np.hypot(tool.vertices[:, 0], tool.vertices[:, 1]).max())
    return far, float(tool.bounds[0, 2]), float(tool.bounds[1, 2])


def _room(
    extent: tuple[float, float, float], row: Fastener, lowest: float, highest: float, approach: float
) -> tuple[Floats, Floats]:
    """The box of all that a tool can meet at a fastener: turned about its axis, and on its way in."""
    far, bottom, top = extent
    radius = far + approach + NEAR_M
    low, high = bottom + lowest - NEAR_M, top + highest + approach + NEAR_M
    corners = np.array([[x, y, z] for x in (-radius, radius) for y in (-radius, radius) for z in (low, high)])
    world = corners @ row.frame[:3, :3].T + row.frame[:3, 3]
    return world.min(axis=0), world.max(axis=0)


def _catalogue(tools: TaskTools) -> Catalogue | None:
    """A catalogue, its file, or the built-in one; None for other tools."""
    if isinstance(tools, (str, os.PathLike)):
        return catalogue(tools)
    return tools if isinstance(tools, Catalogue) else None


def _tools(tools: TaskTools) -> tuple[_Held, ...]:
    """Tools by name: one, a list, or a dict of names; each may come with options of `access`."""
    if isinstance(tools, Mapping):
        named: list[tuple[object, object]] = list(tools.items())
    elif isinstance(tools, Sequence) and not isinstance(tools, (str, bytes)) and not _is_pair(tools):
        named = [(None, each) for each in tools]
    else:
        named = [(None, tools)]
    if not named:
        raise OptionError("tools is empty: give a feeler.Tool, or None not to check their reach")
    found = [_held(name, each) for name, each in named]
    twice = [each.name for n, each in enumerate(found) if each.name in {other.name for other in found[:n]}]
    if twice:
        raise OptionError(f"tools has two that are called {twice[0]!r}: give a dict of names and tools")
    return tuple(found)


def _held(name: object, given: object) -> _Held:
    pair: Any = given if _is_pair(given) else (given, {})
    tool, options = pair
    if not isinstance(tool, Tool):
        raise MeshError(f"tools has {shown(tool)}: give feeler.Tool, or (tool, options of feeler.access)")
    known = {"grip", "lift", "hand", "swing_deg", "approach", "angles"}
    odd = sorted(set(options) - known)
    if odd:
        raise OptionError(f"tools: the option {odd[0]!r} is unknown; options are {', '.join(sorted(known))}")
    if not isinstance(options.get("lift", 0.0), (int, float)) or not math.isfinite(options.get("lift", 0.0)):
        raise OptionError("tools: lift is one number of metres, for all fasteners")
    held = dict(options)
    return _Held(str(tool.name or "tool") if name is None else str(name), tool, held, digest_of([tool, held]))


def _is_pair(given: object) -> bool:
    return isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], Mapping)
