"""Several people on one workbench: their names, what they see of each other, and whose turn the tool is."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from workbench_fake import FILES, FakeSession, Page
from workbench_scene import LEFT, PEG, Bench, Clock, at, cube

from feeler.errors import WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.document.protocol_people import MOST_NAME, MOST_SELECTED
from feeler.workbench.document.protocol_values import Camera
from feeler.workbench.net.server import Server
from feeler.workbench.session.people import AWAY_S, DEVICE, IDLE_S, SCRIPT_S, PeopleOf

CAMERA: Camera = {"position": (2.0, 0.0, 0.0), "target": (0.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0), "fov_rad": 0.8}
START = at(0.0, 0.0, 1.0)


def here(*selection: int, point: Any = None, is_moving: bool = False, **camera: Any) -> protocol.Here:
    return protocol.Here(point, [*selection], {**CAMERA, **camera}, is_moving)  # type: ignore[typeddict-item]


class Room:
    """A session with some people, on a clock that is moved by hand."""

    def __init__(self, count: int = 2) -> None:
        self.bench = Bench(cube(), pose=START)
        self.session = self.bench.session
        self.people = self.session.people
        self.ids = [self.people.join() for _ in range(count)]

    def wait(self, seconds: float) -> None:
        """Time passes, in which all pages say that they are there."""
        for _ in range(int(seconds * 4)):
            self.bench.tick(0.25)
            for person in self.ids:
                self.people.here(person, here())

    def moves(self, person: int, pose: np.ndarray, source: str = "mouse") -> bool:
        """Whether a person's wish reaches the tool."""
        before = self.bench.pose.copy()
        self.bench.seq += 1
        is_allowed = self.session.wish(pose, self.bench.seq, source, person)
        self.bench.tick()
        assert is_allowed or np.array_equal(before, self.bench.pose)
        return is_allowed

    def turn(self, person: int, wish: Any, to: int | None = None) -> None:
        self.session.turn(person, protocol.Turning(1, wish, to))

    @property
    def has_tool(self) -> tuple[str | None, int | None, bool]:
        turn = self.people.people(self.ids[0]).turn
        return turn["kind"], turn["person"], turn["is_free"]

    @property
    def asked(self) -> list[int]:
        return self.people.people(self.ids[0]).turn["asked"]

    @property
    def names(self) -> list[str]:
        return [each["name"] for each in self.people.people(0).people]


def refused(words: str) -> Any:
    return pytest.raises(WorkbenchError, match=words)


# ---- turns ----


def test_who_moves_the_tool_has_it_and_others_are_refused() -> None:
    room = Room()
    one, other = room.ids
    assert room.has_tool == (None, None, True)
    assert room.moves(one, at(0.1, 0.0, 1.0))
    assert room.has_tool == ("page", one, False)
    assert not room.moves(other, at(0.5, 0.0, 1.0))
    with refused("^tool: Guest 1 has the tool; ask for it, or wait until it is free$"):
        room.session.command("place", {"pose": at(0.5, 0.0, 1.0).ravel().tolist()}, other)
    assert room.moves(one, at(0.2, 0.0, 1.0))
    np.testing.assert_allclose(room.bench.pose, at(0.2, 0.0, 1.0), atol=1e-5)


def test_a_tool_that_rests_is_free_for_whoever_moves_it_next() -> None:
    room = Room()
    one, other = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    room.wait(IDLE_S - 1)
    assert not room.moves(other, at(0.5, 0.0, 1.0))
    room.wait(1.5)
    assert room.has_tool == ("page", one, True)
    assert room.moves(other, at(0.5, 0.0, 1.0))
    assert room.has_tool == ("page", other, False)
    assert not room.moves(one, at(0.1, 0.0, 1.0))


def test_who_holds_the_tool_still_keeps_it() -> None:
    room = Room()
    one, other = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    for _ in range(10):
        room.wait(2)
        room.people.here(one, here(is_moving=True))
    assert not room.moves(other, at(0.5, 0.0, 1.0))
    # Who does not have the tool gets nothing by saying so.
    room.wait(IDLE_S + 1)
    room.people.here(other, here(is_moving=True))
    assert room.has_tool == ("page", one, True)


