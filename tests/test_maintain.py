"""Nightly runs: rows as `task` answers, rows kept as a full run finds them, causes, executors, and the files."""

from __future__ import annotations

import json
import math
import warnings
import zipfile
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import night_scene as night
import numpy as np
import pytest
from night_scene import covers, driver, lid, parts, placed, scene_of
from shapes import Mesh, at, box

import feeler
from feeler import _core
from feeler.errors import LoadError, MeshError, OptionError
from feeler.tasks import listed, regions
from feeler.tasks.regions import Noted, Regions
from feeler.tasks.watched import WatchedScene

SAME = (
    "state",
    "seconds",
    "low",
    "high",
    "steps",
    "undone",
    "tools",
    "reach_deg",
    "sight",
    "hidden",
    "blockers",
    "said",
)


@pytest.fixture(scope="module")
def before() -> feeler.Maintenance:
    return feeler.maintain(scene_of(parts()), covers(), tools=driver(), threads=1)


def facts(run: feeler.Maintenance) -> list[dict[str, Any]]:
    """What rows say but for the last run, comparable."""
    return [{name: row.to_dict()[name] for name in ("name", "paths", *SAME)} for row in run]


def maintained(meshes: dict[str, Mesh], previous: feeler.Maintenance | None, **options: Any) -> feeler.Maintenance:
    return feeler.maintain(
        scene_of(meshes), covers(), **{"tools": driver(), "threads": 1, **options}, previous=previous
    )


def test_rows_say_what_task_says(before: feeler.Maintenance) -> None:
    task = feeler.task(scene_of(parts()), "s2/cover", driver())
    row = before[2]
    assert (row.state, row.seconds, row.low, row.high) == ("out", task.seconds, task.low, task.high)
    assert row.name == "s2/cover" and row.paths == ("s2/cover",) and row.tools == ("driver",) == task.tools
    assert row.steps == 2 and row.undone == 1 and row.reach_deg == 360.0 and row.said == task.said
    assert 0.5 < row.sight <= 1.0 and row.hidden == () and row.change == "" and math.isnan(row.delta)
    assert not row.is_kept and before.changes == () and repr(before) == "Maintenance(4 of 4 come out)"


def changed(what: str) -> dict[str, Mesh]:
    """The stations, with one part another."""
    meshes = parts()
    if what == "lid moved":
        meshes["s2/lid"] = lid(2.0)
    elif what == "bolt changed shape":
        meshes["s2/bolt"] = placed(night.bolt(0.025), 2.0)
    elif what == "bolt was removed":
        del meshes["s2/bolt"]
    elif what == "bar was added":
        meshes["bar"] = box((1.9, -0.01, 0.1), (2.1, 0.01, 0.12))
    elif what == "cover moved":
        meshes["s2/cover"] = placed(meshes["s2/cover"], 0.0005)
    elif what == "case moved":
        meshes["s2/case"] = placed(meshes["s2/case"], 0.0, -0.002)
    return meshes


@pytest.mark.parametrize(
    ("what", "more", "is_bare"),
    [
        ("lid moved", 10.0, False),
        ("lid moved", 10.0, True),
        ("bolt changed shape", -1.0, False),
        ("bolt was removed", -1.0, False),
        ("bolt was removed", -1.0, True),
        ("bar was added", None, False),
        ("cover moved", None, False),
        ("case moved", None, False),
    ],
)
def test_kept_rows_are_those_of_a_full_run(
    before: feeler.Maintenance, what: str, more: float | None, is_bare: bool
) -> None:
    tools: dict[str, Any] = {"tools": None} if is_bare else {}
    base = maintained(parts(), None, **tools) if is_bare else before
    meshes = changed(what)
    run, full = maintained(meshes, base, **tools), maintained(meshes, None, **tools)
    assert facts(run) == facts(full)
    assert [row.is_kept for row in run] == [True, True, False, True]
    row = run[2]
    assert [str(each) for each in run.changes if each.what != "is held otherwise"] in (
        [f"s2/{what}"],
        [what],
    )
    if more is not None and not is_bare:
        assert row.delta == more if more > 0 else row.delta < 0.0
        assert row.is_slower == (more > 0) and f" since {what}" in row.change
        assert row.causes[0].path == f"s2/{what.split()[0]}" and run.by_change[0] is row
    assert all(not each.change for each in run if each is not row)


