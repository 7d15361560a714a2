"""The tree of links: which parts each joint moves, and their poses at a position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.errors import OptionError
from feeler.mechanism.joint import Joint
from feeler.mockup import Mockup
from feeler.parts import PartsLike

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """A body of a mechanism: the child of a joint. `above`: the number of its parent link; -1: the frame."""

    number: int
    joint: Joint
    parts: tuple[int, ...]
    above: int


class Links:
    """The links, parents before their children. Link -1 is the frame: all parts that no joint moves."""

    def __init__(self, mockup: Mockup, joints: Sequence[Joint]) -> None:
        """Raises `OptionError` for joints that make no tree."""
        names = [joint.name for joint in joints]
        for name in names:
            if names.count(name) > 1:
                raise OptionError(f"two joints are called {name!r}: give each a name of its own")
        self.link_of = np.full(mockup.part_count, -1)
        children = [self._child(mockup, joint, number, joints) for number, joint in enumerate(joints)]
        above = [self.of(mockup, joint.parent, f"parent of joint {joint.name!r}") for joint in joints]
        for joint, number, parent in zip(joints, range(len(joints)), above, strict=True):
            if parent == number:
                raise OptionError(f"joint {joint.name!r} has the same parts as parent and child: give two links")
        self.links: list[Link] = []
        place = {-1: -1}
        left = list(range(len(joints)))
        while left:
            ready = [number for number in left if above[number] in place]
            if not ready:
                circle = ", ".join(repr(joints[number].name) for number in left)
                raise OptionError(
                    f"joints {circle} go round in a circle, or hang on one: give one of them as a loop (loops=)"
                )
            for number in ready:
                place[number] = len(self.links)
                self.links.append(Link(len(self.links), joints[number], children[number], place[above[number]]))
                left.remove(number)
        self.link_of = np.array([place[int(number)] for number in self.link_of], dtype=np.int64)
        self._names = [link.joint.names for link in self.links]
        self.frame = tuple(np.flatnonzero(self.link_of < 0).tolist())

    def _child(self, mockup: Mockup, joint: Joint, number: int, joints: Sequence[Joint]) -> tuple[int, ...]:
        parts = mockup.parts.select(joint.child)
        if not len(parts):
            raise OptionError(f"the child of joint {joint.name!r} names no part: give one at least")
        if len(parts) == mockup.part_count:
            raise OptionError(f"the child of joint {joint.name!r} is the whole mock-up: leave the parts that stay out")
        taken = parts[self.link_of[parts] >= 0]
        if len(taken):
            other = joints[int(self.link_of[taken[0]])]
            path = mockup.part_paths[int(taken[0])]
            raise OptionError(
                f"part {path!r} is moved by two joints, {other.name!r} and {joint.name!r}: a part is in one link; "
                "give a joint that closes a loop as one of loops="
            )
        self.link_of[parts] = number
        return tuple(parts.tolist())

    def of(self, mockup: Mockup, parts: PartsLike | None, what: str) -> int:
        """The number of the link that some parts are in. Raises `OptionError` for parts of several."""
        if parts is None:
            return -1
        chosen = mockup.parts.select(parts)
        if not len(chosen):
            raise OptionError(f"the {what} names no part: give parts of one link, or None for the frame")
        found = sorted(set(self.link_of[chosen].tolist()))
        if len(found) != 1:
            raise OptionError(f"the {what} is in several links at once: name parts of one link, or None for the frame")
        return int(found[0])

    def __len__(self) -> int:
        return len(self.links)

    def poses(self, values: Mapping[str, float]) -> list[Floats]:
        """The pose of each link in the world, (4, 4); the last one, at -1, is the frame."""
        found: list[Floats] = [np.eye(4)] * (len(self.links) + 1)
        for link, names in zip(self.links, self._names, strict=True):
            moved = link.joint._moved_by(*(values[name] for name in names))
            found[link.number] = moved if link.above < 0 else found[link.above] @ moved
        return found

    def way_up(self, number: int) -> list[int]:
        """The links from one up to the frame, without the frame."""
        found = []
        while number >= 0:
            found.append(number)
            number = self.links[number].above
        return found

    def between(self, one: int, other: int) -> tuple[list[int], list[int]]:
        """The links whose joints move two links against each other: those above the one, and those above the other."""
        up, down = self.way_up(one), self.way_up(other)
        shared = set(up) & set(down)
        return [n for n in up if n not in shared], [n for n in down if n not in shared]
