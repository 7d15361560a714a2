"""What waits to be sent to a page: order, bounds, and two states at most on their way."""

from __future__ import annotations

import itertools

from feeler.workbench.net.outbox import MOST_STATES, Outbox


def test_an_outbox_keeps_messages_in_order_and_counts_them() -> None:
    outbox = Outbox(most_waiting=3, most_bytes=100)
    assert all(outbox.put(text) for text in "abc")
    assert not outbox.put("d")
    assert [outbox.take() for _ in range(5)] == ["a", "b", "c", "d", None]
    assert outbox.put("a" * 100)
    assert not outbox.put("b")
    outbox.take()
    assert outbox.put("c" * 99)


def test_of_progress_the_newest_counts() -> None:
    outbox = Outbox(most_waiting=1)
    for i in range(100):
        outbox.put_newest(1, f"one {i}")
        outbox.put_newest(2, f"two {i}")
    outbox.drop_newest(2)
    assert outbox.put("event")
    assert [outbox.take() for _ in range(3)] == ["event", "one 99", None]


def test_two_states_are_on_their_way_at_most() -> None:
    # The engine makes 250 states a second; the page acknowledges each after a hundred milliseconds.
    outbox = Outbox()
    sent: list[int] = []
    on_their_way: list[tuple[int, int]] = []
    for tick in range(1, 1000):
        while on_their_way and tick - on_their_way[0][0] >= 25:
            outbox.acknowledged(on_their_way.pop(0)[1])
        if outbox.wants_state(tick):
            outbox.sent_state(tick)
            sent.append(tick)
            on_their_way.append((tick, tick))
        assert len(on_their_way) <= MOST_STATES
    assert len(sent) == 80 and sent == sorted({*sent})
    assert max(later - earlier for earlier, later in itertools.pairwise(sent)) <= 25


def test_one_acknowledgement_is_of_all_before_and_of_nothing_else() -> None:
    outbox = Outbox()
    outbox.sent_state(4)
    outbox.sent_state(7)
    assert not outbox.wants_state(8)
    for never_sent in (0, 5, 8, -1, 2**60):
        outbox.acknowledged(never_sent)
    assert not outbox.wants_state(8)
    outbox.acknowledged(7)
    assert outbox.wants_state(8) and not outbox.wants_state(7)
    outbox.acknowledged(7)
