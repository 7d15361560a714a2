"""What objects say of themselves, and the words for values that do not fit."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler

VERTICES = np.array([[0.0, 0, -9], [9, 0, -9], [0, 9, -9]])
FACES = np.array([[0, 1, 2]])
MOCKUP = feeler.Mockup(VERTICES, FACES, part_names=["plate"])
SCENE = feeler.Scene(MOCKUP)
TOOL = feeler.Tool(VERTICES, FACES)


def test_parts_say_how_they_are_looked_up() -> None:
    assert repr(MOCKUP.parts) == "Parts(1: 'plate')"
    with pytest.raises(TypeError, match=r"not by 'plate': parts.find\(path\) looks parts up"):
        MOCKUP.parts["plate"]  # type: ignore[call-overload]
    with pytest.raises(IndexError, match="there is no part 3: there are 1, 0 to 0"):
        MOCKUP.parts[3]
    assert MOCKUP.parts[np.int64(-1)].name == "plate"  # type: ignore[call-overload]


@pytest.mark.parametrize("kind", [int, float, type, str])
def test_a_class_that_takes_no_share_is_no_progress(kind: type) -> None:
    with pytest.raises(feeler.OptionError, match="progress is <class"):
        feeler.Scene(MOCKUP, progress=kind)


def test_pairs_of_arrays_are_parts() -> None:
    made = feeler.Mockup({"a": (VERTICES, FACES), "b": {"c": (VERTICES.tolist(), FACES.tolist())}})
    assert made.part_paths == ("a", "b/c") and made.triangle_count == 2
    assert feeler.Mockup([(VERTICES, FACES)]).part_names == ("part_0",)
    with pytest.raises(feeler.MeshError):
        feeler.Mockup({"a": (VERTICES, FACES, FACES)})


def test_help_names_the_attributes_of_meshes() -> None:
    for kind in (feeler.Mockup, feeler.Tool):
        for name in ("part_names", "part_paths", "part_colours", "source"):
            assert f"`{name}`" in (kind.__doc__ or "")


# Rooms behind the commands and the formats; `types` says what users annotate with.
INSIDE = ("_core", "__main__", "agent", "cli", "io")


def public_dataclasses() -> list[type[Any]]:
    """All dataclasses that `feeler` and its public modules offer."""
    names = ["", *(m.name for m in pkgutil.iter_modules(feeler.__path__) if m.name not in INSIDE)]
    modules = [importlib.import_module(f"feeler.{name}".rstrip(".")) for name in [*names, "samples.accessory"]]
    found = [getattr(module, name) for module in modules for name in getattr(module, "__all__", ())]
    kinds = [kind for kind in found if isinstance(kind, type) and dataclasses.is_dataclass(kind)]
    return list(dict.fromkeys(kinds))


@pytest.mark.parametrize("kind", public_dataclasses(), ids=lambda kind: kind.__name__)
def test_help_names_the_fields_of_a_result(kind: type[Any]) -> None:
    public = [each.name for each in dataclasses.fields(kind) if not each.name.startswith("_")]
    missing = [name for name in public if not re.search(rf"\b{name}\b", kind.__doc__ or "")]
    assert not missing


def test_help_has_the_texts_of_fields_with_shapes_and_units() -> None:
    said = " ".join((feeler.Reach.__doc__ or "").split())
    assert said.startswith("The result for one target; true if it is reachable.")
    assert "pose: `(4, 4)` world_from_tool" in said
    assert "is_found:" in (feeler.Task.__doc__ or ""), "fields of the class that it is made of"


def test_a_tracker_shows_its_tool_and_scene() -> None:
    assert repr(TOOL) in repr(feeler.ContactTracker(SCENE, TOOL))


def test_missing_files_and_folders_are_named_in_words(tmp_path: Path) -> None:
    with pytest.raises(feeler.MissingFileError, match="there is no such file; check the path"):
        feeler.open_scene(tmp_path / "none.feeler")
    with pytest.raises(feeler.WriteError, match="does not exist; make it first"):
        SCENE.save(tmp_path / "none" / "a.feeler")
    zeros = tmp_path / "zeros.feeler"
    zeros.write_bytes(bytes(64))
    with pytest.raises(feeler.LoadError, match=r"saved scenes: \.feeler"):
        feeler.load_mockup(zeros)


def test_a_view_takes_findings_and_poses_and_ends() -> None:
    found = feeler.clash(feeler.Mockup({"a": (VERTICES, FACES), "b": (VERTICES, FACES)}))
    turn, shift = np.eye(3), np.array([0.0, 0.0, 5.0])
    with feeler.view(SCENE, TOOL, browser=False, pose=(turn, shift)) as view:
        assert view.pose[2, 3] == 5.0
        view.place((turn, shift + 1.0))
        view.findings_open(found)
        with pytest.raises(feeler.WorkbenchError, match="hit is None, as from a free cast"):
            view.show_hit(None)  # type: ignore[arg-type]
        with pytest.raises(feeler.WorkbenchError, match="a Distance has no pose"):
            view.show_hit(SCENE.distance(TOOL, np.eye(4)))  # type: ignore[arg-type]
        with pytest.raises(feeler.WorkbenchError, match=r"give findings of feeler\.clash"):
            view.findings_open({})
    with pytest.raises(feeler.WorkbenchError, match="the view is closed"):
        view.hide("plate")


def test_a_view_takes_points_and_indices_as_arrays() -> None:
    corners = np.array([[0, 0, 0], [3, 4, 0]])
    rows = tuple(map(tuple, corners))  # of NumPy's integers
    with feeler.view(SCENE, browser=False) as view:
        for points in (corners, corners.astype(np.float32), list(corners), corners.tolist(), rows):
            view.measure_add("point", points=points)
        number = view.measure_add("angle", triangles=np.array([0, 0], dtype=np.uint32))["id"]
        view.measure_edit(number, "angle", triangles=list(np.array([0, 0])))
        view.section_add(rows[1], 0.0)
        assert [each["value"] for each in view.session.document()["measures"]] == [5.0] * 5 + [0.0]
        for wrong in (corners[0], corners[:1], 3):
            with pytest.raises(feeler.WorkbenchError, match="points"):
                view.measure_add("point", points=wrong)  # type: ignore[arg-type]


def test_answers_that_are_sequences_iterate_index_and_slice() -> None:
    poses = [np.eye(4)] * 3
    chain = feeler.Chain([feeler.Slide((0, 0, 1)), feeler.Slide((0, 1, 0))])
    contacts = SCENE.contacts(TOOL, np.eye(4), within=1.0)
    batches = [SCENE.collide_batch(TOOL, poses), SCENE.distance_batch(TOOL, poses), SCENE.clearance_batch(TOOL, poses)]
    for answer in (chain, contacts, *batches):
        items = [repr(each) for each in answer]
        assert len(items) == len(answer) > 0
        assert [repr(answer[np.int64(i)]) for i in range(len(answer))] == items == [repr(each) for each in answer[:]]
        assert repr(answer[-1]) == items[-1]
        for few in (slice(1, None), slice(None, None, -1), slice(5, 9), slice(0, 3, 2)):
            assert [repr(each) for each in answer[few]] == items[few]
        with pytest.raises(IndexError):
            answer[len(answer)]
        with pytest.raises(IndexError):
            answer[-len(answer) - 1]
        with pytest.raises(TypeError):
            answer["x"]  # type: ignore[index]


def test_a_cast_takes_a_motion_as_its_end() -> None:
    start = np.eye(4)
    start[2, 3] = 5.0
    down = feeler.Slide((0, 0, -9))
    for way in (down, feeler.Screw((1, 0, 0), (0, 0, -9), 3.0), feeler.Chain([down])):
        assert repr(SCENE.cast(TOOL, start, way)) == repr(SCENE.cast(TOOL, start, screw=way))
        with pytest.raises(feeler.OptionError, match="end is a motion, and screw another"):
            SCENE.cast(TOOL, start, way, screw=way)


def test_lengths_in_reprs_have_no_minus_zero_and_few_digits() -> None:
    contacts = SCENE.contacts(TOOL, np.eye(4), within=1.0)
    assert "least gap 0.0 m" in repr(contacts) and "gap 0.0 m" in repr(contacts[0])


def test_a_limit_names_no_saturated_number() -> None:
    with pytest.raises(feeler.LimitError, match=r"more than 2\^64 bytes"):
        feeler.Scene(MOCKUP, voxel_size=1e-12)
