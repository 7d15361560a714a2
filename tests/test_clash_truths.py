"""The judge of depths (bench/clash/judge): its truths agree, it sees what is wrong, and feeler is right."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest

asking = importlib.import_module("clash.judge.asking")
branching = importlib.import_module("clash.judge.branching")
experiment = importlib.import_module("clash.judge.experiment")
facts = importlib.import_module("clash.judge.facts")
flat = importlib.import_module("clash.judge.flat")
goals = importlib.import_module("clash.goals")
kinds = importlib.import_module("clash.judge.kinds")
shapes = importlib.import_module("clash.judge.shapes")
stability = importlib.import_module("clash.judge.stability")
tables = importlib.import_module("clash.tables")
whole_numbers = importlib.import_module("clash.judge.whole_numbers")

Answer, Facts, Group = asking.Answer, facts.Facts, asking.Group
SEED = 7
FEW = {"boxes": 60, "convex": 30, "fine": 1, "polycubes": 2, "polycubes_in_contact": 1, "balls": 4, "pins": 12}
NEEDS_VOLUMES = {"solids", "copies", "copies_in_single"}


def random_polycube(rng: np.random.Generator) -> object:
    cells = shapes.pattern(rng)
    size = 1024.0 * rng.choice([1, 1, 2])
    return shapes.Polycube(cells, shapes.even_planes(cells, size, 1024.0 * rng.integers(0, 3, 3)))


@pytest.mark.parametrize("name", list(kinds.KINDS))
def test_feeler_is_right(name: str) -> None:
    if name in NEEDS_VOLUMES:
        pytest.importorskip("manifold3d")
    found = list(asking.asked(kinds.groups(name, FEW.get(name, 9), SEED)))
    assert found
    assert [each.says for each in found if each.is_verdict_wrong or each.is_outside] == []


def test_every_kind_has_many_verdicts() -> None:
    """A generator that made only apart pairs would prove nothing."""
    seen = set()
    for name in ("boxes", "polycubes", "convex", "copies"):
        for group in kinds.groups(name, {"boxes": 300, "polycubes": 6}.get(name, 50), SEED):
            for each in group.facts.values():
                seen |= {(name, verdict) for verdict in facts.wanted(each, None, group.clearance, 0.0) or ()}
    of_lattices = {"clash", "contact", "none", "contained", "duplicate"}
    for name in ("boxes", "polycubes"):
        assert {verdict for kind, verdict in seen if kind == name} >= of_lattices
    assert {verdict for kind, verdict in seen if kind == "convex"} == {"clash", "contained", "none"}
    assert {verdict for kind, verdict in seen if kind == "copies"} == {"duplicate", "contained"}


def test_a_full_run_has_enough_pairs() -> None:
    pairs = {name: number * (36 if name.startswith("polycubes") else 1) for name, (_, number) in kinds.KINDS.items()}
    assert kinds.LUMP * (kinds.LUMP - 1) // 2 == 36
    assert sum(pairs.values()) > goals.JUDGED_PAIRS
    assert kinds.KINDS["pins"][1] >= 3 * 400


def test_boxes_by_three_ways() -> None:
    rng = np.random.default_rng(SEED)
    deep = 0
    for _ in range(60):
        low = rng.integers(0, 5, (2, 3)) * 8.0
        high = low + 8.0 * rng.integers(1, 5, (2, 3))
        found = whole_numbers.boxes(low[0], high[0], low[1], high[1])
        bodies = [shapes.Polycube(np.zeros((1, 3), int), tuple(np.stack([low[i], high[i]], axis=1))) for i in range(2)]
        other = whole_numbers.polycubes(*bodies)
        assert other.low == pytest.approx(found.low, rel=1e-8) and other.low <= found.low <= other.high
        assert replace(other, low=found.low, high=found.high) == found
        depth = flat.deepest_of_convex(*(shapes.box(low[i], high[i]) for i in range(2)))
        assert max(depth, 0) == pytest.approx(found.low, abs=1e-9)
        deep += found.low > 0
    assert 10 < deep < 60


def test_convex_bodies_by_two_ways() -> None:
    for group in kinds.groups("convex", 25, SEED):
        truth = group.facts[0, 1]
        low, high = branching.depth(*group.parts, 1e-4) if group.triangles() < 400 else (truth.low, truth.high)
        assert low <= truth.high and truth.low <= high


def test_polycubes_by_two_ways() -> None:
    rng = np.random.default_rng(SEED)
    compared = 0
    while compared < 12:
        a, b = random_polycube(rng), random_polycube(rng)
        truth = whole_numbers.polycubes(a, b)
        if truth.low == 0:
            continue
        turn = shapes.random_turn(rng)
        low, high = branching.depth(*((m[0] / 1024 @ turn.T, m[1]) for m in (a.mesh(rng), b.mesh(rng))), 1e-4)
        assert low * 1024 <= truth.high + 1e-9 and truth.low <= high * 1024 + 1e-9
        compared += 1


def test_pins_by_two_ways() -> None:
    rng = np.random.default_rng(SEED)
    compared = 0
    for _ in range(12):
        sides, phase, radius = rng.integers(4, 9, 2).tolist(), rng.uniform(), rng.uniform(0.9, 1.1)
        pin = shapes.revolved([(0, -1), (radius, -1), (radius, 3), (0, 3)], sides[0], phase)
        block = shapes.tube(1.0, 3.0, 0.0, 2.0, sides[1])
        sections = []
        for number, size, start in ((sides[0], radius, phase), (sides[1], 1.0, 0.0)):
            angles = start + 2 * np.pi * np.arange(number) / number
            sections.append(size * np.stack([np.cos(angles), np.sin(angles)], axis=1))
        depth = flat.overlap_in_plane(*sections)
        if depth > 0.01:
            low, high = branching.depth(pin, block, 1e-4)
            assert low <= depth * (1 + 1e-9) and depth <= high
            compared += 1
    assert compared > 5


def test_balls_of_facets_are_within_their_bounds() -> None:
    groups = (group for group in kinds.groups("balls", 200, SEED) if group.triangles() < 400)
    compared = 0
    for group in groups:
        truth = group.facts[0, 1]
        low, high = branching.depth(*group.parts, 1e-3)
        assert low <= truth.high and truth.low <= high
        compared += truth.low > 0
    assert compared > 1


def test_no_sample_is_deeper_than_the_bound() -> None:
    rng = np.random.default_rng(SEED)
    a, b = shapes.torus(0.2, 0.08, 12, 7), shapes.tube(0.05, 0.12, -0.2, 0.1, 9)
    b = b[0] @ shapes.random_turn(rng).T + 0.15, b[1]
    low, high = branching.depth(a, b)
    deepest = 0.0
    for one, other in ((a, b), (b, a)):
        corners, triangles = one[0][one[1]], other[0][other[1]]
        weights = rng.dirichlet((1, 1, 1), (len(corners), 40))
        points = np.einsum("nks,nsx->nkx", weights, corners).reshape(-1, 3)
        points = points[branching.is_inside(points, triangles)]
        tiled = np.broadcast_to(points, (len(triangles), *points.shape))
        deepest = max(deepest, float(branching.distances(tiled, triangles).min(axis=0).max()))
    assert 0.9 * low < deepest <= high


def test_solids_by_depth_and_by_volume() -> None:
    pytest.importorskip("manifold3d")
    verdicts = {group.facts[0, 1].low > 0 for group in kinds.groups("solids", 45, SEED)}  # raises where they disagree
    assert verdicts == {True, False}


def group_of(truth: object, **more: object) -> object:
    mesh = shapes.box([0, 0, 0], [1, 1, 1]).mesh()
    return Group("boxes", (mesh, mesh), {(0, 1): truth}, **more)


@pytest.mark.parametrize(
    ("answer", "is_verdict_wrong", "is_outside"),
    [
        (Answer("clash", 0.1, 1e-4, "measured"), False, False),
        (Answer("clash", 0.09995, 9e-5, "measured"), False, False),
        (Answer("contact", 0.1, 1e-4, "measured"), True, False),
        (Answer(), True, False),
        (Answer("clash", 0.101, 1e-4, "measured"), False, True),  # deeper than the truth
        (Answer("clash", 0.0998, 9e-5, "measured"), False, True),  # the bound above is below the truth
        (Answer("clash", 0.0995, 1e-3, "measured"), False, True),  # an error that is too wide
        (Answer("clash", 0.1, 1e-4, "estimate"), False, True),
    ],
)
def test_the_judge_sees_what_is_wrong(answer: object, is_verdict_wrong: bool, is_outside: bool) -> None:
    found = asking.judged(group_of(Facts(0.1, 0.1)), (0, 1), answer, 1e-15)
    assert (found.is_verdict_wrong, found.is_outside) == (is_verdict_wrong, is_outside)
    assert bool(found.says) == (is_verdict_wrong or is_outside)


def test_which_verdicts_are_right() -> None:
    def right(truth: object, contact: float | None = None, clearance: float = 0.0, rounding: float = 0.0) -> set[str]:
        return set(facts.wanted(truth, contact, clearance, rounding) or ())

    assert right(Facts(0.0, 0.0)) == {"contact"}
    assert right(Facts(0.0, 0.0), rounding=1e-15) == {"contact"}
    assert right(Facts(1e-9, 1e-9)) == {"clash"} and right(Facts(1e-15, 1e-15), rounding=1e-15) == set()
    assert right(Facts(0.1, 0.1), contact=0.2) == {"contact"} and right(Facts(0.1, 0.1), contact=0.09) == {"clash"}
    assert right(Facts(0.1, 0.3), contact=0.2) == set()
    assert right(Facts(0.0, 0.0, 0.1)) == {"none"} and right(Facts(0.0, 0.0, 0.1), clearance=0.2) == {"clearance"}
    assert right(Facts(0.0, 0.0, 0.1), contact=0.2) == {"contact"}
    assert right(Facts(0.0, 0.0, is_same=True)) == {"duplicate"}
    inside = Facts(0.1, 0.1, is_inside=True)
    assert right(inside) == {"contained"} and right(inside, rounding=1e-15) == {"contained", "clash"}
    assert right(replace(inside, is_touching=False), rounding=1e-15) == {"contained"}


def test_changes_of_depths_are_counted() -> None:
    before = {(0, 1): Answer("clash", 0.1, 1e-4, "measured"), (0, 2): Answer("contact", 0.0, 0.0, "measured")}
    same = {(0, 1): Answer("clash", 0.10005, 1e-4, "measured")}
    nothing = {"pairs": 2, "beyond": 0, "most_m": 0.0, "verdicts": 1, "examples": []}
    assert stability.compared(before, same, 0.0) == nothing
    moved = {**before, (0, 1): Answer("clash", 0.1021, 1e-4, "measured")}
    assert stability.compared(before, moved, 1e-3)["beyond"] == 1
    assert stability.compared(before, moved, 3e-3)["beyond"] == 0
    open_parts = {**before, (0, 1): Answer("clash", 0.5, 0.0, "estimate")}
    assert stability.compared(before, open_parts, 0.0)["beyond"] == 0


def test_cutting_keeps_the_surface() -> None:
    mesh = shapes.torus(0.2, 0.05, 6, 5)
    finer = shapes.cut_finer(mesh, 2)
    assert len(finer[1]) == 16 * len(mesh[1])

    def area(vertices: np.ndarray, faces: np.ndarray) -> float:
        corners = vertices[faces]
        return float(
            np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        )

    assert area(*finer) == pytest.approx(area(*mesh), rel=1e-12)
    sides = np.sort(finer[1][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1].tolist()) == {2}


def test_the_table_says_what_is_wrong() -> None:
    judged = [
        asking.Judged("boxes", True, False, False, 1e-4, ""),
        asking.Judged("boxes", False, True, False, None, "feeler says clash"),
        asking.Judged("pins", True, False, True, 0.02, "too deep"),
    ]
    rows = experiment.summed(judged)
    assert [row["kind"] for row in rows] == ["boxes", "pins"] and rows[0]["examples"] == ["feeler says clash"]
    change = {"parts": "pins", "change": "cut", "pairs": 3, "beyond": 1, "most_m": 0.1, "verdicts": 0}
    origin = {"args": [], "dirty": False, "is_quick": False, "when": "2000-01-01", "commit": "0" * 40}
    found = {**origin, "machine": {"cpu": "a CPU"}, "kinds": rows, "stability": [change]}
    text = tables.judge(found)
    assert "| boxes | 2 | 1 | **1** | 0 | 0.0001 |" in text and "| **all** | 3 | 2 | **1** | **1** | 0.02 |" in text
    assert "| pins | cut | 3 | **1** |" in text
    missed = [goal.goal for goal in goals.scorecard({"judge": found}) if not goal.is_met]
    assert len(missed) == 4
    right = {"judge": {**found, "is_quick": True, "kinds": rows[:0], "stability": [{**change, "beyond": 0}]}}
    assert all(goal.is_met for goal in goals.scorecard(right))
