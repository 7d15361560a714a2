"""A small scene for the tests of the workbench, and a session whose clock is moved by hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

import feeler
from feeler.workbench.document.openings import FilePiece, SendFiles
from feeler.workbench.session.session import Session

QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
FACES = np.array([[q[0], q[i], q[i + 1]] for q in QUADS for i in (1, 2)])
PATHS = ["stand/plate", "stand/posts/left", "stand/posts/right", "stand/peg", "sheet"]
PLATE, LEFT, RIGHT, PEG, SHEET = range(5)


def corners(lower: tuple[float, ...], upper: tuple[float, ...]) -> np.ndarray:
    picks = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return np.array(lower) + picks * (np.array(upper) - np.array(lower))


def stand(names: list[str] | None = None) -> feeler.Mockup:
    """A plate whose top is at z = 0, two posts and a peg that stand on it, and a sheet of no thickness at z = 0.5."""
    boxes = [
        corners((-0.5, -0.5, -0.0625), (0.5, 0.5, 0.0)),
        corners((-0.375, -0.0625, 0.0), (-0.25, 0.0625, 0.25)),
        corners((0.25, -0.0625, 0.0), (0.375, 0.0625, 0.25)),
        corners((-0.03125, 0.25, 0.0), (0.03125, 0.3125, 0.125)),
    ]
    sheet = np.array([[-0.5, -0.5, 0.5], [0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]])
    faces = [FACES + 8 * i for i in range(4)] + [np.array([[0, 1, 2], [0, 2, 3]]) + 32]
    paths = names or PATHS
    return feeler.Mockup(
        np.concatenate([*boxes, sheet]),
        np.concatenate(faces),
        np.repeat(np.arange(5), [12, 12, 12, 12, 2]),
        [path.split("/")[-1] for path in paths],
        part_paths=paths,
    )


def cube(size: float = 0.0625, name: str = "cube") -> feeler.Tool:
    return feeler.Tool(corners((-size / 2,) * 3, (size / 2,) * 3), FACES, name)


def at(x: float, y: float, z: float, turn: float = 0.0) -> np.ndarray:
    """A pose: turned about z by some radians, then moved."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    pose[:3, 3] = x, y, z
    return pose


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


class Bench:
    """A session with a clock of its own, and what a hand does in it."""

    def __init__(
        self,
        tool: feeler.Tool | None = None,
        *,
        pose: np.ndarray | None = None,
        mode: str = "stop",
        record: Path | None = None,
        mockup: feeler.Mockup | None = None,
        absent: list[int] | None = None,
        tools: Iterable[feeler.Tool] = (),
    ) -> None:
        """absent: parts that are left out of the scene."""
        self.clock = Clock()
        self.session = Session(clock=self.clock, has_threads=False, record=record)
        self.events: list[dict] = []
        self.session.subscribe(self.events.append)
        self.mockup = mockup or stand()
        self.scene = feeler.Scene(self.mockup).without(absent or [])
        self.session.open(self.mockup, self.scene, tool, pose=pose, mode=mode, tools=[cube(0.03125, "small"), *tools])
        self.seq = 0
        self.tick()

    def tick(self, seconds: float = 1 / 60) -> None:
        self.clock.now += seconds
        self.session.engine.tick()

    def wish(self, pose: np.ndarray, seconds: float = 1 / 60) -> None:
        self.seq += 1
        self.session.wish(pose, self.seq, "mouse")
        self.tick(seconds)

    def drag(self, goal: np.ndarray, speed: float, rate_hz: float = 60.0) -> None:
        """Straight from where the hand is to a goal, at a speed (m/s), asked so often; turns stay."""
        start = self.pose
        way = goal[:3, 3] - start[:3, 3]
        steps = max(1, int(np.ceil(np.linalg.norm(way) / speed * rate_hz)))
        for step in range(1, steps + 1):
            pose = goal.copy()
            if step < steps:
                pose[:3, 3] = start[:3, 3] + way * (step / steps)
            self.wish(pose, 1 / rate_hz)

    def command(self, name: str, /, **args: object) -> dict:
        return self.session.command(name, args)

    @property
    def pose(self) -> np.ndarray:
        return self.session.engine.pose

    @property
    def document(self) -> dict:
        return self.session.document()

    def of_type(self, kind: str) -> list[dict]:
        return [event for event in self.events if event["type"] == kind]


def sent(session: Session, data: bytes) -> int:
    """Sends a file for a job, as a page does; the number of the set."""
    number: int = session.openings.request(SendFiles(1, "job", [{"name": "a", "bytes": len(data)}]))["files"]
    session.openings.request(FilePiece(2, number, 0, np.frombuffer(data, np.uint8)))
    return number
