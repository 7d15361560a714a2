"""Tasks: parts that leave with what is fastened to them alone, or have it undone before."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, joined, mockup_of

import feeler
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

Floats = npt.NDArray[np.float64]
USUAL = Tolerance(2e-4)
GAP = 2e-5


def turn_of(seed: int | None) -> Floats:
    if seed is None:
        return np.eye(3)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def bolt(x: float, y: float, head: float, length: float) -> Mesh:
    """An M6 bolt along z; its head lies at a height."""
    mesh = hardware.hex_bolt(0.006, length, USUAL)
    return mesh.vertices + np.array([x, y, head]), mesh.faces.astype(np.int64)


def plate(corners: tuple[tuple[float, float, float], tuple[float, float, float]], *holes: tuple[float, float]) -> Mesh:
    """A box with holes for bolts, as four boxes around each: one hole at most."""
    low, high = np.array(corners)
    if not holes:
        return box(tuple(low), tuple(high))
    ((x, y),) = holes
    r = 0.0034
    return joined(
        box((low[0], low[1], low[2]), (x - r, high[1], high[2])),
        box((x + r, low[1], low[2]), (high[0], high[1], high[2])),
        box((x - r, low[1], low[2]), (x + r, y - r, high[2])),
        box((x - r, y + r, low[2]), (x + r, high[1], high[2])),
    )


def covered() -> dict[str, Mesh]:
    """A cover on a base under a bolt at x = -30 mm, and a bracket on the cover under a screw at x = 30 mm."""
    foot = 0.01 + 2 * GAP
    return {
        "base": box((-0.06, -0.06, -0.04), (0.06, 0.06, 0.0)),
        "cover": plate(((-0.05, -0.03, GAP), (0.05, 0.03, 0.01 + GAP)), (-0.03, 0.0)),
        "bolt": bolt(-0.03, 0.0, 0.01 + 2 * GAP, 0.02),
        "bracket": plate(((0.02, -0.01, foot), (0.04, 0.01, foot + 0.004)), (0.03, 0.0)),
        "screw": bolt(0.03, 0.0, foot + 0.004 + GAP, 0.012),
    }


def plan(parts: dict[str, Mesh], wanted: Any = "cover", seed: int | None = None, **options: Any) -> feeler.Task:
    turn = turn_of(seed)
    scene = feeler.Scene(mockup_of({name: (corners @ turn.T, faces) for name, (corners, faces) in parts.items()}))
    return feeler.task(scene, wanted, **options)


def left(task: feeler.Task) -> list[list[str]]:
    """What leaves in each step."""
    return [sorted(step.paths) for step in task.steps]


ON_IT = [["bolt"], ["bracket", "cover", "screw"]]
"""The cover leaves with its bracket."""


@pytest.mark.parametrize("seed", [None, 1, 2])
def test_a_bracket_leaves_with_its_cover(seed: int | None) -> None:
    task = plan(covered(), seed=seed)
    assert left(task) == ON_IT and task.bound == pytest.approx(task.seconds) and task.is_complete
    last = task.steps[-1]
    assert last.part == "cover" and last.verb == "take out" and "bracket stays on it" in last.because
    assert plan(covered(), seed=seed, threads=1).to_dict() == task.to_dict()


def test_a_bracket_that_is_kept_or_forced_to_go_first_is_undone() -> None:
    free, kept = plan(covered()), plan(covered(), keep=["bracket", "base"])
    assert kept.steps[-1].paths == ("cover",) and "screw" in {step.part for step in kept.steps}
    assert kept.seconds > free.seconds + 20.0
    assert not plan(covered(), keep="screw").is_found
    for first, second in (("bracket", "cover"), ("screw", "bolt")):
        forced = plan(covered(), before=[(first, second)])
        assert forced.is_found and forced.bound <= forced.seconds
    assert plan(covered(), before=[("bracket", "cover")]).steps[-1].paths == ("cover",)
    both = plan(covered(), ["cover", "screw"])
    assert [each for each in left(both) if "screw" in each] == [["screw"]]


def test_a_bracket_below_a_lip_is_undone_for_a_cover_in_a_recess() -> None:
    """Both can be lifted by 4 mm only, and the rim is 12 mm high: the cover alone goes up and then sideways."""
    rim = [box((x, -0.036, 0.0), (x + 0.004, 0.036, 0.012)) for x in (-0.055, 0.051)]
    rim += [box((-0.051, y, 0.0), (0.051, y + 0.004, 0.012)) for y in (-0.036, 0.032)]
    lip = [box((0.035, -0.056, 0.0), (0.05, -0.05, 0.04)), box((0.035, -0.056, 0.034), (0.05, 0.01, 0.04))]
    parts = covered()
    arm = box((0.036, -0.01, 0.014), (0.04, 0.01, 0.03))
    parts |= {"base": joined(parts["base"], *rim, *lip), "bracket": joined(parts["bracket"], arm)}
    task = plan(parts, keep="base")
    assert sorted(left(task)) == [["bolt"], ["bracket"], ["cover"], ["screw"]] and task.bound <= task.seconds


def cage() -> Mesh:
    """Around the cover and above it, with a slot towards +x that the cover alone passes."""
    sides = [box((-0.056, y, GAP), (0.056, y + 0.004, 0.05)) for y in (-0.035, 0.031)]
    back, beam = box((-0.056, -0.031, GAP), (-0.052, 0.031, 0.05)), box((0.052, -0.031, 0.012), (0.056, 0.031, 0.05))
    return joined(*sides, back, beam, box((-0.056, -0.035, 0.05), (0.056, 0.035, 0.054)))


def test_a_bracket_in_the_way_is_undone() -> None:
    parts = covered() | {"cage": cage()}
    lifted = plan(parts, keep="base")
    assert left(lifted) == [["cage"], *ON_IT]
    slid = plan(parts, keep=["base", "cage"])
    assert sorted(left(slid)) == [["bolt"], ["cover"], ["screw"]]
    assert slid.seconds > lifted.seconds and slid.bound == pytest.approx(slid.seconds)


def test_what_holds_a_bracket_elsewhere_is_undone_where_that_is_quicker() -> None:
    """A strap from the cover to the base: of its two screws that in the base is the quicker one here."""
    foot = 0.01 + 2 * GAP
    strap = joined(
        plate(((0.02, -0.01, foot), (0.048, 0.01, foot + 0.004)), (0.03, 0.0)),
        box((0.048, -0.01, foot), (0.058, 0.01, foot + 0.004)),
    )
    parts = covered() | {"bracket": strap, "post": box((0.052, -0.008, GAP), (0.058, 0.008, 0.01))}
    parts["tie"] = bolt(0.054, 0.0, foot + 0.004 + GAP, 0.025)
    for quick, slow in (("tie", "screw"), ("screw", "tie")):
        task = plan(parts, times=feeler.Times(typed={quick: 5.0, slow: 500.0}), keep="base")
        undone = {step.part for step in task.steps if step.verb == "undo"}
        assert task.is_found and quick in undone and slow not in undone
        assert ("bracket" in task.steps[-1].paths) == (quick == "tie")
        assert task.bound == pytest.approx(task.seconds)


def test_what_is_in_the_way_leaves_with_its_bracket() -> None:
    """A lid over the bolt of the cover, with the bracket on the lid."""
    parts = covered()
    del parts["bracket"], parts["screw"]
    top = 0.03
    parts["lid"] = joined(
        plate(((-0.05, -0.04, top), (0.05, 0.04, top + 0.008)), (0.044, 0.035)),
        *(box((-0.05, y, GAP), (0.05, y + 0.006, top)) for y in (-0.04, 0.034)),
    )
    parts["lid_bolt"] = bolt(0.044, 0.035, top + 0.008 + GAP, top + 0.02)
    foot = top + 0.008 + GAP
    parts["bracket"] = plate(((-0.01, -0.01, foot), (0.01, 0.01, foot + 0.004)), (0.0, 0.0))
    parts["screw"] = bolt(0.0, 0.0, foot + 0.004 + GAP, 0.01)
    task = plan(parts, keep="base")
    assert ["bracket", "lid", "screw"] in left(task) and ["cover"] in left(task)
    assert task.bound == pytest.approx(task.seconds)
    alone = plan(parts, ["cover", "bracket"], keep="base")
    assert alone.is_found


@pytest.mark.parametrize(("depth", "is_carrying"), [(0.012, False), (0.1, True)])
def test_what_others_hang_on_carries_little(depth: float, is_carrying: bool) -> None:
    """Nothing larger holds the base: it leaves with the cover on it only if that is small beside it."""
    parts = covered() | {"base": box((-0.052, -0.035, -depth), (0.052, 0.035, 0.0))}
    parts |= {"floor": box((-0.05, -0.03, -0.11), (0.05, 0.03, -0.101))}
    assert ("bolt" in {step.part for step in plan(parts, "base").steps}) == (not is_carrying)
    assert left(plan(parts, "cover")) == ON_IT


def test_nothing_rides_where_nothing_would_be_left() -> None:
    parts = {name: mesh for name, mesh in covered().items() if name in ("cover", "bracket", "screw")}
    task = plan(parts, "cover")
    assert left(task) == [["screw"], ["cover"]]
