"""Couplings of joints: gears, racks and mimic joints, as `q2 = a q1 + b`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from feeler.arguments import check_number, check_text
from feeler.errors import OptionError
from feeler.field_docs import documented

_SAME = 1e-9


@documented
@dataclass(frozen=True)
class JointCoupling:
    """`joint = ratio * of + offset`: gears (a ratio of tooth counts), racks (metres a radian), mimic joints.

    joint and of: names of numbers of a position (`"hinge"`, `"bolt.turn"`). offset: radians or metres. Raises
    `OptionError` for a ratio of zero and numbers that are not finite.
    """

    joint: str
    of: str
    ratio: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        check_text("joint", self.joint, "the name of a joint")
        check_text("of", self.of, "the name of a joint")
        where = f"coupling of {self.joint!r} with {self.of!r}"
        object.__setattr__(self, "ratio", check_number(f"ratio of the {where}", self.ratio, "a number"))
        object.__setattr__(self, "offset", check_number(f"offset of the {where}", self.offset, "radians or metres"))
        if self.ratio == 0.0:
            raise OptionError(f"ratio of the {where} is 0: give another number, or make the joint fixed")
        if self.joint == self.of:
            raise OptionError(f"joint {self.joint!r} is coupled with itself: give two joints")


@dataclass(frozen=True)
class Driven:
    """A number of a position as `ratio * root + offset`."""

    root: str
    ratio: float
    offset: float


def driven_by(names: Sequence[str], couplings: Iterable[JointCoupling]) -> dict[str, Driven]:
    """Each number by its root. Of coupled numbers, the root is the one that drives, or the first in `names`.

    Raises `OptionError` for joints that do not exist and couplings that contradict each other.
    """
    links: dict[str, list[tuple[str, float, float]]] = {name: [] for name in names}
    followers = set()
    for each in couplings:
        for name in (each.joint, each.of):
            if name not in links:
                raise OptionError(f"a coupling names {name!r}, which is no joint that moves: there are {list(names)}")
        links[each.of].append((each.joint, each.ratio, each.offset))
        links[each.joint].append((each.of, 1.0 / each.ratio, -each.offset / each.ratio))
        followers.add(each.joint)
    found: dict[str, Driven] = {}
    for root in sorted(names, key=lambda name: name in followers):  # a stable sort: those that drive come first
        if root in found:
            continue
        found[root] = Driven(root, 1.0, 0.0)
        waiting = [root]
        while waiting:
            at = waiting.pop()
            for name, ratio, offset in links[at]:
                by = Driven(root, ratio * found[at].ratio, ratio * found[at].offset + offset)
                known = found.setdefault(name, by)
                if known is by:
                    waiting.append(name)
                elif not _is_same(known.ratio, by.ratio) or not _is_same(known.offset, by.offset):
                    raise OptionError(
                        f"couplings contradict each other: {name!r} is {known.ratio:.9g} {root!r} + {known.offset:.9g} "
                        f"and {by.ratio:.9g} {root!r} + {by.offset:.9g}"
                    )
    return found


def _is_same(one: float, other: float) -> bool:
    return abs(one - other) <= _SAME * max(1.0, abs(one), abs(other))
