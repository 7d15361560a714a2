"""Files that pages send, and other mock-ups that they open: what is refused, what is kept, what is removed."""

from __future__ import annotations

import os
import struct
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from workbench_fake import FILES as PAGE_FILES
from workbench_fake import WAIT_S, FakeSession, Page, bearer, fetch

import feeler
from feeler.cli.projects import Work
from feeler.cli.view import _Opening
from feeler.errors import WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.document.openings import FilePiece, FileToSend, OpenMockup, SendFiles
from feeler.workbench.net.server import Server
from feeler.workbench.net.serving import Limits
from feeler.workbench.session.openings import Openings, Wanted
from feeler.workbench.session.sent_files import FileLimits
from feeler.workbench.session.session import Session


class Opened:
    """An opener that keeps what is wanted, and what the files held then."""

    def __init__(self) -> None:
        self.wanted: list[Wanted] = []
        self.held: list[list[bytes]] = []
        self.is_good = True
        self.done = threading.Event()

    def __call__(self, wanted: Wanted) -> bool:
        self.wanted.append(wanted)
        names = [source for source in wanted.sources or () if not source.startswith("sample:")]
        self.held.append([Path(name).read_bytes() for name in names])
        self.done.set()
        return self.is_good


@pytest.fixture(name="opened")
def opener() -> Opened:
    return Opened()


@pytest.fixture
def openings(tmp_path: Path, opened: Opened) -> Iterator[Openings]:
    made = Openings(FileLimits(bytes=1000, files=3, job_bytes=10), tmp_path)
    made.offer(opened)
    yield made
    made.close()
    assert list(tmp_path.iterdir()) == [], "nothing stays"


def send(openings: Openings, **files: bytes) -> int:
    """Announces and sends files; `a_stl` is a.stl. Their number."""
    named = {name.replace("_", "."): data for name, data in files.items()}
    listed: list[FileToSend] = [{"name": name, "bytes": len(data)} for name, data in named.items()]
    number: int = openings.request(SendFiles(1, "open", listed))["files"]
    for at, data in enumerate(named.values()):
        for k in range(0, len(data), 3):
            piece(openings, number, at, data[k : k + 3])
    return number


def piece(openings: Openings, files: int, file: int, data: bytes) -> Any:
    return openings.request(FilePiece(1, files, file, np.frombuffer(data, np.uint8)))


def wait(opened: Opened, openings: Openings) -> None:
    """Until the opener is done, and the thread that called it."""
    assert opened.done.wait(WAIT_S)
    opened.done.clear()
    wait_for_openings()


def wait_for_openings() -> None:
    """Until no mock-up is being opened."""
    for thread in threading.enumerate():
        if thread.name == "feeler opening":
            thread.join(WAIT_S)


def folders(tmp_path: Path) -> list[str]:
    return sorted(path.name for root in tmp_path.iterdir() for path in root.iterdir())


