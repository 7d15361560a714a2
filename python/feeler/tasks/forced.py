"""The order that a user forces: pairs of parts, of which one goes before the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from feeler.arguments import shown
from feeler.errors import OptionError
from feeler.scene import Scene
from feeler.tasks.together import Together


def forced_order(scene: Scene, before: Sequence[object], question: Together) -> dict[int, frozenset[int]]:
    """Of items those that have to go before them.

    Raises `OptionError` if an entry is not a pair of parts, if two parts leave together, or if pairs form a circle.
    """
    paths = scene.mockup.part_paths
    said: dict[tuple[int, int], tuple[int, int]] = {}
    for pair in before:
        if not isinstance(pair, (tuple, list)) or len(pair) != 2:
            raise OptionError(f"before has {shown(pair)}: give pairs of parts: what goes first, and what after it")
        first, second = (scene.mockup.parts.select(each).tolist() for each in pair)
        if set(first) & set(second):
            raise OptionError(f"before has {paths[min(set(first) & set(second))]!r} before itself: name two parts")
        for one in first:
            for other in second:
                items = question.node_of(one), question.node_of(other)
                if items[0] == items[1]:
                    raise OptionError(
                        f"before has {paths[one]!r} before {paths[other]!r}, which leave together: leave this pair out"
                    )
                said.setdefault(items, (one, other))
    found: dict[int, frozenset[int]] = {}
    for one, other in said:
        found[other] = found.get(other, frozenset()) | {one}
    circle = _circle(found)
    if circle:
        names = []
        for one, other in zip(circle, [*circle[1:], circle[0]], strict=True):
            names += [paths[part] for part in said[one, other]]
        chain = [name for n, name in enumerate(names) if n == 0 or name != names[n - 1]]
        raise OptionError(f"before goes in a circle: {' before '.join(map(repr, chain))}: leave one of these pairs out")
    return found


def turned(ahead: Mapping[int, frozenset[int]]) -> dict[int, frozenset[int]]:
    """Of items those that wait for them, from those that go before."""
    items = frozenset[int]().union(*ahead.values())
    return {item: frozenset(other for other, all_ in ahead.items() if item in all_) for item in sorted(items)}


def behind(pairs: Mapping[int, frozenset[int]], item: int) -> frozenset[int]:
    """What follows from an item by pairs, and from these."""
    found: set[int] = set()
    waiting = frozenset({item})
    while waiting:
        waiting = frozenset[int]().union(*(pairs.get(each, frozenset()) for each in waiting)) - found
        found |= waiting
    return frozenset(found)


def _circle(ahead: dict[int, frozenset[int]]) -> list[int]:
    """Items that wait for each other, each for the one before it, from the least; none if there are no such."""
    left = dict(ahead)
    while free := [item for item, others in left.items() if not others & left.keys()]:
        for item in free:
            del left[item]
    if not left:
        return []
    seen = [min(left)]
    while True:
        item = min(left[seen[-1]] & left.keys())
        if item in seen:
            circle = seen[seen.index(item) :][::-1]
            first = circle.index(min(circle))
            return circle[first:] + circle[:first]
        seen.append(item)
