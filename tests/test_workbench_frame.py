"""The page's frame in a real Chromium: drawers, touch, the palette, files that are opened, covers, the selection."""

from __future__ import annotations

import base64
import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from browser import (
    SCHEMES,
    SLOW_MS,
    access_troubles,
    document,
    keep,
    needs_axe,
    opened,
    program,
    ready,
    settled,
    troubles,
    wait,
)

from feeler.cli.projects import Work
from feeler.cli.view import _Opening
from feeler.workbench.net.server import Server
from feeler.workbench.session.session import Session

WIDTHS = (320, 420, 760, 999)


def bar(page: Any, name: str) -> Any:
    return page.locator("#bar").get_by_role("button", name=name)


def command(page: Any, words: str) -> None:
    """Types into the palette, and Enter."""
    page.keyboard.press("Control+k")
    page.get_by_role("combobox", name="Search commands").fill(words)
    page.keyboard.press("Enter")
    page.locator(".dialog.palette").wait_for(state="detached")


def picture_width(page: Any) -> float:
    return float(page.locator("#picture").bounding_box()["width"])


def focused(page: Any) -> str:
    """The accessible name of what has the focus."""
    found: str = page.evaluate(
        "() => document.activeElement.ariaLabel ?? document.activeElement.innerText ?? document.activeElement.id"
    )
    return found


def test_narrow_windows_have_drawers(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+2")
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 700})
            page.wait_for_function("() => document.querySelector('.page').classList.contains('narrow')")
            assert picture_width(page) == width, "the picture has all the room"
            assert page.evaluate("() => document.documentElement.scrollWidth") <= width
            for button in page.locator("#bar button:visible").all():
                box = button.bounding_box()
                assert box["x"] >= 0 and box["x"] + box["width"] <= width, (width, button.get_attribute("aria-label"))
            # One at a time, the focus goes in, and Esc brings it back.
            bar(page, "Open the part tree").click()
            wait(page, "() => document.activeElement.id === 'search'")
            bar(page, "Open the panels").click()
            assert page.locator("#tree").count() == 0
            assert page.locator("#panels").bounding_box()["width"] <= width
            wait(page, "() => document.activeElement.getAttribute('role') === 'tab'")
            keep(page.screenshot(), f"drawer_{width}.png")
            page.keyboard.press("Escape")
            assert page.locator(".drawer").count() == 0
            assert focused(page) == "Open the panels"
            # Commands open the drawer that they are about.
            command(page, "Panel: Measures")
            page.locator("#panels").get_by_text("Viewpoints").wait_for()
            page.locator(".drawer").get_by_role("button", name="Close: Panels").click()
            assert page.locator(".drawer").count() == 0
            command(page, "search parts")
            wait(page, "() => document.activeElement.id === 'search'")
            page.keyboard.press("Escape")
            page.locator(".drawer").wait_for(state="detached")
        # As it was, when there is room again; nothing is cut off.
        for width in (1280, 1000):
            page.set_viewport_size({"width": width, "height": 700})
            page.locator("#tree").wait_for()
            edge = page.locator("#tree").bounding_box()["width"]
            for inside in (page.locator("#search"), page.get_by_role("button", name="Show all")):
                box = inside.bounding_box()
                assert box["x"] + box["width"] <= edge
        page.locator("#panels").wait_for()
        assert page.locator(".drawer").count() == 0
        # The open panel is kept over a reload.
        page.reload()
        ready(page)
        assert page.locator("#tab-measures").get_attribute("aria-selected") == "true"
        assert troubles(page) == []


def test_at_twice_the_size_everything_is_reached(browser: Any, stand: Path, cube: Path) -> None:
    # 200 % zoom of 1280 by 720 is a window of 640 by 360 with twice the pixels.
    context = browser.new_context(viewport={"width": 640, "height": 360}, device_scale_factor=2)
    context.set_default_timeout(SLOW_MS)
    with contextlib.closing(context), program(stand, "--tool", cube) as started:
        page = opened(context, started)
        bar(page, "More").click()
        page.get_by_role("menuitem", name="Settings").click()
        page.get_by_role("button", name="Close").click()
        assert focused(page) == "More"
        bar(page, "Open the panels").click()
        last = page.locator("#panel").get_by_label("Drag in steps (Ctrl: the other way)")
        last.scroll_into_view_if_needed()
        last.check()
        assert page.locator("#picture").bounding_box()["height"] > 250
        assert troubles(page) == []