def test_the_tool_is_asked_for_and_given_or_kept() -> None:
    room = Room(3)
    one, two, three = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    with refused("Guest 1 has the tool"):
        room.turn(two, "take")
    room.turn(three, "ask")
    room.turn(two, "ask")
    room.turn(two, "ask")
    assert room.asked == [three, two]
    with refused("you do not have the tool"):
        room.turn(two, "give", two)
    room.turn(one, "give", two)
    assert room.has_tool == ("page", two, False)
    assert room.asked == [three]
    assert room.moves(two, at(0.3, 0.0, 1.0)) and not room.moves(one, at(0.1, 0.0, 1.0))
    room.turn(two, "keep")
    assert room.asked == [] and room.has_tool == ("page", two, False)
    room.turn(two, "let_go")
    assert room.has_tool == (None, None, True)
    room.turn(three, "ask")
    assert room.has_tool == ("page", three, False), "who asks for a free tool has it"


def test_a_tool_that_is_given_away_does_not_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    room = Room()
    one, other = room.ids
    gone: list[bool] = []
    monkeypatch.setattr(room.session.engine, "let_go", lambda: gone.append(True))
    room.moves(one, at(0.1, 0.0, 1.0))
    room.turn(other, "ask")
    assert not gone
    room.turn(one, "give", other)
    assert gone == [True]


def test_a_page_that_dies_frees_the_tool_and_its_colour() -> None:
    room = Room(3)
    one, two, three = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    room.turn(two, "ask")
    assert not room.people.leave(two)
    assert room.asked == []
    assert room.people.leave(one)
    assert room.has_tool == (None, None, True)
    assert room.moves(three, at(0.2, 0.0, 1.0))
    room.people.join()
    assert [(each["name"], each["colour"]) for each in room.people.people(three).people] == [
        ("Guest 3", 2),
        ("Guest 1", 0),
    ]
    with refused("this page is gone"):
        room.people.here(one, here())
    with refused("this page is gone"):
        room.turn(two, "take")


def test_a_page_that_falls_silent_is_away_and_loses_its_turn() -> None:
    room = Room()
    one, other = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    room.people.here(one, here(is_moving=True))
    for _ in range(int(AWAY_S * 4)):
        room.bench.tick(0.25)
        room.people.here(other, here())
    assert [each["is_away"] for each in room.people.people(other).people] == [True, False]
    assert room.moves(other, at(0.2, 0.0, 1.0))
    room.people.here(one, here())
    assert not any(each["is_away"] for each in room.people.people(other).people)
    # Alone, a page needs to say nothing.
    room.people.leave(other)
    room.bench.tick(10 * AWAY_S)
    assert not any(each["is_away"] for each in room.people.people(one).people)
    room.people.join()
    assert not any(each["is_away"] for each in room.people.people(one).people)


def test_a_script_may_always_move_and_has_the_tool_for_a_second() -> None:
    room = Room(1)
    (one,) = room.ids
    room.moves(one, at(0.1, 0.0, 1.0))
    room.session.command("place", {"pose": at(0.3, 0.0, 1.0).ravel().tolist()})
    assert room.has_tool == ("script", None, False)
    assert room.people.look_s is not None
    assert not room.moves(one, at(0.1, 0.0, 1.0))
    with refused("A script has the tool"):
        room.session.command("release", {}, one)
    room.bench.tick(SCRIPT_S)
    assert room.people.look_s is None, "one page, and nothing to wait for"
    assert room.moves(one, at(0.1, 0.0, 1.0))


