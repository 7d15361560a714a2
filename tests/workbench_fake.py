"""A session without an engine, and clients that say exactly what they are told, for the tests of the server."""

from __future__ import annotations

import contextlib
import http.client
import json
import queue
import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from test_workbench_protocol import DOCUMENT, state
from websockets.sync.client import ClientConnection, connect

from feeler.errors import WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.document.openings import Opens
from feeler.workbench.document.protocol import decode_from_server, encode
from feeler.workbench.files import File
from feeler.workbench.session.people import PeopleOf

FILES = {
    "/": File("text/html; charset=utf-8", b"<!doctype html><title>page</title>"),
    "/main.js": File("text/javascript; charset=utf-8", b"export {};"),
}
WAIT_S = 60.0  # a test that waits so long has failed


class FakeSnapshot:
    def __init__(self, number: int, **changes: Any) -> None:
        self.number = number
        self.made = 0
        self.was_asked = threading.Event()
        self._changes = changes

    def message(self) -> protocol.State:
        self.made += 1
        self.was_asked.set()
        return state(seq=self.number, **self._changes)


class FakeOpenings:
    """Keeps the messages; while `go_on` is not set, an answer waits."""

    def __init__(self) -> None:
        self.came: list[Any] = []
        self.by: list[str | None] = []
        self.go_on = threading.Event()
        self.go_on.set()

    def facts(self) -> Opens | None:
        return None

    def request(self, message: Any, by: str | None = None) -> dict[str, Any]:
        assert self.go_on.wait(WAIT_S)
        self.came.append(message)
        self.by.append(by)
        return {}


class FakeSession:
    """Keeps what it is told, and answers as a session would."""

    def __init__(self) -> None:
        self.pages = 0
        self.is_recording = True
        self.openings = FakeOpenings()
        self.people = PeopleOf(time.monotonic, parts=lambda: 5)
        self.events: list[dict[str, Any]] = []
        self.wishes: queue.Queue[tuple[np.ndarray, int, str]] = queue.Queue()
        self.done: list[tuple[str, dict[str, Any]]] = []
        self.shots: queue.Queue[tuple[int, bytes]] = queue.Queue()
        self.figures: queue.Queue[tuple[int, dict[str, Any]]] = queue.Queue()
        self.gone = threading.Event()
        self.go_on = threading.Event()
        self.began = threading.Event()
        self.jobs: list[Future[Any]] = []
        self.kept_from = 0
        self.while_welcoming: Callable[[], None] = lambda: None
        self._lock = threading.Lock()
        self._listeners: list[Callable[[dict[str, Any]], None]] = []
        self._watchers: list[Callable[[], None]] = []
        self._snapshot: FakeSnapshot | None = None

    def document_and_event(self) -> tuple[dict[str, Any], int]:
        self.while_welcoming()
        with self._lock:
            return {**DOCUMENT}, len(self.events)

    def subscribe(self, listener: Callable[[dict[str, Any]], None]) -> Callable[[], None]:
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def events_since(self, number: int) -> list[dict[str, Any]] | None:
        return self.events[number:] if self.kept_from <= number <= len(self.events) else None

    def tell(self, **event: Any) -> None:
        with self._lock:
            self.events.append({"n": len(self.events) + 1, **event})
            for listener in self._listeners:
                listener(self.events[-1])

    def notice(self, text: str) -> None:
        self.tell(type="notice", level="info", text=text)

    def snapshot(self) -> FakeSnapshot | None:
        return self._snapshot

    def show(self, snapshot: FakeSnapshot) -> None:
        self._snapshot = snapshot
        for watcher in self._watchers:
            watcher()

    def on_snapshot(self, listener: Callable[[], None]) -> Callable[[], None]:
        self._watchers.append(listener)
        return lambda: self._watchers.remove(listener)

    def wish(self, pose: np.ndarray, seq: int, source: str, by: int) -> bool:
        if seq == 666:
            raise ZeroDivisionError("a secret")
        if not self.people.may_move(by):
            return False
        self.wishes.put((pose, seq, source))
        return True

    def turn(self, person: int, turning: protocol.Turning) -> dict[str, Any]:
        self.people.turn(person, turning)
        return {}

    def hand_gone(self) -> None:
        self.gone.set()

    def command(self, name: str, args: dict[str, Any], by: int = 0) -> Any:
        if name == "wrong":
            raise WorkbenchError("no such part", "wrong.parts", "look at the tree")
        if name == "broken":
            raise ZeroDivisionError("a secret")
        if name == "slow":
            self.began.set()
            assert self.go_on.wait(WAIT_S)
        self.done.append((name, args))
        return {"undo_depth": len(self.done)}

    def ask(self, name: str, args: dict[str, Any]) -> Any:
        return {"nan": float("nan")} if name == "nan" else self.command(name, args)

    def job(self, name: str, args: dict[str, Any], on_progress: Callable[[float, str], None]) -> Future[Any]:
        if name == "wrong":
            raise WorkbenchError("no such job", name)
        job: Future[Any] = Future()
        self.jobs.append(job)
        on_progress(0.5, "half way")
        if name == "quick":
            job.set_result({"name": "a.csv"})
        self.began.set()
        return job

    def shot_taken(self, number: int, png: bytes) -> None:
        self.shots.put((number, png))

    def benchmarked(self, number: int, figures: dict[str, Any]) -> None:
        self.figures.put((number, figures))

    def manifest(self) -> dict[str, Any]:
        return {"hash": "00ff", "pieces": []}

    def sent_piece(self, number: int) -> bytes:
        return self.piece(number)

    def piece(self, number: int) -> bytes:
        if number == 500:
            raise ZeroDivisionError("a secret")
        if number:
            raise WorkbenchError(f"there is no piece {number}", "scene", "there is 1")
        return b"\x01" * 2_000_000

    def held_manifest(self, version: int) -> dict[str, Any] | None:
        triple = (0.0, 0.0, 0.0)
        return {
            **{"version": version, "middle": triple, "lower": triple, "upper": triple},
            **{"triangles": 0, "vertices": 0, "part_bytes": 2, "parts": [], "pieces": []},
        }

    def held(self, version: int) -> bytes:
        return bytes([version])

    def card_room(self, number: int) -> bytes:
        if number != 7:
            raise WorkbenchError(f"card {number} has no answer", "cards")
        return b"\x07\x08"

    def finding_rows(self, version: str) -> bytes:
        if version != "00ff":
            raise WorkbenchError("the findings are others now", "findings")
        return b"rows"

    def export(self, name: str) -> bytes:
        if name != "a.csv":
            raise WorkbenchError(f"there is no {name!r}", "exports")
        return b"a,b\n"


