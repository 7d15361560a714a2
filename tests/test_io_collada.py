"""COLLADA: primitives, transforms, instances, controllers, partial and damaged files."""

from __future__ import annotations

import itertools
import math
import zipfile
from pathlib import Path

import numpy as np
import pytest
from test_field_scenes import notes, volumes
from test_io_builders import CORNERS, FACES, SOUP, zipped

from feeler import LoadError, Mockup
from feeler.io import load_mockup
from feeler.io.collada import read_collada

VOLUME = 10 * 20 * 30 / 6  # of the tetrahedron
VISIT = '<scene><instance_visual_scene url="#vs"/></scene>'
INPUT = '<input semantic="VERTEX" source="#{0}-v" offset="0"/>'


def row(values: object) -> str:
    return " ".join(repr(v) for v in np.asarray(values).ravel().tolist())


def source(name: str, points: np.ndarray = CORNERS, params: str = "XYZ") -> str:
    named = "".join(f'<param name="{p}" type="float"/>' if p != "-" else '<param type="float"/>' for p in params)
    width = points.shape[1]
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{points.size}">{row(points)}</float_array>'
        f'<technique_common><accessor source="#{name}-a" count="{len(points)}" stride="{width}">{named}</accessor>'
        "</technique_common></source>"
    )


def geometry(name: str = "g", primitives: str | None = None, points: np.ndarray = CORNERS, params: str = "XYZ") -> str:
    if primitives is None:
        primitives = f'<triangles count="4">{INPUT.format(name)}<p>{row(FACES)}</p></triangles>'
    return (
        f'<geometry id="{name}" name="{name}"><mesh>{source(name + "-s", points, params)}'
        f'<vertices id="{name}-v"><input semantic="POSITION" source="#{name}-s"/></vertices>{primitives}'
        "</mesh></geometry>"
    )


def scene(inner: str) -> str:
    return f'<library_visual_scenes><visual_scene id="vs">{inner}</visual_scene></library_visual_scenes>{VISIT}'


def node(inner: str = '<instance_geometry url="#g"/>', name: str = "n") -> str:
    return f'<node id="{name}" name="{name}">{inner}</node>'


def dae(body: str, geometries: str = "", asset: str = '<unit name="metre" meter="1"/>') -> str:
    library = f"<library_geometries>{geometries or geometry()}</library_geometries>"
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f"<asset>{asset}</asset>{library}{body}</COLLADA>"
    )


def save(folder: Path, text: str) -> Path:
    path = folder / "m.dae"
    path.write_text(text)
    return path


def load(folder: Path, text: str) -> Mockup:
    return load_mockup(save(folder, text))


def soup(mockup: Mockup) -> np.ndarray:
    return mockup.vertices[mockup.faces]


def area(mockup: Mockup) -> float:
    corners = soup(mockup)
    return float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    )


# --- transforms and instances --------------------------------------------------------------------------------------

TURN = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def moved(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def sheared() -> np.ndarray:
    matrix = np.eye(4)
    matrix[0, 1] = math.tan(math.radians(30))
    return matrix


@pytest.mark.parametrize(
    ("text", "matrix"),
    [
        ("<translate>1 2 3</translate>", moved(1, 2, 3)),
        ("<rotate>0 0 2 90</rotate>", TURN),
        ("<scale>1 2 3</scale>", np.diag([1.0, 2, 3, 1])),
        (f"<matrix>{row(moved(4, 5, 6) @ TURN)}</matrix>", moved(4, 5, 6) @ TURN),
        ("<translate>1 2 3</translate><rotate>0 0 1 90</rotate>", moved(1, 2, 3) @ TURN),
        ("<rotate>0 0 1 90</rotate><translate>1 2 3</translate>", TURN @ moved(1, 2, 3)),
        ("<scale>2 2 2</scale><translate>1 0 0</translate>", np.diag([2.0, 2, 2, 1]) @ moved(1, 0, 0)),
        # Points move along x, the more the larger their y: the y axis turns by 30 degrees towards x.
        ("<skew>30 0 1 0 1 0 0</skew>", sheared()),
        # From (5, 0, 0) towards the origin: the node's z is +x, its y the world's z, its x the world's y.
        ("<lookat>5 0 0 0 0 0 0 0 1</lookat>", np.array([[0.0, 0, 1, 5], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])),
        ('<extra/><translate sid="t">1 2 3</translate><asset/>', moved(1, 2, 3)),
    ],
)
def test_transforms_in_the_order_of_the_file(tmp_path, text, matrix):
    mockup = load(tmp_path, dae(scene(node(text + '<instance_geometry url="#g"/>'))))
    assert np.allclose(soup(mockup), SOUP @ matrix[:3, :3].T + matrix[:3, 3], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<translate>1 2</translate>", "<translate> should have 3 numbers"),
        ("<translate>1,5 2 3</translate>", "<translate> should have 3 numbers"),
        ("<rotate>0 0 0 90</rotate>", "axis of length zero"),
        ("<matrix>1 2 3</matrix>", "<matrix> should have 16 numbers"),
        (f"<matrix>{row(np.ones(16))}</matrix>", "not an affine transform"),
        ("<skew>95 0 1 0 1 0 0</skew>", "<skew> has an angle"),
        ("<skew>10 0 1 0 0 1 0</skew>", "two axes of one direction"),
        ("<lookat>1 1 1 1 1 1 0 0 1</lookat>", "length zero"),
    ],
)
def test_transforms_that_make_no_sense(tmp_path, text, words):
    with pytest.raises(LoadError, match=words):
        load(tmp_path, dae(scene(node(text + '<instance_geometry url="#g"/>'))))


