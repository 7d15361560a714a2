"""The workbench with a project: saved as one works, killed at any moment, opened again, and with newer revisions."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_project import HOSTILE, revision
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, Bench, at, cube, stand

import feeler
from feeler.errors import FeelerError, LoadError, WorkbenchError
from feeler.project.book import Book, open_or_make
from feeler.project.store import put
from feeler.workbench.document import findings
from feeler.workbench.document.document import Document
from feeler.workbench.document.keeping import NOT_KEPT, kept_fields, lists
from feeler.workbench.session import saving
from feeler.workbench.session.session import Session

WAIT_S = 60.0
AT_HOME = np.eye(4).ravel().tolist()
CLASHES = {
    "version": 1,
    "clashes": [
        {"id": "one", "a": PATHS[0], "b": PATHS[1], "depth": 0.002},
        {"id": "two \ud800", "a": PATHS[1], "b": PATHS[2], "depth": 0.003, "status": "active", "more": [1.0, None]},
        {"id": "three", "a": PATHS[3], "b": "gone", "gap": 0.0},
    ],
}


def opened(path: Path, mockup: feeler.Mockup | None = None, tool: feeler.Tool | None = None, **more: Any) -> Session:
    """A session without threads of the engine, with a project."""
    mockup = mockup or stand()
    session = Session(has_threads=False, project=open_or_make(path, **more))
    session.open(mockup, feeler.Scene(mockup), tool, tools=[cube(0.03125, "small")])
    return session


def book_of(session: Session) -> Book:
    assert session._saver is not None
    return session._saver._project


def saved(session: Session) -> dict[str, Any]:
    """The document as a page has it, once it is saved."""
    assert session._saver is not None and session._saver.wait(WAIT_S)
    document: dict[str, Any] = {**session.document()}
    assert document["project"]["state"] == "saved"
    return document


def worked(session: Session) -> None:
    """Something in each field."""
    do = session.command
    do("set_unit", {"unit": "in"})
    do("set_material", {"material": "steel"})
    do("hide", {"parts": [PLATE]})
    do("ghost", {"parts": [RIGHT], "is_on": True})
    do("explode", {"share": 0.25})
    do("section_add", {"normal": [0.0, 0.6, 0.8], "offset": 0.1})
    do("isolate", {"parts": [LEFT]})
    do("viewpoint_add", {"camera": {"position": [0, -3, 0], "target": [0, 0, 0], "up": [0, 0, 1], "fov_rad": 0.7}})
    do("measure_add", {"type": "parts", "parts": [LEFT, RIGHT], "name": "gap \U0001f600"})
    do("findings_open", {"findings": CLASHES})
    do("finding_status", {"id": "one", "status": "approved"})
    do("finding_filter", {"is_touching_hidden": False})
    do("take_tool", {"name": None})
    do("grip", {"parts": [PEG]})
    do("place", {"pose": at(0.3, 0.3, 0.9).ravel().tolist()})
    do("release", {})
    do("take_tool", {"name": "small"})
    do("set_mode", {"mode": "pass"})
    do("grip", {"parts": [LEFT, PEG]})
    do("place", {"pose": at(0.1, 0.2, 0.7, 0.5).ravel().tolist()})


def test_every_field_of_the_document_is_kept_or_of_one_run() -> None:
    empty = Document()
    assert set(kept_fields()) | NOT_KEPT == {*vars(empty)}
    assert set(lists()) >= {"sequence", "measures", "viewpoints"}


def test_opened_again_it_is_the_same_document_to_the_byte(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    worked(session)
    before, text = session.current, json.dumps(saved(session))
    session.close()
    for _ in range(2):
        session = opened(path, tool=cube())
        after = session.current
        assert json.dumps(saved(session)) == text
        for name in kept_fields():
            if name != "findings":  # a table is equal to itself alone
                assert getattr(after, name) == getattr(before, name), name
        assert findings.saved(after.findings) == findings.saved(before.findings)
        assert (after.isolation, after.next_id, after.sequence[0].starts) == (
            before.isolation,
            before.next_id,
            before.sequence[0].starts,
        )
        session.close()
    session = opened(path, tool=cube())
    session.command("release", {})
    assert len(session.current.sequence) == 2, "the hand goes on with what it held"
    session.command("undo", {})
    assert saved(session)["gripped"]
    session.close()
    assert [each.name for each in tmp_path.iterdir()] == ["a.feelproj"]


def test_the_hand_and_the_world_are_as_in_the_document(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    worked(session)
    held, pose, world = session.held_tool(), session.engine.pose, session.put_down()
    saved(session)
    session.close()
    session = opened(path)
    again = session.held_tool()
    assert held is not None and again is not None
    assert np.array_equal(held.vertices, again.vertices) and held.part_paths == again.part_paths
    assert np.array_equal(pose, session.engine.pose) and len(world) == len(session.put_down())
    session.close()


def test_a_replay_that_was_cut_off_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("grip", {"parts": [PEG]})
    session.command("place", {"pose": at(0.3, 0.3, 0.9).ravel().tolist()})
    session.command("release", {})
    session.command("sequence_replay", {"id": session.current.sequence[0].id})
    assert saved(session)["replaying"] is not None
    session.close()
    clock = [0.0]
    session = Session(has_threads=False, project=open_or_make(path), clock=lambda: clock[0])
    mockup = stand()
    session.open(mockup, feeler.Scene(mockup), None)
    assert session.current.replaying is not None
    for _ in range(2000):
        clock[0] += 1 / 60
        session.engine.tick()
        if session.current.replaying is None:
            break
    assert session.current.replaying is None and not session.current.gripped
    session.close()


def test_another_tool_than_last_time_replaces_the_one_of_the_project(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    session.command("take_tool", {"name": None})
    saved(session)
    session.close()
    session = opened(path, tool=cube())
    assert session.current.tool is None, "the empty hand of the project"
    saved(session)
    session.close()
    session = opened(path, tool=cube(0.125, "large"))
    assert session.current.tool is not None and session.current.tool.name == "large"
    saved(session)
    session.close()
    session = opened(path, tool=None)
    assert session.current.tool is not None and session.current.tool.name == "large", "its triangles are in the project"
    held = session.held_tool()
    assert held is not None and np.array_equal(held.vertices, cube(0.125).vertices)
    assert "large" in session.document()["tools"]
    session.close()
    whole = path.read_bytes()
    for value, data in (("null", b""), ('{"name": "large"}', b"x"), (None, b"short"), (None, None)):
        path.write_bytes(whole)
        book = open_or_make(path)
        row = next(each for each in book.rows("tools") if each.id == "large")
        book.write([put("tools", "large", 0, value or row.value, data)])
        book.close()
        session = Session(has_threads=False, project=open_or_make(path))
        with pytest.raises(LoadError, match="its tool is not as written"):
            open_in(session)
        session.close()


def open_in(session: Session) -> None:
    mockup = stand()
    session.open(mockup, feeler.Scene(mockup), None)


def test_cards_are_kept_and_open_questions_are_interrupted(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    asked(session)
    saved(session)
    before = session.current.cards
    session.close()
    session = opened(path)
    cards = session.current.cards
    assert [(card.id, card.title, card.parts, card.world) for card in cards] == [
        (card.id, card.title, card.parts, card.world) for card in before
    ]
    assert {card.state for card in cards} <= {"done", "failed", "cancelled"}
    asked(session)
    assert session.current.cards[-1].id == before[-1].id + 1
    session.close()


def asked(session: Session) -> None:
    session.command("ask", {"question": "removal", "parts": [PEG]})


# ---- saving ----


def test_a_change_is_shown_as_saved_when_it_is_on_the_disk_and_not_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    saved(session)
    goes_on, is_writing = threading.Event(), threading.Event()
    write = Book.write

    def slow(book: Book, changes: Any) -> None:
        is_writing.set()
        assert goes_on.wait(WAIT_S)
        write(book, changes)

    monkeypatch.setattr(Book, "write", slow)
    events: list[dict[str, Any]] = []
    session.subscribe(events.append)
    begin = time.perf_counter()
    session.command("hide", {"parts": [PLATE]})
    assert is_writing.wait(WAIT_S)
    session.command("hide", {"parts": [LEFT]})
    session.engine.tick()
    assert time.perf_counter() - begin < 5.0, "neither commands nor the engine wait for the disk"
    assert session.document()["project"]["state"] == "saving"
    assert events[0]["fields"]["hidden"] == [PLATE] and events[0]["fields"]["project"]["state"] == "saving"
    reader = feeler.open_project(path, read_only=True)
    assert reader.document()["hidden"] == []
    goes_on.set()
    assert saved(session)["hidden"] == [PLATE, LEFT] == reader.document()["hidden"]
    reader.close()
    states = [event["fields"]["project"]["state"] for event in events if "project" in event["fields"]]
    assert states[-1] == "saved" and states.count("saved") == 1, "the first write was not of the newest document"
    session.close()


def test_what_cannot_be_saved_is_told_and_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(saving, "RETRY_S", 0.01)
    path = tmp_path / "a.feelproj"
    session = opened(path)
    saved(session)
    connection = book_of(session)._store._connection
    assert connection is not None
    connection.execute("PRAGMA max_page_count = 10")
    told: list[dict[str, Any]] = []
    is_told = threading.Event()

    def hear(event: dict[str, Any]) -> None:
        facts = event.get("fields", {}).get("project")
        if facts and facts["state"] == "failed":
            told.append(facts)
            is_told.set()

    session.subscribe(hear)
    session.command("findings_open", {"findings": {"clashes": [{"a": "x" * 1000, "b": str(k)} for k in range(100)]}})
    assert is_told.wait(WAIT_S)
    assert told[0]["trouble"] == "cannot write a.feelproj: the disk is full; free some space"
    assert str(tmp_path) not in json.dumps(told), "pages see no folder"
    connection.execute("PRAGMA max_page_count = 100000")
    assert saved(session)["project"]["trouble"] is None
    session.close()
    session = opened(path)
    assert session.current.findings is not None
    session.close()


def test_the_end_of_a_script_closes_its_views(tmp_path: Path) -> None:
    script = (
        "import sys\nsys.path.insert(0, sys.argv[1])\nimport feeler, test_project_workbench as stands\n"
        "stand = stands.stand()\n"
        "views = [feeler.view(stand, None, browser=False, project=name) for name in ('a.feelproj', 'b.feelproj')]\n"
        "__import__('os').rename('b.feelproj', 'c.feelproj')\n"
        "for view in views:\n    view.hide([stands.PLATE])\n"
    )
    words = [sys.executable, "-c", script, str(Path(__file__).parent)]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert "not saved: cannot write b.feelproj" in ended.stderr
    with feeler.open_project(tmp_path / "a.feelproj") as project:
        assert project.document()["hidden"] == [PLATE]


def test_closing_a_view_tells_what_is_not_saved(tmp_path: Path) -> None:
    path, mockup = tmp_path / "a.feelproj", stand()
    view = feeler.view(mockup, None, browser=False, project=str(path))
    view.hide([PLATE])
    assert view.session._saver is not None and view.session._saver.wait(WAIT_S)
    path.rename(tmp_path / "b.feelproj")
    view.hide([PEG])
    with pytest.raises(feeler.WriteError, match=r"not saved: cannot write a\.feelproj: the file was moved"):
        view.close()
    view.close()
    (tmp_path / "b.feelproj").rename(path)
    with feeler.view(mockup, None, browser=False, project=str(path)) as view:
        view.hide([LEFT])
    with feeler.open_project(path) as project:
        assert project.document()["hidden"] == [PLATE, LEFT]
    with (
        pytest.warns(UserWarning, match="not saved"),
        pytest.raises(KeyError),
        feeler.view(mockup, None, browser=False, project=str(path)) as view,
    ):
        path.unlink()
        view.hide([PEG])
        raise KeyError


def test_a_read_only_project_is_shown_and_not_written(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("hide", {"parts": [PLATE]})
    saved(session)
    other = opened(path, read_only=True)
    assert other.document()["hidden"] == [PLATE] and other.document()["project"]["state"] == "read only"
    other.command("show_all", {})
    assert other.document()["project"]["state"] == "read only"
    other.close()
    session.close()
    session = opened(path)
    assert session.document()["hidden"] == [PLATE]
    session.close()


def test_a_newer_revision_says_what_is_stale_and_keeps_what_still_has_parts(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    worked(session)
    session.command("release", {})
    session.command("measure_add", {"type": "parts", "parts": [PEG, RIGHT], "name": "of the peg"})
    saved(session)
    session.close()
    # Another order of the parts; the peg is gone, the left post grew, the plate moved, and there is a new one.
    vertices, faces = [], []
    names = ["new", "stand/posts/right", "stand/plate", "sheet", "stand/posts/left"]
    there = revision(p0=("move", -0.5), p1=("scale", 1.25))
    order = [3, 2, 0, 4, 1]
    for number, part in enumerate(order):
        rows = there.faces[there.part_of_face == part]
        used = np.unique(rows)
        faces.append(np.searchsorted(used, rows) + sum(map(len, vertices)))
        vertices.append(there.vertices[used] * (2.0 if number == 0 else 1.0))
    counts = [len(each) for each in faces]
    newer = feeler.Mockup(
        np.concatenate(vertices), np.concatenate(faces), np.repeat(range(5), counts), names, part_paths=names
    )
    session = opened(path, newer, tool=cube())
    facts = saved(session)["project"]
    assert facts["stale"] == {"0": "new", "2": "moved", "4": "changed"}
    assert facts["gone"] == ["stand/peg"] and facts["aside"] == 2
    document = session.document()
    assert document["hidden"] == [1, 2, 3], "the right post, the plate and the sheet"
    assert [line["parts"] for line in document["sequence"]] == [[4]]
    assert [each["name"] for each in document["measures"]] == ["gap \U0001f600"]
    found = session.current.findings
    assert found is not None
    assert found.table.part_of_path[found.table.a[found.table.row_of["one"]]] == 2
    assert found.status["one"] == "approved"
    session.close()
    session = opened(path, newer, tool=cube())
    assert saved(session)["project"] == facts, "until somebody accepts it"
    again = session.document()
    for name in ("sequence", "measures", "cards", "requirements", "viewpoints"):
        assert again[name] == document[name], "what was of the peg is of no other part now"
    session.command("accept_revision", {})
    with pytest.raises(WorkbenchError, match="no part is stale"):
        session.command("accept_revision", {})
    assert saved(session)["project"]["stale"] == {}
    session.close()
    session = opened(path, newer, tool=cube())
    facts = saved(session)["project"]
    assert (facts["stale"], facts["gone"], facts["aside"]) == ({}, [], 2)
    session.close()


def test_places_of_parts_that_were_moved_before_follow_their_parts(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("set_mode", {"mode": "pass"})
    for x in (0.2, -0.3):
        session.command("grip", {"parts": [PEG]})
        session.command("place", {"pose": at(x, 0.1, 0.9).ravel().tolist()})
        session.command("release", {})
    starts = session.current.sequence[1].starts
    assert [part for part, _ in starts] == [PEG]
    saved(session)
    session.close()
    names = [PATHS[PEG], *PATHS[1:3], PATHS[PLATE], PATHS[4]]  # peg and plate have changed places in the file
    there = stand()
    swap = np.array([3, 1, 2, 0, 4])[there.part_of_face]
    order = np.argsort(swap, kind="stable")
    newer = feeler.Mockup(there.vertices, there.faces[order], swap[order], names, part_paths=names)
    session = opened(path, newer)
    assert session.current.sequence[1].starts == ((0, starts[0][1]),) and session.current.sequence[1].parts == (0,)
    assert saved(session)["project"]["stale"] == {}, "other numbers, the same parts"
    session.close()


def test_another_mock_up_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("hide", {"parts": [PLATE]})
    saved(session)
    session.close()
    content = path.read_bytes()
    mockup = feeler.sample("differential", 10_000)
    session = Session(has_threads=False, project=open_or_make(path))
    with pytest.raises(LoadError, match="about another mock-up"):
        session.open(mockup, feeler.Scene(mockup), None)
    session.close()
    session = opened(path)
    assert session.document()["hidden"] == [PLATE] and len(content) == path.stat().st_size
    session.close()


def test_parts_that_are_left_out_now_are_not_held(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("grip", {"parts": [PEG]})
    saved(session)
    session.close()
    mockup = stand()
    session = Session(has_threads=False, project=open_or_make(path))
    session.open(mockup, feeler.Scene(mockup).without([PEG]), None)
    assert session.document()["gripped"] == [] and session.document()["absent"] == [PEG]
    session.close()


# ---- documents of strangers ----


@pytest.mark.parametrize("table", ["document", "sequence", "measures", "views", "findings", "marks", "parts", "facts"])
def test_hostile_documents_are_refused_or_opened(tmp_path: Path, table: str) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    worked(session)
    saved(session)
    session.close()
    whole = path.read_bytes()
    with feeler.open_project(path, read_only=True) as project:
        rows = project._book.rows(table)
    chance, tried = random.Random(62), 0
    for row in rows:
        values = [json.dumps(each) for each in hostile(json.loads(row.value), chance)]
        for text in (*values, *HOSTILE[:: 3 if len(rows) < 6 else 9]):
            if table == "facts" and row.id == "openings":
                continue
            path.write_bytes(whole)
            book = open_or_make(path)
            book.write([put(table, row.id, row.place, text)])
            book.close()
            session = Session(has_threads=False, project=open_or_make(path))
            mockup = stand()
            try:
                session.open(mockup, feeler.Scene(mockup), cube(), tools=[cube(0.03125, "small")])
                session.document()
                session.engine.tick()
                session.command("undo", {}) if session._history.undo_depth else None
                session.command("show_all", {})
            except FeelerError:
                pass
            finally:
                session.close()
            tried += 1
    assert tried > 7


@pytest.mark.parametrize(
    ("table", "key", "value", "message"),
    [
        ("document", "hidden", "[7]", "there is no part 7"),
        ("document", "hidden", "[3,1]", "not in order"),
        ("document", "ghost", "[-1]", "there is no part -1"),
        ("document", "moved", '{"2":[1,2,3]}', "not a pose"),
        ("document", "gripped", '{"x":[]}', "'x'"),
        ("document", "mode", '"fly"', "a word that does not exist"),
        ("document", "explode", "1e9", "out of range"),
        ("document", "next_id", "1", "two things have one id"),
        ("document", "replaying", "99", "there is no such line"),
        ("document", "pose", "[1e300]", "1e\\+300"),
        ("document", "sections", '[{"id":1,"normal":[0,0],"offset":0.0,"is_on":true}]', "sections"),
        ("document", "section_box", '{"lower":[0,0,0],"upper":[1,1,0]}', "no inside"),
        ("document", "trip", '{"way":[],"touched":[],"seated":[]}', "it has no pose"),
        ("sequence", "10", '{"id":3}', "a value is missing"),
        ("marks", "one", '{"id":"one","status":"eaten"}', "a status that does not exist"),
    ],
)
def test_documents_that_nobody_could_have_made(tmp_path: Path, table: str, key: str, value: str, message: str) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path, tool=cube())
    worked(session)
    saved(session)
    session.close()
    book = open_or_make(path)
    book.write([put(table, key, 0, value)])
    book.close()
    session = Session(has_threads=False, project=open_or_make(path))
    with pytest.raises(LoadError, match=message):
        open_in(session)
    session.close()


def hostile(value: Any, chance: random.Random) -> list[Any]:
    """The value with one thing in it replaced by another kind, several times."""
    found = []
    for _ in range(2):
        changed = json.loads(json.dumps(value))
        holder, key = None, None
        inner = changed
        while isinstance(inner, (list, dict)) and inner and chance.random() < 0.8:
            holder, key = inner, chance.choice(list(inner) if isinstance(inner, dict) else range(len(inner)))
            inner = holder[key]
        other = chance.choice([None, -1, 10**6, 1e300, "x", [], {}, True, [[0]], {"a": 1}, 0.5])
        if holder is None:
            changed = other
        else:
            holder[key] = other
        found.append(changed)
    return found


# ---- kills ----


KILLS = int(os.environ.get("FEELER_PROJECT_KILLS", "4"))
CHILD = """
import random, sys, time
sys.path.insert(0, sys.argv[2])
from pathlib import Path
from test_project_workbench import digest_of, opened, random_command
from workbench_scene import cube
from feeler.workbench.session.saving import Saver
save = Saver._save
def noisy(saver, target, first):
    print("writing", digest_of(target), flush=True)
    save(saver, target, first)
