"""Parts that keep their findings under another path, in another order, or meshed anew."""

from __future__ import annotations

import copy
import json
import pickle
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from clash_scene import FOUND, PARTS, house, mockup_of, table, without
from commands import run, run_json
from shapes import Mesh, box

import feeler
from feeler.clashes.matching import matched
from feeler.clashes.shapes import Shapes, shapes_of
from feeler.clashes.tracking import Found, part_keys
from feeler.errors import LoadError
from feeler.io import write_glb


def named(parts: Sequence[tuple[str, Mesh]]) -> feeler.Mockup:
    """A mock-up of parts whose paths may be equal."""
    starts = np.cumsum([0, *(len(vertices) for _, (vertices, _) in parts)])
    return feeler.Mockup(
        np.concatenate([vertices for _, (vertices, _) in parts]),
        np.concatenate([faces + start for (_, (_, faces)), start in zip(parts, starts, strict=False)]),
        np.repeat(np.arange(len(parts)), [len(faces) for _, (_, faces) in parts]),
        [path.split("/")[-1] for path, _ in parts],
        part_paths=[path for path, _ in parts],
    )


def cylinder(facets: int, centre: Sequence[float], radius: float, height: float) -> Mesh:
    """Standing on `centre`, closed, a corner of the circle on the x axis."""
    angles = 2.0 * np.pi * np.arange(facets) / facets
    ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(facets)]) + centre
    vertices = np.concatenate([ring, np.add(ring, [0, 0, height]), [centre], np.add(centre, [0, 0, height])[None]])
    i, j = np.arange(facets), (np.arange(facets) + 1) % facets
    low, high = np.full(facets, 2 * facets), np.full(facets, 2 * facets + 1)
    quads = [(i, j, j + facets), (i, j + facets, i + facets), (low, j, i), (high, i + facets, j + facets)]
    return vertices, np.concatenate([np.column_stack(each) for each in quads])


def shifted(mesh: Mesh, by: Sequence[float]) -> Mesh:
    return mesh[0] + by, mesh[1]


PLATE = box((0, 0, 0), (1, 0.2, 0.01))


def bolt_at(x: float, facets: int = 24) -> Mesh:
    """A bolt through the plate."""
    return cylinder(facets, (x, 0.1, -0.02), 0.01, 0.05)


def bolts(
    *places: float, facets: int = 24, path: str = "rig/bolt", shift: Sequence[float] = (0, 0, 0)
) -> feeler.Mockup:
    """A plate with bolts of one path, in this order."""
    parts = [("rig/plate", PLATE), *((path, bolt_at(x, facets)) for x in places)]
    return named([(name, shifted(mesh, shift)) for name, mesh in parts])


def places(found: feeler.Clashes) -> dict[float, tuple[str, str]]:
    """Status and note of each bolt's finding by the bolt's place along the plate."""
    middle = found.boxes.mean(axis=1)[:, 0].round(3).tolist()
    return {x: (row.status, row.note) for x, row in zip(middle, found, strict=True)}


def checked(mockup: feeler.Mockup) -> feeler.Clashes:
    return feeler.clash(mockup, clearance=0.0)


def approved(mockup: feeler.Mockup, tmp_path: Path, *only: float) -> feeler.Clashes:
    """What was saved of a check in which findings, at these places or all, are approved; the note says where."""
    found = checked(mockup)
    for x, row in zip(found.boxes.mean(axis=1)[:, 0].round(3).tolist(), found, strict=True):
        if not only or x in only:
            found.set_status(row.id, "approved", by="ada", note=f"at {x}")
    found.save(tmp_path / "before.json")
    return feeler.load_clashes(tmp_path / "before.json")


# --- other paths ------------------------------------------------------------------------------------------------------


def suffixed(path: str) -> str:
    return "/".join(f"{step}.{i}" for i, step in enumerate(path.split("/")))


