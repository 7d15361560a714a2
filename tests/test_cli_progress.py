"""The progress bar: silent for short work, one display at a time, safe to call from anywhere."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from feeler import progress as progress_module
from feeler.progress import bar


def test_short_work_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with bar("loading") as progress:
        for i in range(1000):
            progress(i / 1000, "reading")
    assert capsys.readouterr() == ("", "")


def test_long_work_without_a_terminal_writes_a_line_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [100.0]
    monkeypatch.setattr(progress_module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    with bar("loading", line_every_s=10.0) as progress:
        for clock[0], done in ((109.0, 0.1), (110.0, 0.5), (111.0, 0.6), (119.5, 0.7), (120.0, 0.8)):
            progress(done, "sorting")
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "loading: 50 % (sorting)\nloading: 80 % (sorting)\n"


class Timer:
    """A `threading.Timer` that goes off when the test says so."""

    def __init__(self, seconds: float, function: Callable[[], None]) -> None:
        self.seconds, self.function, self.state = seconds, function, "made"

    def start(self) -> None:
        self.state = "started"

    def cancel(self) -> None:
        self.state = "cancelled"


def test_in_a_terminal_a_bar_appears_even_if_the_work_says_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress_module, "_is_terminal", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("FORCE_COLOR", "1")
    timers: list[Timer] = []
    threads = SimpleNamespace(
        Lock=threading.Lock, Timer=lambda *arguments: timers.append(Timer(*arguments)) or timers[-1]
    )
    monkeypatch.setattr(progress_module, "threading", threads)
    with bar("loading", show_after_s=2.0):
        assert timers[0].state == "started" and timers[0].seconds == 2.0
        assert capsys.readouterr().err == "", "not yet"
        timers[0].function()
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "loading" in captured.err
    with bar("quick"):
        pass
    assert timers[1].state == "cancelled"
    timers[1].function()  # as a timer does that is cancelled too late
    assert capsys.readouterr().err == ""


def test_bars_inside_bars_are_silent(capsys: pytest.CaptureFixture[str]) -> None:
    with bar("outer", line_every_s=0.0) as outer:
        with bar("inner", line_every_s=0.0) as inner:
            inner(0.5, "never seen")
        outer(0.5, "seen")
    assert capsys.readouterr().err == "outer: 50 % (seen)\n"


def test_calls_from_many_threads(capsys: pytest.CaptureFixture[str]) -> None:
    with bar("work", line_every_s=0.0) as progress:
        threads = [threading.Thread(target=progress, args=(i / 8, "")) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(capsys.readouterr().err.splitlines()) == 8


def test_an_error_passes_through_and_frees_the_bar(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="inside"), bar("work"):
        raise ValueError("inside")
    with bar("next", line_every_s=0.0) as progress:
        progress(1.0, "")
    assert "next" in capsys.readouterr().err
