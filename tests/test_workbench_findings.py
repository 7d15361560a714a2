"""Findings in the workbench: checked there, worked on, and written."""

from __future__ import annotations

import base64
import gzip
import json
import re
import threading
import zipfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, Bench, at, cube, sent, stand

import feeler
from feeler.errors import WorkbenchError
from feeler.workbench.document import finding_rules, patient_json
from feeler.workbench.document.finding_table import FindingTable
from feeler.workbench.document.findings import findings_of_clashes, restored, saved
from feeler.workbench.document.frames import unpack
from feeler.workbench.document.protocol import SavedPage
from feeler.workbench.document.protocol_findings import FindingRows
from feeler.workbench.session.finding_jobs import threads
from feeler.workbench.session.jobs import JobCancelledError
from feeler.workbench.session.record import read_record
from feeler.workbench.session.replaying import replay

WAIT_S = 120.0


def sunk() -> feeler.Mockup:
    """The stand with its peg 10 mm in the plate, and its left post 1 mm above it."""
    mockup = stand()
    vertices = np.array(mockup.vertices)
    vertices[24:32, 2] -= 0.01
    vertices[8:16, 2] += 0.001
    return feeler.Mockup(vertices, mockup.faces, mockup.part_of_face, mockup.part_names, part_paths=mockup.part_paths)


def checked(bench: Bench, **args: Any) -> dict[str, Any]:
    """Runs a check and opens its findings."""
    taken = bench.session.job("clash", args).result(WAIT_S)
    bench.command("findings_take", key=taken["key"])
    return dict(taken)


def table_of(bench: Bench) -> FindingTable:
    assert bench.session.current.findings is not None
    return bench.session.current.findings.table


def pairs(bench: Bench) -> dict[tuple[str, str], str]:
    table = table_of(bench)
    rows = [table.row_json(row) for row in range(len(table))]
    return {tuple(sorted((each["a"], each["b"]))): each["verdict"] for each in rows}  # type: ignore[misc]


PLATE_PEG = (PATHS[PEG], PATHS[PLATE])
PLATE_LEFT = (PATHS[PLATE], PATHS[LEFT])
PLATE_RIGHT = (PATHS[PLATE], PATHS[RIGHT])


def test_a_check_is_that_of_the_library_and_one_step_of_undo() -> None:
    bench = Bench(cube(), mockup=sunk())
    taken = checked(bench)
    expected = feeler.clash(sunk())
    assert taken["count"] == len(expected) == 3 and table_of(bench).ids == expected.ids
    assert pairs(bench) == {PLATE_PEG: "clash", PLATE_LEFT: "clearance", PLATE_RIGHT: "contact"}
    check = bench.document["findings"]["check"]
    assert (check["clearance"], check["contact"], check["of"], check["moved"]) == (0.002, 0.0, None, {})
    assert bench.document["findings"]["counts"] == {"clash": 1, "clearance": 1, "contact": 1}
    bench.command("undo")
    assert bench.document["findings"] is None
    bench.command("redo")
    assert bench.document["findings"]["version"] == taken["key"]


def test_parts_count_where_they_are_and_not_where_they_were_taken_out_of() -> None:
    bench = Bench(mockup=sunk())
    bench.command("hide", parts=[PEG])
    checked(bench)
    assert PLATE_PEG in pairs(bench), "hidden parts count"
    bench.command("grip", parts=[PEG])
    checked(bench)
    assert PLATE_PEG not in pairs(bench), "a part in the hand does not"
    bench.command("set_mode", mode="pass")
    bench.command("place", pose=list((at(0, 0, 0.02) @ bench.pose).ravel()))
    bench.command("release")
    assert bench.document["out"] == [] and str(PEG) in bench.document["moved"]
    checked(bench)
    assert PLATE_PEG not in pairs(bench), "it lies 10 mm above the plate now"
    assert bench.document["findings"]["check"]["moved"].keys() == {str(PEG)}
    bench.command("clash_settings", clearance=0.011)
    checked(bench)
    table = table_of(bench)
    rows = [table.row_json(row) for row in range(len(table))]
    (gap,) = (each["gap"] for each in rows if tuple(sorted((each["a"], each["b"]))) == PLATE_PEG)
    assert gap == pytest.approx(0.01)
    bench.command("grip", parts=[PEG])
    bench.command("place", pose=list((at(0, 0, 3.0) @ bench.pose).ravel()))
    bench.command("release")
    assert bench.document["out"] == [PEG]
    checked(bench)
    assert not any(PATHS[PEG] in pair for pair in pairs(bench)), "a part taken out"


