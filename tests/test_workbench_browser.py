"""The workbench as people use it: `feeler view` and a real Chromium. Screenshots are kept in target/screenshots."""

from __future__ import annotations

import functools
import http.server
import subprocess
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import (
    CAST_M,
    HALF_TOOL_M,
    PROGRAM,
    SCHEMES,
    Program,
    access_troubles,
    differing,
    document,
    held_at,
    keep,
    move,
    needs_axe,
    opened,
    picture,
    program,
    ready,
    settled,
    troubles,
    wait,
)

import feeler


def test_the_engine_is_seen_and_nothing_is_asked_of_other_hosts(context: Any) -> None:
    asked: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    with program("sample:engine:100000", "--tool", "sample:wrench") as started:
        page = opened(context, started)
        mockup = feeler.sample("engine", 100_000)
        assert page.evaluate("() => window.feeler.triangles") == mockup.triangle_count
        shades = np.unique(picture(page).reshape(-1, 3) // 16, axis=0)
        assert len(shades) > 40, "an engine in light and shadow has many shades"
        keep(page.screenshot(), "engine.png")
        assert "#" not in page.url, "the token does not stay in the address"
        assert troubles(page) == []
        # Of the 10,000 rows that a tree may have, few are in the page.
        page.keyboard.press("/")
        page.keyboard.type("bolt")
        assert 0 < page.locator("[role=treeitem]").count() <= 80
        origin = started.url.split("/#")[0]
        assert asked and all(url.startswith((origin, "blob:", "data:")) for url in asked)
        assert started.interrupt() == 0


def test_search_isolate_and_back(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        whole = picture(page)
        page.keyboard.press("/")
        page.keyboard.type("pump")
        page.locator("[role=treeitem]", has_text="pump").click()
        page.locator("#picture").focus()
        page.keyboard.press("Shift+H")
        wait(page, "() => window.feeler.document.hidden.length === 3")
        assert document(page)["isolated"] and document(page)["hidden"] == [0, 1, 2]
        assert differing(picture(page), whole) > 0.02
        keep(page.screenshot(), "isolated.png")
        page.keyboard.press("Shift+H")
        wait(page, "() => window.feeler.document.hidden.length === 0")
        page.keyboard.press("Escape")
        page.mouse.move(2, 2)  # off the row, whose part is lit while the pointer is over it
        wait(page, "() => document.querySelectorAll('[role=treeitem][aria-selected=true]').length === 0")
        assert differing(picture(page), whole) < 0.01
        assert troubles(page) == []


def test_a_section_cuts_the_picture_and_is_undone(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        whole = picture(page)
        page.locator("#picture").focus()
        page.keyboard.press("s")
        wait(page, "() => window.feeler.document.sections.length === 1")
        cut = picture(page)
        assert differing(cut, whole) > 0.01
        keep(page.screenshot(), "section.png")
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.document.sections.length === 0")
        assert differing(picture(page), whole) < 0.01
        page.keyboard.press("Control+y")
        wait(page, "() => window.feeler.document.sections.length === 1")
        assert differing(picture(page), cut) < 0.01
        assert troubles(page) == []


def test_a_dragged_tool_stops_at_contact(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        move(page, 0.0, 0.0, 0.3)
        page.locator("#picture").focus()
        page.keyboard.press("1")  # from the front: down in the picture is down in the world
        page.keyboard.press("Shift+F")
        settled(page)
        area = page.locator("#picture").bounding_box()
        x, y = area["x"] + 0.5 * area["width"], area["y"] + 0.5 * area["height"]
        # On the tool, beside the middle of the gizmo.
        page.mouse.move(x + 9, y + 9)
        page.mouse.down()
        for step in range(1, 30):
            page.mouse.move(x + 9, y + 9 + 10 * step)
        wait(page, "() => window.feeler.touched.length > 0")
        keep(page.screenshot(), "contact.png")
        page.mouse.up()
        pose = np.reshape(page.evaluate("() => window.feeler.pose"), (4, 4))
        on_pump = 0.081 + HALF_TOOL_M
        assert on_pump <= pose[2, 3] < on_pump + CAST_M
        assert page.evaluate("() => window.feeler.touched") == ["stand/pump"]
        # Where it came to is where it was put down; undo takes it back to where that was before.
        wait(page, "() => window.feeler.document.pose[11] < 0.11")
        page.locator("#picture").focus()
        page.keyboard.press("Control+z")
        wait(page, "() => window.feeler.pose[11] > 0.24")
        assert troubles(page) == []


def test_modes_stop_glide_and_pass(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        move(page, 0.0, 0.0, 0.3)
        top = 0.081 + HALF_TOOL_M
        assert top <= move(page, 0.0, 0.0, 0.05)[2, 3] < top + CAST_M
        page.locator("#picture").focus()
        page.keyboard.press("Space")
        wait(page, "() => window.feeler.document.mode === 'glide'")
        move(page, 0.0, 0.0, 0.12)
        glided = move(page, 0.02, 0.0, 0.1)
        assert glided[2, 3] == pytest.approx(top, abs=1e-4) and glided[0, 3] == pytest.approx(0.02, abs=2e-4)
        wait(page, "() => window.feeler.force[2] > 0")
        page.keyboard.press("Space")
        wait(page, "() => window.feeler.document.mode === 'pass'")
        inside = move(page, 0.02, 0.0, 0.09)
        assert inside[2, 3] == pytest.approx(0.09, abs=1e-9)
        assert page.evaluate("() => window.feeler.touched") == ["stand/pump"]
        wait(page, "() => window.feeler.state.hit_count > 0 && window.feeler.state.depth > 0")
        assert page.evaluate("() => window.feeler.state.depth") == pytest.approx(top - 0.09, abs=1e-5)
        wait(page, "() => /[0-9] mm deep/.test(document.querySelector('.contact-facts').textContent)")
        keep(page.screenshot(), "pass.png")
        assert troubles(page) == []


def test_a_part_is_taken_out_put_down_and_all_is_undone(context: Any, stand: Path) -> None:
    with program(stand) as started:
        page = opened(context, started)
        before = document(page)
        page.evaluate("() => window.feeler.grip('stand/pump')")
        wait(page, "() => window.feeler.document.gripped.length === 1 && window.feeler.pose !== null")
        start = np.reshape(page.evaluate("() => window.feeler.pose"), (4, 4))[:3, 3]
        aside = move(page, start[0] + 0.1, start[1], start[2])
        # A millimetre to the post.
        assert aside[0, 3] - start[0] == pytest.approx(0.001, abs=CAST_M)
        out = move(page, start[0], start[1], start[2] + 0.4)
        assert out[2, 3] - start[2] == pytest.approx(0.4, abs=1e-9)
        keep(page.screenshot(), "taken.png")
        page.evaluate("() => window.feeler.release()")
        wait(page, "() => window.feeler.document.sequence.length === 1")
        after = document(page)
        (line,) = after["sequence"]
        assert line["parts"] == [3] and after["gripped"] == [] and "3" in after["moved"]
        page.keyboard.press("Alt+5")
        page.get_by_text("pump").first.wait_for()
        keep(page.screenshot(), "sequence.png")
        depth = 0
        while document(page)["sequence"] or document(page)["gripped"] or document(page)["moved"]:
            page.evaluate("() => window.feeler.undo()")
            depth += 1
            assert depth < 10
        undone = document(page)
        for name in ("gripped", "moved", "out", "sequence", "hidden"):
            assert undone[name] == before[name], name
        assert troubles(page) == []


def test_two_clicks_measure(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        page.locator("#picture").focus()
        page.keyboard.press("1")
        page.keyboard.press("m")
        settled(page)
        area = page.locator("#picture").bounding_box()
        x, y = area["x"] + 0.5 * area["width"], area["y"] + 0.5 * area["height"]
        page.mouse.click(x - 60, y + 100)
        page.mouse.click(x + 60, y + 100)
        wait(page, "() => window.feeler.document.measures.length === 1")
        (measure,) = document(page)["measures"]
        ends = np.array(measure["points"])
        assert measure["value"] == pytest.approx(float(np.linalg.norm(ends[1] - ends[0])), rel=1e-6)
        assert measure["value"] > 0.01
        # What was clicked at is on the stand, to the last micrometre.
        assert (np.abs(ends) <= [0.2 + 1e-6, 0.1 + 1e-6, 0.221 + 1e-6]).all()
        page.keyboard.press("Alt+4")
        keep(page.screenshot(), "measure.png")
        assert troubles(page) == []


def test_reload_a_second_page_and_a_cut_find_the_document(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        place = move(page, 0.0, 0.0, 0.25)
        page.keyboard.press("/")
        page.keyboard.type("plate")
        page.locator("[role=treeitem]", has_text="plate").click()
        page.locator("#picture").focus()
        page.keyboard.press("h")
        wait(page, "() => window.feeler.document.hidden.length === 1")
        kept = document(page)
        page.reload()
        ready(page)
        assert document(page) == kept
        wait(page, "() => window.feeler.pose !== null && window.feeler.state !== null")
        assert np.reshape(page.evaluate("() => window.feeler.pose"), (4, 4)) == pytest.approx(place)
        second = opened(context, started)
        assert document(second) == kept
        # What one page does, the other shows.
        second.keyboard.press("Alt+h")
        wait(page, "() => window.feeler.document.hidden.length === 0")
        # Two seconds without the net, and what was done meanwhile is there.
        page.bring_to_front()
        context.set_offline(True)
        page.wait_for_timeout(2000)
        context.set_offline(False)
        second.evaluate("() => window.feeler.moveTo([1,0,0,0, 0,1,0,0, 0,0,1,0.28, 0,0,0,1])")
        wait(page, "() => Math.abs(window.feeler.pose[11] - 0.28) < 1e-9")
        assert [line for line in troubles(second)] == []


def test_a_lost_context_is_rebuilt(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        before = picture(page)
        page.evaluate(
            """() => {
                const gl = document.querySelector("#picture").getContext("webgl2");
                window.lost = gl.getExtension("WEBGL_lose_context");
                window.lost.loseContext();
            }"""
        )
        page.wait_for_timeout(200)
        page.evaluate("() => window.lost.restoreContext()")
        wait(page, "() => !document.querySelector('#picture').getContext('webgl2').isContextLost()")
        page.wait_for_timeout(500)
        assert differing(picture(page), before) < 0.01
        assert move(page, 0.0, 0.0, 0.25)[2, 3] == pytest.approx(0.25)


def test_what_was_recorded_is_replayed_and_a_change_is_told(
    context: Any, stand: Path, cube: Path, tmp_path: Path
) -> None:
    record = tmp_path / "session.jsonl"
    with program(stand, "--tool", cube, "--record", record) as started:
        page = opened(context, started)
        move(page, 0.0, 0.0, 0.3)
        move(page, 0.0, 0.0, 0.05)
        page.evaluate("() => window.feeler.grip('stand/pump')")
        page.evaluate("() => window.feeler.undo()")
        assert started.interrupt() == 0
    same = subprocess.run(
        [*PROGRAM, "replay", str(record), str(stand), "--tool", str(cube)], capture_output=True, text=True, check=False
    )
    assert same.returncode == 0, same.stdout + same.stderr
    assert len(record.read_text(encoding="utf-8").splitlines()) > 4


def test_a_file_that_fails_says_why_in_the_page(context: Any, tmp_path: Path) -> None:
    broken = tmp_path / "broken.stl"
    broken.write_bytes(b"solid nothing\nendsolid nothing\n")
    with program(broken) as started:
        page = context.new_page()
        page.goto(started.url)
        page.get_by_text("broken.stl").first.wait_for()
        keep(page.screenshot(), "failed.png")
        assert str(tmp_path).lower() not in page.inner_text("body").lower(), "a page names no path of the disk"
        assert any("broken.stl" in line for line in started.said)


def test_nobody_else_gets_in(context: Any, stand: Path, tmp_path: Path) -> None:
    """A page of another site, in the same browser, that knows the address but not the token."""
    (tmp_path / "index.html").write_text("<!doctype html><title>elsewhere</title>", encoding="utf-8")
    handler = functools.partial(Quiet, directory=str(tmp_path))
    with program(stand) as started, http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as elsewhere:
        threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{elsewhere.server_address[1]}/")
        origin = started.url.split("/#")[0]
        for path in ("/", "/scene", "/scene/pieces/0"):
            told = page.evaluate("url => fetch(url).then(r => `${r.status}`, e => `refused: ${e.name}`)", origin + path)
            assert told == "refused: TypeError", (path, told)
        token = started.url.split("#t=")[1]
        told = page.evaluate(
            """([url, token]) => new Promise(done => {
                const socket = new WebSocket(url);
                const hello = {kind: "hello", protocol: 1, token, session: null, last_event: 0};
                socket.onopen = () => socket.send(JSON.stringify(hello));
                socket.onmessage = () => done("let in");
                socket.onclose = () => done("closed");
                socket.onerror = () => done("refused");
            })""",
            [origin.replace("http", "ws") + "/socket", token],
        )
        assert told in ("closed", "refused")
        elsewhere.shutdown()


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_args: Any) -> None:
        pass


@needs_axe
def test_axe_finds_nothing_serious(context: Any, stand: Path, cube: Path) -> None:
    with program(stand, "--tool", cube) as started:
        page = opened(context, started)
        for panel in range(1, 9):
            page.keyboard.press(f"Alt+{panel}")
            assert access_troubles(page, SCHEMES) == [], panel
        page.locator("#picture").focus()
        page.keyboard.press("?")
        assert access_troubles(page, SCHEMES) == []
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            keep(page.screenshot(), f"help_{scheme}.png")


def test_scripts_have_a_view(context: Any, stand: Path, cube: Path) -> None:
    scene = feeler.Scene(feeler.load_mockup(stand))
    seen: list[np.ndarray] = []
    with feeler.view(scene, feeler.load_tool(cube), browser=False) as view:
        view.on_pose(seen.append)
        page = opened(context, Program(None, view.url))  # type: ignore[arg-type]
        move(page, 0.0, 0.0, 0.3)
        assert view.pose[:3, 3] == pytest.approx([0.0, 0.0, 0.3])
        assert seen and seen[-1][2, 3] == pytest.approx(0.3)
        view.pose = np.reshape(held_at(0.0, 0.0, 0.35), (4, 4))
        wait(page, "() => Math.abs(window.feeler.pose[11] - 0.35) < 1e-9")
        png = view.screenshot()
        assert png.startswith(b"\x89PNG") and len(png) > 2000