RENAMED: dict[str, Callable[[str], str]] = {
    "root": lambda path: "home" + path[path.index("/") :],
    "sub-assembly": lambda path: path.replace("/walls/", "/shell/"),
    "one level more": lambda path: f"plant/{path}",
    "one level less": lambda path: path.split("/", 1)[1],
    "suffixes": suffixed,
    "all names": lambda path: f"part {sorted(PARTS).index(path)}",
}


@pytest.mark.parametrize("number", ["", "#2"])
def test_an_approval_stays_with_its_bolt_where_readers_number_equal_names(number: str) -> None:
    """The second of three bolts is gone, and another one is now the second of the file."""
    names = ["plate", "bolt", f"bolt{number}", f"bolt{number and '#3'}"]
    before = feeler.clash(named(list(zip(names, [PLATE, *map(bolt_at, (0.1, 0.2, 0.3))], strict=True))))
    (second,) = (each.id for each in before if abs(each.point_a[0] - 0.2) < 0.05)
    before.set_status(second, "approved", by="ada")
    now = feeler.clash(named(list(zip(names, [PLATE, *map(bolt_at, (0.1, 0.9, 0.3))], strict=True))))
    now.diff(before)
    status = {round(float(each.point_a[0]), 1): each.status for each in now}
    assert status == {0.1: "active", 0.3: "active", 0.9: "new"}
    assert [each.status for each in now.earlier()].count("resolved") == 1


@pytest.mark.parametrize("how", RENAMED)
def test_findings_outlive_other_paths(tmp_path: Path, how: str) -> None:
    before = feeler.clash(house())
    for row in before:
        before.set_status(row.id, "approved", by="ada", note=f"{row.path_a} | {row.path_b}")
    before.save(tmp_path / "before.json")
    name = RENAMED[how]
    # Read again, in another order, as another program would write it.
    now = feeler.clash(mockup_of({name(path): mesh for path, mesh in reversed(PARTS.items())}))
    change = now.diff(feeler.load_clashes(tmp_path / "before.json"))
    assert change.counts() == {"new": 0, "active": 0, "reviewed": 0, "approved": len(FOUND), "resolved": 0}
    for row in now:
        assert {name(path) for path in row.note.split(" | ")} == {row.path_a, row.path_b}
    others = {path: name(path) for path in PARTS if name(path) != path}
    assert dict(change.parts.renamed) == others and change.parts.by_shape == len(others)
    assert change.parts.by_path == len(PARTS) - len(others) and change.parts.altered == 0
    for row in now:
        assert row.changed == ("renamed" if {row.path_a, row.path_b} & {*others.values()} else "")


def test_ids_are_of_the_paths_now() -> None:
    before = feeler.clash(house())
    now = feeler.clash(mockup_of({f"plant/{path}": mesh for path, mesh in PARTS.items()}))
    ids = now.ids
    now.diff(before)
    assert now.ids == ids and not set(ids) & set(before.ids)


def test_a_renamed_finding_is_not_told_twice(tmp_path: Path) -> None:
    before = feeler.clash(house())
    renamed = mockup_of({f"plant/{path}": mesh for path, mesh in PARTS.items()})
    now = feeler.clash(renamed)
    now.diff(before)
    now.save(tmp_path / "now.json")
    assert set(feeler.load_clashes(tmp_path / "now.json").to_dicts()[0]["changed"].split()) == {"renamed"}
    again = feeler.clash(renamed)
    change = again.diff(feeler.load_clashes(tmp_path / "now.json"))
    assert change.parts.is_plain and {row.changed for row in again} == {""}


def test_a_status_that_is_set_keeps_how_the_finding_changed() -> None:
    now = feeler.clash(mockup_of({f"plant/{path}": mesh for path, mesh in PARTS.items()}))
    now.diff(feeler.clash(house()))
    now.set_status(now.ids[0], "reviewed")
    assert (now[0].status, now[0].changed) == ("reviewed", "renamed")


