"""Project files: rows and seals, the lock, the layout, revisions, and files that are damaged or of strangers."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from workbench_scene import LEFT, PATHS, PEG, PLATE, cube, stand

import feeler
from feeler.errors import FeelerError, LoadError, MissingFileError, OptionError, ProjectError, WriteError
from feeler.project import layout
from feeler.project.book import Book, open_or_make
from feeler.project.lock import ENDING, Lock, holder
from feeler.project.migrations import MIGRATIONS
from feeler.project.store import Store, drop, put

POSIX = pytest.mark.skipif(os.name == "nt", reason="of POSIX")


def store(path: Path) -> Store:
    return Store(path, read_only=False, is_made=True)


@pytest.fixture
def filled(tmp_path: Path) -> Path:
    """A project of the stand with rows in every table."""
    path = tmp_path / "a.feelproj"
    with feeler.open_project(path, stand()) as project:
        book = project._book
        rows = [put(table, str(k), k, json.dumps({"k": k})) for table in ("rules", "views") for k in range(40)]
        book.write([*rows, put("answers", "long", 0, '{"kind":"way"}', bytes(range(256)) * 64)])
        project.write_clashes(feeler.clash(stand()))
    return path


def test_rows_come_back_in_their_order(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    here = store(path)
    here.write([put("views", "b", 0, "1"), put("views", "a", 1, "[2]", b"\0x"), put("rules", "a", 7, '"y"')])
    here.write([put("views", "b", 2, "3"), drop("rules", "a"), drop("rules", "never there")])
    assert [(row.id, row.value) for row in here.rows("views")] == [("a", "[2]"), ("b", "3")]
    here.close()
    again = Store(path, read_only=True, is_made=False)
    assert again.rows("views")[0] == ("a", 1, "[2]", b"\0x")
    assert again.rows("rules") == [] and again.row("views", "c") is None
    with pytest.raises(ProjectError, match="read-only"):
        again.write([])
    again.close()
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.feelproj"], "one file, without others beside it"


def test_all_changes_of_a_write_are_made_or_none(tmp_path: Path) -> None:
    here = store(tmp_path / "a.feelproj")
    here.write([put("views", "a", 0, "1")])
    too_long = "x" * (layout.MOST_TEXT + 1)
    with pytest.raises(WriteError, match="too large"):
        here.write([put("views", "b", 1, "1"), drop("views", "a"), put("views", "c", 2, too_long)])
    assert [row.id for row in here.rows("views")] == ["a"]
    here.close()


def test_a_full_disk_is_told_and_nothing_is_lost(tmp_path: Path) -> None:
    here = store(tmp_path / "a.feelproj")
    here.write([put("views", "a", 0, "1")])
    assert here._connection is not None
    here._connection.execute("PRAGMA max_page_count = 40")
    with pytest.raises(WriteError, match="the disk is full; free some space"):
        here.write([put("views", "b", 0, json.dumps("x" * 400_000))])
    here._connection.execute("PRAGMA max_page_count = 4000")
    here.write([put("views", "c", 1, "2")])
    assert [row.id for row in here.rows("views")] == ["a", "c"]
    here.close()


def test_a_file_that_is_gone_is_not_written_to(tmp_path: Path) -> None:
    here = store(tmp_path / "a.feelproj")
    os.rename(tmp_path / "a.feelproj", tmp_path / "b.feelproj")
    with pytest.raises(WriteError, match="moved or deleted"):
        here.write([put("views", "a", 0, "1")])
    here.close()


# ---- one writer ----


def test_a_second_writer_is_told_who_has_it(filled: Path) -> None:
    with feeler.open_project(filled) as project:
        with pytest.raises(ProjectError, match=rf"open in process {os.getpid()} on \S+, since 20.*read-only"):
            feeler.open_project(filled)
        with feeler.open_project(filled, read_only=True) as reader:
            assert reader.is_read_only and reader.part_paths() == project.part_paths() == PATHS
            project.write_clashes(feeler.clash(stand(), 0.01))
            assert len(reader.findings()) == len(project.findings()) > 0
    feeler.open_project(filled).close()


def holding(path: Path) -> subprocess.Popen[str]:
    program = f"import feeler, time\np = feeler.open_project({str(path)!r})\nprint('open', flush=True)\ntime.sleep(600)"
    process = subprocess.Popen([sys.executable, "-c", program], stdout=-1, text=True)
    assert process.stdout is not None and process.stdout.readline() == "open\n"
    return process


def test_the_lock_of_a_killed_process_is_taken_over(filled: Path) -> None:
    with holding(filled) as process:
        try:
            with pytest.raises(ProjectError, match=f"process {process.pid} "):
                feeler.open_project(filled)
        finally:
            process.kill()
        process.wait()
    with feeler.open_project(filled) as project:
        there = holder(filled)
        assert there is not None and there.pid == os.getpid()
        assert project.part_paths() == PATHS


@POSIX
def test_a_writer_that_lost_its_lock_unnoticed_writes_nothing(filled: Path) -> None:
    """As on a disk without locks: the count of openings tells."""
    first = store(filled)
    os.unlink(filled.with_name(filled.name + ENDING))
    second = store(filled)
    second.write([put("views", "mine", 0, "1")])
    with pytest.raises(ProjectError, match="taken over by another process"):
        first.write([put("views", "lost", 0, "1")])
    assert second.row("views", "mine") and not second.row("views", "lost")
    second.close()
    first.close()


@POSIX
def test_a_forked_child_keeps_no_lock_and_does_not_write(filled: Path) -> None:
    project = feeler.open_project(filled)
    child = os.fork()
    if not child:
        try:
            project.findings()
        except ProjectError:
            os._exit(7)
        finally:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    assert project.findings()
    project.close()


def test_locks_are_given_back_in_order(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    for _ in range(3):
        lock = Lock(path)
        with pytest.raises(ProjectError):
            Lock(path)
        lock.release()
        lock.release()
    assert list(tmp_path.iterdir()) == []


@POSIX
@pytest.mark.skipif(os.name != "nt" and os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written(filled: Path) -> None:
    os.chmod(filled.parent, 0o555)
    try:
        with pytest.raises(WriteError, match="read-only"):
            feeler.open_project(filled)
        with feeler.open_project(filled, read_only=True) as project:
            assert project.part_paths() == PATHS
    finally:
        os.chmod(filled.parent, 0o755)


# ---- layouts ----


def test_the_layout_of_version_1_is_read_by_all_later_ones(testdata: Path, tmp_path: Path) -> None:
    """`testdata/projects/version-1.feelproj` is never written again: a new layout adds a file and a migration."""
    path = tmp_path / "old.feelproj"
    shutil.copy(testdata / "projects" / "version-1.feelproj", path)
    with feeler.open_project(path) as project:
        assert project.part_paths() == PATHS
        document = project.document()
        assert document["hidden"] == [PLATE] and document["unit"] == "in"
        assert [line["name"] for line in document["sequence"]] == ["peg"]
        assert [each["name"] for each in document["measures"]] == ["gap"]
        assert [each["name"] for each in document["viewpoints"]] == ["front"]
        (finding,) = (each for each in project.findings() if each["status"] == "approved")
        assert project.history(finding["id"])[-1]["status"] == "approved"
        assert project.clashes() is not None
        assert not project.changes(stand())
    with sqlite3.connect(path) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (layout.VERSION,)
    connection.close()


def test_every_layout_has_a_fixture_and_a_migration(testdata: Path) -> None:
    versions = range(1, layout.VERSION + 1)
    there = {each.name for each in (testdata / "projects").iterdir()}
    assert there == {*(f"version-{k}.feelproj" for k in versions), "version-1-notes.feelproj"}
    assert set(MIGRATIONS) == set(versions[:-1])


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize("name", ["version-1-notes", "version-2"])
def test_notes_of_all_layouts_are_read(testdata: Path, tmp_path: Path, name: str, read_only: bool) -> None:
    """Version 1 had notes of the workbench as `notes`, beside older ones of scripts as `note`."""
    path = tmp_path / "old.feelproj"
    shutil.copy(testdata / "projects" / f"{name}.feelproj", path)
    before = path.read_bytes()
    with feeler.open_project(path, read_only=read_only) as project:
        found = project._book.marks()
        said = sorted((each["status"], each.get("by", ""), each.get("note", "")) for each in found.values())
        assert said == [
            ("approved", "Ada", "drawn so, says Bob"),
            ("new", "", "only a note"),
            ("reviewed", "Ada", "look"),
        ]
        assert sorted(each["members"] for each in found.values() if "members" in each) == [1, 1]
        lines = [(line["status"], line["by"], line["note"]) for line in project.history()]
        assert lines == [
            ("reviewed", "Ada", "look"),
            ("approved", "Ada", "drawn so"),
            ("approved", "Ada", "drawn so, says Bob"),
            ("new", "", "only a note"),
        ]
        clashes = project.clashes()
        assert clashes is not None
        again = feeler.clash(stand(), 0.01)
        again.diff(clashes)
        notes = {row.note for row in again if row.note}
        assert notes == {"drawn so, says Bob", "only a note", "look"}, "that of an ignored finding, too"
    assert not read_only or path.read_bytes() == before


def test_damaged_files_of_older_layouts_are_refused(testdata: Path, tmp_path: Path) -> None:
    for statement in ("UPDATE marks SET value = '{}'", "DELETE FROM history WHERE place = 3"):
        path = tmp_path / "old.feelproj"
        shutil.copy(testdata / "projects" / "version-1-notes.feelproj", path)
        connection = sqlite3.connect(path)
        connection.execute(statement)
        connection.commit()
        connection.close()
        before = path.read_bytes()
        with pytest.raises(LoadError, match=r"old\.feelproj.*damaged"):
            feeler.open_project(path)
        assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("PRAGMA user_version = 3", "layout 3, and this feeler reads layouts up to 2: use a newer feeler"),
        ("PRAGMA user_version = 0", "damaged: layout 0"),
        ("PRAGMA application_id = 5", "not a project of feeler"),
        ("CREATE TRIGGER t AFTER INSERT ON facts BEGIN DELETE FROM facts; END", "strange 'trigger t'"),
        ("CREATE VIEW v AS SELECT load_extension('x')", "strange 'view v'"),
        ("CREATE INDEX i ON facts (abs(place))", "strange 'index i'"),
        ("CREATE TABLE more (x)", "strange 'table more'"),
        ("CREATE VIRTUAL TABLE f USING fts5(x)", "strange 'table f'"),
        ("DROP TABLE rules", "lacks 'index sqlite_autoindex_rules_1'"),
        ("ALTER TABLE rules ADD COLUMN g GENERATED ALWAYS AS (zeroblob(1000000000))", "strange 'table rules'"),
        ("UPDATE findings SET value = 'null'", "not as it was written"),
        ("UPDATE rules SET place = place + 1 WHERE id = '3'", "not as it was written"),
        ("UPDATE rules SET seal = 'x'", "not as it was written"),
        ("UPDATE rules SET value = x'00'", "not as it was written"),
        ("DELETE FROM rules WHERE id = '3'", "missing or doubled"),
        ("DELETE FROM sums", "sums of facts are missing"),
    ],
)
def test_strange_files_are_refused(filled: Path, statement: str, message: str) -> None:
    connection = sqlite3.connect(filled)
    connection.execute(statement)
    connection.commit()
    connection.close()
    for read_only in (False, True):
        with pytest.raises(LoadError, match=message):
            read_all(filled, read_only)


def read_all(path: Path, read_only: bool = False) -> dict[str, Any]:
    with feeler.open_project(path, read_only=read_only) as project:
        book = project._book
        found = {table: book.rows(table) for table in layout.TABLES if table != "facts"}
        found["facts"] = [row for row in book.rows("facts") if row.id != "openings"]
        return {
            **found,
            "found": project.findings(),
            "document": project.document(),
            "parts": project.part_paths(),
            "answer": book.answer("long"),
            "rows": [book._store.row("rules", str(k)) for k in range(40)],
        }


def test_a_trigger_of_a_stranger_never_runs(filled: Path, tmp_path: Path) -> None:
    """Also not one that comes by another way than the file's schema at the opening."""
    project = feeler.open_project(filled)
    connection = project._book._store._connection
    assert connection is not None
    for statement in (
        "CREATE TEMP TRIGGER t AFTER INSERT ON main.facts BEGIN SELECT 1; END",
        f"ATTACH '{tmp_path / 'b.db'}' AS b",
        "SELECT load_extension('x')",
        "PRAGMA journal_mode = DELETE",
        "CREATE TABLE x (y)",
        "DROP TABLE facts",
    ):
        with pytest.raises(sqlite3.DatabaseError, match=r"not authorized|prohibited|not authorised"):
            connection.execute(statement)
    project.close()


