"""`feeler clash`: what it says, what it writes, and how it ends."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from clash_scene import FOUND, box, house, mockup_of, pairs, without
from commands import error_of, run, run_json

import feeler
from feeler.io import write_glb

ROOT = Path(__file__).resolve().parent


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("house") / "house.glb"
    write_glb(path, house())
    return path


def found_in(document: dict[str, object]) -> dict[tuple[str, str], str]:
    rows = document["clashes"]
    assert isinstance(rows, list)
    return {(row["a"].removeprefix("house/"), row["b"].removeprefix("house/")): row["verdict"] for row in rows}


def test_what_people_read(file: Path) -> None:
    text = run("clash", file).stdout
    assert "9 findings among 7 parts" in text and "4 clash, 2 contact, 1 clearance, 1 contained, 1 duplicate" in text
    groups, _, findings = text.partition("Findings, the worst first")
    assert "Groups by part" in groups and "house/walls/left" in groups
    assert "left and left have the same surface" in groups and "62.5 mm" in findings and "status" not in findings
    assert "bolt M8x30" in findings and "touching" in findings and "976.6 µm apart" in findings
    # Duplicates come first, and have no depth to state.
    assert "same surface" in next(line for line in findings.splitlines() if "house/" in line)
    assert "0 m " not in findings


def test_what_machines_read(file: Path) -> None:
    document = run_json("clash", file)
    assert found_in(document) == FOUND
    assert document["counts"]["clash"] == 4 and document["partial"] is False and document["failed"] is False
    assert document["mockup"]["parts"] == 7 and document["written"] == {}
    assert {row["group"] for row in document["clashes"]} == {group["name"] for group in document["groups"]}
    by_rule = run_json("clash", file, "--by", "rule")
    assert [group["name"] for group in by_rule["groups"]] == ["default"]
    assert len(found_in(run_json("clash", file, "--clearance", "0"))) == len(FOUND) - 1
    walls = ("house/walls/left", "house/walls/right")
    assert found_in(run_json("clash", file, "--contact", "0.07"))[walls] == "contact"
    assert walls not in found_in(run_json("clash", file, "--without", "*walls/right"))
    assert found_in(run_json("clash", file, "--only", "*walls*")) == {walls: "clash"}


def test_everything_is_written(tmp_path: Path, file: Path) -> None:
    names = {
        "csv": "a.csv",
        "xlsx": "a.xlsx",
        "html": "a.html",
        "bcf": "a.bcf",
        "glb": "a.glb",
        "save": "a.json",
        "write-rules": "a.toml",
    }
    words = [word for option, name in names.items() for word in (f"--{option}", tmp_path / name)]
    written = run_json("clash", file, *words, "--threads", "1")["written"]
    assert written == {option: str(tmp_path / name) for option, name in names.items()}
    assert {path.name for path in tmp_path.iterdir()} == set(names.values())
    assert pairs(feeler.load_clashes(tmp_path / "a.json")).values() is not None
    again = run_json("clash", file, "--rules", tmp_path / "a.toml")
    assert len(again["clashes"]) == len(FOUND) and {row["rule"] for row in again["clashes"]} != {"default"}
    assert f"bcf written to {tmp_path / 'a.bcf'}" in run("clash", file, "--bcf", tmp_path / "a.bcf").stdout


def test_from_check_to_check(tmp_path: Path, file: Path) -> None:
    last, now = tmp_path / "last.json", tmp_path / "now.json"
    run("clash", file, "--save", last)
    text = run("clash", file, "--previous", last, "--save", now, "--fail-on", "new").stdout
    assert "0 new, 9 active, 0 reviewed, 0 approved, 0 resolved" in text and "active" in text.partition("Findings,")[2]
    accepted = feeler.load_clashes(now)
    for each in accepted.ids:
        accepted.set_status(each, "approved", by="ada")
    accepted.save(now)
    words = ["clash", file, "--previous", now, "--fail-on"]
    assert run_json(*words, "new")["statuses"]["approved"] == 9
    assert run_json(*words, "any", code=1)["failed"] is True
    run(*words, "approved,clash", code=1)
    run(*words, "new,clash")
    write_glb(tmp_path / "house.glb", without("house/copy/left"))
    document = run_json("clash", tmp_path / "house.glb", "--previous", now, "--save", last)
    assert document["statuses"] == {"new": 0, "active": 0, "reviewed": 0, "approved": 5, "resolved": 4}
    assert len(document["earlier"]) == 4
    run("clash", file, "--previous", last, "--fail-on", "new", code=1)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("any", 1),
        ("new", 1),
        ("clash", 1),
        ("active", 0),
        ("critical", 0),
        ("major", 1),
        ("clash,duplicate", 1),
        ("Clash, NEW", 1),
        ("clash,active", 0),
        ("clash,minor", 0),
    ],
)
def test_the_exit_status_is_what_was_asked_for(file: Path, words: str, code: int) -> None:
    run("clash", file, "--fail-on", words, code=code)
    run("clash", file, "--only", "*near", "--fail-on", words)


def test_approved_findings_grow_by_as_much_as_is_said(tmp_path: Path) -> None:
    from clash_scene import moved

    for name, by in (("a.glb", 0.0), ("b.glb", -0.001)):
        write_glb(tmp_path / name, moved(by))
    run("clash", tmp_path / "a.glb", "--save", tmp_path / "a.json")
    accepted = feeler.load_clashes(tmp_path / "a.json")
    for each in accepted.ids:
        accepted.set_status(each, "approved")
    accepted.save(tmp_path / "a.json")
    words = ["clash", tmp_path / "b.glb", "--previous", tmp_path / "a.json", "--fail-on", "new,clash"]
    run(*words, code=1)
    run(*words, "--growth", "0.01")


def test_bad_input(tmp_path: Path, file: Path) -> None:
    assert "--clearance is '-1': give a length" in error_of("clash", file, "--clearance", "-1")
    assert "--contact is 'much'" in error_of("clash", file, "--contact", "much")
    assert 'contact="chord"' in error_of("clash", file, "--contact", "chord")
    assert "--contact is 'nan'" in error_of("clash", file, "--contact", "nan")
    assert "--by is 'parts': do you mean part" in error_of("clash", file, "--by", "parts")
    assert "--fail-on has 'crash': do you mean clash" in error_of("clash", file, "--fail-on", "new,crash")
    assert "resolved" in error_of("clash", file, "--fail-on", "resolved")
    assert "--growth compares with an earlier check" in error_of("clash", file, "--growth", "1")
    assert "--csv" in error_of("clash", file, "--csv", tmp_path / "a.txt")
    assert "must end in .json" in error_of("clash", file, "--save", tmp_path / "a.txt")
    assert "does not exist" in error_of("clash", file, "--html", tmp_path / "no" / "a.html")
    assert "rules.toml does not exist" in error_of("clash", file, "--rules", tmp_path / "rules.toml")
    assert "last.json does not exist" in error_of("clash", file, "--previous", tmp_path / "last.json")
    assert "--only: no part" in error_of("clash", file, "--only", "nothing")
    assert "--threads is '0'" in error_of("clash", file, "--threads", "0")
    (tmp_path / "rules.toml").write_text('[[rule]]\nname = "x"\na = "*blot*"\n')
    message = error_of("clash", file, "--rules", tmp_path / "rules.toml")
    assert "rule 'x', a: no part matches" in message and "bolt" in message
    write_glb(tmp_path / "ship.glb", mockup_of({"hull": box((0, 0, 0), (9, 1, 1)), "mast": box((2, 0, 0), (3, 1, 7))}))
    run("clash", file, "--save", tmp_path / "last.json")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(feeler, "clash", None)  # it is told before the work
        assert "none of the saved parts exist in this mock-up (0 of 7," in error_of(
            "clash", tmp_path / "ship.glb", "--previous", tmp_path / "last.json"
        )
    (tmp_path / "last.json").write_text((tmp_path / "last.json").read_text()[:300])
    assert "cut short" in error_of("clash", file, "--previous", tmp_path / "last.json")


def test_a_cap_is_told(tmp_path: Path, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from feeler.clashes import as_bcf

    monkeypatch.setitem(as_bcf.write_bcf.__kwdefaults__, "most", 1)
    result = run("clash", file, "--bcf", tmp_path / "a.bcf")
    assert "a.bcf has the 1 worst of" in " ".join(result.stderr.split())


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_leaves_what_was_found(tmp_path: Path, file: Path) -> None:
    """The signal comes while pairs are looked for: out of the progress function, so that there is such a moment."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
        "import os, signal\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import clash_twin, feeler.cli.clash as command\n"
        "from feeler import _core\n"
        "_core.clash = clash_twin.clash  # the core may be done before it hears\n"
        "from contextlib import contextmanager\n"
        "@contextmanager\n"
        "def bar(label):\n"
        "    def report(fraction, stage=''):\n"
        "        if label == 'looking for clashes' and fraction > 0.25:\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "    yield report\n"
        "command.bar = bar\n"
        "from feeler.cli import main; main()"
    )
    words = ["clash", str(file), "--save", str(tmp_path / "a.json"), "--html", str(tmp_path / "a.html"), "--json"]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 130, done.stderr
    assert "interrupted" in done.stderr and "Traceback" not in done.stderr
    document = json.loads(done.stdout)
    assert document["partial"] is True and found_in(document).items() < FOUND.items()
    saved = feeler.load_clashes(tmp_path / "a.json")
    assert saved.is_partial and len(saved) == len(document["clashes"])
    assert "The check was stopped" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_volumes_on_the_command_line(file: Path) -> None:
    pytest.importorskip("manifold3d")
    rows = run_json("clash", file, "--volume")["clashes"]
    assert {row["volume"] is None for row in rows} == {False}
    text = " ".join(run("clash", file, "--volume").stdout.split())
    assert "shared volume: 1.156 m³ in all" in text and "shared volume" in text.split("Findings, the worst first")[1]
    assert "shared volume" not in run("clash", file).stdout


