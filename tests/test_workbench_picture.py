"""The picture as people use it: views, projection, the tool in sight, labels, contact. In a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import HALF_TOOL_M, held_at, keep, move, opened, program, ready, settled, troubles, wait

FRONT, RIGHT = (0, 1, 0), (-1, 0, 0)
LABELS = """() => [...document.querySelectorAll('.labels .mark')]
    .filter(each => each.style.visibility !== 'hidden')
    .map(each => [each.textContent, each.getBoundingClientRect()])
    .map(([text, box]) => [text, box.left, box.top, box.right, box.bottom])"""


def camera(page: Any) -> dict[str, Any]:
    found: dict[str, Any] = page.evaluate("() => window.feeler.camera")
    return found


def forward(page: Any) -> np.ndarray:
    seen = camera(page)
    along = np.subtract(seen["target"], seen["position"])
    return np.asarray(along / np.linalg.norm(along))


def area(page: Any, selector: str) -> tuple[float, float, float, float]:
    box = page.locator(selector).bounding_box()
    return box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]


def overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def on_screen(page: Any, point: tuple[float, float, float]) -> tuple[float, float]:
    left, top, _, _ = area(page, "#picture")
    x, y = page.evaluate("point => window.feeler.pixel(point)", list(point))
    return left + x, top + y


def tool_place(page: Any) -> tuple[float, float, float]:
    pose = np.reshape(page.evaluate("() => window.feeler.pose"), (4, 4))
    x, y, z = (float(value) for value in pose[:3, 3])
    return x, y, z


def test_the_tool_is_seen_at_the_start_and_its_handles_stand_beside_it(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        wait(page, "() => window.feeler.state !== null")
        settled(page)
        assert page.evaluate("() => window.feeler.state.is_free && window.feeler.touched.length === 0")
        x, y, z = tool_place(page)
        corners = [
            on_screen(page, (x + i * HALF_TOOL_M, y + j * HALF_TOOL_M, z + k * HALF_TOOL_M))
            for i in (-1, 1)
            for j in (-1, 1)
            for k in (-1, 1)
        ]
        left, top, right, bottom = area(page, "#picture")
        assert all(left < u < right and top < v < bottom for u, v in corners), "all of it is in the picture"
        tool = (*np.min(corners, axis=0), *np.max(corners, axis=0))
        # The handles stand where the tool is until its picture has come.
        beside = """([left, top, right, bottom]) => {
            const box = document.querySelector(".gizmo").getBoundingClientRect();
            const x = (box.left + box.right) / 2, y = (box.top + box.bottom) / 2;
            return !(left < x && x < right && top < y && y < bottom);
        }"""
        wait(page, beside, [float(each) for each in tool])
        gizmo = area(page, ".gizmo")
        assert left <= gizmo[0] and gizmo[2] <= right and top <= gizmo[1] and gizmo[3] <= bottom, "not cut by the frame"
        keep(page.screenshot(), "start.png")
        # Its arrow, dragged there, moves the tool: up, as the screen has it.
        page.locator("#picture").focus()
        page.keyboard.press("1")
        settled(page)
        gizmo = area(page, ".gizmo")
        middle = (gizmo[0] + gizmo[2]) / 2, (gizmo[1] + gizmo[3]) / 2
        page.mouse.move(middle[0], middle[1] - 45)
        page.mouse.down()
        for step in range(1, 9):
            page.mouse.move(middle[0], middle[1] - 45 - 5 * step)
        page.mouse.up()
        wait(page, "z => window.feeler.document.pose[11] > z + 0.005", z)
        after = tool_place(page)
        assert after[:2] == pytest.approx((x, y), abs=1e-6)
        assert troubles(page) == []


def test_the_cube_turns_the_view_by_pointer_and_by_keys(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        cube = page.locator(".view-cube")
        cube.click(position={"x": 38, "y": 62})  # the front, as the first view has it
        settled(page)
        assert forward(page) == pytest.approx(FRONT, abs=1e-6)
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowRight")
        settled(page)
        assert forward(page) == pytest.approx(RIGHT, abs=1e-6)
        assert "right" in cube.get_attribute("aria-label")
        page.keyboard.press("ArrowUp")
        assert forward(page)[2] < -0.5, "from above"
        cube.drag_to(cube, source_position={"x": 52, "y": 52}, target_position={"x": 70, "y": 60})
        turned = forward(page)
        cube.focus()
        page.keyboard.press("Enter")
        settled(page)
        assert not np.allclose(forward(page), turned), "it is aligned"
        page.get_by_role("button", name="Home view").click()
        assert forward(page)[0] < -0.3 and forward(page)[1] > 0.3 and forward(page)[2] < -0.3
        keep(page.screenshot(), "cube.png")
        assert troubles(page) == []


def test_parallel_projection_is_remembered_and_measures_in_the_picture(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        assert page.locator(".scale-bar").inner_text().startswith("≈")
        page.locator("#picture").focus()
        page.keyboard.press("1")
        page.keyboard.press("o")
        settled(page)
        assert camera(page)["is_parallel"] is True
        bar = page.locator(".scale-bar")
        text, unit = bar.inner_text().split()
        assert unit == "mm"
        # As long as a part of that length, before and behind the middle.
        width = page.evaluate("() => document.querySelector('.scale-bar').getBoundingClientRect().width")
        for depth in (-0.1, 0.1):
            left, right = (on_screen(page, (x, depth, 0.0))[0] for x in (0.0, float(text) * 1e-3))
            assert right - left == pytest.approx(width, abs=0.6)
        keep(page.screenshot(), "parallel.png")
        page.reload()
        ready(page)
        assert camera(page)["is_parallel"] is True
        # A picture for keeping is of that projection, and so is the viewpoint.
        page.evaluate("() => window.feeler.shot(64, 36)")
        with page.expect_download():
            page.keyboard.press("k")
        wait(page, "() => window.feeler.document.viewpoints.length === 1")
        assert page.evaluate("() => window.feeler.document.viewpoints[0].camera.is_parallel") is True
        page.locator("#picture").focus()
        page.keyboard.press("o")
        settled(page)
        assert camera(page)["is_parallel"] is False
        assert troubles(page) == []


def test_an_arrow_leads_to_a_tool_out_of_the_picture(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.locator("#picture").focus()
        arrow = page.locator(".tool-arrow")
        assert not arrow.is_visible()
        for _ in range(12):
            page.keyboard.press("Shift+ArrowRight")
        settled(page)
        assert arrow.is_visible() and page.locator(".gizmo").is_hidden()
        keep(page.screenshot(), "arrow.png")
        arrow.click()
        settled(page)
        assert not arrow.is_visible()
        left, top, right, bottom = area(page, "#picture")
        assert on_screen(page, tool_place(page)) == pytest.approx(((left + right) / 2, (top + bottom) / 2), abs=2)
        # F frames it with the mock-up.
        move(page, 0.0, 0.0, 1.0)
        settled(page)
        page.locator("#picture").focus()
        page.keyboard.press("f")
        settled(page)
        assert not arrow.is_visible()
        x, y = on_screen(page, (0.0, 0.0, 1.0))
        assert left < x < right and top < y < bottom
        assert troubles(page) == []


def test_labels_name_parts_and_cover_neither_one_another_nor_the_gizmo(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        # Between the posts, over the pump.
        move(page, 0.0, 0.0, 0.3)
        move(page, 0.05, 0.0, 0.12)
        page.locator("#picture").focus()
        page.keyboard.press("Shift+F")
        settled(page)
        wait(page, "() => document.querySelectorAll('.labels .mark').length >= 2")
        settled(page)
        labels = page.evaluate(LABELS)
        assert {text.split()[-1] for text, *_ in labels} >= {"pump", "right"}
        gizmo = area(page, ".gizmo")
        inner = (gizmo[0] + 20, gizmo[1] + 20, gizmo[2] - 20, gizmo[3] - 20)
        for k, (text, *box) in enumerate(labels):
            assert not overlap(tuple(box), inner), f"{text} is under the gizmo"
            for other, *place in labels[k + 1 :]:
                assert not overlap(tuple(box), tuple(place)), f"{text} covers {other}"
        assert page.locator(".heat-legend").is_visible()
        assert page.locator(".heat-legend").inner_text() == "0 – 20 mm from the tool"
        keep(page.screenshot(), "labels.png")
        # What is typed stands at the tool.
        page.keyboard.press("g")
        page.keyboard.press("x")
        page.keyboard.type("-5")
        wait(page, "() => document.querySelector('.mark-hand')?.textContent === 'Move X -5 mm'")
        page.keyboard.press("Escape")
        wait(page, "() => !document.querySelector('.mark-hand')")
        assert troubles(page) == []


def test_contact_is_told_while_it_is_pushed_and_while_the_tool_rests(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        move(page, 0.0, 0.0, 0.3)
        move(page, 0.0, 0.0, 0.15)
        page.locator("#picture").focus()
        page.keyboard.press("1")
        page.keyboard.press("Shift+F")
        settled(page)
        page.keyboard.press("g")
        page.keyboard.press("z")
        page.keyboard.type("-100")
        wait(page, "() => [...document.querySelectorAll('.mark')].some(each => each.textContent.endsWith('held back'))")
        keep(page.screenshot(), "held_back.png")
        page.keyboard.press("Enter")
        wait(page, "() => window.feeler.document.pose[11] < 0.11")
        wait(page, "() => document.querySelector('.contact-facts').textContent.includes('touches pump')")
        wait(page, "() => [...document.querySelectorAll('.mark')].some(each => each.textContent === 'touches pump')")
        assert not page.evaluate("() => window.feeler.state.blocked")
        settled(page)
        assert "touches pump" in page.locator(".contact-facts").inner_text()
        keep(page.screenshot(), "rests.png")
        assert troubles(page) == []


def test_the_view_glides_and_ends_with_any_input(browser: Any, stand: Path, cube: Path) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, reduced_motion="no-preference")
    context.set_default_timeout(60_000)
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.locator("#picture").focus()
        before = camera(page)
        # Scripts see where it leads at once; the picture is whole only there.
        page.keyboard.press("1")
        assert forward(page) == pytest.approx(FRONT, abs=1e-6) and camera(page) != before
        settled(page)
        page.keyboard.press("4")
        left, top, right, bottom = area(page, "#picture")
        x, y = left + 0.3 * (right - left), bottom - 0.2 * (bottom - top)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 30, y, steps=4)
        page.mouse.up()
        turned = forward(page)
        assert turned[0] < -0.9 and not np.allclose(turned, RIGHT), "turned from the right, wherever it had come to"
        assert page.evaluate("pose => window.feeler.moveTo(pose)", held_at(0.0, 0.0, 0.4))[11] == pytest.approx(0.4)
        assert troubles(page) == []
    context.close()
