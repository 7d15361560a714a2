"""The workbench from scripts and notebooks: `feeler.view(scene, tool)` opens it, and the `View` drives it."""

from __future__ import annotations

import atexit
import html
import io
import os
import threading
import warnings
import webbrowser
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NoReturn, Protocol

import numpy as np

import feeler
from feeler._core import Cast, Clearance, Collision, Contacts, Distance
from feeler.arguments import check_callable, check_flag, check_kind, check_path, check_whole, check_word
from feeler.atomic import atomic_file, check_target
from feeler.choices import VIEW_UNITS, ViewMode, ViewUnit
from feeler.errors import MeshError, OptionError, WorkbenchError, WriteError
from feeler.io.body import body_of, only_faces
from feeler.mechanism.mechanism import Mechanism
from feeler.mockup import Mockup, Tool
from feeler.picture.camera import check_size
from feeler.picture.png import write_png
from feeler.picture.renderer import render
from feeler.poses import PoseLike
from feeler.project.book import open_or_make
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import MODES
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol import CommandAnswer
from feeler.workbench.engine.mechanism import text_of
from feeler.workbench.session.session import Session
from feeler.workbench.view_commands import ViewCommands

_SHOT_S = 5.0
_SHOT_SIZE = (1280, 800)

_OPEN: set[View] = set()
"""Views to close at the end: their threads must not outlive the interpreter, nor their last changes be lost."""


@atexit.register
def _close_all() -> None:
    for view in list(_OPEN):
        try:
            view.close()
        except WriteError as trouble:
            warnings.warn(str(trouble), stacklevel=1)


def view(
    scene: Scene | Mockup,
    tool: Tool | None = None,
    *,
    port: int = 0,
    browser: bool = True,
    pose: PoseLike | None = None,
    mode: ViewMode = "stop",
    unit: ViewUnit = "mm",
    project: str | os.PathLike[str] | None = None,
    mechanism: Mechanism | None = None,
) -> View:
    """Opens the workbench on a scene, or on a mock-up, which is indexed first, with a tool in hand.

    - `port`: of 127.0.0.1; 0: any free one.
    - `browser`: opens the page; otherwise see `.url`.
    - `pose`: `(4, 4)` world_from_tool of the hand at the start; default beside the mock-up.
    - `mode`: the effect of contact on the hand: `"stop"`, `"glide"` or `"pass"`.
    - `unit`: of displayed lengths: `"mm"`, `"cm"`, `"m"` or `"in"`.
    - `project`: a project file (`.feelproj`), in which everything is saved; made if it is missing. What it has already
      replaces `pose`, `mode` and `unit`.
    - `mechanism`: of the mock-up: its joints have sliders in the page, and its parts can be dragged. It replaces that
      of a project.

    It runs until `close()`, the end of a `with`, or of the program. Raises `OptionError`, `MeshError`,
    `WorkbenchError` for an invalid pose, or if the server cannot start, and the errors of `open_project`.
    """
    given: object = scene
    if not isinstance(given, (Scene, Mockup)):
        raise MeshError(f"view needs a feeler.Scene or feeler.Mockup, not {type(given).__name__}")
    if tool is not None and not isinstance(tool, Tool):
        raise MeshError(f"the tool is a {type(tool).__name__}: pass a feeler.Tool, or None")
    check_word("mode", mode, MODES)
    check_word("unit", unit, VIEW_UNITS)
    check_whole("port", port, 0, 65535)
    check_flag("browser", browser)
    start = None if pose is None else motion.checked(pose, "pose")
    if mechanism is not None:
        check_kind("mechanism", mechanism, Mechanism)
        if mechanism.mockup is not (scene.mockup if isinstance(scene, Scene) else scene):
            raise OptionError("the mechanism is of another mock-up: make it of the one that is viewed")
    book = None if project is None else open_or_make(check_path("project", project))
    session = Session(unit=unit, project=book)
    try:
        opened = View(session, _served(session, port))
        if browser:
            webbrowser.open(opened.url)
        if isinstance(scene, Mockup):
            scene = Scene(scene, tool=tool, progress=lambda share, stage: session.loading(stage, share))
        session.open(scene.mockup, scene, tool, pose=start, mode=mode)
        if mechanism is not None:
            text = text_of(mechanism)
            session.command("mechanism_open", {"name": "mechanism", "text": text, "is_start": True}, None)
    except BaseException:
        session.close()
        raise
    return opened


