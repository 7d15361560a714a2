"""Nightly runs of files with other paths: another name of the file, another level, other names of parts."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run_json
from night_scene import driver, lid, parts, saved, scene_of
from shapes import Mesh, box
from test_maintain import facts
from test_maintain_memory import asked

import feeler
from feeler.errors import OptionError
from feeler.tasks.recognising import recognised
from feeler.tasks.snapshots import parts_seen

LIST = ["*s0*/cover*", "*s1*/cover*"]


def planned(meshes: dict[str, Mesh], previous: Any = None, rows: Any = LIST, **options: Any) -> feeler.Maintenance:
    return feeler.maintain(scene_of(meshes), rows, **{"tools": driver(), "threads": 1, **options}, previous=previous)


@pytest.fixture(scope="module")
def before() -> feeler.Maintenance:
    return planned(rooted("old", parts(2)))


def rooted(root: str, meshes: dict[str, Mesh]) -> dict[str, Mesh]:
    return {f"{root}/{path}": mesh for path, mesh in meshes.items()}


def base_name(path: str) -> str:
    return path.replace("old/", "", 1)


@pytest.mark.parametrize(
    "now",
    [
        lambda path: path.replace("old/", "new/", 1),
        lambda path: f"plant/{path}",
        lambda path: base_name(path),
        lambda path: f"{path}_v2",
        lambda path: "/".join(f"{step}_7" for step in path.split("/")),
    ],
    ids=["root renamed", "a level more", "a level less", "suffixes", "suffixes of all levels"],
)
def test_rows_are_kept_through_new_paths(before: feeler.Maintenance, now: Callable[[str], str]) -> None:
    old = rooted("old", parts(2))
    meshes = {now(path): mesh for path, mesh in old.items()}
    run = planned(meshes, before)
    assert run.renamed == {now(path): path for path in old} and not run.changes
    assert all(row.is_kept and row.delta == 0.0 and not row.change for row in run)
    assert run[0].renamed_from == ("old/s0/cover",) and run[0].paths == (now("old/s0/cover"),)
    assert "10 of 10 parts of the last run are in this mock-up: 0 by path, 10 by shape and place" in run.hints[0]
    assert run.said == "2 of 2 come out, 0 changed, 2 kept, 10 parts renamed"
    # The next night knows the new paths.
    assert not planned(meshes, run).renamed


def test_a_part_that_moved_in_a_renamed_tree_is_named(
    before: feeler.Maintenance, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It is found by the path that the others suggest; what looked elsewhere is kept, also the answers."""
    meshes = rooted("plant/new", parts(2))
    meshes["plant/new/s1/lid"] = lid(1.0)
    full = planned(meshes)
    before.save(tmp_path / "last.json")
    found = asked(monkeypatch)
    run = planned(meshes, tmp_path / "last.json")
    assert facts(run) == facts(full) and [row.is_kept for row in run] == [True, False]
    assert {each.rsplit("/", 1)[0] for each in found} == {"plant/new/s1"}
    assert run[1].delta == 10.0 and run[1].change == "+10 s since lid moved" and run.failing("slower") == [run[1]]
    assert [(each.path, each.what) for each in run.changes] == [("plant/new/s1/lid", "moved")]
    assert run.renamed["plant/new/s1/lid"] == "old/s1/lid" and "1 with another shape or place" in run.hints[0]


def test_answers_are_recalled_through_new_paths(before: feeler.Maintenance, monkeypatch: pytest.MonkeyPatch) -> None:
    """Other times: all rows are planned again, and nothing is asked again."""
    meshes = rooted("new", parts(2))
    full = planned(meshes, times={"take": 60.0})
    found = asked(monkeypatch)
    run = planned(meshes, before, times={"take": 60.0})
    assert not found and facts(run) == facts(full) and not any(row.is_kept for row in run)
    assert run[0].change == "+54 s since other times were given"