def test_a_device_has_a_turn_while_it_moves() -> None:
    room = Room(1)
    (one,) = room.ids
    assert room.moves(DEVICE, at(0.1, 0.0, 1.0), "device")
    assert room.has_tool == ("device", None, False)
    with refused("The device has the tool"):
        room.people.check_move(one)
    # It trembles, which is no move.
    for _ in range(100):
        assert room.moves(DEVICE, at(0.1001, 0.0, 1.0), "device")
        room.bench.tick(IDLE_S / 50)
    assert room.moves(one, at(0.2, 0.0, 1.0))
    assert not room.moves(DEVICE, at(0.1, 0.0, 1.0), "device")
    room.wait(IDLE_S + 1)
    assert not room.moves(DEVICE, at(0.1, 0.0, 1.0), "device"), "it rests"
    assert room.moves(DEVICE, at(0.15, 0.0, 1.0), "device")
    assert not room.moves(one, at(0.2, 0.0, 1.0))


# ---- the document is everybody's ----


def test_the_document_is_everybodys_and_the_hand_its_holders() -> None:
    room = Room()
    one, other = room.ids
    command = room.session.command
    command("grip", {"parts": [PEG]}, one)
    assert room.has_tool == ("page", one, False)
    for name, args in (("release", {}), ("grip", {"parts": [LEFT]}), ("set_mode", {"mode": "pass"})):
        with refused("Guest 1 has the tool"):
            command(name, args, other)
    command("hide", {"parts": [LEFT]}, other)
    command("section_add", {"normal": [0, 0, 1], "offset": 0.0}, other)
    assert room.bench.document["hidden"] == [LEFT] and len(room.bench.document["sections"]) == 1
    # Undo takes back the last step, whoever made it; what moves the hand is its holder's.
    command("undo", {}, one)
    assert room.bench.of_type("notice")[-1]["text"] == "Guest 1 undid a step of Guest 2 (section add)"
    command("redo", {}, one)
    assert room.bench.of_type("notice")[-1]["text"] == "Guest 1 redid a step of Guest 2 (section add)"
    count = len(room.bench.of_type("notice"))
    command("undo", {}, other)
    command("undo", {}, other)
    assert len(room.bench.of_type("notice")) == count, "their own steps"
    with refused("Guest 1 has the tool"):
        command("undo", {}, other)
    assert room.bench.document["gripped"] == [PEG]
    command("undo", {}, one)
    assert room.bench.document["gripped"] == []
    room.wait(IDLE_S + 1)
    command("redo", {}, other)
    assert room.has_tool == ("page", other, False)
    command("redo", {}, one)
    command("redo", {}, one)
    with refused("there is nothing to redo"):
        command("redo", {}, one)


def test_a_replay_is_nobody_elses_to_move() -> None:
    room = Room()
    one, other = room.ids
    command = room.session.command
    command("grip", {"parts": [PEG]}, one)
    command("place", {"pose": at(0.0, 0.25, 1.2).ravel().tolist()}, one)
    command("release", {}, one)
    (line,) = room.bench.document["sequence"]
    command("put_back", {"parts": [PEG]}, one)
    room.wait(IDLE_S + 1)
    command("sequence_replay", {"id": line["id"]}, other)
    for _ in range(2000):
        if room.bench.document["replaying"] is None:
            break
        assert room.has_tool == ("page", other, False)
        assert not room.session.wish(START, 999, "mouse", one)
        room.wait(0.25)
    assert room.bench.document["gripped"] == [] and [*room.bench.document["moved"]] == [str(PEG)]
    room.wait(IDLE_S + 1)
    assert room.has_tool == ("page", other, True)


def test_nothing_of_people_is_in_the_document_or_in_undo() -> None:
    room = Room()
    one, other = room.ids
    before, event = room.bench.document, room.session.last_event
    depth = room.session.command("hide", {"parts": [LEFT]}, one)["undo_depth"]
    room.people.name(one, "Ann")
    room.people.here(one, here(PEG, point=(0.0, 0.0, 0.1)))
    room.turn(other, "take")
    room.turn(other, "let_go")
    assert room.session.command("show", {"parts": [LEFT]}, one)["undo_depth"] == depth + 1
    assert room.bench.document == before and room.session.last_event == event + 2
    assert "Ann" not in json.dumps(room.bench.document)


# ---- names, and pages that lie ----


