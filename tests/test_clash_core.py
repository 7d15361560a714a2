"""`feeler._core.clash` against the public queries, pair by pair."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import feeler
from feeler import Verdict, _core

IDENTITY = np.eye(4)
CLEARANCE = 0.002

Rows = dict[tuple[int, int], Verdict]


def table(value: float) -> npt.NDArray[np.float64]:
    return np.array([[value]])


def clash(
    scene: feeler.Scene, clearance: float = CLEARANCE, contact: float = 0.0, **options: object
) -> _core.ClashRows:
    return _core.clash(scene, table(clearance), table(contact), **options)  # type: ignore[arg-type]


def verdicts(rows: _core.ClashRows) -> Rows:
    pairs = zip(rows.a.tolist(), rows.b.tolist(), rows.verdict.tolist(), strict=True)
    return {(a, b): Verdict(verdict) for a, b, verdict in pairs}


@pytest.fixture(scope="module")
def engine() -> feeler.Scene:
    return feeler.Scene(feeler.sample("engine", triangles=20_000), threads=1)


@pytest.fixture(scope="module")
def rows(engine: feeler.Scene) -> _core.ClashRows:
    return clash(engine)


def test_pairs_are_those_of_one_part_after_the_other(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    mockup = engine.mockup
    found = verdicts(rows)
    gaps = dict(zip(found, rows.gap.tolist(), strict=True))
    triangles = dict(zip(found, rows.triangles.tolist(), strict=True))
    for part in range(len(mockup.parts)):
        tool = feeler.Tool.of_parts(mockup, [part])
        others = engine.without([part])
        near = others.clearance(tool, IDENTITY, within=CLEARANCE)
        of_part = {b if a == part else a for (a, b), verdict in found.items() if part in (a, b)}
        contained = {b if a == part else a for (a, b), v in found.items() if part in (a, b) and v == Verdict.CONTAINED}
        assert of_part - contained <= set(near.parts.tolist()) <= of_part
        hit = others.collide(tool, IDENTITY)
        met = dict(
            zip(*(x.tolist() for x in np.unique(mockup.part_of_face[hit.pairs[:, 1]], return_counts=True)), strict=True)
        )
        for other, distance in zip(near.parts.tolist(), near.distances.tolist(), strict=True):
            pair = (min(part, other), max(part, other))
            assert (gaps[pair] == 0.0) == (distance == 0.0)
            assert gaps[pair] == pytest.approx(distance, rel=1e-9, abs=1e-15)
            assert triangles[pair] == met.get(other, 0)
            if distance > 0.0 and found[pair] != Verdict.CONTAINED:
                assert found[pair] == Verdict.CLEARANCE


def test_what_crosses_clashes_and_what_enters_does_too(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    mockup = engine.mockup
    for (a, b), verdict in verdicts(rows).items():
        if verdict not in (Verdict.CLASH, Verdict.CONTACT):
            continue
        tool, other = feeler.Tool.of_parts(mockup, [a]), engine.only([b])
        kinds = other.collide(tool, IDENTITY).kinds
        is_clash = verdict == Verdict.CLASH
        if feeler.PairKind.CROSSING in kinds:
            assert is_clash
        assert other.is_colliding(tool, IDENTITY, touching="free") == is_clash


def test_numbers_go_with_the_verdict(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    n = len(rows)
    verdict = Verdict.words(rows.verdict)
    assert n > 300 and {Verdict.CLASH, Verdict.CONTACT, Verdict.CLEARANCE} <= {*verdict.tolist()}
    for array, shape in (
        (rows.translation, (n, 3)),
        (rows.point_a, (n, 3)),
        (rows.point_b, (n, 3)),
        (rows.box, (n, 2, 3)),
        (rows.is_open, (n, 2)),
        (rows.depth_kind, (n,)),
    ):
        assert array.shape == shape and np.isfinite(array).all()
    order = list(zip(rows.a.tolist(), rows.b.tolist(), strict=True))
    assert order == sorted(order) and (rows.a < rows.b).all()
    is_deep = np.isin(verdict, [Verdict.CLASH, Verdict.CONTAINED])
    length = np.linalg.norm(rows.translation, axis=1)
    assert (rows.depth[is_deep] > 0.0).all() and (rows.depth[~is_deep] == 0.0).all()
    assert (length[is_deep] >= rows.depth[is_deep] * (1.0 - 1e-9)).all() and (length[~is_deep] == 0.0).all()
    assert (rows.gap[verdict == Verdict.CLEARANCE] > 0.0).all() and (rows.gap <= CLEARANCE)[
        verdict == Verdict.CLEARANCE
    ].all()
    apart = np.linalg.norm(rows.point_b - rows.point_a, axis=1)
    is_near = verdict == Verdict.CLEARANCE
    assert apart[is_near] == pytest.approx(rows.gap[is_near], rel=1e-6)
    assert (rows.box[:, 0] <= rows.box[:, 1]).all()
    assert not rows.is_partial and {*rows.seconds} == {"verdicts", "clearance", "depths"}
    assert rows.counts["crossing"] + rows.counts["touching"] == int((rows.triangles > 0).sum())


def test_a_translation_frees_the_part_that_it_moves(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    for i in np.flatnonzero(rows.verdict == Verdict.CLASH.code)[::7].tolist():
        tool = feeler.Tool.of_parts(engine.mockup, [int(rows.a[i])])
        pose = np.eye(4)
        pose[:3, 3] = rows.translation[i]
        assert not engine.only([int(rows.b[i])]).is_colliding(tool, pose), i


def test_the_same_rows_on_any_number_of_threads_and_in_every_store(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    def columns(of: _core.ClashRows) -> list[npt.NDArray[np.generic]]:
        names = (
            "a",
            "b",
            "verdict",
            "depth",
            "depth_kind",
            "translation",
            "gap",
            "point_a",
            "point_b",
            "triangles",
            "box",
            "is_open",
        )
        return [getattr(of, name) for name in names]

    for threads in (1, 2, 5):
        for one, other in zip(columns(rows), columns(clash(engine, threads=threads)), strict=True):
            assert np.array_equal(one, other)
    dense = clash(feeler.Scene(engine.mockup, storage="dense", threads=1))
    assert verdicts(dense) == verdicts(rows) and np.array_equal(dense.gap, rows.gap)


def test_parts_that_are_out_and_pairs_that_are_not_asked(engine: feeler.Scene, rows: _core.ClashRows) -> None:
    found = verdicts(rows)
    out = int(rows.a[0])
    assert verdicts(clash(engine.without([out]))) == {pair: v for pair, v in found.items() if out not in pair}
    exclude = np.array([[rows.b[1], rows.a[1]]], np.uint32)
    expected = {pair: v for pair, v in found.items() if pair != (int(rows.a[1]), int(rows.b[1]))}
    assert verdicts(clash(engine, exclude=exclude)) == expected
    # Two classes: one is asked against the other alone.
    classes = np.arange(len(engine.mockup.parts), dtype=np.uint32) % 2
    between = _core.clash(
        engine, np.array([[-1.0, CLEARANCE], [CLEARANCE, -1.0]]), np.zeros((2, 2)), class_of_part=classes
    )
    assert verdicts(between) == {(a, b): v for (a, b), v in found.items() if (a + b) % 2}
    # What each part adds makes contacts of what is near.
    touching = clash(engine, contact_of_part=np.full(len(engine.mockup.parts), CLEARANCE / 2))
    assert Verdict.CLEARANCE not in verdicts(touching).values()
    assert {*verdicts(touching)} == {*found}


def test_ctrl_c_leaves_what_was_found(engine: feeler.Scene) -> None:
    def stop_at(stage: str) -> _core.ClashRows:
        def progress(share: float, now: str) -> None:
            if now == stage:
                raise KeyboardInterrupt

        return clash(engine, progress=progress)

    for stage in ("finding colliding parts", "measuring clearances", "measuring depths"):
        # A stage may be over before it is heard: then it is stopped again.
        stopped = next((rows for rows in (stop_at(stage) for _ in range(50)) if rows.is_partial), None)
        assert stopped is not None, stage
        pairs = {*verdicts(stopped)}
        assert pairs <= {*verdicts(clash(engine))}


def test_ctrl_c_at_the_last_word_is_told(engine: feeler.Scene) -> None:
    # On one thread the same is told each time. The last of it is heard when the rows are done.
    told: list[float] = []
    clash(engine, threads=1, progress=lambda share, _: told.append(share))
    heard: list[float] = []

    def progress(share: float, stage: str) -> None:
        heard.append(share)
        if len(heard) == len(told):
            raise KeyboardInterrupt

    assert clash(engine, threads=1, progress=progress).is_partial


def test_a_progress_that_raises_is_heard(engine: feeler.Scene) -> None:
    def progress(share: float, stage: str) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        clash(engine, progress=progress)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"clearance": np.zeros((1, 2))}, r"clearance has shape \[1, 2\]"),
        ({"contact": np.zeros((2, 2))}, "contact has 4 entries where 1"),
        ({"contact": np.array([[-1.0]])}, "contact is -1.0"),
        ({"clearance": np.array([[np.nan]])}, "clearance is NaN"),
        ({"exclude": np.array([[0, 1_000_000]], np.uint32)}, "there is no part 1000000"),
        ({"class_of_part": np.zeros(3, np.uint32)}, "class_of_part has 3 entries"),
    ],
)
def test_bad_tables_are_told(engine: feeler.Scene, options: dict[str, npt.NDArray[np.generic]], message: str) -> None:
    tables = {"clearance": table(0.0), "contact": table(0.0), **options}
    with pytest.raises(feeler.FeelerError, match=message):
        _core.clash(engine, tables.pop("clearance"), tables.pop("contact"), **tables)  # type: ignore[arg-type]


def test_one_part_has_nothing_to_clash_with() -> None:
    tool = feeler.sample_tool("wrench")
    assert len(clash(feeler.Scene(feeler.Mockup(tool.vertices, tool.faces)), 1.0)) == 0