SIZES = [(999, 700), (700, 900), (640, 360), (390, 844)]
COVER = """point => {
    const { left, top } = document.getElementById("picture").getBoundingClientRect();
    const [x, y] = window.feeler.pixel(point);
    const hit = document.elementFromPoint(left + x, top + y);
    return hit?.closest("main.picture") ? null : hit?.outerHTML ?? "outside";
}"""


def test_a_finding_is_seen_beside_its_panel_in_a_narrow_window(context: Any, stand: Path) -> None:
    """At 200 % zoom and on a phone, too."""
    with program(stand) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.get_by_role("button", name="Check clashes").click()
        page.locator(".finding", has_text="left is 1 mm from pump").wait_for()
        for notice in page.locator(".notice").all():
            notice.get_by_role("button").click()
        for width, height in SIZES:
            page.set_viewport_size({"width": width, "height": height})
            wait(page, "() => document.querySelector('.page').classList.contains('narrow')")
            page.locator("#picture").focus()
            page.keyboard.press("Alt+6")
            page.locator(".drawer .finding", has_text="left is 1 mm from pump").click()
            settled(page)
            # Both parts touch the gap there; and most of the pump is in sight.
            for point in ((-0.0795, 0.0, 0.03), (-0.0795, 0.0, 0.07), (-0.05, 0.0, 0.081)):
                assert page.evaluate(COVER, point) is None, (width, height, point)
            keep(page.screenshot(), f"finding_{width}.png")
            assert page.evaluate("() => document.documentElement.scrollWidth") <= width
            # The look ends, and the drawer.
            while page.locator(".drawer").count() > 0:
                page.keyboard.press("Escape")


@pytest.fixture
def phone(browser: Any) -> Iterator[Any]:
    made = browser.new_context(
        viewport={"width": 412, "height": 800}, has_touch=True, is_mobile=True, reduced_motion="reduce"
    )
    made.set_default_timeout(SLOW_MS)
    yield made
    made.close()


def pixel(page: Any, point: tuple[float, float, float]) -> tuple[float, float]:
    area = page.locator("#picture").bounding_box()
    x, y = page.evaluate("point => window.feeler.pixel(point)", list(point))
    return area["x"] + x, area["y"] + y


