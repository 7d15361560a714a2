"""Projects on the command line: `feeler view` as a program, and `feeler clash --project`."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from commands import error_of, run, run_json
from test_cli_view import viewed
from test_project_workbench import opened, saved
from workbench_fake import Page
from workbench_scene import PATHS, PEG, stand

import feeler
from feeler.cli.projects import Work, keep_work
from feeler.io import write_glb
from feeler.project.store import put
from feeler.workbench.document import protocol

POSIX = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")


def document_when(page: Page, is_so: Any) -> dict[str, Any]:
    document: dict[str, Any] = {**page.next(protocol.Welcome).document}
    while not is_so(document):
        document.update(page.next(protocol.Patch).fields)
    return document


def is_saved(document: dict[str, Any]) -> bool:
    return bool(document["mockup"]) and document["project"]["state"] == "saved"


@POSIX
def test_a_project_is_made_goes_on_and_names_its_mock_up(tmp_path: Path) -> None:
    folder = tmp_path / "cad"
    folder.mkdir()
    write_glb(folder / "stand.glb", stand())
    path = folder / "stand.feelproj"
    with viewed(tmp_path, folder / "stand.glb", "--tool", "sample:wrench", "--project", path) as (url, said):
        with Page(url) as page:
            document = document_when(page, is_saved)
            assert document["project"]["name"] == "stand.feelproj"
            page.send(protocol.Command(1, "hide", {"parts": [0]}))
            while (page.next(protocol.Patch).fields.get("project") or {}).get("state") != "saved":
                pass
        told = error_of("view", path)
        assert "is open in process" in told and "--read-only" in told
        with viewed(tmp_path, path, "--read-only") as (other, _), Page(other) as page:
            document = document_when(page, lambda document: document["mockup"])
            assert document["hidden"] == [0] and document["project"]["state"] == "read only"
    assert said == [""]
    moved = tmp_path / "moved"
    shutil.move(folder, moved)
    with viewed(tmp_path, moved / "stand.feelproj") as (url, said), Page(url) as page:
        document = document_when(page, is_saved)
        assert document["mockup"]["name"] == "stand.glb" and document["hidden"] == [0]
        assert document["tool"]["name"] == "wrench"
        page.send(protocol.Command(1, "show_all", {}))
        page.next(protocol.Answer)
    with feeler.open_project(moved / "stand.feelproj") as project:
        assert project.document()["hidden"] == [], "what was changed last is written before the end"
    (moved / "stand.glb").unlink()
    assert "stand.glb', which is not there: give the mock-up" in error_of("view", moved / "stand.feelproj")


@POSIX
def test_a_killed_program_loses_nothing_that_was_shown_as_saved(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    words = ("sample:differential:10000", "--project", path)
    with pytest.raises(AssertionError), viewed(tmp_path, *words) as (url, _), Page(url) as page:
        document_when(page, is_saved)
        page.send(protocol.Command(1, "hide", {"parts": [1]}))
        while (page.next(protocol.Patch).fields.get("project") or {}).get("state") != "saved":
            pass
        there = json.loads(path.with_name("a.feelproj-lock").read_text())
        os.kill(there["pid"], signal.SIGKILL)
    with viewed(tmp_path, path) as (url, _), Page(url) as page:
        assert document_when(page, is_saved)["hidden"] == [1]


@POSIX
def test_what_could_not_be_saved_is_told_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    with viewed(tmp_path, "sample:differential:10000", "--project", path, code=2) as (url, said), Page(url) as page:
        document_when(page, is_saved)
        path.rename(tmp_path / "b.feelproj")
        page.send(protocol.Command(1, "hide", {"parts": [1]}))
        while (page.next(protocol.Patch).fields.get("project") or {}).get("state") != "failed":
            pass
    assert said == ["feeler: not saved: cannot write a.feelproj: the file was moved or deleted; put it back\n"]
    # A file with that name that came meanwhile is another one, and stays as it is.
    assert feeler.open_project(tmp_path / "b.feelproj").document()["hidden"] == []


def test_words_that_cannot_be(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    feeler.open_project(path, stand()).close()
    assert "where its mock-up is" in error_of("view", path)
    assert "give one project" in error_of("view", path, "--project", tmp_path / "b.feelproj")
    assert "--read-only is for a project" in error_of("view", "--read-only")
    assert "empty document" in error_of("view", "sample:gearbox", "--project", path, "--record", tmp_path / "r.jsonl")
    assert "does not exist" in error_of("view", tmp_path / "no.feelproj")
    assert "another format" in error_of("view", "sample:gearbox", "--project", tmp_path / "a.step")
    assert "--project" in error_of("clash", "m.glb", "--project", path, "--previous", tmp_path / "x.json")
    (tmp_path / "c.feelproj").write_text("nothing")
    assert "not a project" in error_of("view", "--project", tmp_path / "c.feelproj")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.feelproj", "c.feelproj"]


def test_findings_of_a_check_go_into_the_project_with_their_history(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    path = tmp_path / "stand.feelproj"
    first = run_json("clash", tmp_path / "stand.glb", "--clearance", "0.1", "--project", path)
    assert first["written"] == {"project": str(path)} and first["clashes"]
    with feeler.open_project(path) as project:
        found = project.clashes()
        assert found is not None
        found.set_status(found[0].id, "approved", by="Ada", note="as drawn")
        project.write_clashes(found)
    again = run_json("clash", path, "--clearance", "0.2")
    assert run_json("report", path)["check"]["clearance"] == 0.2
    assert again["previous"]["by_path"] == again["previous"]["parts"]
    row = next(each for each in again["clashes"] if each["id"] == found[0].id)
    assert (row["status"], row["note"]) == ("approved", "as drawn")
    assert again["statuses"]["active"] == len(first["clashes"]) - 1
    assert "project written to" in run("clash", path, "--clearance", "0").stdout
    with feeler.open_project(path) as project:
        assert [line["status"] for line in project.history(found[0].id)][:1] == ["approved"]
    other = error_of("clash", "sample:differential:10000", "--project", path)
    assert "about another mock-up" in other
    with feeler.open_project(path, read_only=False):
        assert "is open in process" in error_of("clash", path)


def test_a_check_without_options_is_made_as_the_last_one(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    (tmp_path / "rules.toml").write_text('[[exclude]]\nname = "as drawn"\na = "*/peg"\n')
    path = tmp_path / "stand.feelproj"

    def settings() -> Any:
        with feeler.open_project(path) as project:
            return project.document()["clash"]

    first = run_json("clash", tmp_path / "stand.glb", "--clearance", "0.1", "--project", path)
    ruled = run_json("clash", path, "--rules", tmp_path / "rules.toml", "--contact", "1mm")
    assert ruled["clearance"] == 0.1 and len(ruled["clashes"]) < len(first["clashes"])
    rules = (tmp_path / "rules.toml").read_text()
    assert settings() == {"clearance": 0.1, "contact": 0.001, "rules": rules}
    again = run_json("clash", path)
    assert again["clearance"] == 0.1 and again["contact"] == 0.001 and again["hidden"] == ruled["hidden"]
    assert [each["id"] for each in again["clashes"]] == [each["id"] for each in ruled["clashes"]]
    # The page has them, too; and what it sets, the next check.
    there = settings()
    session = opened(path)
    before = session.document()
    assert before["clash"] == there and len(before["hidden"]) == 0
    session.command("clash_settings", {"clearance": 0.05, "rules": ""})
    saved(session)
    session.close()
    assert settings() == {"clearance": 0.05, "contact": 0.001, "rules": ""}
    assert run_json("clash", path)["clearance"] == 0.05
    # The page kept its whole document.
    with feeler.open_project(path) as project:
        assert {"pose", "sections", "clash"} <= project.document().keys()


def test_the_kept_rules_of_a_check_follow_renamed_parts(tmp_path: Path) -> None:
    write_glb(tmp_path / "old.glb", stand())
    whole = stand()
    paths = [each.replace("stand", "frame", 1) for each in whole.part_paths]
    names = [each.rsplit("/", 1)[-1] for each in paths]
    renamed = feeler.Mockup(whole.vertices, whole.faces, whole.part_of_face, names, part_paths=paths)
    write_glb(tmp_path / "new.glb", renamed)
    (tmp_path / "rules.toml").write_text(f'[[exclude]]\nname = "as drawn"\na = "old/{whole.part_paths[PEG]}"\n')
    path = tmp_path / "stand.feelproj"
    words = ("--clearance", "0.1", "--rules", tmp_path / "rules.toml")
    first = run_json("clash", tmp_path / "old.glb", *words, "--project", path)
    again = run_json("clash", tmp_path / "new.glb", "--project", path)
    assert first["hidden"] == again["hidden"] and len(again["clashes"]) == len(first["clashes"])
    (tmp_path / "rules.toml").write_text("# " + 400_000 * "x")
    assert "a project keeps at most 400,000" in error_of("clash", path, "--rules", tmp_path / "rules.toml")


def test_damaged_settings_of_a_check_are_told(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    path = tmp_path / "stand.feelproj"
    run("clash", tmp_path / "stand.glb", "--project", path)
    good = {"clearance": 0.1, "contact": None, "rules": ""}
    for bad in ({"clearance": -1}, {"clearance": "x"}, {"contact": True}, {"rules": 3}, {"rules": "[[exclude]"}, 3):
        with feeler.open_project(path) as project:
            value = {**good, **bad} if isinstance(bad, dict) else bad
            project._book.write([put("document", "clash", 0, json.dumps(value))])
        assert "is damaged" in error_of("clash", path), bad


def test_the_project_names_the_mock_up_that_was_checked_last(tmp_path: Path) -> None:
    write_glb(tmp_path / "old.glb", stand())
    everything = stand()
    few = everything.part_of_face != PEG
    newer = feeler.Mockup(
        everything.vertices,
        everything.faces[few],
        everything.part_of_face[few],
        everything.part_names,
        part_paths=everything.part_paths,
    )
    write_glb(tmp_path / "new.glb", newer)
    path = tmp_path / "stand.feelproj"
    first = run_json("clash", tmp_path / "old.glb", "--clearance", "0.1", "--project", path)
    named = run_json("clash", tmp_path / "new.glb", "--clearance", "0.1", "--project", path)
    assert len(named["clashes"]) < len(first["clashes"])
    (tmp_path / "old.glb").unlink()
    assert len(run_json("clash", path, "--clearance", "0.1")["clashes"]) == len(named["clashes"])


@pytest.mark.parametrize("words", [("clash",), ("maintain", "--part", "*/peg", "--seconds", "5"), ("report",)])
def test_the_tool_of_a_project_may_be_gone(tmp_path: Path, words: tuple[str, ...]) -> None:
    """Only the workbench needs it."""
    write_glb(tmp_path / "stand.glb", stand())
    with feeler.open_project(tmp_path / "stand.feelproj", feeler.load_mockup(tmp_path / "stand.glb")) as project:
        keep_work(project._book, Work([str(tmp_path / "stand.glb")], str(tmp_path / "gone.stl"), "mm"))
    run(words[0], tmp_path / "stand.feelproj", *words[1:])
    with feeler.open_project(tmp_path / "stand.feelproj") as project:
        opened = project._book.fact("opened")
        assert opened["tool"][0] == "gone.stl" and opened["tool_unit"] == "mm"
    assert "gone.stl', which is not there" in error_of("view", tmp_path / "stand.feelproj")


@pytest.mark.parametrize("option", ["--glb", "--write-rules", "--bcf"])
def test_an_input_is_not_written_over(tmp_path: Path, option: str) -> None:
    mockup, rules, topics = tmp_path / "m.glb", tmp_path / "r.toml", tmp_path / "t.bcf"
    write_glb(mockup, stand())
    run("clash", mockup, "--clearance", "0.1", "--write-rules", rules, "--bcf", topics)
    out = {"--glb": mockup, "--write-rules": rules, "--bcf": topics}[option]
    before = out.read_bytes()
    (tmp_path / "link").symlink_to(tmp_path)
    for name in (out, tmp_path / "link" / out.name):
        said = error_of("clash", mockup, "--rules", rules, "--bcf-in", topics, option, name)
        assert f"{option} {name}: it is read by this command; give another name" in said
    assert out.read_bytes() == before
    if option == "--glb":
        assert "is read by this command" in error_of("clash", tmp_path, option, mockup), "a folder of files"
    run("clash", mockup, "--save", tmp_path / "last.json")
    run("clash", mockup, "--previous", tmp_path / "last.json", "--save", tmp_path / "last.json")


def test_a_folder_is_no_project(tmp_path: Path) -> None:
    write_glb(tmp_path / "m.glb", stand())
    assert "is a folder: give a project" in error_of("clash", tmp_path / "m.glb", "--project", ".")


def test_names_of_other_machines_are_not_opened(tmp_path: Path) -> None:
    """Windows would tell that machine who asks."""
    from feeler.cli.projects import _found

    write_glb(tmp_path / "stand.glb", stand())
    with feeler.open_project(tmp_path / "a.feelproj", stand()) as project:
        assert _found(project._book, ["no.glb", str(tmp_path / "stand.glb")]) == str(tmp_path / "stand.glb")
        for name in (f"/{tmp_path}/stand.glb", "\\\\host\\share\\a.step"):
            with pytest.raises(feeler.MissingFileError, match="which is not there"):
                _found(project._book, [name])


def test_a_new_project_of_a_mock_up_that_cannot_be_read_is_deleted(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_text("<b>nonsense</b>")
    error_of("clash", tmp_path / "bad.stl", "--project", tmp_path / "a.feelproj")
    assert [each.name for each in tmp_path.iterdir()] == ["bad.stl"]


@pytest.mark.parametrize(
    "fact",
    [
        *("3", "[]", "{}", '{"sources": []}', '{"sources": [["/etc/passwd"]]}', '{"sources": [["sample:x"]]}'),
        '{"sources":[["//host/share/a.step"]],"tool":null,"tool_unit":null,"unit":null,"up":null,"without":[],"only":[]}',
        '{"sources":[["/dev/zero"]],"tool":null,"tool_unit":null,"unit":null,"up":null,"without":[],"only":[]}',
        '{"sources":[["a\\u0000b"]],"tool":null,"tool_unit":null,"unit":null,"up":null,"without":[],"only":[]}',
        '{"sources":[["sample:gearbox"]],"tool":null,"tool_unit":null,"unit":"parsec","up":null,"without":[],"only":[]}',
        '{"sources":[["sample:gearbox"]],"tool":null,"tool_unit":null,"unit":3,"up":null,"without":[],"only":[]}',
        '{"sources":[["sample:gearbox"]],"tool":null,"tool_unit":null,"unit":null,"up":null,"without":[["a"]],"only":1}',
    ],
)
def test_hostile_mock_ups_of_a_project(tmp_path: Path, fact: str) -> None:
    from feeler.project.store import put

    path = tmp_path / "a.feelproj"
    with feeler.open_project(path, stand()) as project:
        project._book.write([put("facts", "opened", 0, fact)])
    assert error_of("clash", path)
    with sqlite3.connect(path) as connection:
        assert connection.execute("SELECT count(*) FROM parts").fetchone() == (len(PATHS),)
    connection.close()
