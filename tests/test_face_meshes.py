"""Meshes as users hand them over: names with levels, units of several objects, names of tools, paths that are none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from shapes import box

import feeler

BOX = box((0, 0, 0), (1, 1, 1))
TOOL = feeler.Tool(*BOX)
MOCKUP = feeler.Mockup(*BOX)


class Mesh:
    """A mesh of another library."""

    def __init__(self, units: str | None = None) -> None:
        self.vertices, self.faces = (np.asarray(each) for each in BOX)
        self.units = units


def test_a_name_with_a_slash_is_a_path_in_an_assembly() -> None:
    mockup = feeler.Mockup({"a": BOX, "b/c": BOX})
    assert mockup.part_paths == ("a", "b/c") and mockup.part_names == ("a", "c")
    assert [part.path for part in mockup.parts.find("b")] == ["b/c"]
    nested = feeler.Mockup({"b": {"c": TOOL}, "b/c": BOX, "b/d/": BOX, "/": BOX})
    assert nested.part_paths == ("b/c", "b/c#2", "b/d", "_")


def sizes(given: feeler.types.MeshSource, unit: feeler.types.UnitName | None = None) -> list[float]:
    bounds = feeler.Mockup(given, unit=unit).part_bounds.reshape(-1, 2, 3)
    return [round(float(size), 9) for size in (bounds[:, 1] - bounds[:, 0])[:, 0]]


def test_mockups_tools_and_pairs_are_in_metres_beside_objects_of_any_unit() -> None:
    ours = {"tool": TOOL, "mockup": MOCKUP, "pair": BOX}
    assert sizes({**ours, "mesh": Mesh()}) == [1.0, 1.0, 1.0, 1.0]
    assert sizes({**ours, "mesh": Mesh("mm")}) == [1.0, 1.0, 1.0, 0.001]
    assert sizes({**ours, "mesh": Mesh()}, unit="mm") == [1.0, 1.0, 1.0, 0.001]
    assert sizes({**ours, "mesh": Mesh("mm")}, unit="in") == [1.0, 1.0, 1.0, 0.0254]
    with pytest.raises(feeler.MeshError, match="different units"):
        sizes([Mesh(), Mesh("mm")])


@pytest.mark.parametrize("given", [TOOL, MOCKUP, [TOOL], {"a": BOX}])
def test_a_unit_for_what_is_in_metres_is_refused(given: feeler.types.MeshSource) -> None:
    for make in (feeler.Mockup, feeler.Tool):
        with pytest.raises(feeler.OptionError, match=r"unit is 'mm'.*are in metres, so scale the vertices"):
            make(given, unit="mm")
    assert sizes(given) == [1.0]


def test_the_name_of_a_tool_is_text() -> None:
    tool = feeler.Tool(*BOX, "a")
    tool.name = "b"
    for wrong in (3, None, "\ud800"):
        with pytest.raises(feeler.OptionError, match="name is"):
            tool.name = wrong  # type: ignore[assignment]
    assert tool.name == "b"


def test_a_truth_is_no_number_of_a_part() -> None:
    with pytest.raises(TypeError, match="indexed by its number, not by True"):
        _ = MOCKUP.parts[True]


def test_a_session_ends_with_its_block() -> None:
    away = np.eye(4)
    away[2, 3] = 3.0
    with feeler.haptics.Session(feeler.Scene(MOCKUP), TOOL) as session:
        session.start(away)
        session.run(feeler.haptics.devices.Simulated(), realtime=False)
        assert session.is_running
    assert not session.is_running and session.stop() is not None


LOADERS: dict[str, Callable[[], object]] = {
    "load_mockup": lambda: feeler.load_mockup(None),  # type: ignore[arg-type]
    "load_tool": lambda: feeler.load_tool(None),  # type: ignore[arg-type]
    "open_scene": lambda: feeler.open_scene(None),  # type: ignore[arg-type]
    "open_project": lambda: feeler.open_project(None),  # type: ignore[arg-type]
    "from_urdf": lambda: feeler.from_urdf(None),  # type: ignore[arg-type]
    "load_tracks": lambda: feeler.load_tracks(None),  # type: ignore[arg-type]
    "load_clashes": lambda: feeler.load_clashes(None),  # type: ignore[arg-type]
    "load_maintenance": lambda: feeler.load_maintenance(None),  # type: ignore[arg-type]
    "Times.load": lambda: feeler.Times.load(None),  # type: ignore[arg-type]
    "read_bcf": lambda: feeler.clashes.read_bcf(None),  # type: ignore[arg-type]
    "replay": lambda: feeler.haptics.replay(None),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("name", LOADERS)
def test_loaders_refuse_what_is_no_path_as_an_argument(name: str) -> None:
    with pytest.raises(feeler.OptionError, match="path"):
        LOADERS[name]()
