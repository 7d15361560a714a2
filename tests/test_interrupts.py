"""Calls that take long look for signals while they run, so that Ctrl-C ends them."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")

# 64 closed balls in a grid, each a part. As a tool: all of them, or 16. `off`: all cross. `away`: beside each other.
SETUP = """
import os, signal, sys, threading, time
import numpy as np, feeler

rings, columns = 40, 80
polar = np.linspace(0, np.pi, rings + 1)[:, None]
around = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
ball = np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)), -1)
i, j = (x.ravel() for x in np.meshgrid(np.arange(rings), np.arange(columns), indexing="ij"))
beside = (j + 1) % columns
a, b, c, d = i * columns + j, (i + 1) * columns + j, (i + 1) * columns + beside, i * columns + beside
quads = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
balls = np.argwhere(np.ones((4, 4, 4))) * 0.1
vertices = (balls[:, None] + 0.04 * ball.reshape(1, -1, 3)).reshape(-1, 3)
faces = (np.arange(len(balls))[:, None, None] * ball[..., 0].size + quads).reshape(-1, 3)
parts = np.repeat(np.arange(len(balls)), len(quads))
mockup = feeler.Mockup(vertices, faces, parts)
scene, tool = feeler.Scene(mockup), feeler.Tool(vertices, faces)
few = feeler.Tool(vertices[: len(vertices) // 4], faces[: len(faces) // 4])
off, away, turned = np.eye(4), np.eye(4), np.eye(4)
off[:3, 3] = 0.003, 0.002, 0.001
away[0, 3] = 0.39
turned[:3] = [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0]]
"""

# Each would take minutes, or run out of memory after a while.
ENDLESS = {
    "clearance of all pairs": "scene.clearance(tool, off, within=np.inf, triangles=True)",
    "colliding pairs of many poses": "scene.collide_batch(tool, np.tile(off, (1_000_000, 1, 1)))",
    "distances of many poses": "scene.distance_batch(tool, np.tile(away, (1_000_000, 1, 1)))",
    "clearances of many poses": "scene.clearance_batch(tool, np.tile(off, (4000, 1, 1)), np.inf, triangles=True)",
    "a checked path": "scene.check_path(tool, np.tile(np.stack([away, turned]), (100_000, 1, 1)))",
}

# Each takes some tenths of a second at least.
LONG = {
    "contacts": "scene.contacts(tool, away, within=0.4)",
    "tracked contacts": "feeler.ContactTracker(scene, tool).contacts(away, within=0.4)",
    "penetration": "scene.penetration(tool, off)",
    "depth": "scene.depth(few, off)",
    "colliding pairs": "scene.collide(few, np.eye(4))",
    "the nearest parts": "scene.nearest(few, off, 30)",
    "a tool": "feeler.Tool(vertices, faces)",
    "topology": "scene.is_free(tool, away)",
}


def run(script: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", SETUP + script], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", ENDLESS)
def test_ctrl_c_ends_a_call_that_would_take_minutes(name: str) -> None:
    done = run(f"""
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
{ENDLESS[name]}
print("ended by itself")
""")
    assert "ended by itself" not in done.stdout
    assert done.stderr.rstrip().endswith("KeyboardInterrupt"), done.stderr


@pytest.mark.parametrize("name", LONG)
def test_signals_are_heard_while_a_call_runs(name: str) -> None:
    """A handler that runs twice before the call returns: at its end Python would run it once."""
    done = run(f"""
heard = []
signal.signal(signal.SIGALRM, lambda *_: heard.append(time.perf_counter()))
signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
{LONG[name]}
signal.setitimer(signal.ITIMER_REAL, 0)
print("heard", len(heard))
""")
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[1]) > 2, done.stdout
