"""Starts `feeler` again and again as forks of one process that has imported it: half the time of a start is imports.

Linux alone; elsewhere, tests start whole processes.
"""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from typing import NoReturn

IS_THERE = hasattr(os, "pidfd_open") and hasattr(socket, "send_fds")
MOST_BYTES = 1 << 18
"""Of the words and the environment of a program."""


class Forked:
    """A program that was forked, as `subprocess.Popen` has it."""

    def __init__(self, pid: int, status: int) -> None:
        """status: a descriptor on which its exit status comes."""
        self.pid, self._status = pid, status
        self._handle = os.pidfd_open(pid)
        self.returncode: int | None = None

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            signal.pidfd_send_signal(self._handle, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def poll(self) -> int | None:
        return self._ended(0.0)

    def wait(self, timeout: float) -> int:
        if self._ended(timeout) is None:
            raise subprocess.TimeoutExpired("feeler", timeout)
        assert self.returncode is not None
        return self.returncode

    def _ended(self, timeout: float) -> int | None:
        if self.returncode is None and select.select([self._handle], [], [], timeout)[0]:
            told = os.read(self._status, 8)
            self.returncode = int(told) if told else -int(signal.SIGKILL)
            os.close(self._status)
            os.close(self._handle)
        return self.returncode


_parents: list[tuple[subprocess.Popen[bytes], socket.socket]] = []


def started(words: Sequence[str], output: int, environment: dict[str, str]) -> Forked:
    """`feeler WORDS`; output: a descriptor for what it prints, and for its errors."""
    if not _parents:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, __file__, str(theirs.fileno())]
        _parents.append((subprocess.Popen(command, pass_fds=[theirs.fileno()]), ours))
        theirs.close()
        atexit.register(_end)
    reading, writing = os.pipe()
    request = json.dumps({"words": [*words], "environment": environment, "folder": os.getcwd()}).encode()
    assert len(request) < MOST_BYTES
    _, line = _parents[0]
    line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_BYTES)
    socket.send_fds(line, [request], [output, writing])
    os.close(writing)
    told = line.recv(64)
    if not told:
        raise AssertionError("the process that starts programs has ended: see its errors above")
    return Forked(int(told), reading)


def _end() -> None:
    for process, line in _parents:
        line.close()
        process.wait(30)


def _serve(line: socket.socket) -> None:
    """Forks for each request, until nobody can send one."""
    import feeler.cli.view
    import feeler.workbench.net.server
    import feeler.workbench.session.session  # noqa: F401

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C in the terminal is for the tests
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the children
    while True:
        data, descriptors, _, _ = socket.recv_fds(line, MOST_BYTES, 2)
        if not data:
            return
        pid = os.fork()
        if pid == 0:
            line.close()
            _run(json.loads(data), *descriptors)
        for each in descriptors:
            os.close(each)
        line.send(str(pid).encode())


def _run(request: dict[str, object], output: int, status: int) -> None:
    """The program itself, which ends here."""
    from feeler.cli import main

    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    nothing = os.open(os.devnull, os.O_RDONLY)
    for one, other in ((nothing, 0), (output, 1), (output, 2)):
        os.dup2(one, other)
    os.environ.clear()
    os.environ.update(request["environment"])  # type: ignore[call-overload]
    os.chdir(str(request["folder"]))
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    sys.argv = ["feeler", *request["words"]]  # type: ignore[misc]
    leave = os._exit

    def told(number: int) -> NoReturn:
        os.write(status, str(number).encode())
        leave(number)

    os._exit = told  # the program may end so itself, above threads that nobody waits for
    code: object = 1
    try:
        main()
        code = 0
    except SystemExit as end:
        code = end.code
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        told(code if isinstance(code, int) else 0 if code is None else 1)


if __name__ == "__main__":
    _serve(socket.socket(fileno=int(sys.argv[1])))
