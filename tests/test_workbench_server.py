"""The workbench's server: whom it refuses, what it survives, and that no page disturbs another.

Nothing here depends on how fast the machine is: what takes a while is waited for, and the clock of limits is passed in.
"""

from __future__ import annotations

import base64
import json
import logging
import socket
import struct
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import InvalidHandshake
from workbench_fake import FILES, WAIT_S, FakeSession, FakeSnapshot, Page, bearer, fetch, raw_page, token_of

from feeler.errors import WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.files import static_files
from feeler.workbench.net.guard import new_token
from feeler.workbench.net.server import Server
from feeler.workbench.net.serving import Limits

SECRETS = ["/scene", "/scene/pieces/0", "/scene/sent/0", "/held/1", "/exports/a.csv", "/findings/00ff"]


@pytest.fixture
def session() -> FakeSession:
    return FakeSession()


@pytest.fixture
def server(session: FakeSession) -> Iterator[Server]:
    with Server(session, files=FILES) as server:
        yield server


def still_answers(server: Server) -> None:
    assert fetch(server.url, "/")[0] == 200
    with Page(server.url) as page:
        page.next(protocol.Welcome)
        page.send(protocol.Ask(1, "ray", {}))
        assert page.next(protocol.Answer).id == 1


# ---- files and geometry ----


def test_the_address_has_the_token_in_its_fragment(server: Server) -> None:
    at = urlsplit(server.url)
    assert (at.scheme, at.hostname, at.path, at.query) == ("http", "127.0.0.1", "/", "")
    assert len(token_of(server.url)) >= 43
    assert token_of(server.url) not in server.address


def test_the_page_is_served_without_the_token(server: Server) -> None:
    status, headers, body = fetch(server.url, "/")
    assert (status, body) == (200, FILES["/"].data)
    assert headers["content-type"] == "text/html; charset=utf-8"
    assert "default-src 'none'" in headers["content-security-policy"]
    assert f"ws://{urlsplit(server.url).netloc}" in headers["content-security-policy"]
    assert headers["cache-control"] == "no-store" and headers["x-content-type-options"] == "nosniff"
    assert "server" not in headers and not any(name.startswith("access-control") for name in headers)
    assert fetch(server.url, "/main.js")[1]["content-type"] == "text/javascript; charset=utf-8"


def test_geometry_is_served_with_the_token(server: Server) -> None:
    assert json.loads(fetch(server.url, "/scene", bearer(server.url))[2])["hash"] == "00ff"
    status, headers, body = fetch(server.url, "/scene/pieces/0", bearer(server.url))
    assert (status, len(body), headers["content-length"]) == (200, 2_000_000, "2000000")
    assert headers["cache-control"] == "no-store"
    assert fetch(server.url, "/held/7", bearer(server.url))[2] == b"\x07"
    status, headers, body = fetch(server.url, "/exports/a.csv", bearer(server.url))
    assert (status, headers["content-type"], body) == (200, "text/csv; charset=utf-8", b"a,b\n")


def test_what_is_not_there(server: Server) -> None:
    status, _, body = fetch(server.url, "/scene/pieces/1", bearer(server.url))
    assert status == 404
    assert json.loads(body) == {"what": "there is no piece 1", "where": "scene", "do": "there is 1"}
    for path in (
        "/scene/pieces/-1",
        "/scene/pieces/1e3",
        "/scene/pieces/",
        "/scene/sent/",
        "/scene/sent/1",
        "/held/x",
        "/held/" + "9" * 50,
        "/exports/",
    ):
        assert fetch(server.url, path, bearer(server.url))[0] == 404


def test_what_goes_wrong_is_told_by_its_type_alone(server: Server, caplog: pytest.LogCaptureFixture) -> None:
    status, _, body = fetch(server.url, "/scene/pieces/500", bearer(server.url))
    assert status == 500 and b"ZeroDivisionError" in body and b"secret" not in body
    assert "a secret" in caplog.text, "whoever runs the server sees it all"
    assert token_of(server.url) not in caplog.text


