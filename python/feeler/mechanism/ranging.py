"""How far a joint moves freely, and what clashes on the way.

Each link is cast against each other one along their relative motion, which is a chain of screws and slides. Seats, the
pairs of parts that are in contact where they are modelled, are left out there and followed by the rule of seats.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from feeler._core import Cast, Chain
from feeler.ignored import IgnoredPairs
from feeler.mechanism.answers import MechanismContact, MechanismSeat, Range
from feeler.mechanism.joint import JointKind
from feeler.mechanism.legs import STRAIGHT_M, Leg, Legs, halves, relative
from feeler.mechanism.positions import Positions
from feeler.mechanism.seating import Seated
from feeler.mockup import Tool
from feeler.poses import inverse
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Near = tuple[float, int, int, Floats, Floats]
"""A distance, both parts, and both points in the world."""

TOLERANCE_M = 2e-8
"""By how much a contact may be early."""
_TURN = 2.0 * np.pi  # how far a joint without limits is followed, both ways
_MOST_TURN = 999.0 * _TURN
_SIZES = 2.0  # the same of a slide, in sizes of the mock-up
_MOST_HALVES = 40
_SAME_SHARE = 1e-9
_SAME_VALUE = 5e-7
"""Contacts are as near as where a joint begins if it moves by less on the way, radians or metres."""
_LESS = 0.25  # of an overlap, the next
_LEAST_OVERLAP_M = 4e-12  # rounding
_AHEAD = 2.0  # times the time between two overlaps: enough for surfaces that approach at up to the third power of it
_PARTED = (2.0**-10, 2.0**-7, 2.0**-4, 2.0**-2)  # shares of a motion at which a seat may have parted


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where two parts meet on a leg."""

    share: float
    number: int
    """Of the link's tool; -1 of a seat."""
    part: int
    other: int
    point: Floats
    normal: Floats
    """Of the other link, where it is modelled."""


def range_of(mechanism: Positions, name: str, given: Mapping[str, float] | None) -> Range:
    """See `Mechanism.range`."""
    mechanism.check_name(name)
    at = mechanism.completed(mechanism.checked(given, "at"), name)
    start = mechanism.position(at)[name]
    at, origin = mechanism.freed(at, name)
    pairs = moving_pairs(mechanism, roots_of(mechanism, [name]))
    found: list[tuple[float, MechanismContact | None]] = []
    why = ""
    for end, limit in zip(span(mechanism, name, start), mechanism.limits(name) or (-np.inf, np.inf), strict=True):
        value, met, ended = _end(mechanism, name, at, (start, end), pairs, origin)
        if met is None and not ended and end != limit:
            if np.isfinite(limit) and repeats(mechanism, name):
                value = limit  # a turn is all
            elif np.isfinite(limit):
                ended = f"{name!r} was followed to {mechanism.said(name, end)}, not to its limit: it has too many turns"
            elif not repeats(mechanism, name):
                ended = f"{name!r} has no limit: it was followed to {mechanism.said(name, end)}"
        found.append((value, met))
        why = "; ".join(dict.fromkeys(each for each in (why, ended) if each))
    (lower, below), (upper, above) = found
    seats = seats_of(mechanism, pairs)
    return Range(name, start, lower, upper, below, above, seats, not mechanism.loops_of(name), why)


def span(mechanism: Positions, name: str, start: float) -> tuple[float, float]:
    """How far a joint is followed: to its limits; without limits a turn both ways, or a slide that leaves the mock-up.

    What only turns is not followed for more than a turn.
    """
    far = _TURN if mechanism.turns(name) else _SIZES * mechanism.size
    lower, upper = mechanism.limits(name) or (-np.inf, np.inf)
    if repeats(mechanism, name) or not np.isfinite(lower):
        lower = max(lower, start - far)
    if repeats(mechanism, name) or not np.isfinite(upper):
        upper = min(upper, start + far)
    most = _most(mechanism, name)
    return float(max(lower, start - most)), float(min(upper, start + most))


def _most(mechanism: Positions, name: str) -> float:
    """How far a number may move in one question: nothing turns by more than a thousand turns."""
    mine = mechanism.driven[name]
    rates = [
        abs(by.ratio / mine.ratio)
        for other, by in mechanism.driven.items()
        if by.root == mine.root and mechanism.turns(other)
    ]
    return _MOST_TURN / max(rates, default=1e-300)


