"""Loading several files, and files that are not what they seem: what is left out, sizes, units, up axes, many parts."""

from __future__ import annotations

import importlib.util
import itertools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loading import notes, save, soup
from test_io_builders import CORNERS, SOUP, Gltf, obj_text, stl_binary, stl_text, threemf, threemf_mesh
from typer.testing import CliRunner

import feeler
from feeler import LimitError, LoadError, MissingFileError, OptionError
from feeler.clashes import openness
from feeler.cli import app
from feeler.io import axes, load_mockup, load_tool, readers
from feeler.io.raw import PathBook


def glb(**primitive: Any) -> bytes:
    g = Gltf()
    g.node(mesh=g.mesh(**primitive), name="part")
    return g.glb()


# --- nothing left ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\nl 2 1\n", "no triangle (but 2 points); 2 lines were skipped"),
        ("a.obj", "v 0 0 0\ncurv 0 1 1\n", "1 free-form curve (curv)"),
        ("a.glb", glb(mode=0), "1 primitive of points"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
         "end_header\n1 2 3\n", "the PLY file holds no triangle (but 1 point)"),
        ("a.off", "OFF\n2 1 0\n0 0 0\n1 0 0\n2 0 1\n", "1 line was skipped"),
        ("a.stl", "solid a\nsolid b\nendsolid b\n", "2 of 2 solids hold no triangle"),
    ],
)  # fmt: skip
def test_the_error_of_a_file_without_triangles_says_what_it_holds(tmp_path, name, content, words):
    with pytest.raises(LoadError) as error:
        load_mockup(save(tmp_path, name, content))
    assert name in str(error.value) and "holds no triangle" in str(error.value) and words in str(error.value)
    assert str(error.value).endswith("export it again with surfaces")


def test_a_beam_lattice_is_named(testdata):
    """Its one object is a beam lattice, which has no triangle."""
    with pytest.raises(LoadError, match=r"holds no triangle.*beam"):
        load_mockup(testdata / "files" / "3mf_beams_only.3mf")


def test_files_without_triangles_are_all_named(tmp_path):
    save(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")
    save(tmp_path, "b.stl", stl_binary()[:-10])
    save(tmp_path, "sub.obj", "v 0 0 0\np 1\n")
    with pytest.raises(LoadError, match="none holds a triangle") as error:
        load_mockup(tmp_path)
    for words in ("a.obj: 1 line was skipped", "sub.obj: 1 point was skipped", "b.stl: the header promises 4"):
        assert words in str(error.value)


# --- files that fail -------------------------------------------------------------------------------------------------


def test_a_file_of_a_folder_that_fails_is_left_out_and_named(tmp_path):
    save(tmp_path, "a.stl", stl_binary())
    save(tmp_path, "b.stl", stl_binary()[:-10])
    save(tmp_path, "c.obj", "")
    save(tmp_path, "d.glb", glb())
    (tmp_path / "e.stl").symlink_to(tmp_path / "gone.stl")
    (tmp_path / "sub").mkdir()
    save(tmp_path / "sub", "b.ply", b"\x1f\x8b packed")
    seen: list[float] = []
    mockup = load_mockup(tmp_path, progress=lambda fraction, stage: seen.append(fraction))
    assert mockup.part_paths == ("a", "d/part")
    assert seen == sorted(seen) and seen[-1] == 1.0
    doubts = mockup.report.source.doubts
    assert len(doubts) == 4 and all("left out, as it cannot be read" in doubt for doubt in doubts)
    for name, why in (("b.stl", "truncated"), ("c.obj", "empty"), ("e.stl", "no such file"), ("b.ply", "compressed")):
        assert any(name in doubt and why in doubt for doubt in doubts)
    assert set(doubts) <= set(mockup.report.source.notes)
    assert mockup.report.to_dict()["doubts"] == list(doubts)
    assert [Path(file).name for file in mockup.report.source.files] == ["a.stl", "d.glb"]


def test_a_file_that_is_named_raises_beside_others(tmp_path):
    good, bad = save(tmp_path, "a.stl", stl_binary()), save(tmp_path, "b.stl", stl_binary()[:-10])
    with pytest.raises(LoadError, match=r"b\.stl: the header promises"):
        load_mockup([good, bad])
    with pytest.raises(MissingFileError):
        load_mockup([tmp_path, tmp_path / "none.stl"])


def test_a_folder_of_one_bad_file_raises_its_error(tmp_path):
    save(tmp_path, "b.stl", stl_binary()[:-10])
    with pytest.raises(LoadError, match=r"b\.stl: the header promises"):
        load_mockup(tmp_path)


def test_a_file_too_big_for_this_machine_is_left_out_of_a_folder(tmp_path, monkeypatch):
    save(tmp_path, "a.stl", stl_binary())
    save(tmp_path, "b.obj", obj_text())

    def read_obj(path: Path, progress: Any) -> Any:
        raise LimitError(f"{path} would need much")

    monkeypatch.setitem(readers._READERS, "OBJ", read_obj)
    mockup = load_mockup(tmp_path)
    assert mockup.triangle_count == 4 and "b.obj would need much" in notes(mockup)


def test_many_files_that_fail_are_counted(tmp_path):
    save(tmp_path, "a.stl", stl_binary())
    for i in range(30):
        save(tmp_path, f"b{i}.ply", "ply\n")
    doubts = load_mockup(tmp_path).report.source.doubts
    assert len(doubts) == 21 and doubts[-1].startswith("10 more files")


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, LoadError])
def test_what_the_callers_progress_raises_stops_the_load_of_a_folder(tmp_path, error):
    for name in ("a.stl", "b.stl"):
        save(tmp_path, name, stl_text())

    def stop(fraction: float, stage: str) -> None:
        if "b.stl" in stage:
            raise error("stop")

    with pytest.raises(error, match="stop"):
        load_mockup(tmp_path, progress=stop)


