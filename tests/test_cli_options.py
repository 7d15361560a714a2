"""Values of options: every option of every command refuses what it cannot read, in one line that names it."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest
import typer
from commands import error_of, run, run_json
from shapes import box

import feeler
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.cli import app, values
from feeler.cli.options import Option, in_command_line_words, in_text
from feeler.io import write_glb, write_stl

WRONG = ["", "x", "nan", "-1", "1e999", "\u00e9", "9" * 400, "5 parsec", "1,2", "0x10", "--", "\x00"]
NEEDED = {
    **{"path": ["--poses", "p.txt"], "swept": ["--poses", "p.txt"], "access": ["--tool", "t.stl"]},
    "verify": ["--requirements", "r.toml"],
    "move": ["--mechanism", "m.toml"],
    "opening": ["--at", "0,0,0", "--axis", "0,0,1"],
}
NO_ARGUMENT = ("demo", "feel", "view", "bench", "study")


def commands() -> dict[str, typer.models.CommandInfo]:
    """The table of commands, "study hashing" among them."""
    every = {str(each.name): each for each in app.registered_commands}
    for group in app.registered_groups:
        assert group.typer_instance is not None
        every |= {f"{group.name} {each.name}": each for each in group.typer_instance.registered_commands}
    return every


def options_of(name: str) -> dict[str, Option]:
    callback = commands()[name].callback
    assert callback is not None
    return in_text(inspect.unwrap(callback))[1]


OPTIONS = [(name, option) for name in commands() for option in options_of(name).values() if option.value is not None]


def test_the_table_is_whole() -> None:
    assert len(commands()) == 28 and len(OPTIONS) > 200


def test_every_option_with_a_number_has_a_value() -> None:
    """No number is left to typer, which has other words for wrong ones."""
    for name, info in commands().items():
        assert info.callback is not None
        for parameter in inspect.signature(info.callback).parameters.values():
            assert not re.search(r"\b(int|float)\b", str(parameter.annotation)), (name, parameter)


@pytest.mark.parametrize(("name", "option"), OPTIONS, ids=[f"{name} {option.name}" for name, option in OPTIONS])
def test_wrong_values_are_refused_by_name(name: str, option: Option) -> None:
    assert option.value is not None
    tried = 0
    for text in WRONG:
        try:
            option.value.read(text)
        except ValueError:
            tried += 1
        else:
            continue
        needed = [*([] if name.split()[0] in NO_ARGUMENT else ["nothing.stl"]), *NEEDED.get(name, [])]
        if option.name in needed:
            at = needed.index(option.name)
            del needed[at : at + 2]
        said = error_of(*name.split(), *needed, f"{option.name}={text}")
        assert said.startswith(f"feeler: {option.name} is {text[:60]!r}"[:40]), said
        assert re.search("give|choose|do you mean", said) and "Input should" not in said and len(said) < 300
    least = 1 if isinstance(option.value, values.Text | values.FileName) else 5
    assert tried >= least, "nearly everything reads as a value of this option"


@pytest.mark.parametrize(("name", "option"), OPTIONS, ids=[f"{name} {option.name}" for name, option in OPTIONS])
def test_defaults_read_as_what_they_are(name: str, option: Option) -> None:
    if option.shown is not None:
        assert option.value is not None
        assert option.value.read(option.shown) == pytest.approx(option.default)
        assert option.read(option.shown) == option.default


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mock-up of two parts, a tool and a path, in the working folder."""
    monkeypatch.chdir(tmp_path)
    parts = {"a": feeler.Mockup(*box([0, 0, 0], [1, 1, 1])), "b": feeler.Mockup(*box([2, 0, 0], [3, 1, 1]))}
    write_glb(tmp_path / "m.glb", feeler.Mockup(parts))
    write_stl(tmp_path / "t.stl", feeler.Tool(*box([0, 0, 0], [0.1, 0.1, 0.1])))
    (tmp_path / "p.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n" * 2)


