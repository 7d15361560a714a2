"""Names of early builds answer with what they are called now: those of the tables in CHANGELOG.md."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of
from shapes import box
from workbench_scene import Bench, cube

import feeler
from feeler.workbench.scripting import View


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    lower, upper = box((0, 0, 0), (1, 1, 1)), box((0, 0, 2), (1, 1, 3))
    faces = np.concatenate([lower[1], np.asarray(upper[1]) + 8])
    return feeler.Scene(feeler.Mockup(np.concatenate([lower[0], upper[0]]), faces, np.repeat([0, 1], 12), ["a", "b"]))


TOOL = feeler.Tool(*box((0, 0, 0), (0.2, 0.2, 0.2)))
POSE = np.eye(4)
AWAY = np.eye(4)
AWAY[2, 3] = 5.0
LEG = feeler.RemovalLeg(None, AWAY, 5.0, 0.0, (0.0, 0.0, 1.0))

MOVED: dict[str, Callable[[Any], object]] = {
    "Scene.distance_batch(max=) is now within=": lambda s: s.distance_batch(TOOL, [AWAY], max=9.0),
    "Scene.rays(max=) is now within=": lambda s: s.rays([[0.5, 0.5, 9]], [[0, 0, -1.0]], max=9.0),
    "Scene.contacts(margin=) is now within=": lambda s: s.contacts(TOOL, AWAY, margin=0.01),
    "ContactTracker.contacts(margin=) is now within=": (
        lambda s: feeler.ContactTracker(s, TOOL).contacts(AWAY, margin=0.01)
    ),
    "Holds.to_dict is now Holds.to_dicts": lambda s: feeler.holds(s).to_dict(),  # type: ignore[attr-defined]
    "Sight.to_dict is now Sight.to_dicts": lambda s: feeler.sight(s, "b", [[9, 9, 9]]).to_dict(),  # type: ignore[attr-defined]
    "RemovalLeg.as_json is now RemovalLeg.to_dict": lambda s: LEG.as_json(),  # type: ignore[attr-defined]
    "Scene.penetration(margin=) is now within=": lambda s: s.penetration(TOOL, POSE, margin=0.01),
    "clash(exclude=) is now ignore=": lambda s: feeler.clash(s.mockup, exclude=[("a", "b")]),
    "removal_order(part=) is now parts=": lambda s: feeler.removal_order(s, part="b"),
    "access(swing=) is now swing_deg=": lambda s: feeler.access(s, TOOL, AWAY[None], swing=10.0, angles=4),
    "Session.start(pose=) is now world_from_tool=": lambda s: feeler.haptics.Session(s, TOOL).start(pose=AWAY),
    "Removal.found is now Removal.is_found": lambda s: feeler.removal(s, "b").found,
    "RemovalOrder.found is now RemovalOrder.is_found": lambda s: feeler.removal_order(s, "b").found,
    "Reach.swing is now Reach.swing_deg": lambda s: feeler.access(s, TOOL, AWAY[None], angles=4)[0].swing,
    "Reach.reachable is now Reach.is_reachable": lambda s: feeler.access(s, TOOL, AWAY[None], angles=4)[0].reachable,
    "Access.angle is now Access.angles_deg": lambda s: feeler.access(s, TOOL, AWAY[None], angles=4).angle,
    "Clashes.verdict is now Clashes.verdicts": lambda s: feeler.clash(s.mockup).verdict,
    "Clashes.a is now Clashes.parts_a": lambda s: feeler.clash(s.mockup).a,
    "PathCheck.free is now PathCheck.is_free": lambda s: s.check_path(TOOL, [AWAY]).free,
    "ClearanceAlong.share is now ClearanceAlong.fraction": lambda s: s.clearance_along(TOOL, AWAY, AWAY).share,
    "ClearanceAlong.shares is now ClearanceAlong.fractions": lambda s: s.clearance_along(TOOL, AWAY, AWAY).shares,
    "PathCheck.fraction is now PathCheck.fractions": lambda s: s.check_path(TOOL, [AWAY]).fraction,
}


@pytest.mark.parametrize("said", list(MOVED))
def test_old_names_answer_and_say_the_new_one(said: str, scene: feeler.Scene) -> None:
    with pytest.warns(DeprecationWarning, match=re.escape(said)) as warned:
        assert MOVED[said](scene) is not None
    assert [each.filename for each in warned if said in str(each.message)] == [__file__]


GONE: dict[str, tuple[type[Exception], Callable[[Any], object]]] = {
    "removal(allow=) is gone: pass ignore=": (feeler.OptionError, lambda s: feeler.removal(s, "b", allow="start")),
    "removal_order(allow=) is gone": (feeler.OptionError, lambda s: feeler.removal_order(s, "b", allow=None)),
    "insertion(allow=) is gone": (feeler.OptionError, lambda s: feeler.insertion(s, "b", allow=0.001)),
    "read is_found": (AttributeError, lambda s: feeler.removal(s, "b").free),
    "within=, which is given too": (feeler.OptionError, lambda s: s.distance_batch(TOOL, [AWAY], within=1.0, max=1.0)),
}


@pytest.mark.parametrize("said", list(GONE))
def test_old_names_that_are_gone_say_what_to_do(said: str, scene: feeler.Scene) -> None:
    error, call = GONE[said]
    with pytest.raises(error, match=re.escape(said)):
        call(scene)


def test_unknown_names_are_what_they_are_in_python(scene: feeler.Scene) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'nearness'"):
        scene.distance(TOOL, AWAY, nearness=1.0)  # type: ignore[call-arg]
    found = feeler.removal(scene, "b")
    with pytest.raises(AttributeError, match="'Removal' object has no attribute 'leg'"):
        _ = found.leg  # type: ignore[attr-defined]
    assert list(inspect.signature(scene.distance).parameters) == ["tool", "world_from_tool", "within", "ignore"]
    for there in (copy.copy(found), pickle.loads(pickle.dumps(found))):
        assert there.is_found and repr(there) == repr(found)


def test_a_hit_is_shown_by_show_hit(scene: feeler.Scene) -> None:
    class Nobody:
        url = ""

        def close(self) -> None: ...

    with (
        View(Bench(cube()).session, Nobody()) as view,
        pytest.raises(feeler.WorkbenchError, match=r"call show_hit\(hit\)"),
    ):
        view.show(scene.collide(TOOL, POSE))  # type: ignore[arg-type]


def test_the_old_option_of_remove(testdata: Path) -> None:
    said = error_of("remove", "sample:gearbox", "--part", "*bolt*", "--allow", "start")
    assert "--allow is gone: give --ignore PATTERN, --overlap METRES, or --no-seats" in said