# --- units and sizes -------------------------------------------------------------------------------------------------


def test_unit_counts_more_than_the_metre_of_gltf(tmp_path):
    mockup = load_mockup(save(tmp_path, "a.glb", glb()), unit="mm")
    assert np.array_equal(soup(mockup), SOUP * 0.001)
    assert mockup.report.source.unit == "mm"
    assert mockup.report.source.unit_source == "given, instead of the m the file states"


@pytest.mark.parametrize(
    ("longest", "unit", "note"),
    [
        (743, "m", "743 m long: if the file is in millimetres, give the unit mm"),
        (0.7, None, "0.7 mm long: if the file is in metres, give the unit m"),
        (0.7, "mm", "0.7 mm long: if the file is in metres, give the unit m"),
        (500, "m", None),
        (500.1, "m", "500 m long: if the file is in millimetres, give the unit mm"),
        (1, "mm", None),
        (0.999, "mm", "0.999 mm long: if the file is in metres, give the unit m"),
        (20_000, "in", "508 m long: if the file is in millimetres, give the unit mm"),
        (600_000, "mm", "600 m long: check the unit (mm)"),  # no usual unit would make it plausible
        (600_000, "m", "600,000 m long: check the unit (m)"),
        (400, "um", "0.4 mm long: if the file is in millimetres, give the unit mm"),
        (0.0005, "m", "0.5 mm long: check the unit (m)"),
        (0.005, "mm", "0.005 mm long: if the file is in metres, give the unit m"),
        (1e-5, "mm", "1e-05 mm long: check the unit (mm)"),
        (1e30, "m", "1e+30 m long: check the unit (m)"),
    ],
)
def test_sizes_that_no_mockup_has(tmp_path, longest, unit, note):
    path = save(tmp_path, "a.obj", f"v 0 0 0\nv {longest} 0 0\nv 0 {longest / 2} 0\nf 1 2 3\n")
    for mesh in (load_mockup(path, unit), load_tool(path, unit)):
        found = [line for line in mesh.report.source.notes if " long: " in line]
        assert (found[0].startswith(note) and len(found) == 1) if note else not found
        assert list(mesh.report.source.doubts) == found


