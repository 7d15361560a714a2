"""Tasks: plans against exhaustive search, tools, times, people, what is blocked, and the files."""

from __future__ import annotations

import importlib
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from commands import error_of, run, run_json
from shapes import Mesh, at, box, joined, mockup_of

import feeler
from feeler.errors import LoadError, MeshError, OptionError
from feeler.io import write_glb, write_stl
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance
from feeler.tasks.crewed import Job, critical, scheduled
from feeler.tasks.reached import Reaching
from feeler.tasks.times import Arithmetic, strokes_for

run_bench = importlib.import_module("tasks.run")
assemblies = importlib.import_module("tasks.assemblies")

Floats = npt.NDArray[np.float64]
USUAL = Tolerance(1e-4)
SIZE, CLEAR, TAPPED = 0.008, 0.0045, 0.0034


def ring(inner: float, low: float, high: float) -> Mesh:
    mesh = hardware.ring(inner, 0.02, high - low, USUAL)
    return mesh.vertices + np.array([0.0, 0.0, low]), mesh.faces.astype(np.int64)


def bolt(length: float, place: Floats | None = None) -> Mesh:
    mesh, pose = hardware.hex_bolt(SIZE, length, USUAL), np.eye(4) if place is None else place
    return mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces.astype(np.int64)


def nut(top: float) -> Mesh:
    """With its bearing face at z = `top`, below it."""
    mesh = hardware.nut(SIZE, USUAL)
    return mesh.vertices * [1.0, -1.0, -1.0] + [0.0, 0.0, top], mesh.faces.astype(np.int64)


def scene_of(**parts: Mesh) -> feeler.Scene:
    return feeler.Scene(mockup_of(parts), threads=1)


@pytest.fixture
def covered() -> feeler.Scene:
    """A cover under a bolt in a case, and a lid above the head."""
    return scene_of(
        bolt=bolt(0.03),
        cover=ring(CLEAR, -0.01, 0.0),
        case=ring(TAPPED, -0.04, -0.01),
        lid=box((-0.03, -0.03, 0.02), (0.03, 0.03, 0.025)),
    )


def driver(radius: float = 0.002) -> feeler.Tool:
    """A rod above the head."""
    return feeler.Tool(*box((-radius, -radius, 0.0005), (radius, radius, 0.05)), name="driver")


@pytest.mark.parametrize("seed", [4, 8, 12, 29, 33, 42])
def test_plans_are_as_quick_as_exhaustive_search(seed: int) -> None:
    one = run_bench.answer(seed)
    assert one.faults == [] and one.is_quick and one.is_bounded
    # In these, to take a part out only for its room saves time, or there is no plan.
    assert one.task.is_found == (one.least is not None)


def test_plans_do_not_depend_on_threads() -> None:
    one, many = (run_bench.answer(8, threads=count).task.to_dict() for count in (1, 2))
    assert one == many


def test_what_blocks_the_tool_goes_first(covered: feeler.Scene) -> None:
    task = feeler.task(covered, "cover", driver())
    assert [(step.verb, step.part, step.tool) for step in task.steps] == [
        ("take out", "lid", ""),
        ("undo", "bolt", "driver"),
        ("take out", "cover", ""),
    ]
    assert task.tools == ("driver",) and task.bound <= task.seconds and task.is_complete
    assert [step.after for step in task.steps] == [(), (0,), (1,)]  # the cover leaves sideways, or below the lid
    assert "best found" in repr(task) and "not below" in repr(task) and "minimum" not in repr(task)
    lid, undo, cover = task.steps
    assert undo.strokes == 16 and undo.swing_deg == 360.0 and len(undo.tool_way) == 2
    assert undo.way[-1][2, 3] > 0.03 and covered.mockup.part_names.index("lid") in undo.looked
    assert undo.arithmetic.startswith(
        "20 mm / 1.25 mm (M8, ISO 261 coarse) = 16 turns; at 360 deg a stroke: 16 strokes"
    )
    assert "'case'" in undo.because and "along +z" in cover.because
    assert lid.start == 0.0 and undo.start == lid.seconds and task.seconds == pytest.approx(cover.start + cover.seconds)
    assert task.spread == pytest.approx(math.sqrt(sum(step.spread**2 for step in task.steps)))
    assert undo.low == undo.seconds - undo.spread and undo.high == undo.seconds + undo.spread