def test_four_people_differ_by_name_and_colour() -> None:
    room = Room(4)
    one, two, three, four = room.ids
    assert room.names == ["Guest 1", "Guest 2", "Guest 3", "Guest 4"]
    room.people.name(one, "Ann")
    room.people.name(two, " ann\n ")
    room.people.name(three, "x" * MOST_NAME)
    room.people.name(four, "x" * MOST_NAME)
    assert room.names == ["Ann", "ann 2", "x" * MOST_NAME, "x" * (MOST_NAME - 2) + " 2"]
    room.people.name(one, "Ann")
    room.people.name(two, "")
    assert room.names[:2] == ["Ann", "Guest 1"]
    assert [each["colour"] for each in room.people.people(one).people] == [0, 1, 2, 3]
    assert room.people.people(three).you == three


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("<img src=x onerror=alert(1)>", "<img src=x onerror=alert(1)>"),
        ("\u202egnp.exe\u200b\x00\x1b[31m", "gnp.exe [31m"),
        ("\ud83d\ude00".encode("utf-16", "surrogatepass").decode("utf-16"), "\U0001f600"),
        ("   ", "Guest 1"),
    ],
)
def test_a_name_is_plain_text(name: str, shown: str) -> None:
    room = Room()
    room.people.name(room.ids[0], name)
    assert room.names[0] == shown


def test_what_cannot_be_is_refused_and_leaves_no_trace() -> None:
    room = Room()
    one, other = room.ids
    room.people.here(one, here(PEG))
    for wrong, words in (
        (here(5), "there is no part 5"),
        (here(-1), "there is no part -1"),
        (here(*[0] * (MOST_SELECTED + 1)), "1,001 parts are selected"),
        (here(point=(0.0, 1e300, 0.0)), "out of all reach"),
        (here(position=(1e10, 0.0, 0.0)), "the camera sees nothing"),
        (here(position=(0.0, 0.0, 0.0)), "the camera sees nothing"),
        (here(up=(0.0, 0.0, 0.0)), "the camera sees nothing"),
        (here(up=(-1.0, 0.0, 0.0)), "the camera sees nothing"),
        (here(fov_rad=0.0), "the camera sees nothing"),
    ):
        with refused(words):
            room.people.here(one, wrong)
    seen = room.people.seen(one)
    assert seen is not None and seen.selection == [PEG] and room.people.seen(other) is None
    with refused("the name has 1,000,000 characters; choose one of at most 40") as caught:
        room.people.name(one, "<" * 1_000_000)
    assert len(str(caught.value)) < 200
    room.moves(one, at(0.1, 0.0, 1.0))
    for nobody in (one, 99, None, 0, -1):
        with refused("there is no such person"):
            room.turn(one, "give", nobody)
    assert room.has_tool == ("page", one, False)


def test_news_is_of_what_changed_and_only_the_newest() -> None:
    clock = Clock()
    told: list[int] = []
    people = PeopleOf(clock, parts=lambda: 5)
    end = people.on_news(lambda: told.append(1))
    one = people.join()
    assert people.news().is_about_people and people.look_s is None
    people.may_move(one)
    people.news()
    told.clear()
    # Alone, a hand that moves costs nothing.
    for _ in range(100):
        assert people.may_move(one)
    assert not told and not people.news().is_about_people
    other = people.join()
    for part in [0, 1, 2] * 1000:
        people.here(one, here(part))
    news = people.news()
    assert news.seen == (one,) and news.is_about_people
    seen = people.seen(one)
    assert seen is not None and seen.selection == [2]
    told.clear()
    people.here(one, here(2))
    assert not told and people.news() == type(news)(False, ())
    people.here(other, here(1))
    people.leave(other)
    assert people.news().seen == ()
    told.clear()
    end()
    people.join()
    assert not told


steps = st.tuples(
    st.sampled_from(["move", "device", "script", "take", "ask", "give", "keep", "let_go", "here", "leave", "join"]),
    st.integers(0, 3),
    st.integers(-1, 6),
    st.sampled_from([0.0, 0.5, 2.0, 5.0, 9.0]),
)


