"""The actions of a task: undo, disconnect and take out, each asked of the geometry once for all that it looks at."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.parts import PartNumber
from feeler.plan.blocking import DEEPER_M, DEEPER_SHARE, MOST_BLOCKERS, BlockingGraph, Joints, Mover
from feeler.plan.question import TARGET, Clock, Direction, Question
from feeler.plan.sequence import Exit
from feeler.scene import Scene
from feeler.tasks.ahead import Ahead
from feeler.tasks.captive import depth
from feeler.tasks.carried import Carried
from feeler.tasks.elastic import Rings
from feeler.tasks.fixings import Fixing, Fixings
from feeler.tasks.problem import Choice, Way
from feeler.tasks.reached import Reached, Reaching, Tooled
from feeler.tasks.times import Arithmetic, Timed, strokes_for
from feeler.tasks.together import Together

Floats = npt.NDArray[np.float64]

AXIS = "axis"
"""The motion of a fastener: out along its axis."""
DRAWN_SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
"""Where, on the way of a fastener, depths are measured."""
MOST_AT_ONCE = 400
"""A part that no direction with few blockers takes out may wait for this many other parts: a case that all is on."""
BOX_M = 1e-6
"""What boxes are grown by where they tell what a motion can touch."""


class _Graph(BlockingGraph):
    """What blocks parts, where the fasteners are those of `holds`."""

    def __init__(self, question: Together, clock: Clock, fixings: Fixings) -> None:
        super().__init__(question, clock)
        self._fixings = fixings
        self.rings = Rings(self, fixings)
        self._widened: set[int] = set()
        self._movers: dict[tuple[int, frozenset[int]], Mover] = {}

    def exits(self, node: int) -> list[Exit]:
        """As of the graph of a removal order; a ring leaves its groove first."""
        if node not in self._exits and node not in self.question.kept and node in self.rings:
            self.clock.tell(f"how {self.question.names([node])} leaves its groove")
            self._exits[node] = self.rings.exits(node)
        found = super().exits(node)
        if not found and node not in self._widened and self.clock.goes_on():
            self._widened.add(node)
            found = self.widened(node, MOST_AT_ONCE)
        return found

    def fastener_axes(self, parts: tuple[int, ...]) -> list[Floats]:
        """As of each graph. They are looked for anew, so that where that looks is noted for each question."""
        return [row.axis for row in Joints(self.question.scene, self.joints.look).among(parts)]

    def holding(self, node: int) -> frozenset[int]:
        """The fasteners that are undone before a part leaves."""
        if node not in self._holding:
            joints = joints_of(self.question, self._fixings, node)
            self._holding[node] = frozenset(next(iter(each)) for each in joints if len(each) == 1)
        return self._holding[node]

    def leaving(self, node: int) -> frozenset[int]:
        """The items that are out with a node."""
        question = self.question
        return question.leaving(node) if isinstance(question, Together) else frozenset([node])

    def against(self, item: int, direction: Direction, beside: Iterable[int] = ()) -> frozenset[int] | None:
        """The items in the way of one along a direction, but for some beside it; None if a kept one is, or many are."""
        question = self.question
        own = question.parts_of([item])
        passed = {*question.parts_of(beside), *question.parts_of(self.holding(item))} - set(own)
        key = (item, frozenset(passed))
        if key not in self._movers:
            self._movers[key] = Mover(self, item, frozenset(passed))
        found = self._movers[key].blockers(direction, MOST_BLOCKERS)
        return None if found is None else frozenset(map(question.node_of, found))


def joints_of(question: Question, fixings: Fixings, node: int) -> list[frozenset[int]]:
    """Of each joint of a part with others: the fasteners of which one has to be undone. Empty sets: none can be."""
    own = set(question.parts_of([node]))
    found: dict[frozenset[int], frozenset[int]] = {}
    for part in sorted(own):
        for fastener in fixings.by_joined.get(part, ()):
            if set(fixings.joins(fastener)) <= own and fastener not in question.kept:
                continue
            axis = frozenset([fastener, *(mate for mate in fixings.axis_mates(fastener))])
            found[axis] = axis - question.kept
    # A stud stays in its part.
    found |= {
        frozenset([stud]): frozenset()
        for stud in question.kept & fixings.studs.keys() - own
        if fixings.studs[stud] in own
    }
    return list(found.values())


class Actions:
    """The actions of a scene, as `Search` asks for them."""

    def __init__(
        self,
        question: Together,
        clock: Clock,
        fixings: Fixings,
        reaching: Reaching,
        times: Arithmetic,
        ahead: Ahead,
    ) -> None:
        self.question, self.clock, self.fixings, self.reaching, self.times = question, clock, fixings, reaching, times
        self.ahead = ahead
        self.graph = _Graph(question, clock, fixings)
        self.rings = self.graph.rings
        self.get_seconds = times.elements["get"].mean if reaching.is_checked else 0.0
        by_hand = min(times.elements[name].mean for name in ("take", "draw", "clip", "pin"))
        typed = [each.mean for each in times.times.typed.values()]
        self.quickest = min([by_hand + times.elements["aside"].mean, *typed])
        self._axis: dict[int, tuple[Way, ...]] = {}
        self._least: dict[int, float] = {}
        self._firsts: dict[int, float] = {}
        self._most: dict[int, frozenset[int]] = {}
        self._by_hand: dict[tuple[int, ...], Choice] = {}
        self._needed: dict[int, frozenset[int]] = {}
        self._holders: dict[int, list[frozenset[int]]] = {}
        self._loads: dict[int, tuple[int, ...]] = {}
        self._carried = Carried(question, fixings)
        self.met: dict[int, frozenset[int]] = {}
        """Of each fastener that a kept part stops on its axis: that part."""

    def know(self, other: Actions) -> None:
        """Takes over what other actions of the same question found of the geometry."""
        self.graph, self.rings, self._axis, self.met = other.graph, other.rings, other._axis, other.met
        self._most, self._holders, self._loads, self._carried = (
            other._most,
            other._holders,
            other._loads,
            other._carried,
        )
        self.graph.clock = self.clock

    def is_turned(self, item: int) -> bool:
        """Whether it is a fastener that a tool turns."""
        return item != TARGET and self.fixings.is_turned(item)

    def carriers(self, item: int) -> frozenset[int]:
        """As `Problem`."""
        return self._carried.carriers(item)

    def riding(self, item: int, off: frozenset[int] = frozenset(), on: frozenset[int] = frozenset()) -> frozenset[int]:
        """As `Problem`."""
        return self._carried.riding(item, off, on)

    def extensions(self, item: int, off: frozenset[int], on: frozenset[int]) -> Sequence[frozenset[int]]:
        """As `Problem`."""
        return self._carried.extensions(item, off, on)

    def is_smaller(self, one: int, other: int) -> bool:
        """Whether a part is smaller than another one, by its surface and by its reach."""
        return self._carried.is_smaller(one, other)

    def node(self, item: int, riding: frozenset[int]) -> int:
        """The node of the graph that is a part with what rides on it."""
        return self.question.with_riders(item, riding)

    def loads(self, item: int, riding: frozenset[int]) -> Sequence[int]:
        """As `Problem`: those that meet something along a direction in which the part alone does not, nor all other
        riders; and those that a bent way of the part alone meets."""
        node = self.node(item, riding)
        if node not in self._loads:
            parts = [each for each in sorted(riding) if each not in self.fixings]
            self._loads[node] = tuple(each for each in parts if self._is_met_more(item, each, riding))
        bent = frozenset[int]().union(*(one.blockers for one in self.graph.known(item)))
        met = sorted(each for each in bent & riding if each not in self.fixings)
        return tuple(dict.fromkeys((*self._loads[node], *met)))

    def _is_met_more(self, item: int, rider: int, riding: frozenset[int]) -> bool:
        """Whether a rider is in the way of its part in some direction."""
        body = riding | {item}
        for direction in self.graph.directions(self.node(item, riding)):
            self.clock.look()
            bare = self.graph.against(item, direction, riding)
            if bare is not None:
                found = self.graph.against(rider, direction, body)
                if found is None or found - body - bare:
                    return True
        return False

    def holders(self, item: int, riding: frozenset[int] = frozenset()) -> Sequence[frozenset[int]]:
        """As `Problem`."""
        node = self.node(item, riding)
        if node not in self._holders:
            turned = self.is_turned(item)
            self._holders[node] = [] if turned else joints_of(self.question, self.fixings, node)
            if item == TARGET:
                self._holders[node] += [frozenset([each]) for each in self.question.undone]
        return self._holders[node]

    def kept_holders(self, node: int) -> list[int]:
        """The kept fasteners that hold a part to what stays."""
        own = set(self.question.parts_of([node]))
        held = {each for part in own for each in self.fixings.by_joined.get(part, ())}
        return sorted(each for each in held & self.question.kept if not set(self.fixings.joins(each)) <= own)

    def certain(self, item: int) -> Sequence[frozenset[int]]:
        """The joints of a part that are undone in any case: those of it with all that can ride on it."""
        return self.holders(item, self.riding(item))

    def ways(self, item: int, riding: frozenset[int] = frozenset()) -> Sequence[Way]:
        """As `Problem`."""
        if self.is_turned(item):
            if item not in self._axis:
                self._axis[item] = self._along_axis(self.fixings.of(item))
            return self._axis[item]
        if item == TARGET and not self.question.wanted:
            return [Way((AXIS,), frozenset())]
        if item in self.fixings.studs:
            return []
        return [Way(one.motions, one.blockers) for one in self.graph.exits(self.node(item, riding))]

    def mates(self, item: int) -> frozenset[int]:
        """As `Problem`."""
        return frozenset(self.fixings.axis_mates(item)) - self.question.kept

    def tooled(self, item: int, out: frozenset[int]) -> tuple[Sequence[Choice], frozenset[int]]:
        """As `Problem`."""
        answer = self.answer(item, out)
        choices = [Choice(each.tool, self.undone(item, each).mean, each) for each in answer.tooled]
        return choices, self._nodes(answer.blockers) - {item}

    def expect(self, items: Sequence[int], out: frozenset[int] | None) -> None:
        """As `Problem`."""
        if not self.ahead.has_workers:
            return
        questions = []
        for item in items:
            if self.is_turned(item):
                fixing = self.fixings.of(item)
                assert fixing.row is not None
                gone = self.gone(self._most_out(item) if out is None else out - {item}) - {item}
                questions.append((fixing.row, gone, fixing.turns.count))
        self.ahead.reach(questions)

    def answer(self, item: int, out: frozenset[int]) -> Reached:
        """With which tools a fastener is reached while items are out."""
        self.clock.look()
        fixing = self.fixings.of(item)
        assert fixing.row is not None
        return self.reaching.reached(fixing.row, self.gone(out) - {fixing.part}, fixing.turns.count)

    def gone(self, out: Iterable[int]) -> frozenset[int]:
        """The parts that are away while items are out: union nuts and captive screws stay."""
        away = [item for item in out if not self.is_captive(item)]
        wanted = () if self.question.wanted else (TARGET,)
        return frozenset(self.question.parts_of(item for item in away if item not in wanted))

    def is_captive(self, item: int) -> bool:
        """Whether an undone fastener stays in the mock-up."""
        return self.is_turned(item) and self.fixings.captive_on(item) is not None

    def undone(self, item: int, tooled: Tooled) -> Timed:
        """The time to undo a fastener with a tool in hand."""
        fixing = self.fixings.of(item)
        strokes = strokes_for(fixing.turns.count, tooled.stroke_deg)
        last = ["slide"] if self.is_captive(item) else ["draw", "aside"]
        return self.times.undo(fixing.hold.path, fixing.turns, tooled.stroke_deg, strokes, last)

    def by_hand(self, items: Iterable[int]) -> Choice:
        """As `Problem`."""
        own = tuple(items)
        if own not in self._by_hand:
            self._by_hand[own] = Choice("", self.taken(own).mean, None)
        return self._by_hand[own]

    def taken(self, items: Sequence[int]) -> Timed:
        """The time of a step without a tool."""
        if TARGET in items and not self.question.wanted:
            return Timed(0.0, 0.0, "")
        first = self.question.parts_of(items[:1])[0] if items[0] == TARGET else items[0]
        path = self.question.scene.mockup.part_paths[first]
        if items[0] in self.fixings:
            kind = self.fixings.of(items[0]).hold.kind
            if kind in ("circlip", "pin", "dowel", "cotter"):
                return self.times.by_hand(path, ["clip" if kind == "circlip" else "pin", "aside"])
            return self.times.by_hand(path, ["draw", "aside"])
        return self.times.by_hand(path, ["take", "aside"])

    def least(self, item: int) -> float:
        """As `Problem`: with all out that can be out before, and a loose fastener by hand."""
        if item not in self._least:
            by_hand = self.by_hand([item]).seconds
            self._least[item] = min([self.first(item), *([by_hand] if self.mates(item) else [])])
        return self._least[item]

    def first(self, item: int) -> float:
        """As `Problem`: with all out that can be out before."""
        if item not in self._firsts:
            fixing = self.fixings.of(item)
            assert fixing.row is not None
            out = self.gone(self._most_out(item)) - {fixing.part}
            best = self.reaching.at_best(fixing.row, out, fixing.turns.count)
            self._firsts[item] = min((self.undone(item, each).mean for each in best.tooled), default=math.inf)
        return self._firsts[item]

    def needed(self, item: int) -> frozenset[int]:
        """As `Problem`: of the items in the way at first, those that are in it alone."""
        if item not in self._needed:
            found: set[int] = set()
            choices, blockers = self.tooled(item, frozenset())
            if not (choices or self.mates(item) or math.isinf(self.least(item))):
                most = self._most_out(item)
                found = {each for each in sorted(blockers & most) if not self.tooled(item, most - {each})[0]}
            self._needed[item] = frozenset(found)
        return self._needed[item]

    def _most_out(self, item: int) -> frozenset[int]:
        """All items that can be out before a fastener is undone: not what it alone holds, nor what is kept."""
        if item in self._most:
            return self._most[item]
        question = self.question
        stays = {TARGET, item, *question.kept, *self.fixings.studs}
        alone = frozenset([item])
        for part in self.fixings.joins(item):
            node = question.node_of(part)
            if alone in self.holders(node):
                stays.add(node)
        present = np.flatnonzero(question.scene.part_mask).tolist()
        self._most[item] = frozenset(question.node_of(part) for part in present) - stays
        return self._most[item]

    def _nodes(self, parts: Iterable[int]) -> frozenset[int]:
        """The items that have to leave for parts to be gone, but those that are kept."""
        question = self.question
        nodes = {question.node_of(part) for part in parts if part not in question.kept}
        return frozenset(nodes - question.kept - set(self.fixings.studs) - {TARGET})

    def _along_axis(self, fixing: Fixing) -> tuple[Way, ...]:
        """The way out along the axis, with all that is in it; none if something kept is."""
        question = self.question
        own = question.parts_of([fixing.part])
        ignored, far = self.ignored(fixing), self.drawn(fixing)
        facts = [far.tolist(), [PartNumber(part) for part in ignored]]
        deep, hits, _ = question.scene._recalled(
            "axis", own, facts, lambda: self._met_on(fixing, own, ignored), self._is_enough
        )
        kept = [part for part in deep if not self._nodes([part])]
        if kept:
            self.met[fixing.part] = frozenset(deep)
            return ()
        hits = [*hits, *self.fixings.locks(fixing.part)]
        kept = [part for part in hits if not self._nodes([part])]
        if kept:
            self.met[fixing.part] = frozenset(kept[:1])
            return ()
        return (Way((AXIS,), self._nodes([*deep, *hits])),)

    def _is_enough(self, told: Sequence[Any]) -> bool:
        """Whether what was met on an axis is all of it, or has something that is kept."""
        deep, hits, is_all = told
        return is_all or not all(self._nodes([part]) for part in [*deep, *hits])

    def _met_on(self, fixing: Fixing, own: Sequence[int], ignored: Sequence[int]) -> list[Any]:
        """What a fastener enters deeper on its axis; what it hits, up to the first that is kept; if that is all."""
        scene = self.question.scene
        tool, rest = Tool.of_parts(scene.mockup, list(own)), scene.without(list(own))
        passed = set(ignored)
        entered = self._deep(rest, tool, passed)
        deep = [PartNumber(part) for part in sorted(self._deepening(rest, tool, fixing, entered))]
        hits: list[PartNumber] = []
        if not all(self._nodes([part]) for part in deep):
            return [deep, hits, False]
        passed |= entered
        pose, far = np.eye(4), self.drawn(fixing)
        while True:
            self.clock.look()
            ignore = [("*", sorted(passed))] if passed else None
            hit = rest.cast(tool, pose, far, touching="free", ignore=ignore)
            if hit is None:
                return [deep, hits, True]
            hits.append(PartNumber(hit.part))
            if not self._nodes([hit.part]):
                return [deep, hits, False]
            passed.add(hit.part)
            pose = hit.pose

    def _deep(self, rest: Scene, tool: Tool, passed: set[int]) -> set[int]:
        """The parts that a fastener crosses at its place, such as the facets of its hole."""
        contacts = rest.collide(tool, np.eye(4), ignore=[("*", sorted(passed))] if passed else None)
        crossing = contacts.pairs[contacts.kinds == "crossing", 1]
        return set(np.unique(self.question.scene.mockup.part_of_face[crossing]).tolist())

    def _deepening(self, rest: Scene, tool: Tool, fixing: Fixing, parts: set[int]) -> set[int]:
        """Those of them that it enters deeper on its way, by samples."""
        found: set[int] = set()
        for part in sorted(parts):
            alone = rest.only([part])
            limit = DEEPER_M + (1.0 + DEEPER_SHARE) * depth(alone, tool, np.eye(4))
            for share in DRAWN_SHARES:
                self.clock.look()
                if depth(alone, tool, self.drawn(fixing, share)) > limit:
                    found.add(part)
                    break
        return found

    def drawn(self, fixing: Fixing, share: float = 1.0) -> Floats:
        """The motion of a fastener when it is drawn, or a share of it, (4, 4)."""
        assert fixing.row is not None
        far = np.eye(4)
        far[:3, 3] = share * fixing.travel * fixing.row.axis
        return far

    def ignored(self, fixing: Fixing) -> list[int]:
        """What a fastener may meet on its axis: its thread, and what it is on."""
        more = [fixing.hold.anchor, self.fixings.captive_on(fixing.part), *fixing.hold.mates]
        return sorted({part for part in more if part is not None and self.question.scene.part_mask[part]})

    def looked(self, items: Sequence[int], poses: Floats) -> frozenset[int]:
        """The parts whose boxes parts can meet on their way: those that the way depends on."""
        question = self.question
        own = question.parts_of(items)
        tool = Tool.of_parts(question.scene.mockup, list(own))
        corners = tool.bounds[[0, 0, 0, 0, 1, 1, 1, 1], 0], tool.bounds[[0, 0, 1, 1, 0, 0, 1, 1], 1]
        box = np.column_stack([*corners, tool.bounds[[0, 1] * 4, 2]])
        moved = np.einsum("nij,kj->nki", poses[:, :3, :3], box) + poses[:, None, :3, 3]
        # Between two poses its middle is on a line, and corners turn about it.
        turns = np.einsum("nij,nij->n", poses[1:, :3, :3], poses[:-1, :3, :3])
        half = 0.5 * np.arccos(np.clip(0.5 * (turns - 1.0), -1.0, 1.0)).max(initial=0.0)
        grown = BOX_M + 0.5 * float(np.linalg.norm(tool.bounds[1] - tool.bounds[0])) * (1.0 - np.cos(half))
        lower, upper = moved.min(axis=(0, 1)) - grown, moved.max(axis=(0, 1)) + grown
        bounds = question.scene.mockup.part_bounds.reshape(-1, 2, 3)
        meets = ((bounds[:, 0] <= upper) & (bounds[:, 1] >= lower)).all(axis=1) & question.scene.part_mask
        return frozenset(np.flatnonzero(meets).tolist()) - set(own)