def test_times_of_steps_add_up(covered: feeler.Scene) -> None:
    elements = {"get": 100.0, "reach": 10.0, "stroke": [2.0, 0.5], "draw": 1.0, "aside": 0.5, "take": 7.0}
    task = feeler.task(covered, "cover", driver(), elements)
    assert [step.seconds for step in task.steps] == [7.5, 100.0 + 10.0 + 16 * 2.0 + 1.5, 7.5]
    assert [step.spread for step in task.steps] == [0.0, pytest.approx(0.5 * 4.0), 0.0]
    assert task.by_tool["driver"].mean == task.steps[1].seconds and task.work.mean == task.seconds
    typed = feeler.task(covered, "cover", driver(), feeler.Times(elements, typed={"bolt": [33.0, 3.0]}))
    assert typed.steps[1].seconds == 133.0 and "typed" in typed.steps[1].arithmetic
    coarse = feeler.task(covered, "cover", None, feeler.Times(elements, pitches_mm={"bolt": 2.5, "*stud*": 1.0}))
    assert any("'*stud*'" in note for note in coarse.notes) and not any("match no part" in note for note in typed.notes)
    assert "20 mm / 2.5 mm (pitch given) = 8 turns; at 60 deg" in coarse.steps[-2].arithmetic
    assert coarse.steps[-2].strokes == 48 and "not checked" in coarse.notes[0]


def said(task: feeler.Task) -> list[tuple[str, str, tuple[str, ...]]]:
    return [(each.part, each.because, each.blockers) for each in task.blocked]


def test_a_forced_order_that_cannot_be_is_the_reason(covered: feeler.Scene) -> None:
    held = feeler.task(covered, "cover", None, before=[("cover", "bolt")])
    assert said(held) == [("bolt", "by the forced order it goes after a part that it holds", ("cover",))]
    walls = {"floor": box((-0.06, -0.06, -0.01), (0.06, 0.06, 0.0))}
    for n, x, y in ((0, 0.055, 0.0), (1, -0.055, 0.0), (2, 0.0, 0.055), (3, 0.0, -0.055)):
        half = (0.005, 0.06) if x else (0.05, 0.005)
        walls[f"wall{n}"] = box((x - half[0], y - half[1], 0.0), (x + half[0], y + half[1], 0.06))
    low, high = box((-0.049, -0.049, 0.001), (0.049, 0.049, 0.011)), box((-0.049, -0.049, 0.012), (0.049, 0.049, 0.03))
    scene = scene_of(**walls, low=low, middle=box((-0.02, -0.02, 0.0112), (0.02, 0.02, 0.0118)), high=high)
    task = feeler.task(scene, "low", None, keep=["floor", "wall*"], before=[("low", "middle"), ("middle", "high")])
    assert {(part, because.split("order ")[1], blockers) for part, because, blockers in said(task)} == {
        ("low", "it goes before what is in its way", ("middle", "high")),
        ("middle", "it goes before what is in its way", ("high",)),
        ("high", "it goes after a part that it blocks", ("low", "middle")),
    }