MOVING = ["m.glb", "--tool", "t.stl"]
FILES: list[tuple[list[str], list[str]]] = [
    (["collide", *MOVING], ["--pose"]),
    (["collide", *MOVING, "--at", "0,0,3"], ["--glb", "--picture"]),
    (["clearance", *MOVING], ["--pose"]),
    (["clearance", *MOVING, "--at", "0,0,3"], ["--glb", "--csv"]),
    (["collide", "m.glb", "--at", "0,0,3"], ["--tool", "--part"]),
    (["collide", *MOVING, "--at", "0,0,3"], ["--without", "--only"]),
    (["path", *MOVING], ["--poses"]),
    (["path", *MOVING, "--poses", "p.txt"], ["--csv", "--glb"]),
    (["clash", "m.glb"], ["--rules", "--previous", "--csv", "--xlsx", "--html", "--bcf", "--glb", "--save"]),
    (["clash", "m.glb"], ["--write-rules", "--fail-on", "--only", "--bcf-in"]),
    (["verify", "m.glb"], ["--requirements"]),
    (["move", "m.glb"], ["--mechanism", "--write-mechanism"]),
    (["remove", "m.glb"], ["--part", "--hand"]),
    (["remove", "m.glb", "--part", "m/a/part"], ["--ignore", "--csv", "--way", "--glb", "--without"]),
    (["remove", "m.glb", "--part", "m/a/part", "--insert"], ["--from", "--goal"]),
    (["access", *MOVING], ["--targets", "--frames", "--hand", "--grip", "--csv", "--glb"]),
    (["sight", "m.glb"], ["--eye", "--from", "--to"]),
    (["sight", "m.glb", "--eye", "0,0,1"], ["--targets", "--parts", "--csv"]),
    (["access", "m.glb"], ["--catalogue", "--write-catalogue"]),
    (["opening", "m.glb", "--at", "0,0,9", "--axis", "0,0,1"], ["--limits", "--write-limits"]),
    (["swept", "t.stl"], ["--poses"]),
    (["swept", "t.stl", "--poses", "p.txt"], ["--out"]),
    (["feel", "m.glb"], ["--tool", "--record", "--pose", "--device-option"]),
    (["view"], ["--findings", "--record", "--host"]),
    (["sample", "gearbox"], ["--fault", "--out"]),
    (["bench", "m.glb"], ["--tool", "--kinds"]),
]


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(("words", "option"), [(words, each) for words, every in FILES for each in every])
@pytest.mark.parametrize("text", ["x y", "-1", "\u00e9", "n" * 300])
def test_files_and_names_that_are_not_there_are_told_with_their_option(
    words: list[str], option: str, text: str
) -> None:
    if (option, text) in (("--record", "-1"), ("--hand", "x")) or (words == ["view"] and option == "--record"):
        pytest.skip("a name like others")
    more = ["--part", "m/a/part"] if words == ["remove", "m.glb"] and option == "--hand" else []
    said = error_of(*words, *more, option, text)
    assert option in said or (option == "--host" and "host" in said), said


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("text", "metres"),
    [("5mm", 0.005), ("0.2 in", 0.00508), ("0,5 cm", 0.005), ("5000um", 0.005), ("0.005", 0.005), ("2e-3 M", 0.002)],
)
def test_lengths_have_units(text: str, metres: float) -> None:
    found = run_json("clearance", *MOVING, "--at", "0,0,3", "--within", text, "--require", text)
    assert found["within_m"] == metres and found["required_m"] == metres


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("text", ["1,000", "1,000mm", "-12,345 m"])
def test_a_comma_that_may_group_thousands_is_refused(text: str) -> None:
    said = error_of("clearance", *MOVING, "--at", "0,0,3", f"--require={text}")
    number = text.rstrip(" m")
    assert f"give {number.replace(',', '')} or {number.replace(',', '.')}" in said


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(("text", "metres"), [("0,005", 0.005), ("1,5", 1.5), ("1,0000", 1.0), ("1000", 1000.0)])
def test_other_commas_begin_decimals(text: str, metres: float) -> None:
    assert run_json("clearance", *MOVING, "--at", "0,0,3", "--within", text)["within_m"] == metres


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("1,2,3", [1, 2, 3]),
        ("1000mm,200cm,3m", [1, 2, 3]),
        ("1m 2m 3m", [1, 2, 3]),
        ("0,5; 2; 3", [0.5, 2, 3]),
        ("-10in,0,0m", [-0.254, 0, 0]),
    ],
)
def test_positions_have_units(text: str, place: list[float]) -> None:
    found = run_json("clearance", *MOVING, "--at", text)
    assert [row[3] for row in found["poses"][0]["world_from_tool"][:3]] == pytest.approx(place)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("text", ["1,2", "1,2,3,4", "1,2,3mm", "1mm,2,3", "1,,3", "1;2,3"])