@pytest.mark.parametrize("twice", [False, True])
def test_mirrored_parts_keep_their_outside(tmp_path, twice):
    inner = node(f'{"<scale>1 -1 1</scale>" if twice else ""}<instance_geometry url="#g"/>', "inner")
    mockup = load(tmp_path, dae(scene(node(f"<scale>-1 1 1</scale>{inner}"))))
    assert volumes(mockup) == pytest.approx([VOLUME])


def test_nested_instances_of_library_nodes(tmp_path):
    """As SketchUp writes components of components: each transform counts once."""
    library = (
        '<library_nodes><node id="pair" name="pair"><translate>0 100 0</translate><instance_node url="#one"/>'
        '<node name="second"><rotate>0 0 1 90</rotate><instance_node url="#one"/></node></node>'
        '<node id="one" name="one"><translate>1 0 0</translate><instance_geometry url="#g"/></node></library_nodes>'
    )
    inner = "<translate>1000 0 0</translate><instance_node url='#pair'/>"
    mockup = load(tmp_path, dae(library + scene(node(inner, "top"))))
    assert [part.path for part in mockup.parts] == ["m/top/pair/one/g", "m/top/pair/second/one/g"]
    turned = np.stack([-SOUP[..., 1], SOUP[..., 0] + 1, SOUP[..., 2]], axis=-1) + np.array([1000, 100, 0])
    expected = {"m/top/pair/one/g": SOUP + np.array([1001, 100, 0]), "m/top/pair/second/one/g": turned}
    for number, part in enumerate(mockup.parts):
        assert np.allclose(soup(mockup)[mockup.part_of_face == number], expected[part.path], atol=1e-12)


@pytest.mark.parametrize("inner", ["<instance_node url='#a'/>", "<node id='b'><instance_node url='#a'/></node>"])
def test_a_node_that_contains_itself(tmp_path, inner):
    with pytest.raises(LoadError, match="the node 'a' contains itself"):
        load(tmp_path, dae(scene(node(f'<instance_geometry url="#g"/>{inner}', "a"))))


def test_library_nodes_that_double_at_every_level(tmp_path, monkeypatch):
    monkeypatch.setattr("feeler.io.collada.MAX_PARTS", 10_000)
    levels = "".join(f"<node id='n{i}'>" + f"<instance_node url='#n{i + 1}'/>" * 2 + "</node>" for i in range(60))
    text = f"<library_nodes>{levels}<node id='n60'/></library_nodes>" + scene(node("<instance_node url='#n0'/>"))
    with pytest.raises(LoadError, match="more than 10,000 nodes"):
        load(tmp_path, dae(text))


def test_uses_of_what_is_missing_are_named(tmp_path):
    inner = (
        '<instance_geometry url="#g"/><instance_geometry url="#gone"/><instance_node url="other.dae#n"/>'
        '<instance_controller url="#lost"/><instance_camera url="#none"/>'
    )
    said = notes(load(tmp_path, dae(scene(node(inner)))))
    assert "1 use of geometries that is not in the file was left out ('#gone')" in said
    assert "1 use of nodes in other files was left out: load those files beside it ('other.dae#n')" in said
    assert "1 use of controllers that is not in the file was left out ('#lost')" in said


