"""The test stand: `feeler view` as a program, and a headless Chromium with SwiftShader, all on one core."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import chromium
import host

PROGRAM = (sys.executable, "-c", "from feeler.cli import main; main()")
READY_MS = 600_000  # ten million triangles on a core that others use as well
START_S = 60.0


class StandError(RuntimeError):
    """There is nothing to measure with."""


class Viewing:
    """`feeler view` while it runs."""

    def __init__(self, words: Sequence[str], folder: Path) -> None:
        self._said: list[str] = []
        self._address = threading.Event()
        self.process = subprocess.Popen(
            [*PROGRAM, "view", *words, "--no-browser"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        self._address.wait(START_S)
        found = re.search(r"http://\S+", "\n".join(self._said))
        if found is None:
            raise StandError(f"feeler view gave no address; it said: {self._said}")
        self.url = found.group()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._said.append(line.rstrip("\n"))
            if "http://" in line:
                self._address.set()
        self._address.set()

    def wait(self) -> None:
        """Until it ends by itself. Raises `StandError` where that is with an error."""
        status = self.process.wait(READY_MS / 1000)
        if status:
            raise StandError(f"feeler view ended with status {status}; it said: {self._said[-5:]}")

    def memory(self) -> int:
        """Resident bytes of the server."""
        pages = int(Path(f"/proc/{self.process.pid}/statm").read_text(encoding="ascii").split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    def close(self) -> None:
        """Ends it."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(10)
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(30)
        self._listener.join(30)
        assert self.process.stdout is not None
        self.process.stdout.close()


@contextlib.contextmanager
def viewing(*words: str, folder: Path | None = None) -> Iterator[Viewing]:
    """`feeler view WORDS`, which runs in a folder of its own unless told."""
    with tempfile.TemporaryDirectory() as own:
        program = Viewing(words, folder or Path(own))
        try:
            yield program
        finally:
            program.close()


@contextlib.contextmanager
def browser(core: int | None) -> Iterator[Any]:
    """A headless Chromium with a software renderer, all its processes on one core; None: on any."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise StandError("playwright is missing: pip install playwright") from None
    path = chromium.found()
    if path is None:
        raise StandError("no Chromium: install it, or name one by FEELER_CHROMIUM")
    with host.on_core(core):
        playwright = sync_playwright().start()
        started = playwright.chromium.launch(executable_path=path, args=list(chromium.FLAGS))
    try:
        yield started
    finally:
        started.close()
        playwright.stop()


@contextlib.contextmanager
def opened(started: Any, url: str, width: int, height: int, script: str | None = None) -> Iterator[Any]:
    """A page whose picture has the given number of pixels. `script` runs before the page's own."""
    context = started.new_context(viewport={"width": width + 600, "height": height + 80}, reduced_motion="reduce")
    try:
        context.set_default_timeout(READY_MS)
        if script is not None:
            context.add_init_script(script)
        page = context.new_page()
        page.goto(url)
        page.wait_for_selector("#picture")
        for _ in range(3):
            seen = page.evaluate(_SIZE)
            if seen["picture"] == [width, height]:
                break
            around = [outer - inner for outer, inner in zip(seen["window"], seen["picture"], strict=True)]
            page.set_viewport_size({"width": width + around[0], "height": height + around[1]})
        yield page
    finally:
        context.close()


_SIZE = """() => {
  const picture = document.querySelector("#picture");
  return { window: [innerWidth, innerHeight], picture: [picture.clientWidth, picture.clientHeight] };
}"""


def ready(page: Any) -> None:
    """Until the whole mock-up is drawn."""
    page.wait_for_function("() => window.feeler && window.feeler.ready")


def heap_bytes(page: Any) -> int:
    """Memory held by the page's script and its buffers after garbage collection."""
    session = page.context.new_cdp_session(page)
    try:
        session.send("HeapProfiler.collectGarbage")
        usage = session.send("Runtime.getHeapUsage")
    finally:
        session.detach()
    return int(usage["usedSize"]) + int(usage.get("backingStorageSize", 0))


def cpu_s(program: Viewing) -> float:
    """Processor time of the browser so far, all its processes: on one core of its own it would take as long."""
    found: dict[int, tuple[int, float]] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended
            fields = (folder / "stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
            ticks = int(fields[11]) + int(fields[12])
            found[int(folder.name)] = (int(fields[1]), ticks / os.sysconf("SC_CLK_TCK"))
    mine = {os.getpid()}
    while grown := {pid for pid, (parent, _) in found.items() if parent in mine} - mine:
        mine |= grown
    return sum(found[pid][1] for pid in mine - {os.getpid(), program.process.pid} if pid in found)


def manifest(url: str) -> tuple[dict[str, Any], int]:
    """The mock-up's manifest, and how many bytes it has on the wire."""
    address, _, token = url.partition("#t=")
    request = urllib.request.Request(address + "scene", headers={"Authorization": f"Bearer {token}"})
    with urllib.request.urlopen(request) as response:
        data = response.read()
    return json.loads(data), len(data)
