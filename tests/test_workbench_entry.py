"""What a person types in fields of the page, and how it is shown: ranges, small figures, long names, the focus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from browser import SCHEMES, document, opened, picture, program, settled, wait

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance(pixels: np.ndarray) -> np.ndarray:
    """Relative luminance as of WCAG."""
    share = pixels / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4) @ LUMINANCE


def test_what_is_seen_through_is_seen_in_light_and_dark(context: Any, stand: Path) -> None:
    """Parts that are out, too. The luminance of their faces to that of the background is at least 1.15 to 1."""
    with program(stand) as started:
        page = opened(context, started)
        page.locator("#picture").focus()
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            seen = []
            for key, state in (("x", "ghost"), ("h", "hidden")):
                for pressed in ("Control+a", key, "Escape"):
                    page.keyboard.press(pressed)
                wait(page, "state => window.feeler.document[state].length === 4", state)
                settled(page)
                seen.append(luminance(picture(page)) + 0.05)
            page.keyboard.press("Alt+h")
            wait(page, "() => window.feeler.document.hidden.length + window.feeler.document.ghost.length === 0")
            contrast = np.maximum(*seen) / np.minimum(*seen)
            assert (contrast > 1.15).mean() > 0.15, (scheme, "parts that are out differ from the background")


def figure(page: Any, label: str) -> Any:
    return page.locator(f'.figure:has(.figure-label:text-is("{label}")) input')


def typed(field: Any, text: str) -> None:
    field.fill(text)
    field.press("Enter")


def test_a_length_that_cannot_be_is_told_at_its_field(context: Any, stand: Path) -> None:
    """In the unit of the page, without words of the protocol, and it stays to be mended."""
    with program(stand) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        for summary in page.locator("summary").all():
            summary.click()
        page.get_by_role("button", name="Add", exact=True).click()
        told = page.locator(".field-error")
        for label in ("Least distance", "Clearance", "Contact"):
            field = figure(page, label)
            for wrong in ("1000000000", "-1", "1001 m"):
                typed(field, wrong)
                assert told.inner_text() == "Type a length from 0 to 1000000 mm"
                assert field.input_value() == wrong and field.get_attribute("aria-invalid") == "true"
            typed(field, "abc")
            assert told.inner_text() == "Type a length such as 5, 2.5 mm or 3/8 in"
            # A valid length keeps all its digits, also a small one.
            typed(field, "0.0005")
            told.wait_for(state="detached")
            wait(page, "field => field.value === '0.0005'", field.element_handle())
            typed(field, "1/8 in")
            wait(page, "field => field.value === '3.175'", field.element_handle())
        assert page.locator(".notice.error").count() == 0
        kept = document(page)
        assert kept["requirements"][0]["gap"] == kept["clash"]["clearance"] == kept["clash"]["contact"] == 0.003175
        # Arrow keys stop at the least length; Escape restores the last valid one.
        field = figure(page, "Clearance")
        for _ in range(5):
            field.press("ArrowDown")
        assert field.input_value() == "0"
        wait(page, "() => window.feeler.document.clash.clearance === 0")
        typed(field, "abc")
        field.press("Escape")
        told.wait_for(state="detached")
        assert field.input_value() == "0"


# What the server says waits while `isHeld`.
HELD = """(() => {
    const waiting = [];
    window.release = () => { window.isHeld = false; for (const go of waiting.splice(0)) go(); };
    window.WebSocket = class extends WebSocket {
        constructor(...words) {
            super(...words);
            this.addEventListener("message", event => {
                if (!window.isHeld) return;
                event.stopImmediatePropagation();
                waiting.push(() => this.dispatchEvent(new MessageEvent("message", { data: event.data })));
            });
        }
    };
})()"""


def test_no_step_of_a_figure_is_lost_while_the_server_has_not_answered(context: Any, stand: Path, cube: Path) -> None:
    """Each counts from what the field shows, which is what was wanted last; a refused change is taken back."""
    context.add_init_script(HELD)
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)

        def stepped(field: Any, presses: int, shown: str) -> None:
            page.evaluate("() => { window.isHeld = true; }")
            for _ in range(presses):
                field.press("ArrowUp")
            assert field.input_value() == shown
            page.evaluate("() => window.release()")

        page.keyboard.press("Alt+6")
        page.locator("summary", has_text="Clearance, contact, rules").click()
        clearance = figure(page, "Clearance")
        before = 1e3 * document(page)["clash"]["clearance"]
        stepped(clearance, 4, f"{before + 4:g}")
        wait(page, "least => Math.abs(window.feeler.document.clash.clearance - least) < 1e-9", (before + 4) / 1e3)
        # What is typed, and not entered yet, counts.
        clearance.fill("7")
        stepped(clearance, 2, "9")
        wait(page, "() => Math.abs(window.feeler.document.clash.clearance - 0.009) < 1e-9")
        # Another change of it, as by undo, is seen.
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        wait(page, "field => field.value === '8'", clearance.element_handle())

        # Two faces of the section box, one right after the other: neither takes the other back.
        page.keyboard.press("b")
        wait(page, "() => window.feeler.document.section_box !== null")
        box = document(page)["section_box"]
        page.evaluate("() => { window.isHeld = true; }")
        for label in ("X from", "Y to"):
            figure(page, label).press("ArrowUp")
            figure(page, label).press("ArrowUp")
        page.evaluate("() => window.release()")
        wait(page, "x => Math.abs(window.feeler.document.section_box.lower[0] - x) < 1e-9", box["lower"][0] + 2e-3)
        wait(page, "y => Math.abs(window.feeler.document.section_box.upper[1] - y) < 1e-9", box["upper"][1] + 2e-3)

        # The hand, along two axes.
        page.keyboard.press("Alt+1")
        pose = np.reshape(page.evaluate("() => [...window.feeler.pose]"), (4, 4))
        page.evaluate("() => { window.isHeld = true; }")
        for axis in ("X", "Y"):
            for _ in range(3):
                figure(page, axis).first.press("ArrowUp")
        page.evaluate("() => window.release()")
        for at in (3, 7):
            there = [at, pose.ravel()[at] + 3e-3]
            wait(page, "([at, there]) => Math.abs(window.feeler.pose[at] - there) < 1e-9", there)


def test_what_was_told_of_a_rule_goes_once_it_is_right(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        for summary in page.locator("summary").all():
            summary.click()
        rules = page.get_by_label("Rules", exact=True)
        told = page.locator(".field-error")
        rules.fill("[[exclude")
        rules.blur()
        told.wait_for()
        assert "TOML" in told.inner_text() and page.locator(".notice.error").count() == 0
        rules.fill('[[exclude]]\nname = "ours"\na = "pump"\nb = "plate"\n')
        rules.blur()
        told.wait_for(state="detached")
        # A rule with a name that exists raises a notice, which disappears as well.
        typed(figure(page, "Clearance"), "2")
        page.get_by_role("button", name="Check clashes").click()
        page.locator(".finding", has_text="left").first.click()
        page.get_by_role("button", name="Ignore like this").click()
        form = page.get_by_role("form", name="Ignore like this")
        name = form.get_by_label("Name of the rule")
        assert name.input_value() in ("left on pump", "pump on left")
        notice = page.locator(".notice.error")
        typed(name, "ours")
        notice.wait_for()
        typed(name, "theirs")
        notice.wait_for(state="detached")
        wait(page, "() => 'theirs' in window.feeler.document.findings.hidden")


def test_long_names_are_whole_on_hover(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.locator("summary", has_text="Clearances that must hold").click()
        page.get_by_role("button", name="Add", exact=True).click()
        name = page.get_by_label("Name of the requirement")
        long = "the hose of the second pump keeps clear of the manifold and of its heat shield"
        typed(name, long)
        wait(page, "long => window.feeler.document.requirements[0].name === long", long)
        assert name.get_attribute("title") == long
        page.keyboard.press("Alt+4")
        page.locator("#panel").get_by_role("button", name="Picture and viewpoint").click()
        seen = page.get_by_role("list", name="Viewpoints").locator(".name")
        seen.wait_for()
        assert seen.get_attribute("title") == document(page)["viewpoints"][0]["name"]


def test_in_a_narrow_window_the_focus_goes_to_the_panel_that_was_asked_for(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        page.set_viewport_size({"width": 834, "height": 700})
        page.locator("#picture").focus()
        page.keyboard.press("Alt+6")
        page.locator(".drawer").wait_for()
        assert page.evaluate("() => document.activeElement.id") == "tab-findings"
