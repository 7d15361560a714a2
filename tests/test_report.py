"""One report of a project: its content, its pages for strangers' texts, and what Ctrl-C and damage leave."""

from __future__ import annotations

import datetime
import html
import io
import json
import re
import shutil
import sqlite3
import zipfile
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from report_project import BOLD, PEG, WAIT_S, fill, loaded, mockup, project
from workbench_scene import Bench

import feeler
from feeler.cli.projects import Work, keep_work
from feeler.errors import FeelerError, LoadError, WriteError
from feeler.io import write_glb
from feeler.project import layout
from feeler.project.book import open_or_make
from feeler.workbench.document import motion
from feeler.workbench.document.cards import line_setting
from feeler.workbench.report import as_html, media
from feeler.workbench.report.as_json import report_json
from feeler.workbench.report.as_xlsx import xlsx_bytes
from feeler.workbench.report.content import report_of
from feeler.workbench.report.drawing import Drawing
from feeler.workbench.report.source import Source, of_book
from feeler.workbench.report.values import Media, PairPlace, Report
from feeler.workbench.session.record import digest
from feeler.workbench.session.session import Session

WHEN = datetime.datetime(2026, 1, 2, 3, 4, tzinfo=datetime.timezone.utc)
HOSTILE = [BOLD, "</script><script>alert(1)</script>", "=cmd|' /C calc'!A0", "@x", "\u202egnp.exe", "\0\ud800\x07"]


