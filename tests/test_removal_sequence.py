"""The shortest sequence over what blocks what, of graphs that are written down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from feeler.plan.sequence import Exit, SequenceStep, shortest_sequence, undominated

TARGET = -1
Written = Mapping[int, Sequence[tuple[str, set[int]]]]


class WrittenGraph:
    """Exits as given: by part, motions and what blocks them; and by part the fasteners that hold it."""

    def __init__(self, exits: Written, held: Mapping[int, set[int]] | None = None) -> None:
        self.given, self.held, self.asked = exits, held or {}, set[int]()

    def exits(self, node: int) -> Sequence[Exit]:
        self.asked.add(node)
        return undominated([Exit((way,), frozenset(by), self.holding(node)) for way, by in self.given.get(node, [])])

    def is_known(self, node: int) -> bool:
        return node in self.asked

    def holding(self, node: int) -> frozenset[int]:
        return frozenset(self.held.get(node, set()))


def sequence(exits: Written, held: Mapping[int, set[int]] | None = None, count: int = 9) -> list[SequenceStep] | None:
    return shortest_sequence(TARGET, WrittenGraph(exits, held), count, lambda: True)


def parts(steps: list[SequenceStep] | None) -> list[set[int]] | None:
    return None if steps is None else [set(step.parts) for step in steps]


def test_blockers_of_blockers_go_first() -> None:
    assert parts(sequence({TARGET: [("up", {1})], 1: [("up", {2})], 2: [("left", set())]})) == [{2}, {1}, {TARGET}]


def test_the_motion_with_the_fewest_steps_is_taken() -> None:
    exits: Written = {
        TARGET: [("up", {1, 2}), ("left", {3})],
        1: [("up", set())],
        2: [("up", set())],
        3: [("up", set())],
    }
    assert parts(sequence(exits)) == [{3}, {TARGET}]
    # Unless what is in its way needs more.
    longer: Written = {**exits, 3: [("up", {4, 5})], 4: [("up", set())], 5: [("up", set())]}
    assert parts(sequence(longer)) == [{1}, {2}, {TARGET}]


def test_parts_that_block_each_other_go_together_along_one_motion() -> None:
    assert parts(sequence({TARGET: [("up", {1})], 1: [("up", {TARGET})]})) == [{TARGET, 1}]
    assert sequence({TARGET: [("up", {1})], 1: [("left", {TARGET})]}) is None
    three: Written = {TARGET: [("up", {1})], 1: [("up", {2})], 2: [("up", {TARGET}), ("left", {3})]}
    assert parts(sequence(three)) == [{TARGET, 1, 2}]


def test_a_part_that_comes_out_alone_is_not_taken_along() -> None:
    assert parts(sequence({TARGET: [("up", {1})], 1: [("up", {TARGET}), ("left", set())]})) == [{1}, {TARGET}]


def test_not_all_there_is_goes_together() -> None:
    exits: Written = {TARGET: [("up", {1})], 1: [("up", {TARGET})]}
    assert sequence(exits, count=2) is None and sequence(exits, count=3) is not None


def test_fasteners_go_before_what_they_join() -> None:
    exits: Written = {TARGET: [("down", set())], 1: [("up", {2})], 2: [("up", set())]}
    assert parts(sequence(exits, {TARGET: {1}})) == [{2}, {1}, {TARGET}]
    # One that does not come out is left standing, and the other ones go.
    assert parts(sequence({**exits, 3: []}, {TARGET: {1, 3}})) == [{TARGET}]


def test_a_captive_fastener_goes_along() -> None:
    exits: Written = {TARGET: [("up", set())], 1: [("up", {TARGET})]}
    assert parts(sequence(exits, {TARGET: {1}})) == [{TARGET, 1}]


def test_only_parts_of_short_sequences_are_looked_at() -> None:
    graph = WrittenGraph({TARGET: [("up", {1}), ("left", {2, 3, 4, 5})], 1: [("up", set())]})
    assert shortest_sequence(TARGET, graph, 9, lambda: True) is not None
    assert graph.asked == {TARGET, 1}