def test_only_pairs_with_some_parts_are_checked() -> None:
    bench = Bench(cube(), mockup=sunk())
    taken = checked(bench, parts=[LEFT])
    assert taken["count"] == 1 and pairs(bench) == {PLATE_LEFT: "clearance"}
    assert bench.document["findings"]["check"]["of"] == [LEFT]
    with pytest.raises(WorkbenchError, match="nowhere"):
        bench.session.job("clash", {"parts": "nowhere"}).result(WAIT_S)


def test_statuses_and_notes_are_kept_by_the_next_check() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    table = table_of(bench)
    peg = next(row for row in range(3) if PATHS[PEG] in (table.row_json(row)["a"], table.row_json(row)["b"]))
    bench.command("finding_mark", version=table.key, rows=[peg], status="reviewed", note="by design")
    bench.command("finding_group_add", version=table.key, rows=[peg], name="for ada")
    job = bench.session.job("clash", {})
    taken = job.result(WAIT_S)
    # What is done while a check runs is not lost.
    other = table.ids[(peg + 1) % 3]
    bench.command("finding_status", id=other, status="approved")
    bench.command("findings_take", key=taken["key"])
    now = table_of(bench)
    row = now.row_of[table.ids[peg]]
    assert (now.status_of(table.ids[peg]), now.note_of(table.ids[peg])) == ("reviewed", "by design")
    assert bench.document["findings"]["status"] == {other: "approved"}
    assert bench.document["findings"]["members"] == {now.ids[row]: bench.document["findings"]["own_groups"][0]["id"]}
    assert now.status_of(now.ids[(row + 2) % 3]) in ("active",), "known, and no longer new"
    bench.command("clash_settings", clearance=0.0)
    assert checked(bench)["gone"] == 0 and len(table_of(bench).ids) == 2, "the gap of the left post is not looked for"


def test_a_check_of_some_parts_loses_nothing_of_the_others() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    table = table_of(bench)
    row = next(row for row in range(3) if PATHS[PEG] in (table.row_json(row)["a"], table.row_json(row)["b"]))
    peg = table.ids[row]
    bench.command("finding_mark", version=table.key, rows=[row], status="approved", note="by design")
    bench.command("finding_group_add", version=table.key, rows=[row], name="for ada")
    members = bench.document["findings"]["members"]
    assert checked(bench, parts=[LEFT])["gone"] == 0 and peg not in table_of(bench).row_of
    bench.command("take_tool", name=None)
    bench.command("grip", parts=[PEG])
    checked(bench)
    bench.command("place", pose=list(bench.pose.ravel()))
    bench.command("release")
    checked(bench)
    now = table_of(bench)
    assert (now.status_of(peg), now.note_of(peg)) == ("approved", "by design")
    assert now.marks[peg].approved_depth == pytest.approx(0.01)
    assert bench.document["findings"]["members"] == members


def test_what_is_said_while_a_check_of_some_parts_runs_is_not_lost() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    taken = bench.session.job("clash", {"parts": [LEFT]}).result(WAIT_S)
    before = table_of(bench).ids
    for name in before:
        bench.command("finding_status", id=name, status="reviewed")
    bench.command("findings_take", key=taken["key"])
    checked(bench)
    assert [table_of(bench).status_of(name) for name in before] == ["reviewed"] * 3