def repeats(mechanism: Positions, name: str) -> bool:
    """Whether a turn of a joint leads back to where it begins: it alone turns, without pitch."""
    mine = mechanism.driven[name].root
    is_alone = sum(by.root == mine for by in mechanism.driven.values()) == 1 and not mechanism.loops_of(name)
    return is_alone and mechanism.turns(name) and mechanism.joint_of(name).kind is not JointKind.SCREW


def roots_of(mechanism: Positions, names: Iterable[str]) -> set[str]:
    """The roots that move with some numbers, those of their loops too."""
    roots = {mechanism.driven[name].root for name in names}
    for group, _ in mechanism.groups:
        if roots & group:
            roots |= group
    return roots


def solid_pairs(mechanism: Positions) -> list[tuple[int, int]]:
    """The pairs of links with triangles that joints can move against each other; the frame is the second of its
    pairs."""
    links = [link for link in [*range(len(mechanism.links)), -1] if mechanism.bodies.is_solid(link)]
    pairs = ((one, other) for place, one in enumerate(links) for other in links[place + 1 :])
    return [pair for pair in pairs if names_between(mechanism, pair)]


def names_between(mechanism: Positions, pair: tuple[int, int]) -> list[str]:
    """The numbers that say how two links are to each other."""
    up, down = mechanism.links.between(*pair)
    return [name for n in up + down for name in mechanism.links.links[n].joint.names]


def is_moved(mechanism: Positions, pair: tuple[int, int], roots: set[str]) -> bool:
    """Whether some roots move two links against each other."""
    return any(mechanism.driven[name].root in roots for name in names_between(mechanism, pair))


def moving_pairs(mechanism: Positions, roots: set[str]) -> list[tuple[int, int]]:
    """The pairs of links that some roots move against each other."""
    return [pair for pair in solid_pairs(mechanism) if is_moved(mechanism, pair, roots)]


def seats_of(mechanism: Positions, pairs: Iterable[tuple[int, int]]) -> tuple[MechanismSeat, ...]:
    """The seats of pairs of links."""
    paths = mechanism.mockup.part_paths
    return tuple(
        MechanismSeat(seat.part, seat.other, paths[seat.part], paths[seat.other], seat.kind)
        for pair in pairs
        for seat in mechanism.bodies.seats(*pair)
    )


def _end(
    mechanism: Positions,
    name: str,
    at: Mapping[str, float],
    ends: tuple[float, float],
    pairs: list[tuple[int, int]],
    origin: dict[str, float] | None,
) -> tuple[float, MechanismContact | None, str]:
    """The value of a joint where its way to another ends, what it meets there, and why else it ends."""
    begin, end = ends
    if begin == end:
        return end, None, ""
    legs, value = Legs(mechanism, name, at, begin, end, origin), begin
    for leg in legs:
        value = leg.values[1]
        found = _meeting(mechanism, name, at, leg, pairs, _MOST_HALVES)
        if found is not None:
            return found.value, found, ""
    return value, None, legs.why


def _meeting(
    mechanism: Positions,
    name: str,
    at: Mapping[str, float],
    leg: Leg,
    pairs: list[tuple[int, int]],
    most: int,
) -> MechanismContact | None:
    """The first contact on a leg; one of a loop is halved until it is straight where they meet."""
    met = _first(mechanism, leg, pairs)
    if met is None:
        return None
    if leg.off <= STRAIGHT_M or most == 0:
        return contact(mechanism, leg, *met, name)
    for half in halves(mechanism, name, at, leg):
        found = _meeting(mechanism, name, at, half, pairs, most - 1)
        if found is not None:
            return found
    return None


def _first(mechanism: Positions, leg: Leg, pairs: list[tuple[int, int]]) -> tuple[tuple[int, int], Meeting] | None:
    """What meets first on a leg: the links and their parts."""
    best: tuple[tuple[int, int], Meeting] | None = None
    for pair in pairs:
        found = [exactly(mechanism, pair, leg)]
        found += [seat_meeting(mechanism, pair, seat, leg) for seat in mechanism.bodies.seats(*pair)]
        for each in found:
            if each is not None and (best is None or each.share < best[1].share):
                best = (pair, each)
    return best