def test_a_forced_order_is_kept_and_one_that_cannot_be_is_said(covered: feeler.Scene) -> None:
    place = np.eye(4)
    place[0, 3] = 0.1
    two = scene_of(a=bolt(0.03), b=bolt(0.03, place), under=ring(CLEAR, -0.01, 0.0), case=ring(TAPPED, -0.04, -0.01))
    free = feeler.task(two, ["a", "b"])
    first, second = (step.part for step in free.steps if step.verb == "undo")
    back = feeler.task(two, ["a", "b"], before=[(second, first)])
    assert [step.part for step in back.steps if step.verb == "undo"] == [second, first]
    assert back.seconds == free.seconds and back.bound <= free.bound
    for pairs in (np.array([]), iter([(second, first)])):
        assert feeler.task(two, ["a", "b"], before=pairs).is_found  # type: ignore[arg-type]
    blocked = feeler.task(covered, "cover", driver(), before=[("bolt", "lid")])
    assert not blocked.is_found and "order was forced" in blocked.notes[-1]
    reason = "by the forced order it goes after a fastener whose tool it keeps out"
    assert said(blocked) == [("lid", reason, ("bolt",))]
    with pytest.raises(OptionError, match="before goes in a circle: 'a' before 'b' before 'a': leave one"):
        feeler.task(two, ["a", "b"], before=[("a", "b"), ("b", "a")])
    with pytest.raises(OptionError, match="before goes in a circle: 'a' before 'under' before 'b' before 'a': leave"):
        feeler.task(two, "case", before=[("under", "b"), ("b", "a"), ("a", "under"), ("a", "case")])
    with pytest.raises(OptionError, match="before has 'under' before 'case', which leave together: leave this pair"):
        feeler.task(two, ["case", "under"], before=[("under", "case")])
    for wrong in ([("a", "a")], [("a",)], ["ab"], {"a": "b"}, 3):
        with pytest.raises(OptionError):
            feeler.task(two, "a", before=wrong)  # type: ignore[arg-type]


def test_what_nothing_frees_is_named(covered: feeler.Scene) -> None:
    kept = feeler.task(covered, "cover", driver(), keep="lid")
    assert not kept.is_found and kept.steps == () and math.isnan(kept.seconds)
    assert [(each.part, each.blockers) for each in kept.blocked] == [("bolt", ("lid",))]
    assert "no tool reaches it" in kept.blocked[0].because and repr(kept).startswith("Task(blocked: bolt:")
    held = feeler.task(covered, "cover", driver(), keep="bolt")
    assert [(each.part, each.because) for each in held.blocked] == [("cover", "a fastener that holds it is kept")]
    axis = feeler.task(covered, "cover", keep="lid")
    assert "along its axis" in axis.blocked[0].because and axis.blocked[0].blockers == ("lid",)


def test_the_mate_of_what_is_undone_is_loose() -> None:
    scene = scene_of(
        bolt=bolt(0.03),
        top=ring(CLEAR, -0.01, 0.0),
        below=ring(CLEAR, -0.02, -0.01),
        nut=nut(-0.02),
    )
    task = feeler.task(scene, "top", driver(), keep="below")
    assert [step.verb for step in task.steps] == ["undo", "take out"] and task.steps[0].part == "bolt"
    both = feeler.task(scene, ["bolt", "nut"], driver())
    assert [(step.verb, step.part) for step in both.steps] == [("undo", "bolt"), ("take out", "nut")]
    assert "loose" in both.steps[1].because


def test_washers_and_plugs_leave_with_what_they_are_on() -> None:
    washer = hardware.washer(SIZE, USUAL)
    thick = float(np.ptp(washer.vertices[:, 2]))
    scene = scene_of(
        bolt=bolt(0.03, at(z=thick)),
        washer=(washer.vertices - [0.0, 0.0, washer.vertices[:, 2].min()], washer.faces.astype(np.int64)),
        cover=ring(CLEAR, -0.01, 0.0),
        case=ring(TAPPED, -0.04, -0.01),
    )
    task = feeler.task(scene, "cover")
    assert [sorted(step.paths) for step in task.steps] == [["bolt", "washer"], ["cover"]]


def test_parts_that_block_each_other_leave_together() -> None:
    scene = scene_of(
        upper=joined(box((0.0, 0.0, 0.0), (0.02, 0.01, 0.01)), box((0.005, 0.012, 0.004), (0.015, 0.014, 0.006))),
        hook=joined(
            box((0.0, 0.0105, 0.0), (0.02, 0.0115, 0.01)),
            box((0.0, 0.0115, 0.0), (0.0045, 0.0145, 0.01)),
            box((0.0155, 0.0115, 0.0), (0.02, 0.0145, 0.01)),
            box((0.0, 0.0145, 0.0), (0.02, 0.0165, 0.01)),
            box((0.0045, 0.0115, 0.0065), (0.0155, 0.0145, 0.01)),
            box((0.0045, 0.0115, 0.0), (0.0155, 0.0145, 0.0035)),
        ),
        floor=box((-0.1, -0.1, -0.03), (0.1, 0.1, -0.01)),
    )
    task = feeler.task(scene, "upper")
    assert [sorted(step.paths) for step in task.steps] == [["hook", "upper"]]