def test_a_renamed_approval_is_still_of_a_depth(tmp_path: Path) -> None:
    before = approved(bolts(0.2), tmp_path)
    deeper = [("rig/plate", box((0, 0, 0), (1, 0.2, 0.0103))), ("other/bolt", bolt_at(0.2))]
    now = checked(named(deeper))
    now.diff(before, growth=1.0)
    assert (now[0].status, now[0].changed) == ("approved", "renamed")
    before.marks.set(before.ids[0], "approved", Found(-1.0, 0.0, "clash"), "ada", "by design")
    now.diff(before)
    assert now[0].status == "new" and now[0].note.startswith("by design; approved at") and now[0].changed == "renamed"


@pytest.mark.parametrize(("facets", "nudge"), [(48, 0.0), (12, 0.0), (24, 1e-6), (48, 1e-6)])
def test_a_renamed_part_may_be_meshed_anew_or_nudged(tmp_path: Path, facets: int, nudge: float) -> None:
    before = approved(bolts(0.2, 0.5, 0.8), tmp_path)
    now = checked(bolts(0.8, 0.2, 0.5, facets=facets, path="gear/screw", shift=(nudge, -nudge, nudge)))
    now.diff(before, growth=1.0)
    assert places(now) == {x: ("approved", f"at {x}") for x in (0.2, 0.5, 0.8)}


def test_an_assembly_may_lie_elsewhere_under_other_paths(tmp_path: Path) -> None:
    parts = {**PARTS, "yard/flush": box((0.25, -1, 0.25), (0.75, 0, 0.7))}
    before = feeler.clash(mockup_of(parts))
    now = feeler.clash(mockup_of({f"a/{path}": shifted(mesh, (3000, 0, -64)) for path, mesh in parts.items()}))
    assert now.diff(before).counts()["active"] == len(before)


@pytest.mark.parametrize("nudge", [0.0, 1e-6])
def test_copies_in_one_place_are_told_apart_by_their_paths(tmp_path: Path, nudge: float) -> None:
    copies = [("rig/left/pin", bolt_at(0.2)), ("rig/right/pin", bolt_at(0.2)), ("rig/plate", PLATE)]
    before = checked(named(copies))
    for row in before:
        before.set_status(row.id, "reviewed", note=f"{row.path_a} | {row.path_b}")
    before.save(tmp_path / "before.json")
    now = checked(named([(f"new {path}", shifted(mesh, (nudge, 0, 0))) for path, mesh in reversed(copies)]))
    now.diff(feeler.load_clashes(tmp_path / "before.json"))
    for row in now:
        assert sorted(row.note.split(" | ")) == sorted(path.removeprefix("new ") for path in (row.path_a, row.path_b))


def test_copies_in_one_place_are_told_apart_by_their_triangles() -> None:
    """Two boxes of one size and place, whose faces are cut along other diagonals."""
    vertices, faces = PLATE
    turned = vertices * [-1, -1, 1] + [1, 0.2, 0], faces
    one, other = (shapes_of(named(list(zip(names, (PLATE, turned), strict=True)))) for names in ("ab", "xy"))
    swapped = shapes_of(named([("x", turned), ("y", PLATE)]))
    assert matched(one, other)[0].tolist() == [0, 1] and matched(one, swapped)[0].tolist() == [1, 0]


def test_a_row_of_named_parts_that_moves_by_its_pitch_goes_by_paths(tmp_path: Path) -> None:
    def row(by: float) -> feeler.Mockup:
        parts = [("plate", PLATE), *((f"bolt {i}", bolt_at(0.1 * i)) for i in range(1, 10))]
        return named([(path, shifted(mesh, (by, 0, 0))) for path, mesh in parts])

    before = approved(row(0.0), tmp_path)
    now = checked(row(0.1))
    change = now.diff(before)
    assert len(change.approved) == 9 and change.parts.is_plain
    assert all(row.note == f"at {0.1 * int(row.path_b[-1]):.1f}" for row in now)


# --- what is another part ---------------------------------------------------------------------------------------------