def test_rules_hold_and_one_that_names_nothing_is_told() -> None:
    bench = Bench(cube(), mockup=sunk())
    rules = (
        '[[rule]]\nname = "posts"\na = "*posts*"\nseverity = "critical"\n'
        '[[exclude]]\nname = "pegs"\na = "*peg"\n'
        '[[exclude]]\nname = "none"\na = "*nothing*"\n'
    )
    bench.command("clash_settings", rules=rules, contact="chord")
    assert bench.document["clash"] == {"clearance": 0.002, "contact": None, "rules": rules}
    bench.command("clash_settings", contact=0.0)
    taken = checked(bench)
    assert taken["notes"][0] == "'*nothing*' of exclusion 'none' names no part"
    assert PLATE_PEG not in pairs(bench) and bench.document["findings"]["hidden"] == {"pegs": 1, "none": 0}
    assert table_of(bench).row_json(0)["severity"] == "critical"
    before = bench.document["clash"]
    for wrong in ("[[rule", '[[rule]]\nname = "x"\nclearence = 1\n'):
        with pytest.raises(WorkbenchError, match=r"TOML|clearence"):
            bench.command("clash_settings", rules=wrong)
    assert bench.document["clash"] == before, "what is wrong changes nothing"


def test_ignore_like_this_hides_what_it_said_and_is_kept_as_a_rule() -> None:
    mockup = feeler.Mockup(
        np.concatenate([stand().vertices, stand().vertices[24:32] + np.array([0.2, 0, 0])]),
        np.concatenate([stand().faces, stand().faces[36:48] + 12]),
        np.concatenate([stand().part_of_face, np.full(12, 5)]),
        ["plate", "left", "right", "peg_1", "sheet", "peg_2"],
        part_paths=["a/plate", "a/left", "a/right", "a/peg_1", "sheet", "a/peg_2"],
    )
    bench = Bench(cube(), mockup=mockup)
    checked(bench)
    table = table_of(bench)
    row = next(row for row in range(len(table)) if "a/peg_1" in (table.row_json(row)["a"], table.row_json(row)["b"]))
    alike = bench.session.ask("finding_alike", {"version": table.key, "row": row})
    assert alike is not None and {alike["a"], alike["b"]} == {"a/plate", "a/peg_*"} and alike["count"] == 2
    assert bench.session.ask("finding_hides", {"a": "*left", "b": "*"}) == {"count": 1, "trouble": None}
    assert "no part matches '*nope'" in bench.session.ask("finding_hides", {"a": "*nope", "b": "*"})["trouble"]  # type: ignore[index]
    bench.command("finding_ignore", name="pegs", a=alike["a"], b=alike["b"])
    assert len(table_of(bench)) == len(table) - 2 and bench.document["findings"]["hidden"] == {"pegs": 2}
    with pytest.raises(WorkbenchError, match="there is an exclusion 'pegs' already"):
        bench.command("finding_ignore", name="pegs", a="*", b="*")
    rules = bench.session.job("export_findings", {"format": "rules"}).result(WAIT_S)
    assert feeler.clashes.Rules.parse(bench.session.export(rules["name"]).decode()).exclusions[0].name == "pegs"
    checked(bench)
    assert len(table_of(bench)) == len(table) - 2 and bench.document["findings"]["hidden"] == {"pegs": 2}
    for _ in range(2):
        bench.command("undo")
    assert table_of(bench).key == table.key and bench.document["clash"]["rules"] == ""


@pytest.mark.parametrize(
    ("path", "pattern", "others"),
    [
        ("m/*star*", "m/*star*", "m/xstarx"),
        ("m/[brackets]", "m/[brackets]", "m/b"),
        ("re:[x", r"re:(?s:re:\[x(/.*)?)", "re:x"),
        ("*", r"re:(?s:\*(/.*)?)", "x"),
        ("m/*star*_12", "m/[*]star[*]_*", "m/xstarx_12"),
        ("re:[x]_1", "[r]e:[[]x]_*", "re:x_1"),
    ],
)
def test_ignore_like_this_takes_signs_of_patterns_in_names_as_they_are(path: str, pattern: str, others: str) -> None:
    assert finding_rules.alike(path) == pattern
    mockup = feeler.Mockup(
        np.concatenate([stand().vertices, stand().vertices[24:32] + np.array([0.2, 0, 0])]),
        np.concatenate([stand().faces, stand().faces[36:48] + 12]),
        np.concatenate([stand().part_of_face, np.full(12, 5)]),
        part_paths=["a/plate", "a/left", "a/right", path, "sheet", others],
    )
    bench = Bench(cube(), mockup=mockup)
    checked(bench)
    table = table_of(bench)
    row = next(row for row in range(len(table)) if path in (table.row_json(row)["a"], table.row_json(row)["b"]))
    alike = bench.session.ask("finding_alike", {"version": table.key, "row": row})
    assert alike is not None and alike["count"] == 1, "the other part is another"
    bench.command("finding_ignore", name="signs", a=alike["a"], b=alike["b"])
    assert len(table_of(bench)) == len(table) - 1 and bench.document["findings"]["hidden"] == {"signs": 1}
    checked(bench)
    assert len(table_of(bench)) == len(table) - 1, "the check reads the rule as the page does"


