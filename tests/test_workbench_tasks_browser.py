"""Tasks as people plan them: the panel, its chart, its edits, by pointer and keys, in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser import differing, document, keep, opened, picture, program, settled, troubles, wait
from shapes import mockup_of
from test_task import driver
from test_workbench_tasks import mockup

from feeler.io import write_glb, write_stl

DONE = "() => window.feeler.document.cards.length > 0 && window.feeler.document.cards.at(-1).state === 'done'"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("bolted")
    write_glb(folder / "bolted.glb", mockup())
    tool = driver()
    write_stl(folder / "driver.stl", mockup_of({"driver": (tool.vertices, tool.faces)}))
    return folder / "bolted.glb", folder / "driver.stl"


def order(page: Any) -> list[str]:
    """The steps of the chart, in words, once the plan is there."""
    wait(page, DONE)
    page.locator(".gantt-row").first.wait_for()
    return [text.split("\n")[0] for text in page.locator(".gantt-row").all_inner_texts()]


def edited(page: Any, count: int) -> None:
    """Waits until the card has so many edits, and its plan."""
    wait(page, "count => Object.values(window.feeler.document.cards.at(-1).edits).flat().length === count", count)
    wait(page, DONE)


def test_a_task_is_planned_watched_and_edited(context: Any, files: tuple[Path, Path], root: Path) -> None:
    with program(files[0], "--tool", files[1]) as started:
        page = opened(context, started)
        panel = page.locator("#panel")
        page.get_by_role("tab", name="Task").click()
        assert "Select what is taken out" in panel.inner_text()
        page.keyboard.press("/")
        page.keyboard.type("left")
        page.locator("[role=treeitem]", has_text="left").last.click()
        panel.get_by_label("Tools").select_option("those of the workbench")
        panel.get_by_role("button", name="How is it taken out?").click()
        steps = order(page)
        assert [step[2:] for step in steps] == ["take out lid", "undo left"]
        assert "Best found" in panel.inner_text() and "not below" in panel.inner_text()
        keep(page.screenshot(), "task.png")