def test_another_shape_in_the_same_place_is_another_part(tmp_path: Path) -> None:
    before = approved(bolts(0.2), tmp_path)
    for mesh in (
        cylinder(24, (0.2, 0.1, -0.02), 0.0125, 0.05),  # the next size
        cylinder(24, (0.2, 0.1, -0.02), 0.01, 0.055),  # the next length
        box((0.19, 0.09, -0.02), (0.21, 0.11, 0.03)),  # its box
    ):
        now = checked(named([("rig/plate", PLATE), ("rig/pin", mesh)]))
        change = now.diff(before)
        assert (len(change.new), len(change.resolved), now[0].changed) == (1, 1, "")
        assert (change.parts.by_path, change.parts.by_shape) == (1, 0)


def test_the_mirror_image_of_a_part_is_another_part(tmp_path: Path) -> None:
    wedge = np.array([[0, 0, 0], [0.02, 0, 0], [0, 0.1, 0], [0, 0, 0.05], [0.02, 0, 0.05], [0, 0.1, 0.05]])
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    left = np.add(wedge, [0.4, 0.05, -0.02]), faces
    right = wedge * [1, -1, 1] + [0.4, 0.15, -0.02], faces[:, ::-1].copy()
    before = approved(named([("plate", PLATE), ("left", left)]), tmp_path)
    assert len(checked(named([("plate", PLATE), ("right", right)])).diff(before).new) == 1


def test_a_part_moved_or_made_anew_keeps_its_findings_by_its_path(tmp_path: Path) -> None:
    before = approved(bolts(0.2), tmp_path)
    for mesh in (bolt_at(0.8), cylinder(24, (0.2, 0.1, -0.02), 0.0125, 0.05)):
        now = checked(named([("rig/plate", PLATE), ("rig/bolt", mesh)]))
        change = now.diff(before, growth=1.0)
        assert (now[0].status, now[0].changed) == ("approved", "")
        assert (change.parts.by_path, change.parts.altered, change.parts.by_shape) == (2, 1, 0)


# --- parts of one path ------------------------------------------------------------------------------------------------


def test_an_approval_does_not_pass_to_the_next_bolt(tmp_path: Path) -> None:
    before = approved(bolts(0.2, 0.5, 0.8), tmp_path, 0.2)
    now = checked(bolts(0.5, 0.8))
    change = now.diff(before)
    assert places(now) == {0.5: ("active", ""), 0.8: ("active", "")}
    assert [(row.note, row.status) for row in change.resolved] == [("at 0.2", "resolved")]
    assert dict(change.parts.renamed) == {"rig/bolt#2": "rig/bolt", "rig/bolt#3": "rig/bolt#2"}
    assert {row.changed for row in now} == {"renumbered"}
    now.save(tmp_path / "now.json")
    assert [row.note for row in feeler.load_clashes(tmp_path / "now.json").earlier()] == ["at 0.2"]


def test_an_approval_does_not_pass_to_a_bolt_that_had_no_finding(tmp_path: Path) -> None:
    """The second bolt meets nothing in the first check; the file knows it all the same."""
    parts = [("rig/plate", box((0, 0, 0), (0.4, 0.2, 0.01))), ("rig/bolt", bolt_at(0.2)), ("rig/bolt", bolt_at(0.8))]
    before = approved(named(parts), tmp_path)
    now = checked(bolts(0.8))
    change = now.diff(before, growth=1.0)
    assert places(now) == {0.8: ("new", "")} and len(change.resolved) == 1


def test_bolts_in_another_order_keep_their_own_approvals(tmp_path: Path) -> None:
    before = approved(bolts(0.2, 0.5, 0.8), tmp_path)
    for order in ((0.5, 0.2, 0.8), (0.8, 0.5, 0.2), (0.8, 0.2, 0.5)):
        for facets, nudge in ((24, 0.0), (48, 0.0), (24, 1e-6)):
            now = checked(bolts(*order, facets=facets, shift=(nudge, 0, 0)))
            now.diff(before, growth=1.0)
            assert places(now) == {x: ("approved", f"at {x}") for x in (0.2, 0.5, 0.8)}


