"""Findings over time: ids, statuses, what is saved, and files that are not what they should be."""

from __future__ import annotations

import copy
import json
import pickle
import uuid
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clash_scene import FOUND, house, mockup_of, moved, pairs, table, without
from shapes import box

import feeler
from feeler import Verdict
from feeler.clashes.tracking import DEPTH_GROWTH_M, Found, clash_id, followed, mark_json, mark_of_json, part_keys
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io import WriteError
from feeler.workbench.document.findings import findings_of, read_findings


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


def one(depth: float = 0.001, gap: float = 0.0, **more: Any) -> feeler.Clashes:
    """A table of one pair, x/a and x/b."""
    verdict = Verdict.CLASH if depth > 0 else Verdict.CLEARANCE
    return table([{"a": 0, "b": 1, "verdict": verdict, "depth": depth, "gap": gap}], **more)


def test_ids_are_the_same_on_every_machine() -> None:
    assert clash_id("default", "x/a", "x/b") == "71dda261-d157-511d-a6ac-18eac4ea78ef"
    assert uuid.UUID(clash_id("default", "x/ä", "x/b")).version == 5
    assert clash_id("r", "b", "a") == clash_id("r", "a", "b") != clash_id("s", "a", "b")
    assert clash_id("r", "a", "b") != clash_id("r", "a b", "") != clash_id("r a", "b", "")


def test_ids_follow_names_and_not_coordinates(mockup: feeler.Mockup) -> None:
    ids = {(each.path_a, each.path_b): each.id for each in feeler.clash(mockup)}
    nudged = feeler.clash(moved(1e-12))
    assert {(each.path_a, each.path_b): each.id for each in nudged} == ids
    # Parts that come in between, or in another order, change no id.
    shapes = {f"new/{i}": box((50 + 2 * i, 0, 0), (51 + 2 * i, 1, 1)) for i in range(3)}
    from clash_scene import PARTS

    more = feeler.clash(mockup_of(shapes | dict(reversed(PARTS.items()))))
    assert {frozenset((each.path_a, each.path_b)): each.id for each in more} == {
        frozenset(pair): each for pair, each in ids.items()
    }


def test_parts_of_one_path_are_told_apart() -> None:
    assert part_keys(["a", "b", "a", "a"]) == ["a", "b", "a#2", "a#3"]
    assert part_keys(["a", "a", "a#2", "a"]) == ["a", "a#3", "a#2", "a#4"]
    assert part_keys([]) == []
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    shapes = [vertices, vertices + np.array([0.5, 0, 0]), vertices + np.array([0, 0.75, 0])]
    mockup = feeler.Mockup(
        np.concatenate(shapes), np.concatenate([faces + 8 * i for i in range(3)]), np.repeat([0, 1, 2], 12), ["box"] * 3
    )
    found = feeler.clash(mockup)
    assert len(found) == 3 == len(set(found.ids))
    assert set(found.ids) == {
        clash_id("default", *pair) for pair in (("box", "box#2"), ("box", "box#3"), ("box#2", "box#3"))
    }


def test_a_file_gives_back_what_was_saved(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    found.set_status(found.ids[0], "approved", by="ada", note='as "drawn"')
    found.save(tmp_path / "now.json")
    read = feeler.load_clashes(tmp_path / "now.json")

    def told(table: feeler.Clashes) -> list[dict[str, Any]]:
        rows = [{**row, "a": 0, "b": 0, "volume": 0} for row in table.to_dicts()]
        return sorted(rows, key=lambda row: row["id"])

    assert told(read) == told(found)
    assert read.depths.tolist() == found.depths.tolist() and read.gaps.tolist() == found.gaps.tolist()
    assert read.marks.of(found.ids[0]) == found.marks.of(found.ids[0])
    assert (read.facts.clearance, read.facts.contact, read.facts.parts) == (0.002, 0.0, 7)
    assert not read.is_partial and len(read.earlier()) == 0
    read.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "now.json").read_bytes()