def test_two_people_work_at_once() -> None:
    parts: dict[str, Mesh] = {}
    for n, x in enumerate((0.0, 0.1)):
        for name, mesh in (("bolt", bolt(0.03)), ("cover", ring(CLEAR, -0.01, 0.0))):
            parts[f"{name}_{n}"] = (mesh[0] + np.array([x, 0.0, 0.0]), mesh[1])
        case = ring(TAPPED, -0.04, -0.01)
        parts[f"case_{n}"] = (case[0] + np.array([x, 0.0, 0.0]), case[1])
    scene = scene_of(**parts)
    alone, pair = (feeler.task(scene, ["bolt_0", "bolt_1"], driver(), people=people) for people in (1, 2))
    assert {step.person for step in pair.steps} == {0, 1} and pair.steps[1].start == 0.0
    assert alone.seconds / 2.0 < pair.seconds < alone.seconds and pair.bound <= pair.seconds
    assert pair.by_person.keys() == {0, 1} and pair.work.mean > alone.work.mean  # each gets a tool


def test_jobs_wait_for_those_before_them_and_keep_the_tool_in_hand() -> None:
    jobs = [Job("a", 10.0, ()), Job("b", 10.0, ()), Job("a", 10.0, (0,)), Job("", 5.0, (1, 2))]
    (first, second, third, last) = scheduled(jobs, 2.0, 1)
    assert [slot.is_changed for slot in (first, second, third, last)] == [True, True, True, False]
    assert last.end == 41.0 and critical([first, second, third, last]) == [0, 1, 2, 3]
    pair = scheduled(jobs, 2.0, 2)
    assert [slot.person for slot in pair] == [0, 1, 0, 0] and pair[3].end == 27.0 and critical(pair) == [0, 2, 3]
    assert scheduled([], 2.0, 3) == [] and critical([]) == []


def test_answers_of_tools_are_remembered_by_what_they_look_at(covered: feeler.Scene) -> None:
    rows = feeler.find_fasteners(covered)
    reaching = Reaching(covered, driver(), 1)
    lid, case = (int(covered.mockup.parts.select(name)[0]) for name in ("lid", "case"))
    assert reaching.near(rows[0]) >= {lid} and rows[0].part not in reaching.near(rows[0])
    assert not reaching.reached(rows[0], frozenset(), 8.0).tooled and reaching.asked == 1
    assert reaching.reached(rows[0], frozenset([lid]), 8.0).tooled and reaching.asked == 2
    far = scene_of(bolt=bolt(0.03), case=ring(TAPPED, -0.04, -0.01), far=box((1.0, 1.0, 1.0), (1.1, 1.1, 1.1)))
    rows = feeler.find_fasteners(far)
    reaching = Reaching(far, driver(), 1)
    away = int(far.mockup.parts.select("far")[0])
    assert reaching.reached(rows[0], frozenset(), 8.0) is reaching.reached(rows[0], frozenset([away]), 8.0)
    assert case >= 0


def test_several_tools_and_their_options(covered: feeler.Scene) -> None:
    thick = feeler.Tool(*box((-0.03, 0.0005, -0.03), (0.03, 0.05, 0.03)), name="thick")
    task = feeler.task(covered, "cover", {"thick": (thick, {"grip": "y"}), "thin": driver()}, keep="case")
    assert set(task.tools) <= {"thick", "thin"} and task.is_found
    one, same = (feeler.task(covered, "cover", each) for each in ((driver(),), [driver()]))  # type: ignore[list-item]
    assert [step.because for step in one.steps] == [step.because for step in same.steps] and one.tools == same.tools
    odd: Any
    for odd in ((), [()], ("a",), [("a",)], {"w": ()}, {"w": (driver(),)}):
        with pytest.raises((OptionError, MeshError), match="tools"):
            feeler.task(covered, "cover", odd)
    for bad in ([], {"a": 3}, "tools.toml", (driver(), {"grab": "y"}), [driver(), driver()], (driver(), {"lift": "x"})):
        with pytest.raises((OptionError, MeshError, LoadError)):
            feeler.task(covered, "cover", bad)


