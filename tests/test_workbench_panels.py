"""What people do by the panels, the handles in the picture and the keyboard alone, in a real Chromium."""

from __future__ import annotations

import csv
import json
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from browser import (
    CAST_M,
    HALF_TOOL_M,
    differing,
    document,
    keep,
    move,
    opened,
    picture,
    program,
    replayed_program,
    settled,
    troubles,
    wait,
)
from test_workbench_frame import drop

import feeler

PUMP_TOP_M, POST_GAP_M = 0.081, 0.16
FRONT, TOP, CORNER = "1", "5", "7"


def press(page: Any, *keys: str) -> None:
    """Keys of the picture."""
    page.locator("#picture").focus()
    for key in keys:
        page.keyboard.press(key)


def middle(page: Any) -> tuple[float, float]:
    area = page.locator("#picture").bounding_box()
    return area["x"] + 0.5 * area["width"], area["y"] + 0.5 * area["height"]


def pixel(page: Any, point: tuple[float, float, float]) -> tuple[float, float]:
    """Where a world point lies on the screen."""
    area = page.locator("#picture").bounding_box()
    x, y = page.evaluate("point => window.feeler.pixel(point)", list(point))
    return area["x"] + x, area["y"] + y


def arrow(page: Any) -> tuple[float, float]:
    """The middle of the arrow of the only cut."""
    settled(page)
    box = page.locator(".cut-arrow").bounding_box()
    return box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]


def test_a_cut_is_dragged_by_its_arrow_and_then_outlined(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, CORNER)
        page.keyboard.press("Alt+3")
        for _ in range(2):
            page.get_by_role("button", name="Across X").click()
            wait(page, "() => window.feeler.document.sections.length === 1")
        wait(page, "() => document.querySelectorAll('.cut-arrow').length === 1")
        whole = picture(page)
        x, y = arrow(page)
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(1, 21):
            page.mouse.move(x + 3 * step, y)
        # The picture follows before the server knows.
        assert document(page)["sections"][0]["offset"] == pytest.approx(0.0, abs=1e-9)
        assert differing(picture(page), whole) > 0.01
        keep(page.screenshot(), "cut_dragged.png")
        dragged = picture(page)
        page.mouse.up()
        page.mouse.move(x, y + 250)
        wait(page, "() => Math.abs(window.feeler.document.sections[0].offset) > 0.01")
        offset = document(page)["sections"][0]["offset"]
        new = arrow(page)
        assert np.hypot(new[0] - x, new[1] - y) == pytest.approx(60, abs=30), "the arrow goes with the pointer"
        # One drag is one step of undo.
        press(page, "Control+z")
        wait(page, "() => Math.abs(window.feeler.document.sections[0].offset) < 1e-9")
        press(page, "Control+y")
        wait(page, "at => window.feeler.document.sections[0].offset === at", offset)
        # Then the engine's exact outline comes over it.
        deadline = time.monotonic() + 60.0
        while differing(picture(page), dragged) < 0.0008:
            assert time.monotonic() < deadline, "no outline came"
        keep(page.screenshot(), "cut_outlined.png")
        assert troubles(page) == []