def test_rows_and_groups_of_equal_rank_are_in_one_order_also_from_a_file(tmp_path: Path) -> None:
    """Boxes of a lattice, each in its neighbours by the same depth."""
    cells = [(i, j, k) for i in range(3) for j in range(3) for k in range(2)]
    rng = np.random.default_rng(7)
    names = [f"x/{name}" for name in rng.permutation(len(cells))]
    parts = {name: box(np.array(cell), np.array(cell) + 1.25) for name, cell in zip(names, cells, strict=True)}
    few = dict(list(parts.items())[:-4])
    rules = {"rule": [{"name": str(n), "a": f"*{n}", "severity": "minor"} for n in (7, 3)]}

    def told(clashes: feeler.Clashes) -> list[Any]:
        groups = [(group.name, group.rows.tolist()) for by in ("part", "rule") for group in clashes.groups(by)]
        return [clashes.ids, groups, clashes.earlier().ids, clashes.earlier().groups() and told(clashes.earlier())]

    def shuffled(mixed: dict[str, Any]) -> feeler.Mockup:
        order = rng.permutation(len(mixed))
        return mockup_of(dict(list(mixed.items())[place] for place in order))

    expected: list[Any] = []
    for _ in range(6):
        found = feeler.clash(shuffled(parts))
        found.save(tmp_path / "all.json")
        ruled = found.with_rules(rules)
        # Some of the others are not asked for, and some are gone.
        less = feeler.clash(shuffled(few), rules={"exclude": [{"name": "none", "a": names[2], "b": names[4:9]}]})
        less.diff(found)
        for each in (found, ruled, less):
            each.save(tmp_path / "some.json")
            expected.append(told(each))
            assert told(feeler.load_clashes(tmp_path / "some.json")) == expected[-1]
        assert told(feeler.load_clashes(tmp_path / "all.json").with_rules(rules)) == told(ruled)
        assert expected[-3:] == expected[:3]
    assert len(set(found.depths.tolist())) < len(found) / 4


def test_git_can_diff_a_file(tmp_path: Path, mockup: feeler.Mockup) -> None:
    """A line a finding, in an order that hangs on names alone."""
    found = feeler.clash(mockup)
    found.save(tmp_path / "a.json")
    found[::-1].save(tmp_path / "b.json")
    lines = (tmp_path / "a.json").read_text(encoding="ascii").splitlines()
    assert (tmp_path / "b.json").read_text(encoding="ascii").splitlines() == lines
    assert sum('"id"' in line for line in lines) == len(FOUND)
    found.set_status(found.ids[3], "reviewed")
    found.save(tmp_path / "b.json")
    changed = (tmp_path / "b.json").read_text(encoding="ascii").splitlines()
    assert len(changed) == len(lines) and sum(a != b for a, b in zip(lines, changed, strict=True)) == 1
    feeler.clash(without("house/walls/left")).save(tmp_path / "b.json")
    fewer = (tmp_path / "b.json").read_text(encoding="ascii").splitlines()
    kept = {line.rstrip(",") for line in fewer if '"id"' in line}
    assert kept < {line.rstrip(",") for line in lines}, "what stays is the same, though parts have other numbers"


def test_new_active_resolved_and_back(tmp_path: Path, mockup: feeler.Mockup) -> None:
    first = feeler.clash(mockup)
    assert set(first.statuses.tolist()) == {"new"}
    first.save(tmp_path / "1.json")

    second = feeler.clash(without("house/copy/left"))
    change = second.diff(feeler.load_clashes(tmp_path / "1.json"))
    gone = {pair for pair in FOUND if "house/copy/left" in pair}
    assert change.counts() == {
        **{"new": 0, "active": len(FOUND) - len(gone), "reviewed": 0, "approved": 0},
        "resolved": len(gone),
    }
    assert {frozenset((row.path_a, row.path_b)) for row in change.resolved} == {frozenset(pair) for pair in gone}
    assert set(change.resolved.statuses.tolist()) == {"resolved"} and set(second.statuses.tolist()) == {"active"}
    second.save(tmp_path / "2.json")
    assert len(feeler.load_clashes(tmp_path / "2.json").earlier()) == len(gone)

    again = feeler.clash(without("house/copy/left"))
    change = again.diff(feeler.load_clashes(tmp_path / "2.json"))
    assert change.counts()["resolved"] == 0 and len(again.earlier()) == 0, "what is gone is told once"

    third = feeler.clash(mockup)
    change = third.diff(feeler.load_clashes(tmp_path / "2.json"))
    assert {(row.path_a, row.path_b) for row in change.new} == gone, "what was resolved and comes back is new"
    assert change.counts()["resolved"] == 0 and len(third.earlier()) == 0