def test_a_long_press_opens_the_menu_of_a_part(phone: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(phone, started)
        settled(page)
        x, y = pixel(page, (-0.1, -0.05, 0.15))
        touches = page.context.new_cdp_session(page)

        def touch(kind: str, *points: tuple[float, float]) -> None:
            listed = [{"x": px, "y": py} for px, py in points]
            touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": listed})

        # A short touch selects, a long one opens the menu, one that moves turns the view.
        touch("touchStart", (x, y))
        page.wait_for_timeout(700)
        menu = page.get_by_role("menu")
        menu.wait_for()
        touch("touchEnd")
        assert [each.inner_text() for each in menu.locator(".row-name").all()][:4] == [
            *("Hide", "Isolate", "Ghost", "Grip"),
        ]
        for item in menu.get_by_role("menuitem").all():
            assert item.bounding_box()["height"] >= 44
        menu.get_by_role("menuitem", name="Hide").tap()
        wait(page, "() => window.feeler.document.hidden.length === 1")
        before = page.evaluate("() => JSON.stringify(window.feeler.pixel([0, 0, 0]))")
        touch("touchStart", (200, 400))
        for step in range(1, 8):
            touch("touchMove", (200 + 12 * step, 400))
        page.wait_for_timeout(700)
        touch("touchEnd")
        assert page.get_by_role("menu").count() == 0
        assert page.evaluate("() => JSON.stringify(window.feeler.pixel([0, 0, 0]))") != before
        # Fingers have targets of 44 pixels: in the bar, the drawers and the tree.
        bar(page, "Open the part tree").tap()
        small = """() => [...document.querySelectorAll("button, select, [role=treeitem], .choice label")]
            .filter(each => each.checkVisibility() && !each.closest("[role=menu]"))
            .map(each => [each.ariaLabel ?? each.innerText, each.getBoundingClientRect()])
            .filter(([, box]) => box.height > 0 && (box.height < 43.5 || box.width < 30))
            .map(([name, box]) => `${name}: ${box.width} x ${box.height}`)"""
        assert page.evaluate(small) == []
        bar(page, "Open the panels").tap()
        assert page.evaluate(small) == []
        keep(page.screenshot(), "phone.png")
        assert troubles(page) == []


def test_the_palette_runs_what_was_typed(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        for mode in ("pass", "glide", "stop"):
            command(page, f"contact: {mode}")
            wait(page, "mode => window.feeler.document.mode === mode", mode)
        page.get_by_role("treeitem", name="pump").click()
        command(page, "transparent")
        wait(page, "() => window.feeler.document.ghost.length === 1")
        # Labels say what would be done now.
        page.keyboard.press("Control+k")
        page.get_by_role("combobox", name="Search commands").fill("solid")
        assert page.locator(".palette-option .row-name").first.inner_text() == "Solid"
        page.keyboard.press("Enter")
        wait(page, "() => window.feeler.document.ghost.length === 0")
        page.keyboard.press("Control+k")
        page.get_by_role("combobox", name="Search commands").fill("pumpx 7")
        page.get_by_text("No command has these words").wait_for()
        page.get_by_role("button", name="Search the parts for").click()
        wait(page, "() => document.querySelector('#search').value === 'pumpx 7'")
        page.locator("#search").fill("")
        assert troubles(page) == []


def test_labels_follow_the_state(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.get_by_role("treeitem", name="pump").click()
        tools = page.locator(".tree-tools")
        page.keyboard.press("h")
        tools.get_by_role("button", name="Show", exact=True).click()
        tools.get_by_role("button", name="Hide", exact=True).wait_for()
        page.keyboard.press("Shift+h")
        tools.get_by_role("button", name="Show the others again").wait_for()
        # Also with nothing selected.
        page.locator("#picture").focus()
        page.keyboard.press("Escape")
        page.keyboard.press("Shift+h")
        wait(page, "() => !window.feeler.document.isolated && window.feeler.document.hidden.length === 0")
        # The menu by the keyboard alone.
        page.get_by_role("treeitem", name="pump").click()
        page.keyboard.press("Shift+F10")
        assert page.get_by_role("menuitem").first.inner_text().startswith("Hide")
        page.keyboard.press("Enter")
        wait(page, "() => window.feeler.document.hidden.length === 1")
        page.keyboard.press("Shift+F10")
        assert page.get_by_role("menuitem").first.inner_text().startswith("Show")
        page.keyboard.press("Escape")
        # Everything hidden says so, with the way out.
        command(page, "hide all")
        page.get_by_text("All 4 parts are hidden.").wait_for()
        page.locator(".banner").get_by_role("button", name="Show all").click()
        wait(page, "() => window.feeler.document.hidden.length === 0")
        assert page.locator(".banner").count() == 0
        command(page, "Show lengths in inches")
        wait(page, "() => window.feeler.document.unit === 'in'")
        assert troubles(page) == []


def test_what_is_selected(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        page.locator("#search").fill("p")
        page.get_by_role("treeitem", name="pump").click()
        facts = page.locator(".properties")
        facts.get_by_text("closed").wait_for()
        text = facts.inner_text()
        for words in ("pump", "158 × 80 × 60 mm", "12", "758.4 cm³", "538.4 cm²"):
            assert words in text, (words, text)
        page.get_by_role("treeitem", name="left").click(modifiers=["Control"])
        facts.get_by_text("1 mm", exact=True).wait_for()
        facts.get_by_role("button", name="Add as a measure").click()
        wait(page, "() => window.feeler.document.measures.length === 1")
        assert document(page)["measures"][0]["is_exact"]
        keep(page.screenshot(), "selection.png")
        page.get_by_role("treeitem", name="right").click(modifiers=["Control"])
        facts.get_by_text("3 parts").wait_for()
        page.locator("#picture").focus()
        page.keyboard.press("Escape")
        assert facts.count() == 0
        assert troubles(page) == []


DROP = """([name, text]) => {
    const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    const files = new DataTransfer();
    files.items.add(new File([bytes], name));
    for (const type of ["dragenter", "dragover", "drop"]) {
        document.body.dispatchEvent(new DragEvent(type, {bubbles: true, cancelable: true, dataTransfer: files}));
    }
}"""


def drop(page: Any, name: str, data: bytes) -> None:
    page.evaluate(DROP, [name, base64.b64encode(data).decode()])


def choose(page: Any, path: Path) -> None:
    """Opens a file by its key. A browser cancels a chooser before it is told to hand them over: press again."""
    choosers: list[Any] = []
    page.on("filechooser", lambda chooser: choosers.append(chooser))
    for tick in range(SLOW_MS // 100):
        if choosers:
            break
        if tick % 100 == 0:
            page.keyboard.press("Control+o")
        page.wait_for_timeout(100)
    choosers[0].set_files(path)


def block(size: float) -> bytes:
    made: bytes = trimesh.creation.box((size,) * 3).export(file_type="stl")
    return made


def test_the_first_start_and_a_file_that_is_dropped(context: Any, tmp_path: Path) -> None:
    with program() as started:
        page = opened(context, started)
        card = page.get_by_role("region", name="Three questions to begin with")
        card.wait_for()
        keep(page.screenshot(), "first_run.png")
        card.get_by_role("button", name="Does the starter come out?").click()
        page.locator(".properties").get_by_text("6 parts").wait_for()
        card.get_by_role("button", name="Which tool undoes this bolt?").click()
        # The bolt on its cover; F has it alone.
        distance = "() => Math.hypot(...[0, 1, 2].map(k => feeler.camera.position[k] - feeler.camera.target[k]))"
        around = page.evaluate(distance)
        page.locator("#picture").focus()
        page.keyboard.press("f")
        assert around > 2 * page.evaluate(distance)
        page.locator(".properties").get_by_text("bolt_1").first.wait_for()
        # A file of the wrong unit is opened, is told, and is corrected.
        drop(page, "big block.stl", block(743_000.0))
        page.get_by_role("heading", name="big block.stl").wait_for()
        page.wait_for_function("() => window.feeler.document.mockup?.parts === 1 && !window.feeler.document.loading")
        assert document(page)["tool"] is None and card.count() == 0
        settled(page)
        page.reload()
        ready(page)
        bar(page, "1 doubt").click()
        dialog = page.get_by_role("dialog")
        assert "743 m" in dialog.inner_text()
        keep(page.screenshot(), "doubts.png")
        dialog.get_by_label("Read in millimetres").select_option("in")
        dialog.get_by_role("button", name="Read again").click()
        page.wait_for_function("() => window.feeler.document.doubts.some(each => each.includes('18'))")
        # What was done is asked about before it ends.
        page.wait_for_function("() => window.feeler.document.mockup && !window.feeler.document.loading")
        command(page, "picture and viewpoint")
        wait(page, "() => window.feeler.document.viewpoints.length === 1")
        drop(page, "other.stl", block(20.0))
        page.get_by_role("dialog").get_by_role("button", name="Keep the present one").click()
        assert document(page)["mockup"]["name"] == "big block.stl"
        drop(page, "other.stl", block(20.0))
        page.get_by_role("dialog").get_by_role("button", name="Open", exact=True).click()
        page.get_by_role("heading", name="other.stl").wait_for()
        # What feeler cannot read stays outside; what it could not read leaves the present one.
        drop(page, "notes.txt", b"hello")
        page.get_by_text("notes.txt is in no format that feeler reads").wait_for()
        drop(page, "bad.stl", b"<b>nonsense</b>")
        page.locator(".notice.error", has_text="bad.stl").wait_for()
        assert document(page)["mockup"]["name"] == "other.stl"
        path = tmp_path / "chosen.stl"
        path.write_bytes(block(30.0))
        choose(page, path)
        page.get_by_role("heading", name="chosen.stl").wait_for()
        command(page, "open a sample")
        page.get_by_role("dialog").get_by_role("button", name="differential").click()
        page.wait_for_function("() => window.feeler.document.mockup?.name === 'differential'")
        assert troubles(page) == []


def test_a_file_is_refused_until_the_first_mock_up_is_there(context: Any, tmp_path: Path) -> None:
    path = tmp_path / "chosen.stl"
    path.write_bytes(block(30.0))
    go_on = threading.Event()
    with Session() as session, Server(session) as server:
        opening = _Opening(session, Work(["sample:differential:10000"]))
        session.openings.begin(lambda: go_on.wait() and opening._run())
        session.openings.offer(opening.again)
        page = context.new_page()
        page.goto(server.url)
        page.get_by_text("starting").wait_for()
        choose(page, path)
        refused = page.get_by_text("A mock-up is being opened")
        refused.wait_for()
        go_on.set()
        ready(page)
        assert document(page)["mockup"]["name"] == "differential"
        refused.wait_for(state="detached")
        choose(page, path)
        page.get_by_role("heading", name="chosen.stl").wait_for()
        page.close()


def test_a_start_that_failed_offers_another_file(context: Any, tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_text("<b>nonsense</b>")
    with program(tmp_path / "bad.stl") as started:
        page = context.new_page()
        page.goto(started.url)
        page.get_by_text("The mock-up could not be opened").wait_for()
        keep(page.screenshot(), "failed.png")
        with page.expect_file_chooser() as chooser:
            page.get_by_role("alert").get_by_role("button", name="Open a file").click()
        path = tmp_path / "good.stl"
        path.write_bytes(block(30.0))
        chooser.value.set_files(path)
        ready(page)
        assert document(page)["mockup"]["name"] == "good.stl"


def test_covers_say_why(context: Any, stand: Path) -> None:
    with program(stand) as started:
        pages = [opened(context, started) for _ in range(4)]
        fifth = context.new_page()
        fifth.goto(started.url)
        fifth.get_by_role("heading", name="Too many pages are open").wait_for()
        pages.pop().close()
        fifth.get_by_role("button", name="Try again").click()
        ready(fifth)
        stranger = context.new_page()
        stranger.goto(started.url.split("#")[0] + "#t=wrong")
        stranger.get_by_role("heading", name="This page has no access").wait_for()
        started.interrupt()
        fifth.get_by_text("The connection to the engine is lost").wait_for()
        fifth.get_by_text("feeler view has ended.").wait_for()
        keep(fifth.screenshot(), "ended.png")


def test_names_are_isolated_and_cut_in_the_middle(context: Any, tmp_path: Path) -> None:
    import feeler
    from feeler.io import write_glb

    names = ["a_" + "very_" * 30 + "long_name_7", "\u202edesrever", "<b>bold</b>"]
    box = trimesh.creation.box((0.1,) * 3)
    made = feeler.Mockup(
        np.concatenate([box.vertices + np.array((0.2 * k, 0.0, 0.0)) for k in range(3)]),
        np.concatenate([box.faces + 8 * k for k in range(3)]),
        np.repeat(np.arange(3), 12),
        names,
    )
    write_glb(tmp_path / "names.glb", made)
    with program(tmp_path / "names.glb") as started:
        page = opened(context, started)
        rows = page.get_by_role("treeitem")
        cut = rows.filter(has_text="long_name_7")
        head, tail = cut.locator(".name-head"), cut.locator(".name-tail")
        assert tail.inner_text() == "ng_name_7"
        assert head.evaluate("each => each.scrollWidth > each.clientWidth"), "the middle is cut"
        assert tail.evaluate("each => each.scrollWidth <= each.clientWidth")
        assert names[0] in cut.locator(".name").get_attribute("title")
        turned = rows.filter(has_text="desrever")
        # The override ends with the name: it begins where the others do.
        lefts = [row.locator(".name").bounding_box()["x"] for row in (cut, turned)]
        assert lefts[0] == pytest.approx(lefts[1], abs=1)
        assert page.locator("b").count() == 0
        assert troubles(page) == []


@needs_axe
def test_axe_finds_nothing_in_drawers_dialogs_and_menus(context: Any, cube: Path) -> None:
    with program("--tool", cube) as started:
        page = opened(context, started)

        def check(what: str) -> None:
            assert access_troubles(page, SCHEMES) == [], what

        page.get_by_role("region", name="Three questions to begin with").wait_for()
        page.get_by_role("button", name="Which tool undoes this bolt?").click()
        page.locator(".properties").get_by_text("closed").wait_for()
        check("first run and selection")
        page.keyboard.press("Shift+F10")
        check("menu")
        page.keyboard.press("Escape")
        for words in ("open a sample", "settings", "correct the unit"):
            command(page, words)
            check(words)
            page.keyboard.press("Escape")
        page.keyboard.press("Control+k")
        check("palette")
        page.get_by_role("combobox", name="Search commands").fill("nothing of this")
        check("palette without a match")
        page.keyboard.press("Escape")
        command(page, "hide all")
        page.locator(".banner").wait_for()
        check("everything hidden")
        page.set_viewport_size({"width": 412, "height": 800})
        for name in ("Open the part tree", "Open the panels"):
            bar(page, name).click()
            check(name)
            page.keyboard.press("Escape")
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            keep(page.screenshot(), f"narrow_{scheme}.png")
