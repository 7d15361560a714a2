"""What clashes at some position of a joint."""

from __future__ import annotations

from collections.abc import Mapping

from feeler.errors import OptionError
from feeler.mechanism.answers import MechanismClashes, MechanismContact
from feeler.mechanism.legs import whole
from feeler.mechanism.positions import Positions
from feeler.mechanism.ranging import contact, exactly, moving_pairs, roots_of, seat_meeting, seats_of
from feeler.mechanism.standing import Standing


def clashes_of(mechanism: Positions, values: Mapping[str, float | tuple[float, float]]) -> MechanismClashes:
    """See `Mechanism.clash`."""
    stand, move = mechanism.check_ranges(values)
    if len(move) > 1:
        raise OptionError(f"clash is asked of {len(move)} joints that move: give the range of one, numbers of others")
    if not move:
        standing = Standing(mechanism, set(), mechanism.position(stand))
        seats = seats_of(mechanism, standing.moved)
        return MechanismClashes("", 0.0, 0.0, tuple(standing.clashes()), seats)
    ((name, (lower, upper)),) = move.items()
    roots = roots_of(mechanism, [name])
    pairs = moving_pairs(mechanism, roots)
    legs = whole(mechanism, name, stand, lower, upper)
    standing = Standing(mechanism, roots, legs[0].start, lower)
    found: list[MechanismContact] = standing.clashes()
    for pair in pairs:
        skipped: set[tuple[int, int]] = set()
        waiting = list(mechanism.bodies.seats(*pair))
        for leg in legs:
            while (met := exactly(mechanism, pair, leg, skipped)) is not None:
                found.append(contact(mechanism, leg, pair, met, name))
                skipped.add((met.number, met.other))
            for seat in list(waiting):
                if (met := seat_meeting(mechanism, pair, seat, leg)) is not None:
                    found.append(contact(mechanism, leg, pair, met, name))
                    waiting.remove(seat)
    ordered = tuple(sorted(found, key=lambda each: each.value))
    return MechanismClashes(
        name, lower, upper, ordered, seats_of(mechanism, [*pairs, *standing.moved]), not mechanism.loops_of(name)
    )