def test_one_part_renamed_and_what_is_new_or_gone(before: feeler.Maintenance, tmp_path: Path) -> None:
    meshes = rooted("old", parts(2))
    meshes["old/s0/plate"] = meshes.pop("old/s0/lid")
    meshes["old/s1/bar"] = box((1.4, 0.2, 0.2), (1.5, 0.3, 0.3))
    del meshes["old/s1/lid"]
    meshes = dict(sorted(meshes.items()))
    base = planned(dict(sorted(rooted("old", parts(2)).items())))
    run = planned(meshes, base)
    assert facts(run) == facts(planned(meshes)) and run.renamed == {"old/s0/plate": "old/s0/lid"}
    assert [str(each) for each in run.changes] == ["old/s1/bar was added", "old/s1/lid was removed"]
    assert run.hints == (
        "9 of 10 parts of the last run are in this mock-up: 8 by path, 1 by shape and place, such as old/s0/plate, "
        "renamed from old/s0/lid.",
    )
    run.to_html(tmp_path / "night.html")
    assert "<td>old/s0/plate</td><td>old/s0/lid</td>" in (tmp_path / "night.html").read_text()
    run.save(tmp_path / "last.json")
    assert feeler.load_maintenance(tmp_path / "last.json").renamed == run.renamed


def test_two_equal_parts_that_swap_their_names() -> None:
    """The one over the bolt is named as the other was: nothing moved. A row of the list by path is compared by it."""
    meshes = {**parts(1), "s0/lid": lid(0.0), "s0/more": lid(0.4)}
    rows = ["s0/cover", "s0/lid"]
    base = planned(meshes, rows=rows)
    swapped = {**meshes, "s0/lid": meshes["s0/more"], "s0/more": meshes["s0/lid"]}
    run = planned(swapped, base, rows)
    assert facts(run) == facts(planned(swapped, rows=rows))
    assert run.renamed == {"s0/lid": "s0/more", "s0/more": "s0/lid"} and not run.changes
    assert run[0].delta == 0.0 and run[1].change == "" and run[1].delta == 0.0
    assert run[1].renamed_from == ("s0/more",)
    # One of two equal parts went, and the other has its name.
    alone = {path: mesh for path, mesh in swapped.items() if path != "s0/more"}
    run = planned(alone, base, rows)
    assert facts(run) == facts(planned(alone, rows=rows)) and run[0].delta == -10.0
    assert run.renamed == {"s0/lid": "s0/more"} and [str(each) for each in run.changes] == [
        "s0/lid (before) was removed"
    ]
    assert run[0].change == "-10 s since lid (before) was removed"


def test_a_blocked_row_names_paths_of_today() -> None:
    meshes = {**parts(1), "s0/lid": lid(0.0)}
    base = planned(meshes, rows=[{"part": "s0/cover", "keep": "s0/lid"}])
    now = rooted("new", meshes)
    rows = [{"part": "new/s0/cover", "keep": "new/s0/lid"}]
    run = planned(now, base, rows)
    assert run[0].state == "blocked" and facts(run) == facts(planned(now, rows=rows)) and run[0].change == ""
    assert run[0].blockers == ("new/s0/lid",) and "old" not in run[0].said


def test_times_of_a_new_path_are_a_change() -> None:
    """A pattern of the table names the bolt once it has its new name."""
    times = feeler.Times({}, typed={"*_special": 100.0})
    meshes = parts(2)
    base = planned(meshes, times=times)
    named = {("s1/bolt_special" if path == "s1/bolt" else path): mesh for path, mesh in meshes.items()}
    run = planned(named, base, times=times)
    assert facts(run) == facts(planned(named, times=times)) and run[0].delta == 0.0 < run[1].delta
    assert run[1].change.endswith("since bolt_special was renamed") and run.changes[0].what == "renamed"
    assert not any(row.is_kept for row in run), "a time bears on rows, wherever they looked"


def test_a_name_that_makes_another_fastener_bears_on_its_row() -> None:
    """Names say what parts are: a screw that is called a pin is held otherwise."""
    meshes = parts(2)
    base = planned(meshes)
    named = {("s1/housing" if path == "s1/bolt" else path): mesh for path, mesh in meshes.items()}
    run = planned(named, base)
    assert facts(run) == facts(planned(named)) and run[0].delta == 0.0


def test_older_files_are_read(before: feeler.Maintenance, tmp_path: Path) -> None:
    """Without centroids the boxes tell parts apart; answers of the older format are not used."""
    before.save(tmp_path / "last.json")
    data = json.loads((tmp_path / "last.json").read_text())
    assert len(data["snapshot"].pop("middles")) == 10
    del data["renamed"], data["retimed"]
    (tmp_path / "last.json").write_text(json.dumps(data))
    meshes = rooted("new", parts(2))
    run = planned(meshes, tmp_path / "last.json")
    assert len(run.renamed) == 10 and all(row.is_kept for row in run)
    assert all(each.middle is not None for each in run.snapshot.parts.values())