def test_a_plan_without_fasteners_says_so() -> None:
    scene = scene_of(lid=box((0.0, 0.0, 0.01), (0.1, 0.1, 0.02)), base=box((0.0, 0.0, 0.0), (0.4, 0.1, 0.0099)))
    (note,) = [note for note in feeler.task(scene, "lid").notes if "fastener," in note]
    assert "the unit" in note and "400 mm long" in note


def test_a_table_of_times_is_a_file(tmp_path: Path) -> None:
    times = feeler.Times({"get": [5.0, 1.0]}, pitches_mm={'*"x"\\*': 1.5}, typed={"*bolt*": 9.0})
    times.save(tmp_path / "times.toml")
    again = feeler.Times.load(tmp_path / "times.toml")
    assert again == times and "get" not in times.examples and len(times.examples) == 8
    text = (tmp_path / "times.toml").read_text()
    assert "an example, not measured" in text
    (tmp_path / "filled.toml").write_text(text.replace("# stroke = [1.2, 0.3]", "stroke = [2.0, 0.5]"))
    filled = feeler.Times.load(tmp_path / "filled.toml")
    assert filled.elements["stroke"] == (2.0, 0.5) and "stroke" not in filled.examples
    for text in (
        "[element]\nget = 1\n",
        "[elements]\nfetch = 1\n",
        "[elements]\nget = [1, 2, 3]\n",
        "[elements]\nget = -1",
    ):
        (tmp_path / "bad.toml").write_text(text)
        with pytest.raises(LoadError, match=r"bad\.toml"):
            feeler.Times.load(tmp_path / "bad.toml")


@pytest.mark.parametrize(("size", "engaged", "turns"), [(0.008, 0.01, 8.0), (0.00665, 0.01, 8.0), (0.0052, 0.004, 5.0)])
def test_turns_are_length_over_pitch(size: float, engaged: float, turns: float) -> None:
    found = Arithmetic(feeler.Times()).turns("a", size, engaged)
    if size == 0.00665:  # the core of M8 is nearer to M6 by name of size: the mesh alone cannot tell
        assert found.count == pytest.approx(10.0)
    else:
        assert found.count == pytest.approx(turns)
    assert strokes_for(20.0000001, 360.0) == 20  # by rounding of single precision
    assert strokes_for(2.5, 90.0) == 10 and strokes_for(2.5, 360.0) == 3 and strokes_for(0.0, 60.0) == 1


