"""The quickest plan of an assembly by exhaustive search over all states, and the faults of a plan.

What holds what, and what is in the way of what, is known from the boxes of the parts. Whether a tool reaches is asked
of `feeler.access` in each state anew. A state is what is out, and the tool in hand.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

import feeler
from tasks.assemblies import ENGAGED_M, Assembly

Floats = npt.NDArray[np.float64]

PITCH_M = 0.00125
"""Of M8."""
FAR_M = 10.0
NEAR_M = 1e-6
TURN_M = 5e-6
"""How far beside a face a part turns off into another direction."""


_Running = tuple[float, int, str]
"""When a step ends, its part, and the tool in hand."""


class Judge:
    """All states of one assembly."""

    def __init__(self, made: Assembly, tools: dict[str, feeler.Tool], times: feeler.Times) -> None:
        self.made, self.tools, self.times = made, tools, times
        self.scene = feeler.Scene(made.mockup(), threads=1)
        rows = feeler.find_fasteners(self.scene)
        self.rows = {row.part: row for row in rows}
        self._swings: dict[tuple[int, frozenset[int], str], float] = {}

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
            for part, tool, seconds in self.actions(out, hand):
                after, now = (out | {part}, tool or hand), spent + seconds
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
            busy = {part for _, part, _ in running}
            for hand in sorted(set(hands)):
                left = list(hands)
                left.remove(hand)
                for part, tool, seconds in self.actions(out, hand):
                    if part not in busy:
                        one = (round(now + seconds, 9), part, tool or hand)
                        following.append((now, out, tuple(sorted([*running, one])), tuple(left)))
            if running:
                end = running[0][0]
                ended = [each for each in running if each[0] <= end]
                free = tuple(sorted([*hands, *(tool for _, _, tool in ended)]))
                following.append((end, out | {part for _, part, _ in ended}, running[len(ended) :], free))
            for state in following:
                if state not in seen:
                    seen.add(state)
                    number += 1
                    heapq.heappush(queue, (state[0], number, *state[1:]))
        return None

    def actions(self, out: frozenset[int], hand: str) -> Iterator[tuple[int, str, float]]:
        """What can be done in a state: the part, the tool, the seconds."""
        elements = self.times.elements
        for part, each in enumerate(self.made.parts):
            if part in out or part in self.made.keep:
                continue
            others = [other for other in range(len(self.made.parts)) if other not in out and other != part]
            if each.is_bolt:
                if any(
                    self._blocks(part, other, 2, each.travel) for other in others if other and other not in each.holds
                ):
                    continue
                for name in self.tools:
                    swing = self.swing(part, out, name)
                    if swing > 0.0:
                        strokes = math.ceil(ENGAGED_M / PITCH_M * 360.0 / swing - 1e-6)
                        seconds = elements["reach"].mean + strokes * elements["stroke"].mean
                        seconds += elements["draw"].mean + elements["aside"].mean
                        yield part, name, seconds + elements["get"].mean * (name != hand)
            else:
                is_held = any(
                    self.made.parts[other].is_bolt and part in self.made.parts[other].holds for other in others
                )
                if not is_held and self.is_free(part, others):
                    yield part, "", elements["take"].mean + elements["aside"].mean

    def is_free(self, part: int, others: list[int]) -> bool:
        """Whether it leaves along an axis, or along one and then along another."""
        boxes = self.made.parts[part].boxes
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
            for part in step.parts:
                options = {(one, tool): seconds for one, tool, seconds in self.actions(out, hand)}
                seconds = options.get((part, step.tool))
                if seconds is None:
                    found.append(f"step {step.number}: {step} cannot be done")
                    seconds = step.seconds
                spent += seconds
                out |= {part}
            hand = step.tool or hand
        if task.is_found and abs(spent - task.seconds) > 1e-6:
            found.append(f"it takes {spent:.2f} s, not {task.seconds:.2f}")
        if task.is_found and self.made.wanted not in out:
            found.append("the wanted part is still there")
        return found