def test_a_section_box_is_made_by_a_key_and_dragged_and_a_face_is_cut_along(
    context: Any, stand: Path, cube: Path
) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, CORNER)
        whole = picture(page)
        page.mouse.click(*pixel(page, (0.0, -0.04, 0.05)))
        page.locator("[role=treeitem][aria-selected=true]", has_text="pump").wait_for()
        press(page, "b")
        wait(page, "() => window.feeler.document.section_box?.is_on")
        wait(page, "() => document.querySelectorAll('.cut-arrow').length === 6")
        settled(page)
        keep(page.screenshot(), "section_box.png")
        boxed = picture(page)
        assert differing(boxed, whole) > 0.01, "what is beside the pump is cut away"
        before = document(page)["section_box"]
        # The upper face, down into the pump: what it cuts is filled.
        top = page.locator(".cut-arrow[data-cut='-6']").bounding_box()
        x, y = top["x"] + 0.5 * top["width"], top["y"] + 0.5 * top["height"]
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(1, 16):
            page.mouse.move(x, y + 2 * step)
        assert document(page)["section_box"] == before, "the picture follows before the server knows"
        page.mouse.up()
        wait(page, "top => window.feeler.document.section_box.upper[2] < top - 0.005", before["upper"][2])
        after = document(page)["section_box"]
        assert after["lower"] == before["lower"] and after["upper"][:2] == before["upper"][:2]
        keep(page.screenshot(), "section_box_dragged.png")
        # Typed in the panel, switched off by the key, and undone.
        page.get_by_label("X to").fill("20")
        press(page, "Enter")
        wait(page, "() => Math.abs(window.feeler.document.section_box.upper[0] - 0.02) < 1e-9")
        page.locator("#picture").focus()
        press(page, "b")
        wait(page, "() => window.feeler.document.section_box.is_on === false")
        press(page, "Control+z", "Control+z", "Control+z")
        wait(page, "box => JSON.stringify(window.feeler.document.section_box) === JSON.stringify(box)", before)
        press(page, "Control+z")
        wait(page, "() => window.feeler.document.section_box === null")
        # A face: the next click cuts along its plane.
        press(page, FRONT)
        settled(page)
        page.get_by_role("button", name="Along a face").click()
        page.get_by_text("Click a face in the picture").wait_for()
        page.mouse.click(*pixel(page, (0.03, 0.0, 0.05)))
        wait(page, "() => window.feeler.document.sections.length === 1")
        section = document(page)["sections"][0]
        assert section["normal"] == pytest.approx([0, 1, 0]) and section["offset"] == pytest.approx(-0.04)
        settled(page)
        keep(page.screenshot(), "cut_along_a_face.png")
        assert troubles(page) == []


def test_what_is_cut_away_is_neither_picked_nor_measured_nor_turned_about(
    context: Any, stand: Path, cube: Path
) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, FRONT, "s")
        wait(page, "() => window.feeler.document.sections.length === 1")
        section = document(page)["sections"][0]
        assert section["normal"] == [0, 1, 0] and section["offset"] == pytest.approx(0.0, abs=1e-9)
        # On the pump's front, which is cut away: the fill is seen in its place, 40 mm behind.
        x, y = pixel(page, (0.03, 0.0, 0.05))
        page.mouse.click(x, y)
        page.locator("[role=treeitem][aria-selected=true]", has_text="pump").wait_for()
        press(page, "Escape", "m")
        page.mouse.click(*pixel(page, (-0.03, 0.0, 0.05)))
        page.mouse.click(*pixel(page, (0.03, 0.0, 0.05)))
        wait(page, "() => window.feeler.document.measures.length === 1")
        ends = np.array(document(page)["measures"][0]["points"])
        assert ends[:, 1] == pytest.approx([0.0, 0.0], abs=1e-9), "measured on the cut"
        # A click near the pump's edge on the cut snaps to the outline, which no mesh has.
        page.mouse.click(*pixel(page, (-0.03, 0.0, PUMP_TOP_M - 0.001)))
        page.mouse.click(*pixel(page, (0.03, 0.0, PUMP_TOP_M - 0.001)))
        wait(page, "() => window.feeler.document.measures.length === 2")
        ends = np.array(document(page)["measures"][1]["points"])
        assert ends[:, 1] == pytest.approx([0.0, 0.0], abs=1e-9)
        assert ends[:, 2] == pytest.approx([PUMP_TOP_M] * 2, abs=1e-7)
        keep(page.screenshot(), "measured_on_a_cut.png")
        press(page, "Escape")
        # The view turns about the point on the cut: it stays where it is in the picture.
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(1, 11):
            page.mouse.move(x + 12 * step, y)
        page.mouse.up()
        turned = pixel(page, (0.03, 0.0, 0.05))
        assert np.hypot(turned[0] - x, turned[1] - y) < 1.5
        assert troubles(page) == []