def test_bolts_that_come_between_change_nothing(tmp_path: Path) -> None:
    before = approved(bolts(0.2, 0.5), tmp_path)
    now = checked(bolts(0.8, 0.2, 0.3, 0.5))
    now.diff(before)
    assert {x: said for x, (_, said) in places(now).items()} == {0.2: "at 0.2", 0.3: "", 0.5: "at 0.5", 0.8: ""}


@pytest.mark.parametrize("by", [3000.0, 0.3])
def test_bolts_keep_their_approvals_where_the_whole_lies_elsewhere(tmp_path: Path, by: float) -> None:
    """Also by the pitch of the bolts, where each comes to the place of the next."""
    before = approved(bolts(0.2, 0.5, 0.8), tmp_path)
    now = checked(bolts(0.8, 0.5, 0.2, shift=(by, 0, 0)))
    change = now.diff(before)
    assert {round(x - by, 2): said for x, said in places(now).items()} == {
        x: ("approved", f"at {x}") for x in (0.2, 0.5, 0.8)
    }
    assert change.parts.altered == 0 and not change.parts.is_doubtful


def test_a_bolt_may_move_a_little(tmp_path: Path) -> None:
    before = approved(bolts(0.2, 0.5), tmp_path)
    now = checked(bolts(0.495, 0.2))
    now.diff(before)
    assert places(now) == {0.2: ("approved", "at 0.2"), 0.495: ("approved", "at 0.5")}
    for order in ((0.2, 0.53), (0.53, 0.2)):
        now = checked(bolts(*order))
        now.diff(before)
        assert places(now) == {0.2: ("approved", "at 0.2"), 0.53: ("new", "")}, "farther it may be any bolt"


def test_numbered_names_that_move_up_pass_nothing_on(tmp_path: Path) -> None:
    """Exporters that number instances name the third bolt as the second when the first is deleted."""

    def numbered(*places: float) -> feeler.Mockup:
        return named([("plate", PLATE), *((f"bolt-{i}", bolt_at(x)) for i, x in enumerate(places))])

    before = approved(numbered(0.2, 0.5, 0.8), tmp_path, 0.2)
    now = checked(numbered(0.5, 0.8))
    change = now.diff(before)
    assert places(now) == {0.5: ("active", ""), 0.8: ("active", "")} and len(change.resolved) == 1


# --- files and tables -------------------------------------------------------------------------------------------------


def test_a_file_of_an_earlier_version_goes_by_paths(tmp_path: Path) -> None:
    approved(bolts(0.2, 0.5), tmp_path)
    data = json.loads((tmp_path / "before.json").read_text())
    assert [line["part"] for line in data.pop("shapes")] == ["rig/bolt", "rig/bolt#2", "rig/plate"]
    (tmp_path / "old.json").write_text(json.dumps(data))
    now = checked(bolts(0.2, 0.5))
    change = now.diff(feeler.load_clashes(tmp_path / "old.json"))
    assert len(change.approved) == 2 and change.parts.is_plain
    with pytest.raises(LoadError, match=r"0 of 3, such as 'rig/bolt'.*by shape; they were saved without shapes"):
        checked(named([("a", PLATE), ("b", bolt_at(0.2))])).diff(feeler.load_clashes(tmp_path / "old.json"))


@pytest.mark.parametrize(
    ("name", "value"),
    [("part", 3), ("path", 3), ("content", "x"), ("content", "g" * 16), ("box", [[0, 0, 0]]), ("area", None)],
)
def test_damaged_shapes(tmp_path: Path, name: str, value: object) -> None:
    approved(bolts(0.2), tmp_path)
    data = json.loads((tmp_path / "before.json").read_text())
    data["shapes"][1][name] = value
    (tmp_path / "before.json").write_text(json.dumps(data))
    with pytest.raises(LoadError, match=r"shapes\[1\] is not a shape of a part: "):
        feeler.load_clashes(tmp_path / "before.json")
    (tmp_path / "before.json").write_text(json.dumps({**data, "shapes": 3}))
    with pytest.raises(LoadError, match='"shapes" is not a list'):
        feeler.load_clashes(tmp_path / "before.json")