def test_what_somebody_wrote_into_a_file_as_resolved_comes_back_as_new(tmp_path: Path) -> None:
    one().save(tmp_path / "1.json")
    text = (tmp_path / "1.json").read_text()
    (tmp_path / "1.json").write_text(text.replace('"status": "new"', '"status": "resolved"'))
    now = one()
    assert len(now.diff(feeler.load_clashes(tmp_path / "1.json")).new) == 1


@pytest.mark.parametrize("status", ["active", "reviewed"])
def test_what_was_said_stays(tmp_path: Path, status: str) -> None:
    first = one()
    first.set_status(first.ids[0], status, by="ada", note="later")
    first.save(tmp_path / "1.json")
    second = one(depth=0.9)
    second.diff(feeler.load_clashes(tmp_path / "1.json"))
    assert (second[0].status, second[0].by, second[0].note) == (status, "ada", "later")


def approved(depth: float, gap: float = 0.0) -> feeler.Clashes:
    table = one(depth, gap)
    table.set_status(table.ids[0], "approved", by="ada", note="by design")
    return table


@pytest.mark.parametrize(
    ("was", "now", "status"),
    [
        ((0.001, 0.0), (0.001, 0.0), "approved"),
        ((0.001, 0.0), (0.0005, 0.0), "approved"),
        ((0.001, 0.0), (0.001 + 0.9 * DEPTH_GROWTH_M, 0.0), "approved"),
        ((0.001, 0.0), (0.001 + 1.1 * DEPTH_GROWTH_M, 0.0), "new"),
        ((0.0, 0.0015), (0.0, 0.001), "new"),
        ((0.0, 0.0015), (0.0, 0.0019), "approved"),
        ((0.0, 0.00005), (0.00004, 0.0), "approved"),
        ((0.0, 0.00005), (0.00006, 0.0), "new"),
    ],
)
def test_an_approval_is_of_a_depth(was: tuple[float, float], now: tuple[float, float], status: str) -> None:
    before, after = approved(*was), one(*now)
    change = after.diff(before)
    assert after[0].status == status and len(getattr(change, status)) == 1
    if status == "new":
        assert "by design; approved at" in after[0].note and "now" in after[0].note and after[0].by == "ada"


def test_an_approval_is_of_what_the_depth_may_be(tmp_path: Path) -> None:
    """The depth is a lower bound: the same solids, cut otherwise, have another one within the error."""
    deep = {"a": 0, "b": 1, "verdict": Verdict.CLASH}
    before = table([{**deep, "depth": 0.494, "depth_error": 0.00043}])
    before.set_status(before.ids[0], "approved", by="ada")
    before.save(tmp_path / "1.json")
    loaded = feeler.load_clashes(tmp_path / "1.json")
    for depth, status in ((0.49443 + 0.9 * DEPTH_GROWTH_M, "approved"), (0.49443 + 1.1 * DEPTH_GROWTH_M, "new")):
        for known in (before, loaded):
            now = table([{**deep, "depth": depth, "depth_error": 0.0001}])
            now.diff(known)
            assert now[0].status == status
    # The depth of open parts is an estimate, which cutting changes by up to 1 %.
    before = table([{**deep, "depth": 0.494, "depth_error": np.nan}])
    before.set_status(before.ids[0], "approved")
    for depth, status in ((0.4988, "approved"), (0.4992, "new")):
        now = table([{**deep, "depth": depth, "depth_error": np.nan}])
        now.diff(before)
        assert now[0].status == status