def test_most_rows_are_kept_where_one_part_in_a_hundred_moved() -> None:
    meshes = parts() | {f"rest/{n}": box((0.04 * n, -0.9, -0.9), (0.04 * n + 0.02, -0.8, -0.8)) for n in range(82)}
    assert len(meshes) == 100
    base = maintained(meshes, None)
    meshes["s2/lid"] = lid(2.0)
    run = maintained(meshes, base)
    assert facts(run) == facts(maintained(meshes, None)) and [row.is_kept for row in run] == [True, True, False, True]


def test_the_last_digits_of_coordinates_are_no_change(before: feeler.Maintenance) -> None:
    """A file in inches, read in metres, has other last digits than that in millimetres."""
    noisy = {path: (corners / 0.0254 * 0.0254 * (1.0 + 2.0**-52), faces) for path, (corners, faces) in parts().items()}
    assert any((corners != parts()[path][0]).any() for path, (corners, _) in noisy.items())
    run = maintained(noisy, before)
    assert not run.changes and all(row.is_kept and not row.change for row in run)
    shifted = {path: (corners + (path == "s2/lid") * 2e-9, faces) for path, (corners, faces) in noisy.items()}
    assert [str(each) for each in maintained(shifted, before).changes] == ["s2/lid moved"]


def test_what_blocks_is_named_with_its_change(before: feeler.Maintenance) -> None:
    """A kept lid over the bolt: no tool reaches it."""
    entries = [{"part": "s2/cover", "keep": "s2/lid"}, "s1/cover"]
    base = feeler.maintain(scene_of(parts()), entries, tools=driver())
    run = feeler.maintain(scene_of(changed("lid moved")), entries, tools=driver(), previous=base)
    row = run[0]
    assert row.state == "blocked" and row.is_unreachable and row.is_slower and "s2/lid" in row.blockers
    assert row.change == "blocked since lid moved" and math.isnan(row.seconds) and run[1].is_kept
    assert run.failing("slower") == run.failing("unreachable") == run.failing("blocked") == [row]
    assert run.failing("hidden") == run.failing("failed") == []
    again = feeler.maintain(scene_of(parts()), entries, tools=driver(), previous=run)
    assert again[0].change == "comes out since lid moved" and not again[0].is_slower
    with pytest.raises(OptionError, match="do you mean slower"):
        run.failing("slow")


def test_a_part_out_of_the_box_of_all_bears_on_all_rows(before: feeler.Maintenance) -> None:
    meshes = parts()
    meshes["frame/high"] = (meshes["frame/high"][0] + 0.01, meshes["frame/high"][1])
    assert not any(row.is_kept for row in maintained(meshes, before))
    order = dict(sorted(parts().items(), reverse=True))
    assert not any(row.is_kept for row in maintained(order, before))


def test_other_options_are_no_reason_to_keep_a_row(before: feeler.Maintenance) -> None:
    run = maintained(parts(), before, times={"take": 60.0})
    assert not any(row.is_kept for row in run) and run[0].change == "+54 s since other times were given"
    assert not any(row.is_kept for row in maintained(parts(), before, tools=None))
    assert all(row.is_kept for row in maintained(parts(), before))
    # What is seen is asked again where the eyes are others, of the plans that are kept.
    blind = maintained(parts(), before, eyes=[[0.0, 0.0, -0.9]])
    assert all(row.is_kept and row.sight == 0.0 and row.hidden for row in blind) and len(blind.failing("hidden")) == 4
    assert "seen" in blind[0].change and "other eyes" in blind[0].change


def test_what_hides_a_head_is_seen_though_the_plan_is_kept() -> None:
    eyes = [[1.0, 0.5, 0.5]]
    meshes = parts()
    base = maintained(meshes, None, eyes=eyes)
    meshes["s0/lid"] = (meshes["s0/lid"][0] + [0.5, 0.2, 0.18], meshes["s0/lid"][1])
    run, full = maintained(meshes, base, eyes=eyes), maintained(meshes, None, eyes=eyes)
    assert facts(run) == facts(full) and run[1].sight == 0.0 < base[1].sight
    assert run[1].is_kept and run[1].change == f"seen {base[1].sight:.0%} -> 0% since lid moved"