def token_of(url: str) -> str:
    return urlsplit(url).fragment.removeprefix("t=")


def fetch(url: str, path: str, *headers: tuple[str, str], host: str | None = "own", method: str = "GET") -> Any:
    """(status, headers, body) of a request that is sent exactly so; status 0: closed without an answer."""
    at = urlsplit(url)
    connection = http.client.HTTPConnection(at.hostname or "", at.port, timeout=WAIT_S)
    try:
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        if host is not None:
            connection.putheader("Host", at.netloc if host == "own" else host)
        for name, value in headers:
            connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        body = response.read()
        return response.status, {name.lower(): value for name, value in response.getheaders()}, body
    except (http.client.BadStatusLine, ConnectionResetError):
        return 0, {}, b""
    finally:
        connection.close()


def bearer(url: str) -> tuple[str, str]:
    return "Authorization", f"Bearer {token_of(url)}"


class Page:
    """A page's end of the socket."""

    def __init__(self, url: str, *, hello: str | None = "own", origin: str | None = None, **headers: str) -> None:
        at = urlsplit(url)
        self._end = contextlib.ExitStack()
        self.socket: ClientConnection = self._end.enter_context(
            connect(
                f"ws://{at.netloc}/",
                origin=f"http://{at.netloc}" if origin is None else origin or None,  # type: ignore[arg-type]
                additional_headers=headers or None,
                compression=None,
                proxy=None,
                max_size=None,
                open_timeout=WAIT_S,
                close_timeout=WAIT_S,
            )
        )
        self._url = url
        if hello is not None:
            self.hello(hello if hello != "own" else token_of(url))

    def hello(self, token: str, session: str | None = None, last_event: int = 0, protocol_version: int = 1) -> None:
        self.send(protocol.Hello(protocol_version, token, session, last_event))

    def send(self, message: Any) -> None:
        self.raw(encode(message))

    def raw(self, frame: str | bytes) -> None:
        self.socket.send(frame)

    def receive(self) -> Any:
        """The next message that is not about people."""
        while isinstance(message := self.any(), protocol.People | protocol.Seen):
            pass
        return message

    def any(self) -> Any:
        return decode_from_server(self.socket.recv(WAIT_S))

    def next(self, kind: type, where: Callable[[Any], bool] = lambda message: True) -> Any:
        """The next message of a kind; others are left out."""
        while not (isinstance(message := self.any(), kind) and where(message)):
            pass
        return message

    def code(self) -> int | None:
        """With which it is closed, whatever comes before that."""
        with contextlib.suppress(Exception):
            while True:
                self.socket.recv(WAIT_S)
        return self.socket.close_code

    def close(self) -> None:
        self._end.close()

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


def raw_page(url: str) -> socket.socket:
    """A page that has said hello and never reads again."""
    at = urlsplit(url)
    plain = socket.create_connection((at.hostname, at.port), timeout=WAIT_S)
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    plain.sendall(
        f"GET / HTTP/1.1\r\nHost: {at.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
    )
    head = b""
    while not head.endswith(b"\r\n\r\n"):
        head += plain.recv(1)
    assert head.startswith(b"HTTP/1.1 101")
    text = json.dumps({"kind": "hello", "protocol": 1, "token": token_of(url), "session": None, "last_event": 0})
    payload = text.ljust(200).encode()  # long enough for a length of two bytes
    # A masked text frame; the mask is zero, so that the payload is as it is.
    plain.sendall(b"\x81" + bytes([0xFE]) + len(payload).to_bytes(2, "big") + bytes(4) + payload)
    return plain
