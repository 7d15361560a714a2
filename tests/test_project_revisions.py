"""Projects and revisions of their mock-up: files with other names, and which results are about an earlier revision."""

from __future__ import annotations

import contextlib
import datetime
import re
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_project import revision
from test_project_workbench import AT_HOME, WAIT_S, opened, saved
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, SHEET, at, stand

import feeler
from feeler.cli.projects import Work, take_mockup
from feeler.project.book import open_or_make
from feeler.project.renaming import Names
from feeler.project.store import put
from feeler.workbench.document.document import Since
from feeler.workbench.document.finding_rules import renamed_rules
from feeler.workbench.document.keeping import encoded
from feeler.workbench.report.content import report_of
from feeler.workbench.report.source import of_book, of_document
from feeler.workbench.session.session import Session

WHEN = datetime.datetime(2026, 1, 2, tzinfo=datetime.timezone.utc)
OLD, NEW = ([f"{root}/{path}" for path in PATHS] for root in ("engine", "engine_v2"))


def take(session: Session, kind: str) -> None:
    """Runs a check, and takes what it found."""
    found = session.job(kind, {}).result(WAIT_S)
    if kind == "clash":
        session.command("findings_take", {"key": found["key"]})
    else:
        session.command("requirements_checked", {"results": found})


def said(session: Session) -> dict[tuple[str, str], tuple[str, str]]:
    """The status and the note of each finding, by the names of its parts."""
    found = session.current.findings
    assert found is not None
    table = found.table
    names = [path.rpartition("/")[2] for path in table.paths]
    marks = map(found.mark_of, table.ids)
    pairs = zip(table.a.tolist(), table.b.tolist(), marks, strict=True)
    return {(names[a], names[b]): (mark.status, mark.note) for a, b, mark in pairs}


def checked(path: Path) -> dict[tuple[str, str], tuple[str, str]]:
    """A project of findings, each with a status and a note, a group made by hand, requirements and an exclusion."""
    session = opened(path, stand(OLD))
    session.command("clash_settings", {"clearance": 0.1})
    take(session, "clash")
    facts = session.document()["findings"]
    for row in range(facts["count"]):
        given = {"version": facts["version"], "rows": [row], "status": "reviewed", "note": f"seen {row}"}
        session.command("finding_mark", given)
    session.command("finding_group_add", {"version": facts["version"], "rows": [0], "name": "mine"})
    for name, a in (("path", OLD[PEG]), ("folder", "engine/stand/posts"), ("regex", r"re:engine/.*/peg"), ("own", "*")):
        session.command("requirement_add", {"name": name, "a": a, "b": OLD[PLATE], "gap": 0.0})
    session.command("finding_ignore", {"name": "like this", "a": "engine/stand/posts/le*", "b": OLD[RIGHT]})
    saved(session)
    before = said(session)
    assert len(before) > 2 and all(status == "reviewed" for status, _ in before.values())
    session.close()
    return before


