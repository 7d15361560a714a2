"""The commands, for people and for machines: what they say, what they write, how they end."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json
from typer.testing import CliRunner

import feeler
from feeler.cli import app
from feeler.io import write_glb, write_stl

PROGRAM = [sys.executable, "-c", "from feeler.cli import main; main()"]
COMMANDS = ["demo", "info", "index", "collide", "clearance", "path", "move", "clash", "verify", "remove"]
COMMANDS += ["access", "sight", "opening", "task", "maintain", "swept", "feel", "view", "report", "mcp"]
COMMANDS += ["replay", "sample", "bench"]


def box(lower: tuple[float, ...], upper: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])
    return np.array(lower) + corners * (np.array(upper) - np.array(lower)), faces


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A GLB of a plate and two posts, 0.25 m apart."""
    shapes = {
        "stand/plate": box((0, 0, 0), (0.5, 0.25, 0.015625)),
        "stand/posts/left": box((0.0625, 0.0625, 0.015625), (0.125, 0.1875, 0.25)),
        "stand/posts/[1] right": box((0.375, 0.0625, 0.015625), (0.4375, 0.1875, 0.25)),
    }
    mockup = feeler.Mockup(
        np.concatenate([points for points, _ in shapes.values()]),
        np.concatenate([faces + 8 * i for i, (_, faces) in enumerate(shapes.values())]),
        np.repeat(np.arange(3), 12),
        [path.split("/")[-1] for path in shapes],
        part_paths=list(shapes),
    )
    path = tmp_path_factory.mktemp("stand") / "stand.glb"
    write_glb(path, mockup)
    return path


