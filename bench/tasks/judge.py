"""The quickest plan of an assembly by exhaustive search over all states, and the faults of a plan.

What holds what, and what is in the way of what, is known from the boxes of the parts. Whether a tool reaches is asked
of `feeler.access` in each state anew. A state is what is out, and the tool in hand. In each state the parts that bolts
still join leave as one, if one of them is large enough to carry the others.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

import feeler
from tasks.assemblies import Assembly

Floats = npt.NDArray[np.float64]

PITCH_M = 0.00125
"""Of M8."""
FAR_M = 10.0
NEAR_M = 1e-6
TURN_M = 5e-6
"""How far beside a face a part turns off into another direction."""


_Running = tuple[float, tuple[int, ...], str]
"""When a step ends, its parts, and the tool in hand."""


class Judge:
    """All states of one assembly."""

    def __init__(self, made: Assembly, tools: dict[str, feeler.Tool], times: feeler.Times) -> None:
        self.made, self.tools, self.times = made, tools, times
        self.scene = feeler.Scene(made.mockup(), threads=1)
        rows = feeler.find_fasteners(self.scene)
        self.rows = {row.part: row for row in rows}
        self._swings: dict[tuple[int, frozenset[int], str], float] = {}
        self._free: dict[tuple[frozenset[int], frozenset[int]], bool] = {}
        self._sizes = [_size(*part.mesh) for part in made.parts]

    def least(self) -> float | None:
        """Seconds of the quickest plan; None if nothing takes the wanted part out."""
        queue: list[tuple[float, int, frozenset[int], str]] = [(0.0, 0, frozenset(), "")]
        best = {(queue[0][2], ""): 0.0}
        number = 0
        while queue:
            spent, _, out, hand = heapq.heappop(queue)
            if self.made.wanted in out:
                return spent
            if spent > best[out, hand]:
                continue
            for parts, tool, seconds in self.actions(out, hand):
                after, now = (out | parts, tool or hand), spent + seconds
                if now < best.get(after, math.inf) - 1e-12:
                    best[after] = now
                    number += 1
                    heapq.heappush(queue, (now, number, *after))
        return None

    def soonest(self, people: int) -> float | None:
        """Seconds until several people have the wanted part out, at best; None if nothing takes it out.

        All schedules: whoever is free begins with what can be done, or waits for the next step of another to end. What
        is being taken out is in the way until it is out.
        """
        start = (0.0, frozenset[int](), tuple[_Running, ...](), ("",) * people)
        queue: list[tuple[float, int, frozenset[int], tuple[_Running, ...], tuple[str, ...]]] = [(0.0, 0, *start[1:])]
        seen, number = {start}, 0
        while queue:
            now, _, out, running, hands = heapq.heappop(queue)
            if self.made.wanted in out:
                return now
            following = []
            busy = {part for _, parts, _ in running for part in parts}
            for hand in sorted(set(hands)):
                left = list(hands)
                left.remove(hand)
                for parts, tool, seconds in self.actions(out, hand):
                    if not parts & busy:
                        one = (round(now + seconds, 9), tuple(sorted(parts)), tool or hand)
                        following.append((now, out, tuple(sorted([*running, one])), tuple(left)))
            if running:
                end = running[0][0]
                ended = [each for each in running if each[0] <= end]
                free = tuple(sorted([*hands, *(tool for _, _, tool in ended)]))
                following.append(
                    (end, out | {part for _, parts, _ in ended for part in parts}, running[len(ended) :], free)
                )
            for state in following:
                if state not in seen:
                    seen.add(state)
                    number += 1
                    heapq.heappush(queue, (state[0], number, *state[1:]))
        return None

    def actions(self, out: frozenset[int], hand: str) -> Iterator[tuple[frozenset[int], str, float]]:
        """What can be done in a state: the parts that leave, the tool, the seconds."""
        elements = self.times.elements
        there = [part for part in range(len(self.made.parts)) if part not in out]
        for part in there:
            each = self.made.parts[part]
            if not each.is_bolt or part in self.made.keep:
                continue
            passed = {part, each.anchor, *each.holds}
            if any(self._blocks(part, other, 2, each.travel) for other in there if other not in passed):
                continue
            for name in self.tools:
                swing = self.swing(part, out, name)
                if swing > 0.0:
                    strokes = math.ceil(each.engaged / PITCH_M * 360.0 / swing - 1e-6)
                    seconds = elements["reach"].mean + strokes * elements["stroke"].mean
                    seconds += elements["draw"].mean + elements["aside"].mean
                    yield frozenset([part]), name, seconds + elements["get"].mean * (name != hand)
        for body in self._bodies(there):
            if self._may_leave(body) and self.is_free(body, out):
                yield body, "", elements["take"].mean + elements["aside"].mean

    def _bodies(self, there: list[int]) -> list[frozenset[int]]:
        """What bolts still join, with these; bolts that hold nothing are none."""
        group = {part: frozenset([part]) for part in there}
        for part in there:
            each = self.made.parts[part]
            if each.is_bolt:
                ends = [end for end in (part, each.anchor, *each.holds) if end in group]
                joined = frozenset[int]().union(*(group[end] for end in ends))
                group.update(dict.fromkeys(joined, joined))
        found = dict.fromkeys(group[part] for part in there)
        return [body for body in found if any(not self.made.parts[part].is_bolt for part in body)]

    def _may_leave(self, body: frozenset[int]) -> bool:
        """Whether parts may leave as one: nothing is kept, and one of them carries the others."""
        made = self.made
        if body & made.keep or (made.wanted in body and made.parts[made.wanted].is_bolt):
            return False
        plain = [part for part in body if not made.parts[part].is_bolt]
        carriers = [made.wanted] if made.wanted in body else plain
        return len(plain) == 1 or any(
            self._carries(part, [each for each in plain if each != part]) for part in carriers
        )

    def _carries(self, part: int, others: list[int]) -> bool:
        """Whether a part carries others: smaller ones, and little of them if it is fastened to nothing larger."""
        made = self.made
        if not all(self._is_smaller(other, part) for other in others):
            return False
        bolts = [each for each in made.parts if each.is_bolt and part in {each.anchor, *each.holds}]
        ends = {end for each in bolts for end in (each.anchor, *each.holds)} - {part}
        if any(end in made.keep or not self._is_smaller(end, part) for end in ends):
            return True
        is_light = part == made.wanted or (not made.parts[made.wanted].is_bolt and self._is_smaller(part, made.wanted))
        return is_light and sum(self._sizes[other][0] for other in others) < 0.5 * self._sizes[part][0]

    def _is_smaller(self, one: int, other: int) -> bool:
        return all(mine < (1.0 - 1e-6) * its for mine, its in zip(self._sizes[one], self._sizes[other], strict=True))

    def is_free(self, body: frozenset[int], out: frozenset[int]) -> bool:
        """Whether parts leave as one along an axis, or along one and then along another."""
        if (body, out) not in self._free:
            others = [other for other in range(len(self.made.parts)) if other not in out | body]
            self._free[body, out] = self._is_free(
                np.concatenate([self.made.parts[each].boxes for each in body]), others
            )
        return self._free[body, out]

    def _is_free(self, boxes: Floats, others: list[int]) -> bool:
        ways = list(itertools.product(range(3), (1.0, -1.0)))
        if any(self._is_clear(boxes, others, axis, sign * FAR_M) for axis, sign in ways):
            return True
        for axis, sign in ways:
            for by in self._turns(boxes, others, axis, sign):
                if not self._is_clear(boxes, others, axis, sign * by):
                    break
                there = boxes.copy()
                there[:, :, axis] += sign * by
                if any(self._is_clear(there, others, other, way * FAR_M) for other, way in ways if other != axis):
                    return True
        return False

    def _turns(self, boxes: Floats, others: list[int], axis: int, sign: float) -> list[float]:
        """How far along an axis it has passed a face of another part, or is just before one; the nearest first."""
        found: set[float] = set()
        for other in others:
            faces = self.made.parts[other].boxes[:, :, axis].ravel()
            apart = sign * (faces[:, None] - boxes[:, :, axis].ravel())
            found.update((apart + TURN_M).ravel().tolist(), (apart - TURN_M).ravel().tolist())
        return sorted(by for by in found if by > 0.0)

    def _is_clear(self, boxes: Floats, others: list[int], axis: int, by: float) -> bool:
        return not any(self._meets(boxes, other, axis, by) for other in others)

    def _blocks(self, part: int, other: int, axis: int, by: float) -> bool:
        """Whether a part meets another on its way along an axis."""
        return self._meets(self.made.parts[part].boxes, other, axis, by)

    def _meets(self, own: Floats, other: int, axis: int, by: float) -> bool:
        swept = own.copy()
        if by > 0.0:
            swept[:, 1, axis] += by
        else:
            swept[:, 0, axis] += by
        boxes = self.made.parts[other].boxes
        overlap = np.minimum(swept[:, None, 1], boxes[None, :, 1]) - np.maximum(swept[:, None, 0], boxes[None, :, 0])
        return bool((overlap > NEAR_M).all(axis=2).any())

    def swing(self, part: int, out: frozenset[int], name: str) -> float:
        """The swing of a tool in a state, degrees; 0 if it does not reach."""
        key = (part, out, name)
        if key not in self._swings:
            scene = self.scene.without(sorted(out)) if out else self.scene
            row = feeler.access(scene, self.tools[name], feeler.Fasteners([self.rows[part]]), threads=1)[0]
            self._swings[key] = row.swing_deg if row.is_reachable else 0.0
        return self._swings[key]

    def faults(self, task: feeler.Task) -> list[str]:
        """What is wrong with a plan, step by step."""
        found = []
        out: frozenset[int] = frozenset()
        hand, spent = "", 0.0
        for step in task.steps:
            left = frozenset(step.parts)
            while left:
                options = {(parts, tool): seconds for parts, tool, seconds in self.actions(out, hand)}
                whole = [parts for parts, tool in options if parts <= left and tool == step.tool]
                parts = max(whole, key=len, default=left)
                seconds = options.get((parts, step.tool))
                if seconds is None:
                    found.append(f"step {step.number}: {step} cannot be done")
                    seconds = step.seconds
                spent += seconds
                out |= parts
                left -= parts
            hand = step.tool or hand
        if task.is_found and abs(spent - task.seconds) > 1e-6:
            found.append(f"it takes {spent:.2f} s, not {task.seconds:.2f}")
        if task.is_found and self.made.wanted not in out:
            found.append("the wanted part is still there")
        return found


def _size(corners: Floats, faces: npt.NDArray[np.int64]) -> tuple[float, float]:
    """The surface of a mesh, and how far it reaches from the middle of that."""
    a, b, c = (corners[faces[:, n]] for n in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    middle = areas @ (a + b + c) / (3.0 * areas.sum())
    return float(areas.sum()), float(np.linalg.norm(corners[np.unique(faces)] - middle, axis=1).max())
