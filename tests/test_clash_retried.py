"""Rules tried on findings that are there: the same as another check where that can be known, and said where not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clash_scene import FOUND, house, pairs, table
from shapes import box, mockup_of

import feeler
from feeler.clashes import Exclusion, Rule, Rules
from feeler.clashes.shapes import PartShapes
from feeler.clashes.verdict import Verdict
from feeler.errors import OptionError
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


@pytest.fixture
def saved(tmp_path: Path, mockup: feeler.Mockup) -> feeler.Clashes:
    feeler.clash(mockup, contact=0.0).save(tmp_path / "a.json")
    return feeler.load_clashes(tmp_path / "a.json")


def rows(found: feeler.Clashes) -> dict[Any, Any]:
    return {
        frozenset((row.path_a, row.path_b)): (row.id, row.rule, row.severity, row.verdict, row.depth, row.translation)
        for row in found
    }


@pytest.mark.parametrize(
    "rules",
    [
        Rules(),
        Rules((Rule("walls", "house/walls", "house/walls", severity="critical"),)),
        Rules((Rule("walls", "house/walls", contact=0.1),)),
        Rules((Rule("yard", "yard", clearance=0.0005),)),
        Rules((Rule("yard", "yard/near", contact=0.001),)),
        Rules((Rule("walls", "house/walls", "house/walls", level=2),)),
        Rules((Rule("pins", "house/pins"),), others=False),
        Rules(exclusions=(Exclusion("copies", "*copy*"), Exclusion("none", "*core*", "*near*"))),
        Rules(exclusions=(Exclusion("rooms", same_assembly=2), Exclusion("f", fasteners=True))),
        Rules((Rule("yard", "yard", clearance=0.0005),), (Exclusion("near", "*near*"),)),
    ],
    ids=[
        *("none", "severity", "contact", "clearance", "in contact apart", "level", "others", "exclude", "assembly"),
        "excluded and far",
    ],
)
def test_the_same_as_another_check(mockup: feeler.Mockup, saved: feeler.Clashes, rules: Rules) -> None:
    again = feeler.clash(mockup, rules=rules)
    tried = saved.with_rules(rules)
    assert rows(tried) == rows(again)
    assert tried.depths.tolist() == again.depths.tolist() and tried.gaps.tolist() == again.gaps.tolist()
    hidden = {name: count for name, count in tried.hidden.items() if name != "others = false"}
    assert hidden == again.hidden


@pytest.mark.parametrize("clearance", [0.05, 0.15])
@pytest.mark.parametrize("by", ["level", "exclude"])
def test_pairs_beyond_their_clearance_are_no_hidden_findings(by: str, clearance: float) -> None:
    mockup = mockup_of({"yard/a": box((0, 0, 0), (1, 1, 1)), "yard/b": box((1.1, 0, 0), (2, 1, 1))})
    rules = Rules((Rule("yard", "yard", clearance=clearance, level=int(by == "level")),))
    if by == "exclude":
        rules = replace(rules, exclusions=(Exclusion("pair", "yard/a", "yard/b"),))
    expected = feeler.clash(mockup, clearance=0.2, rules=rules).hidden
    assert sum(expected.values()) == int(clearance > 0.1)
    assert feeler.clash(mockup, clearance=0.2).with_rules(rules).hidden == expected


def test_what_others_false_leaves_out_is_counted(saved: feeler.Clashes) -> None:
    tried = saved.with_rules(Rules((Rule("pins", "house/pins"),), others=False))
    assert tried.hidden == {"others = false": len(FOUND) - len(tried)}


def test_rules_may_be_a_file_or_a_dict(tmp_path: Path, saved: feeler.Clashes) -> None:
    (tmp_path / "a.toml").write_text('[[exclude]]\nname = "copies"\na = "*copy*"\n')
    expected = saved.with_rules({"exclude": [{"name": "copies", "a": "*copy*"}]})
    assert rows(saved.with_rules(tmp_path / "a.toml")) == rows(expected) and 0 < len(expected) < len(FOUND)


def test_statuses_stay_with_their_pairs(saved: feeler.Clashes) -> None:
    saved.set_status(saved.ids[0], "approved", by="ada", note="why")
    pair = (saved[0].path_a, saved[0].path_b)
    tried = saved.with_rules(Rules((Rule("all", "*"),)))
    marked = {(row.path_a, row.path_b): (row.status, row.by, row.note) for row in tried if row.status != "new"}
    assert marked == {pair: ("approved", "ada", "why")} and tried.ids != saved.ids


def test_the_table_itself_stays(saved: feeler.Clashes) -> None:
    before = rows(saved)
    saved.with_rules(Rules((Rule("all", "*", contact=1.0),)))
    assert rows(saved) == before


def test_a_larger_clearance_needs_another_check(saved: feeler.Clashes) -> None:
    (note,) = saved.with_rules(Rules((Rule("yard", "yard", clearance=0.5),))).facts.notes
    assert "rule 'yard' asks for 500 mm, but some pairs were checked only within 2 mm" in note


def test_a_smaller_contact_needs_another_check(mockup: feeler.Mockup) -> None:
    wide = feeler.clash(mockup, contact=0.1)
    rules = Rules((Rule("all", "*", contact=0.01),))
    tried = wide.with_rules(rules)
    again = feeler.clash(mockup, rules=rules)
    assert pairs(tried) == pairs(again) and tried.depths.tolist() == again.depths.tolist()
    (note,) = tried.facts.notes
    assert note.startswith("2 contacts are clashes by these rules") and "their translation is not known" in note
    assert np.isnan(tried.translations).all(axis=1).sum() == 2
    assert wide.with_rules(Rules((Rule("all", "*", contact=0.1),))).facts.notes == ()
    (note,) = wide.with_rules(Rules((Rule("all", "*", contact=0.2),))).facts.notes
    assert "rule 'all' asks for 200 mm, but some pairs were checked only within 100 mm" in note


def test_rounding_makes_no_clash(mockup: feeler.Mockup) -> None:
    rows = [{"a": 0, "b": 1, "verdict": Verdict.CONTACT, "depth": 1e-16, "point_a": (1, 1, 1)}]
    found = table(rows, tuple(mockup.part_paths), shapes=PartShapes(mockup))
    found.facts.__dict__["contact"] = 0.001
    assert found.with_rules({}).verdicts.tolist() == [Verdict.CONTACT]


def test_walls_that_pierce_each_other_stay_a_clash(mockup: feeler.Mockup) -> None:
    # Shallower than the contact that they were checked with, and a clash all the same.
    rows = [{"a": 0, "b": 1, "depth": 0.001, "translation": (1.0, 0.0, 0.0)}]
    rows += [{"a": 0, "b": 2, "depth": 0.004, "translation": (1.0, 0.0, 0.0)}]
    rows += [{"a": 0, "b": 3, "depth": 0.003, "translation": (0.003, 0.0, 0.0)}]
    found = table(rows, tuple(mockup.part_paths))
    found.facts.__dict__["contact"] = 0.002
    tried = found.with_rules(Rules((Rule("all", "*", contact=0.005),)))
    verdicts = dict(zip(tried.parts_b.tolist(), tried.verdicts.tolist(), strict=True))
    assert verdicts == {1: Verdict.CLASH, 2: Verdict.CONTACT, 3: Verdict.CONTACT}
    far, note = tried.facts.notes
    assert "asks for 5 mm" in far
    assert note.startswith("1 clashes count as contacts by their depth, but may be thin walls that cross")


def test_contacts_of_old_files_stay_a_doubt(mockup: feeler.Mockup) -> None:
    rows = [{"a": 0, "b": 1, "verdict": Verdict.CONTACT, "depth_kind": 1, "depth_error": np.nan}]
    found = table(rows, tuple(mockup.part_paths))
    found.facts.__dict__["contact"] = 0.002
    (note,) = found.with_rules(Rules((Rule("all", "*", contact=0.001),))).facts.notes
    assert note.startswith("1 contacts may be clashes by these rules: the file lacks their depth")


def test_what_was_hidden_before_is_missed(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, rules=Rules(exclusions=(Exclusion("copies", "*copy*"),)))
    (note,) = found.with_rules(Rules()).facts.notes
    assert note == "4 findings that 'copies' hid are missing here. Check the mock-up to see them"


def test_a_pattern_that_names_none_of_the_parts_of_a_file_is_told(saved: feeler.Clashes) -> None:
    few = saved.with_rules(Rules(exclusions=(Exclusion("yard", "yard"),)))
    assert few.facts.notes == ()
    saved.facts.__dict__["parts"] = 1000  # of which the file has those with findings
    (note,) = saved.with_rules(Rules((Rule("x", "*blot*"),))).facts.notes
    assert note == "'*blot*' of rule 'x' names no part of these findings"


def test_a_pattern_that_names_no_part_of_the_mock_up_is_refused(mockup: feeler.Mockup) -> None:
    with pytest.raises(OptionError, match="do you mean 'bolt M8x30'"):
        feeler.clash(mockup).with_rules(Rules((Rule("x", "*blot*"),)))


def test_shapes_of_fasteners_need_the_mock_up(mockup: feeler.Mockup) -> None:
    rules = Rules(exclusions=(Exclusion("f", fasteners=True),))
    found = feeler.clash(mockup)
    assert found.with_rules(rules).facts.notes == (
        "fasteners are found by name alone. Pass the mock-up to find them by shape, too",
    )
    assert found.with_rules(rules, mockup).facts.notes == ()


def test_fasteners_of_saved_findings_are_found_by_shape(tmp_path: Path) -> None:
    """A file has only the parts of its findings, and in another order."""
    bolt = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    wall = box((-0.05, -0.05, -0.02), (0.05, 0.05, 0.0))
    far = box((1, 0, 0), (2, 1, 1))
    mockup = mockup_of({"far": far, "wall": wall, "part_17": (bolt.vertices, bolt.faces), "part_9": far})
    feeler.clash(mockup, clearance=0).save(tmp_path / "a.json")
    saved = feeler.load_clashes(tmp_path / "a.json")
    rules = Rules(exclusions=(Exclusion("f", fasteners=True),))
    assert saved.with_rules(rules).hidden == {"f": 0}
    tried = saved.with_rules(rules, mockup)
    assert tried.hidden == {"f": 1} == feeler.clash(mockup, clearance=0, rules=rules).hidden
    assert tried.facts.notes == ()
    with pytest.raises(OptionError, match="the clashes are of other parts than the mock-up's, such as 'far': give"):
        saved.with_rules(rules, house())
    with pytest.raises(OptionError, match=r"mockup is 'mock-up': give a feeler\.Mockup"):
        saved.with_rules(rules, "mock-up")  # type: ignore[arg-type]


def test_rules_are_tried_on_what_rules_left(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, rules=Rules((Rule("walls", "house/walls", contact=0.1),)))
    assert pairs(found.with_rules(Rules((Rule("walls", "house/walls", contact=0.1),)))) == pairs(found)


def test_notes_are_saved(tmp_path: Path, mockup: feeler.Mockup, saved: feeler.Clashes) -> None:
    tried = saved.with_rules(Rules(exclusions=(Exclusion("f", fasteners=True),)))
    assert tried.facts.notes
    tried.save(tmp_path / "tried.json")
    assert feeler.load_clashes(tmp_path / "tried.json").facts.notes == tried.facts.notes


def test_names_that_are_not_the_ends_of_paths_need_the_mockup() -> None:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    mockup = feeler.Mockup(
        np.concatenate([vertices, np.add(vertices, 0.5)]),
        np.concatenate([faces, faces + len(vertices)]),
        np.repeat([0, 1], len(faces)),
        ["Pump body", "shaft"],
        part_paths=["asm/id_001", "asm/id_002"],
    )
    rules = {"exclude": [{"name": "pump", "a": "Pump body"}]}
    found = feeler.clash(mockup)
    assert len(feeler.clash(mockup, rules=rules)) == len(found.with_rules(rules, mockup)) == 0 < len(found)