def test_files_come_in_pieces_and_are_opened(openings: Openings, opened: Opened, tmp_path: Path) -> None:
    number = send(openings, a_stl=b"solid a", b_obj=b"v 0 0 0", b_mtl=b"newmtl")
    openings.request(OpenMockup(1, number, None, "in"))
    wait(opened, openings)
    (wanted,) = opened.wanted
    assert wanted.unit == "in" and wanted.sources is not None
    assert [Path(each).name for each in wanted.sources] == ["a.stl", "b.obj"], "companions lie beside them"
    assert opened.held == [[b"solid a", b"v 0 0 0"]]
    assert Path(wanted.sources[1]).with_suffix(".mtl").read_bytes() == b"newmtl"
    if os.name != "nt":
        assert next(tmp_path.iterdir()).stat().st_mode & 0o077 == 0, "for nobody else"
    # Another unit needs the files again; other files do not.
    openings.request(OpenMockup(2, None, None, "mm"))
    wait(opened, openings)
    assert opened.wanted[1] == Wanted(None, "mm") and folders(tmp_path) == ["1"]
    openings.request(OpenMockup(3, send(openings, c_ply=b"ply"), None, None))
    wait(opened, openings)
    assert folders(tmp_path) == ["2"]
    opened.is_good = False
    openings.request(OpenMockup(3, send(openings, d_ply=b"not"), None, None))
    wait(opened, openings)
    assert folders(tmp_path) == ["2"], "what cannot be opened is not kept, what is open is"
    openings.request(OpenMockup(4, None, "gearbox", None))
    wait(opened, openings)
    assert opened.wanted[-1] == Wanted(("sample:gearbox",))


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ([], "no file"),
        ([("a.exe", 1)], "no format"),
        ([("a.FEELPROJ", 1)], "a.FEELPROJ is a project; start feeler view with it"),
        ([("a.stl.exe", 1)], "no format"),
        ([("stl", 1)], "no format"),
        ([("a.bin", 1)], "no format"),
        ([("", 1)], "name"),
        ([(".stl", 1)], "format"),
        ([("x" * 300 + ".stl", 1)], "name"),
        ([("\ud800.stl", 1)], "name"),
        ([("a.stl", 1), ("A.STL", 1)], "same name"),
        ([("a/b.stl", 1), ("a\\b.stl", 1)], "same name"),
        ([("a.stl", 1001)], "larger"),
        ([("a.stl", 600), ("b.stl", 600)], "larger"),
        ([("a.stl", -1)], "larger"),
        ([(f"{k}.stl", 1) for k in range(4)], "more than 3"),
    ],
)
def test_what_is_refused_before_a_byte_comes(
    openings: Openings, tmp_path: Path, files: list[tuple[str, int]], words: str
) -> None:
    listed: list[FileToSend] = [{"name": name, "bytes": size} for name, size in files]
    with pytest.raises(WorkbenchError, match=words):
        openings.request(SendFiles(1, "open", listed))
    assert list(tmp_path.iterdir()) == []


def test_a_name_is_never_a_path(openings: Openings, opened: Opened, tmp_path: Path) -> None:
    for name in ("../../a.stl", "/etc/a.stl", "..\\a.stl", "C:a.stl", "a\0b.stl", "a\nb.stl", "~/a.stl"):
        number = openings.request(SendFiles(1, "open", [{"name": name, "bytes": 0}]))["files"]
        openings.request(OpenMockup(1, number, None, None))
        wait(opened, openings)
        (source,) = opened.wanted[-1].sources or ()
        root = next(tmp_path.iterdir())
        assert Path(source).resolve().parent == (root / str(number)).resolve()
        assert not set(Path(source).name) & set('<>:"/\\|?*\0\n')
    assert [path.name for path in tmp_path.iterdir()] == [next(tmp_path.iterdir()).name], "and nothing is beside it"


@given(st.text(max_size=60))
def test_any_name_stays_in_its_folder(name: str) -> None:
    made = Openings()
    made.offer(lambda wanted: True)
    try:
        number = made.request(SendFiles(1, "open", [{"name": name + ".stl", "bytes": 0}]))["files"]
    except WorkbenchError:
        return
    else:
        sent = made.files._sent[number]
        assert [path.parent for path in sent.paths] == [sent.folder]
        assert [path.name for path in sent.folder.iterdir()] == [sent.paths[0].name]
    finally:
        made.close()


def test_pieces_that_do_not_belong(openings: Openings, tmp_path: Path) -> None:
    number = openings.request(SendFiles(1, "open", [{"name": "a.stl", "bytes": 5}]))["files"]
    for files, file in ((number + 1, 0), (-1, 0), (number, 1), (number, -1)):
        with pytest.raises(WorkbenchError, match=r"there (is|are) no file"):
            piece(openings, files, file, b"abc")
    piece(openings, number, 0, b"abc")
    with pytest.raises(WorkbenchError, match="not all"):
        openings.request(OpenMockup(1, number, None, None))
    with pytest.raises(WorkbenchError, match="more bytes"):
        piece(openings, number, 0, b"abc")
    assert folders(tmp_path) == [], "the whole set is given up"
    with pytest.raises(WorkbenchError, match="no files"):
        openings.request(OpenMockup(1, number, None, None))
    with pytest.raises(WorkbenchError, match="no sample"):
        openings.request(OpenMockup(1, None, "../etc", None))