@pytest.mark.parametrize("path", ["/", "/main.js", *SECRETS, "/nothing"])
def test_foreign_requests_are_refused(server: Server, path: str) -> None:
    netloc = urlsplit(server.url).netloc
    port = netloc.partition(":")[2]
    token = bearer(server.url)
    for host in ("evil.example", f"evil.example:{port}", f"{netloc}.evil.example", f"{netloc}0", "127.0.0.1", None):
        status, _, body = fetch(server.url, path, token, host=host)
        assert status == 421 and netloc.encode() not in body
    for origin in ("http://evil.example", "null", f"http://{netloc}.evil.example", f"https://{netloc}", ""):
        assert fetch(server.url, path, token, ("Origin", origin))[0] == 403
    for site in ("cross-site", "same-site"):
        assert fetch(server.url, path, token, ("Sec-Fetch-Site", site))[0] == 403


def test_own_names_are_answered(server: Server) -> None:
    port = urlsplit(server.url).port
    for host in (f"localhost:{port}", f"127.0.0.1:{port}", f"[::1]:{port}"):
        origin = ("Origin", f"http://{host}")
        assert fetch(server.url, "/scene", bearer(server.url), origin, host=host)[0] == 200
    assert fetch(server.url, "/scene", bearer(server.url), ("Sec-Fetch-Site", "same-origin"))[0] == 200


@pytest.mark.parametrize("path", SECRETS)
def test_geometry_needs_the_token(server: Server, session: FakeSession, path: str) -> None:
    with Server(session, files=FILES) as other:
        old = bearer(other.url)
    for headers in ([], [old], [("Authorization", token_of(server.url))], [("Authorization", f"Bearer {new_token()}")]):
        assert fetch(server.url, path, *headers)[0] == 401
    assert fetch(server.url, f"{path}?t={token_of(server.url)}")[0] in (401, 404), "no token in a query"


@pytest.mark.parametrize(
    "path",
    [
        *("/../main.js", "/..", "/%2e%2e/main.js", "/%2e%2e%2fmain.js", "/./main.js", "//main.js", "/main.js/"),
        *("/main.js?x", "/main.js%00", "/MAIN.JS", "/index.html", "main.js", "*", "/\\main.js"),
        *("/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "/static/../main.js"),
        *("/exports/../a.csv", "/exports/%2e%2e", "/exports/..", "/exports/a.csv/..", "/exports//a.csv"),
        *("http://evil.example/", "/" + "a" * 4000, "/\u00e9".encode().decode("latin-1")),
    ],
)
def test_paths_are_names_of_a_table(server: Server, path: str) -> None:
    at = urlsplit(server.url)
    with socket.create_connection((at.hostname, at.port), timeout=WAIT_S) as plain:
        lines = f"GET {path} HTTP/1.1\r\nHost: {at.netloc}\r\n{': '.join(bearer(server.url))}\r\n\r\n"
        plain.sendall(lines.encode("latin-1"))
        answer = b""
        while chunk := plain.recv(65536):
            answer += chunk
    # What the library refuses to read is closed without an answer.
    assert answer == b"" or answer.split()[1] in (b"400", b"404"), answer[:200]
    still_answers(server)


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE", "NONSENSE"])
@pytest.mark.parametrize("path", ["/", "/scene"])
def test_other_methods_are_refused(server: Server, method: str, path: str) -> None:
    status, headers, _ = fetch(server.url, path, bearer(server.url), method=method)
    # Older versions of the library close the connection.
    assert status in (0, 405) and not any(name.startswith("access-control") for name in headers)
    still_answers(server)


def test_static_files_are_a_table(tmp_path: Path) -> None:
    with pytest.raises(WorkbenchError, match="make build"):
        static_files(tmp_path / "nowhere")
    (tmp_path / "fonts").mkdir()
    for name in ("index.html", "main.js", "style.css", "icon.svg", "fonts/a.woff2"):
        (tmp_path / name).write_text(name)
    files = static_files(tmp_path)
    assert {path: file.type.partition(";")[0] for path, file in files.items()} == {
        "/": "text/html",
        "/index.html": "text/html",
        "/main.js": "text/javascript",
        "/style.css": "text/css",
        "/icon.svg": "image/svg+xml",
        "/fonts/a.woff2": "application/octet-stream",
    }


# ---- whom a socket lets in ----


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1", "https://{}", "http://{}.evil.example"]
)
def test_a_foreign_socket_is_refused(server: Server, origin: str) -> None:
    with pytest.raises(InvalidHandshake, match="403"):
        Page(server.url, origin=origin.format(urlsplit(server.url).netloc))
    still_answers(server)