def test_geometries_that_nothing_in_the_scene_uses_are_named(tmp_path):
    unused = "<library_nodes><node id='spare'><instance_geometry url='#g'/></node></library_nodes>"
    text = dae(unused + scene(node('<instance_node url="#spare"/>')))
    assert "not in the scene" not in notes(load(tmp_path, text))
    lone = text.replace(
        "<library_geometries>", "<library_geometries><geometry id='lone' name='lone'><mesh/></geometry>", 1
    )
    assert "1 geometry is not in the scene and was left out ('lone')" in notes(load(tmp_path, lone))


# --- units and axes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asset", "unit", "metres", "up"),
    [
        ("", "m", 1.0, "y"),
        ("<up_axis>Z_UP</up_axis>", "m", 1.0, "z"),
        ('<unit name="centimeter" meter="0.01"/><up_axis>X_UP</up_axis>', "centimeter", 0.01, "x"),
        ('<unit meter="2.54e-2"/><up_axis> Y_UP </up_axis>', "unit", 0.0254, "y"),
        ("<up_axis>UPWARDS</up_axis>", "m", 1.0, "y"),
    ],
)
def test_unit_and_up_axis(tmp_path, asset, unit, metres, up):
    """The axes stay as they are in the file."""
    path = save(tmp_path, dae(scene(node()), asset=asset))
    mockup = load_mockup(path)
    assert np.array_equal(soup(mockup), SOUP * metres) and mockup.report.source.unit == unit
    assert read_collada(path).up == up
    assert ("'UPWARDS' is unknown in COLLADA" in notes(mockup)) == ("UPWARDS" in asset)


@pytest.mark.parametrize("metres", ["0,0254", "0", "-1", "nan", "inf", "inch"])
def test_a_unit_that_is_no_length(tmp_path, metres):
    with pytest.raises(LoadError, match="the unit has"):
        load(tmp_path, dae(scene(node()), asset=f'<unit meter="{metres}"/>'))


def test_elements_with_a_unit_of_their_own_are_noted(tmp_path):
    inner = '<asset><unit meter="0.001"/></asset><instance_geometry url="#g"/>'
    assert "states another unit or up axis than the file" in notes(load(tmp_path, dae(scene(node(inner, "odd")))))


# --- primitives ----------------------------------------------------------------------------------------------------

U_SHAPE = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
U_SHAPE = np.insert(U_SHAPE, 2, 0.0, axis=1)
FRAME = np.array(
    [[0, 0], [9, 0], [9, 9], [0, 9], [1, 1], [1, 3], [3, 3], [3, 1], [5, 5], [8, 5], [8, 8], [5, 8]], dtype=float
)
FRAME = np.insert(FRAME, 2, 0.0, axis=1)


@pytest.mark.parametrize(
    ("primitive", "faces"),
    [
        ("<triangles>{i}<p>0 2 1 0 1 3</p></triangles>", [[0, 2, 1], [0, 1, 3]]),
        ("<triangles>{i}<p>0 2 1</p><p>0 1 3</p></triangles>", [[0, 2, 1], [0, 1, 3]]),
        ("<tristrips>{i}<p>0 1 2 3</p><p>3 2 1</p></tristrips>", [[0, 1, 2], [2, 1, 3], [3, 2, 1]]),
        ("<trifans>{i}<p>0 1 2 3</p></trifans>", [[0, 1, 2], [0, 2, 3]]),
        ("<polylist>{i}<vcount>3 3</vcount><p>0 2 1 0 1 3</p></polylist>", [[0, 2, 1], [0, 1, 3]]),
        ("<polygons>{i}<p>0 2 1</p><p>0 1 3</p></polygons>", [[0, 2, 1], [0, 1, 3]]),
    ],
)
def test_primitives(tmp_path, primitive, faces):
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=primitive.format(i=INPUT.format("g")))))
    assert np.array_equal(soup(mockup), CORNERS[faces])


def test_corners_with_several_indices(tmp_path):
    inputs = '<input semantic="NORMAL" source="#x" offset="0"/><input semantic="VERTEX" source="#g-v" offset="2"/>'
    numbers = row(np.stack([FACES * 0 + 7, FACES * 0 + 9, FACES], axis=-1))
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=f"<triangles>{inputs}<p>{numbers}</p></triangles>")))
    assert np.array_equal(soup(mockup), SOUP)