def test_measures_of_known_values_by_the_panel(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, CORNER)
        page.keyboard.press("Alt+4")

        def measured(name: str, *points: tuple[float, float, float]) -> dict[str, Any]:
            count = len(document(page)["measures"])
            page.get_by_role("button", name=name, exact=True).click()
            for point in points:
                page.mouse.click(*pixel(page, point))
            wait(page, "n => window.feeler.document.measures.length === n", count + 1)
            page.get_by_role("button", name="End measuring").click()
            made: dict[str, Any] = document(page)["measures"][-1]
            return made

        up = page.evaluate("() => window.feeler.camera.position")
        sign = [1.0 if value > 0 else -1.0 for value in up]
        on_left, on_right = (-0.1, 0.05 * sign[1], 0.2), (0.1, 0.05 * sign[1], 0.2)
        parts = measured("Part to part", on_left, on_right)
        assert parts["value"] == pytest.approx(POST_GAP_M, abs=1e-7) and parts["is_exact"]
        ends = np.array(parts["points"])
        assert sorted(ends[:, 0]) == pytest.approx([-0.08, 0.08], abs=1e-7), "the two closest points"
        assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(parts["value"], abs=1e-12)
        angle = measured("Angle", on_left, (-0.1, 0.0, 0.221))
        assert angle["value"] == pytest.approx(np.pi / 2) and angle["unit"] == "rad" and angle["is_exact"]
        edge = measured("Edge", (-0.09, 0.05 * sign[1], 0.2205))
        assert edge["value"] == pytest.approx(0.04, abs=1e-7)
        shown = page.locator("[aria-label=Measures]").inner_text()
        assert "160" in shown and "90" in shown and "40" in shown
        keep(page.screenshot(), "measures.png")
        # The unit is obeyed by what stands there already.
        page.get_by_role("radiogroup", name="Unit of lengths").get_by_text("cm").click()
        wait(page, "() => document.querySelector('[aria-label=Measures]').innerText.includes('16 cm')")
        # Parts that are drawn apart have no distances.
        page.keyboard.press("Alt+3")
        page.locator("#panel input[aria-label=Explode]").fill("0.5")
        wait(page, "() => window.feeler.document.explode === 0.5")
        press(page, "m")
        page.mouse.click(*pixel(page, on_left))
        page.get_by_text("put the mock-up together").wait_for()
        assert troubles(page) == []


CLASHES = {
    "version": 1,
    "clashes": [
        {"id": "t", "a": "stand/pump", "b": "stand/plate", "verdict": "touching", "depth": 0.0, "gap": 0.0},
        {
            **{"id": "l", "a": "stand/pump", "b": "stand/posts/left", "verdict": "clash", "depth": 0.001},
            **{"point_a": [-0.079, 0.0, 0.05], "point_b": [-0.08, 0.0, 0.05], "group": "pump and posts"},
        },
        {
            **{"id": "r", "a": "stand/pump", "b": "stand/posts/right", "verdict": "clash", "depth": 0.004},
            **{"point_a": [0.079, 0.0, 0.05], "point_b": [0.08, 0.0, 0.05], "group": "pump and posts"},
        },
    ],
}


def stepped_through(page: Any) -> None:
    """The findings of `CLASHES`, from where they are open."""
    wait(page, "() => window.feeler.document.findings !== null")
    page.keyboard.press("Alt+6")
    cards = page.locator(".finding")
    cards.first.wait_for()
    # What only touches is hidden at first; the deepest comes first, as a sentence.
    assert cards.count() == 2
    assert "pump is 4 mm deep in right" in " ".join(cards.first.inner_text().split())
    start = picture(page)
    press(page, "n")
    page.locator(".finding[aria-current=true]", has_text="right").wait_for()
    wait(page, "() => Math.abs(window.feeler.camera.target[0] - 0.0795) < 1e-6")
    assert page.evaluate("() => window.feeler.camera.target") == pytest.approx([0.0795, 0.0, 0.05]), "the contact"
    settled(page)
    keep(page.screenshot(), "finding.png")
    assert differing(start, picture(page)) > 0.1
    assert document(page)["ghost"] == [], "only the picture is another"
    press(page, "n")
    page.locator(".finding[aria-current=true]", has_text="left").wait_for()
    wait(page, "() => Math.abs(window.feeler.camera.target[0] + 0.0795) < 1e-6")
    press(page, "p")
    page.locator(".finding[aria-current=true]", has_text="right").wait_for()
    page.get_by_label("Status of the finding").select_option("reviewed")
    wait(page, "() => window.feeler.document.findings.status.r === 'reviewed'")
    page.get_by_label("Hide contacts").uncheck()
    wait(page, "() => document.querySelectorAll('.finding').length === 3")
    # Next and previous go through what is shown.
    page.get_by_label("Filter findings").fill("reviewed")
    wait(page, "() => document.querySelectorAll('.finding').length === 1")
    press(page, "n", "n")
    assert page.locator(".finding[aria-current=true]", has_text="right").count() == 1


