"""The net thread: serves the page's files, the geometry, and the sockets. It makes no engine calls.

    server = Server(session)
    server.start()
    print(server.url)      # with the token in its fragment, which browsers send nowhere
    server.close()

`guard.py` decides about access. A slow page delays no other: each has its own outbox, only the newest state counts, and
a page that does not read its messages is closed.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import platform
import secrets
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from websockets.asyncio.server import Server as SocketServer
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from feeler.errors import FeelerError, WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.document.frames import dumps
from feeler.workbench.document.protocol_people import LEAST_HERE_MS
from feeler.workbench.files import ANY, File, static_files, type_of
from feeler.workbench.net.client import Client, event_frame, trouble
from feeler.workbench.net.guard import Refused, check_bearer, check_request, is_token, new_token, security_headers
from feeler.workbench.net.listening import Listening, Place, listen
from feeler.workbench.net.serving import Limits, SessionLike

log = logging.getLogger("feeler.workbench")

# Messages of websockets about failed handshakes concern clients, not us.
_quiet = logging.getLogger("feeler.workbench.sockets")
_quiet.setLevel(logging.CRITICAL)

_CLOSE_S = 0.4
_PING_S = 20.0
_POOL = 12  # two threads for each page, and some that fetch geometry
_JSON = "application/json"
_PLAIN = "text/plain; charset=utf-8"
_UPGRADE = ("upgrade", "websocket")


class Server:
    """Serves a session to pages, in a thread of its own."""

    def __init__(
        self,
        session: SessionLike,
        *,
        port: int = 0,
        place: Place | None = None,
        files: Mapping[str, File] | None = None,
        limits: Limits | None = None,
        has_device: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """place: where to listen; default loopback at `port`. files: the page's, default the built ones.

        has_device: whether a haptic device moves the hand. clock: seconds, for the rate limit. Raises `OptionError`,
        and `WorkbenchError` if the page is not built.
        """
        self._session = session
        self._files = static_files() if files is None else dict(files)
        self._place = place or Place(port=port)
        self._place.check()
        self._limits = limits or Limits()
        self._has_device = has_device
        self._clock = clock
        self._token = new_token()
        self._id = secrets.token_hex(8)
        self._clients: set[Client] = set()
        self._greeting = 0
        self._listening: Listening | None = None
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop: asyncio.Event | None = None
        self._pool: ThreadPoolExecutor | None = None
        self._trouble: Exception | None = None
        self._has_news = threading.Event()
        self._has_people_news = threading.Event()
        self._people_news: asyncio.Event | None = None
        self._state: tuple[int, bytes | None] = (0, None)

    @property
    def url(self) -> str:
        """The page's address, with the token in its fragment. Raises `WorkbenchError` before `start`."""
        return f"{self.address}#t={self._token}"

    @property
    def address(self) -> str:
        """The server's address, without the token: safe for a log."""
        if self._listening is None:
            raise WorkbenchError("the server is not started", "server", "call start() first")
        return self._listening.address

    def start(self) -> None:
        """Starts listening. Raises `OptionError` for a port in use."""
        if self._thread is not None:
            raise WorkbenchError("the server was started before", "server", "make another one")
        self._listening = listen(self._place)
        is_up = threading.Event()
        self._thread = threading.Thread(target=self._live, args=(is_up,), name="feeler net", daemon=True)
        self._thread.start()
        is_up.wait()
        if self._trouble is not None:
            raise WorkbenchError(f"cannot serve: {self._trouble}", "server", "see the error above this one") from (
                self._trouble
            )

    def close(self) -> None:
        """Closes all sockets and ends the thread; a second call does nothing."""
        if self._loop is not None and self._stop is not None:
            with contextlib.suppress(RuntimeError):  # it has already ended
                self._loop.call_soon_threadsafe(self._stop.set)
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def __enter__(self) -> Server:
        self.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    # ---- the thread ----

    def _live(self, is_up: threading.Event) -> None:
        try:
            asyncio.run(self._main(is_up))
        except Exception as error:
            # `start` reports errors of the start; after that nobody else would report them.
            self._trouble = error
            if is_up.is_set():
                log.error("the server ended", exc_info=error)
        finally:
            is_up.set()

    async def _main(self, is_up: threading.Event) -> None:
        assert self._listening is not None
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        self._pool = ThreadPoolExecutor(_POOL, "feeler request")
        self._people_news = asyncio.Event()
        ends = [self._session.subscribe(self._on_event), self._session.on_snapshot(self._on_snapshot)]
        ends.append(self._session.people.on_news(self._on_people))
        minding = asyncio.create_task(self._mind_people(self._people_news))
        servers: list[SocketServer] = []
        try:
            for each in self._listening.sockets:
                servers.append(await self._serve(each))
            is_up.set()
            await self._stop.wait()
        finally:
            minding.cancel()
            for end in ends:
                end()
            for server in servers:
                server.close()
            with contextlib.suppress(asyncio.TimeoutError):  # hanging tasks are cancelled with the loop
                await asyncio.wait_for(asyncio.gather(*(each.wait_closed() for each in servers)), 2 * _CLOSE_S)
            self._pool.shutdown(wait=False, cancel_futures=True)

    async def _serve(self, listener: Any) -> SocketServer:
        assert self._listening is not None
        server: SocketServer = await serve(
            self._converse,
            sock=listener,
            ssl=self._listening.tls,
            process_request=self._answer,
            compression=None,
            max_size=self._limits.message_bytes,
            ping_interval=_PING_S,
            ping_timeout=_PING_S,
            close_timeout=_CLOSE_S,
            server_header=None,
            logger=_quiet,
        )
        return server

    # ---- HTTP ----

    async def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The response to a request; None lets a socket open."""
        assert self._listening is not None
        headers = list(request.headers.raw_items())
        # Older versions of the library accept only GET, and report no method.
        refused = check_request(self._listening.door, str(getattr(request, "method", "GET")), headers)
        if refused is not None:
            return self._refusal(refused)
        host = request.headers["Host"]
        if request.path == "/" and any((name.lower(), value.lower()) == _UPGRADE for name, value in headers):
            return None
        static = self._files.get(request.path)
        if static is not None:
            return self._response(200, static.type, static.data, host)
        found = self._secret(request.path)
        if found is None:
            return self._refusal(Refused(404, "there is no such file"))
        refused = check_bearer(headers, self._token)
        if refused is not None:
            return self._refusal(refused)
        kind, work = found
        try:
            assert self._pool is not None
            data = await asyncio.get_running_loop().run_in_executor(self._pool, work)
        except Exception as error:
            if not isinstance(error, FeelerError):
                log.error("%s failed", request.path, exc_info=error)
            status = 404 if isinstance(error, FeelerError) else 500
            return self._response(status, _JSON, dumps(trouble(error, request.path)).encode(), host)
        return self._response(200, kind, data, host)

    def _secret(self, path: str) -> tuple[str, Callable[[], bytes]] | None:
        """The resource at a path with the token: its type, and its maker."""
        session = self._session
        match path.split("/")[1:]:
            case ["scene"]:
                return _JSON, lambda: dumps(session.manifest()).encode()
            case ["scene", "pieces", number] if _is_number(number):
                return ANY, lambda: session.piece(int(number))
            case ["scene", "sent", number] if _is_number(number):
                return ANY, lambda: session.sent_piece(int(number))
            case ["held", version] if _is_number(version):
                return ANY, lambda: session.held(int(version))
            case ["cards", number] if _is_number(number):
                return ANY, lambda: session.card_room(int(number))
            case ["findings", version] if version:
                return ANY, lambda: session.finding_rows(version)
            case ["exports", name] if name:
                return type_of(name), lambda: session.export(name)
        return None

    def _refusal(self, refused: Refused) -> Response:
        assert self._listening is not None
        # A request by another name gets no address.
        host = next(iter(sorted(self._listening.door.hosts)))
        return self._response(refused.status, _PLAIN, f"{refused.reason}\n".encode(), host)

    def _response(self, status: int, kind: str, data: bytes, host: str) -> Response:
        assert self._listening is not None
        fields = {
            "Content-Type": kind,
            "Content-Length": str(len(data)),
            "Connection": "close",
            **security_headers(self._listening.door, host),
        }
        return Response(status, _REASONS[status], Headers(fields), data)

    # ---- sockets ----

    async def _converse(self, socket: ServerConnection) -> None:
        if self._greeting >= self._limits.waiting:
            await socket.close(protocol.NOT_ALLOWED, "too many connections")
            return
        self._greeting += 1
        try:
            hello = await self._greet(socket)
        except ConnectionClosed:
            return
        finally:
            self._greeting -= 1
        if hello is not None:
            await self._attend(socket, hello)

    async def _greet(self, socket: ServerConnection) -> protocol.Hello | None:
        """Reads the hello that admits a page; None if the socket was closed instead."""
        refused = "the first message is hello, with the token"
        try:
            frame = await asyncio.wait_for(socket.recv(), self._limits.hello_s)
        except asyncio.TimeoutError:
            await socket.close(protocol.NOT_ALLOWED, refused)
            return None
        version = protocol.version_of(frame)
        if version is not None and version != protocol.VERSION:
            await socket.close(protocol.RELOAD, "reload the page: it is of another version than the server")
            return None
        try:
            message = protocol.decode_from_page(frame)
        except protocol.ProtocolError:
            message = None
        if not isinstance(message, protocol.Hello) or not is_token(message.token, self._token):
            await socket.close(protocol.NOT_ALLOWED, refused)
            return None
        if len(self._clients) >= self._limits.pages:
            await socket.close(protocol.TOO_MANY_PAGES, f"{len(self._clients)} pages are open: close one")
            return None
        return message

    async def _attend(self, socket: ServerConnection, hello: protocol.Hello) -> None:
        assert self._pool is not None
        people = self._session.people
        person = people.join()
        client = Client(socket, self._session, self._pool, self._state_frame, self._limits, self._clock, person)
        self._clients.add(client)
        self._session.pages = len(self._clients)
        missed_after = hello.last_event if hello.session == self._id else None
        try:
            await client.serve(missed_after, self._welcome, lambda: self._introduce(client))
        except Exception as error:
            log.error("a page's connection failed", exc_info=error)
        finally:
            self._clients.discard(client)
            self._session.pages = len(self._clients)
            had_tool = people.leave(person)
            for other in self._clients:
                other.tell_newest(("seen", person), None)
            # While the server ends there is no hand: a thread that waits for the engine would delay it.
            if (had_tool or not self._clients) and self._stop is not None and not self._stop.is_set():
                self._pool.submit(self._session.hand_gone)

    def _welcome(self) -> protocol.Welcome:
        """In a thread of the pool."""
        document, event = self._session.document_and_event()
        return protocol.Welcome(
            protocol=protocol.VERSION,
            session=self._id,
            document=document,
            event=event,
            device=self._has_device,
            recording=self._session.is_recording,
            held=self._session.held_manifest(document["held_version"]),
            versions=_versions(),
            opens=self._session.openings.facts(),
        )

    # ---- messages of the session, in any thread ----

    def _on_event(self, event: dict[str, Any]) -> None:
        self._soon(self._spread, event)

    def _on_snapshot(self) -> None:
        # The engine may be faster than the net: one pending call is enough.
        if not self._has_news.is_set():
            self._has_news.set()
            self._soon(self._spread_news)

    def _on_people(self) -> None:
        # A page may say where it is as often as it likes: one pending call is enough.
        if not self._has_people_news.is_set():
            assert self._people_news is not None
            self._has_people_news.set()
            self._soon(self._people_news.set)

    async def _mind_people(self, told: asyncio.Event) -> None:
        """Passes on what pages show of their people, at most once in `LEAST_HERE_MS`."""
        people = self._session.people
        while True:
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(told.wait(), people.look_s)
            told.clear()
            self._has_people_news.clear()
            news = people.news()
            for client in self._clients if news.is_about_people else ():
                client.tell_newest("people", _text(people.people(client.person)))
            for person in news.seen:
                self._show(person, self._clients)
            await asyncio.sleep(LEAST_HERE_MS / 1000)

    def _introduce(self, client: Client) -> None:
        """Tells a page that was welcomed who is there."""
        people = self._session.people
        client.tell_newest("people", _text(people.people(client.person)))
        for other in self._clients:
            self._show(other.person, [client])

    def _show(self, person: int, clients: Iterable[Client]) -> None:
        seen = self._session.people.seen(person)
        if seen is None:
            return
        text = _text(seen)
        for client in clients:
            if client.person != person:
                client.tell_newest(("seen", person), text)

    def _soon(self, work: Callable[..., object], *args: Any) -> None:
        assert self._loop is not None
        with contextlib.suppress(RuntimeError):  # the server is ending, and its pages with it
            self._loop.call_soon_threadsafe(work, *args)

    def _spread(self, event: dict[str, Any]) -> None:
        if event["type"] == protocol.Joints.KIND:  # only the newest counts
            shown = _text(protocol.Joints(event["poses"], event["values"]))
            for client in self._clients:
                client.tell_newest(protocol.Joints.KIND, shown)
            return
        try:
            text = event_frame(event)
        except protocol.ProtocolError as error:
            log.error("an event could not be sent: %s", error)
            return
        is_placed = event["type"] == "patch" and "mechanism" in event["fields"]
        for client in self._clients:
            if is_placed:  # what was shown before is over
                client.tell_newest(protocol.Joints.KIND, None)
            client.tell(event["n"], text)

    def _spread_news(self) -> None:
        self._has_news.clear()
        for client in self._clients:
            client.news()

    def _state_frame(self, is_wanted: Callable[[int], bool]) -> tuple[int, bytes] | None:
        """The newest state, if its number is wanted; encoded once for all pages."""
        snapshot = self._session.snapshot()
        if snapshot is None or not is_wanted(snapshot.number):
            return None
        number, frame = self._state
        if number != snapshot.number:
            number, frame = snapshot.number, None
            try:
                packed = protocol.encode(snapshot.message())
                assert isinstance(packed, bytes), "a state has arrays"
                frame = packed
            except Exception as error:
                # The next state may be valid again: the pages keep the last one.
                log.error("a state could not be sent", exc_info=error)
            self._state = (number, frame)
        return None if frame is None else (number, frame)


def _text(message: protocol.People | protocol.Seen | protocol.Joints) -> str:
    frame = protocol.encode(message)
    assert isinstance(frame, str), "it has no arrays"
    return frame


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= 10


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    return {"feeler": version("feeler"), "python": platform.python_version(), "numpy": np.__version__}


_REASONS = {
    200: "OK",
    401: "Unauthorized",
    403: "Forbidden",
    404: "Not Found",
    405: "Method Not Allowed",
    421: "Misdirected Request",
    500: "Internal Server Error",
}
