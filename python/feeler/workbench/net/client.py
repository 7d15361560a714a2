"""One page's connection: hello, its messages, and the replies. Lives in the net thread.

Commands run one after the other, and so do questions and the pieces of files, each in a thread of a pool. The net
thread never waits for them, and a long question delays neither the page's commands nor other pages.
"""

from __future__ import annotations

import asyncio
import base64
import binascii
import logging
from collections.abc import Callable, Hashable
from concurrent.futures import CancelledError, Executor
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from feeler.errors import FeelerError, WorkbenchError
from feeler.workbench.document import protocol
from feeler.workbench.document.frames import dumps
from feeler.workbench.document.openings import FilePiece, OpeningRequest, OpenMockup, SendFiles
from feeler.workbench.net.guard import RateLimit
from feeler.workbench.net.outbox import Outbox
from feeler.workbench.net.serving import JobLike, Limits, SessionLike

log = logging.getLogger("feeler.workbench")

_NO_SHOT: tuple[None, list[str]] = (None, [])
_REFUSAL_S = 1.0  # a page that moves a tool that it does not have hears of it no more often

Request = protocol.Command | protocol.Turning | protocol.Ask | protocol.Job | OpeningRequest


class Client:
    """A page after its hello."""

    def __init__(
        self,
        socket: ServerConnection,
        session: SessionLike,
        pool: Executor,
        state_frame: Callable[[Callable[[int], bool]], tuple[int, bytes] | None],
        limits: Limits,
        clock: Callable[[], float],
        person: int,
    ) -> None:
        """state_frame: the newest state's number and frame, if the number is wanted. clock: seconds, for the limit.

        person: the number of the page's person.
        """
        self.person = person
        self._socket = socket
        self._session = session
        self._pool = pool
        self._state_frame = state_frame
        self._limits = limits
        self._clock = clock
        self._rate = RateLimit(limits.messages_per_s)
        self._outbox = Outbox()
        self._wake = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._commands: asyncio.Queue[Request] = asyncio.Queue()
        self._asks: asyncio.Queue[Request] = asyncio.Queue()
        self._openings: asyncio.Queue[Request] = asyncio.Queue()
        self._requests = 0
        self._pieces = 0
        self._jobs: dict[int, JobLike] = {}
        self._shot: tuple[int | None, list[str]] = _NO_SHOT
        self._early: list[tuple[int, str]] | None = []  # events from before the welcome was ready
        self._refused_at = -_REFUSAL_S

    # ---- called by the server ----

    async def serve(
        self, missed_after: int | None, welcome: Callable[[], protocol.Welcome], welcomed: Callable[[], None]
    ) -> None:
        """Runs until the page is gone. missed_after: its newest event, if it returns to the same session.

        welcomed: called after the welcome.
        """
        tasks = [asyncio.create_task(self._send())]
        try:
            missed, greeting = await self._run(self._prepare, missed_after, welcome)
            for text in missed:
                self._put(text)
            self._put(protocol.encode(greeting))
            early, self._early = self._early or [], None
            for number, text in early:
                if number > greeting.event:
                    self._put(text)
            welcomed()
            tasks += [asyncio.create_task(self._do(queue)) for queue in (self._commands, self._asks, self._openings)]
            await self._receive()
        except ConnectionClosed:
            pass  # the usual end
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            for job in [*self._jobs.values()]:
                job.cancel()  # nobody is left to receive the result

    def tell(self, number: int, text: str) -> None:
        """Queues an event, by its number and encoded."""
        if self._early is not None:
            self._early.append((number, text))
        else:
            self._put(text)

    def news(self) -> None:
        """Signals a newer state."""
        self._wake.set()

    def tell_newest(self, about: Hashable, text: str | None) -> None:
        """Sets the message about something; only the newest counts. None: drops it. Nothing before the welcome."""
        if text is None:
            self._outbox.drop_newest(about)
        elif self._early is None:
            self._outbox.put_newest(about, text)
            self._wake.set()

    # ---- sending ----

    def _prepare(
        self, missed_after: int | None, welcome: Callable[[], protocol.Welcome]
    ) -> tuple[list[str], protocol.Welcome]:
        """Missed events come before the welcome: the page recognises them by their numbers, notices included."""
        missed = None if missed_after is None else self._session.events_since(missed_after)
        greeting = welcome()
        return [event_frame(event) for event in missed or [] if event["n"] <= greeting.event], greeting

    def _put(self, frame: str | bytes) -> None:
        if self._outbox.put(frame):
            self._wake.set()
        else:
            # A closing handshake would wait for all that the page does not read.
            self._socket.transport.abort()

    async def _send(self) -> None:
        """Sends queued messages. Only this waits for a slow page."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            try:
                while (frame := self._next()) is not None:
                    await self._socket.send(frame)
            except ConnectionClosed:
                return

    def _next(self) -> str | bytes | None:
        frame = self._outbox.take()
        if frame is not None or self._early is not None:
            return frame
        state = self._state_frame(self._outbox.wants_state)
        if state is None:
            return None
        self._outbox.sent_state(state[0])
        return state[1]

    # ---- receiving ----

    async def _receive(self) -> None:
        async for frame in self._socket:
            if not self._rate.allows(self._clock()):
                await self._socket.close(protocol.NOT_ALLOWED, "too many messages")
                return
            try:
                self._take(protocol.decode_from_page(frame))
            except Exception as error:
                # No error in one message may end the connection.
                self._refuse(protocol.id_of(frame), error, "message")

    def _take(self, message: protocol.FromPage) -> None:
        match message:
            case protocol.Wish():
                if not self._session.wish(message.pose, message.seq, message.source, self.person):
                    self._refuse_move()
            case protocol.Ack():
                self._outbox.acknowledged(message.seq)
                self._wake.set()
            case protocol.Cancel():
                if (job := self._jobs.get(message.id)) is not None:
                    job.cancel()
            case protocol.Ping():
                self._put(_text(protocol.Answer(message.id, {})))
            case protocol.Shot():
                self._take_shot(message)
            case protocol.Benchmarked():
                self._session.benchmarked(message.id, message.figures)
            case protocol.Here():
                self._session.people.here(self.person, message)
            case protocol.Named():
                self._session.people.name(self.person, message.name)
            case protocol.Hello():
                raise WorkbenchError("hello was said already", "hello", "say it once")
            case _:
                self._queue(message)

    def _refuse_move(self) -> None:
        now = self._clock()
        if now - self._refused_at >= _REFUSAL_S:
            self._refused_at = now
            self._refuse(None, self._session.people.refusal(), "tool")

    def _take_shot(self, shot: protocol.Shot) -> None:
        """A piece of a picture; the last one completes it."""
        pieces = [] if self._shot[0] != shot.id else self._shot[1]
        pieces.append(shot.png_base64)
        if sum(map(len, pieces)) > self._limits.shot_bytes:
            self._shot = _NO_SHOT
            raise WorkbenchError(f"the picture has more than {self._limits.shot_bytes} bytes", "shot", "send less")
        self._shot = (shot.id, pieces) if shot.more else _NO_SHOT
        if not shot.more:
            self._session.shot_taken(shot.id, _png("".join(pieces)))

    def _queue(self, request: Request) -> None:
        if self._requests >= self._limits.requests:
            raise WorkbenchError(
                f"{self._requests} requests wait already", _name(request), "wait for their answers before the next"
            )
        if isinstance(request, FilePiece):
            if self._pieces >= self._limits.pieces:
                raise WorkbenchError(f"{self._pieces} pieces wait already", "open", "wait for their answers")
            self._pieces += 1
        if isinstance(request, protocol.Job) and request.id in self._jobs:
            raise WorkbenchError(f"job {request.id} runs already", request.name, "give every request another id")
        self._requests += 1
        self._queue_of(request).put_nowait(request)

    def _queue_of(self, request: Request) -> asyncio.Queue[Request]:
        match request:
            case protocol.Command() | protocol.Turning():
                return self._commands
            case protocol.Ask() | protocol.Job():
                return self._asks
        return self._openings

    async def _do(self, queue: asyncio.Queue[Request]) -> None:
        """Answers one request after the other."""
        while True:
            request = await queue.get()
            if isinstance(request, protocol.Job):
                await self._start(request)
                continue
            try:
                answer = await self._run(_answer, self._session, request, self.person)
            except Exception as error:
                self._refuse(request.id, error, _name(request))
            else:
                self._put(answer)
            self._requests -= 1
            self._pieces -= isinstance(request, FilePiece)

    async def _start(self, request: protocol.Job) -> None:
        def progressed(share: float, stage: str) -> None:
            frame = dumps({"kind": "progress", "id": request.id, "share": share, "stage": stage})
            self._call(self._progressed, request.id, frame)

        try:
            job = await self._run(self._session.job, request.name, request.args, progressed)
        except Exception as error:
            self._requests -= 1
            self._refuse(request.id, error, request.name)
            return
        self._jobs[request.id] = job
        job.add_done_callback(lambda done: self._call(self._finish, request, done))

    def _progressed(self, job: int, frame: str) -> None:
        if job in self._jobs:
            self._outbox.put_newest(job, frame)
            self._wake.set()

    def _finish(self, request: protocol.Job, done: JobLike) -> None:
        self._jobs.pop(request.id, None)
        self._outbox.drop_newest(request.id)
        self._requests -= 1
        try:
            self._put(_text(protocol.Answer(request.id, done.result())))
        except CancelledError:
            self._refuse(request.id, WorkbenchError("was cancelled", request.name, "start it again"), request.name)
        except Exception as error:
            self._refuse(request.id, error, request.name)

    def _refuse(self, request: int | None, error: Exception, where: str) -> None:
        if not isinstance(error, FeelerError):
            log.error("%s failed", where, exc_info=error)
        self._put(_text(protocol.Refusal(request, trouble(error, where))))

    async def _run(self, work: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._pool, work, *args)

    def _call(self, work: Callable[..., object], *args: Any) -> None:
        """From any thread, calls into the net thread while there is one."""
        try:
            self._loop.call_soon_threadsafe(work, *args)
        except RuntimeError:
            log.debug("a job ended after the server")


def event_frame(event: dict[str, Any]) -> str:
    """The frame of a session's event."""
    return dumps({"kind": "event", **event}, f"event {event.get('type')}")