def test_another_mock_up_is_refused_or_doubted(before: feeler.Maintenance) -> None:
    other = {f"other/{n}": box((n, 5.0, 5.0), (n + 0.3 + 0.1 * n, 5.2, 5.1)) for n in range(4)}
    with pytest.raises(OptionError, match=r"0 of 10, such as 'old/frame/low', match one of 4 parts, such as 'other/0'"):
        planned(other, before, ["other/1"])
    run = planned({**other, **rooted("new", parts(1))}, before, ["*s0/cover"])
    assert "Is the last run of this mock-up?" not in run.hints[0]
    few = {path: mesh for path, mesh in rooted("new", parts(1)).items() if "frame" not in path and "lid" not in path}
    run = planned({**other, **few}, before, ["*s0/cover"])
    assert run.hints[0].startswith("3 of 10 parts") and run.hints[0].endswith("Is the last run of this mock-up?")


def test_centroids_tell_mirrored_parts_apart() -> None:
    """Equal boxes and areas in one place; with the centroids of their surfaces each is known."""
    one, other = wedge(False), wedge(True)
    seen = [parts_seen(scene_of(meshes)) for meshes in ({"a": one, "b": other}, {"x": other, "y": one})]
    assert recognised(*seen).before == {"x": "b", "y": "a"}


def wedge(is_mirrored: bool) -> Mesh:
    x = np.array([0.0, 1.0, 0.0, 0.0, 1.0, 0.0])
    y, z = np.array([0.0, 0.0, 1.0] * 2), np.array([0.0] * 3 + [1.0] * 3)
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    mesh = np.stack([x, y, z], axis=1), faces
    return (mesh[0] * [-1.0, 1.0, 1.0] + [1.0, 0.0, 0.0], faces[:, ::-1]) if is_mirrored else mesh


def test_an_interrupted_run_goes_on_in_a_renamed_file(before: feeler.Maintenance) -> None:
    def stop(share: float, _stage: str) -> None:
        if share >= 0.4:
            raise KeyboardInterrupt

    meshes = rooted("new", parts(2))
    for n in range(2):
        meshes[f"new/s{n}/lid"] = lid(float(n))
    with pytest.raises(feeler.MaintenanceInterrupted) as caught:
        planned(meshes, before, progress=stop)
    later = {f"plant/{path}": mesh for path, mesh in meshes.items()}
    run = planned(later, caught.value.maintenance)
    assert facts(run) == facts(planned(later)) and [row.delta for row in run] == [10.0, 10.0]
    assert sum(row.is_kept for row in run) == len(caught.value.maintenance) == 1


def test_the_command_line_says_what_was_renamed(tmp_path: Path) -> None:
    engine, last = saved(tmp_path, "engine.feeler", parts(1)), tmp_path / "last.json"
    run_json("maintain", engine, "--part", "s0/cover", "--save", last)
    meshes = {**rooted("new", parts(1)), "new/s0/lid": lid(0.0)}
    again = run_json(
        *("maintain", saved(tmp_path, "other.feeler", meshes), "--part", "*s0/cover", "--previous", last),
        *("--fail-on", "slower"),
        code=1,
    )
    assert again["renamed"]["new/s0/cover"] == "s0/cover" and again["rows"][0]["renamed_from"] == ["s0/cover"]
    assert again["failing"] == {"slower": ["*s0/cover"]} and again["rows"][0]["change"].endswith("since lid moved")
    strange = saved(tmp_path, "strange.feeler", {f"z{n}": box((n, 7, 7), (n + 0.5, 8, 9)) for n in range(2)})
    assert "none of its parts is in this one" in error_of("maintain", strange, "--part", "z0", "--previous", last)


@pytest.mark.parametrize("now", [lambda path: f"new/{path}", lambda path: f"{path}_B" if "s1" in path else path])
def test_a_row_that_keeps_renamed_parts_is_kept(now: Callable[[str], str]) -> None:
    old = parts(2)
    rows = [{"part": "*s0*/cover*", "keep": "*s1*/*"}, {"part": "*s1*/cover*", "keep": "*s0*/cover*"}]
    run = planned({now(path): mesh for path, mesh in old.items()}, planned(old, rows=rows), rows)
    assert all(row.is_kept and row.delta == 0.0 and not row.change for row in run)
