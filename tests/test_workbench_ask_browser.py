"""Questions as people ask them: the page in a real Chromium, `feeler view` behind it."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

from browser import differing, document, keep, move, opened, picture, program, settled, troubles, wait
from test_workbench_cards import bolts, chest

from feeler.io import write_glb

DONE = "() => window.feeler.document.cards.length > 0 && window.feeler.document.cards.at(-1).state === 'done'"


def select(page: Any, words: str, row: str) -> None:
    page.keyboard.press("/")
    page.keyboard.type(words)
    page.locator("[role=treeitem]", has_text=row).last.click()
    page.locator("#picture").focus()


def far(page: Any) -> float:
    """From the camera to what it looks at, metres."""
    camera = page.evaluate("() => window.feeler.camera")
    return math.dist(camera["position"], camera["target"])


def test_a_part_is_asked_for_watched_taken_out_and_put_back(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        select(page, "pump", "pump")
        page.keyboard.press("q")
        wait(page, DONE)
        panel = page.locator("#panel")
        assert "Can pump come out?" in panel.inner_text()
        slider = panel.get_by_role("slider")
        slider.wait_for()
        page.mouse.move(2, 2)
        settled(page)
        at_home = picture(page)
        slider.fill("700")
        settled(page)
        assert differing(picture(page), at_home) > 0.005, "the film moves the part"
        assert document(page)["moved"] == {}, "in the picture alone"
        keep(page.screenshot(), "way.png")
        panel.get_by_role("button", name="Play the way").click()
        wait(page, "() => document.querySelector('#panel input[type=range]').value === '1000'")
        panel.get_by_role("button", name="Take it into the sequence").dblclick()
        wait(page, "() => window.feeler.document.sequence.length === 1")
        settled(page)
        assert troubles(page) == [], "a double click is one click"
        assert len(document(page)["out"]) == 1
        # What was asked is about the mock-up with the part: the card says that it is of before.
        page.get_by_role("tab", name="Ask", exact=True).click()
        assert "parts were moved since" in panel.inner_text()
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.document.out.length === 0")
        assert len(document(page)["cards"]) == 1 and "parts were moved since" not in panel.inner_text()
        panel.get_by_role("button", name="Remove: Can pump come out?").click()
        wait(page, "() => window.feeler.document.cards.length === 0")
        settled(page)
        assert troubles(page) == []


def test_a_line_says_what_its_newest_check_found(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        panel = page.locator("#panel")
        select(page, "pump", "pump")
        page.keyboard.press("q")
        wait(page, DONE)
        panel.locator(".gap-curve").wait_for()
        panel.get_by_role("button", name="Take it into the sequence").click()
        wait(page, "() => window.feeler.document.sequence.length === 1")
        facts = panel.get_by_role("list", name="Removals").locator("> li > p.note").first
        assert "1 mm least clearance" in facts.inner_text()
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.document.sequence.length === 0")
        # By hand, through a post.
        for _ in range(2):
            page.keyboard.press("Space")
        wait(page, "() => window.feeler.document.mode === 'pass'")
        select(page, "pump", "pump")
        page.keyboard.press("e")
        wait(page, "() => window.feeler.document.gripped.length === 1")
        x, y, z = (page.evaluate("() => window.feeler.pose")[k] for k in (3, 7, 11))
        move(page, x + 0.5, y, z)
        page.keyboard.press("e")
        wait(page, "() => window.feeler.document.sequence.length === 1")
        page.keyboard.press("Alt+5")
        assert "does not hold" not in facts.inner_text()
        panel.get_by_role("button", name="Check this way").click()
        panel.get_by_text("The way meets right").wait_for()
        assert "does not hold" in facts.inner_text() and "least clearance" not in facts.inner_text()
        assert troubles(page) == []


def test_steps_without_gaps_have_no_curve(context: Any, tmp_path: Path) -> None:
    write_glb(tmp_path / "chest.glb", chest())
    with program(tmp_path / "chest.glb") as started:
        page = opened(context, started)
        select(page, "block", "block")
        page.keyboard.press("Shift+Q")
        wait(page, DONE)
        panel = page.locator("#panel")
        panel.get_by_role("slider").wait_for()
        assert panel.get_by_role("list", name="Entries of all steps").get_by_role("listitem").count() == 2
        assert panel.locator("svg[role=img], .gap-curve").count() == 0
        keep(page.screenshot(), "order.png")
        assert troubles(page) == []


def test_the_room_that_a_part_needs_is_seen(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        select(page, "pump", "pump")
        settled(page)
        before = picture(page)
        page.get_by_role("tab", name="Ask", exact=True).click()
        page.get_by_role("button", name="What room does it need").first.click()
        wait(page, DONE)
        page.locator("#panel dl").wait_for()
        # The volume comes after the figures.
        end = time.monotonic() + 60.0
        while differing(picture(page), before) <= 0.01:
            assert time.monotonic() < end
            settled(page)
        assert "needs at most" in page.locator("#panel").inner_text()
        keep(page.screenshot(), "room.png")
        # A closed card shows nothing in the picture.
        page.locator("#panel li.question button[aria-expanded=true]").click()
        settled(page)
        assert differing(picture(page), before) < 0.005
        assert troubles(page) == []


def test_a_way_guides_the_hand_is_checked_and_shortened(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        select(page, "pump", "pump")
        page.keyboard.press("q")
        wait(page, DONE)
        panel = page.locator("#panel")
        panel.get_by_role("slider").wait_for()
        # The camera goes back until the whole way is in the picture.
        page.locator("#picture").focus()
        page.keyboard.press("f")
        near = far(page)
        panel.get_by_role("button", name="Show the whole way").click()
        assert far(page) > 1.2 * near
        # The way draws the hand while the hand holds its parts.
        panel.get_by_role("button", name="Guide my hand").click()
        wait(page, "() => window.feeler.document.guiding !== null")
        assert len(document(page)["gripped"]) == 1
        settled(page)
        assert panel.get_by_role("button", name="Stop guiding").is_visible()
        keep(page.screenshot(), "guide.png")
        page.locator("#picture").focus()
        page.keyboard.press("Escape")
        wait(page, "() => window.feeler.document.guiding === null")
        assert len(document(page)["gripped"]) == 1, "the parts stay in the hand"
        # Up, aside and back: the way of the hand is longer than it need be.
        x, y, z = (page.evaluate("() => window.feeler.pose")[k] for k in (3, 7, 11))
        for shift in ((0.0, 0.0, 0.5), (0.5, 0.0, 0.5), (0.0, 0.0, 0.5), (0.0, 0.0, 0.8)):
            move(page, x + shift[0], y + shift[1], z + shift[2])
        page.keyboard.press("e")
        wait(page, "() => window.feeler.document.sequence.length === 1")
        poses = len(document(page)["sequence"][0]["way"])
        page.keyboard.press("Alt+5")
        panel.get_by_role("button", name="Check this way").click()
        wait(page, DONE)
        panel.get_by_text("The way holds at and between").wait_for()
        # The picture has the part where it is, until the film is played; then where it was.
        panel.get_by_role("slider").wait_for()
        settled(page)
        out = picture(page)
        panel.get_by_role("slider").fill("1")
        settled(page)
        assert differing(picture(page), out) > 0.01
        panel.get_by_role("button", name="Does the way of pump hold?", exact=True).click()
        settled(page)
        assert differing(picture(page), out) < 0.01
        panel.get_by_role("button", name="Shorten it").click()
        panel.get_by_role("button", name="Use it").click()
        wait(page, "most => window.feeler.document.sequence[0].way.length < most", poses)
        keep(page.screenshot(), "line.png")
        assert troubles(page) == []


def test_the_catalogue_says_which_tool_reaches_each_bolt(context: Any, tmp_path: Path) -> None:
    """A row for each head, colours on the heads; a click draws the whole chain in its seat, with its swing."""
    write_glb(tmp_path / "bolted.glb", bolts())
    with program(tmp_path / "bolted.glb") as started:
        page = opened(context, started)
        settled(page)
        plain = picture(page)
        page.get_by_role("tab", name="Ask", exact=True).click()
        panel = page.locator("#panel")
        panel.get_by_role("button", name="Which tool reaches its bolts?").click()
        wait(page, DONE)
        assert document(page)["cards"][-1]["options"] == {"catalogue": True}
        rows = panel.locator(".reaches li")
        rows.first.wait_for()
        settled(page)
        coloured = picture(page)
        assert rows.count() == 2 and differing(coloured, plain) > 0.0005, "heads are coloured by the answer"
        text = rows.filter(has_text="bolt_free").inner_text()
        assert "hexagon 17 mm: socket 17 (10) + ratchet (10) swings 272°, 2 strokes a turn" in text
        assert "limited by: wall" in rows.filter(has_text="bolt_caught").inner_text()
        # From near the bolt, the camera goes back until the swing is in the picture.
        select(page, "bolt_free", "bolt_free")
        page.keyboard.press("f")
        near = far(page)
        rows.filter(has_text="bolt_free").get_by_role("button").click()
        assert far(page) > 2 * near
        assert page.evaluate("() => window.feeler.document.tool") is None, "the hand stays as it is"
        settled(page)
        ended = time.monotonic() + 60.0
        while differing(picture(page), coloured) <= 0.01:
            assert time.monotonic() < ended, "the chain is not drawn"
            settled(page)
        assert rows.filter(has_text="bolt_free").get_attribute("aria-current") == "true"
        keep(page.screenshot(), "catalogue_reach.png")
        # Asked again, the row is gone with its tool; the card stays.
        panel.get_by_role("button", name="Ask again").first.click()
        wait(page, DONE)
        rows.first.wait_for()
        assert panel.locator(".reaches li[aria-current=true]").count() == 0
        assert "Tools reach all 2 fasteners." in panel.inner_text() and troubles(page) == []