@pytest.fixture(scope="module")
def there(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return project(tmp_path_factory.mktemp("project"))


@pytest.fixture(scope="module")
def world(there: Path) -> feeler.Mockup:
    return feeler.load_mockup(there.with_name("stand.glb"))


def source_of(path: Path, of: feeler.Mockup | None = None) -> Source:
    book = open_or_make(path, read_only=True)
    try:
        return of_book(book, of, content="" if of is None else digest(of))
    finally:
        book.close()


class Tags(HTMLParser):
    """The elements and attributes of a page, and its text outside of scripts."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_a_report_has_everything_that_was_done(there: Path) -> None:
    of = feeler.load_mockup(there.with_name("stand.glb"))
    source = source_of(there, of)
    report = report_of(source, WHEN)
    assert (report.title, report.project, report.made) == ("stand.glb", "stand.feelproj", "2026-01-02 03:04 UTC")
    assert not report.stale and report.parts == 6 and report.sources == ("stand.glb",)
    status = {row.name: row.status for row in report.requirements}
    assert status == {"clear drawn so": "violated", "far": "holds", "none": "unknown", "later": "not checked"}
    violated = report.requirements[0]
    assert violated.path_a and violated.path_b and violated.point and "deep in" in violated.sentence
    assert [row.is_moved for row in report.requirements] == [True, True, True, False], "the peg was taken out since"
    reviewed = [row for row in report.findings if row.status == "reviewed"]
    assert [(row.note, len(row.history)) for row in reviewed] == [("drawn so", 1)]
    assert [row.status for row in report.findings if not row.is_touching][-1] == "reviewed", "open ones come first"
    assert [row.kind for row in report.questions] == ["removal", "order", "access", "way"]
    way = report.questions[0].ways[0]
    assert way.paths == ("stand/stand/peg",) and way.length > 0.1 and len(way.poses) > 1
    assert way.gaps and all(0.0 <= share <= 1.0 for share, _ in way.gaps)
    (step,) = report.steps
    assert step.paths == ("stand/stand/peg",) and step.length == pytest.approx(way.length)
    asked = report.questions[3]
    assert step.checked == asked.sentence != "" and not asked.is_moved, "its way was checked as it is"
    assert asked.ways[0].starts == {} and report.questions[0].is_moved


def test_the_limits_of_a_check_are_figures(there: Path) -> None:
    check = run_json("report", there)["check"]
    assert isinstance(check["clearance"], float)
    assert check["contact"] == "chord" or isinstance(check["contact"], float), "no length with a unit"
    source = source_of(there, feeler.load_mockup(there.with_name("stand.glb")))
    findings = source.document.findings
    assert findings is not None and findings.check is not None and check["is_moved"], "the peg was taken out since"
    table = replace(findings.table, facts=replace(findings.table.facts, contact=0.001))
    # Of a check on the command line: all parts were in their places.
    document = replace(source.document, findings=replace(findings, check=None, table=table))
    found = report_of(replace(source, document=document), WHEN).check
    assert found is not None and found.contact == 0.001 and found.is_moved


def test_a_check_says_which_parts_it_left_out(there: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(there, tmp_path / "stand.feelproj"))
    of = feeler.load_mockup(there.with_name("stand.glb"))
    session = Session(project=open_or_make(path), has_threads=False)
    session.open(of, feeler.Scene(of, threads=1), None, tools=[feeler.sample_tool("wrench")], name="stand.glb")
    assert session.current.out == (PEG,)
    taken = session.job("clash", {}).result(WAIT_S)
    session.command("findings_take", {"key": taken["key"]})
    results = session.job("verify", {}).result(WAIT_S)
    session.command("requirements_checked", {"results": results})
    assert session._saver is not None and session._saver.wait(WAIT_S)
    session.close()
    source = source_of(path, of)
    report = report_of(source, WHEN)
    said = report_json(report)
    peg = {"count": 1, "paths": ["stand/stand/peg"]}
    assert [each["out"] for each in (said["check"], *said["requirements"])] == [peg] * 5, "all four were checked"
    assert not said["check"]["is_moved"] and said["check"]["in_hand"] == {"count": 0, "paths": []}
    sentence = "Left out of this check: stand/stand/peg (out)."
    assert as_html.html_page(report, Media()).decode().count(sentence) == 5
    assert sheets_of(report).count(sentence) == 5
    # Parts in the hand did not count either, wherever they lay; others lay elsewhere.
    findings = source.document.findings
    assert findings is not None and findings.check is not None
    here = motion.row(np.eye(4))
    check = replace(findings.check, out=(0, 1, 2, 3), gripped=(5,), moved={4: here, 5: here})
    document = replace(source.document, findings=replace(findings, check=check), absent=(PEG,))
    told = report_of(replace(source, document=document), WHEN)
    paths = of.part_paths
    assert told.check is not None
    assert str(told.check.layout) == (
        f"Left out of this check: {', '.join(paths[:3])} and 1 more (out), {paths[5]} (in the hand). "
        f"Moved at this check: {paths[4]}."
    )
    assert told.notes == (*report.notes, "The project is without 1 part: stand/stand/peg.")


def sheets_of(report: Report) -> str:
    """All text of the workbook."""
    with zipfile.ZipFile(io.BytesIO(xlsx_bytes(report))) as book:
        return "".join(book.read(each).decode() for each in book.namelist() if each.startswith("xl/worksheets/sheet"))


def test_a_full_disk_leaves_no_half_of_the_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from feeler import atomic
    from feeler.cli.report import _write_files

    real, folder = atomic.atomic_file, tmp_path / "r-files"

    def full(path: Path, *endings: str) -> Any:
        if Path(path).name == "question-2.glb":
            raise WriteError("no room is left")
        return real(path, *endings)

    monkeypatch.setattr(atomic, "atomic_file", full)
    files = {"question-1.glb": b"1", "question-2.glb": b"2"}
    with pytest.raises(WriteError, match="no room"):
        _write_files(folder, files)
    assert not folder.exists()
    folder.mkdir()
    (folder / "mine.txt").write_text("kept")
    with pytest.raises(WriteError, match="no room"):
        _write_files(folder, files)
    assert [each.name for each in folder.iterdir()] == ["mine.txt"]


def test_the_workbook_has_pictures_of_findings(there: Path, tmp_path: Path) -> None:
    out = tmp_path / "r.xlsx"
    run("report", there, "--xlsx", out, "--pictures", "2")
    with zipfile.ZipFile(out) as book:
        pictures = [name for name in book.namelist() if name.startswith("xl/media/")]
        assert len(pictures) == 2 and all(book.read(name).startswith(b"\x89PNG") for name in pictures)
        place = book.read("xl/drawings/drawing1.xml").decode()
        rows = sorted(
            int(row) for row in re.findall(r"<xdr:from><xdr:col>18</xdr:col>.*?<xdr:row>(\d+)</xdr:row>", place)
        )
    shown = media.pictured(report_of(source_of(there, feeler.load_mockup(there.with_name("stand.glb")))).findings, 2)
    all_rows = [row.id for row in report_of(source_of(there)).findings]
    assert rows == sorted(1 + all_rows.index(row.id) for row in shown), "beside their findings"
    plain = xlsx_bytes(report_of(source_of(there)))
    with zipfile.ZipFile(io.BytesIO(plain)) as book:
        assert not any("media" in name for name in book.namelist())


def test_pictures_and_films(there: Path, tmp_path: Path) -> None:
    of = feeler.load_mockup(there.with_name("stand.glb"))
    source = source_of(there, of)
    report = report_of(source, WHEN)
    made = media.media_of(source, report, 2)
    findings = [key for key in made.pictures if key.startswith("finding-")]
    assert len(findings) == 2 and not made.is_partial and not made.left_out
    assert len(made.pictures["way-1-1"]) == 6 and len(made.pictures["way-2-1"]) == 2
    frames = made.pictures["way-1-1"]
    assert len(set(frames)) == 6 and all(frame.startswith(b"\x89PNG") for frame in frames), "the part moves"
    assert set(made.films) == {"question-1", "question-2", "question-4", "sequence"}
    (tmp_path / "film.glb").write_bytes(made.films["question-1"])
    document = json.loads(
        made.films["question-1"][20:].split(b"\0")[0].decode("utf-8", "replace").rpartition("}")[0] + "}"
    )
    assert document["animations"], "it is animated"
    assert feeler.load_mockup(tmp_path / "film.glb").part_count > 1
    page = as_html.html_page(report, made, "report-files").decode()
    links = [attrs["href"] for tag, attrs in Tags(page).tags if tag == "a" and attrs.get("download")]
    assert links == [f"report-files/{name}.glb" for name in ("question-1", "question-2", "question-4", "sequence")]
    alone = as_html.html_page(report, made).decode()
    assert alone.count('href="data:model/gltf-binary;base64,') == 4
    assert [*as_html.files_of(made)] == ["question-1.glb", "question-2.glb", "question-4.glb", "sequence.glb"]


def test_parts_are_drawn_where_they_lay_at_the_check(there: Path, world: feeler.Mockup) -> None:
    source = source_of(there, world)
    report = report_of(source, WHEN)
    wrong = report.requirements[0]
    assert wrong.place is not None
    home = media.media_of(source, report, 1).pictures["requirement-1"]
    shifted = (1.0, 0.0, 0.0, 0.05, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    asked, *rest = source.document.requirements
    assert asked.verdict is not None
    for moved, is_same in (({wrong.place.a: shifted}, False), ({99: shifted}, True), ({wrong.place.a: (1.0,)}, None)):
        verdict = replace(asked.verdict, moved=moved)
        document = replace(source.document, requirements=(replace(asked, verdict=verdict), *rest))
        made = media.media_of(replace(source, document=document), report, 1)
        drawn = made.pictures.get("requirement-1")
        assert (drawn is None and made.left_out != []) if is_same is None else ((drawn == home) == is_same)


def test_a_film_that_would_make_the_page_too_large_is_left_out(there: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report = report_of(source_of(there), WHEN)
    monkeypatch.setattr(as_html, "MOST_EMBEDDED", 10)
    page = as_html.html_page(report, Media(films={"question-1": b"12345678901", "sequence": b"1234567890"})).decode()
    assert page.count("data:model/gltf-binary") == 1 and "left out" in page


def test_the_first_findings_have_pictures_the_worst_of_each_group_first(there: Path) -> None:
    rows = report_of(source_of(there), WHEN).findings
    assert all(row.place is not None for row in rows)
    row = next(row for row in rows if not row.is_touching)
    grouped = [replace(row, id=str(number), group="ABABCC"[number]) for number in range(6)]
    assert [each.id for each in media.pictured(grouped, 3)] == ["0", "1", "4"]
    assert [each.id for each in media.pictured(grouped, 4)] == ["0", "1", "2", "4"], "in the order of the list"
    assert media.pictured([replace(row, place=None)], 3) == []
    assert media.pictured(rows, 0) == [] and media.pictured(rows, 10**6) == list(rows)
    touching = [row for row in rows if row.is_touching]
    assert touching and not any(row.is_touching for row in media.pictured(rows, len(rows) - len(touching)))


@pytest.mark.parametrize("text", ["".join(HOSTILE[:2]), HOSTILE[2], "".join(HOSTILE[3:])])
def test_texts_of_strangers_are_shown_as_text(tmp_path: Path, text: str) -> None:
    name = text.replace("/", "|").replace("\0", "").replace("\ud800", "")
    of = mockup({"stand/block": f"stand/{name}"})
    path = project(tmp_path, of, text.replace("\ud800", "").replace("\0", "") or "x")
    source = source_of(path)
    report = report_of(source, WHEN)
    page = as_html.html_page(report, Media()).decode()
    found = Tags(page)
    tags = {tag for tag, _ in found.tags}
    assert "b" in tags and not any(key.startswith("on") for _, attrs in found.tags for key in attrs)
    assert [tag for tag, _ in found.tags].count("script") == 1
    policy = next(attrs["content"] for tag, attrs in found.tags if attrs.get("http-equiv"))
    assert policy is not None and policy.startswith("default-src 'none'") and "unsafe" not in policy
    shown = "".join(found.words)
    assert html.unescape(name)[:6] in shown
    with zipfile.ZipFile(io.BytesIO(xlsx_bytes(report))) as book:
        sheets = [book.read(each).decode() for each in book.namelist() if each.startswith("xl/worksheets/sheet")]
    assert len(sheets) == 8 and not any("<f>" in sheet for sheet in sheets), "no cell is a formula"


def test_a_newer_revision_makes_results_out_of_date(there: Path, tmp_path: Path) -> None:
    raised = loaded(tmp_path, mockup(is_raised=True))
    report = report_of(source_of(there, raised), WHEN)
    assert report.stale.changed == ("stand/stand/block",)
    rows = {row.name: row.stale for row in report.requirements}
    assert rows["clear drawn so"] == "block changed" and rows["far"] == "" == rows["later"]
    assert all(("block changed" in row.stale) == ("stand/stand/block" in (row.a, row.b)) for row in report.findings)
    assert report.questions and all(row.stale and not row.is_moved for row in report.questions)
    assert not any(step.checked for step in report.steps), "of the mock-up before"
    page = as_html.html_page(report, Media()).decode()
    assert "The mock-up has changed since" in page and page.count("Out of date: block changed.") >= 2


def without_post() -> feeler.Mockup:
    """The mock-up without its left post: the parts after it have other numbers."""
    whole = mockup()
    kept = [0, 2, 3, 4, 5]
    number = {old: new for new, old in enumerate(kept)}
    chosen = np.isin(whole.part_of_face, kept)
    return feeler.Mockup(
        whole.vertices,
        whole.faces[chosen],
        np.array([number[part] for part in whole.part_of_face[chosen].tolist()]),
        [whole.part_names[part] for part in kept],
        part_paths=[whole.part_paths[part] for part in kept],
    )


def test_parts_with_other_numbers_leave_out_the_details_of_answers(there: Path, tmp_path: Path) -> None:
    fewer = without_post()
    report = report_of(source_of(there, loaded(tmp_path, fewer)), WHEN)
    assert report.stale.gone == ("stand/stand/posts/left",)
    assert [len(row.ways) for row in report.questions] == [0, 0, 0, 0] and "other numbers" in report.notes[0]
    clear, far, *_ = report.requirements
    assert (clear.status, clear.place) == ("not checked", None), "a part of its verdict is gone"
    assert (far.status, far.stale) == ("unknown", "")  # it has no post
    assert any(finding.stale == "a part is gone" for finding in report.findings)


def test_answers_of_other_numbers_do_not_come_back(there: Path, tmp_path: Path) -> None:
    """They would name other parts when the newer mock-up is opened the second time."""
    path = tmp_path / "revised.feelproj"
    path.write_bytes(there.read_bytes())
    fewer = loaded(tmp_path, without_post())
    for _ in range(2):
        session = Session(project=open_or_make(path), has_threads=False)
        session.open(fewer, feeler.Scene(fewer, threads=1), None, name="stand.glb")
        assert session._saver is not None and session._saver.wait(WAIT_S)
        assert len(session.current.cards) == 4 and session._cards.ways == {}
        session.close()
    report = report_of(source_of(path, fewer), WHEN)
    assert [len(row.ways) for row in report.questions] == [0, 0, 0, 0]


def test_a_report_of_the_document_is_that_of_its_project(there: Path) -> None:
    bench = Bench(mockup=mockup())
    fill(bench.session)
    job = bench.session.job("report", {"pictures": 1}).result(WAIT_S)
    assert job["name"] == "report.html"
    page = bench.session.export("report.html").decode()
    assert job["bytes"] == len(page.encode())
    assert page.count("data:model/gltf-binary;base64,") == 4 and "Work steps" in page and "clear drawn so" in page


def test_a_report_in_the_page_can_be_cancelled() -> None:
    bench = Bench(mockup=mockup())
    fill(bench.session)
    stages: list[str] = []
    jobs: list[Any] = []

    def hear(_share: float, stage: str) -> None:
        stages.append(stage)
        if stage.startswith("picture"):
            jobs[0].cancel()

    jobs.append(bench.session.job("report", {}, hear))
    with pytest.raises(FeelerError):
        jobs[0].result(WAIT_S)
    assert sum(stage.startswith("picture") for stage in stages) <= 2


def test_ctrl_c_leaves_a_report_with_the_pictures_so_far(there: Path) -> None:
    source = source_of(there, feeler.load_mockup(there.with_name("stand.glb")))
    report = report_of(source, WHEN)

    def stop(_share: float, stage: str) -> None:
        if stage.startswith("picture 3"):
            raise KeyboardInterrupt

    made = media.media_of(source, report, 5, stop)
    assert made.is_partial and len(made.pictures) == 2
    assert "This report was stopped" in as_html.html_page(report, made).decode()


def test_ctrl_c_in_the_command_writes_what_is_there(
    there: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = list[object]()

    def pair(self: Drawing, *given: object) -> bytes:
        drawn.append(given)
        if len(drawn) == 2:
            raise KeyboardInterrupt
        return b"\x89PNG" + bytes(30)

    monkeypatch.setattr(Drawing, "pair", pair)
    done = run("report", there, "--html", tmp_path / "r.html", "--xlsx", tmp_path / "r.xlsx", code=130)
    assert "interrupted: the report has the pictures made so far" in done.stderr
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert page.count("<img") == 1 and "This report was stopped" in page and zipfile.is_zipfile(tmp_path / "r.xlsx")


def test_json_has_the_documented_fields(there: Path) -> None:
    report = report_of(source_of(there), WHEN)
    found = json.loads(json.dumps(report_json(report)))
    page = (Path(__file__).parent.parent / "docs" / "report.md").read_text(encoding="utf-8")
    table = page.partition("## JSON")[2].partition("The sheets of")[0]
    named = set(re.findall(r"`(\w+)`", table))

    def keys(value: object) -> set[str]:
        if isinstance(value, list):
            return set().union(*map(keys, value)) if value else set()
        if not isinstance(value, dict):
            return set()
        return set(value).union(*(keys(each) for key, each in value.items() if key not in ("hidden", "renamed")))

    assert keys(found) - {"name", "figure"} <= named
    assert found["version"] == 1 and found["steps"][0]["parts"] == ["stand/stand/peg"]


# ---- the command ----


def test_the_command_writes_page_workbook_and_files(there: Path, tmp_path: Path) -> None:
    out = tmp_path / "a report.html"
    (tmp_path / "a report-files").mkdir()
    for name in ("question-99.glb", "mine.txt"):
        (tmp_path / "a report-files" / name).write_text("of before")
    done = run("report", there, "--html", out, "--xlsx", tmp_path / "r.xlsx", "--pictures", "1")
    assert (
        "2 requirements" not in done.stdout
        and "4 requirements" in done.stdout
        and "1 requirement violated" in done.stdout
    )
    files = sorted(each.name for each in (tmp_path / "a report-files").iterdir())
    assert files == ["mine.txt", "mock-up.html", "question-1.glb", "question-2.glb", "question-4.glb", "sequence.glb"]
    page = out.read_text(encoding="utf-8")
    assert 'href="a%20report-files/mock-up.html"' in page and 'href="a%20report-files/sequence.glb"' in page
    assert zipfile.is_zipfile(tmp_path / "r.xlsx")
    told = run_json("report", there)
    assert told["mockup"]["files"] == ["stand.glb"] and told["written"] == {} and len(told["findings"]) > 2
    run("report", there, "--html", tmp_path / "one.html", "--one-file", "--pictures", "0")
    assert not (tmp_path / "one-files").exists() and "data:model/gltf-binary" in (tmp_path / "one.html").read_text()


def test_a_project_that_is_open_elsewhere_is_read(there: Path) -> None:
    with feeler.open_project(there):
        assert run_json("report", there)["project"] == "stand.feelproj"


def test_without_the_mock_up_the_report_has_no_pictures_and_says_so(tmp_path: Path) -> None:
    path = project(tmp_path)
    (tmp_path / "stand.glb").unlink()
    done = run("report", path, "--html", tmp_path / "r.html")
    assert "no pictures" in done.stderr
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "has no pictures and no films" in page and "<img" not in page and "stand/stand/peg" not in page
    assert "peg" in page and not (tmp_path / "r-files").exists()
    other = tmp_path / "other"
    other.mkdir()
    write_glb(other / "stand.glb", mockup(is_raised=True))
    assert run_json("report", path, other / "stand.glb")["changes"]["changed"] == ["stand/stand/block"]


def test_the_tool_of_the_project_may_be_gone(tmp_path: Path) -> None:
    path = project(tmp_path)
    book = open_or_make(path)
    keep_work(book, Work([str(tmp_path / "stand.glb")], str(tmp_path / "gone.stl"), "mm", without=["*sheet*"]))
    book.close()
    done = run("report", path, "--html", tmp_path / "r.html", "--pictures", "1")
    assert done.stderr == "" and "pictures" in done.stdout


def test_words_that_cannot_be(there: Path, tmp_path: Path) -> None:
    assert "stand.glb is no project: give a project" in error_of("report", tmp_path / "stand.glb")
    assert "does not exist" in error_of("report", tmp_path / "no.feelproj")
    assert "--one-file" in error_of("report", there, "--one-file")
    assert "must end in .html" in error_of("report", there, "--html", tmp_path / "r.pdf")
    assert "about another mock-up" in error_of("report", there, "sample:differential:10000")
    (tmp_path / "r-files").write_text("a file")
    assert "is not a folder" in error_of("report", there, "--html", tmp_path / "r.html")
    feeler.open_project(tmp_path / "new.feelproj", mockup()).close()
    assert run_json("report", tmp_path / "new.feelproj")["questions"] == []


# ---- maintenance ----


def test_the_last_run_of_maintain_is_listed(there: Path, tmp_path: Path) -> None:
    report = report_of(source_of(there, feeler.load_mockup(there.with_name("stand.glb"))), WHEN)
    run_of = report.maintenance
    assert run_of is not None and run_of.sentence == "2 of 2 come out" and not run_of.stale and not run_of.is_partial
    peg = run_of.rows[0]
    assert (peg.name, peg.paths, peg.state) == ("*/peg", ("stand/stand/peg",), "out")
    assert peg.seconds and peg.spread and peg.sight is None and peg.reach_deg is None
    found = Tags(as_html.html_page(report, Media()).decode())
    assert "Maintenance" in found.words and "*/" in found.words
    with zipfile.ZipFile(io.BytesIO(xlsx_bytes(report))) as book:
        assert "maintenance" in book.read("xl/workbook.xml").decode()
        assert "*/peg" in book.read("xl/worksheets/sheet8.xml").decode()
    said = report_json(report)["maintenance"]
    assert said["rows"][0]["seconds"] == peg.seconds and said["stale"] is None


def test_a_run_of_another_revision_is_out_of_date(there: Path, tmp_path: Path) -> None:
    def since(of: feeler.Mockup | None) -> str:
        run_of = report_of(source_of(there, of), WHEN).maintenance
        assert run_of is not None
        return run_of.stale

    assert since(loaded(tmp_path, mockup(is_raised=True))) == "block changed"
    assert since(loaded(tmp_path, without_post())) == "left gone"
    assert since(loaded(tmp_path, mockup({"stand/block": "stand/lump"}))) == "", "names do not matter"
    assert since(None) == "", "nobody knows"


def test_a_project_without_a_run_has_no_such_section(tmp_path: Path) -> None:
    feeler.open_project(tmp_path / "new.feelproj", mockup()).close()
    report = report_of(source_of(tmp_path / "new.feelproj"), WHEN)
    assert report.maintenance is None and report_json(report)["maintenance"] is None
    assert "Maintenance" not in Tags(as_html.html_page(report, Media()).decode()).words


def test_the_report_of_the_page_has_the_run_of_its_project(there: Path, world: feeler.Mockup, tmp_path: Path) -> None:
    path = tmp_path / "copy.feelproj"
    path.write_bytes(there.read_bytes())
    session = Session(project=open_or_make(path), has_threads=False)
    session.open(world, feeler.Scene(world, threads=1), None, name="stand.glb")
    session.job("report", {"pictures": 0}).result(WAIT_S)
    page = session.export("report.html").decode()
    session.close()
    assert "2 of 2 come out" in page and "Out of date" not in page.partition("id=maintenance")[2].partition("<h2")[0]


@pytest.mark.parametrize("text", HOSTILE[:5])
def test_texts_of_a_run_are_shown_as_text(there: Path, tmp_path: Path, text: str) -> None:
    def changed(table: str, value: Any) -> Any:
        if table != "answers" or value.get("kind") != "maintain":
            return value
        texts = {name: text for name in ("name", "change", "why", "renamed_from")}
        rows = [{**row, **texts, "paths": [text], "tools": [text]} for row in value["rows"]]
        return {**value, "said": text, "at": text, "rows": rows, "contents": {text: "x"}}

    report = report_of(source_of(_changed(there, tmp_path, changed), feeler.load_mockup(there.with_name("stand.glb"))))
    assert report.maintenance is not None and report.maintenance.rows[0].name == text
    page = as_html.html_page(report, Media()).decode()
    assert page.count("<script") == 1 and "onclick=alert(1)>" not in page
    with zipfile.ZipFile(io.BytesIO(xlsx_bytes(report))) as book:
        assert not any(b"<f>" in book.read(each) for each in book.namelist() if "/sheet" in each)


# ---- projects of strangers ----


def test_huge_texts_are_cut(there: Path, tmp_path: Path) -> None:
    path = _changed(there, tmp_path, lambda table, value: _with(value, name="N" * 90_000, note="n" * 90_000))
    report = report_of(source_of(path), WHEN)
    page = as_html.html_page(report, Media())
    assert report.requirements and len(page) < 500_000 and b"NNN" in page


def test_ten_thousand_findings_are_all_in_the_list(there: Path, tmp_path: Path) -> None:
    path = tmp_path / "many.feelproj"
    path.write_bytes(there.read_bytes())
    with feeler.open_project(path) as opened:
        book = opened._book
        row = opened.findings()[0]
        book.write(book.findings_changes([{**row, "id": f"id {i}", "group": f"g{i % 300}"} for i in range(10_000)]))
    source = source_of(path, feeler.load_mockup(there.with_name("stand.glb")))
    report = report_of(source, WHEN)
    made = media.media_of(source, report, 3)
    page = as_html.html_page(report, made).decode()
    assert sum(key.startswith("finding-") for key in made.pictures) == 3
    assert len(re.findall(r'<tr id="f\d+">', page)) == 10_000


def _with(value: Any, **texts: str) -> Any:
    """The value with other texts where it has these fields."""
    if not isinstance(value, dict):
        return value
    return {key: texts.get(key, each) if isinstance(each, str) else each for key, each in value.items()}


def _changed(there: Path, folder: Path, change: Any) -> Path:
    """A copy of a project with changed values, and right digests: as somebody else may make it."""
    path = folder / "changed.feelproj"
    path.write_bytes(there.read_bytes())
    connection = sqlite3.connect(path)
    for table in layout.TABLES:
        number = total = 0
        for key, place, value, data in connection.execute(f"SELECT id, place, value, data FROM {table}").fetchall():
            text = json.dumps(change(table, json.loads(value)))
            seal = layout.seal_of(table, key, place, text, data)
            connection.execute(f"UPDATE {table} SET value = ?, seal = ? WHERE id = ?", (text, seal, key))
            number, total = number + 1, (total + seal) % layout.MODULUS
        connection.execute("UPDATE sums SET number = ?, seal = ? WHERE id = ?", (number, total, table))
    connection.commit()
    connection.close()
    return path


def test_missing_tables_are_told(there: Path, tmp_path: Path) -> None:
    path = tmp_path / "broken.feelproj"
    for table in ("cards", "findings", "sums"):
        path.write_bytes(there.read_bytes())
        connection = sqlite3.connect(path)
        connection.execute(f"DROP TABLE {table}")
        connection.commit()
        connection.close()
        with pytest.raises(LoadError, match="damaged"):
            source_of(path)


JUNK: st.SearchStrategy[Any] = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**63), 2**63), st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([*HOSTILE[:5], "x" * 10_000, "holds", "violated", "resolved", [], {}, [[]], [1e300] * 3, [-1, 7]]),
)  # fmt: skip


FUZZED = ["facts", "document", "sequence", "cards", "requirements", "findings", "marks", "history", "answers"]
FUZZED += ["parts", "gone"]


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_values_are_told_or_shown(
    there: Path, world: feeler.Mockup, tmp_path: Path, data: st.DataObject
) -> None:
    """Any value in any place of any row: a typed error, or a page without elements of strangers."""
    table = data.draw(st.sampled_from(FUZZED))
    at, junk = data.draw(st.integers(0, 400)), data.draw(JUNK)
    left = [at]

    def changed(value: Any) -> Any:
        """The value with junk in one place, chosen by a count of all places."""
        left[0] -= 1
        if left[0] == 0:
            return junk
        if isinstance(value, dict):
            return {key: changed(each) for key, each in value.items()}
        return [changed(each) for each in value] if isinstance(value, list) else value

    path = _changed(there, tmp_path, lambda each, value: changed(value) if each == table else value)
    try:
        source = source_of(path, world)
        report = report_of(source, WHEN)
        made = media.media_of(source, report, 1) if at % 10 == 0 else Media()
        page = as_html.html_page(report, made).decode()
        json.dumps(report_json(report), allow_nan=False)
        if at % 7 == 0:
            xlsx_bytes(report)
    except FeelerError:
        return
    assert page.count("<script") == 1 and "onclick=alert(1)>" not in page


def test_a_question_says_of_which_mock_up_it_is(there: Path) -> None:
    report = report_of(source_of(there))
    settings = ("as loaded", line_setting(0), line_setting(2))
    asked = tuple(replace(report.questions[0], setting=each) for each in settings)
    page = as_html.html_page(replace(report, questions=asked), Media()).decode()
    assert re.findall("About the mock-up[^<]*", page) == [
        "About the mock-up: as loaded.",
        "About the mock-up: before the first step of the sequence.",
        "About the mock-up: after 2 steps of the sequence.",
    ]


def test_columns_of_a_page_are_never_wider_than_a_narrow_screen(there: Path) -> None:
    page = as_html.html_page(report_of(source_of(there), WHEN), Media()).decode()
    assert "minmax(min(" in page and not re.findall(r"minmax\([1-9]\d*px", page)


def test_the_head_says_what_it_counts(there: Path) -> None:
    """Contacts are no findings that are open; findings without a picture are counted with the contacts among them."""
    report = report_of(source_of(there), WHEN)
    one = report.findings[0]
    rows = tuple(
        replace(one, id=f"f{number}", status=status, is_touching=is_touching)
        for number, (status, is_touching) in enumerate(
            [("new", False), ("active", False), ("approved", False), ("new", True), ("new", True), ("new", True)]
        )
    )
    png = Drawing(mockup()).pair(PairPlace(0, 1, (0.0,) * 3, (0.0,) * 3, (0.0,) * 3))
    made = Media(pictures={"finding-f0": [png], "finding-f3": [png]})
    page = as_html.html_page(replace(report, findings=rows), made).decode()
    assert "<b>2 open</b><span>of 3 findings, 3 contacts not counted</span>" in page
    assert "4 more findings without a picture, 2 contacts among them: see the list." in page