def test_approvals_of_older_files_have_the_largest_error(tmp_path: Path) -> None:
    deep = {"a": 0, "b": 1, "verdict": Verdict.CLASH}
    before = table([{**deep, "depth": 0.494}])
    before.set_status(before.ids[0], "approved", by="ada", note="by design")
    before.save(tmp_path / "1.json")
    data = json.loads((tmp_path / "1.json").read_text())
    assert data["clashes"][0].pop("approved_error") == 0.0
    assert data["clashes"][0].pop("approved_verdict") == "clash"
    (tmp_path / "1.json").write_text(json.dumps(data))
    old = feeler.load_clashes(tmp_path / "1.json")
    mark = old.marks.of(old.ids[0])
    assert (mark.approved_depth, mark.approved_error, mark.approved_verdict) == (0.494, None, "clash")
    for more, status in ((0.0004, "approved"), (0.0007, "new")):
        now = table([{**deep, "depth": 0.494 + more}])
        now.diff(old)
        assert now[0].status == status


@pytest.mark.parametrize(
    ("was", "now", "status"),
    [
        (("contact", 0.0), ("duplicate", 0.0), "new"),
        (("clash", 0.5), ("duplicate", 0.0), "new"),
        (("contained", 0.5), ("duplicate", 0.0), "new"),
        (("clearance", 0.0), ("duplicate", 0.0), "new"),
        (("duplicate", 0.0), ("duplicate", 0.0), "approved"),
        (("duplicate", 0.0), ("contact", 0.0), "approved"),
        (("duplicate", 0.0), ("clash", 0.5), "new"),
        (("contact", 2.5e-5), ("clash", 2.5e-5), "new"),  # walls that came to cross
        (("clash", 2.5e-5), ("clash", 2.5e-5), "approved"),
        (("clash", 2.5e-5), ("contact", 2.5e-5), "approved"),
        (("contact", 0.00095), ("clash", 0.00101), "approved"),  # deeper than contact, but no deeper than growth
    ],
)
def test_an_approval_is_of_a_verdict(
    tmp_path: Path, was: tuple[str, float], now: tuple[str, float], status: str
) -> None:
    """Where the depth does not say how bad a finding is."""
    before, after = (table([{"a": 0, "b": 1, "verdict": Verdict(word), "depth": depth}]) for word, depth in (was, now))
    after.facts = replace(after.facts, rules=(("default", 0.002, 0.001),))
    before.set_status(before.ids[0], "approved", by="ada", note="ok")
    before.save(tmp_path / "1.json")
    known = feeler.load_clashes(tmp_path / "1.json")
    after.diff(known)
    assert after[0].status == status
    if status == "new" and now[1] <= was[1]:
        assert after[0].note == f"ok; approved as {was[0]}, and now {now[0]}"
        assert after.marks.of(after.ids[0]).approved_verdict is None
    # The same in the workbench, which keeps its own table, also with the words of others.
    data = json.loads((tmp_path / "1.json").read_text())
    mockup = mockup_of({f"x/{name}": box((i, 0, 0), (i + 1, 1, 1)) for i, name in enumerate("ab")})
    for row in data["clashes"]:
        row["verdict"] = "touching" if row["verdict"] == "contact" else row["verdict"]
        row.pop("approved_error"), row.pop("approved_verdict")
    listed = findings_of(data, mockup.parts)
    known = listed.table.clashes(mockup, listed.mark_of)
    assert known.marks.of(known.ids[0]).approved_verdict == was[0]
    after = table([{"a": 0, "b": 1, "verdict": Verdict(now[0]), "depth": now[1]}], ("x/a", "x/b"))
    after.facts = replace(after.facts, rules=(("default", 0.002, 0.001),))
    after.diff(known)
    assert after[0].status == status


def test_approvals_that_only_an_older_project_kept_take_the_verdict_of_now() -> None:
    mark = mark_of_json({"status": "approved", "approved_depth": 0.494})
    assert followed(mark, Found(0.4943, 0.0001, "clash"), DEPTH_GROWTH_M).approved_verdict == "clash"
    assert followed(mark, Found(0.4946, 0.0001, "clash"), DEPTH_GROWTH_M).status == "new"
    assert mark_of_json(mark_json(mark)) == mark
    for wrong in ({"approved_error": "x"}, {"approved_error": 1e300}, {"approved_verdict": "crash"}):
        with pytest.raises(ValueError, match=f"{next(iter(wrong))} is "):
            mark_of_json({"status": "approved", **wrong})