@pytest.mark.parametrize("tag", ["polylist", "polygons"])
def test_hollow_polygons(tmp_path, tag):
    count = "<vcount>8</vcount>" if tag == "polylist" else ""
    primitive = f"<{tag}>{INPUT.format('g')}{count}<p>0 1 2 3 4 5 6 7</p></{tag}>"
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=primitive, points=U_SHAPE)))
    assert mockup.triangle_count == 6 and area(mockup) == pytest.approx(7)
    assert "1 polygon with more than three corners was cut into triangles ('g')" in notes(mockup)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
@pytest.mark.parametrize("holes", [("4 5 6 7",), ("4 7 6 5", "8 9 10 11"), ("8 11 10 9", "4 5 6 7")])
def test_polygons_with_holes(tmp_path, holes, order):
    """Holes may run either way around; the plane may lie in any direction."""
    inner = "".join(f"<h>{hole}</h>" for hole in holes)
    primitive = f"<polygons>{INPUT.format('g')}<ph><p>0 1 2 3</p>{inner}</ph></polygons>"
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=primitive, points=FRAME[:, order])))
    assert area(mockup) == pytest.approx(81 - 4 - (9 if len(holes) == 2 else 0))
    corners = soup(mockup)
    turn = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, order.index(2)]
    assert (turn >= 0).all() or (turn <= 0).all()
    middle = corners.mean(axis=1)[:, [order.index(0), order.index(1)]]
    assert not ((middle > 1) & (middle < 3)).all(axis=1).any()
    assert "1 polygon with holes was cut along a line to each hole" in notes(mockup)


def test_a_ring_of_holes(tmp_path):
    """Twelve round holes in a round plate: the area is what is left."""

    def circle(x: float, y: float, radius: float, count: int) -> np.ndarray:
        angle = np.arange(count) * 2 * np.pi / count
        return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle), 0 * angle], axis=1)

    rings = [circle(0, 0, 10, 40)] + [circle(7 * np.cos(a), 7 * np.sin(a), 1, 16) for a in np.arange(12) * np.pi / 6]
    starts = np.cumsum([0] + [len(r) for r in rings])
    lists = [row(np.arange(a, b)) for a, b in itertools.pairwise(starts)]
    primitive = f"<ph><p>{lists[0]}</p>" + "".join(f"<h>{text}</h>" for text in lists[1:]) + "</ph>"
    primitive = f"<polygons>{INPUT.format('g')}{primitive}</polygons>"
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=primitive, points=np.concatenate(rings))))

    def polygon(radius: float, count: int) -> float:
        return count * radius**2 * math.sin(2 * math.pi / count) / 2

    assert area(mockup) == pytest.approx(polygon(10, 40) - 12 * polygon(1, 16))


def test_lines_thin_polygons_and_spare_indices_are_counted(tmp_path):
    more = (
        f"<lines>{INPUT.format('g')}<p>0 1</p></lines><linestrips>{INPUT.format('g')}<p>0 1 2</p></linestrips>"
        f"<polylist>{INPUT.format('g')}<vcount>2 3</vcount><p>0 1 0 2 1</p></polylist>"
        f"<triangles>{INPUT.format('g')}<p>0 2 1 0</p></triangles><triangles count='0'/>"
    )
    said = notes(load(tmp_path, dae(scene(node()), geometry(primitives=more))))
    assert "1 primitive of lines was left out: only triangles collide ('g')" in said
    assert "1 primitive of line strips was left out: only triangles collide ('g')" in said
    assert "1 polygon with fewer than three corners has no triangle ('g')" in said
    assert "1 index at the end of primitives makes no whole triangle ('g')" in said


def test_notes_of_a_file_without_a_triangle(tmp_path):
    other = '<geometry id="g" name="wire"><spline/></geometry>'
    raw = read_collada(save(tmp_path, dae(scene(node()), other)))
    assert not len(raw.faces)
    assert raw.notes == ["1 geometry of the kind 'spline' was left out: only triangles collide ('wire')"]


@pytest.mark.parametrize(
    ("points", "params"),
    [(np.insert(CORNERS, 3, 9.0, axis=1), "XYZ-"), (np.insert(CORNERS, 0, 9.0, axis=1), "-XYZ"), (CORNERS, "---")],
)
def test_columns_of_a_source(tmp_path, points, params):
    assert np.array_equal(soup(load(tmp_path, dae(scene(node()), geometry(points=points, params=params)))), SOUP)


def test_indices_out_of_range_are_kept(tmp_path):
    primitive = f"<triangles>{INPUT.format('g')}<p>0 1 2 0 1 9 0 -1 2</p></triangles>"
    mockup = load(tmp_path, dae(scene(node()), geometry(primitives=primitive)))
    assert mockup.triangle_count == 3 and mockup.report.defects["index_out_of_range"].first == (1, 2)


