"""The least gap of a mechanism over ranges of its joints.

Along one joint each pair of links moves along a chain of screws, and its least gap is bounded along that. Over several,
by branch and bound on boxes of the values of all joints but the one that moves the pair farthest: no point of a box of
half-widths `h` is farther from where it is at the middle than the sum of `h` times lever arms, so the gap in the box is
at least that along the one joint with the others in the middle, less this sum. The box with the least bound is cut
first.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from feeler._core import ClearanceAlong
from feeler.arguments import check_whole
from feeler.errors import OptionError
from feeler.mechanism.answers import MechanismClearance, MechanismContact, MechanismSeat
from feeler.mechanism.enclosing import sure_legs
from feeler.mechanism.legs import Leg, relative, whole
from feeler.mechanism.positions import Positions
from feeler.mechanism.ranging import Near, contact, gap, moving_pairs, reaches, roots_of, seat_meeting, seats_of
from feeler.mechanism.standing import Standing
from feeler.poses import inverse

Floats = npt.NDArray[np.float64]
Ranges = dict[str, tuple[float, float]]

OFF = 0.2
"""By how much of the error the legs of a loop may be off."""
CURVE = 121
"""Values of a joint at which the curve has a row."""
SEAT_LINES = 64
"""Along which a seat that several joints move is followed."""
_SLACK = 1e-9  # metres: rounding of poses and distances


@dataclass
class _Best:
    """The least gap found, and what meets deeper than it is seated."""

    mechanism: Positions
    worst: dict[str, float]
    upper: float = math.inf
    near: Near | None = None
    jams: list[MechanismContact] = field(default_factory=list)
    seats: list[MechanismSeat] = field(default_factory=list)

    def stand(self, roots: set[str], position: dict[str, float], value: float = 0.0) -> None:
        """The gaps of all that some roots do not move."""
        standing = Standing(self.mechanism, roots, position, value)
        standing.measure()
        self.seats += standing.seats
        self.take(standing.near, position)
        for met in standing.jams():
            self.jam(met, position)

    def take(self, near: Near | None, position: dict[str, float]) -> None:
        """A gap at a position, if it is the least."""
        if near is not None and near[0] < self.upper:
            self.upper, self.near, self.worst = near[0], near, position

    def jam(self, met: MechanismContact, position: dict[str, float]) -> None:
        """A seat that goes deeper."""
        self.jams.append(met)
        point = np.array(met.point)
        self.take((0.0, met.part, met.other, point, point), position)

    def answer(
        self,
        pairs: list[tuple[int, int]],
        lower: float,
        boxes: int,
        undecided: float,
        curve: Floats,
        is_certified: bool,
    ) -> MechanismClearance:
        """All of it."""
        paths, near = self.mechanism.mockup.part_paths, self.near
        one, other = (None, None) if near is None else near[1:3]
        points = None
        if near is not None:
            ends = [(float(point[0]), float(point[1]), float(point[2])) for point in near[3:]]
            points = (ends[0], ends[1])
        return MechanismClearance(
            max(0.0, min(lower, self.upper)),
            self.upper,
            self.worst,
            one,
            other,
            "" if one is None else paths[one],
            "" if other is None else paths[other],
            points,
            boxes,
            undecided,
            (*seats_of(self.mechanism, pairs), *self.seats),
            curve,
            is_certified,
            tuple(self.jams),
        )


def clearance_of(
    mechanism: Positions,
    values: Mapping[str, float | tuple[float, float]],
    error: float,
    most: int,
    with_standing: bool = True,
) -> MechanismClearance:
    """See `Mechanism.clearance`. with_standing: links that do not move against each other count too."""
    check_whole("most", most, 1)
    stand, move = mechanism.check_ranges(values)
    if not move:
        best = _Best(mechanism, mechanism.position(stand))
        best.stand(set(), best.worst)
        return best.answer([], math.inf, 1, 0.0, np.empty((0, 3)), True)
    mechanism.position({**stand, **{name: ends[0] for name, ends in move.items()}})  # what is coupled is refused
    if len(move) == 1:
        return _along(mechanism, stand, move, error, with_standing)
    if any(mechanism.loops_of(name) for name in move):
        raise OptionError("a mechanism with loops is asked along one joint: give one range, and numbers of the others")
    return _Search(mechanism, stand, move, error, most).answer()


def _along(
    mechanism: Positions, stand: dict[str, float], move: Ranges, error: float, with_standing: bool
) -> MechanismClearance:
    """Along one joint, and all that follows it."""
    ((name, (begin, end)),) = move.items()
    roots = roots_of(mechanism, [name])
    pairs = moving_pairs(mechanism, roots)
    followed = whole(mechanism, name, stand, begin, end)
    is_loop = mechanism.loops_of(name)
    legs = (
        _with_spreads(mechanism, stand, name, followed, pairs, error)
        if is_loop
        else [(leg, [0.0] * len(pairs)) for leg in followed]
    )
    is_proven = all(math.isfinite(spread) for _, spreads in legs for spread in spreads)
    best = _Best(mechanism, legs[0][0].at(0.5))
    if with_standing:
        best.stand(roots, legs[0][0].start, begin)
    curve = _Curve(begin, end, best.upper)
    _follow_seats(best, pairs, [leg for leg, _ in legs])
    lower, boxes, open_ = math.inf, 0, 0.0
    for number, pair in enumerate(pairs):
        for leg, spreads in legs:
            spread = spreads[number]
            # Less than the error it need not be known, though it has met something already.
            within = max(best.upper, error) + (spread if is_proven else 0.0)
            found = _bounded(
                best, pair, leg, 0.5 * error if is_loop else error, within, stand if is_loop else None, name
            )
            boxes += len(found.lowers)
            lower = min(lower, found.lower - spread)
            curve.take(leg, found.edges, found.lowers - spread)
            spans = np.diff(found.edges)
            least = min(found.upper, best.upper) - 1.01 * error
            open_ += float(spans[found.lowers - spread < least].sum())
    curve.measure(mechanism, pairs, stand, name, [leg for leg, _ in legs], best)
    undecided = 0.0 if best.upper == 0.0 else min(1.0, open_ / max(1, len(pairs) * len(legs)))
    rows = curve.rows(max(0.0, min(lower, best.upper)), best.jams)
    is_certified = is_proven and not (is_loop and seats_of(mechanism, pairs))
    return best.answer(pairs, lower, boxes, undecided, rows, is_certified)


def _with_spreads(
    mechanism: Positions,
    stand: dict[str, float],
    name: str,
    legs: list[Leg],
    pairs: list[tuple[int, int]],
    error: float,
) -> list[tuple[Leg, list[float]]]:
    """Legs of a loop, and by how much each pair of links may be off them."""
    reach: dict[str, float] = {}
    for leg in legs:
        for place in (leg.start, leg.end):
            reach.update({each: max(reach.get(each, 0.0), abs(value)) for each, value in place.items()})
    wider = {each: value + mechanism.size for each, value in reach.items()}
    levers = [mechanism.bodies.levers(*pair, wider) for pair in pairs]
    return sure_legs(mechanism, name, stand, legs, levers, OFF * error)


def _bounded(
    best: _Best,
    pair: tuple[int, int],
    leg: Leg,
    error: float,
    within: float,
    stand: dict[str, float] | None = None,
    name: str = "",
) -> ClearanceAlong:
    """The least gap of two links along a leg, without their seats; where it is the least of all it is taken.

    stand: of a loop, the numbers that stand; the gap is then taken where the loop closes.
    """
    mechanism = best.mechanism
    tool, around = mechanism.bodies.tool(pair[0]), mechanism.bodies.alone(pair[1])
    pose, way = relative(mechanism, *pair, leg)
    found = around.clearance_along(tool, pose, way, error, within=within, ignore=mechanism.bodies.ignored(*pair))
    if found.upper < best.upper:
        place = leg.at(found.fraction)
        if stand is not None:
            place = mechanism.position({**stand, name: leg.value(found.fraction)}, leg.start)
        best.take(gap(mechanism, *pair, place, math.inf), place)
    return found


def _follow_seats(best: _Best, pairs: list[tuple[int, int]], legs: list[Leg]) -> None:
    """The seats that go deeper on some legs."""
    for pair in pairs:
        for seat in best.mechanism.bodies.seats(*pair):
            for leg in legs:
                met = seat_meeting(best.mechanism, pair, seat, leg)
                if met is not None:
                    best.jam(contact(best.mechanism, leg, pair, met), leg.at(met.share))
                    break


class _Curve:
    """The gap over one joint, and lower bounds between its rows.

    standing: the gap of all that does not move.
    """

    def __init__(self, begin: float, end: float, standing: float) -> None:
        self.values = np.linspace(begin, end, CURVE)
        half = 0.5 * (end - begin) / (CURVE - 1)
        self.edges = np.concatenate([[begin], self.values[:-1] + half, [end]])
        self.gaps = np.full(CURVE, standing)
        self.lowers = np.full(CURVE, math.inf)
        self._step = half

    def take(self, leg: Leg, edges: Floats, lowers: Floats) -> None:
        """Lower bounds of a pair on spans of a leg."""
        low, high = leg.value(edges[:-1]), leg.value(edges[1:])  # type: ignore[arg-type]
        first = np.clip(np.searchsorted(self.edges, low, "right") - 1, 0, CURVE - 1)
        last = np.clip(np.searchsorted(self.edges, high, "left") - 1, 0, CURVE - 1)
        for by in range(int((last - first).max(initial=0)) + 1):
            np.minimum.at(self.lowers, np.minimum(first + by, last), lowers)

    def measure(
        self,
        mechanism: Positions,
        pairs: list[tuple[int, int]],
        stand: dict[str, float],
        name: str,
        legs: list[Leg],
        best: _Best,
    ) -> None:
        """The gaps at its values."""
        positions = [_on(legs, value) for value in self.values.tolist()]
        if mechanism.loops_of(name):
            positions = [
                mechanism.position({**stand, name: value}, place)
                for value, place in zip(self.values.tolist(), positions, strict=True)
            ]
        all_poses = [mechanism.links.poses(position) for position in positions]
        for one, other in pairs:
            relative_poses = np.array([inverse(poses[other]) @ poses[one] for poses in all_poses])
            found = mechanism.bodies.alone(other).distance_batch(
                mechanism.bodies.tool(one), relative_poses, ignore=mechanism.bodies.ignored(one, other)
            )
            least = int(np.argmin(found.values))
            if found.values[least] < best.upper:
                best.take(gap(mechanism, one, other, positions[least], math.inf), positions[least])
            self.gaps = np.minimum(self.gaps, found.values)

    def rows(self, lower: float, jams: list[MechanismContact]) -> Floats:
        """`(n, 3)`: values, gaps, and lower bounds about them; 0 from where a seat goes deeper on."""
        if jams:
            first = int(np.searchsorted(self.values, min(jam.value for jam in jams)))
            self.gaps[min(first, CURVE - 1)] = 0.0
            self.lowers[max(0, first - 1) :], lower = 0.0, 0.0
        bounds = np.clip(np.maximum(self.lowers, lower), 0.0, self.gaps)
        return np.column_stack([self.values, self.gaps, bounds])


def _on(legs: list[Leg], value: float) -> dict[str, float]:
    """The position at a value of the joint."""
    for leg in legs:
        begin, end = leg.values
        if value <= end or leg is legs[-1]:
            return leg.at(0.0 if begin == end else min(1.0, max(0.0, (value - begin) / (end - begin))))
    return legs[-1].end


class _Search:
    """Boxes of joint values, those with the least bound first."""

    def __init__(self, mechanism: Positions, stand: dict[str, float], move: Ranges, error: float, most: int) -> None:
        self.most = most
        self.mechanism, self.stand, self.move, self.error = mechanism, stand, move, error
        self.names = list(move)
        self.lower = np.array([ends[0] for ends in move.values()])
        self.upper = np.array([ends[1] for ends in move.values()])
        roots = roots_of(mechanism, move)
        self.pairs = moving_pairs(mechanism, roots)
        corners = itertools.product(*move.values())
        reach = reaches(mechanism, *({**stand, **dict(zip(self.names, each, strict=True))} for each in corners))
        self.speeds = [self._speeds(pair, reach) for pair in self.pairs]
        # Each pair is moved along the joint that moves it farthest; boxes are of the others.
        self.ways = [int(np.argmax(speeds * (self.upper - self.lower))) for speeds in self.speeds]
        self.best = _Best(mechanism, mechanism.position(self._values(0.5 * (self.lower + self.upper))))
        self.best.stand(roots, self.best.worst)
        self.boxes = 0
        self._floor = math.inf

    def answer(self) -> MechanismClearance:
        """The bounds, once they are near enough or there are too many boxes."""
        is_followed = self._follow_seats()
        queue: list[tuple[float, int, int, Floats, Floats]] = []
        count = itertools.count()
        left: list[float] = []  # of pairs that one joint alone moves: no box can be cut

        def push(number: int, middle: Floats, half: Floats, least: float) -> None:
            less = np.where(self.speeds[number] > 0.0, half, 0.0)
            less[self.ways[number]] = 0.0
            spread = float(self.speeds[number] @ less) + _SLACK
            bound = max(least, self._ask(number, middle, spread) - spread)
            if bound < self.best.upper - self.error and not less.any():
                left.append(bound)
            elif bound < self.best.upper - self.error:
                heapq.heappush(queue, (bound, next(count), number, middle, half))
            else:
                self._floor = min(self._floor, bound)

        middle, half = 0.5 * (self.lower + self.upper), 0.5 * (self.upper - self.lower)
        for number in range(len(self.pairs)):
            push(number, middle, half, 0.0)
        while queue and queue[0][0] < self.best.upper - self.error and self.best.upper > 0.0 and self.boxes < self.most:
            bound, _, number, middle, half = heapq.heappop(queue)
            cut = self.speeds[number] * half
            cut[self.ways[number]] = 0.0
            axis = int(np.argmax(cut))
            less = half.copy()
            less[axis] *= 0.5
            for sign in (-1.0, 1.0):
                there = middle.copy()
                there[axis] += sign * less[axis]
                push(number, there, less, bound)
        lower = min([self.best.upper, self._floor, *left, *([queue[0][0]] if queue else [])])
        volume = float(np.prod(self.upper - self.lower)) or 1.0
        is_open = self.best.upper > 0.0
        open_ = [each for each in queue if each[0] < self.best.upper - self.error] if is_open else []
        share = sum(float(np.prod(2.0 * half)) for _, _, _, _, half in open_) / volume
        share = (share + is_open * sum(bound < self.best.upper - self.error for bound in left)) / max(
            1, len(self.pairs)
        )
        lower = lower if is_followed else 0.0
        return self.best.answer(self.pairs, lower, self.boxes, min(1.0, share), np.empty((0, 3)), is_followed)

    def _follow_seats(self) -> bool:
        """Whether all seats are followed at all positions: each moves with one joint alone, along which it is cast.

        One that several joints move is cast along the one that moves it farthest, with the others at a grid of values.
        """
        is_followed = True
        middle = 0.5 * (self.lower + self.upper)
        for pair, speeds, way in zip(self.pairs, self.speeds, self.ways, strict=True):
            if not self.mechanism.bodies.seats(*pair):
                continue
            others = [k for k in np.flatnonzero(speeds > 0.0).tolist() if k != way]
            is_followed &= not others
            count = max(2, int(SEAT_LINES ** (1.0 / max(1, len(others)))))
            for place in itertools.product(*(np.linspace(self.lower[k], self.upper[k], count) for k in others)):
                begin, end = middle.copy(), middle.copy()
                begin[others] = end[others] = place
                begin[way], end[way] = self.lower[way], self.upper[way]
                ends = [self.mechanism.position(self._values(each)) for each in (begin, end)]
                _follow_seats(self.best, [pair], [Leg(ends[0], ends[1], (float(begin[way]), float(end[way])))])
                if self.best.jams:
                    return is_followed
        return is_followed

    def _values(self, place: Floats) -> dict[str, float]:
        return {**self.stand, **dict(zip(self.names, place.tolist(), strict=True))}

    def _ask(self, number: int, place: Floats, spread: float) -> float:
        """A lower bound of the gap of a pair of links along one joint, the others in the middle of a box."""
        pair, way = self.pairs[number], self.ways[number]
        begin, end = place.copy(), place.copy()
        begin[way], end[way] = self.lower[way], self.upper[way]
        ends = [self.mechanism.position(self._values(each)) for each in (begin, end)]
        leg = Leg(ends[0], ends[1], (float(begin[way]), float(end[way])))
        # In as many spans as there may be boxes.
        far = float(self.speeds[number][way]) * (self.upper[way] - self.lower[way])
        error = max(0.5 * self.error, 0.5 * spread, 0.5 * far / self.most)
        found = _bounded(self.best, pair, leg, error, self.best.upper + spread)
        self.boxes += len(found.lowers)
        return found.lower if math.isfinite(found.upper) else math.inf  # infinite: it does not hold the least gap

    def _speeds(self, pair: tuple[int, int], reach: dict[str, float]) -> Floats:
        levers = self.mechanism.bodies.levers(*pair, reach)
        found = []
        for name in self.names:
            mine = self.mechanism.driven[name]
            rates = {
                other: by.ratio / mine.ratio for other, by in self.mechanism.driven.items() if by.root == mine.root
            }
            found.append(sum(abs(rates[other]) * lever for other, lever in levers.items() if other in rates))
        return np.array(found)