def test_groups_by_hand() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    table = table_of(bench)
    number = bench.command("finding_group_add", version=table.key, rows=[0, 2], name="mine")["id"]
    assert bench.document["findings"]["members"] == {table.ids[0]: number, table.ids[2]: number}
    bench.command("finding_mark", version=table.key, rows=[2], group=0)
    bench.command("finding_group_rename", id=number, name="ours")
    assert bench.document["findings"]["own_groups"] == [{"id": number, "name": "ours"}]
    bench.command("finding_group_remove", id=number)
    assert bench.document["findings"]["members"] == {} and bench.document["findings"]["own_groups"] == []
    with pytest.raises(WorkbenchError, match="there is no group 99"):
        bench.command("finding_mark", version=table.key, rows=[2], group=99)
    with pytest.raises(WorkbenchError, match="the findings are others now"):
        bench.command("finding_mark", version="another", rows=[2], status="new")
    for rows in ([3], [-1], [True], "0", [0.0]):
        with pytest.raises(WorkbenchError, match="they are not rows"):
            bench.command("finding_mark", version=table.key, rows=rows, status="new")


def test_the_rows_are_fetched_by_their_version() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    message = table_of(bench).message()
    assert isinstance(message, FindingRows) and message.places.shape == (3, 9) and message.sizes.shape == (3, 4)
    words = json.loads(message.words.tobytes())
    assert words["ids"] == list(table_of(bench).ids) and set(words["paths"]) < set(PATHS)
    assert bench.session.finding_rows(message.version) == table_of(bench).frame()
    with pytest.raises(WorkbenchError, match="others now"):
        bench.session.finding_rows("another")
    assert len(json.dumps(bench.document["findings"])) < 1000, "no rows in the document"


def test_a_file_of_any_size_is_opened(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=sunk())
    pair = {"a": PATHS[PEG], "b": PATHS[PLATE], "verdict": "clash", "depth": 0.01}
    many = [{**pair, "id": f"finding {k}", "depth": 0.01 / (k + 1)} for k in range(20_000)]
    data = json.dumps({"version": 1, "clashes": many}).encode()
    assert len(data) > 1_500_000
    files = sent(bench.session, data)
    taken = bench.session.job("findings_file", {"files": files, "name": "a.json"}).result(WAIT_S)
    bench.command("findings_take", key=taken["key"])
    assert len(table_of(bench)) == 20_000 and table_of(bench).ids[0] == "finding 0"
    with pytest.raises(WorkbenchError, match="there are no files"):
        bench.session.job("findings_file", {"files": files, "name": "a.json"}).result(WAIT_S)
    for text, words in (
        (b"{", "a.json cannot be read as JSON"),
        (b"\xff\xfe\x00", "not text|JSON"),
        (b"[]", "holds no list"),
    ):
        files = sent(bench.session, text)
        with pytest.raises(feeler.errors.LoadError, match=words):
            bench.session.job("findings_file", {"files": files, "name": "a.json"}).result(WAIT_S)