def test_numbers_that_are_not_finite_are_kept(tmp_path):
    text = dae(scene(node())).replace("30.0", "1.#QNAN", 1)
    assert load(tmp_path, text).report.defects["non_finite"].count == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("20.0", "20,0", "float_array"),
        ('count="4" stride="3"', 'count="9" stride="3"', "promises 9 points"),
        ('count="4" stride="3"', 'count="x" stride="3"', "whole number"),
        ("#g-s-a", "#nowhere", None),
        ('source="#g-v"', 'source="#nowhere"', "positions that are not in the file"),
        ('semantic="VERTEX"', 'semantic="NORMAL"', "no input for positions"),
        ("<p>0", "<p>zero", "not a whole number"),
        ("</mesh>", "", "XML"),
        ('offset="0"', 'offset="-1"', "whole number"),
    ],
)
def test_damaged_geometry(tmp_path, old, new, words):
    text = dae(scene(node()))
    assert old in text
    text = text.replace(old, new, 1)
    if words is None:
        assert load(tmp_path, text).triangle_count == 4  # the array is in the source, whatever it is called
        return
    with pytest.raises(LoadError, match=words):
        load(tmp_path, text)


# --- controllers ---------------------------------------------------------------------------------------------------


def skin(joints: str = "j0 j1", inverse: np.ndarray | None = None) -> str:
    """The tip (corner 3) follows the second joint, the rest the first; the bind shape is moved by 5 along z."""
    if inverse is None:
        inverse = np.tile(np.eye(4), (2, 1, 1))
    return (
        f'<library_controllers><controller id="c" name="arm"><skin source="#g"><bind_shape_matrix>{row(moved(0, 0, 5))}'
        f'</bind_shape_matrix><source id="js"><Name_array id="jn" count="2">{joints}</Name_array></source>'
        f'<source id="ib"><float_array id="ia" count="32">{row(inverse)}</float_array></source>'
        '<source id="ws"><float_array id="wa" count="2">1 2</float_array></source>'
        '<joints><input semantic="JOINT" source="#js"/><input semantic="INV_BIND_MATRIX" source="#ib"/></joints>'
        '<vertex_weights count="4"><input semantic="JOINT" source="#js" offset="0"/>'
        '<input semantic="WEIGHT" source="#ws" offset="1"/><vcount>1 1 2 1</vcount><v>0 0 0 1 0 0 0 1 1 0</v>'
        "</vertex_weights></skin></controller></library_controllers>"
    )


SKELETON = (
    '<node id="root" name="root"><node sid="j0" id="a"><translate>100 0 0</translate></node>'
    '<node sid="j1" id="b"><translate>0 200 0</translate></node></node>'
)


def test_a_skin_is_placed_by_its_joints(tmp_path):
    inner = (
        '<translate>7000 0 0</translate><instance_controller url="#c"><skeleton>#root</skeleton></instance_controller>'
    )
    mockup = load(tmp_path, dae(skin() + scene(SKELETON + node(inner))))
    placed = CORNERS + np.array([[100, 0, 5]] * 3 + [[0, 200, 5]])
    assert np.allclose(soup(mockup), placed[FACES], atol=1e-12)
    assert "1 skin was placed by its joints as these stand at rest ('arm')" in notes(mockup)


def test_a_skin_without_its_joints_is_in_its_bind_shape(tmp_path):
    inner = '<translate>7000 0 0</translate><instance_controller url="#c"/>'
    mockup = load(tmp_path, dae(skin() + scene(node(inner))))
    assert np.allclose(soup(mockup), SOUP + np.array([7000, 0, 5]), atol=1e-12)
    assert "1 skin was taken in its bind shape" in notes(mockup)


@pytest.mark.parametrize(("method", "factor"), [("", 0.25), ('method="NORMALIZED"', 0.25), ('method="RELATIVE"', 1.0)])
def test_a_morph_at_rest(tmp_path, method, factor):
    morph = (
        f'<library_controllers><controller id="c" name="soft"><morph source="#g" {method}>'
        '<source id="ts"><IDREF_array id="ta" count="1">h</IDREF_array></source>'
        '<source id="ws"><float_array id="wa" count="1">0.75</float_array></source>'
        '<targets><input semantic="MORPH_TARGET" source="#ts"/><input semantic="MORPH_WEIGHT" source="#ws"/></targets>'
        "</morph></controller></library_controllers>"
    )
    text = dae(
        morph + scene(node('<instance_controller url="#c"/>')),
        geometry() + geometry("h", points=CORNERS + 8.0),
    )
    mockup = load(tmp_path, text)
    assert np.allclose(soup(mockup), SOUP * factor + 0.75 * (SOUP + 8), atol=1e-12)
    assert "1 morph was taken at rest, with the weights that the file gives ('soft')" in notes(mockup)


