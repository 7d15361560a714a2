"""Attributes and repeated parts in the page, in a real Chromium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from browser import keep, opened, program, troubles, wait
from loading import instances

import feeler

HTML = '<img src=x onerror="window.hacked = 1">'
LONG = "a long text of an attribute, which is cut in the middle: " * 10 + "its end"


def test_parts_are_found_by_attributes_and_shown_with_them(context: Any, tmp_path: Path) -> None:
    tool = feeler.sample_tool("wrench")
    nodes = [
        {
            "name": f"bolt_{number}",
            "translation": [0.1 * number, 0.0, 0.0],
            "rotation": [0.0, 0.6, 0.0, 0.8] if number % 2 else [0.0, 0.0, 0.0, 1.0],
            "extras": {"grade": f"grade {number % 4}", "note": LONG, HTML: HTML},
        }
        for number in range(40)
    ]
    path = instances(tmp_path / "rig.glb", nodes, materials=[{"name": "Steel"}], mesh=(tool.vertices, tool.faces))
    with program(path) as started:
        page = opened(context, started)
        assert page.evaluate("() => window.feeler.triangles") == 40 * tool.triangle_count
        search = page.locator("#search")
        search.fill('grade:"grade 3" bolt_1')
        wait(page, "() => document.querySelector('.tree-count').textContent.startsWith('3 of 40')")
        search.press("Enter")
        wait(page, "() => document.querySelector('.properties')?.textContent.startsWith('3 parts')")
        search.fill("bolt_12")
        wait(page, "() => document.querySelector('.tree-count').textContent.startsWith('1 of 40')")
        search.press("Enter")
        facts = page.locator(".properties .facts")
        facts.get_by_text("Steel", exact=True).wait_for()
        assert facts.get_by_text("grade 0", exact=True).count() == 1
        long = facts.locator(f"[title^='{LONG[:40]}']")
        assert long.get_attribute("title") == LONG
        assert long.bounding_box()["width"] < page.locator(".properties").bounding_box()["width"]
        assert facts.locator("img").count() == 0 and page.evaluate("() => window.hacked") is None
        assert facts.get_by_title(HTML).count() == 2, "its name and its value"
        keep(page.screenshot(), "attributes.png")
        search.fill("material:brass")
        wait(page, "() => document.querySelector('.tree-count').textContent.startsWith('0 of 40')")
        assert troubles(page) == []
