"""The measurements, each experiment a function that returns plain data. Lengths in metres, times as in the names."""

from __future__ import annotations

import gzip
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import feeler
from feeler.arguments import check_word
from feeler.choices import SAMPLE_NAMES
from feeler.io import write_glb
from feeler.workbench import files
from feeler.workbench.session.benchmark import FILE
from feeler.workbench.session.session import Session

from . import stand

Result = dict[str, Any]

LARGE, SMALL = (1280, 720), (640, 360)
SPEEDS_M_PER_S = (0.01, 0.1, 1.0, 10.0)
STOP_WAY_M = 0.01
PRESS_M = 0.02
ABOVE_M = 0.005
PARTS = 10_000
CUT_MS = 2000
RAYS = 1000
SOAK_CHUNK_S = 10.0


def pictures(browser: Any, mockup: str, size: tuple[int, int], repeats: int) -> list[Result]:
    """`feeler view --benchmark`: opening, camera and tool moving, single frames; once each repeat."""
    found = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            words = [mockup, *(["--tool", "sample:wrench"] if mockup.startswith("sample:") else []), "--benchmark"]
            with (
                stand.viewing(*words, folder=folder) as program,
                stand.opened(browser, program.url, *size),
            ):
                program.wait()
            found.append(json.loads((folder / FILE).read_text(encoding="utf-8")))
    return found


