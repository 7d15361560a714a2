"""The rounding of placements: of parts far from the origin of the sub-assembly that brings them back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from loading import save
from shapes import box
from test_io_3mf import item, model
from test_io_builders import Gltf, zipped
from test_io_collada import INPUT, dae, geometry, node, scene
from test_io_collada import row as numbers_of

import feeler
from feeler.io import load_mockup
from feeler.io.rounding import errors_of, of_numbers

Floats = npt.NDArray[np.float64]
CORNERS, FACES = box((0.0, 0.0, 0.0), (0.05, 0.035, 0.025))


def matrix_of(quaternion: Floats) -> Floats:
    """Of a quaternion x, y, z, w of length 1."""
    (x, y, z), w = quaternion[:3], quaternion[3]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross


def product(one: Floats, other: Floats) -> Floats:
    turned = one[3] * other[:3] + other[3] * one[:3] + np.cross(one[:3], other[:3])
    return np.append(turned, one[3] * other[3] - one[:3] @ other[:3])


def placed(turn: Floats, move: Floats, how: str) -> dict[str, Any]:
    """A node with numbers of single precision: as doubles have them, or as they are printed."""
    if how == "matrix":
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = matrix_of(turn), move
        return {"matrix": matrix.T.astype(np.float32).ravel().tolist()}
    text = [[float(str(number)) for number in row.astype(np.float32)] for row in (turn, move)]
    return {"rotation": text[0], "translation": text[1]}


def nested(folder: Path, lever: float, how: str, seed: int) -> tuple[feeler.Mockup, float]:
    """A box, its copy through a sub-assembly far from its own origin, and a box on it; how far the copies differ."""
    rng = np.random.default_rng(seed)
    turn, below, away = (row / np.linalg.norm(row) for row in (*rng.normal(size=(2, 4)), rng.normal(size=3)))
    move, away = rng.normal(size=3) * 0.1, away * lever
    above = product(turn, below * [-1.0, -1.0, -1.0, 1.0])
    file = Gltf()
    whole = matrix_of(turn)
    meshes = [CORNERS, CORNERS @ whole.T + move, (CORNERS + np.array([0.0, 0.0, 0.025])) @ whole.T + move]
    numbers = [file.mesh(corners, FACES) for corners in meshes]
    file.node(mesh=numbers[1], name="baked")
    inner = file.node(False, mesh=numbers[0], name="nested", **placed(below, away, how))
    file.node(children=[inner], name="sub", **placed(above, move - matrix_of(above) @ away, how))
    file.node(mesh=numbers[2], name="top")
    mockup = load_mockup(save(folder, "nested.glb", file.glb()))
    one, other = (mockup.vertices[mockup.faces[mockup.part_of_face == part]] for part in (0, 1))
    return mockup, float(np.abs(one - other).max())


@pytest.mark.parametrize("how", ["matrix", "quaternion"])
@pytest.mark.parametrize("lever", [0.3, 3.0, 10.0])
def test_copies_and_flush_parts_are_such_however_they_are_placed(tmp_path: Path, lever: float, how: str) -> None:
    for seed in range(12):
        mockup, off = nested(tmp_path, lever, how, seed)
        assert off <= 2.0 * mockup.source.rounding < 4e-7 * (1.0 + lever)
        verdicts = {
            frozenset((row.path_a.split("/")[-1], row.path_b.split("/")[-1])): row.verdict
            for row in feeler.clash(mockup, clearance=1e-3)
        }
        assert verdicts[frozenset(("baked", "nested"))] == feeler.Verdict.DUPLICATE, seed
        assert verdicts[frozenset(("nested", "top"))] == feeler.Verdict.CONTACT, seed


def test_places_of_round_numbers_are_exact(tmp_path: Path) -> None:
    file = Gltf()
    mesh = file.mesh(CORNERS, FACES)
    inner = file.node(False, mesh=mesh, translation=[12.5, -3.0, 0.125], rotation=[0, 0, 0, 1])
    file.node(children=[inner], matrix=[0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 100, 0, 0, 1])
    alone = Gltf()
    alone.node(mesh=alone.mesh(CORNERS, FACES))
    roundings = [load_mockup(save(tmp_path, "a.glb", each.glb())).source.rounding for each in (file, alone)]
    assert roundings[0] == roundings[1] > 0.0


def test_each_number_has_its_own_rounding() -> None:
    single = np.float64(np.float32(0.7071068))
    numbers = np.array([0.0, 1.0, -12.5, 1 / 3, np.nan, single, 0.7071068, 0.70710678118])
    errors = errors_of(numbers)
    assert errors[:5].tolist() == [0.0] * 5
    half = 0.5 * float(np.spacing(np.float32(0.7071068)))
    assert errors[5:].tolist() == pytest.approx([half, 5e-8, 5e-12])
    # Of single precision in text, which has 8 digits where 7 do not suffice; else decimals.
    assert errors_of(np.array([0.70710677, 0.7071066, 0.5])).tolist() == [half, half, 0.0]
    assert errors_of(np.array([0.12345679, 1.2345678, 1.2345671])).tolist() == pytest.approx([5e-9, 5e-8, 5e-8])


def test_single_precision_in_text_is_known_by_its_numbers() -> None:
    rng = np.random.default_rng(0)
    single = rng.uniform(-2.0, 2.0, (200, 3)).astype(np.float32)
    truth = of_numbers(single.astype(np.float64))
    for text in ([[f"{x:.9g}" for x in row] for row in single], [[str(x) for x in row] for row in single]):
        assert of_numbers(np.array(text, dtype=np.float64)) == truth
    decimals = np.round(rng.uniform(-2.0, 2.0, (200, 3)), 8)
    assert of_numbers(decimals) == pytest.approx(5e-9)


UNIT, SIDES = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))


def turn_of(*quaternion: float) -> Floats:
    return matrix_of(np.array(quaternion) / np.linalg.norm(quaternion))


TURNED = turn_of(0.28, 0.64, -0.17, 0.69)
PLACES = {
    "none": (np.eye(3), np.zeros(3)),
    "moved": (np.eye(3), np.array([1.0, 2.0, 3.0])),
    "turned": (turn_of(-0.5, 0.1, 0.3, 0.8), np.zeros(3)),
}
"""Of nodes, in 17 digits: they have no rounding of their own."""


def collada(cubes: list[Floats], place: str) -> bytes:
    turn, move = PLACES[place]
    matrix = np.vstack([np.column_stack([turn, move]), [0.0, 0.0, 0.0, 1.0]])
    own = "" if place == "none" else f"<matrix>{numbers_of(matrix)}</matrix>"
    uses = [node(f'{own}<instance_geometry url="#g{n}"/>', f"n{n}") for n in range(len(cubes))]
    faces = f"<p>{numbers_of(SIDES)}</p>"
    shapes = [
        geometry(f"g{n}", f'<triangles count="12">{INPUT.format(f"g{n}")}{faces}</triangles>', cube)
        for n, cube in enumerate(cubes)
    ]
    return dae(scene("".join(uses)), "".join(shapes)).encode()


def threemf(cubes: list[Floats], place: str) -> bytes:
    turn, move = PLACES[place]
    own = "" if place == "none" else numbers_of(np.concatenate([turn.T.ravel(), move]))
    objects = []
    for n, cube in enumerate(cubes):
        vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in cube.tolist())
        triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in SIDES.tolist())
        mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
        objects.append(f'<object id="{n + 1}">{mesh}</object>')
    items = "".join(item(n + 1, own) for n in range(len(cubes)))
    return zipped({"3D/3dmodel.model": model("".join(objects), items)})


@pytest.mark.parametrize("place", list(PLACES))
@pytest.mark.parametrize(("digits", "rounding"), [("%.6f", 5e-7), ("%.9g", 5e-9), ("%.6g", 5e-6)])
@pytest.mark.parametrize(("make", "metre"), [(collada, 1.0), (threemf, 1e-3)])
def test_text_has_its_rounding_however_a_node_places_it(
    tmp_path: Path, make: Any, metre: float, digits: str, rounding: float, place: str
) -> None:
    """The numbers of a turned part have all digits: those of its file count."""
    exact = [(UNIT + step) @ TURNED.T for step in ([0.0, 0.0, 0.0], [1.0, 0.25, 0.125], [0.0, 0.0, 0.0])]
    exact[2] = exact[2] + [3.0, 0.0, 0.0]
    cubes = [np.array([[float(digits % number) for number in point] for point in cube]) for cube in exact]
    mockup = load_mockup(save(tmp_path, "cubes.dae" if make is collada else "cubes.3mf", make(cubes, place)))
    assert mockup.source.rounding == pytest.approx(rounding * metre, rel=1e-3)
    assert [each.verdict for each in feeler.clash(mockup, clearance=0.0)] == [feeler.Verdict.CONTACT]


@pytest.mark.parametrize("turn", ["0 0 0 0", "0 0 1 0", "nan 0 0 0"])
def test_turns_by_nothing_have_no_rounding(tmp_path: Path, turn: str) -> None:
    inner = f'<rotate>{turn}</rotate><instance_geometry url="#g0"/>'
    text = collada([UNIT], "none").decode().replace('<instance_geometry url="#g0"/>', inner)
    assert load_mockup(save(tmp_path, "unit.dae", text.encode())).source.rounding == of_numbers(UNIT)


@pytest.mark.parametrize("angle", ["30.123456", "33.5"])
def test_turns_of_few_digits_have_their_rounding(tmp_path: Path, angle: str) -> None:
    """An angle of eight digits is off by half a unit in the last one; 33.5 degrees are meant as they are."""
    far = UNIT + np.array([10.0, 0.0, 0.0])
    turn = f'<rotate>0 0 1 {angle}</rotate><instance_geometry url="#g0"/>'
    text = collada([far], "none").decode().replace('<instance_geometry url="#g0"/>', turn)
    off = np.radians(5e-7) * np.linalg.norm([10.5, 0.5, 0.5]) if angle == "30.123456" else 0.0
    own = of_numbers(far)
    assert load_mockup(save(tmp_path, "far.dae", text.encode())).source.rounding == pytest.approx(own + off, rel=1e-6)