@pytest.fixture(scope="module")
def slider(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An STL, in millimetres, of a box that fits exactly between the posts."""
    path = tmp_path_factory.mktemp("slider") / "slider.stl"
    write_stl(path, feeler.Tool(*box((0, 0, 0), (0.25, 0.0625, 0.0625)), name="slider"))
    return path


def test_version() -> None:
    assert re.fullmatch(r"feeler \d+\.\d+\.\d+\S*\n", run("--version").stdout)


def test_help_lists_the_commands_and_each_has_examples() -> None:
    text = run("--help").stdout
    assert re.findall(r"^\W* ([a-z]+) {2,}[A-Z]", text, re.MULTILINE) == [*COMMANDS, "study"]
    for command in COMMANDS:
        text = run(command, "--help").stdout
        assert f"feeler {command}" in text.partition("Examples")[2]
        assert "--json" in text or command == "mcp", "whose answers are JSON"


@pytest.mark.parametrize("words", [[], ["study"], *([name] for name in COMMANDS), ["study", "filters"]], ids=" ".join)
def test_help_has_no_types_of_python(words: list[str]) -> None:
    assert re.findall(r"<\w+[^>]*>|\blist\[|\bbool\b", run(*words, "--help").stdout) == []


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["collide", "--help"]])
def test_help_loads_nothing_that_only_work_needs(words: list[str]) -> None:
    # What is imported is what a user waits for before the first word.
    code = (
        "import sys\n"
        f"sys.argv = ['feeler', *{words}]\n"
        "from feeler.cli import main\n"
        "early = 'rich.table' in sys.modules\n"
        "try:\n    main()\n"
        "finally:\n    print(early, *(name for name in sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    early, *loaded = done.stderr.split()
    assert early == "False" and "feeler.cli.app" in loaded
    heavy = {"trimesh", "matplotlib", "cascadio", "DracoPy", "coal", "fcl", "rich.progress", "feeler.picture"}
    heavy |= {"feeler.workbench", "feeler.workbench.net.server", "websockets", "asyncio", "webbrowser"}
    assert not heavy.intersection(loaded)


def test_info_for_people(stand: Path) -> None:
    text = run("info", stand).stdout
    assert "36" in text and "stand/posts/[1] right" in text and "defects" in text and "none" in text


def test_info_for_machines(stand: Path, slider: Path) -> None:
    files = run_json("info", stand, slider)["files"]
    assert [entry["triangles"] for entry in files] == [36, 12]
    paths = [part["path"] for part in files[0]["part_list"]]
    assert [path.partition("stand/")[2].split("/")[-1] for path in paths] == ["plate", "left", "[1] right"]
    assert files[1]["unit"] == "mm"
    np.testing.assert_allclose(files[1]["extent"], [0.25, 0.0625, 0.0625])
    assert run_json("info", slider, "--unit", "m")["files"][0]["extent"][0] == pytest.approx(250)


def test_collide_names_the_parts(stand: Path, slider: Path) -> None:
    result = run("collide", stand, "--tool", slider, "--at", "0.15,0.09375,0.125", code=1)
    assert "Collision: 10 pairs (10 crossing) with 1 part" in result.stdout
    assert "stand/posts/[1] right" in result.stdout
    assert "left" not in result.stdout.partition("Collision")[2]


def test_collide_without_a_collision_ends_with_0(stand: Path, slider: Path) -> None:
    assert "No collision" in run("collide", stand, "--tool", slider, "--at", "0.125,1,0").stdout
    document = run_json("collide", stand, "--tool", slider, "--at", "0.125,1,0")
    assert document["colliding"] is False and document["poses"][0]["parts"] == []


@pytest.mark.parametrize("storage", ["blocks", "dense", "hashed"])
def test_collide_for_machines(stand: Path, slider: Path, storage: str) -> None:
    words = ["--at", "0.15,0.09375,0.125", "--storage", storage, "--pairs"]
    if storage != "blocks":
        words += ["--voxel-size", "0.05", "--threads", "1"]
    if storage == "hashed":
        words += ["--hashing", "0.5"]
    document = run_json("collide", stand, "--tool", slider, *words, code=1)
    assert document["colliding"] is True
    assert document["mockup"]["triangles"] == 36 and document["tool"]["name"] == "slider"
    assert document["scene"]["storage"] == storage and document["scene"]["memory_bytes"]["total"] > 0
    (pose,) = document["poses"]
    assert pose["pairs"] == len(pose["pair_list"]) == 10 and set(pose["pair_kinds"]) == {"crossing"}
    (part,) = pose["parts"]
    assert part["path"].endswith("stand/posts/[1] right") and part["pairs"] == 10 and part["kinds"]["crossing"] == 10
    assert {pair[1] for pair in pose["pair_list"]} <= set(range(24, 36))
    assert part["mockup_triangles"] == len({pair[1] for pair in pose["pair_list"]})


def test_rotation_is_about_fixed_axes_and_quarter_turns_are_exact(stand: Path, slider: Path) -> None:
    def matrix(*words: str) -> np.ndarray:
        result = CliRunner().invoke(app, ["collide", str(stand), "--tool", str(slider), *words, "--json"])
        return np.array(json.loads(result.stdout)["poses"][0]["world_from_tool"])

    quarter = matrix("--at", "-1,2,3", "--rotate", "90,0,-90")
    # x stays x under the turn about x, then goes to -y; y goes to z; z goes to -y and on to -x.
    np.testing.assert_array_equal(quarter, [[0, 0, -1, -1], [-1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 0, 1]])
    assert matrix("--rotate=10,20,30")[:3, :3] @ matrix("--rotate=10,20,30")[:3, :3].T == pytest.approx(np.eye(3))


def test_pose_files(tmp_path: Path, stand: Path, slider: Path) -> None:
    pose = np.eye(4)
    pose[:3, 3] = [0.15, 0.09375, 0.125]
    (tmp_path / "a.json").write_text(json.dumps(pose.tolist()))
    (tmp_path / "b.json").write_text(json.dumps({"world_from_tool": pose.tolist()}))
    (tmp_path / "c.txt").write_text("# the right post\n" + "\n".join(", ".join(map(str, row)) for row in pose))
    np.save(tmp_path / "d.npy", pose)
    np.save(tmp_path / "e.npy", pose[None])
    for name in ("a.json", "b.json", "c.txt", "d.npy", "e.npy"):
        document = run_json("collide", stand, "--tool", slider, "--pose", tmp_path / name, code=1)
        assert [entry["pairs"] for entry in document["poses"]] == [10]


def test_several_poses_give_a_line_each(tmp_path: Path, stand: Path, slider: Path) -> None:
    poses = np.tile(np.eye(4), (30, 1, 1))
    poses[:, :3, 3] = [0.125, 1, 0.125]
    poses[7, :3, 3] = [0.15, 0.09375, 0.125]
    poses[9, :3, 3] = [0.125, 0.09375, 0.015625]
    (tmp_path / "path.json").write_text(json.dumps({"poses": poses.tolist()}))
    words = ["collide", stand, "--tool", slider, "--pose", tmp_path / "path.json"]
    text = run(*words, "--glb", tmp_path / "worst.glb", code=1).stdout
    assert "2 of 30 poses collide" in text and "at pose 9" in text and "10 more" in text
    assert (tmp_path / "worst.glb").is_file()
    document = run_json(*words, code=1)
    assert [entry["pose"] for entry in document["poses"] if entry["colliding"]] == [7, 9]
    assert document["poses"][9]["kinds"]["coplanar"] > 0


def test_collide_writes_picture_and_glb(tmp_path: Path, stand: Path, slider: Path) -> None:
    glb, picture = tmp_path / "hit.glb", tmp_path / "hit.png"
    words = ["collide", stand, "--tool", slider, "--at", "0.15,0.09375,0.125", "--glb", glb, "--picture", picture]
    words += ["--picture-size", "320x200"]
    assert run_json(*words, code=1)["written"] == {"glb": str(glb), "picture": str(picture)}
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run_json("info", glb)["files"][0]["triangles"] == 36 + 12
    all_parts = glb.stat().st_size
    run(*words, "--context", "0.05", code=1)
    assert glb.stat().st_size < all_parts


def test_sample_lists_makes_and_writes(tmp_path: Path) -> None:
    assert "engine" in run("sample").stdout and "wrench" in run("sample").stdout
    names = run_json("sample")
    assert "engine" in names["mockups"] and "wrench" in names["tools"]
    assert "differential" in run("sample", "differential", "--triangles", "10000").stdout
    made = run_json("sample", "differential", "--triangles", "10000", "--out", tmp_path / "a.glb")
    assert made["bytes"] == (tmp_path / "a.glb").stat().st_size
    read = run_json("info", tmp_path / "a.glb")["files"][0]
    assert (read["triangles"], read["parts"]) == (made["triangles"], made["parts"])
    np.testing.assert_array_equal(read["extent"], made["extent"])
    tool = run_json("sample", "wrench", "--out", tmp_path / "wrench.stl")
    np.testing.assert_allclose(
        run_json("info", tmp_path / "wrench.stl")["files"][0]["extent"], tool["extent"], rtol=1e-6
    )
    truth = tmp_path / "truth.json"
    planted = ("--fault", "floating,inside", "--fault", "mirrored")
    faulty = run_json("sample", "gearbox", "--triangles", "80000", *planted, "--truth", truth)
    assert faulty["parts"] > 500
    assert [fault["name"] for fault in json.loads(truth.read_text())["faults"]] == ["inside", "floating", "mirrored"]
    planted_here = run_json("info", "sample:gearbox:80000::floating,inside")["files"][0]
    assert planted_here["parts"] == faulty["parts"] and planted_here["triangles"] == faulty["triangles"]
    assert "pipe_clash" in run("sample", "gearbox", "--triangles", "80000", "--fault", "rust", code=2).output
    assert run_json("sample", "wrench", "--fine")["triangles"] > 10_000
    assert run_json("sample", "differential", "--triangles", "10000", "--seed", "1")["triangles"] >= 9000


def test_bench_measures() -> None:
    words = ["bench", "sample:differential:10000", "--tool", "sample:torque", "--poses", "5"]
    text = run(*words).stdout
    assert "nominal" in text and "near" in text and "bytes a triangle" in text
    document = run_json(*words, "--kinds", "near")
    (row,) = document["runs"]
    assert row["queries"] == 5 and row["median_pairs"] == 0
    assert 0 < row["median_us"] <= row["p95_us"] <= row["p99_us"] <= row["worst_us"]


def test_demo_goes_the_whole_way(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    result = run("demo", "--triangles", "20000", "--out", folder)
    assert {path.name for path in folder.iterdir()} == {"deepest.png", "deepest.glb", "pose.json"}
    for word in ("triangles", "parts", "predicted", "build", "memory", "queries a second", "median", "p99", "worst"):
        assert word in result.stdout
    # The last line is a command that works, once the file names are replaced.
    command = result.stdout.splitlines()[-1].partition("your own files: ")[2]
    words = command.replace("YOUR_MOCKUP.step", "sample:engine:20000").replace("YOUR_TOOL.stl", "sample:wrench").split()
    assert words[:2] == ["feeler", "collide"]
    words = [str(tmp_path / word) if word.startswith("hit.") else word for word in words[1:]]
    run(*words, "--picture-size", "160x100", code=1)
    assert (tmp_path / "hit.png").is_file()
    document = run_json("demo", "--triangles", "20000", "--out", folder)
    assert document["next"] == command
    assert document["path"]["colliding"] > 0 and document["parts"][0]["poses"] > 0
    assert document["deepest_pairs"] == run_json(*words[: words.index("--glb")], code=1)["poses"][0]["pairs"]


def test_bad_files_and_options(tmp_path: Path, stand: Path, slider: Path) -> None:
    assert "nowhere.stl" in error_of("info", tmp_path / "nowhere.stl")
    (tmp_path / "empty.stl").touch()
    assert "empty.stl" in error_of("info", tmp_path / "empty.stl")
    tool = ["--tool", slider]
    assert "the tool has no pose" in error_of("collide", stand, *tool)
    assert "exclude" in error_of("collide", stand, *tool, "--at", "0,0,0", "--pose", tmp_path / "p.json")
    assert "p.json does not exist" in error_of("collide", stand, *tool, "--pose", tmp_path / "p.json")
    assert "three lengths" in error_of("collide", stand, *tool, "--at", "0,zero,0")
    assert "three lengths" in error_of("collide", stand, *tool, "--at", "0,0")
    assert "three angles" in error_of("collide", stand, *tool, "--rotate", "nan,0,0")
    at = ["--at", "0,0,0"]
    assert "storage" in error_of("collide", stand, *tool, *at, "--storage", "shoebox")
    assert "voxel" in error_of("collide", stand, *tool, *at, "--voxel-size", "-1")
    assert "hashing" in error_of("collide", stand, *tool, *at, "--storage", "hashed", "--hashing", "1.5")
    assert "threads" in error_of("collide", stand, *tool, *at, "--threads", "0")
    assert "context" in error_of("collide", stand, *tool, *at, "--glb", tmp_path / "a.glb", "--context", "-1")
    assert "end in .glb" in error_of("collide", stand, *tool, *at, "--glb", tmp_path / "a.obj")
    assert "--picture-size" in error_of("collide", stand, *tool, *at, "--picture-size", "big")
    assert "does not exist" in error_of("collide", stand, *tool, *at, "--picture", tmp_path / "no" / "a.png")
    assert "sample" in error_of("collide", stand, "sample:engine", *tool, *at)
    assert "sample:NAME" in error_of("collide", "sample:", *tool, *at)
    assert "whole number" in error_of("collide", "sample:engine:many", *tool, *at)
    assert "duplicate" in error_of("collide", "sample:gearbox:45000:0:rust", *tool, *at)
    assert "no faults to plant" in error_of("collide", "sample:engine:20000:0:inside", *tool, *at)
    assert "sample:NAME" in error_of("collide", "sample:gearbox:45000:0:inside:1", *tool, *at)
    assert "fine" in error_of("collide", stand, "--tool", "sample:wrench:coarse", *at)
    assert "spoon" in error_of("collide", stand, "--tool", "sample:spoon", *at)
    assert "spaceship" in error_of("sample", "spaceship")
    assert "--fine is for tools" in error_of("sample", "engine", "--fine")
    assert "end in .glb or .stl" in error_of("sample", "wrench", "--out", tmp_path / "a.obj")
    assert "does not exist" in error_of("sample", "wrench", "--out", tmp_path / "no" / "a.glb")
    assert "--kinds" in error_of("bench", "--kinds", "shallow")
    assert "--poses" in error_of("bench", "--poses", "0")
    (tmp_path / "file").touch()
    assert "cannot make the folder" in error_of("demo", "--out", tmp_path / "file")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.json", "[[1, 0, 0", "cannot be read"),
        ("b.json", '{"matrix": 1}', 'no "world_from_tool"'),
        ("c.json", "[[1, 2], [3]]", "cannot be read"),
        ("d.json", "[]", "shape (0,)"),
        ("e.json", '"pose"', "cannot be read"),
        ("f.txt", "1 0 0 0 0 1", "6 numbers are not a multiple of 16"),
        ("g.txt", "1 0 0 zero", "'zero'"),
        ("h.txt", "", "holds no pose"),
        ("i.npy", "no array", "cannot be read"),
        ("j.txt", "\xff\xfe", "holds no pose"),
        ("j2.txt", "\xff 1", "is not a number"),
        ("k.json", "[" * 100_000, "cannot be read"),
        ("l.txt", " ".join(["1"] * 16), "not rigid"),
        ("m.txt", " ".join(["nan"] * 16), "pose[0, 0] is NaN"),
    ],
)
def test_bad_pose_files(tmp_path: Path, stand: Path, slider: Path, name: str, content: str, words: str) -> None:
    (tmp_path / name).write_bytes(content.encode("latin-1"))
    message = error_of("collide", stand, "--tool", slider, "--pose", tmp_path / name)
    assert words in message
    assert str(tmp_path / name) in message


@pytest.mark.parametrize(
    ("leg", "words"),
    [
        ({"to": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, "legs[1]: the pose is not rigid"),
        ({"to": [[1, 0], [0, 1]]}, "shape (2, 2)"),
        ({"screw": {"axis": [0, 0, 0], "point": [0, 0, 0], "angle": 1, "pitch": 0}}, "axis"),
    ],
)
def test_bad_legs_name_their_file(tmp_path: Path, stand: Path, slider: Path, leg: object, words: str) -> None:
    (tmp_path / "way.json").write_text(json.dumps({"legs": [{"to": np.eye(4).tolist()}, leg]}))
    message = error_of("path", stand, "--tool", slider, "--poses", tmp_path / "way.json")
    assert words in message and str(tmp_path / "way.json") in message


def test_wrong_usage_ends_with_2() -> None:
    assert run("collide", code=2).stdout == ""
    assert run("nonsense", code=2).stdout == ""
    assert run("info", "--nonsense", code=2).stdout == ""


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")
def test_a_closed_pipe_is_no_error(stand: Path) -> None:
    with subprocess.Popen([*PROGRAM, "info", str(stand)], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode in (0, 1)


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")
def test_ctrl_c_ends_with_130(tmp_path: Path) -> None:
    code = (
        # Whoever runs the tests in the background may have told all children to ignore the signal.
        "import feeler, signal, time\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "def slow(*a, **k):\n    print('ready', flush=True); time.sleep(30)\n"
        "feeler.sample = slow\n"
        "from feeler.cli import main; main()"
    )
    words = [sys.executable, "-c", code, "sample", "engine"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate()
    assert process.returncode == 130
    assert stderr.strip() == "feeler: interrupted"


def test_warnings_are_one_line_each() -> None:
    code = (
        "import feeler, warnings, feeler.cli.info\n"
        "def told(*a, **k):\n    warnings.warn('a worker died:\\n3 tasks are done again', feeler.WorkerLost)\n"
        "    warnings.warn('of another library', UserWarning)\n    raise feeler.LoadError('enough')\n"
        "feeler.cli.info.read_mockup = told\n"
        "from feeler.cli import main; main()"
    )
    ended = subprocess.run([sys.executable, "-c", code, "info", "a.stl"], capture_output=True, text=True, check=False)
    first, second, *_, last = ended.stderr.splitlines()
    assert (ended.returncode, first) == (2, "feeler: warning: a worker died: 3 tasks are done again"), ended.stderr
    assert second.endswith("UserWarning: of another library") and last == "feeler: enough"


def test_threads_that_nobody_waits_for_end_with_the_program() -> None:
    """NumPy's `unique` is C++: a thread that the end of the interpreter stops in it takes the process along."""
    code = (
        "import atexit, numpy as np, threading\n"
        "from feeler.cli import main\n"
        "numbers = np.arange(1000) % 100\n"
        "def busy():\n    while True:\n        np.unique(numbers)\n"
        "for _ in range(4):\n    threading.Thread(target=busy, daemon=True).start()\n"
        "threading.Thread(target=lambda: print('waited for')).start()\n"
        "atexit.register(print, 'called at the end')\n"
        "main()"
    )
    for words, status in ((["--version"], 0), (["info", "missing.stl"], 2)):
        ended = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
        assert ended.returncode == status, ended.stderr
        assert {"waited for", "called at the end"} <= {*ended.stdout.splitlines()}
        assert "terminate" not in ended.stderr


def test_poses_in_millimetres_are_asked_about(tmp_path: Path) -> None:
    """A block of 0.1 m, and a tool that was put 50 m away."""
    block, poses = tmp_path / "block.stl", tmp_path / "poses.json"
    feeler.io.write_stl(block, feeler.Mockup(*box([0, 0, 0], [0.1, 0.1, 0.1])))
    pose = np.eye(4)
    pose[:3, 3] = 50.0
    poses.write_text(json.dumps([pose.tolist()] * 2))
    inputs = (block, "--unit", "mm", "--tool", block, "--tool-unit", "mm")
    for words in (("collide", *inputs, "--at", "50,50,50"), ("path", *inputs, "--poses", poses)):
        said = run(*words).stderr
        assert "the tool is at least 86.4 m from a mock-up of 0.17 m: poses are in metres" in said
    poses.write_text(json.dumps([np.eye(4).tolist(), pose.tolist()]))  # the first one is 0 in any unit
    said = run("path", *inputs, "--poses", poses, code=1).stderr
    assert "in 1 of 2 poses the tool is up to 86.4 m from a mock-up of 0.17 m: poses are in metres" in said
    assert "poses are in metres" not in run("collide", *inputs, "--at", "0.5,0,0").stderr
    assert "poses are in metres" not in run("clearance", *inputs, "--at", "0.5,0,0").stderr


def test_the_package_is_the_command_too() -> None:
    said = subprocess.run([sys.executable, "-m", "feeler", "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.startswith("feeler ")


def _with_output(words: list[str], output: Any, before: str = "") -> tuple[int, str]:
    """Exit status and stderr of the program whose stdout is `output`."""
    code = f"{before}\nfrom feeler.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code, *words], stdout=output, stderr=subprocess.PIPE, check=False)
    return done.returncode, done.stderr.decode()


@pytest.mark.skipif(os.name == "nt", reason="limits and pipes of Unix")
@pytest.mark.parametrize("command", ["--help", "info", "collide"])
def test_output_that_cannot_be_written(tmp_path: Path, stand: Path, slider: Path, command: str) -> None:
    """A full disk is one line, and the status of bad input or output; a closed pipe changes nothing."""
    of_command = {"info": [stand], "collide": [stand, "--tool", slider, "--at", "0.15,0.09375,0.125", "--json"]}
    words = [command, *map(str, of_command.get(command, []))]
    with (tmp_path / "out").open("wb") as whole:
        usual, _ = _with_output(words, whole)
    assert usual == (1 if command == "collide" else 0)
    assert (tmp_path / "out").stat().st_size > 0
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))"
    with (tmp_path / "full").open("wb") as full:
        status, said = _with_output(words, full, limit)
    assert status == 2 and said.count("\n") == 1 and said.startswith("feeler: cannot write the output: "), said
    reads, writes = os.pipe()
    os.close(reads)
    assert _with_output(words, writes) == (usual, "")
    os.close(writes)
    closed = "import os, sys; os.close(1); sys.stdout = None"
    assert _with_output(words, None, closed) == (usual, "")


@pytest.mark.parametrize("method", ["write", "flush"])
def test_ctrl_c_while_output_is_written_repeats_nothing(tmp_path: Path, method: str) -> None:
    """It comes as a method of the output returns: what it wrote is out, and is not written again at the end."""
    program = f"""
import sys
import feeler.cli
program = sys.modules["feeler.cli.app"]

def say():
    def press(frame, event, _):
        if event == "return" and frame.f_code.co_name == "{method}" and "self" in frame.f_locals:
            sys.setprofile(None)
            raise KeyboardInterrupt
    print("once", flush="{method}" == "flush")
    sys.setprofile(press)
    print("twice", flush=True)

program.app = lambda **_: say()
program.main()
"""
    with (tmp_path / "out").open("wb") as out:
        done = subprocess.run([sys.executable, "-c", program], stdout=out, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (130, "feeler: interrupted\n")
    assert (tmp_path / "out").read_text() == "once\ntwice\n"


@pytest.mark.parametrize("words", [("clash",), ("remove", "--part", "*", "--each", "--seconds", "1"), ("index",)])
def test_doubts_about_a_mock_up_are_told(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nv 10 9 9\nv 9 10 9\n"
    (tmp_path / "a.obj").write_text(f"o one\n{points}f 1 2 3\no two\nf 4 5 6\nf 4 5 77\n")
    result = CliRunner().invoke(app, [words[0], "a.obj", *words[1:]])
    assert result.exit_code in (0, 1), result.output
    assert "mock-up: 1 triangle" in result.stderr, result.stderr


@pytest.mark.parametrize("encoding", ["ascii", "cp1251", "cp932", "cp1252", "utf-8", "ascii:surrogateescape"])
def test_what_the_output_has_no_character_for_is_written_plainly(encoding: str, tmp_path: Path) -> None:
    """A pipe has the encoding of the system: on Windows, a code page."""
    path = tmp_path / "\u90e8\u54c1.stl"
    write_stl(path, feeler.Tool(*box((0.0, 0.0, 0.0), (2e-4, 1e-4, 1e-4))))
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "COLUMNS": "200"}
    words = [sys.executable, "-m", "feeler", "info", path, "--unit", "mm"]
    done = subprocess.run(words, capture_output=True, env=environment, timeout=60)
    assert done.returncode == 0 and done.stderr.count(b"Traceback") == 0, done.stderr
    shown = done.stdout.decode(encoding.partition(":")[0])
    micro = "\u00b5" if encoding in ("utf-8", "cp1251", "cp1252") else "u"
    times = "\u00d7" if encoding in ("utf-8", "cp932", "cp1252") else "x"
    extent = next(line for line in shown.splitlines() if line.startswith("extent"))
    assert extent.split(maxsplit=1)[1].startswith(f"200 {micro}m {times} 100 {micro}m")
    assert ("\u90e8\u54c1" if encoding in ("utf-8", "cp932") else r"\u90e8\u54c1") in shown