def parts(browser: Any, repeats: int) -> list[Result]:
    """The same of ten thousand boxes: what hiding and filtering all of them costs."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "parts.glb"
        write_glb(path, boxes(PARTS))
        return pictures(browser, str(path), SMALL, repeats)


def boxes(count: int) -> feeler.Mockup:
    """Boxes in a grid, in groups of a hundred."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.008
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])
    places = np.stack(np.unravel_index(np.arange(count), (100, 100, -(-count // 10_000))), axis=1) * 0.01
    return feeler.Mockup(
        (places[:, None] + corner).reshape(-1, 3),
        (8 * np.arange(count)[:, None, None] + faces).reshape(-1, 3),
        np.repeat(np.arange(count), len(faces)),
        [f"piece {part}" for part in range(count)],
        part_paths=[f"stock/shelf {part // 100}/piece {part}" for part in range(count)],
    )


def page(browser: Any, mockup: str, move_s: float) -> Result:
    """One page at 640x360: memory, the tool in contact, stops, a cut, a lost context."""
    with (
        stand.viewing(mockup, "--tool", "sample:wrench") as program,
        stand.opened(browser, program.url, *SMALL, script=_CUTTER) as opened,
    ):
        stand.ready(opened)
        # Again, now that nothing has to be read or indexed: only the page's own work is left.
        begun = stand.cpu_s(program)
        opened.reload()
        stand.ready(opened)
        opening_cpu_s = stand.cpu_s(program) - begun
        manifest, manifest_bytes = stand.manifest(program.url)
        triangles = manifest["triangles"]
        found: Result = {
            "triangles": triangles,
            "pieces": len(manifest["pieces"]),
            "wire_bytes_per_triangle": sum(piece["bytes"] for piece in manifest["pieces"]) / triangles,
            "manifest_bytes": manifest_bytes,
            "heap_bytes_per_triangle": stand.heap_bytes(opened) / triangles,
            "opening_cpu_s": opening_cpu_s,
        }
        opened.wait_for_function("() => window.feeler.stats.isSettled")
        go_above(opened, manifest)
        begun = stand.cpu_s(program)
        moved = opened.evaluate(_MOVE, move_s)
        found["tool_cpu_ms"] = 1e3 * (stand.cpu_s(program) - begun) / max(1, moved["frames"])
        found["free"] = moved
        contact = opened.evaluate(_DOWN, float(manifest["upper"][2] - manifest["lower"][2]))
        found["contact"] = contacts(opened, contact, move_s)
        found["stops"] = stops(opened, contact)
        found["reconnect"] = opened.evaluate(_CUT, CUT_MS)
        found["lost_context_s"] = opened.evaluate(_LOSE) / 1000
        return found


def go_above(opened: Any, manifest: dict[str, Any]) -> None:
    """Moves the wrench from its start, beside the mock-up, to above the middle of it: up, and over."""
    low, high = feeler.sample_tool("wrench").bounds
    pose = opened.evaluate("() => [...window.feeler.pose]")
    pose[11] = manifest["upper"][2] - low[2] + ABOVE_M
    opened.evaluate("pose => window.feeler.moveTo(pose)", pose)
    middle = (np.array(manifest["lower"]) + manifest["upper"] - low - high) / 2.0
    pose[3], pose[7] = middle[:2].tolist()
    opened.evaluate("pose => window.feeler.moveTo(pose)", pose)


def contacts(opened: Any, contact: list[float], move_s: float) -> Result:
    """The tool pressed into the parts that it touches, and moved around there."""
    pressed = [*contact]
    pressed[11] -= PRESS_M
    opened.evaluate("pose => window.feeler.moveTo(pose)", pressed)
    return dict(opened.evaluate(_MOVE, move_s))


def stops(opened: Any, contact: list[float]) -> Result:
    """Where the tool comes to rest when the hand moves on through an obstacle, at each speed."""
    start = [*contact]
    start[11] += STOP_WAY_M / 2
    poses = [
        opened.evaluate(_APPROACH, {"start": start, "step": speed / 60, "way": STOP_WAY_M}) for speed in SPEEDS_M_PER_S
    ]
    spread = np.ptp(np.array(poses), axis=0).max()
    return {
        "speeds_m_per_s": list(SPEEDS_M_PER_S),
        "heights_m": [pose[11] for pose in poses],
        "spread_m": float(spread),
    }


def soak(browser: Any, mockup: str, seconds: float) -> Result:
    """The tool moves on and on: what page and server hold at the end above what they held near the beginning."""
    with (
        stand.viewing(mockup, "--tool", "sample:wrench") as program,
        stand.opened(browser, program.url, *SMALL) as opened,
    ):
        stand.ready(opened)
        opened.wait_for_function("() => window.feeler.stats.isSettled")
        return _soaked(opened, program, seconds)


def _soaked(opened: Any, program: stand.Viewing, seconds: float) -> Result:
    heaps: list[int] = []
    servers: list[int] = []
    unanswered: list[int] = []
    frames = 0
    begun = time.monotonic()
    while not heaps or time.monotonic() - begun < seconds:
        moved = opened.evaluate(_MOVE, min(SOAK_CHUNK_S, max(1.0, seconds)))
        frames += moved["frames"]
        unanswered.append(moved["most_unanswered"])
        heaps.append(stand.heap_bytes(opened))
        servers.append(program.memory())
    took = time.monotonic() - begun
    return {
        "seconds": took,
        "frames_per_s": frames / took,
        "heap_growth_bytes": heaps[-1] - heaps[0],
        "server_growth_bytes": servers[-1] - servers[0],
        "most_unanswered": max(unanswered),
    }


def engine(browser: Any, mockup: str) -> Result:
    """Times of the core and the jobs, and the opening of one HTML file to send."""
    _, name, size = mockup.split(":")
    world = feeler.sample(check_word("name", name, SAMPLE_NAMES), int(size))
    scene = feeler.Scene(world)
    lower, upper = world.bounds
    middle = 0.5 * (lower + upper)
    outlines = [_best_s(lambda axis=axis: scene.section(middle, np.eye(3)[axis])) for axis in range(3)]
    rng = np.random.default_rng(1)
    origins = middle + rng.normal(size=(RAYS, 3)) * np.linalg.norm(upper - lower)
    aims = lower + rng.random((RAYS, 3)) * (upper - lower)
    one_by_one = _best_s(lambda: [scene.rays(origins[i : i + 1], aims[i : i + 1] - origins[i]) for i in range(RAYS)])
    with Session(has_threads=True) as session, tempfile.TemporaryDirectory() as folder:
        session.open(world, scene, None)
        begun = time.perf_counter()
        written = session.job("page", {}).result()
        took = time.perf_counter() - begun
        data = session.export(written["name"])
        path = Path(folder) / "page.html"
        path.write_bytes(data)
        with stand.opened(browser, path.as_uri(), *SMALL) as opened:
            stand.ready(opened)
            open_s = opened.evaluate("() => window.feeler.stats.whole_picture_ms - performance.timeOrigin") / 1000
    return {
        "triangles": world.triangle_count,
        "outline_ms": 1e3 * max(outlines),
        "ray_us": 1e6 * one_by_one / RAYS,
        "page_bytes": len(data),
        "page_left_out": written["left_out"],
        "page_written_s": took,
        "page_opens_s": open_s,
    }


def bundle() -> Result:
    """Size of the built page."""
    static = files.static_files()
    return {
        "files": len({id(each) for each in static.values()}),
        "gzipped_bytes": sum(len(gzip.compress(f.data, 9)) for f in {id(f): f for f in static.values()}.values()),
    }


def _best_s(work: Any, repeats: int = 3) -> float:
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


_MOVE = "seconds => window.feeler.moveAround(seconds)"

# Down from where the hand begins, through all of the mock-up: where the tool stops.
_DOWN = """height => {
  const pose = [...window.feeler.pose];
  pose[11] -= height;
  return window.feeler.moveTo(pose);
}"""

_APPROACH = """async ({ start, step, way }) => {
  await window.feeler.moveTo(start);
  let last = null;
  for (let gone = 0; gone < way; ) {
    gone = Math.min(way, gone + step);
    const pose = [...start];
    pose[11] -= gone;
    last = window.feeler.moveTo(pose);
    last.catch(() => {});
    await new Promise(requestAnimationFrame);
  }
  return last;
}"""

# Sockets that can be cut, and for a while not opened again; when the last welcome came.
_CUTTER = """(() => {
  const Real = window.WebSocket;
  const open = new Set();
  const cut = { until: 0, welcomed: 0, welcomes: 0 };
  window.benchCut = ms => {
    cut.until = performance.now() + ms;
    for (const socket of open) socket.close();
    return cut;
  };
  window.WebSocket = class extends Real {
    constructor(...words) {
      super(...words);
      open.add(this);
      this.addEventListener("open", event => {
        if (performance.now() >= cut.until) return;
        event.stopImmediatePropagation();
        this.close();
      });
      this.addEventListener("close", () => open.delete(this));
      this.addEventListener("message", ({ data }) => {
        if (typeof data !== "string" || JSON.parse(data).kind !== "welcome") return;
        cut.welcomed = performance.now();
        cut.welcomes++;
      });
    }
  };
})();"""

_CUT = """async ms => {
  const before = JSON.stringify(window.feeler.document);
  const cut = window.benchCut(ms);
  const welcomes = cut.welcomes;
  while (cut.welcomes === welcomes) await new Promise(resolve => setTimeout(resolve, 5));
  return { seconds: (cut.welcomed - cut.until) / 1000, is_same: JSON.stringify(window.feeler.document) === before };
}"""

_LOSE = """async () => {
  const canvas = document.querySelector("#picture");
  const context = canvas.getContext("webgl2");
  const loss = context.getExtension("WEBGL_lose_context");
  const frame = () => new Promise(requestAnimationFrame);
  loss.loseContext();
  await new Promise(resolve => setTimeout(resolve, 200));
  const back = new Promise(resolve => canvas.addEventListener("webglcontextrestored", resolve, { once: true }));
  const begun = performance.now();
  loss.restoreContext();
  await back;
  await frame();
  await frame();
  while (!window.feeler.stats.isShown) await frame();
  return performance.now() - begun;
}"""