def test_findings_of_parts_that_the_mockup_lacks_are_told() -> None:
    """Excluded parts are known."""
    bench = Bench(cube(), mockup=sunk(), absent=[LEFT])

    def opened(*pairs: tuple[str, str]) -> list[str]:
        rows = [{"a": a, "b": b, "depth": 1.0, "id": str(k)} for k, (a, b) in enumerate(pairs)]
        files = sent(bench.session, json.dumps({"clashes": rows}).encode())
        taken = bench.session.job("findings_file", {"files": files, "name": "a.json"}).result(WAIT_S)
        assert bench.session.load_findings({"clashes": rows}) == "".join(taken["notes"])
        return list(taken["notes"])

    assert opened() == opened(PLATE_PEG) == opened(PLATE_LEFT) == opened((PATHS[LEFT], PATHS[LEFT])) == []
    told = "1 of 2 findings name parts that this mock-up lacks, such as 'nope'"
    assert opened(PLATE_PEG, (PATHS[PEG], "nope")) == [told]
    assert opened((PATHS[PEG], "nope")) == [told.replace("1 of 2 findings name", "1 of 1 finding names")]
    assert opened(("nope", "no2")) == [told.replace("1 of 2 findings name", "1 of 1 finding names")]
    assert opened(("", "")) == [], "a place without parts"


def test_the_page_says_what_a_bcf_file_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    assert bench.session.job("export_findings", {"format": "bcf"}).result(WAIT_S)["notes"] == []
    monkeypatch.setattr("feeler.clashes.write_bcf", lambda path, *_args, **_more: path.write_bytes(b"x") and 0)
    (note,) = bench.session.job("export_findings", {"format": "bcf"}).result(WAIT_S)["notes"]
    assert note.startswith("clashes.bcf has the 0 worst of ")


def test_files_of_findings(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    first = table_of(bench).ids[0]
    bench.command("finding_status", id=first, status="approved")
    bench.command("finding_mark", version=table_of(bench).key, rows=[0], note="by design")
    written = {}
    for kind in ("json", "csv", "html", "bcf"):
        answer = bench.session.job("export_findings", {"format": kind}).result(WAIT_S)
        written[kind] = bench.session.export(answer["name"])
        assert len(written[kind]) == answer["bytes"] > 100
    (tmp_path / "now.json").write_bytes(written["json"])
    loaded = feeler.load_clashes(tmp_path / "now.json")
    (approved,) = loaded.where(status="approved")
    assert (approved.id, approved.note) == (first, "by design")
    assert b"by design" in written["csv"] and first.encode() in written["html"]
    assert "bcf.version" in zipfile.ZipFile(BytesIO(written["bcf"])).namelist()
    # A check by the command line goes on from there.
    now = feeler.clash(sunk())
    now.diff(loaded)
    assert now.where(status="approved").ids == (first,)


def test_findings_of_other_programs_are_written_as_they_came() -> None:
    bench = Bench(cube())
    bench.session.load_findings({"clashes": [{"id": "x", "a": "nowhere", "b": PATHS[PEG], "depth": 0.5, "more": [1]}]})
    bench.command("finding_status", id="x", status="reviewed")
    answer = bench.session.job("export_findings", {"format": "json"}).result(WAIT_S)
    (row,) = json.loads(bench.session.export(answer["name"]))["clashes"]
    assert (row["id"], row["a"], row["depth"], row["status"], row["more"]) == ("x", "nowhere", 0.5, "reviewed", [1])


def test_saved_findings_come_back_the_same() -> None:
    bench = Bench(cube(), mockup=sunk())
    bench.command("clash_settings", contact=0.0001)
    checked(bench)
    bench.command("finding_group_add", version=table_of(bench).key, rows=[0], name="mine")
    found = bench.session.current.findings
    assert found is not None
    back = restored(json.loads(json.dumps(saved(found))), bench.mockup.parts)
    assert back.to_json() == found.to_json() and back.table.frame() == found.table.frame()


def test_a_record_is_replayed_without_the_jobs(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=sunk(), record=tmp_path / "record.jsonl")
    checked(bench)
    bench.command("finding_status", id=table_of(bench).ids[0], status="reviewed")
    bench.command("finding_ignore", name="pegs", a="*peg", b="*")
    bench.session.close()
    gone = replay(read_record(tmp_path / "record.jsonl"), bench.mockup, bench.scene, cube())
    assert gone.parted is None and gone.commands == 3


def test_a_check_can_be_cancelled_and_leaves_a_thread_for_the_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _pid: {0, 1, 2, 3}, raising=False)
    assert threads() == 3
    monkeypatch.setattr("os.sched_getaffinity", lambda _pid: {0}, raising=False)
    assert threads() == 1
    bench = Bench(mockup=feeler.sample("gearbox", 60_000))
    began = threading.Event()
    job = bench.session.job("clash", {}, lambda share, stage: began.set())
    assert began.wait(WAIT_S)
    job.cancel()
    with pytest.raises(JobCancelledError):
        job.result(WAIT_S)
    assert bench.session.job("clash", {"parts": [0]}).result(WAIT_S)["count"] >= 0, "the next one runs"