def _served(session: Session, port: int) -> Serving:
    try:
        from feeler.workbench.net.server import Server
    except ImportError as error:
        raise WorkbenchError(f"the server needs {error.name}", "view", f"pip install {error.name}") from None
    server = Server(session, port=port)
    server.start()
    return server


class Serving(Protocol):
    """What serves the page of a view."""

    @property
    def url(self) -> str:
        """The address of the page, with its token."""

    def close(self) -> None:
        """Ends it."""


class View(ViewCommands):
    """An open workbench, which `feeler.view` makes. The commands of the page are its methods; each can be undone."""

    def __init__(self, session: Session, server: Serving) -> None:
        self.session = session
        self._server = server
        self._watchers: list[_Watcher] = []
        self._is_closed = False
        _OPEN.add(self)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a View cannot be pickled or copied: open one with feeler.view where it is needed")

    def command(self, name: str, /, **args: object) -> CommandAnswer:
        """Runs a command of the page by its name, such as `view.command("hide", parts="*screw*")`.

        The answer has the `id` of what was added, the `pose` of the hand, `undo_depth` and `redo_depth`. Raises
        `WorkbenchError`.
        """
        self._check_open(name)
        return super().command(name, **args)

    def findings_open(self, findings: feeler.Clashes | Mapping[str, object]) -> CommandAnswer:
        """Opens the findings of a clash check: of `feeler.clash`, or as `feeler clash --json` writes them.

        Findings of other programs need two paths and a depth each: `{"version": 1, "clashes": [{"a": PATH, "b": PATH,
        "depth": 0.002}]}`. They may have `id`, `verdict`, `gap`, `point_a`, `point_b`, `rule`, `status` and `group`;
        lengths are in metres.
        """
        if isinstance(findings, feeler.Clashes):
            findings = feeler.clashes.report(findings)
        return super().findings_open(findings)

    def _check_open(self, name: str) -> None:
        if self._is_closed:
            raise WorkbenchError("the view is closed", name, "open another with feeler.view")

    @property
    def url(self) -> str:
        """The page's address, with the token for access."""
        return str(self._server.url)

    @property
    def pose(self) -> Floats:
        """The hand's pose, `(4, 4)` world_from_tool, metres. Setting it sets a target: contact stops it by the mode.

        Setting waits for the hand to arrive, and can be undone. Raises `WorkbenchError` for an invalid pose.
        """
        return np.array(self.session.engine.pose)

    @pose.setter
    def pose(self, world_from_tool: PoseLike) -> None:
        self.place(list(motion.row(motion.checked(world_from_tool, "pose"))))

    @property
    def touched(self) -> list[str]:
        """Paths of the parts that the hand touches, or that stop it."""
        snapshot, mockup = self.session.snapshot(), self._scene.mockup
        return [] if snapshot is None else [mockup.part_paths[part] for part in snapshot.parts]

    def show_hit(self, hit: Collision | Cast | PoseLike) -> None:
        """Shows an answer of the scene until the hand moves: what collides, where a cast ends, or a pose.

        For a `Collision` its triangles are shown at the present pose of the hand; for a `Cast`, or a pose, the hand is
        put there, without a motion. Raises `WorkbenchError` for other values.
        """
        self._check_open("show_hit")
        if isinstance(hit, Collision):
            self.session.engine.show(np.asarray(hit.pairs), np.asarray(hit.kind_codes))
            return
        if hit is None:
            raise WorkbenchError(
                "there is nothing to show: hit is None, as from a free cast", "show_hit", "give a hit or a pose"
            )
        if isinstance(hit, (Distance, Clearance, Contacts)):
            kind = type(hit).__name__
            raise WorkbenchError(f"a {kind} has no pose", "show_hit", "give a Collision, a Cast, or a pose")
        pose = hit.pose if isinstance(hit, Cast) else hit
        self.session.engine.jump(motion.checked(pose, "show_hit"))

    def on_pose(self, watcher: Callable[[Floats], object]) -> Callable[[], None]:
        """Calls a function with the pose `(4, 4)` after each move of the hand; a slow function gets the newest one.

        It runs in a thread of its own, which ends with the view, or by calling the result.
        """
        check_callable("watcher", watcher, "a function of a pose (4, 4)")
        started = _Watcher(self.session, watcher)
        self._watchers.append(started)
        return started.end

    def screenshot(self, path: str | Path | None = None, *, size: tuple[int, int] = _SHOT_SIZE) -> bytes:
        """A picture as PNG, written to a file if one is named: from a page, or without one from our own renderer.

        size: width and height in pixels. Raises `WriteError`, `OptionError`.
        """
        width, height = check_size(size, 16, 8192)
        if path is not None:
            check_target(path, ".png")
        data = self.session.shot(width, height, _SHOT_S) or self._headless(width, height)
        if path is not None:
            with atomic_file(path, ".png") as file:
                file.write(data)
        return data

    def close(self) -> None:
        """Ends the server and the session; a second call does nothing.

        Raises `WriteError` if the last changes could not be saved in the project; all is closed then, too.
        """
        was_closed, self._is_closed = self._is_closed, True
        _OPEN.discard(self)
        for watcher in self._watchers:
            watcher.end()
        self._watchers = []
        self._server.close()
        self.session.close()
        trouble = self.session.unsaved()
        if trouble is not None and not was_closed:
            raise WriteError(f"the last changes are not saved: {trouble}")

    def __enter__(self) -> View:
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _traceback: object) -> None:
        try:
            self.close()
        except WriteError as trouble:
            if error is None:
                raise
            warnings.warn(str(trouble), stacklevel=2)  # the error of the block comes first

    def _repr_html_(self) -> str:
        # A link instead of a frame: the page forbids framing.
        url = html.escape(self.url, quote=True)
        return f'<a href="{url}" target="_blank" rel="noopener">Open the workbench</a>'

    def __repr__(self) -> str:
        return f"<feeler.View of {self._scene.mockup!r}>"

    @property
    def _scene(self) -> Scene:
        return self.session.scene

    def _headless(self, width: int, height: int) -> bytes:
        document, mockup = self.session.current, self._scene.mockup
        away = [*document.hidden, *document.moved, *document.gripped]
        seen = self._scene.part_mask.copy()
        seen[away] = False
        body = body_of(mockup)
        bodies = [only_faces(body, seen[body.part_of_face])]
        held = self.session.held_tool()
        if held is not None:
            bodies.append(body_of(held, pose=self.pose, cut=False))
        bodies += [body_of(part) for part in self.session.put_down()]
        file = io.BytesIO()
        write_png(file, render(None, *bodies, size=(width, height)))
        return file.getvalue()


class _Watcher:
    """Calls a function with the newest pose, so that a slow one delays nobody."""

    def __init__(self, session: Session, watcher: Callable[[Floats], object]) -> None:
        self._session, self._watcher = session, watcher
        self._news, self._is_ended = threading.Event(), False
        self._end = session.on_snapshot(self._news.set)
        self._thread = threading.Thread(target=self._loop, name="feeler view", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Ends further calls."""
        self._is_ended = True
        self._end()
        self._news.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10.0)

    def _loop(self) -> None:
        before: Floats | None = None
        while self._news.wait() and not self._is_ended:
            self._news.clear()
            snapshot = self._session.snapshot()
            if snapshot is not None and (before is None or not np.array_equal(before, snapshot.pose)):
                before = snapshot.pose
                self._watcher(before.copy())
