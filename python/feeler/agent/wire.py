"""The standard streams as the wire of the protocol: a message a line, bounded in length and in number.

The wire is a private copy of the descriptors. Descriptor 0 then reads as empty, and whatever else the process prints to
descriptor 1, also in a library of C, goes to stderr.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import threading
from collections.abc import AsyncIterator, Coroutine, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import anyio
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream
from mcp.shared.message import ServerMessageMetadata, SessionMessage
from mcp_types import (
    INVALID_REQUEST,
    PARSE_ERROR,
    ErrorData,
    JSONRPCError,
    JSONRPCNotification,
    JSONRPCRequest,
    JSONRPCResponse,
    jsonrpc_message_adapter,
)

from feeler.agent.lanes import Lane

MOST_LINE_BYTES = 1 << 20
"""The longest message that is read; of longer ones, nothing is kept."""
MOST_REQUESTS = 128
"""Requests without an answer; no more are read until one is answered, so a client that only writes fills no memory."""
_CHUNK = 1 << 16
_LONGEST_ID = 1 << 10

Read = MemoryObjectReceiveStream[SessionMessage | Exception]
Write = MemoryObjectSendStream[SessionMessage]


class Wire:
    """Takes the standard streams of the process."""

    def __init__(self) -> None:
        for descriptor, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY), (2, os.O_WRONLY)):
            _fill(descriptor, flags)
        self._in, self._out = os.dup(0), os.dup(1)
        empty = os.open(os.devnull, os.O_RDONLY)
        os.dup2(empty, 0)
        os.close(empty)
        os.dup2(2, 1)

    def close(self) -> None:
        """Gives the streams back. The copies stay open, since a thread may still read from one."""
        os.dup2(self._in, 0)
        os.dup2(self._out, 1)

    def lines(self) -> Iterator[bytes | None]:
        """Each line that comes; None for one that is too long. Blocks."""
        rest = b""
        is_skipping = False
        while chunk := os.read(self._in, _CHUNK):
            *whole, last = (rest + chunk).split(b"\n")
            for line in whole:
                if is_skipping or len(line) > MOST_LINE_BYTES:
                    is_skipping = False
                    yield None
                elif line.strip():
                    yield line
            rest = last
            if len(rest) > MOST_LINE_BYTES:
                rest, is_skipping = b"", True
            elif is_skipping:
                rest = b""
        if rest.strip() and not is_skipping:
            yield rest

    def write(self, line: bytes) -> None:
        """Writes a line. Blocks."""
        left = memoryview(line)
        while left:
            left = left[os.write(self._out, left) :]


def _fill(descriptor: int, flags: int) -> None:
    """Opens the empty file in place of a standard stream that was closed before the program began."""
    try:
        os.fstat(descriptor)
    except OSError:
        empty = os.open(os.devnull, flags)
        if empty != descriptor:
            os.dup2(empty, descriptor)
            os.close(empty)


@asynccontextmanager
async def streams(wire: Wire) -> AsyncIterator[tuple[Read, Write]]:
    """The messages that come, and those to send, as the server of `mcp` takes them.

    Reading and writing have threads of their own, daemons: either may wait for a client that does nothing.
    """
    send_in, read = anyio.create_memory_object_stream[SessionMessage | Exception](0)
    write, take_out = anyio.create_memory_object_stream[SessionMessage](0)
    room = asyncio.Semaphore(MOST_REQUESTS)
    loop = asyncio.get_running_loop()
    writer = Lane("stdout", 1)

    async def answered() -> None:
        room.release()

    async def take(line: bytes | None) -> None:
        message = _message(line)
        if isinstance(message, _Refusal):
            if message.answer.id is not None:
                await room.acquire()  # as for each answer
            await write.send(SessionMessage(message.answer))
        elif isinstance(message, JSONRPCRequest):
            await room.acquire()
            await send_in.send(SessionMessage(message, ServerMessageMetadata(on_request_unanswered=answered)))
        else:
            await send_in.send(SessionMessage(message))

    def read_lines() -> None:
        # One line at a time: those that wait stay with the client. The loop may end meanwhile.
        with contextlib.suppress(Exception):
            for line in wire.lines():
                _in_loop(loop, take(line))
        with contextlib.suppress(Exception):
            _in_loop(loop, send_in.aclose())

    async def send_all() -> None:
        async with take_out:
            async for sent in take_out:
                message = sent.message
                text = message.model_dump_json(by_alias=True, exclude_unset=True)
                if isinstance(message, JSONRPCResponse | JSONRPCError) and message.id is not None:
                    room.release()
                if not await _written(writer, wire, text.encode() + b"\n"):
                    tasks.cancel_scope.cancel()  # the client is gone

    threading.Thread(target=read_lines, name="feeler-stdin", daemon=True).start()
    with send_in, read, write, take_out:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(send_all)
            yield read, write


def _in_loop(loop: asyncio.AbstractEventLoop, work: Coroutine[Any, Any, None]) -> None:
    """Runs it in the loop, and waits for it."""
    try:
        asyncio.run_coroutine_threadsafe(work, loop).result()
    finally:
        work.close()  # where the loop is over


async def _written(writer: Lane, wire: Wire, line: bytes) -> bool:
    """Writes a line in a thread; whether it could be written."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[bool] = loop.create_future()

    def work() -> None:
        try:
            wire.write(line)
            is_written = True
        except OSError:
            is_written = False
        with contextlib.suppress(RuntimeError):
            loop.call_soon_threadsafe(lambda: None if done.done() else done.set_result(is_written))

    writer.submit(work)
    return await done


@dataclass(frozen=True)
class _Refusal:
    """The error that answers a line without a message for the server."""

    answer: JSONRPCError


def _message(line: bytes | None) -> Any:
    """The message of a line, or a refusal."""
    if line is None:
        return _refusal(INVALID_REQUEST, f"the message is longer than {MOST_LINE_BYTES:,} bytes: send less at once")
    try:
        message = jsonrpc_message_adapter.validate_json(line, by_name=False)
    except ValueError:
        known = _id_of(line)
        if known is None:
            return _refusal(PARSE_ERROR, "the line is not a JSON-RPC 2.0 message")
        said = 'not a request of JSON-RPC 2.0 in UTF-8: "jsonrpc" is "2.0", "method" a text, "params" an object'
        return _refusal(INVALID_REQUEST, said, known)
    # With an id that is none, such as 1.5, a request passes for a notification, and its sender would wait.
    if isinstance(message, JSONRPCNotification) and "id" in json.loads(line):
        return _refusal(INVALID_REQUEST, "the id of a request is a whole number or a text")
    return message


def _refusal(code: int, said: str, known: int | str | None = None) -> _Refusal:
    return _Refusal(JSONRPCError(jsonrpc="2.0", id=known, error=ErrorData(code=code, message=said)))


def _id_of(line: bytes) -> int | str | None:
    """The id of a request that is none otherwise, so that its sender does not wait for an answer."""
    try:
        given = json.loads(line)
    except (ValueError, RecursionError):
        return None
    known = given.get("id") if isinstance(given, dict) and "method" in given else None
    if isinstance(known, str):
        return known if known.isprintable() and len(known) <= _LONGEST_ID else None
    return known if isinstance(known, int) and not isinstance(known, bool) and abs(known) < 1 << 63 else None