def test_findings_keep_what_was_said_in_a_file_with_another_name(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    before = checked(path)
    with feeler.open_project(path) as project:
        history = len(project.history())
    session = opened(path, stand(NEW))
    found = session.current.findings
    assert found is not None and said(session) == before
    assert {each.split("/")[0] for each in found.table.paths} == {"engine_v2"}
    assert len(found.members) == 1 and set(found.members) <= set(found.table.ids)
    saved(session)
    take(session, "clash")
    assert said(session) == before, "the same findings, checked again"
    assert len(session.current.findings.members) == 1  # type: ignore[union-attr]
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        ids = {row["id"] for row in project.findings()}
        assert len(project.history()) == history, "nobody said anything else"
        assert {row["id"] for row in project.history()} <= ids
        assert all(row["status"] == "reviewed" and row["note"] for row in project.findings())


def test_what_was_said_of_hidden_findings_follows_names_too(tmp_path: Path) -> None:
    """Of findings that a rule hides: twice another name, an edit in between, and they are listed again."""
    path = tmp_path / "a.feelproj"
    session = opened(path, stand(OLD))
    session.command("clash_settings", {"clearance": 2.0})
    take(session, "clash")
    facts = session.document()["findings"]
    given = {"version": facts["version"], "rows": [*range(facts["count"])], "status": "approved", "note": "seen"}
    session.command("finding_mark", given)
    before = said(session)
    session.command("finding_ignore", {"name": "posts", "a": "*/posts/*", "b": "*"})
    hidden = {*before} - {*said(session)}
    assert len(hidden) > 1 and all("left" in pair or "right" in pair for pair in hidden)
    saved(session)
    session.close()
    third = [f"engine_v3/{path}" for path in PATHS]
    for names in (NEW, third):
        session = opened(path, stand(names))
        saved(session)
        if names is NEW:
            facts = session.document()["findings"]
            session.command("finding_mark", {"version": facts["version"], "rows": [0], "note": "again"})
            take(session, "clash")
            saved(session)
        session.close()
    session = opened(path, stand(third))
    session.command("clash_settings", {"rules": ""})
    take(session, "clash")
    now = said(session)
    assert {pair: now[pair] for pair in hidden} == dict.fromkeys(hidden, ("approved", "seen"))
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        assert {line["status"] for line in project.history()} == {"approved"}, "nothing else was said"
        project.document()


def test_a_check_with_a_smaller_clearance_keeps_what_was_said(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    found = []
    for clearance in (2.0, 0.001, 2.0):
        session = opened(path)
        session.command("clash_settings", {"clearance": clearance})
        take(session, "clash")
        facts = session.document()["findings"]
        if not found:
            marks = {"version": facts["version"], "status": "approved", "note": "agreed"}
            session.command("finding_mark", {**marks, "rows": [*range(facts["count"])]})
        saved(session)
        found.append(said(session))
        session.close()
    assert len(found[1]) < len(found[0]) and found[2] == found[0]
    assert {*found[0].values()} == {("approved", "agreed")}
    # What moved away is gone.
    session = opened(path, revision(p1=("move", 50.0)))
    assert session.job("clash", {}).result(WAIT_S)["gone"] > 0
    session.close()


def check_by_command(path: Path, now: feeler.Mockup) -> None:
    """Checks a mock-up and keeps the findings in a project, as `feeler clash` does."""
    with contextlib.closing(open_or_make(path)) as book:
        take_mockup(book, now, Work([]))
        again, known = feeler.clash(now, 0.3), book.clashes()
        assert known is not None
        again.diff(known)
        book.write_clashes(again)


@pytest.mark.parametrize("is_moved", [True, False], ids=["moved", "left out"])
def test_findings_that_are_gone_are_the_same_in_the_workbench_and_out_of_it(tmp_path: Path, is_moved: bool) -> None:
    """They keep their notes and their history, through undo, and in the next file."""
    now = revision(p1=("move", 50.0)) if is_moved else without_left()
    told = []
    for name in ("command", "page"):
        path = tmp_path / f"{name}.feelproj"
        found = feeler.clash(stand(), 0.3)
        for each in found.ids:
            found.set_status(each, "reviewed", by="Ada", note="asked")
        with feeler.open_project(path, stand()) as project:
            project.write_clashes(found)
        if name == "command":
            check_by_command(path, now)
        else:
            session = opened(path, now)
            session.command("clash_settings", {"clearance": 0.3})
            take(session, "clash")
            saved(session)
            for command in ("undo", "redo"):
                session.command(command, {})
                saved(session)
            in_page = report_of(of_document(session.current, now, {}), WHEN)
            session.close()
        with contextlib.closing(open_or_make(path, read_only=True)) as book:
            earlier = book.clashes()
            report = report_of(of_book(book, now), WHEN)
        assert earlier is not None and [each.note for each in earlier.earlier()] == ["asked"] * len(report.resolved)
        assert all(row.note == "asked" and row.by == "Ada" for row in report.resolved)
        told.append([(row.id, row.status, row.sentence, row.history[-1].status) for row in report.resolved])
    assert told[0] and told[0] == told[1]
    assert [row.id for row in in_page.resolved] == [row[0] for row in told[0]]
    if is_moved:
        with contextlib.closing(open_or_make(path)) as book:
            take_mockup(book, revision([f"new {each}" for each in PATHS], p1=("move", 50.0)), Work([]))
            known = book.clashes()
            assert known is not None and {key.split("/")[0] for key in known.keys} <= {"new stand", "new sheet"}


def test_findings_that_name_parts_in_other_words_are_not_gone(tmp_path: Path) -> None:
    session = opened(tmp_path / "a.feelproj")
    row = {"id": "7", "a": "left", "b": "plate", "verdict": "contact", "rule": "default", "status": "reviewed"}
    session.load_findings({"clashes": [row, {**row, "id": "8", "a": "stand/posts/left", "b": "stand/peg"}]})
    found = session.job("clash", {}).result(WAIT_S)
    session.command("findings_take", {"key": found["key"]})
    assert found["gone"] == 1 and said(session)["plate", "left"] == ("reviewed", "")
    saved(session)
    session.close()


def without_left() -> feeler.Mockup:
    """The stand without a post."""
    whole = stand()
    kept = np.flatnonzero(whole.part_of_face != LEFT)
    parts = whole.part_of_face[kept].astype(int)
    paths = [path for row, path in enumerate(PATHS) if row != LEFT]
    names = [path.split("/")[-1] for path in paths]
    return feeler.Mockup(whole.vertices, whole.faces[kept], parts - (parts > LEFT), names, part_paths=paths)


def test_a_check_of_the_command_line_knows_findings_of_the_workbench_in_another_file(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    before = checked(path)
    now = stand(NEW)
    with contextlib.closing(open_or_make(path)) as book:
        take_mockup(book, now, Work([]))
        previous = book.clashes()
    assert previous is not None
    found = feeler.clash(now, 0.1)
    found.diff(previous)
    assert sum(status == "reviewed" for status in found.statuses) == len(before)


@pytest.mark.parametrize("name", ["command", "page"])
def test_the_history_of_a_finding_says_when_it_was_gone_and_when_it_is_there_again(tmp_path: Path, name: str) -> None:
    """Whether anything was said of it before or not, and however many checks it was away."""
    path, away = tmp_path / "a.feelproj", revision(p1=("move", 50.0))
    found = feeler.clash(stand(), 0.3)
    first, second, *_ = [row.id for row in found if PATHS[LEFT] in (row.path_a, row.path_b)]
    found.set_status(first, "approved", by="Ada", note="asked")
    with feeler.open_project(path, stand()) as project:
        project.write_clashes(found)
    for now in (away, away, stand(), stand()):
        if name == "command":
            check_by_command(path, now)
        else:
            session = opened(path, now)
            session.command("clash_settings", {"clearance": 0.3})
            take(session, "clash")
            saved(session)
            session.close()
    with feeler.open_project(path) as project:
        told = [[line["status"] for line in project.history(each)] for each in (first, second)]
        assert told[0] == ["approved", "resolved", "new", "active"]
        assert told[1] == ["resolved", "new", "active"]
        assert {row["id"]: row["status"] for row in project.findings()}[first] == "active", "the last line says it"


def test_a_report_of_another_file_has_the_history_of_its_findings(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    checked(path)
    book = open_or_make(path, read_only=True)
    report = report_of(of_book(book, stand(NEW)), WHEN)
    book.close()
    assert report.findings and all(len(row.history) == 1 and row.status == "reviewed" for row in report.findings)
    assert not any(row.stale for row in (*report.findings, *report.requirements))


def test_patterns_and_rules_follow_the_names_of_parts(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    checked(path)
    session = opened(path, stand(NEW))
    asked = {each.name: each.a for each in session.current.requirements}
    assert asked == {
        "path": NEW[PEG],
        "folder": "engine_v2/stand/posts",
        "regex": r"re:engine_v2/.*/peg",
        "own": "*",
    }
    assert "engine/" not in session.current.clash.rules
    take(session, "verify")
    assert {each.verdict and each.verdict.status for each in session.current.requirements} <= {"holds", "violated"}
    session.command("finding_ignore", {"name": "alike", "a": NEW[PLATE], "b": NEW[PEG]})
    taken = session.job("clash", {}).result(WAIT_S)
    assert not any("names no part" in note for note in taken["notes"])
    session.close()


@pytest.mark.parametrize(
    ("after", "now"),
    [
        (["stand/plate", "stand/posts/left", "stand/posts/mid", "stand/peg", "sheet"], "mid"),
        (["stand/plate", "stand/posts/left", "stand/posts/peg", "stand/peg", "sheet"], "stand/posts/peg"),
        (["stand/plate", "stand/right", "stand/mid", "stand/peg", "sheet"], "right"),
    ],
    ids=["name", "another has the name", "still there"],
)
def test_a_bare_name_follows_its_part(tmp_path: Path, after: list[str], now: str) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("requirement_add", {"name": "r", "a": "right", "b": "plate", "gap": 0.1})
    saved(session)
    session.close()
    with contextlib.closing(open_or_make(path, read_only=True)) as book:
        (asked,) = of_book(book, stand(after)).document.requirements
    assert (asked.a, asked.b) == (now, "plate")


def test_a_part_that_leaves_a_pattern_by_its_name_is_told(tmp_path: Path) -> None:
    """The pattern stays, as it names other parts; what it names no more is said until the revision is accepted."""
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("requirement_add", {"name": "posts", "a": "*/posts/*", "b": "stand/peg", "gap": 0.01})
    session.command("requirement_add", {"name": "all", "a": "stand/*", "b": "stand/posts/left", "gap": 0.01})
    session.command("clash_settings", {"rules": '[[exclude]]\nname = "feet"\na = "*/posts/*"\nb = "stand/plate"\n'})
    assert saved(session)["project"]["left"] == []
    session.close()
    now = stand([PATHS[0], "stand/beam", *PATHS[2:]])
    told = [
        {"pattern": "*/posts/*", "of": of, "part": "stand/beam", "was": "stand/posts/left"}
        for of in ("requirement", "rule")
    ]
    with contextlib.closing(open_or_make(path, read_only=True)) as book:
        notes = report_of(of_book(book, now), WHEN).notes
        assert "'*/posts/*' of a requirement does not name stand/beam any more, which was stand/posts/left." in notes
    for _ in range(2):
        session = opened(path, now)
        document = saved(session)
        assert document["project"]["left"] == told
        assert [(each["a"], each["b"]) for each in document["requirements"]] == [
            ("*/posts/*", "stand/peg"),
            ("stand/*", "stand/beam"),
        ]
        session.close()
    session = opened(path, now)
    session.command("accept_revision", {})
    assert saved(session)["project"]["left"] == []
    session.close()
    session = opened(path, now)
    assert saved(session)["project"]["left"] == []
    session.close()


def test_renamed_parts_are_listed_until_the_answers_are_of_these(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    saved(session)
    session.close()
    told = []
    for name in ("mid", "far"):
        now = stand([*PATHS[:2], f"stand/posts/{name}", *PATHS[3:]])
        with feeler.open_project(path) as project:
            told.append(project.changes(now).renamed)
        session = opened(path, now)
        saved(session)
        session.job("report", {"pictures": 0}).result(WAIT_S)
        assert "<li>1 renamed: " in session.export("report.html").decode()
        session.close()
        with feeler.open_project(path) as project:
            assert project.changes().renamed == told[-1]
        with contextlib.closing(open_or_make(path, read_only=True)) as book:
            assert of_book(book, now).changes.renamed == of_book(book, None).changes.renamed == told[-1]
    assert told == [{PATHS[2]: "stand/posts/mid"}, {PATHS[2]: "stand/posts/far"}]
    with feeler.open_project(path) as project:
        assert not project.changes(stand()), "as it was"
    with contextlib.closing(open_or_make(path)) as book:
        book.write(book.revision_changes(book.revision(now), is_accepted=True))
        assert not book.renamed()


def test_names_of_several_parts_follow_together() -> None:
    parts = stand(["a/x", "b/x", "c/z", "peg", "sheet"]).parts
    names = Names({"a/bolt": "a/x", "b/bolt": "b/x", "c/nut": "c/z", "d/nut": "peg", "e/pin#2": "sheet"})
    assert [names.pattern(each, parts) for each in ("bolt", "nut", "pin")] == ["x", "nut", "sheet"]


def test_rules_keep_all_but_their_patterns() -> None:
    parts = stand(NEW).parts
    names = Names(dict(zip(OLD, NEW, strict=True)), (("engine/", "engine_v2/"),))
    rules = """# by hand
[[rule]]
name = "engine/stand/peg"
a = ['engine/stand/peg', "other/*"]
b = "engine/stand/*"  # the rest
"""
    made = renamed_rules(rules, lambda each: names.pattern(each, parts))
    assert made.count("engine_v2/stand") == 2 and '"other/*"' in made and "# by hand" in made
    assert 'name = "engine/stand/peg"' in made
    assert renamed_rules("[[rule]", str.upper) == "[[rule]"


@pytest.mark.parametrize("pattern", ["*/peg", "nobody/*", "re:(", "material:steel", "", "engine_v2/stand"])
def test_patterns_that_do_not_need_another_name_stay(pattern: str) -> None:
    names = Names(dict(zip(OLD, NEW, strict=True)), (("engine/", "engine_v2/"),))
    assert names.pattern(pattern, stand(NEW).parts) == pattern


def test_each_result_is_about_the_revision_that_it_was_computed_on(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    for name, a, b in (("peg", PATHS[PEG], PATHS[PLATE]), ("posts", PATHS[LEFT], PATHS[RIGHT])):
        session.command("requirement_add", {"name": name, "a": a, "b": b, "gap": 0.0})
    session.command("measure_add", {"type": "parts", "parts": [PEG, RIGHT], "name": "of the peg"})
    session.command("measure_add", {"type": "parts", "parts": [LEFT, RIGHT], "name": "of the posts"})
    take(session, "verify")
    take(session, "clash")
    assert marks(session) == [{}] * 5
    saved(session)
    session.close()

    raised = revision(p3=("move", 0.015625))
    session = opened(path, raised)
    peg = {PEG: "moved"}
    assert marks(session) == [peg, {}, peg, {}, peg], "requirements, measures, findings"
    assert session.document()["requirements"][0]["verdict"]["stale"] == {str(PEG): {"change": "moved"}}
    report = report_of(of_document(session.current, raised, {}), WHEN)
    assert [row.stale for row in report.requirements] == ["peg moved", ""]
    assert {bool(row.stale) for row in report.findings if row.a.endswith("peg") or row.b.endswith("peg")} == {True}
    saved(session)
    session.close()

    # Back at the first one, all hold again.
    session = opened(path, stand())
    assert marks(session) == [{}] * 5
    saved(session)
    session.close()

    session = opened(path, raised)
    take(session, "verify")
    take(session, "clash")
    assert marks(session) == [{}, {}, peg, {}, {}], "checked again"
    saved(session)
    session.close()
    book = open_or_make(path, read_only=True)
    report = report_of(of_book(book, raised), WHEN)
    book.close()
    assert not any(row.stale for row in (*report.findings, *report.requirements)), "they are of this revision"

    session = opened(path, stand())
    assert marks(session) == [peg, {}, {}, {}, peg], "of the newer one, which is another now"
    session.close()


def marks(session: Session) -> list[dict[int, str]]:
    """How parts differ since: of requirements, measures and findings."""
    document = session.current
    assert document.findings is not None
    stale = [each.verdict.stale for each in document.requirements if each.verdict is not None]
    stale += [each.stale for each in document.measures] + [document.findings.stale]
    return [{part: since.change for part, since in each.items()} for each in stale]


def test_a_removal_is_of_the_revision_that_it_was_made_in(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("set_mode", {"mode": "pass"})
    session.command("grip", {"parts": [PEG]})
    pose = np.reshape(AT_HOME, (4, 4)).copy()
    pose[:3, 3] = 0.0, 0.28125, 3.0
    session.command("place", {"pose": pose.ravel().tolist()})
    session.command("release", {})
    saved(session)
    session.close()
    session = opened(path, revision(p1=("move", 0.0625)))
    (line,) = session.current.sequence
    assert {part: each.change for part, each in line.stale.items()} == {LEFT: "moved"}, "what is around it counts"
    (step,) = report_of(of_document(session.current, stand(), {}), WHEN).steps
    assert "earlier revision" in step.stale
    session.close()


@pytest.mark.parametrize("height", [0.25, 1.0])
def test_a_removal_that_was_checked_again_is_up_to_date(tmp_path: Path, height: float) -> None:
    path, now = tmp_path / "a.feelproj", revision(p1=("move", 0.0625))
    session = opened(path)
    way = {"parts": [PEG], "poses": [AT_HOME, at(0, 0, height).ravel().tolist()], "clearance": None}
    session.command("way_take", {"ways": [way]})
    (line,) = session.current.sequence
    saved(session)
    session.close()
    session = opened(path, now)
    assert session.current.sequence[0].stale
    session.command("sequence_rename", {"id": line.id, "name": "out"})
    check(session, line.id)
    assert session.current.cards[0].is_good is (height == 0.25), "a way that does not hold was checked as well"
    session.command("undo", {})
    (line,) = session.current.sequence
    assert (line.name, dict(line.stale)) == ("peg", {}), "undo does not take the check back"
    saved(session)
    session.close()
    book = open_or_make(path, read_only=True)
    (step,) = report_of(of_book(book, now), WHEN).steps
    book.close()
    assert step.checked and not step.stale
    session = opened(path, stand())
    assert {part: each.change for part, each in session.current.sequence[0].stale.items()} == {LEFT: "moved"}
    session.close()


def test_a_part_that_is_back_as_it_was_is_new_only_to_results_that_did_not_know_it(tmp_path: Path) -> None:
    path, raised = tmp_path / "a.feelproj", revision(p1=("move", 0.0625))
    lifted = {"poses": [AT_HOME, at(0, 0, 0.25).ravel().tolist()], "clearance": None}
    session = opened(path)
    session.command("requirement_add", {"name": "posts", "a": "stand/posts/*", "b": PATHS[PLATE], "gap": 0.0})
    session.command("way_take", {"ways": [{"parts": [PEG], **lifted}]})
    take(session, "verify")
    take(session, "clash")
    saved(session)
    session.close()

    def of(now: feeler.Mockup) -> list[dict[int, str]]:
        """How parts differ of each removal, and of requirements and findings."""
        session = opened(path, now)
        lines = [{part: each.change for part, each in line.stale.items()} for line in session.current.sequence]
        found = [*lines, *marks(session)]
        saved(session)
        session.close()
        return found

    for gone in ([PLATE, RIGHT, PEG, SHEET], [RIGHT, PEG, PLATE, SHEET]):  # a post is gone, and stays so
        assert of(chosen(gone)) == [{}] * 3
    book = open_or_make(path, read_only=True)
    report = report_of(of_book(book, stand()), WHEN)
    book.close()
    assert not any(row.stale for row in (*report.steps, *report.requirements, *report.findings))
    assert of(stand()) == [{}] * 3, "it is back"
    # Gone as it was, and back at another place, or after it had been changed.
    assert of(chosen([PLATE, RIGHT, PEG, SHEET])) == [{}] * 3
    assert of(raised) == [{LEFT: "changed"}] * 3
    assert of(chosen([PLATE, RIGHT, PEG, SHEET])) == [{}] * 3
    assert of(raised) == [{LEFT: "changed"}] * 3
    assert of(chosen([PLATE, RIGHT, PEG, SHEET])) == [{}] * 3
    assert of(stand()) == [{}] * 3, "what the results knew"

    session = opened(path, chosen([PLATE, RIGHT, PEG, SHEET]))
    peg = 2
    session.command("way_take", {"ways": [{"parts": [1], **lifted}]})
    check(session, session.current.sequence[0].id)
    assert session.current.sequence[0].parts == (peg,)
    take(session, "verify")
    take(session, "clash")
    saved(session)
    session.close()
    assert of(stand()) == [{LEFT: "new"}] * 4, "made or checked without it"


def check(session: Session, line: int) -> None:
    """Checks the way of a line, to the end."""
    session.command("way_check", {"id": line})
    end = time.monotonic() + 120.0
    while session.current.cards[0].state != "done":
        assert time.monotonic() < end
        time.sleep(0.005)


def test_a_check_of_the_command_line_is_of_the_mock_up_that_it_saw(tmp_path: Path) -> None:
    path, raised = tmp_path / "a.feelproj", revision(p3=("move", -0.015625))
    session = opened(path)
    take(session, "clash")
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        project.write_clashes(feeler.clash(raised, 0.002))
    session = opened(path, raised)
    assert session.current.findings is not None and not session.current.findings.stale
    saved(session)
    session.close()
    with feeler.open_project(path) as project:
        project.write_clashes(feeler.clash(stand(), 0.002))
    session = opened(path, raised)
    assert session.current.findings is not None and set(session.current.findings.stale) == {PEG}
    session.close()


def test_a_damaged_list_of_stale_parts_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    session.command("measure_add", {"type": "parts", "parts": [LEFT, RIGHT], "name": "m"})
    saved(session)
    (measure,) = session.current.measures
    session.close()
    wrong = encoded(replace(measure, stale={99: Since("moved", "")}))
    with contextlib.closing(open_or_make(path)) as book:
        book.write([put("measures", str(measure.id), 0, wrong)])
    with pytest.raises(feeler.LoadError, match="there is no part 99"):
        opened(path)


def test_a_project_of_an_older_feeler_says_of_all_its_results_what_is_stale(tmp_path: Path) -> None:
    path, raised = tmp_path / "a.feelproj", revision(p3=("move", 0.015625))
    session = opened(path)
    session.command("requirement_add", {"name": "peg", "a": PATHS[PEG], "b": PATHS[PLATE], "gap": 0.0})
    session.command("measure_add", {"type": "parts", "parts": [PEG, RIGHT], "name": "m"})
    take(session, "verify")
    take(session, "clash")
    saved(session)
    session.close()
    session = opened(path, raised)
    saved(session)
    session.close()
    with contextlib.closing(open_or_make(path)) as book:
        for table in ("document", "measures", "requirements"):
            for row in book.rows(table):
                value = re.sub(r',"stale":{("3":{[^}]*})?}', "", row.value)
                book.write([put(table, row.id, row.place, value)])
        assert not any('"stale":' in row.value for table in ("document", "measures") for row in book.rows(table))
    session = opened(path, raised)
    assert marks(session) == [{PEG: "moved"}] * 3
    take(session, "verify")
    assert marks(session)[0] == {}
    saved(session)
    session.close()
    session = opened(path, raised)
    assert marks(session) == [{}, {PEG: "moved"}, {PEG: "moved"}]
    session.close()


def test_a_requirement_whose_part_is_gone_does_not_hold(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    for name, b in (("exact", PATHS[PEG]), ("pattern", "*/pe?"), ("other", PATHS[PLATE])):
        session.command("requirement_add", {"name": name, "a": PATHS[1], "b": b, "gap": 1e-6})
    take(session, "verify")
    before = [each["verdict"]["status"] for each in session.document()["requirements"]]
    saved(session)
    session.close()
    there = stand()
    kept = [part for part in range(len(PATHS)) if part != PEG]
    newer = feeler.Mockup({PATHS[part]: (there.vertices, there.faces[there.part_of_face == part]) for part in kept})
    session = opened(path, newer)
    assert session.document()["project"]["gone"] == [PATHS[PEG]]
    exact, pattern, other = (each["verdict"] for each in session.document()["requirements"])
    assert exact["status"] == pattern["status"] == "unknown" and other["status"] == before[2]
    assert exact["trouble"] == f"{PATHS[PEG]!r} names no part of this revision"
    assert pattern["trouble"] == "'*/pe?' names no part of this revision"
    session.close()


def chosen(parts: list[int]) -> feeler.Mockup:
    """Parts of the stand in another order."""
    there = stand()
    meshes = [there.faces[there.part_of_face == part] for part in parts]
    return feeler.Mockup(
        there.vertices,
        np.concatenate(meshes),
        np.repeat(np.arange(len(parts)), [len(faces) for faces in meshes]),
        [there.part_names[part] for part in parts],
        part_paths=[PATHS[part] for part in parts],
    )


def test_what_was_set_aside_comes_back_with_its_parts(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = opened(path)
    do = session.command
    do("grip", {"parts": [PEG]})
    do("place", {"pose": at(0.3, 0.3, 0.9).ravel().tolist()})
    do("release", {})
    do("measure_add", {"type": "parts", "parts": [PEG, RIGHT], "name": "of the peg"})
    do("measure_add", {"type": "parts", "parts": [LEFT, RIGHT], "name": "of the posts"})
    do("ask", {"question": "removal", "parts": [PEG]})
    do("card_cancel", {"id": session.document()["cards"][-1]["id"]})
    before = saved(session)
    session.close()
    # Without the peg, and once more with another order of its numbers.
    without, turned = chosen([PLATE, LEFT, RIGHT, SHEET]), chosen([PEG, RIGHT, LEFT, PLATE, SHEET])
    for mockup in (without, chosen([RIGHT, LEFT, PLATE, SHEET])):
        session = opened(path, mockup)
        document = saved(session)
        assert document["project"]["aside"] == 3
        assert (document["sequence"], document["cards"]) == ([], [])
        assert [each["name"] for each in document["measures"]] == ["of the posts"]
        # What is made meanwhile is another thing.
        session.command("measure_add", {"type": "parts", "parts": [0, 1], "name": "meanwhile"})
        session.command("undo", {})
        saved(session)
        if mockup is without:
            session.command("accept_revision", {})
            saved(session)
        session.close()
    for _ in range(2):
        session = opened(path, turned)
        back = saved(session)
        assert back["project"]["aside"] == 0
        (line,), (card,) = back["sequence"], back["cards"]
        assert line["parts"] == [0] and line["way"] == before["sequence"][0]["way"] and line["stale"]
        assert (card["parts"], card["title"]) == ([0], before["cards"][0]["title"]) and card["is_earlier"]
        measures = {each.name: (each.parts, each.value) for each in session.current.measures}
        values = {each["name"]: each["value"] for each in before["measures"]}
        assert measures == {
            "of the posts": ((2, 1), values["of the posts"]),
            "of the peg": ((1, 0), values["of the peg"]),
        }
        session.close()