def test_shapes_outlive_files_pickles_and_the_mock_up(tmp_path: Path) -> None:
    before = checked(bolts(0.2, 0.5))
    for row in before:
        before.set_status(row.id, "reviewed", note="seen")
    before.save(tmp_path / "before.json")
    read = feeler.load_clashes(tmp_path / "before.json")
    read.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "before.json").read_bytes()
    for table_before in (before, before[:2], read, pickle.loads(pickle.dumps(before)), copy.deepcopy(read)):
        now = checked(bolts(0.5, 0.2, path="rig/pin"))
        assert len(now.diff(table_before).reviewed) == 2


def test_a_stopped_check_hands_on_what_it_did_not_find(tmp_path: Path) -> None:
    """Its file keeps findings that wait under the new names, so that the next check finds them by path or shape."""
    before = approved(bolts(0.2, 0.5, 0.8), tmp_path)
    part = checked(bolts(0.5, 0.8, path="rig/pin"))[:0]
    part.is_partial = True
    assert part.diff(before).counts()["resolved"] == 0
    part.save(tmp_path / "part.json")
    assert "earlier_shapes" in json.loads((tmp_path / "part.json").read_text())
    for path in ("rig/pin", "gear/screw"):
        now = checked(bolts(0.8, 0.5, path=path))
        now.diff(feeler.load_clashes(tmp_path / "part.json"))
        assert places(now) == {x: ("approved", f"at {x}") for x in (0.5, 0.8)}


def test_a_finding_that_waits_does_not_pass_to_another_bolt(tmp_path: Path) -> None:
    before = approved(bolts(0.2, 0.5), tmp_path, 0.2)
    for found in (slice(None), slice(0)):
        part = checked(bolts(0.5))[found]
        part.is_partial = True
        part.diff(before)
        part.save(tmp_path / "part.json")
        now = checked(bolts(0.5))
        now.diff(feeler.load_clashes(tmp_path / "part.json"))
        assert places(now) == {0.5: ("active", "")}


def test_a_finding_that_waits_outlives_a_revision_without_its_part(tmp_path: Path) -> None:
    before = approved(bolts(0.2), tmp_path)
    part = checked(named([("rig/plate", PLATE)]))
    part.is_partial = True
    part.diff(before)
    part.save(tmp_path / "part.json")
    now = checked(bolts(0.2, path="rig/pin"))
    now.diff(feeler.load_clashes(tmp_path / "part.json"))
    assert places(now) == {0.2: ("approved", "at 0.2")}


def test_a_finding_that_a_file_has_in_both_lists_is_resolved_once(tmp_path: Path) -> None:
    approved(bolts(0.2, 0.5), tmp_path)
    data = json.loads((tmp_path / "before.json").read_text())
    (tmp_path / "twice.json").write_text(json.dumps({**data, "earlier": data["clashes"]}))
    now = checked(bolts(0.2))
    assert now.diff(feeler.load_clashes(tmp_path / "twice.json")).counts()["resolved"] == 1
    now.save(tmp_path / "now.json")
    assert len(feeler.load_clashes(tmp_path / "now.json").earlier()) == 1


def test_tables_without_shapes_go_by_paths() -> None:
    before, now = (table([{"a": 0, "b": 1, "depth": 0.001}]) for _ in range(2))
    assert len(now.diff(before).active) == 1