@pytest.mark.parametrize("host", ["evil.example", "{}.evil.example", "127.0.0.1"])
def test_a_socket_to_another_name_is_refused(server: Server, host: str) -> None:
    at = urlsplit(server.url)
    with socket.create_connection((at.hostname, at.port), timeout=WAIT_S) as plain:
        plain.sendall(
            f"GET / HTTP/1.1\r\nHost: {host.format(at.netloc)}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
        )
        assert plain.recv(100).startswith(b"HTTP/1.1 421")
    still_answers(server)


def test_a_socket_from_another_site_is_refused(server: Server) -> None:
    with pytest.raises(InvalidHandshake, match="403"):
        Page(server.url, **{"Sec-Fetch-Site": "cross-site"})


def test_a_socket_elsewhere_is_none(server: Server) -> None:
    at = urlsplit(server.url)
    for path in ("/main.js", "/scene", "/socket"):
        upgrade = [("Upgrade", "websocket"), ("Connection", "Upgrade"), ("Sec-WebSocket-Version", "13")]
        assert fetch(at.geturl(), path, *upgrade, ("Sec-WebSocket-Key", "A" * 22 + "=="))[0] in (200, 401, 404)


def test_without_origin_and_with_the_token_a_program_may_come(server: Server) -> None:
    with Page(server.url, origin="") as page:
        assert page.next(protocol.Welcome).document["unit"] == "mm"


@pytest.mark.parametrize("token", ["", "wrong", "\u00e9" * 43, "own "])
def test_a_wrong_token_closes_with_1008(server: Server, session: FakeSession, token: str) -> None:
    with Page(server.url, hello=token.replace("own", token_of(server.url)) or " ") as page:
        assert page.code() == protocol.NOT_ALLOWED
    assert session.pages == 0
    still_answers(server)


def test_the_token_of_another_start_is_no_token(server: Server, session: FakeSession) -> None:
    with Server(session, files=FILES) as other:
        old = token_of(other.url)
    with Page(server.url, hello=old) as page:
        assert page.code() == protocol.NOT_ALLOWED


@pytest.mark.parametrize("frame", ["", "{}", b"", b"\x01", '{"kind":"ack","seq":1}', '{"kind":"hello"}', "[" * 5000])
def test_nothing_is_read_before_hello(server: Server, session: FakeSession, frame: str | bytes) -> None:
    with Page(server.url, hello=None) as page:
        page.raw(frame)
        assert page.code() == protocol.NOT_ALLOWED
    assert session.done == []
    still_answers(server)


def test_a_pose_before_hello_moves_nothing(server: Server, session: FakeSession) -> None:
    with Page(server.url, hello=None) as page:
        page.send(protocol.Wish(1, 0.0, "api", np.eye(4)))
        assert page.code() == protocol.NOT_ALLOWED
    assert session.wishes.empty()


def test_no_hello_in_time_closes(session: FakeSession) -> None:
    with Server(session, files=FILES, limits=Limits(hello_s=0.05)) as server, Page(server.url, hello=None) as page:
        assert page.code() == protocol.NOT_ALLOWED


