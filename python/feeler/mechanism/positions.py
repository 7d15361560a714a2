"""The positions of mechanisms: numbers, poses of links, and scenes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from feeler._core import Screw
from feeler.arguments import check_kind, check_list, check_number, check_text, near, shown
from feeler.errors import MechanismError, OptionError
from feeler.ignored import pairs_of_parts
from feeler.mechanism.aligning import aligned, skew
from feeler.mechanism.bodies import Bodies
from feeler.mechanism.coupling import JointCoupling, driven_by
from feeler.mechanism.joint import Joint, JointKind
from feeler.mechanism.links import Links
from feeler.mechanism.loops import Follower, opening
from feeler.mockup import Mockup
from feeler.parts import PartsLike
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Values = Mapping[str, float]

_SAME = 1e-9
_CLOSED = 1e-6
"""Loops whose numbers are all given may be open by this, radians or sizes."""
_DIFFERENCE = 1e-6
_RANK = 1e-7
_MOST_RAD = 1e6
"""Angles beyond have no 1e-9 radians left."""
_MOST_M = 1e9


class Positions:
    """The positions that joints, couplings and loops allow. See `Mechanism`."""

    def __init__(
        self,
        mockup: Mockup,
        joints: Iterable[Joint],
        couplings: Iterable[JointCoupling] = (),
        loops: Iterable[Joint] = (),
        scene: Scene | None = None,
        ignore: Iterable[tuple[PartsLike, PartsLike]] = (),
    ) -> None:
        self.mockup = check_kind("mockup", mockup, Mockup)
        self.joints = tuple(check_kind("a joint", each, Joint) for each in check_list("joints", joints, "joints"))
        if not self.joints:
            raise OptionError("there are no joints: give one at least")
        self.couplings = tuple(
            check_kind("a coupling", each, JointCoupling) for each in check_list("couplings", couplings, "couplings")
        )
        self.loops = tuple(check_kind("a loop", each, Joint) for each in check_list("loops", loops, "joints"))
        if scene is not None and check_kind("scene", scene, Scene).mockup is not mockup:
            raise OptionError("the scene is of another mock-up: give one of this mock-up")
        self.links = Links(mockup, self.joints)
        self.names = tuple(name for joint in self.joints for name in joint.names)
        """The names of the numbers of a position, in the order of the joints."""
        self.driven = driven_by(self.names, self.couplings)
        self._ends = [self._ends_of(loop) for loop in self.loops]
        taken = [joint.name for joint in (*self.joints, *self.loops)]
        for loop in self.loops:
            if taken.count(loop.name) > 1:
                raise OptionError(
                    f"two joints are called {loop.name!r}, a loop and another: give each a name of its own"
                )
            if loop.limits is not None or loop.slide_limits is not None:
                raise OptionError(
                    f"joint {loop.name!r} closes a loop and has limits, which nothing follows: leave them out, and "
                    "limit joints of the tree"
                )
        self.groups = self._grouped()
        self.closing = list(self.loops)
        """The joints that close loops, their axes aligned with those of the tree."""
        for group in self.groups:
            self._align(group[1])
        self._of_name = {name: (link.joint, n) for link in self.links.links for n, name in enumerate(link.joint.names)}
        closed = list(zip(self.closing, self._ends, strict=True))
        self.ignore = pairs_of_parts(mockup, mockup, ignore, "ignore", ("mock-up", "mock-up"))
        self.bodies = Bodies(mockup, self.links, self.couplings, scene, closed, self.ignore)
        self._last: tuple[tuple[tuple[str, float], ...], Scene] | None = None
        for coupling in self.couplings:
            self.limits(coupling.of)  # it raises where those of coupled joints leave no position

    def limits(self, name: str) -> tuple[float, float] | None:
        """The limits of a number, those of the numbers coupled with it included; None for none."""
        self.check_name(name)
        lower, upper = -np.inf, np.inf
        mine = self.driven[name]
        for other, by in self.driven.items():
            own = self.own_limits(other)
            if by.root == mine.root and own is not None:
                ratio = by.ratio / mine.ratio
                offset = by.offset - ratio * mine.offset
                ends = sorted((end - offset) / ratio for end in own)
                lower, upper = max(lower, ends[0]), min(upper, ends[1])
        if lower > upper + _SAME * max(1.0, abs(lower)):
            raise OptionError(f"the limits of the joints coupled with {name!r} leave no position: give wider ones")
        return None if np.isinf(lower) and np.isinf(upper) else (float(lower), float(max(lower, upper)))

    def own_limits(self, name: str) -> tuple[float, float] | None:
        """The limits that the joint of a number has."""
        joint, number = self._of_name[name]
        return joint.limits if number == 0 else joint.slide_limits

    def position(self, values: Values | None = None, start: Values | None = None) -> dict[str, float]:
        """All numbers of a position, radians and metres. Those not given follow from couplings and loops, or are
        0, or the limit nearest to it.

        start: where loops are followed from, a position of this mechanism; None: where the parts are modelled.
        Raises `OptionError` outside of limits, `MechanismError` where a loop cannot close or has a dead point.
        """
        given = self.checked(values)
        roots = self._rooted(given)
        found = {}
        for name in {by.root for by in self.driven.values()}:
            own = self.limits(name)
            rest = 0.0 if own is None else min(max(0.0, own[0]), own[1])
            found[name] = roots.get(name, rest)
        for group, loops in self.groups:
            if group & roots.keys():
                self._close(found, sorted(group & roots.keys()), sorted(group - roots.keys()), loops, start)
                for root in group:
                    self._check_limits(root, found[root])
        return {name: by.ratio * found[by.root] + by.offset for name, by in self.driven.items()}

    def poses(self, values: Values | None = None, start: Values | None = None) -> dict[str, Floats]:
        """The pose `(4, 4)` of each moved link, by the name of its joint; the identity is where it is modelled."""
        found = self.links.poses(self.position(values, start))
        return {link.joint.name: found[link.number] for link in self.links.links}

    def chain(self, joint: str, start: Values, end: Values) -> list[Screw | Floats]:
        """The motion of the link of a joint from one position to another, as `Scene.check_path` takes it: a pose, and
        a `Screw` or a pose to slide to.

        Raises `OptionError` if more than one joint moves it, for then its motion is no screw.
        """
        link = self._link(joint)
        begin, stop = self.position(start), self.position(end)
        names = [name for n in self.links.way_up(link) for name in self.links.links[n].joint.names]
        moving = [name for name in names if abs(begin[name] - stop[name]) > 0.0]
        if len(moving) > 1:
            raise OptionError(f"{joint!r} is moved by {', '.join(moving)} at once: move one joint after the other")
        there = self.links.poses(begin)
        if not moving:
            return [there[link]]
        screw = self.screw(moving[0], begin, stop[moving[0]] - begin[moving[0]])
        return [there[link], self.links.poses(stop)[link] if screw is None else screw]

    def screw(self, name: str, position: Values, by: float) -> Screw | None:
        """The screw in the world by which a number moves what hangs on it; None for a slide."""
        joint, number = self._of_name[name]
        if not joint.turns[number]:
            return None
        link = next(link for link in self.links.links if link.joint is joint)
        above = self.links.poses(position)[link.above]
        slide = position[joint.names[1]] if joint.kind is JointKind.CYLINDRICAL else 0.0
        axis = above[:3, :3] @ np.array(joint.axis)
        point = above[:3, :3] @ np.array(joint.point) + above[:3, 3] + slide * axis
        return Screw(axis, point, by, joint.pitch)

    def scene(self, values: Values | None = None, start: Values | None = None) -> Scene:
        """A scene with the parts at a position; parts keep their numbers and names (`Scene.moved`). The last one is
        kept."""
        position = self.position(values, start)
        key = tuple(sorted(position.items()))
        poses = self.links.poses(position)
        if all(np.array_equal(pose, np.eye(4)) for pose in poses):
            return self.bodies.scene
        if self._last is None or self._last[0] != key:
            of_links = np.array([poses[link.number] for link in self.links.links])
            self._last = (key, self.bodies.scene._with_poses(self.links.link_of, of_links))
        return self._last[1]

    def check_ranges(
        self, values: Mapping[str, float | tuple[float, float]]
    ) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
        """The numbers that stand, and the ranges of those that move."""
        stand: dict[str, float] = {}
        move: dict[str, tuple[float, float]] = {}
        if not isinstance(values, Mapping):
            raise OptionError(f"values is {shown(values)}: give a dict of joints, such as {{'hinge': (0, 1.9)}}")
        for name, value in values.items():
            self.check_name(name)
            if (isinstance(value, (tuple, list)) and len(value) == 2) or (
                isinstance(value, np.ndarray) and value.shape == (2,)
            ):
                lower, upper = (check_number(f"{name!r}", each, "radians or metres") for each in value)
                if lower > upper:
                    ends = f"{self.said(name, lower)} to {self.said(name, upper)}"
                    raise OptionError(f"the range of {name!r} is {ends}: give the least and the greatest value")
                for end in (lower, upper):
                    self._check_limits(name, end)
                move[name] = (lower, upper)
            else:
                stand[name] = check_number(f"{name!r}", value, "a number, or the least and greatest value")
        return stand, move

    def loops_of(self, name: str) -> bool:
        """Whether a number is part of a loop."""
        return any(self.driven[name].root in group for group, _ in self.groups)

    def check_name(self, name: object) -> None:
        """Raises `OptionError` for joints that do not move."""
        if not isinstance(name, str) or name not in self.driven:
            raise OptionError(f"there is no joint {shown(name)} that moves: {near(name, list(self.names))}")

    def said(self, name: str, value: float) -> str:
        """A number of a position in words, with its unit."""
        return f"{value:.9g} rad ({np.degrees(value):.6g} degrees)" if self.turns(name) else f"{value:.9g} m"

    def _check_limits(self, name: str, value: float) -> None:
        """Raises `OptionError` where a number, or one that is coupled with it, is beyond its limits."""
        mine = self.driven[name]
        root = (value - mine.offset) / mine.ratio
        for other, by in self.driven.items():
            if by.root != mine.root:
                continue
            number = value if other == name else by.ratio * root + by.offset
            by_name = "" if other == name else f"{name!r} at {self.said(name, value)} moves "
            if not abs(number) <= (_MOST_RAD if self.turns(other) else _MOST_M):
                most = f"{_MOST_RAD:g} radians" if self.turns(other) else f"{_MOST_M:g} m"
                raise OptionError(f"{by_name}{other!r} {'to' if by_name else 'is'} {number:.9g}: give at most {most}")
            own = self.own_limits(other)
            slack = _SAME * max(1.0, abs(number))
            if own is not None and not own[0] - slack <= number <= own[1] + slack:
                ends = f"its limits are {self.said(other, own[0])} to {self.said(other, own[1])}"
                raise OptionError(f"{by_name}{other!r} {'to' if by_name else 'is'} {self.said(other, number)}: {ends}")

    def checked(self, values: Values | None, what: str = "values") -> dict[str, float]:
        """Given numbers. Raises `OptionError` for others."""
        if values is not None and not isinstance(values, Mapping):
            raise OptionError(f"{what} is {shown(values)}: give a dict of joints, such as {{'hinge': 1.2}}")
        found = {}
        for name, value in (values or {}).items():
            self.check_name(name)
            found[name] = check_number(f"{name!r}", value, "radians or metres")
            self._check_limits(name, found[name])
        return found

    def _rooted(self, given: dict[str, float]) -> dict[str, float]:
        roots: dict[str, float] = {}
        first: dict[str, str] = {}
        for name, value in given.items():
            by = self.driven[name]
            root = (value - by.offset) / by.ratio
            known = roots.setdefault(by.root, root)
            giver = first.setdefault(by.root, name)
            if abs(known - root) > _SAME * max(1.0, abs(known)):
                raise OptionError(
                    f"{name!r} is coupled with {giver!r}, and both are given, as numbers that disagree: leave one out"
                )
        return roots

    def _link(self, joint: str) -> int:
        check_text("joint", joint, "the name of a joint")
        for link in self.links.links:
            if link.joint.name == joint:
                return link.number
        raise OptionError(f"there is no joint {shown(joint)}: {near(joint, [each.name for each in self.joints])}")

    def _ends_of(self, loop: Joint) -> tuple[int, int]:
        ends = (
            self.links.of(self.mockup, loop.parent, f"parent of loop {loop.name!r}"),
            self.links.of(self.mockup, loop.child, f"child of loop {loop.name!r}"),
        )
        if ends[0] == ends[1]:
            raise OptionError(f"loop {loop.name!r} joins a link with itself: give two links")
        return ends

    def _grouped(self) -> list[tuple[set[str], list[int]]]:
        """The roots that each set of loops moves, loops that share some together."""
        groups: list[tuple[set[str], list[int]]] = []
        for number, ends in enumerate(self._ends):
            up, down = self.links.between(*ends)
            own = {self.driven[name].root for n in up + down for name in self.links.links[n].joint.names}
            if not own:
                raise OptionError(f"loop {self.loops[number].name!r} has no joint that moves: leave it out")
            loops = [number]
            for other in [group for group in groups if group[0] & own]:
                groups.remove(other)
                own, loops = own | other[0], other[1] + loops
            groups.append((own, loops))
        return groups

    def _align(self, loops: list[int]) -> None:
        """Takes the axes of loops as exact where they are off by rounding."""
        links = self._links_of(loops)
        joints = aligned([*(self.links.links[number].joint for number in links), *(self.loops[n] for n in loops)])
        for number, joint in zip(links, joints, strict=False):
            self.links.links[number] = replace(self.links.links[number], joint=joint)
        for n, joint in zip(loops, joints[len(links) :], strict=True):
            self.closing[n] = joint

    def _links_of(self, loops: list[int]) -> list[int]:
        """The links whose joints move loops."""
        ways = [side for n in loops for side in self.links.between(*self._ends[n])]
        return sorted({number for way in ways for number in way if self.links.links[number].joint.names})

    def _close(
        self, found: dict[str, float], given: list[str], followed: list[str], loops: list[int], start: Values | None
    ) -> None:
        origin = (
            {name: 0.0 for name in found}
            if start is None
            else {name: self.checked(start, "start").get(name, 0.0) for name in found}
        )
        if len(given) > 1 and followed:
            kept = self._independent({**found, **{root: origin[root] for root in (*given, *followed)}}, given, loops)
            if len(kept) < len(given):
                self._close_over(found, given, kept, followed, loops, start)
                return

        def open_by(inputs: Floats, outputs: Floats) -> Floats:
            roots = {**found, **dict(zip(given, inputs, strict=True)), **dict(zip(followed, outputs, strict=True))}
            return self._opening(roots, loops)

        def told(inputs: Floats) -> str:
            return self._told(dict(zip(given, inputs, strict=True)))

        scales = np.array([self._scale(name) for name in followed])
        begin, end = (np.array([each[name] for name in given]) for each in (origin, found))
        outputs = np.array([origin[name] for name in followed])
        if not followed:
            if float(np.abs(open_by(end, outputs)).max()) > _CLOSED:
                raise MechanismError(f"the loop does not close at {told(end)}: give fewer of its joints")
            return
        try:
            closed = Follower(open_by, scales, told).follow(begin, outputs, end)
        except MechanismError as error:
            joints = [self.links.links[number].joint for number in self._links_of(loops)]
            off = skew([*joints, *(self.closing[n] for n in loops)])
            if off:
                raise MechanismError(f"{off}; {error}") from None
            raise
        found.update(zip(followed, closed.tolist(), strict=True))

    def _close_over(
        self,
        found: dict[str, float],
        given: list[str],
        kept: list[str],
        followed: list[str],
        loops: list[int],
        start: Values | None,
    ) -> None:
        """Closes loops of which more numbers are given than they have freedoms: the rest must agree with those kept."""
        wanted = {name: found[name] for name in given}
        spare = [name for name in given if name not in kept]
        self._close(found, kept, sorted([*followed, *spare]), loops, start)
        if any(abs(found[name] - wanted[name]) > _CLOSED * self._scale(name) for name in spare):
            raise MechanismError(f"the loop does not close at {self._told(wanted)}: give fewer of its joints")

    def freed(self, at: Values, name: str) -> tuple[dict[str, float], dict[str, float] | None]:
        """The numbers that stand while a joint moves, and the position that its loop is followed from, if it is given.

        Of a loop only as many numbers stand as leave it free to move.
        """
        mine = self.driven[name].root
        for group, loops in self.groups:
            others = [root for root in group if root != mine and any(self.driven[each].root == root for each in at)]
            if mine not in group or not others:
                continue
            position = self.position(at)
            inputs = self._independent(position, [mine, *sorted(others)], loops)
            stand = {
                each: value for each, value in at.items() if self.driven[each].root not in set(others) - set(inputs)
            }
            return stand, position
        return dict(at), None

    def completed(self, at: Values, name: str) -> dict[str, float]:
        """The numbers that stand where a joint begins, with its own where those of its loop leave it free: there it is
        as it is modelled."""
        given, mine = self._rooted(self.checked(at, "at")), self.driven[name].root
        for group, loops in self.groups:
            if mine not in group or mine in given or not group & given.keys():
                continue
            modelled = dict.fromkeys({by.root for by in self.driven.values()}, 0.0)
            if mine in self._independent(modelled, [*sorted(group & given.keys()), mine], loops):
                return {**at, name: self.driven[name].offset}
        return dict(at)

    def _independent(self, roots: Values, given: list[str], loops: list[int]) -> list[str]:
        """The first of some roots of loops that may all be given at a position, the others following."""
        group = next(group for group, own in self.groups if loops[0] in own)
        columns = {}
        for name in sorted(group):
            by = _DIFFERENCE * self._scale(name)
            ahead, behind = ({**roots, name: roots[name] + sign * by} for sign in (1.0, -1.0))
            columns[name] = (self._opening(ahead, loops) - self._opening(behind, loops)) / (2.0 * _DIFFERENCE)

        def rank(names: Iterable[str]) -> int:
            chosen = [columns[name] for name in names]
            return int(np.linalg.matrix_rank(np.column_stack(chosen), tol=_RANK)) if chosen else 0

        whole, kept = rank(columns), list[str]()
        for name in given:
            if rank(each for each in columns if each not in kept and each != name) == whole:
                kept.append(name)
        return kept or given[:1]

    def _opening(self, roots: Values, loops: list[int]) -> Floats:
        """How far loops are open, by the roots."""
        poses = self.links.poses({name: by.ratio * roots[by.root] + by.offset for name, by in self.driven.items()})
        return np.concatenate(
            [opening(self.closing[n], poses[self._ends[n][0]], poses[self._ends[n][1]], self.size) for n in loops]
        )

    def _told(self, values: Values) -> str:
        return ", ".join(f"{name} = {self.said(name, value)}" for name, value in values.items())

    def _scale(self, name: str) -> float:
        return 1.0 if self.turns(name) else self.size

    @cached_property
    def size(self) -> float:
        """The diagonal of the mock-up, metres; 1 where it has none."""
        bounds = self.mockup.part_bounds.reshape(-1, 2, 3)
        kept = bounds[(bounds[:, 0] <= bounds[:, 1]).all(axis=1)]
        return (float(np.linalg.norm(kept[:, 1].max(axis=0) - kept[:, 0].min(axis=0))) if len(kept) else 0.0) or 1.0

    def link_of(self, name: str) -> int:
        """The number of the link that a number of a position moves."""
        return self._link(self._of_name[name][0].name)

    def joint_of(self, name: str) -> Joint:
        """The joint of a number of a position."""
        return self._of_name[name][0]

    def turns(self, name: str) -> bool:
        """Whether a number of a position is an angle."""
        joint, number = self._of_name[name]
        return joint.turns[number]
