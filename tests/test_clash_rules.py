"""Rules of a clash check: which pairs, how near, what is left out; and what a file of them says wrong."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clash_scene import FOUND, house, mockup_of, pairs
from shapes import box

import feeler
from feeler.clashes import Exclusion, Rule, Rules, limits, report, write_rules
from feeler.clashes.fastener_rule import is_fastener
from feeler.clashes.limits import sub_assemblies
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


def ruled(mockup: feeler.Mockup, *each: Rule, **more: Any) -> dict[tuple[str, str], str]:
    found = feeler.clash(mockup, rules=Rules(each, **more))
    return {(row.path_a, row.path_b): row.rule for row in found}


def left_out(mockup: feeler.Mockup, *each: Exclusion) -> set[tuple[str, str]]:
    """What exclusions take away from all that is found; nothing else changes."""
    found = pairs(feeler.clash(mockup, rules=Rules(exclusions=each)))
    assert found.items() <= FOUND.items()
    return FOUND.keys() - found.keys()


def test_the_first_rule_that_names_a_pair_decides(mockup: feeler.Mockup) -> None:
    found = ruled(mockup, Rule("copies", "house/copy", "house/walls"), Rule("house", "house", "house"))
    assert {rule for pair, rule in found.items() if "house/copy/left" in pair and "walls" in pair[0]} == {"copies"}
    assert found["house/walls/left", "house/walls/right"] == "house"
    assert found["house/walls/left", "yard/flush"] == "default"
    assert found.keys() == FOUND.keys()
    turned = ruled(mockup, Rule("copies", "house/walls", "house/copy"), Rule("house", "house", "house"))
    assert turned == found, "which of the two is named first does not matter"


def test_rules_have_their_own_limits_and_severity(mockup: feeler.Mockup) -> None:
    each = [
        Rule("yard", "yard", clearance=0.0),
        Rule("walls", "house/walls", "house/walls", contact=0.1, severity="minor"),
        Rule("pins", "house/pins", severity="critical"),
    ]
    found = feeler.clash(mockup, rules=Rules(tuple(each)))
    said = {(row.path_a, row.path_b): (row.verdict.name.lower(), row.severity) for row in found}
    assert ("house/walls/right", "yard/near") not in said
    assert said["house/walls/left", "house/walls/right"] == ("contact", "minor")
    assert said["house/walls/right", "house/pins/core"] == ("contained", "critical")
    order = ["critical", "major", "minor"]
    assert [order.index(row.severity) for row in found] == sorted(order.index(row.severity) for row in found)
    wide = feeler.clash(mockup, clearance=0.0, rules=Rules((Rule("near", "yard/near", clearance=0.002),)))
    assert pairs(wide).keys() == FOUND.keys(), "the rule's clearance, where the call asks for none"


def test_others_need_not_be_asked(mockup: feeler.Mockup) -> None:
    found = ruled(mockup, Rule("pins", "house/pins"), others=False)
    assert found == {pair: "pins" for pair in FOUND if "pins" in "".join(pair)}


@pytest.mark.parametrize(
    ("pattern", "named"),
    [
        ("house/pins", {"bolt M8x30", "core"}),
        ("*core*", {"core"}),
        ("core", {"core"}),
        ("re:house/p.*/[a-c].*", {"bolt M8x30", "core"}),
        ("re:.*M8.*", {"bolt M8x30"}),
    ],
)
def test_patterns(mockup: feeler.Mockup, pattern: str, named: set[str]) -> None:
    gone = left_out(mockup, Exclusion("it", pattern))
    assert gone == {pair for pair in FOUND if {path.split("/")[-1] for path in pair} & named}


def test_several_patterns_on_both_sides(mockup: feeler.Mockup) -> None:
    gone = left_out(mockup, Exclusion("mates", ("*bolt*", "*core*"), ("house/copy", "house/walls/right")))
    assert gone == {("house/pins/bolt M8x30", "house/copy/left"), ("house/walls/right", "house/pins/core")}


def test_one_sub_assembly_is_left_out(mockup: feeler.Mockup) -> None:
    assert left_out(mockup, Exclusion("house", same_assembly=1)) == {
        pair for pair in FOUND if all(path.startswith("house/") for path in pair)
    }
    assert left_out(mockup, Exclusion("rooms", same_assembly=2)) == {("house/walls/left", "house/walls/right")}
    assert left_out(mockup, Exclusion("parts", same_assembly=3)) == set()


def test_the_level_of_a_rule(mockup: feeler.Mockup) -> None:
    found = ruled(mockup, Rule("walls", "house/walls", "house", level=2))
    assert ("house/walls/left", "house/walls/right") not in found
    assert found["house/walls/left", "house/copy/left"] == "walls"
    assert found.keys() == FOUND.keys() - {("house/walls/left", "house/walls/right")}
    found = ruled(mockup, Rule("pins", "house/pins", level=1), Rule("house", "house", "house"))
    assert {pair for pair in FOUND if pair not in found} == {pair for pair in FOUND if "pins" in "".join(pair)}, (
        "a rule decides its pairs: no later one is asked"
    )


def test_sub_assemblies() -> None:
    assert sub_assemblies(["a/b/c", "a/b/d", "a/e", "a", "f/b/c"], 1).tolist() == [0, 0, 0, -1, 1]
    assert sub_assemblies(["a/b/c", "a/b/d", "a/e", "a", "f/b/c"], 2).tolist() == [0, 0, -1, -1, 1]


@pytest.mark.parametrize(
    "name",
    [
        *("bolt_12", "M8x25 screw", "DIN 912 M6", "DIN 912 M8x30", "ISO4014-M8", "Mutter M8", "Unterlegscheibe"),
        *("hex nut/Solid1", "hex nut/Body", "M8 x 30", "HexBolt_12", "SHCS M5x20", "Scheibe M8", "DIN 125 Scheibe"),
        *("cover_screw_inner_3", "screw M6x20 left", "nut for cover", "\u00c9crou M6", "ASME B18.2.1"),
        *("Schraube DIN 933 M8", "Hex Bolt DIN 933 Fabory", "Hexagon socket head cap DIN 912", "Beilagscheibe DIN 125"),
        *("bolt (2)", "petite vis M4", "Screw, pan head", "4711-23 - Bolt M8", "DIN 912 - M8x1,25 - verzinkt"),
        *("Washer M8/Cylinder.001", "Washer M8/Cylinder-mesh", "Bolt/geom-12", "Bolt/Cube", "Bolt/Mesh.004"),
        *("plain washer normal grade a_iso", "hexagon nut style 1 grade ab_iso", "Screw (M8)"),
    ],
)
def test_names_of_fasteners(name: str) -> None:
    assert is_fastener(f"engine/{name}") is True


@pytest.mark.parametrize(
    "name",
    [
        *("Vis CHC M6", "Vis CHC", "VIS_CHC_M6x20", "Vis à tête hexagonale", "Vis tête cylindrique M6", "Vis H M8"),
        *("Vite TCEI M6x20", "Vite TCEI", "Viti testa svasata", "Dado autobloccante M8", "Bullone esagonale"),
        *("Rondelle plate M8", "Rondelle plate", "Écrou frein", "Boulon HM12 inox", "tornillo allen M8"),
        *("Tornillo cabeza hexagonal", "Arandela plana", "Tuerca M8 ciega", "Vis de fixation capot"),
    ],
)
def test_names_whose_noun_comes_first(name: str) -> None:
    assert is_fastener(f"moteur/{name}") is True


@pytest.mark.parametrize("name", ["vis-a-vis", "Vis à vis", "Vis_a_Vis camera", "VIS camera", "Vite", "dado box"])
def test_first_nouns_alone_need_more(name: str) -> None:
    """Words that mean other things in other places; a noun alone is a name."""
    assert is_fastener(f"moteur/{name}") is (True if name == "Vite" else None)


@pytest.mark.parametrize(
    "name",
    [
        *("Bracket (bolt)", "Cover - screw", "dish washer", "parts washer", "wall stud"),
        *("Nut_housing", "lead screw", "LeadScrew", "ISO_K_100_pipe", "M8 housing", "pump/key", "Vis sans fin M20"),
        *(
            "Vis à billes",
            "Vis mère",
            "Vite senza fine",
            "Vite a ricircolo di sfere",
            "Tornillo sin fin",
            "Vis M6 housing",
        ),
    ],
)
def test_names_of_other_things(name: str) -> None:
    assert is_fastener(f"engine/{name}") is False


@pytest.mark.parametrize(
    "name",
    [
        *("DIN 2633 Flansch DN50", "ANSI 150 flange", "Washer_pump", "donut", "nutrient tank", "studio", "bolts/pump"),
        *("ISO 9001 label", "M6x20 spacer", "Luftschraube", "", "\u87ba\u6813"),
        *("Bolt-on bracket", "Bolt on flange", "screw-in sensor", "Halter f\u00fcr DIN 912", "DIN 933 Bohrplatte"),
        *("Flansch DIN 933", "Flansch (Schraube DIN 933)", "Abdeckung Schraube", "support vis", "plaque \u00e9crou"),
        *("DIN 912 holder", "soporte tornillo", "pump/Cylinder.001", "Cylinder.001"),
    ],
)
def test_names_that_do_not_say(name: str) -> None:
    assert is_fastener(f"engine/{name}") is None


def test_fasteners_are_left_out(mockup: feeler.Mockup) -> None:
    gone = left_out(mockup, Exclusion("standard parts", fasteners=True))
    assert gone == {pair for pair in FOUND if "bolt" in "".join(pair)}


def test_fasteners_are_known_by_their_shape() -> None:
    """One that nobody named is a fastener by its hexagon and shank; a name that says another thing wins."""
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    wall = box((-0.05, -0.05, -0.02), (0.05, 0.05, 0.0))
    for name, hidden in (("part_17", 1), ("sensor housing", 0)):
        found = feeler.clash(
            mockup_of({"wall": wall, name: (mesh.vertices, mesh.faces)}),
            rules={"exclude": [{"name": "f", "fasteners": True}]},
        )
        assert (len(found), found.hidden) == (1 - hidden, {"f": hidden})


@pytest.mark.parametrize(("size", "hidden"), [((0.02, 0.03, 0.04), 1), ((0.02, 0.02, 1.2), 1), ((0.5, 0.8, 1.0), 0)])
@pytest.mark.parametrize("name", ["Washer M8", "bolt", "DIN 125"])
def test_large_parts_are_no_fasteners_whatever_their_name(
    name: str, size: tuple[float, float, float], hidden: int
) -> None:
    """A threaded rod may be long."""
    parts = {"wall": box((-1.0, -1.0, -0.2), (1.0, 1.0, 0.01)), name: box((0.0, 0.0, 0.0), size)}
    found = feeler.clash(mockup_of(parts), rules={"exclude": [{"name": "f", "fasteners": True}]})
    assert (len(found), found.hidden) == (1 - hidden, {"f": hidden})
    tried = feeler.clash(mockup_of(parts)).with_rules(
        {"exclude": [{"name": "f", "fasteners": True}]}, mockup=mockup_of(parts)
    )
    assert tried.hidden == {"f": hidden}


def test_each_rule_says_how_many_findings_it_hides(mockup: feeler.Mockup) -> None:
    hiding = (
        Exclusion("copies", "*copy*"),
        Exclusion("standard parts", fasteners=True),
        Exclusion("nothing", "*core*", "*near*"),
    )
    found = feeler.clash(mockup, rules=Rules((Rule("walls", "house/walls", "house/walls", level=2),), hiding))
    copies = {pair for pair in FOUND if "copy" in "".join(pair)}
    bolts = {pair for pair in FOUND if "bolt" in "".join(pair)} - copies
    assert found.hidden == {"copies": len(copies), "standard parts": len(bolts), "nothing": 0, "walls": 1}
    assert len(found) == len(FOUND) - sum(found.hidden.values()), "each is counted once, for the first that names it"


def test_hidden_findings_are_counted_in_the_file_and_the_report(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, rules=Rules(exclusions=(Exclusion("copies", "*copy*"),)))
    found.save(tmp_path / "a.json")
    assert found.hidden["copies"] > 0
    assert feeler.load_clashes(tmp_path / "a.json").hidden == report(found)["hidden"] == found.hidden


def test_names_that_are_not_there_are_told_with_near_ones(mockup: feeler.Mockup) -> None:
    with pytest.raises(
        OptionError,
        match=r"rules, rule 'x', b: no part matches '\*blot\*'; do you mean 'bolt M8x30'\? \(optional = true",
    ):
        ruled(mockup, Rule("x", "*", "*blot*"))
    with pytest.raises(OptionError, match=r"exclusion 'y', a: no path matches 're:walls/\.\*' as a whole"):
        left_out(mockup, Exclusion("y", "re:walls/.*"))
    for optional in (False, True):
        with pytest.raises(
            OptionError, match=r"rules, rule 'x', a: 're:\(' is not a regular expression: .*position 0$"
        ):
            ruled(mockup, Rule("x", "re:(", optional=optional))
    assert left_out(mockup, Exclusion("y", "*blot*", optional=True)) == set()
    assert ruled(mockup, Rule("x", "*blot*", optional=True)).keys() == FOUND.keys()


def test_too_many_classes_are_refused(monkeypatch: pytest.MonkeyPatch, mockup: feeler.Mockup) -> None:
    monkeypatch.setattr(limits, "CLASS_LIMIT", 2)
    with pytest.raises(OptionError, match="patterns put the parts into 3 classes, and 2 are the most"):
        ruled(mockup, Rule("x", "house/walls", "house/pins"))


def test_wrong_rules() -> None:
    make: Any = Rule
    for words, message in [
        ({"clearance": -1.0}, "rule 'x': clearance is -1.0: give metres"),
        ({"clearance": True}, "clearance is True"),
        ({"contact": "chrod"}, "contact is 'chrod': give metres, 0 or more, or \"chord\""),
        ({"severity": "mayor"}, "severity is 'mayor': do you mean major"),
        ({"level": -1}, "level is -1"),
        ({"level": 1.5}, "level is 1.5"),
        ({"a": 3}, "a is 3: give a pattern of paths, or several"),
        ({"b": ["x", ""]}, "give a pattern of paths"),
    ]:
        with pytest.raises(OptionError, match=re.escape(message)):
            make("x", **words)
    for words in ({}, {"a": "x", "fasteners": True}, {"same_assembly": 1, "fasteners": True}):
        with pytest.raises(OptionError, match="exclusion 'y': give one of a, same_assembly and fasteners"):
            Exclusion("y", **words)  # type: ignore[arg-type]
    for names in (("x", "x"), ("",), ("default",)):
        with pytest.raises(OptionError, match="the name of a rule"):
            Rules(tuple(Rule(name) for name in names))


FILE = """
version = 1
others = false