def test_what_is_no_project(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="does not exist"):
        feeler.open_project(tmp_path / "no.feelproj")
    with pytest.raises(LoadError, match="a folder"):
        feeler.open_project(tmp_path)
    (tmp_path / "text.feelproj").write_text("hello " * 1000)
    with pytest.raises(LoadError, match="not a project"):
        feeler.open_project(tmp_path / "text.feelproj")
    (tmp_path / "empty.feelproj").write_bytes(b"")
    with pytest.raises(LoadError, match="not a project"):
        feeler.open_project(tmp_path / "empty.feelproj", stand())
    with pytest.raises(WriteError, match="another format"):
        feeler.open_project(tmp_path / "a.step", stand())
    with pytest.raises(WriteError, match="does not exist"):
        feeler.open_project(tmp_path / "no" / "a.feelproj", stand())
    with pytest.raises(ProjectError, match="closed"):
        project = feeler.open_project(tmp_path / "a.feelproj", stand())
        project.close()
        project.findings()
    assert "closed" in repr(project)


HOSTILE = (
    *("null", "3", "{}", "[[]]", '"x"', "[" * 100_000, "1e999", "NaN", "9" * 10_000, '{"id": 3}', '{"id": []}', "\\"),
    *('{"clashes": 3, "version": 1}', '{"id": "x", "status": 3}', '["a", "b", 1, 1.0, 1.0, 1.0, "b", "eaten"]'),
    '{"a": {"b": {"c": [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]}}}',
)


