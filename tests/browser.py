"""A real Chromium, and `feeler view` as people start it."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
PROGRAM = [sys.executable, "-c", "from feeler.cli import main; main()"]


def chromium() -> str:
    """The path of a Chromium: $FEELER_CHROMIUM, or one on the PATH. Skips the test where there is none, but in CI."""
    named = os.environ.get("FEELER_CHROMIUM")
    found = named or next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium, and CI may not leave these tests out (Debian: chromium)")
        pytest.skip("NO BROWSER: the workbench was not tried in one. Install Chromium, or name one by FEELER_CHROMIUM")
    return found


@dataclass
class Program:
    """`feeler view` while it runs."""

    process: subprocess.Popen[str]
    url: str
    said: list[str] = field(default_factory=list)

    def interrupt(self) -> int:
        """Ctrl-C; the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


@contextmanager
def program(*words: str | Path, timeout_s: float = 60.0) -> Iterator[Program]:
    """`feeler view WORDS --no-browser`, with the address that it prints."""
    command = [*PROGRAM, "view", *map(str, words), "--no-browser"]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    said: list[str] = []
    address = threading.Event()

    def listen() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            said.append(line.rstrip("\n"))
            if "http://" in line:
                address.set()
        address.set()

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    try:
        address.wait(timeout_s)
        found = re.search(r"http://\S+", "\n".join(said))
        if found is None:
            raise AssertionError(f"no address within {timeout_s} s; it said: {said}")
        yield Program(process, found.group(), said)
    finally:
        if process.poll() is None:
            process.kill()
        process.wait(30)
        listener.join(30)
        assert process.stdout is not None
        process.stdout.close()


def keep(picture: bytes, name: str, folders: Sequence[str] = ("target", "screenshots")) -> Path:
    """A screenshot, kept as an artefact of the build."""
    folder = Path(__file__).resolve().parent.parent.joinpath(*folders)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_bytes(picture)
    return path