def test_how_many_parts_are_the_same_is_told() -> None:
    before = feeler.clash(house())
    whole, fewer = feeler.clash(house()), feeler.clash(without("house/copy/left"))
    assert str(whole.diff(before).parts) == "7 of 7 parts with findings before are in this mock-up"
    assert str(fewer.diff(before).parts) == (
        "6 of 7 parts with findings before are in this mock-up: 6 by path, 0 by shape and place"
    )
    renamed = feeler.clash(mockup_of({path.replace("pins", "bolts"): mesh for path, mesh in PARTS.items()}))
    assert str(renamed.diff(before).parts) == (
        "7 of 7 parts with findings before are in this mock-up: 5 by path, 2 by shape and place, such as "
        "house/bolts/bolt M8x30, before house/pins/bolt M8x30"
    )
    other = feeler.clash(mockup_of({path: box((i, 0, 0), (i + 1.1, 9, 9)) for i, path in enumerate(PARTS)}))
    parts = other.diff(before).parts
    assert (parts.by_path, parts.altered, parts.by_shape, parts.is_doubtful) == (7, 7, 0, True)


# --- shapes themselves ------------------------------------------------------------------------------------------------


def test_content_does_not_depend_on_the_order_of_triangles_and_vertices() -> None:
    mockup = house()
    vertices, faces, part = mockup.vertices, mockup.faces, mockup.part_of_face
    rng = np.random.default_rng(1)
    order, places = rng.permutation(len(faces)), rng.permutation(len(vertices))
    place_of = np.argsort(places)
    other = feeler.Mockup(
        np.where(vertices[places] == 0.0, -0.0, vertices[places]),
        np.roll(place_of[faces[order]], 1, axis=1),
        part[order],
        mockup.part_names,
        part_paths=mockup.part_paths,
    )
    one, two = shapes_of(mockup), shapes_of(other)
    for name in ("content", "box", "middle", "area"):
        assert (getattr(one, name) == getattr(two, name)).all(), name
    assert len(set(one.content.tolist())) == len(one.keys) - 1, "two boxes are the same, in one place"


def test_shapes_are_those_of_closed_forms() -> None:
    shapes = shapes_of(mockup_of(PARTS))
    for row, (vertices, _) in enumerate(PARTS.values()):
        x, y, z = np.ptp(vertices, axis=0)
        assert shapes.box[row].tolist() == [vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()]
        assert np.allclose(shapes.area[row], 2 * (x * y + y * z + z * x), rtol=1e-12)
        assert np.allclose(shapes.middle[row], vertices.mean(axis=0), rtol=0, atol=1e-9)


def test_triangles_that_are_none_and_empty_parts() -> None:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    bad = np.array([[0, 1, 99], [8, 1, 2], [9, 1, 2], [0, 0, 0]])
    mockup = feeler.Mockup(
        np.concatenate([vertices, [[np.nan, 0, 0], [1e200, 0, 0]]]),
        np.concatenate([bad, faces, bad]),
        np.repeat([0, 1], [4, 16]),
        ["none", "cube", "empty"],
    )
    shapes = shapes_of(mockup)
    assert shapes.is_known.tolist() == [False, True, False]
    assert (shapes.area[1], shapes.middle[1].tolist()) == (6.0, [0.5, 0.5, 0.5])


