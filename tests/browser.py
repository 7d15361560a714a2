"""A real Chromium, `feeler view` as people start it, and a small stand to try both on."""

from __future__ import annotations

import base64
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import forking
import numpy as np
import pytest
from chromium import FLAGS
from chromium import found as find_chromium
from shapes import Mesh, box

import feeler
from feeler.io import write_glb, write_stl

SLOW_MS = 60_000  # a software renderer on a loaded machine
HALF_TOOL_M, CAST_M = 0.02, 1e-5  # of the cube; how near a stop comes
PROGRAM = [sys.executable, "-c", "from feeler.cli import main; main()"]


def chromium() -> str:
    """The path of a Chromium: $FEELER_CHROMIUM, or one on the PATH. Skips the test where there is none, but in CI."""
    found = find_chromium()
    if found is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium, and CI may not leave these tests out (Debian: chromium)")
        pytest.skip("NO BROWSER: the workbench was not tried in one. Install Chromium, or name one by FEELER_CHROMIUM")
    return found


@dataclass
class Program:
    """`feeler view` or `feeler replay --page` while it runs."""

    process: subprocess.Popen[str] | forking.Forked
    url: str
    said: list[str] = field(default_factory=list)

    def interrupt(self) -> int:
        """Ctrl-C; the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


def program(*words: str | Path) -> AbstractContextManager[Program]:
    """`feeler view WORDS --no-browser`, with the address that it prints."""
    return _started("view", *words)


def replayed_program(*words: str | Path) -> AbstractContextManager[Program]:
    """`feeler replay WORDS --page --no-browser`, likewise."""
    return _started("replay", *words, "--page")


@contextmanager
def _started(*words: str | Path, timeout_s: float = 60.0) -> Iterator[Program]:
    reading, writing = os.pipe()
    process = _process([*map(str, words), "--no-browser"], writing)
    os.close(writing)
    output = open(reading, encoding="utf-8")  # noqa: SIM115
    said: list[str] = []
    address = threading.Event()

    def listen() -> None:
        for line in output:
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
        output.close()


def _process(words: list[str], output: int) -> subprocess.Popen[str] | forking.Forked:
    """`feeler WORDS`, which prints to a descriptor."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    if forking.IS_THERE:
        return forking.started(words, output, environment)
    return subprocess.Popen(
        [*PROGRAM, *words],
        stdout=output,
        stderr=output,
        text=True,
        env=environment,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def keep(picture: bytes, name: str, folders: Sequence[str] = ("target", "screenshots")) -> Path:
    """A screenshot, kept as an artefact of the build."""
    folder = Path(__file__).resolve().parent.parent.joinpath(*folders)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_bytes(picture)
    return path


def sized(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Mesh:
    half = 0.5 * np.array(size)
    return box(middle - half, middle + half)


def stand() -> feeler.Mockup:
    """A plate, two posts on it, and a pump between them with a millimetre around."""
    shapes = {
        "plate": sized((0.4, 0.2, 0.02), (0.0, 0.0, 0.01)),
        "posts/left": sized((0.04, 0.1, 0.2), (-0.1, 0.0, 0.121)),
        "posts/right": sized((0.04, 0.1, 0.2), (0.1, 0.0, 0.121)),
        "pump": sized((0.158, 0.08, 0.06), (0.0, 0.0, 0.051)),
    }
    return feeler.Mockup(
        np.concatenate([points for points, _ in shapes.values()]),
        np.concatenate([faces + 8 * i for i, (_, faces) in enumerate(shapes.values())]),
        np.repeat(np.arange(len(shapes)), 12),
        [path.split("/")[-1] for path in shapes],
        part_paths=list(shapes),
    )


@pytest.fixture(scope="module", name="stand")
def stand_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stand") / "stand.glb"
    write_glb(path, stand())
    return path


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cube") / "cube.stl"
    write_stl(path, feeler.Tool(*sized((2 * HALF_TOOL_M,) * 3, (0.0, 0.0, 0.0)), name="cube"))
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    path = chromium()
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield started
        started.close()


@pytest.fixture
def context(browser: Any) -> Iterator[Any]:
    made = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="dark", reduced_motion="reduce")
    made.set_default_timeout(SLOW_MS)
    yield made
    made.close()


def opened(context: Any, started: Program) -> Any:
    """A page of the workbench, with its whole first picture. What it writes on the console is in `page.said`."""
    page = context.new_page()
    page.said = []
    page.on("console", lambda message: page.said.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: page.said.append(f"error: {error}"))
    page.goto(started.url)
    ready(page)
    return page


def ready(page: Any) -> None:
    page.wait_for_function("() => window.feeler && window.feeler.ready")


def troubles(page: Any) -> list[str]:
    """What the page's console was told; not that a software renderer waits where pixels are read."""
    said = [line for line in page.said if line.startswith(("error", "warning"))]
    return [line for line in said if "GL Driver Message (OpenGL, Performance" not in line]


AXE = Path(__file__).resolve().parent.parent / "viewer" / "node_modules" / "axe-core" / "axe.min.js"
SCHEMES = ("dark", "light")
needs_axe = pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed: make build")


def access_troubles(page: Any, schemes: Sequence[str] = ("dark",)) -> list[tuple[str, str, Any]]:
    """What axe finds that is serious, in the page as it is: scheme, rule, and where it is broken; nothing without axe.

    schemes: of colours. In all but the first only the contrast is looked at, since nothing else depends on them.
    """
    if not AXE.is_file():
        return []
    if not page.evaluate("() => 'axe' in window"):
        page.evaluate(f"{AXE.read_text(encoding='utf-8')};0")
    troubles = []
    for scheme in schemes:
        if len(schemes) > 1:
            page.emulate_media(color_scheme=scheme)
        # Without the places of what passes, which take most of the time.
        options = {"resultTypes": ["violations"], **({} if scheme == schemes[0] else {"runOnly": ["color-contrast"]})}
        for each in page.evaluate("async options => (await axe.run(options)).violations", options):
            if each["impact"] in ("serious", "critical"):
                troubles.append((scheme, each["id"], [node["target"] for node in each["nodes"]][:3]))
    return troubles


def held_at(x: float, y: float, z: float) -> list[float]:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return [float(number) for number in pose.ravel()]


def move(page: Any, x: float, y: float, z: float) -> np.ndarray:
    """Where the tool comes to (4, 4) when the hand wants it there."""
    return np.reshape(page.evaluate("pose => window.feeler.moveTo(pose)", held_at(x, y, z)), (4, 4))


def document(page: Any) -> dict[str, Any]:
    found: dict[str, Any] = page.evaluate("() => JSON.parse(JSON.stringify(window.feeler.document))")
    return found


def wait(page: Any, condition: str, argument: Any = None) -> None:
    """Until a function of the page is true."""
    page.wait_for_function(condition, arg=argument)


def settled(page: Any) -> None:
    """Until the picture shows what was asked for last: what is clicked at is what is seen."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    wait(page, "() => window.feeler.stats.isWhole")


PICTURE = """async () => {
    const bitmap = await createImageBitmap(await window.feeler.shot(320, 180));
    const canvas = new OffscreenCanvas(320, 180);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    // As text: playwright takes a second for as many numbers.
    const bytes = context.getImageData(0, 0, 320, 180).data;
    let text = "";
    for (let at = 0; at < bytes.length; at += 8192) text += String.fromCharCode(...bytes.subarray(at, at + 8192));
    return btoa(text);
}"""


def picture(page: Any) -> np.ndarray:
    """The picture (180, 320, 3) as the page draws it now."""
    rows = np.frombuffer(base64.b64decode(page.evaluate(PICTURE)), np.uint8)
    return rows.reshape(180, 320, 4)[..., :3].astype(np.int16)


def differing(one: np.ndarray, other: np.ndarray) -> float:
    """The share of pixels that are clearly not the same."""
    return float((np.abs(one - other).max(axis=2) > 24).mean())
