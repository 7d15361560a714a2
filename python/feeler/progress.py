"""A progress bar for long steps: `with bar("loading") as progress: work(progress=progress)`.

`progress(fraction, stage)` may be called from any thread and at any rate. Output goes to stderr: in a terminal a bar
that appears after a second; elsewhere a line every ten seconds.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

Progress = Callable[[float, str], object]
"""The progress callback of long calls: called with the share done, 0 to 1, and the stage."""

SHOW_AFTER_S = 1.0
LINE_EVERY_S = 10.0

_shown = threading.Lock()  # a terminal has room for one bar: the outermost one


@contextlib.contextmanager
def bar(label: str, *, show_after_s: float = SHOW_AFTER_S, line_every_s: float = LINE_EVERY_S) -> Iterator[Progress]:
    """Yields `progress(fraction 0 to 1, stage)` and shows it while the block runs, if it runs long enough."""
    if not _shown.acquire(blocking=False):
        yield _ignore
        return
    try:
        display = _Bar(label, show_after_s) if _is_terminal() else _Lines(label, line_every_s)
        try:
            yield display.report
        finally:
            display.close()
    finally:
        _shown.release()


def _ignore(_fraction: float, _stage: str = "") -> None:
    pass


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


class _Bar:
    """A rich bar that appears after a while, even if the work has not reported by then."""

    def __init__(self, label: str, show_after_s: float) -> None:
        self._label = label
        self._lock = threading.Lock()
        self._state = (0.0, "")
        self._live: Any = None
        self._task: Any = None
        self._closed = False
        self._timer = threading.Timer(show_after_s, self._open)
        self._timer.daemon = True
        self._timer.start()

    def report(self, fraction: float, stage: str = "") -> None:
        with self._lock:
            self._state = (min(max(float(fraction), 0.0), 1.0), str(stage))
            if self._live is not None:
                self._update()

    def close(self) -> None:
        self._timer.cancel()
        with self._lock:
            self._closed = True
            if self._live is not None:
                self._live.stop()
                self._live = None

    def _open(self) -> None:
        # Imported here, so that short work does not pay for it.
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._closed:
                return
            self._live = Progress(
                TextColumn("{task.description}"),
                BarColumn(bar_width=32),
                TaskProgressColumn("{task.percentage:>3.0f} %"),
                TimeElapsedColumn(),
                TextColumn("[dim]{task.fields[stage]}"),
                console=Console(stderr=True),
                transient=True,
            )
            # Without a report there is no fraction to show: the bar pulses.
            self._task = self._live.add_task(self._label, total=None, stage="")
            if self._state[0] > 0:
                self._update()
            self._live.start()

    def _update(self) -> None:
        fraction, stage = self._state
        self._live.update(self._task, total=1.0, completed=fraction, stage=stage if stage != self._label else "")


class _Lines:
    """One line at each interval, for logs."""

    def __init__(self, label: str, every_s: float) -> None:
        self._label = label
        self._every_s = every_s
        self._last = time.monotonic()
        self._lock = threading.Lock()

    def report(self, fraction: float, stage: str = "") -> None:
        with self._lock:
            now = time.monotonic()
            if now - self._last < self._every_s:
                return
            self._last = now
        with contextlib.suppress(OSError, ValueError):  # a closed stderr must not stop the work
            print(f"{self._label}: {100 * fraction:.0f} %{' (' + stage + ')' if stage else ''}", file=sys.stderr)

    def close(self) -> None:
        pass