def test_the_file_that_is_too_long_is_named(tmp_path):
    save(tmp_path, "a.glb", glb(corners=CORNERS * 100))
    save(tmp_path, "b.stl", stl_binary())
    assert "3,000 m long: check the units of its files (by themselves too long: a.glb)" in notes(load_mockup(tmp_path))
    save(tmp_path, "a.glb", glb(corners=CORNERS * 10))
    save(tmp_path, "b.glb", glb(corners=CORNERS * 10 + [0, 0, 400]))
    said = notes(load_mockup([tmp_path / "a.glb", tmp_path / "b.glb"]))
    assert "700 m long" in said and "(no file is too long by itself)" in said


# --- up axes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "wanted", "expected"),
    [("y", "z", [1, -3, 2]), ("z", "y", [1, 3, -2]), ("x", "z", [-2, -3, 1]), ("x", "y", [-2, 1, 3])],
)
def test_turning_is_exact(axis, wanted, expected):
    assert axes.turn(np.array([[1.0, 2.0, 3.0]]), axis, wanted).tolist() == [expected]


@pytest.mark.parametrize(("axis", "wanted"), list(itertools.product("xyz", "xyz")))
def test_turns_are_rotations_that_bring_the_axis_up_and_back(axis, wanted):
    turned = axes.turn(np.eye(3), axis, wanted)
    assert np.linalg.det(turned) == 1.0
    assert turned["xyz".index(axis)].tolist() == np.eye(3)["xyz".index(wanted)].tolist()
    assert np.array_equal(axes.turn(turned, wanted, axis), np.eye(3))
    assert not np.signbit(axes.turn(np.zeros((1, 3)), axis, wanted)).any()


@dataclass
class UpFiles:
    """Files of one triangle whose up axis their reader tells: "a_y.obj" has y up, "b_.obj" does not say."""

    folder: Path

    def save(self, *names: str) -> list[Path]:
        return [save(self.folder, name, "v 0 0 0\nv 1 2 3\nv 0 0 1\nf 1 2 3\n") for name in names]


@pytest.fixture
def up_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> UpFiles:
    plain = readers._READERS["OBJ"]

    def read_obj(path: Path, progress: Any) -> Any:
        raw = plain(path, progress)
        raw.up = path.stem.partition("_")[2] or None
        return raw

    monkeypatch.setitem(readers._READERS, "OBJ", read_obj)
    return UpFiles(tmp_path)


def test_different_up_axes_are_told_and_turned_alike(up_files):
    files = up_files.save("a_y.obj", "b_z.obj", "c_.obj", "d_x.obj", "e_y.obj")
    mixed = load_mockup(files, unit="m")
    clash = "the files have different up axes and lie across each other (x up: d_x.obj; y up: a_y.obj, e_y.obj; z up: "
    assert mixed.report.source.doubts == (clash + "b_z.obj); pass up='z' to turn them alike",)
    assert mixed.report.source.up is None
    assert np.array_equal(soup(mixed)[:, 1], [[1, 2, 3]] * 5)
    mockup = load_mockup(files, unit="m", up="Z")
    assert soup(mockup)[:, 1].tolist() == [[1, -3, 2], [1, 2, 3], [1, 2, 3], [-2, -3, 1], [1, -3, 2]]
    assert mockup.report.source.up == "z" and not mockup.report.source.doubts
    assert mockup.report.to_dict()["up"] == "z" and "z is up" in str(mockup.report)
    said = notes(mockup)
    assert "turned from y up to z up: a_y.obj, e_y.obj" in said and "turned from x up to z up: d_x.obj" in said
    assert "not turned to z up, as nothing says which axis is up there: c_.obj" in said


@pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")
def test_a_post_as_step_and_as_gltf_stands_in_one_place(testdata):
    """A post of 10 x 20 x 300 mm, as STEP z up, and as every CAD system writes it into glTF: y up, metres."""
    files = [testdata / "files" / "up_axis.step", testdata / "files" / "up_axis.gltf"]
    across = load_mockup(files)
    assert np.allclose(across.bounds[1] - across.bounds[0], [0.01, 0.3, 0.32], atol=1e-7)
    assert any("y up: up_axis.gltf; z up: up_axis.step" in doubt for doubt in across.report.source.doubts)
    mockup = load_mockup(files, up="z")
    for part in mockup.parts:
        assert np.allclose([part.lower, part.upper], [[0, 0, 0], [0.01, 0.02, 0.3]], atol=1e-7)
    assert mockup.report.source.up == "z"


def test_one_up_axis_is_no_doubt(up_files):
    for names, up in ((["a_y.obj", "b_y.obj"], "y"), (["a_y.obj", "b_.obj"], "y"), (["a_.obj"], None)):
        mockup = load_mockup(up_files.save(*names))
        assert mockup.report.source.up == up and not mockup.report.source.notes
    assert load_mockup(up_files.save("a_.obj"), up="y").report.source.up is None
    tool = load_tool(up_files.save("a_x.obj"), unit="m", up="y")
    assert tool.report.source.up == "y" and tool.vertices[1].tolist() == [-2, 1, 3]


@pytest.mark.parametrize("up", ["", "w", "zz", 2, ["z"]])
def test_up_that_is_no_axis(tmp_path, up):
    with pytest.raises(OptionError, match=r"up is .*: choose x, y or z"):
        load_mockup(save(tmp_path, "a.stl", stl_binary()), up=up)


def test_commands_tell_of_up_axes_and_doubts(up_files):
    mockup, tool = up_files.save("a_z.obj", "b_y.obj")

    def run(*more: str) -> Any:
        words = ["collide", str(mockup), "--tool", str(tool), "--at", "0,0,0", *more]
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 1, result.output  # they share a vertex
        return result

    warning = "feeler: warning: the mock-up has z up and the tool y; to turn the tool the same way, pass --up z\n"
    assert run().stderr == warning
    assert run("--up", "z").stderr == ""
    assert run("--unit", "km").stderr.startswith("feeler: warning: mock-up: 3,000 m long: if the file is in milli")
    shown = CliRunner().invoke(app, ["info", str(tool), "--up", "z"]).output
    assert "turned from y up to z up" in shown
    assert CliRunner().invoke(app, ["info", str(tool), "--up", "q"]).exit_code == 2


def test_a_tool_is_turned_to_a_saved_scene_and_to_a_sample(up_files, tmp_path):
    mockup, tool = up_files.save("a_z.obj", "b_y.obj")
    saved = tmp_path / "a.feeler"
    assert CliRunner().invoke(app, ["index", str(mockup), "-o", str(saved)]).exit_code == 0

    def collide(world: Any, *more: str) -> Any:
        return CliRunner().invoke(app, ["collide", str(world), "--tool", str(tool), "--at", "0,0,0", "--json", *more])

    assert "pass --up z" in collide(saved).stderr
    turned, plain = collide(saved, "--up", "z"), collide(mockup, "--up", "z")
    assert turned.stderr == plain.stderr == ""
    for name in ("lower", "upper", "up"):
        assert json.loads(turned.stdout)["tool"][name] == json.loads(plain.stdout)["tool"][name]
    refused = collide(saved, "--up", "y")
    assert refused.exit_code == 2 and "saved with z up" in refused.stderr
    refused = collide("sample:gearbox:45000", "--up", "z")
    assert refused.exit_code == 2 and "has y up" in refused.stderr


# --- many parts ------------------------------------------------------------------------------------------------------


def test_paths_of_equal_names_are_found_without_trying_all_before():
    """Each claim looks at one path more than it needs at most, also where `#2` is a name of the file's own."""

    class Counting(set):  # type: ignore[type-arg]
        looks = 0

        def __contains__(self, item: object) -> bool:
            Counting.looks += 1
            return super().__contains__(item)

    book = PathBook()
    book._used = Counting()
    names = ["bolt"] * 500 + [f"bolt#{i}" for i in range(2, 502)] + ["bolt"] * 500
    assert len({book.claim("a", name) for name in names}) == len(names)
    assert Counting.looks < 5 * len(names)


