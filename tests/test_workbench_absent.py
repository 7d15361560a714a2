"""Parts that were left out of the scene: nobody meets them, sees them, or is sent them."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import keep, opened, program, troubles, wait
from commands import error_of, run
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, SHEET, Bench, at, cube, stand

import feeler
from feeler.errors import LoadError, WorkbenchError
from feeler.io import write_glb
from feeler.workbench.engine.snapshot import NOT_DRAWN
from feeler.workbench.session import page as page_module
from feeler.workbench.session.record import read_record
from feeler.workbench.session.replaying import replay

WAIT_S = 60.0


def bench(**options: object) -> Bench:
    """Without the plate and the sheet: a post left and right, and the peg."""
    return Bench(cube(), absent=[PLATE, SHEET], **options)  # type: ignore[arg-type]


def drawn(made: Bench) -> np.ndarray:
    """The parts of all packed triangles, in their order."""
    found = []
    for number, piece in enumerate(made.session.manifest()["pieces"]):
        data, v, t = made.session.piece(number), piece["vertices"], piece["triangles"]
        parts = np.frombuffer(data, "<u2", v, 12 * v)
        corners = np.frombuffer(data, "<u2", 3 * t, 12 * v + -(-2 * v // 4) * 4).reshape(-1, 3)
        found.append(parts[corners[:, 0]])
    return np.concatenate(found)


def test_the_pages_get_neither_triangles_nor_names_of_them() -> None:
    made = bench()
    manifest = made.session.manifest()
    assert made.document["absent"] == [PLATE, SHEET]
    assert (made.document["mockup"]["triangles"], made.document["mockup"]["parts"]) == (36, 5)
    assert manifest["triangles"] == 36 and manifest["parts"]["triangles"] == [0, 12, 12, 12, 0]
    assert manifest["parts"]["paths"] == ["", *PATHS[LEFT : PEG + 1], ""]
    for part in (PLATE, SHEET):
        lower, upper = manifest["parts"]["lower"][part], manifest["parts"]["upper"][part]
        assert lower[0] > upper[0], "as an empty part: it has no box"
    assert manifest["lower"] == pytest.approx((-0.375, -0.0625, 0.0)), "the box of what is there"
    assert manifest["upper"] == pytest.approx((0.375, 0.3125, 0.25))
    parts = drawn(made)
    assert set(parts.tolist()) == {LEFT, RIGHT, PEG}
    places = made.session.snapshot().places
    there = np.isin(made.mockup.part_of_face, (LEFT, RIGHT, PEG))
    assert (places[~there] == NOT_DRAWN).all()
    np.testing.assert_array_equal(parts[places[there]], made.mockup.part_of_face[there])


def test_the_hand_begins_beside_what_is_there_and_meets_nothing_else() -> None:
    made = bench()
    size = np.linalg.norm([0.75, 0.375, 0.25])
    assert made.pose[:3, 3] == pytest.approx([0.375 + 0.03125 + 0.06 * size, 0.125, 0.25 + 0.03125])
    made.drag(at(0.0, 0.0, 0.4), 1.0)
    made.drag(at(0.0, 0.0, -0.3), 1.0)
    assert made.pose[2, 3] == -0.3, "there is no plate"
    made.drag(at(0.0, 0.0, 0.1), 1.0)
    made.drag(at(0.3, 0.0, 0.1), 1.0)
    assert made.session.snapshot().parts == [RIGHT]


def test_commands_leave_them_alone() -> None:
    made = bench()
    made.command("hide", parts="*")
    assert made.document["hidden"] == [LEFT, RIGHT, PEG]
    made.command("show_all")
    made.command("isolate", parts=[PEG, SHEET])
    assert made.document["hidden"] == [LEFT, RIGHT]
    made.command("isolate", parts=[PEG])
    assert made.document["hidden"] == [] and not made.document["isolated"], "the sheet was not one of them"
    made.command("ghost", parts="stand/*", is_on=True)
    assert made.document["ghost"] == [LEFT, RIGHT, PEG]
    made.command("hide_all")
    assert made.document["hidden"] == [LEFT, RIGHT, PEG]
    made.command("single_out", parts=[PLATE, PEG])
    assert (made.document["hidden"], made.document["ghost"]) == ([LEFT, RIGHT], [LEFT, RIGHT])
    for name, parts in (("grip", [PLATE]), ("measure_add", [PLATE, PEG])):
        with pytest.raises(WorkbenchError, match="stand/plate was left out of the scene"):
            made.command(name, parts=parts, **({"type": "parts"} if name == "measure_add" else {}))
    clash = {"version": 1, "clashes": [{"a": PATHS[PLATE], "b": PATHS[PEG], "depth": 0.001}]}
    made.session.load_findings(clash)
    made.command("findings_open", findings=clash)
    for depth in range(2):
        table = made.session.current.findings.table
        assert table.paths == (PATHS[PLATE], PATHS[PEG]) and table.part_of_path.tolist() == [-1, PEG], depth
        made.command("undo")


def test_sections_and_rays_pass_them(tmp_path: Path) -> None:
    made = bench()
    down = {"origin": [0.3, 0.0, 1.0], "direction": [0, 0, -1]}
    assert made.session.ask("ray", down)["part"] == RIGHT, "under the sheet"
    made.command("section_add", normal=[0, 1, 0], offset=0.0)
    result = made.session.job("outline", {}).result(WAIT_S)
    assert set(np.frombuffer(base64.b64decode(result["parts"]), "<u4").tolist()) == {LEFT, RIGHT}
    made.session.close()


def test_what_is_exported_has_them_not(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Bench(None, absent=[PLATE, SHEET])
    made.command("grip", parts=[PEG])
    start = made.pose
    made.command("place", pose=(at(0.0, 0.0, 0.05) @ start).ravel().tolist())
    made.command("release")
    made.session.job("export_glb", {}).result(WAIT_S)
    glb = made.session.export("sequence.glb")
    assert b'"peg"' in glb and b"plate" not in glb
    containers: list[bytes] = []
    whole = page_module.container

    def seen(*args: object) -> object:
        found = whole(*args)  # type: ignore[arg-type]
        containers.append(found[0])
        return found

    monkeypatch.setattr(page_module, "container", seen)
    made.session.job("page", {}).result(WAIT_S)
    assert b"stand/peg" in containers[0]
    assert b"plate" not in containers[0] and b"sheet" not in containers[0], "whoever gets the file reads no name"
    made.session.close()


def recorded(path: Path) -> Bench:
    made = bench(pose=at(0.0, 0.0, 0.2), mode="pass", record=path)
    made.drag(at(0.3, 0.0, -0.05), 1.0)
    made.command("hide_all")
    made.session.close()
    return made


def test_a_record_is_replayed_without_the_same_parts(tmp_path: Path) -> None:
    made = recorded(tmp_path / "a.jsonl")
    record = read_record(tmp_path / "a.jsonl")
    assert record.header["mockup"]["absent"] == [PLATE, SHEET]
    assert replay(record, made.mockup, made.scene, cube())
    whole = feeler.Scene(made.mockup)
    with pytest.raises(LoadError, match=r"other parts left out: stand/plate and 1 more only then; give --without"):
        replay(record, made.mockup, whole, cube())
    with pytest.raises(LoadError, match=r"stand/plate only then, stand/peg only now"):
        replay(record, made.mockup, whole.without([PEG, SHEET]), cube())


def test_a_record_that_does_not_say_what_was_left_out_is_gone_through(tmp_path: Path) -> None:
    made = recorded(tmp_path / "a.jsonl")
    first, *rest = (tmp_path / "a.jsonl").read_text().splitlines()
    header = json.loads(first)
    del header["mockup"]["absent"]
    (tmp_path / "b.jsonl").write_text("\n".join([json.dumps(header), *rest]) + "\n")
    record = read_record(tmp_path / "b.jsonl")
    assert replay(record, made.mockup, made.scene, cube())
    assert not replay(record, made.mockup, feeler.Scene(made.mockup), cube())


def test_replay_on_the_command_line_leaves_parts_out(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    mockup = feeler.load_mockup(tmp_path / "stand.glb")
    left_out = [number for number, path in enumerate(mockup.part_paths) if path.endswith(("plate", "sheet"))]
    made = Bench(None, absent=left_out, record=tmp_path / "a.jsonl", mockup=mockup)
    made.command("hide_all")
    made.session.close()
    words = ["replay", tmp_path / "a.jsonl", tmp_path / "stand.glb"]
    assert "other parts left out" in error_of(*words)
    assert "The same to the last" in run(*words, "--without", "*plate", "--without", "*sheet").stdout
    assert "The same to the last" in run(*words, "--only", "*post*", "--only", "*peg").stdout


def test_in_the_page_they_are_neither_drawn_nor_listed_nor_looked_at(context: Any, stand: Path) -> None:
    with program(stand, "--without", "*posts*") as started:
        page = opened(context, started)
        assert page.evaluate("() => window.feeler.triangles") == 24
        rows = [row.get_attribute("aria-label") for row in page.locator("[role=treeitem]").all()]
        assert rows == ["stand 2", "plate", "pump"]
        assert page.locator(".tree-count").inner_text() == "2 parts"
        # The posts are higher than all else: what is looked at is the rest.
        page.locator("#picture").focus()
        page.keyboard.press("1")
        page.keyboard.press("f")
        assert page.evaluate("() => window.feeler.camera.target") == pytest.approx([0.0, 0.0, 0.0405], abs=1e-9)
        keep(page.screenshot(), "left_out.png")
        page.keyboard.press("Control+a")
        page.keyboard.press("h")
        wait(page, "() => window.feeler.document.hidden.length === 2")
        assert "2 parts, 2 hidden" in page.locator(".tree-count").inner_text()
        assert troubles(page) == []