def test_foils_that_come_to_cross_need_a_new_approval() -> None:
    """Their depth stays the same."""
    foil = box((-0.1, -0.1, 0), (0.1, 0.1, 5e-5))
    flat = mockup_of({"a": foil, "b": box((-0.05, -0.05, 2.5e-5), (0.05, 0.05, 7.5e-5))})
    upright = mockup_of({"a": foil, "b": box((-0.03, 0, -0.05), (0.03, 5e-5, 0.05))})
    before = feeler.clash(flat, contact=1e-4)
    before.set_status(before.ids[0], "approved")
    now = feeler.clash(upright, contact=1e-4)
    assert (before[0].verdict, now[0].verdict) == ("contact", "clash") and now[0].depth <= 1e-4
    assert len(now.diff(before).new) == 1
    again = feeler.clash(flat, contact=1e-4)
    assert len(again.diff(before).approved) == 1


def test_an_approved_depth_does_not_creep(tmp_path: Path) -> None:
    """What counts is the depth at the approval, not that of the check before."""
    step = 0.6 * DEPTH_GROWTH_M
    approved(0.001).save(tmp_path / "last.json")
    for number, status in ((1, "approved"), (2, "new")):
        now = one(0.001 + number * step)
        now.diff(feeler.load_clashes(tmp_path / "last.json"))
        assert now[0].status == status
        now.save(tmp_path / "last.json")


def test_growth_is_the_callers(mockup: feeler.Mockup) -> None:
    after = one(0.003)
    assert len(after.diff(approved(0.001), growth=0.01).approved) == 1
    assert len(after.diff(approved(0.001), growth=0.0).new) == 1
    for growth in (-1.0, float("nan"), "1", True):
        with pytest.raises(OptionError, match="growth is"):
            after.diff(approved(0.001), growth=growth)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="previous is str: give Clashes"):
        after.diff("last.json")  # type: ignore[arg-type]


def test_a_partial_check_resolves_nothing(tmp_path: Path, mockup: feeler.Mockup) -> None:
    first = feeler.clash(mockup)
    first.set_status(first.ids[-1], "approved", by="ada")
    first.save(tmp_path / "1.json")
    part = feeler.clash(mockup)[:3]
    part.is_partial = True
    change = part.diff(feeler.load_clashes(tmp_path / "1.json"))
    assert len(change.resolved) == 0 and len(change.active) == 3
    assert len(part.earlier()) == len(FOUND) - 3 and set(part.earlier().statuses.tolist()) == {"new", "approved"}
    part.save(tmp_path / "2.json")
    assert feeler.load_clashes(tmp_path / "2.json").is_partial
    # The next whole check goes on from there.
    whole = feeler.clash(mockup)
    change = whole.diff(feeler.load_clashes(tmp_path / "2.json"))
    assert change.counts() == {"new": 0, "active": len(FOUND) - 1, "reviewed": 0, "approved": 1, "resolved": 0}


def test_a_rule_of_another_name_is_another_finding(mockup: feeler.Mockup) -> None:
    before = feeler.clash(mockup)
    now = feeler.clash(mockup, rules={"rule": [{"name": "all"}]})
    assert now.diff(before).counts() == {
        **{"new": len(FOUND), "active": 0, "reviewed": 0, "approved": 0},
        "resolved": len(FOUND),
    }


def test_wrong_statuses(mockup: feeler.Mockup) -> None:
    found = one()
    with pytest.raises(
        OptionError, match=r"status is 'resolved', which only diff sets: choose new, active, reviewed, approved"
    ):
        found.set_status(found.ids[0], "resolved")
    with pytest.raises(OptionError, match="there is no clash 'nonsense'"):
        found.set_status("nonsense", "active")
    with pytest.raises(OptionError, match="by is 7: give text"):
        found.set_status(found.ids[0], "active", by=7)  # type: ignore[arg-type]
    assert found[0].status == "new"


