"""Two people on one workbench, each with a page in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import SLOW_MS, access_troubles, differing, keep, move, opened, picture, program, settled, troubles, wait

OTHER = "() => window.feeler.people.seen[0]"
NASTY = "<img src=x onerror=alert(1)>"


@pytest.fixture
def other_context(browser: Any) -> Iterator[Any]:
    made = browser.new_context(
        viewport={"width": 1280, "height": 720}, color_scheme="light", reduced_motion="reduce", bypass_csp=True
    )
    made.set_default_timeout(SLOW_MS)
    yield made
    made.close()


def named(page: Any, name: str) -> None:
    """A name, as people set it: in the dialog behind the strip."""
    page.locator(".people-strip").click()
    field = page.get_by_label("Your name")
    field.fill(name)
    field.press("Enter")
    page.get_by_role("button", name="Close", exact=True).click()


def names(page: Any) -> list[str]:
    found: list[str] = page.evaluate("() => window.feeler.people.people.map(each => each.name)")
    return found


def test_two_people_see_each_other_and_take_the_tool_by_turns(
    context: Any, other_context: Any, root: Path, stand: Path, cube: Path
) -> None:
    with program(stand, "--tool", cube) as started:
        ann = opened(context, started)
        assert ann.locator(".people-strip").count() == 0, "alone, nobody is shown"
        ben = opened(other_context, started)
        wait(ann, "() => window.feeler.people.people.length === 2")
        named(ann, "Ann")
        named(ben, NASTY)
        wait(ann, "name => window.feeler.people.people[1].name === name", NASTY)
        wait(ben, "() => window.feeler.people.people[0].name === 'Ann'")
        assert ben.get_by_role("button", name=f"People: Ann, {NASTY} (you)").count() == 1

        # What one selects has an outline for the other, and where one points is marked by the name.
        settled(ben)
        before = picture(ben)
        ann.keyboard.press("/")
        ann.keyboard.type("pump")
        ann.locator("[role=treeitem]", has_text="pump").last.click()
        wait(ben, f"() => ({OTHER})()?.selection.length === 1")
        settled(ben)
        assert differing(picture(ben), before) > 0.002
        assert ben.evaluate("() => document.querySelectorAll('.tree [aria-selected=true]').length") == 0
        at = ann.evaluate("() => window.feeler.pixel([0, 0.04, 0.051])")
        box = ann.locator("#picture").bounding_box()
        ann.mouse.move(box["x"] + at[0], box["y"] + at[1])
        wait(ben, f"() => ({OTHER})()?.point !== null")
        mark = ben.locator(".labels .mark", has_text="Ann")
        mark.wait_for()
        assert "mark-person-0" in (mark.get_attribute("class") or "")
        keep(ben.screenshot(), "people.png")

        # Ann moves the tool; Ben cannot, and asks for it.
        reached = move(ann, 0.0, 0.0, 0.4)
        wait(ben, "() => window.feeler.people.turn.person === window.feeler.people.people[0].id")
        assert "Ann has the tool" in ben.evaluate(
            "() => window.feeler.moveTo(window.feeler.pose).then(() => '', error => error.message)"
        )
        ben.locator("#picture").focus()
        ben.keyboard.press("g")
        bar = ben.locator(".turn-bar")
        assert "Ann has the tool." in bar.inner_text()
        assert access_troubles(ben) == []
        bar.get_by_role("button", name="Ask for it").click()
        asked = ann.locator(".turn-bar")
        asked.wait_for()
        assert NASTY in asked.inner_text() and ann.locator("img").count() == 0
        keep(ann.screenshot(), "people-asked.png")
        asked.get_by_role("button", name="Give it").click()
        wait(ben, "() => window.feeler.people.turn.person === window.feeler.people.you")
        np.testing.assert_allclose(move(ben, 0.0, 0.0, 0.5)[:3, 3] - reached[:3, 3], [0.0, 0.0, 0.1], atol=1e-5)

        # Ben looks where Ann looks.
        camera = ann.evaluate("() => window.feeler.camera")
        ann.keyboard.press("1")
        wait(ben, f"before => ({OTHER})()?.camera.position[0] !== before", camera["position"][0])
        ben.locator(".people-strip").click()
        assert access_troubles(ben) == []
        ben.get_by_role("button", name="Look where Ann looks").click()
        wanted = ann.evaluate("() => window.feeler.camera")
        np.testing.assert_allclose(ben.evaluate("() => window.feeler.camera")["position"], wanted["position"])

        # A page that is gone is seen no more.
        ann.close()
        wait(ben, "() => window.feeler.people.people.length === 1 && window.feeler.people.seen.length === 0")
        assert ben.locator(".people-strip").count() == 0
        assert names(ben) == [NASTY]
        assert troubles(ben) == []