def test_a_bent_way_depends_on_everything() -> None:
    scene = scene_of(parts())
    watched = WatchedScene.of(scene)
    feeler.removal(watched, "s1/lid", directions=[[0.0, 0.0, 1.0]])
    assert not watched.noted.regions().is_all
    feeler.removal(watched, "s1/lid", directions=[[1.0, 0.0, 0.0]])  # past its neighbours, along +x or another way
    feeler.removal(watched, "s1/bolt", rounds=0)
    assert watched.noted.regions().is_all


def test_watched_scenes_answer_alike_and_note_each_query() -> None:
    known = {"hashing", "memory", "mockup", "part_mask", "simd", "storage", "validate", "voxel_size"}
    queries = {name for name in dir(_core.Scene) if not name.startswith("_")} | {"nearest", "moved", "section"}
    assert queries - known <= vars(WatchedScene).keys(), "a query that notes nothing: add it to WatchedScene"
    scene = scene_of(parts())
    rod, near, far = driver(), at(1.0, 0.0, 0.3), at(1.0, 0.0, -0.2)
    for ask in (
        lambda s: s.cast(rod, near, far).part,
        lambda s: s.cast(rod, at(1.2, 0.0, -0.02), screw=feeler.Screw([0, 0, 1], [1.1, 0, 0], 3.0)) is None,
        lambda s: s.distance(rod, near).value,
        lambda s: s.collide(rod, at(1.0, 0.0, -0.02)).parts.tolist(),
        lambda s: s.rays([[1.0, 0.003, 1.0]], [[0.0, 0.0, -1.0]]).distances.tolist(),
        lambda s: s.check_path(rod, np.array([near, far])).is_free,
        lambda s: s.without(["s1/bolt"]).contacts(rod, at(1.0, 0.0, -0.01)).gaps.tolist(),
        lambda s: s.clearance(rod, near, within=0.5).parts.tolist(),
    ):
        watched = WatchedScene.of(scene)
        assert ask(watched) == ask(scene)  # type: ignore[no-untyped-call]
        looked = watched.noted.regions()
        bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)
        bolt = scene.mockup.part_paths.index("s1/bolt")
        assert looked.meets(*bounds[bolt]) and not looked.meets(*bounds[scene.mockup.part_paths.index("s3/bolt")])


def test_regions_meet_what_moving_boxes_meet() -> None:
    """Against many places of the box."""
    random = np.random.default_rng(7)
    hits = 0
    for _ in range(300):
        low = random.uniform(-1.0, 0.0, 3)
        high, way = low + random.uniform(0.0, 0.5, 3), random.uniform(-1.0, 1.0, 3) * random.integers(0, 2, 3)
        other = random.uniform(-1.0, 0.0, 3)
        upper = other + random.uniform(0.0, 0.7, 3)
        noted = Noted(np.full(3, -9.0), np.full(3, 9.0))
        noted.sweep(np.stack([low, high])[None], way)
        looked = Regions.from_dict(json.loads(json.dumps(noted.regions().to_dict())))
        share = np.linspace(0.0, 1.0, 400)[:, None]
        is_met = ((low + share * way <= upper) & (high + share * way >= other)).all(axis=1).any()
        is_near = ((low + share * way <= upper + 0.01) & (high + share * way >= other - 0.01)).all(axis=1).any()
        hits += is_met
        assert is_met <= looked.meets(other, upper) <= is_near
    assert 20 < hits < 280


def test_coarse_regions_are_around_fine_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(5)
    noted = Noted(np.full(3, -9.0), np.full(3, 9.0))
    low = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    noted.sweep(np.stack([low, low + 0.1], axis=1), np.array([0.0, 0.0, 2.0]))
    noted.sweep(np.stack([low, low + 0.1], axis=1)[:1], np.array([1.0, 2.0, 0.5]))
    assert noted.regions().coarse().sweeps.shape == (3, 3, 3)
    monkeypatch.setattr(regions, "_MOST_SWEEPS", 2)
    fine, coarse = noted.regions(), noted.regions().coarse()
    assert len(fine.sweeps) == 3 and len(coarse.sweeps) == 2
    places = random.uniform(-0.5, 2.5, (2_000, 3))
    met = [(fine.meets(each, each + 0.1), coarse.meets(each, each + 0.1)) for each in places]
    assert all(one <= other for one, other in met) and sum(one for one, _ in met) > 20
    assert coarse.meets(np.array([0.3, 0.05, 1.0]), np.array([0.31, 0.06, 1.1]))