def test_the_page_and_the_workbook(covered: feeler.Scene, tmp_path: Path) -> None:
    pytest.importorskip("xlsxwriter")
    renamed = feeler.Mockup(
        *(covered.mockup.vertices, covered.mockup.faces, covered.mockup.part_of_face),
        [f"=<b>{name}</b>" for name in covered.mockup.part_names],
    )
    task = feeler.task(feeler.Scene(renamed), "*cover*", driver(), people=2)
    task.to_html(tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    assert "<svg" in page and "&lt;b&gt;" in page and "<b>" not in page and "16 strokes" in page and "example" in page
    task.to_xlsx(tmp_path / "a.xlsx")
    task.to_xlsx(tmp_path / "b.xlsx")
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.xlsx") as book:
        texts = book.read("xl/sharedStrings.xml").decode()
        sheets = [book.read(f"xl/worksheets/sheet{n}.xml").decode() for n in (1, 2, 3)]
    assert "=&lt;b&gt;lid" in texts and "best found: 3 steps" in texts and "(M8, ISO 261 coarse)" in texts
    assert sheets[0].count("<row ") == 4 and not any("<f>" in sheet for sheet in sheets)


def test_the_command(covered: feeler.Scene, tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", covered.mockup)
    write_stl(tmp_path / "driver.stl", driver())
    words: list[Any] = ["task", tmp_path / "a.glb", "--part", "cover", "--tool", tmp_path / "driver.stl"]
    text = run(*words, "--html", tmp_path / "a.html").stdout
    assert "best found: 3 steps" in text and "undo a/bolt" in text and (tmp_path / "a.html").exists()
    document = run_json(*words, "--people", "2")
    assert document["is_found"] and [step["verb"] for step in document["steps"]] == ["take out", "undo", "take out"]
    assert "in its way" in run(*words, "--keep", "lid", code=1).stdout
    assert run_json(*words, "--keep", "lid", code=1)["blocked"][0]["blockers"] == ["a/lid"]
    run("task", "--write-times", tmp_path / "t.toml")
    assert feeler.Times.load(tmp_path / "t.toml").elements == feeler.Times().elements
    assert len(run_json(*words, "--times", tmp_path / "t.toml")["examples"]) == 9
    assert "give --part" in error_of("task", tmp_path / "a.glb")
    assert "--grip is for --tool" in error_of("task", tmp_path / "a.glb", "--part", "cover", "--grip", "y")
    assert "times" in error_of(*words, "--times", tmp_path / "none.toml")


def test_bad_questions_are_refused(covered: feeler.Scene) -> None:
    for words in (
        {"parts": []},
        {"parts": "nothing"},
        {"parts": "*"},
        {"keep": "cover"},
        {"people": 0},
        {"seconds": 0},
    ):
        with pytest.raises(OptionError):
            feeler.task(covered, **{"parts": "cover", **words})  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="is out already"):
        feeler.task(covered.without("cover"), "cover")


def test_tools_are_chosen_from_a_catalogue(covered: feeler.Scene, tmp_path: Path) -> None:
    task = feeler.task(covered, "cover", "built-in")
    undo = next(step for step in task.steps if step.verb == "undo")
    assert undo.tool.startswith(("socket 13", "ring 13", "open 13")) and undo.strokes >= 16 and len(undo.tool_way) == 2
    same = feeler.task(covered, "cover", feeler.catalogue())
    assert same.to_dict() == task.to_dict()
    kept = feeler.task(covered, "cover", "built-in", keep="lid")
    assert kept.is_found or kept.blocked[0].blockers == ("lid",)
    write_glb(tmp_path / "a.glb", covered.mockup)
    words: list[Any] = ["task", tmp_path / "a.glb", "--part", "cover", "--catalogue", "built-in"]
    assert run_json(*words)["tools"] == [undo.tool]
    assert "give one" in error_of(*words, "--tool", "sample:hand")


@pytest.mark.parametrize(
    ("parts", "turns"), [(("bolt", "case"), "15 mm / 1.25 mm"), (("bolt", "nut"), "11.4 mm / 1.25 mm")]
)
def test_a_thread_is_turned_until_its_end_is_out(parts: tuple[str, str], turns: str) -> None:
    """A bolt of 25 mm stands out beyond a thin thread, or by 5 mm beyond its nut."""
    every = {
        "bolt": bolt(0.025),
        "cover": ring(CLEAR, -0.01, 0.0),
        "case": ring(TAPPED, -0.014, -0.01),
        "nut": nut(-0.0136),
        "low": ring(CLEAR, -0.0136, -0.01),
    }
    chosen = {"cover", *parts, *(("low",) if "nut" in parts else ())}
    scene = scene_of(**{name: mesh for name, mesh in every.items() if name in chosen})
    task = feeler.task(scene, "cover")
    (undone,) = [step for step in task.steps if step.verb == "undo"]
    assert undone.arithmetic.startswith(turns), undone.arithmetic


def test_a_flush_cover_leaves_its_base_in_place() -> None:
    """Turned, so that the coordinates of flush faces differ by rounding."""
    for seed in range(3):
        turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        parts = {
            "cover": ring(CLEAR, 0.0, 0.01),
            "base": ring(TAPPED, -0.03, 0.0),
            "bolt": bolt(0.025, at(z=0.01)),
            "beside": box((0.1, 0.1, -0.1), (0.2, 0.2, 0.1)),
        }
        scene = scene_of(**{name: (vertices @ turn.T, faces) for name, (vertices, faces) in parts.items()})
        task = feeler.task(scene, "cover")
        assert task.is_found and {path for step in task.steps for path in step.paths} == {"bolt", "cover"}
