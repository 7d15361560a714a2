"""Keys faster than the link: what a person presses twice, or at once after something else, counts in that order."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from browser import differing, document, keep, opened, picture, program, settled, troubles, wait

PRESS = """async keys => {
    document.querySelector("#picture").focus();
    for (const key of keys) {
        const [name, ...modifiers] = key.split("+").reverse();
        const ctrlKey = modifiers.includes("Ctrl");
        document.activeElement.dispatchEvent(new KeyboardEvent("keydown", {key: name, ctrlKey, bubbles: true}));
    }
    // Whatever is waiting for a frame or an answer comes after this.
    for (let k = 0; k < 20; k++) await Promise.resolve();
    return document.activeElement.getAttribute("aria-label");
}"""


def press(page: Any, *keys: str) -> str:
    """Keys in one turn of the page, as under load; what has the focus before anything else happens."""
    focused: str = page.evaluate(PRESS, list(keys))
    return focused


def test_each_press_of_space_is_a_mode_further(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, " ", " ")
        wait(page, "() => window.feeler.document.mode === 'pass'")
        press(page, " ", " ", " ", "Ctrl+z")
        wait(page, "() => window.feeler.document.mode === 'glide'")
        press(page, "Ctrl+z", "Ctrl+z", "Ctrl+y")
        wait(page, "() => window.feeler.document.mode === 'stop'")
        assert troubles(page) == []


def test_keys_that_switch_something_do_so_at_each_press(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        press(page, "Ctrl+a", "h", "h", "x", "x", "x")
        wait(page, "() => window.feeler.document.ghost.length === 4")
        assert document(page)["hidden"] == []
        press(page, "s", "s", "s")
        wait(page, "() => window.feeler.document.sections.length === 1")
        wait(page, "() => window.feeler.document.sections[0].is_on")
        assert troubles(page) == []


def test_undo_at_once_after_a_drag_takes_the_drag_back(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        start = document(page)["pose"][11]
        page.evaluate("() => window.feeler.moveTo([1,0,0,0, 0,1,0,0, 0,0,1,0.3, 0,0,0,1])")
        page.locator("#picture").focus()
        page.keyboard.press("g")
        page.keyboard.press("z")
        page.keyboard.type("50")
        press(page, "Enter", "Ctrl+z")
        # The hand goes back to where it was put down before, and redo knows where it was.
        wait(page, "start => Math.abs(window.feeler.pose[11] - start) < 1e-9", start)
        press(page, "Ctrl+y")
        wait(page, "() => Math.abs(window.feeler.document.pose[11] - 0.35) < 1e-9")
        wait(page, "() => Math.abs(window.feeler.pose[11] - 0.35) < 1e-6")
        assert troubles(page) == []


def test_what_is_typed_after_ctrl_k_is_meant_for_the_palette(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        assert press(page, "Ctrl+k") == "Search commands"
        page.keyboard.type("isolate")
        assert page.locator(".palette-input").input_value() == "isolate"
        page.keyboard.press("Escape")
        page.keyboard.press("Control+b")
        page.locator("#tree").wait_for(state="detached")
        assert press(page, "/") == "Search parts", "the tree that was closed is there at once"
        assert troubles(page) == []


def test_a_look_at_findings_changes_no_document_and_is_left_as_it_was(
    context: Any, stand: Path, cube: Path, tmp_path: Path
) -> None:
    paths = ["stand/plate", "stand/posts/left", "stand/posts/right", "stand/pump"]
    plate, left, right, pump = range(4)
    clashes = [
        {"id": name, "a": paths[a], "b": paths[b], "depth": depth}
        for name, a, b, depth in (
            ("one", plate, left, 0.003),
            ("two", right, pump, 0.002),
            ("three", left, pump, 0.001),
        )
    ]
    file = tmp_path / "clashes.json"
    file.write_text(json.dumps({"version": 1, "clashes": clashes}))
    with program(stand, "--tool", cube, "--findings", file) as started:
        page = opened(context, started)
        page.get_by_label("Search parts").fill("pump")
        page.keyboard.press("Enter")
        press(page, "h", "Escape", "7")
        wait(page, "() => window.feeler.document.hidden.length === 1")
        settled(page)
        before, steps = picture(page), document(page)
        page.keyboard.press("Alt+6")
        page.locator(".finding").first.wait_for()
        press(page, "n", "n")
        page.locator(".finding[aria-current=true]", has_text="right").wait_for()
        page.get_by_role("button", name="Leave (Esc)").wait_for()
        settled(page)
        keep(page.screenshot(), "finding_of_a_hidden_part.png")
        assert differing(picture(page), before) > 0.05, "the hidden part is seen, too"
        press(page, "Escape")
        settled(page)
        press(page, "7")
        settled(page)
        assert differing(picture(page), before) < 0.002, "and hidden again"
        # Also where Esc comes before the look has begun.
        press(page, "n", "Escape")
        settled(page)
        press(page, "7")
        settled(page)
        assert differing(picture(page), before) < 0.002
        assert document(page) == steps
        press(page, "Ctrl+z")
        wait(page, "() => window.feeler.document.hidden.length === 0")
        assert troubles(page) == []
