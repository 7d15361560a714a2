"""Clearances that must hold: told by distances that are known, read from files, and by the command."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from clash_scene import mockup_of
from commands import error_of, run, run_json
from shapes import box

import feeler
from feeler.cli.projects import Work, keep_work
from feeler.errors import LoadError, MeshError, MissingFileError, OptionError
from feeler.io import write_glb
from feeler.project.book import open_or_make
from feeler.project.store import put
from feeler.workbench.session.session import Session


def yard() -> feeler.Mockup:
    """A pipe 10 mm beside a duct, one that touches it, one 2 mm inside it, and a core within the duct."""
    return mockup_of(
        {
            "duct/wall": box((0, 0, 0), (1, 1, 1)),
            "duct/core": box((0.4, 0.4, 0.4), (0.6, 0.6, 0.6)),
            "pipes/near": box((1.0078125, 0, 0), (1.1, 1, 1)),
            "pipes/flush": box((0, 1, 0), (1, 1.1, 1)),
            "pipes/sunk": box((0, 0, 0.998046875), (1, 1, 1.1)),
        }
    )


def asked(a: str, b: str, gap: float) -> feeler.Requirement:
    return feeler.Requirement("one", a, b, gap)


@pytest.mark.parametrize(
    ("a", "gap", "holds"),
    [
        *(("*near", 0.0078125, True), ("*near", 0.0078126, False), ("*near", 0.0, True)),
        *(("*flush", 0.0, True), ("*flush", 1e-9, False)),
        *(("*sunk", 0.0, False), ("duct/core", 0.0, False)),
    ],
)
def test_a_requirement_holds_from_its_gap_on(a: str, gap: float, holds: bool) -> None:
    (found,) = feeler.verify(yard(), [asked(a, "duct/wall", gap)])
    assert bool(found) is holds and found.status == ("holds" if holds else "violated")
    assert (found.gap is None) == (found.path_a is None) == (found.pairs == 0) == holds
    (turned,) = feeler.verify(yard(), [asked("duct/wall", a, gap)])
    assert turned.status == found.status, "the order of the sides does not matter"


@pytest.mark.parametrize("gap", [0.001, 0.16, 0.3])
def test_a_gap_that_is_drawn_as_required_holds(tmp_path: Path, gap: float) -> None:
    """Arithmetic rounds, and files of single precision do."""
    low = 0.1 + 0.2
    mockup = mockup_of({"a": box((0, 0, 0), (low, 1, 1)), "b": box((low + gap, 0, 0), (3, 1, 1))})
    write_glb(tmp_path / "gap.glb", mockup)
    for world, off in ((mockup, 1e-12), (feeler.load_mockup(tmp_path / "gap.glb"), 2e-6)):
        assert feeler.verify(world, [asked("a", "b", gap)])[0]
        assert not feeler.verify(world, [asked("a", "b", gap + off)])[0]


def test_the_worst_pair_is_reported() -> None:
    (found,) = feeler.verify(yard(), [asked("pipes", "duct/wall", 0.02)])
    assert (found.pairs, {found.path_a, found.path_b}) == (3, {"pipes/sunk", "duct/wall"})
    assert found.depth == pytest.approx(0.001953125, rel=2e-3) and found.gap == 0.0
    scene = feeler.Scene(yard()).without("*sunk")
    (found,) = feeler.verify(scene, [asked("pipes", "duct/wall", 0.02)])
    assert (found.pairs, found.depth, found.gap) == (2, 0.0, 0.0) and "pipes/flush" in (found.path_a, found.path_b)
    scene = scene.without("*flush")
    (found,) = feeler.verify(scene, [asked("pipes", "duct/wall", 0.02)])
    assert (found.pairs, found.gap) == (1, 0.0078125)
    assert found.point_a is not None and found.point_b is not None
    assert np.linalg.norm(np.subtract(found.point_a, found.point_b)) == pytest.approx(0.0078125)


def test_each_requirement_is_asked_for_itself() -> None:
    both = [asked("*near", "duct", 0.005), feeler.Requirement("two", "*near", "*wall", 0.05)]
    assert [each.status for each in feeler.verify(yard(), both)] == ["holds", "violated"]
    (alone,) = feeler.verify(yard(), [asked("duct/wall", "duct/wall", 1.0)])
    assert alone, "a part is not compared with itself"


def test_a_random_box_is_as_far_as_its_coordinates_say() -> None:
    random = np.random.default_rng(3)
    for _ in range(40):
        away = random.uniform(0.001, 0.2)
        mockup = mockup_of({"one": box((0, 0, 0), (1, 1, 1)), "other": box((1 + away, 0, 0), (2, 1, 1))})
        real = float(mockup.part_bounds.reshape(-1, 2, 3)[1, 0, 0]) - 1.0
        gap = random.uniform(0.0, 0.25)
        (found,) = feeler.verify(mockup, [asked("one", "other", gap)])
        assert bool(found) == (real >= gap), (real, gap)


FILE = """
version = 1
[[requirement]]
name = "near pipe"
a = ["*near", "re:.*/nothing"]
b = "duct"
gap = 0.005
optional = true
[[requirement]]
name = "flush pipe"
a = "*flush"
b = "*wall"
gap = 0.001
"""


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "requirements.toml"
    path.write_text(FILE)
    near, flush = feeler.read_requirements(path)
    assert near == feeler.Requirement("near pipe", ("*near", "re:.*/nothing"), ("duct",), 0.005, True)
    found = feeler.verify(yard(), path)
    assert [each.status for each in found] == ["holds", "violated"] and found[1].requirement == flush
    assert pickle.loads(pickle.dumps(found)) == found
    said = found[1].to_dict()
    assert (said["name"], said["required_gap"], said["gap"]) == ("flush pipe", 0.001, 0.0)
    assert json.loads(json.dumps(said)) == said
    with pytest.raises(MissingFileError):
        feeler.read_requirements(tmp_path / "nothing.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[requirement", "not valid TOML"),
        ("version = 2", "of version 2"),
        ("", "has no requirement"),
        ("[requirement]\nname = 1", "write \\[\\[requirement\\]\\]"),
        ('[[requirement]]\nname = "x"\na = "*"\nb = "*"', "requirement 1: it has no gap"),
        ('[[requirement]]\nname = "x"\na = "*"\nb = "*"\ngap = -1', "gap"),
        ('[[requirement]]\nname = "x"\na = "*"\nb = 3\ngap = 1', "b is 3"),
        ('[[requirement]]\nname = "x"\na = "*"\nb = "*"\ngap = 1\ngab = 2', "there is no 'gab'.*gap"),
        (FILE + FILE.replace("version = 1", ""), "two requirements are called 'near pipe'"),
    ],
)
def test_what_is_wrong_in_a_file_is_said(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(LoadError, match=words):
        feeler.read_requirements(tmp_path / "a.toml")


def test_what_cannot_be_asked() -> None:
    with pytest.raises(OptionError, match=r"^requirement 'one': b is 3: "):
        feeler.Requirement("one", "a", 3, 0.1)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match=r"requirement 'one', a: .*nothing"):
        feeler.verify(yard(), [asked("nothing", "*", 0.1)])
    with pytest.raises(MeshError):
        feeler.verify("engine.step", [])  # type: ignore[arg-type]
    assert feeler.verify(yard(), []) == ()


def test_the_command(tmp_path: Path) -> None:
    write_glb(tmp_path / "yard.glb", yard())
    (tmp_path / "r.toml").write_text(FILE.replace('"duct"', '"*wall"'))
    done = run("verify", tmp_path / "yard.glb", "--requirements", tmp_path / "r.toml", code=1)
    assert "2 requirements: 1 violated, 1 holds" in done.stdout
    assert "violated  flush pipe: " in done.stdout and "1 mm required" in done.stdout
    words = ("verify", tmp_path / "yard.glb", "--requirements", tmp_path / "r.toml", "--json")
    answer = json.loads(run(*words, code=1).stdout)
    assert answer["holds"] is False and [each["status"] for each in answer["requirements"]] == ["holds", "violated"]
    rest = json.loads(run(*words, "--without", "*flush", code=2).stdout)
    assert rest["holds"] is False and [each["status"] for each in rest["requirements"]] == ["holds", "unknown"]


def project_of(folder: Path, *asked: tuple[str, str, str, float], of: feeler.Mockup | None = None) -> Path:
    """A project of the yard in the file yard.glb, with requirements made in the workbench."""
    write_glb(folder / "yard.glb", yard() if of is None else of)
    world = feeler.load_mockup(folder / "yard.glb")
    book = open_or_make(folder / "yard.feelproj")
    session = Session(project=book, has_threads=False)
    session.open(world, feeler.Scene(world, threads=1), None, name="yard.glb")
    keep_work(book, Work([str(folder / "yard.glb")]))
    for name, a, b, gap in asked:
        session.command("requirement_add", {"name": name, "a": a, "b": b, "gap": gap})
    session.close()
    return folder / "yard.feelproj"


def test_the_requirements_of_a_project_are_checked(tmp_path: Path) -> None:
    path = project_of(tmp_path, ("near", "*near", "*wall", 0.005), ("near", "*flush", "*wall", 0.001))
    before = path.read_bytes()
    done = run("verify", path, code=1)
    assert "2 requirements: 1 violated, 1 holds" in done.stdout
    assert "violated  near 2: " in done.stdout, "as the page exports them"
    found = run_json("verify", path, "--without", "*flush", code=2)["requirements"]
    assert [(each["name"], each["status"]) for each in found] == [("near", "holds"), ("near 2", "unknown")]
    assert path.read_bytes() == before, "it is only read"
    with feeler.open_project(path):
        assert len(run_json("verify", path, code=1)["requirements"]) == 2, "also one that is open elsewhere"


def test_the_requirements_of_a_project_follow_a_newer_revision(tmp_path: Path) -> None:
    path = project_of(tmp_path, ("near", "yard/pipes/near", "yard/duct/wall", 0.005))
    old = yard()
    paths = [each.replace("pipes/", "tubes/") for each in old.part_paths]
    newer = feeler.Mockup(old.vertices, old.faces, old.part_of_face, old.part_names, part_paths=paths)
    (tmp_path / "v2").mkdir()
    write_glb(tmp_path / "v2" / "yard.glb", newer)
    for words in ((path, tmp_path / "v2" / "yard.glb"), (tmp_path / "v2" / "yard.glb", "--project", path)):
        (found,) = run_json("verify", *words)["requirements"]
        assert (found["a"], found["status"]) == (["yard/tubes/near"], "holds")
    assert "none of its 5 parts" in error_of("verify", path, "sample:differential:10000")


def test_what_a_project_cannot_verify(tmp_path: Path) -> None:
    path = project_of(tmp_path)
    assert "has no requirements: add them in the workbench, or give --requirements" in error_of("verify", path)
    (tmp_path / "r.toml").write_text(FILE.replace('"duct"', '"*wall"'))
    assert "1 violated" in run("verify", path, "--requirements", tmp_path / "r.toml", code=1).stdout
    assert "nothing says what must hold" in error_of("verify", tmp_path / "yard.glb")
    assert "does not exist" in error_of("verify", tmp_path / "yard.glb", "--project", tmp_path / "no.feelproj")
    assert not (tmp_path / "no.feelproj").exists()
    none = project_of(tmp_path, ("none", "*nothing*", "*", 0.1), ("near", "*near", "*wall", 0.02))
    done = run("verify", none, code=2)
    assert done.stderr == "feeler: not checked, since parts that they name are missing: 'none'\n"
    assert "2 requirements: 1 violated, 0 hold, 1 not checked" in done.stdout
    assert "unknown   none: a: " in done.stdout and "violated  near: " in done.stdout
    rows = json.loads(run("verify", none, "--json", code=2).stdout)
    assert [each["status"] for each in rows["requirements"]] == ["unknown", "violated"] and not rows["holds"]
    for text in ('{"id":1,"name":"","a":"*","b":"*","gap":1}', '{"id":1,"name":"x","a":"*","b":"*","gap":-1}', "[]"):
        book = open_or_make(path)
        book.write([put("requirements", "1", 0, text)])
        book.close()
        assert "damaged" in error_of("verify", path)


@pytest.mark.parametrize("sides", [{"a": []}, {"b": []}, {"a": ()}])
def test_a_side_without_patterns_holds_nothing(sides: dict[str, object]) -> None:
    with pytest.raises(OptionError, match=r"requirement 1, requirement 'one': [ab] is empty: give a pattern"):
        feeler.verify(yard(), {"requirement": [{"name": "one", "a": "pipes", "b": "duct", "gap": 0.1, **sides}]})


def test_names_turn_no_terminal_red(tmp_path: Path) -> None:
    write_glb(tmp_path / "yard.glb", yard())
    (tmp_path / "r.toml").write_text(
        '[[requirement]]\nname = "\\u001b[31mred\\u202e"\na = "*near"\nb = "*core"\ngap = 0\n'
    )
    said = run("verify", tmp_path / "yard.glb", "--requirements", tmp_path / "r.toml").stdout
    assert "\x1b" not in said and "\\x1b[31mred\\u202e" in said


@pytest.mark.parametrize(
    ("a", "b", "without", "out"),
    [
        ("pipes/near", "duct/wall", ["pipes/near"], ("pipes/near",)),
        ("duct/wall", "pipes", ["pipes"], ("pipes/near", "pipes/flush", "pipes/sunk")),
        ("*", "pipes/near", ["pipes/near"], ("pipes/near",)),
        ("pipes", "pipes", ["pipes/near", "pipes/flush"], ("pipes/near", "pipes/flush")),
        ("pipes", "duct/wall", ["pipes/sunk", "pipes/flush"], ()),
    ],
)
def test_one_whose_parts_are_out_is_unknown(a: str, b: str, without: list[str], out: tuple[str, ...]) -> None:
    """Nothing was compared, so it does not hold, unless it need not be there."""
    scene = feeler.Scene(yard()).without(without)
    for one, other in ((a, b), (b, a)):
        (found,) = feeler.verify(scene, [asked(one, other, 1e-3)])
        assert found.out == out and found.status == ("unknown" if out else "holds") and bool(found) is not bool(out)
        (found,) = feeler.verify(scene, [feeler.Requirement("one", one, other, 1e-3, optional=True)])
        assert found.status == "holds" and found.trouble is None


def test_the_command_says_which_parts_are_out(tmp_path: Path) -> None:
    write_glb(tmp_path / "yard.glb", yard())
    (tmp_path / "clear.toml").write_text(
        '[[requirement]]\nname = "pipes"\na = "yard/pipes"\nb = "*wall"\ngap = 0.001\n'
        '[[requirement]]\nname = "core"\na = "*core"\nb = "*near"\ngap = 0.001\n'
    )
    given = ("verify", tmp_path / "yard.glb", "--requirements", tmp_path / "clear.toml", "--without", "yard/pipes")
    done = run(*given, code=2)
    assert "2 requirements: 0 violated, 0 hold, 2 not checked" in done.stdout
    assert "unknown   pipes: yard/pipes/near and 2 other parts are not in the scene" in done.stdout
    assert "unknown   core: yard/pipes/near is not in the scene" in done.stdout
    assert "not checked, since parts that they name are missing: 'pipes', 'core'" in done.stderr
    rows = run_json(*given, code=2)["requirements"]
    assert [row["status"] for row in rows] == ["unknown"] * 2 and rows[1]["out"] == ["yard/pipes/near"]
