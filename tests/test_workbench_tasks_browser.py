"""Tasks as people plan them: the panel, its chart, its edits, by pointer and keys, in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser import access_troubles, differing, keep, opened, picture, program, settled, troubles, wait
from shapes import mockup_of
from test_task import driver
from test_workbench_task_tools import OWN
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
    edits = "const { off, times, before } = window.feeler.document.cards.at(-1).edits"
    wait(page, f"count => {{ {edits}; return [...off, ...times, ...before].length === count }}", count)
    wait(page, DONE)


def test_a_task_is_planned_watched_and_edited(context: Any, files: tuple[Path, Path]) -> None:
    with program(files[0], "--tool", files[1]) as started:
        page = opened(context, started)
        panel = page.locator("#panel")
        page.get_by_role("tab", name="Task").click()
        assert "Select what is taken out" in panel.inner_text()
        for name, keys in (("left", []), ("right", ["Control"])):
            page.locator("[role=treeitem]", has_text=name).last.click(modifiers=keys)
        panel.get_by_label("Tools").select_option("of the workbench")
        panel.get_by_role("button", name="How is it taken out?").click()
        assert [step[2:] for step in order(page)] == ["take out lid", "undo left", "undo right"]
        assert "Best found" in panel.inner_text() and "not below" in panel.inner_text()
        settled(page)
        at_first = picture(page)

        # A step by the keyboard: its tool stands in its seat, its way is drawn; and the film of all.
        rows = page.locator(".gantt-row")
        rows.nth(1).focus()
        page.keyboard.press("Enter")
        wait(page, "() => document.querySelectorAll('.gantt-row')[1].ariaCurrent === 'step'")
        page.wait_for_timeout(300)
        settled(page)
        assert differing(picture(page), at_first) > 0.01
        assert "strokes" in panel.inner_text() and "turns; at" in panel.inner_text()
        inset = panel.locator(".task-sight img")
        inset.wait_for()
        assert inset.evaluate("each => each.complete && each.naturalWidth > 0")
        assert "visible" in panel.locator(".task-sight figcaption").inner_text()
        keep(page.screenshot(), "task.png")
        panel.get_by_label("Speed").select_option("4")
        panel.get_by_role("button", name="Play").click()
        wait(page, "() => document.querySelectorAll('.gantt-row')[2].ariaCurrent === 'step'")

        # Edits plan again: a typed time, an order, and what is off already; each can be taken back.
        rows.nth(2).click()
        panel.get_by_label("Time").fill("-5")
        panel.get_by_label("Time").press("Enter")
        panel.get_by_text("Type seconds such as 90").wait_for()
        assert panel.get_by_label("Time").input_value() == "-5", "it stays, to be mended"
        panel.get_by_label("Time").fill("1.5 min")
        panel.get_by_label("Time").press("Enter")
        edited(page, 1)
        order(page)
        assert "right takes 1 min 30 s, typed" in panel.inner_text()
        earlier = panel.get_by_label("Do it before")
        assert earlier.locator("option").all_inner_texts()[-1] == "2 undo left"
        earlier.select_option(label="2 undo left")
        panel.get_by_role("button", name="Force the order").click()
        edited(page, 2)
        assert [step[2:] for step in order(page)] == ["take out lid", "undo right", "undo left"]
        rows.first.click()
        panel.get_by_role("button", name="Already off").click()
        edited(page, 3)
        assert [step[2:] for step in order(page)] == ["undo right", "undo left"]
        assert "typed" in rows.first.inner_text() and "1 min 38 s" in rows.first.inner_text()
        page.emulate_media(color_scheme="light")
        settled(page)
        panel.evaluate("each => each.scrollTo(0, 260)")
        keep(page.screenshot(), "task_light.png")
        panel.get_by_role("button", name="Take back: right goes before left").click()
        edited(page, 2)
        page.locator("#picture").focus()
        for _ in range(4):
            page.keyboard.press("Control+z")
        edited(page, 0)
        assert [step[2:] for step in order(page)] == ["take out lid", "undo left", "undo right"]

        # A table of times plans again; a wrong one says what is wrong, and changes nothing. A catalogue does, too.
        table = files[0].with_name("ours.toml")
        troubled = panel.get_by_role("alert")

        def give(button: str, text: str) -> None:
            table.write_text(text, encoding="utf-8")
            with page.expect_file_chooser() as chosen:
                panel.get_by_role("button", name=button).click()
            chosen.value.set_files(table)

        give("Open times", "[elements]\nfly = 1\n")
        troubled.get_by_text("ours.toml: elements has 'fly'").wait_for()
        assert "Times are examples" in panel.inner_text()
        give("Open times", "[elements]\nget = 90\n")
        panel.get_by_text("1 of 9 elements").wait_for()
        wait(page, DONE)
        assert "2 min" in rows.nth(1).inner_text() and troubled.count() == 0
        panel.get_by_role("button", name="Use the example times").click()
        panel.get_by_text("Times are examples").wait_for()
        give("Open catalogue", OWN.replace("= 5", "= -5"))
        troubled.get_by_text("ours.toml, [[open]] 1 in line 2: thick_mm is -5").wait_for()
        assert access_troubles(page) == []
        give("Open catalogue", OWN)
        panel.get_by_text("Tools of ours.toml").wait_for()
        assert troubled.count() == 0 and "1 tool" in panel.inner_text()
        keep(page.screenshot(), "task_catalogue.png")
        panel.get_by_label("Tools").select_option("of the catalogue")
        page.locator("[role=treeitem]", has_text="left").last.click()
        panel.get_by_role("button", name="How is it taken out?").click()
        wait(page, "() => window.feeler.document.cards.length === 2")
        order(page)
        rows.nth(1).click()
        assert "ours 13" in panel.inner_text()
        panel.get_by_role("button", name="Use the built-in catalogue").click()
        panel.get_by_text("Tools of the built-in catalogue").wait_for()
        wait(page, DONE)

        assert troubles(page) == []