def test_sets_that_nobody_opens_do_not_pile_up(openings: Openings, tmp_path: Path) -> None:
    for _ in range(10):
        openings.request(SendFiles(1, "open", [{"name": "a.stl", "bytes": 5}]))
    assert folders(tmp_path) == ["10", "7", "8", "9"]


def test_one_is_opened_at_a_time_and_none_after_the_end(openings: Openings, opened: Opened) -> None:
    go_on = threading.Event()

    def slow(wanted: Wanted) -> bool:
        assert go_on.wait(WAIT_S)
        return opened(wanted)

    openings.offer(slow)
    openings.request(OpenMockup(1, None, "gearbox", None))
    with pytest.raises(WorkbenchError, match="being opened"):
        openings.request(OpenMockup(2, None, "gearbox", None))
    go_on.set()
    wait(opened, openings)
    openings.close()
    with pytest.raises(WorkbenchError, match="no other mock-up"):
        openings.request(OpenMockup(3, None, "gearbox", None))


def test_what_the_command_opens_is_not_overtaken(openings: Openings, opened: Opened) -> None:
    go_on, order = threading.Event(), []

    def slow() -> None:
        assert go_on.wait(WAIT_S)
        order.append("command")

    openings.begin(slow)
    with pytest.raises(WorkbenchError, match="being opened"):
        openings.request(OpenMockup(1, None, "gearbox", None))
    assert opened.wanted == []
    go_on.set()
    wait_for_openings()
    openings.request(OpenMockup(2, None, "gearbox", None))
    wait(opened, openings)
    assert order == ["command"] and len(opened.wanted) == 1


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_after_a_start_that_went_wrong_pages_open_another(openings: Openings, opened: Opened) -> None:
    def wrong() -> None:
        raise RuntimeError("broken")

    openings.begin(wrong)
    wait_for_openings()
    openings.request(OpenMockup(1, None, "gearbox", None))
    wait(opened, openings)
    assert len(opened.wanted) == 1


def test_without_an_offer_nothing_is_opened() -> None:
    made = Openings()
    assert made.facts() is None
    with pytest.raises(WorkbenchError, match="no other mock-up"):
        made.request(SendFiles(1, "open", [{"name": "a.stl", "bytes": 5}]))
    assert made.request(SendFiles(1, "job", [{"name": "a.json", "bytes": 0}])) == {"files": 1}
    made.close()
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    with Session(has_threads=False) as session:
        session.open(scene.mockup, scene, None)
        assert session.openings.facts() is None, "scripts keep their scene"


def test_a_file_for_a_job_comes_the_same_way_and_is_read_once(
    openings: Openings, opened: Opened, tmp_path: Path
) -> None:
    """Of any name and format, and without anything to open."""
    for size in (11, -1):
        with pytest.raises(WorkbenchError, match="more than 0 MiB"):
            openings.request(SendFiles(1, "job", [{"name": "a.json", "bytes": size}]))
    with pytest.raises(WorkbenchError, match="more than"):
        openings.request(SendFiles(1, "job", []))
    number = openings.request(SendFiles(1, "job", [{"name": "../a.json", "bytes": 5}]))["files"]
    piece(openings, number, 0, b"abc")
    with pytest.raises(WorkbenchError, match="not all"):
        openings.files.read(number)
    number = openings.request(SendFiles(1, "job", [{"name": "../a.json", "bytes": 5}]))["files"]
    piece(openings, number, 0, b"abcde")
    assert [path.name for path in tmp_path.glob("*/*/*")] == ["file"] * 2
    with pytest.raises(WorkbenchError, match="there are no files"):
        openings.request(OpenMockup(1, number, None, None))
    assert openings.files.read(number) == b"abcde" and folders(tmp_path) == ["1"]
    with pytest.raises(WorkbenchError, match="no files"):
        openings.files.read(number)
    mesh = send(openings, a_stl=b"solid")
    with pytest.raises(WorkbenchError, match="no files"):
        openings.files.read(mesh)


