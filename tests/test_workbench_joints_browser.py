"""Joints as people move them: the panel, keys, the pointer and a dropped file, in a real Chromium."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import access_troubles, differing, document, keep, opened, picture, program, settled, sized, troubles, wait

import feeler
from feeler.io import write_glb

TEXT = """
[[joint]]
name = "door"
kind = "revolute"
child = ["door", "knob"]
axis = [0, 0, 1]
point_m = [-0.1, 0, 0]

[[joint]]
name = "bolt"
kind = "prismatic"
parent = "door"
child = "bolt"
axis = [1, 0, 0]
limits_m = [-0.01, 0.02]
"""
KNOWN = "() => window.feeler.document.joint_ranges.every(each => each.state === 'done')"
DROP = """text => {
    const data = new DataTransfer();
    data.items.add(new File([text], "door.toml"));
    for (const type of ["dragenter", "dragover", "drop"])
        document.querySelector("#picture").dispatchEvent(
            new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
}"""


@pytest.fixture(scope="module")
def cupboard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A door about the z axis with a knob and a bolt, a post that stops it, and a sill below that it passes."""
    shapes = {
        "door": sized((0.2, 0.01, 0.2), (0.01, 0.0, 0.0)),
        "knob": sized((0.02, 0.02, 0.02), (0.09, -0.02, 0.0)),
        "bolt": sized((0.04, 0.01, 0.01), (0.085, 0.012, 0.06)),
        "post": sized((0.02, 0.02, 0.2), (-0.1, 0.12, 0.0)),
        "sill": sized((0.3, 0.3, 0.01), (0.0, 0.0, -0.11)),
    }
    mockup = feeler.Mockup(
        np.concatenate([points for points, _ in shapes.values()]),
        np.concatenate([faces + 8 * i for i, (_, faces) in enumerate(shapes.values())]),
        np.repeat(np.arange(len(shapes)), 12),
        list(shapes),
    )
    path = tmp_path_factory.mktemp("cupboard") / "cupboard.glb"
    write_glb(path, mockup)
    return path


def value(page: Any, name: str = "door") -> float:
    return float(document(page)["mechanism"]["values"][name])


def upper(page: Any) -> float:
    return float(next(each["upper"] for each in document(page)["joint_ranges"] if each["name"] == "door"))


def test_a_dropped_mechanism_moves_by_slider_keys_and_pointer(context: Any, cupboard: Path, root: Path) -> None:
    with program(cupboard) as started:
        page = opened(context, started)
        assert page.get_by_role("tab", name="Joints").count() == 0
        page.evaluate(DROP, TEXT)
        panel = page.locator("#panel")
        panel.get_by_role("slider", name="door").wait_for()
        wait(page, KNOWN)
        slider = panel.get_by_role("slider", name="door")
        stop = upper(page)
        assert 1.0 < stop < 2.0 and f"above {math.degrees(stop):.2f}°" in panel.inner_text()
        settled(page)
        at_home = picture(page)
        keep(page.screenshot(), "joints.png")

        # Keys go by degrees, add up to one step of undo, and say where they are in words.
        slider.focus()
        for _ in range(3):
            page.keyboard.press("ArrowRight")
        page.keyboard.press("Shift+ArrowRight")
        wait(page, "() => window.feeler.document.mechanism.values.door > 0")
        assert value(page) == pytest.approx(math.radians(3.1))
        assert slider.get_attribute("aria-valuetext") == "3.1°"
        page.keyboard.press("End")
        wait(page, "stop => Math.abs(window.feeler.document.mechanism.values.door - stop) < 1e-7", stop)
        settled(page)
        assert differing(picture(page), at_home) > 0.01
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.document.mechanism.values.door === 0")

        # The thumb, dragged past the stop, stays there.
        box = slider.bounding_box()
        span = [float(slider.get_attribute(each)) for each in ("min", "max")]
        x = box["x"] + 8 + (box["width"] - 16) * (0.0 - span[0]) / (span[1] - span[0])
        page.mouse.move(x, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.mouse.move(x + 10, box["y"] + box["height"] / 2, steps=3)
        page.mouse.move(box["x"] + box["width"] + 20, box["y"] + box["height"] / 2, steps=3)
        page.get_by_text("meets post", exact=True).wait_for()
        assert value(page) == 0.0, "it is shown, and not done"
        page.mouse.up()
        wait(page, "() => window.feeler.document.mechanism.values.door > 0.5")
        assert value(page) == pytest.approx(stop, abs=1e-9)

        # What is typed goes as far as contact lets it; the worst position is a ghost.
        figure = panel.get_by_role("textbox", name="door, angle")
        figure.fill("170")
        figure.press("Enter")
        wait(page, "stop => Math.abs(window.feeler.document.mechanism.values.door - stop) < 1e-9", stop)
        assert "stopped here" in panel.inner_text()
        figure.fill("0")
        figure.press("Enter")
        wait(page, "() => window.feeler.document.mechanism.values.door === 0")
        settled(page)
        before = picture(page)
        ghost = panel.get_by_role("listitem", name="door").get_by_role("button", pressed=False).last
        ghost.click()
        wait(page, "() => document.querySelector('.part-line[aria-pressed=true]') !== null")
        page.wait_for_timeout(300)
        settled(page)
        assert differing(picture(page), before) > 0.003
        keep(page.screenshot(), "joints_ghost.png")
        ghost = panel.get_by_role("listitem", name="door").get_by_role("button", pressed=True)
        ghost.click()

        # The part itself goes with the pointer, along its joint; Escape ends that.
        for key in ("Escape", None):
            page.mouse.move(700, 460)
            page.mouse.down()
            page.mouse.move(640, 440, steps=4)
            wait(page, "() => document.querySelector('.joint input[type=range]').ariaValueText !== '0°'")
            assert value(page) == 0.0, "it is shown, and not done"
            if key:
                page.keyboard.press(key)
                wait(page, "() => document.querySelector('.joint input[type=range]').ariaValueText === '0°'")
            page.mouse.up()
        wait(page, "() => window.feeler.document.mechanism.values.door !== 0")
        assert document(page)["mechanism"]["values"]["bolt"] == 0.0
        panel.get_by_role("button", name="Keep this position").click()
        wait(page, "() => window.feeler.document.sequence.length === 1")
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.document.mechanism.values.door === 0")

        assert access_troubles(page) == []
        assert troubles(page) == []
