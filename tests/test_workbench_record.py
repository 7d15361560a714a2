"""Records: every line whole, read after a crash, and replayed to the same hits or to where they part."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from commands import run, run_json
from workbench_scene import LEFT, PEG, PLATE, RIGHT, Bench, at, cube, stand

import feeler
from feeler.errors import LoadError, MissingFileError, WorkbenchError
from feeler.io import write_glb, write_stl
from feeler.workbench.session import player
from feeler.workbench.session import record as recording
from feeler.workbench.session.jobs import JobCancelledError
from feeler.workbench.session.player import Player
from feeler.workbench.session.record import document_digest, read_record
from feeler.workbench.session.replaying import Replay, replay
from feeler.workbench.session.session import Session


def session_of(path: Path, mode: str = "stop") -> Bench:
    """What a user does: comes into contact, takes a part out, makes a mistake, undoes, measures."""
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2), mode=mode, record=path)
    bench.drag(at(0.1, 0.0, 0.0), 0.5)
    bench.command("hide", parts="stand/posts/left")
    with pytest.raises(WorkbenchError):
        bench.command("hide", parts="stand/pig")
    bench.drag(at(0.1, 0.0, 0.2), 0.5)
    bench.command("grip", parts=[PEG])
    bench.drag(at(0.1, 0.0, 0.4), 0.5)
    bench.drag(at(0.3, 0.1, 0.4), 0.5)
    bench.command("release")
    bench.session.hand_gone()
    bench.tick()
    bench.command("set_mode", mode="pass")
    bench.drag(at(0.3, 0.0, 0.0), 1.0)
    bench.command("undo")
    bench.command("sequence_replay", id=bench.document["sequence"][0]["id"])
    for _ in range(400):
        bench.tick()
    bench.command("place", pose=at(0.0, -0.3, 0.2).ravel().tolist())
    bench.command("measure_add", type="parts", parts=[LEFT, RIGHT])
    bench.session.close()
    return bench


@pytest.mark.parametrize("mode", ["stop", "glide", "pass"])
def test_a_replay_is_the_same_to_the_last_triangle(tmp_path: Path, mode: str) -> None:
    bench = session_of(tmp_path / "a.jsonl", mode)
    record = read_record(tmp_path / "a.jsonl")
    assert not record.is_torn and record.header["mockup"]["hash"] == bench.document["mockup"]["hash"]
    found = replay(record, bench.mockup, feeler.Scene(bench.mockup), cube())
    assert found and found.parted is None
    assert found.commands == 10 and found.ticks > 100 and found.hits > 0
    assert {PLATE, RIGHT} <= set(found.touched)


def test_a_record_of_a_version_whose_viewpoints_had_no_cuts_is_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    camera = {"position": [2.0, 0.0, 0.0], "target": [0.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0], "fov_rad": 0.8}

    def made(path: Path) -> Bench:
        bench = Bench(cube(), record=path)
        bench.command("viewpoint_add", camera=camera)
        bench.command("hide", parts=[LEFT])
        bench.session.close()
        return bench

    now = partial(document_digest)
    with monkeypatch.context() as patch:
        patch.setattr(recording, "document_digest", lambda document: now(document, has_viewpoint_cuts=False))
        bench = made(tmp_path / "old.jsonl")
    made(tmp_path / "new.jsonl")
    old, new = read_record(tmp_path / "old.jsonl"), read_record(tmp_path / "new.jsonl")
    assert old.entries[-1]["document"] != new.entries[-1]["document"]
    for each in (old, new):
        assert replay(each, bench.mockup, feeler.Scene(bench.mockup), cube()).parted is None
    old.entries[-1]["document"] = "0" * 64
    parted = replay(old, bench.mockup, feeler.Scene(bench.mockup), cube()).parted
    assert parted is not None and "the document is another" in parted.what


def test_a_record_has_when_the_hand_was_let_go(tmp_path: Path) -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2), mode="glide", record=tmp_path / "a.jsonl")
    bench.drag(at(0.1, 0.0, 0.0), 0.5)
    let_go_at = bench.clock.now
    bench.session.hand_gone()
    for _ in range(30):
        bench.tick()
    bench.session.close()
    record = read_record(tmp_path / "a.jsonl")
    (number,) = (i for i, entry in enumerate(record.entries) if entry["kind"] == "let_go")
    assert record.entries[number]["time"] == let_go_at
    # Until then the wish is below the plate, and from then on where the hand is.
    wishes = [(entry["wish"][11], entry["pose"][11]) for entry in record.entries if entry["kind"] == "tick"]
    before = sum(entry["kind"] == "tick" for entry in record.entries[:number])
    assert wishes[before - 1][0] == 0.0 and wishes[before][0] == wishes[before - 1][1] > 0.03
    assert replay(record, bench.mockup, feeler.Scene(bench.mockup), cube())


def test_where_a_replay_parts_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    bench = session_of(path)
    lines = path.read_text().splitlines()
    entries = [json.loads(line) for line in lines]
    hit = next(i for i, entry in enumerate(entries) if entry["kind"] == "tick" and entry["came"])

    def parted(change: int, **fields: object) -> feeler.workbench.session.replaying.Parted:  # type: ignore[name-defined]
        changed = [json.dumps({**entries[change], **fields}) if i == change else line for i, line in enumerate(lines)]
        (tmp_path / "b.jsonl").write_text("\n".join(changed) + "\n")
        found = replay(read_record(tmp_path / "b.jsonl"), bench.mockup, feeler.Scene(bench.mockup), cube())
        assert not found
        return found.parted

    first, *_ = came = entries[hit]["came"]
    lost = parted(hit, came=came[1:])
    assert (lost.entry, lost.added, lost.missing) == (hit, (first,), ())
    more = parted(hit, came=[*came, 49])
    assert (more.entry, more.added, more.missing) == (hit, (), (49,))
    assert parted(hit, hits="0" * 32).entry == hit
    pose = [*entries[hit]["pose"][:3], entries[hit]["pose"][3] + 1e-15, *entries[hit]["pose"][4:]]
    assert "elsewhere" in parted(hit, pose=pose).what
    first_command = next(i for i, entry in enumerate(entries) if entry["kind"] == "command")
    assert "document is another" in parted(first_command, document="0").what
    assert "ends otherwise" in parted(first_command, name="hidde").what


def test_another_engine_answer_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = session_of(tmp_path / "a.jsonl")
    monkeypatch.setattr("feeler.workbench.engine.engine.OFF_M", 6e-7)
    found = replay(read_record(tmp_path / "a.jsonl"), bench.mockup, feeler.Scene(bench.mockup), cube())
    assert not found and "elsewhere" in found.parted.what


def test_another_mockup_or_tool_is_told(tmp_path: Path) -> None:
    bench = session_of(tmp_path / "a.jsonl")
    record = read_record(tmp_path / "a.jsonl")
    moved = feeler.Mockup(bench.mockup.vertices + 1e-9, bench.mockup.faces, bench.mockup.part_of_face)
    with pytest.raises(LoadError, match="another mock-up"):
        replay(record, moved, feeler.Scene(moved), cube())
    renamed = stand(["stand/plate", "stand/posts/left", "stand/posts/right", "stand/pin", "sheet"])
    with pytest.raises(LoadError, match="another mock-up"):
        replay(record, renamed, feeler.Scene(renamed), cube())
    for tool in (cube(0.06), None):
        with pytest.raises(LoadError, match="another tool, 'cube'"):
            replay(record, bench.mockup, feeler.Scene(bench.mockup), tool)


def test_lines_are_whole_while_the_session_runs(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    bench = Bench(cube(), pose=at(0, 0, 0.2), record=path)
    for step in range(5):
        bench.wish(at(0, 0, 0.2 - 0.01 * step))
        text = path.read_text()
        assert text.endswith("\n") and all(json.loads(line) for line in text.splitlines())
    bench.session.close()


def test_a_line_that_a_crash_cut_off_is_told_and_left_out(tmp_path: Path) -> None:
    bench = session_of(tmp_path / "a.jsonl")
    data = (tmp_path / "a.jsonl").read_bytes()
    whole = read_record(tmp_path / "a.jsonl")
    for cut in (1, 2, 17):
        (tmp_path / "b.jsonl").write_bytes(data[:-cut])
        record = read_record(tmp_path / "b.jsonl")
        assert record.is_torn and record.entries == whole.entries[:-1]
    found = replay(record, bench.mockup, feeler.Scene(bench.mockup), cube())
    assert found and found.is_torn


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a record"),
        ("{}\n", "not a record"),
        ("no json\n{}\n", "line 1 is broken"),
        ('{"kind": "header", "format": 99}\n', "format 99"),
        ('{"kind": "header", "format": 1}\nbroken\n{"kind": "tick"}\n', "line 2 is broken"),
    ],
)
def test_what_is_no_record_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a.jsonl").write_text(text)
    with pytest.raises(LoadError, match=words):
        read_record(tmp_path / "a.jsonl")
    with pytest.raises(MissingFileError):
        read_record(tmp_path / "none.jsonl")


def test_entries_that_lack_something_are_told(tmp_path: Path) -> None:
    session_of(tmp_path / "a.jsonl")
    lines = (tmp_path / "a.jsonl").read_text().splitlines()
    (tmp_path / "b.jsonl").write_text(lines[0] + '\n{"kind": "tick"}\n')
    mockup = stand()
    with pytest.raises(LoadError, match="not a record that this feeler can read"):
        replay(read_record(tmp_path / "b.jsonl"), mockup, feeler.Scene(mockup), cube())


def test_a_disk_that_is_full_does_not_stop_the_session(tmp_path: Path) -> None:
    bench = Bench(cube(), pose=at(0, 0, 0.2), record=tmp_path / "a.jsonl")
    recorder = bench.session._recorder

    class Full:
        closed = False

        def write(self, text: str) -> None:
            raise OSError(28, "No space left on device")

        def close(self) -> None:
            pass

    recorder._file.close()
    recorder._file = Full()
    bench.wish(at(0, 0, 0.1))
    np.testing.assert_array_equal(bench.pose, at(0, 0, 0.1))
    assert not bench.session.is_recording and "No space left" in recorder.trouble
    with pytest.raises(WorkbenchError, match="cannot be written"):
        Bench(cube(), record=tmp_path / "none" / "a.jsonl")


def test_pages_are_shown_a_replay_and_cannot_disturb_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.jsonl"
    bench = session_of(path)
    monkeypatch.setattr(player, "LONGEST_REST_S", 0.0)
    monkeypatch.setattr(player, "TOLD_S", 0.0)
    with Session() as session:
        Player(read_record(path), session, bench.mockup, bench.scene, cube(), name="stand")
        assert session.document()["record"]["name"] == "a.jsonl" and session.document()["record"]["verdict"] is None
        seen: list[tuple[float, ...]] = []
        session.on_snapshot(lambda: seen.append(tuple(session.snapshot().pose[:3, 3])))
        refused: list[str] = []

        def disturb(_share: float, _stage: str) -> None:
            session.wish(at(0.4, 0.4, 0.4), 7, "mouse")
            session.hand_gone()
            with pytest.raises(WorkbenchError, match="being replayed") as caught:
                session.command("undo", {})
            refused.append(str(caught.value))
            assert session.document()["record"]["is_playing"]

        rounds = session.engine._round

        def disturbed(steps: int) -> bool:
            # The latest that a page's wish can come: when the recorded one was given already.
            session.wish(at(0.4, 0.4, 0.4), 7, "mouse")
            return rounds(steps)

        monkeypatch.setattr(session.engine, "_round", disturbed)
        for _ in range(2):
            told = session.job("replay", {}, disturb).result(60)
            assert told["is_same"] and "to the last triangle" in told["verdict"]
            record = session.document()["record"]
            assert record == {"name": "a.jsonl", "is_playing": False, "at": 0.0, "has_gaps": False, **told}
            assert session.document()["sequence"] == bench.document["sequence"]
        assert refused and len(set(seen)) > 100, "each round is shown"
        monkeypatch.setattr(session.engine, "_round", rounds)
        # Then it is a session like any other.
        session.command("undo", {})
        session.wish(at(0.0, -0.3, 0.3), 8, "mouse")
        session.engine.tick()


@pytest.mark.parametrize("mode", ["stop", "glide", "pass"])
def test_every_moment_of_a_record_is_shown_from_both_sides(tmp_path: Path, mode: str) -> None:
    path = tmp_path / "a.jsonl"
    bench = session_of(path, mode)
    record = read_record(path)
    # What the session was after each entry, by a replay that nobody disturbs.
    truth: list[tuple[str, list[float]]] = []
    with Session(has_threads=False, clock=lambda: 0.0) as plain:
        gone = Replay(record, plain)
        gone.open(bench.mockup, bench.scene, cube())
        for number, _ in gone.steps():
            if number > 1:
                truth.append(state(plain))
        truth.append(state(plain))
    with Session() as session:
        shown = Player(record, session, bench.mockup, bench.scene, cube())
        timeline = session.ask("record", {})
        assert timeline["gaps"] == [] and timeline["seconds"] == shown.seconds > 4.0
        assert [step["title"] for step in timeline["steps"]][:3] == ["Hide left", "Hide pig (refused)", "Grip peg"]
        entries = [*range(0, len(truth), 17), *range(len(truth) - 1, 0, -23), 0, len(truth) - 1]
        for number in entries:
            at = shown._ats[number + 1]
            last = max(k for k, each in enumerate(shown._ats) if each <= at + 1e-9)
            session.job("replay_to", {"at": at}).result(60)
            assert state(session) == truth[last - 1], f"{mode}: entry {last}"
            parts = session.snapshot().hits.parts.tolist()
            if record.entries[last - 1]["kind"] == "tick":
                assert parts == record.entries[last - 1]["parts"]
            assert session.document()["record"]["at"] == pytest.approx(at)
        assert session.document()["record"]["is_same"]
        gaps = session.ask("record", {})["gaps"]
        assert 50 < len(gaps) <= 202 and [gap["share"] for gap in gaps] == sorted(gap["share"] for gap in gaps)
        assert min(gap["gap"] for gap in gaps if gap["gap"] is not None) < 1e-5, "it touched the plate"
        # The start, before all entries; from there it plays on to the same end.
        session.job("replay_to", {"at": 0.0}).result(60)
        assert session.job("replay", {"start": 0.0, "speed": 20.0}).result(60)["is_same"]
        assert state(session) == truth[-1]
        with pytest.raises(WorkbenchError, match="from 0"):
            session.job("replay", {"speed": 0.0}).result(60)


def state(session: Session) -> tuple[str, list[float]]:
    """The document, and where the hand is."""
    return document_digest(session.current), session.engine.pose.ravel().tolist()


def test_a_replay_in_pages_tells_where_it_parts_and_can_be_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.jsonl"
    bench = session_of(path)
    monkeypatch.setattr(player, "LONGEST_REST_S", 0.0)
    lines = path.read_text().splitlines()
    hit = next(i for i, line in enumerate(lines) if json.loads(line).get("came"))
    entry = json.loads(lines[hit])
    lines[hit] = json.dumps({**entry, "came": entry["came"][1:]})
    path.write_text("\n".join(lines) + "\n")
    with Session() as session:
        Player(read_record(path), session, bench.mockup, bench.scene, cube())
        told = session.job("replay", {}).result(60)
        assert not told["is_same"] and f"parts at entry {hit}" in told["verdict"]
        assert f"Now: triangles {entry['came'][0]}" in told["verdict"]

        def give_up(_share: float, _stage: str) -> None:
            raise JobCancelledError

        with pytest.raises(JobCancelledError):
            session.job("replay", {}, give_up).result(60)
        record = session.document()["record"]
        assert (record["is_playing"], record["is_same"], record["verdict"]) == (False, None, None)
    with Session() as session:
        with pytest.raises(LoadError, match="another tool"):
            Player(read_record(path), session, bench.mockup, bench.scene, None)
        session.open(bench.mockup, bench.scene, None)
        with pytest.raises(WorkbenchError, match="no record"):
            session.job("replay", {}).result(60)


def test_replay_on_the_command_line(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    write_stl(tmp_path / "cube.stl", cube())
    mockup, tool = feeler.load_mockup(tmp_path / "stand.glb"), feeler.load_tool(tmp_path / "cube.stl", "mm")
    path = tmp_path / "a.jsonl"
    bench = Bench(tool, pose=at(0, 0, 0.2), mode="pass", record=path, mockup=mockup)
    bench.drag(at(0, 0, 0.0), 1.0)
    bench.session.close()
    words = ["replay", path, tmp_path / "stand.glb", "--tool", tmp_path / "cube.stl"]
    text = run(*words).stdout
    assert "The same to the last triangle" in text and "plate" in text
    document = run_json(*words)
    assert document["same"] is True and document["hits"] > 0 and document["parted"] is None
    lines = path.read_text().splitlines()
    hit = next(i for i, line in enumerate(lines) if json.loads(line).get("came"))
    entry = json.loads(lines[hit])
    lines[hit] = json.dumps({**entry, "came": entry["came"][1:]})
    path.write_text("\n".join(lines) + "\n")
    result = run(*words, code=1)
    assert f"Entry {hit}: other triangles" in result.stdout and f"now: triangles {entry['came'][0]}" in result.stdout
    assert run_json(*words, code=1)["parted"]["added"] == [entry["came"][0]]
    run("replay", path, tmp_path / "stand.glb", code=2)
    run("replay", path, "sample:engine:20000", "--tool", tmp_path / "cube.stl", code=2)