# ---- over a socket ----


def test_only_a_page_with_the_token_sends_files() -> None:
    session = FakeSession()
    with Server(session, files=PAGE_FILES) as server:
        # No request of HTTP takes a body, with the token or without it.
        for headers in ([], [bearer(server.url)]):
            for path in ("/", "/open", "/files/1"):
                for method in ("POST", "PUT"):
                    told = fetch(server.url, path, *headers, ("Content-Length", "3"), method=method)[0]
                    assert told in (0, 400, 405), (method, path)
        for hello in (None, "wrong"):
            with Page(server.url, hello=hello) as stranger:
                stranger.send(SendFiles(1, "open", [{"name": "a.stl", "bytes": 3}]))
                assert stranger.code() == protocol.NOT_ALLOWED
        assert session.openings.came == []
        with Page(server.url) as page:
            page.next(protocol.Welcome)
            page.send(SendFiles(1, "open", [{"name": "a.stl", "bytes": 3}]))
            assert page.next(protocol.Answer).id == 1
            page.send(FilePiece(2, 1, 0, np.frombuffer(b"abc", np.uint8)))
            assert page.next(protocol.Answer).id == 2
        assert [type(each) for each in session.openings.came] == [SendFiles, FilePiece]


def test_a_page_that_does_not_wait_for_answers_is_refused() -> None:
    session = FakeSession()
    session.openings.go_on.clear()
    with Server(session, files=PAGE_FILES, limits=Limits(pieces=2)) as server, Page(server.url) as page:
        page.next(protocol.Welcome)
        for number in range(4):
            page.send(FilePiece(number, 1, 0, np.zeros(1000, np.uint8)))
        told = {page.next(protocol.Refusal).id for _ in range(2)}
        assert told <= {1, 2, 3} and len(told) == 2
        # The hand and questions go on meanwhile.
        page.send(protocol.Ask(9, "ray", {}))
        assert page.next(protocol.Answer).id == 9
        session.openings.go_on.set()
        assert len({page.next(protocol.Answer).id for _ in range(2)}) == 2


# ---- with the loader of feeler view ----


def cube(size: float) -> bytes:
    made: bytes = trimesh.creation.box((size,) * 3).export(file_type="stl")
    return made


def loaded(session: Session, openings: Openings, files: dict[str, bytes], unit: str | None = None) -> dict[str, Any]:
    """The document after a page has opened files."""
    number = None
    if files:
        listed: list[FileToSend] = [{"name": name, "bytes": len(data)} for name, data in files.items()]
        number = openings.request(SendFiles(1, "open", listed))["files"]
        for at, data in enumerate(files.values()):
            openings.request(FilePiece(1, number, at, np.frombuffer(data, np.uint8)))
    openings.request(OpenMockup(1, number, None, unit))
    wait_for_openings()
    return {**session.document()}


def test_a_file_replaces_the_sample_and_its_unit_is_corrected(capsys: pytest.CaptureFixture[str]) -> None:
    notices: list[str] = []
    with Session(has_threads=False) as session:
        session.subscribe(lambda event: notices.append(event["text"]) if event["type"] == "notice" else None)
        opening = _Opening(session, Work(["sample:differential:10000"], "sample:wrench", without=["*bolt*"]))
        opening.is_tool_kept = False
        session.openings.offer(opening.again)
        assert opening._run()
        first = session.document()
        assert first["tool"] is not None and first["doubts"] == []
        session.command("hide", {"parts": [0]})
        document = loaded(session, session.openings, {"part one.stl": cube(743_000.0)})
        assert document["mockup"]["name"] == "part one.stl" and document["loading"] is None
        assert document["tool"] is None and "wrench" in document["tools"], "as feeler view FILE: an empty hand"
        assert document["hidden"] == document["absent"] == []
        (doubt,) = document["doubts"]
        assert "743 m" in doubt and "/" not in doubt.split("part one")[0]
        with pytest.raises(WorkbenchError, match="nothing to undo"):
            session.command("undo", {})
        again = loaded(session, session.openings, {}, "um")
        assert again["mockup"]["name"] == "part one.stl" and again["doubts"] == []
        assert session.scene.mockup.bounds[1][0] == pytest.approx(0.3715)
        # What cannot be read leaves the present one, and says why without a path of the disk.
        failed = loaded(session, session.openings, {"bad.stl": struct.pack("<80sI", b"", 7)})
        assert failed["mockup"] == again["mockup"] and failed["loading"] is None and failed["failed"] is None
        assert "bad.stl" in notices[-1] and "feeler-" not in notices[-1]
        session.command("hide", {"parts": [0]})
    assert "bad.stl" in capsys.readouterr().err