def trouble(error: Exception, where: str) -> protocol.Trouble:
    """An error for a page. An unexpected one is sent by its type only: its text may contain anything."""
    if isinstance(error, WorkbenchError):
        return {"what": error.what, "where": error.where or where, "do": error.do}
    if isinstance(error, FeelerError):
        return {"what": str(error), "where": where, "do": ""}
    what = f"something went wrong in the server ({type(error).__name__})"
    return {"what": what, "where": where, "do": "see the terminal, and report the error"}


def _answer(session: SessionLike, request: Request, person: int) -> str:
    """Runs in a thread of the pool, encoding included: an answer may be long."""
    match request:
        case protocol.Command():
            answer = session.command(request.name, request.args, person)
        case protocol.Turning():
            answer = session.turn(person, request)
        case protocol.Ask():
            answer = session.ask(request.name, request.args)
        case FilePiece() | OpenMockup() | SendFiles():
            people = session.people
            answer = session.openings.request(request, people.name_of(person) if people.count > 1 else None)
        case protocol.Job():
            raise AssertionError("these are answered elsewhere")
    return _text(protocol.Answer(request.id, answer))


def _name(request: Request) -> str:
    if isinstance(request, protocol.Turning):
        return "tool"
    return request.name if isinstance(request, (protocol.Command, protocol.Ask, protocol.Job)) else "open"


def _text(message: protocol.Answer | protocol.Refusal) -> str:
    frame = protocol.encode(message)
    assert isinstance(frame, str), "a reply has no arrays"
    return frame


def _png(text: str) -> bytes:
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        data = b""
    if not data.startswith(b"\x89PNG\r\n\x1a\n"):
        raise WorkbenchError("png_base64 is not a PNG file in base64", "shot", "send the result of canvas.toBlob")
    return data