Saver._save = noisy
session = opened(Path(sys.argv[1]), tool=cube())
def told(event):
    facts = event.get("fields", {}).get("project")
    if facts and facts["state"] == "saved":
        print("saved", digest_of(session.current), flush=True)
session.subscribe(told)
chance = random.Random(int(sys.argv[3]))
while True:
    random_command(session, chance)
    time.sleep(chance.choice([0.0, 0.001, 0.01]))
"""


def digest_of(document: Document) -> str:
    facts = {name: repr(getattr(document, name)) for name in kept_fields()}
    return hashlib.sha256(json.dumps(facts).encode("utf-8", "surrogatepass")).hexdigest()


def random_command(session: Session, chance: random.Random) -> bool:
    """Does something that a person does; whether it was possible."""
    part, ids = chance.randrange(5), [each.id for each in session.current.measures]
    name, args = chance.choice(
        [
            ("hide", {"parts": [part]}),
            ("show_all", {}),
            ("isolate", {"parts": [part]}),
            ("explode", {"share": chance.random()}),
            ("set_mode", {"mode": chance.choice(["stop", "glide", "pass"])}),
            ("grip", {"parts": [part]}),
            ("place", {"pose": at(*(chance.uniform(-0.5, 0.5) for _ in range(2)), 0.8).ravel().tolist()}),
            ("release", {}),
            ("put_back", {"parts": [part]}),
            ("measure_add", {"type": "point", "points": [[0, 0, 0], [chance.random(), 0, 1]]}),
            ("measure_remove", {"id": chance.choice(ids or [0])}),
            ("findings_open", {"findings": CLASHES}),
            ("finding_status", {"id": chance.choice(["one", "three"]), "status": chance.choice(["new", "approved"])}),
            ("undo", {}),
            ("redo", {}),
        ]
    )
    try:
        session.command(name, args)
    except FeelerError:
        return False
    return True


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
@pytest.mark.timeout(0)
def test_a_kill_at_any_moment_loses_nothing_that_was_shown_as_saved(tmp_path: Path) -> None:
    """The document found is the last one that was shown as saved, or a later one. FEELER_PROJECT_KILLS: how often."""
    path, chance = tmp_path / "a.feelproj", random.Random(62)
    later = shown_at_all = 0
    for kill in range(KILLS):
        words = [sys.executable, "-c", CHILD, path, Path(__file__).parent, kill]
        with subprocess.Popen([str(word) for word in words], stdout=-1, text=True) as process:
            assert process.stdout is not None
            lines: list[str] = []
            reading = threading.Thread(target=lines.extend, args=(process.stdout,))
            assert process.stdout.readline().startswith("writing")
            reading.start()
            if kill % 2:  # something is saved, however slow the machine
                end = time.monotonic() + WAIT_S
                while not any(line.startswith("saved") for line in lines) and time.monotonic() < end:
                    time.sleep(0.005)
            time.sleep(chance.choice([0.005, 0.05, 0.5]) * chance.random())
            process.send_signal(signal.SIGKILL)
            process.wait()
            reading.join()
        told = [line.split() for line in lines if line.endswith("\n")]
        places = [k for k, (kind, _) in enumerate(told) if kind == "saved"]
        session = opened(path, tool=cube())
        found = digest_of(session.current)
        saved(session)
        session.close()
        if places:
            shown = told[places[-1]][1]
            begun = [digest for kind, digest in told[places[-1] :] if kind == "writing"]
            assert found == shown or found in begun, f"kill {kill}"
            shown_at_all += 1
            later += found != shown
    assert shown_at_all > KILLS // 8
    assert KILLS < 50 or later > 0, "no kill came between a write and its message"


def test_a_view_of_a_script_has_a_project(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    mockup = stand()
    with feeler.view(feeler.Scene(mockup), cube(), browser=False, project=path) as view:
        view.hide("stand/plate")
        assert view.session._saver is not None and view.session._saver.wait(WAIT_S)
        with pytest.raises(feeler.ProjectError, match=f"process {os.getpid()}"):
            feeler.view(feeler.Scene(mockup), cube(), browser=False, project=path)
    with feeler.open_project(path) as project:
        assert project.document()["hidden"] == [PLATE]


def test_a_project_can_be_downloaded_without_one_on_the_disk(tmp_path: Path) -> None:
    bench = Bench(cube())
    bench.command("hide", parts=[PLATE])
    bench.command("findings_open", findings=CLASHES)
    written = bench.session.job("export_project", {}).result(WAIT_S)
    assert written["name"] == "arrays.feelproj"
    path = tmp_path / written["name"]
    path.write_bytes(bench.session.export(written["name"]))
    with feeler.open_project(path) as project:
        assert project.document()["hidden"] == [PLATE] and project.part_paths() == PATHS
        assert len(project.findings()) == 3
    session = opened(path, tool=cube())
    assert session.document()["hidden"] == [PLATE]
    session.close()


def answered(session: Session, question: str, parts: object) -> int:
    """The card of a question, once it is answered."""
    number = session.command("ask", {"question": question, "parts": parts})["id"]
    end = time.monotonic() + 120.0
    while next(card for card in session.current.cards if card.id == number).state != "done":
        assert time.monotonic() < end
        time.sleep(0.005)
    return number


def test_whole_answers_of_cards_are_kept_for_the_same_mock_up(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    way, room = answered(session, "removal", PEG), answered(session, "swept", PEG)
    document = saved(session)
    before = [session.ask("card", {"id": number}) for number in (way, room)]
    volume = session.card_room(room)
    session.close()
    session = opened(path)
    assert session.document()["cards"] == document["cards"]
    assert json.dumps([session.ask("card", {"id": number}) for number in (way, room)]) == json.dumps(before)
    assert session.card_room(room) == volume
    session.command("way_take", {"id": way})
    assert session.current.out == (PEG,)
    session.command("undo", {})
    session.command("card_remove", {"id": room})
    saved(session)
    session.close()
    with contextlib.closing(open_or_make(path)) as book:
        assert book.answer(f"card {way}") is not None and book.answer(f"card {room}") is None
    # Of another revision they may be wrong: what is left is the sentence.
    session = opened(path, revision(p1=("scale", 1.25)), tool=None)
    with pytest.raises(WorkbenchError, match="has no answer"):
        session.ask("card", {"id": way})
    session.close()


def test_answers_of_an_earlier_revision_are_stale_until_they_are_asked_again(tmp_path: Path) -> None:
    path, there = tmp_path / "a.feelproj", revision(p1=("scale", 1.25))
    session = opened(path)
    way = {"parts": [PEG], "poses": [AT_HOME, at(0, 0, 1.0).ravel().tolist()], "clearance": None}
    session.command("way_take", {"ways": [way]})
    session.command("way_check", {"id": session.document()["sequence"][0]["id"]})
    number = answered(session, "swept", LEFT)

    def stale() -> list[bool]:
        cards = session.document()["cards"]
        assert [card["is_stale"] for card in cards] == [card["is_earlier"] for card in cards]
        return [card["is_stale"] for card in cards]

    assert stale() == [False, False]
    saved(session)
    session.close()
    session = opened(path, there, tool=None)
    assert stale() == [True, True], "no part of theirs changed, but what is around them"
    session.command("accept_revision", {})
    assert stale() == [True, True]
    session.command("card_again", {"id": number})
    assert stale() == [True, False]
    saved(session)
    session.close()
    session = opened(path, there, tool=None)
    assert stale() == [True, False]
    session.close()


def test_checks_of_ways_are_kept_with_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    way = {"parts": [PEG], "poses": [AT_HOME, at(0, 0, 1.0).ravel().tolist()], "clearance": None}
    session.command("way_take", {"ways": [way]})
    number = session.command("way_check", {"id": session.document()["sequence"][0]["id"]})["id"]
    end = time.monotonic() + 120.0
    while session.current.cards[0].state != "done":
        assert time.monotonic() < end
        time.sleep(0.005)
    before = session.ask("card", {"id": number})
    document = saved(session)
    session.close()
    session = opened(path)
    assert session.document()["cards"] == document["cards"] and not session.document()["cards"][0]["is_stale"]
    assert json.dumps(session.ask("card", {"id": number})) == json.dumps(before)
    assert before is not None and before["ways"][0]["hit"]["part"] == 4, "the sheet is in the way"
    session.close()
    with contextlib.closing(open_or_make(path)) as book:
        facts, data = book.answer(f"card {number}")
        facts["ways"][0]["places"] = {"99": AT_HOME}
        book.write_answer(f"card {number}", "card", facts, data)
    session = opened(path)
    with pytest.raises(WorkbenchError, match="has no answer"):
        session.ask("card", {"id": number})
    session.close()


@pytest.mark.parametrize(
    "change",
    [
        {"ways": "x"},
        {"ways": [{}]},
        {"blockers": [{"part": 99, "attempts": 1, "is_proof": False, "pose": AT_HOME}]},
        {"blockers": [{"part": -1, "attempts": 1, "is_proof": False, "pose": AT_HOME}]},
        {"facts": [["a", "b"]]},
        {"more": 1},
        {"room": {"pieces": []}},
        {"id": None},
    ],
)
def test_answers_of_strangers_are_none(tmp_path: Path, change: dict[str, Any]) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    number = answered(session, "removal", PEG)
    saved(session)
    session.close()
    with contextlib.closing(open_or_make(path)) as book:
        facts, data = book.answer(f"card {number}")
        book.write_answer(f"card {number}", "card", {**facts, **change}, data)
    session = opened(path)
    with pytest.raises(WorkbenchError, match="has no answer"):
        session.ask("card", {"id": number})
    session.close()