def test_after_a_file_that_failed_at_the_start_another_is_opened(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_text("<b>nonsense</b>")
    with Session(has_threads=False) as session:
        opening = _Opening(session, Work([str(tmp_path / "bad.stl")]))
        session.openings.offer(opening.again)
        assert not opening._run() and opening.is_failed
        assert session.document()["failed"]
        document = loaded(session, session.openings, {"good.stl": cube(100.0)})
        assert document["failed"] is None and document["mockup"]["parts"] == 1 and not opening.is_failed


def test_others_are_told_who_opens_what(tmp_path: Path, opened: Opened) -> None:
    told: list[str] = []
    openings = Openings(FileLimits(bytes=1000, files=3, job_bytes=10), tmp_path, told.append)
    openings.offer(opened)
    openings.request(OpenMockup(1, send(openings, a_stl=b"solid"), None, None))
    wait(opened, openings)
    assert told == [], "nobody else is there"
    openings.request(OpenMockup(2, send(openings, b_stl=b"solid", c_ply=b"ply"), None, None), "Ann")
    wait(opened, openings)
    openings.request(OpenMockup(3, None, None, "in"), "Guest 2")
    wait(opened, openings)
    openings.request(OpenMockup(4, None, "gearbox", None), "Ann")
    wait(opened, openings)
    with pytest.raises(WorkbenchError):
        openings.request(OpenMockup(5, None, "../etc", None), "Ann")
    openings.close()
    assert told == [
        "Ann opens b.stl and 1 more",
        "Guest 2 loads the mock-up again, unit in",
        "Ann opens the sample gearbox",
    ]


def test_the_notice_of_an_opening_reaches_the_pages_of_a_session() -> None:
    session = Session()
    try:
        session.openings.offer(lambda _wanted: False)
        events: list[dict[str, Any]] = []
        session.subscribe(events.append)
        session.openings.request(OpenMockup(1, None, "gearbox", None), "Ann")
        texts = [(each["level"], each["text"]) for each in events if each["type"] == "notice"]
        assert texts == [("info", "Ann opens the sample gearbox")]
    finally:
        session.close()


def test_the_server_says_whose_page_opens() -> None:
    session = FakeSession()
    with Server(session, files=PAGE_FILES) as server, Page(server.url) as page:
        page.next(protocol.Welcome)
        page.send(OpenMockup(1, None, "gearbox", None))
        page.next(protocol.Answer)
        with Page(server.url) as other:
            other.next(protocol.Welcome)
            other.send(protocol.Named("Ann"))
            other.send(OpenMockup(2, None, "gearbox", None))
            other.next(protocol.Answer)
    assert session.openings.by == [None, "Ann"]


def test_a_ping_is_answered_while_everything_waits() -> None:
    session = FakeSession()
    session.openings.go_on.clear()
    try:
        with Server(session, files=PAGE_FILES) as server, Page(server.url) as page:
            page.next(protocol.Welcome)
            page.send(OpenMockup(1, None, "gearbox", None))
            page.send(protocol.Ping(7))
            assert page.next(protocol.Answer) == protocol.Answer(7, {})
    finally:
        session.openings.go_on.set()