[[rule]]
name = "walls against pins"
a = "house/walls"
b = ["*bolt*", "re:.*/core"]
clearance = 0.005
contact = 0.0001
severity = "critical"
level = 3

[[exclude]]
name = "copies"
a = "*copy*"

[[exclude]]
name = "rooms"
same_assembly = 2

[[exclude]]
name = "standard parts"
fasteners = true
"""


def test_a_file_is_read(tmp_path: Path, mockup: feeler.Mockup) -> None:
    path = tmp_path / "clash.toml"
    path.write_text(FILE, encoding="utf-8")
    read = Rules.read(path)
    (rule,) = read.rules
    assert rule == Rule(
        "walls against pins", ("house/walls",), ("*bolt*", "re:.*/core"), 0.005, 0.0001, "critical", level=3
    )
    assert [each.name for each in read.exclusions] == ["copies", "rooms", "standard parts"] and not read.others
    found = feeler.clash(mockup, rules=path)
    assert pairs(found) == {("house/walls/right", "house/pins/core"): "contained"}
    assert found.ids == feeler.clash(mockup, rules=str(path)).ids == feeler.clash(mockup, rules=read).ids
    same = {
        "rule": [{"name": "walls against pins", "a": "house/walls", "b": ["*bolt*", "*core*"], "clearance": 0.005}],
        "exclude": [{"name": "copies", "a": "*copy*"}, {"name": "f", "fasteners": True}],
        "others": False,
    }
    assert feeler.clash(mockup, rules=same).ids == found.ids


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "clash.toml").write_bytes(b"\xef\xbb\xbf" + FILE.encode())
    assert [each.name for each in Rules.read(tmp_path / "clash.toml").rules] == ["walls against pins"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("version = 1", "version = 2", "is of version 2, and this feeler reads 1"),
        ("others = false", 'others = "no"', "others is 'no': give true or false"),
        ("clearance =", "clearence =", "rule 1: there is no 'clearence': do you mean clearance"),
        ("[[rule]]", "[[rules]]", "there is no 'rules': do you mean rule"),
        ("[[rule]]", "[rule]", r"rule is not a list of tables: write \[\[rule\]\] above each"),
        ('"critical"', '"crit"', "rule 1, rule 'walls against pins': severity is 'crit': do you mean critical"),
        ("0.005", "-0.005", "clearance is -0.005: give metres"),
        ('name = "copies"', "", "exclude 1: it has no name"),
        ("fasteners = true", "fasteners = 1", "exclude 3: fasteners is 1: give true or false"),
        ("level = 3", "level = ", "not valid TOML"),
        ("same_assembly = 2", "same_assembly = 0", "give one of a, same_assembly and fasteners"),
        ('name = "walls against pins"', 'name = "default"', "the name of a rule is that of the pairs"),
    ],
)
def test_what_a_file_says_wrong(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "clash.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(LoadError, match=message) as caught:
        Rules.read(path)
    assert "clash.toml" in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path, mockup: feeler.Mockup) -> None:
    with pytest.raises(MissingFileError, match=r"none\.toml does not exist: feeler clash --write-rules"):
        feeler.clash(mockup, rules=tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(LoadError, match="not valid TOML"):
        Rules.read(tmp_path / "binary.toml")
    with pytest.raises(LoadError, match="cannot be read"):
        Rules.read(tmp_path)
    (tmp_path / "deep.toml").write_text("x = " + "[" * 100_000)
    with pytest.raises(LoadError, match="not valid TOML"):
        Rules.read(tmp_path / "deep.toml")


def test_a_file_is_started_from_what_was_found(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, contact=0.001)
    write_rules(tmp_path / "clash.toml", found)
    text = (tmp_path / "clash.toml").read_text(encoding="utf-8")
    again = feeler.clash(mockup, clearance=0.0, rules=tmp_path / "clash.toml")
    assert pairs(again) == pairs(found), "nothing is lost when it is read"
    assert set(again.rules.tolist()) == {"within house", "house against yard"}
    # What is left out by hand is there as a comment, ready to be used.
    commented = "".join(line[2:] if line.startswith("# ") else "" for line in text.splitlines(keepends=True))
    exclusions = commented[commented.index("[[exclude]]") :]
    exclusions = "\n".join(line for line in exclusions.splitlines() if line.startswith(("[[", "name", "a", "b", "f")))
    (tmp_path / "left.toml").write_text(text + "\n" + exclusions, encoding="utf-8")
    rest = pairs(feeler.clash(mockup, contact=0.001, rules=tmp_path / "left.toml"))
    assert rest == {
        pair: verdict for pair, verdict in pairs(found).items() if verdict != "contact" and "bolt" not in "".join(pair)
    }


def test_names_from_files_are_quoted(tmp_path: Path) -> None:
    name = 'he said "x"\\ \u00e4\x07\x7f\U0001d11e'
    mockup = mockup_of(
        {name: box((0, 0, 0), (1, 1, 1)), "[b]": box((0.5, 0, 0), (2, 1, 1)), "c": box((9, 9, 9), (10, 10, 10))}
    )
    write_rules(tmp_path / "clash.toml", feeler.clash(mockup))
    found = feeler.clash(mockup, rules=tmp_path / "clash.toml")
    assert len(found) == 1 and found.rules[0] != "default"


@pytest.mark.parametrize(
    "names",
    [
        ("/World/a", "/World/b", "c"),
        ("/World/a", "World/b", "c"),
        ("", "a", "b"),
        ("/slash/", "a", "b"),
        ("/", "a", "c"),
        ("re:a", "re:(", "b"),
        ("re:a/x", "re:a/y", "re:c"),
        ("a/", "a/b", "c"),
        ("re:line\nbreak/x", "b", "c"),
        ("\ud800", "x\udfff/y", "c?[1]*"),
        (" ", "material:steel", "!a"),
    ],
)
def test_files_of_rules_name_what_was_found(tmp_path: Path, names: tuple[str, ...]) -> None:
    """Whatever the names look like: roots of USD, none, regular expressions, and what no file can store."""
    vertices, faces = box((0, 0, 0), (0.2, 0.2, 0.5))
    shapes = [vertices + np.array([0.15 * i, 0, 0]) for i in range(3)]
    mockup = feeler.Mockup(
        np.concatenate(shapes),
        np.concatenate([faces + 8 * i for i in range(3)]),
        np.repeat([0, 1, 2], 12),
        [name.rpartition("/")[2] for name in names],
        part_paths=list(names),
    )
    found = feeler.clash(mockup, clearance=0.001, contact=1e-5)
    write_rules(tmp_path / "clash.toml", found)
    again = feeler.clash(mockup, clearance=0.0, rules=tmp_path / "clash.toml")
    assert len(found) == 2 and pairs(again) == pairs(found) and "default" not in again.rules
    # So do the exclusions in its comments.
    touching = feeler.clash(mockup, clearance=0.001, contact=1.0)
    write_rules(tmp_path / "touching.toml", touching)
    lines = [line[2:] for line in (tmp_path / "touching.toml").read_text(encoding="utf-8").splitlines()[4:]]
    start = lines.index("[[exclude]]")
    text = "\n".join(line for line in lines[start:] if line.startswith(("[[", "name", "a =", "b =")))
    (tmp_path / "left.toml").write_text(text.rpartition("[[exclude]]")[0], encoding="utf-8")
    assert len(feeler.clash(mockup, clearance=0.001, rules=tmp_path / "left.toml")) == 0


def test_two_rules_may_share_their_last_names(tmp_path: Path) -> None:
    shapes = {f"r/{i}/x": box((3 * i, 0, 0), (3 * i + 1, 1, 1)) for i in range(2)}
    shapes |= {f"r/{i}/y": box((3 * i + 0.5, 0, 0), (3 * i + 2, 1, 1)) for i in range(2)}
    mockup = mockup_of(shapes)
    write_rules(tmp_path / "clash.toml", feeler.clash(mockup))
    assert len(set(feeler.clash(mockup, rules=tmp_path / "clash.toml").rules.tolist())) == 2


def test_classes_are_as_few_as_the_patterns_tell_apart(mockup: feeler.Mockup) -> None:
    made = limits.limits(
        Rules((Rule("x", "house/walls", "house/pins"), Rule("y", "*left*"))),
        mockup.parts,
        mockup.part_paths,
        0.002,
        0.0,
        None,
        np.empty((0, 2), np.uint32),
    )
    assert made.clearance.shape == (5, 5) and (made.clearance == made.clearance.T).all()
    a, b = np.array([0, 0, 1], np.uint32), np.array([2, 6, 6], np.uint32)
    assert [made.names[i] for i in made.rule_of(a, b)] == ["x", "y", "default"]


def test_saved_findings_know_the_names_of_parts(tmp_path: Path) -> None:
    """Rules give the same findings as a new check, also where names are not the last steps of paths."""
    (first, faces), (second, _) = box((0, 0, 0), (1, 1, 1)), box((0.9, 0, 0), (2, 1, 1))
    mockup = feeler.Mockup(
        np.concatenate([first, second]),
        np.concatenate([faces, faces + 8]),
        np.repeat([0, 1], 12),
        ["Pump body", "shaft"],
        part_paths=["asm/id_001", "asm/shaft"],
    )
    found = feeler.clash(mockup)
    found.save(tmp_path / "a.json")
    loaded = feeler.load_clashes(tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    assert data["names"] == {"asm/id_001": "Pump body"} and loaded.facts.names == found.facts.names
    loaded.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "a.json").read_bytes()
    for pattern in ("Pump body", "id_001", "*body*", "shaft", "asm/id_001"):
        rules = {"exclude": [{"name": "n", "a": pattern, "optional": True}]}
        fresh = feeler.clash(mockup, rules=rules).hidden
        for table in (found, found[:], loaded, pickle.loads(pickle.dumps(loaded)), loaded.with_rules({})):
            assert table.with_rules(rules).hidden == fresh, pattern
    # Files of before, and files of others.
    old = {key: value for key, value in data.items() if key != "names"}
    (tmp_path / "old.json").write_text(json.dumps(old))
    rules = {"exclude": [{"name": "n", "a": "id_001"}]}
    assert feeler.load_clashes(tmp_path / "old.json").with_rules(rules).hidden == {"n": 1}
    for wrong in ([], {"asm/id_001": 3}):
        (tmp_path / "bad.json").write_text(json.dumps({**data, "names": wrong}))
        with pytest.raises(LoadError, match='"names" is not texts by part'):
            feeler.load_clashes(tmp_path / "bad.json")