def test_a_finding_is_seen_from_where_nothing_is_in_the_way() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    table = table_of(bench)
    rows = {tuple(sorted((table.row_json(k)["a"], table.row_json(k)["b"]))): k for k in range(3)}
    side = bench.session.ask("finding_side", {"version": table.key, "row": rows[PLATE_LEFT]})
    assert side is not None and side["direction"][2] > 0.0, "from above: the plate would hide it from below"
    assert np.linalg.norm(side["direction"]) == pytest.approx(1.0)


@pytest.mark.parametrize(("up", "axis"), [("x", 0), ("y", 1), ("z", 2)])
def test_a_finding_is_seen_from_above_where_nothing_else_decides(up: feeler.types.UpAxis, axis: int) -> None:
    mockup = sunk()
    mockup.source = replace(mockup.source, up=up)
    bench = Bench(cube(), mockup=mockup)
    side = bench.session.ask("pair_side", {"parts": [LEFT, LEFT], "point": [-0.3, 0.0, 9.0]})
    assert side is not None and side["direction"][axis] == pytest.approx(0.42, abs=0.01)


def test_equal_findings_have_equal_tables_however_they_came() -> None:
    mockup = feeler.sample("gearbox", 40_000)
    found = feeler.clash(mockup)
    one = findings_of_clashes(found, mockup).table
    other = restored(json.loads(json.dumps(saved(findings_of_clashes(found, mockup)))), mockup.parts).table
    assert one.key == other.key and one.frame() == other.frame()
    some = one.rows(np.arange(0, len(one), 3))
    assert some.ids == one.ids[::3] and len(some.paths) < len(one.paths)
    assert [some.row_json(k) for k in range(5)] == [one.row_json(3 * k) for k in range(5)]


def verified(bench: Bench) -> list[dict[str, Any]]:
    """The verdicts of all requirements, checked now."""
    results = bench.session.job("verify", {}).result(WAIT_S)
    bench.command("requirements_checked", results=results)
    return [each["verdict"] for each in bench.document["requirements"]]


def test_clearances_that_must_hold() -> None:
    bench = Bench(mockup=sunk())
    with pytest.raises(WorkbenchError, match="there are no requirements"):
        bench.session.job("verify", {}).result(WAIT_S)
    first = bench.command("requirement_add", name="left post", a="*left", b="*plate", gap=0.002)["id"]
    bench.command("requirement_add", name="peg", a="*peg", b="stand", gap=0.0)
    nothing = bench.command("requirement_add", name="nothing", a="*nothing", b="*", gap=0.1)["id"]
    assert [each["verdict"] for each in bench.document["requirements"]] == [None] * 3
    left, peg, unknown = verified(bench)
    assert (left["status"], left["gap"]) == ("violated", pytest.approx(0.001)) and left["parts"] in (
        [PLATE, LEFT],
        [LEFT, PLATE],
    )
    assert len(left["points"]) == 2 and left["moved"] == {}
    assert peg["status"] == "violated" and peg["depth"] == pytest.approx(0.01, rel=2e-3)
    assert unknown["status"] == "unknown" and "no part matches '*nothing'" in unknown["trouble"]
    # Another name changes nothing; another distance has to be checked again.
    bench.command("requirement_edit", id=first, name="the left post")
    assert bench.document["requirements"][0]["verdict"] == left
    bench.command("requirement_edit", id=first, gap=0.0005)
    assert bench.document["requirements"][0]["verdict"] is None
    bench.command("requirement_remove", id=nothing)
    # The parts count where they lie now.
    bench.command("grip", parts=[PEG])
    left, peg = verified(bench)
    assert (left["status"], peg["status"], peg["gripped"]) == ("holds", "unknown", [PEG]), "it is in the hand"
    written = bench.session.job("export_requirements", {}).result(WAIT_S)
    text = bench.session.export(written["name"]).decode()
    assert 'name = "the left post"' in text and "gap = 0.0005" in text
    for _ in range(9):
        bench.command("undo")
    assert bench.document["requirements"] == []
    side = bench.session.ask("pair_side", {"parts": [PLATE, LEFT], "point": [-0.3, 0.0, 0.0]})
    assert side is not None and side["direction"][2] > 0.0