def exactly(
    mechanism: Positions, pair: tuple[int, int], leg: Leg, skipped: Iterable[tuple[int, int]] = ()
) -> Meeting | None:
    """The first contact of two links on a leg, seats and other pairs left out. Parts that touch where the leg begins
    may slide along each other, and part; they go no deeper."""
    bodies = mechanism.bodies
    pose, way = relative(mechanism, *pair, leg)
    around, tool, ignore = bodies.alone(pair[1]), bodies.tool(pair[0]), bodies.ignored(*pair, skipped)
    hit = around.cast(tool, pose, screw=way, tolerance=TOLERANCE_M, ignore=ignore)
    if hit is None:
        return None
    share = hit.fraction
    if _is_still_at(share, hit, pose, way, leg):
        entered = _entering(around, tool, ignore, leg, (pose, way))
        if entered is None:
            return None
        share, later = entered
        if share > 0.0 or (later.tool_part, later.part) != (hit.tool_part, hit.part):
            hit = later
    part = bodies.parts(pair[0])[hit.tool_part]
    return Meeting(share, hit.tool_part, part, hit.part, hit.point, hit.normal)


def _is_still_at(share: float, hit: Cast, pose: Floats, way: Chain, leg: Leg) -> bool:
    """Whether neither the number of the joint nor the point of a contact has moved by more than the tolerances."""
    if abs(leg.value(share) - leg.values[0]) > _SAME_VALUE:
        return False
    local = inverse(hit.pose) @ np.append(hit.point, 1.0)
    return bool(np.linalg.norm((way.at(pose, share) - pose) @ local) <= TOLERANCE_M)


def _entering(
    around: Scene, tool: Tool, ignore: IgnoredPairs | None, leg: Leg, moved: tuple[Floats, Chain]
) -> tuple[float, Cast] | None:
    """When one body first enters the other, never late, of two that touch where a leg begins, or are in each other
    there by rounding. moved: the pose and the way of the tool."""
    pose, way = moved

    def cast(overlap: float) -> Cast | None:
        found = around.cast(tool, pose, screw=way, tolerance=overlap, touching="free", ignore=ignore)
        if found is not None and found.fraction == 0.0 and leg.start != leg.end:
            found = around._cast_within(tool, pose, way, tolerance=overlap, ignore=ignore)
        return found

    overlap = TOLERANCE_M
    hit = cast(overlap)
    if hit is None:
        return None
    # It is late by the overlap. From how much less late it is with less of it follows where they only touched.
    late, early = 1.0, hit.fraction
    if leg.off > 0.0:  # legs of loops are off by some of the overlap: more of it
        found = cast(overlap / _LESS)
        late = 1.0 if found is None else found.fraction
    while (late == 1.0 or early == late) and early > 0.0 and overlap > _LEAST_OVERLAP_M:
        overlap *= _LESS
        found = cast(overlap)
        late, early = early, early if found is None else found.fraction
    share = max(0.0, early - _AHEAD * (late - early))
    return 0.0 if _is_still_at(share, hit, pose, way, leg) else share, hit


def seat_meeting(mechanism: Positions, pair: tuple[int, int], seat: Seated, leg: Leg) -> Meeting | None:
    """Where a seat first goes deeper on a leg than where it is modelled."""
    rest = _rest_share(mechanism, pair, leg)
    if rest is None:
        return _seat_on(mechanism, pair, seat, leg)
    middle = leg.at(rest)
    # Up to there it is followed from there, so that a part that comes back to its seat does not stop at it.
    found = None
    if rest > 0.0:
        found = _seat_on(mechanism, pair, seat, Leg(middle, leg.start, leg.values))
    if found is not None:
        ahead = _seat_on(mechanism, pair, seat, Leg(leg.start, middle, leg.values))
        share = 1.0 - found.share if ahead is None else ahead.share
        return replace(ahead or found, share=rest * share)
    found = _seat_on(mechanism, pair, seat, Leg(middle, leg.end, leg.values)) if rest < 1.0 else None
    return None if found is None else replace(found, share=rest + (1.0 - rest) * found.share)