@given(st.lists(steps, max_size=60))
def test_there_is_one_holder_whatever_comes(given_steps: list[Any]) -> None:
    clock = Clock()
    people = PeopleOf(clock)
    pages = [people.join() for _ in range(4)]
    for kind, who, to, seconds in given_steps:
        clock.now += seconds
        before = people.people(0).turn
        try:
            if kind == "join":
                pages[who] = people.join()
            elif kind == "leave":
                people.leave(pages[who])
            elif kind == "here":
                people.here(pages[who], here(is_moving=True))
            elif kind in ("move", "device", "script"):
                mover = {"device": DEVICE, "script": 0}.get(kind, pages[who])
                holder = before["person"] or {"device": DEVICE, "script": 0}.get(before["kind"] or "")
                is_allowed = people.may_move(mover, at(float(to), 0.0, 0.0))
                if not before["is_free"] and holder != mover and mover != 0:
                    assert not is_allowed
            else:
                people.turn(pages[who], protocol.Turning(1, kind, to))
        except WorkbenchError:
            pass
        now = people.people(0)
        there = {each["id"] for each in now.people}
        assert now.turn["person"] is None or now.turn["person"] in there
        assert {*now.turn["asked"]} <= there - {now.turn["person"]}
        assert len({each["name"] for each in now.people}) == len({each["colour"] for each in now.people}) == len(there)


numbers = st.floats(allow_nan=False, allow_infinity=False) | st.sampled_from([0.0, 1.0, -1.0])
points = st.tuples(numbers, numbers, numbers)
cameras = st.fixed_dictionaries(
    {"position": points, "target": points, "up": points, "fov_rad": numbers}, optional={"is_parallel": st.booleans()}
)
said = st.one_of(
    st.builds(protocol.Named, st.text(max_size=60)),
    st.builds(protocol.Here, st.none() | points, st.lists(st.integers(-2, 6), max_size=4), cameras, st.booleans()),
    st.builds(
        protocol.Turning,
        st.integers(),
        st.sampled_from(["take", "ask", "give", "keep", "let_go"]),
        st.none() | st.integers(-2, 6),
    ),
)


@given(st.lists(st.tuples(st.integers(0, 1), said), max_size=30))
def test_whatever_a_page_says_others_can_show(messages: list[Any]) -> None:
    people = PeopleOf(Clock(), parts=lambda: 5)
    pages = [people.join(), people.join()]
    for who, message in messages:
        try:
            if isinstance(message, protocol.Named):
                people.name(pages[who], message.name)
            elif isinstance(message, protocol.Here):
                people.here(pages[who], message)
            else:
                people.turn(pages[who], message)
        except WorkbenchError as error:
            assert len(str(error)) < 300
        for each in people.people(pages[0]).people:
            assert 0 < len(each["name"]) <= MOST_NAME and each["name"].isprintable(), ascii(each["name"])
        for page in pages:
            seen = people.seen(page)
            if seen is None:
                continue
            assert {*seen.selection} <= {*range(5)}
            ahead = np.subtract(seen.camera["target"], seen.camera["position"])
            assert np.isfinite(ahead).all() and np.linalg.norm(np.cross(ahead, seen.camera["up"])) > 0.0
            decoded = protocol.decode_from_server(protocol.encode(seen))
            assert decoded == seen


# ---- through the sockets ----


@pytest.fixture
def session() -> FakeSession:
    return FakeSession()


@pytest.fixture
def server(session: FakeSession) -> Iterator[Server]:
    with Server(session, files=FILES, clock=lambda: 0.0) as server:
        yield server


def about(people: protocol.People) -> list[tuple[int, str]]:
    return [(each["id"], each["name"]) for each in people.people]