def test_requirements_that_are_written_are_read_by_the_command(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=sunk())
    for _ in range(2):
        bench.command("requirement_add", name='a "post"', a="*left", b="*plate", gap=0.002)
    written = bench.session.job("export_requirements", {}).result(WAIT_S)
    (tmp_path / "r.toml").write_bytes(bench.session.export(written["name"]))
    found = feeler.verify(sunk(), tmp_path / "r.toml")
    assert [(each.requirement.name, each.status) for each in found] == [
        ('a "post"', "violated"),
        ('a "post" 2', "violated"),
    ]


def test_verdicts_that_are_none_are_refused() -> None:
    bench = Bench(cube(), mockup=sunk())
    number = bench.command("requirement_add", name="one", a="*left", b="*plate", gap=0.002)["id"]
    (good,) = bench.session.job("verify", {}).result(WAIT_S)
    for changes in ({"status": "so so"}, {"gap": "x"}, {"points": [[1, 2]]}, {"moved": []}, {"pairs": None}):
        with pytest.raises(WorkbenchError, match="they are not verdicts"):
            bench.command("requirements_checked", results=[{"id": number, "verdict": {**good["verdict"], **changes}}])
    with pytest.raises(WorkbenchError, match="a verdict has no 'verdict'; send the results"):
        bench.command("requirements_checked", results=[{"id": number}])


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    value=st.recursive(
        st.none() | st.booleans() | st.floats(allow_nan=False) | st.integers(-(2**60), 2**60) | st.text(max_size=5),
        lambda inside: st.lists(inside, max_size=4) | st.dictionaries(st.text(max_size=3), inside, max_size=4),
        max_leaves=20,
    ),
    indent=st.sampled_from([None, 1]),
    cut=st.integers(0, 200),
    junk=st.sampled_from(["", " ", ",", "]", "}", "x", '"', ":"]),
)
def test_patient_json_is_json(
    monkeypatch: pytest.MonkeyPatch, value: Any, indent: int | None, cut: int, junk: str
) -> None:
    monkeypatch.setattr(patient_json, "LARGE", 0)
    text = json.dumps({"clashes": value, "more": [value, value]}, indent=indent)
    assert patient_json.patient_loads(text) == json.loads(text)
    broken = text[: cut % len(text)] + junk + text[cut % len(text) :]
    try:
        expected = json.loads(broken)
    except ValueError:
        with pytest.raises(ValueError):
            patient_json.patient_loads(broken)
    else:
        assert patient_json.patient_loads(broken) == expected
    try:
        json.loads(text[: cut % len(text)])
    except ValueError:
        with pytest.raises(ValueError):
            patient_json.patient_loads(text[: cut % len(text)])


def test_one_file_to_send_has_the_rows() -> None:
    bench = Bench(cube(), mockup=sunk())
    checked(bench)
    name = bench.session.job("page", {}).result(WAIT_S)["name"]
    found = re.search(rb'id="feeler-page">\s*([^<]*)<', bench.session.export(name))
    assert found is not None
    saved_page = unpack(gzip.decompress(base64.b64decode(found[1])), (SavedPage,))
    assert saved_page.findings.tobytes() == table_of(bench).frame()
    assert saved_page.document["findings"]["version"] == table_of(bench).key