def test_findings_are_stepped_through(context: Any, stand: Path, tmp_path: Path) -> None:
    file = tmp_path / "clashes.json"
    file.write_text(json.dumps(CLASHES))
    with program(stand, "--findings", file) as started:
        page = opened(context, started)
        stepped_through(page)
        assert troubles(page) == []


def test_findings_are_opened_in_the_page(context: Any, stand: Path, tmp_path: Path) -> None:
    good, broken = tmp_path / "clashes.json", tmp_path / "broken.json"
    good.write_text(json.dumps(CLASHES))
    broken.write_text('{"rows": []}')
    with program(stand) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        for file in (broken, good):
            with page.expect_file_chooser() as chooser:
                page.locator("#panel").get_by_role("button", name="Open a file").click()
            chooser.value.set_files(file)
            if file == broken:
                page.get_by_role("alert").get_by_text("holds no list").wait_for()
        stepped_through(page)


def test_the_focus_stays_on_the_selected_tab(context: Any, stand: Path) -> None:
    """By arrows and by Alt with a digit, also from a tab that goes; from elsewhere the focus stays where it is."""
    focused = "() => document.activeElement?.id"
    with program(stand) as started:
        page = opened(context, started)
        page.get_by_role("tab", name="Pose").focus()
        for key, tab in (
            *(("Alt+3", "sections"), ("Alt+8", "task"), ("ArrowLeft", "findings"), ("Alt+7", "mechanism")),
            *(("Alt+2", "ask"), ("ArrowRight", "sections")),
        ):
            page.keyboard.press(key)
            page.locator(f"#tab-{tab}[aria-selected=true]").wait_for()
            assert page.evaluate(focused) == f"tab-{tab}", key
        page.locator("#picture").focus()
        page.keyboard.press("Alt+4")
        page.locator("#tab-measures[aria-selected=true]").wait_for()
        assert page.evaluate(focused) == "picture"


def test_what_the_page_cannot_open_is_told_as_what_it_is(context: Any, stand: Path, tmp_path: Path) -> None:
    project, some, none = tmp_path / "work.feelproj", tmp_path / "some.json", tmp_path / "none.json"
    project.write_bytes(b"SQLite format 3")
    (clash, *_) = CLASHES["clashes"]
    some.write_text(json.dumps({"clashes": [clash, {**clash, "id": "x", "b": "nope"}]}))
    none.write_text(json.dumps({"clashes": [{**clash, "a": "no2", "b": "nope"}]}))
    with program(stand) as started:
        page = opened(context, started)
        for file, told in (
            (project, "work.feelproj is a project: start feeler view work.feelproj to open it"),
            (none, "1 of 1 finding names parts that this mock-up lacks, such as 'no2'"),
            (some, "1 of 2 findings name parts that this mock-up lacks, such as 'nope'"),
        ):
            drop(page, file.name, file.read_bytes())
            page.locator(".notice", has_text=told).wait_for()