def test_a_controller_without_its_geometry_is_named(tmp_path):
    inner = '<instance_controller url="#c"/><instance_geometry url="#g"/>'
    text = dae(skin().replace('source="#g"', 'source="#gone"') + scene(node(inner)))
    assert "1 controller has no geometry in the file and was left out ('arm')" in notes(load(tmp_path, text))


# --- partial files and archives --------------------------------------------------------------------------------------


def test_partial_files(tmp_path):
    assert "has geometries and no scene" in notes(load(tmp_path, dae("")))
    nodes = f"<library_nodes>{node()}{node(name='o')}</library_nodes>"
    assert load(tmp_path, dae(nodes)).part_count == 2
    no_scene = scene(node()).replace(VISIT, "")
    assert "the first one was taken" in notes(load(tmp_path, dae(no_scene)))


def test_version_1_5_and_no_namespace(tmp_path):
    text = dae(scene(node()))
    for name in ("http://www.collada.org/2008/03/COLLADASchema", ""):
        assert load(tmp_path, text.replace("http://www.collada.org/2005/11/COLLADASchema", name)).triangle_count == 4


def test_references_with_escapes(tmp_path):
    text = dae(scene(node('<instance_geometry url="#a%20b"/>'))).replace('id="g"', 'id="a b"')
    assert load(tmp_path, text).triangle_count == 4


def test_archives(tmp_path):
    manifest = b'<?xml version="1.0"?><dae_root xmlns="x">./sub/right.dae#vs</dae_root>'
    members = {"manifest.xml": manifest, "a.dae": b"<COLLADA/>", "sub/right.dae": dae(scene(node())).encode()}
    path = tmp_path / "m.zae"
    path.write_bytes(zipped(members))
    mockup = load_mockup(path)
    assert mockup.triangle_count == 4 and mockup.report.source.format == "COLLADA" and not notes(mockup)
    path.write_bytes(zipped({"sub/right.dae": members["sub/right.dae"]}))
    assert load_mockup(path).triangle_count == 4
    path.write_bytes(zipped({"readme.txt": b""}))
    with pytest.raises(LoadError, match=r"no \.dae file"):
        load_mockup(path)


def test_archive_bomb(tmp_path):
    path = tmp_path / "m.zae"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m.dae", b" " * (80 * 2**20))
    with pytest.raises(LoadError, match="zip bomb"):
        load_mockup(path)


def test_entities_are_refused(tmp_path):
    text = dae(scene(node())).replace(
        '<?xml version="1.0"?>', '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;">]>'
    )
    with pytest.raises(LoadError, match="document type") as told:
        load(tmp_path, text)
    assert "UTF-8" not in str(told.value), "the encoding is right, and the advice would be wrong"
    path = tmp_path / "wide.dae"
    path.write_bytes(text.replace('version="1.0"?>', 'version="1.0" encoding="utf-16"?>', 1).encode("utf-16"))
    with pytest.raises(LoadError, match="document type"):
        load_mockup(path)


BODIES = {
    "triangles": "<p>0 1 2 0 2 3</p>",
    "polylist": "<vcount>3 3</vcount><p>0 1 2 0 2 3</p>",
    "polygons": "<p>0 1 2</p><p>0 2 3</p>",
    "tristrips": "<p>0 1 2 3</p><p>0 1 3</p>",
    "trifans": "<p>0 1 2 3</p><p>0 1 3</p>",
}


@pytest.mark.parametrize("tag", BODIES)
def test_a_count_that_differs_is_a_doubt(tmp_path, tag):
    for count, is_doubtful in (("2", False), ("02", False), ("", False), ("1", True), ("3", True), ("9" * 5000, True)):
        text = f'<{tag} count="{count}">{INPUT.format("g")}{BODIES[tag]}</{tag}>'
        mockup = load(tmp_path, dae(scene(node('<instance_geometry url="#g"/>')), geometry("g", text)))
        assert len(mockup.faces) >= 2
        said = [doubt for doubt in mockup.report.source.doubts if "holds another number of polygons" in doubt]
        assert len(said) == is_doubtful, (count, mockup.report.source.doubts)