def test_positions_that_are_refused(text: str) -> None:
    assert "give three lengths" in error_of("clearance", *MOVING, "--at", text)


def test_other_units() -> None:
    assert values.SECONDS.read("2min") == 120 and values.SECONDS.read("500 ms") == 0.5
    assert values.SWING.read("60\u00b0") == 60 and values.SWING.read("3.141592653589793 rad") == pytest.approx(180)
    assert values.THREADS.read(" 8 ") == 8 and values.COUNT.read("1_600_000") == 1_600_000
    assert values.UNIT.read("Inch") == "in" and values.STORAGE.read("Dense") == "dense"


def help_of(words: list[str], width: int, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("COLUMNS", str(width))
    text: str = run(*words, "--help").stdout
    return text


@pytest.mark.parametrize("name", [*commands(), "study", ""])
@pytest.mark.parametrize("width", [80, 120])
def test_help_pages(name: str, width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    text = help_of(name.split(), width, monkeypatch)
    assert max(len(line) for line in text.splitlines()) <= width
    assert "likewise" not in text and not re.search(r"--\S+ +<(str|path|int|float)", text)
    examples = text.partition(" Examples\n")[2]
    if name in commands():
        whole = examples.replace(" \\\n", "").splitlines()
        assert all(line.strip().startswith("feeler ") for line in whole if line.strip()) and "feeler" in examples
        for option in re.findall(r"--[a-z-]+", re.sub(r"&&[^\n]*\n[^\n]*", "", examples)):
            assert option in text.partition(" Examples\n")[0], f"{option} of an example is no option"


def test_lines_of_a_paragraph_are_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    text = help_of(["remove"], 120, monkeypatch).split("Arguments")[0]
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    assert len(lines) <= 6, "the source's line ends are none of the page"


OUTPUTS = [
    ("collide", ["--at", "0,0,0"], "--glb"),
    ("collide", ["--at", "0,0,0"], "--picture"),
    ("clearance", ["--at", "0,0,0"], "--glb"),
    ("clearance", ["--at", "0,0,0"], "--csv"),
    ("path", ["--poses", "t.stl"], "--glb"),
    ("access", [], "--csv"),
    ("access", [], "--glb"),
]


@pytest.mark.parametrize(("name", "words", "output"), OUTPUTS)
def test_an_output_with_the_name_of_an_input_is_told_by_its_option(
    name: str, words: list[str], output: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for file in ("a.stl", "t.stl"):
        write_stl(file, feeler.Tool(*box([0] * 3, [1] * 3)))
    asked = [name, "a.stl", "--tool", "t.stl", *words, output]
    assert error_of(*asked, "t.stl").startswith(f"feeler: {output} t.stl: the name must end in ")
    (tmp_path / "t.stl").rename(tmp_path / "kept.stl")
    ending = {"--picture": ".png", "--csv": ".csv"}.get(output, ".glb")
    asked[asked.index("t.stl")] = "kept.stl"
    assert error_of(*asked, f"none/x{ending}").startswith(f"feeler: {output}: cannot write ")


def test_an_error_about_a_file_of_several_options_names_them_all() -> None:
    options = {name: Option(f"--{name}", None) for name in ("tool", "hand", "out")}
    words = {"tool": "a.stl", "hand": "a.stl", "out": Path("b.glb"), "mockup": ["m.stl"]}
    for message, expected in (
        ("a.stl: is empty", "--tool or --hand: a.stl: is empty"),
        ("cannot write 'b.glb': no", "--out: cannot write 'b.glb': no"),
        ("m.stl: is empty", "m.stl: is empty"),
        ("--out is wrong: 'a.stl'", "--out is wrong: 'a.stl'"),
        ("tool is 3: give", "--tool is 3: give"),
    ):
        assert in_command_line_words(message, options, words) == expected
    assert in_command_line_words("a.stl: is empty", options, {**words, "mockup": ["a.stl"]}) == "a.stl: is empty"


STARTS = [(name, each.name) for name in commands() for each in options_of(name).values() if "--write-" in each.name]


def test_every_option_that_starts_a_file_is_known() -> None:
    assert {option for _, option in STARTS} == {
        *("--write-rules", "--write-mechanism", "--write-catalogue", "--write-limits", "--write-times"),
    }


@pytest.mark.parametrize(("name", "option"), STARTS)
def test_a_file_to_edit_is_started_once(
    name: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second start would take the edits of the first file."""
    monkeypatch.chdir(tmp_path)
    write_stl("a.stl", feeler.Tool(*box([0] * 3, [1] * 3)))
    run(name, "a.stl", option, "x.toml")
    edited = Path("x.toml").read_text() + "# mine"
    Path("x.toml").write_text(edited)
    said = error_of(name, "a.stl", option, "x.toml")
    assert f"{option} x.toml: the file exists" in said and "give another name, or delete it" in said
    assert Path("x.toml").read_text() == edited
    assert "must not exist yet" in " ".join(run(name, "--help").stdout.replace("\u2502", "").split())


@pytest.mark.parametrize("name", list(commands()))
def test_sample_tools_of_examples_exist(name: str) -> None:
    shown = run(*name.split(), "--help").stdout
    assert set(re.findall(r"--(?:tool|hand) sample:(\w+)", shown)) <= set(SAMPLE_TOOL_NAMES)


TEXT_OF = {"--picture-size": "8x8", "--eyes": "5", "--hashing": "0.5", "--error": "1mm", "--pictures": "3"}
"""A text of options that take no name of a file."""


def given_text(option: Option) -> list[str]:
    """An option on the command line, with a text that it reads."""
    if option.value is None:
        return ["--no-browser" if option.name == "--browser" else option.name]
    for text in (TEXT_OF.get(option.name), "1", "x.toml", "x.csv", "x.glb", "0,0,1", "mm", "host:1", "large_6dof"):
        try:
            option.value.read(text or "")
        except ValueError:
            continue
        return [option.name, text or ""]
    raise AssertionError(option.name)


NEEDING = [(name, each) for name in commands() for each in options_of(name).values() if each.needs]
ENDING = [(name, each) for name in commands() for each in options_of(name).values() if each.ends_with is not None]


def test_options_that_go_with_others_are_known() -> None:
    """A help text that says "with another option" is a promise that the option is refused without it."""
    known = {(name, option.name) for name, option in NEEDING}
    assert len(NEEDING) > 30 and {option.name for _, option in ENDING} == {
        *("--write-catalogue", "--write-limits", "--write-times", "--write-mechanism"),
    }
    for name in commands():
        callback = inspect.unwrap(commands()[name].callback)  # type: ignore[arg-type]
        every = options_of(name)
        names = {each.name for each in every.values()}
        for parameter, option in every.items():
            texts = str(inspect.signature(callback, eval_str=True).parameters[parameter].annotation)
            if re.search(r"help='(With --|In --|For --|Size of --)", texts):
                assert (name, option.name) in known, (name, option.name)
            needed = {word.partition(" ")[0] for word in (*option.needs, *(option.ends_with or ()))}
            assert needed <= names - {option.name}, (name, option.name)


def least_words(name: str) -> list[str]:
    """Arguments of a command; nothing that its options need."""
    return [*name.split(), *([] if name.split()[0] in NO_ARGUMENT else ["nothing.stl"])]


@pytest.mark.parametrize(("name", "option"), NEEDING, ids=[f"{name} {option.name}" for name, option in NEEDING])
def test_an_option_in_vain_is_refused(name: str, option: Option) -> None:
    words = [*least_words(name), *NEEDED.get(name, []), *(["--device", "haply"] if name == "feel" else [])]
    for needed in option.needs:
        if needed in words:
            del words[words.index(needed) : words.index(needed) + 2]
    said = error_of(*words, *given_text(option))
    too = "it" if len(option.needs) == 1 else "one of these"
    assert said == f"feeler: {option.name} is for {' or '.join(option.needs)}: give {too}, too\n"


@pytest.mark.parametrize(("name", "option"), ENDING, ids=[f"{name} {option.name}" for name, option in ENDING])
def test_a_command_that_ends_with_a_file_takes_no_other_options(name: str, option: Option) -> None:
    said = error_of(*least_words(name), option.name, "x.toml", "--threads", "1")
    assert said == f"feeler: {option.name} writes a file and ends: leave out --threads\n"


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["collide", "sample:gearbox", "--unit", "mm", "--tool", "t.stl", "--at", "0,0,0"], "--unit is for files"),
        (["collide", "m.glb", "--tool", "sample:wrench", "--tool-unit", "mm", "--at", "0,0,0"], "--tool-unit is for"),
        (["index", "sample:gearbox", "--chord-tolerance", "1mm"], "--chord-tolerance is for STEP files"),
        (["remove", "m.glb", "--part", "a", "--hand", "sample:hand", "--hand-unit", "mm"], "--hand-unit is for files"),
        (["swept", "sample:wrench", "--poses", "p.txt", "--tool-unit", "mm"], "--tool-unit is for files"),
        (["access", "m.glb", "--tool", "sample:wrench", "--tool-unit", "mm"], "--tool-unit is for files"),
        (["sample", "wrench", "--triangles", "1000"], "--triangles and --seed are for mock-ups"),
        (["sample", "wrench", "--seed", "0"], "--triangles and --seed are for mock-ups"),
        (["sample", "engine", "--fine"], "--fine is for tools"),
        (["sample", "--out", "x.glb"], "--out is of a sample: give its name"),
    ],
)
def test_options_of_files_are_refused_for_samples(words: list[str], said: str) -> None:
    assert f"feeler: {said}" in error_of(*words)


@pytest.mark.usefixtures("files")
def test_options_that_go_together_work() -> None:
    found = run_json("collide", *MOVING, "--at", "0,0,0", "--pairs", "--storage", "Hashed", "--hashing", "0.5", code=1)
    assert found["scene"]["storage"] == "hashed" and found["poses"][0]["pair_list"]
    started = run_json("access", "--write-catalogue", "c.toml")
    assert started == {"written": {"catalogue": "c.toml"}} and Path("c.toml").exists()
    assert run_json("opening", "--write-limits", "l.toml") == {"written": {"limits": "l.toml"}}


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("words", "read", "written"),
    [
        (["path", *MOVING], "--poses", "--csv"),
        (["access", *MOVING, "--grip", "z"], "--frames", "--csv"),
        (["remove", "m.glb", "--part", "m/a/part", "--insert"], "--from", "--csv"),
        (["remove", "m.glb", "--part", "m/a/part", "--insert"], "--goal", "--way"),
        (["clearance", *MOVING], "--pose", "--csv"),
        (["task", "m.glb", "--part", "m/a/part"], "--times", "--html"),
    ],
)
def test_no_output_takes_the_place_of_a_file_that_an_option_names(words: list[str], read: str, written: str) -> None:
    name = {"--csv": "same.csv", "--way": "same.json", "--html": "same.html"}[written]
    Path(name).write_text("1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n", encoding="utf-8")
    said = error_of(*words, read, name, written, name)
    assert said.startswith(f"feeler: {written} {name}: it is read by this command; give another name"), said