def test_a_tool_is_taken_and_given_back(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+1")
        choice = page.get_by_role("combobox", name="Tool")
        assert choice.locator("option").all_inner_texts() == ["none", "cube", "torque", "wrench", "square", "hand"]
        choice.select_option("wrench")
        wait(page, "() => window.feeler.document.tool.name === 'wrench'")
        # The page has its shape: it goes down until it stands on something.
        down = move(page, 0.0, 0.0, 0.0)
        wrench = feeler.sample_tool("wrench")
        assert not feeler.Scene(feeler.load_mockup(stand)).is_colliding(wrench, down)
        keep(page.screenshot(), "wrench.png")
        choice.select_option("none")
        page.get_by_text("The hand is empty.").wait_for()
        press(page, "Control+z")
        wait(page, "() => window.feeler.document.tool !== null && window.feeler.document.tool.name === 'wrench'")
        press(page, "Control+z")
        wait(page, "() => window.feeler.document.tool.name === 'cube'")
        assert troubles(page) == []


def test_settings_of_sound_touch_and_devices(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, "Control+,")
        page.get_by_label("Mock-up sounds like").select_option("rubber")
        wait(page, "() => window.feeler.document.material === 'rubber'")
        page.get_by_label("Rumble with the force").uncheck()
        page.get_by_label("Gamepad: rest of the sticks").fill("0.25")
        page.get_by_text("At full size").click()
        keep(page.screenshot(), "settings.png")
        page.reload()
        wait(page, "() => window.feeler && window.feeler.ready")
        press(page, "Control+,")
        assert page.get_by_label("Rumble at each contact").is_checked()
        assert not page.get_by_label("Rumble with the force").is_checked()
        assert page.get_by_label("Gamepad: rest of the sticks").input_value() == "0.25"
        assert page.get_by_label("At full size").is_checked()
        assert page.get_by_label("Mock-up sounds like").input_value() == "rubber"


def taken_out(page: Any) -> None:
    """The pump, straight up and aside: the first line of the sequence."""
    page.evaluate("() => window.feeler.grip('stand/pump')")
    wait(page, "() => window.feeler.document.gripped.length === 1 && window.feeler.pose !== null")
    x, y, z = np.reshape(page.evaluate("() => window.feeler.pose"), (4, 4))[:3, 3]
    move(page, x, y, z + 0.25)
    move(page, x + 0.3, y, z + 0.25)
    page.evaluate("() => window.feeler.release()")
    wait(page, "() => window.feeler.document.sequence.length === 1")


def downloaded(page: Any, name: str, folder: Path) -> Path:
    page.keyboard.press("Alt+5")
    with page.expect_download() as download:
        page.get_by_role("button", name=name).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_the_sequence_is_exported_and_holds_what_was_done(context: Any, stand: Path, tmp_path: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        taken_out(page)
        table = downloaded(page, "Sequence as CSV", tmp_path)
        (line,) = csv.DictReader(table.read_text(encoding="utf-8-sig").splitlines())
        assert line["step"] == "1" and line["parts"] == "stand/pump"
        assert float(line["way (mm)"]) == pytest.approx(550.0, rel=0.01)
        # A millimetre to the posts, and it stood a millimetre above the plate.
        assert float(line["least clearance (mm)"]) == pytest.approx(1.0, rel=0.01)
        text = downloaded(page, "Sequence as a page", tmp_path).read_text(encoding="utf-8")
        assert "stand/pump" in text and "<script" not in text
        film = downloaded(page, "Sequence as animated GLB", tmp_path)
        parts = feeler.load_mockup(film).part_names
        assert "pump" in parts and "left" in parts, "what moves, and what is near"
        body = trimesh.load(film)
        assert len(body.geometry) == len(parts)
        data = film.read_bytes()
        size = int.from_bytes(data[12:16], "little")
        (animation,) = json.loads(data[20 : 20 + size])["animations"]
        assert {channel["target"]["path"] for channel in animation["channels"]} >= {"translation"}
        assert troubles(page) == []


def test_one_html_file_shows_the_mockup_anywhere(context: Any, browser: Any, stand: Path, tmp_path: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        taken_out(page)
        press(page, CORNER)
        page.mouse.move(2, 2)
        page.wait_for_timeout(300)
        before = picture(page)
        page.reload()
        wait(page, "() => window.feeler && window.feeler.ready")
        page.mouse.move(2, 2)
        assert differing(picture(page), before) < 0.01, "where a part was put down, a reload finds it"
        file = downloaded(page, "One HTML file to send", tmp_path)
    assert file.stat().st_size < 2_000_000
    other = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="dark", reduced_motion="reduce")
    other.set_default_timeout(60_000)
    asked: list[str] = []
    other.on("request", lambda request: asked.append(request.url))
    try:
        alone = other.new_page()
        said: list[str] = []
        alone.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        alone.on("pageerror", lambda error: said.append(f"error: {error}"))
        alone.goto(file.as_uri())
        wait(alone, "() => window.feeler && window.feeler.ready")
        assert alone.evaluate("() => window.feeler.triangles") == feeler.load_mockup(stand).triangle_count
        alone.mouse.move(2, 2)
        keep(alone.screenshot(), "one_file.png")
        assert differing(picture(alone), before) < 0.01
        # What was taken out goes its way again, and ends where it was put down.
        alone.keyboard.press("Alt+5")
        end = document(alone)["moved"]["3"]
        alone.get_by_role("button", name=re.compile("^Replay ")).click()
        wait(alone, "() => window.feeler.document.replaying !== null")
        wait(alone, "() => window.feeler.document.replaying === null")
        assert document(alone)["moved"]["3"] == pytest.approx(end, abs=1e-9)
        # Measured by the picture's depth: near, and said to be only that.
        alone.locator("#picture").focus()
        alone.keyboard.press(FRONT)
        alone.keyboard.press("m")
        for x in (-0.1, 0.1):
            alone.mouse.click(*pixel(alone, (x, -0.05, 0.12)))
        wait(alone, "() => window.feeler.document.measures.length === 1")
        assert document(alone)["measures"][0]["value"] == pytest.approx(0.2, abs=0.002)
        alone.locator("[aria-label=Measures]").get_by_text("≈").wait_for()
        assert [line for line in said if line.startswith(("error", "warning"))] == []
        assert all(url.startswith(("file:", "blob:", "data:")) for url in asked)
    finally:
        other.close()


def test_a_record_is_replayed_in_the_page(context: Any, stand: Path, cube: Path, tmp_path: Path) -> None:
    record = tmp_path / "way.jsonl"
    with program(stand, "--tool", cube, "--record", record) as started:
        page = opened(context, started)
        move(page, 0.0, 0.0, 0.3)
        move(page, 0.0, 0.0, 0.05)
        page.wait_for_timeout(600)  # it rests there when it is replayed, too
        page.evaluate("() => window.feeler.grip('stand/posts/left')")
        page.evaluate("() => window.feeler.undo()")
        move(page, 0.0, 0.0, 0.3)
        assert started.interrupt() == 0
        page.close()
    with replayed_program(record, stand, "--tool", cube) as started:
        page = opened(context, started)
        page.get_by_text("way.jsonl can be replayed").wait_for()
        # What is shown meanwhile may be over before anybody looks.
        page.evaluate(
            """() => {
                window.shown = new Set();
                setInterval(() => window.feeler.touched.forEach((part) => window.shown.add(part)), 10);
            }"""
        )
        page.get_by_role("button", name="Replay", exact=True).click()
        wait(page, "() => window.shown.has('stand/pump')")
        keep(page.screenshot(), "replaying.png")
        page.get_by_text("The same hits to the last triangle").wait_for()
        keep(page.screenshot(), "replayed.png")
        height = page.evaluate("() => [document.scrollingElement.scrollHeight, innerHeight]")
        assert height[0] == height[1], "the page does not scroll as a whole"
        assert page.evaluate("() => window.feeler.pose[11]") == pytest.approx(0.3)
        # The timeline: back to the moment of the grip, forward by entries, by a click on the tightest place, and on.
        bar = page.get_by_role("region", name="Record")
        bar.get_by_text("2 entries").click()
        bar.get_by_role("button", name="Grip left").click()
        wait(page, "() => window.feeler.document.gripped.length === 1")
        bar.get_by_role("button", name="Next entry").click()
        wait(page, "() => window.feeler.document.gripped.length === 0")
        bar.get_by_role("button", name="Tightest").click()
        wait(page, "() => window.feeler.pose[11] < 0.2")
        keep(page.screenshot(), "record_scrubbed.png")
        slider = bar.get_by_role("slider", name="Place in the record")
        slider.press("Home")
        wait(page, "() => window.feeler.document.record.at === 0")
        bar.get_by_role("combobox", name="Speed").select_option("8")
        bar.get_by_role("button", name="Play the record").click()
        wait(page, "() => !window.feeler.document.record.is_playing && window.feeler.document.record.at > 1")
        assert page.evaluate("() => window.feeler.pose[11]") == pytest.approx(0.3)
        # From there on it is a workbench like any other.
        on_pump = PUMP_TOP_M + HALF_TOOL_M
        assert on_pump <= move(page, 0.0, 0.0, 0.05)[2, 3] < on_pump + CAST_M
        assert troubles(page) == []
    lines = record.read_text().splitlines()
    hit = next(i for i, line in enumerate(lines) if json.loads(line)["kind"] == "tick")
    entry = json.loads(lines[hit])
    entry["pose"][3] += 0.5
    lines[hit] = json.dumps(entry)
    record.write_text("\n".join(lines) + "\n")
    with replayed_program(record, stand, "--tool", cube) as started:
        page = opened(context, started)
        page.get_by_role("button", name="Replay", exact=True).click()
        page.get_by_text(f"It parts at entry {hit}: the hand comes elsewhere").wait_for()


def test_the_sequence_is_a_film(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        for part, x in (("stand/pump", 0.0), ("stand/posts/left", -0.3)):
            page.evaluate("part => window.feeler.grip(part)", part)
            start = page.evaluate("() => window.feeler.pose")
            start[3] += x
            start[11] += 0.4
            page.evaluate("pose => window.feeler.moveTo(pose)", start)
            page.evaluate("() => window.feeler.release()")
        press(page, "Alt+5")
        page.get_by_role("button", name="Show as a film").click()
        film = page.get_by_role("article", name="Film of the sequence")
        film.get_by_text("0:00.0 of").wait_for()
        settled(page)
        start = picture(page)
        keep(page.screenshot(), "film_of_the_sequence.png")
        film.get_by_role("button", name="Next entry").click()
        film.get_by_role("slider").press("ArrowRight")
        settled(page)
        assert differing(picture(page), start) > 0.01, "the pump is out"
        film.get_by_role("combobox", name="Speed").select_option("8")
        film.get_by_role("button", name="Play the sequence").click()
        film.get_by_role("button", name="Play the sequence").wait_for()
        settled(page)
        end = picture(page)
        film.get_by_role("button", name="End the film").click()
        settled(page)
        assert differing(picture(page), end) < 0.01, "the film ends where the parts lie"
        assert document(page)["moved"]["3"][11] == pytest.approx(0.4)
        assert troubles(page) == []


def test_the_keyboard_alone_takes_a_part_out(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        keys = page.keyboard
        keys.press("/")
        keys.type("pump")
        keys.press("Enter")
        wait(page, "() => document.querySelectorAll('[role=treeitem][aria-selected=true]').length > 0")
        keys.press("Escape")
        while not page.evaluate("() => document.activeElement.id === 'picture'"):
            keys.press("F6")
        keys.press("Shift+H")
        wait(page, "() => window.feeler.document.isolated")
        keys.press("Shift+H")
        wait(page, "() => !window.feeler.document.isolated")
        keys.press("e")
        wait(page, "() => window.feeler.document.gripped.length === 1 && window.feeler.pose !== null")
        start = page.evaluate("() => window.feeler.pose[11]")
        while "Move in the view" not in page.inner_text("body"):  # refused until the part's shape has come
            keys.press("g")
        for key in ("z", "3", "0", "0", "Enter"):
            keys.press(key)
        wait(page, "z => Math.abs(window.feeler.document.pose[11] - z) < 1e-6", start + 0.3)
        keys.press("e")
        wait(page, "() => window.feeler.document.sequence.length === 1")
        assert document(page)["moved"]["3"][11] == pytest.approx(0.3)
        while document(page)["sequence"] or document(page)["gripped"] or document(page)["moved"]:
            depth = page.evaluate("() => JSON.stringify(window.feeler.document)")
            keys.press("Control+z")
            wait(page, "before => JSON.stringify(window.feeler.document) !== before", depth)
        assert document(page)["moved"] == {} and document(page)["out"] == []
        # A movement has its keys in the tree, too, whose Enter otherwise selects.
        keys.press("/")
        keys.type("pump")
        keys.press("Enter")
        wait(page, "() => document.querySelectorAll('[role=treeitem][aria-selected=true]').length > 0")
        page.locator("[role=treeitem][aria-selected=true]").first.focus()
        keys.press("e")
        wait(page, "() => window.feeler.document.gripped.length === 1 && window.feeler.pose !== null")
        while "Move in the view" not in page.inner_text("body"):
            keys.press("g")
        for key in ("z", "2", "0", "0", "Enter"):
            keys.press(key)
        wait(page, "z => Math.abs(window.feeler.document.pose[11] - z) < 1e-6", start + 0.2)
        wait(page, "() => !document.body.innerText.includes('Move along')")
        assert page.evaluate("() => document.activeElement.getAttribute('role')") == "treeitem"
        keys.press("Escape")
        assert troubles(page) == []