def test_obj_parts_are_named_once(tmp_path, monkeypatch):
    """Names cost the same for each part, however many there are."""
    calls = []
    clean = feeler.io.obj.clean_name
    monkeypatch.setattr("feeler.io.obj.clean_name", lambda name, default: calls.append(name) or clean(name, default))
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"g part_{i}\nf 1 2 3\n" for i in range(2000))
    mockup = load_mockup(save(tmp_path, "a.obj", text))
    assert mockup.part_count == 2000 and mockup.part_paths[1999] == "a/part_1999"
    assert mockup.part_of_face.tolist() == list(range(2000))
    assert len(calls) == 4000


@pytest.mark.parametrize("count", [1, 2, 3, 9, 60, 300])
@pytest.mark.parametrize("kind", ["grid", "anywhere", "nested", "equal"])
def test_boxes_that_contain_others_are_those_of_the_plain_loop(rng, count, kind):
    low, size = rng.uniform(0, 1, (count, 3)), rng.uniform(0, 0.4, (count, 3))
    if kind == "grid":  # many edges fall together
        low, size = rng.integers(0, 6, (count, 3)).astype(float), rng.integers(0, 4, (count, 3)).astype(float)
    elif kind == "nested":
        low, size = -size, 2.0 * size
    elif kind == "equal":
        low, size = np.zeros((count, 3)), np.ones((count, 3))
    high = low + size
    inside = (low[None] >= low[:, None]).all(axis=2) & (high[None] <= high[:, None]).all(axis=2)
    assert np.array_equal(openness._containing(low, high), inside.sum(axis=1) > 1)


def test_boxes_in_a_lattice_are_compared_with_few_others(monkeypatch):
    """As many times as there are boxes, or nearly: 100,000 of them would not be done otherwise."""

    def compared(side: int) -> float:
        rows = []
        plain = np.repeat
        monkeypatch.setattr(np, "repeat", lambda what, times: rows.append(len(what) * times) or plain(what, times))
        low = np.array(list(itertools.product(range(side), repeat=3)), dtype=float)
        assert not openness._containing(low, low + 0.5).any()
        monkeypatch.setattr(np, "repeat", plain)
        return sum(rows) / len(low)

    assert compared(24) < 2.0 * compared(12)


# --- words for what is damaged ---------------------------------------------------------------------------------------


def test_what_a_file_is_refused_for_is_named(tmp_path):
    """Never as a damage that was not foreseen, with Python's words."""
    for encoding in ("Shift_JIS", "no-such"):
        (tmp_path / "a.dae").write_bytes(f'<?xml version="1.0" encoding="{encoding}"?><COLLADA/>'.encode())
        with pytest.raises(LoadError, match=r"the encoding of its text is not read \(.*\); save it as UTF-8"):
            load_mockup(tmp_path / "a.dae")
    data = bytearray(threemf(threemf_mesh(1), '<item objectid="1"/>'))
    at = data.index(b"3dmodel.model") + len("3dmodel.model")
    data[at + 10 : at + 40] = bytes(30)
    (tmp_path / "a.3mf").write_bytes(data)
    with pytest.raises(LoadError, match="the archive is damaged") as error:
        load_mockup(tmp_path / "a.3mf")
    assert "not foreseen" not in str(error.value)
    with pytest.raises(LoadError, match="does not begin with a line 'ply'"):
        load_mockup(save(tmp_path, "a.ply", "\nply\nformat ascii 1.0\nend_header\n"))


def test_a_glb_filled_up_with_zeros_is_read(tmp_path):
    good = glb()
    size = int.from_bytes(good[12:16], "little")
    text = good[20 : 20 + size].rstrip()
    filled = text + b"\0" * (8 - len(text) % 4)
    rest = good[20 + size :]
    head = good[:8] + (20 + len(filled) + len(rest)).to_bytes(4, "little") + len(filled).to_bytes(4, "little")
    assert load_mockup(save(tmp_path, "a.glb", head + good[16:20] + filled + rest)).triangle_count > 0
