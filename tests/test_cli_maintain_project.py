"""feeler maintain --project: runs that compare with the one in the project, Ctrl-C, damage, and what is refused."""

from __future__ import annotations

import shutil
import sqlite3
import zlib
from pathlib import Path
from typing import Any

import pytest
from commands import error_of, run, run_json
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from night_scene import lid, parts, saved
from workbench_scene import stand

import feeler
from feeler.cli import kept_runs
from feeler.cli.kept_runs import keep_run, last_run
from feeler.errors import FeelerError
from feeler.project import runs
from feeler.project.book import Book, dumps, open_or_make
from feeler.project.parts import contents_of
from feeler.project.store import put
from feeler.tasks.run import packed
from feeler.workbench.session.session import Session

COVERS = ["--part", "s0/cover", "--part", "s1/cover"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a mock-up and a project of a run."""
    folder = tmp_path_factory.mktemp("made")
    engine = saved(folder, "engine.feeler", parts(2))
    found = run_json("maintain", engine, *COVERS, "--project", folder / "engine.feelproj")
    assert found["written"] == {"project": str(folder / "engine.feelproj")}
    assert [row["state"] for row in found["rows"]] == ["out", "out"] and found["changes"] == []
    return folder


@pytest.fixture
def project(made: Path, tmp_path: Path) -> Path:
    """A project of a run, with its mock-up beside it."""
    for each in ("engine.feeler", "engine.feelproj"):
        shutil.copy(made / each, tmp_path)
    return tmp_path / "engine.feelproj"


def moved(folder: Path, prefix: str = "") -> Path:
    meshes = parts(2)
    meshes["s1/lid"] = lid(1.0)
    return saved(folder, "moved.feeler", {prefix + path: mesh for path, mesh in meshes.items()})


def book_of(path: Path, *, read_only: bool = True) -> Book:
    return open_or_make(path, read_only=read_only)


def kept(path: Path) -> feeler.Maintenance:
    book = book_of(path)
    try:
        found = last_run(book)
    finally:
        book.close()
    assert found is not None
    return found


def test_the_next_run_compares_with_the_one_in_the_project(project: Path, tmp_path: Path) -> None:
    again = run_json("maintain", project, *COVERS)
    assert all(row["is_kept"] and row["delta"] == 0.0 for row in again["rows"])
    assert again["mockup"]["parts"] == 10, "the mock-up that it names"
    said = run("maintain", moved(tmp_path), *COVERS, "--project", project, "--fail-on", "slower", code=1).stdout
    assert "2 of 2 come out, 1 changed, 1 kept" in said and "+10 s since lid moved" in said
    assert f"project written to {project}" in said
    # From now on it names that mock-up, and its run is the one to compare with.
    (tmp_path / "engine.feeler").unlink()
    last = run_json("maintain", project, *COVERS)
    assert all(row["is_kept"] and not row["change"] for row in last["rows"])
    with feeler.open_project(project) as there:
        assert there.document() == feeler.open_project(project, read_only=True).document()


def test_a_project_and_a_file_keep_the_same(project: Path, tmp_path: Path) -> None:
    files = ["--save", tmp_path / "last.json"]
    both = run_json("maintain", project, *COVERS, *files)
    assert sorted(both["written"]) == ["project", "save"]
    one, other = kept(project), feeler.load_maintenance(tmp_path / "last.json")
    assert one.to_dict() == other.to_dict() and one.hints == other.hints == ()
    assert one.answers is not None and other.answers is not None and one.answers.data == other.answers.data
    asked = [list(one.answers.read()[1].values()), list(other.answers.read()[1].values())]
    assert asked[0] == asked[1] and any(asked[0])


def test_renamed_parts_are_recognised(project: Path, tmp_path: Path) -> None:
    words = ["--part", "v2/s0/cover", "--part", "v2/s1/cover", "--project", project]
    found = run_json("maintain", moved(tmp_path, "v2/"), *words)
    assert len(found["renamed"]) == 10 and found["renamed"]["v2/s1/lid"] == "s1/lid"
    assert {row["name"]: row["renamed_from"] for row in found["rows"]}["v2/s1/cover"] == ["s1/cover"]
    assert [change["path"] for change in found["changes"]] == ["v2/s1/lid"]


def test_ctrl_c_keeps_what_is_done_and_the_next_run_goes_on(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = moved(tmp_path)
    before = kept(project)
    whole = feeler.maintain(feeler.open_scene(engine), ["s0/cover", "s1/cover"], previous=before)

    def some(count: int) -> feeler.Maintenance:
        plans = dict(list(whole.plans.items())[:count])
        rest = (frozenset[str](), whole.options, whole.snapshot, before, True, whole.answers)
        return feeler.Maintenance(whole.names, whole.own_paths, plans, *rest)

    for count, code in ((0, 130), (1, 130)):

        def interrupted(*_: Any, count: int = count, **__: Any) -> None:
            raise feeler.MaintenanceInterrupted(some(count))

        monkeypatch.setattr(feeler, "maintain", interrupted)
        run("maintain", engine, *COVERS, "--project", project, code=code)
        assert kept(project).is_partial == bool(count), "nothing done is nothing written"
    monkeypatch.undo()
    assert [row["name"] for row in run_json("report", project)["maintenance"]["rows"]] == ["s0/cover"]
    found = run_json("maintain", project, *COVERS)
    assert [row["is_kept"] for row in found["rows"]] == [True, False]
    assert found["rows"][1]["change"] == "+10 s since lid moved", "it counts from the run before"
    assert not kept(project).is_partial


def test_what_cannot_be(project: Path, tmp_path: Path) -> None:
    asked = ["maintain", project, *COVERS]
    assert "--project has the last run: leave out --previous" in error_of(*asked, "--previous", tmp_path / "a.json")
    assert "give one project" in error_of(*asked, "--project", tmp_path / "b.feelproj")
    assert "does not exist" in error_of("maintain", tmp_path / "no.feelproj", *COVERS)
    assert "must end in .json" in error_of(*asked, "--save", project)
    other = ["maintain", "sample:differential:10000", "--part", "*", "--project", project]
    assert "about another mock-up" in error_of(*other)
    with feeler.open_project(project):
        said = error_of(*asked)
        assert "is open in process" in said and "read-only" not in said
    assert [row.state for row in kept(project)] == ["out", "out"]


def test_a_new_project_of_a_list_that_is_wrong_has_no_run(made: Path, tmp_path: Path) -> None:
    path = tmp_path / "new.feelproj"
    assert "parts[0]" in error_of("maintain", made / "engine.feeler", "--part", "s9/*", "--project", path)
    book = book_of(path)
    assert last_run(book) is None and book.parts()
    book.close()


def test_a_run_of_other_parts_is_told(project: Path) -> None:
    run("maintain", project, "--part", "s0/cover", "--only", "s0/*")
    said = error_of("maintain", project, "--part", "frame/low", "--only", "frame/*")
    assert f"the last run in {project} is one of another mock-up" in said and said.endswith("use another project\n")


# ---- sizes and damage ----


def test_answers_that_are_too_large_are_left_out(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept_runs, "packed", lambda run: (packed(run)[0], bytes(10**6)))
    monkeypatch.setattr(runs, "MOST_DATA", 10**6 - 1)
    found = run("maintain", project, *COVERS)
    assert "left out" in found.stderr and "--save and --previous keep them" in found.stderr
    monkeypatch.undo()
    found = run("maintain", project, *COVERS)
    assert "are not used: they are missing" in found.stderr and "2 kept" in found.stdout


def test_a_run_that_is_too_large_is_in_its_file(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "MOST_RUN_TEXT", len(dumps(packed(kept(project))[0])) + 8)
    found = run("maintain", moved(tmp_path), *COVERS, "--project", project, "--save", tmp_path / "a.json", code=2)
    assert "too large for a project; keep it in a file" in found.stderr
    monkeypatch.undo()
    in_file = feeler.load_maintenance(tmp_path / "a.json")
    lids = [each.snapshot.parts["s1/lid"].box[0] for each in (in_file, kept(project))]
    assert lids == pytest.approx([0.97, 1.47]), "the project keeps the run before"


def test_a_write_is_all_or_none(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = book_of(project).rows("answers")
    real = runs.put

    def broken(table: str, key: str, *more: Any) -> Any:
        return None if key == runs.ANSWERS else real(table, key, *more)

    monkeypatch.setattr(runs, "put", broken)
    with pytest.raises(AssertionError):
        run("maintain", moved(tmp_path), *COVERS, "--project", project)
    assert book_of(project).rows("answers") == before and len(before) == 3


def written(path: Path, data: bytes) -> None:
    """Writes over a run, with a right digest: as somebody else may do."""
    book = book_of(path, read_only=False)
    book.write([put("answers", runs.RUN, 0, dumps({"kind": runs.RUN}), data)])
    book.close()


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "cut off"),
        (b"nonsense", "incorrect header"),
        (zlib.compress(b"{"), "use a copy"),
        (zlib.compress(b"\xff"), "use a copy"),
        (zlib.compress(b"[" * 100_000), "use a copy"),
        (zlib.compress(b"[]"), "it is a list or a single value"),
        (zlib.compress(b'{"format": "feeler maintain 9"}'), "its format is 'feeler maintain 9'"),
        (zlib.compress(b'{"format": "feeler maintain 1"}'), "is missing"),
        (zlib.compress(b"1e999"), "use a copy"),
    ],
)
def test_a_damaged_run_is_told(project: Path, data: bytes, message: str) -> None:
    written(project, data)
    said = error_of("maintain", project, *COVERS)
    assert message in said and "use a copy" in said and str(project) in said


def test_a_run_that_is_too_large_to_read_is_told(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "MOST_RUN_TEXT", 100)
    assert "cut off, or too large" in error_of("maintain", project, *COVERS)


def test_damaged_answers_give_a_hint(project: Path) -> None:
    book = book_of(project, read_only=False)
    book.write([put("answers", runs.ANSWERS, 0, dumps({"kind": runs.ANSWERS}), b"nothing")])
    book.close()
    said = run("maintain", project, *COVERS)
    assert f"The answers in {project} are not used: they are damaged, or of another run." in said.stderr
    assert "2 kept" in said.stdout


def test_a_changed_byte_is_told(project: Path) -> None:
    connection = sqlite3.connect(project)
    connection.execute("UPDATE answers SET data = zeroblob(10) WHERE id = ?", (runs.RUN,))
    connection.commit()
    connection.close()
    assert "is damaged" in error_of("maintain", project, *COVERS)


JUNK: st.SearchStrategy[Any] = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**63), 2**63), st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from(["", "x", "out", 10**400, [], {}, [[]], [1e300] * 6, [-1, 7]]),
)  # fmt: skip


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=st.integers(0, 4000), junk=JUNK)
def test_any_value_in_any_place_of_a_run_is_told_or_compared(made: Path, at: int, junk: Any) -> None:
    book = book_of(made / "engine.feelproj")
    found = runs.run_of(book)
    book.close()
    assert found is not None
    left = [at]

    def changed(value: Any) -> Any:
        left[0] -= 1
        if left[0] == 0:
            return junk
        if isinstance(value, dict):
            return {key: changed(each) for key, each in value.items()}
        return [changed(each) for each in value] if isinstance(value, list) else value

    data = {name: changed(value) for name, value in found[0].items()}

    class Other:
        path = "a.feelproj"

        def answer(self, key: str) -> tuple[Any, bytes | None] | None:
            return ({}, zlib.compress(dumps(data).encode())) if key == runs.RUN else ({}, found[1])

    book_like: Any = Other()
    try:
        before = last_run(book_like)
        assert before is not None
        feeler.maintain(feeler.open_scene(made / "engine.feeler"), ["s0/cover"], previous=before, threads=1)
    except FeelerError:
        return


# ---- beside the workbench ----


def test_the_workbench_leaves_a_run_as_it_is(tmp_path: Path) -> None:
    """As versions do that know nothing of runs: they touch the answers of cards alone."""
    world = stand()
    scene = feeler.Scene(world, threads=1)
    book = open_or_make(tmp_path / "a.feelproj")
    session = Session(project=book, has_threads=False)
    session.open(world, scene, None, name="stand.glb")
    run_before = feeler.maintain(scene, ["*/peg"], seconds=5.0, threads=1)
    assert keep_run(book, run_before, contents_of(world)) == []
    session.close()
    larger = feeler.Mockup(world.vertices * 1.5, world.faces, world.part_of_face, part_paths=world.part_paths)
    for of in (world, larger):
        session = Session(project=open_or_make(tmp_path / "a.feelproj"), has_threads=False)
        session.open(of, feeler.Scene(of, threads=1), None, name="stand.glb")
        session.command("hide", {"parts": [0]})
        if of is larger:
            session.command("accept_revision", {})
        session.close()
    assert kept(tmp_path / "a.feelproj").to_dict() == run_before.to_dict()