def _rest_share(mechanism: Positions, pair: tuple[int, int], leg: Leg) -> float | None:
    """Where on a leg two links are to each other as they are modelled."""
    names = names_between(mechanism, pair)
    moves = [name for name in names if leg.start[name] != leg.end[name]]
    if not moves or any(leg.start[name] != 0.0 for name in names if name not in moves):
        return None
    shares = [-leg.start[name] / (leg.end[name] - leg.start[name]) for name in moves]
    if max(shares) - min(shares) > _SAME_SHARE or not 0.0 <= shares[0] <= 1.0:
        return None
    return shares[0]


def _seat_on(mechanism: Positions, pair: tuple[int, int], seat: Seated, leg: Leg) -> Meeting | None:
    pose, way = relative(mechanism, *pair, leg)
    met = seat.meets(pose, way)
    found = None if met is None else Meeting(met[0], -1, seat.part, seat.other, met[1], met[2])
    for begin in _PARTED:
        if found is not None and found.share <= begin:
            return found
        if seat.is_apart(way.at(pose, begin)):
            # All that it meets from there on is met exactly, by the surfaces that were seated too.
            rest = Leg(leg.at(begin), leg.end, leg.values)
            met = seat.meets(*relative(mechanism, *pair, rest))
            if met is None:
                return None
            return Meeting(begin + (1.0 - begin) * met[0], -1, seat.part, seat.other, met[1], met[2])
    return found


def contact(mechanism: Positions, leg: Leg, pair: tuple[int, int], met: Meeting, name: str = "") -> MechanismContact:
    """A meeting in the world; the part that a joint moves is the first. name: of the joint, if one is asked."""
    there = mechanism.links.poses(leg.at(met.share))[pair[1]]
    point, normal = there[:3, :3] @ met.point + there[:3, 3], there[:3, :3] @ met.normal
    part, other = met.part, met.other
    if _moves_second(mechanism, leg, pair, name):
        # Zeros stay without a sign.
        part, other, normal = other, part, 0.0 - normal
    paths = mechanism.mockup.part_paths
    return MechanismContact(
        leg.value(met.share),
        part,
        other,
        paths[part],
        paths[other],
        (float(point[0]), float(point[1]), float(point[2])),
        (float(normal[0]), float(normal[1]), float(normal[2])),
    )


def _moves_second(mechanism: Positions, leg: Leg, pair: tuple[int, int], name: str) -> bool:
    """Whether a joint moves the second of two links, not the first; what follows it counts where it is between
    neither."""
    first, second = (
        {each for n in side for each in mechanism.links.links[n].joint.names} for side in mechanism.links.between(*pair)
    )
    if name in first or name in second:
        return name in second
    moved = {each for each in first | second if leg.start[each] != leg.end[each]}
    return bool(moved & second) and not moved & first


def reaches(mechanism: Positions, *places: Mapping[str, float]) -> dict[str, float]:
    """The largest absolute values of all numbers at some positions, which are the ends of ranges."""
    found: dict[str, float] = {}
    for place in places:
        for name, value in mechanism.position(place).items():
            found[name] = max(found.get(name, 0.0), abs(value))
    return found


def gap(
    mechanism: Positions,
    one: int,
    other: int,
    position: dict[str, float],
    within: float,
    poses: list[Floats] | None = None,
    skipped: Iterable[tuple[int, int]] | None = None,
) -> Near | None:
    """The distance of two links at a position: metres, both parts, both points in the world; None beyond `within`.

    skipped: pairs of a part of the one's tool and one of the mock-up that have no gap; None: the seats.
    """
    poses = mechanism.links.poses(position) if poses is None else poses
    bodies = mechanism.bodies
    pose = inverse(poses[other]) @ poses[one]
    ignore = bodies.ignored(one, other) if skipped is None else bodies.without(one, list(skipped))
    near = bodies.alone(other).distance(bodies.tool(one), pose, within, ignore=ignore)
    if not np.isfinite(near.value):
        return None
    assert near.part is not None and near.tool_part is not None
    there = poses[other]
    ends = []
    for point in (near.point_on_tool, near.point_on_mockup):
        ends.append(poses[other][:3, 3] if point is None else there[:3, :3] @ np.asarray(point) + there[:3, 3])
    return near.value, bodies.parts(one)[near.tool_part], near.part, ends[0], ends[1]
