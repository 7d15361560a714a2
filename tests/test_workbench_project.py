"""A project in the page, in a real Chromium: the status line, Ctrl+S, the download, and a newer revision."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from browser import document, opened, program, troubles, wait

import feeler
from feeler.io import write_glb
from feeler.project.book import open_or_make
from feeler.workbench.session.session import Session

SAVED = "() => window.feeler.document.project.state === 'saved'"


def test_work_is_saved_and_there_again(context: Any, stand: Path, cube: Path, tmp_path: Path) -> None:
    path = tmp_path / "stand.feelproj"
    with program(stand, "--tool", cube, "--project", path) as started:
        page = opened(context, started)
        wait(page, SAVED)
        page.locator(".project-state").get_by_text("Saved", exact=True).wait_for()
        page.evaluate("() => window.feeler.document.hidden.length")
        page.locator("#picture").focus()
        page.keyboard.press("Control+a")
        page.keyboard.press("h")
        wait(page, "() => window.feeler.document.hidden.length > 0")
        wait(page, SAVED)
        page.keyboard.press("Control+s")
        page.get_by_text("stand.feelproj saves each change as you make it").wait_for()
        hidden = document(page)["hidden"]
        assert troubles(page) == []
        page.close()
    with program(path) as started:
        page = opened(context, started)
        assert document(page)["hidden"] == hidden and document(page)["tool"]["name"] == "cube"
        page.close()


def test_without_a_project_it_comes_as_a_download(context: Any, stand: Path, tmp_path: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        with page.expect_download() as waiting:
            page.locator("#picture").focus()
            page.keyboard.press("Control+s")
        waiting.value.save_as(tmp_path / "a.feelproj")
        assert waiting.value.suggested_filename.endswith(".feelproj")
        page.close()
    with feeler.open_project(tmp_path / "a.feelproj") as project:
        assert project.part_paths() and not project.changes(feeler.load_mockup(stand))


def test_a_newer_revision_is_told_and_accepted(context: Any, stand: Path, tmp_path: Path) -> None:
    path = tmp_path / "stand.feelproj"
    before = feeler.load_mockup(stand)
    feeler.open_project(path, before).close()
    vertices = before.vertices.copy()
    vertices[np.unique(before.faces[before.part_of_face == 0])] += 0.5
    after = feeler.Mockup(vertices, before.faces, before.part_of_face, before.part_names, part_paths=before.part_paths)
    write_glb(tmp_path / "stand-2.glb", after)
    with program(tmp_path / "stand-2.glb", "--project", path) as started:
        page = opened(context, started)
        wait(page, SAVED)
        page.get_by_role("button", name="Parts: 1 moved").click()
        wait(page, "() => document.querySelectorAll('[aria-selected=true].row, .row.selected').length >= 0")
        page.keyboard.press("Control+k")
        page.locator(".palette-input").fill("accept this revision")
        page.keyboard.press("Enter")
        wait(page, "() => Object.keys(window.feeler.document.project.stale).length === 0")
        wait(page, SAVED)
        assert page.get_by_role("button", name="Parts: 1 moved").count() == 0
        assert troubles(page) == []
        page.close()
    with feeler.open_project(path) as project:
        assert not project.changes()


def test_results_of_an_earlier_revision_say_so_in_their_panels(context: Any, stand: Path, tmp_path: Path) -> None:
    path, before = tmp_path / "stand.feelproj", feeler.load_mockup(stand)
    session = Session(has_threads=False, project=open_or_make(path))
    session.open(before, feeler.Scene(before), None)
    one, other = before.part_paths[:2]
    session.command("requirement_add", {"name": "apart", "a": one, "b": other, "gap": 0.0})
    results = session.job("verify", {}).result(60)
    session.command("requirements_checked", {"results": results})
    session.command("measure_add", {"type": "parts", "parts": [0, 1], "name": "between"})
    session.command("findings_take", {"key": session.job("clash", {}).result(60)["key"]})
    assert session._saver is not None and session._saver.wait(60)
    session.close()
    vertices = before.vertices.copy()
    vertices[np.unique(before.faces[before.part_of_face == 0])] += 2.0**-7
    after = feeler.Mockup(vertices, before.faces, before.part_of_face, before.part_names, part_paths=before.part_paths)
    (tmp_path / "new").mkdir()
    write_glb(tmp_path / "new" / stand.name, after)
    with program(tmp_path / "new" / stand.name, "--project", path) as started:
        page = opened(context, started)
        wait(page, SAVED)
        page.locator("#picture").focus()
        page.keyboard.press("Alt+6")
        said = f"in an earlier revision: {before.part_names[0]} moved since"
        page.get_by_text("Clearances that must hold (1 of an earlier revision)").click()
        page.get_by_text(said).wait_for()
        page.get_by_text("Of an earlier revision:").wait_for()
        page.get_by_role("button", name="Check", exact=True).click()
        wait(page, "() => Object.keys(window.feeler.document.requirements[0].verdict.stale).length === 0")
        page.get_by_text(said).wait_for(state="detached")
        page.locator("#picture").focus()
        page.keyboard.press("Alt+4")
        page.locator(".line .stale", has_text="earlier revision").wait_for()
        assert troubles(page) == []
        page.close()
