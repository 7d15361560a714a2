"""The progress bar: silent for short work, one display at a time, safe to call from anywhere."""

from __future__ import annotations

import threading
import time

import pytest

from feeler import progress as progress_module
from feeler.progress import bar


def test_short_work_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with bar("loading") as progress:
        for i in range(1000):
            progress(i / 1000, "reading")
    assert capsys.readouterr() == ("", "")


def test_long_work_without_a_terminal_writes_a_line_now_and_then(capsys: pytest.CaptureFixture[str]) -> None:
    with bar("loading", line_every_s=0.05) as progress:
        progress(0.1, "reading")
        time.sleep(0.06)
        progress(0.5, "sorting")
        progress(0.6, "sorting")
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "loading: 50 % (sorting)\n"


def test_in_a_terminal_a_bar_appears_even_if_the_work_says_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress_module, "_is_terminal", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("FORCE_COLOR", "1")
    with bar("loading", show_after_s=0.01):
        time.sleep(0.4)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "loading" in captured.err
    with bar("quick", show_after_s=5):
        pass
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
