"""Bent ways of parts that a plan leaves in place: with such a way another plan can be quicker."""

from __future__ import annotations

import math
from collections.abc import Sequence

from feeler.plan.question import TARGET
from feeler.tasks.actions import Actions
from feeler.tasks.leading import Leading
from feeler.tasks.problem import Ordered

MOST_BESIDE = 24
"""Parts that are asked, those that are undone and taken out most quickly first."""


def asks_beside(actions: Actions, leading: Leading, steps: Sequence[Ordered], seconds: float) -> bool:
    """Whether one of the parts that the search knows, and that a plan leaves in place, comes out by two straight legs
    though others are in its straight ways. seconds: of the plan. A part that takes longer by itself is not asked."""
    graph, question = actions.graph, actions.question
    leaving = frozenset(each for step in steps for each in step.unit.leaving)
    waiting = []
    for node in graph.asked():
        item, riding = question.bodies.get(node, (node, frozenset[int]()))
        if item in leaving | question.kept | {TARGET} or actions.is_turned(item) or item in actions.fixings.studs:
            continue
        if all(one.blockers for one in graph.known(node)):
            least = _least(actions, item, riding)
            if least < seconds:
                waiting.append((least, node, item, riding))
    is_new = False
    for _, _, item, riding in sorted(waiting, key=lambda each: each[:2])[:MOST_BESIDE]:
        undone = frozenset[int]().union(*actions.holders(item, riding)) - riding
        for out in (undone, undone | leaving - {TARGET} - riding):
            if leading.has_play(item, riding, out) and leading.search(item, riding, out, is_short=True):
                is_new = True
                break
    return is_new


def _least(actions: Actions, item: int, riding: frozenset[int]) -> float:
    """The least seconds to undo what holds a part and to take it out; infinite if something that stays holds it."""
    joints = actions.holders(item, riding)
    held = [min((actions.least(each) for each in joint), default=math.inf) for joint in joints]
    return math.fsum(held) + actions.by_hand([item]).seconds