OLD_FILE = Path(__file__).parent.parent / "testdata" / "clash" / "found.json"
"""Findings saved when a depth was the length of a way out."""


def test_files_of_another_measure_of_depth(tmp_path: Path) -> None:
    old = feeler.load_clashes(OLD_FILE)
    assert [(row.depth, row.depth_kind, row.status) for row in old] == [
        (0.001, "estimate", "approved"),
        (0.0, "estimate", "new"),
    ]
    assert np.isnan(old.depth_errors).all()
    old.save(tmp_path / "again.json")
    again = feeler.load_clashes(tmp_path / "again.json")
    assert again.to_dicts()[0]["depth_kind"] == "estimate" and again[0].status == "approved"
    assert again.marks.of(again.ids[0]).approved_depth == 0.001


@pytest.mark.parametrize(
    ("verdict", "kind", "then", "now"),
    [("clash", "exact", 0.001, 0.0004), ("clash", "estimate", 0.001, 0.003), ("contact", "exact", 0.0, 0.003)],
)
def test_another_measure_of_depth_opens_no_approval(
    tmp_path: Path, verdict: str, kind: str, then: float, now: float
) -> None:
    data = json.loads(OLD_FILE.read_text())
    data["clashes"][0].update(verdict=verdict, depth_kind=kind, depth=then, approved_depth=then)
    (tmp_path / "old.json").write_text(json.dumps(data))
    row = {"a": 0, "b": 1, "verdict": Verdict[verdict.upper()]}
    first = table([{**row, "depth": now}])
    assert len(first.diff(feeler.load_clashes(tmp_path / "old.json")).approved) == 1
    # From there on it is the depth of this measure that may not grow.
    second = table([{**row, "depth": now + 0.002}])
    assert len(second.diff(first).new) == 1


# --- files that are not what they should be ---------------------------------------------------------------------------


@pytest.fixture
def saved(tmp_path: Path, mockup: feeler.Mockup) -> Path:
    path = tmp_path / "last.json"
    feeler.clash(mockup).save(path)
    return path


def test_another_version(saved: Path) -> None:
    saved.write_text(saved.read_text().replace('"version": 1', '"version": 2'))
    with pytest.raises(LoadError, match=r"last\.json is of version 2, and this feeler reads 1: run the check again"):
        feeler.load_clashes(saved)


def test_a_truncated_file(saved: Path) -> None:
    text = saved.read_text()
    for share in (0.0, 0.1, 0.5, 0.9, 0.999):
        saved.write_text(text[: int(share * len(text))])
        with pytest.raises(LoadError, match=r"last\.json: it is cut short, or not JSON"):
            feeler.load_clashes(saved)


def test_a_file_of_another_mock_up(saved: Path) -> None:
    other = feeler.clash(mockup_of({"ship/hull": box((0, 0, 0), (9, 1, 1)), "ship/mast": box((0.5, 0, 0), (2, 1, 7))}))
    told = (
        r"none of the saved parts exist in this mock-up \(0 of 7, such as 'house/copy/left', match one of its 2 parts"
    )
    with pytest.raises(LoadError, match=told):
        other.diff(feeler.load_clashes(saved))
    assert set(other.statuses.tolist()) == {"new"} and len(other.earlier()) == 0


def test_other_files(tmp_path: Path, saved: Path) -> None:
    with pytest.raises(MissingFileError, match=r"none\.json does not exist"):
        feeler.load_clashes(tmp_path / "none.json")
    with pytest.raises(LoadError, match="cannot be read"):
        feeler.load_clashes(tmp_path)
    for content, message in [
        ("[1, 2]", "is not a file of clashes"),
        ('{"version": 1, "clashes": []}', "is not a file of clashes"),
        ('{"format": "feeler clash", "version": 1}', 'holds no list "clashes"'),
        (
            '{"format": "feeler clash", "version": 1, "clashes": [3]}',
            r"clashes\[0\] is not a finding: it is not an object",
        ),
        ('{"format": "feeler clash", "version": 1, "clashes": [{"a": "x", "b": "y"}]}', "it has no 'rule'"),
        ("[" * 100_000, "not JSON"),
        ("\x00", "not JSON"),
    ]:
        (tmp_path / "odd.json").write_text(content)
        with pytest.raises(LoadError, match=message):
            feeler.load_clashes(tmp_path / "odd.json")
    (tmp_path / "odd.json").write_bytes(b"\xff\xfe")
    with pytest.raises(LoadError, match="not JSON"):
        feeler.load_clashes(tmp_path / "odd.json")
    with pytest.raises(WriteError):
        one().save(tmp_path / "no" / "x.json")


