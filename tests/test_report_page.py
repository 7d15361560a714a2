"""The page of a report in a real Chromium: its script, its policy, and that it needs nothing but itself."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browser import SLOW_MS, chromium
from commands import run
from report_project import BOLD, project
from workbench_scene import stand

import feeler
from feeler.clashes import write_html
from feeler.workbench.document.document import Document
from feeler.workbench.report.html_style import CHUNK, STYLE, chunk_class
from feeler.workbench.session.export import sequence_html

playwright = pytest.importorskip("playwright.sync_api")


def test_a_page_plays_ways_filters_findings_and_runs_nothing_else(tmp_path: Path) -> None:
    path = project(tmp_path, text=BOLD)
    run("report", path, "--html", tmp_path / "r.html", "--pictures", "3")
    said: list[str] = []
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        context = browser.new_context(offline=True, color_scheme="dark")
        page = context.new_page()
        page.set_default_timeout(SLOW_MS)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("dialog", lambda dialog: said.append(dialog.message))
        page.goto((tmp_path / "r.html").as_uri())

        film = page.locator(".film.live").first
        assert film.locator("img.on").count() == 1
        first = film.locator("img.on").get_attribute("alt")
        film.get_by_role("button", name="Play").click()
        film.get_by_role("button", name="Pause").wait_for()
        film.get_by_role("button", name="Play").wait_for()  # at the end
        assert film.locator("img.on").get_attribute("alt") != first
        film.get_by_role("slider").focus()
        page.keyboard.press("Home")
        assert film.locator("img.on").get_attribute("alt") == first

        rows = page.locator(".rows tbody tr[id]")
        every = rows.count()
        page.get_by_label("Filter").fill("BLOCK left")
        found = page.locator(".chunk:not([hidden]) .rows tbody tr[id]:not([hidden])").all_text_contents()
        assert 0 < len(found) < every
        assert all("block" in each and "left" in each for each in found)
        assert page.locator("#count").text_content() == f"{len(found)} of {every}"

        assert page.get_by_text(BOLD).count() >= 2, "a note is shown as it was written"
        assert page.locator("[onclick]").count() == 0
        width = page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
        assert width[0] <= width[1]
        page.emulate_media(media="print")
        assert film.locator("img").first.is_visible() and film.locator("img").last.is_visible()
        assert not film.get_by_role("button").is_visible()

        # Each finding is seen in the mock-up.
        page.emulate_media(media="screen")
        card = page.locator(".card", has=page.get_by_text("Show it in the mock-up")).first
        names = [each.inner_text() for each in card.locator(".part bdi").all()]
        with context.expect_page() as opened:
            card.get_by_text("Show it in the mock-up").click()
        shown = opened.value
        shown.set_default_timeout(SLOW_MS)
        said_of_it = shown.locator(".finding-said")
        said_of_it.wait_for()
        assert all(name in said_of_it.inner_text() for name in names[::2]), "the parts of that finding"
        shown.close()

        # The mock-up beside it is a page without a server, which has the ways in its sequence.
        page.get_by_text("Open the mock-up").click()
        page.wait_for_url("**/r-files/mock-up.html")
        page.get_by_role("tab").first.wait_for()  # no function: the policy forbids to make one of text
        names = page.evaluate("window.feeler.document.sequence.map((line) => line.name)")
        assert names == ["peg"]
        browser.close()
    assert [text for text in said if "GPU stall" not in text and "GL Driver" not in text] == []


def test_pages_of_commands_fit_a_narrow_window(tmp_path: Path) -> None:
    mockup = stand([f"part_{number}" + "_without_a_blank" * 12 for number in range(5)])
    paths = [str(path) for path in mockup.part_paths]
    write_html(tmp_path / "clash.html", feeler.clash(mockup, clearance=1.0))
    feeler.task(feeler.Scene(mockup), paths[1], seconds=10.0).to_html(tmp_path / "task.html")
    feeler.maintain(feeler.Scene(mockup), paths[1:2], seconds=10.0).to_html(tmp_path / "maintain.html")
    (tmp_path / "sequence.html").write_bytes(sequence_html(Document(unit="mm"), mockup, lambda *_: None))
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 320, "height": 800})
        for path in sorted(tmp_path.glob("*.html")):
            page.goto(path.as_uri())
            assert page.evaluate("document.documentElement.scrollWidth") == 320, path.name
            assert page.locator("main").count() == 1, path.name
        browser.close()


@pytest.mark.parametrize("rows", [1, 2, 9, 200, CHUNK])
def test_tables_that_are_not_laid_out_reserve_about_their_height(rows: int) -> None:
    power = chunk_class(rows).rpartition("-")[2]
    (reserved,) = re.findall(rf"\.chunk-{power} {{ contain-intrinsic-size: auto (\d+)px", STYLE)
    assert 0.5 < int(reserved) / (75 + 70 * rows) < 2.0