def test_many_boxes_become_few_and_cover_all() -> None:
    random = np.random.default_rng(3)
    noted = Noted(np.zeros(3), np.ones(3))
    places = random.uniform(0.0, 0.6, (1_500, 3))
    for place in places:
        noted.box(place, place + 0.2)
    looked = noted.regions()
    assert len(looked.boxes) < 1_500
    assert all(looked.meets(np.minimum(place + 0.025, 1.0), np.minimum(place + 0.025, 1.0)) for place in places)
    assert (looked.boxes[:, 1] - looked.boxes[:, 0]).max() < 0.4


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        yield pool


def test_rows_do_not_depend_on_the_workers(before: feeler.Maintenance, processes: Executor) -> None:
    scene = scene_of(parts())
    assert facts(feeler.maintain(scene, covers(), tools=driver(), executor=processes)) == facts(before)
    distributed = pytest.importorskip("distributed")
    with ExitStack() as ends:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # another cluster has the usual port of its pages
            cluster = ends.enter_context(
                distributed.LocalCluster(
                    n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="CRITICAL"
                )
            )
            client = ends.enter_context(distributed.Client(cluster))
        two = client.get_executor()
        run = feeler.maintain(scene, covers(), tools=driver(), executor=two)
        assert facts(run) == facts(before)
        meshes = changed("lid moved")
        again = feeler.maintain(scene_of(meshes), covers(), tools=driver(), previous=run, executor=two)
        assert facts(again) == facts(maintained(meshes, before)) and [row.is_kept for row in again].count(True) == 3


def test_an_interrupted_run_goes_on(before: feeler.Maintenance, tmp_path: Path) -> None:
    meshes = parts()
    for n in range(4):
        meshes[f"s{n}/lid"] = lid(float(n))

    def stop(share: float, _stage: str) -> None:
        if share >= 0.3:
            raise KeyboardInterrupt

    with pytest.raises(feeler.MaintenanceInterrupted) as caught:
        maintained(meshes, before, progress=stop)
    some = caught.value.maintenance
    assert some.is_partial and 1 <= len(some) < 4 and all(row.delta == 10.0 for row in some)
    some.save(tmp_path / "last.json")
    run = maintained(meshes, feeler.load_maintenance(tmp_path / "last.json"))
    assert facts(run) == facts(maintained(meshes, None)) and not run.is_partial
    # Differences count from the run before the one that was interrupted.
    assert [row.delta for row in run] == [10.0] * 4 and sum(row.is_kept for row in run) == len(some)


def test_runs_are_saved_and_read(before: feeler.Maintenance, tmp_path: Path) -> None:
    before.save(tmp_path / "last.json")
    read = feeler.load_maintenance(tmp_path / "last.json")
    assert facts(read) == facts(before) and all(row.is_kept for row in maintained(parts(), read))
    data = json.loads((tmp_path / "last.json").read_text())
    for text, said in (
        ("[]", "a list"),
        ("{", "is no run"),
        (json.dumps({**data, "format": "other"}), "its format is 'other'"),
        (json.dumps({**data, "plans": {"a": 3}}), "is no run"),
        (json.dumps({name: value for name, value in data.items() if name != "snapshot"}), "'snapshot' is missing"),
    ):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(LoadError, match=said):
            feeler.load_maintenance(tmp_path / "bad.json")
    with pytest.raises(feeler.MissingFileError, match="first run"):
        feeler.load_maintenance(tmp_path / "none.json")