DAMAGE: dict[str, Any] = {
    "id": "f0000000-0000-5000-8000-000000000000",
    "rule": 3,
    "a": None,
    "status": "gone",
    "verdict": "crash",
    "severity": "mayor",
    "depth": "deep",
    "depth_kind": "certain",
    "gap": 1e300,
    "triangles": -1,
    "point_a": [1, 2],
    "translation": "none",
    "box": [[0, 0, 0]],
    "open": [True],
    "approved_depth": "x",
    "approved_error": "x",
    "approved_verdict": "x",
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_findings(saved: Path, name: str) -> None:
    data = json.loads(saved.read_text())
    data["clashes"][2][name] = DAMAGE[name]
    saved.write_text(json.dumps(data))
    with pytest.raises(LoadError, match=r"clashes\[2\] is not a finding: "):
        feeler.load_clashes(saved)


def test_a_finding_twice(saved: Path) -> None:
    data = json.loads(saved.read_text())
    data["clashes"].append(data["clashes"][0])
    saved.write_text(json.dumps(data))
    with pytest.raises(LoadError, match="holds a finding twice"):
        feeler.load_clashes(saved)


def test_the_workbench_reads_a_file(saved: Path, mockup: feeler.Mockup) -> None:
    table = findings_of(read_findings(saved), mockup.parts).table
    members = [table.row_json(row) for row in range(len(table))]
    assert len(members) == len(FOUND) and (table.part_of_path >= 0).all()
    assert {(each["a"], each["b"]): each["verdict"] for each in members} == FOUND
    touching = {
        (each["a"], each["b"]) for each, is_touching in zip(members, table.is_touching, strict=True) if is_touching
    }
    assert touching == {pair for pair, verdict in FOUND.items() if verdict == "contact"}


def test_tables_travel(mockup: feeler.Mockup) -> None:
    before = feeler.clash(mockup)
    before.set_status(before.ids[0], "approved", by="ada")
    now = feeler.clash(without("yard/flush"))
    now.diff(before)
    for there in (pickle.loads(pickle.dumps(now)), copy.deepcopy(now)):
        assert list(there) == list(now) and there.facts == now.facts and list(there.earlier()) == list(now.earlier())
        assert pairs(there) == pairs(now) and there.part_paths == now.part_paths
        there.set_status(there.ids[1], "reviewed")
        assert now[1].status == "active", "a copy has a status of its own"


@pytest.mark.parametrize("how", ["parts", "scene", "rules", "ignore", "others", "with_rules"])
def test_findings_that_a_check_did_not_look_at_keep_their_status(tmp_path: Path, how: str) -> None:
    """Three boxes in a row overlap their neighbours, and a fourth is gone in the second check."""

    def row(*more: str) -> feeler.Mockup:
        names = ["one", "two", "three", *more]
        return mockup_of({name: box((0.75 * k, 0, 0), (0.75 * k + 1, 1, 1)) for k, name in enumerate(names)})

    def pair(found: feeler.Clashes) -> dict[tuple[str, str], str]:
        return {(each.path_a, each.path_b): each.status for each in found}

    first = feeler.clash(row("four"))
    last = next(each.id for each in first if (each.path_a, each.path_b) == ("two", "three"))
    first.set_status(last, "approved", by="Ada", note="drawn so")
    whole = row()
    exclude = {"exclude": [{"name": "drawn", "a": "two", "b": "three"}]}
    found = {
        "parts": lambda: feeler.clash(whole, parts="one"),
        "scene": lambda: feeler.clash(whole, scene=feeler.Scene(whole).without("three")),
        "rules": lambda: feeler.clash(whole, rules=exclude),
        "ignore": lambda: feeler.clash(whole, ignore=[("two", "three")]),
        "others": lambda: feeler.clash(whole, rules={"others": False, "rule": [{"name": "r", "a": "one", "b": "two"}]}),
        "with_rules": lambda: feeler.clash(whole).with_rules(exclude),
    }[how]()
    found = pickle.loads(pickle.dumps(found))
    changes = found.diff(first)
    lost = {("three", "four"), *({("one", "two")} if how == "others" else ())}  # that pair has another rule now
    assert {(each.path_a, each.path_b) for each in changes.resolved} >= {("three", "four")}
    assert pair(found.earlier()) == {("two", "three"): "approved", **dict.fromkeys(lost, "resolved")}
    found.save(tmp_path / "some.json")
    again = feeler.clash(whole)
    again.diff(feeler.load_clashes(tmp_path / "some.json"))
    assert pair(again)["two", "three"] == "approved"
    (mark,) = (each for each in again if each.id == last)
    assert (mark.by, mark.note) == ("Ada", "drawn so") and len(again.earlier()) == 0 + (how == "others")


def test_gaps_that_a_smaller_clearance_does_not_look_for_keep_their_status(tmp_path: Path) -> None:
    def row(*gaps: float) -> feeler.Mockup:
        starts = np.cumsum([0.0, *(1.0 + gap for gap in gaps)])
        return mockup_of({f"box{k}": box((x, 0, 0), (x + 1, 1, 1)) for k, x in enumerate(starts)})

    first = feeler.clash(row(0.005, 0.001), 0.006)
    wide, near = sorted(first, key=lambda each: -each.gap)
    first.set_status(wide.id, "approved", by="Ada", note="agreed")
    found = feeler.clash(row(0.005, 0.1), 0.002)
    changes = found.diff(first)
    assert [(each.id, each.status) for each in changes.resolved] == [(near.id, "resolved")]
    assert {each.id: each.status for each in found.earlier()} == {wide.id: "approved", near.id: "resolved"}
    found.save(tmp_path / "some.json")
    again = feeler.clash(row(0.005, 0.1), 0.006)
    again.diff(feeler.load_clashes(tmp_path / "some.json"))
    (kept,) = again
    assert (kept.id, kept.status, kept.by, kept.note) == (wide.id, "approved", "Ada", "agreed")
    gone = feeler.clash(row(0.1, 0.1), 0.006)
    assert [each.status for each in gone.diff(again).resolved] == ["resolved"]


COMPUTED = ("paths_a", "paths_b", "verdicts", "depth_kinds", "signed_depths", "rules", "severities", "ids")
MARKED = ("statuses", "by", "notes", "changed")


def test_columns_are_made_once_and_those_of_statuses_after_each_change(mockup: feeler.Mockup) -> None:
    """So that a loop over `clashes.statuses[row]` takes time in proportion to the rows."""
    found = feeler.clash(mockup)
    before = {name: getattr(found, name) for name in (*COMPUTED, *MARKED)}
    assert all(getattr(found, name) is column for name, column in before.items())
    found[1:2].set_status(found.ids[1], "reviewed", by="Ann", note="later")
    assert all(getattr(found, name) is before[name] for name in COMPUTED)
    assert found.statuses.tolist() == ["new", "reviewed", *["new"] * (len(found) - 2)]
    assert (found.by[1], found.notes[1], found[1:].by[0]) == ("Ann", "later", "Ann")
    assert before["statuses"].tolist() == ["new"] * len(found)
    again = feeler.clash(mockup)
    assert set(again.statuses.tolist()) == {"new"}
    again.diff(found)
    assert again.statuses.tolist() == ["active", "reviewed", *["active"] * (len(found) - 2)]
    for copied in (pickle.loads(pickle.dumps(again)), copy.copy(again), again[::-1][::-1]):
        assert copied.statuses.tolist() == again.statuses.tolist()
        assert all(list(getattr(copied, name)) == list(getattr(again, name)) for name in (*COMPUTED, *MARKED))
        assert not copied.statuses.flags.writeable and not copied.verdicts.flags.writeable
