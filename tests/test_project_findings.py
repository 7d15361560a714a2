"""What people said of findings, in a project: kept, undone, and the same in the workbench and out of it."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from commands import run_json
from test_project_workbench import WAIT_S, opened, saved
from workbench_scene import PATHS, stand

import feeler
from feeler.cli.projects import open_named
from feeler.io import write_glb
from feeler.workbench.report.content import report_of
from feeler.workbench.report.source import of_book


def test_statuses_have_a_history_and_keep_their_notes(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    found = feeler.clash(stand(), 0.01)
    found.set_status(found[0].id, "reviewed", by="Ada", note="look")
    with feeler.open_project(path, stand()) as project:
        project.write_clashes(found)
    session = opened(path)
    session.load_findings(feeler.clashes.report(found))
    for status in ("approved", "active"):
        session.command("finding_status", {"id": found[0].id, "status": status})
        saved(session)
    session.command("undo", {})
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        assert [row["status"] for row in project.history(found[0].id)] == ["reviewed", "approved", "active", "approved"]
        now = project.clashes()
        assert now is not None and now[0].status == "approved" and now[0].note == "look"
        assert now.shapes is not None and len(now) == len(found)


def test_who_decides_in_the_workbench_is_kept(tmp_path: Path) -> None:
    """By the name that they chose; a guest without one and a script have none."""
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.load_findings(feeler.clashes.report(feeler.clash(stand(), 0.01)))
    version = session.document()["findings"]["version"]
    ada, guest = session.people.join(), session.people.join()
    session.people.name(ada, "Ada")
    session.command("finding_mark", {"version": version, "rows": [0], "status": "approved"}, ada)
    session.command("finding_mark", {"version": version, "rows": [1], "note": "look"}, ada)
    session.command("finding_mark", {"version": version, "rows": [2], "status": "reviewed"}, guest)
    session.command("finding_mark", {"version": version, "rows": [0], "note": "drawn so"}, guest)
    saved(session)
    session.command("finding_mark", {"version": version, "rows": [0], "status": "active"}, guest)
    saved(session)
    session.command("undo", {}, guest)
    session.command("finding_mark", {"version": version, "rows": [0], "status": "approved"}, guest)  # as it is
    before = saved(session)
    session.close()
    session = opened(path)
    assert saved(session) == before
    session.close()
    with feeler.open_project(path) as project:
        found = project.clashes()
        assert found is not None and [row.by for row in found] == ["Ada", "Ada", ""]
        lines = [(line["status"], line["by"]) for line in project.history(found[0].id)]
        assert lines[-1] == ("approved", "Ada") and ("active", "") in lines
    book, now = open_named(path), datetime.datetime.now(datetime.timezone.utc)
    by = {row.id: row.by for row in report_of(of_book(book, stand()), now).findings}
    book.close()
    assert [by[row.id] for row in found] == ["Ada", "Ada", ""]


def test_people_said_the_same_in_the_workbench_and_out_of_it(tmp_path: Path) -> None:
    """Notes, groups made by hand and statuses: through the workbench, a script and a check of the command line."""
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.load_findings(feeler.clashes.report(feeler.clash(stand(), 0.01)))
    version = session.document()["findings"]["version"]
    session.command("finding_mark", {"version": version, "rows": [0], "status": "approved", "note": "drawn so"})
    session.command("finding_mark", {"version": version, "rows": [1], "note": "only a note"})
    session.command("finding_group_add", {"version": version, "rows": [0, 2], "name": "mine"})
    before = saved(session)["findings"]
    session.close()
    with feeler.open_project(path) as project:
        found = project.clashes()
        assert found is not None
        assert [(row.status, row.note) for row in found] == [
            ("approved", "drawn so"),
            ("new", "only a note"),
            ("new", ""),
        ]
        assert project.findings()[1]["note"] == "only a note"
        assert [(line["status"], line["by"], line["note"]) for line in project.history()] == [
            ("approved", "", "drawn so"),
            ("new", "", "only a note"),
        ]
        again = feeler.clash(stand(), 0.01)
        again.diff(found)
        again.set_status(again[1].id, "reviewed", by="Ada", note="and more")
        project.write_clashes(again)
    session = opened(path)
    document = session.document()["findings"]
    session.close()
    assert document["own_groups"] == before["own_groups"] and document["members"] == before["members"]
    with feeler.open_project(path) as project:
        now = project.clashes()
        assert now is not None
        assert [(row.status, row.by, row.note) for row in now] == [
            ("approved", "", "drawn so"),
            ("reviewed", "Ada", "and more"),
            ("active", "", ""),
        ]


def test_an_ignored_finding_keeps_what_was_said_of_it(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    found = feeler.clash(stand(), 0.01)
    found.set_status(found[0].id, "approved", by="Ada", note="drawn so")
    with feeler.open_project(path, stand()) as project:
        project.write_clashes(found)
    session = opened(path)
    version = session.document()["findings"]["version"]
    session.command("finding_mark", {"version": version, "rows": [1], "status": "reviewed"})
    for row in (0, 1):
        a, b = found[row].path_a, found[row].path_b
        session.command("finding_ignore", {"name": f"drawn {row}", "a": a, "b": b})
    before = saved(session)
    session.close()
    session = opened(path)
    assert session.document()["findings"] == before["findings"], "to the last byte"
    session.command("clash_settings", {"rules": "", "clearance": 0.01})
    saved(session)
    taken = session.job("clash", {}).result(WAIT_S)
    session.command("findings_take", {"key": taken["key"]})
    assert session.current.findings is not None
    table = session.current.findings.table
    assert [table.status_of(each) for each in found.ids[:2]] == ["approved", "reviewed"]
    session.command("undo", {})
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        known = project.clashes()
        assert known is not None and len(known) == len(found) - 2
        again = feeler.clash(stand(), 0.01)
        again.diff(known)
        project.write_clashes(again)
        assert [(row.status, row.by, row.note) for row in again][:2] == [
            ("approved", "Ada", "drawn so"),
            ("reviewed", "", ""),
        ]
        assert again.marks.of(found[0].id).approved_depth == found.marks.of(found[0].id).approved_depth


@pytest.mark.parametrize("is_slow", [True, False])
def test_what_was_undone_or_removed_is_not_there_again(tmp_path: Path, is_slow: bool) -> None:
    """Several changes in one write come to the same as each in a write of its own."""
    path = tmp_path / "a.feelproj"
    report = feeler.clashes.report(feeler.clash(stand(), 0.01))
    session = opened(path)

    def do(name: str, /, **args: Any) -> dict[str, Any]:
        session.command(name, args)
        return saved(session) if is_slow else {}

    def reopened() -> None:
        nonlocal session
        before = saved(session)["findings"]
        session.close()
        session = opened(path)
        assert session.document()["findings"] == before

    do("findings_open", findings=report)
    version = session.document()["findings"]["version"]
    do("finding_mark", version=version, rows=[0, 2], note="old")
    do("finding_group_add", version=version, rows=[0, 1], name="mine")
    reopened()
    do("finding_group_remove", id=session.document()["findings"]["own_groups"][0]["id"])
    do("finding_mark", version=version, rows=[0], note="new")
    reopened()
    assert not session.document()["findings"]["members"]
    do("findings_open", findings=report)
    do("finding_status", id=report["clashes"][2]["id"], status="reviewed")
    reopened()
    assert not session.document()["findings"]["notes"]
    do("finding_mark", version=version, rows=[1], note="only a note")
    checked = {**report, "clashes": [{**row, "status": "active"} for row in report["clashes"]]}
    do("findings_open", findings=checked)
    do("undo")
    reopened()
    session.close()


def test_findings_without_ids_of_a_check_are_kept_too(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command(
        "findings_open", {"findings": {"clashes": [{"id": "x"}, {"id": "x"}, {}, {"a": 3, "depth": "deep"}]}}
    )
    before = saved(session)
    session.close()
    session = opened(path)
    assert session.document()["findings"] == before["findings"]
    session.close()
    with feeler.open_project(path) as project:
        assert project.clashes() is None and len(project.findings()) == 4


def test_a_check_of_an_open_project_offers_only_what_it_has(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    with pytest.raises(feeler.ProjectError) as told:
        open_named(path, can_read_only=False)
    assert str(told.value).endswith("close it there")
    with pytest.raises(feeler.ProjectError, match="open it read-only with --read-only"):
        open_named(path)
    session.close()


@pytest.mark.parametrize(
    "names",
    [
        [f"engine_v2/{path}" for path in PATHS],
        [path.replace("stand/", "frame/") for path in PATHS],
        [path.replace("posts/left", "posts/links") for path in PATHS],
    ],
    ids=["root", "folder", "part"],
)
def test_groups_and_the_history_follow_renamed_parts_in_checks_of_the_command_line(
    tmp_path: Path, names: list[str]
) -> None:
    path = tmp_path / "a.feelproj"
    for name, paths in (("old", PATHS), ("new", names)):
        write_glb(tmp_path / f"{name}.glb", stand(paths))
    rows = run_json("clash", tmp_path / "old.glb", "--clearance", "0.3", "--project", path)["clashes"]
    left = next(row for row, each in enumerate(rows) if "left" in each["a"] and each["gap"])
    session = opened(path, feeler.load_mockup(tmp_path / "old.glb"))
    version = session.document()["findings"]["version"]
    session.command("finding_mark", {"version": version, "rows": [left], "status": "reviewed"})
    session.command("finding_group_add", {"version": version, "rows": [left], "name": "mine"})
    saved(session)
    session.close()
    # The second check does not look for gaps: the finding waits.
    for clearance in ("0.3", "0", "0.3"):
        run_json("clash", tmp_path / "new.glb", "--clearance", clearance, "--project", path)
    found = [row for row in run_json("report", path)["findings"] if row["group"] == "mine"]
    assert [(row["status"], [line["status"] for line in row["history"]]) for row in found] == [
        ("reviewed", ["reviewed"])
    ], found


def test_groups_follow_parts_that_get_the_names_of_others(tmp_path: Path) -> None:
    """Of equal paths: if the first part is gone, each later one has the key that the one before it had."""
    path = tmp_path / "a.feelproj"
    before = pegs(0, 1, 2)
    with feeler.open_project(path, before) as project:
        project.write_clashes(feeler.clash(before))
    session = opened(path, before)
    version = session.document()["findings"]["version"]
    for row, name in ((0, "of the first"), (2, "of the last")):
        session.command("finding_group_add", {"version": version, "rows": [row], "name": name})
    saved(session)
    session.close()
    now = pegs(1, 2)
    with feeler.open_project(path, now) as project:
        known = project.clashes()
        assert known is not None
        found = feeler.clash(now)
        found.diff(known)
        for _ in range(2):  # written again, nothing gets another name
            project.write_clashes(found)
    session = opened(path, now)
    findings = session.document()["findings"]
    assert findings["members"] == {found[1].id: findings["own_groups"][1]["id"]}
    session.close()


def pegs(*numbers: int) -> feeler.Mockup:
    """A plate, and pegs of one path that stand deep in it."""
    plate, peg = trimesh.creation.box((1.0, 0.1, 0.1)), trimesh.creation.box((0.02, 0.02, 0.2))
    return feeler.Mockup(
        np.concatenate([plate.vertices, *(peg.vertices + np.array((0.1 * number, 0.0, 0.0)) for number in numbers)]),
        np.concatenate([plate.faces, *(peg.faces + 8 * (row + 1) for row in range(len(numbers)))]),
        np.repeat(np.arange(1 + len(numbers)), 12),
        ["plate", *("peg" for _ in numbers)],
        part_paths=["plate", *("peg" for _ in numbers)],
    )