def test_twenty_thousand_parts_are_matched_in_seconds() -> None:
    count = 20_000
    lower = np.stack(np.meshgrid(*[np.arange(28)] * 3), axis=-1).reshape(-1, 3)[:count] * 0.05
    rng = np.random.default_rng(2)
    size = np.array([[0.01, 0.01, 0.04], [0.02, 0.02, 0.01], [0.04, 0.04, 0.002]])[rng.integers(0, 3, count)]

    def shapes(paths: list[str], lower: np.ndarray, size: np.ndarray) -> Shapes:
        content = rng.integers(0, 2**63, len(paths)).astype(np.uint64)
        area = 2.0 * (size * np.roll(size, 1, axis=1)).sum(axis=1)
        corners = np.stack([lower, lower + size], axis=1)
        boxes = corners, corners.mean(axis=1), area
        flat = np.full(len(paths), 12), np.zeros(len(paths)), np.zeros(len(paths))
        return Shapes(tuple(part_keys(paths)), tuple(paths), content, *boxes, *flat)

    before = shapes([f"a/{i // 100}/{i}" for i in range(count)], lower, size)
    order = rng.permutation(count)
    for paths in ([f"b/{i}" for i in range(count)], ["bolt"] * count):
        now = shapes(paths, lower[order] + 1e-6, size[order])
        started = time.perf_counter()
        new_of_old, is_same, _ = matched(before, now)
        assert time.perf_counter() - started < 10.0
        assert (order[new_of_old] == np.arange(count)).all() and is_same.all()


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_takes_the_findings_of_another_file(tmp_path: Path) -> None:
    for name in "AB":
        write_glb(tmp_path / f"engine_rev{name}.glb", house())
    first, second = tmp_path / "engine_revA.glb", tmp_path / "engine_revB.glb"
    run("clash", first, "--save", tmp_path / "a.json")
    accepted = feeler.load_clashes(tmp_path / "a.json")
    accepted.set_status(accepted.ids[0], "approved", by="ada")
    accepted.save(tmp_path / "a.json")
    text = run("clash", second, "--previous", tmp_path / "a.json", "--fail-on", "new").stdout
    assert "0 new, 8 active, 0 reviewed, 1 approved, 0 resolved" in text
    words = " ".join(text.split())
    assert "7 of 7 parts with findings before are in this mock-up: 0 by path, 7 by shape and place, such as" in words
    document = run_json("clash", second, "--previous", tmp_path / "a.json", "--save", tmp_path / "b.json")
    assert {row["changed"] for row in document["clashes"]} == {"renamed"}
    assert document["previous"]["by_shape"] == 7 and len(document["previous"]["renamed"]) == 7
    (tmp_path / "report.json").write_text(json.dumps(document))
    for name in ("b.json", "report.json"):
        text = run("clash", first, "--previous", tmp_path / name).stdout
        assert "0 new, 8 active, 0 reviewed, 1 approved, 0 resolved" in text


def test_the_command_doubts_findings_of_another_geometry(tmp_path: Path) -> None:
    write_glb(tmp_path / "house.glb", house())
    run("clash", tmp_path / "house.glb", "--save", tmp_path / "a.json")
    write_glb(
        tmp_path / "house.glb", mockup_of({path: box((i, 0, 0), (i + 1.1, 9, 9)) for i, path in enumerate(PARTS)})
    )
    told = " ".join(run("clash", tmp_path / "house.glb", "--previous", tmp_path / "a.json").stderr.split())
    assert "7 of 7 parts" in told and "7 with another shape or place" in told and "of this mock-up?" in told


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.02, -0.8, 0.7), (5.0, 0.0, 0.0)])
@pytest.mark.parametrize("first", [0, 1, 2])
def test_approvals_stay_in_their_holes_where_numbers_and_the_whole_are_shifted(shift, first):
    """One bolt is deleted, and the others are numbered anew; the last ones are beside the plate."""
    for count in (2, 3, 5, 8):
        holes = [0.1 + 0.2 * k for k in range(count)]
        before = feeler.clash(
            named([("a/plate", PLATE), *((f"a/bolt_{k}", bolt_at(x)) for k, x in enumerate(holes))]), clearance=0
        )
        for row in before:
            before.set_status(row.id, "approved", note=f"{np.mean(row.box, axis=0)[0]:.1f}")
        left = [x for k, x in enumerate(holes) if k != min(first, count - 1)]
        moved = [("a/plate", PLATE), *((f"a/bolt_{k}", bolt_at(x)) for k, x in enumerate(left))]
        now = feeler.clash(named([(path, shifted(mesh, shift)) for path, mesh in moved]), clearance=0)
        now.diff(before)
        kept = [row.note for row in now if row.note]
        assert kept == [f"{np.mean(row.box, axis=0)[0] - shift[0]:.1f}" for row in now if row.note], (count, kept)
        assert len(kept) == len([x for x in left if x < 1.0]), count
