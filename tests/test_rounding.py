"""How far coordinates of files are from those that were meant, and what `clash` makes of it."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import trimesh

import feeler
from feeler.io.rounding import of_numbers

Floats = npt.NDArray[np.float64]
SINGLE_AT_2M = 2.0**-23
"""Half a unit in the last place of single precision, between 2 and 4 m."""


def turn(seed: int) -> Floats:
    return trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3))


def flush_boxes(seed: int, apart: float = 0.0) -> dict[str, trimesh.Trimesh]:
    """Two boxes of 1 m, face on face, at an angle, about 2 m off."""
    parts = {}
    for name, low in (("a", 0.0), ("b", 1.0 + apart)):
        mesh = trimesh.creation.box(bounds=[(low, 0, 0), (low + 1, 1, 1)])
        parts[name] = mesh.apply_transform(turn(seed)).apply_translation((1.9, 0.7, -1.1))
    return parts


def saved(folder: Path, ending: str, parts: dict[str, trimesh.Trimesh]) -> Path:
    if ending == "glb":
        trimesh.Scene(parts).export(folder / "m.glb")
        return folder / "m.glb"
    for name, mesh in parts.items():
        mesh.export(folder / f"{name}.{ending}")
    return folder


@pytest.mark.parametrize("ending", ["glb", "stl", "ply", "obj"])
def test_flush_faces_of_turned_parts_in_files_are_contacts(tmp_path, ending):
    for seed in range(4):
        folder = tmp_path / str(seed)
        folder.mkdir()
        mockup = feeler.load_mockup(saved(folder, ending, flush_boxes(seed)), unit=None if ending == "glb" else "m")
        found = feeler.clash(mockup, clearance=0.001)
        assert [row.verdict for row in found] == ["contact"], (seed, found[0])
        assert 0.0 < mockup.source.rounding <= SINGLE_AT_2M


def test_more_than_the_rounding_is_a_clash_or_a_gap(tmp_path):
    for apart, verdict in ((-1e-5, "clash"), (1e-5, "clearance")):
        folder = tmp_path / verdict
        folder.mkdir()
        mockup = feeler.load_mockup(saved(folder, "glb", flush_boxes(1, apart)))
        assert [row.verdict for row in feeler.clash(mockup, clearance=0.001)] == [verdict]


def test_rules_on_saved_findings_know_the_rounding(tmp_path):
    mockup = feeler.load_mockup(saved(tmp_path, "glb", flush_boxes(2)))
    found = feeler.clash(mockup, clearance=0.001)
    rules = {"rule": [{"name": "no contact", "a": "*a", "contact": 0.0}]}
    assert [row.verdict for row in found.with_rules(rules)] == ["contact"]
    found.save(tmp_path / "last.json")
    kept = feeler.load_clashes(tmp_path / "last.json")
    assert kept.facts.least_contact == found.facts.least_contact == pytest.approx(4 * mockup.source.rounding)
    assert [row.verdict for row in kept.with_rules(rules)] == ["contact"]


def test_arrays_are_in_double_precision():
    mockup = feeler.Mockup(flush_boxes(3))
    assert mockup.source.rounding == 0.0 and feeler.clash(mockup).facts.least_contact == 0.0


def test_saved_scenes_keep_it(tmp_path):
    mockup = feeler.load_mockup(saved(tmp_path, "glb", flush_boxes(4)))
    feeler.Scene(mockup).save(tmp_path / "m.feeler")
    assert feeler.open_scene(tmp_path / "m.feeler").mockup.source.rounding == mockup.source.rounding > 0.0


def test_units_and_nodes_scale_it(tmp_path):
    parts = flush_boxes(5)
    saved(tmp_path, "stl", parts)
    metres, millimetres = (feeler.load_mockup(tmp_path, unit=unit).source.rounding for unit in ("m", "mm"))
    assert millimetres == pytest.approx(metres / 1000)
    path = saved(tmp_path, "glb", parts)
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    for node in document["nodes"]:
        if "mesh" in node:
            node["scale"] = [0.001, 0.001, 0.001]
            node.pop("matrix", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest)) + struct.pack("<II", len(text), 0x4E4F534A)
    plain = feeler.load_mockup(path).source.rounding
    path.write_bytes(head + text + rest)
    assert feeler.load_mockup(path).source.rounding == pytest.approx(plain / 1000)


def as_text(points: Floats, form: str) -> Floats:
    """The numbers as a file in this form has them."""
    return np.array([[float(form % x) for x in row] for row in points[:5_000]])


def test_numbers_tell_their_digits():
    rng = np.random.default_rng(0)
    points = rng.uniform(-9, 9, (300_000, 3))
    points[0, 0] = 9.5  # so that the largest is in the same binade for all
    assert of_numbers(points) == 0.0
    assert of_numbers(points.astype(np.float32).astype(float)) == 2.0**-21
    for decimals in (5, 6, 8, 12):
        assert of_numbers(np.round(points, decimals)) == pytest.approx(0.5 * 10.0**-decimals)
        assert of_numbers(as_text(points, f"%.{decimals}e")) == pytest.approx(0.5 * 10.0**-decimals)
        assert of_numbers(100.0 * as_text(points, f"%.{decimals}e")) == pytest.approx(50.0 * 10.0**-decimals)
        assert of_numbers(as_text(points, f"%.{decimals + 1}g")) == pytest.approx(0.5 * 10.0**-decimals)
    assert of_numbers(np.round(points, 3)) == 0.0  # of so few digits they are exact
    # Whole numbers: cut where longer ones end with zeros and shorter ones do not, and exact otherwise.
    far = as_text(1e4 * points + [948_486.0, -1_045_820.0, 853_576.0], "%.6g")
    assert of_numbers(far) == 5.0 and of_numbers(far.round(-1)) == of_numbers(far + 1.0) == 2.0**-4
    last = points.astype(np.float32).astype(float)
    last[-1, -1] = 0.1  # one number of double precision
    assert of_numbers(last) == 0.0
    assert of_numbers(np.zeros((0, 3))) >= 0.0
    assert of_numbers(np.array([[np.nan, np.inf, 0.1]])) == 0.0
    assert np.isfinite(of_numbers(np.array([[1e300, 0.0, 0.0]])))