@pytest.mark.parametrize("version", [0, 2, 99])
def test_another_version_is_told_to_reload(server: Server, version: int) -> None:
    with Page(server.url, hello=None) as page:
        page.raw(json.dumps({"kind": "hello", "protocol": version, "and": "fields of its own"}))
        assert page.code() == protocol.RELOAD == 4001


def test_four_pages_and_no_more(server: Server, session: FakeSession) -> None:
    pages = [Page(server.url) for _ in range(4)]
    for page in pages:
        page.next(protocol.Welcome)
    assert session.pages == 4
    with Page(server.url) as fifth:
        assert fifth.code() == protocol.TOO_MANY_PAGES
    pages.pop().close()
    # The server has seen it go once a page comes in again.
    while True:
        with Page(server.url) as another:
            try:
                another.next(protocol.Welcome)
                break
            except Exception:
                assert another.code() == protocol.NOT_ALLOWED
    for page in pages:
        page.close()


def test_sockets_that_say_nothing_are_few(session: FakeSession) -> None:
    limits = Limits(hello_s=WAIT_S, waiting=2)
    with Server(session, files=FILES, limits=limits) as server:
        silent = [Page(server.url, hello=None) for _ in range(2)]
        with Page(server.url, hello=None) as third:
            assert third.code() == protocol.NOT_ALLOWED
        for page in silent:
            page.close()


# ---- what pages say and hear ----


def test_a_welcome_has_everything(server: Server, session: FakeSession) -> None:
    session.notice("before anybody came")
    with Page(server.url) as page:
        welcome = page.receive()
    assert isinstance(welcome, protocol.Welcome)
    assert (welcome.event, welcome.device, welcome.recording) == (1, False, True)
    assert welcome.document["mockup"]["name"] == "engine"
    assert welcome.held is not None and welcome.held["version"] == 1
    assert {"feeler", "python", "numpy"} <= {*welcome.versions}


def test_a_pose_is_a_wish(server: Server, session: FakeSession) -> None:
    pose = np.eye(4)
    pose[:3, 3] = [1, 2, 3]
    with Page(server.url) as page:
        page.send(protocol.Wish(7, 12.5, "gizmo", pose))
        wished, seq, source = session.wishes.get(timeout=WAIT_S)
    np.testing.assert_array_equal(wished, pose)
    assert (seq, source) == (7, "gizmo")