def test_lists_are_checked(tmp_path: Path) -> None:
    scene = scene_of(parts(1))
    file = tmp_path / "lru.csv"
    for text, said in (
        ("", "it is empty"),
        ("part\n", "names no part"),
        ("name\ns0/cover\n", "line 1: the column 'name' is unknown"),
        ("part;kept\ns0/cover;\n", "line 1: the column 'kept' is unknown"),
        ("sep=;\npart;keep\n;s0/lid\n", "line 3: the part is missing"),
        ("keep\ns0/cover\n", "line 1: the columns are"),
        ("part,part\ns0/cover,\n", "line 1: the columns are"),
        ("part,people\n\ns0/cover,two\n", "line 3: people is 'two'"),
        ("part,people\ns0/cover,0\n", "line 2: people is 0"),
        ("part,keep\n,s0/lid\n", "line 2: the part is missing"),
        ("part\ns0/cover\ns9/cover\n", "line 3: .*s9/cover"),
        ("part,keep\ns0/cover,s0/*\n", "line 2: 's0/cover' is wanted and kept"),
        ('part\n"s0/\ncover"\ns0/cover,1\n', "line 4: there are 2 cells for 1 columns"),
        ("part\n*\n", "line 2: these are all parts"),
    ):
        file.write_text(text)
        with pytest.raises(LoadError, match=said):
            feeler.maintain(scene, file)
    with pytest.raises(feeler.MissingFileError):
        feeler.maintain(scene, tmp_path / "none.csv")
    file.write_bytes("\ufeffpart,keep,people\r\ns0/cover,s0/lid,2\r\n".encode())
    assert len(feeler.maintain(scene, str(file))) == 1
    wanted = listed.wanted_of(scene, file)
    for text in (
        "part;keep;people\r\ns0/cover;s0/lid;2\r\n",
        "part\tkeep\tpeople\ns0/cover\ts0/lid\t2\n",
        "sep=;\r\npart;keep;people\r\n\r\ns0/cover;s0/lid;2\r\n;;\r\n",
        "people;keep;part\r2;s0/lid;s0/cover\r",
        'sep=|\npart|keep|people\n"s0/cover"|s0/lid|2',
    ):
        file.write_bytes(text.encode())
        assert listed.wanted_of(scene, file) == wanted
    for given, said in (
        ([], "empty"),
        ("s0/cover", "give a list"),
        ([{"part": "s0/cover", "kept": 1}], r"parts\[0\]"),
        (["s0/cover", "s7"], r"parts\[1\]"),
    ):
        with pytest.raises(OptionError, match=said):
            feeler.maintain(scene, given)
    with pytest.raises(MeshError, match="tools has"):
        feeler.maintain(scene, ["s0/cover"], tools=[3])
    with pytest.raises(feeler.MissingFileError):
        feeler.maintain(scene, ["s0/cover"], tools="none.toml")
    with pytest.raises(OptionError, match="previous is 3"):
        feeler.maintain(scene, ["s0/cover"], previous=3)  # type: ignore[arg-type]
    renamed = feeler.Scene(
        feeler.Mockup({name: box((n, 0, 0), (n + 0.5, 1, 1)) for n, name in enumerate(("other", "b"))})
    )
    run = feeler.maintain(renamed, ["other"], seconds=5.0)
    with pytest.raises(feeler.OptionError, match=r"none of its parts is in this one \(0 of 2, such as 'other'"):
        feeler.maintain(scene, ["s0/cover"], previous=run)


def test_what_goes_wrong_in_one_row_ends_no_other() -> None:
    scene = feeler.Scene(feeler.Mockup({**parts(1), "s0/flat": (np.zeros((3, 3)), np.array([[0, 1, 2]]))}))
    run = feeler.maintain(scene, ["s0/flat", "s0/cover"])
    assert run[0].state in ("failed", "blocked", "out") and run[1].state == "out"


def test_files_are_whole_and_escaped(tmp_path: Path) -> None:
    meshes = parts(1)
    meshes["s0/<b>=1+1"] = meshes.pop("s0/lid")
    base = feeler.maintain(scene_of(meshes), ["s0/cover", "s0/<b>*"], tools=driver())
    meshes["s0/<b>=1+1"] = lid(0.0)
    run = feeler.maintain(scene_of(meshes), ["s0/cover", "s0/<b>*"], tools=driver(), previous=base)
    run.to_html(tmp_path / "night.html")
    page = (tmp_path / "night.html").read_text()
    assert "<b>" not in page and "&lt;b&gt;=1+1 moved" in page and "http" not in page.replace("http-equiv", "")
    assert page.index("Changed") < page.index("s0/cover") and "+10 s since" in page and "Parts that changed" in page
    pytest.importorskip("xlsxwriter")
    run.to_xlsx(tmp_path / "rows.xlsx")
    with zipfile.ZipFile(tmp_path / "rows.xlsx") as book:
        text = book.read("xl/sharedStrings.xml").decode()
        assert "+10 s since" in text and "moved" in text and "<f>" not in book.read("xl/worksheets/sheet1.xml").decode()