@pytest.mark.parametrize("table", ["facts", "findings", "marks", "history", "parts", "gone", "document", "sequence"])
def test_hostile_values_with_right_seals_are_refused_or_read(filled: Path, table: str) -> None:
    """A stranger can seal what he likes: each value is an error of ours, or an answer."""
    for text in HOSTILE:
        here = store(filled)
        before = here.rows(table)
        key = before[-1].id if before and table != "facts" else "clashes" if table == "facts" else "0"
        here.write([put(table, key, 0, text)])
        here.close()
        for act in (
            lambda p: p.findings(),
            lambda p: p.document(),
            lambda p: p.clashes(),
            lambda p: p.changes(stand()),
            lambda p: p.history(),
            lambda p: p.part_paths(),
        ):
            with feeler.open_project(filled, read_only=True) as project, contextlib.suppress(FeelerError):
                act(project)
        here = store(filled)
        here.write([drop(table, key), *(put(table, *row) for row in before)])
        here.close()
    assert read_all(filled)["parts"] == PATHS


FUZZ = int(os.environ.get("FEELER_PROJECT_FUZZ", "150"))


@pytest.mark.timeout(0)
def test_random_damage_is_told_or_harmless(filled: Path, tmp_path: Path) -> None:
    """Bytes changed, cut off, doubled, anywhere: an error of ours, or all answers as before, in little memory."""
    expected = read_all(filled, read_only=True)
    whole = filled.read_bytes()
    chance, told = random.Random(62), 0
    path = tmp_path / "damaged.feelproj"
    for _ in range(FUZZ):
        data = bytearray(whole)
        for _ in range(chance.choice([1, 1, 3, 30])):
            page = 4096 * chance.randrange(len(data) // 4096)
            at = chance.choice([chance.randrange(len(data)), chance.randrange(200), page])
            kind = chance.randrange(5)
            if kind == 0:
                del data[at:]
                data += b"\0" * chance.choice([0, len(whole) - len(data)])
            elif kind == 1:
                data[at : at + 4096] = whole[4096 : 4096 + 4096]
            else:
                data[at] = chance.choice([0, 255, chance.randrange(256), data[at] ^ (1 << chance.randrange(8))])
            if len(data) < 4096:
                break
        path.write_bytes(data)
        for each in tmp_path.glob("damaged.feelproj-*"):
            each.unlink()
        for read_only in (True, False):
            try:
                found = read_all(path, read_only)
            except FeelerError:
                told += 1
            else:
                assert found == expected
    assert told > FUZZ // 4
    if os.name != "nt":
        import resource

        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4 << 20, "in kilobytes"


# ---- revisions ----


def revision(names: list[str] | None = None, **moves: Any) -> feeler.Mockup:
    """The stand with some parts moved or scaled: `p1=("move", 0.1)`."""
    mockup = stand(names)
    vertices = mockup.vertices.copy()
    for name, (kind, by) in moves.items():
        rows = np.unique(mockup.faces[mockup.part_of_face == int(name[1:])])
        middle = vertices[rows].mean(axis=0)
        if kind == "move":
            vertices[rows] += by
        elif kind == "turn":
            turn = np.array([[np.cos(by), -np.sin(by), 0], [np.sin(by), np.cos(by), 0], [0, 0, 1]])
            vertices[rows] = (vertices[rows] - middle) @ turn.T + middle
        else:
            vertices[rows] = (vertices[rows] - middle) * by + middle
    paths = names or PATHS
    return feeler.Mockup(
        vertices, mockup.faces, mockup.part_of_face, [each.split("/")[-1] for each in paths], part_paths=paths
    )


def test_a_revision_is_told_part_by_part(filled: Path) -> None:
    with feeler.open_project(filled) as project:
        assert not project.changes(stand()) and str(project.changes(stand())) == "no part changed"
        there = revision(p1=("move", 0.7), p3=("turn", 1.0))
        rounded = feeler.Mockup(
            there.vertices.astype(np.float32), there.faces, there.part_of_face, there.part_names, part_paths=PATHS
        )
        assert project.changes(rounded).moved == (PATHS[1], PATHS[3])
        changes = project.changes(revision(p1=("move", 0.125), p3=("scale", 1.0001), p2=("turn", 0.3)))
        assert (changes.moved, changes.changed) == ((PATHS[1], PATHS[2]), (PATHS[3],))
        assert str(changes) == "parts: 1 changed, 2 moved"
        names = ["stand/plate", "stand/left", "stand/posts/right", "stand/peg", "sheet"]
        changes = project.changes(revision(names, p3=("scale", (1.0, 1.0, 1.5))))
        assert changes.renamed == {"stand/posts/left": "stand/left"} and changes.changed == ("stand/peg",)
        names[3] = "stand/pin"
        changes = project.changes(revision(names, p3=("scale", 2.0)))
        assert changes.gone == ("stand/peg",) and changes.new == ("stand/pin",)
        names = [f"stand v2/{each.removeprefix('stand/')}" for each in PATHS]
        changes = project.changes(revision(names, p3=("scale", 2.0), p1=("move", 0.25)))
        assert changes.changed == ("stand v2/peg",) and changes.moved == ("stand v2/posts/left",)
        assert not changes.gone and not changes.new and len(changes.renamed) == 5, "another name of the root"
        with pytest.raises(LoadError, match="about another mock-up: none of its 5 parts"):
            project.changes(feeler.sample("differential", 10_000))


def test_what_is_stale_stays_until_it_is_accepted(filled: Path) -> None:
    with feeler.open_project(filled) as project:
        book = project._book
        book.write(book.revision_changes(book.revision(revision(p1=("scale", 1.5)))))
        assert project.changes().changed == (PATHS[LEFT],), "of the mock-up that was opened last"
        book.write(book.revision_changes(book.revision(revision(p1=("scale", 1.5), p3=("move", 0.5)))))
        assert (project.changes().changed, project.changes().moved) == ((PATHS[LEFT],), (PATHS[PEG],))
        assert not project.changes(stand()), "back at the first revision, all answers hold again"
        names = [*PATHS[:3], "other", PATHS[4]]
        book.write(book.revision_changes(book.revision(revision(names, p3=("scale", 3.0)))))
        assert project.changes().gone == (PATHS[PEG],) and project.changes().new == ("other",)
        assert not project.changes(stand()), "a part that comes back as it was is not stale"
        book.write(book.revision_changes(book.revision(revision(p1=("scale", 1.5))), is_accepted=True))
        assert not project.changes() and project.changes(stand()).changed == (PATHS[LEFT],)


# ---- findings ----


def test_statuses_and_notes_of_findings_survive_checks(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    found = feeler.clash(stand(), 0.01)
    with feeler.open_project(path, stand()) as project:
        assert project.clashes() is None and project.findings() == []
        found.set_status(found[0].id, "approved", by="Ada", note="as drawn")
        project.write_clashes(found)
    again = feeler.clash(stand(), 0.02)
    with feeler.open_project(path) as project:
        before = project.clashes()
        assert before is not None and list(before.ids) == list(found.ids)
        assert before[0].note == "as drawn" and before[0].status == "approved"
        again.diff(before)
        project.write_clashes(again)
        now = project.clashes()
        assert now is not None
        assert {row.id: (row.status, row.by, row.note) for row in now}[found[0].id] == ("approved", "Ada", "as drawn")
        again.set_status(found[0].id, "reviewed", by="Bob", note="look again")
        project.write_clashes(again)
        lines = project.history(found[0].id)
        assert [(line["status"], line["by"], line["note"]) for line in lines] == [
            ("approved", "Ada", "as drawn"),
            ("reviewed", "Bob", "look again"),
        ]
        assert len(project.history()) == len(lines) + len(found) - 1, "the others became active"


def test_a_copy_is_a_project(filled: Path, tmp_path: Path) -> None:
    with feeler.open_project(filled) as project:
        project.save_copy(tmp_path / "b.feelproj")
        expected = project.findings()
    with feeler.open_project(tmp_path / "b.feelproj") as copy:
        assert copy.findings() == expected


def test_a_copy_takes_no_open_project_and_nothing_that_was_left(filled: Path, tmp_path: Path) -> None:
    other = tmp_path / "b.feelproj"
    with feeler.open_project(filled) as project, feeler.open_project(other, stand()):
        for path in (filled, filled.parent / "." / filled.name):
            with pytest.raises(OptionError, match="this project"):
                project.save_copy(path)
        with pytest.raises(ProjectError, match="is open"):
            project.save_copy(other)
        project.write_clashes(feeler.clash(stand()))
    killed(other, 0.02)
    assert other.with_name("b.feelproj-wal").stat().st_size
    with feeler.open_project(filled) as project:
        project.save_copy(other)
        expected = project.findings()
    with feeler.open_project(other) as copy:
        assert copy.findings() == expected


def killed(path: Path, clearance: float) -> None:
    """A process that writes findings into a project and is killed then."""
    code = f"""
import os, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import feeler
from workbench_scene import stand
project = feeler.open_project({str(path)!r}, stand())
project.write_clashes(feeler.clash(stand(), {clearance}))
os.kill(os.getpid(), 9)
"""
    subprocess.run([sys.executable, "-c", code], check=False, timeout=120)


@POSIX
def test_changes_of_a_project_that_is_gone_do_not_come_back_in_a_new_one(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    killed(path, 0.02)
    path.unlink()
    with pytest.raises(WriteError, match=r"a\.feelproj-wal beside it has changes of a project that is not there"):
        feeler.open_project(path, stand(["a", "b", "c", "d", "e"]))
    path.with_name("a.feelproj-wal").unlink()
    with feeler.open_project(path, stand(["a", "b", "c", "d", "e"])) as project:
        assert project.part_paths() == ["a", "b", "c", "d", "e"] and project.findings() == []


@POSIX
def test_a_symbolic_link_is_no_way_around_the_lock(filled: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.feelproj"
    link.symlink_to(filled.name)
    with feeler.open_project(filled), pytest.raises(ProjectError, match=r"link\.feelproj is open in process"):
        feeler.open_project(link)
    with feeler.open_project(link) as project:
        with pytest.raises(ProjectError, match="is open in process"):
            feeler.open_project(filled)
        copy = tmp_path / "copy.feelproj"
        copy.symlink_to("there.feelproj")
        project.save_copy(copy)
    assert copy.is_symlink() and (tmp_path / "there.feelproj").exists()


@pytest.mark.parametrize(
    "statement", ["DELETE FROM facts WHERE id = 'clashes'", "DELETE FROM facts", "DELETE FROM answers"]
)
@pytest.mark.parametrize("read_only", [False, True])
def test_a_lost_row_that_is_read_alone_is_told(filled: Path, statement: str, read_only: bool) -> None:
    connection = sqlite3.connect(filled)
    connection.execute(statement)
    connection.commit()
    connection.close()
    with pytest.raises(LoadError, match=r"rows of (facts|answers) are missing"):  # noqa: SIM117
        with feeler.open_project(filled, read_only=read_only) as project:
            project._book.answer("long")


def test_findings_of_another_mock_up_are_refused(filled: Path) -> None:
    other = feeler.clash(stand(["v", "w", "x", "y", "z"]), 0.02)
    with feeler.open_project(filled) as project:
        before = project.findings()
        project.write_clashes(other)  # renamed: the same triangles
        tall = feeler.Mockup({str(size): (cube(size).vertices, cube(size).faces) for size in (0.4, 0.5)})
        with pytest.raises(OptionError, match="another mock-up: none of their 2 parts is in"):
            project.write_clashes(feeler.clash(tall, 0.02))
        assert project.findings() != before and len(project.findings()) == len(other)


def test_names_that_are_no_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OptionError, match="path is ''"):
        feeler.open_project("", stand())
    for path in (".", tmp_path):
        with pytest.raises(LoadError, match="is a folder"):
            feeler.open_project(path, stand())
    assert list(tmp_path.iterdir()) == [] and not tmp_path.with_name(tmp_path.name + ENDING).exists()


def test_the_document_has_all_lists(testdata: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    shutil.copy(testdata / "projects" / "version-1.feelproj", path)
    with feeler.open_project(path) as project:
        project._book.write([put("requirements", "1", 0, '{"id":1,"name":"gap"}'), put("cards", "2", 0, '{"id":2}')])
        document = project.document()
    assert document["requirements"] == [{"id": 1, "name": "gap"}] and {"id": 2} in document["cards"]


def test_an_empty_project_is_deleted_when_it_is_closed(tmp_path: Path) -> None:
    book: Book = open_or_make(tmp_path / "a.feelproj")
    assert (tmp_path / "a.feelproj").exists()
    book.close()
    assert list(tmp_path.iterdir()) == []


def test_two_parts_of_one_path_and_empty_parts(tmp_path: Path) -> None:
    vertices, faces = stand().vertices, stand().faces
    mockup = feeler.Mockup(vertices, faces, stand().part_of_face, ["a", "a", "b", "c", "d", "nothing"])
    with feeler.open_project(tmp_path / "a.feelproj", mockup) as project:
        assert project.part_paths() == ["a", "a#2", "b", "c", "d", "nothing"]
        assert not project.changes(mockup)