def test_commands_are_answered_in_their_order(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        for i in range(100):
            page.send(protocol.Command(i, "hide", {"parts": [i]}))
        replies = [page.next(protocol.Answer) for _ in range(100)]
    assert [reply.id for reply in replies] == list(range(100))
    assert [args["parts"] for _, args in session.done] == [[i] for i in range(100)]


@pytest.mark.parametrize("kind", [protocol.Command, protocol.Ask, protocol.Job])
def test_what_is_refused_says_what_where_and_what_to_do(server: Server, kind: type) -> None:
    with Page(server.url) as page:
        page.send(kind(3, "wrong", {}))
        refusal = page.next(protocol.Refusal)
    assert refusal.id == 3 and refusal.error["what"].startswith("no such") and refusal.error["where"]


def test_errors_nobody_foresaw_are_replies_too(
    server: Server, session: FakeSession, caplog: pytest.LogCaptureFixture
) -> None:
    with Page(server.url) as page:
        page.send(protocol.Command(3, "broken", {}))
        page.send(protocol.Ask(4, "broken", {}))
        page.send(protocol.Ask(5, "nan", {}))
        page.send(protocol.Wish(666, 0.0, "api", np.eye(4)))
        refusals = {refusal.id: refusal.error for refusal in (page.next(protocol.Refusal) for _ in range(4))}
        page.send(protocol.Ask(6, "ray", {}))
        assert page.next(protocol.Answer).id == 6
    assert {*refusals} == {3, 4, 5, None}
    for number in (3, 4, None):
        assert "ZeroDivisionError" in refusals[number]["what"] and "secret" not in str(refusals[number])
    assert "JSON" in refusals[5]["what"]
    assert "a secret" in caplog.text and token_of(server.url) not in caplog.text


def test_a_long_question_holds_up_nobody(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page, Page(server.url) as other:
        page.send(protocol.Ask(1, "slow", {}))
        assert session.began.wait(WAIT_S)
        page.send(protocol.Command(2, "hide", {}))
        assert page.next(protocol.Answer).id == 2
        page.send(protocol.Wish(1, 0.0, "api", np.eye(4)))
        assert session.wishes.get(timeout=WAIT_S)[1] == 1
        other.send(protocol.Ask(3, "ray", {}))
        assert other.next(protocol.Answer).id == 3
        assert fetch(server.url, "/scene", bearer(server.url))[0] == 200
        session.go_on.set()
        assert page.next(protocol.Answer).id == 1


def test_too_many_requests_are_refused_one_by_one(session: FakeSession) -> None:
    with Server(session, files=FILES, limits=Limits(requests=2)) as server, Page(server.url) as page:
        page.send(protocol.Ask(1, "slow", {}))
        page.send(protocol.Ask(2, "ray", {}))
        page.send(protocol.Ask(3, "ray", {}))
        assert page.next(protocol.Refusal).id == 3
        session.go_on.set()
        assert [page.next(protocol.Answer).id for _ in range(2)] == [1, 2]
        page.send(protocol.Ask(4, "ray", {}))
        assert page.next(protocol.Answer).id == 4


def test_a_job_reports_and_is_answered(server: Server) -> None:
    with Page(server.url) as page:
        page.send(protocol.Job(5, "quick", {}))
        answer = page.next(protocol.Answer)
    assert (answer.id, answer.result) == (5, {"name": "a.csv"})


def test_progress_goes_to_whoever_asked(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page, Page(server.url) as other:
        other.next(protocol.Welcome)
        page.send(protocol.Job(5, "long", {}))
        assert session.began.wait(WAIT_S)
        session.notice("to all")
        assert page.next(protocol.Notice).text == "to all"
        assert isinstance(other.receive(), protocol.Notice)
        session.jobs[0].set_result(None)
        assert page.next(protocol.Answer).id == 5


def test_a_job_is_cancelled_and_says_so(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        page.send(protocol.Job(5, "long", {}))
        assert session.began.wait(WAIT_S)
        page.send(protocol.Job(5, "long", {}))
        assert "runs already" in page.next(protocol.Refusal).error["what"]
        page.send(protocol.Cancel(4))  # nobody's
        page.send(protocol.Cancel(5))
        refusal = page.next(protocol.Refusal)
        assert (refusal.id, refusal.error["what"]) == (5, "was cancelled")


def test_jobs_end_with_their_page(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        page.send(protocol.Job(5, "long", {}))
        assert session.began.wait(WAIT_S)
        page.send(protocol.Ask(6, "ray", {}))
        page.next(protocol.Answer)
    assert session.gone.wait(WAIT_S)
    assert session.jobs[0].cancelled()


def test_a_picture_comes_as_png_in_any_number_of_pieces(session: FakeSession) -> None:
    png = b"\x89PNG\r\n\x1a\n" + bytes(100)
    text = base64.b64encode(png).decode()
    with Server(session, files=FILES, limits=Limits(shot_bytes=200)) as server, Page(server.url) as page:
        for wrong in ("", "nonsense!", base64.b64encode(b"GIF89a").decode(), "\u00e9"):
            page.send(protocol.Shot(1, "a", wrong, False))
            assert "not a PNG" in page.next(protocol.Refusal).error["what"]
        page.send(protocol.Shot(2, "a", text, False))
        assert session.shots.get(timeout=WAIT_S) == (2, png)
        for at in range(0, len(text), 8):
            page.send(protocol.Shot(3, "a", text[at : at + 8], at + 8 < len(text)))
        assert session.shots.get(timeout=WAIT_S) == (3, png)
        page.send(protocol.Shot(4, "a", text, True))  # given up for another
        page.send(protocol.Shot(5, "a", text, False))
        assert session.shots.get(timeout=WAIT_S) == (5, png)
        for _ in range(2):
            page.send(protocol.Shot(6, "a", text, True))
        assert "more than 200 bytes" in page.next(protocol.Refusal).error["what"]


def test_a_piece_is_no_larger_than_the_protocol_says(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        page.next(protocol.Welcome)
        header = json.dumps(
            {"kind": "file_piece", "id": 1, "files": 1, "file": 0, "arrays": {"data": ["u1", [524_289], 0]}}
        ).encode()
        header += b" " * (-len(header) % 8)
        page.raw(struct.pack("<II", 1, len(header)) + header + bytes(524_296))
        assert "524288" in page.next(protocol.Refusal).error["what"].replace(",", "")
    assert session.openings.came == []


def test_events_go_to_all_pages_in_order(server: Server, session: FakeSession) -> None:
    with Page(server.url) as one, Page(server.url) as other:
        one.next(protocol.Welcome)
        other.next(protocol.Welcome)
        threads = [threading.Thread(target=lambda: [session.notice("a") for _ in range(50)]) for _ in range(4)]
        for thread in threads:
            thread.start()
        for page in (one, other):
            assert [page.next(protocol.Notice).n for _ in range(200)] == list(range(1, 201))
        for thread in threads:
            thread.join()


def test_nothing_is_lost_while_pages_come(server: Server, session: FakeSession) -> None:
    ends = threading.Event()

    def talk() -> None:
        while not ends.wait(0.0005):
            session.notice("a")

    talker = threading.Thread(target=talk)
    talker.start()
    try:
        for _ in range(5):
            with Page(server.url) as page:
                number = page.next(protocol.Welcome).event
                assert [page.next(protocol.Notice).n for _ in range(20)] == list(range(number + 1, number + 21))
    finally:
        ends.set()
        talker.join()


def test_what_the_welcome_has_is_not_told_again(server: Server, session: FakeSession) -> None:
    session.while_welcoming = lambda: session.notice("in the document")
    with Page(server.url) as page:
        assert page.receive().event == 1
        session.notice("new")
        assert page.receive().n == 2


def test_a_page_that_comes_back_hears_what_it_missed(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        first = page.next(protocol.Welcome)
    session.notice("one")
    session.notice("two")

    def back(after: int, of: str = first.session) -> list[Any]:
        with Page(server.url, hello=None) as page:
            page.hello(token_of(server.url), of, after)
            heard = [page.receive()]
            while not isinstance(heard[-1], protocol.Welcome):
                heard.append(page.receive())
            return [each.text if isinstance(each, protocol.Notice) else each.event for each in heard]

    assert back(0) == ["one", "two", 2]
    assert back(1) == ["two", 2]
    assert back(2) == [2]
    assert back(99) == [2], "of another session, or of none"
    assert back(0, "another start") == [2]
    session.kept_from = 1
    assert back(0) == [2], "what is not kept is in the welcome"


def test_the_hand_is_let_go_when_the_last_page_is_gone(server: Server, session: FakeSession) -> None:
    with Page(server.url) as one:
        one.next(protocol.Welcome)
        with Page(server.url) as other:
            other.next(protocol.Welcome)
        one.send(protocol.Ask(1, "ray", {}))
        one.next(protocol.Answer)
        assert not session.gone.is_set()
    assert session.gone.wait(WAIT_S)


# ---- back pressure ----


def test_states_wait_for_acknowledgements(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page:
        page.next(protocol.Welcome)
        for number in (1, 2):
            session.show(FakeSnapshot(number))
            assert page.next(protocol.State).seq == number
        held_back = FakeSnapshot(3)
        session.show(held_back)
        for number in range(4, 50):
            session.show(FakeSnapshot(number))
        session.notice("events are not held back")
        assert isinstance(page.receive(), protocol.Notice)
        page.send(protocol.Ack(2))
        assert page.next(protocol.State).seq == 49, "the newest, and none between"
        assert held_back.made == 0, "what is not sent is not made"


def test_a_state_is_packed_once_for_all_pages(server: Server, session: FakeSession) -> None:
    snapshot = FakeSnapshot(1)
    with Page(server.url) as one, Page(server.url) as other:
        one.next(protocol.Welcome)
        other.next(protocol.Welcome)
        session.show(snapshot)
        assert one.next(protocol.State).seq == other.next(protocol.State).seq == 1
    assert snapshot.made == 1


def test_a_page_gets_the_state_at_once(server: Server, session: FakeSession) -> None:
    session.show(FakeSnapshot(5))
    with Page(server.url) as page:
        assert isinstance(page.receive(), protocol.Welcome)
        assert page.next(protocol.State).seq == 5


def test_a_state_that_cannot_be_told_is_left_out(
    server: Server, session: FakeSession, caplog: pytest.LogCaptureFixture
) -> None:
    with Page(server.url) as page:
        page.next(protocol.Welcome)
        bad = FakeSnapshot(1, depth=float("nan"))
        session.show(bad)
        # A newer state would replace one that the net thread has not asked for yet.
        assert bad.was_asked.wait(WAIT_S)
        session.notice("still here")
        page.next(protocol.Notice)
        session.show(FakeSnapshot(2))
        assert page.next(protocol.State).seq == 2
    assert "a state could not be sent" in caplog.text


def test_an_event_that_cannot_be_told_is_left_out(
    server: Server, session: FakeSession, caplog: pytest.LogCaptureFixture
) -> None:
    with Page(server.url) as page:
        page.next(protocol.Welcome)
        session.tell(type="notice", level="info", text=object())
        session.notice("still here")
        assert page.next(protocol.Notice).n == 2
    assert "an event could not be sent" in caplog.text


def test_a_page_that_takes_nothing_is_closed_and_disturbs_nobody(server: Server, session: FakeSession) -> None:
    with Page(server.url) as page, raw_page(server.url):
        page.next(protocol.Welcome)
        while session.pages < 2:
            pass
        # More than the buffers of the system and the outbox hold together.
        for number in range(1, 1000):
            session.notice("x" * 100_000)
            assert page.next(protocol.Notice).n == number
            page.send(protocol.Command(number, "hide", {}))
            assert page.next(protocol.Answer).id == number
            if session.pages == 1:
                break
        assert session.pages == 1


# ---- malformed, huge, many ----


@pytest.mark.parametrize(
    "frame",
    [
        *("", "nonsense", "[]", "{}", '{"kind":"welcome"}', '{"kind":"command","id":1}', "[" * 100_000, "\x00"),
        *(b"", b"\x01\x00\x00\x00", struct.pack("<II", 1, 2**32 - 1), bytes(1000), b"\xff" * 1000),
        '{"kind":"command","id":5,"name":"hide","args":' + "[" * 200 + "]" * 200 + "}",
        '{"kind":"ack","seq":' + "9" * 100_000 + "}",
        json.dumps({"kind": "command", "id": 1, "name": "a" * 500_000, "args": []}),
    ],
)
def test_malformed_messages_are_refused_and_the_page_goes_on(server: Server, frame: str | bytes) -> None:
    with Page(server.url) as page:
        page.raw(frame)
        refusal = page.next(protocol.Refusal)
        assert refusal.error["what"] and len(json.dumps(refusal.error)) < 1000
        page.send(protocol.Ask(9, "ray", {}))
        assert page.next(protocol.Answer).id == 9


def test_a_message_that_is_too_long_closes_its_page_alone(server: Server) -> None:
    with Page(server.url) as other:
        other.next(protocol.Welcome)
        with Page(server.url) as page:
            page.next(protocol.Welcome)
            page.raw("x" * ((1 << 20) + 1))
            assert page.code() == 1009
        other.send(protocol.Ask(1, "ray", {}))
        assert other.next(protocol.Answer).id == 1


def test_text_that_is_no_utf_8_closes_its_page_alone(server: Server) -> None:
    with raw_page(server.url) as plain:
        plain.sendall(b"\x81\x82" + bytes(4) + b"\xff\xff")
        while plain.recv(65536):
            pass
    still_answers(server)


def test_too_many_messages_close_with_1008(session: FakeSession) -> None:
    now = [0.0]
    with Server(session, files=FILES, limits=Limits(messages_per_s=10), clock=lambda: now[0]) as server:
        with Page(server.url) as page:
            for second in range(3):
                now[0] = float(second)
                for i in range(9):
                    page.send(protocol.Ack(i))
                page.send(protocol.Ask(second, "ray", {}))
                assert page.next(protocol.Answer).id == second
            page.send(protocol.Ack(0))
            assert page.code() == protocol.NOT_ALLOWED
        now[0] = 10.0
        still_answers(server)


def test_bytes_that_are_no_http(server: Server) -> None:
    at = urlsplit(server.url)
    many = b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 500
    for junk in (b"\x00" * 100, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"A" * 20_000, many):
        with socket.create_connection((at.hostname, at.port), timeout=WAIT_S) as plain:
            plain.sendall(junk)
            plain.shutdown(socket.SHUT_WR)
            try:
                while plain.recv(65536):
                    pass
            except ConnectionResetError:
                pass
    still_answers(server)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inside: st.lists(inside, max_size=4) | st.dictionaries(st.text(max_size=10), inside, max_size=4),
    max_leaves=10,
)
kinds = st.sampled_from([*(each.__dict__["KIND"] for each in protocol.FROM_PAGE), "state", "", None])
fields = st.sampled_from(
    [
        *("seq", "id", "name", "args", "token", "protocol", "arrays", "source", "png_base64"),
        *("point", "selection", "camera", "is_moving", "wish", "to"),
    ]
)
messages = st.builds(lambda kind, rest: json.dumps({**rest, "kind": kind}), kinds, st.dictionaries(fields, json_values))
headed = st.builds(lambda text, body: struct.pack("<II", 1, len(text)) + text.encode() + body, messages, st.binary())


@given(st.lists(st.binary(max_size=300) | st.text(max_size=300) | messages | headed, max_size=20))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_messages_never_end_the_server(server: Server, frames: list[str | bytes]) -> None:
    with Page(server.url) as page:
        for frame in frames:
            page.raw(frame.encode("utf-8", "replace").decode() if isinstance(frame, str) else frame)
        page.send(protocol.Ask(2**40, "ray", {}))
        while page.next(protocol.Answer).id != 2**40:
            pass


# ---- start and end ----


def test_the_end_closes_all_pages(session: FakeSession) -> None:
    server = Server(session, files=FILES)
    server.start()
    with Page(server.url) as page, Page(server.url, hello=None) as silent:
        page.next(protocol.Welcome)
        server.close()
        assert page.code() == silent.code() == 1001
    server.close()
    session.notice("nobody hears this")
    session.show(FakeSnapshot(1))
    with pytest.raises(OSError):
        fetch(server.url, "/")
    with pytest.raises(WorkbenchError, match="started before"):
        server.start()


def test_the_end_does_not_wait_for_a_stalled_page_or_a_long_question(session: FakeSession) -> None:
    server = Server(session, files=FILES)
    server.start()
    with raw_page(server.url), Page(server.url) as page:
        page.send(protocol.Ask(1, "slow", {}))
        assert session.began.wait(WAIT_S)
        server.close()
        assert page.code() == 1001
    session.go_on.set()


def test_no_address_before_the_start(session: FakeSession) -> None:
    with pytest.raises(WorkbenchError, match="not started"):
        _ = Server(session, files=FILES).url


def test_the_page_has_to_be_built(session: FakeSession, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(static_files, "__defaults__", (tmp_path,))
    with pytest.raises(WorkbenchError, match="make build"):
        Server(session)


def test_the_log_is_quiet_about_clients(server: Server, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, "feeler"):
        test_bytes_that_are_no_http(server)
    assert token_of(server.url) not in caplog.text
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]
