"""`feeler.clash` and its table: what is found, in which order, how it is read, and what is refused."""

from __future__ import annotations

import dataclasses
import math
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import clash_twin
import numpy as np
import pytest
from clash.cases import cut_box
from clash_scene import FOUND, PARTS, house, mockup_of, open_box, pairs, table
from shapes import box

import feeler
from feeler import Verdict, _core
from feeler.clashes import ClashInterrupted
from feeler.clashes.pictures import Pictures
from feeler.errors import MeshError, OptionError

RANK = {"clash": 0, "duplicate": 0, "contained": 0, "contact": 1, "clearance": 2}


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


def test_each_kind_is_found_and_told_apart(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    assert pairs(found) == FOUND
    assert all(each.a < each.b for each in found)
    for each in found:
        assert (each.depth > 0) == (each.verdict in (Verdict.CLASH, Verdict.CONTAINED, Verdict.DUPLICATE))
        assert (each.gap > 0) == (each.verdict in (Verdict.CLEARANCE, Verdict.CONTAINED))
        assert (each.triangles > 0) == (each.verdict not in (Verdict.CLEARANCE, Verdict.CONTAINED))
        assert not each.is_open_a and not each.is_open_b
        assert all(low <= high for low, high in zip(*each.box, strict=True))
    walls = next(each for each in found if each.path_b == "house/walls/right")
    assert walls.depth == pytest.approx(0.0625, abs=1e-12) and walls.depth_kind == "exact"
    near = next(each for each in found if each.verdict == Verdict.CLEARANCE)
    assert near.gap == 0.0009765625 and near.point_a[0] == 2.0 and near.point_b[0] == 2.0009765625


def test_the_way_out_is_that_of_the_first_part(mockup: feeler.Mockup) -> None:
    for each in feeler.clash(mockup).where(verdict="clash"):
        assert np.linalg.norm(each.translation) == pytest.approx(each.depth, rel=1e-2, abs=1e-5)
        way = np.eye(4)
        way[:3, 3] = np.array(each.translation) * 1.001
        tool = feeler.Tool.of_parts(mockup, each.a)
        rest = feeler.Scene(mockup).only(each.b)
        assert rest.is_colliding(tool, np.eye(4)) and not rest.is_colliding(tool, way, touching="free")


def test_the_worst_is_first() -> None:
    rows = [
        {"a": 0, "b": 1, "verdict": Verdict.CLEARANCE, "gap": 0.001},
        {"a": 0, "b": 2, "verdict": Verdict.CLASH, "depth": 0.01},
        {"a": 0, "b": 3, "verdict": Verdict.CONTACT},
        {"a": 1, "b": 2, "verdict": Verdict.CONTAINED, "depth": 0.5},
        {"a": 1, "b": 3, "verdict": Verdict.CLEARANCE, "gap": 0.0005},
        {"a": 2, "b": 3, "verdict": Verdict.CONTACT, "severity": 0},
        {"a": 3, "b": 1, "verdict": Verdict.CLASH, "depth": 0.01},
        {"a": 3, "b": 2, "verdict": Verdict.DUPLICATE, "depth": 9.0, "severity": 2},
    ]
    found = [(each.a, each.b) for each in table(rows)]
    assert found == [(2, 3), (1, 2), (0, 2), (3, 1), (0, 3), (1, 3), (0, 1), (3, 2)]


def test_columns_and_rows_say_the_same(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    names = ["a", "b", "verdict", "depth", "depth_kind", "gap", "triangles", "rule", "severity", "status"]
    for place, each in enumerate(found):
        assert found[place] == each == found[place - len(found)]
        for name in names:
            assert getattr(found, name)[place] == getattr(each, name), name
        for name in ("translation", "point_a", "point_b"):
            assert tuple(getattr(found, name)[place]) == getattr(each, name)
        assert found.box[place].tolist() == [list(corner) for corner in each.box]
        assert found.ids[place] == each.id
    assert len(set(found.ids)) == len(found)
    with pytest.raises(ValueError, match="read-only"):
        found.depth[0] = 7.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        found[0].depth = 7.0  # type: ignore[misc]
    with pytest.raises(IndexError):
        found[len(found)]


def test_slices_are_tables_that_share_their_status(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    part = found[2:5]
    assert isinstance(part, feeler.Clashes) and len(part) == 3 and list(part) == list(found)[2:5]
    deep = found[found.depth > 0.1]
    assert len(deep) == np.count_nonzero(found.depth > 0.1)
    part.set_status(part.ids[0], "reviewed", by="ada", note="seen")
    assert found[2].status == "reviewed" and found[2].by == "ada" and found[2].note == "seen"
    assert list(found.where(status="reviewed")) == [found[2]]
    assert len(found.where(verdict="clash", status="new")) == len(found.where(verdict=Verdict.CLASH)) - 1
    assert len(found[:0]) == 0 and repr(found[:0]) == "Clashes(0: none)"
    with pytest.raises(OptionError, match="mask of shape"):
        found[np.array([True])]


def test_wrong_choices_of_rows(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    with pytest.raises(OptionError, match="no verdict 'crash': choose clash, contact"):
        found.where(verdict="crash")
    with pytest.raises(OptionError, match="not chosen by 'depth'"):
        found.where(depth="0")
    with pytest.raises(OptionError, match="groups are not made by 'colour': choose part, rule, cluster"):
        found.groups("colour")
    with pytest.raises(OptionError, match="reach is for groups by"):
        found.groups("part", reach=1.0)
    with pytest.raises(OptionError, match="reach is -1"):
        found.groups("cluster", reach=-1.0)


def test_repr_counts(mockup: feeler.Mockup) -> None:
    text = repr(feeler.clash(mockup))
    assert text == "Clashes(9: 4 clash, 2 contact, 1 clearance, 1 contained, 1 duplicate)"


def test_dicts(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    rows = found.to_dicts()
    assert [row["verdict"] for row in rows] == [each.verdict.name.lower() for each in found]
    assert rows[0]["path_a"] == found[0].path_a and math.isnan(rows[0]["volume"])
    assert all(not isinstance(value, np.generic) for row in rows for value in row.values())


def test_pandas_if_it_is_there(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    found = feeler.clash(mockup)
    monkeypatch.setitem(sys.modules, "pandas", None)  # as if it were not installed
    with pytest.raises(OptionError, match="to_pandas needs pandas: pip install pandas"):
        found.to_pandas()
    monkeypatch.undo()
    pandas = pytest.importorskip("pandas")
    frame = found.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == len(found)
    assert frame.index.name == "id" and list(frame.depth) == found.depth.tolist()
    assert found[:0].to_pandas().shape[0] == 0


def test_limits(mockup: feeler.Mockup) -> None:
    meeting = {pair: verdict for pair, verdict in FOUND.items() if verdict != "clearance"}
    near = ("house/walls/right", "yard/near")
    assert pairs(feeler.clash(mockup, clearance=0.0, contact=0.001))[near] == "contact"
    assert pairs(feeler.clash(mockup, clearance=0.0)) == meeting
    assert pairs(feeler.clash(mockup, clearance=0.0009)) == meeting
    assert len(feeler.clash(mockup, clearance=3.0)) == len(PARTS) * (len(PARTS) - 1) // 2
    found = feeler.clash(mockup, contact=0.0625 + 1e-9)
    touching = found.where(verdict="contact")
    assert not touching.depth.any() and not touching.translation.any() and set(touching.depth_kind) == {"exact"}
    deep = pairs(found)
    # What is no deeper than that touches.
    assert {pair: verdict for pair, verdict in deep.items() if FOUND[pair] != verdict} == {
        ("house/walls/left", "house/walls/right"): "contact",
        ("house/walls/right", "house/copy/left"): "contact",
        ("house/walls/right", "yard/near"): "contact",
    }


def test_excluded_pairs_are_not_asked(mockup: feeler.Mockup) -> None:
    left = {pair: verdict for pair, verdict in FOUND.items() if "bolt" not in "".join(pair)}
    assert pairs(feeler.clash(mockup, exclude=[("*bolt*", "*")])) == left
    left = {pair: verdict for pair, verdict in FOUND.items() if pair != ("house/walls/left", "house/walls/right")}
    for exclude in (np.array([[1, 0]]), np.array([[0, 1], [3, 3]]), [("house/walls", "house/walls")]):
        assert pairs(feeler.clash(mockup, exclude=exclude)) == left


def test_a_scene_serves_and_says_who_is_there(mockup: feeler.Mockup) -> None:
    scene = feeler.Scene(mockup)
    found = feeler.clash(mockup, scene=scene)
    assert list(found.ids) == list(feeler.clash(mockup).ids)
    assert "index" in dict(found.facts.seconds)
    here = pairs(feeler.clash(mockup, scene=scene.without("house/copy")))
    assert here == {pair: verdict for pair, verdict in FOUND.items() if "house/copy/left" not in pair}
    assert len(feeler.clash(mockup, scene=scene.only("yard/near"))) == 0


def test_open_parts_are_told_and_hold_nothing() -> None:
    inside = box((0.25, 0.25, 0.25), (0.5, 0.5, 0.5))
    found = feeler.clash(mockup_of({"tub": open_box((0, 0, 0), (1, 1, 1)), "duck": inside}))
    assert len(found) == 0
    found = feeler.clash(mockup_of({"duck": inside, "tub": open_box((0.375, 0, 0), (1, 1, 1))}))
    (row,) = found
    assert (row.is_open_a, row.is_open_b) == (False, True) and row.verdict == Verdict.CLASH


@pytest.mark.parametrize("count", [0, 1])
def test_mockups_of_few_parts(count: int) -> None:
    mockup = mockup_of({"alone": box((0, 0, 0), (1, 1, 1))})
    scene = feeler.Scene(mockup)
    found = feeler.clash(mockup, scene=scene if count else scene.without("alone"))
    assert len(found) == 0 and found.ids == () and found.groups() == [] and list(found) == []
    assert found.rule.shape == (0,) and found.status.shape == (0,) and found.box.shape == (0, 2, 3)


def test_many_coincident_parts() -> None:
    number = 12
    mockup = mockup_of({f"copies/{i}": box((0, 0, 0), (1, 1, 1)) for i in range(number)})
    found = feeler.clash(mockup)
    assert len(found) == number * (number - 1) // 2 and set(found.verdict.tolist()) == {Verdict.DUPLICATE}
    assert len(set(found.ids)) == len(found)
    assert sum(len(group) for group in found.groups()) == len(found) == len(found.groups("cluster")[0])


def copies(number: int) -> feeler.Mockup:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    return feeler.Mockup(
        np.tile(vertices, (number, 1)),
        np.concatenate([faces + 8 * i for i in range(number)]),
        np.repeat(np.arange(number), 12),
        [f"copy {i}" for i in range(number)],
    )


def test_a_thousand_coincident_parts() -> None:
    found = feeler.clash(copies(1000))
    assert len(found) == 1000 * 999 // 2 and set(found.verdict.tolist()) == {Verdict.DUPLICATE}
    assert len(np.unique(np.stack([found.a, found.b]), axis=1).T) == len(found)
    assert set(found[:1000].rule.tolist()) == {"default"} and found[499_499].b == 999


@pytest.mark.slow
def test_a_part_of_millions_against_bolts(rng: np.random.Generator) -> None:
    vertices, faces = cut_box([0, 0, 0], [1, 1, 1], 650)
    meshes = [(vertices, faces)]
    places = rng.uniform(0.05, 0.95, (200, 2))
    for x, y in places:
        meshes.append(box((x - 0.01, y - 0.01, 0.9), (x + 0.01, y + 0.01, 1.05)))
    mockup = mockup_of({f"part {i}": mesh for i, mesh in enumerate(meshes)})
    assert mockup.part_triangles[0] > 5_000_000
    found = feeler.clash(mockup, clearance=0.0)
    against = found[found.a == 0]
    assert len(against) == 200 and set(against.verdict.tolist()) == {Verdict.CLASH}
    # Out of the top, or of a side that is nearer.
    least = np.minimum(0.1, np.minimum(places, 1.0 - places).min(axis=1) + 0.01)
    assert against.depth[np.argsort(against.b)] == pytest.approx(least, rel=2e-6)
    assert set(against.depth_kind.tolist()) <= {"exact", "bound"}
    # A picture of one needs no picture of all.
    assert Pictures(mockup).png(against[0]).startswith(b"\x89PNG")


def test_wrong_arguments(mockup: feeler.Mockup) -> None:
    asked: Any = feeler.clash
    with pytest.raises(MeshError, match=r"needs a feeler\.Mockup, not list"):
        asked([])
    for value in (-1.0, math.nan, math.inf, "2 mm", True, None):
        with pytest.raises(OptionError, match=r"clearance is .*: give metres, 0 or more"):
            asked(mockup, clearance=value)
    for value in (-1e-9, math.nan, "chrod", None):
        with pytest.raises(OptionError, match=r'contact is .*: give metres, 0 or more, or "chord"'):
            asked(mockup, contact=value)
    with pytest.raises(OptionError, match="scene is of another mock-up"):
        asked(mockup, scene=feeler.Scene(house()))
    with pytest.raises(OptionError, match=r"exclude, of the mock-up: no part is called, or matches, '\*blot\*'.*bolt"):
        asked(mockup, exclude=[("*blot*", "*")])
    with pytest.raises(OptionError, match="the mock-up has no part 99"):
        asked(mockup, exclude=np.array([[0, 99]]))
    with pytest.raises(OptionError, match="exclude holds 'bolt'"):
        asked(mockup, exclude=["bolt"])
    with pytest.raises(OptionError, match="threads is 0"):
        asked(mockup, threads=0)


def test_chordal_errors_are_known_of_step_alone(mockup: feeler.Mockup, testdata: Path) -> None:
    with pytest.raises(OptionError, match=r'contact="chord".*only of STEP files.*give contact in metres'):
        feeler.clash(mockup, contact="chord")
    step = feeler.load_mockup(testdata / "meshes" / "assembly.step", chord_tolerance=2e-4)
    assert step.source.chord_tolerance == 2e-4
    assert feeler.load_mockup(testdata / "meshes" / "assembly.step").source.chord_tolerance == 1e-4
    assert feeler.load_mockup(testdata / "files" / "stl_end_loop.stl").source.chord_tolerance is None
    by_chord, by_hand = feeler.clash(step, contact="chord"), feeler.clash(step, contact=4e-4)
    assert pairs(by_chord) == pairs(by_hand)
    assert by_chord.facts.contact == "chord"


def test_contact_by_chord_is_the_sum_of_both(testdata: Path) -> None:
    overlap = 0.0003
    mockup = mockup_of({"a": box((0, 0, 0), (1, 1, 1)), "b": box((1 - overlap, 0.25, 0.25), (2, 0.75, 0.75))})
    for tolerance, verdict in ((1e-4, "clash"), (2e-4, "contact")):
        mockup.source = feeler.mockup.Source(chord_tolerance=tolerance)
        assert list(pairs(feeler.clash(mockup, contact="chord")).values()) == [verdict]
        assert list(pairs(feeler.clash(mockup)).values()) == ["clash"]


def test_volumes(mockup: feeler.Mockup) -> None:
    pytest.importorskip("manifold3d")
    found = feeler.clash(mockup, volume=True)
    volume = {(each.path_a, each.path_b): each.volume for each in found}
    assert volume["house/walls/left", "house/walls/right"] == pytest.approx(0.0625, rel=1e-9)
    assert volume["house/walls/left", "house/copy/left"] == pytest.approx(1.0, rel=1e-9)
    assert volume["house/walls/right", "house/pins/core"] == pytest.approx(1 / 64, rel=1e-9)
    assert volume["house/walls/left", "yard/flush"] == 0.0 == volume["house/walls/right", "yard/near"]
    assert np.isnan(feeler.clash(mockup).volume).all()


def test_volumes_of_what_is_open_mirrored_or_far_off() -> None:
    pytest.importorskip("manifold3d")
    solid, tub = box((0, 0, 0), (1, 1, 1)), open_box((0.5, 0.25, 0.25), (1.5, 0.75, 0.75))
    (row,) = feeler.clash(mockup_of({"a": solid, "b": tub}), volume=True)
    assert math.isnan(row.volume)
    other = box((0.5, 0.25, 0.25), (1.5, 0.75, 0.75))
    mirrored = other[0], other[1][:, ::-1]
    (row,) = feeler.clash(mockup_of({"a": solid, "b": mirrored}), volume=True)
    assert row.volume == pytest.approx(0.125, rel=1e-9)
    # Thin, and far off: there manifold3d takes lengths of a few nanometres for none.
    thin = box((1 - 2.0**-29, 0.25, 0.25), (1.5, 0.75, 0.75))
    far = {name: (mesh[0] + 4096.0, mesh[1]) for name, mesh in {"a": solid, "b": thin}.items()}
    (row,) = feeler.clash(mockup_of(far), volume=True)
    assert row.volume == pytest.approx(2.0**-31, rel=1e-3)


def test_volumes_need_their_extra(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)  # as if it were not installed
    with pytest.raises(OptionError, match=r'volumes need manifold3d: pip install "feeler\[volume\]"'):
        feeler.clash(mockup, volume=True)


@pytest.mark.parametrize("volume", [False, True])
def test_progress_ends_with_1_and_never_goes_back(mockup: feeler.Mockup, volume: bool) -> None:
    if volume:
        pytest.importorskip("manifold3d")
    told: list[float] = []
    feeler.clash(mockup, volume=volume, progress=lambda fraction, _stage: told.append(fraction))
    assert told == sorted(told) and told[-1] == 1.0


def test_an_interrupted_check_leaves_what_it_found(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    # By the plain twin: the core may be done before it hears.
    monkeypatch.setattr(_core, "clash", clash_twin.clash)

    def stop(fraction: float, stage: str) -> None:
        if fraction > 0.35:  # some way into the first stage
            raise KeyboardInterrupt

    with pytest.raises(ClashInterrupted) as caught:
        feeler.clash(mockup, progress=stop)
    found = caught.value.clashes
    assert found.is_partial and len(found) < len(FOUND) and pairs(found).items() <= FOUND.items()
    assert repr(found).endswith("partial)")
    assert isinstance(caught.value, KeyboardInterrupt)
    there = pickle.loads(pickle.dumps(caught.value))
    assert pairs(there.clashes) == pairs(found) and there.clashes.is_partial


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 1.0])
def test_ctrl_c_at_any_moment_keeps_what_there_is(mockup: feeler.Mockup, share: float) -> None:
    def stop(fraction: float, stage: str) -> None:
        if fraction >= share:
            raise KeyboardInterrupt

    scene = feeler.Scene(mockup)
    with pytest.raises(ClashInterrupted) as caught:
        feeler.clash(mockup, scene=scene, progress=stop)
    assert pairs(caught.value.clashes).keys() <= FOUND.keys()


def test_what_a_progress_function_raises_is_raised(mockup: feeler.Mockup) -> None:
    def fail(_fraction: float, _stage: str) -> None:
        raise RuntimeError("full")

    with pytest.raises(RuntimeError, match="full"):
        feeler.clash(mockup, progress=fail)


def test_threads_change_nothing(mockup: feeler.Mockup) -> None:
    one, many = (feeler.clash(mockup, threads=threads) for threads in (1, 3))
    assert list(one) == list(many)


def test_the_package_is_not_hidden_by_the_function() -> None:
    code = "import feeler, feeler.clashes as room; assert callable(feeler.clash) and room.clash is feeler.clash"
    subprocess.run([sys.executable, "-c", code], check=True)