def test_the_command_says_what_each_rule_hides(tmp_path: Path, file: Path) -> None:
    (tmp_path / "a.toml").write_text('[[exclude]]\nname = "standard parts"\nfasteners = true\n')
    assert "hidden: 2 by standard parts" in run("clash", file, "--rules", tmp_path / "a.toml").stdout
    assert "hidden" not in run("clash", file).stdout


@pytest.fixture(scope="module")
def saved(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "a.json"
    run("clash", file, "--save", path)
    return path


def test_saved_findings_are_shown(saved: Path) -> None:
    assert "9 findings among 7 parts\n" in run("clash", saved).stdout


def test_rules_are_tried_on_saved_findings(tmp_path: Path, file: Path, saved: Path) -> None:
    (tmp_path / "a.toml").write_text('[[exclude]]\nname = "copies"\na = "*copy*"\n')
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(feeler, "clash", None)  # the engine is not asked
        tried = run_json("clash", saved, "--rules", tmp_path / "a.toml", "--html", tmp_path / "a.html")
    assert tried["hidden"] == {"copies": 4} and tried["mockup"] is None
    assert found_in(tried) == found_in(run_json("clash", file, "--rules", tmp_path / "a.toml"))
    assert "4 by copies" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_rules_that_need_another_check_say_so(tmp_path: Path, saved: Path) -> None:
    (tmp_path / "a.toml").write_text('[[rule]]\nname = "wide"\nclearance = 0.5\n')
    assert "rule 'wide' asks for 500 mm" in run("clash", saved, "--rules", tmp_path / "a.toml").stdout


def test_a_check_is_not_made_of_saved_findings(tmp_path: Path, saved: Path) -> None:
    message = error_of("clash", saved, "--chord-tolerance", "0.1", "--up", "z")
    assert "--up, --chord-tolerance: saved findings are not checked again" in message
    message = error_of("clash", saved, "--clearance", "0.1", "--bcf", tmp_path / "a.bcf")
    assert "--clearance, --bcf: saved findings are not checked again. Pass the mock-up" in message


@pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")
def test_the_chord_tolerance_of_step_can_be_given(testdata: Path) -> None:
    """The pins of the assembly have more triangles, and the check says so."""
    assembly = testdata / "meshes" / "assembly.step"
    coarse, fine = (run_json("clash", assembly, *given) for given in ((), ("--chord-tolerance", "1e-6")))
    assert fine["mockup"]["triangles"] > 2 * coarse["mockup"]["triangles"]
    assert "--chord-tolerance is '-1': give a length above 0" in error_of("clash", assembly, "--chord-tolerance", "-1")


@pytest.mark.parametrize(("chord", "few"), [(None, None), (1e-5, None), (1e-4, "1 clash is")])
def test_clashes_below_the_chordal_error_are_in_doubt(chord: float | None, few: str | None) -> None:
    from feeler.cli.clash import _chord_doubt

    fit = mockup_of({"pin": box([0, 0, 0], [0.01, 0.01, 0.05]), "bush": box([0.00995, 0, 0], [0.02, 0.01, 0.05])})
    said = _chord_doubt(feeler.clash(fit), chord)
    assert said is None if few is None else (said or "").startswith(few) and "--contact chord" in (said or "")