def test_pages_see_each_other_come_and_go(server: Server) -> None:
    with Page(server.url) as page:
        first = page.next(protocol.People)
        assert about(first) == [(first.you, "Guest 1")]
        with Page(server.url) as other:
            other.next(protocol.People)
            page.send(protocol.Named("<b>Ann</b>"))
            page.send(here(3, point=(0.5, 0.0, 0.25)))
            both = other.next(protocol.People, lambda people: people.people[0]["name"] == "<b>Ann</b>")
            assert about(both) == [(first.you, "<b>Ann</b>"), (both.you, "Guest 2")]
            seen = other.next(protocol.Seen)
            assert (seen.person, seen.selection, seen.point) == (first.you, [3], (0.5, 0.0, 0.25))
            with Page(server.url) as third:
                assert third.next(protocol.Seen) == seen, "who comes later sees it, too"
        assert about(page.next(protocol.People, lambda people: len(people.people) == 1)) == [(first.you, "<b>Ann</b>")]


def test_the_turn_goes_through_the_sockets(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page, Page(server.url) as other:
        one, two = page.next(protocol.People).you, other.next(protocol.People).you
        page.send(protocol.Wish(1, 0.0, "mouse", START))
        other.next(protocol.People, lambda people: people.turn["person"] == one)
        # Refused, and told so once in a second.
        for seq in range(2, 30):
            other.send(protocol.Wish(seq, 0.0, "mouse", START))
        other.send(protocol.Turning(7, "take", None))
        refusals = [other.next(protocol.Refusal), other.next(protocol.Refusal)]
        assert [each.id for each in refusals] == [None, 7]
        wanted = {"what": "Guest 1 has the tool", "where": "tool", "do": "ask for it, or wait until it is free"}
        assert [each.error for each in refusals] == [wanted, wanted]
        assert session.wishes.get()[1] == 1 and session.wishes.empty()
        other.send(protocol.Turning(8, "ask", None))
        assert other.next(protocol.Answer).id == 8
        assert page.next(protocol.People, lambda people: people.turn["asked"] != []).turn["asked"] == [two]
        page.send(protocol.Turning(9, "give", two))
        other.next(protocol.People, lambda people: people.turn["person"] == two)
        other.send(protocol.Wish(30, 0.0, "mouse", START))
        assert session.wishes.get()[1] == 30
        other.close()
        page.next(protocol.People, lambda people: people.turn["person"] is None)
        assert session.gone.wait(60), "the hand is let go, though a page is left"


def test_a_flood_of_places_is_passed_on_now_and_then(server: Server) -> None:
    with Page(server.url) as page, Page(server.url) as other:
        page.next(protocol.People), other.next(protocol.People)
        for number in range(900):
            page.send(here(number % 4, point=(0.0, 0.0, number / 1000)))
        page.send(here(4))
        came = 1
        while other.next(protocol.Seen).selection != [4]:
            came += 1
        assert came < 450


@pytest.mark.parametrize(
    "frame",
    [
        '{"kind":"name"}',
        '{"kind":"name","name":7}',
        '{"kind":"name","name":"' + "<" * 1_000_000 + '"}',
        '{"kind":"here","point":null,"selection":[],"camera":{},"is_moving":false}',
        '{"kind":"here","point":[1e999,0,0],"selection":[],"camera":null,"is_moving":false}',
        '{"kind":"here","point":null,"selection":["*"],"camera":null,"is_moving":false}',
        '{"kind":"turn","id":1,"wish":"seize","to":null}',
        '{"kind":"turn","id":1,"wish":"give","to":"Guest 1"}',
        '{"kind":"people","you":1,"people":[],"turn":null}',
        '{"kind":"seen","person":1,"point":null,"selection":[],"camera":null}',
    ],
    ids=lambda frame: frame[:50],
)
def test_a_page_that_lies_is_refused_and_stays(server: Server, frame: str) -> None:
    with Page(server.url) as page, Page(server.url) as other:
        other.next(protocol.People)
        page.raw(frame)
        refusal = page.next(protocol.Refusal)
        assert len(json.dumps(refusal.error)) < 400
        page.send(protocol.Named("still here"))
        names = other.next(protocol.People, lambda people: "still here" in dict(about(people)).values())
        assert len(names.people) == 2
